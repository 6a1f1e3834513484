//! Hitting sets measured on a window of a raster: `hitting_set RASTER COLUMN ROW SIZE TOLERANCE [cover]`.
//!
//! Prints the squares of both kinds with their counts, and meshes, each with its speed: millions of its samples a second of processor time (Linux), which
//! says little of windows below 300 × 300.
//! With `cover` also the cover by sliding squares, chosen greedily and by reweighting, which takes long where squares are large.

mod clock;

use std::path::Path;

use clock::cpu_seconds;
use terrabite::base::control::{CancelToken, Control};
use terrabite::base::mesh::TileMesh;
use terrabite::base::tiling::TilePlace;
use terrabite::base::{Tile, Window};
use terrabite::field::{Field, FieldOptions};
use terrabite::kernel::polish::{Options, Scratch, polish};
use terrabite::kernel::seam::{MinLink, Rim};
use terrabite::kernel::triangulate::hitting_set::reweighting::{hitting_set, most_successful};
use terrabite::kernel::triangulate::hitting_set::{
    Corners, HittingSet, HittingSetOptions, LargestSquares, Reading, Squares, Stitching, partition, stitch_literally,
};
use terrabite::kernel::triangulate::insertion::GreedyInsertion;
use terrabite::kernel::triangulate::{EngineChoice, EngineScratch, Feasibility, Task};
use terrabite::raster::{Raster, quiet_gdal};

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome<()> {
    quiet_gdal();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (raster, numbers, covers) = match words.as_slice() {
        [raster, column, row, size, tolerance] => (*raster, [column, row, size, tolerance], false),
        [raster, column, row, size, tolerance, "cover"] => (*raster, [column, row, size, tolerance], true),
        _ => return Err("expected: hitting_set RASTER COLUMN ROW SIZE TOLERANCE [cover]".into()),
    };
    let [column, row, size, tolerance] = numbers;
    let tile = load(raster, column.parse()?, row.parse()?, size.parse()?)?;
    let tolerance = tolerance.parse()?;
    squares(&tile, tolerance)?;
    if covers {
        cover(&tile, tolerance)?;
    }
    meshes(&tile, tolerance)
}

fn load(path: &str, column: usize, row: usize, size: usize) -> Outcome<Tile> {
    let raster = Raster::open(Path::new(path), 1)?;
    let field = Field::open(&raster.to_band().expect("a band"), &FieldOptions::default(), &Control::default())?;
    let left = |start: usize, end: usize| end.saturating_sub(start).min(size);
    let (width, height) = (left(column, field.width()), left(row, field.height()));
    if width < 2 || height < 2 {
        return Err(format!("{path}: no window of {size} samples from column {column} and row {row}").into());
    }
    let mut tile = Tile::default();
    field.load(Window { column, row, width, height }, &mut tile)?;
    if !tile.validity().is_whole() {
        return Err(format!("{path}: samples are missing in the window").into());
    }
    Ok(tile)
}

/// What comes of something, and the least of three times that it takes, in seconds of processor time.
fn timed<T>(mut work: impl FnMut() -> Outcome<T>) -> Outcome<(T, f64)> {
    let mut run = || {
        let start = cpu_seconds()?;
        let result = work()?;
        Ok::<_, Box<dyn std::error::Error>>((result, cpu_seconds()? - start))
    };
    let (_, first) = run()?;
    let (_, second) = run()?;
    let (result, third) = run()?;
    Ok((result, first.min(second).min(third)))
}

/// Millions of samples a second.
fn rate(tile: &Tile, seconds: f64) -> f64 {
    (tile.width() * tile.height()) as f64 / seconds / 1e6
}

fn squares(tile: &Tile, tolerance: f64) -> Outcome<()> {
    let cancel = CancelToken::default();
    for corners in [Corners::Free, Corners::Samples] {
        let (found, seconds) = timed(|| Ok(partition(tile, tolerance, Squares::Nested, corners, &cancel)?))?;
        let (triangles, counts, rate) = (found.triangles(), found.counts, rate(tile, seconds));
        println!(
            "nested, {corners:?}: {} squares, {triangles} triangles, {counts:?}, {rate:.2} M/s",
            found.squares.len()
        );
    }
    for reading in [Reading::Disjoint, Reading::Shared] {
        for corners in [Corners::Free, Corners::Samples] {
            let literal = stitch_literally(tile, tolerance, reading, corners, &cancel)?;
            let (before, failing) = (literal.before_repair, literal.failing);
            println!(
                "{reading:?}, {corners:?}: {before} triangles, {failing} fail, {} repaired",
                literal.mesh.triangles.len()
            );
        }
    }
    Ok(())
}

fn cover(tile: &Tile, tolerance: f64) -> Outcome<()> {
    let cancel = CancelToken::default();
    let greedy = partition(tile, tolerance, Squares::Sliding, Corners::Free, &cancel)?;
    println!("sliding, greedy: {} squares, {:?}", greedy.squares.len(), greedy.counts);
    let squares = LargestSquares::new(tile, tolerance, Corners::Free, &cancel)?;
    let found = hitting_set(&squares, 1).ok_or("a sample in no square")?;
    println!(
        "sliding, reweighted: {} squares of {} drawn, c = {}, {} of {} iterations successful, at most {}",
        found.chosen.len(),
        found.drawn,
        found.believed,
        found.successful,
        found.iterations,
        most_successful(found.believed, found.elements),
    );
    Ok(())
}

fn meshes(tile: &Tile, tolerance: f64) -> Outcome<()> {
    let cancel = CancelToken::default();
    let place = TilePlace::alone(tile.width(), tile.height());
    let rim = Rim::new(tile, tolerance, &[], &place, &mut MinLink::default(), &cancel)?;
    let (feasibility, max_stray) = (Feasibility::Weak, f64::INFINITY);
    let task = Task { tile, domain: &rim.domain, tolerance, feasibility, max_stray, cancel: &cancel };
    let variant = |corners, stitching| {
        let options = HittingSetOptions { squares: Squares::Nested, corners, stitching };
        EngineChoice::from(HittingSet { options })
    };
    let engines = [
        ("insertion", GreedyInsertion::default().into()),
        ("shared", variant(Corners::Samples, Stitching::Shared)),
        ("merged", variant(Corners::Samples, Stitching::Merged)),
        ("shared, free", variant(Corners::Free, Stitching::Shared)),
        ("merged, free", variant(Corners::Free, Stitching::Merged)),
    ];
    for (name, engine) in engines {
        let mut scratch = EngineScratch::default();
        let (mesh, seconds) = timed(|| {
            let mut mesh = TileMesh::default();
            engine.triangulate(&task, &mut scratch, &mut mesh)?;
            Ok(mesh)
        })?;
        let mut polished = mesh.clone();
        polish(&task, &Options::default(), &mut Scratch::default(), &mut polished)?;
        let (triangles, rate) = (mesh.triangles.len(), rate(tile, seconds));
        println!("{name}: {triangles} triangles, {rate:.2} M/s, balanced {}", polished.triangles.len());
    }
    Ok(())
}
