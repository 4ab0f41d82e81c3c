//! A constraint of one's own: marbles that cannot leave the surface of a doughnut, not even where it overhangs.
//!
//! What holds each of them is a component of this program. The simulation learns of it in one line, and solves it like its own.

use bevy::prelude::*;
use bevy_sinew::Charge;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::{ConstraintKind, Equation, Points};

/// From the middle of the doughnut to the middle of its tube, metres.
const MAJOR: f32 = 1.0;
/// Radius of the tube, metres.
const MINOR: f32 = 0.35;
/// Radius of a marble, metres.
const MARBLE: f32 = 0.06;

/// Keeps a particle on a torus around the z axis: plain data, to add, change or despawn while the game runs.
#[derive(Component, Clone)]
struct OnTorus {
    #[entities]
    particle: Entity,
    centre: Vec3,
    major: f32,
    minor: f32,
}

impl ParticleConstraint for OnTorus {
    fn particles(&self) -> &[Entity] {
        core::slice::from_ref(&self.particle)
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::custom(Torus { centre: self.centre, major: self.major, minor: self.minor })
    }
}

/// The same as an equation: how far the particle is from the surface, metres.
#[derive(Debug)]
struct Torus {
    centre: Vec3,
    major: f32,
    minor: f32,
}

impl Equation for Torus {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let from_centre = points.relative_to(0, self.centre);
        // The nearest point in the middle of the tube; from there, straight out of it, the distance grows by a metre per metre.
        let around = Vec3::new(from_centre.x, from_centre.y, 0.0).normalize_or(Vec3::X);
        let from_middle = from_centre - around * self.major;
        gradients[0] = from_middle.normalize_or(around);
        from_middle.length() - self.minor
    }

    fn is_length(&self) -> bool {
        true
    }
}

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, SinewPlugins))
        .register_particle_constraint::<OnTorus>() // That is all.
        .add_systems(Startup, setup)
        .run();
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // Bevy's torus lies around the y axis; ours stands.
    let doughnut = bevy::math::primitives::Torus { minor_radius: MINOR, major_radius: MAJOR };
    commands.spawn((
        Mesh3d(meshes.add(doughnut.mesh().major_resolution(96).minor_resolution(48))),
        MeshMaterial3d(materials.add(Color::srgb(0.75, 0.5, 0.3))),
        Transform::from_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2)),
    ));
    let ball = meshes.add(Sphere::new(MARBLE));
    for i in 0..24 {
        // Near the top, in a row across the tube, each with a push of its own. They slide down, swing to and fro, and shy away from each other.
        let side = (i as f32 - 11.5) / 11.5;
        let place = Vec3::new(0.2 * side, MAJOR + MINOR + MARBLE, 0.25 * side);
        let marble = (
            Particle::at(place).with_velocity(Vec3::new(2.0 * side, 0.0, 1.0)),
            Mass(0.05),
            Charge(1.5e-6),
            Mesh3d(ball.clone()),
            MeshMaterial3d(materials.add(Color::hsl(15.0 * i as f32, 0.7, 0.5))),
            // A particle with a transform is drawn where it is.
            Transform::from_translation(place),
        );
        let particle = commands.spawn(marble).id();
        commands.spawn(OnTorus {
            particle,
            centre: Vec3::ZERO,
            major: MAJOR,
            minor: MINOR + MARBLE,
        });
    }
    let (sun, eye) = (Transform::from_xyz(2.0, 4.0, 5.0), Transform::from_xyz(1.2, 0.8, 4.5));
    commands.spawn((DirectionalLight::default(), sun.looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn((Camera3d::default(), eye.looking_at(Vec3::ZERO, Vec3::Y)));
}
