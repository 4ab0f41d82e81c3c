//! Flocks of twins are solved together: bodies that are the same in every number may change lanes.
//!
//! Of eight bodies that lie about, most hold after a sweep or two, and one that has just landed on its elbow spends all of its sweeps: seven lanes
//! would go on for the sake of that one. So as soon as one of a flock holds, the others wait for a lane of another pen, the ward, where they go on
//! together with those of other flocks, and whoever holds makes room for the next. A lane has the bits that its body has alone, whatever is beside
//! it, so nothing depends on who was in the ward with whom.

use super::{How, Pen};
use crate::lanes::LANES;

/// Pens of flocks that are driven together. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Herd {
    /// One for each flock, and more, which are kept for their memory.
    pens: Vec<Pen>,
    flocks: usize,
    /// Those that wait for a lane of the ward.
    waiting: Vec<Place>,
    ward: Pen,
    /// Whose bodies are in its lanes.
    beds: [Option<Place>; LANES],
}

/// A lane of a pen.
#[derive(Clone, Copy, Debug)]
struct Place {
    pen: usize,
    lane: usize,
}

impl Herd {
    /// Makes room for so many flocks.
    pub(super) fn make_room(&mut self, flocks: usize) {
        self.flocks = flocks;
        if self.pens.len() < flocks {
            self.pens.resize_with(flocks, Pen::default);
        }
    }

    /// The pens of its flocks.
    pub(super) fn pens(&mut self) -> &mut [Pen] {
        &mut self.pens[..self.flocks]
    }

    /// Solves all pens, which have been predicted.
    pub(super) fn solve(&mut self, how: &How) {
        for pen in self.pens() {
            how.begin(pen);
        }
        self.ward.clear_as(&self.pens[0]);
        let mut turn = 0;
        while let Some((pen, may_leave)) = self.take_turn(turn) {
            // While others wait for a lane, as soon as one is free is soon enough.
            let few = if may_leave { LANES as u32 - 1 } else { 0 };
            how.sweep(pen, few);
            turn += 1;
        }
    }

    /// The pen to be swept next, and whether a lane that gets free in it is of use: one flock after the other, then the ward until nobody waits.
    fn take_turn(&mut self, turn: usize) -> Option<(&mut Pen, bool)> {
        let Self { pens, flocks, waiting, ward, beds } = self;
        let pens = &mut pens[..*flocks];
        if let Some(pen) = turn.checked_sub(1).filter(|&pen| pen < pens.len()) {
            let left = (0..pens[pen].bodies).filter(|&lane| pens[pen].course.is_going(lane));
            waiting.extend(left.map(|lane| Place { pen, lane }));
        }
        if turn < pens.len() {
            let are_others = pens.len() > 1;
            return Some((&mut pens[turn], are_others));
        }
        for (lane, bed) in beds.iter_mut().enumerate() {
            if ward.course.is_going(lane) {
                continue;
            }
            if let Some(place) = bed.take() {
                pens[place.pen].take_back(place.lane, ward, lane);
            }
            *bed = waiting.pop();
            if let Some(place) = bed {
                ward.admit(lane, &pens[place.pen], place.lane);
            }
        }
        (ward.course.going != 0).then_some((ward, !waiting.is_empty()))
    }
}
