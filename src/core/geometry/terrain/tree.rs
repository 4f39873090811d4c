//! A balanced tree of boxes that stand still.

use nalgebra::Vector3;

use crate::geometry::bounds::Bounds;
use crate::scalar::Scalar;

/// Boxes in a leaf.
const LEAF: usize = 4;

#[derive(Debug, Clone, PartialEq)]
struct Node<T: Scalar> {
    bounds: Bounds<T>,
    from: u32,
    to: u32,
    /// The first of two children, 0 for a leaf.
    first: u32,
}

/// The boxes, split at medians along the widest axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree<T: Scalar> {
    order: Vec<u32>,
    boxes: Vec<Bounds<T>>,
    nodes: Vec<Node<T>>,
}

impl<T: Scalar> Tree<T> {
    /// Of boxes that are finite.
    pub(super) fn new(boxes: &[Bounds<T>]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let centre = |i: u32| -> Vector3<T> { boxes[i as usize].low + boxes[i as usize].high };
        let all = |range: &[u32]| range.iter().map(|&i| boxes[i as usize]).reduce(|a, b| a.union(&b));
        let mut nodes = Vec::new();
        if let Some(bounds) = all(&order) {
            nodes.push(Node { bounds, from: 0, to: order.len() as u32, first: 0 });
        }
        let mut at = 0;
        while at < nodes.len() {
            let (from, to) = (nodes[at].from, nodes[at].to);
            let range = &mut order[from as usize..to as usize];
            if range.len() > LEAF {
                let (mut low, mut high) = (centre(range[0]), centre(range[0]));
                for &i in &*range {
                    (low, high) = (low.inf(&centre(i)), high.sup(&centre(i)));
                }
                let axis = (high - low).imax();
                let middle = range.len() / 2;
                range.select_nth_unstable_by(middle, |&i, &j| {
                    let (x, y) = (centre(i)[axis], centre(j)[axis]);
                    x.partial_cmp(&y).unwrap_or(std::cmp::Ordering::Equal).then(i.cmp(&j))
                });
                let split = from + middle as u32;
                nodes[at].first = nodes.len() as u32;
                for (from, to) in [(from, split), (split, to)] {
                    if let Some(bounds) = all(&order[from as usize..to as usize]) {
                        nodes.push(Node { bounds, from, to, first: 0 });
                    }
                }
            }
            at += 1;
        }
        Self { order, boxes: boxes.to_vec(), nodes }
    }

    /// Appends the boxes that meet `within`.
    pub(super) fn find(&self, within: &Bounds<T>, stack: &mut Vec<u32>, out: &mut Vec<u32>) {
        stack.clear();
        stack.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(at) = stack.pop() {
            let Node { bounds, from, to, first } = &self.nodes[at as usize];
            if !bounds.meets(within) {
                continue;
            }
            if *first == 0 {
                let leaf = self.order[*from as usize..*to as usize].iter().copied();
                out.extend(leaf.filter(|&i| self.boxes[i as usize].meets(within)));
            } else {
                stack.extend([*first, *first + 1]);
            }
        }
    }
}
