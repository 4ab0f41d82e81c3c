//! What surrounds the particles: fields that fill space, and the surfaces that bound it.

use bevy::prelude::*;

use super::order::CreationOrder;

/// Gravitational acceleration, m/s². Default `(0, -9.81, 0)`.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct Gravity(pub Vec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// Share of their velocity that all particles lose to the air per second, 0 to 1. Default 0.1.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct AirDrag(pub f32);

impl Default for AirDrag {
    fn default() -> Self {
        Self(0.1)
    }
}

/// Coulomb's law for particles with a [`Charge`](super::Charge).
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct Electric {
    /// Coulomb's constant K, N·m²/C². Default the vacuum's, 8.987552e9.
    pub constant: f32,
    /// Distance within which the force is softened, metres. Default 0.
    pub softening: f32,
}

impl Default for Electric {
    fn default() -> Self {
        let law = sinew::Electric::default();
        Self { constant: law.constant, softening: law.softening }
    }
}

/// A wind that blows everywhere, on every [`WindSurface`](super::WindSurface).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct Wind {
    /// Direction, and dynamic pressure in pascal: ½ρv², so 10 m/s is 61 Pa. Default 5 Pa along x.
    pub pressure: Vec3,
    /// How much gusts add and take, as a share of the pressure. Default 0.
    pub gusts: f32,
    /// Distance between gusts along the wind, metres. Default 2.
    pub gust_length: f32,
    /// Time between gusts at one place, seconds. Default 1.3.
    pub gust_period: f32,
}

impl Default for Wind {
    fn default() -> Self {
        let wind = sinew::Wind::steady(Vec3::X * 5.0);
        Self {
            pressure: wind.pressure,
            gusts: wind.gusts,
            gust_length: wind.gust_length,
            gust_period: wind.gust_period,
        }
    }
}

impl From<Wind> for sinew::Wind {
    fn from(wind: Wind) -> Self {
        Self {
            pressure: wind.pressure,
            gusts: wind.gusts,
            gust_length: wind.gust_length,
            gust_period: wind.gust_period,
        }
    }
}

/// A fluid that fills the half-space below the entity's local xz plane; particles with a [`Radius`](super::Radius) float in it.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct Fluid {
    /// Density, kg/m³. Default 1000, water.
    pub density: f32,
    /// Share of its velocity that a submerged particle loses per second, 0 to 1. Default 0.8.
    pub drag: f32,
}

impl Default for Fluid {
    fn default() -> Self {
        let water = sinew::Fluid::water(0.0);
        Self { density: water.density, drag: water.drag }
    }
}

/// An endless plane that no particle sinks under: the entity's local xz plane, solid below.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct Ground {
    /// Coulomb's coefficient of friction μ, 0 and up. Default 0.5.
    pub friction: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self { friction: 0.5 }
    }
}

/// A room that no particle leaves: a box around the entity's position, its walls along the world's axes.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct BoundingBox {
    /// Half of each edge, metres. Default 5.
    pub half_size: Vec3,
    /// Coulomb's coefficient of friction μ on its walls, 0 and up. Default 0.5.
    pub friction: f32,
}

impl Default for BoundingBox {
    fn default() -> Self {
        Self { half_size: Vec3::splat(5.0), friction: 0.5 }
    }
}
