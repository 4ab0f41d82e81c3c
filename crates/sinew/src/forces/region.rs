//! The region in which a field acts, such as a wind in a tunnel or a fluid in a basin. All fields share this type, so they fade alike.
//!
//! A shape defines how deep inside it a point is, in metres. The field's share at the point is `3t² - 2t³` with `t = depth/fade`, from 0 at the shape's surface
//! to 1 at `fade` metres inside. Its slope is zero at both ends, so a field with a fade switches nothing on abruptly. Without a fade (0, the default) it ends
//! abruptly, like a wall.

use glam::{Quat, Vec3};

use crate::particles::Particles;
use crate::pose::turned;

/// Where a field acts, and how it fades at the boundary. Default: everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Region {
    /// The shape that it fills.
    pub extent: Extent,
    /// Distance inward from the surface, metres, over which the field grows from zero to full strength. Default 0: abruptly.
    ///
    /// A shape thinner than twice this reaches full strength nowhere.
    pub fade: f32,
}

/// A shape in the world, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Extent {
    /// The whole world.
    #[default]
    Everywhere,
    /// The half-space of points with `up · x < level`.
    Below {
        /// Unit normal of the boundary, pointing out of the region.
        up: Vec3,
        /// `up · x` of the points on the boundary, metres.
        level: f32,
    },
    /// A box.
    Box {
        /// Its centre, metres.
        centre: Vec3,
        /// Lengths of its edges, metres, along its own axes.
        size: Vec3,
        /// Orientation of its axes; a unit quaternion.
        rotation: Quat,
    },
    /// A ball.
    Sphere {
        /// Its centre, metres.
        centre: Vec3,
        /// Its radius, metres.
        radius: f32,
    },
    /// A cylinder with flat ends.
    Cylinder {
        /// Centre of one end, metres.
        a: Vec3,
        /// Centre of the other end, metres; must differ from `a`.
        b: Vec3,
        /// Its radius, metres.
        radius: f32,
    },
    /// All points within a radius of the segment from `a` to `b`: a cylinder with round ends. A ball if the two coincide.
    Capsule {
        /// One end of the segment, metres.
        a: Vec3,
        /// Its other end, metres.
        b: Vec3,
        /// The radius, metres.
        radius: f32,
    },
}

impl Region {
    /// The whole world.
    pub const EVERYWHERE: Self = Self { extent: Extent::Everywhere, fade: 0.0 };

    /// An axis-aligned box, from its centre and the lengths of its edges in metres. Without a fade.
    pub fn boxed(centre: Vec3, size: Vec3) -> Self {
        Extent::Box { centre, size, rotation: Quat::IDENTITY }.into()
    }

    /// A ball, from its centre and its radius in metres. Without a fade.
    pub fn sphere(centre: Vec3, radius: f32) -> Self {
        Extent::Sphere { centre, radius }.into()
    }

    /// The same region, fading in over `fade` metres from its surface inwards.
    pub fn with_fade(self, fade: f32) -> Self {
        Self { fade, ..self }
    }

    /// Whether every number is finite and in range. A field in an invalid region acts nowhere.
    pub fn is_valid(&self) -> bool {
        self.fade.is_finite() && self.fade >= 0.0 && self.extent.is_valid()
    }

    /// Whether a point, in world space and metres, lies inside or on the surface.
    pub fn contains(&self, point: Vec3) -> bool {
        self.extent.depth(WorldPoint::at(point)) >= 0.0
    }

    /// The field's share at a point in world space, 0 to 1.
    pub fn share(&self, point: Vec3) -> f32 {
        self.share_at(WorldPoint::at(point))
    }

    /// The field's share at particle `i`, 0 to 1; uses the particle's own origin, so it is accurate far from the world's origin.
    pub fn share_of(&self, particles: &Particles, i: usize) -> f32 {
        self.share_at(WorldPoint::of(particles, i))
    }

    /// The field's share at a place, 0 to 1.
    #[inline]
    pub(crate) fn share_at(&self, place: WorldPoint) -> f32 {
        if self.extent == Extent::Everywhere {
            return 1.0;
        }
        let depth = self.extent.depth(place);
        // Written so that a NaN is outside.
        if depth >= self.fade {
            1.0
        } else if depth > 0.0 {
            let t = depth / self.fade;
            t * t * (3.0 - 2.0 * t)
        } else {
            0.0
        }
    }
}

impl From<Extent> for Region {
    fn from(extent: Extent) -> Self {
        Self { extent, fade: 0.0 }
    }
}

impl Extent {
    fn is_valid(&self) -> bool {
        let long = |x: f32| x.is_finite() && x > 0.0;
        match *self {
            Self::Everywhere => true,
            Self::Below { up, level } => is_unit(up.length_squared()) && level.is_finite(),
            Self::Box { centre, size, rotation: r } => {
                let squared = r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w;
                centre.is_finite() && size.to_array().into_iter().all(long) && is_unit(squared)
            }
            Self::Sphere { centre, radius } => centre.is_finite() && long(radius),
            Self::Cylinder { a, b, radius } => {
                a.is_finite() && b.is_finite() && long(a.distance(b)) && long(radius)
            }
            Self::Capsule { a, b, radius } => {
                a.is_finite() && b.is_finite() && a.distance(b).is_finite() && long(radius)
            }
        }
    }

    /// An axis-aligned box that contains the shape, with a margin for rounding: its lowest and its highest corner, metres.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let about = |low: Vec3, high: Vec3| {
            let room = low.abs().max(high.abs()) * 1e-6;
            (low - room, high + room)
        };
        match *self {
            Self::Everywhere | Self::Below { .. } => (Vec3::NEG_INFINITY, Vec3::INFINITY),
            Self::Box { centre, size, rotation } => {
                // Half extents of the box along each world axis.
                let half = Vec3::AXES.map(|axis| turned(rotation.conjugate(), axis));
                let reach = half.map(|axis| (axis.abs() * size).element_sum() * 0.5);
                let reach = Vec3::from_array(reach);
                about(centre - reach, centre + reach)
            }
            Self::Sphere { centre, radius } => about(centre - radius, centre + radius),
            // A cylinder is contained in the box of its capsule.
            Self::Cylinder { a, b, radius } | Self::Capsule { a, b, radius } => {
                about(a.min(b) - radius, a.max(b) + radius)
            }
        }
    }

    /// Depth of a place inside the surface, metres; negative outside, where only the sign is meaningful.
    fn depth(&self, place: WorldPoint) -> f32 {
        match *self {
            Self::Everywhere => f32::INFINITY,
            Self::Below { up, level } => -up.dot(place.relative_to(up * level)),
            Self::Box { centre, size, rotation } => {
                let margin =
                    0.5 * size - turned(rotation.conjugate(), place.relative_to(centre)).abs();
                // In scalars, because the result of `min_element` is unspecified for NaN.
                margin.x.min(margin.y).min(margin.z)
            }
            Self::Sphere { centre, radius } => radius - place.relative_to(centre).length(),
            Self::Cylinder { a, b, radius } => {
                let (axis, from) = (b - a, place.relative_to(a));
                let length = axis.length();
                let along = axis.dot(from) / length;
                let across = (from - axis * (along / length)).length();
                (radius - across).min(along).min(length - along)
            }
            Self::Capsule { a, b, radius } => {
                let (axis, from) = (b - a, place.relative_to(a));
                let squared = axis.length_squared();
                let t = if squared > 0.0 { axis.dot(from) / squared } else { 0.0 };
                radius - (from - axis * t.clamp(0.0, 1.0)).length()
            }
        }
    }
}

fn is_unit(squared: f32) -> bool {
    // Tolerates the rounding of a quaternion or a normal that has been rotated a thousand times.
    (squared - 1.0).abs() < 1e-3
}

/// A point in world space with an origin of its own for precision, as particles have (see [`particles`](crate::particles)).
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorldPoint {
    origin: Vec3,
    local: Vec3,
}

impl WorldPoint {
    /// A point in world space, metres.
    pub(crate) fn at(point: Vec3) -> Self {
        Self { origin: point, local: Vec3::ZERO }
    }

    /// The position of particle `i`.
    #[inline]
    pub(crate) fn of(particles: &Particles, i: usize) -> Self {
        Self { origin: particles.origin[i], local: particles.position[i].truncate() }
    }

    /// The centroid of three particles.
    #[inline]
    pub(crate) fn middle(particles: &Particles, [a, b, c]: [usize; 3]) -> Self {
        let aside = particles.separation(b, a) + particles.separation(c, a);
        let first = Self::of(particles, a);
        Self { local: first.local + aside * (1.0 / 3.0), ..first }
    }

    /// The place displaced by `by`, metres.
    #[inline]
    pub(crate) fn moved(self, by: Vec3) -> Self {
        Self { local: self.local + by, ..self }
    }

    /// This place minus a point in world space, metres.
    #[inline]
    pub(crate) fn relative_to(self, point: Vec3) -> Vec3 {
        (self.origin - point) + self.local
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ParticleSeed;

    fn shapes() -> [Extent; 6] {
        // 120° about (1, 1, 1): x goes to y, y to z, z to x.
        let rotation = Quat::from_xyzw(0.5, 0.5, 0.5, 0.5);
        let centre = Vec3::new(10.0, 0.0, 0.0);
        let (a, b) = (centre - Vec3::Y * 2.0, centre + Vec3::Y * 2.0);
        [
            Extent::Everywhere,
            Extent::Below { up: Vec3::Y, level: 1.0 },
            Extent::Box { centre, size: Vec3::new(6.0, 2.0, 2.0), rotation },
            Extent::Sphere { centre, radius: 2.0 },
            Extent::Cylinder { a, b, radius: 1.0 },
            Extent::Capsule { a, b, radius: 1.0 },
        ]
    }

    #[test]
    fn what_a_shape_contains_is_in_the_box_around_it() {
        for extent in shapes() {
            let (low, high) = extent.bounds();
            let mut inside = 0;
            for i in 0..4096_u16 {
                let at = |shift: u16| f32::from(i >> shift & 15) - 7.5;
                let place = Vec3::new(10.0 + 0.6 * at(0), 0.6 * at(4), 0.6 * at(8));
                if extent.depth(WorldPoint::at(place)) >= 0.0 {
                    inside += 1;
                    assert!(
                        place.cmpge(low).all() && place.cmple(high).all(),
                        "{extent:?} {place}"
                    );
                }
            }
            assert!(inside > 20, "{extent:?}");
        }
    }

    #[test]
    fn each_shape_contains_what_is_in_it_and_nothing_else() {
        // From the centre of the shapes: up 0.9, up 2.5, up 3.5, sideways 0.9, sideways 1.5; and whether each of the six contains it.
        let probes = [
            (Vec3::Y * 0.9, [true, true, true, true, true, true]),
            (Vec3::Y * 2.5, [true, false, true, false, false, true]),
            (Vec3::Y * 3.5, [true, false, false, false, false, false]),
            (Vec3::X * 0.9, [true, true, true, true, true, true]),
            (Vec3::Z * 1.5, [true, true, false, true, false, false]),
        ];
        for (probe, inside) in probes {
            let found =
                shapes().map(|extent| Region::from(extent).contains(Vec3::X * 10.0 + probe));
            assert_eq!(found, inside, "{probe}");
        }
    }

    #[test]
    fn the_share_grows_smoothly_from_nothing_at_the_surface_to_all_at_the_fade() {
        let ball = Region::sphere(Vec3::ZERO, 2.0).with_fade(1.0);
        let share = |x: f32| ball.share(Vec3::X * x);
        assert_eq!(
            [share(2.5), share(2.0), share(1.5), share(1.0), share(0.0)],
            [0., 0., 0.5, 1., 1.]
        );
        let steps: Vec<f32> = (0..=300).map(|i| share(2.25 - i as f32 * 0.005)).collect();
        let slopes: Vec<f32> = steps.windows(2).map(|s| s[1] - s[0]).collect();
        assert!(slopes.iter().all(|&slope| (0.0..=0.0076).contains(&slope)));
        // No kink: the slope changes by at most 6/fade² per metre.
        assert!(slopes.windows(2).all(|s| (s[1] - s[0]).abs() < 2e-4));
    }

    #[test]
    fn without_a_fade_a_region_ends_like_a_wall() {
        for extent in shapes() {
            let region = Region::from(extent);
            for i in 0..400 {
                let point = Vec3::new(8.0 + 0.01 * i as f32, 0.003 * i as f32, 0.2);
                let share = region.share(point);
                assert_eq!(
                    share,
                    if region.contains(point) { 1.0 } else { 0.0 },
                    "{extent:?} {point}"
                );
            }
        }
    }

    #[test]
    fn far_from_the_origin_a_region_still_fades_by_millimetres() {
        // Adjacent f32 values are 8 mm apart at 100 km.
        let far = Vec3::new(100_000.0, 0.0, 100_000.0);
        let region = Region::sphere(far, 1.0).with_fade(0.5);
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(far)).unwrap();
        particles.displace(0, Vec3::X * 0.5);
        let mut last = region.share_of(&particles, 0);
        for _ in 0..400 {
            particles.displace(0, Vec3::X * 0.001);
            let now = region.share_of(&particles, 0);
            assert!(now < last, "a millimetre further out is less");
            last = now;
        }
    }

    #[test]
    fn a_region_with_a_broken_number_is_not_valid_and_nothing_is_inside_of_nan() {
        let broken = [
            Region::sphere(Vec3::NAN, 1.0),
            Region::sphere(Vec3::ZERO, -1.0),
            Region::sphere(Vec3::ZERO, 1.0).with_fade(f32::NAN),
            Region::boxed(Vec3::ZERO, Vec3::new(2.0, 0.0, 2.0)),
            Extent::Box {
                centre: Vec3::ZERO,
                size: Vec3::splat(2.0),
                rotation: Quat::from_xyzw(0., 0., 0., 0.),
            }
            .into(),
            Extent::Below { up: Vec3::Y * 2.0, level: 0.0 }.into(),
            Extent::Cylinder { a: Vec3::X, b: Vec3::X, radius: 1.0 }.into(),
            Extent::Capsule { a: Vec3::X, b: Vec3::X, radius: f32::INFINITY }.into(),
        ];
        assert!(broken.iter().all(|region| !region.is_valid()));
        assert!(shapes().iter().all(|&extent| Region::from(extent).is_valid()));
        for extent in &shapes()[1..] {
            assert_eq!(Region::from(*extent).share(Vec3::NAN), 0.0, "{extent:?}");
        }
    }
}
