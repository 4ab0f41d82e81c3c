//! Friction of packs of manifolds, as Coulomb has it.
//!
//! In a heap, pressing tilts a box one way at one contact and back at the next; friction that saw it in between would drag what lies on it, a little
//! in each substep, for ever. And friction tilts boxes, which must not be the last that is done to them. So all of a heap is held before all of it is
//! pressed, against what pressed it in the substeps before; and only what has just met, or slides although it is pressed more than that, once more
//! afterwards. Positions are held against `s`, how far the two surfaces have slid on each other since the substep began, at the centre of the
//! pressure; and against the turn of one on the other. The impulse is at most `μ Σ λ`, its moment about the normal at most that times the radius of
//! the patch.
//!
//! # Where it stuck
//!
//! Pressing moves things after they were held, in a heap again and again, and what carries others on a slope is held before they are. What sticks
//! remembers how far it is from where it stuck (`late`), and is held against that, too: so that it stays there, however small the part that each
//! substep leaves. What lies still on a slope is late by as much as it takes for all of a stack to be held. A part of that is taken back in a substep
//! ([`BACK`]), because what is moved back leaves with speed. What slides forgets ([`FADES`]), or friction would go on pulling to where it once stuck.
//! All of it goes from step to step (`memory`).

use super::block::hold;
use super::bodies::{Bodies, Sliding};
use super::contact::Pack;
use super::turn::{Eight, Symmetric, load};
use crate::lanes::{Lanes, Vector, Work};

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
        for pack in packs {
            let allowed = none.lt(L::load(&pack.friction)).and(L::load(&pack.allowed));
            if !after {
                let used = if none.lt(allowed).any() {
                    let slip = Slip::of(pack, bodies);
                    let slid = slip.slid + slip.late * L::splat(BACK);
                    slip.hold(pack, slid, allowed, bodies).0
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
                let (now, back) = slip.hold(pack, slip.slid + slip.late * fresh, needs, bodies);
                (used, granted) = (used + now, granted + needs);
                left += back;
            }
            slip.keep(pack, left, used.lt(granted), most);
            let old = L::load(&pack.allowed);
            let mean = old + (sum - old) * L::splat(NEWS);
            let light = (mean * slip.weight()).le(L::splat(NOTHING));
            let rough = none.lt(L::load(&pack.friction));
            rough.and(light.select(none, mean)).store(&mut pack.allowed);
        }
    }
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

    /// Holds them against so much slip, as far as a sum `against` of the pressure lets it. Returns against how much of that it had to act, and how
    /// far that took them back.
    #[inline(always)]
    fn hold(
        &self,
        pack: &Pack,
        slid: Vector<L>,
        against: L,
        bodies: &mut Bodies,
    ) -> (L, Vector<L>) {
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
        let shift = (a.shift + along * a.inverse_mass, b.shift - along * b.inverse_mass);
        let turn = (
            a.turn + (ita * f.x + iua * f.y + ina * f.z),
            b.turn - (itb * f.x + iub * f.y + inb * f.z),
        );
        let first = [shift.0.with(a.inverse_mass), turn.0.with(a.mark)];
        L::put_records(&mut bodies.rows, &pack.a, first);
        let second = [shift.1.with(b.inverse_mass), turn.1.with(b.mark)];
        L::put_records(&mut bodies.rows, &pack.b, second);
        (good.and(against * much), stiff.times(f))
    }

    /// Remembers what is left of their slip where they stick; where they slide, what was before fades.
    #[inline(always)]
    fn keep(&self, pack: &mut Pack, left: Vector<L>, sticks: L, most: f32) {
        let Self { late, t, u, .. } = self;
        let left = *late + left;
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&pack.radius));
        let sticks = sticks.and(size.le(L::splat(most / BACK)));
        let left = left.or_else(sticks, *late * L::splat(FADES));
        let along = *t * left.x + *u * left.y;
        for (to, from) in pack.late.iter_mut().zip([along.x, along.y, along.z, left.z]) {
            from.store(to);
        }
    }
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
