//! Symbolic analysis: fill-reducing order, elimination tree, supernodes.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::error::PatternError;

/// Up to this many scalar unknowns the matrix is one dense front.
const DENSE_LIMIT: usize = 48;
/// Fronts up to this many scalar rows are merged whatever zeros it costs.
const SMALL_FRONT: usize = 16;

/// Pivots eliminated together, in elimination positions.
#[derive(Debug, Clone)]
pub(super) struct Supernode {
    pub(super) pivots: Range<usize>,
    /// Range of `Symbolic::borders`: the later positions it touches, ascending.
    pub(super) border: Range<usize>,
    pub(super) children: usize,
}

/// The structure of the factors of a matrix of `size`×`size` blocks with symmetric pattern.
#[derive(Debug, Clone, Default)]
pub(super) struct Symbolic {
    pub(super) size: usize,
    starts: Vec<usize>,
    columns: Vec<usize>,
    /// Elimination position → node, and back.
    pub(super) order: Vec<usize>,
    pub(super) position: Vec<usize>,
    /// Entry (i, j) → entry (j, i).
    pub(super) mirror: Vec<usize>,
    /// In postorder: the children of a supernode directly precede it.
    pub(super) supernodes: Vec<Supernode>,
    pub(super) borders: Vec<usize>,
}

impl Symbolic {
    /// Whether this is the analysis of the pattern.
    pub(super) fn matches(&self, starts: &[usize], columns: &[usize], size: usize) -> bool {
        self.size == size && self.starts == starts && self.columns == columns
    }

    pub(super) fn row(&self, node: usize) -> Range<usize> {
        self.starts[node]..self.starts[node + 1]
    }

    pub(super) fn column(&self, entry: usize) -> usize {
        self.columns[entry]
    }

    /// Analyses a pattern in compressed rows, ascending in every row, structurally symmetric, with its diagonal.
    pub(super) fn new(starts: &[usize], columns: &[usize], size: usize) -> Result<Self, PatternError> {
        check(starts, columns)?;
        let n = starts.len() - 1;
        let mut symbolic = Self {
            size,
            starts: starts.to_vec(),
            columns: columns.to_vec(),
            mirror: mirror(starts, columns),
            ..Self::default()
        };
        let dense = n * size <= DENSE_LIMIT || columns.len() * 2 > n * n;
        if dense {
            symbolic.order = (0..n).collect();
            symbolic.position = (0..n).collect();
            if n > 0 {
                symbolic.supernodes.push(Supernode { pivots: 0..n, border: 0..0, children: 0 });
            }
            return Ok(symbolic);
        }
        symbolic.set_order(minimum_degree(starts, columns));
        let post = postorder(&symbolic.elimination_tree());
        let order = post.iter().map(|&k| symbolic.order[k]).collect();
        symbolic.set_order(order);
        symbolic.find_supernodes();
        Ok(symbolic)
    }

    fn set_order(&mut self, order: Vec<usize>) {
        self.position = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &node)| self.position[node] = k);
        self.order = order;
    }

    /// Neighbours of position `k`, as positions.
    fn neighbours(&self, k: usize) -> impl Iterator<Item = usize> {
        self.row(self.order[k]).map(|entry| self.position[self.columns[entry]])
    }

    /// Parent of every position (Liu 1986, with path compression); roots have themselves beyond the end.
    fn elimination_tree(&self) -> Vec<usize> {
        let n = self.order.len();
        let (mut parent, mut ancestor) = (vec![usize::MAX; n], vec![usize::MAX; n]);
        for k in 0..n {
            for mut j in self.neighbours(k).filter(|&j| j < k) {
                loop {
                    let up = std::mem::replace(&mut ancestor[j], k);
                    if up == k {
                        break;
                    }
                    if up == usize::MAX {
                        parent[j] = k;
                        break;
                    }
                    j = up;
                }
            }
        }
        parent
    }

    fn find_supernodes(&mut self) {
        let n = self.order.len();
        let mut structs: Vec<Vec<usize>> = vec![Vec::new(); n];
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); n];
        let mut marked = vec![usize::MAX; n];
        for k in 0..n {
            let mut rows: Vec<usize> = self.neighbours(k).filter(|&j| j > k).collect();
            rows.iter().for_each(|&j| marked[j] = k);
            for &child in &children[k] {
                for &j in structs[child].iter().filter(|&&j| j > k) {
                    if marked[j] != k {
                        marked[j] = k;
                        rows.push(j);
                    }
                }
            }
            rows.sort_unstable();
            if let Some(&parent) = rows.first() {
                children[parent].push(k);
            }
            structs[k] = rows;
        }
        // Relaxed supernodes: a chain child is merged into its parent while few explicit zeros come of it.
        let mut merged: Vec<(Range<usize>, usize)> = Vec::new();
        for k in 0..n {
            let (mut pivots, mut zeros) = (k..k + 1, 0);
            let border = structs[k].len();
            while let Some((child, child_zeros)) = merged.last() {
                let child_struct = &structs[child.end - 1];
                if child_struct.first().is_none_or(|&parent| parent >= pivots.end) {
                    break;
                }
                let added = child.len() * (pivots.len() + border - child_struct.len());
                let (count, rows) = (child.len() + pivots.len(), child.len() + pivots.len() + border);
                let total = zeros + child_zeros + added;
                if rows * self.size > SMALL_FRONT && 5 * total > count * rows {
                    break;
                }
                zeros = total;
                pivots.start = child.start;
                merged.pop();
            }
            merged.push((pivots, zeros));
        }
        let mut owner = vec![0; n];
        for (s, (pivots, _)) in merged.iter().enumerate() {
            owner[pivots.clone()].fill(s);
        }
        self.supernodes.clear();
        self.borders.clear();
        for (pivots, _) in merged {
            let start = self.borders.len();
            self.borders.extend_from_slice(&structs[pivots.end - 1]);
            self.supernodes.push(Supernode { pivots, border: start..self.borders.len(), children: 0 });
        }
        for s in 0..self.supernodes.len() {
            let border = self.supernodes[s].border.clone();
            if let Some(&first) = self.borders[border].first() {
                self.supernodes[owner[first]].children += 1;
            }
        }
    }
}

/// Checks that every row ascends, stays within the matrix and holds its diagonal, and that (j, i) is an entry where (i, j) is.
fn check(starts: &[usize], columns: &[usize]) -> Result<(), PatternError> {
    let ends = starts.first() == Some(&0) && starts.last() == Some(&columns.len());
    if !ends || !starts.is_sorted() {
        return Err(PatternError { row: 0 });
    }
    let n = starts.len() - 1;
    let row = |i: usize| &columns[starts[i]..starts[i + 1]];
    let sound = |i: usize| {
        row(i).is_sorted_by(|a, b| a < b)
            && row(i).last().is_some_and(|&last| last < n)
            && row(i).binary_search(&i).is_ok()
    };
    if let Some(row) = (0..n).find(|&i| !sound(i)) {
        return Err(PatternError { row });
    }
    match (0..n).find(|&i| row(i).iter().any(|&j| row(j).binary_search(&i).is_err())) {
        Some(row) => Err(PatternError { row }),
        None => Ok(()),
    }
}

fn mirror(starts: &[usize], columns: &[usize]) -> Vec<usize> {
    let n = starts.len() - 1;
    let mut next = starts[..n].to_vec();
    let mut mirror = vec![0; columns.len()];
    // Rows ascend, so that the entries (j, i) of row j are met in the order of i.
    for i in 0..n {
        for entry in starts[i]..starts[i + 1] {
            let j = columns[entry];
            mirror[entry] = next[j];
            next[j] += 1;
        }
    }
    mirror
}

/// Approximate minimum degree order; the given order where the ordering fails.
fn minimum_degree(starts: &[usize], columns: &[usize]) -> Vec<usize> {
    let n = starts.len() - 1;
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, starts, None, columns);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, columns.len()));
    let done =
        amd::order(&mut order, &mut inverse, pattern, amd::Control::default(), MemStack::new(&mut memory));
    if done.is_err() {
        order = (0..n).collect();
    }
    order
}

fn postorder(parent: &[usize]) -> Vec<usize> {
    let n = parent.len();
    // Children in linked lists, smallest last so that the stack pops them ascending.
    let (mut head, mut next) = (vec![usize::MAX; n + 1], vec![usize::MAX; n]);
    for k in (0..n).rev() {
        let p = parent[k].min(n);
        next[k] = head[p];
        head[p] = k;
    }
    let mut order = Vec::with_capacity(n);
    let mut stack = Vec::new();
    let mut root = head[n];
    while root != usize::MAX {
        stack.push(root);
        while let Some(&k) = stack.last() {
            if head[k] == usize::MAX {
                order.push(k);
                stack.pop();
            } else {
                stack.push(head[k]);
                head[k] = next[head[k]];
            }
        }
        root = next[root];
    }
    order
}
