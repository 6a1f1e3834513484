//! The edges of breaklines, as a sink is given them.

use super::Error;
use super::chains::ChainStore;
use crate::base::external::{Sorted, Sorter};
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;
use crate::base::{LineEdge, Window};
use crate::formats::{Marks, Sink};
use crate::kernel::breaklines::{Chains, Place};

/// Edges handed on at a time.
const AT_A_TIME: usize = 1 << 15;

/// Bytes of numbers of vertices in memory.
const IN_MEMORY: usize = 4 << 20;

/// The edges of chains, and the numbers that the vertices at their ends get: band by band of tiles, in each along the lines.
///
/// Memory: the edges of a band, some 200 bytes for each, and 8 MiB.
pub(super) struct Marked<'a> {
    chains: &'a ChainStore,
    marks: Marks,
    /// By places, of those vertices that are ends of edges.
    numbers: Sorter<'a, 3>,
    vertices: u64,
}

impl<'a> Marked<'a> {
    /// What there is to mark; nothing where the sink marks nothing.
    pub(super) fn new(chains: Option<&'a ChainStore>, marks: Marks) -> Option<Marked<'a>> {
        let chains = chains.filter(|_| marks != Marks::None)?;
        let bytes = if marks == Marks::Numbers { IN_MEMORY } else { 0 };
        Some(Marked { chains, marks, numbers: Sorter::new(chains.scratch(), bytes), vertices: 0 })
    }

    /// How many edges there are.
    pub(super) fn count(&self) -> u64 {
        self.chains.distinct()
    }

    /// Whether some of them follow soft lines alone.
    pub(super) fn have_types(&self) -> bool {
        self.chains.soft() > 0
    }

    /// The next vertices that are written, with places of a window.
    pub(super) fn number(&mut self, window: Window, vertices: &[Vertex]) -> Result<(), Error> {
        if self.marks == Marks::Numbers {
            let ends = self.chains.ends_near(window)?;
            let global = |local: i32, first: usize| i64::from(local) + first as i64 * i64::from(STEPS);
            for (number, vertex) in (self.vertices..).zip(vertices) {
                let at = Place { y: global(vertex.at.y, window.row), x: global(vertex.at.x, window.column) };
                if ends.binary_search_by_key(&at, |end| end.0).is_ok() {
                    self.numbers.push([at.y as u64, at.x as u64, number])?;
                }
            }
        }
        self.vertices += vertices.len() as u64;
        Ok(())
    }

    /// Hands the edges to a sink that takes them by places, before any vertex.
    pub(super) fn write_places(
        &self,
        sink: &mut dyn Sink,
        on_the_map: impl Fn(Place, f64) -> [f64; 3],
    ) -> Result<(), Error> {
        if self.marks != Marks::Places {
            return Ok(());
        }
        for chains in self.chains.by_band() {
            let chains = chains?;
            let end = |number: u32| {
                let (place, height) = chains.ends()[number as usize];
                on_the_map(place, height)
            };
            for edges in self.chains.along_lines(&chains).chunks(AT_A_TIME) {
                let placed: Vec<LineEdge<[f64; 3]>> = edges.iter().map(|edge| edge.map(end)).collect();
                sink.lines(&placed)?;
            }
        }
        Ok(())
    }

    /// Hands the edges to a sink that takes them by numbers, after all triangles.
    pub(super) fn write_numbers(self, sink: &mut dyn Sink) -> Result<(), Error> {
        if self.marks != Marks::Numbers {
            return Ok(());
        }
        let mut numbered = Numbered { sorted: self.numbers.finish()?, known: Vec::new() };
        for chains in self.chains.by_band() {
            let chains = chains?;
            let numbers = numbered.of(&chains)?;
            for edges in self.chains.along_lines(&chains).chunks(AT_A_TIME) {
                let of_numbers = |edge: &LineEdge<u32>| edge.map(|end| numbers[end as usize]);
                sink.edges(&edges.iter().map(of_numbers).collect::<Vec<_>>())?;
            }
        }
        Ok(())
    }
}

/// The numbers of vertices, by places.
struct Numbered<'a> {
    sorted: Sorted<'a, 3>,
    /// Those that were read and may be asked for again, in their order.
    known: Vec<(Place, u64)>,
}

impl Numbered<'_> {
    /// Those of the ends of a band's edges; bands come in their order.
    fn of(&mut self, chains: &Chains) -> Result<Vec<u64>, Error> {
        let [Some((first, _)), Some((last, _))] = [chains.ends().first(), chains.ends().last()] else {
            return Ok(Vec::new());
        };
        self.known.retain(|(place, _)| place.y >= first.y);
        while self.known.last().is_none_or(|(place, _)| place < last) {
            let Some(next) = self.sorted.next() else { break };
            let [y, x, number] = next?;
            self.known.push((Place { y: y as i64, x: x as i64 }, number));
        }
        let number = |&(at, _): &(Place, f64)| {
            let found = self.known.binary_search_by_key(&at, |(place, _)| *place);
            self.known[found.unwrap_or_else(|_| panic!("no vertex at {at:?}, where an edge of a line ends"))].1
        };
        Ok(chains.ends().iter().map(number).collect())
    }
}
