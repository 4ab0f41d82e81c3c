//! Crates in a river: the light ones float and drift with the current, a heavy one lies on the bed.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Region, SinewClock};

/// A crate and its density, kg/m³.
#[derive(Component)]
struct Crate(f32);

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, finish).run()
}

fn setup(mut commands: Commands) {
    // The river bed, and 2 m of water above it that flows along x between its banks.
    commands.spawn((Ground, Transform::from_xyz(0.0, -2.0, 0.0)));
    let river = Region::boxed(Vec3::new(200.0, 20.0, 6.0));
    commands.spawn((Fluid::flowing(Vec3::X * 1.5), river));
    for (i, density) in [200.0, 400.0, 600.0, 800.0, 2500.0].into_iter().enumerate() {
        let size = Vec3::new(0.6, 0.5, 0.7);
        let wood = RigidBox::new(size).with_mass(density * size.element_product());
        let at = Transform::from_xyz(0.0, 0.5, i as f32 - 2.0)
            .with_rotation(Quat::from_rotation_z(0.3 * i as f32));
        commands.spawn((Crate(density), wood, Floats::OWN, at));
    }
}

fn finish(
    clock: Res<SinewClock>,
    crates: Query<(&Crate, &Transform, &LinearVelocity)>,
    mut exit: MessageWriter<AppExit>,
) {
    if clock.seconds < 12.0 {
        return;
    }
    let mut right = true;
    for (Crate(density), at, velocity) in &crates {
        let (height, speed) = (at.translation.y, velocity.0.x);
        print!("{density} kg/m³: {height:.2} m at {speed:.2} m/s; ");
        // A floating box that lies level is submerged by the share of its density in that of water.
        let floats = (height - 0.5 * (0.5 - density / 1000.0)).abs() < 0.1 && speed > 1.0;
        right &= if *density < 1000.0 { floats } else { height < -1.6 };
    }
    println!("in a river of 1.5 m/s");
    exit.write(if right { AppExit::Success } else { AppExit::error() });
}
