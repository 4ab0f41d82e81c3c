//! What hangs on one or two pins keeps its angular momentum about that point, or about the axis through both: a pendulum, a rope with a weight, a swing.
//!
//! The force of a pin has no moment about the pin, and constraints among the particles add none in sum. But a projection to the nearest point is not quite along
//! the rod as it was at the start of the substep, about which Verlet conserves angular momentum `Σ r × m v`. It takes a share `½ (ωh)²` of the speed in each
//! substep: a pendulum of 1 m that is let go at 57° loses a fifth of its energy in ten seconds at ten substeps, and two fifths at four. So what the corrections
//! have added is removed as the turn with which a rigid body would respond that is held there ([`momentum`](super::momentum) does the same for what nothing
//! holds):
//!
//! ```text
//! L = Σ r × m (v' - u)        ω = I⁻¹ L  about a point,  a (a·L)/(a·I a)  about an axis a        v = v' - ω × r
//! ```
//!
//! with `r` from the pin to where the particle was when the substep began, `u` its predicted and `v'` its derived velocity.
//!
//! What has several parts, such as a crate on a rope, may lose angular momentum in one of them and would be given it back as a turn of all, with more energy than
//! was lost: up to 2.5 % of it in a minute. Forces that hold distances do no work. So only the share `s` of the turn is removed with which there is no more
//! kinetic energy than was predicted:
//!
//! ```text
//! Σ ½ m (v'² - u²) - s ω·Σ r × m v' + ½ s² ω·L ≤ 0
//! ```
//!
//! Written once, for one body or eight.

use crate::lanes::{Number, Vector};
use crate::pose::symmetric::{Cofactors, cofactors};

/// Addition to the inertia, as a share of its trace. A ball on a rod, or a rope that hangs straight down, has none about its line; and nothing on that line is
/// moved by a turn about it. Of what is to be removed this leaves about as large a share.
const SLENDER: f32 = 1e-4;

/// Particles of an island that are pinned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pins {
    None,
    /// Two, or one twice.
    Few([u32; 2]),
    Many,
}

impl Pins {
    /// From the rows of the pinned particles.
    pub(crate) fn of(mut rows: impl Iterator<Item = u32>) -> Self {
        match [rows.next(), rows.next(), rows.next()] {
            [None, ..] => Self::None,
            [Some(one), other, None] => Self::Few([one, other.unwrap_or(one)]),
            _ => Self::Many,
        }
    }
}

/// Sums over particles about a pivot.
#[derive(Clone, Copy, Debug)]
pub(super) struct PivotSums<N> {
    /// Where the pivot was when the substep began, metres, and the axis from there; zero for a point.
    anchor: Vector<N>,
    axis: Vector<N>,
    /// `Σ m x²`, `Σ m y²`, `Σ m z²`; and `Σ m x y`, `Σ m y z`, `Σ m z x`.
    squares: Vector<N>,
    products: Vector<N>,
    /// `Σ r × m u` and `Σ r × m (v' - u)`.
    predicted: Vector<N>,
    angular: Vector<N>,
    /// `Σ m (v'² - u²)`: twice the kinetic energy that was gained.
    energy: N,
}

/// The turn to be removed about a pivot.
#[derive(Clone, Copy, Debug)]
pub(super) struct PivotDrift<N> {
    pub(super) anchor: Vector<N>,
    /// rad/s.
    pub(super) turn: Vector<N>,
}

impl<N: Number> PivotSums<N> {
    /// No particles yet, about the pivot between two points; both the same for a point.
    #[inline(always)]
    pub(super) fn about(from: Vector<N>, to: Vector<N>) -> Self {
        let none = Vector::new(N::zero(), N::zero(), N::zero());
        Self {
            anchor: from,
            axis: to - from,
            squares: none,
            products: none,
            predicted: none,
            angular: none,
            energy: N::zero(),
        }
    }

    /// Adds a particle of inverse mass `w` that was at `start` when the substep began, with its predicted velocity and the derived one.
    #[inline(always)]
    pub(super) fn add(&mut self, w: N, start: Vector<N>, predicted: Vector<N>, derived: Vector<N>) {
        // None of a pinned particle, which the pivot carries.
        let m = N::zero().lt(w).and(N::splat(1.0) / w);
        let (r, gained) = (start - self.anchor, derived - predicted);
        let weighed = r * m;
        self.energy = self.energy + m * gained.dot(predicted + derived);
        self.predicted += weighed.cross(predicted);
        self.squares += weighed.times(r);
        self.products += weighed.times(Vector::new(r.y, r.z, r.x));
        self.angular += weighed.cross(gained);
    }

    /// The drift; none where it is not finite.
    #[inline(always)]
    pub(super) fn drift(&self) -> PivotDrift<N> {
        let Self { anchor, axis, squares: s, products: p, predicted, angular, energy } = *self;
        let (zero, one) = (N::zero(), N::splat(1.0));
        // As shares of the trace, so that no product underflows.
        let trace = N::splat(2.0) * (s.x + s.y + s.z);
        let scale = one / trace.max(N::splat(f32::MIN_POSITIVE));
        let (s, p, angular) = (s * scale, p * scale, angular * scale);
        let (predicted, lost) = (predicted * scale, (zero - energy * scale).max(zero));
        let more = N::splat(SLENDER);
        let inertia = [
            [s.y + s.z + more, zero - p.x, zero - p.z],
            [zero - p.x, s.z + s.x + more, zero - p.y],
            [zero - p.z, zero - p.y, s.x + s.y + more],
        ];
        let Cofactors { x, minors: [_, _, determinant], .. } = cofactors(&inertia, angular);
        let mut turn = x * (one / determinant);
        let has_axis = zero.lt(axis.length_squared());
        if has_axis.any() {
            let on_axis = axis * (axis.dot(angular) / moment(s, p, axis));
            turn = on_axis.or_else(has_axis, turn);
        }
        let turn = turn * share_within(lost, turn.dot(predicted + angular), turn.dot(angular));
        let finite = turn.length_squared().lt(N::splat(1e30));
        PivotDrift { anchor, turn: turn.or_else(finite, Vector::new(zero, zero, zero)) }
    }
}

/// `a·I a` about an axis `a`, from the sums that the inertia consists of.
#[inline(always)]
fn moment<N: Number>(squares: Vector<N>, products: Vector<N>, axis: Vector<N>) -> N {
    let (s, p, Vector { x, y, z }) = (squares, products, axis);
    axis.dot(Vector::new(
        (s.y + s.z) * x - p.x * y - p.z * z,
        (s.z + s.x) * y - p.x * x - p.y * z,
        (s.x + s.y) * z - p.z * x - p.y * y,
    ))
}

/// The greatest `s` up to 1 with `s² b - 2 s a ≤ lost`, for `b ≥ 0` and `lost ≥ 0`. Written for either sign of `a` without a difference of nearly equal numbers.
#[inline(always)]
fn share_within<N: Number>(lost: N, a: N, b: N) -> N {
    let (zero, one) = (N::zero(), N::splat(1.0));
    let root = (a * a + b.max(zero) * lost).sqrt();
    let gains = a.lt(zero);
    let (above, below) = (gains.select(lost, a + root), gains.select(root - a, b));
    // Where `b` is zero nothing is removed, whatever the share.
    below.le(above).select(one, above / below.max(N::splat(f32::MIN_POSITIVE)))
}

impl<N: Number> PivotDrift<N> {
    /// The velocity to be removed from a particle of inverse mass `w` that was at `start` when the substep began, m/s; none from a pinned one, and none where
    /// the mask `which` is not set.
    #[inline(always)]
    pub(super) fn share(&self, start: Vector<N>, w: N, which: N) -> Vector<N> {
        let share = self.turn.cross(start - self.anchor);
        let moves = N::zero().lt(w).and(which);
        Vector::new(moves.and(share.x), moves.and(share.y), moves.and(share.z))
    }
}
