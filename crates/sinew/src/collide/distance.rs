//! Nearest points of a point and a triangle and of two segments, as weights of the corners.
//!
//! In double precision, in which the single-precision corners and their differences are exact: nearly flat triangles and nearly parallel segments stay accurate
//! without special care.

use glam::DVec3;

/// Below this share of the product of the squared sides, the square of a triangle's area (or of the sine of the angle between two directions) counts as zero.
pub(super) const FLAT: f64 = 1e-14;

/// The weights of a triangle's corners at its point nearest to `p`: they add up to one, and none is negative. A triangle without area is treated as its sides.
///
/// With the sides `u` and `v` from the first corner, `d` from there to the point, and `n = u × v`, the foot of the perpendicular has the weights `(d × v)·n/n²`
/// and `(u × d)·n/n²` of the other two corners. Where one of the three weights is negative, the point is beyond the side opposite that corner, and the nearest
/// point is on that side; if two are, on the nearer of the two sides.
#[inline]
pub(super) fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let foot = foot(p, [a, b, c]).unwrap_or([-1.0; 3]);
    if foot.iter().all(|&weight| weight >= 0.0) {
        return foot;
    }
    let corners = [a, b, c];
    let (mut least, mut nearest) = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for (from, to, other) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        if foot[other] >= 0.0 {
            continue;
        }
        let ends = [corners[from], corners[to]];
        let along = to_segment(p, ends);
        let distance = (p - ends[0] - (ends[1] - ends[0]) * along).length_squared();
        if distance < least {
            least = distance;
            (nearest[from], nearest[to], nearest[other]) = (1.0 - along, along, 0.0);
        }
    }
    nearest
}

/// The weights of the corners at the foot of the perpendicular from a point to the plane of a triangle; `None` without area.
#[inline]
pub(super) fn foot(p: DVec3, [a, b, c]: [DVec3; 3]) -> Option<[f64; 3]> {
    let (u, v, d) = (b - a, c - a, p - a);
    let n = u.cross(v);
    let square = n.length_squared();
    if !has_size(square, u, v) {
        return None;
    }
    let n = n / square;
    let (of_b, of_c) = (d.cross(v).dot(n), u.cross(d).dot(n));
    Some([1.0 - of_b - of_c, of_b, of_c])
}

/// Whether the square of the cross product of two vectors exceeds rounding errors.
#[inline]
pub(super) fn has_size(square: f64, u: DVec3, v: DVec3) -> bool {
    square > FLAT * u.length_squared() * v.length_squared()
}

/// Place of a segment's point nearest to `p` along it, 0 to 1.
#[inline]
pub(super) fn to_segment(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let square = along.length_squared();
    if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// Places of the nearest points of the lines through two segments, 0 to 1 along each; `None` where one is outside its segment by more than `slack`, or where
/// the segments are parallel.
///
/// The connection `r + t v - s u` (`r` from the first's beginning to the second's) is perpendicular to both directions `u` and `v`, so with `n = u × v` the
/// places are `s = (r × v)·n/n²` and `t = (r × u)·n/n²`.
#[inline]
pub(super) fn of_lines([a, b]: [DVec3; 2], [c, d]: [DVec3; 2], slack: f64) -> Option<[f64; 2]> {
    let (u, v, r) = (b - a, d - c, c - a);
    let n = u.cross(v);
    let square = n.length_squared();
    if !has_size(square, u, v) {
        return None;
    }
    let n = n / square;
    let (s, t) = (r.cross(v).dot(n), r.cross(u).dot(n));
    let within = -slack..=1.0 + slack;
    (within.contains(&s) && within.contains(&t)).then(|| [s.clamp(0.0, 1.0), t.clamp(0.0, 1.0)])
}

/// The least distance of two segments.
#[inline]
pub(super) fn of_segments(one: [DVec3; 2], other: [DVec3; 2]) -> f64 {
    let at = |[a, b]: [DVec3; 2], along: f64| a.lerp(b, along);
    if let Some([s, t]) = of_lines(one, other, 0.0) {
        return (at(one, s) - at(other, t)).length();
    }
    let mut least = f64::INFINITY;
    for (points, segment) in [(one, other), (other, one)] {
        for p in points {
            least = least.min((p - at(segment, to_segment(p, segment))).length_squared());
        }
    }
    least.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    fn at([a, b, c]: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
        a * weights[0] + b * weights[1] + c * weights[2]
    }

    #[test]
    fn no_other_point_of_a_triangle_is_nearer() {
        let mut random = Random::new(5);
        for round in 0..300 {
            let mut corners = [0; 3].map(|_| random.vector().as_dvec3());
            if round % 5 == 0 {
                corners[2] = corners[0].lerp(corners[1], 0.3);
            }
            let p = random.vector().as_dvec3() * 2.0;
            let weights = to_triangle(p, corners);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
            let least = (p - at(corners, weights)).length();
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    let other = (p - at(corners, [1.0 - u - v, u, v])).length();
                    assert!(least <= other + 1e-7, "{least} {other}");
                }
            }
        }
    }

    #[test]
    fn no_other_points_of_two_segments_are_nearer() {
        let mut random = Random::new(6);
        for _ in 0..300 {
            let [a, b, c, d] = [0; 4].map(|_| random.vector().as_dvec3());
            let least = of_segments([a, b], [c, d]);
            for i in 0..=30 {
                for j in 0..=30 {
                    let (s, t) = (f64::from(i) / 30.0, f64::from(j) / 30.0);
                    assert!(least <= (a.lerp(b, s) - c.lerp(d, t)).length() + 1e-9);
                }
            }
        }
        let (x, y) = (DVec3::X, DVec3::Y);
        assert_eq!(of_segments([DVec3::ZERO, x], [y, y + x]), 1.0, "parallel ones");
        assert_eq!(of_segments([x, x], [y * 2.0 + x, y * 2.0 + x]), 2.0, "points");
    }
}
