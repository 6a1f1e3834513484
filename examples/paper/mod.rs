//! What the experiments of all papers need: a raster as one tile, and the domain of a tile without a rim of its own.

use std::path::Path;

use terrabite::base::control::Control;
use terrabite::base::lattice::Point;
use terrabite::base::mesh::{Domain, Vertex};
use terrabite::base::{Tile, Window};
use terrabite::field::{Field, FieldOptions};
use terrabite::raster::Raster;

/// Errors are for the person at the terminal.
pub(crate) type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// The first band of a raster, whole.
pub(crate) fn load(path: &str) -> Outcome<Tile> {
    let raster = Raster::open(Path::new(path), 1)?;
    let field = Field::open(&raster.to_band()?, &FieldOptions::default(), &Control::default())?;
    let mut tile = Tile::default();
    field.load(Window { column: 0, row: 0, width: field.width(), height: field.height() }, &mut tile)?;
    Ok(tile)
}

/// The whole tile, its corners only.
pub(crate) fn rectangle(tile: &Tile) -> Domain {
    let (right, bottom) = (tile.width() - 1, tile.height() - 1);
    let corner = |column: usize, row: usize| Vertex {
        at: Point::of_sample(column as i32, row as i32),
        height: tile.at(column, row),
    };
    let vertices = vec![corner(0, 0), corner(right, 0), corner(right, bottom), corner(0, bottom)];
    Domain { vertices, loops: vec![vec![0, 1, 2, 3]], ..Domain::default() }
}
