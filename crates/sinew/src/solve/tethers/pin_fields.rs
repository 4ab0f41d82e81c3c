//! Distances of an island's particles from its pins: from the nearest pin, and from two that are far from each other. Kept from one plan to the next, so that a
//! tear recomputes only the particles whose paths it cut.

use super::geodesic::DistanceField;
use super::tether_length;
use crate::solve::rod_graph::RodGraph;

/// If more than one particle in this many has changed rods, computing from scratch is as fast.
const FEW: usize = 16;

/// No tether.
const NONE: (u32, f32) = (0, f32::INFINITY);

/// Distances of members from the pins of their island.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::solve) struct PinFields {
    /// Member indices of the pins.
    sources: Vec<u32>,
    /// For each member a [hash](RodGraph::hashes) of its rods.
    hashes: Vec<u64>,
    /// Distances from the nearest pin. `None` with at most two pins, where it is the nearer of `from`.
    nearest: Option<DistanceField>,
    /// Distances from single pins: the first one, and two that are far from each other.
    from: Vec<(u32, DistanceField)>,
    /// Indices of those two pins.
    pub(in crate::solve) far: [u32; 2],
}

impl PinFields {
    /// For an island with these rods and at least one pin. Updates the `known` distances where possible, with the same bits as computing from scratch.
    pub(in crate::solve) fn of(graph: &RodGraph, sources: Vec<u32>, known: Option<Self>) -> Self {
        let hashes = graph.hashes();
        let same = |known: &Self| known.sources == sources && known.hashes.len() == hashes.len();
        let known = known.filter(same).and_then(|known| {
            let both = hashes.iter().zip(&known.hashes).zip(0..);
            let changed = both.filter(|((new, old), _)| new != old).map(|(_, member)| member);
            let changed: Vec<u32> = changed.collect();
            (changed.len() * FEW <= hashes.len()).then_some((known, changed))
        });
        let (changed, nearest, mut old) = match known {
            Some((known, changed)) => (changed, known.nearest, known.from),
            None => Default::default(),
        };
        let field = |known: Option<DistanceField>, sources: &[u32]| match known {
            Some(mut known) => {
                graph.update(&mut known, &changed);
                known
            }
            None => graph.field(sources),
        };
        let mut from = Vec::<(u32, DistanceField)>::new();
        let mut farthest = |pin: u32| {
            let own = match from.iter().position(|(of, _)| *of == pin) {
                Some(there) => there,
                None => {
                    let known = old.iter().position(|(of, _)| *of == pin);
                    let known = known.map(|known| old.swap_remove(known).1);
                    let at = pin as usize;
                    from.push((pin, field(known, &sources[at..=at])));
                    from.len() - 1
                }
            };
            let (_, own) = &from[own];
            let each = (0..).zip(&sources).map(|(pin, &source)| (pin, own.length(source)));
            let reached = each.filter(|(_, length)| length.is_finite());
            reached.fold((0, 0.0), |far, own| if own.1 > far.1 { own } else { far }).0
        };
        // The farthest pin from the first one, and the farthest from that.
        let one = farthest(0);
        let far = [one, farthest(one)];
        farthest(far[1]);
        let nearest = (sources.len() > 2).then(|| field(nearest, &sources));
        Self { sources, hashes, nearest, from, far }
    }

    /// Distances from one of the two pins that are far from each other.
    pub(in crate::solve) fn from(&self, which: usize) -> Option<&DistanceField> {
        self.from.iter().find(|(of, _)| *of == self.far[which]).map(|(_, own)| own)
    }

    /// For each member the index of the pin and the length of both tethers, metres; infinite where there is none.
    pub(in crate::solve) fn lengths(&self) -> Vec<[(u32, f32); 2]> {
        let ends = [0, 1].map(|which| (self.far[which], self.from(which)));
        let mut each: Vec<_> = (0..self.hashes.len() as u32)
            .map(|member| {
                let from = |field: &DistanceField| field.length(member);
                let ends = ends.map(|(pin, field)| (pin, field.map_or(f64::INFINITY, from)));
                let near = match &self.nearest {
                    Some(nearest) => (nearest.source(member), nearest.length(member)),
                    // Of two equally near pins, the one with the lower index.
                    None if (ends[1].1, ends[1].0) < (ends[0].1, ends[0].0) => ends[1],
                    None => ends[0],
                };
                let far = ends.into_iter().filter(|end| end.0 != near.0 && end.1.is_finite());
                let far = far.reduce(|a, b| if b.1 > a.1 { b } else { a });
                [near, far.unwrap_or((near.0, f64::INFINITY))]
            })
            .map(|tethers| tethers.map(|(pin, length)| (pin, tether_length(length))))
            .collect();
        for &source in &self.sources {
            each[source as usize] = [NONE; 2];
        }
        // Members to which no hard rods lead.
        for tethers in &mut each {
            *tethers = tethers.map(|own| if own.1.is_finite() { own } else { NONE });
        }
        each
    }
}
