//! Friction of packs of manifolds, as Coulomb has it.
//!
//! In a heap, pressing tilts a box one way at one contact and back at the next; friction that saw it in between would drag what lies on it, a little
//! in each substep, for ever. And friction tilts boxes, which must not be the last that is done to them. So all of a heap is held before all of it is
//! pressed, against what pressed it in the substep before (in the first one, in a trial); and once more afterwards, against what it is pressed more
//! than that. Positions are held against `s`, how far the two surfaces have slid on each other since the substep began, at the centre of the
//! pressure; and against the turn of one on the other. The impulse is at most `μ Σ λ`, its moment about the normal at most that times the radius of
//! the patch.
//!
//! Pressing moves things after they were held, in a heap again and again. What sticks remembers how far it is from where it was (`late`), and is held
//! against that, too.
//!
//! What lies on a slope and does not slide is `late` by as much as it takes for all of a stack to be held, and gets there over some substeps: by so
//! much it would creep in each step, since nothing is remembered from one step to the next. The substep that is tried before the first one brings it
//! there beforehand, tried a few times over. Each trial takes a share `λ` of what is missing over to the next, ¾ for three plates on each other, so what
//! it changes is prolonged ([`AHEAD`]), as much as a heap bears: there are `λ` below zero, too. What is still missing is the creep of a tower on a
//! slope: three plates at 10° go 0.5 mm in a second, six go 2 mm, until they are put to sleep. A memory from step to step would end it, and would
//! have to be saved and restored with the particles.

use super::block::hold;
use super::bodies::{Bodies, Sliding};
use super::contact::Pack;
use super::turn::{Symmetric, load};
use crate::lanes::{LANES, Lanes, Vector, Work};

/// By how much each trial prolongs what it changes of what is late.
pub(super) const AHEAD: [f32; 3] = [1.5; 3];

/// Holds what slides in packs: before they are pressed, against what pressed them in the substep before; and after that against what presses them
/// more.
pub(super) struct Hold<'a> {
    pub(super) packs: &'a mut [Pack],
    pub(super) after: bool,
    /// By how much that prolongs what it changes of what is `late`: 1 but in a trial.
    pub(super) ahead: f32,
    /// How far what sticks may be from where it was, metres.
    pub(super) most: f32,
    pub(super) bodies: &'a mut Bodies,
}

impl Work for Hold<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { packs, after, ahead, most, bodies } = self;
        let none = L::zero();
        for pack in packs {
            let (sum, used) = (L::load(&pack.sum), L::load(&pack.used));
            let allowed = L::load(&pack.allowed);
            let against = if after { (sum - allowed).max(none) } else { allowed };
            let against = none.lt(L::load(&pack.friction)).and(against);
            let now = hold_pack(pack, against, after.then_some(ahead), most, bodies);
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
    ahead: Option<f32>,
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
    let slid = if ahead.is_some() { slid } else { slid + late };
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
    if let Some(ahead) = ahead {
        // What is left is remembered where it sticks; where it slides, no more than was before.
        let left = late + (slid + stiff.times(f)) * L::splat(ahead);
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&pack.radius));
        let sticks = L::load(&pack.used).lt(L::load(&pack.allowed));
        let left = left.or_else(sticks.and(size.le(L::splat(most))), late);
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
