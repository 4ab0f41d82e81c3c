//! The list of scenes.

mod banner;
pub(crate) mod belt;
mod billiards;
mod bin;
mod boats;
mod bricks;
mod buoys;
mod capacitor;
mod catch;
mod catenary;
mod chain;
mod charges;
mod crates;
mod curtain;
mod drape;
mod feathers;
mod flag;
mod flatland;
mod hinges;
mod jelly;
mod loads;
mod net;
mod orbits;
mod pendulums;
mod pile;
mod race;
mod ragdoll;
mod rails;
mod repose;
pub(crate) mod ropes;
mod slopes;
mod soft;
mod square;
mod stairs;
pub(crate) mod swap;

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::{Heading, Lesson, cylinder};

/// A scene: what it is called, where to look at it from, and how to spawn it.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// What it is called on a command line.
    pub name: &'static str,
    /// The heading that it stands under.
    pub heading: Heading,
    /// What it is called on a picture.
    pub title: &'static str,
    /// One sentence on what there is to see.
    pub about: &'static str,
    /// Where the camera stands, metres.
    pub eye: Vec3,
    /// What it looks at, metres.
    pub target: Vec3,
    /// How long it is worth watching, seconds.
    pub seconds: f32,
    /// When it is best photographed, seconds.
    pub moment: f32,
    /// What to try in it, and the number that a formula predicts, if there is one.
    pub lesson: Option<Lesson>,
    /// Spawns everything; each root carries [`InScene`](crate::InScene).
    pub spawn: fn(&mut World),
}

/// All scenes, in the order in which a gallery shows them.
pub const ALL: &[Scene] = &[
    flag::SCENE,
    crates::SCENE,
    square::SCENE,
    ragdoll::SCENE,
    ropes::SCENE,
    banner::SCENE,
    jelly::SCENE,
    pendulums::SCENE,
    charges::SCENE,
    buoys::SCENE,
    boats::SCENE,
    bricks::SCENE,
    soft::SCENE,
    swap::SCENE,
    hinges::SCENE,
    feathers::SCENE,
    orbits::SCENE,
    flatland::SCENE,
    pile::SCENE,
    drape::SCENE,
    stairs::SCENE,
    catch::SCENE,
    curtain::SCENE,
    net::SCENE,
    slopes::SCENE,
    race::SCENE,
    billiards::SCENE,
    bin::SCENE,
    chain::SCENE,
    rails::SCENE,
    belt::SCENE,
    loads::SCENE,
    catenary::SCENE,
    repose::SCENE,
    capacitor::SCENE,
];

/// The scene of that name.
pub fn find(name: &str) -> Option<&'static Scene> {
    ALL.iter().find(|scene| scene.name == name)
}

/// A post or a rail along its y axis, from its radius and its height, metres: as it is drawn it is met.
fn post(world: &mut World, radius: f32, height: f32) -> (Mesh3d, Collider) {
    (mesh(world, cylinder(radius, height)), Collider::cylinder(radius, height))
}

/// Adds a mesh to the app's assets.
fn mesh(world: &mut World, mesh: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh))
}
