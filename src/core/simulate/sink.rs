//! Observers of runs whatever their arithmetic and contact dimension.

use crate::observe::Observer;
use crate::scalar::Scalar;

/// An observer of runs in every arithmetic and contact dimension that runs are compiled for. What implements [`Observer`]
/// for all `T` and `D` is one.
pub trait Sink:
    Observer<f64, 1>
    + Observer<f64, 2>
    + Observer<f64, 3>
    + Observer<f32, 1>
    + Observer<f32, 2>
    + Observer<f32, 3>
{
}

impl<S> Sink for S where
    S: Observer<f64, 1>
        + Observer<f64, 2>
        + Observer<f64, 3>
        + Observer<f32, 1>
        + Observer<f32, 2>
        + Observer<f32, 3>
{
}

/// An arithmetic that runs with contacts of dimension `D` are compiled for.
pub trait Compiled<const D: usize>: Scalar {
    /// The sink as an observer of such a run.
    fn observer(sink: &mut dyn Sink) -> &mut dyn Observer<Self, D>;
}

macro_rules! compiled {
    ($($scalar:ty, $dimension:literal);+) => {
        $(impl Compiled<$dimension> for $scalar {
            fn observer(sink: &mut dyn Sink) -> &mut dyn Observer<Self, $dimension> {
                sink
            }
        })+
    };
}

compiled!(f64, 1; f64, 2; f64, 3; f32, 1; f32, 2; f32, 3);
