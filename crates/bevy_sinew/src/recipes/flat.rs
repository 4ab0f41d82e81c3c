//! Bodies of a 2D world: a rigid body that is not flat cannot be built there.

use bevy::prelude::*;
use sinew::recipes::Blueprint;

use crate::components::Flatland;

/// The thickness up to which a body counts as flat, as a fraction of its extent. A box of 1 m by 1 m that is a hundredth as thick lies still in the plane.
const FLATNESS: f32 = 0.02;

/// Whether the world is two-dimensional.
pub(super) fn is_flat_world(world: &mut World) -> bool {
    world.query_filtered::<(), With<Flatland>>().iter(world).next().is_some()
}

/// Whether a body may be in a 2D world: its particles lie in one plane, however that is turned, or no part of it is rigid.
pub(super) fn may_be_flat(blueprint: &Blueprint) -> bool {
    let all = || blueprint.particles.iter().map(|particle| particle.position);
    let (false, Some(first)) = (blueprint.parts.is_empty(), all().next()) else { return true };
    let most = |a: Vec3, b: Vec3| if b.length_squared() > a.length_squared() { b } else { a };
    let longest = all().map(|at| at - first).fold(Vec3::ZERO, most);
    // Perpendicular to the plane through both and the particle that is farthest from their line.
    let normal = all().map(|at| longest.cross(at - first)).fold(Vec3::ZERO, most);
    let height = |at: Vec3| (at - first).dot(normal.normalize_or_zero());
    let (low, high) = all()
        .map(height)
        .fold((0.0_f32, 0.0_f32), |(low, high), height| (low.min(height), high.max(height)));
    high - low <= FLATNESS * longest.length()
}
