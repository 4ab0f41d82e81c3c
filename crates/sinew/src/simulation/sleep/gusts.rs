//! Bodies that gusts keep awake. Gusts change from step to step: a body that fell asleep in a lull would sleep through the next gust.

use super::{Simulation, SleepScratch};
use crate::forces::Forces;

/// Gust force over weight above which a body stays awake: hardly anything slides at less friction.
const FRICTION: f32 = 0.1;

impl Simulation {
    /// Keeps awake what has surfaces and is light enough to be moved by gusts.
    pub(super) fn stay_awake_in_gusts(&self, sleepers: &mut SleepScratch) {
        let pressure = max_gust_pressure(&self.forces);
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
            // Islands that move or may not sleep need no check.
            let may_fall_asleep =
                |&island: &usize| activities[island].allowed && !activities[island].active;
            let Some(island) = of(a).filter(may_fall_asleep) else { continue };
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

/// Largest change of pressure on a sheet by gusts, Pa: for a wind its share of gusts, for an air flow twice the standard deviation of its speed.
pub(super) fn max_gust_pressure(forces: &Forces) -> f32 {
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
