//! The cone problem a file poses, and the solution that goes with its percussions.

use nalgebra::{SMatrix, SVector};

use super::bodies::factored;
use super::condense::{bodies, condense_global, condense_local, multipliers};
use super::problem::vector;
use super::{Cone, Data, FclibError, Local, Problem, Solution, SparseMatrix};
use crate::cone::{BlockMatrix, Cone as ContactCone, ConeProblem, Form};

impl Problem {
    /// The cone problem w = W r + b with W formed: the local data as they are, or condensed from the bodies.
    ///
    /// Blocks of W that are zero throughout are left out. W is taken as given: measured operators are often slightly
    /// asymmetric or indefinite, and [`ConeProblem::check_symmetric_semidefinite`] tells.
    ///
    /// # Errors
    /// [`FclibError::Problem`] where W, b, μ are not a cone problem, [`FclibError::Singular`] and
    /// [`FclibError::Dense`] where the condensation fails, [`FclibError::Shape`] and [`FclibError::Length`] where
    /// parts put together by hand do not fit.
    pub fn cone(&self) -> Result<Cone, FclibError> {
        self.cone_in(Form::Formed)
    }

    /// [`cone`](Self::cone) with W in the form asked for: a global problem without bilateral constraints keeps its H and M
    /// where that [pays](crate::cone::factored_pays) (`Form::Auto`), or in any case (`Form::Factored`). W is formed where it
    /// cannot be kept so: of local problems, with bilateral constraints, and where M is not symmetric.
    ///
    /// # Errors
    /// As [`cone`](Self::cone).
    pub fn cone_in(&self, form: Form) -> Result<Cone, FclibError> {
        match self.dimension {
            2 => self.cone_of(form).map(Cone::Planar),
            3 => self.cone_of(form).map(Cone::Spatial),
            d => Err(FclibError::Dimension { dataset: "spacedim".into(), value: d as i64 }),
        }
    }

    /// [`cone_in`](Self::cone_in) in a dimension known beforehand.
    fn cone_of<const D: usize>(&self, form: Form) -> Result<ConeProblem<f64, D>, FclibError> {
        self.check()?;
        if let Data::Global(global) = &self.data
            && form != Form::Formed
            && let Some(problem) = factored(global, &self.friction, form)?
        {
            return Ok(problem);
        }
        let condensed;
        let (delassus, velocity) = match &self.data {
            Data::Local(Local { delassus, velocity, bilateral: None }) => (delassus, velocity),
            Data::Local(local) => {
                condensed = condense_local(local)?;
                (&condensed.0, &condensed.1)
            }
            Data::Global(global) => {
                condensed = condense_global(global)?;
                (&condensed.0, &condensed.1)
            }
        };
        let mut problem = ConeProblem::default();
        let (w, b, friction) = problem.parts_mut();
        *w = blocks(delassus);
        b.extend(velocity.chunks_exact(D).map(SVector::from_column_slice));
        friction.extend(self.friction.iter().copied().map(ContactCone::from));
        problem.check()?;
        Ok(problem)
    }

    /// The solution that goes with the percussions r: u, and v and λ where the problem has them.
    ///
    /// # Errors
    /// [`FclibError::Length`] and [`FclibError::NotFinite`] for r; [`FclibError::Singular`].
    pub fn solution(&self, percussions: Vec<f64>) -> Result<Solution, FclibError> {
        self.check()?;
        vector("r", &percussions, self.dimension * self.contacts())?;
        let r = &percussions;
        let (velocities, body_velocities, multipliers) = match &self.data {
            Data::Local(local) => {
                let mut u = local.velocity.clone();
                local.delassus.multiply_add(r, &mut u);
                let lambda = local.bilateral.as_ref().map(|b| multipliers(b, r)).transpose()?;
                if let (Some(bilateral), Some(lambda)) = (&local.bilateral, &lambda) {
                    bilateral.directions.multiply_add(lambda, &mut u);
                }
                (u, None, lambda)
            }
            Data::Global(global) => {
                let (v, lambda) = bodies(global, r)?;
                let mut u = global.velocity.clone();
                global.directions.multiply_add_transposed(&v, &mut u);
                (u, Some(v), global.bilateral.as_ref().map(|_| lambda))
            }
        };
        Ok(Solution { percussions, velocities, body_velocities, multipliers })
    }
}

/// The D×D blocks of a matrix: every block with an entry that is not zero, and the diagonal ones that are stored.
fn blocks<const D: usize>(matrix: &SparseMatrix) -> BlockMatrix<f64, D> {
    let mut result = BlockMatrix::new();
    let mut line: Vec<(usize, SMatrix<f64, D, D>)> = Vec::new();
    // Place of a block column in `line`, valid where `line` confirms it.
    let mut place = vec![0_usize; matrix.columns() / D];
    for row in 0..matrix.rows() / D {
        line.clear();
        for i in 0..D {
            for (j, value) in matrix.row(row * D + i) {
                let column = j / D;
                if line.get(place[column]).is_none_or(|&(c, _)| c != column) {
                    place[column] = line.len();
                    line.push((column, SMatrix::zeros()));
                }
                line[place[column]].1[(i, j % D)] = value;
            }
        }
        line.sort_unstable_by_key(|&(column, _)| column);
        result.start_row();
        for (column, block) in &line {
            if *column == row || block.iter().any(|&x| x != 0.0) {
                result.push(*column, *block);
            }
        }
    }
    result
}
