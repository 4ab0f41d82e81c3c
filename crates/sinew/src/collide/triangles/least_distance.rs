//! Lower bounds of the distance of a particle and a triangle, or of two edges, in single precision, eight at a time.
//!
//! They exclude distant candidates, which most are, and never exceed the exact distance, whatever the rounding. For a particle and a triangle the bound is the
//! distance; for two edges it is that of their lines (or parallels), combined with how far the nearest point of either line is beyond the end of its edge; each
//! less [`ROUNDED`] of the lengths involved. The derivations are in [`distance`](super::super::distance).

use crate::lanes::{Number, Vector};

/// Where the squared sine of the angle between two directions is less than `FLAT`, a triangle counts as its edges, and two edges as parallel. The error of
/// either is below [`ROUNDED`], and so is that of the normal, which rounding turns by `2⁻²³/√FLAT` there.
const FLAT: f32 = 1e-6;

/// Below this product of the squares of two sides, m⁴, the square of their cross product underflows in `f32`.
const TINY: f32 = 1e-30;

/// Greatest error of a distance, as a share of the longest distance between corners.
const ROUNDED: f32 = 1e-3;

/// Of a particle and the corners of a triangle, metres; NaN if one of them is.
#[inline(always)]
pub(super) fn to_triangle<N: Number>([p, a, b, c]: [Vector<N>; 4]) -> N {
    let (u, v, d) = (b - a, c - a, p - a);
    let (uu, vv, dd) = (u.length_squared(), v.length_squared(), d.length_squared());
    let n = u.cross(v);
    let square = n.length_squared();
    let (of_b, of_c) = (d.cross(v).dot(n), u.cross(d).dot(n));
    let zero = N::zero();
    let within = zero.le(of_b).and(zero.le(of_c)).and((of_b + of_c).le(square));
    let above = d.dot(n);
    let side = c - b;
    let edges = to_segment(d, u, uu).min(to_segment(d, v, vv));
    let edges = edges.min(to_segment(p - b, side, side.length_squared()));
    let area = uu * vv;
    let is_flat = square.le(area * N::splat(FLAT)).or(area.le(N::splat(TINY)));
    let edges = edges.sqrt();
    let plane = (above / square.sqrt()).abs();
    let nearest = is_flat.select(edges, within.select(plane, edges));
    nearest - dd.max(uu).max(vv).sqrt() * N::splat(ROUNDED)
}

/// The squared distance of a point and a segment, both relative to the segment's beginning; `uu` is the squared length of the segment.
#[inline(always)]
fn to_segment<N: Number>(d: Vector<N>, u: Vector<N>, uu: N) -> N {
    // Clamped to the segment; 0 for one without length, for which the quotient is NaN.
    let share = (d.dot(u) / uu).max(N::zero()).min(N::splat(1.0));
    (d - u * share).length_squared()
}

/// Of two edges, metres: from the first point to the second, and from the third to the fourth.
#[inline(always)]
pub(super) fn of_edges<N: Number>([p, a, b, c]: [Vector<N>; 4]) -> N {
    let (u, v, r) = (a - p, c - b, b - p);
    let (uu, vv, rr) = (u.length_squared(), v.length_squared(), r.length_squared());
    let n = u.cross(v);
    let square = n.length_squared();
    let zero = N::zero();
    // How far beyond the ends, as a share of the edge. The cross product is divided first and squared afterwards: squares of small edges are still in the range
    // of `f32`, higher powers are not.
    let beyond = |along: N| (zero - along).max(along - N::splat(1.0)).max(zero);
    let s = beyond(r.cross(v).dot(n) / square);
    let t = beyond(r.cross(u).dot(n) / square);
    let apart = r.dot(n) / square.sqrt();
    let lines = apart * apart + (s * s * (square / vv)).max(t * t * (square / uu));
    let parallels = r.cross(u).length_squared() / uu;
    let area = uu * vv;
    let is_parallel = square.le(area * N::splat(FLAT));
    let nearest = is_parallel.select(parallels, lines);
    let nearest = area.le(N::splat(TINY)).select(zero, nearest);
    nearest.sqrt() - rr.max(uu).max(vv).sqrt() * N::splat(ROUNDED)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::super::distance;
    use super::*;
    use crate::lanes::Vector;
    use crate::test_random::Random;

    fn least(at: [[f32; 3]; 4], edges: bool) -> f32 {
        let [p, a, b, c] = at.map(|[x, y, z]| Vector::new(x, y, z));
        if edges { of_edges([p, a, b, c]) } else { to_triangle([p, a, b, c]) }
    }

    fn exact(at: [[f32; 3]; 4], edges: bool) -> f64 {
        let [p, a, b, c] = at.map(|at| DVec3::from(at.map(f64::from)));
        if edges {
            return distance::of_segments([p, a], [b, c]);
        }
        let [i, j, k] = distance::to_triangle(p, [a, b, c]);
        (p - (a * i + b * j + c * k)).length()
    }

    /// Well-shaped sets, needles, and nearly flat, nearly parallel and degenerate ones.
    fn shapes() -> impl Iterator<Item = [[f32; 3]; 4]> {
        let mut random = Random::new(7);
        (0..200_000).map(move |round| {
            let squeeze = [1.0, 1e-2, 1e-4, 1e-7, 0.0][round % 5];
            let size = [1.0, 0.03, 20.0][round % 3];
            let mut at = [0; 4].map(|_| [0; 3].map(|_| size * random.number()));
            match round % 4 {
                0 => at.iter_mut().for_each(|at| at[1] *= squeeze),
                1 => at[3] = core::array::from_fn(|k| at[2][k] + squeeze * (at[3][k] - at[2][k])),
                2 => {
                    // The second edge along the first.
                    let along: [f32; 3] = core::array::from_fn(|k| at[1][k] - at[0][k]);
                    let off = at[3];
                    at[3] = core::array::from_fn(|k| at[2][k] + along[k] + squeeze * off[k]);
                }
                _ => (),
            }
            at
        })
    }

    #[test]
    fn nothing_is_nearer_than_it_says() {
        for at in shapes() {
            for edges in [false, true] {
                let (least, exact) = (least(at, edges), exact(at, edges));
                let holds = least.is_nan() || f64::from(least) <= exact;
                assert!(holds, "{least} of {exact}: {at:?} {edges}");
            }
        }
    }

    #[test]
    fn what_is_far_is_known_to_be() {
        // For well-shaped sets the bound is tight: within rounding for triangles, less so for edges whose nearest points are their ends.
        let (mut count, mut close) = (0, [0; 2]);
        for at in shapes().skip(3).step_by(20) {
            for edges in [false, true] {
                let (least, exact) = (least(at, edges), exact(at, edges));
                close[usize::from(edges)] += u32::from(f64::from(least) > 0.9 * exact - 0.01);
            }
            count += 1;
        }
        assert!(close[0] > count * 99 / 100 && close[1] > count / 2, "{close:?} of {count}");
    }

    #[test]
    fn what_is_no_number_is_not_far() {
        for bad in 0..4 {
            let mut at = [[0.0, 0.0, 9.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.5]];
            assert!(least(at, false) > 5.0 && least(at, true) > 0.0);
            at[bad] = [f32::NAN; 3];
            assert!(least(at, false).is_nan() && least(at, true).is_nan(), "{bad}");
        }
    }
}
