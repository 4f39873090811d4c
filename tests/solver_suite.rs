//! Every registered solver passes the public suite: Coulomb friction in D = 1, 2, 3, rolling resistance in D = 3 and 6.

use nonsmooth::solver::{self, ConeSolver, SOLVERS, Stopping};
use nonsmooth::suite::{SolverFamily, Suite, check_solver};

struct Registered(&'static str);

impl SolverFamily for Registered {
    fn build<const D: usize>(&self, stopping: Stopping<f64>) -> Box<dyn ConeSolver<f64, D>> {
        solver::build(self.0, stopping).expect("registered")
    }
}

#[test]
fn registered_solvers_pass_the_suite() {
    for solver in SOLVERS {
        check_solver(&Suite { cases: 100, ..Suite::default() }, &Registered(solver.name))
            .unwrap_or_else(|failure| panic!("{failure}"));
    }
}

/// One that answers with the best it has after one sweep, and calls nothing a solution that is none.
struct Impatient;

impl SolverFamily for Impatient {
    fn build<const D: usize>(&self, stopping: Stopping<f64>) -> Box<dyn ConeSolver<f64, D>> {
        let stopping = Stopping { max_iterations: Some(1), ..stopping };
        solver::build("nsgs", stopping).expect("registered")
    }
}

#[test]
fn a_solver_that_gives_up_too_often_is_told_so() {
    let failure = check_solver(&Suite { cases: 30, ..Suite::default() }, &Impatient).expect_err("one sweep");
    assert_eq!(failure.property, "problems are solved");
}
