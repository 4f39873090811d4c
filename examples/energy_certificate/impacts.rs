//! Random impacts through the whole step: random systems, contacts, laws and θ.

#[path = "../../tests/mechanics/stream.rs"]
mod stream;

use nalgebra::{DMatrix, SVector};
use nonsmooth::laws::{self, ContactLaw};
use nonsmooth::linalg::Symmetric;
use nonsmooth::scheme::{Activation, ActivationRule, Settings, StepError, ThetaScheme};
use nonsmooth::solver::{self, ConeSolver, Stopping};
use nonsmooth::system::{Lagrangian, SmoothGap};
pub(crate) use stream::Stream;

/// What a number of impacts gave.
#[derive(Debug, Clone)]
pub(crate) struct Tally {
    /// Contacts with a percussion.
    pub(crate) contacts: usize,
    pub(crate) systems: usize,
    /// Systems whose cone problem the solver left unsolved.
    pub(crate) unsolved: usize,
    /// Largest work of a contact over E, normal and tangential together.
    pub(crate) worst: f64,
    /// Largest imbalance of (56) over E.
    pub(crate) imbalance: f64,
    /// Contacts by decade of a positive work over E, from 1e-20: [0] counts what is at most that.
    pub(crate) decades: [usize; 21],
}

impl Default for Tally {
    fn default() -> Self {
        let (contacts, systems, unsolved) = (0, 0, 0);
        Self { contacts, systems, unsolved, worst: f64::MIN, imbalance: 0.0, decades: [0; 21] }
    }
}

/// Makes impacts under the law until `contacts` contacts had a percussion.
pub(crate) fn impacts<const D: usize>(law: &str, contacts: usize, stream: &mut Stream) -> Tally {
    let mut tally = Tally::default();
    while tally.contacts < contacts {
        impact::<D>(law, stream, &mut tally);
    }
    tally
}

type Law<const D: usize> = Box<dyn ContactLaw<f64, D>>;

/// θ in the interval all laws claim; ½ where they claim nothing.
fn common_theta<const D: usize>(laws: &[Law<D>], stream: &mut Stream) -> Option<f64> {
    let mut claim = (0.0_f64, 1.0_f64);
    for law in laws {
        let own = law.dissipative_theta().unwrap_or(0.5..=0.5);
        claim = (claim.0.max(*own.start()), claim.1.min(*own.end()));
    }
    // The ends are as likely as what lies between.
    let share = [0.0, 1.0, stream.uniform(0.0, 1.0)][stream.below(3)];
    (claim.0 <= claim.1).then_some(claim.0 + share * (claim.1 - claim.0))
}

/// The solver goes to 2e-15, so that its residual, times ‖b‖‖p‖/E, stays below the bound on the works.
///
/// A system of 1 to 6 degrees of freedom with 1 to 4 contacts, closed at the start, in one step without forces.
///
/// Every contact opens along the first coordinate, so that the cone problem has a solution whatever M, H and μ; H is
/// rank-deficient as often as not. Separating contacts are active too.
fn impact<const D: usize>(name: &str, stream: &mut Stream, tally: &mut Tally) {
    let (n, count) = (1 + stream.below(6), 1 + stream.below(4));
    let root = DMatrix::from_fn(n, n, |_, _| stream.uniform(-1.0, 1.0));
    let floor = 10.0_f64.powf(stream.uniform(-1.0, 0.0));
    let mass = &root * root.transpose() + DMatrix::identity(n, n) * floor;
    let mut law = || -> Law<D> {
        let e = [0.0, 1.0, stream.uniform(0.0, 1.0)][stream.below(3)];
        let mut values = vec![e, stream.uniform(0.0, 2.0)];
        let description = laws::describe(name).expect("a registered law");
        values.resize_with(description.parameters.len(), || stream.uniform(0.0, 1.0));
        laws::build(name, &values).expect("a registered law")
    };
    // Different laws for the contacts where their intervals meet, else the same for all.
    let different: Vec<Law<D>> = (0..count).map(|_| law()).collect();
    let (laws, theta) = match common_theta(&different, stream) {
        Some(theta) => (different, theta),
        None => {
            let one = || different.into_iter().next().expect("at least one contact");
            let laws = vec![one()];
            let theta = common_theta(&laws, stream).expect("a law claims an interval or nothing");
            (laws, theta)
        }
    };
    let mut system =
        Lagrangian::<f64, D>::new(Symmetric::dense(mass).expect("symmetric")).with_scales(1.0, 1.0);
    for contact in 0..count {
        let row: Vec<SVector<f64, D>> = (0..n)
            .map(|column| match column {
                0 => SVector::from_fn(|d, _| if d == 0 { 1.0 } else { 0.0 }),
                _ => SVector::from_fn(|_, _| stream.uniform(-1.0, 1.0)),
            })
            .collect();
        let interface = contact.min(laws.len() - 1);
        let gap = SmoothGap::new(
            |_: &[f64]| 0.0,
            move |_, push: &mut dyn FnMut(usize, SVector<f64, D>)| {
                row.iter().enumerate().for_each(|(i, &h)| push(i, h));
            },
        );
        system = system.with_contact(interface, gap);
    }
    let v: Vec<f64> = (0..n).map(|_| stream.uniform(-1.0, 1.0)).collect();
    let stopping = Stopping { max_seconds: Some(1.0), ..Stopping::to(2e-15) };
    let solver: Box<dyn ConeSolver<f64, D>> =
        solver::build(solver::DEFAULT, stopping).expect("the default solver");
    let activation = Activation::new(ActivationRule::CurrentGap);
    let settings = Settings { activation, ..Settings::new(theta, 1e-3) };
    let mut scheme = ThetaScheme::new(Box::new(system), laws, solver, settings, 0.0, vec![0.0; n], v)
        .expect("a random system within its ranges");
    let energy = scheme.last_step().energies.mechanical();
    tally.systems += 1;
    let step = match scheme.step() {
        Ok(step) => step,
        Err(StepError::Solve { .. }) => {
            tally.unsolved += 1;
            return;
        }
        Err(error) => panic!("{error}"),
    };
    tally.imbalance = tally.imbalance.max(step.balance.imbalance.abs() / energy);
    for contact in step.contacts.iter().filter(|contact| contact.percussion[0] > 0.0) {
        let work = (contact.normal_work + contact.tangential_work) / energy;
        tally.contacts += 1;
        tally.worst = tally.worst.max(work);
        let decade = if work > 1e-20 { (work.log10() + 20.0).floor() as usize + 1 } else { 0 };
        tally.decades[decade.min(20)] += 1;
    }
}
