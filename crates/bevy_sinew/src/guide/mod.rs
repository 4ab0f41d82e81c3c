//! The guide: how the method works and how to use it, one chapter for each topic. The same chapters form an mdBook, `docs/guide` in the repository. The
//! pictures are screenshots of the gallery, the workspace's collection of scenes.
//!
//! Readers new to position-based dynamics start with [`method`], those who want a scene running with [`bodies`].
//!
//! | chapter | topic |
//! |---|---|
//! | [`method`] | how position-based dynamics works |
//! | [`bodies`] | cloth, ropes, soft bodies, ragdolls, boxes; particles of your own |
//! | [`contacts`] | what collides with what; surfaces, layers, events |
//! | [`forces`] | gravity, wind, water, charges |
//! | [`tuning`] | it stretches, it jitters, it tunnels, it is slow |
//! | [`units`] | units, and typical values for materials |
//! | [`determinism`] | the same bits everywhere; saving; networking |
//! | [`extending`] | a force, a constraint, a recipe of your own |
//! | [`coming_from`] | coming from Avian, rapier, Jolt or Obi |
//! | [`gallery`] | the scenes of the gallery, by the topics of the lectures |

macro_rules! chapters {
    ($($name:ident $file:literal),*) => {$(
        #[cfg_attr(doc, doc = sinew_derive::pictures!($file))]
        #[doc = include_str!($file)]
        pub mod $name {}
    )*};
}

chapters!(
    method "method.md", bodies "bodies.md", contacts "contacts.md", forces "forces.md", tuning "tuning.md", units "units.md",
    determinism "determinism.md", extending "extending.md", coming_from "coming_from.md", gallery "gallery.md"
);
