//! The few unknowns of one manifold, solved together: how hard each of its four points presses, and how friction answers. Eight manifolds side by
//! side.
//!
//! # Pressing
//!
//! With `λ` the impulses along the normal (in kg·m, since positions are moved), `K` how far each of them moves each point, and `c` how far in the
//! points are, wanted is
//! `λ ≥ 0` with `K λ ≥ c`, where one of the two is an equality. Four points in a plane move as a rigid plane does, so `K` has rank 3, and if one
//! point were solved after the other, a box at rest would rock from corner to corner. So the points that are in are solved at once, for a pressure
//! that is linear over the patch, `λ = G μ` with rows `g = (1, x, y)` of
//! `G`: `Gᵀ K G μ = Gᵀ c`. That is exact for up to three points and symmetric for four. Where it would pull, the points are solved one after the
//! other after all, a few times over, with the sum of each kept from pulling.
//!
//! `K` is never written out. An impulse along the normal at `(x, y)` has the moment `y t - x u` about a centre, with `t` and `u` across the normal:
//! it is linear in `g`. So `K = G Q Gᵀ` with one 3×3 matrix `Q` of the pair ([`ContactPatch::about`]), and with the points measured from the middle
//! of those that are in, `S = Gᵀ G` is a number and a 2×2 block: `Gᵀ K G = S Q S`.

use super::turn::Symmetric;
use crate::lanes::{Lanes, Vector};

/// Rounds of solving point after point. What is left is corrected in the next substep.
const ROUNDS: usize = 6;
/// Share of the stiffness that patches have added, so that a small one, whose tilt is round-off, does not answer that.
const TILT_REGULARISATION: f32 = 1e-3;

/// How two bodies give way to impulses along the normal of a patch.
pub(super) struct ContactPatch<L> {
    /// Sum of their inverse masses, 1/kg.
    pub(super) weight: L,
    pub(super) a: PatchSide<L>,
    /// `None` where nothing moves it.
    pub(super) b: Option<PatchSide<L>>,
    /// Where the second one's centre is from the first one's, along `t` and `u`, metres.
    pub(super) apart: (L, L),
}

/// One of the bodies: its inverse inertia `J` as seen in the patch.
pub(super) struct PatchSide<L> {
    /// `J t` and `J u`.
    t: Vector<L>,
    u: Vector<L>,
    /// `t·J t`, `u·J u`, `t·J u`, 1/(kg·m²).
    tt: L,
    uu: L,
    tu: L,
}

impl<L: Lanes> PatchSide<L> {
    #[inline(always)]
    pub(super) fn of(inverse_inertia: &Symmetric<L>, t: Vector<L>, u: Vector<L>) -> Self {
        let (jt, ju) = (inverse_inertia.times(t), inverse_inertia.times(u));
        Self { t: jt, u: ju, tt: t.dot(jt), uu: u.dot(ju), tu: t.dot(ju) }
    }

    /// The turn that an impulse of so much along the normal gives, whose moments along `x` and `y` from this centre are those.
    #[inline(always)]
    pub(super) fn turned(&self, x: L, y: L) -> Vector<L> {
        self.t * y - self.u * x
    }

    /// Adds its share to `Q` about a point at `(x, y)` from its centre.
    #[inline(always)]
    fn add_to(&self, q: &mut Symmetric<L>, x: L, y: L) {
        let along = (x * self.uu - y * self.tu, y * self.tt - x * self.tu);
        q.along.x = q.along.x + (x * along.0 + y * along.1);
        q.along.y = q.along.y + self.uu;
        q.along.z = q.along.z + self.tt;
        q.across.x = q.across.x + along.0;
        q.across.y = q.across.y + along.1;
        q.across.z = q.across.z - self.tu;
    }
}

impl<L: Lanes> ContactPatch<L> {
    /// `Q` about the point at `(x, y)` from the first one's centre: how far impulses with sum and moments `Gᵀ λ` move such planes.
    #[inline(always)]
    pub(super) fn about(&self, x: L, y: L) -> Symmetric<L> {
        let none = L::zero();
        let mut q = Symmetric {
            along: Vector::new(self.weight, none, none),
            across: Vector::new(none, none, none),
        };
        self.a.add_to(&mut q, x, y);
        if let Some(b) = &self.b {
            b.add_to(&mut q, x - self.apart.0, y - self.apart.1);
        }
        q
    }
}

/// The impulses that put some points outside, which are at such places `(x, y)` from the first one's centre, metres. Points that are missing are far
/// outside: with or without them, the others get the same bits.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "points in several arrays")]
pub(super) fn solve_normal_impulses<L: Lanes, const POINTS: usize>(
    patch: &ContactPatch<L>,
    c: &[L; POINTS],
    at: &[(L, L); POINTS],
) -> [L; POINTS] {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut inside = [none; POINTS];
    let (mut x, mut y, mut count) = (none, none, none);
    for i in 0..POINTS {
        inside[i] = none.lt(c[i]);
        count = count + inside[i].and(one);
        x = x + inside[i].and(at[i].0);
        y = y + inside[i].and(at[i].1);
    }
    let share = none.lt(count).select(one / count, none);
    let (x, y) = (x * share, y * share);
    let q = patch.about(x, y);
    // S, and Gᵀ c.
    let (mut xx, mut yy, mut xy) = (none, none, none);
    let mut b = Vector::new(none, none, none);
    let g = centred(at, &inside, (x, y), share);
    for i in 0..POINTS {
        let (dx, dy) = g[i];
        let (ix, iy) = (inside[i].and(dx), inside[i].and(dy));
        xx = xx + ix * ix;
        yy = yy + iy * iy;
        xy = xy + ix * iy;
        b.x = b.x + inside[i].and(c[i]);
        b.y = b.y + ix * c[i];
        b.z = b.z + iy * c[i];
    }
    let (qx, qy) = (q.across.x, q.across.y);
    let (ax, ay) = (xx * q.along.y + xy * q.across.z, xx * q.across.z + xy * q.along.z);
    let (bx, by) = (xy * q.along.y + yy * q.across.z, xy * q.across.z + yy * q.along.z);
    // Without points, or where nothing can move, there must be something to divide by.
    let pressing = count * count * q.along.x;
    let pressing = none.lt(pressing).select(pressing, one);
    let size = (xx + yy) * share;
    let torsional_radius =
        none.lt(size).select(pressing * L::splat(TILT_REGULARISATION) * size, one);
    let mass = Symmetric {
        along: Vector::new(
            pressing,
            ax * xx + ay * xy + torsional_radius,
            bx * xy + by * yy + torsional_radius,
        ),
        across: Vector::new(
            count * (qx * xx + qy * xy),
            count * (qx * xy + qy * yy),
            ax * xy + ay * yy,
        ),
    };
    let (mu, _) = mass.solve(b);
    let mut force = [none; POINTS];
    let mut pulls = none;
    let mut sums = Vector::new(none, none, none);
    for i in 0..POINTS {
        let f = inside[i].and(mu.x + g[i].0 * mu.y + g[i].1 * mu.z);
        pulls = pulls.or(f.lt(none));
        force[i] = f.max(none);
        sums.x = sums.x + force[i];
        sums.y = sums.y + force[i] * g[i].0;
        sums.z = sums.z + force[i] * g[i].1;
    }
    // A point that was outside may have been pressed in.
    let moved = q.times(sums);
    for i in 0..POINTS {
        let left = c[i] - (moved.x + g[i].0 * moved.y + g[i].1 * moved.z);
        let outside = c[i].le(none);
        pulls = pulls.or(outside.and(none.lt(left)));
    }
    if pulls.any() {
        one_by_one(&q, &g, c, pulls, &mut force);
    }
    force
}

/// Where points are from the middle of those inside, which has been reckoned but for round-off. That is nothing to a patch, but all to one whose
/// points are as near each other as it is: so it is taken off once more.
#[inline(always)]
fn centred<L: Lanes, const POINTS: usize>(
    at: &[(L, L); POINTS],
    inside: &[L; POINTS],
    (x, y): (L, L),
    share: L,
) -> [(L, L); POINTS] {
    let mut off = *at;
    let (mut more, mut and_more) = (L::zero(), L::zero());
    // No `map`: its closure is not made for the processor that it runs on, and is called for each operation.
    for (off, inside) in off.iter_mut().zip(inside) {
        *off = (off.0 - x, off.1 - y);
        more = more + inside.and(off.0);
        and_more = and_more + inside.and(off.1);
    }
    let (more, and_more) = (more * share, and_more * share);
    for off in &mut off {
        *off = (off.0 - more, off.1 - and_more);
    }
    off
}

/// Gauss and Seidel's way, where a mask is set.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "rows and columns of the same points")]
fn one_by_one<L: Lanes, const POINTS: usize>(
    q: &Symmetric<L>,
    g: &[(L, L); POINTS],
    c: &[L; POINTS],
    mask: L,
    force: &mut [L; POINTS],
) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let mut k = [[none; POINTS]; POINTS];
    let mut inverse = [none; POINTS];
    for i in 0..POINTS {
        let far = q.times(Vector::new(one, g[i].0, g[i].1));
        for j in 0..=i {
            k[i][j] = far.x + far.y * g[j].0 + far.z * g[j].1;
            k[j][i] = k[i][j];
        }
        inverse[i] = mask.and(none.lt(k[i][i])).and(one / k[i][i]);
    }
    for _ in 0..ROUNDS {
        for i in 0..POINTS {
            // What was changed last is added last: the others are there already.
            let mut others = k[i][i] * force[i];
            for j in [(i + 1) % 4, (i + 2) % 4] {
                if j < POINTS {
                    others = others + k[i][j] * force[j];
                }
            }
            let (last, mut left) = ((i + 3) % 4, c[i] - others);
            if last < POINTS {
                left = left - k[i][last] * force[last];
            }
            force[i] = (force[i] + left * inverse[i]).max(none);
        }
    }
}

/// What stops sliding `(x, y)` and twisting `z` at once, as far as Coulomb lets it: `limit` along the patch, `limit · radius` about its normal, and
/// of both together what is within the ellipse of the two. And which part of the limit that is.
///
/// Where the radius is less than `torsional_radius`, metres, a point holds something. It stops twisting, too, by `limit · torsional_radius` at the
/// most; but what turns on a point is held in its place as if it did not.
#[inline(always)]
pub(super) fn solve_friction<L: Lanes>(
    k: &Symmetric<L>,
    slid: Vector<L>,
    limit: L,
    (radius, torsional_radius): (L, L),
) -> (Vector<L>, L) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let slides = none.lt(limit).and(none.lt(k.along.x)).and(none.lt(k.along.y));
    let is_point = radius.lt(torsional_radius);
    // What cannot be turned that way has no twist.
    let twists = torsional_radius
        .le(radius)
        .and(none.lt(radius))
        .and((L::splat(1e-6) * (k.along.x + k.along.y)).lt(k.along.z * radius * radius));
    let way = -slid.z / k.along.z;
    let most = limit * torsional_radius;
    let twist = is_point.and(slides).and(none.lt(k.along.z)).and(way.max(-most).min(most));
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
    let f = f * scale;
    (Vector::new(f.x, f.y, f.z + good.and(twist)), good.and(much.min(one)))
}

#[cfg(test)]
mod tests;
