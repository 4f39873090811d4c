//! Fixed point on the De Saxcé shift, one convex program per step.

use clarabel::solver::{DefaultSolver, IPSolver, SolverStatus};
use nalgebra::SVector;

use super::anderson::Anderson;
use super::cone_solver::{Description, Iteration, Method};
use super::conic_program::{Unknowns, coulomb_cones, settings, symmetric_part, usable};
use super::control::Control;
use super::error::{Breakdown, BreakdownCause, ProgramError};
use super::feasibility::{Feasibility, feasibility};
use super::newton::{Plan, ProximalPoint, Scaling};
use super::settings::{Interval, SettingsError, check_depth, setters};
use crate::cone::{BlockMatrix, ConeProblem, Workspace, dual_gauge};
use crate::scalar::{Scalar, lit, to_f64};

/// What takes the interior-point solution to the tolerance, in the arithmetic of the problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Polish {
    /// Nothing: the accuracy is the interior-point method's.
    None,
    /// Sweeps of exact one-contact solutions (count).
    Sweeps(usize),
    /// Steps of [`SemismoothNewton`](super::SemismoothNewton) without its fallback (count).
    Newton(usize),
}

/// Settings of [`ConvexFixedPoint`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ConvexFixedPointSettings<T> {
    /// Gap and feasibility tolerance of a convex program (dimensionless, on the scaled problem, in (0, 1)). Default 1e-9.
    pub program_tolerance: f64,
    /// Largest number of interior-point iterations of a convex program (count). Default 100.
    pub program_iterations: u32,
    /// Steps the Anderson acceleration of s remembers (count, at most 10). Default 5; 0 is the plain fixed point.
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
            program_tolerance: 1e-9,
            program_iterations: 100,
            memory: 5,
            damping: T::one(),
            polish: Polish::Newton(25),
        }
    }
}

setters!(ConvexFixedPointSettings<T>:
    with_program_tolerance(program_tolerance: f64),
    with_program_iterations(program_iterations: u32),
    with_memory(memory: usize),
    with_damping(damping: T),
    with_polish(polish: Polish),
);

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
    scaling: Scaling<T>,
    scaled: ConeProblem<T, D>,
    newton: ProximalPoint<T, D>,
    anderson: Anderson<T, T>,
    x: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
    trial: Vec<SVector<T, D>>,
    shift: Vec<T>,
    image: Vec<T>,
    linear: Vec<f64>,
}

impl<T: Scalar, const D: usize> ConvexFixedPoint<T, D> {
    /// q = b + s e_N + (W − sym W) x on the unknowns.
    fn fill_linear(&mut self, unknowns: &Unknowns, remainder: &[SVector<T, D>]) {
        self.linear.clear();
        for (i, b) in self.scaled.b().iter().enumerate() {
            let mut q = b + remainder[i];
            q[0] += self.shift[i];
            self.linear.extend(unknowns.range(i).enumerate().map(|(d, _)| to_f64(q[d])));
        }
    }

    /// μ‖w_T‖ of every contact at x, into `image`.
    fn fill_image(&mut self) {
        let problem = &self.scaled;
        self.image.clear();
        let shift = |(i, &cone)| dual_gauge(&problem.shifted_velocity(i, &self.x), cone);
        self.image.extend(problem.cones().iter().enumerate().map(shift));
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
        let Some(w) = self.scaled.delassus().formed() else { return };
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
                let direct = Plan { direct_steps: steps, fallback: false, ..Plan::default() };
                let _ = self.newton.run(problem, &mut self.trial, &direct, 0, &mut stage);
            }
        }
    }
}

/// Programs without a better iterate before the fixed point is taken to cycle.
const STAGNATION: usize = 10;

impl<T: Scalar, const D: usize> Method<T, D> for ConvexFixedPoint<T, D> {
    const DESCRIPTION: Description = Description {
        name: "convex",
        title: "fixed point on the De Saxcé shift, a convex second-order cone program per step (clarabel)",
        when: "an independent check, or problems that may have no solution; small friction",
        reference: "Acary, Cadoux, Lemaréchal & Malick (2011), doi:10.1002/zamm.201000073",
        iteration: Iteration::Program,
    };
    type Settings = ConvexFixedPointSettings<T>;

    fn new(settings: ConvexFixedPointSettings<T>) -> Result<Self, SettingsError> {
        Interval::Open(0.0, 1.0).check("program_tolerance", settings.program_tolerance)?;
        Interval::LeftOpen(0.0, 1.0).check("damping", settings.damping)?;
        check_depth("memory", settings.memory)?;
        Ok(Self {
            anderson: Anderson::new(settings.memory),
            newton: ProximalPoint::new(),
            settings,
            scaling: Scaling::new(),
            scaled: ConeProblem::default(),
            x: Vec::new(),
            best: Vec::new(),
            trial: Vec::new(),
            shift: Vec::new(),
            image: Vec::new(),
            linear: Vec::new(),
        })
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        let refused = BreakdownCause::Refused;
        self.best.clear();
        self.best.extend_from_slice(r);
        let mut workspace = Workspace::default();
        let mut best = problem.residual_in(r, &mut workspace).scaled;
        self.scaling = Scaling::of(problem);
        self.scaled = self.scaling.scaled(problem);
        self.scaling.enter(r, &mut self.x);
        let cold = r.iter().all(|r| r.norm_squared() == T::zero());
        self.fill_image();
        self.shift.clear();
        self.shift.extend(self.image.iter().map(|&s| if cold { T::zero() } else { s }));
        let mut remainder = vec![SVector::zeros(); r.len()];
        self.asymmetry(&mut remainder);

        let unknowns = Unknowns::of(&self.scaled);
        let quadratic = symmetric_part(self.scaled.delassus().form_in(&mut BlockMatrix::new()), &unknowns);
        let (rows, cones) = coulomb_cones(&self.scaled, &unknowns);
        self.fill_linear(&unknowns, &remainder);
        if !crate::scalar::all_finite(&self.linear) || !crate::scalar::all_finite(&quadratic.nzval) {
            return Err(Breakdown::new(0, BreakdownCause::NotFinite));
        }
        let program = settings(self.settings.program_tolerance, self.settings.program_iterations);
        let mut program =
            DefaultSolver::new(&quadratic, &self.linear, &rows, &vec![0.0; rows.m], &cones, program)
                .map_err(|error| Breakdown::new(0, refused(ProgramError::new(error))))?;

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
                    return Err(Breakdown::new(step, explain(problem, status)));
                }
                let two = lit::<T>(2.0);
                for (s, cone) in self.shift.iter_mut().zip(problem.cones()) {
                    *s = cone.coefficients().iter().fold(*s * two, |s, &c| s + c);
                }
                self.anderson.forget();
            } else {
                for (i, x_i) in self.x.iter_mut().enumerate() {
                    *x_i = SVector::zeros();
                    unknowns.range(i).enumerate().for_each(|(d, k)| x_i[d] = lit(x[k]));
                }
                self.trial.clear();
                self.trial.extend_from_slice(r);
                self.scaling.leave(&self.x, &mut self.trial);
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
            program
                .update_q(&self.linear)
                .map_err(|error| Breakdown::new(step, refused(ProgramError::new(error))))?;
        }
        Ok(budget)
    }
}

/// Why a convex program has no solution.
fn explain<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>, status: SolverStatus) -> BreakdownCause {
    match feasibility(problem) {
        Ok(Feasibility::Separated { margin, .. }) => {
            BreakdownCause::Separated { margin: to_f64(margin), status }
        }
        _ => BreakdownCause::Program { status },
    }
}
