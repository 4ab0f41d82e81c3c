//! The README's first program is this example, word for word, and behaves as described.

use bevy::asset::AssetPlugin;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::Refused;

use super::*;

/// The program as it is printed in the README.
fn in_readme() -> &'static str {
    let readme = include_str!("../../README.md");
    let from = readme.find("```rust").expect("the README has a program");
    let block = &readme[from..];
    let block = &block[block.find('\n').expect("it has lines") + 1..];
    block[..block.find("```").expect("it ends")].trim()
}

#[test]
fn the_program_of_the_readme_is_the_one_that_is_compiled_here() {
    let example = include_str!("../minimal.rs");
    let from = example.find("use bevy::prelude").expect("it begins");
    let to = example.find("#[cfg(test)]").expect("it ends");
    assert_eq!(in_readme(), example[from..to].trim());
}

/// The app that `main` builds, without a window.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
    app.init_asset::<Mesh>().init_asset::<StandardMaterial>();
    app.add_plugins(SinewPlugins).add_systems(Startup, setup);
    let step = app.world().resource::<Time<Fixed>>().timestep();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    app.finish();
    app.cleanup();
    app
}

#[test]
fn there_is_a_camera_and_a_light_and_whatever_moves_is_drawn() {
    let mut app = app();
    (0..3).for_each(|_| app.update());
    let world = app.world_mut();
    assert_eq!(world.query::<&Camera3d>().iter(world).count(), 1);
    assert_eq!(world.query::<&DirectionalLight>().iter(world).count(), 1);
    let mut bodies = world.query_filtered::<Has<Mesh3d>, With<bevy_sinew::ParticleBody>>();
    assert!(bodies.iter(world).count() > 1 && bodies.iter(world).all(|drawn| drawn));
}

#[test]
fn the_tower_stands_until_the_ball_meets_it() {
    let mut app = app();
    let crates = |app: &mut App| {
        let world = app.world_mut();
        let mut crates = world.query_filtered::<&Transform, With<RigidBox>>();
        crates.iter(world).map(|at| at.translation).collect::<Vec<_>>()
    };
    app.update();
    let built = crates(&mut app);
    (0..20).for_each(|_| app.update());
    for (was, is) in built.iter().zip(crates(&mut app)) {
        assert!(was.distance(is) < 0.01, "the crate moved before the impact: {was} {is}");
    }
    (0..300).for_each(|_| app.update());
    let fallen = crates(&mut app);
    let moved = built.iter().zip(&fallen).filter(|(was, is)| was.distance(**is) > 0.3).count();
    assert!(moved >= 2, "it is knocked over: {fallen:?}");
    assert!(fallen.iter().all(|at| at.y > 0.25), "and nothing is in the floor: {fallen:?}");
    // No two crates overlap: the balls inscribed in the 0.6 m cubes stay apart, within 3 cm.
    for (i, a) in fallen.iter().enumerate() {
        assert!(fallen[..i].iter().all(|b| a.distance(*b) > 0.57), "{fallen:?}");
    }
    let refused = app.world().resource::<Messages<Refused>>();
    assert!(refused.is_empty(), "an entity was refused");
}
