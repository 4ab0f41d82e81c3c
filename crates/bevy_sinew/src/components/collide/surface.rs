//! Surface materials and collision layers: the same components on colliders, on bodies and on loose particles.

use bevy::prelude::*;
use sinew::{Layers, Material, PlanarDrag};

use crate::same::{same_fields, same_variants};

/// Friction and restitution of the surface of a [`Collider`](super::Collider), a body or a loose particle. Without it, the default.
///
/// If a number is invalid, a body counts as without the component, and a collider is set aside; either is reported once.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Combine};
/// # fn spawn(mut commands: Commands) {
/// let rubber = SurfaceMaterial::new(1.0).with_restitution(0.7);
/// let ball = RigidMesh::density(900.0).shaped(RigidShape::Sphere { radius: 0.1 });
/// commands.spawn((ball, rubber, Transform::from_xyz(0.0, 2.0, 0.0)));
/// // Slippery for every material: the smaller friction applies.
/// let ice = SurfaceMaterial::new(0.02).with_rules(Combine::Min, Combine::Average);
/// commands.spawn((Ground, ice));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct SurfaceMaterial {
    /// Coulomb's coefficient of friction μ, 0 (ice) or more. Default 0.5.
    pub friction: f32,
    /// Coefficient of restitution: the fraction of the approach speed with which it bounces back, 0 (not at all) to 1 (all of it). Default 0.
    pub restitution: f32,
    /// How the friction of two surfaces is combined. Default the average.
    pub friction_rule: Combine,
    /// How the restitution of two surfaces is combined. Default the average.
    pub restitution_rule: Combine,
    /// Planar drag: the fraction of their velocity that touching bodies lose per second. Of two surfaces the greater value applies. Default none.
    pub drag: GroundDrag,
}

/// Planar drag of a [`SurfaceMaterial`] (the lectures' friction): damping of whatever touches the surface, along it and across it. It acts in addition to
/// Coulomb friction; to have it alone, set the friction to 0 with [`Combine::Min`].
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct GroundDrag {
    /// Fraction of the velocity along the surface that is lost per second, 0 to 1. Default 0.
    pub along: f32,
    /// Fraction of the velocity towards or away from the surface that is lost per second, 0 to 1. Default 0.
    pub across: f32,
}

/// How the coefficients of two surfaces are combined. If the two surfaces have different rules, the one that is later in this list applies.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum Combine {
    /// The average of the two. The default.
    #[default]
    Average,
    /// The smaller of the two: ice is slippery for everything.
    Min,
    /// Their product.
    Multiply,
    /// The greater of the two.
    Max,
}

/// Which entities may collide: two of them do if each is a member of a layer that the other's filter contains. There are 32 layers, one bit each. Without the
/// component, an entity is a member of layer 0 and collides with all layers.
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
/// assert!(ghost.interacts_with(player) && !ghost.interacts_with(CollisionLayers::default()));
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct CollisionLayers {
    /// Bit mask of the layers that it is a member of. Default layer 0.
    pub memberships: u32,
    /// Bit mask of the layers that it collides with. Default all.
    pub filters: u32,
}

/// A collision layer with a name: a variant of an enum that derives this trait, which assigns the layers 0 to 31 to its variants.
pub trait CollisionLayer {
    /// The number of the layer, 0 to 31; greater numbers are ignored.
    fn number(&self) -> u32;
}

/// A [`Collider`](super::Collider) that only reports overlaps and lets everything through.
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
    /// A surface with this coefficient of friction, and defaults otherwise.
    pub fn new(friction: f32) -> Self {
        Self { friction, ..default() }
    }

    /// Returns the same material with another coefficient of friction.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// Returns the same material with another coefficient of restitution.
    pub fn with_restitution(self, restitution: f32) -> Self {
        Self { restitution, ..self }
    }

    /// Returns the same material with other rules for combining friction, and restitution.
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
    /// No membership and an empty filter: it collides with nothing.
    pub const NONE: Self = Self { memberships: 0, filters: 0 };

    /// Layers from two bit masks.
    pub const fn new(memberships: u32, filters: u32) -> Self {
        Self { memberships, filters }
    }

    /// Layers from the numbers of layers, 0 to 31; greater numbers are ignored.
    pub const fn of(memberships: &[u32], filters: &[u32]) -> Self {
        Self { memberships: bits(memberships), filters: bits(filters) }
    }

    /// Layers from named layers.
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

    /// Whether the two may collide.
    pub const fn interacts_with(self, other: Self) -> bool {
        self.layers().interacts_with(other.layers())
    }

    /// The solver's layers.
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
