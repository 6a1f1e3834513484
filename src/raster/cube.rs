//! Opening a netCDF, HDF5 or Zarr file once more as a data cube: the array behind a raster, and the arrays that list where
//! its columns and rows are.

use std::path::Path;

use gdal::cpl::CslStringList;
use gdal::raster::{Group, MDArray};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};

/// Groups in groups, and arrays in all of them, that are looked at.
const DEPTH: usize = 8;
const ARRAYS: usize = 4096;

/// A file of a data cube, and the array in it that a raster shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Source {
    /// GDAL's driver for the cube.
    driver: &'static str,
    /// What GDAL opens as a cube.
    file: String,
    /// Groups and the array's name; empty where the name of the raster does not say it.
    array: Vec<String>,
}

impl Source {
    /// Of a raster that GDAL has opened by `name` with `driver`; `variable` is what its metadata call the array. `None` if
    /// the raster is of no data cube.
    pub(super) fn of(driver: &str, name: &str, variable: Option<String>) -> Option<Source> {
        let (driver, prefix) = match driver {
            "netCDF" => ("netCDF", "NETCDF:"),
            "HDF5" | "HDF5Image" => ("HDF5", "HDF5:"),
            "Zarr" => ("Zarr", "ZARR:"),
            _ => return None,
        };
        let (file, inside) = match name.get(..prefix.len()) {
            Some(start) if start.eq_ignore_ascii_case(prefix) => file_and_array(&name[prefix.len()..]),
            _ => (name, ""),
        };
        let mut array: Vec<String> = inside.split('/').filter(|part| !part.is_empty()).map(str::to_string).collect();
        if array.is_empty() {
            array.extend(variable);
        }
        Some(Source { driver, file: file.to_string(), array })
    }

    /// Whether GDAL may show the last row of the array first, as it does in any case where it gives no geotransform.
    pub(super) fn turns_rows(&self) -> bool {
        self.driver == "netCDF"
    }

    /// Opens the file as a cube, finds the array of `size` (columns, rows) and gives it, and the groups it is in, the
    /// innermost first, to `look`. `None` if there is no such array.
    pub(super) fn look<R>(
        &self,
        size: (usize, usize),
        look: impl FnOnce(&[&Group<'_>], &MDArray<'_>) -> R,
    ) -> Option<R> {
        let options = DatasetOptions {
            open_flags: GdalOpenFlags::GDAL_OF_READONLY | GdalOpenFlags::GDAL_OF_MULTIDIM_RASTER,
            allowed_drivers: Some(&[self.driver]),
            ..DatasetOptions::default()
        };
        let cube = Dataset::open_ex(Path::new(&self.file), options).ok()?;
        let root = cube.root_group().ok()?;
        let mut search = Search { wanted: &self.array, size, look: Some(look), found: None, left: ARRAYS };
        search.group(&[&root], 0);
        search.found
    }
}

/// The parts of a subdataset's name without its prefix: `"dems.nc":height`, `dems.h5://grids/height`.
fn file_and_array(name: &str) -> (&str, &str) {
    let parts = match name.strip_prefix('"') {
        Some(quoted) => quoted.split_once('"').map(|(file, rest)| (file, rest.strip_prefix(':').unwrap_or(rest))),
        None => name.split_once("://").or_else(|| name.rsplit_once(':')),
    };
    let (file, array) = parts.unwrap_or((name, ""));
    // Zarr counts the slices of a thicker array behind its name.
    (file, array.split_once(':').map_or(array, |(array, _)| array))
}

struct Search<'s, R, F> {
    wanted: &'s [String],
    size: (usize, usize),
    look: Option<F>,
    found: Option<R>,
    left: usize,
}

impl<R, F: FnOnce(&[&Group<'_>], &MDArray<'_>) -> R> Search<'_, R, F> {
    /// Looks through the first of `groups`, which is `depth` groups below the root.
    fn group(&mut self, groups: &[&Group<'_>], depth: usize) {
        let group = groups[0];
        let (path, name) = match self.wanted.split_last() {
            // A name alone may be in any group.
            Some((name, path)) => (path, Some(name)),
            None => (&[][..], None),
        };
        if depth >= path.len() {
            for array in group.array_names(CslStringList::new()) {
                if name.is_some_and(|name| *name != array) || self.left == 0 {
                    continue;
                }
                self.left -= 1;
                let Ok(array) = group.open_md_array(&array, CslStringList::new()) else { continue };
                if self.fits(&array) {
                    self.found = self.look.take().map(|look| look(groups, &array));
                    return;
                }
            }
        }
        if depth >= DEPTH {
            return;
        }
        for inner in group.group_names(CslStringList::new()) {
            if path.get(depth).is_some_and(|wanted| *wanted != inner) {
                continue;
            }
            let Ok(inner) = group.open_group(&inner, CslStringList::new()) else { continue };
            let all: Vec<&Group<'_>> = std::iter::once(&inner).chain(groups.iter().copied()).collect();
            self.group(&all, depth + 1);
            if self.found.is_some() {
                return;
            }
        }
    }

    fn fits(&self, array: &MDArray<'_>) -> bool {
        let Ok(dimensions) = array.dimensions() else { return false };
        let (columns, rows) = self.size;
        matches!(&dimensions[..], [.., y, x] if y.size() == rows && x.size() == columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_subdatasets_come_apart() {
        let of = |driver: &str, name: &str| {
            Source::of(driver, name, Some("z".to_string())).map(|s| (s.file, s.array.join("/")))
        };
        let is = |file: &str, array: &str| Some((file.to_string(), array.to_string()));
        assert_eq!(of("netCDF", "a:b/dems.nc"), is("a:b/dems.nc", "z"));
        assert_eq!(of("netCDF", "NETCDF:\"a:b/dems.nc\":height"), is("a:b/dems.nc", "height"));
        assert_eq!(of("netCDF", "netcdf:dems.nc:height"), is("dems.nc", "height"));
        assert_eq!(
            of("netCDF", "NETCDF:\"/vsizip/a.zip/dems.nc\":/group/height"),
            is("/vsizip/a.zip/dems.nc", "group/height")
        );
        assert_eq!(of("HDF5Image", "HDF5:\"dems.h5\"://grids/height"), is("dems.h5", "grids/height"));
        assert_eq!(of("HDF5Image", "HDF5:dems.h5://grids/height"), is("dems.h5", "grids/height"));
        assert_eq!(of("Zarr", "ZARR:\"dems.zarr\":/height:0"), is("dems.zarr", "height"));
        assert_eq!(of("GTiff", "dem.tif"), None);
    }
}
