//! The inverted box: solid outside of a box, a closed room. Its surface consists of six half-spaces.

use glam::{Mat3, Vec3};

use super::convex::Convex as _;
use super::flat::Cuboid;
use super::{Form, Nearest, RayHit, Shape, ShapeTouch};
use crate::collide::frame::Frame;

/// A box that is centred at the origin, empty inside and solid all around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HollowBox {
    pub(super) half_size: Vec3,
}

impl Shape {
    /// Poses of the half-spaces that an unbounded shape consists of, in its own frame: itself for a half-space, six for the outside of a box, none for any
    /// other shape.
    pub(crate) fn half_spaces(&self) -> impl Iterator<Item = Frame> + use<> {
        let alone = matches!(self.form, Form::HalfSpace).then_some(Frame::IDENTITY);
        let walls = self.inside_half_size().into_iter().flat_map(|half| {
            let both = |axis: Vec3| [axis, -axis];
            // A wall faces inward, from where it is towards the centre.
            Vec3::AXES.into_iter().flat_map(both).map(move |inward| {
                let x = inward.any_orthonormal_vector();
                let rotation = Mat3::from_cols(x, inward, x.cross(inward));
                Frame { translation: -inward * inward.abs().dot(half), rotation }
            })
        });
        alone.into_iter().chain(walls)
    }

    /// Half of the size of the box for the outside of a box; `None` for any other shape.
    pub(crate) fn inside_half_size(&self) -> Option<Vec3> {
        if let Form::InsideBox(room) = &self.form { Some(room.half_size) } else { None }
    }

    /// Whether it is unbounded: a half-space or the outside of a box.
    pub(crate) fn is_unbounded(&self) -> bool {
        matches!(self.form, Form::HalfSpace | Form::InsideBox(_))
    }
}

impl HollowBox {
    /// Clamps each coordinate. Where the box is thinner than the sphere, the sphere is kept in the middle.
    #[inline]
    pub(super) fn touch(&self, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        let most = (self.half_size - radius).max(Vec3::ZERO);
        ShapeTouch::between(to, to.max(-most).min(most))
    }

    /// The hit of a ray that starts inside of the room.
    pub(super) fn cast(&self, origin: Vec3, direction: Vec3, max: f32) -> Option<RayHit> {
        if !origin.abs().cmple(self.half_size).all() {
            return None;
        }
        let mut first: Option<RayHit> = None;
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                continue;
            }
            let sign = if direction[axis] < 0.0 { -1.0 } else { 1.0 };
            let distance = (sign * self.half_size[axis] - origin[axis]) / direction[axis];
            if first.is_none_or(|first| distance < first.distance) {
                let mut normal = Vec3::ZERO;
                normal[axis] = -sign;
                first = Some(RayHit { distance, normal });
            }
        }
        first.filter(|hit| hit.distance <= max)
    }

    /// The nearest point on a wall. As for any solid, the distance is positive from the empty side, here inside of the room.
    pub(super) fn nearest(&self, p: Vec3) -> Nearest {
        let Nearest { point, normal, distance } = Cuboid { half_size: self.half_size }.nearest(p);
        // Not `-normal`, whose zeros would be negative.
        Nearest { point, normal: Vec3::ZERO - normal, distance: -distance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_room_is_what_its_six_half_spaces_are() {
        let room = Shape::inside_box(Vec3::new(2.0, 4.0, 6.0)).unwrap();
        let walls: Vec<Frame> = room.half_spaces().collect();
        assert_eq!(walls.len(), 6);
        assert!(walls.iter().all(Frame::is_valid));
        let floor = Shape::half_space();
        let mut random = crate::test_random::Random::new(7);
        for _ in 0..2000 {
            let (from, to) = (random.vector() * Vec3::new(1.0, 2.0, 3.0), random.vector() * 4.0);
            let radius = 0.3 * random.fraction();
            // One wall after the other.
            let mut settled = to;
            for wall in &walls {
                if let Some(touch) = floor.touch(wall.local(from), wall.local(settled), radius) {
                    settled += wall.turn(touch.normal) * touch.depth;
                }
            }
            let touched = room.touch(from, to, radius);
            let own = touched.map_or(to, |touch| to + touch.normal * touch.depth);
            assert!((own - settled).length() < 1e-5, "{to} {radius}: {own} {settled}");
            let direction = (to - from).normalize();
            let hit = room.cast_ray(from, direction, 100.0).expect("there is no way out");
            let sooner = walls.iter().filter_map(|wall| {
                floor.cast_ray(wall.local(from), wall.turn_back(direction), 100.0)
            });
            let least = sooner.map(|hit| hit.distance).fold(f32::INFINITY, f32::min);
            assert!((hit.distance - least).abs() < 1e-4 * least.max(1.0), "{hit:?} {least}");
            let nearest = room.nearest(from);
            let gap = walls.iter().map(|wall| wall.local(from).y).fold(f32::INFINITY, f32::min);
            assert!((nearest.distance - gap).abs() < 1e-5);
            assert_eq!(room.contains(to), to.abs().cmpge(Vec3::new(1.0, 2.0, 3.0)).any());
        }
        assert_eq!(room.cast_ray(Vec3::X * 3.0, Vec3::X, 9.0), None, "from within the solid");
        assert_eq!(room.cast_ray(Vec3::ZERO, Vec3::Y, 1.9), None, "too short");
        assert!(Shape::inside_box(Vec3::new(1.0, 0.0, 1.0)).is_err());
    }

    #[test]
    fn what_does_not_fit_is_held_in_the_middle() {
        let room = Shape::inside_box(Vec3::new(100.0, 1.0, 100.0)).unwrap();
        let touch = room.touch(Vec3::ZERO, Vec3::new(1.0, 0.4, 0.0), 2.0).unwrap();
        assert_eq!((touch.normal, touch.depth), (Vec3::NEG_Y, 0.4));
        assert_eq!(room.touch(Vec3::ZERO, Vec3::NAN, 2.0), None);
    }
}
