//! A triangle: nearest point, and crossing of a segment.

use glam::{DVec3, Vec3};

/// Three vertices, metres, and the unit normal, about which they are counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Triangle {
    pub(super) corners: [Vec3; 3],
    pub(super) normal: Vec3,
}

/// The feature of a triangle that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    Face,
    /// From the vertex with this index to the next.
    Edge(u8),
    Corner(u8),
}

/// The nearest point of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosestPoint {
    pub(super) point: Vec3,
    pub(super) feature: Feature,
    /// Square of the distance, m².
    pub(super) square: f32,
}

/// Where a segment crosses a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Position along the segment, 0 to 1.
    pub(super) share: f64,
    /// Whether it comes from the side that the normal points to.
    pub(super) front: bool,
}

impl Triangle {
    /// A triangle; its normal is zero if it has no area.
    pub(super) fn new(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let [a, b, c] = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        Self { corners, normal }
    }

    /// Bounding box.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        let [a, b, c] = self.corners;
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// The point nearest to `p`, by the region that the projection of `p` lies in (C. Ericson, *Real-Time Collision Detection*, 5.1.5): beyond a vertex if it
    /// is behind both edges from there; beside an edge if the barycentric coordinate across it is negative; else above the face.
    #[inline]
    pub(super) fn closest(&self, p: Vec3) -> ClosestPoint {
        let [a, b, c] = self.corners;
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let at = |point: Vec3, feature| ClosestPoint {
            point,
            feature,
            square: (p - point).length_squared(),
        };
        let (d1, d2) = (ab.dot(ap), ac.dot(ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return at(a, Feature::Corner(0));
        }
        let bp = p - b;
        let (d3, d4) = (ab.dot(bp), ac.dot(bp));
        if d3 >= 0.0 && d4 <= d3 {
            return at(b, Feature::Corner(1));
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return at(a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
        }
        let cp = p - c;
        let (d5, d6) = (ab.dot(cp), ac.dot(cp));
        if d6 >= 0.0 && d5 <= d6 {
            return at(c, Feature::Corner(2));
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return at(a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
        }
        let va = d3 * d6 - d5 * d4;
        let (along, back) = (d4 - d3, d5 - d6);
        if va <= 0.0 && along >= 0.0 && back >= 0.0 {
            return at(b + (c - b) * (along / (along + back)), Feature::Edge(1));
        }
        // The plane is more accurate than the barycentric coordinates.
        let height = self.normal.dot(ap);
        ClosestPoint {
            point: p - self.normal * height,
            feature: Feature::Face,
            square: height * height,
        }
    }

    /// Where the segment between two points crosses it, from the front only or from either side. A segment that ends on it crosses it, unless only the front
    /// counts.
    ///
    /// Computed in `f64` by the volumes that the segment spans with each edge: two triangles at a common edge compute the same volume with opposite signs, so
    /// that there is no gap between them to slip through.
    pub(super) fn crossing(&self, from: Vec3, to: Vec3, front_only: bool) -> Option<Crossing> {
        let start = from.as_dvec3();
        let [a, b, c] = self.corners.map(|corner| corner.as_dvec3() - start);
        let segment = to.as_dvec3() - start;
        let normal = (b - a).cross(c - a);
        let (before, after) = (-normal.dot(a), normal.dot(segment - a));
        let down =
            if front_only { before >= 0.0 && after < 0.0 } else { before > 0.0 && after <= 0.0 };
        let up = !front_only && before < 0.0 && after >= 0.0;
        if !(down || up) {
            return None;
        }
        let volume = |a: DVec3, b: DVec3| segment.dot(a.cross(b));
        let volumes = [volume(a, b), volume(b, c), volume(c, a)];
        let through = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
        through.then_some(Crossing { share: before / (before - after), front: down })
    }
}
