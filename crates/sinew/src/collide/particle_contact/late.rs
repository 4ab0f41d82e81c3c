//! Contacts of rows that moved further than the broad phase allowed for: a ball at rest that is hit, a thread that whips. They are tested against every surface,
//! and what they touch is added here while islands are solved, so that they bounce, slide and are reported as any other.

use core::ops::Range;
use core::sync::atomic::{AtomicBool, Ordering};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{InstantInterval, NormalImpulse, ParticleContacts, SurfaceCandidate};
use crate::particles::Places;

/// A contact that the broad phase has not foreseen.
#[derive(Clone, Copy, Debug)]
pub(super) struct LateContact {
    pub(super) candidate: SurfaceCandidate,
    pub(super) impulse: NormalImpulse,
}

/// The contacts of a step that the broad phase has not foreseen, by row and surface. Workers add to them at the same time, each for its own rows.
#[derive(Debug, Default)]
pub(super) struct LateContacts {
    /// Whether there are any: saves taking the lock, as there hardly ever are.
    any: AtomicBool,
    contacts: Mutex<BTreeMap<[u32; 2], LateContact>>,
}

impl LateContacts {
    pub(super) fn any(&self) -> bool {
        self.any.load(Ordering::Relaxed)
    }

    pub(super) fn clear(&mut self) {
        if core::mem::take(self.any.get_mut()) {
            self.lock().clear();
        }
    }

    /// Calls a function for each contact of some rows, with its row.
    pub(super) fn each(&self, rows: Range<u32>, mut with: impl FnMut(u32, &mut LateContact)) {
        if self.any() && !rows.is_empty() {
            let mut contacts = self.lock();
            let of_rows = contacts.range_mut([rows.start, 0]..[rows.end, 0]);
            of_rows.for_each(|(&[row, _], contact)| with(row, contact));
        }
    }

    /// Calls a function with the contact of a row and a surface, which is added if it is new.
    fn with<R>(
        &self,
        row: u32,
        candidate: SurfaceCandidate,
        with: impl FnOnce(&mut NormalImpulse) -> R,
    ) -> R {
        self.any.store(true, Ordering::Relaxed);
        let mut contacts = self.lock();
        let new = LateContact { candidate, impulse: NormalImpulse::default() };
        with(&mut contacts.entry([row, candidate.surface]).or_insert(new).impulse)
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<[u32; 2], LateContact>> {
        self.contacts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ParticleContacts {
    /// As [`project_to_surfaces`](Self::project_to_surfaces), against all surfaces: for a row that moved further than the broad phase allowed for.
    #[cold]
    pub(super) fn project_to_all_surfaces(
        &self,
        places: &mut Places,
        row: u32,
        interval: InstantInterval,
    ) -> f32 {
        let mut worst = 0.0_f32;
        for number in 0..self.surfaces.len() {
            let material = self.material(number, self.classes.of(row));
            let Some(material) = material.filter(|_| !self.ignores(row, number)) else { continue };
            let Some(contact) = self.contact(places, row, (number, None), interval) else {
                continue;
            };
            let candidate = SurfaceCandidate::new(number, *material, self.gravity.of(row));
            let depth = self.late.0.with(row, candidate, |impulse| {
                self.resolve(places, impulse, (row, &candidate), &contact)
            });
            worst = worst.max(depth);
        }
        worst
    }
}
