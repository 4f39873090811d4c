//! Fixed shapes of any kind: what rolls in them, over them, and along their seams.
#![cfg(feature = "scene")]

#[path = "mechanics/from_text.rs"]
mod from_text;

use std::f64::consts::PI;

use from_text::{follow, try_scheme, upcrossings};

const G: f64 = 9.81;
const R: f64 = 1.0;
const BALL: f64 = 0.2;

/// A disc of radius 0.2 m at a small angle in a bowl of radius 1 m, friction μ.
fn bowl(obstacle: &str, angle: f64, mu: f64, end: f64) -> String {
    let (sin, cos) = angle.sin_cos();
    let (x, y) = ((R - BALL) * sin, R - (R - BALL) * cos);
    format!(
        r#"
        title = "A disc in a bowl"
        laws = ["fremond"]
        gravity = [0.0, -{G}]
        [time]
        theta = 0.5
        step = 1e-3
        end = {end}
        [[bodies]]
        name = "disc"
        mass = 2.0
        inertia = 0.04
        position = [{x:?}, {y:?}]
        discs = [{{ name = "rim", radius = {BALL} }}]
        [[obstacles]]
        name = "bowl"
        {obstacle}
        [[interfaces]]
        between = ["disc", "bowl"]
        parameters = {{ restitution = 0.0, friction = {mu:?} }}
        "#
    )
}

const CIRCLE: &str = "position = [0.0, 1.0]\narcs = [{ name = 'inside', radius = 1.0 }]";

/// Period of x(t).
fn period(text: &str) -> f64 {
    let mut samples = Vec::new();
    let imbalance = follow::<2>(text, |scheme| samples.push((scheme.state().time, scheme.state().q[0])));
    // Rounding of an energy of some m g R = 20 J.
    assert!(imbalance < 64.0 * f64::EPSILON * 20.0, "{imbalance}");
    let crossings = upcrossings(&samples);
    let (first, last) = (crossings[0], crossings[crossings.len() - 1]);
    (last - first) / (crossings.len() - 1) as f64
}

#[test]
fn a_disc_in_a_bowl_swings_as_a_pendulum_slower_by_half_the_inertia_where_it_rolls() {
    let angle = 0.02;
    // ½ m v² (1 + I/(m r²)) with I = ½ m r²: rolling carries 3/2 of the mass.
    let exact = |share: f64| 2.0 * PI * (share * (R - BALL) / G).sqrt() * (1.0 + angle * angle / 16.0);
    for (mu, share) in [(0.0, 1.0), (1.0, 1.5)] {
        let found = period(&bowl(CIRCLE, angle, mu, 8.0));
        // The contact acts in the direction of the start of the step: an error of second order in ωh = 4e-3, and first
        // order where the step begins to roll.
        assert!((found / exact(share) - 1.0).abs() < 2e-3, "μ = {mu}: {found}, {}", exact(share));
    }
}

#[test]
fn a_whole_circle_an_arc_of_it_and_a_fine_chain_make_the_same_bowl() {
    let whole = period(&bowl(CIRCLE, 0.02, 1.0, 4.0));
    let arc =
        "position = [0.0, 1.0]\nangle = 0.5\narcs = [{ name = 'a', radius = 1.0, from = -2.2, to = -1.9 }]";
    assert_eq!(whole, period(&bowl(arc, 0.02, 1.0, 4.0)), "the arc that is met");
    // Chords of a degree, inscribed in the bowl; larger swings pass many of them.
    let points: Vec<String> = (0..=90)
        .map(|i| (PI + PI * f64::from(i) / 90.0).sin_cos())
        .map(|(sin, cos)| format!("[{:?}, {:?}]", cos, 1.0 + sin))
        .collect();
    let chain = format!("chains = [{{ name = 'polyline', points = [{}] }}]", points.join(", "));
    let (round, edged) = (period(&bowl(CIRCLE, 0.4, 1.0, 4.0)), period(&bowl(&chain, 0.4, 1.0, 4.0)));
    // A chord of 2° is lower than its arc by R (1 − cos 1°) = 1.5e-4 R; every corner costs (1 − cos 2°) of the energy.
    assert!((edged / round - 1.0).abs() < 2e-2, "{edged}, {round}");
}

#[test]
fn a_disc_and_a_box_slide_over_the_flush_points_of_a_chain_without_feeling_them() {
    for shape in [
        "discs = [{ name = 's', radius = 0.1 }]",
        "polygons = [{ name = 's', vertices = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]] }]",
    ] {
        let text = format!(
            r#"
            title = "slide"
            laws = ["fremond"]
            gravity = [0.0, -{G}]
            [time]
            theta = 0.5
            step = 1e-3
            end = 0.7
            [[bodies]]
            name = "body"
            mass = 1.0
            inertia = 0.01
            position = [0.15, 0.1]
            velocity = [3.0, 0.0]
            {shape}
            [[obstacles]]
            name = "floor"
            chains = [{{ name = "line", points = [[0.0, 0.0], [0.5, 0.0], [0.9, 0.0], [1.7, 0.0], [3.0, 0.0]] }}]
            [[interfaces]]
            between = ["body", "floor"]
            parameters = {{ restitution = 0.0, friction = 0.0 }}
            "#
        );
        let mut least = f64::INFINITY;
        follow::<1>(&text, |scheme| {
            let state = scheme.state();
            least = least.min(state.v[0]);
            assert!((state.q[1] - 0.1).abs() < 1e-9, "it stays on the floor: {}", state.q[1]);
        });
        // Nothing stops it: 700 roundings of 3 m/s at most.
        assert!(3.0 - least < 700.0 * f64::EPSILON * 3.0, "{shape}: {least}");
    }
}

#[test]
fn a_box_in_a_closed_chain_bounces_for_ever_and_stays_inside() {
    let text = r#"
        title = "billiards"
        laws = ["fremond"]
        [time]
        theta = 0.5
        step = 1e-3
        end = 5.0
        [[bodies]]
        name = "box"
        mass = 1.0
        inertia = 1e-3
        position = [0.1, 0.05]
        velocity = [2.0, 1.1]
        spin = 3.0
        polygons = [{ name = "p", vertices = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]] }]
        [[obstacles]]
        name = "table"
        chains = [{ name = "cushion", points = [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]], closed = true }]
        [[interfaces]]
        between = ["box", "table"]
        parameters = { restitution = 1.0, friction = 0.0 }
        "#;
    let start = 0.5 * (4.0 + 1.21) + 0.5 * 1e-3 * 9.0;
    let (mut kinetic, mut outside, mut impacts) = (0.0, f64::NEG_INFINITY, 0);
    follow::<1>(text, |scheme| {
        let step = scheme.last_step();
        kinetic = step.energies.kinetic;
        impacts += step.contacts.iter().filter(|contact| contact.percussion[0] > 0.0).count();
        let q = &scheme.state().q;
        outside = outside.max(q[0].abs() - 1.0).max(q[1].abs() - 0.5);
    });
    assert!(impacts > 10, "{impacts}");
    assert!(outside < -0.04, "{outside}");
    assert!((kinetic - start).abs() < 1e4 * f64::EPSILON * start, "{kinetic}, {start}");
}

#[test]
fn a_polygon_rests_on_its_corners_in_a_round_bowl() {
    // A rod of half length a in a frictionless circle of radius R rests where its corners touch: √(R² − a²) below the centre.
    let text = format!(
        r#"
        title = "rod"
        laws = ["fremond"]
        gravity = [0.0, -{G}]
        [time]
        theta = 1.0
        step = 1e-3
        end = 6.0
        [[bodies]]
        name = "rod"
        mass = 1.0
        inertia = 0.1
        position = [0.0, 0.25]
        damping = [5.0, 5.0, 0.5]
        polygons = [{{ name = "p", vertices = [[-0.6, 0.0], [0.6, 0.0], [0.6, 0.02], [-0.6, 0.02]] }}]
        [[obstacles]]
        name = "bowl"
        arcs = [{{ name = "inside", centre = [0.0, 1.0], radius = 1.0 }}]
        [[interfaces]]
        between = ["rod", "bowl"]
        parameters = {{ restitution = 0.0, friction = 0.0 }}
        "#
    );
    let mut at = Vec::new();
    follow::<1>(&text, |scheme| at.clone_from(&scheme.state().q));
    // What the velocities at the end of a step close is the predicted gap: a depth of second order in h v.
    assert!((at[1] - 0.2).abs() < 1e-4 && at[0].abs() < 1e-6 && at[2].abs() < 1e-6, "{at:?}");
}

#[test]
fn an_obstacle_that_is_none_is_refused_in_words() {
    for (obstacle, said) in [
        ("arcs = [{ name = 'a', radius = 0.0 }]", "radius of `bowl.a` is 0, it must be finite and > 0"),
        ("arcs = [{ name = 'a', radius = 1.0, from = 0.0 }]", "needs both"),
        ("arcs = [{ name = 'a', radius = 1.0, from = 1.0, to = 0.5 }]", "opening of `bowl.a` is -0.5"),
        ("chains = [{ name = 'c', points = [[0.0, 0.0]] }]", "number of points of chain `bowl.c` is 1"),
        (
            "chains = [{ name = 'c', points = [[0, 0], [1, 0], [1, 0]] }]",
            "length of segment 1 of chain `bowl.c` is 0",
        ),
        (
            "chains = [{ name = 'c', points = [[0, 0], [1, 0], [0, 0]] }]",
            "turn (rad) of chain `bowl.c` at point 1",
        ),
        ("polygons = [{ name = 'p', vertices = [[0, 0], [1, 0]] }]", "number of vertices"),
        ("angle = nan\narcs = [{ name = 'a', radius = 1.0 }]", "position or angle of `bowl`"),
    ] {
        let error = try_scheme::<2>(&bowl(obstacle, 0.1, 0.0, 1.0)).expect_err(obstacle).to_string();
        assert!(error.contains(said), "{obstacle}: {error}");
    }
}
