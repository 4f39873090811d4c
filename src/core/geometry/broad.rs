//! Which pairs of boxes overlap: a balanced tree over their centres.
//!
//! The tree is split at medians along the widest axis, so that its depth is log₂ N whatever the scene; a call costs
//! N log N and the pairs found. The order of the boxes is kept, so that the next call finds them nearly sorted.

use nalgebra::Vector3;

use super::bounds::Bounds;
use super::real::infinity;
use crate::scalar::Scalar;

/// Boxes in a leaf of the tree.
const LEAF: usize = 4;

/// Finds the pairs of boxes that overlap; keeps its memory, so that warm calls allocate nothing.
#[derive(Debug, Clone)]
pub struct BroadPhase<T: Scalar> {
    order: Vec<u32>,
    /// Boxes without bounds, halves of space: these meet everybody.
    unbounded: Vec<u32>,
    /// Twice the centres, by box.
    centres: Vec<Vector3<T>>,
    nodes: Vec<Node<T>>,
    stack: Vec<(u32, u32)>,
}

/// A node holds the boxes `order[from..to]`; its children are `first` and `first + 1`, none for 0.
#[derive(Debug, Clone, Copy)]
struct Node<T: Scalar> {
    bounds: Bounds<T>,
    from: u32,
    to: u32,
    first: u32,
}

impl<T: Scalar> Default for BroadPhase<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Scalar> BroadPhase<T> {
    /// A broad phase without memory.
    pub fn new() -> Self {
        Self {
            order: Vec::new(),
            unbounded: Vec::new(),
            centres: Vec::new(),
            nodes: Vec::new(),
            stack: Vec::new(),
        }
    }

    /// Appends all (i, j), i < j, of boxes that overlap and that are `wanted` to `out`, sorted.
    ///
    /// Boxes with NaN meet everybody as boxes without bounds do: whoever looks closer finds out.
    pub fn pairs(
        &mut self,
        boxes: &[Bounds<T>],
        mut wanted: impl FnMut(usize, usize) -> bool,
        out: &mut Vec<(usize, usize)>,
    ) {
        let start = out.len();
        self.build(boxes);
        let mut emit = |i: u32, j: u32| {
            let (i, j) = (i.min(j) as usize, i.max(j) as usize);
            if wanted(i, j) {
                out.push((i, j));
            }
        };
        for (place, &i) in self.unbounded.iter().enumerate() {
            self.order.iter().for_each(|&j| emit(i, j));
            self.unbounded[..place].iter().for_each(|&j| emit(i, j));
        }
        if !self.nodes.is_empty() {
            self.traverse(boxes, &mut emit);
        }
        out[start..].sort_unstable();
    }

    fn build(&mut self, boxes: &[Bounds<T>]) {
        let same = self.order.len() + self.unbounded.len() == boxes.len();
        let kept = same
            && self.order.iter().all(|&i| boxes[i as usize].is_finite())
            && self.unbounded.iter().all(|&i| !boxes[i as usize].is_finite());
        if !kept {
            self.order.clear();
            self.unbounded.clear();
            for (i, bounds) in (0..).zip(boxes) {
                if bounds.is_finite() { self.order.push(i) } else { self.unbounded.push(i) }
            }
        }
        self.centres.clear();
        self.centres.extend(boxes.iter().map(|b| b.low + b.high));
        self.nodes.clear();
        if self.order.is_empty() {
            return;
        }
        let none = Bounds { low: Vector3::repeat(infinity::<T>()), high: Vector3::repeat(-infinity::<T>()) };
        self.nodes.push(Node { bounds: none, from: 0, to: self.order.len() as u32, first: 0 });
        let mut at = 0;
        while at < self.nodes.len() {
            let Node { from, to, .. } = self.nodes[at];
            let range = &mut self.order[from as usize..to as usize];
            if range.len() > LEAF {
                let centres = &self.centres;
                let (low, high) = range.iter().fold((none.low, none.high), |(low, high), &i| {
                    let c = &centres[i as usize];
                    (low.inf(c), high.sup(c))
                });
                let axis = (high - low).imax();
                let middle = range.len() / 2;
                range.select_nth_unstable_by(middle, |&i, &j| {
                    let (x, y) = (centres[i as usize][axis], centres[j as usize][axis]);
                    x.partial_cmp(&y).unwrap_or(std::cmp::Ordering::Equal).then(i.cmp(&j))
                });
                let split = from + middle as u32;
                self.nodes[at].first = self.nodes.len() as u32;
                self.nodes.push(Node { bounds: none, from, to: split, first: 0 });
                self.nodes.push(Node { bounds: none, from: split, to, first: 0 });
            }
            at += 1;
        }
        // Children stand after their parents.
        for at in (0..self.nodes.len()).rev() {
            let Node { from, to, first, .. } = self.nodes[at];
            self.nodes[at].bounds = if first == 0 {
                let leaf = &self.order[from as usize..to as usize];
                leaf.iter().fold(none, |sum, &i| sum.union(&boxes[i as usize]))
            } else {
                self.nodes[first as usize].bounds.union(&self.nodes[first as usize + 1].bounds)
            };
        }
    }

    /// Pairs within and between the nodes of the stack.
    fn traverse(&mut self, boxes: &[Bounds<T>], emit: &mut impl FnMut(u32, u32)) {
        let mut stack = std::mem::take(&mut self.stack);
        stack.push((0, 0));
        while let Some((a, b)) = stack.pop() {
            let (one, two) = (&self.nodes[a as usize], &self.nodes[b as usize]);
            if a == b {
                if one.first != 0 {
                    let first = one.first;
                    stack.extend([(first, first), (first + 1, first + 1), (first, first + 1)]);
                    continue;
                }
                let leaf = &self.order[one.from as usize..one.to as usize];
                for (place, &i) in leaf.iter().enumerate() {
                    for &j in &leaf[place + 1..] {
                        if boxes[i as usize].meets(&boxes[j as usize]) {
                            emit(i, j);
                        }
                    }
                }
                continue;
            }
            if !one.bounds.meets(&two.bounds) {
                continue;
            }
            // The node of more boxes is opened.
            if one.first == 0 && two.first == 0 {
                for &i in &self.order[one.from as usize..one.to as usize] {
                    for &j in &self.order[two.from as usize..two.to as usize] {
                        if boxes[i as usize].meets(&boxes[j as usize]) {
                            emit(i, j);
                        }
                    }
                }
            } else if two.first == 0 || (one.first != 0 && one.to - one.from >= two.to - two.from) {
                stack.extend([(one.first, b), (one.first + 1, b)]);
            } else {
                stack.extend([(a, two.first), (a, two.first + 1)]);
            }
        }
        self.stack = stack;
    }
}
