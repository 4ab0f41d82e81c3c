//! The cut tool: removes distance constraints and springs near the pointer, except those that make a body rigid, and updates the meshes of cloth and ropes.

use std::collections::{BTreeMap, BTreeSet};

use bevy::mesh::Indices;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyParts, ConstraintOf, CreationOrder, MeshFollow, RigidPose, TubeMesh, WindSurface,
};
use sinew_scenes::{InScene, Skin};

use super::aim;

/// Half the width of the knife, metres, and its increase for each metre of distance.
const KNIFE_HALF_WIDTH: f32 = 0.016;
const KNIFE_SPREAD: f32 = 0.002;
/// How far behind the first hit it still cuts, metres.
const CUT_DEPTH: f32 = 0.12;

/// Cuts the rods and springs near a ray; returns how many.
pub(super) fn cut(world: &mut World, ray: Ray3d) -> usize {
    let far = aim::depth(world, ray, false) + CUT_DEPTH;
    let particles = world.query::<&Particle>();
    let mut ties = world.query::<(
        Entity,
        Option<&DistanceConstraint>,
        Option<&Spring>,
        Option<&ConstraintOf>,
        &CreationOrder,
    )>();
    let mut found: Vec<(CreationOrder, Entity, [Entity; 2], Option<Entity>)> = Vec::new();
    for (tie, rod, spring, of, order) in ties.iter(world) {
        let ends = match (rod, spring) {
            (Some(rod), _) => [rod.a, rod.b],
            (_, Some(spring)) => [spring.a, spring.b],
            _ => continue,
        };
        let body = of.map(|of| of.0);
        let is_rigid = |body: Entity| {
            world.get::<RigidPose>(body).is_some() || world.get::<BodyParts>(body).is_some()
        };
        let [Ok(a), Ok(b)] = ends.map(|end| particles.get_manual(world, end)) else { continue };
        let (depth, off) = crossing(ray, a.position, b.position);
        let near = depth > 0.0 && depth < far && off < KNIFE_HALF_WIDTH + KNIFE_SPREAD * depth;
        if near && !body.is_some_and(is_rigid) {
            found.push((*order, tie, ends, body));
        }
    }
    found.sort_unstable_by_key(|&(order, tie, ..)| (order, tie));
    let mut bodies: BTreeMap<Entity, Vec<[Entity; 2]>> = BTreeMap::new();
    for &(_, tie, ends, body) in &found {
        world.despawn(tie);
        if let Some(body) = body {
            bodies.entry(body).or_default().push(ends);
        }
    }
    for (body, gone) in bodies {
        cut_surface(world, body, &gone);
        split_tube(world, body, &gone);
    }
    found.len()
}

/// Where a ray is nearest to the segment between two points: the distance along the ray, and between the two there, metres.
fn crossing(ray: Ray3d, a: Vec3, b: Vec3) -> (f32, f32) {
    // Projection of a point onto the plane across the ray, relative to the ray.
    let flat = |point: Vec3| {
        let away = point - ray.origin;
        away - *ray.direction * away.dot(*ray.direction)
    };
    let (from, along) = (flat(a), flat(b) - flat(a));
    let share = -from.dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    aim::off_ray(ray, a.lerp(b, share.clamp(0.0, 1.0)))
}

/// Removes the triangles that contain a cut thread: they are no longer drawn, and bodies pass through.
fn cut_surface(world: &mut World, body: Entity, gone: &[[Entity; 2]]) {
    let Some(surface) = world.get::<WindSurface>(body) else { return };
    let sorted = |[a, b]: [Entity; 2]| [a.min(b), a.max(b)];
    let gone: BTreeSet<[Entity; 2]> = gone.iter().copied().map(sorted).collect();
    let is_torn = |&[a, b, c]: &[Entity; 3]| {
        [[a, b], [b, c], [c, a]].into_iter().any(|edge| gone.contains(&sorted(edge)))
    };
    if !surface.triangles.iter().any(is_torn) {
        return;
    }
    let left = surface.triangles.iter().copied().filter(|triangle| !is_torn(triangle)).collect();
    if let Some(mut surface) = world.get_mut::<WindSurface>(body) {
        surface.triangles = left;
    }
    let follow = world.get::<MeshFollow>(body).map(|follow| follow.vertices.clone());
    let mesh = world.get::<Mesh3d>(body).map(|mesh| mesh.0.clone());
    let (Some(vertices), Some(mesh)) = (follow, mesh) else { return };
    let Some(mut meshes) = world.get_resource_mut::<Assets<Mesh>>() else { return };
    let Some(mut mesh) = meshes.get_mut(&mesh) else { return };
    if let Ok(Indices::U32(list)) = mesh.try_indices_mut() {
        let particle = |i: &u32| vertices.get(*i as usize).copied().unwrap_or(Entity::PLACEHOLDER);
        let left = list.chunks_exact(3).filter(|t| !is_torn(&[0, 1, 2].map(|k| particle(&t[k]))));
        *list = left.flatten().copied().collect();
    }
}

/// Splits the tube mesh of a rope: each further piece is drawn by an entity of its own. A rod of one segment is despawned.
fn split_tube(world: &mut World, body: Entity, gone: &[[Entity; 2]]) {
    let mut tubes = world.query::<(Entity, &TubeMesh)>();
    // Pieces of a rope that was cut before are entities of their own.
    let drawn: Vec<(Entity, TubeMesh)> =
        tubes.iter(world).map(|(entity, tube)| (entity, tube.clone())).collect();
    let is_cut = |a: Entity, b: Entity| gone.contains(&[a, b]) || gone.contains(&[b, a]);
    for (entity, tube) in drawn {
        let pieces: Vec<&[Entity]> = tube.particles.chunk_by(|&a, &b| !is_cut(a, b)).collect();
        if pieces.len() < 2 {
            continue;
        }
        if entity == body && tube.particles.len() == 2 {
            world.despawn(body);
            return;
        }
        let skin = world.get::<Skin>(entity).cloned().unwrap_or_default();
        for piece in &pieces[1..] {
            let tube = TubeMesh { particles: piece.to_vec(), ..tube.clone() };
            let order = CreationOrder::default();
            world.spawn((InScene, Name::new("piece"), order, tube, skin.clone(), Interpolate));
        }
        let first = pieces[0].to_vec();
        if let Some(mut tube) = world.get_mut::<TubeMesh>(entity) {
            tube.particles = first;
        }
    }
}
