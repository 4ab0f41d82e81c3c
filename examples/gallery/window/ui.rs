//! The panel on the left: the list of scenes, and below it the controls of the simulation.

use bevy::camera::visibility::RenderLayers;
use bevy::camera::{CameraOutputMode, Viewport};
use bevy::prelude::*;
use bevy::render::render_resource::BlendState;
use bevy::window::PrimaryWindow;
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{
    EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext, egui,
};
use bevy_panorbit_camera::PanOrbitCamera;
use bevy_sinew::MouseDrag;
use sinew_panel::{
    DOCK_WIDTH, PanelKeys, PanelParams, PanelSide, SinewPanelPlugin, dock, show, style,
};
use sinew_scenes::{ALL, Heading, OnStage, Scene};

use super::SceneChoice;
use super::tools::{self, Tools};
use crate::thumbnails;

/// Adds the panel, the keys, and the camera that egui draws with.
pub(super) fn add(app: &mut App) {
    app.add_plugins((EguiPlugin::default(), SinewPanelPlugin::embedded()));
    // Egui would otherwise use the first camera and be confined to its viewport.
    app.world_mut().resource_mut::<EguiGlobalSettings>().auto_create_primary_context = false;
    app.insert_resource(PanelKeys {
        pause: Some(KeyCode::Space),
        back: Some(KeyCode::KeyB),
        step: Some(KeyCode::KeyN),
        half_step: Some(KeyCode::KeyH),
        ..default()
    });
    app.add_systems(Startup, spawn_camera)
        .add_systems(EguiPrimaryContextPass, draw)
        .add_systems(Update, (keys, leave_room, share_pointer));
}

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        PrimaryEguiContext,
        Camera2d,
        RenderLayers::none(),
        Camera {
            order: 1,
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::ALPHA_BLENDING),
                clear_color: ClearColorConfig::None,
            },
            clear_color: ClearColorConfig::Custom(Color::NONE),
            ..default()
        },
    ));
}

fn draw(
    mut contexts: EguiContexts,
    mut panel: PanelParams,
    mut choice: ResMut<SceneChoice>,
    stage: Option<Res<OnStage>>,
    mut tools: ResMut<Tools>,
    mut pictures: Local<Option<Pictures>>,
    mut last: Local<&'static str>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    let pictures = pictures.get_or_insert_with(|| {
        style(ctx);
        Pictures::load(ctx)
    });
    dock(ctx, PanelSide::Left, |ui| {
        ui.heading("Sinew");
        ui.add_space(2.0);
        let current = choice.current;
        ui.label(egui::RichText::new(current.about).weak());
        ui.add_space(6.0);
        if let Some(values) = stage.as_deref().and_then(|stage| lesson(ui, stage)) {
            choice.requested = Some(current);
            choice.values = Some(values);
        }
        if tools::is_on(stage.as_deref()) {
            tools::bar(ui, &mut tools);
        }
        // Sixty names do not fit on the screen: after a change of scene only the heading of the current one is open, until the user opens others.
        let changed = core::mem::replace(&mut *last, current.name) != current.name;
        for heading in Heading::ALL {
            let opens = changed.then_some(heading == current.heading);
            let title = egui::RichText::new(heading.title()).strong();
            let list = egui::CollapsingHeader::new(title).open(opens);
            let clicked = list
                .show_unindented(ui, |ui| scenes_of(ui, heading, current, pictures))
                .body_returned;
            if let Some(scene) = clicked.flatten() {
                choice.requested = Some(scene);
                choice.values = None;
            }
        }
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            if ui.button("Restart").on_hover_text("R").clicked() {
                choice.requested = Some(current);
            }
            let keys = egui::RichText::new("R restarts; arrows change the scene").weak().small();
            ui.add(egui::Label::new(keys).truncate());
        });
        let pointer =
            egui::RichText::new("Drag bodies; click to select, Escape to deselect.").weak().small();
        ui.add(egui::Label::new(pointer).truncate());
        ui.separator();
        show(ui, &mut panel);
    });
    Ok(())
}

/// The thumbnails of the scenes, on one texture.
struct Pictures {
    sheet: Option<egui::TextureHandle>,
}

impl Pictures {
    fn load(ctx: &egui::Context) -> Self {
        let sheet = thumbnails::sheet().map(|sheet| {
            let size = [sheet.width, sheet.height];
            let pixels =
                egui::ColorImage::from_rgba_unmultiplied(size, sheet.pixels.as_flattened());
            ctx.load_texture("thumbnails", pixels, egui::TextureOptions::LINEAR)
        });
        Self { sheet }
    }

    /// The thumbnail of a scene at a size in points; a grey tile for a scene without one.
    fn of(&self, scene: &Scene, size: egui::Vec2) -> egui::Image<'static> {
        let tile = self.sheet.as_ref().zip(thumbnails::place_of(scene.name));
        let image = match tile {
            Some((sheet, place)) => {
                let corner = |[x, y]: [usize; 2]| {
                    egui::pos2(x as f32 / sheet.size()[0] as f32, y as f32 / sheet.size()[1] as f32)
                };
                let end = [place[0] + thumbnails::TILE[0], place[1] + thumbnails::TILE[1]];
                egui::Image::new(egui::load::SizedTexture::new(sheet.id(), size))
                    .uv(egui::Rect::from_min_max(corner(place), corner(end)))
            }
            None => {
                let white =
                    egui::Rect::from_min_max(egui::epaint::WHITE_UV, egui::epaint::WHITE_UV);
                egui::Image::new(egui::load::SizedTexture::new(egui::TextureId::default(), size))
                    .uv(white)
                    .tint(egui::Color32::from_gray(70))
            }
        };
        image.fit_to_exact_size(size).corner_radius(2)
    }
}

/// Columns of buttons: as many as fit side by side with their names alone (thumbnails are shown on hover), so that the controls below fit on a screen of 720
/// pixels.
const COLUMNS: usize = 3;

/// Draws the scenes under a heading as buttons in columns; returns the one that was clicked.
fn scenes_of(
    ui: &mut egui::Ui,
    heading: Heading,
    current: &Scene,
    pictures: &Pictures,
) -> Option<&'static Scene> {
    let mut requested = None;
    egui::Grid::new(heading.title()).num_columns(COLUMNS).spacing([4.0, 2.0]).show(ui, |ui| {
        let gaps = 4.0 * (COLUMNS - 1) as f32;
        let width = ((DOCK_WIDTH - 28.0 - gaps) / COLUMNS as f32).floor();
        for (i, scene) in ALL.iter().filter(|scene| scene.heading == heading).enumerate() {
            let chosen = scene.name == current.name;
            let button =
                egui::Button::selectable(chosen, scene.name).min_size(egui::vec2(width, 20.0));
            let closer = |ui: &mut egui::Ui| {
                let [across, up] = thumbnails::TILE.map(|side| side as f32);
                ui.add(pictures.of(scene, egui::vec2(across, up)));
                ui.set_max_width(across);
                ui.label(scene.title);
            };
            if ui.add(button).on_hover_ui(closer).clicked() {
                requested = Some(scene);
            }
            if i % COLUMNS == COLUMNS - 1 {
                ui.end_row();
            }
        }
    });
    requested
}

/// Draws the lesson: what to try and to watch, the formula, the sliders and the number. Returns the values of the sliders if one was moved.
fn lesson(ui: &mut egui::Ui, stage: &OnStage) -> Option<Vec<f32>> {
    let lesson = stage.scene.lesson?;
    ui.label(format!("Try: {}.", lesson.try_this));
    ui.label(format!("Watch: {}.", lesson.watch));
    ui.add_space(4.0);
    ui.label(egui::RichText::new(lesson.formula).monospace());
    ui.add_space(4.0);
    let mut values = stage.values.clone();
    let mut moved = false;
    for (slider, value) in lesson.sliders.iter().zip(&mut values) {
        let suffix =
            if slider.unit.is_empty() { String::new() } else { format!(" {}", slider.unit) };
        let rail = egui::Slider::new(value, slider.range[0]..=slider.range[1])
            .text(slider.label)
            .suffix(suffix);
        moved |= ui.add(rail).on_hover_text("Changing it restarts the scene.").changed();
    }
    ui.add_space(4.0);
    if let Some([measured, expected]) = stage.reading {
        let unit = lesson.unit;
        ui.label(egui::RichText::new(lesson.number).strong());
        ui.label(format!("measured {measured:.3} {unit}, predicted {expected:.3} {unit}"))
            .on_hover_text(format!("Compared {} s after the start.", lesson.after));
    }
    ui.add_space(6.0);
    moved.then_some(values)
}

fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    egui: Res<EguiWantsInput>,
    mut choice: ResMut<SceneChoice>,
) {
    if egui.wants_keyboard_input() {
        return;
    }
    let current = ALL.iter().position(|scene| scene.name == choice.current.name).unwrap_or(0);
    if keys.just_pressed(KeyCode::KeyR) {
        choice.requested = Some(choice.current);
    }
    if keys.just_pressed(KeyCode::ArrowRight) {
        choice.requested = Some(&ALL[(current + 1) % ALL.len()]);
        choice.values = None;
    }
    if keys.just_pressed(KeyCode::ArrowLeft) {
        choice.requested = Some(&ALL[(current + ALL.len() - 1) % ALL.len()]);
        choice.values = None;
    }
}

/// Sets the viewport of the camera to the part of the window beside the panel, so that a scene is centred in the visible part.
fn leave_room(
    window: Single<&Window, With<PrimaryWindow>>,
    mut camera: Single<&mut Camera, With<PanOrbitCamera>>,
) {
    let whole = window.physical_size();
    let dock = (DOCK_WIDTH * window.scale_factor()) as u32;
    // In a window that is hardly wider than the panel the scene is drawn behind it.
    let left = if whole.x > 2 * dock { dock } else { 0 };
    let physical_position = UVec2::new(left, 0);
    let physical_size = whole - physical_position;
    let fits = camera.viewport.as_ref().is_some_and(|viewport| {
        viewport.physical_position == physical_position && viewport.physical_size == physical_size
    });
    if !fits && physical_size.min_element() > 0 {
        camera.viewport = Some(Viewport { physical_position, physical_size, ..default() });
    }
}

/// The pointer turns the camera only while it is not over the panel, drags nothing and is not used by a tool. (Over the panel it grabs nothing anyway: Bevy's
/// picking gives the press to egui.)
fn share_pointer(
    egui: Res<EguiWantsInput>,
    drag: Res<MouseDrag>,
    tools: Res<Tools>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut camera: Single<&mut PanOrbitCamera>,
) {
    let works = tools.is_armed() && buttons.pressed(MouseButton::Left);
    let free = !egui.wants_any_pointer_input() && drag.grabbed.is_none() && !works;
    if camera.enabled != free {
        camera.enabled = free;
    }
}

#[cfg(test)]
mod tests {
    use ab_glyph::{Font, FontRef};
    use epaint_default_fonts::{EMOJI_ICON, HACK_REGULAR, NOTO_EMOJI_REGULAR, UBUNTU_LIGHT};

    use super::*;

    /// Egui draws characters that its fonts lack as an empty box: the formula of `integrators` once ended with one, for a superscript n.
    #[test]
    fn every_letter_of_a_scene_is_in_the_fonts_that_draw_it() {
        let fonts = [UBUNTU_LIGHT, HACK_REGULAR, NOTO_EMOJI_REGULAR, EMOJI_ICON]
            .map(|font| FontRef::try_from_slice(font).expect("a font that egui ships"));
        let is_drawn = |letter: char| fonts.iter().any(|font| font.glyph_id(letter).0 != 0);
        let mut missing = Vec::new();
        for scene in ALL {
            let mut texts = vec![scene.name, scene.title, scene.about];
            if let Some(lesson) = scene.lesson {
                let own =
                    [lesson.try_this, lesson.watch, lesson.formula, lesson.number, lesson.unit];
                texts.extend(own);
                texts.extend(lesson.sliders.iter().flat_map(|slider| [slider.label, slider.unit]));
            }
            let letters = texts.into_iter().flat_map(str::chars);
            missing.extend(letters.filter(|&letter| !is_drawn(letter)).map(|c| (scene.name, c)));
        }
        assert!(missing.is_empty(), "{missing:?}");
    }

    /// A longer label made the panel wider than its space, which cut off its right edge and a button.
    #[test]
    fn labels_of_sliders_fit_into_the_panel() {
        let lessons = ALL.iter().filter_map(|scene| scene.lesson);
        for slider in lessons.flat_map(|lesson| lesson.sliders) {
            let letters = slider.label.chars().count() + slider.unit.chars().count();
            assert!(letters <= 19, "{} {}: {letters} letters", slider.label, slider.unit);
        }
    }
}
