//! A line of the page: one scene, how long it took each contender, and how well each did it.

use sinew::Distance;
use sinew::glam::Vec3;

/// What a figure of a row is per.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nanoseconds of a whole step per constraint, substep and sweep.
    Projection,
    /// Nanoseconds per tick of 1/60 s.
    Tick,
    /// Nanoseconds per tick, on the clock at the wall: what threads shorten.
    WallTick,
    /// Nanoseconds per unordered pair.
    Pair,
    /// Nanoseconds per vertex.
    Vertex,
    /// Nanoseconds, for something that is done once.
    Once,
    /// Allocations and reallocations.
    Allocations,
    /// Mean stretch, per cent.
    Percent,
    /// Root of the mean square of speeds, mm/s.
    Speed,
}

/// How far lengths are from what they should be, as shares of that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Mean of the absolute errors.
    pub mean: f64,
    /// The largest of them; infinite where something is no number any more.
    pub max: f64,
}

/// One scene, measured.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its number in the table of goals: "P1".
    pub id: &'static str,
    /// What it is, in a line.
    pub scene: String,
    /// What the figures are per.
    pub unit: Unit,
    /// How many constraints it has.
    pub constraints: usize,
    /// Substeps in a tick.
    pub substeps: u32,
    /// The most sweeps in a substep.
    pub sweeps: u32,
    /// What Sinew took.
    pub ours: Option<f64>,
    /// What the naive reference took.
    pub naive: Option<f64>,
    /// What the rival took.
    pub peer: Option<f64>,
    /// What Avian took, where it has the scene.
    pub avian: Option<f64>,
    /// How well Sinew did it, after 4 s.
    pub stretch: Option<Stretch>,
    /// How well the naive reference did it, after 4 s.
    pub naive_stretch: Option<Stretch>,
    /// How well the rival did it, after 4 s.
    pub peer_stretch: Option<Stretch>,
    /// How well Avian did it.
    pub avian_stretch: Option<Stretch>,
    /// What one must know to read the figures.
    pub note: String,
}

impl Unit {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Projection => "ns/projection",
            Self::Tick => "ns/tick",
            Self::WallTick => "ns/tick (wall)",
            Self::Pair => "ns/pair",
            Self::Vertex => "ns/vertex",
            Self::Once => "ns",
            Self::Allocations => "allocations",
            Self::Percent => "% mean stretch",
            Self::Speed => "mm/s RMS",
        }
    }

    /// Whether it is a time.
    pub fn is_time(self) -> bool {
        !matches!(self, Self::Allocations | Self::Percent | Self::Speed)
    }
}

impl Stretch {
    /// That of `rods`, for particles that are there. A rope that is slack has none.
    pub fn of<'a>(
        rods: impl IntoIterator<Item = &'a Distance>,
        position: impl Fn(usize) -> Vec3,
    ) -> Self {
        Self::of_shares(rods.into_iter().map(|rod| {
            let error = f64::from(rod.error(position(rod.a as usize), position(rod.b as usize)));
            error / f64::from(rod.rest)
        }))
    }

    /// That of errors as shares of what they are errors of.
    pub fn of_shares(shares: impl IntoIterator<Item = f64>) -> Self {
        let (mut sum, mut count, mut max) = (0.0, 0_u32, 0.0_f64);
        for share in shares {
            sum += share;
            count += 1;
            max = if share.is_finite() { max.max(share) } else { f64::INFINITY };
        }
        Self { mean: sum / f64::from(count.max(1)), max }
    }
}

impl Row {
    /// A row without figures.
    pub fn new(id: &'static str, scene: impl Into<String>, unit: Unit) -> Self {
        Self {
            id,
            scene: scene.into(),
            unit,
            constraints: 0,
            substeps: 0,
            sweeps: 0,
            ours: None,
            naive: None,
            peer: None,
            avian: None,
            stretch: None,
            naive_stretch: None,
            peer_stretch: None,
            avian_stretch: None,
            note: String::new(),
        }
    }

    /// The same with words that one must know.
    pub fn noted(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// The same for so many constraints, substeps and sweeps.
    pub fn sized(self, constraints: usize, substeps: u32, sweeps: u32) -> Self {
        Self { constraints, substeps, sweeps, ..self }
    }

    /// How many times as fast as the naive reference, or as good.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.naive? / self.ours?)
    }

    /// How many times as fast as the rival.
    pub fn peer_ratio(&self) -> Option<f64> {
        Some(self.peer? / self.ours?)
    }
}
