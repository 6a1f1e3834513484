//! What every format of the table must do: the same tests for all.

use std::path::{Path, PathBuf};

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::any_mesh::{Given, given};
use super::*;
use crate::base::channels::{Channel, Number};
use crate::base::control::CancelToken;
use crate::base::staged::StagedFile;
use crate::base::{CoordinateFrame, LineEdge, LineType};
use crate::testing;

/// A mesh as a reader gives it.
#[derive(Debug, Clone, PartialEq)]
struct Read {
    header: Header,
    vertices: Vec<[u64; 3]>,
    triangles: Vec<[u64; 3]>,
    attributes: Vec<(Channel, Vec<u64>)>,
    edges: Vec<LineEdge<u64>>,
    edges_have_types: bool,
}

fn write(format: &Format, path: &Path, given: &Given) -> Result<(), SinkError> {
    let staged = StagedFile::create(path, false, &[])?;
    // That is told with the contents.
    let header = Header { tolerance: None, ..given.header.clone() };
    let mut sink = (format.sink)(staged, setup(header, f64::INFINITY))?;
    feed(sink.as_mut(), given, usize::MAX)?;
    sink.finish()
}

fn setup(header: Header, loss: f64) -> Setup {
    Setup { header, loss, ..Setup::default() }
}

/// Calls a sink, but no more than `calls` times.
fn feed(sink: &mut dyn Sink, given: &Given, calls: usize) -> Result<(), SinkError> {
    let attributes: Vec<Channel> = given.attributes.iter().map(|(channel, _)| channel.clone()).collect();
    let needs = sink.needs();
    let bounds = given.vertices.iter().fold(Bounds::EMPTY, |bounds, vertex| bounds.with(*vertex));
    let (vertices, triangles) = (given.vertices.len() as u64, given.triangles.len() as u64);
    let mut calls = 0..calls;
    if calls.next().is_none() {
        return Ok(());
    }
    sink.begin(&Contents {
        vertices,
        triangles,
        attributes: &attributes,
        has_normals: false,
        tolerance: given.header.tolerance,
        bounds: needs.bounds.then_some(bounds),
        edges: if needs.edges == Marks::None { 0 } else { given.edges.len() as u64 },
        edges_have_types: needs.edges != Marks::None && given.edges_have_types(),
    })?;
    for batch in given.edges.chunks(given.batch).filter(|_| needs.edges == Marks::Places) {
        if calls.next().is_none() {
            return Ok(());
        }
        let ends = batch.iter().map(|edge| edge.map(|v| given.vertices[v as usize]));
        sink.lines(&ends.collect::<Vec<LineEdge<[f64; 3]>>>())?;
    }
    for (first, batch) in (0..).step_by(given.batch).zip(given.vertices.chunks(given.batch)) {
        if calls.next().is_none() {
            return Ok(());
        }
        let values: Vec<&[f64]> = given.attributes.iter().map(|(_, v)| &v[first..first + batch.len()]).collect();
        sink.vertices(batch, &values)?;
    }
    for batch in given.triangles.chunks(given.batch) {
        if calls.next().is_none() {
            return Ok(());
        }
        let corners = batch.iter().map(|t| t.map(|v| given.vertices[v as usize]));
        let corners: Vec<[[f64; 3]; 3]> = corners.filter(|_| needs.corners).collect();
        sink.triangles(batch, &corners)?;
    }
    for batch in given.edges.chunks(given.batch).filter(|_| needs.edges == Marks::Numbers) {
        if calls.next().is_none() {
            return Ok(());
        }
        sink.edges(batch)?;
    }
    Ok(())
}

fn read(path: &Path) -> Result<Read, ReadError> {
    let mut reader = open(path, None, &ReadOptions::default())?;
    let channels = reader.attributes().to_vec();
    let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let mut values = vec![Vec::new(); names.len()];
    // Faces first: passes may come in any order, and again.
    let count = reader.vertex_count();
    reader.for_each_face(|index, face| {
        assert!(index == triangles.len() as u64 && face.iter().all(|v| *v < count));
        triangles.push(face);
        Ok::<(), ReadError>(())
    })?;
    let mut edges = Vec::new();
    reader.for_each_edge(|index, edge| {
        assert!(index == edges.len() as u64 && edge.ends.iter().all(|v| *v < count));
        edges.push(edge);
        Ok::<(), ReadError>(())
    })?;
    assert_eq!(edges.len() as u64, reader.edge_count());
    for _ in 0..2 {
        vertices.clear();
        values.iter_mut().for_each(Vec::clear);
        reader.for_each_vertex_with(&names, |index, vertex, attributes| {
            assert_eq!(index, vertices.len() as u64);
            vertices.push(vertex.map(f64::to_bits));
            values.iter_mut().zip(attributes).for_each(|(all, value)| all.push(value.to_bits()));
            Ok::<(), ReadError>(())
        })?;
    }
    assert_eq!((vertices.len() as u64, triangles.len() as u64), (reader.vertex_count(), reader.face_count()));
    Ok(Read {
        header: reader.header().clone(),
        vertices,
        triangles,
        attributes: channels.into_iter().zip(values).collect(),
        edges,
        edges_have_types: reader.edges_have_types(),
    })
}

/// What of a mesh a format can be given: coordinates and attributes in single precision, if it has no other, and vertices at
/// places of their own, if their places are all that tells them apart.
fn fitted(format: &Format, given: &Given) -> Given {
    let mut given = given.clone();
    given.header.frame.single |= !format.precisions.contains(&Precision::Double);
    for (channel, values) in given.attributes.iter_mut().filter(|_| format.attributes == Attributes::Single) {
        if channel.number == Number::F64 {
            channel.number = Number::F32;
            values.iter_mut().for_each(|value| *value = f64::from(*value as f32));
        }
    }
    if format.vertices == Vertices::OfEachTriangle {
        given.vertices.iter_mut().enumerate().for_each(|(i, vertex)| vertex[0] = 1000.0 * i as f64);
    }
    if format.name == "ogr" {
        // Databases have no -0.
        given.attributes.iter_mut().flat_map(|(_, values)| values).for_each(|value| *value += 0.0);
    }
    given
}

/// A mesh with its vertices numbered as triangles name them first, and without those that none names.
fn renumbered(given: &Given) -> Given {
    let mut new = std::collections::HashMap::new();
    let mut order = Vec::new();
    for &vertex in given.triangles.as_flattened() {
        new.entry(vertex).or_insert_with(|| {
            order.push(vertex as usize);
            order.len() as u64 - 1
        });
    }
    let values = |values: &Vec<f64>| order.iter().map(|&v| values[v]).collect();
    Given {
        vertices: order.iter().map(|&v| given.vertices[v]).collect(),
        triangles: given.triangles.iter().map(|t| t.map(|v| new[&v])).collect(),
        attributes: given.attributes.iter().map(|(channel, all)| (channel.clone(), values(all))).collect(),
        edges: given.edges.iter().map(|e| e.map(|v| new[&v])).collect(),
        ..given.clone()
    }
}

/// How a format marks edges.
fn marks(format: &Format) -> Marks {
    let folder = testing::folder();
    let staged = StagedFile::create(&file(&folder, format), false, &[]).expect("staged");
    (format.sink)(staged, setup(Header::default(), 0.0)).expect("a sink").needs().edges
}

/// What a format promises to give back.
fn promised(format: &Format, given: &Given) -> Read {
    let renumbered = match format.vertices {
        Vertices::Shared => given.clone(),
        Vertices::OfEachTriangle => renumbered(given),
    };
    let given = &renumbered;
    let frame = given.header.frame;
    let place = |[x, y, height]: [f64; 3]| {
        let (x, y) = frame.written_place((x, y));
        [x, y, frame.written_height(height)].map(f64::to_bits)
    };
    let attributes = match format.attributes {
        Attributes::All | Attributes::Single => given.attributes.as_slice(),
        Attributes::None => &[],
    };
    let attribute =
        |(channel, values): &(Channel, Vec<f64>)| (channel.clone(), values.iter().map(|v| v.to_bits()).collect());
    let vertices: Vec<[u64; 3]> = given.vertices.iter().map(|v| place(*v)).collect();
    // By places, the first vertex that stands there.
    let first = |v: u64| vertices.iter().position(|place| *place == vertices[v as usize]).expect("itself") as u64;
    let edges = match marks(format) {
        Marks::None => Vec::new(),
        Marks::Numbers => given.edges.clone(),
        Marks::Places => given.edges.iter().map(|edge| edge.map(first)).collect(),
    };
    Read {
        header: kept(format, &given.header),
        triangles: given.triangles.clone(),
        attributes: attributes.iter().map(attribute).collect(),
        edges_have_types: marks(format) != Marks::None && given.edges_have_types(),
        vertices,
        edges,
    }
}

/// What a format keeps of a header: texts in one line, without blanks at their end.
fn kept(format: &Format, header: &Header) -> Header {
    let line = |text: &String| text.replace(['\n', '\r'], " ").trim_end().to_string();
    let text = |text: &Option<String>| text.as_ref().map(line);
    let has_heights = match format.header {
        HeaderKept::All => true,
        HeaderKept::AllButHeights => false,
        HeaderKept::Frame => return Header { frame: header.frame, ..Header::default() },
    };
    let of_heights = |what: &Option<String>| text(what).filter(|_| has_heights);
    Header {
        made_by: text(&header.made_by),
        source: text(&header.source),
        crs: Crs {
            definition: text(&header.crs.definition),
            name: text(&header.crs.name),
            // Beside the mesh, or nowhere.
            esri_wkt: None,
            unit: None,
            ..Crs::default()
        },
        heights: Heights { crs: of_heights(&header.heights.crs), unit: of_heights(&header.heights.unit) },
        options: header.options.iter().map(|o| RunOption::new(o.name, line(&o.value))).collect(),
        notes: header.notes.iter().map(|note| line(note).trim_start().to_string()).collect(),
        ..header.clone()
    }
}

fn file(folder: &tempfile::TempDir, format: &Format) -> PathBuf {
    folder.path().join(format!("tin.{}", format.extensions[0]))
}

proptest! {
    #![proptest_config(testing::cases(64, 1000))]

    #[test]
    fn what_a_format_keeps_comes_back_bit_for_bit(given in given()) {
        for format in FORMATS {
            let folder = testing::folder();
            let path = file(&folder, format);
            let given = fitted(format, &given);
            write(format, &path, &given).expect("written");
            let found = read(&path).unwrap_or_else(|e| panic!("{}: {e}", format.title));
            prop_assert_eq!(found, promised(format, &given), "{}", format.title);
        }
    }

    #[test]
    fn aborted_writes_leave_nothing(given in given(), calls in any::<Index>()) {
        for format in FORMATS {
            let folder = testing::folder();
            let staged = StagedFile::create(&file(&folder, format), false, &[]).expect("staged");
            let given = fitted(format, &given);
            let mut sink = (format.sink)(staged, setup(given.header.clone(), f64::INFINITY)).expect("a sink");
            let counts = [given.vertices.len(), given.triangles.len(), given.edges.len()];
            let all = 1 + counts.map(|count| count.div_ceil(given.batch)).iter().sum::<usize>();
            feed(sink.as_mut(), &given, calls.index(all + 1)).expect("fed");
            drop(sink);
            prop_assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0, "{}", format.title);
        }
    }

    #[test]
    fn torn_files_are_errors_that_name_the_file(given in given(), cut in any::<Index>()) {
        for format in FORMATS {
            let folder = testing::folder();
            let path = file(&folder, format);
            write(format, &path, &fitted(format, &given)).expect("written");
            let whole = std::fs::read(&path).expect("a file");
            std::fs::write(&path, &whole[..cut.index(whole.len())]).expect("cut");
            let error = match read(&path) {
                Err(error) => error.to_string(),
                Ok(_) => return Err(TestCaseError::fail(format!("{}: a torn file passes", format.title))),
            };
            prop_assert!(error.starts_with(&path.display().to_string()), "{}", error);
        }
    }

    #[test]
    fn damage_is_no_panic(given in given(), damage in vec((any::<Index>(), any::<u8>()), 1..6)) {
        for format in FORMATS {
            let folder = testing::folder();
            let path = file(&folder, format);
            write(format, &path, &fitted(format, &given)).expect("written");
            let mut bytes = std::fs::read(&path).expect("a file");
            for (at, byte) in &damage {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            std::fs::write(&path, bytes).expect("damaged");
            // Any outcome is right, but for indices out of range, which `read` asserts.
            let _ = read(&path);
        }
    }
}

fn triangle() -> Given {
    Given {
        header: Header::default(),
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]],
        triangles: vec![[0, 1, 2]],
        attributes: Vec::new(),
        edges: vec![
            LineEdge { ends: [0, 1], line_type: LineType::Hard },
            LineEdge { ends: [1, 2], line_type: LineType::Soft },
        ],
        batch: 8,
    }
}

#[test]
fn too_much_is_refused_at_the_beginning() {
    for format in FORMATS {
        let Limits { vertices, triangles } = format.limits;
        let contents = |vertices, triangles| Contents { vertices, triangles, ..Contents::default() };
        let too_many =
            [vertices.checked_add(1).map(|v| contents(v, 1)), triangles.checked_add(1).map(|t| contents(3, t))];
        for contents in too_many.into_iter().flatten() {
            let folder = testing::folder();
            let path = file(&folder, format);
            let staged = StagedFile::create(&path, false, &[]).expect("staged");
            let mut sink = (format.sink)(staged, setup(Header::default(), 0.0)).expect("a sink");
            let refused = sink.begin(&contents).expect_err("refused").to_string();
            assert!(refused.starts_with(&path.display().to_string()) && refused.contains(format.title), "{refused}");
        }
    }
}

#[test]
fn heights_that_would_lose_too_much_are_refused() {
    let frame = CoordinateFrame { single: true, ..CoordinateFrame::PLAIN };
    for format in FORMATS.iter().filter(|format| format.precisions.contains(&Precision::Single)) {
        for (height, loss, is_fine) in [(0.1, 0.0, false), (0.1, 1e-8, true), (0.5, 0.0, true), (f64::NAN, 1.0, false)]
        {
            let folder = testing::folder();
            let staged = StagedFile::create(&file(&folder, format), false, &[]).expect("staged");
            let mut sink = (format.sink)(staged, setup(Header { frame, ..Header::default() }, loss)).expect("a sink");
            let given = Given { vertices: vec![[0.0, 0.0, height]; 3], ..triangle() };
            let fed = feed(sink.as_mut(), &given, usize::MAX);
            assert_eq!(fed.is_ok(), is_fine, "{} {height} {loss}: {fed:?}", format.title);
        }
    }
}

#[test]
fn a_cancelled_token_ends_every_pass() {
    for format in FORMATS {
        let folder = testing::folder();
        let path = file(&folder, format);
        write(format, &path, &fitted(format, &triangle())).expect("written");
        let cancel = CancelToken::default();
        let mut reader = open(&path, None, &ReadOptions { cancel: cancel.clone(), temp_dir: None }).expect("opens");
        cancel.cancel();
        let vertices = reader.for_each_vertex(|_, _| Ok::<(), ReadError>(()));
        let faces = reader.for_each_face(|_, _| Ok::<(), ReadError>(()));
        let edges = reader.for_each_edge(|_, _| Ok::<(), ReadError>(()));
        assert_eq!(reader.edge_count() > 0, marks(format) != Marks::None);
        for pass in [vertices, faces].into_iter().chain((reader.edge_count() > 0).then_some(edges)) {
            assert!(matches!(pass, Err(ReadError::Cancelled(_))), "{}: {pass:?}", format.title);
        }
    }
}

#[test]
fn visitors_stop_passes_with_their_own_errors() {
    #[derive(Debug)]
    struct Enough(u64);
    impl From<ReadError> for Enough {
        fn from(error: ReadError) -> Enough {
            panic!("{error}")
        }
    }
    for format in FORMATS {
        let folder = testing::folder();
        let path = file(&folder, format);
        write(format, &path, &fitted(format, &triangle())).expect("written");
        let mut reader = open(&path, None, &ReadOptions::default()).expect("opens");
        let stop = reader.for_each_vertex(|i, _| if i == 1 { Err(Enough(i)) } else { Ok(()) });
        assert!(matches!(stop, Err(Enough(1))), "{}: {stop:?}", format.title);
        let stop = reader.for_each_face(|i, _| Err(Enough(i)));
        assert!(matches!(stop, Err(Enough(0))), "{}: {stop:?}", format.title);
        let lacking = reader.for_each_vertex_with(&["none"], |_, _, _| Ok::<(), ReadError>(()));
        assert!(matches!(lacking, Err(ReadError::NoAttribute { .. })), "{}: {lacking:?}", format.title);
    }
}

#[test]
fn files_are_recognised_by_what_they_are() {
    for format in FORMATS {
        for name in ["tin", "tin.txt", "tin.ply", "tin.obj", "TIN.OBJ"] {
            let folder = testing::folder();
            let path = folder.path().join(name);
            write(format, &path, &fitted(format, &triangle())).expect("written");
            assert_eq!(read(&path).expect("a mesh").triangles, [[0, 1, 2]], "{} as {name}", format.title);
        }
    }
    let folder = testing::folder();
    let path = folder.path().join("notes.txt");
    for text in ["", "no mesh", "\u{1}\u{2}", "plywood\n"] {
        std::fs::write(&path, text).expect("written");
        assert!(matches!(read(&path), Err(ReadError::Unrecognised { .. })), "{text}");
    }
    assert!(matches!(read(&folder.path().join("none.obj")), Err(ReadError::Io { .. })));
}

/// The most that is usual: a mesh in UTM, each vertex on a sample, takes no more and not less than half.
#[test]
fn files_take_what_the_table_says() {
    let side = 300u64;
    let at = |i: u64| [500_000.25 + 30.0 * (i % side) as f64, 5_200_000.5 - 30.0 * (i / side) as f64, 700.1 + i as f64];
    let square = |i: u64| [[i, i + side, i + side + 1], [i, i + side + 1, i + 1]];
    let inner = (0..side * (side - 1)).filter(|i| i % side != side - 1);
    let count = (side * side) as usize;
    let attribute = (Channel { name: "band_1".to_string(), number: Number::F64 }, vec![1.5; count]);
    let given = Given {
        vertices: (0..side * side).map(at).collect(),
        triangles: inner.flat_map(square).collect(),
        attributes: vec![attribute],
        batch: 1000,
        ..triangle()
    };
    for format in FORMATS {
        let folder = testing::folder();
        let path = file(&folder, format);
        write(format, &path, &fitted(format, &given)).expect("written");
        let found = path.metadata().expect("a file").len() as f64;
        let Bytes { vertex, triangle, attribute } = format.bytes;
        let said = count as f64 * (vertex + attribute) + given.triangles.len() as f64 * triangle;
        assert!((said / 2.0..=said + 4096.0).contains(&found), "{}: {found} of {said}", format.title);
    }
}

#[test]
fn rows_are_told_apart() {
    let mut names: Vec<&str> = FORMATS.iter().flat_map(|f| f.extensions.iter().copied().chain([f.title])).collect();
    assert!(FORMATS.iter().all(|f| !f.extensions.is_empty() && !f.precisions.is_empty()));
    assert!(FORMATS.iter().flat_map(|f| f.extensions).all(|e| *e == e.to_ascii_lowercase()));
    assert!(FORMATS.iter().all(|f| by_name(f.name).is_some_and(|found| found.name == f.name)));
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
}

/// `verify` is to judge what was written, so no reader has a line of code from a writer, and the other way round.
#[test]
fn readers_and_writers_know_nothing_of_each_other() {
    let formats = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/formats");
    let folders: Vec<PathBuf> = formats.read_dir().expect("sources").map(|e| e.expect("an entry").path()).collect();
    let mut rows = 0;
    for folder in folders.iter().filter(|path| path.is_dir()) {
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        // No module's name begins with a digit.
        let row = name.strip_prefix("sms_").unwrap_or(&name);
        assert!(by_name(row).is_some(), "the folder {name} is no row of the table");
        rows += 1;
        let reader =
            if folder.join("read").is_dir() { sources(&folder.join("read")) } else { vec![folder.join("read.rs")] };
        let writer =
            if folder.join("write").is_dir() { sources(&folder.join("write")) } else { vec![folder.join("write.rs")] };
        for path in reader {
            says_nothing_of(&path, &["write::", "wording", "Sink", "staged"]);
        }
        for path in writer {
            says_nothing_of(&path, &["read::", "lines::", "ReadError", "MeshReader", "formats::open"]);
        }
    }
    assert_eq!(rows, FORMATS.len());
    for path in ["lines.rs", "reader.rs", "open.rs"] {
        says_nothing_of(&formats.join(path), &["write::", "wording", "staged"]);
    }
    says_nothing_of(&formats.join("wording.rs"), &["read::", "lines::", "ReadError", "MeshReader"]);
    for path in sources(&formats.with_file_name("verify")) {
        let modules = folders.iter().filter(|path| path.is_dir()).filter_map(|path| path.file_name()?.to_str());
        let modules: Vec<String> = modules.map(|module| format!("formats::{module}")).collect();
        let words = ["write::", "wording", "Sink"].into_iter().chain(modules.iter().map(String::as_str));
        says_nothing_of(&path, &words.collect::<Vec<_>>());
    }
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = folder.read_dir().unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = entries.map(|e| e.expect("an entry").path());
    let is_source = |path: &PathBuf| path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs");
    paths.filter(is_source).collect()
}

/// Tests at the end of a file may say anything.
fn says_nothing_of(path: &Path, words: &[&str]) {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    for line in code.lines().filter(|line| !line.trim_start().starts_with("//")) {
        let found = words.iter().find(|word| line.contains(**word));
        assert!(found.is_none(), "{}: {line}", path.display());
    }
}
