//! What is inside of something when a step begins: spawned there, led there by a pin, or covered by what moved.
//!
//! How far a particle is put out in a substep is how fast it leaves, by the length of that: 40 cm at once are 240 m/s. What it approached by in the substep is
//! stopped exactly; of what it was in before, it is put out at a bounded speed, and at the end of the step it has no more of that than it began with.

use glam::Vec3;

use super::super::recovery::{in_substep, recovery};
use super::{ParticleContact, ParticleContacts};
use crate::particles::{Particles, Places};

/// How much overlap at the beginning of a step may turn into speed, in the same way: what presses on particles leaves as much.
const MAX_DEPENETRATION: (f32, f32) = (20.0, 0.1);

/// A row that is inside of something when a step begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct InsideRow {
    row: u32,
    /// Unit vector out of it.
    normal: Vec3,
    /// How fast it was on its way out, m/s.
    leaving: f32,
}

impl ParticleContacts {
    /// How much overlap is recovered in each substep, metres: for substeps of `h` seconds under gravity of `g` m/s².
    pub(super) fn set_recovery(&mut self, h: f32, g: f32) {
        self.recover = recovery(h, g);
        self.max_depenetration = in_substep(MAX_DEPENETRATION, h, g);
    }

    /// How much of an overlap is recovered in a substep, metres.
    pub(crate) fn recover(&self) -> f32 {
        self.recover
    }

    /// Notes which rows are inside of something.
    pub(crate) fn note_inside(&mut self, particles: &mut Particles) {
        let mut inside = core::mem::take(&mut self.inside);
        inside.clear();
        let places = Places::all(particles);
        for &row in self.reaches.iter().flat_map(|reach| &self.touching[reach.clone()]) {
            if self.is_solid(row) || places.position[row as usize].w == 0.0 {
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

    /// What a row is in when a step begins.
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

    /// Takes off the speed that rows have come out with of what they were in when the step began.
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
