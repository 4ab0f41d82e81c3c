//! Recipes turn a shape into particles and constraints. No engine is needed: [`Blueprint::build`] adds the result to a [`Simulation`](crate::Simulation), and a
//! plugin may spawn it as entities instead.
//!
//! Every recipe takes a `...Spec` with defaults, refuses what it cannot build with a [`RecipeFault`], and returns a [`Blueprint`] in the body's own
//! coordinates. The same spec gives the same bits on every machine: sums and lengths are computed in `f64` with plain arithmetic, sines with `libm`, and no
//! order depends on a hash.
//!
//! All lengths are measured in those coordinates, before the body is placed ([`Blueprint::transformed`]). So equal bodies have bitwise equal constraints
//! wherever they are, and the solver can process them as instances, side by side. A spec that contains points (the ends of a rope, bones) should give them in
//! coordinates that are the same for all such bodies; the distances of points that are rounded in world space differ.

mod articulated;
mod blueprint;
mod build;
mod cloth;
mod cloth_mesh;
mod fault;
mod limits;
mod mass;
mod mesh;
mod nearest;
mod ragdoll;
mod rope;
mod segments;
mod soft;
mod solid;
mod solid_box;

pub use crate::convex_hull::{ConvexHullFault, convex_hull};
pub use articulated::{ArticulatedSpec, Bone, Joint, articulated};
pub use blueprint::{Blueprint, BlueprintFault, Part};
pub use cloth::{ClothMaterial, ClothSpec, cloth_grid, grid_uvs};
pub use cloth_mesh::cloth_from_mesh;
pub use fault::RecipeFault;
pub use mass::{MassFault, MassProperties};
pub use mesh::{Fold, MeshFault, Piece, Weld, weld};
pub use ragdoll::{RagdollParticle, RagdollSpec, ragdoll};
pub use rope::{RopeSpec, rope};
pub use soft::{
    SoftLatticeSpec, SoftMeshSpec, SoftShape, SoftSurface, soft_lattice, soft_lattice_mesh,
    soft_mesh,
};
pub use solid::{Bulk, SolidLayout, SolidShape, SolidSpec, solid};
pub use solid_box::{BoxLayout, BoxSpec, box_2d, box_3d};

#[cfg(test)]
mod tests;
