//! The exact solution of one contact: w = W r + b, K* ∋ Φ(w) ⟂ r ∈ K with W a D×D block.
//!
//! Take-off where b_N ≥ 0. Otherwise w_N = 0 and, with r_N eliminated,
//!
//! ```text
//!   (S + αI) r_T = −β,   S = W_TT − W_TN W_NT/W_NN,   β = b_T − W_TN b_N/W_NN,   w_T = −α r_T,
//!   r_N(α) = −(b_N + W_NT r_T)/W_NN
//! ```
//!
//! The contact sticks (α = 0) where ‖r_T(0)‖ ≤ μ r_N(0); else it slides, with ‖r_T(α)‖ = μ r_N(α) and α > 0.

use nalgebra::{ComplexField, SMatrix, SVector};

use crate::scalar::{Scalar, epsilon, lit};

/// The percussion of one contact with Delassus block `w` (W_NN > 0), velocity `b` without it, friction μ ≥ 0.
///
/// It satisfies the inclusion to a few tens of ε against (1 + μ)(‖b‖ + ‖W‖‖r‖), the block being singular or not, and
/// slightly asymmetric or not. Where several solutions exist (Painlevé: b_N ≥ 0 and W_NN ≤ μ|W_NT|) the contact
/// takes off; where none exists (never for W ≻ 0) the result is the candidate of the smallest slip, and the
/// caller's residual shows it.
#[inline]
pub fn solve_one_contact<T: Scalar, const D: usize>(
    w: &SMatrix<T, D, D>,
    b: &SVector<T, D>,
    friction: T,
) -> SVector<T, D> {
    solve_one_contact_from(w, b, friction, &mut T::zero())
}

/// [`solve_one_contact`] with a first guess of the slip's α = −w_T/r_T in `alpha` (0 is no guess), which is
/// replaced by the one found: the last sweep's value makes the root-finder end at its first evaluation.
#[inline(always)]
pub fn solve_one_contact_from<T: Scalar, const D: usize>(
    w: &SMatrix<T, D, D>,
    b: &SVector<T, D>,
    friction: T,
    alpha: &mut T,
) -> SVector<T, D> {
    match D {
        // Selections instead of branches: in a sweep the statuses follow no pattern a processor could predict.
        1 => {
            let normal = -b[0] / w[(0, 0)];
            vector(if normal > T::zero() { normal } else { T::zero() }, [T::zero(); 2])
        }
        2 => planar(w, b, friction),
        _ if b[0] >= T::zero() => SVector::zeros(),
        _ if friction == T::zero() => vector(-b[0] / w[(0, 0)], [T::zero(); 2]),
        _ => spatial(w, b, friction, alpha),
    }
}

#[inline(always)]
fn vector<T: Scalar, const D: usize>(normal: T, tangential: [T; 2]) -> SVector<T, D> {
    SVector::from_fn(|i, _| if i == 0 { normal } else { tangential[i - 1] })
}

/// A singular S is regularised by this much of W_TT: below the rounding of S, so that the slip it lets through
/// is rounding too.
#[inline(always)]
fn floor<T: Scalar>(tangential_trace: T) -> T {
    lit::<T>(4.0) * epsilon::<T>() * tangential_trace
}

/// In the plane r_T(α) keeps the sign of −β and r_N(α)/|r_T(α)| is affine in α: no iteration.
#[inline(always)]
fn planar<T: Scalar, const D: usize>(w: &SMatrix<T, D, D>, b: &SVector<T, D>, friction: T) -> SVector<T, D> {
    let (nn, nt, tn, tt) = (w[(0, 0)], w[(0, 1)], w[(1, 0)], w[(1, 1)]);
    let inverse = T::one() / nn;
    let s = tt - tn * nt * inverse;
    let s = if s > floor(tt) { s } else { floor(tt) };
    let beta = b[1] - tn * b[0] * inverse;
    let side = if beta > T::zero() { -friction } else { friction };
    // |r_T| ≤ μ r_N at α = 0, multiplied out; the stiffness is that of the slide r_T = ±μ r_N.
    let stiffness = nn + side * nt;
    let sticks = ComplexField::abs(beta) * stiffness <= -friction * b[0] * s;
    // β = 0 also where W_TT = 0, which would leave 0/0.
    let stuck = if beta == T::zero() { T::zero() } else { -beta / s };
    let sliding = -b[0] / stiffness;
    let tangential = if sticks { stuck } else { side * sliding };
    let normal = if sticks { -(b[0] + nt * stuck) * inverse } else { sliding };
    let closed = b[0] < T::zero();
    let select = |x: T| if closed { x } else { T::zero() };
    vector(select(normal), [select(tangential), T::zero()])
}

/// The data of one contact with r_N eliminated.
struct Eliminated<T> {
    /// S in rows, not symmetrised: W may be slightly asymmetric, and is solved as given.
    s: [[T; 2]; 2],
    beta: [T; 2],
    /// W_NT/W_NN.
    coupling: [T; 2],
    /// −b_N/W_NN.
    normal: T,
}

/// r_T and r_N at one α, with their derivatives.
struct Slip<T> {
    t: [T; 2],
    dt: [T; 2],
    n: T,
    dn: T,
}

impl<T: Scalar> Eliminated<T> {
    #[inline(always)]
    fn new<const D: usize>(w: &SMatrix<T, D, D>, b: &SVector<T, D>) -> Self {
        let inverse = T::one() / w[(0, 0)];
        let coupling = [w[(0, 1)] * inverse, w[(0, 2)] * inverse];
        let normal = -b[0] * inverse;
        let row = |i: usize| {
            let tn = w[(i, 0)];
            [w[(i, 1)] - tn * coupling[0], w[(i, 2)] - tn * coupling[1]]
        };
        let beta = [b[1] + w[(1, 0)] * normal, b[2] + w[(2, 0)] * normal];
        Self { s: [row(1), row(2)], beta, coupling, normal }
    }

    /// r_N for r_T = `t`.
    #[inline(always)]
    fn normal(&self, t: [T; 2]) -> T {
        self.normal - dot(self.coupling, t)
    }

    /// det(S + αI), `None` where S + αI is not positive.
    #[inline(always)]
    fn determinant(&self, alpha: T, least: T) -> Option<T> {
        let (p, q) = (self.s[0][0] + alpha, self.s[1][1] + alpha);
        let determinant = p * q - self.s[0][1] * self.s[1][0];
        (determinant > least * (p + q) && p + q > T::zero()).then_some(determinant)
    }

    /// −(S + αI)⁻¹ x by the nonsymmetric 2×2 formula.
    #[inline(always)]
    fn solve(&self, alpha: T, inverse: T, x: [T; 2]) -> [T; 2] {
        let (p, q) = (self.s[0][0] + alpha, self.s[1][1] + alpha);
        [(self.s[0][1] * x[1] - q * x[0]) * inverse, (self.s[1][0] * x[0] - p * x[1]) * inverse]
    }

    /// r_T(α). The 2×2 formula alone leaves a residual of cond(S)·ε, one refinement leaves (cond(S)·ε)² + ε; an
    /// ill-conditioned S is eliminated with a pivot instead.
    #[inline(always)]
    fn tangential(&self, alpha: T, determinant: T) -> [T; 2] {
        let [[a, c1], [c2, d]] = self.s;
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
        let [[_, c1], [c2, _]] = self.s;
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

    #[inline(always)]
    fn slip(&self, alpha: T, determinant: T) -> Slip<T> {
        let t = self.tangential(alpha, determinant);
        let dt = self.solve(alpha, T::one() / determinant, t);
        Slip { t, dt, n: self.normal(t), dn: -dot(self.coupling, dt) }
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

#[inline(always)]
fn spatial<T: Scalar, const D: usize>(
    w: &SMatrix<T, D, D>,
    b: &SVector<T, D>,
    friction: T,
    alpha: &mut T,
) -> SVector<T, D> {
    let contact = Eliminated::new(w, b);
    if contact.beta == [T::zero(); 2] {
        return vector(contact.normal, [T::zero(); 2]);
    }
    if *alpha > T::zero()
        && let Some(r) = slide_again(&contact, friction, w, alpha)
    {
        return r;
    }
    let floor = floor(w[(1, 1)] + w[(2, 2)]);
    let (least, determinant) = match contact.determinant(T::zero(), floor) {
        Some(determinant) => (T::zero(), Some(determinant)),
        None => (floor, contact.determinant(floor, T::zero())),
    };
    let mut outside = None;
    if let Some(determinant) = determinant {
        let t = contact.tangential(least, determinant);
        let n = contact.normal(t);
        if n >= T::zero() && dot(t, t) <= friction * friction * n * n {
            return vector(n, t);
        }
        outside = Some(t);
    }
    let t = slide(&contact, friction, least, floor, outside, alpha);
    let length = norm(t);
    // Along r_T, w_N = 0 gives r_N: on the cone to the last digit.
    let reach = friction / length;
    let direction = [t[0] * reach, t[1] * reach];
    let stiffness = w[(0, 0)] + w[(0, 1)] * direction[0] + w[(0, 2)] * direction[1];
    // Where the slide has little stiffness of its own, b_N/stiffness would magnify the rounding of the direction.
    let normal = if stiffness > lit::<T>(0.1) * w[(0, 0)] { -b[0] / stiffness } else { length / friction };
    vector(normal, [direction[0] * normal, direction[1] * normal])
}

/// The slide of a contact that slid before, from its last α: at most three evaluations, `None` where they do not settle
/// it or the block is not round enough for them.
#[inline(always)]
fn slide_again<T: Scalar, const D: usize>(
    contact: &Eliminated<T>,
    friction: T,
    w: &SMatrix<T, D, D>,
    alpha: &mut T,
) -> Option<SVector<T, D>> {
    let trace = contact.s[0][0] + contact.s[1][1];
    if w[(0, 0)] < lit::<T>(0.05) * (w[(1, 1)] + w[(2, 2)]) {
        return None;
    }
    let mut current = *alpha;
    for _ in 0..3 {
        let twice = trace + current + current;
        let determinant = contact.determinant(current, T::zero())?;
        if !is_round(determinant, twice) {
            return None;
        }
        let inverse = T::one() / determinant;
        let t = contact.solve(current, inverse, contact.beta);
        let dt = contact.solve(current, inverse, t);
        let (n, dn) = (contact.normal(t), -dot(contact.coupling, dt));
        let length = T::one() / norm(t);
        let h = friction * n * length - T::one();
        let slope = friction * length * (dn - n * dot(t, dt) * length * length);
        let step = h / slope;
        let next = current - step;
        if !(slope > T::zero() && next > T::zero()) {
            return None;
        }
        let reach = step * twice * inverse;
        let last = lit::<T>(0.01) * epsilon::<T>();
        if h * h <= last && reach * reach <= last {
            *alpha = next;
            let t = [t[0] - step * dt[0], t[1] - step * dt[1]];
            return Some(vector(contact.normal(t), t));
        }
        current = next;
    }
    None
}

/// r_T of the slide (its length not yet exact): Newton on h(α) = μ r_N/‖r_T‖ − 1 inside a bracket low < α < high
/// with h(low) < 0 < h(high), bisection or growth as a guard. `outside` is r_T at `least`, `resolution` the rounding
/// of S: where the bracket is narrower, both its ends solve (S + αI) r_T = −β, and so does what lies between.
#[inline(always)]
fn slide<T: Scalar>(
    contact: &Eliminated<T>,
    friction: T,
    least: T,
    resolution: T,
    mut outside: Option<[T; 2]>,
    found: &mut T,
) -> [T; 2] {
    let trace = contact.s[0][0] + contact.s[1][1];
    let mut alpha = *found;
    if !(alpha > least) {
        let along = T::one() + friction * norm(contact.coupling);
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
