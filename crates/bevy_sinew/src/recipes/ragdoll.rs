//! Ragdolls: limp human figures.

use bevy::prelude::*;
use sinew::recipes::{Blueprint, RagdollSpec, ragdoll};

use super::build::{MeshShape, Recipe};
use super::rigid_box::spawn_parts;
use crate::components::{BodyContacts, CreationOrder, ParticleBody, Sleep};
use crate::frames::even_factor;
use crate::messages::Refusal;

/// A standing human figure without muscles, with its soles at the origin of its transform, facing +z.
///
/// Each segment of the figure becomes an entity with [`BodyPart`](crate::BodyPart), whose transform follows it; add a mesh to it. Segments that no joint
/// connects collide with each other.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let child = Ragdoll { height: 1.2, mass: 25.0, ..default() };
/// commands.spawn((child, Transform::from_xyz(0.0, 0.5, 0.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder, Sleep)]
pub struct Ragdoll {
    /// Height from the soles to the top of the head, metres. Default 1.75.
    pub height: f32,
    /// Mass of the whole figure, kg. Default 75.
    pub mass: f32,
    /// Damping rate of the joints, 1/s, 0 to 1000: of the motion of the limbs relative to each other. Default 0.5. A [`BodySolver`](crate::BodySolver) on the
    /// body overrides it.
    pub damping: f32,
}

impl Default for Ragdoll {
    fn default() -> Self {
        let spec = RagdollSpec::default();
        Self { height: spec.height, mass: spec.mass, damping: spec.damping }
    }
}

impl Recipe for Ragdoll {
    fn contacts(&self) -> Option<BodyContacts> {
        Some(BodyContacts::ALL)
    }

    fn blueprint(&self, _: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        let Self { height, mass, damping } = *self;
        let height = height * even_factor(scale)?;
        Ok(ragdoll(&RagdollSpec { height, mass, damping })?)
    }

    fn finish(&self, world: &mut World, body: Entity, blueprint: &Blueprint, particles: &[Entity]) {
        let names = blueprint.parts.iter().map(|part| Name::new(part.name));
        spawn_parts(world, body, blueprint, particles, names);
    }
}
