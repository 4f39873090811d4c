//! The arithmetic a law needs.

use nalgebra::RealField;

/// The arithmetic a law needs: a real number that nalgebra computes with and that an error can print.
pub trait Scalar: RealField + Copy + num_traits::ToPrimitive {}
impl<T: RealField + Copy + num_traits::ToPrimitive> Scalar for T {}
