//! The program of the README, as it stands there: a ball on a rod swings into a tower of crates, beside a curtain in the wind.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

fn main() {
    App::new().add_plugins((DefaultPlugins, SinewPlugins)).add_systems(Startup, setup).run();
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // What Bevy needs to show anything: a camera and a light.
    let (eye, sun) = (Transform::from_xyz(0.0, 2.5, 7.5), Transform::from_xyz(2.0, 4.0, 3.0));
    commands.spawn((Camera3d::default(), eye.looking_at(Vec3::Y, Vec3::Y)));
    commands.spawn((DirectionalLight::default(), sun.looking_at(Vec3::ZERO, Vec3::Y)));

    let floor = meshes.add(Plane3d::default().mesh().size(30.0, 30.0));
    let grey = MeshMaterial3d(materials.add(Color::srgb(0.5, 0.5, 0.5)));
    commands.spawn((Ground, Mesh3d(floor), grey));

    // Crates made of particles: their transforms follow them, and they stand on each other.
    let wood = MeshMaterial3d(materials.add(Color::srgb(0.8, 0.5, 0.2)));
    let cube = Mesh3d(meshes.add(Cuboid::from_length(0.6)));
    for i in 0..5 {
        let body = RigidBox::new(Vec3::splat(0.6)).with_mass(2.0);
        let place = Transform::from_xyz(0.8, 0.3 + 0.6 * i as f32, 0.0);
        commands.spawn((body, cube.clone(), wood.clone(), place));
    }

    // Particles of one's own, and what holds them: entities like any others.
    let iron = MeshMaterial3d(materials.add(Color::srgb(0.2, 0.2, 0.25)));
    let ball = (Mesh3d(meshes.add(Sphere::new(0.35))), iron, Transform::default());
    let ball = (Particle::at(Vec3::new(-2.4, 4.0, 0.0)), Mass(20.0), Radius(0.35), ball);
    let ball = commands.spawn(ball).id();
    let hook = commands.spawn((Particle::at(Vec3::new(0.4, 4.0, 0.0)), Pinned::HERE)).id();
    commands.spawn(DistanceConstraint::new(hook, ball, 2.8));

    // A curtain, which brings its own mesh, and a wind.
    commands.spawn((
        Cloth::grid(2.0, 2.0, 32, 32).pinned(ClothPins::TopEdge),
        MeshMaterial3d(materials.add(StandardMaterial {
            double_sided: true,
            cull_mode: None,
            ..Color::srgb(0.7, 0.1, 0.1).into()
        })),
        Transform::from_xyz(-2.0, 2.4, -1.0),
    ));
    commands.spawn(Wind { pressure: Vec3::new(1.0, 0.0, 3.0), gusts: 0.8, ..default() });
}

#[cfg(test)]
#[path = "minimal/tests.rs"]
mod tests;
