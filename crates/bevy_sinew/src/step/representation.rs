//! Passes to the solver which bodies are explicit rigid bodies, when that changes.

use bevy::prelude::*;

use crate::components::{CreationOrder, Representation, RigidPose};
use crate::messages::{Refusal, Refused, refuse};
use crate::rows::ResolvedRows;
use crate::world::SinewWorld;

/// Lists the compounds again if particles were added or removed, or a body changed its representation.
///
/// A body that cannot be rigid, because it has no [`RigidPose`] or one of its particles is gone or set aside, remains particles.
pub(crate) fn compile_compounds(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    changed: Query<Entity, Changed<Representation>>,
    unposed: Query<(), (With<Representation>, Without<RigidPose>)>,
    mut bodies: Query<(
        &CreationOrder,
        &Representation,
        Ref<RigidPose>,
        &mut ResolvedRows<RigidPose>,
    )>,
    mut count: Local<usize>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    // A removal is not detected as a change, but it changes the count.
    let now = bodies.iter().len();
    let count_changed = core::mem::replace(&mut *count, now) != now;
    if !tables.links_stale && !count_changed && changed.is_empty() {
        return;
    }
    tables.links_stale = true;
    for entity in changed.iter().filter(|&entity| unposed.contains(entity)) {
        refuse(&mut messages, entity, Refusal::Representation);
    }
    let mut compounds = Vec::new();
    for (order, representation, pose, mut rows) in &mut bodies {
        let Representation::Rigid(integrator) = *representation else { continue };
        let rows = rows.resolve(&tables.layout, pose.is_changed(), pose.particles.iter().copied());
        let valid = |&row: &u32| tables.is_valid(row as usize);
        if rows.len() == pose.rest.len() && rows.iter().all(valid) {
            let rows = rows.iter().map(|&row| row as usize);
            let compound = sinew::Compound::new(rows, pose.rest.clone());
            compounds.push((*order, sinew::Compound { integrator: integrator.into(), ..compound }));
        }
    }
    compounds.sort_by_key(|(order, _)| *order);
    let compounds = compounds.into_iter().map(|(_, compound)| compound);
    // Written only if different, since writing causes everything to be compiled again.
    if !compounds.clone().eq(simulation.compounds().iter().cloned()) {
        *simulation.compounds_mut() = compounds.collect();
    }
}
