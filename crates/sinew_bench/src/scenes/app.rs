//! P10 to P12: cost of the plugin in an app with `MinimalPlugins`, frame by frame; each frame is a tick unless stated otherwise.

use core::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::{
    BodyConstraints, Cloth, ClothPins, DistanceConstraint, Ground, Ragdoll, RigidBox, SinewPlugin,
    SolverConfig,
};

use super::allocations;
use crate::measure::{Effort, World as Contender, median, time};
use crate::row::{Row, Stretch, Unit};

/// Duration of a tick of the fixed schedule and of a frame: 60 Hz.
const TICK: Duration = Duration::from_nanos(16_666_667);

/// Vertices along a side of the cloth that is spawned and despawned.
const SIDE: u32 = 64;

/// Vertices along a side of the cloth whose mesh is written.
const DRAWN: u32 = 128;

/// Frames in a timed portion; an empty frame takes microseconds.
const FRAMES: usize = 200;

/// Frames before anything is timed.
const WARM: usize = 20;

/// P10.
pub(super) fn come_and_go(effort: &Effort) -> Vec<Row> {
    let mut app = plain();
    app.add_plugins(SinewPlugin::default());
    let mut app = ready(app);
    // The result is the difference to a frame without a spawn or despawn, so the rest of the frame is kept short.
    app.insert_resource(SolverConfig { substeps: 1, max_sweeps: 1, ..default() });
    let cut = app.world_mut().resource_mut::<Assets<Mesh>>().add(square(SIDE));
    let [mut spawn, mut despawn, mut tear] = [const { Vec::new() }; 3];
    let mut constraints = 0;
    for _ in 0..effort.rounds.max(1) {
        frames(&mut app, WARM);
        let empty = frame(&mut app, |_| {});
        let cloth = Cloth::from_mesh().pinned(ClothPins::TopCorners);
        let recipe = (cloth, Mesh3d(cut.clone()));
        let mut body = Entity::PLACEHOLDER;
        let built = frame(&mut app, |world| body = world.spawn(recipe).id());
        frames(&mut app, WARM);
        let whole = frame(&mut app, |_| {});
        let ties: Vec<Entity> = app
            .world()
            .get::<BodyConstraints>(body)
            .into_iter()
            .flat_map(RelationshipTarget::iter)
            .collect();
        constraints = ties.len();
        let torn = frame(&mut app, |world| {
            world.despawn(ties[constraints / 2]);
        });
        frames(&mut app, WARM);
        let gone = frame(&mut app, |world| {
            world.despawn(body);
        });
        spawn.push(built - whole);
        tear.push(torn - whole);
        despawn.push(gone - empty);
    }
    let row = |what: &str, times: Vec<f64>| {
        let scene = format!("{what} a {SIDE}×{SIDE} cloth from a mesh");
        let row = Row::new("P10", scene, Unit::Once).sized(constraints, 1, 1);
        Row { ours: Some(1e9 * median(times)), ..row }
    };
    let mut rows = vec![
        row("spawn", spawn).noted(LESS),
        row("despawn", despawn).noted(LESS),
        row("tear one constraint of", tear).noted(LESS),
    ];
    rows.extend(beside_others(effort));
    rows
}

/// Note of rows that compare a frame with a spawn or despawn to one without.
const LESS: &str = "difference between a frame with and one without it";

/// The same for a box beside eight such cloths, and for a constraint of one of them, at the default substeps and sweeps.
fn beside_others(effort: &Effort) -> Vec<Row> {
    let mut app = plain();
    app.add_plugins(SinewPlugin::default());
    let mut app = ready(app);
    for n in 0..8 {
        let cloth = Cloth::grid(2.0, 2.0, SIDE - 1, SIDE - 1).pinned(ClothPins::TopCorners);
        app.world_mut().spawn((cloth, Transform::from_xyz(3.0 * n as f32, 0.0, 0.0)));
    }
    frames(&mut app, WARM);
    let mut ties = app.world_mut().query_filtered::<Entity, With<DistanceConstraint>>();
    let ties: Vec<Entity> = ties.iter(app.world()).collect();
    let [mut spawn, mut despawn, mut tear] = [const { Vec::new() }; 3];
    for n in 0..4 * effort.rounds.max(1) {
        let before = frame(&mut app, |_| {});
        let (mut body, place) = (Entity::PLACEHOLDER, Transform::from_xyz(-3.0, 0.0, 0.0));
        let recipe = (RigidBox::new(Vec3::ONE), place);
        let built = frame(&mut app, |world| body = world.spawn(recipe).id());
        frames(&mut app, 2);
        let torn = frame(&mut app, |world| {
            world.despawn(ties[n * 7919 % ties.len()]);
        });
        frames(&mut app, 2);
        let gone = frame(&mut app, |world| {
            world.despawn(body);
        });
        frames(&mut app, 2);
        let whole = 0.5 * (before + frame(&mut app, |_| {}));
        spawn.push(built - whole);
        despawn.push(gone - whole);
        tear.push(torn - whole);
    }
    let row = |what: &str, times: Vec<f64>| {
        let row = Row::new("P10", format!("{what} 8 cloths of {SIDE}×{SIDE}"), Unit::Once);
        Row { ours: Some(1e9 * median(times)), ..row.sized(ties.len(), 10, 4) }.noted(LESS)
    };
    vec![
        row("spawn a box beside", spawn),
        row("despawn a box beside", despawn),
        row("tear one constraint of", tear),
    ]
}

/// P11.
pub(super) fn ticks(effort: &Effort) -> Vec<Row> {
    let row = |what: &str, fill: fn(&mut World)| {
        let mut app = plain();
        app.add_plugins(SinewPlugin::default());
        let mut with = ready(app);
        fill(with.world_mut());
        let mut without = ready(plain());
        let [mut ours, mut bare] = [const { Vec::new() }; 2];
        for app in [&mut with, &mut without] {
            frames(app, WARM);
        }
        for _ in 0..effort.rounds.max(1) {
            for (app, times) in [(&mut with, &mut ours), (&mut without, &mut bare)] {
                times.push(1e9 * time(FRAMES, || frames(app, FRAMES)).cpu);
            }
        }
        let (whole, bare) = (median(ours), median(bare));
        let row = Row::new("P11", format!("a tick of {what}"), Unit::Tick);
        let note =
            format!("a frame takes {:.1} µs, without the plugin {:.1}", whole / 1e3, bare / 1e3);
        Row { ours: Some(whole - bare), ..row }.noted(note)
    };
    let dolls = |world: &mut World| {
        world.spawn(Ground);
        for n in 0..10 {
            let place = Transform::from_xyz(2.0 * n as f32, 0.5, 0.0);
            world.spawn((Ragdoll::default(), place));
        }
    };
    vec![row("an empty world", |_| {}), row("10 ragdolls, default settings", dolls)]
}

/// P12.
pub(super) fn mesh_out(effort: &Effort) -> Vec<Row> {
    let mut app = hung(DRAWN);
    frames(&mut app, WARM);
    // Time stands still from here on, so the only work is to redraw a mesh that is marked as changed.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    frames(&mut app, WARM);
    let [mut drawn, mut idle] = [const { Vec::new() }; 2];
    for _ in 0..effort.rounds.max(1) {
        drawn.push(
            time(20, || {
                (0..20).for_each(|_| {
                    touch(app.world_mut());
                    app.update();
                });
            })
            .cpu,
        );
        idle.push(time(20, || frames(&mut app, 20)).cpu);
    }
    let count = f64::from(DRAWN * DRAWN);
    let scene = format!("mesh out: {DRAWN}×{DRAWN} vertices and normals");
    let ours = Some(1e9 * (median(drawn) - median(idle)) / count);
    let row = Row { ours, ..Row::new("P12", scene, Unit::Vertex) };
    vec![row.noted("difference between a frame that updates the mesh and one that does not, both without a tick")]
}

/// P13 for an app.
pub(super) fn allocations(_: &Effort) -> Vec<Row> {
    let mut app = plain();
    app.add_plugins(SinewPlugin::default());
    let bare = allocations::row("an app without the plugin", &mut Frames(ready(plain())));
    let empty = allocations::row("an app with an empty world", &mut Frames(ready(app)));
    let cloth = allocations::row("an app with a cloth and its mesh", &mut Frames(hung(32)));
    vec![bare.noted("what Bevy itself allocates in a frame"), empty, cloth]
}

/// An app as a contender.
struct Frames(App);

impl Contender for Frames {
    fn tick(&mut self) {
        self.0.update();
    }

    fn stretch(&self) -> Option<Stretch> {
        None
    }
}

/// An app without the plugin, with meshes.
fn plain() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
    app.init_asset::<Mesh>();
    app
}

fn ready(mut app: App) -> App {
    app.insert_resource(Time::<Fixed>::from_duration(TICK));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
    app.finish();
    app.cleanup();
    app
}

/// An app with one cloth made from a mesh, hung by two corners.
fn hung(side: u32) -> App {
    let mut app = plain();
    app.add_plugins(SinewPlugin::default());
    let mut app = ready(app);
    let cut = app.world_mut().resource_mut::<Assets<Mesh>>().add(square(side));
    let cloth = Cloth::from_mesh().pinned(ClothPins::TopCorners);
    app.world_mut().spawn((cloth, Mesh3d(cut)));
    app
}

/// A square of 1 m with `side` vertices along each edge.
fn square(side: u32) -> Mesh {
    Plane3d::new(Vec3::Z, Vec2::splat(0.5)).mesh().subdivisions(side - 2).build()
}

fn frames(app: &mut App, count: usize) {
    (0..count).for_each(|_| app.update());
}

/// Duration of a frame, seconds, including `first` at its start.
fn frame(app: &mut App, first: impl FnOnce(&mut World)) -> f64 {
    let mut first = Some(first);
    time(1, || {
        if let Some(first) = first.take() {
            first(app.world_mut());
        }
        app.update();
    })
    .cpu
}

/// Marks every mesh as changed.
fn touch(world: &mut World) {
    let mut meshes = world.query::<&mut Mesh3d>();
    meshes.iter_mut(world).for_each(|mut mesh| mesh.set_changed());
}
