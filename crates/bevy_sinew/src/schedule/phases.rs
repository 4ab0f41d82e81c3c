//! Phase steps: the phases of a tick, shown one by one while the simulation is paused.

use std::collections::VecDeque;

use bevy::prelude::*;
use sinew::Particles;

use super::{PHASE_ORDER, PhaseSystems, SinewControl};
use crate::components::{Particle, RigidPose};
use crate::world::{PhaseWatch, SinewWorld};

/// Shows a paused simulation phase by phase: [`step`](Self::step) advances to the next phase.
///
/// The first step runs a whole tick, and records the particles at the end of each of its phases. What is drawn is then the state at the end of the first phase,
/// and with each further step that of the next one: gizmos, meshes, transforms as the renderer receives them (`GlobalTransform`), and the columns of
/// [`SinewWorld`] outside of ticks. **The components always have the state at the end of the tick**: the tick is the same as any other, bit for bit, and a
/// save, a rollback or a resumed simulation uses a complete tick. A tick or a restored snapshot ends the display. Edits in between take effect in the next
/// tick, as usual. The step after the last phase shows the end of the tick.
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
/// None of it is state. It costs a copy of the particles for each phase, 256 MiB at most: of a large world only the first phases are shown, and then the end.
#[derive(Resource, Debug, Default)]
pub struct PhaseSteps {
    /// Steps that were requested and are still to be taken.
    requested: u32,
    /// Whether the next tick is to be recorded.
    pub(super) records_next: bool,
    /// The phase that is shown, and those after it.
    current: Option<Particles>,
    later: VecDeque<Particles>,
    /// The actual particles, while others are shown in their place.
    actual: Option<Particles>,
    /// Index of the phase that is shown, from 0 at the start of the tick.
    number: usize,
    substeps: u32,
    /// The layout of the recorded rows.
    layout: u64,
    /// Whether the display is to end at the next fixed tick.
    ended: bool,
}

/// The phase that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseStep {
    /// The substep, counted from 1.
    pub substep: u32,
    /// The number of substeps of the tick.
    pub substeps: u32,
    /// The state that is shown is that at the end of this phase.
    pub phase: PhaseSystems,
    /// The phase that the next step shows; `None` for the end of the tick.
    pub next: Option<PhaseSystems>,
}

impl PhaseSteps {
    /// Advances to the next phase, at the next fixed tick, if the simulation is paused. If no phase is shown yet, it requests the tick from `control`.
    pub fn step(&mut self, control: &mut SinewControl) {
        if self.records_next || self.actual.is_some() {
            self.requested = self.requested.saturating_add(1);
        } else if control.stands() {
            self.records_next = true;
            control.step();
        }
    }

    /// Ends the display: the end of the tick is shown.
    pub fn end(&mut self) {
        (self.ended, self.requested) = (self.actual.is_some(), 0);
    }

    /// The phase that is shown; `None` for the end of the tick, as usual.
    pub fn shown(&self) -> Option<PhaseStep> {
        self.actual.as_ref()?;
        let (count, left) = (PHASE_ORDER.len(), !self.later.is_empty());
        Some(PhaseStep {
            substep: (self.number / count) as u32 + 1,
            substeps: self.substeps,
            phase: PHASE_ORDER[self.number % count],
            next: left.then(|| PHASE_ORDER[(self.number + 1) % count]),
        })
    }

    /// Takes the record of a tick.
    pub(super) fn take(&mut self, watch: Option<&mut PhaseWatch>, substeps: u32, layout: u64) {
        self.later = watch.and_then(|watch| watch.frames.take()).unwrap_or_default().into();
        self.current = self.later.pop_front();
        (self.number, self.substeps, self.layout, self.records_next) = (0, substeps, layout, false);
    }

    fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Before a fixed tick: puts the actual particles back, and selects what is shown next.
pub(super) fn choose(world: &mut World) {
    let steps = world.resource::<PhaseSteps>();
    if steps.actual.is_none() && !steps.records_next {
        return;
    }
    let control = *world.resource::<SinewControl>();
    let was_shown = steps.actual.is_some();
    world.resource_scope(|world, mut steps: Mut<PhaseSteps>| {
        let sinew = &mut *world.resource_mut::<SinewWorld>();
        if let Some(actual) = steps.actual.take() {
            steps.current = Some(core::mem::replace(&mut sinew.simulation.particles, actual));
        }
        // A tick that is due shows its phases if the first step requested it, and its end otherwise.
        if steps.ended || !control.stands() || (control.single_steps > 0) != steps.records_next {
            steps.forget();
        } else if !steps.records_next && steps.requested > 0 {
            steps.requested -= 1;
            steps.current = steps.later.pop_front();
            steps.number += 1;
        }
    });
    if was_shown && world.resource::<PhaseSteps>().current.is_none() {
        redraw(world);
    }
}

/// Marks transforms as changed, because the renderer received those of a phase.
fn redraw(world: &mut World) {
    let mut drawn = world.query_filtered::<&mut Transform, Or<(With<RigidPose>, With<Particle>)>>();
    drawn.iter_mut(world).for_each(|mut transform| transform.set_changed());
}

/// After a fixed tick: replaces the particles by those that are shown.
pub(super) fn show(world: &mut World) {
    if world.resource::<PhaseSteps>().current.is_none() {
        return;
    }
    world.resource_scope(|world, mut steps: Mut<PhaseSteps>| {
        let sinew = &mut *world.resource_mut::<SinewWorld>();
        // If particles were added or removed, the recorded rows are no longer valid.
        if steps.layout != sinew.tables.layout.number {
            steps.forget();
        } else if let Some(current) = steps.current.take() {
            steps.actual = Some(core::mem::replace(&mut sinew.simulation.particles, current));
        }
    });
    if world.resource::<PhaseSteps>().actual.is_none() {
        redraw(world);
    }
}

/// Run condition: whether a phase is shown.
pub(crate) fn is_shown(steps: Res<PhaseSteps>) -> bool {
    steps.actual.is_some()
}
