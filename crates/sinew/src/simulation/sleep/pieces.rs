//! Bounds of pieces of islands, by which islands touch each other.
//!
//! The bounds of a whole figure that lies on the floor contain others an arm's length away, and in a crowd all of them would be one group, awake as long as any
//! of them moves. So an island with several body colliders (bones, segments) has bounds for each of them, and one for its remaining particles.

use glam::Vec3;

use crate::collide::BodyCollider;
use crate::islands::Islands;

/// Lower and upper corner.
type Bounds = (Vec3, Vec3);

/// Empty bounds.
const EMPTY: Bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);

/// The pieces of all islands, island after island. Scratch.
#[derive(Default)]
pub(super) struct Pieces {
    /// Start of the pieces of each island, and the end of the last. An island that is a single piece has none here.
    starts: Vec<u32>,
    /// The pieces of each row, row after row, and the start of those of each row.
    of_rows: Vec<u32>,
    begins: Vec<u32>,
    /// Bounds of each piece; empty for one without particles.
    bounds: Vec<Bounds>,
    /// Whether only the bounds can have changed since the pieces were found.
    known: bool,
}

impl Pieces {
    /// Makes the pieces be found again: islands or body colliders have changed.
    pub(super) fn forget(&mut self) {
        self.known = false;
    }

    /// Clears the bounds of the pieces of these islands.
    pub(super) fn begin(
        &mut self,
        body_colliders: &[BodyCollider],
        islands: &Islands,
        these: &[u32],
    ) {
        if !self.known || self.starts.len() != islands.list.len() + 1 {
            self.find(body_colliders, islands);
            let count = self.starts.last().map_or(0, |&end| end as usize);
            self.bounds.resize(count, EMPTY);
        }
        for &island in these {
            let (from, to) = (self.starts[island as usize], self.starts[island as usize + 1]);
            self.bounds[from as usize..to as usize].fill(EMPTY);
        }
    }

    fn find(&mut self, body_colliders: &[BodyCollider], islands: &Islands) {
        let Self { starts, of_rows, begins, known, .. } = self;
        *known = true;
        let home = |solid: &BodyCollider| {
            let mut rows = solid.rows.iter().map(|&row| islands.of.get(row as usize).copied());
            let first = rows.next()??;
            rows.all(|island| island == Some(first)).then_some(first as usize)
        };
        let mut counts = vec![0_u32; islands.list.len()];
        body_colliders.iter().filter_map(home).for_each(|island| counts[island] += 1);
        starts.clear();
        starts.push(0);
        let mut end = 0;
        // One for each body collider, and a first one for particles without.
        starts.extend(counts.iter().map(|&count| {
            end += if count < 2 { 0 } else { count + 1 };
            end
        }));
        let mut next = starts.clone();
        let mut entries: Vec<[u32; 2]> = Vec::new();
        for solid in body_colliders {
            if let Some(island) = home(solid).filter(|&island| counts[island] > 1) {
                next[island] += 1;
                entries.extend(solid.rows.iter().map(|&row| [row, next[island]]));
            }
        }
        entries.sort_unstable();
        begins.clear();
        of_rows.clear();
        let mut next = entries.iter().peekable();
        for (row, &island) in (0..).zip(&islands.of) {
            let begin = of_rows.len();
            begins.push(begin as u32);
            while let Some(&[_, piece]) = next.next_if(|entry| entry[0] == row) {
                of_rows.push(piece);
            }
            if of_rows.len() == begin && counts[island as usize] > 1 {
                of_rows.push(starts[island as usize]);
            }
        }
        begins.push(of_rows.len() as u32);
    }

    /// Whether an island has more than one piece.
    pub(super) fn are_several(&self, island: usize) -> bool {
        self.starts[island] < self.starts[island + 1]
    }

    /// Enlarges the bounds of the pieces of a row by a box of half size `around` at `at`.
    #[inline]
    pub(super) fn add(&mut self, row: u32, at: Vec3, around: f32) {
        let Self { of_rows, begins, bounds, .. } = self;
        let (from, to) = (begins[row as usize] as usize, begins[row as usize + 1] as usize);
        for &piece in &of_rows[from..to] {
            let (low, high) = &mut bounds[piece as usize];
            (*low, *high) = (low.min(at - around), high.max(at + around));
        }
    }

    /// Whether a piece of island `a` touches one of `b`; `all` are the bounds of whole islands.
    pub(super) fn touch(&self, [a, b]: [u32; 2], all: &[Bounds]) -> bool {
        let (own, theirs) = (self.of(a, all), self.of(b, all));
        let whole = &all[b as usize];
        let touches = |one: &&Bounds| overlap(one, whole);
        own.iter().filter(touches).any(|one| theirs.iter().any(|other| overlap(one, other)))
    }

    /// The bounds of the pieces of an island.
    fn of<'a>(&'a self, island: u32, all: &'a [Bounds]) -> &'a [Bounds] {
        let island = island as usize;
        let own = &self.bounds[self.starts[island] as usize..self.starts[island + 1] as usize];
        if own.is_empty() { &all[island..=island] } else { own }
    }
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a.0.cmple(b.1).all() && b.0.cmple(a.1).all()
}
