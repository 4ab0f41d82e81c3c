//! Questions to the world, for a game's systems: what a ray or a shape meets on its way, what a shape overlaps, which particle is nearest.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::{ContactParticipant, Filter, Frame, Shape};

use crate::components::{Collider, CollisionLayers};
use crate::world::SinewWorld;

/// What a [question](SinewWorld::cast_ray) is about. The default is everything but sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QueryFilter {
    /// What it meets, and what meets it; everything if `None`.
    pub layers: Option<CollisionLayers>,
    /// Whether colliders are left out, grounds and bounding boxes among them.
    pub no_colliders: bool,
    /// Whether bodies and loose particles are left out.
    pub no_bodies: bool,
    /// Whether sensors count, too.
    pub sensors: bool,
    /// One that does not count: who asks.
    pub except: Option<Entity>,
}

/// What a ray or a shape met.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "RayHit")]
#[doc(alias = "ShapeHit")]
pub struct QueryHit {
    /// Whom: a body, a loose particle, a collider, a ground or a bounding box.
    pub entity: Entity,
    /// The particle that was met, or that is nearest of what was; none of what stands by itself.
    pub particle: Option<Entity>,
    /// How far from where it began, metres.
    pub distance: f32,
    /// Where, metres.
    pub point: Vec3,
    /// Unit vector out of what was met.
    pub normal: Vec3,
}

/// All questions to the simulation, as a parameter of a system: those of [`SinewWorld`], which it hands on. Many systems may ask at once.
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

/// They look at the world as the last tick left it, one thing after the other: some nanoseconds for each particle and collider. What has been despawned since
/// is still there for them, until the next tick.
impl SinewWorld {
    /// What a ray meets first within `max` metres: a collider, a ground, a wall of a bounding box from inside, a rigid body by its shape, a surface from either
    /// side, or a particle's ball.
    pub fn cast_ray(&self, ray: Ray3d, max: f32, filter: &QueryFilter) -> Option<QueryHit> {
        let filter = self.filter(filter);
        let hit = self.simulation.cast_ray(ray.origin, *ray.direction, max, &filter)?;
        self.named(&hit)
    }

    /// What a shape without dents meets first that goes up to `max` metres from a place along a direction, without turning: a collider, a ground, a wall of a
    /// bounding box, a rigid body by its shape, a surface from either side, or a particle's ball. It goes through nothing, however far it goes. What it overlaps
    /// at the start it meets at once, at a distance of 0. A shape with a broken number meets nothing, and neither do planes, meshes and landscapes that are
    /// to go somewhere.
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

    /// Everyone who overlaps a shape at a place, once each, in the order in which they are found: colliders, rigid bodies, others. A shape with a
    /// broken number overlaps nothing.
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

    /// The particle whose centre is nearest to a point, within `max` metres, and how far away it is.
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

    /// The same with entities; `None` if whom it names is not known.
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

    /// Who an entity is in contacts.
    fn participant_of(&self, entity: Entity) -> Option<ContactParticipant> {
        let tables = &self.tables;
        let among = |list: &[Entity]| list.iter().position(|&other| other == entity);
        let body = among(&tables.bodies).map(|number| ContactParticipant::Body(number as u32));
        body.or_else(|| {
            among(&tables.colliders).map(|number| ContactParticipant::Collider(number as u32))
        })
        .or_else(|| tables.layout.row_of.get(&entity).map(|&row| ContactParticipant::Particle(row)))
    }
}

pub(crate) fn frame(place: Isometry3d) -> Frame {
    Frame::new(place.translation.into(), place.rotation)
}
