//! A warm tick allocates nothing: memory that was allocated once is used again. Allocations are counted on the test's thread alone, so everything runs on it.

use bevy::ecs::schedule::{Schedules, SingleThreadedExecutor};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AirFlow, Attractor, BodyContacts, Charge, ContactShape, ControlForce, Electric, ElectricField,
    Representation, RigidIntegrator, SinewClock,
};

use crate::support::TICK;

/// Ticks before counting begins: by then lists have grown and falling bodies have come to rest.
const WARM: u32 = 480;
/// Ticks counted.
const COUNTED: u32 = 30;

/// An app with meshes, and with Sinew's plugins if `ours`.
fn app(ours: bool) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default()));
    app.init_asset::<Mesh>();
    if ours {
        app.add_plugins(SinewPlugins);
        // A scope of Bevy's task pool allocates what it spawns.
        app.insert_resource(SolverConfig { threads: false, ..default() });
    }
    app.insert_resource(Time::<Fixed>::from_duration(TICK))
        .insert_resource(TimeUpdateStrategy::ManualDuration(TICK))
        // In both apps, because a schedule that has a system to run allocates twice.
        .add_systems(FixedUpdate, ride);
    app.finish();
    app.cleanup();
    for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
    app
}

/// Number of allocations in [`COUNTED`] warm frames, beyond those of the same app without Sinew.
fn allocations(spawn: impl FnOnce(&mut World)) -> i64 {
    let (mut with, mut without) = (app(true), app(false));
    spawn(with.world_mut());
    let (with_it, without_it) = (count(&mut with), count(&mut without));
    assert!(with.world().resource::<SinewClock>().tick > u64::from(WARM), "it ticked");
    with_it as i64 - without_it as i64
}

fn count(app: &mut App) -> u64 {
    (0..WARM).for_each(|_| app.update());
    allocation_counter::measure(|| (0..COUNTED).for_each(|_| app.update())).count_total
}

#[test]
fn an_allocation_would_be_counted() {
    let counted = allocation_counter::measure(|| drop(std::hint::black_box(Box::new(1_u32))));
    assert_eq!(counted.count_total, 1);
    let mut app = app(true);
    app.add_systems(FixedUpdate, || drop(std::hint::black_box(vec![1; 100])));
    assert!(count(&mut app) >= u64::from(COUNTED), "in a system too");
}

#[test]
fn an_empty_world_allocates_nothing() {
    assert_eq!(allocations(|_| {}), 0);
}

#[test]
fn cloth_in_the_wind_with_its_mesh_allocates_nothing() {
    let spawn = |world: &mut World| {
        world.spawn(Ground);
        world.spawn(Wind { pressure: Vec3::new(2.0, 0.0, 1.0), gusts: 0.5, ..default() });
        world.spawn(AirFlow { velocity: Vec3::X, ..default() });
        let cloth = Cloth::grid(1.0, 1.0, 16, 16).pinned(ClothPins::TopCorners);
        world.spawn((cloth, Transform::from_xyz(0.0, 3.0, 0.0)));
        world.spawn((Cloth::grid(0.5, 0.5, 8, 8), Interpolate, Transform::from_xyz(3.0, 1.0, 0.0)));
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn ropes_with_their_tubes_allocate_nothing() {
    let spawn = |world: &mut World| {
        let hand = world.spawn(Transform::from_xyz(0.0, 2.0, 0.0)).id();
        let rope = Rope { pin_start: true, to: Vec3::X, ..default() };
        world.spawn((rope, Transform::from_xyz(0.0, 2.0, 0.0)));
        let end =
            world.spawn((Particle::at(Vec3::Y), PinnedTo { entity: hand, offset: Vec3::ZERO }));
        let end = end.id();
        let other = world.spawn((Particle::at(Vec3::ZERO), Pinned::at(Vec3::X))).id();
        world.spawn(Spring::new(end, other, 0.5, 10.0));
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn ragdolls_and_boxes_that_are_pushed_allocate_nothing() {
    let spawn = |world: &mut World| {
        world.spawn(Ground);
        world.spawn(BoundingBox { size: Vec3::splat(12.0) });
        world.spawn((Ragdoll::default(), Transform::from_xyz(0.0, 1.5, 0.0)));
        let push = ControlForce { force: Vec3::new(0.0, 1.0, 0.0), ..default() };
        world.spawn((RigidBox::default(), push, Transform::from_xyz(2.0, 1.0, 0.0)));
        let spin = Representation::Rigid(RigidIntegrator::default());
        world.spawn((RigidBox::default(), spin, Transform::from_xyz(4.0, 1.0, 0.0)));
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn charges_in_fields_allocate_nothing() {
    let spawn = |world: &mut World| {
        world.insert_resource(Electric { constant: 1.0, softening: 0.05, ..default() });
        world.spawn(ElectricField { field: Vec3::X });
        world.spawn(Attractor::new(1.0));
        for i in 0..200 {
            let turn = i as f32 * 2.4;
            let place = Vec3::new(turn.cos(), i as f32 * 0.01, turn.sin());
            world.spawn((Particle::at(place), Charge(0.01), Radius(0.01)));
        }
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn floating_bodies_allocate_nothing() {
    let spawn = |world: &mut World| {
        world.spawn((Fluid::default(), Transform::from_xyz(0.0, 0.3, 0.0)));
        world.spawn((RigidBox::default(), Floats::default(), Transform::from_xyz(0.0, 1.0, 0.0)));
        world.spawn((Particle::at(Vec3::X * 3.0), Radius(0.1), Mass(2.0)));
    };
    assert_eq!(allocations(spawn), 0);
}

/// A transform that moves up and down.
#[derive(Component)]
struct Lift;

fn ride(mut lifts: Query<&mut Transform, With<Lift>>, time: Res<Time>) {
    for mut lift in &mut lifts {
        lift.translation.y = 0.1 * (time.elapsed_secs() * 3.0).sin();
    }
}

#[test]
fn colliders_and_bodies_at_rest_on_them_allocate_nothing() {
    let spawn = |world: &mut World| {
        let around = world.spawn(Transform::from_xyz(0.0, -1.0, 0.0)).id();
        let floor = Transform::from_xyz(0.0, -0.5, 0.0);
        world.spawn((Collider::cuboid(Vec3::new(18.0, 1.0, 18.0)), floor, ChildOf(around)));
        world.spawn((Collider::sphere(0.5), Transform::from_xyz(4.0, 0.0, 0.0)));
        world.spawn((Collider::sphere(f32::NAN), SurfaceMaterial::default()));
        world.spawn((RigidBox::new(Vec3::splat(0.5)), Transform::default()));
        world.spawn((Particle::at(Vec3::new(2.0, 0.0, 0.0)), Radius(0.1)));
        let cloth = Cloth { radius: 0.02, ..Cloth::grid(0.5, 0.5, 8, 8) };
        world.spawn((cloth, Transform::from_xyz(4.0, 1.0, 0.0)));
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn moving_colliders_allocate_nothing() {
    let spawn = |world: &mut World| {
        let floor = (Collider::cuboid(Vec3::new(18.0, 1.0, 18.0)), Transform::default());
        world.spawn((floor, Lift));
        world.spawn((Collider::sphere(0.5), Lift, Transform::from_xyz(4.0, 0.0, 0.0)));
        world.spawn((RigidBox::new(Vec3::splat(0.5)), Transform::from_xyz(0.0, 1.0, 0.0)));
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn bodies_that_lie_on_each_other_allocate_nothing() {
    let spawn = |world: &mut World| {
        world.spawn((Collider::cuboid(Vec3::new(18.0, 1.0, 18.0)), Transform::default()));
        for i in 0..3 {
            let at = Transform::from_xyz(0.0, 1.0 + 0.6 * i as f32, 0.0);
            world.spawn((RigidBox::new(Vec3::splat(0.5)), BodyContacts::default(), at));
        }
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn particles_that_lie_on_each_other_allocate_nothing() {
    let spawn = |world: &mut World| {
        world.spawn((Collider::cuboid(Vec3::new(18.0, 1.0, 18.0)), Transform::default()));
        for i in 0..3 {
            let ball = Particle::at(Vec3::new(2.0, 1.0 + 0.3 * i as f32, 0.0));
            world.spawn((ball, Radius(0.1), BodyContacts::default()));
        }
        let cloth = Cloth { radius: 0.02, ..Cloth::grid(0.5, 0.5, 8, 8) };
        world.spawn((cloth, BodyContacts::ALL, Transform::from_xyz(4.0, 1.0, 0.0)));
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn particles_that_lie_on_triangles_allocate_nothing() {
    let spawn = |world: &mut World| {
        let cloth =
            Cloth { radius: 0.01, ..Cloth::grid(1.0, 1.0, 5, 5) }.pinned(ClothPins::Corners);
        let flat = Transform::from_rotation(Quat::from_rotation_x(-1.5));
        world.spawn((cloth, BodyContacts::ALL.shaped(ContactShape::Triangles), flat));
        for i in 0..5 {
            let ball = Particle::at(Vec3::new(0.1 * i as f32 - 0.2, 0.05, 0.05));
            world.spawn((ball, Mass(0.01), Radius(0.03), BodyContacts::default()));
        }
    };
    assert_eq!(allocations(spawn), 0);
}

#[test]
fn segments_of_a_rope_that_lies_still_allocate_nothing() {
    let spawn = |world: &mut World| {
        world.spawn((Collider::plane(), Transform::from_xyz(0.0, -0.05, 0.0)));
        let rope = Rope { segments: 9, pin_start: false, ..Rope::between(Vec3::ZERO, Vec3::X) };
        world.spawn((rope, BodyContacts::ALL.shaped(ContactShape::Segments)));
    };
    assert_eq!(allocations(spawn), 0);
}
