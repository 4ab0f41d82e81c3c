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
mod fence;
mod flag;
mod flatland;
mod hammock;
mod hills;
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
mod tiles;
pub(crate) mod timestep;
pub(crate) mod verlet;
mod volumes;

use crate::scene::Scene;

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
    fence::SCENE,
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
    hammock::SCENE,
    hills::SCENE,
    tiles::SCENE,
];

/// The scene of that name, if there is one.
pub fn find(name: &str) -> Option<&'static Scene> {
    ALL.iter().find(|scene| scene.name == name)
}
