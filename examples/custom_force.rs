//! A custom force: rockets that push along their own axis, as a system that runs between the phases of a substep.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ParticleRow, PhaseSystems, RigidPose, SinewClock, SubstepSchedule};

/// A thrust along the body's own y axis, N.
#[derive(Component)]
struct Rocket(f32);

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.insert_resource(AirDrag(0.0));
    // In every substep, beside gravity and springs. Forces add up, so their order does not matter.
    app.add_systems(SubstepSchedule, thrust.in_set(PhaseSystems::AccumulateForces));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, finish).run()
}

fn setup(mut commands: Commands) {
    for (i, thrust) in [0.0, 10.0, 20.0].into_iter().enumerate() {
        let hull = RigidBox::new(Vec3::new(0.2, 1.0, 0.2)).with_mass(1.0);
        commands.spawn((Rocket(thrust), hull, Transform::from_xyz(2.0 * i as f32, 0.0, 0.0)));
    }
}

/// Distributes the thrust over the particles of each rocket, along its axis in this substep.
fn thrust(
    mut world: ResMut<SinewWorld>,
    rockets: Query<(&Rocket, &RigidPose)>,
    rows: Query<&ParticleRow>,
) {
    for (Rocket(thrust), pose) in &rockets {
        let rows: Vec<usize> =
            pose.particles.iter().filter_map(|&p| rows.get(p).ok()?.get()).collect();
        let particles = world.particles();
        let tops = pose.rest.iter().zip(&rows).map(|(rest, &row)| particles.position(row) * rest.y);
        let axis = tops.sum::<Vec3>().normalize_or_zero();
        for &row in &rows {
            world.particles_mut().add_force(row, axis * *thrust / rows.len() as f32);
        }
    }
}

fn finish(
    clock: Res<SinewClock>,
    rockets: Query<(&Rocket, &Transform)>,
    mut exit: MessageWriter<AppExit>,
) {
    if clock.seconds < 2.0 {
        return;
    }
    let mut right = true;
    for (Rocket(thrust), at) in &rockets {
        let expected = 0.5 * (thrust - 9.81) * (clock.seconds * clock.seconds) as f32;
        print!("{thrust} N: {:.2} m; ", at.translation.y);
        right &= (at.translation.y - expected).abs() < 0.05;
    }
    println!("after {:.2} s", clock.seconds);
    exit.write(if right { AppExit::Success } else { AppExit::error() });
}
