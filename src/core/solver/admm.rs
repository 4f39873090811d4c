//! Alternating direction method of multipliers with the De Saxcé shift updated on the way.

use std::iter::repeat;

use nalgebra::{ComplexField, SVector};

use super::anderson::Anderson;
use super::cone_solver::{Description, Iteration, Method};
use super::control::Control;
use super::error::{Breakdown, BreakdownCause};
use super::newton::ScaledProblem;
use super::settings::{Interval, SettingsError, check_depth, setters};
use crate::cone::{ConeProblem, de_saxce, dual_gauge, project};
use crate::scalar::{Scalar, all_finite, lit};

/// Settings of [`Admm`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AdmmSettings<T> {
    /// First penalty ρ, relative to λ_max(W_αα) = 1 (dimensionless, > 0). Default 1.
    pub penalty: T,
    /// Iterations between two looks at the penalty (count). Default 20; 0 keeps it.
    pub adapt_every: usize,
    /// Primal over dual residual, or its inverse, beyond which the penalty is changed and W + ρI factored again
    /// (dimensionless, > 1). Default 5.
    pub imbalance: T,
    /// Over-relaxation of r (dimensionless, in (0, 2)). Default 1.5.
    pub relaxation: T,
    /// Iterations the Anderson acceleration remembers (count, at most 10). Default 10; 0 is the plain method.
    pub memory: usize,
}

impl<T: Scalar> Default for AdmmSettings<T> {
    fn default() -> Self {
        Self { penalty: T::one(), adapt_every: 20, imbalance: lit(5.0), relaxation: lit(1.5), memory: 10 }
    }
}

setters!(AdmmSettings<T>:
    with_penalty(penalty: T),
    with_adapt_every(adapt_every: usize),
    with_imbalance(imbalance: T),
    with_relaxation(relaxation: T),
    with_memory(memory: usize),
);

/// ADMM on the problem scaled to λ_max(W_αα) = 1, with y the scaled multiplier and s the De Saxcé shift:
///
/// ```text
///   (W + ρI) r = ρ (z − y) − b − s e_N,     s ← μ‖w_T‖,
///   z ← proj_K(κ r + (1−κ) z + y),          y ← y + κ r + (1−κ) z_old − z
/// ```
///
/// accelerated by Anderson's method on (z + y, s), with ρ raised or lowered by the square root of the imbalance of
/// ‖r − z‖ and ρ‖z − z_old‖. Boyd et al. (2011), doi:10.1561/2200000016; for frictional contact Tasora, Mangoni,
/// Benatti & Garziera (2021), doi:10.1002/nme.6693.
///
/// One factorisation serves many iterations, and moderate accuracy comes soon. With s held this is a convex program
/// and converges; with s moving there is no proof. Default budget: 20,000 iterations. Choose it for small
/// friction and moderate accuracy on problems
/// too ill-conditioned for Gauss–Seidel; for large friction it may cycle, and it then reports the best iterate.
#[derive(Debug)]
pub struct Admm<T: Scalar, const D: usize> {
    settings: AdmmSettings<T>,
    scaled: ScaledProblem<T, D>,
    anderson: Anderson<T, T>,
    r: Vec<SVector<T, D>>,
    z: Vec<SVector<T, D>>,
    z_old: Vec<SVector<T, D>>,
    w: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
    /// (z + y, s), D + 1 numbers per contact, and its image.
    state: Vec<T>,
    image: Vec<T>,
}

/// Default budget.
const DEFAULT_ITERATIONS: usize = 20_000;
/// Iterations after which the penalty is left alone, so that the method ends as one of a fixed penalty.
const LAST_ADAPTATION: usize = 4_000;
/// Iterations without a new best iterate after which the acceleration rests, and for how long: it may cycle where the
/// plain method converges.
const STAGNATION: usize = 500;

impl<T: Scalar, const D: usize> Admm<T, D> {
    /// One iteration from the state to its image; the primal and dual residuals ‖r − z‖ and ρ‖z − z_old‖.
    fn step(&mut self, penalty: T) -> Result<(T, T), BreakdownCause> {
        let (cones, kappa) = (self.scaled.cones(), self.settings.relaxation);
        std::mem::swap(&mut self.z, &mut self.z_old);
        self.z.clear();
        self.r.clear();
        for (i, state) in self.state.chunks_exact(D + 1).enumerate() {
            let v = SVector::<T, D>::from_column_slice(&state[..D]);
            let z = project(&v, cones[i]);
            // z − y = 2 z − v.
            let mut rhs = (z * lit::<T>(2.0) - v) * penalty - self.scaled.b()[i];
            rhs[0] -= state[D];
            self.z.push(z);
            self.r.push(rhs);
        }
        self.scaled.solve_regularised(&mut self.r);
        if !self.r.iter().all(|r| all_finite(r.iter())) {
            return Err(BreakdownCause::NotFinite);
        }
        let cones = self.scaled.cones();
        self.image.clear();
        let (mut primal, mut dual) = (T::zero(), T::zero());
        for (i, state) in self.state.chunks_exact(D + 1).enumerate() {
            let v = SVector::<T, D>::from_column_slice(&state[..D]);
            let (r, z) = (&self.r[i], &self.z[i]);
            let y = v - z;
            self.image.extend((r * kappa + z * (T::one() - kappa) + y).iter().copied());
            // W r + b + s e_N = ρ (z − y − r): its tangential part is w_T.
            self.image.push(dual_gauge(&((z - y - r) * penalty), cones[i]));
            primal += (r - z).norm_squared();
            dual += (z - self.z_old.get(i).unwrap_or(z)).norm_squared();
        }
        Ok((ComplexField::sqrt(primal), penalty * ComplexField::sqrt(dual)))
    }

    fn factor(&mut self, penalty: T) -> Result<(), BreakdownCause> {
        self.scaled.factor_regularised(penalty).map_err(BreakdownCause::Singular)
    }

    /// Residual of z on the problem as given; its velocity is left in `self.w`.
    fn residual(&mut self) -> T {
        self.w.resize(self.z.len(), SVector::zeros());
        self.scaled.velocity(&self.z, &mut self.w);
        self.scaled.residual(&self.z, &self.w)
    }

    /// The state of a new penalty: ρ y stays.
    fn rescale(&mut self, ratio: T) {
        for (state, &cone) in self.state.chunks_exact_mut(D + 1).zip(self.scaled.cones()) {
            let v = SVector::<T, D>::from_column_slice(&state[..D]);
            let z = project(&v, cone);
            state[..D].copy_from_slice((z + (v - z) * ratio).as_slice());
        }
    }
}

impl<T: Scalar, const D: usize> Method<T, D> for Admm<T, D> {
    const DESCRIPTION: Description = Description {
        name: "admm",
        title: "alternating direction method of multipliers, adaptive penalty, Anderson acceleration",
        when: "small friction and moderate accuracy on ill-conditioned problems",
        reference: "Boyd et al. (2011), doi:10.1561/2200000016",
        iteration: Iteration::Sweep,
    };
    type Settings = AdmmSettings<T>;

    fn new(settings: AdmmSettings<T>) -> Result<Self, SettingsError> {
        Interval::Open(0.0, f64::INFINITY).check("penalty", settings.penalty)?;
        Interval::Open(1.0, f64::INFINITY).check("imbalance", settings.imbalance)?;
        Interval::Open(0.0, 2.0).check("relaxation", settings.relaxation)?;
        check_depth("memory", settings.memory)?;
        let [r, z, z_old, w, best] = std::array::from_fn(|_| Vec::new());
        let (scaled, anderson) = (ScaledProblem::new(), Anderson::new(settings.memory));
        let (state, image) = (Vec::new(), Vec::new());
        Ok(Self { settings, scaled, anderson, r, z, z_old, w, best, state, image })
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        self.scaled.prepare(problem);
        self.scaled.enter(r, &mut self.z);
        self.best.clone_from(&self.z);
        let mut best = self.residual();
        let mut penalty = self.settings.penalty;
        self.factor(penalty).map_err(|cause| Breakdown::new(0, cause))?;
        // z = r, y = −Φ(w)/ρ, s = μ‖w_T‖: the state the method would end in if r were the solution.
        self.state.clear();
        for (i, z) in self.z.iter().enumerate() {
            let (cone, w) = (self.scaled.cones()[i], &self.w[i]);
            self.state.extend((z - de_saxce(w, cone) / penalty).iter().copied());
            self.state.push(dual_gauge(w, cone));
        }
        self.anderson.prepare(self.state.len());
        let budget = control.max_iterations(DEFAULT_ITERATIONS);
        let mut outcome = Ok(budget);
        let (mut improved, mut plain_until) = (0, 0);
        for iteration in 1..=budget {
            let (primal, dual) = match self.step(penalty) {
                Ok(residuals) => residuals,
                Err(cause) => {
                    outcome = Err(Breakdown::new(iteration, cause));
                    break;
                }
            };
            let residual = self.residual();
            if residual < best {
                best = residual;
                improved = iteration;
                self.best.copy_from_slice(&self.z);
            }
            if !control.proceed(iteration, best) || best <= control.tolerance() {
                outcome = Ok(iteration);
                break;
            }
            if iteration > improved.max(plain_until) + STAGNATION {
                plain_until = iteration + STAGNATION;
                self.anderson.forget();
            }
            if iteration >= plain_until {
                self.anderson.accelerate(&self.state, &mut self.image, repeat(T::one()));
            }
            std::mem::swap(&mut self.state, &mut self.image);
            let due = self.settings.adapt_every > 0 && iteration % self.settings.adapt_every == 0;
            if due && iteration <= LAST_ADAPTATION && primal > T::zero() && dual > T::zero() {
                let ratio = primal / dual;
                if ratio > self.settings.imbalance || ratio * self.settings.imbalance < T::one() {
                    let change = ComplexField::sqrt(ratio).max(lit(0.1)).min(lit(10.0));
                    let next = (penalty * change).max(lit(1e-6)).min(lit(1e6));
                    self.rescale(penalty / next);
                    penalty = next;
                    self.anderson.forget();
                    if let Err(cause) = self.factor(penalty) {
                        outcome = Err(Breakdown::new(iteration, cause));
                        break;
                    }
                }
            }
        }
        self.scaled.leave(&self.best, r);
        outcome
    }
}
