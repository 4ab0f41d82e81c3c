//! A scene, the heading it is listed under, and its lesson: an experiment with sliders and one number that a formula predicts.

use bevy::prelude::*;
use bevy_sinew::SinewClock;

/// A scene: its name, its camera and how to spawn it.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Name on a command line.
    pub name: &'static str,
    /// Heading that it is listed under.
    pub heading: Heading,
    /// Title in a window and on a picture.
    pub title: &'static str,
    /// One sentence about what it shows.
    pub about: &'static str,
    /// Position of the camera, metres.
    pub eye: Vec3,
    /// Point at which the camera looks, metres.
    pub target: Vec3,
    /// Length of a film of it, seconds.
    pub seconds: f32,
    /// Simulated time of its still picture, seconds.
    pub moment: f32,
    /// Its experiment, if it has one.
    pub lesson: Option<Lesson>,
    /// Spawns everything; each root entity carries [`InScene`](crate::InScene).
    pub spawn: fn(&mut World),
}

/// The heading under which a gallery lists a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// Gravity, wind, drag, buoyancy, charges.
    Forces,
    /// Time integration.
    Integration,
    /// Rods, springs, angles, and how they are solved.
    Constraints,
    /// Boxes, ragdolls and other compounds, as particles and as rigid bodies.
    Bodies,
    /// Ropes, cloth and soft bodies.
    Soft,
    /// Contacts, friction, restitution.
    Contacts,
    /// Scenes of many kinds of bodies: to play with, to look at, to benchmark.
    Together,
}

impl Heading {
    /// All headings, in the order in which a gallery shows them.
    pub const ALL: [Self; 7] = [
        Self::Forces,
        Self::Integration,
        Self::Constraints,
        Self::Bodies,
        Self::Soft,
        Self::Contacts,
        Self::Together,
    ];

    /// Title on a screen.
    pub fn title(self) -> &'static str {
        match self {
            Self::Forces => "Forces",
            Self::Integration => "Time integration",
            Self::Constraints => "Constraints",
            Self::Bodies => "Bodies",
            Self::Soft => "Ropes, cloth, soft bodies",
            Self::Contacts => "Contacts and friction",
            Self::Together => "Everything together",
        }
    }
}

/// A slider of a scene. A scene is spawned from the values of its sliders, so moving one restarts the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSlider {
    /// Quantity that it changes, in a word or two.
    pub label: &'static str,
    /// Unit of its value; empty where it has none.
    pub unit: &'static str,
    /// Smallest and largest value. The formula of the scene holds in between.
    pub range: [f32; 2],
    /// Initial value.
    pub default: f32,
}

/// An experiment: what to try, what to watch, and one number that a formula predicts.
#[derive(Clone, Copy, Debug)]
pub struct Lesson {
    /// What the user may change, and what happens then.
    pub try_this: &'static str,
    /// Where to look.
    pub watch: &'static str,
    /// The formula that predicts the number, as text.
    pub formula: &'static str,
    /// Its sliders.
    pub sliders: &'static [SceneSlider],
    /// Name of the measured number, in a few words.
    pub number: &'static str,
    /// Unit of the number; empty where it has none.
    pub unit: &'static str,
    /// Simulated time after which the number is compared with the formula, seconds.
    pub after: f32,
    /// Measures the number. `None` before there is something to measure, and once the formula no longer holds, such as after a landing; the last number is kept
    /// then.
    pub measure: fn(&mut World) -> Option<f64>,
    /// The number that the formula predicts, from the values of the sliders and the simulated time in seconds.
    pub expect: fn(&[f32], f64) -> f64,
    /// Largest difference between the two: absolute, in the number's unit, and relative to the predicted number. The larger one counts.
    pub tolerance: [f64; 2],
}

impl Lesson {
    /// Whether a measured number agrees with the formula.
    pub fn agrees(&self, measured: f64, expected: f64) -> bool {
        let [own, share] = self.tolerance;
        (measured - expected).abs() <= own.max(share * expected.abs())
    }
}

/// Marks entities spawned by a scene, so that the next scene can despawn them.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct InScene;

/// The current scene, the values of its sliders and the last measurement.
#[derive(Resource, Clone, Debug)]
pub struct OnStage {
    /// The scene.
    pub scene: &'static Scene,
    /// A value for each of its sliders.
    pub values: Vec<f32>,
    /// The measured number and the one that the formula predicts for the same time.
    pub reading: Option<[f64; 2]>,
    /// Simulated time at which measuring ended, seconds.
    pub(crate) ended: Option<f64>,
}

/// Measures the number of the current scene. Runs once a frame, after the ticks.
pub(crate) fn measure(world: &mut World) {
    let Some(stage) = world.get_resource::<OnStage>() else { return };
    let Some(lesson) = stage.scene.lesson else { return };
    let seconds = world.resource::<SinewClock>().seconds;
    // After a rollback to an earlier time there is something to measure again.
    if stage.ended.is_some_and(|ended| ended <= seconds) {
        return;
    }
    let expected = (lesson.expect)(&stage.values, seconds);
    let measured = (lesson.measure)(world);
    let mut stage = world.resource_mut::<OnStage>();
    stage.ended = (measured.is_none() && stage.reading.is_some()).then_some(seconds);
    stage.reading = measured.map(|measured| [measured, expected]).or(stage.reading);
}

/// The values of the sliders of the scene that is being spawned.
pub(crate) fn values<const N: usize>(world: &World) -> [f32; N] {
    let stage = world.resource::<OnStage>();
    core::array::from_fn(|i| stage.values[i])
}

/// The component of the first entity with this name.
pub(crate) fn component_of<C: Component + Clone>(world: &mut World, name: &str) -> Option<C> {
    let mut named = world.query::<(&Name, &C)>();
    named.iter(world).find(|(its, _)| its.as_str() == name).map(|(_, found)| found.clone())
}
