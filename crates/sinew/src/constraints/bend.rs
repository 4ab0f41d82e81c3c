//! Isometric bending of two triangles that share an edge (physics.md C9).

use glam::{DVec3, Vec3};

use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::wide::{Wide, numbers};
use crate::lanes::{LANES, Lanes, Vector};

/// Keeps two triangles that share an edge from bending; particles `[e0, e1, a, b]`: the edge, then the two opposite corners.
///
/// Its value is linear in the positions up to a square root, so it is cheaper and calmer than an angle. The price: it knows how much is bent but not
/// to which side, so a shape whose rest is folded may as well be folded the other way, and folded flat upon itself it is at a maximum.
/// Flat, its edge goes to the side of `edge × (b - a)`, or of z if that is nothing.
///
/// # The value
///
/// A piecewise linear surface is bent in its edges alone. With θ the fold at an edge `e` (small) and `h` the heights of its two triangles over it,
/// the cotangents of the corners at the edge combine the four particles to the jump of the slope, times the length of the edge,
///
/// ```text
/// Σ Kᵢ xᵢ = ‖e‖ θ n        K = (cot a₁ + cot b₁, cot a₀ + cot b₀, -cot a₀ - cot a₁, -cot b₀ - cot b₁)
/// ```
///
/// (Wardetzky, Bergou, Harmon, Zorin, Grinspun, *Discrete quadratic curvature energies*, 2007; `a₀` is the angle of the triangle of `a` at `e0`.)
/// Here everything is divided by `k = K₀ + K₁ = ‖e‖ (1/hₐ + 1/h_b)`. Then the weights of the edge sum to 1 and those of the corners to -1: the value
/// `‖Σ wᵢ xᵢ‖ - rest` is the gap, in metres, between a point on the edge and one between the corners, which coincide in a flat rest shape (there
/// the diagonals cross). The weights sum to zero, so momentum is kept; and all gradients `wᵢ n` lie along `n = Σ wᵢ xᵢ / ‖…‖`, so the torque is
/// `Σ wᵢ xᵢ × n = 0` as well.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend {
    /// Weights of the particles: the edge's two sum to 1, the corners' to -1. [`Bend::of`] finds them.
    pub weights: [f32; 4],
    /// Length of the weighted sum at rest, metres, not negative; zero for a flat rest shape.
    pub rest: f32,
    /// How hard it is.
    pub softness: Softness,
}

/// A height of less than this share of the edge, or an edge of less than this share of a height, is no triangle: cotangents of a million have no
/// digits left for the bend.
const THINNEST: f64 = 1e-6;

/// A gap of less than this share of the distance between the corners is none: ten times the round-off of `f32`.
const FLAT: f32 = 1e-6;

impl Bend {
    /// A hard one that is at rest where the four particles are now, metres: the edge, then the two opposite corners. `None` if one of the triangles
    /// has no area, or something is not finite.
    pub fn of(positions: [Vec3; 4]) -> Option<Self> {
        Some(Stencil::of(positions)?.bend(Softness::Hard))
    }

    /// The same for a sheet of a bending stiffness, N·m: the `B` of `½ B κ²` joules per square metre for the curvature κ. Positive; `None` otherwise,
    /// and as for [`of`](Self::of). Writing paper has about 3e-4 N·m, cotton 5e-6.
    ///
    /// # The compliance
    ///
    /// The paper's energy of an edge is `½ B · 3/(A₀ + A₁) · ‖Σ Kᵢ xᵢ‖²`, as if a third of each of its triangles were bent evenly, by what the whole
    /// fold is. But in a regular mesh one of the three edges of a triangle gets all of the fold of a cylinder and the others none, or (aslant) they
    /// share it out so that the squares sum to the same. The mean of the curvature is right then, and the mean of its square, the energy,
    /// threefold. So here it is `½ B · ‖Σ Kᵢ xᵢ‖² / (A₀ + A₁)`, that is, with `C` = `‖Σ Kᵢ xᵢ‖ / k`,
    ///
    /// ```text
    /// ½ C²/α = ½ B k² C² / (A₀ + A₁)        α = (A₀ + A₁) / (B k²)        [m/N]
    /// ```
    ///
    /// which is exact for a cylinder of equilateral triangles in any direction, and of right-angled ones along their legs, at any size. A mesh of
    /// right-angled triangles is stiffer than that along its diagonals, by up to three: a mesh has a grain.
    pub fn stiff(positions: [Vec3; 4], stiffness: f32) -> Option<Self> {
        let stencil = Stencil::of(positions)?;
        let k = stencil.sum;
        let compliance = (stencil.area / (f64::from(stiffness) * k * k)) as f32;
        let sound = stiffness > 0.0 && compliance.is_finite();
        sound.then(|| stencil.bend(Softness::compliant(compliance)))
    }

    /// Why it cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        let [e0, e1, a, b] = self.weights;
        let size = e0.abs() + e1.abs() + a.abs() + b.abs();
        // What does not sum to zero holds on to the origin.
        let balanced = size.is_finite() && (e0 + e1 + a + b).abs() <= 1e-5 * size;
        if particles != 4 {
            Some(ConstraintFault::Count)
        } else if !(balanced && self.rest.is_finite() && self.rest >= 0.0) {
            Some(ConstraintFault::Number)
        } else {
            None
        }
    }
}

impl Equation for Bend {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        // From the first particle, so that the digits are the shape's own.
        let from = |i: usize| points.at(i) - points.at(0);
        let [_, w1, wa, wb] = self.weights;
        let gap = from(1) * w1 + from(2) * wa + from(3) * wb;
        let (length, across) = (gap.length(), from(3) - from(2));
        // What is flat up to round-off has a direction of no meaning, which matters only if it has to be folded along that.
        let flat = length == 0.0 || (self.rest > 0.0 && length <= FLAT * across.length());
        let normal = if flat { from(1).cross(across).normalize_or(Vec3::Z) } else { gap / length };
        for (gradient, w) in gradients.iter_mut().zip(self.weights) {
            *gradient = normal * w;
        }
        length - self.rest
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

/// Two triangles at an edge, at rest.
struct Stencil {
    weights: [f64; 4],
    /// Length of the weighted sum, m.
    gap: f64,
    /// `k`, which the cotangents were divided by.
    sum: f64,
    /// Of both triangles, m².
    area: f64,
}

impl Stencil {
    fn of(positions: [Vec3; 4]) -> Option<Self> {
        let [e0, e1, a, b] = positions.map(Vec3::as_dvec3);
        let edge = e1 - e0;
        let (a0, a1, area_a) = cotangents(edge, a - e0)?;
        let (b0, b1, area_b) = cotangents(edge, b - e0)?;
        let sum = a0 + a1 + b0 + b1;
        let weights = [a1 + b1, a0 + b0, -(a0 + a1), -(b0 + b1)].map(|k| k / sum);
        let gap: DVec3 = edge * weights[1] + (a - e0) * weights[2] + (b - e0) * weights[3];
        let mut gap = gap.length();
        // Flat up to the round-off of the positions is flat: a rest of a few nanometres would be a fold that flickers.
        if gap <= f64::from(FLAT) * (b - a).length() {
            gap = 0.0;
        }
        Some(Self { weights, gap, sum, area: area_a + area_b })
    }

    fn bend(&self, softness: Softness) -> Bend {
        Bend { weights: self.weights.map(|w| w as f32), rest: self.gap as f32, softness }
    }
}

/// Cotangents of a triangle's angles at both ends of `edge`, and its area, m²; `side` leads from the first end to the third corner.
fn cotangents(edge: DVec3, side: DVec3) -> Option<(f64, f64, f64)> {
    let twice = edge.cross(side).length();
    let square = edge.length_squared();
    // The height is `twice / ‖edge‖`. Written so that a NaN declines.
    let thick = twice >= THINNEST * square && twice >= THINNEST * side.length_squared();
    let sound = thick && twice > 0.0 && twice.is_finite();
    sound.then(|| (edge.dot(side) / twice, edge.dot(edge - side) / twice, 0.5 * twice))
}

/// The numbers of eight [`Bend`]s.
#[derive(Clone, Debug)]
pub(crate) struct Bends {
    weights: [[f32; LANES]; 4],
    rest: [f32; LANES],
}

impl Wide<4> for Bends {
    const IS_LENGTH: bool = true;

    type Kind = Bend;

    fn of(bends: [&Bend; LANES], _: [usize; LANES]) -> Self {
        let weights = [0, 1, 2, 3].map(|i| numbers(bends, |bend| bend.weights[i]));
        Self { weights, rest: numbers(bends, |bend| bend.rest) }
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 4]) -> (L, [Vector<L>; 4]) {
        let [e0, e1, a, b] = *points;
        let (edge, to_a, to_b) = (e1 - e0, a - e0, b - e0);
        let [w0, w1, wa, wb] = &self.weights;
        let (w0, w1, wa, wb) = (L::load(w0), L::load(w1), L::load(wa), L::load(wb));
        let gap = edge * w1 + to_a * wa + to_b * wb;
        let (length, across) = (gap.length(), to_b - to_a);
        let rest = L::load(&self.rest);
        let nothing = length.same(L::zero());
        // Of a gap of nothing the direction is of any meaning only where there is to be one.
        let mut normal = gap * nothing.select(L::zero(), L::splat(1.0) / length);
        let small = length.le(L::splat(FLAT) * across.length());
        let flat = L::zero().lt(rest).and(nothing.or(small));
        if flat.any() {
            let up = edge.cross(across);
            let size = up.length();
            let up =
                Vector::splat(Vec3::Z).or_else(size.same(L::zero()), up * (L::splat(1.0) / size));
            normal = up.or_else(flat, normal);
        }
        (length - rest, [normal * w0, normal * w1, normal * wa, normal * wb])
    }
}

#[cfg(test)]
mod tests;
