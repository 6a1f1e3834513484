//! Rasters on other machines.

use std::path::Path;

use gdal::config::{clear_config_option, get_config_option, set_config_option};

/// GDAL's names for files that are fetched over a network.
const NETWORKS: [&str; 9] =
    ["/vsicurl/", "/vsicurl?", "/vsis3/", "/vsigs/", "/vsiaz/", "/vsiadls/", "/vsioss/", "/vsiswift/", "/vsiwebhdfs/"];

/// What GDAL is told of networks. By itself it gives up at the first answer that fails, and waits without end for one that does not
/// come.
const PATIENCE: [(&str, &str); 5] = [
    // Servers that are busy, and lost connections: asked again after 1, 2, 4 … seconds, somewhat more each time.
    ("GDAL_HTTP_MAX_RETRY", "5"),
    ("GDAL_HTTP_RETRY_DELAY", "1"),
    ("GDAL_HTTP_CONNECTTIMEOUT", "30"),
    // A minute with less than a byte each second.
    ("GDAL_HTTP_LOW_SPEED_TIME", "60"),
    ("GDAL_HTTP_LOW_SPEED_LIMIT", "1"),
];

/// Whether a name of GDAL's is one of a file on another machine, also within an archive. The `_streaming` kinds cannot be read
/// twice at all, and are not among them.
pub(super) fn is_remote(path: &Path) -> bool {
    let name = path.to_string_lossy();
    // A folder may be called so, too: names begin the path, or stand in quotes, braces or another name.
    let begins = |at: usize| name[..at].chars().next_back().is_none_or(|before| "/\":{,".contains(before));
    NETWORKS.iter().any(|network| name.match_indices(network).any(|(at, _)| begins(at)))
}

/// Prepares GDAL for a file on another machine, where the user has not said otherwise by the variables of the same names.
pub(super) fn be_patient(path: &Path) {
    if !is_remote(path) {
        return;
    }
    for (name, value) in PATIENCE {
        if !is_said(name) {
            // Not worth failing for: what is not retried is told.
            let _ = set_config_option(name, value);
        }
    }
}

fn is_said(name: &str) -> bool {
    get_config_option(name, "").is_ok_and(|said| !said.is_empty())
}

/// Names of files that GDAL forgets what it has fetched of, when they are closed.
const FORGOTTEN: &str = "CPL_VSIL_CURL_NON_CACHED";

/// What `look` finds when it opens, reads and closes files on other machines after they have been read before: what is there now,
/// and not what GDAL has kept of them. It is called twice, and closing forgets what the first call found.
///
/// # Errors
/// What `look` says.
pub(super) fn afresh<T, E>(look: impl Fn() -> Result<T, E>) -> Result<T, E> {
    let is_ours = !is_said(FORGOTTEN) && set_config_option(FORGOTTEN, &NETWORKS.join(":")).is_ok();
    let found = look().and_then(|_| look());
    if is_ours {
        let _ = clear_config_option(FORGOTTEN);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_on_other_machines() {
        for name in ["/vsicurl/https://a/b.tif", "/vsizip//vsis3/bucket/a.zip/b.tif", "NETCDF:\"/vsigs/b/c.nc\":z"] {
            assert!(is_remote(Path::new(name)), "{name}");
        }
        for name in ["dem.tif", "/vsizip/a.zip/b.tif", "/data/vsicurl/dem.tif", "/vsimem/dem.tif"] {
            assert!(!is_remote(Path::new(name)), "{name}");
        }
    }
}
