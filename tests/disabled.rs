//! An entity with Bevy's `Disabled` leaves the simulation with all that belongs to it, and comes back when it is enabled.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AirDrag, Articulated, BodyAttachments, BodyConstraints, BodyParts, Bone, Charge, CreationOrder,
    RopeEnd, SinewSnapshot,
};

use crate::saved::{future, game};
use crate::support::{TICK, app, assert_finite, hash_of, heard, particles_of, position, tick};

fn disable(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).insert(Disabled);
}

fn enable(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).remove::<Disabled>();
}

/// The number of particles, of links and of colliders in the solver.
fn solved(app: &App) -> [usize; 4] {
    let simulation = app.world().resource::<SinewWorld>().simulation();
    [
        simulation.particles.len(),
        simulation.distances().len() + simulation.constraints().len(),
        simulation.colliders.len(),
        simulation.body_colliders().len(),
    ]
}

fn height(app: &App, entity: Entity) -> f32 {
    app.world().get::<Transform>(entity).unwrap().translation.y
}

/// What a ray hits.
fn hit(app: &mut App, origin: Vec3, direction: Dir3) -> Option<Entity> {
    let cast =
        move |query: SinewQuery| query.cast_ray(Ray3d { origin, direction }, 10.0, &default());
    app.world_mut().run_system_once(cast).unwrap().map(|hit| hit.entity)
}

/// Regression: the particles of a disabled body stayed, without the body's settings and shape, and others ran into them. After its absence it moves as if there
/// had been none.
#[test]
fn a_disabled_body_of_any_recipe_leaves_the_simulation_and_comes_back_where_it_was() {
    let recipes: [(&str, fn(&mut World) -> Entity); 7] = [
        ("a box", |world| world.spawn(RigidBox::default()).id()),
        ("a mesh", |world| {
            let shape = RigidShape::Points(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]);
            world.spawn(RigidMesh::mass(1.0).shaped(shape)).id()
        }),
        ("a rope", |world| world.spawn(Rope { pin_start: false, ..default() }).id()),
        ("a cloth", |world| world.spawn(Cloth::grid(1.0, 1.0, 6, 6)).id()),
        ("a soft body", |world| world.spawn(SoftBody::cuboid(Vec3::ONE, UVec3::splat(2))).id()),
        ("a ragdoll", |world| world.spawn(Ragdoll::default()).id()),
        ("a post", |world| {
            world.spawn(Articulated::new([Bone::new("post", Vec3::Y, Vec3::ZERO)])).id()
        }),
    ];
    for (name, spawn) in recipes {
        let undisturbed = {
            let mut app = app();
            let body = spawn(app.world_mut());
            app.world_mut()
                .entity_mut(body)
                .insert((Transform::from_xyz(0.0, 3.0, 0.0), LinearVelocity(Vec3::X)));
            tick(&mut app, 16);
            hash_of(&app, &[body])
        };
        let mut app = app();
        let other =
            app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(9.0, 0.0, 0.0))).id();
        tick(&mut app, 1);
        let without = solved(&app);
        let body = spawn(app.world_mut());
        app.world_mut()
            .entity_mut(body)
            .insert((Transform::from_xyz(0.0, 3.0, 0.0), LinearVelocity(Vec3::X)));
        tick(&mut app, 5);
        let with = solved(&app);
        assert_ne!(with, without, "{name}");
        let members = particles_of(&app, body);
        let before = hash_of(&app, &[body]);

        disable(&mut app, body);
        tick(&mut app, 30);
        assert_eq!(solved(&app), without, "{name} is out");
        assert_eq!(hash_of(&app, &[body]), before, "{name} stays as it was");
        enable(&mut app, body);
        tick(&mut app, 1);
        assert_eq!(solved(&app), with, "{name} is back");
        assert_eq!(particles_of(&app, body), members, "and is not built again");
        let speed = app.world().get::<LinearVelocity>(body).unwrap().0;
        assert!((speed.x - 1.0).abs() < 0.1 && speed.y < -0.5, "{name} moves on at {speed}");
        assert!(height(&app, other) < -0.5);
        tick(&mut app, 10);
        assert_eq!(hash_of(&app, &[body]), undisturbed, "{name} moves as without its absence");
        assert_eq!(heard(&app), [], "{name}");
    }
}

#[test]
fn what_lies_on_a_disabled_body_falls_and_a_ray_passes_through() {
    for asleep in [false, true] {
        let mut app = app();
        let world = app.world_mut();
        world.spawn(Ground);
        let crate_at = |y: f32| {
            (RigidBox::new(Vec3::ONE), ContactEvents::Changes, Transform::from_xyz(0.0, y, 0.0))
        };
        let (lower, upper) = (world.spawn(crate_at(0.5)).id(), world.spawn(crate_at(1.5)).id());
        if asleep {
            world.entity_mut(lower).insert(Sleep::default());
            world.entity_mut(upper).insert(Sleep::default());
        }
        tick(&mut app, 200);
        let touched = |app: &App, one: Entity| {
            app.world().get::<bevy_sinew::Touching>(one).unwrap().0.clone()
        };
        assert!(touched(&app, upper).contains(&lower));
        let beside = Vec3::new(5.0, 0.5, 0.1);
        assert_eq!(hit(&mut app, beside, Dir3::NEG_X), Some(lower));

        disable(&mut app, lower);
        tick(&mut app, 60);
        assert!((height(&app, upper) - 0.5).abs() < 0.02, "it fell to {}", height(&app, upper));
        assert_eq!(hit(&mut app, beside, Dir3::NEG_X), Some(upper));
        assert!(!touched(&app, upper).contains(&lower));
        assert_eq!(touched(&app, lower), [], "its contacts ended");

        // Enabled beside it, where the game has put it in the meantime.
        app.world_mut().get_mut::<Transform>(lower).unwrap().translation = Vec3::new(3.0, 0.5, 0.0);
        enable(&mut app, lower);
        tick(&mut app, 60);
        assert!((height(&app, lower) - 0.5).abs() < 0.02, "it stands at {}", height(&app, lower));
        assert_eq!(hit(&mut app, beside, Dir3::NEG_X), Some(lower));
    }
}

#[test]
fn a_disabled_collider_lets_through_and_sweeps_nothing_along_when_it_comes_back() {
    // What lies on it is awake, or sleeps.
    for lies in [10, 60] {
        let mut app = app();
        let world = app.world_mut();
        let floor = Collider::cuboid(Vec3::new(4.0, 1.0, 4.0));
        let floor = world.spawn((floor, Transform::from_xyz(0.0, -0.5, 0.0))).id();
        let cube =
            world.spawn((RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(0.0, 0.2, 0.0))).id();
        tick(&mut app, lies);
        assert!(height(&app, cube) > 0.18);
        assert_eq!(app.world().get::<Sleep>(cube).unwrap().asleep, lies == 60);
        disable(&mut app, floor);
        tick(&mut app, 20);
        assert!(height(&app, cube) < -0.3, "{}", height(&app, cube));
        // Below it: a sweep from its former place would take it along.
        app.world_mut().get_mut::<Transform>(floor).unwrap().translation.y = -4.0;
        enable(&mut app, floor);
        tick(&mut app, 1);
        let speed = app.world().get::<LinearVelocity>(cube).unwrap().0;
        assert!(speed.y > -5.0, "it falls freely: {speed}");
        tick(&mut app, 90);
        assert!((height(&app, cube) + 3.3).abs() < 0.02, "{}", height(&app, cube));
    }
}

#[test]
fn a_constraint_to_a_disabled_particle_waits_and_one_that_is_disabled_itself_lets_go() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn((Particle::at(Vec3::ZERO), Pinned::HERE)).id();
    let bobs = [1.0, 2.0].map(|x| world.spawn(Particle::at(Vec3::X * x)).id());
    let rods = [1.0, 2.0].map(|rest| rest).into_iter().zip(bobs);
    let rods: Vec<Entity> = rods
        .map(|(rest, bob)| world.spawn(DistanceConstraint::new(hook, bob, rest)).id())
        .collect();
    tick(&mut app, 1);
    assert_eq!(solved(&app)[..2], [3, 2]);
    // The hook: both rods wait, without a message.
    disable(&mut app, hook);
    tick(&mut app, 10);
    assert_eq!(solved(&app)[..2], [2, 0]);
    enable(&mut app, hook);
    tick(&mut app, 1);
    assert_eq!(solved(&app)[..2], [3, 2]);
    // One rod, then in one tick the other instead: as many as before.
    disable(&mut app, rods[0]);
    tick(&mut app, 1);
    let far =
        |app: &App, i: usize| position(app, bobs[i]).distance(position(app, hook)) - (1 + i) as f32;
    tick(&mut app, 20);
    assert!(far(&app, 0) > 0.1 && far(&app, 1).abs() < 0.01, "{} {}", far(&app, 0), far(&app, 1));
    enable(&mut app, rods[0]);
    disable(&mut app, rods[1]);
    tick(&mut app, 120);
    assert!(far(&app, 0).abs() < 0.01 && far(&app, 1) > 0.5, "{} {}", far(&app, 0), far(&app, 1));
    assert_eq!(heard(&app), []);
}

#[test]
fn what_the_game_disabled_itself_stays_disabled_when_its_body_is_enabled() {
    let mut app = app();
    let rope = app.world_mut().spawn(Rope::default()).id();
    tick(&mut app, 2);
    let links = solved(&app)[1];
    let cut = app.world().get::<BodyConstraints>(rope).unwrap().iter().nth(3).unwrap();
    disable(&mut app, cut);
    disable(&mut app, rope);
    tick(&mut app, 2);
    assert_eq!(solved(&app)[..2], [0, 0]);
    enable(&mut app, rope);
    tick(&mut app, 2);
    assert_eq!(solved(&app)[1], links - 1);
    enable(&mut app, cut);
    tick(&mut app, 2);
    assert_eq!(solved(&app)[1], links);
}

#[test]
fn a_body_that_is_spawned_disabled_or_changed_while_it_is_disabled_is_built_when_it_is_enabled() {
    let mut app = app();
    let boxes = |size: f32| RigidBox::new(Vec3::splat(size));
    // Both ways of a pool: with it, and right after it.
    let one = app.world_mut().spawn((boxes(1.0), Disabled)).id();
    let other = app.world_mut().spawn((boxes(1.0), Transform::from_xyz(3.0, 0.0, 0.0))).id();
    disable(&mut app, other);
    // And by what observes the build.
    let level = Rope { to: Vec3::X, ..default() };
    let third = app.world_mut().spawn((level, Transform::from_xyz(6.0, 0.0, 0.0))).id();
    app.world_mut().entity_mut(third).observe(|built: On<BodyBuilt>, mut commands: Commands| {
        commands.entity(built.entity).insert(Disabled);
    });
    tick(&mut app, 5);
    assert_eq!(solved(&app)[0], 0);
    assert_eq!(position(&app, particles_of(&app, third)[20]).y, 0.0, "it does not swing down");
    for body in [one, other] {
        enable(&mut app, body);
        tick(&mut app, 1);
        assert_eq!(particles_of(&app, body).len(), 8);
    }
    for body in [one, other] {
        disable(&mut app, body);
        tick(&mut app, 3);
        app.world_mut().get_mut::<RigidBox>(body).unwrap().size = Vec3::splat(2.0);
        app.world_mut().entity_mut(body).insert(Mass(5.0));
        tick(&mut app, 3);
        enable(&mut app, body);
        tick(&mut app, 1);
        let members = particles_of(&app, body);
        let [a, b] = [members[0], members[7]].map(|one| position(&app, one));
        assert!((a.distance(b) - 12.0_f32.sqrt()).abs() < 1e-3, "{a} {b}");
        let mass: f32 = members.iter().map(|&one| app.world().get::<Mass>(one).unwrap().0).sum();
        assert!((mass - 5.0).abs() < 1e-4, "{mass}");
    }
    assert_eq!(heard(&app), []);
}

#[test]
fn attachments_leave_with_their_body_and_let_go_while_what_they_hold_on_to_is_disabled() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn(Transform::from_xyz(0.0, 4.0, 0.0)).id();
    let hanging = AttachTo::new(hook).part(Anchor::Point(Vec3::Y)).at(Anchor::Point(Vec3::ZERO));
    let lamp = world.spawn((RigidBox::default(), hanging, Transform::from_xyz(0.0, 3.0, 0.0))).id();
    let below = AttachTo::new(lamp).part(Anchor::Corner(Vec3::Y)).at(Anchor::Corner(Vec3::NEG_Y));
    let tag =
        world.spawn((RigidBox::new(Vec3::splat(0.5)), Transform::from_xyz(0.0, 2.25, 0.0))).id();
    world.spawn((below, bevy_sinew::AttachmentOf(tag)));
    tick(&mut app, 60);
    let hangs = |app: &App| {
        (height(app, lamp) - 3.0).abs() < 0.01 && (height(app, tag) - 2.25).abs() < 0.01
    };
    assert!(hangs(&app), "{} {}", height(&app, lamp), height(&app, tag));
    let all = solved(&app);

    // A disabled hook is where it was.
    disable(&mut app, hook);
    tick(&mut app, 60);
    assert!(hangs(&app), "{} {}", height(&app, lamp), height(&app, tag));
    enable(&mut app, hook);
    // The lamp takes its attachment to the hook along; what hangs on it falls, and is caught where it hung.
    disable(&mut app, lamp);
    tick(&mut app, 10);
    assert!(height(&app, tag) < 2.2, "{}", height(&app, tag));
    enable(&mut app, lamp);
    tick(&mut app, 240);
    assert!(app.world().get::<BodyAttachments>(tag).is_some_and(|list| list.iter().count() == 1));
    assert_eq!(solved(&app), all);
    assert!((height(&app, lamp) - 3.0).abs() < 0.05, "{}", height(&app, lamp));
    assert_eq!(heard(&app), []);
}

#[test]
fn a_snapshot_has_what_is_disabled_and_restores_it_in_place_and_in_another_app() {
    let mut app = game();
    let world = app.world_mut();
    world.spawn(Ground);
    let bodies = [0.0, 2.0]
        .map(|x| world.spawn((RigidBox::new(Vec3::ONE), Transform::from_xyz(x, 2.0, 0.0))).id());
    let rope = world.spawn((Rope::default(), Transform::from_xyz(0.0, 4.0, 2.0))).id();
    tick(&mut app, 10);
    disable(&mut app, bodies[0]);
    disable(&mut app, rope);
    let during = SinewSnapshot::capture(app.world());
    tick(&mut app, 5);
    let settled = SinewSnapshot::capture(app.world());
    let expected = {
        enable(&mut app, bodies[0]);
        disable(&mut app, bodies[1]);
        future(&mut app, 30)
    };
    for _ in 0..2 {
        settled.restore(app.world_mut()).unwrap();
        assert_eq!(SinewSnapshot::capture(app.world()).hash(), settled.hash());
        assert!(app.world().get::<Disabled>(bodies[1]).is_none());
        enable(&mut app, bodies[0]);
        disable(&mut app, bodies[1]);
        assert_eq!(future(&mut app, 30), expected);
    }
    // Captured before the tick in which what belongs to them was disabled.
    during.restore(app.world_mut()).unwrap();
    tick(&mut app, 5);
    assert_eq!(SinewSnapshot::capture(app.world()).hash(), settled.hash());

    let mut fresh = game();
    let map = settled.restore(fresh.world_mut()).unwrap();
    enable(&mut fresh, map[&bodies[0]]);
    disable(&mut fresh, map[&bodies[1]]);
    assert_eq!(future(&mut fresh, 30), expected);
    enable(&mut fresh, map[&rope]);
    tick(&mut fresh, 3);
    assert_eq!(solved(&fresh)[0], 8 + 21);
}

#[test]
fn toggling_an_interpolated_body_moves_it_by_nothing() {
    let mut app = app();
    let body = app
        .world_mut()
        .spawn((RigidBox::default(), Interpolate, LinearVelocity(Vec3::X * 3.0)))
        .id();
    app.insert_resource(Gravity(Vec3::ZERO));
    tick(&mut app, 10);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK / 4));
    (0..3).for_each(|_| app.update());
    let at = position(&app, particles_of(&app, body)[0]);
    disable(&mut app, body);
    (0..30).for_each(|_| app.update());
    app.world_mut().resource_mut::<SinewControl>().paused = true;
    enable(&mut app, body);
    tick(&mut app, 3);
    assert_eq!(position(&app, particles_of(&app, body)[0]), at);
    // Moved by the game in the meantime, and drawn there at once.
    disable(&mut app, body);
    tick(&mut app, 2);
    app.world_mut().get_mut::<Transform>(body).unwrap().translation.y = 50.0;
    (0..3).for_each(|_| app.update());
    enable(&mut app, body);
    app.update();
    assert_eq!(height(&app, body), 50.0);
    tick(&mut app, 2);
    assert_eq!(height(&app, body), 50.0);
    assert!(position(&app, particles_of(&app, body)[0]).y > 49.0);
}

#[test]
fn a_child_of_a_disabled_parent_stays_where_it_is() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let world = app.world_mut();
    let parent = world.spawn(Transform::from_xyz(5.0, 0.0, 0.0)).id();
    let child = world
        .spawn((RigidBox::default(), ChildOf(parent), Transform::from_xyz(0.0, 1.0, 0.0)))
        .id();
    let floor = world
        .spawn((Collider::cuboid(Vec3::ONE), ChildOf(parent), Transform::from_xyz(0.0, -1.0, 0.0)))
        .id();
    tick(&mut app, 2);
    let before = hash_of(&app, &[child]);
    disable(&mut app, parent);
    tick(&mut app, 3);
    assert_eq!(hash_of(&app, &[child]), before);
    assert_eq!(hit(&mut app, Vec3::new(5.0, -4.0, 0.1), Dir3::Y), Some(floor));
    enable(&mut app, parent);
    tick(&mut app, 3);
    assert_eq!(hash_of(&app, &[child]), before);
}

#[test]
fn toggling_in_any_tick_is_repeatable() {
    let run = || {
        let mut app = app();
        let bodies = crate::support::busy_scene(&mut app);
        for i in 0..60 {
            let body = bodies[i % bodies.len()];
            if app.world().get::<Disabled>(body).is_some() {
                enable(&mut app, body);
            } else if i % 3 != 0 {
                disable(&mut app, body);
            }
            tick(&mut app, 1);
        }
        for &body in &bodies {
            enable(&mut app, body);
        }
        tick(&mut app, 1);
        assert_finite(&mut app);
        assert_eq!(heard(&app), []);
        crate::support::hash(&mut app)
    };
    assert_eq!(run(), run());
}

#[test]
fn toggling_within_a_frame_changes_nothing() {
    let run = |toggles: bool| {
        let mut app = app();
        let world = app.world_mut();
        world.spawn(Ground);
        let body = world.spawn((RigidBox::default(), Transform::from_xyz(0.0, 0.7, 0.0))).id();
        let cloth = world.spawn((Cloth::grid(1.0, 1.0, 6, 6), Transform::from_xyz(0.0, 2.0, 0.0)));
        let cloth = cloth.id();
        for _ in 0..40 {
            tick(&mut app, 1);
            for one in [body, cloth].into_iter().filter(|_| toggles) {
                disable(&mut app, one);
                enable(&mut app, one);
            }
        }
        hash_of(&app, &[body, cloth])
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_disabled_particle_keeps_its_place_and_its_velocity() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    let moving = Particle { velocity: Vec3::X, ..Particle::at(Vec3::Y) };
    let particle = app.world_mut().spawn((moving, LinearVelocity(Vec3::X))).id();
    tick(&mut app, 6);
    let there = *app.world().get::<Particle>(particle).unwrap();
    disable(&mut app, particle);
    tick(&mut app, 20);
    assert_eq!(solved(&app)[0], 0);
    assert_eq!(*app.world().get::<Particle>(particle).unwrap(), there);
    enable(&mut app, particle);
    tick(&mut app, 6);
    let now = *app.world().get::<Particle>(particle).unwrap();
    assert_eq!(now.velocity, there.velocity);
    assert!((now.position.x - there.position.x - 0.1).abs() < 1e-5, "{now:?}");
}

#[test]
fn what_is_written_to_a_disabled_body_acts_when_it_is_enabled() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    let world = app.world_mut();
    let written = world.spawn(RigidBox::default()).id();
    let pushed = world.spawn((RigidBox::default(), Transform::from_xyz(3.0, 0.0, 0.0))).id();
    let charged =
        world.spawn((RigidBox::default(), Charge(1.0), Transform::from_xyz(6.0, 0.0, 0.0))).id();
    let rising =
        |x: f32| (Ragdoll::default(), LinearVelocity(Vec3::Y), Transform::from_xyz(x, 0.0, 0.0));
    let ragdoll = world.spawn(rising(9.0)).id();
    let eased = world.spawn((rising(12.0), Interpolate)).id();
    tick(&mut app, 3);
    for body in [written, pushed, charged, ragdoll, eased] {
        disable(&mut app, body);
    }
    tick(&mut app, 3);
    let world = app.world_mut();
    world.get_mut::<LinearVelocity>(written).unwrap().0 = Vec3::Y * 2.0;
    world.entity_mut(pushed).set_linear_velocity(Vec3::Y);
    world.entity_mut(charged).remove::<Charge>();
    world.entity_mut(ragdoll).insert(Interpolate);
    world.entity_mut(eased).remove::<Interpolate>();
    tick(&mut app, 3);
    assert_eq!([height(&app, written), height(&app, pushed)], [0.0, 0.0]);
    for body in [written, pushed, charged, ragdoll, eased] {
        enable(&mut app, body);
    }
    tick(&mut app, 30);
    assert!((height(&app, written) - 1.0).abs() < 1e-3, "{}", height(&app, written));
    assert!((height(&app, pushed) - 0.5).abs() < 1e-3, "{}", height(&app, pushed));
    let charge = |one: Entity| app.world().get::<Charge>(one).map(|charge| charge.0);
    assert!(
        particles_of(&app, charged).into_iter().all(|one| charge(one).is_none_or(|it| it == 0.0))
    );
    // An interpolated limb moves in every frame, another one in every tick.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK / 4));
    let limbs = [ragdoll, eased]
        .map(|body| app.world().get::<BodyParts>(body).unwrap().iter().next().unwrap());
    let mut moved = [0, 0];
    for _ in 0..8 {
        let before = limbs.map(|limb| height(&app, limb));
        app.update();
        for (limb, moved) in (0..2).zip(&mut moved) {
            *moved += u32::from(height(&app, limbs[limb]) != before[limb]);
        }
    }
    assert!(moved[0] == 8 && (1..=2).contains(&moved[1]), "{moved:?}");
    assert_eq!(heard(&app), []);
}

#[test]
fn a_rope_that_is_tied_to_a_disabled_crate_hangs_free_and_is_tied_to_it_again() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
    let load =
        world.spawn((RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(1.2, 3.0, 0.0))).id();
    let rope = world.spawn(Rope::between(hook, (load, Anchor::Corner(Vec3::NEG_X)))).id();
    tick(&mut app, 3);
    let all = solved(&app);
    disable(&mut app, load);
    tick(&mut app, 40);
    let end = |app: &App| position(app, *particles_of(app, rope).last().unwrap());
    assert!(end(&app).y < 2.6, "the end swings down: {}", end(&app));
    // Where the end is by then. From afar the tie would jerk both together, as one that is made there would.
    let at = end(&app) + Vec3::X * 0.2;
    app.world_mut().get_mut::<Transform>(load).unwrap().translation = at;
    enable(&mut app, load);
    let mut fastest = 0.0_f32;
    for _ in 0..240 {
        tick(&mut app, 1);
        fastest = fastest.max(app.world().get::<LinearVelocity>(load).unwrap().0.length());
    }
    assert_eq!(solved(&app), all);
    let frame = *app.world().get::<Transform>(load).unwrap();
    let corner = frame * Vec3::new(-0.2, 0.0, 0.0);
    assert!(corner.distance(end(&app)) < 0.01, "{corner} {}", end(&app));
    // As fast as what swings down from the height of the hook, at most.
    assert!(fastest < 5.0, "{fastest} m/s");
    assert_eq!(heard(&app), []);
}

#[test]
fn what_is_disabled_with_its_parent_is_out_and_comes_back_with_it() {
    let mut app = app();
    let world = app.world_mut();
    let room = world.spawn(Transform::from_xyz(5.0, 1.0, 0.0)).id();
    let floor = (Collider::cuboid(Vec3::new(4.0, 1.0, 4.0)), Transform::from_xyz(0.0, -0.5, 0.0));
    world.spawn((floor, ChildOf(room)));
    let cube = world
        .spawn((RigidBox::new(Vec3::ONE), ChildOf(room), Transform::from_xyz(0.0, 0.5, 0.0)))
        .id();
    tick(&mut app, 40);
    let before = (solved(&app), hash_of(&app, &[cube]));
    app.world_mut().entity_mut(room).insert_recursive::<Children>(Disabled);
    tick(&mut app, 10);
    assert_eq!(solved(&app), [0; 4]);
    app.world_mut().entity_mut(room).remove_recursive::<Children, Disabled>();
    tick(&mut app, 1);
    assert_eq!((solved(&app), hash_of(&app, &[cube])), before);
    tick(&mut app, 40);
    assert!((height(&app, cube) - 0.5).abs() < 1e-3, "{}", height(&app, cube));
    assert_eq!(heard(&app), []);
}

#[test]
fn a_body_that_is_despawned_while_it_is_disabled_leaves_nothing_behind() {
    let mut app = app();
    let world = app.world_mut();
    let load = world.spawn((RigidBox::default(), Transform::from_xyz(0.0, -1.5, 0.0))).id();
    let below = AttachTo::new(load).part(Anchor::RopeEnd(RopeEnd::Last)).snapped();
    let rope = world.spawn((Rope::default(), below)).id();
    let ragdoll = world.spawn((Ragdoll::default(), Transform::from_xyz(5.0, 0.0, 0.0))).id();
    tick(&mut app, 3);
    for body in [load, ragdoll] {
        disable(&mut app, body);
    }
    tick(&mut app, 3);
    let entities = |app: &mut App| {
        let world = app.world_mut();
        world.query_filtered::<(), (With<CreationOrder>, Allow<Disabled>)>().iter(world).count()
    };
    app.world_mut().despawn(ragdoll);
    app.world_mut().despawn(rope);
    app.world_mut().despawn(load);
    tick(&mut app, 3);
    assert_eq!(solved(&app), [0; 4]);
    assert_eq!(entities(&mut app), 0);
    assert_eq!(heard(&app), []);
}
