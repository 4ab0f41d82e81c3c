//! A rope bridge of planks between two cliffs. A player walks over it with `move_and_slide`, and the bridge swings and sags under the weight.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{MoveAndSlideConfig, QueryFilter, SinewClock, Weighs};

/// A character moved by the game: its vertical velocity, m/s, and the number of ticks it stood on a plank.
#[derive(Component, Default)]
struct Player(f32, u32);

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(SolverConfig { substeps: 20, ..default() });
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, (walk, watch).chain()).run()
}

fn setup(mut commands: Commands) {
    let cliffs = [-3.85, 3.85].map(|x: f32| {
        let rock = Collider::cuboid(Vec3::new(2.0, 2.0, 2.0));
        commands.spawn((rock, Transform::from_xyz(x, -0.97, 0.0))).id()
    });
    let planks: [Entity; 11] = core::array::from_fn(|i| {
        let wood = RigidBox::new(Vec3::new(0.4, 0.06, 1.2)).with_mass(4.0);
        commands.spawn((wood, Transform::from_xyz(-2.5 + 0.5 * i as f32, 0.0, 0.0))).id()
    });
    // On either side, ropes from plank to plank, and from the outer planks to the edges of the cliffs.
    for side in [-1.0, 1.0] {
        let end = |plank, x: f32| (plank, Anchor::Corner(Vec3::new(x, 0.0, side)));
        let edge = |i: usize, x: f32| (cliffs[i], Anchor::Point(Vec3::new(x, 0.97, 0.6 * side)));
        let mut piece = |from, to| {
            let rope = Rope { segments: 2, mass: 0.1, slack: 0.0, ..Rope::between(from, to) };
            commands.spawn(rope);
        };
        piece(edge(0, 1.0), end(planks[0], -1.0));
        planks.windows(2).for_each(|pair| piece(end(pair[0], 1.0), end(pair[1], -1.0)));
        piece(end(planks[10], 1.0), edge(1, -1.0));
    }
    let player = (Player::default(), Collider::capsule(0.3, 1.1), Weighs::new(70.0));
    commands.spawn((player, Transform::from_xyz(-4.3, 0.9, 0.0)));
}

/// Moves the player: from two seconds on to the right, over whatever is below.
fn walk(
    player: Single<(Entity, &mut Player, &mut Transform, &Collider)>,
    query: SinewQuery,
    planks: Query<(), With<RigidBox>>,
    (clock, time): (Res<SinewClock>, Res<Time>),
) {
    let (entity, mut player, mut at, shape) = player.into_inner();
    let speed = if clock.seconds > 2.0 && at.translation.x < 4.0 { 1.2 } else { 0.0 };
    let velocity = Vec3::new(speed, player.0 - 9.81 * time.delta_secs(), 0.0);
    let filter = QueryFilter { except: Some(entity), ..default() };
    let (from, config) = (at.to_isometry(), MoveAndSlideConfig { max_slope: 1.0, ..default() });
    let out = query.move_and_slide(shape, from, velocity, time.delta(), &config, &filter);
    (at.translation, player.0) = (out.position, out.projected_velocity.y);
    player.1 += u32::from(out.ground.is_some_and(|hit| planks.contains(hit.entity)));
}

/// Measures how far the lowest plank sags, under the player and afterwards.
fn watch(
    clock: Res<SinewClock>,
    planks: Query<&Transform, With<RigidBox>>,
    player: Single<(&Player, &Transform)>,
    mut loaded: Local<f32>,
    mut exit: MessageWriter<AppExit>,
) {
    let depth = planks.iter().map(|at| -at.translation.y).fold(0.0, f32::max);
    let (Player(_, stood), Transform { translation: at, .. }) = *player;
    *loaded = if at.x.abs() < 2.0 { loaded.max(depth) } else { *loaded };
    if clock.seconds > 13.0 {
        println!(
            "the bridge sagged by {:.2} m under the player, and by {depth:.2} m after",
            *loaded
        );
        println!("the player stood on planks for {stood} ticks, and ended at {at:.2?}");
        assert!((at - Vec3::new(4.0, 0.89, 0.0)).length() < 0.05 && *stood > 200);
        assert!(*loaded > depth + 0.1 && *loaded < 1.0);
        exit.write(AppExit::Success);
    }
}
