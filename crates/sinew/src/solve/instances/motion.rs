//! The Verlet step of eight bodies. Operation by operation the prediction is [`Predict`](crate::integrate::Predict); [`Derive`](crate::integrate::Derive) has
//! its counterpart in `momentum_drift`.

use glam::Vec3;

use super::LaneStorage;
use crate::integrate::loss;
use crate::lanes::{Doubles, LANES, Lanes, Vector, kernel};
use crate::solve::lane_particles::LaneParticles;

impl LaneStorage {
    /// Computes the share of velocity that each particle loses over a substep of `h` seconds, from its damping rate and the lag of its velocity.
    pub(super) fn note_losses(&mut self, h: f32) {
        // Consecutive particles mostly have the same damping, so the last exponential is reused.
        let mut last = (0.0, 0.0);
        let Self { velocity, rate, lost, .. } = self;
        for ((velocity, rate), lost) in velocity.iter().zip(rate).zip(lost) {
            let lags = velocity.fourths();
            let mut exponents = [0.0; LANES];
            for (lane, exponent) in exponents.iter_mut().enumerate() {
                *exponent = rate[lane] * ((lags[lane] + h) * 0.5);
            }
            if exponents == [last.0; LANES] {
                *lost = [last.1; LANES];
                continue;
            }
            for (lost, exponent) in lost.iter_mut().zip(exponents) {
                if exponent != last.0 {
                    last = (exponent, loss(exponent));
                }
                *lost = last.1;
            }
        }
    }
}

kernel!(
    /// Stores the masses as the reciprocals of the inverse masses.
    pub(super) fn note_masses<L: Lanes>(storage: &mut LaneStorage) {
        let LaneStorage { mass, now, .. } = storage;
        mass.resize(now.len(), [0.0; LANES]);
        for (mass, entry) in mass.iter_mut().zip(now) {
            let inverse = L::load(entry.fourths()).widen();
            (L::Doubles::splat(1.0) / inverse).store(mass);
        }
    }
);

kernel!(
    /// Predicts the positions of all bodies after a substep of `h` seconds with the acceleration `a`, m/s².
    pub(super) fn predict_lanes<L: Lanes>(storage: &mut LaneStorage, a: Vec3, h: f32) {
        let prediction = Prediction::<L>::of(a, h);
        let LaneStorage { now, start, velocity, rounding, lost, .. } = storage;
        let columns = now.iter_mut().zip(start).zip(velocity).zip(rounding).zip(lost);
        for ((((now, start), velocity), rounding), lost) in columns {
            let (v, lag) = Vector::of(velocity.load());
            let tau = (lag + prediction.h) * L::splat(0.5);
            velocity.set_fourths(prediction.h);
            start.set_fourths(L::load(now.fourths()));
            prediction.apply((v, tau), now, start, (velocity, rounding), lost);
        }
    }
);

/// The prediction of a substep of `h` seconds with the acceleration `a`, m/s².
#[derive(Clone, Copy)]
pub(super) struct Prediction<L> {
    a: Vector<L>,
    pub(super) h: L,
}

impl<L: Lanes> Prediction<L> {
    #[inline(always)]
    pub(super) fn of(a: Vec3, h: f32) -> Self {
        Self { a: Vector::splat(a), h: L::splat(h) }
    }

    /// Predicts the position of particles with the velocity `v`, m/s, that is accelerated for `tau` seconds. Velocities in the column are not read, and of it
    /// and `start` the fourth numbers are left.
    #[inline(always)]
    pub(super) fn apply(
        self,
        (v, tau): (Vector<L>, L),
        now: &mut LaneParticles,
        start: &mut LaneParticles,
        (velocity, rounding): (&mut LaneParticles, &mut LaneParticles),
        lost: &[f32; LANES],
    ) {
        let (Self { a, h }, zero) = (self, L::zero());
        let (p, w) = Vector::of(now.load::<L>());
        let before = Vector::of(rounding.load::<L>()).0;
        let moves = zero.lt(w);
        let change = a * tau - v * L::load(lost) + before;
        let u = v + change;
        let rounded = change - (u - v);
        start.put(p.with(w));
        rounding.put(rounded.or_else(moves, before).with(zero));
        velocity.put(u.or_else(moves, Vector::new(zero, zero, zero)).with(h));
        now.put((p + u * h).or_else(moves, p).with(w));
    }
}
