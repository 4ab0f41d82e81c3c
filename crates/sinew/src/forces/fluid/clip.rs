//! The pressure of a fluid at rest on one triangle, clipped at the waterline: exact, and a function of the three depths alone.
//!
//! The pressure grows with depth, `p = ρ g s`, where the depth `s` of a point is linear over a triangle; it is zero above the surface. With the barycentric
//! coordinates `λ = (λ₀, λ₁, λ₂)` of a point, `Σ λ = 1`, and the vector area `A` (half the cross product of two edges, pointing outward), the total force is
//! `-ρ g A W` and the part on corner `k` is `-ρ g A Wₖ`, where
//!
//! ```text
//! Wₖ = 1/‖A‖ ∫wetted s λₖ dA      metres
//! ```
//!
//! Distributed this way the force also has the moment of the pressure about any point: `x = Σ λₖ xₖ`, so `∫ x s dA = ‖A‖ Σ xₖ Wₖ`.
//!
//! **Fully submerged.** Over a triangle the mean of `λⱼ λₖ` is 1/12, twice that for `j = k`. So with `s = Σ sⱼ λⱼ`,
//!
//! ```text
//! Wₖ = (s₀ + s₁ + s₂ + sₖ)/12
//! ```
//!
//! **One corner submerged**, say 0. The waterline cuts its edges at the shares `t₁ = s₀/(s₀ - s₁)` and `t₂ = s₀/(s₀ - s₂)` of their length. The wetted part is
//! a triangle with the share `t₁ t₂` of the area and the depths `(s₀, 0, 0)`. The formula above in its own coordinates, converted to those of the whole
//! triangle, gives
//!
//! ```text
//! W = t₁ t₂ s₀/12 · (4 - t₁ - t₂, t₁, t₂)
//! ```
//!
//! **Two corners submerged.** The integrand is a polynomial, and the first formula gives its integral over the whole triangle whatever the signs. The second
//! formula, with a negative depth, gives the part above the surface; the difference is the wetted part.

/// The result of clipping one triangle at the waterline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wetting {
    /// `Wₖ`, metres: the part of each corner in the mean depth.
    pub weights: [f64; 3],
    /// Share of the area that is submerged, 0 to 1.
    pub share: f64,
}

/// The wetting of a triangle with these corner depths, metres, positive below the surface. Zero if one of them is not finite.
pub(super) fn wetting(depth: [f64; 3]) -> Wetting {
    if !depth.iter().all(|s| s.is_finite()) {
        return Wetting::default();
    }
    let under = depth.map(|s| s > 0.0);
    match under {
        [false, false, false] => Wetting::default(),
        [true, true, true] => whole(depth),
        [a, b, c] => {
            // The corner that is the only one on its side of the waterline.
            let one_under = u8::from(a) + u8::from(b) + u8::from(c) == 1;
            let alone = (0..3).find(|&k| under[k] == one_under).unwrap_or(0);
            let tip = tip(depth, alone);
            if one_under { tip } else { whole(depth).without(tip) }
        }
    }
}

impl Wetting {
    fn without(self, part: Self) -> Self {
        Self {
            weights: core::array::from_fn(|k| self.weights[k] - part.weights[k]),
            share: self.share - part.share,
        }
    }
}

fn whole(depth: [f64; 3]) -> Wetting {
    let sum = depth[0] + depth[1] + depth[2];
    Wetting { weights: depth.map(|s| (sum + s) / 12.0), share: 1.0 }
}

/// The part that the waterline cuts off at corner `k`. That corner and the other two are on different sides, so no other depth equals `s`, and there is no
/// division by zero.
fn tip(depth: [f64; 3], k: usize) -> Wetting {
    let (next, last) = ((k + 1) % 3, (k + 2) % 3);
    let s = depth[k];
    let (t, u) = (s / (s - depth[next]), s / (s - depth[last]));
    let share = t * u;
    let unit = share * s / 12.0;
    let mut weights = [0.0; 3];
    weights[k] = unit * (4.0 - t - u);
    weights[next] = unit * t;
    weights[last] = unit * u;
    Wetting { weights, share }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integrals by a fine grid of small triangles, each evaluated at its centre.
    fn by_quadrature(depth: [f64; 3]) -> Wetting {
        const N: i32 = 600;
        let mut sum = Wetting::default();
        let mut add = |i: f64, j: f64| {
            let l = [i, j, f64::from(N) - i - j].map(|x| x / f64::from(N));
            let s = depth[0] * l[0] + depth[1] * l[1] + depth[2] * l[2];
            if s > 0.0 {
                let area = 1.0 / f64::from(N * N);
                (0..3).for_each(|k| sum.weights[k] += s * l[k] * area);
                sum.share += area;
            }
        };
        for i in 0..N {
            for j in 0..N - i {
                add(f64::from(i) + 1.0 / 3.0, f64::from(j) + 1.0 / 3.0);
                if i + j + 1 < N {
                    add(f64::from(i) + 2.0 / 3.0, f64::from(j) + 2.0 / 3.0);
                }
            }
        }
        sum
    }

    #[test]
    fn the_weights_are_the_integrals_however_the_triangle_is_cut() {
        let cases = [
            [1.0, 2.0, 0.5],
            [1.0, -2.0, -0.5],
            [-1.0, 2.0, -0.5],
            [-0.3, -2.0, 0.7],
            [1.0, 2.0, -0.5],
            [-3.0, 2.0, 0.5],
            [0.1, -2.0, 0.5],
            [0.0, 0.0, 1.0],
            [0.0, -1.0, 1.0],
            [0.0, 1.0, 1.0],
        ];
        for depth in cases {
            let (exact, summed) = (wetting(depth), by_quadrature(depth));
            assert!((exact.share - summed.share).abs() < 2e-3, "{depth:?}");
            for k in 0..3 {
                assert!(
                    (exact.weights[k] - summed.weights[k]).abs() < 1e-5,
                    "{depth:?}: {exact:?} {summed:?}"
                );
            }
        }
    }

    #[test]
    fn a_dry_or_broken_triangle_feels_nothing() {
        let dry = Wetting::default();
        for depth in [[0.0; 3], [-1.0, 0.0, -2.0], [f64::NAN, 1.0, 1.0], [f64::INFINITY, 1.0, -1.0]]
        {
            assert_eq!(wetting(depth), dry, "{depth:?}");
        }
    }

    #[test]
    fn what_is_under_and_what_is_above_make_the_whole() {
        for depth in [[1.0, -2.0, -0.5], [1e-12, 3.0, -4.0], [5.0, 1e-300, -1e-300]] {
            let (under, above) = (wetting(depth), wetting(depth.map(|s| -s)));
            assert!((under.share + above.share - 1.0).abs() < 1e-12);
            for k in 0..3 {
                let both = under.weights[k] - above.weights[k];
                assert!((both - whole(depth).weights[k]).abs() < 1e-12);
            }
        }
    }
}
