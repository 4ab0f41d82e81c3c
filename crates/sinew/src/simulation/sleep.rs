//! Sleep: what lies still, with everything that it touches, is left out of the steps until something wakes it.
//!
//! Bodies sleep and wake in groups: islands with a box about a piece of each that touch (`pieces`), and all islands of a body. When all of a group have been still for [`SECONDS`], it
//! falls asleep: its particles stop and count as pinned, so that what comes near finds them in its way, and its constraints are not asked. A group
//! wakes
//!
//! - when one of its particles was given a velocity, a force or a control, or [is to wake](crate::Particles::wake);
//! - when something that moves comes near, or a collider near it moves;
//! - when what it is made of and hangs on is not the same: places, masses, constraints, springs, and what it lay beside (`support`).
//!
//! What gusts may move does not sleep in them (`gusts`). Who has slept for long, and lies where nobody comes near, is not looked at (`dormant`).
//!
//! Nothing else is remembered: what is to survive a step is in [`Sleep`], a body's own.

mod dormant;
mod gusts;
mod pieces;
mod support;

use core::ops::Range;

use glam::{Vec3, Vec4};

use dormant::Dormant;
use pieces::Pieces;

use super::Simulation;
use crate::collide::Broad;
use crate::islands::Island;
use crate::particles::NO_BODY;
use crate::union_find::UnionFind;

/// Whether a body may sleep, and for how long it has been still: configuration and live state, to be saved and restored with its particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sleep {
    /// Whether it may. Default not.
    pub allowed: bool,
    /// Whether it is to stay awake, and with it all that touches it, however still it lies. Default not.
    pub keeps_awake: bool,
    /// A particle slower than this is still, m/s, 0 and up. Default 0.02.
    pub speed: f32,
    /// For how long all of it have been still, seconds. Default 0.
    pub still: f32,
    /// Whether it sleeps. Default not. To wake a body, clear this and `still`.
    pub asleep: bool,
    /// Hash of what it and all that it lay beside were made of, lay on and hung on when it fell asleep; where that is another one, it wakes. Default 0, while it is
    /// awake.
    pub support_hash: u64,
}

/// How long a group has to be still before it falls asleep, seconds: longer than anything thrown up is slow at its height.
const SECONDS: f32 = 0.5;

/// How near boxes have to be to count as touching, metres, beside what their particles may cover in a step.
const NEAR: f32 = 0.01;

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
    /// May sleep, and is awake.
    pub fn allowed() -> Self {
        Self { allowed: true, ..Self::default() }
    }
}

/// Scratch of the sleeping decision.
#[derive(Default)]
pub(super) struct SleepScratch {
    /// Islands that are looked at in this step, ascending, and stretches of rows in which theirs are: all but dormant ones.
    looked: Vec<u32>,
    looked_rows: Vec<Range<usize>>,
    looked_bounds: Vec<(Vec3, Vec3)>,
    dormant: Dormant,
    /// Of each island.
    bounds: Vec<(Vec3, Vec3)>,
    pieces: Pieces,
    activities: Vec<IslandActivity>,
    /// How much gusts may push each island, N.
    pushes: Vec<f32>,
    pairs: Vec<[u32; 2]>,
    /// Who is near one.
    near: Vec<u32>,
    broad: Broad,
    /// Towards the first island of a group.
    groups: UnionFind,
    /// The first island of each body.
    first_of: Vec<u32>,
    /// How far the shape of a body collider reaches beyond its particles, metres, for each row; empty if those have changed.
    bounding_radius: Vec<f32>,
    /// Rows that sleep, and their inverse masses.
    masses: Vec<(u32, f32)>,
    /// Of each island what it is made of and hangs on, and, at the first island of a group, of all that sleep in it.
    hashes: Vec<u64>,
    /// [Edits](crate::Particles::edits) of the particles, the revision of how bodies touch, and the hashes of [what stands](support::of_surfaces) and of
    /// [springs](support::of_springs) when that was last looked at; `None` if constraints or particles have come or gone since.
    seen: Option<[u64; 4]>,
}

impl SleepScratch {
    /// Has what sleepers are made of looked at in the next step.
    pub(super) fn forget_support(&mut self) {
        self.seen = None;
        self.bounding_radius.clear();
        self.pieces.forget();
        self.dormant.forget();
    }
}

/// How an island, and then a group, lies.
#[derive(Clone, Copy, Debug)]
struct IslandActivity {
    /// Whether something of it moves, or keeps it from sleeping.
    active: bool,
    /// Whether all of it may sleep.
    allowed: bool,
    /// Whether all of it sleeps.
    asleep: bool,
    /// For how long all of it have been still, seconds.
    still: f32,
}

impl IslandActivity {
    /// Of one that moves nothing else counts.
    const MOVING: Self = Self { active: true, allowed: true, asleep: true, still: f32::INFINITY };
}

/// Whether a particle of a body lies still; also not where it moves by NaN.
fn is_quiet(body: &Sleep, velocity: Vec4) -> bool {
    let speed = velocity.truncate().length();
    if body.asleep { speed == 0.0 } else { speed <= body.speed }
}

impl Simulation {
    /// Has the next step look whether sleepers are where they were: for who writes others than they have by
    /// [`Particles::load`](crate::Particles::load).
    pub fn check_sleepers(&mut self) {
        self.scratch.rest = Default::default();
        self.scratch.sleep_scratch.0.forget_support();
    }

    /// Whether nobody has written to a particle of a sleeper since the last step put it to sleep. Then all of it stands in its rows as that step has left it, and who
    /// loads it from elsewhere need not.
    pub fn are_sleepers_untouched(&self) -> bool {
        let Self { particles, sleep, .. } = self;
        let sleeps = |&row: &u32| {
            let body = particles.body.get(row as usize).and_then(|&body| sleep.get(body as usize));
            body.is_some_and(|body| body.asleep)
        };
        particles.touched().is_some_and(|rows| !rows.iter().any(sleeps))
    }

    /// Finds which bodies sleep in a step of `dt` seconds, and puts them to sleep.
    pub(super) fn put_to_sleep(&mut self, dt: f32) {
        let mut sleepers = core::mem::take(&mut self.scratch.sleep_scratch.0);
        if self.sleep.iter().any(|body| body.allowed) {
            let standing = support::of_surfaces(&self.colliders, &self.boundaries);
            let springs = support::of_springs(&self.forces.springs);
            let now = [self.particles.edits(), self.contacts.revision(), standing, springs];
            let changed = sleepers.seen.replace(now) != Some(now);
            let inputs = self.sleep_inputs(dt, now);
            if !self.leaves_dormant(&sleepers.dormant, &inputs) {
                sleepers.dormant.forget();
            }
            self.look_at_islands(&mut sleepers, dt);
            if sleepers.dormant.is_near(&sleepers.looked, &sleepers.bounds)
                || self.wakes_dormant(&sleepers)
            {
                sleepers.dormant.forget();
                self.look_at_islands(&mut sleepers, dt);
            }
            // Who falls asleep remembers what it lies on.
            let falls = |&number: &u32| {
                let island = sleepers.activities[number as usize];
                island.allowed && !island.asleep && !island.active && island.still >= SECONDS
            };
            let compare = changed || sleepers.looked.iter().any(falls);
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

    /// Whether something of a body moves of which another island is dormant.
    fn wakes_dormant(&self, sleepers: &SleepScratch) -> bool {
        let SleepScratch { dormant, activities, looked_rows, .. } = sleepers;
        let islands = &self.scratch.plan.islands.of;
        !dormant.is_empty()
            && looked_rows.iter().flat_map(Clone::clone).any(|row| {
                dormant.is_of_body(self.particles.body[row])
                    && activities[islands[row] as usize].active
            })
    }

    /// Wakes: gives those that sleep their masses back, at the end of a step.
    pub(super) fn wake(&mut self) {
        let Self { particles, scratch, .. } = self;
        let SleepScratch { masses, dormant, .. } = &mut scratch.sleep_scratch.0;
        for (row, w) in masses.drain(..) {
            particles.position[row as usize].w = w;
        }
        dormant.wake(particles);
    }

    /// Looks at each island but dormant ones: how it lies, and the box that it may reach in the step.
    fn look_at_islands(&mut self, sleepers: &mut SleepScratch, dt: f32) {
        let islands = &mut self.scratch.plan.islands;
        let SleepScratch { looked, looked_rows, dormant, .. } = &mut *sleepers;
        dormant.others(islands, looked, looked_rows);
        for &number in looked.iter() {
            islands.list[number as usize].asleep = false;
        }
        self.measure_islands(sleepers, dt);
    }

    /// Looks at the islands that are to be looked at.
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
        let (mut any_lie, looked) = (false, core::mem::take(&mut sleepers.looked));
        for &number in &looked {
            let activity = self.activity_of(&plan.islands.list[number as usize]);
            any_lie |= !activity.active;
            sleepers.activities[number as usize] = activity;
        }
        // Where all move nobody is asked whom it touches, but by those that are dormant.
        if any_lie || !sleepers.dormant.is_empty() {
            self.enclose_islands(sleepers, &looked, dt);
        } else {
            for &number in &looked {
                sleepers.bounds[number as usize] = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            }
        }
        sleepers.looked = looked;
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
        for collider in self.colliders.iter().filter(|one| one.start != one.end && one.is_valid()) {
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

    /// How an island lies. Of one that moves nothing else counts.
    fn activity_of(&self, island: &Island) -> IslandActivity {
        let Self { particles, forces, .. } = self;
        let mut activity =
            IslandActivity { active: false, allowed: true, asleep: true, still: f32::INFINITY };
        for (i, body) in self.loose_members(island) {
            let pushed = particles.external[i] != Vec3::ZERO;
            if !is_quiet(&body, particles.velocity[i]) || pushed || body.keeps_awake {
                return IslandActivity { active: true, ..activity };
            }
            // What charges do to each other changes with each of them.
            let charged = particles.charge[i] != 0.0 && forces.electric.constant != 0.0;
            activity.allowed &= body.allowed && !charged;
            activity.asleep &= body.asleep;
            activity.still = activity.still.min(body.still);
        }
        if !activity.allowed {
            // It keeps nobody awake who lies still beside it.
            activity.still = f32::INFINITY;
        }
        activity
    }

    /// The box that each of some islands, and each piece of it, may reach in a step of `dt` seconds.
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
                // The same for all that is quiet, so that who touches whom does not change when they fall asleep.
                let quiet = is_quiet(&body, velocity);
                let fastest = if quiet { body.speed } else { velocity.truncate().length() };
                let reach = (fastest + fall) * dt;
                let around = particles.radius[i] + sleepers.bounding_radius[i] + NEAR + reach;
                let at = particles.origin[i] + particles.position[i].truncate();
                (low, high) = (low.min(at - around), high.max(at + around));
                if in_pieces {
                    sleepers.pieces.add(i as u32, at, around);
                }
            }
            sleepers.bounds[number] = (low, high);
        }
    }

    /// The rows of an island that are not pinned, each with how its body sleeps: by default where it has none.
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

    /// Joins islands that touch, those that a spring ties, and those of a body. Two that touch and both move are left as they are: neither lets anybody sleep,
    /// whoever else is with them.
    fn group(&self, sleepers: &mut SleepScratch, compare: bool) {
        let Self { particles, scratch, .. } = self;
        let SleepScratch {
            looked,
            looked_rows,
            looked_bounds,
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
        let each = || looked.iter().map(|&number| &activities[number as usize]);
        // Where all lie still and have done so for long, each group sleeps, whoever is in it; and where all move, none does.
        let (still, moving) = (
            each().all(|island| !island.active && island.still >= SECONDS),
            each().all(|island| island.active),
        );
        let moves = |place: u32| activities[looked[place as usize] as usize].active;
        let lying = || (0..looked.len() as u32).filter(|&place| !moves(place));
        if (compare || !still) && !moving {
            looked_bounds.clear();
            looked_bounds.extend(looked.iter().map(|&number| bounds[number as usize]));
            if 2 * lying().count() > looked.len() {
                broad.pairs(looked_bounds, pairs);
                pairs.retain(|&[a, b]| !(moves(a) && moves(b)));
            } else {
                broad.fill(looked_bounds);
                for place in lying() {
                    near.clear();
                    broad.around(&looked_bounds[place as usize], looked_bounds, near);
                    // Of two that lie still the first one has asked.
                    let others = near.iter().filter(|&&other| other > place || moves(other));
                    pairs.extend(others.map(|&other| [place, other]));
                }
            }
        }
        if looked.len() == bounds.len() {
            groups.reset(bounds.len());
        } else {
            groups.part(looked);
        }
        for &[a, b] in pairs.iter() {
            let [a, b] = [looked[a as usize], looked[b as usize]];
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
        // Neighbours mostly are of one body and of one island.
        let mut last = None;
        for i in looked_rows.iter().flat_map(Clone::clone) {
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

    /// Sums up each group, and lets it sleep, or lets its time go on.
    fn decide(&mut self, sleepers: &mut SleepScratch, dt: f32, compare: bool) {
        let SleepScratch { activities, groups, looked, bounds, .. } = &mut *sleepers;
        for &island in looked.iter() {
            let root = groups.root(island) as usize;
            let own = activities[island as usize];
            let group = &mut activities[root];
            group.active |= own.active;
            group.still = group.still.min(own.still);
        }
        for &number in looked.iter() {
            let group = activities[groups.root(number) as usize];
            let number = number as usize;
            let may = activities[number].allowed && bounds[number].0.is_finite();
            self.scratch.plan.islands.list[number].asleep =
                may && !group.active && group.still >= SECONDS;
        }
        if compare {
            self.compare_support(sleepers);
        }
        let SleepScratch { activities, groups, masses, hashes, looked, dormant, .. } = sleepers;
        let Self { particles, sleep, scratch, .. } = self;
        // Borrowed once: each time counts as a change.
        let (sleep, plan) = (&mut **sleep, &mut scratch.plan);
        // As a step would leave what stands still.
        let still = Vec3::ZERO.extend(self.settings.integrator.lag(scratch.substep.length));
        dormant.stop(particles, still);
        for &number in looked.iter() {
            let root = groups.root(number) as usize;
            let group = activities[root];
            let number = number as usize;
            let island = &mut plan.islands.list[number];
            island.asleep &= !group.active;
            let mut last = None;
            for &row in &plan.islands.members[island.members.clone()] {
                let i = row as usize;
                if last.replace(particles.body[i]) == Some(particles.body[i]) && !island.asleep {
                    continue;
                }
                let Some(body) = sleep.get_mut(particles.body[i] as usize) else { continue };
                // Of many particles of a body the first tells.
                let tells = sleepers.first_of[particles.body[i] as usize] == number as u32;
                if tells && !dormant.is_of_body(particles.body[i]) {
                    sleepers.first_of[particles.body[i] as usize] = u32::MAX;
                    body.still =
                        if group.active { 0.0 } else { (body.still + dt).min(2.0 * SECONDS) };
                    body.asleep = island.asleep;
                    body.support_hash = match (island.asleep, compare) {
                        (true, true) => hashes[root],
                        (true, false) => body.support_hash,
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

    /// Sums up what those of each group that are to sleep are made of and hang on, and wakes all of one in which that is not what it was.
    fn compare_support(&self, sleepers: &mut SleepScratch) {
        let SleepScratch { activities, groups, hashes, bounds, looked, .. } = sleepers;
        let islands = &self.scratch.plan.islands;
        hashes.clear();
        hashes.resize(islands.list.len(), 0);
        self.add_springs(hashes);
        for number in looked.iter().map(|&number| number as usize) {
            let (island, hash) = (&islands.list[number], &mut hashes[number]);
            *hash = if island.asleep {
                hash.wrapping_add(self.support_of(island, bounds[number]))
            } else {
                0
            };
        }
        for &number in looked.iter() {
            let root = groups.root(number) as usize;
            if root != number as usize {
                hashes[root] = hashes[root].wrapping_add(hashes[number as usize]);
            }
        }
        for &number in looked.iter().filter(|&&number| islands.list[number as usize].asleep) {
            let island = &islands.list[number as usize];
            let root = groups.root(number) as usize;
            let bodies = islands.members[island.members.clone()].iter();
            let other = |&row: &u32| {
                let body = self.sleep.get(self.particles.body[row as usize] as usize);
                body.is_some_and(|body| {
                    body.asleep && body.support_hash != 0 && body.support_hash != hashes[root]
                })
            };
            activities[root].active |= bodies.into_iter().any(other);
        }
    }
}
