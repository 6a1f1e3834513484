//! The finished mesh: chunks on disk, and how they are handed to a sink.

use std::sync::Arc;

use super::chains::ChainStore;
use super::marks::Marked;
use super::{Error, Figures, Job, Outcome, Pass, TileTimes};
use crate::base::channels::{Channel, Number};
use crate::base::control::{Control, Stage};
use crate::base::faults::{self, Point};
use crate::base::handed_over::{DENSE_BYTES, clear, make_room};
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;
use crate::base::tiling::{TileGrid, TileId};
use crate::base::{GeoTransform, Tolerance};
use crate::formats::{Bounds, Contents, Sink};
use crate::job::normals::{Maker, NAMES, NormalSource};
use crate::job::spool::{Chunk, Ids, Spool};
use crate::kernel::breaklines::ChainCounts;
use crate::kernel::measure::ErrorStats;

/// A triangulated field: chunks on disk, one per tile. Whether they vanish when it is dropped is up to their spool.
#[derive(Debug)]
pub struct Mesh {
    pub(super) spool: Spool,
    pub(super) grid: TileGrid,
    /// The grid whose tiles the chunks are.
    pub(super) chunks: TileGrid,
    pub(super) geo_transform: GeoTransform,
    pub(super) channels: Vec<Channel>,
    pub(super) tolerance: Tolerance,
    pub(super) error_scale: f64,
    pub(super) outcome: Option<Outcome>,
    pub(super) chains: Option<Arc<ChainStore>>,
    pub(super) times: TileTimes,
    pub(super) spool_bytes: u64,
    pub(super) found: u64,
}

/// Vertices or triangles that a sink is given at a time.
const AT_A_TIME: usize = 1 << 15;

/// The whole mesh in numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// Vertices, seam vertices counted once.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Triangles whose strong feasibility was relaxed to weak.
    pub relaxed: u64,
    /// Errors over all samples.
    pub errors: ErrorStats,
}

impl Mesh {
    /// The mesh that all chunks of a job's last pass are.
    pub(super) fn of(job: &Job<'_>, spool: Spool, last: &Pass) -> Mesh {
        let Job { field, params, end, .. } = *job;
        let kept = params.tolerance.kept();
        Mesh {
            spool_bytes: spool.bytes(),
            spool,
            grid: job.grid,
            chunks: last.grid(),
            geo_transform: field.geo_transform(),
            channels: field.channels().to_vec(),
            tolerance: params.tolerance,
            error_scale: end.map_or(kept, |end| end.scale(job)),
            outcome: end.map(|end| end.outcome),
            chains: job.chains.clone(),
            times: TileTimes::default(),
            found: job.grid.len() as u64,
        }
    }

    /// How the field was cut.
    pub fn grid(&self) -> TileGrid {
        self.grid
    }

    /// What its vertices have beside a height: [`Chunk::attributes`], in this order.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The tolerance it keeps: what was asked for, or what was found for a goal; open where insertion stopped at one.
    pub fn tolerance(&self) -> Tolerance {
        self.tolerance
    }

    /// What it comes to. Reads every chunk.
    ///
    /// # Errors
    /// [`Error`]: a chunk cannot be read.
    pub(super) fn figures(&self) -> Result<Figures, Error> {
        let Summary { vertices, triangles, mut errors, .. } = self.count()?;
        self.chunks().try_for_each(|chunk| chunk.map(|chunk| errors.add(&chunk.errors)))?;
        let largest = errors.extended.map_or(errors.weighted_max, |extended| extended.max);
        Ok(Figures { vertices, triangles, rms: errors.rms(), largest })
    }

    /// What percentiles of errors are to be taken by ([`ErrorStats::percentile`]): the tolerance, or under a goal that left
    /// it open the threshold that it came to.
    pub fn error_scale(&self) -> f64 {
        self.error_scale
    }

    /// How far a run under a goal got.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// What became of each set of lines; nothing where there are none.
    pub fn chains(&self) -> &[ChainCounts] {
        self.chains.as_deref().map_or(&[], ChainStore::counts)
    }

    /// How many edges follow soft lines alone.
    pub fn soft_edges(&self) -> u64 {
        self.chains.as_deref().map_or(0, ChainStore::soft)
    }

    /// Where the time of the tiles went.
    pub fn times(&self) -> TileTimes {
        self.times
    }

    /// How many tiles of [`Mesh::grid`] the spool had already.
    pub fn tiles_found(&self) -> u64 {
        self.found
    }

    /// Temporary disk in use, when it was the most: chunks of two passes at a time, or of all of them where they are kept.
    pub fn spool_bytes(&self) -> u64 {
        self.spool_bytes
    }

    /// Chunk after chunk, in tile order.
    pub fn chunks(&self) -> impl Iterator<Item = Result<Chunk, Error>> {
        let mut buffer = Vec::new();
        (0..self.spool.tiles()).map(move |tile| {
            let mut chunk = Chunk::default();
            self.spool.read(tile, &mut chunk, &mut buffer)?;
            clear(&mut buffer, DENSE_BYTES);
            Ok(chunk)
        })
    }

    /// Hands the mesh to a sink: contents, vertices on the map, triangles; then asks it to finish.
    ///
    /// Three passes over the chunks' counts, their vertices and their triangles; memory: two rows of counts, one chunk and its
    /// encoded form. A sink that asks for bounds costs a pass more; one that asks for corners costs another, and two rows of
    /// the vertices that tiles lend to each other; one that marks edges of breaklines those of a band of tiles, some 200 bytes for
    /// each.
    ///
    /// # Errors
    /// [`Error`]; the sink is dropped unfinished then.
    pub fn write(&self, sink: Box<dyn Sink + '_>, control: &Control<'_>) -> Result<Summary, Error> {
        self.write_if(sink, None, control, &|| Ok(()))
    }

    /// Does what [`Mesh::write`] does, with normals as the last three attributes if they are wanted; but asks the sink to finish only if `may_finish` has nothing against it.
    ///
    /// # Errors
    /// [`Error`], that of `may_finish` among them; the sink is dropped unfinished then.
    pub fn write_if(
        &self,
        mut sink: Box<dyn Sink + '_>,
        normals: Option<NormalSource<'_>>,
        control: &Control<'_>,
        may_finish: &dyn Fn() -> Result<(), Error>,
    ) -> Result<Summary, Error> {
        let needs = sink.needs();
        let steps = (2 + u64::from(needs.bounds)) * self.chunks.len() as u64;
        control.progress.begin(Stage::Write, steps, 0);
        let mut summary = self.count()?;
        let (vertices, triangles) = (summary.vertices, summary.triangles);
        let bounds = if needs.bounds { self.bounds(control)? } else { None };
        let has_normals = normals.is_some();
        let attributes = self.attributes(has_normals);
        let tolerance = Some(self.tolerance.asked()).filter(|asked| asked.is_finite());
        let mut marked = Marked::new(self.chains.as_deref(), needs.edges);
        let edges = marked.as_ref().map_or(0, Marked::count);
        sink.begin(&Contents {
            vertices,
            triangles,
            attributes: &attributes,
            has_normals,
            tolerance,
            bounds,
            edges,
            edges_have_types: marked.as_ref().is_some_and(Marked::have_types),
        })?;
        if let Some(marked) = &marked {
            marked.write_places(sink.as_mut(), |place, height| self.placed(place.x, place.y, height))?;
        }
        self.write_vertices(sink.as_mut(), normals, marked.as_mut(), &mut summary, control)?;
        self.write_triangles(sink.as_mut(), needs.corners, control)?;
        if let Some(marked) = marked {
            marked.write_numbers(sink.as_mut())?;
        }
        may_finish()?;
        sink.finish()?;
        control.progress.end(Stage::Write);
        Ok(summary)
    }

    /// What vertices have in the output.
    fn attributes(&self, has_normals: bool) -> Vec<Channel> {
        let normals = NAMES.iter().filter(|_| has_normals);
        let normals = normals.map(|name| Channel { name: name.to_string(), number: Number::F32 });
        self.channels.iter().cloned().chain(normals).collect()
    }

    fn count(&self) -> Result<Summary, Error> {
        let mut summary = Summary::default();
        let columns = self.chunks.columns();
        for row in 0..self.chunks.rows() {
            for counts in self.spool.counts(row * columns..(row + 1) * columns)? {
                summary.vertices += counts.vertices;
                summary.triangles += counts.triangles;
            }
        }
        Ok(summary)
    }

    /// `None` where there is no vertex.
    fn bounds(&self, control: &Control<'_>) -> Result<Option<Bounds>, Error> {
        let mut bounds = None;
        for chunk in self.chunks() {
            control.cancel.check()?;
            let chunk = chunk?;
            let tile = self.chunks.tile(chunk.tile);
            for vertex in &chunk.vertices {
                bounds = Some(bounds.unwrap_or(Bounds::EMPTY).with(self.on_the_map(tile, vertex)));
            }
            control.progress.step(Stage::Write, 0);
        }
        Ok(bounds)
    }

    /// x, y on the map and the height of a vertex with a place of this tile.
    fn on_the_map(&self, tile: TileId, vertex: &Vertex) -> [f64; 3] {
        let window = self.chunks.window(tile);
        let (column, row) = (window.column as i64 * i64::from(STEPS), window.row as i64 * i64::from(STEPS));
        self.placed(column + i64::from(vertex.at.x), row + i64::from(vertex.at.y), vertex.height)
    }

    /// The same of a place on the lattice of the raster.
    fn placed(&self, column: i64, row: i64, height: f64) -> [f64; 3] {
        let (x, y) = self.geo_transform.apply(column, row);
        [x, y, height]
    }

    fn write_vertices(
        &self,
        sink: &mut dyn Sink,
        normals: Option<NormalSource<'_>>,
        mut marked: Option<&mut Marked<'_>>,
        summary: &mut Summary,
        control: &Control<'_>,
    ) -> Result<(), Error> {
        let mut normals = normals.map(|source| Maker::new(&source, self)).transpose()?;
        let mut axes: [Vec<f64>; 3] = Default::default();
        let mut placed = Vec::new();
        for chunk in self.chunks() {
            control.cancel.check()?;
            let chunk = chunk?;
            let tile = self.chunks.tile(chunk.tile);
            if let Some(marked) = &mut marked {
                marked.number(self.chunks.window(tile), &chunk.vertices)?;
            }
            let mut attributes: Vec<&[f64]> = chunk.attributes.iter().map(|a| a.values.as_slice()).collect();
            if let Some(maker) = &mut normals {
                let normals = maker.of_chunk(&chunk)?;
                axes.iter_mut().enumerate().for_each(|(axis, values)| {
                    values.clear();
                    values.extend(normals.iter().map(|normal| normal[axis]));
                });
                attributes.extend(axes.iter().map(Vec::as_slice));
            }
            for (first, vertices) in (0..).step_by(AT_A_TIME).zip(chunk.vertices.chunks(AT_A_TIME)) {
                placed.clear();
                placed.extend(vertices.iter().map(|vertex| self.on_the_map(tile, vertex)));
                let values: Vec<&[f64]> = attributes.iter().map(|a| &a[first..first + vertices.len()]).collect();
                sink.vertices(&placed, &values)?;
            }
            faults::reach(Point::Vertices);
            summary.relaxed += chunk.relaxed;
            summary.errors.add(&chunk.errors);
            control.progress.step(Stage::Write, 0);
        }
        Ok(())
    }

    fn write_triangles(&self, sink: &mut dyn Sink, has_corners: bool, control: &Control<'_>) -> Result<(), Error> {
        // A positive turn on the lattice is counter-clockwise on the map unless one of the two is mirrored.
        let mirrored = self.geo_transform.determinant() < 0.0;
        let mut ids = match has_corners {
            true => Ids::with_vertices(&self.spool, self.chunks)?,
            false => Ids::new(&self.spool, self.chunks)?,
        };
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        let (mut numbers, mut numbered) = (Vec::new(), Vec::new());
        let (mut places, mut corners) = (Vec::new(), Vec::new());
        for chunk in self.chunks() {
            control.cancel.check()?;
            let chunk = chunk?;
            if chunk.tile > 0 && chunk.tile % self.chunks.columns() == 0 {
                ids.next_row()?;
            }
            ids.of_chunk(&chunk, &mut numbers);
            if has_corners {
                self.place_all(&chunk, &ids, &mut places);
            }
            for triangles in chunk.triangles.chunks(AT_A_TIME) {
                numbered.clear();
                numbered.extend(triangles.iter().map(|&t| turned(t).map(|i| numbers[i as usize])));
                corners.clear();
                if has_corners {
                    corners.extend(triangles.iter().map(|&t| turned(t).map(|i| places[i as usize])));
                }
                sink.triangles(&numbered, &corners)?;
            }
            faults::reach(Point::Triangles);
            control.progress.step(Stage::Write, 0);
        }
        Ok(())
    }

    /// A chunk's vertices on the map, in the order its triangles count them, as [`Ids::of_chunk`] numbers them.
    pub(super) fn place_all(&self, chunk: &Chunk, ids: &Ids<'_>, into: &mut Vec<[f64; 3]>) {
        let tile = self.chunks.tile(chunk.tile);
        let (lent, inside) = chunk.vertices.split_at(chunk.before_borrowed());
        make_room(into, chunk.vertices.len() + chunk.foreign.len());
        into.extend(lent.iter().map(|vertex| self.on_the_map(tile, vertex)));
        into.extend(chunk.foreign.iter().map(|&foreign| {
            let (owner, vertex) = ids.borrowed(tile, foreign);
            self.on_the_map(owner, &vertex)
        }));
        into.extend(inside.iter().map(|vertex| self.on_the_map(tile, vertex)));
    }
}
