//! Electric forces between charges, and electric fields.

use bevy::prelude::*;

use crate::components::CreationOrder;
use crate::same::same_fields;

/// Coulomb's law for particles with a [`Charge`](crate::Charge), and a uniform field. The force between two charges at a distance `r` is
/// `K q₁ q₂ r / (r² + softening²)^{3/2}`; like charges repel each other.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Charge, Electric};
/// # fn example(mut commands: Commands) {
/// // A constant of 1 instead of 9e9, for charges in convenient units; softened, so that opposite charges may meet.
/// commands.insert_resource(Electric { constant: 1.0, softening: 0.1, ..default() });
/// commands.spawn((Particle::at(Vec3::ZERO), Charge(2.0), Pinned::HERE));
/// commands.spawn((Particle::at(Vec3::X), Charge(-1.0)));
/// # }
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct Electric {
    /// Coulomb's constant K, N·m²/C². Default that of the vacuum, 8.987552e9. 0 switches the forces between charges off.
    pub constant: f32,
    /// Distance within which the force is softened, metres, 0 or more, so that it stays finite for coincident charges. Default 0.
    pub softening: f32,
    /// A uniform field everywhere, N/C (the same as V/m): the force on a charge is `q E`. Default zero.
    pub field: Vec3,
    /// Up to this many charges, the force of every pair is computed; above it, distant groups act as one charge (Barnes–Hut), which is faster from about 1300
    /// on. Default 2000.
    pub all_pairs_up_to: u32,
    /// How large a group may be to act as one charge, as a fraction of its distance: 0.1 to 1. Default 0.45, with a force error of 0.5 %.
    pub opening: f32,
}

impl Default for Electric {
    fn default() -> Self {
        sinew::Electric::default().into()
    }
}

same_fields!(Electric, sinew::Electric { constant, softening, field, all_pairs_up_to, opening });

/// A uniform electric field, everywhere or in the [`Region`](super::Region) on the same entity: between the plates of a capacitor.
///
/// At the boundary of its region the field is not conservative (a real field has a fringe there), so a charge that circles in and out may gain energy.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Region;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{ElectricField};
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((ElectricField::new(Vec3::X * 1e5), Region::boxed(Vec3::splat(2.0))));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct ElectricField {
    /// Force per charge in the world, N/C. Default zero.
    pub field: Vec3,
}

impl ElectricField {
    /// A field in N/C.
    pub fn new(field: Vec3) -> Self {
        Self { field }
    }
}
