//! The library under bad input: every refusal is a typed error with what was wrong and its value, and no panic.

use nalgebra::{DMatrix, SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem, ProblemError};
use nonsmooth::laws::{self, Approach, ContactLaw, Fremond, LawError, NewtonCoulomb, Response};
use nonsmooth::linalg::{FactorError, OperatorError, Symmetric};
use nonsmooth::scheme::{Activation, Settings, SetupError, StepError, ThetaScheme};
use nonsmooth::solver::{self, SOLVERS, SolveError, Stopping, StoppingError, UnknownSolver};
use nonsmooth::system::{Body, Dynamics, Forces, Lagrangian, RigidBodies, Signal, SmoothGap, SystemError};

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

type Block = SMatrix<f64, 2, 2>;
type Local = SVector<f64, 2>;

fn problem(
    block: impl FnMut(usize, usize) -> Block,
    b: Vec<Local>,
    mu: Vec<f64>,
) -> Result<ConeProblem<f64, 2>, ProblemError> {
    ConeProblem::new(BlockMatrix::from_fn(2, block), b, mu)
}

fn identity(i: usize, j: usize) -> Block {
    if i == j { Block::identity() } else { Block::zeros() }
}

fn closing() -> Vec<Local> {
    vec![Local::new(-1.0, 0.3); 2]
}

#[test]
fn a_cone_problem_with_numbers_that_are_not_finite_is_refused() {
    for x in NOT_FINITE {
        let w = |i, j| if (i, j) == (1, 1) { Block::new(1.0, x, x, 1.0) } else { identity(i, j) };
        let error = problem(w, closing(), vec![0.5; 2]).expect_err("W");
        assert_eq!(error, ProblemError::NotFinite { what: "W", contact: 1 });
        let b = vec![Local::zeros(), Local::new(0.0, x)];
        let error = problem(identity, b, vec![0.5; 2]).expect_err("b");
        assert_eq!(error, ProblemError::NotFinite { what: "b", contact: 1 });
        let error = problem(identity, closing(), vec![x, 0.5]).expect_err("μ");
        assert_eq!(error, ProblemError::NotFinite { what: "μ", contact: 0 });
    }
}

#[test]
fn a_cone_problem_that_is_none_is_refused() {
    let error = problem(identity, closing(), vec![0.5, -0.25]).expect_err("μ < 0");
    assert_eq!(error, ProblemError::NegativeFriction { contact: 1, value: -0.25 });
    let error = problem(identity, vec![Local::zeros(); 3], vec![0.5; 2]).expect_err("sizes");
    assert_eq!(error, ProblemError::Sizes { rows: 2, b: 3, cones: 2 });
    let skew = |i, j| if i < j { Block::identity() * 0.5 } else { identity(i, j) };
    let error = problem(skew, closing(), vec![0.5; 2]).expect_err("asymmetric");
    assert!(
        matches!(error, ProblemError::NotSymmetric { difference, .. } if (difference - 0.5).abs() < 1e-12)
    );
    let indefinite = |i, j| if i == j { Block::identity() } else { Block::identity() * 2.0 };
    let error = problem(indefinite, closing(), vec![0.5; 2]).expect_err("indefinite");
    assert!(matches!(error, ProblemError::Indefinite { smallest, .. } if (smallest + 1.0).abs() < 1e-12));
    let stuck = |i, j| if (i, j) == (0, 0) { Block::zeros() } else { identity(i, j) };
    let error = problem(stuck, closing(), vec![0.5; 2]).expect_err("immobile");
    assert_eq!(error, ProblemError::NoMobility { contact: 0, normal: 0.0 });
    let mut beyond = BlockMatrix::new();
    beyond.start_row();
    beyond.push(0, Block::identity());
    beyond.push(7, Block::identity());
    let error = ConeProblem::new(beyond, vec![Local::zeros()], vec![0.5]).expect_err("column");
    assert_eq!(error, ProblemError::Column { row: 0, column: 7, rows: 1 });
}

#[test]
fn every_solver_checks_the_problem_and_the_shapes() {
    let zeros = vec![Local::zeros(); 2];
    let good = problem(identity, closing(), vec![0.5; 2]).expect("valid");
    for description in SOLVERS {
        let name = description.name;
        let mut solver = solver::build::<f64, 2>(name, Stopping::default()).expect("registered");
        let mut short = vec![Local::zeros(); 1];
        let error = solver.solve(&good, &zeros, &mut short).expect_err("short");
        assert_eq!(error, SolveError::Shape { contacts: 2, given: 1 }, "{name}");
        let error = solver.solve(&good, &short, &mut zeros.clone()).expect_err("short");
        assert_eq!(error, SolveError::Shape { contacts: 2, given: 1 }, "{name}");
        for x in NOT_FINITE {
            let mut bad = good.clone();
            bad.parts_mut().1[1][0] = x;
            let error = solver.solve(&bad, &zeros, &mut zeros.clone()).expect_err("b");
            let expected = ProblemError::NotFinite { what: "b", contact: 1 };
            assert_eq!(error, SolveError::Problem(expected), "{name}");
            // A start that is not finite is a cold start.
            let mut r = zeros.clone();
            let start = [Local::new(x, x); 2];
            solver.solve(&good, &start, &mut r).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!((r[0][0] - 1.0).abs() < 1e-9, "{name}: {r:?}");
        }
        // Numbers at the ends of the range: an answer or an error, never a panic or a NaN taken for a solution.
        for scale in [1e-300, 1e-160, 1e160, 1e300] {
            let w = |i, j| identity(i, j) * scale;
            let Ok(extreme) = problem(w, closing(), vec![0.5; 2]) else { continue };
            let mut r = zeros.clone();
            if let Ok(solution) = solver.solve(&extreme, &zeros, &mut r) {
                assert!(solution.residual.scaled <= 1e-10, "{name}");
            }
        }
    }
}

#[test]
fn a_stopping_rule_out_of_range_is_refused() {
    for value in [0.0, -1e-10, f64::NAN, f64::INFINITY] {
        let error = solver::build::<f64, 2>("nsgs", Stopping::to(value)).expect_err("tolerance");
        let UnknownSolver::Stopping(StoppingError::Tolerance { value: told }) = error else {
            panic!("{error}")
        };
        assert_eq!(told.to_bits(), value.to_bits());
    }
    for value in [0.0, -1.0, f64::NAN] {
        let stopping = Stopping { max_seconds: Some(value), ..Stopping::<f64>::default() };
        let error = solver::build::<f64, 2>("nsgs", stopping).expect_err("seconds");
        assert!(matches!(error, UnknownSolver::Stopping(StoppingError::Seconds { .. })), "{error}");
    }
    let error = solver::build::<f64, 2>("simplex", Stopping::default()).expect_err("name");
    assert!(error.to_string().contains("`simplex`") && error.to_string().contains("hybrid"), "{error}");
}

#[test]
fn laws_refuse_parameters_out_of_range() {
    for law in laws::LAWS {
        for (i, parameter) in law.parameters.iter().enumerate() {
            let beyond = if parameter.max.is_finite() { parameter.max + 1.0 } else { f64::INFINITY };
            for value in NOT_FINITE.into_iter().chain([parameter.min - 1.0, beyond]) {
                let mut values = law.draw(&[0.5; 8]);
                values[i] = value;
                let error = laws::build::<f64, 2>(law.name, &values).expect_err("out of range");
                let LawError::OutOfRange { law: name, parameter: told, value: shown, .. } = error else {
                    panic!("{error}")
                };
                assert_eq!((name, told, shown.to_bits()), (law.name, parameter.name, value.to_bits()));
            }
        }
        let error = laws::build::<f64, 2>(law.name, &[]).expect_err("no values");
        assert!(matches!(error, LawError::ParameterCount { given: 0, .. }));
    }
    assert!(matches!(laws::build::<f64, 2>("nwton", &[]), Err(LawError::UnknownLaw { .. })));
}

#[test]
fn operators_refuse_what_is_not_symmetric_or_not_finite() {
    for x in NOT_FINITE {
        let error = Symmetric::diagonal(vec![1.0, x]).expect_err("diagonal");
        assert_eq!(error, OperatorError::NotFinite { row: 1, column: 1 });
        let error = Symmetric::dense(DMatrix::from_row_slice(2, 2, &[1.0, x, x, 1.0])).expect_err("dense");
        assert!(matches!(error, OperatorError::NotFinite { .. }));
        let error = Symmetric::sparse(2, &[(0, 0, 1.0), (1, 1, x)]).expect_err("sparse");
        assert_eq!(error, OperatorError::NotFinite { row: 1, column: 1 });
    }
    let skew = DMatrix::from_row_slice(2, 2, &[1.0, 0.25, 0.0, 1.0]);
    let error = Symmetric::dense(skew).expect_err("asymmetric");
    assert!(matches!(error, OperatorError::NotSymmetric { difference, .. } if difference.abs() == 0.25));
    let error = Symmetric::sparse(2, &[(0, 0, 1.0), (1, 1, 1.0), (0, 1, 0.25)]).expect_err("asymmetric");
    assert!(matches!(error, OperatorError::NotSymmetric { .. }));
    assert!(matches!(Symmetric::<f64>::dense(DMatrix::zeros(2, 3)), Err(OperatorError::NotSquare { .. })));
    assert!(matches!(Symmetric::sparse(2, &[(2, 0, 1.0)]), Err(OperatorError::OutOfBounds { row: 2, .. })));
}

type Scheme = ThetaScheme<f64, 2>;

fn mass(entries: &[f64]) -> Symmetric<f64> {
    Symmetric::Diagonal(entries.to_vec())
}

fn law() -> Fremond<f64> {
    Fremond::new(0.5, 0.3).expect("in range")
}

/// Two degrees of freedom, normal and tangential; one contact closes with the first.
fn particle(gap: impl Fn(&[f64]) -> f64 + Send + Sync + 'static) -> Lagrangian<f64, 2> {
    touching(gap, |_, push| {
        push(0, Local::new(1.0, 0.0));
        push(1, Local::new(0.0, 1.0));
    })
}

fn touching(
    gap: impl Fn(&[f64]) -> f64 + Send + Sync + 'static,
    row: impl Fn(&[f64], &mut dyn FnMut(usize, Local)) + Send + Sync + 'static,
) -> Lagrangian<f64, 2> {
    Lagrangian::new(mass(&[1.0, 1.0])).with_contact(0, SmoothGap::new(gap, row))
}

fn scheme(
    system: Lagrangian<f64, 2>,
    settings: Settings<f64>,
    q: &[f64],
    v: &[f64],
) -> Result<Scheme, SetupError> {
    let solver = solver::build("nsgs", Stopping::default()).expect("registered");
    ThetaScheme::new(Box::new(system), vec![Box::new(law())], solver, settings, 0.0, q.to_vec(), v.to_vec())
}

fn settings() -> Settings<f64> {
    Settings::new(0.5, 1e-3)
}

#[test]
fn the_scheme_refuses_settings_out_of_range() {
    let start = |settings| scheme(particle(|q| q[0]), settings, &[0.0; 2], &[0.0; 2]).expect_err("refused");
    for theta in [f64::NAN, f64::INFINITY, -1e-9, 1.0 + 1e-9] {
        let SetupError::Theta { theta: told } = start(Settings::new(theta, 1e-3)) else {
            panic!("θ = {theta}")
        };
        assert_eq!(told.to_bits(), theta.to_bits());
    }
    let error = start(Settings::new(0.9, 1e-3));
    assert!(matches!(error, SetupError::UnprovedTheta { theta: 0.9, .. }), "{error}");
    let message = error.to_string();
    assert!(message.contains("fremond") && message.contains("0.9") && message.contains("0.5"), "{message}");
    for step in [f64::NAN, f64::INFINITY, 0.0, -1e-3] {
        assert!(matches!(start(Settings::new(0.5, step)), SetupError::TimeStep { .. }), "h = {step}");
    }
    // 1e-18 is below the rounding of the positions, and below what the solver leaves of velocities.
    for value in [f64::NAN, f64::INFINITY, 0.0, -1.0, 1e-18] {
        let gap = Activation { gap_tolerance: Some(value), ..Activation::default() };
        let velocity = Activation { velocity_tolerance: Some(value), ..Activation::default() };
        for (activation, name) in [(gap, "gap"), (velocity, "velocity")] {
            let error = start(Settings { activation, ..settings() });
            assert!(matches!(error, SetupError::ActivationTolerance { what, .. } if what == name), "{error}");
        }
    }
}

#[test]
fn the_scheme_refuses_states_and_sizes_that_are_wrong() {
    for x in NOT_FINITE {
        let error = scheme(particle(|q| q[0]), settings(), &[0.0, x], &[0.0; 2]).expect_err("q");
        assert!(matches!(error, SetupError::NotFinite { what: "q", component: 1, .. }), "{error}");
        assert!(error.to_string().contains(&x.to_string()), "{error}");
        let error = scheme(particle(|q| q[0]), settings(), &[0.0; 2], &[x, 0.0]).expect_err("v");
        assert!(matches!(error, SetupError::NotFinite { what: "v", component: 0, .. }), "{error}");
    }
    let error = scheme(particle(|q| q[0]), settings(), &[0.0; 3], &[0.0; 2]).expect_err("size");
    assert_eq!(error, SetupError::Size { what: "q", expected: 2, given: 3 });
    let error = scheme(particle(|q| q[0]), settings(), &[0.0; 2], &[1e200, 0.0]).expect_err("energy");
    assert!(matches!(error, SetupError::Energy { .. }), "{error}");
    let solver = solver::build::<f64, 2>("nsgs", Stopping::default()).expect("registered");
    let none = Vec::new();
    let error = ThetaScheme::new(
        Box::new(particle(|q| q[0])),
        none,
        solver,
        settings(),
        0.0,
        vec![0.0; 2],
        vec![0.0; 2],
    );
    assert_eq!(error.expect_err("laws"), SetupError::Laws { interfaces: 1, laws: 0 });
    // An interface beyond every count of laws.
    let far =
        Lagrangian::<f64, 2>::new(mass(&[1.0])).with_contact(usize::MAX, SmoothGap::new(|q| q[0], |_, _| {}));
    assert!(matches!(scheme(far, settings(), &[0.0], &[0.0]), Err(SetupError::Laws { .. })));
}

#[test]
fn the_scheme_refuses_a_mass_that_is_not_positive_definite() {
    for entries in [[1.0, 0.0], [1.0, -1.0], [1.0, f64::NAN], [1.0, f64::INFINITY], [1.0, 1e-310]] {
        let error = scheme(Lagrangian::new(mass(&entries)), settings(), &[0.0; 2], &[0.0; 2]);
        // Without contacts there is no interface, and so one law too many; the mass is what is wrong first.
        assert!(error.is_err(), "{entries:?}");
        let system =
            Lagrangian::<f64, 2>::new(mass(&entries)).with_contact(0, SmoothGap::new(|q| q[0], |_, _| {}));
        let error = scheme(system, settings(), &[0.0; 2], &[0.0; 2]).expect_err("mass");
        assert_eq!(error, SetupError::Mass(FactorError::NotPositiveDefinite { pivot: 1 }), "{entries:?}");
    }
    let indefinite = [1.0, 2.0, 2.0, 1.0];
    let dense = Symmetric::dense(DMatrix::from_row_slice(2, 2, &indefinite)).expect("symmetric");
    let triplets = [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 2.0), (1, 0, 2.0)];
    let sparse = Symmetric::sparse(2, &triplets).expect("symmetric");
    for operator in [dense, sparse] {
        let system =
            Lagrangian::<f64, 2>::new(operator.clone()).with_contact(0, SmoothGap::new(|q| q[0], |_, _| {}));
        let error = scheme(system, settings(), &[0.0; 2], &[0.0; 2]).expect_err("mass");
        assert!(matches!(error, SetupError::Mass(FactorError::NotPositiveDefinite { .. })), "{error}");
        // A stiffness so negative that M + h²θ²K is not positive definite.
        let soft = Lagrangian::<f64, 2>::new(mass(&[1e-9; 2])).with_stiffness(operator).expect("size");
        let soft = soft.with_contact(0, SmoothGap::new(|q| q[0], |_, _| {}));
        let error = scheme(soft, settings(), &[0.0; 2], &[0.0; 2]).expect_err("iteration matrix");
        assert!(matches!(error, SetupError::IterationMatrix(_)), "{error}");
    }
}

#[test]
fn systems_refuse_wrong_sizes_and_numbers() {
    let two = || Lagrangian::<f64, 2>::new(mass(&[1.0, 1.0]));
    assert!(matches!(
        two().with_damping(mass(&[1.0])),
        Err(SystemError::Size { what: "damping", given: 1, .. })
    ));
    assert!(matches!(two().with_stiffness(mass(&[1.0; 3])), Err(SystemError::Size { given: 3, .. })));
    assert!(matches!(two().with_forces(Forces::constant(vec![0.0])), Err(SystemError::Size { .. })));
    for x in NOT_FINITE {
        let error = two().with_forces(Forces::constant(vec![0.0, x])).expect_err("force");
        assert!(error.to_string().contains(&x.to_string()), "{error}");
        let mut builder = RigidBodies::<f64>::builder();
        assert!(builder.body("b", Body { mass: x, inertia: 1.0 }).is_err());
        assert!(builder.body("b", Body { mass: 1.0, inertia: x }).is_err());
        let body = builder.body("b", Body { mass: 1.0, inertia: 1.0 }).expect("valid");
        let group = builder.group();
        assert!(builder.force(body, [x, 0.0], 0.0).is_err());
        assert!(builder.force(body, [0.0; 2], x).is_err());
        assert!(builder.gravity([0.0, x]).is_err());
        assert!(builder.disc("d", body, [x, 0.0], 0.1, group).is_err());
        assert!(builder.disc("d", body, [0.0; 2], x, group).is_err());
        assert!(builder.half_plane("p", [0.0, x], [0.0, 1.0], group).is_err());
        assert!(builder.half_plane("p", [0.0; 2], [x, 1.0], group).is_err());
    }
    let mut builder = RigidBodies::<f64>::builder();
    assert!(matches!(builder.clone().build(), Err(SystemError::Size { .. })));
    for bad in [0.0, -2.0] {
        let error = builder.body("b", Body { mass: bad, inertia: 1.0 }).expect_err("mass");
        assert_eq!(error.to_string(), format!("mass of `b` is {bad}, it must be finite and > 0"));
    }
}

/// The step fails with an error that says every one of `says`, and the state is that of before it.
fn assert_step_fails(scheme: &mut Scheme, says: &[&str]) -> StepError {
    let before = scheme.state().clone();
    let error = scheme.step().map(|_| ()).expect_err("the step must fail");
    let message = error.to_string();
    says.iter().for_each(|part| assert!(message.contains(part), "`{part}` is missing in: {message}"));
    assert_eq!(*scheme.state(), before, "a failed step changed the state");
    error
}

#[test]
fn a_gap_or_a_jacobian_that_is_not_finite_stops_the_step() {
    for x in [f64::NAN, f64::NEG_INFINITY] {
        let mut scheme = scheme(particle(move |_| x), settings(), &[0.0; 2], &[0.0; 2]).expect("valid");
        assert_step_fails(&mut scheme, &["step 1", "gap of contact 0", "finite"]);
    }
    for x in NOT_FINITE {
        let system = touching(|_| -1.0, move |_, push| push(0, Local::new(x, 0.0)));
        let mut scheme = scheme(system, settings(), &[0.0; 2], &[-1.0, 0.0]).expect("valid");
        assert_step_fails(&mut scheme, &["step 1", "Jacobian of contact 0", "finite"]);
    }
    let system = touching(|_| -1.0, |_, push| push(5, Local::new(1.0, 0.0)));
    let mut beyond = scheme(system, settings(), &[0.0; 2], &[-1.0, 0.0]).expect("valid");
    let error = assert_step_fails(&mut beyond, &["contact 0", "degree of freedom 5", "2"]);
    assert!(matches!(error, StepError::Unknown { index: 5, count: 2, .. }));
    let mut empty =
        scheme(touching(|_| -1.0, |_, _| {}), settings(), &[0.0; 2], &[-1.0, 0.0]).expect("valid");
    assert_step_fails(&mut empty, &["contact 0", "W_NN = 0"]);
}

#[test]
fn a_force_or_a_state_that_overflows_stops_the_step() {
    for x in NOT_FINITE {
        let forces = Forces::constant(vec![0.0; 2]).with_varying(move |_, f: &mut [f64]| f[1] = x);
        let system = particle(|q| q[0]).with_forces(forces).expect("size");
        let mut scheme = scheme(system, settings(), &[1.0; 2], &[0.0; 2]).expect("valid");
        assert_step_fails(&mut scheme, &["step 1", "F[1]", &x.to_string()]);
    }
    let pull = Forces::constant(vec![1e308, 0.0]);
    let system = particle(|q| q[0]).with_forces(pull).expect("size");
    let mut scheme = scheme(system, Settings::new(0.5, 1e3), &[1.0; 2], &[0.0; 2]).expect("valid");
    assert_step_fails(&mut scheme, &["step 1", "inf"]);
}

/// A law that gives whatever it is told.
#[derive(Debug)]
struct Any {
    friction: f64,
    gamma: f64,
    shift: f64,
}

impl ContactLaw<f64, 2> for Any {
    fn name(&self) -> &str {
        "any"
    }
    fn respond(&self, at: &Approach<f64, 2>) -> Response<f64, 2> {
        let shift = if at.before[0] < 0.0 { Local::new(self.shift, 0.0) } else { Local::zeros() };
        Response::new(self.gamma, shift, self.friction)
    }
}

#[test]
fn a_law_of_the_user_that_gives_no_problem_is_refused() {
    let start = |law: Any| {
        let solver = solver::build::<f64, 2>("nsgs", Stopping::default()).expect("registered");
        ThetaScheme::new(
            Box::new(particle(|q| q[0])),
            vec![Box::new(law)],
            solver,
            settings(),
            0.0,
            vec![0.0; 2],
            vec![-1.0, 0.0],
        )
    };
    for friction in [f64::NAN, f64::INFINITY, -0.5] {
        let error = start(Any { friction, gamma: 1.0, shift: 0.0 }).expect_err("μ");
        assert!(matches!(error, SetupError::Law { what: "μ", .. }), "{error}");
        assert!(error.to_string().contains("`any`") && error.to_string().contains(&friction.to_string()));
    }
    for gamma in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        let error = start(Any { friction: 0.5, gamma, shift: 0.0 }).expect_err("γ");
        assert!(matches!(error, SetupError::Law { what: "γ", .. }), "{error}");
    }
    for shift in NOT_FINITE {
        let mut scheme = start(Any { friction: 0.5, gamma: 1.0, shift }).expect("valid at rest");
        let error = scheme.step().map(|_| ()).expect_err("shift");
        assert!(matches!(error, StepError::Law { .. }), "{error}");
        assert!(error.to_string().contains(&shift.to_string()), "{error}");
    }
    assert!(NewtonCoulomb::new(-0.1, 0.5).is_err() && NewtonCoulomb::new(0.5, f64::NAN).is_err());
}

#[test]
fn springs_dampers_and_loads_refuse_numbers_out_of_range() {
    let mut builder = RigidBodies::<f64>::builder();
    let body = builder.body("ball", Body { mass: 1.0, inertia: 1.0 }).expect("positive");
    for x in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = |result| matches!(result, Err(SystemError::OutOfRange { .. }));
        assert!(refused(builder.spring(body, [0.0, x, 0.0])) && refused(builder.damper(body, [0.0, 0.0, x])));
        let sine = Signal::Sine { frequency: x, phase: 0.0 };
        assert!(refused(builder.load(body, [1.0, 0.0], 0.0, sine)), "a frequency of {x}");
        if !x.is_finite() {
            assert!(refused(builder.load(body, [x, 0.0], 0.0, Signal::Ramp { start: 0.0, end: 1.0 })));
        }
    }
    // What was refused left nothing behind.
    let system = builder.build().expect("a body");
    assert!(Dynamics::stiffness(&system).is_none());
    assert!(Dynamics::damping(&system).is_none());
    assert!(!Dynamics::forces(&system).varies());
}
