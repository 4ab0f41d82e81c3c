//! The first program of the README, word for word: a ball on a rod swings into a wall of crates, beside a flag in the wind.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{MouseDragPlugin, TubeMesh};

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, SinewPlugins, MouseDragPlugin))
        .insert_resource(ClearColor(Color::srgb(0.55, 0.72, 0.88)))
        .insert_resource(GlobalAmbientLight { brightness: 700.0, ..default() })
        .add_systems(Startup, setup)
        .run();
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // A camera and a light.
    let (eye, sun) = (Transform::from_xyz(-2.2, 2.4, 6.4), Transform::from_xyz(-3.0, 6.0, 4.0));
    commands.spawn((Camera3d::default(), eye.looking_at(Vec3::new(-0.2, 1.3, 0.0), Vec3::Y)));
    let light = DirectionalLight { shadow_maps_enabled: true, illuminance: 6000.0, ..default() };
    commands.spawn((light, sun.looking_at(Vec3::ZERO, Vec3::Y)));
    let mut paint = |color| MeshMaterial3d(materials.add(Color::Srgba(color)));

    // The ground is an infinite plane; its mesh is the part that is drawn.
    let floor = Mesh3d(meshes.add(Plane3d::default().mesh().size(200.0, 200.0)));
    commands.spawn((Ground, floor, paint(Srgba::rgb(0.35, 0.45, 0.3))));

    // A wall of crates: rigid bodies. Their transforms follow the simulation.
    let (cube, wood) =
        (Mesh3d(meshes.add(Cuboid::from_length(0.6))), paint(Srgba::rgb(0.7, 0.4, 0.15)));
    for row in 0..4 {
        for i in 0..4 - row {
            let at =
                Vec3::new(0.62 * (i as f32 + 0.5 * row as f32 - 1.0), 0.3 + 0.6 * row as f32, 0.0);
            let body = RigidBox::new(Vec3::splat(0.6)).with_mass(2.0);
            commands.spawn((body, cube.clone(), wood.clone(), Transform::from_translation(at)));
        }
    }

    // A wrecking ball: a pinned particle, a heavy one and a rod between them. Each is an entity.
    let (ball, iron) = (Mesh3d(meshes.add(Sphere::new(0.35))), paint(Srgba::rgb(0.15, 0.15, 0.2)));
    let hook = commands.spawn((Particle::at(Vec3::new(0.0, 3.9, 0.8)), Pinned::HERE)).id();
    let ball = (Particle::at(Vec3::new(-0.4, 2.7, 2.9)), Mass(20.0), Radius(0.35), ball);
    let ball = commands.spawn((ball, iron.clone(), Transform::default())).id();
    commands.spawn(DistanceConstraint::new(hook, ball, 2.45));
    commands.spawn((TubeMesh { particles: vec![hook, ball], ..default() }, iron.clone()));

    // A flag on a pole, and wind. Cloth builds its own mesh.
    let pole = Mesh3d(meshes.add(Cylinder::new(0.04, 3.4)));
    commands.spawn((pole, iron, Transform::from_xyz(-2.6, 1.7, -0.5)));
    let red = StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..Color::srgb(0.7, 0.05, 0.05).into()
    };
    commands.spawn((
        Cloth::grid(1.6, 1.0, 32, 20).pinned(ClothPins::LeftEdge),
        MeshMaterial3d(materials.add(red)),
        Transform::from_xyz(-1.8, 2.8, -0.5),
    ));
    commands.spawn(Wind { pressure: Vec3::new(4.0, 0.0, 1.5), gusts: 0.8, ..default() });
}

#[cfg(test)]
#[path = "minimal/tests.rs"]
mod tests;
