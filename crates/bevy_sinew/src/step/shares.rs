//! Distributes the properties of a body to its particles: mass and charge in proportion to their masses, radius and drag to each.

use std::collections::BTreeSet;

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::prelude::*;
use sinew::{ParticleFault, ParticleSeed};

use super::pins::check_once;
use crate::bevy_version::OnRemove;
use crate::components::{BodyParticles, Charge, Drag, Mass, Particle, Radius};
use crate::messages::{Refusal, Refused};

/// The properties of a body.
type BodyProperties = (
    Option<Ref<'static, Mass>>,
    Option<Ref<'static, Radius>>,
    Option<Ref<'static, Charge>>,
    Option<Ref<'static, Drag>>,
);

/// The properties of a particle.
type ParticleProperties = (
    &'static mut Mass,
    Option<&'static mut Radius>,
    Option<&'static mut Charge>,
    Option<&'static mut Drag>,
);

/// Relative deviation of the sum of the particles' masses from the body's mass below which they are not scaled: round-off.
const ROUNDING: f64 = 1e-6;

/// Writes the properties of a body to its particles, if the body was built or a property changed since the last tick.
///
/// A number that is not finite, or out of range, is refused once and changes nothing.
pub(crate) fn distribute(
    mut commands: Commands,
    bodies: Query<
        (Entity, Ref<BodyParticles>, BodyProperties),
        Or<(With<Mass>, With<Radius>, With<Charge>, With<Drag>)>,
    >,
    mut particles: Query<ParticleProperties, (With<Particle>, Without<BodyParticles>)>,
    mut messages: MessageWriter<Refused>,
    mut broken: Local<BTreeSet<Entity>>,
) {
    for (body, list, (mass, radius, charge, drag)) in &bodies {
        let anew = list.is_changed();
        let new = |changed: Option<bool>| changed.is_some_and(|changed| changed || anew);
        let changed = [
            new(mass.as_ref().map(DetectChanges::is_changed)),
            new(radius.as_ref().map(DetectChanges::is_changed)),
            new(charge.as_ref().map(DetectChanges::is_changed)),
            new(drag.as_ref().map(DetectChanges::is_changed)),
        ];
        if !changed.contains(&true) {
            continue;
        }
        let fault = fault(mass.as_deref(), radius.as_deref(), charge.as_deref(), drag.as_deref());
        if !check_once(&mut broken, &mut messages, body, fault.map(Refusal::Body)) {
            continue;
        }
        let [mass_changed, radius_changed, charge_changed, drag_changed] = changed;
        let mut total = sum(&particles, &list);
        if let (Some(mass), true) = (&mass, mass_changed) {
            scale_masses(&mut particles, &list, total, f64::from(mass.0));
            total = sum(&particles, &list);
        }
        for particle in list.iter() {
            let Ok((mass, own_radius, own_charge, own_drag)) = particles.get_mut(particle) else {
                continue;
            };
            if let (Some(radius), true) = (&radius, radius_changed) {
                put(&mut commands, particle, own_radius, **radius);
            }
            // The charge is distributed as the masses are, so it changes with them, too.
            if let (Some(charge), true) = (&charge, charge_changed || mass_changed) {
                let share = f64::from(charge.0) * f64::from(mass.0) / total;
                put(&mut commands, particle, own_charge, Charge(share as f32));
            }
            if let (Some(drag), true) = (&drag, drag_changed) {
                put(&mut commands, particle, own_drag, **drag);
            }
        }
    }
}

/// Removes from the particles of a body a component that was removed from the body: its charge, its drag. (An observer, because a removal may no longer be
/// readable at the next tick.)
pub(crate) fn remove_from_particles<T: Component>(
    removed: OnRemove<T>,
    mut commands: Commands,
    bodies: Query<&BodyParticles, Allow<Disabled>>,
) {
    for particle in bodies.get(removed.entity).into_iter().flat_map(RelationshipTarget::iter) {
        commands.entity(particle).try_remove::<T>();
    }
}

/// The error of a body's property, if any: the one that it would be on a particle.
fn fault(
    mass: Option<&Mass>,
    radius: Option<&Radius>,
    charge: Option<&Charge>,
    drag: Option<&Drag>,
) -> Option<ParticleFault> {
    let seed = ParticleSeed::at(Vec3::ZERO);
    let seed = ParticleSeed {
        mass: mass.map_or(seed.mass, |mass| mass.0),
        radius: radius.map_or(seed.radius, |radius| radius.0),
        charge: charge.map_or(seed.charge, |charge| charge.0),
        drag: drag.map_or(seed.drag, |drag| drag.0),
        ..seed
    };
    // An infinite mass pins a particle; a body cannot have one.
    let infinite = mass.is_some_and(|mass| !mass.0.is_finite()).then_some(ParticleFault::Mass);
    infinite.or(seed.fault())
}

/// Total mass of some particles, kg.
fn sum(
    particles: &Query<ParticleProperties, (With<Particle>, Without<BodyParticles>)>,
    list: &BodyParticles,
) -> f64 {
    let own = list.iter().filter_map(|particle| particles.get(particle).ok());
    own.map(|(mass, ..)| f64::from(mass.0)).filter(|mass| mass.is_finite()).sum()
}

/// Scales the masses of particles with a total of `total` kg to a total of `wanted` kg.
fn scale_masses(
    particles: &mut Query<ParticleProperties, (With<Particle>, Without<BodyParticles>)>,
    list: &BodyParticles,
    total: f64,
    wanted: f64,
) {
    let factor = wanted / total;
    if !(factor.is_finite() && factor > 0.0) || (total - wanted).abs() <= ROUNDING * wanted {
        return;
    }
    for particle in list.iter() {
        if let Ok((mut mass, ..)) = particles.get_mut(particle) {
            mass.0 = (f64::from(mass.0) * factor) as f32;
        }
    }
}

/// Writes a component if it differs, or inserts it.
fn put<T: Component<Mutability = bevy::ecs::component::Mutable> + PartialEq>(
    commands: &mut Commands,
    particle: Entity,
    own: Option<Mut<T>>,
    wanted: T,
) {
    match own {
        Some(mut own) => drop(own.set_if_neq(wanted)),
        None => drop(commands.entity(particle).try_insert(wanted)),
    }
}
