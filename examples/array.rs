//! An array in memory to a mesh in a file, and judged: what a program does that brings samples of its own. It needs no
//! GDAL: `cargo run --no-default-features --example array -- tin.ply`.

use std::path::Path;

use terrabite::base::control::Control;
use terrabite::base::staged::StagedFile;
use terrabite::base::{Band, GeoTransform, Mark, Marks};
use terrabite::field::{Field, FieldOptions};
use terrabite::formats::{Header, PlySink};
use terrabite::job::{Params, triangulate};
use terrabite::verify::{VerifyOptions, verify};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).ok_or("usage: array OUT.ply")?;
    let (width, height, max_error) = (400, 300, 0.5);
    let hill = |i: usize| {
        let (x, y) = ((i % width) as f32 - 150.0, (i / width) as f32 - 100.0);
        // A lake of missing samples.
        if (50.0..60.0).contains(&x) && y.abs() < 20.0 { -9999.0 } else { 300.0 - (x * x + y * y) / 200.0 }
    };
    let heights = (0..width * height).map(hill).collect();
    let band = Band::of_singles("hill", (width, height), heights)?
        .with_marks(Marks { values: vec![Mark::Real(-9999.0)], valid: None })
        .with_geo_transform(GeoTransform::new([500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0], width, height)?);

    let control = Control::default();
    let field = Field::open(&band, &FieldOptions::default(), &control)?;
    let mesh = triangulate(&field, &Params::new(max_error), &control)?;
    let sink = PlySink::new(StagedFile::create(Path::new(&output), true, &[])?, Header::default());
    let summary = mesh.write(Box::new(sink), &control)?;

    let options = VerifyOptions { lines: None, max_error, max_stray: None, importance: None, temp_dir: None };
    let verdict = verify(&band, Path::new(&output), &options, &control)?;
    println!("{} triangles, largest error {}", summary.triangles, summary.errors.max);
    if verdict.passes() && verdict.nodata == 390 && summary.errors.max <= max_error && summary.triangles < 5000 {
        Ok(())
    } else {
        Err(format!("the mesh is not what it should be:\n{verdict}").into())
    }
}
