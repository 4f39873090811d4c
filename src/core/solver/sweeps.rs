//! Gauss–Seidel sweeps with Anderson acceleration between them, until the tolerance or the end of patience.

use nalgebra::SVector;

use super::anderson::Anderson;
use super::control::Control;
use super::gauss_seidel::GaussSeidel;
use crate::cone::{ConeProblem, Workspace, project};
use crate::scalar::{Scalar, lit, to_f64};

/// Order in which a sweep visits the contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sweep {
    /// First to last (default).
    #[default]
    Forward,
    /// Last to first.
    Reverse,
    /// Forward, then reverse, in turn.
    Symmetric,
}

impl Sweep {
    /// Whether sweep number `sweep` (from 1) runs from the last contact to the first.
    fn is_reverse(self, sweep: usize) -> bool {
        match self {
            Self::Forward => false,
            Self::Reverse => true,
            Self::Symmetric => sweep.is_multiple_of(2),
        }
    }
}

/// Accelerated sweeps without a gain of 0.7 that are taken for a cycle.
const CYCLE: usize = 100;

/// Part of the last change above which the change of a sweep calls for acceleration.
const SLOW: f64 = 0.1;

/// When [`Accelerated::run`] gives up.
pub(super) struct Patience<'a> {
    /// Largest number of sweeps, where no price says otherwise.
    pub(super) sweeps: usize,
    /// Sweeps without a gain of 0.7 after which it stops.
    pub(super) stalled: usize,
    /// Asked once, where it would stop: what an iteration of the method that follows costs, in sweeps.
    pub(super) price: Option<&'a mut dyn FnMut() -> usize>,
    /// Largest number of sweeps whatever the price.
    pub(super) most: usize,
}

impl Patience<'_> {
    pub(super) fn endless(sweeps: usize) -> Self {
        Self { sweeps, stalled: usize::MAX, price: None, most: sweeps }
    }
}

/// Iterations of the method that follows whose price is spent on sweeps whatever they gain, since they give it a better
/// start; and those that are spent where the rate measured promises to end within them.
const WORTH_A_START: usize = 5;
const WORTH_THE_END: usize = 30;

/// How fast the changes of the sweeps fall.
#[derive(Debug, Clone, Copy)]
struct Rate<T> {
    least: T,
    /// Sweep number and least change at two earlier times, the later at most two thirds of the sweeps ago.
    marks: [(usize, T); 2],
}

impl<T: Scalar> Rate<T> {
    fn new() -> Self {
        Self { least: T::infinity_impl(), marks: [(0, T::infinity_impl()); 2] }
    }

    fn note(&mut self, sweep: usize, change: T) {
        if change < self.least {
            self.least = change;
        }
        if sweep >= 2 * self.marks[1].0 {
            self.marks = [self.marks[1], (sweep.max(1), self.least)];
        }
    }

    /// Sweeps to go until the change is `target`, at the rate since the earlier mark.
    fn to_go(self, sweep: usize, target: T) -> f64 {
        let (from, change) = self.marks[0];
        let log = |x: T| to_f64(x).ln();
        let rate = (log(change) - log(self.least)) / (sweep - from) as f64;
        let to_go = (log(self.least) - log(target)) / rate;
        if rate > 0.0 && to_go.is_finite() { to_go } else { f64::INFINITY }
    }
}

/// How a run of sweeps ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct SweepsEnd<T> {
    pub(super) iterations: usize,
    /// Scaled residual of the iterate returned.
    pub(super) residual: T,
}

/// Sweeps with Anderson acceleration that return the best iterate met.
#[derive(Debug, Clone)]
pub(super) struct Accelerated<T: Scalar, const D: usize> {
    sweeps: GaussSeidel<T, D>,
    anderson: Anderson<T, SVector<T, D>>,
    accelerated: bool,
    from: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
}

impl<T: Scalar, const D: usize> Accelerated<T, D> {
    pub(super) fn new(depth: usize) -> Self {
        let anderson = Anderson::new(depth);
        Self {
            sweeps: GaussSeidel::new(),
            anderson,
            accelerated: depth > 0,
            from: Vec::new(),
            best: Vec::new(),
        }
    }

    /// Reads what the sweeps keep of a problem, which [`residual`](Self::residual) and [`run`](Self::run) are then of.
    pub(super) fn prepare(&mut self, problem: &ConeProblem<T, D>) {
        self.sweeps.prepare(problem);
    }

    /// The scaled residual.
    pub(super) fn residual(&mut self, problem: &ConeProblem<T, D>, r: &[SVector<T, D>]) -> T {
        self.sweeps.scaled_residual(problem, r)
    }

    pub(super) fn workspace(&mut self) -> &mut Workspace<T> {
        self.sweeps.workspace()
    }

    /// Sweeps over the problem prepared, from `r` of the residual `start`, until the tolerance or the end of patience; `r` is
    /// left at the best iterate measured.
    pub(super) fn run(
        &mut self,
        problem: &ConeProblem<T, D>,
        (r, start): (&mut [SVector<T, D>], T),
        order: Sweep,
        mut patience: Patience<'_>,
        control: &mut Control<'_, T>,
    ) -> SweepsEnd<T> {
        if r.len() == 1 {
            // The sweep is the solution.
            self.sweeps.sweep(problem, r, false);
            let residual = self.sweeps.scaled_residual(problem, r);
            control.proceed(1, residual);
            return SweepsEnd { iterations: 1, residual };
        }
        if self.accelerated {
            self.anderson.prepare(r.len());
        }
        self.from.resize(r.len(), SVector::zeros());
        self.best.clear();
        self.best.extend_from_slice(r);
        let b_norm = problem.b_norm();
        let tolerance = control.tolerance();
        let mut best = start;
        // The change of a sweep bounds the residual only loosely, so the residual decides, and is measured where the
        // change promises it, and from time to time.
        let (mut trigger, mut next_check) = (tolerance, 1);
        let (mut mark, mut since) = (T::infinity_impl(), 0);
        // Acceleration can cycle; plain sweeps leave the cycle, and are given twice as long each time.
        let (mut plain_until, mut plain) = (0, CYCLE);
        let (mut rate, mut price) = (Rate::new(), None);
        // Sweeps that end by themselves need no acceleration.
        let (mut previous, mut slow) = (T::infinity_impl(), false);
        let mut sweep = 0;
        while sweep < patience.most && best > tolerance {
            sweep += 1;
            if self.accelerated {
                self.from.copy_from_slice(r);
            }
            let change = self.sweeps.sweep(problem, r, order.is_reverse(sweep));
            let estimate = nalgebra::ComplexField::sqrt(change) / b_norm;
            let go_on = control.proceed(sweep, estimate);
            if estimate < mark * lit::<T>(0.7) {
                (mark, since) = (estimate, 0);
            } else {
                since += 1;
            }
            rate.note(sweep, estimate);
            slow |= estimate > previous * lit::<T>(SLOW);
            previous = estimate;
            let spent = sweep >= patience.sweeps || since > patience.stalled;
            if spent && let Some(ask) = patience.price.take() {
                let sweeps = ask();
                patience.sweeps = (WORTH_A_START * sweeps).clamp(patience.sweeps, patience.most);
                patience.stalled = patience.stalled.max(patience.sweeps / 4);
                price = Some(sweeps);
            }
            // At the measured rate the end may still be cheaper than the method that follows.
            let ends = |sweeps| rate.to_go(sweep, tolerance) <= (WORTH_THE_END * sweeps) as f64;
            let spent = sweep >= patience.sweeps || since > patience.stalled;
            let last = !go_on || sweep == patience.most || spent && !price.is_some_and(ends);
            if estimate <= trigger || sweep >= next_check || last {
                let residual = self.sweeps.scaled_residual(problem, r);
                if residual < best {
                    best = residual;
                    self.best.copy_from_slice(r);
                }
                // Bodies that share no contact are done after the first sweep.
                next_check = if sweep == 1 { 4 } else { sweep + 8 + sweep / 2 };
                let needed = estimate * tolerance / residual;
                trigger = if needed < tolerance { needed } else { tolerance };
            }
            if last || !(estimate < T::infinity_impl()) {
                break;
            }
            if self.accelerated && since >= CYCLE && sweep >= plain_until {
                self.anderson.forget();
                (plain_until, plain) = (sweep + plain, 2 * plain);
                (mark, since) = (T::infinity_impl(), 0);
            }
            if self.accelerated && slow && sweep >= plain_until {
                // Contact α weighs λ_max(W_αα), so that the iterates do not depend on the units.
                let weights = self.sweeps.sizes().iter().copied();
                if self.anderson.accelerate(&self.from, r, weights) {
                    r.iter_mut().zip(problem.cones()).for_each(|(r, &cone)| *r = project(r, cone));
                }
            }
        }
        r.copy_from_slice(&self.best);
        SweepsEnd { iterations: sweep, residual: best }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_that_fall_by_a_constant_factor_tell_the_sweeps_to_go() {
        let mut rate = Rate::new();
        for sweep in 1..=40 {
            rate.note(sweep, 0.5f64.powi(sweep as i32));
        }
        // 2⁻⁴⁰ is to fall to 2⁻⁶⁰.
        let to_go = rate.to_go(40, 0.5f64.powi(60));
        assert!((to_go - 20.0).abs() < 1e-9, "{to_go}");
    }

    #[test]
    fn changes_that_do_not_fall_never_end() {
        let mut rate = Rate::new();
        for sweep in 1..=40 {
            rate.note(sweep, 1.0f64);
        }
        assert_eq!(rate.to_go(40, 1e-8), f64::INFINITY);
    }
}
