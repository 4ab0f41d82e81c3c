//! Rotations, symmetric matrices and tangents, of eight body colliders in lanes or of one.

pub(super) use crate::lanes::{LaneArray, set};
use crate::lanes::{Lanes, Number, Vector};

/// Loads vectors from lane arrays.
#[inline(always)]
pub(super) fn load<L: Lanes>([x, y, z]: &[LaneArray; 3]) -> Vector<L> {
    Vector::new(L::load(x), L::load(y), L::load(z))
}

/// Stores vectors in lane arrays.
#[inline(always)]
pub(super) fn store<L: Lanes>(v: Vector<L>, [x, y, z]: &mut [LaneArray; 3]) {
    v.x.store(x);
    v.y.store(y);
    v.z.store(z);
}

/// The zero vector.
#[inline(always)]
pub(super) fn zero<N: Number>() -> Vector<N> {
    Vector::new(N::zero(), N::zero(), N::zero())
}

/// A matrix, or eight of them, by columns.
#[derive(Clone, Copy)]
pub(super) struct Matrix<N> {
    pub(super) x: Vector<N>,
    pub(super) y: Vector<N>,
    pub(super) z: Vector<N>,
}

impl<N: Number> Matrix<N> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self { x: zero(), y: zero(), z: zero() }
    }

    /// The rotation of a unit quaternion.
    #[inline(always)]
    pub(super) fn of(q: [N; 4]) -> Self {
        Self::scaled(q, N::splat(2.0))
    }

    /// The rotation of a quaternion of nearly unit length, normalised by its square. `1 + 1.2e-7`, the square of a length, has the root 1 in `f32`, so that
    /// normalising by the length would change nothing: particles would be written that much too far out in every step, and their momentum read twice that too
    /// large.
    #[inline(always)]
    pub(super) fn normalised([x, y, z, w]: [N; 4]) -> Self {
        Self::scaled([x, y, z, w], N::splat(2.0) / (x * x + y * y + z * z + w * w))
    }

    /// The rotation of a quaternion; `twice` is two by the square of its length.
    #[inline(always)]
    fn scaled([x, y, z, w]: [N; 4], twice: N) -> Self {
        let (one, x2, y2, z2) = (N::splat(1.0), x * twice, y * twice, z * twice);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        Self {
            x: Vector::new(one - (yy + zz), xy + wz, xz - wy),
            y: Vector::new(xy - wz, one - (xx + zz), yz + wx),
            z: Vector::new(xz + wy, yz - wx, one - (xx + yy)),
        }
    }

    #[inline(always)]
    pub(super) fn times(&self, v: Vector<N>) -> Vector<N> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// Adds `a bᵀ`.
    #[inline(always)]
    pub(super) fn add_outer(&mut self, a: Vector<N>, b: Vector<N>) {
        self.x += a * b.x;
        self.y += a * b.y;
        self.z += a * b.z;
    }

    /// `self · other`.
    #[inline(always)]
    pub(super) fn times_matrix(&self, other: &Self) -> Self {
        Self { x: self.times(other.x), y: self.times(other.y), z: self.times(other.z) }
    }

    /// `selfᵀ · other`.
    #[inline(always)]
    pub(super) fn transposed_times(&self, other: &Self) -> Self {
        Self {
            x: self.transposed_times_vector(other.x),
            y: self.transposed_times_vector(other.y),
            z: self.transposed_times_vector(other.z),
        }
    }

    #[inline(always)]
    pub(super) fn transposed_times_vector(&self, v: Vector<N>) -> Vector<N> {
        Vector::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// `v` with `selfᵀ - self = [v]`, twice the axial vector: `Σ b × a` of a sum of `a bᵀ`.
    #[inline(always)]
    pub(super) fn twice_axial(&self) -> Vector<N> {
        Vector::new(self.y.z - self.z.y, self.z.x - self.x.z, self.x.y - self.y.x)
    }

    /// Solves `self · x = b` by elimination in the order of the columns, without pivoting; that is safe where the symmetric part is positive definite.
    #[inline(always)]
    pub(super) fn solve(&self, b: Vector<N>) -> Vector<N> {
        let Self { x, y, z } = *self;
        let (l1, l2) = (x.y / x.x, x.z / x.x);
        let (d1, u12, l21) = (y.y - l1 * y.x, z.y - l1 * z.x, y.z - l2 * y.x);
        let l21 = l21 / d1;
        let d2 = z.z - l2 * z.x - l21 * u12;
        let b1 = b.y - l1 * b.x;
        let third = (b.z - l2 * b.x - l21 * b1) / d2;
        let second = (b1 - u12 * third) / d1;
        Vector::new((b.x - y.x * second - z.x * third) / x.x, second, third)
    }
}

/// A symmetric matrix, or eight of them: `along` has its diagonal xx, yy, zz.
#[derive(Clone, Copy)]
pub(super) struct Symmetric<N> {
    pub(super) along: Vector<N>,
    /// Of xy, xz, yz.
    pub(super) across: Vector<N>,
}

impl<L: Lanes> Symmetric<L> {
    #[inline(always)]
    pub(super) fn load([xx, yy, zz, xy, xz, yz]: &[LaneArray; 6]) -> Self {
        Self {
            along: Vector::new(L::load(xx), L::load(yy), L::load(zz)),
            across: Vector::new(L::load(xy), L::load(xz), L::load(yz)),
        }
    }
}

impl<N: Number> Symmetric<N> {
    #[inline(always)]
    pub(super) fn times(&self, v: Vector<N>) -> Vector<N> {
        let Self { along: a, across: c } = *self;
        Vector::new(
            a.x * v.x + c.x * v.y + c.y * v.z,
            c.x * v.x + a.y * v.y + c.z * v.z,
            c.y * v.x + c.z * v.y + a.z * v.z,
        )
    }

    /// `R self Rᵀ v`: for an inertia in body axes, the angular momentum of an angular velocity in world axes.
    #[inline(always)]
    pub(super) fn times_turned(&self, r: &Matrix<N>, v: Vector<N>) -> Vector<N> {
        r.times(self.times(r.transposed_times_vector(v)))
    }

    /// `R self Rᵀ`.
    #[inline(always)]
    pub(super) fn turned(&self, r: &Matrix<N>) -> Self {
        let Self { along: a, across: c } = *self;
        let (x, y, z) = (
            r.times(Vector::new(a.x, c.x, c.y)),
            r.times(Vector::new(c.x, a.y, c.z)),
            r.times(Vector::new(c.y, c.z, a.z)),
        );
        // By rows.
        let rx = Vector::new(r.x.x, r.y.x, r.z.x);
        let ry = Vector::new(r.x.y, r.y.y, r.z.y);
        let rz = Vector::new(r.x.z, r.y.z, r.z.z);
        let ax = Vector::new(x.x, y.x, z.x);
        let ay = Vector::new(x.y, y.y, z.y);
        let az = Vector::new(x.z, y.z, z.z);
        Self {
            along: Vector::new(ax.dot(rx), ay.dot(ry), az.dot(rz)),
            across: Vector::new(ax.dot(ry), ax.dot(rz), ay.dot(rz)),
        }
    }

    /// Solves `self · x = b`. Also returns the least pivot: where it is positive, the matrix is positive definite.
    #[inline(always)]
    pub(super) fn solve(&self, b: Vector<N>) -> (Vector<N>, N) {
        let Self { along: a, across: c } = *self;
        let (l1, l2) = (c.x / a.x, c.y / a.x);
        let d1 = a.y - l1 * c.x;
        let u = c.z - l1 * c.y;
        let l3 = u / d1;
        let d2 = a.z - l2 * c.y - l3 * u;
        let b1 = b.y - l1 * b.x;
        let third = (b.z - l2 * b.x - l3 * b1) / d2;
        let second = b1 / d1 - l3 * third;
        let first = b.x / a.x - l1 * second - l2 * third;
        (Vector::new(first, second, third), a.x.min(d1.min(d2)))
    }
}

/// The unit quaternion of a rotation, computed from its greatest component, so that there is no division by a value near zero.
#[inline(always)]
pub(super) fn unit_quaternion<N: Number>(m: &Matrix<N>) -> [N; 4] {
    let (one, Matrix { x, y, z }) = (N::splat(1.0), *m);
    let trace = x.x + y.y + z.z;
    let real = [y.z - z.y, z.x - x.z, x.y - y.x, one + trace];
    let by_x = [one + x.x - y.y - z.z, x.y + y.x, z.x + x.z, real[0]];
    let by_y = [x.y + y.x, one + y.y - x.x - z.z, y.z + z.y, real[1]];
    let by_z = [z.x + x.z, y.z + z.y, one + z.z - x.x - y.y, real[2]];
    let is_real = N::zero().lt(trace);
    let is_x = y.y.le(x.x).and(z.z.le(x.x));
    let is_y = z.z.le(y.y);
    let mut q = [one; 4];
    for i in 0..4 {
        q[i] = is_real.select(real[i], is_x.select(by_x[i], is_y.select(by_y[i], by_z[i])));
    }
    let [x, y, z, w] = q;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let good = N::zero().lt(length).and(length.lt(N::splat(f32::INFINITY)));
    let none = N::zero();
    for (i, q) in q.iter_mut().enumerate() {
        *q = good.select(*q / length, if i == 3 { one } else { none });
    }
    q
}

/// `q` followed, in its own frame, by the rotation of the quaternion `(v, w)` of any length; normalised.
#[inline(always)]
pub(super) fn turn_further<L: Lanes>([x, y, z, s]: [L; 4], v: Vector<L>, w: L) -> [L; 4] {
    let axis = Vector::new(x, y, z);
    let turned = v * s + axis * w + axis.cross(v);
    let real = s * w - axis.dot(v);
    let inverse = L::splat(1.0) / (turned.length_squared() + real * real).sqrt();
    [turned.x * inverse, turned.y * inverse, turned.z * inverse, real * inverse]
}

/// Two unit vectors across `n` and each other (Duff et al., *Building an Orthonormal Basis, Revisited*, 2017).
#[inline(always)]
pub(super) fn tangents<L: Lanes>(n: Vector<L>) -> (Vector<L>, Vector<L>) {
    let (none, one) = (L::zero(), L::splat(1.0));
    let sign = n.z.lt(none).select(-one, one);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    let t = Vector::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x);
    (t, Vector::new(b, sign + n.y * n.y * a, -n.y))
}
