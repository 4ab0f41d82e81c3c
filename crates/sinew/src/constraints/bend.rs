//! Isometric bending of two triangles that share an edge (physics.md C9).

use glam::{DVec3, Vec3};

use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::wide::{Wide, numbers};
use crate::lanes::{LANES, Lanes, Vector};

/// Isometric bending: keeps two triangles that share an edge from folding. The particles are `[e0, e1, a, b]`: the edge, then the two opposite corners.
///
/// Its value is linear in the positions up to a square root, so it is cheaper and better conditioned than an angle. The price: the value has no sign. A shape
/// with a folded rest state may fold to the other side, and a shape folded flat upon itself is at a maximum of the value. A flat shape with a folded rest state
/// folds towards `edge × (b - a)`, or towards +z if that is zero.
///
/// # The value
///
/// A piecewise linear surface bends at its edges only. Let θ be the (small) fold angle at an edge `e` and `h` the heights of its two triangles over it. The
/// cotangents of the corner angles at the edge combine the four particles to the jump of the slope across the edge, times the length of the edge:
///
/// ```text
/// Σ Kᵢ xᵢ = ‖e‖ θ n        K = (cot a₁ + cot b₁, cot a₀ + cot b₀, -cot a₀ - cot a₁, -cot b₀ - cot b₁)
/// ```
///
/// (Wardetzky, Bergou, Harmon, Zorin, Grinspun, *Discrete quadratic curvature energies*, 2007; `a₀` is the angle of the triangle of `a` at `e0`.)
/// Here everything is divided by `k = K₀ + K₁ = ‖e‖ (1/hₐ + 1/h_b)`, so that the weights of the edge sum to 1 and those of the corners to -1. The value `‖Σ wᵢ
/// xᵢ‖ - rest` is then based on the gap, in metres, between a point on the edge and a point on the line between the corners. In a flat rest shape the two
/// points coincide, where the diagonals cross. The weights sum to zero, so momentum is kept. All gradients `wᵢ n` are along `n = Σ wᵢ xᵢ / ‖…‖`, so the torque
/// `Σ wᵢ xᵢ × n` is zero as well.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend {
    /// Weights of the particles: the two of the edge sum to 1, those of the corners to -1. [`Bend::of`] computes them.
    pub weights: [f32; 4],
    /// Length of the weighted sum at rest, metres, 0 or more; zero for a flat rest shape.
    pub rest: f32,
    /// How stiff the constraint is.
    pub softness: Softness,
}

/// Relative threshold for a degenerate triangle. A height of less than this share of the edge, or an edge of less than this share of a height, is rejected:
/// cotangents of a million leave no digits for the fold.
const THINNEST: f64 = 1e-6;

/// Relative threshold for a flat shape: a gap of less than this share of the distance between the corners counts as zero. Ten times the round-off of `f32`.
const FLAT: f32 = 1e-6;

impl Bend {
    /// A hard constraint whose rest shape is these four positions, metres: the edge, then the two opposite corners. `None` if one of the triangles has no area,
    /// or a position is not finite.
    pub fn of(positions: [Vec3; 4]) -> Option<Self> {
        Some(Stencil::of(positions)?.bend(Softness::Hard))
    }

    /// The same for a sheet with bending stiffness `stiffness`, N·m: the `B` in the energy `½ B κ²` joules per square metre at the curvature κ. `None` if it is
    /// not positive, and in the cases of [`of`](Self::of). Writing paper has about 3e-4 N·m, cotton 5e-6.
    ///
    /// # The compliance
    ///
    /// The paper's energy of an edge is `½ B · 3/(A₀ + A₁) · ‖Σ Kᵢ xᵢ‖²`, which spreads the whole fold evenly over a third of each adjacent triangle. But when
    /// a regular mesh is rolled to a cylinder, one of the three edges of a triangle takes all of the fold and the others none; in an oblique direction the
    /// edges share it so that the squares sum to the same. The mean curvature is then right, but the mean of its square, the energy, is three times too large.
    /// So the energy used here is `½ B · ‖Σ Kᵢ xᵢ‖² / (A₀ + A₁)`, that is, with `C` = `‖Σ Kᵢ xᵢ‖ / k`,
    ///
    /// ```text
    /// ½ C²/α = ½ B k² C² / (A₀ + A₁)        α = (A₀ + A₁) / (B k²)        [m/N]
    /// ```
    ///
    /// This is exact for a cylinder made of equilateral triangles in any direction, and of right-angled triangles along their legs, at any mesh size. A mesh of
    /// right-angled triangles is up to three times stiffer along its diagonals: a mesh is anisotropic.
    pub fn stiff(positions: [Vec3; 4], stiffness: f32) -> Option<Self> {
        let stencil = Stencil::of(positions)?;
        let k = stencil.sum;
        let compliance = (stencil.area / (f64::from(stiffness) * k * k)) as f32;
        let sound = stiffness > 0.0 && compliance.is_finite();
        sound.then(|| stencil.bend(Softness::compliant(compliance)))
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        let [e0, e1, a, b] = self.weights;
        let size = e0.abs() + e1.abs() + a.abs() + b.abs();
        // Weights that do not sum to zero would tie the shape to the origin.
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
        // Relative to the first particle, to keep the precision of the shape itself.
        let from = |i: usize| points.at(i) - points.at(0);
        let [_, w1, wa, wb] = self.weights;
        let gap = from(1) * w1 + from(2) * wa + from(3) * wb;
        let (length, across) = (gap.length(), from(3) - from(2));
        // In a shape that is flat up to round-off the direction of the gap is noise. It matters only if the rest shape is folded.
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

/// Two triangles that share an edge, in their rest shape.
struct Stencil {
    weights: [f64; 4],
    /// Length of the weighted sum, m.
    gap: f64,
    /// `k`, by which the cotangents were divided.
    sum: f64,
    /// Area of both triangles, m².
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
        // A gap within the round-off of the positions is set to zero: a rest gap of a few nanometres would be a fold with a flickering direction.
        if gap <= f64::from(FLAT) * (b - a).length() {
            gap = 0.0;
        }
        Some(Self { weights, gap, sum, area: area_a + area_b })
    }

    fn bend(&self, softness: Softness) -> Bend {
        Bend { weights: self.weights.map(|w| w as f32), rest: self.gap as f32, softness }
    }
}

/// Cotangents of a triangle's angles at both ends of `edge`, and its area, m². `side` is the vector from the first end of the edge to the third corner.
fn cotangents(edge: DVec3, side: DVec3) -> Option<(f64, f64, f64)> {
    let twice = edge.cross(side).length();
    let square = edge.length_squared();
    // The height is `twice / ‖edge‖`. Written so that a NaN gives `None`.
    let thick = twice >= THINNEST * square && twice >= THINNEST * side.length_squared();
    let sound = thick && twice > 0.0 && twice.is_finite();
    sound.then(|| (edge.dot(side) / twice, edge.dot(edge - side) / twice, 0.5 * twice))
}

/// The parameters of eight [`Bend`]s.
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
        // The direction of a zero gap matters only if the rest gap is not zero.
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
