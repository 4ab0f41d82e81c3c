//! The list of scenes.

mod areas;
mod banner;
pub(crate) mod belt;
mod billiards;
mod bin;
mod boats;
mod bricks;
mod buoys;
pub(crate) mod capacitor;
pub(crate) mod car;
mod catch;
mod catenary;
mod chain;
mod charges;
mod crates;
mod curtain;
pub(crate) mod damping;
mod drape;
pub(crate) mod events;
mod feathers;
mod flag;
mod flatland;
mod hinges;
pub(crate) mod impulses;
mod inertia;
pub(crate) mod integrators;
mod jelly;
pub(crate) mod least;
mod loads;
pub(crate) mod masses;
mod million;
mod net;
mod orbits;
pub(crate) mod orders;
mod pendulums;
mod pile;
mod planar;
mod plane;
mod playground;
mod race;
mod ragdoll;
mod rails;
mod repose;
pub(crate) mod reversal;
pub(crate) mod ropes;
pub(crate) mod sleep;
mod slopes;
mod soft;
pub(crate) mod spins;
mod square;
mod stage;
mod stairs;
pub(crate) mod step;
mod straight;
pub(crate) mod swap;
pub(crate) mod sweeps;
mod throws;
pub(crate) mod timestep;
pub(crate) mod verlet;
mod volumes;

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::{InScene, Look, Scene, cylinder, rounded_box};

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
    integrators::SCENE,
    reversal::SCENE,
    timestep::SCENE,
    orders::SCENE,
    inertia::SCENE,
    planar::SCENE,
    car::SCENE,
    impulses::SCENE,
    masses::SCENE,
    volumes::SCENE,
    damping::SCENE,
    straight::SCENE,
    step::SCENE,
    verlet::SCENE,
    plane::SCENE,
    throws::SCENE,
    least::SCENE,
    areas::SCENE,
    spins::SCENE,
    playground::SCENE,
    events::SCENE,
    sleep::SCENE,
    stage::SCENE,
    million::SCENE,
    sweeps::SCENE,
];

/// The scene of that name.
pub fn find(name: &str) -> Option<&'static Scene> {
    ALL.iter().find(|scene| scene.name == name)
}

/// A post or a rail along its y axis, from its radius and its height, metres: as it is drawn it is met.
fn post(world: &mut World, radius: f32, height: f32) -> (Mesh3d, Collider) {
    (mesh(world, cylinder(radius, height)), Collider::cylinder(radius, height))
}

/// Height of the upper side of a [`floor`], metres: a little above the ground that a renderer draws.
const FLOOR: f32 = 0.03;

/// A floor of the scene's own about the origin, from its lengths along x and z in metres; solid, its upper side at [`FLOOR`].
fn floor(world: &mut World, size: Vec2, look: Look) -> Entity {
    let size = Vec3::new(size.x, 0.2, size.y);
    let slab = (mesh(world, rounded_box(size, 0.015, 2)), Collider::cuboid(size));
    let at = Transform::from_xyz(0.0, FLOOR - 0.5 * size.y, 0.0);
    world.spawn((InScene, Name::new("floor"), slab, look, at)).id()
}

/// A line through points, metres, as a stick for each piece between two of them. It is drawn alone: nothing meets it.
fn curve(world: &mut World, points: &[Vec3], radius: f32, look: Look) {
    let stick = |pair: &[Vec3]| {
        let (from, to) = (pair[0], pair[1]);
        let turn = Quat::from_rotation_arc(Vec3::Y, (to - from).normalize_or(Vec3::Y));
        let at = Transform::from_translation(0.5 * (from + to)).with_rotation(turn);
        cylinder(radius, from.distance(to)).transformed_by(at)
    };
    let mut sticks = points.windows(2).map(stick);
    let Some(mut line) = sticks.next() else { return };
    for next in sticks {
        // All sticks have the same attributes, so nothing is refused.
        line.merge(&next).ok();
    }
    let line = mesh(world, line);
    world.spawn((InScene, line, look, Transform::default()));
}

/// Adds a mesh to the app's assets.
fn mesh(world: &mut World, mesh: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh))
}
