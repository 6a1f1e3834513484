//! Checkpoints: heights that somebody has surveyed, held against the mesh.
//!
//! In comes a table ([`Checkpoint`]) and all faces as `verify` passes them; out go the residuals and what accuracy standards make
//! of them ([`CheckpointReport`]). This says how well the raster and the mesh agree with the ground; the tolerance only says how
//! well the mesh agrees with the raster.

mod figures;
mod locate;
mod read;

use std::path::PathBuf;

use serde::Serialize;

use crate::base::Band;

pub use figures::Residuals;
pub use read::{Checkpoint, CheckpointError, Cover};

use locate::Locator;

/// A table of checkpoints.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckpointSource {
    /// The table.
    pub path: PathBuf,
    /// The CRS of x and y; `None` is the raster's. Heights stay as they are.
    pub crs: Option<String>,
}

/// How many residuals are listed as the worst.
const WORST: usize = 10;

/// What checkpoints come to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckpointReport {
    /// The table.
    pub file: String,
    /// The CRS of x and y in the table, if it is not the raster's.
    pub crs: Option<String>,
    /// Checkpoints in the table.
    pub read: u64,
    /// Those of them that are not over or under the mesh. They count in nothing else.
    pub off_mesh: u64,
    /// Of all on the mesh.
    pub all: Option<Residuals>,
    /// Of those that are not vegetated (N).
    pub non_vegetated: Option<Residuals>,
    /// Of those that are vegetated (V).
    pub vegetated: Option<Residuals>,
    /// Non-vegetated vertical accuracy at 95 % confidence, by ASPRS 2014: 1.96 × the RMSE of those that are not vegetated. It
    /// supposes errors with a normal distribution.
    pub nva: Option<f64>,
    /// Vegetated vertical accuracy, by ASPRS 2014: the 95th percentile of the absolute residuals of those that are vegetated.
    pub vva: Option<f64>,
    /// The ten with the largest absolute residuals, the largest first.
    pub worst: Vec<WorstResidual>,
}

impl std::fmt::Display for CheckpointReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let CheckpointReport { read, off_mesh, all, nva, vva, .. } = self;
        write!(f, "checkpoints: {} of {read} on the mesh", read - off_mesh)?;
        if let Some(all) = all {
            write!(f, ", mean {:.4}, RMSE {:.4}, 95 % up to {:.4}", all.mean, all.rmse, all.p95)?;
        }
        nva.map_or(Ok(()), |nva| write!(f, "; NVA {nva:.4}"))?;
        vva.map_or(Ok(()), |vva| write!(f, "; VVA {vva:.4}"))
    }
}

/// A checkpoint and the surface at it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorstResidual {
    /// What it is called.
    pub id: String,
    /// Its place in the table's CRS.
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// Its height.
    pub z: f64,
    /// The height of the surface.
    pub surface: f64,
    /// The surface less the checkpoint.
    pub residual: f64,
    /// What is around it, if the table says so.
    pub cover: Option<Cover>,
}

/// Checkpoints that are being found on a mesh.
pub(super) struct Finding {
    source: CheckpointSource,
    points: Vec<Checkpoint>,
    locator: Locator,
}

impl Finding {
    /// Reads the table, and brings places into the CRS of the raster.
    pub(super) fn begin(source: &CheckpointSource, band: &Band) -> Result<Finding, CheckpointError> {
        let points = read::read(&source.path)?;
        let mut places: Vec<(f64, f64)> = points.iter().map(|point| (point.place[0], point.place[1])).collect();
        if let Some(crs) = &source.crs {
            transform(&mut places, crs, band).map_err(|reason| CheckpointError::Crs {
                path: source.path.clone(),
                from: crs.clone(),
                reason,
            })?;
        }
        let locator = Locator::new(band.geo_transform(), places.into_iter());
        Ok(Finding { source: source.clone(), points, locator })
    }

    pub(super) fn face(&mut self, corners: [(i64, i64); 3], heights: [f64; 3]) {
        self.locator.face(corners, heights);
    }

    pub(super) fn finish(self) -> CheckpointReport {
        let on_mesh = self.points.iter().zip(self.locator.finish());
        let mut found: Vec<(&Checkpoint, f64)> = on_mesh.filter_map(|(point, z)| Some((point, z?))).collect();
        let residual = |(point, surface): &(&Checkpoint, f64)| surface - point.place[2];
        let of = |cover: Option<Cover>| {
            Residuals::of(found.iter().filter(|(point, _)| cover.is_none() || point.cover == cover).map(residual))
        };
        let (all, non_vegetated, vegetated) = (of(None), of(Some(Cover::NonVegetated)), of(Some(Cover::Vegetated)));
        let read = self.points.len() as u64;
        let off_mesh = read - found.len() as u64;
        // Stable: of equal ones the first in the table comes first.
        found.sort_by(|a, b| residual(b).abs().total_cmp(&residual(a).abs()));
        let worst = found.iter().take(WORST).map(|(point, surface)| {
            let ([x, y, z], cover, id) = (point.place, point.cover, point.id.clone());
            WorstResidual { id, x, y, z, surface: *surface, residual: surface - z, cover }
        });
        CheckpointReport {
            file: self.source.path.display().to_string(),
            crs: self.source.crs.clone(),
            read,
            off_mesh,
            all,
            non_vegetated,
            vegetated,
            nva: non_vegetated.map(|residuals| 1.96 * residuals.rmse),
            vva: vegetated.map(|residuals| residuals.p95),
            worst: worst.collect(),
        }
    }
}

#[cfg(feature = "gdal")]
fn transform(places: &mut [(f64, f64)], crs: &str, band: &Band) -> Result<(), String> {
    let into = band.crs_definition().ok_or("the raster has none")?;
    crate::raster::bring_into(places, crs, into)
}

#[cfg(not(feature = "gdal"))]
fn transform(_: &mut [(f64, f64)], _: &str, _: &Band) -> Result<(), String> {
    Err("this build has no GDAL".to_string())
}
