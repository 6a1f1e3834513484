//! The sink.

use std::io::ErrorKind;

use serde_json::json;

use super::driver::Driver;
use super::layer::{Plan, TinLayer};
use super::link::Link;
use super::values::Values;
use crate::base::channels::Channel;
use crate::base::staged::StagedFile;
use crate::base::{CoordinateFrame, LineEdge};
use crate::formats::joiner::Joiner;
use crate::formats::ogr::FORMAT;
use crate::formats::wording::{Placer, facts};
use crate::formats::{Contents, Marks, Needs, OgrGeometry, Setup, Sink, SinkError};

/// A layer of GDAL's with a feature for each triangle: a polygon with heights, counter-clockwise; or TINs with heights, of many
/// triangles each.
///
/// GeoPackage or FlatGeobuf. An attribute is three fields, NAME_1 to NAME_3: its value at each corner, in the order of the ring;
/// TINs have one triangle each then. In GeoPackage the header is an item of the layer's metadata, in JSON; FlatGeobuf has the CRS
/// alone, so it takes no frame but the plain one. Edges that follow lines are a second layer of the GeoPackage, as lines that go
/// from place to place; FlatGeobuf has one layer, and no marks.
///
/// Memory: some megabytes. Temporary file: 8 bytes for each attribute of each vertex.
#[derive(Debug)]
pub struct OgrSink {
    // Closed before the staged file is removed.
    layer: Option<TinLayer>,
    staged: StagedFile,
    driver: &'static Driver,
    setup: Setup,
    values: Option<Values>,
    triangles: Vec<[[f64; 3]; 3]>,
    /// The attributes of all corners of those triangles.
    at_corners: Vec<f64>,
    of_tin: usize,
    lines: Joiner,
    has_lines: bool,
}

/// Triangles that are written together.
const BATCH: usize = 8192;

/// Triangles of a TIN: few enough that whoever reads it has no trouble to hold one.
const TRIANGLES_OF_TIN: usize = 4096;

impl OgrSink {
    /// Writes to `staged`, in the format of GDAL that the options or the extension name.
    ///
    /// # Errors
    /// [`SinkError::Unfit`] for a format that loses what a mesh is, or the frame of this one.
    pub fn new(staged: StagedFile, setup: Setup) -> Result<OgrSink, SinkError> {
        let driver = Driver::choose(staged.path(), setup.options.ogr_driver)?;
        let sink = OgrSink {
            layer: None,
            staged,
            driver,
            setup,
            values: None,
            triangles: Vec::with_capacity(BATCH),
            at_corners: Vec::new(),
            of_tin: TRIANGLES_OF_TIN,
            lines: Joiner::default(),
            has_lines: false,
        };
        if !driver.keeps_header && sink.setup.header.frame != CoordinateFrame::PLAIN {
            let found =
                "coordinates in single precision, less an origin or scaled: a GeoPackage keeps them".to_string();
            let expected =
                format!("coordinates of the map in double precision, the only ones that {} keeps", driver.name);
            return Err(sink.unfit(&expected, found));
        }
        Ok(sink)
    }

    fn unfit(&self, expected: &str, found: String) -> SinkError {
        SinkError::Unfit { path: self.staged.path().to_path_buf(), expected: expected.to_string(), found }
    }

    fn geometry(&self) -> OgrGeometry {
        self.setup.options.ogr_geometry.unwrap_or(OgrGeometry::Polygon)
    }

    /// Fields are told apart without regard to upper and lower case.
    fn check(&self, attributes: &[Channel]) -> Result<(), SinkError> {
        let twice = (1..attributes.len())
            .find(|&i| attributes[..i].iter().any(|a| a.name.eq_ignore_ascii_case(&attributes[i].name)));
        match twice {
            None => Ok(()),
            Some(i) => {
                let name = &attributes[i].name;
                let first = attributes[..i].iter().find(|a| a.name.eq_ignore_ascii_case(name)).expect("found above");
                let expected = "attributes whose names differ in more than upper and lower case";
                Err(self.unfit(expected, format!("{:?} and {name:?}", first.name)))
            }
        }
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        let layer = self.layer.as_mut().expect("begun");
        if !self.triangles.is_empty() {
            layer.write(&self.triangles, &self.at_corners, self.of_tin)?;
        }
        self.triangles.clear();
        self.at_corners.clear();
        Ok(())
    }
}

/// Who reads it is to know what is missing, so the triangles are counted.
fn header(setup: &Setup, contents: &Contents<'_>) -> String {
    let mut header =
        json!({ "triangles": contents.triangles, "attributes": contents.attributes, "facts": facts(&setup.header) });
    if contents.edges > 0 {
        header["edges"] = contents.edges.into();
    }
    header.to_string()
}

impl Sink for OgrSink {
    fn needs(&self) -> Needs {
        let edges = if self.driver.has_layers { Marks::Places } else { Marks::None };
        Needs { corners: true, edges, ..Needs::default() }
    }

    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.setup.header.complete(contents);
        FORMAT.limits.check(FORMAT.title, self.staged.path(), contents)?;
        self.check(contents.attributes)?;
        let temp_dir = self.setup.temp_dir.as_deref();
        if !contents.attributes.is_empty() {
            self.values = Some(Values::new(contents.attributes.len(), temp_dir, self.setup.cancel.clone())?);
            self.of_tin = 1;
        }
        let partial = self.staged.partial_path();
        let link = Link::to(partial, self.driver.extension, temp_dir).map_err(|e| self.staged.write_error(e))?;
        // Drivers make a file, and take none that is there.
        match std::fs::remove_file(partial) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(self.staged.write_error(e).into()),
            _ => {}
        }
        let header = &self.setup.header;
        let plan = Plan {
            driver: self.driver,
            geometry: self.geometry(),
            attributes: contents.attributes,
            crs: header.crs.definition.as_deref().filter(|_| !header.frame.is_local()),
            header: self::header(&self.setup, contents),
            has_lines: contents.edges > 0,
            lines_have_types: contents.edges_have_types,
        };
        self.has_lines = plan.has_lines;
        self.layer = Some(TinLayer::create(link, self.staged.path(), &plan)?);
        self.staged.keep_private().map_err(|e| self.staged.write_error(e))?;
        Ok(())
    }

    fn lines(&mut self, edges: &[LineEdge<[f64; 3]>]) -> Result<(), SinkError> {
        let placer = Placer::of(&self.setup);
        let mut lines = Vec::new();
        for LineEdge { ends: [from, to], line_type } in edges {
            let path = self.staged.path();
            let ends = [placer.place(path, *from)?, placer.place(path, *to)?];
            lines.extend(self.lines.push(LineEdge { ends, line_type: *line_type }));
        }
        self.layer.as_mut().expect("begun").write_lines(&lines)
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], attributes: &[&[f64]]) -> Result<(), SinkError> {
        // Found before the triangles come.
        for vertex in vertices {
            Placer::of(&self.setup).place(self.staged.path(), *vertex)?;
        }
        match &mut self.values {
            Some(values) => Ok(values.push(vertices.len(), attributes)?),
            None => Ok(()),
        }
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], corners: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        assert_eq!(triangles.len(), corners.len(), "corners");
        let placer = Placer::of(&self.setup);
        for (triangle, corners) in triangles.iter().zip(corners) {
            let [a, b, c] = corners.map(|corner| placer.place(self.staged.path(), corner));
            self.triangles.push([a?, b?, c?]);
            if let Some(values) = &mut self.values {
                for vertex in triangle {
                    values.get(*vertex, &mut self.at_corners)?;
                }
            }
            if self.triangles.len() == BATCH {
                self.flush()?;
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), SinkError> {
        self.flush()?;
        let mut layer = self.layer.take().expect("begun");
        if self.has_lines {
            layer.write_lines(&Vec::from_iter(self.lines.finish()))?;
        }
        layer.close()?;
        let OgrSink { staged, .. } = *self;
        Ok(staged.commit()?)
    }
}
