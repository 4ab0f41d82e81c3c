//! Derives the velocities of eight bodies without the momentum that their corrections must not have added. Operation by operation this is
//! [`MomentumDrift`](crate::solve::momentum) of a single body, done in the same pass as the velocities.

use glam::DVec3;

use super::lane_storage::LaneStorage;
use crate::lanes::{Doubles, LANES, Lanes, SetLanes, Vector, kernel};
use crate::pose::symmetric::{Cofactors, MAX_CONDITION, cofactors};
use crate::pose::{MomentSums, pseudo_solve};
use crate::solve::momentum::{MomentumDrift, WideMomentumDrift};

impl<D: Doubles> WideMomentumDrift<D> {
    /// One bit for each body with a finite drift.
    #[inline(always)]
    fn finite(&self) -> u32 {
        self.centre.finite() & self.shift.finite() & self.turn.finite()
    }

    /// The drifts as arrays in memory.
    #[inline(always)]
    fn bodies(&self) -> DriftLanes {
        let Self { anchor, centre, shift, turn } = self;
        let vectors = [anchor.arrays(), centre.arrays(), shift.arrays(), turn.arrays()];
        DriftLanes { vectors, finite: self.finite() }
    }
}

/// Momentum drifts of eight bodies in memory: anchors, centres, shifts and turns, each as x, y and z.
#[derive(Default)]
pub(super) struct DriftLanes {
    vectors: [[[f64; LANES]; 3]; 4],
    finite: u32,
}

impl DriftLanes {
    /// The finite drifts of the bodies in a mask, with their lanes.
    pub(super) fn each(&self, which: u32) -> impl Iterator<Item = (usize, MomentumDrift)> {
        SetLanes(which & self.finite).map(|lane| {
            let [anchor, centre, shift, turn] =
                self.vectors.each_ref().map(|[x, y, z]| DVec3::new(x[lane], y[lane], z[lane]));
            (lane, MomentumDrift { anchor, centre, shift, turn })
        })
    }
}

kernel!(
    /// Derives the velocities in a lane storage at the end of a substep of `h` seconds. Bodies in the mask `free`, which got no momentum from outside, keep
    /// their linear momentum; those that are in `keeps_angular` too also keep their angular momentum.
    pub(super) fn derive_lanes<L: Lanes>(
        storage: &mut LaneStorage,
        h: f32,
        free: u32,
        keeps_angular: u32,
    ) {
        let momentum_drifts = if free != 0 {
            Some(storage.momentum_drifts::<L>(h, free & keeps_angular))
        } else {
            None
        };
        let per_second = L::splat(1.0 / h);
        let h = L::splat(h);
        let LaneStorage { now, start, velocity, .. } = storage;
        for ((now, start), velocity) in now.iter().zip(start).zip(velocity) {
            let ((q, _), (from, _)) = (Vector::of(now.load::<L>()), Vector::of(start.load()));
            let u = Vector::of(velocity.load::<L>()).0;
            let mut v = u + (q - (from + u * h)) * per_second;
            if let Some(momentum_drifts) = &momentum_drifts {
                let share = momentum_drifts.share(from);
                v = (v - share).or_else(L::mask(free & momentum_drifts.finite()), v);
            }
            velocity.put(v.with(h));
        }
    }
);

kernel!(
    /// Computes the momentum drift of the bodies in the mask `which` after a substep of `h` seconds, with the angular part for those in `turning`. If
    /// `per_particle`, writes the velocity to be removed from each particle, m/s, in place of the velocities in the storage (zero for all other bodies) and
    /// returns an empty result.
    pub(super) fn take_drift<L: Lanes>(
        storage: &mut LaneStorage,
        h: f32,
        turning: u32,
        which: u32,
        per_particle: bool,
    ) -> DriftLanes {
        let momentum_drifts = storage.momentum_drifts::<L>(h, turning);
        if !per_particle {
            return momentum_drifts.bodies();
        }
        let which = L::mask(which & momentum_drifts.finite());
        for (start, velocity) in storage.start.iter().zip(&mut storage.velocity) {
            let share = momentum_drifts.share(Vector::of(start.load::<L>()).0);
            let [x, y, z] = [which.and(share.x), which.and(share.y), which.and(share.z)];
            velocity.put(Vector::new(x, y, z).with(L::zero()));
        }
        DriftLanes::default()
    }
);

impl LaneStorage {
    /// The momentum drift of each body before its velocities are derived; with the angular part for the bodies in `turning`.
    #[inline(always)]
    pub(super) fn momentum_drifts<L: Lanes>(
        &self,
        h: f32,
        turning: u32,
    ) -> WideMomentumDrift<L::Doubles> {
        let per_second = L::splat(1.0 / h);
        let h = L::splat(h);
        let Self { now, start, velocity, mass, .. } = self;
        // A `match`, because a closure is not compiled with the target features of the kernel.
        let anchor = match start.first() {
            None => Vector::double(DVec3::ZERO),
            Some(first) => Vector::of(first.load::<L>()).0.widen(),
        };
        let mut sums = MomentSums::<L::Doubles>::none();
        for (((now, start), velocity), mass) in now.iter().zip(start).zip(velocity).zip(mass) {
            let ((q, _), (from, _)) = (Vector::of(now.load::<L>()), Vector::of(start.load()));
            let u = Vector::of(velocity.load::<L>()).0;
            let v = u + (q - (from + u * h)) * per_second;
            let arm = from.widen() - anchor;
            sums.add(L::Doubles::load(mass), arm, v.widen() - u.widen());
        }
        let (centre, shift, turn) = sums.rigid_motion(turning);
        WideMomentumDrift { anchor, centre, shift, turn }
    }
}

impl<D: Doubles> MomentSums<D> {
    /// Barycentres, velocities and angular velocities. The latter are zero for bodies that are not in `turning`.
    #[inline(always)]
    fn rigid_motion(&self, turning: u32) -> (Vector<D>, Vector<D>, Vector<D>) {
        let [centre, shift] = self.means();
        if turning == 0 {
            return (centre, shift, Vector::double(DVec3::ZERO));
        }
        let (inertia, b) = self.about(centre);
        let Cofactors { x, minors: [first, second, determinant], traces } = cofactors(&inertia, b);
        // The same conditions as in `pose::symmetric::solve`.
        let zero = D::splat(0.0);
        let good = zero.lt(first)
            & zero.lt(second)
            & zero.lt(determinant)
            & traces.le(D::splat(MAX_CONDITION) * determinant);
        let turn = x * (D::splat(1.0) / determinant);
        if good & turning == 0xFF {
            return (centre, shift, turn);
        }
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = inertia;
        let numbers = [xx, yy, zz, xy, yz, xz, b.x, b.y, b.z].map(Doubles::array);
        let turn = [turn.x, turn.y, turn.z].map(Doubles::array);
        let [x, y, z] = solve_singular(turn, &numbers, turning, good);
        (centre, shift, Vector { x: D::load(&x), y: D::load(&y), z: D::load(&z) })
    }
}

/// Solves again, lane by lane, where the inertia is nearly singular. Zero for bodies that are not in `turning`.
#[cold]
fn solve_singular(
    mut turn: [[f64; LANES]; 3],
    numbers: &[[f64; LANES]; 9],
    turning: u32,
    good: u32,
) -> [[f64; LANES]; 3] {
    for lane in SetLanes(0xFF & !(turning & good)) {
        let mut found = DVec3::ZERO;
        if turning >> lane & 1 != 0 {
            let [xx, yy, zz, xy, yz, xz, x, y, z] = numbers.map(|number| number[lane]);
            let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
            found = pseudo_solve(inertia, DVec3::new(x, y, z));
        }
        for (column, number) in turn.iter_mut().zip(found.to_array()) {
            column[lane] = number;
        }
    }
    turn
}
