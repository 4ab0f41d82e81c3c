//! Articulated bodies: bones, joints and how far these go.

use bevy::prelude::*;
use sinew::recipes::{self, ArticulatedSpec, Blueprint, articulated};

use super::build::{MeshShape, Recipe};
use super::rigid_box::spawn_parts;
use crate::components::{BodyContacts, CreationOrder, ParticleBody, Sleep};
use crate::frames::even_factor;
use crate::messages::Refusal;
use crate::same::same_variants;

/// A body of rigid bones that are joined: a chain, a door, a lamp, an animal.
///
/// Each bone becomes an entity with [`BodyPart`](crate::BodyPart), named as the bone is, in their order; its `Transform`, centred on the bone with y
/// from its tail to its head, follows it: give those a mesh. Bones that are not joined to each other collide, unless they overlap as they are built.
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
    /// Share of the velocity that its particles lose per second, 0 to 1. Default 0.
    pub drag: f32,
}

/// A bone of an [`Articulated`] body, where it is when that is built. All joints are at rest then.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Bone {
    /// What its part is called. Default `"bone"`.
    pub name: String,
    /// The number of the bone that it is joined to, a lower one than its own. Default none.
    pub parent: Option<usize>,
    /// Its near end, metres, where the joint is, in the body's own frame. Default the origin.
    pub head: Vec3,
    /// Its far end, metres. Default 1 m below.
    pub tail: Vec3,
    /// How thick it is, metres, 1e-6 to 1e6. Default 0.1. Its particles have half of that for their radius.
    pub width: f32,
    /// Kilograms, 1e-9 to 1e12. Default 1.
    pub mass: f32,
    /// How it is joined to its parent. Default free to turn in any way.
    pub joint: BoneJoint,
    /// Whether it is held where it is. Default not.
    pub pinned: bool,
}

/// How a [`Bone`] is joined to its parent, at its head.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum BoneJoint {
    /// It turns about a point.
    Ball {
        /// Largest angle between the bone and where it was built, seen from its parent, radians, 0 to π (any).
        cone: f32,
        /// Largest twist about itself to either side, radians, 0 to π (any).
        twist: f32,
    },
    /// It turns about an axis.
    Hinge {
        /// Direction of the axis in the body's own frame, not zero. A positive angle turns the bone by the right hand about it.
        axis: Vec3,
        /// Smallest angle from where it was built, radians, -π to 0.
        min: f32,
        /// Largest angle, radians, 0 to π. From -π to π is all the way round.
        max: f32,
    },
    /// It is one piece with its parent.
    Fixed,
    /// It has nothing to do with its parent.
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
    /// A bone of 1 kg and 10 cm across between two points, metres.
    pub fn new(name: impl Into<String>, head: Vec3, tail: Vec3) -> Self {
        Self { name: name.into(), head, tail, ..default() }
    }

    /// The same on a parent, by its number.
    pub fn on(self, parent: usize, joint: BoneJoint) -> Self {
        Self { parent: Some(parent), joint, ..self }
    }

    /// The same for the solver, so many times as large.
    fn spec(&self, factor: f32) -> recipes::Bone {
        recipes::Bone {
            // Names are given to the parts below: the solver's are those of its own figures.
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
