//! Sliders, limits, motors and dry friction of joints, and loops of joints with more rows than are needed.
#![cfg(feature = "scene")]

#[path = "mechanics/from_text.rs"]
mod from_text;

use std::f64::consts::PI;

use from_text::{follow, scheme, try_scheme, upcrossings};
use nonsmooth::scheme::StepError;

fn head(step: f64, end: f64, gravity: f64) -> String {
    format!(
        r#"
        title = "mechanisms"
        laws = ["fremond"]
        gravity = [0.0, -{gravity:?}]
        [time]
        theta = 0.5
        step = {step:?}
        end = {end:?}
        "#
    )
}

const R: f64 = 0.3;
const L: f64 = 1.0;
const SPEED: f64 = 8.0;

/// A crank that a motor turns at 8 rad/s, a rod, and a piston that slides along x.
fn slider_crank() -> String {
    let (half_r, half_l) = (R / 2.0, L / 2.0);
    let (middle, end, tip) = (R + half_l, R + L, SPEED * half_r);
    let rod_spin = -SPEED * R / L;
    head(1e-3, 2.0, 9.81)
        + &format!(
            r#"
            [[bodies]]
            name = "crank"
            mass = 1.0
            inertia = 0.01
            position = [{half_r:?}, 0.0]
            velocity = [0.0, {tip:?}]
            spin = {SPEED:?}
            [[bodies]]
            name = "rod"
            mass = 0.8
            inertia = 0.07
            position = [{middle:?}, 0.0]
            velocity = [0.0, {tip:?}]
            spin = {rod_spin:?}
            [[bodies]]
            name = "piston"
            mass = 2.0
            inertia = 0.01
            position = [{end:?}, 0.0]
            [[joints]]
            name = "main bearing"
            body = "crank"
            at = [-{half_r:?}, 0.0]
            motor = {{ speed = {SPEED:?} }}
            [[joints]]
            name = "crank pin"
            body = "rod"
            to = "crank"
            at = [-{half_l:?}, 0.0]
            on = [{half_r:?}, 0.0]
            [[joints]]
            name = "piston pin"
            body = "rod"
            to = "piston"
            at = [{half_l:?}, 0.0]
            [[joints]]
            name = "cylinder"
            body = "piston"
            axis = [1.0, 0.0]
            angle = 0.0
            "#
        )
}

#[test]
fn the_piston_of_a_slider_crank_is_where_geometry_puts_it() {
    let (mut worst, mut work, mut start, mut end) = (0.0_f64, 0.0, None, 0.0);
    let imbalance = follow::<1>(&slider_crank(), |scheme| {
        let state = scheme.state();
        let (sin, cos) = (SPEED * state.time).sin_cos();
        let exact = R * cos + (L * L - R * R * sin * sin).sqrt();
        worst = worst.max((state.q[6] - exact).abs()).max(state.q[7].abs()).max(state.q[8].abs());
        let step = scheme.last_step();
        work += step.balance.external_work;
        start.get_or_insert(step.energies.total() - step.energies.potential);
        end = step.energies.total() - step.energies.potential;
    });
    // Joints are closed, and the motor turns, to 64 ε of the coordinates; angles of 16 rad add up over 2000 steps.
    assert!(worst < 2000.0 * f64::EPSILON * 16.0, "{worst}");
    assert!(imbalance < 1e4 * f64::EPSILON * 10.0, "{imbalance}");
    assert!(work.is_finite() && start.is_some() && end > 0.0);
}

#[test]
fn a_clutch_locks_when_its_torque_has_made_the_speeds_equal() {
    // I₁ at ω₀ against I₂ at rest: locked at ω₀ I₁I₂/((I₁+I₂) τ), at I₁ω₀/(I₁+I₂), for a loss of ½ ω₀² I₁I₂/(I₁+I₂).
    let (one, two, speed, torque) = (0.5, 1.5, 12.0, 3.0);
    let text = head(1e-3, 2.5, 0.0)
        + &format!(
            r#"
            [[bodies]]
            name = "engine"
            mass = 1.0
            inertia = {one:?}
            position = [0.0, 0.0]
            spin = {speed:?}
            [[bodies]]
            name = "gearbox"
            mass = 1.0
            inertia = {two:?}
            position = [0.0, 0.0]
            [[joints]]
            name = "shaft"
            body = "gearbox"
            [[joints]]
            name = "clutch"
            body = "engine"
            to = "gearbox"
            friction = {torque:?}
            "#
        );
    let reduced = one * two / (one + two);
    let (mut locked, mut lost) = (None, 0.0);
    let mut v = Vec::new();
    let imbalance = follow::<1>(&text, |scheme| {
        v.clone_from(&scheme.state().v);
        lost += scheme.last_step().balance.damping_work;
        if (v[2] - v[5]).abs() < 1e-9 {
            locked.get_or_insert(scheme.state().time);
        }
    });
    let locked = locked.expect("it locks");
    // In the step in which it locks, and the next.
    assert!((locked - speed * reduced / torque).abs() < 2.01e-3, "{locked}");
    assert!((v[2] - one * speed / (one + two)).abs() < 1e-12, "{v:?}");
    assert!((lost + 0.5 * reduced * speed * speed).abs() < 1e-9, "{lost}");
    assert!(imbalance < 1e3 * f64::EPSILON * 36.0, "{imbalance}");
}

#[test]
fn a_rusty_pin_holds_a_rod_up_to_its_torque_and_lets_it_fall_beyond() {
    let rod = |friction: f64| {
        head(1e-3, 0.5, 10.0)
            + &format!(
                r#"
                [[bodies]]
                name = "rod"
                mass = 1.0
                inertia = 0.0833
                position = [0.5, 0.0]
                [[joints]]
                name = "pin"
                body = "rod"
                at = [-0.5, 0.0]
                friction = {friction:?}
                "#
            )
    };
    // The weight turns it by m g L/2 = 5 N m.
    let turned = |friction| {
        let (mut scheme, steps) = scheme::<1>(&rod(friction));
        for _ in 0..steps {
            scheme.step().expect("a rod");
        }
        scheme.state().q[2]
    };
    assert!(turned(5.01).abs() < 1e-12, "{}", turned(5.01));
    // It starts with (5 − 4.9)/I_pin = 0.1/0.3333, and the weight's arm shortens but little.
    let exact = -0.5 * 0.1 / 0.3333 * 0.25;
    assert!((turned(4.9) / exact - 1.0).abs() < 2e-2, "{}, {exact}", turned(4.9));
}

#[test]
fn a_rod_between_limits_loses_the_share_of_its_spin_that_the_law_says() {
    let rod = |e: f64, more: &str| {
        head(1e-3, 3.0, 0.0)
            + &format!(
                r#"
                [[bodies]]
                name = "rod"
                mass = 1.0
                inertia = 0.1
                position = [0.5, 0.0]
                velocity = [0.0, 1.0]
                spin = 2.0
                discs = [{{ name = "tip", centre = [0.5, 0.0] }}]
                [[joints]]
                name = "hinge"
                body = "rod"
                at = [-0.5, 0.0]
                limits = [-0.4, 0.6]
                parameters = {{ restitution = {e:?}, friction = 0.0 }}
                {more}
                "#
            )
            .replace("theta = 0.5", "theta = 0.5\nallow_unproved_theta = true")
    };
    let plane = "[[half_planes]]\nname = 'far'\npoint = [0.0, -5.0]\nnormal = [0.0, 1.0]\n[[interfaces]]\n\
                 between = ['rod', 'far']\nparameters = { restitution = 0.0, friction = 0.5 }";
    for e in [0.0, 0.5, 1.0] {
        let mut speeds: Vec<f64> = vec![2.0];
        let (mut least, mut most) = (0.0_f64, 0.0_f64);
        let imbalance = follow::<1>(&rod(e, ""), |scheme| {
            let (spin, angle) = (scheme.state().v[2].abs(), scheme.state().q[2]);
            (least, most) = (least.min(angle), most.max(angle));
            // The rates of a pinned rod alternate by (ωh)²/4 = 1e-6 of themselves from step to step.
            if (spin - speeds[speeds.len() - 1]).abs() > 1e-2 {
                speeds.push(spin);
            }
        });
        // A step past the limit at most.
        assert!(least > -0.402 - 1e-9 && most < 0.602 + 1e-9, "e = {e}: {least}, {most}");
        assert!(imbalance < 1e3 * f64::EPSILON, "{imbalance}");
        if e == 1.0 {
            assert!(speeds.len() == 1, "{speeds:?}");
        } else {
            assert!(speeds.len() > 1);
            // Arms turn by ωh = 2e-3 in the step of an impact.
            speeds.windows(2).for_each(|pair| {
                assert!((pair[1] - e * pair[0]).abs() < 2e-3 * pair[0], "e = {e}: {speeds:?}");
            });
        }
        // Beside contacts with friction the limit has a tangent that moves nothing.
        for solver in ["hybrid", "nsgs", "admm"] {
            let text = rod(e, plane).replace("gravity", &format!("solvers = ['{solver}']\ngravity"));
            let mut spin = 0.0_f64;
            follow::<2>(&text, |scheme| spin = scheme.state().v[2].abs());
            assert!((spin - speeds[speeds.len() - 1]).abs() < 2e-3 * 2.0, "{solver}: {spin}, {speeds:?}");
        }
    }
}

#[test]
fn a_motor_gives_its_torque_up_to_its_speed_and_its_work_is_booked() {
    // 2 N m on I = 0.4: ω = 5 t up to 6 rad/s at 1.2 s, then no torque; the work is ½ I ω².
    let text = head(1e-3, 2.0, 0.0)
        + r#"
        [[bodies]]
        name = "rotor"
        mass = 1.0
        inertia = 0.4
        position = [0.0, 0.0]
        [[joints]]
        name = "axle"
        body = "rotor"
        motor = { speed = 6.0, most = 2.0 }
        "#;
    let mut work = 0.0;
    let imbalance = follow::<1>(&text, |scheme| {
        let state = scheme.state();
        let exact = (5.0 * state.time).min(6.0);
        assert!((state.v[2] - exact).abs() < 1e-10, "t = {}: {} for {exact}", state.time, state.v[2]);
        work += scheme.last_step().balance.external_work;
    });
    assert!((work - 0.5 * 0.4 * 36.0).abs() < 1e-10, "{work}");
    assert!(imbalance < 1e3 * f64::EPSILON * 8.0, "{imbalance}");

    // A torque between two free bodies turns them against each other, and works on both.
    let text = head(1e-3, 1.0, 0.0)
        + r#"
        [[bodies]]
        name = "satellite"
        mass = 1.0
        inertia = 2.0
        position = [0.0, 0.0]
        [[bodies]]
        name = "wheel"
        mass = 1.0
        inertia = 0.5
        position = [0.0, 0.0]
        [[joints]]
        name = "axle"
        body = "wheel"
        to = "satellite"
        motor = { force = 3.0, signal = { ramp = { end = 0.5 } } }
        "#;
    let mut state = (Vec::new(), 0.0);
    follow::<1>(&text, |scheme| {
        state.0.clone_from(&scheme.state().v);
        state.1 += scheme.last_step().balance.external_work;
    });
    // ∫ of the ramp over 1 s is 0.75 s.
    let (v, impulse) = (&state.0, 3.0 * 0.75);
    assert!((v[5] - impulse / 0.5).abs() < 1e-12 && (v[2] + impulse / 2.0).abs() < 1e-12, "{v:?}");
    assert!((state.1 - 0.5 * impulse * impulse * (2.0 + 0.5)).abs() < 1e-12, "{}", state.1);
}

#[test]
fn a_motor_that_pushes_on_a_limit_rests_there() {
    // 2 N m on I = 0.4 from rest, to the limit at 0.6 rad after 0.49 s; the law takes all of the spin, or leaves a bounce.
    for (law, e) in [("fremond", 0.0), ("newton", 0.0), ("fremond", 0.4)] {
        for motor in ["force = 2.0", "speed = 6.0, most = 2.0"] {
            let text = head(1e-3, 4.0, 9.81).replace("fremond", law).replace("theta = 0.5", "")
                + &format!(
                    r#"
                    [[bodies]]
                    name = "rotor"
                    mass = 1.0
                    inertia = 0.4
                    position = [0.0, 0.0]
                    [[joints]]
                    name = "axle"
                    body = "rotor"
                    motor = {{ {motor} }}
                    limits = [-1.0, 0.6]
                    parameters = {{ restitution = {e:?} }}
                    "#
                );
            let (mut spin, mut off, mut energy) = (0.0_f64, 0.0_f64, 0.0_f64);
            let imbalance = follow::<1>(&text, |scheme| {
                let state = scheme.state();
                energy = energy.max(scheme.last_step().energies.kinetic);
                if state.time > 3.0 {
                    (spin, off) = (spin.max(state.v[2].abs()), off.max((state.q[2] - 0.6).abs()));
                }
            });
            assert!(spin < 1e-9 && off < 1e-9, "{law}, e = {e}, {motor}: {spin} rad/s, {off} rad");
            assert!(imbalance < 1e-12 * energy, "{law}, {motor}: {imbalance} of {energy}");
        }
    }
}

#[test]
fn a_rod_in_a_rusty_pin_leans_on_the_floor_without_a_tremble() {
    // Its tip falls on the floor against a friction of 1 N m, and lies there.
    for law in ["fremond", "newton"] {
        let text = head(1e-3, 2.0, 10.0).replace("fremond", law).replace("theta = 0.5", "")
            + r#"
            [[bodies]]
            name = "rod"
            mass = 1.0
            inertia = 0.0833
            position = [0.5, 0.0]
            discs = [{ name = "tip", centre = [0.5, 0.0] }]
            [[joints]]
            name = "pin"
            body = "rod"
            at = [-0.5, 0.0]
            friction = 1.0
            [[half_planes]]
            name = "floor"
            point = [0.0, -0.3]
            normal = [0.0, 1.0]
            [[interfaces]]
            between = ["rod", "floor"]
            parameters = { restitution = 0.0, friction = 0.2 }
            "#;
        let (mut speed, mut off, mut energy) = (0.0_f64, 0.0_f64, 0.0_f64);
        let imbalance = follow::<2>(&text, |scheme| {
            let state = scheme.state();
            energy = energy.max(scheme.last_step().energies.kinetic);
            if state.time > 1.5 {
                let depth = (state.q[1] + 0.5 * state.q[2].sin() + 0.3).abs();
                (speed, off) = (state.v.iter().fold(speed, |most, v| most.max(v.abs())), off.max(depth));
            }
        });
        assert!(speed < 1e-9 && off < 1e-9, "{law}: {speed}, {off}");
        assert!(imbalance < 1e-12 * energy, "{law}: {imbalance} of {energy}");
    }
}

#[test]
fn a_slider_moves_along_its_axis_alone_and_one_that_turns_turns() {
    // A bead on a rod that turns freely in a slot at 30°: gravity accelerates it by g sin 30°.
    let text = head(1e-3, 1.0, 10.0)
        + r#"
        [[bodies]]
        name = "bead"
        mass = 3.0
        inertia = 0.2
        position = [0.0, 0.0]
        spin = 4.0
        [[obstacles]]
        name = "ramp"
        angle = -0.5235987755982988
        [[joints]]
        name = "slot"
        body = "bead"
        to = "ramp"
        axis = [2.0, 0.0]
        friction = 3.0
        "#;
    let (mut q, mut v) = (Vec::new(), Vec::new());
    follow::<1>(&text, |scheme| {
        q.clone_from(&scheme.state().q);
        v.clone_from(&scheme.state().v);
    });
    // Less 3 N of friction on 3 kg.
    let along = 10.0 * 0.5 - 1.0;
    assert!((v[0].hypot(v[1]) - along).abs() < 1e-11 && (v[2] - 4.0).abs() < 1e-12, "{v:?}");
    assert!((q[0] * 0.5 + q[1] * 0.75_f64.sqrt()).abs() < 1e-13, "{q:?}");
}

/// A parallelogram of cranks of 1 kg and 1 m, one more than it needs, under a coupler of 2 kg.
fn parallelogram(cranks: usize, angle: f64) -> String {
    let mut text = head(2e-3, 8.0, 9.81);
    let (sin, cos) = angle.sin_cos();
    let middle = (cranks - 1) as f64 / 2.0;
    text += &format!(
        "[[bodies]]\nname = 'coupler'\nmass = 2.0\ninertia = 1.0\nposition = [{:?}, {:?}]\n",
        middle + sin,
        -cos
    );
    for i in 0..cranks {
        let x = i as f64;
        text += &format!(
            "[[bodies]]\nname = 'crank {i}'\nmass = 1.0\ninertia = {:?}\nposition = [{:?}, {:?}]\nangle = {angle:?}\n\
             [[joints]]\nname = 'base {i}'\nbody = 'crank {i}'\nat = [0.0, 0.5]\non = [{x:?}, 0.0]\n\
             [[joints]]\nname = 'top {i}'\nbody = 'crank {i}'\nat = [0.0, -0.5]\nto = 'coupler'\non = [{:?}, 0.0]\n",
            1.0 / 12.0,
            x + 0.5 * sin,
            -0.5 * cos,
            x - middle
        );
    }
    text
}

#[test]
fn a_parallelogram_swings_as_long_as_it_should_with_as_many_cranks_as_one_likes() {
    let angle = 0.05;
    for cranks in [2, 3, 5] {
        let n = cranks as f64;
        let mut samples = Vec::new();
        let imbalance = follow::<1>(&parallelogram(cranks, angle), |scheme| {
            let q = &scheme.state().q;
            samples.push((scheme.state().time, q[5]));
            assert!((q[2]).abs() < 1e-10, "the coupler stays level: {}", q[2]);
        });
        let crossings = upcrossings(&samples);
        let found = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
        let omega = (9.81 * (0.5 * n + 2.0) / (n / 3.0 + 2.0)).sqrt();
        let exact = 2.0 * PI / omega * (1.0 + angle * angle / 16.0);
        // Second order: (ω h)²/12 = 4e-6.
        assert!((found / exact - 1.0).abs() < 2e-5, "{cranks}: {found}, {exact}");
        assert!(imbalance < 1e5 * f64::EPSILON * 9.81, "{cranks}: {imbalance}");
    }
}

#[test]
fn a_beam_on_more_pins_than_it_needs_stands_still_under_its_weight() {
    let mut text = head(1e-3, 0.2, 9.81);
    text += "[[bodies]]\nname = 'beam'\nmass = 1.0\ninertia = 0.1\nposition = [0.5, 0.0]\n";
    for (i, x) in [0.0, 0.5, 1.0].into_iter().enumerate() {
        let at = x - 0.5;
        text +=
            &format!("[[joints]]\nname = 'pin {i}'\nbody = 'beam'\nat = [{at:?}, 0.0]\non = [{x:?}, 0.0]\n");
    }
    let mut moved = 0.0_f64;
    follow::<1>(&text, |scheme| {
        let q = &scheme.state().q;
        moved = moved.max((q[0] - 0.5).abs()).max(q[1].abs()).max(q[2].abs());
    });
    // 200 steps that leave 64 ε of h g h each.
    assert!(moved < 1e-15, "{moved}");
}

#[test]
fn motors_that_contradict_each_other_are_refused_by_name() {
    let text = head(1e-3, 1.0, 0.0)
        + r#"
        [[bodies]]
        name = "rotor"
        mass = 1.0
        inertia = 1.0
        position = [0.0, 0.0]
        [[joints]]
        name = "one"
        body = "rotor"
        motor = { speed = 1.0 }
        [[joints]]
        name = "other"
        body = "rotor"
        motor = { speed = 2.0 }
        "#;
    let (mut scheme, _) = scheme::<1>(&text);
    let error = scheme.step().map(drop).expect_err("two speeds of one shaft");
    assert!(
        matches!(&error, StepError::Joints { .. } | StepError::JointPasses { .. })
            && error.to_string().contains("joint o"),
        "{error}"
    );
}

#[test]
fn a_joint_that_is_none_is_refused_in_words() {
    for (change, said) in [
        ("motor = { speed = 8.0 }", "motor = { speed = 8.0, force = 1.0 }", "must have either `speed`"),
        ("motor = { speed = 8.0 }", "motor = {}", "must have either `speed`"),
        ("motor = { speed = 8.0 }", "angle = 0.0\nfriction = 1.0", "`main bearing` holds everything"),
        ("motor = { speed = 8.0 }", "friction = -1.0", "friction of `main bearing.friction` is -1"),
        ("motor = { speed = 8.0 }", "limits = [1.0, 0.0]", "upper less lower limit of `main bearing` is -1"),
        (
            "motor = { speed = 8.0 }",
            "motor = { speed = 8.0, most = -2.0 }",
            "largest force of `main bearing.motor` is -2",
        ),
        ("axis = [1.0, 0.0]", "axis = [0.0, 0.0]", "length of the axis of `cylinder` is 0"),
        ("to = \"piston\"", "to = \"valve\"", "joint `piston pin`"),
    ]
    .map(|(from, to, said)| ((from, to), said))
    {
        let text = slider_crank();
        assert!(text.contains(change.0), "{}", change.0);
        let error = try_scheme::<1>(&text.replace(change.0, change.1)).expect_err(change.1).to_string();
        assert!(error.contains(said), "{change:?}: {error}");
    }
}
