//! The one scalar bound of the crate, and the conversions written with it.

/// A real number the whole crate computes with: met by `f32` and `f64`.
///
/// nalgebra computes the small blocks with it and faer the sparse factorisations. A double-double type meets the
/// bound by implementing the two `RealField` traits; `clarabel` asks for more, see `solver::ConicScalar`.
pub trait Scalar: crate::laws::Scalar + faer::traits::RealField + num_traits::FromPrimitive {
    /// Name of the type in outputs.
    const NAME: &'static str;
}

impl Scalar for f32 {
    const NAME: &'static str = "f32";
}

impl Scalar for f64 {
    const NAME: &'static str = "f64";
}

/// The literal `x` as a scalar.
#[inline(always)]
pub fn lit<T: Scalar>(x: f64) -> T {
    nalgebra::convert(x)
}

/// The value of `x` as `f64`, for errors and outputs; NaN where the type cannot say.
pub fn to_f64<T: Scalar>(x: T) -> f64 {
    num_traits::ToPrimitive::to_f64(&x).unwrap_or(f64::NAN)
}

/// Distance from 1 to the next number of the type.
#[inline(always)]
pub fn epsilon<T: Scalar>() -> T {
    T::epsilon_impl()
}

/// Whether every component is finite.
pub fn all_finite<'a, T: Scalar>(values: impl IntoIterator<Item = &'a T>) -> bool {
    // x·0 is 0 exactly when x is neither NaN nor infinite; no test waits for another, as the terms of a sum would.
    values.into_iter().all(|&x| x * T::zero() == T::zero())
}

/// A count as a scalar.
#[inline(always)]
pub fn from_usize<T: Scalar>(n: usize) -> T {
    lit(n as f64)
}
