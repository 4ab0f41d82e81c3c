//! The Settings section: saving and loading the panel's settings.

use std::path::Path;

use bevy::prelude::*;
use bevy_egui::egui::{Button, Label, RichText, TextEdit, Ui, vec2};

use crate::params::PanelParams;
use crate::settings::PanelSettings;
use crate::style::{GOOD, WARN};

/// Writes a file, or everything in [`PanelSettings`].
pub(crate) fn files(ui: &mut Ui, panel: &mut PanelParams) {
    let path = &mut panel.state.settings_path;
    let hint = "File of the solver's settings, gravity, air, charges, speed and recording.";
    ui.add(TextEdit::singleline(path).desired_width(f32::INFINITY)).on_hover_text(hint);
    ui.horizontal(|ui| {
        let width = (ui.available_width() - ui.spacing().item_spacing.x) / 2.0;
        let size = vec2(width, 22.0);
        let save = Button::new("Save settings").min_size(size);
        if ui.add(save).on_hover_text("Writes the file.").clicked() {
            let path = panel.state.settings_path.clone();
            let saved = panel.settings().save(Path::new(&path));
            panel.state.settings_said = Some(match saved {
                Ok(()) => Ok(format!("Saved {path}.")),
                Err(fault) => Err(format!("Not saved: {fault}.")),
            });
        }
        let load = Button::new("Load settings").min_size(size);
        let hint = "Reads the file. A malformed or foreign file changes nothing.";
        if ui.add(load).on_hover_text(hint).clicked() {
            let path = panel.state.settings_path.clone();
            panel.state.settings_said = Some(match PanelSettings::load(Path::new(&path)) {
                Ok(settings) => {
                    panel.apply(&settings);
                    Ok(format!("Loaded {path}."))
                }
                Err(fault) => Err(format!("Not loaded, nothing has changed: {fault}.")),
            });
        }
    });
    if let Some(said) = &panel.state.settings_said {
        let (text, color) = match said {
            Ok(text) => (text, GOOD),
            Err(text) => (text, WARN),
        };
        ui.add(Label::new(RichText::new(text).color(color).small()).wrap());
    }
}

impl PanelParams<'_, '_> {
    /// The present settings.
    pub fn settings(&self) -> PanelSettings {
        PanelSettings {
            solver: *self.config,
            gravity: self.gravity.0.to_array(),
            air_drag: self.air.0,
            electric_constant: self.electric.constant,
            electric_softening: self.electric.softening,
            speed: self.control.relative_speed,
            recording: *self.recording_config,
        }
    }

    /// Applies settings. Those that are equal already are not marked as changed.
    pub fn apply(&mut self, settings: &PanelSettings) {
        self.config.set_if_neq(settings.solver);
        self.gravity.set_if_neq(bevy_sinew::Gravity(Vec3::from_array(settings.gravity)));
        self.air.set_if_neq(bevy_sinew::AirDrag(settings.air_drag));
        let electric = bevy_sinew::Electric {
            constant: settings.electric_constant,
            softening: settings.electric_softening,
            ..*self.electric
        };
        self.electric.set_if_neq(electric);
        let control = bevy_sinew::SinewControl { relative_speed: settings.speed, ..*self.control };
        self.control.set_if_neq(control);
        self.recording_config.set_if_neq(settings.recording);
    }
}
