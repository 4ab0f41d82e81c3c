//! Candidates: pairs among which the neighbours are, kept for several steps.
//!
//! Which pairs are listed is a function of where particles are and how fast they go; to find them among all pairs is what the [grid](super::grid) is for. It is
//! asked for those that are nearer than their margins allow and some more, and until somebody has used that up, no others can have got within their margins: then
//! the neighbours are found among these, to the bits of asking everyone. So nothing depends on how long they have been kept.

use glam::DVec3;

use super::super::filter::ContactFilter;
use super::super::material::BodyContacts;
use super::grid::{PairGrid, list_candidates};
use super::participants::Participants;
use crate::lanes::InstructionSet;

/// Pairs, and what they were found by. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates {
    /// Members, the lower one first; sorted, each once.
    pub(super) pairs: Vec<[u32; 2]>,
    /// As they were found.
    found: Vec<[u32; 2]>,
    /// The higher ones by the lower; then where those of each member end.
    sorted: Vec<u32>,
    ends: Vec<u32>,
    /// Who took part, and how.
    rows: Vec<u32>,
    body: Vec<u32>,
    radius: Vec<f32>,
    contacts: Vec<BodyContacts>,
    /// Where each was, and how far from there its margin may reach, metres.
    pub(super) place: Vec<DVec3>,
    allowance: Vec<f32>,
}

/// What is left of an allowance for rounding.
const ROUNDED: f32 = 0.99;

impl Candidates {
    /// Finds them anew if some may be missing.
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

    /// Whether all pairs that are within their margins now are among them.
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
            // Who is nowhere, or was, is not known to be near nobody.
            let stays = left >= 0.0 && (*place - *before).length_squared() <= left * left;
            if !stays {
                return false;
            }
        }
        true
    }

    /// Puts all in order: by counting those of each lower one, and then those few by the higher.
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
                // Slots may hold several cells, and so be asked twice.
                if last != Some(high) {
                    pairs.push([low as u32, high]);
                }
                last = Some(high);
            }
        }
    }
}
