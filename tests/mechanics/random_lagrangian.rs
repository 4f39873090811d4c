//! Random Lagrangian systems M, C, K with several contacts, in the three storages.

use nalgebra::{DMatrix, SVector};
use nonsmooth::linalg::Symmetric;
use nonsmooth::system::{Forces, Lagrangian, SmoothGap};

use crate::stream::Stream;

/// How M, C and K are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Storage {
    Diagonal,
    Dense,
    Sparse,
}

/// M, C, K, linear gaps g = g₀ + H_N q, a constant and a periodic force, and a state.
///
/// The first velocity e₀ opens every contact without slip (H_N e₀ = 1, H_T e₀ = 0), so that the cone problems have a
/// solution whatever the laws; the constant force closes them.
#[derive(Debug, Clone)]
pub(crate) struct RandomLagrangian<const D: usize> {
    pub(crate) mass: DMatrix<f64>,
    pub(crate) damping: DMatrix<f64>,
    pub(crate) stiffness: DMatrix<f64>,
    /// Block row of each contact, one D-vector per degree of freedom.
    rows: Vec<Vec<SVector<f64, D>>>,
    gaps: Vec<f64>,
    force: Vec<f64>,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
}

fn square(stream: &mut Stream, n: usize, rank: usize, diagonal: bool) -> DMatrix<f64> {
    if diagonal {
        return DMatrix::from_fn(
            n,
            n,
            |i, j| if i == j && i < rank { stream.uniform(0.2, 1.0) } else { 0.0 },
        );
    }
    let g = DMatrix::from_fn(n, rank, |_, _| stream.uniform(-1.0, 1.0));
    &g * g.transpose() / rank as f64
}

impl<const D: usize> RandomLagrangian<D> {
    /// A system of `n` degrees of freedom and `contacts` contacts: M ≻ 0, C and K of rank n − 1. A diagonal one couples
    /// its degrees of freedom through the contacts alone.
    pub(crate) fn draw(stream: &mut Stream, n: usize, contacts: usize, diagonal: bool) -> Self {
        let mass = square(stream, n, n, diagonal) + DMatrix::identity(n, n) * 0.5;
        let damping = square(stream, n, n - 1, diagonal) * 0.3;
        let stiffness = square(stream, n, n - 1, diagonal) * 20.0;
        let mut entry = |column: usize| match column {
            0 => SVector::from_fn(|d, _| if d == 0 { 1.0 } else { 0.0 }),
            _ => SVector::from_fn(|_, _| stream.uniform(-1.0, 1.0)),
        };
        let rows = (0..contacts).map(|_| (0..n).map(&mut entry).collect()).collect();
        let gaps = (0..contacts).map(|_| stream.uniform(0.0, 0.05)).collect();
        let force = (0..n).map(|i| if i == 0 { -10.0 } else { stream.uniform(-1.0, 1.0) }).collect();
        let q = vec![0.0; n];
        let v = (0..n).map(|_| stream.uniform(-1.0, 1.0)).collect();
        Self { mass, damping, stiffness, rows, gaps, force, q, v }
    }

    /// The free system: M and K alone.
    pub(crate) fn conservative(&self, storage: Storage) -> Lagrangian<f64, D> {
        let system = Lagrangian::new(operator(&self.mass, storage));
        system.with_stiffness(operator(&self.stiffness, storage)).expect("sizes agree")
    }

    /// The whole system; contact α is of interface α.
    pub(crate) fn system(&self, storage: Storage) -> Lagrangian<f64, D> {
        let last = self.force.len() - 1;
        let forces =
            Forces::constant(self.force.clone()).with_varying(move |t: f64, f| f[last] += (5.0 * t).sin());
        let system =
            self.conservative(storage).with_damping(operator(&self.damping, storage)).expect("sizes agree");
        let mut system = system.with_forces(forces).expect("finite").with_scales(1.0, 1.0);
        for (interface, (row, &gap)) in self.rows.iter().zip(&self.gaps).enumerate() {
            let (normal, row) = (row.clone(), row.clone());
            let gap = move |q: &[f64]| gap + normal.iter().zip(q).map(|(h, q)| h[0] * q).sum::<f64>();
            let jacobian = move |_: &[f64], push: &mut dyn FnMut(usize, SVector<f64, D>)| {
                row.iter().enumerate().for_each(|(j, &h)| push(j, h));
            };
            system = system.with_contact(interface, SmoothGap::new(gap, jacobian));
        }
        system
    }
}

fn operator(matrix: &DMatrix<f64>, storage: Storage) -> Symmetric<f64> {
    let n = matrix.nrows();
    let operator = match storage {
        Storage::Diagonal => Symmetric::diagonal(matrix.diagonal().as_slice().to_vec()),
        Storage::Dense => Symmetric::dense(matrix.clone()),
        Storage::Sparse => {
            let entries = (0..n).flat_map(|j| (0..n).map(move |i| (i, j, matrix[(i, j)])));
            Symmetric::sparse(n, &entries.filter(|&(_, _, x)| x != 0.0).collect::<Vec<_>>())
        }
    };
    operator.expect("finite and symmetric")
}
