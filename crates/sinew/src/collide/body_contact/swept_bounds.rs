//! Swept bounds of body colliders: where each goes in a step.
//!
//! They say where a body collider goes in a step, extrapolated from the pose and the velocity at the broad phase, with a speculative margin beside
//! that path for spin and jolts. Pairs follow from their overlaps; a collider that leaves its bounds is searched for again.

use glam::{Vec3, Vec4};

use super::super::frame::Frame;
use super::super::world::World;
use super::BodyContactSolver;
use super::bodies::{ROTATION, rotation};
use super::turn::{LaneArray, load, set};
use crate::lanes::{LANES, Lanes, Vector};
use crate::particles::{NO_BODY, Particles};

/// How far from its path a body collider may be thrown in a step before contacts of it are looked for again, by what gravity alone does, `g dt²`. Of
/// a hundred ragdolls that roll down stairs there are always some that are jolted by more; more than this lists pairs that never touch, which costs
/// more than to look again at those few.
const JOLTED: f32 = 2.0;
/// The same by how far it goes: where there is no gravity, there are jolts all the same.
const SWERVED: f32 = 0.1;
/// And by its size, so that round-off is no jolt.
const SHAKEN: f32 = 1e-3;

/// A body collider where contacts of it were looked for, and how it goes on from there.
#[derive(Clone, Copy, Debug)]
pub(super) struct SweptBounds {
    /// Its centre, from its origin, metres.
    pub(super) centre: Vec3,
    /// Its own frame, from its origin.
    pub(super) frame: Frame,
    /// Of its centre, m/s.
    pub(super) velocity: Vec3,
    /// Speculative margin: how far beside its path a point of it may get in the step, metres.
    pub(super) speculative_margin: f32,
    pub(super) origin: Vec3,
    pub(super) body: u32,
    /// Its first particle.
    pub(super) row: u32,
    /// In the world: all that it may get to.
    pub(super) bounds: (Vec3, Vec3),
    pub(super) sound: bool,
}

impl Default for SweptBounds {
    fn default() -> Self {
        Self {
            centre: Vec3::ZERO,
            frame: Frame::IDENTITY,
            velocity: Vec3::ZERO,
            speculative_margin: 0.0,
            origin: Vec3::ZERO,
            body: NO_BODY,
            row: 0,
            bounds: (Vec3::NAN, Vec3::NAN),
            sound: false,
        }
    }
}

impl SweptBounds {
    /// How much nearer it may come in so many seconds to static geometry, metres.
    pub(super) fn reach(&self, time: f32) -> f32 {
        self.velocity.length() * time + self.speculative_margin
    }

    /// The same of another one, which has its own path.
    pub(super) fn reach_of(&self, other: &Self, time: f32) -> f32 {
        (self.velocity - other.velocity).length() * time
            + self.speculative_margin
            + other.speculative_margin
    }

    /// How far it may get against a direction, metres.
    pub(super) fn reach_against(&self, normal: Vec3, time: f32) -> f32 {
        (-normal.dot(self.velocity)).max(0.0) * time + self.speculative_margin
    }
}

/// The swept bounds of eight body colliders.
#[derive(Clone, Copy, Debug)]
pub(super) struct WideSweptBounds {
    /// Where they would have been when the step began, metres from their origins; and how fast they go, m/s.
    centre: [LaneArray; 3],
    velocity: [LaneArray; 3],
    rotation: [LaneArray; 4],
    /// Of those of two particles: the direction from the first to the second.
    line: [LaneArray; 3],
    /// Metres; infinite for none.
    speculative_margin: LaneArray,
    /// How far out they reach, metres.
    reach: LaneArray,
}

impl Default for WideSweptBounds {
    fn default() -> Self {
        let none = LaneArray::default();
        let vector = [none; 3];
        let (rotation, speculative_margin) = ([none; 4], [f32::INFINITY; LANES]);
        Self {
            centre: vector,
            velocity: vector,
            rotation,
            line: vector,
            speculative_margin,
            reach: none,
        }
    }
}

impl WideSweptBounds {
    /// Notes a body collider that is where it was seen so many seconds after the step began.
    fn put(
        &mut self,
        lane: usize,
        (swept, line): (&SweptBounds, Vec3),
        q: Vec4,
        reach: f32,
        time: f32,
    ) {
        set(&mut self.line, lane, line);
        set(&mut self.centre, lane, swept.centre - swept.velocity * time);
        set(&mut self.velocity, lane, swept.velocity);
        for (to, from) in self.rotation.iter_mut().zip(q.to_array()) {
            to[lane] = from;
        }
        (self.speculative_margin[lane], self.reach[lane]) = (swept.speculative_margin, reach);
    }

    /// Of body colliders of two particles, where their centres and the directions from the first to the second are now: the same by which [`left`](Self::left)
    /// goes, but for how they turn about their own lines, which takes no point of them anywhere.
    #[inline(always)]
    pub(super) fn lines_left<L: Lanes>(
        &self,
        centre: Vector<L>,
        line: Vector<L>,
        time: f32,
    ) -> u32 {
        let there = load::<L>(&self.centre) + load::<L>(&self.velocity) * L::splat(time);
        let turned = (line - load::<L>(&self.line)).length();
        let gone = (centre - there).length() + turned * L::load(&self.reach);
        L::load(&self.speculative_margin).lt(gone).bits() & 0xFF
    }

    /// A bit for each that is farther beside its path than its margin, so many seconds after the step began.
    #[inline(always)]
    pub(super) fn left<L: Lanes>(&self, centre: Vector<L>, [x, y, z, w]: [L; 4], time: f32) -> u32 {
        let [was_x, was_y, was_z, was_w] = &self.rotation;
        let was = Vector::new(L::load(was_x), L::load(was_y), L::load(was_z));
        let now = Vector::new(x, y, z);
        // Half of it is the sine of half the angle.
        let turned = now * L::load(was_w) - was * w - was.cross(now);
        let turned = turned.length() * L::splat(2.0);
        let there = load::<L>(&self.centre) + load::<L>(&self.velocity) * L::splat(time);
        let gone = (centre - there).length() + turned * L::load(&self.reach);
        L::load(&self.speculative_margin).lt(gone).bits() & 0xFF
    }
}

impl BodyContactSolver {
    /// Notes where a body collider is and how it goes on, after a share of the step. `rate` takes what was read as its step and its spin to speeds.
    pub(super) fn note_swept_bounds(
        &mut self,
        number: usize,
        particles: &Particles,
        world: &World,
        (share, rate): (f32, f32),
    ) {
        let Self { groups, bodies, swept, wide_swept, .. } = self;
        let part = &groups.parts[number];
        let first = groups.rows.get(part.entries.start);
        let touches = |&&row: &&u32| !world.filter.body(particles.body[row as usize]).disabled;
        let Some(&row) = first.filter(|_| part.sound).filter(touches) else {
            swept[number] = SweptBounds::default();
            return;
        };
        let (row, place) = (row as usize, groups.place(number));
        let [.., centre, step, spin, _] = &bodies[place];
        let (centre, step, spin) = (centre.truncate(), step.truncate(), spin.truncate());
        let (q, dt) = (bodies[place][ROTATION], world.dt);
        let (velocity, left) = (step * rate, dt * (1.0 - share));
        let way = velocity * left;
        let spun = spin.length() * rate * part.reach * left;
        let jolted = JOLTED * world.g() * dt * dt;
        let speculative_margin = spun + jolted + SWERVED * way.length() + SHAKEN * part.reach;
        let origin = particles.origin[row];
        let r = rotation(q);
        let frame = Frame { translation: centre - r * part.centre, rotation: r };
        let sound = centre.is_finite()
            && way.is_finite()
            && speculative_margin.is_finite()
            && q.is_finite();
        let (low, high) = world.body_colliders[number].shape.bounds_in(&frame);
        // Far out the sum with the origin is rounded.
        let wide = speculative_margin + 1e-6 * (origin.abs().max_element() + 1.0);
        let (low, high) = (low + way.min(Vec3::ZERO), high + way.max(Vec3::ZERO));
        let bounds = (low + origin - wide, high + origin + wide);
        let bounds = if sound { bounds } else { (Vec3::NAN, Vec3::NAN) };
        let body = particles.body[row];
        let row = row as u32;
        let one = SweptBounds {
            centre,
            frame,
            velocity,
            speculative_margin,
            origin,
            body,
            row,
            bounds,
            sound,
        };
        swept[number] = one;
        let eight = &mut wide_swept[place / LANES];
        let lane = place % LANES;
        if sound {
            let line = match &*world.body_colliders[number].rest {
                &[from, to] => r * (to - from).normalize_or_zero(),
                _ => Vec3::ZERO,
            };
            eight.put(lane, (&one, line), q, part.reach, dt * share);
        } else {
            eight.speculative_margin[lane] = f32::INFINITY;
        }
    }
}
