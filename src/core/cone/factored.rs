//! The Delassus operator in factored form, W = H M̂⁻¹ Hᵀ, never formed.

use nalgebra::{SMatrix, SVector};

use super::{BlockMatrix, Workspace};
use crate::linalg::{BlockRows, Multifrontal, Symmetric};
use crate::scalar::{Scalar, all_finite};

/// W = H M̂⁻¹ Hᵀ kept as H and M̂, in blocks of `dofs` consecutive velocities: the six of a rigid body, the two or
/// three of a mesh node.
///
/// H maps velocities to local velocities (N, T1, T2), M̂ is symmetric positive definite. A product with W costs a
/// pass over H twice and a solve with M̂, whatever the number of contacts per body.
#[derive(Debug, Clone)]
pub struct FactoredDelassus<T: Scalar, const D: usize> {
    dofs: usize,
    nodes: usize,
    pub(crate) jacobian: NodeRows<T, D>,
    /// M̂⁻¹ Hᵀ in the pattern of H, where M̂ is block-diagonal.
    weighted: Option<Vec<SVector<T, D>>>,
    pub(crate) mass: NodeMatrix<T>,
    inverse: Inverse<T>,
    diagonal: Vec<SMatrix<T, D, D>>,
    formed_blocks: usize,
}

/// M̂⁻¹: `dofs`×`dofs` blocks, or the factors of a coupled M̂.
#[derive(Debug, Clone)]
enum Inverse<T> {
    Blocks(Vec<T>),
    Factors(Box<Multifrontal<T>>),
}

/// H by blocks: entry e of a row has `dofs` columns of D components.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NodeRows<T: Scalar, const D: usize> {
    pub(crate) starts: Vec<usize>,
    pub(crate) nodes: Vec<usize>,
    pub(crate) columns: Vec<SVector<T, D>>,
}

/// A matrix of `dofs`×`dofs` blocks in compressed rows; a block is stored by columns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NodeMatrix<T> {
    pub(crate) starts: Vec<usize>,
    pub(crate) columns: Vec<usize>,
    pub(crate) values: Vec<T>,
}

/// Why (H, M̂) is not a factored Delassus operator.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FactoredError {
    /// The number of velocities is not a multiple of the block size, or the block size is 0.
    #[error("{velocities} velocities do not split into blocks of {dofs}")]
    Blocks {
        /// Size of M̂.
        velocities: usize,
        /// Velocities per block.
        dofs: usize,
    },
    /// H names a velocity M̂ does not have.
    #[error("contact {contact} acts on velocity {velocity}, M̂ has {velocities}")]
    Velocity {
        /// Index of the contact.
        contact: usize,
        /// Index of the velocity.
        velocity: usize,
        /// Size of M̂.
        velocities: usize,
    },
    /// A NaN or an infinity.
    #[error("{what} is not finite at {index}")]
    NotFinite {
        /// `H` or `M̂`.
        what: &'static str,
        /// Contact of H, or row of M̂.
        index: usize,
    },
    /// M̂ has no inverse.
    #[error("M̂ is singular at block {block}")]
    Singular {
        /// Index of the block of velocities.
        block: usize,
    },
}

impl<T: Scalar, const D: usize> FactoredDelassus<T, D> {
    /// The operator of `jacobian` H (one block row per contact over the velocities) and `mass` M̂, its velocities taken
    /// in blocks of `dofs`.
    ///
    /// # Errors
    /// Every [`FactoredError`].
    pub fn new(jacobian: &BlockRows<T, D>, mass: &Symmetric<T>, dofs: usize) -> Result<Self, FactoredError> {
        let velocities = mass.size();
        if dofs == 0 || !velocities.is_multiple_of(dofs) {
            return Err(FactoredError::Blocks { velocities, dofs });
        }
        let nodes = velocities / dofs;
        let jacobian = NodeRows::new(jacobian, velocities, dofs)?;
        let mass = NodeMatrix::new(mass, nodes, dofs)?;
        let inverse = if mass.columns.len() == nodes {
            Inverse::Blocks(inverse_blocks(&mass.values, dofs)?)
        } else {
            let mut factors = Multifrontal::new();
            factors
                .analyse(&mass.starts, &mass.columns, dofs)
                .map_err(|error| FactoredError::Singular { block: error.row })?;
            factors
                .factor(&mass.values, &vec![true; nodes])
                .map_err(|error| FactoredError::Singular { block: error.node })?;
            Inverse::Factors(Box::new(factors))
        };
        let mut operator = Self {
            dofs,
            nodes,
            jacobian,
            weighted: None,
            mass,
            inverse,
            diagonal: Vec::new(),
            formed_blocks: 0,
        };
        operator.prepare();
        operator.formed_blocks = operator.count_formed_blocks();
        Ok(operator)
    }

    /// M̂⁻¹Hᵀ where it is cheap, and the diagonal blocks.
    fn prepare(&mut self) {
        let (d, contacts) = (self.dofs, self.contacts());
        if let Inverse::Blocks(inverse) = &self.inverse {
            let mut weighted = Vec::with_capacity(self.jacobian.columns.len());
            for (&node, columns) in self.jacobian.nodes.iter().zip(self.jacobian.columns.chunks_exact(d)) {
                for row in 0..d {
                    let block = &inverse[node * d * d..][..d * d];
                    let sum = (0..d).fold(SVector::zeros(), |sum, k| sum + columns[k] * block[k * d + row]);
                    weighted.push(sum);
                }
            }
            self.diagonal = (0..contacts)
                .map(|i| {
                    let range = self.jacobian.starts[i] * d..self.jacobian.starts[i + 1] * d;
                    let pairs = self.jacobian.columns[range.clone()].iter().zip(&weighted[range]);
                    pairs.fold(SMatrix::zeros(), |sum, (h, w)| sum + h * w.transpose())
                })
                .collect();
            self.weighted = Some(weighted);
            return;
        }
        let mut product = Workspace::default();
        self.diagonal = (0..contacts)
            .map(|i| {
                SMatrix::from_columns(&std::array::from_fn::<_, D, _>(|c| {
                    let unit = SVector::from_fn(|k, _| if k == c { T::one() } else { T::zero() });
                    self.start_product(&mut product);
                    self.jacobian.add_transpose(i, d, &unit, &mut product.velocities);
                    self.divide(&mut product);
                    self.jacobian.velocity(i, d, &product.velocities)
                }))
            })
            .collect();
    }

    /// Becomes `other`, in the memory at hand.
    pub(crate) fn take(&mut self, other: &Self) {
        let NodeRows { starts, nodes, columns } = &mut self.jacobian;
        starts.clone_from(&other.jacobian.starts);
        nodes.clone_from(&other.jacobian.nodes);
        columns.clone_from(&other.jacobian.columns);
        let NodeMatrix { starts, columns, values } = &mut self.mass;
        starts.clone_from(&other.mass.starts);
        columns.clone_from(&other.mass.columns);
        values.clone_from(&other.mass.values);
        (self.dofs, self.nodes, self.formed_blocks) = (other.dofs, other.nodes, other.formed_blocks);
        self.weighted.clone_from(&other.weighted);
        self.diagonal.clone_from(&other.diagonal);
        match (&mut self.inverse, &other.inverse) {
            (Inverse::Blocks(mine), Inverse::Blocks(others)) => mine.clone_from(others),
            (mine, others) => *mine = others.clone(),
        }
    }

    /// Whether `other` has its blocks at the same places.
    pub(crate) fn same_pattern(&self, other: &Self) -> bool {
        self.dofs == other.dofs
            && self.jacobian.starts == other.jacobian.starts
            && self.jacobian.nodes == other.jacobian.nodes
            && self.mass.starts == other.mass.starts
            && self.mass.columns == other.mass.columns
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.jacobian.starts.len() - 1
    }

    /// Velocities per block.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// Blocks of velocities.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// W_αα.
    #[inline]
    pub fn diagonal(&self, contact: usize) -> &SMatrix<T, D, D> {
        &self.diagonal[contact]
    }

    /// M̂⁻¹ Hᵀ in the pattern of H (D rows per column), `None` where M̂ couples blocks.
    pub(crate) fn weighted(&self) -> Option<&[SVector<T, D>]> {
        self.weighted.as_deref()
    }

    fn start_product(&self, product: &mut Workspace<T>) {
        product.velocities.clear();
        product.velocities.resize(self.nodes * self.dofs, T::zero());
    }

    /// velocities ← M̂⁻¹ velocities.
    fn divide(&self, product: &mut Workspace<T>) {
        let d = self.dofs;
        match &self.inverse {
            Inverse::Factors(factors) => factors.solve(&mut product.velocities, &mut product.solve),
            Inverse::Blocks(inverse) => {
                for (v, block) in product.velocities.chunks_exact_mut(d).zip(inverse.chunks_exact(d * d)) {
                    if d <= 8 {
                        let mut x = [T::zero(); 8];
                        x[..d].copy_from_slice(v);
                        v.fill(T::zero());
                        for (column, &x) in block.chunks_exact(d).zip(&x) {
                            v.iter_mut().zip(column).for_each(|(v, &b)| *v += b * x);
                        }
                    } else {
                        let x = v.to_vec();
                        v.fill(T::zero());
                        for (column, &x) in block.chunks_exact(d).zip(&x) {
                            v.iter_mut().zip(column).for_each(|(v, &b)| *v += b * x);
                        }
                    }
                }
            }
        }
    }

    /// M̂⁻¹ Hᵀ r, in the buffers of `product`.
    pub(crate) fn velocities<'a>(&self, r: &[SVector<T, D>], product: &'a mut Workspace<T>) -> &'a mut [T] {
        self.start_product(product);
        for (i, r) in r.iter().enumerate() {
            self.jacobian.add_transpose(i, self.dofs, r, &mut product.velocities);
        }
        self.divide(product);
        &mut product.velocities
    }

    /// out = W r.
    pub(crate) fn apply(&self, r: &[SVector<T, D>], out: &mut [SVector<T, D>], product: &mut Workspace<T>) {
        let velocities = self.velocities(r, product);
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.jacobian.velocity(i, self.dofs, velocities);
        }
    }

    /// Number of blocks W has when it is formed: contacts couple through the blocks of velocities they share, all of
    /// them where M̂ couples them.
    pub fn formed_blocks(&self) -> usize {
        self.formed_blocks
    }

    fn count_formed_blocks(&self) -> usize {
        if self.weighted.is_none() {
            return self.contacts() * self.contacts();
        }
        let mut contacts = vec![0usize; self.nodes];
        self.jacobian.nodes.iter().for_each(|&node| contacts[node] += 1);
        // Two contacts between the same two blocks are counted twice: an estimate from above.
        contacts.iter().map(|c| c * c).sum::<usize>().saturating_sub(self.contacts())
    }

    /// W, block by block.
    pub fn form(&self) -> BlockMatrix<T, D> {
        let (d, m) = (self.dofs, self.contacts());
        let mut w = BlockMatrix::new();
        let Some(weighted) = &self.weighted else {
            let mut product = Workspace::default();
            let mut full = vec![SMatrix::<T, D, D>::zeros(); m * m];
            for j in 0..m {
                for c in 0..D {
                    let unit = SVector::from_fn(|k, _| if k == c { T::one() } else { T::zero() });
                    self.start_product(&mut product);
                    self.jacobian.add_transpose(j, d, &unit, &mut product.velocities);
                    self.divide(&mut product);
                    for i in 0..m {
                        full[i * m + j].set_column(c, &self.jacobian.velocity(i, d, &product.velocities));
                    }
                }
            }
            full.chunks(m.max(1)).for_each(|row| {
                w.start_row();
                row.iter().enumerate().for_each(|(j, &block)| w.push(j, block));
            });
            return w;
        };
        // Entries of H by node.
        let mut touching: Vec<Vec<(usize, usize)>> = vec![Vec::new(); self.nodes];
        for i in 0..m {
            (self.jacobian.starts[i]..self.jacobian.starts[i + 1])
                .for_each(|entry| touching[self.jacobian.nodes[entry]].push((i, entry)));
        }
        let mut place = vec![usize::MAX; m];
        let mut row: Vec<(usize, SMatrix<T, D, D>)> = Vec::new();
        for i in 0..m {
            row.clear();
            for own in self.jacobian.starts[i]..self.jacobian.starts[i + 1] {
                let left = &self.jacobian.columns[own * d..(own + 1) * d];
                for &(j, entry) in &touching[self.jacobian.nodes[own]] {
                    let right = &weighted[entry * d..(entry + 1) * d];
                    let block =
                        left.iter().zip(right).fold(SMatrix::zeros(), |sum, (h, w)| sum + h * w.transpose());
                    if place[j] == usize::MAX {
                        place[j] = row.len();
                        row.push((j, block));
                    } else {
                        row[place[j]].1 += block;
                    }
                }
            }
            row.iter().for_each(|&(j, _)| place[j] = usize::MAX);
            row.sort_unstable_by_key(|&(j, _)| j);
            w.start_row();
            row.iter().for_each(|&(j, block)| w.push(j, block));
        }
        w
    }
}

impl<T: Scalar, const D: usize> PartialEq for FactoredDelassus<T, D> {
    fn eq(&self, other: &Self) -> bool {
        self.dofs == other.dofs && self.jacobian == other.jacobian && self.mass == other.mass
    }
}

impl<T: Scalar, const D: usize> NodeRows<T, D> {
    fn new(h: &BlockRows<T, D>, velocities: usize, dofs: usize) -> Result<Self, FactoredError> {
        let mut rows = Self { starts: vec![0], nodes: Vec::new(), columns: Vec::new() };
        for contact in 0..h.rows() {
            let start = rows.nodes.len();
            for (velocity, entry) in h.row(contact) {
                if velocity >= velocities {
                    return Err(FactoredError::Velocity { contact, velocity, velocities });
                }
                if !all_finite(entry.iter()) {
                    return Err(FactoredError::NotFinite { what: "H", index: contact });
                }
                let node = velocity / dofs;
                let place = rows.nodes[start..].iter().position(|&n| n == node).unwrap_or_else(|| {
                    rows.nodes.push(node);
                    rows.columns.resize(rows.columns.len() + dofs, SVector::zeros());
                    rows.nodes.len() - 1 - start
                });
                rows.columns[(start + place) * dofs + velocity % dofs] += entry;
            }
            rows.starts.push(rows.nodes.len());
        }
        Ok(rows)
    }

    /// The entries of contact `contact`: node and columns.
    #[inline]
    pub(crate) fn row(&self, contact: usize, dofs: usize) -> impl Iterator<Item = (usize, &[SVector<T, D>])> {
        let range = self.starts[contact]..self.starts[contact + 1];
        let columns = &self.columns[range.start * dofs..range.end * dofs];
        self.nodes[range].iter().copied().zip(columns.chunks_exact(dofs))
    }

    /// (H v)_α.
    #[inline]
    pub(crate) fn velocity(&self, contact: usize, dofs: usize, v: &[T]) -> SVector<T, D> {
        let mut sum = SVector::zeros();
        for (node, columns) in self.row(contact, dofs) {
            let v = &v[node * dofs..(node + 1) * dofs];
            columns.iter().zip(v).for_each(|(h, &v)| sum += h * v);
        }
        sum
    }

    /// f ← f + (Hᵀ)_α r.
    #[inline]
    pub(crate) fn add_transpose(&self, contact: usize, dofs: usize, r: &SVector<T, D>, f: &mut [T]) {
        for (node, columns) in self.row(contact, dofs) {
            let f = &mut f[node * dofs..(node + 1) * dofs];
            f.iter_mut().zip(columns).for_each(|(f, h)| *f += h.dot(r));
        }
    }
}

impl<T: Scalar> NodeMatrix<T> {
    fn new(mass: &Symmetric<T>, nodes: usize, dofs: usize) -> Result<Self, FactoredError> {
        let entries: Vec<(usize, usize, T)> = match mass {
            Symmetric::Diagonal(entries) => entries.iter().enumerate().map(|(i, &x)| (i, i, x)).collect(),
            Symmetric::Dense(matrix) => {
                let n = matrix.nrows();
                (0..n).flat_map(|j| (0..n).map(move |i| (i, j, matrix[(i, j)]))).collect()
            }
            Symmetric::Sparse(matrix) => matrix.entries().collect(),
        };
        let mut blocks: Vec<(usize, usize)> = (0..nodes).map(|i| (i, i)).collect();
        for &(i, j, x) in &entries {
            if !all_finite([&x]) {
                return Err(FactoredError::NotFinite { what: "M̂", index: i });
            }
            if i / dofs != j / dofs && x != T::zero() {
                blocks.push((i / dofs, j / dofs));
                blocks.push((j / dofs, i / dofs));
            }
        }
        blocks.sort_unstable();
        blocks.dedup();
        let columns: Vec<usize> = blocks.iter().map(|&(_, j)| j).collect();
        let starts = (0..=nodes).map(|i| blocks.partition_point(|&(row, _)| row < i)).collect();
        let mut matrix = Self { starts, values: vec![T::zero(); columns.len() * dofs * dofs], columns };
        for (i, j, x) in entries {
            if let Ok(entry) = blocks.binary_search(&(i / dofs, j / dofs)) {
                matrix.values[entry * dofs * dofs + (j % dofs) * dofs + i % dofs] += x;
            }
        }
        Ok(matrix)
    }
}

fn inverse_blocks<T: Scalar>(values: &[T], dofs: usize) -> Result<Vec<T>, FactoredError> {
    let mut inverse = Vec::with_capacity(values.len());
    for (block, values) in values.chunks_exact(dofs * dofs).enumerate() {
        let matrix = nalgebra::DMatrix::from_column_slice(dofs, dofs, values);
        let Some(inverted) = matrix.try_inverse().filter(|x| all_finite(x.iter())) else {
            return Err(FactoredError::Singular { block });
        };
        inverse.extend_from_slice(inverted.as_slice());
    }
    Ok(inverse)
}
