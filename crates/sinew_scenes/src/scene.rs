//! What a scene is, the heading it stands under, and what it teaches: an experiment with sliders and one number that a formula predicts.

use bevy::prelude::*;
use bevy_sinew::SinewClock;

/// A scene: what it is called, where to look at it from, and how to spawn it.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// What it is called on a command line.
    pub name: &'static str,
    /// The heading that it stands under.
    pub heading: Heading,
    /// What it is called on a picture.
    pub title: &'static str,
    /// One sentence on what there is to see.
    pub about: &'static str,
    /// Where the camera stands, metres.
    pub eye: Vec3,
    /// What it looks at, metres.
    pub target: Vec3,
    /// How long it is worth watching, seconds.
    pub seconds: f32,
    /// When it is best photographed, seconds.
    pub moment: f32,
    /// What to try in it, and the number that a formula predicts, if there is one.
    pub lesson: Option<Lesson>,
    /// Spawns everything; each root carries [`InScene`](crate::InScene).
    pub spawn: fn(&mut World),
}

/// The heading under which a gallery lists a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// Gravity, wind, drag, buoyancy, charges.
    Forces,
    /// How a step through time is made.
    Integration,
    /// Rods, springs, angles, and how they are solved.
    Constraints,
    /// Boxes, ragdolls and other compounds, as particles and as rigid bodies.
    Bodies,
    /// Ropes, cloth and soft bodies.
    Soft,
    /// Contacts, friction, restitution.
    Contacts,
    /// Everything at once: to play with, to look at, to count.
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

    /// What it is called on a screen.
    pub fn title(self) -> &'static str {
        match self {
            Self::Forces => "Forces",
            Self::Integration => "Time integration",
            Self::Constraints => "Constraints",
            Self::Bodies => "Bodies",
            Self::Soft => "Ropes, cloth, soft bodies",
            Self::Contacts => "Contacts and friction",
            Self::Together => "All together",
        }
    }
}

/// A slider of a scene. A scene is spawned from the values of its sliders, so moving one starts the scene again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSlider {
    /// What it changes, in a word or two.
    pub label: &'static str,
    /// Unit of its value; empty where it has none.
    pub unit: &'static str,
    /// Least and most value. The formula of the scene holds in between.
    pub range: [f32; 2],
    /// Value at first.
    pub default: f32,
}

/// An experiment: what to try, what to watch, and one number that a formula predicts.
#[derive(Clone, Copy, Debug)]
pub struct Lesson {
    /// What a visitor may change, and what happens then.
    pub try_this: &'static str,
    /// Where to look.
    pub watch: &'static str,
    /// The formula at work, as text.
    pub formula: &'static str,
    /// Its sliders.
    pub sliders: &'static [SceneSlider],
    /// What the measured number is, in a few words.
    pub number: &'static str,
    /// Unit of the number; empty where it has none.
    pub unit: &'static str,
    /// Simulated time after which the number is compared with the formula, seconds.
    pub after: f32,
    /// Reads the number off the world; `None` while there is nothing to read, and when the formula holds no longer: what has landed. The last number stays then.
    pub measure: fn(&mut World) -> Option<f64>,
    /// The number by the formula, from the values of the sliders and the simulated time in seconds.
    pub expect: fn(&[f32], f64) -> f64,
    /// How far the two may be apart, in the number's own unit and as a share of what is expected: the larger one counts.
    pub tolerance: [f64; 2],
}

impl Lesson {
    /// Whether a measured number agrees with the formula.
    pub fn agrees(&self, measured: f64, expected: f64) -> bool {
        let [own, share] = self.tolerance;
        (measured - expected).abs() <= own.max(share * expected.abs())
    }
}

/// Marks what a scene spawned, so that the next one can clear it away.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct InScene;

/// The scene that is on, the values of its sliders, and what was measured last.
#[derive(Resource, Clone, Debug)]
pub struct OnStage {
    /// The scene.
    pub scene: &'static Scene,
    /// A value for each of its sliders.
    pub values: Vec<f32>,
    /// The measured number and the one that the formula gives for the same moment.
    pub reading: Option<[f64; 2]>,
    /// When there was nothing more to measure, simulated seconds.
    pub(crate) ended: Option<f64>,
}

/// Measures the number of the scene that is on. Runs once a frame, after the ticks.
pub(crate) fn measure(world: &mut World) {
    let Some(stage) = world.get_resource::<OnStage>() else { return };
    let Some(lesson) = stage.scene.lesson else { return };
    let seconds = world.resource::<SinewClock>().seconds;
    // Whoever goes back in time is before that again.
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

/// The component of what bears a name in the scene.
pub(crate) fn of_named<C: Component + Clone>(world: &mut World, name: &str) -> Option<C> {
    let mut named = world.query::<(&Name, &C)>();
    named.iter(world).find(|(its, _)| its.as_str() == name).map(|(_, found)| found.clone())
}
