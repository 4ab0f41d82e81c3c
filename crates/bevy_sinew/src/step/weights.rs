//! Gathers weights: kinematic colliders press on what they stand on, as forces for the tick.

use std::collections::BTreeSet;

use bevy::prelude::*;

use super::pins::check_once;
use crate::components::{Collider, PlacedCollider, Weighs};
use crate::messages::{Refusal, Refused};
use crate::world::SinewWorld;

/// Adds the forces, collider by collider in the order of creation; after the game's control forces, whose list is built again in each tick.
pub(crate) fn gather_weights(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    weights: Query<(Entity, &Weighs, &PlacedCollider), With<Collider>>,
    mut broken: Local<BTreeSet<Entity>>,
) {
    broken.retain(|&entity| weights.contains(entity));
    let SinewWorld { simulation, tables } = &mut *world;
    let mut list: Vec<(usize, Weighs)> = Vec::new();
    for (entity, weighs, placed) in &weights {
        let reason = (!weighs.is_valid()).then_some(Refusal::Weight);
        let valid = check_once(&mut broken, &mut messages, entity, reason);
        let listed = tables.colliders.get(placed.number) == Some(&entity);
        if valid && listed && placed.valid().is_some_and(|collider| !collider.sensor) {
            list.push((placed.number, *weighs));
        }
    }
    list.sort_unstable_by_key(|&(number, _)| number);
    for (number, Weighs { mass, reach }) in list {
        simulation.press(number as u32, mass, reach);
    }
}
