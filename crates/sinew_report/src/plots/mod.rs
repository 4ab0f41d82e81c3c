//! The plots of the report, drawn from the same simulations that the cases measure.

mod draw;

use std::path::{Path, PathBuf};

use sinew::glam::Vec3;
use sinew::rigid::RigidIntegrator;
use sinew::{GradientAt, Integrator};

use crate::bodies::{inside, solid, turn};
use crate::compounds::{FLIP, middle_spin, tumbling_box};
use crate::integrators::energies;
use crate::measure::{TICK, at, step, steps};
use crate::media::hanging_chain;
use crate::solver::{bled, spin_of, spinning_cube};

/// A plot: curves in one pair of axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Name of its file, without `.png`.
    pub name: &'static str,
    /// Title of the plot.
    pub title: &'static str,
    /// Labels of the x and y axes, with units.
    pub axes: [&'static str; 2],
    /// Range of the vertical axis; curves that leave it are clipped.
    pub height: [f64; 2],
    /// The curves, in the order of the legend; later ones are drawn on top.
    pub curves: Vec<Curve>,
}

/// A line, or dots.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend. A curve with an empty name has no entry, and the colour of the next one.
    pub name: String,
    /// How it is drawn.
    pub stroke: Stroke,
    /// Its points, from left to right.
    pub points: Vec<[f64; 2]>,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// A line.
    Line,
    /// A broad, pale line: a reference that other curves should lie on.
    Band,
    /// A dot at each point.
    Dots,
}

impl Plot {
    /// Encodes the plot as a PNG file, 1080 × 660 pixels.
    ///
    /// # Errors
    /// A message if drawing or encoding fails.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        draw::png(self)
    }

    /// Writes the plot into a folder, which is created if it does not exist, and returns its path.
    ///
    /// # Errors
    /// A message if the folder or the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, String> {
        let path = folder.join(format!("{}.png", self.name));
        let shown = |error: std::io::Error| format!("{}: {error}", path.display());
        std::fs::create_dir_all(folder).map_err(shown)?;
        std::fs::write(&path, self.png()?).map_err(shown)?;
        Ok(path)
    }
}

/// All plots. Each runs a simulation of its own; together they take about a second.
pub fn plots() -> Vec<Plot> {
    vec![energy(), spin(), flips(), catenary()]
}

fn line(name: impl Into<String>, points: Vec<[f64; 2]>) -> Curve {
    Curve { name: name.into(), stroke: Stroke::Line, points }
}

/// Energy of an oscillator over time with each of the four integrators.
fn energy() -> Plot {
    let h = 0.3_f32;
    let curve = |integrator: Integrator| {
        let points = energies(integrator, h, 134);
        let start = [0.0, 1.0];
        let later = points.iter().zip(1..).map(|(&e, n)| [f64::from(h) * f64::from(n), e]);
        line(format!("{integrator:?}"), core::iter::once(start).chain(later).collect())
    };
    let mut curves: Vec<Curve> = [
        Integrator::ExplicitEuler,
        Integrator::SemiImplicitEuler,
        Integrator::Leapfrog,
        Integrator::Verlet,
    ]
    .map(curve)
    .into();
    // Leapfrog and Verlet have the same values: the one is drawn as dots, the other as a line through them.
    curves[2].stroke = Stroke::Dots;
    Plot {
        name: "energy",
        title: "Energy of an oscillator of 1 rad/s at h = 0.3 s",
        axes: ["time / s", "energy / initial energy"],
        height: [0.75, 1.55],
        curves,
    }
}

/// Spin of a cube of rods over time, for both choices of the gradients.
fn spin() -> Plot {
    let measured = |gradient_at, substeps| {
        let mut world = spinning_cube(10.0, gradient_at, substeps, 20);
        let mut points = vec![[0.0, 10.0]];
        for n in 1..=600 {
            step(&mut world, TICK);
            points.push([f64::from(n) / 60.0, spin_of(&world)]);
        }
        points
    };
    let mut curves = vec![line("StepStart, 20 substeps", measured(GradientAt::StepStart, 20))];
    for substeps in [20, 8, 1] {
        let h = 1.0 / (60.0 * f64::from(substeps));
        let law = (0..=600).map(|n| {
            let t = f64::from(n) / 60.0;
            [t, bled(10.0, h, t)]
        });
        let plural = if substeps == 1 { "" } else { "s" };
        let name = format!("Current, {substeps} substep{plural}, over ω0/√(1+2ω0²ht)");
        // The formula has no legend entry of its own: it is the broad line under the measured one.
        curves.push(Curve { name: String::new(), stroke: Stroke::Band, points: law.collect() });
        curves.push(line(name, measured(GradientAt::Current, substeps)));
    }
    Plot {
        name: "spin",
        title: "Spin of a free cube of 28 rods, 1/60 s",
        axes: ["time / s", "spin / (rad/s)"],
        height: [0.0, 13.5],
        curves,
    }
}

/// Spin of a 1×2×3 box about its middle axis, which flips again and again.
fn flips() -> Plot {
    let h = 1.0 / 240.0_f32;
    // Every fourth step is fine enough to draw.
    let times = || (0..20 * 60).map(|n| f64::from(n) / 60.0);
    let mut body = solid(Vec3::new(0.06, 6.0, 0.0));
    let rigid = times().map(|t| {
        let now = [t, inside(&body).y];
        (0..4).for_each(|_| turn(&mut body, h, RigidIntegrator::Verlet));
        now
    });
    let rigid = rigid.collect();
    let (mut world, rows) = tumbling_box();
    let particles = times().map(|t| {
        let now = [t, middle_spin(&world, rows.clone())];
        steps(&mut world, h, 4);
        now
    });
    // The start is half way between two flips.
    let exact = (0..5).map(|n| [FLIP * (0.5 + f64::from(n)), 0.0]);
    Plot {
        name: "flips",
        title: "A 1×2×3 m box, 6 rad/s about its middle axis, 1 % about its first",
        axes: ["time / s", "spin about its middle axis / (rad/s)"],
        height: [-7.0, 10.5],
        curves: vec![
            Curve {
                name: "rigid body, Verlet, 1/240 s".into(),
                stroke: Stroke::Band,
                points: rigid,
            },
            line("particles, 28 rods, StepStart, 1/240 s", particles.collect()),
            Curve { name: "every 3.903 s".into(), stroke: Stroke::Dots, points: exact.collect() },
        ],
    }
}

/// A chain of 20 links at rest, and the catenary.
fn catenary() -> Plot {
    let world = hanging_chain(20);
    let links = (0..world.particles.len()).map(|i| at(&world, i)).map(|p| [p.x, p.y]);
    // 2a sinh(1/2a) = 1.5, by bisection.
    let (mut low, mut high) = (0.1, 10.0);
    for _ in 0..60 {
        let a = 0.5 * (low + high);
        if 2.0 * a * libm::sinh(0.5 / a) > 1.5 { low = a } else { high = a }
    }
    let curve = (0..=200).map(|n| {
        let x = f64::from(n) / 200.0;
        [x, low * (libm::cosh((x - 0.5) / low) - libm::cosh(0.5 / low))]
    });
    Plot {
        name: "catenary",
        title: "A chain of 1.5 m between two points 1 m apart, static equilibrium",
        axes: ["x / m", "y / m"],
        height: [-0.56, 0.14],
        curves: vec![
            Curve {
                name: "a cosh((x - ½)/a), sag 0.5026 m".into(),
                stroke: Stroke::Band,
                points: curve.collect(),
            },
            Curve {
                name: "particles, 20 links".into(),
                stroke: Stroke::Dots,
                points: links.collect(),
            },
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_has_curves_in_its_frame_and_is_a_png_with_their_colours_in_it() {
        let plots = plots();
        assert!(plots.len() >= 4);
        for plot in plots {
            for curve in &plot.curves {
                assert!(curve.points.iter().flatten().all(|x| x.is_finite()), "{}", plot.name);
                let [low, high] = plot.height;
                let inside = curve.points.iter().filter(|p| (low..=high).contains(&p[1])).count();
                assert!(inside > 3, "{}: {} is out of the picture", plot.name, curve.name);
            }
            let file = plot.png().expect("a picture");
            let mut reader =
                png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG");
            let mut pixels = vec![0; reader.output_buffer_size().expect("it fits")];
            let info = reader.next_frame(&mut pixels).expect("its pixels");
            assert_eq!([info.width, info.height], [1080, 660]);
            let white = pixels.chunks(3).filter(|p| **p == [255, 255, 255]).count();
            let coloured = pixels.chunks(3).filter(|p| p[0].abs_diff(p[2]) > 60).count();
            assert!(white > 300_000 && coloured > 500, "{}: {white} {coloured}", plot.name);
        }
    }
}
