//! The exact solution in space: one root-finder on the slip's α.

use nalgebra::{ComplexField, SMatrix, SVector};

use super::{floor, vector};
use crate::scalar::{Scalar, epsilon, lit};

/// The block of one contact with r_N eliminated, whatever b.
#[derive(Debug, Clone)]
pub(super) struct Spatial<T> {
    /// 1/W_NN and W_TN.
    inverse: T,
    lever: [T; 2],
    /// W_NT/W_NN.
    coupling: [T; 2],
    /// S in rows, not symmetrised: W may be slightly asymmetric, and is solved as given.
    s: [[T; 2]; 2],
    /// −S⁻¹ where the block is round enough for it.
    stick: Option<[[T; 2]; 2]>,
    /// tr W_TT and μ.
    tangential: T,
    friction: T,
}

impl<T: Scalar> Spatial<T> {
    #[inline(always)]
    pub(super) fn new<const D: usize>(w: &SMatrix<T, D, D>, friction: T) -> Self {
        let inverse = T::one() / w[(0, 0)];
        let coupling = [w[(0, 1)] * inverse, w[(0, 2)] * inverse];
        let lever = [w[(1, 0)], w[(2, 0)]];
        let row = |i: usize| [w[(i, 1)] - lever[i - 1] * coupling[0], w[(i, 2)] - lever[i - 1] * coupling[1]];
        let s = [row(1), row(2)];
        let determinant = s[0][0] * s[1][1] - s[0][1] * s[1][0];
        let tangential = w[(1, 1)] + w[(2, 2)];
        let round = is_round(determinant, s[0][0] + s[1][1]) && w[(0, 0)] >= lit::<T>(0.05) * tangential;
        let stick = round.then(|| {
            let inverse = T::one() / determinant;
            [[-s[1][1] * inverse, s[0][1] * inverse], [s[1][0] * inverse, -s[0][0] * inverse]]
        });
        Self { inverse, lever, coupling, s, stick, tangential, friction }
    }

    /// r for the velocity `b` without it; `alpha` as in [`solve_one_contact_from`](super::solve_one_contact_from).
    ///
    /// Take-off, stick and slide are all computed and one is taken: in a sweep the statuses follow no pattern a processor
    /// could predict, and a wrong guess costs it more than the arithmetic.
    #[inline(always)]
    pub(super) fn solve<const D: usize>(&self, b: &SVector<T, D>, alpha: &mut T) -> SVector<T, D> {
        let Some(stick) = self.stick else { return self.search(b, alpha) };
        let contact = Eliminated::new(self, b);
        let stuck = [dot(stick[0], contact.beta), dot(stick[1], contact.beta)];
        let n = contact.normal(stuck);
        let limit = self.friction * n;
        let mut slip = contact.newton_step(*alpha);
        let (closed, opens) = (b[0] < T::zero(), n < T::zero());
        let slides = opens | (dot(stuck, stuck) > limit * limit);
        if closed & slides & !slip.settled {
            slip = contact.newton_step(slip.alpha);
            if !slip.settled {
                slip = contact.newton_step(slip.alpha);
            }
            if !slip.settled {
                return self.search(b, alpha);
            }
        }
        *alpha = [*alpha, slip.alpha][usize::from(closed & slides)];
        let outcomes =
            [[T::zero(); 3], [n, stuck[0], stuck[1]], [contact.normal(slip.t), slip.t[0], slip.t[1]]];
        let [n, t1, t2] = outcomes[usize::from(closed) * (1 + usize::from(slides))];
        vector(n, [t1, t2])
    }

    /// r by the general search: no first guess, or a block that is not round.
    #[cold]
    #[inline(never)]
    fn search<const D: usize>(&self, b: &SVector<T, D>, alpha: &mut T) -> SVector<T, D> {
        let friction = self.friction;
        if b[0] >= T::zero() {
            return SVector::zeros();
        }
        if friction == T::zero() {
            return vector(-b[0] * self.inverse, [T::zero(); 2]);
        }
        let contact = Eliminated::new(self, b);
        if contact.beta == [T::zero(); 2] {
            return vector(contact.normal, [T::zero(); 2]);
        }
        let mut outside = None;
        let smallest = floor(self.tangential);
        let at_rest = contact.determinant(T::zero(), smallest);
        let least = if at_rest.is_some() { T::zero() } else { smallest };
        let determinant = at_rest.or_else(|| contact.determinant(smallest, T::zero()));
        let stuck = determinant.map(|determinant| contact.tangential(least, determinant));
        if let Some(t) = stuck {
            let n = contact.normal(t);
            if n >= T::zero() && dot(t, t) <= friction * friction * n * n {
                return vector(n, t);
            }
            outside = Some(t);
        }
        let t = slide(&contact, least, smallest, outside, alpha);
        let length = norm(t);
        // Along r_T, w_N = 0 gives r_N: on the cone to the last digit.
        let reach = friction / length;
        let direction = [t[0] * reach, t[1] * reach];
        let along = T::one() + dot(self.coupling, direction);
        // Where the slide has little stiffness of its own, b_N/stiffness would magnify the rounding of the direction.
        let normal = if along > lit::<T>(0.1) { contact.normal / along } else { length / friction };
        vector(normal, [direction[0] * normal, direction[1] * normal])
    }
}

/// The problem of one contact with r_N eliminated.
struct Eliminated<'a, T> {
    block: &'a Spatial<T>,
    beta: [T; 2],
    /// −b_N/W_NN.
    normal: T,
}

/// r_T and α after a Newton step.
struct Step<T> {
    t: [T; 2],
    alpha: T,
    settled: bool,
}

/// r_T and r_N at one α, with their derivatives.
struct Slip<T> {
    t: [T; 2],
    dt: [T; 2],
    n: T,
    dn: T,
}

impl<'a, T: Scalar> Eliminated<'a, T> {
    #[inline(always)]
    fn new<const D: usize>(block: &'a Spatial<T>, b: &SVector<T, D>) -> Self {
        let normal = -b[0] * block.inverse;
        let beta = [b[1] + block.lever[0] * normal, b[2] + block.lever[1] * normal];
        Self { block, beta, normal }
    }

    /// r_N for r_T = `t`.
    #[inline(always)]
    fn normal(&self, t: [T; 2]) -> T {
        self.normal - dot(self.block.coupling, t)
    }

    /// det(S + αI), `None` where S + αI is not positive.
    #[inline(always)]
    fn determinant(&self, alpha: T, least: T) -> Option<T> {
        let (p, q) = (self.block.s[0][0] + alpha, self.block.s[1][1] + alpha);
        let determinant = p * q - self.block.s[0][1] * self.block.s[1][0];
        (determinant > least * (p + q) && p + q > T::zero()).then_some(determinant)
    }

    /// −(S + αI)⁻¹ x by the nonsymmetric 2×2 formula.
    #[inline(always)]
    fn solve(&self, alpha: T, inverse: T, x: [T; 2]) -> [T; 2] {
        let (p, q) = (self.block.s[0][0] + alpha, self.block.s[1][1] + alpha);
        [(self.block.s[0][1] * x[1] - q * x[0]) * inverse, (self.block.s[1][0] * x[0] - p * x[1]) * inverse]
    }

    /// r_T(α). The 2×2 formula alone leaves a residual of cond(S)·ε, one refinement leaves (cond(S)·ε)² + ε; an
    /// ill-conditioned S is eliminated with a pivot instead.
    #[inline(always)]
    fn tangential(&self, alpha: T, determinant: T) -> [T; 2] {
        let [[a, c1], [c2, d]] = self.block.s;
        let (p, q) = (a + alpha, d + alpha);
        if determinant < ComplexField::sqrt(epsilon::<T>()) * (p + q) * (p + q) {
            return self.eliminate(p, q);
        }
        let inverse = T::one() / determinant;
        let t = self.solve(alpha, inverse, self.beta);
        if is_round(determinant, p + q) {
            return t;
        }
        let rest = [self.beta[0] + p * t[0] + c1 * t[1], self.beta[1] + c2 * t[0] + q * t[1]];
        let correction = self.solve(alpha, inverse, rest);
        [t[0] + correction[0], t[1] + correction[1]]
    }

    /// Gaussian elimination with the larger diagonal entry as pivot.
    fn eliminate(&self, p: T, q: T) -> [T; 2] {
        let [[_, c1], [c2, _]] = self.block.s;
        let [x, y] = self.beta;
        if p >= q {
            let l = c2 / p;
            let t = (l * x - y) / (q - l * c1);
            [-(x + c1 * t) / p, t]
        } else {
            let l = c1 / q;
            let t = (l * y - x) / (p - l * c2);
            [t, -(y + c2 * t) / q]
        }
    }

    /// One Newton step on h from `alpha`; it has settled where what it leaves is rounding.
    #[inline(always)]
    fn newton_step(&self, alpha: T) -> Step<T> {
        let (block, friction) = (self.block, self.block.friction);
        let (p, q) = (block.s[0][0] + alpha, block.s[1][1] + alpha);
        let inverse = T::one() / (p * q - block.s[0][1] * block.s[1][0]);
        let t = self.solve(alpha, inverse, self.beta);
        let dt = self.solve(alpha, inverse, t);
        let (n, dn) = (self.normal(t), -dot(block.coupling, dt));
        let length = T::one() / norm(t);
        let h = friction * n * length - T::one();
        let slope = friction * length * (dn - n * dot(t, dt) * length * length);
        let step = h / slope;
        let reach = step * (p + q) * inverse;
        let last = lit::<T>(0.01) * epsilon::<T>();
        let next = alpha - step;
        // Where α = 0, or anything is not a number, a comparison fails.
        let settled = (h * h <= last)
            & (reach * reach <= last)
            & (slope > T::zero())
            & (next > T::zero())
            & (alpha > T::zero());
        Step { t: [t[0] - step * dt[0], t[1] - step * dt[1]], alpha: next, settled }
    }

    #[inline(always)]
    fn slip(&self, alpha: T, determinant: T) -> Slip<T> {
        let t = self.tangential(alpha, determinant);
        let dt = self.solve(alpha, T::one() / determinant, t);
        Slip { t, dt, n: self.normal(t), dn: -dot(self.block.coupling, dt) }
    }

    /// The point of the segment from `inside` (μ r_N > ‖r_T‖) to `outside` the cone that is on the cone.
    #[cold]
    fn blend(&self, friction: T, mut inside: [T; 2], mut outside: [T; 2]) -> [T; 2] {
        for _ in 0..60 {
            let half = lit::<T>(0.5);
            let middle = [(inside[0] + outside[0]) * half, (inside[1] + outside[1]) * half];
            if norm(middle) < friction * self.normal(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }
}

/// Whether a 2×2 matrix has a condition number below about 14, so that its explicit inverse is as good as elimination.
#[inline(always)]
fn is_round<T: Scalar>(determinant: T, trace: T) -> bool {
    determinant > lit::<T>(0.0625) * trace * trace
}

#[inline(always)]
fn dot<T: Scalar>(x: [T; 2], y: [T; 2]) -> T {
    x[0] * y[0] + x[1] * y[1]
}

#[inline(always)]
fn norm<T: Scalar>(x: [T; 2]) -> T {
    ComplexField::sqrt(dot(x, x))
}

/// r_T of the slide (its length not yet exact): Newton on h(α) = μ r_N/‖r_T‖ − 1 inside a bracket low < α < high
/// with h(low) < 0 < h(high), bisection or growth as a guard. `outside` is r_T at `least`, `resolution` the rounding
/// of S: where the bracket is narrower, both its ends solve (S + αI) r_T = −β, and so does what lies between.
#[inline(always)]
fn slide<T: Scalar>(
    contact: &Eliminated<'_, T>,
    least: T,
    resolution: T,
    mut outside: Option<[T; 2]>,
    found: &mut T,
) -> [T; 2] {
    let (block, friction) = (contact.block, contact.block.friction);
    let trace = block.s[0][0] + block.s[1][1];
    let mut alpha = *found;
    if !(alpha > least) {
        let along = T::one() + friction * norm(block.coupling);
        let guess = norm(contact.beta) * along / (friction * contact.normal) - trace * lit::<T>(0.5);
        let small = trace * lit::<T>(0.5e-3) + lit::<T>(4.0) * least;
        alpha = if guess > small { guess } else { small };
    }
    let (mut low, mut high) = (least, None::<(T, [T; 2])>);
    for _ in 0..100 {
        if !(alpha < T::infinity_impl()) {
            break;
        }
        let mut newton = None;
        if let Some(determinant) = contact.determinant(alpha, T::zero()) {
            let slip = contact.slip(alpha, determinant);
            let inverse = T::one() / norm(slip.t);
            if !(inverse < T::infinity_impl()) {
                break;
            }
            let h = friction * slip.n * inverse - T::one();
            // dh/dα; h is nearly affine, as 1/‖r_T‖ is in trust-region subproblems.
            let slope = friction * inverse * (slip.dn - slip.n * dot(slip.t, slip.dt) * inverse * inverse);
            let step = h / slope;
            // Against the smallest eigenvalue of S + αI a step this small squares below rounding: its first-order
            // effect on r_T ends the search.
            let reach = step * (trace + alpha + alpha) / determinant;
            let last = lit::<T>(0.01) * epsilon::<T>();
            let well = determinant > ComplexField::sqrt(epsilon::<T>()) * trace * trace;
            if slope > T::zero() && h * h <= last && reach * reach <= last && alpha - step > least && well {
                *found = alpha - step;
                return [slip.t[0] - step * slip.dt[0], slip.t[1] - step * slip.dt[1]];
            }
            if h < T::zero() {
                (low, outside) = (alpha, Some(slip.t));
            } else {
                high = Some((alpha, slip.t));
            }
            newton = (slope > T::zero()).then(|| alpha - step);
        } else {
            low = alpha;
        }
        if high.is_some_and(|(high, _)| high - low <= resolution) {
            break;
        }
        alpha = match (newton, high) {
            (Some(next), Some((high, _))) if next > low && next < high => next,
            (Some(next), None) if next > low => next,
            (_, None) => alpha * lit::<T>(4.0) + resolution,
            (_, Some((high, _))) if high > lit::<T>(16.0) * (low + resolution) => {
                ComplexField::sqrt(low + resolution) * ComplexField::sqrt(high)
            }
            (_, Some((high, _))) => (low + high) * lit::<T>(0.5),
        };
    }
    *found = low;
    match (high, outside) {
        (Some((_, inside)), Some(outside)) => contact.blend(friction, inside, outside),
        (Some((_, t)), None) | (None, Some(t)) if low > least || high.is_some() => t,
        // Friction so weak that α overflows: r_T → −β/α.
        _ => [-contact.beta[0], -contact.beta[1]],
    }
}
