//! Friction of packs of manifolds, as Coulomb has it.
//!
//! In a heap, pressing tilts a box one way at one contact and back at the next; friction that saw it in between would drag what lies on it, a little
//! in each substep, for ever. And friction tilts boxes, which must not be the last that is done to them. So all of a heap is held before all of it is
//! pressed, against what pressed it in the substeps before; and only what has just met, or slides although it is pressed more than that, once more
//! afterwards. Positions are held against `s`, how far the two surfaces have slid on each other since the substep began, at the centre of the
//! pressure; and against the turn of one on the other. The impulse is at most `μ Σ λ`, its moment about the normal at most that times the radius of
//! the patch.
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

use super::block::hold;
use super::bodies::{Bodies, Sliding};
use super::contact::Pack;
use super::turn::{Eight, Symmetric, load};
use crate::lanes::{LANES, Lanes, Vector, Work};

/// Which part of what is late is taken back in a substep. With all of it a heap of a thousand boxes never rests (7 mm/s), with half of it at 1 to 3
/// mm/s, with a fifth at 0.1; with a twentieth a stack slips on a slope that is nearly too steep, before it is held.
const BACK: f32 = 0.2;
/// What is left of it in a substep in which it slides. A stack on a slope that is nearly too steep slides for a few substeps in the one or other
/// contact, and must not forget by that (with 0.9 it goes on for ever); what really slides has forgotten after some fifty substeps.
const FADES: f32 = 0.97;

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
        let none = L::zero();
        if after {
            bodies.expected.fill(Vec4::ZERO);
        }
        for pack in packs {
            let allowed = none.lt(L::load(&pack.friction)).and(L::load(&pack.allowed));
            if !after {
                let used = if none.lt(allowed).any() {
                    let slip = Slip::of(pack, bodies);
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
                continue;
            }
            let (sum, mut used) = (L::load(&pack.sum), L::load(&pack.used));
            let more = none.lt(L::load(&pack.friction)).and((sum - allowed).max(none));
            if !none.lt(more.max(allowed)).any() {
                // What has let go for a substep takes hold again where it was.
                pack.stuck = 0;
                for late in &mut pack.late {
                    (L::load(late) * L::splat(FADES)).store(late);
                }
                pack.allowed = Eight::default();
                continue;
            }
            let slip = Slip::of(pack, bodies);
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
    }
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
            if L::zero().lt(allowed).any() {
                Slip::of(pack, bodies).expect(pack, allowed, bodies);
            }
        }
    }
}

/// What friction answers to a slip.
struct Answer<L> {
    /// The displacement and the turn that it gives to the first one, and takes from the second one.
    a: (Vector<L>, Vector<L>),
    b: (Vector<L>, Vector<L>),
    /// Against how much of the pressure it had to act, kg·m.
    used: L,
    /// How far it takes the slip back.
    back: Vector<L>,
}

/// How eight have slid on each other.
struct Slip<L> {
    a: Sliding<L>,
    b: Sliding<L>,
    n: Vector<L>,
    t: Vector<L>,
    u: Vector<L>,
    /// Where friction acts, from the centres of both.
    arm: Vector<L>,
    other: Vector<L>,
    /// Along `t` and `u`, metres, and about `n`, rad: in this substep, and before.
    slid: Vector<L>,
    late: Vector<L>,
}

impl<L: Lanes> Slip<L> {
    #[inline(always)]
    fn of(pack: &Pack, bodies: &Bodies) -> Self {
        let (a, b) = (Sliding::<L>::load(bodies, &pack.a), Sliding::<L>::load(bodies, &pack.b));
        let (n, arm) = (load::<L>(&pack.up), load::<L>(&pack.arm));
        let other = arm - (b.centre + load::<L>(&pack.offset) - a.centre);
        let (t, u) = tangents(n);
        let slid = a.moved(arm) - b.moved(other);
        let twist = n.dot(a.spin + a.turn - b.spin - b.turn);
        let slid = Vector::new(slid.dot(t), slid.dot(u), twist);
        let [x, y, z, turned] = &pack.late;
        let late = Vector::new(L::load(x), L::load(y), L::load(z));
        let late = Vector::new(late.dot(t), late.dot(u), L::load(turned));
        Self { a, b, n, t, u, arm, other, slid, late }
    }

    /// How far an impulse moves them apart, 1/kg.
    #[inline(always)]
    fn weight(&self) -> L {
        self.a.inverse_mass + self.b.inverse_mass
    }

    /// What holds them against so much slip, as far as a sum `against` of the pressure lets it.
    #[inline(always)]
    fn answer(&self, pack: &Pack, slid: Vector<L>, against: L) -> Answer<L> {
        let Self { a, b, n, t, u, arm, other, .. } = self;
        let (n, t, u) = (*n, *t, *u);
        let weight = self.weight();
        let (ta, tb) = (arm.cross(t), other.cross(t));
        let (ua, ub) = (arm.cross(u), other.cross(u));
        let (ita, itb) = (a.inverse_inertia.times(ta), b.inverse_inertia.times(tb));
        let (iua, iub) = (a.inverse_inertia.times(ua), b.inverse_inertia.times(ub));
        let (ina, inb) = (a.inverse_inertia.times(n), b.inverse_inertia.times(n));
        let stiff = Symmetric {
            along: Vector::new(
                weight + ta.dot(ita) + tb.dot(itb),
                weight + ua.dot(iua) + ub.dot(iub),
                n.dot(ina) + n.dot(inb),
            ),
            across: Vector::new(
                ta.dot(iua) + tb.dot(iub),
                ta.dot(ina) + tb.dot(inb),
                ua.dot(ina) + ub.dot(inb),
            ),
        };
        let limit = against * L::load(&pack.friction);
        let (f, much) = hold(&stiff, slid, limit, L::load(&pack.radius));
        let good = f.length_squared().lt(L::splat(1e30));
        let f = Vector::new(good.and(f.x), good.and(f.y), good.and(f.z));
        let along = t * f.x + u * f.y;
        Answer {
            a: (along * a.inverse_mass, ita * f.x + iua * f.y + ina * f.z),
            b: (along * b.inverse_mass, itb * f.x + iub * f.y + inb * f.z),
            used: good.and(against * much),
            back: stiff.times(f),
        }
    }

    /// Moves both by it.
    #[inline(always)]
    fn apply(&self, pack: &Pack, answer: &Answer<L>, bodies: &mut Bodies) {
        let Self { a, b, .. } = self;
        let (shift, turn) = (a.shift + answer.a.0, a.turn + answer.a.1);
        let first = [shift.with(a.inverse_mass), turn.with(a.mark)];
        L::put_records(&mut bodies.rows, &pack.a, first);
        let (shift, turn) = (b.shift - answer.b.0, b.turn - answer.b.1);
        let second = [shift.with(b.inverse_mass), turn.with(b.mark)];
        L::put_records(&mut bodies.rows, &pack.b, second);
    }

    /// Notes that contacts are expected to press them with such sums, at the centre of the pressure.
    #[inline(always)]
    fn expect(&self, pack: &Pack, sum: L, bodies: &mut Bodies) {
        let push = self.n * sum;
        let sides = [(&pack.a, &self.a, self.arm, push), (&pack.b, &self.b, self.other, -push)];
        for (rows, body, arm, push) in sides {
            let [shifts, turns] = pair_of_rows(rows);
            let turn = body.inverse_inertia.times(arm.cross(push));
            let shift = Vector::of(L::rows(&bodies.expected, &shifts)).0 + push * body.inverse_mass;
            let turn = Vector::of(L::rows(&bodies.expected, &turns)).0 + turn;
            // Nothing that is not a number may get to others.
            let good = (shift.length_squared() + turn.length_squared()).lt(L::splat(1e30));
            let none = Vector::new(L::zero(), L::zero(), L::zero());
            let (shift, turn) = (shift.or_else(good, none), turn.or_else(good, none));
            L::put_rows(&mut bodies.expected, &shifts, shift.with(L::zero()));
            L::put_rows(&mut bodies.expected, &turns, turn.with(L::zero()));
        }
    }

    /// How far all that is expected to press will have them slide on each other.
    #[inline(always)]
    fn expected(&self, pack: &Pack, bodies: &Bodies) -> Vector<L> {
        let (a, turned) = moved_at::<L>(&bodies.expected, &pack.a, self.arm);
        let (b, other) = moved_at::<L>(&bodies.expected, &pack.b, self.other);
        let past = a - b;
        Vector::new(past.dot(self.t), past.dot(self.u), self.n.dot(turned - other))
    }

    /// Remembers what is left of their slip where they stick; where they slide, what was before fades.
    #[inline(always)]
    fn keep(&self, pack: &mut Pack, left: Vector<L>, sticks: L, most: f32) {
        let Self { late, t, u, .. } = self;
        let left = *late + left;
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&pack.radius));
        let sticks = sticks.and(size.le(L::splat(most / BACK)));
        pack.stuck = sticks.bits();
        let left = left.or_else(sticks, *late * L::splat(FADES));
        let along = *t * left.x + *u * left.y;
        for (to, from) in pack.late.iter_mut().zip([along.x, along.y, along.z, left.z]) {
            from.store(to);
        }
    }
}

/// Where [`Bodies::expected`] and [`Bodies::lost`] have the displacements and the turns of eight bodies.
#[inline(always)]
pub(super) fn pair_of_rows(rows: &[u32; LANES]) -> [[u32; LANES]; 2] {
    [rows.map(|row| 2 * row), rows.map(|row| 2 * row + 1)]
}

/// How far what is expected of eight bodies, or lost of them, moves points of these, and how it turns them.
#[inline(always)]
pub(super) fn moved_at<L: Lanes>(
    of: &[Vec4],
    rows: &[u32; LANES],
    arm: Vector<L>,
) -> (Vector<L>, Vector<L>) {
    let [shifts, turns] = pair_of_rows(rows);
    let turn = Vector::of(L::rows(of, &turns)).0;
    let shift = Vector::of(L::rows(of, &shifts)).0;
    (shift + turn.cross(arm), turn)
}

/// Two unit vectors across a third and each other (Duff et al., *Building an Orthonormal Basis, Revisited*, 2017).
#[inline(always)]
pub(super) fn tangents<L: Lanes>(n: Vector<L>) -> (Vector<L>, Vector<L>) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let sign = n.z.lt(none).select(-one, one);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    let t = Vector::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x);
    (t, Vector::new(b, sign + n.y * n.y * a, -n.y))
}
