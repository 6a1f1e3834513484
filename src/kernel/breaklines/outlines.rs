//! What outlines among the lines bound: lakes, and the inside of a cutline.

use super::lakes::{Lakes, odd};
use super::pieces::Piece;
use super::{Inside, LinesError};
use crate::base::{LineKind, LineSet};

/// The inside of the outlines that the mesh ends at, whose pieces are noded; `None` where there are none. Pieces that are not on its border
/// are taken away, and those on the raster's rim.
pub(super) fn take_inside(asked: &[LineSet], pieces: &mut Vec<Piece>, size: (usize, usize)) -> Option<Inside> {
    let (number, set) = (0u8..).zip(asked).find(|(_, set)| set.kind == LineKind::Cutline)?;
    let mut polygons: Vec<u64> = (0..set.lines.lines().len()).map(|line| set.lines.feature(line)).collect();
    let of_line = polygons.clone();
    polygons.sort_unstable();
    polygons.dedup();
    let polygon = |line: u32| polygons.binary_search(&of_line[line as usize]).expect("one of all") as u32;
    let outlines = pieces.iter().filter(|piece| piece.set == number);
    let (inside, border) = Inside::new(outlines.map(|piece| (piece.ends, polygon(piece.line), piece.times)), size);
    pieces.retain(|piece| piece.set != number || border.binary_search(&piece.ends).is_ok());
    Some(inside)
}

/// The lakes of all sets, whose pieces are noded. Each feature is one, with the height of its outline. Pieces that bound no lake are
/// taken away.
pub(super) fn take_lakes(asked: &[LineSet], pieces: &mut Vec<Piece>) -> Result<Lakes, LinesError> {
    let Some((number, set)) = (0u8..).zip(asked).find(|(_, set)| set.kind == LineKind::Lakes) else {
        return Ok(Lakes::default());
    };
    let heights = set.lines.heights().unwrap_or_default();
    let height = |line: usize| heights.get(line).and_then(|heights| heights.first()).copied();
    let mut lakes: Vec<(u64, f64)> = Vec::new();
    let mut of_line = Vec::new();
    for line in 0..set.lines.lines().len() {
        let feature = set.lines.feature(line);
        // Parts of a feature follow each other.
        if lakes.last().is_none_or(|(last, _)| *last != feature) {
            lakes.push((feature, height(line).unwrap_or(0.0)));
        }
        of_line.push(lakes.len() as u32 - 1);
    }
    let lake = |piece: &Piece| (piece.set == number).then(|| of_line[piece.line as usize]);
    let outlines = |pieces: &[Piece]| {
        let sides = pieces.iter().filter_map(|piece| Some((piece.ends, lake(piece)?, piece.times)));
        sides.collect::<Vec<_>>().into_iter()
    };
    let odd = odd(outlines(pieces));
    pieces.retain(|piece| lake(piece).is_none_or(|lake| odd.binary_search(&(piece.ends, lake)).is_ok()));
    Lakes::new(lakes, outlines(pieces))
}
