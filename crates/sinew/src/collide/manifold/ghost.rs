//! Ghost contacts: contacts with the inner edges of a floor that is made of several shapes.
//!
//! Two tiles lie side by side, and a box slides from one to the other. Nothing is in its way. But the box and the second tile, looked at as a pair, are farthest
//! apart along the side of the tile: their normal is level, and the box stops as at a wall, or is thrown up by it. A box that falls along a wall of blocks is held
//! by each of them in the same way, and a ball meets the near edge of the tile from above and loses speed there. Other engines call such contacts ghost
//! collisions. Within a mesh the normals of the neighbouring triangles exclude them (`convex`); between colliders the pairs have to be compared.
//!
//! # The rule
//!
//! The body touches a face of one of the shapes, with the plane `P`. If the body does not reach below `P`, and another shape does not reach above `P`, then `P`
//! separates the two, and as long as the first contact keeps the body above `P`, they cannot meet: their contact is a ghost. It is not, if it may carry the body
//! as well: if it has about the same normal, and that of a face. (Unless a cylinder rolls on the first: then it touches the other with a point of its side that is
//! not its lowest.)
//!
//! A body that tumbles may reach below `P` within the step, beside the face that it touches; its contacts are all kept. So are those with pieces that move apart
//! along `P`'s normal, or turn against each other: crates in a row are a floor as long as they lie side by side, planks of a deck that rolls as long as they do so
//! together. All motions are compared where the body is.

use glam::Vec3;

use super::super::shape::{Kind, Shape, from_parry};
use super::features::ShapeOrTriangle;
use super::{Frame, Manifold, Point};

/// How far the two may reach across the plane, as a share of the body's smallest half extent: what rests on a floor overlaps with it, and tiles may be laid a
/// little unevenly. A ledge of this height is no obstacle.
const TOLERANCE: f32 = 0.02;
/// How far a body, or what lies beside one, may rise above the plane, as a share of that. Crates in a row lie level, but in a heap edges overlap by a little
/// everywhere: with the tolerance of tiles a box that slid down another one sank by as much into the edge below.
const BODY_LEDGE: f32 = 0.1;
/// Cosine of the angle between two normals from which on both contacts may carry the body: 60°.
const BOTH_CARRY: f32 = 0.5;
/// Radius of the inscribed sphere of a convex shape about its centre, at least, as a share of its smallest half extent. That of a tetrahedron is half of it.
const INSCRIBED: f32 = 0.4;
/// Squared difference of two normals up to which they are the same.
const SAME: f32 = 1e-6;

/// A shape that moves in a step: a body, or what it touches. All frames have one origin.
#[derive(Clone, Copy)]
pub(crate) struct MovingShape<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) frame: Frame,
    /// Whether it is a body, and no static or kinematic geometry.
    pub(crate) is_body: bool,
    /// Rotation vector of its motion in the step, rad; zero for what is static.
    pub(crate) turn: Vec3,
}

/// A body whose contacts are compared.
pub(crate) struct MovingBody<'a> {
    body: MovingShape<'a>,
    /// Greatest distance of its surface from its centre, metres.
    reach: f32,
    /// How far it and what it touches may reach across a plane, metres.
    tolerance: f32,
}

/// A contact of a body with another shape.
pub(crate) struct ContactWith<'a> {
    pub(crate) other: MovingShape<'a>,
    pub(crate) manifold: &'a Manifold,
    /// From the other shape towards the body.
    pub(crate) normal: Vec3,
    /// Whether the body is the second of the two that the manifold is of.
    pub(crate) is_second: bool,
}

/// Whether a contact of a body is a ghost beside another one, which is none. On the floor of that the body [keeps upright](MovingBody::keeps_upright), and the floor
/// does not [part](MovingBody::allows_gap) from the body or from the other one.
pub(crate) fn is_ghost(
    &MovingBody { ref body, reach, tolerance }: &MovingBody,
    contact: &ContactWith,
    beside: &ContactWith,
) -> bool {
    let normal = contact.normal;
    let rolls_beside = beside.is_axial() && !contact.is_axial();
    if (normal - beside.normal).length_squared() < SAME && !rolls_beside {
        return false;
    }
    let (other, floor_shape) = (&contact.other, &beside.other);
    let ledge = tolerance * if other.is_body || floor_shape.is_body { BODY_LEDGE } else { 1.0 };
    // Of what is compared in a heap, this alone excludes most.
    let along = beside.normal;
    let height = beside.points().map(|point| along.dot(point)).fold(f32::NEG_INFINITY, f32::max);
    if contact.points().any(|point| along.dot(point) > height + tolerance) {
        return false;
    }
    let turns_along = other.tilt(beside.normal, floor_shape.turn) * reach <= tolerance;
    if !turns_along {
        return false;
    }
    let (Some(geometry), Some(floor)) = (contact.part(), beside.part()) else { return false };
    let along = floor_shape.frame.turn_back(beside.normal);
    let Some((up, offset)) = floor.face_along(along) else { return false };
    let up = floor_shape.frame.turn(up);
    let height = offset + up.dot(floor_shape.frame.translation);
    let own = ShapeOrTriangle::Shape(body.shape);
    let carries = !rolls_beside
        && normal.dot(up) > BOTH_CARRY
        && (geometry.face_along(other.frame.turn_back(normal)).is_some()
            || own.face_along(body.frame.turn_back(-normal)).is_some());
    if carries {
        return false;
    }
    let support = |shape: &ShapeOrTriangle, frame: &Frame, along: Vec3| {
        along.dot(frame.translation) + shape.reach(frame.turn_back(along))
    };
    contact.points().all(|point| up.dot(point) <= height + ledge)
        && -support(&own, &body.frame, -up) >= height - tolerance
        && support(&geometry, &other.frame, up) <= height + ledge
}

impl<'a> MovingBody<'a> {
    pub(crate) fn new(body: MovingShape<'a>, reach: f32) -> Self {
        let (low, high) = body.shape.bounds();
        Self { body, reach, tolerance: TOLERANCE * 0.5 * (high - low).min_element() }
    }

    /// Whether it turns so little against a floor of a normal and a turn in the step, rad, that it reaches nothing beside.
    pub(crate) fn keeps_upright(&self, normal: Vec3, turn: Vec3) -> bool {
        self.body.tilt(normal, turn) * self.reach <= self.tolerance
    }

    /// Whether a plane may separate it from another shape whose centre lies this much below its own, metres: it has to lie above that plane itself.
    pub(crate) fn may_be_above(&self, height: f32) -> bool {
        height * TOLERANCE > INSCRIBED * self.tolerance
    }

    /// Whether it, or another shape, may come nearer to a floor or farther from it by this much in the step, metres.
    pub(crate) fn allows_gap(&self, change: f32) -> bool {
        change.abs() <= self.tolerance
    }
}

impl MovingShape<'_> {
    /// By how much it turns against a floor of a normal and a turn, rad. A turn of a round shape about its own axis, or about its centre, moves no surface.
    fn tilt(&self, up: Vec3, floor: Vec3) -> f32 {
        let (axis, turn) = (self.frame.rotation.y_axis, self.turn - floor);
        let turn = match self.shape.kind() {
            Kind::Sphere { .. } => Vec3::ZERO,
            Kind::Capsule { .. } | Kind::Cylinder { .. } => turn - axis * axis.dot(turn),
            _ => turn,
        };
        (turn - up * up.dot(turn)).length()
    }
}

impl<'a> ContactWith<'a> {
    /// Whether the body is round about an axis, and touches with its side.
    fn is_axial(&self) -> bool {
        self.manifold.axial[usize::from(self.is_second)]
    }

    /// The points on the other shape.
    fn points(&self) -> impl Iterator<Item = Vec3> {
        let on_other = |point: &Point| if self.is_second { point.on_a } else { point.on_b };
        self.manifold.points().iter().map(move |point| self.other.frame.point(on_other(point)))
    }

    /// The convex part that the manifold is of: the shape, or its triangle.
    fn part(&self) -> Option<ShapeOrTriangle<'a>> {
        let (shape, part) = (self.other.shape, self.manifold.part);
        let parry = shape.parry();
        let triangle = match shape.kind() {
            Kind::Mesh => {
                let mesh = parry.as_trimesh()?;
                ((part as usize) < mesh.num_triangles()).then(|| mesh.triangle(part))?
            }
            Kind::HeightField => parry.as_heightfield()?.triangle_at_id(part)?,
            Kind::InsideBox => return None,
            _ => return Some(ShapeOrTriangle::Shape(shape)),
        };
        Some(ShapeOrTriangle::Triangle([triangle.a, triangle.b, triangle.c].map(from_parry)))
    }
}
