//! How eight pairs have slid on each other where they touch, and what stops that: what friction (`hold`) is reckoned with.

use glam::Vec4;

use super::block::hold;
use super::bodies::{Bodies, Sliding};
use super::hold::{BACK, FADES};
use super::pack::Pack;
use super::turn::{Symmetric, load};
use crate::lanes::{LANES, Lanes, Vector};

/// What friction answers to a slip.
pub(super) struct Answer<L> {
    /// The displacement and the turn that it gives to the first one, and takes from the second one, if something can.
    a: (Vector<L>, Vector<L>),
    b: Option<(Vector<L>, Vector<L>)>,
    /// Against how much of the pressure it had to act, kg·m.
    pub(super) used: L,
    /// How far it takes the slip back.
    pub(super) back: Vector<L>,
}

/// How eight have slid on each other.
pub(super) struct Slip<L> {
    a: Sliding<L>,
    /// `None` where it stays where it is.
    b: Option<Sliding<L>>,
    n: Vector<L>,
    t: Vector<L>,
    u: Vector<L>,
    /// Where friction acts, from the centres of both.
    arm: Vector<L>,
    other: Vector<L>,
    /// Along `t` and `u`, metres, and about `n`, rad: in this substep, and before.
    pub(super) slid: Vector<L>,
    pub(super) late: Vector<L>,
}

impl<L: Lanes> Slip<L> {
    #[inline(always)]
    pub(super) fn of<const STILL: bool>(pack: &Pack, bodies: &Bodies) -> Self {
        let a = Sliding::<L>::load(bodies, &pack.a);
        let b = if STILL { None } else { Some(Sliding::<L>::load(bodies, &pack.b)) };
        let (n, arm) = (load::<L>(&pack.up), load::<L>(&pack.arm));
        let mut apart = load::<L>(&pack.offset);
        if let Some(b) = &b {
            apart = b.centre + apart;
        }
        let other = arm - (apart - a.centre);
        let (t, u) = tangents(n);
        let (mut slid, mut turned) = (a.moved(arm), a.spin + a.turn);
        if let Some(b) = &b {
            slid -= b.moved(other);
            turned = turned - b.spin - b.turn;
        }
        let twist = n.dot(turned);
        let slid = Vector::new(slid.dot(t), slid.dot(u), twist);
        let [x, y, z, turned] = &pack.late;
        let late = Vector::new(L::load(x), L::load(y), L::load(z));
        let late = Vector::new(late.dot(t), late.dot(u), L::load(turned));
        Self { a, b, n, t, u, arm, other, slid, late }
    }

    /// How far an impulse moves them apart, 1/kg.
    #[inline(always)]
    pub(super) fn weight(&self) -> L {
        match &self.b {
            None => self.a.inverse_mass,
            Some(b) => self.a.inverse_mass + b.inverse_mass,
        }
    }

    /// What holds them against so much slip, as far as a sum `against` of the pressure lets it.
    #[inline(always)]
    #[allow(clippy::manual_map, reason = "a closure is not made for the processor that it runs on")]
    pub(super) fn answer(&self, pack: &Pack, slid: Vector<L>, against: L) -> Answer<L> {
        let Self { a, b, n, t, u, arm, other, .. } = self;
        let axes = (*t, *u, *n);
        let weight = self.weight();
        let (own, stiff) = Yields::of(&a.inverse_inertia, *arm, axes);
        let along = Vector::new(weight, weight, L::zero()) + stiff.along;
        let mut stiff = Symmetric { along, ..stiff };
        let mut theirs = None;
        if let Some(b) = b {
            let (yields, more) = Yields::of(&b.inverse_inertia, *other, axes);
            stiff.along += more.along;
            stiff.across += more.across;
            theirs = Some((b.inverse_mass, yields));
        }
        let limit = against * L::load(&pack.friction);
        let (f, much) = hold(&stiff, slid, limit, (L::load(&pack.radius), L::load(&pack.blunt)));
        let good = f.length_squared().lt(L::splat(1e30));
        let f = Vector::new(good.and(f.x), good.and(f.y), good.and(f.z));
        let along = *t * f.x + *u * f.y;
        Answer {
            a: (along * a.inverse_mass, own.turned(f)),
            b: match &theirs {
                None => None,
                Some((inverse_mass, yields)) => Some((along * *inverse_mass, yields.turned(f))),
            },
            used: good.and(against * much),
            back: stiff.times(f),
        }
    }

    /// Moves both by it.
    #[inline(always)]
    pub(super) fn apply(&self, pack: &Pack, answer: &Answer<L>, bodies: &mut Bodies) {
        let Self { a, b, .. } = self;
        let (shift, turn) = (a.shift + answer.a.0, a.turn + answer.a.1);
        let first = [shift.with(a.inverse_mass), turn.with(a.mark)];
        L::put_records(&mut bodies.rows, &pack.a, first);
        if let (Some(b), Some(answer)) = (b, &answer.b) {
            let (shift, turn) = (b.shift - answer.0, b.turn - answer.1);
            let second = [shift.with(b.inverse_mass), turn.with(b.mark)];
            L::put_records(&mut bodies.rows, &pack.b, second);
        }
    }

    /// Notes that contacts are expected to press them with such sums, at the centre of the pressure.
    #[inline(always)]
    pub(super) fn expect(&self, pack: &Pack, sum: L, bodies: &mut Bodies) {
        let push = self.n * sum;
        add_expected(&self.a, &pack.a, self.arm, push, bodies);
        if let Some(b) = &self.b {
            add_expected(b, &pack.b, self.other, -push, bodies);
        }
    }

    /// How far all that is expected to press will have them slide on each other.
    #[inline(always)]
    pub(super) fn expected(&self, pack: &Pack, bodies: &Bodies) -> Vector<L> {
        let (a, turned) = moved_at::<L>(&bodies.expected, &pack.a, self.arm);
        let (mut past, mut twisted) = (a, turned);
        if self.b.is_some() {
            let (b, other) = moved_at::<L>(&bodies.expected, &pack.b, self.other);
            (past, twisted) = (a - b, turned - other);
        }
        Vector::new(past.dot(self.t), past.dot(self.u), self.n.dot(twisted))
    }

    /// Remembers what is left of their slip where they stick; where they slide, what was before fades.
    #[inline(always)]
    pub(super) fn keep(&self, pack: &mut Pack, left: Vector<L>, sticks: L, most: f32) {
        let Self { late, t, u, .. } = self;
        let left = *late + left;
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&pack.radius));
        let sticks = sticks.and(size.le(L::splat(most / BACK)));
        pack.stuck = sticks.bits();
        let left = left.or_else(sticks, *late * L::splat(FADES));
        // A point does not know how it was turned.
        let is_point = L::load(&pack.radius).lt(L::load(&pack.blunt));
        let twist = is_point.select(L::zero(), left.z);
        let along = *t * left.x + *u * left.y;
        for (to, from) in pack.late.iter_mut().zip([along.x, along.y, along.z, twist]) {
            from.store(to);
        }
    }
}

/// Notes that eight bodies are expected to be pushed so, at an arm from their centres.
#[inline(always)]
fn add_expected<L: Lanes>(
    body: &Sliding<L>,
    rows: &[u32; LANES],
    arm: Vector<L>,
    push: Vector<L>,
    bodies: &mut Bodies,
) {
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

/// How a body gives way to impulses along two directions at an arm, and to a moment about a third: the turn that each of them gives it.
struct Yields<L> {
    t: Vector<L>,
    u: Vector<L>,
    n: Vector<L>,
}

impl<L: Lanes> Yields<L> {
    /// And how far the three move it along each other; its centre stays.
    #[inline(always)]
    fn of(
        inverse_inertia: &Symmetric<L>,
        arm: Vector<L>,
        (t, u, n): (Vector<L>, Vector<L>, Vector<L>),
    ) -> (Self, Symmetric<L>) {
        let (t, u) = (arm.cross(t), arm.cross(u));
        let (by_t, by_u) = (inverse_inertia.times(t), inverse_inertia.times(u));
        let by_n = inverse_inertia.times(n);
        let along = Vector::new(t.dot(by_t), u.dot(by_u), n.dot(by_n));
        let across = Vector::new(t.dot(by_u), t.dot(by_n), u.dot(by_n));
        (Self { t: by_t, u: by_u, n: by_n }, Symmetric { along, across })
    }

    #[inline(always)]
    fn turned(&self, f: Vector<L>) -> Vector<L> {
        self.t * f.x + self.u * f.y + self.n * f.z
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
