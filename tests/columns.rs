//! At the start of a tick the columns are what the components say, though a warm tick copies little.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Charge, ParticleBody, ParticleOf};
use bevy_sinew::{Drag, ParticleRow, PhaseSystems, SubstepSchedule};

use crate::support::{bare_app, tick};

/// Mass, radius, charge, drag and scale of gravity of a particle, as the solver has them.
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
fn properties_that_change_or_go_are_seen_in_the_next_tick() {
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
    // One loses what the other gets: there are as many as before.
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
fn what_a_body_says_is_said_once_however_often_its_particles_change() {
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
    // One that is set aside, and mended.
    app.world_mut().get_mut::<Particle>(particles[0]).unwrap().velocity.x = f32::NAN;
    tick(&mut app, 3);
    app.world_mut().get_mut::<Particle>(particles[0]).unwrap().velocity.x = 0.0;
    tick(&mut app, 3);
    assert_eq!(scales(&app), [1.0, 2.0]);
    app.world_mut().entity_mut(body).remove::<GravityScale>();
    tick(&mut app, 1);
    assert_eq!(scales(&app), [0.5, 1.0]);
}

#[test]
fn what_a_game_changes_in_the_columns_besides_state_holds_for_a_tick() {
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
