//! The steps of a run, of one length or under error control, behind one face.

use std::sync::atomic::AtomicBool;

use super::{Outcome, SimulateError, advance, advance_adaptively};
use crate::adaptive::{Adaptive, AdaptiveError, AdaptiveSettings};
use crate::observe::Observer;
use crate::scalar::Scalar;
use crate::scheme::ThetaScheme;

/// What makes the steps of a run.
#[derive(Debug)]
pub enum Stepper<T: Scalar, const D: usize> {
    /// Steps of one length.
    Fixed(Box<ThetaScheme<T, D>>),
    /// Steps under error control.
    Adaptive(Box<Adaptive<T, D>>),
}

impl<T: Scalar, const D: usize> Stepper<T, D> {
    /// Takes a scheme over, under error control where there are settings for it.
    ///
    /// # Errors
    /// [`AdaptiveError`] of [`Adaptive::new`].
    pub fn new(
        scheme: ThetaScheme<T, D>,
        control: Option<AdaptiveSettings<T>>,
    ) -> Result<Self, AdaptiveError> {
        Ok(match control {
            None => Self::Fixed(Box::new(scheme)),
            Some(settings) => Self::Adaptive(Box::new(Adaptive::new(scheme, settings)?)),
        })
    }

    /// The scheme.
    pub fn scheme(&self) -> &ThetaScheme<T, D> {
        match self {
            Self::Fixed(scheme) => scheme,
            Self::Adaptive(driver) => driver.scheme(),
        }
    }

    /// The scheme, to be restored; `None` under error control, which keeps what it knows of its state.
    pub fn fixed(&mut self) -> Option<&mut ThetaScheme<T, D>> {
        match self {
            Self::Fixed(scheme) => Some(scheme),
            Self::Adaptive(_) => None,
        }
    }

    /// Makes `steps` fixed steps, or under error control all steps to the end, between [`begin`](super::begin) and
    /// [`end`](super::end).
    ///
    /// # Errors
    /// [`SimulateError`].
    pub fn advance(
        &mut self,
        steps: usize,
        observers: &mut [&mut dyn Observer<T, D>],
        interrupt: &AtomicBool,
    ) -> Result<Outcome, SimulateError> {
        match self {
            Self::Fixed(scheme) => advance(scheme, steps, observers, interrupt),
            Self::Adaptive(driver) => {
                let end = driver.settings().end;
                advance_adaptively(driver, end, observers, interrupt)
            }
        }
    }
}
