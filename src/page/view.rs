//! The view of a mesh in three dimensions: the mesh as GLB, what the program that draws it is told, and its controls.

use std::path::Path;

use serde::Serialize;

use super::html;
use super::image::add_base64;
use super::{PageError, maps};
use crate::base::staged::StagedFile;
use crate::base::{GeoTransform, Reference};
use crate::formats::{Compression, Contents, Crs, Header, Setup, Sink, SinkOptions, glb::GlbSink};
use crate::run::report::grouped;
use crate::run::scene::Scene;
use crate::run::survey::Survey;

/// Draws the mesh: three.js and `viewer/src`, bundled.
pub(super) const SCRIPT: &str = include_str!("../../viewer/dist/view.js");

/// The most bytes of a mesh in a page that is mailed. As text they are a third more; with the program, and maps that are all noise,
/// a page then has less than 3 MB.
const MAILED: usize = 1_100_000;

/// Triangles that a file is given at a time.
const SOME: usize = 4096;

/// What is drawn, and what its numbers mean.
pub(super) struct Drawn<'d> {
    pub(super) scene: &'d Scene,
    pub(super) reference: &'d Reference,
    /// The unit of heights behind a number, as text.
    pub(super) unit: &'d str,
    /// Maps on the page that can be laid over the mesh.
    pub(super) survey: Option<&'d Survey>,
    /// Whether the page is to be small.
    pub(super) is_mailed: bool,
    /// Where temporary files are.
    pub(super) temp_dir: Option<&'d Path>,
}

/// What the program is told.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Settings {
    drapes: Vec<Drape>,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<Samples>,
    /// Digits after the point of x and y, and of heights.
    digits: usize,
    height_digits: usize,
    unit: String,
    /// Triangles shown, and those of the mesh.
    triangles: usize,
    of: u64,
    is_copy: bool,
}

/// An image of the page that can be laid over the mesh.
#[derive(Serialize)]
struct Drape {
    name: &'static str,
    image: String,
}

/// Column and row of a place on the map, c + a x + b y each, and how many samples such an image has across and down.
#[derive(Serialize)]
struct Samples {
    columns: [f64; 3],
    rows: [f64; 3],
    size: [usize; 2],
}

/// What of a mesh can be drawn.
pub(super) fn drawable(scene: Option<&Scene>) -> Option<&Scene> {
    scene.filter(|scene| !scene.triangles.is_empty())
}

/// Adds the chapter to a page.
pub(super) fn add_view(page: &mut String, drawn: &Drawn<'_>) -> Result<(), PageError> {
    html::long_section(page, "The mesh in three dimensions", |page| add_body(page, drawn))
}

fn add_body(page: &mut String, drawn: &Drawn<'_>) -> Result<(), PageError> {
    let (smaller, bytes) = fitting(drawn)?;
    let scene = smaller.as_ref().unwrap_or(drawn.scene);
    let count = grouped(scene.triangles.len() as u64);
    let left_out = match scene.left_out {
        0 => String::new(),
        count => format!(" {} triangles with a corner that is nowhere are left out.", grouped(count)),
    };
    let caption = if scene.is_copy {
        format!(
            "<p class=\"warn\"><b>Not certified:</b> this is a copy for looking, of {count} triangles in place of the mesh's {}. No \
             tolerance holds for it.{left_out}</p>\n",
            grouped(scene.of)
        )
    } else {
        let all = if scene.left_out == 0 { "All " } else { "" };
        format!("<p>{all}{count} triangles of the mesh.{left_out}</p>\n")
    };
    let [left, bottom, right, top] = scene.extent();
    let is_wide = (right - left).max(top - bottom) > 1e5;
    let survey = drawn.survey;
    let settings = Settings {
        drapes: survey.iter().flat_map(|_| maps::TITLES).map(|name| Drape { name, image: maps::id(name) }).collect(),
        samples: survey.map(|survey| {
            let across = |count: usize| count * survey.map.side;
            samples(survey.raster.geo_transform, [across(survey.map.size.0), across(survey.map.size.1)])
        }),
        digits: match drawn.reference.geographic {
            true => 6,
            false if is_wide => 1,
            false => 2,
        },
        height_digits: 2,
        unit: drawn.unit.to_string(),
        triangles: scene.triangles.len(),
        of: scene.of,
        is_copy: scene.is_copy,
    };
    let settings = serde_json::to_string(&settings).expect("plain data");
    page.push_str(&caption);
    page.push_str(include_str!("view.html"));
    page.push_str(&html::embedded_json("view-settings", &settings));
    page.push_str("<script type=\"application/octet-stream\" id=\"view-mesh\">");
    add_base64(page, &bytes);
    page.push_str("</script>\n");
    Ok(())
}

/// The GLB, and the scene that is in it where it had to be made smaller.
fn fitting(drawn: &Drawn<'_>) -> Result<(Option<Scene>, Vec<u8>), PageError> {
    let mut smaller = None;
    loop {
        let scene = smaller.as_ref().unwrap_or(drawn.scene);
        let bytes = glb(drawn, scene)?;
        if !drawn.is_mailed || bytes.len() <= MAILED {
            return Ok((smaller, bytes));
        }
        // A tenth less than what would fit, so that once is enough most often.
        let most = (scene.triangles.len() as f64 * MAILED as f64 / bytes.len() as f64 * 0.9) as usize;
        smaller = Some(scene.fewer(most));
    }
}

/// The mesh as a compressed GLB.
fn glb(drawn: &Drawn<'_>, scene: &Scene) -> Result<Vec<u8>, PageError> {
    let reference = drawn.reference;
    let dir = match drawn.temp_dir {
        Some(dir) => tempfile::tempdir_in(dir),
        None => tempfile::tempdir(),
    };
    let dir = dir.map_err(PageError::Temporary)?;
    let path = dir.path().join("view.glb");
    let header = Header {
        made_by: Some(format!("terrabite {}", env!("CARGO_PKG_VERSION"))),
        crs: Crs { name: Some(reference.crs.clone()), ..Crs::default() },
        frame: scene.frame(reference.metres, &reference.height_unit),
        notes: scene.is_copy.then(|| "a copy for looking, not certified".to_string()).into_iter().collect(),
        ..Header::default()
    };
    let setup = Setup {
        header,
        loss: f64::INFINITY,
        options: SinkOptions { compression: Some(Compression::QuickMeshopt), ..SinkOptions::default() },
        temp_dir: drawn.temp_dir.map(Path::to_path_buf),
        ..Setup::default()
    };
    let mut sink = Box::new(GlbSink::new(StagedFile::create(&path, false, &[])?, setup));
    let (vertex_count, triangle_count) = (scene.vertices.len() as u64, scene.triangles.len() as u64);
    sink.begin(&Contents { vertices: vertex_count, triangles: triangle_count, ..Contents::default() })?;
    sink.vertices(&scene.vertices, &[])?;
    let mut some = Vec::with_capacity(SOME);
    for triangles in scene.triangles.chunks(SOME) {
        some.clear();
        some.extend(triangles.iter().map(|triangle| triangle.map(u64::from)));
        sink.triangles(&some, &[])?;
    }
    sink.finish()?;
    std::fs::read(&path).map_err(PageError::Temporary)
}

fn samples(map: GeoTransform, size: [usize; 2]) -> Samples {
    // It is affine: three places say it all.
    let at = |x, y| map.sample_coordinates(x, y);
    let (origin, east, north) = (at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0));
    Samples {
        columns: [origin.0, east.0 - origin.0, north.0 - origin.0],
        rows: [origin.1, east.1 - origin.1, north.1 - origin.1],
        size,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::page::hash::fingerprint;

    /// Whoever changes `viewer/src` or its packages has to bundle anew; `make test-browser` does so, and compares.
    #[test]
    fn the_bundle_is_that_of_its_sources() {
        let viewer = Path::new(env!("CARGO_MANIFEST_DIR")).join("viewer");
        let sums = std::fs::read_to_string(viewer.join("dist/sums.txt")).unwrap();
        let mut named = Vec::new();
        for line in sums.lines() {
            let (sum, name) = line.split_once("  ").unwrap();
            let found = fingerprint(&viewer.join(name)).unwrap_or_else(|| panic!("viewer/{name} is missing"));
            assert_eq!(found.1, sum, "viewer/{name} is another than when the bundle was made: make viewer");
            named.push(name.to_string());
        }
        let sources = viewer.join("src").read_dir().unwrap();
        let sources = sources.map(|file| format!("src/{}", file.unwrap().file_name().to_string_lossy()));
        let rest = ["build.mjs", "package-lock.json", "package.json", "dist/view.js"].map(str::to_string);
        let mut wanted: Vec<String> = sources.chain(rest).collect();
        wanted.sort();
        named.sort();
        assert_eq!(named, wanted);
    }

    #[test]
    fn licences_stand_in_the_bundle() {
        for words in
            ["three 0.", "meshoptimizer 1.", "three.js authors", "Arseny Kapoulkine", "The above copyright notice"]
        {
            assert!(super::SCRIPT.contains(words), "{words}");
        }
        assert!(!super::SCRIPT.contains("</script") && !super::SCRIPT.contains("<!--"));
    }
}
