//! Save and load: a running scene is saved to a file, loaded into another app, and continues there bit for bit.
//!
//! `cargo run --example save_load` needs no window and exits by itself.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{RegisterState, SinewSnapshot};

/// State of the game itself, on a body: registered state is saved along.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
struct Health(u32);

fn game() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPlugins)).register_state::<Health>();
    // One tick a frame, however long the frame takes.
    let step = core::time::Duration::from_secs(1) / 60;
    app.insert_resource(Time::<Fixed>::from_duration(step))
        .insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(step));
    app.finish();
    app.cleanup();
    // In the first frame no time passes.
    app.update();
    app
}

fn spawn(world: &mut World) {
    world.spawn(Ground);
    world.spawn(Wind { pressure: Vec3::new(3.0, 0.0, 2.0), gusts: 0.8, ..default() });
    for i in 0..5 {
        let place = Transform::from_xyz(0.1 * i as f32, 0.5 + 0.5 * i as f32, 0.0);
        world.spawn((RigidBox::new(Vec3::splat(0.4)), Health(100 - i), place));
    }
    let flag = Cloth::grid(1.5, 1.0, 20, 14).pinned(ClothPins::LeftEdge);
    world.spawn((flag, Transform::from_xyz(2.0, 2.0, 0.0)));
    world.spawn((Ragdoll::default(), Transform::from_xyz(-2.0, 1.5, 0.0)));
}

/// A hash of the whole state: every component and resource that is registered as state.
fn hash(app: &App) -> u64 {
    SinewSnapshot::capture(app.world()).hash()
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let mut old = game();
    spawn(old.world_mut());
    (0..100).for_each(|_| old.update());

    // Save: as text, which is readable, or as bytes, which are small.
    let saved = SinewSnapshot::capture(old.world());
    let (text, bytes) = (saved.to_ron(old.world())?, saved.to_bytes(old.world())?);
    let path = std::env::temp_dir().join(format!("sinew-{}.save", std::process::id()));
    std::fs::write(&path, &bytes)?;
    println!("{saved:?}: {} kB as text, {} kB as bytes", text.len() / 1000, bytes.len() / 1000);

    // Load: a broken file is rejected here, before anything changes.
    let file = std::fs::read(&path)?;
    std::fs::remove_file(&path)?;
    let mut new = game();
    SinewSnapshot::from_bytes(&file, new.world())?.restore(new.world_mut())?;
    assert_eq!(hash(&new), hash(&old), "the loaded state differs from the saved state");
    assert!(SinewSnapshot::from_bytes(&file[..file.len() / 2], new.world()).is_err());

    for _ in 0..300 {
        old.update();
        new.update();
        assert_eq!(hash(&new), hash(&old), "the two simulations diverged");
    }
    let mut boxes = new.world_mut().query::<(&Health, &Transform)>();
    for (health, transform) in boxes.iter(new.world()) {
        println!("{health:?} at {:.3}", transform.translation);
    }
    println!("after 300 more ticks both have the hash {:#018x}", hash(&new));
    Ok(())
}
