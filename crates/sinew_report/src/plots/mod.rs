//! The pictures of the report: what a table cannot show, drawn from the same worlds that the cases measure.

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

/// A picture: curves in one pair of axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Its file's name, without `.png`.
    pub name: &'static str,
    /// What it shows, in a line.
    pub title: &'static str,
    /// What is along each axis, with its unit.
    pub axes: [&'static str; 2],
    /// What is shown of the vertical axis; curves that leave it are cut off.
    pub height: [f64; 2],
    /// The curves, in the order of the legend; later ones lie on top.
    pub curves: Vec<Curve>,
}

/// A line, or dots.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its words in the legend.
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
    /// A broad, pale line: what others are to lie on.
    Band,
    /// A dot at each point.
    Dots,
}

impl Plot {
    /// The picture as a PNG file, 1080 × 660 pixels.
    ///
    /// # Errors
    /// What the drawing or the encoding finds wrong, in words.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        draw::png(self)
    }

    /// Writes the picture into a folder, which is made if it is not there, and returns its path.
    ///
    /// # Errors
    /// What is wrong with the folder or the file.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, String> {
        let path = folder.join(format!("{}.png", self.name));
        let shown = |error: std::io::Error| format!("{}: {error}", path.display());
        std::fs::create_dir_all(folder).map_err(shown)?;
        std::fs::write(&path, self.png()?).map_err(shown)?;
        Ok(path)
    }
}

/// All pictures. They run worlds of their own, for a second or so.
pub fn plots() -> Vec<Plot> {
    vec![energy(), spin(), flips(), catenary()]
}

fn line(name: impl Into<String>, points: Vec<[f64; 2]>) -> Curve {
    Curve { name: name.into(), stroke: Stroke::Line, points }
}

/// Energy over time of an oscillator with the four integrators.
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
    // It has the numbers of Verlet: one as dots, one as a line through them.
    curves[2].stroke = Stroke::Dots;
    Plot {
        name: "energy",
        title: "Energy of an oscillator of 1 rad/s at h = 0.3 s",
        axes: ["time / s", "energy / energy at first"],
        height: [0.75, 1.55],
        curves,
    }
}

/// Spin over time of a cube of rods for the two directions of a correction.
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
        let name = format!("Current, {substeps} substep{plural}, with ω0/√(1+2ω0²ht) beneath");
        // The law has no words of its own: the broad line under the measured one.
        curves.push(Curve { name: String::new(), stroke: Stroke::Band, points: law.collect() });
        curves.push(line(name, measured(GradientAt::Current, substeps)));
    }
    Plot {
        name: "spin",
        title: "Spin of a cube of 28 rods in the void, 1/60 s",
        axes: ["time / s", "spin / (rad/s)"],
        height: [0.0, 13.5],
        curves,
    }
}

/// Spin of a 1×2×3 box about its own middle axis, which turns over again and again.
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
    // It starts in the middle between two flips.
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

/// A chain of 20 links at rest, on the curve of a chain without links.
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
        title: "A chain of 1.5 m between two points 1 m apart, by statics",
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
