//! At the start of a tick the columns equal the components, though a warm tick copies little.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, BodySolver, Charge, ParticleBody, ParticleOf};
use bevy_sinew::{
    CollisionLayers, ContactsDisabled, Drag, ExternalForce, ParticleRow, PhaseSystems, Sleep,
    SleepingDisabled, SubstepSchedule,
};

use crate::support::{app, bare_app, hash, particles_of, tick};

/// Mass, radius, charge, drag and gravity scale of a particle, as the solver has them.
fn held(app: &App, particle: Entity) -> [f32; 5] {
    let row = app.world().get::<ParticleRow>(particle).and_then(|row| row.get()).expect("laid out");
    let seed = app.world().resource::<SinewWorld>().particles().seed(row);
    // Drag is kept as a rate, and comes back rounded.
    let drag = (seed.drag * 1e3).round() / 1e3;
    [seed.mass, seed.radius, seed.charge, drag, seed.gravity_scale]
}

fn two_particles(app: &mut App) -> [Entity; 2] {
    let all = (Mass(2.0), Radius(0.1), Charge(3.0), Drag(0.25), GravityScale(0.5));
    let world = app.world_mut();
    [world.spawn((Particle::at(Vec3::ZERO), all)).id(), world.spawn(Particle::at(Vec3::X)).id()]
}

const PLAIN: [f32; 5] = [1.0, 0.0, 0.0, 0.0, 1.0];

#[test]
fn changed_or_removed_properties_take_effect_in_the_next_tick() {
    let mut app = bare_app();
    let [a, b] = two_particles(&mut app);
    tick(&mut app, 5);
    assert_eq!((held(&app, a), held(&app, b)), ([2.0, 0.1, 3.0, 0.25, 0.5], PLAIN));
    app.world_mut().get_mut::<Mass>(a).unwrap().0 = 4.0;
    tick(&mut app, 1);
    assert_eq!(held(&app, a), [4.0, 0.1, 3.0, 0.25, 0.5]);
    app.world_mut().get_mut::<Radius>(a).unwrap().0 = 0.2;
    app.world_mut().entity_mut(a).remove::<(Charge, Drag)>();
    tick(&mut app, 5);
    assert_eq!(held(&app, a), [4.0, 0.2, 0.0, 0.0, 0.5]);
    // One particle loses what the other gets, so the number of components stays the same.
    app.world_mut().entity_mut(a).remove::<(Radius, GravityScale)>();
    app.world_mut().entity_mut(b).insert((Radius(0.2), GravityScale(0.5)));
    tick(&mut app, 1);
    let expected = ([4.0, 0.0, 0.0, 0.0, 1.0], [1.0, 0.2, 0.0, 0.0, 0.5]);
    assert_eq!((held(&app, a), held(&app, b)), expected);
    app.world_mut().entity_mut(b).insert(Pinned::HERE);
    tick(&mut app, 1);
    assert_eq!(held(&app, b)[0], f32::INFINITY);
    app.world_mut().entity_mut(b).remove::<Pinned>();
    tick(&mut app, 1);
    assert_eq!(held(&app, b)[0], 1.0);
}

#[test]
fn the_gravity_scale_of_a_body_is_applied_once_however_often_its_particles_change() {
    let mut app = bare_app();
    let body = app.world_mut().spawn((ParticleBody, GravityScale(0.5))).id();
    let particles = two_particles(&mut app);
    for particle in particles {
        app.world_mut().entity_mut(particle).insert(ParticleOf(body));
    }
    let scales = |app: &App| particles.map(|particle| held(app, particle)[4]);
    tick(&mut app, 3);
    assert_eq!(scales(&app), [0.25, 0.5]);
    for mass in 1..4 {
        app.world_mut().get_mut::<Mass>(particles[1]).unwrap().0 = mass as f32;
        tick(&mut app, 2);
        assert_eq!(scales(&app), [0.25, 0.5]);
    }
    app.world_mut().get_mut::<GravityScale>(body).unwrap().0 = 2.0;
    tick(&mut app, 1);
    assert_eq!(scales(&app), [1.0, 2.0]);
    // A particle that is set aside and repaired.
    app.world_mut().get_mut::<Particle>(particles[0]).unwrap().velocity.x = f32::NAN;
    tick(&mut app, 3);
    app.world_mut().get_mut::<Particle>(particles[0]).unwrap().velocity.x = 0.0;
    tick(&mut app, 3);
    assert_eq!(scales(&app), [1.0, 2.0]);
    app.world_mut().entity_mut(body).remove::<GravityScale>();
    tick(&mut app, 1);
    assert_eq!(scales(&app), [0.5, 1.0]);
}

/// Regression: the product of the two scales was left at its old value when it overflowed, so it depended on the body's previous scale.
#[test]
fn a_gravity_scale_that_overflows_with_its_body_is_the_particles_own() {
    let mut app = bare_app();
    let body = app.world_mut().spawn((ParticleBody, GravityScale(2.0))).id();
    let heavy = (Particle::at(Vec3::ZERO), Pinned::HERE, GravityScale(1e30), ParticleOf(body));
    let particle = app.world_mut().spawn(heavy).id();
    tick(&mut app, 2);
    assert_eq!(held(&app, particle)[4], 2e30);
    app.world_mut().get_mut::<GravityScale>(body).unwrap().0 = 1e30;
    tick(&mut app, 1);
    assert_eq!(held(&app, particle)[4], 1e30);
}

#[test]
fn a_games_change_of_a_column_that_is_not_state_lasts_one_tick() {
    #[derive(Resource)]
    struct Meddle;
    let mut app = bare_app();
    let meddle = |mut world: ResMut<SinewWorld>| world.particles_mut().scale_gravity(0, 3.0);
    app.insert_resource(Meddle).insert_resource(SolverConfig { substeps: 1, ..default() });
    let system = meddle.in_set(PhaseSystems::AccumulateForces).run_if(resource_exists::<Meddle>);
    app.add_systems(SubstepSchedule, system);
    let [a, _] = two_particles(&mut app);
    tick(&mut app, 3);
    assert_eq!(held(&app, a)[4], 1.5, "once, and not once a tick");
    app.world_mut().remove_resource::<Meddle>();
    tick(&mut app, 1);
    assert_eq!(held(&app, a)[4], 0.5);
}

/// Bodies and loose particles, in the order of spawning; some have been despawned since.
struct Zoo {
    app: App,
    all: Vec<Entity>,
}

impl Zoo {
    fn new() -> Self {
        let mut zoo = Self { app: app(), all: Vec::new() };
        zoo.app.world_mut().spawn(Ground);
        (0..9).for_each(|kind| zoo.spawn(kind));
        zoo
    }

    fn spawn(&mut self, kind: u32) {
        let at = Transform::from_xyz(1.5 * (self.all.len() % 7) as f32, 1.0, kind as f32);
        let world = self.app.world_mut();
        let mut one = match kind % 5 {
            0 => world.spawn((RigidBox::new(Vec3::splat(0.4)), at)),
            1 => world.spawn((Cloth::grid(0.6, 0.6, 5, 5).pinned(ClothPins::TopEdge), at)),
            2 => {
                world.spawn((Cloth::grid(0.6, 0.6, 5, 5), BodyContacts::ALL, at, GravityScale(0.5)))
            }
            3 => world.spawn(Rope::between(at.translation, at.translation + Vec3::Y)),
            _ => world.spawn((Particle::at(at.translation), Radius(0.1))),
        };
        // Writes to columns wake bodies, and only one of the two apps writes.
        let one = one.insert(SleepingDisabled).id();
        self.all.push(one);
    }

    /// Makes one of the changes that a game may make to one of the bodies or particles.
    fn edit(&mut self, what: u32, which: u32) {
        let body = self.all[which as usize % self.all.len()];
        let number = which as f32 % 7.0;
        if self.app.world().get_entity(body).is_err() {
            return;
        }
        let particles = particles_of(&self.app, body);
        let particle = particles.get(which as usize / 7 % particles.len().max(1)).copied();
        let world = self.app.world_mut();
        let mut body = world.entity_mut(body);
        match what % 24 {
            0 => drop(body.insert(SurfaceMaterial { friction: 0.1 * number, ..default() })),
            1 => drop(body.insert(GravityScale(0.25 * number))),
            2 => drop(body.remove::<GravityScale>()),
            3 => drop(body.insert(BodyContacts::ALL)),
            4 => drop(body.insert(BodyContacts::default())),
            5 => drop(body.insert(CollisionLayers { memberships: 3, ..default() })),
            6 => drop(body.insert(BodySolver { tolerance: Some(1e-4), ..default() })),
            7 => drop(body.insert(ContactsDisabled)),
            8 => drop(body.remove::<ContactsDisabled>()),
            9 => drop(body.remove::<Sleep>()),
            10 => body.despawn(),
            11 => self.spawn(which),
            _ => {
                let Some(particle) = particle else { return };
                let mut particle = world.entity_mut(particle);
                match what % 24 {
                    12 => drop(particle.insert(Pinned::HERE)),
                    13 => drop(particle.remove::<Pinned>()),
                    14 => drop(particle.insert(Mass(0.1 + number))),
                    15 => drop(particle.insert(GravityScale(0.5 * number))),
                    16 => drop(particle.remove::<GravityScale>()),
                    17 => drop(particle.insert(Charge(1e-9 * number))),
                    18 => drop(particle.remove::<Charge>()),
                    19 => drop(particle.insert(ExternalForce(Vec3::X * number))),
                    20 => drop(particle.remove::<ExternalForce>()),
                    21 => drop(particle.insert(Radius(0.01 * number))),
                    22 => drop(particle.insert(Drag(0.1 * number))),
                    _ => particle.despawn(),
                }
            }
        }
    }
}

/// One app copies only what changed. In the other, a system writes to the columns after each tick, so that everything is copied in the next one.
#[test]
fn copying_what_changed_equals_copying_everything() {
    for seed in 1..5_u32 {
        let mut zoos = [Zoo::new(), Zoo::new()];
        let meddle = |mut world: ResMut<SinewWorld>| {
            for row in 0..world.particles().len() {
                let mut particles = world.particles_mut();
                particles.scale_gravity(row, 2.0);
                particles.scale_gravity(row, 0.5);
            }
        };
        zoos[1].app.add_systems(FixedLast, meddle);
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        for step in 0..150 {
            for _ in 0..random() % 3 {
                let (what, which) = (random(), random());
                zoos.iter_mut().for_each(|zoo| zoo.edit(what, which));
            }
            zoos.iter_mut().for_each(|zoo| tick(&mut zoo.app, 1));
            let hashes = zoos.each_mut().map(|zoo| hash(&mut zoo.app));
            assert_eq!(hashes[0], hashes[1], "seed {seed}, tick {step}");
            let [one, other] =
                zoos.each_ref().map(|zoo| zoo.app.world().resource::<SinewWorld>().simulation());
            let [p, q] = [one, other].map(|world| &world.particles);
            for row in 0..p.len() {
                let of = |all: &bevy_sinew::sinew::Particles| {
                    let seed = all.seed(row);
                    let own = [seed.mass, seed.radius, seed.charge, seed.drag, seed.gravity_scale];
                    (own, all.body(row), all.rest(row))
                };
                assert_eq!(of(p), of(q), "seed {seed}, tick {step}, row {row}");
            }
            assert_eq!(*one.bodies, *other.bodies);
            assert_eq!(*one.contacts, *other.contacts);
            assert_eq!(one.distances(), other.distances());
            assert_eq!(one.constraints(), other.constraints());
            assert_eq!(one.body_colliders(), other.body_colliders());
            assert_eq!(one.forces.surfaces, other.forces.surfaces);
        }
    }
}
