//! What a run reports as created energy is what a law created, never what a solver left.

#[path = "mechanics/example.rs"]
#[allow(dead_code)]
mod example;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use nonsmooth::observe::{RunInfo, RunSummary, SummaryRecorder};
use nonsmooth::scene::Scene;
use nonsmooth::simulate::{Ended, Stepper};

fn summary(scene: &Scene, law: &str) -> RunSummary {
    let (scheme, steps) = example::scheme::<f64, 2>(scene, law, "hybrid");
    let info = RunInfo::new(law, "hybrid", vec![law.into()], scheme.settings());
    let mut recorder = SummaryRecorder::default();
    let ended = Stepper::from(scheme).run(steps, &info, &mut [&mut recorder], &AtomicBool::new(false));
    assert!(matches!(ended, Ok(Ended::Completed)), "{law}");
    recorder.finish(None).expect("the run began")
}

/// Five boxes on top of each other, at rest from the start; masses of grams and of tonnes, so that no fixed number of
/// joules tells rounding from work.
fn stack(mass: f64) -> Scene {
    let mut text = String::from(
        "title = \"stack\"\nlaws = [\"newton\"]\ngravity = [0.0, -9.81]\n[time]\nstep = 1e-3\nend = 1.0\ntheta = 0.5\n\
         allow_unproved_theta = true\n",
    );
    for i in 0..5 {
        let y = 0.5 + f64::from(i);
        text += &format!(
            "[[bodies]]\nname = \"b{i}\"\ngroups = [\"box\"]\nmass = {mass:?}\ninertia = {:?}\nposition = [0.0, {y:?}]\n\
             [[bodies.polygons]]\nname = \"p\"\nvertices = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]\n",
            mass / 6.0
        );
    }
    text += "[[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n";
    for pair in ["[\"box\", \"box\"]", "[\"box\", \"floor\"]"] {
        text += &format!(
            "[[interfaces]]\nbetween = {pair}\nparameters = {{ restitution = 0.5, friction = 0.4 }}\n"
        );
    }
    Scene::parse(&text, Path::new("stack.toml")).expect("a scene")
}

#[test]
fn a_stack_at_rest_creates_no_energy() {
    for mass in [1e-3, 1.0, 1e6] {
        for law in ["newton", "fremond"] {
            let run = summary(&stack(mass), law);
            // Contacts work at most by the tolerance, 1e-10, of the velocities the weight makes in a step; there are
            // works to judge, and none is taken for created energy.
            assert!(run.max_normal_work < 1e-8 * mass, "{law}, {mass} kg: {:e} J", run.max_normal_work);
            assert_eq!(
                (run.positive_work_steps, run.tangential_work_steps),
                (0, 0),
                "{law}, {mass} kg: {run:?}"
            );
        }
    }
}

#[test]
fn a_law_that_gains_is_reported_in_the_step_where_it_does() {
    let scene = example::scene("impacting_stick");
    // Newton's law gains 7.08e-4 J in its first impact and loses in the second; Frémond's gains nowhere.
    let newton = summary(&scene, "newton");
    assert_eq!((newton.positive_work_steps, newton.tangential_work_steps), (1, 1));
    assert!(
        (newton.max_tangential_work - 7.077_182_890_524e-4).abs() < 1e-10,
        "{:e}",
        newton.max_tangential_work
    );
    let fremond = summary(&scene, "fremond");
    assert_eq!((fremond.positive_work_steps, fremond.tangential_work_steps), (0, 0));
}
