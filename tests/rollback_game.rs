//! The game of the rollback tests: bodies and particles are spawned, fall onto each other, fall asleep and are despawned; threads of a cloth break.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyConstraints, RegisterState, SinewClock};

/// State of the game, counted up in every frame.
#[derive(Resource, Reflect, Clone, Debug, Default)]
pub(crate) struct Counted(pub(crate) u32);

/// Marks what was thrown, with the tick in which it was spawned.
#[derive(Component, Reflect, Clone, Debug)]
pub(crate) struct Thrown(u64);

/// Spawns the scene at the start of the game.
pub(crate) fn stage(app: &mut App) {
    app.init_resource::<Counted>().register_state::<Thrown>();
    let world = app.world_mut();
    world.spawn((Ground, SurfaceMaterial::new(0.5)));
    world.spawn((Wind { pressure: Vec3::X * 3.0, gusts: 0.7, ..default() }, Name::new("wind")));
    let cloth = Cloth::grid(1.0, 1.0, 7, 7).pinned(ClothPins::TopEdge);
    world.spawn((cloth, Transform::from_xyz(0.0, 1.5, 0.0)));
    world.spawn((Rope { segments: 6, ..default() }, Transform::from_xyz(1.5, 2.0, 0.0)));
}

/// One frame of the game: throws boxes and balls, cuts a thread of the cloth, and despawns what was thrown 150 ticks ago.
pub(crate) fn play(
    mut commands: Commands,
    clock: Res<SinewClock>,
    mut counted: ResMut<Counted>,
    thrown: Query<(Entity, &Thrown)>,
    cloths: Query<&BodyConstraints, With<Cloth>>,
) {
    counted.0 += 1;
    let tick = clock.tick;
    let side = (tick % 7) as f32 * 0.1 - 0.3;
    if tick % 31 == 5 {
        let body = (RigidBox::new(Vec3::splat(0.3)), Sleep::default(), Thrown(tick));
        commands.spawn((body, Transform::from_xyz(side, 2.0, 0.4)));
    }
    if tick % 17 == 3 {
        let ball = Particle::at(Vec3::new(side, 1.0, 1.5)).with_velocity(Vec3::NEG_Z * 6.0);
        commands.spawn((ball, Mass(0.05), Radius(0.05), Thrown(tick)));
    }
    if let (true, Some(ties)) = (tick % 23 == 11, cloths.iter().next())
        && let Some(tie) = ties.iter().nth(tick as usize % ties.len().max(1))
    {
        commands.entity(tie).despawn();
    }
    for (entity, Thrown(when)) in &thrown {
        if tick > when + 150 {
            commands.entity(entity).despawn();
        }
    }
}

/// Number of constraints of the cloth.
pub(crate) fn ties(app: &mut App) -> usize {
    let mut cloths = app.world_mut().query_filtered::<&BodyConstraints, With<Cloth>>();
    cloths.single(app.world()).unwrap().len()
}

/// Number of thrown entities that still exist.
pub(crate) fn in_play(app: &mut App) -> usize {
    let world = app.world_mut();
    world.query::<&Thrown>().iter(world).count()
}
