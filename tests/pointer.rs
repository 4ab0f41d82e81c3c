//! A pointer with a ray in the world, but without a window.

use bevy::app::Plugins;
use bevy::camera::NormalizedRenderTarget;
use bevy::picking::backend::ray::{RayId, RayMap};
use bevy::picking::pointer::{Location, PointerAction, PointerId, PointerInput};
use bevy::picking::{InteractionPlugin, PickingPlugin, PickingSystems};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::{Gravity, MouseDragPlugin, SinewPlugins};

/// The ray of the pointer.
#[derive(Resource)]
pub struct Aim(pub Ray3d);

/// An app with the mouse plugin and `plugins`, without gravity, in which a pointer points along -z from 10 m away. Each frame is a tick.
pub fn app<M>(plugins: impl Plugins<M>) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, PickingPlugin, InteractionPlugin));
    app.add_plugins((SinewPlugins, MouseDragPlugin));
    app.add_plugins(plugins);
    let step = app.world().resource::<Time<Fixed>>().timestep();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    app.insert_resource(Gravity(Vec3::ZERO));
    aim(&mut app, 0.0, 0.0);
    let camera = (Camera::default(), GlobalTransform::from(Transform::from_xyz(0.0, 0.0, 10.0)));
    let camera = app.world_mut().spawn(camera).id();
    app.world_mut().spawn(PointerId::Mouse);
    // Pointer events bubble up to the window, but only if the component `Window` is registered.
    app.world_mut().register_component::<Window>();
    let rays = move |aim: Res<Aim>, mut rays: ResMut<RayMap>| {
        rays.map.insert(RayId::new(camera, PointerId::Mouse), aim.0);
    };
    app.add_systems(PreUpdate, rays.after(RayMap::repopulate).before(PickingSystems::Backend));
    app.finish();
    app.cleanup();
    app
}

/// Points along -z through (x, y), metres.
pub fn aim(app: &mut App, x: f32, y: f32) {
    app.insert_resource(Aim(Ray3d::new(Vec3::new(x, y, 10.0), Dir3::NEG_Z)));
}

/// An action of the pointer in the next frame, at a pixel.
pub fn act(app: &mut App, action: PointerAction, at: Vec2) {
    let target = NormalizedRenderTarget::None { width: 100, height: 100 };
    let location = Location { target, position: at };
    app.world_mut().write_message(PointerInput::new(PointerId::Mouse, location, action));
}
