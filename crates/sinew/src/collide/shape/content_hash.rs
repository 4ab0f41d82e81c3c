//! Content hash of a shape.

use glam::Vec3;

use super::Form;
use crate::hash::fnv;

/// Hash of the kind and the numbers of a form.
pub(super) fn of(form: &Form) -> u64 {
    let alone = core::iter::empty();
    match form {
        Form::HalfSpace => mixed(1, alone),
        Form::Ball(ball) => mixed(2, [Vec3::splat(ball.radius)]),
        Form::Capsule(capsule) => mixed(3, [Vec3::new(capsule.radius, capsule.half_height, 0.0)]),
        Form::Cuboid(cuboid) => mixed(4, [cuboid.half_size]),
        Form::Cylinder(cylinder) => {
            mixed(5, [Vec3::new(cylinder.radius, cylinder.half_height, 0.0)])
        }
        Form::Hull(hull) => mixed(6, hull.points.iter().copied()),
        Form::Mesh(mesh) => mixed(7, mesh.corners()),
        Form::Heights(heights) => mixed(8, heights.numbers()),
        Form::InsideBox(hollow) => mixed(9, [hollow.half_size]),
    }
}

fn mixed(kind: u32, numbers: impl IntoIterator<Item = Vec3>) -> u64 {
    let numbers = numbers.into_iter().flat_map(|v| v.to_array());
    fnv(core::iter::once(kind).chain(numbers.map(f32::to_bits)))
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;

    #[test]
    fn equal_shapes_have_equal_hashes_and_others_do_not() {
        let corners = |x: f32| [Vec3::ZERO, Vec3::X * x, Vec3::Y, Vec3::Z];
        let all = [
            Shape::half_space(),
            Shape::inside_box(Vec3::ONE).unwrap(),
            Shape::inside_box(Vec3::splat(2.0)).unwrap(),
            Shape::sphere(1.0).unwrap(),
            Shape::sphere(1.5).unwrap(),
            Shape::capsule(1.0, 3.0).unwrap(),
            Shape::cylinder(1.0, 3.0).unwrap(),
            Shape::cuboid(Vec3::splat(2.0)).unwrap(),
            Shape::cuboid(Vec3::new(2.0, 2.0, 3.0)).unwrap(),
            Shape::hull(&corners(1.0)).unwrap(),
            Shape::hull(&corners(1.5)).unwrap(),
            Shape::mesh(corners(1.0).to_vec(), vec![[0, 1, 2]]).unwrap(),
            Shape::mesh(corners(1.5).to_vec(), vec![[0, 1, 2]]).unwrap(),
            Shape::mesh(corners(1.0).to_vec(), vec![[0, 2, 1]]).unwrap(),
            Shape::height_field(2, 2, &[0.0; 4], Vec3::ONE).unwrap(),
            Shape::height_field(2, 2, &[0.0, 0.0, 0.0, 0.1], Vec3::ONE).unwrap(),
            Shape::height_field(2, 2, &[0.0; 4], Vec3::new(1.0, 1.0, 2.0)).unwrap(),
            Shape::height_field(2, 3, &[0.0; 6], Vec3::ONE).unwrap(),
            Shape::height_field(3, 2, &[0.0; 6], Vec3::ONE).unwrap(),
        ];
        for (i, one) in all.iter().enumerate() {
            for (j, other) in all.iter().enumerate() {
                assert_eq!(one.content_hash() == other.content_hash(), i == j, "{one:?} {other:?}");
            }
        }
        assert_eq!(all[9].content_hash(), Shape::hull(&corners(1.0)).unwrap().content_hash());
    }
}
