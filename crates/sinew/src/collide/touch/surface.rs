//! What a particle may touch and somebody asks about: colliders, and those planes and boxes that bounce or whose contacts are to be told.

use super::super::collider::on_the_way;
use super::super::{Collider, ContactFilter, Frame, Grip, Layers, Material, Party, Shape};
use crate::constraints::{Boundaries, InsideBox, Plane};
use crate::particles::Places;

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) form: Form,
    start: Frame,
    /// Where it goes during the step; the same if it does not.
    end: Frame,
    pub(super) material: Material,
    /// Whether its own coefficients count alone, whatever touches it: so it is of planes and boxes.
    alone: bool,
    pub(super) layers: Layers,
    pub(super) sensor: bool,
    pub(super) events: bool,
    pub(super) party: Party,
}

/// Its geometry.
#[derive(Clone, Debug)]
pub(super) enum Form {
    Plane(Plane),
    Room(InsideBox),
    Shape(Shape),
}

/// Whether a plane or a box is more than a bound: it bounces, or its contacts are to be told.
pub(super) fn is_asked(restitution: f32, told: bool) -> bool {
    restitution > 0.0 || told
}

/// Lists them, valid ones only.
pub(super) fn list(
    boundaries: &Boundaries,
    colliders: &[Collider],
    told: bool,
    surfaces: &mut Vec<Surface>,
) {
    surfaces.clear();
    for (number, plane) in boundaries.planes.iter().enumerate() {
        if plane.is_valid() && is_asked(plane.restitution, told) {
            let party = Party::Plane(number as u32);
            let form = Form::Plane(*plane);
            surfaces.push(Surface::bound(form, plane.friction, plane.restitution, party));
        }
    }
    for (number, room) in boundaries.boxes.iter().enumerate() {
        if room.is_valid() && is_asked(room.restitution, told) {
            let party = Party::Box(number as u32);
            let form = Form::Room(*room);
            surfaces.push(Surface::bound(form, room.friction, room.restitution, party));
        }
    }
    for (number, collider) in colliders.iter().enumerate() {
        if collider.is_valid() {
            surfaces.push(Surface::of(collider, number as u32));
        }
    }
}

impl Surface {
    fn bound(form: Form, friction: f32, restitution: f32, party: Party) -> Self {
        let material = Material::default().with_friction(friction).with_restitution(restitution);
        Self {
            form,
            start: Frame::IDENTITY,
            end: Frame::IDENTITY,
            material,
            alone: true,
            layers: Layers::new(u32::MAX, u32::MAX),
            sensor: false,
            events: false,
            party,
        }
    }

    fn of(collider: &Collider, number: u32) -> Self {
        Self {
            form: Form::Shape(collider.shape.clone()),
            start: collider.start,
            end: collider.end,
            material: collider.material,
            alone: false,
            layers: collider.layers,
            sensor: collider.sensor,
            events: collider.events,
            party: Party::Collider(number),
        }
    }

    /// Whether it goes anywhere during the step.
    pub(super) fn moves(&self) -> bool {
        self.start != self.end
    }

    /// Whether a body may touch it, as far as layers do not decide.
    pub(super) fn may_touch(&self, filter: &ContactFilter, body: u32) -> bool {
        !matches!(self.party, Party::Collider(number) if !filter.may_touch_collider(body, number))
    }

    /// What becomes of it and of what touches it.
    pub(super) fn grip(&self, other: &Material) -> Grip {
        if self.alone {
            let Material { friction, restitution, .. } = self.material;
            return Grip { friction, restitution, ..Grip::default() };
        }
        self.material.against(other)
    }

    /// Where it is after a share of the step.
    pub(super) fn frame_at(&self, share: f32) -> Frame {
        on_the_way(&self.start, &self.end, share)
    }

    /// How far in a row is, metres, with the surface at rest in a frame.
    pub(super) fn depth(&self, places: &Places, row: u32, frame: &Frame) -> f32 {
        let i = places.at(row);
        match &self.form {
            Form::Plane(plane) => plane.correction(places, row).length(),
            Form::Room(room) => room.correction(places, row).length(),
            Form::Shape(shape) => {
                let at = frame.seen_from(places.origin[i]).local(places.position[i].truncate());
                shape.touch(at, at, places.radius[i]).map_or(0.0, |touched| touched.depth)
            }
        }
    }
}
