//! A line of the results: one scene, with the time and the quality of each contender.

use sinew::Distance;
use sinew::glam::Vec3;

/// Unit of the figures of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nanoseconds of a whole step per constraint, substep and sweep.
    Projection,
    /// Nanoseconds per tick of 1/60 s.
    Tick,
    /// Nanoseconds of wall-clock time per tick, which threads shorten.
    WallTick,
    /// Nanoseconds per unordered pair.
    Pair,
    /// Nanoseconds per vertex.
    Vertex,
    /// Nanoseconds, for an event that happens once.
    Once,
    /// Allocations and reallocations.
    Allocations,
    /// Mean stretch, per cent.
    Percent,
    /// Root mean square of speeds, mm/s.
    Speed,
}

/// Relative errors of lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Mean of the absolute errors.
    pub mean: f64,
    /// The largest of them; infinite if one is not finite.
    pub max: f64,
}

/// One scene, measured.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its number in the table of goals: "P1".
    pub id: &'static str,
    /// Title of the scene.
    pub scene: String,
    /// Unit of the figures.
    pub unit: Unit,
    /// Number of constraints.
    pub constraints: usize,
    /// Substeps in a tick.
    pub substeps: u32,
    /// Maximum number of sweeps in a substep.
    pub sweeps: u32,
    /// Figure of Sinew.
    pub ours: Option<f64>,
    /// Figure of the naive reference.
    pub naive: Option<f64>,
    /// Figure of the other engine, rapier.
    pub peer: Option<f64>,
    /// Figure of Avian, if it has the scene.
    pub avian: Option<f64>,
    /// Stretch of Sinew after 4 s.
    pub stretch: Option<Stretch>,
    /// Stretch of the naive reference after 4 s.
    pub naive_stretch: Option<Stretch>,
    /// Stretch of the other engine after 4 s.
    pub peer_stretch: Option<Stretch>,
    /// Stretch of Avian after 4 s.
    pub avian_stretch: Option<Stretch>,
    /// Note for reading the figures.
    pub note: String,
}

impl Unit {
    /// Name of the unit.
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

    /// Whether the figure is a time.
    pub fn is_time(self) -> bool {
        !matches!(self, Self::Allocations | Self::Percent | Self::Speed)
    }
}

impl Stretch {
    /// Stretch of `rods` with given positions. A slack rope has none.
    pub fn of<'a>(
        rods: impl IntoIterator<Item = &'a Distance>,
        position: impl Fn(usize) -> Vec3,
    ) -> Self {
        Self::of_shares(rods.into_iter().map(|rod| {
            let error = f64::from(rod.error(position(rod.a as usize), position(rod.b as usize)));
            error / f64::from(rod.rest)
        }))
    }

    /// Stretch from relative errors.
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

    /// Adds a note.
    pub fn noted(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// Sets the numbers of constraints, substeps and sweeps.
    pub fn sized(self, constraints: usize, substeps: u32, sweeps: u32) -> Self {
        Self { constraints, substeps, sweeps, ..self }
    }

    /// Ratio of the naive reference's figure to Sinew's: how many times as fast, or as good, Sinew is.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.naive? / self.ours?)
    }

    /// Ratio of the other engine's figure to Sinew's.
    pub fn peer_ratio(&self) -> Option<f64> {
        Some(self.peer? / self.ours?)
    }
}
