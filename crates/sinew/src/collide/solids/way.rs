//! Where solids go in a step: from where contacts were looked for on as fast as they went there, and beside that way as far as spin and jolts may
//! take them. What may come to touch what follows from that; who leaves his way is looked after again (`astray`).

use glam::{Vec3, Vec4};

use super::super::{Frame, World};
use super::Solids;
use super::bodies::{ROTATION, rotation};
use super::found::set;
use super::turn::{Eight, load};
use crate::lanes::{LANES, Lanes, Vector};
use crate::particles::{NO_BODY, Particles};

/// How far from its way a solid may be thrown in a step before contacts of it are looked for again, by what gravity alone does, `g dt²`. Of a hundred
/// ragdolls that roll down stairs there are always some that are jolted by more; more than this lists pairs that never touch, which costs more
/// than to look again at those few.
const JOLTED: f32 = 2.0;
/// The same by how far it goes: where there is no gravity, there are jolts all the same.
const SWERVED: f32 = 0.1;
/// And by its size, so that round-off is no jolt.
const SHAKEN: f32 = 1e-3;

/// A solid where contacts of it were looked for, and how it goes on from there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Its centre, from its origin, metres.
    pub(super) centre: Vec3,
    /// Its own frame, from its origin.
    pub(super) frame: Frame,
    /// Of its centre, m/s.
    pub(super) velocity: Vec3,
    /// How far beside its way a point of it may get in the step, metres.
    pub(super) beside: f32,
    pub(super) origin: Vec3,
    pub(super) body: u32,
    /// Its first particle.
    pub(super) row: u32,
    /// In the world: all that it may get to.
    pub(super) bounds: (Vec3, Vec3),
    pub(super) sound: bool,
}

impl Default for Seen {
    fn default() -> Self {
        Self {
            centre: Vec3::ZERO,
            frame: Frame::IDENTITY,
            velocity: Vec3::ZERO,
            beside: 0.0,
            origin: Vec3::ZERO,
            body: NO_BODY,
            row: 0,
            bounds: (Vec3::NAN, Vec3::NAN),
            sound: false,
        }
    }
}

impl Seen {
    /// How much nearer it may come in so many seconds to what stands still, metres.
    pub(super) fn reach(&self, time: f32) -> f32 {
        self.velocity.length() * time + self.beside
    }

    /// The same of another one, which has its own way.
    pub(super) fn reach_of(&self, other: &Self, time: f32) -> f32 {
        (self.velocity - other.velocity).length() * time + self.beside + other.beside
    }

    /// How far it may get against a direction, metres.
    pub(super) fn reach_against(&self, normal: Vec3, time: f32) -> f32 {
        (-normal.dot(self.velocity)).max(0.0) * time + self.beside
    }
}

/// The ways of eight solids.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// Where they would have been when the step began, metres from their origins; and how fast they go, m/s.
    centre: [Eight; 3],
    velocity: [Eight; 3],
    rotation: [Eight; 4],
    /// Metres; infinite for none.
    beside: Eight,
    /// How far out they reach, metres.
    reach: Eight,
}

impl Default for Ways {
    fn default() -> Self {
        let none = Eight::default();
        let vector = [none; 3];
        let (rotation, beside) = ([none; 4], [f32::INFINITY; LANES]);
        Self { centre: vector, velocity: vector, rotation, beside, reach: none }
    }
}

impl Ways {
    /// Notes a solid that is where it was seen so many seconds after the step began.
    fn put(&mut self, lane: usize, seen: &Seen, q: Vec4, reach: f32, time: f32) {
        set(&mut self.centre, lane, seen.centre - seen.velocity * time);
        set(&mut self.velocity, lane, seen.velocity);
        for (to, from) in self.rotation.iter_mut().zip(q.to_array()) {
            to[lane] = from;
        }
        (self.beside[lane], self.reach[lane]) = (seen.beside, reach);
    }

    /// A bit for each that is farther beside its way than expected, so many seconds after the step began.
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
        L::load(&self.beside).lt(gone).bits() & 0xFF
    }
}

impl Solids {
    /// Notes where a solid is and how it goes on, after a share of the step. `rate` takes what was read as its step and its spin to speeds.
    pub(super) fn note(
        &mut self,
        number: usize,
        particles: &Particles,
        world: &World,
        (share, rate): (f32, f32),
    ) {
        let Self { groups, bodies, seen, ways, .. } = self;
        let part = &groups.parts[number];
        let first = groups.rows.get(part.entries.start);
        let touches = |&&row: &&u32| !world.filter.body(particles.body[row as usize]).disabled;
        let Some(&row) = first.filter(|_| part.sound).filter(touches) else {
            seen[number] = Seen::default();
            return;
        };
        let (row, place) = (row as usize, groups.place(number));
        let [.., centre, step, spin, _] = bodies[place].map(Vec4::truncate);
        let (q, dt) = (bodies[place][ROTATION], world.dt);
        let (velocity, left) = (step * rate, dt * (1.0 - share));
        let way = velocity * left;
        let spun = spin.length() * rate * part.reach * left;
        let jolted = JOLTED * world.gravity * dt * dt;
        let beside = spun + jolted + SWERVED * way.length() + SHAKEN * part.reach;
        let origin = particles.origin[row];
        let r = rotation(q);
        let frame = Frame { translation: centre - r * part.centre, rotation: r };
        let sound = centre.is_finite() && way.is_finite() && beside.is_finite() && q.is_finite();
        let (low, high) = world.solids[number].shape.bounds_in(&frame);
        // Far out the sum with the origin is rounded.
        let wide = beside + 1e-6 * (origin.abs().max_element() + 1.0);
        let (low, high) = (low + way.min(Vec3::ZERO), high + way.max(Vec3::ZERO));
        let bounds = (low + origin - wide, high + origin + wide);
        let bounds = if sound { bounds } else { (Vec3::NAN, Vec3::NAN) };
        let body = particles.body[row];
        let row = row as u32;
        let one = Seen { centre, frame, velocity, beside, origin, body, row, bounds, sound };
        seen[number] = one;
        let eight = &mut ways[place / LANES];
        let lane = place % LANES;
        if sound {
            eight.put(lane, &one, q, part.reach, dt * share);
        } else {
            eight.beside[lane] = f32::INFINITY;
        }
    }
}
