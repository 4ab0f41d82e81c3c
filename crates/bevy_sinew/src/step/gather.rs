//! Gather: copies the components of particles into the columns, every tick.
//!
//! A warm tick copies what moves, the [`Particle`]s, table by table. Properties that rarely change (mass, radius, charge and so on) stay in the columns. They
//! are copied again for particles for which Bevy detected a change, or whose set of components differs from before; and for all particles if a game has written
//! to the columns. A write that bypasses Bevy's change detection is therefore not seen, except in a [`Particle`] that is awake. A sleeping `Particle` is not
//! scattered, so its change tick tells whether anything else wrote to it; if nothing did, its state is in the columns as well.

use bevy::ecs::change_detection::ContiguousRef;
use bevy::prelude::*;
use sinew::{ParticleFault, ParticleSeed};

use super::bodies::Bodies;
use crate::changes::ChangeTicks;
use crate::components::{
    Charge, Drag, ExternalForce, GravityScale, Mass, Particle, ParticleRow, Pinned, PinnedTo,
    Radius,
};
use crate::messages::{Refusal, Refused, refuse};
use crate::world::{GatheredProperties, SinewWorld, Tables};

/// The components of a particle.
type ParticleData = (
    Entity,
    Ref<'static, Particle>,
    &'static ParticleRow,
    Ref<'static, Mass>,
    Option<Ref<'static, Pinned>>,
    Option<Ref<'static, PinnedTo>>,
    Option<Ref<'static, Radius>>,
    Option<Ref<'static, Charge>>,
    Option<Ref<'static, Drag>>,
    Option<Ref<'static, ExternalForce>>,
    Option<Ref<'static, GravityScale>>,
);

/// The columns of a table: as many entries in each as there are entities.
type Table<'w> = (
    &'w [Entity],
    ContiguousRef<'w, Particle>,
    &'w [ParticleRow],
    ContiguousRef<'w, Mass>,
    Option<ContiguousRef<'w, Pinned>>,
    Option<ContiguousRef<'w, PinnedTo>>,
    Option<ContiguousRef<'w, Radius>>,
    Option<ContiguousRef<'w, Charge>>,
    Option<ContiguousRef<'w, Drag>>,
    Option<ContiguousRef<'w, ExternalForce>>,
    Option<ContiguousRef<'w, GravityScale>>,
);

/// Copies every particle into its row; one with an error is set aside, and reported once.
pub(crate) fn gather_particles(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    particles: Query<ParticleData>,
    mut bodies: Bodies,
) {
    // All of these components have table storage.
    let Ok(tables) = particles.contiguous_iter() else { return };
    let (mut counts, mut changed, mut added) = ([0; 8], false, false);
    for table in tables {
        let change_ticks = change_ticks(&table);
        counts.iter_mut().zip(&change_ticks).for_each(|(sum, change_ticks)| {
            *sum += change_ticks.map_or(0, |change_ticks| change_ticks.len());
        });
        if properties_changed(&table) {
            changed = true;
            added |= change_ticks.iter().flatten().any(ChangeTicks::any_added);
        }
    }
    let SinewWorld { simulation, tables } = &mut *world;
    let layout = tables.layout.number;
    let is_relaid = core::mem::replace(&mut tables.properties.layout, layout) != layout;
    // As many components may have been removed as were added, which the counts do not show.
    let removed =
        core::mem::replace(&mut tables.properties.counts, counts) != counts || added || is_relaid;
    let which = match tables.edits != simulation.particles.edits() {
        true => DirtyProperties::All,
        false if changed || removed => DirtyProperties::Changed { removed },
        false => DirtyProperties::None,
    };
    tables.bodies_changed = bodies.changed() | is_relaid;
    let any = which != DirtyProperties::None || tables.bodies_changed;
    note_dirty_rows(&mut world, &particles, any);
    world.tables.properties_gathered = false;
    (world.tables.rested, world.tables.stepped) = (false, false);
    world.tables.deferred = !any && world.is_settled();
    if !world.tables.deferred {
        world.tables.properties_gathered =
            gather_tables(&mut world, &mut messages, &particles, which);
    }
}

/// The particles whose properties must be copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DirtyProperties {
    None,
    /// Those that changed, and, if components may have been `removed`, those with other components than before.
    Changed {
        removed: bool,
    },
    All,
}

/// If any body sleeps, lists the particles that anything but the simulation has written to.
fn note_dirty_rows(world: &mut SinewWorld, particles: &Query<ParticleData>, all: bool) {
    let Tables { dirty, asleep, scattered, .. } = &mut world.tables;
    dirty.rows.clear();
    let any = asleep.contains(&true);
    dirty.all = all || !any;
    if !any {
        return;
    }
    for table in particles.contiguous_iter().into_iter().flatten() {
        let change_ticks = ChangeTicks::of(&table.1);
        if change_ticks.any_changed() {
            let by_others = |&place: &usize| Some(change_ticks.when(place)) != *scattered;
            let rows = change_ticks.changed().filter(by_others).map(|place| table.2[place].0);
            dirty.rows.extend(rows);
        }
    }
}

/// Copies the states of all particles, and the properties of some. Returns whether there were such.
fn gather_tables(
    world: &mut SinewWorld,
    messages: &mut MessageWriter<Refused>,
    particles: &Query<ParticleData>,
    which: DirtyProperties,
) -> bool {
    let (mut any, keeps_sleepers) = (false, world.keeps_sleepers());
    let mut dirty = Vec::new();
    for table in particles.contiguous_iter().into_iter().flatten() {
        let (states, rows) = (&*table.1, table.2);
        mark_dirty(&world.tables.properties, &table, which, &mut dirty);
        let mut i = 0;
        while i < rows.len() {
            if dirty.get(i) == Some(&true) {
                any |= gather_one(world, messages, &table, (i, true));
                i += 1;
                continue;
            }
            let next = dirty.get(i..).and_then(|rest| rest.iter().position(|&dirty| dirty));
            let mut end = next.map_or(rows.len(), |next| i + next);
            if keeps_sleepers {
                i += world.sleeping_run(states, &rows[..end], i);
                if i == end {
                    continue;
                }
                end = i + world.waking_run(&rows[..end], i);
            }
            let run = world.tables.valid_run(&rows[i..end]);
            let loaded = world.load(&states[..end], &rows[..end], i);
            i += loaded;
            // The run ended at a particle that is or was set aside.
            if loaded == 0 || loaded < run {
                any |= gather_one(world, messages, &table, (i, false));
                i += 1;
            }
        }
    }
    any
}

/// Marks the entries of a table whose properties must be copied; empty if there are none.
fn mark_dirty(
    gathered: &GatheredProperties,
    table: &Table,
    which: DirtyProperties,
    dirty: &mut Vec<bool>,
) {
    let rows = table.2;
    dirty.clear();
    let removed = match which {
        DirtyProperties::None => return,
        DirtyProperties::All => return dirty.resize(rows.len(), true),
        DirtyProperties::Changed { removed } => removed,
    };
    if removed {
        let kinds = kinds(table);
        let others = |row: &ParticleRow| gathered.kinds.get(row.0 as usize) != Some(&kinds);
        dirty.extend(rows.iter().map(others));
    }
    dirty.resize(rows.len(), false);
    let [pinned, pinned_to, rest @ ..] = change_ticks(table);
    for change_ticks in [pinned, pinned_to].iter().flatten().filter(|one| one.any_added()) {
        change_ticks.added().for_each(|place| dirty[place] = true);
    }
    for change_ticks in rest.iter().flatten().filter(|one| one.any_changed()) {
        change_ticks.changed().for_each(|place| dirty[place] = true);
    }
}

/// Copies all properties of one particle. Returns whether it did: a particle that is and was set aside is copied only if `anew`.
fn gather_one(
    world: &mut SinewWorld,
    messages: &mut MessageWriter<Refused>,
    table: &Table,
    (i, anew): (usize, bool),
) -> bool {
    let (entities, states, rows, mass, pinned, pinned_to, radius, charge, drag, force, scale) =
        table;
    let SinewWorld { simulation, tables } = world;
    let Some(row) = rows[i].get().filter(|&row| row < tables.refused.len()) else { return false };
    let particle = states[i];
    let seed = ParticleSeed {
        position: particle.position,
        remainder: particle.remainder,
        velocity: particle.velocity,
        lag: particle.lag,
        mass: mass[i].0,
        radius: radius.as_ref().map_or(0.0, |all| all[i].0),
        charge: charge.as_ref().map_or(0.0, |all| all[i].0),
        drag: drag.as_ref().map_or(0.0, |all| all[i].0),
        gravity_scale: scale.as_ref().map_or(1.0, |all| all[i].0),
    };
    let external = force.as_ref().map_or(Vec3::ZERO, |all| all[i].0);
    let fault = seed.fault().or_else(|| (!external.is_finite()).then_some(ParticleFault::Force));
    let is_new = fault != tables.refused[row];
    if is_new {
        tables.set_aside += usize::from(fault.is_some());
        tables.set_aside -= usize::from(tables.refused[row].is_some());
        tables.refused[row] = fault;
        tables.links_stale = true;
        if let Some(fault) = fault {
            refuse(messages, entities[i], Refusal::Particle(fault));
        }
    }
    if fault.is_some() && !(is_new || anew) {
        return false;
    }
    tables.properties.kinds[row] = kinds(table);
    tables.properties.gravity_scale[row] = 1.0;
    if fault.is_some() {
        // The last valid position, infinite mass and no charge: it has no effect on others.
        let last = ParticleSeed::at(simulation.particles.position(row)).pinned();
        let put = simulation.particles.set(row, last);
        debug_assert!(put.is_ok(), "columns hold only finite positions");
        return true;
    }
    tables.properties.gravity_scale[row] = seed.gravity_scale;
    let is_pinned = pinned.is_some() || pinned_to.is_some();
    let put = simulation.particles.set(row, if is_pinned { seed.pinned() } else { seed });
    debug_assert!(put.is_ok(), "the seed was checked above");
    // `set` has cleared the force.
    if external != Vec3::ZERO {
        simulation.particles.set_external_force(row, external);
    }
    tables.mass[row] = mass[i].0;
    true
}

/// Whether anything but positions and velocities changed in a table. Adding a pin counts, moving its target does not.
fn properties_changed(table: &Table) -> bool {
    let [pinned, pinned_to, rest @ ..] = change_ticks(table);
    [pinned, pinned_to].iter().flatten().any(ChangeTicks::any_added)
        || rest.iter().flatten().any(ChangeTicks::any_changed)
}

/// The optional columns that a table has, one bit each. Mass is always present.
fn kinds(table: &Table) -> u8 {
    change_ticks(table).iter().rev().fold(0, |bits, column| bits << 1 | u8::from(column.is_some()))
}

/// The columns of a table with properties.
fn change_ticks<'w>(table: &Table<'w>) -> [Option<ChangeTicks<'w>>; 8] {
    let (.., mass, pinned, pinned_to, radius, charge, drag, force, scale) = table;
    [
        pinned.as_ref().map(ChangeTicks::of),
        pinned_to.as_ref().map(ChangeTicks::of),
        Some(ChangeTicks::of(mass)),
        radius.as_ref().map(ChangeTicks::of),
        charge.as_ref().map(ChangeTicks::of),
        drag.as_ref().map(ChangeTicks::of),
        force.as_ref().map(ChangeTicks::of),
        scale.as_ref().map(ChangeTicks::of),
    ]
}
