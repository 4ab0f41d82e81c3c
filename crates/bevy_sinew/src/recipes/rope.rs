//! Ropes.

use bevy::prelude::*;
use sinew::recipes::{Blueprint, RopeSpec, rope};

use super::build::{MeshShape, Recipe, attach};
use crate::components::{Bound, CreationOrder, ParticleBody, TubeMesh};
use crate::messages::Refusal;
use crate::step::frames::even_factor;

/// A rope: a chain of particles, drawn as a tube. It collides by its segments, each a capsule from one particle to the next
/// ([`ContactShape::Auto`](crate::ContactShape)).
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ParticleBody, CreationOrder)]
pub struct Rope {
    /// Where it starts, metres, in the body's own frame. Default its origin.
    pub from: Vec3,
    /// Where it ends, metres. Default 1 m below.
    pub to: Vec3,
    /// How many pieces it has, 1 and up. Default 20.
    pub segments: u32,
    /// Mass of the whole rope, kg. Default 0.1.
    pub mass: f32,
    /// Radius, metres. Default 0.01.
    pub radius: f32,
    /// How much longer it is than the gap between its ends, as a share of the gap. Default 0.
    pub slack: f32,
    /// Which way each piece keeps its length. Default both.
    pub bound: Bound,
    /// Compliance of each piece, m/N. Default 0.
    pub compliance: f32,
    /// Whether its start is held. Default yes.
    pub pin_start: bool,
    /// Whether its end is held. Default not.
    pub pin_end: bool,
}

impl Default for Rope {
    fn default() -> Self {
        let spec = RopeSpec::default();
        Self {
            from: spec.from,
            to: spec.to,
            segments: spec.segments,
            mass: spec.mass,
            radius: spec.radius,
            slack: spec.slack,
            bound: spec.bound.into(),
            compliance: spec.compliance,
            pin_start: true,
            pin_end: false,
        }
    }
}

impl Rope {
    /// A rope between two points, metres, held at the first one.
    pub fn between(from: Vec3, to: Vec3) -> Self {
        Self { from, to, ..default() }
    }
}

impl Recipe for Rope {
    fn blueprint(&self, _: Option<&MeshShape>, scale: Vec3) -> Result<Blueprint, Refusal> {
        let spec = RopeSpec {
            from: self.from * scale,
            to: self.to * scale,
            segments: self.segments,
            mass: self.mass,
            radius: self.radius * even_factor(scale)?,
            slack: self.slack,
            bound: self.bound.into(),
            compliance: self.compliance,
            pin_start: self.pin_start,
            pin_end: self.pin_end,
            ..default()
        };
        Ok(rope(&spec)?)
    }

    fn finish(&self, world: &mut World, body: Entity, _: &Blueprint, particles: &[Entity]) {
        let tube = TubeMesh { particles: particles.to_vec(), radius: self.radius, ..default() };
        attach(world, body, tube);
    }
}
