//! STL's writer.

mod rim;

use std::path::{Path, PathBuf};

use super::FORMAT;
use crate::base::CoordinateFrame;
use crate::base::control::CancelToken;
use crate::base::external::Scratch;
use crate::base::staged::StagedFile;
use crate::formats::output::Output;
use crate::formats::wording::Placer;
use crate::formats::{Base, Bounds, Contents, Header, Needs, Setup, Sink, SinkError};
use rim::{Rim, Wall};

/// Binary STL: 80 bytes of header, a count, and for each triangle its normal and its three corners in single precision.
///
/// The header is a text of 40 bytes (`terrabite STL; …`), then the frame as five little-endian doubles: the origin's x and y,
/// the factors of x and y, and the factor of heights.
///
/// With a base ([`crate::formats::SinkOptions::base`]) the file is a closed solid, and the header's text tells how many
/// triangles the surface has: each of them is followed by its like on the floor, turned over; at the end come the walls,
/// two triangles below each edge that belongs to one triangle only. So the file has 2 × T + 2 × B triangles.
///
/// Memory: one buffer of a megabyte. For a solid 10 MB more to find the rim, and 20 MB to sort it; in temporary files 40 bytes
/// for each edge that has no neighbour among the triangles that come with it.
#[derive(Debug)]
pub struct StlSink {
    output: Output,
    frame: CoordinateFrame,
    placer: Placer,
    base: Option<Base>,
    temp_dir: Option<PathBuf>,
    cancel: CancelToken,
    solid: Option<Solid>,
    /// Triangles in the file so far.
    count: u64,
}

/// What a solid has beside its surface.
#[derive(Debug)]
struct Solid {
    /// z of the floor.
    floor: f32,
    rim: Rim,
    scratch: Scratch,
}

/// A corner of a triangle, as it stands in the file.
type Corner = [f32; 3];

/// Where the count stands.
const COUNT_AT: u64 = 80;

/// What the text of the header takes.
const TEXT_BYTES: usize = 40;

impl StlSink {
    /// Writes to `staged`: in single precision, whatever the frame says.
    pub fn new(staged: StagedFile, setup: Setup) -> StlSink {
        let frame = CoordinateFrame { single: true, ..setup.header.frame };
        let setup = Setup { header: Header { frame, ..setup.header }, ..setup };
        let placer = Placer::of(&setup);
        let Setup { options, temp_dir, cancel, .. } = setup;
        StlSink {
            output: Output::new(staged),
            frame,
            placer,
            base: options.base,
            temp_dir,
            cancel,
            solid: None,
            count: 0,
        }
    }

    fn check_count(&self, found: u64) -> Result<(), SinkError> {
        let limit = FORMAT.limits.triangles;
        if found <= limit {
            return Ok(());
        }
        let (path, what) = (self.output.path().to_path_buf(), "triangles with walls and floor");
        Err(SinkError::TooLarge { path, format: FORMAT.title, what, limit, found })
    }

    /// z of the floor, below all vertices.
    fn floor(&self, base: Base, bounds: Option<Bounds>) -> Result<f32, SinkError> {
        let lowest = bounds.map(|bounds| self.frame.height(self.placer.bounds(bounds).min[2]));
        let height = match base {
            Base::Height(height) => height,
            Base::Depth(depth) => lowest.unwrap_or(0.0) - depth,
        };
        let z = self.frame.written_height(height);
        let is_below = lowest.is_none_or(|lowest| height < lowest && z < self.frame.written_height(lowest));
        if is_below && z.is_finite() {
            return Ok(z as f32);
        }
        let expected = match lowest {
            Some(lowest) => format!("a floor below the lowest vertex, which is at {lowest}"),
            None => "a floor at a finite height".to_string(),
        };
        let found = match lowest {
            Some(lowest) if height < lowest => format!("one at {height}, which single precision does not tell from it"),
            _ => format!("one at {height}"),
        };
        Err(SinkError::Unfit { path: self.output.path().to_path_buf(), expected, found })
    }

    /// The corners as they stand in the file.
    fn placed(&self, corners: &[[f64; 3]; 3]) -> Result<[Corner; 3], SinkError> {
        placed(&self.placer, self.output.path(), corners)
    }

    fn push(&mut self, corners: [Corner; 3]) -> Result<(), SinkError> {
        self.output.buffer().extend_from_slice(&record(corners));
        self.count += 1;
        self.output.drain()
    }

    fn push_walls(&mut self, Solid { floor, rim, scratch }: Solid) -> Result<(), SinkError> {
        let edges = rim.edges(&scratch)?;
        self.check_count(self.count + 2 * edges.count())?;
        edges.for_each_wall(|Wall { from, to, is_at_the_start }| {
            let bottom = |[x, y, _]: Corner| [x, y, floor];
            match is_at_the_start {
                true => self.push([to, from, bottom(from)]),
                false => self.push([to, bottom(from), bottom(to)]),
            }
        })
    }
}

impl Sink for StlSink {
    fn needs(&self) -> Needs {
        Needs { bounds: self.base.is_some(), corners: true, ..Needs::default() }
    }

    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        let triangles = contents.triangles;
        let text = match self.base {
            None => "terrabite STL; 5 f64: offset x y, scales".to_string(),
            Some(base) => {
                self.check_count(2 * triangles)?;
                let floor = self.floor(base, contents.bounds)?;
                let scratch = Scratch::new(self.temp_dir.as_deref(), self.cancel.clone());
                self.solid = Some(Solid { floor, rim: Rim::default(), scratch });
                format!("terrabite STL, {triangles} on base; 5 f64")
            }
        };
        let CoordinateFrame { origin, xy_scale, z_scale, .. } = self.frame;
        let buffer = self.output.buffer();
        buffer.extend_from_slice(format!("{text:TEXT_BYTES$}").as_bytes());
        for value in [origin.0, origin.1, xy_scale.0, xy_scale.1, z_scale] {
            buffer.extend_from_slice(&value.to_le_bytes());
        }
        // That of a solid is known at the end.
        buffer.extend_from_slice(&(triangles as u32).to_le_bytes());
        Ok(())
    }

    /// Nothing of them stands in the file, but heights that may not be lost are found here.
    fn vertices(&mut self, vertices: &[[f64; 3]], _: &[&[f64]]) -> Result<(), SinkError> {
        for vertex in vertices {
            self.placer.place(self.output.path(), *vertex)?;
        }
        Ok(())
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], corners: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        assert_eq!(triangles.len(), corners.len(), "corners");
        let Some(mut solid) = self.solid.take() else {
            let (placer, path) = (self.placer, self.output.path().to_path_buf());
            self.count += triangles.len() as u64;
            return self.output.put_side_by_side(corners, |bytes, _, corners| {
                bytes.extend_from_slice(&record(placed(&placer, &path, corners)?));
                Ok(())
            });
        };
        for (triangles, corners) in triangles.chunks(rim::AT_ONCE).zip(corners.chunks(rim::AT_ONCE)) {
            let (placer, path, floor) = (self.placer, self.output.path().to_path_buf(), solid.floor);
            self.count += 2 * triangles.len() as u64;
            self.output.put_side_by_side(corners, |bytes, _, corners| {
                let top = placed(&placer, &path, corners)?;
                let [a, b, c] = top.map(|[x, y, _]| [x, y, floor]);
                bytes.extend_from_slice(&record(top));
                bytes.extend_from_slice(&record([a, c, b]));
                Ok(())
            })?;
            solid.rim.take(triangles, |i| self.placed(&corners[i]), &solid.scratch)?;
        }
        self.solid = Some(solid);
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), SinkError> {
        if let Some(solid) = self.solid.take() {
            self.push_walls(solid)?;
            let count = self.count as u32;
            self.output.replace(COUNT_AT, &count.to_le_bytes())?;
        }
        self.output.commit()
    }
}

fn placed(placer: &Placer, path: &Path, corners: &[[f64; 3]; 3]) -> Result<[Corner; 3], SinkError> {
    let [a, b, c] = *corners;
    let corner = |vertex| placer.place(path, vertex).map(|[x, y, z]| [x as f32, y as f32, z as f32]);
    Ok([corner(a)?, corner(b)?, corner(c)?])
}

/// A triangle as it stands in the file.
fn record(corners: [Corner; 3]) -> [u8; 50] {
    let mut record = [0; 50];
    let [a, b, c] = corners;
    let vectors = [normal(corners), a, b, c];
    for (bytes, number) in record.as_chunks_mut().0.iter_mut().zip(vectors.as_flattened()) {
        *bytes = number.to_le_bytes();
    }
    record
}

/// The unit normal of what stands in the file; zero where there is none.
fn normal([a, b, c]: [Corner; 3]) -> Corner {
    let minus = |p: f32, q: f32| f64::from(p) - f64::from(q);
    let from_a = |p: Corner| [minus(p[0], a[0]), minus(p[1], a[1]), minus(p[2], a[2])];
    let (u, v) = (from_a(b), from_a(c));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
    // Zero is no number that is written with a sign.
    let unit = |n: f64| (n / length) as f32 + 0.0;
    if length > 0.0 && length.is_finite() { [unit(cross[0]), unit(cross[1]), unit(cross[2])] } else { [0.0; 3] }
}

#[cfg(test)]
mod tests;
