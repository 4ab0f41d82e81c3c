//! Who has left his way, and what he may come to touch now that nobody looked for.
//!
//! What was found for a step holds as long as all go on as they went when it began, give or take what jolts may do ([`way`](super::way)). In a heap
//! that tumbles there is always one that does not: it is looked after by itself, from where it is, and what it may come to touch is added to what was
//! found. What was found before stays: of two that turn or slide on each other others see to that (`again`). So nobody minds, to the last bit,
//! whether something far off has left its way.
//!
//! What comes late has colours of its own, and is pressed after all others.

use glam::Vec3;

use super::super::World;
use super::super::nearby::Nearby;
use super::Solids;
use super::found::{Found, keep_for_impacts, put};
use super::mass_ratio::SWEEPS;
use super::memory::Memory;
use super::pack::Pack;
use crate::particles::Particles;

/// From so many on that lie elsewhere than in the grid it is filled anew: each of them is compared with each that leaves its way.
const MANY: usize = 128;

/// What came late in a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Late {
    /// How many manifolds were found, and packs made of them, when the step began: what comes after those is late.
    found: usize,
    pub(super) packs: usize,
    /// [Classes](Found::class) of the late packs, ascending.
    classes: Vec<usize>,
    /// For each solid which colours it has.
    used: Vec<u64>,
    /// The two of each late manifold as they are in [`Found`], and which part of them; sorted.
    met: Vec<[u32; 3]>,
    /// Who lies elsewhere than in the grid.
    moved: Vec<u32>,
    pairs: Vec<[u32; 2]>,
}

impl Late {
    /// A step begins, for which so many manifolds were found.
    pub(super) fn begin(&mut self, found: usize) {
        self.found = found;
        self.classes.clear();
        self.used.clear();
        self.met.clear();
        self.moved.clear();
    }

    /// Whether a part of two was found.
    pub(super) fn has(
        &self,
        [a, b]: [u32; 2],
        part: u32,
        found: &[Found],
        memory: &Memory,
    ) -> bool {
        let first = &found[..self.found];
        let from = first.partition_point(|one| [one.a, one.b] < [a, b]);
        let mut same = first[from..].iter().take_while(|one| [one.a, one.b] == [a, b]);
        same.any(|one| memory.part(one) == part) || self.met.binary_search(&[a, b, part]).is_ok()
    }
}

impl Solids {
    /// Looks after those who have left their way, from where they were after a share of the step.
    pub(super) fn look_after(
        &mut self,
        particles: &Particles,
        world: &World,
        nearby: &Nearby,
        share: f32,
    ) {
        let mut astray = core::mem::take(&mut self.astray);
        astray.sort_unstable();
        for &number in &astray {
            self.note(number as usize, particles, world, (share, 1.0 / self.h));
            self.bounds[number as usize] = self.seen[number as usize].bounds;
        }
        let mut pairs = core::mem::take(&mut self.late.pairs);
        self.around(&astray, world, share, &mut pairs);
        let first = self.found.len();
        for &[a, b] in &pairs {
            for number in [a, b].map(|number| number as usize) {
                if let Some(part) = self.groups.parts.get(number).filter(|part| part.sound) {
                    let place = self.groups.place(number);
                    self.seen[number].frame = self.bodies.frame(place, part.centre);
                }
            }
            self.compare([a as usize, b as usize], particles, world, (share, true));
        }
        (self.astray, self.late.pairs) = (astray, pairs);
        for number in first..self.found.len() {
            self.pack_late(number);
        }
        keep_for_impacts(&mut self.packs);
        let Self { late, found, memory, .. } = self;
        late.met.extend(found[first..].iter().map(|one| [one.a, one.b, memory.part(one)]));
        late.met.sort_unstable();
        if !self.loose.none_collide() {
            self.tell();
            self.loose.find(&self.seen, &self.groups, particles, world, nearby);
        }
    }

    /// Pairs of some solids and of whatever may come near them; sorted, each once.
    fn around(&mut self, these: &[u32], world: &World, share: f32, pairs: &mut Vec<[u32; 2]>) {
        let Self { seen, stands, near, bounds, groups, late, .. } = self;
        pairs.clear();
        if late.moved.len() + these.len() > MANY {
            near.0.fill(bounds);
            late.moved.clear();
        } else {
            late.moved.extend(these);
            late.moved.sort_unstable();
            late.moved.dedup();
        }
        for &number in these {
            near.0.around(number, bounds, &late.moved, pairs);
            let one = &seen[number as usize];
            for (stand, at) in stands.iter().zip(seen.len()..).filter(|(stand, _)| stand.endless) {
                let size = groups.parts[number as usize].reach;
                if one.sound && stand.is_below(one, size, world, share) {
                    pairs.push([number, at as u32]);
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
    }

    /// Puts a late manifold into the first pack of its colour that has room.
    fn pack_late(&mut self, number: usize) {
        let Self { late, found, packs, groups, bodies, memory, h, .. } = self;
        let one = &mut found[number];
        let (a, b) = (one.a as usize, one.b as usize);
        late.used.resize(groups.parts.len(), 0);
        let taken = late.used[a] | late.used.get(b).copied().unwrap_or(0);
        one.colour = (!taken).trailing_zeros();
        if one.colour < u64::BITS {
            late.used[a] |= 1 << one.colour;
            if let Some(used) = late.used.get_mut(b) {
                *used |= 1 << one.colour;
            }
        } else {
            // One by itself.
            one.colour = u64::BITS + number as u32;
        }
        let free = |pack: &Pack| pack.number.iter().position(|number| *number == u32::MAX);
        let end = late.classes.partition_point(|class| *class <= one.class());
        let last = end.checked_sub(1).filter(|&last| late.classes[last] == one.class());
        let room = last.and_then(|last| Some((last, free(&packs[late.packs + last])?)));
        let (place, lane) = room.unwrap_or((end, 0));
        if room.is_none() {
            late.classes.insert(end, one.class());
            let nothing = (bodies.rows.len() - 1) as u32;
            packs.insert(
                late.packs + end,
                Pack::empty(nothing, one.still.is_some(), SWEEPS[one.level]),
            );
        }
        let solid = b < groups.parts.len();
        let rows = [groups.place(a), if solid { groups.place(b) } else { b }];
        let centre =
            |number: usize| groups.parts.get(number).map_or(Vec3::ZERO, |part| part.centre);
        let known = &memory.now[one.memory as usize];
        let to = (&mut packs[late.packs + place], lane);
        let rows = rows.map(|row| row as u32);
        put(to, (number as u32, rows), (one, known), [centre(a), centre(b)], *h);
    }
}
