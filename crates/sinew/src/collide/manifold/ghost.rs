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
//! A body that tumbles may reach below `P` within the step, beside the face that it touches; its contacts are all kept.

use glam::Vec3;

use super::super::shape::{Kind, Shape, from_parry};
use super::features::ShapeOrTriangle;
use super::{Frame, Manifold};

/// How far the two may reach across the plane, as a share of the body's smallest half extent: what rests on a floor overlaps with it, and tiles may be laid a
/// little unevenly. A ledge of this height is no obstacle.
const TOLERANCE: f32 = 0.02;
/// Cosine of the angle between two normals from which on both contacts may carry the body: 60°.
const BOTH_CARRY: f32 = 0.5;
/// Squared difference of two normals up to which they are the same.
const SAME: f32 = 1e-6;

/// A body that moves in a step.
pub(crate) struct MovingBody<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) frame: Frame,
    /// Rotation vector of its motion in the step, rad.
    pub(crate) turn: Vec3,
    /// Greatest distance of its surface from its centre, metres.
    pub(crate) reach: f32,
}

/// A manifold of a body with static geometry, which stays where it is. Frames of all contacts and of the body have one origin.
pub(crate) struct StaticContact<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) frame: Frame,
    pub(crate) manifold: &'a Manifold,
}

/// Whether a contact of a body is a ghost beside another one, which is none.
pub(crate) fn is_ghost(body: &MovingBody, contact: &StaticContact, beside: &StaticContact) -> bool {
    let normal = contact.normal();
    let rolls_beside = beside.manifold.axial[0] && !contact.manifold.axial[0];
    if (normal - beside.normal()).length_squared() < SAME && !rolls_beside {
        return false;
    }
    let (Some(geometry), Some(floor)) = (contact.part(), beside.part()) else { return false };
    let Some((up, offset)) = floor.face_along(beside.manifold.normal) else { return false };
    let up = beside.frame.turn(up);
    let height = offset + up.dot(beside.frame.translation);
    let own = ShapeOrTriangle::Shape(body.shape);
    let carries = !rolls_beside
        && normal.dot(up) > BOTH_CARRY
        && (geometry.face_along(contact.manifold.normal).is_some()
            || own.face_along(body.frame.turn_back(-normal)).is_some());
    if carries {
        return false;
    }
    let (low, high) = body.shape.bounds();
    let tolerance = TOLERANCE * 0.5 * (high - low).min_element();
    let support = |shape: &ShapeOrTriangle, frame: &Frame, along: Vec3| {
        along.dot(frame.translation) + shape.reach(frame.turn_back(along))
    };
    let lowest = -support(&own, &body.frame, -up);
    lowest >= height - tolerance
        && body.tilt(up) * body.reach <= tolerance
        && support(&geometry, &contact.frame, up) <= height + tolerance
        && contact.points().all(|point| up.dot(point) <= height + tolerance)
}

impl MovingBody<'_> {
    /// By how much it turns against a direction, rad. A turn of a round shape about its own axis, or about its centre, moves no surface.
    fn tilt(&self, up: Vec3) -> f32 {
        let axis = self.frame.rotation.y_axis;
        let turn = match self.shape.kind() {
            Kind::Sphere { .. } => Vec3::ZERO,
            Kind::Capsule { .. } | Kind::Cylinder { .. } => self.turn - axis * axis.dot(self.turn),
            _ => self.turn,
        };
        (turn - up * up.dot(turn)).length()
    }
}

impl<'a> StaticContact<'a> {
    fn normal(&self) -> Vec3 {
        self.frame.turn(self.manifold.normal)
    }

    fn points(&self) -> impl Iterator<Item = Vec3> {
        self.manifold.points().iter().map(|point| self.frame.point(point.on_b))
    }

    /// The convex part that the manifold is of: the shape, or its triangle.
    fn part(&self) -> Option<ShapeOrTriangle<'a>> {
        let (parry, part) = (self.shape.parry(), self.manifold.part);
        let triangle = match self.shape.kind() {
            Kind::Mesh => {
                let mesh = parry.as_trimesh()?;
                ((part as usize) < mesh.num_triangles()).then(|| mesh.triangle(part))?
            }
            Kind::HeightField => parry.as_heightfield()?.triangle_at_id(part)?,
            Kind::InsideBox => return None,
            _ => return Some(ShapeOrTriangle::Shape(self.shape)),
        };
        Some(ShapeOrTriangle::Triangle([triangle.a, triangle.b, triangle.c].map(from_parry)))
    }
}
