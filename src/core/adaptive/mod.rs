//! Steps under error control: the θ-scheme with steps chosen for a tolerance, and placed at impacts.
//!
//! # What ε bounds
//!
//! The tolerance ε is a share of the scene's length L ([`Scales::length`](crate::system::Scales)), over a span from the
//! start t₀ to an end T. Two errors are meant, in the largest component,
//!
//! ```text
//!   max_k |q_k − q(t_k)| / L        and        ∫ |v_h(t) − v(t)| dt / L
//! ```
//!
//! with v_h linear over each step, as q_{k+1} = q_k + h v_{k+½} has it. (Not Σ h_k |v_k − v(t_k)|: a step that ends within
//! rounding of an impact would count for its whole length, with the jump.) An angle counts as the path of a point a length
//! L away, that is as it stands, in radians. Both are aimed at ε; what a motion makes of an error once made (an impact may
//! amplify it) is not known to any one-step estimate, so that a
//! factor of three is left for it. Velocities are measured in L1(t): in L∞ two motions whose impacts differ by a
//! nanosecond are apart by a whole jump, whatever the scheme.
//!
//! # How
//!
//! Every step kept is one θ-step of the scheme with its θ and its laws, never an extrapolation, so that the balance (56)
//! and the sign of the contact works hold at each of them. The tolerances of the active set alone, where the user gave
//! none, are others: γ = 10⁻⁴ ε L on gaps, and on speeds that of a bounce which rounding hides, 1024 ε_machine L high.
//!
//! - **Between events** one step of 3h is compared with three of h, which are kept where
//!   e_q + (T − t) e_v ≤ ε 3h/(T − t₀): errors per unit of time, those of the velocity at what they become until T.
//!   Three and not two: in persistent stick Frémond's law at θ = ½ turns u_T over at every step (±c), a property of the law
//!   and no error, which one and three steps agree about. The difference over 3² − 1 = 8 is the error of the three; over
//!   3 − 1 = 2 where the order is 1: θ ≠ ½, H that turns along the step (constraints are kept with H(q_k)), contacts that
//!   change between sticking, sliding and lifting. Where the motion goes on as before, the three steps are made alone, and
//!   their third differences give the h³/12 times the third derivatives that are their errors. A PI controller chooses
//!   the next length.
//! - **Forces in time** on a body that sticks are resolved as well, to 5·10⁻² ε of what they would do between two steps:
//!   it shows nothing of them until it slides.
//! - **Impacts.** A candidate that has overlapped at the end of a trial is traced back along the path of that trial, a
//!   parabola, to the moment it closes. The flight is made again to end just before that, at a distance of γ, and a step
//!   δ = 2g/|u_N| puts the impact at its middle, where a θ-step at θ = ½ has no error of first order in q: its velocity
//!   before and after hold for δ/2 each. An impact that follows within the smallest step is made with that step; where it
//!   moves a body by far more than γ, that comes out of the half of ε for jumps. δ is of the order of γ/|u_N|, so that the error of second order is below 10⁻² ε.
//!   After it the step is as long as before it. As an active set by predicted gaps would take a contact that decelerates
//!   for one that closes, no step is longer than a free candidate takes to close at its present speed; near a grazing
//!   contact that halves the distance step by step.
//! - **Dips.** A gap with a minimum between the ends of three steps is looked at there.
//! - **Accumulation.** Bounces are followed down, three steps each. One that the active set would keep (by predicted gaps
//!   if it is lower than γ, by rule (55) if rounding hides it) is not flown: a step of γ/|u_N| keeps the contact active,
//!   and the law brings it to rest. Both series are geometric, O(log) steps. e = 1 never rests.
//! - **Ends of sliding.** Sliding that ends within a step is ended by a step of its own, to where it would stop, up to
//!   10⁻² ε L/(T − t) of speed. Sticking that ends, and contacts that lift, change their forces continuously: the
//!   estimate is enough.
//! - **Jumps** of forces in time, and what else no step length reconciles, take from another half of ε, a twentieth of
//!   what is left of it each.
//!
//! Where M̂ depends on h and is not diagonal, lengths are the span times 2⁻ʲ and 3·2⁻ʲ, and thirds of them: the
//! scheme keeps their factors. An approach then goes down that ladder.
//!
//! # What it cannot do
//!
//! Bodies whose gaps are below γ when an impact reaches one of them are hit at once, as bodies that touch: a law for impacts
//! one after the other and one for all at once may give other velocities, whatever the size of the gap. A row of balls shows
//! its gaps where ε < 10⁴ gap/L, and never below 10⁻¹² L.
//!
//! A grazing contact (an impact at zero speed) makes √ε of an error of ε, for every method: the motion itself does. And a
//! step whose error does not fall under its share as the step shrinks ends the run with
//! [`AdaptiveError::Underflow`]; the state is that of the last step kept. What rounding makes of a state is no error in this
//! sense, as shorter steps make no less of it. A motion that needs more than [`AdaptiveSettings::max_steps`] steps for a
//! thousandth of the span ends with [`AdaptiveError::TooManySteps`].

mod attempt;
mod control;
mod driver;
mod events;
mod held;
mod path;
mod roots;
mod settings;

pub use held::{Adaptive, Report};
pub use settings::{AdaptiveError, AdaptiveSettings, Limit};
