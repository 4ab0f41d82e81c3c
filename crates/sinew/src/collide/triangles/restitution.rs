//! Restitution and friction after the velocities are derived, and contact events.
//!
//! As among [`pairs`](crate::collide::pairs), with contact points in place of particles: the law is that of `collide/restitution`. Each of the four particles
//! gets `kᵢ J` of the impulse `J`.

use glam::Vec3;

use super::super::filter::ContactFilter;
use super::super::impact::{ContactParticipant, Impacts};
use super::super::restitution::{ImpactRound, contact_impulse, spreads, threshold};
use super::participants::TriangleParticipants;
use super::search::TriangleCandidate;
use super::solve::{SubstepState, TriangleContact};
use crate::lanes::{Number, Vector};
use crate::particles::Particles;

/// A contact of four particles.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleHit {
    /// Members of the candidate, and whether they are two edges.
    pub(super) members: ([u32; 4], bool),
    rows: [u32; 4],
    bodies: [u32; 2],
    shares: [f32; 4],
    normal: Vec3,
    /// Midpoint of the two contact points, metres.
    point: Vec3,
    /// Relative normal velocity before the contact, m/s; negative on approach.
    parting: f32,
    /// Sum of the overlaps corrected in this substep, metres.
    pub(super) overlap: f64,
    /// Inverse effective mass `Σ w k²`, 1/kg.
    inverse: f32,
    pub(super) friction: f32,
    restitution: f32,
    /// Total normal impulse on the first feature, N·s; known after [`bounce`](Self::bounce).
    impulse: f32,
    pub(super) reported: bool,
}

impl TriangleHit {
    /// A contact before its first correction in this substep. Velocities are still those that led to it.
    pub(super) fn new(
        participants: &TriangleParticipants,
        filter: &ContactFilter,
        candidate: &TriangleCandidate,
    ) -> Self {
        let bodies = [candidate.four[0], candidate.four[3]].map(|i| participants.body[i as usize]);
        let [one, other] = bodies.map(|body| filter.body(body));
        let combined_material = one.material.against(&other.material);
        Self {
            members: (candidate.four, candidate.edges),
            rows: candidate.four.map(|i| participants.rows[i as usize]),
            bodies,
            shares: [0.0; 4],
            normal: Vec3::ZERO,
            point: Vec3::ZERO,
            parting: 0.0,
            overlap: 0.0,
            inverse: f32::INFINITY,
            friction: combined_material.friction,
            restitution: combined_material.restitution,
            impulse: 0.0,
            reported: one.events || other.events,
        }
    }

    /// Records the current contact geometry, and adds its overlap.
    pub(super) fn record(
        &mut self,
        particles: &Particles,
        state: &SubstepState,
        four: [u32; 4],
        contact: &TriangleContact,
        inverse: f64,
    ) {
        self.shares = contact.way.shares.map(|share| share as f32);
        self.normal = contact.way.normal.as_vec3();
        self.point = state.point(four, &contact.way);
        self.parting = self.velocity(particles).dot(self.normal);
        self.overlap += contact.overlap;
        self.inverse = inverse as f32;
    }

    /// Relative velocity of the two points, m/s.
    fn velocity(&self, particles: &Particles) -> Vec3 {
        let of = |k: usize| particles.velocity(self.rows[k] as usize) * self.shares[k];
        of(0) + of(1) + of(2) + of(3)
    }

    /// Applies restitution and friction.
    pub(super) fn bounce(&mut self, particles: &mut Particles, round: &mut ImpactRound) {
        round.next();
        let is_reached = round.reaches(self.rows);
        if !(is_reached || round.is_first()) {
            return;
        }
        let ImpactRound { h, gravity, .. } = *round;
        let first = round.is_first();
        let (normal, velocity) = (self.normal, self.velocity(particles));
        let least = threshold(gravity.greatest(self.rows), h);
        let elastic = (self.restitution, self.parting, least);
        let pressed = self.overlap as f32 / h;
        if first {
            self.impulse = pressed / self.inverse;
        }
        let limit = if first { self.friction * self.overlap as f32 / h } else { 0.0 };
        let (impulse, gained) = contact_impulse::<f32>(
            Vector::splat(normal),
            Vector::splat(velocity),
            elastic,
            (self.friction, limit),
            (self.inverse, self.impulse * self.inverse),
        );
        self.impulse += gained / self.inverse;
        let impulse = Vec3::from(impulse);
        let spreads = spreads(elastic, gained, !is_reached).any();
        for (&row, share) in self.rows.iter().zip(self.shares) {
            let i = row as usize;
            let by = particles.inverse_mass(i) * share;
            if by != 0.0 {
                particles.velocity[i] += (impulse * by).extend(0.0);
                if spreads {
                    round.mark(row);
                }
            }
        }
    }

    /// Adds its contact event.
    pub(super) fn report(&self, impacts: &mut Impacts) {
        let participants = self.bodies.map(ContactParticipant::Body);
        impacts.add(participants, self.point, self.normal, self.impulse, false);
    }
}
