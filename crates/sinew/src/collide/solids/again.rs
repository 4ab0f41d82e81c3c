//! What changes while a step goes on: pairs that turn and slide on each other are compared again, and moving stands are followed.

use glam::Vec3;

use super::super::manifold::collide;
use super::super::{Frame, World};
use super::Solids;
use super::found::put_manifold;
use super::pack::Pack;
use crate::lanes::LANES;

impl Solids {
    /// Compares those again that have turned against each other, or slid on each other, by more than their points are good for; at the places where
    /// this substep began, after a share of the step.
    ///
    /// Where the points of a manifold are farther apart than others may have come nearer than those meanwhile (`Pack::elsewhere`), nothing touches,
    /// and nothing is compared: so most that fly past each other never are.
    pub(super) fn compare_again(&mut self, world: &World, share: f32) {
        let Self { groups, seen, stands, found, packs, bodies, scratch, memory, .. } = self;
        let frame = |number: usize| bodies.frame(groups.place(number), groups.parts[number].centre);
        let time = (1.0 - share) * world.dt;
        for pack in packs {
            // Nearly all are as they were: that is one question.
            if (0..LANES).fold(true, |good, lane| good & holds(pack, lane)) {
                continue;
            }
            for lane in 0..LANES {
                if holds(pack, lane) {
                    continue;
                }
                let Some(one) = found.get_mut(pack.number[lane] as usize) else { continue };
                let known = &mut memory.now[one.memory as usize];
                // Those of several are found once a step.
                if known.reach < 0.0 {
                    continue;
                }
                let (a, b) = (one.a as usize, one.b as usize);
                let (shape, own) = (&world.solids[a].shape, frame(a));
                let stand = one.stand.map(|number| &stands[number as usize]);
                let (other, theirs, centre, reach) = match stand {
                    Some(stand) => {
                        let theirs = stand.frame_at(world, share);
                        let theirs = stand.seen_from(&theirs, seen[a].origin);
                        one.offset = theirs.translation;
                        let reach = seen[a].reach(time) + stand.carries(&seen[a], world, share);
                        (&stand.shape, theirs, Vec3::ZERO, reach)
                    }
                    None => {
                        let theirs = frame(b);
                        let reach = seen[a].reach_of(&seen[b], time);
                        let translation = theirs.translation + one.offset;
                        (
                            &world.solids[b].shape,
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
                put_manifold(pack, lane, (one, known), [groups.parts[a].centre, centre]);
            }
        }
    }

    /// Where moving stands are when a substep begins, as seen from what may touch them.
    pub(super) fn follow_stands(&mut self, world: &World, from: f32) {
        let Self { found, packs, stands, seen, .. } = self;
        if stands.iter().all(|stand| stand.moving.is_none()) {
            return;
        }
        for pack in packs {
            for lane in 0..LANES {
                let Some(one) = found.get(pack.number[lane] as usize) else { continue };
                let Some(stand) = one.stand.map(|number| &stands[number as usize]) else {
                    continue;
                };
                if stand.moving.is_some() {
                    let frame = stand.frame_at(world, from);
                    let here = stand.seen_from(&frame, seen[one.a as usize].origin).translation;
                    for (to, from) in pack.offset.iter_mut().zip(here.to_array()) {
                        to[lane] = from;
                    }
                }
            }
        }
    }
}

/// Whether a manifold is still good for what it is needed for.
#[inline(always)]
fn holds(pack: &Pack, lane: usize) -> bool {
    let strain = pack.strain[lane];
    (strain < 1.0) | (pack.elsewhere[lane] * strain < pack.gap[lane])
}
