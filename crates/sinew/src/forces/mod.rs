//! Forces: everything that accelerates particles. They all add up (physics.md F1–F7); each file holds one kind of force, its derivation and its tests.
//!
//! A force reads positions and velocities at the start of a substep and adds to [`Particles::acceleration`]; it moves nothing directly. What must hold exactly
//! is a [constraint](crate::constraints) instead.

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
pub(crate) use gravity::{
    RowGravity, apply as apply_gravity_and_external, energy as gravity_energy,
};
pub(crate) use spring::apply as apply_springs;
pub(crate) use wind::{Air, PackedSurfaces, Pressures, apply_air, apply_wind, sample_air};

use glam::Vec3;

use crate::particles::{Particles, rate_of_drag};
use crate::tracked::Tracked;

/// The forces of a simulation, and what they act on.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Gravitational acceleration, m/s². Default `(0, -9.81, 0)`.
    pub gravity: Vec3,
    /// Points that attract, in addition to the uniform gravity.
    pub attractors: Vec<Attractor>,
    /// Damping of all particles by the air: the share of velocity lost per second, 0 to 1. Default 0.
    pub drag: f32,
    /// User-driven forces on particles and compounds.
    pub controls: Vec<Control>,
    /// Springs between pairs of particles.
    pub springs: Vec<Spring>,
    /// Triangles of particles. Wind and air act on them, ray casts hit them, and bodies that enable it
    /// ([`BodyContacts::surface`](crate::BodyContacts::surface)) collide by them.
    pub surfaces: Tracked<Vec<[u32; 3]>>,
    /// Winds that press on the surfaces.
    pub winds: Vec<Wind>,
    /// Air around surfaces and loose particles: with drag, lift and a velocity.
    pub air_flows: Vec<AirFlow>,
    /// Fluids that hulls and loose particles float in.
    pub fluids: Vec<Fluid>,
    /// Bodies of several particles that float by their own shape. A faulty hull is skipped, and its particles float as balls.
    pub hulls: Vec<Hull>,
    /// Coulomb forces between charges, and a uniform field.
    pub electric: Electric,
    /// Uniform electric fields, each within its region.
    pub electric_fields: Vec<ElectricField>,
}

impl Forces {
    /// The particles on which a force acts individually, as controls and springs do; `None` if it may be any particle. Not included: winds on surfaces, and
    /// particles with a charge, a gravity scale or an external force of their own, which are tracked elsewhere.
    pub(crate) fn rows(&self) -> Option<impl Iterator<Item = u32>> {
        // Exhaustive, so that a new kind of force does not compile until it is classified here.
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

/// Clears the sums for a new substep: no acceleration, and only the air's damping.
pub(crate) fn reset(particles: &mut Particles, forces: &Forces) {
    let air = rate_of_drag(forces.drag.clamp(0.0, 1.0));
    particles.clear_sums(if air.is_nan() { 0.0 } else { air });
}
