//! Verlet's step for eight bodies: as [`Predict`](crate::integrate::Predict) and [`Derive`](crate::integrate::Derive) have it, operation by
//! operation.

use glam::Vec3;

use super::LaneStorage;
use crate::integrate::loss;
use crate::lanes::{Doubles, LANES, Lanes, Vector, kernel};

impl LaneStorage {
    /// Notes how much velocity is lost over a substep of `h` seconds by particles that had their last step as long ago as they say.
    pub(super) fn note_losses(&mut self, h: f32) {
        // Neighbours mostly share their damping.
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
    /// Notes masses.
    pub(super) fn note_masses<L: Lanes>(storage: &mut LaneStorage) {
        let LaneStorage { mass, now, .. } = storage;
        mass.resize(now.len(), [0.0; LANES]);
        for (mass, spot) in mass.iter_mut().zip(now) {
            let inverse = L::load(spot.fourths()).widen();
            (L::Doubles::splat(1.0) / inverse).store(mass);
        }
    }
);

kernel!(
    /// Predicts where all in a lane storage go in a substep of `h` seconds, accelerated by `a`, m/s².
    pub(super) fn predict_lanes<L: Lanes>(storage: &mut LaneStorage, a: Vec3, h: f32) {
        let (a, h, zero) = (Vector::<L>::splat(a), L::splat(h), L::zero());
        let LaneStorage { now, start, velocity, rounding, lost, .. } = storage;
        let columns = now.iter_mut().zip(start).zip(velocity).zip(rounding).zip(lost);
        for ((((now, start), velocity), rounding), lost) in columns {
            let ((p, w), (v, lag)) =
                (Vector::of(now.load::<L>()), Vector::of(velocity.load::<L>()));
            let before = Vector::of(rounding.load::<L>()).0;
            let moves = zero.lt(w);
            let tau = (lag + h) * L::splat(0.5);
            let change = a * tau - v * L::load(lost) + before;
            let u = v + change;
            let rounded = change - (u - v);
            start.set(p.with(w));
            rounding.put(rounded.or_else(moves, before).with(zero));
            let still = Vector::new(zero, zero, zero);
            velocity.set(u.or_else(moves, still).with(h));
            now.put((p + u * h).or_else(moves, p).with(w));
        }
    }
);
