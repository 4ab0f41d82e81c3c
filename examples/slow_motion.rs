//! Slow motion: crates tumble at full speed, then at a quarter of it, then are paused and stepped one tick at a time, while the game's own clock runs on.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::prelude::*;

fn main() -> AppExit {
    // A game uses `DefaultPlugins`, a camera and meshes. This example draws nothing, takes one tick a frame, and exits by itself.
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, direct).run()
}

fn setup(mut commands: Commands) {
    commands.spawn(Ground);
    for i in 0..6 {
        let wood = RigidBox::new(Vec3::splat(0.5));
        let at = Transform::from_xyz(0.1 * i as f32, 2.0 + 0.6 * i as f32, 0.0);
        // Interpolated bodies move smoothly at any speed.
        commands.spawn((wood, AngularVelocity(Vec3::Z * i as f32), Interpolate, at));
    }
}

/// One second each: full speed, a quarter, and a pause with ten single steps.
fn direct(
    time: Res<Time>,
    clock: Res<SinewClock>,
    mut control: ResMut<SinewControl>,
    mut ticks: Local<Vec<u64>>,
    mut exit: MessageWriter<AppExit>,
) {
    let second = time.elapsed_secs() as usize;
    if second < ticks.len() {
        return;
    }
    ticks.push(clock.tick);
    match second {
        0 => {}
        1 => control.relative_speed = 0.25,
        2 => {
            control.pause();
            (0..10).for_each(|_| control.step());
        }
        _ => {
            let taken: Vec<u64> = ticks.windows(2).map(|pair| pair[1] - pair[0]).collect();
            println!("ticks per second at full speed, at a quarter, single-stepped: {taken:?}");
            let slowed = taken[1] * 4 <= taken[0] + 4 && taken[2] == 10;
            exit.write(if slowed { AppExit::Success } else { AppExit::error() });
        }
    }
}
