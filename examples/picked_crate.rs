//! A crate is picked with the pointer, dragged up and released. This program plays the pointer; in a game, `DefaultPlugins` and a mouse provide it.

use bevy::camera::NormalizedRenderTarget;
use bevy::picking::backend::ray::{RayId, RayMap};
use bevy::picking::pointer::{Location, PointerAction, PointerButton, PointerId, PointerInput};
use bevy::picking::{InteractionPlugin, PickingPlugin, PickingSystems};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{MouseDrag, MouseDragPlugin, SinewClock};

/// Where the pointer is, in the plane of the crate, metres.
#[derive(Resource, Default)]
struct Aim(Vec2);

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PickingPlugin, InteractionPlugin));
    // A game needs only these to let bodies be dragged.
    app.add_plugins((SinewPlugins, MouseDragPlugin));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1)).init_resource::<Aim>();
    app.world_mut().register_component::<Window>();
    app.add_systems(Startup, setup).add_systems(PostUpdate, play);
    let pointing = point.after(RayMap::repopulate).before(PickingSystems::Backend);
    app.add_systems(PreUpdate, pointing).run()
}

fn setup(mut commands: Commands) {
    commands.spawn(Ground);
    commands.spawn((RigidBox::new(Vec3::ONE).with_mass(20.0), Transform::from_xyz(0.0, 0.5, 0.0)));
    commands.spawn(PointerId::Mouse);
    let eye = Transform::from_xyz(0.0, 1.0, 10.0);
    commands.spawn((Camera::default(), eye, GlobalTransform::from(eye)));
}

/// The ray that a window would cast from the position of the pointer.
fn point(aim: Res<Aim>, cameras: Query<Entity, With<Camera>>, mut rays: ResMut<RayMap>) {
    let ray = Ray3d::new(aim.0.extend(10.0), Dir3::NEG_Z);
    rays.map.extend(cameras.iter().map(|camera| (RayId::new(camera, PointerId::Mouse), ray)));
}

/// Presses on the crate after half a second, moves up by 2 m, releases after three seconds, and checks where the crate ended up.
fn play(
    clock: Res<SinewClock>,
    drag: Res<MouseDrag>,
    crates: Query<&Transform, With<RigidBox>>,
    mut aim: ResMut<Aim>,
    mut pointer: MessageWriter<PointerInput>,
    mut lifted: Local<f32>,
    mut exit: MessageWriter<AppExit>,
) -> Result {
    let target = NormalizedRenderTarget::None { width: 100, height: 100 };
    let location = Location { target, position: Vec2::splat(50.0) };
    let mut input =
        |action| pointer.write(PointerInput::new(PointerId::Mouse, location.clone(), action));
    match clock.tick {
        0..30 => aim.0 = Vec2::new(0.1, 0.6),
        30 => drop(input(PointerAction::Press(PointerButton::Primary))),
        31..150 => aim.0.y = 0.6 + 2.0 * (clock.tick - 30) as f32 / 120.0,
        180 => {
            assert!(drag.grabbed.is_some(), "the crate does not hang on the pointer");
            *lifted = crates.single()?.translation.y;
            input(PointerAction::Release(PointerButton::Primary));
        }
        300.. => {
            let lies = crates.single()?.translation.y;
            println!("the crate was lifted to {:.2} m, and lies at {lies:.2} m", *lifted);
            // The crate hangs by the point on its face that was picked, which is then half a metre above its centre.
            let right = (*lifted - 2.0).abs() < 0.1 && (lies - 0.5).abs() < 0.02;
            exit.write(if right { AppExit::Success } else { AppExit::error() });
        }
        _ => {}
    }
    Ok(())
}
