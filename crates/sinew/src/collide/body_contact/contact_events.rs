//! Contact events: what body colliders have touched in a step, for the report.

use glam::Vec3;

use super::super::{ContactParticipant, Impacts};
use super::bodies::CENTRE;
use super::{BodyContactSolver, turn};
use crate::lanes::LANES;

/// A contact of this step that somebody listens to.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactEvent {
    pub(super) participants: [ContactParticipant; 2],
    pub(super) point: Vec3,
    pub(super) normal: Vec3,
    /// N·s.
    pub(super) impulse: f32,
}

impl BodyContactSolver {
    /// What has touched what.
    pub(crate) fn report(&mut self, impacts: &mut Impacts) {
        self.note_contact_events();
        for contact_events in self.contact_events.drain(..) {
            impacts.add(
                contact_events.participants,
                contact_events.point,
                contact_events.normal,
                contact_events.impulse,
                false,
            );
        }
        for sensor_overlaps in self.sensor_overlaps.drain(..) {
            impacts.add(
                sensor_overlaps.participants,
                sensor_overlaps.point,
                sensor_overlaps.normal,
                0.0,
                true,
            );
        }
    }

    /// How deep body colliders were in each other or in static geometry when the last substep began, metres: the first row of each, and what the
    /// substep before has left.
    pub(crate) fn overlaps(&self) -> impl Iterator<Item = (u32, f32)> {
        let lanes = self.wide_contacts.iter().flat_map(|wide| wide.number.iter().zip(&wide.left));
        let deep = lanes.filter(|(_, left)| **left > 0.0);
        let groups = &self.groups;
        deep.flat_map(move |(&number, &left)| {
            let one = self.contacts.get(number as usize);
            let body_colliders =
                one.map(|one| [Some(one.a), one.geometry.is_none().then_some(one.b)]);
            let parts = body_colliders.into_iter().flatten().flatten();
            parts.map(move |solid| {
                let first = groups.parts[solid as usize].entries.start;
                (groups.rows[first], left)
            })
        })
    }

    /// Adds the contact events of the wide contacts so far.
    pub(super) fn note_contact_events(&mut self) {
        let Self { contacts, wide_contacts, swept, bodies, groups, contact_events, h, .. } = self;
        for wide in wide_contacts.iter_mut().filter(|wide| wide.kept) {
            for lane in 0..LANES {
                let Some(one) = contacts.get(wide.number[lane] as usize) else { continue };
                if !one.reports_events || wide.total[lane] <= 0.0 {
                    continue;
                }
                let vector =
                    |v: &[turn::LaneArray; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
                let a = one.a as usize;
                let centre = bodies[groups.place(a)][CENTRE].truncate();
                let point = swept[a].origin + (centre + vector(&wide.arm));
                let (normal, impulse) = (vector(&wide.up), wide.total[lane] / *h);
                contact_events.push(ContactEvent {
                    participants: one.participants,
                    point,
                    normal,
                    impulse,
                });
            }
            wide.total = [0.0; LANES];
        }
        self.loose.note_contact_events(contact_events, *h);
    }
}
