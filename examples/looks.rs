//! Measures whether seams and the rim of a mesh can be seen: its hillshade against the raster's, within two cells of tile
//! lines and of the raster's rim, and elsewhere. Prints JSON. Called by `scripts/bench_looks.py`.
//!
//!     cargo run --release --example looks -- RASTER MESH [TILE [VERTICAL_SCALE]]

use std::error::Error;
use std::path::Path;

use terrabite::base::control::Control;
use terrabite::preview::looks;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [raster, mesh, rest @ ..] = &arguments[..] else {
        return Err("expected: RASTER MESH [TILE [VERTICAL_SCALE]]".into());
    };
    let tile = rest.first().map_or(Ok(512), |tile| tile.parse())?;
    let factor = rest.get(1).map(|factor| factor.parse()).transpose()?;
    let found = looks(Path::new(raster), Path::new(mesh), tile, factor, &Control::default())?;
    println!("{}", serde_json::to_string_pretty(&found)?);
    Ok(())
}
