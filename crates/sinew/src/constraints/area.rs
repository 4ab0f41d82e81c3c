//! The area of a triangle (physics.md C8).

use glam::Vec3;

use super::angle::{any_normal, any_normal_wide};
use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::wide::{Wide, numbers};
use crate::lanes::{LANES, Lanes, Vector};

/// Keeps the area of the triangle `[a, b, c]`.
///
/// A triangle that has collapsed to a line opens again, in a plane chosen for it. Three particles in one place have no direction in which to move, and stay.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Area to keep, m², 0 or more.
    pub rest: f32,
    /// How stiff the constraint is. A compliance is in m⁴/J.
    pub softness: Softness,
}

impl Area {
    /// A hard constraint that keeps the area of the triangle at these positions.
    pub fn of(positions: [Vec3; 3]) -> Self {
        Self { rest: area(positions).0, softness: Softness::Hard }
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if particles != 3 {
            Some(ConstraintFault::Count)
        } else if !(self.rest.is_finite() && self.rest >= 0.0) {
            Some(ConstraintFault::Number)
        } else {
            None
        }
    }
}

/// `C = A - A₀`, m². `keep_within_reach` bounds the length of a step.
impl Equation for Area {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let (now, by) = area([points.at(0), points.at(1), points.at(2)]);
        gradients.copy_from_slice(&by);
        let value = now - self.rest;
        keep_within_reach(value, now.max(self.rest).sqrt(), gradients);
        value
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }
}

/// The area of a triangle, m², and its gradient by each corner, m.
///
/// With `u = b - a`, `v = c - a` and the unit normal `n = u×v/‖u×v‖`, `A = ½‖u×v‖` changes by `½ n·(du×v + u×dv)`: to first order, turning the normal itself
/// changes nothing. Hence
///
/// ```text
/// ∂A/∂b = ½ v×n        ∂A/∂c = ½ n×u        ∂A/∂a = -∂A/∂b - ∂A/∂c
/// ```
///
/// each half as long as the opposite side, and perpendicular to it. A degenerate (collinear) triangle has no normal, and its area grows whichever way it opens;
/// it gets a normal perpendicular to its longer side. The cross product is normalised by its largest component first, because its square would underflow for a
/// triangle of a micrometre.
#[inline]
pub(super) fn area([a, b, c]: [Vec3; 3]) -> (f32, [Vec3; 3]) {
    let (u, v) = (b - a, c - a);
    let cross = u.cross(v);
    let size = cross.abs().max_element();
    let (twice, normal) = if size > 0.0 {
        let cross = cross / size;
        let length = cross.length();
        (size * length, cross / length)
    } else {
        (0.0, any_normal(if u.length_squared() > v.length_squared() { u } else { v }))
    };
    let (by_b, by_c) = (v.cross(normal) * 0.5, normal.cross(u) * 0.5);
    (0.5 * twice, [-(by_b + by_c), by_b, by_c])
}

/// Scales the gradients of an area or a volume up, if necessary, so that one step moves the particles by no more than `reach` metres (root mean square).
///
/// With equal masses a step is `‖d‖ = |C|/‖∇C‖`. When a shape has collapsed to a point its gradient is almost zero, and the step would throw the particles
/// thousands of shape sizes away. Such a gradient keeps its direction and is scaled so that the step equals `reach`. That is about the gradient of the intact
/// shape, so the multipliers of a soft constraint keep their size too. `reach` is the larger of the current and the rest size; a shape that has not collapsed
/// never reaches this bound.
pub(super) fn keep_within_reach(value: f32, reach: f32, gradients: &mut [Vec3]) {
    let square: f32 = gradients.iter().map(|g| g.length_squared()).sum();
    let most = (square * gradients.len() as f32).sqrt() * reach;
    let factor = value.abs() / most;
    // Infinite or NaN if the gradient has vanished or the input is not finite; the solver handles those.
    if factor > 1.0 && factor.is_finite() {
        for gradient in gradients {
            *gradient *= factor;
        }
    }
}

/// The parameters of eight [`Area`]s.
#[derive(Clone, Debug)]
pub(crate) struct Areas {
    rest: [f32; LANES],
}

impl Wide<3> for Areas {
    type Kind = Area;

    fn of(areas: [&Area; LANES], _: [usize; LANES]) -> Self {
        Self { rest: numbers(areas, |area| area.rest) }
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 3]) -> (L, [Vector<L>; 3]) {
        let (now, mut gradients) = area_wide(points);
        let rest = L::load(&self.rest);
        let value = now - rest;
        let mut square = L::zero();
        for gradient in &gradients {
            square = square + gradient.length_squared();
        }
        let (one, reach) = (L::splat(1.0), now.max(rest).sqrt());
        let factor = value.abs() / ((square * L::splat(3.0)).sqrt() * reach);
        let far = one.lt(factor).and(factor.le(L::splat(f32::MAX)));
        if far.any() {
            scale_gradients(far.select(factor, one), &mut gradients);
        }
        (value, gradients)
    }
}

/// Eight lanes of the scalar `area`.
#[inline(always)]
pub(super) fn area_wide<L: Lanes>(points: &[Vector<L>; 3]) -> (L, [Vector<L>; 3]) {
    let [a, b, c] = *points;
    let (u, v) = (b - a, c - a);
    let cross = u.cross(v);
    let size = cross.x.abs().max(cross.y.abs()).max(cross.z.abs());
    let cross = Vector::new(cross.x / size, cross.y / size, cross.z / size);
    let length = cross.length();
    let mut normal = cross * (L::splat(1.0) / length);
    let mut twice = size * length;
    let flat = size.same(L::zero());
    if flat.any() {
        let longer = u.or_else(v.length_squared().lt(u.length_squared()), v);
        normal = any_normal_wide(longer).or_else(flat, normal);
        twice = flat.select(L::zero(), twice);
    }
    let half = L::splat(0.5);
    let (by_b, by_c) = (v.cross(normal) * half, normal.cross(u) * half);
    (half * twice, [-(by_b + by_c), by_b, by_c])
}

/// Multiplies the gradients by `factor`.
#[inline(always)]
pub(super) fn scale_gradients<L: Lanes, const N: usize>(factor: L, gradients: &mut [Vector<L>; N]) {
    for gradient in gradients {
        *gradient = *gradient * factor;
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::*;
    use crate::{Constraint, ConstraintKind, ParticleSeed, Simulation};

    #[test]
    fn the_gradient_is_that_of_the_area() {
        let mut random = Random::new(11);
        for _ in 0..20 {
            let places = random.positions(3);
            let equation = Area::of([places[0], places[1], places[2]]);
            if equation.rest < 0.2 {
                continue; // The gradient of a thin triangle varies too fast for finite differences.
            }
            assert_gradients(&Area { rest: equation.rest * 0.7, ..equation.clone() }, &places);
            assert_gradients(&Area { rest: equation.rest * 1.5, ..equation }, &places);
        }
        let right = [Vec3::ZERO, Vec3::X * 3.0, Vec3::Y * 4.0];
        assert_eq!(Area::of(right).rest, 6.0);
    }

    #[test]
    fn it_keeps_momentum_and_the_area_at_the_least_cost() {
        let mut random = Random::new(12);
        for _ in 0..20 {
            let (places, masses) = (random.positions(3), random.masses(3));
            for rest in [0.1, 0.5, 2.0] {
                let equation = Area { rest, softness: Softness::Hard };
                assert_momentum_kept(&equation, &places, &masses);
                assert_kept(&equation, &places, &masses, 1e-5);
            }
        }
        let places = [Vec3::ZERO, Vec3::new(1.0, 0.2, 0.0), Vec3::new(0.3, 1.0, 0.4)];
        let equation = Area::of(places);
        for factor in [0.93, 1.07] {
            let equation = Area { rest: equation.rest * factor, ..equation.clone() };
            assert_least(&equation, &places, &[1.0, 3.0, 0.5]);
        }
    }

    #[test]
    fn a_triangle_fallen_to_a_line_opens_again_and_one_of_a_micrometre_grows() {
        let equation = Area { rest: 0.5, softness: Softness::Hard };
        assert_kept(&equation, &[Vec3::ZERO, Vec3::X, Vec3::X * 2.0], &[], 1e-5);
        assert_kept(&equation, &[Vec3::ZERO, Vec3::X, Vec3::X], &[], 1e-5);
        let tiny = [Vec3::ZERO, Vec3::X * 1e-6, Vec3::Y * 1e-6];
        assert_kept(&equation, &tiny, &[], 1e-5);
        let mut particles = points_of(&tiny, &[]);
        particles.project(&equation);
        assert!(extent(&particles.positions()) < 2.0, "not thrown away: {particles:?}");
    }

    #[test]
    fn it_survives_every_degenerate_set() {
        let places = Random::new(13).positions(3);
        for rest in [0.0, 1e-12, 1.0, 1e12] {
            let equation = Area { rest, softness: Softness::Hard };
            assert_survives(&equation, &places);
            assert_survives(&equation.with_softness(Softness::frequency(5.0, 0.5)), &places);
        }
    }

    /// The area over 2 s of a soft triangle that starts 10 % too large, without gravity.
    fn breathing(sweeps: u32, softness: Softness) -> Vec<f32> {
        let mut world = Simulation::default();
        world.settings.max_sweeps = sweeps;
        world.forces.gravity = Vec3::ZERO;
        let places = [Vec3::ZERO, Vec3::X, Vec3::new(0.5, 0.75_f32.sqrt(), 0.0)];
        for place in places {
            world.particles.push(ParticleSeed::at(place * 1.05)).unwrap();
        }
        let equation = Area::of(places).with_softness(softness);
        world.constraints_mut().push(Constraint::new(0..3, ConstraintKind::Area(equation)));
        world.constraints_mut().push(Constraint::new([0], ConstraintKind::custom(Restless)));
        world.settings.tolerance = 0.0;
        let rows = [0, 1, 2];
        (0..120)
            .map(|_| {
                assert_eq!(world.step(1.0 / 60.0).unwrap().most_sweeps, sweeps);
                area(rows.map(|i| world.particles.position(i))).0 / Area::of(places).rest
            })
            .collect()
    }

    #[test]
    fn a_soft_one_swings_at_its_frequency_however_often_it_is_swept() {
        let (once, often) = (1, 8);
        let soft = Softness::frequency(2.0, 0.0);
        let (one, eight) = (breathing(once, soft), breathing(often, soft));
        let apart = one.iter().zip(&eight).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let turns = (1..one.len()).filter(|&i| (one[i] > 1.0) != (one[i - 1] > 1.0)).count();
        let (last, first) = (one[90..].iter().copied(), one[..30].iter().copied());
        println!("1 and 8 sweeps are {apart} apart; {turns} crossings in 2 s");
        assert!(apart < 2e-4, "{apart}");
        // Two crossings in each of the four periods of 2 s at 2 Hz.
        assert!((7..=9).contains(&turns), "{turns}");
        assert!(last.fold(0.0, f32::max) > 1.03 && first.fold(2.0, f32::min) < 0.95);
        let damped = breathing(often, Softness::frequency(2.0, 1.0));
        assert!((damped[119] - 1.0).abs() < 1e-3 && damped.iter().all(|a| *a > 0.999));
    }

    #[test]
    fn faults_are_told_apart() {
        let equation = Area { rest: 1.0, softness: Softness::Hard };
        assert_eq!(equation.fault(3), None);
        assert_eq!(equation.fault(2), Some(ConstraintFault::Count));
        assert_eq!(Area { rest: -1.0, ..equation.clone() }.fault(3), Some(ConstraintFault::Number));
        assert_eq!(Area { rest: f32::NAN, ..equation }.fault(3), Some(ConstraintFault::Number));
    }
}
