//! Scatter: copies the columns back into the components, at the end of a tick.

use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;

use crate::components::{Particle, ParticleRow};
use crate::messages::{Refusal, Refused, refuse};
use crate::world::SinewWorld;

/// Writes position, velocity and lag of every particle that took part. Particles that are set aside, or slept, are not written.
pub(crate) fn scatter(
    mut world: ResMut<SinewWorld>,
    ticks: SystemChangeTick,
    mut messages: MessageWriter<Refused>,
    mut particles: Query<(&mut Particle, &ParticleRow)>,
    mut awake: Local<Vec<bool>>,
) {
    world.tables.scattered = Some(ticks.this_run());
    if world.tables.rested {
        return;
    }
    let (columns, tables) = (&world.simulation.particles, &world.tables);
    list_awake(&world, &mut awake);
    // Table by table, with a whole table marked as changed at once; not if a particle in it is set aside or asleep, since that did not change.
    if !awake.is_empty() {
        if awake.contains(&true) {
            scatter_awake(&world, &mut particles, &awake);
        }
    } else if tables.set_aside == 0
        && let Ok(found) = particles.contiguous_iter_mut()
    {
        for (mut states, rows) in found {
            let mut i = 0;
            while i < rows.len() {
                let run = tables.valid_run(&rows[i..]).max(1);
                let first = rows[i].0 as usize;
                let read = columns.states(first..first.saturating_add(run));
                states[i..i + run].iter_mut().zip(read).for_each(|(to, from)| *to = from.into());
                i += run;
            }
        }
    } else {
        for (mut to, row) in &mut particles {
            let Some(row) = row.get().filter(|&row| tables.is_valid(row)) else { continue };
            columns.states(row..row + 1).for_each(|from| *to = from.into());
        }
    }
    // Without a step the report is that of an earlier one, with other rows.
    if tables.stepped {
        for &row in &world.simulation.report().frozen {
            refuse(&mut messages, tables.entities[row as usize], Refusal::Diverged);
        }
    }
}

/// Lists for each row whether it is to be written; empty if no body sleeps.
fn list_awake(world: &SinewWorld, awake: &mut Vec<bool>) {
    let SinewWorld { simulation, tables } = world;
    awake.clear();
    if !tables.asleep.contains(&true) {
        return;
    }
    let sleeps = |body: u32| tables.asleep.get(body as usize) == Some(&true);
    awake
        .extend((0..simulation.particles.len()).map(|row| {
            tables.is_valid(row) && !simulation.particles.body(row).is_some_and(sleeps)
        }));
}

/// Writes some rows, and marks only those as changed.
fn scatter_awake(
    world: &SinewWorld,
    particles: &mut Query<(&mut Particle, &ParticleRow)>,
    awake: &[bool],
) {
    let columns = &world.simulation.particles;
    let Ok(found) = particles.contiguous_iter_mut() else { return };
    for (mut states, rows) in found {
        let is_awake = |row: &ParticleRow| row.get().filter(|&row| awake.get(row) == Some(&true));
        let written = states.bypass_change_detection().iter_mut().zip(rows);
        let mut any = false;
        for (to, row) in written {
            let Some(row) = is_awake(row) else { continue };
            any = true;
            columns.states(row..row + 1).for_each(|from| *to = from.into());
        }
        if any {
            let now = states.this_run_tick();
            for (tick, row) in states.changed_ticks_slice_mut().iter_mut().zip(rows) {
                if is_awake(row).is_some() {
                    *tick = now;
                }
            }
        }
    }
}
