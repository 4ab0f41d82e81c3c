//! Internal friction of a body: relative motion of its particles is damped, and its rigid motion is kept.
//!
//! A joint without friction never comes to rest: the head of a figure that lies on stairs swings from its neck for minutes, and keeps the whole figure from
//! falling asleep. Air drag would stop that, but would slow every fall too. So the velocities of a body's particles are moved towards those of a rigid body
//! with the same momentum and angular momentum, at the rate `λ` (Müller, Heidelberger, Hennix, Ratcliff, *Position Based Dynamics*, 2007, section 3.5):
//!
//! ```text
//! v ← v + (1 - e^(-λ dt)) (v̄ + ω × (q - q̄) - v)        Σ m v and Σ m q × v stay
//! ```
//!
//! Once a step is enough: the rate is slow compared with the motion within a step.

use core::ops::Range;

use glam::DVec3;

use crate::particles::Particles;
use crate::pose::MomentSums;
use crate::settings::BodySettings;

/// Momentum sums of each body with internal friction. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Damping(Vec<Option<Body>>);

/// The sums of one body.
#[derive(Clone, Debug)]
struct Body {
    /// Its first row, relative to which positions are measured.
    first: usize,
    sums: MomentSums<f64>,
    /// The equivalent rigid motion: barycentre, metres, its velocity, m/s, and the angular velocity, rad/s.
    rigid: [DVec3; 3],
    /// Share of the difference from the rigid motion that is removed.
    share: f64,
}

impl Damping {
    /// Applies a step of `dt` seconds to the particles that are not pinned.
    pub(crate) fn apply(&mut self, particles: &mut Particles, bodies: &[BodySettings], dt: f32) {
        let rate = |body: &BodySettings| {
            if body.damping.is_finite() { body.damping.max(0.0) } else { 0.0 }
        };
        if bodies.iter().all(|body| rate(body) == 0.0) {
            return;
        }
        let Self(damped) = self;
        damped.clear();
        damped.resize(bodies.len(), None);
        let Particles { position, velocity, origin, body, .. } = particles;
        let separation = |row: usize, first: usize| {
            let local = position[row].truncate() - position[first].truncate();
            (local + (origin[row] - origin[first])).as_dvec3()
        };
        for (number, rows) in runs(body) {
            if bodies.get(number).is_none_or(|body| rate(body) == 0.0) {
                continue;
            }
            let mut free = rows.filter(|&row| position[row].w > 0.0).peekable();
            let Some(&first) = free.peek() else { continue };
            let (sums, rigid) = (MomentSums::NONE, [DVec3::ZERO; 3]);
            let fresh = || Body { first, sums, rigid, share: 0.0 };
            let Body { first, sums, .. } = damped[number].get_or_insert_with(fresh);
            for row in free {
                let (arm, v) = (separation(row, *first), velocity[row].truncate().as_dvec3());
                sums.add(1.0 / f64::from(position[row].w), arm.into(), v.into());
            }
        }
        for (body, settings) in damped.iter_mut().zip(bodies) {
            let Some(Body { sums, rigid, share, .. }) = body else { continue };
            if let Some(motion) = sums.rigid_motion(true) {
                *rigid = motion;
                *share = -libm::expm1(-f64::from(rate(settings)) * f64::from(dt));
            }
        }
        for (number, rows) in runs(body) {
            let body = damped.get(number).and_then(Option::as_ref);
            let Some(Body { first, rigid: [centre, shift, turn], share, .. }) = body else {
                continue;
            };
            for row in rows.filter(|&row| *share > 0.0 && position[row].w > 0.0) {
                let arm = separation(row, *first) - centre;
                let change =
                    (shift + turn.cross(arm) - velocity[row].truncate().as_dvec3()) * *share;
                velocity[row] += change.as_vec3().extend(0.0);
            }
        }
    }
}

/// Consecutive rows of one body, with the body's index.
fn runs(body: &[u32]) -> impl Iterator<Item = (usize, Range<usize>)> {
    let mut begin = 0;
    body.chunk_by(|one, next| one == next).map(move |run| {
        let rows = begin..begin + run.len();
        begin = rows.end;
        (run[0] as usize, rows)
    })
}

#[cfg(test)]
mod tests;
