//! What lies under a pointer, and by what something is tied there.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::ContactParticipant;
use bevy_sinew::{BodyParts, ParticleOf, QueryFilter, RigidPose};

/// How far tools reach, metres.
const FAR: f32 = 60.0;
/// How far beside the pointer a particle may be where it is over no body, as the tangent of the angle from the camera: as for dragging.
const REACH: f32 = 0.04;
/// How far in front of the camera something is put where the pointer is over nothing, metres.
const IN_THE_AIR: f32 = 5.0;

/// A point of something under a pointer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spot {
    /// What is tied there: a rigid body, a limb, a particle; of what stands the collider.
    pub(super) entity: Entity,
    /// Where on it.
    pub(super) anchor: Anchor,
    /// Where that is now, metres.
    pub(super) point: Vec3,
    /// The body that it is of; `None` of what stands, and of loose particles itself.
    pub(super) body: Option<Entity>,
}

/// Where something new is put: on what the pointer is over, or in the air.
pub(super) fn place(world: &World, ray: Ray3d) -> Vec3 {
    let hit = world.resource::<SinewWorld>().cast_ray(ray, FAR, &QueryFilter::default());
    hit.map_or(ray.origin + ray.direction * IN_THE_AIR, |hit| hit.point)
}

/// How far away what a ray meets is, metres; of what stands, or of everything.
pub(super) fn depth(world: &World, ray: Ray3d, no_bodies: bool) -> f32 {
    let filter = QueryFilter { no_bodies, ..default() };
    let hit = world.resource::<SinewWorld>().cast_ray(ray, FAR, &filter);
    hit.map_or(FAR, |hit| hit.distance)
}

/// What is under a pointer: what its ray meets first, or the particle nearest beside it, such as that of a thin rope.
pub(super) fn spot(world: &World, ray: Ray3d) -> Option<Spot> {
    let sinew = world.resource::<SinewWorld>();
    let hit = sinew.cast_ray(ray, FAR, &QueryFilter::default());
    if let Some(hit) = hit
        && let Some(particle) = hit.particle
    {
        return Some(of_particle(world, particle, hit.point));
    }
    let far = hit.map_or(FAR, |hit| hit.distance);
    if let Some((particle, point)) = beside(sinew, ray, far) {
        return Some(of_particle(world, particle, point));
    }
    let hit = hit?;
    Some(Spot { entity: hit.entity, anchor: Anchor::Whole, point: hit.point, body: None })
}

/// A point of the body that a particle belongs to: of what is rigid the very point, of all else the particle.
fn of_particle(world: &World, particle: Entity, point: Vec3) -> Spot {
    let body = world.get::<ParticleOf>(particle).map_or(particle, |of| of.0);
    let parts = world.get::<BodyParts>(body).into_iter().flat_map(BodyParts::iter).chain([body]);
    let holds = |&part: &Entity| {
        world.get::<RigidPose>(part).is_some_and(|pose| pose.particles.contains(&particle))
    };
    // Of several limbs that share the particle the one whose middle is nearest.
    let off = |part: Entity| {
        let middle = world.get::<Transform>(part).map_or(Vec3::INFINITY, |at| at.translation);
        middle.distance_squared(point)
    };
    let rigid = parts.filter(holds).min_by(|&a, &b| off(a).total_cmp(&off(b)));
    if let Some((part, frame)) = rigid.and_then(|part| Some((part, world.get::<Transform>(part)?)))
    {
        let local = frame.compute_affine().inverse().transform_point3(point);
        return Spot { entity: part, anchor: Anchor::Point(local), point, body: Some(body) };
    }
    let point = world.get::<Particle>(particle).map_or(point, |particle| particle.position);
    Spot { entity: particle, anchor: Anchor::Whole, point, body: Some(body) }
}

/// The particle nearest to a ray as seen from its origin, nearer than `far` metres.
fn beside(sinew: &SinewWorld, ray: Ray3d, far: f32) -> Option<(Entity, Vec3)> {
    let particles = sinew.particles();
    let mut best: Option<(f32, usize)> = None;
    for row in 0..particles.len() {
        let (depth, off) = off_ray(ray, particles.position(row));
        let beside = (off - particles.radius(row)).max(0.0) / depth;
        // A metre in front counts as much as a third of the reach beside.
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

/// How far along a ray a point is, and how far beside it, metres.
pub(super) fn off_ray(ray: Ray3d, point: Vec3) -> (f32, f32) {
    let away = point - ray.origin;
    let depth = away.dot(*ray.direction);
    (depth, (away - *ray.direction * depth).length())
}
