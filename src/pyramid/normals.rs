//! Normals at vertices, for light: from differences of heights around a sample of the finest grid, so that tiles of a level that
//! share a vertex have the same.

use super::Body;
use super::body::{Angle, Vector};
use super::error::PyramidError;
use super::samples::{Block, Patch, Samples};
use super::surface::Surface;

/// Differences reach over one part in this number of a tile's side: neither so far that slopes are lost, nor so near that they are
/// noise.
const REACH: i64 = 128;

/// A normal at every vertex of a tile, in the order of its vertices, as the two bytes of the octahedral encoding.
pub(super) fn encoded(
    body: &Body,
    samples: &Samples,
    surface: &Surface,
    block: &mut Block,
) -> Result<Vec<[u8; 2]>, PyramidError> {
    let cells = samples.grid.cells(surface.tile.level);
    let reach = (cells / REACH).max(1);
    let origin = surface.tile.origin(samples.grid);
    let mut found = Vec::with_capacity(surface.vertices.len());
    for vertex in &surface.vertices {
        let (column, row) = (origin.0 + vertex.sample.0, origin.1 + vertex.sample.1);
        let (lon, lat) = (Angle::of(samples.grid.longitude(column)), Angle::of(samples.grid.latitude(row)));
        let (east_metres, north_metres) = body.metres_in_degree(lat);
        let mut slope = |east: i64, south: i64, metres: f64| {
            let patch = Patch {
                column: column - reach * east,
                row: row - reach * south,
                width: 1 + 2 * east as usize,
                height: 1 + 2 * south as usize,
                step: reach,
            };
            samples.read(patch, block)?;
            let known: Vec<usize> = (0..3).filter(|&i| block.inside[i]).collect();
            let run = metres * samples.grid.cell() * reach as f64;
            // Across the raster's border there is no slope.
            Ok::<f64, PyramidError>(match (known.first(), known.last()) {
                (Some(&a), Some(&b)) if a < b && run > 0.0 => {
                    (block.heights[b] - block.heights[a]) / ((b - a) as f64 * run)
                }
                _ => 0.0,
            })
        };
        let (to_east, to_south) = (slope(1, 0, east_metres)?, slope(0, 1, north_metres)?);
        let up = Body::normal(lon, lat);
        let east = [-lon.sin, lon.cos, 0.0];
        let north = [-lat.sin * lon.cos, -lat.sin * lon.sin, lat.cos];
        let direction: Vector = std::array::from_fn(|i| up[i] - to_east * east[i] + to_south * north[i]);
        found.push(octahedral(direction));
    }
    Ok(found)
}

/// A direction on the octahedron that is unfolded to a square, in steps from 0 to 255 (Cigolle et al. 2014, section 3.2).
fn octahedral(direction: Vector) -> [u8; 2] {
    let size = direction.iter().map(|d| d.abs()).sum::<f64>();
    let [x, y, z] = direction.map(|d| d / size);
    let sign = |d: f64| if d < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = if z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    [x, y].map(|d| ((d * 0.5 + 0.5) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::body::{dot, length};
    use proptest::prelude::*;

    /// The direction that two bytes stand for, of length 1.
    fn decoded([x, y]: [u8; 2]) -> Vector {
        let [mut x, mut y] = [x, y].map(|b| f64::from(b) / 255.0 * 2.0 - 1.0);
        let z = 1.0 - x.abs() - y.abs();
        if z < 0.0 {
            let sign = |d: f64| if d < 0.0 { -1.0 } else { 1.0 };
            (x, y) = ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y));
        }
        let size = length([x, y, z]);
        [x / size, y / size, z / size]
    }

    proptest! {
        #[test]
        fn directions_come_back(x in -1.0f64..1.0, y in -1.0f64..1.0, z in -1.0f64..1.0) {
            let size = length([x, y, z]);
            prop_assume!(size > 0.1);
            let cosine = dot(decoded(octahedral([x, y, z])), [x / size, y / size, z / size]);
            prop_assert!(cosine > 0.9995, "{cosine}");
        }
    }
}
