//! Velocities that a game spawned or changed, and impulses, as components.

use bevy::prelude::*;

use crate::changes::count_and_changed;
use crate::commands::{BodyEdit, Editor};
use crate::components::{
    AngularVelocity, BodyParticles, CreationOrder, ExternalImpulse, ExtractedVelocity,
    LinearVelocity, Particle, RigidPose, Sleep,
};
use crate::messages::{EditFault, Refusal, Refused, refuse};

/// The requested edits, in the order of creation.
type Request = (Option<CreationOrder>, Entity, BodyEdit);

/// A velocity was written, by the game or by the last tick. (For a sleeping body it is not.)
type VelocityWritten =
    Or<(Changed<LinearVelocity>, Changed<AngularVelocity>, Changed<ExtractedVelocity>)>;

/// Entities with velocities: bodies, and single particles.
type HasVelocity = Or<(With<BodyParticles>, With<Particle>)>;

/// Run condition: whether a velocity was written, or extracted.
pub(crate) fn any_velocity_changed(
    linear: Query<Ref<LinearVelocity>, HasVelocity>,
    angular: Query<Ref<AngularVelocity>, HasVelocity>,
    known: Query<Ref<ExtractedVelocity>, HasVelocity>,
) -> bool {
    count_and_changed(&linear).1 || count_and_changed(&angular).1 || count_and_changed(&known).1
}

/// Applies the velocities that a game spawned with bodies and single particles, or has changed since the last tick.
///
/// A velocity that is not finite is refused and reset to that of the body.
pub(crate) fn follow_velocities(
    mut written: ParamSet<(
        Query<
            (
                Entity,
                Option<&CreationOrder>,
                &mut LinearVelocity,
                // A particle has none: it is a point.
                Option<&mut AngularVelocity>,
                &mut ExtractedVelocity,
                Option<&mut Sleep>,
            ),
            (HasVelocity, VelocityWritten),
        >,
        Editor,
    )>,
    mut messages: MessageWriter<Refused>,
    mut requests: Local<Vec<Request>>,
) {
    requests.clear();
    for (entity, order, linear, angular, mut known, sleep) in &mut written.p0() {
        let now = (linear.0, angular.as_ref().map_or(Vec3::ZERO, |angular| angular.0));
        let edits = BodyEdit::of_written(now, known.0);
        if edits == [None, None] {
            continue;
        }
        let mut linear = linear;
        let order = order.copied();
        if now.0.is_finite() && now.1.is_finite() {
            known.0 = Some(now);
        } else {
            let last = known.0.unwrap_or_default();
            linear.0 = last.0;
            if let Some(mut angular) = angular {
                angular.0 = last.1;
            }
        }
        requests.extend(edits.into_iter().flatten().map(|edit| (order, entity, edit)));
        if let Some(mut sleep) = sleep {
            sleep.wake();
        }
    }
    carry_out(&mut requests, &mut written.p1(), &mut messages);
}

/// Applies the impulses that a game has put on bodies, rigid parts and particles, and resets them.
pub(crate) fn apply_impulses(
    mut pushed: Query<
        (Entity, Option<&CreationOrder>, &mut ExternalImpulse, Option<&mut Sleep>),
        Or<(With<BodyParticles>, With<RigidPose>, With<Particle>)>,
    >,
    mut editor: Editor,
    mut messages: MessageWriter<Refused>,
    mut requests: Local<Vec<Request>>,
) {
    requests.clear();
    for (entity, order, mut pushed, sleep) in &mut pushed {
        if *pushed == ExternalImpulse::default() {
            continue;
        }
        let ExternalImpulse { impulse, angular_impulse, point } = core::mem::take(&mut *pushed);
        let push = match point {
            Some(point) => BodyEdit::ImpulseAt(impulse, point),
            None => BodyEdit::Impulse(impulse),
        };
        requests.push((order.copied(), entity, push));
        if angular_impulse != Vec3::ZERO {
            requests.push((order.copied(), entity, BodyEdit::AngularImpulse(angular_impulse)));
        }
        if let Some(mut sleep) = sleep {
            sleep.wake();
        }
    }
    carry_out(&mut requests, &mut editor, &mut messages);
}

/// Executes the edits, body by body in the order of creation; an edit that fails is refused.
fn carry_out(requests: &mut [Request], editor: &mut Editor, messages: &mut MessageWriter<Refused>) {
    // A stable sort: the edits of one body stay in order.
    requests.sort_by_key(|&(order, entity, _)| (order, entity));
    for &(_, entity, edit) in &*requests {
        let fault = match editor.apply(entity, edit) {
            Ok(true) => continue,
            Ok(false) => EditFault::NoParticles,
            Err(fault) => fault,
        };
        refuse(messages, entity, Refusal::Edit(fault));
    }
}
