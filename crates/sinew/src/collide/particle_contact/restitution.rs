//! After the velocities are derived: restitution, drag of surfaces, and contact events.

use super::super::friction::friction_share;
use super::super::impact::{ContactParticipant, Impacts};
use super::super::restitution::{is_elastic, rebound, threshold};
use super::{NormalImpulses, ParticleContacts};
use crate::constraints::PlanarDrag;
use crate::lanes::Number;
use crate::particles::{NO_BODY, Particles, Places};

impl ParticleContacts {
    /// Whether there may be velocities to solve after they are derived.
    #[inline]
    pub(crate) fn bounces(&self) -> bool {
        !self.candidates.is_empty()
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
        for row in rows {
            for number in self.of(row) {
                let contact = normal_impulses.at(number);
                let depth = core::mem::take(&mut contact.depth);
                if depth == 0.0 {
                    continue;
                }
                let i = places.at(row);
                contact.sum += depth / (places.position[i].w * h);
                let candidate = &self.candidates[number as usize];
                if self.surfaces[candidate.surface as usize].sensor {
                    continue;
                }
                let (normal, carried) = (contact.normal, contact.carried / h);
                let approach = contact.approach - carried.dot(normal);
                let velocity = places.velocity[i].truncate() - carried;
                let along = velocity.dot(normal);
                let least = threshold(candidate.gravity, h);
                if is_elastic(candidate.restitution, -approach, least).any() {
                    let wanted = rebound(candidate.restitution, approach);
                    let (gained, slip) = (wanted - along, velocity - normal * along);
                    let taken = friction_share(slip.length(), candidate.friction * gained);
                    places.velocity[i] += (normal * gained - slip * taken).extend(0.0);
                    contact.sum += gained / places.position[i].w;
                }
                if candidate.drag != PlanarDrag::default() {
                    let across = normal * along;
                    let lost = candidate.drag.lost_in(h);
                    let taken = (velocity - across) * lost[0] + across * lost[1];
                    places.velocity[i] -= taken.extend(0.0);
                }
            }
        }
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
        for row in 0..particles.len() {
            for number in self.of(row as u32) {
                let contact = normal_impulses.at(number);
                let surface = &self.surfaces[self.candidates[number as usize].surface as usize];
                let body = particles.body[row];
                let is_reported = self.reported.get(body as usize) == Some(&true);
                if contact.sum == 0.0 || !(is_reported || surface.events) {
                    continue;
                }
                let participant = if body == NO_BODY {
                    ContactParticipant::Particle(row as u32)
                } else {
                    ContactParticipant::Body(body)
                };
                let point = particles.position(row) - contact.normal * particles.radius[row];
                let impulse = if surface.sensor { 0.0 } else { contact.sum };
                impacts.add(
                    [participant, surface.participant],
                    point,
                    contact.normal,
                    impulse,
                    surface.sensor,
                );
            }
        }
    }
}
