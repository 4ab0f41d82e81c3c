//! Derives the velocities of eight bodies without the momentum that their corrections must not have added. Operation by operation this is
//! [`MomentumDrift`](crate::solve::momentum) of a single body, done in the same pass as the velocities.

use glam::{DVec3, Vec3};

use super::lane_storage::LaneStorage;
use super::motion::Prediction;
use crate::lanes::{Doubles, LANES, Lanes, SetLanes, Vector, kernel};
use crate::pose::symmetric::{Cofactors, MAX_CONDITION, cofactors};
use crate::pose::{MomentSums, pseudo_solve};
use crate::solve::lane_particles::LaneParticles;
use crate::solve::momentum::{MomentumDrift, RigidDrift, WideMomentumDrift};
use crate::solve::pivot::{PivotDrift, PivotSums};

impl<D: Doubles> WideMomentumDrift<D> {
    /// One bit for each body with a finite drift.
    #[inline(always)]
    fn finite(&self) -> u32 {
        self.centre.finite() & self.shift.finite() & self.turn.finite()
    }

    /// Anchors, centres, shifts and turns in memory.
    #[inline(always)]
    fn vectors(&self) -> [[[f64; LANES]; 3]; 4] {
        let Self { anchor, centre, shift, turn } = self;
        [anchor.arrays(), centre.arrays(), shift.arrays(), turn.arrays()]
    }
}

/// Which of eight bodies keep their momenta in a substep. One bit each.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeepsMomenta {
    /// Their linear momentum, and of these, their angular momentum too.
    pub(super) free: u32,
    pub(super) turning: u32,
    /// Their angular momentum about their pivot.
    pub(super) held: u32,
}

impl KeepsMomenta {
    /// One bit for each body that keeps any.
    pub(super) fn any(self) -> u32 {
        self.free | self.held
    }
}

/// The drifts of eight bodies, and masks of those that they are removed from.
struct LaneDrifts<L: Lanes> {
    free: Option<(WideMomentumDrift<L::Doubles>, L)>,
    held: Option<(PivotDrift<L>, L)>,
}

impl<L: Lanes> LaneDrifts<L> {
    /// From predicted velocities. If any body is held, those of all eight bodies are derived in the same pass.
    #[inline(always)]
    fn of(storage: &mut LaneStorage, h: f32, keeps_momenta: KeepsMomenta) -> Self {
        let KeepsMomenta { free, turning, held } = keeps_momenta;
        let mut drifts = Self { free: None, held: None };
        // Not `then`, because a closure is not compiled with the target features of the kernel.
        if free != 0 {
            let rigid = storage.momentum_drifts::<L>(h, turning);
            let which = L::mask(free & rigid.finite());
            drifts.free = Some((rigid, which));
        }
        if held != 0 {
            drifts.held = Some((storage.derive_about_pivots::<L>(h), L::mask(held)));
        }
        drifts
    }

    /// The derived velocity of particles, without what is to be removed, m/s.
    #[inline(always)]
    fn velocity(
        &self,
        substep: Substep<L>,
        now: &LaneParticles,
        start: &LaneParticles,
        velocity: &LaneParticles,
    ) -> Vector<L> {
        let ((from, w), mut v) = (Vector::of(start.load::<L>()), at(velocity));
        if self.held.is_none() {
            v = substep.derived(at(now), from, v);
        }
        self.removed_from(v, from, w)
    }

    /// A velocity without what is to be removed from particles of inverse mass `w` that were at `from` when the substep began, m/s.
    #[inline(always)]
    fn removed_from(&self, mut v: Vector<L>, from: Vector<L>, w: L) -> Vector<L> {
        if let Some((rigid, which)) = &self.free {
            v = (v - rigid.share(from)).or_else(*which, v);
        }
        if let Some((pivot, which)) = &self.held {
            v -= pivot.share(from, w, *which);
        }
        v
    }
}

/// The drifts of eight bodies in memory: anchors, centres, shifts and turns of free ones, each as x, y and z; anchors and turns of held ones.
#[derive(Default)]
pub(super) struct DriftLanes {
    free: [[[f64; LANES]; 3]; 4],
    held: [[[f32; LANES]; 3]; 2],
    /// One bit for each body that is free, and for each that is held.
    which: [u32; 2],
}

impl DriftLanes {
    /// The drifts of the bodies in a mask, with their lanes.
    pub(super) fn each(&self, which: u32) -> impl Iterator<Item = (usize, MomentumDrift)> {
        let Self { free, held, which: [are_free, are_held] } = self;
        let free = SetLanes(which & are_free).map(|lane| {
            let [anchor, centre, shift, turn] =
                free.each_ref().map(|[x, y, z]| DVec3::new(x[lane], y[lane], z[lane]));
            (lane, MomentumDrift::Free(RigidDrift { anchor, centre, shift, turn }))
        });
        free.chain(SetLanes(which & are_held).map(|lane| {
            let [anchor, turn] =
                held.each_ref().map(|[x, y, z]| Vector::new(x[lane], y[lane], z[lane]));
            (lane, MomentumDrift::Held(PivotDrift { anchor, turn }))
        }))
    }
}

/// Length of a substep, seconds, and its reciprocal.
#[derive(Clone, Copy)]
struct Substep<L> {
    h: L,
    per_second: L,
}

impl<L: Lanes> Substep<L> {
    #[inline(always)]
    fn of(h: f32) -> Self {
        Self { h: L::splat(h), per_second: L::splat(1.0 / h) }
    }

    /// The velocity of particles that were at `from` when the substep began, were predicted with the velocity `u`, and are at `now`, m/s.
    #[inline(always)]
    fn derived(self, now: Vector<L>, from: Vector<L>, u: Vector<L>) -> Vector<L> {
        u + (now - (from + u * self.h)) * self.per_second
    }
}

kernel!(
    /// Derives the velocities in a lane storage at the end of a substep of `h` seconds, without the momenta that corrections must not have added. With `next`
    /// also predicts the next substep, with that acceleration, m/s², while the particles are in registers.
    pub(super) fn derive_lanes<L: Lanes>(
        storage: &mut LaneStorage,
        h: f32,
        keeps_momenta: KeepsMomenta,
        next: Option<Vec3>,
    ) {
        let drifts = LaneDrifts::<L>::of(storage, h, keeps_momenta);
        let LaneStorage { now, start, velocity, rounding, lost, .. } = storage;
        let substep = Substep::of(h);
        let Some(a) = next else {
            for ((now, start), velocity) in now.iter().zip(start).zip(velocity) {
                let v = drifts.velocity(substep, now, start, velocity);
                velocity.put(v.with(substep.h));
            }
            return;
        };
        let prediction = Prediction::<L>::of(a, h);
        let columns = now.iter_mut().zip(start).zip(velocity).zip(rounding).zip(lost);
        for ((((now, start), velocity), rounding), lost) in columns {
            let v = drifts.velocity(substep, now, start, velocity);
            // A velocity lags by the length of its substep.
            prediction.apply((v, prediction.h), now, start, (velocity, rounding), lost);
        }
    }
);

kernel!(
    /// Computes the momentum drift of the bodies that keep any after a substep of `h` seconds. If `per_particle`, writes the velocity to be removed from each
    /// particle, m/s, in place of the velocities in the storage (zero for all other bodies) and returns an empty result.
    pub(super) fn take_drift<L: Lanes>(
        storage: &mut LaneStorage,
        h: f32,
        keeps_momenta: KeepsMomenta,
        per_particle: bool,
    ) -> DriftLanes {
        let drifts = LaneDrifts::<L>::of(storage, h, keeps_momenta);
        let mut lanes = DriftLanes::default();
        if !per_particle {
            if let Some((rigid, which)) = &drifts.free {
                (lanes.free, lanes.which[0]) = (rigid.vectors(), which.bits() & 0xFF);
            }
            if let Some((PivotDrift { anchor, turn }, which)) = &drifts.held {
                for (to, from) in lanes.held.iter_mut().zip([anchor, turn]) {
                    *to = [from.x.array(), from.y.array(), from.z.array()];
                }
                lanes.which[1] = which.bits() & 0xFF;
            }
            return lanes;
        }
        let none = Vector::new(L::zero(), L::zero(), L::zero());
        for (start, velocity) in storage.start.iter().zip(&mut storage.velocity) {
            let (from, w) = Vector::of(start.load::<L>());
            velocity.put((none - drifts.removed_from(none, from, w)).with(L::zero()));
        }
        lanes
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
        let substep = Substep::of(h);
        let Self { now, start, velocity, mass, .. } = self;
        // A `match`, because a closure is not compiled with the target features of the kernel.
        let anchor = match start.first() {
            None => Vector::double(DVec3::ZERO),
            Some(first) => at::<L>(first).widen(),
        };
        let mut sums = MomentSums::<L::Doubles>::none();
        for (((now, start), velocity), mass) in now.iter().zip(start).zip(velocity).zip(mass) {
            let (from, u) = (at(start), at(velocity));
            let v: Vector<L> = substep.derived(at(now), from, u);
            let arm = from.widen() - anchor;
            sums.add(L::Doubles::load(mass), arm, v.widen() - u.widen());
        }
        let (centre, shift, turn) = sums.rigid_motion(turning);
        WideMomentumDrift { anchor, centre, shift, turn }
    }

    /// Derives the velocities. Returns the turn of each body about its pivot that corrections have added to them.
    #[inline(always)]
    fn derive_about_pivots<L: Lanes>(&mut self, h: f32) -> PivotDrift<L> {
        let [one, others @ ..] = self.pivots;
        let mut sums = if others == [one; LANES - 1] {
            let [from, to] = one;
            PivotSums::about(at(&self.start[from as usize]), at(&self.start[to as usize]))
        } else {
            let [from, to] = self.pivot_ends();
            PivotSums::about(at(&from), at(&to))
        };
        let substep = Substep::of(h);
        let Self { now, start, velocity, .. } = self;
        for ((now, start), velocity) in now.iter().zip(start).zip(velocity) {
            let ((from, w), u) = (Vector::of(start.load()), at(velocity));
            let v = substep.derived(at(now), from, u);
            sums.add(w, from, u, v);
            velocity.put(v.with(w));
        }
        sums.drift()
    }

    /// Where the particles of the pivots were when the substep began, lane by lane.
    #[cold]
    fn pivot_ends(&self) -> [LaneParticles; 2] {
        let mut ends = [LaneParticles::ZERO; 2];
        for (lane, pivot) in self.pivots.iter().enumerate() {
            for (end, &i) in ends.iter_mut().zip(pivot) {
                end.copy_lane(lane, &self.start[i as usize], lane);
            }
        }
        ends
    }
}

/// Where a particle of eight bodies is.
#[inline(always)]
fn at<L: Lanes>(lane_particles: &LaneParticles) -> Vector<L> {
    Vector::of(lane_particles.load()).0
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
