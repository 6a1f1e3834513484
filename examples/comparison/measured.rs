//! What a method takes for a window: triangles, time and memory. A mesh that does not pass `verify` is an error.

use std::path::Path;

use num_rational::BigRational;
use terrabite::base::GeoTransform;
use terrabite::base::control::Control;
use terrabite::base::mesh::TileMesh;
use terrabite::base::staged::StagedFile;
use terrabite::formats::{Contents, Header, PlySink, Sink};
use terrabite::kernel::triangulate::hitting_set::Partition;
use terrabite::verify::{VerifyOptions, verify};

use super::Window;
use super::methods::{Made, Method};
use crate::clock::cpu_seconds;
use crate::paper::Outcome;

/// How long a method is run again and again for its time, in seconds: the clock's steps are some thousandths.
const TIMED: f64 = 0.25;

/// Triangles, vertices, seconds of processor time (the mean of some runs) and by how many KiB the process's resident size grew at
/// the most in the first. For the latter the process has made no other mesh before.
pub(crate) fn measure(method: &Method, window: &Window, tolerance: f64) -> Outcome<String> {
    // All work is that of this thread, whose time is taken.
    let _pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build()?;
    // The largest resident size so far, which loading the raster has left, becomes the present one.
    std::fs::write("/proc/self/clear_refs", "5")?;
    let before = resident("VmRSS:")?;
    let made = (method.make)(window, tolerance)?;
    let kib = resident("VmHWM:")?.saturating_sub(before);
    let (vertices, triangles) = certified(&made, window, tolerance)?;
    let (start, mut runs, mut total) = (cpu_seconds()?, 0, 0.0);
    while total < TIMED {
        (method.make)(window, tolerance)?;
        (runs, total) = (runs + 1, cpu_seconds()? - start);
    }
    let seconds = total / f64::from(runs);
    Ok(format!("{triangles},{vertices},{seconds:.5},{kib}"))
}

/// A line of what Linux tells of this process, in KiB.
fn resident(line: &str) -> Outcome<u64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let found = status.lines().find_map(|l| l.strip_prefix(line)).ok_or("no such line")?;
    Ok(found.trim().trim_end_matches(" kB").parse()?)
}

/// Vertices and triangles of a mesh that `verify` has nothing against; no vertices of squares that hold every sample.
fn certified(made: &Made, window: &Window, tolerance: f64) -> Outcome<(u64, u64)> {
    if let Made::Squares(partition) = made {
        held(partition, window, tolerance)?;
        return Ok((0, partition.triangles() as u64));
    }
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("tin.ply");
    let sink = Box::new(PlySink::new(StagedFile::create(&file, true, &[])?, Header::default()));
    match made {
        Made::Tile(mesh) => write(mesh, sink)?,
        Made::Run(mesh) => drop(mesh.write(sink, &Control::default())?),
        Made::Squares(_) => {}
    }
    judged(&file, window, tolerance)
}

/// Whether every sample is in a square, and within the tolerance of it in rational numbers.
fn held(partition: &Partition, window: &Window, tolerance: f64) -> Outcome<()> {
    let rational = |z: f64| BigRational::from_float(z).ok_or("not a number");
    let mut is_held = vec![false; window.tile.width() * window.tile.height()];
    for square in &partition.squares {
        let [upper_left, upper_right, lower_right, lower_left] = square.heights.map(rational);
        let (a, b, c, d) = (upper_left?, upper_right?, lower_right?, lower_left?);
        let of = |i: usize, first: usize, last: usize| match last - first {
            0 => rational(0.0),
            span => Ok(rational((i - first) as f64)? / rational(span as f64)?),
        };
        for row in square.first.1..=square.last.1 {
            for column in square.first.0..=square.last.0 {
                let (x, y) = (of(column, square.first.0, square.last.0)?, of(row, square.first.1, square.last.1)?);
                // From the corner that is opposite the diagonal, along the two sides that meet there.
                let one = rational(1.0)?;
                let height = match (square.falling, x.clone() >= y, &x + &y <= one) {
                    (true, true, _) => &b + (&a - &b) * (&one - &x) + (&c - &b) * &y,
                    (true, false, _) => &d + (&a - &d) * (&one - &y) + (&c - &d) * &x,
                    (false, _, true) => &a + (&b - &a) * &x + (&d - &a) * &y,
                    (false, _, false) => &c + (&b - &c) * (&one - &y) + (&d - &c) * (&one - &x),
                };
                let off = height - rational(window.tile.at(column, row))?;
                if off > rational(tolerance)? || off < rational(-tolerance)? {
                    return Err(format!("the sample {column}, {row} is not within {tolerance} of {square:?}").into());
                }
                is_held[row * window.tile.width() + column] = true;
            }
        }
    }
    if is_held.contains(&false) { Err("a sample is in no square".into()) } else { Ok(()) }
}

fn judged(file: &Path, window: &Window, tolerance: f64) -> Outcome<(u64, u64)> {
    let options =
        VerifyOptions { lines: None, max_error: tolerance, max_stray: None, importance: None, temp_dir: None };
    let verdict = verify(&window.band()?, file, &options, &Control::default())?;
    if verdict.passes() { Ok((verdict.vertices, verdict.triangles)) } else { Err(format!("{verdict}").into()) }
}

/// Writes the mesh of a tile that is a whole raster without a place on the map.
fn write(mesh: &TileMesh, mut sink: Box<dyn Sink>) -> Outcome<()> {
    let contents = Contents {
        vertices: mesh.vertices.len() as u64,
        triangles: mesh.triangles.len() as u64,
        ..Contents::default()
    };
    sink.begin(&contents)?;
    let on_map = |v: &terrabite::base::mesh::Vertex| {
        let (x, y) = GeoTransform::DEFAULT.apply(v.at.x.into(), v.at.y.into());
        [x, y, v.height]
    };
    sink.vertices(&mesh.vertices.iter().map(on_map).collect::<Vec<_>>(), &[])?;
    // Counter-clockwise seen from above, which in the lattice, whose rows run down, are those the other way round.
    let flip = GeoTransform::DEFAULT.determinant() < 0.0;
    let turned = |&[a, b, c]: &[u32; 3]| if flip { [a, c, b] } else { [a, b, c] }.map(u64::from);
    sink.triangles(&mesh.triangles.iter().map(turned).collect::<Vec<_>>(), &[])?;
    Ok(sink.finish()?)
}
