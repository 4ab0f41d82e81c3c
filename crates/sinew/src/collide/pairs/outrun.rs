//! Whether what was found still holds: has somebody gone further than its margin?
//!
//! What all do alike does not count: a heap in free fall has the same neighbours as one at rest. There is a common displacement `Δ` with `‖q_i -
//! x_i - Δ‖ ≤ m_i` for all if there is one with `|q_i - x_i - Δ| ≤ m_i/√3` along each axis, and that is so if the greatest of `q_i - x_i - m_i/√3` is
//! not above the least of `q_i - x_i + m_i/√3`. One pass, no mean, and one fast particle does not make the others look fast.
//!
//! Nor does what a body does counts that is on its own: two that fly past each other need no looking until the boxes about them meet.

use glam::{DVec3, Vec3, Vec4};

use super::members::Members;
use crate::particles::Particles;

/// Scratch of asking.
#[derive(Clone, Debug, Default)]
pub(super) struct Outrun {
    /// The box about each run of members when they were looked at, with their radii and margins, metres from the first's origin.
    boxes: Vec<[DVec3; 2]>,
    /// What each run has done since: bounds of its displacement, metres.
    spreads: Vec<Spread>,
    /// The same when it was last asked.
    before: Vec<Spread>,
}

/// What displacements there are that nobody of some members is further than its slack from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spread {
    low: Vec3,
    high: Vec3,
}

/// Above so many runs of one body each pair of them is not worth being asked.
const RUNS: usize = 48;

/// 1/√3, less a little for rounding.
const AXIS: f32 = 0.577;

/// Which share of its radius a particle may move by in a substep before pairs are asked for the way that they came.
const SWIFT: f32 = 0.25;

impl Outrun {
    /// Takes where everybody is now.
    pub(super) fn begin(&mut self, members: &Members) {
        self.boxes.clear();
        self.spreads.clear();
        if members.runs.len() > RUNS {
            return;
        }
        let mut first = 0;
        for &(end, _) in &members.runs {
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for i in first..end {
                let about = f64::from(members.radius[i] + members.home[i].w);
                let place = members.place[i];
                // One that takes no part is in no box.
                if place.x.is_finite() {
                    (low, high) = (low.min(place - about), high.max(place + about));
                }
            }
            self.boxes.push([low, high]);
            self.spreads.push(Spread::STILL);
            first = end;
        }
    }

    /// Whether somebody may have come near whom it was not near.
    pub(super) fn is_outrun(&mut self, members: &Members, particles: &Particles) -> bool {
        core::mem::swap(&mut self.spreads, &mut self.before);
        self.spreads.clear();
        let (mut all, mut first) = (Spread::ANY, 0);
        for &(end, _) in &members.runs {
            let mut spread = Spread::ANY;
            for (&row, home) in members.rows[first..end].iter().zip(&members.home[first..end]) {
                spread.add(particles.position[row as usize] - *home, home.w);
            }
            if spread.is_empty() {
                return true;
            }
            all.meet(&spread);
            self.spreads.push(spread);
            first = end;
        }
        all.is_empty() && self.some_meet()
    }

    /// Whether the boxes about two runs that went different ways have met.
    fn some_meet(&self) -> bool {
        if self.boxes.len() != self.spreads.len() || self.before.len() != self.spreads.len() {
            return true;
        }
        let swept = |i: usize| {
            let ([low, high], now, before) = (self.boxes[i], self.spreads[i], self.before[i]);
            let ways = [now.middle(), before.middle()];
            (low + ways[0].min(ways[1]).as_dvec3(), high + ways[0].max(ways[1]).as_dvec3())
        };
        for i in 1..self.boxes.len() {
            let (low, high) = swept(i);
            for j in 0..i {
                let mut both = self.spreads[i];
                both.meet(&self.spreads[j]);
                if !both.is_empty() {
                    continue;
                }
                let (other_low, other_high) = swept(j);
                if low.cmple(other_high).all() && other_low.cmple(high).all() {
                    return true;
                }
            }
        }
        false
    }

    /// Whether somebody moves so far in this substep that it may pass through another.
    pub(super) fn is_swift(&self, members: &Members, particles: &Particles) -> bool {
        let mut spread = Spread::ANY;
        for (&row, &radius) in members.rows.iter().zip(&members.radius) {
            let i = row as usize;
            spread.add(particles.position[i] - particles.start[i], radius * SWIFT);
        }
        spread.is_empty()
    }
}

impl Spread {
    const ANY: Self = Self { low: Vec3::NEG_INFINITY, high: Vec3::INFINITY };
    const STILL: Self = Self { low: Vec3::ZERO, high: Vec3::ZERO };

    /// Leaves those that one which went `way` is within `slack` of. One that is nowhere does not count.
    #[inline(always)]
    fn add(&mut self, way: Vec4, slack: f32) {
        let (way, slack) = (way.truncate(), slack * AXIS);
        let (low, high) = (way - slack, way + slack);
        let greater = |a: f32, b: f32| if b > a { b } else { a };
        let less = |a: f32, b: f32| if b < a { b } else { a };
        self.low.x = greater(self.low.x, low.x);
        self.low.y = greater(self.low.y, low.y);
        self.low.z = greater(self.low.z, low.z);
        self.high.x = less(self.high.x, high.x);
        self.high.y = less(self.high.y, high.y);
        self.high.z = less(self.high.z, high.z);
    }

    /// Leaves those of both.
    fn meet(&mut self, other: &Self) {
        self.low = self.low.max(other.low);
        self.high = self.high.min(other.high);
    }

    fn is_empty(&self) -> bool {
        !self.low.cmple(self.high).all()
    }

    /// One of them.
    fn middle(&self) -> Vec3 {
        let middle = self.low * 0.5 + self.high * 0.5;
        // Of members that are all nowhere there is none.
        if middle.is_finite() { middle } else { Vec3::ZERO }
    }
}
