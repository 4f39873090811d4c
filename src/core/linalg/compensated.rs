//! Sums of products in twice the working precision.

use nalgebra::ComplexField;

use crate::scalar::Scalar;

/// Σ aᵢ bᵢ with the rounding of every product and sum carried along: as accurate as if computed in twice the
/// precision and rounded once, by Ogita, Rump and Oishi (2005), doi:10.1137/030601818.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Compensated<T> {
    sum: T,
    error: T,
}

impl<T: Scalar> Compensated<T> {
    /// A sum of no terms yet but `first`.
    #[inline]
    pub(crate) fn new(first: T) -> Self {
        Self { sum: first, error: T::zero() }
    }

    /// Adds a b.
    #[inline]
    pub(crate) fn add_product(&mut self, a: T, b: T) {
        let product = a * b;
        let lost = ComplexField::mul_add(a, b, -product);
        let sum = self.sum + product;
        let part = sum - self.sum;
        // What the sum lost, exactly (Knuth).
        self.error += (self.sum - (sum - part)) + (product - part) + lost;
        self.sum = sum;
    }

    /// The sum, rounded once.
    #[inline]
    pub(crate) fn value(&self) -> T {
        self.sum + self.error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_is_not_lost() {
        // 3·(1/3) − 1 is the rounding of 1/3 times −3, exactly; and 10¹⁶ + 1 − 10¹⁶ = 1.
        let third = 1.0_f64 / 3.0;
        let mut sum = Compensated::new(-1.0);
        sum.add_product(3.0, third);
        assert_eq!(sum.value(), -f64::EPSILON / 4.0);
        let mut sum = Compensated::new(1e16_f64);
        sum.add_product(1.0, 1.0);
        sum.add_product(-1e8, 1e8);
        assert_eq!(sum.value(), 1.0);
        let mut sum = Compensated::new(1e8_f32);
        sum.add_product(1.0, 1.0);
        sum.add_product(-1e4, 1e4);
        assert_eq!(sum.value(), 1.0);
    }
}
