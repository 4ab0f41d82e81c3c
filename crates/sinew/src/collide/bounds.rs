//! Planes and boxes that constrain particles without restitution, drag, motion or events (physics.md C4), and the plane constraint of a 2D world. Particles are
//! projected one by one, or eight side by side by the same code. Everything else is a surface (`particle_contact::surface`).

use glam::Vec3;

use super::collider::Collider;
use super::friction::contact_correction;
use crate::constraints::{Boundaries, InsideBox, PlanarDrag, Plane};
use crate::lanes::{Number, Vector};
use crate::particles::{Particles, Places, ground};

/// Bounds of particles by class ([`BodyClasses`](super::body_classes::BodyClasses)), and the plane of a 2D world: scratch of a step.
#[derive(Clone, Debug, Default)]
pub(super) struct Bounds {
    classes: Vec<ClassBounds>,
    /// Each plane and each box once, for whichever classes.
    planes: Vec<Plane>,
    boxes: Vec<InsideBox>,
    plane_constraint: Option<Plane>,
    /// Boundary planes with a drag, including those that are surfaces.
    drags: Vec<Plane>,
}

/// The bounds of one class, each with the combined friction of the two.
#[derive(Clone, Debug, Default)]
pub(super) struct ClassBounds {
    planes: Vec<Plane>,
    boxes: Vec<InsideBox>,
}

/// A plane or a box.
#[derive(Clone, Copy, Debug)]
pub(super) enum PlaneOrBox {
    Plane(Plane),
    Box(InsideBox),
}

/// A particle as a sphere, or eight of them, in a substep. Positions are relative to a common origin, metres.
pub(super) struct Spheres<N> {
    pub(super) origin: Vec3,
    pub(super) position: Vector<N>,
    /// Where they were when the substep began.
    pub(super) start: Vector<N>,
    pub(super) radius: N,
}

impl Spheres<f32> {
    /// The particle of a row.
    #[inline(always)]
    pub(super) fn of(places: &Places, row: u32) -> Self {
        let i = places.at(row);
        Self {
            origin: places.origin[i],
            position: places.position[i].truncate().into(),
            start: places.start[i].truncate().into(),
            radius: places.radius[i],
        }
    }
}

impl<N: Number> Spheres<N> {
    /// The displacement that brings them out of a plane, metres; zero where they do not overlap.
    #[inline(always)]
    pub(super) fn plane_correction(&self, plane: &Plane) -> Vector<N> {
        let ground = N::splat(ground(self.origin, plane.normal, plane.offset));
        plane.correction(self.position, self.radius, ground)
    }

    /// The displacement that brings them into a box, metres; zero where they are in it.
    #[inline(always)]
    pub(super) fn box_correction(&self, inside: &InsideBox) -> Vector<N> {
        inside.correction(self.position, self.radius, self.origin)
    }
}

impl PlaneOrBox {
    /// The plane or axis-aligned box of a collider; `None` if its shape is another, or it moves.
    pub(super) fn of(collider: &Collider) -> Option<Self> {
        if !collider.shape.is_unbounded() || collider.start != collider.end {
            return None;
        }
        let frame = &collider.end;
        if let Some(half) = collider.shape.inside_half_size() {
            let (middle, level) = (frame.translation, frame.rotation == glam::Mat3::IDENTITY);
            return level.then(|| Self::Box(InsideBox::new(middle - half, middle + half)));
        }
        let normal = frame.rotation.y_axis;
        let offset = normal.dot(frame.translation);
        Some(Self::Plane(Plane { normal, offset, ..Plane::ground(0.0) }))
    }

    fn with_friction(self, friction: f32) -> Self {
        match self {
            Self::Plane(plane) => Self::Plane(Plane { friction, ..plane }),
            Self::Box(inside) => Self::Box(InsideBox { friction, ..inside }),
        }
    }
}

impl Bounds {
    /// Begins a step with a number of classes without bounds. Keeps allocations.
    pub(super) fn begin(&mut self, boundaries: &Boundaries, classes: usize) {
        self.classes.resize_with(classes, ClassBounds::default);
        for class in &mut self.classes {
            class.planes.clear();
            class.boxes.clear();
        }
        self.planes.clear();
        self.boxes.clear();
        self.drags.clear();
        let drags = |plane: &&Plane| plane.is_valid() && plane.drag != PlanarDrag::default();
        self.drags.extend(boundaries.planes.iter().filter(drags));
        self.plane_constraint = boundaries.plane_constraint.filter(Plane::is_valid);
    }

    /// Adds a bound for each class for which `friction` returns a coefficient.
    pub(super) fn add(&mut self, bound: PlaneOrBox, friction: impl Fn(usize) -> Option<f32>) {
        let mut is_used = false;
        for (number, class) in self.classes.iter_mut().enumerate() {
            let Some(friction) = friction(number) else { continue };
            is_used = true;
            match bound.with_friction(friction) {
                PlaneOrBox::Plane(plane) => class.planes.push(plane),
                PlaneOrBox::Box(inside) => class.boxes.push(inside),
            }
        }
        match bound {
            PlaneOrBox::Plane(plane) if is_used => self.planes.push(plane),
            PlaneOrBox::Box(inside) if is_used => self.boxes.push(inside),
            _ => (),
        }
    }

    /// Whether there are neither bounds nor a plane constraint.
    pub(super) fn is_empty(&self) -> bool {
        self.planes.is_empty() && self.boxes.is_empty() && self.plane_constraint.is_none()
    }

    /// Whether the world is 2D.
    pub(super) fn has_plane_constraint(&self) -> bool {
        self.plane_constraint.is_some()
    }

    /// The planes that bound a class; `None` if boxes or the plane of a 2D world constrain it too.
    pub(super) fn only_planes(&self, class: usize) -> Option<&[Plane]> {
        let Some(class) = self.classes.get(class) else { return Some(&[]) };
        (class.boxes.is_empty() && self.plane_constraint.is_none()).then_some(&class.planes)
    }

    /// All planes and boxes, for whichever classes.
    pub(super) fn all(&self) -> (&[Plane], &[InsideBox]) {
        (&self.planes, &self.boxes)
    }

    /// Applies the drag of planes to particles that touch them, before a substep of `h` seconds is predicted.
    pub(super) fn drag(&self, particles: &mut Particles, excluded: &[bool], h: f32) {
        for plane in &self.drags {
            plane.drag.apply(particles, (plane.normal, plane.offset), excluded, h);
        }
    }

    /// The bounds of a class.
    #[inline]
    pub(super) fn of(&self, class: usize) -> &ClassBounds {
        const UNBOUNDED: &ClassBounds = &ClassBounds { planes: Vec::new(), boxes: Vec::new() };
        self.classes.get(class).unwrap_or(UNBOUNDED)
    }

    /// Projects a row to the plane of a 2D world; returns its distance before, metres.
    #[inline]
    pub(super) fn project_to_plane(&self, places: &mut Places, row: u32) -> f32 {
        let Some(plane_constraint) = &self.plane_constraint else { return 0.0 };
        let out = places.height(row, plane_constraint.normal, plane_constraint.offset);
        places.displace(row, plane_constraint.normal * -out);
        out.abs()
    }

    /// Projects all rows to the plane of a 2D world, or with `moving` their velocities: contact normals may be slightly out of the plane.
    pub(super) fn flatten(&self, particles: &mut Particles, moving: bool) {
        let Some(Plane { normal, offset, .. }) = self.plane_constraint else { return };
        for row in 0..particles.len() {
            let here = particles.position[row];
            if here.w == 0.0 {
                continue;
            }
            if moving {
                let out = particles.velocity[row].truncate().dot(normal);
                particles.velocity[row] -= (normal * out).extend(0.0);
            } else {
                let out =
                    ground(particles.origin[row], normal, offset) + here.truncate().dot(normal);
                particles.position[row] -= (normal * out).extend(0.0);
            }
        }
    }

    /// Distance of a row from the plane of a 2D world, metres.
    pub(super) fn out_of_plane(&self, places: &Places, row: u32) -> f32 {
        let plane_constraint = self.plane_constraint.as_ref();
        plane_constraint.map_or(0.0, |s| places.height(row, s.normal, s.offset).abs())
    }
}

impl ClassBounds {
    /// Whether nothing bounds the class.
    pub(super) fn is_empty(&self) -> bool {
        self.planes.is_empty() && self.boxes.is_empty()
    }

    /// Projects spheres out of every plane and box, once, with friction, recovering at most `recover` metres of an overlap from before the substep. Returns the
    /// greatest correction of each, metres.
    #[inline(always)]
    pub(super) fn project<N: Number>(&self, spheres: &mut Spheres<N>, recover: f32) -> N {
        let mut worst = N::zero();
        for plane in &self.planes {
            let out = spheres.plane_correction(plane);
            worst = push(spheres, out, (plane.friction, recover)).max(worst);
        }
        for inside in &self.boxes {
            let out = spheres.box_correction(inside);
            worst = push(spheres, out, (inside.friction, recover)).max(worst);
        }
        worst
    }

    /// The correction of each plane and each box for a row, metres; zero where it does not overlap.
    pub(super) fn corrections(&self, places: &Places, row: u32) -> impl Iterator<Item = Vec3> {
        let planes =
            self.planes.iter().map(move |plane| Spheres::of(places, row).plane_correction(plane));
        let boxes =
            self.boxes.iter().map(move |inside| Spheres::of(places, row).box_correction(inside));
        planes.chain(boxes).map(Vec3::from)
    }

    /// Greatest overlap of a row, metres. Moves nothing.
    pub(super) fn error(&self, places: &Places, row: u32) -> f32 {
        self.corrections(places, row).map(Vec3::length).fold(0.0, f32::max)
    }
}

/// Moves spheres by the normal corrections `out` and the friction that belongs to them, where there are any. Returns the normal corrections applied, metres.
#[inline(always)]
fn push<N: Number>(
    spheres: &mut Spheres<N>,
    out: Vector<N>,
    (coefficient, recover): (f32, f32),
) -> N {
    if !N::zero().lt(out.length_squared()).any() {
        return N::zero();
    }
    let moved = spheres.position - spheres.start;
    let limits = (N::splat(coefficient), N::splat(recover));
    let (by, depth) = contact_correction(out, moved, limits);
    let touching = N::zero().lt(depth);
    spheres.position = (spheres.position + by).or_else(touching, spheres.position);
    depth
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
        hold(PlaneOrBox::Plane(plane), plane.friction, particles)
    }

    fn hold(bound: PlaneOrBox, friction: f32, particles: &mut Particles) -> f32 {
        let mut bounds = Bounds::default();
        bounds.begin(&Boundaries::default(), 1);
        bounds.add(bound, |_| Some(friction));
        let mut sphere = Spheres::of(&Places::all(particles), 0);
        let depth = bounds.of(0).project(&mut sphere, f32::INFINITY);
        particles.set_position(0, sphere.origin + Vec3::from(sphere.position));
        depth
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
        let inside = InsideBox::new(Vec3::ZERO, Vec3::new(100.0, 1.0, 100.0));
        let mut out = one(Vec3::new(-5.0, 0.5, 120.0), Vec3::new(-5.0, 0.5, 120.0), 0.25);
        hold(PlaneOrBox::Box(inside), inside.friction, &mut out);
        assert!(out.position(0).abs_diff_eq(Vec3::new(0.25, 0.5, 99.75), 1e-4));
        let mut fat = one(Vec3::new(50.0, 0.9, 50.0), Vec3::new(50.0, 0.9, 50.0), 2.0);
        hold(PlaneOrBox::Box(inside), inside.friction, &mut fat);
        assert_eq!(fat.position(0).y, 0.5);
    }
}
