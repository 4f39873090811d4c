//! The joints of bodies in space: rows that are held, sprung or driven, and the torques of bodies that turn in them.
//!
//! Bodies in joints take no [flights](crate::system::Dynamics::fly): their step is (52) along q ⊕ s with the gyroscopic torque
//! of its mean spin,
//!
//! ```text
//!   J (ω₁ − ω₀) + h ω_θ × J ω_θ = h τ + Hᵀp + Ḡᵀλ,     R₁ = R₀ cay(h ω_θ)
//! ```
//!
//! whose work ω_θ·(ω_θ × J ω_θ) is zero, so that the balance (56) closes with the terms it has, for any θ; with θ = ½ free motion
//! is that of the flight, and keeps the angular momentum as well.

use nalgebra::{Vector1, Vector3};

use super::coordinate::{Relation, Way};
use super::flight::is_isotropic;
use super::shape::DOFS;
use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::system::element::{Acts, Element};
use crate::system::{Joints, RowLaw};

/// Two bodies, and their ways over a step.
struct Pair<T: Scalar> {
    bodies: [Option<usize>; 2],
    ways: [Way<T>; 2],
}

/// The rows of all joints, one after another.
#[derive(Debug)]
pub(super) struct JointSet<T: Scalar> {
    elements: Vec<Element<T, Relation<T>>>,
    /// Whether each body is in a joint.
    joined: Vec<bool>,
    /// Bodies in joints whose moments of inertia differ.
    turning: Vec<(usize, Vector3<T>)>,
}

impl<T: Scalar> JointSet<T> {
    pub(super) fn new(elements: Vec<Element<T, Relation<T>>>, moments: &[[T; 3]]) -> Self {
        let mut joined = vec![false; moments.len()];
        let bodies = elements.iter().flat_map(|element| element.measure.sides).filter_map(|side| side.body);
        bodies.for_each(|body| joined[body] = true);
        let of = |(body, moments): (usize, &[T; 3])| (body, Vector3::from(*moments));
        let all = moments.iter().enumerate().map(of);
        let turning = all.filter(|(body, moments)| joined[*body] && !is_isotropic(moments)).collect();
        Self { elements, joined, turning }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Whether a body is in a joint.
    pub(super) fn joins(&self, body: usize) -> bool {
        self.joined[body]
    }

    /// Calls `row` with every coordinate and the ways of its bodies, which rows of one joint share.
    fn for_each(
        &self,
        way: impl Fn(Option<usize>) -> Way<T>,
        mut row: impl FnMut(usize, &Relation<T>, [&Way<T>; 2]),
    ) {
        let mut last: Option<Pair<T>> = None;
        for (i, element) in self.elements.iter().enumerate() {
            let bodies = element.measure.sides.map(|side| side.body);
            let Pair { ways: [a, b], .. } = match last.take().filter(|pair| pair.bodies == bodies) {
                Some(same) => last.insert(same),
                None => last.insert(Pair { bodies, ways: bodies.map(&way) }),
            };
            row(i, &element.measure, [a, b]);
        }
    }
}

impl<T: Scalar> Joints<T> for JointSet<T> {
    fn rows(&self) -> usize {
        self.elements.len()
    }

    fn residual(&self, q: &[T], out: &mut [T]) {
        out.iter_mut().zip(&self.elements).for_each(|(out, element)| *out = element.residual(q));
    }

    fn jacobian(&self, q: &[T], s: &[T], out: &mut BlockRows<T, 1>) {
        self.for_each(
            |body| Way::along(body, q, s),
            |_, relation, ways| {
                out.start_row();
                relation.between(ways, |dof, entry| out.push(dof, Vector1::new(entry)));
            },
        );
    }

    fn tangent(&self, q: &[T], s: &[T], (end, _): (&[T], &[T]), out: &mut BlockRows<T, 1>) {
        self.for_each(
            |body| Way::at_end(body, q, s, end),
            |_, relation, ways| {
                out.start_row();
                relation.between(ways, |dof, entry| out.push(dof, Vector1::new(entry)));
            },
        );
    }

    fn curvature(&self, q: &[T], s: &[T], multipliers: &[T], out: &mut [T]) {
        self.for_each(
            |body| Way::along(body, q, s),
            |row, relation, ways| relation.curvature(ways, multipliers[row], out),
        );
    }

    fn inertial(&self, s: &[T], step: T, out: &mut [T]) {
        for (body, moments) in &self.turning {
            let i = DOFS * body + 3;
            let turn = Vector3::new(s[i], s[i + 1], s[i + 2]);
            let torque = moments.component_mul(&turn).cross(&turn) / step;
            (0..3).for_each(|k| out[i + k] += torque[k]);
        }
    }

    fn law(&self, row: usize, q: &[T], time: T, step: T) -> RowLaw<T> {
        self.elements[row].law(q, time, step)
    }

    fn all_held(&self) -> bool {
        self.elements.iter().all(|element| matches!(element.acts, Acts::Holds { .. }))
    }

    fn energy(&self, q: &[T]) -> T {
        self.elements.iter().fold(T::zero(), |sum, element| sum + element.energy(q))
    }

    fn label(&self, row: usize) -> String {
        self.elements[row].label.clone()
    }
}
