//! What is drawn follows what is simulated: vertices, normals, tubes, and the frames between two ticks.

use core::time::Duration;

use bevy::mesh::Indices;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{ContactsDisabled, MeshFollow, SinewClock, TubeMesh};

use crate::support::{
    TICK, app, assert_finite, heard, mesh_of, particles_of, position, tick, vertices,
};

/// The largest distance between a cloth's vertices, in the world's frame, and the particles that they follow, metres.
fn mesh_error(app: &App, body: Entity) -> f32 {
    let frame = *app.world().get::<Transform>(body).unwrap();
    let follow = app.world().get::<MeshFollow>(body).unwrap();
    let mesh = mesh_of(app, body);
    assert_eq!(mesh.len(), follow.vertices.len());
    let pairs = mesh.iter().zip(&follow.vertices);
    pairs.map(|(&v, &p)| (frame * v).distance(position(app, p))).fold(0.0, f32::max)
}

#[test]
fn the_vertices_of_a_cloth_are_where_its_particles_are_whatever_its_transform() {
    let mut app = app();
    app.world_mut().spawn(Wind { gusts: 0.5, ..default() });
    let transforms = [
        Transform::IDENTITY,
        Transform::from_xyz(3.0, -2.0, 7.0).with_rotation(Quat::from_rotation_x(0.7)),
        Transform::from_xyz(-3.0, 0.0, 0.0).with_scale(Vec3::new(2.0, 0.5, 1.0)),
        Transform::from_xyz(-6.0, 0.0, 0.0).with_scale(Vec3::new(-1.0, 1.0, 1.0)),
    ];
    let cloths = transforms.map(|transform| {
        app.world_mut().spawn((Cloth::default().pinned(ClothPins::TopCorners), transform)).id()
    });
    for _ in 0..30 {
        tick(&mut app, 3);
        for cloth in cloths {
            let error = mesh_error(&app, cloth);
            assert!(error < 1e-5, "{error}");
        }
    }
    assert_finite(&mut app);
    assert_eq!(heard(&app), []);
}

#[test]
fn a_scaled_mesh_becomes_a_cloth_of_the_scaled_size() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let mesh =
        app.world_mut().resource_mut::<Assets<Mesh>>().add(Mesh::from(Cuboid::from_length(1.0)));
    let scale = Vec3::new(2.0, 3.0, 4.0);
    let body = app
        .world_mut()
        .spawn((Cloth::from_mesh(), Mesh3d(mesh), Transform::from_scale(scale)))
        .id();
    tick(&mut app, 10);
    let particles = particles_of(&app, body);
    assert_eq!(particles.len(), 8, "24 vertices of a cube are 8 corners");
    for particle in particles {
        assert!(position(&app, particle).abs().abs_diff_eq(scale / 2.0, 1e-3));
    }
    assert!(mesh_error(&app, body) < 1e-5);
}

#[test]
fn normals_are_unit_vectors_perpendicular_to_a_flat_cloth() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let turn = Quat::from_rotation_y(1.0);
    let cloth = app.world_mut().spawn((Cloth::default(), Transform::from_rotation(turn))).id();
    tick(&mut app, 5);
    let handle = &app.world().get::<Mesh3d>(cloth).unwrap().0;
    let mesh = app.world().resource::<Assets<Mesh>>().get(handle).unwrap();
    let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).and_then(|list| list.as_float3()).unwrap();
    assert_eq!(normals.len(), 441);
    for &normal in normals {
        // Threads whose rest length is rounded up push, and the sheet gives way sideways by micrometres.
        assert!(Vec3::from(normal).abs_diff_eq(Vec3::Z, 2e-3), "{normal:?}");
    }
}

#[test]
fn the_tube_of_a_rope_keeps_its_radius_around_its_particles() {
    let mut app = app();
    let rope = Rope { radius: 0.03, slack: 0.5, to: Vec3::X, pin_end: true, ..default() };
    let body = app.world_mut().spawn((rope, Transform::from_xyz(1.0, 2.0, 3.0))).id();
    tick(&mut app, 90);
    let frame = *app.world().get::<Transform>(body).unwrap();
    let particles: Vec<Vec3> =
        particles_of(&app, body).iter().map(|&p| position(&app, p)).collect();
    let skin = mesh_of(&app, body);
    assert_eq!(skin.len(), 21 * 9);
    for (vertex, &place) in skin.iter().enumerate() {
        let away = (frame * place).distance(particles[vertex / 9]);
        assert!((away - 0.03).abs() < 1e-4, "{away}");
    }
}

/// The mesh of a tube around loose particles at rest.
fn tube(places: &[Vec3], radius: f32, sides: u32) -> Mesh {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let world = app.world_mut();
    let particles = places.iter().map(|&at| world.spawn(Particle::at(at)).id()).collect();
    let tube = world.spawn(TubeMesh { particles, radius, sides }).id();
    tick(&mut app, 2);
    let handle = &app.world().get::<Mesh3d>(tube).expect("it has a mesh").0;
    app.world().resource::<Assets<Mesh>>().get(handle).expect("its mesh is there").clone()
}

#[test]
fn a_tube_stays_at_its_radius_and_faces_outwards() {
    let middle: Vec<Vec3> =
        (0..20).map(|i| Vec3::new(i as f32 * 0.1, (i as f32 * 0.3).sin() * 0.2, 0.0)).collect();
    let mesh = tube(&middle, 0.03, 8);
    let positions = vertices(&mesh);
    assert_eq!(positions.len(), 20 * 9);
    for (i, position) in positions.iter().enumerate() {
        let distance = position.distance(middle[i / 9]);
        assert!((distance - 0.03).abs() < 1e-5);
    }
    let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).and_then(|list| list.as_float3()).unwrap();
    let indices: Vec<usize> = mesh.indices().unwrap().iter().collect();
    // The sides, without the caps at the ends.
    assert!(indices.len() > 3 * 19 * 16);
    for t in indices.chunks(3).take(19 * 16) {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| positions[i]);
        let outwards = Vec3::from(normals[t[0]]);
        assert!((b - a).cross(c - a).dot(outwards) > 0.0);
    }
}

#[test]
fn coincident_points_leave_a_tube_finite_and_a_single_point_shows_nothing() {
    let mesh = tube(&[Vec3::ZERO, Vec3::ZERO, Vec3::Y, Vec3::ZERO], 0.1, 5);
    assert_eq!(vertices(&mesh).len(), 4 * 6);
    assert!(vertices(&mesh).iter().all(|place| place.is_finite()));
    // Not a mesh without vertices, for which Bevy's renderer reports an error.
    let alone = tube(&[Vec3::Y], 0.1, 5);
    assert_eq!(vertices(&alone), [Vec3::Y; 3]);
    assert_eq!(alone.indices().map(Indices::len), Some(3));
}

/// Regression: the first mesh of a rope was empty, so that in a window each rope logged "Use-after-free: attempted to copy element data for an unallocated key"
/// when it was spawned.
#[test]
fn the_first_mesh_of_a_rope_has_vertices() {
    let mut app = app();
    let particles = [Vec3::ZERO, Vec3::X].map(|at| app.world_mut().spawn(Particle::at(at)).id());
    let tube = TubeMesh { particles: particles.to_vec(), radius: 0.1, sides: 5 };
    let tube = app.world_mut().spawn(tube).id();
    let rope = app.world_mut().spawn(Rope::default()).id();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    for frame in 0..4 {
        app.update();
        for entity in [tube, rope] {
            let Some(handle) = app.world().get::<Mesh3d>(entity) else { continue };
            let meshes = app.world().resource::<Assets<Mesh>>();
            assert!(!vertices(meshes.get(&handle.0).unwrap()).is_empty(), "frame {frame}");
        }
    }
}

#[test]
fn a_cloth_that_is_spawned_in_a_pause_is_drawn_where_it_is() {
    let mut app = app();
    app.insert_resource(SinewControl { paused: true, ..default() });
    let cloth = app.world_mut().spawn((Cloth::default(), Transform::from_xyz(1.0, 2.0, 3.0))).id();
    let rope = app.world_mut().spawn(Rope::default()).id();
    tick(&mut app, 3);
    assert!(mesh_error(&app, cloth) < 1e-5, "{}", mesh_error(&app, cloth));
    assert_eq!(mesh_of(&app, rope).len(), 21 * 9);
}

#[test]
fn an_interpolated_cloth_is_drawn_between_the_last_two_ticks() {
    let mut app = app();
    let fall = |eased: bool, app: &mut App| {
        // Both in the same place.
        let mut body =
            app.world_mut().spawn((Cloth::default(), ContactsDisabled, Transform::default()));
        if eased {
            body.insert(Interpolate);
        }
        body.id()
    };
    let (eased, plain) = (fall(true, &mut app), fall(false, &mut app));
    tick(&mut app, 30);
    let top = |app: &App, body| mesh_of(app, body)[0].y;
    let overstep = |app: &App| app.world().resource::<Time<Fixed>>().overstep_fraction();
    // Frames of a fifth of a tick.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK / 5));
    let mut drawn = Vec::new();
    for _ in 0..10 {
        let before = app.world().resource::<SinewClock>().tick;
        let last = position(&app, particles_of(&app, eased)[0]).y;
        app.update();
        let now = position(&app, particles_of(&app, eased)[0]).y;
        if app.world().resource::<SinewClock>().tick > before {
            let expected = last + (now - last) * overstep(&app);
            assert!((top(&app, eased) - expected).abs() < 1e-4, "{} {expected}", top(&app, eased));
        }
        assert!((top(&app, plain) - now).abs() < 1e-5, "the other one jumps from tick to tick");
        drawn.push(top(&app, eased));
    }
    let steps: Vec<f32> = drawn.windows(2).map(|pair| pair[0] - pair[1]).collect();
    assert!(steps.iter().all(|&step| step > 0.0), "it falls in every frame: {steps:?}");
    let (least, most) =
        (steps.iter().copied().fold(f32::MAX, f32::min), steps.iter().copied().fold(0.0, f32::max));
    assert!(most < 1.5 * least, "and evenly: {steps:?}");
}

#[test]
fn interpolating_the_transform_of_a_box_does_not_change_the_simulation() {
    let run = |eased: bool| {
        let mut app = app();
        let mut body =
            app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(0.0, 5.0, 0.0)));
        if eased {
            body.insert(Interpolate);
        }
        let body = body.id();
        tick(&mut app, 10);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK / 4));
        let mut heights = Vec::new();
        for _ in 0..40 {
            app.update();
            heights.push(app.world().get::<Transform>(body).unwrap().translation.y);
        }
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
        let states =
            particles_of(&app, body).into_iter().map(|p| *app.world().get::<Particle>(p).unwrap());
        (states.collect::<Vec<_>>(), heights)
    };
    let ((eased, glide), (plain, jumps)) = (run(true), run(false));
    assert_eq!(eased, plain, "it is only drawn differently");
    let moves = |heights: &[f32]| heights.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert!(moves(&glide) >= 38, "{glide:?}");
    assert!(moves(&jumps) <= 11, "{jumps:?}");
}

#[test]
fn a_loose_ball_is_drawn_where_its_particle_is() {
    let mut app = app();
    let ball =
        app.world_mut().spawn((Particle::at(Vec3::new(1.0, 5.0, 2.0)), Transform::default())).id();
    tick(&mut app, 20);
    let drawn = app.world().get::<Transform>(ball).unwrap().translation;
    assert_eq!(drawn, position(&app, ball));
    assert!(drawn.y < 5.0 && drawn.x == 1.0);
}

#[test]
fn normals_are_perpendicular_to_the_surface_in_a_stretched_or_mirrored_frame() {
    for scale in
        [Vec3::ONE, Vec3::new(1.0, 1.0, 4.0), Vec3::new(0.5, 3.0, 1.0), Vec3::new(-1.0, 1.0, 1.0)]
    {
        let mut app = app();
        let cloth =
            app.world_mut().spawn((Cloth::grid(1.0, 1.0, 3, 3), Transform::from_scale(scale))).id();
        tick(&mut app, 1);
        app.world_mut().resource_mut::<SinewControl>().paused = true;
        for particle in particles_of(&app, cloth) {
            let mut particle = app.world_mut().get_mut::<Particle>(particle).unwrap();
            particle.position.z = particle.position.y + 0.5 * particle.position.x;
        }
        tick(&mut app, 2);
        let handle = &app.world().get::<Mesh3d>(cloth).unwrap().0;
        let mesh = app.world().resource::<Assets<Mesh>>().get(handle).unwrap();
        let at = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
        let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).unwrap().as_float3().unwrap();
        let corners: Vec<usize> = mesh.indices().unwrap().iter().collect();
        for corners in corners.chunks(3) {
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(|i| Vec3::from(at[i]));
            let face = (b - a).cross(c - a).normalize();
            let normal = Vec3::from(normals[corners[0]]);
            assert!(normal.dot(face) > 0.999, "{scale}: {normal} on a face of {face}");
        }
    }
}

/// What the game is to do in its next `FixedUpdate`.
#[derive(Resource, Default)]
struct Next(Option<fn(&mut World, Entity)>, Option<Entity>);

/// A world without gravity in which `Next` is done, and something in it that has been drawn for some ticks at this speed and is within a tick: `lead` fifths of a
/// tick after one.
fn drawn_at_speed(
    speed: f32,
    lead: usize,
    spawn: impl FnOnce(&mut World) -> Entity,
) -> (App, Entity) {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).init_resource::<Next>();
    app.add_systems(FixedUpdate, |world: &mut World| {
        let Next(go, body) = core::mem::take(&mut *world.resource_mut::<Next>());
        go.into_iter().zip(body).for_each(|(go, body)| go(world, body));
    });
    let body = spawn(app.world_mut());
    tick(&mut app, 5);
    app.world_mut().resource_mut::<SinewControl>().relative_speed = speed;
    tick(&mut app, 5);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK / 5));
    (0..lead).for_each(|_| app.update());
    (app, body)
}

/// The places at which a body is drawn: of its parts, or of its mesh, or its own.
fn drawn_places(app: &App, body: Entity) -> Vec<Vec3> {
    let parts = app.world().get::<bevy_sinew::BodyParts>(body);
    let drawn: Vec<Entity> = parts.map_or_else(|| vec![body], |parts| parts.iter().collect());
    let place = |one: Entity| app.world().get::<Transform>(one).unwrap().translation;
    if app.world().get::<MeshFollow>(body).is_some() {
        mesh_of(app, body).into_iter().map(|at| place(body) + at).collect()
    } else {
        drawn.into_iter().map(place).collect()
    }
}

/// Regression: a teleport that the game writes in `FixedUpdate` was drawn as a glide over a whole tick; so were the limbs of a ragdoll, whenever it was written.
#[test]
fn an_interpolated_body_that_is_teleported_is_never_drawn_on_the_way() {
    const FAR: Vec3 = Vec3::new(30.0, 0.0, 0.0);
    /// A frame in which that is the same.
    fn turned(world: &mut World) -> Entity {
        world.spawn(Transform::from_rotation(Quat::from_rotation_x(0.3))).id()
    }
    type Spawn = fn(&mut World) -> Entity;
    let bodies: [(&str, Spawn); 6] = [
        ("a box", |world| world.spawn((RigidBox::default(), Interpolate)).id()),
        ("a box in a frame", |world| {
            let parent = turned(world);
            world.spawn((RigidBox::default(), Interpolate, ChildOf(parent))).id()
        }),
        ("a ragdoll", |world| world.spawn((Ragdoll::default(), Interpolate)).id()),
        ("a ragdoll in a frame", |world| {
            let parent = turned(world);
            world.spawn((Ragdoll::default(), Interpolate, ChildOf(parent))).id()
        }),
        ("a cloth", |world| world.spawn((Cloth::grid(1.0, 1.0, 4, 4), Interpolate)).id()),
        ("a particle", |world| {
            world.spawn((Particle::at(Vec3::ZERO), Transform::default(), Interpolate)).id()
        }),
    ];
    type Move = fn(&mut World, Entity);
    let moves: [(&str, Move); 2] = [
        // Only particles are moved by their own place.
        ("a component", |world, body| match world.get_mut::<Particle>(body) {
            Some(mut particle) => particle.position += FAR,
            None => world.get_mut::<Transform>(body).unwrap().translation += FAR,
        }),
        ("a command", |world, body| {
            let at = *world.get::<Transform>(body).unwrap();
            let to = at.with_translation(at.translation + FAR);
            world.entity_mut(body).teleport(to);
        }),
    ];
    // At a speed of its own, the simulation takes a tick in some fixed ticks, and none or several in others.
    let times = [(1.0, 7), (0.4, 7), (0.4, 12), (0.4, 17), (2.5, 7), (2.5, 12)];
    let mut glides = Vec::new();
    for (name, spawn) in bodies {
        for ((how, go), fixed) in moves.into_iter().flat_map(|go| [(go, true), (go, false)]) {
            for (speed, lead) in times {
                let (mut app, body) = drawn_at_speed(speed, lead, spawn);
                if fixed {
                    app.insert_resource(Next(Some(go), Some(body)));
                } else {
                    go(app.world_mut(), body);
                }
                for frame in 0..25 {
                    app.update();
                    for at in drawn_places(&app, body) {
                        if at.length() > 2.0 && at.distance(FAR) > 2.0 {
                            glides.push(format!(
                                "{name}, {how}, fixed {fixed}, speed {speed} after {lead}, frame {frame}: {at}"
                            ));
                        }
                    }
                }
                let all = drawn_places(&app, body);
                assert!(all.iter().all(|at| at.x > 20.0), "{name} {how}: it was moved");
            }
        }
    }
    assert!(
        glides.is_empty(),
        "{} places on the way, for instance {:#?}",
        glides.len(),
        &glides[..glides.len().min(12)]
    );
}

/// A parent that moves is no teleport: the body in it, and its limbs, are drawn on the way.
#[test]
fn an_interpolated_body_in_a_moving_frame_is_drawn_moving_evenly() {
    const STEP: f32 = 0.1;
    for speed in [1.0, 0.4] {
        let mut frame = Entity::PLACEHOLDER;
        let (mut app, body) = drawn_at_speed(speed, 7, |world| {
            frame = world.spawn(Transform::default()).id();
            world.spawn((Ragdoll::default(), Interpolate, ChildOf(frame))).id()
        });
        app.add_systems(FixedUpdate, move |mut frames: Query<&mut Transform>| {
            frames.get_mut(frame).unwrap().translation.x += STEP;
        });
        (0..10).for_each(|_| app.update());
        let mut before = drawn_places(&app, body);
        for _ in 0..25 {
            app.update();
            let now = drawn_places(&app, body);
            for (from, to) in before.iter().zip(&now) {
                let way = to.x - from.x;
                assert!((way - STEP / 5.0).abs() < STEP / 50.0, "at speed {speed}: {way} m");
            }
            before = now;
        }
    }
}
