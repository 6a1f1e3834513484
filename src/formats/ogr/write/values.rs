//! The attributes of vertices, until the triangles come that have them at their corners.

use std::fs::File;

use crate::base::control::CancelToken;
use crate::base::external::{Scratch, ScratchError};
use std::path::Path;

/// Numbers in a block that is read at once, at most.
const BLOCK: usize = 4096;

/// Blocks that are kept: triangles name vertices near those that triangles before them have named.
const BLOCKS: usize = 128;

/// The values of all vertices, in a temporary file of 8 bytes a value. Memory: 4 MiB.
#[derive(Debug)]
pub(super) struct Values {
    scratch: Scratch,
    file: File,
    /// Values of a vertex.
    width: usize,
    /// Vertices in a block.
    vertices_of_block: u64,
    vertices: u64,
    blocks: Vec<Option<(u64, Vec<[u64; 1]>)>>,
}

impl Values {
    pub(super) fn new(width: usize, temp_dir: Option<&Path>, cancel: CancelToken) -> Result<Values, ScratchError> {
        let scratch = Scratch::new(temp_dir, cancel);
        let file = scratch.file()?;
        let vertices_of_block = (BLOCK / width).max(1) as u64;
        Ok(Values { scratch, file, width, vertices_of_block, vertices: 0, blocks: vec![None; BLOCKS] })
    }

    /// The values of the next vertices, attribute by attribute.
    pub(super) fn push(&mut self, count: usize, attributes: &[&[f64]]) -> Result<(), ScratchError> {
        for first in (0..count).step_by(BLOCK) {
            let rows = first..count.min(first + BLOCK);
            let records: Vec<[u64; 1]> =
                rows.flat_map(|i| attributes.iter().map(move |values| [values[i].to_bits()])).collect();
            self.scratch.write(&self.file, &records)?;
        }
        self.vertices += count as u64;
        Ok(())
    }

    /// Adds the values of a vertex to `values`.
    pub(super) fn get(&mut self, vertex: u64, values: &mut Vec<f64>) -> Result<(), ScratchError> {
        assert!(vertex < self.vertices, "vertex {vertex} of {}", self.vertices);
        let (block, place) = (vertex / self.vertices_of_block, (vertex % self.vertices_of_block) as usize * self.width);
        let slot = &mut self.blocks[(block % BLOCKS as u64) as usize];
        let records = match slot {
            Some((found, records)) if *found == block => records,
            _ => {
                let first = block * self.vertices_of_block;
                let count = self.vertices_of_block.min(self.vertices - first) as usize * self.width;
                let mut records = vec![[0]; count];
                self.scratch.read(&self.file, first * self.width as u64, &mut records)?;
                &mut slot.insert((block, records)).1
            }
        };
        values.extend(records[place..place + self.width].iter().map(|[bits]| f64::from_bits(*bits)));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vertex_finds_its_values() {
        for width in [1, 3, 5000] {
            let mut values = Values::new(width, None, CancelToken::default()).expect("a file");
            let count = if width > 100 { 5 } else { 700_000 / width };
            let of = |vertex: usize, attribute: usize| (vertex * 7 + attribute) as f64;
            let all: Vec<Vec<f64>> = (0..width).map(|a| (0..count).map(|v| of(v, a)).collect()).collect();
            for half in [0..count / 2, count / 2..count] {
                let slices: Vec<&[f64]> = all.iter().map(|a| &a[half.clone()]).collect();
                values.push(half.len(), &slices).expect("written");
            }
            for vertex in (0..count).rev().step_by(3).chain([0, count - 1]) {
                let mut found = Vec::new();
                values.get(vertex as u64, &mut found).expect("read");
                assert!((0..width).all(|a| found[a] == of(vertex, a)), "{vertex}");
            }
        }
    }
}
