//! Welding of whole meshes, of invalid ones and of noise.

use std::collections::BTreeSet;

use super::*;
use crate::test_random::Random;

/// A cube of 1 m as a render mesh: 4 vertices a face, 24 in all.
fn drawn_cube() -> (Vec<Vec3>, Vec<u32>) {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let first = positions.len() as u32;
            for corner in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let mut p = [side; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = corner;
                positions.push(Vec3::from(p));
            }
            let quad = if side == 1.0 { [0, 1, 2, 0, 2, 3] } else { [0, 2, 1, 0, 3, 2] };
            indices.extend(quad.map(|i| first + i));
        }
    }
    (positions, indices)
}

#[test]
fn the_seams_of_a_drawn_cube_close() {
    let (mut positions, indices) = drawn_cube();
    for (i, p) in positions.iter_mut().enumerate() {
        p.x += i as f32 * 1e-7; // exporters round
    }
    let cube = weld(&positions, &indices, 1e-5).unwrap();
    let counts = [cube.positions.len(), cube.triangles.len(), cube.edges.len(), cube.bends.len()];
    assert_eq!(counts, [8, 12, 18, 18]);
    let corners = cube.triangles.iter().map(|t| t.map(|i| cube.positions[i as usize]));
    let volume: f32 = corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
    assert!((volume - 1.0).abs() < 1e-5, "the winding is kept: {volume}");
    for (v, p) in positions.iter().enumerate() {
        let followed = cube.positions[cube.vertices[v] as usize];
        assert!(p.distance(followed) <= 1e-5);
    }
    assert_eq!(weld(&positions, &indices, 0.0).unwrap().positions.len(), 24, "nothing is equal");
}

#[test]
fn shuffled_vertices_change_nothing_but_the_numbers() {
    let (positions, indices) = drawn_cube();
    let named = |weld: &Weld| {
        let name = |i: u32| weld.positions[i as usize].to_array().map(|x| x as i32);
        let pair = |p: [u32; 2]| BTreeSet::from(p.map(name));
        let edges: BTreeSet<_> = weld.edges.iter().map(|&e| pair(e)).collect();
        let bends: BTreeSet<_> =
            weld.bends.iter().map(|b| (pair(b.edge), pair(b.opposite))).collect();
        let turned = |t: [[i32; 3]; 3]| {
            let lowest = (0..3).min_by_key(|&k| t[k]).unwrap();
            [0, 1, 2].map(|k| t[(lowest + k) % 3])
        };
        let triangles: BTreeSet<_> = weld.triangles.iter().map(|t| turned(t.map(name))).collect();
        (edges, bends, triangles)
    };
    let straight = weld(&positions, &indices, 1e-5).unwrap();
    assert_eq!(straight, weld(&positions, &indices, 1e-5).unwrap());
    let mut random = Random::new(3);
    for _ in 0..20 {
        let mut order: Vec<u32> = (0..24).collect();
        for i in (1..24).rev() {
            order.swap(i, random.below(i + 1));
        }
        let mut shuffled = vec![Vec3::ZERO; 24];
        for (v, &to) in order.iter().enumerate() {
            shuffled[to as usize] = positions[v];
        }
        let renumbered: Vec<u32> = indices.iter().map(|&i| order[i as usize]).collect();
        let other = weld(&shuffled, &renumbered, 1e-5).unwrap();
        assert_eq!(named(&other), named(&straight));
    }
}

#[test]
fn degenerate_and_repeated_triangles_go_and_stray_vertices_follow_the_nearest() {
    let mut positions = vec![Vec3::NAN; 6];
    positions[0] = Vec3::new(9.0, 0.1, 0.0); // used by nothing
    positions[1] = Vec3::ZERO;
    positions[2] = Vec3::X * 10.0;
    positions[3] = Vec3::Y;
    positions[4] = Vec3::X * 6.0; // only in a triangle without area
    positions[5] = Vec3::X * 3.0; // likewise
    let indices = [1, 4, 2, 1, 2, 3, 1, 1, 3, 3, 2, 1, 2, 3, 1, 5, 4, 2];
    let weld = weld(&positions, &indices, 1e-5).unwrap();
    assert_eq!(weld.triangles, [[0, 1, 2]]);
    assert_eq!(weld.positions, positions[1..4]);
    assert_eq!(weld.vertices, [1, 0, 1, 2, 1, 0]);
    assert_eq!(weld.edges, [[0, 1], [0, 2], [1, 2]]);
    assert_eq!(weld.bends, []);
}

#[test]
fn an_edge_of_three_triangles_does_not_bend() {
    let positions = [Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::Y, Vec3::NEG_X];
    let two = weld(&positions, &[0, 1, 2, 1, 0, 3], 1e-5).unwrap();
    let places = |pair: [u32; 2]| pair.map(|i| two.positions[i as usize]);
    assert_eq!(two.bends.len(), 1);
    let ([a, b], [c, d]) = (places(two.bends[0].edge), places(two.bends[0].opposite));
    assert_eq!(
        (a + b, a.min(b), c + d, c.min(d)),
        (Vec3::Z, Vec3::ZERO, Vec3::X + Vec3::Y, Vec3::ZERO)
    );
    let three = weld(&positions, &[0, 1, 2, 1, 0, 3, 0, 1, 4], 1e-5).unwrap();
    assert_eq!((three.edges.len(), three.bends.len()), (7, 0));
}

#[test]
fn a_chain_of_near_vertices_thins_out_and_does_not_collapse() {
    // 101 x 2 vertices, 0.6 mm apart, and a tolerance of 1 mm: every second one stays.
    let along = |i: u32, z: f32| Vec3::new(i as f32 * 6e-4, 0.0, z);
    let positions: Vec<Vec3> = (0..101).flat_map(|i| [along(i, 0.0), along(i, 1.0)]).collect();
    let indices: Vec<u32> = (0..100).flat_map(|i| [0, 1, 2, 2, 1, 3].map(|k| 2 * i + k)).collect();
    let weld = weld(&positions, &indices, 1e-3).unwrap();
    assert_eq!((weld.positions.len(), weld.triangles.len()), (102, 100));
}

#[test]
fn each_fault_is_told_apart() {
    let corner = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let line = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
    let nan = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, f32::NAN, 0.0)];
    assert_eq!(weld(&[], &[0, 1, 2], 0.0), Err(MeshFault::Empty));
    assert_eq!(weld(&corner, &[], 0.0), Err(MeshFault::Empty));
    assert_eq!(weld(&corner, &[0, 1], 0.0), Err(MeshFault::NotTriangles(2)));
    assert_eq!(weld(&nan, &[0, 1, 2], 0.0), Err(MeshFault::NotFinite(2)));
    let fault = MeshFault::IndexOutOfRange { index: 3, vertices: 3 };
    assert_eq!(weld(&corner, &[0, 1, 3], 0.0), Err(fault));
    assert_eq!(fault.to_string(), "its mesh names vertex 3, but has 3");
    assert_eq!(weld(&corner, &[0, 1, 2], f32::NAN), Err(MeshFault::Tolerance));
    assert_eq!(weld(&corner, &[0, 1, 2], -1.0), Err(MeshFault::Tolerance));
    assert_eq!(weld(&corner, &[0, 1, 2], 5.0), Err(MeshFault::AllDegenerate));
    assert_eq!(weld(&corner, &[0, 1, 0], 0.0), Err(MeshFault::AllDegenerate));
    assert_eq!(weld(&line, &[0, 1, 2], 0.0), Err(MeshFault::AllDegenerate));
}

#[test]
fn noise_is_welded_or_refused_but_never_worse() {
    use super::super::{ClothMaterial, cloth_from_mesh};
    let mut random = Random::new(11);
    let mut built = 0;
    for _ in 0..1000 {
        let scale = [1e-30, 1e-3, 1.0, 1e30][random.below(4)];
        let grid = 1 + random.below(8);
        let odd = [f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, f32::MIN_POSITIVE, -0.0];
        let mut coordinate = || match random.below(400) {
            0 => odd[random.below(6)],
            _ => random.below(grid) as f32 * scale,
        };
        let positions: Vec<Vec3> =
            (0..12).map(|_| Vec3::new(coordinate(), coordinate(), coordinate())).collect();
        let positions = &positions[..random.below(13)];
        let count = 3 * random.below(20) + usize::from(random.below(50) == 0);
        let end = positions.len() + usize::from(random.below(50) == 0);
        let indices: Vec<u32> = (0..count).map(|_| random.below(end.max(1)) as u32).collect();
        let tolerance = [0.0, 1e-5, 0.5, 1e20][random.below(4)];
        if let Ok(weld) = weld(positions, &indices, tolerance) {
            let particles = weld.positions.len() as u32;
            assert_eq!(weld.vertices.len(), positions.len());
            assert!(weld.vertices.iter().all(|&v| v < particles));
            assert!(weld.triangles.iter().flatten().all(|&v| v < particles));
            let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
            let sides = |&[a, b, c]: &[u32; 3]| [sorted(a, b), sorted(b, c), sorted(c, a)];
            let edges: BTreeSet<_> = weld.triangles.iter().flat_map(sides).collect();
            assert!(weld.edges.iter().eq(&edges), "{:?}", weld.edges);
            let count = |edge: [u32; 2]| {
                weld.triangles.iter().filter(|&t| sides(t).contains(&edge)).count()
            };
            let inner = edges.iter().filter(|&&edge| count(edge) == 2);
            assert!(weld.bends.iter().map(|bend| &bend.edge).eq(inner));
            let ends = weld.pieces.iter().map(|piece| piece.particles.end);
            assert_eq!(ends.clone().next_back(), Some(particles));
            assert!(
                weld.pieces
                    .iter()
                    .skip(1)
                    .map(|piece| piece.particles.start)
                    .eq(ends.take(weld.pieces.len() - 1))
            );
        }
        let material = ClothMaterial { weld_tolerance: tolerance, ..ClothMaterial::default() };
        if let Ok(body) = cloth_from_mesh(positions, &indices, &material) {
            super::super::blueprint::checks::assert_at_rest(&body);
            assert!(body.total_mass().is_finite());
            built += 1;
        }
    }
    assert!(built > 100, "the noise is not all refused: {built}");
}

mod order;
