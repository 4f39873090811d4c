//! Mechanical systems: M v̇ + C v + K q = F(t) + Hᵀ(q) r with candidate contacts g(q).
//!
//! A system says what moves and what may touch. It knows no law, no scheme and no solver. Four small traits say it:
//!
//! | trait | what it says | needed by |
//! |---|---|---|
//! | [`Dynamics`] | M, C, K, F, what moves as told; how q moves along a velocity | every system |
//! | [`Contacts`] | candidates, gaps, Jacobians | every system; none by default |
//! | [`Joints`] | bilateral rows, springs, motors | systems with joints |
//! | [`Describe`] | names, meshes, shapes | outputs alone |
//!
//! What implements the first two and the last is a [`System`]; an [`Assembly`] of several is one.
//!
//! A configuration q is no velocity: where q has more components than v (quaternions), or another geometry,
//! [`Dynamics::advance`] says what q ⊕ s is, and it is the one place where q moves.

mod assembly;
mod elastic;
mod element;
mod forces;
mod gaps;
mod interfaces;
mod lagrangian;
mod nonlinear;
mod prescribed;
mod rigid_bodies;
mod row_law;
mod signal;
mod solid;
mod spatial_bodies;

use std::fmt::Debug;
use std::sync::Arc;

pub use assembly::{Assembly, AssemblyError};
pub use elastic::{
    Axis, ElasticBody, ElasticBodyBuilder, ElasticError, Geometry, Hypothesis, MassForm, Material,
    PreloadError, Support,
};
pub use forces::Forces;
pub use gaps::{SmoothContacts, SmoothGap};
pub use interfaces::GroupId;
pub use lagrangian::Lagrangian;
pub use nonlinear::{NonlinearLagrangian, NonlinearTerms};
pub use prescribed::Prescribed;
pub use rigid_bodies::{
    Body, BodyId, ContactorId, Relative, RigidBodies, RigidBodiesBuilder, RoundSide, polygon_body,
};
pub use row_law::RowLaw;
pub use signal::Signal;
pub use solid::{ContactPlace, Solid, Surface};
pub use spatial_bodies::{
    Bodies, SpatialBodies, SpatialBodiesBuilder, SpatialBody, SpatialMotion, SpatialRelative,
};

use crate::contact::{Candidate, ContactId};
use crate::geometry::InertiaError;
use crate::linalg::{BlockRows, OperatorError, Symmetric, max_abs};
use crate::scalar::Scalar;

/// What moves: M v̇ + C v + K q = F(t), with constant M, C and K or with [nonlinear terms](Self::nonlinear).
///
/// Velocities, forces and displacements s have [`dofs`](Self::dofs) components, configurations q
/// [`coordinates`](Self::coordinates).
pub trait Dynamics<T: Scalar>: Debug + Send {
    /// Number of degrees of freedom n, components of v.
    fn dofs(&self) -> usize {
        self.mass().size()
    }

    /// Number of components of q. A system with another number than [`dofs`](Self::dofs) overrides
    /// [`advance`](Self::advance), [`difference`](Self::difference) and [`potential`](Self::potential).
    fn coordinates(&self) -> usize {
        self.dofs()
    }

    /// out ← q ⊕ s, where the motion s = h v_θ leads from q: the one place where q moves. Must undo
    /// [`difference`](Self::difference), and be q for s = 0. Default: q + s.
    fn advance(&self, q: &[T], s: &[T], out: &mut [T]) {
        for (out, (&q, &s)) in out.iter_mut().zip(q.iter().zip(s)) {
            *out = q + s;
        }
    }

    /// out ← the motion s with `from` ⊕ s = `to`, the least there is: what error norms and interpolation measure.
    /// Default: `to` − `from`.
    fn difference(&self, from: &[T], to: &[T], out: &mut [T]) {
        for (out, (&from, &to)) in out.iter_mut().zip(from.iter().zip(to)) {
            *out = to - from;
        }
    }

    /// Whether q ⊕ s is q + s. A system with stiffness, prescribed motion or nonlinear terms must be flat, and so must one
    /// that is followed from event to event. Default: whether q and v have as many components.
    fn is_flat(&self) -> bool {
        self.coordinates() == self.dofs()
    }

    /// Whether velocities change without forces, as those of bodies that turn in space do: the system then has
    /// [`fly`](Self::fly), and neither stiffness, prescribed motion nor nonlinear terms.
    fn flies(&self) -> bool {
        false
    }

    /// Free flight: leads (q, v) on without any force, every degree of freedom i for `times[i]` (s), those of one body for
    /// one time. It must keep the kinetic energy, and move q as [`advance`](Self::advance) does to first order, translations
    /// exactly so.
    fn fly(&self, times: &[T], q: &mut [T], v: &mut [T]) {
        if self.is_flat() {
            q.iter_mut().zip(times.iter().zip(&*v)).for_each(|(q, (&time, &v))| *q += time * v);
            return;
        }
        let s: Vec<T> = times.iter().zip(&*v).map(|(&time, &v)| time * v).collect();
        let from = q.to_vec();
        self.advance(&from, &s, q);
    }

    /// The second flight of a step that began at `start` and moves by s = h v_θ: leads (q, v) on as [`fly`](Self::fly) does.
    /// What is in joints takes no flights but the way `start` ⊕ s, along which their rows are discrete derivatives.
    fn land(&self, _start: &[T], _s: &[T], times: &[T], q: &mut [T], v: &mut [T]) {
        self.fly(times, q, v);
    }

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

    /// Torques about fixed axes (N m), in the places of rotations about axes that go with bodies; see
    /// [`pull_back`](Self::pull_back).
    fn fixed_torques(&self) -> Option<&Forces<T>> {
        None
    }

    /// Adds to `force` what [torques about fixed axes](Self::fixed_torques) are about the axes of the velocities, in
    /// configuration q.
    fn pull_back(&self, _q: &[T], _torques: &[T], _force: &mut [T]) {}

    /// Potential of the constant forces (J), −F₀·q by default.
    fn potential(&self, q: &[T]) -> T {
        self.forces().potential(q)
    }

    /// Degrees of freedom that move as told, the last ones; an absent list costs nothing.
    fn prescribed(&self) -> Option<&Prescribed<T>> {
        None
    }

    /// The terms of a nonlinear system, `None` where M, C and K say all.
    fn nonlinear(&self) -> Option<&dyn NonlinearTerms<T>> {
        None
    }

    /// The joints, `None` without.
    fn joints(&self) -> Option<&dyn Joints<T>> {
        None
    }

    /// Degrees of freedom of a body, where the system is one of bodies, body i with those from i times this number on,
    /// that nothing but contacts couples. Bodies at rest then may leave the steps, see [`scheme`](crate::scheme).
    fn body_dofs(&self) -> Option<usize> {
        None
    }

    /// Whether a degree of freedom turns (rad), and does not shift (m): error norms take lengths as shares of the
    /// [length](Scales::length) of the scene, and angles as they are.
    fn turns(&self, _dof: usize) -> bool {
        false
    }

    /// Size and speed that make the tolerances of the active set scale-free.
    fn scales(&self, q: &[T], v: &[T]) -> Scales<T>;
}

/// What may touch: unilateral contacts of dimension D. By default nothing does.
///
/// Local frames are ordered (N, T1, T2) with the normal pointing from the obstacle to the body, so that a closing contact
/// has u_N < 0.
pub trait Contacts<T: Scalar, const D: usize>: Debug + Send {
    /// Number of interfaces; the scheme wants one law for each.
    fn interfaces(&self) -> usize {
        0
    }

    /// Whether H^α(q) is the same for all q: the scheme then keeps the Delassus operator of all candidates, those
    /// of an infinite reach, and takes its active rows.
    fn constant_jacobian(&self) -> bool {
        false
    }

    /// Appends every candidate contact with gap g(q) ≤ `reach` to `out`, each once, in any order.
    ///
    /// `&mut self` lets a broad phase keep its order from one call to the next.
    fn candidates(&mut self, _q: &[T], _reach: T, _out: &mut Vec<Candidate<T>>) {}

    /// As [`candidates`](Self::candidates), without those between bodies that are `asleep`, or between such a body and
    /// obstacles. A system with [`Dynamics::body_dofs`] overrides it: by default all are found, and wake everybody.
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

    /// Appends the block row H^α(q), of a candidate that [`candidates`](Self::candidates) named, to `out`: one row, begun by
    /// [`BlockRows::start_row`].
    fn jacobian(&self, _contact: ContactId, _q: &[T], out: &mut BlockRows<T, D>) {
        out.start_row();
    }

    /// Gap g^α(q) (m) of a candidate that [`candidates`](Self::candidates) named, of the same features, in any
    /// configuration near the one it was named in.
    fn gap(&self, _contact: ContactId, _q: &[T]) -> T {
        T::infinity_impl()
    }
}

/// Bilateral rows φ(q) = 0, and rows along which springs, motors or dry friction act ([`law`](Self::law)).
///
/// A joint is a contact whose half-line has become the whole line: in the cone problem its percussion is free
/// (K = ℝ), so that the dual cone is K* = {0} and the row reads u = 0. The scheme eliminates such rows exactly,
/// see [`scheme`](crate::scheme).
pub trait Joints<T: Scalar>: Debug {
    /// Number of rows.
    fn rows(&self) -> usize;

    /// Whether bodies move along joints; those welded to the ground alone do not.
    fn moves(&self) -> bool {
        self.rows() > 0
    }

    /// out ← φ(q), one number per row (m or rad).
    fn residual(&self, q: &[T], out: &mut [T]);

    /// Appends the rows Ḡ(q, s), with φ(q ⊕ s) − φ(q) = Ḡ(q, s) s.
    fn jacobian(&self, q: &[T], s: &[T], out: &mut BlockRows<T, 1>);

    /// Appends the rows ∂φ(q ⊕ s)/∂s, with `end` = q ⊕ s and zeros in `still`. By default Ḡ(`end`, 0), as where q ⊕ s is
    /// q + s.
    ///
    /// It speeds up the iteration, whose solution does not depend on it.
    fn tangent(&self, _q: &[T], _s: &[T], (end, still): (&[T], &[T]), out: &mut BlockRows<T, 1>) {
        self.jacobian(end, still, out);
    }

    /// Adds the impulses (N s, N m s) over a step of length `step` of the inertial forces that the motion `s` brings beside M:
    /// the gyroscopic torques of joined bodies in space. They do no work along s; there are none by default.
    fn inertial(&self, _s: &[T], _step: T, _out: &mut [T]) {}

    /// Adds ∂(Ḡ(q, s)ᵀλ)_i/∂s_i to out_i, for one multiplier λ per row.
    ///
    /// It speeds up the iteration of a step with joints, whose solution does not depend on it: Newton's method with it,
    /// a linear rate of the order of h²λ without.
    fn curvature(&self, _q: &[T], _s: &[T], _multipliers: &[T], _out: &mut [T]) {}

    /// What holds a row over the step of length `step` from q at `time`; every row is held by default.
    fn law(&self, _row: usize, _q: &[T], _time: T, _step: T) -> RowLaw<T> {
        RowLaw::Held
    }

    /// Whether every row is [held](RowLaw::Held).
    fn all_held(&self) -> bool {
        true
    }

    /// Energy (J) of the springs in the rows.
    fn energy(&self, _q: &[T]) -> T {
        T::zero()
    }

    /// Name of the joint a row belongs to.
    fn label(&self, row: usize) -> String {
        row.to_string()
    }
}

/// Names, meshes and shapes, for outputs and errors alone: numerics never read a label.
pub trait Describe<T: Scalar> {
    /// Name of a degree of freedom.
    fn dof_label(&self, dof: usize) -> String {
        format!("q{dof}")
    }

    /// Unit of a degree of freedom, as a displacement: `m` or `rad`.
    fn dof_unit(&self, _dof: usize) -> &'static str {
        "m"
    }

    /// Component of q that shows a shift along a degree of freedom; the same number where both are one.
    fn coordinate_of(&self, dof: usize) -> usize {
        dof
    }

    /// Name of a component of q; that of the degree of freedom where both are one.
    fn coordinate_label(&self, coordinate: usize) -> String {
        self.dof_label(coordinate)
    }

    /// Name of a contact.
    fn contact_label(&self, contact: ContactId) -> String {
        contact.number().to_string()
    }

    /// Outlines of the bodies in configuration q, as points (m) in the fixed frame, closed ones with the first point repeated:
    /// for figures. A disc has `sides` sides, a point is a single point.
    fn outlines(&self, _q: &[T], _sides: usize) -> Vec<Vec<[T; 2]>> {
        Vec::new()
    }

    /// Shapes of the bodies for pictures, none by default.
    fn solids(&self) -> Vec<Solid> {
        Vec::new()
    }

    /// Pose of a body in configuration q: position (m) and unit quaternion (w, x, y, z), from its frame to the fixed one.
    fn body_pose(&self, _body: usize, _q: &[T]) -> ([f64; 3], [f64; 4]) {
        ([0.0; 3], [1.0, 0.0, 0.0, 0.0])
    }

    /// Velocity (m/s) of the origin of a body's frame, and spin (rad/s), both along the fixed axes.
    fn body_velocity(&self, _body: usize, _q: &[T], _v: &[T]) -> ([f64; 3], [f64; 3]) {
        ([0.0; 3], [0.0; 3])
    }

    /// Point (m) of a contact and its local axes in the fixed frame, `None` where it has no place.
    fn contact_place(&self, _contact: ContactId, _q: &[T]) -> Option<ContactPlace> {
        None
    }

    /// Mesh and numbering of an elastic body.
    fn geometry(&self) -> Option<&Arc<Geometry<T>>> {
        None
    }

    /// Node of the mesh that a contact belongs to.
    fn contact_node(&self, _contact: ContactId) -> Option<usize> {
        None
    }
}

/// A mechanical system with contacts of dimension D: all that has [`Dynamics`], [`Contacts`] and [`Describe`].
pub trait System<T: Scalar, const D: usize>: Dynamics<T> + Contacts<T, D> + Describe<T> {}
impl<T: Scalar, const D: usize, S: Dynamics<T> + Contacts<T, D> + Describe<T>> System<T, D> for S {}

/// Characteristic length and speed of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales<T> {
    /// Length (m), > 0.
    pub length: T,
    /// Speed (m/s), > 0.
    pub speed: T,
}

impl<T: Scalar> Scales<T> {
    /// The largest |q| and |v|, or 1.
    pub fn of(q: &[T], v: &[T]) -> Self {
        let or_one = |x: T| if x > T::zero() { x } else { T::one() };
        Self { length: or_one(max_abs(q)), speed: or_one(max_abs(v)) }
    }
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
    /// Moments of inertia that no body has.
    #[error("inertia of `{body}`: {source}")]
    Inertia {
        /// Name of the body.
        body: String,
        /// What is wrong.
        source: InertiaError,
    },
    /// A connection of a body with itself.
    #[error(
        "{what} connects `{body}` with `{body}`: it wants two different bodies, another body or the ground as the second"
    )]
    OneBody {
        /// The connection.
        what: String,
        /// The body.
        body: String,
    },
    /// A connection of bodies that all move as told.
    #[error("{what} connects {bodies}: one of its bodies must move under forces")]
    NoneFree {
        /// The connection.
        what: String,
        /// The bodies, by name.
        bodies: String,
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
