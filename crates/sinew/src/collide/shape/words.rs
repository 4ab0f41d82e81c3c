//! Serialisation of a shape as plain words: the numbers that it was made of, from which the same shape is made again. Derived data (trees, faces, `parry3d`
//! shapes) is left out.

use std::sync::Arc;

use glam::Vec3;

use super::fault::first_out_of_range;
use super::hull::ConvexHull;
use super::{Cuboid, Form, Shape, ShapeFault};
use crate::collide::words::{Reader, Write};

impl Shape {
    /// The shape as words, for serialisation. [`from_words`](Self::from_words) restores an equal shape, exact to the bit. The words of a kind of shape mean the
    /// same in every version that can read them.
    pub fn to_words(&self) -> Vec<u32> {
        let mut words = Vec::new();
        match &self.form {
            Form::HalfSpace => words.push(HALF_SPACE),
            Form::InsideBox(hollow) => {
                words.push(INSIDE_BOX);
                words.vec3(2.0 * hollow.half_size);
            }
            Form::Ball(ball) => {
                words.push(BALL);
                words.float(ball.radius);
            }
            Form::Capsule(capsule) => {
                words.push(CAPSULE);
                words.float(capsule.radius);
                words.float(2.0 * capsule.half_height);
            }
            Form::Cuboid(Cuboid { half_size }) => {
                words.push(CUBOID);
                words.vec3(2.0 * *half_size);
            }
            Form::Cylinder(cylinder) => {
                words.push(CYLINDER);
                words.float(cylinder.radius);
                words.float(2.0 * cylinder.half_height);
            }
            Form::Hull(hull) => {
                words.push(HULL);
                triangles(&mut words, &hull.points, &hull.triangles);
            }
            Form::Mesh(mesh) => {
                words.push(MESH);
                triangles(&mut words, &mesh.vertices, &mesh.triangles);
            }
            Form::Heights(heights) => {
                let (columns, rows) = heights.grid();
                words.extend([HEIGHTS, columns as u32, rows as u32]);
                words.vec3(heights.size());
                words.push((columns * rows) as u32);
                let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
                all.for_each(|(column, row)| words.float(heights.height(column, row)));
            }
        }
        words
    }

    /// Restores a shape from its [words](Self::to_words). `None` if they are not those of a shape: an unknown kind, too few or too many words, or numbers that
    /// the constructor refuses.
    pub fn from_words(words: &[u32]) -> Option<Self> {
        let mut reader = Reader(words);
        let shape = match reader.word()? {
            HALF_SPACE => Self::half_space(),
            INSIDE_BOX => Self::inside_box(reader.vec3()?).ok()?,
            BALL => Self::sphere(reader.float()?).ok()?,
            CAPSULE => Self::capsule(reader.float()?, reader.float()?).ok()?,
            CUBOID => Self::cuboid(reader.vec3()?).ok()?,
            CYLINDER => Self::cylinder(reader.float()?, reader.float()?).ok()?,
            HULL => {
                let (points, triangles) = (reader.list(Reader::vec3)?, reader.list(corners)?);
                hull(points, &triangles).ok()?
            }
            MESH => Self::mesh(reader.list(Reader::vec3)?, reader.list(corners)?).ok()?,
            HEIGHTS => {
                let (columns, rows) = (reader.word()? as usize, reader.word()? as usize);
                let size = reader.vec3()?;
                let heights = reader.list(Reader::float)?;
                Self::height_field(columns, rows, &heights, size).ok()?
            }
            _ => return None,
        };
        reader.all(shape)
    }
}

const HALF_SPACE: u32 = 1;
const BALL: u32 = 2;
const CAPSULE: u32 = 3;
const CUBOID: u32 = 4;
const CYLINDER: u32 = 5;
const HULL: u32 = 6;
const MESH: u32 = 7;
const HEIGHTS: u32 = 8;
const INSIDE_BOX: u32 = 9;

fn triangles(words: &mut Vec<u32>, points: &[Vec3], triangles: &[[u32; 3]]) {
    words.push(points.len() as u32);
    points.iter().for_each(|&point| words.vec3(point));
    words.push(triangles.len() as u32);
    words.extend(triangles.as_flattened());
}

fn corners(reader: &mut Reader) -> Option<[u32; 3]> {
    Some([reader.word()?, reader.word()?, reader.word()?])
}

/// A hull from known triangles: computing them again might change their order.
fn hull(points: Vec<Vec3>, triangles: &[[u32; 3]]) -> Result<Shape, ShapeFault> {
    if let Some(point) = first_out_of_range(&points) {
        return Err(ShapeFault::Point(point));
    }
    let is_out_of_range = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= points.len());
    if let Some(triangle) = triangles.iter().position(is_out_of_range) {
        return Err(ShapeFault::Corner(triangle));
    }
    Ok(Shape::of(Form::Hull(Arc::new(ConvexHull::of_triangles(points, triangles)?))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    /// Pseudo-random points in no particular order, some of them inside of the hull.
    fn scattered(count: u32, seed: u64) -> Vec<Vec3> {
        let mut random = Random::new(seed);
        (0..count).map(|_| random.vector() * Vec3::new(0.5, 1.0, 0.15)).collect()
    }

    fn shapes() -> Vec<Shape> {
        let mut shapes = vec![
            Shape::half_space(),
            Shape::inside_box(Vec3::new(0.1, 3.0, 7.7)).unwrap(),
            Shape::sphere(0.1).unwrap(),
            Shape::capsule(0.3, 0.7).unwrap(),
            Shape::cuboid(Vec3::new(0.1, 1e-6, 3.3)).unwrap(),
            Shape::cylinder(1.1, 0.013).unwrap(),
            // Faces of many coplanar triangles, and coincident vertices.
            Shape::cylinder(1.0, 1.0).unwrap().scaled(Vec3::new(1.0, 1.0, 2.0)).unwrap(),
            Shape::hull(
                &[0, 1, 2, 3, 4, 5, 6, 7]
                    .map(|i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)),
            )
            .unwrap(),
            Shape::height_field(3, 2, &[0.0, 0.1, -0.3, -0.0, 0.7, 0.2], Vec3::new(2.0, 0.7, 3.0))
                .unwrap(),
        ];
        for seed in 0..20 {
            let points = scattered(8 + 13 * seed, seed.into());
            shapes.push(Shape::hull(&points).unwrap());
            // Triangles in no particular order, many with the same centre along an axis.
            let n = points.len() as u32;
            let sheet = (0..3 * n).map(|i| [i % n, (i * 7 + 1) % n, (i * 5 + 3 + i / n) % n]);
            shapes.push(Shape::mesh(points, sheet.collect()).unwrap());
        }
        shapes
    }

    #[test]
    fn a_shape_comes_back_equal_from_its_words() {
        for shape in shapes() {
            let words = shape.to_words();
            let again = Shape::from_words(&words).expect("they are of a shape");
            assert_eq!(again.form, shape.form);
            assert_eq!(again.content_hash(), shape.content_hash());
            assert_eq!(again.to_words(), words);
        }
    }

    #[test]
    fn words_that_are_too_few_too_many_or_of_nothing_are_refused() {
        for shape in shapes() {
            let words = shape.to_words();
            for length in 0..words.len().min(200) {
                assert_eq!(Shape::from_words(&words[..length]), None, "{length} of {shape:?}");
            }
            let more: Vec<u32> = words.iter().copied().chain([0]).collect();
            assert_eq!(Shape::from_words(&more), None);
        }
        assert_eq!(Shape::from_words(&[10]), None);
        assert_eq!(Shape::from_words(&[BALL, f32::NAN.to_bits()]), None);
        // A length that no memory would hold, and a missing vertex.
        assert_eq!(Shape::from_words(&[HULL, u32::MAX]), None);
        let mut corner = Shape::hull(&scattered(8, 1)).unwrap().to_words();
        *corner.last_mut().unwrap() = 8;
        assert_eq!(Shape::from_words(&corner), None);
    }
}
