//! Distance and normal of two convex shapes, the basis of shape casts.
//!
//! The search is that of Gilbert, Johnson and Keerthi (1988) for the point of the Minkowski difference that is nearest to the origin, in `f64` and without
//! rounding radii: a sphere is a point and a capsule a segment, each with a radius. `parry3d` has the same search in `f32`, and terminates at a thousandth of
//! the distance: its normals are off by a few hundredths of a radian where a character stands a centimetre above a floor, and whatever slides along them
//! creeps.
//!
//! The distance that is returned is the separation of the two along the normal, which never exceeds their distance, however well the search converged: moving
//! no farther than that in any direction touches nothing.

use glam::{DMat3, DVec3, Vec3};
use smallvec::SmallVec;

use super::{Kind, Shape};
use crate::collide::frame::Frame;

/// A convex shape as everything within a radius of its core. In its own frame, metres.
#[derive(Clone, Copy, Debug)]
pub(in crate::collide) struct RoundedCore<'a> {
    core: Core<'a>,
    radius: f64,
}

#[derive(Clone, Copy, Debug)]
enum Core<'a> {
    Point,
    /// Along y; half of its length.
    Segment(f64),
    /// Half of its size.
    Box(DVec3),
    Cylinder {
        radius: f64,
        half_height: f64,
    },
    Hull(&'a [Vec3]),
    Triangle([DVec3; 3]),
}

/// The gap between two shapes that are apart, in the frame of the second one.
#[derive(Clone, Copy, Debug)]
pub(in crate::collide) struct Gap {
    /// Separation along the normal, metres; negative where they overlap by less than their radii.
    pub(in crate::collide) distance: f64,
    /// Unit vector from the second to the first.
    pub(in crate::collide) normal: DVec3,
    /// The nearest point on the second shape.
    pub(in crate::collide) point: DVec3,
    /// Distance of the cores, metres. Where it is small, the normal is only as accurate as positions are.
    pub(in crate::collide) cores: f64,
}

/// Pose of one shape in the frame of another, at the precision of their difference.
#[derive(Clone, Copy, Debug)]
pub(in crate::collide) struct Relative {
    rotation: DMat3,
    translation: DVec3,
}

/// Maximum number of iterations: between polyhedra the search terminates by itself in fewer than ten.
const ROUNDS: usize = 64;
/// Square of the distance above which cores count as apart, m².
const APART: f64 = 1e-20;

impl<'a> RoundedCore<'a> {
    /// The rounded core of a shape; `None` for half-spaces, inside boxes, meshes and heightfields.
    pub(in crate::collide) fn of(shape: &'a Shape) -> Option<Self> {
        let round = |core, radius: f32| Self { core, radius: f64::from(radius) };
        Some(match shape.kind() {
            Kind::Sphere { radius } => round(Core::Point, radius),
            Kind::Capsule { radius, half_height } => {
                round(Core::Segment(f64::from(half_height)), radius)
            }
            Kind::Box { half_size } => round(Core::Box(half_size.as_dvec3()), 0.0),
            Kind::Cylinder { radius, half_height } => {
                let (radius, half_height) = (f64::from(radius), f64::from(half_height));
                round(Core::Cylinder { radius, half_height }, 0.0)
            }
            Kind::Hull(points) => round(Core::Hull(points), 0.0),
            Kind::HalfSpace | Kind::InsideBox | Kind::Mesh | Kind::HeightField => return None,
        })
    }

    /// A ball that is centred at the origin.
    pub(in crate::collide) fn ball(radius: f32) -> Self {
        Self { core: Core::Point, radius: f64::from(radius) }
    }

    /// A triangle.
    pub(in crate::collide) fn triangle(corners: [Vec3; 3]) -> Self {
        Self { core: Core::Triangle(corners.map(Vec3::as_dvec3)), radius: 0.0 }
    }

    /// Its support point along a unit vector.
    pub(in crate::collide) fn farthest(&self, along: DVec3) -> DVec3 {
        self.support(along) + along * self.radius
    }

    /// The support point of the core along a direction.
    fn support(&self, along: DVec3) -> DVec3 {
        match self.core {
            Core::Point => DVec3::ZERO,
            Core::Segment(half) => DVec3::Y * half.copysign(along.y),
            Core::Box(half) => {
                let [x, y, z] = [along.x, along.y, along.z];
                DVec3::new(half.x.copysign(x), half.y.copysign(y), half.z.copysign(z))
            }
            Core::Cylinder { radius, half_height } => {
                let level = (along.x * along.x + along.z * along.z).sqrt();
                let share = if level > 0.0 { radius / level } else { 0.0 };
                DVec3::new(along.x * share, half_height.copysign(along.y), along.z * share)
            }
            Core::Hull(points) => farthest(points.iter().map(|point| point.as_dvec3()), along),
            Core::Triangle(corners) => farthest(corners, along),
        }
    }

    /// Its distance from the plane `y = 0` of a half-space, and the nearest point on that plane.
    pub(in crate::collide) fn above_plane(&self, pose: &Relative) -> Gap {
        let lowest = pose.point(self.support(pose.rotation.transpose() * -DVec3::Y));
        Gap {
            distance: lowest.y - self.radius,
            normal: DVec3::Y,
            point: lowest.with_y(0.0),
            cores: lowest.y,
        }
    }

    /// The gap between this shape, at pose `pose` in the frame of the other one, and that; `None` where their cores touch or overlap.
    pub(in crate::collide) fn gap(&self, pose: &Relative, other: &Self) -> Option<Gap> {
        let back = pose.rotation.transpose();
        // Support point of the Minkowski difference against a direction, and the point of the other shape that belongs to it.
        let support = |v: DVec3| {
            let theirs = other.support(v);
            (pose.point(self.support(back * -v)) - theirs, theirs)
        };
        let mut simplex: Simplex = SmallVec::new();
        simplex.push(support(pose.translation));
        let (mut v, mut point) = simplex[0];
        let mut separation = f64::NEG_INFINITY;
        for _ in 0..ROUNDS {
            let square = v.length_squared();
            // Also for NaN.
            if square.is_nan() || square <= APART {
                return None;
            }
            let corner = support(v);
            let least = v.dot(corner.0);
            separation = least / square.sqrt();
            if square - least <= 1e-13 * square || simplex.contains(&corner) {
                break;
            }
            simplex.push(corner);
            let (nearer, theirs) = reduce(&mut simplex)?;
            if nearer.length_squared() >= square {
                break;
            }
            (v, point) = (nearer, theirs);
        }
        let normal = v.normalize();
        Some(Gap {
            distance: separation - self.radius - other.radius,
            normal,
            point: point + normal * other.radius,
            cores: separation,
        })
    }
}

impl RoundedCore<'_> {
    /// A separation from another shape whose core touches or overlaps that of this one, as a gap of negative distance: the shortest one along the normals of a
    /// triangle, the axes of this shape, or the line from the centre of the other one. It separates the two, though there may be a shorter one. `None` if a
    /// number is not finite.
    pub(in crate::collide) fn separation(&self, pose: &Relative, other: &Self) -> Option<Gap> {
        let mut directions: SmallVec<[DVec3; 16]> = SmallVec::new();
        let mut middle = DVec3::ZERO;
        if let Core::Triangle([a, b, c]) = other.core {
            let normal = (b - a).cross(c - a);
            let edges = [b - a, c - b, a - c].map(|edge| edge.cross(normal));
            directions.extend([normal, -normal]);
            directions.extend(edges);
            middle = (a + b + c) / 3.0;
        }
        let DMat3 { x_axis, y_axis, z_axis } = pose.rotation;
        directions.extend([
            pose.translation - middle,
            x_axis,
            -x_axis,
            y_axis,
            -y_axis,
            z_axis,
            -z_axis,
        ]);
        let back = pose.rotation.transpose();
        let mut best: Option<Gap> = None;
        for normal in directions.into_iter().filter_map(DVec3::try_normalize) {
            let point = other.farthest(normal);
            let separation = (pose.point(self.farthest(back * -normal)) - point).dot(normal);
            let better = best.is_none_or(|best| separation > best.distance);
            if better && separation.is_finite() {
                best = Some(Gap { distance: separation, normal, point, cores: 0.0 });
            }
        }
        best
    }
}

impl Relative {
    /// Pose of `one` in the frame of `other`.
    pub(in crate::collide) fn new(one: &Frame, other: &Frame) -> Self {
        let back = other.rotation.as_dmat3().transpose();
        let between = one.translation.as_dvec3() - other.translation.as_dvec3();
        Self { rotation: back * one.rotation.as_dmat3(), translation: back * between }
    }

    fn point(&self, local: DVec3) -> DVec3 {
        self.rotation * local + self.translation
    }
}

/// Up to four points of the difference, the newest last, each with its point of the second shape.
type Simplex = SmallVec<[(DVec3, DVec3); 4]>;

fn farthest(points: impl IntoIterator<Item = DVec3>, along: DVec3) -> DVec3 {
    let mut most = (f64::NEG_INFINITY, DVec3::ZERO);
    for point in points {
        let reach = point.dot(along);
        if reach > most.0 {
            most = (reach, point);
        }
    }
    most.1
}

/// Reduces a simplex to the smallest sub-simplex with the newest point that contains the point nearest to the origin. Returns that point, and the corresponding
/// one of the second shape. `None` if the origin is inside.
fn reduce(simplex: &mut Simplex) -> Option<(DVec3, DVec3)> {
    let newest = simplex.pop()?;
    let others = simplex.clone();
    if let [a, b, c] = others[..]
        && encloses([newest.0, a.0, b.0, c.0])
    {
        return None;
    }
    let mut best = (newest.0.length_squared(), SmallVec::from_slice(&[(newest, 1.0)]));
    let mut consider = |shares: &[((DVec3, DVec3), f64)]| {
        let inside = shares.iter().all(|(_, share)| *share > 0.0);
        let square = shares.iter().map(|(at, share)| at.0 * share).sum::<DVec3>().length_squared();
        if inside && square < best.0 {
            best = (square, SmallVec::<[_; 4]>::from_slice(shares));
        }
    };
    for (i, &other) in others.iter().enumerate() {
        let (a, b) = (newest.0, other.0);
        let share = -a.dot(b - a) / (b - a).length_squared();
        consider(&[(newest, 1.0 - share), (other, share)]);
        for &third in &others[..i] {
            let c = third.0;
            let normal = (b - a).cross(c - a);
            let share = |p: DVec3, q: DVec3| p.cross(q).dot(normal) / normal.length_squared();
            consider(&[(newest, share(b, c)), (other, share(c, a)), (third, share(a, b))]);
        }
    }
    simplex.clear();
    let (mut nearest, mut theirs) = (DVec3::ZERO, DVec3::ZERO);
    for &(at, share) in &best.1 {
        nearest += at.0 * share;
        theirs += at.1 * share;
        simplex.push(at);
    }
    // Keeps the newest point last.
    simplex.reverse();
    Some((nearest, theirs))
}

/// Whether the origin is within a tetrahedron: for each face on the same side as the fourth point.
fn encloses([a, b, c, d]: [DVec3; 4]) -> bool {
    let same_side = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| {
        let normal = (b - a).cross(c - a);
        normal.dot(d - a) * normal.dot(-a) > 0.0
    };
    same_side(a, b, c, d) && same_side(b, c, d, a) && same_side(c, d, a, b) && same_side(d, a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn shapes() -> Vec<Shape> {
        let corners: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32 * 0.7, (i >> 2) as f32 * 1.3))
            .collect();
        vec![
            Shape::sphere(0.4).unwrap(),
            Shape::capsule(0.3, 1.2).unwrap(),
            Shape::cuboid(Vec3::new(0.5, 1.0, 2.0)).unwrap(),
            Shape::cylinder(0.5, 0.8).unwrap(),
            Shape::hull(&corners).unwrap(),
        ]
    }

    fn frames() -> impl Iterator<Item = Frame> {
        (0..60).map(|i| {
            let angle = i as f32 * 0.7;
            let at = Vec3::new(libm::cosf(angle), libm::sinf(2.1 * angle), libm::sinf(angle));
            let turn = Quat::from_xyzw(0.3, libm::sinf(angle), -0.2 * i as f32, 1.0);
            Frame::new(at * (2.3 + 0.2 * (i % 7) as f32), turn)
        })
    }

    /// No direction separates the two by more than the gap found, and its point lies on the second shape.
    #[test]
    fn the_gap_is_the_greatest_separation_and_the_distance_to_every_point() {
        for (i, a) in shapes().iter().enumerate() {
            for (j, b) in shapes().iter().enumerate() {
                let (own, other) = (RoundedCore::of(a).unwrap(), RoundedCore::of(b).unwrap());
                let mut apart = 0;
                for frame in frames() {
                    let pose = Relative::new(&frame, &Frame::IDENTITY);
                    let Some(gap) = own.gap(&pose, &other) else { continue };
                    let separation = |n: DVec3| {
                        let near = pose.point(own.support(pose.rotation.transpose() * -n));
                        (near - other.support(n)).dot(n) - own.radius - other.radius
                    };
                    assert!((separation(gap.normal) - gap.distance).abs() < 1e-9, "{i} {j}");
                    for k in 0..200 {
                        let k = f64::from(k);
                        let n =
                            DVec3::new(libm::cos(k), libm::sin(1.7 * k), libm::cos(2.3 * k + 1.0));
                        let n = (gap.normal + n * 0.3f64.powi(1 + k as i32 % 12)).normalize();
                        assert!(separation(n) <= gap.distance + 1e-7, "{i} {j} {frame:?}");
                    }
                    if gap.distance > 0.0 {
                        apart += 1;
                        let on_b = gap.point.as_vec3();
                        let found = b.nearest(on_b).distance;
                        assert!(found.abs() < 1e-5, "{i} {j}: {found}");
                        let off = a.nearest(frame.local(on_b)).distance;
                        assert!((off - gap.distance as f32).abs() < 1e-5, "{i} {j}: {off} {gap:?}");
                    }
                }
                assert!(apart > 20, "{i} {j}: {apart}");
            }
        }
    }

    /// `parry3d` is off by up to 4 hundredths of a radian here.
    #[test]
    fn the_normal_of_a_face_is_exact_however_near() {
        let (own, floor) = (Shape::cuboid(Vec3::new(0.5, 1.8, 0.4)).unwrap(), [40.0, 1.0, 40.0]);
        let floor = Shape::cuboid(floor.into()).unwrap();
        for gap in [1.0, 0.01, 1e-4, 1e-6] {
            for turn in 0..20 {
                let turn = Quat::from_xyzw(0.0, libm::sinf(turn as f32), 0.0, 1.0);
                let frame = Frame::new(Vec3::new(3.0, 1.4 + gap, -7.0), turn);
                let pose = Relative::new(&frame, &Frame::IDENTITY);
                let (own, other) =
                    (RoundedCore::of(&own).unwrap(), RoundedCore::of(&floor).unwrap());
                let found = own.gap(&pose, &other).unwrap();
                assert!(found.normal.abs_diff_eq(DVec3::Y, 1e-6), "{gap}: {found:?}");
                assert!((found.distance - f64::from(gap)).abs() < 2e-7, "{gap}: {found:?}");
            }
        }
    }

    #[test]
    fn a_way_out_of_a_triangle_leads_out_of_it_and_flat_ones_have_one_too() {
        let spread = [Vec3::new(-1.0, 0.1, -1.0), Vec3::X, Vec3::new(0.1, -0.1, 1.0)];
        let triangles = [spread, [Vec3::X, Vec3::ZERO, -Vec3::X], [Vec3::splat(0.1); 3]];
        for shape in &shapes() {
            let own = RoundedCore::of(shape).unwrap();
            let (low, high) = shape.bounds();
            for corners in triangles {
                let (other, frame) =
                    (RoundedCore::triangle(corners), Frame::at((low + high) * -0.5));
                let pose = Relative::new(&frame, &Frame::IDENTITY);
                let out = own.separation(&pose, &other).unwrap();
                assert!(out.distance < 0.0 && out.normal.is_normalized(), "{out:?}");
                let by = out.normal * (1e-4 - out.distance);
                let away = Relative { translation: pose.translation + by, ..pose };
                let gap = own.gap(&away, &other).unwrap();
                assert!(gap.distance > 0.0, "{gap:?} {out:?}");
            }
        }
        let pose = Relative::new(&Frame::at(Vec3::NAN), &Frame::IDENTITY);
        let own = RoundedCore::ball(1.0);
        assert!(own.separation(&pose, &own).is_none());
    }

    #[test]
    fn cores_that_overlap_have_no_gap_and_broken_numbers_neither() {
        for shape in &shapes() {
            let own = RoundedCore::of(shape).unwrap();
            let (low, high) = shape.bounds();
            let middle = Frame::at((low + high) * 0.5);
            let pose = Relative::new(&Frame::IDENTITY, &middle);
            let corners = [Vec3::new(-1.0, 0.01, -1.0), Vec3::X, Vec3::Z];
            assert!(own.gap(&pose, &RoundedCore::of(&shapes()[2]).unwrap()).is_none());
            assert!(
                RoundedCore::triangle(corners)
                    .gap(&pose, &RoundedCore::of(&shapes()[3]).unwrap())
                    .is_none()
            );
            let broken = Relative::new(&Frame::at(Vec3::NAN), &Frame::IDENTITY);
            assert!(own.gap(&broken, &own).is_none());
        }
        assert!(RoundedCore::of(&Shape::half_space()).is_none());
    }
}
