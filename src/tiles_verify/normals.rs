//! Normals of a tile's vertices: whether each is the one nearest to the ground's that its two bytes can say.
//!
//! The ground's normal at a sample of the grid is 𝑢 − 𝑒 · east − 𝑛 · north, of which 𝑢 is the ellipsoid's, and 𝑒 and 𝑛 are slopes. A slope is that between
//! the samples a 128th of the tile's side to either side, one cell at the least; where the raster gives one of them no height, between the other and
//! the sample itself, and where it gives fewer than two of the three one, it is 0. A vertex has the normal of the sample nearest to it. Where the raster's own
//! samples are vertices, one in the middle between two samples, give or take a step of the lattice, has that of either.

use super::decode::LAST;
use super::ellipsoid::{Meridian, Point, across, times};
use super::findings::{Findings, Kind};
use super::tile::Tile;
use crate::pyramid::{Patch, PyramidError, SampleBlock, Samples};

/// Slopes reach so far, in parts of a tile's side.
const REACH: i64 = 128;

/// How far a byte may be from what it rounds, in steps: half of one, and what doubles are off by.
const ROUNDED: f64 = 0.5 + 1e-6;

/// What is as near to a plane through two axes, in shares of a direction, may be on either side.
const ON_PLANE: f64 = 1e-9;

/// The places on the unfolded octahedron of a direction, in steps from 0 to 255: one, or more where it is folded.
fn octahedral(direction: Point) -> impl Iterator<Item = [f64; 2]> {
    let size: f64 = direction.iter().map(|c| c.abs()).sum();
    let [x, y, z] = direction.map(|c| c / size);
    let signs =
        move |c: f64| [1.0, -1.0].into_iter().filter(move |sign| sign * c >= 0.0 || z < 0.0 && c.abs() < ON_PLANE);
    signs(x).flat_map(move |across| signs(y).map(move |up| (across, up))).map(move |(across, up)| {
        let place = if z < 0.0 { [(1.0 - y.abs()) * across, (1.0 - x.abs()) * up] } else { [x, y] };
        place.map(|c| 127.5 * (c + 1.0))
    })
}

/// The direction, of length 1, that two bytes say.
fn direction(code: [u8; 2]) -> Point {
    let [x, y] = code.map(|byte| f64::from(byte) / 127.5 - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let below = (-z).max(0.0);
    let found = [x - below.copysign(x), y - below.copysign(y), z];
    found.map(|c| c / times(found, found).sqrt())
}

/// The angle between a direction and one of length 1, in degrees.
fn angle(of: Point, to: Point) -> f64 {
    let aside = across(of, to);
    times(aside, aside).sqrt().atan2(times(of, to)).to_degrees()
}

/// Whether two bytes say a direction as nearly as they can.
fn says(code: [u8; 2], expected: Point) -> bool {
    octahedral(expected).any(|at| (0..2).all(|k| (f64::from(code[k]) - at[k]).abs() <= ROUNDED))
}

impl Tile<'_> {
    /// Judges the normals of all vertices.
    pub(super) fn judge_normals(
        &self,
        samples: &Samples,
        own_samples: bool,
        block: &mut SampleBlock,
        findings: &mut Findings,
    ) -> Result<(), PyramidError> {
        for (vertex, &code) in self.decoded.normals.iter().flatten().enumerate() {
            let [u, v, _] = self.decoded.vertices[vertex];
            let (columns, rows) = (self.samples_near(u, own_samples), self.samples_near(LAST - v, own_samples));
            let mut nearest = f64::INFINITY;
            for (&column, &row) in columns.iter().flat_map(|column| rows.iter().map(move |row| (column, row))) {
                let expected = self.normal_of_ground(column, row, samples, block)?;
                if says(code, expected) {
                    nearest = 0.0;
                    break;
                }
                nearest = nearest.min(angle(expected, direction(code)));
            }
            if nearest > 0.0 {
                let (key, (lon, lat)) = (self.key, self.place(f64::from(u), f64::from(v)));
                findings.add(Kind::Normals, || {
                    format!("tile {key}: the normal of vertex {vertex} at {lon}°, {lat}° is {nearest}° from that of the ground")
                });
            }
        }
        Ok(())
    }

    /// The column, or the row from the north, of the sample nearest to a coordinate; of both if it is in the middle and a vertex need not stand on a sample.
    fn samples_near(&self, coordinate: u16, anywhere: bool) -> Vec<i64> {
        let nearest = self.sample(coordinate);
        let cells = self.grid.cells(self.key.level);
        let (apart, step) = (self.samples_apart(), cells as f64 / f64::from(LAST));
        let off = f64::from(coordinate) * step - nearest as f64;
        let is_in_middle = anywhere && off.abs() >= 0.5 * apart as f64 - step;
        let other = is_in_middle.then(|| nearest + apart * off.signum() as i64).filter(|at| (0..=cells).contains(at));
        [nearest].into_iter().chain(other).collect()
    }

    /// The ground's normal at a sample of the tile.
    fn normal_of_ground(
        &self,
        column: i64,
        row: i64,
        samples: &Samples,
        block: &mut SampleBlock,
    ) -> Result<Point, PyramidError> {
        let origin = self.key.origin(self.grid);
        let (column, row) = (origin.0 + column, origin.1 + row);
        let reach = (self.grid.cells(self.key.level) / REACH).max(1);
        let meridian = Meridian::of(self.grid.longitude(column));
        let parallel = self.ellipsoid.parallel(self.grid.latitude(row));
        let cell = self.grid.cell().to_radians() * reach as f64;
        let mut slope = |patch: Patch, metres: f64| {
            samples.read(patch, block)?;
            let has = &block.inside;
            let between =
                |from: usize, to: usize| (block.heights[to] - block.heights[from]) / ((to - from) as f64 * metres);
            Ok::<f64, PyramidError>(match (has[0], has[1], has[2]) {
                (true, _, true) => between(0, 2),
                (true, true, false) => between(0, 1),
                (false, true, true) => between(1, 2),
                _ => 0.0,
            })
        };
        let patch = Patch { column, row, width: 1, height: 1, step: reach };
        let to_east = slope(Patch { column: column - reach, width: 3, ..patch }, parallel.reach * cell)?;
        let along_meridian = self.ellipsoid.along_meridian(&parallel);
        let to_south = slope(Patch { row: row - reach, height: 3, ..patch }, along_meridian * cell)?;
        let (up, east, north) = parallel.directions(meridian);
        Ok(std::array::from_fn(|k| up[k] - to_east * east[k] + to_south * north[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Of all that two bytes can say, what they say is nearest on the octahedron, and less than a degree away.
        #[test]
        fn codes_say_what_they_round(x in -1.0f64..1.0, y in -1.0f64..1.0, z in -1.0f64..1.0, bit in 0u32..16) {
            let size = times([x, y, z], [x, y, z]).sqrt();
            prop_assume!(size > 0.1);
            let expected = [x / size, y / size, z / size];
            let code = octahedral(expected).next().expect("a place").map(|c| c.round() as u8);
            prop_assert!(says(code, expected) && angle(direction(code), expected) < 1.0, "{code:?}");
            let word = u16::from_le_bytes(code) ^ (1u16 << bit);
            let off = octahedral(expected).next().expect("a place").map(|c| (c - c.floor() - 0.5).abs());
            prop_assume!(off.iter().all(|off| *off > 0.01));
            prop_assert!(!says(word.to_le_bytes(), expected), "{code:?}, {word:x}");
        }
    }

    /// Where the octahedron is folded, either side is right.
    #[test]
    fn folds_have_two_sides() {
        for expected in [[0.6, 0.0, -0.8], [0.6, 1e-17, -0.8], [0.6, -1e-17, -0.8]] {
            let codes: Vec<[u8; 2]> = octahedral(expected).map(|at| at.map(|c| c.round() as u8)).collect();
            assert_eq!(codes.len(), 2);
            for code in codes {
                assert!(angle(direction(code), expected) < 1.0 && says(code, expected), "{code:?}");
            }
        }
        assert_eq!(octahedral([0.0, 0.0, -1.0]).count(), 4);
        assert!(octahedral([0.6, 0.0, 0.8]).all(|at| at == [127.5 * (1.0 + 0.6 / 1.4), 127.5]));
    }
}
