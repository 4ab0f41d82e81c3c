//! Positions of the bodies and stairs of scenes, shared by all engines.

use sinew::glam::{EulerRot, Quat, Vec3};

/// Initial positions of the boxes of a heap, metres.
pub(crate) fn stacked(edge: u32) -> impl Iterator<Item = Vec3> {
    (0..edge * edge * edge).map(move |n| {
        let (x, y, z) = (n % edge, n / (edge * edge), n / edge % edge);
        // Every second layer is offset by a quarter of a box, so that the boxes do not stay in columns.
        let aside = 0.25 * (y % 2) as f32;
        Vec3::new(1.05 * x as f32 + aside, 0.6 + 1.1 * y as f32, 1.05 * z as f32 + aside)
    })
}

/// Half extents and positions of stairs that descend below the [`places`], metres: two for each row of ragdolls.
pub(crate) fn stairs(side: u32) -> impl Iterator<Item = (Vec3, Vec3)> {
    let half = Vec3::new(0.5, 5.0, side as f32 + 10.0);
    (0..2 * side + 20).map(move |n| {
        let down = Vec3::new(n as f32 - 0.5, -0.2 * n as f32, side as f32 - 1.0);
        (half, down - Vec3::Y * half.y)
    })
}

/// Positions on a square grid, 2 m apart.
pub(crate) fn places(side: u32) -> impl Iterator<Item = Vec3> {
    (0..side * side).map(move |n| Vec3::new((n % side) as f32, 0.0, (n / side) as f32) * 2.0)
}

/// Initial poses of a thousand boxes of 1 m, metres: in rows, or in varied poses above the middle of [`pit`].
pub(crate) fn pile(poured: bool) -> impl Iterator<Item = (Vec3, Quat)> {
    (0..1000_u32).map(move |n| {
        let (layer, place) = (n / 100, n % 100);
        let [x, z] = [place % 10, place / 10].map(|i| 1.1 * (i as f32 - 4.5));
        let drift = 0.13 * (layer % 3) as f32;
        if poured {
            let [a, b, c] = [0.7, 1.3, 2.1].map(|by| by * n as f32);
            let turn = Quat::from_euler(EulerRot::XYZ, a, b, c);
            (Vec3::new(1.5 * x + drift, 1.0 + 1.8 * layer as f32, 1.5 * z - drift), turn)
        } else {
            (Vec3::new(x + drift, 0.6 + 1.2 * layer as f32, z - drift), Quat::IDENTITY)
        }
    })
}

/// Sizes and positions of four walls around poured boxes, metres.
pub(crate) fn pit() -> impl Iterator<Item = (Vec3, Vec3)> {
    let (reach, high) = (9.5, 20.0);
    let wide = 2.0 * reach;
    [(reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)].into_iter().map(move |(x, z)| {
        let size = if z == 0.0 { Vec3::new(1.0, high, wide) } else { Vec3::new(wide, high, 1.0) };
        (size, Vec3::new(x, 0.5 * high, z))
    })
}

/// Number of steps of the stairs of [`figures`], and the depth of each, metres.
const STEPS: u32 = 20;
const GOING: f32 = 0.42;

/// Sizes and positions of stairs with steps of height `rise` that descend along x, metres; none if it is 0.
pub(crate) fn flight(rise: f32) -> impl Iterator<Item = (Vec3, Vec3)> {
    (0..STEPS).filter_map(move |n| {
        let high = rise * (STEPS - n) as f32;
        let place = Vec3::new(GOING * n as f32, 0.5 * high, 0.0);
        (high > 0.0).then_some((Vec3::new(GOING, high, 24.0), place))
    })
}

/// Initial poses of a hundred ragdolls above such stairs, metres.
pub(crate) fn figures(rise: f32) -> impl Iterator<Item = (Vec3, Quat)> {
    (0..100_u32).map(move |n| {
        let (row, place) = (n / 20, n % 20);
        let turn = Quat::from_rotation_y(0.5 * n as f32) * Quat::from_rotation_z(-0.7);
        let x = 1.6 * row as f32;
        let above = rise * (STEPS as f32 - x / GOING).max(0.0);
        (Vec3::new(x, 1.6 + above, 1.15 * (place as f32 - 9.5)), turn)
    })
}

/// Positions of a thousand boxes of 1 m that lie side by side, metres.
pub(crate) fn lying() -> impl Iterator<Item = Vec3> {
    (0..1000_u32).map(|n| Vec3::new(1.5 * (n % 32) as f32, 0.5, 1.5 * (n / 32) as f32))
}
