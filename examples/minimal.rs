//! The program of the README: a crate falls past a curtain in the wind.

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
    let mut paint = |color: Color| {
        let material = StandardMaterial { double_sided: true, cull_mode: None, ..color.into() };
        MeshMaterial3d(materials.add(material))
    };
    let floor = meshes.add(Plane3d::default().mesh().size(20.0, 20.0));
    commands.spawn((Ground::default(), Mesh3d(floor), paint(Color::srgb(0.6, 0.6, 0.6))));
    commands.spawn(Wind { pressure: Vec3::new(2.0, 0.0, 4.0), gusts: 0.8, ..default() });
    // A box made of particles: its transform follows them. It is heavy, or the wind would have it.
    commands.spawn((
        ParticleBox::new(Vec3::ONE).with_mass(50.0),
        Mesh3d(meshes.add(Cuboid::default())),
        paint(Color::srgb(0.8, 0.5, 0.2)),
        Transform::from_xyz(1.2, 4.0, 0.0).with_rotation(Quat::from_rotation_z(0.6)),
    ));
    // A curtain: it brings its own mesh.
    commands.spawn((
        Cloth::grid(2.0, 2.0, 32, 32).pinned(ClothPins::TopEdge),
        paint(Color::srgb(0.7, 0.1, 0.1)),
        Transform::from_xyz(-1.2, 2.2, 0.0),
    ));
    let (sun, eye) = (Transform::from_xyz(2.0, 4.0, 3.0), Transform::from_xyz(0.0, 2.0, 7.0));
    commands.spawn((DirectionalLight::default(), sun.looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn((Camera3d::default(), eye.looking_at(Vec3::Y, Vec3::Y)));
}
