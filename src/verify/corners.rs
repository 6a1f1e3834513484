//! Vertices: duplicate, unused, off the lattice.

use crate::formats::MeshReader;

use super::VerifyError;
use super::finding::{Finding, VertexPlace};
use super::gather::{Counted, Gather, Key, MIX};
use super::grid::Grid;
use super::observe::Observer;
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
    (scratch, mut observer): (&'s Scratch, Option<&mut dyn Observer>),
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
            observer.iter_mut().for_each(|observer| observer.vertex((x, y), z));
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
        uses: Gather<'_, UseKey>,
        pace: &mut Pace<'_>,
    ) -> Result<(), VerifyError> {
        let (mut uses, joined) = uses.finish()?;
        pace.pass(joined)?;
        let count = vertices.count();
        let mut unused = |vertex: u64| {
            if vertex < count {
                let at = vertices.get(vertex)?;
                self.unused.add(|| grid.vertex(vertex, at));
            }
            Ok::<(), VerifyError>(())
        };
        let mut expected = 0;
        while let Some(([block, used], records)) = uses.next()? {
            pace.pass(records)?;
            (expected * UseKey::BLOCK..block * UseKey::BLOCK).try_for_each(&mut unused)?;
            let bits = (0..UseKey::BLOCK).filter(|bit| used >> bit & 1 == 0);
            bits.map(|bit| block * UseKey::BLOCK + bit).try_for_each(&mut unused)?;
            expected = block + 1;
        }
        // After the last use, all the rest is unused.
        (expected * UseKey::BLOCK..count).try_for_each(&mut unused)
    }
}

/// Which vertices of a block faces use: `[block, a bit for each of its vertices]`.
#[derive(Debug)]
pub(super) struct UseKey;

impl UseKey {
    /// Vertices of a block.
    const BLOCK: u64 = 64;

    /// Of a face with this corner.
    pub(super) fn record(vertex: u64) -> Counted {
        [vertex / UseKey::BLOCK, 1 << (vertex % UseKey::BLOCK)]
    }
}

impl Key for UseKey {
    fn is_same(a: Counted, b: Counted) -> bool {
        a[0] == b[0]
    }

    fn join(a: Counted, b: Counted) -> Counted {
        [a[0], a[1] | b[1]]
    }

    fn hash([block, _]: Counted) -> u64 {
        block.wrapping_mul(MIX)
    }
}

/// For the corners of all faces. Memory: 0.1 MiB of slots, and a sort of 4.
pub(super) fn use_sort(scratch: &Scratch) -> Gather<'_, UseKey> {
    Gather::new(scratch, 1 << 13, 4 << 20)
}
