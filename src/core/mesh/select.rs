//! Groups by name, and parts of the boundary by where they are and which way they face.

use std::collections::{BTreeSet, HashSet};

use super::{Element, Mesh, MeshError, Shape};

/// A side of the bounding box within this share of its extent is touched.
const ON_SIDE: f64 = 1e-6;

/// What a selector asks of an edge of the boundary, or of an end of a bar.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Condition {
    /// Anything.
    Boundary,
    /// The coordinate `axis` of every node is below (`sign` = 1) or above (−1) a value (m).
    Beyond { axis: usize, sign: f64, value: f64, or_on: bool },
    /// The coordinate is this value, but for rounding (m).
    On { axis: usize, value: f64 },
    /// The coordinate is the smallest of the body (`sign` = 1), or the largest (−1).
    Side { axis: usize, sign: f64 },
    /// The outward normal is nearer to this direction of an axis than to any other.
    Normal { axis: usize, sign: f64 },
}

impl Condition {
    /// Conditions that must all hold, joined by `and`; `None` where the text is no selector.
    fn parse(text: &str) -> Option<Vec<Self>> {
        text.split(" and ").map(|part| Self::parse_one(part.trim())).collect()
    }

    fn parse_one(text: &str) -> Option<Self> {
        match text {
            "boundary" => return Some(Self::Boundary),
            "left" => return Some(Self::Side { axis: 0, sign: 1.0 }),
            "right" => return Some(Self::Side { axis: 0, sign: -1.0 }),
            "bottom" => return Some(Self::Side { axis: 1, sign: 1.0 }),
            "top" => return Some(Self::Side { axis: 1, sign: -1.0 }),
            _ => {}
        }
        let axis = |name: &str| ["x", "y"].iter().position(|axis| *axis == name);
        if let Some(direction) = text.strip_prefix("normal ") {
            let direction = direction.trim();
            let (sign, name) = match direction.strip_prefix('-') {
                Some(name) => (-1.0, name),
                None => (1.0, direction.strip_prefix('+').unwrap_or(direction)),
            };
            return Some(Self::Normal { axis: axis(name.trim())?, sign });
        }
        let at = text.find(['<', '>', '='])?;
        let (name, rest) = text.split_at(at);
        let axis = axis(name.trim())?;
        let (operator, rest) = rest.split_at(1);
        let (or_on, rest) = rest.strip_prefix('=').map_or((false, rest), |rest| (true, rest));
        let value = rest.trim().parse::<f64>().ok().filter(|value| value.is_finite())?;
        Some(match operator {
            "<" => Self::Beyond { axis, sign: 1.0, value, or_on },
            ">" => Self::Beyond { axis, sign: -1.0, value, or_on },
            _ => Self::On { axis, value },
        })
    }

    /// Whether an edge with these nodes and this outward normal is meant, in a body between two corners.
    fn holds(self, nodes: &[[f64; 2]], normal: [f64; 2], [low, high]: [[f64; 2]; 2]) -> bool {
        let near = |axis: usize, value: f64| {
            let extent = (high[0] - low[0]).max(high[1] - low[1]);
            move |at: &[f64; 2]| (at[axis] - value).abs() <= ON_SIDE * extent
        };
        match self {
            Self::Boundary => true,
            Self::Beyond { axis, sign, value, or_on } => nodes.iter().all(|at| {
                let inside = sign * (value - at[axis]);
                inside > 0.0 || (or_on && inside == 0.0)
            }),
            Self::On { axis, value } => nodes.iter().all(near(axis, value)),
            Self::Side { axis, sign } => {
                nodes.iter().all(near(axis, if sign > 0.0 { low[axis] } else { high[axis] }))
            }
            Self::Normal { axis, sign } => sign * normal[axis] > normal[1 - axis].abs(),
        }
    }
}

impl Mesh {
    /// Names of the groups.
    pub fn group_names(&self) -> impl Iterator<Item = &str> {
        self.groups.keys().map(String::as_str)
    }

    /// Whether a name is that of a group, or a selector.
    pub fn knows_group(&self, name: &str) -> bool {
        self.groups.contains_key(name) || Condition::parse(name).is_some()
    }

    /// Gives groups, or what selectors select, new names: each (old, new) pair.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], [`MeshError::EmptyGroup`], [`MeshError::GroupExists`].
    pub fn rename_groups<'a>(
        &mut self,
        names: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<(), MeshError> {
        for (old, new) in names {
            if old != new && self.groups.contains_key(new) {
                return Err(MeshError::GroupExists { name: new.into(), old: old.into() });
            }
            let members = match self.groups.remove(old) {
                Some(members) => members,
                None => {
                    let selected = self.group(old)?;
                    let first = self.elements.len();
                    self.elements.extend(selected);
                    (first..self.elements.len()).collect()
                }
            };
            self.groups.insert(new.to_string(), members);
        }
        Ok(())
    }

    /// The elements of a group, or the edges of the boundary (ends of a bar) that a selector selects; their tags are
    /// those of the elements they bound.
    fn group(&self, name: &str) -> Result<Vec<Element>, MeshError> {
        let members: Vec<Element> = match (self.groups.get(name), Condition::parse(name)) {
            (Some(members), _) => members.iter().map(|&index| self.elements[index]).collect(),
            (None, Some(conditions)) => self.select(&conditions),
            (None, None) => {
                const SHOWN: usize = 20;
                let mut known = self.group_names().take(SHOWN).collect::<Vec<_>>().join(", ");
                if self.groups.len() > SHOWN {
                    known += &format!(" and {} more", self.groups.len() - SHOWN);
                }
                return Err(MeshError::UnknownGroup { name: name.into(), known });
            }
        };
        if members.is_empty() {
            let [[x0, y0], [x1, y1]] = self.corners();
            return Err(MeshError::EmptyGroup { name: name.into(), x0, y0, x1, y1 });
        }
        Ok(members)
    }

    fn select(&self, conditions: &[Condition]) -> Vec<Element> {
        let corners = self.corners();
        let at = |node: usize| self.nodes[node].position;
        let mut selected = Vec::new();
        let edges = self.directed_edges();
        if self.dimension == 1 {
            let (starts, ends): (HashSet<usize>, HashSet<usize>) =
                edges.iter().map(|&([a, b], _)| (a, b)).unzip();
            for ([a, b], element) in edges {
                for (node, outward, is_end) in [(a, -1.0, !ends.contains(&a)), (b, 1.0, !starts.contains(&b))]
                {
                    let holds = |c: &Condition| c.holds(&[at(node)], [outward, 0.0], corners);
                    if is_end && conditions.iter().all(holds) {
                        selected
                            .push(Element { tag: self.elements[element].tag, shape: Shape::Point([node]) });
                    }
                }
            }
            return selected;
        }
        let all: HashSet<[usize; 2]> = edges.iter().map(|&(edge, _)| edge).collect();
        for ([a, b], element) in edges {
            let ([ax, ay], [bx, by]) = (at(a), at(b));
            let holds = |c: &Condition| c.holds(&[at(a), at(b)], [by - ay, ax - bx], corners);
            if !all.contains(&[b, a]) && conditions.iter().all(holds) {
                selected.push(Element { tag: self.elements[element].tag, shape: Shape::Segment([a, b]) });
            }
        }
        selected
    }

    /// The nodes of a group or a selector, ascending.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], [`MeshError::EmptyGroup`].
    pub fn group_nodes(&self, name: &str) -> Result<Vec<usize>, MeshError> {
        let members = self.group(name)?;
        let nodes = members.iter().flat_map(|element| element.shape.nodes());
        Ok(nodes.copied().collect::<BTreeSet<_>>().into_iter().collect())
    }

    /// The elements of dimension `wanted` of a group or a selector: a curve that has a name in common with its end
    /// points is meant without them.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], [`MeshError::EmptyGroup`]; [`MeshError::GroupDimension`] where there is none of them.
    pub fn group_elements(&self, name: &str, wanted: usize) -> Result<Vec<Element>, MeshError> {
        let mut members = self.group(name)?;
        let other = members.iter().find(|element| element.shape.dimension() != wanted).copied();
        members.retain(|element| element.shape.dimension() == wanted);
        match other {
            Some(Element { tag, shape }) if members.is_empty() => Err(MeshError::GroupDimension {
                name: name.into(),
                element: tag,
                given: shape.dimension(),
                wanted,
            }),
            _ => Ok(members),
        }
    }
}
