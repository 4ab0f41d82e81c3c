//! Sums over particles, eight at a time: masses, first and second moments about a point, momenta. The motion of the particles as a whole follows from them.

use crate::lanes::{Arithmetic, Doubles, LANES, Vector};

/// The sums, in eight lanes or as one number each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MomentSums<N> {
    /// `Σ m`.
    pub(crate) mass: N,
    /// `Σ m r`.
    pub(crate) first: Vector<N>,
    /// `Σ m x²`, `Σ m y²`, `Σ m z²`.
    pub(crate) squares: Vector<N>,
    /// `Σ m x y`, `Σ m y z`, `Σ m z x`.
    pub(crate) products: Vector<N>,
    /// `Σ m v`.
    pub(crate) momentum: Vector<N>,
    /// `Σ r × m v`.
    pub(crate) angular: Vector<N>,
}

impl<N: Arithmetic> MomentSums<N> {
    /// All sums zero.
    #[inline(always)]
    const fn all(zero: N) -> Self {
        let vector = Vector { x: zero, y: zero, z: zero };
        Self {
            mass: zero,
            first: vector,
            squares: vector,
            products: vector,
            momentum: vector,
            angular: vector,
        }
    }

    /// Adds a particle, or eight: masses, positions and velocities.
    #[inline(always)]
    pub(crate) fn add(&mut self, m: N, r: Vector<N>, v: Vector<N>) {
        let (weighed, moved) = (r * m, v * m);
        self.mass = self.mass + m;
        self.first += weighed;
        self.squares += weighed.times(r);
        self.products += weighed.times(Vector { x: r.y, y: r.z, z: r.x });
        self.momentum += moved;
        self.angular += r.cross(moved);
    }

    /// The barycentre and its velocity.
    #[inline(always)]
    pub(crate) fn means(&self) -> [Vector<N>; 2] {
        [self.first / self.mass, self.momentum / self.mass]
    }

    /// Inertia and angular momentum about the barycentre.
    #[inline(always)]
    pub(crate) fn about(&self, barycentre: Vector<N>) -> ([[N; 3]; 3], Vector<N>) {
        let (c, m) = (barycentre, self.mass);
        let s = self.squares - c.times(c) * m;
        let p = self.products - c.times(Vector { x: c.y, y: c.z, z: c.x }) * m;
        let inertia = [[s.y + s.z, -p.x, -p.z], [-p.x, s.z + s.x, -p.y], [-p.z, -p.y, s.x + s.y]];
        (inertia, self.angular - c.cross(self.momentum))
    }
}

impl<D: Doubles> MomentSums<D> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        Self::all(D::splat(0.0))
    }
}

impl MomentSums<f64> {
    pub(crate) const NONE: Self = Self::all(0.0);

    /// Adds the sums of all lanes, lowest lane first.
    #[inline(always)]
    pub(crate) fn add_lanes<D: Doubles>(&mut self, sums: &MomentSums<D>) {
        let MomentSums { mass, first, squares, products, momentum, angular } = sums;
        add_all(&mut self.mass, *mass);
        let own = [
            (&mut self.first, first),
            (&mut self.squares, squares),
            (&mut self.products, products),
            (&mut self.momentum, momentum),
            (&mut self.angular, angular),
        ];
        for (sum, lanes) in own {
            add_all(&mut sum.x, lanes.x);
            add_all(&mut sum.y, lanes.y);
            add_all(&mut sum.z, lanes.z);
        }
    }
}

#[inline(always)]
fn add_all<D: Doubles>(sum: &mut f64, lanes: D) {
    let mut numbers = [0.0; LANES];
    lanes.store(&mut numbers);
    for number in numbers {
        *sum += number;
    }
}
