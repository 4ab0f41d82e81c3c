//! Contacts (physics.md C10): collision detection and response, with friction and restitution.
//!
//! | file | what it is |
//! |---|---|
//! | `shape` | half-space, inverted box, sphere, capsule, box, cylinder, hull, mesh, heightfield: contacts of a moving sphere, rays, nearest points |
//! | `frame` | poses of rigid things |
//! | `material` | friction, restitution, layers; contact settings of a body |
//! | `collider` | static and kinematic shapes |
//! | `body_collider` | particles that collide as one, by a shape |
//! | `distance` | distances between points, segments and triangles |
//! | `features` | edges and triangles of bodies that collide by their surface, against shapes |
//! | `surface_point` | the point of such an edge or triangle that meets a shape |
//! | `filter` | which pairs may touch: layers, joints, settings of bodies |
//! | `nearby` | broad phase over whole bodies |
//! | `body_classes` | bodies that static geometry treats alike |
//! | `bounds` | planes and boxes that bound particles without bounce, drag, motion or events |
//! | `particle_contact` | single particles against colliders |
//! | `pairs` | particles against particles: grid, neighbour list, solve |
//! | `triangles` | particles against triangles, and edges against edges, for bodies that collide by their surface |
//! | `manifold` | contact manifolds of two shapes |
//! | `sweep` | shape casts along a straight line, and contacts within a distance |
//! | `body_contact` | compounds that collide by their shape, ropes by their segments |
//! | `friction` | Coulomb friction |
//! | `restitution` | the law of restitution |
//! | `pressed` | interface to large cloth under body colliders |
//! | `recovery` | maximum depenetration of a particle in a substep |
//! | `world` | the view of a world that all of them read |
//! | `stage` | contact state of a step, and the order of the passes |
//! | `impact` | contact events for the report |
//! | `words` | types with private fields as plain words, for serialisation |

mod body_classes;
mod body_collider;
mod body_contact;
mod bounds;
mod collider;
mod distance;
mod features;
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
mod surface_point;
mod sweep;
#[cfg(test)]
mod test_frames;
mod triangles;
mod words;
mod world;

pub use body_collider::{BodyCollider, BodyColliderFault};
pub use body_contact::{CachedManifold, ContactCache};
pub use collider::Collider;
pub use frame::Frame;
pub use impact::{ContactParticipant, Impact};
pub use material::{BodyContacts, Combine, CombinedMaterial, Layers, Material};
pub use shape::{Nearest, RayHit, Shape, ShapeFault, is_uniform};

pub(crate) use body_contact::{RigidStep, Written, half_spaces};
pub(crate) use filter::ContactFilter;
pub(crate) use friction::contact_correction;
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
