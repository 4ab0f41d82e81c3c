//! A character controller with `move_and_slide`: it walks up a ramp and over a kerb, slides along a wall, jumps and lands.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{MoveAndSlideConfig, QueryFilter, SinewClock};

/// Velocity, m/s; whether it stands on the ground; the greatest height so far, metres.
#[derive(Component, Default)]
struct Character {
    velocity: Vec3,
    stands: bool,
    highest: f32,
}

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, (walk, finish).chain()).run()
}

fn setup(mut commands: Commands) {
    commands.spawn(Ground);
    let mut block = |size: Vec3, at: Transform| commands.spawn((Collider::cuboid(size), at)).id();
    // A ramp of 20 degrees up to a floor at 1 m, a kerb of 5 cm, and a slanted wall.
    let ramp = Transform::from_xyz(3.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(0.35));
    block(Vec3::new(6.0, 0.2, 4.0), ramp);
    block(Vec3::new(10.0, 1.0, 12.0), Transform::from_xyz(10.4, 0.5, 0.0));
    block(Vec3::new(8.0, 0.05, 12.0), Transform::from_xyz(11.0, 1.025, 0.0));
    let wall = Transform::from_xyz(11.0, 2.0, 0.0).with_rotation(Quat::from_rotation_y(-0.5));
    block(Vec3::new(0.2, 3.0, 20.0), wall);
    commands.spawn((
        Character::default(),
        Collider::capsule(0.3, 1.2),
        Transform::from_xyz(-2.0, 1.0, 0.0),
    ));
}

fn walk(
    one: Single<(Entity, &mut Character, &mut Transform, &Collider)>,
    query: SinewQuery,
    (clock, time): (Res<SinewClock>, Res<Time>),
) {
    let (entity, mut character, mut at, shape) = one.into_inner();
    let filter = QueryFilter { except: Some(entity), ..default() };
    let leaps = character.stands && clock.seconds > 7.0 && clock.seconds < 7.1;
    let fall = if leaps { 4.0 } else { character.velocity.y - 9.81 * time.delta_secs() };
    let speed = if clock.seconds < 9.0 { 2.5 } else { 0.0 };
    let velocity = Vec3::new(speed, fall, 0.0);
    let (from, config) = (at.to_isometry(), MoveAndSlideConfig::default());
    let out = query.move_and_slide(shape, from, velocity, time.delta(), &config, &filter);
    at.translation = out.position;
    character.velocity = out.projected_velocity;
    character.stands = out.ground.is_some();
    character.highest = character.highest.max(at.translation.y);
}

fn finish(
    clock: Res<SinewClock>,
    one: Single<(&Character, &Transform)>,
    mut exit: MessageWriter<AppExit>,
) {
    if clock.seconds > 10.0 {
        let (Character { velocity, stands, highest }, at) = *one;
        println!("ended at {:.2?}, jumped to {highest:.2} m, standing: {stands}", at.translation);
        // It stands on the kerb, has slid along the wall, is at rest, and has jumped.
        let (top, Vec3 { y, z, .. }) = (1.05 + 0.9 + 0.01, at.translation);
        assert!(*stands && (y - top).abs() < 0.01 && z < -1.0 && *velocity == Vec3::ZERO);
        assert!(*highest > top + 0.7);
        exit.write(AppExit::Success);
    }
}
