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
use crate::union_find::UnionFind;

/// Islands with deep overlaps in a substep. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct DeepOverlaps {
    /// Islands that are deep in something, ascending.
    islands: Vec<u32>,
    /// The sets of islands deep in each other, by their places in `islands`.
    joined: UnionFind,
    /// Two islands that are deep in each other; no second one for static geometry.
    pairs: Vec<(u32, Option<u32>)>,
    /// By the root of a set.
    sets: Vec<DeepSet>,
    /// Roots of sets with the rows of their particles, ascending.
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
        let DeepOverlaps { islands: deep, joined, sets, rows, .. } = deep_overlaps;
        for (place, &number) in (0..).zip(deep.iter()) {
            let set = joined.root(place);
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

    /// Finds the sets of islands that are deep in each other.
    fn find_sets(&mut self) {
        let Self { islands, joined, pairs, sets, .. } = self;
        let both = |&(a, b): &(u32, Option<u32>)| core::iter::once(a).chain(b);
        islands.extend(pairs.iter().flat_map(both));
        islands.sort_unstable();
        islands.dedup();
        let place = |island: u32| islands.partition_point(|&other| other < island) as u32;
        joined.reset(islands.len());
        for &(a, b) in pairs.iter() {
            joined.unite(place(a), place(b.unwrap_or(a)));
        }
        sets.resize(islands.len(), DeepSet::default());
        for &(a, _) in pairs.iter().filter(|(_, b)| b.is_none()) {
            sets[joined.root(place(a)) as usize].held = true;
        }
    }
}
