//! The Delassus operator in the form that pays: block by block, or as the factors it is made of.

use nalgebra::{SMatrix, SVector};

use super::{BlockMatrix, FactoredDelassus, Workspace};
use crate::scalar::Scalar;

/// W, symmetric positive semidefinite, from percussions (N s) to local velocities (m/s).
///
/// A solver matches on the form, or takes [`form_in`](Self::form_in), which gives it W block by block in a workspace of
/// its own.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Delassus<T: Scalar, const D: usize> {
    /// W block by block.
    Formed(BlockMatrix<T, D>),
    /// W = H M̂⁻¹ Hᵀ as H and M̂.
    Factored(Box<FactoredDelassus<T, D>>),
}

/// The form in which a problem given by H and M̂ holds W.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Form {
    /// Whichever [pays](factored_pays) (default).
    #[default]
    Auto,
    /// W block by block.
    Formed,
    /// H and M̂.
    Factored,
}

/// Whether W is better kept as H and M̂, of so many velocities, than formed over so many scalar percussions.
///
/// A Newton step factors one matrix or the other, over the velocities or over the percussions. Cold solves of walls with
/// ever fewer contacts, the forming of W counted (`cargo bench --bench cone`), took with W formed so many times what they
/// took with H and M̂:
///
/// | n/(D m) | 0.26 | 0.42 | 0.62 | 0.81 | 1.0 | 1.3 | 1.7 |
/// |---|---|---|---|---|---|---|---|
/// | `proximal-newton` | 11 | 3.1 | 1.15 | 0.91 | 0.63 | 0.65 | 0.57 |
/// | `hybrid` | 12 | 3.5 | 1.19 | 0.90 | 0.78 | 0.82 | 0.73 |
///
/// so that it pays below n = 0.7 D m. Sweeps alone (`nsgs`) run over rows of a formed W a quarter faster where they end:
/// the step of a scheme, whose warm solves mostly end in sweeps, and which splits W into islands, always forms it.
pub fn factored_pays(velocities: usize, percussions: usize) -> bool {
    10 * velocities < 7 * percussions
}

impl<T: Scalar, const D: usize> Default for Delassus<T, D> {
    fn default() -> Self {
        Self::Formed(BlockMatrix::new())
    }
}

impl<T: Scalar, const D: usize> Delassus<T, D> {
    /// The operator of H and M̂ in the form that [`factored_pays`] chooses.
    pub fn where_it_pays(factors: FactoredDelassus<T, D>) -> Self {
        if factored_pays(factors.nodes() * factors.dofs(), factors.contacts() * D) {
            Self::Factored(Box::new(factors))
        } else {
            Self::Formed(factors.form())
        }
    }

    /// Number of contacts m.
    pub fn contacts(&self) -> usize {
        match self {
            Self::Formed(w) => w.rows(),
            Self::Factored(factors) => factors.contacts(),
        }
    }

    /// W where it is formed.
    #[inline]
    pub fn formed(&self) -> Option<&BlockMatrix<T, D>> {
        match self {
            Self::Formed(w) => Some(w),
            Self::Factored(_) => None,
        }
    }

    /// H and M̂ where W is not formed.
    #[inline]
    pub fn factors(&self) -> Option<&FactoredDelassus<T, D>> {
        match self {
            Self::Formed(_) => None,
            Self::Factored(factors) => Some(factors),
        }
    }

    /// W block by block: as it stands where it is formed, else formed in `own`, which the caller keeps.
    pub fn form_in<'a>(&'a self, own: &'a mut BlockMatrix<T, D>) -> &'a BlockMatrix<T, D> {
        match self {
            Self::Formed(w) => w,
            Self::Factored(factors) => {
                *own = factors.form();
                own
            }
        }
    }

    /// W block by block, to refill it; what stands in factored form is formed first.
    pub(super) fn formed_mut(&mut self) -> &mut BlockMatrix<T, D> {
        if let Self::Factored(factors) = self {
            *self = Self::Formed(factors.form());
        }
        match self {
            Self::Formed(w) => w,
            Self::Factored(_) => unreachable!("formed by the lines above"),
        }
    }

    /// W_αα, `None` where it is absent.
    #[inline]
    pub fn diagonal(&self, contact: usize) -> Option<&SMatrix<T, D, D>> {
        match self {
            Self::Formed(w) => w.diagonal(contact),
            Self::Factored(factors) => Some(factors.diagonal(contact)),
        }
    }

    /// Blocks that W has or would have when it is formed.
    pub fn blocks(&self) -> usize {
        match self {
            Self::Formed(w) => w.stored_blocks(),
            Self::Factored(factors) => factors.formed_blocks(),
        }
    }

    /// (W r)_α. In factored form it is a product with all of W, and allocates.
    #[inline]
    pub fn row_product(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        match self {
            Self::Formed(w) => w.row_product(contact, r),
            Self::Factored(factors) => {
                let mut workspace = Workspace::default();
                let velocities = factors.velocities(r, &mut workspace);
                factors.jacobian.velocity(contact, factors.dofs(), velocities)
            }
        }
    }
}

impl<T: Scalar, const D: usize> From<BlockMatrix<T, D>> for Delassus<T, D> {
    fn from(w: BlockMatrix<T, D>) -> Self {
        Self::Formed(w)
    }
}
