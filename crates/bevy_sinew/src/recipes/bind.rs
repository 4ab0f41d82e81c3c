//! Spawns the distances and the constraints of a blueprint as entities.

use bevy::ecs::relationship::{Relationship, RelationshipHookMode, RelationshipTarget};
use bevy::prelude::*;
use sinew::ConstraintKind;
use sinew::recipes::Blueprint;

use crate::components::{
    AngleConstraint, AnyConstraint, AreaConstraint, BendConstraint, CollinearConstraint,
    ConeConstraint, ConstraintOf, CoplanarConstraint, DistanceConstraint, HingeConstraint,
    PatchConstraint, RigidConstraint, TetrahedronConstraint, VolumeConstraint,
};

/// A relationship whose target is a plain list.
pub(super) trait ListRelationship:
    Relationship<RelationshipTarget: RelationshipTarget<Collection = Vec<Entity>>>
{
}

impl<R: Relationship<RelationshipTarget: RelationshipTarget<Collection = Vec<Entity>>>>
    ListRelationship for R
{
}

/// Spawns the distances of a body, then its other constraints. Stops early if an observer despawns the body.
pub fn bind(
    world: &mut World,
    body: Entity,
    blueprint: &Blueprint,
    particles: &[Entity],
) -> Vec<Entity> {
    // An index without a particle becomes a placeholder: the constraint is then refused at gather, like any other whose particle is gone.
    let particle = |row: u32| particles.get(row as usize).copied().unwrap_or(Entity::PLACEHOLDER);
    let Blueprint { distances, constraints, .. } = blueprint;
    let mut bound = spawn_related::<ConstraintOf>(world, body, distances.len() + constraints.len());
    for (done, distance) in distances.iter().enumerate() {
        let Some(&entity) = bound.get(done) else { return bound };
        let constraint = DistanceConstraint {
            a: particle(distance.a),
            b: particle(distance.b),
            rest: distance.rest,
            softness: distance.softness.into(),
            bound: distance.bound.into(),
        };
        if !insert_related(world, entity, ConstraintOf(body), constraint) {
            bound.truncate(done);
            return bound;
        }
    }
    for (done, constraint) in (distances.len()..).zip(constraints) {
        let Some(&entity) = bound.get(done) else { return bound };
        let particles = constraint.rows.iter().map(|&row| particle(row)).collect();
        if !insert_kind(world, entity, ConstraintOf(body), particles, &constraint.kind) {
            bound.truncate(done);
            return bound;
        }
    }
    bound
}

/// Spawns entities that are in the list of a body (none if the body is gone), but do not have the relationship until they are [inserted](insert_related). Bevy
/// issues a command for each entity that is added to a list, which takes longer than everything else, so they are added all at once. An observer that despawns
/// the body despawns them, too.
pub(super) fn spawn_related<R: ListRelationship>(
    world: &mut World,
    body: Entity,
    count: usize,
) -> Vec<Entity> {
    if count == 0 || world.get_entity(body).is_err() {
        return Vec::new();
    }
    let joined: Vec<Entity> = world.spawn_batch(core::iter::repeat_n((), count)).collect();
    let mut body = world.entity_mut(body);
    if let Some(mut list) = body.get_mut::<R::RelationshipTarget>() {
        list.collection_mut_risky().extend_from_slice(&joined);
    } else {
        body.insert(R::RelationshipTarget::from_collection_risky(joined.clone()));
    }
    joined
}

/// Inserts the components of an entity that was [spawned](spawn_related). Returns whether the body still exists; if it does not, neither does the entity.
pub(super) fn insert_related<R: ListRelationship>(
    world: &mut World,
    entity: Entity,
    of: R,
    rest: impl Bundle,
) -> bool {
    let Some(mode) = mode::<R>(world, of.get()) else { return false };
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.insert_with_relationship_hook_mode((of, rest), mode);
    }
    true
}

/// How an entity is added to a body: without the hook, since it is in the list; unless an observer removed the list. `None` if the body is gone.
fn mode<R: ListRelationship>(world: &World, body: Entity) -> Option<RelationshipHookMode> {
    let body = world.get_entity(body).ok()?;
    Some(match body.contains::<R::RelationshipTarget>() {
        true => RelationshipHookMode::Skip,
        false => RelationshipHookMode::Run,
    })
}

/// Inserts the component of a constraint's kind. A custom constraint, or one with a wrong number of particles, becomes an [`AnyConstraint`].
fn insert_kind(
    world: &mut World,
    entity: Entity,
    of: ConstraintOf,
    particles: Vec<Entity>,
    kind: &ConstraintKind,
) -> bool {
    let three = <[Entity; 3]>::try_from(particles.as_slice());
    let four = <[Entity; 4]>::try_from(particles.as_slice());
    match (kind, three, four) {
        (ConstraintKind::Angle(kind), Ok(p), _) => {
            insert_related(world, entity, of, AngleConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Hinge(kind), _, Ok(p)) => {
            insert_related(world, entity, of, HingeConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Cone(kind), ..) => {
            insert_related(world, entity, of, ConeConstraint::from_kind(particles, kind))
        }
        (ConstraintKind::Area(kind), Ok(p), _) => {
            insert_related(world, entity, of, AreaConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Patch(kind), ..) => {
            insert_related(world, entity, of, PatchConstraint::from_kind(particles, kind))
        }
        (ConstraintKind::Tetrahedron(kind), _, Ok(p)) => {
            insert_related(world, entity, of, TetrahedronConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Volume(kind), ..) => {
            insert_related(world, entity, of, VolumeConstraint::from_kind(particles, kind))
        }
        (ConstraintKind::Bend(kind), _, Ok(p)) => {
            insert_related(world, entity, of, BendConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Coplanar(kind), ..) => {
            let softness = kind.softness.into();
            insert_related(
                world,
                entity,
                of,
                CoplanarConstraint::new(particles).with_softness(softness),
            )
        }
        (ConstraintKind::Collinear(kind), ..) => {
            let softness = kind.softness.into();
            insert_related(
                world,
                entity,
                of,
                CollinearConstraint::new(particles).with_softness(softness),
            )
        }
        (ConstraintKind::Rigid(kind), ..) => {
            insert_related(world, entity, of, RigidConstraint::from_kind(particles, kind))
        }
        (kind, ..) => {
            insert_related(world, entity, of, AnyConstraint::new(particles, kind.clone()))
        }
    }
}

/// Inserts components on an entity, unless an observer has despawned it.
pub(crate) fn attach(world: &mut World, body: Entity, bundle: impl Bundle) {
    if let Ok(mut entity) = world.get_entity_mut(body) {
        entity.insert(bundle);
    }
}
