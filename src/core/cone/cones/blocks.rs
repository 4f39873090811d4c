//! The cone with rolling resistance, K = {‖r_B‖ ≤ c_B r_N, B = tangent, rolling, spinning}: one ball per block.

use nalgebra::{SMatrix, SVector};

use crate::scalar::Scalar;

/// A block of components with its coefficient.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block<T> {
    start: usize,
    end: usize,
    pub(crate) coefficient: T,
}

/// First and last component of the blocks: (T), (R) in the plane; (T1, T2), (R1, R2), (S) in space.
const PLANE: &[(usize, usize)] = &[(1, 2), (2, 3)];
const SPACE: &[(usize, usize)] = &[(1, 3), (3, 5), (5, 6)];

/// The blocks of a contact of dimension D, 3 (in the plane) or 6, with the coefficients μ, μ_R and μ_S.
#[inline(always)]
pub(crate) fn of<T: Scalar, const D: usize>(coefficients: [T; 3]) -> impl Iterator<Item = Block<T>> {
    let places = if D == 6 { SPACE } else { PLANE };
    // Components that a dimension does not have are left out: nothing is read beyond D.
    places
        .iter()
        .zip(coefficients)
        .filter(|((_, end), _)| *end <= D)
        .map(|(&(start, end), coefficient)| Block { start, end, coefficient })
}

impl<T: Scalar> Block<T> {
    /// The components.
    #[inline(always)]
    pub(crate) fn components(&self) -> std::ops::Range<usize> {
        self.start..self.end
    }

    /// ‖x_B‖.
    #[inline(always)]
    pub(crate) fn norm<const D: usize>(&self, x: &SVector<T, D>) -> T {
        if self.end - self.start == 1 {
            return nalgebra::ComplexField::abs(x[self.start]);
        }
        let square = self.components().fold(T::zero(), |sum, i| sum + x[i] * x[i]);
        nalgebra::ComplexField::sqrt(square)
    }
}

/// Σ_B c_B ‖x_B‖.
#[inline]
pub(in crate::cone) fn gauge<T: Scalar, const D: usize>(x: &SVector<T, D>, coefficients: [T; 3]) -> T {
    of::<T, D>(coefficients).fold(T::zero(), |sum, block| sum + block.coefficient * block.norm(x))
}

#[inline]
pub(crate) fn de_saxce<T: Scalar, const D: usize>(w: &SVector<T, D>, coefficients: [T; 3]) -> SVector<T, D> {
    let mut phi = *w;
    phi[0] += gauge(w, coefficients);
    phi
}

/// The normal component of the projection of `x` on K, and 1 + Σ c_B² over the blocks that are cut.
///
/// It is the zero of t − x_N − Σ_B c_B max(0, ‖x_B‖ − c_B t), increasing and piecewise linear in t: from the piece on which
/// every block is cut, blocks that turn out whole are dropped, which only raises t. Negative, or 0, where x lies in the polar
/// cone.
fn normal<T: Scalar, const D: usize>(x: &SVector<T, D>, coefficients: [T; 3]) -> (T, T) {
    let sums = |cut: &dyn Fn(T, T) -> bool| {
        of::<T, D>(coefficients).fold((x[0], T::one()), |(sum, weight), block| {
            let (c, norm) = (block.coefficient, block.norm(x));
            if cut(c, norm) { (sum + c * norm, weight + c * c) } else { (sum, weight) }
        })
    };
    let (mut sum, mut weight) = sums(&|_, _| true);
    if sum <= T::zero() {
        return (sum, weight);
    }
    // One block at least is dropped each time.
    for _ in 0..coefficients.len() {
        let t = sum / weight;
        let next = sums(&|c, norm| norm > c * t);
        if next.1 == weight {
            break;
        }
        (sum, weight) = next;
    }
    (sum / weight, weight)
}

pub(crate) fn project<T: Scalar, const D: usize>(x: &SVector<T, D>, coefficients: [T; 3]) -> SVector<T, D> {
    let (t, _) = normal(x, coefficients);
    if t <= T::zero() {
        return SVector::zeros();
    }
    let mut p = *x;
    p[0] = t;
    for block in of::<T, D>(coefficients) {
        let (radius, norm) = (block.coefficient * t, block.norm(x));
        if norm > radius {
            block.components().for_each(|i| p[i] = x[i] * (radius / norm));
        }
    }
    p
}

pub(in crate::cone) fn natural_map<T: Scalar, const D: usize>(
    r: &SVector<T, D>,
    x: &SVector<T, D>,
    coefficients: [T; 3],
) -> SVector<T, D> {
    let z = r - x;
    let (t, _) = normal(&z, coefficients);
    if t <= T::zero() {
        return *r;
    }
    let (mut f, mut whole) = (*x, true);
    for block in of::<T, D>(coefficients) {
        let (radius, norm) = (block.coefficient * t, block.norm(&z));
        if norm > radius {
            whole = false;
            block.components().for_each(|i| f[i] = r[i] - z[i] * (radius / norm));
        }
    }
    if !whole {
        f[0] = r[0] - t;
    }
    f
}

/// An element of the generalised Jacobian of the projection on K at `y`, `None` at and below the apex, where it is 0.
///
/// With the blocks A that are cut, ‖y_B‖ > c_B p_N, and τ_B = y_B/‖y_B‖,
///
/// ```text
///   p_N = (y_N + Σ_A c_B ‖y_B‖)/(1 + Σ_A c_B²),     p_B = c_B p_N τ_B,
///   p′ = a aᵀ/(1 + Σ_A c_B²) + Σ_A (c_B p_N/‖y_B‖)(I_B − τ_B τ_Bᵀ) + Σ_{B ∉ A} I_B,     a = (1, c_B τ_B of A, 0)
/// ```
pub(crate) fn slope<T: Scalar, const D: usize>(
    y: &SVector<T, D>,
    coefficients: [T; 3],
) -> Option<SMatrix<T, D, D>> {
    let (t, weight) = normal(y, coefficients);
    if t <= T::zero() {
        return None;
    }
    let mut along = SVector::<T, D>::zeros();
    along[0] = T::one();
    let mut slope = SMatrix::<T, D, D>::zeros();
    for block in of::<T, D>(coefficients) {
        let (radius, norm) = (block.coefficient * t, block.norm(y));
        if block.coefficient > T::zero() && norm <= radius {
            block.components().for_each(|i| slope[(i, i)] = T::one());
            continue;
        }
        if norm == T::zero() {
            continue;
        }
        let shrink = radius / norm;
        for i in block.components() {
            let tau = y[i] / norm;
            along[i] = block.coefficient * tau;
            for j in block.components() {
                let identity = if i == j { T::one() } else { T::zero() };
                slope[(i, j)] = shrink * (identity - tau * y[j] / norm);
            }
        }
    }
    Some(slope + along * along.transpose() / weight)
}

/// Alart and Curnier's map of one contact at z = r − w, ρ = 1: f_N = r_N − max(0, z_N), f_B = r_B − the projection of z_B on
/// the ball of radius c_B max(0, z_N).
pub(crate) fn alart_curnier<T: Scalar, const D: usize>(
    r: &SVector<T, D>,
    w: &SVector<T, D>,
    coefficients: [T; 3],
) -> SVector<T, D> {
    let z = r - w;
    if z[0] <= T::zero() {
        return *r;
    }
    let mut f = *w;
    for block in of::<T, D>(coefficients) {
        let (radius, norm) = (block.coefficient * z[0], block.norm(&z));
        if norm > radius {
            block.components().for_each(|i| f[i] = r[i] - z[i] * (radius / norm));
        }
    }
    f
}

/// An element of the generalised Jacobian of (z_N, the projection of z_B on the ball of radius c_B z_N), and whether that
/// is the identity; `None` where z_N ≤ 0, for 0.
pub(crate) fn ball_slope<T: Scalar, const D: usize>(
    z: &SVector<T, D>,
    coefficients: [T; 3],
) -> Option<(SMatrix<T, D, D>, bool)> {
    if z[0] <= T::zero() {
        return None;
    }
    let (mut slope, mut whole) = (SMatrix::<T, D, D>::zeros(), true);
    slope[(0, 0)] = T::one();
    for block in of::<T, D>(coefficients) {
        let (radius, norm) = (block.coefficient * z[0], block.norm(z));
        if norm <= radius && block.coefficient > T::zero() {
            block.components().for_each(|i| slope[(i, i)] = T::one());
            continue;
        }
        whole = false;
        if norm > T::zero() {
            for i in block.components() {
                let tau = z[i] / norm;
                slope[(i, 0)] = block.coefficient * tau;
                for j in block.components() {
                    let identity = if i == j { T::one() } else { T::zero() };
                    slope[(i, j)] = (radius / norm) * (identity - tau * z[j] / norm);
                }
            }
        }
    }
    Some((slope, whole))
}

/// Derivative of Φ at w: the identity, with c_B w_B/‖w_B‖ in the normal row.
pub(crate) fn de_saxce_slope<T: Scalar, const D: usize>(
    w: &SVector<T, D>,
    coefficients: [T; 3],
) -> SMatrix<T, D, D> {
    let mut slope = SMatrix::<T, D, D>::identity();
    for block in of::<T, D>(coefficients) {
        let norm = block.norm(w);
        if norm > T::zero() {
            block.components().for_each(|j| slope[(0, j)] = block.coefficient * w[j] / norm);
        }
    }
    slope
}
