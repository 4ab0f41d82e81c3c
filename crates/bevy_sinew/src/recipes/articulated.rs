//! Articulated bodies: rigid bones and joints with limits.

use bevy::prelude::*;
use sinew::recipes::{self, ArticulatedSpec, Blueprint, articulated};

use super::build::{MeshShape, Recipe};
use super::rigid_box::spawn_parts;
use crate::components::{BodyContacts, CreationOrder, ParticleBody, Sleep};
use crate::frames::even_factor;
use crate::messages::Refusal;
use crate::same::same_variants;

/// A body of rigid bones that are connected by joints: a chain, a door, a lamp, an animal.
///
/// Each bone becomes an entity with [`BodyPart`](crate::BodyPart), with the name of the bone, in the order of the bones. Its `Transform` follows the bone: it
/// is centred on it, with y from tail to head; add a mesh to that entity. Bones that no joint connects collide with each other, unless they overlap when they
/// are built.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Articulated;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Bone, BoneJoint};
/// # fn spawn(mut commands: Commands) {
/// let post = Bone { pinned: true, ..Bone::new("post", Vec3::Y * 2.0, Vec3::Y) };
/// let door = Bone::new("door", Vec3::Y * 2.0, Vec3::new(1.0, 2.0, 0.0))
///     .on(0, BoneJoint::Hinge { axis: Vec3::Y, min: 0.0, max: 1.5 });
/// commands.spawn(Articulated::new([post, door]));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder, Sleep)]
pub struct Articulated {
    /// The bones, at least one; each after its parent. Default none, which is refused.
    pub bones: Vec<Bone>,
    /// Fraction of the velocity that its particles lose per second, 0 to 1. Default 0.
    pub drag: f32,
}

/// A bone of an [`Articulated`] body, in the pose in which the body is built. All joints are at rest in that pose.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Bone {
    /// Name of the bone's part. Default `"bone"`.
    pub name: String,
    /// Index of the bone to which it is connected, which must be lower than its own. Default none.
    pub parent: Option<usize>,
    /// The near end, where the joint is, metres in the body's own frame. Default the origin.
    pub head: Vec3,
    /// The far end, metres. Default 1 m below the origin.
    pub tail: Vec3,
    /// Thickness, metres, 1e-6 to 1e6. Default 0.1. Its particles have half of it as their radius.
    pub width: f32,
    /// Mass, kilograms, 1e-9 to 1e12. Default 1.
    pub mass: f32,
    /// The joint with its parent. Default a ball joint without limits.
    pub joint: BoneJoint,
    /// Whether the bone is pinned where it is built. Default false.
    pub pinned: bool,
}

/// The joint of a [`Bone`] with its parent, at its head.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum BoneJoint {
    /// A ball joint.
    Ball {
        /// Largest angle between the bone and its built pose, relative to its parent, radians, 0 to π (no limit).
        cone: f32,
        /// Largest twist about the bone to either side, radians, 0 to π (no limit).
        twist: f32,
    },
    /// A hinge.
    Hinge {
        /// Direction of the axis in the body's own frame, not zero. Positive angles follow the right-hand rule.
        axis: Vec3,
        /// Smallest angle from the built pose, radians, -π to 0.
        min: f32,
        /// Largest angle from the built pose, radians, 0 to π. From -π to π is no limit.
        max: f32,
    },
    /// Rigidly connected to its parent.
    Fixed,
    /// Not connected to its parent.
    Free,
}

impl Default for BoneJoint {
    fn default() -> Self {
        recipes::Joint::default().into()
    }
}

impl Default for Bone {
    fn default() -> Self {
        let recipes::Bone { name, parent, head, tail, width, mass, joint, pinned } = default();
        Self { name: name.into(), parent, head, tail, width, mass, joint: joint.into(), pinned }
    }
}

impl Bone {
    /// A bone of 1 kg and 10 cm thickness between two points, metres.
    pub fn new(name: impl Into<String>, head: Vec3, tail: Vec3) -> Self {
        Self { name: name.into(), head, tail, ..default() }
    }

    /// Returns the same bone with a joint to a parent, given by its index.
    pub fn on(self, parent: usize, joint: BoneJoint) -> Self {
        Self { parent: Some(parent), joint, ..self }
    }

    /// The solver's bone, scaled.
    fn spec(&self, factor: f32) -> recipes::Bone {
        recipes::Bone {
            // The solver's names are static strings; the names of the parts are set in `finish`.
            name: "bone",
            parent: self.parent,
            head: self.head * factor,
            tail: self.tail * factor,
            width: self.width * factor,
            mass: self.mass,
            joint: self.joint.into(),
            pinned: self.pinned,
        }
    }
}

impl Articulated {
    /// A body of these bones.
    pub fn new(bones: impl Into<Vec<Bone>>) -> Self {
        Self { bones: bones.into(), ..default() }
    }
}

impl Recipe for Articulated {
    fn contacts(&self) -> Option<BodyContacts> {
        Some(BodyContacts::ALL)
    }

    fn blueprint(&self, _: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        let factor = even_factor(scale)?;
        let bones = self.bones.iter().map(|bone| bone.spec(factor)).collect();
        Ok(articulated(&ArticulatedSpec { bones, drag: self.drag })?)
    }

    fn finish(&self, world: &mut World, body: Entity, blueprint: &Blueprint, particles: &[Entity]) {
        let names = self.bones.iter().map(|bone| Name::new(bone.name.clone()));
        spawn_parts(world, body, blueprint, particles, names);
    }
}

same_variants!(BoneJoint, recipes::Joint {
    Ball { cone, twist }, Hinge { axis, min, max }, Fixed, Free,
});
