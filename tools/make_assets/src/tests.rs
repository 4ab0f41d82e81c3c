//! Checks that the committed files are what the tool writes, and that the models have the properties that the project's examples rely on.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::PathBuf;

use glam::{Vec2, Vec3};

use super::ASSETS;
use crate::paint::shape;

/// Folder of the committed files, read from the environment when the test runs: a target folder may be shared by clones.
fn committed() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo says where it is");
    PathBuf::from(package).join("../../assets")
}

#[test]
fn committed_files_are_what_the_tool_writes() {
    for asset in ASSETS {
        let path = committed().join(asset.path);
        let committed =
            fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(
            committed == (asset.bytes)(),
            "{} is not what its source draws; run `cargo run -p sinew_make_assets`",
            asset.path
        );
    }
}

#[test]
fn assets_stay_small() {
    let size = |path| fs::metadata(committed().join(path)).expect("a committed asset").len();
    let total: u64 = ASSETS.iter().map(|asset| size(asset.path)).sum();
    assert!(total < 1_000_000, "{total} bytes");
}

#[test]
fn lantern_is_one_closed_skin_around_its_centre() {
    let model = Model::load(&crate::gltf::lantern());
    assert!((500..=2000).contains(&model.triangles.len()), "{} triangles", model.triangles.len());
    let size = model.high - model.low;
    assert!((size.y - 0.6).abs() < 0.01, "{size}");

    let welded = model.welded();
    let mut edges = HashMap::new();
    for [a, b, c] in &welded {
        for edge in [[*a, *b], [*b, *c], [*c, *a]] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    for ([from, to], count) in &edges {
        assert_eq!(*count, 1, "an edge is used twice in one direction");
        assert!(
            edges.contains_key(&[*to, *from]),
            "a hole at {} {}",
            model.positions[*from],
            model.positions[*to]
        );
    }
    assert_eq!(pieces(&welded), 1);
    let corners: HashSet<usize> = welded.iter().flatten().copied().collect();
    let euler = corners.len() as isize - edges.len() as isize / 2 + welded.len() as isize;
    assert_eq!(euler, 0, "a solid with one hole through it, under the handle");

    let (mut volume, mut moment) = (0.0, Vec3::ZERO);
    for [a, b, c] in welded.iter().map(|triangle| triangle.map(|corner| model.positions[corner])) {
        let wedge = a.dot(b.cross(c)) / 6.0;
        volume += wedge;
        moment += (a + b + c) / 4.0 * wedge;
    }
    assert!((0.01..0.05).contains(&volume), "{volume} cubic metres; negative is inside out");
    assert!((moment / volume).length() < 1.0e-4, "{}", moment / volume);
}

#[test]
fn banner_is_irregular_cloth_with_one_seam() {
    let model = Model::load(&crate::gltf::banner());
    assert!((500..=700).contains(&model.triangles.len()), "{} triangles", model.triangles.len());
    assert_eq!(
        (model.low, model.high),
        (
            Vec3::new(-shape::HALF_WIDTH, -shape::LENGTH, 0.0),
            Vec3::new(shape::HALF_WIDTH, 0.0, 0.0),
        )
    );

    let welded = model.welded();
    assert_eq!(pieces(&model.triangles), 2, "the seam parts the halves");
    assert_eq!(pieces(&welded), 1, "welding joins them");
    let kept: HashSet<usize> = welded.iter().flatten().copied().collect();
    let twins =
        (0..model.positions.len()).filter(|vertex| !kept.contains(vertex)).collect::<Vec<_>>();
    assert!(twins.len() > 10);
    assert!(twins.iter().all(|&vertex| model.positions[vertex].x == 0.0));

    let mut area = 0.0;
    for [a, b, c] in welded.iter().map(|triangle| triangle.map(|corner| model.positions[corner])) {
        area += (b - a).cross(c - a).z / 2.0;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert!((0.05..0.2).contains(&from.distance(to)), "an edge {} long", from.distance(to));
        }
    }
    let outline = shape::HALF_WIDTH * (shape::LENGTH + shape::NOTCH);
    assert!((area - outline).abs() < 1.0e-4, "triangles cover {area} of {outline} square metres");
}

/// A model as read by a loader.
struct Model {
    positions: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
    low: Vec3,
    high: Vec3,
}

impl Model {
    /// Loads a file through `gltf`, with all its validation, and checks the properties common to all models.
    fn load(file: &[u8]) -> Self {
        let loaded = ::gltf::Gltf::from_slice(file).expect("a valid file");
        let bytes = loaded.blob.as_deref().expect("a binary chunk");
        assert_eq!(loaded.meshes().len(), 1);
        let mesh = loaded.meshes().next().expect("one mesh");
        assert_eq!(mesh.primitives().len(), 1);
        let primitive = mesh.primitives().next().expect("one primitive");
        for view in loaded.views() {
            assert_eq!(view.offset() % 4, 0);
        }

        let reader = primitive.reader(|_| Some(bytes));
        let positions: Vec<Vec3> =
            reader.read_positions().expect("positions").map(Vec3::from).collect();
        let normals: Vec<Vec3> = reader.read_normals().expect("normals").map(Vec3::from).collect();
        let uvs: Vec<Vec2> =
            reader.read_tex_coords(0).expect("uvs").into_f32().map(Vec2::from).collect();
        let indices: Vec<usize> = reader
            .read_indices()
            .expect("indices")
            .into_u32()
            .map(|index| index as usize)
            .collect();
        assert_eq!((normals.len(), uvs.len()), (positions.len(), positions.len()));
        assert!(normals.iter().all(|normal| normal.is_normalized()));
        assert!(uvs.iter().all(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0));
        assert_eq!(
            indices.iter().collect::<HashSet<_>>().len(),
            positions.len(),
            "every vertex is used"
        );

        let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let bounds = primitive.bounding_box();
        assert_eq!((bounds.min, bounds.max), (low.to_array(), high.to_array()));
        Self { positions, triangles: indices.as_chunks().0.to_vec(), low, high }
    }

    /// The triangles, with vertices at exactly the same position merged.
    fn welded(&self) -> Vec<[usize; 3]> {
        let mut first = HashMap::new();
        let vertices: Vec<usize> = (0..self.positions.len())
            .map(|vertex| {
                *first.entry(self.positions[vertex].to_array().map(f32::to_bits)).or_insert(vertex)
            })
            .collect();
        self.triangles.iter().map(|triangle| triangle.map(|corner| vertices[corner])).collect()
    }
}

/// Number of connected parts of `triangles`: parts share no vertex.
fn pieces(triangles: &[[usize; 3]]) -> usize {
    let mut groups: Vec<HashSet<usize>> = Vec::new();
    for triangle in triangles {
        let (touching, mut apart): (Vec<_>, Vec<_>) = groups
            .into_iter()
            .partition(|group| triangle.iter().any(|corner| group.contains(corner)));
        apart.push(touching.into_iter().flatten().chain(*triangle).collect());
        groups = apart;
    }
    groups.len()
}
