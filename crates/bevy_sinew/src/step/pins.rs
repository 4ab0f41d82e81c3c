//! Pins at gather: the points that pinned particles are led to.

use std::collections::BTreeSet;

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sinew::Pin;

use crate::components::{Particle, ParticleRow, Pinned, PinnedTo};
use crate::messages::{Refusal, Refused, refuse};
use crate::schedule::Pace;
use crate::world::SinewWorld;

/// Leads particles that are pinned to a point, and those that are pinned to other entities; lets go of those whose entity is gone.
pub(crate) fn gather_pins(
    mut commands: Commands,
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    pinned: Query<(Entity, &Pinned, &ParticleRow), With<Particle>>,
    pinned_to: Query<(Entity, &PinnedTo, &ParticleRow), With<Particle>>,
    transforms: TransformHelper,
    pace: Res<Pace>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let particles = &simulation.particles;
    let pins = &mut simulation.boundaries.pins;
    pins.clear();
    for (entity, pin, row) in &pinned {
        let Some(row) = row.get() else { continue };
        let Some(target) = pin.target.filter(|_| tables.refused[row].is_none()) else { continue };
        let reason = (!target.is_finite()).then_some(Refusal::PinPoint);
        if sound(&mut tables.broken, &mut messages, entity, reason) {
            pins.push(Pin { particle: row as u32, target });
        }
    }
    // A query's order is not the order of creation; each particle has one pin of each kind at most, so sorting makes it so.
    pins.sort_unstable_by_key(|pin| pin.particle);
    let still = pins.len();
    for (entity, pin, row) in &pinned_to {
        let Some(row) = row.get() else { continue };
        if tables.refused[row].is_some() {
            continue;
        }
        // Computed afresh: GlobalTransform is a frame old in the fixed schedule.
        match transforms.compute_global_transform(pin.entity) {
            Ok(transform) => {
                let target = transform.transform_point(pin.offset);
                if target.is_finite() {
                    // Of several ticks in a row, each goes its part of the way.
                    let way = particles.relative_to(row, target);
                    let target = if pace.left > 1 {
                        target + way * (1.0 - 1.0 / pace.left as f32)
                    } else {
                        target
                    };
                    pins.push(Pin { particle: row as u32, target });
                }
            }
            Err(_) => {
                refuse(&mut messages, entity, Refusal::PinTarget(pin.entity));
                commands.entity(entity).try_remove::<PinnedTo>();
            }
        }
    }
    // Behind the others: of two pins on one particle, the one on an entity wins. Each list has a particle once, so nothing is left to chance.
    pins[still..].sort_unstable_by_key(|pin| pin.particle);
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
