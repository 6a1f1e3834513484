//! Rims of neighbours, who see the same samples and the same points: points on them, and nested ones.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::{Foreign, LateVertex, MinLink, NestedRim, Rim, Side};
use crate::base::PointSet;
use crate::base::control::CancelToken;
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;
use crate::base::tiling::{TileGrid, TileId};
use crate::base::{Heights, Tile};
use crate::field::Field;

type Place = (usize, usize);

/// A bumpy field of small tiles, with points.
struct Scene {
    grid: TileGrid,
    seed: usize,
    points: PointSet,
}

impl Scene {
    fn height(&self, column: usize, row: usize) -> f64 {
        ((column * 7919 + row * 104_729 + self.seed) % 13) as f64
    }

    fn rim(&self, id: TileId) -> Rim {
        let at = self.grid.place_of(id);
        let window = at.window;
        let place = |i: usize| (window.column + i % window.width, window.row + i / window.width);
        let heights = (0..window.len()).map(|i| self.height(place(i).0, place(i).1)).collect();
        let tile = Tile::from_heights(window.width, window.height, Heights::F64(heights));
        let mut points = Vec::new();
        self.points.within(window, &mut points);
        Rim::new(&tile, 4.0, &points, &at, &mut MinLink::default(), &CancelToken::default()).expect("nobody cancels")
    }

    /// Where a vertex of a tile lies in the field.
    fn place(&self, id: TileId, vertex: Vertex) -> Place {
        let (window, (column, row)) = (self.grid.window(id), vertex.at.sample().expect("a sample"));
        (window.column + column, window.row + row)
    }

    /// The places on one side that a tile owns, in its order.
    fn side(&self, id: TileId, rim: &Rim, west: bool) -> Vec<Place> {
        let (first, count) = match west {
            false => (rim.owned.before_north(), rim.owned.north),
            true => (rim.owned.before_west(), rim.owned.west),
        };
        (first..first + count).map(|i| self.place(id, rim.domain.vertices[i as usize])).collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn points_are_vertices_and_neighbours_agree(
        (width, height) in (2usize..30, 2usize..30), tile in 1usize..12, seed in 0usize..1000,
        points in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 0..80),
    ) {
        let scaled = |(x, y): (f64, f64)| ((x * width as f64) as usize, (y * height as f64) as usize);
        let points = PointSet::new(points.into_iter().map(scaled));
        let scene = Scene { grid: TileGrid::new(width, height, tile), seed, points };
        let grid = scene.grid;
        let rims: Vec<Rim> = (0..grid.len()).map(|i| scene.rim(grid.tile(i))).collect();
        // How many tiles own what lies there.
        let mut owners: BTreeMap<Place, usize> = BTreeMap::new();
        for (index, rim) in rims.iter().enumerate() {
            let id = grid.tile(index);
            let (owned, borrowed) = rim.domain.vertices.split_at(rim.owned.total() as usize);
            for vertex in owned.iter().chain(&rim.domain.points) {
                *owners.entry(scene.place(id, *vertex)).or_default() += 1;
            }
            for vertex in rim.domain.fixed() {
                let (column, row) = scene.place(id, vertex);
                prop_assert_eq!(vertex.height, scene.height(column, row));
            }
            let window = grid.window(id);
            let inside = |at: i32, count: usize| at > 0 && at < STEPS * (count as i32 - 1);
            for point in &rim.domain.points {
                prop_assert!(inside(point.at.x, window.width) && inside(point.at.y, window.height));
            }
            prop_assert!(rim.domain.points.is_sorted_by_key(|v| (v.at.y, v.at.x)));
            // What is borrowed lies where its owner has it.
            for (foreign, vertex) in rim.foreign.iter().zip(borrowed) {
                let found = scene.place(id, *vertex);
                let east = TileId { column: id.column + 1, row: id.row };
                let south = TileId { column: id.column, row: id.row + 1 };
                let owned = |owner: TileId, west, i: u32| scene.side(owner, &rims[grid.index(owner)], west)[i as usize];
                match *foreign {
                    Foreign::East(i) => prop_assert_eq!(owned(east, true, i), found),
                    Foreign::South(i) => prop_assert_eq!(owned(south, false, i), found),
                    _ => {}
                }
            }
        }
        prop_assert!(owners.values().all(|count| *count == 1), "{:?}", owners);
        prop_assert!(scene.points.iter().all(|point| owners.contains_key(&point)));
    }
}

/// Levels of a tile's late vertices, by place in the field.
type Late = BTreeMap<Place, f64>;

/// The nested rim of a tile of a field with missing samples, as places in the field.
fn nested(field: &Field, grid: TileGrid, id: TileId) -> (NestedRim, Late) {
    let (at, mut tile) = (grid.place_of(id), Tile::default());
    let window = at.window;
    field.load(window, &mut tile).expect("loads");
    let found = Rim::nested(&tile, 0.5, &[], &at, |v| v.level > 1.0, &CancelToken::default()).expect("nobody cancels");
    let (right, bottom) = (window.width - 1, window.height - 1);
    let place = |v: &LateVertex| match v.side {
        Some(Side::North) => (v.at, 0),
        Some(Side::South) => (v.at, bottom),
        Some(Side::West) => (0, v.at),
        Some(Side::East) => (right, v.at),
        None => (v.at % window.width, v.at / window.width),
    };
    let all = found.late.iter().map(|(_, v)| v).chain(&found.late_idle);
    let late = all.map(|v| ((window.column + place(v).0, window.row + place(v).1), v.level)).collect();
    (found, late)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The same vertices are late, with the same levels, and one tile owns each.
    #[test]
    fn neighbours_agree_on_nested_rims(
        (width, height) in (2usize..24, 2usize..24), tile in 1usize..9, seed in 0usize..1000, sparse in 2usize..12,
    ) {
        let grid = TileGrid::new(width, height, tile);
        let noise = |i: usize| (i + 1).wrapping_mul(2 * seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        // Blocks are missing, so that there are straight runs.
        let is_missing = |i: usize| noise(i % width / 4 + 99 * (i / width / 3)) % sparse == 0;
        let heights = (0..width * height).map(|i| if is_missing(i) { f64::NAN } else { (noise(i) % 13) as f64 });
        let field = Field::from_heights(width, height, Heights::F64(heights.collect())).expect("a field");
        let all: Vec<(NestedRim, Late)> = (0..grid.len()).map(|i| nested(&field, grid, grid.tile(i))).collect();
        let mut levels: BTreeMap<Place, f64> = BTreeMap::new();
        for (place, level) in all.iter().flat_map(|(_, late)| late) {
            prop_assert_eq!(*levels.entry(*place).or_insert(*level), *level, "{:?}", place);
        }
        // Whoever has a vertex there has it late.
        let mut owners: BTreeMap<Place, usize> = BTreeMap::new();
        for (index, (found, late)) in all.iter().enumerate() {
            let window = grid.window(grid.tile(index));
            let place = |v: &Vertex| v.at.sample().map(|(c, r)| (window.column + c, window.row + r)).expect("a sample");
            let rim = &found.rim;
            let owned = rim.owned.total() as usize - rim.idle.len();
            let borrowed = owned..owned + rim.foreign.len();
            for (i, vertex) in rim.domain.vertices.iter().enumerate() {
                prop_assert_eq!(late.contains_key(&place(vertex)), levels.contains_key(&place(vertex)));
                *owners.entry(place(vertex)).or_default() += usize::from(!borrowed.contains(&i));
            }
            rim.idle.iter().for_each(|(_, v)| *owners.entry(place(v)).or_default() += 1);
        }
        prop_assert!(owners.values().all(|count| *count == 1), "{:?}", owners);
    }
}
