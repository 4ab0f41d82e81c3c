//! Change detection over whole tables at once: for most components a warm tick only needs to know whether any of them changed.

use bevy::ecs::change_detection::{ContiguousRef, Tick};
use bevy::ecs::query::ArchetypeFilter;
use bevy::prelude::*;

use crate::components::ExtractedTransform;

/// How many ticks are compared at a time: enough that the compiler vectorises the comparison, few enough that an early change ends the search early.
const STRIDE: usize = 64;

/// The added and changed ticks of a table's column, relative to the last run of a system.
#[derive(Clone, Copy)]
pub(crate) struct ChangeTicks<'w> {
    added: &'w [Tick],
    changed: &'w [Tick],
    now: u32,
    last: u32,
}

impl<'w> ChangeTicks<'w> {
    pub(crate) fn of<T>(column: &ContiguousRef<'w, T>) -> Self {
        Self {
            added: column.added_ticks_slice(),
            changed: column.changed_ticks_slice(),
            now: column.this_run_tick().get(),
            last: column.last_run_tick().get(),
        }
    }

    /// How many components there are.
    pub(crate) fn len(&self) -> usize {
        self.changed.len()
    }

    /// Whether any changed (or was added) since the system last ran.
    pub(crate) fn any_changed(&self) -> bool {
        self.any_newer(self.changed)
    }

    /// Whether any was added since.
    pub(crate) fn any_added(&self) -> bool {
        self.any_newer(self.added)
    }

    /// The positions of the components that changed.
    pub(crate) fn changed(&self) -> impl Iterator<Item = usize> + use<'w> {
        self.newer(self.changed)
    }

    /// The positions of the components that were added.
    pub(crate) fn added(&self) -> impl Iterator<Item = usize> + use<'w> {
        self.newer(self.added)
    }

    /// The tick at which the component at a position changed.
    pub(crate) fn when(&self, place: usize) -> Tick {
        self.changed[place]
    }

    fn newer(&self, ticks: &'w [Tick]) -> impl Iterator<Item = usize> + use<'w> {
        let (now, age) = (self.now, self.now.wrapping_sub(self.last));
        (0..ticks.len()).filter(move |&place| now.wrapping_sub(ticks[place].get()) < age)
    }

    fn any_newer(&self, ticks: &[Tick]) -> bool {
        // Bevy keeps all ticks far below the point where they would wrap around.
        let age = self.now.wrapping_sub(self.last);
        let newer = |tick: &Tick| self.now.wrapping_sub(tick.get()) < age;
        ticks.chunks(STRIDE).any(|some| some.iter().fold(false, |any, tick| any | newer(tick)))
    }
}

/// The number of components in all tables that a query matches, and whether any of them changed since the calling system last ran.
pub(crate) fn count_and_changed<'a, T: Component, F: ArchetypeFilter>(
    query: &Query<Ref<'a, T>, F>,
) -> (usize, bool) {
    match query.contiguous_iter() {
        Ok(tables) => tables.fold((0, false), |(count, changed), column| {
            (count + column.len(), changed || ChangeTicks::of(&column).any_changed())
        }),
        // A component with sparse-set storage has no column.
        Err(_) => query.iter().fold((0, false), |(count, changed), component| {
            (count + 1, changed || component.is_changed())
        }),
    }
}

/// Run condition: whether a body may be at another place in the world than the simulation left it. A body with a parent has to be examined to find out, so the
/// condition holds while there is one, and for one more tick.
pub(crate) fn any_body_may_have_moved(
    transforms: Query<Ref<Transform>, With<ExtractedTransform>>,
    known: Query<Ref<ExtractedTransform>>,
    parented: Query<(), (With<ExtractedTransform>, With<ChildOf>)>,
    mut were_parented: Local<bool>,
) -> bool {
    let parented = !parented.is_empty();
    let were_parented = core::mem::replace(&mut *were_parented, parented);
    parented || were_parented || count_and_changed(&transforms).1 || count_and_changed(&known).1
}
