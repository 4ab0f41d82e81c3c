//! Recipes as components: spawning one builds a body, changing it or replacing it by another one rebuilds the body, and despawning the entity removes it.

mod articulated;
mod bind;
mod bind_mesh;
mod build;
mod built;
mod cloth;
mod flat;
mod ragdoll;
mod rigid_box;
mod rigid_mesh;
mod rope;
mod soft;

pub(crate) use bind_mesh::MadeFrom;
pub(crate) use build::{AwaitsMesh, AwaitsPlace, Built, Rescaled};

pub(crate) use rope::TiedEnd;

pub use bind::bind;

pub use articulated::{Articulated, Bone, BoneJoint};
pub use built::BodyBuilt;
pub use cloth::{Cloth, ClothPins, ClothShape};
pub use ragdoll::Ragdoll;
pub use rigid_box::{BoxParticles, RigidBox};
pub use rigid_mesh::{Bulk, RigidMesh, RigidParticles, RigidShape};
pub use rope::{Rope, RopePoint, RopeTie};
pub use soft::{SoftBody, SoftShape};

use bevy::prelude::*;

use crate::changes::any_body_may_have_moved;
use crate::schedule::{SinewSystems, SinewTick};

/// Functions of all recipes: the body of an entity may have been built from another recipe than the one that it has now.
macro_rules! all_recipes {
    ($($recipe:ty),*) => {
        /// The components that the last build of a body added.
        fn built_defaults(body: &EntityWorldMut) -> build::Defaults {
            None$(.or_else(|| build::recipe_defaults::<$recipe>(body)))*.cloned().unwrap_or_default()
        }

        /// Removes what the plugin keeps of recipes that a body no longer has.
        fn forget_replaced(body: &mut EntityWorldMut) {
            $(build::forget_recipe::<$recipe>(body);)*
        }
    };
}

all_recipes!(Cloth, SoftBody, Ragdoll, Articulated, RigidMesh, RigidBox, Rope);

/// Adds the systems that build the recipes.
pub(crate) fn add(app: &mut App) {
    app.init_resource::<built::JustBuilt>().add_message::<BodyBuilt>();
    // In sequence: the order in which bodies of one tick are numbered must not depend on the executor.
    app.add_systems(
        SinewTick,
        (
            build::notice_flatland,
            build::notice_scale
                .run_if(any_body_may_have_moved.or_else(any_with_component::<build::AwaitsPlace>)),
            // Large bodies first: when something is despawned or cut, everything that was created after it is laid out and compiled again.
            build::build::<Cloth>,
            build::build::<SoftBody>,
            build::build::<Ragdoll>,
            build::build::<Articulated>,
            build::build::<RigidMesh>,
            build::build::<RigidBox>,
            build::build::<Rope>,
            build::build_waiting::<Rope>,
            built::send_built,
        )
            .chain()
            .in_set(SinewSystems::Build),
    );
}
