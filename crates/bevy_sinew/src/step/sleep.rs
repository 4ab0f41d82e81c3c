//! Sleep: what bodies keep of it goes to the solver before a tick and comes back after it.

use bevy::prelude::*;

use crate::components::{BodyParticles, Collider, Gravity, Sleep};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;

/// What surrounds bodies: where something of it changed, all wake.
type Surroundings =
    Or<(Changed<Collider>, Changed<crate::Ground>, Changed<crate::Wind>, Changed<crate::Fluid>)>;

/// Tells the solver who may sleep and who does.
pub(crate) fn gather_sleep(
    mut world: ResMut<SinewWorld>,
    gravity: Res<Gravity>,
    changed: Query<(), Surroundings>,
    colliders: Query<(), With<Collider>>,
    mut bodies: Query<(&Rows<BodyParticles>, &mut Sleep)>,
    mut count: Local<usize>,
) {
    let simulation = &mut world.simulation;
    simulation.sleep.clear();
    let number = colliders.iter().len();
    let went = core::mem::replace(&mut *count, number) != number;
    if bodies.is_empty() {
        return;
    }
    simulation.sleep.resize(simulation.bodies.len(), sinew::Sleep::default());
    let wakes = went || gravity.is_changed() || !changed.is_empty();
    for (rows, mut sleep) in &mut bodies {
        if wakes && sleep.asleep {
            sleep.wake();
        }
        let row = rows.get().iter().find(|&&row| row != GONE);
        let body = row.and_then(|&row| simulation.particles.body(row as usize));
        if let Some(own) = body.and_then(|body| simulation.sleep.get_mut(body as usize)) {
            let Sleep { speed, still, asleep } = *sleep;
            *own = sinew::Sleep { allowed: true, speed, still, asleep };
        }
    }
}

/// Keeps what has become of it.
pub(crate) fn keep_sleep(
    world: Res<SinewWorld>,
    mut bodies: Query<(&Rows<BodyParticles>, &mut Sleep)>,
) {
    let simulation = &world.simulation;
    for (rows, mut sleep) in &mut bodies {
        let row = rows.get().iter().find(|&&row| row != GONE);
        let body = row.and_then(|&row| simulation.particles.body(row as usize));
        let Some(own) = body.and_then(|body| simulation.sleep.get(body as usize)) else { continue };
        let kept = Sleep { speed: sleep.speed, still: own.still, asleep: own.asleep };
        sleep.set_if_neq(kept);
    }
}
