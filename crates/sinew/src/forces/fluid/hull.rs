//! Hulls: bodies of several particles that float by their own shape.
//!
//! The force of a fluid at rest on a body is that of the pressure on its wetted skin, `F = -∫ ρ g s n dA`, with the moment `-∫ ρ g s x × n dA`.
//! [`clip`](super::clip) gives both exactly for a triangle, distributed to its corners; this module sums them.
//!
//! **A closed skin** needs no cap at the waterline: there `s = 0`, so the pressure on a cap is zero. By the divergence theorem the sum is `ρ g V up`,
//! Archimedes' law with the submerged volume `V`, acting at its centroid: `-∫ s n dA = -∫ ∇s dV = up V`.
//!
//! **An open skin**, such as a boat, is correct as it is while its rim is dry: it floats on its outside. When the rim is submerged, the pressure on the opening
//! is missing, and a sunken boat would be thrown out of the water. So the rim (the edges with a triangle on one side only) is covered by a lid, a fan about the
//! middle of the rim, which takes pressure where it is submerged. That closes every skin. *Water does not flow in*: a boat that heels or sinks below its rim
//! floats as if it had a deck, and sinks when it weighs more than the water displaced by boat and lid.
//!
//! **From the skin to the particles.** If the particles are the corners of the skin, they take the forces of their triangles: force and moment are those of the
//! pressure, to round-off. If the skin follows the pose of the particles, the force `F` and the moment `τ` about their barycentre accelerate them as a rigid
//! body, `aᵢ = F/M + α × rᵢ` with `I α = τ`: the sums over the particles are `F` and `τ` again. The part of a moment that collinear particles or a single one
//! cannot take is dropped (the pseudo-inverse of `I`).

use glam::{DVec3, Quat, Vec3};

use super::Fluid;
use super::clip::{Wetting, wetting};
use crate::forces::region::WorldPoint;
use crate::particles::Particles;
use crate::pose::{PointMasses, Pose, pose, pseudo_solve};

mod skin;

pub use skin::{Hull, HullFault, Skin};

/// Scratch of the fluids; it keeps its allocations between calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct FluidScratch {
    /// Which rows carry a hull, and so do not float as balls.
    pub(super) carriers: Vec<bool>,
    /// Vertices of the current hull, metres from its first carrier.
    points: Vec<DVec3>,
    /// Force on each vertex for a specific weight of the fluid of 1 Pa/m, m³.
    forces: Vec<DVec3>,
}

/// Adds the buoyancy and the drag of all fluids on a hull, and marks its carriers. A faulty hull is skipped, and its particles float as balls.
pub(super) fn apply(
    particles: &mut Particles,
    fluids: &[Fluid],
    hull: &Hull,
    gravity: Vec3,
    scratch: &mut FluidScratch,
) {
    if hull.fault(particles.len()).is_some() {
        return;
    }
    for &row in &hull.rows {
        scratch.carriers[row as usize] = true;
    }
    if place(particles, hull, &mut scratch.points).is_none() {
        return;
    }
    let first = hull.rows[0] as usize;
    for fluid in fluids.iter().filter(|fluid| fluid.is_valid()) {
        let Some(load) = Load::of(particles, hull, fluid, scratch) else { continue };
        let inside =
            fluid.region.share_at(WorldPoint::of(particles, first).moved(load.middle.as_vec3()));
        if inside > 0.0 {
            let weight = f64::from(fluid.weight(gravity) * inside);
            match hull.skin() {
                Skin::Carriers => apply_forces(particles, hull, &scratch.forces, weight),
                Skin::Posed { .. } => push(particles, hull, &load, weight),
            }
            let rate = fluid.rate() * load.share as f32 * inside;
            for &i in &hull.rows {
                particles.push_drag(i as usize, rate, fluid.current);
            }
        }
    }
}

/// Computes the positions of a hull's vertices, metres from its first carrier. `None` if the carriers have no pose.
fn place(particles: &Particles, hull: &Hull, points: &mut Vec<DVec3>) -> Option<()> {
    let first = hull.rows[0] as usize;
    points.clear();
    match hull.skin() {
        Skin::Carriers => points.extend(hull.rows.iter().map(|&i| from(particles, i, first))),
        Skin::Posed { vertices, rest } => {
            // A pinned carrier has infinite mass; it is given the mean mass of the others.
            let (sum, count) = moving(particles, &hull.rows)
                .fold((0.0, 0.0), |(sum, count), (_, m)| (sum + m, count + 1.0));
            let mean = if count > 0.0 { (sum / count) as f32 } else { 1.0 };
            let carriers = hull.rows.iter().zip(rest).map(|(&i, &rest)| {
                let i = i as usize;
                let w = particles.position[i].w;
                (particles.separation(i, first), rest, if w > 0.0 { 1.0 / w } else { mean })
            });
            // Always with the same initial rotation, so that the result depends on the particles alone.
            let found: Pose = pose(carriers, Quat::IDENTITY)?;
            points.extend(vertices.iter().map(|&v| found.point(v).as_dvec3()));
        }
    }
    Some(())
}

/// The total load on a hull by a fluid with a specific weight of 1 Pa/m.
#[derive(Default)]
struct Load {
    /// Force, m³.
    force: DVec3,
    /// Moment about the first carrier, m⁴.
    moment: DVec3,
    /// Submerged share of the volume, or of the area for an open hull, 0 to 1.
    share: f64,
    /// Centre of pressure, metres from the first carrier; it is below the surface.
    middle: DVec3,
}

impl Load {
    /// Integrates the pressure, and leaves the force on each vertex in `scratch.forces`. `None` if nothing is submerged.
    fn of(
        particles: &Particles,
        hull: &Hull,
        fluid: &Fluid,
        scratch: &mut FluidScratch,
    ) -> Option<Self> {
        let FluidScratch { points, forces, .. } = scratch;
        let (up, first) = (fluid.up.as_dvec3(), hull.rows[0] as usize);
        let level = f64::from(fluid.level) - up.dot(place_of(particles, first));
        if !points.iter().any(|x| up.dot(*x) < level) {
            return None;
        }
        forces.clear();
        forces.resize(points.len(), DVec3::ZERO);
        let mut sum = SkinSums::default();
        for corners in hull.triangles() {
            let at = corners.map(|v| v as usize);
            let (area, wetting) = sum.add(at.map(|v| points[v]), up, level);
            sum.area += area.length();
            sum.wetted += area.length() * wetting.share;
            for (v, weight) in at.into_iter().zip(wetting.weights) {
                forces[v] -= area * weight;
                let pressure = area.length() * weight;
                sum.pressure += pressure;
                sum.middle += points[v] * pressure;
            }
        }
        sum.add_lid(hull.rim(), points, forces, up, level);
        // On a skin that is inside out (by its winding, or by deformation) the fluid is still outside.
        let outward = if sum.volume < 0.0 { -1.0 } else { 1.0 };
        let mut load = Self::default();
        for (force, x) in forces.iter_mut().zip(points) {
            *force *= outward;
            load.force += *force;
            load.moment += x.cross(*force);
        }
        if !(load.force.is_finite() && load.moment.is_finite() && sum.pressure > 0.0) {
            return None;
        }
        load.middle = sum.middle / sum.pressure;
        let (part, whole) = if hull.is_open() || sum.volume == 0.0 {
            (sum.wetted, sum.area)
        } else {
            (load.force.dot(up), sum.volume.abs())
        };
        load.share = if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
        Some(load)
    }
}

/// Sums over the skin.
#[derive(Default)]
struct SkinSums {
    volume: f64,
    area: f64,
    wetted: f64,
    pressure: f64,
    middle: DVec3,
}

impl SkinSums {
    /// One triangle: adds its part of the volume; returns its outward vector area, m², and its wetting. A triangle that is not finite counts as zero.
    fn add(&mut self, [a, b, c]: [DVec3; 3], up: DVec3, level: f64) -> (DVec3, Wetting) {
        let area = (b - a).cross(c - a) * 0.5;
        if !area.is_finite() {
            return (DVec3::ZERO, Wetting::default());
        }
        // The tetrahedron from the first carrier to the triangle.
        self.volume += a.dot(area) / 3.0;
        (area, wetting([a, b, c].map(|x| level - up.dot(x))))
    }

    /// The lid: a fan over the rim about its middle. The force on the middle is distributed equally to the vertices of the rim.
    fn add_lid(
        &mut self,
        rim: &[[u32; 2]],
        points: &[DVec3],
        forces: &mut [DVec3],
        up: DVec3,
        level: f64,
    ) {
        if rim.is_empty() {
            return;
        }
        let share = 1.0 / rim.len() as f64;
        let middle = rim.iter().map(|&[a, _]| points[a as usize]).sum::<DVec3>() * share;
        let mut on_middle = DVec3::ZERO;
        for &[a, b] in rim {
            // Reversed: the skin is on the left of a rim edge, the lid on its right.
            let at = [b as usize, a as usize];
            let (area, wetting) = self.add([points[at[0]], points[at[1]], middle], up, level);
            forces[at[0]] -= area * wetting.weights[0];
            forces[at[1]] -= area * wetting.weights[1];
            on_middle -= area * wetting.weights[2];
        }
        for &[a, _] in rim {
            forces[a as usize] += on_middle * share;
        }
    }
}

/// Applies the forces on the vertices to the carriers, which are the same particles.
fn apply_forces(particles: &mut Particles, hull: &Hull, forces: &[DVec3], weight: f64) {
    for (&i, &force) in hull.rows.iter().zip(forces) {
        particles.push_force(i as usize, (force * weight).as_vec3());
    }
}

/// Accelerates the free carriers as a rigid body, by the total force and moment.
fn push(particles: &mut Particles, hull: &Hull, load: &Load, weight: f64) {
    let first = hull.rows[0] as usize;
    let free = moving(particles, &hull.rows).map(|(i, m)| (from(particles, i, first), m));
    let PointMasses { mass, barycentre, inertia } = PointMasses::of(free);
    if mass == 0.0 {
        return;
    }
    let linear = load.force * (weight / mass);
    let moment = (load.moment - barycentre.cross(load.force)) * weight;
    let angular = pseudo_solve(inertia, moment);
    for &i in &hull.rows {
        if particles.position[i as usize].w > 0.0 {
            let r = from(particles, i, first) - barycentre;
            particles.push_acceleration(i as usize, (linear + angular.cross(r)).as_vec3());
        }
    }
}

/// The free carriers, with their masses.
fn moving(particles: &Particles, rows: &[u32]) -> impl Iterator<Item = (u32, f64)> + Clone {
    let of = |&i: &u32| (i, f64::from(particles.position[i as usize].w));
    rows.iter().map(of).filter(|&(_, w)| w > 0.0).map(|(i, w)| (i, 1.0 / w))
}

/// Position of particle `i`, metres from particle `first`.
fn from(particles: &Particles, i: u32, first: usize) -> DVec3 {
    place_of(particles, i as usize) - place_of(particles, first)
}

fn place_of(particles: &Particles, i: usize) -> DVec3 {
    particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3()
}
