//! Segments: the rods of bodies that collide by them, each a capsule between two particles.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::{BodyCollider, Particles, Simulation};

use crate::components::{
    Bound, Collider, ContactCache, CreationOrder, DistanceConstraint, RigidPose,
};
use crate::world::Tables;

/// What is a rod and nothing else that collides.
type Rod = (With<DistanceConstraint>, Without<Collider>, Without<RigidPose>);

/// Rods.
#[derive(SystemParam)]
pub(crate) struct Segments<'w, 's> {
    rods: Query<
        'w,
        's,
        (&'static CreationOrder, &'static DistanceConstraint, Has<ContactCache>),
        Rod,
    >,
    all: Query<'w, 's, Entity, Rod>,
    remembering: Query<'w, 's, Entity, (With<ContactCache>, Rod)>,
    commands: Commands<'w, 's>,
    /// How many rods have a memory since they were last listed.
    listed: Local<'s, usize>,
}

impl Segments<'_, '_> {
    /// Whether rods have got or lost a memory since they were listed: a rollback does that.
    pub(crate) fn are_off(&self) -> bool {
        self.remembering.iter().len() != *self.listed
    }

    /// Lists the segments of bodies that ask for them, if `any` does, and who has any. Which particles are whose is known already. What becomes one is given a
    /// memory of what it touches, and loses that when it ceases to be one.
    pub(crate) fn list(
        &mut self,
        (simulation, tables): (&Simulation, &Tables),
        (any, asks): (bool, impl Fn(Entity) -> bool),
        owners: &mut Vec<Entity>,
        body_colliders: &mut Vec<(CreationOrder, Entity, BodyCollider)>,
    ) {
        let Self { rods, all, remembering, commands, listed } = self;
        **listed = 0;
        if !any && remembering.is_empty() {
            return;
        }
        let particles = &simulation.particles;
        let asking: Vec<bool> = tables.bodies.iter().map(|&body| any && asks(body)).collect();
        let asks = |body: u32| asking.get(body as usize) == Some(&true);
        let mut last = None;
        let take = |entity: Entity| {
            let Ok((order, rod, remembers)) = rods.get(entity) else { return };
            let owner = owner(rod, particles, tables).filter(|&body| asks(body));
            let solid = owner.and_then(|_| segment(rod, particles, tables, &mut last));
            match (&solid, remembers) {
                (Some(_), false) => drop(commands.entity(entity).insert(ContactCache::default())),
                (None, true) => drop(commands.entity(entity).remove::<ContactCache>()),
                _ => {}
            }
            if let (Some(owner), Some(solid)) = (owner, solid) {
                owners.push(tables.bodies[owner as usize]);
                body_colliders.push((*order, entity, BodyCollider { id: order.0, ..solid }));
                **listed += 1;
            }
        };
        if !tables.links.sound {
            all.iter().for_each(take);
            return;
        }
        // The solver's list, which has all there are, is in one piece, and there may be many rods of others.
        let is_asking = |row: u32| particles.body(row as usize).is_some_and(asks);
        let mut maybe: Vec<Entity> = remembering.iter().collect();
        let known = simulation.distances().iter().zip(&tables.links.distances);
        maybe.extend(known.filter(|(rod, _)| is_asking(rod.a)).map(|(_, place)| place.entity));
        maybe.sort_unstable();
        maybe.dedup();
        maybe.into_iter().for_each(take);
    }
}

/// The number of the body that both ends of a rod belong to.
fn owner(rod: &DistanceConstraint, particles: &Particles, tables: &Tables) -> Option<u32> {
    let body = |end: Entity| particles.body(*tables.layout.row_of.get(&end)? as usize);
    let one = body(rod.a)?;
    (rod.bound != Bound::AtLeast && body(rod.b) == Some(one)).then_some(one)
}

/// The capsule of a rod, as thick as its thinner end; `None` if it has no thickness, or an end is gone or set aside. Rods of a rope are much alike:
/// `last` is what the one before became.
fn segment(
    rod: &DistanceConstraint,
    particles: &Particles,
    tables: &Tables,
    last: &mut Option<([f32; 2], BodyCollider)>,
) -> Option<BodyCollider> {
    let rows = [tables.sound_row(rod.a)?, tables.sound_row(rod.b)?];
    let [one, other] = rows.map(|row| particles.radius(row as usize));
    let size = [rod.rest, one.min(other)];
    if last.as_ref().is_none_or(|(known, _)| *known != size) {
        *last = Some((size, BodyCollider::segment(rows, size[0], size[1], 0).ok()?));
    }
    let (_, like) = last.as_ref()?;
    let solid = BodyCollider { rows: rows.to_vec(), ..like.clone() };
    solid.fault(particles.len()).is_none().then_some(solid)
}
