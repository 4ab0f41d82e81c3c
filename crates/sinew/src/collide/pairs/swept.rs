//! Scalar solve of one pair at a time: fast pairs and coincident ones.
//!
//! # Fast pairs
//!
//! With `s` the separation at the start of the substep and `D` its change, the separation moves along `s + τ D`, `τ` from 0 to 1. There are three cases:
//!
//! - it starts apart, `‖s‖ ≥ r`: if `‖s + τ D‖ = r` has a root in that interval, it is the time of impact, and `n = (s + τ D)/r` is the normal;
//! - it starts with an overlap and approaches: `n = s/‖s‖`, so that the particles cannot leave on the other side;
//! - it separates all the time, or misses: the separation at the end counts, as for slow pairs.
//!
//! In the first two cases the pair is kept on its side of the plane `n · d = r`, as if by a wall through the point of impact. So it is never closer than `r`,
//! and keeps its motion along the wall except for friction.

use glam::{Vec3, Vec4};

use super::super::friction::friction;
use crate::lanes::Vector;
use crate::particles::Particles;

/// A pair that may touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct SweptPair {
    pub(super) rows: [u32; 2],
    /// Added to the difference of the two positions for their different origins, metres.
    pub(super) offset: Vec3,
    /// Least allowed distance, metres.
    pub(super) reach: f32,
    /// Coefficient of friction.
    pub(super) friction: f32,
}

/// A fast pair that was stopped, and the normal at its time of impact.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeOfImpact {
    pub(super) pair: SweptPair,
    pub(super) normal: Vec3,
}

/// Below this share of the least distance a separation has no direction.
pub(super) const COINCIDENT: f32 = 1e-6;

impl SweptPair {
    /// Pushes the pair apart if it must be. Returns the normal, from the second to the first, the overlap along it in metres, and whether the pair was stopped
    /// at its time of impact.
    pub(super) fn solve(&self, particles: &mut Particles) -> Option<(Vec3, f32, bool)> {
        let ends = self.separation(&particles.position);
        let start = self.separation(&particles.start);
        if !(ends.is_finite() && start.is_finite()) {
            return None;
        }
        let moved = ends - start;
        let stopped = self.first_touch(start, moved);
        let normal = stopped.or_else(|| {
            (ends.length_squared() < self.reach * self.reach).then(|| self.direction(ends))
        })?;
        let overlap = self.reach - normal.dot(ends);
        if overlap <= 0.0 {
            return None;
        }
        let slid = moved - normal * normal.dot(moved);
        let apart =
            normal * overlap + Vec3::from(friction(Vector::from(slid), overlap, self.friction));
        shift(&mut particles.position, self.rows, apart);
        Some((normal, overlap, stopped.is_some()))
    }

    fn separation(&self, places: &[Vec4]) -> Vec3 {
        let [a, b] = self.rows.map(|row| places[row as usize].truncate());
        (a - b) + self.offset
    }

    /// The normal at the time of impact, if the pair approaches and touches.
    fn first_touch(&self, start: Vec3, moved: Vec3) -> Option<Vec3> {
        let (length, nearing) = (moved.length_squared(), start.dot(moved));
        if nearing >= 0.0 || length < 0.25 * self.reach * self.reach {
            return None;
        }
        let outside = start.length_squared() - self.reach * self.reach;
        if outside <= 0.0 {
            return Some(self.direction(start));
        }
        let root = nearing * nearing - length * outside;
        if root < 0.0 {
            return None;
        }
        // The smaller root, in the form without cancellation.
        let time = outside / (root.sqrt() - nearing);
        (time <= 1.0).then(|| self.direction(start + moved * time))
    }

    /// Unit vector along a separation. Coincident particles are separated along x, y or z, as the sum of their rows is 0, 1 or 2 modulo three, the one with the
    /// lower row upwards.
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
    /// Moves the pair back to its side of the plane, if other contacts have pushed it through.
    pub(super) fn enforce(&self, particles: &mut Particles) {
        let short = self.pair.reach - self.normal.dot(self.pair.separation(&particles.position));
        if short > 0.0 {
            shift(&mut particles.position, self.pair.rows, self.normal * short);
        }
    }
}

/// Separates a pair by `apart`, by inverse masses (the `w` of `[x y z w]`).
fn shift(position: &mut [Vec4], rows: [u32; 2], apart: Vec3) {
    let [a, b] = rows.map(|row| row as usize);
    let (w_a, w_b) = (position[a].w, position[b].w);
    // A pair of two pinned particles is never listed.
    let each = apart / (w_a + w_b);
    position[a] += (each * w_a).extend(0.0);
    position[b] -= (each * w_b).extend(0.0);
}
