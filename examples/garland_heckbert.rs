//! The experiments of Garland & Heckbert 1995, on one raster, as comma-separated values: `scripts/paper.py` makes tables
//! and plots of them.
//!
//! `garland_heckbert curves RASTER`: one line per insertion (thinned) and variant: variant, vertices, largest error, RMS.
//! `garland_heckbert times RASTER`: variant, samples, vertices, seconds, RMS.
//! `garland_heckbert counts RASTER TOLERANCE...`: tolerance, triangles with the rim refined like the rest.
//! `garland_heckbert measures RASTER`: measure, vertices, largest error, RMS at some numbers of vertices.
//! `garland_heckbert cliff`: variant, vertices on the way to no error at a cliff of 100 × 100 samples.

mod paper;

use std::time::Instant;

use terrabite::base::control::CancelToken;
use terrabite::base::mesh::TileMesh;
use terrabite::base::{Heights, Tile};
use terrabite::kernel::triangulate::insertion::{
    DataDependent, Fit, GreedyInsertion, InsertionOptions, Measure, Scratch, Selection, Shape, Step, Swap,
};
use terrabite::kernel::triangulate::{Feasibility, Task};
use terrabite::raster::quiet_gdal;

use paper::{Outcome, load, rectangle};

fn main() -> Outcome<()> {
    quiet_gdal();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["curves", raster] => curves(&load(raster)?),
        ["times", raster] => times(&load(raster)?),
        ["counts", raster, tolerances @ ..] => counts(&load(raster)?, tolerances),
        ["measures", raster] => measures(&load(raster)?),
        ["cliff"] => cliff(),
        _ => Err("expected: curves|times|counts|measures RASTER, or cliff".into()),
    }
}

/// A mesh, how it stood after every insertion, and how long it took.
struct Refined {
    mesh: TileMesh,
    steps: Vec<Step>,
    seconds: f64,
}

/// Refines a tile by a variant.
fn refine(tile: &Tile, options: InsertionOptions, tolerance: f64, most: usize, steps: bool) -> Outcome<Refined> {
    let (domain, cancel, mut mesh) = (rectangle(tile), CancelToken::default(), TileMesh::default());
    let task = Task {
        tile,
        domain: &domain,
        tolerance,
        feasibility: Feasibility::Weak,
        max_stray: f64::INFINITY,
        cancel: &cancel,
    };
    let mut scratch = Scratch::default();
    let start = Instant::now();
    let steps = GreedyInsertion { options }.triangulate_alone(&task, most, steps, &mut scratch, &mut mesh)?;
    Ok(Refined { mesh, steps, seconds: start.elapsed().as_secs_f64() })
}

fn variant(swap: Swap, selection: Selection) -> InsertionOptions {
    InsertionOptions { swap, selection, ..InsertionOptions::default() }
}

fn data_dependent(fit: Fit, shape: Shape, quality_threshold: f64) -> InsertionOptions {
    variant(Swap::DataDependent(DataDependent { fit, shape, quality_threshold }), Selection::Sequential)
}

fn samples(tile: &Tile) -> f64 {
    (tile.width() * tile.height()) as f64
}

/// Figures 17, 18 and 19: errors while vertices are added.
fn curves(tile: &Tile) -> Outcome<()> {
    const MOST: usize = 20_000;
    let sequential = InsertionOptions::default();
    let of = |selection| variant(Swap::Delaunay, selection);
    let variants: [(&str, InsertionOptions, f64); 9] = [
        ("sequential", sequential, 0.0),
        ("fractional 0.9", of(Selection::Fractional(0.9)), 0.0),
        ("fractional 0.5", of(Selection::Fractional(0.5)), 0.0),
        ("constant 20", of(Selection::Constant), 20.0),
        ("constant 5", of(Selection::Constant), 5.0),
        ("data-dependent", data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.5), 0.0),
        ("data-dependent, L2", data_dependent(Fit::L2, Shape::AreaOverDiameter, 0.5), 0.0),
        ("data-dependent, L∞", data_dependent(Fit::LInfinity, Shape::AreaOverDiameter, 0.5), 0.0),
        ("data-dependent, pure", data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.0), 0.0),
    ];
    println!("variant,vertices,largest,rms");
    for (name, options, tolerance) in variants {
        let mut next = 5;
        for step in refine(tile, options, tolerance, MOST, true)?.steps {
            if step.vertices >= next {
                let rms = (step.squares.max(0.0) / samples(tile)).sqrt();
                println!("\"{name}\",{},{},{rms}", step.vertices, step.largest);
                next = step.vertices + 1 + step.vertices / 200;
            }
        }
    }
    Ok(())
}

/// Figures 13 and 20: time against vertices, and against error.
fn times(tile: &Tile) -> Outcome<()> {
    println!("variant,samples,vertices,seconds,rms");
    let variants = [
        ("delaunay", InsertionOptions::default()),
        ("data-dependent", data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.5)),
    ];
    for (name, options) in variants {
        for most in [100, 200, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 50_000] {
            if most as f64 > samples(tile) {
                continue;
            }
            let mut seconds = f64::INFINITY;
            for _ in 0..3 {
                seconds = seconds.min(refine(tile, options, 0.0, most, false)?.seconds);
            }
            let rms = rms(tile, &refine(tile, options, 0.0, most, true)?);
            println!("{name},{},{most},{seconds},{rms}", samples(tile));
        }
    }
    Ok(())
}

fn counts(tile: &Tile, tolerances: &[&str]) -> Outcome<()> {
    println!("tolerance,triangles");
    for text in tolerances {
        let refined = refine(tile, InsertionOptions::default(), text.parse()?, usize::MAX, false)?;
        println!("{text},{}", refined.mesh.triangles.len());
    }
    Ok(())
}

/// Section 3: what the measures are worth.
fn measures(tile: &Tile) -> Outcome<()> {
    println!("measure,vertices,largest,rms,seconds");
    let all = [
        ("local error", Measure::LocalError),
        ("curvature, smoothed by 1", Measure::Curvature(1.0)),
        ("curvature, smoothed by 4", Measure::Curvature(4.0)),
        ("global error", Measure::GlobalError),
        ("error × curvature, smoothed by 1", Measure::Product(1.0)),
        ("error × curvature, smoothed by 4", Measure::Product(4.0)),
    ];
    for (name, measure) in all {
        for most in [771, 1_542, 7_711] {
            let options = InsertionOptions { measure, ..InsertionOptions::default() };
            let refined = refine(tile, options, 0.0, most, true)?;
            let (vertices, largest, rms) =
                (refined.mesh.vertices.len(), largest_error(tile, &refined.mesh), rms(tile, &refined));
            let seconds = refined.seconds;
            println!("\"{name}\",{vertices},{largest},{rms},{seconds}");
        }
    }
    Ok(())
}

fn rms(tile: &Tile, refined: &Refined) -> f64 {
    refined.steps.last().map_or(0.0, |step| (step.squares.max(0.0) / samples(tile)).sqrt())
}

/// Scores of other measures than errors say nothing of errors.
fn largest_error(tile: &Tile, mesh: &TileMesh) -> f64 {
    use terrabite::base::tiling::TilePlace;
    use terrabite::kernel::measure::{Bare, Bound, measure};
    measure(tile, mesh, Bound::Scale(1.0), &TilePlace::alone(tile.width(), tile.height()), Bare::Nothing).max
}

/// Figure 22: half the ground is 0, the other half 1.
fn cliff() -> Outcome<()> {
    println!("variant,vertices");
    let heights = (0..10_000).map(|i| if i % 100 < 50 { 0.0 } else { 1.0 }).collect();
    let tile = Tile::from_heights(100, 100, Heights::F32(heights));
    let variants = [
        ("delaunay", InsertionOptions::default()),
        ("data-dependent", data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.5)),
        ("data-dependent, pure", data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.0)),
    ];
    for (name, options) in variants {
        println!("\"{name}\",{}", refine(&tile, options, 0.0, usize::MAX, false)?.mesh.vertices.len());
    }
    Ok(())
}
