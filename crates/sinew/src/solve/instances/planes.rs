//! Planes against eight bodies, as [`bounds`](crate::collide) has it of one particle, operation by operation.

use super::LaneStorage;
use crate::constraints::Plane;
use crate::lanes::{LANES, Lanes, Vector, kernel};

kernel!(
    /// Puts all particles of the bodies that are still `going` out of all planes once, with friction; returns the deepest of each body, metres.
    pub(super) fn project_planes<L: Lanes>(
        planes: &[Plane],
        // How much of an overlap is recovered in a substep, metres.
        recover: f32,
        storage: &mut LaneStorage,
        going: u32,
    ) -> [f32; LANES] {
        let (going, mut deepest) = (L::mask(going), L::zero());
        let LaneStorage { now, start, radius, ground, .. } = storage;
        for ((now, start), radius) in now.iter_mut().zip(start).zip(radius) {
            for (plane, ground) in planes.iter().zip(&*ground) {
                let (p, w) = Vector::of(now.load::<L>());
                let normal = Vector::<L>::splat(plane.normal);
                let height = normal.dot(p) + L::load(ground) - L::load(radius);
                let below = height.lt(L::zero()).and(L::zero().lt(w)).and(going);
                if !below.any() {
                    continue;
                }
                let mut out = normal * -height;
                let moved = p - Vector::of(start.load::<L>()).0;
                let mut depth = out.length();
                let deep = L::splat(recover).lt(depth).and(below);
                if deep.any() {
                    let most = L::splat(recover) - out.dot(moved) / depth;
                    let less = out * (most.max(L::zero()) / depth);
                    out = less.or_else(deep.and(most.lt(depth)), out);
                    depth = out.length();
                }
                // Of what is too little to be squared nothing comes.
                let below = below.and(L::zero().lt(depth * depth));
                let moved = moved + out;
                let slid = moved - out * (moved.dot(out) / (depth * depth));
                let distance = slid.length();
                let most = L::splat(plane.friction) * depth;
                let slips = most.lt(distance);
                let slowed = slid * (L::splat(-plane.friction) * depth / distance);
                let back = slowed.or_else(slips, -slid);
                now.put((p + (out + back)).or_else(below, p).with(w));
                deepest = below.and(depth).max(deepest);
            }
        }
        deepest.array()
    }
);
