//! Warnings: what a user should know of an input although the run goes on.
//!
//! Whoever finds something makes a [`Warning`], a sentence without options; [`Warnings`] keeps one for each kind and file. The
//! command adds what mends it, and prints them or puts them into its JSON.

use std::path::{Path, PathBuf};

use serde::Serialize;

/// The kinds of warnings. Their names in JSON are stable; docs/rasters.md lists them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum WarningCode {
    /// GDAL's own words.
    Gdal,
    /// The band holds colours, and no band was named.
    Picture,
    /// The nodata tag is a value that no sample can have.
    UnreachableNodata,
    /// Samples are missing because they are close to a mark that they do not equal.
    NearNodata,
    /// Samples with the value 0 are missing because the nodata tag is 0.
    ZeroNodata,
    /// Samples beside voids lie far beyond the heights of all others.
    NearVoids,
    /// The mesh is complete, but a budget ended it before the quality that was asked for.
    FellShort,
    /// The work dir of a finished run could not be removed.
    WorkDirLeft,
    /// Columns run from south to north and rows from west to east.
    SwappedAxes,
    /// The file lists longitudes and latitudes or projected coordinates, and does not say of which CRS.
    NoGridMapping,
    /// The file names another value for missing samples than GDAL takes.
    FillValue,
    /// A table has no lines for some samples, and nothing marks these.
    XyzGaps,
    /// This version of GDAL reads some heights of the format wrongly.
    Misread,
    /// The values are depths.
    Depths,
    /// The format of the output does not keep the attributes of vertices.
    AttributesLost,
    /// Features of a layer have no geometry.
    NoGeometry,
    /// The format of the output does not mark edges that follow lines.
    EdgesLost,
    /// The format of the output does not keep all that the mesh says of itself.
    HeaderLost,
}

/// Something about a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// What kind it is.
    pub code: WarningCode,
    /// The file it is about, as the user named it.
    #[serde(serialize_with = "displayed")]
    pub file: PathBuf,
    /// How many samples, lines or messages it is about, at least 1.
    pub count: u64,
    /// A sentence, without a full stop.
    pub message: String,
}

impl Warning {
    /// That so many features of a layer are passed over; `None` where there are none.
    pub(crate) fn of_no_geometry(file: &Path, count: u64) -> Option<Warning> {
        let message = match count {
            0 => return None,
            1 => "1 feature has no geometry and is passed over".to_string(),
            count => format!("{count} features have no geometry and are passed over"),
        };
        Some(Warning { code: WarningCode::NoGeometry, file: file.to_path_buf(), count, message })
    }
}

fn displayed<S: serde::Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&path.display())
}

/// Warnings in the order in which they were found first.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Warnings(Vec<Warning>);

impl Warnings {
    /// GDAL's kinds of messages that are kept; what comes after them is only counted.
    pub const GDAL_KINDS: usize = 20;

    /// Adds one. Of GDAL's messages each is a kind of its own; of other codes there is one for each file. Where it is known
    /// already its count grows.
    pub fn add(&mut self, warning: Warning) {
        let is_gdal = warning.code == WarningCode::Gdal;
        let same = |w: &&mut Warning| {
            w.code == warning.code && w.file == warning.file && (!is_gdal || w.message == warning.message)
        };
        if let Some(known) = self.0.iter_mut().find(same) {
            known.count = known.count.saturating_add(warning.count);
            return;
        }
        if is_gdal {
            let kinds = self.0.iter().filter(|w| w.code == WarningCode::Gdal).count();
            if kinds >= Self::GDAL_KINDS {
                return;
            }
        }
        self.0.push(warning);
    }

    /// All of them.
    pub fn iter(&self) -> std::slice::Iter<'_, Warning> {
        self.0.iter()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Extend<Warning> for Warnings {
    fn extend<I: IntoIterator<Item = Warning>>(&mut self, warnings: I) {
        warnings.into_iter().for_each(|warning| self.add(warning));
    }
}

impl IntoIterator for Warnings {
    type Item = Warning;
    type IntoIter = std::vec::IntoIter<Warning>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gdal(message: &str) -> Warning {
        Warning { code: WarningCode::Gdal, file: "dem.tif".into(), count: 1, message: message.to_string() }
    }

    #[test]
    fn the_same_message_is_counted_and_at_most_twenty_kinds_of_gdals_are_kept() {
        let mut warnings = Warnings::default();
        warnings.extend((0..30).flat_map(|i| [gdal(&format!("kind {i}")), gdal("kind 0")]));
        assert_eq!(warnings.iter().count(), Warnings::GDAL_KINDS);
        assert_eq!(warnings.iter().next().map(|w| w.count), Some(31));
        let json = serde_json::to_value(&warnings).expect("JSON");
        assert_eq!(json[1], serde_json::json!({"code": "gdal", "file": "dem.tif", "count": 1, "message": "kind 1"}));
    }
}
