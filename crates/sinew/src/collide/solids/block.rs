//! The few unknowns of one manifold, solved together: how hard each of its four points presses, and how friction answers. Eight manifolds side by
//! side.
//!
//! # Pressing
//!
//! With `λ` the impulses along the normal (in kg·m, since positions are moved), `K` how far each of them moves each point, and `c` how far in the
//! points are, wanted is
//! `λ ≥ 0` with `K λ ≥ c`, where one of the two is an equality. Four points in a plane move as a rigid plane does, so `K` has rank 3, and if one
//! point were solved after the other, a box at rest would rock from corner to corner. So the points that are in are solved at once, for a pressure
//! that is linear over the patch, `λ = G μ` with rows `(1, x, y)` of
//! `G`: `Gᵀ K G μ = Gᵀ c`. That is exact for up to three points and symmetric for four. Where it would pull, the points are solved one after the
//! other after all, a few times over, with the sum of each kept from pulling.

use super::turn::Symmetric;
use crate::lanes::{Lanes, Vector};

/// Rounds of solving point after point. What is left is corrected in the next substep.
const ROUNDS: usize = 6;
/// Share of the stiffness that patches have added, so that a small one, whose tilt is round-off, does not answer that.
const BLUNT: f32 = 1e-3;

/// The impulses that put four points outside. `x` and `y` are where they are in the patch, in any unit.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "rows and columns of the same four points")]
pub(super) fn press<L: Lanes>(k: &[[L; 4]; 4], c: [L; 4], at: [(L, L); 4]) -> [L; 4] {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut inside = [none; 4];
    let (mut x, mut y, mut count) = (none, none, none);
    for i in 0..4 {
        inside[i] = none.lt(c[i]);
        count = count + inside[i].and(one);
        x = x + inside[i].and(at[i].0);
        y = y + inside[i].and(at[i].1);
    }
    let share = none.lt(count).select(one / count, none);
    let (x, y) = (x * share, y * share);
    let mut size = none;
    let mut g = [[none; 3]; 4];
    for i in 0..4 {
        let (dx, dy) = (at[i].0 - x, at[i].1 - y);
        g[i] = [inside[i].and(one), inside[i].and(dx), inside[i].and(dy)];
        size = size + g[i][1] * g[i][1] + g[i][2] * g[i][2];
    }
    let unit = none.lt(size).select((count / size).sqrt(), none);
    let mut h = [[none; 3]; 4];
    for i in 0..4 {
        g[i][1] = g[i][1] * unit;
        g[i][2] = g[i][2] * unit;
    }
    for i in 0..4 {
        for m in 0..3 {
            h[i][m] = k[i][0] * g[0][m] + k[i][1] * g[1][m] + k[i][2] * g[2][m] + k[i][3] * g[3][m];
        }
    }
    let mut a = [[none; 3]; 3];
    let mut b = [none; 3];
    for m in 0..3 {
        for l in 0..=m {
            a[m][l] = g[0][m] * h[0][l] + g[1][m] * h[1][l] + g[2][m] * h[2][l] + g[3][m] * h[3][l];
        }
        b[m] = g[0][m] * c[0] + g[1][m] * c[1] + g[2][m] * c[2] + g[3][m] * c[3];
    }
    // Without points, or where nothing can move, there must be something to divide by.
    let blunt = a[0][0] * L::splat(BLUNT);
    let first = none.lt(a[0][0]).select(a[0][0], one);
    let blunt = none.lt(a[0][0]).select(blunt, one);
    let mass = Symmetric {
        along: Vector::new(first, a[1][1] + blunt, a[2][2] + blunt),
        across: Vector::new(a[1][0], a[2][0], a[2][1]),
    };
    let (mu, _) = mass.solve(Vector::new(b[0], b[1], b[2]));
    let mut force = [none; 4];
    let mut pulls = none;
    for i in 0..4 {
        let f = g[i][0] * mu.x + g[i][1] * mu.y + g[i][2] * mu.z;
        pulls = pulls.or(f.lt(none));
        force[i] = f.max(none);
    }
    // A point that was outside may have been pressed in.
    for i in 0..4 {
        let left = c[i] - moved(k, i, &force);
        let outside = c[i].le(none);
        pulls = pulls.or(outside.and(none.lt(left)));
    }
    if pulls.any() {
        one_by_one(k, c, pulls, &mut force);
    }
    force
}

/// Gauss and Seidel's way, where a mask is set.
#[inline(always)]
fn one_by_one<L: Lanes>(k: &[[L; 4]; 4], c: [L; 4], mask: L, force: &mut [L; 4]) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut inverse = [none; 4];
    for i in 0..4 {
        inverse[i] = mask.and(none.lt(k[i][i])).and(one / k[i][i]);
    }
    for _ in 0..ROUNDS {
        for i in 0..4 {
            let left = c[i] - moved(k, i, force);
            force[i] = (force[i] + left * inverse[i]).max(none);
        }
    }
}

/// How far the forces move a point.
#[inline(always)]
fn moved<L: Lanes>(k: &[[L; 4]; 4], i: usize, force: &[L; 4]) -> L {
    k[i][0] * force[0] + k[i][1] * force[1] + k[i][2] * force[2] + k[i][3] * force[3]
}

/// What stops sliding `(x, y)` and twisting `z` at once, as far as Coulomb lets it: `limit` along the patch, `limit · radius` about its normal, and
/// of both together what is within the ellipse of the two. And which part of the limit that is.
#[inline(always)]
pub(super) fn hold<L: Lanes>(
    k: &Symmetric<L>,
    slid: Vector<L>,
    limit: L,
    radius: L,
) -> (Vector<L>, L) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let slides = none.lt(limit).and(none.lt(k.along.x)).and(none.lt(k.along.y));
    // A point, and what cannot be turned that way, has no twist.
    let twists = none
        .lt(radius)
        .and((L::splat(1e-6) * (k.along.x + k.along.y)).lt(k.along.z * radius * radius));
    let k = Symmetric {
        along: Vector::new(
            slides.select(k.along.x, one),
            slides.select(k.along.y, one),
            twists.and(slides).select(k.along.z, one),
        ),
        across: Vector::new(slides.and(k.across.x), twists.and(k.across.y), twists.and(k.across.z)),
    };
    let (f, pivot) = k.solve(Vector::new(-slid.x, -slid.y, -twists.and(slid.z)));
    let limit = slides.select(limit, one);
    let (along, about) =
        ((f.x * f.x + f.y * f.y).sqrt() / limit, twists.and(f.z / (limit * radius)));
    let much = (along * along + about * about).sqrt();
    let good = slides.and(none.lt(pivot));
    let scale = good.and(one.lt(much).select(one / much, one));
    (f * scale, good.and(much.min(one)))
}
