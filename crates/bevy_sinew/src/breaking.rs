//! Constraints that break at a force or at a strain.

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::relationship::RelationshipTarget;
use bevy::prelude::*;
use sinew::Bound;

use crate::attach::{AttachTo, AttachmentJoints, AttachmentOf};
use crate::changes::count_and_changed;
use crate::components::{BodyConstraints, BreakAt, ConstraintOf, CreationOrder};
use crate::schedule::SinewClock;
use crate::world::{LinkIndex, SinewWorld};

/// A constraint, a spring or an attachment broke, because it exceeded its [`BreakAt`]. It is a message, and an event that can be observed on what broke and, if
/// that belongs to a body, on the body. What broke still exists when the event is sent, and is despawned right after.
///
/// The events of a tick are sent at the end of [`SinewSystems::Scatter`](crate::SinewSystems::Scatter), after the contacts of the tick, in the order in which
/// the constraints were created. The message is written once, with the constraint as its `entity`.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins));
/// app.add_observer(|broke: On<Broke>| println!("{broke:?}"));
/// ```
#[derive(Message, EntityEvent, Reflect, Clone, Debug, PartialEq)]
pub struct Broke {
    /// The target of the event: the constraint, or its body.
    pub entity: Entity,
    /// The constraint or the spring that broke, or the entity with the [`AttachTo`].
    pub constraint: Entity,
    /// The body that it belongs to, if any.
    pub body: Option<Entity>,
    /// The particles that it connected.
    pub particles: Vec<Entity>,
    /// The mean position of these particles, metres in the world.
    pub point: Vec3,
    /// The force that it carried, N. Zero if that was not measured, because it has no force limit.
    pub force: f32,
    /// Its elongation as a fraction of its rest length; zero if it has no rest length.
    pub strain: f32,
}

/// A constraint that may break, and its index in the solver's lists. Scratch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Breakable {
    at: LinkIndex,
    limits: BreakAt,
    /// What breaks: the constraint, or the attachment that it belongs to.
    target: Entity,
    body: Option<Entity>,
}

/// The constraints that may break, for the solver's lists of this tick.
#[derive(Resource, Default)]
pub(crate) struct Breakables {
    all: Vec<(CreationOrder, Entity, Breakable)>,
    version: u64,
    count: usize,
}

/// Lists the constraints that may break, and enables the measurement of loads for those with a force limit and of strains for those with a strain limit.
pub(crate) fn gather_breakables(
    mut world: ResMut<SinewWorld>,
    mut breakables: ResMut<Breakables>,
    limits: Query<Ref<BreakAt>>,
    own: Query<
        (Entity, &BreakAt, Option<&ConstraintOf>),
        (Without<AttachTo>, Without<BodyConstraints>),
    >,
    bodies: Query<(Entity, &BreakAt, Ref<BodyConstraints>)>,
    attachments: Query<
        (Entity, &BreakAt, Ref<AttachmentJoints>, Option<&AttachmentOf>),
        With<AttachTo>,
    >,
    limited: Query<(), With<BreakAt>>,
    orders: Query<&CreationOrder>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let (count, changed) = count_and_changed(&limits);
    let count_changed = core::mem::replace(&mut breakables.count, count) != count;
    if count == 0 {
        if count_changed {
            breakables.all.clear();
            simulation.measure_loads([], []);
            simulation.measure_strains([]);
        }
        return;
    }
    let stale = changed
        || count_changed
        || breakables.version != tables.links.version
        || bodies.iter().any(|(.., list)| list.is_changed())
        || attachments.iter().any(|(_, _, joints, _)| joints.is_changed());
    if !stale {
        return;
    }
    breakables.version = tables.links.version;
    let list = &mut breakables.all;
    list.clear();
    let mut add = |constraint: Entity, limits: &BreakAt, target: Entity, body: Option<Entity>| {
        let Ok(&order) = orders.get(constraint) else { return };
        tables.links.find(order, constraint, |at| {
            list.push((order, constraint, Breakable { at, limits: *limits, target, body }));
        });
    };
    for (constraint, limits, of) in &own {
        add(constraint, limits, constraint, of.map(|of| of.0));
    }
    for (body, limits, constraints) in &bodies {
        for constraint in constraints.iter().filter(|&constraint| !limited.contains(constraint)) {
            add(constraint, limits, constraint, Some(body));
        }
    }
    for (attachment, limits, joints, of) in &attachments {
        for joint in joints.iter() {
            add(joint, limits, attachment, Some(of.map_or(attachment, |of| of.0)));
        }
    }
    list.sort_unstable_by_key(|&(order, entity, one)| (order, entity, one.at));
    let by_force = || list.iter().map(|(.., one)| one).filter(|one| one.limits.force.is_finite());
    let mut distances: Vec<usize> = by_force().filter_map(|one| one.at.distance()).collect();
    let mut constraints: Vec<usize> = by_force().filter_map(|one| one.at.constraint()).collect();
    distances.sort_unstable();
    constraints.sort_unstable();
    simulation.measure_loads(distances, constraints);
    let by_strain = list.iter().filter(|(.., one)| one.limits.strain.is_finite());
    simulation.measure_strains(by_strain.filter_map(|(.., one)| one.at.distance()));
}

/// Breaks the constraints that exceed a limit.
pub(crate) fn break_constraints(
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    breakables: Res<Breakables>,
    mut commands: Commands,
) {
    if breakables.all.is_empty() || !clock.is_behind(&world) {
        return;
    }
    let mut broken: Vec<Broke> =
        breakables.all.iter().filter_map(|(.., one)| one.event(&world)).collect();
    // Of an attachment with several constraints, the first that breaks is reported.
    let mut reported = EntityHashSet::default();
    broken.retain(|event| reported.insert(event.constraint));
    if !broken.is_empty() {
        commands.queue(move |world: &mut World| {
            broken.into_iter().for_each(|one| break_constraint(world, one));
        });
    }
}

impl Breakable {
    /// The event, if the constraint exceeds a limit.
    fn event(&self, world: &SinewWorld) -> Option<Broke> {
        let (simulation, tables) = (&world.simulation, &world.tables);
        let particles = &simulation.particles;
        let (mut ends, mut rest, mut sign) = (None, 0.0, 1.0);
        let force = match self.at {
            LinkIndex::Distance(number) => {
                let distance = simulation.distances().get(number)?;
                (ends, rest) = (Some([distance.a, distance.b]), distance.rest);
                if distance.bound == Bound::AtLeast {
                    sign = -1.0;
                }
                simulation.distance_load(number).unwrap_or(0.0) * sign
            }
            LinkIndex::Spring(number) => {
                let spring = simulation.forces.springs.get(number)?;
                (ends, rest) = (Some([spring.a, spring.b]), spring.rest);
                spring.tension(particles)
            }
            LinkIndex::Constraint(number) => simulation.constraint_load(number).unwrap_or(0.0),
        };
        let strain = match ends {
            Some([a, b]) if rest > 0.0 => {
                let length = particles.separation(a as usize, b as usize).length();
                sign * (length - rest) / rest
            }
            _ => 0.0,
        };
        let exceeds = |value: f32, limit: f32| limit >= 0.0 && limit.is_finite() && value > limit;
        if !exceeds(force, self.limits.force) && !exceeds(strain, self.limits.strain) {
            return None;
        }
        let rows: &[u32] = match (&ends, self.at) {
            (Some(ends), _) => ends,
            (None, LinkIndex::Constraint(number)) => &simulation.constraints().get(number)?.rows,
            _ => return None,
        };
        let near = particles.position(*rows.first()? as usize);
        let sum: Vec3 = rows.iter().map(|&row| particles.relative_to(row as usize, near)).sum();
        Some(Broke {
            entity: self.target,
            constraint: self.target,
            body: self.body,
            particles: rows.iter().map(|&row| tables.entities[row as usize]).collect(),
            point: near + sum / rows.len() as f32,
            force,
            strain,
        })
    }
}

/// Sends the event, and despawns what broke.
fn break_constraint(world: &mut World, event: Broke) {
    let constraint = event.constraint;
    if world.get_entity(constraint).is_err() {
        return;
    }
    let body = event.body.filter(|&body| body != constraint);
    world.write_message(event.clone());
    world.trigger(event.clone());
    if let Some(body) = body.filter(|&body| world.get_entity(body).is_ok()) {
        world.trigger(Broke { entity: body, ..event });
    }
    world.flush();
    let Ok(mut entity) = world.get_entity_mut(constraint) else { return };
    // An attachment on the body itself is removed as a component; the body stays.
    if entity.contains::<AttachTo>() && !entity.contains::<AttachmentOf>() {
        entity.remove::<AttachTo>();
        world.flush();
    } else {
        entity.despawn();
    }
}
