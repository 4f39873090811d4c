//! External forces: a constant part, which has a potential, and a part that varies in time.

use std::fmt;

use crate::scalar::Scalar;

type Varying<T> = Box<dyn Fn(T, &mut [T]) + Send + Sync>;

/// F(t) = F₀ + F₁(t), generalised forces (N, N m).
pub struct Forces<T: Scalar> {
    constant: Vec<T>,
    varying: Option<Varying<T>>,
}

impl<T: Scalar> Forces<T> {
    /// A constant force; its potential is −F₀·q.
    pub fn constant(force: Vec<T>) -> Self {
        Self { constant: force, varying: None }
    }

    /// Adds a part that varies in time: `add(t, f)` adds F₁(t) to `f`.
    #[must_use]
    pub fn with_varying(mut self, add: impl Fn(T, &mut [T]) + Send + Sync + 'static) -> Self {
        self.varying = Some(Box::new(add));
        self
    }

    /// F₀.
    pub fn constant_part(&self) -> &[T] {
        &self.constant
    }

    /// Whether a part varies in time.
    pub fn varies(&self) -> bool {
        self.varying.is_some()
    }

    /// force ← F(t).
    pub fn at(&self, time: T, force: &mut [T]) {
        force.copy_from_slice(&self.constant);
        if let Some(add) = &self.varying {
            add(time, force);
        }
    }

    /// force ← F_{k+θ} = (1−θ) F(t) + θ F(t + h); `scratch` has the same size.
    pub fn averaged(&self, time: T, step: T, theta: T, force: &mut [T], scratch: &mut [T]) {
        self.at(time, force);
        if self.varies() {
            self.at(time + step, scratch);
            let other = T::one() - theta;
            force.iter_mut().zip(&*scratch).for_each(|(f, &g)| *f = other * *f + theta * g);
        }
    }

    /// −F₀·q, the potential of the constant part.
    pub fn potential(&self, q: &[T]) -> T {
        -crate::linalg::dot(&self.constant, q)
    }
}

impl<T: Scalar> fmt::Debug for Forces<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Forces").field("constant", &self.constant).field("varies", &self.varies()).finish()
    }
}
