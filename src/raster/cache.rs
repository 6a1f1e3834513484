//! GDAL's block cache.

use std::sync::atomic::{AtomicBool, Ordering};

static IS_OURS: AtomicBool = AtomicBool::new(false);

/// Says that nobody but terrabite uses GDAL in this process, as in the `terrabite` command: [`bound_gdal_cache`] may then make
/// the cache as small as it likes.
pub fn own_gdal_cache() {
    IS_OURS.store(true, Ordering::Relaxed);
}

/// Keeps GDAL's block cache to this number of bytes, where the user has not said otherwise by `GDAL_CACHEMAX`: blocks are read
/// and written whole, and GDAL's own choice is a twentieth of the machine's memory. What the cache holds beyond is given up.
///
/// Only after [`own_gdal_cache`]. A process that is another's keeps its cache as it is, and `GDAL_CACHEMAX` bounds it. Where the
/// cache is full, GDAL (3.6.2) writes blocks of whatever dataset from the thread that wants room; a GeoTIFF that another thread
/// completes at that moment is damaged, or the process crashes. The smaller a cache, the sooner.
#[allow(unsafe_code)]
pub fn bound_gdal_cache(bytes: u64) {
    let is_said = || !gdal::config::get_config_option("GDAL_CACHEMAX", "").is_ok_and(|said| said.is_empty());
    if IS_OURS.load(Ordering::Relaxed) && !is_said() {
        // SAFETY: takes a number, and locks the cache itself; whoever reads meanwhile has a lock on the block that is read, and
        // nobody completes a file.
        unsafe { gdal_sys::GDALSetCacheMax64(i64::try_from(bytes).unwrap_or(i64::MAX)) }
    }
}

#[cfg(test)]
#[allow(unsafe_code)]
mod tests {
    use super::{bound_gdal_cache, own_gdal_cache};
    use crate::base::Window;
    use crate::raster::Raster;
    use gdal::raster::Buffer;
    use gdal::{Dataset, DriverManager};
    use std::path::Path;

    const SIDE: usize = 1024;

    /// A cache is that of a process, so these tests run in processes of their own.
    fn alone(name: &str, test: impl FnOnce(&Path)) {
        const ALONE: &str = "TERRABITE_TEST_ALONE";
        if std::env::var_os(ALONE).is_some() {
            return test(tempfile::tempdir().expect("a folder").path());
        }
        let mut child = std::process::Command::new(std::env::current_exe().expect("a name"));
        child.args(["--exact", &format!("raster::cache::tests::{name}")]);
        let output = child.env(ALONE, "1").env_remove("GDAL_CACHEMAX").output().expect("runs");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(said.contains("1 passed"), "{said}");
    }

    /// Two megabytes of blocks that are in the cache and not yet in the file.
    fn written(path: &Path) -> Dataset {
        let driver = DriverManager::get_driver_by_name("GTiff").expect("a driver");
        let dataset = driver.create_with_band_type::<i16, _>(path, SIDE, SIDE, 1).expect("creates");
        let mut samples = Buffer::new((SIDE, SIDE), vec![7i16; SIDE * SIDE]);
        dataset.rasterband(1).expect("a band").write((0, 0), (SIDE, SIDE), &mut samples).expect("writes");
        assert!(used() >= 2 << 20, "{}", used());
        dataset
    }

    fn used() -> i64 {
        // SAFETY: gives a number.
        unsafe { gdal_sys::GDALGetCacheUsed64() }
    }

    fn bound() -> i64 {
        // SAFETY: gives a number.
        unsafe { gdal_sys::GDALGetCacheMax64() }
    }

    fn read(path: &Path) {
        let mut samples = vec![0; 2 * 16 * 16];
        let window = Window { column: 0, row: 0, width: 16, height: 16 };
        Raster::open(path, 1).expect("opens").read_native(window, &mut samples).expect("reads");
    }

    #[test]
    fn a_bound_holds_after_blocks_were_read() {
        alone("a_bound_holds_after_blocks_were_read", |folder| {
            own_gdal_cache();
            let dataset = written(&folder.join("dem.tif"));
            bound_gdal_cache(1 << 20);
            assert_eq!(bound(), 1 << 20);
            assert!(used() <= 1 << 20, "{}", used());
            dataset.close().expect("closes");
            read(&folder.join("dem.tif"));
            bound_gdal_cache(7 << 20);
            assert_eq!(bound(), 7 << 20);
        });
    }

    #[test]
    fn a_cache_of_others_stays_as_it_is() {
        alone("a_cache_of_others_stays_as_it_is", |folder| {
            bound_gdal_cache(1 << 20);
            let dataset = written(&folder.join("dem.tif"));
            let (before, had) = (used(), bound());
            assert!(had > 2 << 20, "{had}");
            bound_gdal_cache(1 << 20);
            assert_eq!((used(), bound()), (before, had));
            dataset.close().expect("closes");
        });
    }
}
