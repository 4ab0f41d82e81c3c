//! Strain limiting (Provot, *Deformation Constraints in a Mass-Spring Model to Describe Rigid Cloth Behavior*, 1995): rods of large cloth with a strain of more
//! than a few hundredths are brought within that limit, as far as the rods around them allow.
//!
//! The error that sweeps leave is not spread evenly: of a flag's 5838 rods seven are off by more than 3 %, at the corner that all of it hangs on, and where a
//! jerk goes through a large sheet a few hundred are, by up to a third. These rods are few, and their neighbours have slack. So a rod beyond the limit is
//! projected to somewhat within it, and so are the neighbours that this moves beyond it, and so on: a queue of particles that have moved since their rods were
//! checked is processed, oldest first, until it is empty. The largest strains come first: the limit starts somewhat below the largest strain, and is lowered
//! step by step. Where a jerk goes through all of a sheet, the budget is spent before the last limit, and what is left is spread evenly. This is Gauss–Seidel
//! restricted to where it matters, with one projection where a sweep over all rods has hundreds. Positions in which no rod is too long form a convex set, and
//! if there are any, the projections approach them (projections onto convex sets). A rope, unlike a bar, may be shorter than its length by any amount.
//!
//! Strain limiting is a part of [relaxation](super::relaxation), and follows its rule: positions change, velocities do not.

use glam::Vec4;

use super::rod_graph::{RodEnd, RodGraph};
use super::rods::{FullCorrection, project};

/// Greatest strain of a rod. Weft and warp of woven cloth give way by about as much before they are taut.
const LIMIT: f32 = 0.03;

/// Share of the limit to which a rod is brought. Bringing it exactly to the limit takes longer, as every rod that moves then brings its neighbours beyond it.
const TARGET_SHARE: f32 = 0.9;

/// Ratio of successive limits, from the largest strain down to the last limit. For a sheet of 128 × 128 that swings from two corners, twelve starts each, worst
/// strain and engine time: 1.1 gives 11.8 % and 6.9 ms, 1.15 12.4 % and 6.9 ms, 1.2 13.0 % and 7.0 ms.
const LIMIT_RATIO: f32 = 1.15;

/// Budget: greatest mean number of checks of each rod end. For the same sheet: one gives 14.8 % and 6.7 ms, two 12.4 % and 6.9 ms, three 11.3 % and 7.1 ms; the
/// slowest ticks take 3 to 4 ms more than others.
const CHECKS: usize = 2;

/// Most rounds for one limit. The last rounds are about a few rods that cannot all be satisfied.
const MAX_ROUNDS: usize = 256;

/// If more than one particle in this many is in the queue, the cloth is stretched everywhere, and no rod has slack to give.
const QUEUE_SHARE: usize = 2;

/// Scratch of strain limiting.
#[derive(Clone, Debug, Default)]
pub(crate) struct StrainScratch {
    /// Previous positions, metres.
    pub(super) before: Vec<Vec4>,
    /// Particles whose rods are to be checked, in this round and in the next.
    now: Vec<u32>,
    next: Vec<u32>,
    /// Whether each particle is listed for the next round.
    listed: Vec<bool>,
    /// Particles that have been moved, ring by ring.
    moved: Vec<u32>,
    /// Particles with a rod beyond the last limit but within the present one; and whether each particle is among them.
    later: Vec<u32>,
    deferred: Vec<bool>,
}

impl StrainScratch {
    /// Limits the strain of the rods of a graph. Only rods at particles that are not where `before` has them can be beyond the limit.
    pub(super) fn limit(&mut self, graph: &RodGraph, position: &mut [Vec4]) {
        let mut budget = CHECKS * graph.ends();
        self.list_moved(position);
        // No rod is beyond this limit: the first pass collects the rods beyond the last limit.
        let mut limit = f32::MAX;
        while self.bring_within(graph, position, limit, &mut budget, MAX_ROUNDS) && limit > LIMIT {
            if limit == f32::MAX {
                // Strains beyond 1 get no limits of their own, however far away a particle was set.
                limit = self.worst(graph, position).min(1.0);
            }
            limit = (limit / LIMIT_RATIO).max(LIMIT);
            core::mem::swap(&mut self.now, &mut self.later);
        }
    }

    /// Brings the rods of some particles within the last limit, and the rods around them that this moves beyond it, for this many rings of rods. Returns the
    /// particles that moved, some more than once.
    pub(super) fn limit_about(
        &mut self,
        graph: &RodGraph,
        position: &mut [Vec4],
        particles: impl Iterator<Item = u32>,
        rings: usize,
    ) -> &[u32] {
        self.begin(position.len());
        self.now.extend(particles);
        self.bring_within(graph, position, LIMIT, &mut (CHECKS * graph.ends()), rings);
        &self.moved
    }

    /// Clears the lists, and allocates for this many particles.
    fn begin(&mut self, particles: usize) {
        let Self { now, next, listed, later, deferred, moved, .. } = self;
        for list in [now, next, later, moved] {
            list.clear();
            list.reserve(particles);
        }
        for flags in [listed, deferred] {
            flags.clear();
            flags.resize(particles, false);
        }
    }

    /// Lists the particles that are not where they were before.
    fn list_moved(&mut self, position: &[Vec4]) {
        self.begin(position.len());
        let Self { before, now, .. } = self;
        let moved = before.iter().zip(position).zip(0..);
        now.extend(moved.filter(|((before, here), _)| before != here).map(|(_, i)| i));
    }

    /// Brings the listed rods, and the rods that this moves beyond the limit, within it; lists those beyond the last limit for later. Returns false if the
    /// budget is spent or too many particles are listed.
    fn bring_within(
        &mut self,
        graph: &RodGraph,
        position: &mut [Vec4],
        limit: f32,
        budget: &mut usize,
        rounds: usize,
    ) -> bool {
        let Self { now, next, listed, later, deferred, moved, .. } = self;
        let (band, last) = (Band::of(limit), Band::of(LIMIT));
        now.iter().for_each(|&i| deferred[i as usize] = false);
        for _ in 0..rounds {
            if now.len() * QUEUE_SHARE > position.len() {
                return false;
            }
            now.iter().for_each(|&i| listed[i as usize] = false);
            for i in now.drain(..) {
                let rods = graph.rods_of(i);
                let Some(left) = budget.checked_sub(rods.len()) else { return false };
                *budget = left;
                let mut waits = false;
                for rod in rods {
                    if last.holds(position, i, rod) {
                        continue;
                    }
                    if band.holds(position, i, rod) {
                        waits = true;
                    } else if bring_to(position, i, rod, limit * TARGET_SHARE) {
                        for end in [i, rod.to] {
                            if !core::mem::replace(&mut listed[end as usize], true) {
                                next.push(end);
                                moved.push(end);
                            }
                        }
                    }
                }
                if waits && !core::mem::replace(&mut deferred[i as usize], true) {
                    later.push(i);
                }
            }
            core::mem::swap(now, next);
            if now.is_empty() {
                return true;
            }
        }
        // Rods that cannot be satisfied are left as they are, until a particle next to them moves.
        now.drain(..).for_each(|i| listed[i as usize] = false);
        true
    }

    /// The largest strain of the rods listed for later.
    fn worst(&self, graph: &RodGraph, position: &[Vec4]) -> f32 {
        let ends =
            self.later.iter().flat_map(|&i| graph.rods_of(i).iter().map(move |rod| (i, rod)));
        let strains =
            ends.map(|(i, rod)| (libm::sqrtf(square(position, i, rod)) / rod.rest - 1.0).abs());
        strains.fold(0.0, f32::max)
    }
}

/// Bounds of the squared lengths of rods within a limit, as shares of the squares of their rest lengths.
#[derive(Clone, Copy)]
struct Band {
    least: f32,
    most: f32,
}

impl Band {
    fn of(limit: f32) -> Self {
        let (least, most) = ((1.0 - limit).max(0.0), 1.0 + limit);
        Self { least: least * least, most: most * most }
    }

    /// Whether a rod at a particle is within the limit. A rod that slackens has no lower bound.
    #[inline(always)]
    fn holds(&self, position: &[Vec4], i: u32, rod: &RodEnd) -> bool {
        let (square, whole) = (square(position, i, rod), rod.rest * rod.rest);
        square <= self.most * whole && (rod.slackens || self.least * whole <= square)
    }
}

/// The squared length of a rod at a particle, m².
#[inline(always)]
fn square(position: &[Vec4], i: u32, rod: &RodEnd) -> f32 {
    (position[i as usize] - position[rod.to as usize]).truncate().length_squared()
}

/// Projects a rod to this strain, with the sign of its present one; returns whether it moved.
#[inline]
fn bring_to(position: &mut [Vec4], i: u32, rod: &RodEnd, strain: f32) -> bool {
    let (a, b) = (i as usize, rod.to as usize);
    let is_short = square(position, i, rod) < rod.rest * rod.rest;
    let rest = rod.rest + rod.rest * if is_short { -strain } else { strain };
    let (one, other) = (position[a].to_array(), position[b].to_array());
    let (one, other, ..) = project::<f32>(one, other, rest, FullCorrection);
    let (one, other) = (Vec4::from_array(one), Vec4::from_array(other));
    // A rod between two pins does not move; nor does one with coincident ends or non-finite positions.
    let moves = (one, other) != (position[a], position[b]) && (one + other).is_finite();
    if moves {
        (position[a], position[b]) = (one, other);
    }
    moves
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of cells of 1 m with both diagonals.
    fn square(side: u32) -> (RodGraph, Vec<Vec4>) {
        woven(side, false)
    }

    /// The same, of ropes (`slackens`) or of bars.
    fn woven(side: u32, slackens: bool) -> (RodGraph, Vec<Vec4>) {
        let row = |x: u32, y: u32| y * (side + 1) + x;
        let mut rods = Vec::new();
        for (x, y) in (0..=side).flat_map(|y| (0..=side).map(move |x| (x, y))) {
            let (right, up) = (x < side, y < side);
            rods.extend(right.then(|| (row(x, y), row(x + 1, y), 1.0, slackens)));
            rods.extend(up.then(|| (row(x, y), row(x, y + 1), 1.0, slackens)));
            let diagonal = core::f32::consts::SQRT_2;
            rods.extend((right && up).then(|| (row(x, y), row(x + 1, y + 1), diagonal, slackens)));
            rods.extend((right && up).then(|| (row(x + 1, y), row(x, y + 1), diagonal, slackens)));
        }
        let all = (0..=side).flat_map(|y| (0..=side).map(move |x| (x, y)));
        let position: Vec<Vec4> =
            all.map(|(x, y)| Vec4::new(x as f32, y as f32, 0.0, 1.0)).collect();
        (RodGraph::shortest(position.len(), &rods), position)
    }

    /// Limits the strain of particles that have moved from `before`.
    fn limited(graph: &RodGraph, before: &[Vec4], mut position: Vec<Vec4>) -> Vec<Vec4> {
        let mut scratch = StrainScratch { before: before.to_vec(), ..Default::default() };
        scratch.limit(graph, &mut position);
        position
    }

    fn strains(graph: &RodGraph, position: &[Vec4]) -> impl Iterator<Item = f32> {
        (0..position.len() as u32).flat_map(move |i| {
            graph.rods_of(i).iter().map(move |rod| {
                let apart = (position[i as usize] - position[rod.to as usize]).truncate();
                (apart.length() / rod.rest - 1.0).abs()
            })
        })
    }

    #[test]
    fn what_was_pulled_out_comes_to_the_limit_and_what_is_far_from_it_stays() {
        let (graph, flat) = square(30);
        for pull in [0.1, -0.2, 0.9] {
            let mut position = flat.clone();
            position[15 * 31 + 15] += Vec4::new(pull, 0.3 * pull, 0.2 * pull, 0.0);
            let after = limited(&graph, &flat, position);
            let worst = strains(&graph, &after).fold(0.0, f32::max);
            assert!(worst <= 1.0001 * LIMIT, "{pull}: {worst}");
            assert_eq!(after[..4 * 31], flat[..4 * 31], "{pull}");
            let moved =
                after.iter().zip(&flat).map(|(after, before)| *after - *before).sum::<Vec4>();
            let pulled = Vec4::new(pull, 0.3 * pull, 0.2 * pull, 0.0);
            assert!((moved - pulled).length() < 1e-4, "its barycentre stays: {moved}");
        }
    }

    #[test]
    fn what_is_within_the_limit_and_what_has_not_moved_are_left_as_they_are() {
        let (graph, flat) = square(10);
        let mut position = flat.clone();
        position[60] += Vec4::new(0.02, 0.0, 0.0, 0.0);
        assert_eq!(limited(&graph, &flat, position.clone()), position);
        // The particle was there before, so it does not count as moved by the sweeps.
        position[60] += Vec4::new(0.2, 0.0, 0.0, 0.0);
        assert_eq!(limited(&graph, &position, position.clone()), position);
    }

    #[test]
    fn ropes_stay_slack_and_are_not_seen_longer() {
        let (graph, flat) = woven(30, true);
        let mut position = flat.clone();
        position[15 * 31 + 15] += Vec4::new(0.0, 0.0, 0.6, 0.0);
        // Two particles moved closer together.
        position[5 * 31 + 5] += Vec4::new(0.02, 0.0, 0.0, 0.0);
        position[5 * 31 + 6] -= Vec4::new(0.02, 0.0, 0.0, 0.0);
        let after = limited(&graph, &flat, position.clone());
        let slack = 5 * 31 + 5..5 * 31 + 7;
        assert_eq!(after[slack.clone()], position[slack]);
        assert_ne!(after[15 * 31 + 15], position[15 * 31 + 15]);
        for i in 0..after.len() as u32 {
            for rod in graph.rods_of(i) {
                let apart = (after[i as usize] - after[rod.to as usize]).truncate().length();
                assert!(apart <= 1.0001 * (1.0 + LIMIT) * rod.rest, "{i}: {apart}");
            }
        }
    }

    #[test]
    fn pins_stay_and_what_cannot_be_met_ends_finite() {
        let (graph, flat) = square(10);
        let mut position = flat.clone();
        for (row, far) in [(0, -4.0), (10, 4.0), (60, f32::NAN)] {
            position[row] = Vec4::new(flat[row].x + far, flat[row].y, 0.0, 0.0);
        }
        let after = limited(&graph, &flat, position.clone());
        for (row, (after, before)) in after.iter().zip(&position).enumerate() {
            assert!(row == 60 || after.is_finite(), "{row}: {after}");
            assert_eq!(after.w, before.w, "{row}");
            assert!(before.w > 0.0 || row == 60 || after == before, "{row}: {after} {before}");
        }
    }

    #[test]
    fn cloth_that_is_stretched_all_over_is_left_as_it_is() {
        let (graph, flat) = square(20);
        let taut: Vec<Vec4> = flat.iter().map(|q| (q.truncate() * 1.06).extend(q.w)).collect();
        assert_eq!(limited(&graph, &flat, taut.clone()), taut);
    }
}
