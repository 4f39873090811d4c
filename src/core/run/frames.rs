//! The VTK series of a run, where this build can write one.

use std::path::Path;

use crate::observe::{Frame, ObserveError, Observer, RunInfo};
use crate::scalar::Scalar;
use crate::scene::Scene;

/// The name of the series of the contacts beside that of the bodies.
pub(super) fn of_contacts(name: String) -> String {
    #[cfg(feature = "vtk")]
    return name + crate::observe::VtkSeries::CONTACTS;
    #[cfg(not(feature = "vtk"))]
    name
}

/// The VTK series of a run, if the scene asks for one and this build can write it.
pub(super) struct Frames {
    #[cfg(feature = "vtk")]
    series: Option<crate::observe::VtkSeries>,
}

impl Frames {
    #[cfg(feature = "vtk")]
    pub(super) fn new(scene: &Scene, folder: &Path, name: &str) -> Self {
        let series = |every| crate::observe::VtkSeries::new(folder, name, every);
        Self { series: scene.output.vtk_every.map(series) }
    }

    #[cfg(not(feature = "vtk"))]
    pub(super) fn new(_scene: &Scene, _folder: &Path, _name: &str) -> Self {
        Self {}
    }

    #[cfg(feature = "vtk")]
    pub(super) fn resume(self, times: Vec<f64>) -> Self {
        Self { series: self.series.map(|series| series.resume(times)) }
    }

    #[cfg(not(feature = "vtk"))]
    pub(super) fn resume(self, _times: Vec<f64>) -> Self {
        self
    }

    #[cfg(feature = "vtk")]
    pub(super) fn times(&self) -> Vec<f64> {
        self.series.as_ref().map(|series| series.times().to_vec()).unwrap_or_default()
    }

    #[cfg(not(feature = "vtk"))]
    pub(super) fn times(&self) -> Vec<f64> {
        Vec::new()
    }

    fn series<T: Scalar, const D: usize>(&mut self) -> Option<&mut dyn Observer<T, D>> {
        #[cfg(feature = "vtk")]
        return self.series.as_mut().map(|series| series as &mut dyn Observer<T, D>);
        #[cfg(not(feature = "vtk"))]
        None
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for Frames {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.series().map_or(Ok(()), |series| series.begin(run, frame))
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.series().map_or(Ok(()), |series| series.step(frame))
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.series().map_or(Ok(()), |series| series.end(frame))
    }
}
