//! Surface materials (friction, restitution, drag), collision layers, and the contact settings of a body.

use crate::constraints::PlanarDrag;

/// The material of a surface. Two surfaces that touch combine to a [`CombinedMaterial`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Coulomb coefficient of friction μ, dimensionless, 0 (ice) or more. Default 0.5.
    pub friction: f32,
    /// Coefficient of restitution: the share of the approach speed that remains after a bounce, 0 (no bounce) to 1 (elastic). Default 0.
    pub restitution: f32,
    /// How the friction of two surfaces is combined. Default [`Combine::Average`].
    pub friction_rule: Combine,
    /// How the restitution of two surfaces is combined. Default [`Combine::Average`].
    pub restitution_rule: Combine,
    /// A velocity damping along and across the surface, for what touches it: single particles on static or kinematic geometry, and body colliders. Of two
    /// surfaces the greater value applies. Default none.
    pub drag: PlanarDrag,
}

/// How a coefficient of a contact is computed from those of the two surfaces. Where the two surfaces have different rules, the later one in this list applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Combine {
    /// The mean of the two. The default.
    #[default]
    Average,
    /// The smaller of the two: ice stays slippery under any other surface.
    Min,
    /// Their product.
    Multiply,
    /// The greater of the two.
    Max,
}

/// The combined surface properties of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CombinedMaterial {
    /// Coulomb coefficient of friction μ.
    pub friction: f32,
    /// Coefficient of restitution e.
    pub restitution: f32,
    /// Drag along and across the surface, shares of the velocity lost per second.
    pub drag: PlanarDrag,
}

impl Default for Material {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Material {
    const DEFAULT: Self = Self {
        friction: 0.5,
        restitution: 0.0,
        friction_rule: Combine::Average,
        restitution_rule: Combine::Average,
        drag: PlanarDrag { along: 0.0, across: 0.0 },
    };

    /// The same material with another coefficient of friction.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// The same material with another coefficient of restitution.
    pub fn with_restitution(self, restitution: f32) -> Self {
        Self { restitution, ..self }
    }

    /// Whether all values are finite and in range.
    pub fn is_valid(&self) -> bool {
        self.friction.is_finite()
            && self.friction >= 0.0
            && (0.0..=1.0).contains(&self.restitution)
            && self.drag.is_valid()
    }

    /// Combines this material with that of another surface.
    pub fn against(&self, other: &Self) -> CombinedMaterial {
        CombinedMaterial {
            friction: self.friction_rule.max(other.friction_rule).of(self.friction, other.friction),
            restitution: self
                .restitution_rule
                .max(other.restitution_rule)
                .of(self.restitution, other.restitution),
            drag: PlanarDrag {
                along: self.drag.along.max(other.drag.along),
                across: self.drag.across.max(other.drag.across),
            },
        }
    }
}

impl Combine {
    /// The combined coefficient of two surfaces.
    pub fn of(self, a: f32, b: f32) -> f32 {
        match self {
            Self::Average => 0.5 * (a + b),
            Self::Min => a.min(b),
            Self::Multiply => a * b,
            Self::Max => a.max(b),
        }
    }
}

/// Collision layers. Two things may touch if each is a member of a layer that the other collides with. 32 layers, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layers {
    /// Layers that it is a member of. Default the first.
    pub memberships: u32,
    /// Layers that it collides with. Default all.
    pub filters: u32,
}

impl Default for Layers {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Layers {
    const DEFAULT: Self = Self { memberships: 1, filters: u32::MAX };

    /// Collides with nothing.
    pub const NONE: Self = Self { memberships: 0, filters: 0 };

    /// A member of the layers `memberships` that collides with the layers `filters`.
    pub const fn new(memberships: u32, filters: u32) -> Self {
        Self { memberships, filters }
    }

    /// Whether two things with these layers may touch.
    #[inline]
    pub const fn interacts_with(self, other: Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}

/// The contact settings of a body: what it collides with, and how its surface behaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyContacts {
    /// The material of its surface.
    pub material: Material,
    /// Its collision layers.
    pub layers: Layers,
    /// Whether it collides with other bodies that do, too: rigid parts by their shape, other particles as balls of their radius. Default true.
    pub with_bodies: bool,
    /// Whether its particles collide with each other. Two that are closer than the sum of their radii in the rest shape keep their distance there instead.
    /// Default false.
    pub with_itself: bool,
    /// Whether it collides by the triangles of its surface ([`Forces::surfaces`](crate::Forces::surfaces)) in addition to its particles: neither particles
    /// nor shapes then pass through its mesh, however coarse it is. Among particles it costs about ten times as much as particles alone. Default false.
    pub surface: bool,
    /// Whether its contacts are listed in the report. Default false.
    pub events: bool,
    /// Whether it collides with nothing at all, not even colliders, planes and boxes. Default false.
    pub disabled: bool,
}

impl Default for BodyContacts {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl BodyContacts {
    /// Collides with everything but itself.
    pub(crate) const DEFAULT: Self = Self {
        material: Material::DEFAULT,
        layers: Layers::DEFAULT,
        with_bodies: true,
        with_itself: false,
        surface: false,
        events: false,
        disabled: false,
    };

    /// Whether it collides with anything dynamic.
    pub(crate) fn takes_part(&self) -> bool {
        !self.disabled && (self.with_bodies || self.with_itself)
    }

    /// Whether two bodies may touch, as far as no constraint between them prevents it.
    #[inline(always)]
    pub(crate) fn collides_with(&self, other: &Self) -> bool {
        self.with_bodies
            && other.with_bodies
            && !self.disabled
            && !other.disabled
            && self.layers.interacts_with(other.layers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_later_rule_of_two_counts() {
        let rubber = Material { friction: 1.0, ..Default::default() };
        let ice = Material { friction: 0.1, friction_rule: Combine::Min, ..Default::default() };
        assert_eq!(rubber.against(&ice).friction, 0.1);
        assert_eq!(rubber.against(&Material::default()).friction, 0.75);
        let sticky = Material { friction: 2.0, friction_rule: Combine::Max, ..Default::default() };
        assert_eq!(sticky.against(&ice).friction, 2.0);
        assert_eq!(ice.against(&sticky), sticky.against(&ice));
        assert_eq!(Combine::Multiply.of(0.5, 0.5), 0.25);
    }

    #[test]
    fn both_layers_must_include_each_other() {
        let (player, wall) = (Layers::new(1, 2), Layers::new(2, 1));
        assert!(player.interacts_with(wall) && wall.interacts_with(player));
        assert!(!player.interacts_with(player));
        assert!(
            !player.interacts_with(Layers::new(2, 4)),
            "only one of the two collides with the other"
        );
        assert!(Layers::default().interacts_with(Layers::default()));
        assert!(!Layers::NONE.interacts_with(Layers::default()));
    }

    #[test]
    fn invalid_numbers_are_detected() {
        assert!(Material::default().is_valid());
        for bad in [f32::NAN, -0.1, f32::INFINITY] {
            assert!(!Material::default().with_friction(bad).is_valid());
            assert!(!Material::default().with_restitution(bad).is_valid());
        }
        assert!(!Material::default().with_restitution(1.1).is_valid());
    }
}
