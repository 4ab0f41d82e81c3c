//! Friction of packs of manifolds, as Coulomb has it.
//!
//! In a heap, pressing tilts a box one way at one contact and back at the next; friction that saw it in between would drag what lies on it, a little
//! in each substep, for ever. And friction tilts boxes, which must not be the last that is done to them. So all of a heap is held before all of it is
//! pressed, against what pressed it in the substeps before; and only what has just met, or slides although it is pressed more than that, once more
//! afterwards. Positions are held against `s`, how far the two surfaces have slid on each other since the substep began, at the centre of the
//! pressure; and against the turn of one on the other. The impulse is at most `μ Σ λ`, its moment about the normal at most that times the radius of
//! the patch; of what is a point, a hundredth of its size (`pack::BLUNT`), without a memory.
//!
//! # What is to come
//!
//! Before they are pressed, things have fallen by `g h²`, and what is wedged between two slopes has slid on both by nearly that: more than friction
//! may hold. It would act against the fall with all it has, where the two slopes together let nothing slide, and leave alone what really creeps: a
//! wedged box crept at a quarter of a millimetre a second for ever, and in a heap of a thousand one or the other fell of it, for minutes. So where
//! friction would slip, it acts against what will be left when all have pressed as they did in the substeps before (`Bodies::expected`). Where it
//! sticks it does not: pressures come and go in a heap, and would shake what lies still (a thousand boxes then go on at 1 mm/s).
//!
//! # Where it stuck
//!
//! Pressing moves things after they were held, in a heap again and again, and what carries others on a slope is held before they are. What sticks
//! remembers how far it is from where it stuck (`late`), and is held against that, too: so that it stays there, however small the part that each
//! substep leaves. What lies still on a slope is late by as much as it takes for all of a stack to be held. A part of that is taken back in a substep
//! ([`BACK`]), because what is moved back leaves with speed. What slides forgets ([`FADES`]), or friction would go on pulling to where it once stuck.
//! All of it goes from step to step (`memory`).

use glam::Vec4;

use super::bodies::Bodies;
use super::pack::Pack;
use super::slip::Slip;
use super::turn::Eight;
use crate::lanes::{Lanes, Work};

/// Which part of what is late is taken back in a substep. With all of it a heap of a thousand boxes never rests (7 mm/s), with half of it at 1 to 3
/// mm/s, with a fifth at 0.1; with a twentieth a stack slips on a slope that is nearly too steep, before it is held.
pub(super) const BACK: f32 = 0.2;
/// What is left of it in a substep in which it slides. A stack on a slope that is nearly too steep slides for a few substeps in the one or other
/// contact, and must not forget by that (with 0.9 it goes on for ever); what really slides has forgotten after some fifty substeps.
pub(super) const FADES: f32 = 0.97;

/// What presses is a mean over some substeps, of which this is the share of the newest one. In a heap contacts press twice as hard in one substep and
/// not at all in the next; friction that did as they do would let go each time: a thousand boxes poured in any pose then go on at 1 to 8 mm/s for
/// ever, and with a mean they come to rest. Over time that is as much friction as there was pressure.
const NEWS: f32 = 0.25;
/// What moves neither body by more than this in a substep, metres, is none.
const NOTHING: f32 = 1e-10;
/// By which part of the mean what slides must be pressed more for friction to act on that at once. What sticks needs no more.
const MORE: f32 = 0.1;

/// Holds what slides in packs: before they are pressed, against what pressed them in the substeps before; and after that, where it is needed, against
/// what presses them more.
pub(super) struct Hold<'a> {
    pub(super) packs: &'a mut [Pack],
    pub(super) after: bool,
    /// How far what sticks may be taken back in a substep, metres.
    pub(super) most: f32,
    pub(super) bodies: &'a mut Bodies,
}

impl Work for Hold<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { packs, after, most, bodies } = self;
        if after {
            bodies.expected.fill(Vec4::ZERO);
        }
        for pack in packs {
            match (after, pack.still) {
                (false, false) => hold_before::<L, false>(pack, bodies),
                (false, true) => hold_before::<L, true>(pack, bodies),
                (true, false) => hold_after::<L, false>(pack, bodies, most),
                (true, true) => hold_after::<L, true>(pack, bodies, most),
            }
        }
    }
}
/// Against what pressed it in the substeps before. `STILL` is what the pack says of that, as in `contact`.
#[inline(always)]
fn hold_before<L: Lanes, const STILL: bool>(pack: &mut Pack, bodies: &mut Bodies) {
    let none = L::zero();
    let allowed = none.lt(L::load(&pack.friction)).and(L::load(&pack.allowed));
    let used = if none.lt(allowed).any() {
        let slip = Slip::of::<STILL>(pack, bodies);
        let slid = slip.slid + slip.late * L::splat(BACK);
        let answer = slip.answer(pack, slid, allowed);
        let slips = none.lt(allowed).and(allowed.le(answer.used));
        let answer = if slips.any() {
            let expected = slid + slip.expected(pack, bodies);
            slip.answer(pack, expected.or_else(slips, slid), allowed)
        } else {
            answer
        };
        slip.apply(pack, &answer, bodies);
        answer.used
    } else {
        none
    };
    used.store(&mut pack.used);
}

/// Against what pressed it more than that, and what is to be remembered.
#[inline(always)]
fn hold_after<L: Lanes, const STILL: bool>(pack: &mut Pack, bodies: &mut Bodies, most: f32) {
    let none = L::zero();
    let allowed = none.lt(L::load(&pack.friction)).and(L::load(&pack.allowed));
    let (sum, mut used) = (L::load(&pack.sum), L::load(&pack.used));
    let more = none.lt(L::load(&pack.friction)).and((sum - allowed).max(none));
    if !none.lt(more.max(allowed)).any() {
        // What has let go for a substep takes hold again where it was.
        pack.stuck = 0;
        for late in &mut pack.late {
            (L::load(late) * L::splat(FADES)).store(late);
        }
        pack.allowed = Eight::default();
        return;
    }
    let slip = Slip::of::<STILL>(pack, bodies);
    let (mut left, mut granted) = (slip.slid, allowed);
    let needs = used.lt(allowed).select(none, more);
    let needs = (allowed * L::splat(MORE)).lt(needs).and(needs);
    if none.lt(needs).any() {
        // Who was not held before is held against what is late here.
        let fresh = allowed.le(none).and(L::splat(BACK));
        let answer = slip.answer(pack, slip.slid + slip.late * fresh, needs);
        slip.apply(pack, &answer, bodies);
        (used, granted) = (used + answer.used, granted + needs);
        left += answer.back;
    }
    slip.keep(pack, left, used.lt(granted), most);
    let old = L::load(&pack.allowed);
    let mean = old + (sum - old) * L::splat(NEWS);
    let light = (mean * slip.weight()).le(L::splat(NOTHING));
    let rough = none.lt(L::load(&pack.friction));
    let allowed = rough.and(light.select(none, mean));
    allowed.store(&mut pack.allowed);
    slip.expect(pack, allowed, bodies);
}

/// Notes how packs are expected to press in the next substep, where nothing has pressed yet: all that was noted before is forgotten.
pub(super) struct Expect<'a> {
    pub(super) packs: &'a [Pack],
    pub(super) bodies: &'a mut Bodies,
}

impl Work for Expect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { packs, bodies } = self;
        bodies.expected.fill(Vec4::ZERO);
        for pack in packs {
            let allowed = L::load(&pack.allowed);
            if !L::zero().lt(allowed).any() {
                continue;
            }
            if pack.still {
                Slip::of::<true>(pack, bodies).expect(pack, allowed, bodies);
            } else {
                Slip::of::<false>(pack, bodies).expect(pack, allowed, bodies);
            }
        }
    }
}
