//! Scatter: the columns back into the components, at the end of a tick.

use bevy::prelude::*;
use sinew::ParticleState;

use crate::components::{Particle, ParticleRow};
use crate::messages::{Refusal, Refused, refuse};
use crate::world::SinewWorld;

/// Writes position, velocity and lag of every particle that took part; one that was set aside keeps what it has.
pub(crate) fn scatter(
    world: Res<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut particles: Query<(&mut Particle, &ParticleRow)>,
) {
    let (columns, tables) = (&world.simulation.particles, &world.tables);
    // Table by table, all of a table marked as changed at once. Not with one set aside among them: that one did not change.
    if tables.set_aside == 0
        && let Ok(found) = particles.contiguous_iter_mut()
    {
        for (mut states, rows) in found {
            let mut i = 0;
            while i < rows.len() {
                let run = tables.sound_run(&rows[i..]).max(1);
                let first = rows[i].0 as usize;
                let read = columns.states(first..first.saturating_add(run));
                states[i..i + run].iter_mut().zip(read).for_each(|(to, from)| *to = particle(from));
                i += run;
            }
        }
    } else {
        for (mut to, row) in &mut particles {
            let Some(row) = row.get().filter(|&row| tables.is_sound(row)) else { continue };
            columns.states(row..row + 1).for_each(|from| *to = particle(from));
        }
    }
    for &row in &world.simulation.report().frozen {
        refuse(&mut messages, tables.entities[row as usize], Refusal::Diverged);
    }
}

/// A particle in a state.
pub(crate) fn particle(state: ParticleState) -> Particle {
    let ParticleState { position, remainder, velocity, lag } = state;
    Particle { position, remainder, velocity, lag }
}
