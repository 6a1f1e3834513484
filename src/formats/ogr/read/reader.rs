//! A layer as a mesh of any format.

use std::ops::ControlFlow;
use std::path::Path;

use crc32fast::Hasher;
use gdal::vector::{Feature, LayerAccess};

use super::OgrError;
use super::facts::{self, Facts};
use super::layer::MeshLayer;
use super::wkb::Corners;
use crate::base::channels::{Channel, Number};
use crate::base::external::Scratch;
use crate::formats::ends::Ends;
use crate::formats::weld::{Welded, Welder};
use crate::formats::{EdgeVisitor, FaceVisitor, Header, MeshReader, ReadError, ReadOptions, VertexVisitor};

/// A layer as a [`MeshReader`]. What terrabite has written in its metadata is the header; else it is the layer's CRS.
#[derive(Debug)]
pub struct OgrReader {
    layer: MeshLayer,
    header: Header,
    attributes: Vec<Channel>,
    scratch: Scratch,
    welded: Welded,
    faces: u64,
    edges: u64,
    /// Of all corners.
    checksum: u32,
}

impl OgrReader {
    /// Opens a file, and reads its layer once.
    ///
    /// # Errors
    /// [`OgrError`]: nothing that OGR opens, not one layer, features that are no triangles with heights, fewer than there should
    /// be.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<OgrReader, OgrError> {
        let layer = MeshLayer::open(path, &options.cancel)?;
        let facts = facts::of_layer(path, &layer.layer()?)?;
        let scratch = Scratch::new(options.temp_dir.as_deref(), options.cancel.clone());
        let mut welder = Welder::new(&scratch);
        let (mut faces, mut checksum) = (0, Hasher::new());
        let features = layer.for_each_feature(&mut |_, triangles| {
            faces += triangles.len() as u64;
            checksum.update(bytemuck::cast_slice(triangles));
            triangles.as_flattened().iter().try_for_each(|corner| welder.push(*corner))?;
            Ok(ControlFlow::Continue(()))
        })?;
        let said =
            layer.layer()?.try_feature_count().filter(|said| features < *said).map(|said| ("features", said, features));
        let of_facts = facts.as_ref().filter(|facts| facts.triangles != faces);
        let of_facts = of_facts.map(|facts| ("triangles", facts.triangles, faces));
        if let Some((what, expected, found)) = said.or(of_facts) {
            return Err(OgrError::Count { path: path.to_path_buf(), what, expected, found });
        }
        let welded = welder.finish()?;
        let (header, attributes, edges) = match facts {
            Some(Facts { header, attributes, edges, .. }) => (header, attributes, edges),
            None => (layer.header()?, layer.attributes()?, 0),
        };
        // They are there.
        attributes.iter().try_for_each(|attribute| layer.fields(&attribute.name).map(drop))?;
        Ok(OgrReader { layer, header, attributes, scratch, welded, faces, edges, checksum: checksum.finalize() })
    }

    fn pass(&self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), OgrError> {
        let wanted: Result<Vec<Wanted>, OgrError> = attributes.iter().map(|name| self.wanted(name)).collect();
        let wanted = wanted?;
        let changed = || OgrError::Changed { path: self.layer.path().to_path_buf(), expected: self.faces };
        let mut numbers = self.welded.numbers(&self.scratch);
        let (mut next, mut checksum, mut values) = (0, Hasher::new(), vec![0.0; wanted.len()]);
        let mut is_enough = false;
        self.layer.for_each_feature(&mut |feature, triangles: &[Corners]| {
            checksum.update(bytemuck::cast_slice(triangles));
            for (i, place) in triangles.as_flattened().iter().enumerate() {
                if numbers.next().ok_or_else(changed)?? != next {
                    continue;
                }
                for (value, wanted) in values.iter_mut().zip(&wanted) {
                    *value = self.value(feature, wanted, i % 3)?;
                }
                if visit(next, *place, &values).is_break() {
                    is_enough = true;
                    return Ok(ControlFlow::Break(()));
                }
                next += 1;
            }
            Ok(ControlFlow::Continue(()))
        })?;
        if !is_enough && (numbers.next().is_some() || checksum.finalize() != self.checksum) {
            return Err(changed());
        }
        Ok(())
    }

    fn wanted(&self, name: &str) -> Result<Wanted, OgrError> {
        let attribute = self.attributes.iter().find(|attribute| attribute.name == name).expect("asked for before");
        Ok(Wanted { name: name.to_string(), number: attribute.number, fields: self.layer.fields(name)? })
    }

    /// The value at a corner. Databases have nothing in the place of a number that is none.
    fn value(&self, feature: &Feature<'_>, wanted: &Wanted, corner: usize) -> Result<f64, OgrError> {
        let found = feature.field_as_double(wanted.fields[corner]).ok().flatten();
        let value = found.unwrap_or(f64::NAN);
        let (is_fit, expected) = match wanted.number {
            Number::U8 => (value.fract() == 0.0 && (0.0..=255.0).contains(&value), "a whole number from 0 to 255"),
            Number::F32 => (value.is_nan() || f64::from(value as f32) == value, "a number of single precision"),
            Number::F64 => (true, "a number"),
        };
        if is_fit {
            return Ok(value);
        }
        Err(OgrError::Feature {
            path: self.layer.path().to_path_buf(),
            feature: feature.fid().unwrap_or_default(),
            expected: format!("{expected} in the field {}_{}", wanted.name, corner + 1),
            found: found.map_or("nothing".to_string(), |value| value.to_string()),
        })
    }
}

/// An attribute that a visitor asks for.
struct Wanted {
    name: String,
    number: Number,
    fields: [usize; 3],
}

impl MeshReader for OgrReader {
    fn path(&self) -> &Path {
        self.layer.path()
    }

    fn vertex_count(&self) -> u64 {
        self.welded.vertices()
    }

    fn face_count(&self) -> u64 {
        self.faces
    }

    fn header(&self) -> &Header {
        &self.header
    }

    fn attributes(&self) -> &[Channel] {
        &self.attributes
    }

    fn vertices(&mut self, attributes: &[&str], visit: &mut VertexVisitor<'_>) -> Result<(), ReadError> {
        let reader: &dyn MeshReader = self;
        reader.must_have(attributes)?;
        Ok(self.pass(attributes, visit)?)
    }

    fn faces(&mut self, visit: &mut FaceVisitor<'_>) -> Result<(), ReadError> {
        let mut numbers = self.welded.numbers(&self.scratch);
        for face in 0..self.faces {
            let mut corner = || numbers.next().expect("three for each face");
            let corners = [corner()?, corner()?, corner()?];
            if visit(face, corners).is_break() {
                break;
            }
        }
        Ok(())
    }

    fn edge_count(&self) -> u64 {
        self.edges
    }

    fn edges_have_types(&self) -> bool {
        self.edges > 0 && self.layer.lines_have_types()
    }

    fn edges(&mut self, visit: &mut EdgeVisitor<'_>) -> Result<(), ReadError> {
        if self.edges == 0 {
            return Ok(());
        }
        let (mut ends, mut found) = (Ends::new(&self.scratch), 0);
        self.layer.for_each_line(|points, line_type| {
            found += points.len().saturating_sub(1) as u64;
            Ok(ends.line(points, line_type)?)
        })?;
        let (path, expected) = (self.layer.path(), self.edges);
        if found != expected {
            return Err(OgrError::Count { path: path.to_path_buf(), what: "edges", expected, found }.into());
        }
        let mut failed = None;
        self.pass(&[], &mut |vertex, place, _| match ends.vertex(vertex, place) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                failed = Some(error);
                ControlFlow::Break(())
            }
        })?;
        match failed {
            Some(error) => Err(error.into()),
            None => ends.visit(path, visit),
        }
    }
}
