use super::VerifyError;
use super::finding::{EdgePlace, Finding, MapPlace};
use super::grid::Grid;
use super::pace::Pace;
use super::scratch::Scratch;
use super::sort::{Sorted, Sorter};
use super::vertices::{Vertex, VertexStore};

/// Bytes of the sort of the rim's edges.
const RIM_BYTES: usize = 4 << 20;

/// How the faces hang together.
#[derive(Debug, Default)]
pub(super) struct EdgeFindings {
    pub(super) unmatched: Finding<EdgePlace>,
    pub(super) overused: Finding<EdgePlace>,
    pub(super) same_direction: Finding<EdgePlace>,
    pub(super) rim_gaps: Finding<MapPlace>,
    pub(super) rim_doubled: Finding<MapPlace>,
}

/// Matches the edges, sorted, of all faces: two faces share an edge in opposite directions, or it lies on the rim.
///
/// A T-junction shows as unmatched edges: the long one on one side, the short ones on the other.
pub(super) fn match_edges(
    edges: Sorted<'_, 3>,
    vertices: &mut VertexStore<'_>,
    grid: &Grid,
    scratch: &Scratch,
    pace: &mut Pace<'_>,
) -> Result<EdgeFindings, VerifyError> {
    let mut found = EdgeFindings::default();
    let mut rim = Sorter::new(scratch, RIM_BYTES);
    let mut edges = edges.peekable();
    while let Some(first) = edges.next() {
        let [low, high, first] = first?;
        let mut uses = [0u64; 2];
        uses[(first & 1) as usize] += 1;
        pace.tick()?;
        while let Some(same) = edges.next_if(|e| !matches!(e, Ok([l, h, _]) if (*l, *h) != (low, high))) {
            uses[(same?[2] & 1) as usize] += 1;
            pace.tick()?;
        }
        if uses == [1, 1] {
            continue;
        }
        let (a, b) = (vertices.get(low)?, vertices.get(high)?);
        let place = || grid.edge((low, a), (high, b));
        match uses[0] + uses[1] {
            1 => match on_rim(grid, a, b) {
                Some(stretch) => rim.push(stretch)?,
                None => found.unmatched.add(place),
            },
            2 => found.same_direction.add(place),
            _ => found.overused.add(place),
        }
    }
    found.follow_rim(grid, rim.finish()?)?;
    Ok(found)
}

/// The sides of the domain: first row, last column, last row, first column.
const SIDES: u64 = 4;

/// `[side, begin, end]` of an edge that lies on the rim, in lattice steps along the side.
fn on_rim(grid: &Grid, a: Vertex, b: Vertex) -> Option<[u64; 3]> {
    let (a, b) = (a.place.filter(|&p| grid.contains(p))?, b.place.filter(|&p| grid.contains(p))?);
    let (far_x, far_y) = grid.far_corner();
    let stretch = |side, from: i64, to: i64| Some([side, from.min(to) as u64, from.max(to) as u64]);
    match (a, b) {
        ((_, 0), (_, 0)) => stretch(0, a.0, b.0),
        _ if a.0 == far_x && b.0 == far_x => stretch(1, a.1, b.1),
        _ if a.1 == far_y && b.1 == far_y => stretch(2, a.0, b.0),
        ((0, _), (0, _)) => stretch(3, a.1, b.1),
        _ => None,
    }
}

impl EdgeFindings {
    /// Checks that the edges on the rim, sorted, lie end to end along each side.
    fn follow_rim(&mut self, grid: &Grid, rim: Sorted<'_, 3>) -> Result<(), VerifyError> {
        let (far_x, far_y) = grid.far_corner();
        let place = |side, along: u64| {
            grid.map(match side {
                0 => (along as i64, 0),
                1 => (far_x, along as i64),
                2 => (along as i64, far_y),
                _ => (0, along as i64),
            })
        };
        let length = |side| if side % 2 == 0 { far_x as u64 } else { far_y as u64 };
        let mut reached = (0, 0);
        for record in rim {
            let [side, begin, end] = record?;
            while reached.0 < side {
                self.close_side(reached.1, length(reached.0), place(reached.0, reached.1));
                reached = (reached.0 + 1, 0);
            }
            if begin > reached.1 {
                self.rim_gaps.add(|| place(side, reached.1));
            }
            if begin < reached.1 {
                self.rim_doubled.add(|| place(side, begin));
            }
            reached.1 = reached.1.max(end);
        }
        while reached.0 < SIDES {
            self.close_side(reached.1, length(reached.0), place(reached.0, reached.1));
            reached = (reached.0 + 1, 0);
        }
        Ok(())
    }

    /// A side that is not followed to its end has a gap there.
    fn close_side(&mut self, reached: u64, length: u64, place: MapPlace) {
        if reached < length {
            self.rim_gaps.add(|| place);
        }
    }
}
