//! Motion that a game asks for by components: velocities that it spawned or changed, and impulses.

use bevy::prelude::*;

use crate::changes::census;
use crate::commands::{BodyEdit, Editor};
use crate::components::{
    AngularVelocity, BodyParticles, CreationOrder, ExternalImpulse, ExtractedVelocity,
    LinearVelocity, Particle, RigidPose, Sleep,
};
use crate::messages::{EditFault, Refusal, Refused, refuse};

/// What is asked of a body, in the order of creation.
type Asked = (Option<CreationOrder>, Entity, BodyEdit);

/// Whose velocity somebody has written, be it the last tick: of a sleeper it has not.
type Sped = Or<(Changed<LinearVelocity>, Changed<AngularVelocity>, Changed<ExtractedVelocity>)>;

/// What has velocities: bodies, and single particles.
type Moves = Or<(With<BodyParticles>, With<Particle>)>;

/// A run condition: whether a velocity was written, or read off particles.
pub(crate) fn any_velocity_changed(
    linear: Query<Ref<LinearVelocity>, Moves>,
    angular: Query<Ref<AngularVelocity>, Moves>,
    known: Query<Ref<ExtractedVelocity>, Moves>,
) -> bool {
    census(&linear).1 || census(&angular).1 || census(&known).1
}

/// Gives bodies and single particles the velocities that a game spawned with them, or has changed since the last tick.
///
/// One that is not finite is refused and put back to what the body has.
pub(crate) fn follow_velocities(
    mut bodies: Query<
        (
            Entity,
            Option<&CreationOrder>,
            &mut LinearVelocity,
            // A particle has none: it is a point.
            Option<&mut AngularVelocity>,
            &mut ExtractedVelocity,
            Option<&mut Sleep>,
        ),
        (Moves, Sped),
    >,
    mut editor: Editor,
    mut messages: MessageWriter<Refused>,
    mut asked: Local<Vec<Asked>>,
) {
    asked.clear();
    for (entity, order, linear, angular, mut known, sleep) in &mut bodies {
        let now = (linear.0, angular.as_ref().map_or(Vec3::ZERO, |angular| angular.0));
        if known.0 == Some(now) {
            continue;
        }
        let mut linear = linear;
        let order = order.copied();
        let edits = match known.0 {
            // Particles of a body at rest may have velocities of their own, which are yet to be read off them.
            None if now == (Vec3::ZERO, Vec3::ZERO) => continue,
            None => [Some(BodyEdit::Motion(now.0, now.1)), None],
            Some((velocity, spin)) => {
                let moved = (velocity != now.0).then_some(BodyEdit::LinearVelocity(now.0));
                let spun = (spin != now.1).then_some(BodyEdit::AngularVelocity(now.1));
                [moved, spun]
            }
        };
        if now.0.is_finite() && now.1.is_finite() {
            known.0 = Some(now);
        } else {
            let last = known.0.unwrap_or_default();
            linear.0 = last.0;
            if let Some(mut angular) = angular {
                angular.0 = last.1;
            }
        }
        asked.extend(edits.into_iter().flatten().map(|edit| (order, entity, edit)));
        if let Some(mut sleep) = sleep {
            sleep.wake();
        }
    }
    carry_out(&mut asked, &mut editor, &mut messages);
}

/// Gives bodies, rigid parts and particles the impulses that a game has put onto them, and takes those off.
pub(crate) fn apply_impulses(
    mut pushed: Query<
        (Entity, Option<&CreationOrder>, &mut ExternalImpulse, Option<&mut Sleep>),
        Or<(With<BodyParticles>, With<RigidPose>, With<Particle>)>,
    >,
    mut editor: Editor,
    mut messages: MessageWriter<Refused>,
    mut asked: Local<Vec<Asked>>,
) {
    asked.clear();
    for (entity, order, mut pushed, sleep) in &mut pushed {
        if *pushed == ExternalImpulse::default() {
            continue;
        }
        let ExternalImpulse { impulse, angular_impulse, point } = core::mem::take(&mut *pushed);
        let push = match point {
            Some(point) => BodyEdit::ImpulseAt(impulse, point),
            None => BodyEdit::Impulse(impulse),
        };
        asked.push((order.copied(), entity, push));
        if angular_impulse != Vec3::ZERO {
            asked.push((order.copied(), entity, BodyEdit::AngularImpulse(angular_impulse)));
        }
        if let Some(mut sleep) = sleep {
            sleep.wake();
        }
    }
    carry_out(&mut asked, &mut editor, &mut messages);
}

/// Does what is asked, body by body in the order of creation; what cannot be done is refused.
fn carry_out(asked: &mut [Asked], editor: &mut Editor, messages: &mut MessageWriter<Refused>) {
    // A stable sort: what is asked of one body stays in its order.
    asked.sort_by_key(|&(order, entity, _)| (order, entity));
    for &(_, entity, edit) in &*asked {
        let fault = match editor.apply(entity, edit) {
            Ok(true) => continue,
            Ok(false) => EditFault::NoParticles,
            Err(fault) => fault,
        };
        refuse(messages, entity, Refusal::Edit(fault));
    }
}
