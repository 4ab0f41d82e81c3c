//! Contact surfaces: colliders, and planes and boxes with more than friction (restitution, drag, events), which take part in the broad phase. Planes and boxes
//! without are plain bounds. Each body class is classified separately, so that the trajectory of a body does not depend on the settings of others.

use super::super::body_classes::{BodyClass, BodyClasses};
use super::super::bounds::{Bounds, PlaneOrBox, Spheres};
use super::super::collider::{Collider, interpolate_frame};
use super::super::filter::ContactFilter;
use super::super::frame::Frame;
use super::super::impact::ContactParticipant;
use super::super::material::{CombinedMaterial, Layers, Material};
use super::super::shape::{LocalFace, Reachable, Shape};
use super::super::world::World;
use super::ParticleContact;
use crate::constraints::{InsideBox, PlanarDrag, Plane};
use crate::particles::{Particles, Places};

/// A contact surface.
#[derive(Clone, Debug)]
pub(super) struct ContactSurface {
    pub(super) form: SurfaceForm,
    start: Frame,
    /// Pose at the end of the step; equal to `start` if it does not move.
    end: Frame,
    /// Whether it moves during the step.
    pub(super) moves: bool,
    pub(super) material: Material,
    /// Whether its own coefficients apply alone, as those of planes and boxes do, and not combined with those of the body.
    alone: bool,
    pub(super) layers: Layers,
    pub(super) sensor: bool,
    pub(super) events: bool,
    pub(super) participant: ContactParticipant,
}

/// Geometry of a surface.
#[derive(Clone, Debug)]
pub(super) enum SurfaceForm {
    Plane(Plane),
    BoundingBox(InsideBox),
    Shape(Shape),
}

/// Lists the valid surfaces. What only bounds a body class goes to `bounds`, everything else to `surfaces`, with the combined material of each surface and each
/// class, surface by surface; `None` where a class does not collide with it, or collides with it as a plain bound.
pub(super) fn list(
    world: &World,
    classes: &BodyClasses,
    bounds: &mut Bounds,
    surfaces: &mut Vec<ContactSurface>,
    materials: &mut Vec<Option<CombinedMaterial>>,
) {
    let World { boundaries, colliders, filter, .. } = *world;
    bounds.begin(boundaries, classes.all().len());
    surfaces.clear();
    materials.clear();
    let mut add = |surface: ContactSurface, bound: Option<PlaneOrBox>| {
        let combined = |class: &BodyClass| {
            let applies = surface.layers.interacts_with(class.layers);
            applies.then(|| surface.combined_material(&class.material))
        };
        let is_bound = |class: &BodyClass, material: &CombinedMaterial| {
            let CombinedMaterial { restitution, drag, .. } = *material;
            let quiet = restitution <= 0.0 && drag == PlanarDrag::default();
            bound.is_some() && quiet && !class.events
        };
        if let Some(bound) = bound {
            bounds.add(bound, |number| {
                let class = &classes.all()[number];
                let material = combined(class).filter(|material| is_bound(class, material))?;
                Some(material.friction)
            });
        }
        let first = materials.len();
        materials.extend(
            classes
                .all()
                .iter()
                .map(|class| combined(class).filter(|material| !is_bound(class, material))),
        );
        if materials[first..].iter().any(Option::is_some) {
            surfaces.push(surface);
        } else {
            materials.truncate(first);
        }
    };
    for (number, plane) in boundaries.planes.iter().enumerate() {
        if plane.is_valid() {
            let (form, participant) =
                (SurfaceForm::Plane(*plane), ContactParticipant::Plane(number as u32));
            let coefficients = (plane.friction, plane.restitution);
            let surface = ContactSurface::bound(form, coefficients, participant);
            add(surface, Some(PlaneOrBox::Plane(*plane)));
        }
    }
    for (number, room) in boundaries.boxes.iter().enumerate() {
        if room.is_valid() {
            let (form, participant) =
                (SurfaceForm::BoundingBox(*room), ContactParticipant::Box(number as u32));
            let surface =
                ContactSurface::bound(form, (room.friction, room.restitution), participant);
            add(surface, Some(PlaneOrBox::Box(*room)));
        }
    }
    for (number, collider) in colliders.iter().enumerate() {
        if collider.is_valid() {
            let number = number as u32;
            let needs_surface =
                collider.sensor || collider.events || filter.ignores_collider(number);
            let bound = if needs_surface { None } else { PlaneOrBox::of(collider) };
            add(ContactSurface::of(collider, number), bound);
        }
    }
}

impl ContactSurface {
    fn bound(
        form: SurfaceForm,
        (friction, restitution): (f32, f32),
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

    /// Whether some body ignores it.
    pub(super) fn is_ignored(&self, filter: &ContactFilter) -> bool {
        matches!(self.participant, ContactParticipant::Collider(number) if filter.ignores_collider(number))
    }

    /// Whether a body may touch it, apart from layers.
    pub(super) fn may_touch(&self, filter: &ContactFilter, body: u32) -> bool {
        !matches!(self.participant, ContactParticipant::Collider(number) if !filter.may_touch_collider(body, number))
    }

    /// Combined material of this surface and another one.
    pub(super) fn combined_material(&self, other: &Material) -> CombinedMaterial {
        if self.alone {
            let Material { friction, restitution, .. } = self.material;
            return CombinedMaterial { friction, restitution, ..CombinedMaterial::default() };
        }
        self.material.against(other)
    }

    /// Its pose at a fraction of the step.
    pub(super) fn frame_at(&self, share: f32) -> Frame {
        interpolate_frame(&self.start, &self.end, share)
    }

    /// What a row may meet of it while it moves by up to `way` metres. `frame` is its pose; of what moves itself, a row may meet any part.
    pub(super) fn reachable(
        &self,
        frame: &Frame,
        particles: &Particles,
        (row, way): (usize, f32),
    ) -> Reachable {
        match &self.form {
            SurfaceForm::Shape(shape) if !self.moves => {
                let frame = frame.seen_from(particles.origin[row]);
                let at = frame.local(particles.position[row].truncate());
                shape.reachable(at, way, particles.radius[row])
            }
            _ => Reachable::Several,
        }
    }

    /// Overlap of a row with the surface at rest in a pose, if there is one. `face` is the only face that the row may meet, if there is one.
    pub(super) fn overlap(
        &self,
        places: &Places,
        row: u32,
        frame: &Frame,
        face: Option<&LocalFace>,
    ) -> Option<ParticleContact> {
        let i = places.at(row);
        match &self.form {
            SurfaceForm::Plane(plane) => {
                ParticleContact::along(Spheres::of(places, row).plane_correction(plane).into())
            }
            SurfaceForm::BoundingBox(room) => {
                ParticleContact::along(Spheres::of(places, row).box_correction(room).into())
            }
            SurfaceForm::Shape(shape) => {
                let at = frame.seen_from(places.origin[i]).local(places.position[i].truncate());
                let touched = shape.touch_at(face, (at, at, places.radius[i]))?;
                Some(ParticleContact::of(&touched, at, [frame; 2], false))
            }
        }
    }
}
