//! Multifrontal LU of a block matrix with symmetric pattern, some of its nodes left out.

use std::ops::Range;

use super::error::{NoPivot, PatternError};
use super::front::eliminate;
use super::symbolic::Symbolic;
use crate::scalar::Scalar;

/// K = L U by fronts (Duff and Reid 1984, doi:10.1137/0905045): the symbolic analysis is that of the whole pattern
/// and is kept while the pattern stays; each numeric factorisation takes the active nodes only. Rows are exchanged
/// within a front's pivots, never across fronts.
///
/// ```
/// use nonsmooth::linalg::{Multifrontal, SolveBuffers};
///
/// // [2 1; 1 3] as four blocks of one number each.
/// let mut lu = Multifrontal::new();
/// lu.analyse(&[0, 2, 4], &[0, 1, 0, 1], 1)?;
/// lu.factor(&[2.0, 1.0, 1.0, 3.0], &[true, true])?;
/// let mut x = [3.0, 4.0];
/// lu.solve(&mut x, &mut SolveBuffers::default());
/// assert!((x[0] - 1.0f64).abs() < 1e-15 && (x[1] - 1.0f64).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Multifrontal<T> {
    symbolic: Symbolic,
    fronts: Vec<Front>,
    /// Active positions of the fronts, pivots first.
    nodes: Vec<usize>,
    /// L (n×p) then U₁₂ (p×q) of every front, in columns.
    factors: Vec<T>,
    swaps: Vec<usize>,
    dense: Vec<T>,
    stack: Vec<T>,
    /// Fronts whose update waits on the stack.
    waiting: Vec<usize>,
    local: Vec<usize>,
}

/// Scratch memory of a solve: the right side in the order of elimination, and the part of it that belongs to the pivots of
/// a front.
#[derive(Debug, Clone)]
pub struct SolveBuffers<T> {
    x: Vec<T>,
    head: Vec<T>,
}

impl<T> Default for SolveBuffers<T> {
    fn default() -> Self {
        Self { x: Vec::new(), head: Vec::new() }
    }
}

impl<T: Scalar> Default for Multifrontal<T> {
    fn default() -> Self {
        Self::new()
    }
}

#[derive(Debug, Clone, Default)]
struct Front {
    nodes: Range<usize>,
    /// Scalar pivots p and rows n.
    pivots: usize,
    rows: usize,
    factors: usize,
    swaps: usize,
}

impl<T: Scalar> Multifrontal<T> {
    /// Factors of nothing.
    pub fn new() -> Self {
        Self {
            symbolic: Symbolic::default(),
            fronts: Vec::new(),
            nodes: Vec::new(),
            factors: Vec::new(),
            swaps: Vec::new(),
            dense: Vec::new(),
            stack: Vec::new(),
            waiting: Vec::new(),
            local: Vec::new(),
        }
    }

    /// Takes the pattern of a matrix of `size`×`size` blocks: compressed rows, ascending, symmetric, with the
    /// diagonal. The analysis is redone only where the pattern differs from the last.
    ///
    /// # Errors
    /// [`PatternError`] with the first row that is not so.
    pub fn analyse(&mut self, starts: &[usize], columns: &[usize], size: usize) -> Result<(), PatternError> {
        if !self.symbolic.matches(starts, columns, size) {
            self.symbolic = Symbolic::new(starts, columns, size)?;
            self.fronts.clear();
        }
        Ok(())
    }

    /// Factors the matrix whose entries, `size`² numbers each in columns, stand in `values` in the order of the
    /// pattern, restricted to the active nodes.
    ///
    /// # Errors
    /// [`NoPivot`].
    ///
    /// # Panics
    /// If there are fewer values or nodes than the pattern has.
    pub fn factor(&mut self, values: &[T], active: &[bool]) -> Result<(), NoPivot> {
        let d = self.symbolic.size;
        self.fronts.clear();
        self.nodes.clear();
        self.factors.clear();
        self.swaps.clear();
        self.stack.clear();
        self.waiting.clear();
        self.local.resize(self.symbolic.order.len(), 0);
        for s in 0..self.symbolic.supernodes.len() {
            let supernode = self.symbolic.supernodes[s].clone();
            let first = self.nodes.len();
            let order = &self.symbolic.order;
            self.nodes.extend(supernode.pivots.clone().filter(|&k| active[order[k]]));
            let pivots = self.nodes.len() - first;
            let border = self.symbolic.borders[supernode.border.clone()].iter().copied();
            self.nodes.extend(border.filter(|&k| active[order[k]]));
            let nodes = first..self.nodes.len();
            for (i, &k) in self.nodes[nodes.clone()].iter().enumerate() {
                self.local[k] = i;
            }
            let (p, n) = (pivots * d, nodes.len() * d);
            self.dense.clear();
            self.dense.resize(n * n, T::zero());
            self.assemble(values, active, supernode.pivots, nodes.start..nodes.start + pivots, n);
            self.absorb(supernode.children, n);
            let front =
                Front { nodes, pivots: p, rows: n, factors: self.factors.len(), swaps: self.swaps.len() };
            self.swaps.resize(front.swaps + p, 0);
            eliminate(&mut self.dense, n, p, &mut self.swaps[front.swaps..])
                .map_err(|column| NoPivot { node: self.symbolic.order[self.nodes[first + column / d]] })?;
            self.factors.extend_from_slice(&self.dense[..n * p]);
            for column in self.dense[n * p..].chunks_exact(n.max(1)) {
                self.factors.extend_from_slice(&column[..p]);
            }
            if n > p || !self.symbolic.supernodes[s].border.is_empty() {
                for column in self.dense[n * p..].chunks_exact(n.max(1)) {
                    self.stack.extend_from_slice(&column[p..]);
                }
                self.waiting.push(s);
            }
            self.fronts.push(front);
        }
        Ok(())
    }

    /// Adds the entries of the pivots' rows and columns to the front.
    fn assemble(
        &mut self,
        values: &[T],
        active: &[bool],
        supernode: Range<usize>,
        pivots: Range<usize>,
        n: usize,
    ) {
        let (d, symbolic) = (self.symbolic.size, &self.symbolic);
        for &k in &self.nodes[pivots] {
            let row = self.local[k] * d;
            for entry in symbolic.row(symbolic.order[k]) {
                let node = symbolic.column(entry);
                let j = symbolic.position[node];
                if j < supernode.start || !active[node] {
                    continue;
                }
                let column = self.local[j] * d;
                for c in 0..d {
                    let from = &values[entry * d * d + c * d..][..d];
                    let to = &mut self.dense[(column + c) * n + row..][..d];
                    to.iter_mut().zip(from).for_each(|(to, &from)| *to += from);
                }
                if j >= supernode.end {
                    let mirror = symbolic.mirror[entry] * d * d;
                    for c in 0..d {
                        let from = &values[mirror + c * d..][..d];
                        let to = &mut self.dense[(row + c) * n + column..][..d];
                        to.iter_mut().zip(from).for_each(|(to, &from)| *to += from);
                    }
                }
            }
        }
    }

    /// Adds the updates of the last `children` fronts on the stack to the front of `n` rows.
    fn absorb(&mut self, children: usize, n: usize) {
        let d = self.symbolic.size;
        for _ in 0..children {
            let child = self.waiting.pop().expect("children precede their parent");
            let front = &self.fronts[child];
            let border = &self.nodes[front.nodes.start + front.pivots / d..front.nodes.end];
            let q = front.rows - front.pivots;
            let update = self.stack.len() - q * q;
            for (jj, &j) in border.iter().enumerate() {
                let column = self.local[j] * d;
                for c in 0..d {
                    let from = &self.stack[update + (jj * d + c) * q..][..q];
                    let to = &mut self.dense[(column + c) * n..][..n];
                    for (from, &i) in from.chunks_exact(d).zip(border) {
                        let row = self.local[i] * d;
                        to[row..row + d].iter_mut().zip(from).for_each(|(to, &from)| *to += from);
                    }
                }
            }
            self.stack.truncate(update);
        }
    }

    /// Solves K x = b in place; `x` has `size` numbers per node, those of inactive nodes are left alone.
    ///
    /// # Panics
    /// If `x` is shorter than that.
    pub fn solve(&self, x: &mut [T], buffers: &mut SolveBuffers<T>) {
        let d = self.symbolic.size;
        let Self { symbolic, fronts, nodes, factors, swaps, .. } = self;
        let SolveBuffers { x: work, head } = buffers;
        work.clear();
        symbolic.order.iter().for_each(|&node| work.extend_from_slice(&x[node * d..(node + 1) * d]));
        for front in fronts.iter() {
            let (p, n) = (front.pivots, front.rows);
            gather(head, work, &nodes[front.nodes.clone()][..p / d], d);
            for k in 0..p {
                head.swap(k, swaps[front.swaps + k]);
            }
            let lower = &factors[front.factors..front.factors + n * p];
            for k in 0..p {
                let column = &lower[k * n..(k + 1) * n];
                let value = head[k];
                head[k + 1..].iter_mut().zip(&column[k + 1..p]).for_each(|(x, &l)| *x -= l * value);
                for (l, &node) in column[p..].chunks_exact(d).zip(&nodes[front.nodes.clone()][p / d..]) {
                    work[node * d..(node + 1) * d].iter_mut().zip(l).for_each(|(x, &l)| *x -= l * value);
                }
            }
            scatter(head, work, &nodes[front.nodes.clone()][..p / d], d);
        }
        for front in fronts.iter().rev() {
            let (p, n) = (front.pivots, front.rows);
            if p == 0 {
                continue;
            }
            gather(head, work, &nodes[front.nodes.clone()][..p / d], d);
            let upper = &factors[front.factors + n * p..][..p * (n - p)];
            for (columns, &node) in upper.chunks_exact(p * d).zip(&nodes[front.nodes.clone()][p / d..]) {
                for (column, &value) in columns.chunks_exact(p).zip(&work[node * d..(node + 1) * d]) {
                    head.iter_mut().zip(column).for_each(|(x, &u)| *x -= u * value);
                }
            }
            let square = &factors[front.factors..front.factors + n * p];
            for k in (0..p).rev() {
                let column = &square[k * n..k * n + k + 1];
                let value = head[k] / column[k];
                head[k] = value;
                head[..k].iter_mut().zip(column).for_each(|(x, &u)| *x -= u * value);
            }
            scatter(head, work, &nodes[front.nodes.clone()][..p / d], d);
        }
        for (&node, solved) in symbolic.order.iter().zip(work.chunks_exact(d)) {
            x[node * d..(node + 1) * d].copy_from_slice(solved);
        }
    }
}

fn gather<T: Scalar>(head: &mut Vec<T>, work: &[T], nodes: &[usize], d: usize) {
    head.clear();
    nodes.iter().for_each(|&k| head.extend_from_slice(&work[k * d..(k + 1) * d]));
}

fn scatter<T: Scalar>(head: &[T], work: &mut [T], nodes: &[usize], d: usize) {
    for (&k, x) in nodes.iter().zip(head.chunks_exact(d)) {
        work[k * d..(k + 1) * d].copy_from_slice(x);
    }
}
