//! Whom gusts keep awake. They are others in every step: what fell asleep in a lull would sleep through the next one.

use super::{Simulation, SleepScratch};
use crate::forces::Forces;

/// What a gust accelerates by more than this share of gravity is not sure to stay where it lies: hardly anything slides more easily.
const FRICTION: f32 = 0.1;

impl Simulation {
    /// Has what has a skin, and is light enough to be moved by gusts, stay awake.
    pub(super) fn stay_awake_in_gusts(&self, sleepers: &mut SleepScratch) {
        let pressure = most_of_gusts(&self.forces);
        if pressure == 0.0 {
            return;
        }
        let Self { particles, forces, scratch, .. } = self;
        let islands = &scratch.plan.islands;
        let of = |row: u32| islands.of.get(row as usize).map(|&island| island as usize);
        let SleepScratch { activities, pushes, .. } = sleepers;
        pushes.clear();
        pushes.resize(activities.len(), 0.0);
        for &[a, b, c] in &forces.surfaces {
            // What moves or may not sleep anyway needs no look.
            let waits = |&island: &usize| activities[island].allowed && !activities[island].active;
            let Some(island) = of(a).filter(waits) else { continue };
            let last = particles.len();
            if [a, b, c].into_iter().all(|row| (row as usize) < last) {
                let corner = particles.position(a as usize);
                let [ab, ac] = [b, c].map(|row| particles.relative_to(row as usize, corner));
                pushes[island] += 0.5 * ab.cross(ac).length() * pressure;
            }
        }
        let gravity = forces.gravity.length();
        for (number, push) in pushes.iter().enumerate().filter(|(_, push)| **push > 0.0) {
            let members = &islands.members[islands.list[number].members.clone()];
            let weights = members.iter().map(|&row| particles.position[row as usize].w);
            let mass: f32 = weights.filter(|&w| w > 0.0).map(f32::recip).sum();
            if *push > FRICTION * gravity * mass {
                (activities[number].allowed, activities[number].still) = (false, f32::INFINITY);
            }
        }
    }
}

/// By how much gusts change the pressure on a sheet at the most, Pa: of a wind by its share, of air by that of its speed, twice the standard deviation.
pub(super) fn most_of_gusts(forces: &Forces) -> f32 {
    let winds = forces.winds.iter().filter(|wind| wind.is_valid());
    let winds = winds.map(|wind| wind.gusts.abs() * wind.pressure.length());
    let flows = forces.air_flows.iter().filter(|flow| flow.is_valid());
    let flows = flows.map(|flow| {
        let dynamic = 0.5 * flow.density * flow.velocity.length_squared();
        let most = 1.0 + 2.0 * flow.gusts;
        dynamic * (most * most - 1.0) * (flow.drag + flow.lift)
    });
    winds.chain(flows).sum()
}
