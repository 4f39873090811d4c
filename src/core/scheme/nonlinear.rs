//! The θ-step of nonlinear systems, and the discrete balance it satisfies.
//!
//! For d/dt (M(q) v) − ∂_q T + ∇V + d = F + Hᵀ r with T = ½ v·M(q) v, the step from (q₀, v₀) to (q₁, v₁),
//! Δq = q₁ − q₀ = h v_θ, v_θ = (1−θ) v₀ + θ v₁, is
//!
//! ```text
//!   M₁ v₁ − M₀ v₀ − h ∇̄T + h ∇̄V + h d(t_θ, q_θ, v_θ) = h F_θ + H(q₀)ᵀ p                               (N)
//! ```
//!
//! with discrete derivatives D_iM and ∇̄V, equal to ∂_iM and ∇V at the midpoint plus the smallest correction that
//! makes the mean value theorem exact (Gonzalez 1996, doi:10.1007/BF02440162):
//!
//! ```text
//!   Σ_i D_iM Δq_i = M₁ − M₀,     ∇̄V·Δq = V₁ − V₀
//!   ∇̄T_i = v_θ·D_iM v̄ − ¼ (v₁·D_iM v₁ + v₀·D_iM v₀),     v̄ = ½ (v₀ + v₁)
//! ```
//!
//! (at θ = ½ simply ∇̄T_i = ½ v₀·D_iM v₁). With M̄ = ½ (M₀ + M₁), M₁v₁ − M₀v₀ = M̄ (v₁ − v₀) + (M₁ − M₀) v̄ and
//!
//! ```text
//!   v_θ·M̄ (v₁ − v₀) = ½ (‖v₁‖²_M̄ − ‖v₀‖²_M̄) + (θ − ½) ‖v₁ − v₀‖²_M̄
//!   T₁ − T₀         = ½ (‖v₁‖²_M̄ − ‖v₀‖²_M̄) + ¼ (v₁·(M₁−M₀) v₁ + v₀·(M₁−M₀) v₀)
//!   h v_θ·∇̄T        = v_θ·(M₁−M₀) v̄ − ¼ (v₁·(M₁−M₀) v₁ + v₀·(M₁−M₀) v₀)
//! ```
//!
//! so that (N) times v_θ is the balance
//!
//! ```text
//!   (T + V)₁ − (T + V)₀ = h v_θ·F_θ − h v_θ·d + (½−θ) ‖v₁ − v₀‖²_M̄ + Σ_α u_θ·p + v_θ·ρ
//! ```
//!
//! with ρ what the iteration left of (N): it closes to the tolerance of the nonlinear solve, for every law and every
//! θ, and the contact works are those of the linear scheme, u_θ = H(q₀) v_θ, so that a law keeps the sign it claims.
//! M constant and V = ½ q·Kq give ∇̄V = K q_{k+½}: for θ = ½ this is the linear step.
//!
//! (N) is solved by Newton's method with the symmetric part of its Jacobian at v₀ kept over the step, M̂; every iterate
//! solves a cone problem with W = H M̂⁻¹ Hᵀ and the free velocity v − M̂⁻¹ ρ₀(v), ρ₀ being (N) without the contacts.
//! What M̂ is changes the number of iterations alone: at their end (N) holds, and the law at exactly the velocities and
//! percussions returned.

use nalgebra::{Cholesky, DMatrix};

use crate::linalg::{Factor, axpy, dot, max_abs};
use crate::scalar::{Scalar, epsilon, lit};
use crate::system::NonlinearTerms;

/// Terms of (N) at the state and at the iterate.
#[derive(Debug)]
pub(super) struct Nonlinear<T: Scalar> {
    /// M(q_k), M(q_{k+1}).
    mass: [DMatrix<T>; 2],
    potential: [T; 2],
    /// D_iM.
    derivatives: Vec<DMatrix<T>>,
    change: DMatrix<T>,
    gradient: Vec<T>,
    other: Vec<T>,
    middle: Vec<T>,
    next_q: Vec<T>,
    mean: Vec<T>,
    difference: Vec<T>,
    product: Vec<T>,
    /// ρ₀ and its neighbours.
    residual: Vec<T>,
    moved: Vec<T>,
    trial: Vec<T>,
    matrix: DMatrix<T>,
}

/// Where a step starts: (t, h, θ), q_k, v_k, F_θ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start<'a, T> {
    pub(super) time: T,
    pub(super) step: T,
    pub(super) theta: T,
    pub(super) q: &'a [T],
    pub(super) v: &'a [T],
    pub(super) force: &'a [T],
}

fn multiply<T: Scalar>(a: &DMatrix<T>, x: &[T], y: &mut [T]) {
    y.fill(T::zero());
    for (column, &x) in a.column_iter().zip(x) {
        axpy(y, x, column.as_slice());
    }
}

/// x·A y.
fn form<T: Scalar>(x: &[T], a: &DMatrix<T>, y: &[T]) -> T {
    a.column_iter().zip(y).fold(T::zero(), |sum, (column, &y)| sum + dot(x, column.as_slice()) * y)
}

fn largest<T: Scalar>(a: &DMatrix<T>) -> T {
    max_abs(a.as_slice())
}

/// x with what rounding could have made of it taken away: the correction of a discrete derivative divides by ‖Δq‖, and
/// is not to divide rounding.
fn beyond<T: Scalar>(x: T, rounding: T) -> T {
    if x > rounding {
        x - rounding
    } else if x < -rounding {
        x + rounding
    } else {
        T::zero()
    }
}

impl<T: Scalar> Nonlinear<T> {
    pub(super) fn new(dynamics: &dyn NonlinearTerms<T>, q: &[T]) -> Self {
        let n = q.len();
        let (square, zeros) = (|| DMatrix::zeros(n, n), || vec![T::zero(); n]);
        let mut mass = square();
        dynamics.mass(q, &mut mass);
        let potential = dynamics.potential(q);
        Self {
            mass: [mass, square()],
            potential: [potential; 2],
            derivatives: (0..n).map(|_| square()).collect(),
            change: square(),
            gradient: zeros(),
            other: zeros(),
            middle: zeros(),
            next_q: zeros(),
            mean: zeros(),
            difference: zeros(),
            product: zeros(),
            residual: zeros(),
            moved: zeros(),
            trial: zeros(),
            matrix: square(),
        }
    }

    /// The state is q.
    pub(super) fn start_from(&mut self, dynamics: &dyn NonlinearTerms<T>, q: &[T]) {
        dynamics.mass(q, &mut self.mass[0]);
        self.potential[0] = dynamics.potential(q);
    }

    /// ½ v·M v and V of the state.
    pub(super) fn energies(&self, v: &[T]) -> (T, T) {
        (form(v, &self.mass[0], v) * lit::<T>(0.5), self.potential[0])
    }

    /// residual ← ρ₀(v₁), (N) without the contacts, all on the left.
    fn evaluate(&mut self, dynamics: &dyn NonlinearTerms<T>, start: Start<'_, T>, v: &[T]) {
        let Start { time, step: h, theta, q, v: v0, force } = start;
        let (half, quarter, one) = (lit::<T>(0.5), lit::<T>(0.25), T::one());
        let n = q.len();
        let mut squared = T::zero();
        for i in 0..n {
            let v_theta = (one - theta) * v0[i] + theta * v[i];
            self.next_q[i] = q[i] + h * v_theta;
            self.middle[i] = q[i] + (h * v_theta) * half;
            self.mean[i] = (v0[i] + v[i]) * half;
            self.difference[i] = v[i] - v0[i];
            self.product[i] = v_theta;
            squared += (h * v_theta) * (h * v_theta);
        }
        let rounding = lit::<T>(8.0) * epsilon::<T>();
        dynamics.mass(&self.next_q, &mut self.mass[1]);
        self.change.copy_from(&self.mass[1]);
        self.change -= &self.mass[0];
        // What ∂M at the midpoint leaves of M₁ − M₀ goes along Δq.
        self.matrix.copy_from(&self.change);
        for (i, derivative) in self.derivatives.iter_mut().enumerate() {
            dynamics.mass_derivative(&self.middle, i, derivative);
            axpy(self.matrix.as_mut_slice(), -(h * self.product[i]), derivative.as_slice());
        }
        if squared > T::zero() {
            let floor = rounding * largest(&self.mass[0]);
            self.matrix.iter_mut().for_each(|x| *x = beyond(*x, floor) / squared);
            for (derivative, &v_theta) in self.derivatives.iter_mut().zip(&self.product) {
                axpy(derivative.as_mut_slice(), h * v_theta, self.matrix.as_slice());
            }
        }
        self.potential[1] = dynamics.potential(&self.next_q);
        dynamics.potential_gradient(&self.middle, &mut self.gradient);
        if squared > T::zero() {
            let [before, after] = self.potential;
            let left = (after - before) - h * dot(&self.gradient, &self.product);
            let size = nalgebra::ComplexField::abs(before) + nalgebra::ComplexField::abs(after);
            let correction = beyond(left, rounding * size) / squared;
            axpy(&mut self.gradient, correction * h, &self.product);
        }
        // Time and configuration at k + θ for the forces without potential.
        self.residual.copy_from_slice(q);
        axpy(&mut self.residual, theta, &self.next_q);
        axpy(&mut self.residual, -theta, q);
        dynamics.other_forces(time + theta * h, &self.residual, &self.product, &mut self.other);
        for (i, &force) in force.iter().enumerate() {
            let d = &self.derivatives[i];
            let kinetic = form(&self.product, d, &self.mean) - quarter * (form(v, d, v) + form(v0, d, v0));
            self.residual[i] = h * (self.gradient[i] + self.other[i] - force - kinetic);
        }
        let v_theta = &mut self.moved;
        // M̄ (v₁ − v₀) + (M₁ − M₀) v̄: small differences are not taken of large momenta.
        multiply(&self.mass[0], &self.difference, v_theta);
        axpy(&mut self.residual, half, v_theta);
        multiply(&self.mass[1], &self.difference, v_theta);
        axpy(&mut self.residual, half, v_theta);
        multiply(&self.change, &self.mean, v_theta);
        axpy(&mut self.residual, one, v_theta);
    }

    /// Sets M̂, the symmetric part of ∂ρ₀/∂v₁ at v₁ = v_k by differences, in `factor`; M(q_k) where that is not positive
    /// definite. `speed` scales the differences. `false` if M(q_k) is not positive definite either.
    pub(super) fn linearise(
        &mut self,
        dynamics: &dyn NonlinearTerms<T>,
        start: Start<'_, T>,
        speed: T,
        factor: &mut Factor<T>,
    ) -> bool {
        let n = start.q.len();
        let Factor::Dense(cholesky) = factor else { return false };
        let mut matrix =
            std::mem::replace(cholesky, Cholesky::pack_dirty(DMatrix::zeros(0, 0))).unpack_dirty();
        let delta = nalgebra::ComplexField::sqrt(epsilon::<T>()) * speed;
        let mut trial = std::mem::take(&mut self.trial);
        trial.copy_from_slice(start.v);
        for j in 0..n {
            for (sign, weight) in [(T::one(), lit::<T>(0.5)), (-T::one(), lit::<T>(-0.5))] {
                trial[j] = start.v[j] + sign * delta;
                self.evaluate(dynamics, start, &trial);
                let scale = weight / delta;
                for i in 0..n {
                    let old = if sign > T::zero() { T::zero() } else { matrix[(i, j)] };
                    matrix[(i, j)] = old + self.residual[i] * scale;
                }
            }
            trial[j] = start.v[j];
        }
        self.trial = trial;
        for j in 0..n {
            for i in 0..j {
                let mean = (matrix[(i, j)] + matrix[(j, i)]) * lit::<T>(0.5);
                (matrix[(i, j)], matrix[(j, i)]) = (mean, mean);
            }
        }
        let mut done = lower_factor(&mut matrix);
        if !done {
            matrix.copy_from(&self.mass[0]);
            done = lower_factor(&mut matrix);
        }
        *cholesky = Cholesky::pack_dirty(matrix);
        done
    }

    /// v_free ← v − M̂⁻¹ ρ₀(v).
    pub(super) fn free_velocity(
        &mut self,
        dynamics: &dyn NonlinearTerms<T>,
        start: Start<'_, T>,
        v: &[T],
        factor: &mut Factor<T>,
        v_free: &mut [T],
    ) {
        self.evaluate(dynamics, start, v);
        v_free.copy_from_slice(&self.residual);
        factor.solve_in_place(v_free);
        v_free.iter_mut().zip(v).for_each(|(x, &v)| *x = v - *x);
    }

    /// ‖ρ‖∞ / (‖M₀v₀‖∞ + ‖M₁v₁‖∞ + h ‖F‖∞ + h ‖∇V‖∞ + ‖Hᵀp‖∞) for the impulse Hᵀp, at v.
    pub(super) fn left_over(
        &mut self,
        dynamics: &dyn NonlinearTerms<T>,
        start: Start<'_, T>,
        v: &[T],
        impulse: &[T],
    ) -> T {
        self.evaluate(dynamics, start, v);
        axpy(&mut self.residual, -T::one(), impulse);
        let mut scale = max_abs(impulse) + start.step * (max_abs(start.force) + max_abs(&self.gradient));
        multiply(&self.mass[0], start.v, &mut self.moved);
        scale += max_abs(&self.moved);
        multiply(&self.mass[1], v, &mut self.moved);
        scale += max_abs(&self.moved);
        if scale > T::zero() { max_abs(&self.residual) / scale } else { max_abs(&self.residual) }
    }

    /// (T₁ − T₀, V₁ − V₀, −h v_θ·d, ‖v₁ − v₀‖²_M̄) of the step evaluated last, which ends at v.
    pub(super) fn changes(&self, start: Start<'_, T>, v: &[T]) -> (T, T, T, T) {
        let (half, quarter) = (lit::<T>(0.5), lit::<T>(0.25));
        let mean = |x: &[T], y: &[T]| (form(x, &self.mass[0], y) + form(x, &self.mass[1], y)) * half;
        let kinetic = mean(&self.difference, &self.mean)
            + quarter * (form(v, &self.change, v) + form(start.v, &self.change, start.v));
        let [before, after] = self.potential;
        let damping = -start.step * dot(&self.product, &self.other);
        (kinetic, after - before, damping, mean(&self.difference, &self.difference))
    }

    /// ½ v·M₁ v and V₁ of the step evaluated last.
    pub(super) fn next_energies(&self, v: &[T]) -> (T, T) {
        (form(v, &self.mass[1], v) * lit::<T>(0.5), self.potential[1])
    }

    /// The end of the step becomes the state.
    pub(super) fn accept(&mut self) {
        self.mass.swap(0, 1);
        self.potential[0] = self.potential[1];
    }
}

/// A = L Lᵀ in place, L in the lower triangle; `false` at a pivot that is not positive.
fn lower_factor<T: Scalar>(a: &mut DMatrix<T>) -> bool {
    let n = a.nrows();
    for j in 0..n {
        let mut pivot = a[(j, j)];
        for k in 0..j {
            pivot -= a[(j, k)] * a[(j, k)];
        }
        if !(pivot > T::zero()) {
            return false;
        }
        let root = nalgebra::ComplexField::sqrt(pivot);
        a[(j, j)] = root;
        for i in j + 1..n {
            let mut x = a[(i, j)];
            for k in 0..j {
                x -= a[(i, k)] * a[(j, k)];
            }
            a[(i, j)] = x / root;
        }
    }
    true
}
