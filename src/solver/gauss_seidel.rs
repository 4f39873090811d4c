//! One Gauss–Seidel sweep, with what it remembers from one sweep to the next.

use nalgebra::{SMatrix, SVector};

use crate::cone::{
    BlockMatrix, ConeProblem, FactoredDelassus, Product, largest_eigenvalue, solve_one_contact_from,
};
use crate::scalar::Scalar;

/// Sweeps over a problem: for every contact r_α ← the exact solution of w_α = W_αα r_α + (b_α + Σ_{β≠α} W_αβ r_β).
#[derive(Debug, Clone)]
pub(super) struct GaussSeidel<T> {
    /// λ_max(W_αα), one per contact.
    sizes: Vec<T>,
    /// The slip's α = −w_T/r_T of the last sweep, one per contact: where the next root-finder starts.
    slips: Vec<T>,
    product: Product<T>,
}

/// What a sweep carries along contact by contact.
trait Rows<T: Scalar, const D: usize> {
    /// (W r)_α at the current r.
    fn product(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D>;
    fn diagonal(&self, contact: usize) -> &SMatrix<T, D, D>;
    /// r_α has changed by `change`.
    fn change(&mut self, contact: usize, change: &SVector<T, D>);
}

struct Formed<'a, T: Scalar, const D: usize>(&'a BlockMatrix<T, D>);

impl<T: Scalar, const D: usize> Rows<T, D> for Formed<'_, T, D> {
    #[inline(always)]
    fn product(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        self.0.row_product(contact, r)
    }
    #[inline(always)]
    fn diagonal(&self, contact: usize) -> &SMatrix<T, D, D> {
        self.0.diagonal(contact).expect("checked problems have every diagonal block")
    }
    #[inline(always)]
    fn change(&mut self, _: usize, _: &SVector<T, D>) {}
}

/// Keeps the velocities v = M̂⁻¹ Hᵀ r.
struct Bodies<'a, T: Scalar, const D: usize> {
    factors: &'a FactoredDelassus<T, D>,
    weighted: &'a [SVector<T, D>],
    velocities: &'a mut [T],
}

impl<T: Scalar, const D: usize> Rows<T, D> for Bodies<'_, T, D> {
    #[inline(always)]
    fn product(&self, contact: usize, _: &[SVector<T, D>]) -> SVector<T, D> {
        self.factors.jacobian.velocity(contact, self.factors.dofs(), self.velocities)
    }
    #[inline(always)]
    fn diagonal(&self, contact: usize) -> &SMatrix<T, D, D> {
        self.factors.diagonal(contact)
    }
    #[inline(always)]
    fn change(&mut self, contact: usize, change: &SVector<T, D>) {
        let (d, h) = (self.factors.dofs(), &self.factors.jacobian);
        let range = h.starts[contact]..h.starts[contact + 1];
        let columns = self.weighted[range.start * d..range.end * d].chunks_exact(d);
        for (&node, columns) in h.nodes[range].iter().zip(columns) {
            let v = &mut self.velocities[node * d..(node + 1) * d];
            v.iter_mut().zip(columns).for_each(|(v, w)| *v += w.dot(change));
        }
    }
}

impl<T: Scalar> GaussSeidel<T> {
    pub(super) fn new() -> Self {
        Self { sizes: Vec::new(), slips: Vec::new(), product: Product::default() }
    }

    /// Reads the diagonal of W; allocates only where the problem is larger than any before.
    pub(super) fn prepare<const D: usize>(&mut self, problem: &ConeProblem<T, D>) {
        let m = problem.contacts();
        self.sizes.clear();
        self.sizes.extend((0..m).map(|i| largest_eigenvalue(problem.diagonal(i))));
        self.slips.clear();
        self.slips.resize(m, T::zero());
    }

    pub(super) fn sizes(&self) -> &[T] {
        &self.sizes
    }

    /// One sweep; returns Σ ‖W_αα Δr_α‖², what the sweep changed as a velocity squared.
    ///
    /// A problem in factored form is swept with H and the velocities where M̂ is block-diagonal; a coupled M̂ would
    /// need a solve per contact, so that W is formed.
    pub(super) fn sweep<const D: usize>(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        reverse: bool,
    ) -> T {
        let Self { slips, product, .. } = self;
        match problem.factors().and_then(|factors| Some((factors, factors.weighted()?))) {
            Some((factors, weighted)) => {
                let velocities = factors.velocities(r, product);
                run(Bodies { factors, weighted, velocities }, problem, r, reverse, slips)
            }
            None => run(Formed(problem.delassus()), problem, r, reverse, slips),
        }
    }
}

#[inline]
fn run<T: Scalar, const D: usize>(
    mut rows: impl Rows<T, D>,
    problem: &ConeProblem<T, D>,
    r: &mut [SVector<T, D>],
    reverse: bool,
    slips: &mut [T],
) -> T {
    let (b, friction, m) = (problem.b(), problem.friction(), r.len());
    let mut total = T::zero();
    for k in 0..m {
        let i = if reverse { m - 1 - k } else { k };
        let old = r[i];
        let block = *rows.diagonal(i);
        let others = rows.product(i, r) + (b[i] - block * old);
        let next = solve_one_contact_from(&block, &others, friction[i], &mut slips[i]);
        let change = next - old;
        r[i] = next;
        rows.change(i, &change);
        total += (block * change).norm_squared();
    }
    total
}
