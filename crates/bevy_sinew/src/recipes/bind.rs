//! What holds a body together: the distances and the constraints of its blueprint become entities.

use bevy::prelude::*;
use sinew::Law;
use sinew::recipes::Blueprint;

use crate::components::{
    AngleConstraint, AreaConstraint, BendConstraint, CollinearConstraint, ConeConstraint,
    ConstraintOf, CoplanarConstraint, DistanceConstraint, HingeConstraint, LawConstraint,
    PatchConstraint, RigidConstraint, TetrahedronConstraint, VolumeConstraint,
};

/// Spawns the distances of a body, and then its other constraints. An observer may despawn the body at any of them: then it stops there.
pub(super) fn bind(
    world: &mut World,
    body: Entity,
    blueprint: &Blueprint,
    particles: &[Entity],
) -> Vec<Entity> {
    // A number that no particle has names nobody: the constraint is refused at gather as any other whose particle is gone.
    let particle = |row: u32| particles.get(row as usize).copied().unwrap_or(Entity::PLACEHOLDER);
    let mut bound = Vec::with_capacity(blueprint.distances.len() + blueprint.constraints.len());
    for distance in &blueprint.distances {
        if world.get_entity(body).is_err() {
            return bound;
        }
        let constraint = DistanceConstraint {
            a: particle(distance.a),
            b: particle(distance.b),
            rest: distance.rest,
            softness: distance.softness.into(),
            bound: distance.bound.into(),
        };
        bound.push(join(world, ConstraintOf(body), |mut entity| _ = entity.insert(constraint)));
    }
    for constraint in &blueprint.constraints {
        if world.get_entity(body).is_err() {
            return bound;
        }
        let particles = constraint.rows.iter().map(|&row| particle(row)).collect();
        let of = ConstraintOf(body);
        bound.push(join(world, of, |entity| insert_law(entity, particles, &constraint.law)));
    }
    bound
}

/// Spawns what belongs to a body: first the relationship and then the rest, so that whoever despawns the body meanwhile takes it along. In one bundle the
/// body would have to be there for longer: Bevy notes who joined it with a command of its own, behind those of observers.
pub(super) fn join(
    world: &mut World,
    of: impl Bundle,
    rest: impl FnOnce(EntityWorldMut),
) -> Entity {
    let joined = world.spawn(of).id();
    if let Ok(entity) = world.get_entity_mut(joined) {
        rest(entity);
    }
    joined
}

/// Inserts a law as the component that it is; a game's own stays what it is, and so does one that does not have the particles that it should.
fn insert_law(mut entity: EntityWorldMut, particles: Vec<Entity>, law: &Law) {
    let three = <[Entity; 3]>::try_from(particles.as_slice());
    let four = <[Entity; 4]>::try_from(particles.as_slice());
    match (law, three, four) {
        (Law::Angle(law), Ok(p), _) => entity.insert(AngleConstraint::from_law(p, law)),
        (Law::Hinge(law), _, Ok(p)) => entity.insert(HingeConstraint::from_law(p, law)),
        (Law::Cone(law), ..) => entity.insert(ConeConstraint::from_law(particles, law)),
        (Law::Area(law), Ok(p), _) => entity.insert(AreaConstraint::from_law(p, law)),
        (Law::Patch(law), ..) => entity.insert(PatchConstraint::from_law(particles, law)),
        (Law::Tetrahedron(law), _, Ok(p)) => entity.insert(TetrahedronConstraint::from_law(p, law)),
        (Law::Volume(law), ..) => entity.insert(VolumeConstraint::from_law(particles, law)),
        (Law::Bend(law), _, Ok(p)) => entity.insert(BendConstraint::from_law(p, law)),
        (Law::Coplanar(law), ..) => {
            let softness = law.softness.into();
            entity.insert(CoplanarConstraint::new(particles).with_softness(softness))
        }
        (Law::Collinear(law), ..) => {
            let softness = law.softness.into();
            entity.insert(CollinearConstraint::new(particles).with_softness(softness))
        }
        (Law::Rigid(law), ..) => entity.insert(RigidConstraint::from_law(particles, law)),
        (law, ..) => entity.insert(LawConstraint::new(particles, law.clone())),
    };
}

#[cfg(test)]
mod tests {
    use sinew::constraints::{
        Angle, Area, Bend, Collinear, Cone, Coplanar, Hinge, Patch, Rigid, Tetrahedron, Volume, Way,
    };
    use sinew::{Constraint, Distance, Equation, ParticleSeed, Points, Softness};

    use super::*;
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
            (3, Law::Angle(Angle::between(0.1, 0.2).with_softness(soft))),
            (4, Law::Hinge(Hinge::between(0.1, 0.2).with_softness(soft))),
            (4, Law::Cone(Cone::about(o, x, y, z, 0.3).unwrap().with_softness(soft))),
            (3, Law::Area(Area::of([o, x, y]).with_softness(soft))),
            (4, Law::Patch(Patch::of(faces, &places).with_way(Way::Scaling).with_softness(soft))),
            (4, Law::Tetrahedron(Tetrahedron::of(places).with_softness(soft))),
            (4, Law::Volume(Volume::of(faces, &places).with_way(Way::Scaling).with_softness(soft))),
            (4, Law::Bend(Bend::of(places).unwrap().with_softness(soft))),
            (4, Law::Coplanar(Coplanar::default().with_softness(soft))),
            (3, Law::Collinear(Collinear::default().with_softness(soft))),
            (4, Law::Rigid(Rigid::of(places).with_softness(soft))),
            (2, Law::custom(Own)),
        ];
        Blueprint {
            particles: places.map(ParticleSeed::at).to_vec(),
            distances: vec![Distance::new(0, 1, 1.0)],
            constraints: laws.map(|(count, law)| Constraint::new(0..count, law)).to_vec(),
            ..Default::default()
        }
    }

    fn the_law_of<T: crate::ParticleConstraint>(world: &mut World) -> Option<(Vec<Entity>, Law)> {
        let found = world.query::<&T>().single(world).ok()?;
        Some((found.particles().to_vec(), found.law()))
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
            the_law_of::<LawConstraint>(&mut world),
        ];
        for (found, meant) in found.into_iter().zip(&blueprint.constraints) {
            let named = particles[..meant.rows.len()].to_vec();
            assert_eq!(found, Some((named, meant.law.clone())));
        }
        assert_eq!(world.get::<BodyConstraints>(body).unwrap().iter().count(), 13);
        world.despawn(body);
        assert_eq!(world.query::<&ConstraintOf>().iter(&world).count(), 0, "all go with it");
    }

    #[test]
    fn it_stops_where_an_observer_despawned_the_body() {
        let mut world = World::new();
        let body = world.spawn(ParticleBody).id();
        world.add_observer(move |_: On<Add, AreaConstraint>, mut commands: Commands| {
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
        let law = Law::Angle(Angle::between(0.0, 1.0));
        let constraints = vec![Constraint::new([0, 9], law.clone())];
        let blueprint = Blueprint { constraints, ..Default::default() };
        let particle = world.spawn_empty().id();
        bind(&mut world, body, &blueprint, &[particle]);
        let found = the_law_of::<LawConstraint>(&mut world);
        assert_eq!(found, Some((vec![particle, Entity::PLACEHOLDER], law)));
    }
}
