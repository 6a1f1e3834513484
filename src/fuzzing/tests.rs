//! A short run of every target.

use std::path::{Path, PathBuf};

use gdal::DriverManager;
use gdal::raster::{Buffer, GdalType, RasterCreationOptions};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::{mesh, naive};
use crate::base::CoordinateFrame;
use crate::base::Heights;
use crate::base::control::Control;
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::base::staged::StagedFile;
use crate::field::Field;
use crate::formats::{Base, Compression, FORMATS, Format, Header, Precision, Setup, SinkOptions};
use crate::job::spool::{Attribute, Chunk, fuzzing as codec};
use crate::job::{Params, triangulate};
use crate::kernel::measure::ErrorStats;
use crate::kernel::seam::{Foreign, RimCounts};
use crate::raster::quiet_gdal;

type Run = Box<dyn Fn(&[u8])>;
type Seeds = Vec<(&'static str, Vec<u8>)>;

fn corpus(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target)
}

/// The files of a target's corpus, in the order of their names. There are none in a packaged crate.
fn files(target: &str) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> = corpus(target).read_dir().into_iter().flatten().flatten().map(|e| e.path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).expect("a file of the corpus")).collect()
}

/// The formats that are fuzzed: all that are read by code of this house.
fn fuzzed() -> impl Iterator<Item = &'static Format> {
    FORMATS.iter().copied().filter(|format| format.name != "ogr")
}

/// A mesh of the raster of `mesh` in this format, within the tolerance by far or just so.
fn written(format: &Format, max_error: f64, options: SinkOptions) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh").with_extension(format.extensions[0]);
    let heights = Heights::F64(mesh::heights());
    let field = Field::from_heights(mesh::SIDE, mesh::SIDE, heights).expect("a field");
    let made = triangulate(&field, &Params::new(max_error), &Control::default()).expect("a mesh");
    let single = !format.precisions.contains(&Precision::Double);
    let frame = CoordinateFrame { single, ..CoordinateFrame::PLAIN };
    let setup =
        Setup { header: Header { frame, ..Header::default() }, loss: f64::INFINITY, options, ..Setup::default() };
    let staged = StagedFile::create(&path, false, &[]).expect("staged");
    made.write((format.sink)(staged, setup).expect("a sink"), &Control::default()).expect("written");
    std::fs::read(&path).expect("a file")
}

/// Meshes in a format.
fn meshes_in(format: &'static Format) -> Seeds {
    let usual = SinkOptions::default();
    let mut seeds = vec![("exact", written(format, 0.0, usual)), ("binary", written(format, mesh::TOLERANCE, usual))];
    match format.name {
        "ply" => seeds = meshes(),
        "glb" => {
            let compression = Some(Compression::Meshopt);
            seeds.push(("compressed", written(format, 0.0, SinkOptions { compression, ..usual })));
        }
        "stl" => {
            let base = Some(Base::Depth(1.0));
            seeds.push(("solid", written(format, 0.0, SinkOptions { base, ..usual })));
        }
        _ => {}
    }
    seeds
}

/// Meshes of the raster of `mesh` as PLY.
fn meshes() -> Seeds {
    let folder = tempfile::tempdir().expect("a folder");
    let mut meshes = Vec::new();
    let format = FORMATS[0];
    for (name, max_error) in [("exact", 0.0), ("binary", mesh::TOLERANCE)] {
        meshes.push((name, written(format, max_error, SinkOptions::default())));
    }
    std::fs::write(folder.path().join("exact"), &meshes[0].1).expect("written");
    // The first again as text, with an offset, a factor and an attribute.
    let mut mesh = crate::formats::ply::read::PlyFile::open(&folder.path().join("exact")).expect("a mesh");
    let (vertices, faces) = (mesh.vertex_count(), mesh.face_count());
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment offset 2 -1\ncomment z_scale 0.5\nelement vertex {vertices}\nproperty float x\n\
         property float y\nproperty double z\nproperty uchar red\nelement face {faces}\nproperty list uchar int \
         vertex_index\nend_header\n"
    );
    mesh.for_each_vertex(|_, [x, y, z]| {
        text += &format!("{} {} {} 7\n", x - 2.0, y + 1.0, z * 0.5);
        Ok::<(), crate::formats::ply::read::PlyError>(())
    })
    .expect("vertices");
    mesh.for_each_face(|_, [a, b, c]| {
        text += &format!("3 {a} {b} {c}\n");
        Ok::<(), crate::formats::ply::read::PlyError>(())
    })
    .expect("faces");
    meshes.push(("ascii", text.into_bytes()));
    meshes
}

fn chunks() -> Seeds {
    let vertex = |x, y| Vertex { at: Point { x, y }, height: f64::from(x) * 0.1 };
    let chunk = Chunk {
        rim: RimCounts { corners: 1, north: 1, west: 0, east: 0, south: 0 },
        vertices: vec![vertex(0, 0), vertex(4, 0), vertex(4, 4)],
        foreign: vec![Foreign::NorthEast, Foreign::East(0), Foreign::At { across: -1, down: 1, at: vertex(8, 4).at }],
        borrowed: vec![vertex(8, 0)],
        triangles: vec![[0, 1, 4], [1, 2, 3]],
        attributes: vec![Attribute { name: "slope".to_string(), values: vec![0.5; 3] }],
        errors: ErrorStats { samples: 9, ..ErrorStats::default() },
        ..Chunk::default()
    };
    let whole = codec::encode(&chunk);
    let body = &whole[..whole.len() - 4];
    let manifest = crate::job::work_dir::fuzzing::a_manifest();
    let many: Vec<u8> = (0..=255).collect();
    vec![
        ("whole", [&[0], whole.as_slice()].concat()),
        ("body", [&[1], body].concat()),
        ("made", [&[2, 5, 3, 4, 2], many.as_slice()].concat()),
        ("manifest", [&[3], manifest.as_slice()].concat()),
        ("other-format", [&[3], br#"{"format": 2, "program": "terrabite 9"}"#.as_slice()].concat()),
    ]
}

fn geotiff<T: GdalType + Copy>(
    size: (usize, usize),
    bands: usize,
    options: &[&str],
    of: impl Fn(usize) -> T,
) -> Vec<u8> {
    quiet_gdal();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dem.tif");
    let options: RasterCreationOptions = options.iter().copied().collect();
    let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let dataset = driver.create_with_band_type_with_options::<T, _>(&path, size.0, size.1, bands, &options);
    let dataset = dataset.expect("a raster");
    for band in 1..=bands {
        let mut samples = Buffer::new(size, (0..size.0 * size.1).map(&of).collect());
        dataset.rasterband(band).expect("a band").write((0, 0), size, &mut samples).expect("written");
    }
    dataset.close().expect("closed");
    std::fs::read(path).expect("a file")
}

/// A TIFF by hand: samples of 16 bits in strips of two rows, with these tags beside those that there must be.
fn tiff_by_hand(width: u32, samples: &[u16], further: &[(u16, u16, u32)]) -> Vec<u8> {
    let height = samples.len() as u32 / width;
    let strips = height.div_ceil(2);
    let data = 8u32;
    let offsets = data + 2 * samples.len() as u32;
    let counts = offsets + 4 * strips;
    let ifd = counts + 4 * strips;
    let mut bytes = [b"II*\0".as_slice(), &ifd.to_le_bytes()].concat();
    samples.iter().for_each(|s| bytes.extend(s.to_le_bytes()));
    let rows = |strip: u32| (height - 2 * strip).min(2);
    (0..strips).for_each(|strip| bytes.extend((data + 4 * width * strip).to_le_bytes()));
    (0..strips).for_each(|strip| bytes.extend((2 * width * rows(strip)).to_le_bytes()));
    let mut tags = vec![
        (256u16, 4u16, 1u32, width),
        (257, 4, 1, height),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 4, strips, if strips == 1 { data } else { offsets }),
        (277, 3, 1, 1),
        (278, 4, 1, 2),
        (279, 4, strips, if strips == 1 { 2 * width * rows(0) } else { counts }),
    ];
    tags.extend(further.iter().map(|&(tag, kind, value)| (tag, kind, 1, value)));
    tags.sort();
    bytes.extend((tags.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in tags {
        bytes.extend(tag.to_le_bytes().into_iter().chain(kind.to_le_bytes()));
        bytes.extend(count.to_le_bytes().into_iter().chain(value.to_le_bytes()));
    }
    bytes.extend([0; 4]);
    bytes
}

fn tiffs() -> Seeds {
    let byte = |i: usize| (i * 37 % 251) as u8;
    let single = |i: usize| i as f32 * 0.25 - 3.0;
    let samples: Vec<u16> = (0..30).map(|i| i * 1031).collect();
    vec![
        ("strips", geotiff::<f32>((7, 5), 1, &["BLOCKYSIZE=2"], single)),
        ("tiles", geotiff::<i16>((18, 17), 1, &["TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16"], |i| i as i16 - 40)),
        ("bands", geotiff::<u8>((6, 4), 2, &["INTERLEAVE=BAND"], byte)),
        ("pixels", geotiff::<u8>((6, 4), 2, &["INTERLEAVE=PIXEL"], byte)),
        ("big", geotiff::<f64>((4, 3), 1, &["BIGTIFF=YES"], |i| i as f64 / 3.0)),
        ("packed", geotiff::<u16>((6, 4), 1, &["NBITS=12"], |i| i as u16 * 100)),
        ("deflated", geotiff::<u16>((6, 4), 1, &["COMPRESS=DEFLATE", "PREDICTOR=2"], |i| i as u16)),
        ("by-hand", tiff_by_hand(6, &samples, &[(266, 3, 1), (284, 3, 1), (339, 3, 2)])),
        ("reversed", tiff_by_hand(6, &samples, &[(266, 3, 2), (284, 3, 1), (339, 3, 2)])),
    ]
}

fn jobs() -> Seeds {
    let job = |head: &[u8], samples: usize| {
        let body = (0..samples).map(|i| (i * i % 11) as u8);
        head.iter().copied().chain(body).collect::<Vec<u8>>()
    };
    // Width, height, tile, tolerance, engine, quality, angle, edges, feasibility, flags, how many heights of the list.
    vec![
        ("plain", job(&[6, 5, 0, 1, 0, 2, 0, 0, 0, 0, 9], 60)),
        ("tiles", job(&[8, 7, 3, 2, 0, 5, 2, 1, 1, 0, 18], 90)),
        ("cuts", job(&[7, 9, 2, 3, 2, 6, 0, 0, 1, 1, 31], 99)),
        ("weights", job(&[5, 6, 1, 1, 3, 3, 0, 0, 0, 2, 9], 120)),
        ("files", job(&[6, 6, 2, 1, 0, 2, 0, 0, 0, 6, 31], 140)),
        ("bad", job(&[4, 4, 0, 9, 8, 0, 0, 31, 31], 40)),
    ]
}

/// `TERRABITE_CORPUS=write cargo test seeds` writes them anew.
#[test]
fn seeds_pass_and_are_in_the_corpus() {
    let write = std::env::var_os("TERRABITE_CORPUS").is_some_and(|v| v == "write");
    let others: [(&str, Seeds, Run); 3] = [
        ("chunk", chunks(), Box::new(super::chunk)),
        ("tiff", tiffs(), Box::new(super::tiff)),
        ("simplify", jobs(), Box::new(super::simplify)),
    ];
    let formats = fuzzed().map(|format| {
        let run: Run = Box::new(|bytes| super::mesh(format.name, bytes));
        (format.name, meshes_in(format), run)
    });
    for (target, seeds, run) in formats.chain(others) {
        for (name, bytes) in seeds {
            run(&bytes);
            if write {
                std::fs::create_dir_all(corpus(target)).expect("a folder");
                std::fs::write(corpus(target).join(name), bytes).expect("written");
            }
        }
        files(target).iter().for_each(|bytes| run(bytes));
    }
}

/// What is done to a seed.
#[derive(Debug, Clone)]
enum Edit {
    Set(Index, u8),
    Flip(Index, u8),
    Cut(Index),
    Insert(Index, Vec<u8>),
    Copy(Index, Index, usize),
}

fn edit() -> impl Strategy<Value = Edit> {
    let near = prop_oneof![Just(0u8), Just(1), Just(2), Just(255), any::<u8>()];
    prop_oneof![
        6 => (any::<Index>(), near).prop_map(|(at, byte)| Edit::Set(at, byte)),
        6 => (any::<Index>(), 0u8..8).prop_map(|(at, bit)| Edit::Flip(at, bit)),
        1 => any::<Index>().prop_map(Edit::Cut),
        2 => (any::<Index>(), vec(any::<u8>(), 1..9)).prop_map(|(at, bytes)| Edit::Insert(at, bytes)),
        2 => (any::<Index>(), any::<Index>(), 1usize..9).prop_map(|(from, to, many)| Edit::Copy(from, to, many)),
    ]
}

fn spoilt(mut bytes: Vec<u8>, edits: &[Edit]) -> Vec<u8> {
    for edit in edits {
        if bytes.is_empty() {
            break;
        }
        let length = bytes.len();
        match edit {
            Edit::Set(at, byte) => bytes[at.index(length)] = *byte,
            Edit::Flip(at, bit) => bytes[at.index(length)] ^= 1 << bit,
            Edit::Cut(at) => bytes.truncate(at.index(length)),
            Edit::Insert(at, more) => {
                let at = at.index(length);
                bytes.splice(at..at, more.iter().copied());
            }
            Edit::Copy(from, to, many) => {
                let (from, to) = (from.index(length), to.index(length));
                let many = *many.min(&(length - from.max(to)));
                bytes.copy_within(from..from + many, to);
            }
        }
    }
    bytes
}

fn any_of(seeds: Seeds) -> impl Strategy<Value = Vec<u8>> {
    let seeds: Vec<Vec<u8>> = seeds.into_iter().map(|(_, bytes)| bytes).collect();
    (prop::sample::select(seeds), vec(edit(), 1..5)).prop_map(|(seed, edits)| spoilt(seed, &edits))
}

/// A spoilt mesh of any format, with the format's name.
fn any_mesh() -> impl Strategy<Value = (&'static str, Vec<u8>)> {
    let seeds = fuzzed().flat_map(|format| meshes_in(format).into_iter().map(|(_, bytes)| (format.name, bytes)));
    let seeds: Vec<(&'static str, Vec<u8>)> = seeds.collect();
    (prop::sample::select(seeds), vec(edit(), 1..5)).prop_map(|((name, seed), edits)| (name, spoilt(seed, &edits)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_mesh_is_judged((format, bytes) in any_mesh()) {
        super::mesh(format, &bytes);
    }

    #[test]
    fn any_chunk_is_read_or_refused(bytes in prop_oneof![any_of(chunks()), vec(any::<u8>(), 0..300)]) {
        super::chunk(&bytes);
    }

    #[test]
    fn any_tiff_is_read_in_place_as_gdal_reads_it(bytes in any_of(tiffs())) {
        super::tiff(&bytes);
    }

    #[test]
    fn any_heights_are_simplified_or_refused(bytes in prop_oneof![any_of(jobs()), vec(any::<u8>(), 0..300)]) {
        super::simplify(&bytes);
    }
}

/// The naive check finds what the verifier finds.
#[test]
fn a_mesh_without_a_face_or_too_far_is_none() {
    let heights = [0.0, 1.0, 2.0, 3.0];
    let ground = naive::Ground::new((2, 2), &heights, &[]);
    let surface = |faces: &[[usize; 3]], z: f64| naive::Surface {
        places: vec![(0, 0), (4, 0), (4, 4), (0, 4)],
        heights: vec![0.0, 1.0, 3.0, z],
        faces: faces.to_vec(),
    };
    let both = [[0, 2, 1], [0, 3, 2]];
    assert_eq!(ground.check(&surface(&both, 2.0), 0.0), Ok(()));
    assert_eq!(ground.check(&surface(&both, 2.5), 0.5), Ok(()));
    assert!(ground.check(&surface(&both, 2.5), 0.499).is_err());
    assert!(ground.check(&surface(&both[..1], 2.0), 0.0).is_err());
    assert!(ground.check(&surface(&[[0, 1, 2], [0, 2, 3]], 2.0), 0.0).is_err());
    let weighted = |weights: &[f64]| naive::Ground::new((2, 2), &heights, weights).check(&surface(&both, 2.5), 0.5);
    assert_eq!(weighted(&[1.0, 1.0, 1.0, 1.0]), Ok(()));
    // The fourth sample is the third vertex of the list: rows are read from left to right.
    assert!(weighted(&[1.0, 1.0, 1.001, 1.0]).is_err() && weighted(&[1.0, 1.0, 0.5, 9.0]) == Ok(()));
}

/// GDAL tells no places of its blocks, and when it is asked again, that they begin at 0, in the header.
#[test]
fn blocks_in_the_header_are_not_used_in_place() {
    // Like the kind of StripOffsets (273), those of the last two are none.
    let mut bytes = b"II*\0\x08\0\0\0\x0b\0".to_vec();
    for (tag, kind, count, value) in [
        (256u16, 3u16, 1u32, 7u32),
        (257, 3, 1, 5),
        (258, 3, 1, 32),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 99, 3, 152),
        (277, 3, 1, 1),
        (278, 3, 1, 2),
        (279, 1, 126, 0),
        (0, 22873, 1, 1),
        (22873, 22873, 1, 1),
    ] {
        for part in [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()] {
            bytes.extend_from_slice(part);
        }
    }
    bytes.resize(173, 0);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dem.tif");
    std::fs::write(&path, &bytes).expect("written");
    crate::raster::quiet_gdal();
    let raster = crate::raster::Raster::open(&path, 1).expect("opens");
    for _ in 0..3 {
        raster.to_band().expect("a band").plain_layout().expect_err("not in place");
    }
    super::tiff(&bytes);
}

/// The first and the last row are the same in either order; the heights between were taken as they stood in the file.
#[test]
fn bits_in_reverse_order_are_not_used_in_place() {
    let samples: Vec<u16> = (0..48).map(|i| if (12..36).contains(&i) { i } else { 0 }).collect();
    let bytes = tiff_by_hand(6, &samples, &[(266, 3, 2)]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dem.tif");
    std::fs::write(&path, &bytes).expect("written");
    let raster = crate::raster::Raster::open(&path, 1).expect("opens");
    let reason = raster.to_band().expect("a band").plain_layout().expect_err("not in place");
    assert!(reason.contains("FillOrder"), "{reason}");
    super::tiff(&bytes);
    let usual = tiff_by_hand(6, &samples, &[(266, 3, 1)]);
    std::fs::write(&path, &usual).expect("written");
    crate::testing::band(&path, 1).plain_layout().expect("in place");
}
