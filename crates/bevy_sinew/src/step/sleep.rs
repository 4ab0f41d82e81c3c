//! Sleep: what bodies keep of it goes to the solver before a tick and comes back after it.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::components::{BodyParticles, Collider, Gravity, Sleep};
use crate::rows::{GONE, Rows};
use crate::world::SinewWorld;
use crate::{CollisionLayers, ContactsDisabled, Fluid, Sensor, SurfaceMaterial, Wind};

/// What surrounds bodies: where something of it changes, all wake.
#[derive(SystemParam)]
pub(crate) struct Surroundings<'w, 's> {
    gravity: Res<'w, Gravity>,
    colliders: Query<'w, 's, Standing, (Without<Sensor>, Without<ContactsDisabled>)>,
    winds: Query<'w, 's, &'static Wind>,
    fluids: Query<'w, 's, &'static Fluid>,
    changed: Query<'w, 's, (), Touched>,
    known: Local<'s, Known>,
}

/// What of a collider matters to what lies on it.
type Standing =
    (&'static Collider, Option<&'static SurfaceMaterial>, Option<&'static CollisionLayers>);

type Touched = Or<(
    Changed<Collider>,
    Changed<SurfaceMaterial>,
    Changed<CollisionLayers>,
    Changed<Wind>,
    Changed<Fluid>,
)>;

/// The number of surroundings that nobody has touched since, and how many there were. It saves work and changes nothing: bodies keep the number that
/// they know.
#[derive(Default)]
pub(crate) struct Known {
    number: u64,
    counts: [usize; 3],
}

impl Surroundings<'_, '_> {
    /// One number for all that surrounds bodies, of its values alone: put back as it was, it is the same.
    fn number(&mut self) -> u64 {
        let counts =
            [self.colliders.iter().len(), self.winds.iter().len(), self.fluids.iter().len()];
        let known = self.known.number != 0 && self.known.counts == counts;
        if !known || self.gravity.is_changed() || !self.changed.is_empty() {
            *self.known = Known { number: self.summed_up().max(1), counts };
        }
        self.known.number
    }

    /// A sum, because queries have no order.
    fn summed_up(&self) -> u64 {
        let mut sum = mixed(1, self.gravity.0.to_array());
        let mut add = |number: u64| sum = sum.wrapping_add(number);
        for (collider, material, layers) in &self.colliders {
            let bounds = match *collider {
                // Its bounds have no end.
                Collider::InsideBox { size } => (-size, Vec3::INFINITY),
                ref collider => collider.shape().map(|shape| shape.bounds()).unwrap_or_default(),
            };
            let SurfaceMaterial { friction, restitution, drag, .. } =
                material.copied().unwrap_or_default();
            let CollisionLayers { memberships, filters } = layers.copied().unwrap_or_default();
            let made_of = [friction, restitution, drag.along, drag.across];
            let layers = [memberships, filters].map(f32::from_bits);
            let bounds = [bounds.0, bounds.1].into_iter().flat_map(|v| v.to_array());
            add(mixed(2, bounds.chain(made_of).chain(layers)));
        }
        for Wind { pressure: p, gusts, gust_length, gust_period } in &self.winds {
            add(mixed(4, [p.x, p.y, p.z, *gusts, *gust_length, *gust_period]));
        }
        for Fluid { density, drag, current: c, .. } in &self.fluids {
            add(mixed(5, [*density, *drag, c.x, c.y, c.z]));
        }
        sum
    }
}

/// Fowler, Noll and Vo's hash of some numbers.
fn mixed(kind: u64, numbers: impl IntoIterator<Item = f32>) -> u64 {
    let mix = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x0100_0000_01b3);
    let begin = mix(0xcbf2_9ce4_8422_2325, kind);
    numbers.into_iter().fold(begin, |hash, number| mix(hash, u64::from(number.to_bits())))
}

/// Tells the solver who may sleep and who does.
pub(crate) fn gather_sleep(
    mut world: ResMut<SinewWorld>,
    mut surroundings: Surroundings,
    mut bodies: Query<(&Rows<BodyParticles>, &mut Sleep)>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    simulation.sleep.clear();
    tables.asleep.clear();
    tables.unmoved.clear();
    if bodies.is_empty() {
        return;
    }
    simulation.sleep.resize(simulation.bodies.len(), sinew::Sleep::default());
    let now = surroundings.number();
    for (rows, mut sleep) in &mut bodies {
        if sleep.around != now {
            if sleep.around != 0 && sleep.asleep {
                sleep.wake();
            }
            sleep.around = now;
        }
        let row = rows.get().iter().find(|&&row| row != GONE);
        let body = row.and_then(|&row| simulation.particles.body(row as usize));
        if let Some(own) = body.and_then(|body| simulation.sleep.get_mut(body as usize)) {
            let Sleep { speed, still, asleep, .. } = *sleep;
            *own = sinew::Sleep { allowed: true, speed, still, asleep };
        }
    }
    tables.asleep.extend(simulation.sleep.iter().map(|body| body.asleep));
    if !tables.touched.all {
        tables.unmoved.clone_from(&tables.asleep);
        for &row in &tables.touched.rows {
            let known = (row as usize) < simulation.particles.len();
            let body = known.then(|| simulation.particles.body(row as usize)).flatten();
            if let Some(own) = body.and_then(|body| tables.unmoved.get_mut(body as usize)) {
                *own = false;
            }
        }
    }
}

/// Notes, after the step, who slept through all of it. Those need not be written: they are as they were gathered.
pub(crate) fn note_sleepers(mut world: ResMut<SinewWorld>) {
    let SinewWorld { simulation, tables } = &mut *world;
    let after = simulation.sleep.iter();
    for (was, now) in tables.asleep.iter_mut().zip(after.clone()) {
        *was &= now.asleep;
    }
    for (unmoved, now) in tables.unmoved.iter_mut().zip(after) {
        *unmoved &= now.asleep;
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
        let kept = Sleep { still: own.still, asleep: own.asleep, ..*sleep };
        sleep.set_if_neq(kept);
    }
}
