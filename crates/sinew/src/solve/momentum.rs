//! Conserves the momenta of an island that nothing outside acts on: momentum that its own constraints cannot have added is removed.
//!
//! Constraints among the particles of an island add no momentum in sum. But a correction is rounded to the spacing of positions, 6e-8 m within a metre, which
//! divided by `h` becomes an impulse. At 600 substeps a second that is noise of some 1e-5 m/s which adds up like a random walk, until after a minute a free
//! brick tumbles differently than it should. The true sums are known, so the difference is removed from all particles as the velocity with which a rigid body
//! would respond to it.
//!
//! Verlet conserves the angular momentum `Σ m p × v` with `p` at the start of the substep, and so do corrections along the start of the step
//! ([`GradientAt::StepStart`](crate::GradientAt::StepStart)). Corrections to the nearest point do not: a cube of rods loses its spin as `ω₀/√(1 + 2ω₀²ht)`, and
//! a skin under pressure gains spin out of nothing. This is corrected in the same way, unless [`keep_spin`](crate::SolverSettings::keep_spin) is off, which
//! leaves the lectures' loop as it is.
//!
//! What hangs on one or two pins keeps its angular momentum about these: [`pivot`](super::pivot).

use glam::{DVec3, Vec3, Vec4};

use super::pivot::{PivotDrift, PivotSums};
use crate::integrate::Integrator;
use crate::islands::Island;
use crate::lanes::{Doubles, LANES, Lanes, Number, Vector, kernel};
use crate::particles::Places;
use crate::pose::{MomentSums, pseudo_solve};

/// What the corrections of an island added in sum and that has to be removed.
#[derive(Clone, Copy, Debug)]
pub(super) enum MomentumDrift {
    /// Of an island that nothing holds.
    Free(RigidDrift),
    /// Of one that hangs on a pivot.
    Held(PivotDrift<f32>),
}

/// A rigid motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigidDrift {
    /// Position at the start of the substep of the first of its rows, metres; the barycentre is measured from it.
    pub(super) anchor: DVec3,
    pub(super) centre: DVec3,
    /// Velocity of the barycentre, m/s, and angular velocity, rad/s.
    pub(super) shift: DVec3,
    pub(super) turn: DVec3,
}

impl MomentumDrift {
    /// The drift of an island that has had no contact so far, before its velocities are derived; `None` if something else than a pivot holds it. With
    /// `keeps_angular` it includes angular momentum.
    ///
    /// With `v' = u + (q' - q)/h` ([`integrate`](crate::integrate)) the corrections added the momentum `P = Σ m (v' - u)`, and the angular momentum `L = Σ r ×
    /// m (v' - u)` about the point that `r` is measured from, with `r` at the start of the substep. A rigid body of the same masses responds with `P/M` and
    /// `I⁻¹ (L - r̄ × P)`. Differences of velocities are exact in `f64`, so summing them loses nothing.
    pub(super) fn of(
        places: &Places,
        (island, rows): (&Island, &[u32]),
        h: f32,
        keeps_angular: bool,
    ) -> Option<Self> {
        let per_second = 1.0 / h;
        let velocities = |i: usize| {
            let (q, start) = (places.position[i].truncate(), places.start[i].truncate());
            let u = places.velocity[i].truncate();
            [u, u + (q - (start + u * h)) * per_second]
        };
        if let Some(pivot) = island.pivot.filter(|_| keeps_angular) {
            let [from, to] = pivot.map(|row| places.start[places.at(row)].truncate());
            let mut sums = PivotSums::<f32>::about(Vector::splat(from), Vector::splat(to));
            for i in rows.iter().map(|&row| places.at(row)) {
                let (w, start) = (places.position[i].w, places.start[i].truncate());
                let [predicted, derived] = velocities(i).map(Vector::splat);
                sums.add(w, Vector::splat(start), predicted, derived);
            }
            return Some(Self::Held(sums.drift()));
        }
        let gained = |_, i: usize| {
            let [u, v] = velocities(i);
            v.as_dvec3() - u.as_dvec3()
        };
        Self::of_gains(places, (island, rows), keeps_angular, gained)
    }

    /// The same for the corrections since the particles were at `before`, within the substep, of an island that nothing holds.
    pub(super) fn since(
        places: &Places,
        (island, rows, before): (&Island, &[u32], &[Vec4]),
        h: f32,
        keeps_angular: bool,
    ) -> Option<Self> {
        let per_second = f64::from(1.0 / h);
        let gained = |number: usize, i: usize| {
            let moved = places.position[i].truncate().as_dvec3();
            (moved - before[number].truncate().as_dvec3()) * per_second
        };
        Self::of_gains(places, (island, rows), keeps_angular, gained)
    }

    /// The drift of particles with velocity gains, m/s, given by a function of their number among the rows and their index among the places.
    #[inline(always)]
    fn of_gains(
        places: &Places,
        (island, rows): (&Island, &[u32]),
        keeps_angular: bool,
        gained: impl Fn(usize, usize) -> DVec3,
    ) -> Option<Self> {
        if !island.free {
            return None;
        }
        let anchor = places.start[places.at(*rows.first()?)].truncate().as_dvec3();
        let mut sums = MomentSums::NONE;
        for (number, &row) in rows.iter().enumerate() {
            let i = places.at(row);
            let (w, start) = (places.position[i].w, places.start[i].truncate().as_dvec3());
            sums.add(1.0 / f64::from(w), (start - anchor).into(), gained(number, i).into());
        }
        let [centre, shift, turn] = sums.rigid_motion(keeps_angular)?;
        Some(Self::Free(RigidDrift { anchor, centre, shift, turn }))
    }

    /// Adds the velocity that each particle is to lose when its velocity is derived, m/s.
    pub(super) fn add_to(&self, places: &Places, rows: &[u32], to: &mut [Vec4]) {
        for &row in rows {
            let i = places.at(row);
            to[i] += self.share(places.start[i]).extend(0.0);
        }
    }

    /// Subtracts the drift from the derived velocities.
    pub(super) fn subtract_from(&self, places: &mut Places, rows: &[u32]) {
        for &row in rows {
            let i = places.at(row);
            places.velocity[i] -= self.share(places.start[i]).extend(0.0);
        }
    }

    /// The velocity to be removed from a particle that was at `start` when the substep began, with its inverse mass, m/s.
    fn share(&self, start: Vec4) -> Vec3 {
        match self {
            Self::Free(RigidDrift { anchor, centre, shift, turn }) => {
                let arm = start.truncate().as_dvec3() - anchor - centre;
                (shift + turn.cross(arm)).as_vec3()
            }
            Self::Held(drift) => {
                let all = <f32 as Number>::zero().le(0.0);
                drift.share(Vector::splat(start.truncate()), start.w, all).into()
            }
        }
    }
}

/// The drifts of eight bodies.
pub(super) struct WideMomentumDrift<D> {
    pub(super) anchor: Vector<D>,
    pub(super) centre: Vector<D>,
    pub(super) shift: Vector<D>,
    pub(super) turn: Vector<D>,
}

impl<D: Doubles> WideMomentumDrift<D> {
    /// The same drift in all lanes.
    #[inline(always)]
    pub(super) fn all(one: &RigidDrift) -> Self {
        let RigidDrift { anchor, centre, shift, turn } = *one;
        let all = Vector::double;
        Self { anchor: all(anchor), centre: all(centre), shift: all(shift), turn: all(turn) }
    }

    /// The velocities to be removed from particles that were at `from` when the substep began, m/s.
    #[inline(always)]
    pub(super) fn share<L: Lanes<Doubles = D>>(&self, from: Vector<L>) -> Vector<L> {
        let arm = from.widen() - self.anchor - self.centre;
        let share = self.shift + self.turn.cross(arm);
        Vector::narrow(share)
    }
}

kernel!(
    /// Stores the velocity that each particle of an island is to lose when its velocity is derived, m/s; eight at a time.
    pub(super) fn note_drift<L: Lanes>(
        momentum_drift: &MomentumDrift,
        places: &Places<'_>,
        rows: &[u32],
        // One for each of the places.
        to: &mut [Vec4],
    ) {
        let MomentumDrift::Free(rigid) = momentum_drift else {
            for &row in rows {
                let i = places.at(row);
                to[i] = momentum_drift.share(places.start[i]).extend(0.0);
            }
            return;
        };
        let (eights, others) = rows.as_chunks::<LANES>();
        let all = WideMomentumDrift::all(rigid);
        for eight in eights {
            let at = eight.map(|row| places.at(row) as u32);
            let (from, _) = Vector::of(L::rows(places.start, &at));
            L::put_rows(to, &at, all.share(from).with(L::zero()));
        }
        for &row in others {
            let i = places.at(row);
            to[i] = momentum_drift.share(places.start[i]).extend(0.0);
        }
    }
);

impl MomentSums<f64> {
    /// The barycentre relative to the anchor, metres, and the velocity and angular velocity that a rigid body with these sums would have.
    pub(super) fn rigid_motion(&self, keeps_angular: bool) -> Option<[DVec3; 3]> {
        let means = self.means();
        let turn = if keeps_angular {
            let (inertia, angular) = self.about(means[0]);
            pseudo_solve(inertia, angular.into())
        } else {
            DVec3::ZERO
        };
        let [centre, shift] = means.map(DVec3::from);
        let motion = [centre, shift, turn];
        motion.iter().all(|v| v.is_finite()).then_some(motion)
    }
}

/// Whether an island has constraints, and all of them are between its own particles.
pub(crate) fn keeps_momenta(island: &Island) -> bool {
    // Explicit Euler adds the forces of the substep after the constraints; an explicit rigid body has velocities of its own.
    !island.groups.is_empty()
        && !island.rigid
        && !island.external
        && island.settings.integrator != Integrator::ExplicitEuler
}
