//! Finds what is under the pointer, and an anchor to tie something there.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::ContactParticipant;
use bevy_sinew::{BodyParts, ParticleOf, QueryFilter, RigidPose};

/// Range of the tools, metres.
const FAR: f32 = 60.0;
/// Largest distance of a particle from the pointer where it is over no body, as the tangent of the angle at the camera: the same as for dragging.
const REACH: f32 = 0.04;
/// Distance in front of the camera at which something is placed if nothing is under the pointer, metres.
const IN_THE_AIR: f32 = 5.0;

/// A point under the pointer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PickedPoint {
    /// The entity to tie to: a rigid body, a limb, a particle, or a static collider.
    pub(super) entity: Entity,
    /// The point on it.
    pub(super) anchor: Anchor,
    /// The point in the world at the time of picking, metres.
    pub(super) point: Vec3,
    /// The body that it belongs to; a loose particle itself; `None` for static geometry.
    pub(super) body: Option<Entity>,
}

/// Where something new is placed: on what is under the pointer, or in the air.
pub(super) fn place(world: &World, ray: Ray3d) -> Vec3 {
    let hit = world.resource::<SinewWorld>().cast_ray(ray, FAR, &QueryFilter::default());
    hit.map_or(ray.origin + ray.direction * IN_THE_AIR, |hit| hit.point)
}

/// Distance to the first hit of a ray, metres; of static geometry only, if `no_bodies`.
pub(super) fn depth(world: &World, ray: Ray3d, no_bodies: bool) -> f32 {
    let filter = QueryFilter { no_bodies, ..default() };
    let hit = world.resource::<SinewWorld>().cast_ray(ray, FAR, &filter);
    hit.map_or(FAR, |hit| hit.distance)
}

/// What is under the pointer: the first hit of its ray, or the particle nearest to it, such as one of a thin rope.
pub(super) fn spot(world: &World, ray: Ray3d) -> Option<PickedPoint> {
    let sinew = world.resource::<SinewWorld>();
    let hit = sinew.cast_ray(ray, FAR, &QueryFilter::default());
    if let Some(hit) = hit
        && let Some(particle) = hit.particle
    {
        return Some(point_on_body_of(world, particle, hit.point));
    }
    let far = hit.map_or(FAR, |hit| hit.distance);
    if let Some((particle, point)) = beside(sinew, ray, far) {
        return Some(point_on_body_of(world, particle, point));
    }
    let hit = hit?;
    Some(PickedPoint { entity: hit.entity, anchor: Anchor::Whole, point: hit.point, body: None })
}

/// A point on the body of a particle: the exact point if it is rigid, otherwise the particle.
fn point_on_body_of(world: &World, particle: Entity, point: Vec3) -> PickedPoint {
    let body = world.get::<ParticleOf>(particle).map_or(particle, |of| of.0);
    let parts = world.get::<BodyParts>(body).into_iter().flat_map(BodyParts::iter).chain([body]);
    let holds = |&part: &Entity| {
        world.get::<RigidPose>(part).is_some_and(|pose| pose.particles.contains(&particle))
    };
    // If several limbs share the particle, the one whose centre is nearest.
    let off = |part: Entity| {
        let middle = world.get::<Transform>(part).map_or(Vec3::INFINITY, |at| at.translation);
        middle.distance_squared(point)
    };
    let rigid = parts.filter(holds).min_by(|&a, &b| off(a).total_cmp(&off(b)));
    if let Some((part, frame)) = rigid.and_then(|part| Some((part, world.get::<Transform>(part)?)))
    {
        let local = frame.compute_affine().inverse().transform_point3(point);
        return PickedPoint { entity: part, anchor: Anchor::Point(local), point, body: Some(body) };
    }
    let point = world.get::<Particle>(particle).map_or(point, |particle| particle.position);
    PickedPoint { entity: particle, anchor: Anchor::Whole, point, body: Some(body) }
}

/// The particle nearest to a ray as seen from its origin, within `far` metres.
fn beside(sinew: &SinewWorld, ray: Ray3d, far: f32) -> Option<(Entity, Vec3)> {
    let particles = sinew.particles();
    let mut best: Option<(f32, usize)> = None;
    for row in 0..particles.len() {
        let (depth, off) = off_ray(ray, particles.position(row));
        let beside = (off - particles.radius(row)).max(0.0) / depth;
        // A metre of depth counts as much as 0.3 of the reach sideways.
        let score = beside + 0.3 * REACH * depth;
        let seen = depth > 0.0 && depth <= far && beside <= REACH;
        if seen && best.is_none_or(|(least, _)| score < least) {
            best = Some((score, row));
        }
    }
    let row = best?.1;
    let entity = sinew.entity_of(ContactParticipant::Particle(row as u32))?;
    Some((entity, particles.position(row)))
}

/// Distance of a point along a ray, and from the ray, metres.
pub(super) fn off_ray(ray: Ray3d, point: Vec3) -> (f32, f32) {
    let away = point - ray.origin;
    let depth = away.dot(*ray.direction);
    (depth, (away - *ray.direction * depth).length())
}
