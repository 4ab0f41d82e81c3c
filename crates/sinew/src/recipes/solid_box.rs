//! Boxes of fully connected particles (physics.md B1, B2): the simplest rigid compound. All rotation results from the particles; there is no rotation state.

use glam::{DVec3, Vec3};

use super::blueprint::{Blueprint, Part};
use super::fault::{RecipeFault, check_mass, check_particles, ensure};
use super::limits::LENGTHS;
use crate::collide::Shape;
use crate::constraints::GradientAt;

/// A box to build. The default is a cube of 1 m and 1 kg, with its particles at the corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxSpec {
    /// Lengths of its edges along x, y and z, metres, 1e-6 to 1e6. Default 1 each. In 2D, z is only for drawing, 0 or more.
    pub size: Vec3,
    /// Mass of the whole box, kg, 1e-9 to 1e12. Default 1.
    pub mass: f32,
    /// Where in the box its particles are. Default at the corners.
    pub layout: BoxLayout,
    /// Radius of every particle, metres, 0 or more. Default 0. At the corners, it extends beyond the box.
    pub radius: f32,
    /// Share of the velocity lost per second, 0 to 1. Default 0.
    pub drag: f32,
}

/// Where the particles of a box are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BoxLayout {
    /// At its corners, so that contacts, wind and rendering agree. The price: the moments of inertia are 3 times those of a solid box, because all mass is as
    /// far out as possible. It rotates more sluggishly; it falls, slides, and flips over the same axes as a solid box.
    #[default]
    Corners,
    /// At `1/√3` of the way from its centre to its corners: mass, centre and inertia are exactly those of the solid box, `m/12·(b² + c²)`. Contacts of the
    /// particles are inside the box, and it has no triangles for the wind.
    Equimomental,
}

impl Default for BoxSpec {
    fn default() -> Self {
        Self { size: Vec3::ONE, mass: 1.0, layout: BoxLayout::default(), radius: 0.0, drag: 0.0 }
    }
}

/// A solid box centred on the origin: 8 particles, all 28 pairs connected, one part named `"box"`.
///
/// Particle `i` is on the positive side of x, y and z where bit 0, 1 and 2 of `i` is set.
pub fn box_3d(spec: &BoxSpec) -> Result<Blueprint, RecipeFault> {
    check(spec, &spec.size.to_array())?;
    let mut body = connected(spec, 8, spec.size);
    if spec.layout == BoxLayout::Corners {
        body.triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    }
    Ok(body)
}

/// A rectangle in the xy plane, centred on the origin: 4 particles, all 6 pairs connected, one part named `"box"`, numbered as in [`box_3d`]. Its two triangles
/// face +z. With the equimomental layout its in-plane inertia is that of a solid plate, `m/12·(a² + b²)`.
pub fn box_2d(spec: &BoxSpec) -> Result<Blueprint, RecipeFault> {
    check(spec, &spec.size.to_array()[..2])?;
    ensure((0.0..=*LENGTHS.end()).contains(&spec.size.z), RecipeFault::Size)?;
    let mut body = connected(spec, 4, spec.size.with_z(0.0));
    if spec.layout == BoxLayout::Corners {
        body.triangles = vec![[0, 1, 3], [0, 3, 2]];
    }
    Ok(body)
}

/// The corners of the six faces, counter-clockwise from outside.
const FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

fn check(spec: &BoxSpec, edges: &[f32]) -> Result<(), RecipeFault> {
    ensure(edges.iter().all(|edge| LENGTHS.contains(edge)), RecipeFault::Size)?;
    check_mass(spec.mass)?;
    check_particles(spec.radius, spec.drag)
}

/// The first `count` corners of a box of `size`, all pairs connected.
fn connected(spec: &BoxSpec, count: u32, size: Vec3) -> Blueprint {
    let reach = match spec.layout {
        BoxLayout::Corners => 0.5,
        BoxLayout::Equimomental => 0.5 / 3.0_f64.sqrt(),
    };
    let side = |i: u32, bit: u32| if i >> bit & 1 == 1 { reach } else { -reach };
    let corner = |i| (DVec3::new(side(i, 0), side(i, 1), side(i, 2)) * size.as_dvec3()).as_vec3();
    let rest: Vec<Vec3> = (0..count).map(corner).collect();
    let mut body = Blueprint::fully_connected(&rest, spec.mass, spec.radius, spec.drag);
    // Rods lose spin unless their gradient is taken at the start of the substep, and an impact on the ground then takes more sweeps.
    body.settings.gradient_at = Some(GradientAt::StepStart);
    body.settings.max_sweeps = Some(8);
    // The collision shape of a rectangle is as deep as its shorter edge, unless it is drawn deeper.
    let flat = if size.z > 0.0 { 0.0 } else { size.x.min(size.y) };
    let shape = Shape::cuboid(spec.size.with_z(spec.size.z.max(flat))).ok();
    let particles = (0..count).collect();
    body.parts = vec![Part { name: "box", particles, rest, size: spec.size, shape }];
    body
}

#[cfg(test)]
mod tests {
    use super::super::blueprint::checks::assert_at_rest;
    use super::*;
    use crate::particles::ParticleSeed;

    fn brick(layout: BoxLayout) -> BoxSpec {
        BoxSpec { size: Vec3::new(1.0, 2.0, 3.0), mass: 5.0, layout, ..BoxSpec::default() }
    }

    /// Moments of inertia about the axes through the origin.
    fn inertia(body: &Blueprint) -> DVec3 {
        let moment = |p: &ParticleSeed| {
            let s = p.position.as_dvec3() * p.position.as_dvec3();
            DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y) * f64::from(p.mass)
        };
        body.particles.iter().map(moment).sum()
    }

    #[test]
    fn all_pairs_are_tied_at_their_distance() {
        for layout in [BoxLayout::Corners, BoxLayout::Equimomental] {
            let (solid, flat) = (box_3d(&brick(layout)).unwrap(), box_2d(&brick(layout)).unwrap());
            assert_eq!((solid.particles.len(), solid.distances.len()), (8, 28));
            assert_eq!((flat.particles.len(), flat.distances.len()), (4, 6));
            for body in [solid, flat] {
                assert_at_rest(&body);
                assert_eq!(body.total_mass(), 5.0);
                assert_eq!(body.parts.len(), 1);
            }
        }
    }

    #[test]
    fn the_equimomental_box_turns_as_the_solid_one_and_corners_three_times_as_hard() {
        let solid = DVec3::new(13.0, 10.0, 5.0) * (5.0 / 12.0);
        let exact = inertia(&box_3d(&brick(BoxLayout::Equimomental)).unwrap());
        assert!((exact / solid - 1.0).abs().max_element() < 1e-6, "{exact}");
        let corners = inertia(&box_3d(&brick(BoxLayout::Corners)).unwrap());
        assert!((corners / solid - 3.0).abs().max_element() < 1e-6, "{corners}");
        let plate = inertia(&box_2d(&brick(BoxLayout::Equimomental)).unwrap());
        assert!((plate.z / solid.z - 1.0).abs() < 1e-6, "{plate}");
    }

    #[test]
    fn the_faces_look_outward_and_enclose_the_volume() {
        let body = box_3d(&brick(BoxLayout::Corners)).unwrap();
        assert_eq!(body.triangles.len(), 12);
        let corners = |t: &[u32; 3]| t.map(|i| body.particles[i as usize].position);
        let volume = |[a, b, c]: [Vec3; 3]| a.dot(b.cross(c)) / 6.0;
        for t in &body.triangles {
            assert!(volume(corners(t)) > 0.0, "{t:?} looks inward");
        }
        let whole: f32 = body.triangles.iter().map(|t| volume(corners(t))).sum();
        assert!((whole - 6.0).abs() < 1e-5, "{whole}");
    }

    #[test]
    fn each_fault_is_told_apart_and_the_ends_of_the_ranges_are_accepted() {
        let refused = |change: fn(&mut BoxSpec)| {
            let mut spec = BoxSpec::default();
            change(&mut spec);
            let fault = box_3d(&spec).unwrap_err();
            assert_eq!(box_2d(&spec), Err(fault));
            fault
        };
        assert_eq!(refused(|s| s.size.x = 0.0), RecipeFault::Size);
        assert_eq!(refused(|s| s.size.z = f32::NAN), RecipeFault::Size);
        assert_eq!(refused(|s| s.mass = f32::INFINITY), RecipeFault::Mass);
        assert_eq!(refused(|s| s.mass = -1.0), RecipeFault::Mass);
        assert_eq!(refused(|s| s.radius = -0.1), RecipeFault::Radius);
        assert_eq!(refused(|s| s.drag = 1.5), RecipeFault::Drag);
        for (size, mass) in [(1e-6, 1e12), (1e6, 1e-9)] {
            let spec = BoxSpec {
                size: Vec3::splat(size),
                mass,
                layout: BoxLayout::Equimomental,
                ..BoxSpec::default()
            };
            assert_at_rest(&box_3d(&spec).unwrap());
        }
    }
}
