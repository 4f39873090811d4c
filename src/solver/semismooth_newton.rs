//! Semismooth Newton on the whole problem, with a line search and a proximal fallback.

use nalgebra::{ComplexField, SVector};

use super::complementarity::{Formulation, Linearised, linearise, value};
use super::newton::spread;
use super::newton_matrix::NewtonMatrix;
use super::scaling::Scaled;
use super::watchdog::Watchdog;
use super::{Breakdown, ConeSolver, Control, Description, Family, Stopping};
use crate::cone::{ConeProblem, Workspace, de_saxce, project};
use crate::scalar::{Scalar, epsilon, lit};

/// Settings of [`SemismoothNewton`].
#[derive(Debug, Clone)]
pub struct SemismoothNewtonSettings<T> {
    /// Tolerance and budget; the default budget is 4,000 Newton steps (linear solves).
    pub stopping: Stopping<T>,
    /// The nonsmooth equation. Default: Alart–Curnier.
    pub formulation: Formulation,
    /// Newton steps on the problem itself before the proximal fallback (count). Default 30; 0 goes straight to
    /// the proximal point method.
    pub direct_steps: usize,
    /// First proximal weight a₀ of the fallback, relative to λ_max(W_αα) = 1 (dimensionless, > 0). Default 1e-4.
    pub proximal_weight: T,
    /// Whether the fallback may run. Default true; without it a stagnation ends the solve.
    pub fallback: bool,
}

impl<T: Scalar> Default for SemismoothNewtonSettings<T> {
    fn default() -> Self {
        Self {
            stopping: Stopping::default(),
            formulation: Formulation::default(),
            direct_steps: 30,
            proximal_weight: lit(1e-4),
            fallback: true,
        }
    }
}

/// Semismooth Newton: F(r) = 0 with F the [`Formulation`] of every contact on the problem scaled to
/// λ_max(W_αα) = 1, the Newton system
///
/// ```text
///   Σ_β C_α W_αβ dr_β + (A_α + a C_α) dr_α = −F_α,     dF = A dr + C dw
/// ```
///
/// and a non-monotone line search on ½‖F‖². With a = 0 in F and a few ε in the matrix (so that redundant contacts,
/// which leave W singular, still have a step) it converges quadratically near a solution; where it stagnates the
/// fallback solves w + a (r − r_k) in place of w for a decreasing a, r_k being the last iterate (proximal point;
/// Acary, Brémond & Huber 2018, doi:10.1007/978-3-319-75972-2_10), in turn with both formulations and from other
/// starts, until the budget of Newton steps ends.
///
/// Choose it for accuracy on up to a few thousand contacts; the cost is one factorisation per step.
#[derive(Debug)]
pub struct SemismoothNewton<T: Scalar, const D: usize> {
    settings: SemismoothNewtonSettings<T>,
    scaled: Scaled<T, D>,
    matrix: NewtonMatrix<T, D>,
    r: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
    best_residual: T,
    center: Vec<SVector<T, D>>,
    reference: Vec<SVector<T, D>>,
    trial: Vec<SVector<T, D>>,
    step: Vec<SVector<T, D>>,
    contacts: Vec<Linearised<T, D>>,
    steps: usize,
    reached: bool,
    workspace: Workspace<T>,
}

/// How a Newton phase ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// Tolerance, budget or clock: the solve is over.
    Over,
    /// The phase reached its own target.
    Success(usize),
    /// No progress, or a step that could not be computed.
    Stagnation,
}

impl<T: Scalar, const D: usize> SemismoothNewton<T, D> {
    /// The solver with its settings.
    pub fn new(settings: SemismoothNewtonSettings<T>) -> Self {
        Self {
            settings,
            scaled: Scaled::default(),
            matrix: NewtonMatrix::default(),
            r: Vec::new(),
            best: Vec::new(),
            best_residual: T::infinity_impl(),
            center: Vec::new(),
            reference: Vec::new(),
            trial: Vec::new(),
            step: Vec::new(),
            contacts: Vec::new(),
            steps: 0,
            reached: false,
            workspace: Workspace::default(),
        }
    }

    /// Σ‖F‖² and the square of the residual at `x`, with the proximal weight `a` around the centre.
    fn merit(&self, x: &[SVector<T, D>], formulation: Formulation, a: T) -> (T, T) {
        let problem = self.scaled.problem();
        let (mut merit, mut residual) = (T::zero(), T::zero());
        for (i, x_i) in x.iter().enumerate() {
            let (w, mu) = (problem.shifted_velocity(i, x), problem.friction()[i]);
            merit += value(formulation, x_i, &(w + (x_i - self.center[i]) * a), mu).norm_squared();
            residual += self.scaled.residual_square(i, &(x_i - project(&(x_i - de_saxce(&w, mu)), mu)));
        }
        (merit, residual)
    }

    /// Keeps `self.r` if it is the best so far.
    fn keep(&mut self, residual_square: T) {
        let residual = ComplexField::sqrt(residual_square);
        if residual < self.best_residual {
            self.best_residual = residual;
            self.best.copy_from_slice(&self.r);
        }
    }

    /// The Newton step at `self.r` into `self.step`; `damping` is the a of the matrix, `a` that of F.
    fn newton_step(&mut self, formulation: Formulation, a: T, damping: T) -> Result<(), String> {
        let problem = self.scaled.problem();
        self.contacts.clear();
        for (i, r) in self.r.iter().enumerate() {
            let w = problem.shifted_velocity(i, &self.r) + (r - self.center[i]) * a;
            self.contacts.push(linearise(formulation, r, &w, problem.friction()[i]));
        }
        let (contacts, delassus) = (&self.contacts, self.scaled.delassus());
        self.matrix.factor(delassus, |i| {
            let contact = &contacts[i];
            let diagonal = contact.by_percussion + contact.by_velocity * damping;
            (!contact.open).then_some((contact.by_velocity, diagonal))
        })?;
        // The step of an open contact is known, and goes to the right-hand side of the others.
        self.step.clear();
        self.step.extend(contacts.iter().map(|contact| -contact.f));
        for (i, contact) in contacts.iter().enumerate().filter(|(_, contact)| !contact.open) {
            let open = delassus.row(i).filter(|(j, _)| contacts[*j].open);
            let known = open.fold(SVector::<T, D>::zeros(), |sum, (j, block)| sum - block * contacts[j].f);
            self.step[i] -= contact.by_velocity * known;
        }
        self.matrix.solve(&mut self.step)
    }

    /// Newton from `self.r` until ‖F‖² ≤ `target` or `most` steps, on the leash of the [`Watchdog`].
    fn phase(
        &mut self,
        formulation: Formulation,
        (a, damping): (T, T),
        (target, most): (T, usize),
        problem: &ConeProblem<T, D>,
        control: &mut Control<'_, T>,
    ) -> End {
        let budget = control.max_iterations(DEFAULT_STEPS);
        let (mut merit, mut residual) = self.merit(&self.r, formulation, a);
        // Where a phase ends without reaching its target, this much of ‖F‖ (3 %) is still worth the name.
        let enough = merit * lit::<T>(9e-4);
        let unfinished = |merit: T, step| if merit <= enough { End::Success(step) } else { End::Stagnation };
        let mut watchdog = Watchdog::new(merit);
        self.reference.clone_from(&self.r);
        for step in 0..most {
            self.keep(residual);
            if self.finished(problem, control) || self.steps >= budget {
                return End::Over;
            }
            if merit <= target {
                return End::Success(step);
            }
            if let Some(reference) = watchdog.back() {
                self.r.clone_from(&self.reference);
                merit = reference;
            }
            self.steps += 1;
            let computed = self.newton_step(formulation, a, damping).is_ok();
            if !control.proceed(self.steps, self.best_residual) {
                return End::Over;
            }
            if !computed {
                return End::Stagnation;
            }
            let (now, mut length) = (merit, T::one());
            self.advance(length);
            (merit, residual) = self.merit(&self.trial, formulation, a);
            if !watchdog.trusts(merit) {
                for _ in 0..12 {
                    if watchdog.accepts(merit, length, now) {
                        break;
                    }
                    length *= lit::<T>(0.5);
                    self.advance(length);
                    (merit, residual) = self.merit(&self.trial, formulation, a);
                }
                if watchdog.searched(length, merit) {
                    return unfinished(merit, step + 1);
                }
            }
            std::mem::swap(&mut self.r, &mut self.trial);
            if watchdog.stands(merit) {
                self.reference.clone_from(&self.r);
            }
        }
        self.keep(residual);
        if self.finished(problem, control) { End::Over } else { unfinished(merit, most) }
    }

    fn advance(&mut self, length: T) {
        self.trial.clear();
        self.trial.extend(self.r.iter().zip(&self.step).map(|(r, step)| r + step * length));
    }

    /// Whether the best iterate solves the problem as given, measured there.
    fn finished(&mut self, problem: &ConeProblem<T, D>, control: &Control<'_, T>) -> bool {
        if self.best_residual <= control.tolerance() {
            self.trial.clone_from(&self.best);
            self.scaled.unscale_into(&self.best, &mut self.trial);
            self.reached =
                problem.residual_in(&self.trial, &mut self.workspace).scaled <= control.tolerance();
        }
        self.reached
    }

    /// Whether rounding explains what the best iterate leaves.
    fn is_exhausted(&mut self, problem: &ConeProblem<T, D>) -> bool {
        self.trial.clone_from(&self.best);
        self.scaled.unscale_into(&self.best, &mut self.trial);
        problem.solved_to_rounding(&self.trial, self.best_residual, &mut self.workspace)
    }

    /// Proximal point steps from `self.r` with a first weight `a`.
    fn proximal(
        &mut self,
        formulation: Formulation,
        (mut a, most): (T, usize),
        problem: &ConeProblem<T, D>,
        control: &mut Control<'_, T>,
    ) -> End {
        let (least, tenth) = (lit::<T>(1e-9).max(epsilon::<T>() * lit::<T>(16.0)), lit::<T>(0.1));
        let (mut floor, mut failures, mut quick) = (least, 0, 0);
        let first = self.steps;
        while failures < 20 && self.steps - first < most {
            self.center.clone_from(&self.r);
            let natural = self.merit(&self.r, Formulation::NaturalMap, T::zero()).0;
            let end = self.phase(formulation, (a, a), (natural * lit::<T>(1e-6), 20), problem, control);
            let gentle = self.steps - first > 120;
            match end {
                End::Over => return End::Over,
                // Success without a step leaves nothing to iterate on.
                End::Success(0) => return End::Stagnation,
                End::Success(steps) => {
                    failures = 0;
                    quick = if steps <= 8 { quick + 1 } else { 0 };
                    if steps <= 4 {
                        a *= if gentle { lit::<T>(0.4) } else { tenth };
                    } else if quick >= 2 {
                        a *= if gentle { lit::<T>(0.6) } else { ComplexField::sqrt(tenth) };
                    } else if steps > 12 {
                        a *= lit::<T>(2.0);
                    }
                    floor *= lit::<T>(0.5);
                    a = a.max(floor).max(least);
                }
                End::Stagnation => {
                    failures += 1;
                    quick = 0;
                    floor = a * lit::<T>(2.0);
                    let factor = match failures {
                        1 if gentle => 2.0,
                        1 => 4.0,
                        _ => 10.0,
                    };
                    a = (a * lit::<T>(factor)).min(lit(10.0));
                    if !self.r.iter().all(|r| crate::scalar::all_finite(r.iter())) {
                        self.r.clone_from(&self.best);
                    }
                }
            }
        }
        End::Stagnation
    }

    /// Another place to start from: Gauss–Seidel sweeps from rest first, then percussions of the size of the best
    /// iterate's spread over the cones by the golden ratio, so that every restart tries other statuses.
    fn restart(&mut self, attempt: usize) {
        let m = self.r.len();
        if attempt == 1 {
            self.r.fill(SVector::zeros());
            for i in (0..20).flat_map(|_| 0..m) {
                self.r[i] = self.scaled.problem().solve_contact(i, &self.r);
            }
            return;
        }
        let square = self.best.iter().fold(T::zero(), |sum, r| sum + r.norm_squared());
        let size = ComplexField::sqrt(square / lit::<T>(m as f64)) + T::one();
        spread(&mut self.r, self.scaled.problem().friction(), size, attempt);
    }
}

/// Default budget of Newton steps.
const DEFAULT_STEPS: usize = 4_000;
/// Newton steps of the first proximal attempt before another start is tried, and of the later ones.
const ATTEMPT_STEPS: [usize; 2] = [600, 100];

impl<T: Scalar, const D: usize> Family<T> for SemismoothNewton<T, D> {
    const DESCRIPTION: Description = Description {
        name: "newton",
        title: "semismooth Newton (Alart–Curnier or natural map) with a line search and a proximal fallback",
        when: "accuracy on up to a few thousand contacts, redundant contacts included",
        reference: "Alart & Curnier (1991), doi:10.1016/0045-7825(91)90022-X",
    };

    fn with_stopping(stopping: Stopping<T>) -> Self {
        Self::new(SemismoothNewtonSettings { stopping, ..SemismoothNewtonSettings::default() })
    }
}

impl<T: Scalar, const D: usize> ConeSolver<T, D> for SemismoothNewton<T, D> {
    fn name(&self) -> &'static str {
        <Self as Family<T>>::DESCRIPTION.name
    }

    fn stopping(&self) -> &Stopping<T> {
        &self.settings.stopping
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        self.scaled.refill(problem);
        self.scaled.scale_into(r, &mut self.r);
        self.best.clone_from(&self.r);
        self.center.clone_from(&self.r);
        (self.best_residual, self.steps, self.reached) = (T::infinity_impl(), 0, false);
        self.matrix
            .analyse(self.scaled.delassus())
            .map_err(|message| Breakdown { iterations: 0, message })?;
        let mut formulation = self.settings.formulation;
        // Enough to leave a singular system a step, too little to slow the last ones.
        let damping = lit::<T>(1e4) * epsilon::<T>();
        let budget = control.max_iterations(DEFAULT_STEPS);
        let mut end = End::Stagnation;
        for attempt in 0.. {
            let direct = (T::zero(), self.settings.direct_steps);
            if self.settings.direct_steps > 0 {
                end = self.phase(formulation, (T::zero(), damping), direct, problem, control);
            }
            if end == End::Over || !self.settings.fallback || self.steps >= budget {
                break;
            }
            if self.is_exhausted(problem) {
                end = End::Over;
                break;
            }
            if attempt == 0 {
                self.r.clone_from(&self.best);
            }
            let most =
                if attempt == 0 { ATTEMPT_STEPS[0].max(10 * problem.contacts()) } else { ATTEMPT_STEPS[1] };
            let first = (self.settings.proximal_weight, most);
            end = self.proximal(formulation, first, problem, control);
            if end == End::Over || attempt >= MOST_ATTEMPTS {
                break;
            }
            formulation = formulation.other();
            self.restart(attempt + 1);
        }
        self.scaled.unscale_into(&self.best, r);
        if end == End::Over {
            return Ok(self.steps);
        }
        let message = format!("stagnation of the {:?} equation", self.settings.formulation);
        Err(Breakdown { iterations: self.steps, message })
    }
}

/// Attempts of the fallback; the budget usually ends before.
const MOST_ATTEMPTS: usize = 1_000;
