//! Small symmetric matrices: linear solve and eigendecomposition.

use glam::DVec3;

use crate::lanes::{Arithmetic, Vector};

/// Condition bound above which [`solve`] gives up: compounds longer than about 1000 times their width.
pub(crate) const MAX_CONDITION: f64 = 1e6;

/// `x = K⁻¹ b` and a bound on the condition number of `K`, `tr(K) tr(K⁻¹)` (9 at best), if `K` is positive definite and well conditioned. By cofactors, which
/// also decide that (Sylvester's criterion).
pub(crate) fn solve(k: &[[f64; 3]; 3], b: DVec3) -> Option<(DVec3, f64)> {
    let Cofactors { x, minors: [first, second, determinant], traces } = cofactors(k, b.into());
    // Written so that NaN gives `None`. Products of tiny numbers may underflow to zero: that gives `None` as well.
    if first > 0.0 && second > 0.0 && determinant > 0.0 && traces <= MAX_CONDITION * determinant {
        let inverse = 1.0 / determinant;
        Some((DVec3::from(x) * inverse, traces * inverse))
    } else {
        None
    }
}

/// Solution of `K x = b` by cofactors, before the division by the determinant.
pub(crate) struct Cofactors<N> {
    /// `x det(K)`.
    pub(crate) x: Vector<N>,
    /// The leading principal minors, the determinant last. `K` is positive definite if all are positive.
    pub(crate) minors: [N; 3],
    /// `tr(K) tr(K⁻¹) det(K)`.
    pub(crate) traces: N,
}

/// The solution for one matrix, or for eight.
#[inline(always)]
pub(crate) fn cofactors<N: Arithmetic>(k: &[[N; 3]; 3], b: Vector<N>) -> Cofactors<N> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = *k;
    let (cxx, cyy, czz) = (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
    let (cxy, cxz, cyz) = (xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz);
    let determinant = xx * cxx + xy * cxy + xz * cxz;
    let traces = (xx + yy + zz) * (cxx + cyy + czz);
    let x = Vector {
        x: cxx * b.x + cxy * b.y + cxz * b.z,
        y: cxy * b.x + cyy * b.y + cyz * b.z,
        z: cxz * b.x + cyz * b.y + czz * b.z,
    };
    Cofactors { x, minors: [xx, czz, determinant], traces }
}

/// Eigenvalues and unit eigenvectors (one per row) of a symmetric matrix, in no particular order, by Jacobi's method: rotates one off-diagonal element after
/// the other to zero; what this adds to the others vanishes quadratically (Golub, Van Loan, *Matrix Computations*, 8.5). Slow for large matrices, the most
/// accurate for small ones.
pub(crate) fn eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut vectors = [[0.0; N]; N];
    for (i, v) in vectors.iter_mut().enumerate() {
        v[i] = 1.0;
    }
    // Five or six sweeps are enough; the bound is for non-finite input.
    for _ in 0..20 {
        let (mut off, mut all) = (0.0, 0.0);
        for (p, row) in a.iter().enumerate() {
            all += row[p] * row[p];
            off += row[p + 1..].iter().map(|x| x * x).sum::<f64>();
        }
        if off <= 1e-36 * all {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                if a[p][q] == 0.0 {
                    continue;
                }
                // tan φ of the smaller of the two rotations that zero a[p][q].
                let half = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let tan = 1.0_f64.copysign(half) / (half.abs() + (1.0 + half * half).sqrt());
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                let sin = tan * cos;
                let shift = tan * a[p][q];
                a[p][p] -= shift;
                a[q][q] += shift;
                a[p][q] = 0.0;
                a[q][p] = 0.0;
                for i in 0..N {
                    if i != p && i != q {
                        let (ip, iq) = (a[i][p], a[i][q]);
                        a[i][p] = cos * ip - sin * iq;
                        a[i][q] = sin * ip + cos * iq;
                        a[p][i] = a[i][p];
                        a[q][i] = a[i][q];
                    }
                    let (vp, vq) = (vectors[p][i], vectors[q][i]);
                    vectors[p][i] = cos * vp - sin * vq;
                    vectors[q][i] = sin * vp + cos * vq;
                }
            }
        }
    }
    (std::array::from_fn(|i| a[i][i]), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_positive_definite_or_nearly_singular_or_nan_is_declined() {
        let diagonal = |x, y, z| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
        assert_eq!(
            solve(&diagonal(1.0, 2.0, 4.0), DVec3::ONE),
            Some((DVec3::new(1.0, 0.5, 0.25), 12.25))
        );
        for (x, y, z) in [
            (1.0, 1.0, -1.0),
            (-1.0, -1.0, 1.0),
            (1.0, -1.0, -1.0),
            (1.0, 1.0, 1e-7),
            (0.0, 0.0, 0.0),
            (1.0, f64::NAN, 1.0),
        ] {
            assert_eq!(solve(&diagonal(x, y, z), DVec3::ONE), None, "{x} {y} {z}");
        }
    }

    #[test]
    fn the_eigenpairs_make_the_matrix_again_also_when_some_are_equal() {
        let a = [
            [2.0, -1.0, 0.5, 0.25],
            [-1.0, 2.0, 0.5, 0.25],
            [0.5, 0.5, -3.0, 0.0],
            [0.25, 0.25, 0.0, 2.0],
        ];
        let ones = [[1.0; 4]; 4];
        let huge = ones.map(|row| row.map(|x| x * 1e100));
        for a in [a, ones, huge, [[0.0; 4]; 4]] {
            let (values, vectors) = eigen(a);
            for i in 0..4 {
                for j in 0..4 {
                    let scale = a[0][0].max(1e-300);
                    let made: f64 = (0..4).map(|k| values[k] * vectors[k][i] * vectors[k][j]).sum();
                    let dot: f64 = (0..4).map(|k| vectors[i][k] * vectors[j][k]).sum();
                    assert!((made - a[i][j]).abs() <= 1e-14 * scale);
                    assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-14);
                }
            }
        }
    }
}
