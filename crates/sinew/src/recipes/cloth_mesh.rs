//! Cloth in any shape: a mesh goes in, as a modelling program exports it, and its vertices follow the particles.

use glam::Vec3;

use super::blueprint::{Blueprint, gap};
use super::cloth::{ClothFault, ClothMaterial};
use super::mesh::{Bend, Weld, weld};
use crate::constraints::Distance;

/// Cloth from a triangle list: a particle at each welded vertex ([`weld`]), a distance along each edge, and, unless the
/// material bends freely, a compliant distance between the two corners opposite each inner edge.
///
/// A particle has a third of the mass of each triangle around it. Distances come in the order of [`Weld::edges`], and
/// then those across folds, sorted likewise; a pair that is tied already (the opposite corners in a tetrahedron are
/// themselves an edge) is not tied again. [`Blueprint::vertices`] names the particle of each vertex of the mesh.
pub fn cloth_from_mesh(
    positions: &[Vec3],
    indices: &[u32],
    material: &ClothMaterial,
) -> Result<Blueprint, ClothFault> {
    material.check()?;
    let Weld { positions, triangles, vertices, edges, bends } =
        weld(positions, indices, material.weld_tolerance)?;
    let masses = masses(&positions, &triangles, material.density);
    let particles = positions.iter().zip(masses).map(|(p, mass)| material.seed(*p, mass)).collect();
    let tie = |[a, b]: [u32; 2], compliance| {
        let rest = gap(positions[a as usize], positions[b as usize]);
        Distance::new(a, b, rest).with_compliance(compliance)
    };
    let mut distances: Vec<Distance> =
        edges.iter().map(|&edge| tie(edge, material.stretch_compliance)).collect();
    if let Some(compliance) = material.bend_compliance {
        distances.extend(folds(&edges, &bends).map(|pair| tie(pair, compliance)));
    }
    let body = Blueprint { particles, distances, triangles, vertices, ..Blueprint::default() };
    let lengths = body.distances.iter().map(|d| d.rest);
    // Lengths are squared and masses inverted in `f32` at every sweep.
    let ordinary = lengths.map(|rest| rest * rest).chain(body.particles.iter().map(|p| p.mass));
    if ordinary.into_iter().all(|x| x.is_normal() && (1.0 / x).is_normal()) {
        Ok(body)
    } else {
        Err(ClothFault::Scale)
    }
}

/// A third of each triangle's mass to each of its corners, kg.
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

/// The opposite corners of all bends, sorted, each pair once, and none that is an edge.
fn folds<'a>(edges: &'a [[u32; 2]], bends: &[Bend]) -> impl Iterator<Item = [u32; 2]> + use<'a> {
    let mut pairs: Vec<[u32; 2]> = bends.iter().map(|bend| bend.opposite).collect();
    pairs.sort_unstable_by_key(|&[a, b]| u64::from(a) << 32 | u64::from(b));
    pairs.dedup();
    let mut edges = edges.iter().peekable();
    pairs.into_iter().filter(move |pair| {
        while edges.next_if(|edge| *edge < pair).is_some() {}
        edges.peek() != Some(&pair)
    })
}

#[cfg(test)]
mod tests {
    use super::super::blueprint::checks::assert_at_rest;
    use super::super::{ClothSpec, MeshFault, cloth_grid};
    use super::*;

    /// A grid as a drawn mesh: each triangle with vertices of its own.
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
        assert_eq!(cloth(1.0, &light), Err(ClothFault::Density));
        assert_eq!(cloth(0.0, &good), Err(ClothFault::Mesh(MeshFault::AllDegenerate)));
        assert_eq!(cloth(1e30, &good), Err(ClothFault::Scale));
        let exact = ClothMaterial { weld_tolerance: 0.0, ..good };
        assert_eq!(cloth(1e-25, &exact), Err(ClothFault::Scale));
    }
}
