//! Solids of any shape, soft bodies and articulated bodies build themselves with the requested properties.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    Articulated, BodyConstraints, BodyParts, Bone, BoneJoint, ContactsDisabled, Inertia,
    MeshFollow, Refusal, RigidParticles, SoftShape, WindSurface, WorldCenterOfMass,
};

use crate::support::{app, assert_finite, heard, mesh_of, particles_of, position, tick, vertices};

fn constraints_of(app: &App, body: Entity) -> usize {
    app.world().get::<BodyConstraints>(body).map_or(0, |list| list.iter().count())
}

fn mesh(app: &mut App, mesh: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh))
}

#[test]
fn a_solid_has_the_mass_and_inertia_of_its_filled_mesh() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let skin = mesh(&mut app, Cuboid::new(1.0, 2.0, 3.0));
    let four = RigidParticles::Four;
    let at = Transform::from_xyz(4.0, 5.0, 6.0).with_rotation(Quat::from_rotation_x(0.5));
    for (solid, count) in [
        (RigidMesh::density(500.0), 8),
        (RigidMesh::density(500.0).shaped(RigidShape::Hull), 8),
        (RigidMesh { particles: four, ..RigidMesh::mass(3000.0) }, 4),
    ] {
        // All in the same place.
        let body = app.world_mut().spawn((solid, skin.clone(), ContactsDisabled, at)).id();
        tick(&mut app, 2);
        assert_eq!(particles_of(&app, body).len(), count);
        assert_eq!(constraints_of(&app, body), count * (count - 1) / 2);
        let entity = app.world().entity(body);
        let centre = *entity.get::<WorldCenterOfMass>().unwrap();
        assert!((centre.mass - 3000.0).abs() < 0.1, "{}", centre.mass);
        assert!(centre.position.abs_diff_eq(at.translation, 1e-4), "{}", centre.position);
        let turn = Mat3::from_quat(at.rotation);
        let inertia = turn.transpose() * entity.get::<Inertia>().unwrap().0 * turn;
        let solid = Mat3::from_diagonal(Vec3::new(13.0, 10.0, 5.0) * (3000.0 / 12.0));
        assert!(inertia.abs_diff_eq(solid, 2.0), "{inertia}");
        let frame = *entity.get::<Transform>().unwrap();
        assert!(frame.translation.abs_diff_eq(at.translation, 1e-4));
        assert!(frame.rotation.angle_between(at.rotation) < 1e-3);
        let mean: Vec3 = particles_of(&app, body).iter().map(|&p| position(&app, p)).sum::<Vec3>()
            / count as f32;
        assert!(mean.abs_diff_eq(at.translation, 1e-4));
    }
    assert_eq!(heard(&app), []);
}

#[test]
fn round_solids_have_their_exact_mass_and_roll_down_a_slope_by_their_inertia() {
    // The hull of a sphere's mesh has corners and does not roll freely, so the round shapes are used.
    let (radius, height, angle) = (0.5, 1.2, 0.35_f32);
    let volume = core::f32::consts::PI * radius * radius;
    let ball = RigidShape::Sphere { radius };
    let capsule = RigidShape::Capsule { radius, length: height };
    let cylinder = RigidShape::Cylinder { radius, height };
    let caps = volume * radius * 4.0 / 3.0;
    for (shape, volume, lag) in [
        (ball, caps, Some(0.4)),
        (capsule, volume * height + caps, None),
        (cylinder, volume * height, Some(0.5)),
    ] {
        let mut app = app();
        app.insert_resource(AirDrag(0.0));
        let turn = Quat::from_rotation_z(-angle);
        let slope = Transform::from_rotation(turn).with_translation(turn * Vec3::Y * -0.5);
        app.world_mut().spawn((Collider::cuboid(Vec3::new(60.0, 1.0, 20.0)), slope));
        let lies = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let at = Transform::from_translation(turn * Vec3::Y * radius).with_rotation(lies);
        let body = app.world_mut().spawn((RigidMesh::density(700.0).shaped(shape), at)).id();
        tick(&mut app, 30);
        let down =
            |app: &App| app.world().get::<LinearVelocity>(body).unwrap().0.dot(turn * Vec3::X);
        let before = down(&app);
        tick(&mut app, 60);
        let v = down(&app);
        let entity = app.world().entity(body);
        let mass = entity.get::<WorldCenterOfMass>().unwrap().mass;
        assert!((mass / (700.0 * volume) - 1.0).abs() < 1e-4, "{mass}");
        let spin = -entity.get::<AngularVelocity>().unwrap().0.z;
        assert!((spin * radius / v - 1.0).abs() < 0.02, "it rolls: {v} {spin}");
        if let Some(lag) = lag {
            let expected = 9.81 * angle.sin() / (1.0 + lag);
            assert!(((v - before) / expected - 1.0).abs() < 0.02, "{} of {expected}", v - before);
        }
        assert_eq!(heard(&app), []);
    }
}

#[test]
fn a_solid_takes_its_size_from_its_scale_and_a_mirror_does_not_turn_it_inside_out() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let skin = mesh(&mut app, Cuboid::new(1.0, 1.0, 1.0));
    for scale in [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 2.0, 3.0)] {
        let at = Transform::from_xyz(0.0, 1.0, 0.0).with_scale(scale);
        let body = app.world_mut().spawn((RigidMesh::density(500.0), skin.clone(), at)).id();
        tick(&mut app, 2);
        let mass = app.world().get::<WorldCenterOfMass>(body).unwrap().mass;
        assert!((mass - 3000.0).abs() < 0.1, "{scale}: {mass}");
        assert_eq!(app.world().get::<Transform>(body).unwrap().scale, scale);
    }
    assert_eq!(heard(&app), []);
}

#[test]
fn a_solid_cone_that_is_thrown_keeps_its_spin() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    let skin = mesh(&mut app, Cone::new(0.3, 0.6));
    let spin = Vec3::Y * 5.0;
    let body = app.world_mut().spawn((RigidMesh::mass(2.0), skin)).set_motion(Vec3::X, spin).id();
    tick(&mut app, 120);
    let entity = app.world().entity(body);
    let kept = entity.get::<AngularVelocity>().unwrap().0;
    assert!(kept.abs_diff_eq(spin, 0.02), "{kept}");
    let centre = entity.get::<WorldCenterOfMass>().unwrap().position;
    // The origin of Bevy's cone is at half its height, its centre of mass at a quarter.
    assert!(centre.abs_diff_eq(Vec3::new(2.0, -0.15, 0.0), 2e-3), "{centre}");
    assert_finite(&mut app);
    assert_eq!(heard(&app), []);
}

#[test]
fn impossible_solids_are_refused_once_and_have_no_particles() {
    let mut app = app();
    let skin = mesh(&mut app, Cuboid::new(1.0, 1.0, 1.0));
    // A sheet has no inside, and no hull either.
    let sheet = mesh(&mut app, Plane3d::default().mesh().size(1.0, 1.0));
    let world = app.world_mut();
    let point = RigidShape::Points(vec![Vec3::ZERO]);
    let bad = [
        world.spawn((RigidMesh::mass(f32::NAN), skin.clone())).id(),
        world.spawn((RigidMesh::density(-1.0), skin.clone())).id(),
        world.spawn((RigidMesh { radius: -1.0, ..default() }, skin)).id(),
        world.spawn((RigidMesh::default(), sheet.clone())).id(),
        world.spawn((RigidMesh::default().shaped(RigidShape::Hull), sheet)).id(),
        world.spawn(RigidMesh::default().shaped(point)).id(),
        world.spawn(RigidMesh::default()).id(),
    ];
    tick(&mut app, 10);
    let refusals = heard(&app);
    assert_eq!(refusals.iter().map(|(entity, _)| *entity).collect::<Vec<_>>(), bad);
    for (body, reason) in refusals {
        assert!(matches!(reason, Refusal::Recipe(_) | Refusal::NoMesh), "{reason}");
        assert_eq!(particles_of(&app, body), []);
    }
}

#[test]
fn a_soft_ball_from_a_mesh_keeps_its_volume_on_the_ground_and_deforms_a_mesh_of_its_own() {
    let mut app = app();
    app.world_mut().spawn(Ground);
    let sphere = Sphere::new(0.5).mesh().ico(3).unwrap();
    let original = vertices(&sphere);
    let skin = mesh(&mut app, sphere);
    let soft = SoftBody { pressure: 1.2, ..SoftBody::from_mesh() }.with_mass(2.0);
    let body = app.world_mut().spawn((soft, skin.clone(), Transform::from_xyz(0.0, 0.7, 0.0))).id();
    tick(&mut app, 180);
    let particles = particles_of(&app, body);
    assert_eq!(particles.len(), 162, "the vertices of its mesh, welded");
    let at = |p| position(&app, p);
    let triangles = &app.world().get::<WindSurface>(body).unwrap().triangles;
    let volume: f32 =
        triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c)))).sum::<f32>() / 6.0;
    // An icosphere of 320 faces has 0.969 of the volume of its ball.
    let meant = 1.2 * 0.969 * core::f32::consts::PI / 6.0;
    assert!((volume / meant - 1.0).abs() < 0.02, "{volume} of {meant}");
    assert!((app.world().get::<WorldCenterOfMass>(body).unwrap().mass - 2.0).abs() < 1e-3);
    let worn = mesh_of(&app, body);
    assert_ne!(worn, original);
    let shared = vertices(app.world().resource::<Assets<Mesh>>().get(&skin.0).unwrap());
    assert_eq!(shared, original, "others that share the mesh keep theirs");
    let frame = *app.world().get::<Transform>(body).unwrap();
    let follow = &app.world().get::<MeshFollow>(body).unwrap().vertices;
    for (&particle, &vertex) in follow.iter().zip(&worn) {
        assert!((frame * vertex).abs_diff_eq(at(particle), 1e-5));
    }
    assert_eq!(heard(&app), []);
}

/// Bodies refused the triangle strips that colliders accept. The normals of a strip's mesh are checked, too: its triangles are not those of a list of the same
/// indices.
#[test]
fn bodies_are_the_same_from_a_strip_as_from_the_list_of_its_triangles() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let corners = vec![[0.0_f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let skin = |topology, indices: Vec<u32>| {
        Mesh::new(topology, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.clone())
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0_f32; 3]; 4])
            .with_inserted_indices(Indices::U32(indices))
    };
    let list = vec![0, 1, 2, 2, 1, 3, 2, 3, 0, 0, 3, 1];
    let strip = skin(PrimitiveTopology::TriangleStrip, vec![0, 1, 2, 3, 0, 1]);
    let skins = [skin(PrimitiveTopology::TriangleList, list), strip].map(|own| mesh(&mut app, own));
    let bodies = skins.map(|skin| {
        let world = app.world_mut();
        [
            world.spawn((RigidMesh::mass(1.0), ContactsDisabled, skin.clone())).id(),
            world.spawn((SoftBody::from_mesh(), ContactsDisabled, skin.clone())).id(),
            world.spawn((Cloth::from_mesh(), ContactsDisabled, skin)).id(),
        ]
    });
    tick(&mut app, 3);
    assert_eq!(heard(&app), []);
    let [listed, stripped] = bodies.map(|bodies| {
        bodies.map(|body| {
            let handle = &app.world().get::<Mesh3d>(body).unwrap().0;
            let mesh = app.world().resource::<Assets<Mesh>>().get(handle).unwrap();
            let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).and_then(|list| list.as_float3());
            let particles = particles_of(&app, body).into_iter();
            let places: Vec<Vec3> = particles.map(|one| position(&app, one)).collect();
            (places, normals.unwrap().to_vec())
        })
    });
    assert!(listed.iter().all(|(places, _)| places.len() >= 4));
    assert_eq!(listed, stripped);
    assert!(Vec3::from(listed[2].1[0]).distance(Vec3::new(-1.0, -1.0, 1.0).normalize()) < 1e-3);
}

#[test]
fn soft_boxes_and_balls_make_their_own_mesh_and_regain_their_height() {
    let mut app = app();
    app.world_mut().spawn(Ground);
    let cells = UVec3::new(3, 3, 3);
    let cube = SoftBody::cuboid(Vec3::splat(0.6), cells).with_density(200.0);
    let world = app.world_mut();
    let bodies = [
        (world.spawn((cube, Transform::from_xyz(0.0, 0.5, 0.0))).id(), 64, 56),
        // Shells of 12 and 42 particles around the middle one.
        (world.spawn((SoftBody::ball(0.3, 4), Transform::from_xyz(3.0, 0.5, 0.0))).id(), 55, 42),
    ];
    tick(&mut app, 240);
    for (body, particles, vertices) in bodies {
        assert_eq!(particles_of(&app, body).len(), particles);
        let skin = mesh_of(&app, body);
        assert_eq!(skin.len(), vertices);
        let frame = *app.world().get::<Transform>(body).unwrap();
        let heights = skin.iter().map(|&vertex| (frame * vertex).y);
        let tall = heights.clone().fold(f32::MIN, f32::max) - heights.fold(f32::MAX, f32::min);
        assert!((tall - 0.6).abs() < 0.06, "{tall} of 0.6 m");
        // A ball with flat faces may still be rolling.
        let speed = app.world().get::<LinearVelocity>(body).unwrap().0.length();
        assert!(speed < 0.05 || vertices == 42, "the cube rests: {speed}");
    }
    let mass = app.world().get::<WorldCenterOfMass>(bodies[0].0).unwrap().mass;
    assert!((mass - 200.0 * 0.216).abs() < 0.01, "{mass}");
    assert_eq!(heard(&app), []);
}

#[test]
fn a_changed_soft_body_is_rebuilt_from_its_original_mesh() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let skin = mesh(&mut app, Sphere::new(0.5).mesh().ico(2).unwrap());
    let tight = SoftBody { pressure: 3.0, ..SoftBody::from_mesh() };
    let body = app.world_mut().spawn((tight, skin)).id();
    tick(&mut app, 60);
    let far = |app: &App| {
        let lengths = particles_of(app, body).into_iter().map(|p| position(app, p).length());
        lengths.fold(0.0, f32::max)
    };
    assert!(far(&app) > 0.65, "it is blown up: {}", far(&app));
    app.world_mut().get_mut::<SoftBody>(body).unwrap().pressure = 1.0;
    tick(&mut app, 1);
    assert!((far(&app) - 0.5).abs() < 0.01, "{}", far(&app));
    app.world_mut().get_mut::<SoftBody>(body).unwrap().shape =
        SoftShape::Ball { radius: 0.2, cells: 2 };
    tick(&mut app, 2);
    assert_eq!(particles_of(&app, body).len(), 13);
    assert_eq!(mesh_of(&app, body).len(), 12);
    assert_eq!(heard(&app), []);
}

#[test]
fn an_articulated_body_has_a_named_part_for_each_bone_and_its_joints_keep_their_limits() {
    let mut app = app();
    let post = Bone { pinned: true, ..Bone::new("post", Vec3::Y * 2.0, Vec3::Y * 3.0) };
    let hinge = BoneJoint::Hinge { axis: Vec3::Z, min: -0.8, max: 0.0 };
    let flap = Bone::new("flap", Vec3::Y * 2.0, Vec3::new(0.6, 2.0, 0.0)).on(0, hinge);
    let body = app.world_mut().spawn(Articulated::new([post, flap])).id();
    tick(&mut app, 1);
    let parts: Vec<Entity> = app.world().get::<BodyParts>(body).unwrap().iter().collect();
    let name = |part: &Entity| app.world().get::<Name>(*part).unwrap().to_string();
    assert_eq!(parts.iter().map(name).collect::<Vec<_>>(), ["post", "flap"]);
    for _ in 0..240 {
        tick(&mut app, 1);
        let held = app.world().get::<Transform>(parts[0]).unwrap();
        assert!(held.translation.abs_diff_eq(Vec3::Y * 2.5, 1e-4), "{held:?}");
        let along = app.world().get::<Transform>(parts[1]).unwrap().rotation * Vec3::NEG_Y;
        let fallen = -along.y.atan2(along.x);
        assert!(fallen > -0.05 && fallen < 0.9, "{fallen} rad");
    }
    let along = app.world().get::<Transform>(parts[1]).unwrap().rotation * Vec3::NEG_Y;
    assert!((-along.y.atan2(along.x) - 0.8).abs() < 0.03, "it hangs at its limit: {along}");
    assert_finite(&mut app);
    assert_eq!(heard(&app), []);
}

#[test]
fn impossible_soft_and_articulated_bodies_are_refused_once_and_have_no_particles() {
    let mut app = app();
    let sheet = mesh(&mut app, Plane3d::default().mesh().size(1.0, 1.0));
    let world = app.world_mut();
    let bone = Bone::default();
    let ball = BoneJoint::Ball { cone: -1.0, twist: 0.0 };
    let hinge = BoneJoint::Hinge { axis: Vec3::ZERO, min: 0.0, max: 1.0 };
    let bad = [
        world.spawn((SoftBody::from_mesh(), sheet)).id(),
        world.spawn(SoftBody::from_mesh()).id(),
        world.spawn(SoftBody::cuboid(Vec3::ONE, UVec3::ZERO)).id(),
        world.spawn(SoftBody::ball(f32::NAN, 4)).id(),
        world.spawn(SoftBody { stiffness: 0.0, ..default() }).id(),
        world.spawn(SoftBody { poisson: 0.5, ..default() }).id(),
        world.spawn(SoftBody::default().with_mass(0.0)).id(),
        world.spawn(Articulated::default()).id(),
        world.spawn(Articulated::new([Bone { mass: -1.0, ..bone.clone() }])).id(),
        world.spawn(Articulated::new([bone.clone().on(0, ball)])).id(),
        world.spawn(Articulated::new([bone.clone(), bone.clone().on(0, ball)])).id(),
        world.spawn(Articulated::new([bone.clone(), bone.on(0, hinge)])).id(),
        world.spawn(Articulated { drag: 2.0, ..Articulated::new([Bone::default()]) }).id(),
    ];
    tick(&mut app, 10);
    let mut refusals = heard(&app);
    refusals.sort_by_key(|(entity, _)| *entity);
    let mut all = bad.to_vec();
    all.sort();
    assert_eq!(refusals.iter().map(|(entity, _)| *entity).collect::<Vec<_>>(), all);
    for (body, reason) in refusals {
        let expected = matches!(reason, Refusal::Recipe(_) | Refusal::NoMesh);
        assert!(expected, "{reason}");
        assert_eq!(particles_of(&app, body), []);
    }
}
