//! The angle at a joint of three particles, between two limits (physics.md C5).

use core::f32::consts::PI;

use glam::Vec3;

use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::wide::{Wide, beyond, is_size, numbers};
use crate::lanes::{LANES, Lanes, Vector, atan2};

/// Limits the angle `a b c` at the joint `b` of the particles `[a, b, c]` to a range within 0..=π.
///
/// The angle is unsigned: an elbow at rest at 180° may bend either way. For a joint that bends one way only, use a [`Hinge`](super::Hinge).
#[derive(Clone, Debug, PartialEq)]
pub struct Angle {
    /// Smallest angle, radians, 0 to `max`.
    pub min: f32,
    /// Largest angle, radians, `min` to π. π is a straight joint. Equal to `min`, it keeps one angle.
    pub max: f32,
    /// How stiff the constraint is. A compliance is in rad²/J.
    pub softness: Softness,
}

impl Angle {
    /// Hard limits, radians.
    pub fn between(min: f32, max: f32) -> Self {
        Self { min, max, softness: Softness::Hard }
    }

    /// A hard constraint that keeps the angle of `[a, b, c]` at these positions. If two of them coincide there is no angle, and it keeps 0.
    pub fn rest(positions: [Vec3; 3]) -> Self {
        let [a, b, c] = positions;
        let angle = between(a - b, c - b).map_or(0.0, |turn| turn.angle);
        Self::between(angle, angle)
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        let inside = |angle: f32| (0.0..=PI).contains(&angle);
        if particles != 3 {
            Some(ConstraintFault::Count)
        } else if !(inside(self.min) && inside(self.max)) {
            Some(ConstraintFault::Number)
        } else if self.min > self.max {
            Some(ConstraintFault::Limits)
        } else {
            None
        }
    }
}

/// `C = θ - max` above the range, `θ - min` (negative) below it, and zero inside, in radians: a two-sided inequality.
impl Equation for Angle {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let (u, v) = (points.at(0) - points.at(1), points.at(2) - points.at(1));
        let Some(turn) = between(u, v) else { return 0.0 };
        let value = beyond(turn.angle, self.min, self.max);
        if value != 0.0 {
            gradients[0] = turn.by_u;
            gradients[1] = -(turn.by_u + turn.by_v);
            gradients[2] = turn.by_v;
        }
        value
    }

    /// A single angle is kept from both sides.
    fn is_range(&self) -> bool {
        self.min < self.max
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }
}

/// The angle between two vectors, 0 to π, and its derivatives by each of them, rad/m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub(super) angle: f32,
    pub(super) by_u: Vec3,
    pub(super) by_v: Vec3,
}

/// The angle `θ = atan2(‖u×v‖, u·v)` between two vectors; `None` where one of them has no direction.
///
/// The arc tangent is accurate everywhere. The arc cosine loses half of its digits near 0 and π, where its derivative is infinite. With the unit normal `n =
/// u×v/‖u×v‖`, turning `u` about `n` by a small angle moves it by `n×u` per radian towards `v`. For a displacement of the end of `u` across its own length this
/// gives
///
/// ```text
/// ∂θ/∂u = -(n×û)/‖u‖        ∂θ/∂v = (n×v̂)/‖v‖
/// ```
///
/// and zero along `u` and along `n`. Where `u` and `v` are collinear (θ is 0 or π), every direction across them changes the angle alike, so the gradient is not
/// unique. One is chosen: `n` is `u` × the coordinate axis along which `u` is smallest. So a straight joint outside its limits does bend, always the same way.
#[inline]
pub(super) fn between(u: Vec3, v: Vec3) -> Option<Turn> {
    let (u_length, v_length) = (u.length(), v.length());
    if !(u_length > 0.0 && v_length > 0.0 && u_length.is_finite() && v_length.is_finite()) {
        return None;
    }
    let (u, v) = (u / u_length, v / v_length);
    let across = u.cross(v);
    let sine = across.length();
    let normal = if sine > 0.0 { across / sine } else { any_normal(u) };
    let angle = libm::atan2f(sine, u.dot(v));
    Some(Turn { angle, by_u: u.cross(normal) / u_length, by_v: normal.cross(v) / v_length })
}

/// A unit vector perpendicular to `u`: `u` × the coordinate axis along which `u` is smallest, the first such axis in a tie. `u` must not be zero.
#[inline]
pub(super) fn any_normal(u: Vec3) -> Vec3 {
    u.cross(Vec3::AXES[u.abs().min_position()]).normalize_or(Vec3::X)
}

/// The parameters of eight [`Angle`]s.
#[derive(Clone, Debug)]
pub(crate) struct Angles {
    min: [f32; LANES],
    max: [f32; LANES],
}

impl Wide<3> for Angles {
    type Kind = Angle;

    fn of(angles: [&Angle; LANES], _: [usize; LANES]) -> Self {
        Self { min: numbers(angles, |angle| angle.min), max: numbers(angles, |angle| angle.max) }
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 3]) -> (L, [Vector<L>; 3]) {
        let [a, b, c] = *points;
        let Turns { angle, by_u, by_v } = between_wide(a - b, c - b);
        let value = beyond(angle, L::load(&self.min), L::load(&self.max));
        (value, [by_u, -(by_u + by_v), by_v])
    }
}

/// Eight angles between two vectors, 0 to π (NaN where there is none), and their derivatives by each vector, rad/m.
pub(super) struct Turns<L> {
    pub(super) angle: L,
    pub(super) by_u: Vector<L>,
    pub(super) by_v: Vector<L>,
}

/// Eight lanes of the scalar `between`.
#[inline(always)]
pub(super) fn between_wide<L: Lanes>(u: Vector<L>, v: Vector<L>) -> Turns<L> {
    let (u_length, v_length) = (u.length(), v.length());
    let has_angle = is_size(u_length).and(is_size(v_length));
    let one = L::splat(1.0);
    let (by_u_length, by_v_length) = (one / u_length, one / v_length);
    let (u, v) = (u * by_u_length, v * by_v_length);
    let across = u.cross(v);
    let sine = across.length();
    let mut normal = across * (one / sine);
    let straight = sine.same(L::zero());
    if straight.any() {
        normal = any_normal_wide(u).or_else(straight, normal);
    }
    Turns {
        angle: has_angle.select(atan2(sine, u.dot(v)), L::splat(f32::NAN)),
        by_u: u.cross(normal) * by_u_length,
        by_v: normal.cross(v) * by_v_length,
    }
}

/// Eight lanes of the scalar `any_normal`.
#[inline(always)]
pub(super) fn any_normal_wide<L: Lanes>(u: Vector<L>) -> Vector<L> {
    let (x, y, z) = (u.x.abs(), u.y.abs(), u.z.abs());
    let (by_x, by_y, zero) = (x.le(y).and(x.le(z)), y.le(z), L::zero());
    let across = Vector::new(
        by_x.select(zero, by_y.select(-u.z, u.y)),
        by_x.select(u.z, by_y.select(zero, -u.x)),
        by_x.select(-u.y, by_y.select(u.x, zero)),
    );
    let inverse = L::splat(1.0) / across.length();
    (across * inverse).or_else(is_size(inverse), Vector::splat(Vec3::X))
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::*;
    use crate::{Constraint, ConstraintKind, Distance, ParticleSeed, Simulation};

    #[test]
    fn the_gradient_is_that_of_the_angle_from_sharp_to_blunt() {
        let mut random = Random::new(1);
        let mut checked = 0;
        for _ in 0..40 {
            let places = random.positions(3);
            let angle = Angle::rest([places[0], places[1], places[2]]).min;
            if !(0.3..2.8).contains(&angle)
                || places[1].distance(places[0]) < 0.4
                || places[1].distance(places[2]) < 0.4
            {
                continue; // Too close to a degenerate angle for finite differences.
            }
            checked += 1;
            assert_gradients(&Angle::between(0.0, angle - 0.2), &places);
            assert_gradients(&Angle::between(angle + 0.2, PI), &places);
        }
        assert!(checked >= 15, "{checked}");
    }

    #[test]
    fn it_keeps_momentum_and_its_limits_at_the_least_cost() {
        let mut random = Random::new(2);
        for _ in 0..20 {
            let (places, masses) = (random.positions(3), random.masses(3));
            let angle = Angle::rest([places[0], places[1], places[2]]).min;
            for equation in
                [Angle::between(0.0, angle * 0.6), Angle::between(0.4 * angle + 0.6 * PI, PI)]
            {
                assert_momentum_kept(&equation, &places, &masses);
                assert_kept(&equation, &places, &masses, 1e-5);
            }
        }
        let corner = [Vec3::X, Vec3::ZERO, Vec3::new(0.2, 1.5, 0.3)];
        assert_least(&Angle::between(0.0, 1.3), &corner, &[1.0, 2.0, 0.5]);
        assert_least(&Angle::between(1.5, PI), &corner, &[1.0, 2.0, 0.5]);
    }

    #[test]
    fn it_does_nothing_inside_its_range_and_says_how_far_outside_it_is() {
        let right = [Vec3::X, Vec3::ZERO, Vec3::Y];
        assert_eq!(evaluate(&Angle::between(1.0, 2.0), &right), (0.0, vec![Vec3::ZERO; 3]));
        assert!((evaluate(&Angle::between(0.0, 1.0), &right).0 - (PI / 2.0 - 1.0)).abs() < 1e-6);
        assert!((evaluate(&Angle::between(2.0, 3.0), &right).0 - (PI / 2.0 - 2.0)).abs() < 1e-6);
    }

    #[test]
    fn a_straight_joint_bends_and_a_folded_one_opens() {
        let straight = [-Vec3::X, Vec3::ZERO, Vec3::X];
        assert_kept(&Angle::between(0.0, 2.0), &straight, &[], 1e-4);
        let folded = [Vec3::X, Vec3::ZERO, Vec3::X * 2.0];
        assert_kept(&Angle::between(1.0, PI), &folded, &[], 1e-4);
        assert_momentum_kept(&Angle::between(0.0, 2.0), &straight, &[1.0, 2.0, 3.0]);
        assert_momentum_kept(&Angle::between(1.0, PI), &folded, &[1.0, 2.0, 3.0]);
    }

    #[test]
    fn it_survives_every_degenerate_set() {
        let places = Random::new(3).positions(3);
        for equation in
            [Angle::between(0.0, 0.1), Angle::between(3.0, PI), Angle::between(1.0, 1.0)]
        {
            assert_survives(&equation, &places);
            assert_survives(&equation.with_softness(Softness::frequency(5.0, 1.0)), &places);
        }
    }

    /// A rod hangs from a pinned bar at an angle of 90°, which the constraint alone keeps against gravity.
    #[test]
    fn a_bracket_carries_its_arm_as_long_as_its_angle_is_hard() {
        let lowest = |softness: Softness| {
            let mut world = Simulation::default();
            let places = [Vec3::Y, Vec3::ZERO, Vec3::X];
            for (i, at) in places.into_iter().enumerate() {
                let seed = ParticleSeed::at(at);
                world.particles.push(if i < 2 { seed.pinned() } else { seed }).unwrap();
            }
            world.distances_mut().push(Distance::new(1, 2, 1.0));
            let equation = Angle::rest(places).with_softness(softness);
            world
                .constraints_mut()
                .push(Constraint::new([0, 1, 2], ConstraintKind::Angle(equation)));
            let mut lowest = 0.0_f32;
            for _ in 0..180 {
                world.step(1.0 / 60.0).unwrap();
                lowest = lowest.min(world.particles.position(2).y);
            }
            lowest
        };
        let hard = lowest(Softness::Hard);
        assert!(hard > -2e-3, "{hard}");
        // At 2 Hz it sags by g/ω² = 62 mm, and the first swing reaches twice that.
        let soft = lowest(Softness::frequency(2.0, 0.0));
        assert!(soft < -0.08 && soft > -0.135, "{soft}");
    }

    #[test]
    fn faults_are_told_apart() {
        let good = Angle::between(0.0, 1.0);
        assert_eq!(good.fault(3), None);
        assert_eq!(good.fault(4), Some(ConstraintFault::Count));
        assert_eq!(Angle::between(1.0, 0.5).fault(3), Some(ConstraintFault::Limits));
        assert_eq!(Angle::between(-0.1, 0.5).fault(3), Some(ConstraintFault::Number));
        assert_eq!(Angle::between(0.0, 3.2).fault(3), Some(ConstraintFault::Number));
        assert_eq!(Angle::between(f32::NAN, 0.5).fault(3), Some(ConstraintFault::Number));
    }
}
