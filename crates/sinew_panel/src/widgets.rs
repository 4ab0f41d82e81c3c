//! Building blocks of the sections: a foldable header, a row with a label column, a number with its unit.

use bevy_egui::egui::collapsing_header::CollapsingState;
use bevy_egui::egui::emath::Numeric;
use bevy_egui::egui::{
    self, Align, Align2, Color32, Label, Layout, Response, Sense, Slider, Stroke, TextStyle, Ui,
    UiBuilder, vec2,
};

/// Width of the column of labels, points.
const LABEL: f32 = 84.0;
/// Width of the number beside a slider, points: enough for ten characters, as otherwise it grows and pushes the edge of everything below.
const VALUE: f32 = 84.0;
/// Width of the button that resets a number, points.
const RESET: f32 = 16.0;
/// Width of the column of units, points.
const UNIT: f32 = 30.0;
/// The most characters of a unit that fit into that column.
const UNIT_LETTERS: usize = 3;

/// A section under a header that folds it. Returns whether it is open.
pub(crate) fn section(ui: &mut Ui, title: &str, body: impl FnOnce(&mut Ui)) -> bool {
    let id = ui.make_persistent_id(("sinew_section", title));
    let mut state = CollapsingState::load_with_default_open(ui.ctx(), id, true);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::click());
    if response.clicked() {
        state.toggle(ui);
    }
    let visuals = ui.visuals();
    let color = if response.hovered() { visuals.text_color() } else { visuals.weak_text_color() };
    let painter = ui.painter();
    painter.hline(rect.x_range(), rect.top(), visuals.widgets.noninteractive.bg_stroke);
    let font = TextStyle::Body.resolve(ui.style());
    let strong = visuals.strong_text_color();
    painter.text(rect.left_center(), Align2::LEFT_CENTER, title, font, strong);
    // A chevron that points right when closed and down when open.
    let centre = rect.right_center() - vec2(6.0, 0.0);
    let turn =
        egui::emath::Rot2::from_angle(state.openness(ui.ctx()) * std::f32::consts::FRAC_PI_2);
    let corners = [vec2(-2.0, -4.0), vec2(2.0, 0.0), vec2(-2.0, 4.0)];
    painter.line(corners.map(|c| centre + turn * c).to_vec(), Stroke::new(1.5, color));

    state.show_body_unindented(ui, |ui| {
        ui.set_width(ui.available_width());
        body(ui);
        ui.add_space(6.0);
    });
    state.is_open()
}

/// A row: a label in its column, then what `add` draws to its right. The label has a tooltip.
pub(crate) fn row<R>(ui: &mut Ui, label: &str, hint: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let size = vec2(LABEL, ui.spacing().interact_size.y);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let layout = Layout::left_to_right(Align::Center);
        ui.new_child(UiBuilder::new().max_rect(rect).layout(layout))
            .add(Label::new(label).truncate().selectable(false));
        response.on_hover_text(hint);
        add(ui)
    })
    .inner
}

/// A row with a slider that fills it, and its number in a column of fixed width. Returns whether the user moved it.
///
/// A value outside the slider's range stays as it is until then: drawing the panel must not change the world.
pub(crate) fn slider(ui: &mut Ui, label: &str, hint: &str, slider: Slider<'_>) -> bool {
    row(ui, label, hint, |ui| rail(ui, hint, slider, 0.0))
}

/// Like [`slider`], with a button that resets the number to its default, visible where the number differs from it.
pub(crate) fn number<N: Numeric>(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    number: &mut N,
    default: N,
    make: impl FnOnce(&mut N) -> Slider<'_>,
) -> bool {
    row(ui, label, hint, |ui| {
        let space = RESET + ui.spacing().item_spacing.x;
        let changed = rail(ui, hint, make(number), space);
        let name = format!("the default, {}", default.to_f64());
        let reset = reset(ui, *number != default, &name);
        if reset {
            *number = default;
        }
        changed || reset
    })
}

fn rail(ui: &mut Ui, hint: &str, slider: Slider<'_>, space: f32) -> bool {
    let rail = ui.available_width() - VALUE - ui.spacing().item_spacing.x - space;
    ui.spacing_mut().slider_width = rail.max(24.0);
    ui.spacing_mut().interact_size.x = VALUE;
    let response = ui.add(slider.clamping(egui::SliderClamping::Edits));
    response.on_hover_text(hint).changed()
}

/// A small button that resets the value to its left. Its space is reserved where there is nothing to reset, so that the layout does not move.
fn reset(ui: &mut Ui, differs: bool, to: &str) -> bool {
    let size = vec2(RESET, ui.spacing().interact_size.y);
    if !differs {
        ui.allocate_exact_size(size, Sense::hover());
        return false;
    }
    let button = egui::Button::new("⟲").min_size(size).small().frame(false);
    ui.add_sized(size, button).on_hover_text(format!("Reset to {to}.")).clicked()
}

/// A row with one draggable number for each axis, and a button that resets them to their defaults. Returns whether the user changed one.
pub(crate) fn vector(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    axes: [&mut f32; 3],
    default: [f32; 3],
    speed: f64,
) -> bool {
    row(ui, label, hint, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = ((ui.available_width() - RESET - 12.0) / 3.0).floor();
        ui.spacing_mut().interact_size.x = width.max(24.0);
        let mut changed = false;
        let [x, y, z] = axes;
        for (axis, name) in [&mut *x, &mut *y, &mut *z].into_iter().zip(["x", "y", "z"]) {
            let drag = egui::DragValue::new(axis).speed(speed).fixed_decimals(2);
            changed |= ui.add(drag).on_hover_text(format!("{name}: {hint}")).changed();
        }
        let [a, b, c] = default;
        if reset(ui, [*x, *y, *z] != default, &format!("{a}, {b}, {c}")) {
            (*x, *y, *z) = (a, b, c);
            changed = true;
        }
        changed
    })
}

/// A row with a read-only number: right-aligned, with its unit in a column of its own, so that nothing moves as it changes.
pub(crate) fn value(ui: &mut Ui, label: &str, hint: &str, number: &str, unit: &str) {
    colored_value(ui, None, label, hint, number, unit, None);
}

/// A row with a read-only vector, each component in three significant digits, and the unit behind the label.
pub(crate) fn vector_value(
    ui: &mut Ui,
    label: &str,
    unit: &str,
    hint: &str,
    vector: bevy::math::Vec3,
) {
    let (rect, response) = readout_space(ui);
    let visuals = ui.visuals();
    let body = TextStyle::Body.resolve(ui.style());
    let small = TextStyle::Small.resolve(ui.style());
    let mono = TextStyle::Monospace.resolve(ui.style());
    let (text, weak, strong) =
        (visuals.text_color(), visuals.weak_text_color(), visuals.strong_text_color());
    let painter = ui.painter();
    let written = painter.text(rect.left_center(), Align2::LEFT_CENTER, label, body, text);
    let place = written.right_center() + vec2(6.0, 0.0);
    painter.text(place, Align2::LEFT_CENTER, unit, small, weak);
    let numbers = vector.to_array().map(|x| format!("{:>7}", short(x.into()))).concat();
    painter.text(rect.right_center(), Align2::RIGHT_CENTER, numbers, mono, strong);
    response.on_hover_text(hint);
}

/// A number in three significant digits, with at most two decimals.
pub(crate) fn short(number: f64) -> String {
    match number.abs() {
        size if size >= 99_999.5 => format!("{number:.0e}"),
        size if size >= 99.95 => format!("{number:.0}"),
        size if size >= 9.995 => format!("{number:.1}"),
        // No minus sign where the number is written as zero.
        size if size < 0.005 => "0.00".into(),
        _ => format!("{number:.2}"),
    }
}

/// Like [`value`], with a coloured dot before the label and a colour for the number. A unit that is too wide for its column is written behind the label.
pub(crate) fn colored_value(
    ui: &mut Ui,
    dot: Option<Color32>,
    label: &str,
    hint: &str,
    number: &str,
    unit: &str,
    color: Option<Color32>,
) {
    let (rect, response) = readout_space(ui);
    let visuals = ui.visuals();
    let body = TextStyle::Body.resolve(ui.style());
    let mono = TextStyle::Monospace.resolve(ui.style());
    let painter = ui.painter();
    let mut left = rect.left_center();
    if let Some(dot) = dot {
        painter.circle_filled(left + vec2(4.0, 0.0), 3.5, dot);
        left.x += 14.0;
    }
    let written = painter.text(left, Align2::LEFT_CENTER, label, body, visuals.text_color());
    let weak = visuals.weak_text_color();
    let edge = rect.right_center() - vec2(UNIT, 0.0);
    let strong = color.unwrap_or_else(|| visuals.strong_text_color());
    painter.text(edge, Align2::RIGHT_CENTER, number, mono.clone(), strong);
    if unit.chars().count() > UNIT_LETTERS {
        let place = written.right_center() + vec2(6.0, 0.0);
        painter.text(place, Align2::LEFT_CENTER, unit, TextStyle::Small.resolve(ui.style()), weak);
    } else {
        painter.text(edge + vec2(6.0, 0.0), Align2::LEFT_CENTER, unit, mono, weak);
    }
    response.on_hover_text(hint);
}

fn readout_space(ui: &mut Ui) -> (egui::Rect, Response) {
    // Rows are closer together than those with something to click.
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y - 3.0);
    ui.allocate_exact_size(size, Sense::hover())
}

/// An integer with a space between groups of three digits.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// The factor and the SI prefix that leave one to three digits before the decimal point.
pub(crate) fn prefix(size: f64) -> (f64, &'static str) {
    match size.abs() {
        x if x >= 1e9 => (1e9, "G"),
        x if x >= 1e6 => (1e6, "M"),
        x if x >= 1e3 => (1e3, "k"),
        x if x >= 1.0 || x == 0.0 => (1.0, ""),
        x if x >= 1e-3 => (1e-3, "m"),
        x if x >= 1e-6 => (1e-6, "µ"),
        // Too small to show any digit.
        _ => (1.0, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_000), "1 000");
        assert_eq!(grouped(65_536), "65 536");
        assert_eq!(grouped(1_234_567), "1 234 567");
    }

    #[test]
    fn a_short_number_has_at_most_six_characters() {
        for (number, text) in [
            (0.0, "0.00"),
            (-0.001, "0.00"),
            (9.996, "10.0"),
            (-12.345, "-12.3"),
            (99.96, "100"),
            (-99_999.0, "-99999"),
            (1.0e7, "1e7"),
        ] {
            assert_eq!(short(number), text);
            assert!(text.len() <= 6);
        }
    }

    #[test]
    fn prefixes_leave_three_digits() {
        for (size, name) in [
            (0.0, ""),
            (12.0, ""),
            (-4.5e3, "k"),
            (2e6, "M"),
            (0.02, "m"),
            (5e-6, "µ"),
            (1e-12, ""),
        ] {
            assert_eq!(prefix(size).1, name, "{size}");
        }
    }
}
