//! Writes one mesh with one material as binary glTF.
//!
//! The JSON is made from `gltf`'s own types rather than from free-form maps: their fields have a fixed order, so the bytes do not depend on which map type
//! other packages enable in `serde_json`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use glam::Vec3;
use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::{Target, View};
use gltf::json::image::MimeType;
use gltf::json::material::{EmissiveFactor, PbrMetallicRoughness, StrengthFactor};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::texture::{Info, Sampler, WrappingMode};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{
    Accessor, Asset, Buffer, Image, Index, Material, Node, Root, Scene, Texture, Value,
};

use super::mesh::Mesh;

/// The material of a mesh.
pub(super) struct Surface<'a> {
    /// Base colour texture, as a PNG file.
    pub(super) picture: &'a [u8],
    /// Emissive texture, as a PNG file.
    pub(super) glow: Option<&'a [u8]>,
    pub(super) roughness: f32,
    pub(super) double_sided: bool,
}

/// The contents of a `.glb` file with `mesh` as its only mesh, in one primitive.
pub(super) fn write(name: &str, mesh: &Mesh, surface: &Surface) -> Vec<u8> {
    let mut file = File::default();
    let primitive = file.primitive(mesh);
    let material = file.material(name, surface);
    let mesh = file.root.push(gltf::json::Mesh {
        extensions: None,
        extras: Default::default(),
        name: Some(name.into()),
        primitives: vec![Primitive { material: Some(material), ..primitive }],
        weights: None,
    });
    let node =
        file.root.push(Node { mesh: Some(mesh), name: Some(name.into()), ..Default::default() });
    let scene = file.root.push(Scene {
        extensions: None,
        extras: Default::default(),
        name: Some(name.into()),
        nodes: vec![node],
    });
    file.root.scene = Some(scene);
    file.finish()
}

/// A file under construction: its JSON, and the bytes of its binary chunk.
#[derive(Default)]
struct File {
    root: Root,
    bytes: Vec<u8>,
}

impl File {
    fn primitive(&mut self, mesh: &Mesh) -> Primitive {
        let low = mesh.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = mesh.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let positions = self.floats(Type::Vec3, mesh.positions.iter().map(Vec3::to_array));
        self.root.accessors[positions.value()].min = Some(corner(low));
        self.root.accessors[positions.value()].max = Some(corner(high));
        let normals = self.floats(Type::Vec3, mesh.normals.iter().map(Vec3::to_array));
        let uvs = self.floats(Type::Vec2, mesh.uvs.iter().map(glam::Vec2::to_array));

        let indices = mesh.triangles.as_flattened();
        let bytes = indices.iter().flat_map(|&index| {
            u16::try_from(index).expect("the project's models are small").to_le_bytes()
        });
        let view = self.view(bytes.collect(), Some(Target::ElementArrayBuffer));
        let indices = self.accessor(view, indices.len(), ComponentType::U16, Type::Scalar);
        Primitive {
            attributes: BTreeMap::from([
                (Checked::Valid(Semantic::Positions), positions),
                (Checked::Valid(Semantic::Normals), normals),
                (Checked::Valid(Semantic::TexCoords(0)), uvs),
            ]),
            extensions: None,
            extras: Default::default(),
            indices: Some(indices),
            material: None,
            mode: Checked::Valid(Mode::Triangles),
            targets: None,
        }
    }

    fn material(&mut self, name: &str, surface: &Surface) -> Index<Material> {
        let picture = self.texture(surface.picture);
        let glow = surface.glow.map(|png| self.texture(png));
        self.root.push(Material {
            name: Some(name.into()),
            double_sided: surface.double_sided,
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_texture: Some(picture),
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(surface.roughness),
                ..Default::default()
            },
            emissive_factor: EmissiveFactor([if glow.is_some() { 1.0 } else { 0.0 }; 3]),
            emissive_texture: glow,
            ..Default::default()
        })
    }

    fn texture(&mut self, png: &[u8]) -> Info {
        let view = self.view(png.to_vec(), None);
        let source = self.root.push(Image {
            buffer_view: Some(view),
            mime_type: Some(MimeType("image/png".into())),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        let sampler = self.root.push(Sampler {
            wrap_s: Checked::Valid(WrappingMode::ClampToEdge),
            wrap_t: Checked::Valid(WrappingMode::ClampToEdge),
            ..Default::default()
        });
        let index = self.root.push(Texture {
            name: None,
            sampler: Some(sampler),
            source,
            extensions: None,
            extras: Default::default(),
        });
        Info { index, tex_coord: 0, extensions: None, extras: Default::default() }
    }

    fn floats<const N: usize>(
        &mut self,
        kind: Type,
        vectors: impl ExactSizeIterator<Item = [f32; N]>,
    ) -> Index<Accessor> {
        let count = vectors.len();
        let view = self.view(
            vectors.flatten().flat_map(f32::to_le_bytes).collect(),
            Some(Target::ArrayBuffer),
        );
        self.accessor(view, count, ComponentType::F32, kind)
    }

    fn accessor(
        &mut self,
        view: Index<View>,
        count: usize,
        component: ComponentType,
        kind: Type,
    ) -> Index<Accessor> {
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Checked::Valid(GenericComponentType(component)),
            extensions: None,
            extras: Default::default(),
            type_: Checked::Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        })
    }

    /// Appends `bytes` to the binary chunk, at a multiple of four, as accessors require.
    fn view(&mut self, bytes: Vec<u8>, target: Option<Target>) -> Index<View> {
        let view = View {
            // The only buffer of a binary file.
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(self.bytes.len())),
            byte_stride: None,
            name: None,
            target: target.map(Checked::Valid),
            extensions: None,
            extras: Default::default(),
        };
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.root.push(view)
    }

    fn finish(mut self) -> Vec<u8> {
        self.root.asset =
            Asset { generator: Some("sinew_make_assets".into()), ..Default::default() };
        self.root.push(Buffer {
            byte_length: USize64::from(self.bytes.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        let json =
            gltf::json::serialize::to_vec(&self.root).expect("glTF's own types are always JSON");
        // The length in the header is computed while writing.
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let file = Glb { header, json: Cow::Owned(json), bin: Some(Cow::Owned(self.bytes)) };
        file.to_vec().expect("writing to memory cannot fail")
    }
}

/// A corner of the bounding box as JSON. Through `f64`, which represents every `f32` exactly.
fn corner(at: Vec3) -> Value {
    at.to_array().map(f64::from).to_vec().into()
}
