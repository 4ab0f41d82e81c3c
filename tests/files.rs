//! Snapshots are written to RON and to bytes and read back bit for bit; broken or foreign files are refused, and nothing changes.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::{ConstraintKind, Equation, Points};
use bevy_sinew::{AnyConstraint, BodyParticles, CreationOrder};
use bevy_sinew::{LoadFault, SaveFault, SinewClock, SinewSnapshot};
use bevy_sinew::{ParticleConstraint, RegisterParticleConstraint};

use crate::saved::{SCENES, future, game, played, whole};
use crate::support::{busy_scene, heard, mesh_of, tick, vertices};

type Write = fn(&SinewSnapshot, &World) -> Vec<u8>;
type Read = fn(&[u8], &World) -> Result<SinewSnapshot, LoadFault>;

/// Both formats, as bytes.
const FORMATS: [(&str, Write, Read); 2] = [
    (
        "RON",
        |saved, world| saved.to_ron(world).unwrap().into_bytes(),
        |bytes, world| SinewSnapshot::from_ron(&String::from_utf8_lossy(bytes), world),
    ),
    (
        "bytes",
        |saved, world| saved.to_bytes(world).unwrap(),
        |bytes, world| SinewSnapshot::from_bytes(bytes, world),
    ),
];

#[test]
fn every_scene_comes_back_from_both_formats_and_goes_on_as_it_did() {
    for (name, scene, ticks) in SCENES {
        let mut old = played(scene, ticks);
        let saved = SinewSnapshot::capture(old.world());
        let files = FORMATS.map(|(_, write, _)| write(&saved, old.world()));
        let expected = future(&mut old, 60);
        for ((format, write, read), file) in FORMATS.into_iter().zip(files) {
            let mut new = game();
            let loaded = read(&file, new.world()).unwrap();
            assert_eq!(loaded.hash(), saved.hash(), "{name}, {format}");
            assert_eq!(write(&loaded, new.world()), file, "{name}, {format}: written again");
            loaded.restore(new.world_mut()).unwrap();
            assert_eq!(whole(&new), saved.hash(), "{name}, {format}: put back");
            assert_eq!(future(&mut new, 60), expected, "{name}, {format}: goes on");
            assert_eq!(heard(&new), [], "{name}, {format}");
        }
    }
}

/// Regression: the record of what the rope was built from named entities of the app that saved it, so the rope was built anew: it hung straight again and went
/// on differently.
#[test]
fn a_rope_between_two_bodies_is_not_rebuilt_when_it_is_loaded() {
    for (format, write, read) in FORMATS {
        let mut old = game();
        // So that entity ids differ from those in the app that loads them.
        old.world_mut().spawn_batch([(); 64].map(|()| Name::new("nothing of ours")));
        let hook =
            old.world_mut().spawn((Collider::default(), Transform::from_xyz(0.0, 3.0, 0.0))).id();
        let crate_ = (RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(1.0, 1.5, 0.0));
        let crate_ = old.world_mut().spawn(crate_).id();
        old.world_mut().spawn(Rope { segments: 9, ..Rope::between(hook, crate_) });
        tick(&mut old, 20);
        let saved = SinewSnapshot::capture(old.world());
        let file = write(&saved, old.world());
        let mut new = game();
        read(&file, new.world()).unwrap().restore(new.world_mut()).unwrap();
        assert_eq!(whole(&new), saved.hash(), "{format}: put back");
        assert_eq!(future(&mut new, 30), future(&mut old, 30), "{format}: goes on");
    }
}

/// Regression: bodies that were loaded from a file had no mesh, since they were not built, and two that were given the same mesh both deformed it.
#[test]
fn loaded_cloth_and_soft_bodies_are_drawn_as_they_were() {
    for (format, write, read) in FORMATS {
        let at = |x: f32| Transform::from_xyz(x, 2.0, 0.0).with_scale(Vec3::splat(1.2));
        let mut old = game();
        let sheet = old.world_mut().resource_mut::<Assets<Mesh>>().add(sheet());
        let hung = || Cloth::from_mesh().pinned(ClothPins::TopEdge);
        let world = old.world_mut();
        let bodies = [
            world.spawn((Cloth::grid(1.0, 0.6, 7, 4).pinned(ClothPins::LeftEdge), at(0.0))).id(),
            world.spawn((SoftBody::cuboid(Vec3::ONE, UVec3::new(2, 3, 2)), at(2.0))).id(),
            world.spawn((SoftBody::ball(0.5, 4), at(4.0))).id(),
            world.spawn((hung(), Mesh3d(sheet.clone()), at(6.0))).id(),
            world.spawn((hung(), Mesh3d(sheet), at(8.0))).id(),
        ];
        tick(&mut old, 20);
        let saved = SinewSnapshot::capture(old.world());
        let file = write(&saved, old.world());
        let mut new = game();
        read(&file, new.world()).unwrap().restore(new.world_mut()).unwrap();
        // In a file entities have no ids of their own.
        let world = new.world_mut();
        let mut found: Vec<(CreationOrder, Entity)> = world
            .query_filtered::<(&CreationOrder, Entity), With<BodyParticles>>()
            .iter(world)
            .map(|(order, body)| (*order, body))
            .collect();
        found.sort_unstable();
        assert_eq!(found.len(), bodies.len());
        let loaded: Vec<Entity> = found.iter().map(|found| found.1).collect();
        tick(&mut new, 3);
        // Meshes that were made by hand are not in the file: the game inserts them, at any time.
        let shared = new.world_mut().resource_mut::<Assets<Mesh>>().add(self::sheet());
        let made = Vec::from(&loaded[3..]);
        made.iter().for_each(|&body| {
            new.world_mut().entity_mut(body).insert(Mesh3d(shared.clone()));
        });
        tick(&mut new, 3);
        tick(&mut old, 6);
        for (body, &loaded) in bodies.into_iter().zip(&loaded) {
            let uvs = |app: &App, body: Entity| {
                let meshes = app.world().resource::<Assets<Mesh>>();
                let mesh = meshes.get(&app.world().get::<Mesh3d>(body).unwrap().0).unwrap();
                let indices: Vec<usize> = mesh.indices().unwrap().iter().collect();
                (format!("{:?}", mesh.attribute(Mesh::ATTRIBUTE_UV_0)), indices)
            };
            assert_eq!(mesh_of(&new, loaded), mesh_of(&old, body), "{format}: {body}");
            assert!(uvs(&new, loaded) == uvs(&old, body), "{format}: {body}");
        }
        let untouched = vertices(new.world().resource::<Assets<Mesh>>().get(&shared).unwrap());
        assert_eq!(untouched, vertices(&self::sheet()), "{format}");
        assert_eq!(heard(&new), [], "{format}");
        // Another size: the body is built anew, once, from the game's mesh or with a mesh of its own.
        let size = |app: &App| app.world().resource::<Assets<Mesh>>().len();
        for body in loaded {
            new.world_mut().get_mut::<Transform>(body).unwrap().scale = Vec3::splat(0.5);
        }
        tick(&mut new, 3);
        let meshes = size(&new);
        tick(&mut new, 5);
        assert_eq!(size(&new), meshes, "{format}");
    }
}

/// A sheet that is a mesh of the game, facing up.
fn sheet() -> Mesh {
    Plane3d::default().mesh().subdivisions(3).build()
}

#[test]
fn extreme_floats_come_back_bit_for_bit() {
    let floats = [-0.0, 0.0, 1e-45, -1e-45, f32::MIN_POSITIVE, f32::MAX, f32::MIN, 0.1, 1.0 / 3.0];
    let mut app = game();
    let spawned: Vec<Entity> = floats
        .iter()
        .map(|&x| app.world_mut().spawn((Particle::at(Vec3::new(x, -x, 1.0)), Radius(x))).id())
        .collect();
    let odd = SinewClock { tick: u64::MAX, seconds: -5e-324, ahead: 0.0 };
    app.insert_resource(odd);
    let saved = SinewSnapshot::capture(app.world());
    for (format, write, read) in FORMATS {
        let file = write(&saved, app.world());
        let mut new = game();
        let map = read(&file, new.world()).unwrap().restore(new.world_mut()).unwrap();
        assert_eq!(map.len(), floats.len());
        let clock = new.world().resource::<SinewClock>();
        assert_eq!((clock.tick, clock.seconds.to_bits()), (odd.tick, odd.seconds.to_bits()));
        let world = new.world_mut();
        let mut found: Vec<[u32; 3]> = Vec::new();
        for (particle, radius) in world.query::<(&Particle, &Radius)>().iter(world) {
            found.push([particle.position.x, particle.position.y, radius.0].map(f32::to_bits));
        }
        let mut expected: Vec<[u32; 3]> = floats.map(|x| [x, -x, x].map(f32::to_bits)).to_vec();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected, "{format}");
    }
    assert_eq!(spawned.len(), floats.len());
}

/// An app with a few bodies, and a file of its state.
fn file_of(write: Write) -> (App, Vec<u8>) {
    let mut app = game();
    let world = app.world_mut();
    world.spawn(Ground);
    world.spawn((RigidBox::new(Vec3::splat(0.3)), Transform::from_xyz(0.0, 0.2, 0.0)));
    world.spawn((Rope { segments: 3, ..default() }, Transform::from_xyz(1.0, 2.0, 0.0)));
    tick(&mut app, 20);
    let file = write(&SinewSnapshot::capture(app.world()), app.world());
    (app, file)
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    for (format, write, read) in FORMATS {
        let (app, file) = file_of(write);
        let before = whole(&app);
        for length in (0..file.len()).step_by(1 + file.len() / 300).chain([file.len() - 1]) {
            let read = read(&file[..length], app.world());
            assert!(read.is_err(), "{format}: {length} of {}", file.len());
        }
        let longer: Vec<u8> = file.iter().copied().chain(*b" 1").collect();
        assert!(read(&longer, app.world()).is_err(), "{format}: more than there was");
        assert!(read(&file, app.world()).is_ok(), "{format}");
        assert_eq!(whole(&app), before);
    }
}

#[test]
fn a_file_with_a_changed_byte_is_refused() {
    let (app, file) = file_of(FORMATS[1].1);
    let before = whole(&app);
    for place in (0..file.len()).step_by(1 + file.len() / 500) {
        for flip in [1, 0x80] {
            let mut file = file.clone();
            file[place] ^= flip;
            assert!(SinewSnapshot::from_bytes(&file, app.world()).is_err(), "{flip} at {place}");
        }
    }
    // The text with one digit changed.
    let (_, file) = file_of(FORMATS[0].1);
    let text = String::from_utf8(file).unwrap();
    let place = text.find("position").unwrap();
    let digit = place + text[place..].find(|c: char| ('1'..='8').contains(&c)).unwrap();
    let mut bytes = text.clone().into_bytes();
    bytes[digit] += 1;
    let changed = String::from_utf8(bytes).unwrap();
    assert_eq!(SinewSnapshot::from_ron(&changed, app.world()).unwrap_err(), LoadFault::Hash);
    assert_eq!(whole(&app), before);
}

#[test]
fn foreign_files_other_versions_and_unregistered_types_are_refused_by_name() {
    let (app, file) = file_of(FORMATS[0].1);
    let text = String::from_utf8(file).unwrap();
    let read = |text: &str| SinewSnapshot::from_ron(text, app.world()).unwrap_err();
    for foreign in ["(\"a story\", 1, 0, [], 0)", "(5, 1, 0, [], 0)"] {
        assert_eq!(read(foreign), LoadFault::Foreign, "{foreign}");
    }
    for broken in ["", "()", "[1, 2]", "(resources: {}, entities: {})", "\u{0}"] {
        assert!(matches!(read(broken), LoadFault::Broken(_) | LoadFault::Foreign), "{broken}");
    }
    let newer = text.replacen(", 1, ", ", 2, ", 1).replacen(",\n    1,", ",\n    2,", 1);
    assert_ne!(newer, text);
    assert_eq!(read(&newer), LoadFault::Version(2));
    let strange = text.replace("bevy_sinew::Rope", "bevy_sinew::Chain");
    assert_eq!(read(&strange), LoadFault::Unregistered("bevy_sinew::Chain".into()));

    let bytes = |bytes: &[u8]| SinewSnapshot::from_bytes(bytes, app.world()).unwrap_err();
    assert_eq!(bytes(b""), LoadFault::Foreign);
    assert_eq!(bytes(b"\x89PNG\r\n\x1a\n and so on"), LoadFault::Foreign);
    let (_, mut file) = file_of(FORMATS[1].1);
    file[4] = 2;
    assert_eq!(bytes(&file), LoadFault::Version(2));
}

/// A constraint that cannot be written, because it is not reflected.
#[derive(Component, Clone)]
struct Unseen {
    #[entities]
    particle: Entity,
}

impl ParticleConstraint for Unseen {
    fn particles(&self) -> &[Entity] {
        core::slice::from_ref(&self.particle)
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::custom(Nothing)
    }
}

#[derive(Debug)]
struct Nothing;

impl Equation for Nothing {
    fn evaluate(&self, _: &Points, _: &mut [Vec3]) -> f32 {
        0.0
    }
}

#[test]
fn constraints_that_cannot_be_written_are_refused_by_name() {
    let mut app = game();
    app.register_particle_constraint::<Unseen>();
    busy_scene(&mut app);
    tick(&mut app, 3);
    let particle = app.world_mut().spawn(Particle::default()).id();
    let unseen = app.world_mut().spawn(Unseen { particle }).id();
    let saved = SinewSnapshot::capture(app.world());
    let fault = saved.to_ron(app.world()).unwrap_err();
    assert!(matches!(&fault, SaveFault::NotReflected(name) if name.contains("Unseen")), "{fault}");
    assert_eq!(saved.to_bytes(app.world()), Err(fault));
    app.world_mut().despawn(unseen);
    let any = AnyConstraint::new([particle], ConstraintKind::custom(Nothing));
    let any = app.world_mut().spawn(any).id();
    let saved = SinewSnapshot::capture(app.world());
    for fault in [saved.to_ron(app.world()).err(), saved.to_bytes(app.world()).err()] {
        assert!(matches!(&fault, Some(SaveFault::Unwritable(_))), "{fault:?}");
    }
    app.world_mut().despawn(any);
    assert!(SinewSnapshot::capture(app.world()).to_ron(app.world()).is_ok());
}
