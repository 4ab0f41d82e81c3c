//! The whole state is captured and restored, in place and into a fresh app, recipes included: everything that a scene can contain goes on bit for bit.

use core::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::{ConstraintKind, Equation, Points};
use bevy_sinew::{
    Articulated, ParticleConstraint, Region, RegisterParticleConstraint, Representation,
};
use bevy_sinew::{
    Attractor, BodyConstraints, Bone, BoneJoint, Charge, CreationOrder, RegisterState,
    RestoreFault, RigidIntegrator, RigidParticles, SinewClock, SinewSnapshot,
};

use crate::support::{TICK, app, bare_app, busy_scene, forget, hash, heard, particles_of, tick};

/// A constraint of the game's own: keeps the second particle on a sphere about the first.
#[derive(Component, Reflect, Clone, Debug)]
struct OnBall {
    #[entities]
    particles: [Entity; 2],
    radius: f32,
}

impl ParticleConstraint for OnBall {
    fn particles(&self) -> &[Entity] {
        &self.particles
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::custom(Ball(self.radius))
    }
}

#[derive(Debug)]
struct Ball(f32);

impl Equation for Ball {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let apart = points.at(1) - points.at(0);
        gradients[1] = apart.normalize_or(Vec3::Y);
        gradients[0] = -gradients[1];
        apart.length() - self.0
    }
}

/// A pin or a platform that the game moves, by the clock of the simulation, around this place.
#[derive(Component, Reflect, Clone, Debug)]
struct Driven(Vec3);

fn drive(
    clock: Res<SinewClock>,
    mut pins: Query<(&Driven, &mut Pinned)>,
    mut platforms: Query<(&Driven, &mut Transform), Without<Pinned>>,
) {
    let turn = Quat::from_rotation_y(clock.tick as f32 * 0.02) * Vec3::X * 0.4;
    for (driven, mut pin) in &mut pins {
        pin.target = Some(driven.0 + turn);
    }
    for (driven, mut transform) in &mut platforms {
        transform.translation = driven.0 + turn;
    }
}

/// An app in which these components are registered.
pub(crate) fn game() -> App {
    let mut app = app();
    app.register_particle_constraint::<OnBall>()
        .register_state::<OnBall>()
        .register_state::<Driven>()
        .add_systems(FixedUpdate, drive);
    app
}

fn floor(world: &mut World) {
    world.spawn((Collider::plane(), SurfaceMaterial::new(0.6).with_restitution(0.2)));
}

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

fn cloth_in_gusts(world: &mut World) {
    world.spawn(Wind { pressure: Vec3::new(5.0, 0.0, 3.0), gusts: 0.8, ..default() });
    world.spawn((Cloth::grid(1.0, 1.0, 9, 8).pinned(ClothPins::TopCorners), at(0.0, 2.0, 0.0)));
}

fn rope_on_a_platform(world: &mut World) {
    floor(world);
    let platform =
        world.spawn((Driven(Vec3::Y * 2.0), at(0.0, 2.0, 0.0), Name::new("platform"))).id();
    let hook = world.spawn((at(0.0, -0.2, 0.0), ChildOf(platform))).id();
    let first = world.spawn((Particle::at(Vec3::Y * 2.0), Radius(0.03))).id();
    world.entity_mut(first).insert(PinnedTo { entity: hook, offset: Vec3::X * 0.1 });
    let mut last = first;
    for i in 1..8 {
        let next = Particle::at(Vec3::new(0.0, 2.0 - 0.3 * i as f32, 0.0));
        let next = world.spawn((next, Radius(0.03), Mass(0.1))).id();
        world.spawn(DistanceConstraint::new(last, next, 0.3));
        last = next;
    }
    let rope = Rope { segments: 8, slack: 0.3, pin_end: true, to: Vec3::X, ..default() };
    world.spawn((rope, at(1.0, 1.0, 0.0)));
    // A crate that rides on the platform as its child.
    world.spawn((RigidBox::new(Vec3::splat(0.2)), at(0.0, 1.0, 0.0), ChildOf(platform)));
}

fn heap(world: &mut World) {
    floor(world);
    for i in 0..4 {
        let place = at(0.05 * i as f32, 0.3 + 0.4 * i as f32, 0.0);
        let place = place.with_rotation(Quat::from_rotation_z(0.1 * i as f32));
        world.spawn((RigidBox::new(Vec3::new(0.4, 0.3, 0.5)), ContactEvents::default(), place));
    }
    world.spawn((Ragdoll::default(), at(1.5, 1.2, 0.0)));
}

fn jelly(world: &mut World) {
    floor(world);
    world.spawn((SoftBody::cuboid(Vec3::splat(0.5), UVec3::splat(2)), at(0.0, 0.6, 0.0)));
    world.spawn((RigidBox::new(Vec3::splat(0.3)), at(0.1, 1.2, 0.0)));
}

fn rigid(world: &mut World) {
    floor(world);
    let integrators = [RigidIntegrator::Euler, RigidIntegrator::Leapfrog, RigidIntegrator::Verlet];
    for (i, integrator) in integrators.into_iter().enumerate() {
        let body = RigidBox { particles: bevy_sinew::BoxParticles::Equimomental, ..default() };
        let spin = AngularVelocity(Vec3::new(1.0, 7.0, 0.3));
        let place = at(2.0 * i as f32, 3.0, 0.0);
        world.spawn((body, Representation::Rigid(integrator), spin, place));
    }
}

fn own_constraints(world: &mut World) {
    let centre = world.spawn((Particle::at(Vec3::Y), Pinned::HERE, Driven(Vec3::Y))).id();
    for i in 0..3 {
        let place = Vec3::new(1.0, 1.0 + 0.1 * i as f32, 0.2 * i as f32);
        let bead = world.spawn((Particle::at(place).with_velocity(Vec3::Z), Mass(0.3))).id();
        world.spawn(OnBall { particles: [centre, bead], radius: 1.0 + 0.1 * i as f32 });
    }
}

fn sleepers(world: &mut World) {
    floor(world);
    for i in 0..3 {
        let place = at(2.0 * i as f32, 0.16 + 0.2 * i as f32, 0.0);
        world.spawn((RigidBox::new(Vec3::splat(0.3)), Sleep::default(), place));
    }
    // A falling box that wakes one of them later.
    world.spawn((RigidBox::new(Vec3::splat(0.3)), Sleep::default(), at(0.1, 14.0, 0.0)));
}

fn torn_cloth(world: &mut World) {
    let cloth = Cloth::grid(1.0, 1.0, 10, 10).pinned(ClothPins::TopEdge);
    world.spawn((cloth, Torn, at(0.0, 2.0, 0.0)));
}

/// Marks a cloth that is torn before it is captured.
#[derive(Component)]
struct Torn;

fn driven_pins(world: &mut World) {
    let mut last: Option<Entity> = None;
    for i in 0..9 {
        let place = Vec3::new(0.2 * i as f32, 1.0, 0.0);
        let mut bead = world.spawn((Particle::at(place), Mass(0.2), Charge(1e-6)));
        if i == 0 || i == 8 {
            bead.insert((Pinned::HERE, Driven(place)));
        }
        let bead = bead.id();
        if let Some(last) = last {
            world.spawn(Spring::new(last, bead, 0.2, 60.0).with_damping(0.1));
        }
        last = Some(bead);
    }
}

fn odd_shapes(world: &mut World) {
    let heights = [0.0, 0.1, 0.0, 0.2, 0.0, 0.1, 0.0, 0.1, 0.3];
    world.spawn(Collider::height_field(3, 3, &heights, Vec3::new(6.0, 1.0, 6.0)).unwrap());
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(0.3, 0.8, 0.3)];
    let wedge = Collider::mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap();
    world.spawn((wedge, at(0.0, 0.4, 0.0)));
    let points = [0, 1, 2, 3, 4, 5].map(|i: u32| {
        let sign = if i.is_multiple_of(2) { 0.3 } else { -0.3 };
        Vec3::from_array([0, 1, 2].map(|axis| if i / 2 == axis { sign } else { 0.0 }))
    });
    let gem = RigidMesh::mass(2.0).shaped(RigidShape::Points(points.to_vec()));
    world.spawn((gem, at(0.4, 2.0, 0.2)));
    let barrel = RigidShape::Cylinder { radius: 0.2, height: 0.5 };
    let barrel =
        RigidMesh { particles: RigidParticles::Four, ..RigidMesh::mass(1.0).shaped(barrel) };
    world.spawn((barrel, Floats::boxed(Vec3::new(0.4, 0.5, 0.4)), at(-0.8, 1.5, 0.0)));
    world.spawn((Fluid::default(), Region::boxed(Vec3::new(2.0, 1.0, 2.0)), at(-1.0, 0.3, 0.0)));
    let post = Bone { pinned: true, ..Bone::new("post", Vec3::Y * 2.0, Vec3::Y) };
    let door = Bone::new("door", Vec3::Y * 2.0, Vec3::new(1.0, 2.0, 0.0))
        .on(0, BoneJoint::Hinge { axis: Vec3::Y, min: 0.0, max: 1.5 });
    world.spawn((Articulated::new([post, door]), at(3.0, 0.0, 0.0)));
    world.spawn((Attractor::default(), at(0.0, 5.0, 9.0)));
}

/// Scenes, and how many ticks pass before they are captured.
pub(crate) const SCENES: [(&str, fn(&mut World), u64); 11] = [
    ("cloth in gusts", cloth_in_gusts, 40),
    ("a rope on a platform", rope_on_a_platform, 40),
    ("a heap", heap, 70),
    ("a jelly", jelly, 40),
    ("rigid bodies", rigid, 30),
    ("own constraints", own_constraints, 30),
    ("sleepers", sleepers, 90),
    ("torn cloth", torn_cloth, 40),
    ("driven pins", driven_pins, 30),
    ("odd shapes", odd_shapes, 50),
    ("not built yet", heap, 0),
];

/// A game with a scene, in the state in which it is captured.
pub(crate) fn played(scene: fn(&mut World), ticks: u64) -> App {
    let mut app = game();
    scene(app.world_mut());
    tick(&mut app, ticks);
    let world = app.world_mut();
    let mut torn = world.query_filtered::<&BodyConstraints, With<Torn>>();
    let ties = torn.iter(world).next().map(|ties| ties.iter().collect::<Vec<Entity>>());
    if let Some(ties) = ties {
        ties.into_iter().step_by(9).for_each(|tie| _ = world.despawn(tie));
        tick(&mut app, 20);
    }
    app
}

/// The hash of the whole state.
pub(crate) fn whole(app: &App) -> u64 {
    SinewSnapshot::capture(app.world()).hash()
}

/// The hash after each of the next ticks.
pub(crate) fn future(app: &mut App, ticks: u64) -> Vec<u64> {
    let after = |_| {
        tick(app, 1);
        whole(app)
    };
    (0..ticks).map(after).collect()
}

#[test]
fn every_scene_goes_on_as_it_did_in_place_and_in_a_fresh_app() {
    for (name, scene, ticks) in SCENES {
        let mut old = played(scene, ticks);
        let saved = SinewSnapshot::capture(old.world());
        assert_eq!(saved.hash(), whole(&old), "{name}: capturing changes nothing");
        let expected = future(&mut old, 120);
        assert!(expected.iter().all(|&hash| hash != saved.hash()), "{name}: nothing happens");

        saved.restore(old.world_mut()).unwrap();
        assert_eq!(whole(&old), saved.hash(), "{name}: put back in place");
        assert_eq!(future(&mut old, 120), expected, "{name}: in place");

        let mut new = game();
        // Other things were here before, so that ids and the order of archetypes differ; and a body is simulated that the restore has to remove.
        new.world_mut().spawn_batch((0..50).map(|i| (Name::new(format!("{i}")), Driven(Vec3::X))));
        new.world_mut().spawn((Cloth::grid(0.3, 0.3, 3, 3), at(9.0, 9.0, 9.0)));
        tick(&mut new, 3);
        saved.restore(new.world_mut()).unwrap();
        assert_eq!(whole(&new), saved.hash(), "{name}: put into a fresh app");
        assert_eq!(future(&mut new, 120), expected, "{name}: in a fresh app");
        assert_eq!(heard(&new), [], "{name}");
        assert_eq!(heard(&old), [], "{name}");
    }
}

/// Regressions: the pins of a door on a post counted as awake while the door slept on, so the door was reported awake; and once any body slept, the step itself
/// woke rigid bodies, so they never slept. Neither happened in the first tick after a restore.
#[test]
fn every_scene_may_be_restored_to_any_of_its_ticks() {
    for (name, scene, ticks) in SCENES {
        let (mut old, mut other) = (played(scene, ticks), played(scene, 1));
        for number in 0..150 {
            let saved = SinewSnapshot::capture(old.world());
            saved.restore(other.world_mut()).unwrap();
            tick(&mut old, 1);
            tick(&mut other, 1);
            assert_eq!(whole(&other), whole(&old), "{name}: {number} ticks later");
        }
    }
}

#[test]
fn restoring_in_place_undoes_spawns_and_despawns() {
    for (name, scene, ticks) in SCENES {
        let mut app = played(scene, ticks);
        let saved = SinewSnapshot::capture(app.world());
        let expected = future(&mut app, 60);

        // Every second entity of the simulation is despawned, and others are spawned.
        let world = app.world_mut();
        let all: Vec<Entity> =
            world.query_filtered::<Entity, With<CreationOrder>>().iter(world).collect();
        for entity in all.into_iter().step_by(2) {
            world.try_despawn(entity).ok();
        }
        let late = world.spawn((RigidBox::default(), at(0.0, 4.0, 0.0))).id();
        world.insert_resource(Gravity(Vec3::X));
        tick(&mut app, 10);
        forget(&mut app);

        let map = saved.restore(app.world_mut()).unwrap();
        assert!(app.world().get_entity(late).is_err(), "{name}: the new body is gone");
        assert_eq!(map.len(), saved.entities().len(), "{name}");
        assert_eq!(whole(&app), saved.hash(), "{name}: put back");
        assert_eq!(future(&mut app, 60), expected, "{name}");
        assert_eq!(heard(&app), [], "{name}");
    }
}

#[test]
fn recipes_restored_into_a_fresh_app_build_nothing_anew_and_go_on() {
    let mut old = app();
    let bodies = busy_scene(&mut old);
    tick(&mut old, 100);
    let saved = SinewSnapshot::capture(old.world());
    let counts: Vec<usize> = bodies.iter().map(|&body| particles_of(&old, body).len()).collect();
    let mut new = app();
    let map = saved.restore(new.world_mut()).unwrap();
    let restored: Vec<_> = bodies.iter().map(|body| particles_of(&new, map[body])).collect();
    for _ in 0..100 {
        tick(&mut old, 1);
        tick(&mut new, 1);
        assert_eq!(hash(&mut old), hash(&mut new));
    }
    let after: Vec<_> = bodies.iter().map(|body| particles_of(&new, map[body])).collect();
    assert_eq!(after, restored, "the same particles, not new ones");
    assert_eq!(after.iter().map(Vec::len).collect::<Vec<_>>(), counts);
    // The recipes are restored and active: a changed one builds its body anew.
    new.world_mut().get_mut::<Rope>(map[&bodies[1]]).unwrap().segments = 7;
    tick(&mut new, 1);
    assert_eq!(particles_of(&new, map[&bodies[1]]).len(), 8);
}

#[test]
fn a_body_from_a_mesh_goes_on_in_an_app_that_has_another_mesh_or_none() {
    let mut old = app();
    let mesh = old
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .add(Plane3d::default().mesh().subdivisions(4));
    let body = (Cloth::from_mesh().pinned(ClothPins::TopEdge), Mesh3d(mesh), at(0.0, 2.0, 0.0));
    let body = old.world_mut().spawn(body).id();
    tick(&mut old, 20);
    let saved = SinewSnapshot::capture(old.world());
    let expected = future(&mut old, 60);
    let mut bare = bare_app();
    saved.restore(bare.world_mut()).unwrap();
    assert_eq!(future(&mut bare, 60), expected, "without meshes");
    assert_eq!(heard(&bare), []);
    let mut new = app();
    let map = saved.restore(new.world_mut()).unwrap();
    let mesh = new
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .add(Plane3d::default().mesh().subdivisions(4));
    new.world_mut().entity_mut(map[&body]).insert(Mesh3d(mesh));
    assert_eq!(future(&mut new, 60), expected, "with a mesh of its own");
    assert_eq!(heard(&new), []);
}

#[test]
fn what_is_not_registered_is_refused_and_nothing_changes() {
    let mut old = played(own_constraints, 10);
    let saved = SinewSnapshot::capture(old.world());
    let mut strange = app();
    busy_scene(&mut strange);
    tick(&mut strange, 5);
    let before = whole(&strange);
    let fault = saved.restore(strange.world_mut()).unwrap_err();
    assert!(
        matches!(&fault, RestoreFault::Unregistered(name) if name.contains("OnBall") || name.contains("Driven")),
        "{fault}"
    );
    assert_eq!(whole(&strange), before);
    let mut world = World::new();
    assert_eq!(saved.restore(&mut world).unwrap_err(), RestoreFault::NoPlugin);
    assert!(SinewSnapshot::capture(&world).entities().is_empty());
    tick(&mut old, 1);
}

#[test]
fn the_hash_depends_on_every_bit_of_the_state() {
    type Change = fn(&mut World, Entity);
    let changes: [(&str, Change); 9] = [
        ("a place", |w, b| w.get_mut::<Particle>(b).unwrap().position.x = 0.1_f32.next_up()),
        ("a sign", |w, b| w.get_mut::<Particle>(b).unwrap().remainder.z = -0.0),
        ("a mass", |w, b| w.get_mut::<Mass>(b).unwrap().0 = 1.0_f32.next_down()),
        ("a pin", |w, b| _ = w.entity_mut(b).insert(Pinned::HERE)),
        ("the clock", |w, _| w.resource_mut::<SinewClock>().seconds = f64::MIN_POSITIVE),
        ("a setting", |w, _| w.resource_mut::<SolverConfig>().substeps += 1),
        ("one more", |w, _| _ = w.spawn(Particle::at(Vec3::ZERO))),
        ("one less", |w, b| _ = w.despawn(b)),
        ("a name in a spring", |w, b| {
            let other = w.spawn_empty().id();
            let mut springs = w.query::<&mut Spring>();
            springs
                .iter_mut(w)
                .for_each(|mut spring| spring.b = if spring.b == b { other } else { spring.b });
        }),
    ];
    let set = || {
        let mut app = app();
        let world = app.world_mut();
        let beads = [0.1, 0.7].map(|x| world.spawn(Particle::at(Vec3::X * x)).id());
        world.spawn(Spring::new(beads[1], beads[0], 0.5, 3.0));
        (app, beads[0])
    };
    let (first, _) = set();
    for (name, change) in changes {
        let (mut app, bead) = set();
        assert_eq!(whole(&app), whole(&first), "two of a kind");
        change(app.world_mut(), bead);
        assert_ne!(whole(&app), whole(&first), "{name}");
    }
}

/// Every contact event: whether it started, and its entity.
#[derive(Resource, Default)]
struct ContactLog(Vec<(bool, Entity)>);

#[test]
fn a_restore_reports_neither_lasting_contacts_nor_those_of_the_undone_future() {
    let mut app = app();
    app.init_resource::<ContactLog>()
        .add_observer(|start: On<bevy_sinew::ContactStarted>, mut log: ResMut<ContactLog>| {
            log.0.push((true, start.entity));
        })
        .add_observer(|end: On<bevy_sinew::ContactEnded>, mut log: ResMut<ContactLog>| {
            log.0.push((false, end.entity));
        });
    floor(app.world_mut());
    let lying = (RigidBox::new(Vec3::splat(0.3)), ContactEvents::default(), at(0.0, 0.15, 0.0));
    let lying = app.world_mut().spawn(lying).id();
    tick(&mut app, 30);
    assert_eq!(app.world().resource::<ContactLog>().0, [(true, lying)]);
    let saved = SinewSnapshot::capture(app.world());
    let late = (RigidBox::new(Vec3::splat(0.3)), ContactEvents::default(), at(3.0, 0.15, 0.0));
    app.world_mut().spawn(late);
    app.world_mut().entity_mut(lying).insert(LinearVelocity(Vec3::Y * 5.0));
    tick(&mut app, 20);
    let count = app.world().resource::<ContactLog>().0.len();
    assert_eq!(count, 3, "one came down, one flew off");
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(
        app.world().resource::<ContactLog>().0.len(),
        count,
        "an undone contact does not end"
    );
    tick(&mut app, 10);
    assert_eq!(
        app.world().resource::<ContactLog>().0.len(),
        count,
        "a lasting contact does not begin"
    );
}

#[test]
fn interpolation_between_ticks_is_not_state() {
    let run = |eased: bool| {
        let mut app = app();
        // Three frames in every two ticks.
        app.insert_resource(TimeUpdateStrategy::ManualDuration(
            TICK * 2 / 3 + Duration::from_nanos(1),
        ));
        let body = (RigidBox::default(), AngularVelocity(Vec3::Y * 3.0), at(0.0, 5.0, 0.0));
        let body = app.world_mut().spawn(body).id();
        if eased {
            app.world_mut().entity_mut(body).insert(Interpolate);
        }
        (0..40).for_each(|_| app.update());
        app
    };
    let (mut plain, mut eased) = (run(false), run(true));
    assert_eq!(hash(&mut plain), hash(&mut eased), "easing changes nothing");
    let drawn = |app: &mut App| {
        let world = app.world_mut();
        let mut bodies = world.query_filtered::<&Transform, With<RigidBox>>();
        *bodies.single(world).unwrap()
    };
    assert_ne!(drawn(&mut plain), drawn(&mut eased), "it is drawn elsewhere");
    let saved = SinewSnapshot::capture(eased.world());
    let expected: Vec<u64> = (0..30)
        .map(|_| {
            tick(&mut eased, 1);
            hash(&mut eased)
        })
        .collect();
    saved.restore(eased.world_mut()).unwrap();
    let again: Vec<u64> = (0..30)
        .map(|_| {
            tick(&mut eased, 1);
            hash(&mut eased)
        })
        .collect();
    assert_eq!(again, expected, "in place");
    let mut new = app();
    saved.restore(new.world_mut()).unwrap();
    let again: Vec<u64> = (0..30)
        .map(|_| {
            tick(&mut new, 1);
            hash(&mut new)
        })
        .collect();
    assert_eq!(again, expected, "in a fresh app");
}

/// Of an interpolated body that the game moved in `Update`, a snapshot had the transform from before that.
#[test]
fn a_snapshot_has_what_the_game_did_to_an_interpolated_transform() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let frame = core::time::Duration::from_micros(6_944);
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(frame));
    let body = (RigidBox::default(), LinearVelocity(Vec3::X * 3.0), Interpolate);
    let body = app.world_mut().spawn(body).id();
    (0..20).for_each(|_| app.update());
    let height = |app: &App| app.world().get::<Transform>(body).unwrap().translation.y;
    let before = SinewSnapshot::capture(app.world());
    app.world_mut().get_mut::<Transform>(body).unwrap().translation = Vec3::Y * 100.0;
    let moved = SinewSnapshot::capture(app.world());
    for (snapshot, expected) in [(before, 0.0), (moved, 100.0)] {
        snapshot.restore(app.world_mut()).unwrap();
        (0..20).for_each(|_| app.update());
        assert!((height(&app) - expected).abs() < 1e-3, "{}", height(&app));
    }
}
