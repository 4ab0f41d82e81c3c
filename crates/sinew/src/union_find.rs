//! Union-find: disjoint sets of indices, as a list of parents in which the root of each set is its smallest member.

/// Disjoint sets of the indices from 0 on.
#[derive(Clone, Debug, Default)]
pub(crate) struct UnionFind {
    parent: Vec<u32>,
}

impl UnionFind {
    /// Makes `count` sets of one member each.
    pub(crate) fn reset(&mut self, count: usize) {
        self.parent.clear();
        self.parent.extend(0..count as u32);
    }

    /// Changes the number of indices. New ones are sets of one member; no index that stays may be in a set with one that is removed.
    pub(crate) fn resize(&mut self, count: usize) {
        let had = self.parent.len();
        self.parent.truncate(count);
        self.parent.extend(had as u32..count as u32);
    }

    /// Makes each of these indices a set of its own again. No other index may be in a set with one of them.
    pub(crate) fn isolate(&mut self, these: &[u32]) {
        for &one in these {
            self.parent[one as usize] = one;
        }
    }

    /// Number of indices.
    pub(crate) fn len(&self) -> usize {
        self.parent.len()
    }

    /// Joins the sets of `a` and `b`.
    pub(crate) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The root of a set: its smallest member. Shortens the path for the next call (path halving).
    pub(crate) fn root(&mut self, mut member: u32) -> u32 {
        let parent = &mut self.parent;
        while parent[member as usize] != member {
            let up = parent[parent[member as usize] as usize];
            parent[member as usize] = up;
            member = up;
        }
        member
    }
}
