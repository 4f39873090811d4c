//! Linear Lagrangian systems as scene files write them: M, C, K, F and linear gaps.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, SVector};
use serde::Deserialize;

use super::build::Parts;
use super::format::InterfaceSpec;
use super::{PlannedRun, Scene, SceneError};
use crate::linalg::Symmetric;
use crate::registry::Registry;
use crate::scalar::{Scalar, lit};
use crate::system::{Forces, Lagrangian, Signal, SmoothGap, SystemError};

/// A small system M q̈ + C q̇ + K q = F(t) with gaps linear in q, in place of bodies: models of the literature, word by word.
/// Every coordinate has its own unit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LagrangianSpec {
    /// Names of the coordinates; as many as there are degrees of freedom.
    pub coordinates: Vec<String>,
    /// Mass matrix M, row by row, symmetric and positive definite (of each coordinate its own).
    pub mass: Vec<Vec<f64>>,
    /// Damping matrix C, row by row, symmetric; none where absent (of each coordinate its own).
    #[serde(default)]
    pub damping: Vec<Vec<f64>>,
    /// Stiffness matrix K, row by row, symmetric; none where absent (of each coordinate its own).
    #[serde(default)]
    pub stiffness: Vec<Vec<f64>>,
    /// Constant force; none where absent (of each coordinate its own).
    #[serde(default)]
    pub force: Vec<f64>,
    /// Forces that vary in time, added to the constant one.
    #[serde(default)]
    pub loads: Vec<GeneralLoadSpec>,
    /// Initial coordinates; 0 where absent (of each coordinate its own).
    #[serde(default)]
    pub position: Vec<f64>,
    /// Initial velocities; 0 where absent (of each coordinate its own).
    #[serde(default)]
    pub velocity: Vec<f64>,
    /// Unilateral contacts.
    #[serde(default)]
    pub gaps: Vec<GapSpec>,
}

/// A force times a signal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeneralLoadSpec {
    /// Force (of each coordinate its own).
    pub force: Vec<f64>,
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: Signal<f64>,
}

/// A contact with the gap g = normal · q + offset ≥ 0 and the sliding velocity tangent · q̇.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GapSpec {
    /// Name.
    pub name: String,
    /// Derivative of the gap by each coordinate (m per unit of each).
    pub normal: Vec<f64>,
    /// Gap where all coordinates are 0 (m).
    #[serde(default)]
    pub offset: f64,
    /// Sliding velocity by each velocity (m per unit of each); without it the contact has no friction.
    #[serde(default)]
    pub tangent: Vec<f64>,
    /// A law this contact keeps in every run, in place of the law of the run.
    pub law: Option<String>,
    /// Parameters of the law by name (of each parameter its own); a law takes those it has.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
}

impl GapSpec {
    /// The contact as an interface, for its law and parameters.
    pub(super) fn interface(&self) -> InterfaceSpec {
        let between = [self.name.clone(), "its gap".into()];
        InterfaceSpec { between, law: self.law.clone(), parameters: self.parameters.clone() }
    }
}

impl LagrangianSpec {
    fn size(&self, what: &'static str, given: usize) -> Result<(), SceneError> {
        let expected = self.coordinates.len();
        let differs = SystemError::Size { what, expected, given };
        if given == expected { Ok(()) } else { Err(differs.into()) }
    }

    /// `values` in the arithmetic of the run, zeros where they are absent.
    fn vector<T: Scalar>(&self, what: &'static str, values: &[f64]) -> Result<Vec<T>, SceneError> {
        if values.is_empty() {
            return Ok(vec![T::zero(); self.coordinates.len()]);
        }
        self.size(what, values.len())?;
        match values.iter().find(|x| !x.is_finite()) {
            Some(&value) => Err(SceneError::OutOfRange { what: what.into(), value, range: "finite" }),
            None => Ok(values.iter().map(|&x| lit(x)).collect()),
        }
    }

    fn matrix<T: Scalar>(&self, what: &'static str, rows: &[Vec<f64>]) -> Result<Symmetric<T>, SceneError> {
        let n = self.coordinates.len();
        self.size(what, rows.len())?;
        rows.iter().try_for_each(|row| self.size(what, row.len()))?;
        let diagonal = (0..n).all(|i| (0..n).all(|j| i == j || rows[i][j] == 0.0));
        let operator = if diagonal {
            Symmetric::diagonal((0..n).map(|i| lit(rows[i][i])).collect())
        } else {
            Symmetric::dense(DMatrix::from_fn(n, n, |i, j| lit(rows[i][j])))
        };
        operator.map_err(|source| SystemError::Operator { what, source }.into())
    }

    /// Nothing else stands in the scene.
    fn stands_alone(scene: &Scene) -> Result<(), SceneError> {
        let others = [
            ("bodies", scene.bodies.is_empty()),
            ("a solid", scene.solid.is_none()),
            ("obstacles", scene.obstacles.is_empty()),
            ("half-planes", scene.half_planes.is_empty()),
            ("joints", scene.joints.is_empty()),
            ("springs", scene.springs.is_empty()),
            ("interfaces", scene.interfaces.is_empty()),
            ("gravity", scene.gravity == [0.0, 0.0]),
        ];
        match others.iter().find(|(_, absent)| !absent) {
            Some(&(what, _)) => Err(SceneError::BesideLagrangian { what }),
            None => Ok(()),
        }
    }

    /// The system, its laws and its initial state.
    pub(super) fn parts<T: Scalar, const D: usize>(
        &self,
        scene: &Scene,
        (run, registry): (&PlannedRun, &Registry),
    ) -> Result<Parts<T, D>, SceneError> {
        Self::stands_alone(scene)?;
        if self.coordinates.is_empty() {
            return Err(SceneError::Empty { what: "coordinate of the Lagrangian system" });
        }
        let mut forces = Forces::constant(self.vector("the force", &self.force)?);
        for GeneralLoadSpec { force, signal } in &self.loads {
            signal.check()?;
            let load: Vec<T> = self.vector("the force of a load", force)?;
            forces = forces.with_load(signal.cast(), load.into_iter().enumerate().collect());
        }
        let mut system = Lagrangian::<T, D>::new(self.matrix("mass", &self.mass)?).with_forces(forces)?;
        if !self.damping.is_empty() {
            system = system.with_damping(self.matrix("damping", &self.damping)?)?;
        }
        if !self.stiffness.is_empty() {
            system = system.with_stiffness(self.matrix("stiffness", &self.stiffness)?)?;
        }
        let mut laws = Vec::new();
        for (interface, gap) in self.gaps.iter().enumerate() {
            let normal: Vec<T> = self.vector("the normal of a gap", &gap.normal)?;
            if normal.iter().all(|&x| x == T::zero()) {
                let (what, value) = (format!("the normal of gap `{}`", gap.name), 0.0);
                return Err(SceneError::OutOfRange { what, value, range: "a row that is not all zero" });
            }
            let tangent: Vec<T> = self.vector("the tangent of a gap", &gap.tangent)?;
            if !gap.offset.is_finite() {
                let what = format!("the offset of gap `{}`", gap.name);
                return Err(SceneError::OutOfRange { what, value: gap.offset, range: "finite" });
            }
            let (row, offset) = (normal.clone(), lit::<T>(gap.offset));
            let distance = move |q: &[T]| crate::linalg::dot(&row, q) + offset;
            let columns = move |_: &[T], push: &mut dyn FnMut(usize, SVector<T, D>)| {
                for (dof, (&n, &t)) in normal.iter().zip(&tangent).enumerate() {
                    if n != T::zero() || t != T::zero() {
                        let entries = [n, t];
                        let entry = |row: usize| entries.get(row).copied().unwrap_or_else(T::zero);
                        push(dof, SVector::from_fn(|row, _| entry(row)));
                    }
                }
            };
            system = system.with_contact(interface, SmoothGap::new(distance, columns));
            laws.push(gap.interface().law(run, registry)?);
        }
        let names = |gap: &GapSpec| gap.name.clone();
        system = system.with_labels(self.coordinates.clone(), self.gaps.iter().map(names).collect());
        let q = self.vector("the position", &self.position)?;
        let v = self.vector("the velocity", &self.velocity)?;
        Ok((Box::new(system), laws, q, v))
    }
}
