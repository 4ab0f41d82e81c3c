//! The particles of the bones, which of them are shared, and the joint limits between them.

use core::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::{Bone, BonePoint, Joint, across};
use crate::constraints::{Cone, Constraint, ConstraintKind, Hinge};

/// The particles of a body of bones.
pub(super) struct Skeleton {
    pub(super) points: Vec<BonePoint>,
    /// The particles of each bone: head, tail, two in the middle, and those beside the joints that it carries.
    pub(super) members: Vec<Vec<u32>>,
    /// The particles of each rigid piece. A bone that is fixed to another one is included in that one's piece, and its own list is empty.
    pub(super) pieces: Vec<Vec<u32>>,
    /// The particle beside the joint of each bone; its head where there is none.
    sides: Vec<u32>,
}

/// A bone's own axes: y from the tail to the head, x sideways.
pub(super) struct BoneAxes {
    middle: DVec3,
    axes: [DVec3; 3],
}

/// Indices in a bone's list of particles.
const HEAD: usize = 0;
const TAIL: usize = 1;
const MIDDLE: usize = 2;
/// Shares of a bone's mass: ends and middle of a thin rod (Simpson's rule), and a share for each joint. Normalised by their sum.
const END: f64 = 1.0 / 6.0;
const HALF_MIDDLE: f64 = 1.0 / 3.0;
const BESIDE: f64 = 1.0 / 12.0;
/// A head within this distance of its parent's tail, as a share of the parent's width, coincides with it.
const SAME_PLACE: f32 = 0.05;

impl Skeleton {
    pub(super) fn of(bones: &[Bone]) -> Self {
        let mut skeleton =
            Self { points: Vec::new(), members: Vec::new(), pieces: Vec::new(), sides: Vec::new() };
        for bone in bones {
            skeleton.add(bones, bone);
        }
        skeleton.distribute_mass(bones);
        skeleton.merge_fixed(bones);
        skeleton
    }

    /// Adds the particles of a bone, and the shared ones to its parent.
    fn add(&mut self, bones: &[Bone], bone: &Bone) {
        let parent = bone.parent.filter(|_| bone.joint != Joint::Free);
        let frame = BoneAxes::of(bone);
        let half = frame.axes[0] * f64::from(bone.width) * 0.5;
        let head = match parent {
            Some(p) if bones[p].tail.distance(bone.head) <= SAME_PLACE * bones[p].width => {
                self.members[p][TAIL]
            }
            Some(p) if bones[p].head.distance(bone.head) <= SAME_PLACE * bones[p].width => {
                self.members[p][HEAD]
            }
            _ => self.point(bone.head.as_dvec3(), bone.width),
        };
        let tail = self.point(bone.tail.as_dvec3(), bone.width);
        let middle =
            [frame.middle + half, frame.middle - half].map(|place| self.point(place, bone.width));
        let mut own = vec![head, tail, middle[0], middle[1]];
        let mut side = head;
        if let Some(p) = parent {
            if !self.members[p].contains(&head) {
                self.members[p].push(head);
            }
            let at = bone.head.as_dvec3();
            let beside = match bone.joint {
                Joint::Hinge { axis, .. } => Some(axis.as_dvec3().normalize_or_zero()),
                Joint::Ball { twist, .. } if twist < PI => Some(frame.axes[0]),
                _ => None,
            };
            if let Some(direction) = beside {
                side = self.point(at + direction * f64::from(bone.width), bone.width);
                self.members[p].push(side);
            }
            if matches!(bone.joint, Joint::Hinge { .. }) {
                own.push(side);
            }
        }
        self.members.push(own);
        self.sides.push(side);
    }

    fn point(&mut self, place: DVec3, width: f32) -> u32 {
        self.points.push(BonePoint {
            position: place.as_vec3(),
            mass: 0.0,
            radius: 0.5 * width,
            pinned: false,
        });
        self.points.len() as u32 - 1
    }

    /// Distributes the masses.
    fn distribute_mass(&mut self, bones: &[Bone]) {
        for (bone, members) in bones.iter().zip(&self.members) {
            let share = |k: usize| match k {
                HEAD | TAIL => END,
                2 | 3 => HALF_MIDDLE,
                _ => BESIDE,
            };
            let all: f64 = (0..members.len()).map(share).sum();
            for (k, &i) in members.iter().enumerate() {
                let mass = f64::from(bone.mass) * share(k) / all;
                let point = &mut self.points[i as usize];
                point.mass += mass;
                point.pinned |= bone.pinned;
            }
        }
    }

    /// Merges bones that are fixed to each other into one piece.
    fn merge_fixed(&mut self, bones: &[Bone]) {
        let mut owner: Vec<usize> = Vec::new();
        for (number, bone) in bones.iter().enumerate() {
            let fixed = bone.parent.filter(|_| bone.joint == Joint::Fixed);
            owner.push(fixed.map_or(number, |parent| owner[parent]));
            self.pieces.push(Vec::new());
            for &i in &self.members[number] {
                let piece = &mut self.pieces[owner[number]];
                if !piece.contains(&i) {
                    piece.push(i);
                }
            }
        }
    }

    /// The limits of all joints.
    pub(super) fn limits(&self, bones: &[Bone]) -> Vec<Constraint> {
        let mut limits = Vec::new();
        for (number, bone) in bones.iter().enumerate() {
            let Some(parent) = bone.parent else { continue };
            let (own, side) = (&self.members[number], self.sides[number]);
            match bone.joint {
                Joint::Ball { cone, twist } => {
                    if cone < PI {
                        limits.extend(self.cone(&self.members[parent], own, cone));
                    }
                    if twist < PI {
                        limits.extend(self.turn(
                            [side, own[HEAD], own[TAIL], own[MIDDLE]],
                            -twist,
                            twist,
                        ));
                    }
                }
                Joint::Hinge { min, max, .. } if max - min < 2.0 * PI => {
                    let farthest = |members: &[u32]| self.farthest(own[HEAD], side, members);
                    let rows = [farthest(&self.members[parent]), own[HEAD], side, farthest(own)];
                    limits.extend(self.turn(rows, min, max));
                }
                _ => {}
            }
        }
        limits
    }

    /// Limits a bone to a cone about its direction at build time, in the frame of three particles of its parent: the head, and two that are far from it and far
    /// from collinear.
    fn cone(&self, parent: &[u32], own: &[u32], max: f32) -> Option<Constraint> {
        let at = |i: u32| self.points[i as usize].position;
        let head = own[HEAD];
        let others = || parent.iter().copied().filter(|&i| i != head);
        let away = |i: u32| at(i).distance_squared(at(head));
        let x = others().reduce(|best, i| if away(i) > away(best) { i } else { best })?;
        let y = self.farthest(head, x, parent);
        let cone = Cone::about(at(head), at(x), at(y), at(own[TAIL]) - at(head), max)?;
        Some(Constraint::new([head, x, y, own[TAIL]], ConstraintKind::Cone(cone)))
    }

    /// Limits the angle about the line through the second and third particle. `min` and `max` are relative to the present angle.
    fn turn(&self, rows: [u32; 4], min: f32, max: f32) -> Option<Constraint> {
        let now = Hinge::rest(rows.map(|i| self.points[i as usize].position)).min;
        let kind = ConstraintKind::Hinge(Hinge::between(now + min, now + max));
        let distinct = (0..4).all(|i| !rows[..i].contains(&rows[i]));
        distinct.then(|| Constraint::new(rows, kind))
    }

    /// The particle farthest from the line through two others; the first of equally far ones.
    fn farthest(&self, from: u32, to: u32, members: &[u32]) -> u32 {
        let at = |i: u32| self.points[i as usize].position.as_dvec3();
        let line = (at(to) - at(from)).normalize_or_zero();
        let away = |i: u32| line.cross(at(i) - at(from)).length_squared();
        let farther =
            |best: u32, i: u32| if away(i) > away(best) * (1.0 + 1e-6) { i } else { best };
        members.iter().copied().reduce(farther).unwrap_or(from)
    }
}

impl BoneAxes {
    /// For a hinge, x is along the component of the axis that is perpendicular to the bone.
    pub(super) fn of(bone: &Bone) -> Self {
        let (head, tail) = (bone.head.as_dvec3(), bone.tail.as_dvec3());
        let y = (head - tail).normalize_or_zero();
        let wanted = match bone.joint {
            Joint::Hinge { axis, .. } => {
                axis.as_dvec3().normalize_or_zero().reject_from_normalized(y)
            }
            _ => DVec3::ZERO,
        };
        // If less than a tenth of the axis is left, it does not define a direction.
        let x = if wanted.length() > 0.1 { wanted.normalize_or_zero() } else { across(y) };
        Self { middle: (head + tail) * 0.5, axes: [x, y, x.cross(y)] }
    }

    /// Coordinates of a point in the bone's axes, from the middle of the bone, metres.
    pub(super) fn local(&self, place: Vec3) -> Vec3 {
        let from = place.as_dvec3() - self.middle;
        let [x, y, z] = self.axes.map(|axis| axis.dot(from));
        DVec3::new(x, y, z).as_vec3()
    }
}
