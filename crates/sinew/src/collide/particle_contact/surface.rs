//! What a particle may touch and somebody asks about: colliders, and those planes and boxes that bounce or whose contacts are to be reported.

use super::super::collider::on_the_way;
use super::super::{
    Collider, CombinedMaterial, ContactFilter, ContactParticipant, Frame, Layers, Material, Shape,
};
use crate::constraints::{Boundaries, InsideBox, Plane};
use crate::particles::Places;

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct ContactSurface {
    pub(super) form: SurfaceForm,
    start: Frame,
    /// Where it goes during the step; the same if it does not.
    end: Frame,
    /// Whether it goes anywhere during the step.
    pub(super) moves: bool,
    pub(super) material: Material,
    /// Whether its own coefficients count alone, whatever touches it: so it is of planes and boxes.
    alone: bool,
    pub(super) layers: Layers,
    pub(super) sensor: bool,
    pub(super) events: bool,
    pub(super) participant: ContactParticipant,
}

/// Its geometry.
#[derive(Clone, Debug)]
pub(super) enum SurfaceForm {
    Plane(Plane),
    BoundingBox(InsideBox),
    Shape(Shape),
}

/// Whether a plane or a box is more than a bound: it bounces, or its contacts are to be reported.
pub(super) fn is_asked(restitution: f32, reported: bool) -> bool {
    restitution > 0.0 || reported
}

/// Lists them, valid ones only.
pub(super) fn list(
    boundaries: &Boundaries,
    colliders: &[Collider],
    reported: bool,
    surfaces: &mut Vec<ContactSurface>,
) {
    surfaces.clear();
    for (number, plane) in boundaries.planes.iter().enumerate() {
        if plane.is_valid() && is_asked(plane.restitution, reported) {
            let participant = ContactParticipant::Plane(number as u32);
            let form = SurfaceForm::Plane(*plane);
            surfaces.push(ContactSurface::bound(
                form,
                plane.friction,
                plane.restitution,
                participant,
            ));
        }
    }
    for (number, bounding_box) in boundaries.boxes.iter().enumerate() {
        if bounding_box.is_valid() && is_asked(bounding_box.restitution, reported) {
            let participant = ContactParticipant::Box(number as u32);
            let form = SurfaceForm::BoundingBox(*bounding_box);
            surfaces.push(ContactSurface::bound(
                form,
                bounding_box.friction,
                bounding_box.restitution,
                participant,
            ));
        }
    }
    for (number, collider) in colliders.iter().enumerate() {
        if collider.is_valid() {
            surfaces.push(ContactSurface::of(collider, number as u32));
        }
    }
}

impl ContactSurface {
    fn bound(
        form: SurfaceForm,
        friction: f32,
        restitution: f32,
        participant: ContactParticipant,
    ) -> Self {
        let material = Material::default().with_friction(friction).with_restitution(restitution);
        Self {
            form,
            start: Frame::IDENTITY,
            end: Frame::IDENTITY,
            moves: false,
            material,
            alone: true,
            layers: Layers::new(u32::MAX, u32::MAX),
            sensor: false,
            events: false,
            participant,
        }
    }

    fn of(collider: &Collider, number: u32) -> Self {
        Self {
            form: SurfaceForm::Shape(collider.shape.clone()),
            start: collider.start,
            end: collider.end,
            moves: collider.start != collider.end,
            material: collider.material,
            alone: false,
            layers: collider.layers,
            sensor: collider.sensor,
            events: collider.events,
            participant: ContactParticipant::Collider(number),
        }
    }

    /// Whether a body may touch it, as far as layers do not decide.
    pub(super) fn may_touch(&self, filter: &ContactFilter, body: u32) -> bool {
        !matches!(self.participant, ContactParticipant::Collider(number) if !filter.may_touch_collider(body, number))
    }

    /// What becomes of it and of what touches it.
    pub(super) fn combined_material(&self, other: &Material) -> CombinedMaterial {
        if self.alone {
            let Material { friction, restitution, .. } = self.material;
            return CombinedMaterial { friction, restitution, ..CombinedMaterial::default() };
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
            SurfaceForm::Plane(plane) => plane.correction(places, row).length(),
            SurfaceForm::BoundingBox(bounding_box) => bounding_box.correction(places, row).length(),
            SurfaceForm::Shape(shape) => {
                let at = frame.seen_from(places.origin[i]).local(places.position[i].truncate());
                shape.touch(at, at, places.radius[i]).map_or(0.0, |touched| touched.depth)
            }
        }
    }
}
