//! Skin of the neighbour list: whether a participant has gone further than its margin, so that the list must be built again.
//!
//! What all do alike does not count: a heap in free fall has the same neighbours as one at rest. There is a common displacement `Δ` with `‖q_i -
//! x_i - Δ‖ ≤ m_i` for all if there is one with `|q_i - x_i - Δ| ≤ m_i/√3` along each axis, and that is so if the greatest of `q_i - x_i - m_i/√3` is
//! not above the least of `q_i - x_i + m_i/√3`. One pass, no mean, and one fast particle does not make the others look fast.
//!
//! Nor does what a body does counts that is on its own: two that fly past each other need no looking until the boxes about them meet.

use glam::{DVec3, Vec3, Vec4};

use super::participants::Participants;
use crate::particles::Particles;

/// Scratch of asking.
#[derive(Clone, Debug, Default)]
pub(super) struct SkinCheck {
    /// The box about each run of members when they were looked at, with their radii and margins, metres from the first's origin.
    boxes: Vec<[DVec3; 2]>,
    /// What each run has done since: bounds of its displacement, metres.
    displacement_bounds: Vec<DisplacementBounds>,
    /// The same when it was last asked.
    before: Vec<DisplacementBounds>,
}

/// What displacements there are that nobody of some members is further than its slack from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DisplacementBounds {
    low: Vec3,
    high: Vec3,
}

/// Above so many runs of one body each pair of them is not worth being asked.
const RUNS: usize = 48;

/// 1/√3, less a little for rounding.
const AXIS: f32 = 0.577;

/// Which share of its radius a particle may move by in a substep before pairs are asked for the way that they came.
const FAST: f32 = 0.25;

impl SkinCheck {
    /// Takes where everybody is now.
    pub(super) fn begin(&mut self, participants: &Participants) {
        self.boxes.clear();
        self.displacement_bounds.clear();
        if participants.runs.len() > RUNS {
            return;
        }
        let mut first = 0;
        for &(end, _) in &participants.runs {
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for i in first..end {
                let about = f64::from(participants.radius[i] + participants.home[i].w);
                let place = participants.place[i];
                // One that takes no part is in no box.
                if place.x.is_finite() {
                    (low, high) = (low.min(place - about), high.max(place + about));
                }
            }
            self.boxes.push([low, high]);
            self.displacement_bounds.push(DisplacementBounds::STILL);
            first = end;
        }
    }

    /// Whether somebody may have come near whom it was not near.
    pub(super) fn is_skin_exceeded(
        &mut self,
        participants: &Participants,
        particles: &Particles,
    ) -> bool {
        core::mem::swap(&mut self.displacement_bounds, &mut self.before);
        self.displacement_bounds.clear();
        let (mut all, mut first) = (DisplacementBounds::ANY, 0);
        for &(end, _) in &participants.runs {
            let mut spread = DisplacementBounds::ANY;
            for (&row, home) in
                participants.rows[first..end].iter().zip(&participants.home[first..end])
            {
                spread.add(particles.position[row as usize] - *home, home.w);
            }
            if spread.is_empty() {
                return true;
            }
            all.intersect(&spread);
            self.displacement_bounds.push(spread);
            first = end;
        }
        all.is_empty() && self.any_overlap()
    }

    /// Whether the boxes about two runs that went different ways have met.
    fn any_overlap(&self) -> bool {
        if self.boxes.len() != self.displacement_bounds.len()
            || self.before.len() != self.displacement_bounds.len()
        {
            return true;
        }
        let swept = |i: usize| {
            let ([low, high], now, before) =
                (self.boxes[i], self.displacement_bounds[i], self.before[i]);
            let ways = [now.middle(), before.middle()];
            (low + ways[0].min(ways[1]).as_dvec3(), high + ways[0].max(ways[1]).as_dvec3())
        };
        for i in 1..self.boxes.len() {
            let (low, high) = swept(i);
            for j in 0..i {
                let mut both = self.displacement_bounds[i];
                both.intersect(&self.displacement_bounds[j]);
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
    pub(super) fn is_fast(&self, participants: &Participants, particles: &Particles) -> bool {
        let mut spread = DisplacementBounds::ANY;
        for (&row, &radius) in participants.rows.iter().zip(&participants.radius) {
            let i = row as usize;
            spread.add(particles.position[i] - particles.start[i], radius * FAST);
        }
        spread.is_empty()
    }
}

impl DisplacementBounds {
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
    fn intersect(&mut self, other: &Self) {
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
