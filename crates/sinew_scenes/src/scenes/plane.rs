//! A plane as an equation, which keeps a ball on it, and as an inequality, which lets the ball leave the plane but not penetrate it.

use bevy::prelude::*;
use bevy_sinew::AnyConstraint;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::{Bound, ConstraintKind, Equation, Points};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::{Restart, into_round};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "plane",
    heading: Heading::Constraints,
    title: "Equation and inequality",
    about: "all are thrown off the slope: C = 0 keeps the orange ones on it, C ≥ 0 lets the green ones leave and stops them when they return",
    eye: Vec3::new(1.4, 2.3, 4.5),
    target: Vec3::new(0.0, 1.05, 0.0),
    seconds: 4.0,
    moment: 0.3,
    lesson: Some(Lesson {
        try_this: "make the heavy balls heavier: nothing changes, because a single particle moves to the nearest point whatever its mass; drag an orange ball and a green one off the slope",
        watch: "all four stay side by side down the slope: a correction acts along the normal only, and removes only that part of the velocity",
        formula: "C = (p − p₀)·n; height y = v t − ½ g t² cos θ while y > 0, and 0 then",
        sliders: &[
            SceneSlider { label: "Jump", unit: "m/s", range: [1.0, 2.8], default: 2.0 },
            SceneSlider { label: "Slope", unit: "°", range: [10.0, 35.0], default: 25.0 },
            SceneSlider { label: "Heavy balls", unit: "kg", range: [2.0, 50.0], default: 10.0 },
        ],
        number: "Height of the heavy green ball over the slope",
        unit: "mm",
        after: 0.3,
        measure: |world| {
            let slope = component_of::<Slope>(world, "slope")?;
            let ball: Particle = component_of(world, "inequality")?;
            let height = (ball.position - CENTRE).dot(slope.normal) - slope.offset;
            Some(f64::from(height) * 1e3)
        },
        expect: |values, seconds| {
            let [jump, slope] = [values[0], values[1]].map(f64::from);
            let time = into_round(seconds, ROUND);
            let fall = 0.5 * 9.81 * libm::cos(slope.to_radians()) * time * time;
            (jump * time - fall).max(0.0) * 1e3
        },
        tolerance: [1.0, 2e-3],
    }),
    spawn,
};

/// All balls start again after this time, seconds.
const ROUND: f64 = 1.0;
/// Centre of the top face of the slope, and its length, metres.
const CENTRE: Vec3 = Vec3::new(0.0, FLOOR + 1.12, 0.0);
const LENGTH: f32 = 3.5;
/// Where the balls start along the slope, from its centre, metres.
const START: f32 = -1.6;

/// The reference of the measurement: the normal of the slope, and the distance from it at which the measured ball rests, metres.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Slope {
    normal: Vec3,
    offset: f32,
}

/// `C = (p - p₀)·n`, with C = 0 or C ≥ 0.
#[derive(Debug)]
struct OnPlane {
    point: Vec3,
    normal: Vec3,
    bound: Bound,
}

impl Equation for OnPlane {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        gradients[0] = self.normal;
        points.relative_to(0, self.point).dot(self.normal)
    }

    fn bound(&self) -> Bound {
        self.bound
    }

    fn is_length(&self) -> bool {
        true
    }
}

fn spawn(world: &mut World) {
    let [jump, slope, heavy] = values(world);
    world.insert_resource(AirDrag(0.0));
    let angle = slope.to_radians();
    let turn = Quat::from_rotation_z(-angle);
    let (down, normal) = (turn * Vec3::X, turn * Vec3::Y);
    floor(world, Vec2::new(4.4, 2.4), Look::color(0x4b4f5c).roughness(0.9));
    // The slab has no collider: a constraint on each ball keeps it on the plane.
    let slab = mesh(world, rounded_box(Vec3::new(LENGTH, 0.06, 1.8), 0.02, 2));
    let at = Transform::from_translation(CENTRE - normal * 0.03).with_rotation(turn);
    world.spawn((InScene, slab, Look::color(0xe9e3d5).roughness(0.7), at));
    let stripe = mesh(world, Cuboid::new(LENGTH - 0.1, 0.006, 0.3));
    for side in [-1.2, 1.2] {
        let top = CENTRE + down * side - normal * 0.06;
        let stand = mesh(world, cylinder(0.04, top.y - FLOOR));
        let at = Transform::from_xyz(top.x, 0.5 * (top.y + FLOOR), 0.0);
        world.spawn((InScene, stand, Look::color(0x70787f).metal(), at));
    }
    let lanes = [
        ("light, equation", Bound::Equal, 1.0, -0.66, 0xd9622b),
        ("equation", Bound::Equal, heavy, -0.22, 0xd9622b),
        ("light, inequality", Bound::AtLeast, 1.0, 0.22, 0x4f9d69),
        ("inequality", Bound::AtLeast, heavy, 0.66, 0x4f9d69),
    ];
    for (name, bound, mass, z, color) in lanes {
        let pale = Look::color(if bound == Bound::Equal { 0xf1c9a8 } else { 0xbfdcc4 });
        let at = Transform::from_translation(CENTRE + Vec3::Z * z).with_rotation(turn);
        world.spawn((InScene, stripe.clone(), pale, at));
        let radius = if mass > 1.0 { 0.13 } else { 0.08 };
        let point = CENTRE + normal * radius;
        let from = point + down * START + Vec3::Z * z;
        let start = Particle::at(from).with_velocity(down * 0.4 + normal * jump);
        let skin = mesh(world, ball(radius));
        let made = world.spawn((
            InScene,
            Name::new(name),
            start,
            Restart::every(ROUND, start),
            Mass(mass),
            Radius(radius),
            Interpolate,
            Transform::from_translation(from),
            skin,
            Look::color(color).roughness(0.3),
        ));
        let particle = made.id();
        let plane = ConstraintKind::custom(OnPlane { point, normal, bound });
        world.spawn((InScene, AnyConstraint::new([particle], plane)));
        if name == "inequality" {
            world.spawn((InScene, Name::new("slope"), Slope { normal, offset: radius }));
        }
    }
}
