//! The tables of Silva, Mitchell & Kaufman 1995 and of Agarwal & Desikan 1997, on one window of one raster, as
//! comma-separated values: `scripts/paper_windows.py` makes tables and plots of them.
//!
//! `silva_agarwal window RASTER`: stride, first column, first row, least and largest height, tolerance, Franklin's triangles.
//! `silva_agarwal methods`: the names of all methods.
//! `silva_agarwal run METHOD RASTER TOLERANCE`: triangles, vertices, seconds, KiB; the mesh has passed `verify`.
//! `silva_agarwal readings RASTER TOLERANCE`: literal stitching, triangles at the end, before they were repaired, and how many of
//! these failed the exact test.
//! `silva_agarwal bound RASTER TOLERANCE`: lower bounds of the number of triangles, by incompatible samples and by weights.

mod clock;
mod comparison;
mod lower_bound;
mod paper;

use terrabite::kernel::triangulate::hitting_set::{Literal, Reading};

use comparison::{METHODS, Window, measure, stitched, tolerance_of};
use lower_bound::lower_bounds;
use paper::Outcome;

fn main() -> Outcome<()> {
    terrabite::raster::quiet_gdal();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["window", raster] => {
            let window = Window::of(raster)?;
            let (tolerance, triangles) = tolerance_of(&window)?;
            let ((column, row), (low, high)) = (window.first, window.range());
            println!("stride,column,row,low,high,tolerance,triangles");
            println!("{},{column},{row},{low},{high},{tolerance},{triangles}", window.stride);
        }
        ["methods"] => {
            println!("method");
            METHODS.iter().for_each(|method| println!("{}", method.name));
        }
        ["run", name, raster, tolerance] => {
            let method = METHODS.iter().find(|method| method.name == *name).ok_or("no such method")?;
            println!("triangles,vertices,seconds,kib");
            println!("{}", measure(method, &Window::of(raster)?, tolerance.parse()?)?);
        }
        ["readings", raster, tolerance] => {
            let window = Window::of(raster)?;
            println!("reading,triangles,before,failing");
            for (name, reading) in [("disjoint", Reading::Disjoint), ("shared", Reading::Shared)] {
                let Literal { mesh, before_repair, failing } = stitched(reading, &window, tolerance.parse()?)?;
                println!("{name},{},{before_repair},{failing}", mesh.triangles.len());
            }
        }
        ["bound", raster, tolerance] => {
            let bounds = lower_bounds(&Window::of(raster)?.tile, tolerance.parse()?);
            println!("incompatible,weights");
            println!("{},{}", bounds.incompatible.len(), bounds.weighed.triangles());
        }
        _ => {
            return Err(
                "expected: window RASTER, methods, run METHOD RASTER TOLERANCE, readings|bound RASTER TOLERANCE".into(),
            );
        }
    }
    Ok(())
}
