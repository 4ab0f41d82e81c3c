//! Move and slide: where something that a game moves by itself, such as a player's character, comes to in a tick.
//!
//! It goes its way until something is a skin's width away, takes the part of its velocity that leads into that out, and goes on with the rest of the time. Where
//! the rest leads into something that it touches already, it goes along the edge between the two, and where that leads into a third, nowhere: the rule of
//! *Quake*'s `PM_SlideMove` (1996), which Godot and Avian have, too. What overlaps it at the start pushes it out first.
//!
//! A floor is what is level enough to stand on. It takes the weight whole, so that nothing slides down on it that does not go; what is steeper turns nobody
//! upwards who goes against it, and slides everybody down. Climbing steps is left to the game, as it is in Avian: one cast up, one move, one cast down.

use glam::Vec3;

use super::queries::SweptHit;
use super::{Filter, Hit, Simulation};
use crate::collide::{AtStart, Frame, Shape, SweepHit, SweepMotion};

/// How something moves and slides. What is not in its range is clamped to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlideConfig {
    /// Against gravity, of any length but zero. Default +y.
    pub up: Vec3,
    /// The steepest slope that it can stand on, rad from the level, 0 to π/2. Default π/4.
    pub max_slope: f32,
    /// How far it keeps off everything, metres, 1e-4 to 1. Default 0.01.
    pub skin_width: f32,
    /// How often it may turn, 1 to 32. Default 8.
    pub iterations: u32,
    /// How often it may be pushed out of what overlaps it at the start, 0 to 32; 0 for never. Default 8.
    pub depenetration_iterations: u32,
}

/// Where something that moved and slid has come to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlideOutput {
    /// Where its origin is, metres.
    pub translation: Vec3,
    /// The velocity that is left, m/s: without what led into what it met.
    pub velocity: Vec3,
    /// The floor that it stands on, within two skin widths below; none while it rises from there.
    pub ground: Option<Hit>,
    /// What was in its way, in that order, once for each time. `distance` is how far it went to there since it turned last.
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
    /// Whether something can stand on a surface with this unit normal.
    pub fn is_floor(&self, normal: Vec3) -> bool {
        self.clamped().is_some_and(|config| config.slope(normal) == Slope::Floor)
    }

    fn clamped(&self) -> Option<Clamped> {
        // In this order, NaN is the least.
        let within = |x: f32, low: f32, high: f32| x.max(low).min(high);
        let max_slope = within(self.max_slope, 0.0, core::f32::consts::FRAC_PI_2);
        Some(Clamped {
            up: self.up.try_normalize()?,
            // A slope of exactly that much is a floor, as rounding has it.
            level: libm::cosf(max_slope) - 1e-4,
            skin: within(self.skin_width, 1e-4, 1.0),
            iterations: self.iterations.clamp(1, 32),
            pushes: self.depenetration_iterations.min(32),
        })
    }
}

impl Simulation {
    /// Moves a shape without dents by a velocity, m/s, for `delta` seconds, as far as it can, sliding along what is in the way. Nothing is changed: the new
    /// place and the velocity that is left are for the caller to keep. It goes through nothing, however fast it is, and no farther than 1e6 m. Numbers that
    /// are not finite, an `up` without a direction, and shapes with dents do not move; a velocity of zero is still pushed out of what overlaps it. To be
    /// asked between steps.
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
            came: velocity,
            hits: Vec::new(),
        };
        slide.push_out();
        slide.go(delta);
        let ground = slide.ground();
        let Slide { frame, velocity, hits, .. } = slide;
        SlideOutput { translation: frame.translation, velocity, ground, hits }
    }
}

/// The same with every number in its range.
#[derive(Clone, Copy)]
struct Clamped {
    up: Vec3,
    /// The least part of a normal upwards on what can be stood on.
    level: f32,
    skin: f32,
    iterations: u32,
    pushes: u32,
}

#[derive(Clone, Copy, PartialEq)]
enum Slope {
    Floor,
    /// Steeper than that, upwards all the same.
    Steep,
    WallOrCeiling,
}

/// Something on its way.
struct Slide<'a> {
    world: &'a Simulation,
    shape: &'a Shape,
    frame: Frame,
    filter: &'a Filter,
    config: Clamped,
    velocity: Vec3,
    /// What it touches, and the velocity with which it came to there: what leads along all of them is a part of that, and never goes back against it,
    /// as what is led along one after the other would.
    planes: Vec<SweepHit>,
    came: Vec3,
    hits: Vec<Hit>,
}

/// How far it goes without turning at most, metres: as far as a cast looks.
const FARTHEST: f32 = 1e6;
/// What is nearer than this part of the skin pushes. Where it rests it is no nearer than 98 %, so that it rests.
const PUSHES: f32 = 0.95;
/// A push that is a smaller part of the skin than this is none: between two walls that both push it ends there.
const SETTLED: f32 = 1e-3;
/// How much pushes yield to each other, so that between what leaves too little room there is one place in the middle.
const YIELDS: f32 = 0.1;
/// Rounds in which pushes are shared out.
const SHARES: usize = 48;
/// What leads into a plane by less than this part of the speed leads along it.
const ALONG: f32 = 1e-5;

impl Slide<'_> {
    fn cast(&self, direction: Vec3, length: f32, along: &[SweepHit]) -> Option<SweptHit> {
        let (clearance, start) = (self.config.skin, AtStart::Entered);
        let way = SweepMotion { direction, length, clearance, start, along };
        self.world.sweep(self.shape, &self.frame, &way, self.filter)
    }

    /// Out of what overlaps it and its skin, as far as that is free.
    fn push_out(&mut self) {
        let skin = self.config.skin;
        for _ in 0..self.config.pushes {
            let (low, high) = self.shape.bounds_in(&self.frame);
            let mut near: Vec<(Vec3, f32)> = Vec::new();
            self.world.obstacles((low - skin, high + skin), self.filter, &mut |_, _, obstacle| {
                self.shape.contacts(&self.frame, PUSHES * skin, obstacle, &mut |hit| {
                    near.push((hit.normal.as_vec3(), skin - hit.distance));
                });
            });
            let push = shared(&near);
            let length = push.length();
            // Nor out of what is so large that there is no number for the way.
            if !length.is_finite() || length <= SETTLED * skin {
                return;
            }
            let direction = push / length;
            // Not through what it does not touch yet.
            let (clearance, start) = (0.1 * skin, AtStart::Passed);
            let way = SweepMotion { direction, length, clearance, start, along: &[] };
            let met = self.world.sweep(self.shape, &self.frame, &way, self.filter);
            self.frame.translation += direction * met.map_or(length, |met| met.at.distance);
        }
    }

    /// Its way.
    fn go(&mut self, delta: f32) {
        let mut left = delta;
        for _ in 0..self.config.iterations {
            let speed = self.velocity.length();
            let length = speed * left;
            if length.is_nan() || length <= 0.0 {
                return;
            }
            let direction = self.velocity / speed;
            let far = length.min(FARTHEST);
            let Some(met) = self.cast(direction, far, &self.planes) else {
                self.frame.translation += direction * far;
                return;
            };
            if met.at.distance > 0.0 {
                self.frame.translation += direction * met.at.distance;
                left *= 1.0 - met.at.distance / length;
                self.leave_planes();
            }
            self.planes.push(met.at);
            self.hits.push(met.hit());
            self.velocity = self.along_planes();
        }
    }

    /// Forgets what it touched where it was before.
    fn leave_planes(&mut self) {
        let (planes, skin) = (core::mem::take(&mut self.planes), self.config.skin);
        let touched =
            |plane: &SweepHit| self.cast(-plane.normal.as_vec3(), 0.1 * skin, &[]).is_some();
        let before = planes.len();
        let planes: Vec<SweepHit> = planes.into_iter().filter(touched).collect();
        if planes.len() < before {
            self.came = self.velocity;
        }
        self.planes = planes;
    }

    /// What of the velocity leads into nothing that it touches: along the plane that came last, or one before it, or the edge between two of them.
    fn along_planes(&self) -> Vec3 {
        let velocity = self.came;
        let planes: Vec<Vec3> = self.planes.iter().map(|plane| plane.normal.as_vec3()).collect();
        let grain = ALONG * velocity.length();
        let free = |v: Vec3| planes.iter().all(|plane| v.dot(*plane) >= -grain);
        // Less than rounding leaves is nothing: what stands, stands.
        let kept = |v: Vec3| if v.length() <= 1e-6 * velocity.length() { Vec3::ZERO } else { v };
        let single = planes.iter().rev().map(|plane| {
            let v = self.config.off(velocity, *plane);
            v - *plane * v.dot(*plane).min(0.0)
        });
        let pairs = (0..planes.len()).rev().flat_map(|i| (0..i).map(move |j| (i, j)));
        let edges = pairs.filter_map(|(i, j)| {
            let edge = planes[i].cross(planes[j]).try_normalize()?;
            let v = self.config.off(self.config.off(velocity, planes[i]), planes[j]);
            Some(edge * edge.dot(v))
        });
        single.chain(edges).map(kept).find(|v| free(*v)).unwrap_or(Vec3::ZERO)
    }

    /// What it stands on in the end.
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

    /// What a slope takes of a velocity before the rest is led along it: a floor of a fall as much as leads into it, so that a weight does not become a way
    /// downhill; what is steep all of a way against it, so that nobody runs up.
    fn off(&self, velocity: Vec3, normal: Vec3) -> Vec3 {
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

/// The least push that does what each of some normals asks for, metres along it, or comes as near to that as it can.
fn shared(near: &[(Vec3, f32)]) -> Vec3 {
    let mut push = Vec3::ZERO;
    let mut shares = vec![0.0_f32; near.len()];
    for _ in 0..SHARES {
        for (share, (normal, asked)) in shares.iter_mut().zip(near) {
            let lacks = asked - normal.dot(push) - YIELDS * *share;
            let more = (*share + lacks / (1.0 + YIELDS)).max(0.0) - *share;
            *share += more;
            push += *normal * more;
        }
    }
    push
}

#[cfg(test)]
mod tests;
