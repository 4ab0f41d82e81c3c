//! Verlet's step of particles in columns: what one substep derives and what the next one predicts, in one go over each of them. Operation by
//! operation it is what [`Derive`](super::Derive) and [`Predict`](super::Predict) do.

use core::ops::Range;

use glam::Vec3;

use super::loss;
use crate::lanes::{Columns, InstructionSet, LANES, Lanes, Vector, Work, with};

/// Particles that are in columns for all substeps of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct MovingColumns {
    pub(crate) position: Columns,
    /// Where they were predicted to go; in the last substep, where that began.
    pub(crate) begun: Columns,
    pub(crate) velocity: Columns,
    pub(crate) rounding: Columns,
}

/// What all of them have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepConstants {
    /// Acceleration, m/s².
    pub(crate) acceleration: Vec3,
    /// Length of a substep, seconds.
    pub(crate) h: f32,
    /// Damping, 1/s, and the share of velocity that is lost in a substep.
    rate: f32,
    lost: f32,
}

impl StepConstants {
    /// With damping, 1/s; none if that is no number.
    pub(crate) fn new(acceleration: Vec3, rate: f32, h: f32) -> Option<Self> {
        let lost = loss(rate * h);
        (!lost.is_nan()).then_some(Self { acceleration, h, rate, lost })
    }
}

impl StepConstants {
    /// The shares that are lost by particles that had their last steps so long ago, seconds.
    #[inline(never)]
    fn lost_after(&self, lags: [f32; LANES]) -> [f32; LANES] {
        lags.map(|lag| loss(self.rate * ((lag + self.h) * 0.5)))
    }
}

impl MovingColumns {
    /// All four columns.
    pub(crate) fn each(&mut self) -> [&mut Columns; 4] {
        [&mut self.position, &mut self.begun, &mut self.velocity, &mut self.rounding]
    }

    /// Takes some lanes through a part of the step.
    pub(crate) fn pass(
        &mut self,
        pass: Pass,
        lanes: [Range<usize>; 2],
        step: StepConstants,
        instructions: InstructionSet,
    ) {
        with(instructions, Advance { moving: self, pass, lanes, step });
    }
}

/// A part of a step, for some lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pass {
    /// Predicts the first positions of lanes that had their last steps as long ago as the fourths of their velocities say. `last` as below.
    Begin { last: bool },
    /// Derives the velocities, and predicts the next positions. `last` where that is for the last substep.
    GoOn { last: bool },
    /// Derives the velocities after the last substep.
    Settle,
}

struct Advance<'a> {
    moving: &'a mut MovingColumns,
    pass: Pass,
    lanes: [Range<usize>; 2],
    step: StepConstants,
}

impl Work for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { moving, pass, lanes, step } = self;
        match pass {
            Pass::Begin { last } => moving.begin::<L>(lanes, step, last),
            Pass::GoOn { last } => moving.go_on::<L>(lanes, step, last),
            Pass::Settle => moving.settle::<L>(lanes, step),
        }
    }
}

impl MovingColumns {
    #[inline(always)]
    fn begin<L: Lanes>(&mut self, lanes: [Range<usize>; 2], step: StepConstants, last: bool) {
        let (h, zero) = (L::splat(step.h), L::zero());
        let steady = L::splat(step.lost);
        let acceleration = Vector::<L>::splat(step.acceleration);
        let [position, begun, velocity, rounding] = self.each();
        let (mut position, mut begun) = (position.eights(), begun.eights());
        let (mut velocity, mut rounding) = (velocity.eights(), rounding.eights());
        // Neighbours mostly had theirs at the same time.
        let mut known = ([step.h; LANES], steady);
        for lanes in lanes {
            let mut at = lanes.start;
            while at < lanes.end {
                let (p, w) = Vector::of(position.load::<L>(at));
                let (v, lag) = Vector::of(velocity.load::<L>(at));
                let (before, _) = Vector::of(rounding.load::<L>(at));
                let tau = (lag + h) * L::splat(0.5);
                if !lag.same(L::load(&known.0)).all() {
                    known = (lag.array(), L::load(&step.lost_after(lag.array())));
                }
                let change = acceleration * tau - v * known.1 + before;
                let u = v + change;
                let rounded = change - (u - v);
                let moves = zero.lt(w);
                let next = (p + u * h).or_else(moves, p);
                let u = Vector::new(moves.and(u.x), moves.and(u.y), moves.and(u.z));
                velocity.put(at, u.with(zero));
                begun.put(at, if last { p } else { next }.with(zero));
                position.put(at, next.with(w));
                // Last: the compiler makes stores with a mask of a choice that follows its load, which take as long as all the rest.
                rounding.put(at, rounded.or_else(moves, before).with(zero));
                at += LANES;
            }
        }
    }

    #[inline(always)]
    fn go_on<L: Lanes>(&mut self, lanes: [Range<usize>; 2], step: StepConstants, last: bool) {
        let (h, per, zero) = (L::splat(step.h), L::splat(1.0 / step.h), L::zero());
        let lost = L::splat(step.lost);
        let push = Vector::<L>::splat(step.acceleration) * h;
        let [position, begun, velocity, rounding] = self.each();
        let (mut position, mut begun) = (position.eights(), begun.eights());
        let (mut velocity, mut rounding) = (velocity.eights(), rounding.eights());
        for lanes in lanes {
            let mut at = lanes.start;
            while at < lanes.end {
                let (p, w) = Vector::of(position.load::<L>(at));
                // No loops and no closures: what is not inlined is not compiled for the lanes' instructions.
                let (predicted, _) = Vector::of(begun.load::<L>(at));
                let (u, _) = Vector::of(velocity.load::<L>(at));
                let (before, _) = Vector::of(rounding.load::<L>(at));
                let v = u + (p - predicted) * per;
                let change = push - v * lost + before;
                let u = v + change;
                let rounded = change - (u - v);
                let moves = zero.lt(w);
                let next = (p + u * h).or_else(moves, p);
                let u = Vector::new(moves.and(u.x), moves.and(u.y), moves.and(u.z));
                velocity.put(at, u.with(zero));
                begun.put(at, if last { p } else { next }.with(zero));
                position.put(at, next.with(w));
                // Last: the compiler makes stores with a mask of a choice that follows its load, which take as long as all the rest.
                rounding.put(at, rounded.or_else(moves, before).with(zero));
                at += LANES;
            }
        }
    }

    #[inline(always)]
    fn settle<L: Lanes>(&mut self, lanes: [Range<usize>; 2], step: StepConstants) {
        let (h, per) = (L::splat(step.h), L::splat(1.0 / step.h));
        let [position, start, velocity, rounding] = self.each();
        let (position, mut begun) = (position.eights(), start.eights());
        let (mut velocity, mut rounding) = (velocity.eights(), rounding.eights());
        for lanes in lanes {
            let mut at = lanes.start;
            while at < lanes.end {
                let (p, w) = Vector::of(position.load::<L>(at));
                let (start, _) = Vector::of(begun.load::<L>(at));
                let (u, _) = Vector::of(velocity.load::<L>(at));
                velocity.put(at, (u + (p - (start + u * h)) * per).with(h));
                velocity.put_fourth(at, h);
                begun.put_fourth(at, w);
                rounding.put_fourth(at, L::zero());
                at += LANES;
            }
        }
    }
}
