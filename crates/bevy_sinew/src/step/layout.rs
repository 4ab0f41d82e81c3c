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
    mut found: Local<Scratch>,
) {
    if !changed.0 {
        return;
    }
    changed.0 = false;

    let SinewWorld { simulation, tables } = &mut *world;
    let (Scratch { present, new }, mut order) = (&mut *found, core::mem::take(&mut tables.order));
    let last = &mut order;
    present.clear();
    present.resize(last.len(), false);
    new.clear();
    for (entity, mut number, row) in &mut particles {
        // Spawned before the plugin was there to count.
        if number.0 == 0 {
            counter.0 += 1;
            number.0 = counter.0;
        }
        let own = (*number, entity);
        match row.get().filter(|&row| last.get(row) == Some(&own)) {
            Some(row) => present[row] = true,
            None => new.push(own),
        }
    }
    let mut same = present.iter().position(|&present| !present).unwrap_or(last.len());
    // Those that stay are in order already, and what is new mostly comes behind them.
    let mut is_present = present.iter();
    last.retain(|_| is_present.next() == Some(&true));
    new.sort_unstable();
    if let (Some(first), Some(own)) = (new.first(), last.last())
        && first < own
    {
        same = same.min(last.partition_point(|own| own < first));
        last.extend_from_slice(new);
        last.sort_unstable();
    } else {
        last.extend_from_slice(new);
    }
    tables.stale = true;
    let is_same = same == last.len() && same == tables.entities.len();
    if !is_same {
        assign_rows(simulation, tables, &mut particles, (last, same));
    }
    tables.order = order;
}

/// Memory.
#[derive(Default)]
pub(crate) struct Scratch {
    /// For each row whether its particle is still there.
    present: Vec<bool>,
    new: Vec<(CreationOrder, Entity)>,
}

/// Gives all their rows but so many, from the first on, that keep theirs.
fn assign_rows(
    simulation: &mut Simulation,
    tables: &mut Tables,
    particles: &mut Query<(Entity, &mut CreationOrder, &mut ParticleRow), With<Particle>>,
    (order, same): (&[(CreationOrder, Entity)], usize),
) {
    tables.layout.number += 1;
    tables.layout.same = same;
    // Making room is no edit of the game's.
    let unedited = tables.edits == simulation.particles.edits();
    carry_over(simulation, tables, order);
    if unedited {
        tables.edits = simulation.particles.edits();
    }
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
    tables.held.lay_out(same, order.len());
    let row_of = &mut tables.layout.row_of;
    for entity in tables.entities.drain(same..) {
        row_of.remove(&entity);
    }
    tables.entities.extend(new);
    row_of.extend(tables.entities.iter().copied().zip(0..).skip(same));
}
