//! The weighted error of channels, judged in a pass of its own.

use rayon::prelude::*;
use serde::Serialize;

use crate::base::channels::ChannelBands;
use crate::base::control::{Control, Stage};
use crate::base::{Band, channels_of};
use crate::formats::MeshReader;

use super::VerifyError;
use super::finding::{Finding, SamplePlace};
use super::grid::{Grid, orientation};
use super::pace::Pace;
use super::ranges::Scales;
use super::samples::{BandReader, number_or_nodata};
use super::surface::{Measure, Surface};
use super::triangle::Triangle;
use super::valued::ValuedStore;
use crate::base::external::{Queue, Scratch, Sorted, Sorter};

/// What was found out about the weighted error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WeightedVerdict {
    /// w.
    #[serde(rename = "weight")]
    pub emphasis: f64,
    /// M.
    pub unit: f64,
    /// The attributes, and the ranges they are scaled by.
    pub channels: Vec<ChannelRange>,
    /// Where it is largest; `None` where no sample is covered.
    pub worst: Option<WorstWeighted>,
    /// Samples where it exceeds the tolerance, exactly.
    pub above_tolerance: Finding<SamplePlace>,
}

/// A channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelRange {
    /// The attribute's name.
    pub name: String,
    /// The least value, or that of the type.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

/// The sample with the largest weighted error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WorstWeighted {
    /// The error: rounded, but at most the tolerance if and only if the exact one is.
    pub error: f64,
    /// Which sample; the first one in row order where several have it.
    #[serde(flatten)]
    pub place: SamplePlace,
    /// The face it was measured in.
    pub face: u64,
}

/// `[first row, face, corners]`, the corners in positive order.
type Face = [u64; 5];

/// Bytes of the sort of faces.
const FACE_BYTES: usize = 16 << 20;
/// Faces held against a band at a time.
const BATCH: usize = 4 << 10;
/// Pieces a band is cut into for the threads.
const TASKS: usize = 32;

/// Judges the weighted error at every sample that the mesh covers.
///
/// A pass over the file's vertices and faces, one over each band of the raster, and one more over those whose range is
/// looked for. Memory use is constant: the sort's 16 MiB, a [`ValuedStore`], and bands of 8 MiB in all.
pub(super) fn judge_weighted(
    raster: &Band,
    mesh: &mut dyn MeshReader,
    tolerance: f64,
    options: &ChannelBands,
    scratch: &Scratch,
    control: &Control<'_>,
) -> Result<WeightedVerdict, VerifyError> {
    let named = channels_of(&options.bands);
    let names: Vec<&str> = named.iter().map(|c| c.name.as_str()).collect();
    mesh.must_have(&names)?;
    let scales = Scales::find(raster, options, control)?;
    let grid = Grid::of(raster, mesh);
    let mut pace = Pace::begin(control, Stage::Sort, mesh.vertex_count() + mesh.face_count());
    let mut store = ValuedStore::read(mesh, &names, &grid, scratch, &mut pace)?;
    let faces = sorted_faces(mesh, &mut store, &grid, scratch, &mut pace)?;
    pace.end()?;

    let measure = Measure { scales: &scales.scales, tolerance };
    let mut readers = Readers::new(raster, options);
    let mut sweep = Sweep { grid, measure, store, worst: None, above: Finding::default() };
    sweep.run(&mut readers, faces, scratch, control)?;
    let ranges = names.iter().zip(&scales.ranges);
    Ok(WeightedVerdict {
        emphasis: options.emphasis,
        unit: scales.unit,
        channels: ranges.map(|(name, &(min, max))| ChannelRange { name: name.to_string(), min, max }).collect(),
        worst: sweep.worst,
        above_tolerance: sweep.above,
    })
}

/// The faces that touch samples, by first row. Faces without an area or a place are told of by others.
fn sorted_faces<'s>(
    mesh: &mut dyn MeshReader,
    store: &mut ValuedStore<'_>,
    grid: &Grid,
    scratch: &'s Scratch,
    pace: &mut Pace<'_>,
) -> Result<Sorted<'s, 5>, VerifyError> {
    let mut sorter = Sorter::new(scratch, FACE_BYTES);
    mesh.for_each_face(|face, [a, b, c]| {
        pace.tick()?;
        let places = [store.get(a)?.place, store.get(b)?.place, store.get(c)?.place];
        let [Some(pa), Some(pb), Some(pc)] = places else { return Ok(()) };
        let Some(triangle) = Triangle::new(face, [pa, pb, pc], [0.0; 3]) else { return Ok(()) };
        let (first, last) = triangle.rows(grid);
        let [b, c] = if orientation(pa, pb, pc) > 0 { [b, c] } else { [c, b] };
        if first <= last {
            sorter.push([first as u64, face, a, b, c])?;
        }
        Ok::<(), VerifyError>(())
    })?;
    Ok(sorter.finish()?)
}

/// The heights and the channels, some rows at a time.
struct Readers<'r>(Vec<BandReader<'r>>);

impl<'r> Readers<'r> {
    fn new(raster: &'r Band, options: &'r ChannelBands) -> Self {
        let heights = if options.planar { BandReader::level(raster, &options.bands) } else { BandReader::new(raster) };
        let readers: Vec<_> = std::iter::once(heights).chain(options.bands.iter().map(BandReader::new)).collect();
        let rows = (readers[0].rows() / readers.len()).max(1);
        Readers(readers.into_iter().map(|r| r.by(rows)).collect())
    }

    /// Heights, NaN where there are none, and the channels, finite wherever there is a height.
    fn read(&mut self, index: usize) -> Result<Vec<&[f64]>, VerifyError> {
        let (heights, channels) = self.0.split_first_mut().expect("the heights come first");
        let (width, first_row) = (heights.raster().width(), index * heights.rows());
        let mut read = vec![heights.read(index)?];
        for channel in channels {
            let raster = channel.raster();
            let values = channel.read_numbers(index)?;
            let wrong = |(value, height): (&f64, &f64)| !value.is_finite() && !height.is_nan();
            if let Some(at) = values.iter().zip(read[0]).position(wrong) {
                let (path, found) = (raster.path().to_path_buf(), number_or_nodata(values[at]));
                let (column, row) = (at % width, first_row + at / width);
                return Err(VerifyError::NoValue { path, band: raster.number(), column, row, found });
            }
            read.push(values);
        }
        Ok(read)
    }
}

struct Sweep<'a> {
    grid: Grid,
    measure: Measure<'a>,
    store: ValuedStore<'a>,
    worst: Option<WorstWeighted>,
    above: Finding<SamplePlace>,
}

/// What is known of a row: error, column and face of its worst sample; which samples exceed the tolerance.
#[derive(Debug, Clone)]
struct Row {
    worst: Option<(f64, i64, u64)>,
    above: Vec<bool>,
}

impl Sweep<'_> {
    fn run(
        &mut self,
        readers: &mut Readers<'_>,
        faces: Sorted<'_, 5>,
        scratch: &Scratch,
        control: &Control<'_>,
    ) -> Result<(), VerifyError> {
        let (rows, bands) = (readers.0[0].rows(), readers.0[0].count());
        let samples = self.grid.width as u64 * self.grid.height as u64;
        control.progress.begin(Stage::Compare, bands as u64, samples);
        let mut faces = faces.peekable();
        let mut waiting = Queue::<5>::new(scratch);
        for index in 0..bands {
            let values = readers.read(index)?;
            let top = (index * rows) as i64;
            let row = Row { worst: None, above: vec![false; self.grid.width as usize] };
            let mut band = vec![row; values[0].len() / self.grid.width as usize];
            let bottom = top + band.len() as i64;
            let mut next = Queue::new(scratch);
            for piece in std::mem::replace(&mut waiting, Queue::new(scratch)).into_pieces() {
                for batch in piece?.chunks(BATCH) {
                    control.cancel.check()?;
                    self.compare(batch, top, &values, &mut band, &mut next)?;
                }
            }
            loop {
                let in_band = |f: &Result<Face, _>| f.as_ref().map_or(true, |f| (f[0] as i64) < bottom);
                let batch: Vec<Face> =
                    std::iter::from_fn(|| faces.next_if(in_band)).take(BATCH).collect::<Result<_, _>>()?;
                if batch.is_empty() {
                    break;
                }
                control.cancel.check()?;
                self.compare(&batch, top, &values, &mut band, &mut next)?;
            }
            waiting = next;
            self.add(top, &band);
            control.progress.step(Stage::Compare, values[0].len() as u64);
        }
        control.progress.end(Stage::Compare);
        Ok(())
    }

    /// Holds a batch of faces against the rows from `top` on; those that go on below are handed to `next`.
    fn compare(
        &mut self,
        batch: &[Face],
        top: i64,
        values: &[&[f64]],
        band: &mut [Row],
        next: &mut Queue<'_, 5>,
    ) -> Result<(), VerifyError> {
        let bottom = top + band.len() as i64;
        let mut surfaces = Vec::with_capacity(batch.len());
        for face in batch {
            let surface = self.surface(face)?;
            let (first, last) = surface.triangle.rows(&self.grid);
            if last >= bottom {
                next.push(*face)?;
            }
            surfaces.push((surface, first, last));
        }
        let (width, measure) = (self.grid.width, self.measure);
        let piece = band.len().div_ceil(TASKS);
        band.par_chunks_mut(piece).enumerate().for_each(|(task, rows)| {
            let first_row = top + (task * piece) as i64;
            let after = first_row + rows.len() as i64;
            for (surface, first, last) in &surfaces {
                for row in first_row.max(*first)..after.min(last + 1) {
                    let Some(span) = surface.triangle.row_span(row, width) else { continue };
                    let start = (row - top) as usize * width as usize;
                    let samples: Vec<&[f64]> = values.iter().map(|v| &v[start..start + width as usize]).collect();
                    let Row { worst, above } = &mut rows[(row - first_row) as usize];
                    if !surface.is_finite() {
                        let columns = span.closed.0 as usize..=span.closed.1 as usize;
                        columns.for_each(|column| above[column] |= !samples[0][column].is_nan());
                        continue;
                    }
                    surface.judge_row(row, &span, &samples, measure, |column, error, within| {
                        above[column as usize] |= !within;
                        if worst.is_none_or(|(e, c, _)| (error, c) > (e, column)) {
                            *worst = Some((error, column, surface.triangle.face));
                        }
                    });
                }
            }
        });
        Ok(())
    }

    fn surface(&mut self, &[_, face, a, b, c]: &Face) -> Result<Surface, VerifyError> {
        let count = self.measure.scales.len();
        let (mut corners, mut values) = ([(0, 0); 3], vec![[0.0; 3]; count]);
        for (i, vertex) in [a, b, c].into_iter().enumerate() {
            let vertex = self.store.get(vertex)?;
            corners[i] = vertex.place.expect("faces without a place are left out");
            values.iter_mut().enumerate().for_each(|(j, v)| v[i] = vertex.value(j));
        }
        let triangle = Triangle::new(face, corners, values[0]).expect("faces without an area are left out");
        Ok(Surface::new(triangle, values, self.measure))
    }

    fn add(&mut self, top: i64, band: &[Row]) {
        for (row, found) in (top..).zip(band) {
            for (column, _) in found.above.iter().enumerate().filter(|(_, above)| **above) {
                self.above.add(|| self.grid.sample(column as i64, row));
            }
            let Some((error, column, face)) = found.worst else { continue };
            if self.worst.is_none_or(|w| error > w.error) {
                self.worst = Some(WorstWeighted { error, place: self.grid.sample(column, row), face });
            }
        }
    }
}
