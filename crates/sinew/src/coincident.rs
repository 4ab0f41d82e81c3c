//! Vertices that coincide: a closed surface often comes as triangles with vertices of their own, so that each has its own normals and texture coordinates.

use glam::Vec3;

/// For each vertex the index of the first one at the same position, bit for bit, with -0 equal to 0.
pub(crate) fn first_coincident(positions: &[Vec3]) -> Vec<u32> {
    // Adding zero turns -0 into 0.
    let key = |i: u32| (positions[i as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&i| (key(i), i));
    let mut first = vec![0; positions.len()];
    for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &i in same {
            first[i as usize] = same[0];
        }
    }
    first
}
