//! The content of a file.

use super::{FclibError, SparseMatrix};
use crate::cone::{BlockMatrix, Cone as ContactCone, ConeProblem};

/// An FCLIB problem as its file holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Title and description.
    pub info: Info,
    /// Dimension of a contact, 2 (N, T) or 3 (N, T1, T2).
    pub dimension: usize,
    /// μ, one value per contact, finite and ≥ 0.
    pub friction: Vec<f64>,
    /// The matrices and vectors.
    pub data: Data,
    /// Starting points stored with the problem.
    pub guesses: Vec<Solution>,
    /// A solution stored with the problem.
    pub solution: Option<Solution>,
}

/// Title and description of a problem.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Info {
    /// `info/title`.
    pub title: Option<String>,
    /// `info/description`.
    pub description: Option<String>,
    /// `info/math_info`.
    pub math_info: Option<String>,
}

/// The two forms of a problem.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// Condensed to the contacts.
    Local(Local),
    /// With the velocities of the bodies.
    Global(Global),
}

/// u = W r + V λ + q, 0 = Vᵀ r + R λ + s.
#[derive(Debug, Clone, PartialEq)]
pub struct Local {
    /// W, dm × dm for m contacts of dimension d.
    pub delassus: SparseMatrix,
    /// q, the velocity without percussions, dm values.
    pub velocity: Vec<f64>,
    /// V, R and s.
    pub bilateral: Option<LocalBilateral>,
}

/// Bilateral constraints of a local problem.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalBilateral {
    /// V, dm × l.
    pub directions: SparseMatrix,
    /// R, l × l.
    pub compliance: SparseMatrix,
    /// s, l values.
    pub velocity: Vec<f64>,
}

/// M v = H r + G λ + f, u = Hᵀ v + w, 0 = Gᵀ v + b.
#[derive(Debug, Clone, PartialEq)]
pub struct Global {
    /// M, n × n: the mass, or the iteration matrix of the scheme.
    pub mass: SparseMatrix,
    /// H, n × dm: a column is the generalised direction of one local component.
    pub directions: SparseMatrix,
    /// f, n generalised percussions (M times the velocity without contact).
    pub force: Vec<f64>,
    /// w, dm values added to the local velocities.
    pub velocity: Vec<f64>,
    /// G and b.
    pub bilateral: Option<GlobalBilateral>,
}

/// Bilateral constraints of a global problem.
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalBilateral {
    /// G, n × l.
    pub directions: SparseMatrix,
    /// b, l values.
    pub velocity: Vec<f64>,
}

/// A guess or a solution.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Solution {
    /// r, percussions of the contacts, dm values.
    pub percussions: Vec<f64>,
    /// u, local velocities, dm values.
    pub velocities: Vec<f64>,
    /// v, velocities of the bodies, n values in a global problem.
    pub body_velocities: Option<Vec<f64>>,
    /// λ, multipliers of the bilateral constraints, l values.
    pub multipliers: Option<Vec<f64>>,
}

/// The cone problem of a file, in its dimension.
#[derive(Debug, Clone, PartialEq)]
pub enum Cone {
    /// Contacts (N, T).
    Planar(ConeProblem<f64, 2>),
    /// Contacts (N, T1, T2).
    Spatial(ConeProblem<f64, 3>),
}

impl Cone {
    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        match self {
            Self::Planar(problem) => problem.contacts(),
            Self::Spatial(problem) => problem.contacts(),
        }
    }

    /// Dimension of a contact.
    pub fn dimension(&self) -> usize {
        match self {
            Self::Planar(_) => 2,
            Self::Spatial(_) => 3,
        }
    }
}

impl Problem {
    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.friction.len()
    }

    /// Checks that the parts have the sizes they declare to each other, and that friction is a coefficient.
    ///
    /// # Errors
    /// [`FclibError::Dimension`], [`FclibError::Shape`], [`FclibError::Length`], [`FclibError::NotFinite`],
    /// [`FclibError::NegativeFriction`].
    pub fn check(&self) -> Result<(), FclibError> {
        if !(2..=3).contains(&self.dimension) {
            return Err(FclibError::Dimension { dataset: "spacedim".into(), value: self.dimension as i64 });
        }
        let local = self.dimension * self.contacts();
        for (contact, &value) in self.friction.iter().enumerate() {
            if !value.is_finite() {
                return Err(FclibError::NotFinite { dataset: "vectors/mu".into(), position: contact });
            }
            if value < 0.0 {
                return Err(FclibError::NegativeFriction { contact, value });
            }
        }
        let (mut bodies, mut multipliers) = (None, 0);
        match &self.data {
            Data::Local(Local { delassus, velocity, bilateral }) => {
                shape("W", delassus, (local, local))?;
                vector("vectors/q", velocity, local)?;
                if let Some(LocalBilateral { directions, compliance, velocity }) = bilateral {
                    multipliers = velocity.len();
                    shape("V", directions, (local, multipliers))?;
                    shape("R", compliance, (multipliers, multipliers))?;
                    vector("vectors/s", velocity, multipliers)?;
                }
            }
            Data::Global(Global { mass, directions, force, velocity, bilateral }) => {
                let n = force.len();
                bodies = Some(n);
                vector("vectors/f", force, n)?;
                shape("M", mass, (n, n))?;
                shape("H", directions, (n, local))?;
                vector("vectors/w", velocity, local)?;
                if let Some(GlobalBilateral { directions, velocity }) = bilateral {
                    multipliers = velocity.len();
                    shape("G", directions, (n, multipliers))?;
                    vector("vectors/b", velocity, multipliers)?;
                }
            }
        }
        for solution in self.guesses.iter().chain(&self.solution) {
            vector("r", &solution.percussions, local)?;
            vector("u", &solution.velocities, local)?;
            if let Some(v) = &solution.body_velocities {
                vector("v", v, bodies.unwrap_or(0))?;
            }
            if let Some(l) = &solution.multipliers {
                vector("l", l, multipliers)?;
            }
        }
        Ok(())
    }

    /// A local problem from a cone problem.
    ///
    /// # Errors
    /// [`FclibError::Dimension`] for D = 1 and 6, [`FclibError::Rolling`]: the layout knows Coulomb contacts in the plane and
    /// in space only.
    pub fn from_cone<const D: usize>(problem: &ConeProblem<f64, D>, info: Info) -> Result<Self, FclibError> {
        if !(2..=3).contains(&D) {
            return Err(FclibError::Dimension { dataset: "spacedim".into(), value: D as i64 });
        }
        let rows = D * problem.contacts();
        let mut own = BlockMatrix::new();
        let w = problem.delassus().form_in(&mut own);
        let mut entries = Vec::with_capacity(w.stored_blocks() * D * D);
        for row in 0..problem.contacts() {
            for (column, block) in w.row(row) {
                for i in 0..D {
                    entries.extend(
                        (0..D).map(|j| ((row * D + i) as u32, (column * D + j) as u32, block[(i, j)])),
                    );
                }
            }
        }
        let velocity = problem.b().iter().flat_map(|b| b.iter().copied()).collect();
        let delassus = SparseMatrix::from_entries(rows, rows, &entries);
        let data = Data::Local(Local { delassus, velocity, bilateral: None });
        let rolls = |cone: &ContactCone<f64>| !matches!(cone, ContactCone::Coulomb { .. });
        if let Some(contact) = problem.cones().iter().position(rolls) {
            return Err(FclibError::Rolling { contact });
        }
        let friction = problem.cones().iter().map(ContactCone::friction).collect();
        Ok(Self { info, dimension: D, friction, data, guesses: Vec::new(), solution: None })
    }
}

fn shape(name: &str, matrix: &SparseMatrix, expected: (usize, usize)) -> Result<(), FclibError> {
    if (matrix.rows(), matrix.columns()) == expected {
        return Ok(());
    }
    let (rows, columns) = (matrix.rows(), matrix.columns());
    let expected = format!("{} × {}", expected.0, expected.1);
    Err(FclibError::Shape { matrix: name.into(), rows, columns, expected })
}

pub(super) fn vector(name: &str, values: &[f64], expected: usize) -> Result<(), FclibError> {
    if values.len() != expected {
        let (expected, found) = (expected as u64, values.len() as u64);
        return Err(FclibError::Length { dataset: name.into(), expected, found });
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(position) => Err(FclibError::NotFinite { dataset: name.into(), position }),
        None => Ok(()),
    }
}
