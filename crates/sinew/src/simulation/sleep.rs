//! Sleep: bodies that lie still, with everything that they touch, are left out of the steps until something wakes them.
//!
//! Bodies sleep and wake in groups: islands joined where bounds of their pieces touch (`pieces`), where a spring connects them, and all islands of a body. When
//! all of a group have been still for [`TIME_TO_SLEEP`], and its support has not just changed, it falls asleep: its particles stop and count as pinned, so that
//! whatever comes near collides with them, and its constraints are not solved. A group wakes
//!
//! - when one of its particles was given a velocity, a force or a control, or was [marked to wake](crate::Particles::wake);
//! - when something that moves comes near, or a collider near it moves;
//! - when its support changes: positions, masses, shapes, constraints, springs, hulls, ignored pairs, and the static geometry beside it (`support`).
//!
//! Bodies that gusts could move stay awake in them (`gusts`). Groups that have slept for long and have nothing moving near them are dormant: they are not even
//! visited (`dormant`).
//!
//! No other state exists: what must survive a step is in [`Sleep`], which belongs to a body.

mod dormant;
mod gusts;
mod pieces;
mod support;

use core::ops::Range;

use glam::{Vec3, Vec4};

use dormant::Dormant;
use pieces::Pieces;
use support::SupportHash;

use super::Simulation;
use crate::collide::{Broad, Collider};
use crate::islands::Island;
use crate::particles::NO_BODY;
use crate::union_find::UnionFind;

/// Whether a body may sleep, and how long it has been still: configuration and live state, to be saved and restored with its particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sleep {
    /// Whether the body may sleep. Default false.
    pub allowed: bool,
    /// Whether the body, and with it everything that touches it, stays awake, however still it is. Default false.
    pub keeps_awake: bool,
    /// Speed up to which a particle counts as still, m/s, 0 and up. Default 0.02.
    pub speed: f32,
    /// Time for which the whole group has been still, seconds. Default 0.
    pub still: f32,
    /// Whether it sleeps. Default false. To wake a body, clear this and `still`.
    pub asleep: bool,
    /// Hash of the support when it fell asleep: of its group's particles, shapes, constraints and springs, and of the colliders beside it. If the hash is
    /// another one now, it wakes. In the tick before it may fall asleep, of the same without positions: it falls asleep only if nothing of that has changed since.
    /// Default 0, also while it is otherwise awake.
    pub support_hash: u64,
}

/// How long a group must be still before it falls asleep, seconds: longer than an object thrown upwards stays slow at the top of its path.
const TIME_TO_SLEEP: f32 = 0.5;

/// Gap up to which bounds count as touching, metres, in addition to the way of their particles in a step.
const TOUCH_MARGIN: f32 = 0.01;

impl Default for Sleep {
    fn default() -> Self {
        Self {
            allowed: false,
            keeps_awake: false,
            speed: 0.02,
            still: 0.0,
            asleep: false,
            support_hash: 0,
        }
    }
}

impl Sleep {
    /// A body that may sleep and is awake.
    pub fn allowed() -> Self {
        Self { allowed: true, ..Self::default() }
    }
}

/// Working data of sleeping.
#[derive(Default)]
pub(super) struct SleepScratch {
    /// Islands that are visited in this step, ascending, and ranges of rows that contain theirs: all but dormant ones.
    visited: Vec<u32>,
    visited_rows: Vec<Range<usize>>,
    visited_bounds: Vec<(Vec3, Vec3)>,
    dormant: Dormant,
    /// Bounds that each island may reach in the step.
    bounds: Vec<(Vec3, Vec3)>,
    pieces: Pieces,
    activities: Vec<IslandActivity>,
    /// Force that gusts may exert on each island, N.
    pushes: Vec<f32>,
    pairs: Vec<[u32; 2]>,
    /// Islands near one: a buffer.
    near: Vec<u32>,
    broad: Broad,
    /// Union-find over islands; the root is the first island of a group.
    groups: UnionFind,
    /// The first island of each body.
    first_of: Vec<u32>,
    /// How far the shape of a body collider reaches beyond each of its particles, metres, by row; empty if the colliders have changed.
    bounding_radius: Vec<f32>,
    /// Rows put to sleep in this step, and their inverse masses.
    masses: Vec<(u32, f32)>,
    /// Support hash of each island; at the first island of a group, of all in the group.
    hashes: Vec<SupportHash>,
    /// [Edits](crate::Particles::edits) of the particles, the revision of `contacts`, and the hashes of [static geometry](support::of_surfaces), of
    /// [springs and hulls](support::of_springs_and_hulls) and of [ignored pairs](support::of_ignored) when supports were last compared; `None` if constraints,
    /// body colliders or particles were added or removed since.
    compared: Option<[u64; 5]>,
}

impl SleepScratch {
    /// Makes the next step compare the supports of all sleepers.
    pub(super) fn forget_support(&mut self) {
        self.compared = None;
        self.bounding_radius.clear();
        self.pieces.forget();
        self.dormant.forget();
    }
}

/// Activity of an island, and then of a group.
#[derive(Clone, Copy, Debug)]
struct IslandActivity {
    /// Whether a part of it moves, or keeps it awake.
    active: bool,
    /// Whether all of its bodies may sleep.
    allowed: bool,
    /// Whether all of its bodies sleep.
    asleep: bool,
    /// Time for which all of it has been still, seconds.
    still: f32,
    /// Whether it may not fall asleep yet, because its support is not the one that it had in the last step.
    unsettled: bool,
}

impl IslandActivity {
    /// A moving island; the other fields do not matter then.
    const MOVING: Self =
        Self { active: true, allowed: true, asleep: true, still: f32::INFINITY, unsettled: false };

    /// Whether its support is compared in this step of `dt` seconds: it sleeps, or falls asleep in this step or the next.
    fn is_drowsy(&self, dt: f32) -> bool {
        self.allowed && !self.active && self.still + dt >= TIME_TO_SLEEP
    }
}

/// Whether a particle of a body is still. A NaN velocity is not.
fn is_still(body: &Sleep, velocity: Vec4) -> bool {
    let speed = velocity.truncate().length();
    if body.asleep { speed == 0.0 } else { speed <= body.speed }
}

impl Simulation {
    /// Makes the next step check whether sleepers are where they were. To be called after loading other states into their rows by
    /// [`Particles::load`](crate::Particles::load).
    pub fn check_sleepers(&mut self) {
        self.scratch.rest = Default::default();
        self.scratch.sleep_scratch.0.forget_support();
    }

    /// Whether no particle of a sleeping body was written to since the last step. Then the rows of sleepers hold what that step left there, and a caller that
    /// keeps the state elsewhere need not load them.
    pub fn are_sleepers_untouched(&self) -> bool {
        let Self { particles, sleep, .. } = self;
        let sleeps = |&row: &u32| {
            let body = particles.body.get(row as usize).and_then(|&body| sleep.get(body as usize));
            body.is_some_and(|body| body.asleep)
        };
        particles.touched().is_some_and(|rows| !rows.iter().any(sleeps))
    }

    /// Decides which islands sleep in a step of `dt` seconds, and puts them to sleep.
    pub(super) fn put_to_sleep(&mut self, dt: f32) {
        let mut sleepers = core::mem::take(&mut self.scratch.sleep_scratch.0);
        if self.sleep.iter().any(|body| body.allowed) {
            let standing = support::of_surfaces(&self.colliders, &self.boundaries);
            let springs = support::of_springs_and_hulls(&self.forces);
            let ignored = support::of_ignored(&self.ignored);
            let now =
                [self.particles.edits(), self.contacts.revision(), standing, springs, ignored];
            let changed = sleepers.compared.replace(now) != Some(now);
            let inputs = self.sleep_inputs(dt, now);
            if !self.stays_dormant(&sleepers.dormant, &inputs) {
                sleepers.dormant.forget();
            }
            self.visit_islands(&mut sleepers, dt);
            if sleepers.dormant.is_near(&sleepers.visited, &sleepers.bounds)
                || self.wakes_dormant(&sleepers)
            {
                sleepers.dormant.forget();
                self.visit_islands(&mut sleepers, dt);
            }
            // Groups that are about to fall asleep store their support hash.
            let falls_asleep = |&number: &u32| {
                let island = sleepers.activities[number as usize];
                !island.asleep && island.is_drowsy(dt)
            };
            let compare = changed || sleepers.visited.iter().any(falls_asleep);
            self.group(&mut sleepers, compare);
            self.decide(&mut sleepers, dt, compare);
            let number = sleepers.dormant.number();
            self.note_dormant(&mut sleepers, inputs);
            self.scratch.plan.islands.dormant_number = number;
            self.particles.note_sleepers(self.sleep.iter().any(|body| body.asleep));
        } else {
            sleepers.dormant.forget();
            self.scratch.plan.islands.dormant_number = 0;
            self.scratch.plan.islands.list.iter_mut().for_each(|island| island.asleep = false);
            self.particles.note_sleepers(false);
        }
        self.scratch.sleep_scratch.0 = sleepers;
    }

    /// Whether a visited island moves that belongs to the same body as a dormant one.
    fn wakes_dormant(&self, sleepers: &SleepScratch) -> bool {
        let SleepScratch { dormant, activities, visited_rows, .. } = sleepers;
        let islands = &self.scratch.plan.islands.of;
        !dormant.is_empty()
            && visited_rows.iter().flat_map(Clone::clone).any(|row| {
                dormant.is_of_body(self.particles.body[row])
                    && activities[islands[row] as usize].active
            })
    }

    /// Restores the masses of sleepers, at the end of a step.
    pub(super) fn wake(&mut self) {
        let Self { particles, scratch, .. } = self;
        let SleepScratch { masses, dormant, .. } = &mut scratch.sleep_scratch.0;
        for (row, w) in masses.drain(..) {
            particles.position[row as usize].w = w;
        }
        dormant.wake(particles);
    }

    /// Measures the activity and the bounds of each island that is not dormant.
    fn visit_islands(&mut self, sleepers: &mut SleepScratch, dt: f32) {
        let islands = &mut self.scratch.plan.islands;
        let SleepScratch { visited, visited_rows, dormant, .. } = &mut *sleepers;
        dormant.others(islands, visited, visited_rows);
        for &number in visited.iter() {
            islands.list[number as usize].asleep = false;
        }
        self.measure_islands(sleepers, dt);
    }

    /// Measures the islands to visit.
    fn measure_islands(&self, sleepers: &mut SleepScratch, dt: f32) {
        let Self { particles, scratch, forces, .. } = self;
        if sleepers.bounding_radius.len() != particles.len() {
            sleepers.bounding_radius.clear();
            sleepers.bounding_radius.resize(particles.len(), 0.0);
            for solid in &self.body_colliders {
                let (low, high) = solid.shape.bounds();
                let reach = low.abs().max(high.abs()).length();
                for (&row, rest) in solid.rows.iter().zip(&*solid.rest) {
                    if let Some(bounding_radius) = sleepers.bounding_radius.get_mut(row as usize) {
                        *bounding_radius = bounding_radius.max(reach - rest.length());
                    }
                }
            }
        }
        let plan = &scratch.plan;
        let count = plan.islands.list.len();
        sleepers.bounds.resize(count, (Vec3::INFINITY, Vec3::NEG_INFINITY));
        sleepers.activities.resize(count, IslandActivity::MOVING);
        let (mut any_lie, visited) = (false, core::mem::take(&mut sleepers.visited));
        for &number in &visited {
            let activity = self.activity_of(&plan.islands.list[number as usize]);
            any_lie |= !activity.active;
            sleepers.activities[number as usize] = activity;
        }
        // Where all move, no bounds are needed, except to find what comes near dormant islands.
        if any_lie || !sleepers.dormant.is_empty() {
            self.enclose_islands(sleepers, &visited, dt);
        } else {
            for &number in &visited {
                sleepers.bounds[number as usize] = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            }
        }
        sleepers.visited = visited;
        self.stay_awake_in_gusts(sleepers);
        let controls =
            forces.controls.iter().filter(|control| control.is_valid() && !control.is_idle());
        let pushed = controls.flat_map(|control| &control.rows).chain(particles.woken());
        for &row in pushed {
            if let Some(&island) = plan.islands.of.get(row as usize) {
                sleepers.activities[island as usize].active = true;
            }
        }
        for pin in &self.boundaries.pins {
            let i = pin.particle as usize;
            let Some(&island) = plan.islands.of.get(i) else { continue };
            sleepers.activities[island as usize].active |=
                particles.relative_to(i, pin.target).length() > 1e-6;
        }
        // A sensor lets everything through.
        let moving = |one: &&Collider| one.start != one.end && !one.sensor && one.is_valid();
        for collider in self.colliders.iter().filter(moving) {
            let (start, end) = (
                collider.shape.bounds_in(&collider.start),
                collider.shape.bounds_in(&collider.end),
            );
            let (low, high) = (start.0.min(end.0), start.1.max(end.1));
            for (bounds, activity) in sleepers.bounds.iter().zip(&mut sleepers.activities) {
                activity.active |= bounds.0.cmple(high).all() && bounds.1.cmpge(low).all();
            }
        }
    }

    /// Activity of an island. Once a part of it moves, the other fields do not matter.
    fn activity_of(&self, island: &Island) -> IslandActivity {
        let Self { particles, forces, .. } = self;
        let mut activity = IslandActivity { active: false, ..IslandActivity::MOVING };
        for (i, body) in self.loose_members(island) {
            let pushed = particles.external[i] != Vec3::ZERO;
            if !is_still(&body, particles.velocity[i]) || pushed || body.keeps_awake {
                return IslandActivity { active: true, ..activity };
            }
            // Forces between charges change when any of them moves.
            let charged = particles.charge[i] != 0.0 && forces.electric.constant != 0.0;
            activity.allowed &= body.allowed && !charged;
            activity.asleep &= body.asleep;
            activity.still = activity.still.min(body.still);
        }
        if !activity.allowed {
            // It does not keep awake what lies still beside it.
            activity.still = f32::INFINITY;
        }
        activity
    }

    /// Bounds that each of these islands, and each piece of them, may reach in a step of `dt` seconds.
    fn enclose_islands(&self, sleepers: &mut SleepScratch, these: &[u32], dt: f32) {
        let Self { particles, scratch, forces, .. } = self;
        let plan = &scratch.plan;
        sleepers.pieces.begin(&self.body_colliders, &plan.islands, these);
        let fall = forces.gravity.length() * dt;
        for &number in these {
            let number = number as usize;
            let island = &plan.islands.list[number];
            let in_pieces = sleepers.pieces.are_several(number);
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for (i, body) in self.loose_members(island) {
                let velocity = particles.velocity[i];
                // The same margin for all that is still, so that the pairs do not change when a group falls asleep.
                let quiet = is_still(&body, velocity);
                let fastest = if quiet { body.speed } else { velocity.truncate().length() };
                let reach = (fastest + fall) * dt;
                let around =
                    particles.radius[i] + sleepers.bounding_radius[i] + TOUCH_MARGIN + reach;
                let at = particles.origin[i] + particles.position[i].truncate();
                (low, high) = (low.min(at - around), high.max(at + around));
                if in_pieces {
                    sleepers.pieces.add(i as u32, at, around);
                }
            }
            sleepers.bounds[number] = (low, high);
        }
    }

    /// The rows of an island that are not pinned, each with the sleep settings of its body; the default for particles without one.
    #[inline]
    fn loose_members(&self, island: &Island) -> impl Iterator<Item = (usize, Sleep)> {
        let Self { particles, scratch, sleep, .. } = self;
        let members = scratch.plan.islands.members[island.members.clone()].iter();
        // Neighbours mostly share their body.
        let (mut last, mut body) = (NO_BODY, Sleep::default());
        let loose = members.map(|&row| row as usize).filter(|&i| particles.position[i].w != 0.0);
        loose.map(move |i| {
            if particles.body[i] != last {
                last = particles.body[i];
                let own = sleep.get(last as usize).filter(|_| last != NO_BODY);
                body = own.copied().unwrap_or_default();
            }
            (i, body)
        })
    }

    /// Joins islands that touch, islands that a spring connects, and all islands of a body. Two islands that touch and both move are not joined: each keeps its
    /// group awake anyway.
    fn group(&self, sleepers: &mut SleepScratch, compare: bool) {
        let Self { particles, scratch, .. } = self;
        let SleepScratch {
            visited,
            visited_rows,
            visited_bounds,
            bounds,
            pieces,
            activities,
            pairs,
            near,
            broad,
            groups,
            first_of,
            ..
        } = sleepers;
        pairs.clear();
        let each = || visited.iter().map(|&number| &activities[number as usize]);
        // If all have been still for long enough, every group sleeps, whatever the grouping; if all move, none does.
        let (still, moving) = (
            each().all(|island| !island.active && island.still >= TIME_TO_SLEEP),
            each().all(|island| island.active),
        );
        let moves = |place: u32| activities[visited[place as usize] as usize].active;
        let lying = || (0..visited.len() as u32).filter(|&place| !moves(place));
        if (compare || !still) && !moving {
            visited_bounds.clear();
            visited_bounds.extend(visited.iter().map(|&number| bounds[number as usize]));
            if 2 * lying().count() > visited.len() {
                broad.pairs(visited_bounds, pairs);
                pairs.retain(|&[a, b]| !(moves(a) && moves(b)));
            } else {
                broad.fill(visited_bounds);
                for place in lying() {
                    near.clear();
                    broad.query(&visited_bounds[place as usize], visited_bounds, near);
                    // A pair of still islands was found by the first of them.
                    let others = near.iter().filter(|&&other| other > place || moves(other));
                    pairs.extend(others.map(|&other| [place, other]));
                }
            }
        }
        if visited.len() == bounds.len() {
            groups.reset(bounds.len());
        } else {
            groups.isolate(visited);
        }
        for &[a, b] in pairs.iter() {
            let [a, b] = [visited[a as usize], visited[b as usize]];
            if groups.root(a) != groups.root(b) && pieces.touch([a, b], bounds) {
                groups.unite(a, b);
            }
        }
        for spring in &self.forces.springs {
            let ends = [spring.a, spring.b].map(|row| scratch.plan.islands.of.get(row as usize));
            if let [Some(&a), Some(&b)] = ends {
                groups.unite(a, b);
            }
        }
        first_of.clear();
        first_of.resize(self.sleep.len(), u32::MAX);
        // Neighbours mostly share their body and their island.
        let mut last = None;
        for i in visited_rows.iter().flat_map(Clone::clone) {
            let (island, body) = (scratch.plan.islands.of[i], particles.body[i]);
            if last.replace((island, body)) == Some((island, body)) {
                continue;
            }
            if let Some(first) = first_of.get_mut(body as usize) {
                if *first == u32::MAX {
                    *first = island;
                }
                groups.unite(*first, island);
            }
        }
    }

    /// Sums up each group, and puts it to sleep or advances its time.
    fn decide(&mut self, sleepers: &mut SleepScratch, dt: f32, compare: bool) {
        let SleepScratch { activities, groups, visited, bounds, .. } = &mut *sleepers;
        for &island in visited.iter() {
            let root = groups.root(island) as usize;
            let own = activities[island as usize];
            let group = &mut activities[root];
            group.active |= own.active;
            group.still = group.still.min(own.still);
        }
        for &number in visited.iter() {
            let group = activities[groups.root(number) as usize];
            let number = number as usize;
            let may = activities[number].allowed && bounds[number].0.is_finite();
            self.scratch.plan.islands.list[number].asleep =
                may && !group.active && group.still >= TIME_TO_SLEEP;
        }
        if compare {
            self.compare_support(sleepers, dt);
        }
        let SleepScratch { activities, groups, masses, hashes, visited, dormant, .. } = sleepers;
        let Self { particles, sleep, scratch, .. } = self;
        // Borrowed once, because each mutable borrow of `sleep` counts as a change.
        let (sleep, plan) = (&mut **sleep, &mut scratch.plan);
        // The velocity and lag that a step leaves for a particle at rest.
        let still = Vec3::ZERO.extend(self.settings.integrator.lag(scratch.substep.length));
        dormant.stop(particles, still);
        for &number in visited.iter() {
            let root = groups.root(number) as usize;
            let group = activities[root];
            let number = number as usize;
            let island = &mut plan.islands.list[number];
            island.asleep &= !(group.active || group.unsettled);
            let is_drowsy = group.is_drowsy(dt) && activities[number].allowed;
            let mut last = None;
            for &row in &plan.islands.members[island.members.clone()] {
                let i = row as usize;
                if last.replace(particles.body[i]) == Some(particles.body[i]) && !island.asleep {
                    continue;
                }
                let Some(body) = sleep.get_mut(particles.body[i] as usize) else { continue };
                // The first particle of a body in its first island updates the body.
                let is_first = sleepers.first_of[particles.body[i] as usize] == number as u32;
                if is_first && !dormant.is_of_body(particles.body[i]) {
                    sleepers.first_of[particles.body[i] as usize] = u32::MAX;
                    // If all of it is pinned, it is not still, but held: when it is released it must not sleep in the air at once.
                    let is_held = group.still == f32::INFINITY && activities[number].allowed;
                    body.still = if group.active || is_held {
                        0.0
                    } else {
                        (body.still + dt).min(2.0 * TIME_TO_SLEEP)
                    };
                    body.asleep = island.asleep;
                    body.support_hash = match (island.asleep, compare) {
                        (true, true) => hashes[root].whole(),
                        (true, false) => body.support_hash,
                        (false, true) if is_drowsy => hashes[root].without_positions,
                        (false, _) => 0,
                    };
                }
                if island.asleep && particles.position[i].w > 0.0 {
                    masses.push((row, particles.position[i].w));
                    particles.position[i].w = 0.0;
                    particles.start[i] = particles.position[i];
                    particles.velocity[i] = still;
                    particles.rounding[i] = Vec4::ZERO;
                }
            }
        }
    }

    /// Sums up the support hashes of the islands of each group, and marks a group as active where a sleeping body's stored hash is another one, and as unsettled
    /// where that of a body that would fall asleep is.
    ///
    /// What lies still is not simulated any more from the step in which it falls asleep, so a support that was taken away just before that step would not be
    /// missed.
    fn compare_support(&self, sleepers: &mut SleepScratch, dt: f32) {
        let SleepScratch { activities, groups, hashes, bounds, visited, first_of, .. } = sleepers;
        let islands = &self.scratch.plan.islands;
        hashes.clear();
        hashes.resize(islands.list.len(), SupportHash::default());
        self.add_springs_and_hulls(hashes);
        self.add_shapes(hashes);
        self.add_ignored(hashes, first_of, |island| groups.root(island));
        for &number in visited.iter() {
            let group = activities[groups.root(number) as usize];
            let (island, hash) = (&islands.list[number as usize], &mut hashes[number as usize]);
            if island.asleep || group.is_drowsy(dt) {
                *hash += self.support_of(island, bounds[number as usize]);
            } else {
                *hash = SupportHash::default();
            }
        }
        for &number in visited.iter() {
            let root = groups.root(number) as usize;
            if root != number as usize {
                let own = hashes[number as usize];
                hashes[root] += own;
            }
        }
        for &number in visited.iter().filter(|&&number| islands.list[number as usize].asleep) {
            let island = &islands.list[number as usize];
            let root = groups.root(number) as usize;
            for &row in &islands.members[island.members.clone()] {
                let body = self.sleep.get(self.particles.body[row as usize] as usize);
                let Some(&Sleep { asleep, support_hash, .. }) = body else { continue };
                if asleep {
                    let changed = support_hash != 0 && support_hash != hashes[root].whole();
                    activities[root].active |= changed;
                } else {
                    activities[root].unsettled |= support_hash != hashes[root].without_positions;
                }
            }
        }
    }
}
