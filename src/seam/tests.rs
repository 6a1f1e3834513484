//! Points on the rims of tiles: what neighbours, who see the same samples and the same points, make of them.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::{Foreign, MinLink, Rim};
use crate::control::CancelToken;
use crate::field::{Heights, Tile};
use crate::lattice::STEPS;
use crate::mesh::Vertex;
use crate::raster::PointSet;
use crate::tiling::{TileGrid, TileId};

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
        let window = self.grid.window(id);
        let place = |i: usize| (window.column + i % window.width, window.row + i / window.width);
        let heights = (0..window.len()).map(|i| self.height(place(i).0, place(i).1)).collect();
        let tile = Tile::from_heights(window.width, window.height, Heights::F64(heights));
        let mut points = Vec::new();
        self.points.within(window, &mut points);
        let last = (self.grid.is_last_column(id), self.grid.is_last_row(id));
        Rim::new(&tile, 4.0, &points, last, &mut MinLink::default(), &CancelToken::default()).expect("nobody cancels")
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
