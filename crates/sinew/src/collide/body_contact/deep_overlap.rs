//! How fast particles may leave a substep in which a body collider was deep in something.
//!
//! What holds it there, pins and limits of joints, gives way meanwhile, by ever more, and when that comes back at once it flings all of them. So the particles of
//! islands in which a body collider is that deep get no faster than the fastest one was, or than overlap is recovered. An impact of two gives nobody more
//! than that. What is taken off is given to all that were deep in each other alike, so that their momentum stays; what is deep in something that stands gives it
//! to that.

use glam::Vec3;

use super::BodyContactSolver;
use crate::islands::Islands;
use crate::lanes::LANES;
use crate::particles::Particles;

/// The islands that are deep in something in a substep. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct DeepOverlaps {
    /// Islands and the set that they are in: those that are deep in each other; sorted by island.
    islands: Vec<(u32, u32)>,
    /// Two that are deep in each other; no second one where that stands.
    pairs: Vec<(u32, Option<u32>)>,
    /// By the number of a set.
    sets: Vec<DeepSet>,
    /// Numbers of sets with the rows of their particles, ascending.
    rows: Vec<(u32, u32)>,
}

#[derive(Clone, Copy, Debug, Default)]
struct DeepSet {
    /// Whether one of it is deep in something that stands.
    held: bool,
    /// The speed that none of its particles may exceed, m/s.
    most: f32,
}

impl BodyContactSolver {
    /// Notes the islands in which a body collider was deeper in than so many metres, and how fast their particles may leave the substep: at the speed at which
    /// overlap is recovered, or by what gravity gives, both m/s, faster than the fastest came.
    pub(super) fn note_deep_overlaps(
        &mut self,
        particles: &Particles,
        islands: &Islands,
        depth: f32,
        (recovery, gained): (f32, f32),
    ) {
        let Self { wide_contacts, groups, deep_overlaps, .. } = self;
        deep_overlaps.clear();
        let home = |row: u32| groups.island_of(row, islands);
        for wide in wide_contacts.iter().filter(|wide| wide.depenetrated != 0) {
            for lane in (0..LANES).filter(|&lane| wide.left[lane] > depth) {
                let (a, b) = (home(wide.a[lane]), home(wide.b[lane]));
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
            if !island.one_state {
                rows.extend(members.iter().map(|&row| (set, row)));
            }
        }
        rows.sort_unstable();
    }

    /// Takes off what they have become faster by.
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
        // Few are deep at once, and fewer in a row: a pass for each that hands its number on.
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
