//! Narrow phase in batches of eight rows: a cloth on a ball needs ten thousand tests a substep, most of which find no contact.
//!
//! A contact moves only its own row, so rows may be solved side by side and give the same bits as one after the other. The candidates of one row are solved in
//! sequence: round `n` holds the `n`th candidate of each row. Where a shape has a [closed form](ClosedForm), or each row may meet only one
//! [face](super::super::shape::LocalFace) of it, eight rows are tested and moved at a time. Rows that came from behind the surface, or meet more of it, are solved
//! one by one. Plain bounds come first.

use core::ops::Range;

use glam::Vec3;

use super::super::bounds::{ClassBounds, Spheres};
use super::super::frame::Frame;
use super::super::shape::{ClosedForm, LaneFaces, SphereTouches};
use super::surface::{ContactSurface, SurfaceForm};
use super::{
    ContactOf, FrameOf, InstantInterval, NormalImpulses, ParticleContact, ParticleContacts,
    SurfaceCandidate,
};
use crate::islands::Islands;
use crate::lanes::{InstructionSet, LANES, LaneArray, Lanes, SetLanes, Vector, Work, get, with};
use crate::particles::{Particles, Places};

/// Batches of all islands, for one step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct CandidateBatches {
    /// The runs of each island; `None` where its rows are solved one by one.
    islands: Vec<Option<IslandRuns>>,
    bounds: Vec<BoundRun>,
    bounded: Vec<RowBatch>,
    runs: Vec<SurfaceRun>,
    batches: Vec<CandidateBatch>,
    /// Faces of the batches of runs over faces, one entry a batch.
    faces: Vec<LaneFaces>,
    /// The rows of a round; scratch.
    round: Vec<Candidacy>,
}

/// Surface or body class, row, and candidate.
type Candidacy = (u32, u32, u32);

/// Ranges of the runs of an island.
#[derive(Clone, Debug)]
struct IslandRuns {
    bounds: Range<u32>,
    surfaces: Range<u32>,
}

/// Batches of rows near the plain bounds of one body class.
#[derive(Clone, Debug)]
struct BoundRun {
    class: u32,
    batches: Range<u32>,
}

/// Batches of one surface, which may be solved in any order.
#[derive(Clone, Debug)]
struct SurfaceRun {
    surface: u32,
    batches: Range<u32>,
    /// Where the entries of the batches in `faces` begin, if each row may meet only one face of the surface.
    faces: Option<u32>,
}

/// One row a lane; unused lanes repeat the last row.
#[derive(Clone, Copy, Debug)]
struct RowBatch {
    rows: [u32; LANES],
    /// Radius of each row, metres.
    radius: [f32; LANES],
    /// Number of distinct rows.
    count: u32,
}

/// Rows with a candidate each.
#[derive(Clone, Copy, Debug)]
struct CandidateBatch {
    rows: RowBatch,
    candidates: [u32; LANES],
    /// Friction coefficient of each.
    friction: LaneArray,
}

/// Below this number of rows most lanes would be empty.
const FEWEST: usize = LANES / 2;

impl CandidateBatches {
    /// Clears all batches.
    pub(super) fn clear(&mut self) {
        self.islands.clear();
        self.bounds.clear();
        self.bounded.clear();
        self.runs.clear();
        self.batches.clear();
        self.faces.clear();
    }
}

impl RowBatch {
    /// Where the rows are in the columns of `places`.
    #[inline(always)]
    fn places(&self, places: &Places) -> [u32; LANES] {
        let mut rows = self.rows;
        rows.iter_mut().for_each(|row| *row = places.at(*row) as u32);
        rows
    }
}

impl ParticleContacts {
    /// Builds the batches of each island, once candidates and reaches are known.
    pub(super) fn make_batches(&mut self, particles: &Particles, islands: &Islands) {
        self.batches.clear();
        for (number, island) in islands.list.iter().enumerate() {
            let Some(reach) = self.reaches.get(number).cloned() else { break };
            let runs = if reach.len() < FEWEST || !island.one_origin {
                None
            } else {
                let bounds = self.batch_bounds(particles, reach.clone());
                Some(IslandRuns { bounds, surfaces: self.batch_surfaces(particles, reach) })
            };
            self.batches.islands.push(runs);
        }
    }

    /// Batches those of some rows that are near plain bounds, by body class. Returns the range of the runs.
    fn batch_bounds(&mut self, particles: &Particles, reach: Range<usize>) -> Range<u32> {
        let Self { touching, bounded, classes, bounds, excluded, batches: all, .. } = self;
        let CandidateBatches { bounds: runs, bounded: batches, round, .. } = all;
        let begin = runs.len() as u32;
        let is_excluded = |row: u32| excluded.get(row as usize) == Some(&true);
        let rows = touching[reach].iter().copied();
        let rows = rows.filter(|&row| bounded[row as usize] && !is_excluded(row));
        round.clear();
        round.extend(rows.map(|row| (classes.of(row) as u32, row, 0)));
        round.sort_by_key(|&(class, ..)| class);
        for run in round.chunk_by(|(one, ..), (other, ..)| one == other) {
            let class = run[0].0;
            if bounds.of(class as usize).is_empty() {
                continue;
            }
            let begin = batches.len() as u32;
            batches.extend(run.chunks(LANES).map(|some| row_batch(some, particles)));
            runs.push(BoundRun { class, batches: begin..batches.len() as u32 });
        }
        begin..runs.len() as u32
    }

    /// Batches the candidates of some rows. Returns the range of the runs.
    fn batch_surfaces(&mut self, particles: &Particles, reach: Range<usize>) -> Range<u32> {
        let Self { first, candidates, faces: own_faces, touching, batches: all, .. } = self;
        let CandidateBatches { runs, batches, faces, round, .. } = all;
        let face = |number: u32| own_faces.get(candidates[number as usize].face as usize);
        let begin = runs.len() as u32;
        let rows = if first.is_empty() { &[] } else { &touching[reach] };
        for turn in 0.. {
            round.clear();
            round.extend(rows.iter().filter_map(|&row| {
                let number = first[row as usize] + turn;
                let has = number < first[row as usize + 1];
                has.then(|| (candidates[number as usize].surface, row, number))
            }));
            if round.is_empty() {
                break;
            }
            let key = |&(surface, _, number): &Candidacy| (surface, face(number).is_some());
            round.sort_by_key(key);
            for run in round.chunk_by(|one, other| key(one) == key(other)) {
                let begin = batches.len() as u32;
                let batch = |some: &[Candidacy]| candidate_batch(some, candidates, particles);
                batches.extend(run.chunks(LANES).map(batch));
                let (surface, has_faces) = key(&run[0]);
                let first_face = has_faces.then_some(faces.len() as u32);
                if has_faces {
                    let of_batch = |some: &[Candidacy]| {
                        LaneFaces::of(some.iter().filter_map(|&(.., number)| face(number)))
                    };
                    faces.extend(run.chunks(LANES).map(of_batch));
                }
                let batches = begin..batches.len() as u32;
                runs.push(SurfaceRun { surface, batches, faces: first_face });
            }
        }
        begin..runs.len() as u32
    }

    /// Whether the rows of island `number` are solved in batches.
    pub(super) fn has_batches(&self, number: usize) -> bool {
        self.batches.islands.get(number).is_some_and(Option::is_some)
    }

    /// Projects the rows of island `number` that are near plain bounds out of these; returns the greatest depth, metres.
    pub(super) fn leave_bounds_in_batches(
        &self,
        places: &mut Places,
        (number, interval): (usize, InstantInterval),
        instructions: InstructionSet,
    ) -> f32 {
        let CandidateBatches { islands, bounds, bounded, .. } = &self.batches;
        let Some(Some(IslandRuns { bounds: range, .. })) = islands.get(number) else { return 0.0 };
        let mut worst = 0.0_f32;
        for run in &bounds[range.start as usize..range.end as usize] {
            let batches = &bounded[run.batches.start as usize..run.batches.end as usize];
            let origin = places.origin[places.at(batches[0].rows[0])];
            let work = BoundBatches {
                places: places.reborrow(),
                batches,
                bounds: self.bounds.of(run.class as usize),
                origin,
                recover: self.recover_in(interval),
            };
            worst = worst.max(with(instructions, work));
        }
        worst
    }

    /// Projects the rows of island `number` out of the surfaces near them; returns the greatest depth, metres. None of the rows may have moved further than the
    /// broad phase allowed for.
    pub(super) fn leave_in_batches(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (number, interval): (usize, InstantInterval),
        instructions: InstructionSet,
    ) -> f32 {
        let CandidateBatches { islands, runs, batches, faces, .. } = &self.batches;
        let Some(Some(IslandRuns { surfaces: range, .. })) = islands.get(number) else {
            return 0.0;
        };
        let mut worst = 0.0_f32;
        for run in &runs[range.start as usize..range.end as usize] {
            let batches = &batches[run.batches.start as usize..run.batches.end as usize];
            let form = match &self.surfaces[run.surface as usize].form {
                SurfaceForm::Shape(shape) => shape.closed_form(),
                SurfaceForm::Plane(_) | SurfaceForm::BoundingBox(_) => None,
            };
            let tests = match (form, run.faces) {
                (Some(form), _) => Some(LaneTests::Form(form)),
                (None, Some(first)) => Some(LaneTests::Faces(&faces[first as usize..])),
                (None, None) => None,
            };
            let Some(tests) = tests else {
                for batch in batches {
                    for lane in 0..batch.rows.count as usize {
                        let (row, number) = (batch.rows.rows[lane], batch.candidates[lane]);
                        worst = worst.max(self.project_candidate(
                            places,
                            normal_impulses,
                            (row, number),
                            interval,
                        ));
                    }
                }
                continue;
            };
            let origin = places.origin[places.at(batches[0].rows.rows[0])];
            let (was, is) = self.frames_of(run.surface as usize, interval, origin);
            let work = SurfaceBatches {
                contacts: self,
                places: places.reborrow(),
                normal_impulses: normal_impulses.reborrow(),
                batches,
                surface: (run.surface, tests),
                frames: [was, is],
                interval,
            };
            worst = worst.max(with(instructions, work));
        }
        worst
    }
}

/// A batch of rows, with their candidates.
fn candidate_batch(
    some: &[Candidacy],
    all: &[SurfaceCandidate],
    particles: &Particles,
) -> CandidateBatch {
    let rows = row_batch(some, particles);
    let mut batch = CandidateBatch { rows, candidates: [0; LANES], friction: [0.0; LANES] };
    for lane in 0..LANES {
        let number = some[lane.min(some.len() - 1)].2;
        batch.candidates[lane] = number;
        batch.friction[lane] = all[number as usize].friction;
    }
    batch
}

fn row_batch(some: &[Candidacy], particles: &Particles) -> RowBatch {
    let count = some.len() as u32;
    let mut batch = RowBatch { rows: [0; LANES], radius: [0.0; LANES], count };
    for lane in 0..LANES {
        let row = some[lane.min(some.len() - 1)].1;
        batch.rows[lane] = row;
        batch.radius[lane] = particles.radius[row as usize];
    }
    batch
}

/// Batches against plain bounds; the output is the greatest depth, metres.
struct BoundBatches<'a> {
    places: Places<'a>,
    batches: &'a [RowBatch],
    bounds: &'a ClassBounds,
    /// That of all rows.
    origin: Vec3,
    recover: f32,
}

impl Work for BoundBatches<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { places, batches, bounds, origin, recover } = self;
        let mut worst = L::zero();
        for batch in batches {
            let rows = batch.places(&places);
            let (position, w) = Vector::of(L::rows(places.position, &rows));
            let (start, _) = Vector::of(L::rows(places.start, &rows));
            let radius = L::load(&batch.radius);
            let mut spheres = Spheres { origin, position, start, radius };
            let movable = L::zero().lt(w);
            let depth = movable.and(bounds.project(&mut spheres, recover));
            let touching = L::zero().lt(depth);
            if touching.any() {
                let moved = spheres.position.or_else(touching, position);
                L::put_rows(places.position, &rows, moved.with(w));
                worst = depth.max(worst);
            }
        }
        worst.largest(0.0)
    }
}

/// How eight rows are tested at a time.
#[derive(Clone, Copy)]
enum LaneTests<'a> {
    Form(ClosedForm),
    /// The only faces that the rows may meet, one entry a batch.
    Faces(&'a [LaneFaces]),
}

impl LaneTests<'_> {
    /// Tests the rows of a batch, which move from one point to another in the frame of the surface.
    #[inline(always)]
    fn touch<L: Lanes>(
        &self,
        number: usize,
        [from, to]: [Vector<L>; 2],
        batch: &RowBatch,
    ) -> SphereTouches<L> {
        match self {
            Self::Form(form) => {
                let near = form.nearest(to);
                let found = near.touch(from, L::load(&batch.radius));
                let (depth, touching) = (found.depth, found.touching);
                SphereTouches { normal: near.normal, depth, touching, certain: found.in_front }
            }
            Self::Faces(faces) => faces[number].load::<L>().touch(from, to),
        }
    }
}

/// Batches against one surface; the output is the greatest depth, metres.
struct SurfaceBatches<'a> {
    contacts: &'a ParticleContacts,
    places: Places<'a>,
    normal_impulses: NormalImpulses<'a>,
    batches: &'a [CandidateBatch],
    surface: (u32, LaneTests<'a>),
    /// Poses of the surface at the start and the end of the interval, relative to the origin of all rows.
    frames: [Frame; 2],
    interval: InstantInterval,
}

impl Work for SurfaceBatches<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { contacts, mut places, mut normal_impulses, batches, surface, frames, interval } =
            self;
        let (surface, tests) = surface;
        let (was, is) = (FrameOf::<L>::of(&frames[0]), FrameOf::<L>::of(&frames[1]));
        let ContactSurface { moves, sensor, .. } = contacts.surfaces[surface as usize];
        let mut worst = 0.0_f32;
        for (number, batch) in batches.iter().enumerate() {
            let rows = batch.rows.places(&places);
            let (start, _) = Vector::of(L::rows(places.start, &rows));
            let (position, w) = Vector::of(L::rows(places.position, &rows));
            let (from, to) = (was.local(start), is.local(position));
            let found = tests.touch(number, [from, to], &batch.rows);
            // Rows that came from behind the surface or meet more of it, or overlapped it before, are solved one by one.
            let deep = L::splat(contacts.recover_in(interval)).lt(found.depth).and(found.touching);
            let single = !found.certain.bits() | deep.bits();
            // Those of lanes that repeat the last row as well: what they write is what is left in it.
            let together = found.touching.bits() & !single;
            let distinct = (1 << batch.rows.count) - 1;
            if together != 0 {
                let contact = ContactOf::at(found.normal, found.depth, to, ([&was, &is], moves));
                if !sensor {
                    let by = contact.displacement(position - start, L::load(&batch.friction));
                    let moved = (position + by).or_else(L::mask(together), position);
                    L::put_rows(places.position, &rows, moved.with(w));
                    worst = L::mask(together).and(contact.depth).largest(worst);
                }
                let (normals, carried) = (arrays(contact.normal), arrays(contact.carried));
                let depths = contact.depth.array();
                for lane in SetLanes(together & distinct) {
                    let contact = ParticleContact {
                        normal: get(&normals, lane).into(),
                        depth: depths[lane],
                        carried: get(&carried, lane).into(),
                    };
                    let impulse = normal_impulses.at(batch.candidates[lane]);
                    impulse.record(&places, batch.rows.rows[lane], &contact);
                }
            }
            for lane in SetLanes(single & distinct) {
                let which = (batch.rows.rows[lane], batch.candidates[lane]);
                let depth =
                    contacts.project_candidate(&mut places, &mut normal_impulses, which, interval);
                worst = worst.max(depth);
            }
        }
        worst
    }
}

/// Eight vectors in memory.
#[inline(always)]
fn arrays<L: Lanes>(v: Vector<L>) -> [LaneArray; 3] {
    [v.x.array(), v.y.array(), v.z.array()]
}
