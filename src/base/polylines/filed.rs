//! Lines in a temporary file, read from the first to the last.

use std::fs::File;
use std::sync::{Arc, Mutex};

use super::Polylines;
use crate::base::external::{Scratch, ScratchError};

/// How many vertices are read at a time; a line is read whole.
const AT_A_TIME: usize = 1 << 16;

/// Takes lines one by one; what is more than a number of vertices goes to a file.
///
/// Memory: 16 bytes for each vertex up to that number, or 24 with heights, and 8 for each line.
#[derive(Debug)]
pub(crate) struct LineWriter {
    scratch: Scratch,
    with_heights: bool,
    /// The most vertices in memory.
    most: usize,
    features: Vec<u64>,
    lines: Vec<Vec<(f64, f64)>>,
    heights: Vec<Vec<f64>>,
    vertices: usize,
    filed: Filed,
}

impl LineWriter {
    /// For lines with heights or without, of which up to `most` vertices are held in memory.
    pub(crate) fn new(scratch: Scratch, with_heights: bool, most: usize) -> LineWriter {
        let (features, lines, heights, filed) = (Vec::new(), Vec::new(), Vec::new(), Filed::default());
        LineWriter { scratch, with_heights, most, features, lines, heights, vertices: 0, filed }
    }

    /// The next line, of a feature. There are as many heights as vertices, if they are wanted.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn push(
        &mut self,
        feature: u64,
        vertices: Vec<(f64, f64)>,
        heights: Vec<f64>,
    ) -> Result<(), ScratchError> {
        self.features.push(feature);
        self.vertices += vertices.len();
        self.lines.push(vertices);
        if self.with_heights {
            self.heights.push(heights);
        }
        let most = if self.filed.file.is_some() { AT_A_TIME } else { self.most };
        if self.vertices > most { self.file() } else { Ok(()) }
    }

    /// Puts what is in memory into the file.
    fn file(&mut self) -> Result<(), ScratchError> {
        if self.filed.file.is_none() {
            self.filed.file = Some(Mutex::new(self.scratch.file()?));
        }
        let file = self.filed.file.as_mut().expect("made above").get_mut().expect("nobody panicked");
        let mut words: Vec<[u64; 1]> = Vec::new();
        let mut first = 0;
        while first < self.lines.len() {
            words.clear();
            let mut after = first;
            while after < self.lines.len() && words.len() < 2 * AT_A_TIME {
                let line = &self.lines[after];
                words.push([line.len() as u64]);
                words.extend(line.iter().flat_map(|&(x, y)| [[x.to_bits()], [y.to_bits()]]));
                words.extend(self.heights.get(after).into_iter().flatten().map(|height| [height.to_bits()]));
                after += 1;
            }
            self.scratch.write(file, &words)?;
            self.filed.pieces.push(Piece { lines: after - first, words: words.len() });
            first = after;
        }
        self.lines.clear();
        self.heights.clear();
        self.vertices = 0;
        Ok(())
    }

    /// All lines.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn finish(mut self) -> Result<Polylines, ScratchError> {
        if self.filed.file.is_none() {
            let lines = Polylines::new(self.lines).of_features(self.features);
            return Ok(if self.with_heights { lines.with_heights(self.heights) } else { lines });
        }
        self.file()?;
        let filed = Filed { scratch: Some(self.scratch), with_heights: self.with_heights, ..self.filed };
        let features = Some(Arc::new(self.features));
        Ok(Polylines { filed: Some(Arc::new(filed)), features, ..Polylines::default() })
    }
}

/// Lines in a file.
#[derive(Debug, Default)]
pub(super) struct Filed {
    scratch: Option<Scratch>,
    file: Option<Mutex<File>>,
    pub(super) with_heights: bool,
    pieces: Vec<Piece>,
}

/// What is read at a time.
#[derive(Debug, Clone, Copy)]
struct Piece {
    lines: usize,
    words: usize,
}

impl PartialEq for Filed {
    /// Whether it is the same file.
    fn eq(&self, other: &Filed) -> bool {
        std::ptr::eq(self, other)
    }
}

impl Filed {
    /// Some lines at a time, without their features, each with the number of the first.
    pub(super) fn pieces(&self) -> impl Iterator<Item = Result<(usize, Polylines), ScratchError>> {
        let mut next = (0, 0);
        self.pieces.iter().map(move |piece| {
            let (word, first) = next;
            next = (word + piece.words as u64, first + piece.lines);
            let mut words = vec![[0u64; 1]; piece.words];
            let (scratch, file) = self.scratch.as_ref().zip(self.file.as_ref()).expect("a finished file");
            scratch.read(&file.lock().expect("nobody panicked"), word, &mut words)?;
            let mut words = words.into_iter().flatten();
            let (mut lines, mut heights) = (Vec::new(), Vec::new());
            for _ in 0..piece.lines {
                let count = words.next().expect("a line") as usize;
                let mut number = || f64::from_bits(words.next().expect("a number"));
                lines.push((0..count).map(|_| (number(), number())).collect());
                if self.with_heights {
                    heights.push((0..count).map(|_| number()).collect());
                }
            }
            let lines = Polylines::new(lines);
            Ok((first, if self.with_heights { lines.with_heights(heights) } else { lines }))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back_from_a_file_as_from_memory() {
        let line = |i: usize| (0..i * 7 % 23).map(|j| (i as f64 / 3.0, j as f64)).collect::<Vec<_>>();
        let heights = |i: usize| (0..i * 7 % 23).map(|j| (i * j) as f64).collect::<Vec<_>>();
        for with_heights in [false, true] {
            let read = |most: usize| {
                let mut writer = LineWriter::new(Scratch::new(None, Default::default()), with_heights, most);
                (0..40).for_each(|i| writer.push(i as u64 / 2, line(i), heights(i)).expect("a file"));
                writer.push(9, (0..70_000).map(|i| (f64::from(i), 0.5)).collect(), vec![1.0; 70_000]).expect("a file");
                writer.finish().expect("a file")
            };
            let (memory, file) = (read(1 << 20), read(100));
            assert!(memory.filed.is_none() && file.filed.is_some());
            assert_eq!((file.count(), file.have_heights(), file.feature(13)), (41, with_heights, 6));
            let (mut lines, mut heights) = (Vec::new(), Vec::new());
            for piece in file.pieces() {
                let (first, piece) = piece.expect("a file");
                assert_eq!(first, lines.len());
                lines.extend_from_slice(piece.lines());
                heights.extend_from_slice(piece.heights().unwrap_or_default());
            }
            assert_eq!((lines.as_slice(), heights.as_slice()), (memory.lines(), memory.heights().unwrap_or_default()));
            assert_eq!(memory.pieces().count(), 1);
        }
    }
}
