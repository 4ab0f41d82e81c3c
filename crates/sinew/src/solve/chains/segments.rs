//! A long chain, divided into eight segments that are eliminated in parallel, one per lane: the same system, and the same solution to round-off (Wang, *A
//! Parallel Method for Tridiagonal Equations*, 1981).
//!
//! Elimination goes rod by rod, and each waits for the quotient of the previous one. In eight segments of equal length the rods are eliminated together, except
//! the last one of each, which is a separator. An eliminated rod is coupled to the next rod and, by fill-in, to the previous separator `s`:
//!
//! ```text
//! share = c_i / d_(i-1)        d_i = A_(i,i) - share c_i       b_i = -C_i - share b_(i-1)       f_i = -share f_(i-1)
//! before: A_ss -= f_i² / d_i,  b_s -= f_i b_i / d_i            λ_i = (b_i - f_i λ_s - c_(i+1) λ_(i+1)) / d_i
//! ```
//!
//! with `c_i = A_(i-1,i)`. The eight separators then form a tridiagonal system of their own, which is solved sequentially, and back substitution is in lanes
//! again. This takes half as much arithmetic again and an eighth of the waiting. Chains that may be in an instance batch are too short for it: they need the
//! same bits when solved alone.

use glam::{Vec3, Vec4};

use super::Link;
use super::project::{KAPPA, KAPPA_OF_TWO_PINS, NO_PIVOT, diagonal, within};
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, advance, kernel};

/// Lengths of rods, metres, one of each segment.
pub(super) type Rests = [f32; LANES];

/// Divides a chain: returns the rod lengths of its segments, one rod of each segment at a time. The chain begins with the first particle; then follow the rods
/// of one segment after those of the other, each with the particle that it leads to. Missing rods of the last segments are filled with rods of zero length,
/// from the last particle to itself.
pub(super) fn rests_of(links: &[Link]) -> impl Iterator<Item = Rests> {
    // An odd number: eight particles that are a power of two apart would map to the same cache sets.
    let steps = (links.len() - 1).div_ceil(LANES) | 1;
    (0..steps).map(move |step| {
        let rest = |lane: usize| links.get(1 + lane * steps + step).map_or(0.0, |link| link.rest);
        core::array::from_fn(rest)
    })
}

/// Scratch for solving a chain by segments.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct SegmentScratch {
    /// `x y z w` of its particles, where `w` are inverse masses.
    particles: Vec<Vec4>,
    eliminated: Vec<Eliminated>,
}

/// What elimination keeps of a rod of each segment: its direction, the share of the previous rod that it subtracts, its right-hand side and fill-in, both
/// divided by its pivot, and the inverse mass at its end.
type Eliminated = [[f32; LANES]; 7];

impl SegmentScratch {
    /// Solves a chain once, in positions that begin with row `first`. Returns the largest error found, metres.
    pub(super) fn project(
        &mut self,
        (links, rests): (&[Link], &[Rests]),
        (position, first): (&mut [Vec4], u32),
        instructions: InstructionSet,
    ) -> f32 {
        let Self { particles, eliminated } = self;
        particles.clear();
        particles.extend(links.iter().map(|link| link.merged(position, first)));
        let (Some(&one), Some(&last)) = (particles.first(), particles.last()) else { return 0.0 };
        particles.resize(1 + LANES * rests.len(), last);
        eliminated.resize(rests.len().max(eliminated.len()), [[0.0; LANES]; _]);
        let kappa = if one.w == 0.0 && last.w == 0.0 { KAPPA_OF_TWO_PINS } else { KAPPA };
        let worst = solve_segments(particles, rests, eliminated, kappa, instructions);
        for (link, &to) in links.iter().zip(&*particles) {
            let [at, other] = link.places(first);
            if at == other {
                position[at] = to;
                continue;
            }
            let by = (to - link.merged(position, first)).truncate().extend(0.0);
            position[at] += by;
            position[other] += by;
        }
        worst
    }
}

/// The reduced system of the separators: what elimination of their own segments left, less the contributions of the segments behind them.
#[derive(Default)]
struct Separators {
    /// The diagonal before elimination.
    whole: [f32; LANES],
    diagonal: [f32; LANES],
    right: [f32; LANES],
    /// Coupling to the previous separator.
    coupling: [f32; LANES],
}

impl Separators {
    /// The multiplier `λ` of each separator.
    fn solve(self) -> [f32; LANES] {
        let Self { whole, diagonal, right, coupling } = self;
        let (mut shares, mut lambdas) = ([0.0; LANES], [0.0; LANES]);
        let (mut inverse, mut before) = (0.0, 0.0);
        let mut inverses = [0.0; LANES];
        for k in 0..LANES {
            let share = coupling[k] * inverse;
            let pivot = diagonal[k] - share * coupling[k];
            inverse = if whole[k] * NO_PIVOT < pivot { 1.0 / pivot } else { 0.0 };
            before = right[k] - share * before;
            (shares[k], inverses[k], lambdas[k]) = (share, inverse, before);
        }
        let mut next = 0.0;
        for k in (0..LANES).rev() {
            let share = if k + 1 < LANES { shares[k + 1] } else { 0.0 };
            next = lambdas[k] * inverses[k] - share * next;
            lambdas[k] = next;
        }
        lambdas
    }
}

kernel!(
    /// Solves the segments of a chain once. Returns the largest error found, metres.
    fn solve_segments<L: Lanes>(
        particles: &mut [Vec4],
        rests: &[Rests],
        eliminated: &mut [Eliminated],
        kappa: f32,
    ) -> f32 {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let (kappa, no_pivot, steps) = (L::splat(kappa), L::splat(NO_PIVOT), rests.len() as u32);
        // The particle before each segment, and the one before that; the first segment has no rod before it.
        let (mut rows, mut rows_before) = ([0; LANES], [0; LANES]);
        for (lane, row) in rows.iter_mut().enumerate() {
            *row = lane as u32 * steps;
        }
        for (before, row) in rows_before.iter_mut().zip(rows) {
            *before = row.saturating_sub(1);
        }
        let (mut p, mut w) = Vector::of(L::rows(particles, &rows));
        let d = p - Vector::of(L::rows(particles, &rows_before)).0;
        let length = d.length();
        let mut before = d * zero.lt(length).and(one / length);
        // Right-hand sides, fill-in, and inverse pivots of the previous rods. Initially those are the separators.
        let (mut right, mut fill, mut inverse) = (zero, zero, zero);
        // What is subtracted from the previous separators.
        let (mut off_diagonal, mut off_right) = (zero, zero);
        let (mut sum, mut worst, mut whole, mut pivot) = (zero, zero, zero, zero);
        for (step, (rest, to)) in rests.iter().zip(&mut *eliminated).enumerate() {
            advance(&mut rows);
            let (q, next_w) = Vector::of(L::rows(particles, &rows));
            let (d, rest) = (q - p, L::load(rest));
            let length = d.length();
            let value = length - rest;
            let n = d * zero.lt(length).and(one / length);
            let coupling = -(w * n.dot(before));
            whole = diagonal(w + next_w, kappa, value, rest);
            let share = coupling * inverse;
            pivot = whole - share * coupling;
            right = -value - share * right;
            fill = if step == 0 { coupling } else { -(share * fill) };
            inverse = (whole * no_pivot).lt(pivot).and(one / pivot);
            let filled = fill * inverse;
            if step + 1 < rests.len() {
                off_diagonal = off_diagonal + filled * fill;
                off_right = off_right + filled * right;
            }
            let [x, y, z, to_share, to_right, to_filled, to_w] = to;
            n.x.store(x);
            n.y.store(y);
            n.z.store(z);
            share.store(to_share);
            (right * inverse).store(to_right);
            filled.store(to_filled);
            next_w.store(to_w);
            sum = sum + value.abs();
            worst = value.abs().max(worst);
            (p, w, before) = (q, next_w, n);
        }
        let mut separators = Separators {
            whole: whole.array(),
            diagonal: pivot.array(),
            right: right.array(),
            coupling: fill.array(),
        };
        let (off_diagonal, off_right) = (off_diagonal.array(), off_right.array());
        for k in 1..LANES {
            separators.diagonal[k - 1] -= off_diagonal[k];
            separators.right[k - 1] -= off_right[k];
        }
        let lambdas = separators.solve();
        let mut lambdas_before = [0.0; LANES];
        lambdas_before[1..].copy_from_slice(&lambdas[..LANES - 1]);
        let separator_before = L::load(&lambdas_before);
        let most = L::splat(2.0 * sum.array().iter().fold(0.0, |sum, x| sum + x));
        let mut lambda_next = L::load(&lambdas);
        // The impulses of the separators, whose particles also belong to the next segments.
        let last_pull = before * lambda_next;
        let (last_w, mut pull_next) = (w, last_pull);
        let last_rows = rows;
        let mut share_next = eliminated.get(rests.len() - 1).map_or(zero, |last| L::load(&last[3]));
        for kept in eliminated[..rests.len() - 1].iter().rev() {
            let [x, y, z, share, right, filled, w] = kept;
            rows.iter_mut().for_each(|row| *row -= 1);
            let n = Vector::new(L::load(x), L::load(y), L::load(z));
            let (right, filled, w) = (L::load(right), L::load(filled), L::load(w));
            let lambda = right - share_next * lambda_next - filled * separator_before;
            let pull = n * lambda;
            let by = within(most, (pull - pull_next) * w);
            let p = Vector::of(L::rows(particles, &rows)).0;
            L::put_rows(particles, &rows, (p + by).with(w));
            (share_next, lambda_next, pull_next) = (L::load(share), lambda, pull);
        }
        let firsts = [pull_next.x.array(), pull_next.y.array(), pull_next.z.array()];
        let mut behind = firsts;
        for column in &mut behind {
            column.rotate_left(1);
            column[LANES - 1] = 0.0;
        }
        let [x, y, z] = &behind;
        let behind = Vector::new(L::load(x), L::load(y), L::load(z));
        let by = within(most, (last_pull - behind) * last_w);
        let p = Vector::of(L::rows(particles, &last_rows)).0;
        L::put_rows(particles, &last_rows, (p + by).with(last_w));
        let first_pull = Vector::new(firsts[0][0], firsts[1][0], firsts[2][0]);
        let by = within(most.array()[0], first_pull * -particles[0].w);
        particles[0] += Vec3::from(by).extend(0.0);
        worst.largest(0.0)
    }
);
