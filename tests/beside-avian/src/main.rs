//! A game that glob-imports the preludes of Bevy, Avian 0.7 and Sinew, with the aliases that the crate docs of `bevy_sinew` list. If a name of Sinew clashes
//! with one of Avian that is not on that list, this does not compile. Run it by hand when a name of the prelude or Avian's version changes:
//!
//! `cargo check --manifest-path tests/beside-avian/Cargo.toml`

// A name that two globs import may be no more than a warning.
#![deny(warnings)]

// The lists as in the crate docs.
use avian3d::prelude::*;
use avian3d::prelude::{
    AngularVelocity, Collider, CollisionLayers, Gravity, GravityScale, LinearVelocity, Mass, Sensor,
};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AngularVelocity as SinewAngularVelocity, Collider as SinewCollider,
    CollisionLayers as SinewLayers, Gravity as SinewGravity, GravityScale as SinewGravityScale,
    LinearVelocity as SinewLinearVelocity, Mass as SinewMass, Sensor as SinewSensor,
};

/// Every name of Sinew's prelude, and the names that Avian shares with it. A name that two globs import is ambiguous where it is used.
mod names {
    use super::*;

    pub fn of<T: ?Sized>() -> &'static str {
        core::any::type_name::<T>()
    }

    pub fn ours() -> Vec<&'static str> {
        vec![
            of::<(SinewPlugins, SolverConfig, SinewGravity, AirDrag, Ground, BoundingBox)>(),
            of::<(SinewControl, SinewWorld, SinewQuery, Interpolate, SinewGravityScale)>(),
            of::<(Particle, SinewMass, Radius, Pinned, PinnedTo, DistanceConstraint, Spring)>(),
            of::<(Softness, RigidBox, RigidMesh, RigidShape, Rope, Cloth, ClothPins, SoftBody)>(),
            of::<(Ragdoll, Wind, Fluid, Floats, ExternalForce, ExternalImpulse, ExternalTorque)>(),
            of::<(SinewLinearVelocity, SinewAngularVelocity, SinewCollider, SurfaceMaterial)>(),
            of::<(SinewLayers, SinewSensor, ContactEvents, ContactStarted, ContactEnded, Sleep)>(),
            of::<(Anchor, AttachTo, BodyBuilt, BreakAt, Broke)>(),
        ]
    }

    /// Traits of the prelude: their methods resolve beside Avian's.
    pub fn traits(mut commands: Commands, bodies: Query<Entity, With<RigidBox>>) {
        for body in &bodies {
            commands.entity(body).apply_impulse(Vec3::Y);
        }
        commands.relax_world();
    }

    pub fn theirs() -> Vec<&'static str> {
        vec![
            of::<(PhysicsPlugins, RigidBody, Collider, CollisionLayers, Sensor, Mass, Gravity)>(),
            of::<(LinearVelocity, AngularVelocity, GravityScale, SubstepSchedule, Friction)>(),
            of::<(DistanceJoint, RevoluteJoint, SphericalJoint, FixedJoint, Position, Rotation)>(),
            of::<(SubstepCount, Physics, ConstantForce, CollisionStart, CollisionEnd)>(),
        ]
    }
}

fn main() {
    for name in names::ours().into_iter().chain(names::theirs()) {
        println!("{name}");
    }
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPlugins));
    app.add_systems(Startup, |mut commands: Commands| {
        // One entity of each kind, in one world.
        commands.spawn((
            RigidBody::Static,
            Collider::cuboid(4.0, 0.2, 4.0),
            CollisionLayers::default(),
        ));
        commands.spawn((SinewCollider::cuboid(Vec3::ONE), SinewLayers::default()));
        commands.spawn((RigidBox::new(Vec3::ONE), Transform::from_xyz(0.0, 3.0, 0.0)));
    });
    app.add_systems(Update, names::traits);
    app.finish();
    app.update();
}
