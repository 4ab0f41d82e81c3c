//! Capsule and box. The capsule's axis is a box without width, so the separating axes are the box's normals and the products of its edges with the capsule's
//! axis.

use glam::Vec3;

use super::features::CROSSING_SINE;
use super::round::{limit, rim};
use super::{BIAS, Frame, Manifold, Point};

/// A capsule `[radius, half height]` and a box, metres. Two points where the capsule lies along a face or an edge.
pub(super) fn collide(
    [radius, half_height]: [f32; 2],
    half_size: Vec3,
    a_in_b: &Frame,
    reach: f32,
) -> Option<Manifold> {
    let rod = Rod {
        centre: a_in_b.translation,
        axis: a_in_b.rotation.y_axis,
        half: half_height,
        size: half_size,
    };
    let Separation { mut normal, apart, above } = rod.separate(radius + reach)?;
    let (mut along, mut on_box) = (0.0, Vec3::ZERO);
    let outside = apart > rod.rounding();
    if above {
        along = rod.lower(normal);
        on_box = rod.at(along).clamp(-rod.size, rod.size);
    } else if outside {
        (along, on_box) = rod.nearest();
        let between = rod.at(along) - on_box;
        let length = between.length();
        if length > radius + reach {
            return None;
        }
        normal = between / length.max(f32::MIN_POSITIVE);
    }
    let point = |along: f32, q: Vec3| {
        let p = rod.at(along) + rim(rod.axis, along, half_height, -normal) * radius;
        Point { on_a: a_in_b.local(p), on_b: q, distance: (p - q).dot(normal) }
    };
    let within = |along: f32, q: Vec3| Some(point(along, q)).filter(|p| p.distance <= reach);
    let mut manifold = Manifold::new(normal);
    // Nearly parallel to the surface, the second point is not far off.
    let parallel = rod.axis.dot(normal).abs() < CROSSING_SINE;
    let line = if parallel { rod.line(normal) } else { None };
    for (along, q) in line.into_iter().flatten() {
        if let Some(point) = within(along, q) {
            manifold.push(point);
        }
    }
    if manifold.len == 0 {
        let (along, q) = if outside { (along, on_box) } else { rod.deepest(normal) };
        if let Some(point) = within(along, q) {
            manifold.push(point);
        }
    }
    manifold.slide_limit = rod.slide_limit(&manifold);
    (manifold.len > 0).then_some(manifold)
}

/// The direction in which an axis and a box are farthest apart, or overlap least, out of the box, and the separation, metres.
struct Separation {
    normal: Vec3,
    apart: f32,
    /// Whether the whole axis is above that face, so that the nearest point of the box is on it.
    above: bool,
}

/// A capsule's axis in the coordinates of a box.
struct Rod {
    centre: Vec3,
    axis: Vec3,
    half: f32,
    /// Half size of the box.
    size: Vec3,
}

impl Rod {
    /// A point of the axis.
    fn at(&self, along: f32) -> Vec3 {
        self.centre + self.axis * along
    }

    /// A separation no greater than this, metres, does not determine the nearest points.
    fn rounding(&self) -> f32 {
        1e-5 * (self.size.max_element() + self.half)
    }

    /// The direction of greatest separation of axis and box; `None` if they are further apart than `reach`.
    fn separate(&self, reach: f32) -> Option<Separation> {
        let Self { centre, axis, half, size } = self;
        let (mut best, mut most) = (Vec3::Y, f32::NEG_INFINITY);
        let beyond = (centre.abs() - size - axis.abs() * *half).to_array();
        let (mut face, sides) = (1, centre.to_array());
        for (i, apart) in beyond.into_iter().enumerate() {
            if apart > most {
                (face, most) = (i, apart);
            }
        }
        if most > f32::NEG_INFINITY {
            best = Vec3::AXES[face] * 1.0_f32.copysign(sides[face]);
        }
        // Most distant pairs are already distant along a face normal.
        if most > reach {
            return None;
        }
        // If the whole axis is above one face, no edge is nearer.
        let within = (centre.abs() + axis.abs() * *half).cmple(*size);
        if most > self.rounding() && within.bitmask().count_ones() == 2 {
            return Some(Separation { normal: best, apart: most, above: true });
        }
        let mut needed = most + BIAS.1 * size.min_element() + BIAS.0 * most.abs();
        for edge in Vec3::AXES {
            let product = edge.cross(*axis);
            let length = product.length();
            if length < 1e-3 {
                continue;
            }
            let product = product / length;
            let along = centre.dot(product);
            let apart = along.abs() - size.dot(product.abs());
            if apart > needed {
                (best, most) = (if along < 0.0 { -product } else { product }, apart);
                needed = apart;
            }
        }
        let found = Separation { normal: best, apart: most, above: false };
        (most <= reach && centre.is_finite()).then_some(found)
    }

    /// The end of the axis that is lower along `up`.
    fn lower(&self, up: Vec3) -> f32 {
        if self.axis.dot(up) < 0.0 { self.half } else { -self.half }
    }

    /// The nearest points of an axis and a box that do not overlap: a place along the axis, and a point of the box.
    ///
    /// Either one of them is an end of the axis or a corner of the box, or they lie on the axis and one of the twelve edges.
    fn nearest(&self) -> (f32, Vec3) {
        let Self { centre, axis, half, size } = self;
        let (mut least, mut best) = (f32::INFINITY, (0.0, Vec3::ZERO));
        let mut take = |along: f32, q: Vec3| {
            let squared = (self.at(along) - q).length_squared();
            if squared < least {
                (least, best) = (squared, (along, q));
            }
        };
        for along in [-half, *half] {
            take(along, self.at(along).clamp(-*size, *size));
        }
        // An edge can only be nearest to a part of the axis that extends beyond both sides that join there; this excludes most edges.
        let slack = 1e-3 * (size.max_element() + half);
        let farthest = axis.abs() * *half;
        let below = (farthest - centre).cmpge(size - slack);
        let above = (farthest + centre).cmpge(size - slack);
        let comes_beyond = [below, above].map(|side| [side.test(0), side.test(1), side.test(2)]);
        // Arrays, because indexing the components of a vector costs more here.
        let (middle, size, slopes) = (centre.to_array(), size.to_array(), axis.to_array());
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let square = 1.0 - slopes[i] * slopes[i];
            for (first, second) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                if !(comes_beyond[first][j] && comes_beyond[second][k]) {
                    continue;
                }
                let side = |which: usize, of: f32| if which == 0 { -of } else { of };
                let mut q = [0.0; 3];
                (q[j], q[k]) = (side(first, size[j]), side(second, size[k]));
                let along = (*centre - Vec3::from(q)).dot(*axis);
                // Where they are parallel any place will do: ends and corners are compared too.
                let s = if square > 1e-6 { (middle[i] - slopes[i] * along) / square } else { 0.0 };
                let u = limit(slopes[i] * limit(s, size[i]) - along, *half);
                q[i] = limit(middle[i] + u * slopes[i], size[i]);
                take(u, q.into());
            }
        }
        (best.0, best.1)
    }

    /// The part of the axis that lies above the face or edge that points along `normal`: the two ends of it, each with the box's surface point.
    fn line(&self, normal: Vec3) -> Option<[(f32, Vec3); 2]> {
        let half = self.half;
        let (centre, axis) = (self.centre.to_array(), self.axis.to_array());
        let (size, normal) = (self.size.to_array(), normal.to_array());
        let (mut from, mut to) = (-half, half);
        for i in 0..3 {
            // No limit across the surface.
            if normal[i].abs() > 0.1 {
                continue;
            }
            if axis[i].abs() > 1e-6 {
                let end = |side: f32| (side - centre[i]) / axis[i];
                let ends = [end(-size[i]), end(size[i])];
                from = from.max(ends[0].min(ends[1]));
                to = to.min(ends[0].max(ends[1]));
            } else if centre[i].abs() > size[i] {
                return None;
            }
        }
        // Less than a hundredth of the half length counts as a point.
        if to - from < 0.01 * half {
            return None;
        }
        // Moved out onto the sides that point along the normal.
        let end = |along: f32| {
            let mut q = self.at(along).clamp(-self.size, self.size).to_array();
            for i in 0..3 {
                if normal[i].abs() > 0.1 {
                    q[i] = size[i].copysign(normal[i]);
                }
            }
            (along, Vec3::from(q))
        };
        Some([end(from), end(to)])
    }

    /// Least distance of points on a face to the rim of that face, metres; 0 on edges and corners.
    fn slide_limit(&self, manifold: &Manifold) -> f32 {
        let across = manifold.normal.cmpeq(Vec3::ZERO);
        if across.bitmask().count_ones() < 2 {
            return 0.0;
        }
        let least = |limit: f32, point: &Point| {
            let inside = self.size - point.on_b.abs();
            limit.min(Vec3::select(across, inside, Vec3::MAX).min_element())
        };
        manifold.points().iter().fold(f32::INFINITY, least)
    }

    /// The deepest place of an axis that overlaps the box, along a direction out of it, and the surface point there.
    fn deepest(&self, normal: Vec3) -> (f32, Vec3) {
        let Self { axis, size, .. } = self;
        let along = if axis.dot(normal).abs() > 1e-3 { self.lower(normal) } else { 0.0 };
        let p = self.at(along);
        // On the plane of the face or edge that points that way.
        let out = size.dot(normal.abs()) - p.dot(normal);
        (along, p + normal * out)
    }
}
