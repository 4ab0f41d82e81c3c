//! Swept bounds of body colliders: the AABB that each sweeps in a step.
//!
//! The sweep is extrapolated from the pose and the velocity at the broad phase, with a speculative margin around the path for spin and jolts. Pairs follow
//! from the overlaps of the bounds; a body collider that leaves its bounds is queried again.

use glam::{Vec3, Vec4};

use super::super::frame::Frame;
use super::super::world::World;
use super::BodyContactSolver;
use super::bodies::{ROTATION, rotation};
use super::turn::{LaneArray, load, set};
use crate::lanes::{LANES, Lanes, Vector};
use crate::particles::{NO_BODY, Particles};

/// Speculative margin for jolts as a multiple of what gravity alone moves in a step, `g dt²`. In a hundred ragdolls that roll down stairs some always exceed
/// it; a wider margin lists pairs that never touch, which costs more than to query those few again.
const JOLT_MARGIN: f32 = 2.0;
/// The same as a share of the distance travelled in the step: jolts happen without gravity, too.
const PATH_MARGIN: f32 = 0.1;
/// The same as a share of the collider's reach, so that round-off does not count as leaving the bounds.
const SIZE_MARGIN: f32 = 1e-3;

/// Pose, velocity and bounds of a body collider at its last broad-phase query.
#[derive(Clone, Copy, Debug)]
pub(super) struct SweptBounds {
    /// Centre, from its origin, metres.
    pub(super) centre: Vec3,
    /// Frame of the shape, from its origin.
    pub(super) frame: Frame,
    /// Velocity of its centre, m/s, and angular velocity, rad/s.
    pub(super) velocity: Vec3,
    pub(super) spin: Vec3,
    /// Speculative margin: how far from its extrapolated path a point of it may get in the step before pairs are searched again, metres.
    pub(super) speculative_margin: f32,
    pub(super) origin: Vec3,
    pub(super) body: u32,
    /// Row of its first particle.
    pub(super) row: u32,
    /// Swept AABB in the world; NaN of an invalid one.
    pub(super) bounds: (Vec3, Vec3),
    pub(super) sound: bool,
}

impl Default for SweptBounds {
    fn default() -> Self {
        Self {
            centre: Vec3::ZERO,
            frame: Frame::IDENTITY,
            velocity: Vec3::ZERO,
            spin: Vec3::ZERO,
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
    /// How far it may approach static geometry in `time` seconds, metres.
    pub(super) fn reach(&self, time: f32) -> f32 {
        self.velocity.length() * time + self.speculative_margin
    }

    /// How far it and another body collider may approach each other in `time` seconds, metres.
    pub(super) fn reach_of(&self, other: &Self, time: f32) -> f32 {
        (self.velocity - other.velocity).length() * time
            + self.speculative_margin
            + other.speculative_margin
    }

    /// How far it may move against a direction in `time` seconds, metres.
    pub(super) fn reach_against(&self, normal: Vec3, time: f32) -> f32 {
        (-normal.dot(self.velocity)).max(0.0) * time + self.speculative_margin
    }
}

/// Swept bounds of eight body colliders.
#[derive(Clone, Copy, Debug)]
pub(super) struct WideSweptBounds {
    /// Centres extrapolated back to when the step began, metres from their origins; velocities, m/s.
    centre: [LaneArray; 3],
    velocity: [LaneArray; 3],
    rotation: [LaneArray; 4],
    /// Of body colliders of two particles: the direction from the first to the second.
    line: [LaneArray; 3],
    /// Metres; infinite in empty lanes.
    speculative_margin: LaneArray,
    /// Greatest distance of the surface from the centre, metres.
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
    /// Sets a lane from what was measured `time` seconds after the step began.
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

    /// Like [`outside`](Self::outside), for body colliders of two particles, from their centres and the directions from the first to the second particle. Turns
    /// about their own line are left out: they move no point of a capsule.
    #[inline(always)]
    pub(super) fn lines_outside<L: Lanes>(
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

    /// Returns a bit for each lane that is farther from its extrapolated path than its margin, `time` seconds after the step began.
    #[inline(always)]
    pub(super) fn outside<L: Lanes>(
        &self,
        centre: Vector<L>,
        [x, y, z, w]: [L; 4],
        time: f32,
    ) -> u32 {
        let [was_x, was_y, was_z, was_w] = &self.rotation;
        let was = Vector::new(L::load(was_x), L::load(was_y), L::load(was_z));
        let now = Vector::new(x, y, z);
        // Its half is the sine of half the angle.
        let turned = now * L::load(was_w) - was * w - was.cross(now);
        let turned = turned.length() * L::splat(2.0);
        let there = load::<L>(&self.centre) + load::<L>(&self.velocity) * L::splat(time);
        let gone = (centre - there).length() + turned * L::load(&self.reach);
        L::load(&self.speculative_margin).lt(gone).bits() & 0xFF
    }
}

impl BodyContactSolver {
    /// Sets the swept bounds of a body collider from its pose and velocity after a fraction `share` of the step. `rate` converts the extracted step and spin
    /// to velocities, 1/s, or is 1 if they are velocities.
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
        let travel = velocity * left;
        let spun = spin.length() * rate * part.reach * left;
        let jolted = JOLT_MARGIN * world.g() * dt * dt;
        let speculative_margin =
            spun + jolted + PATH_MARGIN * travel.length() + SIZE_MARGIN * part.reach;
        let origin = particles.origin[row];
        let r = rotation(q);
        let frame = Frame { translation: centre - r * part.centre, rotation: r };
        let sound = centre.is_finite()
            && travel.is_finite()
            && speculative_margin.is_finite()
            && q.is_finite();
        let (low, high) = world.body_colliders[number].shape.bounds_in(&frame);
        // Far from the world's origin the sum with its own origin is rounded.
        let wide = speculative_margin + 1e-6 * (origin.abs().max_element() + 1.0);
        let (low, high) = (low + travel.min(Vec3::ZERO), high + travel.max(Vec3::ZERO));
        let bounds = (low + origin - wide, high + origin + wide);
        let bounds = if sound { bounds } else { (Vec3::NAN, Vec3::NAN) };
        let body = particles.body[row];
        let row = row as u32;
        let one = SweptBounds {
            centre,
            frame,
            velocity,
            spin: spin * rate,
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
