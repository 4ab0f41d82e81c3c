//! Half-steps: the phases of a tick, shown one by one while the simulation is paused.

use std::collections::VecDeque;

use bevy::prelude::*;
use sinew::Particles;

use super::{PHASE_ORDER, PhaseSystems, SinewControl};
use crate::components::{Particle, RigidPose};
use crate::world::{PhaseWatch, SinewWorld};

/// Shows a paused simulation phase by phase: [`step`](Self::step) asks for the next one.
///
/// The first half-step takes a whole tick, and notes the particles at the end of each of its phases; what is drawn then is as of the first phase, and of the next one
/// with each half-step: gizmos, meshes, transforms as they reach the renderer (`GlobalTransform`), and the columns of [`SinewWorld`] outside of ticks. **The
/// components are those of the tick's end all the while**, so it is the same tick as one that is taken at once, bit for bit, and whatever saves, rolls back or goes on
/// finds a whole one: a save in between is one of the tick's end, and a tick or a restored snapshot ends the showing. What is edited in between acts in the next tick, as it
/// does between any two. The half-step after the last phase shows the tick's end.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::PhaseSteps;
/// fn look_closely(mut control: ResMut<SinewControl>, mut phases: ResMut<PhaseSteps>) {
///     control.pause();
///     phases.step(&mut control);
/// }
/// # bevy::ecs::system::assert_is_system(look_closely);
/// ```
///
/// Nothing of it is state. It costs a copy of the particles for each phase, 256 MiB at most: of a large world the first phases are shown, and then the end.
#[derive(Resource, Debug, Default)]
pub struct PhaseSteps {
    /// Half-steps that are yet to be taken.
    asked: u32,
    /// Whether the tick at hand is to be noted.
    pub(super) begins: bool,
    /// What is shown, and what comes after it.
    current: Option<Particles>,
    rest: VecDeque<Particles>,
    /// The particles as they are, while others are shown in their place.
    own: Option<Particles>,
    /// Which phase of the tick is shown, from 0.
    number: usize,
    substeps: u32,
    /// The layout of rows that the particles are in.
    layout: u64,
    /// Whether what is shown is no longer of this world.
    ended: bool,
}

/// Which phase is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseStep {
    /// The substep, from 1.
    pub substep: u32,
    /// Substeps of the tick.
    pub substeps: u32,
    /// What is shown is as of the end of this phase.
    pub phase: PhaseSystems,
    /// The phase that the next half-step shows; `None`: the end of the tick.
    pub next: Option<PhaseSystems>,
}

impl PhaseSteps {
    /// Shows the next phase, from the next fixed tick on, if the simulation is paused. Where none is shown yet, it asks `control` for the tick.
    pub fn step(&mut self, control: &mut SinewControl) {
        if self.begins || self.own.is_some() {
            self.asked = self.asked.saturating_add(1);
        } else if control.paused {
            self.begins = true;
            control.step();
        }
    }

    /// Shows the end of the tick.
    pub fn end(&mut self) {
        (self.ended, self.asked) = (self.own.is_some(), 0);
    }

    /// Which phase is shown; `None` where it is the end of the tick, as ever.
    pub fn shown(&self) -> Option<PhaseStep> {
        self.own.as_ref()?;
        let (count, left) = (PHASE_ORDER.len(), !self.rest.is_empty());
        Some(PhaseStep {
            substep: (self.number / count) as u32 + 1,
            substeps: self.substeps,
            phase: PHASE_ORDER[self.number % count],
            next: left.then(|| PHASE_ORDER[(self.number + 1) % count]),
        })
    }

    /// Takes what was noted of a tick.
    pub(super) fn take(&mut self, watch: Option<&mut PhaseWatch>, substeps: u32, layout: u64) {
        self.rest = watch.and_then(|watch| watch.frames.take()).unwrap_or_default().into();
        self.current = self.rest.pop_front();
        (self.number, self.substeps, self.layout, self.begins) = (0, substeps, layout, false);
    }

    fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Before a fixed tick: the particles are what they are again, and what is shown next is chosen.
pub(super) fn choose(world: &mut World) {
    let steps = world.resource::<PhaseSteps>();
    if steps.own.is_none() && !steps.begins {
        return;
    }
    let control = *world.resource::<SinewControl>();
    let was_shown = steps.own.is_some();
    world.resource_scope(|world, mut steps: Mut<PhaseSteps>| {
        let sinew = &mut *world.resource_mut::<SinewWorld>();
        if let Some(own) = steps.own.take() {
            steps.current = Some(core::mem::replace(&mut sinew.simulation.particles, own));
        }
        // A tick that is due shows its phases if it was asked for by the first half-step, and else its end.
        if steps.ended || !control.paused || (control.single_steps > 0) != steps.begins {
            steps.forget();
        } else if !steps.begins && steps.asked > 0 {
            steps.asked -= 1;
            steps.current = steps.rest.pop_front();
            steps.number += 1;
        }
    });
    if was_shown && world.resource::<PhaseSteps>().current.is_none() {
        redraw(world);
    }
}

/// What the renderer was given of a phase is no longer so.
fn redraw(world: &mut World) {
    let mut drawn = world.query_filtered::<&mut Transform, Or<(With<RigidPose>, With<Particle>)>>();
    drawn.iter_mut(world).for_each(|mut transform| transform.set_changed());
}

/// After a fixed tick: puts what is shown in the place of the particles.
pub(super) fn show(world: &mut World) {
    if world.resource::<PhaseSteps>().current.is_none() {
        return;
    }
    world.resource_scope(|world, mut steps: Mut<PhaseSteps>| {
        let sinew = &mut *world.resource_mut::<SinewWorld>();
        // Who came or went meanwhile has rows that what was noted does not know.
        if steps.layout != sinew.tables.layout.number {
            steps.forget();
        } else if let Some(current) = steps.current.take() {
            steps.own = Some(core::mem::replace(&mut sinew.simulation.particles, current));
        }
    });
    if world.resource::<PhaseSteps>().own.is_none() {
        redraw(world);
    }
}

/// Whether a phase is shown.
pub(crate) fn is_shown(steps: Res<PhaseSteps>) -> bool {
    steps.own.is_some()
}
