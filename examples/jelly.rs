//! A soft body: a cube of jelly falls on the floor, is squashed, wobbles and regains its shape.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParticles, SinewClock};

#[derive(Component)]
struct Jelly;

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, watch).run()
}

fn setup(mut commands: Commands) {
    commands.spawn(Ground);
    let jelly = SoftBody { stiffness: 1.5e4, ..SoftBody::cuboid(Vec3::ONE, UVec3::splat(4)) };
    commands.spawn((Jelly, jelly, Transform::from_xyz(0.0, 2.0, 0.0)));
}

/// Tracks the smallest height of the cube, metres, and checks it and the height at rest after five seconds.
fn watch(
    clock: Res<SinewClock>,
    jellies: Query<&BodyParticles, With<Jelly>>,
    particles: Query<&Particle>,
    mut least: Local<Option<f32>>,
    mut exit: MessageWriter<AppExit>,
) {
    let Ok(members) = jellies.single() else { return };
    let heights = || members.iter().filter_map(|p| particles.get(p).ok()).map(|p| p.position.y);
    let low = heights().fold(f32::INFINITY, f32::min);
    let tall = heights().fold(f32::NEG_INFINITY, f32::max) - low;
    *least = Some(least.map_or(tall, |least| least.min(tall)));
    if clock.seconds > 5.0 {
        let squashed = least.unwrap_or(1.0);
        println!("the jelly was squashed to {squashed:.2} m and is {tall:.2} m tall at rest");
        let right = squashed < 0.9 && tall > squashed + 0.02 && tall < 1.02 && low > -0.01;
        exit.write(if right { AppExit::Success } else { AppExit::error() });
    }
}
