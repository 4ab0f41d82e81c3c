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
    let both = order.iter().zip(&tables.entities);
    let same = both.take_while(|((_, new), old)| new == *old).count();
    tables.stale = true;
    if same == order.len() && same == tables.entities.len() {
        return;
    }
    tables.layout.number += 1;
    tables.layout.same = same;
    carry_over(simulation, tables, &order);
    for (row, (_, entity)) in order.iter().enumerate().skip(same) {
        if let Ok((_, _, mut its_row)) = particles.get_mut(*entity) {
            its_row.0 = row as u32;
        }
    }
}

/// Moves the rows that stay, behind those that are the same, to their new places, so that a particle that is set aside keeps its last good position.
fn carry_over(simulation: &mut Simulation, tables: &mut Tables, order: &[(CreationOrder, Entity)]) {
    let same = tables.layout.same;
    let new = order.iter().map(|(_, entity)| *entity).skip(same);
    let known = new.clone().map(|entity| {
        let old = *tables.layout.row_of.get(&entity)? as usize;
        Some((simulation.particles.position(old), tables.refused[old]))
    });
    let known: Vec<_> = known.collect();
    simulation.particles.resize(same);
    simulation.particles.resize(order.len());
    tables.refused.truncate(same);
    for (row, known) in (same..).zip(known) {
        if let Some((position, _)) = known {
            simulation.particles.set_position(row, position);
        }
        tables.refused.push(known.and_then(|(_, refused)| refused));
    }
    simulation.forget_step_start();
    tables.set_aside = tables.refused.iter().flatten().count();
    tables.mass.truncate(same);
    tables.mass.resize(order.len(), 0.0);
    let row_of = &mut tables.layout.row_of;
    for entity in tables.entities.drain(same..) {
        row_of.remove(&entity);
    }
    tables.entities.extend(new);
    row_of.extend(tables.entities.iter().copied().zip(0..).skip(same));
}
