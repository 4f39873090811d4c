//! Checks of an inertia, and its principal axes.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::real::{abs, max};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// Why a matrix is the inertia of no body.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InertiaError {
    /// A NaN or an infinity.
    #[error("an entry of the inertia is not finite")]
    NotFinite,
    /// J_ij ≠ J_ji.
    #[error(
        "the inertia is not symmetric: entries ({row}, {column}) and ({column}, {row}) differ by {difference:e}"
    )]
    NotSymmetric {
        /// Row, from 0.
        row: usize,
        /// Column.
        column: usize,
        /// J_ij − J_ji (kg m²).
        difference: f64,
    },
    /// A principal moment that is not positive.
    #[error("a principal moment of inertia is {moment:e}, it must be positive")]
    NotPositive {
        /// The moment (kg m²).
        moment: f64,
    },
    /// One principal moment exceeds the sum of the others: no distribution of mass has it.
    #[error("a principal moment of inertia, {largest:e}, exceeds the sum of the two others, {others:e}")]
    Triangle {
        /// The largest moment (kg m²).
        largest: f64,
        /// Sum of the others (kg m²).
        others: f64,
    },
}

/// Principal moments, and the axes they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Principal<T: Scalar> {
    /// Moments J₁, J₂, J₃ (kg m²).
    pub moments: Vector3<T>,
    /// From the principal axes to the axes the inertia was given in; the identity where these are principal.
    pub axes: UnitQuaternion<T>,
}

impl<T: Scalar> Principal<T> {
    /// Departures of J₁ ≤ J₂ + J₃, of symmetry and of a diagonal that are taken for rounding, in the largest moment: 64 ε.
    fn rounding() -> T {
        lit::<T>(64.0) * epsilon::<T>()
    }

    /// Principal axes of `inertia` (kg m²), in the order and with the signs that turn least from the axes given.
    ///
    /// # Errors
    ///
    /// [`InertiaError`] where no body has that inertia. Moments may reach the triangle inequality, as those of flat bodies do.
    pub fn of(inertia: &Matrix3<T>) -> Result<Self, InertiaError> {
        if !all_finite(inertia.iter()) {
            return Err(InertiaError::NotFinite);
        }
        let largest = inertia.iter().fold(T::zero(), |m, &x| max(m, abs(x)));
        let rounding = Self::rounding() * largest;
        for (row, column) in [(0, 1), (0, 2), (1, 2)] {
            let difference = inertia[(row, column)] - inertia[(column, row)];
            if abs(difference) > rounding {
                return Err(InertiaError::NotSymmetric { row, column, difference: to_f64(difference) });
            }
        }
        let off = [(0, 1), (0, 2), (1, 2)].map(|at| abs(inertia[at]));
        let found = if off.iter().all(|&x| x <= rounding) {
            Self { moments: inertia.diagonal(), axes: UnitQuaternion::identity() }
        } else {
            let eigen = (inertia / largest).symmetric_eigen();
            turned_least(eigen.eigenvalues * largest, &eigen.eigenvectors)
        };
        check(&found.moments)?;
        Ok(found)
    }
}

/// Among the orders and signs of the axes, the rotation of largest trace.
fn turned_least<T: Scalar>(moments: Vector3<T>, axes: &Matrix3<T>) -> Principal<T> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let mut best = (lit::<T>(-4.0), Matrix3::identity(), moments);
    for order in orders {
        let mut columns = order.map(|k| axes.column(k).into_owned());
        for (k, column) in columns.iter_mut().enumerate() {
            if column[k] < T::zero() {
                *column = -*column;
            }
        }
        let mut turn = Matrix3::from_columns(&columns);
        if turn.determinant() < T::zero() {
            // The sign that costs the least trace makes it a rotation.
            let weakest = (0..3).reduce(|a, b| if turn[(b, b)] < turn[(a, a)] { b } else { a }).unwrap_or(0);
            let flipped = -turn.column(weakest);
            turn.set_column(weakest, &flipped);
        }
        if turn.trace() > best.0 {
            best = (turn.trace(), turn, Vector3::from(order.map(|k| moments[k])));
        }
    }
    let axes = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(best.1));
    Principal { moments: best.2, axes }
}

fn check<T: Scalar>(moments: &Vector3<T>) -> Result<(), InertiaError> {
    let (least, largest) = (moments.min(), moments.max());
    if !(least > T::zero()) {
        return Err(InertiaError::NotPositive { moment: to_f64(least) });
    }
    let others = moments.sum() - largest;
    if largest - others > Principal::<T>::rounding() * largest {
        return Err(InertiaError::Triangle { largest: to_f64(largest), others: to_f64(others) });
    }
    Ok(())
}
