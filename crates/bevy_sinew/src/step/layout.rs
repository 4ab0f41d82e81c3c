//! Layout: which particle has which row. Done afresh when particles come or go, and only then.

use bevy::prelude::*;
use sinew::Simulation;

use crate::components::{CreationCounter, CreationOrder, Particle, ParticleRow, TopologyChanged};
use crate::world::{SinewWorld, Tables};

/// Gives each particle its row, in the order of creation, if any came or went since the last tick.
pub(crate) fn lay_out(
    mut changed: ResMut<TopologyChanged>,
    mut counter: ResMut<CreationCounter>,
    mut world: ResMut<SinewWorld>,
    mut particles: Query<(Entity, &mut CreationOrder, &mut ParticleRow), With<Particle>>,
    mut order: Local<Vec<(CreationOrder, Entity)>>,
) {
    if !changed.0 {
        return;
    }
    changed.0 = false;

    order.clear();
    for (entity, mut number, _) in &mut particles {
        // Spawned before the plugin was there to count.
        if number.0 == 0 {
            counter.0 += 1;
            number.0 = counter.0;
        }
        order.push((*number, entity));
    }
    order.sort_unstable();

    let SinewWorld { simulation, tables } = &mut *world;
    let unchanged = order.len() == tables.entities.len()
        && order.iter().zip(&tables.entities).all(|((_, new), old)| new == old);
    tables.stale = true;
    if unchanged {
        return;
    }
    tables.layout.number += 1;
    carry_over(simulation, tables, &order);
    for (row, (_, entity)) in order.iter().enumerate() {
        if let Ok((_, _, mut its_row)) = particles.get_mut(*entity) {
            its_row.0 = row as u32;
        }
    }
}

/// Moves the rows that stay to their new places, so that a particle that is set aside keeps its last good position.
fn carry_over(simulation: &mut Simulation, tables: &mut Tables, order: &[(CreationOrder, Entity)]) {
    let mut columns = sinew::Particles::default();
    columns.resize(order.len());
    let mut refused = vec![None; order.len()];
    for (row, (_, entity)) in order.iter().enumerate() {
        if let Some(&old) = tables.layout.row_of.get(entity) {
            let position = simulation.particles.position(old as usize);
            columns.set_position(row, position);
            refused[row] = tables.refused[old as usize];
        }
    }
    simulation.particles = columns;
    simulation.forget_step_start();
    tables.set_aside = refused.iter().flatten().count();
    tables.refused = refused;
    tables.mass.clear();
    tables.mass.resize(order.len(), 0.0);
    tables.entities.clear();
    tables.entities.extend(order.iter().map(|(_, entity)| *entity));
    tables.layout.row_of.clear();
    let rows = tables.entities.iter().zip(0..);
    tables.layout.row_of.extend(rows.map(|(entity, row)| (*entity, row)));
}
