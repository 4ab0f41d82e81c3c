//! Cloth as a regular grid: a flag, a curtain, a trampoline, a sail (physics.md B3). Rows of equal cells are also fastest for the solver, so for a rectangle
//! prefer this to a mesh.

use glam::Vec3;

use super::blueprint::Blueprint;
use super::fault::{RecipeFault, check_particles, ensure};
use super::limits::{LENGTHS, MAX_PARTICLES, is_compliance};
use crate::constraints::Distance;
use crate::particles::ParticleSeed;

/// Material of cloth, shared by grids and meshes. The default is plain-woven cotton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClothMaterial {
    /// Mass per area, kg/m², 1e-6 to 1e6. Default 0.2 (a bed sheet 0.15, denim 0.4, silk 0.06).
    pub density: f32,
    /// Compliance of the threads, along them and in shear, m/N, 0 or more. Default 0: cloth does not stretch.
    pub stretch_compliance: f32,
    /// Compliance of the bending distances across each fold, m/N, 0 or more; `None` for cloth that bends freely, without such distances.
    ///
    /// Default 1. With particles a distance `s` apart, a fold by the angle `θ` costs `s²θ⁴/32α`; cloth of bending rigidity `B` (N·m) costs `½Bθ²`. They agree
    /// at a fold of 1 rad for `α = s²/16B`. In cells of 5 cm, 1 m/N is `B = 1.6e-4` (a stiff cotton); in cells of 1 cm, 6e-6 (a silk; Kawabata's tests of
    /// fabrics find 2e-6 to 1e-4).
    pub bend_compliance: Option<f32>,
    /// Radius of every particle, metres, 0 or more. Default 0.005. Contacts keep the cloth this far from other surfaces.
    pub radius: f32,
    /// Share of the velocity lost per second, 0 to 1. Default 0. Air is better modelled as wind.
    pub drag: f32,
    /// Vertices of a mesh closer than this become one particle, metres, 0 or more. Default 1e-5: the rounding of a coordinate of 100 m in a file. A grid
    /// ignores it.
    pub weld_tolerance: f32,
}

/// A rectangle of cloth to build. The default is 1 m × 1 m in 20 × 20 cells.
///
/// It hangs in the xy plane, centred on the origin: columns run from left (-x) to right, rows from the top (+y) down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClothSpec {
    /// Length along x, metres, 1e-6 to 1e6. Default 1.
    pub width: f32,
    /// Length along y, metres, 1e-6 to 1e6. Default 1.
    pub height: f32,
    /// Cells from left to right, at least 1. Default 20. A row has one more particle than that.
    pub columns: u32,
    /// Cells from top to bottom, at least 1. Default 20. There is one more row of particles than that.
    pub rows: u32,
    /// Whether each cell has both its diagonals, against shear. Default true.
    pub shear: bool,
    /// The material.
    pub material: ClothMaterial,
}

impl Default for ClothMaterial {
    fn default() -> Self {
        Self {
            density: 0.2,
            stretch_compliance: 0.0,
            bend_compliance: Some(1.0),
            radius: 0.005,
            drag: 0.0,
            weld_tolerance: 1e-5,
        }
    }
}

impl Default for ClothSpec {
    fn default() -> Self {
        Self {
            width: 1.0,
            height: 1.0,
            columns: 20,
            rows: 20,
            shear: true,
            material: ClothMaterial::default(),
        }
    }
}

/// Builds a rectangle of cloth from rows of particles: the top row first, each from left to right.
///
/// Distances are grouped into families, each row by row and of one rest length: along rows, along columns, the diagonals down to the right, the diagonals down
/// to the left, and the bending distances to the second next particle along rows and along columns. A particle has the mass of the quarters of cells around it.
/// There are two triangles a cell, counter-clockwise seen from +z. Vertex `i` of a mesh with the same numbering follows particle `i`.
pub fn cloth_grid(spec: &ClothSpec) -> Result<Blueprint, RecipeFault> {
    check(spec)?;
    let (columns, rows) = (spec.columns, spec.rows);
    let (dx, dy) =
        (f64::from(spec.width) / f64::from(columns), f64::from(spec.height) / f64::from(rows));
    let mut body = Blueprint {
        particles: particles(spec, f64::from(spec.material.density) * dx * dy),
        vertices: (0..(columns + 1) * (rows + 1)).collect(),
        ..Blueprint::default()
    };
    let mut tie = |compliance: f32, length: f64, [x0, y0]: [u32; 2], [x1, y1]: [u32; 2]| {
        let (across, down) = (x0.max(x1), y0.max(y1));
        for row in 0..(rows + 1).saturating_sub(down) {
            body.distances.extend((0..(columns + 1).saturating_sub(across)).map(|column| {
                let (a, b) = (spec.index(column + x0, row + y0), spec.index(column + x1, row + y1));
                Distance::new(a, b, length as f32).with_compliance(compliance)
            }));
        }
    };
    let stretch = spec.material.stretch_compliance;
    tie(stretch, dx, [0, 0], [1, 0]);
    tie(stretch, dy, [0, 0], [0, 1]);
    if spec.shear {
        let diagonal = (dx * dx + dy * dy).sqrt();
        tie(stretch, diagonal, [0, 0], [1, 1]);
        tie(stretch, diagonal, [1, 0], [0, 1]);
    }
    if let Some(bend) = spec.material.bend_compliance {
        tie(bend, 2.0 * dx, [0, 0], [2, 0]);
        tie(bend, 2.0 * dy, [0, 0], [0, 2]);
    }
    body.triangles.reserve(2 * (columns * rows) as usize);
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [0, 1].map(|right| spec.index(column + right, row));
            let [c, d] = [0, 1].map(|right| spec.index(column + right, row + 1));
            body.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    Ok(body)
}

/// Texture coordinates of [`cloth_grid`]'s particles, for a mesh of the same numbering: (0, 0) at the top left, (1, 1) at the bottom right. Fails for the same
/// specs as [`cloth_grid`].
pub fn grid_uvs(spec: &ClothSpec) -> Result<Vec<[f32; 2]>, RecipeFault> {
    check(spec)?;
    let share = |i: u32, of: u32| (f64::from(i) / f64::from(of)) as f32;
    let row = |r| (0..=spec.columns).map(move |c| [share(c, spec.columns), share(r, spec.rows)]);
    Ok((0..=spec.rows).flat_map(row).collect())
}

impl ClothSpec {
    /// The particle at a column and a row, both from 0 to the number of cells; larger values are clamped.
    pub fn index(&self, column: u32, row: u32) -> u32 {
        let above = row.min(self.rows).saturating_mul(self.columns.saturating_add(1));
        above.saturating_add(column.min(self.columns))
    }

    /// The particles at the corners: top left, top right, bottom left, bottom right.
    pub fn corners(&self) -> [u32; 4] {
        let (right, bottom) = (self.columns, self.rows);
        [(0, 0), (right, 0), (0, bottom), (right, bottom)]
            .map(|(column, row)| self.index(column, row))
    }
}

impl ClothMaterial {
    /// Returns the first fault.
    pub(super) fn check(&self) -> Result<(), RecipeFault> {
        ensure((1e-6..=1e6).contains(&self.density), RecipeFault::Density)?;
        ensure(is_compliance(self.stretch_compliance), RecipeFault::Compliance)?;
        let bend = self.bend_compliance.is_none_or(is_compliance);
        ensure(bend, RecipeFault::BendCompliance)?;
        check_particles(self.radius, self.drag)
    }

    /// A particle of this material; `mass` in kg.
    pub(super) fn seed(&self, position: Vec3, mass: f64) -> ParticleSeed {
        let seed = ParticleSeed::at(position).with_mass(mass as f32);
        seed.with_radius(self.radius).with_drag(self.drag)
    }
}

fn check(spec: &ClothSpec) -> Result<(), RecipeFault> {
    let particles = (u64::from(spec.columns) + 1).saturating_mul(u64::from(spec.rows) + 1);
    let sizes = LENGTHS.contains(&spec.width) && LENGTHS.contains(&spec.height);
    ensure(sizes, RecipeFault::Size)?;
    ensure(spec.columns > 0 && spec.rows > 0, RecipeFault::NoCells)?;
    ensure(particles <= MAX_PARTICLES, RecipeFault::TooMany)?;
    spec.material.check()
}

fn particles(spec: &ClothSpec, cell_mass: f64) -> Vec<ParticleSeed> {
    let share = |i: u32, of: u32| f64::from(i) / f64::from(of) - 0.5;
    let inside = |i: u32, of: u32| if i == 0 || i == of { 0.5 } else { 1.0 };
    let particle = |column, row| {
        let x = f64::from(spec.width) * share(column, spec.columns);
        let y = f64::from(spec.height) * -share(row, spec.rows);
        let mass = cell_mass * inside(column, spec.columns) * inside(row, spec.rows);
        spec.material.seed(Vec3::new(x as f32, y as f32, 0.0), mass)
    };
    (0..=spec.rows)
        .flat_map(|row| (0..=spec.columns).map(move |column| particle(column, row)))
        .collect()
}

#[cfg(test)]
mod tests;
