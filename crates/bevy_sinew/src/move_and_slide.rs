//! Move and slide: what a game's own character controller asks, for something that the game moves by its `Transform`.

use core::time::Duration;

use bevy::prelude::*;
use sinew::SlideConfig;

use crate::components::Collider;
use crate::query::{QueryFilter, QueryHit, frame};
use crate::world::SinewWorld;

/// How something [moves and slides](SinewWorld::move_and_slide). What is not in its range is clamped to it.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct MoveAndSlideConfig {
    /// Against gravity, of any length but zero. Default +y.
    pub up: Vec3,
    /// The steepest slope that it can stand on, rad from the level, 0 to π/2. What is steeper is a wall from below, and slides down from above. Default π/4.
    pub max_slope: f32,
    /// How far it keeps off everything, metres, 1e-4 to 1. Default 0.01.
    pub skin_width: f32,
    /// How often it may turn in one call, 1 to 32. Default 8.
    #[doc(alias = "max_slides")]
    pub move_and_slide_iterations: u32,
    /// How often it may be pushed out of what overlaps it at the start, 0 to 32; 0 for never. Default 8.
    pub depenetration_iterations: u32,
}

/// Where something that [moved and slid](SinewWorld::move_and_slide) has come to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MoveAndSlideOutput {
    /// The new place of its origin, metres.
    pub position: Vec3,
    /// The velocity that is left, m/s: without what led into what it met.
    pub projected_velocity: Vec3,
    /// The floor that it stands on, within two skin widths below; none in the air, and none while it rises from the floor.
    pub ground: Option<QueryHit>,
    /// What was in its way, in that order, once for each time: walls, floors and ceilings.
    pub hits: Vec<QueryHit>,
}

impl Default for MoveAndSlideConfig {
    fn default() -> Self {
        let SlideConfig { up, max_slope, skin_width, iterations, depenetration_iterations } =
            SlideConfig::default();
        let move_and_slide_iterations = iterations;
        Self { up, max_slope, skin_width, move_and_slide_iterations, depenetration_iterations }
    }
}

impl MoveAndSlideConfig {
    /// Whether something can stand on a surface with this unit normal: which of the hits are floors.
    pub fn is_floor(&self, normal: Vec3) -> bool {
        self.settings().is_floor(normal)
    }

    fn settings(&self) -> SlideConfig {
        let Self { up, max_slope, skin_width, .. } = *self;
        SlideConfig {
            up,
            max_slope,
            skin_width,
            iterations: self.move_and_slide_iterations,
            depenetration_iterations: self.depenetration_iterations,
        }
    }
}

impl SinewWorld {
    /// Moves a shape without dents by a velocity, m/s, for a time, as far as it can, sliding along what is in the way: colliders, [`Ground`](crate::Ground),
    /// [`BoundingBox`](crate::BoundingBox), bodies, cloth, loose particles. It goes through nothing, however fast it is, and keeps a skin's width off everything;
    /// what overlaps it at the start pushes it out first. It stands on a floor by its weight without sliding down.
    ///
    /// Nothing is changed: the game keeps the new place and the velocity. Things are met where the last tick left them. It pushes nobody
    /// ([`Weighs`](crate::Weighs) has it press on what it stands on), climbs no steps, and follows no platform: a game does that with
    /// [`cast_shape`](Self::cast_shape) and another call. A shape or a number that is broken does not move, nor does one with dents.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sinew::prelude::*;
    /// # use bevy_sinew::{MoveAndSlideConfig, QueryFilter};
    /// #[derive(Component, Default)]
    /// struct Player {
    ///     velocity: Vec3,
    /// }
    ///
    /// fn walk(
    ///     query: SinewQuery,
    ///     time: Res<Time>,
    ///     mut players: Query<(Entity, &mut Player, &mut Transform, &Collider)>,
    /// ) {
    ///     for (entity, mut player, mut place, shape) in &mut players {
    ///         let fall = player.velocity.y - 9.81 * time.delta_secs();
    ///         let velocity = Vec3::new(2.0, fall, 0.0);
    ///         let (from, config) = (place.to_isometry(), MoveAndSlideConfig::default());
    ///         // The player's own collider is not in its way.
    ///         let filter = QueryFilter { except: Some(entity), ..default() };
    ///         let out = query.move_and_slide(shape, from, velocity, time.delta(), &config, &filter);
    ///         place.translation = out.position;
    ///         player.velocity = out.projected_velocity;
    ///     }
    /// }
    /// # let mut app = App::new();
    /// # app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(FixedUpdate, walk);
    /// # app.finish();
    /// # app.update();
    /// ```
    #[doc(alias = "collide_and_slide")]
    #[doc(alias = "KinematicCharacterController")]
    pub fn move_and_slide(
        &self,
        shape: &Collider,
        place: Isometry3d,
        velocity: Vec3,
        delta: Duration,
        config: &MoveAndSlideConfig,
        filter: &QueryFilter,
    ) -> MoveAndSlideOutput {
        let position = place.translation.into();
        let Ok(shape) = shape.shape() else {
            return MoveAndSlideOutput { position, ..default() };
        };
        let (frame, filter) = (frame(place), self.filter(filter));
        let (delta, config) = (delta.as_secs_f32(), config.settings());
        let out = self.simulation.move_and_slide(&shape, &frame, velocity, delta, &config, &filter);
        MoveAndSlideOutput {
            position: out.translation,
            projected_velocity: out.velocity,
            ground: out.ground.and_then(|hit| self.named(&hit)),
            hits: out.hits.iter().filter_map(|hit| self.named(hit)).collect(),
        }
    }
}
