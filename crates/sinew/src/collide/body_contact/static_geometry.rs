//! Static and kinematic geometry: colliders, and the planes and boxes around the world, as half-spaces.

use glam::{Mat3, Vec3};

use super::super::collider::Collider;
use super::super::frame::Frame;
use super::super::impact::ContactParticipant;
use super::super::material::{CombinedMaterial, Layers, Material};
use super::super::shape::Shape;
use super::super::world::World;
use super::contact_cache::Other;
use super::swept_bounds::SweptBounds;
use crate::constraints::{Boundaries, InsideBox, Plane};

/// A collider, or a half-space of one, of a plane or of a box.
#[derive(Clone, Debug)]
pub(super) struct StaticGeometry {
    pub(super) shape: Shape,
    pub(super) start: Frame,
    /// Number of the collider, if it moves during the step.
    pub(super) moving: Option<usize>,
    /// Frame of the half-space in the coordinates of its collider; the identity of others.
    wall: Frame,
    material: Material,
    /// Whether its own coefficients are used instead of a combined material: true of planes and boxes.
    alone: bool,
    pub(super) layers: Layers,
    pub(super) sensor: bool,
    pub(super) events: bool,
    pub(super) participant: ContactParticipant,
    /// Its name in the contact cache.
    pub(super) other: Other,
    /// Half-space, solid below its plane.
    pub(super) endless: bool,
}

/// Lists all valid static and kinematic geometry of a step.
pub(super) fn list(
    world: &World,
    floor: &mut Option<Shape>,
    static_geometry: &mut Vec<StaticGeometry>,
) {
    // Created once: a clone allocates nothing.
    let floor = floor.get_or_insert_with(Shape::half_space);
    static_geometry.clear();
    for (number, collider) in world.colliders.iter().enumerate() {
        if !collider.is_valid() {
            continue;
        }
        if collider.shape.is_unbounded() {
            let walls = collider.shape.half_spaces().zip(0..);
            static_geometry.extend(
                walls.map(|wall| StaticGeometry::of(collider, number, Some((wall, floor)))),
            );
        } else {
            static_geometry.push(StaticGeometry::of(collider, number, None));
        }
    }
    for (number, plane) in world.boundaries.planes.iter().enumerate() {
        if plane.is_valid() {
            let number = number as u32;
            let other = Other::Plane(u64::from(number));
            static_geometry.push(StaticGeometry::wall(
                plane,
                floor,
                (ContactParticipant::Plane(number), other),
            ));
        }
    }
    for (number, bounding_box) in world.boundaries.boxes.iter().enumerate() {
        if bounding_box.is_valid() {
            let number = number as u32;
            static_geometry.extend(walls(bounding_box).zip(0..).map(|(plane, wall)| {
                let other = Other::Wall(u64::from(number), wall);
                StaticGeometry::wall(&plane, floor, (ContactParticipant::Box(number), other))
            }));
        }
    }
}

impl StaticGeometry {
    /// Geometry of a collider, or of one of its half-spaces.
    fn of(collider: &Collider, number: usize, wall: Option<((Frame, u32), &Shape)>) -> Self {
        let Collider { shape, start, end, material, layers, sensor, events, id } = collider;
        let ((wall, nth), shape, endless) = match wall {
            Some((wall, floor)) => (wall, floor, true),
            None => ((Frame::IDENTITY, 0), shape, false),
        };
        Self {
            shape: shape.clone(),
            start: placed(start, &wall),
            wall,
            moving: (start != end).then_some(number),
            material: *material,
            alone: false,
            layers: *layers,
            sensor: *sensor,
            events: *events,
            participant: ContactParticipant::Collider(number as u32),
            other: Other::Collider(if *id > 0 { *id } else { number as u64 }, nth),
            endless,
        }
    }

    fn wall(
        plane: &Plane,
        floor: &Shape,
        (participant, other): (ContactParticipant, Other),
    ) -> Self {
        let material =
            Material::default().with_friction(plane.friction).with_restitution(plane.restitution);
        Self {
            shape: floor.clone(),
            start: frame_of(plane),
            moving: None,
            wall: Frame::IDENTITY,
            material: Material { drag: plane.drag, ..material },
            alone: true,
            layers: Layers::new(u32::MAX, u32::MAX),
            sensor: false,
            events: false,
            participant,
            other,
            endless: true,
        }
    }

    /// Its frame after a fraction `share` of the step.
    pub(super) fn frame_at(&self, world: &World, share: f32) -> Frame {
        match self.moving.and_then(|number| world.colliders.get(number)) {
            Some(collider) if share > 0.0 => placed(&collider.frame_at(share), &self.wall),
            _ => self.start,
        }
    }

    /// A frame of it relative to an origin, metres. Far from the world's origin, coordinates lose their digits, so a half-space is moved along its plane to
    /// the point nearest to the origin.
    pub(super) fn seen_from(&self, frame: &Frame, origin: Vec3) -> Frame {
        if !self.endless {
            return frame.seen_from(origin);
        }
        let n = frame.rotation.y_axis;
        let height = n.as_dvec3().dot(frame.translation.as_dvec3() - origin.as_dvec3());
        Frame { translation: n * height as f32, ..*frame }
    }

    /// AABB over the step, in the world; NaN for half-spaces.
    pub(super) fn bounds(&self, world: &World) -> (Vec3, Vec3) {
        if self.endless {
            return (Vec3::NAN, Vec3::NAN);
        }
        let (low, high) = self.shape.bounds_in(&self.start);
        if self.moving.is_none() {
            return (low, high);
        }
        let (low_end, high_end) = self.shape.bounds_in(&self.frame_at(world, 1.0));
        (low.min(low_end), high.max(high_end))
    }

    /// Whether a body collider of the reach `size`, metres, may touch this half-space from a fraction `share` of the step on.
    pub(super) fn is_below(&self, one: &SweptBounds, size: f32, world: &World, share: f32) -> bool {
        let here = self.seen_from(&self.frame_at(world, share), one.origin);
        let normal = here.rotation.y_axis;
        let height = normal.dot(one.centre - here.translation);
        let reach = one.reach_against(normal, (1.0 - share) * world.dt);
        height <= size + reach + self.carries(one, world, share)
    }

    /// How far it moves a body collider lying on it, from a fraction `share` of the step on, metres.
    pub(super) fn carries(&self, one: &SweptBounds, world: &World, share: f32) -> f32 {
        self.carried(one, world, share).length()
    }

    /// Displacement that it gives to a body collider lying on it, from a fraction `share` of the step on, metres.
    pub(super) fn carried(&self, one: &SweptBounds, world: &World, share: f32) -> Vec3 {
        if self.moving.is_none() {
            return Vec3::ZERO;
        }
        let (from, to) = (self.frame_at(world, share), self.frame_at(world, 1.0));
        let point = one.centre + one.origin;
        to.point(from.local(point)) - point
    }

    /// Rotation vector of its motion in the step, rad; of a turn by more than a right angle NaN.
    pub(super) fn turn(&self, world: &World) -> Vec3 {
        if self.moving.is_none() {
            return Vec3::ZERO;
        }
        let [from, to] = [&self.start, &self.frame_at(world, 1.0)].map(|frame| frame.rotation);
        let axes = [0, 1, 2].map(|axis| (from.col(axis), to.col(axis)));
        // 1 + 2 cos, and sin times the unit vector.
        let trace: f32 = axes.iter().map(|(from, to)| from.dot(*to)).sum();
        let turn = 0.5 * axes.iter().map(|(from, to)| from.cross(*to)).sum::<Vec3>();
        if trace > 1.0 { turn } else { Vec3::NAN }
    }

    /// The material of a contact of it with a surface.
    pub(super) fn combined_material(&self, other: &Material) -> CombinedMaterial {
        if self.alone {
            let Material { friction, restitution, drag, .. } = self.material;
            CombinedMaterial { friction, restitution, drag }
        } else {
            other.against(&self.material)
        }
    }
}

/// The frame of a half-space of a collider at `frame`. The identity keeps the bits of `frame`.
fn placed(frame: &Frame, wall: &Frame) -> Frame {
    if *wall == Frame::IDENTITY { *frame } else { frame.of(wall) }
}

/// Calls `call` with the valid planes, and with the walls of the valid boxes: with the participant, and with the frame in which it is solid below y = 0.
pub(crate) fn half_spaces(
    boundaries: &Boundaries,
    call: &mut dyn FnMut(ContactParticipant, Frame),
) {
    for (number, plane) in (0..).zip(&boundaries.planes).filter(|(_, plane)| plane.is_valid()) {
        call(ContactParticipant::Plane(number), frame_of(plane));
    }
    for (number, bounding_box) in (0..).zip(&boundaries.boxes).filter(|(_, one)| one.is_valid()) {
        walls(bounding_box).for_each(|wall| call(ContactParticipant::Box(number), frame_of(&wall)));
    }
}

/// The frame of a plane: its normal is y.
fn frame_of(plane: &Plane) -> Frame {
    let n = plane.normal.normalize_or(Vec3::Y);
    let x = n.any_orthonormal_vector();
    Frame { translation: n * plane.offset, rotation: Mat3::from_cols(x, n, x.cross(n)) }
}

/// The six planes of a box, facing inward.
fn walls(bounding_box: &InsideBox) -> impl Iterator<Item = Plane> {
    let InsideBox { min, max, .. } = *bounding_box;
    let wall = move |normal: Vec3, offset: f32| Plane {
        normal,
        offset,
        friction: bounding_box.friction,
        restitution: bounding_box.restitution,
        ..Plane::ground(0.0)
    };
    Vec3::AXES
        .into_iter()
        .flat_map(move |axis| [wall(axis, axis.dot(min)), wall(-axis, -axis.dot(max))])
}
