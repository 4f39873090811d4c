//! Linear isotropic elasticity in the plane and on a line.

use crate::scalar::{Scalar, all_finite, lit, to_f64};
use crate::system::SystemError;

/// What holds across the thickness of a plane body.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Hypothesis {
    /// σ_zz = 0: a thin plate (default).
    #[default]
    PlaneStress,
    /// ε_zz = 0: a slice of a long body.
    PlaneStrain,
}

/// A linear isotropic material with the section of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material<T> {
    /// Young's modulus E > 0 (Pa).
    pub young: T,
    /// Poisson's ratio ν, −1 < ν < ½; without effect on bars.
    pub poisson: T,
    /// Density ρ > 0 (kg/m³).
    pub density: T,
    /// Thickness of a plane body (m), cross-section of a bar (m²), > 0.
    pub section: T,
    /// Plane stress or plane strain; without effect on bars.
    pub hypothesis: Hypothesis,
}

impl<T: Scalar> Material<T> {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn check(&self) -> Result<(), SystemError> {
        let positive = [
            ("Young's modulus", self.young),
            ("the density", self.density),
            ("the thickness or cross-section", self.section),
        ];
        for (what, value) in positive {
            if !(value > T::zero() && all_finite([&value])) {
                let (what, value) = (what.into(), to_f64(value));
                return Err(SystemError::OutOfRange { what, value, range: "finite and > 0" });
            }
        }
        if !(self.poisson > -T::one() && self.poisson < lit(0.5)) {
            let (what, value) = ("Poisson's ratio".into(), to_f64(self.poisson));
            return Err(SystemError::OutOfRange { what, value, range: "in (−1, ½)" });
        }
        Ok(())
    }

    /// (D₁₁, D₁₂, D₃₃) of σ = D ε with σ = (σ_xx, σ_yy, σ_xy), ε = (ε_xx, ε_yy, 2ε_xy).
    pub(super) fn plane_moduli(&self) -> [T; 3] {
        let (e, nu, one) = (self.young, self.poisson, T::one());
        let shear = e / (lit::<T>(2.0) * (one + nu));
        match self.hypothesis {
            Hypothesis::PlaneStress => {
                let factor = e / (one - nu * nu);
                [factor, factor * nu, shear]
            }
            Hypothesis::PlaneStrain => {
                let factor = e / ((one + nu) * (one - lit::<T>(2.0) * nu));
                [factor * (one - nu), factor * nu, shear]
            }
        }
    }

    /// Speed of longitudinal waves in a bar, c = √(E/ρ) (m/s).
    pub fn bar_wave_speed(&self) -> T {
        nalgebra::ComplexField::sqrt(self.young / self.density)
    }
}
