//! The triangles on which air acts, packed by eights, and the kernel that adds a force per triangle to its corners.
//!
//! Most of the cost of a wind is reading the corners of a triangle and adding to their accelerations. A cloth grid has its cells in rows, two triangles each,
//! and from cell to cell each corner is the next particle. So eight such cells are four contiguous runs of eight particles, which load into registers without a
//! gather, and the two triangles of a cell share what is loaded. All other triangles are gathered, in any order.
//!
//! A particle gets the forces of its own triangles in an order that depends only on the order of those: first those of cells, then the others. So the result
//! for a cloth does not depend on what else is in the world.

use core::ops::Range;

use glam::{Vec3, Vec4};

use crate::lanes::{InstructionSet, LANES, Lanes, Vector, Work, with};
use crate::particles::Particles;
use crate::tracked::Tracked;

/// The triangles of a list, packed; valid as long as that list and the number of particles stay the same. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct PackedSurfaces {
    cells: Vec<CellRun>,
    gathered: Vec<GatheredTriangles>,
    /// How many of `cells` and of `gathered` are of particles that do not move as rigid states; these come first.
    particle_counts: [usize; 2],
    /// Revision of the packed list, and the number of particles.
    packed: Option<(u64, usize)>,
    ranges: Vec<Range<usize>>,
    /// Indices of the triangles that are in no cell run.
    others: Vec<u32>,
    /// For each particle, the index of its stretch of consecutive particles with one origin.
    origin_runs: Vec<u32>,
}

/// Eight cells in a row: sixteen triangles of a list. The first triangle of each cell has the corners 0, 1, 2, the second 1, 2, 3.
#[derive(Clone, Copy, Debug)]
struct CellRun {
    first: u32,
    /// Rows of the first cell's corners; from cell to cell each increases by one.
    corners: [u32; 4],
    /// Whether corners of one cell may have different origins.
    mixed_origins: bool,
}

/// Up to eight arbitrary triangles; unused lanes repeat the first one.
#[derive(Clone, Copy, Debug)]
struct GatheredTriangles {
    numbers: [u32; LANES],
    corners: [[u32; LANES]; 3],
    count: usize,
    mixed_origins: bool,
}

/// A force on triangles. It must not depend on their winding.
pub(super) trait SurfaceForce {
    /// Per-triangle input for eight triangles, besides their areas.
    type Local<L: Lanes>: Copy;
    /// Whether it needs the velocities of the corners.
    const NEEDS_MOTION: bool;

    /// The input for eight triangles; `None` if there is no force on any of them.
    fn at<L: Lanes>(&self, numbers: &[u32; LANES]) -> Option<Self::Local<L>>;

    /// The inputs for the even and for the odd ones of sixteen triangles.
    fn at_pairs<L: Lanes>(&self, first: usize) -> [Option<Self::Local<L>>; 2];

    /// A third of the force on eight triangles, N, given twice their area vectors.
    fn third<L: Lanes>(
        &self,
        local: Self::Local<L>,
        twice_the_area: Vector<L>,
        motion: &Motion<L>,
    ) -> Vector<L>;
}

/// Motion of the three corners of eight triangles.
#[derive(Clone, Copy)]
pub(super) struct Motion<L> {
    /// Sum of the velocities, m/s.
    pub(super) sum: Vector<L>,
    /// The largest velocity lag of the corners, seconds; see [`Particles::lag`].
    pub(super) lag: L,
}

impl PackedSurfaces {
    /// Packs the triangles: first those in the ranges of `particle_ranges`, ascending, then the others. A triangle with a missing particle is left out.
    pub(crate) fn pack(
        &mut self,
        surfaces: &Tracked<Vec<[u32; 3]>>,
        particle_ranges: &[Range<usize>],
        origin: &[Vec3],
    ) {
        let packed = Some((surfaces.revision(), origin.len()));
        if self.packed != packed || self.ranges != particle_ranges {
            (self.packed, self.particle_counts) = (packed, [0; 2]);
            self.ranges.clear();
            self.ranges.extend_from_slice(particle_ranges);
            self.cells.clear();
            self.gathered.clear();
            // The list may have become shorter since the ranges were computed.
            let len = surfaces.len();
            let there =
                || particle_ranges.iter().map(|range| range.start.min(len)..range.end.min(len));
            self.pack_ranges(surfaces, there(), origin.len());
            self.particle_counts = [self.cells.len(), self.gathered.len()];
            let begins = core::iter::once(0).chain(there().map(|range| range.end));
            let ends = there().map(|range| range.start).chain([len]);
            let between = begins.zip(ends).map(|(begin, end)| begin..end);
            self.pack_ranges(surfaces, between, origin.len());
        }
        self.note_origins(origin);
    }

    /// Packs all triangles of a list, for tests.
    #[cfg(test)]
    pub(super) fn of(surfaces: &[[u32; 3]], particles: &Particles) -> Self {
        let mut packed = Self::default();
        packed.pack(&surfaces.to_vec().into(), &[], &particles.origin);
        packed
    }

    fn pack_ranges(
        &mut self,
        surfaces: &[[u32; 3]],
        ranges: impl Iterator<Item = Range<usize>>,
        len: usize,
    ) {
        let Self { cells: packed, gathered, others, .. } = self;
        others.clear();
        let there = |corners: &[u32; 3]| corners.iter().all(|&i| (i as usize) < len);
        for range in ranges {
            let mut number = range.start;
            let of_one = surfaces.get(range).unwrap_or_default();
            let end = number + of_one.len();
            while number < end {
                let left = &surfaces[number..end];
                if let Some(corners) = cells(left).filter(|_| left[..2 * LANES].iter().all(there)) {
                    packed.push(CellRun { first: number as u32, corners, mixed_origins: false });
                    number += 2 * LANES;
                    continue;
                }
                if there(&left[0]) {
                    others.push(number as u32);
                }
                number += 1;
            }
        }
        for eight in others.chunks(LANES) {
            let mut numbers = [eight[0]; LANES];
            numbers[..eight.len()].copy_from_slice(eight);
            let mut corners = [[0; LANES]; 3];
            for (lane, &number) in numbers.iter().enumerate() {
                let [a, b, c] = surfaces[number as usize];
                (corners[0][lane], corners[1][lane], corners[2][lane]) = (a, b, c);
            }
            gathered.push(GatheredTriangles {
                numbers,
                corners,
                count: eight.len(),
                mixed_origins: false,
            });
        }
    }

    /// Notes which triangles may have corners with different origins. Particles that constraints connect share one.
    fn note_origins(&mut self, origin: &[Vec3]) {
        let Self { cells, gathered, origin_runs, .. } = self;
        let (mut origin_run, mut last) = (0, origin.first());
        origin_runs.clear();
        origin_runs.extend(origin.iter().map(|own| {
            origin_run += u32::from(last != Some(own));
            last = Some(own);
            origin_run
        }));
        let of = |row: u32| origin_runs[row as usize];
        for run in cells {
            let one = of(run.corners[0]);
            run.mixed_origins = (run.corners.iter())
                .any(|&row| of(row) != one || of(row + LANES as u32 - 1) != one);
        }
        for eight in gathered {
            let [a, b, c] = &eight.corners;
            let is_apart = |i: usize| of(b[i]) != of(a[i]) || of(c[i]) != of(a[i]);
            eight.mixed_origins = (0..LANES).any(is_apart);
        }
    }

    /// Adds the force on all triangles, or only on those in the ranges packed first; does nothing while there are fewer particles than were packed.
    pub(super) fn accelerate(
        &self,
        particles: &mut Particles,
        force: &impl SurfaceForce,
        only_particles: bool,
        instructions: InstructionSet,
    ) {
        if self.packed.is_none_or(|(_, packed)| packed > particles.len()) {
            return;
        }
        let [cells, gathered] = if only_particles {
            self.particle_counts
        } else {
            [self.cells.len(), self.gathered.len()]
        };
        let (cells, gathered) = (&self.cells[..cells], &self.gathered[..gathered]);
        if cells.is_empty() && gathered.is_empty() {
            return;
        }
        particles.acceleration_dirty = true;
        with(instructions, Accelerate { particles, cells, gathered, force });
    }
}

/// The corners of the first of eight cells, if the triangles start with eight such cells: first and last the two that are not shared.
fn cells(triangles: &[[u32; 3]]) -> Option<[u32; 4]> {
    let follows =
        |number: usize| triangles[number] == triangles[number - 2].map(|row| row.wrapping_add(1));
    if triangles.len() < 2 * LANES || !(2..2 * LANES).all(follows) {
        return None;
    }
    let (one, other) = (triangles[0], triangles[1]);
    let mut shared = one.into_iter().filter(|row| other.contains(row));
    let shared = [shared.next()?, shared.next()?];
    if shared[0] == shared[1] {
        return None;
    }
    let alone = |of: [u32; 3]| of.into_iter().find(|row| !shared.contains(row));
    Some([alone(one)?, shared[0], shared[1], alone(other)?])
}

/// Adds the force on triangles to their corners.
struct Accelerate<'a, F> {
    particles: &'a mut Particles,
    cells: &'a [CellRun],
    gathered: &'a [GatheredTriangles],
    force: &'a F,
}

impl<F: SurfaceForce> Work for Accelerate<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { particles, cells, gathered, force } = self;
        for run in cells {
            run.accelerate::<L, F>(particles, force);
        }
        for eight in gathered {
            eight.accelerate::<L, F>(particles, force);
        }
    }
}

impl CellRun {
    #[inline(always)]
    fn accelerate<L: Lanes, F: SurfaceForce>(&self, particles: &mut Particles, force: &F) {
        let [first, second] = force.at_pairs::<L>(self.first as usize);
        if first.is_none() && second.is_none() {
            return;
        }
        let [a, b, c, d] = self.corners.map(|row| row as usize);
        let Particles { position, origin, velocity, acceleration, .. } = particles;
        let (p, own) = Vector::<L>::of(L::run(position, a));
        let (q, one) = Vector::of(L::run(position, b));
        let (r, other) = Vector::of(L::run(position, c));
        let (s, last) = Vector::of(L::run(position, d));
        let mut edges = [q - p, r - p, q - s, r - s];
        if self.mixed_origins {
            let rows = [run_rows(a), run_rows(b), run_rows(c), run_rows(d)];
            edges[0] = shifted(edges[0], &rows[0], &rows[1], origin);
            edges[1] = shifted(edges[1], &rows[0], &rows[2], origin);
            edges[2] = shifted(edges[2], &rows[3], &rows[1], origin);
            edges[3] = shifted(edges[3], &rows[3], &rows[2], origin);
        }
        let none = Vector::splat(Vec3::ZERO);
        let [mut near, mut far] = [Motion { sum: none, lag: L::zero() }; 2];
        if F::NEEDS_MOTION {
            let shared = Motion::of(L::run(velocity, b)).and(L::run(velocity, c));
            near = shared.and(L::run(velocity, a));
            far = shared.and(L::run(velocity, d));
        }
        let (mut on_first, mut on_second) = (none, none);
        if let Some(local) = first {
            on_first = force.third(local, edges[0].cross(edges[1]), &near);
        }
        if let Some(local) = second {
            on_second = force.third(local, edges[2].cross(edges[3]), &far);
        }
        let both = on_first + on_second;
        add_run(acceleration, a, on_first * own);
        add_run(acceleration, b, both * one);
        add_run(acceleration, c, both * other);
        add_run(acceleration, d, on_second * last);
    }
}

impl GatheredTriangles {
    #[inline(always)]
    fn accelerate<L: Lanes, F: SurfaceForce>(&self, particles: &mut Particles, force: &F) {
        let Some(local) = force.at::<L>(&self.numbers) else { return };
        let Particles { position, origin, velocity, acceleration, .. } = particles;
        let [a, b, c] = &self.corners;
        let (p, own) = Vector::<L>::of(L::rows(position, a));
        let (q, one) = Vector::of(L::rows(position, b));
        let (r, other) = Vector::of(L::rows(position, c));
        let (mut along, mut across) = (q - p, r - p);
        if self.mixed_origins {
            along = shifted(along, a, b, origin);
            across = shifted(across, a, c, origin);
        }
        let mut motion = Motion { sum: Vector::splat(Vec3::ZERO), lag: L::zero() };
        if F::NEEDS_MOTION {
            motion = Motion::of(L::rows(velocity, b))
                .and(L::rows(velocity, c))
                .and(L::rows(velocity, a));
        }
        let third = force.third(local, along.cross(across), &motion);
        let mut more = [[Vec4::ZERO; LANES]; 3];
        L::put_run(&mut more[0], 0, (third * own).with(L::zero()));
        L::put_run(&mut more[1], 0, (third * one).with(L::zero()));
        L::put_run(&mut more[2], 0, (third * other).with(L::zero()));
        // One triangle after the other: several may share a corner, and the result must not depend on which others are in the same eight.
        for lane in 0..self.count {
            acceleration[a[lane] as usize] += more[0][lane];
            acceleration[b[lane] as usize] += more[1][lane];
            acceleration[c[lane] as usize] += more[2][lane];
        }
    }
}

impl<L: Lanes> Motion<L> {
    /// Starts with one corner, from packed velocities.
    #[inline(always)]
    fn of(packed: [L; 4]) -> Self {
        let (sum, lag) = Vector::of(packed);
        Self { sum, lag }
    }

    /// Adds another corner.
    #[inline(always)]
    fn and(self, packed: [L; 4]) -> Self {
        let (velocity, lag) = Vector::of(packed);
        Self { sum: self.sum + velocity, lag: self.lag.max(lag) }
    }
}

#[inline(always)]
fn add_run<L: Lanes>(acceleration: &mut [Vec4], first: usize, more: Vector<L>) {
    let (sum, fourth) = Vector::of(L::run(acceleration, first));
    L::put_run(acceleration, first, (sum + more).with(fourth));
}

#[inline(always)]
fn run_rows(first: usize) -> [u32; LANES] {
    let mut rows = [0; LANES];
    for (lane, row) in rows.iter_mut().enumerate() {
        *row = (first + lane) as u32;
    }
    rows
}

/// Differences between particles, corrected by the difference of their origins.
#[inline(always)]
fn shifted<L: Lanes>(
    between: Vector<L>,
    from: &[u32; LANES],
    to: &[u32; LANES],
    origin: &[Vec3],
) -> Vector<L> {
    let mut shifts = [Vec4::ZERO; LANES];
    for lane in 0..LANES {
        let shift = origin[to[lane] as usize] - origin[from[lane] as usize];
        shifts[lane] = shift.extend(f32::from(u8::from(shift != Vec3::ZERO)));
    }
    let (shift, is_shifted) = Vector::of(L::run(&shifts, 0));
    (between + shift).or_else(L::zero().lt(is_shifted), between)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::lanes::InstructionSet;
    use crate::particles::ParticleSeed;
    use crate::test_random::Random;

    /// A force that depends on every input: along the area's normal or against it, whichever points up, with the index of the triangle and the motion of its
    /// corners.
    struct Trial {
        numbered: bool,
    }

    const TRIAL: Trial = Trial { numbered: true };

    fn trial(number: u32, twice: DVec3, sum: DVec3) -> DVec3 {
        sum * (twice.length() * f64::from(number + 1)) + DVec3::Y * twice.y.abs()
    }

    impl SurfaceForce for Trial {
        type Local<L: Lanes> = L;
        const NEEDS_MOTION: bool = true;

        #[inline(always)]
        fn at<L: Lanes>(&self, numbers: &[u32; LANES]) -> Option<L> {
            Some(L::load(
                &numbers.map(|number| if self.numbered { (number + 1) as f32 } else { 1.0 }),
            ))
        }

        #[inline(always)]
        fn at_pairs<L: Lanes>(&self, first: usize) -> [Option<L>; 2] {
            let of = |parity| core::array::from_fn(|lane| (first + 2 * lane + parity) as u32);
            [self.at(&of(0)), self.at(&of(1))]
        }

        #[inline(always)]
        fn third<L: Lanes>(&self, number: L, twice: Vector<L>, motion: &Motion<L>) -> Vector<L> {
            let up = Vector::splat(Vec3::Y) * twice.y.abs();
            motion.sum * (twice.length() * number) + up
        }
    }

    /// A grid of particles about a metre apart, at irregular positions, and two triangles for each cell. The corners are rotated by `turned` places, and the
    /// second triangle's the other way.
    fn grid(columns: u32, rows: u32, turned: usize) -> (Particles, Vec<[u32; 3]>) {
        let mut particles = Particles::default();
        let mut random = Random::new(7);
        let mut any = || 0.5 * random.number();
        for place in 0..columns * rows {
            let at =
                Vec3::new((place % columns) as f32 + 0.5 * any(), any(), (place / columns) as f32);
            let velocity = Vec3::new(any(), any(), any());
            let seed = ParticleSeed::at(at).with_mass(1.0 + any()).with_velocity(velocity);
            particles.push(seed).unwrap();
        }
        let mut triangles = Vec::new();
        for place in 0..columns * (rows - 1) {
            let (here, below) = (place, place + columns);
            if place % columns + 1 < columns {
                let mut cell = [[here, below, here + 1], [here + 1, below + 1, below]];
                cell[0].rotate_left(turned);
                cell[1].rotate_right(turned);
                triangles.extend(cell);
            }
        }
        (particles, triangles)
    }

    /// The sums of a third of the forces, each times the inverse mass, in double precision.
    fn expected(
        particles: &Particles,
        triangles: impl Iterator<Item = (usize, [u32; 3])>,
    ) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; particles.len()];
        for (number, corners) in triangles {
            let corners = corners.map(|row| row as usize);
            if corners.iter().any(|&i| i >= particles.len()) {
                continue;
            }
            let [a, b, c] = corners.map(|i| {
                particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3()
            });
            let sum: DVec3 = corners.map(|i| particles.velocity(i).as_dvec3()).into_iter().sum();
            let third = trial(number as u32, (b - a).cross(c - a), sum);
            for i in corners {
                sums[i] += third * f64::from(particles.inverse_mass(i));
            }
        }
        sums
    }

    fn accelerated(
        particles: &mut Particles,
        force: &Trial,
        (packed, only_particles): (&PackedSurfaces, bool),
        instructions: InstructionSet,
    ) -> Vec<Vec3> {
        particles.clear_sums(0.0);
        packed.accelerate(particles, force, only_particles, instructions);
        (0..particles.len()).map(|i| particles.acceleration(i)).collect()
    }

    fn assert_near(found: &[Vec3], expected: &[DVec3], case: &str) {
        for (row, (found, expected)) in found.iter().zip(expected).enumerate() {
            let most = 1e-5 * expected.length().max(1.0);
            assert!(
                found.as_dvec3().abs_diff_eq(*expected, most),
                "{case}, {row}: {found} {expected}"
            );
        }
    }

    #[test]
    fn each_triangle_of_a_grid_gets_its_force_once_however_long_its_rows_are() {
        for (columns, rows) in [(2, 2), (8, 3), (9, 2), (10, 4), (17, 5), (24, 24), (33, 3)] {
            for turned in 0..3 {
                let (mut particles, triangles) = grid(columns, rows, turned);
                let packed = PackedSurfaces::of(&triangles, &particles);
                let in_rows = (columns - 1) / 8 * (rows - 1);
                assert_eq!(packed.cells.len(), in_rows as usize, "{columns} × {rows}");
                let expected = expected(&particles, triangles.into_iter().enumerate());
                let case = format!("{columns} × {rows}, turned by {turned}");
                let wide =
                    accelerated(&mut particles, &TRIAL, (&packed, false), InstructionSet::best());
                assert_near(&wide, &expected, &case);
                for set in [InstructionSet::Scalar, InstructionSet::Simd128] {
                    assert_eq!(
                        accelerated(&mut particles, &TRIAL, (&packed, false), set),
                        wide,
                        "{case}"
                    );
                }
            }
        }
    }

    #[test]
    fn triangles_in_any_order_and_of_particles_with_other_origins_get_theirs() {
        let (mut particles, mut triangles) = grid(17, 4, 0);
        for i in 20..particles.len() {
            // The world position does not change, only the origin.
            let shift = Vec3::new(64.0 * (i % 3) as f32, 0.0, -32.0 * (i % 2) as f32);
            particles.origin[i] += shift;
            particles.position[i] -= shift.extend(0.0);
        }
        let mut packed = PackedSurfaces::default();
        for _ in 0..2 {
            packed.pack(&triangles.clone().into(), &[], &particles.origin);
            let expected = expected(&particles, triangles.iter().copied().enumerate());
            let found =
                accelerated(&mut particles, &TRIAL, (&packed, false), InstructionSet::best());
            assert_near(&found, &expected, "apart");
            // The same triangles in another order.
            let len = triangles.len();
            triangles = (0..len).map(|number| triangles[number * 37 % len]).collect();
        }
        assert!(packed.cells.is_empty());
    }

    #[test]
    fn separate_triangles_may_be_accelerated_alone_and_those_without_particles_are_left_out() {
        let (mut particles, mut triangles) = grid(20, 3, 0);
        triangles.extend([[0, 1, 1000], [u32::MAX, 0, 1]]);
        let separate = [3..30, 41..50];
        let mut packed = PackedSurfaces::default();
        packed.pack(&triangles.clone().into(), &separate, &particles.origin);
        let is_separate = |number: usize| separate.iter().any(|range| range.contains(&number));
        let numbered = || triangles.iter().copied().enumerate();
        let all = expected(&particles, numbered());
        let some = expected(&particles, numbered().filter(|&(number, _)| is_separate(number)));
        let best = InstructionSet::best();
        assert_near(&accelerated(&mut particles, &TRIAL, (&packed, false), best), &all, "all");
        assert_near(&accelerated(&mut particles, &TRIAL, (&packed, true), best), &some, "separate");
        // After the list became shorter, the remaining triangles.
        triangles.truncate(20);
        packed.pack(&triangles.clone().into(), &separate, &particles.origin);
        let left = expected(&particles, triangles.iter().copied().enumerate());
        let found = accelerated(&mut particles, &TRIAL, (&packed, false), best);
        assert_near(&found, &left, "shorter");
        // In a world with fewer particles than were packed, nothing is written.
        let mut fewer = grid(19, 3, 0).0;
        let touched = accelerated(&mut fewer, &TRIAL, (&packed, false), best);
        assert!(touched.iter().all(|&a| a == Vec3::ZERO));
    }

    #[test]
    fn it_does_not_matter_to_a_grid_what_else_there_is() {
        let (particles, triangles) = grid(13, 5, 0);
        let alone = PackedSurfaces::of(&triangles, &particles);
        // Next to it, and before it in the lists, is another grid.
        let (mut both, mut listed) = grid(11, 3, 1);
        listed.push([0, 1, 2]);
        let rows = both.len() as u32;
        for i in 0..particles.len() {
            let seed = ParticleSeed::at(particles.position(i))
                .with_mass(particles.mass(i))
                .with_velocity(particles.velocity(i));
            both.push(seed).unwrap();
        }
        listed.extend(triangles.iter().map(|corners| corners.map(|row| row + rows)));
        let packed = PackedSurfaces::of(&listed, &both);
        let count = |packed: &PackedSurfaces| packed.cells.len();
        assert_eq!(count(&packed), count(&alone) + 2);
        let [alone, beside] =
            [(particles, alone), (both, packed)].map(|(mut particles, packed)| {
                accelerated(
                    &mut particles,
                    &Trial { numbered: false },
                    (&packed, false),
                    InstructionSet::best(),
                )
            });
        assert_eq!(beside[rows as usize..], alone);
    }
}
