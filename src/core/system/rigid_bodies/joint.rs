//! Joints between planar bodies: pins and welds, and the rows of sliders, springs, motors and friction.
//!
//! A pin holds a point of one body on a point of another, φ(q) = x_a + R(γ_a) ā − x_b − R(γ_b) b̄ = 0; a weld holds
//! the relative angle as well. Its rows Ḡ are the discrete derivative of φ: over a step s, as
//! R(γ + Δ) − R(γ) = (sin(Δ/2)/(Δ/2)) R′(γ + Δ/2) Δ exactly,
//!
//! ```text
//!   φ(q + s) − φ(q) = Ḡ(q, s) s,     Ḡ with the lever arms (sin(Δ/2)/(Δ/2)) R(γ + Δ/2) ā
//! ```
//!
//! so that Ḡ v_{k+θ} = 0 keeps φ where it was to rounding, and does no work at that.

use nalgebra::{SVector, Vector1, Vector2};

use super::measure::Measure;
use super::side::Side;
use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::system::element::{Acts, Coordinate, Element};
use crate::system::{Joints, RowLaw};

/// A joint of the scene.
#[derive(Debug, Clone)]
pub(super) struct Joint<T> {
    pub(super) label: String,
    pub(super) a: Side<T>,
    /// A body, or a fixed point.
    pub(super) b: Side<T>,
    /// γ_a − γ_b of a weld.
    pub(super) angle: Option<T>,
}

impl<T: Scalar> Joint<T> {
    /// Scalar rows of the joint.
    pub(super) fn rows(&self) -> usize {
        if self.angle.is_some() { 3 } else { 2 }
    }

    /// φ(q), m and rad.
    pub(super) fn residual(&self, q: &[T], out: &mut [T]) {
        let gap = self.a.position(q) - self.b.position(q);
        out[..2].copy_from_slice(gap.as_slice());
        if let Some(angle) = self.angle {
            out[2] = self.a.angle(q) - self.b.angle(q) - angle;
        }
    }

    /// Adds ∂(Ḡ(q, s)ᵀλ)_i/∂s_i to `out`: only a turn changes a lever arm, and only the one of its own body.
    pub(super) fn curvature(&self, q: &[T], s: &[T], multipliers: &[T], out: &mut [T]) {
        for (side, sign) in [(&self.a, T::one()), (&self.b, -T::one())] {
            let Some(body) = side.body else { continue };
            let i = 3 * body + 2;
            let rate = side.mean_arm_rate(q[i], s[i]);
            out[i] += sign * (multipliers[1] * rate.x - multipliers[0] * rate.y);
        }
    }

    /// Appends the rows Ḡ(q, s).
    pub(super) fn jacobian(&self, q: &[T], s: &[T], out: &mut BlockRows<T, 1>) {
        let sides = [(&self.a, T::one()), (&self.b, -T::one())];
        let one = |x: T| -> SVector<T, 1> { Vector1::new(x) };
        for axis in 0..2 {
            out.start_row();
            for (side, sign) in sides {
                let Some(body) = side.body else { continue };
                let i = 3 * body;
                let arm = side.mean_arm(q[i + 2], s[i + 2]);
                out.push(i + axis, one(sign));
                out.push(i + 2, one(sign * if axis == 0 { -arm.y } else { arm.x }));
            }
        }
        if self.angle.is_some() {
            out.start_row();
            for (side, sign) in sides {
                if let Some(body) = side.body {
                    out.push(3 * body + 2, one(sign));
                }
            }
        }
    }
}

/// The joints of a scene, their rows one after another: pins and welds, then elements.
#[derive(Debug)]
pub(super) struct JointSet<T> {
    joints: Vec<Joint<T>>,
    elements: Vec<Element<T, Measure<T>>>,
    /// Rows of pins and welds.
    pinned: usize,
}

impl<T: Scalar> JointSet<T> {
    pub(super) fn new(joints: Vec<Joint<T>>, elements: Vec<Element<T, Measure<T>>>) -> Self {
        let pinned = joints.iter().map(Joint::rows).sum();
        Self { joints, elements, pinned }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.joints.is_empty() && self.elements.is_empty()
    }

    /// The points that pins and welds hold: name of the joint, body, and point in its frame.
    pub(super) fn held_points(&self) -> impl Iterator<Item = (&str, usize, Vector2<T>)> {
        let of = |joint| {
            let Joint { label, a, b, .. }: &Joint<T> = joint;
            [a, b].into_iter().filter_map(|side| Some((label.as_str(), side.body?, side.point)))
        };
        self.joints.iter().flat_map(of)
    }

    /// The pins and welds with their rows.
    fn with_rows(&self) -> impl Iterator<Item = (&Joint<T>, std::ops::Range<usize>)> {
        self.joints.iter().scan(0, |first, joint| {
            let rows = *first..*first + joint.rows();
            *first = rows.end;
            Some((joint, rows))
        })
    }

    fn element(&self, row: usize) -> Option<&Element<T, Measure<T>>> {
        row.checked_sub(self.pinned).and_then(|i| self.elements.get(i))
    }
}

impl<T: Scalar> Joints<T> for JointSet<T> {
    fn rows(&self) -> usize {
        self.pinned + self.elements.len()
    }

    fn moves(&self) -> bool {
        !self.elements.is_empty()
            || self.joints.iter().any(|joint| joint.angle.is_none() || joint.b.body.is_some())
    }

    fn residual(&self, q: &[T], out: &mut [T]) {
        self.with_rows().for_each(|(joint, rows)| joint.residual(q, &mut out[rows]));
        let of_elements = out[self.pinned..].iter_mut().zip(&self.elements);
        of_elements.for_each(|(out, element)| *out = element.residual(q));
    }

    fn jacobian(&self, q: &[T], s: &[T], out: &mut BlockRows<T, 1>) {
        self.joints.iter().for_each(|joint| joint.jacobian(q, s, out));
        for element in &self.elements {
            out.start_row();
            element.measure.row(q, s, |dof, entry| out.push(dof, Vector1::new(entry)));
        }
    }

    fn curvature(&self, q: &[T], s: &[T], multipliers: &[T], out: &mut [T]) {
        self.with_rows().for_each(|(joint, rows)| joint.curvature(q, s, &multipliers[rows], out));
    }

    fn law(&self, row: usize, q: &[T], time: T, step: T) -> RowLaw<T> {
        self.element(row).map_or(RowLaw::Held, |element| element.law(q, time, step))
    }

    fn all_held(&self) -> bool {
        self.elements.iter().all(|element| matches!(element.acts, Acts::Holds { .. }))
    }

    fn energy(&self, q: &[T]) -> T {
        self.elements.iter().fold(T::zero(), |sum, element| sum + element.energy(q))
    }

    fn label(&self, row: usize) -> String {
        if let Some(element) = self.element(row) {
            return element.label.clone();
        }
        let found = self.with_rows().find(|(_, rows)| rows.contains(&row));
        found.map_or_else(|| row.to_string(), |(joint, _)| joint.label.clone())
    }
}
