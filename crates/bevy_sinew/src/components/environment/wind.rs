//! Air: uniform damping, wind pressure on surfaces, and flowing air with drag and lift.

use bevy::prelude::*;

use crate::components::CreationOrder;
use crate::same::same_fields;

/// Air resistance as damping: the fraction of their velocity that all particles lose per second, 0 to 1. Default 0.1.
///
/// It depends neither on size nor on shape (this is the lectures' isotropic friction). For drag that depends on the silhouette use an [`AirFlow`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// // No air resistance, as in space.
/// commands.insert_resource(AirDrag(0.0));
/// # }
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct AirDrag(pub f32);

impl Default for AirDrag {
    fn default() -> Self {
        Self(0.1)
    }
}

/// A wind as a pressure on every [`WindSurface`](crate::WindSurface), independent of the velocity of the surface (this is the lectures' wind). It blows
/// everywhere, or in the [`Region`](super::Region) on the same entity.
///
/// The force on each triangle is the pressure times its area times the cosine of the angle of incidence, from either side. A sheet thus receives the force on
/// its silhouette, and a closed body, which has a front and a back, receives it *twice*: give closed bodies half the pressure in a [`Region`](super::Region) of
/// their own, or use an [`AirFlow`]. Cloth and soft bodies have a surface. Ropes, boxes and figures have none, and wind does not act on them: give them a
/// [`WindSurface`](crate::WindSurface) of their particles, or use an [`AirFlow`], which acts on particles with a radius.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Region;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A wind everywhere, and that of a fan.
/// commands.spawn(Wind { pressure: Vec3::X * 2.0, gusts: 0.5, ..default() });
/// let fan = Wind { pressure: Vec3::Z * 20.0, gusts: 0.0, ..default() };
/// commands.spawn((fan, Region::cylinder(0.5, 3.0), Transform::from_xyz(0.0, 1.0, 0.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct Wind {
    /// Direction in the world, and dynamic pressure in pascal: ½ρv², so 10 m/s is 61 Pa. Default 5 Pa along x.
    pub pressure: Vec3,
    /// Amplitude of gusts, as a fraction of the pressure. Default 0.
    pub gusts: f32,
    /// Distance between gusts along the wind, metres. Default 2.
    pub gust_length: f32,
    /// Time between gusts at one place, seconds. Default 1.3.
    pub gust_period: f32,
}

impl Default for Wind {
    fn default() -> Self {
        sinew::Wind::steady(Vec3::X * 5.0).into()
    }
}

same_fields!(Wind, sinew::Wind { pressure, gusts, gust_length, gust_period } other { region: sinew::Region::EVERYWHERE });

/// Air with a velocity, everywhere or in the [`Region`](super::Region) on the same entity. It exerts drag and lift.
///
/// It acts on the triangles of every [`WindSurface`](crate::WindSurface) by their velocity relative to the air, and on particles with a
/// [`Radius`](crate::Radius) that belong to no triangle as on balls: loose particles, and those of ropes, boxes and figures. Where several flows overlap, their
/// velocities add up, and density and coefficients are those of the densest. A triangle represents a sheet with air on both sides: around closed bodies, use
/// half the coefficients.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{AirFlow};
/// # fn spawn(mut commands: Commands) {
/// // Bodies with a large silhouette fall slowly in it.
/// commands.spawn(AirFlow::steady(Vec3::X * 3.0).with_gusts(0.3));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct AirFlow {
    /// Velocity in the world, m/s. Default zero: still air, in which bodies slow down.
    pub velocity: Vec3,
    /// Density, kg/m³. Default 1.225: air at sea level and 15 °C.
    pub density: f32,
    /// Drag coefficient of a sheet square to the flow, 0 or more. Default 1.28, that of a flat plate. Without drag there is no lift.
    pub drag: f32,
    /// Lift coefficient, 0 or more: the lift at the angle of attack α is `½ρ C A v² sin α cos α`. Default 1.28.
    pub lift: f32,
    /// Intensity of turbulence: the standard deviation of each component of the velocity, as a fraction of the speed. Default 0; 0.1 over water, 0.3 in a town.
    pub gusts: f32,
    /// Size of the largest eddies, metres. Default 4.
    pub gust_length: f32,
    /// Time in which the eddies change, besides being carried along, seconds. Default 2.
    pub gust_period: f32,
    /// Whether it also acts on particles with a radius that belong to no triangle, as on balls. Default true.
    pub on_particles: bool,
}

impl Default for AirFlow {
    fn default() -> Self {
        sinew::AirFlow::default().into()
    }
}

impl AirFlow {
    /// A steady flow with this velocity, m/s.
    pub fn steady(velocity: Vec3) -> Self {
        Self { velocity, ..default() }
    }

    /// Returns the same flow with gusts, as a fraction of its speed.
    pub fn with_gusts(self, gusts: f32) -> Self {
        Self { gusts, ..self }
    }
}

same_fields!(AirFlow, sinew::AirFlow {
    velocity, density, drag, lift, gusts, gust_length, gust_period, on_particles,
} other { region: sinew::Region::EVERYWHERE });
