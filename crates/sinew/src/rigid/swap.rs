//! Swap between a compound of particles and a rigid body, in both directions and at any time (physics.md M2).
//!
//! # What is conserved, and how
//!
//! The particles are at `pᵢ` with velocities `vᵢ`; their rest positions in the body's frame are `rᵢ`. The body gets
//!
//! ```text
//! M = Σ m        p = Σ m pᵢ / M        v = Σ m vᵢ / M        c = Σ m rᵢ / M        R: the nearest to Σ m (pᵢ - p)(rᵢ - c)ᵀ
//! I = Σ m (s² 1 - s sᵀ),  s = rᵢ - c        L = Σ m (pᵢ - p) × (vᵢ - v)        ω = (R I Rᵀ)⁻¹ L
//! ```
//!
//! and the way back gives `pᵢ = p + R s`, `vᵢ = v + ω × R s`, whose momentum is `M v`, whose angular momentum is `R I Rᵀ ω = L` and whose nearest rotation is
//! `R`. So nothing jumps in either direction, and a swap there and back changes only round-off, provided that the compound was rigid. If it was not, its strain
//! and the non-rigid part of its motion are lost, with their energy; `P` and `L` stay.
//!
//! The inertia is that of the *particles*: eight particles at the corners of a box have three times the inertia of the solid box, and so has the body. It is
//! taken from the rest shape, not from the strained one, so that a second swap finds the same one.
//!
//! **Flat** compounds keep everything. Particles on a **line** have no inertia about it, so neither they nor the body can spin about it: such a spin, set by
//! hand on a body, is lost, and the twist about the line is that of `previous` ([`pose`]). A **single** particle keeps its momentum and `previous`, and does
//! not spin.

use glam::{DMat3, DVec3, Mat3, Quat, Vec3};

use super::principal::Principal;
use super::{RigidBody, RigidFault};
use crate::particles::Particles;
use crate::pose::pose;

impl RigidBody {
    /// The rigid body equivalent to a compound, from the position (metres from `origin`, which is in whole metres), velocity (m/s, true at the instant of the
    /// position) and mass (kg) of each particle, and its rest position in the body's frame, in the same order.
    ///
    /// `previous` is the last known rotation, or the identity; [`pose`] describes when it matters. Particles whose mass is not positive and finite do not
    /// count. Pinned ones are among these: the body is not pinned.
    ///
    /// # Errors
    /// [`RigidFault::Particles`] if the numbers of rest positions and particles differ or no particle counts; the fault of the result if a value is not finite.
    pub fn from_particles(
        origin: Vec3,
        points: impl Iterator<Item = (Vec3, Vec3, f32)> + Clone,
        rest: &[Vec3],
        previous: Quat,
    ) -> Result<Self, RigidFault> {
        if points.clone().count() != rest.len() {
            return Err(RigidFault::Particles);
        }
        let counted = || {
            let all = points.clone().zip(rest);
            let counted = all.filter(|((_, _, m), _)| *m > 0.0 && m.is_finite());
            counted.map(|((p, v, m), r)| (p.as_dvec3(), v.as_dvec3(), r.as_dvec3(), f64::from(m)))
        };
        let mass: f64 = counted().map(|(.., m)| m).sum();
        if mass == 0.0 {
            return Err(RigidFault::Particles);
        }
        let mean = |f: fn((DVec3, DVec3, DVec3, f64)) -> DVec3| {
            counted().map(f).sum::<DVec3>() * (1.0 / mass)
        };
        let (position, velocity) = (mean(|(p, _, _, m)| p * m), mean(|(_, v, _, m)| v * m));
        let centre = mean(|(_, _, r, m)| r * m);
        let (mut moments, mut momentum) = (DMat3::ZERO, DVec3::ZERO);
        for (p, v, r, m) in counted() {
            let s = r - centre;
            moments += DMat3::from_cols(s * s.x, s * s.y, s * s.z) * m;
            momentum += (p - position).cross(v - velocity) * m;
        }
        let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
        let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - moments;
        let points = points.zip(rest).map(|((p, _, m), &r)| (p, r, m));
        let pose = pose(points, previous).ok_or(RigidFault::Position)?;
        let mut body = Self {
            origin,
            rotation: pose.rotation,
            centre: centre.as_vec3(),
            ..Self::new(mass as f32, symmetric(inertia))
        };
        if let Some(fault) = body.fault() {
            return Err(fault);
        }
        // The remaining state uses the rounded centre and the unrounded inertia, so that `place` gives the same means and the same L, and repeated swaps do not
        // accumulate rounding errors.
        let (turn, principal) = (body.turn(), Principal::new(inertia).ok_or(RigidFault::Inertia)?);
        let rate = turn * principal.rate(turn.conjugate() * momentum);
        let off = turn * (body.centre.as_dvec3() - centre);
        body.position = (position + off).as_vec3();
        body.velocity = (velocity + rate.cross(off)).as_vec3();
        body.angular_velocity = rate.as_vec3();
        body.fault().map_or(Ok(body), Err)
    }

    /// The present positions, in metres from `origin`, of the particles with rest positions `rest` (metres, body's frame), and their velocities, m/s, true at
    /// the same instant.
    pub fn place<'a>(
        &self,
        rest: &'a [Vec3],
    ) -> impl ExactSizeIterator<Item = (Vec3, Vec3)> + Clone + use<'a> {
        let (turn, body) = (self.turn(), *self);
        rest.iter().map(move |r| {
            let arm = turn * (r.as_dvec3() - body.centre.as_dvec3());
            let velocity = body.angular_velocity.as_dvec3().cross(arm) + body.velocity.as_dvec3();
            ((body.position.as_dvec3() + arm).as_vec3(), velocity.as_vec3())
        })
    }

    /// The rigid body equivalent to the particles in `rows`, with their velocities at the instant of the positions; otherwise as
    /// [`from_particles`](Self::from_particles). The particles stay in the simulation: the caller removes or pins them.
    ///
    /// # Errors
    /// As `from_particles`; and [`RigidFault::Particles`] for a row that does not exist.
    pub fn from_rows(
        particles: &Particles,
        rows: &[usize],
        rest: &[Vec3],
        previous: Quat,
    ) -> Result<Self, RigidFault> {
        if rows.iter().any(|&i| i >= particles.len()) {
            return Err(RigidFault::Particles);
        }
        let Some(&first) = rows.first() else { return Err(RigidFault::Particles) };
        let origin = particles.origin[first];
        let point = |&i: &usize| {
            (particles.relative_to(i, origin), particles.free_velocity_now(i), particles.mass(i))
        };
        Self::from_particles(origin, rows.iter().map(point), rest, previous)
    }

    /// Writes the body's motion to the particles in `rows`, positions and velocities: the way back. Their masses stay.
    ///
    /// # Errors
    /// [`RigidFault::Particles`] if the numbers of rest positions and rows differ, or a row does not exist; the body's [fault](Self::fault) if it has one. Then
    /// nothing changes.
    pub fn write_rows(
        &self,
        particles: &mut Particles,
        rows: &[usize],
        rest: &[Vec3],
    ) -> Result<(), RigidFault> {
        self.put_rows(particles, (rows, rest), |particles, i, displacement, velocity| {
            particles.displace(i, displacement);
            particles.set_velocity(i, velocity);
        })
    }

    /// [`write_rows`](Self::write_rows) for the step itself: wakes nothing.
    pub(crate) fn write_rows_in_step(
        &self,
        particles: &mut Particles,
        rows: &[usize],
        rest: &[Vec3],
    ) -> Result<(), RigidFault> {
        self.put_rows(particles, (rows, rest), Particles::put)
    }

    fn put_rows(
        &self,
        particles: &mut Particles,
        (rows, rest): (&[usize], &[Vec3]),
        put: impl Fn(&mut Particles, usize, Vec3, Vec3),
    ) -> Result<(), RigidFault> {
        if let Some(fault) = self.fault() {
            return Err(fault);
        }
        if rows.len() != rest.len() || rows.iter().any(|&i| i >= particles.len()) {
            return Err(RigidFault::Particles);
        }
        for (&i, (position, velocity)) in rows.iter().zip(self.place(rest)) {
            // Written as a displacement: a position in world coordinates would lose digits far from zero.
            let displacement = position - particles.relative_to(i, self.origin);
            put(particles, i, displacement, velocity);
        }
        Ok(())
    }
}

/// Rounded to `f32`, with both halves from the same elements, so that it is exactly symmetric.
fn symmetric(m: DMat3) -> Mat3 {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = m.as_mat3().to_cols_array_2d();
    Mat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
}
