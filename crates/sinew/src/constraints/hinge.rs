//! The signed angle about an axis of two particles, between two limits (physics.md C5), which is also the dihedral angle of bending (C9).

use core::f32::consts::TAU;

use glam::Vec3;

use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::wide::{CLEAR, Wide, beyond, is_below, is_size, numbers};
use crate::lanes::{LANES, Lanes, Vector, atan2};

/// Limits the signed angle about the axis `h0 → h1` from the half-plane of `a` to the half-plane of `c`. The particles are `[a, h0, h1, c]`.
///
/// The angle is in -π to π, positive by the right-hand rule about `h0 → h1` for a turn from `a` to `c`. Uses:
///
/// - **A hinge**, such as an elbow or a knee: `h0` and `h1` are the pin of the hinge, `a` and `c` lie on the two bones. A straight joint has the angle π, so an
///   elbow that closes by 150° and never bends backward is [`between`](Self::between)(30°, 180°), or (180°, 330°) if it closes the other way.
/// - **Bending** of two triangles with the common edge `h0 h1`: [`rest`](Self::rest) keeps the dihedral angle; flat is π.
/// - **A twist limit**: the particles are [a reference in the parent, the joint, the child's far end, a reference in the child], so that the axis is the bone
///   itself.
///
/// An angle outside the range is corrected the shorter way round: -179° is 1° above a range of 170° to 180°. Where `a` or `c` lies on the axis there is no
/// angle, and nothing is done.
#[derive(Clone, Debug, PartialEq)]
pub struct Hinge {
    /// Smallest angle, radians, -2π to 2π, so that a range may extend across π (170° to 190°).
    pub min: f32,
    /// Largest angle, radians, `min` (which keeps one angle) to 2π, and at most 2π above `min` (no limit).
    pub max: f32,
    /// How stiff the constraint is. A compliance is in rad²/J.
    pub softness: Softness,
}

impl Hinge {
    /// Hard limits, radians.
    pub fn between(min: f32, max: f32) -> Self {
        Self { min, max, softness: Softness::Hard }
    }

    /// A hard constraint that keeps the angle of `[a, h0, h1, c]` at these positions; 0 where there is none.
    pub fn rest(positions: [Vec3; 4]) -> Self {
        let angle = dihedral(positions).map_or(0.0, |(angle, _)| angle);
        Self::between(angle, angle)
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        let inside = |angle: f32| (-TAU..=TAU).contains(&angle);
        if particles != 4 {
            Some(ConstraintFault::Count)
        } else if !(inside(self.min) && inside(self.max) && self.max - self.min <= TAU) {
            Some(ConstraintFault::Number)
        } else if self.min > self.max {
            Some(ConstraintFault::Limits)
        } else {
            None
        }
    }
}

/// `C` is how far the angle is above the range, or (negative) below it, in radians, and zero inside.
impl Equation for Hinge {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let places = [points.at(0), points.at(1), points.at(2), points.at(3)];
        let Some((angle, by)) = dihedral(places) else { return 0.0 };
        // Measured from the middle of the range, the shorter way round.
        let (middle, half) = (0.5 * (self.min + self.max), 0.5 * (self.max - self.min));
        let value = beyond(wrapped(angle - middle), -half, half);
        if value != 0.0 {
            gradients.copy_from_slice(&by);
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

/// Wraps an angle to -π to π.
fn wrapped(angle: f32) -> f32 {
    angle - TAU * (angle / TAU).round()
}

/// The dihedral angle and its gradients, rad/m; `None` where the axis has no length or one of the outer particles lies on it.
///
/// With the unit axis `ê` along `e = h1 - h0`, `n = ê×(a - h0)` is as long as the distance of `a` from the axis, and points where `a` moves as it turns about
/// `ê`; `m = ê×(c - h0)` likewise. The angle from one half-plane to the other is the angle from `n` to `m`: `φ = atan2(ê·(n×m), n·m)`, which is accurate
/// everywhere and signed. If `a` moves by `δ`, its half-plane turns by `δ·n/‖n‖²`, so
///
/// ```text
/// ∂φ/∂a = -n/‖n‖²        ∂φ/∂c = m/‖m‖²
/// ```
///
/// Along the edge, `a` is at `s = (a - h0)·e/‖e‖²` (0 at `h0`, 1 at `h1`), and `c` at `t`. If `h1` moves by `δ`, the point of the axis nearest to `a` moves by
/// `s δ`, which turns the half-plane as if `a` had moved by `-s δ`. If `h0` moves, `1 - s` takes the place of `s`:
///
/// ```text
/// ∂φ/∂h0 = -(1 - s) ∂φ/∂a - (1 - t) ∂φ/∂c        ∂φ/∂h1 = -s ∂φ/∂a - t ∂φ/∂c
/// ```
///
/// (Bridson et al., *Simulation of Clothing with Folds and Wrinkles*, 2003, in other notation.) Unlike an unsigned angle, this one has a gradient where the
/// joint is straight or folded flat, too.
fn dihedral([a, h0, h1, c]: [Vec3; 4]) -> Option<(f32, [Vec3; 4])> {
    let edge = h1 - h0;
    let length = edge.length();
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    let axis = edge / length;
    let (to_a, to_c) = (a - h0, c - h0);
    let (n, m) = (axis.cross(to_a), axis.cross(to_c));
    let (n_square, m_square) = (n.length_squared(), m.length_squared());
    // Below a millionth of the distance, the component across the axis is round-off.
    let on_axis = |across: f32, to: Vec3| across <= 1e-12 * to.length_squared();
    if on_axis(n_square, to_a) || on_axis(m_square, to_c) {
        return None;
    }
    let angle = libm::atan2f(axis.dot(n.cross(m)), n.dot(m));
    let (by_a, by_c) = (-n / n_square, m / m_square);
    let (s, t) = (to_a.dot(axis) / length, to_c.dot(axis) / length);
    let by_h0 = by_a * (s - 1.0) + by_c * (t - 1.0);
    Some((angle, [by_a, by_h0, by_a * -s - by_c * t, by_c]))
}

/// The parameters of eight [`Hinge`]s.
#[derive(Clone, Debug)]
pub(crate) struct Hinges {
    /// The middle of each range, an angle in -π to π, radians.
    middle: [f32; LANES],
    /// Half its width, radians.
    half: [f32; LANES],
    /// Cosine and sine of the middle. `clear` below is a cosine that is above that of half the width by a safe margin.
    towards: [[f32; LANES]; 2],
    clear: [f32; LANES],
    /// Whether any of them has a range rather than a single angle.
    is_limit: bool,
}

impl Wide<4> for Hinges {
    const IS_LIMIT: bool = true;

    type Kind = Hinge;

    fn of(hinges: [&Hinge; LANES], _: [usize; LANES]) -> Self {
        let middle = |hinge: &Hinge| wrapped(0.5 * (hinge.min + hinge.max));
        let half = |hinge: &Hinge| 0.5 * (hinge.max - hinge.min);
        Self {
            middle: numbers(hinges, middle),
            half: numbers(hinges, half),
            towards: [libm::cosf, libm::sinf].map(|of| numbers(hinges, |hinge| of(middle(hinge)))),
            clear: numbers(hinges, |hinge| libm::cosf(half(hinge)) + CLEAR),
            is_limit: hinges.iter().any(|hinge| half(hinge) > 0.0),
        }
    }

    /// Compares the cosine of the angle from the middle of the range. Where `a` or `c` is nearly in line with the edge the angle is round-off, and the lane is
    /// left to `evaluate`.
    #[inline(always)]
    fn is_kept<L: Lanes>(&self, points: &[Vector<L>; 4]) -> L {
        if !self.is_limit {
            return L::zero();
        }
        let [a, h0, h1, c] = *points;
        let (edge, to_a, to_c) = (h1 - h0, a - h0, c - h0);
        let (n, m) = (edge.cross(to_a), edge.cross(to_c));
        let square = edge.length_squared();
        let (n_square, m_square) = (n.length_squared(), m.length_squared());
        let least = L::splat(1e-4) * square;
        let apart = (least * to_a.length_squared())
            .lt(n_square)
            .and((least * to_c.length_squared()).lt(m_square));
        let [cosine, sine] = &self.towards;
        let along = edge.dot(n.cross(m)) / square.sqrt();
        let near = n.dot(m) * L::load(cosine) + along * L::load(sine);
        apart.and(is_below(near, n_square * m_square, L::load(&self.clear)))
    }

    /// See `dihedral`. The middle of the range is already in -π..π, so at most one full turn has to be subtracted or added.
    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 4]) -> (L, [Vector<L>; 4]) {
        let [a, h0, h1, c] = *points;
        let edge = h1 - h0;
        let length = edge.length();
        let inverse = L::splat(1.0) / length;
        let axis = edge * inverse;
        let (to_a, to_c) = (a - h0, c - h0);
        let (n, m) = (axis.cross(to_a), axis.cross(to_c));
        let (n_square, m_square) = (n.length_squared(), m.length_squared());
        let round_off = L::splat(1e-12);
        let has_angle = is_size(length)
            .and((round_off * to_a.length_squared()).lt(n_square))
            .and((round_off * to_c.length_squared()).lt(m_square));
        let angle = atan2(axis.dot(n.cross(m)), n.dot(m));
        let from_middle = angle - L::load(&self.middle);
        let (half_turn, turn) = (L::splat(0.5 * TAU), L::splat(TAU));
        let above = half_turn.le(from_middle).and(turn);
        let below = from_middle.le(-half_turn).and(turn);
        let half = L::load(&self.half);
        let value = has_angle.and(beyond(from_middle - above + below, -half, half));

        let by_a = n * (L::splat(-1.0) / n_square);
        let by_c = m * (L::splat(1.0) / m_square);
        let (s, t) = (to_a.dot(axis) * inverse, to_c.dot(axis) * inverse);
        let one = L::splat(1.0);
        let by_h0 = by_a * (s - one) + by_c * (t - one);
        (value, [by_a, by_h0, by_a * -s - by_c * t, by_c])
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::*;
    use crate::{Constraint, ConstraintKind, Distance, ParticleSeed, Simulation};
    use core::f32::consts::PI;

    /// Half-planes at `angle` about the z axis, with lever positions `s`, `t` other than 0 and 1.
    fn at(angle: f32) -> [Vec3; 4] {
        let c = Vec3::new(libm::cosf(angle), libm::sinf(angle), 0.0) * 0.8 + Vec3::Z * 1.3;
        [Vec3::new(1.0, 0.0, -0.2), Vec3::ZERO, Vec3::Z, c]
    }

    #[test]
    fn the_angle_turns_from_a_to_c_by_the_right_hand() {
        for angle in [-179.0, -90.0, -1.0, 0.0, 1.0, 45.0, 120.0, 179.0] {
            let found = Hinge::rest(at(f32::to_radians(angle))).min;
            assert!((found - f32::to_radians(angle)).abs() < 1e-6, "{angle}: {found}");
        }
    }

    #[test]
    fn a_range_is_left_by_the_shorter_way_round() {
        let value = |angle: f32, min: f32, max: f32| {
            let equation = Hinge::between(f32::to_radians(min), f32::to_radians(max));
            evaluate(&equation, &at(f32::to_radians(angle))).0 * (180.0 / PI)
        };
        for (angle, min, max, expected) in [
            (-179.0, 170.0, 180.0, 1.0),
            (169.0, 170.0, 180.0, -1.0),
            (-179.0, 170.0, 190.0, 0.0),
            (-165.0, 170.0, 190.0, 5.0),
            (-1.0, 0.0, 150.0, -1.0),
            (151.0, 0.0, 150.0, 1.0),
            (-179.0, 179.0, 179.0, 2.0),
            (3.0, -180.0, 180.0, 0.0),
            (179.0, -180.0, -170.0, -1.0),
            (-100.0, 180.0, 330.0, 0.0),
        ] {
            let found = value(angle, min, max);
            assert!((found - expected).abs() < 1e-3, "{angle} in {min}..{max}: {found}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_angle_the_flat_and_the_folded_included() {
        for angle in [-170.0, -60.0, 0.0, 20.0, 90.0, 180.0] {
            let rest = f32::to_radians(angle) + 0.5;
            assert_gradients(&Hinge::between(rest, rest), &at(f32::to_radians(angle)));
            assert_gradients(&Hinge::between(rest - 1.0, rest - 1.0), &at(f32::to_radians(angle)));
        }
    }

    #[test]
    fn it_keeps_momentum_and_its_limits_at_the_least_cost() {
        let mut random = Random::new(5);
        for _ in 0..30 {
            let (places, masses) = (random.positions(4), random.masses(4));
            let angle = Hinge::rest([places[0], places[1], places[2], places[3]]).min;
            let equation = Hinge::between(angle + 0.3, angle + 0.6);
            assert_momentum_kept(&equation, &places, &masses);
            assert_kept(&equation, &places, &masses, 1e-4);
        }
        assert_least(&Hinge::between(1.2, 2.0), &at(1.1), &[1.0, 2.0, 0.5, 1.0]);
        assert_least(&Hinge::between(0.1, 1.0), &at(1.1), &[1.0, 2.0, 0.5, 1.0]);
    }

    #[test]
    fn it_survives_every_degenerate_set() {
        for equation in
            [Hinge::between(0.2, 0.3), Hinge::between(PI, PI), Hinge::between(-3.0, -2.0)]
        {
            assert_survives(&equation, &at(1.0));
            assert_survives(&equation.with_softness(Softness::frequency(5.0, 1.0)), &at(1.0));
        }
    }

    /// An elbow: the upper arm and the pin of the hinge are pinned, the forearm is straight at first, and `gravity` pulls at the hand. Returns how far it has
    /// bent, radians: the least, the greatest and the final angle.
    fn bent(gravity: f32, equation: Option<Hinge>, start: f32) -> (f32, f32, f32) {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::new(0.0, gravity, 0.0);
        let hand = Vec3::new(libm::cosf(start), libm::sinf(start), 0.0);
        let places = [-Vec3::X, Vec3::Z * -0.1, Vec3::Z * 0.1, hand];
        for (i, place) in places.into_iter().enumerate() {
            let seed = ParticleSeed::at(place);
            world.particles.push(if i < 3 { seed.pinned() } else { seed }).unwrap();
        }
        for pin in [1, 2] {
            let length = places[pin].distance(hand);
            world.distances_mut().push(Distance::new(pin as u32, 3, length));
        }
        world.constraints_mut().extend(
            equation.map(|equation| Constraint::new(0..4, ConstraintKind::Hinge(equation))),
        );
        let (mut least, mut most, mut last) = (0.0_f32, 0.0_f32, 0.0);
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
            let hand = world.particles.position(3);
            assert!((hand.length() - 1.0).abs() < 5e-3, "the forearm is {} long", hand.length());
            last = libm::atan2f(hand.y, hand.x);
            (least, most) = (least.min(last), most.max(last));
        }
        (least, most, last)
    }

    #[test]
    fn an_elbow_bends_forward_by_150_degrees_and_not_backward() {
        // Straight is 180°; the angle from the upper arm to the forearm increases as the hand rises.
        let elbow = || Some(Hinge::between(f32::to_radians(180.0), f32::to_radians(330.0)));
        let (least, ..) = bent(-9.81, None, 0.0);
        assert!(least < f32::to_radians(-90.0), "a free arm falls: {least}");
        let (least, most, last) = bent(-9.81, elbow(), 0.0);
        println!("pulled backward: {least} to {most}, at last {last} rad");
        assert!(least > f32::to_radians(-0.5) && most < f32::to_radians(0.5), "{least} {most}");
        let (least, most, last) = bent(9.81, elbow(), 0.01);
        println!("pulled forward: {least} to {most}, at last {last} rad");
        assert!(
            least > f32::to_radians(-0.5)
                && (most - f32::to_radians(150.0)).abs() < f32::to_radians(1.0),
            "{most}"
        );
        // With a fast swing, the limit still stops it.
        let (_, most, _) =
            bent(9.81, Some(Hinge::between(f32::to_radians(180.0), f32::to_radians(240.0))), 0.01);
        assert!((most - f32::to_radians(60.0)).abs() < f32::to_radians(1.0), "{most}");
    }

    #[test]
    fn faults_are_told_apart() {
        assert_eq!(Hinge::between(-PI, PI).fault(4), None);
        assert_eq!(Hinge::between(f32::to_radians(170.0), f32::to_radians(190.0)).fault(4), None);
        assert_eq!(Hinge::between(0.0, 1.0).fault(3), Some(ConstraintFault::Count));
        assert_eq!(Hinge::between(1.0, 0.5).fault(4), Some(ConstraintFault::Limits));
        assert_eq!(Hinge::between(-7.0, 0.5).fault(4), Some(ConstraintFault::Number));
        assert_eq!(Hinge::between(-5.0, 5.0).fault(4), Some(ConstraintFault::Number));
        assert_eq!(Hinge::between(0.0, f32::NAN).fault(4), Some(ConstraintFault::Number));
    }
}
