//! Impact zones, for contacts that do not converge: candidates that would still pass through each other move together for the rest of the substep.
//!
//! A particle between two triangles that both press on it can be pushed by each through the other, for ever. So after the sweeps, all members of contacts that
//! still pass through each other are merged into one zone (after Provot 1997, and Bridson and others 2002), and all of a zone are displaced as its centre of
//! mass is: none has moved relative to another, so none can have passed through another. Momentum is conserved; only their relative motion in this substep is
//! lost.
//!
//! A zone may now pass through others; then they are merged. In the end nothing passes through anything, unless pinned members with different displacements
//! force it.

use glam::DVec3;

use super::search::TriangleCandidate;
use super::solve::SubstepState;
use crate::lanes::SetLanes;
use crate::union_find::UnionFind;

/// Zones of a substep. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Zones {
    /// Union-find over the members; empty as long as there is no zone.
    connected: UnionFind,
    /// Sums of each zone, by its root.
    sums: Vec<ZoneSum>,
}

#[derive(Clone, Copy, Debug, Default)]
struct ZoneSum {
    mass: f64,
    moment: DVec3,
    pinned: f64,
    pinned_displacement: DVec3,
    participants: u32,
}

/// Greatest number of rounds in which zones grow. Each adds contacts further away; if that many are not enough, the world is so crowded that no number is.
const ROUNDS: u32 = 16;

impl Zones {
    /// Finds candidates with moved members that still pass through each other, and moves their zones. Returns the number of rounds; zero if there are none.
    pub(super) fn resolve(
        &mut self,
        candidates: &[TriangleCandidate],
        state: &mut SubstepState,
        sweep: u32,
    ) -> u32 {
        self.connected.reset(0);
        let mut since = 1;
        for round in 0..ROUNDS {
            let sweep = sweep + round;
            if !self.merge(candidates, state, since) {
                return round;
            }
            self.move_zones(state, sweep);
            since = sweep;
        }
        ROUNDS
    }

    /// Merges the members of candidates that pass through each other. Returns whether there are any.
    fn merge(
        &mut self,
        candidates: &[TriangleCandidate],
        state: &mut SubstepState,
        since: u32,
    ) -> bool {
        state.close.update();
        let mut any = false;
        for (place, close) in
            (0..).map_while(|place| Some((place, state.close.close_lanes(place, 0)?)))
        {
            for lane in SetLanes(close) {
                let number = state.close.number(place, lane as u32);
                let candidate = &candidates[number as usize];
                if !state.moved_since(candidate.four, since)
                    || state.four(candidate).crossing().is_none()
                {
                    continue;
                }
                if self.connected.len() == 0 {
                    self.connected.reset(state.at.len());
                }
                any = true;
                for &other in &candidate.four[1..] {
                    self.connected.unite(candidate.four[0], other);
                }
            }
        }
        any
    }

    /// Moves each zone as one.
    fn move_zones(&mut self, state: &mut SubstepState, sweep: u32) {
        let Self { connected, sums } = self;
        sums.clear();
        sums.resize(connected.len(), ZoneSum::default());
        for i in 0..connected.len() {
            let sum = &mut sums[connected.root(i as u32) as usize];
            let (displacement, weight) = (state.at[i] - state.from[i], state.weight[i]);
            sum.participants += 1;
            if weight > 0.0 {
                sum.mass += 1.0 / weight;
                sum.moment += displacement / weight;
            } else {
                sum.pinned += 1.0;
                sum.pinned_displacement += displacement;
            }
        }
        for i in 0..connected.len() {
            let sum = &sums[connected.root(i as u32) as usize];
            if sum.participants < 2 || state.weight[i] == 0.0 {
                continue;
            }
            let displacement = if sum.pinned > 0.0 {
                sum.pinned_displacement / sum.pinned
            } else {
                sum.moment / sum.mass
            };
            state.move_to(i, state.from[i] + displacement, sweep);
        }
    }
}
