//! The panel's settings as a file, saved and loaded as a whole or not at all.

#[cfg(test)]
mod tests;

use core::any::TypeId;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::reflect::serde::{TypedReflectDeserializer, TypedReflectSerializer};
use bevy::reflect::{FromReflect, TypeRegistry};
use bevy_sinew::SolverConfig;

use crate::recording::RecordingConfig;
use crate::state::default_settings_path;

/// Version of the file format. Other versions are rejected.
const VERSION: u32 = 1;

/// The settings of a whole world, which can be written as RON (Rusty Object Notation) and read again. Winds and fluids belong to a scene and are not included.
///
/// ```
/// # use sinew_panel::PanelSettings;
/// let settings = PanelSettings { speed: 0.5, ..PanelSettings::default() };
/// assert_eq!(PanelSettings::from_ron(&settings.to_ron()?)?, settings);
/// assert!(PanelSettings::from_ron("(speed: 0.5)").is_err());
/// # Ok::<(), sinew_panel::SettingsFault>(())
/// ```
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct PanelSettings {
    /// The solver's settings.
    pub solver: SolverConfig,
    /// [`Gravity`](bevy_sinew::Gravity), m/s².
    pub gravity: [f32; 3],
    /// [`AirDrag`](bevy_sinew::AirDrag), 1/s, 0 and up.
    pub air_drag: f32,
    /// Coulomb's constant of [`Electric`](bevy_sinew::Electric), N·m²/C².
    pub electric_constant: f32,
    /// Softening distance of [`Electric`](bevy_sinew::Electric), m, 0 and up.
    pub electric_softening: f32,
    /// [`SinewControl::relative_speed`](bevy_sinew::SinewControl::relative_speed), 0 to 16.
    pub speed: f32,
    /// When ticks are recorded, and the limits of that.
    pub recording: RecordingConfig,
}

impl Default for PanelSettings {
    /// The settings of a new world.
    fn default() -> Self {
        let electric = bevy_sinew::Electric::default();
        Self {
            solver: SolverConfig::default(),
            gravity: bevy_sinew::Gravity::default().0.to_array(),
            air_drag: bevy_sinew::AirDrag::default().0,
            electric_constant: electric.constant,
            electric_softening: electric.softening,
            speed: 1.0,
            recording: RecordingConfig::default(),
        }
    }
}

/// Content of a file: the version under the panel's name, which identifies the file, and the settings.
#[derive(Reflect)]
struct File {
    sinew_panel: u32,
    settings: PanelSettings,
}

/// Why settings could not be saved or loaded. Nothing was changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsFault {
    /// The file cannot be read or written.
    #[error("{0}")]
    File(String),
    /// It is not a settings file of this panel.
    #[error("it is not a settings file of the panel")]
    Foreign,
    /// It has another version of the format.
    #[error("its format version is {0}, not {VERSION}")]
    Version(u32),
    /// It is truncated or malformed, or has an unknown field.
    #[error("it is malformed: {0}")]
    Broken(String),
    /// This number is out of its range or not finite.
    #[error("its {0} is out of range")]
    Number(&'static str),
}

impl PanelSettings {
    /// The settings as RON text.
    ///
    /// # Errors
    /// None in practice: every field can be serialized.
    pub fn to_ron(&self) -> Result<String, SettingsFault> {
        let registry = registry();
        let file = File { sinew_panel: VERSION, settings: *self };
        ron::Options::default()
            .to_string_pretty(
                &TypedReflectSerializer::new(&file, &registry),
                ron::ser::PrettyConfig::new(),
            )
            .map_err(|fault| SettingsFault::Broken(fault.to_string()))
    }

    /// Parses the text of [`to_ron`](Self::to_ron). A missing setting gets its default.
    ///
    /// # Errors
    /// Text that is something else, has another version or is malformed, or has a number out of its range.
    pub fn from_ron(text: &str) -> Result<Self, SettingsFault> {
        let registry = registry();
        let broken = |fault: String| {
            let own = text.contains("sinew_panel");
            if own { SettingsFault::Broken(fault) } else { SettingsFault::Foreign }
        };
        let registration = registry.get(TypeId::of::<File>());
        let registration = registration.ok_or_else(|| broken("no registration".into()))?;
        let seed = TypedReflectDeserializer::new(registration, &registry);
        let value = ron::Options::default().from_str_seed(text, seed);
        let value = value.map_err(|fault| broken(fault.to_string()))?;
        let read = File::from_reflect(&*value);
        let read = read.ok_or_else(|| broken("the settings are missing".into()))?;
        if read.sinew_panel != VERSION {
            return Err(SettingsFault::Version(read.sinew_panel));
        }
        let settings = read.settings;
        settings.fault().map_or(Ok(settings), |name| Err(SettingsFault::Number(name)))
    }

    /// Writes a file.
    ///
    /// # Errors
    /// If the path cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), SettingsFault> {
        std::fs::write(path, self.to_ron()?).map_err(|fault| SettingsFault::File(fault.to_string()))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If the path cannot be read, and those of [`from_ron`](Self::from_ron).
    pub fn load(path: &Path) -> Result<Self, SettingsFault> {
        let text = std::fs::read_to_string(path);
        // A file that is not text is not a settings file.
        Self::from_ron(&text.map_err(|fault| match fault.kind() {
            std::io::ErrorKind::InvalidData => SettingsFault::Foreign,
            _ => SettingsFault::File(fault.to_string()),
        })?)
    }

    /// Default path of the settings: `settings.ron` beside the executable, or in the working directory if that is not known.
    pub fn default_path() -> PathBuf {
        default_settings_path()
    }

    /// Name of a setting that is out of its range, if there is one.
    fn fault(&self) -> Option<&'static str> {
        let solver = &self.solver;
        let up = |number: f32| number.is_finite() && number >= 0.0;
        let sound = [
            ("gravity", self.gravity.iter().all(|x| x.is_finite())),
            ("air_drag", up(self.air_drag)),
            ("electric_constant", self.electric_constant.is_finite()),
            ("electric_softening", up(self.electric_softening)),
            ("speed", up(self.speed)),
            ("tolerance", up(solver.tolerance)),
            ("max_speed", up(solver.max_speed)),
            ("substeps", (1..=256).contains(&solver.substeps)),
            ("max_sweeps", (1..=1000).contains(&solver.max_sweeps)),
        ];
        sound.into_iter().find(|(_, sound)| !sound).map(|(name, _)| name)
    }
}

/// The registry of the types in a file.
fn registry() -> TypeRegistry {
    let mut registry = TypeRegistry::new();
    registry.register::<File>();
    registry
}
