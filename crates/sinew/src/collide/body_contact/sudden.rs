//! Who has been stopped suddenly in a substep, so that what joints hold together has to be swept once more in it.
//!
//! Contacts come after the constraints of a substep, and move one body collider by itself: a shin that meets the floor at 5 m/s is put back by 8 mm in a
//! substep of 1/600 s, while the thigh goes on; joints and bones are off by as much when the substep ends, and only the next one hands the impulse on. So where
//! a contact has changed a velocity by much, the constraints of that island are swept once more after the contacts, and what is off is the contact, by a part of
//! that. Ragdolls that fall by metres, singly, in a pile or under a crate of a ton, have bones off by 0.5 % then at the worst, instead of 3 to 8 %.
//!
//! What it costs, a contact has to be able to bear. A load `F` that lies on a light mass `m` for good pushes it by `F h²/m` in each substep: bones are drawn out
//! by that if contacts have the last word, and drawn into the ground if they have not. Into the ground is where it comes to rest, as long as it is less than a
//! contact recovers in a substep, and less than what has met is thick; what is pushed by more has its turn only while it has just begun.

use super::super::recovery::in_substep;
use super::bodies::SHIFT;
use super::wide_contact::WideContact;
use super::{BodyContactSolver, RECOVERED};
use crate::islands::Islands;
use crate::lanes::LANES;

/// By how much a contact must change the velocity of a body collider in a substep: so many times what gravity does, and what this speed is, m/s. Limbs
/// that lie still carry some ten times their own weight.
const SUDDEN: (f32, f32) = (15.0, 0.1);
/// By which factor a contact that has just begun presses harder than in the mean of the substeps before: it has come to that after some eight of them.
const HARDER: f32 = 1.1;
/// The share of its radius that what is round may be drawn in by in a substep.
const DRAWN_IN: f32 = 0.25;

impl BodyContactSolver {
    /// Numbers of the islands of which a part has been stopped suddenly in the last substep, ascending, each once.
    pub(crate) fn stopped(&self) -> &[u32] {
        &self.stopped
    }

    /// Notes them in a substep of `h` seconds, when normals have been solved. Where a body collider is all that there is of its island, nothing is to be handed
    /// on.
    pub(super) fn note_stopped(&mut self, islands: &Islands, (h, gravity): (f32, f32)) {
        let Self { stopped, wide_contacts, bodies, groups, rigid, .. } = self;
        stopped.clear();
        let mut numbered = groups.groups.iter().enumerate();
        if numbered.all(|(number, group)| group.sound & !rigid.lanes(number) == 0) {
            return;
        }
        let (fast, recovered) = (in_substep(SUDDEN, h, gravity), in_substep(RECOVERED, h, gravity));
        for wide in wide_contacts.iter() {
            for lane in (0..LANES).filter(|&lane| wide.sum[lane] > 0.0) {
                for row in [wide.a[lane], wide.b[lane]].map(|row| row as usize) {
                    // What stands, and nothing, have the rows behind those of body colliders.
                    let (number, own) = (row / LANES, row % LANES);
                    if groups.groups.len() <= number || rigid.lanes(number) >> own & 1 == 1 {
                        continue;
                    }
                    let moved = wide.sum[lane] * bodies[row][SHIFT].w;
                    if moved <= fast
                        || (recovered.min(thin(wide, lane)) < moved && !has_begun(wide, lane))
                    {
                        continue;
                    }
                    let Some(solid) = groups.sound_in(number, own) else { continue };
                    let particles = groups.parts[solid].entries.len();
                    let is_part =
                        |&number: &u32| islands.list[number as usize].members.len() > particles;
                    stopped.extend(groups.island_of(row as u32, islands).filter(is_part));
                }
            }
        }
        stopped.sort_unstable();
        stopped.dedup();
    }
}

/// Whether a manifold presses harder than it did. Of what is smooth that is not known.
fn has_begun(wide: &WideContact, lane: usize) -> bool {
    wide.friction[lane] > 0.0 && wide.sum[lane] > HARDER * wide.friction_limit[lane]
}

/// How far what has met may be drawn in, metres: no bound where nothing is round.
fn thin(wide: &WideContact, lane: usize) -> f32 {
    let radii = wide.radii.iter().map(|radii| radii[lane]).filter(|&radius| radius > 0.0);
    radii.fold(f32::INFINITY, f32::min) * DRAWN_IN
}
