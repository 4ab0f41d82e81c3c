//! A cape, attached by its collar to a hero that walks in a circle. The example prints where the cape is, and exits.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParticles, SinewClock};

#[derive(Component)]
struct Hero;

#[derive(Component)]
struct Cape;

fn main() -> AppExit {
    // Runs without a window, as fast as possible. To see it, use `DefaultPlugins` and add a camera and a light.
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, (walk, finish).chain()).run()
}

fn setup(mut commands: Commands) {
    let hero =
        commands.spawn((Hero, Transform::from_xyz(2.0, 0.0, 0.0), Collider::capsule(0.25, 1.0)));
    let hero = hero.id();
    // The collar is every particle in a thin box around the upper edge of the cloth: no particle index is needed.
    let collar = Anchor::InBox { center: Vec3::Y * 0.6, half_size: Vec3::new(1.0, 0.01, 0.1) };
    commands.spawn((
        Cape,
        Cloth::grid(0.6, 1.2, 12, 24),
        AttachTo::new(hero).part(collar),
        Transform::from_xyz(2.0, 0.0, 0.3),
    ));
    commands.spawn(Wind { pressure: Vec3::X * 0.5, gusts: 0.5, ..default() });
}

/// The hero walks once around the circle in six seconds, facing forward.
fn walk(mut heroes: Query<&mut Transform, With<Hero>>, clock: Res<SinewClock>) {
    let turn = Quat::from_rotation_y(clock.seconds as f32 * core::f32::consts::TAU / 6.0);
    for mut hero in &mut heroes {
        *hero = Transform::from_translation(turn * Vec3::X * 2.0).with_rotation(turn);
    }
}

/// After five seconds the cape has followed and hangs behind the hero.
fn finish(
    clock: Res<SinewClock>,
    heroes: Query<&Transform, With<Hero>>,
    capes: Query<&BodyParticles, With<Cape>>,
    particles: Query<&Particle>,
    mut exit: MessageWriter<AppExit>,
) -> Result {
    if clock.seconds < 5.0 {
        return Ok(());
    }
    let (hero, cape) = (heroes.single()?.translation, capes.single()?);
    let all = cape.iter().filter_map(|p| particles.get(p).ok());
    let far = all.map(|p| p.position.distance(hero)).fold(0.0, f32::max);
    println!("after 10 m the cape is within {far:.2} m of its hero");
    exit.write(if far < 2.0 { AppExit::Success } else { AppExit::error() });
    Ok(())
}
