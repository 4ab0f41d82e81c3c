//! Islands: particles that constraints connect, found by union-find.

use super::Island;
use crate::union_find::{root, unite};

/// The islands of a world, in the order of their first particles. Every particle is in one.
#[derive(Clone, Debug, Default)]
pub(super) struct Connected {
    /// Towards the first particle of the island.
    parent: Vec<u32>,
}

impl Connected {
    /// Lets every one of so many particles stand alone.
    pub(super) fn reset(&mut self, particles: usize) {
        self.parent.clear();
        self.parent.extend(0..particles as u32);
    }

    /// Joins the islands of two particles, towards the smaller row, so that the root of an island is its first particle.
    pub(super) fn unite(&mut self, a: u32, b: u32) {
        unite(&mut self.parent, a, b);
    }

    /// Numbers the islands by their first particles, and lists the members of each, ascending.
    pub(super) fn number(
        &mut self,
        islands: &mut Vec<Island>,
        island_of: &mut Vec<u32>,
        members: &mut Vec<u32>,
    ) {
        let particles = self.parent.len();
        islands.clear();
        island_of.clear();
        for row in 0..particles as u32 {
            let first = root(&mut self.parent, row);
            let number = if first == row {
                islands.push(Island::default());
                islands.len() as u32 - 1
            } else {
                island_of[first as usize]
            };
            island_of.push(number);
            islands[number as usize].members.end += 1;
        }
        let mut begin = 0;
        for island in islands.iter_mut() {
            let count = island.members.end;
            island.members = begin..begin;
            begin += count;
        }
        members.clear();
        members.resize(particles, 0);
        for (row, &number) in island_of.iter().enumerate() {
            let span = &mut islands[number as usize].members;
            members[span.end] = row as u32;
            span.end += 1;
        }
    }
}
