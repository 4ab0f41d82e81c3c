//! A rope between two posts, brought to rest by drag, and the catenary given by its length.

use bevy::prelude::*;
use bevy_sinew::BodyParticles;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{curve, post};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};

pub(super) const SCENE: Scene = Scene {
    name: "catenary",
    heading: Heading::Soft,
    title: "The catenary",
    about: "a rope between two posts comes to rest in strong drag, on the red curve of cosh that its length alone determines",
    eye: Vec3::new(0.4, 1.6, 4.6),
    target: Vec3::new(0.0, 1.15, 0.0),
    seconds: 5.0,
    moment: 4.0,
    lesson: Some(Lesson {
        try_this: "give the rope more slack, then more mass: slack changes the curve, mass does not",
        watch: "high drag removes the motion, and what is left is statics: the rope lies on the red curve",
        formula: "sag = a (cosh(D/2a) − 1), with 2a sinh(D/2a) = L",
        sliders: &[
            SceneSlider { label: "Slack", unit: "", range: [0.2, 0.6], default: 0.3 },
            SceneSlider { label: "Mass", unit: "kg", range: [0.1, 3.0], default: 0.5 },
            SceneSlider { label: "Span", unit: "m", range: [1.2, 2.2], default: 2.0 },
        ],
        number: "Sag in the middle",
        unit: "m",
        after: 5.0,
        measure: |world| {
            let particles: BodyParticles = component_of(world, "hanging rope")?;
            let height = |p: Entity| world.get::<Particle>(p).map(|p| f64::from(p.position.y));
            let lowest = particles.iter().filter_map(height).reduce(f64::min)?;
            Some(f64::from(TOP) - lowest)
        },
        expect: |values, _| {
            let span = f64::from(values[2]);
            let a = parameter(span, span * (1.0 + f64::from(values[0])));
            a * (libm::cosh(0.5 * span / a) - 1.0)
        },
        // The solver may leave each of the 24 segments too long by its tolerance, and the sag grows faster than the length.
        tolerance: [0.0, 0.02],
    }),
    spawn,
};

/// Height of the ends, metres.
const TOP: f32 = 1.95;
/// Radius of the rope and of a post, metres.
const ROPE: f32 = 0.02;
const POST: f32 = 0.05;
/// Straight segments of the drawn curve.
const PIECES: u32 = 40;

/// The parameter `a` of the catenary over `span` whose arc length is `length`, metres: the root of `2a sinh(span/2a) = length`, by bisection.
fn parameter(span: f64, length: f64) -> f64 {
    // With u = span/2a the arc length is span · sinh(u)/u, which grows with u.
    let (mut low, mut high) = (1e-6, 20.0);
    for _ in 0..80 {
        let u = 0.5 * (low + high);
        if libm::sinh(u) / u < length / span {
            low = u;
        } else {
            high = u;
        }
    }
    span / (low + high)
}

fn spawn(world: &mut World) {
    let [slack, mass, span] = values(world);
    world.insert_resource(AirDrag(0.95));
    world.spawn((InScene, Ground));
    let half = 0.5 * span;
    let wood = Look::color(0x8a6a4b).roughness(0.9);
    for side in [-1.0, 1.0] {
        let post = post(world, POST, TOP + 0.1);
        let x = side * (half + POST + ROPE + 0.002);
        world.spawn((InScene, post, wood.clone(), Transform::from_xyz(x, 0.5 * TOP + 0.05, 0.0)));
    }
    let rope = Rope {
        mass,
        radius: ROPE,
        segments: 24,
        pin_start: true,
        pin_end: true,
        ..Rope::between(Vec3::new(-half, TOP, 0.0), Vec3::new(half, TOP, 0.0))
    };
    let hemp = Look::color(0xc9a66b).roughness(0.9);
    world.spawn((InScene, Name::new("hanging rope"), rope.with_slack(slack), hemp, Interpolate));
    // The curve by the formula, drawn in front of the rope.
    let a = parameter(f64::from(span), f64::from(span * (1.0 + slack))) as f32;
    let curve_at = |i: u32| {
        let x = span * (i as f32 / PIECES as f32 - 0.5);
        let lift = a * (libm::coshf(x / a) - libm::coshf(half / a));
        Vec3::new(x, TOP + lift, 2.0 * ROPE)
    };
    let points: Vec<Vec3> = (0..=PIECES).map(curve_at).collect();
    curve(world, &points, 0.005, Look::color(0xd0342c));
}
