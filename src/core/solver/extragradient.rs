//! Projections on the variational inequality: the fixed point and the extragradient method.

use nalgebra::{ComplexField, SVector};

use super::cone_solver::{Description, Iteration, Method};
use super::control::Control;
use super::error::Breakdown;
use super::newton::ScaledProblem;
use super::settings::{Interval, SettingsError, setters};
use crate::cone::ConeProblem;
use crate::scalar::{Scalar, lit};

/// How many projections an iteration makes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Projections {
    /// r ← proj_K(r − ρ F(r)): the projected fixed point.
    One,
    /// r̄ = proj_K(r − ρ F(r)), r ← proj_K(r − ρ F(r̄)): the extragradient method (default).
    #[default]
    Two,
}

/// Settings of [`Extragradient`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ExtragradientSettings<T> {
    /// Projections of an iteration. Default: two, the extragradient method.
    pub projections: Projections,
    /// First step ρ, relative to 1/λ_max(W_αα) (dimensionless, > 0). Default 1.
    pub step: T,
    /// The step is refused and shortened where ρ‖F(r) − F(r̄)‖ > this ‖r − r̄‖ (dimensionless, in (0, 1)).
    /// Default 0.9.
    pub contraction: T,
    /// The step is lengthened by 3/2 where that ratio is below this (dimensionless). Default 0.3.
    pub lengthen_below: T,
}

impl<T: Scalar> Default for ExtragradientSettings<T> {
    fn default() -> Self {
        Self {
            projections: Projections::default(),
            step: T::one(),
            contraction: lit(0.9),
            lengthen_below: lit(0.3),
        }
    }
}

setters!(ExtragradientSettings<T>:
    with_projections(projections: Projections),
    with_step(step: T),
    with_contraction(contraction: T),
    with_lengthen_below(lengthen_below: T),
);

/// The cone problem as a variational inequality: r ∈ K, F(r)·(r' − r) ≥ 0 for every r' ∈ K, with
/// F(r) = Φ(W r + b), on the problem scaled to λ_max(W_αα) = 1; the projections of Korpelevich (1976) with the step
/// rule of Khobotov (1987), as compared for frictional contact by Acary, Brémond & Huber (2018),
/// doi:10.1007/978-3-319-75972-2_10.
///
/// It needs products with W only, and no diagonal block is ever inverted. Its rate is linear with the condition of
/// W, so that 1e-10 may take 10⁵ iterations; convergence is proven for monotone F, which Φ is not once μ > 0, and
/// for large friction it may cycle. Default budget: 200,000 iterations, a product with W per projection.
/// Choose it as a reference for other methods, or for a rough start.
#[derive(Debug, Clone)]
pub struct Extragradient<T: Scalar, const D: usize> {
    settings: ExtragradientSettings<T>,
    scaled: ScaledProblem<T, D>,
    x: Vec<SVector<T, D>>,
    force: Vec<SVector<T, D>>,
    trial: Vec<SVector<T, D>>,
    trial_force: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
}

/// Default budget.
const DEFAULT_ITERATIONS: usize = 200_000;

impl<T: Scalar, const D: usize> Method<T, D> for Extragradient<T, D> {
    const DESCRIPTION: Description = Description {
        name: "extragradient",
        title: "extragradient projections on the variational inequality, self-adaptive step",
        when: "a reference for other methods or a rough start; products with W only",
        reference: "Khobotov (1987); Acary, Brémond & Huber (2018), doi:10.1007/978-3-319-75972-2_10",
        iteration: Iteration::Sweep,
    };
    type Settings = ExtragradientSettings<T>;

    fn new(settings: ExtragradientSettings<T>) -> Result<Self, SettingsError> {
        Interval::Open(0.0, f64::INFINITY).check("step", settings.step)?;
        Interval::Open(0.0, 1.0).check("contraction", settings.contraction)?;
        Interval::Closed(0.0, 1.0).check("lengthen_below", settings.lengthen_below)?;
        let [x, force, trial, trial_force, best] = std::array::from_fn(|_| Vec::new());
        Ok(Self { settings, scaled: ScaledProblem::new(), x, force, trial, trial_force, best })
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        let Self { settings, scaled, x, force, trial, trial_force, best } = self;
        scaled.prepare(problem);
        scaled.enter(r, x);
        best.clone_from(x);
        for buffer in [&mut *force, &mut *trial, &mut *trial_force] {
            buffer.resize(x.len(), SVector::zeros());
        }
        let (mut rho, mut smallest) = (settings.step, T::infinity_impl());
        // Where nothing resists (no solution, r grows for ever) the step must not outrun the digits of r.
        let (shortest, longest) = (lit::<T>(1e-12), lit::<T>(1e4));
        let budget = control.max_iterations(DEFAULT_ITERATIONS);
        // Measured again in the problem's units, the residual may differ by rounding.
        let target = control.tolerance() * lit::<T>(0.95);
        let mut iterations = budget;
        scaled.force(x, force);
        for iteration in 1..=budget + 1 {
            let residual = scaled.residual_of_force(x, force);
            if residual < smallest {
                smallest = residual;
                best.copy_from_slice(x);
            }
            // The last round only measures.
            if iteration > budget || !control.proceed(iteration - 1, smallest) || smallest <= target {
                iterations = iteration - 1;
                break;
            }
            let ratio = loop {
                trial.iter_mut().zip(&*x).zip(&*force).for_each(|((trial, x), f)| *trial = x - f * rho);
                scaled.project_in_place(trial);
                scaled.force(trial, trial_force);
                let (mut moved, mut changed) = (T::zero(), T::zero());
                for i in 0..x.len() {
                    moved += (x[i] - trial[i]).norm_squared();
                    changed += (force[i] - trial_force[i]).norm_squared();
                }
                if moved == T::zero() {
                    break settings.contraction;
                }
                let ratio = rho * ComplexField::sqrt(changed / moved);
                // Written so that a NaN ends the search.
                let refused = ratio > settings.contraction && rho > shortest;
                if !refused {
                    break ratio;
                }
                let shrink = (settings.contraction / ratio).min(T::one()).max(lit(0.1));
                rho *= shrink * lit::<T>(2.0 / 3.0);
            };
            match settings.projections {
                Projections::One => {
                    std::mem::swap(x, trial);
                    std::mem::swap(force, trial_force);
                }
                Projections::Two => {
                    x.iter_mut().zip(&*trial_force).for_each(|(x, f)| *x -= f * rho);
                    scaled.project_in_place(x);
                    scaled.force(x, force);
                }
            }
            if ratio < settings.lengthen_below && rho < longest {
                rho *= lit::<T>(1.5);
            }
        }
        scaled.leave(best, r);
        Ok(iterations)
    }
}
