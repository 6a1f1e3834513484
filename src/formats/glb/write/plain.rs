//! A GLB without compression, from front to back.

use super::super::FORMAT;
use super::document::{Buffers, Part, Stretch, document, front, too_long};
use super::layout::{Layout, y_up};
use crate::base::Texture;
use crate::formats::output::Output;
use crate::formats::wording::Placer;
use crate::formats::{Bounds, Contents, Header, SinkError};

/// The most vertices that are numbered in 16 bits: the largest number restarts a primitive.
const SHORT: u64 = u16::MAX as u64;

/// What counts and bounds tell is written first, then everything streams.
pub(super) struct Plain {
    output: Output,
    header: Header,
    placer: Placer,
    texture: Option<Texture>,
    layout: Layout,
    corner_bytes: usize,
    /// Nothing is written of a mesh without triangles.
    is_empty: bool,
    /// Bytes that fill up the BIN chunk.
    padding: usize,
}

impl Plain {
    pub(super) fn new(output: Output, header: Header, placer: Placer, texture: Option<Texture>) -> Plain {
        Plain {
            output,
            header,
            placer,
            texture,
            layout: Layout::default(),
            corner_bytes: 4,
            is_empty: false,
            padding: 0,
        }
    }

    pub(super) fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        let path = self.output.path();
        FORMAT.limits.check(FORMAT.title, path, contents)?;
        self.layout = Layout::new(path, contents, self.texture.is_some())?;
        let Contents { vertices, triangles, bounds, .. } = *contents;
        self.is_empty = vertices == 0 || triangles == 0;
        self.corner_bytes = if vertices <= SHORT { 2 } else { 4 };
        let (mut parts, mut bin) = (Vec::new(), 0);
        if !self.is_empty {
            let corners = u128::from(triangles) * 3;
            let bytes = u128::from(vertices) * self.layout.stride as u128 + corners * self.corner_bytes as u128;
            let bytes = u64::try_from(bytes).unwrap_or(u64::MAX);
            bin = Some(bytes).filter(|b| *b <= u64::from(u32::MAX)).ok_or_else(|| too_long(path, bytes))?;
            let (min, max) = self.extent(bounds.unwrap_or(Bounds::EMPTY))?;
            let offset = vertices * self.layout.stride as u64;
            parts.push(Part {
                vertices: Stretch { count: vertices, offset: 0, packed: None },
                corners: Stretch { count: 3 * triangles, offset, packed: None },
                corner_bytes: self.corner_bytes as u64,
                min,
                max,
            });
        }
        let mesh = bin.next_multiple_of(4);
        self.padding = (mesh - bin) as usize;
        let jpeg = self.texture.as_ref().filter(|_| !self.is_empty).map(|texture| texture.jpeg.len() as u64);
        let texture = jpeg.map(|length| (mesh, length));
        let bin = if jpeg.is_some() { mesh + jpeg.unwrap_or(0) } else { bin };
        let padded = bin.next_multiple_of(4);
        let json = document(&self.header, &self.layout, &parts, Buffers { bin, unpacked: None, texture });
        let front = front(self.output.path(), &json, padded)?;
        self.output.buffer().extend_from_slice(&front);
        self.output.drain()
    }

    /// Between what positions lie.
    fn extent(&self, bounds: Bounds) -> Result<([f32; 3], [f32; 3]), SinkError> {
        let Bounds { min: low, max: high } = self.placer.bounds(bounds);
        // North is where the third coordinate is least.
        let extent = (y_up([low[0], high[1], low[2]]), y_up([high[0], low[1], high[2]]));
        match extent.0.iter().chain(&extent.1).all(|v| v.is_finite()) {
            true => Ok(extent),
            false => Err(SinkError::Unfit {
                path: self.output.path().to_path_buf(),
                expected: "coordinates that are finite in single precision".to_string(),
                found: format!("vertices between {low:?} and {high:?}"),
            }),
        }
    }

    pub(super) fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        if self.layout.fields.len() == 1 && !self.is_empty {
            let (placer, path) = (self.placer, self.output.path().to_path_buf());
            let position = |vertex: &[f64; 3]| Ok(y_up(placer.place(&path, *vertex)?).map(f32::to_le_bytes));
            return self.output.put_all(vertices, |vertex| position(vertex).map(bytemuck::cast::<_, [u8; 12]>));
        }
        for (i, vertex) in vertices.iter().enumerate() {
            let place = self.placer.place(self.output.path(), *vertex)?;
            if !self.is_empty {
                let at = self.texture.as_ref().map_or([0.0; 2], |texture| texture.at(vertex[0], vertex[1]));
                self.layout.append(self.output.buffer(), place, at, attributes, i);
                self.output.drain()?;
            }
        }
        Ok(())
    }

    pub(super) fn triangles(&mut self, triangles: &[[u64; 3]]) -> Result<(), SinkError> {
        match self.corner_bytes {
            2 => self
                .output
                .put_all(triangles, |t| Ok::<[u8; 6], _>(bytemuck::cast(t.map(|v| (v as u16).to_le_bytes())))),
            _ => self
                .output
                .put_all(triangles, |t| Ok::<[u8; 12], _>(bytemuck::cast(t.map(|v| (v as u32).to_le_bytes())))),
        }
    }

    pub(super) fn finish(mut self) -> Result<(), SinkError> {
        let padding = [0; 4];
        self.output.buffer().extend_from_slice(&padding[..self.padding]);
        if let Some(texture) = self.texture.as_ref().filter(|_| !self.is_empty) {
            let length = texture.jpeg.len();
            self.output.buffer().extend_from_slice(&texture.jpeg);
            self.output.buffer().extend_from_slice(&padding[..length.next_multiple_of(4) - length]);
        }
        self.output.commit()
    }
}
