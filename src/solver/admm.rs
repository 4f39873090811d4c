//! Alternating direction method of multipliers with the De Saxcé shift updated on the way.

use std::iter::repeat;

use nalgebra::{ComplexField, SMatrix, SVector};

use super::anderson::Anderson;
use super::complementarity::tangential_norm;
use super::newton_matrix::NewtonMatrix;
use super::scaling::Scaled;
use super::{Breakdown, ConeSolver, Control, Description, Family, Stopping};
use crate::cone::{ConeProblem, de_saxce, project};
use crate::scalar::{Scalar, lit};

/// Settings of [`Admm`].
#[derive(Debug, Clone)]
pub struct AdmmSettings<T> {
    /// Tolerance and budget; the default budget is 20,000 iterations (one linear solve each).
    pub stopping: Stopping<T>,
    /// First penalty ρ, relative to λ_max(W_αα) = 1 (dimensionless, > 0). Default 1.
    pub penalty: T,
    /// Iterations between two looks at the penalty (count). Default 20; 0 keeps it.
    pub adapt_every: usize,
    /// Primal over dual residual, or its inverse, beyond which the penalty is changed and W + ρI factored again
    /// (dimensionless, > 1). Default 5.
    pub imbalance: T,
    /// Over-relaxation of r (dimensionless, in (0, 2)). Default 1.5.
    pub relaxation: T,
    /// Iterations the Anderson acceleration remembers (count, at most 10: more is taken as 10). Default 10; 0 is the
    /// plain method.
    pub memory: usize,
}

impl<T: Scalar> Default for AdmmSettings<T> {
    fn default() -> Self {
        Self {
            stopping: Stopping::default(),
            penalty: T::one(),
            adapt_every: 20,
            imbalance: lit(5.0),
            relaxation: lit(1.5),
            memory: 10,
        }
    }
}

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
/// and converges; with s moving there is no proof. Choose it for small friction and moderate accuracy on problems
/// too ill-conditioned for Gauss–Seidel; for large friction it may cycle, and it then reports the best iterate.
#[derive(Debug)]
pub struct Admm<T: Scalar, const D: usize> {
    settings: AdmmSettings<T>,
    scaled: Scaled<T, D>,
    matrix: NewtonMatrix<T, D>,
    anderson: Anderson<T, T>,
    r: Vec<SVector<T, D>>,
    z: Vec<SVector<T, D>>,
    z_old: Vec<SVector<T, D>>,
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
    /// The solver with its settings.
    pub fn new(settings: AdmmSettings<T>) -> Self {
        Self {
            anderson: Anderson::new(settings.memory),
            settings,
            scaled: Scaled::default(),
            matrix: NewtonMatrix::default(),
            r: Vec::new(),
            z: Vec::new(),
            z_old: Vec::new(),
            best: Vec::new(),
            state: Vec::new(),
            image: Vec::new(),
        }
    }

    fn factor(&mut self, penalty: T) -> Result<(), String> {
        let identity = SMatrix::identity();
        self.matrix.factor(self.scaled.delassus(), |_| Some((identity, identity * penalty)))
    }

    /// One iteration from the state to its image; the primal and dual residuals ‖r − z‖ and ρ‖z − z_old‖.
    fn step(&mut self, penalty: T) -> Result<(T, T), String> {
        let problem = self.scaled.problem();
        let (friction, kappa) = (problem.friction(), self.settings.relaxation);
        std::mem::swap(&mut self.z, &mut self.z_old);
        self.z.clear();
        self.r.clear();
        for (i, state) in self.state.chunks_exact(D + 1).enumerate() {
            let v = SVector::<T, D>::from_column_slice(&state[..D]);
            let z = project(&v, friction[i]);
            // z − y = 2 z − v.
            let mut rhs = (z * lit::<T>(2.0) - v) * penalty - problem.b()[i];
            rhs[0] -= state[D];
            self.z.push(z);
            self.r.push(rhs);
        }
        self.matrix.solve(&mut self.r)?;
        self.image.clear();
        let (mut primal, mut dual) = (T::zero(), T::zero());
        for (i, state) in self.state.chunks_exact(D + 1).enumerate() {
            let v = SVector::<T, D>::from_column_slice(&state[..D]);
            let (r, z) = (&self.r[i], &self.z[i]);
            let y = v - z;
            self.image.extend((r * kappa + z * (T::one() - kappa) + y).iter().copied());
            // W r + b + s e_N = ρ (z − y − r): its tangential part is w_T.
            let slip = tangential_norm(&((z - y - r) * penalty));
            self.image.push(if friction[i] > T::zero() { friction[i] * slip } else { T::zero() });
            primal += (r - z).norm_squared();
            dual += (z - self.z_old.get(i).unwrap_or(z)).norm_squared();
        }
        Ok((ComplexField::sqrt(primal), penalty * ComplexField::sqrt(dual)))
    }

    /// Residual of z on the problem as given.
    fn residual(&self) -> T {
        let problem = self.scaled.problem();
        let square = self.z.iter().enumerate().fold(T::zero(), |sum, (i, z)| {
            let mu = problem.friction()[i];
            let phi = de_saxce(&problem.shifted_velocity(i, &self.z), mu);
            sum + self.scaled.residual_square(i, &(z - project(&(z - phi), mu)))
        });
        ComplexField::sqrt(square)
    }

    /// The state of a new penalty: ρ y stays.
    fn rescale(&mut self, ratio: T) {
        for (state, &mu) in self.state.chunks_exact_mut(D + 1).zip(self.scaled.problem().friction()) {
            let v = SVector::<T, D>::from_column_slice(&state[..D]);
            let z = project(&v, mu);
            state[..D].copy_from_slice((z + (v - z) * ratio).as_slice());
        }
    }
}

impl<T: Scalar, const D: usize> Family<T> for Admm<T, D> {
    const DESCRIPTION: Description = Description {
        name: "admm",
        title: "alternating direction method of multipliers, adaptive penalty, Anderson acceleration",
        when: "small friction and moderate accuracy on ill-conditioned problems",
        reference: "Boyd et al. (2011), doi:10.1561/2200000016",
    };

    fn with_stopping(stopping: Stopping<T>) -> Self {
        Self::new(AdmmSettings { stopping, ..AdmmSettings::default() })
    }
}

impl<T: Scalar, const D: usize> ConeSolver<T, D> for Admm<T, D> {
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
        let breakdown = |iterations, message| Breakdown { iterations, message };
        self.scaled.refill(problem);
        self.scaled.scale_into(r, &mut self.z);
        self.best.clone_from(&self.z);
        let mut best = self.residual();
        let mut penalty = self.settings.penalty;
        self.matrix.analyse(self.scaled.delassus()).map_err(|m| breakdown(0, m))?;
        self.factor(penalty).map_err(|m| breakdown(0, m))?;
        // z = r, y = −Φ(w)/ρ, s = μ‖w_T‖: the state the method would end in if r were the solution.
        self.state.clear();
        for (i, z) in self.z.iter().enumerate() {
            let mu = self.scaled.problem().friction()[i];
            let w = self.scaled.problem().shifted_velocity(i, &self.z);
            self.state.extend((z - de_saxce(&w, mu) / penalty).iter().copied());
            self.state.push(mu * tangential_norm(&w));
        }
        self.anderson.prepare(self.state.len());
        let budget = control.max_iterations(DEFAULT_ITERATIONS);
        let mut outcome = Ok(budget);
        let (mut improved, mut plain_until) = (0, 0);
        for iteration in 1..=budget {
            let (primal, dual) = match self.step(penalty) {
                Ok(residuals) => residuals,
                Err(message) => {
                    outcome = Err(breakdown(iteration, message));
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
                    if let Err(message) = self.factor(penalty) {
                        outcome = Err(breakdown(iteration, message));
                        break;
                    }
                }
            }
        }
        self.scaled.unscale_into(&self.best, r);
        outcome
    }
}
