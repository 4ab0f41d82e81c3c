//! Every force of the solver as a component or a resource: its effect agrees with physics, in the region where it applies.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AirFlow, Attractor, BoxParticles, Charge, Combine, Electric, ElectricField, Flatland,
    GroundDrag, HullShape, Refusal, Region, WindSurface,
};

use crate::support::{bare_app, heard, particles_of, position, tick};

/// An app without gravity and without drag.
fn space() -> App {
    let mut app = bare_app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    app
}

/// The same with gravity.
fn vacuum() -> App {
    let mut app = space();
    app.insert_resource(Gravity::default());
    app
}

/// A triangle of 0.5 m² and 0.3 kg about a point, perpendicular to the given axis. In an even wind its three particles move as one. Returns one of them.
fn sheet(app: &mut App, at: Vec3, axis: Vec3) -> Entity {
    let turn = Quat::from_rotation_arc(Vec3::Z, axis);
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| {
        let place = at + turn * (corner - Vec3::new(1.0, 1.0, 0.0) / 3.0);
        app.world_mut().spawn((Particle::at(place), Mass(0.1))).id()
    });
    app.world_mut().spawn(WindSurface { triangles: vec![corners] });
    corners[0]
}

fn velocity(app: &App, particle: Entity) -> Vec3 {
    app.world().get::<Particle>(particle).unwrap().velocity
}

fn close(found: f32, expected: f32, share: f32) {
    assert!((found / expected - 1.0).abs() < share, "{found} of {expected}");
}

#[test]
fn a_wind_in_a_region_blows_inside_it_alone_and_where_it_fades_by_its_share() {
    let mut app = space();
    let wind = Wind { pressure: Vec3::Z * 6.0, ..default() };
    let region = Region::sphere(2.0).with_fade(1.0);
    app.world_mut().spawn((wind, region, Transform::from_xyz(10.0, 0.0, 0.0)));
    let [inside, fading, outside] =
        [10.0, 11.5, 13.0].map(|x| sheet(&mut app, Vec3::X * x, Vec3::Z));
    tick(&mut app, 6);
    // 6 Pa on 0.5 m² for 0.1 s, on 0.3 kg; in the middle of the fade, half of that.
    close(velocity(&app, inside).z, 1.0, 0.02);
    close(velocity(&app, fading).z, 0.5, 0.02);
    assert_eq!(velocity(&app, outside), Vec3::ZERO);
}

#[test]
fn each_shape_of_a_region_turns_with_its_entity_and_follows_its_parents() {
    // Along the world's x axis when the entity is turned by a quarter about z, and 5 m up with its parent.
    let shapes = [
        Region::boxed(Vec3::new(1.0, 6.0, 1.0)),
        Region::cylinder(0.5, 6.0),
        Region::capsule(0.5, 5.0),
    ];
    for region in shapes {
        let mut app = space();
        let cart = app.world_mut().spawn(Transform::from_xyz(0.0, 5.0, 0.0)).id();
        let turned = Transform::from_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_2));
        app.world_mut().spawn((ElectricField::new(Vec3::Z), region, turned, ChildOf(cart)));
        let charge = |at| (Particle::at(at), Charge(1.0));
        let inside = app.world_mut().spawn(charge(Vec3::new(2.5, 5.0, 0.0))).id();
        let across = app.world_mut().spawn(charge(Vec3::new(0.0, 7.5, 0.0))).id();
        app.insert_resource(Electric { constant: 0.0, ..default() });
        tick(&mut app, 5);
        assert!(velocity(&app, inside).z > 0.05, "{region:?}");
        assert_eq!(velocity(&app, across), Vec3::ZERO, "{region:?}");
        assert_eq!(heard(&app), []);
    }
}

#[test]
fn an_air_flow_carries_a_sheet_to_its_terminal_speed() {
    let mut app = vacuum();
    let flow = app.world_mut().spawn(AirFlow::steady(Vec3::Y * 3.0)).id();
    let leaf = sheet(&mut app, Vec3::ZERO, Vec3::Y);
    // Weight m g against drag ½ρ C A v².
    let terminal = (2.0 * 0.3 * 9.81 / (1.225 * 1.28 * 0.5_f32)).sqrt();
    tick(&mut app, 300);
    close(velocity(&app, leaf).y, 3.0 - terminal, 1e-3);
    app.world_mut().get_mut::<AirFlow>(flow).unwrap().velocity = Vec3::ZERO;
    tick(&mut app, 300);
    close(velocity(&app, leaf).y, -terminal, 1e-3);
}

#[test]
fn a_current_carries_a_ball_and_only_in_its_pool() {
    let mut app = space();
    let pool = Region::boxed(Vec3::new(10.0, 6.0, 10.0));
    app.world_mut().spawn((Fluid::flowing(Vec3::X * 2.0), pool));
    let ball = |at: Vec3| (Particle::at(at), Radius(0.1));
    let wet = app.world_mut().spawn(ball(Vec3::Y * -1.0)).id();
    let dry = app.world_mut().spawn(ball(Vec3::Y * -4.0)).id();
    tick(&mut app, 60);
    // The difference of its velocity to the current shrinks by 0.8 each second.
    close(velocity(&app, wet).x, 1.6, 2e-3);
    assert_eq!(velocity(&app, dry), Vec3::ZERO);
}

/// Draft of a box of 1 × 0.6 × 1 m and 240 kg at rest in still water, as a share of its height.
fn draft(body: RigidBox, floats: Floats, flatland: bool) -> f32 {
    let mut app = bare_app();
    app.world_mut().spawn((Fluid { drag: 0.95, ..default() }, Transform::from_xyz(0.0, 2.0, 0.0)));
    if flatland {
        app.world_mut().spawn(Flatland);
    }
    let size = Vec3::new(1.0, 0.6, 1.0);
    let crate_ = RigidBox { size, mass: 240.0, ..body };
    let crate_ = app.world_mut().spawn((crate_, floats, Transform::from_xyz(3.0, 2.2, 0.0))).id();
    tick(&mut app, 900);
    assert_eq!(heard(&app), []);
    let frame = app.world().get::<Transform>(crate_).unwrap();
    assert!((frame.rotation * Vec3::Y).y > 0.9999, "upright: {frame:?}");
    (2.0 - (frame.translation.y - 0.3)) / 0.6
}

#[test]
fn a_box_of_each_kind_floats_at_the_draft_of_its_density() {
    let corners = RigidBox::default();
    let solid = RigidBox { particles: BoxParticles::Equimomental, ..default() };
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<_> =
        faces.iter().flat_map(|&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]]).collect();
    let half = Vec3::new(0.5, 0.3, 0.5);
    let corner = |i: u32| {
        half * Vec3::from([i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| 2.0 * bit as f32 - 1.0))
    };
    let mesh = Floats::mesh((0..8).map(corner).collect::<Vec<_>>(), triangles);
    let cases = [
        (corners.clone(), Floats::OWN, false),
        (solid.clone(), Floats::OWN, false),
        (corners.clone(), Floats { shape: HullShape::Surface }, false),
        (solid.clone(), Floats::boxed(2.0 * half), false),
        (solid.clone(), mesh, false),
        (RigidBox { flat: true, ..corners }, Floats::OWN, true),
        (RigidBox { flat: true, ..solid }, Floats::OWN, true),
    ];
    for (body, floats, flat) in cases {
        close(draft(body, floats, flat), 0.4, 0.01);
    }
}

#[test]
fn a_wide_raft_rights_itself() {
    let mut app = bare_app();
    app.world_mut().spawn((Fluid { drag: 0.9, ..default() }, Transform::default()));
    let raft = RigidBox::new(Vec3::new(3.0, 0.3, 2.0)).with_mass(900.0);
    let heeled = Transform::from_rotation(Quat::from_rotation_z(0.5) * Quat::from_rotation_x(-0.3));
    let raft = app.world_mut().spawn((raft, Floats::OWN, heeled)).id();
    tick(&mut app, 1200);
    let up = app.world().get::<Transform>(raft).unwrap().rotation * Vec3::Y;
    assert!(up.y > 0.9999, "{up}");
}

#[test]
fn without_its_hull_a_body_sinks_and_a_surface_may_lose_its_corners() {
    let mut app = bare_app();
    app.world_mut().spawn((Fluid::default(), Transform::default()));
    let body = RigidBox::default().with_mass(400.0);
    let body = app.world_mut().spawn((body, Floats { shape: HullShape::Surface })).id();
    tick(&mut app, 2);
    let hulls = |app: &App| app.world().resource::<SinewWorld>().simulation().forces.hulls.len();
    assert_eq!(hulls(&app), 1);
    let corner = particles_of(&app, body)[7];
    app.world_mut().despawn(corner);
    tick(&mut app, 2);
    assert_eq!(hulls(&app), 1, "the rest of the skin floats");
    let of_hulls = |(_, reason): &(Entity, Refusal)| matches!(reason, Refusal::Hull(_));
    assert!(!heard(&app).iter().any(of_hulls), "without a refusal");
    app.world_mut().entity_mut(body).remove::<Floats>();
    tick(&mut app, 120);
    assert_eq!(hulls(&app), 0);
    assert!(app.world().get::<Transform>(body).unwrap().translation.y < -5.0);
}

#[test]
fn an_orbit_about_an_attractor_closes() {
    let mut app = space();
    let sun = Attractor::new(200.0).with_softening(0.0);
    let cart = app.world_mut().spawn(Transform::from_xyz(0.0, 40.0, 0.0)).id();
    let sun = app.world_mut().spawn((sun, Transform::from_xyz(7.0, 0.0, 0.0), ChildOf(cart))).id();
    let (centre, start) = (Vec3::new(7.0, 40.0, 0.0), Vec3::new(12.0, 40.0, 0.0));
    let speed = (200.0 / 5.0_f32).sqrt();
    let planet = Particle::at(start).with_velocity(Vec3::Z * speed);
    let planet = app.world_mut().spawn((planet, Mass(3.0))).id();
    // T = 2π √(r³/GM) = 4.9673 s, which is 298.04 ticks.
    for _ in 0..298 {
        tick(&mut app, 1);
        close(position(&app, planet).distance(centre), 5.0, 1e-3);
    }
    assert!(position(&app, planet).distance(start) < 0.02, "{}", position(&app, planet));
    app.world_mut().despawn(sun);
    tick(&mut app, 1);
    let straight = velocity(&app, planet);
    tick(&mut app, 1);
    assert_eq!(velocity(&app, planet), straight, "nothing pulls any more");
}

#[test]
fn a_uniform_field_accelerates_a_charge_by_q_e_over_m() {
    let mut app = space();
    let field = Vec3::new(0.0, 3.0, -8.0);
    app.insert_resource(Electric { constant: 0.0, field, ..default() });
    app.world_mut().spawn((ElectricField::new(Vec3::X * 4.0), Region::sphere(5.0)));
    let ion = |x: f32| (Particle::at(Vec3::X * x), Charge(0.5), Mass(2.0));
    let [inside, outside] = [0.0, 20.0].map(|x| app.world_mut().spawn(ion(x)).id());
    tick(&mut app, 60);
    // The reported velocity is the mean over the last of ten substeps, thus that of half a substep earlier.
    let t = 1.0 - 0.5 / 600.0;
    assert!(velocity(&app, outside).abs_diff_eq(field * 0.25 * t, 1e-4));
    assert!(velocity(&app, inside).abs_diff_eq((field + Vec3::X * 4.0) * 0.25 * t, 1e-4));
}

#[test]
fn a_world_in_2d_stays_in_its_plane_and_falls_in_it() {
    let mut app = vacuum();
    let plane = app.world_mut().spawn(Flatland).id();
    app.world_mut().spawn(Wind { pressure: Vec3::Z * 50.0, ..default() });
    let thrown = Particle::at(Vec3::ZERO).with_velocity(Vec3::new(1.0, 0.0, 3.0));
    let stone = app.world_mut().spawn(thrown).id();
    let body = RigidBox { flat: true, ..default() };
    let body = app.world_mut().spawn((body, Transform::from_xyz(5.0, 0.0, 0.0))).id();
    let mut all = vec![stone];
    let apart = |app: &App, all: &[Entity], z: f32| {
        all.iter().map(|&p| (position(app, p).z - z).abs()).fold(0.0, f32::max)
    };
    for _ in 0..60 {
        tick(&mut app, 1);
        all.extend(particles_of(&app, body));
        assert!(apart(&app, &all, 0.0) < 1e-5);
    }
    let at = position(&app, stone);
    assert!(at.abs_diff_eq(Vec3::new(1.0, -0.5 * 9.81, 0.0), 1e-3), "{at}");
    // The particles follow the plane when it moves.
    *app.world_mut().get_mut::<Transform>(plane).unwrap() = Transform::from_xyz(0.0, 0.0, 0.25);
    tick(&mut app, 1);
    assert!(apart(&app, &all, 0.25) < 1e-5);
    app.world_mut().despawn(plane);
    tick(&mut app, 30);
    assert!(position(&app, all[1]).z > 0.3, "nothing holds it in a plane now");
}

#[test]
fn the_gravity_scale_of_bodies_and_particles_scales_their_fall() {
    let mut app = vacuum();
    let mut body = |x: f32, scale: f32| {
        let place = Transform::from_xyz(x, 0.0, 0.0);
        app.world_mut().spawn((RigidBox::default(), GravityScale(scale), place)).id()
    };
    let bodies = [body(0.0, 0.0), body(3.0, 1.0), body(6.0, 2.0)];
    let stones = [0.0, 1.0, 2.0].map(|scale| {
        let place = Particle::at(Vec3::Z * (5.0 + scale));
        app.world_mut().spawn((place, GravityScale(scale))).id()
    });
    tick(&mut app, 1);
    // The scales of a body and of its particles multiply.
    for particle in particles_of(&app, bodies[1]) {
        app.world_mut().entity_mut(particle).insert(GravityScale(2.0));
    }
    app.world_mut().get_mut::<GravityScale>(bodies[1]).unwrap().0 = 0.5;
    tick(&mut app, 29);
    let body = |i: usize| app.world().get::<Transform>(bodies[i]).unwrap().translation.y;
    let stone = |i: usize| position(&app, stones[i]).y;
    assert!(body(0).abs() < 1e-6 && stone(0) == 0.0, "{} {}", body(0), stone(0));
    for (fallen, scale) in [(body(1), 1.0), (body(2), 2.0), (stone(1), 1.0), (stone(2), 2.0)] {
        close(fallen, -0.5 * 9.81 * 0.25 * scale, 1e-3);
    }
}

#[test]
fn a_drag_along_the_ground_slows_a_sliding_block_by_its_share_each_second() {
    let mut app = bare_app();
    app.insert_resource(AirDrag(0.0));
    let drag = GroundDrag { along: 0.6, ..default() };
    let slippery =
        SurfaceMaterial { friction: 0.0, friction_rule: Combine::Min, drag, ..default() };
    app.world_mut().spawn((Ground, slippery));
    let block = Particle::at(Vec3::ZERO).with_velocity(Vec3::X * 3.0);
    let block = app.world_mut().spawn(block).id();
    tick(&mut app, 120);
    let speed = app.world().get::<Particle>(block).unwrap().velocity.x;
    assert!((speed / (3.0 * 0.4 * 0.4) - 1.0).abs() < 1e-3, "{speed}");
}
