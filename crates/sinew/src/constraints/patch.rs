//! The area of a whole patch of triangles (physics.md C8), and helpers shared by the constraints on meshes.

use std::sync::Arc;

use glam::{DVec3, Vec3, Vec4};

use super::area::{area, area_wide, keep_within_reach};
use super::correction::SizeCorrection;
use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, kernel};

/// Keeps the total area of a patch of triangles: one may grow while another shrinks.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// The triangles, as indices into the constraint's particles. Their winding does not matter.
    pub triangles: Arc<[[u32; 3]]>,
    /// Area to keep, m², 0 or more.
    pub rest: f32,
    /// How the area is corrected.
    pub correction: SizeCorrection,
    /// How stiff the constraint is. A compliance is in m⁴/J along the gradient, and in m/N for scaling.
    pub softness: Softness,
}

impl Patch {
    /// A hard constraint that keeps the area of the patch at these positions, along the gradient. `positions` are those of the constraint's particles, in its
    /// order. A triangle with an index out of range does not count, and [`Constraint::fault`](super::Constraint::fault) reports it.
    pub fn of(triangles: impl Into<Arc<[[u32; 3]]>>, positions: &[Vec3]) -> Self {
        let triangles = triangles.into();
        let corner = |i: u32| positions.get(i as usize).copied();
        let one = |t: &[u32; 3]| Some(area([corner(t[0])?, corner(t[1])?, corner(t[2])?]).0);
        let rest = triangles.iter().filter_map(one).map(f64::from).sum::<f64>() as f32;
        Self { triangles, rest, correction: SizeCorrection::Gradient, softness: Softness::Hard }
    }

    /// The same patch with another correction.
    pub fn with_correction(self, correction: SizeCorrection) -> Self {
        Self { correction, ..self }
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if particles < 3 {
            Some(ConstraintFault::Count)
        } else if !(self.rest.is_finite() && self.rest >= 0.0) {
            Some(ConstraintFault::Number)
        } else {
            triangle_fault(&self.triangles, particles)
        }
    }
}

/// Along the gradient: `C = ΣA - A₀`, m², with the gradient of each triangle from `area`; `keep_within_reach` bounds the length of a step. By scaling (see
/// `scale`): lengths go as the root of the area, so the factor is `√(A₀/A)`. A patch of no area, or of less than a quarter of its rest area, is corrected along
/// the gradient in either case. The solver derives the error from value and gradient, which gives the same length for both units.
impl Equation for Patch {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        // All instruction sets give the same bits, so the fastest is used.
        let best = InstructionSet::best();
        let sum = area_of(&self.triangles, points.now, gradients, best);
        let now = sum as f32;
        if self.correction == SizeCorrection::Scaling && self.rest <= 4.0 * now {
            return scale(points, (self.rest / now).sqrt(), gradients);
        }
        let value = (sum - f64::from(self.rest)) as f32;
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

/// Uniform scaling by `factor` about the mass barycentre, as a value and gradients that the generic projection turns into exactly that.
///
/// Every free particle has to move by `dᵢ = (s - 1)(qᵢ - B)`. Let `M = Σm` over the free particles, `R = √(Σ mᵢ‖qᵢ - B‖²/M)` the root mean square distance from
/// the barycentre (metres), and
///
/// ```text
/// C = (1 - s) R        ∇ᵢC = mᵢ (qᵢ - B)/(M R)        so that Σ wⱼ‖∇ⱼC‖² = Σ mⱼ‖qⱼ - B‖²/(M R)² = 1/M
/// ```
///
/// The projection `dᵢ = -wᵢ ∇ᵢC · C/(1/M)` gives `-(qᵢ - B)/(M R) · (1 - s) R · M = (s - 1)(qᵢ - B)`. `|C|` is the root mean square displacement, a length. The
/// gradient is that of `R` with the factor held fixed, not that of the factor, so the displacement is not the least.
///
/// `B` is the barycentre of the *masses*: `Σ mᵢ(qᵢ - B) = 0` keeps momentum and `Σ mᵢ (qᵢ - B)×(qᵢ - B) = 0` angular momentum. A pinned particle has infinite
/// mass, so if there are any, `B` is their mean. They do not move; with a single one the size is still exact after one step.
pub(super) fn scale(points: &Points, factor: f32, gradients: &mut [Vec3]) -> f32 {
    gradients.fill(Vec3::ZERO);
    let all = || (0..points.len()).map(|i| (points.at(i).as_dvec3(), mass(points.inverse_mass(i))));
    let (mut free, mut pinned) = ((DVec3::ZERO, 0.0), (DVec3::ZERO, 0.0));
    for (q, m) in all() {
        match m {
            Some(m) => free = (free.0 + q * m, free.1 + m),
            None => pinned = (pinned.0 + q, pinned.1 + 1.0),
        }
    }
    let (sum, weight) = if pinned.1 > 0.0 { pinned } else { free };
    let middle = sum / weight;
    let square: f64 =
        all().map(|(q, m)| m.map_or(0.0, |m| m * (q - middle).length_squared())).sum();
    let radius = (square / free.1).sqrt();
    // No free particle, or all in one place: there is no size to scale.
    if !(radius > 0.0 && radius.is_finite()) {
        return 0.0;
    }
    for (gradient, (q, m)) in gradients.iter_mut().zip(all()) {
        *gradient = m.map_or(Vec3::ZERO, |m| ((q - middle) * (m / (free.1 * radius))).as_vec3());
    }
    (1.0 - factor) * radius as f32
}

/// Mass in kg; `None` if it is pinned.
fn mass(inverse: f32) -> Option<f64> {
    (inverse > 0.0).then(|| 1.0 / f64::from(inverse))
}

/// What is wrong with the triangles of a constraint with this many particles.
pub(super) fn triangle_fault(triangles: &[[u32; 3]], particles: usize) -> Option<ConstraintFault> {
    if triangles.iter().flatten().any(|&i| i as usize >= particles) {
        Some(ConstraintFault::Triangle)
    } else if triangles.iter().any(|[a, b, c]| a == b || b == c || c == a) {
        Some(ConstraintFault::SameParticle)
    } else {
        None
    }
}

kernel!(
    /// The area of some triangles; the gradients are added to `gradients`. Both are summed in the order of the triangles, areas in f64, so that the result is
    /// the same for any instruction set.
    ///
    /// There is no such kernel for a volume: summing its gradients takes as long as the whole scalar loop.
    fn area_of<L: Lanes>(triangles: &[[u32; 3]], now: &[Vec4], gradients: &mut [Vec3]) -> f64 {
        let mut sum = 0.0;
        for some in triangles.chunks(LANES) {
            // Unused lanes of the last chunk repeat the first triangle and are not added.
            let mut rows = some[0].map(|row| [row; LANES]);
            for (lane, triangle) in some.iter().enumerate() {
                for (rows, row) in rows.iter_mut().zip(triangle) {
                    rows[lane] = *row;
                }
            }
            let (a, _) = Vector::of(L::rows(now, &rows[0]));
            let (b, _) = Vector::of(L::rows(now, &rows[1]));
            let (c, _) = Vector::of(L::rows(now, &rows[2]));
            let (areas, [by_a, by_b, by_c]) = area_wide(&[a, b, c]);
            let areas = areas.array();
            let by = [
                [by_a.x.array(), by_a.y.array(), by_a.z.array()],
                [by_b.x.array(), by_b.y.array(), by_b.z.array()],
                [by_c.x.array(), by_c.y.array(), by_c.z.array()],
            ];
            for (lane, triangle) in some.iter().enumerate() {
                sum += f64::from(areas[lane]);
                for ([x, y, z], row) in by.iter().zip(triangle) {
                    gradients[*row as usize] += Vec3::new(x[lane], y[lane], z[lane]);
                }
            }
        }
        sum
    }
);

#[cfg(test)]
mod lanes_tests {
    use super::*;
    use crate::constraints::area::area;
    use crate::constraints::checks::Random;

    /// 50 particles, two of them coincident, and 83 triangles between them.
    fn mesh() -> (Vec<Vec4>, Vec<[u32; 3]>) {
        let mut now: Vec<_> = Random::new(51).positions(50).iter().map(|p| p.extend(1.0)).collect();
        now[7] = now[8];
        let triangles = (0..83_u32).map(|k| [k % 50, (k * 7 + 3) % 50, (k * 11 + 8) % 50]);
        (now, triangles.collect())
    }

    fn sums(set: InstructionSet, count: usize) -> (f64, Vec<Vec3>) {
        let (now, triangles) = mesh();
        let mut gradients = vec![Vec3::ZERO; now.len()];
        (area_of(&triangles[..count], &now, &mut gradients, set), gradients)
    }

    #[test]
    fn every_set_adds_up_to_the_same_bits_for_any_number_of_triangles() {
        for count in [0, 1, 7, 8, 9, 16, 83] {
            let truth = sums(InstructionSet::Scalar, count);
            for set in [InstructionSet::Simd128, InstructionSet::Avx2] {
                assert_eq!(sums(set, count), truth);
            }
        }
    }

    #[test]
    fn triangle_by_triangle_it_is_the_same_area() {
        let (now, triangles) = mesh();
        let (mut sum, mut gradients) = (0.0, vec![Vec3::ZERO; now.len()]);
        for rows in triangles {
            let (one, by) = area(rows.map(|row| now[row as usize].truncate()));
            sum += f64::from(one);
            for (row, by) in rows.into_iter().zip(by) {
                gradients[row as usize] += by;
            }
        }
        let (found, by) = sums(InstructionSet::best(), 83);
        assert!(by.iter().zip(&gradients).all(|(a, b)| a.abs_diff_eq(*b, 1e-5)));
        assert!((found - sum).abs() < 1e-5 * sum && sum > 10.0, "{found} {sum}");
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::*;

    /// A sheet of 3 × 3 particles, 1 m wide, slightly curved so that it is not planar.
    fn sheet() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut places = Vec::new();
        for row in 0..3 {
            for column in 0..3 {
                let (x, y) = (column as f32 * 0.5, row as f32 * 0.5);
                places.push(Vec3::new(x, y + 0.1 * x, 0.3 * x * x - 0.2 * x * y));
            }
        }
        let mut triangles = Vec::new();
        for [row, column] in [[0, 0], [0, 1], [1, 0], [1, 1]] {
            let corner = row * 3 + column;
            triangles.push([corner, corner + 1, corner + 4]);
            triangles.push([corner, corner + 4, corner + 3]);
        }
        (places, triangles)
    }

    fn patch(factor: f32, correction: SizeCorrection) -> Patch {
        let (places, triangles) = sheet();
        let patch = Patch::of(triangles, &places).with_correction(correction);
        Patch { rest: patch.rest * factor, ..patch }
    }

    #[test]
    fn the_gradient_is_that_of_the_whole_area() {
        let (places, _) = sheet();
        assert!((patch(1.0, SizeCorrection::Gradient).rest - 1.0).abs() < 0.2);
        assert_gradients(&patch(0.5, SizeCorrection::Gradient), &places);
        assert_gradients(&patch(1.5, SizeCorrection::Gradient), &places);
    }

    #[test]
    fn either_way_keeps_momentum_and_the_area_and_one_at_the_least_cost() {
        let (places, _) = sheet();
        let masses = Random::new(31).masses(9);
        for correction in [SizeCorrection::Gradient, SizeCorrection::Scaling] {
            for factor in [0.3, 0.9, 1.1, 3.0, 20.0] {
                assert_momentum_kept(&patch(factor, correction), &places, &masses);
                assert_kept(&patch(factor, correction), &places, &masses, 1e-4);
            }
        }
        assert_least(&patch(0.95, SizeCorrection::Gradient), &places, &masses);
        assert_least(&patch(1.05, SizeCorrection::Gradient), &places, &masses);
    }

    #[test]
    fn one_scaling_makes_the_area_right_and_moves_each_particle_as_derived() {
        let (places, _) = sheet();
        let masses = Random::new(32).masses(9);
        let equation = patch(1.7, SizeCorrection::Scaling);
        let mut particles = points_of(&places, &masses);
        particles.project(&equation);
        assert!(
            (Patch::of(equation.triangles.clone(), &particles.positions()).rest / equation.rest
                - 1.0)
                .abs()
                < 1e-5
        );
        let total: f32 = masses.iter().sum();
        let middle = places.iter().zip(&masses).map(|(p, m)| *p * *m).sum::<Vec3>() / total;
        for (p, q) in places.iter().zip(particles.positions()) {
            assert!(q.abs_diff_eq(middle + (*p - middle) * 1.7_f32.sqrt(), 1e-5), "{p} {q}");
        }
    }

    #[test]
    fn a_scaling_with_one_pinned_particle_is_right_at_once_about_that() {
        let (places, _) = sheet();
        let mut masses = vec![1.0; 9];
        masses[2] = f32::INFINITY;
        let equation = patch(0.6, SizeCorrection::Scaling);
        let mut particles = points_of(&places, &masses);
        particles.project(&equation);
        assert_eq!(particles.positions()[2], places[2]);
        assert!(particles.error(&equation) < 1e-5);
    }

    #[test]
    fn either_way_survives_every_degenerate_set() {
        let (places, _) = sheet();
        for correction in [SizeCorrection::Gradient, SizeCorrection::Scaling] {
            for factor in [0.0, 0.5, 1e6] {
                let soft = Softness::frequency(5.0, 0.5);
                assert_survives(&patch(factor, correction), &places);
                assert_survives(&patch(factor, correction).with_softness(soft), &places);
            }
        }
    }

    #[test]
    fn faults_are_told_apart() {
        let good = patch(1.0, SizeCorrection::Gradient);
        assert_eq!(good.fault(9), None);
        assert_eq!(good.fault(8), Some(ConstraintFault::Triangle));
        assert_eq!(good.fault(2), Some(ConstraintFault::Count));
        assert_eq!(patch(-1.0, SizeCorrection::Gradient).fault(9), Some(ConstraintFault::Number));
        assert_eq!(
            patch(f32::NAN, SizeCorrection::Gradient).fault(9),
            Some(ConstraintFault::Number)
        );
        let twice = Patch { triangles: Arc::from([[0, 1, 1]]), ..good };
        assert_eq!(twice.fault(9), Some(ConstraintFault::SameParticle));
        assert_eq!(
            Patch::of([[0, 1, 7]], &[Vec3::ZERO; 3]).fault(3),
            Some(ConstraintFault::Triangle)
        );
    }
}
