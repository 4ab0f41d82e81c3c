//! Impulses, velocities, teleports and reversal of bodies, parts and particles have exactly the documented effect, or none.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyPart, BodyParts, BoxParticles, PendingEdits, RigidPose, WorldCenterOfMass};

use crate::support::{
    app, bare_app, bits, fnv, hash, hash_of, heard, mesh_of, particles_of, position, tick,
};

/// An impulse, N·s, or a velocity, m/s.
pub(crate) const PUSH: Vec3 = Vec3::new(12.0, -5.0, 3.0);
/// An angular velocity, rad/s.
pub(crate) const SPIN: Vec3 = Vec3::new(0.4, 2.0, -1.0);

/// An app without gravity and without air drag.
pub(crate) fn space() -> App {
    weightless(bare_app())
}

fn weightless(mut app: App) -> App {
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    app
}

/// A solid brick of 1 × 2 × 3 m and 6 kg.
pub(crate) fn brick() -> RigidBox {
    let particles = BoxParticles::Equimomental;
    RigidBox { size: Vec3::new(1.0, 2.0, 3.0), mass: 6.0, particles, ..default() }
}

/// Spawns a recipe and runs the tick that builds it.
pub(crate) fn built(app: &mut App, recipe: impl Bundle, at: Transform) -> Entity {
    let body = app.world_mut().spawn((recipe, at)).id();
    tick(app, 1);
    assert!(!particles_of(app, body).is_empty());
    body
}

/// Queues commands on an entity and applies them.
pub(crate) fn command(app: &mut App, entity: Entity, edits: impl FnOnce(&mut EntityCommands)) {
    let world = app.world_mut();
    edits(&mut world.commands().entity(entity));
    world.flush();
}

/// Mass, momentum and angular momentum about `about`, of some particles.
pub(crate) fn momenta(app: &App, particles: &[Entity], about: Vec3) -> (f64, DVec3, DVec3) {
    let (mut mass, mut p, mut l) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for &entity in particles {
        let particle = app.world().get::<Particle>(entity).unwrap();
        let m = f64::from(app.world().get::<Mass>(entity).unwrap().0);
        let arm = (particle.position - about).as_dvec3() + particle.remainder.as_dvec3();
        let momentum = particle.velocity.as_dvec3() * m;
        (mass, p, l) = (mass + m, p + momentum, l + arm.cross(momentum));
    }
    (mass, p, l)
}

fn velocity(app: &App, particle: Entity) -> Vec3 {
    app.world().get::<Particle>(particle).unwrap().velocity
}

#[test]
fn impulses_change_momentum_and_angular_momentum_exactly_near_and_far() {
    for at in [Vec3::ZERO, Vec3::new(5000.0, 20.0, -3000.0)] {
        let mut app = space();
        let turned = Transform::from_translation(at).with_rotation(Quat::from_rotation_z(0.7));
        let body = built(&mut app, brick(), turned);
        let all = particles_of(&app, body);
        command(&mut app, body, |body| _ = body.set_motion(Vec3::X, SPIN));
        tick(&mut app, 10);

        let (_, p0, l0) = momenta(&app, &all, at);
        command(&mut app, body, |body| _ = body.apply_impulse(PUSH));
        let (mass, p1, l1) = momenta(&app, &all, at);
        assert!((mass - 6.0).abs() < 1e-6 && (p1 - p0 - PUSH.as_dvec3()).length() < 1e-5);
        // The centre of mass is near `at`, not at it: the body has moved.
        let centre = app.world().get::<WorldCenterOfMass>(body).unwrap().position - at;
        let lever = centre.as_dvec3().cross(PUSH.as_dvec3());
        let rounding = if at == Vec3::ZERO { 1e-5 } else { 1e-2 };
        assert!((l1 - l0 - lever).length() < rounding, "no spin of its own: {}", l1 - l0 - lever);

        command(&mut app, body, |body| _ = body.apply_angular_impulse(PUSH));
        let (_, p2, l2) = momenta(&app, &all, at);
        assert!((p2 - p1).length() < 1e-5, "no push: {}", p2 - p1);
        assert!((l2 - l1 - PUSH.as_dvec3()).length() < 2e-5, "{}", l2 - l1);

        let point = Vec3::new(0.5, 3.0, -1.0);
        command(&mut app, body, |body| _ = body.apply_impulse_at(PUSH, at + point));
        let (_, p3, l3) = momenta(&app, &all, at);
        assert!((p3 - p2 - PUSH.as_dvec3()).length() < 1e-5);
        let lever = point.as_dvec3().cross(PUSH.as_dvec3());
        assert!((l3 - l2 - lever).length() < 3e-5, "{}", l3 - l2 - lever);
        assert_eq!(heard(&app), []);
    }
}

#[test]
fn an_impulse_shows_in_the_velocities_after_the_next_tick() {
    let mut app = space();
    let body = built(&mut app, brick(), Transform::default());
    command(&mut app, body, |body| _ = body.apply_impulse(PUSH).apply_angular_impulse(Vec3::Z));
    tick(&mut app, 1);
    let linear = app.world().get::<LinearVelocity>(body).unwrap().0;
    assert!(linear.abs_diff_eq(PUSH / 6.0, 1e-5), "{linear}");
    // About z: 6/12 · (1 + 4) kg·m².
    let spin = app.world().get::<AngularVelocity>(body).unwrap().0;
    assert!(spin.abs_diff_eq(Vec3::Z / 2.5, 1e-4), "{spin}");
}

#[test]
fn set_velocities_are_read_back_and_leave_the_other_one_unchanged() {
    let mut app = space();
    let body = built(&mut app, brick(), Transform::from_xyz(3.0, 0.0, 0.0));
    let read = |app: &App| {
        let (linear, spin) = (app.world().get::<LinearVelocity>(body), app.world().get(body));
        (linear.unwrap().0, spin.map_or(Vec3::NAN, |spin: &AngularVelocity| spin.0))
    };
    command(&mut app, body, |body| _ = body.set_motion(Vec3::Y, SPIN * 0.2));
    tick(&mut app, 1);
    let (linear, spin) = read(&app);
    assert!(linear.abs_diff_eq(Vec3::Y, 1e-5) && spin.abs_diff_eq(SPIN * 0.2, 2e-3), "{spin}");

    command(&mut app, body, |body| _ = body.set_linear_velocity(PUSH));
    tick(&mut app, 1);
    let (linear, after) = read(&app);
    assert!(linear.abs_diff_eq(PUSH, 1e-5) && after.abs_diff_eq(spin, 5e-3), "{spin} {after}");

    command(&mut app, body, |body| _ = body.set_angular_velocity(Vec3::Z));
    tick(&mut app, 1);
    let (linear, spin) = read(&app);
    assert!(linear.abs_diff_eq(PUSH, 1e-5) && spin.abs_diff_eq(Vec3::Z, 2e-3), "{linear} {spin}");

    command(&mut app, body, |body| _ = body.set_motion(Vec3::ZERO, Vec3::ZERO));
    let still = particles_of(&app, body).into_iter().all(|p| velocity(&app, p) == Vec3::ZERO);
    assert!(still, "at rest, every particle of it");
}

#[test]
fn a_velocity_set_in_free_fall_applies_now_and_not_half_a_substep_ago() {
    let mut app = bare_app();
    app.insert_resource(AirDrag(0.0)).insert_resource(SolverConfig { substeps: 1, ..default() });
    let body = built(&mut app, brick(), Transform::default());
    tick(&mut app, 30);
    command(&mut app, body, |body| _ = body.set_linear_velocity(Vec3::ZERO));
    let from = app.world().get::<WorldCenterOfMass>(body).unwrap().position.y;
    tick(&mut app, 60);
    let fallen = app.world().get::<WorldCenterOfMass>(body).unwrap().position.y - from;
    let seconds = 60.0 * app.world().resource::<Time<Fixed>>().timestep().as_secs_f32();
    assert!((fallen + 0.5 * 9.81 * seconds * seconds).abs() < 1e-4, "{fallen}");
}

#[test]
fn a_teleport_does_the_same_as_moving_the_transform_bit_for_bit() {
    let to = Transform::from_xyz(400.0, 7.0, -2.0).with_rotation(Quat::from_rotation_x(1.2));
    let run = |by_command: bool| {
        let mut app = space();
        let body = built(&mut app, brick(), Transform::from_xyz(1.0, 2.0, 3.0));
        command(&mut app, body, |body| _ = body.set_motion(PUSH, SPIN));
        tick(&mut app, 20);
        if by_command {
            command(&mut app, body, |body| _ = body.teleport(to));
        } else {
            *app.world_mut().get_mut::<Transform>(body).unwrap() = to;
        }
        tick(&mut app, 20);
        (hash(&mut app), hash_of(&app, &[body]), heard(&app))
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_teleport_takes_effect_at_once_and_keeps_velocities_and_the_shape() {
    let mut app = space();
    let body = built(&mut app, brick(), Transform::from_xyz(1.0, 2.0, 3.0));
    command(&mut app, body, |body| _ = body.set_motion(PUSH, SPIN));
    tick(&mut app, 20);
    let all = particles_of(&app, body);
    let state = |app: &App| -> Vec<Particle> {
        all.iter().map(|&p| *app.world().get::<Particle>(p).unwrap()).collect()
    };
    let (before, frame) = (state(&app), *app.world().get::<Transform>(body).unwrap());

    let by = Vec3::new(7.0, -100.0, 0.25);
    command(&mut app, body, |body| _ = body.displace(by));
    for (old, new) in before.iter().zip(state(&app)) {
        assert!(new.position.abs_diff_eq(old.position + by, 1e-5));
        assert_eq!((new.velocity, new.lag), (old.velocity, old.lag), "every bit");
    }
    let moved = *app.world().get::<Transform>(body).unwrap();
    assert_eq!(moved, Transform { translation: frame.translation + by, ..frame });

    // Turned about its centre of mass: that stays where it is, spin and velocity turn with the body.
    let (_, momentum, _) = momenta(&app, &all, Vec3::ZERO);
    let quarter = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2);
    command(&mut app, body, |body| _ = body.turn(quarter));
    let (_, turned, _) = momenta(&app, &all, Vec3::ZERO);
    assert!((turned - (quarter * momentum.as_vec3()).as_dvec3()).length() < 1e-4);
    let after = app.world().get::<Transform>(body).unwrap();
    assert!(after.translation.abs_diff_eq(moved.translation, 2e-4), "its frame is centred");
    assert!(after.rotation.angle_between(quarter * moved.rotation) < 1e-3);
    tick(&mut app, 5);
    let report = app.world().resource::<SinewWorld>().report().clone();
    assert!(report.strain < 1e-3, "nothing was strained by it: {report:?}");
}

#[test]
fn a_teleport_moves_the_mesh_of_cloth() {
    let mut app = weightless(app());
    let cloth = built(&mut app, Cloth::grid(1.0, 0.5, 6, 4), Transform::from_xyz(0.0, 2.0, 0.0));
    app.update();
    let vertices = |app: &App| -> Vec<Vec3> {
        let frame = *app.world().get::<Transform>(cloth).unwrap();
        mesh_of(app, cloth).into_iter().map(|v| frame.transform_point(v)).collect()
    };
    let before = vertices(&app);
    command(&mut app, cloth, |cloth| _ = cloth.displace(Vec3::new(0.0, 0.0, 7.0)));
    tick(&mut app, 2);
    app.update();
    for (old, new) in before.iter().zip(vertices(&app)) {
        assert!(new.abs_diff_eq(*old + Vec3::Z * 7.0, 1e-4), "{old} {new}");
    }
}

#[test]
fn an_edit_after_a_transform_was_moved_by_hand_acts_where_it_is_now() {
    let mut app = space();
    let body = built(&mut app, brick(), Transform::default());
    app.world_mut().get_mut::<Transform>(body).unwrap().translation.x = 50.0;
    // Through the centre of mass, so without spin.
    command(&mut app, body, |body| _ = body.apply_impulse_at(Vec3::Y * 6.0, Vec3::X * 50.0));
    tick(&mut app, 1);
    let spin = app.world().get::<AngularVelocity>(body).unwrap().0;
    let at = app.world().get::<Transform>(body).unwrap().translation;
    assert!(spin.length() < 1e-4, "{spin}");
    assert!((at.x - 50.0).abs() < 1e-4 && (at.y - 1.0 / 60.0).abs() < 1e-4, "{at}");
}

#[test]
fn a_reversed_body_tumbles_back_to_where_it_came_from() {
    let mut app = bare_app();
    app.insert_resource(AirDrag(0.0));
    let config = SolverConfig { max_sweeps: 60, tolerance: 1e-7, ..default() };
    app.insert_resource(config);
    let start = Transform::from_xyz(0.0, 50.0, 0.0);
    let body = built(&mut app, brick(), start);
    command(&mut app, body, |body| _ = body.set_motion(Vec3::new(3.0, 8.0, 0.0), SPIN));
    tick(&mut app, 1);
    let all = particles_of(&app, body);
    let past: Vec<Vec3> =
        all.iter().map(|&p| app.world().get::<Particle>(p).unwrap().previous()).collect();
    tick(&mut app, 60);
    let there = position(&app, all[0]);
    assert!(there.distance(past[0]) > 3.0, "it went somewhere");
    command(&mut app, body, |body| _ = body.reverse());
    tick(&mut app, 60);
    for (&particle, past) in all.iter().zip(past) {
        let back = position(&app, particle);
        assert!(back.distance(past) < 1e-3, "{back} {past}");
    }
}

#[test]
fn a_particle_is_kicked_moved_and_turned_back_like_a_body() {
    let mut app = space();
    let stone = app.world_mut().spawn((Particle::at(Vec3::X), Mass(2.0))).id();
    app.world_mut().entity_mut(stone).apply_impulse_at(PUSH, Vec3::Y * 40.0);
    assert_eq!(velocity(&app, stone), PUSH / 2.0, "a point has no lever");
    app.world_mut().entity_mut(stone).set_linear_velocity(Vec3::Z).turn(Quat::from_rotation_x(1.0));
    assert_eq!(velocity(&app, stone), Vec3::Z, "and nothing to turn");
    let to = Transform::from_xyz(5.0, 6.0, 7.0).with_rotation(Quat::from_rotation_y(1.0));
    app.world_mut().entity_mut(stone).teleport(to).displace(Vec3::X);
    let particle = *app.world().get::<Particle>(stone).unwrap();
    assert_eq!((particle.position, particle.velocity), (Vec3::new(6.0, 6.0, 7.0), Vec3::Z));
    tick(&mut app, 1);
    app.world_mut().entity_mut(stone).reverse();
    assert_eq!(velocity(&app, stone), -Vec3::Z);
    assert_eq!(heard(&app), []);
}

#[test]
fn pinned_particles_are_moved_by_teleports_alone() {
    let mut app = space();
    let rope = built(&mut app, Rope::default(), Transform::from_xyz(0.0, 3.0, 0.0));
    let all = particles_of(&app, rope);
    let pinned: Vec<Entity> =
        all.iter().copied().filter(|&p| app.world().get::<Pinned>(p).is_some()).collect();
    let free: Vec<Entity> = all.iter().copied().filter(|p| !pinned.contains(p)).collect();
    assert!(!pinned.is_empty() && !free.is_empty());
    let (_, before, _) = momenta(&app, &free, Vec3::ZERO);
    command(&mut app, rope, |rope| _ = rope.apply_impulse(PUSH));
    let (_, after, _) = momenta(&app, &free, Vec3::ZERO);
    assert!((after - before - PUSH.as_dvec3()).length() < 1e-4, "all of it goes to the free ones");
    let edits = |rope: &mut EntityCommands| {
        rope.set_motion(PUSH, SPIN).apply_angular_impulse(PUSH).set_linear_velocity(SPIN).reverse();
    };
    let held = position(&app, pinned[0]);
    command(&mut app, rope, edits);
    assert_eq!((position(&app, pinned[0]), velocity(&app, pinned[0])), (held, Vec3::ZERO));
    command(&mut app, rope, |rope| _ = rope.displace(Vec3::X));
    assert_eq!(position(&app, pinned[0]), held + Vec3::X);
}

#[test]
fn a_rigid_part_of_a_ragdoll_is_pushed_by_itself() {
    let mut app = space();
    let doll = built(&mut app, Ragdoll::default(), Transform::from_xyz(0.0, 2.0, 0.0));
    let world = app.world_mut();
    let mut parts = world.query::<(Entity, &RigidPose, &BodyPart)>();
    let (head, pose, _) = parts.iter(world).next().unwrap();
    let own = pose.particles.clone();
    command(&mut app, head, |head| _ = head.apply_impulse(PUSH));
    let others: Vec<Entity> =
        particles_of(&app, doll).into_iter().filter(|p| !own.contains(p)).collect();
    let ((_, mine, _), (_, theirs, _)) =
        (momenta(&app, &own, Vec3::ZERO), momenta(&app, &others, Vec3::ZERO));
    assert!((mine - PUSH.as_dvec3()).length() < 1e-4 && theirs.length() < 1e-4, "{mine} {theirs}");
}

#[test]
fn edits_of_a_body_that_is_not_built_yet_are_applied_when_it_is() {
    let mut app = space();
    let body = app.world_mut().commands().spawn(brick()).apply_impulse(PUSH).id();
    app.world_mut().flush();
    command(&mut app, body, |body| _ = body.displace(Vec3::Y * 9.0).apply_angular_impulse(SPIN));
    let waiting = app.world().get::<PendingEdits>(body).unwrap().0.len();
    assert_eq!(waiting, 3);
    tick(&mut app, 1);
    assert_eq!(app.world().get::<PendingEdits>(body), Some(&PendingEdits::default()));
    let linear = app.world().get::<LinearVelocity>(body).unwrap().0;
    assert!(linear.abs_diff_eq(PUSH / 6.0, 1e-5), "{linear}");
    let at = app.world().get::<Transform>(body).unwrap().translation;
    assert!(at.abs_diff_eq(Vec3::Y * 9.0 + PUSH / 360.0, 1e-4), "{at}");
    assert_eq!(heard(&app), []);
}

/// A velocity that was written before a command of the same frame was applied after it, and replaced what the command had done: who set a running speed and then
/// jumped by an impulse did not jump.
#[test]
fn a_velocity_written_before_or_after_a_command_keeps_what_the_command_does() {
    let run = Vec3::new(3.0, 0.0, 0.0);
    let write = |app: &mut App, body: Entity| {
        let mut velocity = app.world_mut().get_mut::<LinearVelocity>(body).unwrap();
        velocity.0.x = run.x;
    };
    type Edit = fn(&mut EntityCommands);
    let cases: [(&str, Edit, Vec3, Vec3); 5] = [
        ("an impulse", |body| _ = body.apply_impulse(Vec3::Y * 30.0), run, Vec3::Y * 5.0),
        ("a velocity", |body| _ = body.set_linear_velocity(Vec3::Y), Vec3::ZERO, Vec3::Y),
        ("a spin", |body| _ = body.set_angular_velocity(Vec3::Y), run, Vec3::ZERO),
        ("a stop", |body| _ = body.set_motion(Vec3::ZERO, Vec3::ZERO), Vec3::ZERO, Vec3::ZERO),
        (
            "a turn",
            |body| _ = body.turn(Quat::from_rotation_y(-core::f32::consts::FRAC_PI_2)),
            Vec3::Z * 3.0,
            Vec3::ZERO,
        ),
    ];
    for (name, edit, kept, added) in cases {
        let mut app = space();
        let body = built(&mut app, brick(), Transform::default());
        write(&mut app, body);
        command(&mut app, body, edit);
        let velocity = |app: &App| app.world().get::<LinearVelocity>(body).unwrap().0;
        let at_once = velocity(&app);
        assert!(at_once.distance(kept + added) < 1e-4, "{name}: at once {at_once}");
        tick(&mut app, 2);
        let found = velocity(&app);
        assert!(found.distance(kept + added) < 1e-4, "{name}: {found}");
    }
    // In the other order, whether the body had a velocity or not.
    let mut app = space();
    let body = built(&mut app, brick(), Transform::default());
    command(&mut app, body, |body| _ = body.apply_impulse(Vec3::Y * 30.0));
    write(&mut app, body);
    tick(&mut app, 2);
    let found = app.world().get::<LinearVelocity>(body).unwrap().0;
    assert!(found.distance(run + Vec3::Y * 5.0) < 1e-4, "{found}");
    // A body that is not built yet starts with its velocity, and is pushed then.
    let body = (brick(), LinearVelocity(run), Transform::from_xyz(0.0, 0.0, 50.0));
    let body = app.world_mut().spawn(body).id();
    command(&mut app, body, |body| _ = body.apply_impulse(Vec3::Y * 30.0));
    tick(&mut app, 2);
    let found = app.world().get::<LinearVelocity>(body).unwrap().0;
    assert!(found.distance(run + Vec3::Y * 5.0) < 1e-4, "{found}");
}

/// A limb, and a particle of its own.
#[test]
fn a_velocity_written_before_a_limb_or_a_particle_is_pushed_is_kept() {
    let mut app = space();
    let figure = built(&mut app, Ragdoll::default(), Transform::default());
    let limb = app.world().get::<BodyParts>(figure).unwrap().iter().next().unwrap();
    let mass = app.world().get::<WorldCenterOfMass>(figure).unwrap().mass;
    app.world_mut().get_mut::<LinearVelocity>(figure).unwrap().0.x = 3.0;
    command(&mut app, limb, |limb| _ = limb.apply_impulse(Vec3::Y * mass));
    tick(&mut app, 1);
    let found = app.world().get::<LinearVelocity>(figure).unwrap().0;
    assert!(found.distance(Vec3::new(3.0, 1.0, 0.0)) < 0.01, "{found}");
    let marble = app.world_mut().spawn((Particle::default(), LinearVelocity(Vec3::ZERO))).id();
    tick(&mut app, 1);
    app.world_mut().get_mut::<LinearVelocity>(marble).unwrap().0.x = 3.0;
    command(&mut app, marble, |marble| _ = marble.apply_impulse(Vec3::Y));
    tick(&mut app, 1);
    let found = app.world().get::<LinearVelocity>(marble).unwrap().0;
    assert!(found.distance(Vec3::new(3.0, 1.0, 0.0)) < 1e-4, "{found}");
}

/// Between two ticks an interpolated body is drawn behind the place where it is. A command there took that for a move by the game: it moved the body back, turned
/// its velocities with it, and the tick moved it forward again, but not what the command had done. After four seconds of small pushes in every frame, a body that
/// tumbled was 0.1 m beside the same body without interpolation.
#[test]
fn a_command_acts_on_an_interpolated_body_as_on_any_other() {
    let motion = |eased: bool| {
        let mut app = weightless(app());
        let frame = core::time::Duration::from_micros(6_944);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
        let spin = (LinearVelocity(Vec3::X * 3.0), AngularVelocity(SPIN));
        let parent = app.world_mut().spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
        let [body, child] = [0.0, 9.0].map(|z| {
            let body = (brick(), spin, Transform::from_xyz(0.0, 0.0, z));
            app.world_mut().spawn(body).id()
        });
        app.world_mut().entity_mut(child).insert(ChildOf(parent));
        if eased {
            app.world_mut().entity_mut(body).insert(Interpolate);
            app.world_mut().entity_mut(child).insert(Interpolate);
        }
        let push = move |mut commands: Commands, time: Res<Time>| {
            for body in [body, child] {
                commands.entity(body).apply_impulse(Vec3::Y * time.delta_secs());
                commands.entity(body).displace(Vec3::Z * time.delta_secs());
            }
        };
        app.add_systems(Update, push);
        (0..600).for_each(|_| app.update());
        hash_of_particles(&app, &[body, child])
    };
    assert_eq!(motion(true), motion(false));
}

/// Hash of the particles of these bodies.
fn hash_of_particles(app: &App, bodies: &[Entity]) -> u64 {
    let particles = bodies.iter().flat_map(|&body| particles_of(app, body));
    fnv(particles.flat_map(|one| bits(app.world().get::<Particle>(one).unwrap())))
}
