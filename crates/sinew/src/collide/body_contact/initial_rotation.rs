//! Initial rotation of body colliders when a step begins, from nothing: no rotation is kept, so that what is restored goes on to the same bits. Two
//! of a body collider's particles, far out and far from being in line with the first one, say nearly how it is turned; `extract_pose` makes that
//! exact.

use glam::{DMat3, DQuat, Mat3, Vec3, Vec4};

use super::BodyContactSolver;
use super::bodies::{ROTATION, quaternion};
use super::groups::{BodyGroups, CompiledCollider};
use super::turn::{LaneArray, Matrix, load};
use crate::collide::World;
use crate::lanes::{LANES, Lanes, Vector, Work, with};
use crate::particles::Particles;
use crate::pose::rotation;

/// What the initial rotation of eight body colliders is computed from: the rows of their first particles, of those far out, and of those aside; and
/// the frames that these make at rest.
#[derive(Clone, Debug)]
pub(super) struct RotationReference {
    rows: [[u32; LANES]; 3],
    rest: [[LaneArray; 3]; 3],
}

impl RotationReference {
    /// Of as many body colliders as there are lanes, whose particles are not in line: each with its rows and where those rest.
    pub(super) fn of<'a>(
        eight: impl Iterator<Item = (&'a CompiledCollider, &'a [u32], &'a [Vec3])>,
    ) -> Option<Self> {
        let mut rotation_reference = Self { rows: [[0; LANES]; 3], rest: [[[0.0; LANES]; 3]; 3] };
        let mut count = 0;
        for (lane, (part, rows, rest)) in eight.enumerate() {
            let side = part.side?;
            for (to, from) in rotation_reference.rows.iter_mut().zip([0, part.far, side]) {
                to[lane] = rows[from];
            }
            let frame = frame(rest[part.far] - rest[0], rest[side] - rest[0])?;
            // Transposed.
            for (to, from) in
                rotation_reference.rest.iter_mut().zip(frame.transpose().to_cols_array_2d())
            {
                for (to, from) in to.iter_mut().zip(from) {
                    to[lane] = from;
                }
            }
            count += 1;
        }
        (count == LANES).then_some(rotation_reference)
    }
}

impl BodyContactSolver {
    /// Notes a rotation near that of each sound body collider.
    pub(super) fn note_initial_rotations(&mut self, particles: &Particles, world: &World) {
        let Self { groups, origin_offsets, bodies, instructions, .. } = self;
        let mut turned = [Vec4::W; LANES];
        for (number, group) in groups.groups.iter().enumerate() {
            // Where particles of one body collider have origins of their own, none is computed so.
            let rotation_reference =
                group.rotation_reference.as_ref().filter(|_| origin_offsets.of(group).is_none());
            let known = rotation_reference.map_or(0, |rotation_reference| {
                let position = &particles.position;
                with(
                    *instructions,
                    InitialRotation { rotation_reference, position, turned: &mut turned },
                )
            });
            for (lane, &turned) in turned.iter().enumerate() {
                let row = &mut bodies[number * LANES + lane];
                if known >> lane & 1 == 1 {
                    row[ROTATION] = turned;
                } else if let Some(solid) = groups.sound_in(number, lane) {
                    let rest = &world.body_colliders[solid].rest;
                    row[ROTATION] = initial_rotation(groups, &groups.parts[solid], rest, particles);
                }
            }
        }
    }
}

/// How eight body colliders are turned, to the bits of [`initial_rotation`].
struct InitialRotation<'a> {
    rotation_reference: &'a RotationReference,
    position: &'a [Vec4],
    turned: &'a mut [Vec4; LANES],
}

impl Work for InitialRotation<'_> {
    /// A bit for each that it is known of.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let Self {
            rotation_reference: RotationReference { rows: [first, far, side], rest },
            position,
            turned,
        } = self;
        let first = places::<L>(position, first);
        let (far, side) = (places(position, far) - first, places(position, side) - first);
        let (x, is_long) = unit(far);
        let (z, is_wide) = unit(far.cross(side));
        let [a, b, c] = rest;
        let rest = Matrix { x: load(a), y: load(b), z: load(c) };
        let q = unit_quaternion(&Matrix { x, y: z.cross(x), z }.times_matrix(&rest));
        L::put_run(turned, 0, q);
        is_long.and(is_wide).bits()
    }
}

#[inline(always)]
fn places<L: Lanes>(position: &[Vec4], rows: &[u32; LANES]) -> Vector<L> {
    Vector::of(L::rows(position, rows)).0
}

/// A vector of length 1, and whether there is one.
#[inline(always)]
fn unit<L: Lanes>(v: Vector<L>) -> (Vector<L>, L) {
    let inverse = L::splat(1.0) / v.length();
    (v * inverse, L::zero().lt(inverse).and(inverse.lt(L::splat(f32::INFINITY))))
}

/// [`quaternion`] in lanes.
#[inline(always)]
fn unit_quaternion<L: Lanes>(m: &Matrix<L>) -> [L; 4] {
    let (one, Matrix { x, y, z }) = (L::splat(1.0), *m);
    let trace = x.x + y.y + z.z;
    let real = [y.z - z.y, z.x - x.z, x.y - y.x, one + trace];
    let by_x = [one + x.x - y.y - z.z, x.y + y.x, z.x + x.z, real[0]];
    let by_y = [x.y + y.x, one + y.y - x.x - z.z, y.z + z.y, real[1]];
    let by_z = [z.x + x.z, y.z + z.y, one + z.z - x.x - y.y, real[2]];
    let is_real = L::zero().lt(trace);
    let is_x = y.y.le(x.x).and(z.z.le(x.x));
    let is_y = z.z.le(y.y);
    let mut q = [one; 4];
    for i in 0..4 {
        q[i] = is_real.select(real[i], is_x.select(by_x[i], is_y.select(by_y[i], by_z[i])));
    }
    let [x, y, z, w] = q;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let good = L::zero().lt(length).and(length.lt(L::splat(f32::INFINITY)));
    let none = L::zero();
    for (i, q) in q.iter_mut().enumerate() {
        *q = good.select(*q / length, if i == 3 { one } else { none });
    }
    q
}

/// A rotation near that of a body collider, from two of its particles: a function of where they are.
fn initial_rotation(
    groups: &BodyGroups,
    part: &CompiledCollider,
    rest: &[Vec3],
    particles: &Particles,
) -> Vec4 {
    let rows = &groups.rows[part.entries.clone()];
    let here = |i: usize| particles.separation(rows[i] as usize, rows[0] as usize);
    let there = |i: usize| rest[i] - rest[0];
    if let Some(side) = part.side {
        let frames = (frame(there(part.far), there(side)), frame(here(part.far), here(side)));
        if let (Some(from), Some(to)) = frames {
            return quaternion(&(to * from.transpose()));
        }
    }
    let ends = (there(part.far).try_normalize(), here(part.far).try_normalize());
    let (Some(from), Some(to)) = ends else { return Vec4::W };
    // The shortest arc; of a half turn any.
    let (axis, real) = (from.cross(to), 1.0 + from.dot(to));
    let q = if real > 1e-6 { axis.extend(real) } else { from.any_orthonormal_vector().extend(0.0) };
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    q / length
}

/// The rotation of a body collider the slow and certain way.
pub(super) fn certain(
    groups: &BodyGroups,
    number: usize,
    rest: &[Vec3],
    particles: &Particles,
    near: Vec4,
) -> Vec4 {
    let part = &groups.parts[number];
    let rows = &groups.rows[part.entries.clone()];
    let place = groups.place(number);
    let slots = &groups.slots[groups.groups[place / LANES].slots.clone()];
    let points = || {
        rows.iter().zip(rest).zip(slots).map(|((&row, rest), slot)| {
            let here = particles.separation(row as usize, rows[0] as usize).as_dvec3();
            (here, (*rest - part.centre).as_dvec3(), f64::from(slot.pull[place % LANES]))
        })
    };
    let sum: f64 = points().map(|(_, _, m)| m).sum();
    let middle = points().map(|(q, _, m)| q * (m / sum)).sum::<glam::DVec3>();
    let mut moments = DMat3::ZERO;
    for (q, r, m) in points() {
        let a = (q - middle) * m;
        moments += DMat3::from_cols(a * r.x, a * r.y, a * r.z);
    }
    let near = DQuat::from_xyzw(near.x.into(), near.y.into(), near.z.into(), near.w.into());
    let q = rotation::nearest(moments, near.normalize());
    let q = Vec4::new(q.x as f32, q.y as f32, q.z as f32, q.w as f32);
    if q.is_finite() { q } else { Vec4::W }
}

/// A right-handed frame with its first axis along `a` and `b` in the plane of the first two.
fn frame(a: Vec3, b: Vec3) -> Option<Mat3> {
    let (x, z) = (a.try_normalize()?, a.cross(b).try_normalize()?);
    Some(Mat3::from_cols(x, z.cross(x), z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::InstructionSet;

    /// Eight at a time, on any machine, the bits are those of one at a time; and of what is in line or nowhere nothing is said.
    #[test]
    fn eight_are_turned_as_each_alone_is() {
        let mut state = 3_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
        };
        let part = CompiledCollider { far: 1, side: Some(2), ..CompiledCollider::default() };
        let mut odd = 0;
        for round in 0..200 {
            let mut three = || [(); 3].map(|()| Vec3::new(next(), next(), next()));
            let rest = [(); LANES].map(|()| three());
            let mut here = [(); LANES].map(|()| three());
            match round % 4 {
                // Turned by little; a half turn about each axis in turn; in line; nowhere.
                0 => here = rest,
                1 => here[0] = rest[0].map(|r| 2.0 * r * (r.x.abs() - r) - r),
                2 => here[round % LANES][2] = here[round % LANES][0],
                _ => here[round % LANES][1] = Vec3::NAN,
            }
            let rows: Vec<u32> = (0..3 * LANES as u32).collect();
            let eight = (0..LANES).map(|lane| (&part, &rows[3 * lane..], &rest[lane][..]));
            let Some(rotation_reference) = RotationReference::of(eight) else { continue };
            let position: Vec<Vec4> =
                here.iter().flatten().map(|place| place.extend(1.0)).collect();
            for set in [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::Avx2] {
                let mut turned = [Vec4::ZERO; LANES];
                let (rotation_reference, position) = (&rotation_reference, &position[..]);
                let known = with(
                    set,
                    InitialRotation { rotation_reference, position, turned: &mut turned },
                );
                for lane in 0..LANES {
                    let ([a, b, c], [p, q, r]) = (rest[lane], here[lane]);
                    let frames = (frame(b - a, c - a), frame(q - p, r - p));
                    let (Some(from), Some(to)) = frames else {
                        odd += 1;
                        assert_eq!(known >> lane & 1, 0, "{set:?}, round {round}, lane {lane}");
                        continue;
                    };
                    let alone = quaternion(&(to * from.transpose()));
                    assert_eq!(known >> lane & 1, 1, "{set:?}, round {round}, lane {lane}");
                    let bits = |q: Vec4| q.to_array().map(f32::to_bits);
                    assert_eq!(bits(turned[lane]), bits(alone), "{set:?}, round {round}");
                }
            }
        }
        assert!(odd > 100, "{odd}");
    }
}
