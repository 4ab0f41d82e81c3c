//! Segments: the rods of bodies that collide by them, each a capsule between two particles.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::{BodyCollider, Particles, Simulation};

use crate::components::{
    Bound, Collider, ContactCache, CreationOrder, DistanceConstraint, RigidPose,
};
use crate::world::Tables;

/// Rods that do not collide otherwise.
type Rod = (With<DistanceConstraint>, Without<Collider>, Without<RigidPose>);

/// The rods of all bodies.
#[derive(SystemParam)]
pub(crate) struct Segments<'w, 's> {
    rods: Query<
        'w,
        's,
        (&'static CreationOrder, &'static DistanceConstraint, Has<ContactCache>),
        Rod,
    >,
    all: Query<'w, 's, Entity, Rod>,
    cached: Query<'w, 's, Entity, (With<ContactCache>, Rod)>,
    commands: Commands<'w, 's>,
    /// The number of rods with a contact cache when they were last listed.
    listed: Local<'s, usize>,
}

impl Segments<'_, '_> {
    /// Whether rods have gained or lost a contact cache since they were listed, as after a rollback.
    pub(crate) fn are_off(&self) -> bool {
        self.cached.iter().len() != *self.listed
    }

    /// Lists the segments of the bodies that collide by them (`uses_segments`), if there are `any`, and the owners of the segments. The mapping from particles
    /// to bodies must be up to date. A rod that becomes a segment is given a contact cache, which is removed when it is one no longer.
    pub(crate) fn list(
        &mut self,
        (simulation, tables): (&Simulation, &Tables),
        (any, uses_segments): (bool, impl Fn(Entity) -> bool),
        owners: &mut Vec<Entity>,
        body_colliders: &mut Vec<(CreationOrder, Entity, BodyCollider)>,
    ) {
        let Self { rods, all, cached, commands, listed } = self;
        **listed = 0;
        if !any && cached.is_empty() {
            return;
        }
        let particles = &simulation.particles;
        let with_segments: Vec<bool> =
            tables.bodies.iter().map(|&body| any && uses_segments(body)).collect();
        let uses_segments = |body: u32| with_segments.get(body as usize) == Some(&true);
        let mut last = None;
        let add = |entity: Entity| {
            let Ok((order, rod, has_cache)) = rods.get(entity) else { return };
            let owner = owner(rod, particles, tables).filter(|&body| uses_segments(body));
            let body_collider = owner.and_then(|_| segment(rod, particles, tables, &mut last));
            match (&body_collider, has_cache) {
                (Some(_), false) => drop(commands.entity(entity).insert(ContactCache::default())),
                (None, true) => drop(commands.entity(entity).remove::<ContactCache>()),
                _ => {}
            }
            if let (Some(owner), Some(body_collider)) = (owner, body_collider) {
                owners.push(tables.bodies[owner as usize]);
                body_colliders.push((
                    *order,
                    entity,
                    BodyCollider { id: order.0, ..body_collider },
                ));
                **listed += 1;
            }
        };
        if !tables.links.complete {
            all.iter().for_each(add);
            return;
        }
        // The solver's list has all rods, in contiguous memory, and there may be many of other bodies.
        let may_be_segment = |row: u32| particles.body(row as usize).is_some_and(uses_segments);
        let mut candidates: Vec<Entity> = cached.iter().collect();
        let all_rods = simulation.distances().iter().zip(&tables.links.distances);
        candidates
            .extend(all_rods.filter(|(rod, _)| may_be_segment(rod.a)).map(|(_, key)| key.entity));
        candidates.sort_unstable();
        candidates.dedup();
        candidates.into_iter().for_each(add);
    }
}

/// The index of the body to which both ends of a rod belong.
fn owner(rod: &DistanceConstraint, particles: &Particles, tables: &Tables) -> Option<u32> {
    let body = |end: Entity| particles.body(*tables.layout.row_of.get(&end)? as usize);
    let one = body(rod.a)?;
    (rod.bound != Bound::AtLeast && body(rod.b) == Some(one)).then_some(one)
}

/// The capsule of a rod, as thick as its thinner end; `None` if it has no thickness, or an end is gone or set aside. Rods of a rope are mostly equal, so the
/// previous one (`last`) is reused.
fn segment(
    rod: &DistanceConstraint,
    particles: &Particles,
    tables: &Tables,
    last: &mut Option<([f32; 2], BodyCollider)>,
) -> Option<BodyCollider> {
    let rows = [tables.valid_row(rod.a)?, tables.valid_row(rod.b)?];
    let [one, other] = rows.map(|row| particles.radius(row as usize));
    let size = [rod.rest, one.min(other)];
    if last.as_ref().is_none_or(|(known, _)| *known != size) {
        *last = Some((size, BodyCollider::segment(rows, size[0], size[1], 0).ok()?));
    }
    let (_, like) = last.as_ref()?;
    let body_collider = BodyCollider { rows: rows.to_vec(), ..like.clone() };
    body_collider.fault(particles.len()).is_none().then_some(body_collider)
}
