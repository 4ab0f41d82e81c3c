//! Where bodies and stairs of a scene stand: the same for ours and for a rival's.

use sinew::glam::Vec3;

/// Where the boxes of a heap begin, metres.
pub(crate) fn stacked(edge: u32) -> impl Iterator<Item = Vec3> {
    (0..edge * edge * edge).map(move |n| {
        let (x, y, z) = (n % edge, n / (edge * edge), n / edge % edge);
        // Every second layer is moved by a quarter of a box, so that they do not stay columns.
        let aside = 0.25 * (y % 2) as f32;
        Vec3::new(1.05 * x as f32 + aside, 0.6 + 1.1 * y as f32, 1.05 * z as f32 + aside)
    })
}

/// Half the sizes and the places of stairs that go down below the [`places`], metres: two for each row of ragdolls.
pub(crate) fn stairs(side: u32) -> impl Iterator<Item = (Vec3, Vec3)> {
    let half = Vec3::new(0.5, 5.0, side as f32 + 10.0);
    (0..2 * side + 20).map(move |n| {
        let down = Vec3::new(n as f32 - 0.5, -0.2 * n as f32, side as f32 - 1.0);
        (half, down - Vec3::Y * half.y)
    })
}

/// Places on a square with 2 m between them.
pub(crate) fn places(side: u32) -> impl Iterator<Item = Vec3> {
    (0..side * side).map(move |n| Vec3::new((n % side) as f32, 0.0, (n / side) as f32) * 2.0)
}
