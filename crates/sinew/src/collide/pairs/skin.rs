//! Skin check of the neighbour list: whether a participant has moved further than its margin, so that the list must be rebuilt.
//!
//! A common displacement does not count: a heap in free fall has the same neighbours as one at rest. There is a common displacement `Δ` with `‖q_i - x_i - Δ‖ ≤
//! m_i` for all if there is one with `|q_i - x_i - Δ| ≤ m_i/√3` along each axis, which is so if the greatest of `q_i - x_i - m_i/√3` is not above the least of
//! `q_i - x_i + m_i/√3`. This takes one pass and no mean, and one fast particle does not make the others look fast.
//!
//! Where that test finds none, one `Δ`, the middle of the remaining interval along each axis, is tested exactly: a particle that moves straight along an axis
//! may use all of its margin, and not `m_i/√3`. Without it, one particle of five thousand that had moved by its margin, as foreseen, had the list rebuilt in
//! each step.
//!
//! Nor does the displacement of a body by itself count: two bodies that fly past each other need no rebuild until their bounds overlap.

use glam::{DVec3, Vec3, Vec4};

use super::participants::Participants;
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, get, kernel};
use crate::particles::Particles;

/// Scratch of the skin check.
#[derive(Clone, Debug, Default)]
pub(super) struct SkinCheck {
    /// Bounds of each run of participants when the list was built, with their radii and margins, metres from the origin of the first.
    boxes: Vec<[DVec3; 2]>,
    /// For each run the common displacements since then that its participants allow, metres.
    displacement_bounds: Vec<DisplacementBounds>,
    /// The same at the previous check.
    before: Vec<DisplacementBounds>,
}

/// The displacements from which no participant of a set deviates by more than its margin, as bounds on each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DisplacementBounds {
    low: Vec3,
    high: Vec3,
}

/// Above this many runs, testing each pair of them does not pay.
const RUNS: usize = 48;

/// 1/√3, rounded down.
const AXIS: f32 = 0.577;

/// Reduction of a margin against rounding.
const ROUNDED: f32 = 0.999;

/// Share of its radius that a particle may move by in a substep before pairs are tested along their paths.
const FAST: f32 = 0.25;

impl SkinCheck {
    /// Starts from the present positions.
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
                // A particle that takes no part is in no box.
                if place.x.is_finite() {
                    (low, high) = (low.min(place - about), high.max(place + about));
                }
            }
            self.boxes.push([low, high]);
            self.displacement_bounds.push(DisplacementBounds::STILL);
            first = end;
        }
    }

    /// Whether a pair that is not listed may have come within its margins; and whether a particle moves so far in this substep that it may pass through
    /// another.
    pub(super) fn check(
        &mut self,
        participants: &Participants,
        particles: &Particles,
        instructions: InstructionSet,
    ) -> [bool; 2] {
        core::mem::swap(&mut self.displacement_bounds, &mut self.before);
        let (each, all) = (&mut self.displacement_bounds, [(participants.rows.len(), 0)]);
        let runs = if self.boxes.is_empty() { &all[..] } else { &participants.runs };
        let columns = [&particles.position[..], &particles.start];
        let paths = bounds_of_runs(participants, columns, runs, each, instructions);
        [self.is_skin_exceeded(participants, particles), paths.is_empty()]
    }

    fn is_skin_exceeded(&self, participants: &Participants, particles: &Particles) -> bool {
        let (mut all, mut torn) = (DisplacementBounds::ANY, false);
        for spread in &self.displacement_bounds {
            torn |= spread.is_empty();
            all.intersect(spread);
        }
        all.is_empty()
            && (torn || self.any_overlap())
            && any_is_beyond(participants, particles, all.middle())
    }

    /// Whether the swept bounds of two runs with different displacements overlap.
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
}

kernel!(
    /// The allowed common displacements of each run since the list was built. Returns those of all participants from the second of two columns to the first in
    /// this substep, with a share of their radii as the margin.
    fn bounds_of_runs<L: Lanes>(
        participants: &Participants,
        columns: [&[Vec4]; 2],
        // End and body of each.
        runs: &[(usize, u32)],
        to: &mut Vec<DisplacementBounds>,
    ) -> DisplacementBounds {
        to.clear();
        let [position, start] = columns;
        let Participants { rows, home, radius, .. } = participants;
        let mut paths = WideBounds::<L>::any();
        let mut first = 0;
        for &(end, _) in runs {
            let (rows, home, radius) = (&rows[first..end], &home[first..end], &radius[first..end]);
            let mut bounds = WideBounds::<L>::any();
            for at in (0..rows.len()).step_by(LANES) {
                let now = Vector::of(read::<L>(position, rows, at)).0;
                let start = Vector::of(read::<L>(start, rows, at)).0;
                let (home, margin) = Vector::of(L::run(&eight_of(home, at), 0));
                bounds.add(now - home, margin);
                paths.add(now - start, L::load(&eight_of(radius, at)) * L::splat(FAST));
            }
            to.push(bounds.of_all());
            first = end;
        }
        paths.of_all()
    }
);

/// Gathers eight rows, as [`eight_of`] selects them. Rows ascend, so mostly they are contiguous.
#[inline(always)]
fn read<L: Lanes>(column: &[Vec4], rows: &[u32], at: usize) -> [L; 4] {
    match rows[at..].first_chunk::<LANES>() {
        Some([first, .., last]) if last - first == LANES as u32 - 1 => {
            L::run(column, *first as usize)
        }
        _ => L::rows(column, &eight_of(rows, at)),
    }
}

/// Eight elements from `at` on, or the remaining ones padded with the last.
#[inline(always)]
fn eight_of<T: Copy>(column: &[T], at: usize) -> [T; LANES] {
    let left = &column[at..];
    if let Some(eight) = left.first_chunk() {
        return *eight;
    }
    let mut eight = [left[left.len() - 1]; LANES];
    eight[..left.len()].copy_from_slice(left);
    eight
}

/// [`DisplacementBounds`] in each lane.
struct WideBounds<L> {
    low: Vector<L>,
    high: Vector<L>,
}

impl<L: Lanes> WideBounds<L> {
    #[inline(always)]
    fn any() -> Self {
        Self {
            low: Vector::splat(DisplacementBounds::ANY.low),
            high: Vector::splat(DisplacementBounds::ANY.high),
        }
    }

    /// Intersects with the displacements within `slack` of `way`. NaN has no effect.
    #[inline(always)]
    fn add(&mut self, way: Vector<L>, slack: L) {
        let slack = slack * L::splat(AXIS);
        let slack = Vector::new(slack, slack, slack);
        let (low, high) = (way - slack, way + slack);
        let (l, h) = (self.low, self.high);
        self.low = Vector::new(low.x.max(l.x), low.y.max(l.y), low.z.max(l.z));
        self.high = Vector::new(high.x.min(h.x), high.y.min(h.y), high.z.min(h.z));
    }

    /// The intersection over all lanes.
    #[inline(always)]
    fn of_all(&self) -> DisplacementBounds {
        let mut bounds = DisplacementBounds::ANY;
        let [low, high] = [&self.low, &self.high];
        let lows = [low.x.array(), low.y.array(), low.z.array()];
        let highs = [high.x.array(), high.y.array(), high.z.array()];
        for lane in 0..LANES {
            bounds
                .intersect(&DisplacementBounds { low: get(&lows, lane), high: get(&highs, lane) });
        }
        bounds
    }
}

/// Whether a participant has moved further than its margin, relative to a common displacement.
fn any_is_beyond(participants: &Participants, particles: &Particles, common: Vec3) -> bool {
    let beyond = |(&row, home): (&u32, &Vec4)| {
        let own = (particles.position[row as usize] - *home).truncate() - common;
        let margin = home.w * ROUNDED;
        own.length_squared() > margin * margin
    };
    participants.rows.iter().zip(&participants.home).any(beyond)
}

impl DisplacementBounds {
    const ANY: Self = Self { low: Vec3::NEG_INFINITY, high: Vec3::INFINITY };
    const STILL: Self = Self { low: Vec3::ZERO, high: Vec3::ZERO };

    /// Intersects with another set.
    fn intersect(&mut self, other: &Self) {
        self.low = self.low.max(other.low);
        self.high = self.high.min(other.high);
    }

    fn is_empty(&self) -> bool {
        !self.low.cmple(self.high).all()
    }

    /// The centre.
    fn middle(&self) -> Vec3 {
        let middle = self.low * 0.5 + self.high * 0.5;
        // Not finite if all participants are NaN.
        if middle.is_finite() { middle } else { Vec3::ZERO }
    }
}
