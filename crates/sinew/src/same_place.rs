//! Vertices in the same place: a closed surface often comes as triangles with corners of their own, for the sake of normals and textures.

use glam::Vec3;

/// For each vertex the first one in the same place, to the bit; the two zeros are one.
pub(crate) fn first_in_place(positions: &[Vec3]) -> Vec<u32> {
    // Adding zero makes of -0 the zero that it equals.
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
