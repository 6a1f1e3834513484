//! How a vertex stands in a GLB: its accessors, and the bytes of its record.

use std::path::Path;

use super::super::FORMAT;
use crate::base::channels::{Channel, Number};
use crate::formats::{Contents, SinkError};

/// The most bytes from one vertex to the next that glTF allows.
const STRIDE: usize = 252;

/// What vertices have, in the order in which it stands in their records.
#[derive(Debug, Default)]
pub(super) struct Layout {
    /// The position first.
    pub(super) fields: Vec<Field>,
    /// Bytes of a record.
    pub(super) stride: usize,
    /// The names of the attributes in their order, where the fields do not tell it: colours are one field.
    pub(super) names: Vec<String>,
}

/// One accessor.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) semantic: String,
    pub(super) kind: Kind,
    pub(super) offset: usize,
    /// The attributes whose values it has.
    sources: [usize; 3],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Position,
    Normal,
    /// A place in the texture.
    Texture,
    /// Three bytes, and an alpha of 255.
    Colour,
    Single,
    /// One byte, and three that fill up.
    Byte,
}

impl Kind {
    fn bytes(self) -> usize {
        match self {
            Kind::Position | Kind::Normal => 12,
            Kind::Texture => 8,
            Kind::Colour | Kind::Single | Kind::Byte => 4,
        }
    }
}

impl Layout {
    /// The layout of such vertices, with a place in a texture or without.
    ///
    /// # Errors
    /// [`SinkError::DoubleAttribute`]; [`SinkError::Unfit`] if there are too many attributes.
    pub(super) fn new(path: &Path, contents: &Contents<'_>, has_texture: bool) -> Result<Layout, SinkError> {
        let Contents { attributes, has_normals, .. } = *contents;
        if let Some(double) = attributes.iter().find(|a| a.number == Number::F64) {
            let name = double.name.clone();
            return Err(SinkError::DoubleAttribute { path: path.to_path_buf(), format: FORMAT.title, name });
        }
        let further = attributes.len() - if has_normals { 3 } else { 0 };
        let mut layout = Layout::default();
        layout.push("POSITION", Kind::Position, [0; 3]);
        if has_normals {
            layout.push("NORMAL", Kind::Normal, [further, further + 1, further + 2]);
        }
        if has_texture {
            layout.push("TEXCOORD_0", Kind::Texture, [0; 3]);
        }
        let colour = colour(&attributes[..further]);
        if colour.is_some() {
            layout.names = attributes.iter().map(|a| a.name.clone()).collect();
        }
        for (i, Channel { name, number }) in attributes[..further].iter().enumerate() {
            match colour {
                Some(sources) if sources[0] == i => layout.push("COLOR_0", Kind::Colour, sources),
                Some(sources) if sources.contains(&i) => {}
                _ => {
                    let kind = if *number == Number::U8 { Kind::Byte } else { Kind::Single };
                    layout.push(&format!("_{name}"), kind, [i; 3]);
                }
            }
        }
        if layout.stride > STRIDE {
            return Err(SinkError::Unfit {
                path: path.to_path_buf(),
                expected: format!("vertices of at most {STRIDE} bytes in a GLB"),
                found: format!("{} attributes, which make {} bytes", attributes.len(), layout.stride),
            });
        }
        Ok(layout)
    }

    fn push(&mut self, semantic: &str, kind: Kind, sources: [usize; 3]) {
        self.fields.push(Field { semantic: semantic.to_string(), kind, offset: self.stride, sources });
        self.stride += kind.bytes();
    }

    /// Appends the record of a vertex that stands at `place` in its frame and at `at` in the texture, and is number `i` of those
    /// with these attributes.
    pub(super) fn append(&self, record: &mut Vec<u8>, place: [f64; 3], at: [f64; 2], attributes: &[&[f64]], i: usize) {
        for Field { kind, sources, .. } in &self.fields {
            let value = |source: usize| attributes[sources[source]][i];
            match kind {
                Kind::Position => append_vector(record, place),
                Kind::Normal => append_vector(record, [value(0), value(1), value(2)]),
                Kind::Texture => at.iter().for_each(|share| record.extend_from_slice(&(*share as f32).to_le_bytes())),
                Kind::Colour => record.extend_from_slice(&[value(0) as u8, value(1) as u8, value(2) as u8, u8::MAX]),
                Kind::Single => record.extend_from_slice(&(value(0) as f32).to_le_bytes()),
                Kind::Byte => record.extend_from_slice(&[value(0) as u8, 0, 0, 0]),
            }
        }
    }
}

/// The attributes `red`, `green` and `blue`, if they are bytes.
fn colour(attributes: &[Channel]) -> Option<[usize; 3]> {
    let find = |name: &str| attributes.iter().position(|a| a.name == name && a.number == Number::U8);
    Some([find("red")?, find("green")?, find("blue")?])
}

fn append_vector(record: &mut Vec<u8>, vector: [f64; 3]) {
    record.extend_from_slice(y_up(vector).map(f32::to_le_bytes).as_flattened());
}

/// What stands for x, y, z where y is up.
pub(super) fn y_up([x, y, z]: [f64; 3]) -> [f32; 3] {
    [x as f32, z as f32, -(y as f32)]
}
