//! Move and slide: moves a kinematic object, such as a player's character, through a tick with sliding along obstacles.
//!
//! The shape moves until an obstacle is a skin width away, loses the part of its velocity that leads into the obstacle, and continues for the rest of the time.
//! If that leads into another obstacle it already touches, it moves along the edge between the two; if that leads into a third, it stops: the rule of *Quake*'s
//! `PM_SlideMove` (1996), which Godot and Avian use, too. What overlaps it at the start pushes it out first.
//!
//! A floor is a surface level enough to stand on. It carries the whole weight, so that nothing slides down it by gravity. A steeper surface does not deflect
//! motion upwards, and lets everything slide down. Climbing steps is left to the game, as in Avian: one cast up, one move, one cast down.

use glam::Vec3;

use super::queries::{FARTHEST_CAST, SweptHit};
use super::{Filter, Hit, Simulation};
use crate::collide::{AtStart, Frame, Shape, SweepHit, SweepMotion};

/// Parameters of [`Simulation::move_and_slide`]. Values out of range are clamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlideConfig {
    /// The direction against gravity, of any length but zero. Default +y.
    pub up: Vec3,
    /// The steepest slope that counts as a floor, rad from the level, 0 to π/2. Default π/4.
    pub max_slope: f32,
    /// Distance kept from everything, metres, 1e-4 to 1. Default 0.01.
    pub skin_width: f32,
    /// Most changes of direction, 1 to 32. Default 8.
    pub iterations: u32,
    /// Most rounds of pushing out of what overlaps at the start, 0 to 32; 0 disables it. Default 8.
    pub depenetration_iterations: u32,
}

/// Result of [`Simulation::move_and_slide`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlideOutput {
    /// New position of the shape's origin, metres.
    pub translation: Vec3,
    /// Remaining velocity, m/s: without the parts that led into obstacles.
    pub velocity: Vec3,
    /// The floor that it stands on, within two skin widths below; `None` while it moves upwards off the floor.
    pub ground: Option<Hit>,
    /// Obstacles in the order in which they were hit, once for each hit. `distance` is the way from the last change of direction.
    pub hits: Vec<Hit>,
}

impl Default for SlideConfig {
    fn default() -> Self {
        Self {
            up: Vec3::Y,
            max_slope: core::f32::consts::FRAC_PI_4,
            skin_width: 0.01,
            iterations: 8,
            depenetration_iterations: 8,
        }
    }
}

impl SlideConfig {
    /// Whether a surface with this unit normal counts as a floor.
    pub fn is_floor(&self, normal: Vec3) -> bool {
        self.clamped().is_some_and(|config| config.slope(normal) == Slope::Floor)
    }

    fn clamped(&self) -> Option<Clamped> {
        // In this order NaN becomes `low`.
        let within = |x: f32, low: f32, high: f32| x.max(low).min(high);
        let max_slope = within(self.max_slope, 0.0, core::f32::consts::FRAC_PI_2);
        Some(Clamped {
            up: self.up.try_normalize()?,
            // With a margin for rounding, so that a slope of exactly `max_slope` is a floor.
            level: libm::cosf(max_slope) - 1e-4,
            skin: within(self.skin_width, 1e-4, 1.0),
            iterations: self.iterations.clamp(1, 32),
            pushes: self.depenetration_iterations.min(32),
        })
    }
}

impl Simulation {
    /// Moves a convex shape with a velocity, m/s, for `delta` seconds, as far as possible, sliding along obstacles. The world is not changed: the caller stores
    /// the new position and velocity. Nothing is tunnelled through, however fast the shape is; the way without a change of direction is at most 1e6 m. With
    /// arguments that are not finite, a zero `up`, or a shape that is not convex nothing moves; with a zero velocity the shape is still pushed out of what
    /// overlaps it. To be called between steps.
    pub fn move_and_slide(
        &self,
        shape: &Shape,
        frame: &Frame,
        velocity: Vec3,
        delta: f32,
        config: &SlideConfig,
        filter: &Filter,
    ) -> SlideOutput {
        let still = SlideOutput { translation: frame.translation, ..SlideOutput::default() };
        let Some(config) = config.clamped().filter(|_| shape.is_convex()) else { return still };
        if !(frame.is_valid() && (velocity * delta).is_finite() && velocity.is_finite())
            || delta < 0.0
        {
            return still;
        }
        let mut slide = Slide {
            world: self,
            shape,
            frame: *frame,
            filter,
            config,
            velocity,
            planes: Vec::new(),
            arrival: velocity,
            hits: Vec::new(),
        };
        slide.push_out();
        slide.advance(delta);
        let ground = slide.ground();
        let Slide { frame, velocity, hits, .. } = slide;
        SlideOutput { translation: frame.translation, velocity, ground, hits }
    }
}

/// [`SlideConfig`] with every value in its range.
#[derive(Clone, Copy)]
struct Clamped {
    up: Vec3,
    /// Least upward component of the normal of a floor.
    level: f32,
    skin: f32,
    iterations: u32,
    pushes: u32,
}

#[derive(Clone, Copy, PartialEq)]
enum Slope {
    Floor,
    /// Steeper than a floor, with a normal that points upwards.
    Steep,
    WallOrCeiling,
}

/// A move in progress.
struct Slide<'a> {
    world: &'a Simulation,
    shape: &'a Shape,
    frame: Frame,
    filter: &'a Filter,
    config: Clamped,
    velocity: Vec3,
    /// The planes that it touches, and the velocity with which it came there. Velocities along several planes are projected from that one velocity; projected
    /// one after the other, they could turn back against it.
    planes: Vec<SweepHit>,
    arrival: Vec3,
    hits: Vec<Hit>,
}

/// Obstacles nearer than this fraction of the skin push. A shape at rest on something is no nearer than 98 %, so it stays at rest.
const PUSH_BELOW: f32 = 0.95;
/// Pushes smaller than this fraction of the skin end the loop: between two walls that both push it ends there.
const SETTLED: f32 = 1e-3;
/// Regularisation of the pushes: where there is too little room, they have one solution in the middle.
const REGULARISATION: f32 = 0.1;
/// Gauss–Seidel rounds over the pushes.
const PUSH_ROUNDS: usize = 48;
/// A velocity that leads into a plane by less than this fraction of the speed counts as along it.
const PARALLEL: f32 = 1e-5;

impl Slide<'_> {
    fn cast(&self, direction: Vec3, length: f32, along: &[SweepHit]) -> Option<SweptHit> {
        let (clearance, start) = (self.config.skin, AtStart::Entered);
        let motion = SweepMotion { direction, length, clearance, start, along };
        self.world.sweep(self.shape, &self.frame, &motion, self.filter)
    }

    /// Pushes the shape out of what overlaps it and its skin, as far as there is room.
    fn push_out(&mut self) {
        let skin = self.config.skin;
        for _ in 0..self.config.pushes {
            let (low, high) = self.shape.bounds_in(&self.frame);
            let mut near: Vec<(Vec3, f32)> = Vec::new();
            self.world.obstacles((low - skin, high + skin), self.filter, &mut |_, _, obstacle| {
                self.shape.contacts(&self.frame, PUSH_BELOW * skin, obstacle, &mut |hit| {
                    near.push((hit.normal.as_vec3(), skin - hit.distance));
                });
            });
            let push = smallest_push(&near);
            let length = push.length();
            // Out of something so large that the push overflows there is no way, either.
            if !length.is_finite() || length <= SETTLED * skin {
                return;
            }
            let direction = push / length;
            // The push must not lead through what it does not touch yet.
            let (clearance, start) = (0.1 * skin, AtStart::Passed);
            let motion = SweepMotion { direction, length, clearance, start, along: &[] };
            let met = self.world.sweep(self.shape, &self.frame, &motion, self.filter);
            self.frame.translation += direction * met.map_or(length, |met| met.at.distance);
        }
    }

    /// Moves for `delta` seconds.
    fn advance(&mut self, delta: f32) {
        let mut left = delta;
        for _ in 0..self.config.iterations {
            let speed = self.velocity.length();
            let length = speed * left;
            if length.is_nan() || length <= 0.0 {
                return;
            }
            let direction = self.velocity / speed;
            let far = length.min(FARTHEST_CAST);
            let Some(met) = self.cast(direction, far, &self.planes) else {
                self.frame.translation += direction * far;
                return;
            };
            if met.at.distance > 0.0 {
                self.frame.translation += direction * met.at.distance;
                left *= 1.0 - met.at.distance / length;
                self.drop_planes();
            }
            self.planes.push(met.at);
            self.hits.push(met.hit());
            self.velocity = self.clip_to_planes();
        }
    }

    /// Drops the planes that it no longer touches.
    fn drop_planes(&mut self) {
        let (planes, skin) = (core::mem::take(&mut self.planes), self.config.skin);
        let touched =
            |plane: &SweepHit| self.cast(-plane.normal.as_vec3(), 0.1 * skin, &[]).is_some();
        let before = planes.len();
        let planes: Vec<SweepHit> = planes.into_iter().filter(touched).collect();
        if planes.len() < before {
            self.arrival = self.velocity;
        }
        self.planes = planes;
    }

    /// The part of the velocity that leads into none of the touched planes: along the last plane, or an earlier one, or the edge between two of them.
    fn clip_to_planes(&self) -> Vec3 {
        let velocity = self.arrival;
        let planes: Vec<Vec3> = self.planes.iter().map(|plane| plane.normal.as_vec3()).collect();
        let grain = PARALLEL * velocity.length();
        let free = |v: Vec3| planes.iter().all(|plane| v.dot(*plane) >= -grain);
        // Below rounding it is zero, so that a shape at rest stays at rest.
        let kept = |v: Vec3| if v.length() <= 1e-6 * velocity.length() { Vec3::ZERO } else { v };
        let single = planes.iter().rev().map(|plane| {
            let v = self.config.clip(velocity, *plane);
            v - *plane * v.dot(*plane).min(0.0)
        });
        let pairs = (0..planes.len()).rev().flat_map(|i| (0..i).map(move |j| (i, j)));
        let edges = pairs.filter_map(|(i, j)| {
            let edge = planes[i].cross(planes[j]).try_normalize()?;
            let v = self.config.clip(self.config.clip(velocity, planes[i]), planes[j]);
            Some(edge * edge.dot(v))
        });
        single.chain(edges).map(kept).find(|v| free(*v)).unwrap_or(Vec3::ZERO)
    }

    /// The floor under the final position.
    fn ground(&self) -> Option<Hit> {
        let Self { velocity, config: Clamped { up, skin, .. }, .. } = *self;
        let hit = self.cast(-up, skin, &[])?.hit();
        let rises = velocity.dot(up) > 1e-3 && velocity.dot(hit.normal) > 1e-3;
        (self.config.slope(hit.normal) == Slope::Floor && !rises).then_some(hit)
    }
}

impl Clamped {
    fn slope(&self, normal: Vec3) -> Slope {
        match normal.dot(self.up) {
            up if up >= self.level => Slope::Floor,
            up if up > 1e-3 => Slope::Steep,
            _ => Slope::WallOrCeiling,
        }
    }

    /// Removes from a velocity what a slope blocks before the rest is projected onto it. A floor removes as much of a downward velocity as leads into it, so
    /// that weight does not become motion downhill; a steep slope removes the horizontal velocity against it, so that it cannot be climbed.
    fn clip(&self, velocity: Vec3, normal: Vec3) -> Vec3 {
        let up = self.up;
        match self.slope(normal) {
            Slope::Floor => {
                let into = velocity.dot(normal) / normal.dot(up);
                velocity - up * into.min(0.0).max(velocity.dot(up).min(0.0))
            }
            Slope::Steep => {
                let level = (normal - up * normal.dot(up)).normalize_or_zero();
                velocity - level * velocity.dot(level).min(0.0)
            }
            Slope::WallOrCeiling => velocity,
        }
    }
}

/// The smallest push that satisfies each requirement, `(normal, metres along it)`, or comes nearest to that: projected Gauss–Seidel with regularisation.
fn smallest_push(near: &[(Vec3, f32)]) -> Vec3 {
    let mut push = Vec3::ZERO;
    let mut shares = vec![0.0_f32; near.len()];
    for _ in 0..PUSH_ROUNDS {
        for (share, (normal, required)) in shares.iter_mut().zip(near) {
            let missing = required - normal.dot(push) - REGULARISATION * *share;
            let more = (*share + missing / (1.0 + REGULARISATION)).max(0.0) - *share;
            *share += more;
            push += *normal * more;
        }
    }
    push
}

#[cfg(test)]
mod tests;
