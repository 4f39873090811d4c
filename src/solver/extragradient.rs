//! Projections on the variational inequality: the fixed point and the extragradient method.

use nalgebra::{ComplexField, SVector};

use super::scaling::Scaled;
use super::{Breakdown, ConeSolver, Control, Description, Family, Stopping};
use crate::cone::{ConeProblem, de_saxce, project};
use crate::scalar::{Scalar, lit};

/// How many projections an iteration makes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Projections {
    /// r ← proj_K(r − ρ F(r)): the projected fixed point.
    One,
    /// r̄ = proj_K(r − ρ F(r)), r ← proj_K(r − ρ F(r̄)): the extragradient method (default).
    #[default]
    Two,
}

/// Settings of [`Extragradient`].
#[derive(Debug, Clone)]
pub struct ExtragradientSettings<T> {
    /// Tolerance and budget; the default budget is 200,000 iterations (a product with W per projection).
    pub stopping: Stopping<T>,
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
            stopping: Stopping::default(),
            projections: Projections::default(),
            step: T::one(),
            contraction: lit(0.9),
            lengthen_below: lit(0.3),
        }
    }
}

/// The cone problem as a variational inequality: r ∈ K, F(r)·(r' − r) ≥ 0 for every r' ∈ K, with
/// F(r) = Φ(W r + b), on the problem scaled to λ_max(W_αα) = 1; the projections of Korpelevich (1976) with the step
/// rule of Khobotov (1987), as compared for frictional contact by Acary, Brémond & Huber (2018),
/// doi:10.1007/978-3-319-75972-2_10.
///
/// It needs products with W only, and no diagonal block is ever inverted. Its rate is linear with the condition of
/// W, so that 1e-10 may take 10⁵ iterations; convergence is proven for monotone F, which Φ is not once μ > 0, and
/// for large friction it may cycle. Choose it as a reference for other methods, or for a rough start.
#[derive(Debug, Clone)]
pub struct Extragradient<T: Scalar, const D: usize> {
    settings: ExtragradientSettings<T>,
    scaled: Scaled<T, D>,
    r: Vec<SVector<T, D>>,
    force: Vec<SVector<T, D>>,
    trial: Vec<SVector<T, D>>,
    trial_force: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
}

/// Default budget.
const DEFAULT_ITERATIONS: usize = 200_000;

impl<T: Scalar, const D: usize> Extragradient<T, D> {
    /// The solver with its settings.
    pub fn new(settings: ExtragradientSettings<T>) -> Self {
        Self {
            settings,
            scaled: Scaled::default(),
            r: Vec::new(),
            force: Vec::new(),
            trial: Vec::new(),
            trial_force: Vec::new(),
            best: Vec::new(),
        }
    }
}

/// F(r) = Φ(W r + b).
fn fill_force<T: Scalar, const D: usize>(
    problem: &ConeProblem<T, D>,
    r: &[SVector<T, D>],
    force: &mut Vec<SVector<T, D>>,
) {
    force.clear();
    force.extend((0..r.len()).map(|i| de_saxce(&problem.shifted_velocity(i, r), problem.friction()[i])));
}

impl<T: Scalar, const D: usize> Family<T> for Extragradient<T, D> {
    const DESCRIPTION: Description = Description {
        name: "extragradient",
        title: "extragradient projections on the variational inequality, self-adaptive step",
        when: "a reference for other methods or a rough start; products with W only",
        reference: "Khobotov (1987); Acary, Brémond & Huber (2018), doi:10.1007/978-3-319-75972-2_10",
    };

    fn with_stopping(stopping: Stopping<T>) -> Self {
        Self::new(ExtragradientSettings { stopping, ..ExtragradientSettings::default() })
    }
}

impl<T: Scalar, const D: usize> ConeSolver<T, D> for Extragradient<T, D> {
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
        let p = self.scaled.problem();
        let friction = p.friction();
        let (mut rho, mut best) = (self.settings.step, T::infinity_impl());
        // Where nothing resists (no solution, r grows for ever) the step must not outrun the digits of r.
        let (shortest, longest) = (lit::<T>(1e-12), lit::<T>(1e4));
        let budget = control.max_iterations(DEFAULT_ITERATIONS);
        // Measured again in the problem's units, the residual may differ by rounding.
        let target = control.tolerance() * lit::<T>(0.95);
        let mut iterations = budget;
        fill_force(p, &self.r, &mut self.force);
        for iteration in 1..=budget + 1 {
            let square = self.r.iter().zip(&self.force).enumerate().fold(T::zero(), |sum, (i, (r, f))| {
                sum + self.scaled.residual_square(i, &(r - project(&(r - f), friction[i])))
            });
            let residual = ComplexField::sqrt(square);
            if residual < best {
                best = residual;
                self.best.copy_from_slice(&self.r);
            }
            // The last round only measures.
            if iteration > budget || !control.proceed(iteration - 1, best) || best <= target {
                iterations = iteration - 1;
                break;
            }
            let ratio = loop {
                self.trial.clear();
                let projected = self.r.iter().zip(&self.force).zip(friction);
                self.trial.extend(projected.map(|((r, f), &mu)| project(&(r - f * rho), mu)));
                fill_force(p, &self.trial, &mut self.trial_force);
                let (mut moved, mut changed) = (T::zero(), T::zero());
                for i in 0..self.r.len() {
                    moved += (self.r[i] - self.trial[i]).norm_squared();
                    changed += (self.force[i] - self.trial_force[i]).norm_squared();
                }
                if moved == T::zero() {
                    break self.settings.contraction;
                }
                let ratio = rho * ComplexField::sqrt(changed / moved);
                // Written so that a NaN ends the search.
                let refused = ratio > self.settings.contraction && rho > shortest;
                if !refused {
                    break ratio;
                }
                let shrink = (self.settings.contraction / ratio).min(T::one()).max(lit(0.1));
                rho *= shrink * lit::<T>(2.0 / 3.0);
            };
            match self.settings.projections {
                Projections::One => {
                    std::mem::swap(&mut self.r, &mut self.trial);
                    std::mem::swap(&mut self.force, &mut self.trial_force);
                }
                Projections::Two => {
                    for (i, r) in self.r.iter_mut().enumerate() {
                        *r = project(&(*r - self.trial_force[i] * rho), friction[i]);
                    }
                    fill_force(p, &self.r, &mut self.force);
                }
            }
            if ratio < self.settings.lengthen_below && rho < longest {
                rho *= lit::<T>(1.5);
            }
        }
        self.scaled.unscale_into(&self.best, r);
        Ok(iterations)
    }
}
