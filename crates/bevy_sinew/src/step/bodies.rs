//! Bodies at gather: what a body asks of the solver, how gravity pulls on it and how it takes part in contacts, is written to the rows of its
//! particles.

use std::collections::BTreeSet;

use bevy::ecs::change_detection::ContiguousRef;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::{BodySettings, Material};

use super::pins::sound;
use crate::changes::{ChangeTicks, census};
use crate::components::{
    BodyContacts, BodyParticles, CollisionLayers, ContactEvents, ContactShape, ContactsDisabled,
    CreationOrder, GravityScale, Particle, ParticleOf, ParticleRow, Radius, Representation,
    ResolvedShape, RestPlace, Sleep, SurfaceMaterial, WatchedContacts,
};
use crate::config::BodySolver;
use crate::messages::{Refusal, Refused};
use crate::rows::{GONE, Rows};
use crate::world::{SinewWorld, Tables};

/// Loose particles that others may touch: each is a body of its own.
type Loose = (
    With<Particle>,
    Without<ParticleOf>,
    Or<(
        With<Radius>,
        With<BodyContacts>,
        With<SurfaceMaterial>,
        With<CollisionLayers>,
        With<ContactEvents>,
        With<Sleep>,
    )>,
);

/// What is said of contacts.
type Told = (
    Option<&'static BodyContacts>,
    Option<&'static ResolvedShape>,
    Option<&'static SurfaceMaterial>,
    Option<&'static CollisionLayers>,
    Has<ContactEvents>,
    Has<ContactsDisabled>,
);

/// The same in one table.
type ToldTable<'w> = (
    Option<ContiguousRef<'w, BodyContacts>>,
    Option<ContiguousRef<'w, SurfaceMaterial>>,
    Option<ContiguousRef<'w, CollisionLayers>>,
);

/// The same, with when it changed.
type ToldRefs = (
    Option<Ref<'static, BodyContacts>>,
    Option<Ref<'static, SurfaceMaterial>>,
    Option<Ref<'static, CollisionLayers>>,
);

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
            ToldRefs,
            Option<Ref<'static, ResolvedShape>>,
            Option<Ref<'static, Representation>>,
        ),
    >,
    loose: Query<'w, 's, ToldRefs, Loose>,
    places: Query<'w, 's, Ref<'static, RestPlace>>,
    /// How many said something of each kind: what came is a change, and fewer than before is all that is left to notice.
    events: Query<'w, 's, Ref<'static, ContactEvents>>,
    sleepers: Query<'w, 's, (), With<Sleep>>,
    disabled: Query<'w, 's, Ref<'static, ContactsDisabled>>,
    watched: Res<'w, WatchedContacts>,
    counts: Local<'s, [usize; 13]>,
}

impl Bodies<'_, '_> {
    /// Whether there is any.
    pub(crate) fn any(&self) -> bool {
        !self.all.is_empty() || !self.loose.is_empty()
    }

    /// Whether one came, went or changed since the system that asks last ran.
    pub(crate) fn changed(&mut self) -> bool {
        let mut changed = self.watched.is_changed();
        let (mut now, mut with_itself) = ([0; 13], false);
        for (members, solver, scale, told, resolved, representation) in &self.all {
            let (contacts, material, layers) = told;
            now[12] += usize::from(representation.is_some());
            changed |= representation.is_some_and(|one| one.is_changed());
            now[0] += usize::from(solver.is_some());
            now[1] += usize::from(scale.is_some());
            now[2] += usize::from(contacts.is_some());
            now[3] += usize::from(material.is_some());
            now[4] += usize::from(layers.is_some());
            changed |= members.is_changed();
            changed |= solver.is_some_and(|solver| solver.is_changed());
            changed |= scale.is_some_and(|scale| scale.is_changed());
            changed |= material.is_some_and(|material| material.is_changed());
            changed |= layers.is_some_and(|layers| layers.is_changed());
            changed |= resolved.is_some_and(|resolved| resolved.is_changed());
            if let Some(contacts) = contacts {
                changed |= contacts.is_changed();
                with_itself |= contacts.with_itself;
            }
        }
        // There may be very many of these: table by table. All are kept in tables.
        for table in self.loose.contiguous_iter().into_iter().flatten() {
            let change_ticks = change_ticks(&table);
            now[5..8].iter_mut().zip(change_ticks).for_each(|(sum, change_ticks)| {
                *sum += change_ticks.map_or(0, |change_ticks| change_ticks.len());
            });
            changed |= change_ticks.iter().flatten().any(ChangeTicks::any_changed);
        }
        if with_itself {
            let (count, moved) = census(&self.places);
            now[8] = count;
            changed |= moved;
        }
        let (count, came) = census(&self.events);
        now[9] = count;
        changed |= came;
        now[10] = self.sleepers.iter().len();
        let (count, came) = census(&self.disabled);
        now[11] = count;
        changed |= came;
        let went = core::mem::replace(&mut *self.counts, now) != now;
        went || changed
    }
}

fn change_ticks<'w>((contacts, material, layers): &ToldTable<'w>) -> [Option<ChangeTicks<'w>>; 3] {
    [
        contacts.as_ref().map(ChangeTicks::of),
        material.as_ref().map(ChangeTicks::of),
        layers.as_ref().map(ChangeTicks::of),
    ]
}

/// What bodies said that is broken, so that each is reported once; and memory.
#[derive(Default)]
pub(crate) struct Known {
    scales: BTreeSet<Entity>,
    materials: BTreeSet<Entity>,
    ordered: Vec<(Option<CreationOrder>, Entity)>,
}

/// Writes what bodies have to say to the rows of their particles, if the rows were filled afresh with what each particle says of itself.
///
/// A scale of gravity that is not finite is none, a material with a broken number is the default one, and both are reported when that is news.
pub(crate) fn gather_bodies(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut bodies: Query<(
        Ref<BodyParticles>,
        &mut Rows<BodyParticles>,
        Option<&BodySolver>,
        Option<&GravityScale>,
        Option<&Representation>,
        Told,
    )>,
    entities: Query<(Entity, Option<&CreationOrder>), Or<(With<BodyParticles>, Loose)>>,
    loose: Query<(&ParticleRow, Told), Loose>,
    places: Query<&RestPlace>,
    watched: Res<WatchedContacts>,
    mut known: Local<Known>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if !tables.properties_gathered {
        tables.edits = simulation.particles.edits();
        return;
    }
    let Known { scales, materials, ordered } = &mut *known;
    scales.retain(|&entity| entities.contains(entity));
    materials.retain(|&entity| entities.contains(entity));
    simulation.bodies.clear();
    simulation.contacts.clear();
    tables.bodies.clear();
    // Nothing is solved in the order of their numbers, but what is reported of contacts is sorted by them.
    ordered.clear();
    ordered.extend(entities.iter().map(|(entity, order)| (order.copied(), entity)));
    ordered.sort_unstable();
    for &(_, entity) in &*ordered {
        let is_watched = watched.all || watched.body == Some(entity);
        if let Ok((members, mut rows, solver, scale, representation, told)) = bodies.get_mut(entity)
        {
            let rows = rows.resolve(&tables.layout, members.is_changed(), members.iter());
            let mut contacts = contacts(materials, &mut messages, entity, told);
            contacts.events |= is_watched;
            let own = solver.map_or(default(), |&solver| BodySettings::from(solver));
            let representation = representation.copied().unwrap_or_default().within_a_step();
            let own = BodySettings { representation, ..own };
            let number = number(simulation, tables, entity, own, contacts);
            let scale = scale.map_or(1.0, |scale| scale.0);
            let reason = (!scale.is_finite()).then_some(Refusal::GravityScale);
            let sound = sound(scales, &mut messages, entity, reason);
            let scale = if sound { scale } else { 1.0 };
            for &row in rows.iter().filter(|&&row| row != GONE) {
                simulation.particles.set_body(row as usize, Some(number));
                simulation.particles.scale_gravity(row as usize, scale);
            }
            if contacts.with_itself {
                for (&row, member) in rows.iter().zip(members.iter()) {
                    if let (Ok(&RestPlace(place)), true) = (places.get(member), row != GONE) {
                        simulation.particles.set_rest(row as usize, Some(place));
                    }
                }
            }
        } else if let Ok((row, told)) = loose.get(entity)
            && let Some(row) = row.get().filter(|&row| row < simulation.particles.len())
        {
            let mut contacts = contacts(materials, &mut messages, entity, told);
            contacts.events |= is_watched;
            let number = number(simulation, tables, entity, default(), contacts);
            simulation.particles.set_body(row, Some(number));
        }
    }
    tables.edits = simulation.particles.edits();
}

/// Gives a body a place in the solver's lists.
fn number(
    simulation: &mut sinew::Simulation,
    tables: &mut Tables,
    entity: Entity,
    settings: BodySettings,
    contacts: sinew::BodyContacts,
) -> u32 {
    let number = simulation.bodies.len() as u32;
    simulation.bodies.push(settings);
    simulation.contacts.push(contacts);
    tables.bodies.push(entity);
    number
}

/// How a body takes part in contacts.
fn contacts(
    broken: &mut BTreeSet<Entity>,
    messages: &mut MessageWriter<Refused>,
    entity: Entity,
    (contacts, resolved, material, layers, events, disabled): (
        Option<&BodyContacts>,
        Option<&ResolvedShape>,
        Option<&SurfaceMaterial>,
        Option<&CollisionLayers>,
        bool,
        bool,
    ),
) -> sinew::BodyContacts {
    let its_material = material.map_or(Material::default(), |&material| material.into());
    let reason = (!its_material.is_valid()).then_some(Refusal::Material);
    let sound = sound(broken, messages, entity, reason);
    let contacts = contacts.copied().unwrap_or_default();
    let shape = match (contacts.shape, resolved) {
        (ContactShape::Auto, Some(resolved)) => resolved.shape,
        (shape, _) => shape,
    };
    sinew::BodyContacts {
        material: if sound { its_material } else { Material::default() },
        layers: layers.copied().unwrap_or_default().layers(),
        with_bodies: contacts.with_bodies,
        with_itself: contacts.with_itself,
        surface: shape == ContactShape::Triangles,
        events,
        disabled,
    }
}
