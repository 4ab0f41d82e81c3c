//! U1 to U13, the user scenes: whole frames of apps with `MinimalPlugins` and `SinewPlugins` at default settings (with four substeps where a row says so), with
//! a ground, on one thread or, with `--threads`, on the default threads of an app.
//!
//! A frame is a tick of 1/60 s. The time is the mean over all frames from the first second to the fourth, when bodies are in contact. The quality is measured
//! over the last two seconds: the mean and the largest relative error of hard distances, the root mean square of the speeds, and for boxes the deepest
//! penetration at the end. The note also has the engine's part of the time. rapier3d takes turns with Sinew in the rigid scenes, by itself without an app, and
//! Avian in an app, both at their default settings; the stretch of their ragdolls is the opening of joints.

use core::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyContacts, BodyParticles, PhaseSystems, Region, SleepingDisabled, SubstepSchedule, TickTime,
};
use sinew::Simulation;
use sinew::pose::Pose;

use super::calm::deepest;
use crate::measure::{Cube, Effort, Took, World as Contender, mean_square, stretch_of, time};
use crate::peers::{self, Rivals};
use crate::places;
use crate::row::{Row, Stretch, Unit};

/// Duration of a tick of the fixed schedule and of a frame: 60 Hz.
const TICK: Duration = Duration::from_nanos(16_666_667);

/// Frames before timing starts, timed frames, and of those the last ones, over which the quality is measured: one second, three, two.
const WARM: usize = 60;
const TIMED: usize = 180;
const JUDGED: usize = 120;

/// Frames between two measurements of the quality, which are not timed.
const LOOK: usize = 12;

/// A scene: its number, its title, the function that fills the world, and the same scene in other engines.
struct Level {
    id: &'static str,
    what: &'static str,
    fill: fn(&mut World),
    peers: fn(&Effort) -> Rivals,
    /// Substeps in a tick, if not the default number.
    substeps: Option<u32>,
}

const fn level(id: &'static str, what: &'static str, fill: fn(&mut World)) -> Level {
    Level { id, what, fill, peers: |_| Rivals { rapier: None, avian: None }, substeps: None }
}

impl Level {
    /// Adds other engines, which set up the same scene.
    const fn beside(self, peers: fn(&Effort) -> Rivals) -> Self {
        Self { peers, ..self }
    }

    /// The scene with four substeps, the default of rapier.
    const fn with_four_substeps(self) -> Self {
        Self { what: "the same with four substeps", substeps: Some(4), ..self }
    }
}

/// U1 to U9, U12 and U13.
const LEVELS: &[Level] = &[
    level("U1", "a cape of 24×24 dropped on a ball", |world| cape(world, ClothPins::None)),
    level("U1", "a cape of 24×24 hung over a ball, steady wind", |world| {
        cape(world, ClothPins::TopEdge);
        world.spawn(Wind { pressure: Vec3::new(2.0, 0.0, 4.0), ..default() });
    }),
    level("U2", "the gallery's flag, gusts", flag),
    level("U3", "cloth of 64×64 falls on a ball", |world| draped(world, false)),
    level("U3", "the same, folded on itself, with self-contact", |world| draped(world, true)),
    level("U4", "cloth of 128×128 hung by two corners, wind", |world| {
        world.spawn(Wind { pressure: Vec3::new(0.0, 0.0, 5.0), ..default() });
        let cloth = Cloth::grid(2.0, 2.0, 127, 127).pinned(ClothPins::TopCorners);
        world.spawn((cloth, Transform::from_xyz(0.0, 2.5, 0.0)));
    }),
    level("U5", "20 ropes of 32 over a beam, weights", ropes),
    HEAP,
    POURED,
    POURED.with_four_substeps(),
    ON_A_FLOOR,
    ON_A_FLOOR.with_four_substeps(),
    DOWN_STAIRS,
    DOWN_STAIRS.with_four_substeps(),
    level("U8", "200 jelly cubes into a bin", jelly),
    level("U9", "a level of all of it", of_all),
    level("U12", "a crate of 5 kg is tossed into a sheet of 64×64 held at its corners", caught),
    level("U12", "a figure flies at a hanging sheet of 64×64", flown_at),
    level("U12", "a sheet of 64×64 falls on nine crates", on_crates),
    level("U12", "a sheet of 64×64 falls on another one on a ball", on_another),
    level("U13", "a sheet of 64×64 falls on the ground", on_the_ground),
    level("U13", "a sheet of 64×64 falls on hills", |world| {
        hills(world);
        on_the_ground(world);
    }),
    level("U13", "100 ragdolls fall on hills", |world| {
        hills(world);
        figures(world, 0.0);
    }),
    level("U13", "1000 boxes in rows fall on hills", |world| {
        hills(world);
        boxes(world, false);
    }),
];

const HEAP: Level = level("U6", "1000 boxes in rows fall into a heap", |world| boxes(world, false))
    .beside(|effort| peers::pile(effort, false));
const POURED: Level =
    level("U6", "1000 boxes poured between four walls", |world| boxes(world, true))
        .beside(|effort| peers::pile(effort, true));
const ON_A_FLOOR: Level = level("U7", "100 ragdolls on a floor", |world| figures(world, 0.0))
    .beside(|effort| peers::figures(effort, 0.0));
const DOWN_STAIRS: Level = level("U7", "100 ragdolls down stairs", |world| figures(world, 0.24))
    .beside(|effort| peers::figures(effort, 0.24));

/// Measures the scenes of one number.
fn run(id: &str, effort: &Effort) -> Vec<Row> {
    let levels = LEVELS.iter().filter(|level| level.id == id);
    levels.map(|level| measured(level, effort, |world| with_ground(world, level.fill))).collect()
}

macro_rules! users {
    ($($name:ident $id:literal),*) => {$(
        pub(super) fn $name(effort: &Effort) -> Vec<Row> {
            run($id, effort)
        }
    )*};
}

users!(
    u1 "U1", u2 "U2", u3 "U3", u4 "U4", u5 "U5", u6 "U6", u7 "U7", u8 "U8", u9 "U9", u12 "U12",
    u13 "U13"
);

/// U10: cost of a ground, a far collider, a wind and a system of the game between two phases in each scene, relative to the frame without any of them.
///
/// Cloth and ropes are run without a ground. Falling bodies have one, since falling for ever is no realistic scene, and are kept awake, so that the same bodies
/// are active in every variant: a wind wakes the bodies that it moves, and these boxes are no denser than air. The sleeping scene is compared only with a
/// system of the game.
pub(super) fn u10(effort: &Effort) -> Vec<Row> {
    let falls = |level: &Level| ["U6", "U7", "U8"].contains(&level.id);
    let asleep = level("U11", "1000 boxes side by side, asleep", |world| lying(world, true));
    let by_default = LEVELS
        .iter()
        .filter(|level| level.substeps.is_none() && !["U12", "U13"].contains(&level.id));
    by_default
        .map(|level| match falls(level) {
            false => with_extras(level, effort, |_| {}, &[A_GROUND, FAR, A_WIND, OWN_SYSTEM]),
            true => with_extras(level, effort, awake_on_a_ground, &[FAR, A_WIND, OWN_SYSTEM]),
        })
        .chain([with_extras(&asleep, effort, |world| with_ground(world, |_| {}), &[OWN_SYSTEM])])
        .collect()
}

/// The name of an addition to a scene, and the function that adds it.
type Extra = (&'static str, fn(&mut World));

const A_GROUND: Extra = ("a ground", |world| {
    world.spawn(Ground);
});
const FAR: Extra = ("a far collider", |world| {
    world.spawn((Collider::sphere(1.0), Transform::from_xyz(100.0, -50.0, 0.0)));
});
const A_WIND: Extra = ("a wind", |world| {
    world.spawn(Wind::default());
});
const OWN_SYSTEM: Extra = ("a system of the game", |world| {
    let own = nothing.in_set(PhaseSystems::Integrate);
    world.resource_mut::<Schedules>().add_systems(SubstepSchedule, own);
});

/// Adds a ground, and keeps all bodies awake.
fn awake_on_a_ground(world: &mut World) {
    world.spawn(Ground);
    world.resource_mut::<Schedules>().add_systems(Update, stay_awake);
}

fn stay_awake(
    mut commands: Commands,
    sleepers: Query<Entity, (With<Sleep>, Without<SleepingDisabled>)>,
) {
    for entity in &sleepers {
        commands.entity(entity).insert(SleepingDisabled);
    }
}

/// The scene with `around` applied, and in the note the relative cost of each extra.
fn with_extras(level: &Level, effort: &Effort, around: fn(&mut World), extras: &[Extra]) -> Row {
    let run = |fill: fn(&mut World)| {
        measured(level, effort, |world| {
            around(world);
            (level.fill)(world);
            fill(world);
        })
    };
    let bare = run(|_| {});
    let share = |with: Row| with.ours.unwrap_or(f64::NAN) / bare.ours.unwrap_or(f64::NAN);
    let shares = extras.iter().map(|(what, fill)| format!("{what} {:.2}×", share(run(*fill))));
    let shares = shares.collect::<Vec<_>>().join(", ");
    Row { id: "U10", stretch: None, ..bare }.noted(shares)
}

/// U11.
pub(super) fn u11(effort: &Effort) -> Vec<Row> {
    // A typical level: one body moves and all others rest.
    let one_awake = |world: &mut World| {
        lying(world, true);
        let place = Transform::from_xyz(-3.0, 0.5, -3.0);
        world.spawn((RigidBox::new(Vec3::ONE), place, SleepingDisabled));
    };
    let awake = level("U11", "1000 boxes side by side, awake", |_| {})
        .beside(|effort| peers::lying(effort, false));
    let asleep = level("U11", "1000 boxes side by side, asleep", |_| {})
        .beside(|effort| peers::lying(effort, true));
    let but_one = level("U11", "1000 boxes side by side, asleep, and one awake", |_| {});
    vec![
        measured(&asleep, effort, |world| with_ground(world, |world| lying(world, true))),
        measured(&but_one, effort, |world| with_ground(world, one_awake)),
        measured(&awake, effort, |world| with_ground(world, |world| lying(world, false))),
    ]
}

/// A thousand boxes side by side, which may sleep or not.
fn lying(world: &mut World, sleeps: bool) {
    for place in places::lying() {
        let mut body = world.spawn((RigidBox::new(Vec3::ONE), Transform::from_translation(place)));
        if !sleeps {
            body.insert(SleepingDisabled);
        }
    }
}

/// A system of the game that does nothing.
fn nothing() {}

fn with_ground(world: &mut World, fill: impl FnOnce(&mut World)) {
    world.spawn(Ground);
    fill(world);
}

/// Runs a scene and fills in its row.
fn measured(level: &Level, effort: &Effort, fill: impl FnOnce(&mut World)) -> Row {
    let mut ours = UserApp::new(effort, fill);
    if let Some(substeps) = level.substeps {
        ours.app.world_mut().resource_mut::<SolverConfig>().substeps = substeps;
    }
    let Rivals { rapier, avian } = (level.peers)(effort);
    let mut rivals = [("rapier", rapier), ("Avian", avian)];
    let short = if effort.quick { 10 } else { 1 };
    // Bodies are built in the first tick; only then can the weights be attached to them.
    ours.tick();
    load_ends(ours.app.world_mut());
    (0..WARM / short).for_each(|_| ours.tick());
    for rival in rivals.iter_mut().filter_map(|(_, rival)| rival.as_mut()) {
        (0..=WARM / short).for_each(|_| rival.tick());
    }
    ours.substeps = Duration::ZERO;
    let (mut own, mut theirs) = (Contest::default(), [Contest::default(), Contest::default()]);
    let all = TIMED / short;
    let mut done = 0;
    while done < all {
        let frames = LOOK.min(all - done);
        done += frames;
        let judged = all - done <= JUDGED / short;
        own.run(&mut ours, frames, judged);
        for ((_, rival), contest) in rivals.iter_mut().zip(&mut theirs) {
            if let Some(rival) = rival {
                contest.run(rival.as_mut(), frames, judged);
            }
        }
    }
    let engine = 100.0 * ours.substeps.as_secs_f64() / own.took.wall;
    let is_cubes = !ours.cubes().is_empty();
    let mut note = format!("engine {engine:.0} %; {}", own.quality(&ours, is_cubes));
    for ((name, rival), contest) in rivals.iter().zip(&theirs) {
        if let Some(rival) = rival {
            note += &format!("; {name} {}", contest.quality(rival.as_ref(), is_cubes));
        }
    }
    let settings = *ours.app.world().resource::<SolverConfig>();
    let count = ours.simulation().distances().len();
    let row = Row::new(level.id, level.what, Unit::Tick);
    let row = row.sized(count, settings.substeps, settings.max_sweeps).noted(note);
    let spent = |contest: &Contest| {
        let Took { cpu, wall } = contest.took;
        let seconds = if effort.threads { wall } else { cpu };
        (seconds > 0.0).then_some(1e9 * seconds / all as f64)
    };
    let [rapier, avian] = &theirs;
    Row {
        ours: spent(&own),
        peer: spent(rapier),
        avian: spent(avian),
        stretch: own.stretch(),
        peer_stretch: rapier.stretch(),
        avian_stretch: avian.stretch(),
        ..row
    }
}

/// An app as in the README.
struct UserApp {
    app: App,
    /// Total duration of the substeps in the frames so far.
    substeps: Duration,
}

impl UserApp {
    fn new(effort: &Effort, fill: impl FnOnce(&mut World)) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
        app.init_asset::<Mesh>();
        app.add_plugins(SinewPlugins);
        app.insert_resource(Time::<Fixed>::from_duration(TICK));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK));
        app.world_mut().resource_mut::<SolverConfig>().threads = effort.threads;
        app.finish();
        app.cleanup();
        fill(app.world_mut());
        Self { app, substeps: Duration::ZERO }
    }

    fn simulation(&self) -> &Simulation {
        self.app.world().resource::<SinewWorld>().simulation()
    }
}

impl Contender for UserApp {
    fn tick(&mut self) {
        self.app.update();
        self.substeps += self.app.world().resource::<TickTime>().substeps;
    }

    fn stretch(&self) -> Option<Stretch> {
        let world = self.simulation();
        stretch_of(world.distances(), |i| world.particles.position(i))
    }

    fn cubes(&self) -> Vec<Cube> {
        let world = self.app.world();
        let Some(mut boxes) = world.try_query::<(&RigidBox, &Transform, &LinearVelocity)>() else {
            return Vec::new();
        };
        let whole = boxes.iter(world).filter(|(own, ..)| own.size == Vec3::ONE);
        let cube = |(_, &Transform { translation, rotation, .. }, velocity): (_, &_, &_)| {
            let LinearVelocity(velocity) = *velocity;
            Cube { pose: Pose { translation, rotation }, velocity }
        };
        whole.map(cube).collect()
    }

    fn speeds(&self) -> Vec<Vec3> {
        let cubes = self.cubes();
        if !cubes.is_empty() {
            return cubes.iter().map(|cube| cube.velocity).collect();
        }
        let particles = &self.simulation().particles;
        (0..particles.len()).map(|i| particles.velocity(i)).collect()
    }
}

/// Time and quality of a contender, accumulated over several measurements.
struct Contest {
    /// Total time, seconds.
    took: Took,
    looks: u32,
    mean: f64,
    max: f64,
    squares: f64,
}

impl Default for Contest {
    fn default() -> Self {
        Self { took: Took { cpu: 0.0, wall: 0.0 }, looks: 0, mean: 0.0, max: 0.0, squares: 0.0 }
    }
}

impl Contest {
    /// Runs and times `frames` frames, and measures the quality after them if `judged`.
    fn run(&mut self, world: &mut dyn Contender, frames: usize, judged: bool) {
        let took = time(1, || (0..frames).for_each(|_| world.tick()));
        self.took.cpu += took.cpu;
        self.took.wall += took.wall;
        if judged {
            if let Some(now) = world.stretch() {
                self.mean += now.mean;
                self.max = self.max.max(now.max);
            }
            self.squares += mean_square(&world.speeds());
            self.looks += 1;
        }
    }

    fn stretch(&self) -> Option<Stretch> {
        let mean = self.mean / f64::from(self.looks.max(1));
        (self.max > 0.0).then_some(Stretch { mean, max: self.max })
    }

    /// Quality as text: the root mean square of the speeds, and for cubes the deepest penetration of a corner into another cube or the floor at the end.
    fn quality(&self, world: &dyn Contender, is_cubes: bool) -> String {
        let mean = (self.squares / f64::from(self.looks.max(1))).sqrt();
        let speed = format!("{:.1} mm/s", 1e3 * mean);
        if is_cubes {
            format!("{speed}, {:.1} mm deep", 1e3 * deepest(&world.cubes()))
        } else {
            speed
        }
    }
}

/// A rope with a weight, kg, on its last particle.
#[derive(Component)]
struct Load(f32);

/// Attaches the weights to the ropes, once they are built.
fn load_ends(world: &mut World) {
    let mut ropes = world.query::<(&BodyParticles, &Load)>();
    let ends: Vec<(Entity, f32)> = ropes
        .iter(world)
        .filter_map(|(particles, load)| Some((particles.iter().last()?, load.0)))
        .collect();
    for (end, mass) in ends {
        world.entity_mut(end).insert(Mass(mass));
    }
}

fn cape(world: &mut World, pins: ClothPins) {
    world.spawn((Collider::sphere(0.3), Transform::from_xyz(0.0, 1.0, 0.0)));
    let cloth = Cloth::grid(1.2, 1.2, 23, 23);
    let place = if pins == ClothPins::None {
        let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
        Transform::from_xyz(0.05, 1.6, 0.02).with_rotation(flat)
    } else {
        // The cape hangs in front of the ball, and the wind presses it against the ball.
        Transform::from_xyz(0.0, 1.1, -0.35)
    };
    world.spawn((cloth.pinned(pins), place));
}

fn flag(world: &mut World) {
    let pressure = Vec3::new(13.0, 0.0, 3.5);
    world.spawn(Wind { pressure, gusts: 0.55, gust_length: 1.1, gust_period: 0.9 });
    world.insert_resource(AirDrag(0.75));
    let cloth = Cloth { density: 0.18, ..Cloth::grid(1.92, 1.2, 48, 30) };
    let place = Transform::from_xyz(0.99, 2.25, 0.0);
    world.spawn((cloth.pinned(ClothPins::LeftEdge), place));
    let pole = Transform::from_xyz(0.0, 1.475, 0.0);
    world.spawn((Collider::cylinder(0.03, 2.95), pole));
}

fn draped(world: &mut World, folded: bool) {
    world.insert_resource(AirDrag(0.5));
    world.spawn((Collider::sphere(0.5), Transform::from_xyz(0.0, 0.75, 0.0)));
    let turn = Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    let cloth = Cloth { radius: 0.011, ..Cloth::grid(1.7, 1.7, 63, 63) };
    let mut cloth = world.spawn((cloth, Transform::from_xyz(0.0, 1.45, 0.0).with_rotation(turn)));
    if folded {
        cloth.insert(BodyContacts::ALL);
    }
}

/// A sheet of 2 m at a position, vertical or horizontal.
fn sheet(world: &mut World, pins: ClothPins, at: Vec3, level: bool) {
    let turn = if level { -core::f32::consts::FRAC_PI_2 } else { 0.0 };
    let place = Transform::from_translation(at).with_rotation(Quat::from_rotation_x(turn));
    world.spawn((Cloth::grid(2.0, 2.0, 63, 63).pinned(pins), place));
}

/// The crate is tossed up, so that it lands while frames are timed.
fn caught(world: &mut World) {
    sheet(world, ClothPins::Corners, Vec3::Y * 2.0, true);
    let own = RigidBox::new(Vec3::splat(0.4)).with_mass(5.0);
    world.spawn((own, Transform::from_xyz(0.1, 2.5, 0.0), LinearVelocity(Vec3::Y * 5.0)));
}

/// So is the ragdoll.
fn flown_at(world: &mut World) {
    sheet(world, ClothPins::TopEdge, Vec3::Y * 1.3, false);
    let velocity = LinearVelocity(Vec3::new(0.0, 6.0, -5.0));
    world.spawn((Ragdoll::default(), Transform::from_xyz(0.0, 0.6, 5.2), velocity));
}

fn on_crates(world: &mut World) {
    sheet(world, ClothPins::None, Vec3::Y * 1.2, true);
    for (x, z) in (0..9).map(|i| ((i % 3) as f32, (i / 3) as f32)) {
        let place = Transform::from_xyz(0.5 * x - 0.5, 0.15, 0.5 * z - 0.5);
        world.spawn((RigidBox::new(Vec3::splat(0.3)), place));
    }
}

fn on_another(world: &mut World) {
    world.spawn((Collider::sphere(0.5), Transform::from_xyz(0.0, 0.5, 0.0)));
    sheet(world, ClothPins::None, Vec3::Y * 1.2, true);
    sheet(world, ClothPins::None, Vec3::new(0.02, 1.4, 0.0), true);
}

fn on_the_ground(world: &mut World) {
    sheet(world, ClothPins::None, Vec3::Y * 0.8, true);
}

/// Hills of up to half a metre over the ground, in cells of half a metre.
fn hills(world: &mut World) {
    const SIDE: usize = 97;
    let height = |i: usize| {
        let (x, z) = ((i % SIDE) as f32, (i / SIDE) as f32);
        0.25 + 0.15 * ops::sin(0.7 * x) * ops::cos(0.5 * z) + 0.1 * ops::sin(0.3 * (x + z))
    };
    let heights: Vec<f32> = (0..SIDE * SIDE).map(height).collect();
    if let Ok(hills) = Collider::height_field(SIDE, SIDE, &heights, Vec3::new(48.0, 1.0, 48.0)) {
        world.spawn((hills, Transform::default()));
    }
}

fn ropes(world: &mut World) {
    let lies = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let beam = Transform::from_xyz(0.0, 2.0, 2.0).with_rotation(lies);
    world.spawn((Collider::capsule(0.1, 5.0), beam));
    for n in 0..20_u32 {
        let z = 0.2 * n as f32;
        let (from, to) = (Vec3::new(-0.6, 2.13, z), Vec3::new(1.4, 2.13, z));
        let rope = Rope { segments: 32, mass: 0.32, radius: 0.02, ..Rope::between(from, to) };
        world.spawn((rope, Load(0.2)));
    }
}

fn boxes(world: &mut World, poured: bool) {
    for (place, turn) in places::pile(poured) {
        let place = Transform::from_translation(place).with_rotation(turn);
        world.spawn((RigidBox::new(Vec3::ONE), place));
    }
    if poured {
        fixed(world, places::pit());
    }
}

/// A hundred ragdolls above stairs with steps of height `rise`, metres; on the floor if it is 0.
fn figures(world: &mut World, rise: f32) {
    fixed(world, places::flight(rise));
    for (place, turn) in places::figures(rise) {
        let place = Transform::from_translation(place).with_rotation(turn);
        world.spawn((Ragdoll::default(), place));
    }
}

/// Adds static boxes of given sizes at given positions.
fn fixed(world: &mut World, boxes: impl Iterator<Item = (Vec3, Vec3)>) {
    for (size, place) in boxes {
        world.spawn((Collider::cuboid(size), Transform::from_translation(place)));
    }
}

fn jelly(world: &mut World) {
    let (edge, room, high, thick) = (0.26, 2.9, 1.8, 0.06);
    let reach = 0.5 * (room + thick);
    for (x, z) in [(reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)] {
        let along = room + 2.0 * thick;
        let size =
            if z == 0.0 { Vec3::new(thick, high, along) } else { Vec3::new(along, high, thick) };
        world.spawn((Collider::cuboid(size), Transform::from_xyz(x, 0.5 * high, z)));
    }
    for n in 0..200_u32 {
        // None overlaps another, including the radius.
        let (layer, place) = (n / 36, n % 36);
        let [x, z] = [place % 6, place / 6].map(|i| (i as f32 - 2.5) * 0.475);
        let at = Vec3::new(x, (layer as f32 + 0.55) * 0.475, z);
        let angle = |stride: u32| 0.15 * ((n * stride % 13) as f32 / 6.0 - 1.0);
        let turn = Quat::from_euler(EulerRot::XYZ, angle(3), angle(5), angle(7));
        let cube = SoftBody::cuboid(Vec3::splat(edge), UVec3::splat(2));
        let cube = SoftBody { stiffness: 8e3, damping: 0.6, radius: edge / 4.0, ..cube };
        world.spawn((cube, Transform::from_translation(at).with_rotation(turn)));
    }
}

/// 10 ragdolls, 5 capes, 60 crates, 10 ropes, 10 floaters in a river, wind.
fn of_all(world: &mut World) {
    world.spawn(Wind { pressure: Vec3::new(3.0, 0.0, 1.0), gusts: 0.4, ..default() });
    for n in 0..10_u32 {
        let place = Transform::from_xyz(1.5 * n as f32, 1.4, 6.0);
        world.spawn((Ragdoll::default(), place));
        let from = Vec3::new(1.5 * n as f32, 3.0, 9.0);
        let rope = Rope { segments: 20, ..Rope::between(from, from + Vec3::X) };
        world.spawn(rope);
    }
    for n in 0..5_u32 {
        let x = 3.0 * n as f32;
        world.spawn((Collider::sphere(0.3), Transform::from_xyz(x, 1.0, 3.0)));
        let cape = Cloth::grid(1.2, 1.2, 23, 23).pinned(ClothPins::TopEdge);
        world.spawn((cape, Transform::from_xyz(x, 1.1, 2.65)));
    }
    for n in 0..60_u32 {
        let (layer, place) = (n / 20, n % 20);
        let place = Vec3::new(0.7 * place as f32, 0.3 + 0.6 * layer as f32, 0.0);
        let crate_ = RigidBox::new(Vec3::splat(0.5)).with_mass(5.0);
        world.spawn((crate_, Transform::from_translation(place)));
    }
    // A river beside the rest, a metre deep.
    let river = Region::boxed(Vec3::new(40.0, 2.0, 4.0));
    world.spawn((Fluid::flowing(Vec3::X), river, Transform::from_xyz(12.0, 1.0, -5.0)));
    for n in 0..10_u32 {
        let place = Transform::from_xyz(1.5 * n as f32, 1.2, -5.0);
        let floater = RigidBox::new(Vec3::splat(0.5)).with_mass(60.0);
        world.spawn((floater, Floats::default(), place));
    }
}
