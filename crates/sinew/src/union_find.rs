//! Union-find: which of many things belong together, as a list of parents in which the root of each set is its smallest member.

/// Joins the sets of two.
pub(crate) fn unite(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

/// The smallest one of a set, shortening the way for the next time (path halving).
pub(crate) fn root(parent: &mut [u32], mut member: u32) -> u32 {
    while parent[member as usize] != member {
        let up = parent[parent[member as usize] as usize];
        parent[member as usize] = up;
        member = up;
    }
    member
}
