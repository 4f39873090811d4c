//! Functions of a scalar by their names: the traits a scalar meets share method names.

use nalgebra::{ComplexField, Vector3};

use crate::scalar::{Scalar, lit};

#[inline(always)]
pub(super) fn abs<T: Scalar>(x: T) -> T {
    ComplexField::abs(x)
}

#[inline(always)]
pub(super) fn sqrt<T: Scalar>(x: T) -> T {
    ComplexField::sqrt(x)
}

/// The larger; `y` where `x` is NaN.
#[inline(always)]
pub(super) fn max<T: Scalar>(x: T, y: T) -> T {
    if x > y { x } else { y }
}

/// The smaller; `y` where `x` is NaN.
#[inline(always)]
pub(super) fn min<T: Scalar>(x: T, y: T) -> T {
    if x < y { x } else { y }
}

/// `x` in [0, 1]; 0 for NaN.
#[inline(always)]
pub(super) fn unit_interval<T: Scalar>(x: T) -> T {
    min(max(x, T::zero()), T::one())
}

#[inline(always)]
pub(super) fn infinity<T: Scalar>() -> T {
    lit(f64::INFINITY)
}

/// The unit vector along `v`; `None` where it has none to rounding.
#[inline]
pub(super) fn direction<T: Scalar>(v: &Vector3<T>) -> Option<Vector3<T>> {
    // Scaled first, so that the squares neither overflow nor vanish.
    let largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    if !(largest > T::zero() && largest < infinity()) {
        return None;
    }
    let scaled = v / largest;
    Some(scaled / sqrt(scaled.dot(&scaled)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_tiny_and_huge_vectors() {
        for scale in [1e-300, 1.0, 1e300] {
            let d = direction(&Vector3::new(3.0 * scale, 0.0, 4.0 * scale)).expect("a direction");
            assert!((d - Vector3::new(0.6, 0.0, 0.8)).norm() <= 2.0 * f64::EPSILON);
        }
        assert!(direction(&Vector3::<f64>::zeros()).is_none());
        assert!(direction(&Vector3::new(f64::NAN, 1.0, 0.0)).is_none_or(|d| d.x.is_nan()));
    }
}
