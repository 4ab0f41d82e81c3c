//! Bodies that cannot be built are refused once, by name, and the rest of the world goes on.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Flatland, Refusal};

use crate::support::{app, assert_finite, forget, heard, particles_of, position, tick};

/// Spawns a body that cannot be built beside a falling particle. Returns the body, the entities refused within 30 ticks, and how many particles the body has.
fn refused(spawn: impl FnOnce(&mut World) -> Entity) -> (Entity, Vec<Entity>, usize) {
    let mut app = app();
    let stone = app.world_mut().spawn(Particle::at(Vec3::ZERO)).id();
    let body = spawn(app.world_mut());
    tick(&mut app, 30);
    assert!(position(&app, stone).y < -1.0, "the rest goes on");
    let named = heard(&app).into_iter().map(|(entity, _)| entity).collect();
    (body, named, particles_of(&app, body).len())
}

/// Asserts for each case that exactly one message names the body, and that the body has no particles.
fn assert_each_refused(cases: Vec<(String, Box<dyn FnOnce(&mut World) -> Entity>)>) {
    let mut wrong = Vec::new();
    for (name, spawn) in cases {
        let (body, named, particles) = refused(spawn);
        if named != [body] || particles != 0 {
            wrong.push(format!("{name}: {body}: {named:?} named, {particles} particles"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn case<B: Bundle>(
    name: impl ToString,
    bundle: B,
) -> (String, Box<dyn FnOnce(&mut World) -> Entity>) {
    (name.to_string(), Box::new(move |world| world.spawn(bundle).id()))
}

const BAD: [f32; 6] = [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30];

#[test]
fn recipes_with_a_broken_number_are_refused_once() {
    let mut cases = Vec::new();
    for bad in BAD {
        cases.push(case(format!("box of {bad} m"), RigidBox::new(Vec3::new(1.0, bad, 1.0))));
        cases.push(case(format!("box of {bad} kg"), RigidBox::default().with_mass(bad)));
        cases.push(case(format!("cloth {bad} m wide"), Cloth::grid(bad, 1.0, 4, 4)));
        cases.push(case(format!("cloth {bad} m high"), Cloth::grid(1.0, bad, 4, 4)));
        cases.push(case(format!("cloth of {bad} kg/m²"), Cloth { density: bad, ..default() }));
        cases.push(
            case(format!("rope of {bad} m"), Rope { to: Vec3::Y * bad, ..default() })
                .minus_one(bad),
        );
        cases.push(case(format!("rope of {bad} kg"), Rope { mass: bad, ..default() }));
        cases.push(case(format!("figure of {bad} m"), Ragdoll { height: bad, ..default() }));
        cases.push(case(format!("figure of {bad} kg"), Ragdoll { mass: bad, ..default() }));
    }
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        let cloth = Cloth::default();
        cases.push(case(
            format!("stretch {bad}"),
            Cloth { stretch_compliance: bad, ..cloth.clone() },
        ));
        cases.push(case(
            format!("bend {bad}"),
            Cloth { bend_compliance: Some(bad), ..cloth.clone() },
        ));
        cases.push(case(format!("cloth radius {bad}"), Cloth { radius: bad, ..cloth }));
        cases.push(case(format!("slack {bad}"), Rope { slack: bad, ..default() }));
        cases.push(case(format!("rope radius {bad}"), Rope { radius: bad, ..default() }));
        cases.push(case(format!("compliance {bad}"), Rope { compliance: bad, ..default() }));
    }
    cases.push(case("rope from nowhere", Rope { from: Vec3::NAN, ..default() }));
    cases.push(case("rope without segments", Rope { segments: 0, ..default() }));
    cases.push(case("cloth without columns", Cloth::grid(1.0, 1.0, 0, 4)));
    cases.push(case("cloth without rows", Cloth::grid(1.0, 1.0, 4, 0)));
    cases.push(case("cloth with too many cells", Cloth::grid(1.0, 1.0, u32::MAX, u32::MAX)));
    assert_each_refused(cases);
}

/// Replaces the case of a rope of -1 m, which is a valid rope of 1 m in the other direction.
trait MinusOne {
    fn minus_one(self, bad: f32) -> Self;
}

impl MinusOne for (String, Box<dyn FnOnce(&mut World) -> Entity>) {
    fn minus_one(self, bad: f32) -> Self {
        if bad == -1.0 {
            case("rope of no length", Rope { to: Vec3::ZERO, ..default() })
        } else {
            self
        }
    }
}

#[test]
fn bodies_with_a_broken_transform_are_refused_once() {
    let nan = f32::NAN;
    let transforms = [
        ("at NaN", Transform::from_xyz(0.0, nan, 0.0)),
        ("at infinity", Transform::from_xyz(f32::INFINITY, 0.0, 0.0)),
        ("turned by NaN", Transform::from_rotation(Quat::from_xyzw(nan, 0.0, 0.0, 1.0))),
        ("scaled by NaN", Transform::from_scale(Vec3::new(1.0, nan, 1.0))),
        ("scaled to nothing", Transform::from_scale(Vec3::ZERO)),
        ("flattened", Transform::from_scale(Vec3::new(1.0, 0.0, 1.0))),
        ("mirrored and flattened", Transform::from_scale(Vec3::new(-1.0, 0.0, 1.0))),
    ];
    let mut cases = Vec::new();
    for (name, transform) in transforms {
        cases.push(case(format!("box {name}"), (RigidBox::default(), transform)));
        cases.push(case(format!("rope {name}"), (Rope::default(), transform)));
        cases.push(case(format!("cloth {name}"), (Cloth::default(), transform)));
        cases.push(case(format!("figure {name}"), (Ragdoll::default(), transform)));
    }
    assert_each_refused(cases);
}

fn list(topology: PrimitiveTopology, positions: Vec<[f32; 3]>) -> Mesh {
    Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
}

fn from_mesh(name: &str, mesh: Mesh) -> (String, Box<dyn FnOnce(&mut World) -> Entity>) {
    let spawn = move |world: &mut World| {
        let handle = world.resource_mut::<Assets<Mesh>>().add(mesh);
        world.spawn((Cloth::from_mesh(), Mesh3d(handle))).id()
    };
    (name.into(), Box::new(spawn))
}

#[test]
fn meshes_unfit_for_cloth_are_refused_once() {
    use PrimitiveTopology::{LineList, PointList, TriangleList, TriangleStrip};
    let three = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let with = |indices: Vec<u32>| {
        list(TriangleList, three.clone()).with_inserted_indices(Indices::U32(indices))
    };
    let nothing = Mesh::new(TriangleList, RenderAssetUsages::default());
    assert_each_refused(vec![
        from_mesh("no positions", nothing),
        from_mesh("empty", list(TriangleList, Vec::new())),
        from_mesh("no triangles", with(Vec::new())),
        from_mesh("points", list(PointList, three.clone())),
        from_mesh("lines", list(LineList, vec![[0.0; 3], [1.0; 3]])),
        from_mesh("a strip of two vertices", list(TriangleStrip, vec![[0.0; 3], [1.0; 3]])),
        from_mesh("half a triangle", list(TriangleList, vec![[0.0; 3], [1.0; 3]])),
        from_mesh("NaN", list(TriangleList, vec![[0.0; 3], [1.0, 0.0, f32::NAN], [0.0, 1.0, 0.0]])),
        from_mesh("all in one place", list(TriangleList, vec![[1.0; 3]; 9])),
        from_mesh("all on a line", list(TriangleList, vec![[0.0; 3], [1.0; 3], [2.0; 3]])),
        from_mesh("an index too far", with(vec![0, 1, 3])),
        from_mesh("two indices", with(vec![0, 1])),
        case("no Mesh3d", Cloth::from_mesh()),
        case("a handle to nothing", (Cloth::from_mesh(), Mesh3d(Handle::default()))),
    ]);
}

#[test]
fn a_mesh_file_that_is_not_there_is_refused_once() {
    // Loading fails on another thread, so it takes some time.
    let mut app = app();
    let missing = app.world().resource::<AssetServer>().load("there is no such.mesh");
    let body = app.world_mut().spawn((Cloth::from_mesh(), Mesh3d(missing))).id();
    for _ in 0..200 {
        tick(&mut app, 1);
        std::thread::sleep(core::time::Duration::from_millis(1));
    }
    let named: Vec<Entity> = heard(&app).into_iter().map(|(entity, _)| entity).collect();
    assert_eq!(named, [body]);
}

#[test]
fn a_refused_body_is_built_when_its_recipe_is_repaired() {
    let mut app = app();
    let body = app.world_mut().spawn(RigidBox::new(Vec3::NAN)).id();
    let rope = app.world_mut().spawn((Rope::default(), Transform::from_scale(Vec3::ZERO))).id();
    tick(&mut app, 5);
    assert_eq!(heard(&app).len(), 2);
    forget(&mut app);
    app.world_mut().get_mut::<RigidBox>(body).unwrap().size = Vec3::ONE;
    app.world_mut().entity_mut(rope).insert((Rope::default(), Transform::IDENTITY));
    tick(&mut app, 5);
    assert_eq!((particles_of(&app, body).len(), particles_of(&app, rope).len()), (8, 21));
    assert_eq!(heard(&app), []);
    assert_finite(&mut app);
}

#[test]
fn a_body_whose_recipe_becomes_invalid_is_left_without_particles() {
    let mut app = app();
    let world = app.world_mut();
    let cube = world.resource_mut::<Assets<Mesh>>().add(Mesh::from(Cuboid::default()));
    let bodies = [
        world.spawn(RigidBox::default()).id(),
        world.spawn(Rope::default()).id(),
        world.spawn((Cloth::from_mesh(), Mesh3d(cube))).id(),
    ];
    tick(&mut app, 5);
    let world = app.world_mut();
    world.get_mut::<RigidBox>(bodies[0]).unwrap().mass = f32::NAN;
    let longer = Rope { segments: 30, ..default() };
    world.entity_mut(bodies[1]).insert((longer, Transform::from_xyz(f32::NAN, 0.0, 0.0)));
    world.entity_mut(bodies[2]).remove::<Mesh3d>().insert(Cloth::from_mesh());
    tick(&mut app, 5);
    let mut named: Vec<Entity> = heard(&app).into_iter().map(|(entity, _)| entity).collect();
    named.sort_by_key(|entity| entity.index());
    assert_eq!(named, bodies);
    assert_eq!(bodies.map(|body| particles_of(&app, body).len()), [0; 3]);
    assert!(app.world().resource::<SinewWorld>().particles().is_empty());
}

/// Regression: the rods of a body that is not flat contradict the plane of a 2D world. A box reached 500 m/s there, a ball 349 m/s, a ragdoll 122 m/s.
#[test]
fn a_rigid_body_that_is_not_flat_is_refused_in_a_two_dimensional_world_until_that_is_none() {
    let mut app = app();
    let at = |x: f32| Transform::from_xyz(x, 3.0, 0.0);
    let world = app.world_mut();
    let flatland = world.spawn(Flatland).id();
    world.spawn(Ground);
    let ball = RigidMesh::mass(1.0).shaped(RigidShape::Sphere { radius: 0.5 });
    let thick = [
        world.spawn((RigidBox::new(Vec3::ONE), at(0.0))).id(),
        world.spawn((ball, at(2.0))).id(),
        world.spawn((Ragdoll::default(), at(4.0))).id(),
    ];
    let turned = at(6.0).with_rotation(Quat::from_rotation_x(0.7));
    let thin = [
        world.spawn((RigidBox { flat: true, ..default() }, turned)).id(),
        world.spawn((RigidBox::new(Vec3::new(1.0, 1.0, 0.01)), at(8.0))).id(),
        world.spawn((Rope { pin_start: false, ..default() }, at(10.0))).id(),
        world.spawn((Cloth::grid(1.0, 1.0, 4, 4), at(12.0))).id(),
    ];
    let mut fastest = 0.0_f32;
    for _ in 0..120 {
        tick(&mut app, 1);
        let world = app.world_mut();
        let mut particles = world.query::<&Particle>();
        let speeds = particles.iter(world).map(|one| one.velocity.length());
        fastest = speeds.fold(fastest, f32::max);
    }
    assert!(fastest < 10.0, "they fall: {fastest} m/s");
    let named: Vec<_> = thick.iter().map(|&body| (body, Refusal::NotFlat)).collect();
    let mut all = heard(&app);
    all.sort_by_key(|(body, _)| body.index());
    assert_eq!(all, named, "each is named once");
    for body in thin {
        assert!(!particles_of(&app, body).is_empty());
    }
    app.world_mut().despawn(flatland);
    tick(&mut app, 2);
    for body in thick {
        assert!(!particles_of(&app, body).is_empty());
    }
}
