//! The tools as buttons, each with its key.

use bevy::prelude::KeyCode;
use bevy_egui::egui::{Button, Grid, Label, RichText, Ui, vec2};
use sinew_panel::DOCK_WIDTH;

use super::{TOOLS, Tools};

/// Buttons in a row.
const COLUMNS: usize = 3;

/// Draws the buttons. A clicked tool stays armed until it is clicked again, another one is clicked, or Escape is pressed.
pub(in crate::window) fn bar(ui: &mut Ui, tools: &mut Tools) {
    Grid::new("tools").num_columns(COLUMNS).spacing([4.0, 2.0]).show(ui, |ui| {
        let gaps = 4.0 * (COLUMNS - 1) as f32;
        let width = ((DOCK_WIDTH - 28.0 - gaps) / COLUMNS as f32).floor();
        for (i, (tool, key)) in TOOLS.into_iter().enumerate() {
            let text = format!("{} {}", tool.name(), short(key));
            let button =
                Button::new(text).selected(tools.armed == Some(tool)).min_size(vec2(width, 22.0));
            if ui.add(button).on_hover_text(tool.hint()).clicked() {
                if tool.is_immediate() {
                    tools.clicked = Some(tool);
                } else {
                    tools.armed = (tools.armed != Some(tool)).then_some(tool);
                }
            }
            if i % COLUMNS == COLUMNS - 1 {
                ui.end_row();
            }
        }
    });
    let hint = match tools.armed {
        None => "Keys act at the pointer; a button selects a tool for clicks.".to_owned(),
        Some(tool) => format!("{}: click in the view. Escape deselects the tool.", tool.name()),
    };
    ui.label(RichText::new(hint).weak().small());
    // Always drawn, so that nothing below moves.
    let message =
        if tools.message.is_empty() { "The pointer drags bodies." } else { &tools.message };
    ui.add(Label::new(RichText::new(message).small()).truncate());
    ui.add_space(6.0);
}

/// Name of a key on a button.
fn short(key: KeyCode) -> String {
    let name = format!("{key:?}").replace("Delete", "Del");
    name.trim_start_matches("Key").trim_start_matches("Digit").to_owned()
}
