//! What holds particles by themselves: planes and boxes (physics.md C4), with Coulomb friction where a particle touches (F8), pins (C3), and the
//! sheet that a world in 2D lies in.

use glam::Vec3;

use super::Pin;
use super::planar_drag::{self, PlanarDrag};
use crate::particles::{Particles, Places};

/// What is enforced on single particles. [`Constraint`](super::Constraint)s and distances are kept apart, in the
/// [`Simulation`](crate::Simulation), because they are compiled into a plan when they change; these may change at any step for free.
#[derive(Clone, Debug, Default)]
pub struct Boundaries {
    /// Half-spaces that every particle stays in, such as the ground.
    pub planes: Vec<Plane>,
    /// Boxes that every particle stays inside.
    pub boxes: Vec<InsideBox>,
    /// Particles that are held at a point, or led along a path.
    pub pins: Vec<Pin>,
    /// For a world in 2D: the plane in which every particle stays, on both its sides. Its friction does not matter.
    pub sheet: Option<Plane>,
}

/// "Every particle stays on the side of this plane to which the normal points": the ground, a wall, a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vector that points to the allowed side. [`Plane::new`] normalises it.
    pub normal: Vec3,
    /// `normal · x` of the points on the plane, metres: its signed distance from the origin.
    pub offset: f32,
    /// Coulomb's coefficient of friction μ, 0 (ice) and up. Default 0.5.
    pub friction: f32,
    /// The lectures' friction: a drag along the plane and one across it, for what touches it. Default none.
    pub drag: PlanarDrag,
}

impl Plane {
    /// The level ground at y = `height` metres.
    pub fn ground(height: f32) -> Self {
        Self { normal: Vec3::Y, offset: height, friction: 0.5, drag: PlanarDrag::default() }
    }

    /// The plane through `point` with the given normal, of any length but zero; `None` if it has no direction or is not finite.
    pub fn new(point: Vec3, normal: Vec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let plane = Self { normal, offset: normal.dot(point), ..Self::ground(0.0) };
        plane.is_valid().then_some(plane)
    }

    /// The same with another coefficient of friction.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// Whether the normal is a unit vector and all numbers are finite and in range. An invalid plane is skipped.
    pub fn is_valid(&self) -> bool {
        (self.normal.length_squared() - 1.0).abs() < 1e-3
            && self.offset.is_finite()
            && self.friction.is_finite()
            && self.friction >= 0.0
            && self.drag.is_valid()
    }
}

/// "Every particle stays inside this box", whose edges lie along the axes: the lectures' clamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InsideBox {
    /// Corner with the smallest coordinates, metres.
    pub min: Vec3,
    /// Corner with the largest coordinates, metres.
    pub max: Vec3,
    /// Coulomb's coefficient of friction μ on its walls, 0 and up. Default 0.5.
    pub friction: f32,
}

impl InsideBox {
    /// The box between two corners, metres.
    pub fn new(min: Vec3, max: Vec3) -> Self {
        Self { min, max, friction: 0.5 }
    }

    /// Whether `min ≤ max` and all numbers are finite and in range. An invalid box is skipped.
    pub fn is_valid(&self) -> bool {
        self.min.is_finite()
            && self.max.is_finite()
            && self.min.cmple(self.max).all()
            && self.friction.is_finite()
            && self.friction >= 0.0
    }
}

/// The valid ones among the surfaces that bound every particle: scratch of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    planes: Vec<Plane>,
    boxes: Vec<InsideBox>,
    sheet: Option<Plane>,
}

impl Contacts {
    /// Takes what is valid, and keeps its memory.
    pub(crate) fn take(&mut self, boundaries: &Boundaries) {
        self.planes.clear();
        self.planes.extend(boundaries.planes.iter().filter(|plane| plane.is_valid()));
        self.boxes.clear();
        self.boxes.extend(boundaries.boxes.iter().filter(|room| room.is_valid()));
        self.sheet = boundaries.sheet.filter(Plane::is_valid);
    }

    /// Whether there is nothing to touch.
    pub(crate) fn is_empty(&self) -> bool {
        self.planes.is_empty() && self.boxes.is_empty() && self.sheet.is_none()
    }

    /// Slows down what touches a plane with a drag, before a substep of `h` seconds is predicted.
    pub(crate) fn drag(&self, particles: &mut Particles, h: f32) {
        planar_drag::apply(particles, &self.planes, h);
    }

    /// Puts a row on the right side of everything, once, with friction; returns how far out it was, metres.
    #[inline]
    pub(crate) fn project(&self, places: &mut Places, row: u32) -> f32 {
        if places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        let mut worst = 0.0_f32;
        for plane in &self.planes {
            let out = plane.correction(places, row);
            worst = worst.max(push(places, row, out, plane.friction));
        }
        for room in &self.boxes {
            let out = room.correction(places, row);
            worst = worst.max(push(places, row, out, room.friction));
        }
        if let Some(sheet) = &self.sheet {
            let out = places.height(row, sheet.normal, sheet.offset);
            places.displace(row, sheet.normal * -out);
            worst = worst.max(out.abs());
        }
        worst
    }

    /// How far out a row is, metres, moving nothing.
    pub(crate) fn error(&self, places: &Places, row: u32) -> f32 {
        if places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        let planes = self.planes.iter().map(|plane| plane.correction(places, row).length());
        let boxes = self.boxes.iter().map(|room| room.correction(places, row).length());
        let sheet = self.sheet.iter().map(|s| places.height(row, s.normal, s.offset).abs());
        planes.chain(boxes).chain(sheet).fold(0.0, f32::max)
    }
}

/// Moves a row by the normal correction and by the friction that goes with it; returns how far out it was, metres.
#[inline]
fn push(places: &mut Places, row: u32, normal_part: Vec3, coefficient: f32) -> f32 {
    if normal_part == Vec3::ZERO {
        return 0.0;
    }
    let depth = normal_part.length();
    let i = places.at(row);
    let moved = (places.position[i] - places.start[i]).truncate() + normal_part;
    let slid = moved - normal_part * (moved.dot(normal_part) / (depth * depth));
    places.displace(row, normal_part + friction(slid, depth, coefficient));
    depth
}

/// The tangential correction of Coulomb's law in positions: `Δt = -t · min(μ Δn/‖t‖, 1)`.
///
/// `t` is the sliding of this substep and `Δn` the normal correction. A normal force N acts for a substep h on the mass m as
/// the displacement `Δn = N h²/m`; friction of at most μN moves it back by at most `μ Δn`, and never past standing still.
#[inline]
fn friction(slid: Vec3, normal_correction: f32, coefficient: f32) -> Vec3 {
    let distance = slid.length();
    if distance > coefficient * normal_correction {
        slid * (-coefficient * normal_correction / distance)
    } else {
        -slid
    }
}

impl Plane {
    /// The displacement that brings a row, a sphere of its radius, just inside, metres; zero if it is inside already. It goes to the
    /// nearest point of the half-space: along the normal, for one particle whatever its mass.
    #[inline]
    fn correction(&self, places: &Places, row: u32) -> Vec3 {
        let radius = places.radius[places.at(row)];
        let height = places.height(row, self.normal, self.offset) - radius;
        if height < 0.0 { self.normal * -height } else { Vec3::ZERO }
    }
}

impl InsideBox {
    /// The same: the clamp, coordinate by coordinate. Where the box is thinner than the sphere, the sphere is held in the middle.
    #[inline]
    fn correction(&self, places: &Places, row: u32) -> Vec3 {
        let i = places.at(row);
        let (radius, origin) = (places.radius[i], places.origin[i]);
        let (min, max) = (self.min - origin, self.max - origin);
        let middle = (min + max) * 0.5;
        let low = (min + radius).min(middle);
        let high = (max - radius).max(middle);
        let position = places.position[i].truncate();
        position.max(low).min(high) - position
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ParticleSeed;

    fn one(at: Vec3, moved_from: Vec3, radius: f32) -> Particles {
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(moved_from).with_radius(radius)).unwrap();
        particles.set_position(0, at);
        particles
    }

    fn touch(plane: Plane, particles: &mut Particles) -> f32 {
        Contacts { planes: vec![plane], ..Default::default() }
            .project(&mut Places::all(particles), 0)
    }

    #[test]
    fn a_sunken_particle_is_put_on_the_ground_and_a_flying_one_left_alone() {
        let ground = Plane::ground(1.0).with_friction(0.0);
        let mut low = one(Vec3::new(3.0, 0.2, 4.0), Vec3::new(3.0, 1.2, 4.0), 0.1);
        assert!((touch(ground, &mut low) - 0.9).abs() < 1e-6);
        assert!(low.position(0).abs_diff_eq(Vec3::new(3.0, 1.1, 4.0), 1e-6));
        let mut high = one(Vec3::Y * 1.2, Vec3::Y * 1.3, 0.1);
        assert_eq!(touch(ground, &mut high), 0.0);
        assert_eq!(high.position(0), Vec3::Y * 1.2);
    }

    #[test]
    fn the_box_clamps_each_coordinate_and_centres_what_does_not_fit() {
        let room = InsideBox::new(Vec3::ZERO, Vec3::new(100.0, 1.0, 100.0));
        let mut out = one(Vec3::new(-5.0, 0.5, 120.0), Vec3::new(-5.0, 0.5, 120.0), 0.25);
        Contacts { boxes: vec![room], ..Default::default() }.project(&mut Places::all(&mut out), 0);
        assert!(out.position(0).abs_diff_eq(Vec3::new(0.25, 0.5, 99.75), 1e-4));
        let mut fat = one(Vec3::new(50.0, 0.9, 50.0), Vec3::new(50.0, 0.9, 50.0), 2.0);
        Contacts { boxes: vec![room], ..Default::default() }.project(&mut Places::all(&mut fat), 0);
        assert_eq!(fat.position(0).y, 0.5);
    }

    #[test]
    fn friction_takes_at_most_mu_times_the_normal_correction() {
        let slid = Vec3::new(0.3, 0.0, 0.4);
        assert!(friction(slid, 0.1, 0.5).abs_diff_eq(slid * -0.1, 1e-7));
        assert_eq!(friction(slid, 10.0, 0.5), -slid);
        assert_eq!(friction(Vec3::ZERO, 0.0, 0.5), Vec3::ZERO);
    }

    #[test]
    fn invalid_planes_and_boxes_say_so() {
        assert!(Plane::new(Vec3::ZERO, Vec3::ZERO).is_none());
        assert!(Plane::new(Vec3::NAN, Vec3::Y).is_none());
        assert!(Plane::new(Vec3::ZERO, Vec3::Y * 7.0).is_some_and(|p| p.normal == Vec3::Y));
        assert!(!Plane::ground(0.0).with_friction(-1.0).is_valid());
        assert!(!InsideBox::new(Vec3::ONE, Vec3::ZERO).is_valid());
    }
}
