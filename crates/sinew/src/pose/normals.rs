//! Vertex normals of a mesh, for rendering: at each vertex the normalised sum of the area vectors of the triangles around it.
//!
//! `(p₁-p₀) × (p₂-p₀)` is twice the area times the normal of a triangle. Summing these instead of unit normals saves a square root per triangle, gives slivers
//! little weight, and makes the result in a flat part its normal, however it is triangulated.

use glam::{Vec3, Vec4, Vec4Swizzles};

use crate::lanes::{LANES, Lanes, Vector, kernel};

/// Least squared length of a sum of area vectors that has a direction, m⁴: far above the underflow of `f32`, and the square for a triangle with edges of 50 nm.
const MIN_SQUARE: f32 = 1e-30;

kernel!(
    /// Writes the unit normal of each vertex to `normals`, `[x y z 0]`; as many as there are `points`.
    ///
    /// `points` are `[x y z _]` in metres relative to a point nearby, in the frame that the normals are to be in; the fourth number is ignored. Triangles that
    /// are anticlockwise as seen from outside have normals that point outwards. A triangle with an index out of range is skipped.
    ///
    /// A vertex of no triangle, or of triangles whose area vectors sum to zero or overflow, gets `fallback`. The bits do not depend on `instructions`; pass
    /// [`InstructionSet::default`](crate::InstructionSet::default). Only `normals` may be reallocated, once.
    pub fn normals<L: Lanes>(
        points: &[Vec4],
        triangles: &[[u32; 3]],
        fallback: Vec3,
        normals: &mut Vec<Vec4>,
    ) {
        normals.clear();
        normals.resize(points.len(), Vec4::ZERO);
        let normals = &mut normals[..];
        // Slices of one length, so that an index needs one bounds check.
        let points = &points[..normals.len()];
        for &[a, b, c] in triangles {
            let [a, b, c] = [a as usize, b as usize, c as usize];
            if a < points.len() && b < points.len() && c < points.len() {
                let p = points[a];
                let area = cross(points[b] - p, points[c] - p);
                normals[a] += area;
                normals[b] += area;
                normals[c] += area;
            }
        }
        let (eights, rest) = normals.as_chunks_mut::<LANES>();
        let mut last = [Vec4::ZERO; LANES];
        last[..rest.len()].copy_from_slice(rest);
        for eight in eights.iter_mut().chain([&mut last]) {
            let (sum, _) = Vector::<L>::of(L::run(eight, 0));
            let squared = sum.length_squared();
            let directed =
                L::splat(MIN_SQUARE).lt(squared).and(squared.lt(L::splat(f32::INFINITY)));
            let unit = sum * (L::splat(1.0) / squared.sqrt());
            let normal = unit.or_else(directed, Vector::splat(fallback));
            L::put_run(eight, 0, normal.with(L::zero()));
        }
        rest.copy_from_slice(&last[..rest.len()]);
    }
);

/// The cross product of the first three components; the fourth is zero.
#[inline(always)]
fn cross(a: Vec4, b: Vec4) -> Vec4 {
    (a * b.yzxw() - a.yzxw() * b).yzxw()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::InstructionSet;
    use crate::test_random::Random;

    const SETS: [InstructionSet; 3] = InstructionSet::ALL;

    fn found(points: &[Vec4], triangles: &[[u32; 3]]) -> Vec<Vec4> {
        let mut found = SETS.map(|set| {
            let mut all = vec![Vec4::NAN; 3];
            normals(points, triangles, Vec3::Y, &mut all, set);
            all
        });
        assert!(found[0] == found[1] && found[0] == found[2], "the same bits from all sets");
        core::mem::take(&mut found[0])
    }

    fn random(seed: u64) -> impl FnMut() -> f32 {
        let mut random = Random::new(seed);
        move || 0.5 * random.number()
    }

    #[test]
    fn normals_are_sums_of_area_vectors_one_triangle_after_the_other_as_long_as_one() {
        let mut next = random(3);
        for (vertices, faces) in [(3, 1), (5, 7), (8, 8), (40, 70), (100, 203)] {
            let points: Vec<Vec4> =
                (0..vertices).map(|_| Vec4::new(next(), next(), next(), f32::NAN)).collect();
            let mut row = || ((next() + 0.5) * vertices as f32) as u32;
            // Two in a hundred have an index out of range.
            let triangles: Vec<[u32; 3]> = (0..faces)
                .map(|f| if f % 50 == 7 { [row(), u32::MAX, 0] } else { [row(), row(), row()] })
                .collect();
            let mut sums = vec![Vec3::ZERO; vertices];
            for rows in triangles.iter().filter(|rows| rows[1] != u32::MAX) {
                let [a, b, c] = rows.map(|row| points[row as usize].truncate());
                rows.iter().for_each(|&row| sums[row as usize] += (b - a).cross(c - a));
            }
            for (normal, sum) in found(&points, &triangles).into_iter().zip(sums) {
                let length = sum.length();
                let truth = if length > 0.0 { sum / length } else { Vec3::Y };
                assert!(normal.truncate().abs_diff_eq(truth, 3e-7), "{normal} {truth}");
                assert_eq!(normal.w, 0.0);
            }
        }
    }

    #[test]
    fn a_ball_has_normals_that_point_outwards() {
        // An octahedron, anticlockwise from outside.
        let points = [Vec4::X, Vec4::Y, Vec4::Z, -Vec4::X, -Vec4::Y, -Vec4::Z];
        let [x, y, z, u, v, w] = [0, 1, 2, 3, 4, 5];
        let triangles = [
            [x, y, z],
            [y, u, z],
            [u, v, z],
            [v, x, z],
            [y, x, w],
            [u, y, w],
            [v, u, w],
            [x, v, w],
        ];
        for (normal, point) in found(&points, &triangles).into_iter().zip(points) {
            assert!(normal.abs_diff_eq(point, 1e-6), "{normal} {point}");
        }
    }

    #[test]
    fn what_has_no_direction_falls_back_and_what_is_not_finite_stays_with_its_neighbours() {
        let far = Vec4::new(1e30, 0.0, 0.0, 0.0);
        let points = [
            Vec4::ZERO,
            Vec4::X,
            Vec4::Y,
            Vec4::X * 2.0,
            Vec4::NAN,
            far,
            Vec4::Y * 1e-9,
            Vec4::X * 1e-9,
            Vec4::Z,
            Vec4::ONE,
        ];
        // Collinear, a point, with a NaN, too large for `f32`, too small; a good one, and one vertex without triangles.
        let triangles = [[0, 1, 3], [2, 2, 2], [4, 8, 2], [5, 8, 3], [6, 7, 7], [9, 1, 0]];
        let all = found(&points, &triangles);
        assert!(all.iter().all(|n| n.is_finite() && (n.length_squared() - 1.0).abs() < 1e-5));
        assert_eq!(all[4], Vec4::Y);
        assert_eq!(all[6], Vec4::Y);
        let truth = (Vec3::X - Vec3::ONE).cross(-Vec3::ONE).normalize();
        assert!(all[9].truncate().abs_diff_eq(truth, 1e-6));
        assert_eq!(found(&points, &[]), vec![Vec4::Y; points.len()]);
        assert_eq!(found(&[], &triangles), vec![]);
    }
}
