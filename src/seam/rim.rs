use std::ops::Range;

use super::{MinLink, WeightedLine};
use crate::control::{CancelToken, Cancelled};
use crate::field::Tile;
use crate::lattice::Point;
use crate::mesh::{Domain, Vertex};

/// The rim of a tile: its corners and the vertices of its four sides, as the domain of an engine.
///
/// Vertices that the tile owns come first, so that their number is their place among the tile's own: the corners
/// (north-west, then north-east, south-west, south-east), then the sides (north, west, east, south), each from the
/// lower coordinate to the higher. Vertices owned by a neighbour follow.
#[derive(Debug, Clone, Default)]
pub struct Rim {
    /// What is to be triangulated: one loop.
    pub domain: Domain,
    /// How many of which kind the tile owns.
    pub owned: RimCounts,
    /// The others, in the domain's order.
    pub foreign: Vec<Foreign>,
}

/// How many vertices of its rim a tile owns, by kind. A tile owns its north and west side and the corner between; the
/// last column owns its east side too, the last row its south side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RimCounts {
    /// Corners.
    pub corners: u32,
    /// Vertices between the corners of the north side.
    pub north: u32,
    /// Of the west side.
    pub west: u32,
    /// Of the east side, in the last column.
    pub east: u32,
    /// Of the south side, in the last row.
    pub south: u32,
}

impl RimCounts {
    /// All of them.
    pub fn total(&self) -> u32 {
        self.corners + self.north + self.west + self.east + self.south
    }
}

/// A rim vertex that a neighbour owns. Ordinals count the vertices of a side from its lower coordinate, corners apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foreign {
    /// The corner at the end of the north side.
    NorthEast,
    /// The corner at the end of the west side.
    SouthWest,
    /// The corner opposite the tile's own.
    SouthEast,
    /// On the east side: the west side of the next tile.
    East(u32),
    /// On the south side: the north side of the tile below.
    South(u32),
}

impl Rim {
    /// Computes the rim of `tile`, each side from its own samples alone. `last_column` and `last_row` say whether the
    /// tile lies at the raster's right and lower rim.
    ///
    /// Every vertex keeps the height of its sample; every link is within `tolerance` at the samples it passes, and where
    /// the tile has channels its weighted error is within [`ChannelError::limit`].
    ///
    /// [`ChannelError::limit`]: crate::channels::ChannelError::limit
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        tile: &Tile,
        tolerance: f64,
        (last_column, last_row): (bool, bool),
        min_link: &mut MinLink,
        cancel: &CancelToken,
    ) -> Result<Rim, Cancelled> {
        let (right, bottom) = (tile.width() - 1, tile.height() - 1);
        let mut line = Vec::with_capacity(tile.width().max(tile.height()));
        let mut channels = vec![Vec::new(); tile.channels.len()];
        let mut side = |len: usize, place: &dyn Fn(usize) -> (usize, usize)| -> Result<Vec<Vertex>, Cancelled> {
            line.clear();
            line.extend((0..len).map(|i| tile.at(place(i).0, place(i).1)));
            let path = match &tile.channel_error {
                None => min_link.path(&line, tolerance, &[], cancel)?,
                Some(error) => {
                    for (channel, values) in channels.iter_mut().enumerate() {
                        values.clear();
                        values.extend((0..len).map(|i| tile.channel_at(channel, place(i).0, place(i).1)));
                    }
                    let channels = WeightedLine { error, channels: &channels };
                    min_link.path_weighted(&line, channels, tolerance, &[], cancel)?
                }
            };
            Ok(path[1..path.len() - 1].iter().map(|&i| vertex(tile, place(i))).collect())
        };
        let north = side(tile.width(), &|i| (i, 0))?;
        let south = side(tile.width(), &|i| (i, bottom))?;
        let west = side(tile.height(), &|i| (0, i))?;
        let east = side(tile.height(), &|i| (right, i))?;

        let corner = |column, row| vec![vertex(tile, (column, row))];
        let mine = |_| unreachable!("every tile owns its first corner, its north and its west side");
        // In the order in which a tile numbers what it owns.
        let features: [Feature; 8] = [
            Feature { vertices: corner(0, 0), owned: true, name: mine },
            Feature { vertices: corner(right, 0), owned: last_column, name: |_| Foreign::NorthEast },
            Feature { vertices: corner(0, bottom), owned: last_row, name: |_| Foreign::SouthWest },
            Feature { vertices: corner(right, bottom), owned: last_column && last_row, name: |_| Foreign::SouthEast },
            Feature { vertices: north, owned: true, name: mine },
            Feature { vertices: west, owned: true, name: mine },
            Feature { vertices: east, owned: last_column, name: Foreign::East },
            Feature { vertices: south, owned: last_row, name: Foreign::South },
        ];
        let (mut vertices, mut foreign) = (Vec::new(), Vec::new());
        let mut numbers: [Range<u32>; 8] = Default::default();
        for round_of_owned in [true, false] {
            for (number, feature) in numbers.iter_mut().zip(&features).filter(|(_, f)| f.owned == round_of_owned) {
                *number = vertices.len() as u32..(vertices.len() + feature.vertices.len()) as u32;
                vertices.extend_from_slice(&feature.vertices);
                if !feature.owned {
                    foreign.extend((0..feature.vertices.len() as u32).map(feature.name));
                }
            }
        }
        let owned = |i: usize| if features[i].owned { features[i].vertices.len() as u32 } else { 0 };
        let owned = RimCounts {
            corners: (0..4).map(owned).sum(),
            north: owned(4),
            west: owned(5),
            east: owned(6),
            south: owned(7),
        };
        // North side eastwards, east side down, south side back, west side up: the ground stays to the left.
        let [nw, ne, sw, se, north, west, east, south] = numbers;
        let there = nw.chain(north).chain(ne).chain(east);
        let walk = there.chain(se).chain(south.rev()).chain(sw).chain(west.rev()).collect();
        Ok(Rim { domain: Domain { vertices, loops: vec![walk] }, owned, foreign })
    }
}

/// A corner or the inside of a side.
struct Feature {
    vertices: Vec<Vertex>,
    owned: bool,
    /// What a vertex is called where it is not owned, by its ordinal.
    name: fn(u32) -> Foreign,
}

fn vertex(tile: &Tile, (column, row): (usize, usize)) -> Vertex {
    Vertex { at: Point::of_sample(column as i32, row as i32), height: tile.at(column, row) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Heights;

    fn bumpy(width: usize, height: usize) -> Tile {
        let heights = (0..width * height).map(|i| ((i * 2_654_435_761) >> 7 & 15) as f32).collect();
        Tile::from_heights(width, height, Heights::F32(heights))
    }

    fn rim(tile: &Tile, last: (bool, bool)) -> Rim {
        Rim::new(tile, 3.0, last, &mut MinLink::default(), &CancelToken::default()).expect("nobody cancels")
    }

    #[test]
    fn the_loop_goes_around_the_tile_with_the_ground_to_its_left() {
        let tile = bumpy(13, 9);
        for last in [(false, false), (true, false), (false, true), (true, true)] {
            let rim = rim(&tile, last);
            assert_eq!(rim.domain.area(), 2 * 16 * 12 * 8);
            assert_eq!(rim.owned.total() as usize + rim.foreign.len(), rim.domain.vertices.len());
            assert_eq!(rim.domain.loops[0].len(), rim.domain.vertices.len());
            let mut places: Vec<Point> = rim.domain.vertices.iter().map(|v| v.at).collect();
            places.sort();
            places.dedup();
            assert_eq!(places.len(), rim.domain.vertices.len());
        }
    }

    #[test]
    fn neighbours_agree_on_their_seam() {
        let left = bumpy(13, 9);
        // The right neighbour's west side has the same samples as the left one's east side.
        let mut heights = vec![0.0; 13 * 9];
        (0..9).for_each(|row| heights[row * 13] = left.at(12, row) as f32);
        let right = Tile::from_heights(13, 9, Heights::F32(heights));
        let (a, b) = (rim(&left, (false, false)), rim(&right, (true, false)));
        let at = |i: u32| b.domain.vertices[(b.owned.corners + b.owned.north + i) as usize];
        let borrowed = a.foreign.iter().zip(&a.domain.vertices[a.owned.total() as usize..]);
        let mut seen = 0;
        for (foreign, vertex) in borrowed {
            if let Foreign::East(ordinal) = foreign {
                assert_eq!((at(*ordinal).at.y, at(*ordinal).height), (vertex.at.y, vertex.height));
                seen += 1;
            }
        }
        assert_eq!(seen, b.owned.west);
    }
}
