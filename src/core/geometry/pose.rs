//! Where a body is and how it is turned, and frames that belong to a normal.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::real::sqrt;
use crate::scalar::{Scalar, all_finite, epsilon, lit};

/// Why a pose is none.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// A quaternion of length 0, which turns nothing.
    #[error("the quaternion has length 0, so that it is no orientation")]
    ZeroQuaternion,
    /// A component that is NaN or infinite.
    #[error("a component of the position or of the quaternion is not finite")]
    NotFinite,
}

/// Position and orientation of a body, or of a part of one.
///
/// The point p of its frame is, from the [position](Self::position) of the body, at [`lever`](Self::lever)(p) = a + R p: the
/// arm a is 0 for the body itself, and leads to the frame of a [part](Self::part). Differences of positions and of levers are
/// taken apart, so that contacts far from the origin keep their digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose<T: Scalar> {
    position: Vector3<T>,
    orientation: UnitQuaternion<T>,
    rotation: Matrix3<T>,
    arm: Vector3<T>,
}

impl<T: Scalar> Pose<T> {
    /// A body at `position` (m), turned by `orientation` from its frame to the fixed one.
    #[inline]
    pub fn new(position: Vector3<T>, orientation: UnitQuaternion<T>) -> Self {
        Self { position, orientation, rotation: rotation(&orientation), arm: Vector3::zeros() }
    }

    /// As [`new`](Self::new), of any quaternion (w, x, y, z) of a length that is not 0.
    ///
    /// # Errors
    ///
    /// [`PoseError`] for a quaternion of length 0, and for what is not finite.
    pub fn from_parts(position: Vector3<T>, [w, x, y, z]: [T; 4]) -> Result<Self, PoseError> {
        if !all_finite(position.iter().chain(&[w, x, y, z])) {
            return Err(PoseError::NotFinite);
        }
        let largest =
            [w, x, y, z].into_iter().fold(T::zero(), |m, c| super::real::max(m, super::real::abs(c)));
        if largest == T::zero() {
            return Err(PoseError::ZeroQuaternion);
        }
        let scaled = Quaternion::new(w / largest, x / largest, y / largest, z / largest);
        Ok(Self::new(position, UnitQuaternion::new_normalize(scaled)))
    }

    /// At the origin, not turned.
    pub fn identity() -> Self {
        Self::new(Vector3::zeros(), UnitQuaternion::identity())
    }

    /// The frame that stands at `local` in the frame of this one: same position, with an arm.
    #[inline]
    pub fn part(&self, local: &Self) -> Self {
        Self {
            position: self.position,
            orientation: self.orientation * local.orientation,
            rotation: self.rotation * local.rotation,
            arm: self.lever(&(local.position + local.arm)),
        }
    }

    /// Position of the body (m).
    #[inline]
    pub fn position(&self) -> &Vector3<T> {
        &self.position
    }

    /// Orientation, from the frame to the fixed axes.
    #[inline]
    pub fn orientation(&self) -> &UnitQuaternion<T> {
        &self.orientation
    }

    /// The same as a matrix R.
    #[inline]
    pub fn rotation(&self) -> &Matrix3<T> {
        &self.rotation
    }

    /// Arm from the position to the origin of the frame, in fixed axes (m).
    #[inline]
    pub fn arm(&self) -> &Vector3<T> {
        &self.arm
    }

    /// A vector of the frame in fixed axes, R v.
    #[inline(always)]
    pub fn turn(&self, v: &Vector3<T>) -> Vector3<T> {
        self.rotation * v
    }

    /// A vector of fixed axes in the frame, Rᵀ v.
    #[inline(always)]
    pub fn turn_back(&self, v: &Vector3<T>) -> Vector3<T> {
        let r = &self.rotation;
        Vector3::new(r.column(0).dot(v), r.column(1).dot(v), r.column(2).dot(v))
    }

    /// From the position of the body to the point `p` of the frame, in fixed axes: a + R p.
    #[inline(always)]
    pub fn lever(&self, p: &Vector3<T>) -> Vector3<T> {
        self.arm + self.turn(p)
    }

    /// The point `p` of the frame in space.
    #[inline]
    pub fn place(&self, p: &Vector3<T>) -> Vector3<T> {
        self.position + self.lever(p)
    }

    /// From the origin of this frame to the origin of `other`, in fixed axes.
    #[inline(always)]
    pub(super) fn to(&self, other: &Self) -> Vector3<T> {
        (other.position - self.position) + (other.arm - self.arm)
    }
}

/// The matrix of q, divided by |q|²: orthogonal to rounding where q is unit only nearly.
#[inline]
fn rotation<T: Scalar>(q: &UnitQuaternion<T>) -> Matrix3<T> {
    let (w, x, y, z) = (q.w, q.i, q.j, q.k);
    let twice = lit::<T>(2.0) / (w * w + x * x + y * y + z * z);
    let one = T::one();
    Matrix3::new(
        one - twice * (y * y + z * z),
        twice * (x * y - w * z),
        twice * (x * z + w * y),
        twice * (x * y + w * z),
        one - twice * (x * x + z * z),
        twice * (y * z - w * x),
        twice * (x * z - w * y),
        twice * (y * z + w * x),
        one - twice * (x * x + y * y),
    )
}

/// The frame (n, t₁, t₂) of a unit normal n, as columns; right-handed, a function of n alone.
///
/// The tangents are those of the fixed vertical turned to e = (2, 3, 6)/7 and from there to n, each time by the smallest
/// turn: smooth in n everywhere but at n = −e (no field of tangents is so everywhere), and (x, y) for n = z.
/// The second turn is written as a reflection at e + n, which keeps its digits near −e.
pub fn frame<T: Scalar>(n: &Vector3<T>) -> Matrix3<T> {
    let e: Vector3<T> = Vector3::new(lit::<T>(2.0), lit(3.0), lit(6.0)) / lit::<T>(7.0);
    let a: Vector3<T> = Vector3::new(lit::<T>(87.0), lit(-6.0), lit(-26.0)) / lit::<T>(91.0);
    let b: Vector3<T> = Vector3::new(lit::<T>(-6.0), lit(82.0), lit(-39.0)) / lit::<T>(91.0);
    let middle: Vector3<T> = e + n;
    let square = middle.dot(&middle);
    if !(sqrt(square) > lit::<T>(4.0) * epsilon::<T>()) {
        return Matrix3::from_columns(&[*n, a, -b]);
    }
    let twice = lit::<T>(2.0) / square;
    let mirrored = |v: Vector3<T>| v - middle * (twice * middle.dot(&v));
    // Near −e the direction of the mirror is lost to rounding, but not that the tangent is normal to n.
    let first = mirrored(a);
    let first: Vector3<T> = first - n * n.dot(&first);
    let first = first / sqrt(first.dot(&first));
    Matrix3::from_columns(&[*n, first, n.cross(&first)])
}
