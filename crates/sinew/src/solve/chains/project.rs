//! The kernel: a chain of rods, solved at once.
//!
//! Rod `i` of `n`, from particle `i - 1` to `i`, asks for `C_i = ‖d_i‖ - L_i = 0` with `d_i = p_i - p_(i-1)`; its gradients are `∓n_i`, `n_i = d_i/‖d_i‖`. Where each
//! is to first order what all of them together make it, by the least motion weighted with the masses, is (physics.md C1)
//!
//! ```text
//! A λ = -C,   A_(i,i) = w_(i-1) + w_i,   A_(i,i+1) = -w_i n_i·n_(i+1),   Δp_i = w_i (λ_i n_i - λ_(i+1) n_(i+1))
//! ```
//!
//! with inverse masses `w`: a rod feels the two beside it and nobody else, so `A` is tridiagonal, and elimination takes one pass there and one back
//! (Thomas). It is one step of Newton's method. Pulls are along rods and in pairs, so the barycentre stays, and nothing is turned.
//!
//! **What cannot be.** A chain that is straight and too short for what it holds together asks for ways to the side that would have to be as long as they like,
//! `C/θ` where neighbours make an angle of `θ`: a step of Newton's overshoots. So the diagonal is enlarged by a share `κ |C_i|/L_i` of itself (Levenberg and
//! Marquardt): with that no way to the side is longer than the sag `√(C L)/2√κ` that would do, and where a chain can be kept, `C` and with it the share vanish.
//! Nor does a particle go farther than twice what all rods together are off by. What is left the sweeps share out, and what is pinned is held by tethers besides.

use super::Eliminated;
use crate::lanes::{Number, Vector};

/// What a chain is solved on: one, or that of each of eight bodies.
pub(in crate::solve) trait Links<N: Number> {
    /// Particles, one more than there are rods.
    fn count(&self) -> usize;
    /// Both particles of a link as `x y z w`, `w` being inverse masses; the same twice where there is one.
    fn ends(&self, link: usize) -> [[N; 4]; 2];
    /// Whether there are two.
    fn is_double(&self, link: usize) -> bool;
    /// Length of the rod that leads there, metres.
    fn rest(&self, link: usize) -> N;
    /// Moves it. The pulls are those of the rod that leads there, and of the next one, which pulls the other way, kg·m.
    fn shift(&mut self, link: usize, by: Vector<N>, pulls: [Vector<N>; 2]);
    /// Keeps what is needed on the way back.
    fn keep(&mut self, link: usize, eliminated: Eliminated<N>);
    /// What was kept.
    fn kept(&self, link: usize) -> Eliminated<N>;
}

/// What is always added to the diagonal, as a share of it: some roundings, so that no pivot is nothing.
const TRACE: f32 = 1e-6;

/// What is left of a diagonal where that is nothing but round-off, as a share of it.
pub(super) const NO_PIVOT: f32 = 0.1 * TRACE;

/// The share `κ`. By 0.1 a rope that is jerked straight between free weights of a thousand of its pieces is off by as much as without, 20 %, and its pieces
/// are flung at 11 m/s instead of 25; a tenth of it hardly helps. A load may be some `L/2κg h²` times a piece before it is held too softly, 9000 of 5 cm.
pub(super) const KAPPA: f32 = 0.1;

/// The same between two pins, where a straight chain can go nowhere at all: with 10 some of 20 pieces that are as long as their gap still tremble, by 0.4 m/s.
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
    // Of the rod before: its direction, the inverse of its pivot, and its right side.
    let (mut before, mut inverse, mut right) = (no, zero, zero);
    let (mut sum, mut worst) = (zero, zero);
    for link in 1..count {
        let (q, next_w) = place(chain, link);
        let d = q - p;
        let length = d.length();
        let rest = chain.rest(link);
        let value = length - rest;
        // Two in one place have no direction, and pull at nobody.
        let n = d * zero.lt(length).and(one / length);
        let diagonal = diagonal(w + next_w, kappa, value, rest);
        let coupling = -(w * n.dot(before));
        let share = coupling * inverse;
        let pivot = diagonal - share * coupling;
        // Two pins have none.
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

/// The diagonal of a rod between particles with so much inverse mass together, which is off by `value`, metres.
#[inline(always)]
pub(super) fn diagonal<N: Number>(w: N, kappa: N, value: N, rest: N) -> N {
    let share_off = N::zero().lt(rest).and(value.abs() / rest);
    w * (N::splat(1.0 + TRACE) + kappa * share_off)
}

/// Where a link is, and its inverse mass: of two particles, that of one with the mass of both.
#[inline(always)]
fn place<N: Number>(chain: &impl Links<N>, link: usize) -> (Vector<N>, N) {
    let [one, other] = chain.ends(link);
    if chain.is_double(link) { merged(one, other) } else { Vector::of(one) }
}

/// Of two particles, one with the mass of both.
#[inline(always)]
pub(super) fn merged<N: Number>(one: [N; 4], other: [N; 4]) -> (Vector<N>, N) {
    let ((p, w), (q, other_w)) = (Vector::of(one), Vector::of(other));
    let both = w + other_w;
    let moves = N::zero().lt(both);
    // Of two pins it is the first.
    let share = moves.and(w / both);
    (p + (q - p) * share, share * other_w)
}

/// A way, shortened to `most` metres where it is longer.
#[inline(always)]
pub(super) fn within<N: Number>(most: N, by: Vector<N>) -> Vector<N> {
    let square = by.length_squared();
    let far = (most * most).lt(square);
    if !far.any() {
        return by;
    }
    (by * (most / square.sqrt())).or_else(far, by)
}
