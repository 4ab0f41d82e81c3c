//! The pressure of a fluid at rest on one triangle, cut at the waterline: exact, and a function of the three depths alone.
//!
//! Pressure grows with depth: `p = ρ g s`, with `s` the depth of a point, which is linear over a triangle, and nothing above the surface. With
//! the barycentric coordinates `λ = (λ₀, λ₁, λ₂)` of a point, `Σ λ = 1`, and the vector area `A` (half the cross product of two edges, pointing
//! out), the force is `-ρ g A W` in all and `-ρ g A Wₖ` on corner `k`, where
//!
//! ```text
//! Wₖ = 1/‖A‖ ∫wetted s λₖ dA      metres
//! ```
//!
//! Spread this way it has the moment of the pressure, too, about any point: `x = Σ λₖ xₖ`, so `∫ x s dA = ‖A‖ Σ xₖ Wₖ`.
//!
//! **Wholly under.** Over a triangle the mean of `λⱼ λₖ` is 1/12, twice that for `j = k`. So with `s = Σ sⱼ λⱼ`,
//!
//! ```text
//! Wₖ = (s₀ + s₁ + s₂ + sₖ)/12
//! ```
//!
//! **One corner under**, say 0. The waterline crosses its edges at the shares `t₁ = s₀/(s₀ - s₁)` and `t₂ = s₀/(s₀ - s₂)` of their length. What is
//! under is a triangle of the share `t₁ t₂` of the area, with the depths `(s₀, 0, 0)`, and the formula above in its own coordinates, carried over
//! to those of the whole, gives
//!
//! ```text
//! W = t₁ t₂ s₀/12 · (4 - t₁ - t₂, t₁, t₂)
//! ```
//!
//! **Two under.** The integrand is a polynomial, over the whole triangle given by the first formula whatever the signs; what is over the part
//! above the surface is the second one, with a negative depth; the difference is what is under.

/// How one triangle stands in the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wetting {
    /// `Wₖ`, metres: the share of each corner in the mean depth.
    pub weights: [f64; 3],
    /// Share of the area that is under the surface, 0 to 1.
    pub share: f64,
}

/// The wetting of a triangle whose corners are at these depths, metres, positive under the surface. Nothing if one of them is not finite.
pub(super) fn wetting(depth: [f64; 3]) -> Wetting {
    if !depth.iter().all(|s| s.is_finite()) {
        return Wetting::default();
    }
    let under = depth.map(|s| s > 0.0);
    match under {
        [false, false, false] => Wetting::default(),
        [true, true, true] => whole(depth),
        [a, b, c] => {
            // The corner that is alone on its side.
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

/// The part that the waterline cuts off at corner `k`. Of the corner and the other two, one side is under and the other is not: no depth equals
/// `s`, and nothing is divided by zero.
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

    /// The integrals by a fine grid of small triangles, each taken at its middle.
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
