//! The settings of the scheme, and what is checked before the first step.

use super::no_joints::joints_of;
use std::ops::RangeInclusive;

use nalgebra::SVector;

use super::joints::{LEAST_ROUNDING, ROUNDING};
use super::{Activation, SetupError};
use crate::laws::{Approach, ContactLaw, Response};
use crate::linalg::{Symmetric, max_abs};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};
use crate::system::{Dynamics, RowLaw};

/// Parameters of the scheme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<T> {
    /// θ ∈ [0, 1] of x_{k+θ} = (1−θ) x_k + θ x_{k+1}; ½ conserves energy between impacts.
    pub theta: T,
    /// Time step h > 0 (s).
    pub step: T,
    /// Rule and tolerances of the active set.
    pub activation: Activation<T>,
    /// Opt-out: accept a θ outside the interval in which a law is proved dissipative. Default `false`. Laws that
    /// claim no interval at all constrain θ in neither case.
    pub allow_unproved_theta: bool,
    /// Contacts that carried a percussion and are slow [last](crate::laws::Approach::lasting): they take no restitution and
    /// stay in the active set through rounding, their islands take `theta_rest`, and their overlaps are opened. Default
    /// `true`; without, the rule of the active set is taken literally. Systems with damping or stiffness, with springs or
    /// dampers in joints and nonlinear ones, and steps under error control, have none.
    pub lasting: bool,
    /// θ ∈ [½, 1] of islands all of whose contacts last. Default 1: what sticks stands still. See [`scheme`](super).
    pub theta_rest: T,
    /// Leave islands of bodies at rest out of the steps until something touches them. Default `false`. It neglects motion
    /// within the tolerance of the cone solver, and nothing else; systems that cannot say what rests
    /// ([`Dynamics::body_dofs`]), with joints or with forces that vary in time compute every step.
    pub sleep: bool,
    /// Opening (m or rad) of a joint against that of the start which a step may leave. `None`, the default, is 64 ε of the
    /// largest coordinate, what the rounding of positions leaves; it never adds up over steps. Looser tolerances save a
    /// pass at most and let joints do work, their percussions times the opening over h: the balance shows it.
    pub joint_tolerance: Option<T>,
}

impl<T: Scalar> Settings<T> {
    /// θ and h, with the paper's active set (55).
    pub fn new(theta: T, step: T) -> Self {
        Self {
            theta,
            step,
            activation: Activation::default(),
            allow_unproved_theta: false,
            lasting: true,
            theta_rest: T::one(),
            sleep: false,
            joint_tolerance: None,
        }
    }
}

pub(super) fn check_settings<T: Scalar>(settings: &Settings<T>) -> Result<(), SetupError> {
    let Settings { theta, step, .. } = *settings;
    if !(T::zero() <= theta && theta <= T::one()) {
        return Err(SetupError::Theta { theta: to_f64(theta) });
    }
    if !(lit::<T>(0.5) <= settings.theta_rest && settings.theta_rest <= T::one()) {
        return Err(SetupError::ThetaRest { theta: to_f64(settings.theta_rest) });
    }
    if !(step > T::zero() && all_finite([&step])) {
        return Err(SetupError::TimeStep { step: to_f64(step) });
    }
    Ok(())
}

/// What rounding takes from θ and from the ends of an interval: 1/(1+e) typed by hand must pass.
pub(crate) fn claim_slack<T: Scalar>() -> T {
    lit::<T>(4.0) * epsilon::<T>()
}

/// Whether an interval that a law claims holds θ, to rounding.
pub(crate) fn claims<T: Scalar>(claimed: &RangeInclusive<T>, theta: T) -> bool {
    let slack = claim_slack::<T>();
    *claimed.start() - slack <= theta && theta <= *claimed.end() + slack
}

pub(super) fn check_laws<T: Scalar, const D: usize>(
    laws: &[Box<dyn ContactLaw<T, D>>],
    interfaces: usize,
    settings: &Settings<T>,
) -> Result<(), SetupError> {
    if laws.len() != interfaces {
        return Err(SetupError::Laws { interfaces, laws: laws.len() });
    }
    let theta = settings.theta;
    for (interface, law) in laws.iter().enumerate() {
        let name = || law.name().to_string();
        if let (Some(claimed), false) = (law.dissipative_theta(), settings.allow_unproved_theta)
            && !claims(&claimed, theta)
        {
            let (theta, min, max) = (to_f64(theta), to_f64(*claimed.start()), to_f64(*claimed.end()));
            return Err(SetupError::UnprovedTheta { law: name(), interface, theta, min, max });
        }
        let memory = vec![T::zero(); law.memory()];
        let at_rest = Approach::impact(SVector::zeros(), theta).with_memory(&memory);
        let Response { gamma, cone, .. } = law.respond(&at_rest);
        let error = |what, value| SetupError::Law { law: name(), what, value, theta: to_f64(theta) };
        if !(gamma > T::zero() && all_finite([&gamma])) {
            return Err(error("γ", to_f64(gamma)));
        }
        for (what, c) in ["μ", "μ_R", "μ_S"].into_iter().zip(cone.coefficients()) {
            if !(c >= T::zero() && all_finite([&c])) {
                return Err(error(what, to_f64(c)));
            }
        }
    }
    Ok(())
}

/// Checks that every operator of the system and the state have one component per degree of freedom, and that the
/// state is finite.
pub(super) fn check_sizes<T: Scalar>(system: &dyn Dynamics<T>, q: &[T], v: &[T]) -> Result<(), SetupError> {
    let expected = system.dofs();
    let sizes = [
        ("mass", system.mass().size()),
        ("damping", system.damping().map_or(expected, Symmetric::size)),
        ("stiffness", system.stiffness().map_or(expected, Symmetric::size)),
        ("force", system.forces().constant_part().len()),
        ("v", v.len()),
        ("prescribed", system.prescribed().map_or(expected, |p| p.first().saturating_add(p.count()))),
    ];
    if let Some(&(what, given)) = sizes.iter().find(|&&(_, given)| given != expected) {
        return Err(SetupError::Size { what, expected, given });
    }
    let (expected, given) = (system.coordinates(), q.len());
    if given != expected {
        return Err(SetupError::Size { what: "q", expected, given });
    }
    let linear = [
        ("stiffness", system.stiffness().is_some()),
        ("prescribed motion", system.prescribed().is_some()),
        ("nonlinear terms", system.nonlinear().is_some()),
    ];
    if (!system.is_flat() || system.flies())
        && let Some(&(what, _)) = linear.iter().find(|&&(_, has)| has)
    {
        return Err(SetupError::Curved { what });
    }
    for (what, x) in [("q", q), ("v", v)] {
        if let Some(component) = x.iter().position(|x| !all_finite([x])) {
            return Err(SetupError::NotFinite { what, component, value: to_f64(x[component]) });
        }
    }
    Ok(())
}

/// Gap of a joint at the start that counts as closed, relative to the length of the scene: drawings are given with
/// some ten digits.
const JOINT_TOLERANCE: f64 = 1e-9;

/// Checks that joints are closed at the start, and θ > 0 where there are any.
pub(super) fn check_joints<T: Scalar>(
    system: &dyn Dynamics<T>,
    settings: &Settings<T>,
    q: &[T],
    length: T,
) -> Result<(), SetupError> {
    let joints = joints_of(system);
    let rows = joints.rows();
    if rows == 0 {
        return Ok(());
    }
    if !(settings.theta > T::zero()) {
        return Err(SetupError::JointsTheta);
    }
    if system.nonlinear().is_some() {
        return Err(SetupError::JointsNonlinear);
    }
    let mut open = vec![T::zero(); rows];
    joints.residual(q, &mut open);
    let larger = nalgebra::RealField::max;
    if let Some(tolerance) = settings.joint_tolerance {
        let rounding = lit::<T>(LEAST_ROUNDING) * epsilon::<T>() * larger(length, max_abs(q));
        if !(tolerance > T::zero() && tolerance >= rounding && all_finite([&tolerance])) {
            let (value, rounding) = (to_f64(tolerance), to_f64(rounding));
            return Err(SetupError::JointTolerance { value, rounding });
        }
    }
    let floor = lit::<T>(ROUNDING) * epsilon::<T>();
    let bound = larger(lit::<T>(JOINT_TOLERANCE), floor) * (length + T::one());
    let bound = larger(bound, settings.joint_tolerance.unwrap_or_else(T::zero));
    let held = |row: usize| joints.law(row, q, T::zero(), settings.step) == RowLaw::Held;
    match (0..rows).find(|&row| held(row) && !(nalgebra::ComplexField::abs(open[row]) <= bound)) {
        Some(row) => Err(SetupError::JointOpen { joint: joints.label(row), by: to_f64(open[row]) }),
        None => Ok(()),
    }
}

/// The tolerances of the active set in this system, (gap, velocity).
pub(super) fn tolerances<T: Scalar>(
    activation: &Activation<T>,
    solver_tolerance: T,
    system: &dyn Dynamics<T>,
    q: &[T],
    v: &[T],
) -> Result<(T, T), SetupError> {
    let scales = system.scales(q, v);
    let tolerances = activation.tolerances(scales, solver_tolerance);
    // Gaps are differences of positions, u_N of a closed contact is what the solver leaves.
    let least = [
        ("gap", tolerances.0, epsilon::<T>() * scales.length),
        ("velocity", tolerances.1, nalgebra::RealField::max(solver_tolerance, epsilon()) * scales.speed),
    ];
    for (what, value, least) in least {
        if !(value >= least && value > T::zero() && all_finite([&value])) {
            return Err(SetupError::ActivationTolerance { what, value: to_f64(value), least: to_f64(least) });
        }
    }
    Ok(tolerances)
}
