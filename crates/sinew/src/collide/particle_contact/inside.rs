//! Rows that overlap something at the start of a step: spawned inside of it, moved there by a pin, or covered by a moving collider.
//!
//! A particle that is moved out by a length in a substep leaves with the velocity length / h: 40 cm at once are 240 m/s. So the approach of the substep is
//! corrected in full, an overlap from before at a bounded speed, and at the end of the step the velocity gained in that way is removed.

use glam::Vec3;

use super::super::recovery::{MAX_DEPENETRATION, in_substep, recovery};
use super::super::restitution::{is_elastic, threshold};
use super::{ParticleContact, ParticleContacts, SurfaceCandidate};
use crate::lanes::Number;
use crate::particles::{Particles, Places};

/// A row that overlaps something at the start of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct InsideRow {
    row: u32,
    /// Unit vector out of it.
    normal: Vec3,
    /// Its velocity along the normal at that time, m/s, 0 if it moved inwards.
    leaving: f32,
}

impl ParticleContacts {
    /// Sets the depenetration limits for substeps of `h` seconds under gravity of `g` m/s².
    pub(super) fn set_recovery(&mut self, h: f32, g: f32) {
        self.recover = recovery(h, g);
        self.max_depenetration = in_substep(MAX_DEPENETRATION, h, g);
    }

    /// Maximum depenetration in a substep, metres.
    pub(crate) fn recover(&self) -> f32 {
        self.recover
    }

    /// Records the rows that overlap something at the start of a step of substeps of `h` seconds, apart from those that bounce off it: that sets their velocity,
    /// whatever the recovery has made of it. A particle that another one has just pushed into a wall lost all of its velocity otherwise.
    pub(crate) fn note_inside(&mut self, particles: &mut Particles, h: f32) {
        let mut inside = core::mem::take(&mut self.inside);
        inside.clear();
        let places = Places::all(particles);
        for &row in self.reaches.iter().flat_map(|reach| &self.touching[reach.clone()]) {
            if self.is_excluded(row) || places.position[row as usize].w == 0.0 {
                continue;
            }
            let deepest =
                self.overlaps(&places, row).max_by(|a, b| a.0.depth.total_cmp(&b.0.depth));
            let deep = deepest.filter(|(overlap, _)| overlap.depth > self.max_depenetration);
            let Some((ParticleContact { normal, .. }, candidate)) = deep else { continue };
            let normal = Vec3::from(normal);
            let along = places.velocity[row as usize].truncate().dot(normal);
            let bounces = |candidate: &SurfaceCandidate| {
                let least = threshold(candidate.gravity, h);
                is_elastic(candidate.restitution, along.abs(), least).any()
            };
            if !candidate.is_some_and(bounces) {
                inside.push(InsideRow { row, normal, leaving: along.max(0.0) });
            }
        }
        self.inside = inside;
    }

    /// The overlaps of a row at the start of a step, those with surfaces with their candidate.
    fn overlaps(
        &self,
        places: &Places,
        row: u32,
    ) -> impl Iterator<Item = (ParticleContact, Option<&SurfaceCandidate>)> {
        let bounds = self.bounds.of(self.classes.of(row));
        let bounds = bounds.corrections(places, row).filter_map(ParticleContact::along);
        let bounds = bounds.map(|overlap| (overlap, None));
        let surfaces = self.of(row).filter_map(move |number| {
            let candidate = &self.candidates[number as usize];
            let number = candidate.surface as usize;
            let (surface, frame) = (&self.surfaces[number], &self.frames[number]);
            let face = self.face_of(candidate);
            let overlap = (!surface.sensor).then(|| surface.overlap(places, row, frame, face));
            overlap.flatten().map(|overlap| (overlap, Some(candidate)))
        });
        bounds.chain(surfaces)
    }

    /// Removes the velocity that rows gained from the recovery of overlaps from before the step.
    pub(crate) fn take_off_recovery(&self, particles: &mut Particles) {
        for &InsideRow { row, normal, leaving } in &self.inside {
            let velocity = &mut particles.velocity[row as usize];
            let gained = velocity.truncate().dot(normal) - leaving;
            if gained > 0.0 {
                *velocity -= (normal * gained).extend(0.0);
            }
        }
    }
}
