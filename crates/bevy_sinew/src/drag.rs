//! Dragging particles with the mouse: what every demo rewrites.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;

use crate::components::{BodyParticles, Mass, Particle, ParticleOf, ParticleRow, Pinned};
use crate::schedule::{PhaseSystems, SubstepSchedule};
use crate::world::SinewWorld;

/// Lets the mouse drag particles. Inert in an app without a window or a mouse, except for what a game does with [`MouseDrag`] itself.
#[derive(Default)]
pub struct MouseDragPlugin;

/// What is being dragged, and how. A game may set [`grabbed`](Self::grabbed) itself: a hand, a tractor beam.
#[derive(Resource, Clone, Debug)]
pub struct MouseDrag {
    /// The button that grabs; `None` switches the mouse off. Default the left one.
    pub button: Option<MouseButton>,
    /// How far beside the pointer a particle may be, as the tangent of the angle seen from the camera. Default 0.04, some 2°.
    pub reach: f32,
    /// How eagerly the particle follows: the frequency ω of a critically damped pull, rad/s. Default 14: there in a quarter of a second.
    pub eagerness: f32,
    /// What is held now.
    pub grabbed: Option<Grab>,
}

/// A particle, and where it is pulled to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grab {
    /// The particle.
    pub particle: Entity,
    /// Where it is to go, metres.
    pub target: Vec3,
}

impl Default for MouseDrag {
    fn default() -> Self {
        Self { button: Some(MouseButton::Left), reach: 0.04, eagerness: 14.0, grabbed: None }
    }
}

impl Plugin for MouseDragPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MouseDrag>()
            .add_systems(PreUpdate, follow_pointer.run_if(pointed).after(bevy::input::InputSystems))
            .add_systems(
                SubstepSchedule,
                pull.run_if(holding)
                    .in_set(PhaseSystems::AccumulateForces)
                    // Forces add up; which of two comes first is the schedule's affair.
                    .ambiguous_with(PhaseSystems::AccumulateForces),
            );
    }
}

/// Whether the mouse has anything to say: its button is down, or was a moment ago.
fn pointed(drag: Res<MouseDrag>, buttons: Option<Res<ButtonInput<MouseButton>>>) -> bool {
    let told = drag.button.zip(buttons);
    told.is_some_and(|(button, buttons)| buttons.pressed(button) || buttons.just_released(button))
}

/// Whether anything is held.
fn holding(drag: Res<MouseDrag>) -> bool {
    drag.grabbed.is_some()
}

/// Grabs the particle under the pointer when the button goes down, leads it while it is held, and lets go after.
fn follow_pointer(
    mut drag: ResMut<MouseDrag>,
    buttons: Option<Res<ButtonInput<MouseButton>>>,
    windows: Query<&Window, With<PrimaryWindow>>,
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    particles: Query<(Entity, &Particle, &ParticleRow), Without<Pinned>>,
    world: Res<SinewWorld>,
) {
    let Some((buttons, button)) = buttons.zip(drag.button) else { return };
    if !buttons.pressed(button) {
        if buttons.just_released(button) {
            drag.grabbed = None;
        }
        return;
    }
    let pointer = windows.single().ok().and_then(Window::cursor_position);
    let ray = pointer.zip(cameras.iter().find(|(camera, _)| camera.is_active)).and_then(
        |(pointer, (camera, frame))| {
            Some((camera.viewport_to_world(frame, pointer).ok()?, frame.forward()))
        },
    );
    let Some((ray, forward)) = ray else { return };
    if buttons.just_pressed(button) {
        let candidates = particles.iter().map(|(entity, particle, row)| {
            let radius = row.get().map_or(0.0, |i| world.simulation.particles.radius(i));
            (entity, particle.position, radius)
        });
        drag.grabbed =
            pick(ray, drag.reach, candidates).map(|(particle, at)| Grab { particle, target: at });
    }
    if let Some(grab) = &mut drag.grabbed {
        // It stays as far from the camera as it was grabbed.
        let depth = (grab.target - ray.origin).dot(*forward);
        let steepness = ray.direction.dot(*forward);
        if steepness > 1e-3 {
            grab.target = ray.origin + *ray.direction * (depth / steepness);
        }
    }
}

/// The particle nearest to the ray as seen from its origin; of those that the ray goes through, the nearest to the origin.
fn pick(
    ray: Ray3d,
    reach: f32,
    candidates: impl Iterator<Item = (Entity, Vec3, f32)>,
) -> Option<(Entity, Vec3)> {
    let mut best: Option<(f32, Entity, Vec3)> = None;
    for (entity, at, radius) in candidates {
        let away = at - ray.origin;
        let depth = away.dot(*ray.direction);
        if depth.is_nan() || depth <= 0.0 {
            continue;
        }
        let beside = ((away - *ray.direction * depth).length() - radius).max(0.0) / depth;
        // A metre in front counts as much as a third of the reach beside.
        let score = beside + depth * reach * 0.3;
        if beside <= reach && best.is_none_or(|(least, ..)| score < least) {
            best = Some((score, entity, at));
        }
    }
    best.map(|(_, entity, at)| (entity, at))
}

/// Pulls the grabbed particle: `a = ω² (target - p) - 2 ω v`, and as much more as its body is heavier than it.
fn pull(
    drag: Res<MouseDrag>,
    mut world: ResMut<SinewWorld>,
    particles: Query<(&ParticleRow, &Mass, Option<&ParticleOf>)>,
    bodies: Query<&BodyParticles>,
    masses: Query<&Mass>,
) {
    let Some(grab) = drag.grabbed else { return };
    let Ok((row, mass, body)) = particles.get(grab.particle) else { return };
    let Some(i) = row.get().filter(|&i| i < world.particles().len()) else { return };
    if !grab.target.is_finite() || world.particles().inverse_mass(i) == 0.0 {
        return;
    }
    let members = body.and_then(|body| bodies.get(body.0).ok());
    let whole: f32 =
        members.map_or(mass.0, |list| masses.iter_many(list.iter()).map(|m| m.0).sum());
    let omega = drag.eagerness.clamp(0.0, 100.0);
    // An explicit pull is stable up to ω h = 2; half of a half leaves room for what else pulls.
    let most = 0.5 / (omega * world.substep().length).max(1e-6);
    let share = (whole / mass.0).clamp(1.0, (most * most).max(1.0));
    let away = grab.target - world.particles().position(i);
    let velocity = world.particles().velocity(i);
    let pull = (away * omega - velocity * 2.0) * omega * share;
    world.particles_mut().add_acceleration(i, pull);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entity(number: u32) -> Entity {
        Entity::from_raw_u32(number).expect("a small number")
    }

    #[test]
    fn the_pointer_takes_what_is_under_it_and_the_nearer_of_two() {
        let ray = Ray3d::new(Vec3::ZERO, Dir3::NEG_Z);
        let near = (entity(1), Vec3::new(0.01, 0.0, -2.0), 0.0);
        let far = (entity(2), Vec3::new(0.0, 0.0, -6.0), 0.0);
        let behind = (entity(3), Vec3::Z, 1.0);
        let beside = (entity(4), Vec3::new(1.0, 0.0, -2.0), 0.1);
        let picked = pick(ray, 0.04, [behind, far, beside, near].into_iter());
        assert_eq!(picked.map(|(entity, _)| entity), Some(near.0));
        assert!(pick(ray, 0.04, [behind, beside].into_iter()).is_none());
        let ball = (entity(5), Vec3::new(0.4, 0.0, -2.0), 0.5);
        assert!(pick(ray, 0.04, [ball].into_iter()).is_some(), "a ball is as wide as it is");
    }

    #[test]
    fn a_grabbed_crate_hangs_at_the_hand() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, crate::SinewPlugins));
        let step = app.world().resource::<Time<Fixed>>().timestep();
        app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(step));
        app.insert_resource(crate::AirDrag(0.9));
        app.finish();
        app.cleanup();
        let body = app
            .world_mut()
            .spawn((
                crate::ParticleBox::default().with_mass(20.0),
                Transform::from_xyz(0.0, 1.0, 0.0),
            ))
            .id();
        app.update();
        app.update();
        let corner = app.world().get::<BodyParticles>(body).unwrap().iter().last().unwrap();
        let target = Vec3::new(1.0, 4.0, 0.0);
        app.world_mut().resource_mut::<MouseDrag>().grabbed =
            Some(Grab { particle: corner, target });
        for _ in 0..300 {
            app.update();
        }
        let at = app.world().get::<Particle>(corner).unwrap().position;
        // It sags by g/ω² = 5 cm, and swings a little.
        assert!(at.distance(target) < 0.1, "{at}");
        let middle = app.world().get::<crate::Barycenter>(body).unwrap().position;
        assert!(middle.y < at.y, "it hangs from the hand");
    }
}
