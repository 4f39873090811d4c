//! A system says the same with all its tongues: gaps and Jacobians, joints and their rows, forces and potentials.

use nalgebra::DMatrix;
use proptest::strategy::{Strategy, ValueTree};

use super::{Suite, SuiteFailure};
use crate::contact::ContactId;
use crate::linalg::{BlockRows, Factor, Symmetric};
use crate::system::System;

/// Length of the central differences, as a share of the scene: its error, of the order of its square, and the rounding of
/// the difference, ε over it, are both far below [`SLOPE`].
const DIFFERENCE: f64 = 1e-5;

/// How far a derivative may be from the difference, as a share of the larger of both and 1.
const SLOPE: f64 = 1e-6;

/// Rounding of what should hold exactly, as a share of its terms.
const EXACT: f64 = 1e-11;

/// Tests a system in configurations near (q, v): every array has the size it should have, M is positive definite, and
///
/// - q ⊕ 0 = q, and [`difference`](crate::system::Dynamics::difference) undoes
///   [`advance`](crate::system::Dynamics::advance);
/// - every candidate is named once, its gap is that of [`gap`](crate::system::Contacts::gap), and H_N is the derivative of
///   the gap along any motion;
/// - φ(q ⊕ s) − φ(q) = Ḡ(q, s) s to rounding, for every joint;
/// - −F₀ is the derivative of the potential of the constant forces, and the nonlinear terms are derivatives of theirs.
///
/// Contacts are sought up to the gap `reach` (m), and motions are random, of `size` (m and rad) in every component: small
/// against the distances over which the closest features change.
///
/// # Errors
/// [`SuiteFailure`] with the numbers of the first property that does not hold.
pub fn check_system<const D: usize>(
    suite: &Suite,
    system: &mut dyn System<f64, D>,
    (q, v): (&[f64], &[f64]),
    (reach, size): (f64, f64),
) -> Result<(), SuiteFailure> {
    let n = system.dofs();
    let check = Check::<D> { size };
    check.sizes(system, q, v)?;
    let mut runner = suite.runner();
    let motions = proptest::collection::vec(-size..size, 2 * n);
    for _ in 0..suite.cases {
        let drawn = motions.new_tree(&mut runner).expect("a range has values").current();
        let (to, along) = drawn.split_at(n);
        let mut place = vec![0.0; q.len()];
        system.advance(q, to, &mut place);
        check.motions(system, &place, along)?;
        check.contacts(system, &place, along, reach)?;
        check.joints(system, &place, along)?;
        check.potentials(system, &place, along)?;
    }
    Ok(())
}

struct Check<const D: usize> {
    size: f64,
}

impl<const D: usize> Check<D> {
    fn fail(&self, property: &'static str, case: String) -> Result<(), SuiteFailure> {
        Err(SuiteFailure { property, dimension: D, solver: "–".into(), case })
    }

    fn sizes(&self, system: &dyn System<f64, D>, q: &[f64], v: &[f64]) -> Result<(), SuiteFailure> {
        let n = system.dofs();
        let told = system.prescribed();
        let sizes = [
            ("q", q.len(), system.coordinates()),
            ("v", v.len(), n),
            ("M", system.mass().size(), n),
            ("C", system.damping().map_or(n, Symmetric::size), n),
            ("K", system.stiffness().map_or(n, Symmetric::size), n),
            ("F", system.forces().constant_part().len(), n),
            ("what is prescribed", told.map_or(n, |told| told.first() + told.count()), n),
        ];
        if let Some((what, given, expected)) = sizes.iter().find(|(_, given, expected)| given != expected) {
            return self.fail("sizes agree", format!("{what} has {given} components, not {expected}"));
        }
        // What moves as told may have no mass.
        let free = told.map_or(n, |told| told.first().min(n));
        if let Err(error) = Factor::new(&system.mass().leading(free)) {
            return self.fail("M is positive definite", error.to_string());
        }
        let scales = system.scales(q, v);
        if !(scales.length > 0.0 && scales.speed > 0.0) {
            return self.fail("scales are positive", format!("{scales:?}"));
        }
        Ok(())
    }

    fn motions(&self, system: &dyn System<f64, D>, q: &[f64], s: &[f64]) -> Result<(), SuiteFailure> {
        let scale = q.iter().fold(self.size, |most, x| most.max(x.abs()));
        let (mut to, mut back) = (vec![0.0; q.len()], vec![0.0; s.len()]);
        system.advance(q, &vec![0.0; s.len()], &mut to);
        if let Some(i) = (0..q.len()).find(|&i| !((to[i] - q[i]).abs() <= EXACT * scale)) {
            return self.fail("q ⊕ 0 = q", format!("component {i}: {} for {}", to[i], q[i]));
        }
        system.advance(q, s, &mut to);
        system.difference(q, &to, &mut back);
        match (0..s.len()).find(|&i| !((back[i] - s[i]).abs() <= EXACT * scale)) {
            Some(i) => {
                self.fail("the difference undoes the motion", format!("{i}: {} for {}", back[i], s[i]))
            }
            None => Ok(()),
        }
    }

    /// (f(q ⊕ εs) − f(q ⊖ εs))/2ε.
    fn slope(&self, system: &dyn System<f64, D>, q: &[f64], s: &[f64], f: &dyn Fn(&[f64]) -> f64) -> f64 {
        let at = |epsilon: f64| {
            let (mut place, motion) = (vec![0.0; q.len()], s.iter().map(|s| epsilon * s).collect::<Vec<_>>());
            system.advance(q, &motion, &mut place);
            f(&place)
        };
        (at(DIFFERENCE) - at(-DIFFERENCE)) / (2.0 * DIFFERENCE)
    }

    fn contacts(
        &self,
        system: &mut dyn System<f64, D>,
        q: &[f64],
        s: &[f64],
        reach: f64,
    ) -> Result<(), SuiteFailure> {
        let mut found = Vec::new();
        system.candidates(q, reach, &mut found);
        let mut ids: Vec<ContactId> = found.iter().map(|candidate| candidate.id).collect();
        ids.sort_unstable();
        if let Some(twice) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
            return self.fail("a candidate is named once", system.contact_label(twice[0]));
        }
        let mut rows = BlockRows::<f64, D>::new();
        for candidate in found {
            let label = system.contact_label(candidate.id);
            if candidate.interface >= system.interfaces() {
                let case = format!("{label}: interface {} of {}", candidate.interface, system.interfaces());
                return self.fail("interfaces exist", case);
            }
            let gap = system.gap(candidate.id, q);
            let scale = q.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            if !((gap - candidate.gap).abs() <= EXACT * scale) {
                return self.fail("a gap is one", format!("{label}: {gap} for {}", candidate.gap));
            }
            rows.clear();
            system.jacobian(candidate.id, q, &mut rows);
            if rows.rows() != 1 || rows.largest_column(0).is_some_and(|column| column >= s.len()) {
                return self.fail("a Jacobian is one block row over v", label);
            }
            let rate = rows.velocity(0, s)[0];
            let slope = self.slope(system, q, s, &|q| system.gap(candidate.id, q));
            if !((rate - slope).abs() <= SLOPE * self.size.max(rate.abs())) {
                return self.fail("H_N is the derivative of the gap", format!("{label}: {rate} for {slope}"));
            }
        }
        Ok(())
    }

    fn joints(&self, system: &dyn System<f64, D>, q: &[f64], s: &[f64]) -> Result<(), SuiteFailure> {
        let Some(joints) = system.joints() else { return Ok(()) };
        let (mut rows, mut to) = (BlockRows::<f64, 1>::new(), vec![0.0; q.len()]);
        let (mut before, mut after) = (vec![0.0; joints.rows()], vec![0.0; joints.rows()]);
        joints.jacobian(q, s, &mut rows);
        system.advance(q, s, &mut to);
        joints.residual(q, &mut before);
        joints.residual(&to, &mut after);
        if rows.rows() != joints.rows() {
            return self.fail("joints have their rows", format!("{} for {}", rows.rows(), joints.rows()));
        }
        let scale = q.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
        for i in 0..joints.rows() {
            let (by, rate) = (after[i] - before[i], rows.velocity(i, s)[0]);
            if !((by - rate).abs() <= EXACT * scale) {
                let case = format!("{}: {rate} for {by}", joints.label(i));
                return self.fail("Ḡ is the discrete derivative of the joints", case);
            }
        }
        Ok(())
    }

    fn potentials(&self, system: &dyn System<f64, D>, q: &[f64], s: &[f64]) -> Result<(), SuiteFailure> {
        let n = s.len();
        let force = system.forces().constant_part();
        let work: f64 = force.iter().zip(s).map(|(f, s)| f * s).sum();
        let slope = self.slope(system, q, s, &|q| system.potential(q));
        let size: f64 = force.iter().map(|f| f.abs() * self.size).sum();
        // The potential itself is rounded, ε|V| over the length of the difference.
        let rounding = EXACT * system.potential(q).abs() / DIFFERENCE;
        if !((work + slope).abs() <= SLOPE * size + rounding) {
            return self.fail("−F₀ is the derivative of its potential", format!("{work} for {}", -slope));
        }
        let Some(terms) = system.nonlinear() else { return Ok(()) };
        let (mut gradient, mut mass) = (vec![0.0; n], DMatrix::zeros(n, n));
        terms.potential_gradient(q, &mut gradient);
        let rate: f64 = gradient.iter().zip(s).map(|(g, s)| g * s).sum();
        let slope = self.slope(system, q, s, &|q| terms.potential(q));
        let rounding = EXACT * terms.potential(q).abs() / DIFFERENCE;
        if !((rate - slope).abs() <= SLOPE * self.size.max(rate.abs()) + rounding) {
            return self.fail("∇V is the derivative of V", format!("{rate} for {slope}"));
        }
        let mut derivative = DMatrix::zeros(n, n);
        let mut sum = DMatrix::zeros(n, n);
        for (i, &s) in s.iter().enumerate() {
            terms.mass_derivative(q, i, &mut derivative);
            sum += &derivative * s;
        }
        terms.mass(q, &mut mass);
        let largest = mass.amax();
        for i in 0..n {
            for j in 0..n {
                let slope = self.slope(system, q, s, &|q| {
                    let mut mass = DMatrix::zeros(n, n);
                    terms.mass(q, &mut mass);
                    mass[(i, j)]
                });
                if !((sum[(i, j)] - slope).abs() <= SLOPE * largest * self.size.max(1e-3)) {
                    let case = format!("M_{i}{j}: {} for {slope}", sum[(i, j)]);
                    return self.fail("∂M is the derivative of M", case);
                }
            }
        }
        Ok(())
    }
}
