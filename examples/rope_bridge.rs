//! A rope bridge with planks, tied between two cliffs; a player crosses it, and it sags under him.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::prelude::*;

const PLANKS: usize = 11;

/// Someone whom the game moves: a collider that goes from one cliff to the other.
#[derive(Component)]
struct Player;

#[derive(Component)]
struct Plank;

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins)).init_resource::<Lowest>();
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, (walk, watch).chain()).run()
}

/// How deep the lowest plank has been, metres.
#[derive(Resource, Default)]
struct Lowest(f32);

fn setup(mut commands: Commands) {
    let cliffs = [-3.0, 3.0].map(|x: f32| {
        let rock = Collider::cuboid(Vec3::new(2.0, 2.0, 2.0));
        commands.spawn((rock, Transform::from_xyz(x + x.signum(), -1.0, 0.0))).id()
    });
    let planks: Vec<Entity> = (0..PLANKS)
        .map(|i| {
            let at = Transform::from_xyz(-2.5 + 0.5 * i as f32, 0.0, 0.0);
            let wood = RigidBox::new(Vec3::new(0.4, 0.06, 1.2)).with_mass(4.0);
            commands.spawn((Plank, wood, at)).id()
        })
        .collect();
    // A rope on either side from plank to plank, and to the edges of the cliffs.
    for side in [-1.0, 1.0] {
        let right = |plank| (plank, Anchor::Corner(Vec3::new(1.0, 0.0, side)));
        let left = |plank| (plank, Anchor::Corner(Vec3::new(-1.0, 0.0, side)));
        let edge = |i: usize, x: f32| (cliffs[i], Anchor::Point(Vec3::new(x, 1.0, 0.6 * side)));
        let mut piece = |from, to| {
            let rope = Rope { segments: 2, mass: 0.05, slack: 0.1, ..Rope::between(from, to) };
            commands.spawn(rope);
        };
        piece(edge(0, 1.0), left(planks[0]));
        for pair in planks.windows(2) {
            piece(right(pair[0]), left(pair[1]));
        }
        piece(right(planks[PLANKS - 1]), edge(1, -1.0));
    }
    commands.spawn((Player, Collider::sphere(0.4), Transform::from_xyz(-4.0, 0.4, 0.0)));
}

/// The player crosses in eight seconds, lower in the middle, where the bridge sags.
fn walk(mut players: Query<&mut Transform, With<Player>>, clock: Res<SinewClock>) {
    for mut player in &mut players {
        let x = (clock.seconds as f32 - 4.0).clamp(-4.0, 4.0);
        player.translation = Vec3::new(x, 0.4 - 0.6 * (1.0 - (x / 3.0).powi(2)).max(0.0), 0.0);
    }
}

fn watch(
    clock: Res<SinewClock>,
    planks: Query<&Transform, With<Plank>>,
    mut lowest: ResMut<Lowest>,
    mut exit: MessageWriter<AppExit>,
) {
    let deepest = planks.iter().map(|at| at.translation.y).fold(0.0, f32::min);
    lowest.0 = lowest.0.min(deepest);
    if clock.seconds > 9.0 {
        println!("the bridge sagged by {:.2} m, and hangs by {:.2} m", -lowest.0, -deepest);
        exit.write(if lowest.0 > -1.5 { AppExit::Success } else { AppExit::error() });
    }
}
