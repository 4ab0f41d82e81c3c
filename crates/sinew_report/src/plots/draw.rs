//! Draws a [`Plot`] with `plotters`. Its lines are not antialiased, so the plot is drawn three times as large and each pixel is the mean of nine.

use std::sync::OnceLock;

use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use super::{Curve, Plot, Stroke};

/// Size of a plot, pixels.
const SIZE: [u32; 2] = [1080, 660];

/// Factor of supersampling.
const FINE: u32 = 3;

/// Colours of the curves in order, distinguishable with most kinds of colour blindness (Okabe and Ito, 2008).
const COLOURS: [RGBColor; 5] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(90, 90, 90),
];

/// Colour of axes and text.
const INK: RGBColor = RGBColor(40, 40, 40);

/// Draws a plot and encodes it as PNG.
pub(super) fn png(plot: &Plot) -> Result<Vec<u8>, String> {
    load_font()?;
    let [width, height] = SIZE.map(|side| side * FINE);
    let mut large = vec![255; (width * height * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut large, (width, height)).into_drawing_area();
        draw(plot, &area).map_err(|error| format!("{}: {error}", plot.name))?;
        area.present().map_err(|error| format!("{}: {error}", plot.name))?;
    }
    encode(&shrink(&large)).map_err(|error| format!("{}: {error}", plot.name))
}

/// Registers a font with plotters, which has none of its own: the one that the panel (egui) depends on anyway.
fn load_font() -> Result<(), String> {
    static LOADED: OnceLock<bool> = OnceLock::new();
    let load = || {
        register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok()
    };
    if *LOADED.get_or_init(load) { Ok(()) } else { Err("the font cannot be read".into()) }
}

type Area<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;
type Fault<'a> = DrawingAreaErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>;

fn draw<'a>(plot: &Plot, area: &Area<'a>) -> Result<(), Fault<'a>> {
    let px = |pixels: u32| pixels * FINE;
    let words = |pixels: u32| ("sans-serif", px(pixels)).into_font().color(&INK);
    area.fill(&WHITE)?;
    let ends = |pick: fn(f64, f64) -> f64, from| {
        plot.curves.iter().flat_map(|c| &c.points).map(|p| p[0]).fold(from, pick)
    };
    let (left, right) = (ends(f64::min, f64::INFINITY), ends(f64::max, f64::NEG_INFINITY));
    let [low, high] = plot.height;
    let mut chart = ChartBuilder::on(area)
        .margin(px(18))
        .caption(plot.title, words(24))
        .x_label_area_size(px(48))
        .y_label_area_size(px(72))
        .build_cartesian_2d(left..right, low..high)?;
    chart
        .configure_mesh()
        .x_desc(plot.axes[0])
        .y_desc(plot.axes[1])
        .axis_desc_style(words(18))
        .label_style(words(16))
        .set_all_tick_mark_size(px(6))
        .axis_style(INK.stroke_width(FINE))
        .bold_line_style(RGBColor(215, 215, 215).stroke_width(FINE))
        .light_line_style(WHITE)
        .x_label_formatter(&|x| label(*x))
        .y_label_formatter(&|y| label(*y))
        .draw()?;
    let mut number = 0;
    for curve in &plot.curves {
        let colour = COLOURS[number % COLOURS.len()];
        // A curve without a name belongs to the next one and has its colour.
        number += usize::from(!curve.name.is_empty());
        let Curve { stroke, points, name } = curve;
        let pale = colour.mix(0.3).stroke_width(px(8));
        let dark = colour.stroke_width(px(2));
        let drawn = match stroke {
            Stroke::Line | Stroke::Band => {
                let style = if *stroke == Stroke::Line { dark } else { pale };
                chart.draw_series(
                    runs(points, plot.height).map(|run| PathElement::new(run, style)),
                )?
            }
            Stroke::Dots => {
                let inside = points.iter().filter(|p| (low..=high).contains(&p[1]));
                chart.draw_series(
                    inside.map(|p| Circle::new((p[0], p[1]), px(4), colour.filled())),
                )?
            }
        };
        if !name.is_empty() {
            let stroke = *stroke;
            let sample = px(26) as i32;
            drawn.label(name.as_str()).legend(move |(x, y)| match stroke {
                Stroke::Line => PathElement::new([(x, y), (x + sample, y)], dark).into_dyn(),
                Stroke::Band => PathElement::new([(x, y), (x + sample, y)], pale).into_dyn(),
                Stroke::Dots => Circle::new((x + sample / 2, y), px(4), colour.filled()).into_dyn(),
            });
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .margin(px(12))
        .legend_area_size(px(36))
        .label_font(words(16))
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(190, 190, 190).stroke_width(FINE))
        .draw()?;
    Ok(())
}

/// The parts of a curve that lie within `low..=high`, each clipped at the edge: plotters would draw what is beyond along the edge.
fn runs(points: &[[f64; 2]], [low, high]: [f64; 2]) -> impl Iterator<Item = Vec<(f64, f64)>> {
    let inside = |p: &[f64; 2]| (low..=high).contains(&p[1]);
    let mut runs: Vec<Vec<(f64, f64)>> = Vec::new();
    for (i, p) in points.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| points[i]);
        let crossing = |q: [f64; 2]| {
            let edge = if p[1].max(q[1]) > high { high } else { low };
            let share = (edge - q[1]) / (p[1] - q[1]);
            (q[0] + share * (p[0] - q[0]), edge)
        };
        match (inside(p), before.filter(&inside).is_some()) {
            (true, true) => {}
            (true, false) => runs.push(before.map(crossing).into_iter().collect()),
            (false, true) => {
                if let (Some(run), Some(q)) = (runs.last_mut(), before) {
                    run.push(crossing(q));
                }
            }
            (false, false) => {}
        }
        if let (true, Some(run)) = (inside(p), runs.last_mut()) {
            run.push((p[0], p[1]));
        }
    }
    runs.into_iter()
}

/// A number at an axis: with as many decimals as it needs, at most three.
fn label(x: f64) -> String {
    let text = format!("{x:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    // U+2212, the minus sign, which is as wide as the digits.
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// Averages blocks of `FINE × FINE` pixels.
fn shrink(large: &[u8]) -> Vec<u8> {
    let ([width, height], fine) = (SIZE.map(|side| side as usize), FINE as usize);
    let mut small = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let mut sum = 0;
                for dy in 0..fine {
                    let row = (y * fine + dy) * width * fine;
                    for dx in 0..fine {
                        sum += usize::from(large[(row + x * fine + dx) * 3 + channel]);
                    }
                }
                small.push((sum / (fine * fine)) as u8);
            }
        }
    }
    small
}

fn encode(pixels: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_cut_off_where_it_leaves_the_picture() {
        let points = [[0.0, 0.5], [1.0, 1.5], [2.0, 1.5], [3.0, 0.5], [4.0, -0.5]];
        let parts: Vec<_> = runs(&points, [0.0, 1.0]).collect();
        assert_eq!(parts, [vec![(0.0, 0.5), (0.5, 1.0)], vec![(2.5, 1.0), (3.0, 0.5), (3.5, 0.0)]]);
    }

    #[test]
    fn numbers_at_an_axis_are_as_long_as_they_must() {
        for (x, text) in
            [(0.0, "0"), (-0.0001, "0"), (-2.5, "−2.5"), (10.0, "10"), (0.125, "0.125")]
        {
            assert_eq!(label(x), text);
        }
    }
}
