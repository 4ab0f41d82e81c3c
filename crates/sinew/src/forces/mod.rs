//! Forces: what accelerates particles. They all add up (physics.md F1–F7); each file holds one law, its derivation and its test.
//!
//! A force law reads positions and velocities at the start of a substep and adds to [`Particles::acceleration`]. Nothing else moves
//! because of a force; what must hold exactly is a [constraint](crate::constraints) instead.

mod control;
mod electric;
mod fluid;
mod gravity;
mod region;
mod spring;
mod wind;

pub use control::Control;
pub use electric::{Electric, ElectricField};
pub use fluid::{Fluid, Hull, HullFault, Skin};
pub use gravity::Attractor;
pub use region::{Extent, Region};
pub use spring::{Spring, SpringFault};
pub use wind::{AirFlow, Wind};

pub(crate) use control::apply as apply_controls;
pub(crate) use electric::{ElectricScratch, apply as apply_electric, energy as electric_energy};
pub(crate) use fluid::{FluidScratch, apply as apply_fluids};
pub(crate) use gravity::{apply as apply_gravity_and_external, energy as gravity_energy};
pub(crate) use spring::apply as apply_springs;
pub(crate) use wind::{Air, PackedSurfaces, Pressures, apply_air, apply_wind, sample_air};

use glam::Vec3;

use crate::particles::{Particles, rate_of_drag};
use crate::tracked::Tracked;

/// The force laws of a simulation and what they act on.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Gravitational acceleration, m/s². Default `(0, -9.81, 0)`.
    pub gravity: Vec3,
    /// Points that attract, besides.
    pub attractors: Vec<Attractor>,
    /// Damping of everything by the air, as the share of velocity lost per second (the lectures' drag), 0 to 1. Default 0.
    pub drag: f32,
    /// The user's own forces on particles and compounds.
    pub controls: Vec<Control>,
    /// Springs between pairs of particles.
    pub springs: Vec<Spring>,
    /// Triangles of particles: wind presses on them and air drags, rays meet them, and bodies collide by them that ask for it
    /// ([`BodyContacts::surface`](crate::BodyContacts::surface)).
    pub surfaces: Tracked<Vec<[u32; 3]>>,
    /// Winds that press on them.
    pub winds: Vec<Wind>,
    /// Air that they and loose particles move in: with drag, lift and a velocity.
    pub air_flows: Vec<AirFlow>,
    /// Fluids that hulls and loose particles float in.
    pub fluids: Vec<Fluid>,
    /// Solids made of several particles that float by their own shape. One at fault is left out, and its particles float as balls.
    pub hulls: Vec<Hull>,
    /// How charges attract and repel.
    pub electric: Electric,
    /// Uniform electric fields, each within its region.
    pub electric_fields: Vec<ElectricField>,
}

impl Forces {
    /// The particles that these act on otherwise than on all alike: those that they name; `None` where it may be any of them. Which surfaces winds press on, and which
    /// particles have a charge, a gravity or a force of their own, is known elsewhere.
    pub(crate) fn rows(&self) -> Option<impl Iterator<Item = u32>> {
        // Each by its name, so that the compiler asks of which kind a new force is.
        let Self {
            gravity: _,
            drag: _,
            surfaces: _,
            winds: _,
            hulls: _,
            electric: _,
            electric_fields: _,
            attractors,
            air_flows,
            fluids,
            controls,
            springs,
        } = self;
        let any = !(attractors.is_empty() && air_flows.is_empty() && fluids.is_empty());
        let controlled = controls.iter().flat_map(|control| control.rows.iter().copied());
        let tied = springs.iter().flat_map(|spring| [spring.a, spring.b]);
        (!any).then(|| controlled.chain(tied))
    }
}

impl Default for Forces {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, -9.81, 0.0),
            attractors: Vec::new(),
            drag: 0.0,
            controls: Vec::new(),
            springs: Vec::new(),
            surfaces: Tracked::default(),
            winds: Vec::new(),
            air_flows: Vec::new(),
            fluids: Vec::new(),
            hulls: Vec::new(),
            electric: Electric::default(),
            electric_fields: Vec::new(),
        }
    }
}

/// Starts the sums of a substep afresh: no acceleration, and the damping of the air alone.
pub(crate) fn reset(particles: &mut Particles, forces: &Forces) {
    let air = rate_of_drag(forces.drag.clamp(0.0, 1.0));
    particles.clear_sums(if air.is_nan() { 0.0 } else { air });
}
