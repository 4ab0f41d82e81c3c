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
use crate::world::{HeldProperties, SinewWorld};

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
type ContactsData = (
    Option<&'static BodyContacts>,
    Option<&'static ResolvedShape>,
    Option<&'static SurfaceMaterial>,
    Option<&'static CollisionLayers>,
    Has<ContactEvents>,
    Has<ContactsDisabled>,
);

/// The same in one table.
type ContactsTable<'w> = (
    Option<ContiguousRef<'w, BodyContacts>>,
    Option<ContiguousRef<'w, SurfaceMaterial>>,
    Option<ContiguousRef<'w, CollisionLayers>>,
);

/// The same, with when it changed.
type ContactsRefs = (
    Option<Ref<'static, BodyContacts>>,
    Option<Ref<'static, SurfaceMaterial>>,
    Option<Ref<'static, CollisionLayers>>,
);

/// What bodies say in one table.
type BodyTable<'w> = (
    ContiguousRef<'w, BodyParticles>,
    Option<ContiguousRef<'w, BodySolver>>,
    Option<ContiguousRef<'w, GravityScale>>,
    ContactsTable<'w>,
    Option<ContiguousRef<'w, Representation>>,
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
            ContactsRefs,
            Option<Ref<'static, Representation>>,
        ),
    >,
    loose: Query<'w, 's, ContactsRefs, Loose>,
    places: Query<'w, 's, Ref<'static, RestPlace>>,
    /// How many said something of each kind: what came is a change, and fewer than before is all that is left to notice.
    events: Query<'w, 's, Ref<'static, ContactEvents>>,
    sleepers: Query<'w, 's, (), With<Sleep>>,
    disabled: Query<'w, 's, Ref<'static, ContactsDisabled>>,
    watched: Res<'w, WatchedContacts>,
    counts: Local<'s, [usize; 14]>,
}

impl Bodies<'_, '_> {
    /// Whether one came, went or changed since the system that asks last ran.
    pub(crate) fn changed(&mut self) -> bool {
        let mut changed = self.watched.is_changed();
        let (mut now, mut with_itself) = ([0; 14], false);
        // There may be very many of all of these: table by table. All are kept in tables.
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
            let (count, moved) = census(&self.places);
            now[10] = count;
            changed |= moved;
        }
        let (count, came) = census(&self.events);
        now[11] = count;
        changed |= came;
        now[12] = self.sleepers.iter().len();
        let (count, came) = census(&self.disabled);
        now[13] = count;
        changed |= came;
        let went = core::mem::replace(&mut *self.counts, now) != now;
        went || changed
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
    (members, solver, scale, told, representation): &BodyTable<'w>,
) -> [Option<ChangeTicks<'w>>; 7] {
    let [contacts, material, layers] = change_ticks(told);
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

/// What bodies said that is broken, so that each is reported once; what they say; and memory.
#[derive(Default)]
pub(crate) struct Known {
    scales: BTreeSet<Entity>,
    materials: BTreeSet<Entity>,
    /// How many particles have a place in a rest shape.
    places: usize,
    ordered: Vec<(Option<CreationOrder>, Entity)>,
    settings: Vec<BodySettings>,
    contacts: Vec<sinew::BodyContacts>,
    /// Of each row.
    of_rows: Vec<OfBody>,
}

/// What a particle has of its body.
#[derive(Clone, Copy)]
struct OfBody {
    body: Option<u32>,
    gravity_scale: f32,
    has_rest: bool,
}

/// Lists what bodies have to say, and writes to the rows of their particles what is not there yet, if bodies have anything new to say or rows were filled
/// afresh with what each particle says of itself.
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
        ContactsData,
    )>,
    entities: Query<(Entity, Option<&CreationOrder>), Or<(With<BodyParticles>, Loose)>>,
    loose: Query<(&ParticleRow, ContactsData), Loose>,
    places: Query<Ref<RestPlace>>,
    watched: Res<WatchedContacts>,
    mut known: Local<Known>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if !(tables.properties_gathered || tables.bodies_changed) {
        tables.edits = simulation.particles.edits();
        return;
    }
    let Known { scales, materials, places: count, ordered, settings, contacts, of_rows } =
        &mut *known;
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
        let (now, moved) = census(&places);
        core::mem::replace(count, now) != now || moved
    };
    // Nothing is solved in the order of their numbers, but what is reported of contacts is sorted by them.
    ordered.clear();
    ordered.extend(entities.iter().map(|(entity, order)| (order.copied(), entity)));
    ordered.sort_unstable();
    for &(_, entity) in &*ordered {
        let is_watched = watched.all || watched.body == Some(entity);
        let body = Some(tables.bodies.len() as u32);
        let (own, asked) = if let Ok((members, mut rows, solver, scale, representation, asked)) =
            bodies.get_mut(entity)
        {
            let rows = rows.resolve(&tables.layout, members.is_changed(), members.iter());
            let asked = contacts_of(materials, &mut messages, entity, asked);
            let scale = scale.map_or(1.0, |scale| scale.0);
            let reason = (!scale.is_finite()).then_some(Refusal::GravityScale);
            let sound = sound(scales, &mut messages, entity, reason);
            let of_particle = OfBody {
                body,
                gravity_scale: if sound { scale } else { 1.0 },
                has_rest: asked.with_itself,
            };
            for &row in rows.iter().filter(|&&row| row != GONE) {
                of_rows[row as usize] = of_particle;
            }
            if asked.with_itself {
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
            (BodySettings { representation, ..own }, asked)
        } else if let Ok((row, asked)) = loose.get(entity)
            && let Some(row) = row.get().filter(|&row| row < of_rows.len())
        {
            of_rows[row] = OfBody { body, gravity_scale: 1.0, has_rest: false };
            (default(), contacts_of(materials, &mut messages, entity, asked))
        } else {
            continue;
        };
        let events = asked.events || is_watched;
        settings.push(own);
        contacts.push(sinew::BodyContacts { events, ..asked });
        tables.bodies.push(entity);
    }
    write(simulation, &tables.held, of_rows);
    // What is written to is new.
    if *simulation.bodies != *settings {
        (*simulation.bodies).clone_from(settings);
    }
    if *simulation.contacts != *contacts {
        (*simulation.contacts).clone_from(contacts);
    }
    tables.edits = simulation.particles.edits();
}

/// Writes to rows what particles have of their bodies, where it is not what stands there. A scale of gravity that is not finite with that of the body is the
/// particle's own.
fn write(simulation: &mut sinew::Simulation, held: &HeldProperties, of_rows: &[OfBody]) {
    let particles = &mut simulation.particles;
    for (row, (of_body, &own)) in of_rows.iter().zip(&held.gravity_scale).enumerate() {
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

/// How a body takes part in contacts.
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
