//! P4: triangle cloth with stiff bending, by the dihedral angle or isometrically; the time is a mean over edges and bends.

use sinew::constraints::{Bend, Hinge};
use sinew::glam::Vec3;
use sinew::recipes::weld;
use sinew::{Constraint, ConstraintKind, Simulation, Softness};

use super::cloth;
use crate::measure::{Effort, Ours, Race};
use crate::naive::Naive;
use crate::row::{Row, Unit};

/// Particles along a side.
const SIDE: u32 = 128;

/// Substeps in a tick, of one sweep each.
const SUBSTEPS: u32 = 10;

/// Bending stiffness, N·m, of canvas. Cotton has a twentieth of that.
const STIFFNESS: f32 = 1e-4;

/// Why the naive reference stretches more: without bending it stretches as much in this order, and in the order of P2's mesh as little as Sinew.
const NOTE: &str = "the naive reference sweeps along the rows, which makes a sheet with one diagonal a cell flutter";

/// The kind of bending constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bending {
    /// The angle between two triangles.
    Dihedral,
    /// The isometric bending energy of Wardetzky and others.
    Isometric,
}

/// P4.
pub fn run(effort: &Effort) -> Vec<Row> {
    let row = |bending, words| {
        let world = world(SIDE, bending, SUBSTEPS, 1);
        let constraints = world.distances().len() + world.constraints().len();
        let race = Race::between(Ours(world.clone()), Naive::of(&world));
        let scene = format!("{words} bending on {SIDE}×{SIDE}, mean of edges and bends");
        let row = Row::new("P4", scene, Unit::Projection).sized(constraints, SUBSTEPS, 1);
        race.run(effort, constraints * SUBSTEPS as usize, row).noted(NOTE)
    };
    vec![row(Bending::Dihedral, "dihedral"), row(Bending::Isometric, "isometric")]
}

/// A horizontal sheet of triangles, pinned at two corners, with a bending constraint at each inner edge.
pub fn world(side: u32, bending: Bending, substeps: u32, sweeps: u32) -> Simulation {
    let mut grid = cloth::sheet(side);
    let at = |i: u32| grid.particles[i as usize].position;
    let positions: Vec<Vec3> = grid.particles.iter().map(|p| p.position).collect();
    let indices: Vec<u32> = grid.triangles.iter().flatten().copied().collect();
    let found = weld(&positions, &indices, 0.0).expect("the mesh is sound");
    // Nothing is welded, but the particles may be renumbered.
    let mut own = vec![0; positions.len()];
    (0..).zip(&found.vertices).for_each(|(vertex, &p): (u32, &u32)| own[p as usize] = vertex);
    let own = |pair: [u32; 2]| pair.map(|i| own[i as usize]);
    let bends: Vec<Constraint> = found
        .bends
        .iter()
        .filter_map(|bend| {
            let ([e0, e1], [a, b]) = (own(bend.edge), own(bend.opposite));
            Some(match bending {
                Bending::Isometric => {
                    let law = Bend::stiff([e0, e1, a, b].map(at), STIFFNESS)?;
                    Constraint::new([e0, e1, a, b], ConstraintKind::Bend(law))
                }
                Bending::Dihedral => {
                    let law = Hinge::rest([a, e0, e1, b].map(at));
                    let soft = Softness::compliant(compliance([e0, e1, a, b].map(at)));
                    Constraint::new([a, e0, e1, b], ConstraintKind::Hinge(law.with_softness(soft)))
                }
            })
        })
        .collect();
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut edges: Vec<[u32; 2]> = found.edges.iter().map(|&e| sorted(own(e))).collect();
    edges.sort_unstable();
    // The grid has two diagonals in each cell; this keeps the one that is an edge.
    grid.distances.retain(|d| edges.binary_search(&sorted([d.a, d.b])).is_ok());
    grid.constraints = bends;
    cloth::world(&grid, substeps, sweeps)
}

/// Compliance of a fold by θ, rad²/J, for the energy `½ B ‖e‖² θ² / (A₀ + A₁)` of a hinge of triangles.
fn compliance([e0, e1, a, b]: [Vec3; 4]) -> f32 {
    let edge = e1 - e0;
    let areas = 0.5 * (edge.cross(a - e0).length() + edge.cross(b - e0).length());
    areas / (STIFFNESS * edge.length_squared())
}
