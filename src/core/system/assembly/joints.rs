//! The joints of the members, one after another.

use super::{Assembly, Member};
use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::system::{Joints, RowLaw};

impl<T: Scalar, const D: usize> Joints<T> for Assembly<T, D> {
    fn rows(&self) -> usize {
        self.joint_rows
    }

    fn moves(&self) -> bool {
        self.members.iter().any(|member| member.system.joints().is_some_and(Joints::moves))
    }

    fn residual(&self, q: &[T], out: &mut [T]) {
        for Member { system, q: place, joint_rows, .. } in &self.members {
            if let Some(joints) = system.joints() {
                joints.residual(&q[place.clone()], &mut out[joint_rows.clone()]);
            }
        }
    }

    fn jacobian(&self, q: &[T], s: &[T], out: &mut BlockRows<T, 1>) {
        for Member { system, q: place, v, .. } in &self.members {
            let Some(joints) = system.joints() else { continue };
            let first = out.rows();
            joints.jacobian(&q[place.clone()], &s[v.clone()], out);
            (first..out.rows()).for_each(|row| out.shift_row(row, v.start));
        }
    }

    fn tangent(&self, q: &[T], s: &[T], (end, still): (&[T], &[T]), out: &mut BlockRows<T, 1>) {
        for Member { system, q: place, v, .. } in &self.members {
            let Some(joints) = system.joints() else { continue };
            let first = out.rows();
            let end = (&end[place.clone()], &still[v.clone()]);
            joints.tangent(&q[place.clone()], &s[v.clone()], end, out);
            (first..out.rows()).for_each(|row| out.shift_row(row, v.start));
        }
    }

    fn inertial(&self, s: &[T], step: T, out: &mut [T]) {
        for Member { system, v, .. } in &self.members {
            if let Some(joints) = system.joints() {
                joints.inertial(&s[v.clone()], step, &mut out[v.clone()]);
            }
        }
    }

    fn curvature(&self, q: &[T], s: &[T], multipliers: &[T], out: &mut [T]) {
        for Member { system, q: place, v, joint_rows, .. } in &self.members {
            let Some(joints) = system.joints() else { continue };
            let multipliers = &multipliers[joint_rows.clone()];
            joints.curvature(&q[place.clone()], &s[v.clone()], multipliers, &mut out[v.clone()]);
        }
    }

    fn law(&self, row: usize, q: &[T], time: T, step: T) -> RowLaw<T> {
        let found = self.at(row, |member| &member.joint_rows);
        let joints = found.and_then(|(member, row)| Some((member, member.system.joints()?, row)));
        joints.map_or(RowLaw::Held, |(member, joints, row)| joints.law(row, &q[member.q.clone()], time, step))
    }

    fn all_held(&self) -> bool {
        self.members.iter().all(|member| member.system.joints().is_none_or(Joints::all_held))
    }

    fn energy(&self, q: &[T]) -> T {
        let of = |m: &Member<T, D>| m.system.joints().map(|joints| joints.energy(&q[m.q.clone()]));
        self.members.iter().filter_map(of).fold(T::zero(), |sum, energy| sum + energy)
    }

    fn label(&self, row: usize) -> String {
        let found = self.at(row, |member| &member.joint_rows);
        let label = found.and_then(|(member, row)| Some((member, member.system.joints()?.label(row))));
        label.map_or_else(|| row.to_string(), |(member, label)| format!("{}.{label}", member.name))
    }
}
