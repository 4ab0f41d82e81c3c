//! Anchors: places on a body or an entity where something is attached.

use bevy::prelude::*;

/// A place on an entity: which part of a body is attached, and where on the other entity ([`AttachTo`](super::AttachTo)).
///
/// Coordinates are in the entity's own frame, metres. The frame of a body is the one in which its recipe builds it, scaled as the entity is: a region of a
/// cloth stays the same however the cloth hangs now, and a point of a soft body or of a rope selects the particle that was built nearest to it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::RopeEnd;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let post = commands.spawn(Transform::from_xyz(0.0, 2.0, 0.0)).id();
/// // The upper left corner of a banner, by its position, and the first end of a rope.
/// let corner = Anchor::Point(Vec3::new(-0.5, 0.5, 0.0));
/// commands.spawn((Cloth::grid(1.0, 1.0, 8, 8), AttachTo::new(post).part(corner)));
/// let end = Anchor::RopeEnd(RopeEnd::First);
/// commands.spawn((Rope::default(), AttachTo::new(post).part(end)));
/// # }
/// ```
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Anchor {
    /// As a part of a body: all of its particles, each by itself. On the other entity: no particular place (see [`AttachTo::anchor`](super::AttachTo::anchor));
    /// with [`AttachTo::snap`](super::AttachTo::snap), its origin. The default.
    #[default]
    Whole,
    /// A point. On a rigid body any point, inside or outside of it; on any other body the particle that was built nearest to it.
    Point(Vec3),
    /// A corner of a box or of a limb ([`BodyPart`](crate::BodyPart)), selected by the signs of x, y and z. A zero selects the middle along that axis: of an
    /// edge, or of a face.
    Corner(Vec3),
    /// The particle that this vertex of the body's mesh follows ([`MeshFollow`](crate::MeshFollow)). On a body without one, the particle with this index in
    /// [`BodyParticles`](crate::BodyParticles).
    Vertex(u32),
    /// The particles that were built within a box along the axes of the frame.
    InBox {
        /// The box's centre, metres.
        center: Vec3,
        /// Half the box's size, metres.
        half_size: Vec3,
    },
    /// The particles that were built within a sphere.
    InSphere {
        /// The sphere's centre, metres.
        center: Vec3,
        /// The sphere's radius, metres.
        radius: f32,
    },
    /// An end of a rope.
    RopeEnd(RopeEnd),
    /// A point of a bone of a [`Ragdoll`](crate::Ragdoll) or an [`Articulated`](crate::Articulated) body.
    Bone {
        /// The bone's name: the `Name` of its [`BodyPart`](crate::BodyPart).
        name: String,
        /// The point in the bone's own frame, metres.
        point: Vec3,
    },
}

/// An end of a rope.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum RopeEnd {
    /// The start. The default.
    #[default]
    First,
    /// The end.
    Last,
}

impl Anchor {
    /// The middle of the bone with this name.
    pub fn bone(name: impl Into<String>) -> Self {
        Self::Bone { name: name.into(), point: Vec3::ZERO }
    }

    /// Whether all its numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        match self {
            Self::Whole | Self::Vertex(_) | Self::RopeEnd(_) => true,
            Self::Point(point) | Self::Corner(point) | Self::Bone { point, .. } => {
                point.is_finite()
            }
            Self::InBox { center, half_size } => center.is_finite() && half_size.is_finite(),
            Self::InSphere { center, radius } => center.is_finite() && radius.is_finite(),
        }
    }

    /// Whether a place is in the region of the anchor; `None` if the anchor is not a region.
    pub(super) fn contains(&self, place: Vec3) -> Option<bool> {
        match *self {
            Self::InBox { center, half_size } => {
                Some((place - center).abs().cmple(half_size.abs()).all())
            }
            Self::InSphere { center, radius } => Some(place.distance(center) <= radius),
            _ => None,
        }
    }
}
