//! Contacts (physics.md C10): what may not pass through what, with friction and restitution.
//!
//! | file | what it is |
//! |---|---|
//! | `shape` | plane, sphere, capsule, box, cylinder, hull, mesh, heightfield: made and measured with `parry3d` |
//! | `frame` | where something rigid is |
//! | `material` | friction, restitution, layers; what a body asks for |
//! | `collider` | shapes that stand still or that the game moves |
//! | `body_collider` | particles that collide as one, by a shape |
//! | `distance` | how near points, segments and triangles are to each other |
//! | `filter` | which things may touch: layers, joints, what bodies ask for |
//! | `nearby` | broad phase over whole bodies: which of them may come to touch another one |
//! | `body_classes` | bodies that static geometry treats alike |
//! | `bounds` | planes and boxes that hold particles without ado |
//! | `particle_contact` | single particles against colliders |
//! | `pairs` | particles against particles: a grid, and what is near enough in it |
//! | `triangles` | particles against triangles, and edges against edges, where a body asks for it: the finer tier |
//! | `manifold` | where two shapes touch |
//! | `sweep` | what a shape meets on a straight way, and what it is near |
//! | `body_contact` | compounds that collide by their shape, ropes by their segments |
//! | `friction` | Coulomb's law |
//! | `pressed` | what contacts ask of large cloth that body colliders press on |
//! | `restitution` | restitution: the one law of all contacts |
//! | `recovery` | how much of an overlap a particle is put out by in a substep |
//! | `world` | what all of them are told of a world |
//! | `stage` | all of it in its order |
//! | `impact` | what has touched what, for the report |
//! | `words` | what has private parts as plain words, to be stored |

mod body_classes;
mod body_collider;
mod body_contact;
mod bounds;
mod collider;
mod distance;
mod filter;
mod frame;
mod friction;
mod impact;
mod manifold;
mod material;
mod nearby;
mod pairs;
mod particle_contact;
mod pressed;
mod recovery;
mod restitution;
mod shape;
mod stage;
mod sweep;
mod triangles;
mod words;
mod world;

pub use body_collider::{BodyCollider, BodyColliderFault};
pub use body_contact::{CachedManifold, ContactCache};
pub use collider::Collider;
pub use frame::Frame;
pub use impact::{ContactParticipant, Impact};
pub use material::{BodyContacts, Combine, CombinedMaterial, Layers, Material};
pub use shape::{Nearest, RayHit, Shape, ShapeFault};

pub(crate) use body_contact::{RigidStep, Written, half_spaces};
pub(crate) use filter::ContactFilter;
pub(crate) use manifold::{Broad, ManifoldScratch, collide};
pub(crate) use particle_contact::{
    BatchContacts, InstantInterval, NormalImpulse, NormalImpulses, ParticleContacts,
};
pub(crate) use pressed::{Aggregate, PressedCloth, Push, ring_share};
pub(crate) use recovery::recovery;
pub(crate) use shape::Kind as ShapeKind;
pub(crate) use stage::Contacts;
pub(crate) use sweep::{AtStart, Obstacle, SweepHit, SweepMotion};
pub(crate) use world::World;
