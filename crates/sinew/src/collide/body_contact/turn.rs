//! Rotations, symmetric matrices and tangents of eight body colliders in lanes.

pub(super) use crate::lanes::{LaneArray, set};
use crate::lanes::{Lanes, Vector};

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

/// The zero vector in each lane.
#[inline(always)]
pub(super) fn zero<L: Lanes>() -> Vector<L> {
    Vector::new(L::zero(), L::zero(), L::zero())
}

/// A matrix in each lane, by columns.
#[derive(Clone, Copy)]
pub(super) struct Matrix<L> {
    pub(super) x: Vector<L>,
    pub(super) y: Vector<L>,
    pub(super) z: Vector<L>,
}

impl<L: Lanes> Matrix<L> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self { x: zero(), y: zero(), z: zero() }
    }

    /// The rotation of a unit quaternion.
    #[inline(always)]
    pub(super) fn of([x, y, z, w]: [L; 4]) -> Self {
        let (one, x2, y2, z2) = (L::splat(1.0), x + x, y + y, z + z);
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
    pub(super) fn times(&self, v: Vector<L>) -> Vector<L> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// Adds `a bᵀ`.
    #[inline(always)]
    pub(super) fn add_outer(&mut self, a: Vector<L>, b: Vector<L>) {
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
    pub(super) fn transposed_times_vector(&self, v: Vector<L>) -> Vector<L> {
        Vector::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// `v` with `selfᵀ - self = [v]`, twice the axial vector: `Σ b × a` of a sum of `a bᵀ`.
    #[inline(always)]
    pub(super) fn twice_axial(&self) -> Vector<L> {
        Vector::new(self.y.z - self.z.y, self.z.x - self.x.z, self.x.y - self.y.x)
    }

    /// Solves `self · x = b` by elimination in the order of the columns, without pivoting; that is safe where the symmetric part is positive definite.
    #[inline(always)]
    pub(super) fn solve(&self, b: Vector<L>) -> Vector<L> {
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

/// A symmetric matrix in each lane: `along` has its diagonal xx, yy, zz.
#[derive(Clone, Copy)]
pub(super) struct Symmetric<L> {
    pub(super) along: Vector<L>,
    /// Of xy, xz, yz.
    pub(super) across: Vector<L>,
}

impl<L: Lanes> Symmetric<L> {
    #[inline(always)]
    pub(super) fn load([xx, yy, zz, xy, xz, yz]: &[LaneArray; 6]) -> Self {
        Self {
            along: Vector::new(L::load(xx), L::load(yy), L::load(zz)),
            across: Vector::new(L::load(xy), L::load(xz), L::load(yz)),
        }
    }

    #[inline(always)]
    pub(super) fn times(&self, v: Vector<L>) -> Vector<L> {
        let Self { along: a, across: c } = *self;
        Vector::new(
            a.x * v.x + c.x * v.y + c.y * v.z,
            c.x * v.x + a.y * v.y + c.z * v.z,
            c.y * v.x + c.z * v.y + a.z * v.z,
        )
    }

    /// `R self Rᵀ v`: for an inertia in body axes, the angular momentum of an angular velocity in world axes.
    #[inline(always)]
    pub(super) fn times_turned(&self, r: &Matrix<L>, v: Vector<L>) -> Vector<L> {
        r.times(self.times(r.transposed_times_vector(v)))
    }

    /// `R self Rᵀ`.
    #[inline(always)]
    pub(super) fn turned(&self, r: &Matrix<L>) -> Self {
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
    pub(super) fn solve(&self, b: Vector<L>) -> (Vector<L>, L) {
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
