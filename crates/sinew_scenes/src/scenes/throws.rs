//! The same throw in four media: vacuum, air, water and honey.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Combine, Region};

use crate::look::Look;
use crate::props::{FLOOR, curve, floor, mesh};
use crate::rounds::{Restart, into_round};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "throws",
    heading: Heading::Forces,
    title: "One throw in four media",
    about: "the same ball thrown equally: in vacuum, in air, in water and, in front, in honey; each medium takes a fraction of the velocity per second",
    eye: Vec3::new(0.3, 2.4, 5.7),
    target: Vec3::new(0.0, 0.58, 0.0),
    seconds: 4.0,
    moment: 0.45,
    lesson: Some(Lesson {
        try_this: "throw at 60 and at 30 degrees: in vacuum both have the same range, in a medium the lower one goes farther; a lighter ball sinks more slowly in water and honey, and so it goes farther",
        watch: "the lines are the predicted paths, and the rings where they land; in honey no throw goes beyond v/λ, however long it flies",
        formula: "x = v (1 − exp(−λt)) cos α / λ, with λ = −ln(1 − d); it falls by g (1 − ρ/ρ_b)",
        sliders: &[
            SceneSlider { label: "Speed", unit: "m/s", range: [4.0, 6.3], default: 6.0 },
            SceneSlider { label: "Angle", unit: "°", range: [30.0, 60.0], default: 50.0 },
            SceneSlider { label: "Water drag", unit: "/s", range: [0.5, 0.95], default: 0.8 },
            SceneSlider {
                label: "Ball density",
                unit: "kg/m³",
                range: [3000.0, 8000.0],
                default: 5000.0,
            },
        ],
        number: "Range in water",
        unit: "m",
        after: 1.75,
        measure: |world| {
            let ball: Particle = component_of(world, "water")?;
            Some(f64::from(ball.position.x - START.x))
        },
        expect: |values, seconds| {
            let [speed, angle, drag, density] = [values[0], values[1], values[2], values[3]];
            let flight = Flight::of(speed, angle, 1000.0 / density, drag);
            flight.way(flight.lands().min(into_round(seconds, ROUND)))
        },
        tolerance: [0.01, 0.01],
    }),
    spawn,
};

/// All balls are thrown again after this time, seconds.
const ROUND: f64 = 2.0;
/// Radius of the balls, start of the first lane before its offset along z, and width of a lane, metres.
const RADIUS: f32 = 0.09;
const START: Vec3 = Vec3::new(-2.1, FLOOR + RADIUS, 0.0);
const LANE: f32 = 0.55;
/// Height of the media, and length of a lane, metres.
const HIGH: f32 = 2.0;
const LONG: f32 = 4.8;

/// A throw in a medium.
#[derive(Clone, Copy, Debug)]
struct Flight {
    /// Horizontal and vertical velocity at the start, m/s.
    velocity: [f64; 2],
    /// Gravity less buoyancy, m/s².
    gravity: f64,
    /// Rate of the drag, 1/s.
    rate: f64,
}

impl Flight {
    /// From the speed, m/s; the angle, degrees; the density of the medium relative to the ball; and the fraction of its velocity that the ball loses in a
    /// second.
    fn of(speed: f32, angle: f32, density: f32, drag: f32) -> Self {
        let (sin, cos) = libm::sincos(f64::from(angle).to_radians());
        Self {
            velocity: [f64::from(speed) * cos, f64::from(speed) * sin],
            gravity: 9.81 * (1.0 - f64::from(density)),
            rate: -libm::log1p(-f64::from(drag)),
        }
    }

    /// `(1 - e^(-λt))/λ`: the time for which the initial velocity would have to last to cover the same distance, seconds.
    fn lasting(self, time: f64) -> f64 {
        if self.rate > 0.0 { -libm::expm1(-self.rate * time) / self.rate } else { time }
    }

    /// Horizontal distance at a time, metres.
    fn way(self, time: f64) -> f64 {
        self.velocity[0] * self.lasting(time)
    }

    /// Height above the start at a time, metres.
    fn height(self, time: f64) -> f64 {
        let Self { velocity, gravity, rate } = self;
        if rate > 0.0 {
            let sink = gravity / rate;
            (velocity[1] + sink) * self.lasting(time) - sink * time
        } else {
            velocity[1] * time - 0.5 * gravity * time * time
        }
    }

    /// Time at which it is back at the height of its start, seconds.
    fn lands(self) -> f64 {
        // With drag it lands after more than half and less than all of the time of a flight without drag. The bracket is wider.
        let longest = 2.0 * self.velocity[1] / self.gravity;
        let [mut up, mut down] = [0.25 * longest, 1.001 * longest];
        for _ in 0..60 {
            let middle = 0.5 * (up + down);
            if self.height(middle) > 0.0 {
                up = middle;
            } else {
                down = middle;
            }
        }
        0.5 * (up + down)
    }
}

fn spawn(world: &mut World) {
    let [speed, angle, drag, density] = values(world);
    world.insert_resource(AirDrag(0.0));
    // Friction that stops the balls where they land.
    let sand = SurfaceMaterial { friction_rule: Combine::Max, ..SurfaceMaterial::new(20.0) };
    let ground = floor(world, Vec2::new(5.4, 4.0 * LANE + 0.4), Look::color(0xcdb891));
    world.entity_mut(ground).insert(sand);
    let volume = 4.0 / 3.0 * core::f32::consts::PI * RADIUS * RADIUS * RADIUS;
    let (sin, cos) = libm::sincosf(angle.to_radians());
    let throw = Vec3::new(cos, sin, 0.0) * speed;
    let skin = mesh(world, ball(RADIUS));
    let strip = mesh(world, Cuboid::new(LONG, 0.008, LANE - 0.06));
    let ring = mesh(world, Torus::new(RADIUS, RADIUS + 0.03));
    let media = [
        ("vacuum", 0.0, 0.0, 0x3b3f4a, 0x5b6270),
        ("air", 1.2, 0.2, 0xbcd9e8, 0x86a9bd),
        ("water", 1000.0, drag, 0x3d7ea6, 0x5aa9e6),
        ("honey", 1420.0, 0.995, 0xe0a526, 0xe9b44c),
    ];
    for (n, (name, fluid, drag, color, pale)) in media.into_iter().enumerate() {
        let z = (n as f32 - 1.5) * LANE;
        let from = START + Vec3::Z * z;
        let look = Look::color(color).roughness(0.3);
        let at = Transform::from_xyz(0.0, FLOOR + 0.004, z);
        world.spawn((InScene, strip.clone(), look.clone(), at));
        if fluid > 0.0 {
            let medium = Fluid { density: fluid, drag, current: Vec3::ZERO };
            // The upper half of the region is above the surface and has no effect.
            let region = Region::boxed(Vec3::new(LONG + 0.4, 2.0 * HIGH, LANE));
            let at = Transform::from_xyz(0.0, HIGH, z);
            world.spawn((InScene, Name::new("medium"), medium, region, at));
        }
        let flight = Flight::of(speed, angle, fluid / density, drag);
        let lands = flight.lands();
        let path = |k: i32| {
            let time = lands * f64::from(k) / 32.0;
            from + Vec3::new(flight.way(time) as f32, flight.height(time) as f32, 0.0)
        };
        let path: Vec<Vec3> = (0..=32).map(path).collect();
        curve(world, &path, 0.014, Look::color(pale));
        let at = from.with_y(FLOOR + 0.015) + Vec3::X * flight.way(lands) as f32;
        let at = Transform::from_translation(at).with_scale(Vec3::new(1.0, 0.5, 1.0));
        world.spawn((InScene, ring.clone(), Look::color(0xf3f1ea), at));
        let start = Particle::at(from).with_velocity(throw);
        world.spawn((
            InScene,
            Name::new(name),
            start,
            Restart::every(ROUND, start),
            Mass(density * volume),
            Radius(RADIUS),
            sand,
            Interpolate,
            Transform::from_translation(from),
            skin.clone(),
            Look::color(0xd1495b).roughness(0.3),
        ));
    }
}
