//! Broad phase of body colliders: swept bounds of a step, pairs whose bounds overlap, and missed pairs.
//!
//! When a step begins, each body collider gets swept bounds, the pairs of bounds that overlap are listed, and the narrow phase compares them.
//!
//! # Missed pairs
//!
//! These pairs are complete as long as each body collider goes on as it moved when the step began, within its speculative margin. In a tumbling heap there is
//! always one that does not: it leaves its swept bounds, is queried by itself from where it is, and the pairs that it gains are added. Pairs that were found
//! before stay; those that turn or slide on each other are refreshed by `narrow_phase`. So the result of a pair does not depend, to the last bit, on whether
//! something far away has left its swept bounds.
//!
//! Missed manifolds have colours of their own and are solved after all others.

use glam::Vec3;

use super::super::features::Features;
use super::super::nearby::Nearby;
use super::super::world::World;
use super::BodyContactSolver;
use super::bodies::{ROTATION, SHIFT};
use super::contact_cache::{CacheBuilder, ContactCache};
use super::pose::robust_rotation;
use super::swept_bounds::{SweptBounds, WideSweptBounds};
use super::wide_contact::{Contact, SWEEPS, WideContact, colour, pack_contacts, put, set_levels};
use crate::lanes::LANES;
use crate::not_cloned::NotCloned;
use crate::particles::{NO_BODY, Particles};

/// From this number of body colliders outside the grid on, the grid is filled anew: each of them is compared with each that leaves its swept bounds.
const REFILL_COUNT: usize = 128;

impl BodyContactSolver {
    /// Finds at the start of a step all pairs and manifolds that may touch in it, and packs their contacts.
    pub(crate) fn broad_phase(
        &mut self,
        particles: &Particles,
        world: &World,
        near: (&Nearby, &Features),
        cache: &mut ContactCache,
    ) {
        self.cache.take(cache);
        if self.is_empty() {
            self.cache.now.clear();
            return;
        }
        self.sensors.begin();
        self.h = world.dt / world.substeps.max(1) as f32;
        let is_new = self.dormant.0.begin(world, &self.groups, &self.in_contact);
        if is_new {
            self.cache.forget_dormant();
        }
        self.groups.update_masses(world.body_colliders, self.dormant.0.active(), particles);
        self.note_sleepers(world);
        super::static_geometry::list(world, &mut self.floor, &mut self.static_geometry);
        let rows = self.groups.padded() + self.static_geometry.len() + 1;
        self.bodies.resize(rows, self.dormant.0.kept());
        self.sums.resize(self.groups.groups.len(), Default::default());
        if world.at_rest {
            self.rest();
            return;
        }
        self.overlaps.update(world.body_colliders, &self.groups, particles, world.filter);
        self.origin_offsets.collect(&self.groups, self.dormant.0.active(), particles);
        self.note_initial_rotations(particles, world);
        self.extract_poses_afresh(particles, world);
        if !self.dormant.0.is_kept {
            self.wide_swept.clear();
            self.wide_swept.resize(self.groups.groups.len(), WideSweptBounds::default());
            self.swept.clear();
            self.swept.resize(self.groups.parts.len(), SweptBounds::default());
        }
        for place in 0..self.dormant.0.active().len() {
            let number = self.dormant.0.active()[place] as usize;
            self.note_swept_bounds(number, particles, world, (0.0, 1.0));
        }
        self.place_static_geometry(world, 0.0, 0.0);
        let mut pairs = core::mem::take(&mut self.pairs);
        self.near_pairs(world, &mut pairs);
        self.contacts.clear();
        self.cache.begin(self.dormant.0.is_kept);
        self.compare_all(&pairs, particles, world, is_new);
        self.pairs = pairs;
        self.drop_ghosts(world);
        self.cache.in_order();
        self.missed.begin(self.contacts.len());
        self.loose.broad_phase(&self.swept, &self.groups, particles, world, near, None);
        let Self {
            contacts,
            used,
            wide_contacts,
            order,
            begins,
            groups,
            bodies,
            cache,
            h,
            loads,
            ..
        } = self;
        let mass = |number: u32| {
            let weight = bodies[groups.place(number as usize)][SHIFT].w;
            (weight > 0.0 && groups.is_alone(number as usize)).then(|| 1.0 / weight)
        };
        set_levels((contacts, *h), groups.parts.len(), mass, loads);
        let colours = colour(contacts, groups.parts.len(), used);
        let null_row = (bodies.rows.len() - 1) as u32;
        let centre =
            |row: u32| groups.parts.get(row as usize).map_or(Vec3::ZERO, |part| part.centre);
        let contacts = (&contacts[..], &cache.now[..], *h);
        let row = |number: u32| {
            let solid = number < groups.parts.len() as u32;
            if solid { groups.place(number as usize) as u32 } else { number }
        };
        pack_contacts(contacts, (null_row, colours), [order, begins], wide_contacts, (row, centre));
        self.missed.wide_contacts = wide_contacts.len();
        self.keep_for_impacts(world);
        self.fresh = true;
        self.in_contact.clear();
        self.in_contact.resize(self.groups.groups.len(), 0);
        self.mark_in_contact(0);
    }

    /// Makes all wide contacts keep what restitution needs, if any contact has a restitution, or a single particle may bring them an impact from elsewhere: one
    /// that is slow itself may take part.
    fn keep_for_impacts(&mut self, world: &World) {
        let Self { wide_contacts, loose, .. } = self;
        let any_elastic = wide_contacts.iter().any(|wide| wide.elastic != 0);
        if any_elastic || !loose.is_empty() && world.any_restitution() {
            wide_contacts.iter_mut().for_each(|wide| wide.kept = true);
        }
    }

    /// Marks the body colliders of the contacts from `first` on, and those with single particles nearby.
    fn mark_in_contact(&mut self, first: usize) {
        let Self { contacts, groups, loose, in_contact, .. } = self;
        let mut note = |number: u32| {
            // Static geometry has numbers after those of body colliders.
            if (number as usize) < groups.parts.len() {
                let place = groups.place(number as usize);
                in_contact[place / LANES] |= 1 << (place % LANES);
            }
        };
        for one in &contacts[first..] {
            note(one.a);
            note(one.b);
        }
        loose.bodies().for_each(note);
    }

    /// Marks the body colliders that sleep. Other immovable ones may be kinematic.
    fn note_sleepers(&mut self, world: &World) {
        let Self { groups, asleep, dormant, .. } = self;
        asleep.clear();
        asleep.extend_from_slice(dormant.0.kept());
        asleep.resize(groups.groups.len(), 0);
        let islands = world.islands;
        let active = dormant.0.active().iter().map(|&number| number as usize);
        let parts = active.map(|number| (number, &groups.parts[number]));
        for (number, part) in parts.filter(|(_, part)| part.immovable) {
            let first = groups.rows.get(part.entries.start);
            let island = first.and_then(|&row| islands.of.get(row as usize));
            if part.sound && island.is_some_and(|&island| islands.list[island as usize].asleep) {
                let place = groups.place(number);
                asleep[place / LANES] |= 1 << (place % LANES);
            }
        }
    }

    /// Ends the broad phase of a step in which nothing moves: no pairs are found, and the cache stays as it is.
    fn rest(&mut self) {
        self.dormant.0.invalidate();
        self.cache.in_order();
        self.wide_swept.clear();
        self.wide_swept.resize(self.groups.groups.len(), WideSweptBounds::default());
        self.swept.clear();
        self.contacts.clear();
        self.wide_contacts.clear();
        self.loose.clear();
        self.outside_bounds.clear();
        self.in_contact.clear();
        self.in_contact.resize(self.groups.groups.len(), 0);
        self.missed.begin(0);
        self.missed.wide_contacts = 0;
    }

    /// Extracts poses and velocities afresh, from the initial rotations; lanes that have not converged start once more from [`robust_rotation`].
    fn extract_poses_afresh(&mut self, particles: &Particles, world: &World) {
        for number in 0..self.groups.groups.len() {
            let kept = self.dormant.0.kept_of(number);
            if kept != 0 && kept == self.groups.groups[number].sound {
                continue;
            }
            let (first, mut pending) = (number * LANES, 0xFF);
            let eight = (kept != 0).then(|| self.bodies.eight(first));
            for _ in 0..2 {
                // Lanes that converged in the first pass keep their result: it must not depend on the other lanes.
                let before = (pending != 0xFF).then(|| self.bodies.eight(first));
                let columns = [&particles.position[..], &particles.velocity];
                let unconverged = self.extract_pose(number, columns, None, !0);
                let Self { groups, bodies, .. } = self;
                if let Some(before) = before {
                    bodies.put_back(first, !pending, before);
                }
                pending &= unconverged;
                if pending == 0 {
                    break;
                }
                for lane in (0..LANES).filter(|lane| pending >> lane & 1 == 1) {
                    if let Some(solid) = groups.sound_in(number, lane) {
                        let (rest, row) = (&world.body_colliders[solid].rest, first + lane);
                        let near = bodies[row][ROTATION];
                        bodies[row][ROTATION] =
                            robust_rotation(groups, solid, rest, particles, near);
                    }
                }
            }
            if let Some(eight) = eight {
                self.bodies.put_back(first, kept, eight);
            }
        }
    }

    /// Lists the pairs of body colliders, and of body colliders with static geometry, whose bounds overlap; sorted.
    fn near_pairs(&mut self, world: &World, pairs: &mut Vec<[u32; 2]>) {
        let Self {
            swept,
            static_geometry,
            clusters,
            bounds,
            groups,
            nearby,
            instructions,
            order: endless,
            dormant: NotCloned(dormant),
            ..
        } = self;
        bounds.resize(swept.len(), (Vec3::NAN, Vec3::NAN));
        for &number in dormant.active() {
            bounds[number as usize] = swept[number as usize].bounds;
        }
        bounds.extend(static_geometry.iter().map(|geometry| geometry.bounds(world)));
        let same_body = |i: usize| {
            let body = |i: usize| swept.get(i).map_or(NO_BODY, |one| one.body);
            body(i) != NO_BODY && body(i) == body(i - 1)
        };
        let travel = |i: usize| swept.get(i).map_or(Vec3::ZERO, |one| one.velocity * world.dt);
        clusters.0.pairs(bounds, same_body, travel, *instructions, nearby);
        pairs.clear();
        // Pairs of two dormant body colliders are known from the step before.
        let needs_query = |pair: &[u32; 2]| {
            (pair[0] as usize) < swept.len()
                && !(dormant.is_kept && dormant.are_both_dormant(groups, *pair))
        };
        let mut nearby = nearby.iter().copied().filter(needs_query).peekable();
        // Geometry without end is compared with every body collider. Both lists are sorted and are merged.
        endless.clear();
        endless.extend(
            (0..static_geometry.len() as u32).filter(|&i| static_geometry[i as usize].endless),
        );
        let active = dormant.active().iter().map(|&number| number as usize);
        for (a, one) in active.map(|a| (a, &swept[a])).filter(|(_, one)| one.sound) {
            for &number in &*endless {
                if static_geometry[number as usize].is_below(one, groups.parts[a].reach, world, 0.0)
                {
                    let pair = [a as u32, swept.len() as u32 + number];
                    while let Some(before) = nearby.next_if(|before| *before < pair) {
                        pairs.push(before);
                    }
                    pairs.push(pair);
                }
            }
        }
        pairs.extend(nearby);
    }

    /// Places static geometry from one fraction of the step to another. What does not move was placed when the step began.
    pub(super) fn place_static_geometry(&mut self, world: &World, from: f32, to: f32) {
        let (first, begins) = (self.groups.padded(), to == 0.0);
        let static_geometry = self.static_geometry.iter().enumerate();
        for (number, geometry) in
            static_geometry.filter(|(_, geometry)| begins || geometry.moving.is_some())
        {
            let (start, end) = (geometry.frame_at(world, from), geometry.frame_at(world, to));
            self.bodies.place(first + number, &start, &end);
        }
    }
}

/// Pairs and manifolds that were found within a step.
#[derive(Clone, Debug, Default)]
pub(super) struct MissedPairs {
    /// Numbers of manifolds and of wide contacts that the broad phase found when the step began: those after them are missed ones.
    contacts: usize,
    pub(super) wide_contacts: usize,
    /// [Classes](Contact::class) of the wide contacts of missed manifolds, ascending.
    classes: Vec<usize>,
    /// For each body collider the colours in use by missed manifolds, a bit for each.
    used: Vec<u64>,
    /// The two of each missed manifold as in [`Contact`], and the part (triangle) of the manifold; sorted.
    found: Vec<[u32; 3]>,
    /// Body colliders whose bounds are no longer those in the grid.
    moved: Vec<u32>,
    pairs: Vec<[u32; 2]>,
}

impl MissedPairs {
    /// Begins a step in which the broad phase found this number of manifolds.
    pub(super) fn begin(&mut self, contacts: usize) {
        self.contacts = contacts;
        self.classes.clear();
        self.used.clear();
        self.found.clear();
        self.moved.clear();
    }

    /// Whether a manifold of this pair and part was found in this step.
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
        same.any(|one| cache.part(one.cache_index) == part)
            || self.found.binary_search(&[a, b, part]).is_ok()
    }
}

impl BodyContactSolver {
    /// Finds the missed pairs of the body colliders that have left their swept bounds, from where they were after a fraction `share` of the step.
    pub(super) fn find_missed_pairs(
        &mut self,
        particles: &Particles,
        world: &World,
        near: (&Nearby, &Features),
        share: f32,
    ) {
        let mut outside_bounds = core::mem::take(&mut self.outside_bounds);
        outside_bounds.sort_unstable();
        for &number in &outside_bounds {
            self.note_swept_bounds(number as usize, particles, world, (share, 1.0 / self.h));
            self.bounds[number as usize] = self.swept[number as usize].bounds;
        }
        let mut pairs = core::mem::take(&mut self.missed.pairs);
        self.around(&outside_bounds, world, share, &mut pairs);
        let first = self.contacts.len();
        for &[a, b] in &pairs {
            for number in [a as usize, b as usize] {
                self.read_line(number, particles);
                if let Some(part) = self.groups.parts.get(number).filter(|part| part.sound) {
                    let place = self.groups.place(number);
                    self.swept[number].frame = self.bodies.frame(place, part.centre);
                }
            }
            self.compare_missed([a, b], particles, world, share);
        }
        (self.outside_bounds, self.missed.pairs) = (outside_bounds, pairs);
        for number in first..self.contacts.len() {
            self.pack_missed(number);
        }
        let Self { missed, contacts, cache, .. } = self;
        missed.found.extend(
            contacts[first..].iter().map(|one| [one.a, one.b, cache.part(one.cache_index)]),
        );
        missed.found.sort_unstable();
        if !(self.loose.none_collide() && near.1.is_empty()) {
            self.note_contact_events();
            let outside = Some(&self.outside_bounds[..]);
            self.loose.broad_phase(&self.swept, &self.groups, particles, world, near, outside);
            let loose = core::mem::take(&mut self.loose);
            loose.bodies().for_each(|number| self.read_line(number as usize, particles));
            self.loose = loose;
        }
        self.keep_for_impacts(world);
        self.mark_in_contact(first);
    }

    /// Extracts the pose of a line that this substep has skipped because it was in no contact.
    fn read_line(&mut self, number: usize, particles: &Particles) {
        let Some(place) = self.groups.parts.get(number).map(|_| self.groups.place(number)) else {
            return;
        };
        let (group, lane) = (place / LANES, 1 << (place % LANES));
        let stays = self.rigid.lanes(group) | self.asleep[group];
        if lane & !(self.extracted[group] | stays) == 0 {
            return;
        }
        self.extracted[group] |= lane;
        let before = (stays != 0).then(|| self.bodies.eight(group * LANES));
        let columns = [&particles.position[..], &particles.start];
        self.extract_pose(group, columns, Some(0.0), lane);
        if let Some(before) = before {
            self.bodies.put_back(group * LANES, stays, before);
        }
    }

    /// Lists the pairs of some body colliders with everything whose bounds overlap theirs; sorted, each once.
    fn around(&mut self, these: &[u32], world: &World, share: f32, pairs: &mut Vec<[u32; 2]>) {
        let Self { swept, static_geometry, clusters, bounds, groups, missed, .. } = self;
        pairs.clear();
        if missed.moved.len() + these.len() > REFILL_COUNT {
            clusters.0.fill(bounds);
            missed.moved.clear();
        } else {
            missed.moved.extend(these);
            missed.moved.sort_unstable();
            missed.moved.dedup();
        }
        for &number in these {
            clusters.0.query(number, bounds, &missed.moved, pairs);
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

    /// Adds a missed manifold to the first wide contact of its colour with a free lane.
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
            // No colour is free: a colour of its own.
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
            let null_row = (bodies.rows.len() - 1) as u32;
            wide_contacts.insert(
                missed.wide_contacts + end,
                WideContact::empty(null_row, one.fixed.is_some(), SWEEPS[one.level]),
            );
        }
        let solid = b < groups.parts.len();
        let rows = [groups.place(a), if solid { groups.place(b) } else { b }];
        let centre =
            |number: usize| groups.parts.get(number).map_or(Vec3::ZERO, |part| part.centre);
        let cached = &cache.now[one.cache_index as usize];
        let to = (&mut wide_contacts[missed.wide_contacts + place], lane);
        let rows = rows.map(|row| row as u32);
        put(to, (number as u32, rows), (one, cached), [centre(a), centre(b)], *h);
    }
}
