//! Statics as a command: a body, or the whole world, walks to the state that it comes to rest in, without waiting for it (physics.md F9).

use bevy::prelude::*;

use crate::components::{BodyParticles, CreationOrder, Particle, ParticleBody, RigidPose, Sleep};
use crate::messages::{EditFault, Refusal, Refused, refuse};
use crate::world::SinewWorld;

/// Brings a body, a rigid part or a particle to rest at once, where it would come to rest in time: a bridge hangs through, a curtain in its folds, a crate
/// lies on the floor. Everything else is held meanwhile as if it were pinned, so what is tied to it or lies below it does not give way.
///
/// On an entity it acts in the next tick, or in the one in which the body is built, also while the simulation is paused, and is taken off; no time passes.
/// Then it stands still. [`RelaxFinished`] says how far it came. For the whole world there is [`RelaxWorld`]. Part of the state.
///
/// The time it takes is that of [`max_steps`](Self::max_steps) ticks at the most.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Relax;
/// # use bevy_sinew::prelude::*;
/// fn build(mut commands: Commands) {
///     // A rope that hangs still from the first frame on.
///     let rope = Rope { to: Vec3::X, slack: 0.5, pin_start: true, pin_end: true, ..default() };
///     commands.spawn((rope, Relax::default()));
/// }
///
/// fn settle(mut commands: Commands, cloths: Query<Entity, With<Cloth>>) {
///     for cloth in &cloths {
///         commands.entity(cloth).relax();
///     }
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(Startup, (build, settle).chain());
/// # app.finish();
/// # app.update();
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Relax {
    /// Length of a step of the walk, seconds, positive. It walks faster with the square of it; strong springs need a short one. Default 0.2.
    pub step: f32,
    /// It has come to rest when nothing moves by more in a step, metres, 0 and up: long chains come to rest slowly, by less and less. Default 1e-6.
    pub tolerance: f32,
    /// The most steps that are taken, 1 to 100 000. Default 2000.
    pub max_steps: u32,
}

impl Default for Relax {
    fn default() -> Self {
        Self { step: 0.2, tolerance: 1e-6, max_steps: 2000 }
    }
}

/// Brings everything to rest at once: inserted as a resource, it acts in the next tick as [`Relax`] does on a body, before those, and is taken off.
/// [`SinewCommandsExt::relax_world`] inserts it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Relax, RelaxWorld};
/// # fn example(mut commands: Commands) {
/// // A level begins with everything at rest.
/// commands.relax_world();
/// // The same in no more than so many steps.
/// commands.insert_resource(RelaxWorld(Relax { max_steps: 200, ..default() }));
/// # }
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct RelaxWorld(pub Relax);

/// How far a [`Relax`] or a [`RelaxWorld`] came: a message, and an event to be observed.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::RelaxFinished;
/// fn ready(mut finished: MessageReader<RelaxFinished>) {
///     for done in finished.read() {
///         println!("{} after {} steps", if done.settled { "at rest" } else { "not yet" }, done.steps);
///     }
/// }
/// ```
#[derive(Message, Event, Reflect, Clone, Copy, Debug, PartialEq)]
pub struct RelaxFinished {
    /// The body, part or particle; `None` for the whole world.
    pub entity: Option<Entity>,
    /// Steps that it took.
    pub steps: u32,
    /// How far the particle that moved most went in the last of them, metres.
    pub moved: f32,
    /// Whether that was within the tolerance.
    pub settled: bool,
}

/// Commands on the simulation as a whole.
pub trait SinewCommandsExt {
    /// Brings everything to rest in the next tick: inserts a [`RelaxWorld`].
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sinew::prelude::*;
    /// # use bevy_sinew::SinewCommandsExt;
    /// fn begin_level(mut commands: Commands) {
    ///     commands.relax_world();
    /// }
    /// ```
    fn relax_world(&mut self) -> &mut Self;
}

impl SinewCommandsExt for Commands<'_, '_> {
    fn relax_world(&mut self) -> &mut Self {
        self.insert_resource(RelaxWorld::default());
        self
    }
}

impl SinewCommandsExt for World {
    fn relax_world(&mut self) -> &mut Self {
        self.insert_resource(RelaxWorld::default());
        self
    }
}

/// Whom it is asked of.
type Asked = (
    Entity,
    Option<&'static CreationOrder>,
    &'static Relax,
    Option<&'static BodyParticles>,
    Option<&'static RigidPose>,
    Has<Particle>,
    Has<ParticleBody>,
);

/// Whether somebody asks.
pub(crate) fn is_asked(asked: Query<(), With<Relax>>, whole: Option<Res<RelaxWorld>>) -> bool {
    whole.is_some() || !asked.is_empty()
}

/// Does what is asked: the world first, then bodies in the order of their creation.
pub(crate) fn relax_asked(
    mut commands: Commands,
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut finished: MessageWriter<RelaxFinished>,
    whole: Option<Res<RelaxWorld>>,
    asked: Query<Asked>,
    mut particles: Query<&mut Particle>,
    mut sleepers: Query<&mut Sleep>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let mut walks = Vec::new();
    if let Some(whole) = whole {
        commands.remove_resource::<RelaxWorld>();
        walks.push((None, None, whole.0, None));
    }
    for (entity, order, relax, members, posed, is_particle, is_body) in &asked {
        let list: Vec<Entity> = match (members, posed) {
            (Some(members), _) => members.iter().collect(),
            (None, Some(posed)) => posed.particles.clone(),
            (None, None) if is_particle => vec![entity],
            // It waits for its particles.
            (None, None) if is_body => continue,
            (None, None) => Vec::new(),
        };
        commands.entity(entity).try_remove::<Relax>();
        walks.push((order.copied(), Some(entity), *relax, Some(list)));
    }
    walks.sort_by_key(|&(order, entity, ..)| (entity.is_some(), order, entity));
    for (_, entity, relax, list) in walks {
        let Relax { step, tolerance, max_steps } = relax;
        // In this order, NaN is 0.
        let (tolerance, most) = (tolerance.max(0.0), max_steps.clamp(1, 100_000));
        let rows: Vec<u32> = match &list {
            Some(list) => list.iter().filter_map(|&one| tables.sound_row(one)).collect(),
            None => {
                let all = 0..tables.entities.len() as u32;
                all.filter(|&row| tables.is_sound(row as usize)).collect()
            }
        };
        let name = entity.unwrap_or(Entity::PLACEHOLDER);
        if list.as_ref().is_some_and(Vec::is_empty) {
            refuse(&mut messages, name, Refusal::Edit(EditFault::NoParticles));
            continue;
        }
        let found = match list {
            Some(_) => simulation.relax_rows(&rows, step, tolerance, most),
            None => simulation.relax(step, tolerance, most),
        };
        let Ok(sinew::Relaxed { steps, moved, settled }) = found else {
            refuse(&mut messages, name, Refusal::Edit(EditFault::NotFinite));
            continue;
        };
        let states = rows.iter().flat_map(|&row| {
            let row = row as usize;
            simulation.particles.states(row..row + 1).map(move |state| (row, state))
        });
        for (row, state) in states {
            if let Ok(mut to) = particles.get_mut(tables.entities[row]) {
                to.set_if_neq(state.into());
            }
        }
        match entity {
            Some(entity) => sleepers.get_mut(entity).iter_mut().for_each(|sleep| sleep.wake()),
            None => sleepers.iter_mut().for_each(|mut sleep| sleep.wake()),
        }
        let event = RelaxFinished { entity, steps, moved, settled };
        finished.write(event);
        commands.trigger(event);
    }
}
