//! A family of laws without its type: what a registry holds.

use std::any::Any;
use std::sync::Arc;

use super::{ContactLaw, Description, LawError, LawFamily, Scalar};

/// Makes a law from parameter values in the order of its description.
type Maker<T, const D: usize> = fn(&[T]) -> Result<Box<dyn ContactLaw<T, D>>, LawError>;

/// A family of laws as a registry holds it: its description, and how to make its laws in each arithmetic and contact
/// dimension it supports. [`family!`](crate::laws::family) makes one from the type of a law.
#[derive(Debug, Clone)]
pub struct LawEntry {
    description: Description,
    /// A [`Maker`] for each arithmetic and dimension.
    makers: Vec<Arc<dyn Any + Send + Sync>>,
}

impl LawEntry {
    /// A family that supports no arithmetic and no dimension yet, see [`with`](Self::with).
    pub fn new(description: Description) -> Self {
        Self { description, makers: Vec::new() }
    }

    /// Adds the arithmetic T and the contact dimension D, in which `L` is the law.
    #[must_use]
    pub fn with<L, T, const D: usize>(mut self) -> Self
    where
        T: Scalar,
        L: LawFamily<T> + ContactLaw<T, D> + 'static,
    {
        let maker: Maker<T, D> = |values| Ok(Box::new(L::try_new(values)?));
        self.makers.push(Arc::new(maker));
        self
    }

    /// What the family is, with its parameters.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Makes a law from parameter values in the order of the description.
    ///
    /// # Errors
    /// [`LawError::Unsupported`] for an arithmetic or a dimension the family does not have, and those of
    /// [`LawFamily::try_new`].
    pub fn build<T: Scalar, const D: usize>(
        &self,
        values: &[T],
    ) -> Result<Box<dyn ContactLaw<T, D>>, LawError> {
        let maker = self.makers.iter().find_map(|maker| maker.downcast_ref::<Maker<T, D>>());
        let maker = maker.ok_or_else(|| LawError::Unsupported {
            law: self.description.name,
            scalar: std::any::type_name::<T>(),
            dimension: D,
        })?;
        maker(values)
    }
}

/// The [`LawEntry`] of a law in `f64` and `f32`, with contacts of 1, 2 and 3 dimensions: `family!(MyLaw<T>)` of a type that
/// is generic over its scalar, `family!(MyLaw)` of one that is not.
///
/// ```
/// use nonsmooth::laws::{Fremond, family};
///
/// let entry = family!(Fremond<T>);
/// let law = entry.build::<f64, 2>(&[0.5, 0.3]).unwrap();
/// assert_eq!(law.name(), entry.description().name);
/// ```
#[macro_export]
macro_rules! law_family {
    ($($law:ident)::+ <T>) => {
        $crate::law_family!(@ $($law)::+<f64>, $($law)::+<f32>)
    };
    ($law:ty) => {
        $crate::law_family!(@ $law, $law)
    };
    (@ $double:ty, $single:ty) => {
        $crate::laws::LawEntry::new(<$double as $crate::laws::LawFamily<f64>>::DESCRIPTION)
            .with::<$double, f64, 1>()
            .with::<$double, f64, 2>()
            .with::<$double, f64, 3>()
            .with::<$single, f32, 1>()
            .with::<$single, f32, 2>()
            .with::<$single, f32, 3>()
    };
}
#[doc(inline)]
pub use law_family as family;
