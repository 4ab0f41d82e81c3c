//! The rows that contacts read and write: body colliders first, in groups of eight, then static and kinematic geometry, which contacts do not move.

use core::ops::{Index, IndexMut};

use glam::{Mat3, Vec3, Vec4};

use super::super::frame::Frame;
use super::turn::{Matrix, Symmetric, unit_quaternion};
use crate::lanes::{FIELDS, LANES, Lanes, Record, Vector};

/// Fields of a row. `[x y z w]`: displacement by contacts in this substep, metres, and inverse mass, 1/kg.
pub(super) const SHIFT: usize = 0;
/// `[x y z m]`: turn by contacts in this substep, rad about each axis; depenetration mark, 1 if a part of it came of a deep overlap.
pub(super) const TURN: usize = 1;
// Fields 2 and 3, which only lanes and `loose` read: inverse inertia in world axes, 1/(kg·m²), first xx, yy, zz, then xy, xz, yz.
/// `[x y z r]`: centre when the substep began, from its origin, metres; of a pinned body collider the greatest distance of its free particles from its pin or
/// axis, metres, else 0.
pub(super) const CENTRE: usize = 4;
/// Displacement of the centre since then without contacts, metres.
pub(super) const STEP: usize = 5;
/// Turn since then without contacts: `2 tan(φ/2)` about the axis.
pub(super) const SPIN: usize = 6;
/// Predicted rotation, a unit quaternion. The last field, because friction does not load it.
pub(super) const ROTATION: usize = 7;

/// One row for each body collider, padded to a multiple of eight; then one for each collider and plane; and a null row. A contact needs nearly all fields of
/// two bodies at arbitrary places, so a row is contiguous (`AoS`) and not spread over columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    pub(super) rows: Vec<Record>,
    /// Predicted displacement, metres, and turn, rad, by contacts in this substep: two entries for each row.
    pub(super) predicted: Vec<Vec4>,
    /// Constraint residual (`friction`): displacement, metres, and turn, rad, beyond those that contacts assume; two entries for each row.
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
    /// Resizes to `len` rows, all at rest. `kept` has a bit for each row, eight rows a number; rows whose bit is set keep their contents.
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

    /// Whether an impulse can move or turn what is in a row.
    pub(super) fn is_movable(&self, row: usize) -> bool {
        let [shift, _, along, across, ..] = self[row];
        shift.w != 0.0 || along.truncate() != Vec3::ZERO || across.truncate() != Vec3::ZERO
    }

    /// A copy of the eight rows from `first` on.
    pub(super) fn eight(&self, first: usize) -> [Record; LANES] {
        core::array::from_fn(|lane| self.rows[first + lane])
    }

    /// Restores from a [copy](Self::eight) the rows whose bit in `lanes` is set.
    pub(super) fn put_back(&mut self, first: usize, lanes: u32, eight: [Record; LANES]) {
        for (lane, row) in eight.into_iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1)
        {
            self.rows[first + lane] = row;
        }
    }

    /// The frame of a body collider with the centre `centre` in its own frame: placed where the substep began, with the predicted rotation.
    pub(super) fn frame(&self, row: usize, centre: Vec3) -> Frame {
        let (at, r) = (self[row][CENTRE].truncate(), rotation(self[row][ROTATION]));
        Frame { translation: at - r * centre, rotation: r }
    }

    /// Places a row of static or kinematic geometry: its frame at the start and at the end of a substep.
    pub(super) fn place(&mut self, row: usize, start: &Frame, end: &Frame) {
        let row = &mut self[row];
        row[ROTATION] = quaternion(&end.rotation);
        row[STEP] = (end.translation - start.translation).extend(0.0);
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } = end.rotation * start.rotation.transpose();
        let sine = Vec3::new(y.z - z.y, z.x - x.z, x.y - y.x) * 0.5;
        // tan ½φ = sinφ / (1 + cosφ). A half turn in a substep is clamped: no contact could follow it.
        let below = (0.5 * (x.x + y.y + z.z + 1.0)).max(1e-3);
        let spin = if start.rotation == end.rotation { Vec3::ZERO } else { sine * (2.0 / below) };
        row[SPIN] = spin.extend(0.0);
    }
}

/// The eight row numbers from `first` on.
#[inline(always)]
pub(super) fn from_row(first: usize) -> [u32; LANES] {
    let mut rows = [0; LANES];
    for (lane, row) in rows.iter_mut().enumerate() {
        *row = (first + lane) as u32;
    }
    rows
}

/// Eight rows in lanes, as the normal solve reads them.
pub(super) struct WideBody<L> {
    pub(super) shift: Vector<L>,
    pub(super) turn: Vector<L>,
    pub(super) inverse_mass: L,
    pub(super) depenetration_mark: L,
    pub(super) inverse_inertia: Symmetric<L>,
    pub(super) rotation: Matrix<L>,
    pub(super) centre: Vector<L>,
    /// Reach of a pinned body collider from its pin or axis; 0 of others.
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

/// Eight rows in lanes, as the friction solve reads them: without the rotation.
pub(super) struct WideSlidingBody<L> {
    pub(super) shift: Vector<L>,
    pub(super) turn: Vector<L>,
    pub(super) inverse_mass: L,
    pub(super) depenetration_mark: L,
    pub(super) inverse_inertia: Symmetric<L>,
    pub(super) centre: Vector<L>,
    pub(super) step: Vector<L>,
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

    /// Displacement since the substep began of the point at `arm` from the centre, metres: `spin × (arm - ½ spin × arm)` is the chord, to third order.
    #[inline(always)]
    pub(super) fn moved(&self, arm: Vector<L>) -> Vector<L> {
        let middle = arm - self.spin.cross(arm) * L::splat(0.5);
        self.step + self.shift + self.spin.cross(middle) + self.turn.cross(arm)
    }
}

/// The unit quaternion of a rotation.
pub(super) fn quaternion(m: &Mat3) -> Vec4 {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(Vector::<f32>::splat);
    Vec4::from_array(unit_quaternion(&Matrix { x, y, z }))
}

/// The rotation matrix of a unit quaternion.
pub(super) fn rotation(q: Vec4) -> Mat3 {
    Mat3::from_quat(glam::Quat::from_xyzw(q.x, q.y, q.z, q.w))
}
