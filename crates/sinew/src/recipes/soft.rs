//! Soft bodies (physics.md B3, C7): a closed skin kept full by its volume, and a lattice of tetrahedra that is soft throughout.
//!
//! Both specs take the stiffness of the material, not of a single constraint, and derive each constraint's compliance from it; so a finer mesh does not make a
//! softer body.

mod lattice;

use core::ops::RangeInclusive;

use glam::Vec3;

pub use self::lattice::{SoftLatticeSpec, SoftShape, SoftSurface, soft_lattice, soft_lattice_mesh};
use super::blueprint::{Blueprint, rest_length};
use super::fault::{RecipeFault, check_particles, ensure};
use super::limits::LENGTHS;
use super::mass::MassProperties;
use super::mesh::{Fold, weld};
use super::nearest::bounds;
use super::solid::Bulk;
use crate::constraints::{self, Constraint, ConstraintKind, Distance, Softness, Volume};
use crate::particles::ParticleSeed;

/// A skin kept full by its volume: a ball, a cushion, a balloon. The default has 1 kg and stretches like a balloon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftMeshSpec {
    /// Its mass, or the density of the enclosed volume; the mass is distributed over the surface by area. Default 1 kg.
    pub bulk: Bulk,
    /// Stretching stiffness of the skin, N/m: Young's modulus times thickness, 1e-6 to 1e9. Default 100 (0.1 mm of rubber).
    pub stretch: f32,
    /// Bending stiffness of the skin, N·m, 0 or more. Default 0.01. Zero: it bends freely.
    pub bend: f32,
    /// Damping ratio of every constraint of the skin, 0 (undamped) to 10. Default 0.1.
    pub damping: f32,
    /// Rest volume, as a multiple of the mesh's own, 0.01 to 100. Default 1. Above that the skin is under tension.
    ///
    /// A skin under tension slowly starts to spin by itself: springs that act against each other are solved one after the other, which leaves a small torque in
    /// every substep, proportional to the square of a spring's displacement in it. A ball of 1 kg at 1.3 times its volume has 0.04 J of spin after 2 s with a
    /// skin of 100 N/m, and 6 J with one of 1000 N/m, unless it is in contact with something, has drag, or is solved in
    /// [`Order::Jacobi`](crate::Order::Jacobi).
    pub pressure: f32,
    /// Stiffness of the volume constraint. Default hard. With a soft one the body can be squashed.
    pub softness: Softness,
    /// Radius of every particle, metres, 0 or more. Default 0.005.
    pub radius: f32,
    /// Share of the velocity lost per second, 0 to 1. Default 0.
    pub drag: f32,
    /// Vertices of the mesh closer than this become one particle, metres, 0 or more. Default 1e-5.
    pub weld_tolerance: f32,
}

impl Default for SoftMeshSpec {
    fn default() -> Self {
        Self {
            bulk: Bulk::Mass(1.0),
            stretch: 100.0,
            bend: 0.01,
            damping: 0.1,
            pressure: 1.0,
            softness: Softness::Hard,
            radius: 0.005,
            drag: 0.0,
            weld_tolerance: 1e-5,
        }
    }
}

/// Builds a soft body from a closed triangle list, counter-clockwise from outside: a particle at each welded vertex ([`weld`](super::weld)), a distance along
/// each edge, bending across each edge, and one volume.
///
/// [`Blueprint::vertices`] holds the particle of each vertex of the mesh; [`Blueprint::triangles`] are for the wind.
///
/// The volume and the skin that pulls against it are solved in turns. At the default sweeps and substeps the volume of a dropped ball is off by 0.2 % at worst,
/// as with twice the sweeps, by 0.5 % with half of them and by 1.3 % with one.
///
/// # The skin
///
/// A sheet of springs has the stiffness `Y` (N/m) of a sheet of material if each spring represents the material around it: along an edge of length `l` between
/// the triangles `A₀` and `A₁`, `k = Y (A₀ + A₁)/l²`. That is exact for equilateral triangles, whose springs of `k = √3/2 Y` form an isotropic sheet with
/// Poisson's ratio 1/3, and a good approximation elsewhere (Van Gelder, *Approximate simulation of elastic membranes by triangulated spring meshes*, 1998).
///
/// # Errors
/// A [`RecipeFault`] if a value is out of range or the mesh is unsuitable; [`RecipeFault::Inside`] for an open, flat or inverted mesh.
pub fn soft_mesh(
    spec: &SoftMeshSpec,
    positions: &[Vec3],
    indices: &[u32],
) -> Result<Blueprint, RecipeFault> {
    check(spec)?;
    let welded = weld(positions, indices, spec.weld_tolerance)?;
    let (positions, triangles, edges) = (welded.positions, welded.triangles, welded.edges);
    let volume = MassProperties::of_mesh(&positions, &triangles)?.volume;
    let mass = spec.bulk.mass_of(volume)?;
    let areas: Vec<f64> = triangles.iter().map(|t| area(&positions, t)).collect();
    let mut masses = vec![0.0; positions.len()];
    // The mesh is closed and not flat, so the total area is positive.
    let per_area = mass / areas.iter().sum::<f64>();
    for (t, area) in triangles.iter().zip(&areas) {
        t.iter().for_each(|&i| masses[i as usize] += per_area * area / 3.0);
    }
    let seed = |(p, m): (&Vec3, &f64)| {
        let seed = ParticleSeed::at(*p).with_mass(*m as f32);
        seed.with_radius(spec.radius).with_drag(spec.drag)
    };
    let mut body = Blueprint {
        particles: positions.iter().zip(&masses).map(seed).collect(),
        vertices: welded.vertices,
        ..Blueprint::default()
    };
    for (&[a, b], around) in edges.iter().zip(around(&edges, &triangles, &areas)) {
        let [p, q] = [a, b].map(|i| positions[i as usize]);
        let length = (p.as_dvec3() - q.as_dvec3()).length();
        let stiffness = f64::from(spec.stretch) * around / (length * length);
        let inverse = [a, b].iter().map(|&i| 1.0 / masses[i as usize]).sum();
        let softness = damped(1.0 / stiffness, inverse, spec.damping);
        body.distances.push(Distance::new(a, b, rest_length(p, q)).with_softness(softness));
    }
    if spec.bend > 0.0 {
        body.constraints
            .extend(welded.bends.iter().filter_map(|b| fold(spec, b, &positions, &masses)));
    }
    let full = Volume::of(triangles.as_slice(), &positions).with_pressure(spec.pressure);
    let full = ConstraintKind::Volume(full.with_softness(spec.softness));
    body.constraints.push(Constraint::new(0..positions.len() as u32, full));
    body.triangles = triangles;
    sound(body)
}

fn check(spec: &SoftMeshSpec) -> Result<(), RecipeFault> {
    ensure((1e-6..=1e9).contains(&spec.stretch), RecipeFault::Stiffness)?;
    ensure(spec.bend.is_finite() && spec.bend >= 0.0, RecipeFault::BendStiffness)?;
    ensure((0.01..=100.0).contains(&spec.pressure), RecipeFault::Pressure)?;
    ensure(spec.softness.is_valid(), RecipeFault::Softness)?;
    ensure(DAMPING_RATIOS.contains(&spec.damping), RecipeFault::DampingRatio)?;
    check_particles(spec.radius, spec.drag)
}

/// Range of damping ratios for a soft body.
const DAMPING_RATIOS: RangeInclusive<f32> = 0.0..=10.0;

/// Area of a triangle, m².
fn area(positions: &[Vec3], t: &[u32; 3]) -> f64 {
    let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a).length() * 0.5
}

/// Total area of the triangles at each edge, m². The edges are sorted.
fn around(edges: &[[u32; 2]], triangles: &[[u32; 3]], areas: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; edges.len()];
    for (&[a, b, c], area) in triangles.iter().zip(areas) {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            if let Ok(edge) = edges.binary_search(&[p.min(q), p.max(q)]) {
                sums[edge] += area;
            }
        }
    }
    sums
}

/// The bending constraint across an edge.
fn fold(
    spec: &SoftMeshSpec,
    bend: &Fold,
    positions: &[Vec3],
    masses: &[f64],
) -> Option<Constraint> {
    let rows = [bend.edge[0], bend.edge[1], bend.opposite[0], bend.opposite[1]];
    let kind = constraints::Bend::stiff(rows.map(|i| positions[i as usize]), spec.bend)?;
    let Softness::Compliant { compliance, .. } = kind.softness else { return None };
    let square = |(i, w): (&u32, &f32)| f64::from(w * w) / masses[*i as usize];
    let inverse = rows.iter().zip(&kind.weights).map(square).sum();
    let softness = damped(f64::from(compliance), inverse, spec.damping);
    Some(Constraint::new(rows, ConstraintKind::Bend(kind.with_softness(softness))))
}

/// A compliance with damping of `ratio` times critical: `β = 2ζ√(kμ)` with `k = 1/α` and the effective mass `μ = 1/Σ w‖∇C‖²`.
fn damped(compliance: f64, inverse_mass: f64, ratio: f32) -> Softness {
    let damping = 2.0 * f64::from(ratio) / (compliance * inverse_mass).sqrt();
    Softness::Compliant { compliance: compliance as f32, damping: damping as f32 }
}

/// Returns the body if all its numbers are normal: lengths are squared and masses inverted in `f32` in every sweep.
fn sound(body: Blueprint) -> Result<Blueprint, RecipeFault> {
    let [low, high] = bounds(body.particles.iter().map(|p| p.position)).map(Vec3::as_dvec3);
    if !LENGTHS.contains(&((high - low).max_element() as f32)) {
        return Err(RecipeFault::Size);
    }
    let lengths = body.distances.iter().map(|d| d.rest * d.rest);
    let compliances = body.distances.iter().filter_map(|d| match d.softness {
        Softness::Compliant { compliance, .. } => Some(compliance),
        _ => None,
    });
    let mut ordinary = lengths.chain(compliances).chain(body.particles.iter().map(|p| p.mass));
    let sound = ordinary.all(|x| x.is_normal() && (1.0 / x).is_normal()) && body.validate().is_ok();
    if sound { Ok(body) } else { Err(RecipeFault::Scale) }
}

#[cfg(test)]
mod tests;
