//! Missed pairs: body colliders that have left their swept bounds within a step, and the pairs that the broad phase did not find for them.
//!
//! What was found for a step holds as long as all go on as they went when it began, give or take what jolts may do
//! ([`swept_bounds`](super::swept_bounds)). In a heap that tumbles there is always one that does not: it is searched for by itself, from where it is,
//! and what it may come to touch is added to what was found. What was found before stays: of two that turn or slide on each other others see to that
//! (`refresh`). So nobody minds, to the last bit, whether something far off has left its swept bounds.
//!
//! Missed manifolds have colours of their own, and are solved after all others.

use glam::Vec3;

use super::super::World;
use super::super::nearby::Nearby;
use super::BodyContactSolver;
use super::contact_cache::CacheBuilder;
use super::contacts::{Contact, keep_for_impacts, put};
use super::mass_ratio::SWEEPS;
use super::wide_contact::WideContact;
use crate::particles::Particles;

/// From so many on that lie elsewhere than in the grid it is filled anew: each of them is compared with each that leaves its swept bounds.
const MANY: usize = 128;

/// Pairs and manifolds that were found within a step.
#[derive(Clone, Debug, Default)]
pub(super) struct MissedPairs {
    /// How many manifolds were found, and wide contacts made of them, when the step began: those behind them were missed by the broad phase.
    contacts: usize,
    pub(super) wide_contacts: usize,
    /// [Classes](Contact::class) of the wide contacts of missed manifolds, ascending.
    classes: Vec<usize>,
    /// For each body collider which colours it has.
    used: Vec<u64>,
    /// The two of each missed manifold as they are in [`Contact`], and which part of them; sorted.
    met: Vec<[u32; 3]>,
    /// Who lies elsewhere than in the grid.
    moved: Vec<u32>,
    pairs: Vec<[u32; 2]>,
}

impl MissedPairs {
    /// A step begins, for which so many manifolds were found.
    pub(super) fn begin(&mut self, contacts: usize) {
        self.contacts = contacts;
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
        contacts: &[Contact],
        cache: &CacheBuilder,
    ) -> bool {
        let first = &contacts[..self.contacts];
        let from = first.partition_point(|one| [one.a, one.b] < [a, b]);
        let mut same = first[from..].iter().take_while(|one| [one.a, one.b] == [a, b]);
        same.any(|one| cache.part(one) == part) || self.met.binary_search(&[a, b, part]).is_ok()
    }
}

impl BodyContactSolver {
    /// Finds the missed pairs of those that have left their swept bounds, from where they were after a share of the step.
    pub(super) fn find_missed_pairs(
        &mut self,
        particles: &Particles,
        world: &World,
        nearby: &Nearby,
        share: f32,
    ) {
        let mut outside_bounds = core::mem::take(&mut self.outside_bounds);
        outside_bounds.sort_unstable();
        for &number in &outside_bounds {
            self.note(number as usize, particles, world, (share, 1.0 / self.h));
            self.bounds[number as usize] = self.swept[number as usize].bounds;
        }
        let mut pairs = core::mem::take(&mut self.missed.pairs);
        self.around(&outside_bounds, world, share, &mut pairs);
        let first = self.contacts.len();
        for &[a, b] in &pairs {
            for number in [a, b].map(|number| number as usize) {
                if let Some(part) = self.groups.parts.get(number).filter(|part| part.sound) {
                    let place = self.groups.place(number);
                    self.swept[number].frame = self.bodies.frame(place, part.centre);
                }
            }
            self.compare([a as usize, b as usize], particles, world, (share, true));
        }
        (self.outside_bounds, self.missed.pairs) = (outside_bounds, pairs);
        for number in first..self.contacts.len() {
            self.pack_missed(number);
        }
        keep_for_impacts(&mut self.wide_contacts);
        let Self { missed, contacts, cache, .. } = self;
        missed.met.extend(contacts[first..].iter().map(|one| [one.a, one.b, cache.part(one)]));
        missed.met.sort_unstable();
        if !self.loose.none_collide() {
            self.note_contact_events();
            self.loose.broad_phase(&self.swept, &self.groups, particles, world, nearby);
        }
    }

    /// Pairs of some body colliders and of whatever may come near them; sorted, each once.
    fn around(&mut self, these: &[u32], world: &World, share: f32, pairs: &mut Vec<[u32; 2]>) {
        let Self { swept, static_geometry, clusters, bounds, groups, missed, .. } = self;
        pairs.clear();
        if missed.moved.len() + these.len() > MANY {
            clusters.0.fill(bounds);
            missed.moved.clear();
        } else {
            missed.moved.extend(these);
            missed.moved.sort_unstable();
            missed.moved.dedup();
        }
        for &number in these {
            clusters.0.around(number, bounds, &missed.moved, pairs);
            let one = &swept[number as usize];
            for (geometry, at) in
                static_geometry.iter().zip(swept.len()..).filter(|(geometry, _)| geometry.endless)
            {
                let size = groups.parts[number as usize].reach;
                if one.sound && geometry.is_below(one, size, world, share) {
                    pairs.push([number, at as u32]);
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
    }

    /// Puts a missed manifold into the first wide contact of its colour that has room.
    fn pack_missed(&mut self, number: usize) {
        let Self { missed, contacts, wide_contacts, groups, bodies, cache, h, .. } = self;
        let one = &mut contacts[number];
        let (a, b) = (one.a as usize, one.b as usize);
        missed.used.resize(groups.parts.len(), 0);
        let taken = missed.used[a] | missed.used.get(b).copied().unwrap_or(0);
        one.colour = (!taken).trailing_zeros();
        if one.colour < u64::BITS {
            missed.used[a] |= 1 << one.colour;
            if let Some(used) = missed.used.get_mut(b) {
                *used |= 1 << one.colour;
            }
        } else {
            // One by itself.
            one.colour = u64::BITS + number as u32;
        }
        let free = |wide: &WideContact| wide.number.iter().position(|number| *number == u32::MAX);
        let end = missed.classes.partition_point(|class| *class <= one.class());
        let last = end.checked_sub(1).filter(|&last| missed.classes[last] == one.class());
        let room =
            last.and_then(|last| Some((last, free(&wide_contacts[missed.wide_contacts + last])?)));
        let (place, lane) = room.unwrap_or((end, 0));
        if room.is_none() {
            missed.classes.insert(end, one.class());
            let nothing = (bodies.rows.len() - 1) as u32;
            wide_contacts.insert(
                missed.wide_contacts + end,
                WideContact::empty(nothing, one.fixed.is_some(), SWEEPS[one.level]),
            );
        }
        let solid = b < groups.parts.len();
        let rows = [groups.place(a), if solid { groups.place(b) } else { b }];
        let centre =
            |number: usize| groups.parts.get(number).map_or(Vec3::ZERO, |part| part.centre);
        let known = &cache.now[one.cache_index as usize];
        let to = (&mut wide_contacts[missed.wide_contacts + place], lane);
        let rows = rows.map(|row| row as u32);
        put(to, (number as u32, rows), (one, known), [centre(a), centre(b)], *h);
    }
}
