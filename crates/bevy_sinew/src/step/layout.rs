//! Layout: assigns rows to particles, only when particles are added or removed.

use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;
use sinew::Simulation;

use crate::components::{
    CreationCounter, CreationOrder, Particle, ParticleRow, TopologyChanged, fill_sorted,
};
use crate::world::{SinewWorld, Tables};

/// Assigns each particle its row, in the order of creation, if any was added or removed since the last tick.
pub(crate) fn lay_out(
    mut changed: ResMut<TopologyChanged>,
    mut counter: ResMut<CreationCounter>,
    mut world: ResMut<SinewWorld>,
    mut particles: Query<(Entity, &mut CreationOrder, &mut ParticleRow), With<Particle>>,
    disabled: Query<Entity, (With<Particle>, With<Disabled>)>,
    mut scratch: Local<LayoutScratch>,
) {
    if !changed.0 {
        return;
    }
    changed.0 = false;

    let SinewWorld { simulation, tables } = &mut *world;
    fill_sorted(&mut tables.disabled, disabled.iter());
    let (LayoutScratch { present, new }, mut order) =
        (&mut *scratch, core::mem::take(&mut tables.order));
    let last = &mut order;
    present.clear();
    present.resize(last.len(), false);
    new.clear();
    for (entity, mut number, row) in &mut particles {
        // Particles that were spawned before the plugin was added.
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
    // The remaining particles are sorted already, and new ones usually come after them.
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
    tables.links_stale = true;
    let is_same = same == last.len() && same == tables.entities.len();
    if !is_same {
        assign_rows(simulation, tables, &mut particles, (last, same));
    }
    tables.order = order;
}

/// Scratch memory.
#[derive(Default)]
pub(crate) struct LayoutScratch {
    /// For each row, whether its particle still exists.
    present: Vec<bool>,
    new: Vec<(CreationOrder, Entity)>,
}

/// Assigns rows to all particles but the leading ones that are the same.
fn assign_rows(
    simulation: &mut Simulation,
    tables: &mut Tables,
    particles: &mut Query<(Entity, &mut CreationOrder, &mut ParticleRow), With<Particle>>,
    (order, same): (&[(CreationOrder, Entity)], usize),
) {
    tables.layout.number += 1;
    tables.layout.same = same;
    // The resize does not count as an edit by the game.
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

/// Moves the remaining rows to their new places, so that a particle that is set aside keeps its last valid position.
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
    tables.properties.lay_out(same, order.len());
    let row_of = &mut tables.layout.row_of;
    for entity in tables.entities.drain(same..) {
        row_of.remove(&entity);
    }
    tables.entities.extend(new);
    row_of.extend(tables.entities.iter().copied().zip(0..).skip(same));
}
