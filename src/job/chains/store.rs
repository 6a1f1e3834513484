//! The edges of chains, put away by bands of tiles and found again by window.

use std::sync::Arc;

use super::Band;
use crate::base::external::{Scratch, ScratchError, Shelves};
use crate::base::lattice::STEPS;
use crate::base::tiling::TileGrid;
use crate::base::{LineEdge, LineType, Window};
use crate::job::lines::Lines;
use crate::kernel::breaklines::{ChainCounts, Chains, End, Inside, Place, PlacedEdge, SetBits, TileChains, type_of};

/// The edges of all chains. Those of a band lie in lists by their lower ends, as many columns in each, and so do the ends.
///
/// Memory: [`ChainStore::IN_MEMORY`] and some 100 bytes for each list that is not empty; what is more is in a temporary file.
#[derive(Debug)]
pub(in crate::job) struct ChainStore {
    grid: TileGrid,
    bands: Vec<Band>,
    edges: Shelves<7>,
    ends: Shelves<3>,
    /// For each set of lines.
    counts: Vec<ChainCounts>,
    /// The sets whose lines are soft.
    soft: SetBits,
    /// How many edges there are, each once.
    distinct: u64,
    /// How many of them follow soft lines alone.
    soft_edges: u64,
    /// Where the mesh is to be, if that is not all of the ground.
    inside: Option<Arc<Inside>>,
    /// The ends on the line to the next band.
    on_line: Vec<End>,
}

/// Columns of the lattice whose edges are in one list.
const COLUMNS: i64 = 256 * STEPS as i64;

impl ChainStore {
    /// How many bytes of edges are held in memory; tests go to the file.
    const IN_MEMORY: usize = if cfg!(test) { 4 << 10 } else { 8 << 20 };

    pub(super) fn new(grid: TileGrid, bands: Vec<Band>, lines: &Lines, scratch: Scratch) -> ChainStore {
        ChainStore {
            grid,
            bands,
            edges: Shelves::new(scratch.clone(), Self::IN_MEMORY * 7 / 10),
            ends: Shelves::new(scratch, Self::IN_MEMORY * 3 / 10),
            counts: vec![ChainCounts::default(); lines.set_count()],
            soft: lines.soft_sets(),
            distinct: 0,
            soft_edges: 0,
            inside: lines.inside().cloned(),
            on_line: Vec::new(),
        }
    }

    /// Puts the chains of a band away; bands come in their order.
    pub(super) fn put(
        &mut self,
        band: usize,
        chains: &Chains,
        lines: &Lines,
        off_ground: &[u64],
    ) -> Result<(), ScratchError> {
        self.counts.iter_mut().zip(off_ground).for_each(|(count, off_ground)| count.off_ground += off_ground);
        for (_, sets) in chains.distinct() {
            let counting = lines.counting(sets);
            (0..).zip(&mut self.counts).for_each(|(set, count)| count.edges += u64::from(counting >> set & 1));
            self.distinct += 1;
            self.soft_edges += u64::from(type_of(sets, self.soft) == LineType::Soft);
        }
        let list = |place: Place| (band as u32, (place.x / COLUMNS) as u32);
        let mut edges: Vec<_> = chains.edges().iter().map(|edge| (list(edge.ends[0].0), edge_record(edge))).collect();
        // Lists keep their order.
        edges.sort_by_key(|(list, _)| *list);
        put_all(&mut self.edges, &edges)?;

        let end = self.bands[band].places.end;
        let mut ends = std::mem::take(&mut self.on_line);
        ends.extend_from_slice(chains.ends());
        ends.sort_unstable_by_key(|end| end.0);
        ends.dedup_by_key(|end| end.0);
        self.on_line = ends.split_off(ends.partition_point(|(place, _)| place.y < end));
        let mut ends: Vec<_> = ends.iter().map(|&end| (list(end.0), end_record(end))).collect();
        ends.sort_by_key(|(list, _)| *list);
        put_all(&mut self.ends, &ends)
    }

    /// How many edges each set of lines has, and what of it has none. An edge may be of several.
    pub(in crate::job) fn counts(&self) -> &[ChainCounts] {
        &self.counts
    }

    /// How many edges there are, each once.
    pub(in crate::job) fn distinct(&self) -> u64 {
        self.distinct
    }

    /// How many of these follow soft lines alone.
    pub(in crate::job) fn soft(&self) -> u64 {
        self.soft_edges
    }

    /// The edges of a band along lines, each once ([`Chains::along_lines`]).
    pub(in crate::job) fn along_lines(&self, chains: &Chains) -> Vec<LineEdge<u32>> {
        chains.along_lines(self.soft)
    }

    /// Where temporary files are made.
    pub(in crate::job) fn scratch(&self) -> &Scratch {
        self.edges.scratch()
    }

    /// The edges of one band after the other.
    pub(in crate::job) fn by_band(&self) -> impl Iterator<Item = Result<Chains, ScratchError>> {
        (0..self.bands.len() as u32).map(|band| {
            let mut records = Vec::new();
            self.edges.row(band).try_for_each(|list| self.edges.get(list, &mut records))?;
            Ok(Chains::of(records.iter().map(edge_of).collect()))
        })
    }

    /// The edges that lie in a window, rim included, and all ends of edges that do, those of edges outside among them. Replaces what is
    /// in `found`.
    pub(in crate::job) fn within(&self, window: Window, found: &mut TileChains) -> Result<(), ScratchError> {
        let lists = self.lists(window);
        let mut records = Vec::new();
        lists.iter().try_for_each(|&list| self.edges.get(list, &mut records))?;
        let mut edges: Vec<PlacedEdge> = records.iter().map(edge_of).collect();
        edges.sort_by_key(|edge| edge.ends.map(|end| end.0));
        let ends = self.ends_of(&lists)?;
        found.fill(window, self.inside.as_ref(), edges.into_iter(), ends.into_iter());
        Ok(())
    }

    /// The ends of edges in a window and some others, each once, in their order.
    pub(in crate::job) fn ends_near(&self, window: Window) -> Result<Vec<End>, ScratchError> {
        self.ends_of(&self.lists(window))
    }

    fn ends_of(&self, lists: &[(u32, u32)]) -> Result<Vec<End>, ScratchError> {
        let mut records = Vec::new();
        lists.iter().try_for_each(|&list| self.ends.get(list, &mut records))?;
        let mut ends: Vec<End> = records.iter().map(|&[y, x, height]| end_of([y, x, height])).collect();
        ends.sort_unstable_by_key(|end| end.0);
        Ok(ends)
    }

    /// The lists of edges whose lower ends may be in a window.
    fn lists(&self, window: Window) -> Vec<(u32, u32)> {
        let row = |row: usize| self.grid.index(self.grid.owner(0, row)) / self.grid.columns();
        let bands = [window.row, window.row + window.height - 1].map(|sample| {
            let row = row(sample);
            self.bands.partition_point(|band| band.rows.end <= row) as u32
        });
        let columns = [window.column, window.column + window.width - 1]
            .map(|column| (column as i64 * i64::from(STEPS) / COLUMNS) as u32);
        (bands[0]..=bands[1]).flat_map(|band| (columns[0]..=columns[1]).map(move |column| (band, column))).collect()
    }
}

fn put_all<const N: usize>(shelves: &mut Shelves<N>, records: &[((u32, u32), [u64; N])]) -> Result<(), ScratchError> {
    for list in records.chunk_by(|a, b| a.0 == b.0) {
        let records: Vec<[u64; N]> = list.iter().map(|(_, record)| *record).collect();
        shelves.put(list[0].0, &records)?;
    }
    Ok(())
}

fn end_record((place, height): End) -> [u64; 3] {
    [place.y as u64, place.x as u64, height.to_bits()]
}

fn end_of([y, x, height]: [u64; 3]) -> End {
    (Place { y: y as i64, x: x as i64 }, f64::from_bits(height))
}

/// What it has to its left is 0 where that is unknown, else 1 or 2.
fn edge_record(edge: &PlacedEdge) -> [u64; 7] {
    let [a, b] = edge.ends.map(end_record);
    let inside = edge.inside.map_or(0, |is_left| 1 + u64::from(is_left));
    [a[0], a[1], a[2], b[0], b[1], b[2], inside << 8 | u64::from(edge.sets)]
}

fn edge_of(record: &[u64; 7]) -> PlacedEdge {
    let &[y, x, height, to_y, to_x, to_height, rest] = record;
    let inside = [None, Some(false), Some(true)][(rest >> 8) as usize];
    PlacedEdge { ends: [end_of([y, x, height]), end_of([to_y, to_x, to_height])], sets: rest as u8, inside }
}
