//! terrabite bites terrains of any size into triangles: a raster of heights goes in, a triangulated irregular network
//! comes out whose surface is within a stated vertical distance of every sample.
//!
//! A [`field::Field`] makes samples readable, from memory or from a raster. [`simplify::triangulate`] cuts it into
//! tiles, works on them on the threads of the current rayon pool and keeps the finished ones on disk; the
//! [`simplify::Mesh`] it returns gives them back as chunks, in tile order, or writes them to a [`sink::Sink`].
//! [`verify::verify`] judges a written mesh by other code. Fields may have [`channels`] beside the heights, such as
//! colours. A [`control::Control`] watches and stops any of them.
//!
//! Heights from memory, with progress, cancellation and the triangles of every chunk:
//!
//! ```
//! use terrabite::base::control::{CancelToken, Control, Progress, Stage};
//! use terrabite::base::{Heights};
//! use terrabite::field::{Field};
//! use terrabite::job::{Params, triangulate};
//!
//! /// Gives up once it has heard of a thousand tiles; `step` is called from several threads.
//! struct Patience(CancelToken, std::sync::atomic::AtomicU64);
//!
//! impl Progress for Patience {
//!     fn begin(&self, stage: Stage, steps: u64, _samples: u64) {
//!         println!("{stage:?}: {steps} steps");
//!     }
//!     fn step(&self, _: Stage, _samples: u64) {
//!         if self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed) == 1000 {
//!             self.0.cancel();
//!         }
//!     }
//!     fn end(&self, _: Stage) {}
//! }
//!
//! # fn main() -> Result<(), terrabite::job::Error> {
//! let (width, height) = (300, 200);
//! let bowl = |i: usize| {
//!     let (x, y) = ((i % width) as f32 - 150.0, (i / width) as f32 - 100.0);
//!     (x * x + y * y) / 100.0
//! };
//! let field = Field::from_heights(width, height, Heights::F32((0..width * height).map(bowl).collect()))?;
//!
//! let cancel = CancelToken::default();
//! let patience = Patience(cancel.clone(), Default::default());
//! let control = Control { cancel, progress: &patience };
//! let mesh = triangulate(&field, &Params { tile: 128, ..Params::new(0.5) }, &control)?;
//!
//! let mut triangles = 0;
//! for chunk in mesh.chunks() {
//!     // Places are tile-local, in quarter cells; `mesh.grid()` says where the tile lies.
//!     triangles += chunk?.triangles.len();
//! }
//! assert!(triangles > 100 && triangles < width * height / 10);
//! # Ok(())
//! # }
//! ```
//!
//! From a file to a file:
//!
//! ```no_run
//! use std::path::Path;
//!
//! use terrabite::base::control::Control;
//! use terrabite::field::{Field, FieldOptions};
//! use terrabite::raster::Raster;
//! use terrabite::job::{Error, Params, triangulate};
//! use terrabite::formats::{Header, PlySink};
//! use terrabite::base::staged::StagedFile;
//!
//! # fn main() -> Result<(), Error> {
//! let (input, output) = (Path::new("dem.tif"), Path::new("tin.ply"));
//! let control = Control::default();
//! let raster = Raster::open(input, 1)?;
//! let staged = StagedFile::create(output, false, &[input])?;
//! let field = Field::open(&raster, &FieldOptions::default(), &control)?;
//! let mesh = triangulate(&field, &Params::new(5.0), &control)?;
//! let summary = mesh.write(Box::new(PlySink::new(staged, Header::default())), &control)?;
//! println!("{} triangles, largest error {}", summary.triangles, summary.errors.max);
//! # Ok(())
//! # }
//! ```
//!
//! [`field::Field::open_with_importance`] takes a second raster with the first, whose samples weigh the errors: distance ×
//! weight is within the tolerance then.
//!
//! GDAL prints its errors on standard error by itself; [`raster::quiet_gdal`] stops that, for the whole process;
//! [`raster::keep_gdal_warnings`] also keeps its warnings, for [`raster::take_gdal_warnings`].

pub mod base;
#[cfg(feature = "cli")]
pub mod cli;
pub mod field;
pub mod formats;
#[cfg(all(any(test, feature = "fuzzing"), feature = "gdal"))]
#[doc(hidden)]
pub mod fuzzing;
pub mod job;
pub mod kernel;
#[cfg(feature = "gdal")]
pub mod preview;
#[cfg(feature = "gdal")]
pub mod raster;
pub mod run;
pub mod synth;
#[cfg(test)]
mod testing;
pub mod verify;
