//! Gather: the values of the components into the columns, every tick; and the environment into the force laws.

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sinew::{InsideBox, ParticleFault, ParticleSeed, Pin, Plane};

use crate::components::{
    AirDrag, BodyParticles, BoundingBox, Charge, CreationOrder, Drag, Electric, ExternalForce,
    ExtractedTransform, Fluid, Gravity, Ground, Mass, Particle, ParticleRow, Pinned, PinnedTo,
    Radius, Wind,
};
use crate::config::SolverConfig;
use crate::messages::{Refusal, Refused, refuse};
use crate::schedule::SinewClock;
use crate::world::SinewWorld;

/// Moves the particles of bodies whose `Transform` somebody else changed: the change is a teleport of the whole body.
///
/// Velocities turn with the body and otherwise stay, so that a portal carries a flying box through.
pub(crate) fn follow_teleports(
    mut bodies: Query<(&Transform, &mut ExtractedTransform, &BodyParticles), Changed<Transform>>,
    mut particles: Query<&mut Particle>,
) {
    for (transform, mut known, members) in &mut bodies {
        let Some(old) = known.0 else { continue };
        if old == *transform || !transform.is_finite() {
            continue;
        }
        let turn = transform.rotation * old.rotation.inverse();
        let mut moved = particles.iter_many_mut(members.iter());
        while let Some(mut particle) = moved.fetch_next() {
            let arm = particle.position - old.translation;
            particle.position = transform.translation + turn * arm;
            particle.velocity = turn * particle.velocity;
        }
        known.0 = Some(*transform);
    }
}

/// Copies every particle into its row; a faulty one is set aside, and reported when that is news.
pub(crate) fn gather_particles(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    particles: Query<(
        Entity,
        &Particle,
        &Mass,
        &ParticleRow,
        Option<&Pinned>,
        Has<PinnedTo>,
        Option<&Radius>,
        Option<&Charge>,
        Option<&Drag>,
        Option<&ExternalForce>,
    )>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    simulation.constraints.pins.clear();
    for (entity, particle, mass, row, pinned, pinned_to, radius, charge, drag, force) in &particles
    {
        let Some(row) = row.get() else { continue };
        let seed = ParticleSeed {
            position: particle.position,
            velocity: particle.velocity,
            lag: particle.lag,
            mass: mass.0,
            radius: radius.map_or(0.0, |r| r.0),
            charge: charge.map_or(0.0, |c| c.0),
            drag: drag.map_or(0.0, |d| d.0),
        };
        let external = force.map_or(Vec3::ZERO, |f| f.0);
        let fault =
            seed.fault().or_else(|| (!external.is_finite()).then_some(ParticleFault::Force));
        if fault != tables.refused[row] {
            tables.refused[row] = fault;
            tables.stale = true;
            if let Some(fault) = fault {
                refuse(&mut messages, entity, Refusal::Particle(fault));
            }
        }
        if fault.is_some() {
            // Last good position, infinite mass, no charge: nothing notices it.
            let last = ParticleSeed::at(simulation.particles.position(row)).pinned();
            let put = simulation.particles.set(row, last);
            debug_assert!(put.is_ok(), "columns hold only finite positions");
            continue;
        }
        let held = pinned.is_some() || pinned_to;
        let seed = if held { seed.pinned() } else { seed };
        let put = simulation.particles.set(row, seed);
        debug_assert!(put.is_ok(), "the seed was checked above");
        simulation.particles.set_external_force(row, external);
        tables.mass[row] = mass.0;
        if let Some(target) = pinned.and_then(|pin| pin.target)
            && target.is_finite()
        {
            simulation.constraints.pins.push(Pin { particle: row as u32, target });
        }
    }
    // A query's order is not the order of creation; each particle has one pin at most, so sorting makes it so.
    simulation.constraints.pins.sort_unstable_by_key(|pin| pin.particle);
}

/// Leads particles that are pinned to other entities; lets go of those whose entity is gone.
pub(crate) fn gather_moving_pins(
    mut commands: Commands,
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    pins: Query<(Entity, &PinnedTo, &ParticleRow), With<Particle>>,
    transforms: TransformHelper,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    for (entity, pin, row) in &pins {
        let Some(row) = row.get() else { continue };
        if tables.refused[row].is_some() {
            continue;
        }
        // Computed afresh: GlobalTransform is a frame old in the fixed schedule.
        match transforms.compute_global_transform(pin.entity) {
            Ok(transform) => {
                let target = transform.transform_point(pin.offset);
                if target.is_finite() {
                    simulation.constraints.pins.push(Pin { particle: row as u32, target });
                }
            }
            Err(_) => {
                refuse(&mut messages, entity, Refusal::PinTarget(pin.entity));
                commands.entity(entity).try_remove::<PinnedTo>();
            }
        }
    }
    simulation.constraints.pins.sort_by_key(|pin| pin.particle);
}

/// Copies the configuration and the environment. Invalid entries are skipped by the laws themselves.
pub(crate) fn gather_environment(
    mut world: ResMut<SinewWorld>,
    config: Res<SolverConfig>,
    clock: Res<SinewClock>,
    gravity: Res<Gravity>,
    drag: Res<AirDrag>,
    electric: Res<Electric>,
    winds: Query<(&CreationOrder, &Wind)>,
    fluids: Query<(&CreationOrder, &Fluid, &Transform)>,
    grounds: Query<(&CreationOrder, &Ground, &Transform)>,
    rooms: Query<(&CreationOrder, &BoundingBox, &Transform)>,
) {
    let simulation = &mut world.simulation;
    simulation.settings = (*config).into();
    simulation.time = clock.seconds;
    let forces = &mut simulation.forces;
    forces.gravity = if gravity.0.is_finite() { gravity.0 } else { Vec3::ZERO };
    forces.drag = drag.0;
    forces.electric =
        sinew::Electric { constant: electric.constant, softening: electric.softening };

    in_order(&mut forces.winds, winds.iter().map(|(order, wind)| (*order, (*wind).into())));
    let fluid = |(order, fluid, transform): (&CreationOrder, &Fluid, &Transform)| {
        let up = transform.up();
        let level = up.dot(transform.translation);
        (*order, sinew::Fluid { up: *up, level, density: fluid.density, drag: fluid.drag })
    };
    in_order(&mut forces.fluids, fluids.iter().map(fluid));

    let constraints = &mut simulation.constraints;
    let plane = |(order, ground, transform): (&CreationOrder, &Ground, &Transform)| {
        let normal = transform.up();
        let offset = normal.dot(transform.translation);
        (*order, Plane { normal: *normal, offset, friction: ground.friction })
    };
    in_order(&mut constraints.planes, grounds.iter().map(plane));
    let room = |(order, room, transform): (&CreationOrder, &BoundingBox, &Transform)| {
        let (centre, half) = (transform.translation, room.half_size);
        let (min, max) = (centre - half, centre + half);
        (*order, InsideBox { min, max, friction: room.friction })
    };
    in_order(&mut constraints.boxes, rooms.iter().map(room));
}

/// Fills `list` in the order of creation, whatever the order of the query. There are a handful of each kind at most.
fn in_order<T>(list: &mut Vec<T>, entries: impl Iterator<Item = (CreationOrder, T)>) {
    let mut entries: Vec<_> = entries.collect();
    entries.sort_by_key(|(order, _)| *order);
    list.clear();
    list.extend(entries.into_iter().map(|(_, entry)| entry));
}
