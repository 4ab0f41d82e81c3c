//! A cone that limits the direction of a bone, about an axis fixed in its parent (physics.md C5).

use core::f32::consts::PI;

use glam::Vec3;

use super::angle::{Turns, between, between_wide};
use super::equation::{Bound, Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::wide::{CLEAR, Wide, is_below, numbers};
use crate::lanes::{LANES, Lanes, Vector};

/// Keeps the segment `c → d` within the angle `max` of an axis that is fixed in the frame of three particles, as in the shoulder or the hip of a ragdoll.
///
/// The particles are `[o, x, y, c, d]`, or `[o, x, y, d]` for a segment that starts at `o`. The axis is computed from the positions of `o`, `x` and `y`, so it
/// turns with them. A cone does not limit twist; a [`Hinge`](super::Hinge) does.
#[derive(Clone, Debug, PartialEq)]
pub struct Cone {
    /// Coefficients of the axis: it is `axis.x (x - o) + axis.y (y - o) + axis.z (x - o)×(y - o)`. The length is irrelevant but must not be zero.
    /// [`about`](Self::about) computes the coefficients.
    pub axis: Vec3,
    /// Largest angle between the axis and the segment, radians, 0 to π (no limit).
    pub max: f32,
    /// How stiff the constraint is. A compliance is in rad²/J.
    pub softness: Softness,
}

impl Cone {
    /// A hard cone of `max` radians about `direction`, a vector in world space, for the given positions of the three particles of the frame.
    ///
    /// `None` if the direction is zero, or if the three particles are collinear.
    pub fn about(o: Vec3, x: Vec3, y: Vec3, direction: Vec3, max: f32) -> Option<Self> {
        // Solves direction = αu + βv + γw with w = u×v perpendicular to both: γ is a projection, and by Cramer's rule α and β are (direction×v)·w/w·w and
        // (u×direction)·w/w·w. In f64, so that a thin triangle is a valid frame too.
        let (u, v) = ((x - o).as_dvec3(), (y - o).as_dvec3());
        let direction = direction.as_dvec3();
        let w = u.cross(v);
        let square = w.length_squared();
        // The sine of the angle at `o` must exceed 1e-6: below that, f32 positions do not define a plane.
        if square <= 1e-12 * u.length_squared() * v.length_squared() {
            return None;
        }
        let axis = glam::DVec3::new(
            direction.cross(v).dot(w) / square,
            u.cross(direction).dot(w) / square,
            direction.dot(w) / square,
        );
        // Scaled so that the largest coefficient is 1; the length is irrelevant.
        let axis = (axis / axis.abs().max_element()).as_vec3();
        axis.is_finite().then_some(Self { axis, max, softness: Softness::Hard })
    }

    /// The axis for a frame at these positions, metres; not of unit length.
    pub fn axis_in(&self, o: Vec3, x: Vec3, y: Vec3) -> Vec3 {
        let (u, v) = (x - o, y - o);
        u * self.axis.x + v * self.axis.y + u.cross(v) * self.axis.z
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if !(particles == 4 || particles == 5) {
            Some(ConstraintFault::Count)
        } else if !self.axis.is_finite()
            || self.axis == Vec3::ZERO
            || !(0.0..=PI).contains(&self.max)
        {
            Some(ConstraintFault::Number)
        } else {
            None
        }
    }
}

/// `C = θ - max` outside the cone, radians, and zero inside.
///
/// `between` gives the derivatives of the angle θ between the axis `A` and `s = d - c`: `g = ∂θ/∂A` and `∂θ/∂s`. The axis is
/// `A = αu + βv + γ u×v` with `u = x - o`, `v = y - o`, so by the product rule `g·dA = αg·du + βg·dv + γ(g·(du×v) + g·(u×dv))`, and with the triple products permuted cyclically
///
/// ```text
/// ∂θ/∂x = αg + γ v×g        ∂θ/∂y = βg + γ g×u        ∂θ/∂o = -∂θ/∂x - ∂θ/∂y
/// ∂θ/∂d = ∂θ/∂s             ∂θ/∂c = -∂θ/∂s
/// ```
///
/// They sum to zero, and rotating all particles together does not change θ: the parent receives the reaction of what the bone receives.
impl Equation for Cone {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let (o, x, y) = (points.at(0), points.at(1), points.at(2));
        let (start, end) = if points.len() == 4 { (0, 3) } else { (3, 4) };
        let segment = points.at(end) - points.at(start);
        let Some(turn) = between(self.axis_in(o, x, y), segment) else { return 0.0 };
        if turn.angle <= self.max {
            return 0.0;
        }
        let (u, v) = (x - o, y - o);
        gradients[1] = turn.by_u * self.axis.x + v.cross(turn.by_u) * self.axis.z;
        gradients[2] = turn.by_u * self.axis.y + turn.by_u.cross(u) * self.axis.z;
        gradients[0] = -(gradients[1] + gradients[2]);
        gradients[end] += turn.by_v;
        gradients[start] -= turn.by_v;
        turn.angle - self.max
    }

    fn bound(&self) -> Bound {
        Bound::AtMost
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }
}

/// The parameters of eight [`Cone`]s of four or five particles.
#[derive(Clone, Debug)]
pub(crate) struct Cones {
    axis: [[f32; LANES]; 3],
    max: [f32; LANES],
    /// A cosine that is above that of `max` by a safe margin.
    clear: [f32; LANES],
    /// 1 where the segment starts at the frame's own `o`. Such a cone of four particles is stored in the form of five, with `o` twice.
    starts_at_frame: [f32; LANES],
}

impl Wide<5> for Cones {
    const IS_LIMIT: bool = true;

    type Kind = Cone;

    fn of(cones: [&Cone; LANES], particles: [usize; LANES]) -> Self {
        Self {
            axis: [0, 1, 2].map(|i| numbers(cones, |cone| cone.axis[i])),
            max: numbers(cones, |cone| cone.max),
            clear: numbers(cones, |cone| libm::cosf(cone.max) + CLEAR),
            starts_at_frame: numbers(particles, |count| f32::from(u8::from(count == 4))),
        }
    }

    fn rows(rows: &[u32]) -> [u32; 5] {
        match *rows {
            [o, x, y, d] => [o, x, y, o, d],
            _ => core::array::from_fn(|i| rows[i]),
        }
    }

    #[inline(always)]
    fn is_kept<L: Lanes>(&self, points: &[Vector<L>; 5]) -> L {
        let [o, x, y, c, d] = *points;
        let (axis, out) = (self.axis(x - o, y - o), d - c);
        let square = axis.length_squared() * out.length_squared();
        is_below(axis.dot(out), square, L::load(&self.clear))
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 5]) -> (L, [Vector<L>; 5]) {
        let [o, x, y, c, d] = *points;
        let (u, v) = (x - o, y - o);
        let [along_u, along_v, up] = &self.axis;
        let (along_u, along_v, up) = (L::load(along_u), L::load(along_v), L::load(up));
        let axis = self.axis(u, v);
        let Turns { angle, by_u: turn, by_v: by_d } = between_wide(axis, d - c);
        let max = L::load(&self.max);
        let value = max.lt(angle).and(angle - max);

        let by_x = turn * along_u + v.cross(turn) * up;
        let by_y = turn * along_v + turn.cross(u) * up;
        let by_o = -(by_x + by_y);
        let starts_at_frame = L::zero().lt(L::load(&self.starts_at_frame));
        let nothing = Vector::new(L::zero(), L::zero(), L::zero());
        let by_o = (by_o - by_d).or_else(starts_at_frame, by_o);
        (value, [by_o, by_x, by_y, nothing.or_else(starts_at_frame, -by_d), by_d])
    }
}

impl Cones {
    #[inline(always)]
    fn axis<L: Lanes>(&self, u: Vector<L>, v: Vector<L>) -> Vector<L> {
        let [along_u, along_v, up] = &self.axis;
        u * L::load(along_u) + v * L::load(along_v) + u.cross(v) * L::load(up)
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::*;
    use crate::{Constraint, ConstraintKind, Distance, ParticleSeed, Simulation};

    const FRAME: [Vec3; 3] = [Vec3::ZERO, Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.2, 0.9, -0.1)];

    fn cone(direction: Vec3, max: f32) -> Cone {
        Cone::about(FRAME[0], FRAME[1], FRAME[2], direction, max).unwrap()
    }

    fn angle(a: Vec3, b: Vec3) -> f32 {
        between(a, b).map_or(0.0, |turn| turn.angle)
    }

    /// The frame with a segment along `direction`, of four particles or of five.
    fn with(direction: Vec3, count: usize) -> Vec<Vec3> {
        let mut places = FRAME.to_vec();
        let start = if count == 5 { Vec3::new(0.3, 0.2, 0.5) } else { Vec3::ZERO };
        places.extend((count == 5).then_some(start));
        places.push(start + direction);
        places
    }

    #[test]
    fn the_axis_is_the_direction_asked_for_and_turns_with_its_frame() {
        let mut random = Random::new(4);
        for _ in 0..20 {
            let direction = random.vector().normalize();
            let found = cone(direction, 1.0).axis_in(FRAME[0], FRAME[1], FRAME[2]).normalize();
            assert!(found.abs_diff_eq(direction, 1e-5), "{direction} {found}");
        }
        // A quarter turn of the frame about z, and a shift.
        let turned = FRAME.map(|p| Vec3::new(-p.y, p.x, p.z) + Vec3::splat(3.0));
        let found = cone(Vec3::X, 1.0).axis_in(turned[0], turned[1], turned[2]).normalize();
        assert!(found.abs_diff_eq(Vec3::Y, 1e-5), "{found}");
    }

    #[test]
    fn what_has_no_frame_or_no_direction_has_no_cone() {
        assert_eq!(Cone::about(Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::Y, 1.0), None);
        assert_eq!(Cone::about(Vec3::ZERO, Vec3::ZERO, Vec3::X, Vec3::Y, 1.0), None);
        assert_eq!(Cone::about(Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO, 1.0), None);
        assert_eq!(Cone::about(Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN, 1.0), None);
    }

    #[test]
    fn the_gradient_is_that_of_the_angle_for_all_five_particles() {
        let mut random = Random::new(5);
        let mut checked = 0;
        for attempt in 0..60 {
            let (axis, direction) = (random.vector().normalize(), random.vector());
            let present = angle(axis, direction);
            if direction.length() < 0.5 || !(0.6..2.5).contains(&present) {
                continue;
            }
            checked += 1;
            assert_gradients(&cone(axis, present - 0.3), &with(direction, 4 + attempt % 2));
        }
        assert!(checked >= 20, "{checked}");
    }

    #[test]
    fn it_keeps_momentum_and_the_bone_in_the_cone_at_the_least_cost() {
        let mut random = Random::new(6);
        for count in [4, 5] {
            for _ in 0..10 {
                let masses = random.masses(count);
                let direction = random.vector() - Vec3::Z;
                assert_momentum_kept(&cone(Vec3::Z, 0.8), &with(direction, count), &masses);
                assert_kept(&cone(Vec3::Z, 0.8), &with(direction, count), &masses, 1e-4);
            }
            let near = with(Vec3::new(0.6, 0.3, 0.8), count);
            assert_least(&cone(Vec3::Z, 0.6), &near, &[1.0, 2.0, 0.5, 1.5, 1.0]);
        }
    }

    #[test]
    fn inside_the_cone_nothing_happens_and_against_the_axis_it_turns_back() {
        let equation = cone(Vec3::Z, 0.8);
        assert_eq!(
            evaluate(&equation, &with(Vec3::new(0.5, 0.0, 1.0), 5)),
            (0.0, vec![Vec3::ZERO; 5])
        );
        assert_kept(&equation, &with(-Vec3::Z, 5), &[], 1e-4);
    }

    #[test]
    fn it_survives_every_degenerate_set() {
        for equation in [cone(Vec3::Z, 0.1), cone(Vec3::X, 0.0), cone(-Vec3::Y, 1.0)] {
            for count in [4, 5] {
                let places = with(Vec3::new(0.6, 0.3, -0.8), count);
                assert_survives(&equation, &places);
                let soft = equation.clone().with_softness(Softness::frequency(5.0, 1.0));
                assert_survives(&soft, &places);
            }
        }
    }

    #[test]
    fn a_bone_held_out_by_a_cone_falls_to_its_rim_and_no_farther() {
        let mut world = Simulation::default();
        for place in FRAME {
            world.particles.push(ParticleSeed::at(place).pinned()).unwrap();
        }
        world.particles.push(ParticleSeed::at(Vec3::X)).unwrap();
        world.distances_mut().push(Distance::new(0, 3, 1.0));
        world
            .constraints_mut()
            .push(Constraint::new([0, 1, 2, 3], ConstraintKind::Cone(cone(Vec3::X, 0.5))));
        let mut most = 0.0_f32;
        for _ in 0..180 {
            world.step(1.0 / 60.0).unwrap();
            let bone = world.particles.position(3);
            most = most.max(angle(Vec3::X, bone));
        }
        println!("the bone fell by {most} rad of 0.5");
        assert!((most - 0.5).abs() < 5e-3, "{most}");
    }

    #[test]
    fn faults_are_told_apart() {
        let good = cone(Vec3::Z, 1.0);
        assert_eq!((good.fault(4), good.fault(5)), (None, None));
        assert_eq!(good.fault(3), Some(ConstraintFault::Count));
        assert_eq!(good.fault(6), Some(ConstraintFault::Count));
        assert_eq!(cone(Vec3::Z, 4.0).fault(5), Some(ConstraintFault::Number));
        assert_eq!(cone(Vec3::Z, f32::NAN).fault(5), Some(ConstraintFault::Number));
        assert_eq!(
            Cone { axis: Vec3::ZERO, ..good.clone() }.fault(5),
            Some(ConstraintFault::Number)
        );
        assert_eq!(Cone { axis: Vec3::NAN, ..good }.fault(5), Some(ConstraintFault::Number));
    }
}
