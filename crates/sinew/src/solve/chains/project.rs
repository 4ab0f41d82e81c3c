//! The kernel: direct solution of a chain of rods.
//!
//! Rod `i` of `n`, from particle `i - 1` to `i`, has the constraint `C_i = ‖d_i‖ - L_i = 0` with `d_i = p_i - p_(i-1)`; its gradients are `∓n_i`, `n_i =
//! d_i/‖d_i‖`. The least mass-weighted motion that satisfies all of them to first order is (physics.md C1)
//!
//! ```text
//! A λ = -C,   A_(i,i) = w_(i-1) + w_i,   A_(i,i+1) = -w_i n_i·n_(i+1),   Δp_i = w_i (λ_i n_i - λ_(i+1) n_(i+1))
//! ```
//!
//! with inverse masses `w`. A rod couples only to its two neighbours, so `A` is tridiagonal, and elimination takes one pass forward and one back (Thomas). It
//! is one step of Newton's method. The impulses act along rods and in opposite pairs, so the barycentre stays, and no angular momentum is added.
//!
//! **Infeasible chains.** A chain that is straight and too short for its ends requires sideways motion of unbounded length, `C/θ` where neighbours make an
//! angle of `θ`: a Newton step overshoots. So the diagonal is enlarged by a share `κ |C_i|/L_i` of itself (Levenberg and Marquardt). This limits sideways
//! motion to the sag `√(C L)/2√κ` that would suffice; where the chain is feasible, `C` and with it the share vanish. In addition no particle moves farther than
//! twice the total error of all rods. The remaining error is distributed by the sweeps, and pinned chains are also held by tethers.

use super::Eliminated;
use crate::lanes::{Number, Vector};

/// The chain that is solved: a single one, or the corresponding ones of eight bodies.
pub(in crate::solve) trait Links<N: Number> {
    /// Number of particles, one more than rods.
    fn count(&self) -> usize;
    /// Both particles of a link as `x y z w`, where `w` are inverse masses; the same twice where there is one.
    fn ends(&self, link: usize) -> [[N; 4]; 2];
    /// Whether a link consists of two particles.
    fn is_double(&self, link: usize) -> bool;
    /// Length of the rod that leads there, metres.
    fn rest(&self, link: usize) -> N;
    /// Moves a link. `pulls` are the impulses times the substep, kg·m, of the rod that leads there, and of the next one, which acts in the opposite direction.
    fn shift(&mut self, link: usize, by: Vector<N>, pulls: [Vector<N>; 2]);
    /// Stores what back substitution needs.
    fn keep(&mut self, link: usize, eliminated: Eliminated<N>);
    /// What was stored.
    fn kept(&self, link: usize) -> Eliminated<N>;
}

/// Constant regularisation of the diagonal, as a share of it: some round-off errors, so that no pivot is zero.
const TRACE: f32 = 1e-6;

/// Least pivot, as a share of the diagonal. What is smaller is round-off.
pub(super) const NO_PIVOT: f32 = 0.1 * TRACE;

/// The share `κ`. With 0.1, a rope that is jerked straight between free weights of a thousand of its pieces is off by as much as without, 20 %, and its pieces
/// are flung at 11 m/s instead of 25; a tenth of 0.1 hardly helps. A load may be about `L/(2κ g h²)` times as heavy as a piece before it is held too softly:
/// 9000 times for pieces of 5 cm.
pub(super) const KAPPA: f32 = 0.1;

/// `κ` between two pins, where a straight chain cannot move at all: with 10, a chain of 20 pieces as long as the gap still trembled at up to 0.4 m/s.
pub(super) const KAPPA_OF_TWO_PINS: f32 = 100.0;

/// Solves a chain once. Returns the largest error found, metres.
#[inline(always)]
pub(in crate::solve) fn project_chain<N: Number>(chain: &mut impl Links<N>) -> N {
    let (zero, one) = (N::zero(), N::splat(1.0));
    let no = Vector::new(zero, zero, zero);
    let (mut p, mut w) = place(chain, 0);
    let (first_w, count) = (w, chain.count());
    let (_, last_w) = place(chain, count - 1);
    let both = first_w.same(zero).and(last_w.same(zero));
    let kappa = both.select(N::splat(KAPPA_OF_TWO_PINS), N::splat(KAPPA));
    // Direction, inverse pivot, and right-hand side of the previous rod.
    let (mut before, mut inverse, mut right) = (no, zero, zero);
    let (mut sum, mut worst) = (zero, zero);
    for link in 1..count {
        let (q, next_w) = place(chain, link);
        let d = q - p;
        let length = d.length();
        let rest = chain.rest(link);
        let value = length - rest;
        // Coincident particles give no direction, and no impulse.
        let n = d * zero.lt(length).and(one / length);
        let diagonal = diagonal(w + next_w, kappa, value, rest);
        let coupling = -(w * n.dot(before));
        let share = coupling * inverse;
        let pivot = diagonal - share * coupling;
        // The pivot of a rod between two pins is zero.
        inverse = (diagonal * N::splat(NO_PIVOT)).lt(pivot).and(one / pivot);
        right = -value - share * right;
        chain.keep(link, [n.x, n.y, n.z, share, right * inverse, next_w]);
        sum = sum + value.abs();
        worst = value.abs().max(worst);
        (p, w, before) = (q, next_w, n);
    }
    let most = sum + sum;
    let (mut share_next, mut lambda_next, mut pull_next) = (zero, zero, no);
    for link in (1..count).rev() {
        let [x, y, z, share, right, w] = chain.kept(link);
        let lambda = right - share_next * lambda_next;
        let pull = Vector::new(x, y, z) * lambda;
        chain.shift(link, within(most, (pull - pull_next) * w), [pull, pull_next]);
        (share_next, lambda_next, pull_next) = (share, lambda, pull);
    }
    chain.shift(0, within(most, -pull_next * first_w), [no, pull_next]);
    worst
}

/// The diagonal of a rod whose ends have the sum `w` of inverse masses, and whose error is `value`, metres.
#[inline(always)]
pub(super) fn diagonal<N: Number>(w: N, kappa: N, value: N, rest: N) -> N {
    let share_off = N::zero().lt(rest).and(value.abs() / rest);
    w * (N::splat(1.0 + TRACE) + kappa * share_off)
}

/// Position and inverse mass of a link; of two particles, those of one with the mass of both.
#[inline(always)]
fn place<N: Number>(chain: &impl Links<N>, link: usize) -> (Vector<N>, N) {
    let [one, other] = chain.ends(link);
    if chain.is_double(link) { merged(one, other) } else { Vector::of(one) }
}

/// Merges two particles into one with the mass of both.
#[inline(always)]
pub(super) fn merged<N: Number>(one: [N; 4], other: [N; 4]) -> (Vector<N>, N) {
    let ((p, w), (q, other_w)) = (Vector::of(one), Vector::of(other));
    let both = w + other_w;
    let moves = N::zero().lt(both);
    // Of two pins, the first is taken.
    let share = moves.and(w / both);
    (p + (q - p) * share, share * other_w)
}

/// A displacement, shortened to `most` metres where it is longer.
#[inline(always)]
pub(super) fn within<N: Number>(most: N, by: Vector<N>) -> Vector<N> {
    let square = by.length_squared();
    let far = (most * most).lt(square);
    if !far.any() {
        return by;
    }
    (by * (most / square.sqrt())).or_else(far, by)
}
