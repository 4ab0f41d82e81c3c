//! Mass properties compared with closed forms, and invalid meshes.

use super::*;
use crate::convex_hull::convex_hull;
use glam::{DQuat, Quat};

/// Largest difference of two symmetric matrices, relative to the trace of the second.
fn off(a: DMat3, b: DMat3) -> f64 {
    let trace = b.x_axis.x + b.y_axis.y + b.z_axis.z;
    (a - b).to_cols_array().into_iter().fold(0.0, |worst: f64, x| worst.max(x.abs())) / trace
}

/// Checks volume, barycentre and spread of a mesh, as given and rotated and moved.
fn assert_is(points: &[Vec3], triangles: &[[u32; 3]], volume: f64, mean: DVec3, spread: DMat3) {
    let turn = DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize();
    let r = DMat3::from_quat(turn);
    for (turn, shift) in [(DMat3::IDENTITY, DVec3::ZERO), (r, DVec3::new(3.0, -2.0, 1.5))] {
        let moved: Vec<Vec3> =
            points.iter().map(|p| (turn * p.as_dvec3() + shift).as_vec3()).collect();
        let found = MassProperties::of_mesh(&moved, triangles).unwrap();
        let size = spread.to_cols_array().into_iter().fold(0.0, f64::max).sqrt();
        assert!((found.volume / volume - 1.0).abs() < 1e-6, "{} {volume}", found.volume);
        let away = (found.barycentre - (turn * mean + shift)).length();
        assert!(away < 1e-6 * size.max(1.0), "{} {mean}", found.barycentre);
        let wanted = turn * spread * turn.transpose();
        assert!(off(found.spread, wanted) < 1e-6, "{} {wanted}", found.spread);
    }
}

fn hull(points: &[Vec3]) -> Vec<[u32; 3]> {
    convex_hull(points).unwrap()
}

#[test]
fn a_tetrahedron_is_as_the_integral_says() {
    let (a, b, c) = (1.0_f64, 2.0, 3.0);
    let points = [Vec3::ZERO, Vec3::X, Vec3::Y * 2.0, Vec3::Z * 3.0];
    let spread = DMat3::from_cols(
        DVec3::new(3.0 * a * a, -a * b, -a * c),
        DVec3::new(-a * b, 3.0 * b * b, -b * c),
        DVec3::new(-a * c, -b * c, 3.0 * c * c),
    ) * (1.0 / 80.0);
    let mean = DVec3::new(a, b, c) / 4.0;
    assert_is(&points, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], 1.0, mean, spread);
    assert_is(&points, &hull(&points), 1.0, mean, spread);
}

#[test]
fn an_octahedron_has_a_fifth_of_its_half_diagonal_squared() {
    let points = [Vec3::X, Vec3::Y, Vec3::Z].map(|e| [e * 0.5, e * -0.5]).concat();
    let spread = DMat3::from_diagonal(DVec3::splat(0.25 / 10.0));
    assert_is(&points, &hull(&points), 4.0 / 3.0 / 8.0, DVec3::ZERO, spread);
    let found = MassProperties::of_mesh(&points, &hull(&points)).unwrap();
    let inertia = found.inertia(2.0);
    assert!(inertia.abs_diff_eq(Mat3::from_diagonal(Vec3::splat(2.0 * 0.25 / 5.0)), 1e-7));
}

#[test]
fn a_cone_out_of_sixteen_sides_is_as_the_pyramid_over_its_base() {
    let (sides, radius, height) = (16, 0.5_f64, 2.0_f64);
    let step = core::f64::consts::TAU / f64::from(sides);
    let rim = |i: i32| {
        let (sin, cos) = libm::sincos(f64::from(i) * step);
        DVec3::new(radius * cos, radius * sin, 0.0).as_vec3()
    };
    let mut points: Vec<Vec3> = (0..sides).map(rim).collect();
    points.push(Vec3::Z * 2.0);
    let area = 0.5 * f64::from(sides) * radius * radius * libm::sin(step);
    // For a regular polygon the mean of x² is R² (2 + cos(2π/n)) / 12; for a pyramid over it, 3/5 of that.
    let across = 0.6 * radius * radius * (2.0 + libm::cos(step)) / 12.0;
    let spread = DMat3::from_diagonal(DVec3::new(across, across, 3.0 * height * height / 80.0));
    assert_is(&points, &hull(&points), area * height / 3.0, DVec3::Z * (height / 4.0), spread);
}

/// A prism 1 m high over a polygon in the xy plane, triangulated.
pub(crate) fn prism(polygon: &[[f32; 2]], caps: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let n = polygon.len() as u32;
    let level = |z: f32| polygon.iter().map(move |&[x, y]| Vec3::new(x, y, z));
    let mut triangles: Vec<[u32; 3]> =
        caps.iter().flat_map(|&[a, b, c]| [[a, c, b], [a + n, b + n, c + n]]).collect();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    (level(0.0).chain(level(1.0)).collect(), triangles)
}

/// An L-shaped prism: a foot of 2 × 1 and a leg of 1 × 2 on its left.
pub(crate) fn letter() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    prism(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]])
}

#[test]
fn a_letter_that_is_not_convex_is_the_sum_of_its_boxes() {
    let (points, triangles) = letter();
    // Foot and leg, 2 m³ each: mean, and spread about their own mean.
    let boxes = [
        (DVec3::new(1.0, 0.5, 0.5), DVec3::new(2.0, 1.0, 1.0)),
        (DVec3::new(0.5, 2.0, 0.5), DVec3::new(1.0, 2.0, 1.0)),
    ];
    let mean = (boxes[0].0 + boxes[1].0) * 0.5;
    let mut spread = DMat3::ZERO;
    for (at, size) in boxes {
        spread += (DMat3::from_diagonal(size * size / 12.0) + outer(at - mean, at - mean)) * 0.5;
    }
    assert_is(&points, &triangles, 4.0, mean, spread);
}

#[test]
fn a_cavity_and_a_second_piece_count_as_they_should() {
    let cube = |size: f32, at: Vec3| {
        let (points, triangles) =
            prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], &[[0, 1, 2], [0, 2, 3]]);
        let placed = points.into_iter().map(move |p| (p - 0.5) * size + at);
        (placed.collect::<Vec<_>>(), triangles)
    };
    let (mut points, mut triangles) = cube(2.0, Vec3::ZERO);
    let (inner, faces) = cube(1.0, Vec3::ZERO);
    triangles.extend(faces.iter().map(|&[a, b, c]| [a + 8, c + 8, b + 8]));
    points.extend(inner);
    let spread = DMat3::from_diagonal(DVec3::splat((8.0 * 4.0 - 1.0) / 12.0 / 7.0));
    assert_is(&points, &triangles, 7.0, DVec3::ZERO, spread);

    let (mut points, mut triangles) = cube(1.0, Vec3::X * 2.0);
    let (other, faces) = cube(1.0, Vec3::X * -2.0);
    triangles.extend(faces.iter().map(|t| t.map(|i| i + 8)));
    points.extend(other);
    let spread = DVec3::splat(1.0 / 12.0) + DVec3::X * 4.0;
    assert_is(&points, &triangles, 2.0, DVec3::ZERO, DMat3::from_diagonal(spread));
}

#[test]
fn vertices_that_are_split_along_a_seam_close_it_all_the_same() {
    let (points, triangles) = letter();
    let split: Vec<Vec3> = triangles.iter().flatten().map(|&i| points[i as usize] * -1.0).collect();
    // Mirrored, so the winding is reversed; and with zeros of both signs.
    let triangles: Vec<[u32; 3]> =
        (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 2, 3 * i + 1]).collect();
    assert!((MassProperties::of_mesh(&split, &triangles).unwrap().volume - 4.0).abs() < 1e-12);
}

#[test]
fn principal_axes_make_the_spread_again_and_a_cube_has_those_of_its_mesh() {
    let (points, triangles) = letter();
    let found = MassProperties::of_mesh(&points, &triangles).unwrap();
    let (squares, axes) = found.principal();
    let made = axes * DMat3::from_diagonal(squares) * axes.transpose();
    assert!(off(made, found.spread) < 1e-12);
    for k in 0..3 {
        assert!(axes.col(k)[k] > 0.5, "{axes}");
    }

    let turn = Mat3::from_quat(Quat::from_xyzw(0.1, 0.2, -0.3, 0.9).normalize());
    let corners: Vec<Vec3> = (0..8)
        .map(|i: u8| turn * Vec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into()))
        .collect();
    let cube = MassProperties::of_mesh(&corners, &hull(&corners)).unwrap();
    let (squares, axes) = cube.principal();
    assert!((squares * 12.0 - 1.0).abs().max_element() < 1e-6);
    assert!(off(axes, DMat3::IDENTITY) < 1e-12, "{axes}");
}

#[test]
fn each_fault_is_told_apart() {
    let (points, triangles) = letter();
    let of = |points: &[Vec3], triangles: &[[u32; 3]]| {
        MassProperties::of_mesh(points, triangles).unwrap_err()
    };
    assert_eq!(of(&[], &triangles), MassFault::Empty);
    assert_eq!(of(&points, &[]), MassFault::Empty);
    for bad in [f32::NAN, f32::INFINITY] {
        let mut spoilt = points.clone();
        spoilt[5].y = bad;
        assert_eq!(of(&spoilt, &triangles), MassFault::NotFinite(5));
    }
    assert_eq!(of(&points[..11], &triangles), MassFault::NoSuchVertex(5));
    assert!(matches!(of(&points, &triangles[1..]), MassFault::Open(..)));
    let mut turned = triangles.clone();
    turned[7].swap(0, 1);
    assert!(matches!(of(&points, &turned), MassFault::Open(..)));
    let inward: Vec<_> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(of(&points, &inward), MassFault::InsideOut);
    let flat: Vec<_> = points.iter().map(|p| p.with_z(0.1)).collect();
    assert_eq!(of(&flat, &triangles), MassFault::Flat);
    let thin: Vec<_> = points.iter().map(|p| p.with_z(p.z * 1e-7)).collect();
    assert_eq!(of(&thin, &triangles), MassFault::Flat);
    assert_eq!(of(&[Vec3::ONE; 12], &triangles), MassFault::Flat);
    let vast: Vec<_> = points.iter().map(|p| *p * 1e38).collect();
    assert!(
        (MassProperties::of_mesh(&vast, &triangles).unwrap().volume / 4e114 - 1.0).abs() < 1e-6
    );
}
