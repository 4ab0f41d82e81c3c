//! What solids have touched in a step, for the report.

use glam::Vec3;

use super::super::{Impacts, Party};
use super::bodies::CENTRE;
use super::{Solids, turn};
use crate::lanes::LANES;

/// A contact of this step that somebody listens to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told {
    pub(super) parties: [Party; 2],
    pub(super) point: Vec3,
    pub(super) normal: Vec3,
    /// N·s.
    pub(super) impulse: f32,
}

impl Solids {
    /// What has touched what.
    pub(crate) fn report(&mut self, impacts: &mut Impacts) {
        self.tell();
        for told in self.told.drain(..) {
            impacts.add(told.parties, told.point, told.normal, told.impulse, false);
        }
        for sensed in self.sensed.drain(..) {
            impacts.add(sensed.parties, sensed.point, sensed.normal, 0.0, true);
        }
    }

    /// How deep solids were in each other or in what stands when the last substep began, metres: the first row of each, and what the substep before has
    /// left.
    pub(crate) fn overlaps(&self) -> impl Iterator<Item = (u32, f32)> {
        let lanes = self.packs.iter().flat_map(|pack| pack.number.iter().zip(&pack.left));
        let deep = lanes.filter(|(_, left)| **left > 0.0);
        let groups = &self.groups;
        deep.flat_map(move |(&number, &left)| {
            let one = self.found.get(number as usize);
            let solids = one.map(|one| [Some(one.a), one.stand.is_none().then_some(one.b)]);
            let parts = solids.into_iter().flatten().flatten();
            parts.map(move |solid| {
                let first = groups.parts[solid as usize].entries.start;
                (groups.rows[first], left)
            })
        })
    }

    /// Notes what packs have done so far.
    pub(super) fn tell(&mut self) {
        let Self { found, packs, seen, bodies, groups, told, h, .. } = self;
        for pack in packs.iter_mut().filter(|pack| pack.kept) {
            for lane in 0..LANES {
                let Some(one) = found.get(pack.number[lane] as usize) else { continue };
                if !one.listened || pack.total[lane] <= 0.0 {
                    continue;
                }
                let vector = |v: &[turn::Eight; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
                let a = one.a as usize;
                let centre = bodies[groups.place(a)][CENTRE].truncate();
                let point = seen[a].origin + (centre + vector(&pack.arm));
                let (normal, impulse) = (vector(&pack.up), pack.total[lane] / *h);
                told.push(Told { parties: one.parties, point, normal, impulse });
            }
            pack.total = [0.0; LANES];
        }
        self.loose.tell(told, *h);
    }
}
