//! The Plots section: energies, momenta, errors of the solver and durations of a tick over the last seconds.

use bevy_egui::egui::{Button, Color32, FontId, Grid, TextStyle, Ui, vec2};
use egui_plot::{AxisHints, GridMark, HoverPosition, Line, Plot, PlotPoints, uniform_grid_spacer};

use crate::history::{PlotHistory, PlotSample};
use crate::params::PanelParams;
use crate::state::Plotted;
use crate::style::{AXES, GRAVITATIONAL, KINETIC, SERIES, STORED, TOTAL, WARN};
use crate::widgets::{colored_value, prefix, row};

/// The most points in a curve, give or take a factor of two; the plot is about 220 points wide.
const POINTS: usize = 300;

/// The buttons that choose what is plotted, with label and hint, in [`COLUMNS`] columns.
const CHOICES: [(Plotted, &str, &str); 6] = [
    (Plotted::Energy, "Energy", "Energies by kind, and their sum."),
    (Plotted::Momentum, "Momentum", "Momentum of all free particles along x, y and z."),
    (
        Plotted::AngularMomentum,
        "Ang. mom.",
        "Angular momentum of all free particles about the world's origin, along x, y and z.",
    ),
    (Plotted::Error, "Error, mm", "Largest residual of a hard constraint."),
    (Plotted::Strain, "Strain, %", "Largest residual of a hard distance, relative to its length."),
    (Plotted::Time, "Tick, ms", "Time of a tick on this machine, by parts or by phases."),
];
const COLUMNS: usize = 3;

/// One curve.
struct Curve {
    name: &'static str,
    color: Color32,
    hint: &'static str,
    read: fn(&PlotSample) -> f64,
}

/// How the numbers of a plot are written.
#[derive(Clone, Copy)]
struct Unit {
    name: &'static str,
    /// Whether it takes SI prefixes: kJ and mJ, but neither k% nor mmm.
    prefixed: bool,
}

impl Unit {
    /// What a number of about `size` is divided by for display, and the unit with its prefix.
    fn of(self, size: f64) -> (f64, String) {
        let (scale, prefix) = if self.prefixed { prefix(size) } else { (1.0, "") };
        (scale, format!("{prefix}{}", self.name))
    }
}

/// Draws the section. It only reads the world; the choice of curves is the panel's own state.
pub(crate) fn plots(ui: &mut Ui, panel: &mut PanelParams) {
    let chosen = panel.state.plot;
    let width = ((ui.available_width() - 4.0 * (COLUMNS - 1) as f32) / COLUMNS as f32).floor();
    Grid::new("sinew_plots").num_columns(COLUMNS).spacing([4.0, 2.0]).show(ui, |ui| {
        for (i, (plot, name, hint)) in CHOICES.into_iter().enumerate() {
            let button = Button::selectable(plot == chosen, name).min_size(vec2(width, 20.0));
            if ui.add(button).on_hover_text(hint).clicked() {
                panel.state.plot = plot;
            }
            if i % COLUMNS == COLUMNS - 1 {
                ui.end_row();
            }
        }
    });
    let by_phase = panel.state.by_phase;
    if chosen == Plotted::Time {
        let hint = "Measures each phase of the substeps. They then run separately, with the same bits, but slower.";
        row(ui, "Phases", hint, |ui| {
            ui.checkbox(&mut panel.state.by_phase, "Measured").on_hover_text(hint);
        });
    }
    let history = &panel.history;
    let unit = match chosen {
        Plotted::Energy => Unit { name: "J", prefixed: true },
        Plotted::Momentum => Unit { name: "kg·m/s", prefixed: false },
        Plotted::AngularMomentum => Unit { name: "kg·m²/s", prefixed: false },
        Plotted::Error => Unit { name: "mm", prefixed: false },
        Plotted::Strain => Unit { name: "%", prefixed: false },
        Plotted::Time => Unit { name: "ms", prefixed: false },
    };
    let curves = curves(chosen, by_phase, history);
    draw(ui, history, &curves, unit);
    let latest = history.last().copied().unwrap_or_default();
    for Curve { name, color, hint, read } in curves {
        let now = read(&latest);
        let (scale, unit) = unit.of(now);
        let number = readable(now / scale, chosen == Plotted::Energy);
        colored_value(ui, Some(color), name, hint, &number, &unit, None);
    }
}

/// The curves of a plot; the last one is drawn under all others.
fn curves(plot: Plotted, by_phase: bool, history: &PlotHistory) -> Vec<Curve> {
    let curve = |name, color, hint, read| Curve { name, color, hint, read };
    match plot {
        Plotted::Energy => {
            let mut all = vec![
                curve(
                    "Kinetic",
                    KINETIC,
                    "Kinetic energy: sum of ½mv² over all particles.",
                    |s| s.kinetic,
                ),
                curve(
                    "Gravitational",
                    GRAVITATIONAL,
                    "Gravitational potential energy, zero at the world's origin.",
                    |s| s.gravitational,
                ),
            ];
            if history.iter().any(|sample| sample.stored != 0.0) {
                let hint = "Energy in springs and between charges.";
                all.push(curve("Stored", STORED, hint, |s| s.stored));
            }
            let hint = "Sum of all kinds. Drag, friction and pins reduce it, winds increase it.";
            all.push(curve("Total", TOTAL, hint, PlotSample::total));
            all
        }
        Plotted::Momentum => {
            let hint = "Σ m v; conserved if only internal forces act.";
            vec![
                curve("p along x", AXES[0], hint, |s| s.momentum.x),
                curve("p along y", AXES[1], hint, |s| s.momentum.y),
                curve("p along z", AXES[2], hint, |s| s.momentum.z),
                curve("Magnitude", TOTAL, "Length of the three as a vector.", |s| {
                    s.momentum.length()
                }),
            ]
        }
        Plotted::AngularMomentum => {
            let hint = "Σ m x × v about the origin; conserved if only internal forces act.";
            vec![
                curve("L about x", AXES[0], hint, |s| s.angular_momentum.x),
                curve("L about y", AXES[1], hint, |s| s.angular_momentum.y),
                curve("L about z", AXES[2], hint, |s| s.angular_momentum.z),
                curve("Magnitude", TOTAL, "Length of the three as a vector.", |s| {
                    s.angular_momentum.length()
                }),
            ]
        }
        Plotted::Error => {
            let hint = "Largest residual of a hard constraint at the end of the tick.";
            vec![curve("Largest error", WARN, hint, |s| f64::from(s.error) * 1e3)]
        }
        Plotted::Strain => {
            let hint = "Largest residual of a hard distance, relative to its length.";
            vec![curve("Largest strain", WARN, hint, |s| f64::from(s.strain) * 1e2)]
        }
        Plotted::Time if by_phase => {
            let phase = |i: usize, name, hint, read| curve(name, SERIES[i], hint, read);
            vec![
                phase(
                    0,
                    "Forces",
                    "Gravity, springs, and forces of the game.",
                    |s| ms(s.phases[0]),
                ),
                phase(1, "Wind", "Wind pressure, and drag and lift of air flows.", |s| {
                    ms(s.phases[1])
                }),
                phase(2, "Buoyancy", "Fluids.", |s| ms(s.phases[2])),
                phase(3, "Electric", "Charges and fields.", |s| ms(s.phases[3])),
                phase(4, "Integrate", "Prediction of the next positions.", |s| ms(s.phases[4])),
                phase(5, "Constraints", "Sweeps, contacts, velocities.", |s| ms(s.phases[5])),
            ]
        }
        Plotted::Time => {
            let hint = "Building bodies, and copying components into the solver.";
            vec![
                curve("Gather", SERIES[0], hint, |s| ms(s.parts[0])),
                curve("Substeps", SERIES[5], "All phases of all substeps.", |s| ms(s.parts[1])),
                curve(
                    "Scatter",
                    SERIES[4],
                    "Copying results back into components, and computing poses.",
                    |s| ms(s.parts[2]),
                ),
                curve("Tick", TOTAL, "Sum of the three.", |s| ms(s.parts.iter().sum())),
            ]
        }
    }
}

fn ms(seconds: f32) -> f64 {
    f64::from(seconds) * 1e3
}

/// A number with two decimals, or with three where it is small.
fn readable(number: f64, is_prefixed: bool) -> String {
    if is_prefixed || number.abs() >= 10.0 {
        // No minus sign where the number is written as zero.
        return format!("{:.2}", if number.abs() < 0.005 { 0.0 } else { number });
    }
    format!("{:.3}", if number.abs() < 0.0005 { 0.0 } else { number })
}

fn draw(ui: &mut Ui, history: &PlotHistory, curves: &[Curve], unit: Unit) {
    let now = history.last().map_or(0.0, |latest| latest.seconds);
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    let lines: Vec<_> = curves
        .iter()
        .map(|curve| {
            let points: PlotPoints = history
                .thinned(POINTS)
                .map(|sample| {
                    let y = (curve.read)(sample);
                    (low, high) = (low.min(y), high.max(y));
                    [sample.seconds - now, y]
                })
                .collect();
            Line::new(curve.name, points).color(curve.color).width(1.5)
        })
        .collect();
    let (low, high) = (-round_up(-low), round_up(high));
    let high = if high > low { high } else { 1.0 };
    let (scale, written) = unit.of(high.max(-low));

    let font = FontId { size: 10.0, ..TextStyle::Monospace.resolve(ui.style()) };
    let weak = ui.visuals().weak_text_color();
    let axis =
        |hints: AxisHints<'static>| hints.tick_label_font(font.clone()).tick_label_color(weak);
    // Labels at the ends would run into those of the other axis and over the edge.
    let inside = |x: f64| x > -PlotHistory::SPAN && x < 0.0;
    let across = axis(AxisHints::new_x()).formatter(move |mark, _| {
        if inside(mark.value) { format!("{:.0} s", mark.value) } else { String::new() }
    });
    // A long unit would take half of the width, so it is written above the axis.
    let is_wide = written.chars().count() > 3;
    let shown = if is_wide { String::new() } else { format!(" {written}") };
    let up = axis(AxisHints::new_y().min_thickness(46.0))
        .formatter(move |mark, _| tick_label(&mark, scale, &shown));
    if is_wide {
        ui.label(bevy_egui::egui::RichText::new(&written).font(font.clone()).color(weak));
    }
    Plot::new("sinew_plot")
        .height(132.0)
        .custom_x_axes(vec![across.label_spacing(24.0..=40.0)])
        .custom_y_axes(vec![up])
        .x_grid_spacer(uniform_grid_spacer(|_| [20.0, 10.0, 2.0]))
        .grid_color(weak.gamma_multiply(0.4))
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .label_formatter(move |hover| match hover {
            HoverPosition::NearDataPoint { plot_name, position, .. } => {
                let (scale, unit) = unit.of(position.y);
                let y = position.y / scale;
                Some(format!("{plot_name}\n{y:.2} {unit} at {:.2} s", position.x))
            }
            HoverPosition::Elsewhere { .. } => None,
        })
        .show(ui, |plot| {
            plot.set_plot_bounds_x(-PlotHistory::SPAN..=0.0);
            plot.set_plot_bounds_y(low..=high);
            // The sum is drawn under its parts.
            for line in lines.into_iter().rev() {
                plot.line(line);
            }
        });
}

fn tick_label(mark: &GridMark, scale: f64, unit: &str) -> String {
    let step = mark.step_size / scale;
    // As many decimals as are needed to tell two marks apart.
    let decimals = if step < 1.0 { (-step.log10()).ceil().clamp(0.0, 4.0) as usize } else { 0 };
    format!("{:.decimals$}{unit}", mark.value / scale)
}

/// The next larger number that an axis may end at. There are few of them, so that the axis does not move with the curves.
fn round_up(x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return 0.0;
    }
    let decade = 10_f64.powf(x.log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];
    steps.into_iter().map(|step| step * decade).find(|&end| end >= x).unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_ends_at_a_round_number() {
        for (x, end) in
            [(0.0, 0.0), (-3.0, 0.0), (1.0, 1.0), (1.2, 1.5), (73.0, 80.0), (97.0, 100.0)]
        {
            assert_eq!(round_up(x), end, "{x}");
        }
        assert_eq!(round_up(f64::NAN), 0.0);
    }

    #[test]
    fn what_is_zero_when_it_is_written_has_no_minus() {
        assert_eq!(readable(-1e-5, false), "0.000");
        assert_eq!(readable(-1e-3, true), "0.00");
        assert_eq!(readable(-12.345, false), "-12.35");
        assert_eq!(readable(0.1234, false), "0.123");
    }
}
