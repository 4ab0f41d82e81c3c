//! Air: what it takes from everything, the wind that presses on surfaces, and air that flows, with drag and lift.

use bevy::prelude::*;

use crate::components::CreationOrder;
use crate::same::same_fields;

/// Share of their velocity that all particles lose to the air per second, 0 to 1. Default 0.1.
///
/// That is the lectures' drag: it knows neither size nor shape. What slows down by its silhouette is an [`AirFlow`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// // Nothing slows down by itself, as in space.
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

/// A wind that presses on every [`WindSurface`](crate::WindSurface), whichever way that moves: the lectures' wind. It blows everywhere, or in the
/// [`Region`](super::Region) on the same entity.
///
/// Each triangle is pressed by its area times the cosine of the angle at which the wind meets it, from whichever side. So a sheet feels its silhouette, and a
/// closed body, which has a front and a back, feels it *twice*: give bodies half the pressure in a [`Region`](super::Region) of their own, or take an
/// [`AirFlow`]. Cloth and soft bodies have a surface. Ropes, boxes and figures have none, and a wind passes them by: give them a
/// [`WindSurface`](crate::WindSurface) of their particles, or let an [`AirFlow`] take them along, which acts on particles with a radius.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Region;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // Everywhere, and a fan's besides.
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
    /// How much gusts add and take, as a share of the pressure. Default 0.
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

/// Air with a velocity, everywhere or in the [`Region`](super::Region) on the same entity: things slow down, lift and fall in it as in air.
///
/// It acts on the triangles of every [`WindSurface`](crate::WindSurface) by their velocity relative to it, and on particles of no triangle with a
/// [`Radius`](crate::Radius) as on balls: loose ones, and those of ropes, boxes and figures. Where several overlap there is air once: velocities add up, density and coefficients are those of the densest. A
/// triangle stands for a sheet, with air on both sides: give the air around closed bodies half the coefficients.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{AirFlow};
/// # fn spawn(mut commands: Commands) {
/// // What has a large silhouette falls slowly in it.
/// commands.spawn(AirFlow::steady(Vec3::X * 3.0).with_gusts(0.3));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct AirFlow {
    /// Velocity in the world, m/s. Default zero: still air, in which things slow down.
    pub velocity: Vec3,
    /// Density, kg/m³. Default 1.225: at sea level and 15 °C.
    pub density: f32,
    /// Drag coefficient of a sheet that stands square to the flow, 0 and up. Default 1.28, that of a flat plate.
    pub drag: f32,
    /// Lift coefficient, 0 and up: the lift at the angle of attack α is `½ρ C A v² sin α cos α`. Default 1.28.
    pub lift: f32,
    /// How much gusts add and take: the standard deviation of each component of the velocity, as a share of the speed. Default 0;
    /// 0.1 over water, 0.3 in a town.
    pub gusts: f32,
    /// Size of the largest eddies, metres. Default 4.
    pub gust_length: f32,
    /// Time in which the eddies change, besides being carried along, seconds. Default 2.
    pub gust_period: f32,
    /// Whether loose particles with a radius feel it too, as balls. Default true.
    pub on_particles: bool,
}

impl Default for AirFlow {
    fn default() -> Self {
        sinew::AirFlow::default().into()
    }
}

impl AirFlow {
    /// A steady flow of the given velocity, m/s.
    pub fn steady(velocity: Vec3) -> Self {
        Self { velocity, ..default() }
    }

    /// The same with gusts of the given share of its speed.
    pub fn with_gusts(self, gusts: f32) -> Self {
        Self { gusts, ..self }
    }
}

same_fields!(AirFlow, sinew::AirFlow {
    velocity, density, drag, lift, gusts, gust_length, gust_period, on_particles,
} other { region: sinew::Region::EVERYWHERE });
