//! Tangential slip of eight pairs where they touch, and what stops it: what `friction` is reckoned with.

use glam::Vec4;

use super::bodies::{Bodies, WideSlidingBody};
use super::friction::{BACK, FADES};
use super::patch_solve::solve_friction;
use super::turn::{Symmetric, load};
use super::wide_contact::WideContact;
use crate::lanes::{LANES, Lanes, Vector};

/// Response of friction to a slip.
pub(super) struct FrictionResponse<L> {
    /// The displacement and the turn that it gives to the first one, and takes from the second one, if something can.
    a: (Vector<L>, Vector<L>),
    b: Option<(Vector<L>, Vector<L>)>,
    /// Against how much of the pressure it had to act, kg·m.
    pub(super) friction_limit_used: L,
    /// How far it takes the slip back.
    pub(super) back: Vector<L>,
}

/// Tangential slip of eight pairs.
pub(super) struct TangentialSlip<L> {
    a: WideSlidingBody<L>,
    /// `None` where it stays where it is.
    b: Option<WideSlidingBody<L>>,
    n: Vector<L>,
    t: Vector<L>,
    u: Vector<L>,
    /// Where friction acts, from the centres of both.
    arm: Vector<L>,
    other: Vector<L>,
    /// Along `t` and `u`, metres, and about `n`, rad: in this substep, and before.
    pub(super) slid: Vector<L>,
    pub(super) accumulated_slip: Vector<L>,
}

impl<L: Lanes> TangentialSlip<L> {
    #[inline(always)]
    pub(super) fn of<const FIXED: bool>(wide: &WideContact, bodies: &Bodies) -> Self {
        let a = WideSlidingBody::<L>::load(bodies, &wide.a);
        let b = if FIXED { None } else { Some(WideSlidingBody::<L>::load(bodies, &wide.b)) };
        let (n, arm) = (load::<L>(&wide.up), load::<L>(&wide.arm));
        let mut apart = load::<L>(&wide.offset);
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
        let [x, y, z, turned] = &wide.accumulated_slip;
        let accumulated_slip = Vector::new(L::load(x), L::load(y), L::load(z));
        let accumulated_slip =
            Vector::new(accumulated_slip.dot(t), accumulated_slip.dot(u), L::load(turned));
        Self { a, b, n, t, u, arm, other, slid, accumulated_slip }
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
    pub(super) fn answer(
        &self,
        wide: &WideContact,
        slid: Vector<L>,
        against: L,
    ) -> FrictionResponse<L> {
        let Self { a, b, n, t, u, arm, other, .. } = self;
        let axes = (*t, *u, *n);
        let weight = self.weight();
        let (own, stiff) = EffectiveMass::of(&a.inverse_inertia, *arm, axes);
        let along = Vector::new(weight, weight, L::zero()) + stiff.along;
        let mut stiff = Symmetric { along, ..stiff };
        let mut theirs = None;
        if let Some(b) = b {
            let (yields, more) = EffectiveMass::of(&b.inverse_inertia, *other, axes);
            stiff.along += more.along;
            stiff.across += more.across;
            theirs = Some((b.inverse_mass, yields));
        }
        let limit = against * L::load(&wide.friction);
        let (f, much) = solve_friction(
            &stiff,
            slid,
            limit,
            (L::load(&wide.radius), L::load(&wide.torsional_radius)),
        );
        let good = f.length_squared().lt(L::splat(1e30));
        let f = Vector::new(good.and(f.x), good.and(f.y), good.and(f.z));
        let along = *t * f.x + *u * f.y;
        FrictionResponse {
            a: (along * a.inverse_mass, own.turned(f)),
            b: match &theirs {
                None => None,
                Some((inverse_mass, yields)) => Some((along * *inverse_mass, yields.turned(f))),
            },
            friction_limit_used: good.and(against * much),
            back: stiff.times(f),
        }
    }

    /// Moves both by it.
    #[inline(always)]
    pub(super) fn apply(
        &self,
        wide: &WideContact,
        answer: &FrictionResponse<L>,
        bodies: &mut Bodies,
    ) {
        let Self { a, b, .. } = self;
        let (shift, turn) = (a.shift + answer.a.0, a.turn + answer.a.1);
        let first = [shift.with(a.inverse_mass), turn.with(a.depenetration_mark)];
        L::put_records(&mut bodies.rows, &wide.a, first);
        if let (Some(b), Some(answer)) = (b, &answer.b) {
            let (shift, turn) = (b.shift - answer.0, b.turn - answer.1);
            let second = [shift.with(b.inverse_mass), turn.with(b.depenetration_mark)];
            L::put_records(&mut bodies.rows, &wide.b, second);
        }
    }

    /// Notes that contacts are expected to press them with such sums, at the centre of the pressure.
    #[inline(always)]
    pub(super) fn predict_impulse(&self, wide: &WideContact, sum: L, bodies: &mut Bodies) {
        let push = self.n * sum;
        add_predicted(&self.a, &wide.a, self.arm, push, bodies);
        if let Some(b) = &self.b {
            add_predicted(b, &wide.b, self.other, -push, bodies);
        }
    }

    /// How far all that is expected to press will have them slide on each other.
    #[inline(always)]
    pub(super) fn predicted(&self, wide: &WideContact, bodies: &Bodies) -> Vector<L> {
        let (a, turned) = moved_at::<L>(&bodies.predicted, &wide.a, self.arm);
        let (mut past, mut twisted) = (a, turned);
        if self.b.is_some() {
            let (b, other) = moved_at::<L>(&bodies.predicted, &wide.b, self.other);
            (past, twisted) = (a - b, turned - other);
        }
        Vector::new(past.dot(self.t), past.dot(self.u), self.n.dot(twisted))
    }

    /// Remembers what is left of their slip where they stick; where they slide, what was before fades.
    #[inline(always)]
    pub(super) fn keep(&self, wide: &mut WideContact, left: Vector<L>, sticks: L, most: f32) {
        let Self { accumulated_slip, t, u, .. } = self;
        let left = *accumulated_slip + left;
        let size = (left.x * left.x + left.y * left.y).sqrt();
        let size = size.max(left.z.abs() * L::load(&wide.radius));
        let sticks = sticks.and(size.le(L::splat(most / BACK)));
        wide.sticking = sticks.bits();
        let left = left.or_else(sticks, *accumulated_slip * L::splat(FADES));
        // A point does not know how it was turned.
        let is_point = L::load(&wide.radius).lt(L::load(&wide.torsional_radius));
        let twist = is_point.select(L::zero(), left.z);
        let along = *t * left.x + *u * left.y;
        for (to, from) in wide.accumulated_slip.iter_mut().zip([along.x, along.y, along.z, twist]) {
            from.store(to);
        }
    }
}

/// Notes that eight bodies are expected to be pushed so, at an arm from their centres.
#[inline(always)]
fn add_predicted<L: Lanes>(
    body: &WideSlidingBody<L>,
    rows: &[u32; LANES],
    arm: Vector<L>,
    push: Vector<L>,
    bodies: &mut Bodies,
) {
    let [shifts, turns] = pair_of_rows(rows);
    let turn = body.inverse_inertia.times(arm.cross(push));
    let shift = Vector::of(L::rows(&bodies.predicted, &shifts)).0 + push * body.inverse_mass;
    let turn = Vector::of(L::rows(&bodies.predicted, &turns)).0 + turn;
    // Nothing that is not a number may get to others.
    let good = (shift.length_squared() + turn.length_squared()).lt(L::splat(1e30));
    let none = Vector::new(L::zero(), L::zero(), L::zero());
    let (shift, turn) = (shift.or_else(good, none), turn.or_else(good, none));
    L::put_rows(&mut bodies.predicted, &shifts, shift.with(L::zero()));
    L::put_rows(&mut bodies.predicted, &turns, turn.with(L::zero()));
}

/// Effective mass: how a body gives way to impulses along two directions at an arm, and to a moment about a third: the turn that each of them gives
/// it.
struct EffectiveMass<L> {
    t: Vector<L>,
    u: Vector<L>,
    n: Vector<L>,
}

impl<L: Lanes> EffectiveMass<L> {
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

/// Where [`Bodies::predicted`] and [`Bodies::residual`] have the displacements and the turns of eight bodies.
#[inline(always)]
pub(super) fn pair_of_rows(rows: &[u32; LANES]) -> [[u32; LANES]; 2] {
    [rows.map(|row| 2 * row), rows.map(|row| 2 * row + 1)]
}

/// How far what is predicted of eight bodies, or their residual, moves points of these, and how it turns them.
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
