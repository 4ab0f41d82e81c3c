//! Wide contact constraint: eight manifolds side by side, as contacts are solved; and how long a manifold is valid while the two turn and slide on
//! each other.

use super::super::manifold::Manifold;
use super::turn::{LaneArray, store};
use crate::lanes::{LANES, Lanes, Vector};

/// As good as infinitely far out, metres: what a missing point is.
pub(super) const FAR: f32 = 1e9;

/// The angle that two may turn against each other before they are compared again, rad.
const TURNED: f32 = 0.02;
/// The same for how far they may slide on each other, as a share of their size.
const SLID: f32 = 0.03;
/// How much further what is round may turn: about the centre of the rounding that moves nothing, and its points are no farther from there than it is long.
const ROUND: f32 = 2.5;
/// How much faster a manifold becomes stale whose [slope](Manifold::slope) is 1. Its points are points of the two, and as one slides over the rim of
/// the other it touches with others, that are higher by the slope times the way: so that must be less, and no height is wrong by more than `SLID /
/// STEEP` of the size. Without that a box fell half a millimetre deep into a rim that its manifold did not know of, and was thrown out of it, again
/// and again, for minutes; three times as much finds a tenth more manifolds in a heap of boxes in random poses, for nothing.
const STEEP: f32 = 100.0;

/// Torsional patch radius of everything, as a share of its size. What touches in a point has no arm to stop a turn on it with, in numbers; of any
/// stuff there is one, and a box that stands on a corner, or hangs between two, does not turn about that for ever.
pub(super) const TORSIONAL_RADIUS: f32 = 0.01;

/// The angle that the two of a manifold may turn against each other, rad.
pub(super) fn may_turn(manifold: &Manifold) -> f32 {
    if manifold.is_round() { ROUND * TURNED } else { TURNED }
}

/// How far the two of a manifold may slide on each other, metres, of a size; no farther than that.
pub(super) fn may_slide(manifold: &Manifold, size: f32) -> f32 {
    manifold.free.min(size).max(SLID * size)
}

/// How much faster than others a manifold becomes stale.
pub(super) fn staleness_rate(manifold: &Manifold) -> f32 {
    1.0 + STEEP * manifold.slope
}

/// Eight manifolds that have no solid in common; on lines of the cache of its own, because an eight that lies across two of them costs twice as much.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct WideContact {
    /// Rows of the bodies that are pushed along the normal, and of those that are pushed back.
    pub(super) a: [u32; LANES],
    pub(super) b: [u32; LANES],
    /// Which of the manifolds that were found it is.
    pub(super) number: [u32; LANES],
    /// Whether all of the second ones stay where they are in this step: then nothing of them is asked. Most of what lies somewhere lies on such, and
    /// of all that is reckoned for two bodies half is for the second one.
    pub(super) fixed: bool,
    /// How often they are pressed in a substep, 1 and up: see `mass_ratio`.
    pub(super) sweeps: u32,
    /// In the second one's axes; in the world's if that stays where it is, and in the first one's if the second one is round and the first one is not:
    /// a normal turns with the face, and not with the ball on it. Of two that are round it follows from where they are.
    pub(super) normal: [LaneArray; 3],
    /// Radii of what is round, metres: see [`Manifold::radii`].
    pub(super) radii: [LaneArray; 2],
    /// Whether the second one of any is round.
    pub(super) round: bool,
    /// A bit for each manifold whose first one, and whose second one, is round about its own y axis alone: see [`Manifold::axial`].
    pub(super) axial: [u32; 2],
    /// [Anchors](Manifold::anchors) from the centres, in their own axes, metres; the second one's in the world's if that stays where it is.
    pub(super) on_a: [[LaneArray; 3]; 4],
    pub(super) on_b: [[LaneArray; 3]; 4],
    /// Added to the distance of each point, metres: none for one that is there.
    pub(super) missing: [LaneArray; 4],
    /// From the first one's origin to the second one's, metres.
    pub(super) offset: [LaneArray; 3],
    pub(super) friction: LaneArray,
    /// One by the length that the two may slide on each other before they are compared again, 1/m.
    pub(super) stiff: LaneArray,
    /// One by the angle that they may turn against each other before that, 1/rad.
    pub(super) bent: LaneArray,
    /// By how much more than the staleness says, times what they may slide, others of their points may have come nearer than those of the manifold: a
    /// turn of `φ` takes these away by up to `r φ` and others there by as much.
    pub(super) elsewhere: LaneArray,
    /// How much faster than others they become stale by that, and by turning: [`staleness_rate`].
    pub(super) staleness_rate: LaneArray,
    /// How much they have turned and slid since they were compared: 1 is as much as they may, where they touch.
    pub(super) staleness: LaneArray,
    /// How far apart the nearest of their points will be if they go on as in the last substep, by how far they may slide; 0 where that is not known.
    pub(super) predicted_gap: LaneArray,
    /// The arm at which friction acts against turning on what is a point, metres: [`TORSIONAL_RADIUS`] of its size, if its particles are nobody
    /// else's.
    pub(super) torsional_radius: LaneArray,
    /// How much of the arm is the first one's anchor: 1 if the second one stands, or the first one alone is round, for a ball touches a face where the ball is;
    /// none if the second one alone is; else a half.
    pub(super) own: LaneArray,
    /// Whether approach and place are to be kept: something bounces, or somebody listens.
    pub(super) kept: bool,
    /// A bit for each manifold with a restitution: what it recovers of an overlap never turns into speed, but for what a load needs.
    pub(super) elastic: u32,
    /// A bit for each manifold where more overlap was recovered in this substep than may turn into speed, or one of whose body colliders comes from
    /// where that was.
    pub(super) depenetrated: u32,
    /// Of the substep: impulses of the points, kg·m.
    pub(super) force: [LaneArray; 4],
    /// Their speeds before contacts, m/s; negative when approaching. [`FAR`] for what touches nothing.
    pub(super) approach: [LaneArray; 4],
    /// Normal in the world, and the centre of pressure from the first one's centre, metres.
    pub(super) up: [LaneArray; 3],
    pub(super) arm: [LaneArray; 3],
    /// How far the points are from there; and the sum of their impulses, kg·m.
    pub(super) radius: LaneArray,
    pub(super) sum: LaneArray,
    /// Against how much of such a sum friction has acted in this substep, before it was pressed; and may act in the next: a mean of the last ones.
    pub(super) friction_limit_used: LaneArray,
    pub(super) friction_limit: LaneArray,
    /// How far what sticks is from where it stuck, metres, and has turned about the normal, rad: pressing moved it after it was held,
    /// and joints took a part of what held it (`constraint_residual`).
    pub(super) accumulated_slip: [LaneArray; 4],
    /// A bit for each manifold that sticks.
    pub(super) sticking: u32,
    /// Of the step: sum of the impulses, kg·m.
    pub(super) total: LaneArray,
    /// How deep the points that press were in when the substep began, metres: what the one before has left.
    pub(super) left: LaneArray,
}

impl WideContact {
    /// One without manifolds; `nothing` is the row of nothing.
    pub(super) fn empty(nothing: u32, fixed: bool, sweeps: u32) -> Self {
        let (none, vector) = ([0.0; LANES], [[0.0; LANES]; 3]);
        Self {
            a: [nothing; LANES],
            b: [nothing; LANES],
            number: [u32::MAX; LANES],
            fixed,
            sweeps,
            normal: vector,
            radii: [none; 2],
            round: false,
            axial: [0; 2],
            on_a: [vector; 4],
            on_b: [vector; 4],
            missing: [[FAR; LANES]; 4],
            offset: vector,
            friction: none,
            stiff: none,
            bent: none,
            elsewhere: none,
            staleness_rate: none,
            staleness: none,
            predicted_gap: none,
            torsional_radius: none,
            own: none,
            kept: false,
            elastic: 0,
            depenetrated: 0,
            force: [none; 4],
            approach: [[FAR; LANES]; 4],
            up: vector,
            arm: vector,
            radius: none,
            sum: none,
            friction_limit_used: none,
            friction_limit: none,
            accumulated_slip: [none; 4],
            sticking: 0,
            total: none,
            left: none,
        }
    }
}

impl WideContact {
    /// What lets go for a substep is held at its centre meanwhile: friction at an edge that has lifted would rock it, and it rocks on for minutes.
    #[inline(always)]
    pub(super) fn let_go<L: Lanes>(&mut self, normal: Vector<L>) {
        self.radius = [0.0; LANES];
        self.arm = [[0.0; LANES]; 3];
        store(normal, &mut self.up);
    }
}
