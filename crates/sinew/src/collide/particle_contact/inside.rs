//! Rows that overlap something at the start of a step: spawned inside of it, moved there by a pin, or covered by a moving collider.
//!
//! A particle that is moved out by a length in a substep leaves with the velocity length / h: 40 cm at once are 240 m/s. So the approach of the substep is
//! corrected in full, an overlap from before at a bounded speed, and at the end of the step the velocity gained in that way is removed.

use glam::Vec3;

use super::super::recovery::{MAX_DEPENETRATION, in_substep, recovery};
use super::{ParticleContact, ParticleContacts};
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

    /// Records the rows that overlap something at the start of the step.
    pub(crate) fn note_inside(&mut self, particles: &mut Particles) {
        let mut inside = core::mem::take(&mut self.inside);
        inside.clear();
        let places = Places::all(particles);
        for &row in self.reaches.iter().flat_map(|reach| &self.touching[reach.clone()]) {
            if self.is_excluded(row) || places.position[row as usize].w == 0.0 {
                continue;
            }
            let deepest = self.overlaps(&places, row).max_by(|a, b| a.depth.total_cmp(&b.depth));
            let deep = deepest.filter(|overlap| overlap.depth > self.max_depenetration);
            inside.extend(deep.map(|ParticleContact { normal, .. }| {
                let leaving = places.velocity[row as usize].truncate().dot(normal).max(0.0);
                InsideRow { row, normal, leaving }
            }));
        }
        self.inside = inside;
    }

    /// The overlaps of a row at the start of a step.
    fn overlaps(&self, places: &Places, row: u32) -> impl Iterator<Item = ParticleContact> {
        let bounds = self.bounds.of(self.classes.of(row));
        let bounds = bounds.corrections(places, row).filter_map(ParticleContact::along);
        let surfaces = self.of(row).filter_map(move |number| {
            let number = self.candidates[number as usize].surface as usize;
            let (surface, frame) = (&self.surfaces[number], &self.frames[number]);
            if surface.sensor { None } else { surface.overlap(places, row, frame) }
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
