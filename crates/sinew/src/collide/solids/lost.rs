//! What joints take of what contacts did: friction that holds a bone must know how far that really went.
//!
//! A particle that `k` solids share is displaced by the `k`-th part of what each of them asks (`groups`). A pelvis, which others hang on by all of
//! its particles, goes back by half of what it slid, where contacts believe that it went back by all of it. What they do not know of they do not
//! hold: a ragdoll on the ground crept over it by up to a centimetre a second, for ever.
//!
//! So when the particles were displaced, such solids are read once more: how far their centres have gone since the substep began, and how they have
//! turned, as in `read`. By what that differs from what contacts believe, they are farther from where they stuck (`hold`). What slides does not ask.

use super::Solids;
use super::bodies::{Bodies, from_row};
use super::groups::Group;
use super::pack::Pack;
use super::read::{Gathered, Source};
use super::slip::{moved_at, pair_of_rows};
use super::turn::{Matrix, Symmetric, load, zero};
use crate::lanes::{FIELDS, LANES, Lanes, Vector, Work, with};
use crate::particles::Particles;

impl Solids {
    /// Notes where solids did not go as contacts had them, because they share particles with others.
    pub(super) fn lose(&mut self, particles: &Particles) {
        let Self { groups, lifts, bodies, gathered, packs, instructions, .. } = self;
        let mut any = false;
        for (number, group) in groups.groups.iter().enumerate().filter(|(_, group)| group.shares) {
            let source = Source {
                slots: &groups.slots[group.slots.clone()],
                lifts: lifts.of(group),
                position: &particles.position,
                other: &particles.start,
                fresh: false,
            };
            let first = number * LANES;
            with(*instructions, Lose { group, source, bodies, first, gathered });
            any = true;
        }
        if any {
            with(*instructions, Miss { packs, bodies });
        }
    }
}

/// Compares where a group is with where contacts believe it to be.
struct Lose<'a> {
    group: &'a Group,
    source: Source<'a>,
    bodies: &'a mut Bodies,
    /// The first row of the group among the bodies.
    first: usize,
    /// Scratch.
    gathered: &'a mut Vec<Gathered>,
}

impl Work for Lose<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { group, source, bodies, first, gathered } = self;
        let rows = from_row(first);
        let [shift, turn, along, across, _, believed, spin, rotation] =
            L::records::<FIELDS>(&bodies.rows, &rows);
        let (centre, step) = source.centre::<L>(&group.mass, gathered);
        let mut momentum = zero::<L>();
        for (slot, kept) in source.slots.iter().zip(gathered) {
            let (arm, moved) = (load(&kept.position) - centre, load(&kept.moved) - step);
            momentum += arm.cross(moved) * L::load(&slot.pull);
        }
        let inverse = if group.pinned {
            Symmetric::load(&group.mass.led).turned(&Matrix::of(rotation))
        } else {
            Symmetric { along: Vector::of(along).0, across: Vector::of(across).0 }
        };
        let off = step - Vector::of(believed).0 - Vector::of(shift).0;
        let turned = inverse.times(momentum) - Vector::of(spin).0 - Vector::of(turn).0;
        let [shifts, turns] = pair_of_rows(&rows);
        L::put_rows(&mut bodies.lost, &shifts, off.with(L::zero()));
        L::put_rows(&mut bodies.lost, &turns, turned.with(L::zero()));
    }
}

/// Adds what was lost to how far those are from where they stuck that stick.
struct Miss<'a> {
    packs: &'a mut [Pack],
    bodies: &'a Bodies,
}

impl Work for Miss<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { packs, bodies } = self;
        for pack in packs.iter_mut().filter(|pack| pack.stuck != 0) {
            let sticks = L::mask(pack.stuck);
            let (n, arm) = (load::<L>(&pack.up), load::<L>(&pack.arm));
            let (mut past, mut turned) = moved_at::<L>(&bodies.lost, &pack.a, arm);
            if !pack.still {
                let (own, theirs) = (centre::<L>(bodies, &pack.a), centre::<L>(bodies, &pack.b));
                let other = arm - (theirs + load::<L>(&pack.offset) - own);
                let (b, back) = moved_at::<L>(&bodies.lost, &pack.b, other);
                (past, turned) = (past - b, turned - back);
            }
            let twist = n.dot(turned);
            // Nothing that is not a number is to be remembered.
            let sound = (past.length_squared() + twist * twist).lt(L::splat(1e30));
            let sticks = sticks.and(sound);
            for (late, by) in pack.late.iter_mut().zip([past.x, past.y, past.z, twist]) {
                (L::load(late) + sticks.and(by)).store(late);
            }
        }
    }
}

/// Centres of eight bodies when the substep began, metres from their origins.
#[inline(always)]
fn centre<L: Lanes>(bodies: &Bodies, rows: &[u32; LANES]) -> Vector<L> {
    let [_, _, _, _, centre] = L::records(&bodies.rows, rows);
    Vector::of(centre).0
}
