//! x
use nonsmooth::laws::{ContactLaw, Fremond, NewtonCoulomb};
use nonsmooth::scheme::*;
use nonsmooth::solver::*;
use nonsmooth::system::*;
fn main() {
    for law in ["newton", "fremond"] {
        let mut b = RigidBodies::<f64>::builder();
        let s = b.body("stick", Body { mass: 1.0, inertia: 1.0 / 12.0 }).unwrap();
        b.gravity([0.0, -10.0]).unwrap();
        let (g1, g2) = (b.group(), b.group());
        b.disc("tip", s, [0.0, -0.5], 0.0, g1).unwrap();
        b.half_plane("floor", [0.0, 0.0], [0.0, 1.0], g2).unwrap();
        b.interface(g1, g2).unwrap();
        let sys = b.build().unwrap();
        let law: Box<dyn ContactLaw<f64, 2>> = if law == "newton" {
            Box::new(NewtonCoulomb::new(1.0, 0.01).unwrap())
        } else {
            Box::new(Fremond::new(1.0, 0.01).unwrap())
        };
        let q0 = vec![2f64.sqrt() / 4.0, 2f64.sqrt() / 4.0 + 0.01, std::f64::consts::FRAC_PI_4];
        let v0 = vec![-0.5, 0.1, 0.1];
        let solver = Nsgs::<f64, 2>::new(NsgsSettings::default());
        let mut sch =
            ThetaScheme::new(sys, vec![law], solver, Settings::new(0.5, 1e-4), 0.0, q0.clone(), v0.clone())
                .unwrap();
        let mut worst = 0f64;
        for k in 1..=2000 {
            let st = sch.step().unwrap();
            worst = worst.max(st.balance.imbalance.abs());
            for c in &st.contacts {
                println!(
                    "{k} {:?} {:?} {:?} {:e} {:e}",
                    c.before.as_slice(),
                    c.after.as_slice(),
                    c.percussion.as_slice(),
                    c.normal_work,
                    c.tangential_work
                );
            }
        }
        println!("{:?} imb {worst:e} E {:?}", sch.state(), sch.last_step().energies);
        let t = std::time::Instant::now();
        let n = 5_000_000;
        for _ in 0..n {
            sch.step().unwrap();
        }
        println!("{} ns/step", t.elapsed().as_nanos() as f64 / n as f64);
    }
}
