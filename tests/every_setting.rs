//! Settings that no other suite covers: each integrator, order and gradient, steps of every length, rigid integrators, the plugin alone, phases with run
//! conditions, the drag of a ground, and bodies without a surface in a wind.

use core::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AirFlow, BodyParticles, Bulk, GradientAt, GroundDrag, Integrator, Order, PhaseSystems,
    Representation, RigidIntegrator, SinewClock, SinewPlugin, SubstepSchedule, WindSurface,
};

use crate::support::{
    TICK, app, assert_finite, busy_scene, hash, hash_of, particles_of, position, tick,
};

/// The plugin in `Update`, where a tick is as long as a frame.
fn stepped() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPlugin::in_schedule(Update)));
    app.finish();
    app.cleanup();
    app
}

#[test]
fn steps_of_any_length_one_after_the_other_fall_along_the_parabola() {
    for integrator in [Integrator::Verlet, Integrator::Leapfrog] {
        let mut app = stepped();
        app.insert_resource(AirDrag(0.0));
        app.world_mut().resource_mut::<SolverConfig>().integrator = integrator;
        let stone = app.world_mut().spawn(Particle::at(Vec3::ZERO)).id();
        for frame in 0..300_u64 {
            let hertz = [144.0, 60.0, 30.0, 59.0, 240.0, 24.0][(frame * frame % 6) as usize];
            let length = Duration::from_secs_f64(1.0 / hertz);
            app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
            app.update();
        }
        let seconds = app.world().resource::<SinewClock>().seconds;
        let fallen = f64::from(position(&app, stone).y);
        let expected = -0.5 * 9.81 * seconds * seconds;
        assert!(
            seconds > 2.0 && (fallen / expected - 1.0).abs() < 1e-4,
            "{integrator:?}: {fallen} {expected}"
        );
    }
}

#[test]
fn steps_of_any_length_leave_a_resting_box_in_place() {
    let mut app = stepped();
    app.world_mut().spawn(Ground);
    let body = (RigidBox::default(), Transform::from_xyz(0.0, 0.5, 0.0));
    let body = app.world_mut().spawn(body).id();
    for frame in 0..600_u64 {
        let hertz = [144.0, 60.0, 30.0, 59.0, 240.0, 24.0][(frame * frame % 6) as usize];
        let length = Duration::from_secs_f64(1.0 / hertz);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
        app.update();
        let lies = app.world().get::<Transform>(body).unwrap().translation;
        assert!((lies - Vec3::Y * 0.5).length() < 5e-3, "{frame}: {lies}");
    }
}

/// The step changes by up to a fifth from one frame to the next. With larger changes ropes whip: what a long step stretched, a short one draws in at once
/// (CHANGELOG, "Not yet").
#[test]
fn jittering_steps_leave_a_hanging_rope_in_place() {
    let mut app = stepped();
    let rope = (Rope::default(), Transform::from_xyz(3.0, 3.0, 0.0));
    let rope = app.world_mut().spawn(rope).id();
    for frame in 0..600_u64 {
        let hertz = [66.0, 60.0, 72.0, 63.0, 69.0, 61.0][(frame * frame % 6) as usize];
        let length = Duration::from_secs_f64(1.0 / hertz);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
        app.update();
    }
    let ends = particles_of(&app, rope);
    let long = position(&app, ends[0]).distance(position(&app, ends[ends.len() - 1]));
    assert!((long - 1.0).abs() < 0.01, "{long}");
}

#[test]
fn each_integrator_order_and_gradient_holds_a_box_a_rope_and_a_cloth() {
    for integrator in [
        Integrator::Verlet,
        Integrator::Leapfrog,
        Integrator::SemiImplicitEuler,
        Integrator::ExplicitEuler,
    ] {
        for order in [Order::GaussSeidel, Order::MostViolatedFirst, Order::Jacobi] {
            for gradient_at in [GradientAt::Current, GradientAt::StepStart] {
                let case = format!("{integrator:?} {order:?} {gradient_at:?}");
                let mut app = app();
                let config = SolverConfig { integrator, order, gradient_at, ..default() };
                let world = app.world_mut();
                world.insert_resource(config);
                world.spawn(Ground);
                let body = (RigidBox::default(), Transform::from_xyz(0.0, 0.6, 0.0));
                let body = world.spawn(body).id();
                let rope = (Rope::default(), Transform::from_xyz(3.0, 3.0, 0.0));
                let rope = world.spawn(rope).id();
                let cloth = Cloth::grid(1.0, 1.0, 6, 6).pinned(ClothPins::TopCorners);
                let cloth = world.spawn((cloth, Transform::from_xyz(-3.0, 3.0, 0.0))).id();
                tick(&mut app, 120);
                assert_finite(&mut app);
                let lies = app.world().get::<Transform>(body).unwrap().translation;
                assert!((lies.y - 0.5).abs() < 0.02, "{case}: {lies}");
                let ends = particles_of(&app, rope);
                let long = position(&app, ends[0]).distance(position(&app, ends[ends.len() - 1]));
                assert!((long - 1.0).abs() < 0.05, "{case}: {long}");
                let low = particles_of(&app, cloth)
                    .iter()
                    .map(|&p| position(&app, p).y)
                    .fold(9.0, f32::min);
                assert!((1.8..2.6).contains(&low), "{case}: {low}");
            }
        }
    }
}

#[test]
fn a_rigid_body_of_each_integrator_falls_spins_and_comes_to_rest() {
    for integrator in [RigidIntegrator::Euler, RigidIntegrator::Leapfrog, RigidIntegrator::Verlet] {
        let mut app = app();
        app.insert_resource(AirDrag(0.0));
        let body = (RigidBox::new(Vec3::new(0.4, 0.6, 0.8)), Representation::Rigid(integrator));
        let spin = AngularVelocity(Vec3::new(0.3, 2.0, 0.1));
        let body = (body, spin, Transform::from_xyz(0.0, 60.0, 0.0));
        let body = app.world_mut().spawn(body).id();
        tick(&mut app, 60);
        let seconds = app.world().resource::<SinewClock>().seconds as f32;
        let fallen = 60.0 - app.world().get::<Transform>(body).unwrap().translation.y;
        let expected = 0.5 * 9.81 * seconds * seconds;
        assert!((fallen / expected - 1.0).abs() < 0.005, "{integrator:?}: {fallen} {expected}");
        let spin = app.world().get::<AngularVelocity>(body).unwrap().0;
        assert!((spin.y - 2.0).abs() < 0.15, "{integrator:?}: {spin}");
        // And it comes to rest on a ground that is spawned where it is now.
        let below = app.world().get::<Transform>(body).unwrap().translation.y - 1.0;
        app.world_mut().spawn((Ground, Transform::from_xyz(0.0, below, 0.0)));
        app.world_mut().commands().entity(body).set_motion(Vec3::ZERO, Vec3::ZERO);
        tick(&mut app, 240);
        let still = app.world().get::<LinearVelocity>(body).unwrap().0.length();
        let high = app.world().get::<Transform>(body).unwrap().translation.y - below;
        assert!(still < 0.01 && (0.19..0.41).contains(&high), "{integrator:?}: {still} {high}");
    }
}

#[test]
fn the_plugin_alone_simulates_the_same_bits_as_the_group() {
    let mut alone = App::new();
    alone.add_plugins((MinimalPlugins, SinewPlugin::default()));
    alone.insert_resource(Time::<Fixed>::from_duration(TICK));
    alone.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    alone.finish();
    alone.cleanup();
    let mut grouped = app();
    busy_scene(&mut alone);
    busy_scene(&mut grouped);
    tick(&mut grouped, 60);
    while alone.world().resource::<SinewClock>().tick < 60 {
        alone.update();
    }
    assert_eq!(hash(&mut alone), hash(&mut grouped));
}

/// Regression: where no system of a game ran between phases, all substeps were taken at once and the conditions were never evaluated.
#[test]
fn a_run_condition_of_a_phase_is_evaluated_in_every_substep() {
    let mut app = app();
    app.insert_resource(AirDrag(0.0));
    app.configure_sets(
        SubstepSchedule,
        PhaseSystems::AccumulateForces.run_if(|mut evaluated: Local<u32>| {
            *evaluated += 1;
            *evaluated > 100
        }),
    );
    let stone = app.world_mut().spawn(Particle::at(Vec3::ZERO)).id();
    tick(&mut app, 10);
    assert_eq!(
        position(&app, stone),
        Vec3::ZERO,
        "no forces, no fall: 10 substeps in each of 10 ticks"
    );
    tick(&mut app, 30);
    // The velocity of a particle at rest counts as that at the middle of the previous substep (leapfrog), so it falls half a substep further at each instant.
    let (seconds, h) = (30.0 * TICK.as_secs_f32(), TICK.as_secs_f32() / 10.0);
    let expected = -0.5 * 9.81 * seconds * (seconds + h);
    let fallen = position(&app, stone).y;
    assert!((fallen / expected - 1.0).abs() < 1e-3, "{fallen} {expected}");
}

#[test]
fn a_wind_whose_phase_does_not_run_does_not_blow() {
    let drift = |blows: bool| {
        let mut app = app();
        app.insert_resource(Gravity(Vec3::ZERO));
        app.configure_sets(SubstepSchedule, PhaseSystems::Wind.run_if(move || blows));
        app.world_mut().spawn(Wind::default());
        let cloth = app.world_mut().spawn(Cloth::grid(1.0, 1.0, 4, 4)).id();
        let turned = Transform::from_rotation(Quat::from_rotation_y(core::f32::consts::FRAC_PI_2));
        app.world_mut().entity_mut(cloth).insert(turned);
        tick(&mut app, 30);
        particles_of(&app, cloth).iter().map(|&p| position(&app, p).x).sum::<f32>() / 25.0
    };
    assert!(drift(true) > 0.1);
    assert!(drift(false).abs() < 1e-3, "{}", drift(false));
}

#[test]
fn ground_drag_slows_a_sliding_box_by_its_share_each_second() {
    for along in [0.2_f32, 0.5, 0.9] {
        let mut app = app();
        app.insert_resource(AirDrag(0.0));
        let drag = GroundDrag { along, across: 0.0 };
        app.world_mut().spawn((Ground, SurfaceMaterial { drag, ..SurfaceMaterial::new(0.0) }));
        let slick = SurfaceMaterial::new(0.0);
        let body = (RigidBox::default(), slick, Transform::from_xyz(0.0, 0.5, 0.0));
        let body = app.world_mut().spawn((body, LinearVelocity(Vec3::X * 3.0))).id();
        tick(&mut app, 120);
        let velocity = app.world().get::<LinearVelocity>(body).unwrap().0;
        let seconds = app.world().resource::<SinewClock>().seconds as f32;
        let expected = 3.0 * (1.0 - along).powf(seconds);
        assert!((velocity.x - expected).abs() < 0.03 * 3.0, "{along}: {velocity} {expected}");
        assert!(velocity.yz().length() < 0.01, "{along}: {velocity}");
    }
}

/// A rope and a ragdoll: bodies without a surface of their own.
fn bare(app: &mut App) -> [Entity; 2] {
    let world = app.world_mut();
    let rope =
        world.spawn((Rope { pin_start: true, ..default() }, Transform::from_xyz(0.0, 3.0, 0.0)));
    let rope = rope.id();
    let figure = world.spawn((Ragdoll::default(), Transform::from_xyz(3.0, 3.0, 0.0))).id();
    [rope, figure]
}

#[test]
fn ropes_and_figures_have_no_surface_for_a_wind_but_air_flows_around_their_particles() {
    let run = |setup: fn(&mut World)| {
        let mut app = app();
        let bodies = bare(&mut app);
        setup(app.world_mut());
        tick(&mut app, 60);
        let middle = |body| {
            let all = particles_of(&app, body);
            all.iter().map(|&p| position(&app, p)).sum::<Vec3>() / all.len() as f32
        };
        (hash_of(&app, &bodies), bodies.map(middle))
    };
    let still = run(|_| {});
    let wind = run(|world| {
        world.spawn(Wind { pressure: Vec3::X * 60.0, ..default() });
    });
    assert_eq!(wind.0, still.0, "a wind passes them by, to the last bit");
    let air = run(|world| {
        world.spawn(AirFlow::steady(Vec3::X * 10.0));
    });
    for (blown, still) in air.1.iter().zip(&still.1) {
        assert!(blown.x - still.x > 1e-3, "air takes them along: {blown} {still}");
    }
}

#[test]
fn a_figure_that_is_given_a_surface_feels_the_wind() {
    let drift = |given: bool| {
        let mut app = app();
        app.insert_resource(Gravity(Vec3::ZERO));
        let [_, figure] = bare(&mut app);
        tick(&mut app, 1);
        let all: Vec<Entity> = app.world().get::<BodyParticles>(figure).unwrap().iter().collect();
        if given {
            let triangles = all.windows(3).map(|three| [three[0], three[1], three[2]]).collect();
            app.world_mut().entity_mut(figure).insert(WindSurface { triangles });
        }
        let middle = |app: &App| all.iter().map(|&p| position(app, p).z).sum::<f32>();
        let before = middle(&app);
        app.world_mut().spawn(Wind { pressure: Vec3::Z * 60.0, ..default() });
        tick(&mut app, 30);
        (middle(&app) - before) / all.len() as f32
    };
    assert!(drift(true) > 1e-3, "{}", drift(true));
    assert!(drift(false).abs() < 1e-4, "{}", drift(false));
}

/// The wind of the lectures uses the magnitude of each triangle's share without its sign, so the back of a closed body is pushed as much as its front.
#[test]
fn a_closed_body_feels_twice_its_silhouette() {
    for turn in
        [Quat::IDENTITY, Quat::from_rotation_y(0.6), Quat::from_euler(EulerRot::XYZ, 0.5, 0.4, 0.0)]
    {
        let mut app = app();
        app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
        let jelly =
            SoftBody { bulk: Bulk::Mass(5.0), ..SoftBody::cuboid(Vec3::ONE, UVec3::splat(2)) };
        let body = app.world_mut().spawn((jelly, Transform::from_rotation(turn))).id();
        app.world_mut().spawn(Wind { pressure: Vec3::X * 6.0, ..default() });
        tick(&mut app, 6);
        // Of a cube with unit faces: the projected area is the sum over its three axes.
        let silhouette: f32 =
            [Vec3::X, Vec3::Y, Vec3::Z].iter().map(|axis| (turn * *axis).x.abs()).sum();
        let seconds = app.world().resource::<SinewClock>().seconds as f32;
        let expected = 2.0 * 6.0 * silhouette / 5.0 * seconds;
        let velocity = app.world().get::<LinearVelocity>(body).unwrap().0;
        assert!((velocity.x / expected - 1.0).abs() < 0.03, "{turn}: {velocity} {expected}");
        assert!(velocity.yz().length() < 0.03 * expected, "{velocity}");
    }
}
