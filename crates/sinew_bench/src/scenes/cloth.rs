//! Cloth that hangs by two corners: P1 as a grid, P2 as a mesh with shuffled vertices; also used for the plot of growth.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{Blueprint, ClothMaterial, ClothSpec, cloth_from_mesh, cloth_grid};
use sinew::{Distance, Simulation, SolverSettings};

use super::empty;
use crate::measure::{Effort, Ours, Race};
use crate::naive::Naive;
use crate::peers;
use crate::row::{Row, Unit};

/// Particles along a side in P1 and P2.
const SIDE: u32 = 128;

/// Substeps in a tick of P1 and P2.
const SUBSTEPS: u32 = 10;

/// Length of a cell, m. With this length the largest stretch at this many substeps is that of the table of goals; finer cells stretch more under the same
/// sweeps, because gravity moves a particle by a larger part of a cell.
pub const CELL: f32 = 0.1;

/// A quarter turn about x: the sheet starts horizontal, so that it swings down and folds as cloth does; in its own plane it would stay flat.
const LEVEL: Quat =
    Quat::from_xyzw(-core::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, core::f32::consts::FRAC_1_SQRT_2);

/// P1.
pub fn grid(effort: &Effort) -> Vec<Row> {
    let scene = format!("cloth grid {SIDE}×{SIDE}, two corners pinned");
    let sheet = sheet(SIDE);
    vec![race(effort, "P1", scene, &sheet, &sheet)]
}

/// P2.
pub fn mesh(effort: &Effort) -> Vec<Row> {
    let (cut, given) = mesh_and_given(SIDE);
    let scene = "the same as a mesh, vertices shuffled".to_string();
    let mesh = race(effort, "P2", scene, &cut, &given);
    let scattered = scattered(SIDE);
    let scene = "the same with shuffled rows, without the recipe for meshes".to_string();
    let rows = race(effort, "P2", scene, &scattered, &scattered);
    let note = "a mesh has one diagonal a cell, and so fewer constraints; naive and rapier have the particles in the order of the vertices";
    vec![mesh.noted(note), rows]
}

/// A sheet of `side × side` particles, [`CELL`] apart, with hard distances along rows, columns and both diagonals of each cell, and without bending
/// constraints. Horizontal, with both ends of its top row pinned.
pub fn sheet(side: u32) -> Blueprint {
    let spec = spec(side);
    let mut sheet = cloth_grid(&spec).expect("the grid is sound").transformed(LEVEL, Vec3::ZERO);
    for corner in &spec.corners()[..2] {
        sheet.pin(*corner).expect("the corner is there");
    }
    sheet
}

/// The same sheet as a mesh whose vertices are shuffled with a fixed seed, twice: as the recipe for meshes makes it, which may renumber the particles; and with
/// the particles in the order of the vertices and the edges sorted.
pub fn mesh_and_given(side: u32) -> (Blueprint, Blueprint) {
    let spec = spec(side);
    let grid = cloth_grid(&spec).expect("the grid is sound").transformed(LEVEL, Vec3::ZERO);
    let place = shuffle(grid.particles.len());
    let mut positions = vec![Vec3::ZERO; grid.particles.len()];
    for (particle, &place) in grid.particles.iter().zip(&place) {
        positions[place as usize] = particle.position;
    }
    let indices: Vec<u32> = grid.triangles.iter().flatten().map(|&i| place[i as usize]).collect();
    let cut = cloth_from_mesh(&positions, &indices, &spec.material);
    let mut cut = cut.expect("the mesh is sound");
    for corner in &spec.corners()[..2] {
        let vertex = place[*corner as usize];
        cut.pin(cut.vertices[vertex as usize]).expect("the corner is there");
    }
    let mut vertex_of = vec![0; cut.particles.len()];
    (0..).zip(&cut.vertices).for_each(|(v, &particle): (u32, &u32)| {
        vertex_of[particle as usize] = v;
    });
    let given = renumbered(&cut, &vertex_of);
    (cut, given)
}

/// The sheet with its particles shuffled and its distances sorted: what a mesh looks like without renumbering.
pub fn scattered(side: u32) -> Blueprint {
    let sheet = sheet(side);
    let place = shuffle(sheet.particles.len());
    renumbered(&sheet, &place)
}

/// A simulation of one body with a fixed number of sweeps in each substep.
pub fn world(body: &Blueprint, substeps: u32, sweeps: u32) -> Simulation {
    let settings = SolverSettings {
        substeps,
        max_sweeps: sweeps,
        tolerance: 0.0,
        microsteps: false,
        ..Default::default()
    };
    let mut world = empty(settings);
    body.build(&mut world).expect("the recipe is sound");
    world
}

/// A race over one body; the other contenders use `given`.
fn race(
    effort: &Effort,
    id: &'static str,
    scene: String,
    body: &Blueprint,
    given: &Blueprint,
) -> Row {
    let [ours, given] = [body, given].map(|body| world(body, SUBSTEPS, 1));
    let constraints = ours.distances().len();
    let race = Race::between(Ours(ours), Naive::of(&given));
    let race = race.against(peers::soft(effort, &given));
    let row = Row::new(id, scene, Unit::Projection).sized(constraints, SUBSTEPS, 1);
    race.run(effort, constraints * SUBSTEPS as usize, row)
}

/// The particles and distances of a body with the particles renumbered, and the distances sorted by the new numbers.
fn renumbered(body: &Blueprint, number: &[u32]) -> Blueprint {
    let mut particles = body.particles.clone();
    for (seed, &number) in body.particles.iter().zip(number) {
        particles[number as usize] = *seed;
    }
    let ends = |d: &Distance| {
        let [a, b] = [d.a, d.b].map(|i| number[i as usize]);
        Distance { a: a.min(b), b: a.max(b), ..*d }
    };
    let mut distances: Vec<Distance> = body.distances.iter().map(ends).collect();
    distances.sort_unstable_by_key(|d| [d.a, d.b]);
    Blueprint { particles, distances, ..Blueprint::default() }
}

fn spec(side: u32) -> ClothSpec {
    let material = ClothMaterial { bend_compliance: None, ..ClothMaterial::default() };
    let (cells, length) = (side - 1, CELL * (side - 1) as f32);
    ClothSpec { width: length, height: length, columns: cells, rows: cells, shear: true, material }
}

/// A random permutation of `count` items (Fisher–Yates shuffle), by a 64-bit xorshift generator (Marsaglia) with a fixed seed.
pub fn shuffle(count: usize) -> Vec<u32> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut place: Vec<u32> = (0..count as u32).collect();
    for i in (1..count).rev() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        place.swap(i, (state % (i as u64 + 1)) as usize);
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sheet_of_the_table_has_64_770_constraints_and_two_pins() {
        let sheet = sheet(SIDE);
        assert_eq!(sheet.distances.len(), 64_770);
        assert_eq!(sheet.particles.iter().filter(|p| p.mass.is_infinite()).count(), 2);
    }

    #[test]
    fn a_shuffled_sheet_is_the_same_sheet() {
        let (cut, given) = mesh_and_given(8);
        let (grid, scattered) = (sheet(8), scattered(8));
        let [first, second, third, last] = [&grid, &cut, &given, &scattered].map(|body| {
            let mut at: Vec<_> =
                body.particles.iter().map(|p| p.position.to_array().map(f32::to_bits)).collect();
            at.sort_unstable();
            at
        });
        assert!(first == second && first == third && first == last);
        assert_ne!(grid.particles[5].position, given.particles[5].position);
        assert_ne!(grid.particles[5].position, scattered.particles[5].position);
        assert_eq!(cut.distances.len(), 2 * 7 * 8 + 7 * 7);
        assert_eq!(scattered.distances.len(), grid.distances.len());
        for body in [&cut, &given, &scattered] {
            let at = |i: u32| body.particles[i as usize].position;
            assert!(body.distances.iter().all(|d| d.error(at(d.a), at(d.b)) < 1e-6));
            assert_eq!(body.particles.iter().filter(|p| p.mass.is_infinite()).count(), 2);
        }
    }
}
