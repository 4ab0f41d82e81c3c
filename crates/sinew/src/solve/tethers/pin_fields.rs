//! How far the particles of an island are from its pins: from the nearest, and from two that are far from each other. Kept from one plan to the next, so that a tear
//! has only those looked at again whose ways it cut.

use super::geodesic::DistanceField;
use super::taut;
use crate::solve::rod_graph::RodGraph;

/// Where more than one in so many particles has other rods, it is as quick to begin anew.
const FEW: usize = 16;

/// No tether.
const NONE: (u32, f32) = (0, f32::INFINITY);

/// How far members are from the pins of their island.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::solve) struct PinFields {
    /// The pins among the members.
    sources: Vec<u32>,
    /// Of each member a [hash](RodGraph::hashes) of its rods.
    hashes: Vec<u64>,
    /// From the nearest; none where there are two pins at the most, and that is the nearer of those.
    nearest: Option<DistanceField>,
    /// From single pins: the first one, and two that are far from each other.
    from: Vec<(u32, DistanceField)>,
    /// Which of the pins those two are.
    pub(in crate::solve) far: [u32; 2],
}

impl PinFields {
    /// Of an island with these rods, and with pins, of which there is one at least; out of what was `known` of an island, to the same bits.
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
        // The farthest from any, and the farthest from that.
        let one = farthest(0);
        let far = [one, farthest(one)];
        farthest(far[1]);
        let nearest = (sources.len() > 2).then(|| field(nearest, &sources));
        Self { sources, hashes, nearest, from, far }
    }

    /// From one of the two that are far from each other.
    pub(in crate::solve) fn from(&self, which: usize) -> Option<&DistanceField> {
        self.from.iter().find(|(of, _)| *of == self.far[which]).map(|(_, own)| own)
    }

    /// Of each member to which of the pins it is tethered, and how long that is, metres; infinite without.
    pub(in crate::solve) fn lengths(&self) -> Vec<[(u32, f32); 2]> {
        let ends = [0, 1].map(|which| (self.far[which], self.from(which)));
        let mut each: Vec<_> = (0..self.hashes.len() as u32)
            .map(|member| {
                let from = |field: &DistanceField| field.length(member);
                let ends = ends.map(|(pin, field)| (pin, field.map_or(f64::INFINITY, from)));
                let near = match &self.nearest {
                    Some(nearest) => (nearest.source(member), nearest.length(member)),
                    // Of two that are equally far, the first of the pins.
                    None if (ends[1].1, ends[1].0) < (ends[0].1, ends[0].0) => ends[1],
                    None => ends[0],
                };
                let far = ends.into_iter().filter(|end| end.0 != near.0 && end.1.is_finite());
                let far = far.reduce(|a, b| if b.1 > a.1 { b } else { a });
                [near, far.unwrap_or((near.0, f64::INFINITY))]
            })
            .map(|tethers| tethers.map(|(pin, length)| (pin, taut(length))))
            .collect();
        for &source in &self.sources {
            each[source as usize] = [NONE; 2];
        }
        // What nothing hard leads to.
        for tethers in &mut each {
            *tethers = tethers.map(|own| if own.1.is_finite() { own } else { NONE });
        }
        each
    }
}
