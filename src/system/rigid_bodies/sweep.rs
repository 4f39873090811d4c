//! Sweep and prune along x: the pairs of discs that can be near each other.

use nalgebra::Vector2;

use crate::scalar::Scalar;

/// Discs in the order of their left ends, kept from step to step: insertion sort then is nearly linear.
#[derive(Debug)]
pub(super) struct Sweep<T: Scalar> {
    entries: Vec<Entry<T>>,
}

#[derive(Debug, Clone, Copy)]
struct Entry<T: Scalar> {
    contactor: usize,
    centre: Vector2<T>,
    left: T,
    right: T,
}

impl<T: Scalar> Sweep<T> {
    pub(super) fn new(contactors: impl Iterator<Item = usize>) -> Self {
        let zero = T::zero();
        let entry = |contactor| Entry { contactor, centre: Vector2::zeros(), left: zero, right: zero };
        Self { entries: contactors.map(entry).collect() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Moves every disc to its (centre, radius) and restores the order.
    pub(super) fn update(&mut self, disc: impl Fn(usize) -> (Vector2<T>, T)) {
        for entry in &mut self.entries {
            let (centre, radius) = disc(entry.contactor);
            *entry = Entry { centre, left: centre.x - radius, right: centre.x + radius, ..*entry };
        }
        for i in 1..self.entries.len() {
            let mut j = i;
            while j > 0 && self.entries[j].left < self.entries[j - 1].left {
                self.entries.swap(j, j - 1);
                j -= 1;
            }
        }
    }

    /// Calls `near(i, j, (centre i, centre j))`, i < j, for every pair whose extents along x come within `reach`.
    pub(super) fn for_each_near_pair(
        &self,
        reach: T,
        mut near: impl FnMut(usize, usize, (Vector2<T>, Vector2<T>)),
    ) {
        for (k, a) in self.entries.iter().enumerate() {
            for b in self.entries[k + 1..].iter().take_while(|b| !(b.left > a.right + reach)) {
                if a.contactor < b.contactor {
                    near(a.contactor, b.contactor, (a.centre, b.centre));
                } else {
                    near(b.contactor, a.contactor, (b.centre, a.centre));
                }
            }
        }
    }
}
