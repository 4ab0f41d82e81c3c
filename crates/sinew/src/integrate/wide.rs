//! The Verlet step, two particles at a time in their memory layout. It runs in every substep of every world and is bound by memory.

use core::ops::Range;

use glam::{Vec3, Vec4};

use crate::lanes::{Lanes, Work};
use crate::particles::{Particles, Places};

/// The prediction of some consecutive particles. All columns have the same length.
pub(crate) struct Predict<'a> {
    pub(crate) position: &'a mut [Vec4],
    pub(crate) start: &'a mut [Vec4],
    pub(crate) velocity: &'a mut [Vec4],
    pub(crate) motion: MotionColumns<'a>,
    /// Length of the substep, seconds.
    pub(crate) h: f32,
}

/// Derives the velocities of some consecutive particles from the positions that the constraints left.
pub(crate) struct Derive<'a> {
    pub(crate) position: &'a [Vec4],
    pub(crate) start: &'a [Vec4],
    pub(crate) velocity: &'a mut [Vec4],
    /// Velocity to be removed from each particle, m/s; empty for none.
    pub(crate) momentum_drift: &'a [Vec4],
    /// Length of the substep, seconds.
    pub(crate) h: f32,
    /// The lag that the velocities get: the time over which they are means, seconds.
    pub(crate) lag: f32,
}

/// What a prediction needs of some consecutive particles beside their positions and velocities. All columns have the same length, but `acceleration`,
/// `damping`, `medium` and `drift` may be empty for zeros, and `damping` may have a single number for all.
pub(crate) struct MotionColumns<'a> {
    pub(crate) rounding: &'a mut [Vec4],
    pub(crate) acceleration: &'a [Vec4],
    pub(crate) damping: &'a [f32],
    pub(crate) medium: &'a [f32],
    pub(crate) drift: &'a [Vec3],
    /// Acceleration that is added to that of every particle, m/s².
    pub(crate) uniform_acceleration: Vec4,
    /// Damping rate that is added to that of every particle, 1/s.
    pub(crate) uniform_damping: f32,
}

impl<'a> MotionColumns<'a> {
    /// The columns of all particles of a world, with their places.
    pub(crate) fn all(particles: &'a mut Particles) -> (Places<'a>, Self) {
        let Particles { position, start, origin, radius, velocity, rounding, .. } = particles;
        let damping = match &particles.column_summary.damping {
            Some(all) => core::slice::from_ref(all),
            None => &particles.damping,
        };
        let motion = Self {
            rounding,
            acceleration: if particles.acceleration_dirty { &particles.acceleration } else { &[] },
            damping,
            medium: if particles.medium_dirty { &particles.medium } else { &[] },
            drift: &particles.drift,
            uniform_acceleration: particles.uniform_acceleration.extend(0.0),
            uniform_damping: particles.uniform_damping,
        };
        (Places { first: 0, position, start, origin, radius, velocity }, motion)
    }

    /// Splits before a row.
    pub(crate) fn split_at(self, row: usize) -> (Self, Self) {
        let (rounding, roundings) = self.rounding.split_at_mut(row);
        let (own, others) = (0..row, row..row + roundings.len());
        let of = MotionColumns { rounding: &mut [], ..self };
        (Self { rounding, ..of.columns(own) }, Self { rounding: roundings, ..of.columns(others) })
    }

    /// All columns but the rounding, for some rows.
    #[inline(always)]
    fn columns(&self, rows: Range<usize>) -> Self {
        Self {
            rounding: &mut [],
            acceleration: self.acceleration.get(rows.clone()).unwrap_or_default(),
            damping: if self.damping.len() < 2 {
                self.damping
            } else {
                &self.damping[rows.clone()]
            },
            medium: self.medium.get(rows.clone()).unwrap_or_default(),
            drift: self.drift.get(rows).unwrap_or_default(),
            ..*self
        }
    }

    /// Reborrows some rows.
    #[inline(always)]
    fn some(&mut self, rows: Range<usize>) -> MotionColumns<'_> {
        let others = self.columns(rows.clone());
        MotionColumns { rounding: &mut self.rounding[rows], ..others }
    }

    /// Reborrows all rows.
    pub(crate) fn reborrow(&mut self) -> MotionColumns<'_> {
        MotionColumns { rounding: self.rounding, ..*self }
    }

    /// The prediction of some of its rows over `h` seconds. The other columns begin with the same row.
    #[inline(always)]
    pub(crate) fn predict<'b>(
        &'b mut self,
        [position, start, velocity]: [&'b mut [Vec4]; 3],
        rows: Range<usize>,
        h: f32,
    ) -> Predict<'b> {
        Predict {
            position: &mut position[rows.clone()],
            start: &mut start[rows.clone()],
            velocity: &mut velocity[rows.clone()],
            motion: self.some(rows),
            h,
        }
    }
}

impl Predict<'_> {
    /// Reborrows some of them.
    pub(crate) fn slice(&mut self, rows: Range<usize>) -> Predict<'_> {
        let Self { position, start, velocity, motion, h } = self;
        motion.predict([position, start, velocity], rows, *h)
    }

    /// Splits into chunks of an even number of particles.
    pub(crate) fn chunks(self, of: usize) -> impl Iterator<Item = Self> {
        let Self { position, start, velocity, motion, h } = self;
        let columns =
            position.chunks_mut(of).zip(start.chunks_mut(of)).zip(velocity.chunks_mut(of));
        let mut left = Some(motion);
        columns.filter_map(move |((position, start), velocity)| {
            let (motion, others) = left.take()?.split_at(position.len());
            left = Some(others);
            Some(Self { position, start, velocity, motion, h })
        })
    }
}

impl<'a> Derive<'a> {
    /// Splits into chunks of an even number of particles.
    pub(super) fn chunks(self, of: usize) -> impl Iterator<Item = Self> {
        let columns = self.position.chunks(of).zip(self.start.chunks(of));
        let columns = columns.zip(self.velocity.chunks_mut(of));
        columns.enumerate().map(move |(number, ((position, start), velocity))| {
            let rows = number * of..number * of + position.len();
            let momentum_drift = self.momentum_drift.get(rows).unwrap_or_default();
            Self { position, start, velocity, momentum_drift, ..self }
        })
    }

    #[cfg(test)]
    /// All particles of a world, after a substep of `h` seconds.
    pub(super) fn all(particles: &'a mut Particles, h: f32, lag: f32) -> Self {
        let Particles { position, start, velocity, .. } = particles;
        Self { position, start, velocity, momentum_drift: &[], h, lag }
    }
}

impl Work for Predict<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { position, start, velocity, motion, h } = self;
        let MotionColumns {
            rounding,
            acceleration,
            damping,
            medium,
            drift,
            uniform_acceleration,
            uniform_damping,
        } = motion;
        let rates = Rates { damping, medium, uniform_damping };
        let mut step = Step {
            uniform_acceleration: L::two(&[uniform_acceleration; 2], 0),
            h,
            steady: rates.same().map_or(f32::NAN, |rate| loss(rate * h)),
            last: (0.0, 0.0),
            rates,
            drift,
        };
        let count = position.len();
        let (positions, last_position) = position.as_chunks_mut::<2>();
        let (starts, last_start) = start.as_chunks_mut::<2>();
        let (velocities, last_velocity) = velocity.as_chunks_mut::<2>();
        let (roundings, last_rounding) = rounding.as_chunks_mut::<2>();
        let (accelerations, last_acceleration) = acceleration.as_chunks::<2>();
        let columns = positions.iter_mut().zip(starts).zip(velocities).zip(roundings);
        for (i, (((p, start), v), rounding)) in columns.enumerate() {
            step.step_two([p, start, v, rounding], accelerations.get(i), 2 * i);
        }
        // An odd particle is paired with a pinned one at zero.
        if let ([p], [s], [v], [r]) = (last_position, last_start, last_velocity, last_rounding) {
            let mut two = [*p, *s, *v, *r].map(|column| [column, Vec4::ZERO]);
            let a = last_acceleration.first().map(|&a| [a, Vec4::ZERO]);
            step.step_two(two.each_mut(), a.as_ref(), count - 1);
            [*p, *s, *v, *r] = two.map(|[own, _]| own);
        }
    }
}

impl Work for Derive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { position, start, velocity, momentum_drift, h, lag } = self;
        let (positions, last_position) = position.as_chunks::<2>();
        let (starts, last_start) = start.as_chunks::<2>();
        let (velocities, last_velocity) = velocity.as_chunks_mut::<2>();
        let (excesses, last_excess) = momentum_drift.as_chunks::<2>();
        for (i, ((p, s), v)) in positions.iter().zip(starts).zip(velocities).enumerate() {
            derive_two::<L>([p, s], v, excesses.get(i), (h, lag));
        }
        if let ([p], [s], [v]) = (last_position, last_start, last_velocity) {
            let [p, s] = [p, s].map(|own| [*own, Vec4::ZERO]);
            let momentum_drift =
                last_excess.first().map(|&momentum_drift| [momentum_drift, Vec4::ZERO]);
            let mut velocity = [*v, Vec4::ZERO];
            derive_two::<L>([&p, &s], &mut velocity, momentum_drift.as_ref(), (h, lag));
            *v = velocity[0];
        }
    }
}

#[inline(always)]
fn derive_two<L: Lanes>(
    [p, start]: [&[Vec4; 2]; 2],
    v: &mut [Vec4; 2],
    momentum_drift: Option<&[Vec4; 2]>,
    (h, lag): (f32, f32),
) {
    let u = L::two(v, 0);
    let predicted = L::two(start, 0) + u * L::splat(h);
    let corrected = L::two(p, 0) - predicted;
    let mut derived = u + corrected * L::splat(1.0 / h);
    if let Some(momentum_drift) = momentum_drift {
        derived = derived - L::two(momentum_drift, 0);
    }
    derived.with_fourths(L::splat(lag)).put_two(v, 0);
}

/// What is the same in the steps of all particles.
struct Step<'a, L> {
    uniform_acceleration: L,
    h: f32,
    rates: Rates<'a>,
    /// The share of velocity that is lost over a whole substep where all have the same damping; NaN where they differ.
    steady: f32,
    /// The last exponent, and the loss for it: consecutive particles mostly have the same damping.
    last: (f32, f32),
    drift: &'a [Vec3],
}

impl<L: Lanes> Step<'_, L> {
    /// Moves particles `i` and `i + 1`. The columns are position, start, velocity, rounding.
    #[inline(always)]
    fn step_two(
        &mut self,
        columns: [&mut [Vec4; 2]; 4],
        acceleration: Option<&[Vec4; 2]>,
        i: usize,
    ) {
        let [position, start, velocity, rounding] = columns;
        let p = L::two(position, 0);
        let moves = L::zero().lt(p.fourths());
        let v = L::two(velocity, 0);
        let tau = (v.fourths() + L::splat(self.h)) * L::splat(0.5);
        let a = match acceleration {
            Some(a) => L::two(a, 0) + self.uniform_acceleration,
            None => self.uniform_acceleration,
        };
        let before = L::two(rounding, 0);
        let lags = [velocity[0].w, velocity[1].w];
        // One by one, because comparing arrays is compiled to a call.
        let lost = if lags[0] == self.h && lags[1] == self.h && !self.steady.is_nan() {
            L::splat(self.steady)
        } else {
            let [one, other] = self.lost(lags, i);
            L::two(&[Vec4::splat(one), Vec4::splat(other)], 0)
        };
        let slip = match self.drift.get(i..) {
            Some(drift @ [_, ..]) if drift.iter().take(2).any(|&drift| drift != Vec3::ZERO) => {
                let [one, other] = self.slip(velocity, i);
                L::two(&[one, other], 0)
            }
            _ => v,
        };
        let change = a * tau - slip * lost + before;
        let u = v + change;
        let rounded = change - (u - v);
        p.put_two(start, 0);
        moves.select(rounded, before).with_fourths(L::zero()).put_two(rounding, 0);
        moves.and(u).with_fourths(L::splat(self.h)).put_two(velocity, 0);
        moves.select(p + u * L::splat(self.h), p).with_fourths(p).put_two(position, 0);
    }

    /// The velocities of two particles relative to their media, m/s.
    #[inline(never)]
    fn slip(&self, velocity: &[Vec4; 2], i: usize) -> [Vec4; 2] {
        let mut slip = *velocity;
        for ((slip, drift), i) in slip.iter_mut().zip(&self.drift[i..]).zip(i..) {
            if *drift != Vec3::ZERO {
                *slip -= (*drift / self.rates.of(i)).extend(0.0);
            }
        }
        slip
    }

    /// The shares of velocity that two particles lose if their lags or their dampings differ from the rest.
    #[inline(never)]
    fn lost(&mut self, lags: [f32; 2], i: usize) -> [f32; 2] {
        let mut lost = [0.0; 2];
        for ((lost, lag), i) in lost.iter_mut().zip(lags).zip(i..) {
            let exponent = self.rates.of(i) * ((lag + self.h) * 0.5);
            if exponent != self.last.0 {
                self.last = (exponent, loss(exponent));
            }
            *lost = self.last.1;
        }
        lost
    }
}

/// The rates at which particles lose velocity, 1/s.
struct Rates<'a> {
    damping: &'a [f32],
    medium: &'a [f32],
    uniform_damping: f32,
}

impl Rates<'_> {
    /// The rate of one particle; any number for a particle that does not exist.
    fn of(&self, i: usize) -> f32 {
        let own = match self.damping {
            [all] => *all,
            each => each.get(i).copied().unwrap_or(0.0),
        };
        own + (self.uniform_damping + self.medium.get(i).copied().unwrap_or(0.0))
    }

    /// The rate of all particles, if it is the same.
    fn same(&self) -> Option<f32> {
        (self.damping.len() < 2 && self.medium.is_empty()).then(|| self.of(0))
    }
}

/// `1 - e^(-x)`.
pub(crate) fn loss(exponent: f32) -> f32 {
    if exponent == 0.0 { 0.0 } else { -libm::expm1f(-exponent) }
}
