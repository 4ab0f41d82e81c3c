//! Gather: the values of the particles' components into the columns, every tick.

use std::collections::BTreeSet;

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sinew::{ParticleFault, ParticleSeed, Pin};

use crate::components::{
    BodyParticles, Charge, Drag, ExternalForce, ExtractedTransform, GravityScale, Mass, Particle,
    ParticleRow, Pinned, PinnedTo, Radius,
};
use crate::messages::{Refusal, Refused, refuse};
use crate::step::carry::Carry;
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
        if old == *transform {
            continue;
        }
        let Some(carry) = Carry::between(&old, transform) else { continue };
        let mut moved = particles.iter_many_mut(members.iter());
        while let Some(mut particle) = moved.fetch_next() {
            carry.take(&mut particle);
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
        Option<&GravityScale>,
    )>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    simulation.boundaries.pins.clear();
    for found in &particles {
        let (entity, particle, mass, row, pinned, pinned_to, radius, charge, drag, force, scale) =
            found;
        let Some(row) = row.get() else { continue };
        let seed = ParticleSeed {
            position: particle.position,
            remainder: particle.remainder,
            velocity: particle.velocity,
            lag: particle.lag,
            mass: mass.0,
            radius: radius.map_or(0.0, |r| r.0),
            charge: charge.map_or(0.0, |c| c.0),
            drag: drag.map_or(0.0, |d| d.0),
            gravity_scale: scale.map_or(1.0, |scale| scale.0),
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
                simulation.boundaries.pins.push(Pin { particle: row as u32, target });
            }
        }
    }
    // A query's order is not the order of creation; each particle has one pin at most, so sorting makes it so.
    simulation.boundaries.pins.sort_unstable_by_key(|pin| pin.particle);
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
                    simulation.boundaries.pins.push(Pin { particle: row as u32, target });
                }
            }
            Err(_) => {
                refuse(&mut messages, entity, Refusal::PinTarget(pin.entity));
                commands.entity(entity).try_remove::<PinnedTo>();
            }
        }
    }
    simulation.boundaries.pins.sort_by_key(|pin| pin.particle);
}

/// Whether nothing is wrong; what is gets reported once, until it was mended.
pub(crate) fn sound(
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
