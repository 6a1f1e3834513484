//! GDAL's block cache.

/// Keeps GDAL's block cache to this number of bytes, where the user has not said otherwise by `GDAL_CACHEMAX`: blocks are read
/// and written whole, and GDAL's own choice is a twentieth of the machine's memory. What the cache holds beyond is given up.
///
/// The configuration option would not do: GDAL looks at it once, when the first block is read, and opening a raster may read
/// some (to see whether samples of a mosaic are missing).
#[allow(unsafe_code)]
pub fn bound_gdal_cache(bytes: u64) {
    if gdal::config::get_config_option("GDAL_CACHEMAX", "").is_ok_and(|said| said.is_empty()) {
        // SAFETY: takes a number, and locks the cache itself; whoever reads meanwhile has a lock on the block that is read.
        unsafe { gdal_sys::GDALSetCacheMax64(i64::try_from(bytes).unwrap_or(i64::MAX)) }
    }
}

#[cfg(test)]
mod tests {
    use super::bound_gdal_cache;
    use crate::base::Window;
    use crate::raster::Raster;

    /// Other tests set bounds, too, so this one runs in a process of its own.
    #[test]
    #[allow(unsafe_code)]
    fn a_bound_holds_after_blocks_were_read() {
        const ALONE: &str = "TERRABITE_TEST_ALONE";
        if std::env::var_os(ALONE).is_none() {
            let mut child = std::process::Command::new(std::env::current_exe().expect("a name"));
            child.args(["--exact", "raster::cache::tests::a_bound_holds_after_blocks_were_read"]);
            let said = child.env(ALONE, "1").env_remove("GDAL_CACHEMAX").output().expect("runs").stdout;
            let said = String::from_utf8_lossy(&said).into_owned();
            assert!(said.contains("1 passed"), "{said}");
            return;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("dem.tif");
        let driver = gdal::DriverManager::get_driver_by_name("GTiff").expect("a driver");
        driver.create_with_band_type::<i16, _>(&path, 256, 256, 1).expect("creates").close().expect("writes");
        let mut samples = vec![0; 2 * 16 * 16];
        let window = Window { column: 0, row: 0, width: 16, height: 16 };
        Raster::open(&path, 1).expect("opens").read_native(window, &mut samples).expect("reads");
        bound_gdal_cache(7 << 20);
        // SAFETY: gives a number.
        assert_eq!(unsafe { gdal_sys::GDALGetCacheMax64() }, 7 << 20);
    }
}
