//! What makes a mesh sound: checks, and the repairs that change nothing of the body.

use std::collections::BTreeMap;

use super::{Element, Mesh, MeshError, MeshNote, Node, Shape};
use crate::linalg::forest::join;

impl Mesh {
    /// A mesh from its parts; the body is made of the triangles, or of the lines where there are none. Groups hold
    /// indices of elements. Clockwise triangles are turned, nodes that belong to no element of the body are left out
    /// with the elements of groups that they carry, and [`notes`](Self::notes) says so.
    ///
    /// # Errors
    /// [`MeshError`] naming the element, node or group at fault.
    pub fn new(
        nodes: Vec<Node>,
        elements: Vec<Element>,
        groups: BTreeMap<String, Vec<usize>>,
    ) -> Result<Self, MeshError> {
        let dimension = elements.iter().map(|element| element.shape.dimension()).max().unwrap_or(0);
        if dimension == 0 {
            return Err(MeshError::Empty);
        }
        let mut mesh = Self { dimension, nodes, elements, groups, notes: Vec::new() };
        mesh.check_indices()?;
        mesh.leave_out_nodes()?;
        mesh.check_coordinates()?;
        mesh.turn()?;
        mesh.check_overlaps()?;
        mesh.count_parts();
        Ok(mesh)
    }

    fn check_indices(&self) -> Result<(), MeshError> {
        for element in &self.elements {
            if let Some(&node) = element.shape.nodes().iter().find(|&&node| node >= self.nodes.len()) {
                return Err(MeshError::UnknownNode { element: element.tag, node: node as u64 });
            }
        }
        for (name, members) in &self.groups {
            if let Some(&index) = members.iter().find(|&&index| index >= self.elements.len()) {
                let message = format!("group `{name}` names element {index} of {}", self.elements.len());
                return Err(MeshError::Format { line: 0, message });
            }
        }
        Ok(())
    }

    /// Leaves out the nodes that no element of the body has, with the elements that need them.
    fn leave_out_nodes(&mut self) -> Result<(), MeshError> {
        let mut used = vec![false; self.nodes.len()];
        let body = self.elements.iter().filter(|element| element.shape.dimension() == self.dimension);
        body.flat_map(|element| element.shape.nodes()).for_each(|&node| used[node] = true);
        let Some(first) = used.iter().position(|&used| !used) else { return Ok(()) };
        let (Node { tag, position }, count) = (self.nodes[first], used.iter().filter(|used| !**used).count());
        self.notes.push(MeshNote::LeftOut { count, node: tag, position });
        let places = |kept: &[bool]| {
            let mut next = 0;
            let place = |&kept: &bool| {
                next += usize::from(kept);
                kept.then(|| next - 1)
            };
            kept.iter().map(place).collect::<Vec<Option<usize>>>()
        };
        let node_place = places(&used);
        let kept: Vec<bool> = (self.elements.iter())
            .map(|element| element.shape.nodes().iter().all(|&node| used[node]))
            .collect();
        let element_place = places(&kept);
        let moved = |node: usize| node_place[node].unwrap_or(node);
        let mut index = 0;
        self.elements.retain(|_| {
            index += 1;
            kept[index - 1]
        });
        for element in &mut self.elements {
            element.shape = match element.shape {
                Shape::Point(nodes) => Shape::Point(nodes.map(moved)),
                Shape::Segment(nodes) => Shape::Segment(nodes.map(moved)),
                Shape::Triangle(nodes) => Shape::Triangle(nodes.map(moved)),
            };
        }
        let mut index = 0;
        self.nodes.retain(|_| {
            index += 1;
            used[index - 1]
        });
        for members in self.groups.values_mut() {
            *members = members.iter().filter_map(|&member| element_place[member]).collect();
        }
        Ok(())
    }

    fn check_coordinates(&self) -> Result<(), MeshError> {
        for node in &self.nodes {
            for (axis, &value) in ['x', 'y'].into_iter().zip(&node.position) {
                let on_line = self.dimension == 2 || axis == 'x' || value == 0.0;
                let range = if on_line {
                    "finite"
                } else {
                    "0: a mesh without triangles is a bar, whose lines lie on the x axis"
                };
                if !value.is_finite() || !on_line {
                    return Err(MeshError::Coordinate { node: node.tag, axis, value, range });
                }
            }
        }
        Ok(())
    }

    /// Turns clockwise triangles, and refuses elements of the body without measure.
    fn turn(&mut self) -> Result<(), MeshError> {
        let extent = self.extent();
        // Below round-off of the coordinates a measure says nothing.
        let smallest = 1e-14 * extent[0].max(extent[1]).powi(self.dimension as i32);
        let (mut count, mut first) = (0, 0);
        for at in 0..self.elements.len() {
            let element = self.elements[at];
            if element.shape.dimension() != self.dimension {
                continue;
            }
            let value = self.measure(&element);
            if !(value.abs() > smallest) {
                let measure = if self.dimension == 2 { "area" } else { "length" };
                let nodes = self.tags_of(element.shape.nodes());
                return Err(MeshError::Degenerate { element: element.tag, nodes, measure, value });
            }
            if let (Shape::Triangle([a, b, c]), true) = (element.shape, value < 0.0) {
                self.elements[at].shape = Shape::Triangle([a, c, b]);
                first = if count == 0 { element.tag } else { first };
                count += 1;
            }
        }
        if count > 0 {
            self.notes.push(MeshNote::Turned { count, element: first });
        }
        Ok(())
    }

    fn tags_of(&self, nodes: &[usize]) -> Vec<u64> {
        nodes.iter().map(|&node| self.nodes[node].tag).collect()
    }

    /// Counter-clockwise neighbours run along their common edge in opposite directions.
    fn check_overlaps(&self) -> Result<(), MeshError> {
        let mut edges = self.directed_edges();
        edges.sort_unstable();
        for pair in edges.windows(2) {
            let ([edge, other], [first, second]) =
                ([pair[0].0, pair[1].0], [pair[0].1, pair[1].1].map(|i| self.elements[i]));
            if edge != other {
                continue;
            }
            let sorted = |element: &Element| {
                let mut nodes = element.shape.nodes().to_vec();
                nodes.sort_unstable();
                nodes
            };
            let ([first, second], same) = ([first, second], sorted(&first) == sorted(&second));
            let (nodes, edge) = (self.tags_of(first.shape.nodes()), edge.map(|node| self.nodes[node].tag));
            let (first, second) = (first.tag, second.tag);
            return Err(if same {
                MeshError::Doubled { first, second, nodes }
            } else {
                MeshError::Overlap { first, second, edge }
            });
        }
        Ok(())
    }

    /// Edges of the triangles in the order of their nodes, with the index of the triangle; of a bar its elements, from
    /// left to right.
    pub(super) fn directed_edges(&self) -> Vec<([usize; 2], usize)> {
        let mut edges = Vec::new();
        for (at, element) in self.elements.iter().enumerate() {
            match element.shape {
                Shape::Triangle([a, b, c]) => edges.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, at))),
                Shape::Segment([a, b]) if self.dimension == 1 => {
                    let runs_right = self.nodes[a].position[0] < self.nodes[b].position[0];
                    edges.push((if runs_right { [a, b] } else { [b, a] }, at));
                }
                _ => {}
            }
        }
        edges
    }

    fn count_parts(&mut self) {
        let mut parent: Vec<usize> = (0..self.nodes.len()).collect();
        let mut count = self.nodes.len();
        for element in self.elements.iter().filter(|element| element.shape.dimension() == self.dimension) {
            for pair in element.shape.nodes().windows(2) {
                count -= usize::from(join(&mut parent, pair[0], pair[1]));
            }
        }
        if count > 1 {
            self.notes.push(MeshNote::Parts { count });
        }
    }
}
