//! Gathers bodies: writes solver settings, gravity scale and contact settings of each body to the rows of its particles.

use std::collections::BTreeSet;

use bevy::ecs::change_detection::ContiguousRef;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::{BodySettings, Material};

use super::pins::check_once;
use crate::changes::{ChangeTicks, count_and_changed};
use crate::components::{
    BodyContacts, BodyParticles, CollisionLayers, ContactEvents, ContactShape, ContactsDisabled,
    CreationOrder, GravityScale, Particle, ParticleOf, ParticleRow, Radius, Representation,
    ResolvedShape, RestPlace, Sleep, SurfaceMaterial, WatchedContacts, fill_sorted,
};
use crate::config::BodySolver;
use crate::messages::{Refusal, Refused};
use crate::rows::{GONE, ResolvedRows};
use crate::world::{GatheredProperties, SinewWorld};

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

/// The contact components of a body.
type ContactsData = (
    Option<&'static BodyContacts>,
    Option<&'static ResolvedShape>,
    Option<&'static SurfaceMaterial>,
    Option<&'static CollisionLayers>,
    Has<ContactEvents>,
    Has<ContactsDisabled>,
);

/// The contact components in one table.
type ContactsTable<'w> = (
    Option<ContiguousRef<'w, BodyContacts>>,
    Option<ContiguousRef<'w, SurfaceMaterial>>,
    Option<ContiguousRef<'w, CollisionLayers>>,
);

/// The contact components, with their change ticks.
type ContactsRefs = (
    Option<Ref<'static, BodyContacts>>,
    Option<Ref<'static, SurfaceMaterial>>,
    Option<Ref<'static, CollisionLayers>>,
);

/// The components of bodies in one table.
type BodyTable<'w> = (
    ContiguousRef<'w, BodyParticles>,
    Option<ContiguousRef<'w, BodySolver>>,
    Option<ContiguousRef<'w, GravityScale>>,
    ContactsTable<'w>,
    Option<ContiguousRef<'w, Representation>>,
);

/// Detects changes of the components of bodies.
#[derive(SystemParam)]
pub(crate) struct Bodies<'w, 's> {
    all: Query<
        'w,
        's,
        (
            Ref<'static, BodyParticles>,
            Option<Ref<'static, BodySolver>>,
            Option<Ref<'static, GravityScale>>,
            ContactsRefs,
            Option<Ref<'static, Representation>>,
        ),
    >,
    loose: Query<'w, 's, ContactsRefs, Loose>,
    places: Query<'w, 's, Ref<'static, RestPlace>>,
    /// Components whose additions are found by change detection, and whose removals by comparing the count.
    events: Query<'w, 's, Ref<'static, ContactEvents>>,
    sleepers: Query<'w, 's, (), With<Sleep>>,
    disabled: Query<'w, 's, Ref<'static, ContactsDisabled>>,
    watched: Res<'w, WatchedContacts>,
    counts: Local<'s, [usize; 14]>,
}

impl Bodies<'_, '_> {
    /// Whether any was added, removed or changed since the calling system last ran.
    pub(crate) fn changed(&mut self) -> bool {
        let mut changed = self.watched.is_changed();
        let (mut now, mut with_itself) = ([0; 14], false);
        // Table by table, as there may be very many. All of these components have table storage.
        for table in self.all.contiguous_iter().into_iter().flatten() {
            let change_ticks = body_change_ticks(&table);
            now[..7].iter_mut().zip(change_ticks).for_each(|(sum, change_ticks)| {
                *sum += change_ticks.map_or(0, |change_ticks| change_ticks.len());
            });
            changed |= change_ticks.iter().flatten().any(ChangeTicks::any_changed);
            let (_, _, _, (contacts, ..), _) = &table;
            with_itself |=
                contacts.iter().any(|all| all.iter().any(|contacts| contacts.with_itself));
        }
        for table in self.loose.contiguous_iter().into_iter().flatten() {
            let change_ticks = change_ticks(&table);
            now[7..10].iter_mut().zip(change_ticks).for_each(|(sum, change_ticks)| {
                *sum += change_ticks.map_or(0, |change_ticks| change_ticks.len());
            });
            changed |= change_ticks.iter().flatten().any(ChangeTicks::any_changed);
        }
        if with_itself {
            let (count, moved) = count_and_changed(&self.places);
            now[10] = count;
            changed |= moved;
        }
        let (count, any_changed) = count_and_changed(&self.events);
        now[11] = count;
        changed |= any_changed;
        now[12] = self.sleepers.iter().len();
        let (count, any_changed) = count_and_changed(&self.disabled);
        now[13] = count;
        changed |= any_changed;
        let count_changed = core::mem::replace(&mut *self.counts, now) != now;
        count_changed || changed
    }
}

fn change_ticks<'w>(
    (contacts, material, layers): &ContactsTable<'w>,
) -> [Option<ChangeTicks<'w>>; 3] {
    [
        contacts.as_ref().map(ChangeTicks::of),
        material.as_ref().map(ChangeTicks::of),
        layers.as_ref().map(ChangeTicks::of),
    ]
}

fn body_change_ticks<'w>(
    (members, solver, scale, contacts, representation): &BodyTable<'w>,
) -> [Option<ChangeTicks<'w>>; 7] {
    let [contacts, material, layers] = change_ticks(contacts);
    [
        Some(ChangeTicks::of(members)),
        solver.as_ref().map(ChangeTicks::of),
        scale.as_ref().map(ChangeTicks::of),
        contacts,
        material,
        layers,
        representation.as_ref().map(ChangeTicks::of),
    ]
}

/// Which bodies have errors, so that each is reported once; the settings of bodies; and scratch memory.
#[derive(Default)]
pub(crate) struct BodyScratch {
    scales: BTreeSet<Entity>,
    materials: BTreeSet<Entity>,
    /// The number of particles with a rest position.
    places: usize,
    ordered: Vec<(Option<CreationOrder>, Entity)>,
    settings: Vec<BodySettings>,
    contacts: Vec<sinew::BodyContacts>,
    /// For each row.
    of_rows: Vec<OfBody>,
}

/// The properties that a particle has from its body.
#[derive(Clone, Copy)]
struct OfBody {
    body: Option<u32>,
    gravity_scale: f32,
    has_rest: bool,
}

/// Lists the settings of bodies, and writes to the rows of their particles what differs, if a body has changed or rows were filled again from the particles'
/// own components.
///
/// A gravity scale that is not finite counts as 1, a material with an invalid number as the default; both are reported once.
pub(crate) fn gather_bodies(
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut bodies: Query<(
        Ref<BodyParticles>,
        &mut ResolvedRows<BodyParticles>,
        Option<&BodySolver>,
        Option<&GravityScale>,
        Option<&Representation>,
        ContactsData,
    )>,
    entities: Query<(Entity, Option<&CreationOrder>), Or<(With<BodyParticles>, Loose)>>,
    loose: Query<(&ParticleRow, ContactsData), Loose>,
    places: Query<Ref<RestPlace>>,
    watched: Res<WatchedContacts>,
    mut scratch: Local<BodyScratch>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if !(tables.properties_gathered || tables.bodies_changed) {
        tables.edits = simulation.particles.edits();
        return;
    }
    let BodyScratch { scales, materials, places: count, ordered, settings, contacts, of_rows } =
        &mut *scratch;
    scales.retain(|&entity| entities.contains(entity));
    materials.retain(|&entity| entities.contains(entity));
    settings.clear();
    contacts.clear();
    tables.bodies.clear();
    of_rows.clear();
    of_rows.resize(
        simulation.particles.len(),
        OfBody { body: None, gravity_scale: 1.0, has_rest: false },
    );
    let places_changed = {
        let (now, moved) = count_and_changed(&places);
        core::mem::replace(count, now) != now || moved
    };
    // The solver does not depend on the order of bodies, but the contact report is sorted by it.
    fill_sorted(ordered, entities.iter().map(|(entity, order)| (order.copied(), entity)));
    for &(_, entity) in &*ordered {
        let is_watched = watched.all || watched.body == Some(entity);
        let body = Some(tables.bodies.len() as u32);
        let (own, own_contacts) =
            if let Ok((members, mut rows, solver, scale, representation, own_contacts)) =
                bodies.get_mut(entity)
            {
                let rows = rows.resolve(&tables.layout, members.is_changed(), members.iter());
                let own_contacts = contacts_of(materials, &mut messages, entity, own_contacts);
                let scale = scale.map_or(1.0, |scale| scale.0);
                let reason = (!scale.is_finite()).then_some(Refusal::GravityScale);
                let valid = check_once(scales, &mut messages, entity, reason);
                let of_particle = OfBody {
                    body,
                    gravity_scale: if valid { scale } else { 1.0 },
                    has_rest: own_contacts.with_itself,
                };
                for &row in rows.iter().filter(|&&row| row != GONE) {
                    of_rows[row as usize] = of_particle;
                }
                if own_contacts.with_itself {
                    let there = rows.iter().zip(members.iter()).filter(|(row, _)| **row != GONE);
                    for (&row, member) in there {
                        let known = simulation.particles.rest(row as usize);
                        if places_changed || known.is_none() {
                            let place = places.get(member).ok().map(|place| place.0);
                            if place != known {
                                simulation.particles.set_rest(row as usize, place);
                            }
                        }
                    }
                }
                let own = solver.map_or(default(), |&solver| BodySettings::from(solver));
                let representation = representation.copied().unwrap_or_default().within_a_step();
                (BodySettings { representation, ..own }, own_contacts)
            } else if let Ok((row, own_contacts)) = loose.get(entity)
                && let Some(row) = row.get().filter(|&row| row < of_rows.len())
            {
                of_rows[row] = OfBody { body, gravity_scale: 1.0, has_rest: false };
                (default(), contacts_of(materials, &mut messages, entity, own_contacts))
            } else {
                continue;
            };
        let events = own_contacts.events || is_watched;
        settings.push(own);
        contacts.push(sinew::BodyContacts { events, ..own_contacts });
        tables.bodies.push(entity);
    }
    write(simulation, &tables.properties, of_rows);
    // Written only if different, since writing marks it as changed.
    if *simulation.bodies != *settings {
        (*simulation.bodies).clone_from(settings);
    }
    if *simulation.contacts != *contacts {
        (*simulation.contacts).clone_from(contacts);
    }
    tables.edits = simulation.particles.edits();
}

/// Writes to rows what particles have from their bodies, where it differs. If the product of the gravity scales of body and particle is not finite, the
/// particle's applies.
fn write(simulation: &mut sinew::Simulation, gathered: &GatheredProperties, of_rows: &[OfBody]) {
    let particles = &mut simulation.particles;
    for (row, (of_body, &own)) in of_rows.iter().zip(&gathered.gravity_scale).enumerate() {
        if particles.body(row) != of_body.body {
            particles.set_body(row, of_body.body);
        }
        let scale = own * of_body.gravity_scale;
        particles.set_gravity_scale(row, if scale.is_finite() { scale } else { own });
        if !of_body.has_rest && particles.rest(row).is_some() {
            particles.set_rest(row, None);
        }
    }
}

/// The contact settings of a body.
fn contacts_of(
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
    let valid = check_once(broken, messages, entity, reason);
    let contacts = contacts.copied().unwrap_or_default();
    let shape = match (contacts.shape, resolved) {
        (ContactShape::Auto, Some(resolved)) => resolved.shape,
        (shape, _) => shape,
    };
    sinew::BodyContacts {
        material: if valid { its_material } else { Material::default() },
        layers: layers.copied().unwrap_or_default().layers(),
        with_bodies: contacts.with_bodies,
        with_itself: contacts.with_itself,
        surface: shape == ContactShape::Triangles,
        events,
        disabled,
    }
}
