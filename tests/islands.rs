//! Islands: what does not touch is solved apart, and moves as if alone.

use nonsmooth::laws;
use nonsmooth::scheme::{Activation, ActivationRule, Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{RigidBodies, polygon_body};

type Scheme = ThetaScheme<f64, 2>;

/// Pairs of squares, one above the other, each pair far from the next and thrown in its own way.
fn scene(pairs: std::ops::Range<usize>) -> Scheme {
    let mut builder = RigidBodies::builder();
    let (square, floor) = (builder.group(), builder.group());
    let (mut q, mut v) = (Vec::new(), Vec::new());
    let (body, vertices, _) =
        polygon_body(1.0, &[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]).expect("a square");
    for pair in pairs {
        let x = pair as f64;
        for above in [0.0, 1.0] {
            let name = format!("square {pair} {above}");
            let body = builder.body(&name, body).expect("positive");
            builder.polygon(&name, body, &vertices, square).expect("convex");
            q.extend([10.0 * x, 0.6 + 1.05 * above, 0.01 * (x - 4.0)]);
            v.extend([0.1 * x, -0.2 * above, 0.05 * x]);
        }
    }
    builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floor).expect("a plane");
    builder.interface(square, square).expect("a group");
    builder.interface(square, floor).expect("two groups");
    builder.gravity([0.0, -10.0]).expect("finite");
    let laws = (0..2).map(|_| laws::build("fremond", &[0.3, 0.4]).expect("registered")).collect();
    let solver = solver::build(solver::DEFAULT, Stopping::to(1e-12)).expect("registered");
    let activation = Activation::new(ActivationRule::PredictedGap);
    let settings = Settings { activation, ..Settings::new(0.6, 1e-3) };
    ThetaScheme::new(Box::new(builder.build().expect("bodies")), laws, solver, settings, 0.0, q, v)
        .expect("a valid setup")
}

#[test]
fn a_pair_of_squares_does_not_feel_the_others() {
    const PAIRS: usize = 30;
    const STEPS: usize = 400;
    let mut together = scene(0..PAIRS);
    let mut most = 0;
    for _ in 0..STEPS {
        let step = together.step().expect("squares");
        most = most.max(step.contacts.len());
        // What the islands report is measured on the whole problem.
        if let Some(solution) = &step.solution {
            assert!(solution.residual.scaled <= 1e-12, "{solution:?}");
        }
    }
    assert!(most > 16, "enough contacts for the problem to be split: {most}");
    for pair in 0..PAIRS {
        let mut alone = scene(pair..pair + 1);
        for _ in 0..STEPS {
            alone.step().expect("two squares");
        }
        let (q, others) = (&alone.state().q, &together.state().q[6 * pair..6 * pair + 6]);
        let difference = q.iter().zip(others).fold(0.0, |d, (a, b)| f64::max(d, (a - b).abs()));
        // The solver's tolerance, amplified by some impacts.
        assert!(difference <= 1e-9, "pair {pair}: {difference:e}");
    }
}
