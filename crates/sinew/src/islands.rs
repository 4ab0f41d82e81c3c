//! Islands: particles that constraints connect, found by union-find. Each is solved by itself, with settings of its own; contacts ask who is in which.

use core::ops::Range;

use crate::settings::SolverSettings;
use crate::union_find::UnionFind;

/// The islands of a world. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Islands {
    /// In the order of their first particles. Every particle is in one.
    pub(crate) list: Vec<Island>,
    /// The rows of the particles, island after island, ascending in each.
    pub(crate) members: Vec<u32>,
    /// The number of each particle's island.
    pub(crate) of: Vec<u32>,
    /// For each island whether it is dormant: asleep as in the last step, without anything being done to it. Empty, with the number 0, where none is; and as
    /// long as the number is another one, the same are.
    pub(crate) dormant: Vec<bool>,
    pub(crate) dormant_number: u64,
}

/// Particles that constraints connect, and those constraints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Island {
    /// Where its groups are among the plan's.
    pub(crate) groups: Range<usize>,
    /// Where its cluster batches are.
    pub(crate) cluster_batches: Range<usize>,
    /// Where its particles are among the plan's members.
    pub(crate) members: Range<usize>,
    /// Whether a compound in it moves as an explicit rigid body, which keeps its own momenta.
    pub(crate) rigid: bool,
    /// Whether a constraint in it may hold on to the world ([`Equation::is_internal`](crate::constraints::Equation::is_internal)).
    pub(crate) external: bool,
    /// Whether all its particles have one origin in this step.
    pub(crate) one_origin: bool,
    /// Whether nothing outside holds it in this step: its constraints are among its own particles, of which none is pinned.
    pub(crate) free: bool,
    /// Whether it sleeps through this step.
    pub(crate) asleep: bool,
    /// Whether loads of constraints in it are measured, so that it is solved by itself.
    pub(crate) measured: bool,
    /// Whether it moves as one rigid state in this step: its constraints are not swept, and its particles follow.
    pub(crate) one_state: bool,
    /// Where its chains are among the plan's.
    pub(crate) chains: Range<usize>,
    /// Which of the plan's tethers are its own.
    pub(crate) tethers: Option<u32>,
    /// Which of the plan's spans are its own.
    pub(crate) spans: Option<u32>,
    /// Whether a part of it collides as a rigid shape.
    pub(crate) has_solids: bool,
    /// Whether a spring pulls on it in this step.
    pub(crate) has_springs: bool,
    /// How it is solved in this step: the world's settings, and those of the bodies in it; the sweeps are those of a microstep.
    pub(crate) settings: SolverSettings,
    /// The microsteps that it takes in each substep, 1 or more.
    pub(crate) microsteps: u32,
}

impl Island {
    /// Whether nobody is to sweep its constraints in this step.
    pub(crate) fn is_left_alone(&self) -> bool {
        self.asleep || self.one_state
    }

    /// Whether chains in it are solved at once. Where everything walks to rest sweeps do: with them a rope between two pins still moved by micrometres after
    /// 20 000 such steps.
    pub(crate) fn has_chains(&self) -> bool {
        self.settings.long_range && !self.settings.statics && !self.chains.is_empty()
    }

    /// Whether it goes through each substep in several microsteps.
    pub(crate) fn takes_microsteps(&self) -> bool {
        self.microsteps > 1 && !self.is_left_alone()
    }
}

impl Islands {
    /// Numbers the sets of connected particles by their first ones, and lists the members of each, ascending.
    pub(crate) fn number(&mut self, connected: &mut UnionFind) {
        let Self { list, members, of, .. } = self;
        let particles = connected.len();
        list.clear();
        of.clear();
        for row in 0..particles as u32 {
            let first = connected.root(row);
            let number = if first == row {
                list.push(Island::default());
                list.len() as u32 - 1
            } else {
                of[first as usize]
            };
            of.push(number);
            list[number as usize].members.end += 1;
        }
        let mut begin = 0;
        for island in list.iter_mut() {
            let count = island.members.end;
            island.members = begin..begin;
            begin += count;
        }
        members.clear();
        members.resize(particles, 0);
        for (row, &number) in of.iter().enumerate() {
            let span = &mut list[number as usize].members;
            members[span.end] = row as u32;
            span.end += 1;
        }
    }
}
