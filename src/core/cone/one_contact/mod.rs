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

mod planar;
mod rolling;
mod spatial;

use nalgebra::{SMatrix, SVector};

use crate::cone::cones::Shape;
use crate::laws::Cone;
use crate::scalar::{Scalar, epsilon, lit};
use planar::Planar;
use rolling::Rolling;
use spatial::Spatial;

/// The percussion of one contact with Delassus block `w` (W_NN > 0), velocity `b` without it, and a cone: a number is
/// Coulomb's of that friction.
///
/// It satisfies the inclusion to a few tens of ε against (1 + μ)(‖b‖ + ‖W‖‖r‖), the block being singular or not, and
/// slightly asymmetric or not. Where several solutions exist (Painlevé: b_N ≥ 0 and W_NN ≤ μ|W_NT|) the contact
/// takes off; where none exists (never for W ≻ 0) the result is the candidate of the smallest slip, and the
/// caller's residual shows it. With rolling resistance in space it is the result of an iteration, which the residual shows
/// as well.
#[inline]
pub fn solve_one_contact<T: Scalar, const D: usize>(
    w: &SMatrix<T, D, D>,
    b: &SVector<T, D>,
    cone: impl Into<Cone<T>>,
) -> SVector<T, D> {
    solve_one_contact_from(w, b, cone, &mut T::zero())
}

/// [`solve_one_contact`] with a first guess of the slip's α = −w_T/r_T in `alpha` (0 is no guess), which is
/// replaced by the one found: the last sweep's value makes the root-finder end at its first evaluation.
#[inline(always)]
pub fn solve_one_contact_from<T: Scalar, const D: usize>(
    w: &SMatrix<T, D, D>,
    b: &SVector<T, D>,
    cone: impl Into<Cone<T>>,
    alpha: &mut T,
) -> SVector<T, D> {
    let cone = cone.into();
    match (D, Shape::of::<D>(cone)) {
        (_, Shape::Blocks(_)) => Rolling::new(w, cone).solve(b),
        (1, _) => half_line(b, T::one() / w[(0, 0)]),
        (2, Shape::Disc(friction)) => Planar::new(w, friction).solve(b),
        (_, Shape::Disc(friction)) => Spatial::new(w, friction).solve(b, alpha),
    }
}

/// D = 1: r = max(0, −b/W).
#[inline(always)]
fn half_line<T: Scalar, const D: usize>(b: &SVector<T, D>, inverse: T) -> SVector<T, D> {
    let normal = -b[0] * inverse;
    vector(if normal > T::zero() { normal } else { T::zero() }, [T::zero(); 2])
}

/// The contacts of a problem, each with what of its block the solution needs: no sweep computes it again.
#[derive(Debug, Clone)]
pub(crate) struct OneContactSolvers<T: Scalar, const D: usize> {
    /// 1/W where D = 1; else empty, as are the others where D differs.
    half_lines: Vec<T>,
    planar: Vec<Planar<T>>,
    spatial: Vec<Spatial<T>>,
    /// α of the last solution, one per contact.
    slips: Vec<T>,
    /// Empty where no contact rolls; else one per contact, `None` for one that does not.
    rolling: Vec<Option<Rolling<T, D>>>,
}

impl<T: Scalar, const D: usize> OneContactSolvers<T, D> {
    pub(crate) fn new() -> Self {
        Self {
            half_lines: Vec::new(),
            planar: Vec::new(),
            spatial: Vec::new(),
            slips: Vec::new(),
            rolling: Vec::new(),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.half_lines.clear();
        self.planar.clear();
        self.spatial.clear();
        self.slips.clear();
        self.rolling.clear();
    }

    /// Takes the next contact.
    pub(crate) fn push(&mut self, w: &SMatrix<T, D, D>, cone: Cone<T>) {
        match D {
            1 => self.half_lines.push(T::one() / w[(0, 0)]),
            2 => self.planar.push(Planar::new(w, cone.friction())),
            _ => {
                if let Shape::Blocks(_) = Shape::of::<D>(cone) {
                    self.rolling.resize_with(self.slips.len(), || None);
                    self.rolling.push(Some(Rolling::new(w, cone)));
                } else if !self.rolling.is_empty() {
                    self.rolling.push(None);
                }
                if D == 3 {
                    self.spatial.push(Spatial::new(w, cone.friction()));
                }
                self.slips.push(T::zero());
            }
        }
    }

    /// The percussion of a contact with velocity `b` without it.
    #[inline(always)]
    pub(crate) fn solve(&mut self, contact: usize, b: &SVector<T, D>) -> SVector<T, D> {
        match D {
            1 => half_line(b, self.half_lines[contact]),
            2 => self.planar[contact].solve(b),
            _ => match self.rolling.get_mut(contact) {
                Some(Some(rolling)) => rolling.solve(b),
                _ => self.spatial[contact].solve(b, &mut self.slips[contact]),
            },
        }
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
