//! Vertices: duplicate, unused, off the lattice.

use crate::formats::MeshReader;

use super::VerifyError;
use super::finding::{Finding, VertexPlace};
use super::grid::Grid;
use super::pace::Pace;
use super::vertices::{Vertex, VertexStore, VertexWriter};
use crate::base::external::{Scratch, Sorted, Sorter};

/// Bytes of the sort by place.
const PLACE_BYTES: usize = 16 << 20;

/// What is wrong with vertices.
#[derive(Debug, Default)]
pub(super) struct VertexFindings {
    pub(super) off_lattice: Finding<VertexPlace>,
    pub(super) outside: Finding<VertexPlace>,
    pub(super) not_finite: Finding<VertexPlace>,
    pub(super) duplicate: Finding<VertexPlace>,
    pub(super) unused: Finding<VertexPlace>,
}

/// Reads the vertices once: judges each by itself and stores it. Also gives their places, sorted, as `[x, y, vertex]`.
pub(super) fn read_vertices<'s>(
    mesh: &mut dyn MeshReader,
    grid: &Grid,
    scratch: &'s Scratch,
    pace: &mut Pace<'_>,
) -> Result<(VertexFindings, VertexStore<'s>, Sorted<'s, 3>), VerifyError> {
    let mut found = VertexFindings::default();
    let mut store = VertexWriter::new(scratch)?;
    let mut places = Sorter::new(scratch, PLACE_BYTES);
    mesh.for_each_vertex(|vertex, [x, y, z]| {
        pace.tick()?;
        let z = grid.frame.height(z);
        let here = || {
            let (x, y) = grid.frame.on_the_map((x, y));
            VertexPlace { vertex, x, y }
        };
        let exact = grid.lattice(x, y);
        // A vertex off the lattice is judged where it nearly is, so that this one fault does not hide the others.
        let place = exact.or_else(|| grid.nearest_lattice(x, y));
        if exact.is_none() {
            found.off_lattice.add(here);
        }
        if place.is_some_and(|p| !grid.contains(p)) {
            found.outside.add(here);
        }
        if !z.is_finite() {
            found.not_finite.add(here);
        }
        if let Some((x, y)) = place {
            places.push([x as u64, y as u64, vertex])?;
        }
        store.push(Vertex { place, z })
    })?;
    Ok((found, store.finish()?, places.finish()?))
}

impl VertexFindings {
    /// Finds vertices that have the lattice point of one before them.
    pub(super) fn find_duplicates(
        &mut self,
        grid: &Grid,
        places: Sorted<'_, 3>,
        pace: &mut Pace<'_>,
    ) -> Result<(), VerifyError> {
        let mut before = None;
        for record in places {
            pace.tick()?;
            let [x, y, vertex] = record?;
            if before.replace((x, y)) == Some((x, y)) {
                let place = Some((x as i64, y as i64));
                self.duplicate.add(|| grid.vertex(vertex, Vertex { place, z: 0.0 }));
            }
        }
        Ok(())
    }

    /// Finds vertices that no face uses.
    pub(super) fn find_unused(
        &mut self,
        grid: &Grid,
        vertices: &mut VertexStore<'_>,
        uses: Sorted<'_, 1>,
        pace: &mut Pace<'_>,
    ) -> Result<(), VerifyError> {
        let mut expected = 0;
        for record in uses.map(Some).chain([None]) {
            pace.tick()?;
            // After the last use, all the rest is unused.
            let used = record.transpose()?.map_or(vertices.count(), |[v]| v);
            for unused in expected..used {
                let vertex = vertices.get(unused)?;
                self.unused.add(|| grid.vertex(unused, vertex));
            }
            expected = expected.max(used + 1);
        }
        Ok(())
    }
}
