//! An egui panel that tunes, inspects and steps a Sinew world.
//!
//! Add it after the plugins that create the window. It is docked to the right edge of the screen; F1 hides and shows it:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_sinew::prelude::*;
//! use sinew_panel::SinewPanelPlugin;
//!
//! App::new().add_plugins((DefaultPlugins, SinewPlugins, SinewPanelPlugin::default())).run();
//! ```
//!
//! Or draw it into a panel of your own, above or below other widgets:
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
//! | Time | `SinewClock`, [`Recording`] | `SinewControl`, `PhaseSteps`, and the whole state when you go back |
//! | Selected body | the components of the [`Selection`], contacts in `SinewWorld::report` | `Representation`, `Sleep`; despawns a constraint |
//! | Solver | | `SolverConfig` |
//! | World | | `Gravity`, `AirDrag`, every `Wind`, `Electric` if there are charges |
//! | Report | `SinewWorld::report`, `TickTime` | |
//! | Plots | [`PlotHistory`], sampled from `SinewWorld::ledger`, its report and `TickTime` | `TickTime::by_phase`, while the phases are plotted |
//! | View | | `enabled` and the layers of `SinewGizmoConfigGroup`, if there are gizmos |
//! | Settings | a file | that file, or everything in [`PanelSettings`] |
//!
//! The panel writes only what the user edits: opening it changes nothing. The plots (energies by kind, momentum, angular momentum, error, strain, duration of a
//! tick by parts or by phases) cost one more summation of the forces in a tick, and only while their section is open. Measuring the phases costs more, and
//! happens only while they are plotted. Recording costs a copy of the state, on average at most 1 ms a tick ([`RecordingConfig::max_microseconds`]), and only
//! while the panel is shown and Record is ticked.
//!
//! # Time backwards
//!
//! While the panel is shown, it records the state of the last ticks: at most 600 of them and 512 MiB, and of a large scene only every few ticks
//! ([`RecordingConfig`]). The button Back, its key or the slider below restores one of them and pauses. Run or Step goes on from there, bit for bit as before:
//! the panel compares each tick that is simulated again with the recorded one and shows whether they are the same. At the first tick that differs, because you
//! changed a setting, dragged a body, or the game acted, the recorded ticks from there on are dropped.
//!
//! - The state of the simulation goes back ([`StateTypes`](bevy_sinew::StateTypes)), settings and gravity included. Pause and speed are left alone.
//! - **A game's own state does not go back**: scores, timers, cameras, entities without particles. [`RegisterState`](bevy_sinew::RegisterState) adds components
//!   and resources to the state, and the event [`WentBack`] is the place to restore the rest.
//! - Input is not recorded. Bodies that were despawned come back under new ids, with their meshes; a material comes back with them if it is registered
//!   (`app.register_unsaved_state::<MeshMaterial3d<StandardMaterial>>()`).
//! - [`Recording`] offers the same from code, without a panel: [`RecordWhen::Always`], [`Recording::go_to`].
//!
//! # The selected body
//!
//! A press on a body in the game's view selects it. The panel takes the body that [`MouseDragPlugin`](bevy_sinew::MouseDragPlugin) grabs, so add that plugin;
//! or set [`Selection`]. The panel shows the body's mass, motion and energies, the residuals of its constraints and its contacts, and can cut the rod or spring
//! that is nearest to the clicked point. In an app with gizmos, lines mark the selected body: a cross at its centre of mass, and in red what would be cut.
//! Escape or a click on empty space clears the selection. Selecting does not affect the motion; only a drag does.
//!
//! # Keys
//!
//! | key | effect | where it is set |
//! |---|---|---|
//! | F1 | hides and shows the docked panel | [`SinewPanel::key`] |
//! | F2 | pauses and resumes simulated time | [`PanelKeys::pause`] |
//! | F3 | goes back by one recorded tick | [`PanelKeys::back`] |
//! | F4 | simulates one tick while paused | [`PanelKeys::step`] |
//! | F6 | shows the state after the next phase of a tick while paused | [`PanelKeys::half_step`] |
//! | Escape | clears the selection | [`PanelKeys::deselect`] |
//!
//! # Without a screen
//!
//! Without a window, its input or a renderer the plugin does not add egui, which would panic there, and draws nothing; the game runs as it would without the
//! panel. Without a camera there is no egui context; the panel appears once a camera is spawned.
//!
//! # Modules
//!
//! | module | content |
//! |---|---|
//! | `panel` | what the panel reads and writes, the order of its sections, the sampling |
//! | `sections` | one file a section |
//! | `settings` | what the panel can set, as a file |
//! | `widgets` | rows, sliders, numbers, headers |
//! | `history` | the ring buffer of what is plotted |
//! | `recording` | the snapshots of the last ticks, and restoring one |
//! | `keys` | key bindings |
//! | `selection` | the selected body, and the values shown of it |
//! | `mark` | lines at the selected body |
//! | `dock` | the container at the edge of the screen |
//! | `style` | colours, fonts, spacing |

mod dock;
mod history;
mod keys;
mod mark;
mod panel;
mod params;
mod recording;
mod sections;
mod selection;
mod settings;
mod state;
mod style;
#[cfg(test)]
mod tests;
mod widgets;

use std::sync::Arc;

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
pub use history::{PlotHistory, PlotSample};
pub use keys::PanelKeys;
pub use mark::SinewPanelGizmos;
pub use panel::show;
pub use params::PanelParams;
pub use recording::{RecordWhen, RecordedTick, Recording, RecordingConfig, Replay, WentBack};
pub use selection::Selection;
pub use settings::{PanelSettings, SettingsFault};
pub use style::style;

use state::PanelState;

/// Adds the panel, and `EguiPlugin` if the app does not have it yet. Must be added after the plugins that create the window, such as `DefaultPlugins`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SinewPanelPlugin {
    /// What draws the panel. Default [`PanelMode::Docked`], at the right, shown, with F1 as its key.
    pub mode: PanelMode,
}

/// What draws the panel, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelMode {
    /// The plugin draws it at an edge of the screen, in the style of [`style()`].
    Docked(SinewPanel),
    /// A system of the game draws it, by calling [`show`].
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
    /// The edge that it is docked to. Default right.
    pub side: PanelSide,
    /// The key that hides and shows it; `None` disables it. Default F1.
    pub key: Option<KeyCode>,
}

impl Default for SinewPanel {
    fn default() -> Self {
        Self { shown: true, side: PanelSide::Right, key: Some(KeyCode::F1) }
    }
}

impl SinewPanelPlugin {
    /// The plugin with a panel docked to an edge of the screen.
    pub fn docked(panel: SinewPanel) -> Self {
        Self { mode: PanelMode::Docked(panel) }
    }

    /// The plugin without a panel of its own: a system of the game draws it with [`show`].
    pub fn embedded() -> Self {
        Self { mode: PanelMode::Embedded }
    }
}

impl Plugin for SinewPanelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PlotHistory>()
            .init_resource::<PanelState>()
            .init_resource::<PanelKeys>()
            .init_resource::<Recording>()
            .init_resource::<RecordingConfig>()
            .init_resource::<Selection>()
            .register_type::<(PanelKeys, RecordingConfig, Selection)>()
            .add_observer(selection::follow_back);
        let simulated = resource_exists::<SinewWorld>;
        let follow = || {
            (panel::sample, recording::record.run_if(recording::is_on)).chain().run_if(simulated)
        };
        // Once a tick in apps that tick in the fixed schedules. The second time, in `Last`, is for worlds that tick in a schedule of their own; elsewhere the
        // tick is already sampled and it does nothing.
        app.add_systems(FixedLast, follow())
            .add_systems(
                Last,
                (
                    recording::restore_requested.run_if(simulated).run_if(recording::is_requested),
                    follow(),
                )
                    .chain(),
            )
            .add_systems(
                Update,
                (
                    (keys::apply, selection::select, selection::watch).chain().run_if(simulated),
                    panel::reset_shown,
                )
                    .chain(),
            );
        if !add_egui(app) {
            info!("no window or renderer: the panel is not drawn");
            return;
        }
        if let PanelMode::Docked(panel) = self.mode {
            app.insert_resource(panel).add_systems(Update, toggle).add_systems(
                EguiPrimaryContextPass,
                draw.run_if(|panel: Res<SinewPanel>| panel.shown).run_if(simulated),
            );
        }
    }

    /// Runs after all plugins are built, so that the gizmos of a plugin that is added later exist.
    fn finish(&self, app: &mut App) {
        mark::add(app);
    }
}

/// Adds egui unless the app has it. Returns false, and adds nothing, if egui would panic.
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

/// Whether the app stores assets of the handle's type. This detects shaders without naming a renderer.
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
    // Without a camera there is no context yet.
    let Ok(ctx) = contexts.ctx_mut() else { return };
    let looks = looks.get_or_insert_with(|| {
        let mut looks = egui::Style::clone(&ctx.global_style());
        style::apply_style(&mut looks);
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
