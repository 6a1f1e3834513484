//! Writing and reading a mesh in every format: what `convert` and `verify` do, less all that is not the format.
//!
//! Files lie in the system's temporary folder: `TMPDIR=/dev/shm cargo bench --bench formats` leaves the disk out. Bytes are
//! those of the file; for reading, `open` is what it takes until the mesh is known (text is read once to be counted, corners
//! of STL are joined), `passes` one pass over vertices and one over faces.

mod terrain;

use std::path::Path;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use terrabite::base::staged::StagedFile;
use terrabite::formats::{
    Base, Bounds, Compression, Contents, FORMATS, Format, MeshReader, ReadError, ReadOptions, Setup, SinkOption,
    SinkOptions,
};

use terrain::fractal;

/// Vertices along a side. OGR takes a hundred times as long as the others.
const SIDE: usize = 1001;
const SIDE_OF_OGR: usize = 101;

/// Vertices or triangles that are handed over at a time, as `convert` does.
const BATCH: usize = 1 << 16;

/// A mesh in memory.
struct Mesh {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u64; 3]>,
    corners: Vec<[[f64; 3]; 3]>,
}

impl Mesh {
    /// Of all samples: coordinates of UTM half a metre apart, heights in single precision, so that no format joins vertices.
    fn new(side: usize) -> Mesh {
        let vertex = |i: usize| {
            let (column, row) = (i % side, i / side);
            let height = fractal(column, row) as f32;
            [562_000.25 + column as f64 / 2.0, 5_118_000.5 - row as f64 / 2.0, f64::from(height)]
        };
        let vertices: Vec<_> = (0..side * side).map(vertex).collect();
        let cell = |i: usize| {
            let a = ((i / (side - 1)) * side + i % (side - 1)) as u64;
            let (b, c, d) = (a + 1, a + side as u64, a + side as u64 + 1);
            [[a, c, b], [b, c, d]]
        };
        let triangles: Vec<_> = (0..(side - 1) * (side - 1)).flat_map(cell).collect();
        let corners = triangles.iter().map(|t: &[u64; 3]| t.map(|v| vertices[v as usize])).collect();
        Mesh { vertices, triangles, corners }
    }

    fn write(&self, format: &Format, options: SinkOptions, path: &Path) {
        let staged = StagedFile::create(path, true, &[]).expect("a staged file");
        let setup = Setup { options, as_is: true, loss: f64::INFINITY, ..Setup::default() };
        let mut sink = (format.sink)(staged, setup).expect("a sink");
        let needs = sink.needs();
        let bounds = self.vertices.iter().fold(Bounds::EMPTY, |bounds, vertex| bounds.with(*vertex));
        let (vertices, triangles) = (self.vertices.len() as u64, self.triangles.len() as u64);
        let contents = Contents { vertices, triangles, bounds: needs.bounds.then_some(bounds), ..Contents::default() };
        sink.begin(&contents).expect("begun");
        self.vertices.chunks(BATCH).for_each(|vertices| sink.vertices(vertices, &[]).expect("vertices"));
        for (triangles, corners) in self.triangles.chunks(BATCH).zip(self.corners.chunks(BATCH)) {
            let corners = if needs.corners { corners } else { &[] };
            sink.triangles(triangles, corners).expect("triangles");
        }
        sink.finish().expect("finished");
    }
}

fn open(format: &Format, path: &Path) -> Box<dyn MeshReader> {
    (format.reader)(path, &ReadOptions::default()).expect("a mesh")
}

/// One pass over vertices, one over faces; returns how many there were.
fn passes(mesh: &mut dyn MeshReader) -> (u64, u64) {
    let (mut vertices, mut faces, mut sum) = (0, 0, 0.0);
    mesh.for_each_vertex(|_, [x, y, z]| {
        vertices += 1;
        sum += x + y + z;
        Ok::<(), ReadError>(())
    })
    .expect("vertices");
    let mut corners = 0;
    mesh.for_each_face(|_, [a, b, c]| {
        faces += 1;
        corners += a + b + c;
        Ok::<(), ReadError>(())
    })
    .expect("faces");
    std::hint::black_box((sum, corners));
    (vertices, faces)
}

/// The ways in which a format is written: plain, and with each option that makes another file of it.
fn ways(format: &Format) -> Vec<(String, SinkOptions)> {
    let plain = SinkOptions::default();
    let mut ways = vec![(format.name.to_string(), plain)];
    let further = [
        (SinkOption::Ascii, "ascii", SinkOptions { ascii: true, ..plain }),
        (SinkOption::Base, "solid", SinkOptions { base: Some(Base::Depth(10.0)), ..plain }),
        (SinkOption::Compression, "meshopt", SinkOptions { compression: Some(Compression::Meshopt), ..plain }),
    ];
    let further = further.into_iter().filter(|(option, ..)| format.options.contains(option));
    ways.extend(further.map(|(_, name, options)| (format!("{}_{name}", format.name), options)));
    ways
}

fn formats(c: &mut Criterion) {
    let (large, small) = (Mesh::new(SIDE), Mesh::new(SIDE_OF_OGR));
    let folder = tempfile::tempdir().expect("a folder");
    for format in FORMATS {
        let mesh = if format.name == "ogr" { &small } else { &large };
        for (name, options) in ways(format) {
            let path = folder.path().join(format!("{name}.{}", format.extensions[0]));
            mesh.write(format, options, &path);
            let bytes = path.metadata().expect("a file").len();
            eprintln!("{name}: {} triangles, {bytes} bytes", mesh.triangles.len());
            let mut group = c.benchmark_group(&name);
            group.throughput(Throughput::Bytes(bytes));
            group.bench_function("write", |b| b.iter(|| mesh.write(format, options, &path)));
            group.bench_function("open", |b| b.iter(|| open(format, &path)));
            let mut reader = open(format, &path);
            let counts = (mesh.vertices.len() as u64, mesh.triangles.len() as u64);
            assert_eq!(passes(reader.as_mut()), counts, "vertices and triangles of {name}");
            group.bench_function("passes", |b| b.iter(|| passes(reader.as_mut())));
            group.finish();
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(1500));
    targets = formats
}
criterion_main!(benches);
