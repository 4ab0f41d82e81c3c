//! After the velocities are derived: restitution as an impulse, the lectures' drags, and what is to be reported.

use super::super::impact::{ContactParticipant, Impacts};
use super::super::restitution::{is_elastic, rebound, threshold};
use super::{NormalImpulses, ParticleContacts};
use crate::constraints::PlanarDrag;
use crate::lanes::Number;
use crate::particles::{NO_BODY, Particles, Places};

impl ParticleContacts {
    /// Whether anything is left to do when the velocities are derived.
    #[inline]
    pub(crate) fn bounces(&self) -> bool {
        !self.candidates.is_empty()
    }

    /// Gives rows that touched something in the substep of `h` seconds the velocity that they bounce off with, and takes off what drags ask.
    ///
    /// Positions know nothing of elasticity: whatever was put on a surface leaves it with the speed that it lacked to get there. So where the speed
    /// of approach `a` before the substep was above `2gh`, which gravity alone gives to what lies still, the velocity along the normal becomes `-e
    /// a`. Taken before the last bit of the way, `a` is what the particle had half a substep earlier, and never more than it has at the surface: `e =
    /// 1` gains nothing.
    pub(crate) fn bounce(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        rows: core::ops::Range<u32>,
        (h, g): (f32, f32),
    ) {
        for row in rows {
            for number in self.of(row) {
                let press = normal_impulses.at(number);
                let depth = core::mem::take(&mut press.depth);
                if depth == 0.0 {
                    continue;
                }
                let i = places.at(row);
                press.sum += depth / (places.position[i].w * h);
                let candidate = &self.candidates[number as usize];
                if self.surfaces[candidate.surface as usize].sensor {
                    continue;
                }
                let (normal, carried) = (press.normal, press.carried / h);
                let approach = press.approach - carried.dot(normal);
                let velocity = places.velocity[i].truncate() - carried;
                let along = velocity.dot(normal);
                if is_elastic(candidate.restitution, -approach, threshold(g, h)).any() {
                    let wanted = rebound(candidate.restitution, approach);
                    places.velocity[i] += (normal * (wanted - along)).extend(0.0);
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

    /// Tells what has touched what in a step, where somebody asked.
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
                let press = normal_impulses.at(number);
                let surface = &self.surfaces[self.candidates[number as usize].surface as usize];
                let body = particles.body[row];
                let asked = self.reported.get(body as usize).is_some_and(|&reported| reported);
                if press.sum == 0.0 || !(asked || surface.events) {
                    continue;
                }
                let participant = if body == NO_BODY {
                    ContactParticipant::Particle(row as u32)
                } else {
                    ContactParticipant::Body(body)
                };
                let point = particles.position(row) - press.normal * particles.radius[row];
                let impulse = if surface.sensor { 0.0 } else { press.sum };
                impacts.add(
                    [participant, surface.participant],
                    point,
                    press.normal,
                    impulse,
                    surface.sensor,
                );
            }
        }
    }
}
