//! Systems behind the doors: what every system says of itself, assemblies, and configurations that are no velocities.

#[path = "mechanics/stream.rs"]
mod stream;

use std::ops::ControlFlow;

use nalgebra::SVector;
use nonsmooth::adaptive::{Adaptive, AdaptiveSettings};
use nonsmooth::contact::{Candidate, ContactId};
use nonsmooth::laws::{ContactLaw, NewtonCoulomb};
use nonsmooth::linalg::{BlockRows, Symmetric};
use nonsmooth::observe::{CsvFiles, Frame, Observer, Rates, RunInfo};
use nonsmooth::scheme::{Settings, SetupError, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::suite::{Suite, check_system};
use nonsmooth::system::{
    Assembly, AssemblyError, Body, BodyId, Contacts, Describe, Dynamics, Forces, Lagrangian, Relative,
    RigidBodies, RoundSide, Scales, Signal, SmoothContacts, SmoothGap, System,
};

/// Newton's law without friction.
fn elastic<const D: usize>(e: f64) -> Box<dyn ContactLaw<f64, D>> {
    Box::new(NewtonCoulomb::new(e, 0.0).expect("in range"))
}

fn scheme<const D: usize>(
    system: Box<dyn System<f64, D>>,
    e: f64,
    (q, v): (&[f64], &[f64]),
    h: f64,
) -> ThetaScheme<f64, D> {
    let laws = (0..system.interfaces()).map(|_| elastic(e)).collect();
    let solver = solver::build("hybrid", Stopping::default()).expect("registered");
    ThetaScheme::new(system, laws, solver, Settings::new(0.5, h), 0.0, q.to_vec(), v.to_vec()).expect("valid")
}

fn mass(entries: &[f64]) -> Symmetric<f64> {
    Symmetric::diagonal(entries.to_vec()).expect("finite")
}

/// A bead of mass m on a line above a floor at 0, under its weight.
fn bead(m: f64) -> Lagrangian<f64, 1> {
    let floor = SmoothGap::new(
        |q: &[f64]| q[0],
        |_: &[f64], push: &mut dyn FnMut(usize, SVector<f64, 1>)| {
            push(0, SVector::<f64, 1>::new(1.0));
        },
    );
    let weight = Forces::constant(vec![-9.81 * m]);
    Lagrangian::new(mass(&[m])).with_forces(weight).expect("one force").with_contact(0, floor)
}

/// A bead of mass m on a ring of radius r: q is its place (x, y), v its rate ω. Its motion along the ring is a rotation, so
/// that it stays on it; the ring is cut by a stop at y = 0.
#[derive(Debug)]
struct Ring {
    inertia: Symmetric<f64>,
    forces: Forces<f64>,
}

impl Ring {
    fn new(m: f64, r: f64) -> Self {
        Self { inertia: mass(&[m * r * r]), forces: Forces::constant(vec![0.0]) }
    }
}

impl Dynamics<f64> for Ring {
    fn coordinates(&self) -> usize {
        2
    }
    fn advance(&self, q: &[f64], s: &[f64], out: &mut [f64]) {
        let (sin, cos) = s[0].sin_cos();
        out.copy_from_slice(&[cos * q[0] - sin * q[1], sin * q[0] + cos * q[1]]);
    }
    fn difference(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
        out[0] = f64::atan2(from[0] * to[1] - from[1] * to[0], from[0] * to[0] + from[1] * to[1]);
    }
    fn mass(&self) -> &Symmetric<f64> {
        &self.inertia
    }
    fn forces(&self) -> &Forces<f64> {
        &self.forces
    }
    fn potential(&self, _q: &[f64]) -> f64 {
        0.0
    }
    fn turns(&self, _dof: usize) -> bool {
        true
    }
    fn scales(&self, q: &[f64], v: &[f64]) -> Scales<f64> {
        let length = q[0].hypot(q[1]);
        Scales { length, speed: length * v[0].abs().max(1.0) }
    }
}

impl Contacts<f64, 1> for Ring {
    fn interfaces(&self) -> usize {
        1
    }
    fn candidates(&mut self, q: &[f64], reach: f64, out: &mut Vec<Candidate<f64>>) {
        if q[1] <= reach {
            out.push(Candidate { id: ContactId::new(0), interface: 0, gap: q[1] });
        }
    }
    fn jacobian(&self, _contact: ContactId, q: &[f64], out: &mut BlockRows<f64, 1>) {
        out.start_row();
        out.push(0, SVector::<f64, 1>::new(q[0]));
    }
    fn gap(&self, _contact: ContactId, q: &[f64]) -> f64 {
        q[1]
    }
}

impl Describe<f64> for Ring {
    fn dof_label(&self, _dof: usize) -> String {
        "rate".into()
    }
    fn coordinate_label(&self, coordinate: usize) -> String {
        ["x", "y"][coordinate].into()
    }
}

fn bodies(links: usize) -> RigidBodies<f64> {
    let mut builder = RigidBodies::builder();
    let (balls, ground) = (builder.group(), builder.group());
    let mut last = None;
    for i in 0..links {
        let body = builder.body(&format!("b{i}"), Body { mass: 1.0, inertia: 0.1 }).expect("positive");
        builder.disc(&format!("d{i}"), body, [0.0, 0.0], 0.4, balls).expect("a disc");
        builder
            .pin(&format!("p{i}"), body, [-0.5, 0.0], last, [if i == 0 { 0.0 } else { 0.5 }, 0.0])
            .expect("finite");
        last = Some(body);
    }
    builder.half_plane("floor", [0.0, -1.0], [0.1, 1.0], ground).expect("a plane");
    builder.interface(balls, ground).expect("groups");
    builder.gravity([0.0, -9.81]).expect("finite");
    builder.build().expect("bodies")
}

#[test]
fn systems_agree_with_themselves() {
    let suite = Suite::default();
    check_system::<2>(
        &suite,
        &mut bodies(3),
        (&[0.5, 0.0, 0.0, 1.5, 0.0, 0.0, 2.5, 0.0, 0.0], &[0.0; 9]),
        (2.0, 0.1),
    )
    .expect("bodies with joints");
    check_system::<1>(&suite, &mut bead(2.0), (&[1.0], &[0.0]), (10.0, 0.1)).expect("a bead");
    check_system::<1>(&suite, &mut Ring::new(2.0, 1.0), (&[0.6, 0.8], &[1.0]), (10.0, 0.1)).expect("a ring");
    let members: Vec<(&str, Box<dyn System<f64, 1>>)> = vec![
        ("bead", Box::new(bead(1.0))),
        ("ring", Box::new(Ring::new(1.0, 1.0))),
        ("other", Box::new(bead(2.0))),
    ];
    let mut assembly = Assembly::new(members).expect("three members");
    check_system::<1>(&suite, &mut assembly, (&[1.0, 0.6, 0.8, 1.0], &[0.0; 3]), (10.0, 0.1))
        .expect("an assembly");
}

#[test]
fn rows_along_every_relative_coordinate_are_discrete_derivatives_and_gaps_of_every_shape_have_their_rows() {
    let mut builder = RigidBodies::<f64>::builder();
    let (moving, still) = (builder.group(), builder.group());
    let body = Body { mass: 1.0, inertia: 0.2 };
    let one = builder.body("one", body).expect("positive");
    let other = builder.body("other", body).expect("positive");
    builder.disc("disc", one, [0.1, 0.05], 0.1, moving).expect("a disc");
    let square = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]];
    builder.polygon("square", other, &square, moving).expect("convex");
    let motion = [(0.3, Signal::Constant), (0.0, Signal::Constant), (0.2, Signal::Constant)];
    let mover = builder.moved_body("mover", [0.0, -1.5, 0.0], motion).expect("finite");
    builder.half_plane_of("plane", mover, [0.0, 0.1], [0.2, 1.0], still).expect("a plane");
    builder
        .arc("hump", mover, ([0.0, 0.2], 0.3), RoundSide::Outside, Some([0.0, 3.0]), still)
        .expect("an arc");
    builder.arc("bowl", BodyId::GROUND, ([0.0; 2], 2.0), RoundSide::Inside, None, still).expect("a circle");
    builder
        .chain("line", BodyId::GROUND, &[[-3.0, -2.0], [0.0, -1.8], [3.0, -2.0]], false, still)
        .expect("a chain");
    builder.interface(moving, still).expect("groups");
    let (at, on, axis) = ([0.3, -0.2], [-0.1, 0.4], [1.0, 0.7]);
    for (name, to) in [("ground", None), ("other", Some(other)), ("mover", Some(mover))] {
        for relative in [Relative::Distance { at, on }, Relative::Along { at, on, axis }, Relative::Angle] {
            builder.spring_between(name, (one, to), relative, (3.0, 0.1), 0.2).expect("finite");
            builder.limit(name, (one, to), relative, [-5.0, 5.0]).expect("in order");
        }
    }
    let mut system = builder.build().expect("bodies");
    let q = [0.3, 0.1, 0.4, -0.7, 0.2, 1.3, 0.3, -1.5, 0.2];
    check_system::<2>(&Suite::default(), &mut system, (&q, &[0.0; 9]), (20.0, 0.1)).expect("a mechanism");
}

#[test]
fn a_system_that_contradicts_itself_is_found() {
    #[derive(Debug)]
    struct Wrong(Ring);
    impl Dynamics<f64> for Wrong {
        fn coordinates(&self) -> usize {
            2
        }
        fn advance(&self, q: &[f64], s: &[f64], out: &mut [f64]) {
            self.0.advance(q, s, out);
        }
        fn difference(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
            self.0.difference(from, to, out);
        }
        fn mass(&self) -> &Symmetric<f64> {
            self.0.mass()
        }
        fn forces(&self) -> &Forces<f64> {
            self.0.forces()
        }
        fn potential(&self, q: &[f64]) -> f64 {
            q[0]
        }
        fn scales(&self, q: &[f64], v: &[f64]) -> Scales<f64> {
            self.0.scales(q, v)
        }
    }
    impl Contacts<f64, 1> for Wrong {}
    impl Describe<f64> for Wrong {}
    let failure = check_system::<1>(
        &Suite::default(),
        &mut Wrong(Ring::new(1.0, 1.0)),
        (&[0.6, 0.8], &[1.0]),
        (1.0, 0.1),
    )
    .expect_err("a potential without a force");
    assert!(failure.to_string().contains("potential"), "{failure}");
}

/// Two beads in one system, and the same two as members of an assembly, take the same steps to the last bit.
#[test]
fn an_assembly_moves_as_one_system_does() {
    let members: Vec<(&str, Box<dyn System<f64, 1>>)> =
        vec![("light", Box::new(bead(1.0))), ("heavy", Box::new(bead(3.0)))];
    let assembly = Assembly::new(members).expect("two members");
    let mut one = Lagrangian::<f64, 1>::new(mass(&[1.0, 3.0]));
    one = one.with_forces(Forces::constant(vec![-9.81, -9.81 * 3.0])).expect("two forces");
    for dof in 0..2 {
        let gap = SmoothGap::new(
            move |q: &[f64]| q[dof],
            move |_: &[f64], push: &mut dyn FnMut(usize, SVector<f64, 1>)| {
                push(dof, SVector::<f64, 1>::new(1.0));
            },
        );
        one = one.with_contact(dof, gap);
    }
    let start = (&[1.0, 0.7][..], &[0.0, 0.3][..]);
    let (mut together, mut apart) =
        (scheme(Box::new(one), 0.5, start, 1e-3), scheme(Box::new(assembly), 0.5, start, 1e-3));
    for _ in 0..3000 {
        together.step().expect("beads");
        apart.step().expect("beads");
        assert_eq!(together.state(), apart.state());
        assert_eq!(together.last_step().balance, apart.last_step().balance);
    }
    assert_eq!(apart.system().dof_label(1), "heavy.q0");
    let contact = apart.last_step().contacts.last().expect("at rest on the floor").id;
    assert_eq!(apart.system().contact_label(contact), "heavy.0");
}

/// A contact across two members: equal beads exchange their velocities, whatever system each is.
#[test]
fn members_touch_each_other() {
    let free = || Box::new(Lagrangian::<f64, 1>::new(mass(&[1.0])).with_scales(1.0, 1.0));
    let mut across = SmoothContacts::default();
    across.push(
        0,
        SmoothGap::new(
            |q: &[f64]| q[1] - q[0],
            |_: &[f64], push: &mut dyn FnMut(usize, SVector<f64, 1>)| {
                push(0, SVector::<f64, 1>::new(-1.0));
                push(1, SVector::<f64, 1>::new(1.0));
            },
        ),
    );
    let members: Vec<(&str, Box<dyn System<f64, 1>>)> = vec![("left", free()), ("right", free())];
    let pair = Assembly::new(members).expect("two members").with_contacts_across(across);
    let mut scheme = scheme(Box::new(pair), 1.0, (&[0.0, 1.0], &[1.0, 0.0]), 1e-3);
    for _ in 0..2000 {
        scheme.step().expect("two beads");
    }
    // Exact but for the tolerance of one contact's exact solution.
    let v = &scheme.state().v;
    assert!((v[0].abs()).max((v[1] - 1.0).abs()) <= 8.0 * f64::EPSILON, "{v:?}");
}

/// Where q is no velocity, it moves by `advance` alone: a bead on a ring never leaves it, bounces off its stop with
/// exactly the speed it came with, and keeps its energy, under steps of one length and under error control.
#[test]
fn a_bead_stays_on_its_ring() {
    let rate = |scheme: &ThetaScheme<f64, 1>| scheme.state().v[0];
    let start = (&[0.6, 0.8][..], &[-2.0][..]);
    let mut fixed = scheme(Box::new(Ring::new(1.5, 1.0)), 1.0, start, 1e-3);
    let mut bounces = 0;
    for _ in 0..20_000 {
        let before = rate(&fixed);
        let step = fixed.step().expect("a bead");
        assert!(step.balance.imbalance.abs() <= 1e-14 * step.energies.total());
        bounces += usize::from(rate(&fixed) != before);
        let q = &fixed.state().q;
        // A rotation a step, each rounded: √k ε would do, k ε bounds it.
        assert!((q[0].hypot(q[1]) - 1.0).abs() <= 20_000.0 * f64::EPSILON, "{q:?}");
        assert!((rate(&fixed).abs() - 2.0).abs() <= 1e-14 * 2.0 * (bounces + 1) as f64);
    }
    // 40 rad: the first at 0.927 rad, then one every π.
    assert_eq!(bounces, 13);

    let start = scheme(Box::new(Ring::new(1.5, 1.0)), 1.0, start, 1e-3);
    let mut driver = Adaptive::new(start, AdaptiveSettings::new(1e-6, 5.0)).expect("in range");
    let ended = driver
        .advance_to(5.0, |_, _, _| ControlFlow::<()>::Continue(()))
        .expect("a bead under error control");
    assert!(ended.is_continue());
    // 10 rad from atan2(0.8, 0.6) down to 0 and up: at 9.0727 rad above it folded by π.
    let angle = f64::atan2(driver.scheme().state().q[1], driver.scheme().state().q[0]);
    let gone = 10.0 - f64::atan2(0.8, 0.6);
    let turns = (gone / std::f64::consts::PI).floor();
    let rest = gone - turns * std::f64::consts::PI;
    let expected = if (turns as usize).is_multiple_of(2) { rest } else { std::f64::consts::PI - rest };
    assert!((angle - expected).abs() <= 1e-5, "{angle} for {expected}");
}

/// A checkpoint and the tables hold q and v as they are, each of its own length.
#[test]
fn outputs_and_checkpoints_tell_coordinates_from_velocities() {
    let start = (&[0.6, 0.8][..], &[-2.0][..]);
    let ring = || scheme(Box::new(Ring::new(1.5, 1.0)), 0.5, start, 1e-3);
    let mut through = ring();
    (0..700).for_each(|_| drop(through.step().expect("a bead").clone()));
    let mut resumed = ring();
    resumed.restore(&through.snapshot()).expect("a snapshot of this scheme");
    assert_eq!(through.state(), resumed.state());
    for _ in 0..2000 {
        through.step().expect("a bead");
        resumed.step().expect("a bead");
        assert_eq!(through.state(), resumed.state());
    }

    let folder = tempfile::tempdir().expect("a folder");
    let rates = Rates { trajectory: 1, contacts: 1, energy: 1 };
    let mut tables = CsvFiles::create(folder.path(), rates).expect("tables");
    let law = through.laws()[0].name().to_string();
    let run = RunInfo::new("newton", "hybrid", vec![law], through.settings());
    let frame = Frame { system: through.system(), state: through.state(), step: through.last_step() };
    tables.begin(&run, frame).expect("a header and a row");
    tables.commit().expect("written");
    let text = std::fs::read_to_string(folder.path().join("trajectory.csv")).expect("a table");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let (header, row) = (lines.next().expect("a header"), lines.next().expect("a row"));
    assert!(header.ends_with(&["x", "y", "v.rate"]), "{header:?}");
    assert_eq!(header.len(), row.len());
}

#[test]
fn what_cannot_be_assembled_is_refused_by_name() {
    #[derive(Debug)]
    struct Stiff(Ring, Symmetric<f64>);
    impl Dynamics<f64> for Stiff {
        fn coordinates(&self) -> usize {
            2
        }
        fn mass(&self) -> &Symmetric<f64> {
            self.0.mass()
        }
        fn stiffness(&self) -> Option<&Symmetric<f64>> {
            Some(&self.1)
        }
        fn forces(&self) -> &Forces<f64> {
            self.0.forces()
        }
        fn scales(&self, q: &[f64], v: &[f64]) -> Scales<f64> {
            self.0.scales(q, v)
        }
    }
    impl Contacts<f64, 1> for Stiff {}
    impl Describe<f64> for Stiff {}
    let solver = solver::build("hybrid", Stopping::default()).expect("registered");
    let system = Box::new(Stiff(Ring::new(1.0, 1.0), mass(&[1.0])));
    let error = ThetaScheme::<f64, 1>::new(
        system,
        vec![],
        solver,
        Settings::new(0.5, 1e-3),
        0.0,
        vec![1.0, 0.0],
        vec![0.0],
    )
    .expect_err("K q has no meaning");
    assert_eq!(error, SetupError::Curved { what: "stiffness" });
    let none: Vec<(String, Box<dyn System<f64, 1>>)> = (0..=ContactId::MOST_MEMBERS)
        .map(|i| -> (String, Box<dyn System<f64, 1>>) { (i.to_string(), Box::new(bead(1.0))) })
        .collect();
    assert!(matches!(Assembly::new(none), Err(AssemblyError::TooMany { .. })));
}
