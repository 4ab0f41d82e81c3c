//! A rectangle cut to the outline of another (Sutherland and Hodgman): where the faces of two boxes lie on each other.

use glam::Vec3;

/// A convex polygon: across the reference face in x and y, above it in z, metres. Four cuts of four corners leave eight at most.
pub(super) struct Polygon {
    corners: [Vec3; 8],
    len: usize,
}

impl Polygon {
    /// A rectangle, corner after corner, without what is outside of `-x..=x` and `-y..=y`.
    #[inline(always)]
    pub(super) fn cut([p, q, r, s]: [Vec3; 4], x: f32, y: f32) -> Self {
        let (least, most) = (p.min(q).min(r.min(s)), p.max(q).max(r.max(s)));
        let zero = Vec3::ZERO;
        let mut this = Self { corners: [p, q, r, s, zero, zero, zero, zero], len: 4 };
        if most.x > x {
            this.cut_at(|p| x - p.x);
        }
        if least.x < -x {
            this.cut_at(|p| x + p.x);
        }
        if most.y > y {
            this.cut_at(|p| y - p.y);
        }
        if least.y < -y {
            this.cut_at(|p| y + p.y);
        }
        this
    }

    /// Its corners.
    #[inline(always)]
    pub(super) fn corners(&self) -> &[Vec3] {
        &self.corners[..self.len]
    }

    /// Cuts off where a linear function is negative.
    #[inline(always)]
    fn cut_at(&mut self, inside: impl Fn(Vec3) -> f32) {
        if self.len == 0 {
            return;
        }
        let (before, mut len) = (self.corners, 0);
        let mut p = before[(self.len - 1) & 7];
        let mut at_p = inside(p);
        for &q in &before[..self.len] {
            let at_q = inside(q);
            if (at_p < 0.0) != (at_q < 0.0) {
                // One is negative and the other is not, so that the difference is not zero.
                self.corners[len & 7] = p + (q - p) * (at_p / (at_p - at_q));
                len += 1;
            }
            if at_q >= 0.0 {
                self.corners[len & 7] = q;
                len += 1;
            }
            (p, at_p) = (q, at_q);
        }
        // A ninth, which rounding alone could make, has taken the place of another.
        self.len = len.min(8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygon: &Polygon) -> f32 {
        let c = polygon.corners();
        (0..c.len()).map(|i| 0.5 * c[i].truncate().perp_dot(c[(i + 1) % c.len()].truncate())).sum()
    }

    #[test]
    fn a_square_across_the_corners_of_another_becomes_an_octagon() {
        let corners = [Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y].map(|p| p * 1.2);
        let polygon = Polygon::cut(corners, 1.0, 1.0);
        assert_eq!(polygon.corners().len(), 8);
        // 2 * 1.2² less four triangles of 0.2².
        assert!((area(&polygon) - (2.88 - 0.16)).abs() < 1e-5, "{}", area(&polygon));
    }

    #[test]
    fn what_is_beside_leaves_nothing_and_what_is_inside_stays() {
        let square = [
            Vec3::ONE,
            Vec3::new(-1.0, 1.0, 1.0),
            Vec3::new(-1.0, -1.0, 1.0),
            Vec3::new(1.0, -1.0, 1.0),
        ];
        let beside = Polygon::cut(square.map(|p| p + Vec3::X * 5.0), 2.0, 2.0);
        assert!(beside.corners().is_empty());
        let inside = Polygon::cut(square, 1.0, 1.0);
        assert_eq!(inside.corners(), square);
    }
}
