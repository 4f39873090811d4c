//! The property suite: what every law and every solver is tested by, for authors inside and outside the crate.
//!
//! ```
//! use nonsmooth::laws::Fremond;
//! use nonsmooth::suite::{Suite, check_law};
//!
//! // One number in [0, 1] per parameter draws an instance: here restitution and friction.
//! let draw = |unit: &[f64]| Fremond::new(unit[0], 2.0 * unit[1]).expect("parameters in range");
//! check_law(&Suite { cases: 8, ..Suite::default() }, 2, draw).unwrap();
//! ```
//!
//! [`check_solver`] does the same for a solver of the cone problem.
//!
//! [`check_law`] tests the claim of a law in every contact dimension with every registered solver:
//!
//! - inside the θ-interval it claims, u_{k+θ}·p ≤ 0 at every contact of random problems ([`check_dissipation`]),
//!   and the balance (56) closes over random systems, many contacts and many steps ([`check_balance`]);
//! - outside, and everywhere for a law that claims nothing, energy is created ([`find_violation`]).
//!
//! [`check_system`] tests what a system says of itself: sizes, gaps and Jacobians, joints, potentials.

mod laws;
mod solvers;
mod strategies;
mod systems;
mod violation;

use proptest::test_runner::{Config, FileFailurePersistence, RngAlgorithm, TestRng, TestRunner};

pub use laws::{Draw, check_balance, check_dissipation, check_lasting, check_law, check_law_in, work_bound};
pub use solvers::{BuildSolver, SolverFamily, check_solver, check_solver_in};
pub use strategies::{RandomSystem, random_system};
pub use systems::check_system;
pub use violation::{Violation, check_claim_is_sharp, find_violation};

/// How many cases a property is tested on, and where the seeds of failures are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Suite {
    /// Random cases per property, law, solver and dimension. Default 64.
    pub cases: u32,
    /// File that keeps the seeds of failures, to be committed; `None` (default) keeps none.
    pub regressions: Option<&'static str>,
}

impl Default for Suite {
    fn default() -> Self {
        Self { cases: 64, regressions: None }
    }
}

impl Suite {
    /// A runner whose cases are the same in every run.
    fn runner(&self) -> TestRunner {
        let persistence =
            self.regressions.map(|file| Box::new(FileFailurePersistence::Direct(file)) as Box<_>);
        let config = Config {
            cases: self.cases,
            failure_persistence: persistence,
            max_shrink_iters: 2_000,
            ..Config::default()
        };
        TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
    }
}

/// A property that does not hold, with the case that shows it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{property} (D = {dimension}, solver {solver}): {case}")]
pub struct SuiteFailure {
    /// What should hold.
    pub property: &'static str,
    /// Contact dimension.
    pub dimension: usize,
    /// Cone solver, or `–` where none is involved.
    pub solver: String,
    /// The smallest case found, and the numbers.
    pub case: String,
}
