//! Friction solve of wide contacts, by Coulomb.
//!
//! In a heap, pressing tilts a box one way at one contact and back at the next; friction that saw it in between would drag what lies on it, a little
//! in each substep, for ever. And friction tilts boxes, which must not be the last that is done to them. So all of a heap is held before all of it is
//! pressed, against what pressed it in the substeps before; and only what has just met, or slides although it is pressed more than that, once more
//! afterwards. Positions are held against `s`, how far the two surfaces have slid on each other since the substep began, at the centre of the
//! pressure; and against the turn of one on the other. The impulse is at most `μ Σ λ`, its moment about the normal at most that times the radius of
//! the patch; of what is a point, a hundredth of its size (`wide_contact::TORSIONAL_RADIUS`), without accumulated slip.
//!
//! # What is to come
//!
//! Before they are pressed, things have fallen by `g h²`, and what is wedged between two slopes has slid on both by nearly that: more than friction
//! may hold. It would act against the fall with all it has, where the two slopes together let nothing slide, and leave alone what really creeps: a
//! wedged box crept at a quarter of a millimetre a second for ever, and in a heap of a thousand one or the other fell of it, for minutes. So where
//! friction would slip, it acts against what will be left when all have pressed as they did in the substeps before (`Bodies::predicted`). Where it
//! sticks it does not: pressures come and go in a heap, and would shake what lies still (a thousand boxes then go on at 1 mm/s).
//!
//! # Where it stuck
//!
//! Pressing moves things after they were held, in a heap again and again, and what carries others on a slope is held before they are. What sticks
//! remembers how far it is from where it stuck (`accumulated_slip`), and is held against that, too: so that it stays there, however small the part
//! that each substep leaves. What lies still on a slope has accumulated as much slip as it takes for all of a stack to be held. A part of that is
//! taken back in a substep ([`BACK`]), because what is moved back leaves with speed. What slides forgets ([`FADES`]), or friction would go on pulling
//! to where it once stuck. All of it goes from step to step (`contact_cache`).

use glam::Vec4;

use super::bodies::Bodies;
use super::tangential_slip::TangentialSlip;
use super::turn::LaneArray;
use super::wide_contact::WideContact;
use crate::lanes::{Lanes, Work};

/// Which part of the accumulated slip is taken back in a substep. With all of it a heap of a thousand boxes never rests (7 mm/s), with half of it at
/// 1 to 3 mm/s, with a fifth at 0.1; with a twentieth a stack slips on a slope that is nearly too steep, before it is held.
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

/// Solves friction of wide contacts: before their normals are solved, against what pressed them in the substeps before; and after that, where it is
/// needed, against what presses them more.
pub(super) struct FrictionSolve<'a> {
    pub(super) wide_contacts: &'a mut [WideContact],
    pub(super) after: bool,
    /// How far what sticks may be taken back in a substep, metres.
    pub(super) max_correction: f32,
    pub(super) bodies: &'a mut Bodies,
}

impl Work for FrictionSolve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { wide_contacts, after, max_correction, bodies } = self;
        if after {
            bodies.predicted.fill(Vec4::ZERO);
        }
        for wide in wide_contacts {
            match (after, wide.fixed) {
                (false, false) => friction_before::<L, false>(wide, bodies),
                (false, true) => friction_before::<L, true>(wide, bodies),
                (true, false) => friction_after::<L, false>(wide, bodies, max_correction),
                (true, true) => friction_after::<L, true>(wide, bodies, max_correction),
            }
        }
    }
}
/// Against what pressed it in the substeps before. `FIXED` is what the wide contact says of that, as in `normal_solve`.
#[inline(always)]
fn friction_before<L: Lanes, const FIXED: bool>(wide: &mut WideContact, bodies: &mut Bodies) {
    let none = L::zero();
    let friction_limit = none.lt(L::load(&wide.friction)).and(L::load(&wide.friction_limit));
    let friction_limit_used = if none.lt(friction_limit).any() {
        let slip = TangentialSlip::of::<FIXED>(wide, bodies);
        let slid = slip.slid + slip.accumulated_slip * L::splat(BACK);
        let answer = slip.answer(wide, slid, friction_limit);
        let slips = none.lt(friction_limit).and(friction_limit.le(answer.friction_limit_used));
        let answer = if slips.any() {
            let predicted = slid + slip.predicted(wide, bodies);
            slip.answer(wide, predicted.or_else(slips, slid), friction_limit)
        } else {
            answer
        };
        slip.apply(wide, &answer, bodies);
        answer.friction_limit_used
    } else {
        none
    };
    friction_limit_used.store(&mut wide.friction_limit_used);
}

/// Against what pressed it more than that, and what the anchor is to keep.
#[inline(always)]
fn friction_after<L: Lanes, const FIXED: bool>(
    wide: &mut WideContact,
    bodies: &mut Bodies,
    max_correction: f32,
) {
    let none = L::zero();
    let friction_limit = none.lt(L::load(&wide.friction)).and(L::load(&wide.friction_limit));
    let (sum, mut friction_limit_used) = (L::load(&wide.sum), L::load(&wide.friction_limit_used));
    let more = none.lt(L::load(&wide.friction)).and((sum - friction_limit).max(none));
    if !none.lt(more.max(friction_limit)).any() {
        // What has let go for a substep takes hold again where it was.
        wide.sticking = 0;
        for accumulated_slip in &mut wide.accumulated_slip {
            (L::load(accumulated_slip) * L::splat(FADES)).store(accumulated_slip);
        }
        wide.friction_limit = LaneArray::default();
        return;
    }
    let slip = TangentialSlip::of::<FIXED>(wide, bodies);
    let (mut left, mut granted) = (slip.slid, friction_limit);
    let needs = friction_limit_used.lt(friction_limit).select(none, more);
    let needs = (friction_limit * L::splat(MORE)).lt(needs).and(needs);
    if none.lt(needs).any() {
        // Who was not held before is held against the accumulated slip here.
        let fresh = friction_limit.le(none).and(L::splat(BACK));
        let answer = slip.answer(wide, slip.slid + slip.accumulated_slip * fresh, needs);
        slip.apply(wide, &answer, bodies);
        (friction_limit_used, granted) =
            (friction_limit_used + answer.friction_limit_used, granted + needs);
        left += answer.back;
    }
    slip.keep(wide, left, friction_limit_used.lt(granted), max_correction);
    let old = L::load(&wide.friction_limit);
    let mean = old + (sum - old) * L::splat(NEWS);
    let light = (mean * slip.weight()).le(L::splat(NOTHING));
    let rough = none.lt(L::load(&wide.friction));
    let friction_limit = rough.and(light.select(none, mean));
    friction_limit.store(&mut wide.friction_limit);
    slip.predict_impulse(wide, friction_limit, bodies);
}

/// Predicts the impulses of wide contacts in the next substep, where nothing has pressed yet: all that was noted before is forgotten.
pub(super) struct PredictImpulse<'a> {
    pub(super) wide_contacts: &'a [WideContact],
    pub(super) bodies: &'a mut Bodies,
}

impl Work for PredictImpulse<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { wide_contacts, bodies } = self;
        bodies.predicted.fill(Vec4::ZERO);
        for wide in wide_contacts {
            let friction_limit = L::load(&wide.friction_limit);
            if !L::zero().lt(friction_limit).any() {
                continue;
            }
            if wide.fixed {
                TangentialSlip::of::<true>(wide, bodies).predict_impulse(
                    wide,
                    friction_limit,
                    bodies,
                );
            } else {
                TangentialSlip::of::<false>(wide, bodies).predict_impulse(
                    wide,
                    friction_limit,
                    bodies,
                );
            }
        }
    }
}
