//! Boxes, and the rigid parts of bodies that have several.

use bevy::prelude::*;
use sinew::recipes::{Blueprint, BoxLayout, BoxSpec, Part, box_2d, box_3d};

use super::bind::attach;
use super::build::{MeshShape, Recipe};
use crate::components::{
    BodyPart, Collider, CreationOrder, PartOf, ParticleBody, RigidPose, Sleep,
};
use crate::messages::Refusal;
use crate::same::same_variants;

/// A rigid box of particles that distances hold together: 8 particles and 28 distances, or 4 and 6 if it is flat.
///
/// It is built at its `Transform`, with its scale; the transform then follows it. It has a [`BodyPart`] with its size, and collides by its shape.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let crate_ = RigidBox::new(Vec3::new(0.6, 0.4, 0.4)).with_mass(12.0);
/// commands.spawn((crate_, Transform::from_xyz(0.0, 2.0, 0.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder, Sleep)]
#[doc(alias = "ParticleBox")]
pub struct RigidBox {
    /// Edge lengths, metres, 1e-6 to 1e6, before scaling. Default 1 each.
    pub size: Vec3,
    /// Mass of the whole box, kg. Default 1.
    pub mass: f32,
    /// Where the particles are in the box. Default at the corners.
    pub particles: BoxParticles,
    /// Whether it is a two-dimensional box: 4 particles in the local xy plane. Default false.
    pub flat: bool,
}

/// Where the particles of a box are.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum BoxParticles {
    /// At its corners, so that particles and mesh coincide; its inertia is three times that of a solid box.
    #[default]
    Corners,
    /// At 1/√3 of the distance to its corners: mass and inertia are exactly those of a solid box.
    Equimomental,
}

same_variants!(BoxParticles, BoxLayout { Corners, Equimomental });

impl Default for RigidBox {
    fn default() -> Self {
        Self { size: Vec3::ONE, mass: 1.0, particles: BoxParticles::Corners, flat: false }
    }
}

impl RigidBox {
    /// A box with these edge lengths, metres, and a mass of 1 kg.
    pub fn new(size: Vec3) -> Self {
        Self { size, ..default() }
    }

    /// Returns the same box with another mass, kg.
    pub fn with_mass(self, mass: f32) -> Self {
        Self { mass, ..self }
    }
}

impl Recipe for RigidBox {
    fn blueprint(&self, _: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        let (size, layout) = (self.size * scale.abs(), self.particles.into());
        let spec = BoxSpec { size, mass: self.mass, layout, ..default() };
        Ok(if self.flat { box_2d(&spec)? } else { box_3d(&spec)? })
    }

    fn collider(&self, blueprint: &Blueprint) -> Option<Collider> {
        // A box without a thickness is as thick as its shorter edge.
        let Vec3 { x, y, z } = blueprint.parts.first()?.size;
        let z = if self.flat && z == 0.0 { x.min(y) } else { z };
        Some(Collider::cuboid(Vec3::new(x, y, z)))
    }

    fn finish(&self, world: &mut World, body: Entity, blueprint: &Blueprint, particles: &[Entity]) {
        if let Some(part) = blueprint.parts.first() {
            attach(world, body, (pose_of(part, particles), BodyPart { size: part.size }));
        }
    }
}

/// The pose of a rigid part.
pub(crate) fn pose_of(part: &Part, particles: &[Entity]) -> RigidPose {
    RigidPose {
        particles: part.particles.iter().map(|&i| particles[i as usize]).collect(),
        rest: part.rest.clone(),
    }
}

/// Spawns an entity for each rigid part of a body, with its pose.
pub(super) fn spawn_parts(
    world: &mut World,
    body: Entity,
    blueprint: &Blueprint,
    particles: &[Entity],
    names: impl Iterator<Item = Name>,
) {
    for (part, name) in blueprint.parts.iter().zip(names) {
        if world.get_entity(body).is_err() {
            return;
        }
        let pose = pose_of(part, particles);
        let spawned = world.spawn((name, BodyPart { size: part.size }, PartOf(body), pose)).id();
        if let Some(collider) = part.shape.as_ref().map(|_| part_collider(part.size)) {
            attach(world, spawned, collider);
        }
    }
}

/// The shape by which a part collides: a capsule along y, or a box.
fn part_collider(size: Vec3) -> Collider {
    if size.x == size.z && size.y >= size.x {
        return Collider::capsule(size.x * 0.5, size.y - size.x);
    }
    Collider::cuboid(size)
}
