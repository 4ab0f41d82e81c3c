//! Triangles of particles: their areas, and what they hand on to their corners.

use glam::{Vec3, Vec4};

use crate::pose::cross;

/// The particles that triangles are made of.
#[derive(Clone, Copy)]
pub(super) struct Sheet<'a> {
    pub(super) position: &'a [Vec4],
    pub(super) origin: &'a [Vec3],
}

impl Sheet<'_> {
    /// Whether all corners of a triangle are rows that exist.
    #[inline(always)]
    pub(super) fn has(&self, [a, b, c]: [u32; 3]) -> bool {
        let len = self.position.len().min(self.origin.len());
        (a as usize) < len && (b as usize) < len && (c as usize) < len
    }

    /// `(p_b - p_a) × (p_c - p_a)`, m²; the fourth number is nothing.
    #[inline(always)]
    pub(super) fn twice_the_area(&self, [a, b, c]: [u32; 3]) -> Vec4 {
        // Not by `map`, which is not inlined and takes as long as all the rest.
        let (a, b, c) = (a as usize, b as usize, c as usize);
        let p = self.position[a];
        let (mut along, mut other) = (self.position[b] - p, self.position[c] - p);
        let [o, ob, oc] = [self.origin[a], self.origin[b], self.origin[c]];
        // What constraints bind together has one origin.
        if o != ob || o != oc {
            along += (ob - o).extend(0.0);
            other += (oc - o).extend(0.0);
        }
        cross(along, other)
    }

    /// Accelerates each corner of a triangle by a force, N, whose fourth number is zero.
    #[inline(always)]
    pub(super) fn add(&self, acceleration: &mut [Vec4], [a, b, c]: [u32; 3], force: Vec4) {
        self.add_at(acceleration, a, force);
        self.add_at(acceleration, b, force);
        self.add_at(acceleration, c, force);
    }

    #[inline(always)]
    fn add_at(&self, acceleration: &mut [Vec4], i: u32, force: Vec4) {
        acceleration[i as usize] += force * self.position[i as usize].w;
    }
}
