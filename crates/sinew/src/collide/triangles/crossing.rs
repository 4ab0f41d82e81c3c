//! Continuous collision detection: whether a particle passes through a triangle in a substep, or an edge through an edge.
//!
//! # When
//!
//! All corners move linearly from the start of the substep to their current positions. With `u`, `v` two sides of the triangle (or the two edges) and `p` from
//! its first corner to the particle (or from the beginning of one edge to that of the other), each of the form `x₀ + τ Δx`, the four points are coplanar at the
//! roots of the cubic (Provot 1997; Bridson and others 2002)
//!
//! ```text
//! f(τ) = p(τ) · (u(τ) × v(τ))        0 ≤ τ ≤ 1
//! ```
//!
//! In Bernstein form a cubic stays between the least and the greatest of its four coefficients, so that most have no root because all four have the same sign.
//! Between the zeros of its derivative it is monotonic, so that a root is bracketed by signs and found by bisection to full precision. Only a root without a
//! change of sign can be missed, which is a touch and not a crossing.
//!
//! # Where, and to which side
//!
//! At a root the particle has passed if it is within the triangle then (or the edges intersect), with a tolerance that leaves no crack between two triangles at
//! their common edge. It came from the side that it moves away from, relative to the triangle at that place: `n` is the triangle's normal (or the normal of
//! both edges) towards that side.

use glam::DVec3;

use super::super::distance::{foot, has_size, of_lines};

/// Four points at the start of the substep and now: a particle and the corners of a triangle, or the ends of one edge and of another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Four {
    pub(super) from: [DVec3; 4],
    pub(super) to: [DVec3; 4],
    pub(super) edges: bool,
}

/// Contact geometry of two features: weights of the four points, which are positive for the first feature and negative for the second and add up to zero; and
/// the unit normal from the second to the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactShares {
    pub(super) shares: [f64; 4],
    pub(super) normal: DVec3,
}

/// Tolerance beyond the border of a triangle or an edge, as a share of its size: far more than the rounding errors of double precision, and no visible
/// thickness.
const CRACK: f64 = 1e-7;

/// Bisections of the interval of a root: more would not add significant digits to `τ`.
const HALVINGS: u32 = 40;

impl Four {
    /// The first crossing, if they end on the other side: if they passed through each other and back there is none.
    pub(super) fn crossing(&self) -> Option<ContactShares> {
        let (began, ends) = (self.sides(self.from), self.sides(self.to));
        let turned = [ends[0] - began[0], ends[1] - began[1], ends[2] - began[2]];
        let cubic = cubic(began, turned);
        if is_one_sided(cubic) {
            return None;
        }
        let (roots, count) = roots(cubic);
        let mut ways = roots[..count].iter().filter_map(|&time| self.crosses_at(time));
        let first = ways.next()?;
        ways.count().is_multiple_of(2).then_some(first)
    }

    /// Upper bound, squared, of how far any point of one feature can have moved relative to any point of the other: twice the longest displacement relative to
    /// the mean of the four.
    #[inline]
    pub(super) fn longest_way(&self) -> f64 {
        let way = |i: usize| self.to[i] - self.from[i];
        let mean = (way(0) + way(1) + way(2) + way(3)) * 0.25;
        let square = |i: usize| (way(i) - mean).length_squared();
        4.0 * square(0).max(square(1)).max(square(2)).max(square(3))
    }

    /// `p`, `u` and `v`.
    #[inline(always)]
    fn sides(&self, [p, a, b, c]: [DVec3; 4]) -> [DVec3; 3] {
        if self.edges { [b - p, a - p, c - b] } else { [p - a, b - a, c - a] }
    }

    fn crosses_at(&self, time: f64) -> Option<ContactShares> {
        let at = |i: usize| self.from[i].lerp(self.to[i], time);
        let (shares, normal) = self.meet([at(0), at(1), at(2), at(3)], CRACK)?;
        let nearing = normal.dot(gap(shares, self.to) - gap(shares, self.from));
        if nearing == 0.0 {
            return None;
        }
        Some(ContactShares { shares, normal: if nearing > 0.0 { -normal } else { normal } })
    }

    /// The weights of the points along the common normal of the features, if these points lie within them, and the unit normal.
    fn meet(&self, at: [DVec3; 4], slack: f64) -> Option<([f64; 4], DVec3)> {
        let [p, a, b, c] = at;
        let [_, u, v] = self.sides(at);
        let n = u.cross(v);
        let shares = if self.edges {
            let [s, t] = of_lines([p, a], [b, c], slack)?;
            [1.0 - s, s, t - 1.0, -t]
        } else {
            let foot = foot(p, [a, b, c]).filter(|foot| foot.iter().all(|&w| w >= -slack))?;
            let [i, j, k] = foot.map(|w| w.max(0.0));
            let sum = i + j + k;
            [1.0, -i / sum, -j / sum, -k / sum]
        };
        Some((shares, n / n.length()))
    }

    /// The direction from the second to the first for points that coincide at the end of the substep: the normal there, towards the side where they began.
    pub(super) fn side(&self, shares: [f64; 4]) -> Option<DVec3> {
        let [_, u, v] = self.sides(self.to);
        let n = u.cross(v);
        let square = n.length_squared();
        let came = n.dot(gap(shares, self.from));
        if !has_size(square, u, v) || came == 0.0 {
            return None;
        }
        let n = n / square.sqrt();
        Some(if came < 0.0 { -n } else { n })
    }
}

/// The vector from the point of the second feature to that of the first, by their weights.
#[inline]
pub(super) fn gap(shares: [f64; 4], at: [DVec3; 4]) -> DVec3 {
    at[0] * shares[0] + at[1] * shares[1] + at[2] * shares[2] + at[3] * shares[3]
}

/// The coefficients of `f`, from the constant one up.
fn cubic([p, u, v]: [DVec3; 3], [dp, du, dv]: [DVec3; 3]) -> [f64; 4] {
    let (n0, n1, n2) = (u.cross(v), u.cross(dv) + du.cross(v), du.cross(dv));
    [p.dot(n0), p.dot(n1) + dp.dot(n0), p.dot(n2) + dp.dot(n1), dp.dot(n2)]
}

/// Whether it is positive everywhere or negative everywhere from 0 to 1, or NaN.
fn is_one_sided([c0, c1, c2, c3]: [f64; 4]) -> bool {
    let all = [c0, c0 + c1 / 3.0, c0 + (2.0 * c1 + c2) / 3.0, c0 + c1 + c2 + c3];
    !(all.iter().any(|&b| b <= 0.0) && all.iter().any(|&b| b >= 0.0))
}

/// The times from 0 to 1 at which it changes sign, ascending.
///
/// A cubic that begins at zero is on neither side, and has no root there.
fn roots(cubic: [f64; 4]) -> ([f64; 3], usize) {
    let [c0, c1, c2, c3] = cubic;
    let value = |t: f64| c0 + t * (c1 + t * (c2 + t * c3));
    let mut knots = [0.0; 4];
    let mut count = 1;
    // Zeros of the derivative, in the form that avoids cancellation.
    let (a, half, c) = (3.0 * c3, c2, c1);
    let beneath = half * half - a * c;
    if beneath > 0.0 {
        let root = beneath.sqrt();
        let sum = if half < 0.0 { root - half } else { -root - half };
        let (one, other) = (sum / a, c / sum);
        for time in [one.min(other), one.max(other)] {
            if time > 0.0 && time < 1.0 {
                knots[count] = time;
                count += 1;
            }
        }
    }
    knots[count] = 1.0;
    let (mut found, mut number) = ([0.0; 3], 0);
    for pair in knots[..=count].windows(2) {
        let (mut low, mut high) = (pair[0], pair[1]);
        let (at_low, at_high) = (value(low), value(high));
        if at_low == 0.0 || (at_low < 0.0) == (at_high < 0.0) {
            continue;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if (value(middle) < 0.0) == (at_low < 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        found[number] = high;
        number += 1;
    }
    (found, number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_changes_of_sign_are_found_in_their_order() {
        let of = |r: [f64; 3], k: f64| {
            let [a, b, c] = r;
            [-a * b * c * k, (a * b + a * c + b * c) * k, -(a + b + c) * k, k]
        };
        for (wanted, cubic) in [
            (vec![0.2, 0.5, 0.9], of([0.5, 0.9, 0.2], -3.0)),
            (vec![0.25], of([0.25, -2.0, 4.0], 1.0)),
            (vec![], of([1.5, -2.0, 4.0], 1.0)),
            (vec![0.5], [-1.0, 2.0, 0.0, 0.0]),
            (vec![0.25, 0.75], [0.1875, -1.0, 1.0, 0.0]),
            (vec![], [1.0, 0.0, 0.0, 0.0]),
            (vec![], [0.0; 4]),
            (vec![], [f64::NAN; 4]),
        ] {
            let (found, count) = roots(cubic);
            assert_eq!(count, wanted.len(), "{cubic:?}: {found:?}");
            for (one, other) in found.iter().zip(&wanted) {
                assert!((one - other).abs() < 1e-10, "{found:?}");
            }
            assert!(wanted.is_empty() || !is_one_sided(cubic));
        }
    }

    #[test]
    fn a_point_passes_within_a_triangle_and_not_beside_it() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let four = |p: DVec3, q: DVec3, by: DVec3| {
            let [a, b, c] = triangle;
            Four { from: [p, a, b, c], to: [q, a + by, b + by, c + by], edges: false }
        };
        let (up, down) = (DVec3::new(0.2, 0.3, 1.0), DVec3::new(0.2, 0.3, -1.0));
        let way = four(up, down, DVec3::ZERO).crossing().unwrap();
        assert!((way.normal - DVec3::Z).length() < 1e-12);
        assert!(
            (gap(way.shares, [up, triangle[0], triangle[1], triangle[2]]) - DVec3::Z).length()
                < 1e-9
        );
        let way = four(down, up, DVec3::ZERO).crossing().unwrap();
        assert!((way.normal + DVec3::Z).length() < 1e-12, "from the other side");
        // The triangle moves instead; and both move, so that their relative displacement is zero.
        assert!(four(up, up, DVec3::Z * 2.0).crossing().is_some());
        assert!(four(up, down, DVec3::Z * -2.0).crossing().is_none());
        let beside = DVec3::X;
        assert!(four(up + beside, down + beside, DVec3::ZERO).crossing().is_none());
        // Through an edge and a corner: no crack.
        for at in [DVec3::X * 0.5, DVec3::ZERO, DVec3::new(0.5, 0.5, 0.0)] {
            assert!(four(at + DVec3::Z, at - DVec3::Z, DVec3::ZERO).crossing().is_some(), "{at}");
        }
        let flat = Four {
            from: [up, DVec3::ZERO, DVec3::X, DVec3::X],
            to: [down, DVec3::ZERO, DVec3::X, DVec3::X],
            edges: false,
        };
        assert!(flat.crossing().is_none());
    }

    #[test]
    fn an_edge_passes_an_edge() {
        let edge = |z: f64| [DVec3::new(-1.0, 0.0, z), DVec3::new(1.0, 0.0, z)];
        let other = [DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0)];
        let four = |from: f64, to: f64, beside: DVec3| {
            let ([a, b], [c, d], [e, f]) = (edge(from), edge(to), other);
            Four {
                from: [a + beside, b + beside, e, f],
                to: [c + beside, d + beside, e, f],
                edges: true,
            }
        };
        let way = four(0.5, -0.5, DVec3::ZERO).crossing().unwrap();
        assert!((way.normal - DVec3::Z).length() < 1e-12);
        assert!(way.shares.iter().sum::<f64>().abs() < 1e-15);
        let way = four(-0.5, 0.5, DVec3::ZERO).crossing().unwrap();
        assert!((way.normal + DVec3::Z).length() < 1e-12);
        assert!(four(0.5, 0.2, DVec3::ZERO).crossing().is_none());
        assert!(four(0.5, -0.5, DVec3::Y * 1.5).crossing().is_none());
    }
}
