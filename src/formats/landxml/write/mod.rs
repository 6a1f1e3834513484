//! LandXML's writer.

mod head;
mod text;

use super::FORMAT;
use crate::base::staged::StagedFile;
use crate::base::{LineEdge, LineType};
use crate::formats::joiner::{Joined, Joiner};
use crate::formats::output::{Output, push_decimal, push_place};
use crate::formats::wording::{Placer, facts};
use crate::formats::{Contents, Header, Marks, Needs, Setup, Sink, SinkError};
use text::{attribute, fact};

/// LandXML 1.2 with one surface: `<P id="1">northing easting elevation</P>` for each vertex, `<F>1 2 3</F>` for each triangle,
/// counter-clockwise seen from above, numbered from 1. One blank between numbers, as some programs split there. Edges that follow
/// lines are breaklines of the source data, from place to place, as far as one goes on from another; soft ones are described as `soft`.
///
/// Coordinates are the shortest decimals that are read again as the same doubles, in single precision as well. The CRS stands
/// in `CoordinateSystem` where coordinates are those of the map, and nowhere else. All facts of the header, and how many
/// vertices and triangles there are, are properties of a feature of the surface, `terrabite`. Date and time, which the schema
/// asks for, are always those of the first of January 2000, so that the same mesh is the same bytes. Memory: three megabytes
/// of buffers.
#[derive(Debug)]
pub struct LandXmlSink {
    output: Output,
    header: Header,
    placer: Placer,
    vertices: u64,
    triangles: u64,
    edges: u64,
    lines: Joiner,
    /// Vertices that have been written.
    written: u64,
    section: Section,
}

/// Where the file stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    Lines,
    Points,
    Faces,
}

impl LandXmlSink {
    /// Writes to `staged`, as the setup says.
    pub fn new(staged: StagedFile, setup: Setup) -> LandXmlSink {
        let placer = Placer::of(&setup);
        let header = setup.header;
        LandXmlSink {
            output: Output::new(staged),
            header,
            placer,
            vertices: 0,
            triangles: 0,
            edges: 0,
            lines: Joiner::default(),
            written: 0,
            section: Section::Lines,
        }
    }

    fn push(&mut self, text: &str) {
        self.output.buffer().extend_from_slice(text.as_bytes());
    }

    /// No more lines.
    fn begin_points(&mut self) -> Result<(), SinkError> {
        if self.section == Section::Lines {
            self.section = Section::Points;
            if let Some(line) = self.lines.finish() {
                push_line(&mut self.output, &line)?;
            }
            if self.edges > 0 {
                self.push("</Breaklines>\n</SourceData>\n");
            }
            self.push("<Definition surfType=\"TIN\">\n<Pnts>\n");
        }
        Ok(())
    }

    /// No more vertices.
    fn begin_faces(&mut self) -> Result<(), SinkError> {
        self.begin_points()?;
        if self.section == Section::Points {
            self.section = Section::Faces;
            self.push("</Pnts>\n<Faces>\n");
        }
        Ok(())
    }

    /// What stands behind the triangles.
    fn push_facts(&mut self) {
        self.push("</Faces>\n</Definition>\n<Feature code=\"terrabite\">\n");
        let counts = [("vertices", self.vertices.to_string()), ("triangles", self.triangles.to_string())];
        let edges = (self.edges > 0).then(|| ("edges", self.edges.to_string()));
        let facts = facts(&self.header).into_iter().map(|line| ("fact", fact(&line)));
        for (label, value) in counts.into_iter().chain(edges).chain(facts) {
            self.push(&format!("<Property label=\"{label}\" value=\"{}\"/>\n", attribute(&value)));
        }
        // No line break at the end: whatever is cut off is missed.
        self.push("</Feature>\n</Surface>\n</Surfaces>\n</LandXML>");
    }
}

/// A line as a breakline.
fn push_line(output: &mut Output, (points, line_type): &Joined) -> Result<(), SinkError> {
    let text = output.buffer();
    // The schema's types are standard, wall, proximity and nondestructive.
    text.extend_from_slice(match line_type {
        LineType::Hard => b"<Breakline brkType=\"standard\"><PntList3D>".as_slice(),
        LineType::Soft => b"<Breakline brkType=\"standard\" desc=\"soft\"><PntList3D>",
    });
    for (i, [x, y, z]) in points.iter().enumerate() {
        if i > 0 {
            text.push(b' ');
        }
        push_place(text, [*y, *x, *z]);
    }
    text.extend_from_slice(b"</PntList3D></Breakline>\n");
    output.drain()
}

impl Sink for LandXmlSink {
    fn needs(&self) -> Needs {
        Needs { edges: Marks::Places, ..Needs::default() }
    }

    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.header.complete(contents);
        FORMAT.limits.check(FORMAT.title, self.output.path(), contents)?;
        (self.vertices, self.triangles, self.edges) = (contents.vertices, contents.triangles, contents.edges);
        let head = head::head(&self.header);
        self.push(&head);
        if self.edges > 0 {
            self.push("<SourceData>\n<Breaklines>\n");
        }
        Ok(())
    }

    fn lines(&mut self, edges: &[LineEdge<[f64; 3]>]) -> Result<(), SinkError> {
        for LineEdge { ends: [from, to], line_type } in edges {
            let path = self.output.path();
            let ends = [self.placer.place(path, *from)?, self.placer.place(path, *to)?];
            if let Some(line) = self.lines.push(LineEdge { ends, line_type: *line_type }) {
                push_line(&mut self.output, &line)?;
            }
        }
        Ok(())
    }

    fn vertices(&mut self, vertices: &[[f64; 3]], _: &[&[f64]]) -> Result<(), SinkError> {
        self.begin_points()?;
        let (placer, path, before) = (self.placer, self.output.path().to_path_buf(), self.written);
        self.written += vertices.len() as u64;
        self.output.put_side_by_side(vertices, |text, i, vertex| {
            let [x, y, z] = placer.place(&path, *vertex)?;
            text.extend_from_slice(b"<P id=\"");
            push_decimal(text, before + i as u64 + 1);
            text.extend_from_slice(b"\">");
            push_place(text, [y, x, z]);
            text.extend_from_slice(b"</P>\n");
            Ok(())
        })
    }

    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        self.begin_faces()?;
        self.output.put_side_by_side(triangles, |text, _, [a, b, c]| {
            text.extend_from_slice(b"<F>");
            push_decimal(text, a + 1);
            text.push(b' ');
            push_decimal(text, b + 1);
            text.push(b' ');
            push_decimal(text, c + 1);
            text.extend_from_slice(b"</F>\n");
            Ok(())
        })
    }

    fn finish(mut self: Box<Self>) -> Result<(), SinkError> {
        self.begin_faces()?;
        self.push_facts();
        self.output.commit()
    }
}

#[cfg(test)]
mod tests;
