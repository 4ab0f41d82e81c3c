//! Segments: the rods of bodies that collide by them, each a capsule between two particles.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::{BodyCollider, Particles};

use crate::components::{
    Bound, Collider, ContactCache, CreationOrder, DistanceConstraint, ParticleOf, RigidPose,
};
use crate::world::Tables;

/// What is a rod and nothing else that collides.
type Rod = (With<DistanceConstraint>, Without<Collider>, Without<RigidPose>);

/// Rods, and whose particles are whose.
#[derive(SystemParam)]
pub(crate) struct Segments<'w, 's> {
    rods: Query<
        'w,
        's,
        (Entity, &'static CreationOrder, &'static DistanceConstraint, Has<ContactCache>),
        Rod,
    >,
    members: Query<'w, 's, &'static ParticleOf>,
    remembering: Query<'w, 's, (), (With<ContactCache>, Rod)>,
    commands: Commands<'w, 's>,
    /// How many rods have a memory since they were last listed.
    listed: Local<'s, usize>,
}

impl Segments<'_, '_> {
    /// Whether rods have got or lost a memory since they were listed: a rollback does that.
    pub(crate) fn are_off(&self) -> bool {
        self.remembering.iter().len() != *self.listed
    }

    /// Lists the segments of bodies that ask for them, if `any` does, and who has any. What becomes one is given a memory of what it touches, and loses that when it
    /// ceases to be one.
    pub(crate) fn list(
        &mut self,
        (particles, tables): (&Particles, &Tables),
        (any, asks): (bool, impl Fn(Entity) -> bool),
        owners: &mut Vec<Entity>,
        body_colliders: &mut Vec<(CreationOrder, Entity, BodyCollider)>,
    ) {
        let Self { rods, members, commands, listed, remembering } = self;
        **listed = 0;
        if !any && remembering.is_empty() {
            return;
        }
        let mut last = None;
        for (entity, order, rod, remembers) in &*rods {
            let owner = owner(rod, members).filter(|&body| asks(body));
            let solid = owner.and_then(|_| segment(rod, particles, tables, &mut last));
            match (&solid, remembers) {
                (Some(_), false) => drop(commands.entity(entity).insert(ContactCache::default())),
                (None, true) => drop(commands.entity(entity).remove::<ContactCache>()),
                _ => {}
            }
            if let (Some(owner), Some(solid)) = (owner, solid) {
                owners.push(owner);
                body_colliders.push((*order, entity, BodyCollider { id: order.0, ..solid }));
                **listed += 1;
            }
        }
    }
}

/// The body that both ends of a rod belong to.
fn owner(rod: &DistanceConstraint, members: &Query<&ParticleOf>) -> Option<Entity> {
    let [one, other] = [rod.a, rod.b].map(|end| members.get(end).map(|of| of.0).ok());
    one.filter(|_| one == other && rod.bound != Bound::AtLeast)
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
