//! The edges of breaklines, as a sink is given them.

use super::Error;
use crate::base::Window;
use crate::base::mesh::Vertex;
use crate::formats::{Marks, Sink};
use crate::kernel::breaklines::{Chains, Place};

/// Edges handed on at a time.
const AT_A_TIME: usize = 1 << 15;

/// In the place of a vertex that has not come.
const NONE: u64 = u64::MAX;

/// The edges of chains, and the numbers that the vertices at their ends get. Memory: 16 bytes for each edge.
pub(super) struct Marked<'a> {
    chains: &'a Chains,
    marks: Marks,
    edges: Vec<[u32; 2]>,
    numbers: Vec<u64>,
    vertices: u64,
}

impl<'a> Marked<'a> {
    /// What there is to mark; nothing where the sink marks nothing.
    pub(super) fn new(chains: Option<&'a Chains>, marks: Marks) -> Option<Marked<'a>> {
        let chains = chains.filter(|_| marks != Marks::None)?;
        let edges = chains.along_lines();
        let numbers = if marks == Marks::Numbers { vec![NONE; chains.ends().len()] } else { Vec::new() };
        Some(Marked { chains, marks, edges, numbers, vertices: 0 })
    }

    /// How many edges there are.
    pub(super) fn count(&self) -> u64 {
        self.edges.len() as u64
    }

    /// The next vertices that are written, with places of a window.
    pub(super) fn number(&mut self, window: Window, vertices: &[Vertex]) {
        if self.marks == Marks::Numbers {
            for (number, vertex) in (self.vertices..).zip(vertices) {
                if let Some(end) = self.chains.number_in(window, vertex.at) {
                    self.numbers[end] = number;
                }
            }
        }
        self.vertices += vertices.len() as u64;
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
        let end = |number: u32| {
            let (place, height) = self.chains.ends()[number as usize];
            on_the_map(place, height)
        };
        for edges in self.edges.chunks(AT_A_TIME) {
            let ends: Vec<[[f64; 3]; 2]> = edges.iter().map(|edge| edge.map(end)).collect();
            sink.lines(&ends)?;
        }
        Ok(())
    }

    /// Hands the edges to a sink that takes them by numbers, after all triangles.
    pub(super) fn write_numbers(&self, sink: &mut dyn Sink) -> Result<(), Error> {
        if self.marks != Marks::Numbers {
            return Ok(());
        }
        let number = |end: u32| {
            let number = self.numbers[end as usize];
            assert!(
                number != NONE,
                "no vertex at {:?}, where an edge of a line ends",
                self.chains.ends()[end as usize]
            );
            number
        };
        for edges in self.edges.chunks(AT_A_TIME) {
            let numbers: Vec<[u64; 2]> = edges.iter().map(|edge| edge.map(number)).collect();
            sink.edges(&numbers)?;
        }
        Ok(())
    }
}
