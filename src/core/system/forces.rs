//! External forces: a constant part, which has a potential, and a part that varies in time.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use super::Signal;
use crate::scalar::Scalar;

type Varying<T> = Arc<dyn Fn(T, &mut [T]) + Send + Sync>;

/// A signal with the forces that it scales, by degree of freedom.
pub(super) type Load<T> = (Signal<T>, Vec<(usize, T)>);

/// A part that varies in time, with the degrees of freedom it acts on.
type Part<T> = (Range<usize>, Varying<T>);

/// F(t) = F₀ + F₁(t), generalised forces (N, N m).
#[derive(Clone)]
pub struct Forces<T: Scalar> {
    constant: Vec<T>,
    loads: Vec<Load<T>>,
    varying: Vec<Part<T>>,
}

impl<T: Scalar> Forces<T> {
    /// A constant force; its potential is −F₀·q.
    pub fn constant(force: Vec<T>) -> Self {
        Self { constant: force, loads: Vec::new(), varying: Vec::new() }
    }

    /// Adds the forces `entries`, (degree of freedom, force), times a signal.
    #[must_use]
    pub fn with_load(mut self, signal: Signal<T>, entries: Vec<(usize, T)>) -> Self {
        self.loads.push((signal, entries));
        self
    }

    /// Adds a part that varies smoothly in time: `add(t, f)` adds F₁(t) to `f`. One that jumps is a
    /// [`load`](Self::with_load), whose signal knows where.
    #[must_use]
    pub fn with_varying(mut self, add: impl Fn(T, &mut [T]) + Send + Sync + 'static) -> Self {
        let all = 0..self.constant.len();
        self.varying.push((all, Arc::new(add)));
        self
    }

    /// The forces on several systems, whose degrees of freedom stand one after another.
    pub(super) fn joined(all: impl Iterator<Item = Self>) -> Self {
        let mut joined = Self::constant(Vec::new());
        for Self { constant, loads, varying } in all {
            let first = joined.constant.len();
            joined.constant.extend(constant);
            for (signal, entries) in loads {
                let entries = entries.into_iter().map(|(dof, load)| (first + dof, load)).collect();
                joined.loads.push((signal, entries));
            }
            let shifted = |dofs: &Range<usize>| first + dofs.start..first + dofs.end;
            joined.varying.extend(varying.into_iter().map(|(dofs, add)| (shifted(&dofs), add)));
        }
        joined
    }

    /// F₀.
    pub fn constant_part(&self) -> &[T] {
        &self.constant
    }

    /// Whether a part varies in time.
    pub fn varies(&self) -> bool {
        !self.varying.is_empty() || !self.loads.is_empty()
    }

    /// The first time after `time` at which a signal jumps or has a kink.
    pub fn next_break(&self, time: T) -> Option<T> {
        let breaks = self.loads.iter().filter_map(|(signal, _)| signal.next_break(time));
        breaks.reduce(|first, other| if other < first { other } else { first })
    }

    /// force ← F(t).
    pub fn at(&self, time: T, force: &mut [T]) {
        self.add_up(time, force, |signal| signal.at(time));
    }

    /// force ← F(t) with every signal continued smoothly from where it is at `inside`: the limits of F at both ends of
    /// a stretch between [breaks](Self::next_break).
    pub fn continued(&self, time: T, inside: T, force: &mut [T]) {
        self.add_up(time, force, |signal| signal.continued(time, inside));
    }

    fn add_up(&self, time: T, force: &mut [T], value: impl Fn(&Signal<T>) -> T) {
        force.copy_from_slice(&self.constant);
        for (signal, entries) in &self.loads {
            let value = value(signal);
            entries.iter().for_each(|&(dof, load)| force[dof] += value * load);
        }
        for (dofs, add) in &self.varying {
            add(time, &mut force[dofs.clone()]);
        }
    }

    /// force ← F_{k+θ} = (1−θ) F(t) + θ F(t + h); `scratch` has the same size.
    pub fn averaged(&self, time: T, step: T, theta: T, force: &mut [T], scratch: &mut [T]) {
        self.at(time, force);
        if self.varies() {
            self.at(time + step, scratch);
            let other = T::one() - theta;
            force.iter_mut().zip(&*scratch).for_each(|(f, &g)| *f = other * *f + theta * g);
        }
    }

    /// −F₀·q, the potential of the constant part.
    pub fn potential(&self, q: &[T]) -> T {
        -crate::linalg::dot(&self.constant, q)
    }
}

impl<T: Scalar> fmt::Debug for Forces<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Forces").field("constant", &self.constant).field("varies", &self.varies()).finish()
    }
}
