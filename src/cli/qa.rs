//! What `verify` makes beside its verdict, and the pages of reports.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::Failure;
use crate::base::staged::StagedFile;
use crate::page::{self, Origin};
use crate::run::checkpoints::CheckpointSource;
use crate::run::scene::Most;
use crate::run::{Extras, VerifyReport, VerifyRequest};

#[derive(Debug, clap::Args)]
pub(super) struct QaArgs {
    /// Write the verdict with its figures, charts, maps and a view of the mesh as a page for a browser, in one file
    #[arg(long, help_heading = "Report", value_name = "HTML")]
    report: Option<PathBuf>,
    /// Write the vertical error of every sample, surface less raster, as a tiled GeoTIFF with the raster's place and CRS. Its
    /// nodata value is NaN, where there is no surface or no height
    #[arg(long, help_heading = "Report", value_name = "TIFF")]
    error_raster: Option<PathBuf>,
    /// Hold surveyed heights against the mesh: a table with a first line that names the columns x, y, z and, if there are any, id
    /// and cover (N or V: not vegetated, vegetated)
    #[arg(long, help_heading = "Report", value_name = "CSV")]
    checkpoints: Option<PathBuf>,
    /// The CRS of x and y in the table, if it is not the raster's: EPSG:25832, WKT, or any other form that GDAL takes
    #[arg(long, help_heading = "Report", value_name = "CRS", requires = "checkpoints")]
    checkpoints_crs: Option<String>,
    /// Replace the files that --report and --error-raster name
    #[arg(long, help_heading = "Report")]
    overwrite: bool,
}

impl QaArgs {
    /// What is made.
    pub(super) fn extras(&self) -> Extras {
        let source = |path: &PathBuf| CheckpointSource { path: path.clone(), crs: self.checkpoints_crs.clone() };
        Extras {
            error_raster: self.error_raster.clone(),
            overwrite: self.overwrite,
            survey: self.report.is_some(),
            scene: self.report.as_ref().map(|_| Most::OF_A_PAGE),
            checkpoints: self.checkpoints.as_ref().map(source),
        }
    }

    /// Finds what is wrong with the page's path before the work begins.
    pub(super) fn check(&self, request: &VerifyRequest) -> Result<(), Failure> {
        let Some(path) = &self.report else { return Ok(()) };
        if self.error_raster.as_ref() == Some(path) {
            return Err(Failure::usage(format!("{}: --report and --error-raster name the same file", path.display())));
        }
        Ok(StagedFile::check(path, self.overwrite, &self.kept(request))?)
    }

    /// Writes the page, if there is to be one.
    pub(super) fn write(&self, report: &VerifyReport, request: &VerifyRequest) -> Result<(), Failure> {
        let Some(path) = &self.report else { return Ok(()) };
        let origin = origin(request.input.path(), &request.mesh, request.temp_dir.as_deref());
        let page = page::of_verdict(report, &origin)?;
        Ok(page::write(&page, path, self.overwrite, &self.kept(request))?)
    }

    /// What the page may not replace: what is read, and what else is written.
    fn kept<'r>(&'r self, request: &'r VerifyRequest) -> Vec<&'r Path> {
        request.inputs().into_iter().chain(self.error_raster.as_deref()).collect()
    }
}

/// What a page of these files says of how it came to be.
pub(super) fn origin(raster: &Path, mesh: &Path, temp_dir: Option<&Path>) -> Origin {
    let words = std::env::args_os().enumerate().map(|(i, word)| {
        let word = if i == 0 { "terrabite".into() } else { word.to_string_lossy() };
        quoted(&word)
    });
    Origin {
        command: words.collect(),
        made: now(),
        raster: raster.to_path_buf(),
        mesh: mesh.to_path_buf(),
        temp_dir: temp_dir.map(Path::to_path_buf),
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Day and time in UTC.
fn now() -> String {
    let seconds = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_secs());
    moment(seconds)
}

/// Seconds since 1970 as day and time.
fn moment(seconds: u64) -> String {
    let is_leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let (mut day, mut year, mut month) = (seconds / 86_400, 1970, 1);
    while day >= 365 + u64::from(is_leap(year)) {
        day -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    for days in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if day < days {
            break;
        }
        (day, month) = (day - days, month + 1);
    }
    let (hour, minute) = (seconds / 3600 % 24, seconds / 60 % 60);
    format!("{year}-{month:02}-{:02} {hour:02}:{minute:02} UTC", day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_as_date_says_them() {
        for (seconds, expected) in [
            (0, "1970-01-01 00:00 UTC"),
            (951_782_399, "2000-02-28 23:59 UTC"),
            (951_868_799, "2000-02-29 23:59 UTC"),
            (951_868_800, "2000-03-01 00:00 UTC"),
            (1_767_225_599, "2025-12-31 23:59 UTC"),
        ] {
            assert_eq!(moment(seconds), expected);
        }
    }

    #[test]
    fn words_as_a_shell_takes_them() {
        assert_eq!(
            [quoted("--max-error=5"), quoted("my dem.tif"), quoted("it\'s"), quoted("")],
            ["--max-error=5", "'my dem.tif'", "'it'\\''s'", "''"]
        );
    }
}
