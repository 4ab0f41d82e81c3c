//! Props of scenes: posts, floors, lines.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::scene::InScene;
use crate::shapes::{cylinder, rounded_box};

/// A post or a rail along its y axis, from its radius and its height, metres: a mesh and the collider of the same shape.
pub(crate) fn post(world: &mut World, radius: f32, height: f32) -> (Mesh3d, Collider) {
    (mesh(world, cylinder(radius, height)), Collider::cylinder(radius, height))
}

/// Height of the top of a [`floor`], metres: a little above the ground that a renderer draws.
pub(crate) const FLOOR: f32 = 0.03;

/// A solid floor of the scene's own about the origin, from its lengths along x and z in metres; its top is at [`FLOOR`].
pub(crate) fn floor(world: &mut World, size: Vec2, look: Look) -> Entity {
    let size = Vec3::new(size.x, 0.2, size.y);
    let slab = (mesh(world, rounded_box(size, 0.015, 2)), Collider::cuboid(size));
    let at = Transform::from_xyz(0.0, FLOOR - 0.5 * size.y, 0.0);
    world.spawn((InScene, Name::new("floor"), slab, look, at)).id()
}

/// A line through points, metres: a stick between each two of them. It is only drawn and has no collider.
pub(crate) fn curve(world: &mut World, points: &[Vec3], radius: f32, look: Look) {
    let stick = |pair: &[Vec3]| {
        let (from, to) = (pair[0], pair[1]);
        let turn = Quat::from_rotation_arc(Vec3::Y, (to - from).normalize_or(Vec3::Y));
        let at = Transform::from_translation(0.5 * (from + to)).with_rotation(turn);
        cylinder(radius, from.distance(to)).transformed_by(at)
    };
    let mut sticks = points.windows(2).map(stick);
    let Some(mut line) = sticks.next() else { return };
    for next in sticks {
        // All sticks have the same attributes, so merging cannot fail.
        line.merge(&next).ok();
    }
    let line = mesh(world, line);
    world.spawn((InScene, line, look, Transform::default()));
}

/// Adds a mesh to the app's assets.
pub(crate) fn mesh(world: &mut World, mesh: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh))
}
