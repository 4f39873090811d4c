//! Static preload: the equilibrium under the boundary conditions of a time.

use super::ElasticBody;
use crate::linalg::{Factor, FactorError, OperatorError, Symmetric};
use crate::scalar::{Scalar, epsilon, lit, to_f64};

/// What the nodes that may touch an obstacle do while the body is preloaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// They are held in every direction.
    Fixed,
    /// They are held along the normal alone: frictionless supports.
    Sliding,
    /// They are free, as if no obstacle were there.
    Free,
}

/// Why there is no static equilibrium.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PreloadError {
    /// K is singular on what is free to move.
    #[error("no static equilibrium: the body can move without strain ({0}); hold more of it")]
    Singular(FactorError),
    /// K is singular but for rounding on what is free to move.
    #[error(
        "no static equilibrium: the body can move almost without strain (pivots of K in the ratio {ratio:e}); hold \
         more of it"
    )]
    NearlySingular {
        /// The smallest pivot over the largest.
        ratio: f64,
    },
    /// The restricted K is not an operator.
    #[error(transparent)]
    Operator(#[from] OperatorError),
}

impl<T: Scalar> ElasticBody<T> {
    /// The displacements q of the equilibrium K q = F at `time`, with prescribed displacements at their value of
    /// that time and the nodes that may touch held as `support` says; the constant forces (gravity, constant
    /// tractions) act where `with_constant_forces`.
    ///
    /// # Errors
    /// [`PreloadError::Singular`] where the body can move without strain.
    pub fn preload(
        &self,
        time: T,
        support: Support,
        with_constant_forces: bool,
    ) -> Result<Vec<T>, PreloadError> {
        let n = self.mass.size();
        let mut q = vec![T::zero(); n];
        let mut held = vec![false; n];
        if let Some(prescribed) = &self.prescribed {
            for i in 0..prescribed.count() {
                q[prescribed.first() + i] = prescribed.displacement(i, time);
                held[prescribed.first() + i] = true;
            }
        }
        // Obstacles along an axis hold that component; slanted ones hold both.
        for contact in &self.geometry.contacts {
            let normal = self.geometry.obstacles[contact.obstacle].normal;
            for axis in 0..self.geometry.mesh.dimension() {
                let hold = match support {
                    Support::Fixed => true,
                    Support::Sliding => normal[axis] != T::zero(),
                    Support::Free => false,
                };
                held[self.geometry.dof(contact.node, axis)] |= hold;
            }
        }
        let mut place = vec![usize::MAX; n];
        let mut free = Vec::new();
        for dof in (0..n).filter(|&dof| !held[dof]) {
            place[dof] = free.len();
            free.push(dof);
        }
        let mut force = vec![T::zero(); n];
        self.forces.at(time, &mut force);
        if !with_constant_forces {
            force.iter_mut().zip(self.forces.constant_part()).for_each(|(f, &c)| *f -= c);
        }
        let mut stretch = vec![T::zero(); n];
        self.stiffness.multiply(&q, &mut stretch);
        let mut right: Vec<T> = free.iter().map(|&dof| force[dof] - stretch[dof]).collect();
        if !free.is_empty() {
            let inside = |&(i, j, _): &(usize, usize, T)| !held[i] && !held[j];
            let moved = |(i, j, k): (usize, usize, T)| (place[i], place[j], k);
            let entries: Vec<_> = self.stiffness.entries().filter(inside).map(moved).collect();
            let restricted = Symmetric::sparse(free.len(), &entries)?;
            let mut factor = Factor::new(&restricted).map_err(PreloadError::Singular)?;
            if let Factor::Sparse(factor) = &factor {
                // What rounding makes of a zero pivot; pivots of a held body are n² times larger and more.
                let ratio = factor.pivot_ratio();
                if ratio < lit::<T>(16.0 * free.len() as f64) * epsilon::<T>() {
                    return Err(PreloadError::NearlySingular { ratio: to_f64(ratio) });
                }
            }
            factor.solve_in_place(&mut right);
        }
        free.iter().zip(right).for_each(|(&dof, x)| q[dof] = x);
        Ok(q)
    }
}
