//! A kinematic tray that carries crates by friction, and balls that bounce by the restitution of their material.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Combine, ParticleBody, ParticleOf, RigidPose, SinewClock};

use crate::look::Look;
use crate::props::{curve, mesh};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "belt",
    heading: Heading::Contacts,
    title: "Carried and bouncing",
    about: "a tray that moves to and fro carries crates by friction alone; five balls bounce to e² of their height",
    eye: Vec3::new(2.4, 2.6, 6.0),
    target: Vec3::new(0.0, 0.8, 0.0),
    seconds: 6.0,
    moment: 1.4,
    lesson: Some(Lesson {
        try_this: "change the restitution of the ball in the middle, or the height it falls from",
        watch: "each bounce returns the fraction e of the speed and so e² of the height, up to the red mark; the crates move with the tray, because its acceleration stays below μ g",
        formula: "v' = −e v, so h' = e² h",
        sliders: &[
            SceneSlider { label: "Restitution", unit: "", range: [0.3, 1.0], default: 0.7 },
            SceneSlider { label: "Fall", unit: "m", range: [0.8, 2.0], default: 1.64 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 9.81], default: 9.81 },
        ],
        number: "Height of the ball in the middle",
        unit: "m",
        after: 1.1,
        measure: |world| {
            let ball: Particle = component_of(world, "middle ball")?;
            Some(f64::from(ball.position.y - RADIUS - PLATE))
        },
        expect: |values, seconds| {
            let [restitution, fall, gravity] = [values[0], values[1], values[2]].map(f64::from);
            height(restitution, fall, gravity, seconds)
        },
        tolerance: [0.01, 0.01],
    }),
    spawn,
};

/// A tray that moves to and fro along x. Its position is a function of simulated time alone.
#[derive(Component)]
pub(crate) struct Tray {
    at: Vec3,
}

/// Moves the trays by 0.8 m to either side, with a period of 5 s.
pub(crate) fn move_trays(clock: Res<SinewClock>, mut trays: Query<(&Tray, &mut Transform)>) {
    for (tray, mut transform) in &mut trays {
        let turn = (clock.seconds / 5.0).fract() as f32 * core::f32::consts::TAU;
        transform.translation = tray.at + Vec3::X * (0.8 * libm::sinf(turn));
    }
}

/// Radius of a ball, and height of the plate on which the balls bounce, metres.
const RADIUS: f32 = 0.12;
const PLATE: f32 = 0.04;

/// Height over the plate of a ball that fell from `fall` metres and bounces without air resistance, metres.
fn height(restitution: f64, fall: f64, gravity: f64, seconds: f64) -> f64 {
    let first = libm::sqrt(2.0 * fall / gravity);
    if seconds < first {
        return fall - 0.5 * gravity * seconds * seconds;
    }
    let (mut since, mut speed) = (seconds - first, gravity * first);
    for _ in 0..100 {
        speed *= restitution;
        let lasts = 2.0 * speed / gravity;
        if since < lasts {
            return speed * since - 0.5 * gravity * since * since;
        }
        since -= lasts;
    }
    0.0
}

fn spawn(world: &mut World) {
    let [restitution, fall, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    // The formula ignores air resistance.
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let at = Vec3::new(0.0, 0.5, -0.9);
    let size = Vec3::new(2.0, 0.12, 0.9);
    let board = mesh(world, rounded_box(size, 0.02, 2));
    let tray = (Tray { at }, Collider::cuboid(size), SurfaceMaterial::new(0.7));
    let rubber = Look::color(0x3a3f47).roughness(0.9);
    world.spawn((InScene, tray, board, rubber, Interpolate, Transform::from_translation(at)));
    let skin = mesh(world, rounded_box(Vec3::splat(0.36), 0.012, 2));
    for (n, x) in [-0.6, 0.0, 0.6, 0.3].into_iter().enumerate() {
        let high = if n == 3 { 1.3 } else { 0.8 };
        world.spawn((
            InScene,
            Name::new("crate"),
            RigidBox::new(Vec3::splat(0.36)).with_mass(3.0),
            SurfaceMaterial::new(0.7),
            skin.clone(),
            Look::texture("textures/crate.png").roughness(0.8),
            Interpolate,
            Transform::from_translation(at + Vec3::new(x, high - 0.5, 0.0)),
        ));
    }
    let floor = Transform::from_xyz(0.0, 0.5 * PLATE, 0.9);
    let slab = Vec3::new(3.4, PLATE, 0.8);
    let plate = mesh(world, rounded_box(slab, 0.01, 2));
    let steel = (Collider::cuboid(slab), Look::color(0x9aa4ad).metal());
    world.spawn((
        InScene,
        steel,
        SurfaceMaterial::new(0.3).with_rules(Combine::Max, Combine::Max),
        plate,
        floor,
    ));
    let skin = mesh(world, ball(RADIUS));
    let high = PLATE + RADIUS + restitution * restitution * fall;
    let mark = [-0.2, 0.2].map(|side| Vec3::new(side, high, 0.9 - RADIUS - 0.02));
    curve(world, &mark, 0.01, Look::color(0xd0342c));
    for (n, restitution) in [0.0, 0.4, restitution, 0.9, 1.0].into_iter().enumerate() {
        let place = Vec3::new(0.6 * n as f32 - 1.2, PLATE + RADIUS + fall, 0.9);
        let body = world
            .spawn((
                InScene,
                Name::new("ball"),
                ParticleBody,
                SurfaceMaterial::default().with_restitution(restitution),
                skin.clone(),
                Look::texture("textures/ball.png").roughness(0.4),
                Interpolate,
                Transform::from_translation(place),
            ))
            .id();
        let particle = (Particle::at(place), Mass(0.3), Radius(RADIUS), ParticleOf(body));
        let ball = world
            .spawn((Name::new(if n == 2 { "middle ball" } else { "bouncing" }), particle))
            .id();
        world.entity_mut(body).insert(RigidPose { particles: vec![ball], rest: vec![Vec3::ZERO] });
    }
}
