//! Refresh of manifolds within a step: pairs that turn and slide on each other are compared again, and kinematic geometry is followed.

use glam::Vec3;

use super::super::manifold::collide;
use super::super::{Frame, World};
use super::BodyContactSolver;
use super::contacts::put_manifold;
use super::wide_contact::WideContact;
use crate::lanes::LANES;

impl BodyContactSolver {
    /// Compares those again that have turned against each other, or slid on each other, by more than their points are good for; at the places where
    /// this substep began, after a share of the step.
    ///
    /// Where the points of a manifold are farther apart than others may have come nearer than those meanwhile (`WideContact::elsewhere`), nothing
    /// touches, and nothing is compared: so most that fly past each other never are.
    pub(super) fn refresh_manifolds(&mut self, world: &World, share: f32) {
        let Self {
            groups,
            swept,
            static_geometry,
            contacts,
            wide_contacts,
            bodies,
            scratch,
            cache,
            ..
        } = self;
        let frame = |number: usize| bodies.frame(groups.place(number), groups.parts[number].centre);
        let time = (1.0 - share) * world.dt;
        for wide in wide_contacts {
            // Nearly all are as they were: that is one question.
            if (0..LANES).fold(true, |good, lane| good & holds(wide, lane)) {
                continue;
            }
            for lane in 0..LANES {
                if holds(wide, lane) {
                    continue;
                }
                let Some(one) = contacts.get_mut(wide.number[lane] as usize) else { continue };
                let known = &mut cache.now[one.cache_index as usize];
                // Those of several are found once a step.
                if known.reach < 0.0 {
                    continue;
                }
                let (a, b) = (one.a as usize, one.b as usize);
                let (shape, own) = (&world.body_colliders[a].shape, frame(a));
                let geometry = one.geometry.map(|number| &static_geometry[number as usize]);
                let (other, theirs, centre, reach) = match geometry {
                    Some(geometry) => {
                        let theirs = geometry.frame_at(world, share);
                        let theirs = geometry.seen_from(&theirs, swept[a].origin);
                        one.offset = theirs.translation;
                        let reach =
                            swept[a].reach(time) + geometry.carries(&swept[a], world, share);
                        (&geometry.shape, theirs, Vec3::ZERO, reach)
                    }
                    None => {
                        let theirs = frame(b);
                        let reach = swept[a].reach_of(&swept[b], time);
                        let translation = theirs.translation + one.offset;
                        (
                            &world.body_colliders[b].shape,
                            Frame { translation, ..theirs },
                            groups.parts[b].centre,
                            reach,
                        )
                    }
                };
                let seen_from = own.from_within(&theirs);
                known.manifold = Default::default();
                (known.seen_from, known.reach) = (seen_from, reach);
                collide(shape, other, &seen_from, reach, &mut scratch.0, &mut |manifold| {
                    known.manifold = *manifold;
                });
                put_manifold(wide, lane, (one, known), [groups.parts[a].centre, centre]);
            }
        }
    }

    /// Where kinematic geometry is when a substep begins, as seen from what may touch them.
    pub(super) fn follow_kinematic_geometry(&mut self, world: &World, from: f32) {
        let Self { contacts, wide_contacts, static_geometry, swept, .. } = self;
        if static_geometry.iter().all(|geometry| geometry.moving.is_none()) {
            return;
        }
        for wide in wide_contacts {
            for lane in 0..LANES {
                let Some(one) = contacts.get(wide.number[lane] as usize) else { continue };
                let Some(geometry) = one.geometry.map(|number| &static_geometry[number as usize])
                else {
                    continue;
                };
                if geometry.moving.is_some() {
                    let frame = geometry.frame_at(world, from);
                    let here = geometry.seen_from(&frame, swept[one.a as usize].origin).translation;
                    for (to, from) in wide.offset.iter_mut().zip(here.to_array()) {
                        to[lane] = from;
                    }
                }
            }
        }
    }
}

/// Whether a manifold is still good for what it is needed for.
#[inline(always)]
fn holds(wide: &WideContact, lane: usize) -> bool {
    let staleness = wide.staleness[lane];
    (staleness < 1.0) | (wide.elsewhere[lane] * staleness < wide.predicted_gap[lane])
}
