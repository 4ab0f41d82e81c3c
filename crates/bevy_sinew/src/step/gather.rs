//! Gather: the values of the components into the columns, every tick; and the environment into the force laws.

use std::collections::BTreeSet;

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
        if let Some(target) = pinned.and_then(|pin| pin.target) {
            let reason = (!target.is_finite()).then_some(Refusal::PinPoint);
            if sound(&mut tables.broken, &mut messages, entity, reason) {
                simulation.constraints.pins.push(Pin { particle: row as u32, target });
            }
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

/// Copies the configuration and the environment; what has a broken number is left out, and reported when that is news.
pub(crate) fn gather_environment(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    config: Res<SolverConfig>,
    clock: Res<SinewClock>,
    gravity: Res<Gravity>,
    drag: Res<AirDrag>,
    electric: Res<Electric>,
    winds: Query<(Entity, &CreationOrder, &Wind)>,
    fluids: Query<(Entity, &CreationOrder, &Fluid, &Transform)>,
    grounds: Query<(Entity, &CreationOrder, &Ground, &Transform)>,
    rooms: Query<(Entity, &CreationOrder, &BoundingBox, &Transform)>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    simulation.settings = (*config).into();
    simulation.time = clock.seconds;
    let forces = &mut simulation.forces;
    forces.gravity = if gravity.0.is_finite() { gravity.0 } else { Vec3::ZERO };
    forces.drag = drag.0;
    forces.electric =
        sinew::Electric { constant: electric.constant, softening: electric.softening };

    let mut in_order = InOrder { broken: &mut tables.broken, messages: &mut messages };
    let wind = |(entity, order, wind): (Entity, &CreationOrder, &Wind)| {
        (*order, entity, sinew::Wind::from(*wind))
    };
    in_order.fill(&mut forces.winds, winds.iter().map(wind), sinew::Wind::is_valid);
    let fluid = |(entity, order, fluid, frame): (Entity, &CreationOrder, &Fluid, &Transform)| {
        let (up, level) = surface(frame);
        let fluid = sinew::Fluid { up, level, density: fluid.density, drag: fluid.drag };
        (*order, entity, fluid)
    };
    in_order.fill(&mut forces.fluids, fluids.iter().map(fluid), sinew::Fluid::is_valid);

    let constraints = &mut simulation.constraints;
    let plane = |(entity, order, ground, frame): (Entity, &CreationOrder, &Ground, &Transform)| {
        let (normal, offset) = surface(frame);
        (*order, entity, Plane { normal, offset, friction: ground.friction })
    };
    in_order.fill(&mut constraints.planes, grounds.iter().map(plane), Plane::is_valid);
    let room =
        |(entity, order, room, frame): (Entity, &CreationOrder, &BoundingBox, &Transform)| {
            let (centre, half) = (frame.translation, room.half_size);
            let (min, max) = (centre - half, centre + half);
            (*order, entity, InsideBox { min, max, friction: room.friction })
        };
    in_order.fill(&mut constraints.boxes, rooms.iter().map(room), InsideBox::is_valid);
}

/// The plane of an entity's own x and z axes: its normal, and its distance from the origin along that.
fn surface(frame: &Transform) -> (Vec3, f32) {
    // Not `Transform::up`, which asserts that a rotation is one: a broken one is to be refused, not to end the game.
    let normal = (frame.rotation * Vec3::Y).normalize_or_zero();
    (normal, normal.dot(frame.translation))
}

/// Fills lists of surroundings in the order of creation, whatever the order of the query. There are a handful of each kind at most.
struct InOrder<'a, 'w> {
    broken: &'a mut BTreeSet<Entity>,
    messages: &'a mut MessageWriter<'w, Refused>,
}

impl InOrder<'_, '_> {
    fn fill<T>(
        &mut self,
        list: &mut Vec<T>,
        entries: impl Iterator<Item = (CreationOrder, Entity, T)>,
        valid: impl Fn(&T) -> bool,
    ) {
        let mut entries: Vec<_> = entries.collect();
        entries.sort_by_key(|(order, ..)| *order);
        list.clear();
        for (_, entity, entry) in entries {
            let reason = (!valid(&entry)).then_some(Refusal::Surroundings);
            if sound(self.broken, self.messages, entity, reason) {
                list.push(entry);
            }
        }
    }
}

/// Whether nothing is wrong; what is gets reported once, until it was mended.
fn sound(
    broken: &mut BTreeSet<Entity>,
    messages: &mut MessageWriter<Refused>,
    entity: Entity,
    reason: Option<Refusal>,
) -> bool {
    let Some(reason) = reason else {
        if !broken.is_empty() {
            broken.remove(&entity);
        }
        return true;
    };
    if broken.insert(entity) {
        refuse(messages, entity, reason);
    }
    false
}
