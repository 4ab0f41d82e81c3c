//! Internal pieces of the plugin, tested from outside: binding a body's constraints, composing frames, and the gap that closes a surface.

use core::f32::consts::FRAC_PI_2;

use bevy::prelude::*;
use bevy_sinew::internals::{bind, compose, gap};
use bevy_sinew::sinew::constraints::{
    Angle, Area, Bend, Collinear, Cone, Coplanar, Hinge, Patch, Rigid, SizeCorrection, Tetrahedron,
    Volume,
};
use bevy_sinew::sinew::recipes::Blueprint;
use bevy_sinew::sinew::{
    Constraint, ConstraintKind, Distance, Equation, ParticleSeed, Points, Softness,
};
use bevy_sinew::{
    AngleConstraint, AnyConstraint, AreaConstraint, BendConstraint, BodyConstraints,
    CollinearConstraint, ConeConstraint, ConstraintOf, CoplanarConstraint, HingeConstraint,
    ParticleBody, ParticleConstraint, PatchConstraint, RigidConstraint, TetrahedronConstraint,
    VolumeConstraint,
};

use crate::bevy_version::OnAdd;

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
    let kinds = [
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
        constraints: kinds.map(|(count, kind)| Constraint::new(0..count, kind)).to_vec(),
        ..Default::default()
    }
}

fn the_only<T: ParticleConstraint>(world: &mut World) -> Option<(Vec<Entity>, ConstraintKind)> {
    let found = world.query::<&T>().single(world).ok()?;
    Some((found.particles().to_vec(), found.kind()))
}

#[test]
fn each_constraint_kind_becomes_a_component_with_the_same_kind() {
    let mut world = World::new();
    let body = world.spawn(ParticleBody).id();
    let particles: Vec<Entity> = (0..4).map(|_| world.spawn_empty().id()).collect();
    let blueprint = blueprint();
    assert_eq!(blueprint.validate(), Ok(()));
    let all = blueprint.distances.len() + blueprint.constraints.len();
    assert_eq!(bind(&mut world, body, &blueprint, &particles).len(), all);
    let found = [
        the_only::<AngleConstraint>(&mut world),
        the_only::<HingeConstraint>(&mut world),
        the_only::<ConeConstraint>(&mut world),
        the_only::<AreaConstraint>(&mut world),
        the_only::<PatchConstraint>(&mut world),
        the_only::<TetrahedronConstraint>(&mut world),
        the_only::<VolumeConstraint>(&mut world),
        the_only::<BendConstraint>(&mut world),
        the_only::<CoplanarConstraint>(&mut world),
        the_only::<CollinearConstraint>(&mut world),
        the_only::<RigidConstraint>(&mut world),
        the_only::<AnyConstraint>(&mut world),
    ];
    for (found, meant) in found.into_iter().zip(&blueprint.constraints) {
        let named = particles[..meant.rows.len()].to_vec();
        assert_eq!(found, Some((named, meant.kind.clone())));
    }
    assert_eq!(world.get::<BodyConstraints>(body).unwrap().iter().count(), all);
    world.despawn(body);
    assert_eq!(world.query::<&ConstraintOf>().iter(&world).count(), 0, "all go with it");
}

#[test]
fn binding_stops_when_an_observer_despawns_the_body() {
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
fn a_constraint_with_the_wrong_number_of_particles_becomes_an_any_constraint() {
    let mut world = World::new();
    let body = world.spawn(ParticleBody).id();
    let kind = ConstraintKind::Angle(Angle::between(0.0, 1.0));
    let constraints = vec![Constraint::new([0, 9], kind.clone())];
    let blueprint = Blueprint { constraints, ..Default::default() };
    let particle = world.spawn_empty().id();
    bind(&mut world, body, &blueprint, &[particle]);
    let found = the_only::<AnyConstraint>(&mut world);
    assert_eq!(found, Some((vec![particle, Entity::PLACEHOLDER], kind)));
}

fn turned(angle: f32) -> Transform {
    Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(Quat::from_rotation_z(angle))
}

#[test]
fn transforms_without_shear_compose_as_in_bevy() {
    let even = turned(0.7).with_scale(Vec3::splat(2.0));
    let long = turned(0.3).with_scale(Vec3::new(1.0, 4.0, 0.5));
    let mirrored = turned(0.3).with_scale(Vec3::new(-1.0, 4.0, 0.5));
    for (outer, inner) in [
        (even, turned(0.4).with_scale(Vec3::new(1.0, 2.0, 3.0))),
        (long, turned(0.0).with_scale(Vec3::new(3.0, 2.0, 1.0))),
        (long, turned(FRAC_PI_2).with_scale(Vec3::new(3.0, 2.0, 1.0))),
        (mirrored, turned(FRAC_PI_2)),
    ] {
        let found = compose(&outer, &inner).unwrap().compute_affine();
        let true_one = outer.compute_affine() * inner.compute_affine();
        assert!(found.abs_diff_eq(true_one, 1e-5), "{outer:?} {inner:?}: {found}");
    }
}

#[test]
fn a_rotation_in_an_unevenly_scaled_parent_does_not_compose() {
    let long = Transform::from_scale(Vec3::new(1.0, 2.0, 1.0));
    assert_eq!(compose(&long, &turned(0.5)), None);
    let flat = Transform::from_scale(Vec3::new(1.0, 0.0, 1.0));
    assert_eq!(compose(&flat, &turned(0.5)), None);
}

#[test]
fn the_gap_of_a_triangle_is_where_its_corners_are_farthest() {
    let triangles: [[[f32; 2]; 3]; 5] = [
        [[0.0, 0.0], [1.0, 0.0], [0.5, 0.866_025_4]],
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        [[0.0, 0.0], [3.0, 0.0], [1.0, 0.4]],
        [[0.0, 0.0], [2.0, 0.1], [2.1, 0.0]],
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]],
    ];
    for corners in triangles {
        let [a, b, c] = corners.map(|[x, y]| Vec3::new(x, y, 0.0));
        let mut far = 0.0_f32;
        for i in 0..=400 {
            for j in 0..=400 - i {
                let (u, v) = (i as f32 / 400.0, j as f32 / 400.0);
                let place = a + (b - a) * u + (c - a) * v;
                far = far
                    .max([a, b, c].map(|p| p.distance(place)).into_iter().fold(f32::MAX, f32::min));
            }
        }
        let found = gap([a, b, c]);
        assert!((found - far).abs() < 5e-3, "{corners:?}: {found}, and by looking {far}");
    }
}
