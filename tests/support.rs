//! Apps to test in, a clock that runs tick by tick, a record of refusals, and hashes of the state.

use core::time::Duration;

use bevy::app::Plugins;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParticles, Charge, CreationOrder, Drag, Electric, Refusal, Refused};

/// One tick of the fixed schedule: 60 Hz.
pub(crate) const TICK: Duration = Duration::from_nanos(16_666_667);

/// Every refusal so far, in order.
#[derive(Resource, Default)]
pub(crate) struct Heard(pub(crate) Vec<Refused>);

/// How often the fixed schedule ran, paused or not.
#[derive(Resource, Default)]
struct FixedTicks(u64);

/// An app with nothing but `MinimalPlugins` and Sinew's: no assets, no meshes.
pub(crate) fn bare_app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPlugins));
    instrument(&mut app);
    app
}

/// The same with assets, so that there are meshes, and with the propagation of transforms.
pub(crate) fn app() -> App {
    app_with(())
}

/// The same with more plugins.
pub(crate) fn app_with<M>(more: impl Plugins<M>) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
    app.init_asset::<Mesh>();
    app.add_plugins(SinewPlugins).add_plugins(more);
    instrument(&mut app);
    app
}

fn instrument(app: &mut App) {
    app.insert_resource(Time::<Fixed>::from_duration(TICK))
        .insert_resource(TimeUpdateStrategy::ManualDuration(TICK))
        .init_resource::<Heard>()
        .init_resource::<FixedTicks>()
        .add_systems(FixedFirst, |mut ticks: ResMut<FixedTicks>| ticks.0 += 1)
        .add_systems(Last, |mut heard: ResMut<Heard>, mut messages: MessageReader<Refused>| {
            heard.0.extend(messages.read().cloned());
        });
    app.finish();
    app.cleanup();
}

/// Runs frames until the fixed schedule ran `count` more times. A frame is as long as a tick, unless the test set another length.
pub(crate) fn tick(app: &mut App, count: u64) {
    let end = app.world().resource::<FixedTicks>().0 + count;
    for _ in 0..100 * (count + 10) {
        if app.world().resource::<FixedTicks>().0 >= end {
            return;
        }
        app.update();
    }
    panic!("the fixed schedule does not run");
}

/// The refusals so far: entity and reason.
pub(crate) fn heard(app: &App) -> Vec<(Entity, Refusal)> {
    let all = &app.world().resource::<Heard>().0;
    all.iter().map(|refused| (refused.entity, refused.reason.clone())).collect()
}

/// Clears the refusals so far.
pub(crate) fn forget(app: &mut App) {
    app.world_mut().resource_mut::<Heard>().0.clear();
}

/// The particles of a body, as the body lists them.
pub(crate) fn particles_of(app: &App, body: Entity) -> Vec<Entity> {
    app.world().get::<BodyParticles>(body).map(|list| list.iter().collect()).unwrap_or_default()
}

/// Position of a particle.
pub(crate) fn position(app: &App, particle: Entity) -> Vec3 {
    app.world().get::<Particle>(particle).expect("it is a particle").position
}

/// FNV-1a over words.
pub(crate) fn fnv(words: impl Iterator<Item = u32>) -> u64 {
    let bytes = words.flat_map(u32::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// The bits of one particle's state.
pub(crate) fn bits(particle: &Particle) -> [u32; 10] {
    let Particle { position: p, remainder: r, velocity: v, lag } = *particle;
    [p.x, p.y, p.z, r.x, r.y, r.z, v.x, v.y, v.z, lag].map(f32::to_bits)
}

/// Hash of all particles, in the order of their creation.
pub(crate) fn hash(app: &mut App) -> u64 {
    let world = app.world_mut();
    let mut all: Vec<(CreationOrder, Particle)> = world
        .query::<(&CreationOrder, &Particle)>()
        .iter(world)
        .map(|(order, particle)| (*order, *particle))
        .collect();
    all.sort_by_key(|(order, _)| *order);
    assert!(!all.is_empty(), "a hash of nothing proves nothing");
    fnv(all.iter().flat_map(|(_, particle)| bits(particle)))
}

/// Hash of the particles and the transforms of these bodies alone.
pub(crate) fn hash_of(app: &App, bodies: &[Entity]) -> u64 {
    let world = app.world();
    fnv(bodies.iter().flat_map(|&body| {
        let particles = particles_of(app, body);
        assert!(!particles.is_empty(), "a hash of nothing proves nothing");
        let transform = *world.get::<Transform>(body).expect("bodies have transforms");
        let pose =
            [transform.translation.to_array().to_vec(), transform.rotation.to_array().to_vec()];
        let particles = particles.into_iter().map(|p| *world.get::<Particle>(p).expect("alive"));
        let state: Vec<u32> = particles.flat_map(|particle| bits(&particle)).collect();
        state.into_iter().chain(pose.into_iter().flatten().map(f32::to_bits))
    }))
}

/// Asserts that every particle, transform and mesh vertex in the world is a finite number.
pub(crate) fn assert_finite(app: &mut App) {
    let world = app.world_mut();
    let particles = world.query::<(Entity, &Particle)>();
    for (entity, particle) in { particles }.iter(world) {
        let sound = particle.position.is_finite() && particle.velocity.is_finite();
        assert!(sound, "{entity}: {particle:?}");
    }
    for (entity, transform) in world.query::<(Entity, &Transform)>().iter(world) {
        assert!(transform.is_finite(), "{entity}: {transform:?}");
    }
    let Some(meshes) = world.get_resource::<Assets<Mesh>>() else { return };
    for (id, mesh) in meshes.iter() {
        for (vertex, position) in vertices(mesh).into_iter().enumerate() {
            assert!(position.is_finite(), "mesh {id:?}, vertex {vertex}: {position}");
        }
    }
}

/// The positions of a mesh's vertices.
pub(crate) fn vertices(mesh: &Mesh) -> Vec<Vec3> {
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|list| list.as_float3());
    positions.unwrap_or_default().iter().map(|&p| p.into()).collect()
}

/// The vertices of an entity's own mesh.
pub(crate) fn mesh_of(app: &App, body: Entity) -> Vec<Vec3> {
    let handle = &app.world().get::<Mesh3d>(body).expect("it has a mesh").0;
    let meshes = app.world().resource::<Assets<Mesh>>();
    vertices(meshes.get(handle).expect("its mesh is there"))
}

/// Spawns a bit of everything: a box, a rope, a flag, a ragdoll and a swarm of charges on springs, in wind, water and a bounding box. Returns the four bodies.
pub(crate) fn busy_scene(app: &mut App) -> Vec<Entity> {
    let world = app.world_mut();
    world.spawn(Ground);
    world.spawn(BoundingBox { size: Vec3::splat(12.0) });
    world.spawn(Wind { pressure: Vec3::new(6.0, 0.0, 2.0), gusts: 0.5, ..default() });
    world.spawn((Fluid::default(), Transform::from_xyz(0.0, 0.3, 0.0)));
    let bodies = vec![
        world
            .spawn((RigidBox::new(Vec3::new(0.4, 0.3, 0.5)), Transform::from_xyz(-2.0, 2.0, 0.0)))
            .id(),
        world
            .spawn((
                Rope { slack: 0.2, pin_end: true, to: Vec3::X, ..default() },
                Transform::from_xyz(0.0, 2.0, 2.0),
            ))
            .id(),
        world
            .spawn((
                Cloth::grid(1.0, 0.7, 10, 7).pinned(ClothPins::LeftEdge),
                Transform::from_xyz(1.0, 3.0, 0.0),
            ))
            .id(),
        world
            .spawn((
                Ragdoll::default(),
                Transform::from_xyz(2.0, 1.0, -2.0).with_rotation(Quat::from_rotation_z(0.4)),
            ))
            .id(),
    ];
    world.insert_resource(Electric { constant: 1.0, softening: 0.05, ..default() });
    let swarm: Vec<Entity> = (0..6)
        .map(|i| {
            let place = Vec3::new(-1.0 + 0.3 * i as f32, 2.0, -1.0 + 0.1 * (i * i) as f32);
            world
                .spawn((
                    Particle::at(place),
                    Mass(0.5),
                    Charge(0.5 - (i % 2) as f32),
                    Radius(0.05),
                    Drag(0.1),
                ))
                .id()
        })
        .collect();
    for pair in swarm.windows(2) {
        world.spawn(Spring::new(pair[0], pair[1], 0.35, 40.0).with_damping(0.3));
    }
    bodies
}
