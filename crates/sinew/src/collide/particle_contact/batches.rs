//! Narrow phase in batches of eight rows: a cloth on a ball needs ten thousand tests a substep, most of which find no contact.
//!
//! A contact moves only its own row, so rows may be solved side by side and give the same bits as one after the other. The candidates of one row are solved in
//! sequence: round `n` holds the `n`th candidate of each row. Where a shape has a [closed form](ClosedForm), eight rows are tested at a time, and only those
//! that touch are resolved one by one, by the same code as any other contact. Rows that came from behind the surface take the scalar path.

use core::ops::Range;

use super::super::frame::Frame;
use super::super::shape::{ClosedForm, ShapeTouch};
use super::surface::SurfaceForm;
use super::{InstantInterval, NormalImpulses, ParticleContact, ParticleContacts};
use crate::islands::Islands;
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, Work, get, with};
use crate::particles::{Particles, Places};

/// Batches of all islands, for one step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct CandidateBatches {
    /// Range in `runs` of each island; `None` where its rows are solved one by one.
    islands: Vec<Option<Range<u32>>>,
    runs: Vec<SurfaceRun>,
    batches: Vec<CandidateBatch>,
    /// Surface, row and candidate of each row in a round; scratch.
    round: Vec<(u32, u32, u32)>,
}

/// Batches of one surface, which may be solved in any order.
#[derive(Clone, Debug)]
struct SurfaceRun {
    surface: u32,
    batches: Range<u32>,
}

/// One row a lane; unused lanes repeat the last row.
#[derive(Clone, Copy, Debug)]
struct CandidateBatch {
    rows: [u32; LANES],
    /// Candidate of each row.
    candidates: [u32; LANES],
    /// Radius of each row, metres.
    radius: [f32; LANES],
    /// Number of distinct rows.
    count: u32,
}

/// Below this number of rows most lanes would be empty.
const FEWEST: usize = LANES / 2;

impl CandidateBatches {
    /// Clears all batches.
    pub(super) fn clear(&mut self) {
        self.islands.clear();
        self.runs.clear();
        self.batches.clear();
    }
}

impl ParticleContacts {
    /// Builds the batches of each island, once candidates and reaches are known.
    pub(super) fn make_batches(&mut self, particles: &Particles, islands: &Islands) {
        let Self { first, candidates, reaches, touching, batches: all, .. } = self;
        all.clear();
        let CandidateBatches { islands: ranges, runs, batches, round } = all;
        for (island, reach) in islands.list.iter().zip(reaches.iter()) {
            let rows = &touching[reach.clone()];
            if rows.len() < FEWEST || !island.one_origin || first.is_empty() {
                ranges.push(None);
                continue;
            }
            let begin = runs.len() as u32;
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
                round.sort_by_key(|&(surface, ..)| surface);
                for run in round.chunk_by(|(one, ..), (other, ..)| one == other) {
                    let begin = batches.len() as u32;
                    batches.extend(run.chunks(LANES).map(|some| batch_of(some, particles)));
                    runs.push(SurfaceRun {
                        surface: run[0].0,
                        batches: begin..batches.len() as u32,
                    });
                }
            }
            ranges.push(Some(begin..runs.len() as u32));
        }
    }

    /// Whether the rows of island `number` are solved in batches.
    pub(super) fn has_batches(&self, number: usize) -> bool {
        self.batches.islands.get(number).is_some_and(Option::is_some)
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
        let CandidateBatches { islands, runs, batches, .. } = &self.batches;
        let Some(Some(range)) = islands.get(number) else { return 0.0 };
        let mut worst = 0.0_f32;
        for run in &runs[range.start as usize..range.end as usize] {
            let batches = &batches[run.batches.start as usize..run.batches.end as usize];
            let form = match &self.surfaces[run.surface as usize].form {
                SurfaceForm::Shape(shape) => shape.closed_form(),
                SurfaceForm::Plane(_) | SurfaceForm::BoundingBox(_) => None,
            };
            let Some(form) = form else {
                for batch in batches {
                    for lane in 0..batch.count as usize {
                        let (row, number) = (batch.rows[lane], batch.candidates[lane]);
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
            let origin = places.origin[places.at(batches[0].rows[0])];
            let (was, is) = self.frames_of(run.surface as usize, interval, origin);
            let work = SurfaceBatches {
                contacts: self,
                places: places.reborrow(),
                normal_impulses: normal_impulses.reborrow(),
                batches,
                surface: (run.surface, form),
                frames: [was, is],
                interval,
            };
            worst = worst.max(with(instructions, work));
        }
        worst
    }
}

fn batch_of(some: &[(u32, u32, u32)], particles: &Particles) -> CandidateBatch {
    let mut batch = CandidateBatch {
        rows: [0; LANES],
        candidates: [0; LANES],
        radius: [0.0; LANES],
        count: some.len() as u32,
    };
    for lane in 0..LANES {
        let (_, row, number) = some[lane.min(some.len() - 1)];
        (batch.rows[lane], batch.candidates[lane]) = (row, number);
        batch.radius[lane] = particles.radius[row as usize];
    }
    batch
}

/// Batches against one surface; the output is the greatest depth, metres.
struct SurfaceBatches<'a> {
    contacts: &'a ParticleContacts,
    places: Places<'a>,
    normal_impulses: NormalImpulses<'a>,
    batches: &'a [CandidateBatch],
    surface: (u32, ClosedForm),
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
        let (number, form) = surface;
        let (was, is) = (LocalFrame::<L>::of(&frames[0]), LocalFrame::<L>::of(&frames[1]));
        let mut worst = 0.0_f32;
        for batch in batches {
            let mut rows = batch.rows;
            rows.iter_mut().for_each(|row| *row = places.at(*row) as u32);
            let from = was.local(&L::rows(places.start, &rows));
            let to = is.local(&L::rows(places.position, &rows));
            let near = form.nearest(to);
            let found = near.touch(from, L::load(&batch.radius));
            // Rows that came from behind the surface, or overlapped it before, are solved one by one.
            let deep = L::splat(contacts.recover_in(interval)).lt(found.depth).and(found.touching);
            let behind = !found.in_front.bits() | deep.bits();
            let mut left = (found.touching.bits() | behind) & ((1 << batch.count) - 1);
            if left == 0 {
                continue;
            }
            let normals = [near.normal.x.array(), near.normal.y.array(), near.normal.z.array()];
            let ends = [to.x.array(), to.y.array(), to.z.array()];
            let depths = found.depth.array();
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let which = (batch.rows[lane], batch.candidates[lane]);
                let depth = if behind >> lane & 1 == 0 {
                    let touched = ShapeTouch { normal: get(&normals, lane), depth: depths[lane] };
                    let moves = contacts.surfaces[number as usize].moves;
                    let contact = ParticleContact::of(&touched, get(&ends, lane), &frames, moves);
                    contacts.take_contact(&mut places, &mut normal_impulses, which, &contact)
                } else {
                    contacts.project_candidate(&mut places, &mut normal_impulses, which, interval)
                };
                worst = worst.max(depth);
            }
        }
        worst
    }
}

/// A [`Frame`] broadcast to all lanes.
struct LocalFrame<L> {
    axes: [Vector<L>; 3],
    translation: Vector<L>,
}

impl<L: Lanes> LocalFrame<L> {
    #[inline(always)]
    fn of(frame: &Frame) -> Self {
        let r = &frame.rotation;
        Self {
            axes: [Vector::splat(r.x_axis), Vector::splat(r.y_axis), Vector::splat(r.z_axis)],
            translation: Vector::splat(frame.translation),
        }
    }

    /// See [`Frame::local`].
    #[inline(always)]
    fn local(&self, columns: &[L; 4]) -> Vector<L> {
        let direction = Vector::of(*columns).0 - self.translation;
        let [x, y, z] = &self.axes;
        Vector::new(x.dot(direction), y.dot(direction), z.dot(direction))
    }
}
