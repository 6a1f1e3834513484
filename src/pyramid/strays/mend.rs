//! Edges that stray are mended.

use std::collections::HashMap;

use super::Straightness;
use crate::pyramid::error::PyramidError;
use crate::pyramid::grid::TileKey;
use crate::pyramid::lines::Vertex;
use crate::pyramid::part::{Part, Place};
use crate::pyramid::samples::Patch;
use crate::pyramid::surface::Surface;
use crate::pyramid::tile::{LevelTask, TileMaker, renew};

/// What has come of edges that stray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::pyramid) enum Straightened {
    /// None does that counts.
    Kept,
    /// Parts have changed.
    Mended,
    /// Nothing helps.
    Stuck,
}

impl LevelTask<'_> {
    /// Mends edges that stray, those that may among them if that is asked for.
    pub(in crate::pyramid) fn straighten(
        &self,
        tile: TileKey,
        (surface, max_error): (&Surface, f64),
        parts: &mut [Part],
        place: &dyn Fn(i64) -> Place,
        with_free: bool,
        maker: &mut TileMaker,
    ) -> Result<Straightened, PyramidError> {
        let limit = self.max_stray * self.level.max_error;
        if limit == f64::INFINITY || self.samples.own.is_some() {
            return Ok(Straightened::Kept);
        }
        let Place { tile_cells, cells: part_cells, snap, .. } = place(0);
        let (body, samples, cancel) = (self.body, self.samples, self.cancel);
        let straightness = Straightness { body, samples, limit, max_error, part_cells, cancel };
        let mut strays = straightness.find(surface, &mut maker.block)?;
        strays.retain(|stray| with_free || !stray.is_free);
        let counts = strays.iter().any(|stray| !stray.is_free);
        let mut wanted: Vec<(u32, Vertex)> = Vec::new();
        let mut blocked: Vec<(u32, Vertex)> = Vec::new();
        let mut taken: HashMap<u32, HashMap<(i64, i64), usize>> = HashMap::new();
        let origin = tile.origin(samples.grid);
        for &stray in &strays {
            let (part, place) = (&parts[stray.owner as usize], place(i64::from(stray.owner)));
            let taken = taken.entry(stray.owner).or_insert_with(|| part.places(tile_cells));
            let mut ways = Vec::new();
            for (column, row) in stray.side.map(|(column, row)| (column / snap * snap, row / snap * snap)) {
                let patch = Patch { column: origin.0 + column, row: origin.1 + row, width: 1, height: 1, step: 1 };
                samples.read(patch, &mut maker.block)?;
                let (height, is_inside) = (maker.block.heights[0], maker.block.inside[0]);
                let vertex = self.at_rim(tile, Vertex::of_sample(column, row, height), &mut maker.block)?;
                let is_free = !taken.contains_key(&vertex.coordinates(tile_cells));
                ways.extend((is_inside && is_free && place.has_inside(&vertex)).then_some((stray.owner, vertex)));
            }
            match ways.first() {
                Some(way) => wanted.push(*way),
                None if !stray.is_free => blocked.push((stray.owner, Vertex::default())),
                None => {}
            }
        }
        let mut is_mended = self.insert(wanted, parts, place, maker)?;
        is_mended |= renew(parts, &blocked, place, maker);
        Ok(match is_mended {
            true => Straightened::Mended,
            false if counts => Straightened::Stuck,
            false => Straightened::Kept,
        })
    }
}
