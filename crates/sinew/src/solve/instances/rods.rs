//! Hard rods and tethers of eight bodies at once.

use glam::Vec4;

use crate::constraints::project_rod;
use crate::lanes::{LANES, Lanes, SetLanes, Vector, kernel};
use crate::solve::lane_particles::LaneParticles;
use crate::solve::plan::instance_batches::InstancedRod;
use crate::solve::rods::{COS_SQUARED, FullCorrection, project, project_from_start};
use crate::solve::tethers::project_tether;

kernel!(
    /// Projects rods once, one after the other. Returns the largest error found in each body, metres, or `worst` if that is larger. Bodies in the mask
    /// `along_start` are corrected along the directions that the rods had at the start of the substep; `START` must be true unless that mask is empty. Bodies
    /// in the mask `inactive` are not swept any more: their lanes may be written with anything.
    pub(super) fn sweep_rods<L: Lanes, const START: bool>(
        rods: &[InstancedRod],
        now: &mut [LaneParticles],
        start: &[LaneParticles],
        along_start: u32,
        inactive: u32,
        worst: [f32; LANES],
    ) -> [f32; LANES] {
        let (along_start, inactive, mut worst) =
            (L::mask(along_start), L::mask(inactive), L::load(&worst));
        for rod in rods {
            let (a, b, rest) = (rod.a as usize, rod.b as usize, L::load(&rod.rest));
            let (one, other) = (now[a].load::<L>(), now[b].load::<L>());
            let (one, other, error, moves) = if START {
                let start = (start[a].load::<L>(), start[b].load::<L>());
                project_from_start(one, other, start, rest, along_start)
            } else {
                project(one, other, rest, FullCorrection)
            };
            now[a].put(one);
            now[b].put(other);
            worst = error.max(worst);
            let moves = moves.or(inactive);
            if !moves.all() {
                worst = L::load(&project_singly(rod, now, L::ALL ^ moves.bits())).max(worst);
            }
        }
        worst.array()
    }
);

/// Projects a rod lane by lane where its ends coincide or are pinned. Returns the errors, metres.
#[cold]
fn project_singly(rod: &InstancedRod, now: &mut [LaneParticles], stuck: u32) -> [f32; LANES] {
    let mut found = [0.0; LANES];
    let (a, b) = (rod.a as usize, rod.b as usize);
    for lane in SetLanes(stuck) {
        let mut pair: [Vec4; 2] = [now[a].lane(lane), now[b].lane(lane)];
        found[lane] = project_rod(&mut pair, 0, 1, rod.rest[lane]);
        now[a].set_lane(lane, pair[0].truncate());
        now[b].set_lane(lane, pair[1].truncate());
    }
    found
}

kernel!(
    /// Projects the particles of the bodies in `going` into the range of their tethers. Returns how far outside the farthest particle of each body was, metres.
    pub(super) fn project_tethers<L: Lanes>(
        now: &mut [LaneParticles],
        // For each particle, the positions of its pins and in `w` the tether lengths.
        tethers: &[Vec<LaneParticles>; 2],
        going: u32,
    ) -> [f32; LANES] {
        let (going, mut worst) = (L::mask(going), L::zero());
        for tethers in tethers {
            for (now, tether) in now.iter_mut().zip(tethers) {
                let ((p, w), pin) = (Vector::of(now.load::<L>()), tether.load());
                let (held, far, out) = project_tether(p, w.and(going), pin, pin[3]);
                if out.any() {
                    now.put(held.with(w));
                    worst = far.max(worst);
                }
            }
        }
        worst.array()
    }
);

kernel!(
    /// Mask of the bodies with a rod that turns so far in this substep that its direction at the start is a poor guess of the direction it needs; the same test
    /// as `turns_too_fast` for a single island.
    pub(super) fn turn_too_fast<L: Lanes>(
        rods: &[InstancedRod],
        now: &[LaneParticles],
        start: &[LaneParticles],
    ) -> u32 {
        let mut fast = L::zero();
        for rod in rods {
            let (now, start) = (between::<L>(now, rod), between::<L>(start, rod));
            let along = now.dot(start);
            let squares = now.length_squared() * start.length_squared();
            let back = along.lt(L::zero());
            let turned = (along * along).lt(L::splat(COS_SQUARED) * squares);
            fast = fast.or(back).or(turned);
        }
        fast.bits()
    }
);

/// The vector from the first particle of a rod to the second.
#[inline(always)]
fn between<L: Lanes>(lane_particles: &[LaneParticles], rod: &InstancedRod) -> Vector<L> {
    let (one, other) = (&lane_particles[rod.a as usize], &lane_particles[rod.b as usize]);
    Vector::of(other.load::<L>()).0 - Vector::of(one.load::<L>()).0
}
