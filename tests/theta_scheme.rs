//! What the θ-scheme guarantees for any system, law and solver: energy without contact, the balance (56), the sign of
//! the contact work, the claimed interval of θ, and the active set on curved obstacles.

#[path = "mechanics/random_lagrangian.rs"]
mod random_lagrangian;
#[path = "mechanics/stream.rs"]
mod stream;

use nonsmooth::laws::{self, ContactLaw, Description, LAWS};
use nonsmooth::scheme::{Settings, SetupError, StepError, ThetaScheme};
use nonsmooth::solver::{self, SOLVERS, SolveError, Stopping};
use nonsmooth::system::Lagrangian;
use random_lagrangian::{RandomLagrangian, Storage};
use stream::Stream;

type Law<const D: usize> = Box<dyn ContactLaw<f64, D>>;
type Scheme<const D: usize> = ThetaScheme<f64, D>;

/// Accuracy asked of the solvers, on the scaled residual.
const TOLERANCE: f64 = 1e-12;

fn scheme<const D: usize>(
    system: Lagrangian<f64, D>,
    laws: Vec<Law<D>>,
    solver: &str,
    settings: Settings<f64>,
    state: &RandomLagrangian<D>,
) -> Result<Scheme<D>, SetupError> {
    let solver = solver::build(solver, Stopping::to(TOLERANCE)).expect("a registered solver");
    ThetaScheme::new(Box::new(system), laws, solver, settings, 0.0, state.q.clone(), state.v.clone())
}

fn free(stream: &mut Stream, storage: Storage, theta: f64) -> Scheme<1> {
    let state = RandomLagrangian::<1>::draw(stream, 6, 0, storage == Storage::Diagonal);
    let settings = Settings::new(theta, 0.02);
    scheme(state.conservative(storage), Vec::new(), "nsgs", settings, &state).expect("a free system")
}

const STORAGES: [Storage; 3] = [Storage::Diagonal, Storage::Dense, Storage::Sparse];

#[test]
fn without_contact_the_midpoint_conserves_energy() {
    const STEPS: usize = 5000;
    let mut stream = Stream(1);
    for storage in STORAGES {
        let mut free = free(&mut stream, storage, 0.5);
        let start = free.last_step().energies.mechanical();
        let exchanged = (0..STEPS).map(|_| free.step().expect("free").energies.elastic).fold(0.0, f64::max);
        assert!(exchanged > 0.1 * start, "{storage:?}: the springs take part");
        let drift = (free.last_step().energies.mechanical() - start).abs();
        // A rounding of ε per operation, six operations per component and step, all of one sign at worst.
        assert!(drift <= 6.0 * STEPS as f64 * f64::EPSILON * start, "{storage:?}: {:e}", drift / start);
    }
}

#[test]
fn without_contact_theta_above_one_half_dissipates_and_below_creates() {
    let mut stream = Stream(2);
    for storage in STORAGES {
        for theta in [0.0, 0.25, 0.49, 0.51, 0.75, 1.0] {
            let mut free = free(&mut stream, storage, theta);
            let mut energy = free.last_step().energies.mechanical();
            for _ in 0..200 {
                let step = free.step().expect("free");
                let next = step.energies.mechanical();
                let change = if theta > 0.5 { energy - next } else { next - energy };
                assert!(change > 0.0, "{storage:?}, θ = {theta}: {energy:e} → {next:e}");
                energy = next;
            }
        }
    }
}

/// Share of its range from which friction is drawn, μ ≤ ½: with more, cone problems of several contacts may be too
/// hard for a solver, which is the matter of the solvers' own tests.
const FRICTION_SHARE: f64 = 0.25;

/// Instances of a registered law, one per interface: the same but for the friction, so that the intervals they claim
/// meet.
fn draw<const D: usize>(description: &Description, stream: &mut Stream, count: usize) -> Vec<Law<D>> {
    let mut unit: Vec<f64> = description.parameters.iter().map(|_| stream.uniform(0.0, 1.0)).collect();
    let friction = description.parameters.iter().position(|p| p.name == laws::FRICTION.name);
    let instance = |_| {
        if let Some(friction) = friction {
            unit[friction] = stream.uniform(0.0, FRICTION_SHARE);
        }
        laws::build(description.name, &description.draw(&unit)).expect("parameters drawn in their range")
    };
    (0..count).map(instance).collect()
}

/// θ in the interval all `laws` claim; anywhere in [0, 1] where one claims none. The flag tells whether all claim.
fn draw_theta<const D: usize>(laws: &[Law<D>], stream: &mut Stream) -> (f64, bool) {
    let claims: Option<Vec<_>> = laws.iter().map(|law| law.dissipative_theta()).collect();
    let Some(claims) = claims else { return (stream.uniform(0.0, 1.0), false) };
    let least = claims.iter().map(|c| *c.start()).fold(0.0, f64::max);
    let largest = claims.iter().map(|c| *c.end()).fold(1.0, f64::min);
    (least + stream.uniform(0.0, 1.0) * (largest - least), true)
}

/// What a run of random contacts came to.
struct Checked {
    impulses: usize,
    /// Whether the solver gave up on a problem before the end.
    given_up: bool,
}

/// Steps a scheme, checks (56) and the contact work, and counts the impulses. The default solver may not give up.
fn check_energy<const D: usize>(place: &str, mut scheme: Scheme<D>, claimed: bool, steps: usize) -> Checked {
    let (mut impulses, dofs) = (0, scheme.state().q.len() as f64);
    for _ in 0..steps {
        let before = scheme.last_step().energies.mechanical();
        if let Some(error) = scheme.step().err() {
            let not_solved =
                matches!(error, StepError::Solve { source: SolveError::NotConverged { .. }, .. });
            assert!(not_solved && scheme.solver().name() != solver::DEFAULT, "{place}: {error}");
            return Checked { impulses, given_up: true };
        }
        let step = scheme.last_step();
        let (balance, energy) = (step.balance, before.max(step.energies.mechanical()));
        let mut turned_over = energy + balance.external_work.abs() + balance.numerical_dissipation.abs();
        for contact in &step.contacts {
            let power = contact.percussion.norm() * (contact.before.norm() + contact.after.norm());
            turned_over += power;
            impulses += usize::from(contact.percussion[0] > 0.0);
            // The inclusion holds to the tolerance on w, a velocity, over all contacts: w·p may exceed 0 by that.
            let b = scheme.cone_problem().b_norm();
            let roundoff = 4.0 * TOLERANCE * b * contact.percussion.norm() + 16.0 * f64::EPSILON * power;
            let work = contact.normal_work + contact.tangential_work;
            assert!(!claimed || work <= roundoff, "{place}: contact work {work:e}, round-off {roundoff:e}");
        }
        // n products of n terms, each rounded to ε, against all that is turned over.
        let roundoff = 4.0 * dofs * dofs * f64::EPSILON * turned_over;
        let imbalance = balance.imbalance.abs();
        assert!(imbalance <= roundoff, "{place}: (56) leaves {imbalance:e}, round-off {roundoff:e}");
    }
    Checked { impulses, given_up: false }
}

fn energy_of_random_systems<const D: usize>() {
    const STEPS: usize = 200;
    let mut stream = Stream(D as u64);
    let (mut impulses, mut runs, mut given_up) = (0, 0, 0);
    for description in LAWS {
        for solver in SOLVERS {
            for storage in STORAGES {
                let state = RandomLagrangian::<D>::draw(&mut stream, 6, 4, storage == Storage::Diagonal);
                let laws = draw::<D>(description, &mut stream, 4);
                let (theta, claimed) = draw_theta(&laws, &mut stream);
                let place =
                    format!("{}, {}, D = {D}, θ = {theta}, {storage:?}", description.name, solver.name);
                let settings = Settings::new(theta, 0.01);
                let scheme = scheme(state.system(storage), laws, solver.name, settings, &state);
                let scheme = scheme.unwrap_or_else(|error| panic!("{place}: {error}"));
                let run = check_energy(&place, scheme, claimed, STEPS);
                impulses += run.impulses;
                given_up += usize::from(run.given_up);
                runs += 1;
            }
        }
    }
    assert!(given_up <= runs / 10, "D = {D}: solvers gave up in {given_up} of {runs} runs");
    assert!(impulses > runs * STEPS / 4, "D = {D}: {impulses} impulses in {runs} runs of {STEPS} steps");
}

#[test]
fn the_balance_closes_and_contact_dissipates_without_friction() {
    energy_of_random_systems::<1>();
}

#[test]
fn the_balance_closes_and_contact_dissipates_in_the_plane() {
    energy_of_random_systems::<2>();
}

#[test]
fn the_balance_closes_and_contact_dissipates_in_space() {
    energy_of_random_systems::<3>();
}

/// The states of a run, one after the other.
fn trajectory<const D: usize>(mut scheme: Scheme<D>, steps: usize) -> Vec<f64> {
    let mut states = Vec::new();
    for _ in 0..steps {
        scheme.step().expect("two contacts");
        states.extend(scheme.state().q.iter().chain(&scheme.state().v));
    }
    states
}

fn storages_agree<const D: usize>() {
    const STEPS: usize = 200;
    let mut stream = Stream(10 + D as u64);
    for description in LAWS {
        for diagonal in [true, false] {
            let state = RandomLagrangian::<D>::draw(&mut stream, 6, 2, diagonal);
            let seed = stream.0;
            let run = |&storage: &Storage| {
                let mut stream = Stream(seed);
                let laws = draw::<D>(description, &mut stream, 2);
                let (theta, _) = draw_theta(&laws, &mut stream);
                let settings = Settings::new(theta, 0.01);
                let scheme = scheme(state.system(storage), laws, "nsgs", settings, &state);
                trajectory(scheme.expect("a claimed θ"), STEPS)
            };
            let storages = if diagonal { &STORAGES[..] } else { &STORAGES[1..] };
            let runs: Vec<Vec<f64>> = storages.iter().map(run).collect();
            let far = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let apart = runs[1..].iter().map(|other| far(&runs[0], other)).fold(0.0, f64::max);
            let size = runs[0].iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            // What the solver leaves open in a step; damping and contact keep the steps from adding up.
            assert!(
                apart <= TOLERANCE * size,
                "{}, D = {D}, diagonal: {diagonal}: {apart:e}",
                description.name
            );
        }
    }
}

#[test]
fn the_storage_of_the_matrices_does_not_change_the_motion() {
    storages_agree::<1>();
    storages_agree::<2>();
    storages_agree::<3>();
}

#[test]
fn a_theta_outside_the_claimed_interval_is_refused_by_name_and_accepted_on_request() {
    let mut stream = Stream(20);
    let state = RandomLagrangian::<2>::draw(&mut stream, 6, 3, false);
    let mut refused = 0;
    for description in LAWS {
        for theta in [0.1, 0.3, 0.49, 0.5, 0.51, 0.8, 1.0] {
            let laws = || draw::<2>(description, &mut Stream(21), 3);
            let claim = laws()[0].dissipative_theta();
            let outside = claim.as_ref().is_some_and(|claim| !claim.contains(&theta));
            let mut settings = Settings::new(theta, 0.01);
            let built = scheme(state.system(Storage::Dense), laws(), "nsgs", settings, &state);
            match (built, outside) {
                (Ok(_), false) => (),
                (Err(error), true) => {
                    let (min, max) =
                        claim.map(|claim| (*claim.start(), *claim.end())).expect("outside a claim");
                    let law = description.name.to_string();
                    assert_eq!(error, SetupError::UnprovedTheta { law, interface: 0, theta, min, max });
                    let message = error.to_string();
                    for part in [description.name.into(), format!("θ = {theta}"), format!("[{min}, {max}]")]
                    {
                        assert!(message.contains(&part), "`{message}` names {part}");
                    }
                    refused += 1;
                }
                (built, _) => panic!("{}, θ = {theta}: {:?}", description.name, built.err()),
            }
            settings.allow_unproved_theta = true;
            let place = format!("{}, θ = {theta}, allowed", description.name);
            let allowed = scheme(state.system(Storage::Dense), laws(), "nsgs", settings, &state);
            // The balance does not care for the claim.
            let run = check_energy(&place, allowed.expect("the opt-out accepts any θ"), false, 50);
            assert!(run.impulses > 10, "{place}: {} impulses", run.impulses);
        }
    }
    assert!(refused > LAWS.len(), "{refused} refusals");
}

#[test]
fn one_law_outside_its_interval_is_enough_to_refuse() {
    let state = RandomLagrangian::<3>::draw(&mut Stream(22), 6, 2, false);
    // θ ≤ 1/(1+e): 0.8 suits e = 0.2 at interface 0, not e = 0.6 at interface 1.
    let laws = || [0.2, 0.6].map(|e| laws::build::<f64, 3>("fremond", &[e, 0.3]).expect("in range")).into();
    let refused = scheme(state.system(Storage::Dense), laws(), "nsgs", Settings::new(0.8, 0.01), &state);
    let error = refused.expect_err("θ = 0.8 > 1/1.6");
    let expected = SetupError::UnprovedTheta {
        law: "fremond".into(),
        interface: 1,
        theta: 0.8,
        min: 0.5,
        max: 1.0 / 1.6,
    };
    assert_eq!(error, expected);
    for theta in [-1e-9, 1.0 + 1e-9, f64::NAN, f64::INFINITY] {
        let settings = Settings { allow_unproved_theta: true, ..Settings::new(theta, 0.01) };
        let refused = scheme(state.system(Storage::Dense), laws(), "nsgs", settings, &state);
        assert!(matches!(refused, Err(SetupError::Theta { .. })), "no opt-out from [0, 1]: θ = {theta}");
    }
}
