//! Files beside a raster or a layer that GDAL reads together with it: masks, statistics and tags, world files, headers, and
//! the sources of a VRT.
//!
//! In comes the name a dataset is opened by; out go the paths whose files decide what it holds, those among them that are
//! not there: a mask that comes up changes the raster. GDAL's own list (`GDALGetFileList`) is not in the bindings, and has
//! only what is there.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Endings that GDAL puts behind the whole name of a raster of any format.
const OF_ANY_RASTER: &[&str] = &["msk", "aux.xml", "ovr"];

/// Endings in place of a raster's own, of any format.
const IN_PLACE: &[&str] = &["aux.xml", "aux", "wld", "prj", "tab"];

/// The same, of formats in several files. A TIFF is one.
const PARTS: &[&str] = &[
    "hdr", "clr", "ige", "rrd", "rdc", "ref", "gri", "grd", "sgrd", "sdat", "mgrd", "mpr", "mp#", "grf", "csy", "flt",
    "bil", "img", "cub", "lbl", "idx", "ppg", "pjg", "lrc", "lerc",
];

/// Endings of a layer's parts.
const OF_A_LAYER: &[&str] = &["shx", "dbf", "prj", "cpg", "csvt", "dat", "map", "id", "mid"];

/// Files of VRTs and folders that are looked at, at the most: a mosaic of more is told by its samples.
const MOST: usize = 4096;

/// Characters of a VRT that are looked at.
const LONGEST_VRT: u64 = 64 << 20;

/// The paths that a dataset may be read from, the one it is opened by first.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Companions {
    /// Each once.
    pub(super) paths: Vec<PathBuf>,
    known: HashSet<PathBuf>,
}

impl Companions {
    /// Of a raster.
    pub(super) fn of_raster(name: &Path) -> Companions {
        let mut all = Companions::default();
        let mains = all.add_named(name);
        for main in &mains {
            OF_ANY_RASTER.iter().for_each(|ending| all.add(behind(main, ending)));
            let ending = extension(main);
            let is_tiff = ["tif", "tiff"].iter().any(|tiff| ending.eq_ignore_ascii_case(tiff));
            let parts = if is_tiff { &[] } else { PARTS };
            let world = world_files(&ending);
            let others = world.iter().map(String::as_str).chain(IN_PLACE.iter().chain(parts).copied());
            others.for_each(|other| {
                all.add(main.with_extension(other));
                // Names on discs of old systems.
                if ending.chars().any(char::is_uppercase) {
                    all.add(main.with_extension(other.to_uppercase()));
                }
            });
            // ERS: the samples are in the file of the same name without an ending.
            if ending.eq_ignore_ascii_case("ers") {
                all.add(main.with_extension(""));
            }
        }
        all.add_sources(name, &mains);
        all
    }

    /// Of a layer of points or polygons.
    pub(super) fn of_layer(name: &Path) -> Companions {
        let mut all = Companions::default();
        for main in all.add_named(name) {
            OF_A_LAYER.iter().for_each(|ending| all.add(main.with_extension(ending)));
        }
        all
    }

    fn add(&mut self, path: PathBuf) {
        if self.paths.len() < MOST && self.known.insert(path.clone()) {
            self.paths.push(path);
        }
    }

    /// Adds the plain files that a name leads to, and returns them: itself, what is in a folder, an archive in
    /// `/vsizip/a.zip/dem.tif`, the file in `NETCDF:"dem.nc":height`.
    fn add_named(&mut self, name: &Path) -> Vec<PathBuf> {
        let found = if name.is_file() {
            vec![name.to_path_buf()]
        } else if name.is_dir() {
            within(name)
        } else {
            let text = name.to_string_lossy();
            text.split([':', '"', '{', '}', ',']).filter_map(file_in).collect()
        };
        found.iter().for_each(|path| self.add(path.clone()));
        if name.is_dir() { Vec::new() } else { found }
    }

    /// Adds the sources of a VRT, and theirs. The name may be the VRT itself.
    fn add_sources(&mut self, name: &Path, mains: &[PathBuf]) {
        let here = PathBuf::from(".");
        let mut waiting: Vec<PathBuf> = mains.to_vec();
        if let Some(text) = name.to_str().filter(|text| text.trim_start().starts_with(VRT)) {
            waiting.extend(self.add_all(sources(text), &here));
        }
        while let Some(vrt) = waiting.pop() {
            let Some(text) = vrt_text(&vrt) else { continue };
            let folder = vrt.parent().unwrap_or(&here).to_path_buf();
            waiting.extend(self.add_all(sources(&text), &folder));
        }
    }

    /// Adds sources, and returns the files that were not known.
    fn add_all(&mut self, sources: Vec<Source>, folder: &Path) -> Vec<PathBuf> {
        let mut new = Vec::new();
        for Source { name, relative } in sources {
            let name = if relative { folder.join(&name) } else { PathBuf::from(name) };
            let known = self.paths.len();
            for main in self.add_named(&name) {
                OF_ANY_RASTER.iter().for_each(|ending| self.add(behind(&main, ending)));
                if self.paths[known..].contains(&main) {
                    new.push(main);
                }
            }
            // A source that is not there is missing samples, until it comes up.
            if !name.exists() && !name.to_string_lossy().contains([':', ',']) {
                self.add(name);
            }
        }
        new
    }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default()
}

/// `dem.tif`, `msk` → `dem.tif.msk`.
fn behind(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}

/// Of `tif`: `tfw` and `tifw`.
fn world_files(extension: &str) -> Vec<String> {
    let mut letters = extension.chars();
    match (letters.next(), letters.next_back()) {
        (Some(first), Some(last)) => vec![format!("{first}{last}w"), format!("{extension}w")],
        _ => Vec::new(),
    }
}

/// The plain file that a part of a name leads to, without GDAL's prefixes: perhaps an archive that the rest is in.
fn file_in(part: &str) -> Option<PathBuf> {
    let mut rest = part;
    while let Some(inner) = rest.strip_prefix("/vsi") {
        rest = inner.split_once('/').map_or("", |(_, path)| path);
    }
    if rest.is_empty() {
        return None;
    }
    // "/vsizip/a.zip/b" is the file a.zip here, "/vsizip//data/a.zip/b" is /data/a.zip.
    Path::new(rest).ancestors().find(|path| path.is_file()).map(Path::to_path_buf)
}

/// The files of a folder and of those in it, in the order of their names.
fn within(folder: &Path) -> Vec<PathBuf> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for path in folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() && !path.is_symlink() { folders.push(path) } else { files.push(path) }
        }
        if files.len() > MOST {
            break;
        }
    }
    files.sort();
    files
}

const VRT: &str = "<VRTDataset";

/// The text of a VRT; `None` of another file.
fn vrt_text(path: &Path) -> Option<String> {
    use std::io::Read;
    let mut file = std::fs::File::open(path).ok()?;
    let mut start = vec![0; 256];
    let count = file.read(&mut start).ok()?;
    start.truncate(count);
    if !String::from_utf8_lossy(&start).contains(VRT) {
        return None;
    }
    file.take(LONGEST_VRT).read_to_end(&mut start).ok()?;
    Some(String::from_utf8_lossy(&start).into_owned())
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Source {
    name: String,
    /// Whether the name is one from the VRT's folder on.
    relative: bool,
}

/// What a VRT reads: the texts of its elements `SourceFilename` and `SourceDataset`.
fn sources(vrt: &str) -> Vec<Source> {
    let elements = ["<SourceFilename", "<SourceDataset"];
    let mut found = Vec::new();
    for element in elements.iter().flat_map(|name| vrt.split(name).skip(1)) {
        let Some((attributes, text)) = element.split_once('>') else { continue };
        let attributes = attributes.to_ascii_lowercase().replace(['\'', '"', ' ', '\t', '\n', '\r'], "");
        let relative = attributes.contains("relativetovrt=1");
        let name = unescaped(text.split('<').next().unwrap_or_default().trim());
        if !name.is_empty() && !attributes.ends_with('/') {
            found.push(Source { name, relative });
        }
    }
    found
}

fn unescaped(text: &str) -> String {
    let entities = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    entities.iter().fold(text.to_string(), |text, (entity, sign)| text.replace(entity, sign))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(all: &Companions, folder: &Path) -> Vec<String> {
        all.paths.iter().map(|p| p.strip_prefix(folder).unwrap_or(p).display().to_string()).collect()
    }

    #[test]
    fn masks_tags_and_world_files_of_a_raster() {
        let folder = tempfile::tempdir().unwrap();
        let dem = folder.path().join("dem.tif");
        std::fs::write(&dem, "").unwrap();
        let found = names(&Companions::of_raster(&dem), folder.path());
        assert_eq!(found[0], "dem.tif");
        for name in ["dem.tif.msk", "dem.tif.aux.xml", "dem.tif.ovr", "dem.tfw", "dem.tifw", "dem.wld", "dem.prj"] {
            assert!(found.contains(&name.to_string()), "{name}: {found:?}");
        }
        // Outputs beside it are none of its files.
        assert!(!["dem.ply", "dem.png", "dem.img"].iter().any(|name| found.contains(&name.to_string())));
        let old = folder.path().join("DEM.BIL");
        std::fs::write(&old, "").unwrap();
        assert!(names(&Companions::of_raster(&old), folder.path()).contains(&"DEM.HDR".to_string()));
    }

    #[test]
    fn files_inside_names_of_gdal() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("dems.zip");
        std::fs::write(&file, "").unwrap();
        let file = file.display();
        for name in [
            format!("/vsizip/{file}/inside/dem.asc"),
            format!("/vsizip/{{{file}}}/dem.asc"),
            format!("NETCDF:\"{file}\":height"),
            format!("GTIFF_DIR:2:{file}"),
            format!("/vsisubfile/10_20,{file}"),
        ] {
            let found = Companions::of_raster(Path::new(&name));
            assert_eq!(found.paths.first(), Some(&PathBuf::from(file.to_string())), "{name}");
        }
        assert!(Companions::of_raster(Path::new("/vsicurl/https://example.org/dem.tif")).paths.is_empty());
        assert!(Companions::of_raster(Path::new("none.tif")).paths.is_empty());
    }

    #[test]
    fn sources_of_a_vrt_and_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        std::fs::create_dir(folder.path().join("in")).unwrap();
        write("a.tif", "II*");
        write("in/b & c.tif", "II*");
        write(
            "in/inner.vrt",
            "<VRTDataset><SourceDataset relativeToVRT='1'>b &amp; c.tif</SourceDataset></VRTDataset>",
        );
        let absolute = folder.path().join("a.tif").display().to_string();
        write(
            "all.vrt",
            &format!(
                "<?xml version='1.0'?><VRTDataset><SourceFilename relativeToVRT=\"0\">{absolute}</SourceFilename>\
                 <SourceFilename relativetoVRT = \"1\" shared=\"0\">in/inner.vrt</SourceFilename>\
                 <SourceFilename relativeToVRT=\"1\">none.tif</SourceFilename>\
                 <SourceFilename relativeToVRT=\"1\">all.vrt</SourceFilename></VRTDataset>"
            ),
        );
        let found = names(&Companions::of_raster(&folder.path().join("all.vrt")), folder.path());
        for name in ["a.tif", "a.tif.msk", "in/inner.vrt", "in/b & c.tif", "in/b & c.tif.aux.xml", "none.tif"] {
            assert!(found.contains(&name.to_string()), "{name}: {found:?}");
        }
    }

    #[test]
    fn parts_of_a_layer() {
        let folder = tempfile::tempdir().unwrap();
        let shp = folder.path().join("coast.shp");
        std::fs::write(&shp, "").unwrap();
        let found = names(&Companions::of_layer(&shp), folder.path());
        assert_eq!(found[..3], ["coast.shp", "coast.shx", "coast.dbf"]);
    }
}
