//! Writes the densest mesh of a raster there is: every cell with four heights as two triangles, half of every cell with
//! three as one. `terrabite verify` passes it at tolerance 0, unless a face is named that is left out. Holds the whole raster
//! in memory.
//!
//!     cargo run --release --example cells -- RASTER OUT.ply [FACE]

use std::io::{BufWriter, Write};
use std::path::Path;

use terrabite::base::Window;
use terrabite::raster::Raster;
use terrabite::verify::HeightReader;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let (input, output, left_out) = match arguments.as_slice() {
        [_, input, output] => (input, output, None),
        [_, input, output, face] => (input, output, Some(face.parse::<usize>()?)),
        _ => return Err("usage: cells RASTER OUT.ply [FACE]".into()),
    };
    let raster = Raster::open(Path::new(input), 1)?;
    let (width, height) = (raster.width(), raster.height());
    let mut heights = vec![0.0; width * height];
    HeightReader::new(&raster.to_band()?).read(Window { column: 0, row: 0, width, height }, &mut heights)?;

    // Where rows run south on the map, the way around a cell by left, lower, right, upper side is counter-clockwise.
    let mirrored = raster.geo_transform().determinant() > 0.0;
    let mut faces: Vec<[usize; 3]> = Vec::new();
    for (row, column) in (0..height - 1).flat_map(|r| (0..width - 1).map(move |c| (r, c))) {
        let at = row * width + column;
        let ring = [at, at + width, at + width + 1, at + 1];
        let valid: Vec<usize> = ring.into_iter().filter(|&i| !heights[i].is_nan()).collect();
        match valid[..] {
            [a, b, c] => faces.push([a, b, c]),
            [a, b, c, d] => faces.extend([[a, b, c], [a, c, d]]),
            _ => {}
        }
    }
    if let Some(face) = left_out
        && !faces.is_empty()
    {
        faces.remove(face % faces.len());
    }
    const UNUSED: u32 = u32::MAX;
    let mut numbers = vec![UNUSED; heights.len()];
    faces.iter().flatten().for_each(|&i| numbers[i] = 0);
    let mut vertices = 0;
    for number in numbers.iter_mut().filter(|n| **n != UNUSED) {
        *number = vertices;
        vertices += 1;
    }
    let mut out = BufWriter::new(std::fs::File::create(output)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        faces.len()
    )?;
    for (index, _) in numbers.iter().enumerate().filter(|(_, n)| **n != UNUSED) {
        let (x, y) = raster.geo_transform().apply(4 * (index % width) as i64, 4 * (index / width) as i64);
        [x, y, heights[index]].iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
    }
    for mut face in faces {
        if mirrored {
            face.swap(1, 2);
        }
        out.write_all(&[3])?;
        face.iter().try_for_each(|&i| out.write_all(&numbers[i].to_le_bytes()))?;
    }
    Ok(out.flush()?)
}
