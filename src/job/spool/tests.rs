//! Chunks come back as they were kept, and seam vertices have one number.

use std::collections::HashMap;

use proptest::collection::vec;
use proptest::prelude::*;

use super::{Attribute, Chunk, Ids, Spool, SpoolError, codec};
use crate::base::PointSet;
use crate::base::control::CancelToken;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::{TileMesh, Vertex};
use crate::base::tiling::TileGrid;
use crate::base::{Heights, Tile};
use crate::kernel::measure::{BINS, ErrorStats, WeightedStats};
use crate::kernel::seam::{Foreign, MinLink, Rim, RimCounts};

fn foreign() -> impl Strategy<Value = Foreign> {
    prop_oneof![
        Just(Foreign::NorthEast),
        Just(Foreign::SouthWest),
        Just(Foreign::SouthEast),
        any::<u32>().prop_map(Foreign::East),
        any::<u32>().prop_map(Foreign::South),
    ]
}

fn vertex() -> impl Strategy<Value = Vertex> {
    (any::<(i32, i32)>(), -1e30f64..1e30).prop_map(|((x, y), height)| Vertex { at: Point { x, y }, height })
}

fn errors() -> impl Strategy<Value = ErrorStats> {
    let numbers = [0.0..1e30f64, 0.0..1e30f64, 0.0..1e30f64];
    (any::<[u64; 4]>(), numbers).prop_map(|([samples, column, row, count], [max, weighted_max, squares])| {
        let worst = (column, row);
        let mut errors =
            ErrorStats { samples, bridged: samples / 7, max, weighted_max, worst, squares, ..ErrorStats::default() };
        errors.histogram[count as usize % BINS] = count;
        (errors.nodata, errors.stray, errors.trimmed) = (row, count, column);
        errors.extended = (count % 2 == 1).then_some(WeightedStats { max: squares, worst: (row, column) });
        errors
    })
}

fn attribute(vertices: usize) -> impl Strategy<Value = Attribute> {
    (".{0,5}", vec(-1e9f64..1e9, vertices)).prop_map(|(name, values)| Attribute { name, values })
}

fn chunk() -> impl Strategy<Value = Chunk> {
    let sizes = (1usize..12, 0usize..6);
    sizes.prop_flat_map(|(own, borrowed)| {
        let corner = 0..(own + borrowed) as u32;
        let lists = (
            vec(vertex(), own),
            (vec(foreign(), borrowed), vec(vertex(), borrowed)),
            vec([corner.clone(), corner.clone(), corner], 0..9),
            vec(attribute(own), 0..3),
        );
        (lists, errors(), any::<[u32; 8]>(), any::<[u32; 2]>()).prop_map(|(lists, errors, counts, wide)| {
            let (vertices, (foreign, borrowed), triangles, attributes) = lists;
            let [corners, north, west, east, south, shared, pending, samples_checksum] = counts;
            let rim = RimCounts { corners, north, west, east, south };
            let (tile, relaxed) = (wide[0] as usize, u64::from(wide[1]));
            Chunk {
                tile,
                rim,
                shared,
                pending,
                vertices,
                foreign,
                borrowed,
                triangles,
                attributes,
                errors,
                relaxed,
                samples_checksum,
            }
        })
    })
}

fn encoded(chunk: &Chunk) -> Vec<u8> {
    let mut bytes = Vec::new();
    codec::encode(chunk, &mut bytes);
    bytes
}

proptest! {
    #[test]
    fn chunks_come_back(chunk in chunk(), before in chunk()) {
        // Whatever the memory held that is lent.
        let mut decoded = before;
        prop_assert_eq!(codec::decode(&encoded(&chunk), &mut decoded), Ok(()));
        prop_assert_eq!(decoded, chunk);
    }
}

/// A chunk of a few vertices, each list in use.
fn small() -> Chunk {
    let vertex = |x, y| Vertex { at: Point { x, y }, height: f64::from(x) * 0.1 };
    Chunk {
        tile: 3,
        rim: RimCounts { corners: 1, north: 1, west: 0, east: 0, south: 0 },
        vertices: vec![vertex(0, 0), vertex(4, 0), vertex(4, 4)],
        foreign: vec![Foreign::NorthEast, Foreign::East(0)],
        triangles: vec![[0, 1, 4], [1, 2, 3]],
        attributes: vec![Attribute { name: "slope".to_string(), values: vec![0.5; 3] }],
        ..Chunk::default()
    }
}

#[test]
fn every_cut_is_refused() {
    let bytes = encoded(&small());
    for length in 0..bytes.len() {
        assert!(codec::decode(&bytes[..length], &mut Chunk::default()).is_err(), "{length} bytes");
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert!(codec::decode(&longer, &mut Chunk::default()).is_err());
}

#[test]
fn every_flipped_bit_is_refused() {
    let mut bytes = encoded(&small());
    for bit in 0..8 * bytes.len() {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(codec::decode(&bytes, &mut Chunk::default()).is_err(), "bit {bit}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

/// Even with a checksum that fits: counts and indices from outside are not believed.
#[test]
fn nonsense_with_a_good_checksum_does_not_panic() {
    let bytes = encoded(&small());
    let body = bytes.len() - 4;
    for at in 0..body {
        for value in [0, 1, 0x7f, 0x80, 0xff] {
            let mut changed = bytes.clone();
            changed[at] = value;
            let checksum = crc32fast::hash(&changed[..body]);
            changed[body..].copy_from_slice(&checksum.to_le_bytes());
            let mut chunk = Chunk::default();
            if codec::decode(&changed, &mut chunk).is_ok() {
                let in_tile = chunk.vertices.len() + chunk.borrows();
                assert!(chunk.triangles.as_flattened().iter().all(|&i| (i as usize) < in_tile), "byte {at}");
            }
        }
    }
}

/// The tiles of a bumpy field: each with its rim, the points inside, one more vertex there, and no triangle.
fn tiles(grid: TileGrid, points: &PointSet) -> Vec<(Chunk, Vec<Vertex>)> {
    let height = |column: usize, row: usize| ((column * 7919 + row * 104_729) % 31) as f32;
    let tile = |index: usize| {
        let place = grid.place(index);
        let window = place.window;
        let places = (0..window.len()).map(|i| (window.column + i % window.width, window.row + i / window.width));
        let heights = Heights::F32(places.map(|(column, row)| height(column, row)).collect());
        let samples = Tile::from_heights(window.width, window.height, heights);
        let mut forced = Vec::new();
        points.within(window, &mut forced);
        let rim = Rim::new(&samples, 9.0, &forced, &place, &mut MinLink::default(), &CancelToken::default()).unwrap();
        let mut mesh = TileMesh { vertices: rim.domain.fixed().collect(), ..TileMesh::default() };
        if !forced.contains(&(1, 1)) {
            mesh.vertices.push(Vertex { at: Point::of_sample(1, 1), height: samples.at(1, 1) });
        }
        let mut chunk = Chunk::default();
        chunk.fill(index, &rim, &mut mesh.clone(), ErrorStats::default(), samples.checksum());
        (chunk, mesh.vertices)
    };
    (0..grid.len()).map(tile).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// In grids of one row or column, too, where a tile is first and last. Points fall on seams and corners as well.
    #[test]
    fn neighbours_call_a_seam_vertex_by_one_number(
        wide in any::<bool>(), high in any::<bool>(), points in vec((0.0f64..1.0, 0.0f64..1.0), 0..60),
    ) {
        let (width, height) = (if wide { 37 } else { 12 }, if high { 34 } else { 12 });
        let grid = TileGrid::new(width, height, 12);
        let scaled = |(x, y): (f64, f64)| ((x * width as f64) as usize, (y * height as f64) as usize);
        let points = PointSet::new(points.into_iter().map(scaled));
        let folder = tempfile::tempdir().unwrap();
        let spool = Spool::new(folder.path(), grid.len()).unwrap();
        let tiles = tiles(grid, &points);
        // In any order.
        tiles.iter().rev().for_each(|(chunk, _)| spool.append(chunk, &mut Vec::new()).unwrap());

        let mut ids = Ids::new(&spool, grid).unwrap();
        let (mut numbers, mut number_at, mut place_of) = (Vec::new(), HashMap::new(), HashMap::new());
        for (index, (_, vertices)) in tiles.iter().enumerate() {
            if index > 0 && index % grid.columns() == 0 {
                ids.next_row().unwrap();
            }
            let mut chunk = Chunk::default();
            spool.read(index, &mut chunk, &mut Vec::new()).unwrap();
            ids.of_chunk(&chunk, &mut numbers);
            let window = grid.window(grid.tile(index));
            let place = |at: Point| (at.x + STEPS * window.column as i32, at.y + STEPS * window.row as i32);
            assert_eq!(numbers.len(), vertices.len());
            for (&number, vertex) in numbers.iter().zip(vertices) {
                let place = place(vertex.at);
                assert_eq!(*number_at.entry(place).or_insert(number), number, "tile {index}, {place:?}");
                assert_eq!(*place_of.entry(number).or_insert(place), place, "tile {index}, vertex {number}");
            }
        }
        let owned: u64 = tiles.iter().map(|(chunk, _)| chunk.counts().vertices).sum();
        let mut used: Vec<u64> = place_of.into_keys().collect();
        used.sort();
        assert_eq!(used, (0..owned).collect::<Vec<u64>>());
        for (column, row) in points.iter() {
            let place = (STEPS * column as i32, STEPS * row as i32);
            assert!(number_at.contains_key(&place), "point {column}, {row}");
        }
    }
}

/// Fills a kept spool, lets go of it, and gives another one over the same folder.
fn kept(folder: &tempfile::TempDir, grid: TileGrid, stamp: u32) -> Spool {
    Spool::kept(&folder.path().join("chunks"), grid.columns(), grid.len(), stamp, false).unwrap()
}

#[test]
fn kept_chunks_are_found_by_the_next_spool_of_the_job() {
    let grid = TileGrid::new(37, 34, 12);
    let folder = tempfile::tempdir().unwrap();
    let tiles = tiles(grid, &PointSet::default());
    let (mut chunk, mut buffer) = (Chunk::default(), Vec::new());
    let first = kept(&folder, grid, 7);
    for (made, _) in tiles.iter().filter(|(c, _)| c.tile != 4) {
        assert!(!first.find(made.tile, &mut chunk, &mut buffer).unwrap());
        first.append(made, &mut buffer).unwrap();
    }
    drop(first);
    let next = kept(&folder, grid, 7);
    for (made, _) in &tiles {
        let found = next.find(made.tile, &mut chunk, &mut buffer).unwrap();
        assert_eq!(found, made.tile != 4);
        if found {
            assert_eq!(chunk, *made);
        } else {
            next.append(made, &mut buffer).unwrap();
        }
        next.read(made.tile, &mut chunk, &mut buffer).unwrap();
        assert_eq!(chunk, *made);
    }
    let counts: Vec<_> = tiles.iter().map(|(c, _)| c.counts()).collect();
    assert_eq!(next.counts(0..grid.len()).unwrap(), counts);
    let other = kept(&folder, grid, 8);
    assert!(!other.find(0, &mut chunk, &mut buffer).unwrap());
}

#[test]
fn torn_kept_chunks_count_as_missing() {
    let grid = TileGrid::new(13, 13, 12);
    let folder = tempfile::tempdir().unwrap();
    let (mut chunk, mut buffer) = (Chunk::default(), Vec::new());
    kept(&folder, grid, 7).append(&Chunk { tile: 0, ..small() }, &mut buffer).unwrap();
    let path = folder.path().join("chunks/0/0.chunk");
    let whole = std::fs::read(&path).unwrap();
    assert!(kept(&folder, grid, 7).find(0, &mut chunk, &mut buffer).unwrap());
    for length in (0..whole.len()).step_by(3) {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(!kept(&folder, grid, 7).find(0, &mut chunk, &mut buffer).unwrap(), "{length} bytes");
    }
    // More rim vertices than vertices: no chunk that a run makes.
    let wrong = Chunk { tile: 0, rim: RimCounts { north: 4, ..small().rim }, ..small() };
    kept(&folder, grid, 7).append(&wrong, &mut buffer).unwrap();
    assert!(!kept(&folder, grid, 7).find(0, &mut chunk, &mut buffer).unwrap());
}

/// As processes do that work on the same tiles: whoever looks finds a whole chunk or none, and nobody is in another's way.
#[test]
fn the_same_chunk_may_be_kept_by_several_at_the_same_time() {
    let grid = TileGrid::new(37, 34, 12);
    let folder = tempfile::tempdir().unwrap();
    let tiles = tiles(grid, &PointSet::default());
    let (mut chunk, mut buffer) = (Chunk::default(), Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| {
                let spool = kept(&folder, grid, 7);
                for _ in 0..5 {
                    tiles.iter().for_each(|(made, _)| spool.append(made, &mut Vec::new()).unwrap());
                }
            });
        }
        for _ in 0..20 {
            let spool = kept(&folder, grid, 7);
            for (made, _) in &tiles {
                let is_there = folder.path().join(format!("chunks/{}/{}.chunk", made.tile / 3, made.tile % 3)).exists();
                let found = spool.find(made.tile, &mut chunk, &mut buffer).unwrap();
                assert!(found || !is_there, "a part of tile {}", made.tile);
                assert!(!found || chunk == *made);
            }
        }
    });
    let names = |row: usize| folder.path().join(format!("chunks/{row}")).read_dir().unwrap().count();
    assert_eq!([0, 1, 2].map(names), [3; 3], "private names are gone");
    kept(&folder, grid, 7).sync().unwrap();
}

/// Their sum goes over 32 bits.
#[test]
fn counts_beyond_all_numbers_are_refused() {
    let grid = TileGrid::new(13, 13, 12);
    let folder = tempfile::tempdir().unwrap();
    let (mut chunk, mut buffer) = (Chunk::default(), Vec::new());
    let rim = RimCounts { north: u32::MAX, west: 2, ..small().rim };
    kept(&folder, grid, 7).append(&Chunk { tile: 0, rim, shared: u32::MAX, ..small() }, &mut buffer).unwrap();
    assert!(!kept(&folder, grid, 7).find(0, &mut chunk, &mut buffer).unwrap());
}

#[test]
fn what_cannot_be_kept_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let grid = TileGrid::new(13, 13, 12);
    let spool = kept(&folder, grid, 7);
    std::fs::write(folder.path().join("chunks/0"), "a file where a folder should be").unwrap();
    let refused = spool.append(&Chunk { tile: 0, ..small() }, &mut Vec::new()).unwrap_err();
    assert!(matches!(&refused, SpoolError::Kept { path, .. } if path.ends_with("0/0.chunk")), "{refused}");
}
