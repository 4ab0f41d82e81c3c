//! Rigid states: a body collider whose particles are constrained only by its own rods is integrated as one rigid body, and its particles follow.
//!
//! Rigid states are selected when a step begins (`rigid_islands`). Each is then read from its particles, goes through the substeps as a centre, a rotation, a
//! velocity and an angular momentum, eight in lanes, and its particles are written from that. The particles remain the state from step to step.
//!
//! # The free body
//!
//! The effect of rods on particles that Verlet moves, each corrected along its direction when the substep began (SHAKE), has a closed form for all rods at
//! once: the discrete Moser–Veselov equations, as in `rigid/verlet.rs` of the crate. With `r` the arms when the substep began, `Δ` the rotation through the
//! substep and `Σ m r × v` the angular momentum, as Verlet keeps it,
//!
//! ```text
//! h L = Σ m r × Δ r        q = q̄ + Δ r        v = v̄ + (Δ - 1) r / h
//! ```
//!
//! `L` of the particles is the same number at both ends of a substep, so that reading and writing them changes nothing but round-off. With the unit
//! quaternion `(v, w)` of `Δ`, and `I` the inertia,
//!
//! ```text
//! h L = 2 (w I v + v × I v)        w = √(1 - v²)
//! ```
//!
//! which Newton's method solves in body axes, where `I` is constant, from its first two terms in a step or two. Momenta are kept, whatever error that leaves;
//! energy oscillates within bounds; the order is 2.
//!
//! # Contacts
//!
//! Contacts shift and turn a pose, which is an impulse and its moment: `h L` grows by `I φ`, and the rotation is solved again from where the substep began.
//! That is where rods would have put the particles (`pose`), without a sum over them.
//!
//! # Precision
//!
//! What `f32` drops of a sum over substeps is kept beside centre, rotation and velocity: the turn in a substep is a few thousandths of a radian, and rounded
//! to the digits of a quaternion, forty substeps of sixty ticks would lose more than a rotation about the middle axis tolerates. Sums over particles are
//! taken about their mean, and the error of that mean is summed up once more: rounded weights would otherwise lose or gain the same share in every step.
//! Where particles are written, the momentum and angular momentum after rounding are summed up as they will be read; the difference is stored as the rounding
//! of their velocities, and is read from there.

use glam::{Vec3, Vec4};

use super::bodies::{Bodies, ROTATION, from_row};
use super::groups::{BodyGroup, Slot, WideMass};
use super::pose::Gathered;
use super::rigid_rotation::{Rotation, WideRotation, load_four, store_four};
use super::swept_bounds::WideSweptBounds;
use super::turn::{LaneArray, Matrix, Symmetric, load, store, zero};
use crate::integrate::loss;
use crate::lanes::{FIELDS, LANES, Lanes, Vector, Work, get, kernel};

/// Limit of `v²` of the quaternion of a turn: a quarter of a turn in a substep. Faster bodies turn by that.
const MOST: f32 = 0.5;
/// The same limit when a step begins, half a radian: faster bodies go as particles.
const FAST: f32 = 0.061;
/// Bound of a squared relative Newton step: such a step leaves an error of its square, which is round-off.
const CONVERGED: f32 = 1e-7;
/// `v²` up to which the first two terms are exact in `f32`, and the share of the angular momentum that the second one may have for that: turns of two
/// hundredths of a radian in a substep.
const SLOW: f32 = 1e-4;
/// The most Newton steps.
const STEPS: u32 = 6;
/// Distance of a particle from its place that is allowed beside the tolerance of its rods, as a share of the reach of the body.
const MISPLACED: f32 = 1e-3;

/// Eight rigid states. Fields of other lanes are undefined.
#[derive(Clone, Debug, Default)]
pub(super) struct WideRigidState {
    /// A bit for each lane that is a rigid state.
    pub(super) lanes: u32,
    /// Centre when the step began.
    began: [LaneArray; 3],
    /// Centre, from the origin, metres; and what `f32` has dropped of it in this step.
    centre: [LaneArray; 3],
    remainder: [LaneArray; 3],
    /// Mean velocity of the last substep, m/s, and what `f32` has dropped of it.
    velocity: [LaneArray; 3],
    rounding: [LaneArray; 3],
    /// Angular momentum about the centre as Verlet keeps it, kg·m²/s.
    momentum: [LaneArray; 3],
    pub(super) rotation: WideRotation,
    /// Centre and rotation when the substep began.
    start_centre: [LaneArray; 3],
    start_rotation: WideRotation,
    /// Turn in the last substep, in body axes: a quaternion.
    turn: [LaneArray; 4],
    /// Length of the last substep, seconds.
    pub(super) lag: LaneArray,
    /// Damping of its particles, 1/s.
    pub(super) rate: LaneArray,
    /// Damping exponents of the next substep and of those after it, and the shares of the velocities that are lost.
    exponents: [LaneArray; 2],
    lost: [LaneArray; 2],
}

impl WideRigidState {
    /// Centre of a lane from the origin, metres, and its rotation: a quaternion of nearly unit length.
    pub(super) fn pose(&self, lane: usize) -> (Vec3, Vec4) {
        let [x, y, z, w] = &self.rotation.whole;
        let turn = Vec4::new(x[lane], y[lane], z[lane], w[lane]);
        (get(&self.centre, lane) + get(&self.remainder, lane), turn)
    }

    /// Displacement of the centre of a lane in this step, metres, and the time over which its velocity is a mean, seconds.
    pub(super) fn gone(&self, lane: usize) -> (Vec3, f32) {
        (get(&self.centre, lane) - get(&self.began, lane), self.lag[lane])
    }

    /// The velocity of a lane, m/s.
    pub(super) fn velocity(&self, lane: usize) -> Vec3 {
        get(&self.velocity, lane)
    }

    /// The angular momentum of a lane, kg·m²/s.
    pub(super) fn momentum(&self, lane: usize) -> Vec3 {
        get(&self.momentum, lane)
    }

    /// Computes the shares of the velocities that are lost over substeps of `h` seconds in air of the damping `air`, 1/s.
    pub(super) fn note_losses(&mut self, air: f32, h: f32) {
        for (which, lags) in [self.lag, [h; LANES]].iter().enumerate() {
            let (exponents, lost) = (&mut self.exponents[which], &mut self.lost[which]);
            for lane in 0..LANES {
                let exponent = (self.rate[lane] + (air + 0.0)) * ((lags[lane] + h) * 0.5);
                if exponent.to_bits() != exponents[lane].to_bits() {
                    (exponents[lane], lost[lane]) = (exponent, loss(exponent));
                }
            }
        }
    }
}

/// Turn of a body in a substep, in its own axes, from `momentum`, its angular momentum there times `h`.
#[inline(always)]
fn turn_of<L: Lanes>(
    momentum: Vector<L>,
    inertia: &Symmetric<L>,
    inverse: &Symmetric<L>,
) -> (Vector<L>, L) {
    let (one, two, half) = (L::splat(1.0), L::splat(2.0), L::splat(0.5));
    let first = limited(inverse.times(momentum) * half);
    let w = (one - first.length_squared()).sqrt();
    let gyroscopic = first.cross(inertia.times(first)) * two;
    let mut v = limited(inverse.times(momentum - gyroscopic) * (half / w));
    let mut w = (one - v.length_squared()).sqrt();
    // For slow bodies, and for those with equal moments of inertia, two terms are exact: the error is the square of what they leave out.
    let small = first
        .length_squared()
        .le(L::splat(SLOW))
        .and(gyroscopic.length_squared().le(momentum.length_squared() * L::splat(SLOW * SLOW)));
    let mut going = small.select(L::zero(), L::zero().same(L::zero()));
    let [x, y, z] = columns(inertia);
    for _ in 0..STEPS {
        if !going.any() {
            break;
        }
        let spun = inertia.times(v);
        let missing = momentum * half - (spun * w + v.cross(spun));
        let along = spun * (one / w);
        let none = L::zero();
        let matrix = Matrix {
            x: x * w + v.cross(x) - Vector::new(none, spun.z, -spun.y) - along * v.x,
            y: y * w + v.cross(y) - Vector::new(-spun.z, none, spun.x) - along * v.y,
            z: z * w + v.cross(z) - Vector::new(spun.y, -spun.x, none) - along * v.z,
        };
        let further = matrix.solve(missing);
        let next = v + further;
        let square = next.length_squared();
        // A lane that has converged, or would leave the range, keeps its value: the other lanes must not matter.
        let good = going.and(square.le(L::splat(MOST)));
        v = next.or_else(good, v);
        w = good.select((one - square).sqrt(), w);
        let done = further.length_squared().le(square * L::splat(CONVERGED));
        going = good.and(done.select(L::zero(), good));
    }
    (v, w)
}

/// A turn, limited to [`MOST`].
#[inline(always)]
fn limited<L: Lanes>(v: Vector<L>) -> Vector<L> {
    let square = v.length_squared();
    let most = L::splat(MOST);
    let good = square.le(most);
    // Rarely exceeded: the quotient and the root take as long as the rest of a turn.
    if good.all() {
        return v;
    }
    v * good.select(L::splat(1.0), (most / square).sqrt())
}

#[inline(always)]
fn columns<L: Lanes>(m: &Symmetric<L>) -> [Vector<L>; 3] {
    let Symmetric { along: a, across: c } = *m;
    [Vector::new(a.x, c.x, c.y), Vector::new(c.x, a.y, c.z), Vector::new(c.y, c.z, a.z)]
}

/// Reads the particles of eight body colliders when a step of substeps of `h` seconds begins.
pub(super) struct ReadStates<'a> {
    pub(super) mass: &'a WideMass,
    pub(super) slots: &'a [Slot],
    pub(super) position: &'a [Vec4],
    pub(super) velocity: &'a [Vec4],
    pub(super) rounding: &'a [Vec4],
    /// Rows with their extracted rotations.
    pub(super) bodies: &'a Bodies,
    pub(super) first: usize,
    /// Reach of each of them, and the tolerances of their rods, metres.
    pub(super) reach: LaneArray,
    pub(super) tolerance: LaneArray,
    pub(super) state: &'a mut WideRigidState,
    pub(super) h: f32,
    /// Scratch.
    pub(super) gathered: &'a mut Vec<Gathered>,
}

impl Work for ReadStates<'_> {
    /// A bit for each that moves as a rigid body does: its particles are at their places and had the same last substep, and it does not turn too fast.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let Self { mass, slots, position, velocity, rounding, bodies, first, state, .. } = self;
        let gathered = self.gathered;
        let Some(slot) = slots.first() else { return 0 };
        let (near, _) = Vector::of(L::rows(position, &slot.rows));
        let (pace, lag) = Vector::of(L::rows(velocity, &slot.rows));
        let (mut sum, mut speeds) = (zero::<L>(), zero::<L>());
        let mut good = L::zero().le(lag);
        gathered.resize(slots.len(), Gathered::default());
        for (slot, kept) in slots.iter().zip(&mut *gathered) {
            let (q, _) = Vector::of(L::rows(position, &slot.rows));
            let (v, own) = Vector::of(L::rows(velocity, &slot.rows));
            store(q, &mut kept.position);
            store(v, &mut kept.moved);
            let pull = L::load(&slot.pull);
            sum += (q - near) * pull;
            speeds += (v - pace) * pull;
            good = good.and(own.same(lag));
        }
        let middle = L::load(&mass.inverse_weight);
        let (centre, shift) = (near + sum * middle, pace + speeds * middle);
        let moments = Moments::of(slots, centre, shift, |number, slot| {
            let kept = &gathered[number];
            let (dropped, _) = Vector::of(L::rows(rounding, &slot.rows));
            (load(&kept.position), load(&kept.moved), dropped)
        });
        let whole = L::records::<FIELDS>(&bodies.rows, &from_row(first))[ROTATION];
        let r = Matrix::of(whole);
        let (mut off, mut turned) = (L::zero(), zero::<L>());
        for (slot, kept) in slots.iter().zip(&*gathered) {
            let q = load(&kept.position);
            let (rest, pull) = (r.times(load(&slot.rest)), L::load(&slot.pull));
            let there = (q - centre) - rest;
            turned += rest.cross(there) * pull;
            off = off.max(L::zero().lt(pull).and(there.length_squared()));
        }
        let (inertia, inverse) =
            (Symmetric::load(&mass.inertia), Symmetric::load(&mass.inverse_inertia));
        let half = L::splat(0.5);
        let nudge = r.times(inverse.times(r.transposed_times_vector(turned))) * half;
        let rotation = Rotation { whole, remainder: [L::zero(); 4] }.nudged(nudge);
        let own = r.transposed_times_vector(moments.momentum);
        let fast = inverse.times(own) * (half * L::splat(self.h));
        let (turn, real) = turn_of(own * lag, &inertia, &inverse);
        let most = L::load(&self.reach) * L::splat(MISPLACED) + L::load(&self.tolerance);
        // False for NaN, too.
        good = good.and(off.le(most * most)).and(fast.length_squared().le(L::splat(FAST)));
        store(centre, &mut state.began);
        store(centre, &mut state.centre);
        store(moments.centre * middle, &mut state.remainder);
        store(shift, &mut state.velocity);
        store(moments.velocity * middle, &mut state.rounding);
        store(moments.momentum, &mut state.momentum);
        rotation.store(&mut state.rotation);
        store(centre, &mut state.start_centre);
        rotation.store(&mut state.start_rotation);
        store_four([turn.x, turn.y, turn.z, real], &mut state.turn);
        lag.store(&mut state.lag);
        good.bits() & 0xFF
    }
}

/// Sums over the particles of eight bodies about a position and a velocity that are nearly their means.
struct Moments<L> {
    /// `Σ m q`, kg·m, and `Σ m v`, kg·m/s, relative to those.
    centre: Vector<L>,
    velocity: Vector<L>,
    /// `Σ m q × v`, kg·m²/s.
    momentum: Vector<L>,
}

impl<L: Lanes> Moments<L> {
    /// Sums up the position, velocity and rounding of velocity that `read` returns for the number of each slot.
    #[inline(always)]
    fn of(
        slots: &[Slot],
        centre: Vector<L>,
        velocity: Vector<L>,
        mut read: impl FnMut(usize, &Slot) -> (Vector<L>, Vector<L>, Vector<L>),
    ) -> Self {
        let (mut off, mut faster, mut dropped) = (zero::<L>(), zero::<L>(), zero::<L>());
        let (mut momentum, mut beside) = (zero::<L>(), zero::<L>());
        for (number, slot) in slots.iter().enumerate() {
            let (q, v, rounded) = read(number, slot);
            let (arm, gone, pull) = (q - centre, v - velocity, L::load(&slot.pull));
            off += arm * pull;
            faster += gone * pull;
            dropped += rounded * pull;
            momentum += arm.cross(gone) * pull;
            beside += arm.cross(rounded) * pull;
        }
        Self { centre: off, velocity: faster + dropped, momentum: momentum + beside }
    }
}

/// Forces that differ between particles: their sums over eight body colliders in a substep.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ForceSums {
    /// Gain of velocity, m/s.
    pub(super) velocity: [LaneArray; 3],
    /// Gain of angular momentum, kg·m²/s.
    pub(super) momentum: [LaneArray; 3],
    /// A bit for each lane whose damping losses are included.
    pub(super) forced: u32,
}

/// Advances eight states by some substeps.
pub(super) struct AdvanceStates<'a> {
    pub(super) mass: &'a WideMass,
    pub(super) state: &'a mut WideRigidState,
    /// Acceleration of all particles, m/s².
    pub(super) common: Vec3,
    /// Sums of other forces, for a single substep.
    pub(super) sums: Option<&'a ForceSums>,
    pub(super) h: f32,
    /// Swept bounds, and the end of each substep, seconds since the step began.
    pub(super) wide_swept: &'a WideSweptBounds,
    pub(super) times: &'a [f32],
}

impl Work for AdvanceStates<'_> {
    /// A bit for each that has left its swept bounds.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let Self { mass, state, common, sums, wide_swept, times, .. } = self;
        let (inertia, inverse) =
            (Symmetric::load(&mass.inertia), Symmetric::load(&mass.inverse_inertia));
        let (a, h, half) = (Vector::<L>::splat(common), L::splat(self.h), L::splat(0.5));
        let (mut centre, mut remainder) = (load::<L>(&state.centre), load::<L>(&state.remainder));
        let (mut velocity, mut rounding) = (load::<L>(&state.velocity), load::<L>(&state.rounding));
        let mut momentum = load::<L>(&state.momentum);
        let mut rotation = Rotation::<L>::load(&state.rotation);
        let mut lag = L::load(&state.lag);
        let (mut start, mut turn) = ((centre, rotation), rotation.whole);
        let mut left = 0;
        for (number, &time) in times.iter().enumerate() {
            let tau = (lag + h) * half;
            lag = h;
            let mut change = a * tau + rounding;
            let mut lost = L::load(&state.lost[number.min(1)]);
            if let Some(sums) = sums {
                lost = L::mask(sums.forced).select(L::zero(), lost);
            }
            change -= velocity * lost;
            momentum -= momentum * lost;
            if let Some(sums) = sums {
                change += load(&sums.velocity);
                momentum += load(&sums.momentum);
            }
            let next = velocity + change;
            rounding = change - (next - velocity);
            velocity = next;
            start = (centre, rotation);
            let step = velocity * h + remainder;
            let there = centre + step;
            remainder = step - (there - centre);
            centre = there;
            let own = rotation.matrix().transposed_times_vector(momentum) * h;
            let (v, w) = turn_of(own, &inertia, &inverse);
            rotation = rotation.further(v, w);
            turn = [v.x, v.y, v.z, w];
            left |= wide_swept.outside::<L>(centre, rotation.whole, time);
        }
        store(centre, &mut state.centre);
        store(remainder, &mut state.remainder);
        store(velocity, &mut state.velocity);
        store(rounding, &mut state.rounding);
        store(momentum, &mut state.momentum);
        rotation.store(&mut state.rotation);
        store(start.0, &mut state.start_centre);
        start.1.store(&mut state.start_rotation);
        store_four(turn, &mut state.turn);
        lag.store(&mut state.lag);
        left & state.lanes
    }
}

/// Writes the rows of eight states that contacts read.
pub(super) struct ShowStates<'a> {
    pub(super) mass: &'a WideMass,
    pub(super) state: &'a WideRigidState,
    pub(super) bodies: &'a mut Bodies,
    pub(super) first: usize,
    pub(super) h: f32,
    /// Whether with velocities and at the poses where the substep began; otherwise with displacements, at the predicted poses.
    pub(super) at_start: bool,
    /// Swept bounds, and the time since the step began, seconds.
    pub(super) wide_swept: Option<(&'a WideSweptBounds, f32)>,
}

impl Work for ShowStates<'_> {
    /// A bit for each that has left its swept bounds.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let Self { mass, state, bodies, first, at_start, wide_swept, .. } = self;
        let rotation = if at_start { &state.start_rotation } else { &state.rotation };
        let rotation = load_four::<L>(&rotation.whole);
        let inverse = Symmetric::load(&mass.inverse_inertia).turned(&Matrix::of(rotation));
        let (velocity, momentum) = (load::<L>(&state.velocity), load::<L>(&state.momentum));
        let (none, time) = (L::zero(), L::splat(if at_start { 1.0 } else { self.h }));
        let fields = [
            zero::<L>().with(L::load(&mass.inverse_mass)),
            zero::<L>().with(none),
            inverse.along.with(none),
            inverse.across.with(none),
            load::<L>(&state.start_centre).with(none),
            (velocity * time).with(none),
            inverse.times(momentum * time).with(none),
            rotation,
        ];
        put(bodies, first, state.lanes, fields);
        let centre = load::<L>(&state.centre);
        wide_swept
            .map_or(0, |(swept, time)| swept.outside::<L>(centre, rotation, time) & state.lanes)
    }
}

/// Writes the rows of `lanes` out of eight.
#[inline(always)]
fn put<L: Lanes>(bodies: &mut Bodies, first: usize, lanes: u32, fields: [[L; 4]; FIELDS]) {
    let rows = from_row(first);
    if lanes == 0xFF {
        L::put_records(&mut bodies.rows, &rows, fields);
        return;
    }
    let before = bodies.eight(first);
    L::put_records(&mut bodies.rows, &rows, fields);
    bodies.put_back(first, !lanes, before);
}

kernel!(
    /// Applies the pose deltas of contacts in a substep to eight states.
    pub(super) fn correct_states<L: Lanes>(
        mass: &WideMass,
        state: &mut WideRigidState,
        bodies: &Bodies,
        first: usize,
        h: f32,
    ) {
        let [shift, turn, ..] = L::records::<FIELDS>(&bodies.rows, &from_row(first));
        let (shift, turn) = (Vector::of(shift).0, Vector::of(turn).0);
        let moved = L::zero().lt(shift.length_squared() + turn.length_squared());
        if !moved.any() {
            return;
        }
        let (inertia, inverse) =
            (Symmetric::load(&mass.inertia), Symmetric::load(&mass.inverse_inertia));
        let (h, per) = (L::splat(h), L::splat(1.0 / h));
        let r = Rotation::<L>::load(&state.rotation).matrix();
        let gained = inertia.times_turned(&r, turn);
        let momentum = load::<L>(&state.momentum) + gained * per;
        let start = Rotation::<L>::load(&state.start_rotation);
        let own = start.matrix().transposed_times_vector(momentum) * h;
        let (v, w) = turn_of(own, &inertia, &inverse);
        let step = shift + load(&state.remainder);
        let centre = load::<L>(&state.centre);
        let there = centre + step;
        store(load::<L>(&state.velocity) + shift * per, &mut state.velocity);
        store(momentum, &mut state.momentum);
        store(there, &mut state.centre);
        store(step - (there - centre), &mut state.remainder);
        start.further(v, w).store(&mut state.rotation);
        store_four([v.x, v.y, v.z, w], &mut state.turn);
    }
);

/// Applies the velocity changes of contacts, which refer to where the substep began, to eight states.
pub(super) struct BounceStates<'a> {
    pub(super) mass: &'a WideMass,
    pub(super) state: &'a mut WideRigidState,
    pub(super) bodies: &'a Bodies,
    pub(super) first: usize,
    pub(super) h: f32,
    /// A bit for each with new velocities, and for each of those whose position stays.
    pub(super) lanes: u32,
    pub(super) stays: u32,
}

impl Work for BounceStates<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { mass, state, bodies, first, lanes, stays, .. } = self;
        let lanes = L::mask(lanes & state.lanes);
        let [shift, turn, ..] = L::records::<FIELDS>(&bodies.rows, &from_row(first));
        let (shift, turn) = (Vector::of(shift).0, Vector::of(turn).0);
        let inertia = Symmetric::load(&mass.inertia);
        let r = Rotation::<L>::load(&state.start_rotation).matrix();
        let gained = inertia.times_turned(&r, turn);
        let (velocity, momentum) = (load::<L>(&state.velocity), load::<L>(&state.momentum));
        let (faster, spun) = (velocity + shift, momentum + gained);
        store(faster.or_else(lanes, velocity), &mut state.velocity);
        store(spun.or_else(lanes, momentum), &mut state.momentum);
        settle::<L>(mass, state, self.h, lanes, L::mask(stays));
    }
}

/// Updates states whose velocities have changed: the turn in the ending substep, and the pose that it led to, unless that stays.
#[inline(always)]
fn settle<L: Lanes>(mass: &WideMass, state: &mut WideRigidState, h: f32, lanes: L, stays: L) {
    let (inertia, inverse) =
        (Symmetric::load(&mass.inertia), Symmetric::load(&mass.inverse_inertia));
    let (start, rotation) =
        (Rotation::<L>::load(&state.start_rotation), Rotation::<L>::load(&state.rotation));
    let momentum = load::<L>(&state.momentum) * L::splat(h);
    // Backwards from the pose that stays, or forwards from the start.
    let back = -rotation.matrix().transposed_times_vector(momentum);
    let forth = start.matrix().transposed_times_vector(momentum);
    let (v, w) = turn_of(back.or_else(stays, forth), &inertia, &inverse);
    let v = (-v).or_else(stays, v);
    let goes = stays.select(L::zero(), lanes);
    let centre = load::<L>(&state.centre);
    let gone = load::<L>(&state.start_centre) + load::<L>(&state.velocity) * L::splat(h);
    store(gone.or_else(goes, centre), &mut state.centre);
    store(zero::<L>().or_else(goes, load(&state.remainder)), &mut state.remainder);
    start.further(v, w).or_else(goes, rotation).store(&mut state.rotation);
    let (turned, before) = ([v.x, v.y, v.z, w], load_four::<L>(&state.turn));
    for i in 0..4 {
        lanes.select(turned[i], before[i]).store(&mut state.turn[i]);
    }
}

/// Pose of eight bodies about their centres: a rotation, its remainder, radians, and the remainder of the centre, metres.
struct WidePose<L> {
    r: Matrix<L>,
    nudge: Vector<L>,
    remainder: Vector<L>,
}

impl<L: Lanes> WidePose<L> {
    /// Position of a particle of each from the centre. A closure would not be compiled for the instruction set of the kernel.
    #[inline(always)]
    fn arm(&self, rest: Vector<L>) -> Vector<L> {
        let arm = self.r.times(rest);
        arm + (self.nudge.cross(arm) + self.remainder)
    }
}

kernel!(
    /// Writes the particles of some of eight states: with `exact`, so that the next step reads their momenta exactly, else to round-off.
    pub(super) fn write_states<L: Lanes>(
        group: &BodyGroup,
        slots: &[Slot],
        state: &WideRigidState,
        lanes: u32,
        exact: bool,
        // Positions, positions at the start of the substep, velocities, and their roundings.
        columns: [&mut [Vec4]; 4],
    ) {
        let [position, start, velocity, rounding] = columns;
        let lag = L::load(&state.lag);
        let (turn, none, two) = (load_four::<L>(&state.turn), L::zero(), L::splat(2.0));
        let v = Vector::new(turn[0], turn[1], turn[2]);
        let (rotation, begun) =
            (Rotation::<L>::load(&state.rotation), Rotation::<L>::load(&state.start_rotation));
        let (r, nudge) = (Matrix::normalised(rotation.whole), rotation.nudge());
        let before = Matrix::normalised(begun.whole);
        // (1 - Δᵀ) r = 2 (w v × r - v × (v × r)).
        let (square, along) = (v.length_squared(), v * turn[3]);
        let back = Matrix {
            x: Vector::new(square, along.z, -along.y) - v * v.x,
            y: Vector::new(-along.z, square, along.x) - v * v.y,
            z: Vector::new(along.y, -along.x, square) - v * v.z,
        };
        // Divided, not multiplied by a rounded 1/h: that would lose or gain the same share in every step.
        let per_second = |v: Vector<L>| {
            let twice = v * two;
            Vector::new(twice.x / lag, twice.y / lag, twice.z / lag)
        };
        let back = Matrix { x: per_second(back.x), y: per_second(back.y), z: per_second(back.z) };
        let mut rates = r.times_matrix(&back);
        let (centre, remainder) = (load::<L>(&state.centre), load::<L>(&state.remainder));
        let (began, mean) = (load::<L>(&state.start_centre), load::<L>(&state.velocity));
        let dropped = load::<L>(&state.rounding);
        let inverse = Symmetric::load(&group.mass.inverse_inertia);
        let pose = WidePose { r, nudge, remainder };
        // Corrects the momenta for the rounding of the above: a hundred steps would otherwise lose or gain the same amount a hundred times. What the
        // velocities cannot represent is stored as their rounding.
        let (mut more, mut faster) = (zero::<L>(), dropped);
        for _ in 0..if exact { 2 } else { 0 } {
            rates = Matrix {
                x: rates.x + more.cross(r.x),
                y: rates.y + more.cross(r.y),
                z: rates.z + more.cross(r.z),
            };
            let written = Moments::of(slots, centre, mean, |_, slot| {
                let rest = load(&slot.rest);
                (centre + pose.arm(rest), mean + rates.times(rest), zero())
            });
            let missing = r.transposed_times_vector(load::<L>(&state.momentum) - written.momentum);
            more = r.times(inverse.times(missing));
            faster = dropped - written.velocity * L::load(&group.mass.inverse_weight);
        }
        let whole = !group.scattered && lanes == 0xFF;
        for slot in slots {
            let (rest, w) = (load::<L>(&slot.rest), L::load(&slot.inverse_mass));
            let arm = pose.arm(rest);
            let fields = [
                (centre + arm).with(w),
                (began + before.times(rest)).with(w),
                (mean + rates.times(rest)).with(lag),
                (faster + more.cross(arm)).with(none),
            ];
            let columns = [&mut *position, &mut *start, &mut *velocity, &mut *rounding]
                .into_iter()
                .zip(fields);
            for (column, field) in columns {
                if whole {
                    L::put_rows(column, &slot.rows, field);
                    continue;
                }
                let mut eight = [Vec4::ZERO; LANES];
                L::put_run(&mut eight, 0, field);
                for (lane, own) in eight.into_iter().enumerate() {
                    if lanes >> lane & 1 == 1 && slot.share[lane] > 0.0 {
                        column[slot.rows[lane] as usize] = own;
                    }
                }
            }
        }
    }
);
