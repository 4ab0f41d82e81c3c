//! Bulk access: fills many rows before a step and reads them after it, for a caller that keeps the state elsewhere, as an engine does in components. The cost
//! is that of memory access: the arithmetic runs on three axes at once, and unusual values take a slow path.

use core::ops::Range;

use glam::{Vec3, Vec4};

use super::{ParticleFault, ParticleSeed, Particles, snap};

/// The part of a particle's state that a step changes, and so all that must be carried from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParticleState {
    /// Position, metres.
    pub position: Vec3,
    /// What `position` leaves out because `f32` has no digits for it, metres.
    pub remainder: Vec3,
    /// Mean velocity over the last `lag` seconds, m/s.
    pub velocity: Vec3,
    /// Length of the substep over which `velocity` is the mean, seconds, 0 and up; 0 for a velocity that is true now.
    pub lag: f32,
    /// What rounding took from `velocity` when it last changed, m/s: a step adds it to the next change. Zero, the default, loses less than a digit of `f32`.
    pub rounding: Vec3,
}

impl ParticleState {
    /// Why this state is invalid, or `None` if it is valid.
    pub fn fault(&self) -> Option<ParticleFault> {
        let Self { position, remainder, velocity, lag, rounding } = *self;
        let fault = ParticleSeed { remainder, velocity, lag, ..ParticleSeed::at(position) }.fault();
        fault.or((!rounding.is_finite()).then_some(ParticleFault::Velocity))
    }
}

/// Positions beyond this, metres, take the slow path: their sum with [`ROUNDER`] may exceed 2²⁴, from where `f32` has even numbers only.
const FAST_RANGE: f32 = 4_194_304.0;
/// Adding and then subtracting this, 1.5 · 2²³, rounds to whole numbers, because from 2²³ on every `f32` is whole. The factor 1.5 keeps negative numbers in
/// that range.
const ROUNDER: f32 = 12_582_912.0;

impl Particles {
    /// Writes states into the rows from `first` on, and returns how many it wrote: it stops before a state with a [fault](ParticleState::fault), and at the
    /// last row. Masses and all other properties stay.
    ///
    /// Without a `rounding` the rows are bit for bit as [`set`](Self::set) would leave them.
    pub fn load(&mut self, first: usize, states: impl Iterator<Item = ParticleState>) -> usize {
        let xyz = Vec4::new(1.0, 1.0, 1.0, 0.0).cmpgt(Vec4::ZERO);
        let lowest = Vec3::MIN.extend(0.0);
        let rows = from(&mut self.origin, first).iter_mut().zip(from(&mut self.position, first));
        let rows = rows.zip(from(&mut self.start, first)).zip(from(&mut self.velocity, first));
        let rows = rows.zip(from(&mut self.rounding, first));
        let mut count = 0;
        for (((((origin, position), start), velocity), rounding), state) in rows.zip(states) {
            let (p, r) = (state.position.extend(0.0), state.remainder.extend(0.0));
            let (v, lost) = (state.velocity.extend(state.lag), state.rounding.extend(0.0));
            // `snap`, for numbers that are not large.
            let half_up = p + 0.5;
            let nearest = (half_up + ROUNDER) - ROUNDER;
            let above = nearest.cmpgt(half_up);
            let whole = nearest - Vec4::select(above, Vec4::ONE, Vec4::ZERO);
            let local = (p - whole) + r;
            // The fast path applies if the remainder does not reach into the next metre. Non-finite values fail each comparison.
            let within = local + 0.5;
            let ordinary = p.abs().cmplt(Vec4::splat(FAST_RANGE))
                & within.cmpge(Vec4::ZERO)
                & within.cmplt(Vec4::ONE)
                & v.cmpge(lowest)
                & v.cmple(Vec4::MAX)
                & lost.abs().cmple(Vec4::MAX);
            let (whole, local) = if ordinary.all() {
                (whole.truncate(), local)
            } else if let Some((whole, local)) = place_anywhere(p, r, v, lost) {
                (whole, local.extend(0.0))
            } else {
                break;
            };
            *origin = whole;
            *position = Vec4::select(xyz, local, *position);
            *start = *position;
            *velocity = v;
            *rounding = lost;
            count += 1;
        }
        count
    }

    /// A revision that changes with each call that changes a property of a row, or assigns the row to another particle; a clone has a different one. A caller
    /// that keeps the properties elsewhere need not write them again while it is unchanged. Changes by [`load`](Self::load), by steps and by the methods for
    /// positions and velocities do not count.
    pub fn edits(&self) -> u64 {
        self.edits.number()
    }

    /// Records a change of properties that was written to the columns directly.
    pub(crate) fn note_edit(&mut self) {
        self.edits.advance();
    }

    /// The states of some rows, in order; rows that do not exist are left out. [`load`](Self::load) restores them bit for bit.
    pub fn states(&self, rows: Range<usize>) -> impl Iterator<Item = ParticleState> + '_ {
        let rows = rows.start..rows.end.min(self.len());
        let places = self.origin.get(rows.clone()).unwrap_or_default().iter();
        let locals = self.position.get(rows.clone()).unwrap_or_default();
        let velocities = self.velocity.get(rows.clone()).unwrap_or_default();
        let roundings = self.rounding.get(rows).unwrap_or_default();
        let motion = velocities.iter().zip(roundings);
        places.zip(locals).zip(motion).map(|((origin, local), (velocity, rounding))| {
            let (position, remainder) = exact_sum(*origin, *local);
            ParticleState {
                position: position.truncate(),
                remainder: remainder.truncate(),
                velocity: velocity.truncate(),
                lag: velocity.w,
                rounding: rounding.truncate(),
            }
        })
    }

    /// Limits the speed of some rows to `most`, m/s, and appends the limited ones to a list.
    pub(crate) fn limit_speeds(&mut self, rows: Range<usize>, most: f32, limited: &mut Vec<u32>) {
        let first = rows.start as u32;
        for (v, row) in self.velocity[rows].iter_mut().zip(first..) {
            let speed = v.truncate();
            // The square may overflow where the length does not.
            if speed.length_squared() > most * most && speed.is_finite() {
                let size = speed.abs().max_element();
                *v = ((speed / size).normalize() * most).extend(v.w);
                limited.push(row);
            }
        }
    }

    /// The first block of up to 64 rows that are not all [finite](Self::is_finite). Each number times zero is zero if it is finite, and so is the sum of all.
    pub(crate) fn next_broken(&self, among: Range<usize>) -> Option<Range<usize>> {
        const SOME: usize = 64;
        let Range { start, end } = among;
        let mut rows = (start..end).step_by(SOME).map(|row| row..end.min(row + SOME));
        rows.find(|rows| {
            let (position, origin) = (&self.position[rows.clone()], &self.origin[rows.clone()]);
            let all = position.iter().zip(origin).zip(&self.velocity[rows.clone()]);
            let sum = all.fold(Vec4::ZERO, |sum, ((p, origin), v)| {
                sum + ((*p + origin.extend(0.0)) * 0.0 + *p * 0.0) + *v * 0.0
            });
            sum != Vec4::ZERO
        })
    }
}

/// [`place`] for a state off the fast path; `None` if the state is invalid. It takes copies: a variable whose address is taken would be accessed component by
/// component.
#[cold]
fn place_anywhere(p: Vec4, r: Vec4, v: Vec4, lost: Vec4) -> Option<(Vec3, Vec3)> {
    let [position, remainder, velocity, rounding] = [p, r, v, lost].map(Vec4::truncate);
    let state = ParticleState { position, remainder, velocity, lag: v.w, rounding };
    state.fault().is_none().then(|| place(position, remainder))
}

/// The rows of a column from `first` on.
fn from<T>(column: &mut [T], first: usize) -> &mut [T] {
    column.get_mut(first..).unwrap_or_default()
}

/// The position of a particle, and what rounding it left out: Knuth's two-sum, exact whichever of the two is larger. The fourth components mean nothing.
#[inline]
pub(super) fn exact_sum(origin: Vec3, local: Vec4) -> (Vec4, Vec4) {
    let (a, b) = (origin.extend(0.0), local);
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Splits a position into an origin, whole metres, and an offset from it.
#[inline]
pub(super) fn place(position: Vec3, remainder: Vec3) -> (Vec3, Vec3) {
    let whole = snap(position);
    // The remainder may reach into the next metre, where the offset would need one bit more than it has.
    let origin = whole + snap((position - whole) + remainder);
    (origin, (position - origin) + remainder)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions near and far, halves and their neighbours, on both sides of zero.
    fn places() -> Vec<f32> {
        let near = [0.0, 0.3, 0.5, 0.49999997, 0.50000006, 1.5, 2.5, 7.25, 1e-20, 1e-42, 999.4999];
        let far = [4_194_303.5, 4_194_304.0, 4_194_304.5, 8_388_607.5, 1.6e7, 3e9, 1e30, f32::MAX];
        near.iter().chain(&far).flat_map(|&x| [x, -x]).collect()
    }

    #[test]
    fn rows_are_as_if_they_were_set_one_by_one() {
        let places = places();
        for (i, &x) in places.iter().enumerate() {
            for &remainder in &[0.0, 1e-9, -1e-9, 2e-4, -2e-4, 0.25, 0.75, -0.75, 3.0] {
                let (y, z) = (places[(i + 3) % places.len()], places[(i + 8) % places.len()]);
                let state = ParticleState {
                    position: Vec3::new(x, y, z),
                    remainder: Vec3::new(remainder, 0.0, -remainder),
                    velocity: Vec3::new(x, 1.0, -0.0),
                    lag: 0.01,
                    rounding: Vec3::ZERO,
                };
                let ParticleState { position, remainder, velocity, lag, .. } = state;
                let seed = ParticleSeed::at(position).with_mass(3.0);
                let (mut one, mut many) = (Particles::default(), Particles::default());
                one.push(ParticleSeed { remainder, velocity, lag, ..seed }).unwrap();
                many.push(ParticleSeed::at(Vec3::ONE).with_mass(3.0).with_radius(0.1)).unwrap();
                many.rounding[0] += 1.0;
                assert_eq!(many.load(0, [state].into_iter()), 1);
                let bits = |particles: &Particles| {
                    let (p, v) = (particles.position[0], particles.velocity[0]);
                    let start = particles.start[0];
                    [particles.origin[0].extend(0.0), p, start, v]
                        .map(|x| x.to_array().map(f32::to_bits))
                };
                assert_eq!(bits(&one), bits(&many), "{state:?}");
                assert_eq!(many.rounding[0], one.rounding[0]);
                assert_eq!(many.radius(0), 0.1, "properties stay");
                let read = many.states(0..9).next().unwrap();
                assert_eq!(read.position, many.position(0));
                assert_eq!(read.remainder, many.remainder(0));
                assert_eq!((read.velocity, read.lag), (velocity, lag));
            }
        }
    }

    #[test]
    fn loading_stops_before_what_is_no_state() {
        let good = ParticleState { position: Vec3::ONE, ..Default::default() };
        let bad = [
            ParticleState { position: Vec3::NAN, ..good },
            ParticleState { remainder: Vec3::new(0.0, f32::INFINITY, 0.0), ..good },
            ParticleState { velocity: Vec3::new(0.0, 0.0, f32::NEG_INFINITY), ..good },
            ParticleState { lag: f32::NAN, ..good },
            ParticleState { lag: -1.0, ..good },
            ParticleState { rounding: Vec3::new(0.0, f32::NAN, 0.0), ..good },
            ParticleState { rounding: Vec3::NEG_INFINITY, ..good },
        ];
        for bad in bad {
            let mut particles = Particles::default();
            particles.resize(3);
            assert!(bad.fault().is_some() && good.fault().is_none());
            assert_eq!(particles.load(0, [good, bad, good].into_iter()), 1, "{bad:?}");
            assert_eq!(particles.position(0), Vec3::ONE);
            assert_eq!(particles.position(1), Vec3::ZERO);
            assert_eq!(particles.load(2, [good, good].into_iter()), 1, "there is no fourth row");
            assert_eq!(particles.load(7, [good].into_iter()), 0);
            assert_eq!(particles.states(1..7).count(), 2);
            assert_eq!(particles.states(5..7).count(), 0);
        }
    }
}
