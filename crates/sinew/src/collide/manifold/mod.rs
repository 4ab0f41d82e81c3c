//! Where two shapes touch: a normal and up to four points, a function of the two and of nothing else, so that nothing is hidden in here. Solids
//! remember what it said (`body_contact::contact_cache`).
//!
//! | file | which pairs |
//! |---|---|
//! | `boxes` | box and box, eight pairs at a time: separating axes; their faces, clipped; corners where no face looks at another |
//! | `half_space` | anything convex and what is infinite |
//! | `round` | spheres; capsule and capsule |
//! | `rod` | capsule and box |
//! | `convex` | cylinders and hulls, and whatever lies on a mesh or a heightfield: `parry3d` finds their normals, `features` the points |
//! | `reduce` | of many points the four that hold as well |
//! | `broad` | which pairs are near at all |

mod boxes;
mod broad;
mod convex;
mod features;
mod half_space;
mod reduce;
mod rod;
mod round;
#[cfg(test)]
mod tests;

use glam::Vec3;

use super::frame::Frame;
use super::shape::{Kind, Shape};
use super::words::{Reader, Write};
use crate::lanes::InstructionSet;

pub(crate) use boxes::BoxPairs;
pub(crate) use broad::{Aabb, Broad, ClusterSearch, NO_GROUP};
pub(crate) use convex::ManifoldScratch;

/// Where two surfaces are near each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Point {
    /// On the first one's surface, in its coordinates, metres.
    pub(crate) on_a: Vec3,
    /// On the second one's surface, in its coordinates, metres.
    pub(crate) on_b: Vec3,
    /// From there to here along the normal, metres; negative where they overlap.
    pub(crate) distance: f32,
}

/// Up to four points with a normal in common.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Manifold {
    /// Unit vector in the second one's coordinates, from it towards the first.
    pub(crate) normal: Vec3,
    points: [Point; 4],
    len: u32,
    /// Which triangle of a mesh or a heightfield it is of; 0 of what is convex.
    pub(crate) part: u32,
    /// Rounding radii of the two, metres; 0 where it is not round. A sphere touches a face below its centre however it has rolled, a capsule and a lying
    /// cylinder below their axes: so what stays where it is in them is the centre of the rounding, a radius away from the surface.
    pub(crate) radii: [f32; 2],
    /// Whether each is round about its own y axis alone, as a cylinder is: then that radius goes straight to the axis, and not along the normal.
    pub(crate) axial: [bool; 2],
    /// How far the two may slide on each other, at least, and be to each other what they are, metres: to the rim of a face. 0 where that is not
    /// known.
    pub(crate) free: f32,
    /// The slope of one on the other, where the deepest point is not a corner of it but where the other one ends: as it slides or turns it touches
    /// there with other points of its own, that are higher or lower by so much a metre. 0 where that is not so, or not known.
    pub(crate) slope: f32,
}

impl Manifold {
    /// One without points.
    fn new(normal: Vec3) -> Self {
        Self { normal, ..Self::default() }
    }

    /// One with a single point.
    fn single(normal: Vec3, on_a: Vec3, on_b: Vec3, distance: f32) -> Self {
        let mut manifold = Self::new(normal);
        manifold.push(Point { on_a, on_b, distance });
        manifold
    }

    /// Adds a point; the fifth is left out.
    fn push(&mut self, point: Point) {
        if let Some(place) = self.points.get_mut(self.len as usize) {
            *place = point;
            self.len += 1;
        }
    }

    /// Its points, at least one of those that are handed out.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points[..self.len as usize]
    }

    /// The least distance of its points, metres; infinite without any.
    fn nearest(&self) -> f32 {
        self.points().iter().fold(f32::INFINITY, |least, point| least.min(point.distance))
    }

    /// The same seen from the other one, whose place in this one's coordinates is given.
    fn swapped(&self, b_in_a: &Frame) -> Self {
        let ([ra, rb], [a, b]) = (self.radii, self.axial);
        let (radii, axial) = ([rb, ra], [b, a]);
        let mut manifold = Self { normal: b_in_a.turn(-self.normal), radii, axial, ..*self };
        for point in &mut manifold.points[..self.len as usize] {
            (point.on_a, point.on_b) = (point.on_b, point.on_a);
        }
        manifold
    }

    /// The same where the second one is at a frame, in whose coordinates this is.
    fn placed(mut self, at: &Frame) -> Self {
        self.normal = at.turn(self.normal);
        for point in &mut self.points[..self.len as usize] {
            point.on_b = at.point(point.on_b);
        }
        self
    }

    /// Appends it as words.
    pub(crate) fn write(&self, words: &mut Vec<u32>) {
        let Self { normal, points, len, part, radii, axial, free, slope } = self;
        words.vec3(*normal);
        words.push(*len);
        for point in points {
            words.vec3(point.on_a);
            words.vec3(point.on_b);
            words.float(point.distance);
        }
        words.push(*part);
        words.extend([radii[0].to_bits(), radii[1].to_bits()]);
        words.extend(axial.map(u32::from));
        words.extend([free.to_bits(), slope.to_bits()]);
    }

    /// Reads it from words.
    pub(crate) fn read(reader: &mut Reader) -> Option<Self> {
        let normal = reader.vec3()?;
        let len = reader.word().filter(|&len| len <= 4)?;
        let mut points = [Point::default(); 4];
        for point in &mut points {
            let (on_a, on_b) = (reader.vec3()?, reader.vec3()?);
            *point = Point { on_a, on_b, distance: reader.float()? };
        }
        let part = reader.word()?;
        let radii = [reader.float()?, reader.float()?];
        let axial = [reader.word()? != 0, reader.word()? != 0];
        let (free, slope) = (reader.float()?, reader.float()?);
        Some(Self { normal, points, len, part, radii, axial, free, slope })
    }

    /// Whether one of the two is round.
    pub(crate) fn is_round(&self) -> bool {
        self.radii != [0.0; 2]
    }

    /// What of a point stays where it is in each of the two, for where the first one was when it was found: a point of the surface, or the centre of the
    /// rounding.
    pub(crate) fn anchors(&self, point: &Point, a_in_b: &Frame) -> [Vec3; 2] {
        self.anchors_about(point, a_in_b, self.axial)
    }

    /// The same where others are round about their axes than [`axial`](Self::axial) says.
    #[inline(always)]
    pub(crate) fn anchors_about(
        &self,
        point: &Point,
        a_in_b: &Frame,
        axial: [bool; 2],
    ) -> [Vec3; 2] {
        let [own, theirs] = self.radii;
        let mut anchors =
            [point.on_a + a_in_b.turn_back(self.normal) * own, point.on_b - self.normal * theirs];
        if axial[0] {
            (anchors[0].x, anchors[0].z) = (0.0, 0.0);
        }
        if axial[1] {
            (anchors[1].x, anchors[1].z) = (0.0, 0.0);
        }
        anchors
    }

    /// Notes what is round of each.
    #[inline(always)]
    fn note_rounding(&mut self, kinds: [Kind; 2], a_in_b: &Frame) {
        let towards_b = a_in_b.turn_back(-self.normal);
        let own = rounding(kinds[0], towards_b, self.points().iter().map(|point| point.on_a));
        let theirs = rounding(kinds[1], self.normal, self.points().iter().map(|point| point.on_b));
        self.radii = [own.0, theirs.0];
        self.axial = [own.1, theirs.1];
    }

    /// Whether it has points, and nothing in it is NaN or infinite: any such number times zero is NaN, and so is a sum with it.
    #[inline(always)]
    fn is_sound(&self) -> bool {
        let mut sum = self.normal;
        for point in self.points() {
            sum += point.on_a + point.on_b + point.distance;
        }
        self.len > 0 && sum.dot(Vec3::ZERO) == 0.0
    }
}

/// Hands out where `a` and `b` are no further apart than `reach` metres (0 or more), given where `a` is in the coordinates of `b`.
///
/// One manifold for two convex shapes, one for each triangle of a mesh or heightfield and for each wall of a room; none for two of those that cannot move (half-spaces,
/// rooms, meshes, heightfields), and none where the frame is not finite.
pub(crate) fn collide(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut ManifoldScratch,
    out: &mut dyn FnMut(&Manifold),
) {
    if rank(a.kind()) <= rank(b.kind()) {
        return in_order(a, b, a_in_b, reach, scratch, out);
    }
    let b_in_a = inverse(a_in_b);
    in_order(b, a, &b_in_a, reach, scratch, &mut |manifold| out(&manifold.swapped(a_in_b)));
}

/// Whether a shape has a manifold for each triangle that another one is near.
pub(crate) fn is_of_triangles(shape: &Shape) -> bool {
    match shape.kind() {
        Kind::Mesh | Kind::HeightField => true,
        // One whose faces the library finds wanting is a mesh to it.
        Kind::Hull(_) => shape.parry().as_trimesh().is_some(),
        _ => false,
    }
}

/// The same for the two in the order of their rank, so that each pair of kinds is written once.
fn in_order(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut ManifoldScratch,
    out: &mut dyn FnMut(&Manifold),
) {
    let mut found = match (a.kind(), b.kind()) {
        (Kind::HalfSpace | Kind::InsideBox | Kind::Mesh | Kind::HeightField, _) => return,
        (kind, Kind::HalfSpace) => {
            Manifold { free: f32::INFINITY, ..half_space::collide(kind, a_in_b, reach) }
        }
        (kind, Kind::InsideBox) => {
            for wall in b.half_spaces() {
                let found = half_space::collide(kind, &a_in_b.from_within(&wall), reach);
                let found = Manifold { free: f32::INFINITY, ..found };
                if found.is_sound() {
                    let mut found = found.placed(&wall);
                    found.note_rounding([kind, Kind::InsideBox], a_in_b);
                    out(&found);
                }
            }
            return;
        }
        (_, Kind::Mesh | Kind::HeightField) => {
            return convex::on_triangles(a, b, a_in_b, reach, scratch, out);
        }
        (_, Kind::Hull(_)) if is_of_triangles(b) => {
            return convex::on_triangles(a, b, a_in_b, reach, scratch, out);
        }
        (Kind::Box { .. }, Kind::Box { .. }) => {
            let pairs = &mut scratch.boxes;
            pairs.clear();
            pairs.push([a, b], a_in_b, reach);
            pairs.collide(InstructionSet::best()).first().copied().unwrap_or_default()
        }
        (Kind::Sphere { radius }, _) => round::sphere(radius, b, a_in_b, reach).unwrap_or_default(),
        (
            Kind::Capsule { radius, half_height },
            Kind::Capsule { radius: other, half_height: other_half },
        ) => round::capsules([radius, half_height], [other, other_half], a_in_b, reach)
            .unwrap_or_default(),
        (Kind::Capsule { radius, half_height }, Kind::Box { half_size }) => {
            rod::collide([radius, half_height], half_size, a_in_b, reach).unwrap_or_default()
        }
        _ => convex::collide(a, b, a_in_b, reach, scratch).unwrap_or_default(),
    };
    if found.is_sound() {
        found.note_rounding([a.kind(), b.kind()], a_in_b);
        out(&found);
    }
}

/// The sine of the angle by which a cylinder must be tilted to touch by its side or a rim, and not by an end: 6 degrees.
const ROLLS: f32 = 0.1;

/// The rounding radius of what touches in some points, metres, and whether it is round about its y axis alone; 0 of what is not round.
#[inline(always)]
fn rounding(kind: Kind, outwards: Vec3, mut points: impl Iterator<Item = Vec3>) -> (f32, bool) {
    match kind {
        Kind::Sphere { radius } | Kind::Capsule { radius, .. } => (radius, false),
        Kind::Cylinder { radius, .. } => {
            let (out, sine) = across_axis(outwards);
            let near = 1e-3 * radius;
            let is_lowest =
                |p: Vec3| (Vec3::new(p.x, 0.0, p.z) - out * radius).length_squared() < near * near;
            let rolls = sine > ROLLS && points.all(is_lowest);
            if rolls { (radius, true) } else { (0.0, false) }
        }
        _ => (0.0, false),
    }
}

/// The direction across the y axis that is nearest to another one, and the sine of the angle between that and the axis.
#[inline(always)]
fn across_axis(direction: Vec3) -> (Vec3, f32) {
    let across = Vec3::new(direction.x, 0.0, direction.z);
    let sine = across.length();
    (across / sine.max(f32::MIN_POSITIVE), sine)
}

/// Which of two is the first: what is simpler, and what can move before what cannot.
fn rank(kind: Kind) -> u8 {
    match kind {
        Kind::Sphere { .. } => 0,
        Kind::Capsule { .. } => 1,
        Kind::Box { .. } => 2,
        Kind::Cylinder { .. } => 3,
        Kind::Hull(..) => 4,
        Kind::HalfSpace => 5,
        Kind::Mesh => 6,
        Kind::HeightField => 7,
        Kind::InsideBox => 8,
    }
}

/// Where the second is, seen from the first.
fn inverse(frame: &Frame) -> Frame {
    Frame { translation: -frame.turn_back(frame.translation), rotation: frame.rotation.transpose() }
}
