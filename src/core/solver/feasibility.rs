//! Whether some percussion brings every velocity into the dual cone, or the direction that shows none does.

use clarabel::solver::SupportedConeT::{NonnegativeConeT, SecondOrderConeT};
use clarabel::solver::{DefaultSettings, DefaultSolution, DefaultSolver, IPSolver, SolverStatus};
use nalgebra::SVector;

use super::conic_program::{Unknowns, settings, sparse, usable};
use super::error::ProgramError;
use super::newton::Scaling;
use crate::cone::cones::Shape;
use crate::cone::{BlockMatrix, Cone, ConeProblem, ProblemError, contains, dual_gauge};
use crate::scalar::{Scalar, epsilon, lit, to_f64};

/// Why [`feasibility`] decided nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Undecided {
    /// b = 0: r = 0 is a solution, and W r ∈ int K* may or may not be.
    #[error("b = 0")]
    Trivial,
    /// A contact has rolling resistance: K* is then no second-order cone.
    #[error("contact {contact} has rolling resistance, which the convex program does not know")]
    Rolling {
        /// Index of the contact.
        contact: usize,
    },
    /// Entries of W or b are so large or so small that the scaled problem is not finite.
    #[error("the scaled problem is not finite")]
    NotFinite,
    /// The convex program was refused.
    #[error("the convex program was refused")]
    Refused(#[source] ProgramError),
    /// The program's end was not verified, or its margin is too near 0.
    #[error("clarabel stopped with {0:?}")]
    Program(SolverStatus),
}

/// The outcome of [`feasibility`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Feasibility<T: Scalar, const D: usize> {
    /// W r + b ∈ int K* for this r, which makes a solution of the cone problem exist.
    Strict {
        /// The largest t ≤ 1 with W r + b − t b̄ e_N ∈ K*, b̄_α the size of b at the contact (dimensionless).
        margin: T,
        /// The percussions (N s), free of sign and cone.
        percussion: Vec<SVector<T, D>>,
    },
    /// No r brings W r + b into K*: d separates the range of W from K* − b. A solution may exist all the same
    /// (feasibility is sufficient, not necessary), but nothing guarantees it.
    Separated {
        /// The largest t, negative (dimensionless).
        margin: T,
        /// d ∈ K with Wᵀ d = 0 and d·b < 0, scaled to Σ d_N = 1 in the scaled problem (N s).
        direction: Vec<SVector<T, D>>,
    },
    /// The margin is too near 0 for the arithmetic, or the program was not solved.
    Undecided {
        /// The margin computed, NaN where there is none.
        margin: T,
        /// What stood in the way.
        reason: Undecided,
    },
}

/// Margins smaller than this are not decided: it is 100 times the tolerance of the convex program.
const UNDECIDED: f64 = 1e-7;

/// Slater's condition of the cone problem by one second-order cone program,
///
/// ```text
///   max t   subject to   W r + b − t b̄ e_N ∈ K*,   t ≤ 1,   r free,
/// ```
///
/// with b̄_α = β λ_max(W_αα)^{1/2}, β the mean size of the scaled b. A positive margin makes a solution exist
/// (Acary, Cadoux, Lemaréchal & Malick 2011, doi:10.1002/zamm.201000073); a negative one comes with the direction
/// d ∈ K, Wᵀ d = 0, d·b < 0 that proves it. Both are verified in the arithmetic of T before they are returned.
///
/// # Errors
/// [`ProblemError`] where the data are not a cone problem.
pub fn feasibility<T: Scalar, const D: usize>(
    problem: &ConeProblem<T, D>,
) -> Result<Feasibility<T, D>, ProblemError> {
    problem.check()?;
    let m = problem.contacts();
    if problem.b_norm() == T::zero() {
        return Ok(Feasibility::Undecided { margin: T::zero(), reason: Undecided::Trivial });
    }
    let rolls = |&cone: &_| matches!(Shape::of::<D>(cone), Shape::Blocks(_));
    if let Some(contact) = problem.cones().iter().position(rolls) {
        return Ok(Feasibility::Undecided { margin: T::zero(), reason: Undecided::Rolling { contact } });
    }
    let scaling = Scaling::of(problem);
    let scaled = scaling.scaled(problem);
    let (unknowns, margin) = (Unknowns::all::<D>(m), m * D);
    let (mut entries, mut rhs, mut cones) = (Vec::new(), Vec::new(), Vec::new());
    // One row of W x + b − t e_N, as s = rhs − A (x, t), combined with weights on N and on one tangent.
    let (p, mut own) = (&scaled, BlockMatrix::new());
    let w = p.delassus().form_in(&mut own);
    let mut push = |contact: usize, weights: &[(usize, f64)]| {
        let row = rhs.len();
        for (j, block) in w.row(contact) {
            for (c, column) in unknowns.range(j).enumerate() {
                let value = weights.iter().map(|&(d, weight)| weight * to_f64(block[(d, c)])).sum::<f64>();
                entries.push((row, column, -value));
            }
        }
        entries.extend(weights.iter().filter(|&&(d, _)| d == 0).map(|&(_, weight)| (row, margin, weight)));
        rhs.push(weights.iter().map(|&(d, weight)| weight * to_f64(p.b()[contact][d])).sum::<f64>());
    };
    for (i, cone) in p.cones().iter().enumerate() {
        let mu = to_f64(cone.friction());
        match if mu > 0.0 { D } else { 1 } {
            1 => {
                push(i, &[(0, 1.0)]);
                cones.push(NonnegativeConeT(1));
            }
            2 => {
                push(i, &[(0, 1.0), (1, mu)]);
                push(i, &[(0, 1.0), (1, -mu)]);
                cones.push(NonnegativeConeT(2));
            }
            _ => {
                push(i, &[(0, 1.0)]);
                (1..D).for_each(|d| push(i, &[(d, mu)]));
                cones.push(SecondOrderConeT(D));
            }
        }
    }
    entries.push((rhs.len(), margin, 1.0));
    rhs.push(1.0);
    cones.push(NonnegativeConeT(1));
    let undecided = |margin: f64, reason| Ok(Feasibility::Undecided { margin: lit(margin), reason });
    if !entries.iter().all(|(_, _, value)| value.is_finite()) || !rhs.iter().all(|b| b.is_finite()) {
        return undecided(f64::NAN, Undecided::NotFinite);
    }
    let mut linear = vec![0.0; margin + 1];
    linear[margin] = -1.0;
    let (rows, quadratic) = (sparse(rhs.len(), margin + 1, &entries), sparse(margin + 1, margin + 1, &[]));
    let mut last = (f64::NAN, SolverStatus::Unsolved);
    // Where the program stalls in one scaling of its rows it seldom does in the other.
    for equilibrate_enable in [true, false] {
        let settings = DefaultSettings { equilibrate_enable, ..settings(UNDECIDED * 1e-2, 200) };
        let mut program = match DefaultSolver::new(&quadratic, &linear, &rows, &rhs, &cones, settings) {
            Ok(program) => program,
            Err(error) => return undecided(f64::NAN, Undecided::Refused(ProgramError::new(error))),
        };
        program.solve();
        if let Some(decided) = decide(&scaling, &scaled, &program.solution) {
            return Ok(decided);
        }
        last = (program.solution.x[margin], program.solution.status);
    }
    undecided(last.0, Undecided::Program(last.1))
}

/// What the convex program found, verified on the scaled problem.
fn decide<T: Scalar, const D: usize>(
    scaling: &Scaling<T>,
    p: &ConeProblem<T, D>,
    solution: &DefaultSolution<f64>,
) -> Option<Feasibility<T, D>> {
    let (primal, dual) = (&solution.x, &solution.z);
    if !usable(solution.status) || !primal.iter().chain(dual).all(|v| v.is_finite()) {
        return None;
    }
    let t = primal[p.contacts() * D];
    if t > UNDECIDED {
        let block = |i: usize| SVector::<T, D>::from_fn(|d, _| lit(primal[i * D + d]));
        let x: Vec<_> = (0..p.contacts()).map(block).collect();
        let margin = verified_margin(p, &x)?.min(T::one());
        let mut percussion = x.clone();
        scaling.leave(&x, &mut percussion);
        Some(Feasibility::Strict { margin, percussion })
    } else if t < -UNDECIDED {
        let d = direction(p, dual);
        let mut direction = d.clone();
        scaling.leave(&d, &mut direction);
        separates(p, &d, lit(t)).then_some(Feasibility::Separated { margin: lit(t), direction })
    } else {
        None
    }
}

/// min_α (w_N − μ‖w_T‖), where it is positive.
fn verified_margin<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>, x: &[SVector<T, D>]) -> Option<T> {
    let margins = problem.cones().iter().enumerate().map(|(i, &cone)| {
        let w = problem.shifted_velocity(i, x);
        w[0] - dual_gauge(&w, cone)
    });
    let least = margins.fold(T::infinity_impl(), |least, margin| least.min(margin));
    (least > T::zero()).then_some(least)
}

/// The direction of the dual variables: what the rows of a contact weigh its N and T components with.
fn direction<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>, dual: &[f64]) -> Vec<SVector<T, D>> {
    let mut row = 0;
    let contact = |cone: &Cone<T>| {
        let (mu, mut d) = (to_f64(cone.friction()), SVector::<T, D>::zeros());
        let rows = if mu > 0.0 { D } else { 1 };
        let y = &dual[row..row + rows];
        row += rows;
        d[0] = lit(if rows == 2 { y[0] + y[1] } else { y[0] });
        match rows {
            1 => {}
            2 => d[1] = lit(mu * (y[0] - y[1])),
            _ => (1..D).for_each(|k| d[k] = lit(mu * y[k])),
        }
        d
    };
    problem.cones().iter().map(contact).collect()
}

/// d ∈ K, ‖Wᵀ d‖ small against |d·b|, d·b < 0: the residue of Wᵀ d = 0 cannot make up for d·b within percussions
/// of size 1e4.
fn separates<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>, d: &[SVector<T, D>], t: T) -> bool {
    let along = d.iter().zip(problem.b()).fold(T::zero(), |sum, (d, b)| sum + d.dot(b));
    let mut image = vec![SVector::<T, D>::zeros(); d.len()];
    let mut own = BlockMatrix::new();
    let w = problem.delassus().form_in(&mut own);
    for (i, d_i) in d.iter().enumerate() {
        w.row(i).for_each(|(j, block)| image[j] += block.transpose() * d_i);
    }
    let image = nalgebra::ComplexField::sqrt(image.iter().fold(T::zero(), |sum, v| sum + v.norm_squared()));
    let slack = lit::<T>(UNDECIDED).max(epsilon::<T>() * lit::<T>(64.0));
    let inside = d.iter().zip(problem.cones()).all(|(d, &cone)| contains(d, cone, slack));
    inside
        && along < t * lit::<T>(0.5)
        && image <= lit::<T>(1e-4).max(slack) * nalgebra::ComplexField::abs(along)
}
