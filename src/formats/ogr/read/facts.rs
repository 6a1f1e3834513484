//! What terrabite says of a mesh in the metadata of its layer.

use std::path::Path;

use gdal::Metadata;
use gdal::vector::Layer;
use serde_json::Value;

use super::OgrError;
use crate::base::channels::{Channel, Number};
use crate::formats::{Header, lines};

/// The item that has it.
pub(super) const ITEM: &str = "terrabite";

/// The facts of a mesh that terrabite has written.
#[derive(Debug)]
pub(super) struct Facts {
    pub(super) header: Header,
    pub(super) triangles: u64,
    pub(super) attributes: Vec<Channel>,
    /// Edges that follow lines, in another layer.
    pub(super) edges: u64,
}

/// Those of a layer; `None` for one of another origin.
pub(super) fn of_layer(path: &Path, layer: &Layer<'_>) -> Result<Option<Facts>, OgrError> {
    let Some(text) = layer.metadata_item(ITEM, "") else { return Ok(None) };
    let facts = serde_json::from_str(&text).ok().as_ref().and_then(facts);
    facts.map(Some).ok_or_else(|| OgrError::Header {
        path: path.to_path_buf(),
        expected: format!("triangles, attributes and facts in JSON under {ITEM:?}"),
        found: text.chars().take(80).collect(),
    })
}

fn facts(value: &Value) -> Option<Facts> {
    let lines: Option<Vec<&str>> =
        value.get("facts")?.as_array()?.iter().map(|l| l.as_str().map(str::trim_end)).collect();
    let attributes: Option<Vec<Channel>> = value.get("attributes")?.as_array()?.iter().map(attribute).collect();
    let edges = value.get("edges").map_or(Some(0), Value::as_u64)?;
    let triangles = value.get("triangles")?.as_u64()?;
    Some(Facts { header: lines::header(lines?), triangles, attributes: attributes?, edges })
}

fn attribute(value: &Value) -> Option<Channel> {
    let number = match value.get("number")?.as_str()? {
        "u8" => Number::U8,
        "f32" => Number::F32,
        "f64" => Number::F64,
        _ => return None,
    };
    Some(Channel { name: value.get("name")?.as_str()?.to_string(), number })
}
