//! Limit of the speed at which particles leave a substep in which a body collider was deep in something.
//!
//! Meanwhile the constraints that hold it there, pins and joint limits, yield more and more, and when they return at once they fling all of its particles. So
//! the particles of islands with so deep a body collider get no faster than the fastest one was, or than overlap is recovered. An impact of two bodies makes
//! none faster than that. The removed momentum is distributed over all particles of the islands that were deep in each other, so that their momentum is kept;
//! islands deep in static geometry give it to that.

use glam::Vec3;

use super::BodyContactSolver;
use crate::islands::Islands;
use crate::lanes::LANES;
use crate::particles::Particles;

/// Islands with deep overlaps in a substep. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct DeepOverlaps {
    /// Islands, and the set of islands deep in each other that each belongs to; sorted by island.
    islands: Vec<(u32, u32)>,
    /// Two islands that are deep in each other; no second one for static geometry.
    pairs: Vec<(u32, Option<u32>)>,
    /// By the number of a set.
    sets: Vec<DeepSet>,
    /// Numbers of sets with the rows of their particles, ascending.
    rows: Vec<(u32, u32)>,
}

#[derive(Clone, Copy, Debug, Default)]
struct DeepSet {
    /// Whether an island of the set is deep in static geometry.
    held: bool,
    /// Speed limit of its particles, m/s.
    most: f32,
}

impl BodyContactSolver {
    /// Lists the islands with a body collider deeper than `depth` metres, and the speed limit of their particles in this substep: the speed at which overlap
    /// is recovered, or the fastest particle's speed plus what gravity gives, both m/s.
    pub(super) fn note_deep_overlaps(
        &mut self,
        particles: &Particles,
        islands: &Islands,
        depth: f32,
        (recovery, gained): (f32, f32),
    ) {
        let Self { wide_contacts, groups, deep_overlaps, .. } = self;
        deep_overlaps.clear();
        let island_of = |row: u32| groups.island_of(row, islands);
        for wide in wide_contacts.iter().filter(|wide| wide.depenetrated != 0) {
            for lane in (0..LANES).filter(|&lane| wide.remaining_overlap[lane] > depth) {
                let (a, b) = (island_of(wide.a[lane]), island_of(wide.b[lane]));
                deep_overlaps.pairs.extend(a.map(|a| (a, b)));
            }
        }
        if deep_overlaps.pairs.is_empty() {
            return;
        }
        deep_overlaps.find_sets();
        let DeepOverlaps { islands: deep, sets, rows, .. } = deep_overlaps;
        for &(number, set) in deep.iter() {
            let island = &islands.list[number as usize];
            let members = &islands.members[island.members.clone()];
            for &row in members {
                let speed = particles.velocity(row as usize).length();
                let most = &mut sets[set as usize].most;
                *most = most.max(recovery).max(speed + gained);
            }
            // Rigid states have no particles that could be flung apart.
            if !island.is_rigid_state {
                rows.extend(members.iter().map(|&row| (set, row)));
            }
        }
        rows.sort_unstable();
    }

    /// Limits the speeds, and distributes the removed momentum.
    pub(super) fn limit_speeds(&self, particles: &mut Particles) {
        let DeepOverlaps { rows, sets, .. } = &self.deep_overlaps;
        for own in rows.chunk_by(|one, other| one.0 == other.0) {
            let DeepSet { held, most } = sets[own[0].0 as usize];
            let (mut lost, mut mass) = (Vec3::ZERO, 0.0);
            for i in own.iter().map(|&(_, row)| row as usize) {
                let (w, velocity) = (particles.position[i].w, &mut particles.velocity[i]);
                let now = velocity.truncate();
                if now.length() > most {
                    let slower = now * (most / now.length());
                    *velocity = slower.extend(velocity.w);
                    lost += if w > 0.0 { (now - slower) / w } else { Vec3::ZERO };
                }
                mass += if w > 0.0 { 1.0 / w } else { 0.0 };
            }
            let given = lost / mass;
            if held || lost == Vec3::ZERO || !given.is_finite() {
                continue;
            }
            for i in own.iter().map(|&(_, row)| row as usize) {
                if particles.position[i].w > 0.0 {
                    particles.velocity[i] += given.extend(0.0);
                }
            }
        }
    }
}

impl DeepOverlaps {
    pub(super) fn clear(&mut self) {
        self.islands.clear();
        self.pairs.clear();
        self.sets.clear();
        self.rows.clear();
    }

    /// Numbers the sets of islands that are deep in each other.
    fn find_sets(&mut self) {
        let Self { islands, pairs, sets, .. } = self;
        pairs.sort_unstable();
        pairs.dedup();
        let both = |&(a, b): &(u32, Option<u32>)| core::iter::once(a).chain(b);
        islands.extend(pairs.iter().flat_map(both).map(|island| (island, 0)));
        islands.sort_unstable();
        islands.dedup();
        (0..).zip(islands.iter_mut()).for_each(|(number, (_, set))| *set = number);
        let place = |islands: &[(u32, u32)], island: u32| {
            islands.partition_point(|(other, _)| *other < island)
        };
        // Few are deep at once, and fewer in a chain: one pass for each link that passes its number on.
        let mut changed = true;
        while changed {
            changed = false;
            for &(a, b) in pairs.iter() {
                let [a, b] = [a, b.unwrap_or(a)].map(|island| place(islands, island));
                let least = islands[a].1.min(islands[b].1);
                changed |= islands[a].1 != islands[b].1;
                (islands[a].1, islands[b].1) = (least, least);
            }
        }
        sets.resize(islands.len(), DeepSet::default());
        for &(a, _) in pairs.iter().filter(|(_, b)| b.is_none()) {
            sets[islands[place(islands, a)].1 as usize].held = true;
        }
    }
}
