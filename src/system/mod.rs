//! Mechanical systems: M v̇ + C v + K q = F(t) + Hᵀ(q) r with candidate contacts g(q).
//!
//! A system says what moves and what may touch. It knows no law, no scheme and no solver.

mod elastic;
mod forces;
mod lagrangian;
mod nonlinear;
mod prescribed;
mod rigid_bodies;
mod signal;

use std::fmt::Debug;
use std::sync::Arc;

pub use elastic::{
    Axis, ElasticBody, ElasticBodyBuilder, ElasticError, Geometry, Hypothesis, MassForm, Material,
    PreloadError, Support,
};
pub use forces::Forces;
pub use lagrangian::{Lagrangian, SmoothGap};
pub use nonlinear::{Dynamics, NonlinearLagrangian};
pub use prescribed::Prescribed;
pub use rigid_bodies::{Body, BodyId, ContactorId, GroupId, RigidBodies, RigidBodiesBuilder, polygon_body};
pub use signal::Signal;

use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, OperatorError, Symmetric};
use crate::scalar::Scalar;

/// A system with constant mass, damping and stiffness, and unilateral contacts of dimension D.
///
/// Sizes: q and v have [`dofs`](Self::dofs) components. Local frames are ordered (N, T1, T2) with the normal
/// pointing from the obstacle to the body, so that a closing contact has u_N < 0.
pub trait MechanicalSystem<T: Scalar, const D: usize>: Debug + Send {
    /// Number of degrees of freedom n.
    fn dofs(&self) -> usize;

    /// Mass M, positive definite.
    fn mass(&self) -> &Symmetric<T>;

    /// Damping C, positive semidefinite; an absent one costs nothing.
    fn damping(&self) -> Option<&Symmetric<T>> {
        None
    }

    /// Stiffness K, positive semidefinite; an absent one costs nothing.
    fn stiffness(&self) -> Option<&Symmetric<T>> {
        None
    }

    /// External forces F(t).
    fn forces(&self) -> &Forces<T>;

    /// Degrees of freedom that move as told, the last ones; an absent list costs nothing.
    fn prescribed(&self) -> Option<&Prescribed<T>> {
        None
    }

    /// Whether H^α(q) is the same for all q: the scheme then keeps the Delassus operator of all candidates, those
    /// of an infinite reach, and takes its active rows.
    fn constant_jacobian(&self) -> bool {
        false
    }

    /// Number of interfaces; the scheme wants one law for each.
    fn interfaces(&self) -> usize;

    /// Appends every candidate contact with gap g(q) ≤ `reach` to `out`, each once, in any order.
    ///
    /// `&mut self` lets a broad phase keep its order from one call to the next.
    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>);

    /// Degrees of freedom of a body, where the system is one of bodies, body i with those from i times this number on, that
    /// nothing but contacts couples. Bodies at rest then may leave the steps, see [`scheme`](crate::scheme).
    fn body_dofs(&self) -> Option<usize> {
        None
    }

    /// As [`candidates`](Self::candidates), without those between bodies that are `asleep`, or between such a body and
    /// obstacles. A system with [`body_dofs`](Self::body_dofs) overrides it: by default all are found, and wake everybody.
    fn awake_candidates(&mut self, q: &[T], reach: T, _asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        self.candidates(q, reach, out);
    }

    /// Finds the pairs that would pass through each other unseen on the path q + t h v, 0 ≤ t ≤ 1, with `path` = (h, v): each
    /// takes the place of the candidates of its pair in `out`, with the gap at the end of the path of the features that meet
    /// first, and the time t at which they meet is in `times`. Pairs of which both bodies are `asleep` are left out.
    ///
    /// By default nothing is ever crossed unseen, as where gaps keep their sign at any depth. It must cost next to nothing where
    /// nothing is fast.
    fn swept_candidates(
        &mut self,
        _q: &[T],
        _path: (T, &[T]),
        _asleep: &[bool],
        _out: &mut Vec<Candidate<T>>,
        _times: &mut Vec<(ContactId, T)>,
    ) {
    }

    /// Appends the block row H^α(q), of a candidate that [`candidates`](Self::candidates) named, to `out`.
    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>);

    /// Gap g^α(q) (m) of a candidate that [`candidates`](Self::candidates) named, of the same features, in any
    /// configuration near the one it was named in.
    fn gap(&self, contact: ContactId, q: &[T]) -> T;

    /// Number of bilateral rows φ(q) = 0 of the joints, 0 for a system without joints.
    ///
    /// A joint is a contact whose half-line has become the whole line: in the cone problem its percussion is free
    /// (K = ℝ), so that the dual cone is K* = {0} and the row reads u = 0. The scheme eliminates such rows exactly,
    /// see [`scheme`](crate::scheme).
    fn joint_rows(&self) -> usize {
        0
    }

    /// Whether bodies move along joints; those welded to the ground alone do not.
    fn joints_move(&self) -> bool {
        self.joint_rows() > 0
    }

    /// out ← φ(q), one number per bilateral row.
    fn joint_residual(&self, _q: &[T], _out: &mut [T]) {}

    /// Appends the rows Ḡ(q, s), with φ(q + s) − φ(q) = Ḡ(q, s) s.
    fn joint_jacobian(&self, _q: &[T], _s: &[T], _out: &mut BlockRows<T, 1>) {}

    /// Adds ∂(Ḡ(q, s)ᵀλ)_i/∂s_i to out_i, for one multiplier λ per row.
    ///
    /// It speeds up the iteration of a step with joints, whose solution does not depend on it: Newton's method with it,
    /// a linear rate of the order of h²λ without.
    fn joint_curvature(&self, _q: &[T], _s: &[T], _multipliers: &[T], _out: &mut [T]) {}

    /// Name of the joint a bilateral row belongs to.
    fn joint_label(&self, row: usize) -> String {
        row.to_string()
    }

    /// The terms of a nonlinear system, `None` where M, C and K say all.
    fn nonlinear(&self) -> Option<&dyn Dynamics<T>> {
        None
    }

    /// Size and speed that make the tolerances of the active set scale-free.
    fn scales(&self, q: &[T], v: &[T]) -> Scales<T>;

    /// Mesh and numbering of an elastic body, for outputs.
    fn geometry(&self) -> Option<&Arc<Geometry<T>>> {
        None
    }

    /// Node of the mesh that a contact belongs to, for outputs.
    fn contact_node(&self, _contact: ContactId) -> Option<usize> {
        None
    }

    /// Name of a contact in outputs.
    fn contact_label(&self, contact: ContactId) -> String {
        contact.0.to_string()
    }

    /// Name of a degree of freedom in outputs.
    fn dof_label(&self, dof: usize) -> String {
        format!("q{dof}")
    }

    /// Unit of a degree of freedom in outputs, `m` or `rad`.
    fn dof_unit(&self, _dof: usize) -> &'static str {
        "m"
    }
}

impl<T: Scalar, const D: usize, S: MechanicalSystem<T, D> + ?Sized> MechanicalSystem<T, D> for Box<S> {
    fn dofs(&self) -> usize {
        (**self).dofs()
    }
    fn mass(&self) -> &Symmetric<T> {
        (**self).mass()
    }
    fn damping(&self) -> Option<&Symmetric<T>> {
        (**self).damping()
    }
    fn stiffness(&self) -> Option<&Symmetric<T>> {
        (**self).stiffness()
    }
    fn forces(&self) -> &Forces<T> {
        (**self).forces()
    }
    fn prescribed(&self) -> Option<&Prescribed<T>> {
        (**self).prescribed()
    }
    fn constant_jacobian(&self) -> bool {
        (**self).constant_jacobian()
    }
    fn interfaces(&self) -> usize {
        (**self).interfaces()
    }
    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        (**self).candidates(q, reach, out);
    }
    fn body_dofs(&self) -> Option<usize> {
        (**self).body_dofs()
    }
    fn awake_candidates(&mut self, q: &[T], reach: T, asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        (**self).awake_candidates(q, reach, asleep, out);
    }
    fn swept_candidates(
        &mut self,
        q: &[T],
        path: (T, &[T]),
        asleep: &[bool],
        out: &mut Vec<Candidate<T>>,
        times: &mut Vec<(ContactId, T)>,
    ) {
        (**self).swept_candidates(q, path, asleep, out, times);
    }
    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        (**self).jacobian(contact, q, out);
    }
    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        (**self).gap(contact, q)
    }
    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        (**self).scales(q, v)
    }
    fn geometry(&self) -> Option<&Arc<Geometry<T>>> {
        (**self).geometry()
    }
    fn contact_node(&self, contact: ContactId) -> Option<usize> {
        (**self).contact_node(contact)
    }
    fn joint_rows(&self) -> usize {
        (**self).joint_rows()
    }
    fn joints_move(&self) -> bool {
        (**self).joints_move()
    }
    fn joint_residual(&self, q: &[T], out: &mut [T]) {
        (**self).joint_residual(q, out);
    }
    fn joint_jacobian(&self, q: &[T], s: &[T], out: &mut BlockRows<T, 1>) {
        (**self).joint_jacobian(q, s, out);
    }
    fn joint_curvature(&self, q: &[T], s: &[T], multipliers: &[T], out: &mut [T]) {
        (**self).joint_curvature(q, s, multipliers, out);
    }
    fn joint_label(&self, row: usize) -> String {
        (**self).joint_label(row)
    }
    fn nonlinear(&self) -> Option<&dyn Dynamics<T>> {
        (**self).nonlinear()
    }
    fn contact_label(&self, contact: ContactId) -> String {
        (**self).contact_label(contact)
    }
    fn dof_label(&self, dof: usize) -> String {
        (**self).dof_label(dof)
    }
    fn dof_unit(&self, dof: usize) -> &'static str {
        (**self).dof_unit(dof)
    }
}

/// Characteristic length and speed of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales<T> {
    /// Length (m), > 0.
    pub length: T,
    /// Speed (m/s), > 0.
    pub speed: T,
}

/// Why a system could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SystemError {
    /// A matrix is not the symmetric operator it should be.
    #[error("{what}: {source}")]
    Operator {
        /// Which matrix.
        what: &'static str,
        /// What is wrong with it.
        source: OperatorError,
    },
    /// Two sizes differ.
    #[error("{what} has size {given}, the system has {expected} degrees of freedom")]
    Size {
        /// What has the wrong size.
        what: &'static str,
        /// Number of degrees of freedom.
        expected: usize,
        /// The size given.
        given: usize,
    },
    /// A number is outside its range.
    #[error("{what} is {value}, it must be {range}")]
    OutOfRange {
        /// What it is.
        what: String,
        /// The value refused.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// An outline is no convex polygon.
    #[error("polygon `{label}`, vertex {vertex}: {reason}")]
    Polygon {
        /// Label of the polygon.
        label: String,
        /// The vertex, or the number of vertices.
        vertex: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// An index names nothing.
    #[error("{what} {index} does not exist ({count} defined)")]
    Unknown {
        /// What was named.
        what: &'static str,
        /// The index given.
        index: usize,
        /// How many there are.
        count: usize,
    },
}
