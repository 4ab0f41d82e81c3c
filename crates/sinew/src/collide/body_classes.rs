//! Body classes: bodies with the same material, layers and event flag, which all static geometry treats alike.
//! There are few classes, so what holds between a class and a plane (filter result, combined material) is computed once per class and not once per particle.

use super::filter::ContactFilter;
use super::material::{BodyContacts, Layers, Material};
use crate::particles::Particles;

/// The properties that all bodies of a class share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BodyClass {
    pub(super) material: Material,
    pub(super) layers: Layers,
    /// Whether contacts of these bodies are listed in the report.
    pub(super) events: bool,
}

/// The body classes of a step and the class of each body and row. Rebuilt only when something changes; a function of the current state alone, not of history.
#[derive(Clone, Debug, Default)]
pub(super) struct BodyClasses {
    /// Entry 0 is the class of [`BodyContacts::DEFAULT`], which rows without a body belong to.
    classes: Vec<BodyClass>,
    of_body: Vec<u32>,
    /// Class of each row; empty where all rows are of class 0.
    of_row: Vec<u32>,
    /// [Edits](Particles::edits) and number of the particles when `of_row` was last built.
    built_for: Option<(u64, usize)>,
}

impl BodyClass {
    fn of(body: &BodyContacts) -> Self {
        let BodyContacts { material, layers, events, .. } = *body;
        Self { material, layers, events }
    }
}

impl BodyClasses {
    /// Assigns the bodies of a step to classes.
    pub(super) fn update(&mut self, filter: &ContactFilter, particles: &Particles) {
        let bodies = filter.bodies();
        let same = !self.classes.is_empty()
            && self.of_body.len() == bodies.len()
            && self.of_body.iter().zip(bodies).all(|(&class, body)| {
                self.classes.get(class as usize) == Some(&BodyClass::of(body))
            });
        let now = (particles.edits(), particles.len());
        if same && self.built_for == Some(now) {
            return;
        }
        self.built_for = Some(now);
        if !same {
            self.classes.clear();
            self.classes.push(BodyClass::of(&BodyContacts::DEFAULT));
            self.of_body.clear();
            let mut last = 0;
            for body in bodies {
                let class = BodyClass::of(body);
                if self.classes[last] != class {
                    last = self.classes.iter().position(|&one| one == class).unwrap_or_else(|| {
                        self.classes.push(class);
                        self.classes.len() - 1
                    });
                }
                self.of_body.push(last as u32);
            }
        }
        self.of_row.clear();
        if self.classes.len() > 1 {
            let class = |&body: &u32| self.of_body.get(body as usize).copied().unwrap_or(0);
            self.of_row.extend(particles.body.iter().map(class));
        }
    }

    /// All classes.
    pub(super) fn all(&self) -> &[BodyClass] {
        &self.classes
    }

    /// The class of a row.
    #[inline(always)]
    pub(super) fn of(&self, row: u32) -> usize {
        self.of_row.get(row as usize).map_or(0, |&class| class as usize)
    }

    /// The class of all rows, if there is only one.
    #[inline]
    pub(super) fn common(&self) -> Option<usize> {
        self.of_row.is_empty().then_some(0)
    }

    /// The class of these rows, if they all have the same one.
    pub(super) fn of_all(&self, rows: core::ops::Range<u32>) -> Option<usize> {
        let class = self.of(rows.start);
        let listed = self.of_row.get(rows.start as usize..rows.end as usize).unwrap_or_default();
        listed.iter().all(|&one| one as usize == class).then_some(class)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ParticleSeed;

    #[test]
    fn bodies_that_are_alike_are_of_one_class_and_those_that_change_change_theirs() {
        let mut particles = Particles::default();
        for body in [0, 1, 2, 2, 7] {
            let row = particles.push(ParticleSeed::at(glam::Vec3::ZERO)).unwrap();
            particles.set_body(row as usize, Some(body));
        }
        let ice = BodyContacts {
            material: Material::default().with_friction(0.0),
            ..BodyContacts::default()
        };
        let mut bodies = vec![BodyContacts::default(), ice, ice];
        let mut classes = BodyClasses::default();
        classes.update(&ContactFilter::untied(&bodies), &particles);
        let of = |classes: &BodyClasses| [0, 1, 2, 3, 4].map(|row| classes.of(row));
        assert_eq!(of(&classes), [0, 1, 1, 1, 0]);
        assert_eq!((classes.of_all(1..4), classes.of_all(0..2)), (Some(1), None));
        assert_eq!(classes.all()[1].material.friction, 0.0);
        bodies[2].layers = Layers::NONE;
        classes.update(&ContactFilter::untied(&bodies), &particles);
        assert_eq!(of(&classes), [0, 1, 2, 2, 0]);
        bodies = vec![BodyContacts::default(); 3];
        classes.update(&ContactFilter::untied(&bodies), &particles);
        assert_eq!((of(&classes), classes.all().len()), ([0; 5], 1));
        assert_eq!(classes.of_all(0..5), Some(0));
    }
}
