//! Bodies that move as told: belts, shakers and pistons, and the work of what moves them.
#![cfg(feature = "scene")]

#[path = "mechanics/from_text.rs"]
mod from_text;

use std::f64::consts::PI;

use from_text::{follow, scheme, try_scheme};
use nonsmooth::scheme::ThetaScheme;

const G: f64 = 9.81;

fn head(step: f64, end: f64) -> String {
    format!(
        r#"
        title = "moved"
        laws = ["newton"]
        gravity = [0.0, -{G}]
        [time]
        theta = 0.5
        allow_unproved_theta = true
        step = {step:?}
        end = {end:?}
        "#
    )
}

fn interface(obstacle: &str, mu: f64) -> String {
    format!(
        "[[interfaces]]\nbetween = ['body', '{obstacle}']\nparameters = {{ restitution = 0.0, friction = {mu:?} }}\n"
    )
}

#[test]
fn a_belt_carries_a_block_along_and_half_of_its_work_is_heat() {
    let (mu, speed, mass) = (0.3, 1.2, 2.0);
    let block = r#"
        [[bodies]]
        name = "body"
        mass = 2.0
        inertia = 0.02
        position = [0.0, 0.1]
        polygons = [{ name = "p", vertices = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]] }]
        [[obstacles]]
        name = "belt"
        motion = [{ displacement = [1.2, 0.0], signal = { linear = { rate = 1.0 } } }]
    "#;
    for shape in [
        "half_planes = [{ name = 'top', normal = [0.0, 1.0] }]",
        "polygons = [{ name = 'top', vertices = [[-9.0, -1.0], [9.0, -1.0], [9.0, 0.0], [-9.0, 0.0]] }]",
        "chains = [{ name = 'top', points = [[-9.0, 0.0], [9.0, 0.0]] }]",
    ] {
        let text = head(1e-3, 1.0) + block + shape + "\n" + &interface("belt", mu);
        let (mut driven, mut heat, mut v) = (0.0, 0.0, Vec::new());
        let imbalance = follow::<2>(&text, |scheme| {
            let balance = &scheme.last_step().balance;
            driven += balance.prescribed_work;
            heat += balance.tangential_contact_work;
            v.clone_from(&scheme.state().v);
            let exact = (mu * G * scheme.state().time).min(speed);
            assert!((v[0] - exact).abs() < 1e-9, "{shape}: {} for {exact}", v[0]);
        });
        assert!((driven - mass * speed * speed).abs() < 1e-8, "{shape}: {driven}");
        assert!((heat + 0.5 * mass * speed * speed).abs() < 1e-8, "{shape}: {heat}");
        assert!((v[3] - speed).abs() < 1e-12, "{v:?}");
        assert!(imbalance < 1e3 * f64::EPSILON * 3.0, "{shape}: {imbalance}");
    }
}

#[test]
fn a_block_stands_still_on_a_belt_that_has_caught_it() {
    // Carried from rest to the speed of the belt in v/(μ g) = 0.2 s, pulled by 60 % of what friction can hold.
    let (mu, speed, mass) = (0.5, 1.0, 2.0);
    let block = |law: &str, more: &str| {
        format!(
            r#"
            title = "moved"
            laws = ["{law}"]
            gravity = [0.0, -{G}]
            [time]
            step = 1e-3
            end = 1.0
            [[bodies]]
            name = "body"
            mass = {mass:?}
            inertia = 0.02
            position = [0.0, 0.1]
            {more}
            polygons = [{{ name = "p", vertices = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]] }}]
            [[obstacles]]
            name = "belt"
            motion = [{{ displacement = [{speed:?}, 0.0], signal = {{ linear = {{ rate = 1.0 }} }} }}]
            half_planes = [{{ name = 'top', normal = [0.0, 1.0] }}]
            "#
        ) + &interface("belt", mu)
    };
    for law in ["newton", "fremond", "moreau"] {
        for more in ["", "force = [-5.886, 0.0]\nvelocity = [1.0, 0.0]", "velocity = [1.0, 0.0]"] {
            let (mut worst, mut energy) = (0.0_f64, 0.0_f64);
            let imbalance = follow::<2>(&block(law, more), |scheme| {
                let (state, step) = (scheme.state(), scheme.last_step());
                energy = energy.max(step.energies.total());
                if state.time > 0.25 {
                    let by = [state.v[0] - state.v[3], state.v[1], state.v[2], state.q[1] - 0.1, state.q[2]];
                    worst = by.into_iter().fold(worst, |worst, by| worst.max(by.abs()));
                    assert!(step.contacts.iter().all(|contact| contact.lasting && contact.theta == 1.0));
                }
            });
            assert!(worst < 1e-9, "{law}, {more}: {worst}");
            assert!(imbalance < 1e-12 * energy, "{law}, {more}: {imbalance} of {energy}");
        }
    }
}

#[test]
fn a_stack_rides_up_on_a_belt_that_climbs() {
    // Two blocks on each other, on a belt that climbs at 20°: μ = 0.5 holds them.
    let angle = 20.0_f64.to_radians();
    let (sin, cos) = angle.sin_cos();
    let mut text = head(1e-3, 0.5).replace("newton", "fremond");
    for (name, height) in [("body", 0.1), ("upper", 0.3)] {
        text += &format!(
            "[[bodies]]\nname = '{name}'\ngroups = ['all']\nmass = 1.0\ninertia = 0.02\nangle = {angle:?}\n\
             position = [{:?}, {:?}]\nvelocity = [{:?}, {:?}]\npolygons = [{{ name = 'p', vertices = [[-0.2, -0.1], \
             [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]] }}]\n",
            -height * sin,
            height * cos,
            cos * 0.7,
            sin * 0.7
        );
    }
    text += &format!(
        "[[obstacles]]\nname = 'belt'\ngroups = ['all']\nangle = {angle:?}\nhalf_planes = [{{ name = 'top', normal = [0.0, \
         1.0] }}]\nmotion = [{{ displacement = [{cos:?}, {sin:?}], signal = {{ linear = {{ rate = 0.7 }} }} }}]\n\
         [[interfaces]]\nbetween = ['all', 'all']\nparameters = {{ restitution = 0.3, friction = 0.5 }}\n"
    );
    let mut worst = 0.0_f64;
    let imbalance = follow::<2>(&text, |scheme| {
        let v = &scheme.state().v;
        if scheme.state().time > 0.01 {
            let by = [v[0] - v[6], v[1] - v[7], v[2], v[3] - v[6], v[4] - v[7], v[5]];
            worst = by.into_iter().fold(worst, |worst, by| worst.max(by.abs()));
        }
    });
    assert!(worst < 1e-9, "{worst}");
    assert!(imbalance < 1e-12 * 10.0, "{imbalance}");
}

#[test]
fn bodies_on_belts_that_start_run_and_stop_take_no_energy_from_their_contacts() {
    let table =
        "{ table = { times = [-1.0, 0.2, 0.5, 0.8, 1.0, 9.0], values = [0.0, 0.0, 0.6, 0.6, 0.3, 0.3] } }";
    for (law, e) in [("newton", 0.0), ("fremond", 0.0), ("fremond", 0.6), ("moreau", 0.3)] {
        for signal in [table, "{ sine = { frequency = 2.0 } }", "{ linear = { rate = 1.5 } }"] {
            let mut text = head(1e-3, 1.5)
                .replace("newton", law)
                .replace("theta = 0.5", "")
                .replace("allow_unproved_theta = true", "");
            for (name, x, y) in [("a", 0.0, 0.12), ("b", 0.02, 0.33), ("c", 0.5, 0.2)] {
                text += &format!(
                    "[[bodies]]\nname = '{name}'\ngroups = ['all']\nmass = 1.0\ninertia = 0.01\nposition = [{x:?}, \
                     {y:?}]\npolygons = [{{ name = 'p', vertices = [[-0.15, -0.1], [0.15, -0.1], [0.15, 0.1], \
                     [-0.15, 0.1]] }}]\n"
                );
            }
            text += &format!(
                "[[obstacles]]\nname = 'belt'\ngroups = ['all']\nhalf_planes = [{{ name = 'top', normal = [0.0, 1.0] \
                 }}]\nmotion = [{{ displacement = [1.0, 0.05], signal = {signal} }}]\n[[interfaces]]\n\
                 between = ['all', 'all']\nparameters = {{ restitution = {e:?}, friction = 0.4 }}\n"
            );
            let (mut energy, mut created) = (0.0_f64, 0);
            let imbalance = follow::<2>(&text, |scheme| {
                let step = scheme.last_step();
                energy = energy.max(step.energies.total().abs());
                // Percussions of 1e-11 N s, which the solver leaves, work by 1e-28 J.
                let works = step.contacts.iter().filter(|contact| contact.creates_energy() != [false; 2]);
                created +=
                    works.filter(|c| c.normal_work.max(c.tangential_work) > f64::EPSILON * 1e-6).count();
            });
            assert_eq!(created, 0, "{law}, e = {e}, {signal}");
            assert!(imbalance < 1e-12 * energy, "{law}, e = {e}, {signal}: {imbalance} of {energy}");
        }
    }
}

#[test]
fn a_run_goes_on_from_a_snapshot_as_if_it_had_not_stopped() {
    // A block that a belt has caught, one that still slides, and a motor on its limit.
    let mut text = head(1e-3, 0.4).replace("newton", "fremond").replace("theta = 0.5", "");
    for (name, x, speed) in [("caught", 0.0, 0.9), ("slides", 1.0, -0.5)] {
        text += &format!(
            "[[bodies]]\nname = '{name}'\ngroups = ['blocks']\nmass = 1.0\ninertia = 0.01\nposition = [{x:?}, 0.1]\n\
             velocity = [{speed:?}, 0.0]\npolygons = [{{ name = 'p', vertices = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], \
             [-0.2, 0.1]] }}]\n"
        );
    }
    text += "[[bodies]]\nname = 'rotor'\nmass = 1.0\ninertia = 0.1\nposition = [5.0, 0.0]\n[[joints]]\nname = 'axle'\n\
             body = 'rotor'\non = [5.0, 0.0]\nmotor = { force = 2.0 }\nlimits = [-1.0, 0.1]\n\
             parameters = { restitution = 0.2 }\n[[obstacles]]\nname = 'belt'\n\
             motion = [{ displacement = [1.0, 0.0], signal = { linear = { rate = 1.0 } } }]\n\
             half_planes = [{ name = 'top', normal = [0.0, 1.0] }]\n";
    text += &interface("belt", 0.3).replace("'body'", "'blocks'");
    let run = |scheme: &mut ThetaScheme<f64, 2>, steps: usize| {
        for step in 0..steps {
            scheme.step().unwrap_or_else(|error| panic!("step {step}: {error}"));
        }
    };
    let (mut whole, steps) = scheme::<2>(&text);
    for stop in [1, 33, 150, 250, 350] {
        let made = whole.state().index;
        run(&mut whole, stop - made);
        let mut again = scheme::<2>(&text).0;
        again.restore(&whole.snapshot()).expect("the same scene");
        let mut rest = scheme::<2>(&text).0;
        run(&mut rest, steps);
        run(&mut again, steps - stop);
        assert_eq!(again.state(), rest.state(), "from step {stop}");
    }
}

/// A ball on a plate that moves as A sin 2πft with A ω² = `ratio` g.
fn shaker(ratio: f64) -> (String, f64) {
    let omega = 2.0 * PI * 5.0;
    let amplitude = ratio * G / (omega * omega);
    let text = head(1e-4, 0.4)
        + &format!(
            r#"
            [[bodies]]
            name = "body"
            mass = 0.5
            inertia = 0.01
            position = [0.0, 0.1]
            velocity = [0.0, {:?}]
            discs = [{{ name = "rim", radius = 0.1 }}]
            [[obstacles]]
            name = "plate"
            motion = [{{ displacement = [0.0, {amplitude:?}], signal = {{ sine = {{ frequency = 5.0 }} }} }}]
            half_planes = [{{ name = "top", normal = [0.0, 1.0] }}]
            "#,
            amplitude * omega
        )
        + &interface("plate", 0.0);
    (text, omega)
}

#[test]
fn a_ball_takes_off_from_a_shaker_when_its_acceleration_passes_that_of_gravity() {
    let flights = |ratio: f64| {
        let (text, omega) = shaker(ratio);
        let (mut first, mut energy, mut driven) = (None, None, 0.0);
        let mut end = 0.0;
        let imbalance = follow::<1>(&text, |scheme| {
            let step = scheme.last_step();
            let carried = step.contacts.iter().any(|contact| contact.percussion[0] > 0.0);
            // In the first step the ball is faster than the plate, whose speed is that of a step, by (ωh)²/24.
            if !carried && scheme.state().time > 2e-3 {
                first.get_or_insert(scheme.state().time);
            }
            end = step.energies.total();
            driven += step.balance.prescribed_work + step.balance.normal_contact_work;
            energy.get_or_insert(end - driven);
        });
        // Energies of some m g · 1 cm and less.
        assert!(imbalance < 1e3 * f64::EPSILON, "{imbalance}");
        assert!((end - energy.expect("steps") - driven).abs() < 1e-10, "{end}, {energy:?}, {driven}");
        (first, omega)
    };
    assert_eq!(flights(0.98).0, None, "below g it stays");
    for ratio in [1.02, 1.5, 3.0] {
        let (first, omega) = flights(ratio);
        let exact = (1.0_f64 / ratio).asin() / omega;
        // Two steps of 1e-4 s, for the predicted gap.
        let first = first.expect("a flight");
        assert!((first - exact).abs() < 3e-4, "{ratio}: {first}, {exact}");
    }
}

#[test]
fn a_mass_on_a_spring_behind_a_piston_moves_as_the_forced_oscillator() {
    let (a, omega, forced) = (0.1, 7.0, 2.0 * PI * 0.6);
    let text = head(1e-3, 4.0).replace(&format!("gravity = [0.0, -{G}]"), "")
        + &format!(
            r#"
            [[bodies]]
            name = "body"
            mass = 2.0
            inertia = 0.1
            position = [1.0, 0.0]
            [[obstacles]]
            name = "piston"
            motion = [{{ displacement = [{a:?}, 0.0], signal = {{ sine = {{ frequency = 0.6 }} }} }}]
            [[springs]]
            name = "coupling"
            body = "body"
            to = "piston"
            stiffness = {:?}
            "#,
            2.0 * omega * omega
        );
    let (mut worst, mut driven, mut end) = (0.0_f64, 0.0, 0.0);
    let imbalance = follow::<1>(&text, |scheme| {
        let t = scheme.state().time;
        let share = a * omega * omega / (omega * omega - forced * forced);
        let exact = share * ((forced * t).sin() - forced / omega * (omega * t).sin());
        worst = worst.max((scheme.state().q[0] - 1.0 - exact).abs());
        driven += scheme.last_step().balance.prescribed_work;
        end = scheme.last_step().energies.total();
    });
    // Second order: ω t (ωh)²/12 of the amplitude, 1.2e-4; the piston's own start is that of a step.
    assert!(worst < 3e-4 * a * 10.0, "{worst}");
    assert!(imbalance < 1e4 * f64::EPSILON, "{imbalance}");
    assert!((end - driven).abs() < 1e-10, "{end}, {driven}");
}

#[test]
fn a_body_welded_to_a_piston_follows_it_and_its_inertia_is_what_the_piston_works_against() {
    let text = head(1e-3, 1.0).replace(&format!("gravity = [0.0, -{G}]"), "")
        + r#"
        [[bodies]]
        name = "body"
        mass = 2.0
        inertia = 0.1
        position = [0.5, 0.2]
        velocity = [0.5, 0.0]
        [[obstacles]]
        name = "piston"
        motion = [{ displacement = [1.0, 0.0], signal = { table = { times = [-1.0, 0.5, 2.5], values = [-0.5, 0.25, 3.25] } } }]
        [[joints]]
        name = "bolt"
        body = "body"
        to = "piston"
        at = [-0.5, -0.2]
        angle = 0.0
        "#;
    let (mut driven, mut v, mut q) = (0.0, Vec::new(), Vec::new());
    let imbalance = follow::<1>(text.as_str(), |scheme| {
        driven += scheme.last_step().balance.prescribed_work;
        v.clone_from(&scheme.state().v);
        q.clone_from(&scheme.state().q);
    });
    // From 0.5 m/s to 1.5 m/s.
    assert!((v[0] - 1.5).abs() < 1e-10 && (q[0] - q[3] - 0.5).abs() < 1e-12, "{v:?}, {q:?}");
    assert!((driven - (1.5 * 1.5 - 0.25)).abs() < 1e-9, "{driven}");
    assert!(imbalance < 1e3 * f64::EPSILON, "{imbalance}");
}

#[test]
fn a_disc_in_a_drum_that_turns_climbs_until_it_slides_back_on_the_cone_of_friction() {
    // A box in a drum at ω is carried up and slides; a disc spins up until it rolls without sliding on the moving wall.
    let text = head(1e-3, 6.0)
        + r#"
        [[bodies]]
        name = "body"
        mass = 1.0
        inertia = 0.02
        position = [0.0, -0.8]
        discs = [{ name = "rim", radius = 0.2 }]
        damping = [5.0, 5.0, 0.0]
        [[obstacles]]
        name = "drum"
        motion = [{ angle = 1.5, signal = { linear = { rate = 1.0 } } }]
        arcs = [{ name = "wall", radius = 1.0 }]
        "#
        + &interface("drum", 0.5);
    let mut v = Vec::new();
    let imbalance = follow::<2>(&text, |scheme| v.clone_from(&scheme.state().v));
    // It stays near the lowest point and rolls there: 0.2 ω_disc = 1.0 · 1.5.
    assert!((0.2 * v[2] - 1.5).abs() < 1e-3, "{v:?}");
    assert!(imbalance < 1e4 * f64::EPSILON * 10.0, "{imbalance}");
}

#[test]
fn a_motion_that_is_none_is_refused_in_words() {
    let (text, _) = shaker(1.5);
    let sine = "signal = { sine = { frequency = 5.0 } }";
    let mover = |more: &str| text.replace("half_planes = [{", &format!("{more}\nhalf_planes = [{{"));
    for (text, said) in [
        (text.replace("frequency = 5.0", "frequency = 0.0"), "frequency of a signal is 0"),
        (text.replace(sine, "signal = { linear = { rate = inf } }"), "rate of a signal is inf"),
        (
            text.replace(
                "motion = [{",
                "motion = [{ displacement = [0.0, 1.0], signal = { linear = { rate = 1.0 } } }, {",
            ),
            "two motions in y",
        ),
        (mover("position = [nan, 0.0]"), "position or angle of `plate`"),
        (text.replace("signal = { sine", "sygnal = { sine"), "sygnal"),
    ] {
        let error = try_scheme::<1>(&text).map(drop).expect_err(said).to_string();
        assert!(error.contains(said), "{said}: {error}");
    }
}
