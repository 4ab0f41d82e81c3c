//! Everything that contacts know of what takes part in them: body colliders first, eight by eight, then colliders and planes, which nothing
//! moves.

use core::ops::{Index, IndexMut};

use glam::{Mat3, Vec3, Vec4};

use super::super::frame::Frame;
use super::turn::{Matrix, Symmetric};
use crate::lanes::{FIELDS, LANES, Lanes, Record, Vector};

/// The fields of a row. `[x y z w]`: how far contacts have moved it in this substep, metres, and its inverse mass, 1/kg.
pub(super) const SHIFT: usize = 0;
/// `[x y z m]`: how far they have turned it, rad about each axis; 1 if some of that came of a deep overlap.
pub(super) const TURN: usize = 1;
// Two fields that only lanes and `loose` ask for: the inverse inertia in world axes, 1/(kg·m²), first xx, yy, zz, then xy, xz, yz.
/// `[x y z r]`: its centre when the substep began, from its origin, metres; and of what is pinned how far its free particles are from its pin or its axis at
/// most, metres, 0 of all others.
pub(super) const CENTRE: usize = 4;
/// How far that has gone since, without contacts, metres.
pub(super) const STEP: usize = 5;
/// How far it has turned since, without contacts: `2 tan(φ/2)` about the axis.
pub(super) const SPIN: usize = 6;
/// As predicted: a unit quaternion. The last one, because friction does not ask for it.
pub(super) const ROTATION: usize = 7;

/// A row for each body collider, up to a multiple of eight; then for each collider and each plane; and one for nothing. A contact asks for nearly all
/// that there is of two bodies that may lie anywhere: so that is in one place, and not in columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    pub(super) rows: Vec<Record>,
    /// How far contacts are expected to move each of them in this substep, metres, and to turn it, rad: two entries for each.
    pub(super) predicted: Vec<Vec4>,
    /// How far each of them has gone farther than contacts believe, metres, and how it has turned further, rad: two entries for each
    /// (`friction`).
    pub(super) residual: Vec<Vec4>,
}

impl Index<usize> for Bodies {
    type Output = [Vec4; FIELDS];

    #[inline(always)]
    fn index(&self, row: usize) -> &[Vec4; FIELDS] {
        &self.rows[row].0
    }
}

impl IndexMut<usize> for Bodies {
    #[inline(always)]
    fn index_mut(&mut self, row: usize) -> &mut [Vec4; FIELDS] {
        &mut self.rows[row].0
    }
}

impl Bodies {
    /// Makes room for so many, none of which moves; some of the first ones stay as they are, by a bit for each, eight rows a number.
    pub(super) fn resize(&mut self, len: usize, kept: &[u32]) {
        let mut fixed = Record([Vec4::ZERO; FIELDS]);
        fixed.0[ROTATION] = Vec4::W;
        self.rows.resize(len, fixed);
        for (row, to) in self.rows.iter_mut().enumerate() {
            if kept.get(row / LANES).is_none_or(|kept| kept >> (row % LANES) & 1 == 0) {
                *to = fixed;
            }
        }
        self.predicted.clear();
        self.predicted.resize(2 * len, Vec4::ZERO);
        self.residual.clear();
        self.residual.resize(2 * len, Vec4::ZERO);
    }

    /// A copy of eight rows from one on.
    pub(super) fn eight(&self, first: usize) -> [Record; LANES] {
        core::array::from_fn(|lane| self.rows[first + lane])
    }

    /// Puts some of eight rows back to a [copy](Self::eight), by a bit for each.
    pub(super) fn put_back(&mut self, first: usize, lanes: u32, eight: [Record; LANES]) {
        for (lane, row) in eight.into_iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1)
        {
            self.rows[first + lane] = row;
        }
    }

    /// The frame of a body collider whose centre is at `centre` in it: where the substep began, turned as predicted.
    pub(super) fn frame(&self, row: usize, centre: Vec3) -> Frame {
        let (at, r) = (self[row][CENTRE].truncate(), rotation(self[row][ROTATION]));
        Frame { translation: at - r * centre, rotation: r }
    }

    /// Places a row that nothing moves: its frame at the end of a substep, and what it was at its start.
    pub(super) fn place(&mut self, row: usize, start: &Frame, end: &Frame) {
        let row = &mut self[row];
        row[ROTATION] = quaternion(&end.rotation);
        row[STEP] = (end.translation - start.translation).extend(0.0);
        let (x, y, z) = columns_of(&(end.rotation * start.rotation.transpose()));
        let sine = Vec3::new(y.z - z.y, z.x - x.z, x.y - y.x) * 0.5;
        // tan ½φ = sinφ / (1 + cosφ); half a turn in a substep is none that anything could follow.
        let below = (0.5 * (x.x + y.y + z.z + 1.0)).max(1e-3);
        let spin = if start.rotation == end.rotation { Vec3::ZERO } else { sine * (2.0 / below) };
        row[SPIN] = spin.extend(0.0);
    }
}

/// Eight rows from one on.
#[inline(always)]
pub(super) fn from_row(first: usize) -> [u32; LANES] {
    let mut rows = [0; LANES];
    for (lane, row) in rows.iter_mut().enumerate() {
        *row = (first + lane) as u32;
    }
    rows
}

/// The columns of eight of them.
pub(super) struct WideBody<L> {
    pub(super) shift: Vector<L>,
    pub(super) turn: Vector<L>,
    pub(super) inverse_mass: L,
    pub(super) depenetration_mark: L,
    pub(super) inverse_inertia: Symmetric<L>,
    pub(super) rotation: Matrix<L>,
    pub(super) centre: Vector<L>,
    /// How far what is pinned reaches; 0 of others.
    pub(super) pin_reach: L,
    pub(super) step: Vector<L>,
    pub(super) spin: Vector<L>,
}

impl<L: Lanes> WideBody<L> {
    #[inline(always)]
    pub(super) fn load(bodies: &Bodies, rows: &[u32; 8]) -> Self {
        let [shift, turn, along, across, centre, step, spin, rotation] =
            L::records(&bodies.rows, rows);
        let ((shift, inverse_mass), (turn, depenetration_mark)) =
            (Vector::of(shift), Vector::of(turn));
        let (centre, pin_reach) = Vector::of(centre);
        Self {
            shift,
            inverse_mass,
            turn,
            depenetration_mark,
            inverse_inertia: Symmetric { along: Vector::of(along).0, across: Vector::of(across).0 },
            rotation: Matrix::of(rotation),
            centre,
            pin_reach,
            step: Vector::of(step).0,
            spin: Vector::of(spin).0,
        }
    }
}

/// The columns of eight of them that friction asks for.
pub(super) struct WideSlidingBody<L> {
    pub(super) shift: Vector<L>,
    pub(super) turn: Vector<L>,
    pub(super) inverse_mass: L,
    pub(super) depenetration_mark: L,
    pub(super) inverse_inertia: Symmetric<L>,
    pub(super) centre: Vector<L>,
    step: Vector<L>,
    pub(super) spin: Vector<L>,
}

impl<L: Lanes> WideSlidingBody<L> {
    #[inline(always)]
    pub(super) fn load(bodies: &Bodies, rows: &[u32; 8]) -> Self {
        let [shift, turn, along, across, centre, step, spin] = L::records(&bodies.rows, rows);
        let ((shift, inverse_mass), (turn, depenetration_mark)) =
            (Vector::of(shift), Vector::of(turn));
        Self {
            shift,
            turn,
            inverse_mass,
            depenetration_mark,
            inverse_inertia: Symmetric { along: Vector::of(along).0, across: Vector::of(across).0 },
            centre: Vector::of(centre).0,
            step: Vector::of(step).0,
            spin: Vector::of(spin).0,
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
