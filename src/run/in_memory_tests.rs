//! Meshes in arrays: the same as in files, written and judged from there.

use std::path::Path;
use std::sync::atomic::Ordering;

use super::{
    ConvertRequest, HeightSource, InMemory, LineInput, LineTypes, Lines, PointInput, Request, RunError, VerifyRequest,
    convert_mesh, simplify, simplify_in_memory, verify_mesh,
};
use crate::base::control::{CancelToken, Control, Progress, Stage};
use crate::base::{Band, LineKind, LineType, PointCounts, Polylines};
use crate::formats::{ArrayReader, SinkOptions};
use crate::job::Params;

fn bowl() -> Band {
    let height = |i: usize| ((i % 40) as f32 - 20.0).powi(2) / 10.0 + ((i / 40) as f32 - 15.0).powi(2) / 7.0;
    Band::of_singles("bowl", (40, 30), (0..1200).map(height).collect()).expect("a band")
}

fn made(request: &Request<'_>) -> InMemory {
    simplify_in_memory(request, &Control::default()).expect("a mesh")
}

fn reader(mesh: &InMemory) -> ArrayReader<'_> {
    let arrays = (mesh.arrays.vertices.as_slice(), mesh.arrays.triangles.as_slice());
    let mesh_in_it = ArrayReader::new("arrays", mesh.header.clone(), arrays, Vec::new(), CancelToken::default());
    mesh_in_it.and_then(|found| found.with_edges(&mesh.arrays.edges, &mesh.arrays.soft_edges)).expect("a mesh")
}

fn request(output: &Path) -> Request<'static> {
    Request::new(bowl(), output, 0.5)
}

#[test]
fn the_same_bytes_as_a_file_and_the_same_verdict() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, copy) = (folder.path().join("file.ply"), folder.path().join("copy.ply"));
    let report = simplify(&request(&file), &Control::default()).expect("a file");
    let mesh = made(&request(&file));
    assert_eq!(
        (mesh.report.triangles, mesh.report.format, mesh.report.output.as_str()),
        (report.triangles, "arrays", "")
    );
    assert_eq!(mesh.arrays.triangles.len() as u64, 3 * report.triangles);
    let written = convert_mesh(&mut reader(&mesh), &ConvertRequest::new("arrays", &copy), &Control::default());
    assert_eq!(written.expect("a file").max_error, Some(0.5));
    assert_eq!(std::fs::read(&copy).expect("bytes"), std::fs::read(&file).expect("bytes"));
    let judged = |max_error| {
        let request = VerifyRequest::new(bowl(), "arrays", max_error);
        verify_mesh(&mut reader(&mesh), &request, &Control::default()).expect("a verdict").passed
    };
    assert!(judged(0.5) && !judged(0.01));
}

#[test]
fn edges_that_follow_breaklines_go_with_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, copy) = (folder.path().join("file.ply"), folder.path().join("copy.ply"));
    // The last line goes on from the first, and shares a stretch with it.
    let [bend, end] = [(33.2, -20.7), (36.0, -3.0)];
    let lines = Polylines::new(vec![
        vec![(2.3, -4.1), bend, end],
        vec![(6.0, -22.0), (12.0, -20.0)],
        vec![bend, end, (38.0, -2.0)],
    ]);
    let (kind, heights) = (LineKind::Breaklines, HeightSource::Raster);
    let types = LineTypes::Each(vec![LineType::Hard, LineType::Soft, LineType::Soft]);
    let lines = vec![LineInput { kind, from: Lines::Places(lines), shift: 0.5, heights, types }];
    let request = Request { lines, ..request(&file) };
    let chains = simplify(&request, &Control::default()).expect("a file").breaklines.expect("lines").chains;
    let mesh = made(&request);
    let soft = |(edge, is_soft): (&[u32], &bool)| {
        let middle =
            |axis: usize| edge.iter().map(|&end| mesh.arrays.vertices[3 * end as usize + axis]).sum::<f64>() / 2.0;
        assert_eq!(*is_soft, middle(0) > 36.0 || middle(0) < 13.0 && middle(1) < -15.0);
    };
    mesh.arrays.edges.chunks(2).zip(&mesh.arrays.soft_edges).for_each(soft);
    assert!(mesh.arrays.soft_edges.iter().filter(|is_soft| **is_soft).count() > 1);
    assert!(chains.edges > 2 && mesh.arrays.edges.len() as u64 == 2 * chains.edges, "{chains:?}");
    let written = convert_mesh(&mut reader(&mesh), &ConvertRequest::new("arrays", &copy), &Control::default());
    assert_eq!(written.expect("a file").edges, chains.edges);
    assert_eq!(std::fs::read(&copy).expect("bytes"), std::fs::read(&file).expect("bytes"));
}

#[test]
fn options_of_formats_are_for_files() {
    let sink = SinkOptions { ascii: true, ..SinkOptions::default() };
    let refused = simplify_in_memory(&Request { sink, ..request(Path::new("")) }, &Control::default());
    assert!(matches!(refused, Err(RunError::FormatOption { .. })));
}

#[test]
fn places_become_the_samples_nearest_to_them() {
    let places = [(7.5, -3.5), (7.6, -3.6), (30.4, -20.5), (99.0, 0.0)];
    let points = Some(PointInput::Places(places.as_slice().into()));
    let mesh = made(&Request { points, ..request(Path::new("")) });
    let counts = mesh.report.points.expect("points").counts;
    assert_eq!(counts, PointCounts { read: 4, used: 2, merged: 1, outside: 1 });
    let (vertices, _) = mesh.arrays.vertices.as_chunks::<3>();
    for place in [[7.5, -3.5], [30.5, -20.5]] {
        assert!(vertices.iter().any(|[x, y, _]| [*x, *y] == place), "{place:?}");
    }
}

/// Stops a run once three tiles of it are there.
struct Third(CancelToken, std::sync::atomic::AtomicU64);

impl Progress for Third {
    fn begin(&self, _: Stage, _: u64, _: u64) {}

    fn end(&self, _: Stage) {}

    fn step(&self, stage: Stage, _: u64) {
        if stage == Stage::Triangulate && self.1.fetch_add(1, Ordering::Relaxed) == 2 {
            self.0.cancel();
        }
    }
}

#[test]
fn a_work_dir_keeps_tiles_until_the_arrays_are_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().join("work");
    let mut asked = Request { work_dir: Some(dir.clone()), ..request(Path::new("")) };
    asked.params.tile = 8;
    let cancel = CancelToken::default();
    let third = Third(cancel.clone(), Default::default());
    let stopped = simplify_in_memory(&asked, &Control { cancel, progress: &third });
    assert!(matches!(stopped, Err(RunError::Kept { .. })) && dir.is_dir());
    let other = Request { params: Params { tile: 9, ..asked.params.clone() }, ..asked.clone() };
    assert!(simplify_in_memory(&other, &Control::default()).is_err(), "tiles of another job");
    let continued = made(&asked);
    assert!(continued.report.tiles_found.is_some_and(|tiles| tiles >= 3), "{:?}", continued.report.tiles_found);
    assert!(!dir.exists(), "it is of no more use");
    let whole = made(&Request { work_dir: None, ..asked });
    assert_eq!(continued.arrays.triangles, whole.arrays.triangles);
    assert_eq!(continued.arrays.vertices, whole.arrays.vertices);
}
