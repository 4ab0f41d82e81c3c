//! The style of the panel: a dark theme, one accent colour, numbers in a monospaced font.

use bevy_egui::egui::{self, Color32, CornerRadius, FontFamily, FontId, Stroke, TextStyle};

/// Good values: converged, within tolerance.
pub(crate) const GOOD: Color32 = Color32::from_rgb(116, 190, 140);
/// Values that need attention.
pub(crate) const WARN: Color32 = Color32::from_rgb(230, 169, 90);
/// Kinetic energy in the plot, and the accent of everything else.
pub(crate) const KINETIC: Color32 = Color32::from_rgb(92, 168, 230);
/// Gravitational energy in the plot.
pub(crate) const GRAVITATIONAL: Color32 = Color32::from_rgb(222, 152, 96);
/// Energy of springs and between charges in the plot.
pub(crate) const STORED: Color32 = Color32::from_rgb(150, 134, 214);
/// Sum of all energies in the plot.
pub(crate) const TOTAL: Color32 = Color32::from_rgb(226, 230, 236);

/// Components along x, y and z in the plots: red, green and blue, the usual colours of axes.
pub(crate) const AXES: [Color32; 3] = [
    Color32::from_rgb(226, 106, 98),
    Color32::from_rgb(122, 194, 116),
    Color32::from_rgb(92, 152, 236),
];
/// Parts of a tick and phases of a substep in the plots.
pub(crate) const SERIES: [Color32; 6] = [
    Color32::from_rgb(222, 152, 96),
    Color32::from_rgb(116, 190, 140),
    Color32::from_rgb(84, 190, 196),
    Color32::from_rgb(226, 200, 92),
    Color32::from_rgb(150, 134, 214),
    Color32::from_rgb(92, 168, 230),
];

const PANEL: Color32 = Color32::from_rgb(24, 26, 31);
const WELL: Color32 = Color32::from_rgb(17, 19, 23);
const HAIRLINE: Color32 = Color32::from_rgb(44, 48, 56);
const WIDGET: Color32 = Color32::from_rgb(44, 49, 58);
const HOVERED: Color32 = Color32::from_rgb(57, 64, 76);
const PRESSED: Color32 = Color32::from_rgb(66, 78, 96);
const FILL: Color32 = Color32::from_rgb(50, 96, 140);
const TEXT: Color32 = Color32::from_rgb(172, 179, 190);
const STRONG: Color32 = Color32::from_rgb(230, 233, 238);
const WEAK: Color32 = Color32::from_rgb(118, 126, 139);

/// Applies the panel's style to a whole egui context: for an app that embeds the panel and has no style of its own.
///
/// Call it once or in every frame. The panel of [`PanelMode::Docked`](crate::PanelMode::Docked) uses this style by itself and leaves the context's style as it
/// is.
pub fn style(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.style_mut_of(egui::Theme::Dark, apply_style);
}

/// Changes a style to the panel's.
pub(crate) fn apply_style(style: &mut egui::Style) {
    style.text_styles = [
        (TextStyle::Small, FontId::new(11.0, FontFamily::Proportional)),
        (TextStyle::Body, FontId::new(13.0, FontFamily::Proportional)),
        (TextStyle::Button, FontId::new(13.0, FontFamily::Proportional)),
        (TextStyle::Heading, FontId::new(16.0, FontFamily::Proportional)),
        (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
    ]
    .into();
    style.drag_value_text_style = TextStyle::Monospace;
    style.animation_time = 0.1;
    style.interaction.selectable_labels = false;

    let spacing = &mut style.spacing;
    spacing.item_spacing = egui::vec2(8.0, 4.0);
    spacing.button_padding = egui::vec2(6.0, 2.0);
    spacing.interact_size = egui::vec2(40.0, 20.0);
    spacing.slider_rail_height = 4.0;
    spacing.icon_width = 16.0;
    spacing.icon_width_inner = 10.0;
    spacing.icon_spacing = 8.0;
    spacing.tooltip_width = 260.0;

    let mut visuals = egui::Visuals::dark();
    visuals.panel_fill = PANEL;
    visuals.window_fill = PANEL;
    visuals.window_stroke = Stroke::new(1.0, HAIRLINE);
    visuals.extreme_bg_color = WELL;
    visuals.faint_bg_color = WELL;
    visuals.weak_text_color = Some(WEAK);
    visuals.hyperlink_color = KINETIC;
    visuals.warn_fg_color = WARN;
    visuals.selection.bg_fill = FILL;
    visuals.selection.stroke = Stroke::new(1.0, STRONG);
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = egui::style::HandleShape::Rect { aspect_ratio: 0.4 };
    visuals.indent_has_left_vline = false;

    let states = &mut visuals.widgets;
    for (state, fill, text) in [
        (&mut states.noninteractive, PANEL, TEXT),
        (&mut states.inactive, WIDGET, TEXT),
        (&mut states.hovered, HOVERED, STRONG),
        (&mut states.active, PRESSED, STRONG),
        (&mut states.open, WIDGET, STRONG),
    ] {
        state.bg_fill = fill;
        state.weak_bg_fill = fill;
        state.bg_stroke = Stroke::NONE;
        state.fg_stroke = Stroke::new(1.0, text);
        state.corner_radius = CornerRadius::same(4);
        state.expansion = 0.0;
    }
    states.noninteractive.bg_stroke = Stroke::new(1.0, HAIRLINE);
    style.visuals = visuals;
}
