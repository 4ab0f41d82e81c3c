//! Contact events of a step: collected contact by contact, then merged into one entry for each pair of participants.

use glam::Vec3;

/// A participant of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ContactParticipant {
    /// A body, by its index in [`Simulation::bodies`](crate::Simulation::bodies).
    Body(u32),
    /// A particle that belongs to no body, by its row.
    Particle(u32),
    /// A collider, by its index in [`Simulation::colliders`](crate::Simulation::colliders).
    Collider(u32),
    /// A plane of [`Boundaries`](crate::Boundaries), by its index there.
    Plane(u32),
    /// A box of [`Boundaries`](crate::Boundaries), by its index there.
    Box(u32),
}

/// Two participants that touched in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// The participant that comes first in the order of [`ContactParticipant`]: by kind, then by index.
    pub first: ContactParticipant,
    /// The other participant.
    pub second: ContactParticipant,
    /// The contact point, metres; of several contacts, that with the greatest impulse.
    pub point: Vec3,
    /// Unit contact normal at that point, from the second to the first.
    pub normal: Vec3,
    /// The total normal impulse on the first participant over the step, N·s. Zero from a sensor.
    pub impulse: f32,
    /// Whether one of the two is a sensor.
    pub sensor: bool,
}

/// Contact events of a step. Scratch while the step runs, then the report.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Impacts {
    /// One entry a contact; after [`merge`](Self::merge) one a pair, sorted by participants.
    list: Vec<Impact>,
    /// The greatest single impulse of each merged entry, N·s.
    greatest: Vec<f32>,
}

impl Impacts {
    /// Clears the events of the last step.
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

    /// Merges the contacts of each pair of participants, and sorts the pairs.
    pub(crate) fn merge(&mut self) -> &[Impact] {
        // Stable, so that contacts of one pair stay in the order in which they were added.
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
