//! The sliding block.

mod elastic;

use elastic::*;
use nonsmooth::scheme::ActivationRule;
use nonsmooth::system::{Hypothesis, Support};

#[test]
fn try_it() {
    let Some(mesh) = authors_mesh() else { return };
    for hypothesis in [Hypothesis::PlaneStress, Hypothesis::PlaneStrain] {
        for support in [Support::Fixed] {
            let b = block(mesh.clone(), hypothesis);
            println!("mass {}", b.total_mass());
            let q = b.preload(0.0, support, false).unwrap();
            use nonsmooth::system::MechanicalSystem;
            let k = MechanicalSystem::<f64, 2>::stiffness(&b).unwrap();
            let mut y = q.clone();
            k.multiply(&q, &mut y);
            println!(
                "{hypothesis:?} {support:?} {:.8}",
                0.5 * q.iter().zip(&y).map(|(a, b)| a * b).sum::<f64>()
            );
        }
    }
    for rule in [ActivationRule::CurrentGap, ActivationRule::MoreauJean] {
        for law in ["newton", "fremond"] {
            let mut s = block_scheme(mesh.clone(), Hypothesis::PlaneStress, law, "hybrid", rule);
            let clock = std::time::Instant::now();
            let (mut max_t, mut max_n, mut count, mut diss, mut imb, mut iters) =
                (f64::MIN, f64::MIN, 0, 0.0, 0.0f64, 0);
            for _ in 0..10000 {
                let step = s.step().unwrap();
                let t = step.contacts.iter().map(|c| c.tangential_work).fold(f64::MIN, f64::max);
                let n = step.contacts.iter().map(|c| c.normal_work).fold(f64::MIN, f64::max);
                max_t = max_t.max(t);
                max_n = max_n.max(n);
                count += usize::from(t > 1e-9);
                diss += step.balance.normal_contact_work + step.balance.tangential_contact_work;
                imb = imb.max(step.balance.imbalance.abs());
                iters += step.solution.map_or(0, |s| s.iterations);
            }
            println!(
                "{rule:?} {law} E {} maxT {max_t:e} maxN {max_n:e} steps {count} diss {diss} imb {imb:e} iters {iters} {:.1} µs/step",
                s.last_step().energies.mechanical(),
                clock.elapsed().as_secs_f64() * 100.0
            );
        }
    }
}
