//! The area of a patch, eight triangles at a time.

use glam::{Vec3, Vec4};

use crate::constraints::area::area_wide;
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, Work, with};

/// The area of some triangles; its gradients are added to `gradients`. Both are summed up in the order of the triangles, areas in f64, so that there
/// is one result, whatever the instructions are.
///
/// A volume is not worth it: adding up its gradients takes as long as all of it does one by one.
pub(super) fn area_of(
    triangles: &[[u32; 3]],
    now: &[Vec4],
    gradients: &mut [Vec3],
    instructions: InstructionSet,
) -> f64 {
    with(instructions, AddUp { triangles, now, gradients })
}

struct AddUp<'a> {
    triangles: &'a [[u32; 3]],
    now: &'a [Vec4],
    gradients: &'a mut [Vec3],
}

impl Work for AddUp<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let Self { triangles, now, gradients } = self;
        let mut sum = 0.0;
        for some in triangles.chunks(LANES) {
            // Where there are fewer than eight, the first stands there again, and is not added again.
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::area::area;
    use crate::constraints::checks::Random;

    /// 50 particles, two of them in one place, and 83 triangles between them.
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
