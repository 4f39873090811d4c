//! What laws remember of contacts, from one accepted step to the next.

use super::ContactStep;
use crate::contact::ContactId;
use crate::laws::{ContactLaw, Passage};
use crate::scalar::{Scalar, all_finite, lit, to_f64};

/// The numbers of every contact whose law [remembers](ContactLaw::remember), from its first step on and for good: a ball
/// that comes back is the ball that left. Empty, and without cost, where no law remembers.
#[derive(Debug, Clone)]
pub(super) struct Memories<T> {
    /// Numbers per contact, by interface.
    counts: Vec<usize>,
    /// Contacts, ordered by identity, with the place of their numbers.
    places: Vec<(ContactId, usize)>,
    numbers: Vec<T>,
    /// What a contact begins with, for the law that remembers most.
    zeros: Vec<T>,
}

/// [`Memories`] as plain numbers.
pub(super) type MemoryMark = Vec<(ContactId, Vec<f64>)>;

impl<T: Scalar> Memories<T> {
    pub(super) fn new<const D: usize>(laws: &[Box<dyn ContactLaw<T, D>>]) -> Self {
        let counts: Vec<usize> = laws.iter().map(|law| law.memory()).collect();
        let most = counts.iter().copied().max().unwrap_or(0);
        Self { counts, places: Vec::new(), numbers: Vec::new(), zeros: vec![T::zero(); most] }
    }

    fn place(&self, id: ContactId) -> Result<usize, usize> {
        self.places.binary_search_by_key(&id, |&(id, _)| id)
    }

    /// The memory of a contact of interface `interface`.
    #[inline]
    pub(super) fn of(&self, id: ContactId, interface: usize) -> &[T] {
        if self.zeros.is_empty() {
            return &[];
        }
        let count = self.counts[interface];
        match self.place(id) {
            Ok(place) => &self.numbers[self.places[place].1..][..count],
            Err(_) => &self.zeros[..count],
        }
    }

    /// Lets the laws take note of an accepted step.
    pub(super) fn accept<const D: usize>(
        &mut self,
        laws: &[Box<dyn ContactLaw<T, D>>],
        contacts: &[ContactStep<T, D>],
        step: T,
    ) {
        if self.zeros.is_empty() {
            return;
        }
        for contact in contacts {
            let count = self.counts[contact.interface];
            if count == 0 {
                continue;
            }
            let place = self.place(contact.id).unwrap_or_else(|place| {
                self.places.insert(place, (contact.id, self.numbers.len()));
                self.numbers.resize(self.numbers.len() + count, T::zero());
                place
            });
            let ContactStep { before, after, percussion, theta, .. } = *contact;
            let done = Passage::impact(before, after, percussion, theta);
            let done = done.with_gap(contact.gap, step, contact.lasting);
            let memory = &mut self.numbers[self.places[place].1..][..count];
            laws[contact.interface].remember(&done, memory);
        }
    }

    /// Becomes `other`, in the memory at hand.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.places.clone_from(&other.places);
        self.numbers.clone_from(&other.numbers);
    }

    pub(super) fn mark(&self) -> MemoryMark {
        let end = |k: usize| {
            let next = self.places.iter().map(|&(_, place)| place).filter(|&place| place > self.places[k].1);
            next.min().unwrap_or(self.numbers.len())
        };
        let numbers = |k: usize| self.numbers[self.places[k].1..end(k)].iter().map(|&x| to_f64(x)).collect();
        self.places.iter().enumerate().map(|(k, &(id, _))| (id, numbers(k))).collect()
    }

    /// `None` where the numbers are not those of these laws.
    pub(super) fn restore(&mut self, mark: &MemoryMark) -> Option<()> {
        let ordered = mark.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let known = |numbers: &[f64]| self.counts.contains(&numbers.len()) && all_finite(numbers);
        if !ordered || !mark.iter().all(|(_, numbers)| known(numbers)) {
            return None;
        }
        self.places.clear();
        self.numbers.clear();
        for (id, numbers) in mark {
            self.places.push((*id, self.numbers.len()));
            self.numbers.extend(numbers.iter().map(|&x| lit::<T>(x)));
        }
        Some(())
    }
}
