//! A container for panels, docked to an edge of the screen.

use std::sync::Arc;

use bevy_egui::egui::{
    self, Area, Frame, Id, Margin, Order, Pos2, Rect, ScrollArea, Style, Ui, vec2,
};

/// The edge of the screen that a panel is docked to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PanelSide {
    /// The left edge.
    Left,
    /// The right edge.
    #[default]
    Right,
}

/// Width of a docked panel, points. A narrower screen is filled whole.
pub const DOCK_WIDTH: f32 = 300.0;

/// Draws into a panel of [`DOCK_WIDTH`] that fills one edge of the screen and scrolls if its content is taller.
///
/// It is an egui `Area`, not an `egui::Panel`: `bevy_egui` does not expose the root `Ui`, and egui does not count the pointer over a panel inside any other
/// `Ui` as its own, so a drag on the panel would also turn the game's camera.
pub fn dock<R>(ctx: &egui::Context, side: PanelSide, add: impl FnOnce(&mut Ui) -> R) -> R {
    dock_styled(ctx, side, None, add)
}

/// Like [`dock`], with a style that applies to this panel only.
pub(crate) fn dock_styled<R>(
    ctx: &egui::Context,
    side: PanelSide,
    style: Option<Arc<Style>>,
    add: impl FnOnce(&mut Ui) -> R,
) -> R {
    let screen = ctx.content_rect();
    let size = vec2(DOCK_WIDTH.min(screen.width()), screen.height());
    let left = match side {
        PanelSide::Left => screen.left(),
        PanelSide::Right => screen.right() - size.x,
    };
    let rect = Rect::from_min_size(Pos2::new(left, screen.top()), size);
    let area = Area::new(Id::new(("sinew_dock", side as u8)))
        .order(Order::Middle)
        .fixed_pos(rect.min)
        .constrain(false)
        .movable(false)
        .fade_in(false)
        .default_size(size);
    let response = area.show(ctx, |ui| {
        if let Some(style) = style {
            ui.set_style(style);
        }
        ui.set_clip_rect(rect);
        ui.set_min_size(size);
        ui.set_max_size(size);
        let visuals = ui.visuals();
        ui.painter().rect_filled(rect, 0.0, visuals.panel_fill);
        let edge = if side == PanelSide::Left { rect.right() - 0.5 } else { rect.left() + 0.5 };
        ui.painter().vline(edge, rect.y_range(), visuals.widgets.noninteractive.bg_stroke);
        ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                let margin = Margin { left: 14, right: 14, top: 10, bottom: 10 };
                Frame::new()
                    .inner_margin(margin)
                    .show(ui, |ui| {
                        ui.set_width(ui.available_width());
                        add(ui)
                    })
                    .inner
            })
            .inner
    });
    response.inner
}
