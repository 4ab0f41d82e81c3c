//! Forces while they are in use: an edit takes effect in the next tick; a broken one is named once and affects nothing else; and all of them go on from cloned
//! components, bit for bit.

use bevy::prelude::*;
use bevy_sinew::Region;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::{HullFault, ParticleFault};
use bevy_sinew::{
    AirFlow, Attractor, BoxParticles, Charge, CreationOrder, Electric, ElectricField, Flatland,
    HullShape, Refusal, SinewSnapshot, WindSurface,
};

use crate::support::{bare_app, bits, hash, heard, tick};

/// The entities of the scene.
#[derive(Clone)]
struct Cast {
    wind: Entity,
    air: Entity,
    fluid: Entity,
    field: Entity,
    sun: Entity,
    raft: Entity,
    ion: Entity,
}

/// A bit of each force: a sheet in winds, a raft and a ball in a pool with a current, charges in fields, an attractor, and a gravity scale.
fn scene(app: &mut App) -> Cast {
    app.insert_resource(Electric { constant: 2.0, softening: 0.1, ..default() });
    let world = app.world_mut();
    let place = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.2)]
        .map(|at| world.spawn((Particle::at(at + Vec3::Y * 3.0), Mass(0.1))).id());
    let [a, b, c, d] = corners;
    // With a creation order, so that the snapshot includes it.
    world.spawn((WindSurface { triangles: vec![[a, b, c], [b, d, c]] }, CreationOrder::default()));
    for pair in [[a, b], [a, c], [b, c], [b, d], [c, d]] {
        world.spawn(Spring::new(pair[0], pair[1], 1.0, 30.0).with_damping(0.2));
    }
    let wind = Wind { pressure: Vec3::Z * 4.0, gusts: 0.4, ..default() };
    let pool = Region::boxed(Vec3::new(12.0, 8.0, 12.0)).with_fade(0.5);
    let ball = (Particle::at(Vec3::new(2.0, 0.1, 2.0)), Radius(0.2), Mass(20.0), Charge(0.2));
    world.spawn(ball);
    let body = RigidBox::new(Vec3::new(1.5, 0.4, 1.0)).with_mass(300.0);
    let body = RigidBox { particles: BoxParticles::Equimomental, ..body };
    Cast {
        wind: world.spawn((wind, Region::sphere(4.0).with_fade(2.0), place(0.5))).id(),
        air: world.spawn(AirFlow::steady(Vec3::new(2.0, 0.5, 1.0)).with_gusts(0.3)).id(),
        fluid: world.spawn((Fluid::flowing(Vec3::X), pool, place(0.0))).id(),
        field: world.spawn((ElectricField::new(Vec3::Y * 30.0), Region::capsule(3.0, 4.0))).id(),
        sun: world.spawn((Attractor::new(5.0), place(-3.0))).id(),
        raft: world.spawn((body, Floats::OWN, GravityScale(0.9), place(-1.0))).id(),
        ion: world
            .spawn((Particle::at(Vec3::Y), Charge(0.3), GravityScale(0.5), Radius(0.05)))
            .id(),
    }
}

fn played(ticks: u64) -> (App, Cast) {
    let mut app = bare_app();
    let cast = scene(&mut app);
    tick(&mut app, ticks);
    assert_eq!(heard(&app), []);
    (app, cast)
}

fn edit<C: Component<Mutability = bevy::ecs::component::Mutable>>(
    app: &mut App,
    entity: Entity,
    change: impl FnOnce(&mut C),
) {
    change(&mut app.world_mut().get_mut::<C>(entity).unwrap());
}

#[test]
fn each_number_edited_live_takes_effect_in_the_next_tick() {
    type Edit = fn(&mut App, &Cast);
    let edits: &[(&str, Edit)] = &[
        ("wind", |a, c| edit::<Wind>(a, c.wind, |w| w.pressure *= 2.0)),
        ("wind gusts", |a, c| edit::<Wind>(a, c.wind, |w| w.gusts = 0.9)),
        ("wind region", |a, c| edit::<Region>(a, c.wind, |r| r.fade = 7.0)),
        ("wind shape", |a, c| edit::<Region>(a, c.wind, |r| r.shape = Region::sphere(0.1).shape)),
        ("wind place", |a, c| edit::<Transform>(a, c.wind, |t| t.translation.x += 40.0)),
        ("wind everywhere", |a, c| _ = a.world_mut().entity_mut(c.wind).remove::<Region>()),
        ("air", |a, c| edit::<AirFlow>(a, c.air, |w| w.velocity.y += 1.0)),
        ("air density", |a, c| edit::<AirFlow>(a, c.air, |w| w.density *= 0.5)),
        ("air drag", |a, c| edit::<AirFlow>(a, c.air, |w| w.drag *= 0.5)),
        ("air lift", |a, c| edit::<AirFlow>(a, c.air, |w| w.lift = 0.0)),
        ("air gusts", |a, c| edit::<AirFlow>(a, c.air, |w| w.gusts = 0.0)),
        ("eddies", |a, c| edit::<AirFlow>(a, c.air, |w| w.gust_length = 1.0)),
        ("their period", |a, c| edit::<AirFlow>(a, c.air, |w| w.gust_period = 0.5)),
        ("loose particles", |a, c| edit::<AirFlow>(a, c.air, |w| w.on_particles = false)),
        ("fluid", |a, c| edit::<Fluid>(a, c.fluid, |f| f.density *= 0.5)),
        ("fluid drag", |a, c| edit::<Fluid>(a, c.fluid, |f| f.drag = 0.1)),
        ("current", |a, c| edit::<Fluid>(a, c.fluid, |f| f.current.z = 2.0)),
        ("level", |a, c| edit::<Transform>(a, c.fluid, |t| t.translation.y += 0.1)),
        ("pool", |a, c| edit::<Region>(a, c.fluid, |r| r.fade = 4.0)),
        ("field", |a, c| edit::<ElectricField>(a, c.field, |f| f.field.x = 9.0)),
        ("sun", |a, c| edit::<Attractor>(a, c.sun, |s| s.strength = -5.0)),
        ("its softening", |a, c| edit::<Attractor>(a, c.sun, |s| s.softening = 3.0)),
        ("its place", |a, c| edit::<Transform>(a, c.sun, |t| t.translation.y += 3.0)),
        ("hull", |a, c| edit::<Floats>(a, c.raft, |f| *f = Floats::boxed(Vec3::splat(0.4)))),
        ("no hull", |a, c| _ = a.world_mut().entity_mut(c.raft).remove::<Floats>()),
        ("weight", |a, c| edit::<GravityScale>(a, c.raft, |g| g.0 = 1.5)),
        ("weight of one", |a, c| edit::<GravityScale>(a, c.ion, |g| g.0 = 1.5)),
        ("law", |a, _| a.world_mut().resource_mut::<Electric>().field.x = 5.0),
        ("flat", |a, _| _ = a.world_mut().spawn(Flatland)),
    ];
    let (mut app, cast) = played(30);
    let start = SinewSnapshot::capture(app.world());
    tick(&mut app, 1);
    let unedited = hash(&mut app);
    // From the same instant in a new app, because some edits leave state behind.
    let after = |name: &str, change: Edit| {
        let mut app = bare_app();
        let map = start.restore(app.world_mut()).unwrap();
        let of = |entity: Entity| map[&entity];
        let cast = Cast {
            wind: of(cast.wind),
            air: of(cast.air),
            fluid: of(cast.fluid),
            field: of(cast.field),
            sun: of(cast.sun),
            raft: of(cast.raft),
            ion: of(cast.ion),
        };
        change(&mut app, &cast);
        tick(&mut app, 1);
        assert_eq!(heard(&app), [], "{name}");
        hash(&mut app)
    };
    assert_eq!(after("no edit", |_, _| ()), unedited);
    for &(name, change) in edits {
        assert_ne!(after(name, change), unedited, "{name}");
    }
}

/// State of the first `count` particles, in the order of creation.
fn state(app: &mut App, count: usize) -> Vec<[u32; 10]> {
    let world = app.world_mut();
    let mut all: Vec<(CreationOrder, Particle)> =
        world.query::<(&CreationOrder, &Particle)>().iter(world).map(|(o, p)| (*o, *p)).collect();
    all.sort_by_key(|(order, _)| *order);
    all.iter().take(count).map(|(_, particle)| bits(particle)).collect()
}

/// Applies `breaks` in one app and `instead`, its valid equivalent, in another. Asserts one message about the broken entity, and the same bits in both.
fn as_if(
    name: &str,
    breaks: impl FnOnce(&mut App, &Cast) -> (Entity, Refusal),
    instead: impl FnOnce(&mut App, &Cast),
) {
    let ((mut broken, cast), (mut well, same)) = (played(10), played(10));
    let count = state(&mut broken, usize::MAX).len();
    let expected = breaks(&mut broken, &cast);
    instead(&mut well, &same);
    for _ in 0..15 {
        tick(&mut broken, 1);
        tick(&mut well, 1);
        assert_eq!(state(&mut broken, count), state(&mut well, count), "{name}");
    }
    assert_eq!(heard(&broken), [expected], "{name}");
    assert_eq!(heard(&well), [], "{name}");
}

#[test]
fn a_broken_number_is_refused_once_and_acts_as_if_its_entity_were_not_there() {
    const BAD: f32 = f32::NAN;
    type Break = fn(&mut App, &Cast) -> Entity;
    fn put(app: &mut App, bundle: impl Bundle) -> Entity {
        app.world_mut().spawn(bundle).id()
    }
    let cases: &[(&str, Break)] = &[
        ("wind", |a, _| put(a, Wind { pressure: Vec3::splat(BAD), ..default() })),
        ("its fade", |a, _| put(a, (Wind::default(), Region::sphere(1.0).with_fade(BAD)))),
        ("its box", |a, _| put(a, (Wind::default(), Region::boxed(Vec3::new(2.0, -2.0, 2.0))))),
        ("its height", |a, _| put(a, (Wind::default(), Region::cylinder(1.0, BAD)))),
        ("below zero", |a, _| put(a, (Wind::default(), Region::capsule(1.0, -2.0)))),
        ("its place", |a, _| {
            let nowhere = Transform::from_xyz(0.0, BAD, 0.0);
            put(a, (Wind::default(), Region::sphere(1.0), nowhere))
        }),
        ("no turn", |a, _| {
            let none = Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
            put(a, (Wind::default(), Region::capsule(1.0, 2.0), none))
        }),
        ("air", |a, _| put(a, AirFlow::steady(Vec3::X * BAD))),
        ("air density", |a, _| put(a, AirFlow { density: -1.0, ..default() })),
        ("air gusts", |a, _| put(a, AirFlow { gust_period: BAD, ..default() })),
        ("air region", |a, _| put(a, (AirFlow::default(), Region::sphere(BAD)))),
        ("current", |a, _| put(a, Fluid::flowing(Vec3::Z * BAD))),
        ("pool", |a, _| put(a, (Fluid::default(), Region::sphere(BAD)))),
        ("field", |a, _| put(a, ElectricField::new(Vec3::Z * f32::INFINITY))),
        ("field region", |a, _| put(a, (ElectricField::new(Vec3::X), Region::sphere(0.0)))),
        ("attractor", |a, _| put(a, Attractor::new(BAD))),
        ("softening", |a, _| put(a, Attractor::default().with_softening(-1.0))),
        ("nowhere", |a, _| put(a, (Attractor::default(), Transform::from_xyz(BAD, 0.0, 0.0)))),
        ("flatland", |a, _| put(a, (Flatland, Transform::from_xyz(0.0, 0.0, BAD)))),
        ("two things", |a, _| {
            put(a, (Attractor::default().with_softening(BAD), AirFlow::steady(Vec3::ZERO)))
        }),
    ];
    for &(name, breaks) in cases {
        let break_it = |app: &mut App, cast: &Cast| (breaks(app, cast), Refusal::Field);
        // The last case has two components on one entity, of which one is valid: its still air acts.
        let sound = |app: &mut App, _: &Cast| {
            if name == "two things" {
                app.world_mut().spawn(AirFlow::steady(Vec3::ZERO));
            }
        };
        as_if(name, break_it, sound);
    }
}

#[test]
fn a_broken_gravity_scale_or_hull_is_refused_once_and_the_body_goes_on_without_it() {
    as_if(
        "weight of a body",
        |app, cast| {
            edit::<GravityScale>(app, cast.raft, |g| g.0 = f32::NAN);
            (cast.raft, Refusal::GravityScale)
        },
        |app, cast| _ = app.world_mut().entity_mut(cast.raft).remove::<GravityScale>(),
    );
    as_if(
        "weight of a particle",
        |app, _| {
            let stone = (Particle::at(Vec3::X * 30.0), GravityScale(f32::INFINITY));
            let stone = app.world_mut().spawn(stone).id();
            (stone, Refusal::Particle(ParticleFault::GravityScale))
        },
        |_, _| (),
    );
    let hulls = [
        (Floats::boxed(Vec3::NAN), HullFault::Number),
        (Floats::mesh([Vec3::ZERO], []), HullFault::Empty),
        (Floats::mesh([Vec3::ZERO], [[0, 0, 1]]), HullFault::MissingVertex),
        (Floats { shape: HullShape::Surface }, HullFault::Empty),
    ];
    for (bad, fault) in hulls {
        as_if(
            "hull",
            |app, cast| {
                edit::<Floats>(app, cast.raft, |floats| *floats = bad);
                (cast.raft, Refusal::Hull(fault))
            },
            |app, cast| _ = app.world_mut().entity_mut(cast.raft).remove::<Floats>(),
        );
    }
}

/// The entity that holds a resource.
fn home<R: Resource>(app: &mut App) -> Entity {
    let world = app.world_mut();
    world.query_filtered::<Entity, With<R>>().single(world).unwrap()
}

#[test]
fn a_broken_resource_is_refused_once_by_its_entity_and_does_nothing() {
    as_if(
        "gravity",
        |app, _| {
            app.insert_resource(Gravity(Vec3::Y * f32::NAN));
            (home::<Gravity>(app), Refusal::Resource("Gravity"))
        },
        |app, _| _ = app.insert_resource(Gravity(Vec3::ZERO)),
    );
    for bad in [f32::NAN, -0.5, 2.0] {
        as_if(
            "drag",
            |app, _| {
                app.insert_resource(AirDrag(bad));
                (home::<AirDrag>(app), Refusal::Resource("AirDrag"))
            },
            |app, _| _ = app.insert_resource(AirDrag(0.0)),
        );
    }
    let sound = Electric { constant: 2.0, softening: 0.1, field: Vec3::X, ..default() };
    let laws = [
        Electric { constant: f32::NAN, ..sound },
        Electric { softening: -1.0, ..sound },
        Electric { field: Vec3::NAN, ..sound },
        Electric { opening: 0.0, ..sound },
    ];
    for law in laws {
        as_if(
            "law",
            |app, _| {
                app.insert_resource(law);
                (home::<Electric>(app), Refusal::Resource("Electric"))
            },
            |app, _| _ = app.insert_resource(Electric { constant: 0.0, ..default() }),
        );
    }
}

#[test]
fn a_repaired_attractor_acts_again_and_is_named_again_when_it_breaks_again() {
    let (mut app, cast) = played(3);
    for strength in [f32::NAN, 3.0, f32::NAN] {
        edit::<Attractor>(&mut app, cast.sun, |sun| sun.strength = strength);
        tick(&mut app, 4);
        let list = app.world().resource::<SinewWorld>().simulation().forces.attractors.len();
        assert_eq!(list, usize::from(strength.is_finite()));
    }
    let named = (cast.sun, Refusal::Field);
    assert_eq!(heard(&app), [named.clone(), named]);
}

#[test]
fn all_forces_go_on_from_cloned_components_bit_for_bit() {
    let (mut app, _) = played(40);
    let saved = SinewSnapshot::capture(app.world());
    let go_on = |app: &mut App| -> Vec<u64> {
        (0..60)
            .map(|_| {
                tick(app, 1);
                hash(app)
            })
            .collect()
    };
    let first = go_on(&mut app);
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(go_on(&mut app), first, "put back in place");
    let mut fresh = bare_app();
    saved.restore(fresh.world_mut()).unwrap();
    assert_eq!(go_on(&mut fresh), first, "in an app that never saw it");
    assert_eq!(heard(&app), []);
}
