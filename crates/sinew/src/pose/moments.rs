//! Sums over particles, eight at a time: of their masses, of what those have for first and second moments about a point, and of the momenta that they have, or are
//! given. What they do as a whole follows from these.

use glam::DVec3;

use crate::lanes::{Doubles, LANES, Vector};

/// Such sums: eight side by side, or one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments<N> {
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

impl<D: Doubles> Moments<D> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let zero = Vector::double(DVec3::ZERO);
        Self {
            mass: zero.x,
            first: zero,
            squares: zero,
            products: zero,
            momentum: zero,
            angular: zero,
        }
    }

    /// Adds eight masses, where they are and how fast.
    #[inline(always)]
    pub(crate) fn add(&mut self, m: D, r: Vector<D>, v: Vector<D>) {
        let (weighed, moved) = (r * m, v * m);
        self.mass = self.mass + m;
        self.first += weighed;
        self.squares += weighed.times(r);
        self.products += weighed.times(Vector { x: r.y, y: r.z, z: r.x });
        self.momentum += moved;
        self.angular += r.cross(moved);
    }
}

impl Moments<f64> {
    pub(crate) const NONE: Self = {
        let zero = Vector { x: 0.0, y: 0.0, z: 0.0 };
        Self {
            mass: 0.0,
            first: zero,
            squares: zero,
            products: zero,
            momentum: zero,
            angular: zero,
        }
    };

    /// Adds those of all lanes, the lowest first.
    #[inline(always)]
    pub(crate) fn add_lanes<D: Doubles>(&mut self, sums: &Moments<D>) {
        let Moments { mass, first, squares, products, momentum, angular } = sums;
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
