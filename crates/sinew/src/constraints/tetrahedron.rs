//! The volume of a tetrahedron (physics.md C7).

use glam::Vec3;

use super::area::{keep_within_reach, scale_gradients};
use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::wide::{Wide, is_size, numbers};
use crate::lanes::{LANES, Lanes, Vector};

/// Keeps the signed volume of the tetrahedron `[a, b, c, d]`: `⅙ (b - a)×(c - a)·(d - a)`.
///
/// It is positive where `a`, `b`, `c` are counter-clockwise as seen from `d`. That agrees with a [`Volume`](super::Volume) of its outward triangles, which are
/// `[a, c, b]`, `[a, b, d]`, `[a, d, c]` and `[b, c, d]`. Because the volume has a sign, an inverted tetrahedron recovers.
#[derive(Clone, Debug, PartialEq)]
pub struct Tetrahedron {
    /// Volume to keep, m³; negative for the opposite order of the particles.
    pub rest: f32,
    /// How stiff the constraint is. A compliance is in m⁶/J.
    pub softness: Softness,
}

impl Tetrahedron {
    /// A hard constraint that keeps the signed volume of the tetrahedron at these positions.
    pub fn of(positions: [Vec3; 4]) -> Self {
        Self { rest: volume(positions).0, softness: Softness::Hard }
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if particles != 4 {
            Some(ConstraintFault::Count)
        } else if !self.rest.is_finite() {
            Some(ConstraintFault::Number)
        } else {
            None
        }
    }
}

/// `C = V - V₀`, m³; `keep_within_reach` bounds the length of a step. Where all four particles are collinear there is no gradient, and nothing is done.
impl Equation for Tetrahedron {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let (now, by) = volume([points.at(0), points.at(1), points.at(2), points.at(3)]);
        gradients.copy_from_slice(&by);
        let value = now - self.rest;
        keep_within_reach(value, libm::cbrtf(now.abs().max(self.rest.abs())), gradients);
        value
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }
}

/// The signed volume, m³, and its gradient by each corner, m².
///
/// `V = ⅙ (u×v)·w` with `u = b - a`, `v = c - a`, `w = d - a` is linear in each of the three and invariant under their cyclic permutation; so
///
/// ```text
/// ∂V/∂b = ⅙ v×w        ∂V/∂c = ⅙ w×u        ∂V/∂d = ⅙ u×v        ∂V/∂a = -∂V/∂b - ∂V/∂c - ∂V/∂d
/// ```
///
/// Each has a third of the area of the opposite face as its length, and points away from that face.
#[inline]
fn volume([a, b, c, d]: [Vec3; 4]) -> (f32, [Vec3; 4]) {
    let (u, v, w) = (b - a, c - a, d - a);
    let (by_b, by_c, by_d) = (v.cross(w) / 6.0, w.cross(u) / 6.0, u.cross(v) / 6.0);
    (by_d.dot(w), [-(by_b + by_c + by_d), by_b, by_c, by_d])
}

/// The parameters of eight [`Tetrahedron`]s.
#[derive(Clone, Debug)]
pub(crate) struct Tetrahedra {
    rest: [f32; LANES],
    /// Lower bound of `C²/Σ‖∇C‖²`, m², above which a step may be longer than the edge of a cube with the rest volume; reduced slightly for rounding.
    reach: [f32; LANES],
}

/// Squares of values below this may have lost precision, m⁶.
const SMALLEST: f32 = 1e-30;

impl Wide<4> for Tetrahedra {
    type Kind = Tetrahedron;

    fn of(all: [&Tetrahedron; LANES], _: [usize; LANES]) -> Self {
        let reach = |tetrahedron: &Tetrahedron| {
            let length = libm::cbrtf(tetrahedron.rest);
            4.0 * (1.0 - 1e-5) * length * length
        };
        Self { rest: numbers(all, |tetrahedron| tetrahedron.rest), reach: numbers(all, reach) }
    }

    /// See `volume`. The reach of a step is a cube root. Whether a gradient has to be scaled up is first decided without it, by squares, then by the third
    /// power of the step where that is not certain. Lanes that have collapsed go through the scalar formula.
    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 4]) -> (L, [Vector<L>; 4]) {
        let [a, b, c, d] = *points;
        let (u, v, w) = (b - a, c - a, d - a);
        let sixth = L::splat(1.0 / 6.0);
        let (by_b, by_c, by_d) = (v.cross(w) * sixth, w.cross(u) * sixth, u.cross(v) * sixth);
        let mut gradients = [-(by_b + by_c + by_d), by_b, by_c, by_d];
        let (now, rest) = (by_d.dot(w), L::load(&self.rest));
        let value = now - rest;
        let mut square = L::zero();
        for gradient in &gradients {
            square = square + gradient.length_squared();
        }
        let (squared, zero) = (value * value, L::zero());
        let within = L::splat(SMALLEST).lt(squared).and(squared.le(L::load(&self.reach) * square));
        if within.or(value.same(zero)).all() {
            return (value, gradients);
        }
        let size = now.abs().max(rest.abs());
        // Root mean square step: half the norm, for four particles.
        let step = value.abs() / (square * L::splat(4.0)).sqrt();
        let far = is_size(step).and(size.lt(step * step * step));
        if far.any() {
            let factor = L::load(&scale_factors(step.array(), size.array()));
            scale_gradients(far.select(factor, L::splat(1.0)), &mut gradients);
        }
        (value, gradients)
    }
}

/// The factors, at least 1, by which gradients have to be scaled up so that steps of `step` metres become as long as the edge of a cube of volume `size`, m³.
#[cold]
fn scale_factors(step: [f32; LANES], size: [f32; LANES]) -> [f32; LANES] {
    core::array::from_fn(|lane| {
        let factor = step[lane] / libm::cbrtf(size[lane]);
        if factor > 1.0 && factor.is_finite() { factor } else { 1.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::super::{SizeCorrection, Volume};
    use super::*;
    use crate::{Constraint, ConstraintKind, ParticleSeed, Simulation};

    const CORNER: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];

    #[test]
    fn its_volume_is_that_of_its_outward_triangles() {
        assert!((Tetrahedron::of(CORNER).rest - 1.0 / 6.0).abs() < 1e-7);
        let mut random = Random::new(21);
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        for _ in 0..10 {
            let p = random.positions(4);
            let (one, gradients) =
                evaluate(&Tetrahedron { rest: 0.0, softness: Softness::Hard }, &p);
            let mesh = Volume { rest: 0.0, ..Volume::of(faces, &p) };
            assert_eq!(mesh.correction, SizeCorrection::Gradient);
            let (other, others) = evaluate(&mesh, &p);
            assert!((one - other).abs() < 1e-6);
            assert!(gradients.iter().zip(&others).all(|(a, b)| a.abs_diff_eq(*b, 1e-6)));
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_volume() {
        let mut random = Random::new(22);
        for _ in 0..20 {
            let places = random.positions(4);
            let now = Tetrahedron::of([places[0], places[1], places[2], places[3]]).rest;
            for rest in [now - 0.1, now + 0.1] {
                assert_gradients(&Tetrahedron { rest, softness: Softness::Hard }, &places);
            }
        }
    }

    #[test]
    fn it_keeps_momentum_and_the_volume_at_the_least_cost() {
        let mut random = Random::new(23);
        for _ in 0..20 {
            let (places, masses) = (random.positions(4), random.masses(4));
            for rest in [-0.4, 0.01, 1.0] {
                let equation = Tetrahedron { rest, softness: Softness::Hard };
                assert_momentum_kept(&equation, &places, &masses);
                assert_kept(&equation, &places, &masses, 1e-5);
            }
        }
        for factor in [0.93, 1.07] {
            let equation = Tetrahedron { rest: factor / 6.0, softness: Softness::Hard };
            assert_least(&equation, &CORNER, &[1.0, 3.0, 0.5, 1.0]);
        }
    }

    #[test]
    fn one_turned_inside_out_comes_back_and_a_flat_one_fills() {
        let equation = Tetrahedron::of(CORNER);
        assert_kept(&equation, &CORNER.map(|p| p * Vec3::new(1.0, 1.0, -1.0)), &[], 1e-5);
        assert_kept(&equation, &CORNER.map(|p| p * Vec3::new(1.0, 1.0, 0.0)), &[], 1e-5);
        let tiny = CORNER.map(|p| p * 1e-5);
        assert_kept(&equation, &tiny, &[], 1e-5);
        let mut particles = points_of(&tiny, &[]);
        particles.project(&equation);
        assert!(extent(&particles.positions()) < 2.0, "not thrown away: {particles:?}");
    }

    #[test]
    fn it_survives_every_degenerate_set() {
        let places = Random::new(24).positions(4);
        for rest in [-1.0, 0.0, 1e-12, 1.0, 1e12] {
            let equation = Tetrahedron { rest, softness: Softness::Hard };
            assert_survives(&equation, &places);
            assert_survives(&equation.with_softness(Softness::frequency(5.0, 0.5)), &places);
        }
    }

    #[test]
    fn a_soft_one_breathes_alike_however_often_it_is_swept() {
        let breathing = |sweeps: u32, softness: Softness| -> Vec<f32> {
            let mut world = Simulation::default();
            world.settings.max_sweeps = sweeps;
            world.forces.gravity = Vec3::ZERO;
            for place in CORNER {
                world.particles.push(ParticleSeed::at(place)).unwrap();
            }
            let equation = Tetrahedron { rest: 1.1 / 6.0, softness };
            world
                .constraints_mut()
                .push(Constraint::new(0..4, ConstraintKind::Tetrahedron(equation)));
            world.constraints_mut().push(Constraint::new([0], ConstraintKind::custom(Restless)));
            world.settings.tolerance = 0.0;
            let now = |world: &Simulation| {
                Tetrahedron::of([0, 1, 2, 3].map(|i| world.particles.position(i))).rest * 6.0
            };
            (0..120)
                .map(|_| {
                    assert_eq!(world.step(1.0 / 60.0).unwrap().most_sweeps, sweeps);
                    now(&world)
                })
                .collect()
        };
        for softness in [Softness::frequency(2.0, 0.1), Softness::spring(500.0, 0.0)] {
            let (one, eight) = (breathing(1, softness), breathing(8, softness));
            let apart = one.iter().zip(&eight).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let most = one.iter().copied().fold(0.0, f32::max);
            println!("{softness:?}: 1 and 8 sweeps are {apart} apart; it swings up to {most}");
            assert!(apart < 2e-4 && most > 1.12, "{apart} {most}");
        }
    }

    #[test]
    fn faults_are_told_apart() {
        let equation = Tetrahedron::of(CORNER);
        assert_eq!(equation.fault(4), None);
        assert_eq!(equation.fault(3), Some(ConstraintFault::Count));
        assert_eq!(Tetrahedron { rest: -1.0, ..equation.clone() }.fault(4), None);
        assert_eq!(
            Tetrahedron { rest: f32::INFINITY, ..equation }.fault(4),
            Some(ConstraintFault::Number)
        );
    }
}
