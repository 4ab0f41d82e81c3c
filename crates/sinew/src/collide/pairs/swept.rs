//! One pair at a time: those that are fast, and those that are at one place.
//!
//! # Fast pairs
//!
//! With `s` the separation when the substep began and `D` its change, the separation goes along `s + τ D`, `τ` from 0 to 1. Three cases:
//!
//! - it began apart, `‖s‖ ≥ r`: if `‖s + τ D‖ = r` has a root in there, that is where the two first touch, and `n = (s + τ D)/r` is the normal;
//! - it began with an overlap, and comes nearer: `n = s/‖s‖`, so that it cannot get out at the other side;
//! - it moves apart all the time, or passes by: what counts is where it ends, as for slow ones.
//!
//! In the first two it is held on its side of the plane `n · d = r`, as of a wall through the point where they touched. So it is never nearer than
//! `r`, and has lost nothing of its way along the wall but what friction takes.

use glam::{Vec3, Vec4};

use super::super::friction::friction;
use crate::particles::Particles;

/// Two that may touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct SweptPair {
    pub(super) rows: [u32; 2],
    /// What is to be added to the difference of their positions, metres.
    pub(super) offset: Vec3,
    /// Least distance, metres.
    pub(super) reach: f32,
    /// Coefficient of friction.
    pub(super) friction: f32,
}

/// A fast pair that was stopped, and the normal that it was stopped along.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeOfImpact {
    pub(super) pair: SweptPair,
    pub(super) normal: Vec3,
}

/// Below this share of the least distance a separation has no direction.
pub(super) const COINCIDENT: f32 = 1e-6;

impl SweptPair {
    /// Pushes it apart if it must be. Returns the normal, from the second to the first, the overlap along it in metres, and whether it was stopped on
    /// its way.
    pub(super) fn treat(&self, particles: &mut Particles) -> Option<(Vec3, f32, bool)> {
        let ends = self.separation(&particles.position);
        let began = self.separation(&particles.start);
        if !(ends.is_finite() && began.is_finite()) {
            return None;
        }
        let moved = ends - began;
        let stopped = self.first_touch(began, moved);
        let normal = stopped.or_else(|| {
            (ends.length_squared() < self.reach * self.reach).then(|| self.direction(ends))
        })?;
        let overlap = self.reach - normal.dot(ends);
        if overlap <= 0.0 {
            return None;
        }
        let slid = moved - normal * normal.dot(moved);
        let apart = normal * overlap + friction(slid, overlap, self.friction);
        shift(&mut particles.position, self.rows, apart);
        Some((normal, overlap, stopped.is_some()))
    }

    fn separation(&self, places: &[Vec4]) -> Vec3 {
        let [a, b] = self.rows.map(|row| places[row as usize].truncate());
        (a - b) + self.offset
    }

    /// The normal where it first touches on its way, if it comes nearer and does.
    fn first_touch(&self, began: Vec3, moved: Vec3) -> Option<Vec3> {
        let (length, nearing) = (moved.length_squared(), began.dot(moved));
        if nearing >= 0.0 || length < 0.25 * self.reach * self.reach {
            return None;
        }
        let outside = began.length_squared() - self.reach * self.reach;
        if outside <= 0.0 {
            return Some(self.direction(began));
        }
        let root = nearing * nearing - length * outside;
        if root < 0.0 {
            return None;
        }
        // The lesser root in the form that does not subtract what is nearly equal.
        let time = outside / (root.sqrt() - nearing);
        (time <= 1.0).then(|| self.direction(began + moved * time))
    }

    /// A unit vector along a separation. Two at one place go apart along x, y or z, as the sum of their rows leaves 0, 1 or 2 when divided by three,
    /// the one with the lower row upwards.
    fn direction(&self, apart: Vec3) -> Vec3 {
        let length = apart.length();
        if length > COINCIDENT * self.reach {
            return apart / length;
        }
        let [a, b] = self.rows;
        let along = Vec3::AXES[(a % 3 + b % 3) as usize % 3];
        if a < b { along } else { -along }
    }
}

impl TimeOfImpact {
    /// Puts it back on its side, if others have pushed it through.
    pub(super) fn hold(&self, particles: &mut Particles) {
        let short = self.pair.reach - self.normal.dot(self.pair.separation(&particles.position));
        if short > 0.0 {
            shift(&mut particles.position, self.pair.rows, self.normal * short);
        }
    }
}

/// The places of two, to be changed: `[x y z w]`.
fn shift(position: &mut [Vec4], rows: [u32; 2], apart: Vec3) {
    let [a, b] = rows.map(|row| row as usize);
    let (w_a, w_b) = (position[a].w, position[b].w);
    // Two that nothing moves are no pair.
    let each = apart / (w_a + w_b);
    position[a] += (each * w_a).extend(0.0);
    position[b] -= (each * w_b).extend(0.0);
}
