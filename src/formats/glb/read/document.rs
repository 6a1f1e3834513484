//! The JSON chunk of a GLB, as far as it says where triangles are.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// The document. Numbers of parts are not believed: they may be out of range.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub(super) asset: Asset,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Asset {
    pub(super) version: String,
    pub(super) generator: Option<String>,
    #[serde(default)]
    extras: Extras,
}

/// What terrabite says in the extras of an asset, which may be anything.
#[derive(Debug, Default)]
struct Extras(Option<serde_json::Value>);

impl<'de> Deserialize<'de> for Extras {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Extras, D::Error> {
        deserializer.deserialize_any(ExtrasVisitor)
    }
}

/// Keeps the value of `terrabite`, and nothing else.
struct ExtrasVisitor;

impl<'de> Visitor<'de> for ExtrasVisitor {
    type Value = Extras;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("extras")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Extras, A::Error> {
        let mut found = None;
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "terrabite" => found = Some(map.next_value()?),
                _ => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(Extras(found))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Extras, A::Error> {
        while seq.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Extras(None))
    }

    fn visit_bool<E>(self, _: bool) -> Result<Extras, E> {
        Ok(Extras(None))
    }

    fn visit_i64<E>(self, _: i64) -> Result<Extras, E> {
        Ok(Extras(None))
    }

    fn visit_u64<E>(self, _: u64) -> Result<Extras, E> {
        Ok(Extras(None))
    }

    fn visit_f64<E>(self, _: f64) -> Result<Extras, E> {
        Ok(Extras(None))
    }

    fn visit_str<E>(self, _: &str) -> Result<Extras, E> {
        Ok(Extras(None))
    }

    fn visit_unit<E>(self) -> Result<Extras, E> {
        Ok(Extras(None))
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

/// Boxes keep it small where it is empty, as most are.
#[derive(Debug, Deserialize)]
pub(super) struct Node {
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<IgnoredAny>,
    pub(super) matrix: Option<Box<[f64; 16]>>,
    pub(super) translation: Option<Box<[f64; 3]>>,
    pub(super) rotation: Option<Box<[f64; 4]>>,
    pub(super) scale: Option<Box<[f64; 3]>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub(super) primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<String, usize>,
    pub(super) indices: Option<usize>,
    pub(super) mode: Option<u64>,
    #[serde(default)]
    pub(super) extensions: BTreeMap<String, IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u64,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
    #[serde(default)]
    extensions: ViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Box<Packed>>,
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Box<Packed>>,
}

/// How a view is compressed.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Packed {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: u64,
    pub(super) count: u64,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) byte_length: u64,
    pub(super) uri: Option<String>,
}

impl BufferView {
    /// How it is compressed, if it is.
    pub(super) fn packed(&self) -> Option<&Packed> {
        self.extensions.ext.as_deref().or(self.extensions.khr.as_deref())
    }
}

impl Asset {
    /// The lines in which terrabite says what the mesh is; `None` in files of other programs.
    pub(super) fn facts(&self) -> Option<Vec<String>> {
        self.texts("facts")
    }

    /// The names of attributes in their order, where terrabite says them.
    pub(super) fn attributes(&self) -> Vec<String> {
        self.texts("attributes").unwrap_or_default()
    }

    fn texts(&self, name: &str) -> Option<Vec<String>> {
        let texts = self.extras.0.as_ref()?.get(name)?.as_array()?;
        Some(texts.iter().filter_map(|text| text.as_str()).map(one_line).collect())
    }
}

/// A text as a header has it.
pub(super) fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ").trim_end().to_string()
}
