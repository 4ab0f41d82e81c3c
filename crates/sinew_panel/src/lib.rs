//! An egui panel that tunes, inspects and steps a Sinew world.
//!
//! Add it after the plugins that make the window, and it stands at the right edge of the screen; F1 hides and shows it:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_sinew::prelude::*;
//! use sinew_panel::SinewPanelPlugin;
//!
//! App::new().add_plugins((DefaultPlugins, SinewPlugins, SinewPanelPlugin::default())).run();
//! ```
//!
//! Or draw it into a panel of one's own, below or above whatever else is there:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
//! use bevy_sinew::prelude::*;
//! use sinew_panel::{PanelParams, PanelSide, SinewPanelPlugin, dock, show, style};
//!
//! fn gallery(mut contexts: EguiContexts, mut panel: PanelParams) -> Result {
//!     let ctx = contexts.ctx_mut()?;
//!     style(ctx);
//!     dock(ctx, PanelSide::Left, |ui| {
//!         ui.heading("Scenes");
//!         show(ui, &mut panel);
//!     });
//!     Ok(())
//! }
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, SinewPlugins, SinewPanelPlugin::embedded()))
//!     .add_systems(EguiPrimaryContextPass, gallery)
//!     .run();
//! ```
//!
//! # What it shows
//!
//! | section | reads | writes |
//! |---|---|---|
//! | Time | `SinewClock` | `SinewControl` |
//! | Solver | | `SolverConfig` |
//! | World | | `Gravity`, `AirDrag`, every `Wind`, `Electric` if there are charges |
//! | Report | `SinewWorld::report`, `TickTime` | |
//! | Energy | [`EnergyHistory`], sampled from `SinewWorld::ledger` | |
//! | View | | `enabled` of `SinewGizmoConfigGroup`, if there are gizmos |
//!
//! It writes where the user's hand is and nowhere else: opening it changes nothing. Energies cost one more summation of the forces in a tick, and
//! only while their section is open.
//!
//! # Where there is no screen
//!
//! Without a window, its input or a renderer the plugin adds no egui, which would not start there, and draws nothing; the game runs as without it.
//! Without a camera there is no egui context, and the panel waits for one.
//!
//! # The map
//!
//! | file | what it holds |
//! |---|---|
//! | `panel` | what the panel reads and writes, the order of its sections, the sampling |
//! | `sections` | one file a section |
//! | `widgets` | rows, sliders, numbers, headers |
//! | `history` | the ring buffer of energies |
//! | `dock` | the place at the edge of the screen |
//! | `style` | colours, fonts, spacing |

mod dock;
mod history;
mod panel;
mod sections;
mod style;
#[cfg(test)]
mod tests;
mod widgets;

use std::sync::Arc;

use bevy::app::RunFixedMainLoopSystems;
use bevy::asset::{Asset, Assets, Handle};
use bevy::image::Image;
use bevy::input::InputPlugin;
use bevy::prelude::*;
use bevy::window::WindowPlugin;
use bevy_egui::input::EguiWantsInput;
use bevy_egui::render::EGUI_SHADER_HANDLE;
use bevy_egui::{EguiContexts, EguiPlugin, EguiPrimaryContextPass, egui};
use bevy_sinew::SinewWorld;

pub use dock::{DOCK_WIDTH, PanelSide, dock};
pub use history::{EnergyHistory, EnergySample};
pub use panel::{PanelParams, show};
pub use style::style;

use panel::PanelState;

/// Adds the panel, and `EguiPlugin` if the app has none yet. Must come after the plugins that make the window, such as `DefaultPlugins`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SinewPanelPlugin {
    /// Who draws it. Default [`PanelMode::Docked`], at the right, shown, with F1 as its key.
    pub mode: PanelMode,
}

/// Who draws the panel, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelMode {
    /// The plugin does, at an edge of the screen, and wears the looks of [`style()`] there.
    Docked(SinewPanel),
    /// A system of the game does, by calling [`show`].
    Embedded,
}

impl Default for PanelMode {
    fn default() -> Self {
        Self::Docked(SinewPanel::default())
    }
}

/// The docked panel: a resource that may be changed at any time.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SinewPanel {
    /// Whether it is shown. Default true.
    pub shown: bool,
    /// The edge it stands at. Default the right one.
    pub side: PanelSide,
    /// The key that hides and shows it. Default F1.
    pub key: Option<KeyCode>,
}

impl Default for SinewPanel {
    fn default() -> Self {
        Self { shown: true, side: PanelSide::Right, key: Some(KeyCode::F1) }
    }
}

impl SinewPanelPlugin {
    /// A panel at an edge of the screen.
    pub fn docked(panel: SinewPanel) -> Self {
        Self { mode: PanelMode::Docked(panel) }
    }

    /// No panel of its own: a system of the game draws it with [`show`].
    pub fn embedded() -> Self {
        Self { mode: PanelMode::Embedded }
    }
}

impl Plugin for SinewPanelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<EnergyHistory>().init_resource::<PanelState>();
        let simulated = resource_exists::<SinewWorld>;
        // Once a tick where ticks are fixed; the second time serves worlds that tick in a schedule of their own, and finds nothing to do elsewhere.
        app.add_systems(FixedLast, panel::sample.run_if(simulated))
            .add_systems(Last, panel::sample.run_if(simulated))
            .add_systems(
                RunFixedMainLoop,
                panel::forget_who_looked.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop),
            );
        if !add_egui(app) {
            info!("no window or no renderer: the panel is not drawn");
            return;
        }
        if let PanelMode::Docked(panel) = self.mode {
            app.insert_resource(panel).add_systems(Update, toggle).add_systems(
                EguiPrimaryContextPass,
                draw.run_if(|panel: Res<SinewPanel>| panel.shown).run_if(simulated),
            );
        }
    }
}

/// Adds egui unless it is there. Returns false, and adds nothing, where it would panic.
fn add_egui(app: &mut App) -> bool {
    if app.is_plugin_added::<EguiPlugin>() {
        return true;
    }
    let ready = app.is_plugin_added::<WindowPlugin>()
        && app.is_plugin_added::<InputPlugin>()
        && app.world().contains_resource::<Assets<Image>>()
        && has_assets_of(app, &EGUI_SHADER_HANDLE);
    if ready {
        app.add_plugins(EguiPlugin::default());
    }
    ready
}

/// Whether the app stores assets of the handle's type: the way to ask for shaders without naming a renderer.
fn has_assets_of<A: Asset>(app: &App, _: &Handle<A>) -> bool {
    app.world().contains_resource::<Assets<A>>()
}

fn toggle(
    mut panel: ResMut<SinewPanel>,
    keys: Option<Res<ButtonInput<KeyCode>>>,
    egui: Res<EguiWantsInput>,
) {
    let Some((key, keys)) = panel.key.zip(keys) else { return };
    if keys.just_pressed(key) && !egui.wants_keyboard_input() {
        panel.shown = !panel.shown;
    }
}

fn draw(
    mut contexts: EguiContexts,
    panel: Res<SinewPanel>,
    mut params: PanelParams,
    mut looks: Local<Option<Arc<egui::Style>>>,
) {
    // A game without a camera has no context yet.
    let Ok(ctx) = contexts.ctx_mut() else { return };
    let looks = looks.get_or_insert_with(|| {
        let mut looks = egui::Style::clone(&ctx.global_style());
        style::dress(&mut looks);
        Arc::new(looks)
    });
    dock::dock_styled(ctx, panel.side, Some(looks.clone()), |ui| {
        ui.horizontal(|ui| {
            ui.label(egui::RichText::new("Sinew").heading().strong());
            if let Some(key) = panel.key {
                let hint = egui::RichText::new(format!("{key:?} hides")).small().weak();
                let layout = egui::Layout::right_to_left(egui::Align::Center);
                ui.with_layout(layout, |ui| ui.label(hint));
            }
        });
        ui.add_space(6.0);
        show(ui, &mut params);
    });
}
