//! Cloth of any shape, from a mesh as exported by a modelling program, whose vertices follow the particles.

use glam::Vec3;

use super::blueprint::{Blueprint, rest_length};
use super::cloth::ClothMaterial;
use super::fault::RecipeFault;
use super::mesh::{Edges, Piece, Welded, sort, weld_with_edges};
use crate::constraints::Distance;

/// Builds cloth from a triangle list: a particle at each welded vertex ([`weld`](super::weld)), a distance along each edge, and, unless the material bends
/// freely, a compliant distance between the two corners opposite each inner edge.
///
/// A particle has a third of the mass of each triangle around it. Particles are numbered as in [`Weld`](super::Weld), not as the vertices are:
/// [`Blueprint::vertices`] holds the particle of each vertex of the mesh, so to pin a vertex, pin that particle.
///
/// Distances along edges come first, then those across folds. A pair that is connected already (the opposite corners in a tetrahedron are themselves an edge)
/// gets no second distance. Both groups are sorted by their lower and then their higher particle; in a mesh that is a grid, those along rows come first, then
/// those across rows, and then those along either diagonal.
pub fn cloth_from_mesh(
    positions: &[Vec3],
    indices: &[u32],
    material: &ClothMaterial,
) -> Result<Blueprint, RecipeFault> {
    material.check()?;
    let Welded { positions, triangles, vertices, edges, pieces } =
        weld_with_edges(positions, indices, material.weld_tolerance)?;
    let masses = masses(&positions, &triangles, material.density);
    let particles = positions.iter().zip(masses).map(|(p, mass)| material.seed(*p, mass)).collect();
    let tie = |[a, b]: [u32; 2], compliance| {
        let rest = rest_length(positions[a as usize], positions[b as usize]);
        Distance::new(a, b, rest).with_compliance(compliance)
    };
    // There are about as many folds as edges, or somewhat fewer.
    let mut distances = Vec::with_capacity(2 * edges.list.len());
    let steps = |w| [1, w, w + 1, w - 1];
    let thread = |edge| distances.push(tie(edge, material.stretch_compliance));
    by_family(&edges.list, |edge| edge.ends, &pieces, steps, thread);
    if let Some(compliance) = material.bend_compliance {
        // The other diagonal of a cell; two cells along a row, level or not; and two down a column, straight or not.
        let steps = |w: u32| [w - 1, w + 1, 2, w + 2, w.abs_diff(2), 2 * w, 2 * w + 1, 2 * w - 1];
        let fold = |pair| distances.push(tie(pair, compliance));
        by_family(&folds(&edges, positions.len()), |pair| *pair, &pieces, steps, fold);
    }
    let body = Blueprint { particles, distances, triangles, vertices, ..Blueprint::default() };
    let lengths = body.distances.iter().map(|d| d.rest);
    // Lengths are squared and masses inverted in `f32` in every sweep, so these and their inverses must be normal numbers.
    let ordinary = lengths.map(|rest| rest * rest).chain(body.particles.iter().map(|p| p.mass));
    if ordinary.into_iter().all(|x| (f32::MIN_POSITIVE..=1.0 / f32::MIN_POSITIVE).contains(&x)) {
        Ok(body)
    } else {
        Err(RecipeFault::Scale)
    }
}

/// Distributes a third of each triangle's mass to each of its corners, kg.
fn masses(positions: &[Vec3], triangles: &[[u32; 3]], density: f32) -> Vec<f64> {
    let mut masses = vec![0.0; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
        let share = (b - a).cross(c - a).length() * f64::from(density) / 6.0;
        for &i in t {
            masses[i as usize] += share;
        }
    }
    masses
}

/// The opposite corners of all bends, sorted, each pair once, without pairs that are edges.
fn folds(edges: &Edges, particles: usize) -> Vec<[u32; 2]> {
    let mut pairs = Vec::with_capacity(edges.list.len());
    pairs.extend(edges.bends().map(|bend| bend.opposite));
    sort(&mut pairs, particles, |pair| pair[0], |pair| pair[1].into());
    pairs.dedup();
    let mut edges = edges.list.iter().map(|edge| edge.ends).peekable();
    pairs.retain(|pair| {
        while edges.next_if(|edge| edge < pair).is_some() {}
        edges.peek() != Some(pair)
    });
    pairs
}

/// Passes sorted pairs to `emit`, piece by piece. In a grid the two ends of every pair differ by one of a few steps, and pairs are grouped by step, so that
/// pairs with consecutive ends follow each other. `steps` gives the steps for a row of that many particles.
fn by_family<T, const N: usize>(
    pairs: &[T],
    ends: impl Fn(&T) -> [u32; 2],
    pieces: &[Piece],
    steps: impl Fn(u32) -> [u32; N],
    mut emit: impl FnMut([u32; 2]),
) {
    let mut rest = pairs;
    for piece in pieces {
        let (own, others) =
            rest.split_at(rest.partition_point(|pair| ends(pair)[0] < piece.particles.end));
        rest = others;
        let Some(columns) = piece.columns else {
            own.iter().for_each(|pair| emit(ends(pair)));
            continue;
        };
        let steps = steps(columns);
        let mut left = own.len();
        for (i, step) in steps.iter().enumerate() {
            // In narrow grids some steps are equal.
            if left > 0 && !steps[..i].contains(step) {
                for pair in own.iter().map(&ends).filter(|[a, b]| b - a == *step) {
                    emit(pair);
                    left -= 1;
                }
            }
        }
        debug_assert_eq!(left, 0, "a tie of a grid that is in no family");
    }
}

#[cfg(test)]
mod tests {
    use super::super::blueprint::checks::assert_at_rest;
    use super::super::{ClothSpec, MeshFault, cloth_grid};
    use super::*;

    /// A grid as a mesh for rendering: each triangle with vertices of its own.
    fn torn_apart(spec: &ClothSpec) -> (Vec<Vec3>, Vec<u32>) {
        let grid = cloth_grid(spec).unwrap();
        let corners = grid.triangles.iter().flatten();
        let positions: Vec<Vec3> = corners.map(|&i| grid.particles[i as usize].position).collect();
        let indices = (0..positions.len() as u32).collect();
        (positions, indices)
    }

    #[test]
    fn a_mesh_of_loose_triangles_becomes_one_cloth() {
        let spec = ClothSpec { columns: 6, rows: 4, height: 0.5, ..ClothSpec::default() };
        let (positions, indices) = torn_apart(&spec);
        let body = cloth_from_mesh(&positions, &indices, &spec.material).unwrap();
        assert_at_rest(&body);
        assert_eq!((body.particles.len(), body.triangles.len()), (7 * 5, 2 * 24));
        let edges = 6 * 5 + 4 * 7 + 24;
        let inner = edges - 2 * (6 + 4);
        assert_eq!(body.distances.len(), edges + inner);
        assert!((body.total_mass() - 0.1).abs() < 1e-7);
        for (vertex, position) in body.vertices.iter().zip(&positions) {
            assert_eq!(body.particles[*vertex as usize].position, *position);
        }
    }

    #[test]
    fn opposite_corners_that_are_an_edge_or_come_twice_are_tied_once() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let faces = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2];
        let tetrahedron = cloth_from_mesh(&corners, &faces, &ClothMaterial::default()).unwrap();
        assert_at_rest(&tetrahedron);
        assert_eq!(tetrahedron.distances.len(), 6);
        let ring = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        let faces: Vec<u32> = (0..4).flat_map(|i| [i, (i + 1) % 4, 4, (i + 1) % 4, i, 5]).collect();
        let octahedron = cloth_from_mesh(&ring, &faces, &ClothMaterial::default()).unwrap();
        assert_at_rest(&octahedron);
        assert_eq!(octahedron.distances.len(), 12 + 3, "three diagonals, each named four times");
    }

    #[test]
    fn a_freely_bending_cloth_has_its_edges_only() {
        let (positions, indices) =
            torn_apart(&ClothSpec { columns: 2, rows: 1, ..ClothSpec::default() });
        let material = ClothMaterial { bend_compliance: None, ..ClothMaterial::default() };
        let body = cloth_from_mesh(&positions, &indices, &material).unwrap();
        assert_eq!(body.distances.len(), 4 + 3 + 2);
    }

    #[test]
    fn faults_of_material_mesh_and_units_are_told_apart() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let good = ClothMaterial::default();
        let cloth = |scale: f32, material: &ClothMaterial| {
            cloth_from_mesh(&corners.map(|c| c * scale), &[0, 1, 2], material)
        };
        assert!(cloth(1.0, &good).is_ok());
        let light = ClothMaterial { density: 0.0, ..good };
        assert_eq!(cloth(1.0, &light), Err(RecipeFault::Density));
        assert_eq!(cloth(0.0, &good), Err(RecipeFault::Mesh(MeshFault::AllDegenerate)));
        assert_eq!(cloth(1e30, &good), Err(RecipeFault::Scale));
        let exact = ClothMaterial { weld_tolerance: 0.0, ..good };
        assert_eq!(cloth(1e-25, &exact), Err(RecipeFault::Scale));
    }
}
