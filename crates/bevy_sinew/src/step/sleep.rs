//! Copies the sleep state of bodies to the solver before a tick, and back after it.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::changes::count_and_changed;
use crate::components::{
    AirDrag, AirFlow, Attractor, BodyParticles, ContactEvents, Electric, ElectricField, Gravity,
    Region, RegionShape, Sleep, SleepingDisabled, Touching,
};
use crate::components::{Fluid, Wind};
use crate::frames::Frames;
use crate::rows::{GONE, ResolvedRows};
use crate::state::{FNV_START, fnv};
use crate::step::environment::plane;
use crate::world::SinewWorld;

/// The environment: a change wakes all bodies.
#[derive(SystemParam)]
pub(crate) struct Environment<'w, 's> {
    gravity: Res<'w, Gravity>,
    air_drag: Res<'w, AirDrag>,
    electric: Res<'w, Electric>,
    winds: Query<'w, 's, (Entity, &'static Wind, Option<&'static Region>)>,
    air: Query<'w, 's, (Entity, &'static AirFlow, Option<&'static Region>)>,
    fluids: Query<'w, 's, (Entity, &'static Fluid, Option<&'static Region>)>,
    fields: Query<'w, 's, (Entity, &'static ElectricField, Option<&'static Region>)>,
    attractors: Query<'w, 's, (Entity, &'static Attractor)>,
    frames: Frames<'w, 's>,
}

impl Environment<'_, '_> {
    /// A hash of the values of the environment: restoring the same values restores the hash. Computed every tick, since a parent may have moved a field; there
    /// are only a few.
    fn hash(&self) -> u64 {
        let (drag, electric) = (self.air_drag.0, *self.electric);
        let everywhere = [drag, electric.constant, electric.softening];
        let everywhere = everywhere
            .into_iter()
            .chain(self.gravity.0.to_array())
            .chain(electric.field.to_array());
        let mut sum = mixed(1, everywhere);
        let mut add = |kind, entity, region: Option<&Region>, numbers: &[f32]| {
            let place = region.map(|region| self.place_of(entity, region));
            let numbers = numbers.iter().copied().chain(place.into_iter().flatten());
            sum = sum.wrapping_add(mixed(kind, numbers));
        };
        for (entity, &Wind { pressure: p, gusts, gust_length, gust_period }, region) in &self.winds
        {
            add(4, entity, region, &[p.x, p.y, p.z, gusts, gust_length, gust_period]);
        }
        for (entity, &Fluid { density, drag, current: c, .. }, region) in &self.fluids {
            let (up, level) = plane(&self.frames.of(entity).unwrap_or_default(), Vec3::Y);
            add(5, entity, region, &[density, drag, c.x, c.y, c.z, up.x, up.y, up.z, level]);
        }
        for (entity, air, region) in &self.air {
            let AirFlow {
                velocity: v,
                density,
                drag,
                lift,
                gusts,
                gust_length,
                gust_period,
                on_particles,
            } = *air;
            let turbulence = [gusts, gust_length, gust_period, f32::from(u8::from(on_particles))];
            add(6, entity, region, &[v.x, v.y, v.z, density, drag, lift]);
            add(9, entity, None, &turbulence);
        }
        for (entity, ElectricField { field: f }, region) in &self.fields {
            add(7, entity, region, &[f.x, f.y, f.z]);
        }
        for (entity, Attractor { strength, softening }) in &self.attractors {
            let at = self.frames.of(entity).unwrap_or_default().translation;
            add(8, entity, None, &[*strength, *softening, at.x, at.y, at.z]);
        }
        sum.max(1)
    }

    /// The placement of a region, and its size. A field without a region is the same everywhere, wherever its entity is.
    fn place_of(&self, entity: Entity, region: &Region) -> impl Iterator<Item = f32> + use<> {
        let at = self.frames.of(entity).unwrap_or_default();
        let size = match region.shape {
            RegionShape::Box { size } => [1.0, size.x, size.y, size.z],
            RegionShape::Sphere { radius } => [2.0, radius, 0.0, 0.0],
            RegionShape::Cylinder { radius, height } => [3.0, radius, height, 0.0],
            RegionShape::Capsule { radius, length } => [4.0, radius, length, 0.0],
        };
        let numbers = at.translation.to_array().into_iter().chain(at.rotation.to_array());
        numbers.chain(at.scale.to_array()).chain(size).chain([region.fade])
    }
}

/// FNV-1a hash of some numbers.
fn mixed(kind: u64, numbers: impl IntoIterator<Item = f32>) -> u64 {
    let begin = fnv(FNV_START, kind);
    numbers.into_iter().fold(begin, |hash, number| fnv(hash, number.to_bits().into()))
}

/// Run condition: whether [`gather_sleep`] may differ from what the solver has. It does not while particles are not gathered, no [`Sleep`] has changed (a step
/// that changes one writes it back), the environment is the same, and no entity has [`ContactEvents::Every`].
pub(crate) fn any_sleep_changed(
    world: Res<SinewWorld>,
    environment: Environment,
    with_events: Query<&ContactEvents>,
    sleepers: Query<Ref<Sleep>>,
    disabled: Query<Ref<SleepingDisabled>>,
    mut before: Local<(bool, u64, usize, usize)>,
) -> bool {
    let ((sleepers, changed), (disabled, disabled_changed)) =
        (count_and_changed(&sleepers), count_and_changed(&disabled));
    let now = (world.tables.deferred, environment.hash(), sleepers, disabled);
    let same = core::mem::replace(&mut *before, now) == now;
    let any_every = with_events.iter().any(|events| *events == ContactEvents::Every);
    !(now.0 && same) || changed || disabled_changed || any_every
}

/// Bodies whose contacts are all reported, and the gathered state by body index; scratch memory.
#[derive(Default)]
pub(crate) struct SleepScratch {
    watched: Vec<Entity>,
    gathered: Vec<sinew::Sleep>,
}

/// Passes to the solver which bodies may sleep, and which do.
pub(crate) fn gather_sleep(
    mut world: ResMut<SinewWorld>,
    environment: Environment,
    with_events: Query<(Entity, &ContactEvents, &Touching)>,
    mut bodies: Query<(Entity, &ResolvedRows<BodyParticles>, &mut Sleep, Has<SleepingDisabled>)>,
    mut scratch: Local<SleepScratch>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let (SleepScratch { watched, gathered }, count) = (&mut *scratch, simulation.bodies.len());
    tables.asleep.clear();
    tables.unmoved.clear();
    gathered.clear();
    gathered.resize(if bodies.is_empty() { 0 } else { count }, sinew::Sleep::default());
    let now = environment.hash();
    // Contacts at rest are reported, too, so bodies in contact with an entity with [`ContactEvents::Every`] are kept awake.
    watched.clear();
    for (entity, _, touching) in with_events.iter().filter(|one| *one.1 == ContactEvents::Every) {
        watched.push(entity);
        watched.extend(&touching.0);
    }
    watched.sort_unstable();
    for (entity, rows, mut sleep, disabled) in &mut bodies {
        let keeps_awake = disabled || watched.binary_search(&entity).is_ok();
        if sleep.environment_hash != now {
            if sleep.environment_hash != 0 && sleep.asleep {
                sleep.wake();
            }
            sleep.environment_hash = now;
        }
        let row = rows.current(&tables.layout).iter().find(|&&row| row != GONE);
        let body = row.and_then(|&row| simulation.particles.body(row as usize));
        if let Some(own) = body.and_then(|body| gathered.get_mut(body as usize)) {
            let Sleep { speed, still, asleep, support_hash, .. } = *sleep;
            *own = sinew::Sleep { allowed: true, keeps_awake, speed, still, asleep, support_hash };
        }
    }
    // Written only if different, so that a step at rest is recognised at once.
    if *simulation.sleep != *gathered {
        (*simulation.sleep).clone_from(gathered);
    }
    tables.asleep.extend(simulation.sleep.iter().map(|body| body.asleep));
    if !tables.dirty.all {
        tables.unmoved.clone_from(&tables.asleep);
    }
    let mut written = false;
    for &row in &tables.dirty.rows {
        let known = (row as usize) < simulation.particles.len();
        let body = known.then(|| simulation.particles.body(row as usize)).flatten();
        let Some(body) = body.map(|body| body as usize) else { continue };
        written |= tables.asleep.get(body) == Some(&true);
        if let Some(own) = tables.unmoved.get_mut(body) {
            *own = false;
        }
    }
    if written {
        simulation.check_sleepers();
    }
}

/// After the step, notes which bodies slept through all of it. They need not be written: they are as they were gathered.
pub(crate) fn note_sleepers(mut world: ResMut<SinewWorld>) {
    if world.tables.rested {
        return;
    }
    let SinewWorld { simulation, tables } = &mut *world;
    let after = simulation.sleep.iter();
    for (was, now) in tables.asleep.iter_mut().zip(after.clone()) {
        *was &= now.asleep;
    }
    for (unmoved, now) in tables.unmoved.iter_mut().zip(after) {
        *unmoved &= now.asleep;
    }
}

/// Copies the sleep state back.
pub(crate) fn keep_sleep(
    world: Res<SinewWorld>,
    mut bodies: Query<(&ResolvedRows<BodyParticles>, &mut Sleep)>,
) {
    let SinewWorld { simulation, tables } = &*world;
    if tables.rested {
        return;
    }
    for (rows, mut sleep) in &mut bodies {
        let row = rows.current(&tables.layout).iter().find(|&&row| row != GONE);
        let body = row.and_then(|&row| simulation.particles.body(row as usize));
        let Some(own) = body.and_then(|body| simulation.sleep.get(body as usize)) else { continue };
        let kept = Sleep {
            still: own.still,
            asleep: own.asleep,
            support_hash: own.support_hash,
            ..*sleep
        };
        sleep.set_if_neq(kept);
    }
}
