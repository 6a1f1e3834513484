//! Polishing measured: `polish RASTER TOLERANCE [TILE [weak|strong [all|EFFORT [sampled|fitted [cuts|insertion [ANGLE [weak|strong]]]]]]]`
//! cuts a raster into tiles, triangulates each with greedy cuts (or by greedy insertion) and polishes it with every effort,
//! or the one named, perhaps with a floor for angles and strong edges, in one thread. Prints triangles, seconds of
//! processor time (Linux), and the root of the mean square error as a share of the tolerance.

mod clock;

use std::path::Path;

use clock::cpu_seconds;
use terrabite::base::Tile;
use terrabite::base::control::{CancelToken, Control};
use terrabite::base::mesh::TileMesh;
use terrabite::base::tiling::TileGrid;
use terrabite::field::{Field, FieldOptions};
use terrabite::kernel::measure::{Bare, ErrorStats, measure};
use terrabite::kernel::polish::{Effort, Heights, Options, Scratch, Tuning, polish};
use terrabite::kernel::seam::{MinLink, Rim};
use terrabite::kernel::triangulate::cuts::GreedyCuts;
use terrabite::kernel::triangulate::insertion::GreedyInsertion;
use terrabite::kernel::triangulate::{Engine, Feasibility, Task};
use terrabite::raster::Raster;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Balanced, Effort::Best];

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |i: usize| arguments.get(i).map(String::as_str);
    let (Some(raster), Some(tolerance)) = (argument(0), argument(1)) else {
        return Err(
            "expected: polish RASTER TOLERANCE [TILE [weak|strong [all|fast|balanced|best [sampled|fitted [cuts|insertion [ANGLE [weak|strong]]]]]]]".into()
        );
    };
    let tolerance: f64 = tolerance.parse()?;
    let tile = argument(2).unwrap_or("512").parse()?;
    let feasibility = if argument(3) == Some("strong") { Feasibility::Strong } else { Feasibility::Weak };
    let only = argument(4).filter(|&name| name != "all");
    let heights = if argument(5) == Some("fitted") { Heights::Fitted } else { Heights::Sampled };

    let min_angle = argument(7).map(str::parse).transpose()?;
    let tuning = Tuning { min_angle, strong_edges: argument(8) == Some("strong"), ..Tuning::default() };

    let raster = Raster::open(Path::new(raster), 1)?;
    let field = Field::open(&raster.to_band().expect("a band"), &FieldOptions::default(), &Control::default())?;
    let grid = TileGrid::new(field.width(), field.height(), tile);
    let (mut samples, mut scratch) = (Tile::default(), Scratch::default());
    let (mut engine, mut inserter) = (Default::default(), Default::default());
    let (mut cut, mut polished) = (TileMesh::default(), TileMesh::default());
    let (mut cuts, mut results) = ((0, 0.0), [(); 3].map(|()| (0, 0.0, ErrorStats::default())));
    let cancel = CancelToken::default();
    for index in 0..grid.len() {
        let place = grid.place(index);
        field.load(place.window, &mut samples)?;
        let rim = Rim::new(&samples, tolerance, &[], &place, &mut MinLink::default(), &cancel)?;
        let task = Task {
            tile: &samples,
            domain: &rim.domain,
            tolerance,
            feasibility,
            max_stray: f64::INFINITY,
            cancel: &cancel,
        };
        let start = cpu_seconds()?;
        if argument(6) == Some("insertion") {
            GreedyInsertion::default().triangulate(&task, &mut inserter, &mut cut)?;
        } else {
            GreedyCuts::PLAIN.triangulate(&task, &mut engine, &mut cut)?;
        }
        cuts = (cuts.0 + cut.triangles.len(), cuts.1 + cpu_seconds()? - start);
        for (effort, result) in EFFORTS.into_iter().zip(&mut results) {
            if only.is_some_and(|name| name != format!("{effort:?}").to_lowercase()) {
                continue;
            }
            polished.clone_from(&cut);
            let start = cpu_seconds()?;
            polish(&task, &Options { effort, heights, tuning }, &mut scratch, &mut polished)?;
            result.0 += polished.triangles.len();
            result.1 += cpu_seconds()? - start;
            result.2.add(&measure(&samples, &polished, tolerance, &place, Bare::Nothing));
        }
    }
    println!("start: {} triangles, {:.3} s", cuts.0, cuts.1);
    for (effort, (triangles, seconds, errors)) in EFFORTS.into_iter().zip(results) {
        println!("{effort:?}: {triangles} triangles, {seconds:.3} s, rms {:.12}", errors.rms() / tolerance);
    }
    Ok(())
}
