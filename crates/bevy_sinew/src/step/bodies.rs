//! Bodies at gather: what a body asks of the solver, and how gravity pulls on it, is written to the rows of its particles.

use std::collections::BTreeSet;

use bevy::prelude::*;

use super::gather::sound;
use crate::components::{BodyParticles, GravityScale};
use crate::config::BodySolver;
use crate::messages::{Refusal, Refused};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;

/// Writes what bodies have to say to the rows of their particles. The rows were filled afresh, with what each particle says of itself.
///
/// A scale of gravity that is not finite is none, and reported when that is news.
pub(crate) fn gather_bodies(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut bodies: Query<
        (
            Entity,
            Ref<BodyParticles>,
            &mut Rows<BodyParticles>,
            Option<&BodySolver>,
            Option<&GravityScale>,
        ),
        Or<(With<BodySolver>, With<GravityScale>)>,
    >,
    mut broken: Local<BTreeSet<Entity>>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    simulation.bodies.clear();
    broken.retain(|&entity| bodies.contains(entity));
    for (entity, members, mut rows, solver, scale) in &mut bodies {
        let rows = rows.resolve(tables, members.is_changed(), members.iter());
        // The number is a place in a list and no more: nothing is ordered by it.
        let body = solver.map(|_| simulation.bodies.len() as u32);
        simulation.bodies.extend(solver.map(|&solver| sinew::BodySettings::from(solver)));
        let scale = scale.map_or(1.0, |scale| scale.0);
        let reason = (!scale.is_finite()).then_some(Refusal::GravityScale);
        let sound = sound(&mut broken, &mut messages, entity, reason);
        let scale = if sound { scale } else { 1.0 };
        for &row in rows.iter().filter(|&&row| row != GONE) {
            simulation.particles.set_body(row as usize, body);
            simulation.particles.scale_gravity(row as usize, scale);
        }
    }
}
