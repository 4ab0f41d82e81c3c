//! Bodies at gather: what a body asks of the solver, and how gravity pulls on it, is written to the rows of its particles.

use std::collections::BTreeSet;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::pins::sound;
use crate::components::{BodyParticles, GravityScale};
use crate::config::BodySolver;
use crate::messages::{Refusal, Refused};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;

/// Those that have something to say.
type Speaks = (With<BodyParticles>, Or<(With<BodySolver>, With<GravityScale>)>);

/// Whether bodies have something new to say.
#[derive(SystemParam)]
pub(crate) struct Bodies<'w, 's> {
    all: Query<
        'w,
        's,
        (
            Ref<'static, BodyParticles>,
            Option<Ref<'static, BodySolver>>,
            Option<Ref<'static, GravityScale>>,
        ),
        Speaks,
    >,
    /// How many said something of each kind: what came is a change, and fewer than before is all that is left to notice.
    counts: Local<'s, [usize; 2]>,
}

impl Bodies<'_, '_> {
    /// Whether any body says anything.
    pub(crate) fn any(&self) -> bool {
        !self.all.is_empty()
    }

    /// Whether one came, went or changed since the system that asks last ran.
    pub(crate) fn changed(&mut self) -> bool {
        let (mut now, mut changed) = ([0; 2], false);
        for (members, solver, scale) in &self.all {
            now[0] += usize::from(solver.is_some());
            now[1] += usize::from(scale.is_some());
            changed |= members.is_changed();
            changed |= solver.is_some_and(|solver| solver.is_changed());
            changed |= scale.is_some_and(|scale| scale.is_changed());
        }
        let went = core::mem::replace(&mut *self.counts, now) != now;
        went || changed
    }
}

/// Writes what bodies have to say to the rows of their particles, if the rows were filled afresh with what each particle says of itself.
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
        Speaks,
    >,
    mut broken: Local<BTreeSet<Entity>>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if !tables.properties_gathered {
        tables.edits = simulation.particles.edits();
        return;
    }
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
    tables.edits = simulation.particles.edits();
}
