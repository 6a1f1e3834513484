//! terrabite bites terrains of any size into triangles: a raster of heights goes in, a triangulated irregular network
//! comes out whose surface is within a stated vertical distance of every sample.
//!
//! From a file to a file, as the command does it, with progress and a way to stop:
//!
//! ```no_run
//! # #[cfg(feature = "gdal")]
//! # fn run() -> Result<(), terrabite::run::RunError> {
//! use terrabite::base::control::{CancelToken, Control, Silent};
//! use terrabite::run::{Request, VerifyRequest, simplify, verify};
//!
//! let cancel = CancelToken::default(); // `cancel.cancel()`, from any thread, stops the run
//! let control = Control { cancel, progress: &Silent }; // or an implementation of `Progress`
//! let request = Request { fill_voids: 100, ..Request::new("dem.tif", "tin.ply", 5.0) };
//! let report = simplify(&request, &control)?;
//! println!("{} triangles, largest error {}", report.triangles, report.error.max);
//! let check = VerifyRequest { fill_voids: 100, ..VerifyRequest::new("dem.tif", "tin.ply", 5.0) };
//! assert!(verify(&check, &control)?.passed);
//! # Ok(())
//! # }
//! ```
//!
//! Ten items are enough for that and more:
//!
//! - [`run::Request`] says what to do, all that the command can be asked for; [`run::simplify`] does it, [`run::plan`]
//!   says what it takes; [`run::Report`] is what came of it, [`run::RunError`] why nothing did.
//! - [`run::verify`] judges a written mesh by other code.
//! - [`job::Params`] has the numbers and choices that decide a mesh.
//! - [`base::Band`] is a raster's band, as GDAL opens it, in memory, or read window by window by any program.
//! - [`base::control::Control`] watches and stops a run.
//! - [`formats::FORMATS`] lists the formats of meshes.
//!
//! Heights in memory:
//!
//! ```
//! use terrabite::base::Band;
//! use terrabite::base::control::Control;
//! use terrabite::run::{Request, VerifyRequest, simplify, verify};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (width, height) = (300, 200);
//! let bowl = |i: usize| {
//!     let (x, y) = ((i % width) as f32 - 150.0, (i / width) as f32 - 100.0);
//!     (x * x + y * y) / 100.0
//! };
//! let band = Band::of_singles("bowl", (width, height), (0..width * height).map(bowl).collect())?;
//! # let folder = tempfile::tempdir()?;
//! # let tin = folder.path().join("tin.ply");
//! # let tin = tin.as_path();
//! let report = simplify(&Request::new(band.clone(), tin, 0.5), &Control::default())?;
//! assert!(report.triangles > 100 && report.error.max <= 0.5);
//! assert!(verify(&VerifyRequest::new(band, tin, 0.5), &Control::default())?.passed);
//! # Ok(())
//! # }
//! ```
//!
//! Below that, a [`field::Field`] makes samples readable, [`job::triangulate`] works on its tiles on the threads of the
//! current rayon pool, and the [`job::Mesh`] it returns gives them back as chunks, in tile order, or writes them to a
//! [`formats::Sink`].
//!
//! The features `gdal` (rasters, layers of points and polygons, pictures) and `cli` (the command) are on unless
//! `default-features = false`; the rest needs neither.
//!
//! The library installs no handlers. GDAL prints its errors on standard error by itself; [`raster::quiet_gdal`] stops that,
//! for the whole process; [`raster::keep_gdal_warnings`] also keeps its warnings, for [`raster::take_gdal_warnings`].

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
pub mod page;
#[cfg(feature = "gdal")]
pub mod preview;
#[cfg(feature = "gdal")]
pub mod pyramid;
#[cfg(feature = "gdal")]
pub mod raster;
pub mod run;
pub mod synth;
#[cfg(test)]
mod testing;
#[cfg(feature = "gdal")]
pub mod tiles_verify;
pub mod verify;
