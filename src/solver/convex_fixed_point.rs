//! Fixed point on the De Saxcé shift, one convex program per step.

use clarabel::solver::{DefaultSolver, IPSolver};
use nalgebra::SVector;

use super::anderson::Anderson;
use super::complementarity::tangential_norm;
use super::conic_program::{Unknowns, coulomb_cones, settings, symmetric_part, usable};
use super::scaling::Scaled;
use super::{Breakdown, ConeSolver, Control, Description, Family, SemismoothNewton, Stopping};
use super::{Feasibility, SemismoothNewtonSettings, feasibility};
use crate::cone::{ConeProblem, Workspace};
use crate::scalar::{Scalar, lit, to_f64};

/// What takes the interior-point solution to the tolerance, in the arithmetic of the problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polish {
    /// Nothing: the accuracy is the interior-point method's.
    None,
    /// Sweeps of exact one-contact solutions (count).
    Sweeps(usize),
    /// Steps of [`SemismoothNewton`] without its fallback (count).
    Newton(usize),
}

/// Settings of [`ConvexFixedPoint`].
#[derive(Debug, Clone)]
pub struct ConvexFixedPointSettings<T> {
    /// Tolerance and budget; the default budget is 200 convex programs.
    pub stopping: Stopping<T>,
    /// Gap and feasibility tolerance of a convex program (dimensionless, on the scaled problem). Default 1e-9.
    pub program_tolerance: f64,
    /// Largest number of interior-point iterations of a convex program (count). Default 100.
    pub program_iterations: u32,
    /// Steps the Anderson acceleration of s remembers (count, at most 10: more is taken as 10). Default 5; 0 is the
    /// plain fixed point.
    pub memory: usize,
    /// Part of the way from s to its image that a step takes (in (0, 1]). Default 1; each time 10 programs in a
    /// row bring no better iterate it is halved, down to 1/8, and s is restarted from another place.
    pub damping: T,
    /// Polish of the iterates. Default 25 Newton steps.
    pub polish: Polish,
}

impl<T: Scalar> Default for ConvexFixedPointSettings<T> {
    fn default() -> Self {
        Self {
            stopping: Stopping::default(),
            program_tolerance: 1e-9,
            program_iterations: 100,
            memory: 5,
            damping: T::one(),
            polish: Polish::Newton(25),
        }
    }
}

/// Fixed point on s_α = μ_α‖w_{T,α}‖: with s held, the cone problem is the optimality condition of
///
/// ```text
///   min ½ rᵀ W r + rᵀ (b + s e_N)   over r ∈ K
/// ```
///
/// solved by clarabel's interior-point method (in f64 whatever T is); then s ← μ‖w_T‖, with Anderson acceleration.
/// Acary, Cadoux, Lemaréchal & Malick (2011), doi:10.1002/zamm.201000073. Of an asymmetric W the program takes the
/// symmetric part, and the rest of W r goes to its linear term from the previous step. Without friction s = 0 and
/// the first program is the solution.
///
/// An interior-point solution with gap g has r only to √g on weakly active contacts, so an iterate is polished as
/// the settings say, whenever the residual has fallen tenfold, every tenth program, and at the end: the last digits
/// are the polish's, not the fixed point's. The fixed point is proven to converge for small μ only and may cycle for
/// large μ; the best iterate is returned then.
///
/// Choose it as an independent check on other solvers, or where the problem may have no solution: a program that is
/// unbounded says so, and [`feasibility`] gives the direction. It costs an interior-point solve per step.
#[derive(Debug)]
pub struct ConvexFixedPoint<T: Scalar, const D: usize> {
    settings: ConvexFixedPointSettings<T>,
    scaled: Scaled<T, D>,
    newton: SemismoothNewton<T, D>,
    anderson: Anderson<T, T>,
    x: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
    trial: Vec<SVector<T, D>>,
    shift: Vec<T>,
    image: Vec<T>,
    linear: Vec<f64>,
}

impl<T: Scalar, const D: usize> ConvexFixedPoint<T, D> {
    /// The solver with its settings.
    pub fn new(settings: ConvexFixedPointSettings<T>) -> Self {
        let polish = SemismoothNewtonSettings { fallback: false, ..SemismoothNewtonSettings::default() };
        let direct_steps = if let Polish::Newton(steps) = settings.polish { steps } else { 0 };
        Self {
            anderson: Anderson::new(settings.memory),
            newton: SemismoothNewton::new(SemismoothNewtonSettings { direct_steps, ..polish }),
            settings,
            scaled: Scaled::default(),
            x: Vec::new(),
            best: Vec::new(),
            trial: Vec::new(),
            shift: Vec::new(),
            image: Vec::new(),
            linear: Vec::new(),
        }
    }

    /// q = b + s e_N + (W − sym W) x on the unknowns.
    fn fill_linear(&mut self, unknowns: &Unknowns, remainder: &[SVector<T, D>]) {
        self.linear.clear();
        for (i, b) in self.scaled.problem().b().iter().enumerate() {
            let mut q = b + remainder[i];
            q[0] += self.shift[i];
            self.linear.extend(unknowns.range(i).enumerate().map(|(d, _)| to_f64(q[d])));
        }
    }

    /// μ‖w_T‖ of every contact at x, into `image`.
    fn fill_image(&mut self) {
        let problem = self.scaled.problem();
        self.image.clear();
        self.image.extend(problem.friction().iter().enumerate().map(|(i, &mu)| {
            if mu > T::zero() {
                mu * tangential_norm(&problem.shifted_velocity(i, &self.x))
            } else {
                T::zero()
            }
        }));
    }

    /// Another place to continue a cycle from: s between 0 and twice the images, spread over the contacts by the
    /// golden ratio so that no two restarts look alike.
    fn spread(&mut self, restart: usize) {
        let mean = self.image.iter().fold(T::zero(), |sum, &s| sum + s) / lit::<T>(self.image.len() as f64);
        for (i, (s, &image)) in self.shift.iter_mut().zip(&self.image).enumerate() {
            let place = ((restart * self.image.len() + i) as f64 * 0.618_033_988_749_894_9).fract();
            *s = if image > T::zero() { image.max(mean) * lit::<T>(2.0 * place) } else { image };
        }
    }

    /// ½ (W − Wᵀ) x.
    fn asymmetry(&self, into: &mut [SVector<T, D>]) {
        let w = self.scaled.delassus();
        into.fill(SVector::zeros());
        let half = lit::<T>(0.5);
        for i in 0..w.rows() {
            for (j, block) in w.row(i) {
                into[i] += block * self.x[j] * half;
                into[j] -= block.transpose() * self.x[i] * half;
            }
        }
    }

    /// Polishes `self.trial` (a percussion of the problem as given).
    fn polish(&mut self, problem: &ConeProblem<T, D>, control: &mut Control<'_, T>) {
        match self.settings.polish {
            Polish::None => {}
            Polish::Sweeps(sweeps) => {
                for _ in 0..sweeps {
                    for i in 0..self.trial.len() {
                        self.trial[i] = problem.solve_contact(i, &self.trial);
                    }
                }
            }
            Polish::Newton(steps) => {
                let mut stage = control.stage(control.tolerance(), steps);
                // A polish that breaks down leaves its best iterate, which is measured like any other.
                let _ = self.newton.iterate(problem, &mut self.trial, &mut stage);
            }
        }
    }
}

/// Programs without a better iterate before the fixed point is taken to cycle.
const STAGNATION: usize = 10;

impl<T: Scalar, const D: usize> Family<T> for ConvexFixedPoint<T, D> {
    const DESCRIPTION: Description = Description {
        name: "convex",
        title: "fixed point on the De Saxcé shift, a convex second-order cone program per step (clarabel)",
        when: "an independent check, or problems that may have no solution; small friction",
        reference: "Acary, Cadoux, Lemaréchal & Malick (2011), doi:10.1002/zamm.201000073",
    };

    fn with_stopping(stopping: Stopping<T>) -> Self {
        Self::new(ConvexFixedPointSettings { stopping, ..ConvexFixedPointSettings::default() })
    }
}

impl<T: Scalar, const D: usize> ConeSolver<T, D> for ConvexFixedPoint<T, D> {
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
        let breakdown = |iterations, message: String| Breakdown { iterations, message };
        self.best.clear();
        self.best.extend_from_slice(r);
        let mut workspace = Workspace::default();
        let mut best = problem.residual_in(r, &mut workspace).scaled;
        self.scaled.refill(problem);
        self.scaled.scale_into(r, &mut self.x);
        let cold = r.iter().all(|r| r.norm_squared() == T::zero());
        self.fill_image();
        self.shift.clear();
        self.shift.extend(self.image.iter().map(|&s| if cold { T::zero() } else { s }));
        let mut remainder = vec![SVector::zeros(); r.len()];
        self.asymmetry(&mut remainder);

        let unknowns = Unknowns::of(self.scaled.problem());
        let quadratic = symmetric_part(self.scaled.delassus(), &unknowns);
        let (rows, cones) = coulomb_cones(self.scaled.problem(), &unknowns);
        self.fill_linear(&unknowns, &remainder);
        if !crate::scalar::all_finite(&self.linear) || !crate::scalar::all_finite(&quadratic.nzval) {
            return Err(breakdown(0, "the scaled problem is not finite".into()));
        }
        let program = settings(self.settings.program_tolerance, self.settings.program_iterations);
        let mut program =
            DefaultSolver::new(&quadratic, &self.linear, &rows, &vec![0.0; rows.m], &cones, program)
                .map_err(|error| breakdown(0, error.to_string()))?;

        self.anderson.prepare(self.shift.len());
        let mut damping = self.settings.damping;
        let (mut polished_at, mut since_best, mut unbounded, mut restarts) = (T::infinity_impl(), 0, 0, 0);
        let budget = control.max_iterations(200);
        for step in 1..=budget {
            program.solve();
            let x = &program.solution.x;
            if !usable(program.solution.status) || !crate::scalar::all_finite(x) {
                // Unbounded below: a larger shift is the only thing that can bound it.
                unbounded += 1;
                if unbounded > 8 {
                    let status = program.solution.status;
                    return Err(breakdown(step, explain(problem, &format!("{status:?}"))));
                }
                let two = lit::<T>(2.0);
                self.shift.iter_mut().zip(problem.friction()).for_each(|(s, &mu)| *s = *s * two + mu);
                self.anderson.forget();
            } else {
                for (i, x_i) in self.x.iter_mut().enumerate() {
                    *x_i = SVector::zeros();
                    unknowns.range(i).enumerate().for_each(|(d, k)| x_i[d] = lit(x[k]));
                }
                self.trial.clear();
                self.trial.extend_from_slice(r);
                self.scaled.unscale_into(&self.x, &mut self.trial);
                let mut residual = problem.residual_in(&self.trial, &mut workspace).scaled;
                let due = residual <= polished_at * lit::<T>(0.1) || step % 10 == 0 || step == budget;
                if residual > control.tolerance() && due {
                    polished_at = residual;
                    self.polish(problem, control);
                    residual = problem.residual_in(&self.trial, &mut workspace).scaled;
                }
                since_best += 1;
                if residual < best {
                    (best, since_best) = (residual, 0);
                    self.best.copy_from_slice(&self.trial);
                }
                self.fill_image();
                for (image, &s) in self.image.iter_mut().zip(&self.shift) {
                    *image = s + (*image - s) * damping;
                }
                let mut next = self.image.clone();
                self.anderson.accelerate(&self.shift, &mut next, std::iter::repeat(T::one()));
                next.iter_mut().for_each(|s| *s = s.max(T::zero()));
                self.shift = next;
                if since_best >= STAGNATION && problem.solved_to_rounding(&self.best, best, &mut workspace) {
                    r.copy_from_slice(&self.best);
                    return Ok(step);
                }
                if since_best >= STAGNATION {
                    restarts += 1;
                    damping = (damping * lit::<T>(0.5)).max(lit::<T>(0.125));
                    since_best = 0;
                    polished_at = T::infinity_impl();
                    self.spread(restarts);
                    self.anderson.forget();
                }
            }
            if !control.proceed(step, best) || best <= control.tolerance() || step == budget {
                r.copy_from_slice(&self.best);
                return Ok(step);
            }
            self.asymmetry(&mut remainder);
            self.fill_linear(&unknowns, &remainder);
            program.update_q(&self.linear).map_err(|error| breakdown(step, error.to_string()))?;
        }
        Ok(budget)
    }
}

/// Why a convex program has no solution, in words.
fn explain<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>, status: &str) -> String {
    match feasibility(problem) {
        Ok(Feasibility::Separated { margin, .. }) => {
            let margin = to_f64(margin);
            format!(
                "no percussion brings every velocity into K* (scaled margin {margin:.3e}): clarabel {status}"
            )
        }
        _ => format!("clarabel stopped with {status}"),
    }
}
