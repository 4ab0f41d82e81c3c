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
//! | Time | `SinewClock`, [`Recording`] | `SinewControl`, `PhaseSteps`, and everything where you go back |
//! | Selected body | the components of the [`Selection`], contacts in `SinewWorld::report` | `Representation`, `Sleep`; despawns a constraint |
//! | Solver | | `SolverConfig` |
//! | World | | `Gravity`, `AirDrag`, every `Wind`, `Electric` if there are charges |
//! | Report | `SinewWorld::report`, `TickTime` | |
//! | Plots | [`PlotHistory`], sampled from `SinewWorld::ledger`, its report and `TickTime` | `TickTime::by_phase`, while that is plotted |
//! | View | | `enabled` and the layers of `SinewGizmoConfigGroup`, if there are gizmos |
//! | Settings | a file | that file, or all that is in [`PanelSettings`] |
//!
//! It writes where the user's hand is and nowhere else: opening it changes nothing. The plots (energies by kind, momentum, angular
//! momentum, error, strain, how long a tick takes by parts or by phases) cost one more summation of the forces in a tick, and only while their section is open; to
//! measure the phases costs more, and is done only while that is plotted. Recording costs a copy of the state, 1 ms a tick at the most in the long run
//! ([`RecordingConfig::max_microseconds`]), and only while the panel is shown and Record is ticked.
//!
//! # Time backwards
//!
//! While the panel is shown, it records the state of the last ticks: 600 of them and 512 MiB at the most, and of a large scene every few ticks ([`RecordingConfig`]). The button Back, its key or
//! the slider below puts the world back to one of them and pauses. Run or Step goes on from there, bit for bit as before: the panel compares what is simulated
//! again with what it recorded, and says whether it is the same. With the first tick that differs, because you changed a setting, dragged a body, or the game
//! acted, the recorded ticks from there on are dropped.
//!
//! - What goes back is the state of the simulation ([`StateTypes`](bevy_sinew::StateTypes)), settings and gravity included. Pause and speed are yours.
//! - **A game's own state does not go back**: scores, timers, cameras, what it spawned without particles. [`RegisterState`](bevy_sinew::RegisterState) adds
//!   components and resources to the state, and the event [`WentBack`] says when to do the rest.
//! - Input is not recorded. Bodies that were despawned come back under new ids, with their meshes; a material comes back with them if it is registered
//!   (`app.register_unsaved_state::<MeshMaterial3d<StandardMaterial>>()`).
//! - [`Recording`] does the same from code, without a panel: [`RecordWhen::Always`], [`Recording::go_to`].
//!
//! # The selected body
//!
//! A press on a body in the game's view selects it: the panel reads what [`MouseDragPlugin`](bevy_sinew::MouseDragPlugin) catches, so add that plugin; or set
//! [`Selection`]. The panel shows its mass, its motion, its energies, how well its constraints hold, and what it touches, and cuts the rod or spring that is
//! nearest to where it was clicked. What is selected is marked by lines in an app that has gizmos: a cross at its centre, and what would be cut in red. Escape or
//! a click into the void selects nothing. Selecting changes nothing of the motion; only a drag does.
//!
//! # Keys
//!
//! | key | what it does | where it is set |
//! |---|---|---|
//! | F1 | hides and shows the docked panel | [`SinewPanel::key`] |
//! | F2 | stops and starts simulated time | [`PanelKeys::pause`] |
//! | F3 | goes back by one recorded tick | [`PanelKeys::back`] |
//! | F4 | simulates one tick while paused | [`PanelKeys::step`] |
//! | F6 | shows the next phase of a tick while paused | [`PanelKeys::half_step`] |
//! | Escape | selects nothing | [`PanelKeys::deselect`] |
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
//! | `settings` | what the panel sets, as a file |
//! | `widgets` | rows, sliders, numbers, headers |
//! | `history` | the ring buffer of what is plotted |
//! | `recording` | the snapshots of the last ticks, and the way back to them |
//! | `keys` | the keys |
//! | `selection` | the body that was clicked, and what is known of it |
//! | `mark` | lines at the selected body |
//! | `dock` | the place at the edge of the screen |
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
        // Once a tick where ticks are fixed; the second time serves worlds that tick in a schedule of their own, and finds nothing to do elsewhere.
        app.add_systems(FixedLast, follow())
            .add_systems(
                Last,
                (recording::travel.run_if(simulated).run_if(recording::is_wanted), follow())
                    .chain(),
            )
            .add_systems(
                Update,
                (
                    (keys::press, selection::select, selection::watch).chain().run_if(simulated),
                    panel::forget_who_looked,
                )
                    .chain(),
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

    /// Not while building: the gizmos of a plugin that comes later are there by now.
    fn finish(&self, app: &mut App) {
        mark::add(app);
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
