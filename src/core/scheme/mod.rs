//! The Moreau–Jean θ-scheme, for any contact law: active-set rules, cone problem, step.
//!
//! # Islands
//!
//! Contacts that no chain of blocks of W couples are solved apart, one cone problem for each island of bodies in touch;
//! an island whose percussions of the last step still solve it costs no iteration. The solution reported is measured on
//! the whole problem.
//!
//! # Bodies at rest
//!
//! With [`Settings::sleep`] an island that stands still leaves the steps until something touches it: the derivation stands
//! at the head of `rest.rs`. Its contacts are reported all the same, with the percussions that hold it.
//!
//! # Joints
//!
//! A joint is a contact whose half-line became the whole line. With rows Ḡ and percussions λ ∈ ℝ of the joints, the
//! dual of whose cone is {0},
//!
//! ```text
//!   M̂ (v_{k+1} − v_free) = Hᵀ p + Ḡᵀ λ,     K* ∋ Φ(w) ⟂ p ∈ K,     {0} ∋ Ḡ v_{k+θ} ⟂ λ ∈ ℝ
//! ```
//!
//! and λ is eliminated: M̂⁻¹ gives way to P = M̂⁻¹ − M̂⁻¹ Ḡᵀ S⁻¹ Ḡ M̂⁻¹, S = Ḡ M̂⁻¹ Ḡᵀ, in W = H P Hᵀ and in the
//! free velocity, and every solver sees a cone problem as before. Joints do no work, for any θ. Ḡ is the discrete
//! derivative of φ over the step, φ(q_{k+1}) − φ(q_k) = Ḡ (q_{k+1} − q_k), so that joints stay closed to rounding
//! ([`Settings::joint_tolerance`]) over any number of steps. It depends on the end of the step: Newton's method finds it
//! under given percussions, and passes with a cone problem each, accelerated, find these; see `joints.rs`.
//!
//! A row of the joints may have a [law](crate::system::RowLaw): a spring with a damper, a motor, dry friction. Its percussion
//! then works, and the balance has the work by kind: springs change the elastic energy, dampers and friction are damping work,
//! motors external work. Rows that hold the same thing twice are solved with a ridge around the multipliers; see `laws.rs`.
//!
//! # Bodies that turn in space
//!
//! A system whose velocities change without forces, J ω̇ + ω × J ω = 0, makes its step between two free flights, which keep the
//! kinetic energy and the angular momentum: the derivation stands at the head of `flight.rs`.
//!
//! # Nonlinear systems
//!
//! For M(q) v̇ + f(t, q, v) = F + Hᵀ r with kinetic energy T = ½ v·M(q) v and potential V(q) the step is
//!
//! ```text
//!   M₁ v₁ − M₀ v₀ − h ∇̄T + h ∇̄V + h d(t_θ, q_θ, v_θ) = h F_θ + H(q₀)ᵀ p
//!   ∇̄T_i = v_θ·D_iM v̄ − ¼ (v₁·D_iM v₁ + v₀·D_iM v₀),     v̄ = ½ (v₀ + v₁)
//! ```
//!
//! with discrete derivatives Σ_i D_iM Δq_i = M₁ − M₀ and ∇̄V·Δq = V₁ − V₀ (Gonzalez 1996). Times v_θ it gives
//!
//! ```text
//!   (T + V)₁ − (T + V)₀ = h v_θ·F_θ − h v_θ·d + (½−θ) ‖v₁ − v₀‖²_M̄ + Σ_α u_θ·p + v_θ·ρ,   M̄ = ½ (M₀ + M₁)
//! ```
//!
//! the balance (56) up to what the Newton iteration leaves, ρ: it closes to the tolerance of the nonlinear solve. The
//! contact works are those of the linear scheme, u_θ = H(q_k) v_θ, and so is the sign a law claims for them. The
//! derivation stands at the head of `nonlinear.rs`.

mod activation;
mod active_set;
mod arms;
mod balance;
mod certainty;
mod clock;
mod cones;
mod crossed;
mod delassus;
mod equations;
mod equilibrium;
mod error;
mod find_contacts;
mod flight;
mod islands;
mod joints;
mod kept;
mod lasting;
mod matrix;
mod memory;
mod move_on;
mod no_joints;
mod nonlinear;
mod passes;
mod positions;
mod record;
mod rest;
mod setup;
mod snapshot;
mod solve_contacts;
mod step;
mod theta_scheme;
mod variable;
mod velocity;

pub use activation::{Activation, ActivationRule};
pub use equilibrium::{EquilibriumError, equilibrium};
pub use error::{SetupError, StepError};
pub use record::{ContactStep, Part, State, Step};
pub use setup::Settings;
#[cfg(feature = "scene")]
pub(crate) use setup::{claim_slack, claims};
pub use snapshot::{RestoreError, Snapshot};
pub use theta_scheme::ThetaScheme;
pub(crate) use variable::Saved;
