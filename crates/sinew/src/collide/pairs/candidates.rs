//! Candidate pairs: a superset of the neighbour list that is kept for several steps.
//!
//! The neighbour list is a function of positions and velocities. To avoid testing all pairs, the [grid](super::grid) finds those within their allowances, which
//! are wider than the margins. Until a particle has moved by the difference, no other pair can have come within its margins, and the neighbours found among the
//! candidates are exactly those among all pairs. So no result depends on how long candidates have been kept.

use glam::DVec3;

use super::super::filter::ContactFilter;
use super::super::material::BodyContacts;
use super::grid::{PairGrid, list_candidates};
use super::participants::Participants;
use crate::lanes::InstructionSet;

/// Candidate pairs, and the state that they were found for. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates {
    /// Participant indices, the lower one first; sorted, unique.
    pub(super) pairs: Vec<[u32; 2]>,
    /// In the order in which they were found.
    found: Vec<[u32; 2]>,
    /// Scratch of the counting sort: higher indices grouped by the lower one, and the end of each group.
    sorted: Vec<u32>,
    ends: Vec<u32>,
    /// The participants and contact settings that the pairs were found for.
    rows: Vec<u32>,
    body: Vec<u32>,
    radius: Vec<f32>,
    contacts: Vec<BodyContacts>,
    /// Position of each participant at that time, metres, and its allowance: how far from there its margin may reach, metres.
    pub(super) place: Vec<DVec3>,
    allowance: Vec<f32>,
}

/// Reduction of what is left of an allowance, against rounding.
const ROUNDED: f32 = 0.99;

impl Candidates {
    /// Finds the candidates again if a pair may be missing.
    pub(super) fn update(
        &mut self,
        participants: &Participants,
        grid: &mut PairGrid,
        filter: &ContactFilter,
        instructions: InstructionSet,
    ) {
        if self.are_complete(participants, filter) {
            return;
        }
        let Participants { rows, body, radius, place, .. } = participants;
        self.rows.clone_from(rows);
        self.body.clone_from(body);
        self.radius.clone_from(radius);
        self.place.clone_from(place);
        self.contacts.clear();
        self.contacts.extend_from_slice(filter.bodies());
        self.allowance.clear();
        self.allowance.extend(participants.allowances());
        self.found.clear();
        grid.fill(participants, &self.allowance);
        list_candidates(grid, participants, filter, &mut self.found, instructions);
        self.order(rows.len());
    }

    /// Whether all pairs that are within their margins now are candidates.
    fn are_complete(&self, participants: &Participants, filter: &ContactFilter) -> bool {
        let Participants { rows, body, radius, place, home, .. } = participants;
        if self.rows != *rows
            || self.body != *body
            || self.radius != *radius
            || self.contacts != filter.bodies()
        {
            return false;
        }
        let then = self.place.iter().zip(&self.allowance);
        for ((place, home), (before, allowance)) in place.iter().zip(home).zip(then) {
            let left = f64::from((allowance - home.w) * ROUNDED);
            // A position that is or was NaN fails this test: its neighbours are unknown.
            let stays = left >= 0.0 && (*place - *before).length_squared() <= left * left;
            if !stays {
                return false;
            }
        }
        true
    }

    /// Sorts the pairs and removes duplicates: a counting sort by the lower index, then a comparison sort of each short group by the higher.
    fn order(&mut self, count: usize) {
        let Self { pairs, found, sorted, ends, .. } = self;
        pairs.clear();
        ends.clear();
        ends.resize(count + 1, 0);
        for [low, _] in found.iter() {
            ends[*low as usize + 1] += 1;
        }
        let mut sum = 0;
        for end in ends.iter_mut() {
            sum += *end;
            *end = sum;
        }
        sorted.resize(found.len(), 0);
        for &[low, high] in found.iter() {
            let at = &mut ends[low as usize];
            sorted[*at as usize] = high;
            *at += 1;
        }
        let mut begin = 0;
        for (low, &end) in ends[..count].iter().enumerate() {
            let own = &mut sorted[begin..end as usize];
            begin = end as usize;
            own.sort_unstable();
            let mut last = None;
            for &high in own.iter() {
                // A slot of the grid may hold several cells and be visited twice, so a pair can be found twice.
                if last != Some(high) {
                    pairs.push([low as u32, high]);
                }
                last = Some(high);
            }
        }
    }
}
