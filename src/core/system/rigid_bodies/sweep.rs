//! Sweep and prune: the pairs of contactors whose bounding circles can be near each other.

use nalgebra::Vector2;

use crate::scalar::{Scalar, lit};

/// Bounding circles in the order of their lower ends along an axis, kept from step to step: insertion sort then is
/// nearly linear. The axis is the one along which the scene is longer.
#[derive(Debug)]
pub(super) struct Sweep<T: Scalar> {
    entries: Vec<Entry<T>>,
    axis: usize,
}

#[derive(Debug, Clone, Copy)]
struct Entry<T: Scalar> {
    contactor: usize,
    centre: Vector2<T>,
    radius: T,
    low: T,
    high: T,
}

impl<T: Scalar> Sweep<T> {
    pub(super) fn new(contactors: impl Iterator<Item = usize>) -> Self {
        let zero = T::zero();
        let entry =
            |contactor| Entry { contactor, centre: Vector2::zeros(), radius: zero, low: zero, high: zero };
        Self { entries: contactors.map(entry).collect(), axis: 0 }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Moves every circle to its (centre, radius) and restores the order.
    pub(super) fn update(&mut self, circle: impl Fn(usize) -> (Vector2<T>, T)) {
        let (mut least, mut most) = (None::<Vector2<T>>, None::<Vector2<T>>);
        for entry in &mut self.entries {
            let (centre, radius) = circle(entry.contactor);
            (entry.centre, entry.radius) = (centre, radius);
            least = Some(least.map_or(centre, |x| x.inf(&centre)));
            most = Some(most.map_or(centre, |x| x.sup(&centre)));
        }
        if let (Some(least), Some(most)) = (least, most) {
            let extent = most - least;
            let other = 1 - self.axis;
            // A factor of two, so that a square scene keeps its axis.
            if extent[other] > extent[self.axis] * lit::<T>(2.0) {
                self.axis = other;
            }
        }
        for entry in &mut self.entries {
            entry.low = entry.centre[self.axis] - entry.radius;
            entry.high = entry.centre[self.axis] + entry.radius;
        }
        for i in 1..self.entries.len() {
            let mut j = i;
            while j > 0 && self.entries[j].low < self.entries[j - 1].low {
                self.entries.swap(j, j - 1);
                j -= 1;
            }
        }
    }

    /// Calls `near(i, j, (centre i, centre j))`, i < j, for every pair whose extents come within `reach`.
    pub(super) fn for_each_near_pair(
        &self,
        reach: T,
        mut near: impl FnMut(usize, usize, (Vector2<T>, Vector2<T>)),
    ) {
        let other = 1 - self.axis;
        for (k, a) in self.entries.iter().enumerate() {
            for b in self.entries[k + 1..].iter().take_while(|b| !(b.low > a.high + reach)) {
                let apart = nalgebra::ComplexField::abs(a.centre[other] - b.centre[other]);
                if apart > a.radius + b.radius + reach {
                    continue;
                }
                if a.contactor < b.contactor {
                    near(a.contactor, b.contactor, (a.centre, b.centre));
                } else {
                    near(b.contactor, a.contactor, (b.centre, a.centre));
                }
            }
        }
    }
}
