//! Gathers the environment: resources and entities become the solver's forces, and the plane of a 2D world, every tick. There are only a few of each kind, so
//! nothing is kept from tick to tick but the reported errors.

use std::collections::BTreeSet;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::Plane;

use crate::components::{
    AirDrag, AirFlow, Attractor, CreationOrder, Electric, ElectricField, Flatland, Fluid, Gravity,
    Region, Wind,
};
use crate::config::SolverConfig;
use crate::frames::{Frames, Misplaced};
use crate::messages::{Refusal, Refused, refuse};
use crate::schedule::SinewClock;
use crate::world::SinewWorld;

/// Copies the settings and the environment; fields with an invalid number are left out, and reported once.
pub(crate) fn gather_environment(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    config: Res<SolverConfig>,
    clock: Res<SinewClock>,
    everywhere: Everywhere,
    fields: Fields,
    flatlands: Flatlands,
    frames: Frames,
    mut known: Local<BTreeSet<Broken>>,
    mut scratch: Local<EnvironmentScratch>,
) {
    let simulation = &mut world.simulation;
    simulation.settings = (*config).into();
    simulation.time = clock.seconds;
    let before = core::mem::take(&mut *known);
    let EnvironmentScratch { places, planes } = &mut *scratch;
    let mut validator =
        FieldValidator { before, now: BTreeSet::new(), kind: 0, messages: &mut messages, places };
    everywhere.add_to(&mut simulation.forces, &mut validator);
    fields.add_to(&mut simulation.forces, &frames, &mut validator);
    simulation.boundaries.plane_constraint =
        plane_constraint(&flatlands, planes, &frames, &mut validator);
    *known = validator.now;
}

/// The resources of the environment.
#[derive(SystemParam)]
pub(crate) struct Everywhere<'w, 's> {
    gravity: Res<'w, Gravity>,
    drag: Res<'w, AirDrag>,
    electric: Res<'w, Electric>,
    /// The entities of the resources, which a message can name.
    gravity_at: Query<'w, 's, Entity, With<Gravity>>,
    drag_at: Query<'w, 's, Entity, With<AirDrag>>,
    electric_at: Query<'w, 's, Entity, With<Electric>>,
}

impl Everywhere<'_, '_> {
    fn add_to(&self, forces: &mut sinew::Forces, validator: &mut FieldValidator) {
        let Gravity(gravity) = *self.gravity;
        let valid = validator.resource("Gravity", &self.gravity_at, gravity.is_finite());
        forces.gravity = if valid { gravity } else { Vec3::ZERO };

        let AirDrag(drag) = *self.drag;
        let valid = validator.resource("AirDrag", &self.drag_at, (0.0..=1.0).contains(&drag));
        forces.drag = if valid { drag } else { 0.0 };

        // The solver ignores invalid electric settings by itself.
        forces.electric = (*self.electric).into();
        validator.resource("Electric", &self.electric_at, forces.electric.is_valid());
    }
}

type Field<T> = (Entity, &'static CreationOrder, &'static T, Option<&'static Region>);

/// The entities of the environment.
#[derive(SystemParam)]
pub(crate) struct Fields<'w, 's> {
    winds: Query<'w, 's, Field<Wind>>,
    air: Query<'w, 's, Field<AirFlow>>,
    fluids: Query<'w, 's, Field<Fluid>>,
    electric: Query<'w, 's, Field<ElectricField>>,
    attractors: Query<'w, 's, (Entity, &'static CreationOrder, &'static Attractor)>,
}

impl Fields<'_, '_> {
    fn add_to(&self, forces: &mut sinew::Forces, frames: &Frames, validator: &mut FieldValidator) {
        let within = |entity, region: Option<&Region>| {
            let Some(region) = region else { return Ok(sinew::Region::EVERYWHERE) };
            region.at(&frames.of(entity)?)
        };

        let wind = |(entity, order, wind, region): (_, &_, &Wind, _)| {
            (
                *order,
                entity,
                within(entity, region).map(|region| sinew::Wind { region, ..(*wind).into() }),
            )
        };
        validator.fill(&mut forces.winds, self.winds.iter().map(wind), sinew::Wind::is_valid);

        let air = |(entity, order, air, region): (_, &_, &AirFlow, _)| {
            (
                *order,
                entity,
                within(entity, region).map(|region| sinew::AirFlow { region, ..(*air).into() }),
            )
        };
        validator.fill(&mut forces.air_flows, self.air.iter().map(air), sinew::AirFlow::is_valid);

        let fluid = |(entity, order, fluid, region): (_, &_, &Fluid, _)| {
            let under = |region| {
                let (up, level) = plane(&frames.of(entity)?, Vec3::Y);
                Ok(sinew::Fluid { up, level, region, ..(*fluid).into() })
            };
            (*order, entity, within(entity, region).and_then(under))
        };
        validator.fill(&mut forces.fluids, self.fluids.iter().map(fluid), sinew::Fluid::is_valid);

        let field = |(entity, order, field, region): (_, &_, &ElectricField, _)| {
            let within = within(entity, region);
            let field = |region| sinew::ElectricField { field: field.field, region };
            (*order, entity, within.map(field))
        };
        let fields = self.electric.iter().map(field);
        validator.fill(&mut forces.electric_fields, fields, sinew::ElectricField::is_valid);

        let attractor = |(entity, order, attractor): (_, &_, &Attractor)| {
            let at = frames.of(entity).map(|frame| attractor.at(frame.translation));
            (*order, entity, at)
        };
        let attractors = self.attractors.iter().map(attractor);
        validator.fill(&mut forces.attractors, attractors, sinew::Attractor::is_valid);
    }
}

/// The planes of 2D worlds.
type Flatlands<'w, 's> = Query<'w, 's, (Entity, &'static CreationOrder), With<Flatland>>;

/// The plane of a 2D world: of several, the first valid one.
fn plane_constraint(
    flatlands: &Flatlands,
    list: &mut Vec<Plane>,
    frames: &Frames,
    validator: &mut FieldValidator,
) -> Option<Plane> {
    let entry = |(entity, order): (_, &_)| {
        let plane = frames.of(entity).map(|frame| {
            let (normal, offset) = plane(&frame, Vec3::Z);
            Plane { normal, offset, friction: 0.0, ..Plane::ground(0.0) }
        });
        (*order, entity, plane)
    };
    validator.fill(list, flatlands.iter().map(entry), Plane::is_valid);
    list.first().copied()
}

/// The plane through an entity's origin that is perpendicular to one of its axes: its normal, and its distance from the world's origin along that.
pub(super) fn plane(frame: &Transform, axis: Vec3) -> (Vec3, f32) {
    // Not `Transform::up`, which asserts that the rotation is normalised: an invalid one must be refused, not panic.
    let normal = (frame.rotation * axis).normalize_or_zero();
    (normal, normal.dot(frame.translation))
}

/// Scratch memory, kept from tick to tick.
#[derive(Default)]
pub(crate) struct EnvironmentScratch {
    places: Vec<(CreationOrder, Entity, usize)>,
    planes: Vec<Plane>,
}

/// An entity and the index of what is invalid on it, which may be several things.
type Broken = (Entity, u32);

/// Passes valid entries in the order of creation, whatever the order of the query, and reports the others, each once until it is corrected.
struct FieldValidator<'a, 'w> {
    before: BTreeSet<Broken>,
    now: BTreeSet<Broken>,
    /// Index of the list or resource that is being validated.
    kind: u32,
    messages: &'a mut MessageWriter<'w, Refused>,
    /// The entities of the list's entries, and the index of each entry before sorting.
    places: &'a mut Vec<(CreationOrder, Entity, usize)>,
}

impl FieldValidator<'_, '_> {
    fn fill<T>(
        &mut self,
        list: &mut Vec<T>,
        entries: impl Iterator<Item = (CreationOrder, Entity, Result<T, Misplaced>)>,
        valid: impl Fn(&T) -> bool,
    ) {
        self.kind += 1;
        list.clear();
        self.places.clear();
        for (order, entity, entry) in entries {
            match entry {
                Ok(entry) => {
                    self.places.push((order, entity, list.len()));
                    list.push(entry);
                }
                Err(misplaced) => {
                    self.check(entity, false, || misplaced.into());
                }
            }
        }
        self.places.sort_unstable();
        for i in 0..list.len() {
            // The entry for this place has been swapped away once for each earlier place at which it was.
            let mut from = self.places[i].2;
            while from < i {
                from = self.places[from].2;
            }
            list.swap(i, from);
        }
        let mut next = 0;
        list.retain(|entry| {
            let place = self.places[next];
            next += 1;
            self.check(place.1, valid(entry), || Refusal::Field)
        });
    }

    /// Whether a resource is valid; an error names its entity.
    fn resource<T: Resource>(
        &mut self,
        name: &'static str,
        at: &Query<Entity, With<T>>,
        valid: bool,
    ) -> bool {
        self.kind += 1;
        let entity = at.iter().next().unwrap_or(Entity::PLACEHOLDER);
        self.check(entity, valid, || Refusal::Resource(name))
    }

    fn check(&mut self, entity: Entity, valid: bool, reason: impl FnOnce() -> Refusal) -> bool {
        if !valid {
            let broken = (entity, self.kind);
            if !self.before.contains(&broken) {
                refuse(self.messages, entity, reason());
            }
            self.now.insert(broken);
        }
        valid
    }
}
