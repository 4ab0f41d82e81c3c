//! Friction of packs of manifolds, as Coulomb has it.
//!
//! In a heap, pressing tilts a box one way at one contact and back at the next; friction that saw it in between would drag what lies on it, a little
//! in each substep, for ever. And friction tilts boxes, which must not be the last that is done to them. So all of a heap is held before all of it is
//! pressed, against what pressed it in the substep before (in the first one, in a trial); and once more afterwards, against what it is pressed more
//! than that. Positions are held against `s`, how far the two surfaces have slid on each other since the substep began, at the centre of the
//! pressure; and against the turn of one on the other. The impulse is at most `μ Σ λ`, its moment about the normal at most that times the radius of
//! the patch.
//!
//! # Where it stuck
//!
//! Pressing moves things after they were held, in a heap again and again, and what carries others on a slope is held before they are. What sticks remembers
//! how far it is from where it stuck (`late`), and is held against that, too: so that it stays there, however small the part that each substep leaves. What lies
//! still on a slope is late by as much as it takes for all of a stack to be held. A part of that is taken back in a substep ([`BACK`]), because what is moved back leaves
//! with speed. What slides forgets ([`FADES`]), or friction would go on pulling to where it once stuck. All of it goes from step to step (`memory`).

use super::block::hold;
use super::bodies::{Bodies, Sliding};
use super::contact::Pack;
use super::turn::{Symmetric, load};
use crate::lanes::{LANES, Lanes, Vector, Work};

/// Which part of what is late is taken back in a substep. With all of it a heap of a thousand boxes never rests (7 mm/s), with half of it at 1 to 3 mm/s, with a fifth at 0.1; with a
/// twentieth a stack slips on a slope that is nearly too steep, before it is held.
const BACK: f32 = 0.2;
/// What is left of it in a substep in which it slides. A stack on a slope that is nearly too steep slides for a few substeps in the one or other contact, and
/// must not forget by that (with 0.9 it goes on for ever); what really slides has forgotten after some fifty substeps.
const FADES: f32 = 0.97;

/// Holds what slides in packs: before they are pressed, against what pressed them in the substep before; and after that against what presses them
/// more.
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
            let (sum, used) = (L::load(&pack.sum), L::load(&pack.used));
            let allowed = L::load(&pack.allowed);
            let against = if after { (sum - allowed).max(none) } else { allowed };
            let against = none.lt(L::load(&pack.friction)).and(against);
            let now = hold_pack(pack, against, after, most, bodies);
            if after {
                // What was too much is taken off next time.
                let used = used + now;
                (sum - (used - sum).max(none)).max(none).store(&mut pack.allowed);
            } else {
                now.store(&mut pack.used);
            }
        }
    }
}

/// Returns against how much of the sum it had to act.
#[inline(always)]
fn hold_pack<L: Lanes>(
    pack: &mut Pack,
    against: L,
    after: bool,
    most: f32,
    bodies: &mut Bodies,
) -> L {
    let none = L::zero();
    if !none.lt(against.max(L::load(&pack.allowed))).any() {
        pack.late = [[0.0; LANES]; 4];
        return none;
    }
    let (mut a, mut b) = (Sliding::<L>::load(bodies, &pack.a), Sliding::<L>::load(bodies, &pack.b));
    let (n, arm) = (load::<L>(&pack.up), load::<L>(&pack.arm));
    // The same point from the other one's centre.
    let other = arm - (b.centre + load::<L>(&pack.offset) - a.centre);
    let (t, u) = tangents(n);
    let weight = a.inverse_mass + b.inverse_mass;
    let slid = a.moved(arm) - b.moved(other);
    let twist = n.dot(a.spin + a.turn - b.spin - b.turn);
    let slid = Vector::new(slid.dot(t), slid.dot(u), twist);
    let late = Vector::new(L::load(&pack.late[0]), L::load(&pack.late[1]), L::load(&pack.late[2]));
    let late = Vector::new(late.dot(t), late.dot(u), L::load(&pack.late[3]));
    let slid = if after { slid } else { slid + late * L::splat(BACK) };
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
    if after {
        // What is left is remembered where it sticks; where it slides, what was before fades.
        let left = late + (slid + stiff.times(f));
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&pack.radius));
        let sticks = L::load(&pack.used).lt(L::load(&pack.allowed));
        let bound = sticks.and(size.le(L::splat(most / BACK)));
        let left = left.or_else(bound, late * L::splat(FADES));
        let along = t * left.x + u * left.y;
        for (to, from) in pack.late.iter_mut().zip([along.x, along.y, along.z, left.z]) {
            from.store(to);
        }
    }
    let f = Vector::new(good.and(f.x), good.and(f.y), good.and(f.z));
    let along = t * f.x + u * f.y;
    a.shift += along * a.inverse_mass;
    b.shift -= along * b.inverse_mass;
    a.turn += ita * f.x + iua * f.y + ina * f.z;
    b.turn -= itb * f.x + iub * f.y + inb * f.z;
    L::put_records(&mut bodies.rows, &pack.a, [a.shift.with(a.inverse_mass), a.turn.with(a.mark)]);
    L::put_records(&mut bodies.rows, &pack.b, [b.shift.with(b.inverse_mass), b.turn.with(b.mark)]);
    good.and(against * much)
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
