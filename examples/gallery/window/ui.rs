//! The panel on the left: the list of scenes, and below it the controls of the simulation.

use bevy::camera::Viewport;
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::{EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, egui};

use super::Programme;

pub(super) fn add(app: &mut App) {
    let _ = app;
}
