//! A sleeping body wakes, whatever a game does to it or to what it lies on; and nothing else wakes with it.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{AirFlow, Attractor, BodyParticles, ControlForce, ElectricField, SinewWorld};
use bevy_sinew::{Charge, Electric, Flatland, PhaseSystems, Region};
use bevy_sinew::{SleepingDisabled, SubstepSchedule};

use crate::support::{app, particles_of, tick};

/// A crate on the floor, another one on top of it, and one far away, all asleep.
struct Asleep {
    app: App,
    ground: Entity,
    lower: Entity,
    upper: Entity,
    far: Entity,
}

const SIZE: f32 = 0.4;

fn asleep() -> Asleep {
    let mut app = app();
    let world = app.world_mut();
    let ground = world
        .spawn((Collider::cuboid(Vec3::new(20.0, 1.0, 20.0)), Transform::from_xyz(0.0, -0.5, 0.0)))
        .id();
    world.spawn((
        Collider::cuboid(Vec3::new(20.0, 1.0, 20.0)),
        Transform::from_xyz(40.0, -0.5, 0.0),
    ));
    let [lower, upper, far] = [[0.0, 0.5], [0.0, 1.5], [40.0, 0.5]].map(|[x, y]| {
        let body = (RigidBox::new(Vec3::splat(SIZE)), Sleep::default());
        world.spawn((body, Transform::from_xyz(x, SIZE * y, 0.0))).id()
    });
    tick(&mut app, 240);
    let all = Asleep { app, ground, lower, upper, far };
    assert!([lower, upper, far].iter().all(|&body| all.sleeps(body)), "they lie still");
    all
}

impl Asleep {
    fn sleeps(&self, body: Entity) -> bool {
        self.app.world().get::<Sleep>(body).unwrap().asleep
    }

    fn height(&self, body: Entity) -> f32 {
        self.app.world().get::<Transform>(body).unwrap().translation.y
    }

    fn corner(&self, body: Entity) -> Entity {
        particles_of(&self.app, body)[0]
    }
}

/// A change that is to wake the upper crate.
type Cause = fn(&mut Asleep);

#[test]
fn a_change_by_the_game_wakes_a_sleeping_body_and_none_far_away() {
    let causes: &[(&str, Cause)] = &[
        ("a velocity of a particle", |all| {
            let corner = all.corner(all.upper);
            all.app.world_mut().get_mut::<Particle>(corner).unwrap().velocity = Vec3::Y;
        }),
        ("a place of a particle", |all| {
            for particle in particles_of(&all.app, all.upper) {
                all.app.world_mut().get_mut::<Particle>(particle).unwrap().position.y += 0.1;
            }
        }),
        ("a transform", |all| {
            all.app.world_mut().get_mut::<Transform>(all.upper).unwrap().translation.y += 0.1;
        }),
        ("a velocity of the body", |all| {
            all.app.world_mut().get_mut::<LinearVelocity>(all.upper).unwrap().0.y = 1.0;
        }),
        ("an impulse", |all| {
            all.app.world_mut().commands().entity(all.upper).apply_impulse(Vec3::Y);
        }),
        ("a force for a tick", |all| {
            all.app.world_mut().commands().entity(all.upper).apply_force(Vec3::Y * 1e3);
        }),
        ("a force on the body", |all| {
            all.app.world_mut().entity_mut(all.upper).insert(ExternalForce(Vec3::Y * 1e3));
        }),
        ("a force on a particle", |all| {
            let corner = all.corner(all.upper);
            all.app.world_mut().entity_mut(corner).insert(ExternalForce(Vec3::Y * 1e3));
        }),
        ("a control", |all| {
            let control = ControlForce { on: Some(all.upper), ..ControlForce::new(Vec3::Y * 1e3) };
            all.app.world_mut().spawn(control);
        }),
        ("a rod to a pinned particle", |all| {
            let (corner, world) = (all.corner(all.upper), all.app.world_mut());
            let nail = world.spawn((Particle::at(Vec3::Y * 2.0), Pinned::HERE)).id();
            world.spawn(DistanceConstraint::new(corner, nail, 0.5));
        }),
        ("a spring to a pinned particle", |all| {
            let (corner, world) = (all.corner(all.upper), all.app.world_mut());
            let nail = world.spawn((Particle::at(Vec3::Y * 2.0), Pinned::HERE)).id();
            let (rest, stiffness, damping) = (0.1, 1e3, 1.0);
            world.spawn(Spring { a: corner, b: nail, rest, stiffness, damping });
        }),
        ("a system that pushes within a tick", |all| {
            let row = all.app.world().get::<bevy_sinew::ParticleRow>(all.corner(all.upper));
            let row = row.unwrap().get().unwrap();
            let push = move |mut world: ResMut<SinewWorld>| {
                world.particles_mut().add_force(row, Vec3::Y * 1e3);
            };
            all.app.add_systems(SubstepSchedule, push.in_set(PhaseSystems::AccumulateForces));
        }),
        ("a system that moves it within a tick", |all| {
            let row = all.app.world().get::<bevy_sinew::ParticleRow>(all.corner(all.upper));
            let row = row.unwrap().get().unwrap();
            let push = move |mut world: ResMut<SinewWorld>| {
                world.particles_mut().set_velocity(row, Vec3::Y);
            };
            all.app.add_systems(SubstepSchedule, push.before(PhaseSystems::AccumulateForces));
        }),
        ("a weight", |all| {
            all.app.world_mut().entity_mut(all.upper).insert(Mass(100.0));
        }),
        ("a scale of gravity", |all| {
            all.app.world_mut().entity_mut(all.upper).insert(GravityScale(-1.0));
        }),
        ("layers that let it fall", |all| {
            all.app.world_mut().entity_mut(all.upper).insert(CollisionLayers::NONE);
        }),
        ("contact events of a collider", |all| {
            all.app.world_mut().entity_mut(all.ground).insert(ContactEvents::Every);
        }),
        ("the one below is gone", |all| {
            all.app.world_mut().despawn(all.lower);
        }),
    ];
    let mut asleep_still = Vec::new();
    for &(name, cause) in causes {
        let mut all = asleep();
        cause(&mut all);
        tick(&mut all.app, 3);
        if all.sleeps(all.upper) {
            asleep_still.push(name);
        }
        assert!(all.sleeps(all.far), "{name}: the far crate sleeps on");
    }
    assert_eq!(asleep_still, [""; 0]);
}

#[test]
fn a_change_of_a_global_force_wakes_all_bodies() {
    let causes: &[(&str, Cause)] = &[
        ("gravity", |all| {
            all.app.world_mut().resource_mut::<Gravity>().0 = Vec3::Y;
        }),
        ("an attractor", |all| {
            all.app.world_mut().spawn((Attractor::new(1e4), Transform::from_xyz(0.0, 9.0, 0.0)));
        }),
        ("air", |all| {
            all.app.world_mut().spawn(AirFlow { velocity: Vec3::Y * 30.0, ..default() });
        }),
        ("larger eddies in air that is there", |all| {
            let air = all.app.world_mut().spawn(AirFlow::default()).id();
            tick(&mut all.app, 240);
            assert!(all.sleeps(all.upper));
            all.app.world_mut().get_mut::<AirFlow>(air).unwrap().gust_length = 9.0;
        }),
        ("water", |all| {
            all.app.world_mut().spawn((Fluid::default(), Transform::from_xyz(0.0, 3.0, 0.0)));
        }),
        ("a field on charges", |all| {
            let corner = all.corner(all.upper);
            all.app.world_mut().entity_mut(corner).insert(Charge(1.0));
            all.app.world_mut().spawn(ElectricField { field: Vec3::Y * 1e3 });
        }),
        ("a charge nearby", |all| {
            let corner = all.corner(all.upper);
            let world = all.app.world_mut();
            world.resource_mut::<Electric>().constant = 10.0;
            world.entity_mut(corner).insert(Charge(1.0));
            world.spawn((Particle::at(Vec3::Y * 2.0), Charge(-50.0), Pinned::HERE));
        }),
    ];
    let mut asleep_still = Vec::new();
    for &(name, cause) in causes {
        let mut all = asleep();
        cause(&mut all);
        tick(&mut all.app, 3);
        if all.sleeps(all.upper) {
            asleep_still.push(name);
        }
    }
    assert_eq!(asleep_still, [""; 0]);
}

/// While all bodies rest, sleep is gathered only once, until any body's setting changes.
#[test]
fn disabling_sleep_wakes_a_body_and_enabling_it_lets_it_sleep_again() {
    let mut all = asleep();
    tick(&mut all.app, 30);
    all.app.world_mut().entity_mut(all.far).insert(SleepingDisabled);
    tick(&mut all.app, 1);
    assert!(!all.sleeps(all.far) && all.sleeps(all.upper) && all.sleeps(all.lower));
    tick(&mut all.app, 120);
    assert!(!all.sleeps(all.far), "as long as sleep is disabled");
    all.app.world_mut().entity_mut(all.far).remove::<SleepingDisabled>();
    tick(&mut all.app, 240);
    assert!(all.sleeps(all.far));
    all.app.world_mut().entity_mut(all.far).insert(ContactEvents::Every);
    tick(&mut all.app, 2);
    assert!(!all.sleeps(all.far), "it reports every contact");
}

#[test]
fn a_sleeping_hung_body_falls_when_its_support_is_removed() {
    let causes: [(&str, fn(&mut World, Entity, Entity)); 3] = [
        ("the nail is drawn", |world, nail, _| {
            world.entity_mut(nail).remove::<Pinned>();
        }),
        ("the rod is cut", |world, _, rod| {
            world.despawn(rod);
        }),
        ("the rod is longer", |world, _, rod| {
            world.get_mut::<DistanceConstraint>(rod).unwrap().rest += 1.0;
        }),
    ];
    for (name, cause) in causes {
        let mut app = app();
        let world = app.world_mut();
        let body = (RigidBox::new(Vec3::splat(SIZE)), Sleep::default());
        let body = world.spawn((body, Transform::from_xyz(0.0, 2.0, 0.0))).id();
        tick(&mut app, 1);
        let corners = particles_of(&app, body);
        let world = app.world_mut();
        let nail = world.spawn((Particle::at(Vec3::Y * 3.0), Pinned::HERE)).id();
        // By the four upper corners, so that it hangs still.
        let above = corners.iter().filter(|&&c| world.get::<Particle>(c).unwrap().position.y > 2.0);
        let above: Vec<Entity> = above.copied().collect();
        assert_eq!(above.len(), 4);
        let rods = rods(world, &above, nail);
        tick(&mut app, 240);
        let world = app.world();
        assert!(world.get::<Sleep>(body).unwrap().asleep, "{name}: it hangs still");
        let before = world.get::<Transform>(body).unwrap().translation.y;
        for &rod in &rods {
            cause(app.world_mut(), nail, rod);
            if name == "the nail is drawn" {
                break;
            }
        }
        tick(&mut app, 30);
        let now = app.world().get::<Transform>(body).unwrap().translation.y;
        // Rods that are too long push down no faster than the limit for recovering violations; a free fall is not limited by that.
        let least = if name == "the rod is longer" { 0.4 } else { 0.5 };
        assert!(now < before - least, "{name}: {before} to {now}");
    }
}

/// A rod from each particle to the nail, at their present distance.
fn rods(world: &mut World, particles: &[Entity], nail: Entity) -> Vec<Entity> {
    let at = |world: &World, one: Entity| world.get::<Particle>(one).unwrap().position;
    let rods = particles.iter().map(|&one| {
        let rest = at(world, one).distance(at(world, nail));
        world.spawn(DistanceConstraint::new(one, nail, rest)).id()
    });
    rods.collect()
}

#[test]
fn the_upper_crate_falls_onto_the_floor_when_the_lower_one_is_gone() {
    let mut all = asleep();
    all.app.world_mut().despawn(all.lower);
    tick(&mut all.app, 60);
    let height = all.height(all.upper);
    assert!((height - 0.5 * SIZE).abs() < 0.01, "it lies at {height}");
    assert!(all.app.world().get::<BodyParticles>(all.upper).is_some());
}

/// Regression: it fell asleep in a lull, and the next gust found it fixed to the ground.
#[test]
fn a_body_that_gusts_may_move_does_not_sleep_in_them() {
    let app_in = |pressure: f32| {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((Ground, SurfaceMaterial::new(1.0)));
        let wind = Wind { pressure: Vec3::X * pressure, gusts: 0.5, ..default() };
        let wind = world.spawn(wind).id();
        let light = RigidBox::new(Vec3::splat(0.5)).with_mass(2.0);
        let light = world.spawn((light, Transform::from_xyz(0.0, 0.25, 0.0))).id();
        let cube = SoftBody::cuboid(Vec3::splat(0.5), UVec3::splat(2));
        let soft = world.spawn((cube, Transform::from_xyz(4.0, 0.3, 0.0))).id();
        let heavy = RigidBox::new(Vec3::splat(0.5)).with_mass(500.0);
        let heavy = world.spawn((heavy, Transform::from_xyz(9.0, 0.25, 0.0))).id();
        tick(&mut app, 900);
        (app, wind, [light, soft, heavy])
    };
    let asleep =
        |app: &App, all: [Entity; 3]| all.map(|b| app.world().get::<Sleep>(b).unwrap().asleep);
    // A breeze moves none of them; a wind that pushes the light box about leaves the heavy one at rest.
    let (mut app, wind, all) = app_in(0.01);
    assert_eq!(asleep(&app, all), [true; 3], "in a breeze");
    // Something that fills the world wakes all when it changes; the heavy box falls asleep again.
    app.world_mut().get_mut::<Wind>(wind).unwrap().pressure.x = 40.0;
    tick(&mut app, 2);
    assert_eq!(asleep(&app, all), [false; 3], "when it freshens");
    tick(&mut app, 120);
    assert_eq!(asleep(&app, all), [false, false, true], "since it freshened");
    let (app, _, all) = app_in(40.0);
    assert_eq!(asleep(&app, all), [false, false, true], "in gusts");
}

/// A body that floats asleep, and one in the air of a 2D world, slept on when the hull was removed or the plane was moved.
#[test]
fn a_hull_and_the_plane_of_a_2d_world_wake_what_they_hold() {
    let mut app = app();
    let world = app.world_mut();
    let lid = Collider::cuboid(Vec3::new(20.0, 1.0, 20.0));
    world.spawn((lid.clone(), Transform::from_xyz(0.0, 2.5, 0.0)));
    world.spawn(Ground);
    world.spawn((Fluid { density: 3000.0, ..default() }, Transform::from_xyz(0.0, 5.0, 0.0)));
    let raft = (RigidBox::default(), Floats::default(), Transform::from_xyz(0.0, 1.5, 0.0));
    let raft = world.spawn(raft).id();
    let sunk = world.spawn((RigidBox::default(), Transform::from_xyz(5.0, 0.5, 0.0))).id();
    tick(&mut app, 180);
    let sleeps = |app: &App, body: Entity| app.world().get::<Sleep>(body).unwrap().asleep;
    assert!(sleeps(&app, raft) && sleeps(&app, sunk));
    app.world_mut().entity_mut(raft).remove::<Floats>();
    tick(&mut app, 3);
    assert!(!sleeps(&app, raft) && sleeps(&app, sunk), "only what lost its hull wakes");
    app.world_mut().entity_mut(sunk).insert(Floats::default());
    tick(&mut app, 3);
    assert!(!sleeps(&app, sunk), "what gets one wakes, too");

    let mut app = crate::support::app();
    let world = app.world_mut();
    world.spawn(Ground);
    let square = RigidBox { flat: true, ..default() };
    let square = world.spawn((square, Transform::from_xyz(0.0, 0.5, 0.0))).id();
    let plane = world.spawn(Flatland).id();
    tick(&mut app, 180);
    assert!(sleeps(&app, square));
    app.world_mut().get_mut::<Transform>(plane).unwrap().translation.z = 0.3;
    tick(&mut app, 60);
    let z = app.world().get::<Transform>(square).unwrap().translation.z;
    assert!((z - 0.3).abs() < 1e-3, "{z}");
}

/// A wind that acts everywhere, on an entity that moves (a camera, a player), kept everything awake: a crate slept in 3 of 120 ticks.
#[test]
fn a_field_without_a_region_may_be_on_an_entity_that_moves() {
    let mut all = asleep();
    let world = all.app.world_mut();
    let calm = Wind { pressure: Vec3::X, gusts: 0.0, ..default() };
    let wind = world.spawn((calm, Transform::default())).id();
    let sea = world.spawn((Fluid::default(), Transform::from_xyz(0.0, -1.0, 0.0))).id();
    let charged = world.spawn((ElectricField { field: Vec3::Y }, Transform::default())).id();
    tick(&mut all.app, 120);
    for _ in 0..10 {
        for field in [wind, sea, charged] {
            all.app.world_mut().get_mut::<Transform>(field).unwrap().translation.x += 0.1;
        }
        tick(&mut all.app, 1);
        assert!(all.sleeps(all.upper) && all.sleeps(all.far));
    }
    all.app.world_mut().get_mut::<Transform>(sea).unwrap().translation.y += 0.1;
    tick(&mut all.app, 2);
    assert!(!all.sleeps(all.upper), "the level of a sea counts");
    tick(&mut all.app, 120);
    assert!(all.sleeps(all.upper));
    all.app.world_mut().entity_mut(wind).insert(Region::sphere(5.0));
    tick(&mut all.app, 120);
    all.app.world_mut().get_mut::<Transform>(wind).unwrap().translation.x += 0.1;
    tick(&mut all.app, 2);
    assert!(!all.sleeps(all.upper), "so does the place of a region");
}

/// A body whose particles were all pinned counted as still meanwhile, and slept where it was as soon as it was released: a crate stayed in the air.
#[test]
fn a_body_that_was_held_falls_when_it_is_released() {
    for pins in 1..=8 {
        let mut app = app();
        let body = (RigidBox::default(), Transform::from_xyz(0.0, 5.0, 0.0));
        let body = app.world_mut().spawn(body).id();
        tick(&mut app, 1);
        let corners = particles_of(&app, body);
        for &corner in &corners[..pins] {
            app.world_mut().entity_mut(corner).insert(Pinned::HERE);
        }
        tick(&mut app, 120);
        let before = app.world().get::<Transform>(body).unwrap().translation.y;
        for &corner in &corners[..pins] {
            app.world_mut().entity_mut(corner).remove::<Pinned>();
        }
        tick(&mut app, 60);
        let fallen = before - app.world().get::<Transform>(body).unwrap().translation.y;
        assert!(fallen > 3.0, "{pins} pins: {fallen} m");
    }
}
