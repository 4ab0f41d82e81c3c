//! Gathers pins: the targets of pinned particles.

use std::collections::BTreeSet;

use bevy::prelude::*;
use sinew::Pin;

use crate::components::{Particle, ParticleRow, Pinned, PinnedTo};
use crate::frames::Frames;
use crate::messages::{Refusal, Refused, refuse};
use crate::schedule::FixedTick;
use crate::world::SinewWorld;

/// Lists the targets of particles that are pinned to a point or to another entity; releases those whose entity is gone.
pub(crate) fn gather_pins(
    mut commands: Commands,
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    pinned: Query<(Entity, &Pinned, &ParticleRow), With<Particle>>,
    pinned_to: Query<(Entity, &PinnedTo, &ParticleRow), With<Particle>>,
    frames: Frames,
    fixed_tick: Res<FixedTick>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let particles = &simulation.particles;
    let pins = &mut simulation.boundaries.pins;
    pins.clear();
    for (entity, pin, row) in &pinned {
        let Some(row) = row.get() else { continue };
        let Some(target) = pin.target.filter(|_| tables.refused[row].is_none()) else { continue };
        let reason = (!target.is_finite()).then_some(Refusal::PinPoint);
        if check_once(&mut tables.broken, &mut messages, entity, reason) {
            pins.push(Pin { particle: row as u32, target });
        }
    }
    // A query's order is not the order of creation. Each particle has one pin of each kind at most, so sorting by row is sufficient.
    pins.sort_unstable_by_key(|pin| pin.particle);
    let still = pins.len();
    for (entity, pin, row) in &pinned_to {
        let Some(row) = row.get() else { continue };
        if tables.refused[row].is_some() {
            continue;
        }
        // Computed on demand: `GlobalTransform` is a frame old in the fixed schedule.
        match frames.matrix(pin.entity) {
            Some(transform) => {
                let target = transform.transform_point(pin.offset);
                if target.is_finite() {
                    // If several ticks are run in a row, each moves by its share of the way.
                    let way = particles.relative_to(row, target);
                    let target = if fixed_tick.remaining > 1 {
                        target + way * (1.0 - 1.0 / fixed_tick.remaining as f32)
                    } else {
                        target
                    };
                    pins.push(Pin { particle: row as u32, target });
                }
            }
            None => {
                refuse(&mut messages, entity, Refusal::PinTarget(pin.entity));
                commands.entity(entity).try_remove::<PinnedTo>();
            }
        }
    }
    // After the others: of two pins on one particle, the one on an entity takes effect. Each list has a particle once, so the order is unique.
    pins[still..].sort_unstable_by_key(|pin| pin.particle);
}

/// Whether there is no error; an error is reported once, until it is corrected.
pub(crate) fn check_once(
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
