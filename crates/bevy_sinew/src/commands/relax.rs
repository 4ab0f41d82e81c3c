//! Statics as commands: a body, or the whole world, moves to its rest state within one tick (physics.md F9).

use bevy::prelude::*;

use crate::components::{CreationOrder, Particle, Sleep};
use crate::messages::{EditFault, Refusal, Refused, refuse};
use crate::targets::{Targets, particles_of, waits};
use crate::world::SinewWorld;

/// Moves a body, a rigid part or a particle to the state in which it would come to rest: a bridge sags, a curtain hangs in its folds, a crate lies on the
/// floor. All other particles are held as if they were pinned while that is computed, so bodies that it is tied to or rests on do not give way.
///
/// On an entity it takes effect in the next tick, or in the one in which the body is built, even while the simulation is paused, and is then removed; no
/// simulated time passes. Afterwards the body has no velocity. [`RelaxFinished`] reports the result. For the whole world use [`RelaxWorld`]. Part of the state.
///
/// It takes as much computing time as [`max_steps`](Self::max_steps) ticks at most.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Relax;
/// # use bevy_sinew::prelude::*;
/// fn build(mut commands: Commands) {
///     // A rope that hangs at rest from the first frame on.
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
    /// Step length of the iteration, seconds, positive. The state moves faster with its square; strong springs require a short step. Default 0.2.
    pub step: f32,
    /// The state is at rest when no particle moves by more in a step, metres, 0 or more. Long chains converge slowly, so their remaining motion can be far
    /// below the remaining error. Default 1e-6.
    pub tolerance: f32,
    /// The maximum number of steps, 1 to 100 000. Default 2000.
    pub max_steps: u32,
}

impl Default for Relax {
    fn default() -> Self {
        Self { step: 0.2, tolerance: 1e-6, max_steps: 2000 }
    }
}

/// Moves everything to its rest state: inserted as a resource, it takes effect in the next tick as [`Relax`] does on a body, before those, and is then removed.
/// [`SinewCommandsExt::relax_world`] inserts it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Relax, RelaxWorld};
/// # fn example(mut commands: Commands) {
/// // A level begins with everything at rest.
/// commands.relax_world();
/// // The same, in at most 200 steps.
/// commands.insert_resource(RelaxWorld(Relax { max_steps: 200, ..default() }));
/// # }
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct RelaxWorld(pub Relax);

/// The result of a [`Relax`] or a [`RelaxWorld`]: a message, and an event that can be observed.
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
    /// The number of steps that were taken.
    pub steps: u32,
    /// The displacement of the particle that moved most in the last step, metres.
    pub moved: f32,
    /// Whether that was within the tolerance.
    pub settled: bool,
}

/// Commands on the simulation as a whole.
pub trait SinewCommandsExt {
    /// Moves everything to its rest state in the next tick: inserts a [`RelaxWorld`].
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

/// Run condition: whether there is any request.
pub(crate) fn any_relax(requests: Query<(), With<Relax>>, whole: Option<Res<RelaxWorld>>) -> bool {
    whole.is_some() || !requests.is_empty()
}

/// Executes the requests: the world first, then bodies in the order of their creation.
pub(crate) fn run_relax(
    mut commands: Commands,
    mut world: ResMut<SinewWorld>,
    mut messages: MessageWriter<Refused>,
    mut finished: MessageWriter<RelaxFinished>,
    whole: Option<Res<RelaxWorld>>,
    requests: Query<(Entity, Option<&CreationOrder>, &Relax)>,
    targets: Targets,
    mut particles: Query<&mut Particle>,
    mut sleepers: Query<&mut Sleep>,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    let mut runs = Vec::new();
    if let Some(whole) = whole {
        commands.remove_resource::<RelaxWorld>();
        runs.push((None, None, whole.0, None));
    }
    for (entity, order, relax) in &requests {
        let list = particles_of(&targets, entity);
        // The request waits until the body has particles.
        if list.is_empty() && waits(&targets, entity) {
            continue;
        }
        commands.entity(entity).try_remove::<Relax>();
        runs.push((order.copied(), Some(entity), *relax, Some(list)));
    }
    runs.sort_by_key(|&(order, entity, ..)| (entity.is_some(), order, entity));
    for (_, entity, relax, list) in runs {
        let Relax { step, tolerance, max_steps } = relax;
        // With the operands in this order, NaN becomes 0.
        let (tolerance, max_steps) = (tolerance.max(0.0), max_steps.clamp(1, 100_000));
        let rows: Vec<u32> = match &list {
            Some(list) => list.iter().filter_map(|&one| tables.valid_row(one)).collect(),
            None => {
                let all = 0..tables.entities.len() as u32;
                all.filter(|&row| tables.is_valid(row as usize)).collect()
            }
        };
        let name = entity.unwrap_or(Entity::PLACEHOLDER);
        if list.as_ref().is_some_and(Vec::is_empty) {
            refuse(&mut messages, name, Refusal::Edit(EditFault::NoParticles));
            continue;
        }
        let found = match list {
            Some(_) => simulation.relax_rows(&rows, step, tolerance, max_steps),
            None => simulation.relax(step, tolerance, max_steps),
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
