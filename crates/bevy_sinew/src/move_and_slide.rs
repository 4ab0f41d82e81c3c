//! Move and slide: for character controllers that move an entity by its `Transform`.

use core::time::Duration;

use bevy::prelude::*;
use sinew::SlideConfig;

use crate::components::Collider;
use crate::query::{QueryFilter, QueryHit, frame};
use crate::world::SinewWorld;

/// Settings of [move and slide](SinewWorld::move_and_slide). Values outside their range are clamped.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct MoveAndSlideConfig {
    /// The direction against gravity, of any length but zero. Default +y.
    pub up: Vec3,
    /// The steepest slope to stand on, radians from the horizontal, 0 to π/2. A steeper surface acts as a wall from below, and the shape slides down it from
    /// above. Default π/4.
    pub max_slope: f32,
    /// The gap that is kept to everything, metres, 1e-4 to 1. Default 0.01.
    pub skin_width: f32,
    /// Maximum number of changes of direction in one call, 1 to 32. Default 8.
    #[doc(alias = "max_slides")]
    pub move_and_slide_iterations: u32,
    /// Maximum number of iterations that push the shape out of initial overlaps, 0 to 32; 0 disables that. Default 8.
    pub depenetration_iterations: u32,
}

/// The result of a [move and slide](SinewWorld::move_and_slide).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MoveAndSlideOutput {
    /// The new position, metres.
    pub position: Vec3,
    /// The remaining velocity, m/s: without the components into the surfaces that were hit.
    pub projected_velocity: Vec3,
    /// The floor within two skin widths below; `None` in the air, and while the shape moves up from the floor.
    pub ground: Option<QueryHit>,
    /// The surfaces that were hit, in order, repeated hits included: walls, floors and ceilings.
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
    /// Whether a surface with this unit normal is a floor, on which the shape can stand.
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
    /// Moves a convex shape by a velocity, m/s, for a duration, as far as possible, sliding along the obstacles: colliders, [`Ground`](crate::Ground),
    /// [`BoundingBox`](crate::BoundingBox), bodies, cloth, loose particles. It passes through nothing at any speed, and keeps a skin width of distance. It is
    /// pushed out of initial overlaps first. On a floor it does not slide down under gravity.
    ///
    /// Nothing is changed: the game applies the returned position and velocity. Obstacles are where the last tick left them. The shape pushes no bodies
    /// ([`Weighs`](crate::Weighs) lets it press on what it stands on), climbs no steps, and follows no moving platform: a game implements these with
    /// [`cast_shape`](Self::cast_shape) and another call. A shape or a number that is invalid, or a shape that is not convex, does not move.
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
