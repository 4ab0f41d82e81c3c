//! A chain of iron links carries a bucket that is filled until a joint breaks.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyAttachments, SinewClock};

/// The force at which a joint breaks, N.
const STRENGTH: f32 = 300.0;

#[derive(Component)]
struct Bucket;

#[derive(Resource, Default)]
struct Broken(Option<(f32, f32)>);

fn main() -> AppExit {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SinewPlugins)).init_resource::<Broken>();
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Startup, setup).add_systems(FixedUpdate, (fill, finish));
    app.add_observer(snap).run()
}

fn setup(mut commands: Commands) {
    let mut above = commands.spawn(Transform::from_xyz(0.0, 4.0, 0.0)).id();
    let mut at = Anchor::Whole;
    // Each link hangs with the middle of its top face on the middle of the bottom face above, by an attachment of its own that can break.
    let hang = |above: Entity, at: Anchor| {
        let hangs = AttachTo::new(above).part(Anchor::Corner(Vec3::Y)).at(at).snapped();
        related!(BodyAttachments[(hangs, BreakAt::force(STRENGTH))])
    };
    for i in 0..6 {
        let link = RigidBox::new(Vec3::new(0.06, 0.2, 0.06)).with_mass(0.5);
        let place = Transform::from_xyz(0.0, 3.9 - 0.2 * i as f32, 0.0);
        above = commands.spawn((link, hang(above, at), place)).id();
        at = Anchor::Corner(Vec3::NEG_Y);
    }
    let bucket = (Bucket, RigidBox::new(Vec3::splat(0.4)), Mass(5.0));
    commands.spawn((bucket, hang(above, at), Transform::from_xyz(0.0, 2.6, 0.0)));
}

/// Records the first joint that breaks. It is the topmost, which carries the most.
fn snap(broke: On<Broke>, buckets: Query<&Mass, With<Bucket>>, mut broken: ResMut<Broken>) {
    let filled = buckets.single().map_or(0.0, |mass| mass.0);
    broken.0.get_or_insert((broke.force, filled));
}

/// Adds three kilograms of water a second.
fn fill(mut buckets: Query<&mut Mass, With<Bucket>>, time: Res<Time>) {
    for mut mass in &mut buckets {
        mass.0 += 3.0 * time.delta_secs();
    }
}

fn finish(broken: Res<Broken>, clock: Res<SinewClock>, mut exit: MessageWriter<AppExit>) {
    if let Some((force, mass)) = broken.0 {
        println!("a joint broke under {force:.0} N, with {mass:.1} kg in the bucket");
        exit.write(AppExit::Success);
    } else if clock.seconds > 20.0 {
        exit.write(AppExit::error());
    }
}
