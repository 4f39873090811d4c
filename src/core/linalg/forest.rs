//! Sets that are joined two by two: a forest of parents, each tree of which is a set.

/// The smallest member of the set of `i`, on the way to which the paths are halved.
pub(crate) fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// Joins the sets of `one` and `other`; whether they were two. The smallest member stands for the whole.
pub(crate) fn join(parent: &mut [usize], one: usize, other: usize) -> bool {
    let (one, other) = (root(parent, one), root(parent, other));
    parent[one.max(other)] = one.min(other);
    one != other
}
