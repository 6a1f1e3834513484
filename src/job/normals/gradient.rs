//! Normals from the samples' gradient.

use super::{NormalSource, unit};
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;
use crate::base::{CoordinateFrame, GeoTransform, Tile, Window};
use crate::field::Field;
use crate::job::spool::Chunk;
use crate::job::{Error, Mesh};

/// Samples around a tile that are looked at.
const MARGIN: usize = 2;

/// Reads the samples of each chunk's tile once more, with some around it.
pub(in crate::job) struct Maker<'a> {
    field: &'a Field,
    mesh: &'a Mesh,
    slopes: Slopes,
    tile: Tile,
    normals: Vec<[f64; 3]>,
}

impl<'a> Maker<'a> {
    pub(super) fn new(source: &NormalSource<'a>, mesh: &'a Mesh) -> Maker<'a> {
        let slopes = Slopes { transform: mesh.geo_transform, frame: source.frame };
        Maker { field: source.field, mesh, slopes, tile: Tile::default(), normals: Vec::new() }
    }

    pub(super) fn of_chunk(&mut self, chunk: &Chunk) -> Result<&[[f64; 3]], Error> {
        self.normals.clear();
        if chunk.vertices.is_empty() {
            return Ok(&self.normals);
        }
        let window = self.mesh.chunks.window(self.mesh.chunks.tile(chunk.tile));
        let (column, row) = (window.column.saturating_sub(MARGIN), window.row.saturating_sub(MARGIN));
        let right = (window.column + window.width + MARGIN).min(self.field.width());
        let below = (window.row + window.height + MARGIN).min(self.field.height());
        let around = Window { column, row, width: right - column, height: below - row };
        self.field.load(around, &mut self.tile)?;
        let first = (window.column - column, window.row - row);
        let Maker { slopes, tile, normals, .. } = self;
        normals.extend(chunk.vertices.iter().map(|vertex| slopes.normal(gradient(tile, first, vertex))));
        Ok(&self.normals)
    }
}

/// What becomes of a gradient on the grid.
struct Slopes {
    transform: GeoTransform,
    frame: CoordinateFrame,
}

impl Slopes {
    /// The normal where heights grow by so much from column to column and from row to row.
    fn normal(&self, (across, down): (f64, f64)) -> [f64; 3] {
        let [_, xp, xl, _, yp, yl] = self.transform.coefficients();
        let determinant = self.transform.determinant();
        let x = (across * yl - down * yp) / determinant;
        let y = (down * xp - across * xl) / determinant;
        let CoordinateFrame { xy_scale, z_scale, .. } = self.frame;
        unit([-x * z_scale / xy_scale.0, -y * z_scale / xy_scale.1, 1.0])
    }
}

/// By how much heights grow at a vertex, from column to column and from row to row: at a sample the difference of its two
/// neighbours, halved, or that to the one there is; between samples those of the samples around, weighted by nearness. `first`
/// is where the vertex's tile begins.
fn gradient(tile: &Tile, (column, row): (usize, usize), vertex: &Vertex) -> (f64, f64) {
    let place = |at: i32, first: usize| {
        (at.div_euclid(STEPS) as usize + first, f64::from(at.rem_euclid(STEPS)) / f64::from(STEPS))
    };
    let ((column, right), (row, below)) = (place(vertex.at.x, column), place(vertex.at.y, row));
    let mut sum = (0.0, 0.0, 0.0);
    for (dx, wx) in [(0, 1.0 - right), (1, right)] {
        for (dy, wy) in [(0, 1.0 - below), (1, below)] {
            let (column, row, weight) = (column + dx, row + dy, wx * wy);
            if weight > 0.0 && has_height(tile, column as i64, row as i64) {
                let (across, down) = at_sample(tile, column as i64, row as i64);
                sum = (sum.0 + weight * across, sum.1 + weight * down, sum.2 + weight);
            }
        }
    }
    if sum.2 > 0.0 { (sum.0 / sum.2, sum.1 / sum.2) } else { (0.0, 0.0) }
}

fn has_height(tile: &Tile, column: i64, row: i64) -> bool {
    let inside = (0..tile.width() as i64).contains(&column) && (0..tile.height() as i64).contains(&row);
    inside && tile.validity().has_height(column as i32, row as i32)
}

fn at_sample(tile: &Tile, column: i64, row: i64) -> (f64, f64) {
    let along = |(dx, dy): (i64, i64)| {
        let height = |n: i64| {
            let (column, row) = (column + n * dx, row + n * dy);
            has_height(tile, column, row).then(|| tile.at(column as usize, row as usize))
        };
        match (height(-1), height(0), height(1)) {
            (Some(before), _, Some(after)) => (after - before) / 2.0,
            (Some(before), Some(here), None) => here - before,
            (None, Some(here), Some(after)) => after - here,
            _ => 0.0,
        }
    };
    (along((1, 0)), along((0, 1)))
}
