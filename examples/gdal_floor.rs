//! The physical floor of the benchmarks: what GDAL alone needs to decode a raster once.
//!
//! `gdal_floor read RASTER THREADS` reads every block of band 1 once and drops it, each thread through a handle of its
//! own and past GDAL's block cache, and prints the seconds. `gdal_floor raw RASTER OUT` writes band 1 as bare
//! single-precision numbers, for a program that opens no rasters. Called by `scripts/bench.py`.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use gdal::Dataset;
use gdal::raster::{GdalDataType, GdalType, RasterBand};

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["read", raster, threads] => read(raster, threads.parse()?),
        ["raw", raster, out] => raw(raster, out),
        _ => Err("expected: read RASTER THREADS, or: raw RASTER OUT".into()),
    }
}

/// Reads every block on `threads` threads, which take the next one from a counter.
fn read(raster: &str, threads: usize) -> Outcome<()> {
    let start = Instant::now();
    let next = AtomicUsize::new(0);
    let blocks = std::thread::scope(|scope| {
        let readers: Vec<_> = (0..threads).map(|_| scope.spawn(|| read_blocks(raster, &next))).collect();
        readers.into_iter().map(|r| r.join().expect("readers do not panic")).sum::<Outcome<usize>>()
    })?;
    println!("{{\"seconds\": {}, \"blocks\": {blocks}}}", start.elapsed().as_secs_f64());
    Ok(())
}

fn read_blocks(raster: &str, next: &AtomicUsize) -> Outcome<usize> {
    let dataset = Dataset::open(raster)?;
    let band = dataset.rasterband(1)?;
    let ((width, height), (block_width, block_height)) = (band.size(), band.block_size());
    let (across, down) = (width.div_ceil(block_width), height.div_ceil(block_height));
    let mut blocks = 0;
    loop {
        let index = next.fetch_add(1, Ordering::Relaxed);
        if index >= across * down {
            return Ok(blocks);
        }
        drop_block(&band, (index % across, index / across))?;
        blocks += 1;
    }
}

fn drop_block(band: &RasterBand<'_>, block: (usize, usize)) -> Outcome<()> {
    fn of_type<T: Copy + GdalType>(band: &RasterBand<'_>, block: (usize, usize)) -> Outcome<()> {
        std::hint::black_box(band.read_block::<T>(block)?.data());
        Ok(())
    }
    match band.band_type() {
        GdalDataType::UInt8 => of_type::<u8>(band, block),
        GdalDataType::Int16 => of_type::<i16>(band, block),
        GdalDataType::UInt16 => of_type::<u16>(band, block),
        GdalDataType::Int32 => of_type::<i32>(band, block),
        GdalDataType::UInt32 => of_type::<u32>(band, block),
        GdalDataType::Float32 => of_type::<f32>(band, block),
        GdalDataType::Float64 => of_type::<f64>(band, block),
        other => Err(format!("samples of type {}", other.name()).into()),
    }
}

/// Writes all rows as little-endian single-precision numbers, a row of blocks at a time.
fn raw(raster: &str, out: &str) -> Outcome<()> {
    let dataset = Dataset::open(raster)?;
    let band = dataset.rasterband(1)?;
    let ((width, height), (_, block_height)) = (band.size(), band.block_size());
    let mut file = BufWriter::new(File::create(out)?);
    for row in (0..height).step_by(block_height) {
        let size = (width, block_height.min(height - row));
        for value in band.read_as::<f32>((0, row as isize), size, size, None)?.data() {
            file.write_all(&value.to_le_bytes())?;
        }
    }
    Ok(file.flush()?)
}
