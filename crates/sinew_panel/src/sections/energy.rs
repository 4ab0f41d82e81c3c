//! The energies of the last seconds.

use bevy_egui::egui::{FontId, TextStyle, Ui};
use egui_plot::{AxisHints, GridMark, HoverPosition, Line, Plot, PlotPoints, uniform_grid_spacer};

use crate::history::{EnergyHistory, EnergySample};
use crate::style::{GRAVITATIONAL, KINETIC, STORED, TOTAL};
use crate::widgets::{colored_value, prefix};

/// The most points in a curve that is drawn 220 points wide, give or take a factor of two.
const POINTS: usize = 300;

/// Only reads.
pub(crate) fn energy(ui: &mut Ui, history: &EnergyHistory) {
    let latest = history.last().copied().unwrap_or_default();
    let springs = history.iter().any(|sample| sample.stored != 0.0);
    let mut curves = vec![
        (
            "Kinetic",
            KINETIC,
            EnergySample::kinetic as fn(&EnergySample) -> f64,
            "Energy of motion: ½mv² of every particle.",
        ),
        (
            "Gravitational",
            GRAVITATIONAL,
            EnergySample::gravitational,
            "Energy of height, zero at the world's origin.",
        ),
    ];
    if springs {
        let hint = "Energy in springs and between charges.";
        curves.push(("Stored", STORED, EnergySample::stored, hint));
    }
    let hint = "Sum of them: what drag, friction and pins take, and winds give.";
    curves.push(("Total", TOTAL, EnergySample::total, hint));

    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    let lines: Vec<_> = curves
        .iter()
        .map(|&(name, color, read, _)| {
            let points: PlotPoints = history
                .thinned(POINTS)
                .map(|sample| {
                    let energy = read(sample);
                    (low, high) = (low.min(energy), high.max(energy));
                    [sample.seconds - latest.seconds, energy]
                })
                .collect();
            Line::new(name, points).color(color).width(1.5)
        })
        .collect();
    let (low, high) = (-round_up(-low), round_up(high));
    let high = if high > low { high } else { 1.0 };
    let (scale, unit) = prefix(high.max(-low));

    let font = FontId { size: 10.0, ..TextStyle::Monospace.resolve(ui.style()) };
    let weak = ui.visuals().weak_text_color();
    let axis =
        |hints: AxisHints<'static>| hints.tick_label_font(font.clone()).tick_label_color(weak);
    // Labels at the ends would run into those of the other axis and over the edge.
    let inside = |x: f64| x > -EnergyHistory::SPAN && x < 0.0;
    let across = axis(AxisHints::new_x()).formatter(move |mark, _| {
        if inside(mark.value) { format!("{:.0} s", mark.value) } else { String::new() }
    });
    let up = axis(AxisHints::new_y().min_thickness(46.0))
        .formatter(move |mark, _| tick_label(&mark, scale, unit));
    Plot::new("sinew_energy")
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
        .label_formatter(|hover| match hover {
            HoverPosition::NearDataPoint { plot_name, position, .. } => {
                let (scale, unit) = prefix(position.y);
                let energy = position.y / scale;
                Some(format!("{plot_name}\n{energy:.2} {unit}J at {:.2} s", position.x))
            }
            HoverPosition::Elsewhere { .. } => None,
        })
        .show(ui, |plot| {
            plot.set_plot_bounds_x(-EnergyHistory::SPAN..=0.0);
            plot.set_plot_bounds_y(low..=high);
            // The total lies under its parts.
            for line in lines.into_iter().rev() {
                plot.line(line);
            }
        });
    for (name, color, read, hint) in curves {
        let energy = read(&latest);
        let (scale, unit) = prefix(energy);
        let number = format!("{:.2}", energy / scale);
        colored_value(ui, Some(color), name, hint, &number, &format!("{unit}J"), None);
    }
}

impl EnergySample {
    fn kinetic(&self) -> f64 {
        self.kinetic
    }

    fn gravitational(&self) -> f64 {
        self.gravitational
    }

    fn stored(&self) -> f64 {
        self.stored
    }
}

fn tick_label(mark: &GridMark, scale: f64, unit: &str) -> String {
    let step = mark.step_size / scale;
    let decimals = if step < 0.1 {
        2
    } else if step < 1.0 {
        1
    } else {
        0
    };
    format!("{:.decimals$} {unit}J", mark.value / scale)
}

/// The next number up that an axis may end at: few of them, so that the axis stands still while the curves move.
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
}
