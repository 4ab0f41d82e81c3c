//! Fluids at rest or in a steady flow: buoyancy and drag (physics.md F6, F7).
//!
//! Below a surface with the unit normal `up`, the pressure is `p = ρ g s`, with the depth `s` measured along `up` and `g` the component of gravity against
//! `up`. Where gravity is not along `up`, as in a mountain stream, its other component drives the stream; floating bodies are pulled along the tilted surface
//! by it and held back by the drag. [`ball`] applies this to loose particles, [`hull`] to bodies of several particles.
//!
//! The drag pulls the velocity towards that of the current, at a rate proportional to the submerged share of the body. The fluid that an accelerating body has
//! to displace (added mass) is not modelled: a light body bobs faster than in reality.

mod ball;
mod clip;
mod hull;
#[cfg(test)]
mod tests;

pub use hull::{Hull, HullFault, Skin};

pub(crate) use hull::FluidScratch;

use glam::Vec3;

use super::Forces;
use super::region::Region;
use crate::particles::{Particles, rate_of_drag};

/// A fluid that fills the half-space below a plane, or the part of it within a region.
///
/// A particle with a radius floats in it as a ball; particles that carry a [`Hull`] float as that hull instead. Where fluids overlap, each acts as if it were
/// alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Unit normal of the surface, pointing out of the fluid. Default +y.
    pub up: Vec3,
    /// `up · x` of the points on the surface, metres. Default 0.
    pub level: f32,
    /// Density, kg/m³. Default 1000, water.
    pub density: f32,
    /// Share of its velocity relative to the fluid that a fully submerged particle loses per second, 0 to 1; proportionally less if it is partly submerged.
    /// Default 0.8. A drag of 1 is a rate of [`FASTEST`](Self::FASTEST).
    pub drag: f32,
    /// Velocity of the fluid, m/s; the drag acts relative to it. Default zero.
    pub current: Vec3,
    /// The part of the half-space that the fluid fills. Default everywhere. A pool is a box; where the region fades, density and drag fade with it. The region
    /// is evaluated once for a body, at the centre of its submerged part, not for each triangle: walls exert no pressure.
    pub region: Region,
}

impl Default for Fluid {
    fn default() -> Self {
        Self::water(0.0)
    }
}

impl Fluid {
    /// Highest rate of damping by a fluid, 1/s; it stands for a drag of 1. The exact rate for a drag of 1 is infinite, and so would be the pull of the current.
    /// This rate removes a relative velocity within any practical step, and is finite.
    pub const FASTEST: f32 = 1e6;

    /// Water at rest with its surface at y = `level` metres: 1000 kg/m³, a drag of 0.8.
    pub fn water(level: f32) -> Self {
        Self {
            up: Vec3::Y,
            level,
            density: 1000.0,
            drag: 0.8,
            current: Vec3::ZERO,
            region: Region::default(),
        }
    }

    /// The same fluid within `region` only.
    pub fn within(self, region: Region) -> Self {
        Self { region, ..self }
    }

    /// Whether every number is finite and in range. An invalid fluid does nothing.
    pub fn is_valid(&self) -> bool {
        (self.up.length_squared() - 1.0).abs() < 1e-3
            && self.level.is_finite()
            && self.density.is_finite()
            && self.density >= 0.0
            && (0.0..=1.0).contains(&self.drag)
            && self.current.is_finite()
            && self.region.is_valid()
    }

    /// Rate at which a velocity relative to the fluid decays, 1/s.
    fn rate(&self) -> f32 {
        rate_of_drag(self.drag).min(Self::FASTEST)
    }

    /// Increase of pressure with depth, Pa/m: `ρ g` with the component of gravity against `up`.
    fn weight(&self, gravity: Vec3) -> f32 {
        -self.density * gravity.dot(self.up)
    }
}

/// Adds the buoyancy and the drag of all fluids on all hulls, and on the loose particles that carry no hull.
pub(crate) fn apply(
    particles: &mut Particles,
    Forces { fluids, hulls, gravity, .. }: &Forces,
    scratch: &mut FluidScratch,
) {
    if !fluids.iter().any(Fluid::is_valid) {
        return;
    }
    scratch.carriers.clear();
    if !hulls.is_empty() {
        scratch.carriers.resize(particles.len(), false);
        for hull in hulls {
            hull::apply(particles, fluids, hull, *gravity, scratch);
        }
    }
    for fluid in fluids.iter().filter(|fluid| fluid.is_valid()) {
        ball::apply(particles, fluid, *gravity, &scratch.carriers);
    }
}
