//! Real meshes from outside this project become cloth, fall on the ground, and stay whole. They lie in `../shared/models`, beside the repository; where that
//! folder is missing, these tests print so and pass.

use std::path::PathBuf;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::support::{app, assert_finite, heard, mesh_of, particles_of, position, tick};

fn model(name: &str) -> Option<PathBuf> {
    // Read when the test runs: clones may share a target folder.
    let package = std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let path = PathBuf::from(package).join("../../shared/models").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: there is no {}", path.display());
    None
}

/// Triangles of a Wavefront file: its `v` and `f` lines, faces of any number of corners.
fn read_obj(text: &str) -> (Vec<Vec3>, Vec<u32>) {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f32> = words.take(3).map(|word| word.parse().unwrap()).collect();
                positions.push(Vec3::new(p[0], p[1], p[2]));
            }
            Some("f") => {
                let corner =
                    |word: &str| word.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                let corners: Vec<u32> = words.map(corner).collect();
                for k in 1..corners.len() - 1 {
                    indices.extend([corners[0], corners[k], corners[k + 1]]);
                }
            }
            _ => (),
        }
    }
    (positions, indices)
}

/// All triangles of a glTF file, in one list, in the coordinates of its meshes.
pub(crate) fn read_gltf(path: &PathBuf) -> (Vec<Vec3>, Vec<u32>) {
    let data = gltf::Gltf::open(path).unwrap();
    let buffers: Vec<Vec<u8>> = data
        .buffers()
        .map(|buffer| match buffer.source() {
            gltf::buffer::Source::Bin => data.blob.clone().unwrap(),
            gltf::buffer::Source::Uri(uri) => decode(uri.split_once("base64,").expect("data").1),
        })
        .collect();
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for primitive in data.meshes().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let first = positions.len() as u32;
        positions.extend(reader.read_positions().unwrap().map(Vec3::from));
        match reader.read_indices() {
            Some(list) => indices.extend(list.into_u32().map(|i| first + i)),
            None => indices.extend(first..positions.len() as u32),
        }
    }
    (positions, indices)
}

/// Decodes base 64, the encoding of data in a glTF file.
fn decode(text: &str) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let sextets: Vec<u8> = text.bytes().filter(|&c| c != b'=').map(value).collect();
    let four = |chunk: &[u8]| {
        let bits = chunk.iter().fold(0_u32, |bits, &s| bits << 6 | u32::from(s))
            << (6 * (4 - chunk.len()));
        bits.to_be_bytes()[1..chunk.len()].to_vec()
    };
    sextets.chunks(4).flat_map(four).collect()
}

/// A mesh of these corners and triangles.
pub(crate) fn mesh_from(positions: &[Vec3], indices: Vec<u32>) -> Mesh {
    let positions: Vec<[f32; 3]> = positions.iter().map(Vec3::to_array).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices))
}

/// Drops a mesh as cloth on the ground for a second and checks what is left of it.
fn drop_on_the_ground(name: &str, (positions, indices): (Vec<Vec3>, Vec<u32>)) {
    let (min, max) =
        positions.iter().fold((Vec3::MAX, Vec3::MIN), |(min, max), &p| (min.min(p), max.max(p)));
    let count = positions.len();
    let mesh = mesh_from(&positions, indices);
    // A metre across, 20 cm above the ground.
    let scale = 1.0 / (max - min).max_element();
    let place = Transform::from_xyz(0.0, 0.2 - min.y * scale, 0.0).with_scale(Vec3::splat(scale));

    let mut app = app();
    app.world_mut().spawn(Ground);
    let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let body = app.world_mut().spawn((Cloth::from_mesh(), Mesh3d(handle), place)).id();
    tick(&mut app, 60);

    assert_eq!(heard(&app), [], "{name}");
    let particles = particles_of(&app, body);
    assert!(particles.len() > 100 && particles.len() <= count, "{name}: {}", particles.len());
    assert_finite(&mut app);
    let vertices = mesh_of(&app, body);
    assert_eq!(vertices.len(), count, "{name}: every vertex is drawn");
    let lowest = particles.iter().map(|&p| position(&app, p).y).fold(f32::MAX, f32::min);
    let farthest = particles.iter().map(|&p| position(&app, p).length()).fold(0.0, f32::max);
    assert!(lowest > -1e-4 && lowest < 0.05, "{name} reached the ground: {lowest}");
    assert!(farthest < 2.0, "{name} holds together: {farthest}");
    let drawn = vertices.iter().map(|&v| (place * v).y).fold(f32::MAX, f32::min);
    assert!((drawn - lowest).abs() < 1e-3, "{name} is drawn where it is: {drawn} {lowest}");
    println!("{name}: {count} vertices, {} particles", particles.len());
}

#[test]
fn a_scanned_bunny_falls_as_cloth() {
    if let Some(path) = model("bunny_10k.obj") {
        let read = read_obj(&std::fs::read_to_string(path).unwrap());
        assert!(read.1.len() > 3 * 9000, "{} indices", read.1.len());
        drop_on_the_ground("the bunny", read);
    }
}

#[test]
fn a_golf_ball_falls_as_cloth() {
    if let Some(path) = model("GolfBall.glb") {
        drop_on_the_ground("the golf ball", read_gltf(&path));
    }
}

#[test]
fn a_torus_with_seams_falls_as_cloth() {
    if let Some(path) = model("torus.gltf") {
        drop_on_the_ground("the torus", read_gltf(&path));
    }
}

#[test]
fn an_alien_and_a_fox_fall_as_cloth() {
    for name in ["alien.glb", "Fox.glb"] {
        if let Some(path) = model(name) {
            drop_on_the_ground(name, read_gltf(&path));
        }
    }
}
