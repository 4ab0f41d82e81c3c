//! Spatial queries: ray casts, shape casts, overlaps, and the nearest particle.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::{ContactParticipant, Filter, Frame, Shape};

use crate::components::{Collider, CollisionLayers};
use crate::world::SinewWorld;

/// What a [query](SinewWorld::cast_ray) considers. Default everything but sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QueryFilter {
    /// Layers of the query: it considers entities whose layers collide with these. `None` considers all layers.
    pub layers: Option<CollisionLayers>,
    /// Whether colliders are left out, including grounds and bounding boxes.
    pub no_colliders: bool,
    /// Whether bodies and loose particles are left out.
    pub no_bodies: bool,
    /// Whether sensors are included.
    pub sensors: bool,
    /// One entity to leave out, for instance the one that moves. A rigid part of a body, such as a limb, stands for the body.
    pub except: Option<Entity>,
}

/// A hit of a ray or a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "RayHit")]
#[doc(alias = "ShapeHit")]
pub struct QueryHit {
    /// The entity that was hit: a body, a loose particle or a collider.
    pub entity: Entity,
    /// The particle that was hit, or the one nearest to the hit; `None` for a static or kinematic collider.
    pub particle: Option<Entity>,
    /// Distance from the start of the cast, metres.
    pub distance: f32,
    /// The point that was hit, metres.
    pub point: Vec3,
    /// Unit normal at the point, out of the entity that was hit.
    pub normal: Vec3,
}

/// System parameter for spatial queries: it dereferences to [`SinewWorld`], which has them. Any number of systems may use it at once.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{QueryFilter, SinewQuery};
/// fn land(query: SinewQuery, gears: Query<(Entity, &Collider, &Transform)>) {
///     for (gear, shape, place) in &gears {
///         let filter = QueryFilter { except: Some(gear), ..default() };
///         let hit = query.cast_shape(shape, place.to_isometry(), Dir3::NEG_Y, 10.0, &filter);
///         if let Some(hit) = hit {
///             println!("{} is {} m below", hit.entity, hit.distance);
///         }
///     }
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(Update, land);
/// # app.finish();
/// # app.update();
/// ```
#[derive(SystemParam)]
pub struct SinewQuery<'w> {
    world: Res<'w, SinewWorld>,
}

impl core::ops::Deref for SinewQuery<'_> {
    type Target = SinewWorld;

    fn deref(&self) -> &SinewWorld {
        &self.world
    }
}

/// Spatial queries. They use the state that the last tick left, and test all particles and colliders, one after the other: some nanoseconds each. Entities that
/// have been despawned since are still found, until the next tick.
impl SinewWorld {
    /// The first hit of a ray within `max` metres: a collider, a ground, a wall of a bounding box from inside, a rigid body by its shape, a surface from either
    /// side, or the ball of a particle.
    pub fn cast_ray(&self, ray: Ray3d, max: f32, filter: &QueryFilter) -> Option<QueryHit> {
        let filter = self.filter(filter);
        let hit = self.simulation.cast_ray(ray.origin, *ray.direction, max, &filter)?;
        self.named(&hit)
    }

    /// The first hit of a convex shape that is moved up to `max` metres from a placement along a direction, without rotation: a collider, a ground, a wall of a
    /// bounding box from inside, a rigid body by its shape, a surface from either side, or the ball of a particle. The cast is exact at any distance. An
    /// initial overlap is a hit at the distance 0. A shape with an invalid number hits nothing, and neither do planes, meshes and heightfields as the moving
    /// shape.
    #[doc(alias = "sweep")]
    pub fn cast_shape(
        &self,
        shape: &Collider,
        place: Isometry3d,
        direction: Dir3,
        max: f32,
        filter: &QueryFilter,
    ) -> Option<QueryHit> {
        let (shape, frame) = (shape.shape().ok()?, frame(place));
        let filter = self.filter(filter);
        self.named(&self.simulation.cast_shape(&shape, &frame, *direction, max, &filter)?)
    }

    /// All entities that overlap a shape at a placement, each once, in the order in which they are found: colliders, rigid bodies, others. A shape with an
    /// invalid number overlaps nothing.
    pub fn overlapping(
        &self,
        shape: &Collider,
        place: Isometry3d,
        filter: &QueryFilter,
    ) -> Vec<Entity> {
        let mut found = Vec::new();
        let Ok(shape) = shape.shape() else { return found };
        self.overlapping_shape(&shape, &frame(place), filter, &mut found);
        found
    }

    /// The particle whose centre is nearest to a point, within `max` metres, and its distance, metres.
    pub fn nearest_particle(
        &self,
        point: Vec3,
        max: f32,
        filter: &QueryFilter,
    ) -> Option<(Entity, f32)> {
        let filter = self.filter(filter);
        let (row, distance) = self.simulation.nearest_particle(point, max, &filter)?;
        Some((self.entity_of(ContactParticipant::Particle(row))?, distance))
    }

    /// The hit with entities; `None` if the entity is not known.
    pub(crate) fn named(&self, hit: &sinew::Hit) -> Option<QueryHit> {
        let sinew::Hit { participant, row, distance, point, normal } = *hit;
        let entity = self.entity_of(participant)?;
        let particle = row.and_then(|row| self.entity_of(ContactParticipant::Particle(row)));
        Some(QueryHit { entity, particle, distance, point, normal })
    }

    fn overlapping_shape(
        &self,
        shape: &Shape,
        frame: &Frame,
        filter: &QueryFilter,
        found: &mut Vec<Entity>,
    ) {
        self.simulation.overlaps(shape, frame, &self.filter(filter), |participant, _| {
            if let Some(entity) =
                self.entity_of(participant).filter(|entity| !found.contains(entity))
            {
                found.push(entity);
            }
        });
    }

    pub(crate) fn filter(&self, filter: &QueryFilter) -> Filter {
        let all = Filter::default();
        Filter {
            layers: filter.layers.map_or(all.layers, CollisionLayers::layers),
            colliders: !filter.no_colliders,
            bodies: !filter.no_bodies,
            sensors: filter.sensors,
            except: filter.except.and_then(|entity| self.participant_of(entity)),
        }
    }

    /// The contact participant of an entity.
    fn participant_of(&self, entity: Entity) -> Option<ContactParticipant> {
        let tables = &self.tables;
        let among = |list: &[Entity]| list.iter().position(|&other| other == entity);
        let body = among(&tables.bodies).map(|number| ContactParticipant::Body(number as u32));
        body.or_else(|| {
            among(&tables.colliders).map(|number| ContactParticipant::Collider(number as u32))
        })
        .or_else(|| {
            let part = among(&tables.parts)?;
            let row = *self.simulation.body_colliders().get(part)?.rows.first()?;
            self.simulation.particles.body(row as usize).map(ContactParticipant::Body)
        })
        .or_else(|| tables.layout.row_of.get(&entity).map(|&row| ContactParticipant::Particle(row)))
    }
}

pub(crate) fn frame(place: Isometry3d) -> Frame {
    Frame::new(place.translation.into(), place.rotation)
}
