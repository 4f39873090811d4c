//! One Gauss–Seidel sweep, with what it remembers from one sweep to the next.

use nalgebra::SVector;

use crate::cone::{
    BlockMatrix, ConeProblem, FactoredDelassus, OneContactSolvers, Residual, Workspace, largest_eigenvalue,
};
use crate::scalar::Scalar;

/// Sweeps over a problem: for every contact r_α ← the exact solution of w_α = W_αα r_α + (b_α + Σ_{β≠α} W_αβ r_β).
#[derive(Debug, Clone)]
pub(super) struct GaussSeidel<T: Scalar, const D: usize> {
    /// λ_max(W_αα), one per contact.
    sizes: Vec<T>,
    contacts: OneContactSolvers<T, D>,
    workspace: Workspace<T>,
    /// W of a problem in factored form whose M̂ is coupled.
    formed: BlockMatrix<T, D>,
}

/// What a sweep carries along contact by contact.
trait Rows<T: Scalar, const D: usize> {
    /// Σ_{β≠α} W_αβ r_β at the current r.
    fn others(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D>;
    /// r_α was `before`, and is `now`.
    fn change(&mut self, contact: usize, before: &SVector<T, D>, now: &SVector<T, D>);
}

struct Formed<'a, T: Scalar, const D: usize>(&'a BlockMatrix<T, D>);

impl<T: Scalar, const D: usize> Rows<T, D> for Formed<'_, T, D> {
    #[inline(always)]
    fn others(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        let diagonal = self.0.diagonal(contact).expect("checked problems have every diagonal block");
        self.0.row_product(contact, r) - diagonal * r[contact]
    }
    #[inline(always)]
    fn change(&mut self, _: usize, _: &SVector<T, D>, _: &SVector<T, D>) {}
}

/// Keeps the velocities v = M̂⁻¹ Hᵀ r.
struct Bodies<'a, T: Scalar, const D: usize> {
    factors: &'a FactoredDelassus<T, D>,
    weighted: &'a [SVector<T, D>],
    velocities: &'a mut [T],
}

impl<T: Scalar, const D: usize> Rows<T, D> for Bodies<'_, T, D> {
    #[inline(always)]
    fn others(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        let all = self.factors.jacobian.velocity(contact, self.factors.dofs(), self.velocities);
        all - self.factors.diagonal(contact) * r[contact]
    }
    #[inline(always)]
    fn change(&mut self, contact: usize, before: &SVector<T, D>, now: &SVector<T, D>) {
        let (d, h) = (self.factors.dofs(), &self.factors.jacobian);
        let range = h.starts[contact]..h.starts[contact + 1];
        let columns = self.weighted[range.start * d..range.end * d].chunks_exact(d);
        let change = now - before;
        for (&node, columns) in h.nodes[range].iter().zip(columns) {
            let v = &mut self.velocities[node * d..(node + 1) * d];
            v.iter_mut().zip(columns).for_each(|(v, w)| *v += w.dot(&change));
        }
    }
}

impl<T: Scalar, const D: usize> GaussSeidel<T, D> {
    pub(super) fn new() -> Self {
        Self {
            sizes: Vec::new(),
            contacts: OneContactSolvers::new(),
            workspace: Workspace::default(),
            formed: BlockMatrix::new(),
        }
    }

    /// Reads the diagonal of W; allocates only where the problem is larger than any before.
    pub(super) fn prepare(&mut self, problem: &ConeProblem<T, D>) {
        self.sizes.clear();
        self.contacts.clear();
        for (i, &cone) in problem.cones().iter().enumerate() {
            let block = problem.diagonal(i);
            self.sizes.push(largest_eigenvalue(block));
            self.contacts.push(block, cone);
        }
        if problem.factors().is_some_and(|factors| factors.weighted().is_none()) {
            problem.delassus().form_in(&mut self.formed);
        }
    }

    /// [`ConeProblem::scaled_residual`] of the problem prepared.
    pub(super) fn scaled_residual(&mut self, problem: &ConeProblem<T, D>, r: &[SVector<T, D>]) -> T {
        problem.scaled_residual(r, &self.sizes, &mut self.workspace)
    }

    /// [`ConeProblem::residual`].
    pub(super) fn residual(&mut self, problem: &ConeProblem<T, D>, r: &[SVector<T, D>]) -> Residual<T> {
        problem.residual_in(r, &mut self.workspace)
    }

    pub(super) fn workspace(&mut self) -> &mut Workspace<T> {
        &mut self.workspace
    }

    pub(super) fn sizes(&self) -> &[T] {
        &self.sizes
    }

    /// One sweep; returns Σ ‖W_αα Δr_α‖², what the sweep changed as a velocity squared.
    ///
    /// A problem in factored form is swept with H and the velocities where M̂ is block-diagonal; a coupled M̂ would
    /// need a solve per contact, so that [`prepare`](Self::prepare) forms W.
    pub(super) fn sweep(&mut self, problem: &ConeProblem<T, D>, r: &mut [SVector<T, D>], reverse: bool) -> T {
        let Self { contacts, workspace, formed, .. } = self;
        match problem.factors().and_then(|factors| Some((factors, factors.weighted()?))) {
            Some((factors, weighted)) => {
                let velocities = factors.velocities(r, workspace);
                run(Bodies { factors, weighted, velocities }, problem, r, reverse, contacts)
            }
            None => {
                let w = problem.delassus().formed().unwrap_or(formed);
                run(Formed(w), problem, r, reverse, contacts)
            }
        }
    }
}

#[inline]
fn run<T: Scalar, const D: usize>(
    mut rows: impl Rows<T, D>,
    problem: &ConeProblem<T, D>,
    r: &mut [SVector<T, D>],
    reverse: bool,
    contacts: &mut OneContactSolvers<T, D>,
) -> T {
    let (b, m) = (problem.b(), r.len());
    let mut total = T::zero();
    for k in 0..m {
        let i = if reverse { m - 1 - k } else { k };
        let before = r[i];
        let others = rows.others(i, r) + b[i];
        let now = contacts.solve(i, &others);
        r[i] = now;
        rows.change(i, &before, &now);
        // W_αα Δr and not λ_max ‖Δr‖: wedged contacts shift percussions that move nothing.
        total += (problem.diagonal(i) * (now - before)).norm_squared();
    }
    total
}
