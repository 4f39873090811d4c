//! The cone a contact's percussion must stay in, as a law says it.

use super::Scalar;

/// The cone K of admissible percussions: for every block B of components beside the normal one, ‖p_B‖ ≤ c_B p_N.
///
/// A number is Coulomb's cone with that coefficient of friction: `Cone::from(0.3)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Cone<T> {
    /// Coulomb's: ‖p_T‖ ≤ μ p_N, one block for all tangential components. Without tangent it is the half-line p_N ≥ 0.
    Coulomb {
        /// Coefficient of friction μ ≥ 0 (dimensionless).
        friction: T,
    },
    /// Coulomb's, with moments that resist rolling and spinning: ‖p_T‖ ≤ μ p_N, ‖m_R‖ ≤ μ_R p_N, |m_S| ≤ μ_S p_N.
    ///
    /// The percussion is (p_N, p_T, m_R) in the plane (D = 3), (p_N, p_T1, p_T2, m_R1, m_R2, m_S) in space (D = 6), and the
    /// local velocity (u_N, u_T, ω) to it, ω the relative angular velocity. A contact without such rows has Coulomb's cone.
    Rolling {
        /// Coefficient of friction μ ≥ 0 (dimensionless).
        friction: T,
        /// Coefficient of rolling resistance μ_R ≥ 0 (m).
        rolling: T,
        /// Coefficient of spinning resistance μ_S ≥ 0 (m), in space.
        spinning: T,
    },
}

/// The components of a contact: what its velocities and percussions consist of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Rows {
    /// The normal: D = 1.
    Normal,
    /// The normal and the tangents: D = 2 in the plane, 3 in space.
    #[default]
    Tangent,
    /// The normal, the tangents and the relative rotation: D = 3 in the plane, 6 in space.
    Rolling,
}

impl Rows {
    /// Names of the components of a contact of dimension `dimension`, in their order.
    pub fn components(self, dimension: usize) -> &'static [&'static str] {
        match (self, dimension) {
            (Self::Rolling, 0..=3) => &["N", "T1", "R"][..dimension],
            (_, 0..=3) => &["N", "T1", "T2"][..dimension],
            _ => &["N", "T1", "T2", "R1", "R2", "S"],
        }
    }

    /// Those of a law with this coefficient of friction and no rolling resistance: without friction no tangents.
    pub fn rubbing<T: Scalar>(friction: T) -> Self {
        if friction > T::zero() { Self::Tangent } else { Self::Normal }
    }
}

impl<T> From<T> for Cone<T> {
    fn from(friction: T) -> Self {
        Self::Coulomb { friction }
    }
}

impl<T: Scalar> Cone<T> {
    /// Rolling resistance, and none against spinning.
    pub fn rolling(friction: T, rolling: T) -> Self {
        Self::Rolling { friction, rolling, spinning: T::zero() }
    }

    /// Coefficient of friction μ.
    #[inline]
    pub fn friction(&self) -> T {
        match *self {
            Self::Coulomb { friction } | Self::Rolling { friction, .. } => friction,
        }
    }

    /// μ, μ_R and μ_S, 0 where there is none.
    #[inline]
    pub fn coefficients(&self) -> [T; 3] {
        match *self {
            Self::Coulomb { friction } => [friction, T::zero(), T::zero()],
            Self::Rolling { friction, rolling, spinning } => [friction, rolling, spinning],
        }
    }

    /// The cone in another arithmetic.
    pub fn cast<U: Scalar>(&self) -> Cone<U> {
        let cast = |x: T| nalgebra::convert::<f64, U>(x.to_f64().unwrap_or(f64::NAN));
        match *self {
            Self::Coulomb { friction } => Cone::Coulomb { friction: cast(friction) },
            Self::Rolling { friction, rolling, spinning } => {
                Cone::Rolling { friction: cast(friction), rolling: cast(rolling), spinning: cast(spinning) }
            }
        }
    }

    /// The cone with all coefficients times `factor`.
    #[inline]
    pub fn scaled(self, factor: T) -> Self {
        match self {
            Self::Coulomb { friction } => Self::Coulomb { friction: friction * factor },
            Self::Rolling { friction, rolling, spinning } => Self::Rolling {
                friction: friction * factor,
                rolling: rolling * factor,
                spinning: spinning * factor,
            },
        }
    }

    /// The cone of a contact that has these rows: moments are free of resistance where the law names none, and left out
    /// where there are no rows for them.
    #[inline]
    pub fn on(self, rows: Rows) -> Self {
        match (self, rows) {
            (Self::Coulomb { friction }, Rows::Rolling) => Self::rolling(friction, T::zero()),
            (Self::Rolling { friction, .. }, Rows::Normal | Rows::Tangent) => Self::Coulomb { friction },
            (cone, _) => cone,
        }
    }

    /// The cone of the same contact with its moments measured as impulses at the lever arm `length` (m): m/`length` against
    /// p_N, and `length` ω against u_N.
    #[inline]
    pub fn at_arm(self, length: T) -> Self {
        match self {
            Self::Rolling { friction, rolling, spinning } => {
                Self::Rolling { friction, rolling: rolling / length, spinning: spinning / length }
            }
            cone => cone,
        }
    }
}
