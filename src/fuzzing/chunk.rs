//! Fuzzing: chunks that are torn or made up.

use super::bytes::Bytes;
use super::temp_dir;
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::job::spool::{Attribute, Chunk, Spool, fuzzing as codec};
use crate::job::work_dir::fuzzing as work_dir;
use crate::kernel::measure::{BINS, ShapeStats, WeightedStats};
use crate::kernel::seam::{Foreign, RimCounts};

/// The stamp of the kept spool.
const STAMP: u32 = 7;

/// Chunks and manifests as they are kept. The first byte says what the others are.
pub fn chunk(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    match kind % 4 {
        0 => decode(bytes),
        // Nothing is behind a checksum that does not fit: it is made to.
        1 => decode(&[bytes, &crc32fast::hash(bytes).to_le_bytes()].concat()),
        2 => come_back(&mut Bytes::new(bytes)),
        _ => work_dir::manifest(bytes, &temp_dir()),
    }
}

/// Whatever is read as a chunk is one that comes back, and the folder that it is kept in says the same of it.
fn decode(bytes: &[u8]) {
    let mut chunk = Chunk::default();
    let is_read = codec::decode(bytes, &mut chunk).is_ok();
    if is_read {
        let in_tile = (chunk.vertices.len() + chunk.borrows()) as u64;
        assert!(chunk.triangles.as_flattened().iter().all(|&i| u64::from(i) < in_tile));
        assert!(chunk.attributes.iter().all(|a| a.values.len() == chunk.vertices.len()));
        // By bytes: NaN differs from itself.
        let again = codec::encode(&chunk);
        let mut twice = Chunk::default();
        codec::decode(&again, &mut twice).expect("what was written");
        assert_eq!(codec::encode(&twice), again);
    }
    let folder = tempfile::tempdir_in(temp_dir()).expect("a folder");
    let spool = Spool::kept(folder.path(), 1, 1, STAMP, false).expect("a spool");
    std::fs::create_dir(folder.path().join("0")).expect("a row");
    let kept = [bytes, &STAMP.to_le_bytes()].concat();
    std::fs::write(folder.path().join("0/0.chunk"), kept).expect("written");
    if spool.find(0, &mut chunk, &mut Vec::new()).expect("readable") {
        assert!(is_read && chunk.before_borrowed() <= chunk.vertices.len());
        assert_eq!(spool.counts(0..1).expect("counts"), [chunk.counts()]);
    }
}

/// A chunk comes back as it was; with a bit flipped, cut short or with more at its end it does not.
fn come_back(from: &mut Bytes<'_>) {
    let chunk = a_chunk(from);
    let mut bytes = codec::encode(&chunk);
    // Memory that held another chunk.
    let mut decoded = Chunk { vertices: vec![Vertex { at: Point { x: 1, y: 2 }, height: 3.0 }; 4], ..Chunk::default() };
    codec::decode(&bytes, &mut decoded).expect("what was written");
    assert_eq!(codec::encode(&decoded), bytes);
    let bit = from.word() as usize % (8 * bytes.len());
    bytes[bit / 8] ^= 1 << (bit % 8);
    assert!(codec::decode(&bytes, &mut decoded).is_err(), "bit {bit}");
    bytes[bit / 8] ^= 1 << (bit % 8);
    let length = from.word() as usize % bytes.len();
    assert!(codec::decode(&bytes[..length], &mut decoded).is_err(), "{length} bytes");
    bytes.push(from.byte());
    assert!(codec::decode(&bytes, &mut decoded).is_err(), "longer");
}

fn a_chunk(from: &mut Bytes<'_>) -> Chunk {
    let count = |from: &mut Bytes<'_>| from.word() as u32;
    let vertex = |from: &mut Bytes<'_>| {
        let at = from.word();
        Vertex { at: Point { x: at as i32, y: (at >> 32) as i32 }, height: from.double() }
    };
    let foreign = |from: &mut Bytes<'_>| match from.byte() % 6 {
        0 => Foreign::NorthEast,
        1 => Foreign::SouthWest,
        2 => Foreign::SouthEast,
        3 => Foreign::East(from.word() as u32),
        4 => Foreign::South(from.word() as u32),
        _ => {
            let (across, down) = (from.within(0, 3) as i32 - 1, from.within(0, 1) as u32);
            Foreign::At { across, down, at: vertex(from).at }
        }
    };
    let [vertices, borrowed, triangles, attributes] =
        [from.within(0, 12), from.within(0, 6), from.within(0, 9), from.within(0, 3)];
    let corners = vertices + borrowed;
    let mut chunk = Chunk {
        tile: from.word() as usize,
        rim: RimCounts {
            corners: count(from),
            north: count(from),
            west: count(from),
            east: count(from),
            south: count(from),
        },
        shared: count(from),
        pending: count(from),
        vertices: (0..vertices).map(|_| vertex(from)).collect(),
        foreign: (0..borrowed).map(|_| foreign(from)).collect(),
        borrowed: (0..from.within(0, borrowed)).map(|_| vertex(from)).collect(),
        relaxed: from.word(),
        samples_checksum: count(from),
        ..Chunk::default()
    };
    if corners > 0 {
        let corner = |from: &mut Bytes<'_>| from.within(0, corners - 1) as u32;
        chunk.triangles = (0..triangles).map(|_| std::array::from_fn(|_| corner(from))).collect();
    }
    for _ in 0..attributes {
        let name = (0..from.within(0, 5)).map(|_| char::from(from.byte())).collect();
        chunk.attributes.push(Attribute { name, values: (0..vertices).map(|_| from.double()).collect() });
    }
    let errors = &mut chunk.errors;
    (errors.samples, errors.nodata) = (from.word(), from.word());
    (errors.stray, errors.trimmed) = (from.word(), from.word());
    errors.beside = from.word();
    (errors.max, errors.weighted_max, errors.squares) = (from.double(), from.double(), from.double());
    errors.worst = (from.word(), from.word());
    errors.histogram[from.word() as usize % BINS] = from.word();
    if from.bit() {
        let mut shape = Box::<ShapeStats>::default();
        (shape.angles[0], shape.overshoots[0], shape.overshoot_max) = (from.word(), from.word(), from.double());
        shape.astray = shape.angles[0];
        errors.shape = Some(shape);
    }
    if from.bit() {
        errors.extended = Some(WeightedStats { max: from.double(), worst: (from.word(), from.word()) });
    }
    chunk
}
