//! Event-driven integration: the motion itself, to rounding, as a reference for time-stepping schemes.
//!
//! # The motion
//!
//! M, C, K are constant and F is smooth between the breaks of its signals. With gaps g^α and local velocities
//! u = H(q) v, between impacts
//!
//! ```text
//!   M v̇ + C v + K q = F(t) + Hᵀ λ,      0 ≤ g ⟂ λ_N ≥ 0,      ‖λ_T‖ ≤ μ λ_N,   λ_T = −μ λ_N u_T/‖u_T‖ where u_T ≠ 0
//! ```
//!
//! and at an impact, all contacts with g = 0 taking part, M (v⁺ − v⁻) = Hᵀ p with the law of each contact at θ = ½,
//!
//! ```text
//!   w = W p + u⁻ + δ,   K* ∋ Φ(w) ⟂ p ∈ K,   W = H M⁻¹ Hᵀ,   δ = ((1−γ) u⁻ + s)/γ
//! ```
//!
//! which is (35) for Newton's law and Ξ (45–46) for Frémond's.
//!
//! # Modes
//!
//! A contact with g = 0 and u_N = 0 is open, sticks or slides. The modes are those of the solution of the cone problem of
//! the accelerations, w = W λ + H a_free + Ḣ v, in which a contact that slips has its tangential velocity added with a
//! weight that keeps its direction; it is solved by the same [`ConeSolver`](crate::solver::ConeSolver), slightly after
//! the event (1e-6 of a step), as at the event itself two modes are possible. Where the solver stops early, or no modes
//! near its solution are consistent, Lemke's method finds a vertex of the linear complementarity problem, or that there is
//! none; it visits no vertex twice. With the modes fixed λ is the solution of a
//! linear system, and the motion that of an ordinary differential equation of index 1 (Acary & Brogliato 2008, ch. 8,
//! doi:10.1007/978-3-540-75392-6), whose drift from g = 0, u_N = 0 and, sticking, u_T = 0 is projected away after every
//! step. Redundant contacts share what is not determined in proportion to the normal forces, or stay near the forces that
//! the least friction sustains.
//!
//! Where no finite force keeps a sliding contact closed (Painlevé) there is an impact without collision: the law of
//! impact with an infinitesimal approach (Génot & Brogliato 1999, doi:10.1016/S0997-7538(99)00144-8).
//!
//! # Method
//!
//! Pieces of the motion are polynomials found by Gauss–Legendre collocation of order 24 and kept as dense output; with
//! constant forces they are exact parabolas. They end at the first root of a gap, of a normal force, of the distance of a
//! force from its cone, or of a slip; the functions are bounded over intervals, so that no pair of close roots is
//! missed, and their roots found to the last digit. A gap that touches zero by less than its rounding is a touch, not an
//! impact. The mean velocity since the last contact stands in for the gap after an impact: flights of any shortness are
//! found. A ball that comes to rest through infinitely many impacts is followed through all of them that are faster than
//! the tolerance, 1e-13 of the speed of the scene, and then held: it rests 2u/(a(1−e)) too early, u being that speed.
//!
//! Solvers of ordinary differential equations at hand interpolate with order 7 at most, and none is exact for parabolas,
//! which is why the collocation is the crate's own.
//!
//! # Limits
//!
//! Contacts of dimension 1 and 2; no joints, no configuration-dependent mass, no prescribed degrees of freedom: these are
//! refused. All is dense in the closed contacts, every candidate is looked at, and steps follow the highest frequency of
//! the system: made for tens of degrees of freedom. Of redundant contacts that stick the forces are not unique: they are
//! kept inside the cones as long as the cone problem says that this can be; where it changes its mind at one time, the
//! motion ends in [`EventFailure::Stalled`], which piles of eight discs still may. Each contact of a pile bounces some forty
//! times before it stays, in chains that others begin again: with e > 0 six discs take a thousand impacts and more. Where
//! closed contacts wedge one another, no velocity after an impact may satisfy Newton's law with e > 0 and friction (forces p
//! inside the cones with Hᵀ p = 0 and p·δ < 0), which ends in [`EventFailure::Inconsistent`]; with e = 0, and with Frémond's
//! law, p·δ is never negative. Contacts between polygons whose features change are found where they change, to 1e-12 of a
//! step. A graze, or a friction force that touches its cone, is decided by rounding.

mod collocation;
mod complementarity;
mod crossing;
mod dynamics;
mod error;
mod events;
mod integrate;
mod least_norm;
mod legendre;
mod local;
mod motion;
mod piece;
mod settle;

pub use error::{EventError, EventFailure};
pub use integrate::integrate;
pub use motion::{ContactImpact, ImpactEvent, Mode, ModeChange, Motion};

/// Tolerances of the integration; the defaults are those of double precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// What a step may leave out of its velocities, relative to them (in the norm of M). Default 1e-14.
    pub tolerance: f64,
    /// Gap up to which a contact is closed, relative to the length of the scene. Default 1e-13.
    pub gap_tolerance: f64,
    /// Normal velocity below which a closed contact neither approaches nor leaves, relative to the speed of the scene,
    /// or to that of the motion where it is larger. Default 1e-13.
    pub speed_tolerance: f64,
    /// Largest step (s). Default: none; to be set where F(t) has features that are shorter than a hundredth of a step
    /// and no break announces.
    pub largest_step: f64,
    /// Largest number of events. Default 100 000.
    pub max_events: usize,
    /// Largest number of steps, which the motion keeps. Default 1 000 000.
    pub max_steps: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tolerance: 1e-14,
            gap_tolerance: 1e-13,
            speed_tolerance: 1e-13,
            largest_step: f64::INFINITY,
            max_events: 100_000,
            max_steps: 1_000_000,
        }
    }
}

impl Settings {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`EventFailure::OutOfRange`].
    pub fn check(&self) -> Result<(), EventFailure> {
        let least = 4.0 * f64::EPSILON;
        for (what, value) in [
            ("tolerance", self.tolerance),
            ("gap_tolerance", self.gap_tolerance),
            ("speed_tolerance", self.speed_tolerance),
        ] {
            if !(least..=1e-3).contains(&value) {
                return Err(EventFailure::OutOfRange {
                    what: what.into(),
                    value,
                    range: "between 4 ε and 1e-3",
                });
            }
        }
        if !(self.largest_step > 0.0) {
            let what = "largest_step".into();
            return Err(EventFailure::OutOfRange { what, value: self.largest_step, range: "> 0" });
        }
        Ok(())
    }
}
