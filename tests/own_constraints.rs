//! A game's own constraints, and all kinds together: one registration, one order, one state.

use core::sync::atomic::{AtomicUsize, Ordering};

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::constraints::Cone;
use bevy_sinew::sinew::{ConstraintFault, ConstraintKind, Equation, Points};
use bevy_sinew::{
    AngleConstraint, HingeConstraint, ParticleConstraint, RegisterParticleConstraint,
    VolumeConstraint,
};
use bevy_sinew::{
    AnyConstraint, AreaConstraint, BendConstraint, CollinearConstraint, ConeConstraint,
    CoplanarConstraint, CreationOrder, PatchConstraint, Refusal, RigidConstraint, SinewSnapshot,
    SizeCorrection, TetrahedronConstraint,
};

use crate::constraints::FACES;
use crate::snapshot::clear;
use crate::support::{TICK, app, busy_scene, hash, heard, position, tick};

/// Keeps a particle on a sphere. It has hooks of its own, which the plugin must not need.
#[derive(Component, Clone)]
#[component(on_add = count, on_remove = count)]
struct OnBall {
    #[entities]
    particle: Entity,
    centre: Vec3,
    radius: f32,
}

/// How often a hook of the game ran.
#[derive(Resource, Default)]
struct Hooked(u32);

fn count(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut hooked) = world.get_resource_mut::<Hooked>() {
        hooked.0 += 1;
    }
}

impl ParticleConstraint for OnBall {
    fn particles(&self) -> &[Entity] {
        core::slice::from_ref(&self.particle)
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::custom(Ball { centre: self.centre, radius: self.radius })
    }

    fn fault(&self) -> Option<ConstraintFault> {
        (!self.radius.is_finite()).then_some(ConstraintFault::Number)
    }
}

#[derive(Debug)]
struct Ball {
    centre: Vec3,
    radius: f32,
}

impl Equation for Ball {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let from_centre = points.relative_to(0, self.centre);
        gradients[0] = from_centre.normalize_or(Vec3::Y);
        from_centre.length() - self.radius
    }
}

fn on_ball(particle: Entity) -> OnBall {
    OnBall { particle, centre: Vec3::ZERO, radius: 1.0 }
}

/// The same constraint as a second type.
#[derive(Component, Clone)]
struct OnOther(OnBall);

impl ParticleConstraint for OnOther {
    fn particles(&self) -> &[Entity] {
        self.0.particles()
    }

    fn kind(&self) -> ConstraintKind {
        self.0.kind()
    }
}

#[test]
fn a_particle_stays_on_the_surface_of_a_games_own_constraint() {
    let mut app = app();
    app.init_resource::<Hooked>().register_particle_constraint::<OnBall>();
    let bead = Particle::at(Vec3::Y).with_velocity(Vec3::X);
    let bead = app.world_mut().spawn(bead).id();
    let on = app.world_mut().spawn(on_ball(bead)).id();
    let mut lowest = 1.0_f32;
    for _ in 0..240 {
        tick(&mut app, 1);
        let at = position(&app, bead);
        assert!((at.length() - 1.0).abs() < 1e-3, "{at}");
        lowest = lowest.min(at.y);
    }
    assert!(lowest < -0.99, "it slid all the way round: {lowest}");
    app.world_mut().get_mut::<OnBall>(on).unwrap().radius = 1.5;
    tick(&mut app, 5);
    assert!((position(&app, bead).length() - 1.5).abs() < 1e-2, "changed");
    app.world_mut().despawn(on);
    tick(&mut app, 60);
    assert!(position(&app, bead).length() > 2.0, "and let go");
    assert_eq!(app.world().resource::<Hooked>().0, 2);
    assert_eq!(heard(&app), []);
}

#[test]
fn a_fault_reported_by_a_games_constraint_is_refused() {
    let mut app = app();
    app.register_particle_constraint::<OnBall>();
    let bead = app.world_mut().spawn(Particle::at(Vec3::Y)).id();
    let bad = app.world_mut().spawn(OnBall { radius: f32::NAN, ..on_ball(bead) }).id();
    tick(&mut app, 20);
    assert_eq!(heard(&app), [(bad, Refusal::Constraint(ConstraintFault::Number))]);
    assert!(position(&app, bead).y < 0.7, "it falls");
}

#[test]
fn registering_early_late_or_twice_has_the_same_effect() {
    let run = |place: usize| {
        let mut app = App::new();
        let register = |app: &mut App, when| {
            if when == place || place == 4 {
                app.register_particle_constraint::<OnBall>();
            }
        };
        register(&mut app, 0);
        app.add_plugins((MinimalPlugins, SinewPlugins));
        app.insert_resource(Time::<Fixed>::from_duration(TICK))
            .insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(TICK));
        register(&mut app, 1);
        let bead = app.world_mut().spawn(Particle::at(Vec3::new(0.6, 0.8, 0.0))).id();
        // A constraint that is spawned before its type is registered has no creation order yet.
        let on = app.world_mut().spawn(on_ball(bead)).id();
        register(&mut app, 2);
        app.finish();
        app.update();
        register(&mut app, 3);
        (0..30).for_each(|_| app.update());
        assert!(app.world().get::<CreationOrder>(on).is_some());
        let simulation = app.world().resource::<SinewWorld>().simulation();
        assert_eq!(simulation.constraints().len(), 1, "{place}");
        (position(&app, bead).length() - 1.0).abs()
    };
    for place in 0..5 {
        let off = run(place);
        assert!(off < 1e-3, "{place}: {off}");
    }
}

/// How often the kind of any `Counted` was queried.
static QUERIES: AtomicUsize = AtomicUsize::new(0);

#[derive(Component, Clone)]
struct Counted(OnBall);

impl ParticleConstraint for Counted {
    fn particles(&self) -> &[Entity] {
        self.0.particles()
    }

    fn kind(&self) -> ConstraintKind {
        QUERIES.fetch_add(1, Ordering::Relaxed);
        self.0.kind()
    }
}

#[test]
fn the_kind_of_a_constraint_is_queried_after_a_change_and_not_in_a_warm_tick() {
    let mut app = app();
    app.register_particle_constraint::<Counted>();
    busy_scene(&mut app);
    let bead = app.world_mut().spawn(Particle::at(Vec3::Y)).id();
    let on = app.world_mut().spawn(Counted(on_ball(bead))).id();
    tick(&mut app, 2);
    let queries = QUERIES.load(Ordering::Relaxed);
    tick(&mut app, 50);
    assert_eq!(QUERIES.load(Ordering::Relaxed), queries);
    app.world_mut().get_mut::<Counted>(on).unwrap().0.radius = 1.1;
    tick(&mut app, 2);
    assert_eq!(QUERIES.load(Ordering::Relaxed), queries + 1);
}

/// Moves an entity into a table of its own.
#[derive(Component)]
struct Mark<const N: usize>;

/// Two types of constraints, taking turns, pull one particle onto surfaces that exclude each other: the last one wins. `marks` shuffles their tables, `turned`
/// reverses their order of creation. Returns a hash of the final positions.
fn opposed(marks: bool, turned: bool) -> u64 {
    let mut app = app();
    app.register_particle_constraint::<OnBall>().register_particle_constraint::<OnOther>();
    let world = app.world_mut();
    let beads: Vec<Entity> =
        (0..3).map(|i| world.spawn(Particle::at(Vec3::Y + Vec3::X * i as f32)).id()).collect();
    if marks {
        // Tables are visited in the order in which they were created.
        world.spawn((OnOther(on_ball(beads[0])), Mark::<2>));
        world.spawn((on_ball(beads[0]), Mark::<1>));
        world.spawn((on_ball(beads[0]), Mark::<0>));
        let all: Vec<Entity> = world
            .query_filtered::<Entity, Or<(With<OnBall>, With<OnOther>)>>()
            .iter(world)
            .collect();
        all.into_iter().for_each(|entity| _ = world.despawn(entity));
    }
    for i in 0..6 {
        let place = if turned { 5 - i } else { i };
        let ball = OnBall { centre: Vec3::X * 0.3 * place as f32, ..on_ball(beads[place % 3]) };
        let mut entity = world.spawn_empty();
        match (marks, place % 3) {
            (true, 0) => _ = entity.insert(Mark::<0>),
            (true, 1) => _ = entity.insert(Mark::<1>),
            (true, 2) => _ = entity.insert(Mark::<2>),
            _ => {}
        }
        match place % 2 {
            0 => entity.insert(ball),
            _ => entity.insert(OnOther(ball)),
        };
    }
    tick(&mut app, 30);
    assert_eq!(heard(&app), []);
    // The particles alone, whose creation orders are the same in every case.
    let at = beads.iter().map(|&bead| position(&app, bead).to_array());
    crate::support::fnv(at.flatten().map(f32::to_bits))
}

#[test]
fn the_order_of_creation_decides_across_types_and_tables() {
    assert_eq!(opposed(false, false), opposed(true, false), "not the order of the tables");
    assert_eq!(opposed(false, true), opposed(true, true));
    assert_ne!(opposed(false, false), opposed(false, true), "and it does matter");
}

/// One constraint of each kind, each on particles that hang from the first one; some are soft.
fn one_of_each(world: &mut World) {
    let mut x = -3.0;
    let mut set = || {
        x += 0.8;
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(-0.5, 0.2, 0.3)];
        let found =
            corners.map(|p| world.spawn(Particle::at(p * 0.5 + Vec3::new(x, 4.0, -3.0))).id());
        world.entity_mut(found[0]).insert(Pinned::HERE);
        for i in 1..5 {
            world.spawn(
                DistanceConstraint::new(found[0], found[i], 0.5)
                    .with_bound(bevy_sinew::Bound::AtMost),
            );
        }
        (found, [found[0], found[1], found[2]], [found[0], found[1], found[2], found[3]])
    };
    let sets = [(); 12].map(|()| set());
    let soft = Softness::frequency(4.0, 0.2);
    let three = |i: usize| sets[i].1;
    let four = |i: usize| sets[i].2;
    let five = |i: usize| sets[i].0;
    let cone = Cone::about(Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_Y, 0.4).expect("a frame");
    world.spawn(AngleConstraint::new(three(0), 1.0, 1.2).with_softness(soft));
    world.spawn(HingeConstraint::new(four(1), 0.5, 1.0));
    world.spawn(ConeConstraint::from_kind(five(2), &cone));
    world.spawn(AreaConstraint::new(three(3), 0.2).with_softness(soft));
    world.spawn(PatchConstraint::new(four(4), FACES, 0.7));
    world.spawn(TetrahedronConstraint::new(four(5), 0.03).with_softness(soft));
    world.spawn(
        VolumeConstraint::new(four(6), FACES, 0.03).with_correction(SizeCorrection::Scaling),
    );
    world.spawn(BendConstraint::new(four(7), [0.5, 0.5, -0.5, -0.5], 0.1));
    world.spawn(CoplanarConstraint::new(five(8)));
    world.spawn(CollinearConstraint::new(three(9)).with_softness(soft));
    let rest = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| p * 0.4);
    world.spawn(RigidConstraint::new(four(10), rest));
    let kind = ConstraintKind::custom(Ball { centre: Vec3::new(0.0, 4.0, -3.0), radius: 2.0 });
    world.spawn(AnyConstraint::new([five(11)[4]], kind));
}

#[test]
fn restored_constraints_go_on_bit_for_bit() {
    let mut app = app();
    app.world_mut().spawn(Ground);
    one_of_each(app.world_mut());
    tick(&mut app, 60);
    let simulation = app.world().resource::<SinewWorld>().simulation();
    let count = simulation.constraints().len();
    assert_eq!(count, 12, "`one_of_each` spawns that many: a new one is to be counted here, too");
    let hashes = |app: &mut App| -> Vec<u64> {
        (0..60)
            .map(|_| {
                tick(app, 1);
                hash(app)
            })
            .collect()
    };
    let saved = SinewSnapshot::capture(app.world());
    let first = hashes(&mut app);
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(hashes(&mut app), first, "in place");
    clear(app.world_mut());
    let map = saved.restore(app.world_mut()).unwrap();
    assert_eq!(hashes(&mut app), first, "under new names");
    assert!(!map.is_empty());
    assert_eq!(heard(&app), []);
}
