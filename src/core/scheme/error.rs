//! Why a scheme could not be set up, or a step not be made.

use crate::contact::ImproperResponse;
use crate::linalg::FactorError;
use crate::solver::{SolveError, StoppingError};

/// Why a scheme could not be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// θ outside [0, 1].
    #[error("θ = {theta} is not in [0, 1]")]
    Theta {
        /// The value refused.
        theta: f64,
    },
    /// θ_rest outside [½, 1].
    #[error("θ_rest = {theta} is not in [0.5, 1]")]
    ThetaRest {
        /// The value refused.
        theta: f64,
    },
    /// θ outside the interval in which a law is proved dissipative.
    #[error(
        "θ = {theta} is outside [{min}, {max}], where the law `{law}` of interface {interface} is proved \
         dissipative; choose θ inside, or allow an unproved θ explicitly"
    )]
    UnprovedTheta {
        /// Name of the law.
        law: String,
        /// Interface it governs.
        interface: usize,
        /// The value refused.
        theta: f64,
        /// Lower end of the claimed interval.
        min: f64,
        /// Upper end of the claimed interval.
        max: f64,
    },
    /// h is not a positive finite number.
    #[error("the time step is {step}, it must be finite and > 0")]
    TimeStep {
        /// The value refused.
        step: f64,
    },
    /// A tolerance of the active set is not a finite number above what rounding and the solver leave.
    #[error(
        "the {what} tolerance of the active set is {value}, it must be finite and at least {least:e} here: below, rounding \
         and the solver's tolerance decide which contacts there are"
    )]
    ActivationTolerance {
        /// `gap` or `velocity`.
        what: &'static str,
        /// The value refused.
        value: f64,
        /// The least that is accepted, ε of the scene's length, or the solver's tolerance of its speed.
        least: f64,
    },
    /// A vector or an operator of the system has the wrong size.
    #[error("{what}: size {given} for {expected} degrees of freedom")]
    Size {
        /// `mass`, `damping`, `stiffness`, `force`, `prescribed`, `q` or `v`.
        what: &'static str,
        /// Degrees of freedom of the system.
        expected: usize,
        /// Components given.
        given: usize,
    },
    /// A component of the initial state is NaN or infinite.
    #[error("{what}[{component}] is {value}, it must be finite")]
    NotFinite {
        /// `q` or `v`.
        what: &'static str,
        /// Component.
        component: usize,
        /// The value refused.
        value: f64,
    },
    /// The number of laws is not the number of interfaces.
    #[error("the system has {interfaces} interfaces, {laws} laws were given")]
    Laws {
        /// Interfaces of the system.
        interfaces: usize,
        /// Laws given.
        laws: usize,
    },
    /// A law gives a friction or an evaluation point no cone problem can be built with.
    #[error("law `{law}` gives {what} = {value} at θ = {theta}")]
    Law {
        /// Name of the law.
        law: String,
        /// What it gave.
        what: &'static str,
        /// The value.
        value: f64,
        /// θ.
        theta: f64,
    },
    /// A constant row of H is not finite, or names a degree of freedom the system does not have.
    #[error("contact {contact}: its row of H is not finite, or reaches beyond {dofs} degrees of freedom")]
    ConstantRow {
        /// Label of the contact.
        contact: String,
        /// Degrees of freedom of the system.
        dofs: usize,
    },
    /// The energy of the initial state overflows.
    #[error("the energy of the initial state is not finite (kinetic {kinetic} J, elastic {elastic} J)")]
    Energy {
        /// Kinetic energy (J).
        kinetic: f64,
        /// Elastic energy (J).
        elastic: f64,
    },
    /// θ = 0 leaves v_{k+θ} = v_k no freedom to keep the joints closed.
    #[error("joints need θ > 0")]
    JointsTheta,
    /// Terms that multiply q, of a system whose configurations do not add up.
    #[error("{what} wants configurations that add up, q + h v: this system moves them otherwise")]
    Curved {
        /// Which terms.
        what: &'static str,
    },
    /// Bodies in space under error control.
    #[error("error control does not follow bodies that turn in space: give a fixed step")]
    FlightAdaptive,
    /// Joints between the coordinates of a nonlinear system.
    #[error("a nonlinear system takes no joints: choose its coordinates so that they hold")]
    JointsNonlinear,
    /// A joint is open in the initial configuration.
    #[error("joint {joint} is open by {by} at the start")]
    JointOpen {
        /// Label of the joint.
        joint: String,
        /// φ (m or rad).
        by: f64,
    },
    /// A tolerance of the joints that is not finite, not positive or below rounding.
    #[error(
        "joint_tolerance = {value:e} must be finite and at least {rounding:e}, the rounding of positions in this scene"
    )]
    JointTolerance {
        /// The tolerance given (m or rad).
        value: f64,
        /// The smallest that is accepted.
        rounding: f64,
    },
    /// Error control over joints.
    #[error(
        "error control takes no joints that move: their rates alternate about zero from step to step, which a change of length \
         breaks; use fixed steps"
    )]
    JointsAdaptive,
    /// A step that changes its length, with displacements that move.
    #[error("a step of changing length takes no prescribed displacement that moves: its q_k depends on h")]
    MovingStep,
    /// A step that changes its length, with bodies that may sleep.
    #[error("a step of changing length takes no bodies that sleep: what counts as rest depends on h")]
    SleepingStep,
    /// M is not positive definite.
    #[error("mass: {0}")]
    Mass(FactorError),
    /// M̂ = M + hθC + h²θ²K is not positive definite.
    #[error("iteration matrix M + hθC + h²θ²K: {0}")]
    IterationMatrix(FactorError),
    /// The solver's stopping rule is out of range.
    #[error(transparent)]
    Stopping(#[from] StoppingError),
}

/// Why a step was not made. The state is that of before the step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// A gap or a row of H is NaN or infinite.
    #[error("step {step}, t = {time} s: the {what} of contact {contact} is not finite")]
    Contact {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// Label of the contact.
        contact: String,
        /// `gap` or `Jacobian`.
        what: &'static str,
    },
    /// A system names a degree of freedom or an interface it does not have.
    #[error("step {step}, t = {time} s: contact {contact} names {what} {index}, the system has {count}")]
    Unknown {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// Label of the contact.
        contact: String,
        /// `degree of freedom` or `interface`.
        what: &'static str,
        /// The index named.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A law gave an evaluation point that is not finite, or γ ≤ 0.
    #[error("step {step}, t = {time} s, contact {contact}: {source}")]
    Law {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// Label of the contact.
        contact: String,
        /// The answer.
        source: ImproperResponse,
    },
    /// The cone problem was not solved.
    #[error("step {step}, t = {time} s, {contacts} contacts: {source}")]
    Solve {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// Contacts in the problem.
        contacts: usize,
        /// What the solver says, with the best residual.
        source: SolveError,
    },
    /// The joints leave no velocity.
    #[error("step {step}, t = {time} s: joint {joint} cannot be kept, the joints contradict each other")]
    Joints {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// Label of the joint.
        joint: String,
    },
    /// The passes over a step with joints did not end.
    #[error(
        "step {step}, t = {time} s: joint {joint} is open by {opening:e} after {passes} passes, tolerance {tolerance:e}, \
         and the equations of motion and joints are off by {excess:e} tolerances; a smaller step converges faster"
    )]
    JointPasses {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// Label of the joint that is open most.
        joint: String,
        /// Its opening (m or rad).
        opening: f64,
        /// How much was allowed.
        tolerance: f64,
        /// The larger of the opening and the residual of the equations of motion, in what is allowed of each.
        excess: f64,
        /// Passes made.
        passes: usize,
    },
    /// The iteration for nonlinear terms did not end.
    #[error(
        "step {step}, t = {time} s: {what} is {left_over:e} after {passes} passes, tolerance {tolerance:e}; a \
         smaller step converges faster"
    )]
    Iteration {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// What is left: the relative residual of the equations of motion.
        what: &'static str,
        /// How much.
        left_over: f64,
        /// How much was allowed.
        tolerance: f64,
        /// Passes made.
        passes: usize,
    },
    /// M̂ of a nonlinear system is not positive definite.
    #[error("step {step}, t = {time} s: the mass matrix M(q) is not positive definite")]
    Mass {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
    },
    /// The energy overflowed.
    #[error(
        "step {step}, t = {time} s: the energy or its balance is not finite (kinetic energy {kinetic} J)"
    )]
    Energy {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// Kinetic energy (J).
        kinetic: f64,
    },
    /// A force or the new state is NaN or infinite.
    #[error("step {step}, t = {time} s: {what}[{component}] is {value}, it must be finite")]
    State {
        /// Number of the step.
        step: usize,
        /// Time at its end.
        time: f64,
        /// `F` (the forces F_{k+θ}), `v` or `q`.
        what: &'static str,
        /// Component.
        component: usize,
        /// Its value.
        value: f64,
    },
}
