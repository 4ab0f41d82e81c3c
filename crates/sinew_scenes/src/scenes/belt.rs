//! A belt that carries crates along, and balls that bounce, each as its material is.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Combine, ParticleBody, ParticleOf, RigidPose, SinewClock};

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "belt",
    heading: Heading::Contacts,
    title: "Moved and bounced",
    about: "a tray that goes to and fro carries crates by friction alone; five balls bounce to e² of their height",
    eye: Vec3::new(2.4, 2.6, 6.0),
    target: Vec3::new(0.0, 0.8, 0.0),
    seconds: 6.0,
    moment: 1.4,
    lesson: None,
    spawn,
};

/// Goes to and fro along x: its path is a function of the simulation's time alone.
#[derive(Component)]
pub(crate) struct Tray {
    at: Vec3,
}

/// Leads trays, 0.8 m to either side in 5 s.
pub(crate) fn lead_trays(clock: Res<SinewClock>, mut trays: Query<(&Tray, &mut Transform)>) {
    for (tray, mut transform) in &mut trays {
        let turn = (clock.seconds / 5.0).fract() as f32 * core::f32::consts::TAU;
        transform.translation = tray.at + Vec3::X * (0.8 * libm::sinf(turn));
    }
}

fn spawn(world: &mut World) {
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
    let floor = Transform::from_xyz(0.0, 0.02, 0.9);
    let slab = Vec3::new(3.4, 0.04, 0.8);
    let plate = mesh(world, rounded_box(slab, 0.01, 2));
    let steel = (Collider::cuboid(slab), Look::color(0x9aa4ad).metal());
    world.spawn((
        InScene,
        steel,
        SurfaceMaterial::new(0.3).with_rules(Combine::Max, Combine::Max),
        plate,
        floor,
    ));
    let skin = mesh(world, ball(0.12));
    for (n, restitution) in [0.0, 0.4, 0.7, 0.9, 1.0].into_iter().enumerate() {
        let place = Vec3::new(0.6 * n as f32 - 1.2, 1.8, 0.9);
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
        let ball =
            world.spawn((Particle::at(place), Mass(0.3), Radius(0.12), ParticleOf(body))).id();
        world.entity_mut(body).insert(RigidPose { particles: vec![ball], rest: vec![Vec3::ZERO] });
    }
}
