//! Islands of which a body collider was stopped abruptly in a substep, so that their constraints are swept once more in it.
//!
//! Contacts come after the constraints of a substep, and move one body collider by itself: a shin that hits the floor at 5 m/s is moved back by 8 mm in a
//! substep of 1/600 s while the thigh goes on; joints and bones are off by as much when the substep ends, and only the next one passes the impulse on. So
//! where a contact has changed a velocity abruptly, the constraints of that island are swept once more after the contacts, and the remaining error is a
//! fraction of that, in the contact. Ragdolls that fall by metres, singly, in a pile or under a crate of a ton, then have bones off by 0.5 % at worst,
//! instead of 3 to 8 %.
//!
//! The contact has to bear that error. A load `F` that lies permanently on a light mass `m` pushes it by `F h²/m` in each substep: bones are stretched by
//! that if contacts come last, and are drawn into the ground if constraints do. The latter is chosen for a lasting load as long as the displacement is less
//! than a contact recovers in a substep and less than the colliding parts are thick; with a greater one an island is swept once more only while the contact
//! has just begun.

use super::super::recovery::in_substep;
use super::bodies::SHIFT;
use super::wide_contact::WideContact;
use super::{BodyContactSolver, RECOVERED};
use crate::islands::Islands;
use crate::lanes::LANES;

/// Change of velocity of a body collider in a substep from which on a contact counts as abrupt: a multiple of what gravity gives, and a speed, m/s. Limbs at
/// rest carry some ten times their own weight.
const SUDDEN: (f32, f32) = (15.0, 0.1);
/// Ratio of its impulse to the mean of the substeps before, from which on a contact counts as just begun: the mean reaches that after some eight substeps.
const BEGUN_RATIO: f32 = 1.1;
/// Share of its radius by which a round shape may be drawn in, in a substep.
const DRAWN_IN: f32 = 0.25;

impl BodyContactSolver {
    /// Numbers of the islands with an abruptly stopped body collider in the last substep, ascending, each once.
    pub(crate) fn stopped(&self) -> &[u32] {
        &self.stopped
    }

    /// Lists them in a substep of `h` seconds, once normals have been solved. Islands that consist of one body collider are left out: they have no other body
    /// to pass the impulse on to.
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
                    // Static geometry and the null row come after the rows of body colliders.
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

/// Whether a manifold presses harder than before. It is not known for manifolds without friction.
fn has_begun(wide: &WideContact, lane: usize) -> bool {
    wide.friction[lane] > 0.0 && wide.sum[lane] > BEGUN_RATIO * wide.friction_limit[lane]
}

/// How far the colliding shapes may be drawn in, metres; infinite if neither is round.
fn thin(wide: &WideContact, lane: usize) -> f32 {
    let radii = wide.radii.iter().map(|radii| radii[lane]).filter(|&radius| radius > 0.0);
    radii.fold(f32::INFINITY, f32::min) * DRAWN_IN
}
