//! A distance between two anchors. An anchor is a point carried by particles, such as a corner of a box, a place on a bone or the middle of a patch of cloth.
//!
//! It is an affine combination `x = Σ wᵢ xᵢ` of particle positions with `Σ wᵢ = 1`, so it moves with the particles under any affine map. On a rigid body it
//! therefore moves exactly as a point of the body, and no body frame has to be extracted.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::correction::GradientAt;
use super::distance::direction;
use super::equation::{Bound, Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use crate::pose::{PointMasses, pseudo_solve, symmetric};

/// Keeps two anchors a distance apart: `C = ‖x_a - x_b‖ - L`. With `L = 0` it is a ball joint.
#[derive(Clone, Debug, PartialEq)]
pub struct AnchorDistance {
    /// The first anchor; it uses the first particles of the constraint, one for each of its weights.
    pub a: Anchor,
    /// The second anchor; it uses the particles that follow.
    pub b: Anchor,
    /// Length to keep, metres, 0 or more.
    pub rest: f32,
    /// Whether the length is kept exactly, or only as an upper or lower limit.
    pub bound: Bound,
    /// How stiff the constraint is.
    pub softness: Softness,
}

/// A point carried by particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor {
    /// Weight of each particle; the weights sum to 1. [`affine_weights`] computes them.
    pub weights: Arc<[f32]>,
    /// Whether the particles form a rigid body. If so, a correction acts on the whole body, as a force on a rigid body at this point does, and not on each
    /// particle by its weight. Default false.
    pub rigid: bool,
}

impl Anchor {
    /// An anchor at a single particle.
    pub fn particle() -> Self {
        Self { weights: Arc::new([1.0]), rigid: false }
    }

    /// An anchor of several particles, one weight for each.
    pub fn new(weights: impl Into<Arc<[f32]>>) -> Self {
        Self { weights: weights.into(), rigid: false }
    }

    /// The same anchor, on a rigid body.
    pub fn rigid(self) -> Self {
        Self { rigid: true, ..self }
    }

    /// Position of the anchor, metres from the origin; its particles start at index `first`.
    fn at(&self, first: usize, position: impl Fn(usize) -> Vec3) -> Vec3 {
        let all = self.weights.iter().zip(first..);
        all.map(|(&w, i)| position(i) * w).sum()
    }

    /// Writes the gradient of `n·x` by each particle. `n` is a unit vector.
    ///
    /// For independent particles it is `wᵢ n`. A rigid body that is pulled along `n` at the lever arm `r` (from its barycentre) translates by `n/M` and rotates
    /// by `I⁻¹ (r × n)`. Particle i therefore gets `mᵢ (n/M + (I⁻¹ (r × n)) × rᵢ)`: these gradients sum to `n` and to the torque `r × n`, and the correction is
    /// a rigid motion, so the constraints inside the body have nothing to correct. With [`GradientAt::StepStart`] the lever arms are those at the start of the
    /// substep, which keeps the angular momentum.
    fn gradients(&self, points: &Points, first: usize, n: Vec3, gradients: &mut [Vec3]) {
        let numbers = first..first + self.weights.len();
        let free = numbers.clone().all(|i| points.inverse_mass(i) > 0.0);
        if !self.rigid || !free {
            for (&w, gradient) in self.weights.iter().zip(gradients) {
                *gradient = n * w;
            }
            return;
        }
        let start = points.gradient_at() == GradientAt::StepStart;
        let at = |i: usize| if start { points.start(i) } else { points.at(i) };
        let weighed =
            numbers.map(|i| (at(i).as_dvec3(), f64::from(points.inverse_mass(i)).recip()));
        let PointMasses { mass, barycentre, inertia } = PointMasses::of(weighed.clone());
        let n = n.as_dvec3();
        let lever = self.at(first, at).as_dvec3() - barycentre;
        let turn = pseudo_solve(inertia, lever.cross(n));
        for ((p, m), gradient) in weighed.zip(gradients) {
            *gradient = ((n / mass + turn.cross(p - barycentre)) * m).as_vec3();
        }
    }
}

impl AnchorDistance {
    /// A hard ball joint: both anchors in one place.
    pub fn joint(a: Anchor, b: Anchor) -> Self {
        Self { a, b, rest: 0.0, bound: Bound::Equal, softness: Softness::Hard }
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        let sides = [&self.a, &self.b];
        let sound = |anchor: &&Anchor| {
            let sum: f32 = anchor.weights.iter().sum();
            (sum - 1.0).abs() <= 1e-3 && anchor.weights.iter().all(|w| w.is_finite())
        };
        if sides.iter().any(|anchor| anchor.weights.is_empty())
            || self.a.weights.len() + self.b.weights.len() != particles
        {
            Some(ConstraintFault::Count)
        } else if !(sides.iter().all(sound) && self.rest.is_finite() && self.rest >= 0.0) {
            Some(ConstraintFault::Number)
        } else {
            None
        }
    }
}

impl Equation for AnchorDistance {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let second = self.a.weights.len();
        if second + self.b.weights.len() != points.len() {
            return 0.0;
        }
        let d = self.a.at(0, |i| points.at(i)) - self.b.at(second, |i| points.at(i));
        let (n, length) = direction(d);
        if length == 0.0 && self.rest == 0.0 {
            return 0.0;
        }
        let (first, others) = gradients.split_at_mut(second);
        self.a.gradients(points, 0, n, first);
        self.b.gradients(points, second, -n, others);
        length - self.rest
    }

    fn bound(&self) -> Bound {
        self.bound
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }

    fn is_length(&self) -> bool {
        true
    }
}

/// Relative threshold for a second moment (a squared extent). An axis whose moment is less than this share of the largest is treated as having no extent: the
/// particles cannot carry a point along it.
const FLAT: f64 = 1e-6;

/// The weights with which particles at `places` (metres) carry `point`. The weights sum to 1 and reproduce the point, or the nearest point that the particles
/// can carry if they lie on a line or in a plane. Of all such weights these have the least sum of squares. Empty if there are no particles.
pub fn affine_weights(places: &[Vec3], point: Vec3) -> Vec<f32> {
    let count = places.len() as f64;
    let centre = places.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count;
    let mut moments = [[0.0; 3]; 3];
    for place in places {
        let r = (place.as_dvec3() - centre).to_array();
        for (row, x) in moments.iter_mut().zip(r) {
            row.iter_mut().zip(r).for_each(|(to, y)| *to += x * y);
        }
    }
    let (values, axes) = symmetric::eigen(moments);
    let most = values.iter().copied().fold(0.0, f64::max);
    let to = point.as_dvec3() - centre;
    let kept = values.into_iter().zip(axes).filter(|&(value, _)| value > FLAT * most);
    let along: DVec3 = kept
        .map(|(value, axis)| {
            let axis = DVec3::from_array(axis);
            axis * (axis.dot(to) / value)
        })
        .sum();
    let weight = |place: &Vec3| (1.0 / count + (place.as_dvec3() - centre).dot(along)) as f32;
    places.iter().map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::super::checks::{self, Random, points_of};
    use super::*;

    fn corners(size: Vec3) -> Vec<Vec3> {
        let side = |i: usize, bit: usize| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        (0..8).map(|i| Vec3::new(side(i, 0), side(i, 1), side(i, 2)) * size).collect()
    }

    #[test]
    fn weights_carry_the_point_wherever_the_particles_are_turned() {
        let rest = corners(Vec3::new(1.0, 2.0, 0.5));
        let point = Vec3::new(0.7, -1.4, 0.1);
        let weights = affine_weights(&rest, point);
        let turned = |p: Vec3| glam::Quat::from_rotation_y(0.7) * p + Vec3::new(3.0, 1.0, -2.0);
        let carried: Vec3 = rest.iter().zip(&weights).map(|(&p, &w)| turned(p) * w).sum();
        assert!(carried.abs_diff_eq(turned(point), 1e-5), "{carried}");
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn flat_particles_carry_the_nearest_point_of_their_plane_and_one_carries_itself() {
        let flat = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X + Vec3::Y];
        let weights = affine_weights(&flat, Vec3::new(0.3, 0.8, 5.0));
        let carried: Vec3 = flat.iter().zip(&weights).map(|(&p, &w)| p * w).sum();
        assert!(carried.abs_diff_eq(Vec3::new(0.3, 0.8, 0.0), 1e-5), "{carried}");
        assert_eq!(affine_weights(&[Vec3::Y], Vec3::X), [1.0]);
        assert_eq!(affine_weights(&[], Vec3::X), []);
    }

    #[test]
    fn a_joint_of_two_boxes_closes_and_keeps_both_momenta_and_both_shapes() {
        let (one, other) = (corners(Vec3::ONE), corners(Vec3::new(0.4, 0.8, 0.6)));
        let a = Anchor::new(affine_weights(&one, Vec3::new(0.5, 0.2, 0.0))).rigid();
        let b = Anchor::new(affine_weights(&other, Vec3::new(-0.2, 0.4, 0.3))).rigid();
        let joint = AnchorDistance::joint(a, b);
        let places: Vec<Vec3> = one
            .iter()
            .copied()
            .chain(other.iter().map(|&p| p + Vec3::new(0.75, -0.18, -0.33)))
            .collect();
        let masses: Vec<f32> = (0..16).map(|i| if i < 8 { 0.5 } else { 0.1 }).collect();
        assert_eq!(joint.fault(16), None);
        checks::assert_momentum_kept(&joint, &places, &masses);
        let mut particles = points_of(&places, &masses);
        let before = particles.project(&joint);
        // To first order in its length, the correction is a rigid motion.
        let length = |p: &[Vec3], i: usize, k: usize| p[i].distance(p[k]);
        let after = particles.positions();
        for (i, k) in [(0, 1), (0, 7), (2, 5), (8, 9), (8, 15)] {
            let change = (length(&after, i, k) - length(&places, i, k)).abs();
            assert!(before > 0.03 && change < 2.0 * before * before, "{i} {k}: {change}");
        }
        // The correction acts only along the current offset, but the anchors also move sideways: each projection leaves a part of the error.
        for _ in 0..20 {
            particles.project(&joint);
        }
        assert!(particles.error(&joint) < 1e-5, "{}", particles.error(&joint));
    }

    #[test]
    fn it_moves_a_rigid_body_by_its_inverse_mass_at_the_point() {
        // A cube of 8 kg, pulled at a corner particle: n/M + (r × n) I⁻¹ (r × n) per unit of correction.
        let (places, masses) = (corners(Vec3::ONE), [1.0; 8]);
        let anchor = Anchor::new(affine_weights(&places, Vec3::new(0.5, 0.0, 0.0))).rigid();
        let mut all = places.clone();
        all.push(Vec3::new(0.5, 1.0, 0.0));
        let masses: Vec<f32> = masses.into_iter().chain([f32::INFINITY]).collect();
        let joint = AnchorDistance::joint(anchor, Anchor::particle());
        let particles = points_of(&all, &masses);
        let mut gradients = [Vec3::ZERO; 9];
        joint.evaluate(&particles.points(), &mut gradients);
        let w: f32 = gradients[..8].iter().map(|g| g.length_squared()).sum();
        // I = 8 · (0.25 + 0.25) = 4 kg·m²; r × n = 0.5: 1/8 + 0.25/4.
        assert!((w - (0.125 + 0.0625)).abs() < 1e-6, "{w}");
    }

    #[test]
    fn the_gradient_of_free_particles_is_the_derivative() {
        let mut random = Random::new(5);
        let places: Vec<Vec3> = (0..6).map(|_| random.vector()).collect();
        let [a, b] = [[0.2, 0.3, 0.5], [0.7, -0.4, 0.7]].map(Anchor::new);
        let joint = AnchorDistance { rest: 0.1, ..AnchorDistance::joint(a, b) };
        checks::assert_gradients(&joint, &places);
    }

    #[test]
    fn faults_are_told_apart() {
        let joint = AnchorDistance::joint(Anchor::particle(), Anchor::new([0.5, 0.5]));
        assert_eq!(joint.fault(3), None);
        assert_eq!(joint.fault(2), Some(ConstraintFault::Count));
        let off = AnchorDistance::joint(Anchor::particle(), Anchor::new([0.5, 0.4]));
        assert_eq!(off.fault(3), Some(ConstraintFault::Number));
        assert_eq!(
            AnchorDistance { rest: f32::NAN, ..joint }.fault(3),
            Some(ConstraintFault::Number)
        );
    }
}
