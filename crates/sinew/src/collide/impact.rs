//! What has touched what in a step, for whoever wants to know: gathered contact by contact, and merged into one line for each two participants.

use glam::Vec3;

/// Who takes part in a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ContactParticipant {
    /// A body, by its number in [`Simulation::bodies`](crate::Simulation::bodies).
    Body(u32),
    /// A particle of no body, by its row.
    Particle(u32),
    /// A collider, by its number in [`Simulation::colliders`](crate::Simulation::colliders).
    Collider(u32),
    /// A plane of [`Boundaries`](crate::Boundaries), by its number there.
    Plane(u32),
    /// A box of [`Boundaries`](crate::Boundaries), by its number there.
    Box(u32),
}

/// Two participants that touched in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// The one with the lower number of its kind, in the order of [`ContactParticipant`].
    pub first: ContactParticipant,
    /// The other one.
    pub second: ContactParticipant,
    /// Where, metres; of several contacts the one with the greatest impulse.
    pub point: Vec3,
    /// Unit vector there, from the second to the first.
    pub normal: Vec3,
    /// What the first one got along the normals over the whole step, N·s. Zero from a sensor.
    pub impulse: f32,
    /// Whether one of them is a sensor.
    pub sensor: bool,
}

/// Impacts of a step. Scratch, and then the report.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Impacts {
    /// Contact by contact; merged in the end, sorted by their participants.
    list: Vec<Impact>,
    /// The greatest single impulse of each merged one.
    greatest: Vec<f32>,
}

impl Impacts {
    /// Forgets the last step.
    pub(crate) fn clear(&mut self) {
        self.list.clear();
    }

    /// Adds a contact that pushed `a` along `normal`, away from `b`, with an impulse in N·s.
    pub(crate) fn add(
        &mut self,
        [a, b]: [ContactParticipant; 2],
        point: Vec3,
        normal: Vec3,
        impulse: f32,
        sensor: bool,
    ) {
        let (first, second, normal) = if a <= b { (a, b, normal) } else { (b, a, -normal) };
        self.list.push(Impact { first, second, point, normal, impulse, sensor });
    }

    /// Merges those of the same two participants, and sorts them by who they are.
    pub(crate) fn merge(&mut self) -> &[Impact] {
        // Stable, so that equals stay in the order in which they came about.
        self.list.sort_by_key(|impact| (impact.first, impact.second));
        self.greatest.clear();
        let mut kept = 0;
        for i in 0..self.list.len() {
            let impact = self.list[i];
            let same = kept > 0 && {
                let last = &self.list[kept - 1];
                (last.first, last.second) == (impact.first, impact.second)
            };
            if !same {
                self.list[kept] = impact;
                self.greatest.push(impact.impulse);
                kept += 1;
                continue;
            }
            let (last, greatest) = (&mut self.list[kept - 1], &mut self.greatest[kept - 1]);
            last.impulse += impact.impulse;
            if impact.impulse > *greatest {
                *greatest = impact.impulse;
                (last.point, last.normal) = (impact.point, impact.normal);
            }
        }
        self.list.truncate(kept);
        &self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_of_the_same_two_become_one_with_the_strongest_ones_place() {
        let (ball, floor, box_) = (
            ContactParticipant::Body(3),
            ContactParticipant::Collider(0),
            ContactParticipant::Body(1),
        );
        let mut impacts = Impacts::default();
        impacts.add([ball, floor], Vec3::X, Vec3::Y, 1.0, false);
        impacts.add([floor, ball], Vec3::Z, Vec3::NEG_Y, 3.0, false);
        impacts.add([ball, box_], Vec3::ZERO, Vec3::X, 0.5, false);
        let merged = impacts.merge();
        assert_eq!(merged.len(), 2);
        assert_eq!((merged[0].first, merged[0].second), (box_, ball));
        assert_eq!(merged[0].normal, Vec3::NEG_X);
        assert_eq!((merged[1].impulse, merged[1].point, merged[1].normal), (4.0, Vec3::Z, Vec3::Y));
    }
}
