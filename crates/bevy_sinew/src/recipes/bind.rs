//! What holds a body together: the distances and the constraints of its blueprint become entities.

use bevy::ecs::relationship::{Relationship, RelationshipHookMode, RelationshipTarget};
use bevy::prelude::*;
use sinew::ConstraintKind;
use sinew::recipes::Blueprint;

use crate::components::{
    AngleConstraint, AnyConstraint, AreaConstraint, BendConstraint, CollinearConstraint,
    ConeConstraint, ConstraintOf, CoplanarConstraint, DistanceConstraint, HingeConstraint,
    PatchConstraint, RigidConstraint, TetrahedronConstraint, VolumeConstraint,
};

/// A relationship whose other side is a plain list.
pub(super) trait Joins:
    Relationship<RelationshipTarget: RelationshipTarget<Collection = Vec<Entity>>>
{
}

impl<R: Relationship<RelationshipTarget: RelationshipTarget<Collection = Vec<Entity>>>> Joins
    for R
{
}

/// Spawns the distances of a body, and then its other constraints. An observer may despawn the body at any of them: then it stops there.
pub(super) fn bind(
    world: &mut World,
    body: Entity,
    blueprint: &Blueprint,
    particles: &[Entity],
) -> Vec<Entity> {
    // A number that no particle has names nobody: the constraint is refused at gather as any other whose particle is gone.
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
        if !fill(world, entity, ConstraintOf(body), constraint) {
            bound.truncate(done);
            return bound;
        }
    }
    for (done, constraint) in (distances.len()..).zip(constraints) {
        let Some(&entity) = bound.get(done) else { return bound };
        let particles = constraint.rows.iter().map(|&row| particle(row)).collect();
        if !fill_kind(world, entity, ConstraintOf(body), particles, &constraint.kind) {
            bound.truncate(done);
            return bound;
        }
    }
    bound
}

/// Spawns entities that are in the list of a body (none if that is gone), though they do not say so themselves until they are [filled](fill): all at
/// once, because Bevy has a command for each that joins, to be carried out alone, which takes longer than everything else. So whoever despawns the
/// body meanwhile takes them along.
pub(super) fn spawn_related<R: Joins>(
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

/// Makes something of an entity that was [spawned](spawn_related). Whether the body is still there: if not, so is the entity not.
pub(super) fn fill<R: Joins>(world: &mut World, entity: Entity, of: R, rest: impl Bundle) -> bool {
    let Some(mode) = mode::<R>(world, of.get()) else { return false };
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.insert_with_relationship_hook_mode((of, rest), mode);
    }
    true
}

/// How an entity is to join a body: silently, for it is in the list; unless an observer took that away. `None` if the body is gone.
fn mode<R: Joins>(world: &World, body: Entity) -> Option<RelationshipHookMode> {
    let body = world.get_entity(body).ok()?;
    Some(match body.contains::<R::RelationshipTarget>() {
        true => RelationshipHookMode::Skip,
        false => RelationshipHookMode::Run,
    })
}

/// The same with a constraint as the component that it is; a game's own stays what it is, and so does one that does not have the particles that it
/// should.
fn fill_kind(
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
            fill(world, entity, of, AngleConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Hinge(kind), _, Ok(p)) => {
            fill(world, entity, of, HingeConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Cone(kind), ..) => {
            fill(world, entity, of, ConeConstraint::from_kind(particles, kind))
        }
        (ConstraintKind::Area(kind), Ok(p), _) => {
            fill(world, entity, of, AreaConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Patch(kind), ..) => {
            fill(world, entity, of, PatchConstraint::from_kind(particles, kind))
        }
        (ConstraintKind::Tetrahedron(kind), _, Ok(p)) => {
            fill(world, entity, of, TetrahedronConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Volume(kind), ..) => {
            fill(world, entity, of, VolumeConstraint::from_kind(particles, kind))
        }
        (ConstraintKind::Bend(kind), _, Ok(p)) => {
            fill(world, entity, of, BendConstraint::from_kind(p, kind))
        }
        (ConstraintKind::Coplanar(kind), ..) => {
            let softness = kind.softness.into();
            fill(world, entity, of, CoplanarConstraint::new(particles).with_softness(softness))
        }
        (ConstraintKind::Collinear(kind), ..) => {
            let softness = kind.softness.into();
            fill(world, entity, of, CollinearConstraint::new(particles).with_softness(softness))
        }
        (ConstraintKind::Rigid(kind), ..) => {
            fill(world, entity, of, RigidConstraint::from_kind(particles, kind))
        }
        (kind, ..) => fill(world, entity, of, AnyConstraint::new(particles, kind.clone())),
    }
}

#[cfg(test)]
mod tests {
    use sinew::constraints::{
        Angle, Area, Bend, Collinear, Cone, Coplanar, Hinge, Patch, Rigid, SizeCorrection,
        Tetrahedron, Volume,
    };
    use sinew::{Constraint, Distance, Equation, ParticleSeed, Points, Softness};

    use super::*;
    use crate::bevy_version::OnAdd;
    use crate::components::{BodyConstraints, ParticleBody};

    #[derive(Debug)]
    struct Own;

    impl Equation for Own {
        fn evaluate(&self, _: &Points, _: &mut [Vec3]) -> f32 {
            0.0
        }
    }

    /// A tetrahedron with one constraint of each kind.
    fn blueprint() -> Blueprint {
        let places = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let [o, x, y, z] = places;
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let soft = Softness::frequency(3.0, 0.5);
        let laws = [
            (3, ConstraintKind::Angle(Angle::between(0.1, 0.2).with_softness(soft))),
            (4, ConstraintKind::Hinge(Hinge::between(0.1, 0.2).with_softness(soft))),
            (4, ConstraintKind::Cone(Cone::about(o, x, y, z, 0.3).unwrap().with_softness(soft))),
            (3, ConstraintKind::Area(Area::of([o, x, y]).with_softness(soft))),
            (
                4,
                ConstraintKind::Patch(
                    Patch::of(faces, &places)
                        .with_correction(SizeCorrection::Scaling)
                        .with_softness(soft),
                ),
            ),
            (4, ConstraintKind::Tetrahedron(Tetrahedron::of(places).with_softness(soft))),
            (
                4,
                ConstraintKind::Volume(
                    Volume::of(faces, &places)
                        .with_correction(SizeCorrection::Scaling)
                        .with_softness(soft),
                ),
            ),
            (4, ConstraintKind::Bend(Bend::of(places).unwrap().with_softness(soft))),
            (4, ConstraintKind::Coplanar(Coplanar::default().with_softness(soft))),
            (3, ConstraintKind::Collinear(Collinear::default().with_softness(soft))),
            (4, ConstraintKind::Rigid(Rigid::of(places).with_softness(soft))),
            (2, ConstraintKind::custom(Own)),
        ];
        Blueprint {
            particles: places.map(ParticleSeed::at).to_vec(),
            distances: vec![Distance::new(0, 1, 1.0)],
            constraints: laws.map(|(count, kind)| Constraint::new(0..count, kind)).to_vec(),
            ..Default::default()
        }
    }

    fn the_law_of<T: crate::ParticleConstraint>(
        world: &mut World,
    ) -> Option<(Vec<Entity>, ConstraintKind)> {
        let found = world.query::<&T>().single(world).ok()?;
        Some((found.particles().to_vec(), found.kind()))
    }

    #[test]
    fn each_law_becomes_its_component_and_says_what_it_said() {
        let mut world = World::new();
        let body = world.spawn(ParticleBody).id();
        let particles: Vec<Entity> = (0..4).map(|_| world.spawn_empty().id()).collect();
        let blueprint = blueprint();
        assert_eq!(blueprint.validate(), Ok(()));
        assert_eq!(bind(&mut world, body, &blueprint, &particles).len(), 13);
        let found = [
            the_law_of::<AngleConstraint>(&mut world),
            the_law_of::<HingeConstraint>(&mut world),
            the_law_of::<ConeConstraint>(&mut world),
            the_law_of::<AreaConstraint>(&mut world),
            the_law_of::<PatchConstraint>(&mut world),
            the_law_of::<TetrahedronConstraint>(&mut world),
            the_law_of::<VolumeConstraint>(&mut world),
            the_law_of::<BendConstraint>(&mut world),
            the_law_of::<CoplanarConstraint>(&mut world),
            the_law_of::<CollinearConstraint>(&mut world),
            the_law_of::<RigidConstraint>(&mut world),
            the_law_of::<AnyConstraint>(&mut world),
        ];
        for (found, meant) in found.into_iter().zip(&blueprint.constraints) {
            let named = particles[..meant.rows.len()].to_vec();
            assert_eq!(found, Some((named, meant.kind.clone())));
        }
        assert_eq!(world.get::<BodyConstraints>(body).unwrap().iter().count(), 13);
        world.despawn(body);
        assert_eq!(world.query::<&ConstraintOf>().iter(&world).count(), 0, "all go with it");
    }

    #[test]
    fn it_stops_where_an_observer_despawned_the_body() {
        let mut world = World::new();
        let body = world.spawn(ParticleBody).id();
        world.add_observer(move |_: OnAdd<AreaConstraint>, mut commands: Commands| {
            commands.entity(body).try_despawn();
        });
        let particles: Vec<Entity> = (0..4).map(|_| world.spawn_empty().id()).collect();
        let bound = bind(&mut world, body, &blueprint(), &particles);
        assert_eq!(bound.len(), 5, "the distance, and up to the area");
        assert_eq!(world.query::<&ConstraintOf>().iter(&world).count(), 0);
    }

    #[test]
    fn a_law_with_the_wrong_number_of_particles_stays_a_law() {
        let mut world = World::new();
        let body = world.spawn(ParticleBody).id();
        let kind = ConstraintKind::Angle(Angle::between(0.0, 1.0));
        let constraints = vec![Constraint::new([0, 9], kind.clone())];
        let blueprint = Blueprint { constraints, ..Default::default() };
        let particle = world.spawn_empty().id();
        bind(&mut world, body, &blueprint, &[particle]);
        let found = the_law_of::<AnyConstraint>(&mut world);
        assert_eq!(found, Some((vec![particle, Entity::PLACEHOLDER], kind)));
    }
}
