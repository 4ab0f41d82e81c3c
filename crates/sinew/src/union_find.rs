//! Union-find: which of many things belong together, as a list of parents in which the root of each set is its smallest member.

/// Sets of numbers from 0 on.
#[derive(Clone, Debug, Default)]
pub(crate) struct UnionFind {
    parent: Vec<u32>,
}

impl UnionFind {
    /// Lets every one of so many stand alone.
    pub(crate) fn reset(&mut self, count: usize) {
        self.parent.clear();
        self.parent.extend(0..count as u32);
    }

    /// Has so many: those that are new stand alone, and with those that are gone nobody may be who stays.
    pub(crate) fn resize(&mut self, count: usize) {
        let had = self.parent.len();
        self.parent.truncate(count);
        self.parent.extend(had as u32..count as u32);
    }

    /// Lets some stand alone again, with whom nobody else is.
    pub(crate) fn part(&mut self, these: &[u32]) {
        for &one in these {
            self.parent[one as usize] = one;
        }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.parent.len()
    }

    /// Joins the sets of two.
    pub(crate) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The smallest one of a set, shortening the way for the next time (path halving).
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
