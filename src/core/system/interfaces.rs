//! Which groups of shapes touch each other.

use super::SystemError;

/// A group of contactors and half-planes: interfaces are declared between groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroupId(pub(super) usize);

/// Interfaces between groups, a symmetric table.
#[derive(Debug)]
pub(super) struct Interfaces {
    groups: usize,
    table: Vec<Option<usize>>,
    pub(super) count: usize,
}

impl Interfaces {
    pub(super) fn new(groups: usize, pairs: &[(usize, usize)]) -> Self {
        let mut table = vec![None; groups * groups];
        for (interface, &(a, b)) in pairs.iter().enumerate() {
            table[a * groups + b] = Some(interface);
            table[b * groups + a] = Some(interface);
        }
        Self { groups, table, count: pairs.len() }
    }

    #[inline]
    pub(super) fn between(&self, a: usize, b: usize) -> Option<usize> {
        self.table[a * self.groups + b]
    }
}

/// The place of the pair in a list of interfaces, added where it is new.
pub(super) fn declare(pairs: &mut Vec<(usize, usize)>, a: usize, b: usize) -> usize {
    let pair = (a.min(b), a.max(b));
    pairs.iter().position(|&p| p == pair).unwrap_or_else(|| {
        pairs.push(pair);
        pairs.len() - 1
    })
}

/// An index that names one of `count`.
pub(super) fn known(what: &'static str, index: usize, count: usize) -> Result<usize, SystemError> {
    if index < count { Ok(index) } else { Err(SystemError::Unknown { what, index, count }) }
}
