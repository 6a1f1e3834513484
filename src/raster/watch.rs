//! Noticing that a raster or a layer is changed while a run reads it.

use std::path::{Path, PathBuf};

use super::companions::Companions;
use super::remote::{afresh, is_remote};
use super::{Opening, Raster, RasterError};
use crate::base::{FileState, Files, Watch, identity};

/// Whether all files with samples are among its companions.
fn is_plain_geotiff(raster: &Raster) -> bool {
    raster.driver() == "GTiff" && raster.path().is_file()
}

/// Paths, and what was there when they were looked at first.
#[derive(Debug)]
struct Watched(Vec<(PathBuf, String, Option<FileState>)>);

impl Watched {
    fn of(main: &Path, companions: Companions) -> Watched {
        let folder = main.parent().unwrap_or(Path::new(""));
        let named = |path: PathBuf| {
            let own = path == main;
            let name = path.strip_prefix(folder).unwrap_or(&path).display().to_string();
            let name = if own { String::new() } else { name };
            let state = FileState::of(&path, &name);
            (path, name, state)
        };
        Watched(companions.paths.into_iter().map(named).collect())
    }

    fn files(&self, all: bool) -> Files {
        Files::new(all, self.0.iter().filter_map(|(_, _, state)| state.clone()).collect())
    }
}

/// Notices that a raster, or a layer, is changed while a run reads it.
///
/// Cost: a look at the files that `companions` finds, about ten beside a GeoTIFF; where they are not all there may
/// be, the full check also reads [`identity`], at the beginning and in the end.
#[derive(Debug)]
pub struct FileWatch {
    path: PathBuf,
    is_layer: bool,
    watched: Watched,
    files: Files,
    /// Whether samples come, or may come, from another machine.
    is_remote: bool,
    /// How the raster is opened once more, and what it was recognised by.
    identity: Option<(Opening, Vec<(&'static str, String)>)>,
}

/// Paths that [`Watch::check_files`] looks at, at the most: of a mosaic of more the last check finds the others.
const QUICK: usize = 256;

impl FileWatch {
    /// Begins to watch a raster. To be called before any sample is read.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    pub fn new(raster: &Raster) -> Result<FileWatch, RasterError> {
        let path = raster.path();
        let watched = Watched::of(path, Companions::of_raster(path));
        let files = watched.files(is_plain_geotiff(raster));
        let identity = if files.are_all() { None } else { Some((raster.opening(), identity(&raster.to_band()?)?)) };
        let is_remote = is_remote(path) || raster.driver() == "VRT";
        Ok(FileWatch { path: path.to_path_buf(), is_layer: false, watched, files, is_remote, identity })
    }

    /// Begins to watch the files of a layer of points or polygons. To be called before it is opened.
    pub fn layer(path: &Path) -> FileWatch {
        let watched = Watched::of(path, Companions::of_layer(path));
        FileWatch {
            path: path.to_path_buf(),
            is_layer: true,
            watched,
            files: Files::none(),
            is_remote: false,
            identity: None,
        }
    }

    fn compare(&self, most: usize) -> Result<(), RasterError> {
        for (path, name, before) in self.watched.0.iter().take(most) {
            let now = FileState::of(path, name);
            if now != *before {
                let what = if name.is_empty() { "file".to_string() } else { format!("file {name}") };
                return Err(self.changed(&what, FileState::said(before.as_ref()), FileState::said(now.as_ref())));
            }
        }
        Ok(())
    }

    fn changed(&self, what: &str, expected: String, found: String) -> RasterError {
        let (path, what) = (self.path.clone(), what.to_string());
        match self.is_layer {
            true => RasterError::LayerChanged { path, what, expected, found },
            false => RasterError::Changed { path, what, expected, found },
        }
    }
}

impl Watch for FileWatch {
    /// A layer has none: what it holds is told by itself.
    fn files(&self) -> &Files {
        &self.files
    }

    fn check(&self) -> Result<(), RasterError> {
        self.compare(usize::MAX)?;
        let Some((opening, before)) = &self.identity else { return Ok(()) };
        // A handle of its own: GDAL may hold blocks of the old one.
        let look = || identity(&opening.open()?.to_band()?);
        let now = if self.is_remote { afresh(look)? } else { look()? };
        match before.iter().zip(now).find(|(before, now)| *before != now) {
            Some(((what, expected), (_, found))) => Err(self.changed(what, expected.clone(), found)),
            None => Ok(()),
        }
    }

    fn check_files(&self) -> Result<(), RasterError> {
        self.compare(QUICK)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gdal::DriverManager;
    use std::fs;

    fn files_of(raster: &Raster) -> Files {
        Watched::of(raster.path(), Companions::of_raster(raster.path())).files(is_plain_geotiff(raster))
    }

    fn dem(folder: &Path) -> PathBuf {
        let path = folder.join("dem.tif");
        let driver = DriverManager::get_driver_by_name("GTiff").expect("built in");
        driver.create_with_band_type::<u8, _>(&path, 20, 10, 1).expect("made").close().expect("closed");
        path
    }

    /// What a check says after `change`; the files as they were, and as they are.
    fn after(change: impl FnOnce(&Path)) -> (String, Files, Files) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = dem(folder.path());
        fs::write(folder.path().join("dem.tfw"), "1\n0\n0\n-1\n0\n0\n").expect("written");
        let raster = Raster::open(&path, 1).expect("opens");
        let watch = FileWatch::new(&raster).expect("a watch");
        assert!(watch.check().is_ok() && watch.check_files().is_ok() && watch.files().same_samples(&files_of(&raster)));
        change(folder.path());
        let said = watch.check_files().expect_err("a change").to_string();
        assert_eq!(watch.check().expect_err("a change").to_string(), said);
        (said, watch.files().clone(), files_of(&raster))
    }

    #[test]
    fn a_file_that_comes_up_goes_or_changes_is_named() {
        type Change = fn(&Path);
        let changes: [(Change, &str, &str); 4] = [
            (
                |f| fs::write(f.join("dem.tif.msk"), "mask").unwrap(),
                "dem.tif.msk",
                "expected file dem.tif.msk no such file",
            ),
            (|f| fs::write(f.join("dem.tif.aux.xml"), "<PAMDataset/>").unwrap(), "dem.tif.aux.xml", "found 13 bytes"),
            (|f| fs::remove_file(f.join("dem.tfw")).unwrap(), "dem.tfw", "found no such file"),
            (
                |f| fs::File::options().append(true).open(f.join("dem.tif")).unwrap().set_len(9).unwrap(),
                "the raster's own file",
                "dem.tif: the raster has changed: expected file ",
            ),
        ];
        for (change, name, words) in changes {
            let (said, before, now) = after(change);
            assert!(said.contains(words), "{said}");
            assert!(!before.same_samples(&now));
            assert_eq!((before.differences(&now), now.differences(&before)), (vec![name.into()], vec![name.into()]));
        }
    }

    #[test]
    fn the_parts_of_a_layer_are_watched() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("peaks.csv");
        fs::write(&path, "x,y\n1,2\n").expect("written");
        let watch = FileWatch::layer(&path);
        assert!(watch.check().is_ok());
        fs::write(folder.path().join("peaks.prj"), "LOCAL_CS[]").expect("written");
        assert!(watch.check().expect_err("a change").to_string().contains("peaks.prj"));
    }
}
