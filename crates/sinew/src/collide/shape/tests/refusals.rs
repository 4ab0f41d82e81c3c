//! Input that is no valid shape is refused, with the reason.

use glam::Vec3;

use crate::collide::shape::{Shape, ShapeFault};
use crate::recipes::ConvexHullFault;

#[test]
fn invalid_sizes_are_refused() {
    for bad in [f32::NAN, 0.0, -1.0, 1e-7, 1e7, f32::INFINITY] {
        assert_eq!(Shape::sphere(bad), Err(ShapeFault::Radius));
        assert_eq!(Shape::capsule(bad, 2.0), Err(ShapeFault::Radius));
        assert_eq!(Shape::capsule(1.0, bad), Err(ShapeFault::Height));
        assert_eq!(Shape::cylinder(bad, 2.0), Err(ShapeFault::Radius));
        assert_eq!(Shape::cylinder(1.0, bad), Err(ShapeFault::Height));
        for axis in 0..3 {
            let mut size = Vec3::ONE;
            size[axis] = bad;
            assert_eq!(Shape::cuboid(size * 2.0), Err(ShapeFault::Size));
            assert_eq!(Shape::height_field(2, 2, &[0.0; 4], size), Err(ShapeFault::Size));
        }
    }
    assert_eq!(
        Shape::sphere(-1.0).unwrap_err().to_string(),
        "its radius is not between 1e-6 and 1e6 metres"
    );
}

#[test]
fn hulls_without_an_inside_are_refused() {
    let square = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::X + Vec3::Z];
    assert_eq!(Shape::hull(&square[..3]), Err(ConvexHullFault::TooFew.into()));
    assert_eq!(Shape::hull(&square), Err(ConvexHullFault::Flat.into()));
    assert_eq!(Shape::hull(&[Vec3::ONE; 9]), Err(ConvexHullFault::Flat.into()));
    let nearly = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(0.5, 1e-7, 0.5)];
    assert_eq!(Shape::hull(&nearly), Err(ConvexHullFault::Flat.into()));
    let thin = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(0.5, 1e-4, 0.5)];
    assert!(Shape::hull(&thin).is_ok());
    let mut points = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    assert_eq!(Shape::hull(&points.map(|p| p * 1e-7)), Err(ShapeFault::Size));
    points[2].y = f32::NAN;
    assert_eq!(Shape::hull(&points), Err(ShapeFault::Point(2)));
    points[2].y = 1e7;
    assert_eq!(Shape::hull(&points), Err(ShapeFault::Point(2)));
    assert_eq!(
        Shape::hull(&square).unwrap_err().to_string(),
        "it has no hull: the points all lie in a plane"
    );
}

#[test]
fn meshes_without_a_usable_triangle_are_refused_and_others_lose_their_bad_ones() {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X * 2.0, Vec3::X];
    let mesh = |triangles: &[[u32; 3]]| Shape::mesh(corners.clone(), triangles.to_vec());
    assert_eq!(mesh(&[]), Err(ShapeFault::NoArea));
    assert_eq!(mesh(&[[0, 1, 3], [0, 0, 2], [1, 2, 4]]), Err(ShapeFault::NoArea));
    assert_eq!(mesh(&[[0, 1, 2], [0, 1, 5]]), Err(ShapeFault::Corner(1)));
    assert_eq!(Shape::mesh(Vec::new(), Vec::new()), Err(ShapeFault::NoArea));
    let mut bad = corners.clone();
    bad[1].z = f32::NAN;
    assert_eq!(Shape::mesh(bad, vec![[0, 1, 2]]), Err(ShapeFault::Point(1)));
    let tiny = corners.iter().map(|p| *p * 1e-8).collect();
    assert_eq!(Shape::mesh(tiny, vec![[0, 1, 2]]), Err(ShapeFault::Size));
    assert_eq!(mesh(&[[0, 1, 3], [0, 1, 2], [1, 4, 2]]), mesh(&[[0, 1, 2]]));
}

#[test]
fn height_fields_without_a_cell_are_refused() {
    let field = |c, r, heights: &[f32]| Shape::height_field(c, r, heights, Vec3::ONE);
    assert_eq!(field(1, 4, &[0.0; 4]), Err(ShapeFault::Grid));
    assert_eq!(field(4, 1, &[0.0; 4]), Err(ShapeFault::Grid));
    assert_eq!(field(2, 2, &[0.0; 5]), Err(ShapeFault::Heights));
    assert_eq!(field(usize::MAX, 3, &[0.0; 5]), Err(ShapeFault::Heights));
    assert_eq!(field(2, 2, &[0.0, 0.0, f32::NAN, 0.0]), Err(ShapeFault::Altitude(2)));
    assert_eq!(field(2, 2, &[0.0, 2e6, 0.0, 0.0]), Err(ShapeFault::Altitude(1)));
    assert!(field(2, 2, &[0.0; 4]).is_ok());
}

#[test]
fn invalid_scales_are_refused() {
    let ball = Shape::sphere(1.0).unwrap();
    for bad in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
        assert_eq!(ball.scaled(Vec3::new(1.0, bad, 1.0)), Err(ShapeFault::Scale));
    }
    assert_eq!(ball.scaled(Vec3::splat(1e7)), Err(ShapeFault::Radius));
}
