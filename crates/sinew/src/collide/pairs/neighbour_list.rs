//! Neighbour list: the pairs within their margins, filtered, sorted, graph coloured, eight to a block.

use glam::Vec3;

use super::super::filter::ContactFilter;
use super::participants::Participants;
use crate::lanes::{LANES, set};

/// The neighbour list. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct NeighbourList {
    /// Participant indices, the lower one first; sorted.
    pub(super) pairs: Vec<[u32; 2]>,
    /// Least allowed distance of each pair, metres.
    pub(super) reach: Vec<f32>,
    /// Colours used by each participant, a bit each.
    taken: Vec<u64>,
    /// The colour of each pair.
    colour: Vec<u8>,
    /// The blocks, colour by colour.
    pub(super) blocks: Vec<PairBlock>,
    /// For blocks whose pairs have different origins: what is added to the difference of the two positions, metres.
    pub(super) offsets: Vec<[[f32; LANES]; 3]>,
}

/// Eight pairs that share no particle. Where there are fewer, the last one is repeated.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct PairBlock {
    /// Rows of the first and of the second particle of each pair.
    pub(super) rows: [[u32; LANES]; 2],
    /// Least allowed distance, metres.
    pub(super) reach: [f32; LANES],
    /// Coefficient of friction.
    pub(super) friction: [f32; LANES],
    /// Coefficient of restitution.
    pub(super) restitution: [f32; LANES],
    /// Number of distinct pairs.
    pub(super) count: u32,
    /// Bit mask of the pairs to be reported.
    pub(super) reported: u32,
    /// Its index in `offsets`, or [`NO_OFFSET`].
    pub(super) offset: u32,
}

/// Marks a block in which both particles of every pair have the same origin.
pub(super) const NO_OFFSET: u32 = u32::MAX;

/// Colours, one a bit of `taken`. A pair for which none is left gets a block of its own, after all others.
const COLOURS: usize = 64;

/// Factor on a squared distance for the rounding of sums of radii and margins in a different order.
const ROUNDED: f32 = 1.0 + 1e-5;

impl NeighbourList {
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.reach.clear();
        self.blocks.clear();
        self.offsets.clear();
    }

    /// Takes those of the sorted candidates that are within their margins and may touch.
    pub(super) fn select(
        &mut self,
        candidates: &[[u32; 2]],
        participants: &Participants,
        filter: &ContactFilter,
    ) {
        let Participants { radius, home, pinned, .. } = participants;
        for &[low, high] in candidates {
            let (i, j) = (low as usize, high as usize);
            // No pair has a greater reach than the sum of its radii.
            let within = radius[i] + radius[j] + home[i].w + home[j].w;
            let apart = participants.separation(i, j).length_squared();
            if apart > within * within * ROUNDED || pinned[i] && pinned[j] {
                continue;
            }
            let Some(reach) = participants.reach(filter, i, j) else { continue };
            if is_near(participants, i, j, reach) {
                self.pairs.push([low, high]);
                self.reach.push(reach);
            }
        }
    }

    /// Colours the pairs in order (greedy: the first colour that neither particle has), and packs each colour into blocks.
    pub(super) fn colour(&mut self, participants: &Participants, filter: &ContactFilter) {
        let Self { pairs, taken, colour, blocks, .. } = self;
        taken.clear();
        taken.resize(participants.rows.len(), 0);
        colour.clear();
        let mut counts = [0_u32; COLOURS + 1];
        for &[a, b] in pairs.iter() {
            let both = taken[a as usize] | taken[b as usize];
            let free = both.trailing_ones();
            let bit = 1_u64.checked_shl(free).unwrap_or(0);
            taken[a as usize] |= bit;
            taken[b as usize] |= bit;
            counts[free as usize] += 1;
            colour.push(free as u8);
        }
        let mut firsts = [0_u32; COLOURS + 1];
        let mut sum = 0;
        for (first, &count) in firsts.iter_mut().zip(&counts[..COLOURS]) {
            *first = sum;
            sum += count.div_ceil(LANES as u32);
        }
        firsts[COLOURS] = sum;
        blocks.clear();
        blocks.resize((sum + counts[COLOURS]) as usize, PairBlock::EMPTY);
        self.pack((participants, filter), firsts);
    }

    /// Writes each pair into the next free lane of its colour.
    fn pack(
        &mut self,
        (participants, filter): (&Participants, &ContactFilter),
        firsts: [u32; COLOURS + 1],
    ) {
        let Self { pairs, reach, colour, blocks, offsets, .. } = self;
        let mut filled = [0_u32; COLOURS + 1];
        let mut last = CombinedSettings::none();
        for ((&[a, b], &reach), &colour) in pairs.iter().zip(reach.iter()).zip(colour.iter()) {
            let colour = colour as usize;
            let number = filled[colour];
            filled[colour] += 1;
            let (block, lane) = if colour == COLOURS {
                (firsts[colour] + number, 0)
            } else {
                (firsts[colour] + number / LANES as u32, number as usize % LANES)
            };
            let block = &mut blocks[block as usize];
            let (a, b) = (a as usize, b as usize);
            let bodies = [participants.body[a], participants.body[b]];
            if last.bodies != bodies {
                last = CombinedSettings::of(filter, bodies);
            }
            block.put(lane, [participants.rows[a], participants.rows[b]], reach, &last);
            let offset = participants.origin[a] - participants.origin[b];
            if offset != Vec3::ZERO {
                if block.offset == NO_OFFSET {
                    block.offset = offsets.len() as u32;
                    offsets.push([[0.0; LANES]; 3]);
                }
                set(&mut offsets[block.offset as usize], lane, offset);
            }
        }
        for block in blocks.iter_mut().filter(|block| block.count < LANES as u32) {
            block.pad(offsets);
        }
    }
}

/// Whether a pair is close enough to touch before one of the two exceeds its margin; for fast pairs, whether it does on its path in this substep.
fn is_near(participants: &Participants, i: usize, j: usize, reach: f32) -> bool {
    let apart = participants.separation(i, j);
    let (one, other) = (participants.home[i].w, participants.home[j].w);
    let within = reach + one + other;
    let distance = apart.length_squared();
    // NaN is not near.
    #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN is not near, either")]
    if !(distance < within * within) {
        return false;
    }
    if participants.path.is_empty() {
        return true;
    }
    let came = participants.path[i] - participants.path[j];
    let length = came.length_squared();
    // The nearest point of the path from `apart - came` to `apart`, with half of the radii as a margin for what other contacts do to the two in the meantime.
    let back = if length > 0.0 { (apart.dot(came) / length).clamp(0.0, 1.0) } else { 0.0 };
    let about = reach + 0.5 * (participants.radius[i] + participants.radius[j]);
    (apart - came * back).length_squared() < about * about
}

/// Combined contact settings of two bodies.
struct CombinedSettings {
    bodies: [u32; 2],
    friction: f32,
    restitution: f32,
    reported: bool,
}

impl CombinedSettings {
    fn none() -> Self {
        Self { bodies: [u32::MAX; 2], friction: 0.0, restitution: 0.0, reported: false }
    }

    fn of(filter: &ContactFilter, bodies: [u32; 2]) -> Self {
        let [one, other] = bodies.map(|body| filter.body(body));
        let combined_material = one.material.against(&other.material);
        let reported = one.events || other.events;
        Self {
            bodies,
            friction: combined_material.friction,
            restitution: combined_material.restitution,
            reported,
        }
    }
}

impl PairBlock {
    const EMPTY: Self = Self {
        rows: [[0; LANES]; 2],
        reach: [0.0; LANES],
        friction: [0.0; LANES],
        restitution: [0.0; LANES],
        count: 0,
        reported: 0,
        offset: NO_OFFSET,
    };

    /// Writes a pair into a lane.
    #[inline(always)]
    fn put(&mut self, lane: usize, rows: [u32; 2], reach: f32, settings: &CombinedSettings) {
        self.rows[0][lane] = rows[0];
        self.rows[1][lane] = rows[1];
        self.reach[lane] = reach;
        self.friction[lane] = settings.friction;
        self.restitution[lane] = settings.restitution;
        self.count = lane as u32 + 1;
        self.reported |= u32::from(settings.reported) << lane;
    }

    /// Repeats the last pair in the unused lanes: they compute and write the same values.
    fn pad(&mut self, offsets: &mut [[[f32; LANES]; 3]]) {
        let Some(last) = (self.count as usize).checked_sub(1) else { return };
        for rows in &mut self.rows {
            let row = rows[last];
            rows[last..].fill(row);
        }
        for column in [&mut self.reach, &mut self.friction, &mut self.restitution] {
            let number = column[last];
            column[last..].fill(number);
        }
        for column in offsets.get_mut(self.offset as usize).into_iter().flatten() {
            let number = column[last];
            column[last..].fill(number);
        }
    }
}
