//! A custom constraint: marbles that stay on the surface of a doughnut, even where it overhangs. The constraint is a component of this program; one line
//! registers it, and the solver treats it like a built-in one.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::{ConstraintKind, Equation, Points};
use bevy_sinew::{Charge, SinewClock};
use bevy_sinew::{ParticleConstraint, RegisterParticleConstraint};

/// Keeps a particle on a torus around the z axis. It is plain data: add, change or despawn it while the game runs.
#[derive(Component, Clone)]
struct OnTorus {
    #[entities]
    particle: Entity,
    torus: Torus,
}

/// Major and minor radius, metres: from the centre to the middle of the tube, and from there to the surface.
#[derive(Clone, Copy, Debug)]
struct Torus(f32, f32);

impl ParticleConstraint for OnTorus {
    fn particles(&self) -> &[Entity] {
        core::slice::from_ref(&self.particle)
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::custom(self.torus)
    }
}

/// The constraint function: the signed distance of the particle from the surface, metres.
impl Equation for Torus {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let place = points.relative_to(0, Vec3::ZERO);
        // The nearest point on the circle in the middle of the tube. Straight away from it, the distance grows by one metre per metre: a unit gradient.
        let around = place.with_z(0.0).normalize_or(Vec3::X);
        let from_middle = place - around * self.0;
        gradients[0] = from_middle.normalize_or(around);
        from_middle.length() - self.1
    }

    fn is_length(&self) -> bool {
        true
    }
}

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins));
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.register_particle_constraint::<OnTorus>(); // All the registration it needs.
    app.add_systems(Startup, setup).add_systems(FixedUpdate, finish).run()
}

/// A row of marbles across the top of the tube, each with its own velocity. They slide down and swing; their charges repel each other.
fn setup(mut commands: Commands) {
    for side in (0..24).map(|i| (i as f32 - 11.5) / 11.5) {
        let marble = Particle::at(Vec3::new(0.2 * side, 1.4, 0.25 * side))
            .with_velocity(Vec3::new(2.0 * side, 0.0, 1.0));
        let particle = commands.spawn((marble, Mass(0.05), Charge(1.5e-6))).id();
        commands.spawn(OnTorus { particle, torus: Torus(1.0, 0.41) });
    }
}

/// After five seconds all marbles are still on the surface, and repulsion has left most of them on the lower half.
fn finish(clock: Res<SinewClock>, all: Query<&Particle>, mut exit: MessageWriter<AppExit>) {
    if clock.seconds < 5.0 {
        return;
    }
    let off = |p: Vec3| ((p.truncate().length() - 1.0).hypot(p.z) - 0.41).abs();
    let far = all.iter().map(|one| off(one.position)).fold(0.0, f32::max);
    let low = all.iter().filter(|one| one.position.y < 0.0).count();
    println!(
        "{low} of 24 marbles are on the lower half; the largest distance from the surface is {far:.6} m"
    );
    exit.write(if far < 1e-3 && low > 12 { AppExit::Success } else { AppExit::error() });
}
