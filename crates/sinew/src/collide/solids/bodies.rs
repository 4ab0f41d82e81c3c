//! Everything that contacts know of what takes part in them, in columns: solids first, eight by eight, then colliders and planes, which nothing
//! moves.

use glam::{Mat3, Vec3, Vec4};

use super::super::Frame;
use super::turn::{Matrix, Symmetric};
use crate::lanes::{Lanes, Vector};

/// Columns; a row for each solid, up to a multiple of eight; then for each collider and each plane; and one for nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    /// `[x y z w]`: how far contacts have moved it in this substep, metres, and its inverse mass, 1/kg.
    pub(super) shift: Vec<Vec4>,
    /// `[x y z m]`: how far they have turned it, rad about each axis; 1 if some of that came of a deep overlap.
    pub(super) turn: Vec<Vec4>,
    /// Inverse inertia in world axes, 1/(kg·m²): xx, yy, zz.
    pub(super) along: Vec<Vec4>,
    /// xy, xz, yz.
    pub(super) across: Vec<Vec4>,
    /// As predicted: a unit quaternion.
    pub(super) rotation: Vec<Vec4>,
    /// Its centre when the substep began, from its origin, metres.
    pub(super) centre: Vec<Vec4>,
    /// How far that has gone since, without contacts, metres.
    pub(super) step: Vec<Vec4>,
    /// How far it has turned since, without contacts: `2 tan(φ/2)` about the axis.
    pub(super) spin: Vec<Vec4>,
}

impl Bodies {
    /// Makes room for so many, none of which moves.
    pub(super) fn resize(&mut self, len: usize) {
        let Self { shift, turn, along, across, rotation, centre, step, spin } = self;
        for column in [shift, turn, along, across, centre, step, spin] {
            column.clear();
            column.resize(len, Vec4::ZERO);
        }
        rotation.clear();
        rotation.resize(len, Vec4::W);
    }

    /// Takes back what contacts have done in this substep.
    pub(super) fn take_back(&mut self) {
        for shift in &mut self.shift {
            *shift = Vec4::new(0.0, 0.0, 0.0, shift.w);
        }
        self.turn.fill(Vec4::ZERO);
    }

    /// Places a row that nothing moves: its frame at the end of a substep, and what it was at its start.
    pub(super) fn place(&mut self, row: usize, start: &Frame, end: &Frame) {
        self.rotation[row] = quaternion(&end.rotation);
        self.step[row] = (end.translation - start.translation).extend(0.0);
        let (x, y, z) = columns_of(&(end.rotation * start.rotation.transpose()));
        let sine = Vec3::new(y.z - z.y, z.x - x.z, x.y - y.x) * 0.5;
        // tan ½φ = sinφ / (1 + cosφ); half a turn in a substep is none that anything could follow.
        let below = (0.5 * (x.x + y.y + z.z + 1.0)).max(1e-3);
        let spin = if start.rotation == end.rotation { Vec3::ZERO } else { sine * (2.0 / below) };
        self.spin[row] = spin.extend(0.0);
    }
}

/// The columns of eight of them.
pub(super) struct Eight<L> {
    pub(super) shift: Vector<L>,
    pub(super) turn: Vector<L>,
    pub(super) inverse_mass: L,
    pub(super) mark: L,
    pub(super) inverse_inertia: Symmetric<L>,
    pub(super) rotation: Matrix<L>,
    pub(super) centre: Vector<L>,
    pub(super) step: Vector<L>,
    pub(super) spin: Vector<L>,
}

impl<L: Lanes> Eight<L> {
    #[inline(always)]
    pub(super) fn load(bodies: &Bodies, rows: &[u32; 8]) -> Self {
        let (shift, inverse_mass) = Vector::of(L::rows(&bodies.shift, rows));
        let (turn, mark) = Vector::of(L::rows(&bodies.turn, rows));
        Self {
            shift,
            inverse_mass,
            turn,
            mark,
            inverse_inertia: Symmetric {
                along: Vector::of(L::rows(&bodies.along, rows)).0,
                across: Vector::of(L::rows(&bodies.across, rows)).0,
            },
            rotation: Matrix::of(L::rows(&bodies.rotation, rows)),
            centre: Vector::of(L::rows(&bodies.centre, rows)).0,
            step: Vector::of(L::rows(&bodies.step, rows)).0,
            spin: Vector::of(L::rows(&bodies.spin, rows)).0,
        }
    }
}

/// The columns of eight of them that friction asks for.
pub(super) struct Sliding<L> {
    pub(super) shift: Vector<L>,
    pub(super) turn: Vector<L>,
    pub(super) inverse_mass: L,
    pub(super) mark: L,
    pub(super) inverse_inertia: Symmetric<L>,
    pub(super) centre: Vector<L>,
    step: Vector<L>,
    pub(super) spin: Vector<L>,
}

impl<L: Lanes> Sliding<L> {
    #[inline(always)]
    pub(super) fn load(bodies: &Bodies, rows: &[u32; 8]) -> Self {
        let (shift, inverse_mass) = Vector::of(L::rows(&bodies.shift, rows));
        let (turn, mark) = Vector::of(L::rows(&bodies.turn, rows));
        Self {
            shift,
            turn,
            inverse_mass,
            mark,
            inverse_inertia: Symmetric {
                along: Vector::of(L::rows(&bodies.along, rows)).0,
                across: Vector::of(L::rows(&bodies.across, rows)).0,
            },
            centre: Vector::of(L::rows(&bodies.centre, rows)).0,
            step: Vector::of(L::rows(&bodies.step, rows)).0,
            spin: Vector::of(L::rows(&bodies.spin, rows)).0,
        }
    }

    /// Displacement since the substep began of what is at `arm` from the centre, metres: `spin × (arm - ½ spin × arm)` is the chord, to third order.
    #[inline(always)]
    pub(super) fn moved(&self, arm: Vector<L>) -> Vector<L> {
        let middle = arm - self.spin.cross(arm) * L::splat(0.5);
        self.step + self.shift + self.spin.cross(middle) + self.turn.cross(arm)
    }
}

fn columns_of(m: &Mat3) -> (Vec3, Vec3, Vec3) {
    (m.x_axis, m.y_axis, m.z_axis)
}

/// The unit quaternion of a rotation; by its greatest component, so that nothing is divided by what is nearly zero.
pub(super) fn quaternion(m: &Mat3) -> Vec4 {
    let (x, y, z) = columns_of(m);
    let trace = x.x + y.y + z.z;
    let q = if trace > 0.0 {
        Vec4::new(y.z - z.y, z.x - x.z, x.y - y.x, 1.0 + trace)
    } else if x.x >= y.y && x.x >= z.z {
        Vec4::new(1.0 + x.x - y.y - z.z, x.y + y.x, z.x + x.z, y.z - z.y)
    } else if y.y >= z.z {
        Vec4::new(x.y + y.x, 1.0 + y.y - x.x - z.z, y.z + z.y, z.x - x.z)
    } else {
        Vec4::new(z.x + x.z, y.z + z.y, 1.0 + z.z - x.x - y.y, x.y - y.x)
    };
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    if length > 0.0 && length.is_finite() { q / length } else { Vec4::W }
}

/// The rotation of a unit quaternion.
pub(super) fn rotation(q: Vec4) -> Mat3 {
    Mat3::from_quat(glam::Quat::from_xyzw(q.x, q.y, q.z, q.w))
}
