//! The plot of the cost of a projection as cloth grows from a thousand constraints to four million.

use std::path::Path;

use sinew::recipes::Blueprint;
use sinew_report::plots::{Curve, Plot, Stroke};

use crate::measure::{Effort, Ours, Race, World};
use crate::naive::Naive;
use crate::row::{Row, Stretch, Unit};
use crate::scenes::cloth;

/// Particles along a side; a cloth has about four constraints for each particle.
const SIDES: [u32; 7] = [16, 32, 64, 128, 256, 512, 1024];

/// Substeps in a tick, of one sweep each.
const SUBSTEPS: u32 = 4;

/// Number of projections, approximately, that is enough to time one size.
const ENOUGH: usize = 20_000_000;

/// Measures all sizes, which takes a minute or two, and writes the plot.
///
/// # Errors
/// A message if drawing or writing the file fails.
pub fn draw(effort: &Effort, path: &Path) -> Result<(), String> {
    let sides = if effort.quick { &SIDES[..5] } else { &SIDES };
    let grid = measured(effort, sides, "grid", cloth::sheet);
    let mesh = measured(effort, sides, "shuffled", cloth::scattered);
    let curves: Vec<Curve> = grid.into_iter().chain(mesh).collect();
    let highest = curves.iter().flat_map(|c| &c.points).map(|p| p[1]).fold(1.0, f64::max);
    let plot = Plot {
        name: "growth",
        title: "Cloth of 4 substeps × 1 sweep: whole step per projection, CPU time",
        axes: ["log₁₀ of the number of constraints", "ns per projection"],
        // With space for the legend.
        height: [0.0, 1.35 * highest],
        curves,
    };
    std::fs::write(path, plot.png()?).map_err(|error| format!("{}: {error}", path.display()))
}

/// A world that is timed without a quality measurement, so that it need not run on to its end.
struct Unjudged<W>(W);

impl<W: World> World for Unjudged<W> {
    fn tick(&mut self) {
        self.0.tick();
    }

    fn stretch(&self) -> Option<Stretch> {
        None
    }
}

/// The curves of Sinew and of the naive reference for one kind of cloth.
fn measured(effort: &Effort, sides: &[u32], name: &str, body: fn(u32) -> Blueprint) -> [Curve; 2] {
    let mut points: [Vec<[f64; 2]>; 2] = Default::default();
    for &side in sides {
        let world = cloth::world(&body(side), SUBSTEPS, 1);
        let constraints = world.distances().len();
        let count = constraints * SUBSTEPS as usize;
        let most = (ENOUGH / count).clamp(8, 240);
        let naive = Naive::of(&world);
        let race = Race::between(Unjudged(Ours(world)), Unjudged(naive)).short(most);
        let row = race.run(effort, count, Row::new("", "", Unit::Projection));
        for (points, figure) in points.iter_mut().zip([row.ours, row.naive]) {
            points.push([(constraints as f64).log10(), figure.unwrap_or(f64::NAN)]);
        }
        eprintln!(
            "  {name}, {constraints} constraints: {:.2?} ns, naive {:.2?}",
            row.ours, row.naive
        );
    }
    let [ours, naive] = points;
    let curve = |words: &str, points| Curve {
        name: format!("{words}, {name}"),
        stroke: Stroke::Line,
        points,
    };
    [curve("Sinew", ours), curve("naive", naive)]
}
