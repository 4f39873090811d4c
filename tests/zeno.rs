//! The bouncing ball: infinitely many impacts in finite time, then rest.
#![cfg(feature = "scene")]

#[path = "mechanics/regression.rs"]
mod regression;

use std::path::Path;

use nonsmooth::scene::{Run, Scene, build};
use regression::{log_spaced, order};

fn scene() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/bouncing_ball.toml");
    Scene::read(&path).expect("the example is a scene")
}

struct Bounce { times: Vec<f64>, y: f64, ymin: f64, vmax: f64, e: f64 }

fn run(law: &str, h: f64) -> Bounce {
    let mut scene = scene();
    scene.time.step = h;
    let runs = Scene { laws: vec![law.into()], ..scene.clone() }.runs().unwrap();
    let [run] = <[Run; 1]>::try_from(runs).unwrap();
    let mut scheme = build::<f64, 1>(&scene, &run).unwrap();
    let mut b = Bounce { times: vec![], y: 0.0, ymin: 0.0, vmax: 0.0, e: 0.0 };
    let rest = 1.341640786;
    for _ in 0..run.steps {
        let step = scheme.step().unwrap();
        let hit = step.contacts.first().is_some_and(|c| c.percussion[0] > 0.0);
        let s = scheme.state();
        if hit { b.times.push(s.time) }
        if s.time > rest { b.y = b.y.max(s.q[1].abs()); b.ymin = b.ymin.min(s.q[1]); b.vmax = b.vmax.max(s.v[1].abs()); }
    }
    b
}

#[test]
fn measure() {
    for law in ["newton", "fremond"] {
        let hs = log_spaced(1e-5, 1e-2, 13);
        for &h in &hs {
            let b = run(law, h);
            let mut t = 0.2f64.sqrt(); let mut k = t * 2.0 * 0.5;
            let mut errs = vec![];
            for x in b.times.iter().take(6) { errs.push(format!("{:.2}", (x - t) / h)); t += k; k *= 0.5; }
            println!("{law} {h:.2e} n {} err/h {:?} y/h {:.3} ymin/h {:.3} y/h2 {:.3} v/h {:.3}", b.times.len(), errs, b.y / h, b.ymin / h, b.y/h/h, b.vmax / h);
        }
    }
    let _ = order(&[1.0, 2.0], &[1.0, 2.0]);
}
