//! After the velocities are derived: restitution, drag of surfaces, and contact events.

use glam::Vec3;

use super::super::impact::{ContactParticipant, Impacts};
use super::super::restitution::{ImpactRound, contact_impulse, is_elastic, spreads, threshold};
use super::late::LateContact;
use super::{NormalImpulse, NormalImpulses, ParticleContacts, SurfaceCandidate};
use crate::constraints::PlanarDrag;
use crate::lanes::{Number, Vector};
use crate::particles::{NO_BODY, Particles, Places};

impl ParticleContacts {
    /// Whether rows may have touched something that the broad phase has not foreseen.
    #[inline]
    pub(crate) fn any_late(&self) -> bool {
        self.late.0.any()
    }

    /// Whether there may be velocities to solve after they are derived.
    #[inline]
    pub(crate) fn bounces(&self) -> bool {
        !self.candidates.is_empty() || self.any_late()
    }

    /// Applies restitution and drag to rows that touched something in the substep of `h` seconds.
    ///
    /// The position solve has no restitution: a particle that was projected onto a surface leaves it with the velocity of the correction. So where the approach
    /// speed `a` before the substep was above `2gh`, twice what gravity adds to resting contacts in a substep, the normal velocity becomes `e a` away from the
    /// surface. Taken before the last part of the path, `a` is the speed that the particle had half a substep earlier, and never more than at the surface: `e =
    /// 1` gains no energy. Friction of the added impulse acts on the slip that the position solve has left.
    pub(crate) fn bounce(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        rows: core::ops::Range<u32>,
        h: f32,
    ) {
        for row in rows.clone() {
            for number in self.of(row) {
                let candidate = &self.candidates[number as usize];
                self.bounce_one(places, normal_impulses.at(number), (row, candidate), h);
            }
        }
        self.late.0.each(rows, |row, LateContact { candidate, impulse }| {
            self.bounce_one(places, impulse, (row, candidate), h);
        });
    }

    /// Applies restitution and drag to a contact.
    #[inline]
    fn bounce_one(
        &self,
        places: &mut Places,
        contact: &mut NormalImpulse,
        (row, candidate): (u32, &SurfaceCandidate),
        h: f32,
    ) {
        let depth = core::mem::take(&mut contact.depth);
        contact.pressed = depth / h;
        if depth == 0.0 {
            return;
        }
        let i = places.at(row);
        contact.sum += depth / (places.position[i].w * h);
        if self.surfaces[candidate.surface as usize].sensor {
            return;
        }
        let (coefficient, before, least) = contact.elasticity(candidate, h);
        if is_elastic(coefficient, before.abs(), least).any() {
            contact.bounce(places, row, candidate, h);
        }
        if candidate.drag != PlanarDrag::default() {
            let carried = contact.carried / h;
            let velocity = places.velocity[i].truncate() - carried;
            let across = contact.normal * velocity.dot(contact.normal);
            let lost = candidate.drag.lost_in(h);
            let taken = (velocity - across) * lost[0] + across * lost[1];
            places.velocity[i] -= taken.extend(0.0);
        }
    }

    /// Whether contacts may bounce.
    #[inline]
    pub(in crate::collide) fn any_elastic(&self) -> bool {
        !self.elastic.is_empty() || self.any_late()
    }

    /// Solves the contacts with a restitution again, together with all others. To be called first in a round: in the first one they have just been
    /// [solved](Self::bounce), and those that bounced reach their neighbours.
    pub(in crate::collide) fn bounce_again(
        &self,
        particles: &mut Particles,
        normal_impulses: &mut NormalImpulses,
        round: &mut ImpactRound,
    ) {
        let (h, first) = (round.h, round.is_first());
        let mut places = Places::all(particles);
        let mut again = |contact: &mut NormalImpulse, row, candidate: &SurfaceCandidate| {
            round.next();
            if contact.pressed == 0.0 || !(first || round.reaches([row])) {
                return;
            }
            let gained = if first {
                contact.pressed
            } else {
                contact.bounce(&mut places, row, candidate, h)
            };
            if spreads(contact.elasticity(candidate, h), gained, first).any() {
                round.mark(row);
            }
        };
        for &[row, number] in &self.elastic {
            again(normal_impulses.at(number), row, &self.candidates[number as usize]);
        }
        self.late.0.each(0..u32::MAX, |row, LateContact { candidate, impulse }| {
            let is_sensor = self.surfaces[candidate.surface as usize].sensor;
            if candidate.restitution > 0.0 && !is_sensor {
                again(impulse, row, candidate);
            }
        });
    }

    /// Reports the contacts of a step whose body or surface has events enabled.
    pub(crate) fn report(
        &self,
        particles: &Particles,
        normal_impulses: &mut NormalImpulses,
        impacts: &mut Impacts,
    ) {
        let reported = !self.reported.is_empty();
        if !(reported || self.surfaces.iter().any(|surface| surface.events)) {
            return;
        }
        let mut report = |row: u32, contact: &NormalImpulse, candidate: &SurfaceCandidate| {
            let surface = &self.surfaces[candidate.surface as usize];
            let body = particles.body[row as usize];
            let is_reported = self.reported.get(body as usize) == Some(&true);
            if contact.sum == 0.0 || !(is_reported || surface.events) {
                return;
            }
            let participant = if body == NO_BODY {
                ContactParticipant::Particle(row)
            } else {
                ContactParticipant::Body(body)
            };
            let row = row as usize;
            let point = particles.position(row) - contact.normal * particles.radius[row];
            let impulse = if surface.sensor { 0.0 } else { contact.sum };
            impacts.add(
                [participant, surface.participant],
                point,
                contact.normal,
                impulse,
                surface.sensor,
            );
        };
        for row in 0..particles.len() as u32 {
            for number in self.of(row) {
                report(row, normal_impulses.at(number), &self.candidates[number as usize]);
            }
        }
        self.late.0.each(0..u32::MAX, |row, late| report(row, &late.impulse, &late.candidate));
    }
}

impl NormalImpulse {
    /// Coefficient of restitution, relative normal velocity before the contact and threshold, m/s, in a substep of `h` seconds.
    fn elasticity(&self, candidate: &SurfaceCandidate, h: f32) -> (f32, f32, f32) {
        let before = self.approach - self.carried.dot(self.normal) / h;
        (candidate.restitution, before, threshold(candidate.gravity, h))
    }

    /// Applies restitution to its row in a substep of `h` seconds, and returns what it adds to the velocity along the normal, m/s.
    fn bounce(
        &mut self,
        places: &mut Places,
        row: u32,
        candidate: &SurfaceCandidate,
        h: f32,
    ) -> f32 {
        let i = places.at(row);
        let velocity = places.velocity[i].truncate() - self.carried / h;
        let (by, gained) = contact_impulse::<f32>(
            Vector::splat(self.normal),
            Vector::splat(velocity),
            self.elasticity(candidate, h),
            (candidate.friction, 0.0),
            (1.0, self.pressed),
        );
        places.velocity[i] += Vec3::from(by).extend(0.0);
        self.pressed += gained;
        self.sum += gained / places.position[i].w;
        gained
    }
}
