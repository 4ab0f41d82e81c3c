//! Strain limiting (Provot, *Deformation Constraints in a Mass-Spring Model to Describe Rigid Cloth Behavior*, 1995): the rods of large cloth that are off by more than a
//! few hundredths are brought within that, as long as those around them have room.
//!
//! What sweeps leave is not spread evenly: of a flag's 5838 rods seven are off by more than 3 %, at the corner that all of it hangs on, and where a jerk goes
//! through a large sheet a few hundred are, by up to a third. Those are few, and their neighbours have room. So a rod that is off by more than the limit is
//! projected to somewhat within it, and so are those around it that this brings beyond, and so on: a list of particles that have moved since their rods were looked
//! at, the oldest first, until it is empty. What is off most comes first: the limit is at first somewhat below the largest strain, and gets less step by step. Where a
//! jerk goes through all of a sheet, time is spent before the last limit, and what is left is spread evenly. That is Gauss and Seidel's way where it matters and
//! nowhere else, one projection where a sweep over all has hundreds.
//! Places where no rod is too long are a convex set, and where there are such this goes towards them (projections onto convex sets). What is a rope and no bar
//! may be as short as it likes.
//!
//! It is a part of [relaxation](super::relaxation), and has the rules of it: positions move, velocities do not.

use glam::Vec4;

use super::rod_graph::{RodEnd, RodGraph};
use super::rods::{Whole, project};

/// By how much of its length a rod may be off. Weft and warp of a woven cloth give way by about as much before they are taut.
const LIMIT: f32 = 0.03;

/// To which share of that it is brought. To all of it takes longer: each that moves brings its neighbours beyond.
const WITHIN: f32 = 0.9;

/// By how much the limits get less, one after the other, from what is worst down to the last. A sheet of 128 × 128 that swings from two corners, twelve starts each,
/// its worst strain and engine time by this: 1.1 11.8 % and 6.9 ms, 1.15 12.4 and 6.9, 1.2 13.0 and 7.0.
const STEP: f32 = 1.15;

/// How often each end of a rod is looked at, in the mean over all, at the most. Of the same sheet: once 14.8 % and 6.7 ms, twice 12.4 and 6.9, three times 11.3 and
/// 7.1; its slowest ticks take 3 to 4 ms more than others.
const LOOKS: usize = 2;

/// How many rounds there are at the most for one limit: the last ones are about a few rods that cannot all be met.
const ROUNDS: usize = 256;

/// Where more than one in so many particles is on the list, all of it is stretched, and nobody has room.
const MANY: usize = 2;

/// What strain limiting needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct StrainScratch {
    /// Where particles were, metres.
    pub(super) before: Vec<Vec4>,
    /// Those whose rods are to be looked at, and those in the round after.
    now: Vec<u32>,
    next: Vec<u32>,
    /// Whether each particle is among the next.
    listed: Vec<bool>,
    /// Those that have been moved, ring by ring.
    moved: Vec<u32>,
    /// Those of which a rod is beyond the last limit, and within the present one; and whether each particle is among them.
    later: Vec<u32>,
    put_off: Vec<bool>,
}

impl StrainScratch {
    /// Limits the strain of the rods of a graph, of which none is off that does not end at a particle that is elsewhere than `before`.
    pub(super) fn limit(&mut self, graph: &RodGraph, position: &mut [Vec4]) {
        let mut looks = LOOKS * graph.ends();
        self.list_moved(position);
        // Nothing is beyond that: it is found what is beyond the last limit.
        let mut limit = f32::MAX;
        while self.bring_within(graph, position, limit, &mut looks, ROUNDS) && limit > LIMIT {
            if limit == f32::MAX {
                // What is twice as long as it may be is not worth a limit of its own, however far away somebody has put it.
                limit = self.worst(graph, position).min(1.0);
            }
            limit = (limit / STEP).max(LIMIT);
            core::mem::swap(&mut self.now, &mut self.later);
        }
    }

    /// Brings the rods of some particles within the last limit, and those about them that this brings beyond it, for so many rings of rods. Returns who has
    /// moved, some more than once.
    pub(super) fn limit_about(
        &mut self,
        graph: &RodGraph,
        position: &mut [Vec4],
        particles: impl Iterator<Item = u32>,
        rings: usize,
    ) -> &[u32] {
        self.begin(position.len());
        self.now.extend(particles);
        self.bring_within(graph, position, LIMIT, &mut (LOOKS * graph.ends()), rings);
        &self.moved
    }

    /// Forgets what was listed, and makes room for so many particles.
    fn begin(&mut self, particles: usize) {
        let Self { now, next, listed, later, put_off, moved, .. } = self;
        for list in [now, next, later, moved] {
            list.clear();
            list.reserve(particles);
        }
        for flags in [listed, put_off] {
            flags.clear();
            flags.resize(particles, false);
        }
    }

    /// Lists who is elsewhere than before.
    fn list_moved(&mut self, position: &[Vec4]) {
        self.begin(position.len());
        let Self { before, now, .. } = self;
        let moved = before.iter().zip(position).zip(0..);
        now.extend(moved.filter(|((before, here), _)| before != here).map(|(_, i)| i));
    }

    /// Brings what is listed, and what that brings beyond it, within a limit; lists for later what is beyond the last one. False if there is no time left, or
    /// no room.
    fn bring_within(
        &mut self,
        graph: &RodGraph,
        position: &mut [Vec4],
        limit: f32,
        looks: &mut usize,
        rounds: usize,
    ) -> bool {
        let Self { now, next, listed, later, put_off, moved, .. } = self;
        let (band, last) = (Band::of(limit), Band::of(LIMIT));
        now.iter().for_each(|&i| put_off[i as usize] = false);
        for _ in 0..rounds {
            if now.len() * MANY > position.len() {
                return false;
            }
            now.iter().for_each(|&i| listed[i as usize] = false);
            for i in now.drain(..) {
                let rods = graph.rods_of(i);
                let Some(left) = looks.checked_sub(rods.len()) else { return false };
                *looks = left;
                let mut waits = false;
                for rod in rods {
                    if last.holds(position, i, rod) {
                        continue;
                    }
                    if band.holds(position, i, rod) {
                        waits = true;
                    } else if bring_to(position, i, rod, limit * WITHIN) {
                        for end in [i, rod.to] {
                            if !core::mem::replace(&mut listed[end as usize], true) {
                                next.push(end);
                                moved.push(end);
                            }
                        }
                    }
                }
                if waits && !core::mem::replace(&mut put_off[i as usize], true) {
                    later.push(i);
                }
            }
            core::mem::swap(now, next);
            if now.is_empty() {
                return true;
            }
        }
        // What cannot be met is left as it is, until something beside it moves.
        now.drain(..).for_each(|i| listed[i as usize] = false);
        true
    }

    /// The largest strain of what is listed for later.
    fn worst(&self, graph: &RodGraph, position: &[Vec4]) -> f32 {
        let ends =
            self.later.iter().flat_map(|&i| graph.rods_of(i).iter().map(move |rod| (i, rod)));
        let strains =
            ends.map(|(i, rod)| (libm::sqrtf(square(position, i, rod)) / rod.rest - 1.0).abs());
        strains.fold(0.0, f32::max)
    }
}

/// Between which squares of lengths rods are within a limit, as shares of the squares of their rest lengths.
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

    /// Whether a rod at a particle is within. What slackens may be as short as it likes.
    #[inline(always)]
    fn holds(&self, position: &[Vec4], i: u32, rod: &RodEnd) -> bool {
        let (square, whole) = (square(position, i, rod), rod.rest * rod.rest);
        square <= self.most * whole && (rod.slackens || self.least * whole <= square)
    }
}

/// The square of the length of a rod at a particle, m².
#[inline(always)]
fn square(position: &[Vec4], i: u32, rod: &RodEnd) -> f32 {
    (position[i as usize] - position[rod.to as usize]).truncate().length_squared()
}

/// Projects a rod to such a strain, longer or shorter than it should be as it is; says whether it moved.
#[inline]
fn bring_to(position: &mut [Vec4], i: u32, rod: &RodEnd, strain: f32) -> bool {
    let (a, b) = (i as usize, rod.to as usize);
    let is_short = square(position, i, rod) < rod.rest * rod.rest;
    let rest = rod.rest + rod.rest * if is_short { -strain } else { strain };
    let (one, other) = (position[a].to_array(), position[b].to_array());
    let (one, other, ..) = project::<f32>(one, other, rest, Whole);
    let (one, other) = (Vec4::from_array(one), Vec4::from_array(other));
    // Of two pins none moves; nor does what lies in one place, or is nowhere.
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

    /// The same of ropes, or of bars.
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
        (RodGraph::new(position.len(), &rods), position)
    }

    /// Limits it from where it was `before`.
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
        // It was there before, so the sweeps before have left it there.
        position[60] += Vec4::new(0.2, 0.0, 0.0, 0.0);
        assert_eq!(limited(&graph, &position, position.clone()), position);
    }

    #[test]
    fn ropes_stay_slack_and_are_not_seen_longer() {
        let (graph, flat) = woven(30, true);
        let mut position = flat.clone();
        position[15 * 31 + 15] += Vec4::new(0.0, 0.0, 0.6, 0.0);
        // Two that have come nearer to each other.
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
