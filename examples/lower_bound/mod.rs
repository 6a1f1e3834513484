//! Lower bounds of the number of triangles of any mesh within the tolerance of all samples, wherever its vertices are.

mod polygon;
mod samples;
mod sets;
mod weights;

use terrabite::base::Tile;

use samples::{At, Samples};
use sets::{Chosen, Search};

pub(crate) fn explore(tile: &Tile, tolerance: f64, step: usize, triangles_only: bool) {
    let samples = Samples { tile, tolerance };
    let at: Vec<At> = (0..tile.height())
        .step_by(step)
        .flat_map(|r| (0..tile.width()).step_by(step).map(move |c| (c as i32, r as i32)))
        .collect();
    let start = std::time::Instant::now();
    let chosen = Chosen::new(&samples, at);
    let edges: usize = chosen.after.iter().map(Vec::len).sum();
    eprintln!("step {step}: {} samples, {edges} compatible pairs, {:?}", chosen.at.len(), start.elapsed());
    let mut search = Search { samples, chosen: &chosen, triangles_only, sets: Vec::new(), tests: 0, most: 3_000_000 };
    let all = search.run();
    eprintln!(
        "all {all}: {} sets, largest {:?}, {} tests, {:?}",
        search.sets.len(),
        search.sets.iter().map(Vec::len).max(),
        search.tests,
        start.elapsed()
    );
    let (whole, most) = weights::weights(&search.sets, chosen.at.len());
    eprintln!("bound {} , {:?}", whole.iter().sum::<u64>().div_ceil(most), start.elapsed());
}
