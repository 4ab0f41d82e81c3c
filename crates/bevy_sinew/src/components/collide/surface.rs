//! What surfaces are made of and which of them may touch: the same components on colliders, on bodies and on loose particles.

use bevy::prelude::*;
use sinew::{Layers, Material, PlanarDrag};

use crate::same::{same_fields, same_variants};

/// What the surface of a [`Collider`](super::Collider), a body or a loose particle is made of. Without it, the default.
///
/// A body with a broken number is as one without it, a collider is set aside; either is reported once.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Combine};
/// # fn spawn(mut commands: Commands) {
/// let rubber = SurfaceMaterial::new(1.0).with_restitution(0.7);
/// let ball = RigidMesh::density(900.0).shaped(RigidShape::Sphere { radius: 0.1 });
/// commands.spawn((ball, rubber, Transform::from_xyz(0.0, 2.0, 0.0)));
/// // Slippery for everything.
/// let ice = SurfaceMaterial::new(0.02).with_rules(Combine::Min, Combine::Average);
/// commands.spawn((Ground, ice));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct SurfaceMaterial {
    /// Coulomb's coefficient of friction μ, 0 (ice) and up. Default 0.5.
    pub friction: f32,
    /// Which part of its speed of approach it bounces back with, 0 (not at all) to 1 (all of it). Default 0.
    pub restitution: f32,
    /// How the friction of two surfaces is made of each one's. Default their average.
    pub friction_rule: Combine,
    /// How the restitution of two surfaces is made of each one's. Default their average.
    pub restitution_rule: Combine,
    /// The lectures' friction: shares of the velocity that what touches it loses per second. Of two surfaces the greater counts. Default none.
    pub drag: GroundDrag,
}

/// The lectures' friction of a [`SurfaceMaterial`]: a drag of its own along the surface and across it, for what touches it. Coulomb's friction acts
/// besides: set that to 0 by [`Combine::Min`] to have this alone.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct GroundDrag {
    /// Share of the velocity along the surface that is lost per second, 0 to 1. Default 0.
    pub along: f32,
    /// Share of the velocity towards it or away that is lost per second, 0 to 1. Default 0.
    pub across: f32,
}

/// How a coefficient of two surfaces is made of each one's. Where the two ask for different rules, the one later in this list counts.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum Combine {
    /// Half of their sum. The default.
    #[default]
    Average,
    /// The smaller of the two: ice is slippery for everyone.
    Min,
    /// Their product.
    Multiply,
    /// The greater of the two.
    Max,
}

/// Which things may touch: two of them do if each is a member of a layer that the other one collides with. 32 layers, a bit each. Without it, a member of layer 0
/// that collides with all.
///
/// ```
/// # use bevy_sinew::{CollisionLayer, CollisionLayers};
/// #[derive(CollisionLayer, Clone, Copy)]
/// enum Layer {
///     Wall,
///     Player,
///     Ghost,
/// }
/// let ghost = CollisionLayers::of_layers([Layer::Ghost], [Layer::Player]);
/// let player = CollisionLayers::of_layers([Layer::Player], [Layer::Wall, Layer::Ghost]);
/// assert!(ghost.meets(player) && !ghost.meets(CollisionLayers::default()));
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct CollisionLayers {
    /// Layers that it is in, a bit each. Default the first one, layer 0.
    pub memberships: u32,
    /// Layers that it collides with, a bit each. Default all.
    pub filters: u32,
}

/// A collision layer by a name: a variant of an enum that derives this, which makes it one of the layers 0 to 31.
pub trait CollisionLayer {
    /// Which layer it is, 0 to 31; others are no layers.
    fn number(&self) -> u32;
}

/// A [`Collider`](super::Collider) that only notices what touches it, and lets it through.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands) {
///     let goal = (Collider::cuboid(Vec3::new(3.0, 2.0, 1.0)), Sensor, ContactEvents::default());
///     commands.spawn(goal).observe(|on: On<ContactStarted>| println!("{} is in", on.other));
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Sensor;

impl Default for SurfaceMaterial {
    fn default() -> Self {
        let Material { friction, restitution, .. } = Material::default();
        Self {
            friction,
            restitution,
            friction_rule: Combine::default(),
            restitution_rule: Combine::default(),
            drag: GroundDrag::default(),
        }
    }
}

impl SurfaceMaterial {
    /// A surface with a coefficient of friction.
    pub fn new(friction: f32) -> Self {
        Self { friction, ..default() }
    }

    /// The same with another coefficient of friction.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// The same with another coefficient of restitution.
    pub fn with_restitution(self, restitution: f32) -> Self {
        Self { restitution, ..self }
    }

    /// The same with other rules for what comes of two surfaces: of friction, and of restitution.
    pub fn with_rules(self, friction_rule: Combine, restitution_rule: Combine) -> Self {
        Self { friction_rule, restitution_rule, ..self }
    }
}

same_fields!(
    SurfaceMaterial,
    Material { friction, restitution, friction_rule, restitution_rule, drag }
);
same_fields!(GroundDrag, PlanarDrag { along, across });
same_variants!(Combine, sinew::Combine { Average, Min, Multiply, Max });

impl Default for CollisionLayers {
    fn default() -> Self {
        let Layers { memberships, filters } = Layers::default();
        Self { memberships, filters }
    }
}

impl CollisionLayers {
    /// Touches nothing.
    pub const NONE: Self = Self { memberships: 0, filters: 0 };

    /// A member of the first of these layers that collides with the second of them, a bit each.
    pub const fn new(memberships: u32, filters: u32) -> Self {
        Self { memberships, filters }
    }

    /// The same from the numbers of the layers, 0 to 31; others are no layers.
    pub const fn of(memberships: &[u32], filters: &[u32]) -> Self {
        Self { memberships: bits(memberships), filters: bits(filters) }
    }

    /// The same from layers by their names.
    pub fn of_layers<M: CollisionLayer, F: CollisionLayer>(
        memberships: impl IntoIterator<Item = M>,
        filters: impl IntoIterator<Item = F>,
    ) -> Self {
        Self { memberships: named(memberships), filters: named(filters) }
    }

    /// A member of these layers, by their numbers, that collides with all.
    pub const fn in_layers(memberships: &[u32]) -> Self {
        Self { memberships: bits(memberships), filters: u32::MAX }
    }

    /// Whether the two may touch.
    pub const fn meets(self, other: Self) -> bool {
        self.layers().meets(other.layers())
    }

    /// The same for the solver.
    pub(crate) const fn layers(self) -> Layers {
        Layers::new(self.memberships, self.filters)
    }
}

fn named<L: CollisionLayer>(layers: impl IntoIterator<Item = L>) -> u32 {
    layers.into_iter().fold(0, |sum, layer| sum | bits(&[layer.number()]))
}

const fn bits(layers: &[u32]) -> u32 {
    let (mut bits, mut i) = (0, 0);
    while i < layers.len() {
        if layers[i] < u32::BITS {
            bits |= 1 << layers[i];
        }
        i += 1;
    }
    bits
}
