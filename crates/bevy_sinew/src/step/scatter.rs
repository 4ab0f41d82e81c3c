//! Scatter: the columns back into the components, at the end of a tick.

use bevy::prelude::*;

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
    for (mut particle, row) in &mut particles {
        let Some(row) = row.get() else { continue };
        if tables.refused[row].is_none() {
            *particle = Particle {
                position: columns.position(row),
                remainder: columns.remainder(row),
                velocity: columns.velocity(row),
                lag: columns.lag(row),
            };
        }
    }
    for &row in &world.simulation.report().frozen {
        refuse(&mut messages, tables.entities[row as usize], Refusal::Diverged);
    }
}
