//! The Verlet step of particles in columns: deriving velocities in one substep and predicting positions for the next, in one pass. Operation by operation it is
//! the same as [`Derive`](super::Derive) and [`Predict`](super::Predict).

use core::ops::Range;

use glam::Vec3;

use super::loss;
use crate::lanes::{Columns, ColumnsView, LANES, Lanes, Vector, kernel};

/// Particles that stay in columns for all substeps of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct MovingColumns {
    pub(crate) position: Columns,
    /// Predicted positions; in the last substep, positions at its start.
    pub(crate) start: Columns,
    pub(crate) velocity: Columns,
    pub(crate) rounding: Columns,
}

/// What is the same for all particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepConstants {
    /// Acceleration, m/s².
    pub(crate) acceleration: Vec3,
    /// Length of a substep, seconds.
    pub(crate) h: f32,
    /// Damping rate, 1/s, and the share of velocity that is lost in a substep.
    rate: f32,
    lost: f32,
}

impl StepConstants {
    /// With a damping rate in 1/s; `None` if the loss is NaN.
    pub(crate) fn new(acceleration: Vec3, rate: f32, h: f32) -> Option<Self> {
        let lost = loss(rate * h);
        (!lost.is_nan()).then_some(Self { acceleration, h, rate, lost })
    }

    /// The shares of velocity that are lost by particles with these lags, seconds.
    #[inline(never)]
    fn lost_after(&self, lags: [f32; LANES]) -> [f32; LANES] {
        lags.map(|lag| loss(self.rate * ((lag + self.h) * 0.5)))
    }
}

impl MovingColumns {
    /// All four columns.
    pub(crate) fn each(&mut self) -> [&mut Columns; 4] {
        [&mut self.position, &mut self.start, &mut self.velocity, &mut self.rounding]
    }

    #[inline(always)]
    fn open(&mut self) -> OpenColumns<'_> {
        OpenColumns {
            position: self.position.view(),
            start: self.start.view(),
            velocity: self.velocity.view(),
            rounding: self.rounding.view(),
        }
    }
}

kernel!(
    /// Predicts the first positions of some lanes; their lags are in the `w` of the velocities. `last` if the substep is also the last.
    pub(crate) fn predict_columns<L: Lanes>(
        moving: &mut MovingColumns,
        lanes: [Range<usize>; 2],
        step: StepConstants,
        last: bool,
    ) {
        let h = L::splat(step.h);
        let acceleration = Vector::<L>::splat(step.acceleration);
        let mut open = moving.open();
        // Consecutive particles mostly have the same lag.
        let mut known = ([step.h; LANES], L::splat(step.lost));
        for lanes in lanes {
            let mut at = lanes.start;
            while at < lanes.end {
                let (v, lag) = Vector::of(open.velocity.load::<L>(at));
                if !lag.same(L::load(&known.0)).all() {
                    known = (lag.array(), L::load(&step.lost_after(lag.array())));
                }
                let tau = (lag + h) * L::splat(0.5);
                open.predict(at, v, acceleration * tau - v * known.1, h, last);
                at += LANES;
            }
        }
    }
);

kernel!(
    /// Derives the velocities, and predicts the next positions. `last` if these are for the last substep.
    pub(crate) fn advance_columns<L: Lanes>(
        moving: &mut MovingColumns,
        lanes: [Range<usize>; 2],
        step: StepConstants,
        last: bool,
    ) {
        let (h, per, lost) = (L::splat(step.h), L::splat(1.0 / step.h), L::splat(step.lost));
        let push = Vector::<L>::splat(step.acceleration) * h;
        let mut open = moving.open();
        for lanes in lanes {
            let mut at = lanes.start;
            while at < lanes.end {
                let (p, _) = Vector::of(open.position.load::<L>(at));
                let (predicted, _) = Vector::of(open.start.load::<L>(at));
                let (u, _) = Vector::of(open.velocity.load::<L>(at));
                let v = u + (p - predicted) * per;
                open.predict(at, v, push - v * lost, h, last);
                at += LANES;
            }
        }
    }
);

kernel!(
    /// Derives the velocities after the last substep.
    pub(crate) fn derive_columns<L: Lanes>(
        moving: &mut MovingColumns,
        lanes: [Range<usize>; 2],
        step: StepConstants,
    ) {
        let (h, per) = (L::splat(step.h), L::splat(1.0 / step.h));
        let OpenColumns { position, mut start, mut velocity, mut rounding } = moving.open();
        for lanes in lanes {
            let mut at = lanes.start;
            while at < lanes.end {
                let (p, w) = Vector::of(position.load::<L>(at));
                let (from, _) = Vector::of(start.load::<L>(at));
                let (u, _) = Vector::of(velocity.load::<L>(at));
                velocity.put(at, (u + (p - (from + u * h)) * per).with(h));
                velocity.put_fourth(at, h);
                start.put_fourth(at, w);
                rounding.put_fourth(at, L::zero());
                at += LANES;
            }
        }
    }
);

/// The columns while a kernel runs over them.
struct OpenColumns<'a> {
    position: ColumnsView<'a>,
    start: ColumnsView<'a>,
    velocity: ColumnsView<'a>,
    rounding: ColumnsView<'a>,
}

impl OpenColumns<'_> {
    /// Adds to the velocities `v` of eight particles their `change` by forces and damping, and predicts the next positions. `last` if these are for the last
    /// substep.
    // No loops and no closures: what is not inlined is not compiled for the instruction set.
    #[inline(always)]
    fn predict<L: Lanes>(&mut self, at: usize, v: Vector<L>, change: Vector<L>, h: L, last: bool) {
        let zero = L::zero();
        let (p, w) = Vector::of(self.position.load::<L>(at));
        let (before, _) = Vector::of(self.rounding.load::<L>(at));
        let change = change + before;
        let u = v + change;
        let rounded = change - (u - v);
        let moves = zero.lt(w);
        let next = (p + u * h).or_else(moves, p);
        let u = Vector::new(moves.and(u.x), moves.and(u.y), moves.and(u.z));
        self.velocity.put(at, u.with(zero));
        self.start.put(at, if last { p } else { next }.with(zero));
        self.position.put(at, next.with(w));
        // Written last: the compiler turns a selection right after its load into masked stores, which take as long as everything else here.
        self.rounding.put(at, rounded.or_else(moves, before).with(zero));
    }
}
