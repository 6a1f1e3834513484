//! The JSON chunk of a GLB.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::layout::{Kind, Layout};
use crate::formats::wording::facts;
use crate::formats::{Header, SinkError};

/// The extension by which meshes are compressed.
const MESHOPT: &str = "EXT_meshopt_compression";

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const CLAMP: u32 = 33071;

/// A primitive: where its vertices and its triangles are.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) vertices: Stretch,
    /// The corners of triangles.
    pub(super) corners: Stretch,
    /// Bytes of a corner: 2 or 4.
    pub(super) corner_bytes: u64,
    /// The least x, y, z of vertices.
    pub(super) min: [f32; 3],
    /// The largest.
    pub(super) max: [f32; 3],
}

/// A stretch of a buffer.
#[derive(Debug)]
pub(super) struct Stretch {
    /// How many elements it has.
    pub(super) count: u64,
    /// Where it begins, in bytes, in the buffer of what is not compressed.
    pub(super) offset: u64,
    /// Where it begins and how long it is in the BIN chunk, where it is compressed.
    pub(super) packed: Option<(u64, u64)>,
}

/// Lengths of buffers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Buffers {
    /// Of the BIN chunk.
    pub(super) bin: u64,
    /// Of what is in it, decompressed; `None` where it is not compressed.
    pub(super) unpacked: Option<u64>,
    /// Where the texture begins and how long it is in the BIN chunk.
    pub(super) texture: Option<(u64, u64)>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Document<'a> {
    asset: Asset<'a>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    extensions_used: Vec<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    extensions_required: Vec<&'static str>,
    scene: usize,
    scenes: [Scene; 1],
    nodes: [Node; 1],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    meshes: Vec<Mesh<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    materials: Vec<Material>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    textures: Vec<Texture>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    images: Vec<Image>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    samplers: Vec<Sampler>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    buffer_views: Vec<BufferView>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    buffers: Vec<Buffer>,
}

#[derive(Serialize)]
struct Asset<'a> {
    version: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    generator: Option<&'a str>,
    extras: Extras<'a>,
}

#[derive(Serialize)]
struct Extras<'a> {
    terrabite: Facts<'a>,
}

/// What the file says of itself: `facts` are all of it, the rest is for programs that want numbers.
#[derive(Serialize)]
struct Facts<'a> {
    offset: [f64; 2],
    xy_scale: [f64; 2],
    z_scale: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    crs: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertical_crs: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    source: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_error: Option<f64>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    attributes: &'a [String],
    facts: Vec<String>,
}

#[derive(Serialize)]
struct Scene {
    nodes: [usize; 1],
}

#[derive(Serialize)]
struct Node {
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    translation: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct Mesh<'a> {
    primitives: Vec<Primitive<'a>>,
}

#[derive(Serialize)]
struct Primitive<'a> {
    attributes: BTreeMap<&'a str, usize>,
    indices: usize,
    material: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Material {
    pbr_metallic_roughness: Roughness,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Roughness {
    #[serde(skip_serializing_if = "Option::is_none")]
    base_color_texture: Option<TextureIndex>,
    metallic_factor: u32,
    roughness_factor: u32,
}

#[derive(Serialize)]
struct TextureIndex {
    index: usize,
}

#[derive(Serialize)]
struct Texture {
    sampler: usize,
    source: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Image {
    buffer_view: usize,
    mime_type: &'static str,
}

/// The image does not go on beyond its edges.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Sampler {
    wrap_s: u32,
    wrap_t: u32,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: usize,
    #[serde(skip_serializing_if = "is_zero")]
    byte_offset: u64,
    component_type: u32,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    normalized: bool,
    count: u64,
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    min: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max: Option<[f64; 3]>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: usize,
    #[serde(skip_serializing_if = "is_zero")]
    byte_offset: u64,
    byte_length: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    byte_stride: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    extensions: Option<BTreeMap<&'static str, Packed>>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Packed {
    buffer: usize,
    byte_offset: u64,
    byte_length: u64,
    byte_stride: u64,
    count: u64,
    mode: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    byte_length: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    extensions: Option<BTreeMap<&'static str, Fallback>>,
}

#[derive(Serialize)]
struct Fallback {
    fallback: bool,
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// The document of a mesh of these primitives, as the bytes of a JSON chunk: padded with blanks to a multiple of 4.
pub(super) fn document(header: &Header, layout: &Layout, parts: &[Part], buffers: Buffers) -> Vec<u8> {
    let is_packed = buffers.unpacked.is_some() && !parts.is_empty();
    let extensions = if is_packed { vec![MESHOPT] } else { Vec::new() };
    let (mut primitives, mut accessors, mut buffer_views) = (Vec::new(), Vec::new(), Vec::new());
    for part in parts {
        primitives.push(Primitive {
            attributes: layout.fields.iter().map(|f| f.semantic.as_str()).zip(accessors.len()..).collect(),
            indices: accessors.len() + layout.fields.len(),
            material: 0,
        });
        accessors.extend(vertex_accessors(layout, part, buffer_views.len()));
        buffer_views.push(view(&part.vertices, layout.stride as u64, Some(layout.stride as u64), "ATTRIBUTES"));
        accessors.push(Accessor {
            buffer_view: buffer_views.len(),
            byte_offset: 0,
            component_type: if part.corner_bytes == 2 { UNSIGNED_SHORT } else { UNSIGNED_INT },
            normalized: false,
            count: part.corners.count,
            kind: "SCALAR",
            min: None,
            max: None,
        });
        buffer_views.push(view(&part.corners, part.corner_bytes, None, "TRIANGLES"));
    }
    let has_mesh = !primitives.is_empty();
    let fallback = || Some(BTreeMap::from([(MESHOPT, Fallback { fallback: true })]));
    let bin = Buffer { byte_length: buffers.bin, extensions: None };
    let unpacked = buffers.unpacked.map(|byte_length| Buffer { byte_length, extensions: fallback() });
    let texture = buffers.texture.filter(|_| has_mesh);
    let images = texture.map(|(byte_offset, byte_length)| {
        let (byte_stride, target, extensions) = (None, None, None);
        buffer_views.push(BufferView { buffer: 0, byte_offset, byte_length, byte_stride, target, extensions });
        Image { buffer_view: buffer_views.len() - 1, mime_type: "image/jpeg" }
    });
    let base_color_texture = texture.map(|_| TextureIndex { index: 0 });
    let roughness = Roughness { base_color_texture, metallic_factor: 0, roughness_factor: 1 };
    let material = Material { pbr_metallic_roughness: roughness };
    let document = Document {
        asset: asset(header, layout),
        extensions_used: extensions.clone(),
        extensions_required: extensions,
        scene: 0,
        scenes: [Scene { nodes: [0] }],
        nodes: [Node { mesh: has_mesh.then_some(0), translation: translation(header) }],
        meshes: if has_mesh { vec![Mesh { primitives }] } else { Vec::new() },
        materials: if has_mesh { vec![material] } else { Vec::new() },
        textures: texture.map(|_| Texture { sampler: 0, source: 0 }).into_iter().collect(),
        images: images.into_iter().collect(),
        samplers: texture.map(|_| Sampler { wrap_s: CLAMP, wrap_t: CLAMP }).into_iter().collect(),
        accessors,
        buffer_views,
        buffers: if has_mesh { [bin].into_iter().chain(unpacked).collect() } else { Vec::new() },
    };
    let mut json = serde_json::to_vec(&document).expect("plain data");
    json.resize(json.len().next_multiple_of(4), b' ');
    json
}

fn asset<'a>(header: &'a Header, layout: &'a Layout) -> Asset<'a> {
    let frame = &header.frame;
    let terrabite = Facts {
        offset: [frame.origin.0, frame.origin.1],
        xy_scale: [frame.xy_scale.0, frame.xy_scale.1],
        z_scale: frame.z_scale,
        crs: header.crs.definition.as_deref(),
        vertical_crs: header.heights.crs.as_deref(),
        source: header.source.as_deref(),
        max_error: header.tolerance,
        attributes: &layout.names,
        facts: facts(header).iter().map(|line| line.trim_end().to_string()).collect(),
    };
    Asset { version: "2.0", generator: header.made_by.as_deref(), extras: Extras { terrabite } }
}

/// The frame's origin in the units of the file, y up; `None` where it is 0.
fn translation(header: &Header) -> Option<[f64; 3]> {
    let frame = &header.frame;
    let (x, y) = (frame.origin.0 * frame.xy_scale.0, frame.origin.1 * frame.xy_scale.1);
    ((x, y) != (0.0, 0.0)).then_some([x, 0.0, 0.0 - y])
}

fn vertex_accessors<'a>(layout: &'a Layout, part: &'a Part, view: usize) -> impl Iterator<Item = Accessor> + 'a {
    let doubles = |values: [f32; 3]| values.map(f64::from);
    layout.fields.iter().map(move |field| {
        let (component_type, kind) = match field.kind {
            Kind::Position | Kind::Normal => (FLOAT, "VEC3"),
            Kind::Texture => (FLOAT, "VEC2"),
            Kind::Colour => (UNSIGNED_BYTE, "VEC4"),
            Kind::Single => (FLOAT, "SCALAR"),
            Kind::Byte => (UNSIGNED_BYTE, "SCALAR"),
        };
        Accessor {
            buffer_view: view,
            byte_offset: field.offset as u64,
            component_type,
            normalized: field.kind == Kind::Colour,
            count: part.vertices.count,
            kind,
            min: (field.kind == Kind::Position).then_some(doubles(part.min)),
            max: (field.kind == Kind::Position).then_some(doubles(part.max)),
        }
    })
}

fn view(stretch: &Stretch, bytes: u64, byte_stride: Option<u64>, mode: &'static str) -> BufferView {
    let packed = stretch.packed.map(|(byte_offset, byte_length)| Packed {
        buffer: 0,
        byte_offset,
        byte_length,
        byte_stride: bytes,
        count: stretch.count,
        mode,
    });
    BufferView {
        buffer: usize::from(packed.is_some()),
        byte_offset: stretch.offset,
        byte_length: stretch.count * bytes,
        byte_stride,
        target: Some(if byte_stride.is_some() { ARRAY_BUFFER } else { ELEMENT_ARRAY_BUFFER }),
        extensions: packed.map(|packed| BTreeMap::from([(MESHOPT, packed)])),
    }
}

/// The most bytes of a JSON chunk: readers take it as a whole. A billion vertices have as much.
const JSON_BYTES: usize = 16 << 20;

/// All of a GLB before the content of its BIN chunk: the file's header, the JSON chunk and the header of the BIN chunk, if
/// there is one. `bin` is a multiple of 4.
///
/// # Errors
/// [`SinkError::Unfit`] if the file would be longer than its header can say, or the JSON chunk too long.
pub(super) fn front(path: &Path, json: &[u8], bin: u64) -> Result<Vec<u8>, SinkError> {
    if json.len() > JSON_BYTES {
        return Err(SinkError::Unfit {
            path: path.to_path_buf(),
            expected: format!("a mesh that is described in at most {JSON_BYTES} bytes of JSON"),
            found: format!("{}", json.len()),
        });
    }
    let bin_chunk = if bin > 0 { 8 + bin } else { 0 };
    let length = 20 + json.len() as u64 + bin_chunk;
    let length = u32::try_from(length).map_err(|_| too_long(path, length))?;
    let mut front = Vec::with_capacity(28 + json.len());
    front.extend_from_slice(b"glTF");
    [2, length, json.len() as u32].iter().for_each(|number| front.extend_from_slice(&number.to_le_bytes()));
    front.extend_from_slice(b"JSON");
    front.extend_from_slice(json);
    if bin > 0 {
        front.extend_from_slice(&(bin as u32).to_le_bytes());
        front.extend_from_slice(b"BIN\0");
    }
    Ok(front)
}

/// The file would have this many bytes, or more.
pub(super) fn too_long(path: &Path, bytes: u64) -> SinkError {
    SinkError::Unfit {
        path: path.to_path_buf(),
        expected: format!("at most {} bytes, as many as a GLB can have", u32::MAX),
        found: format!("a mesh of {bytes}"),
    }
}
