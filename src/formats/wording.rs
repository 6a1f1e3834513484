//! What writers of several formats do alike: coordinates in their frame, and headers of one line for each fact.

use std::path::Path;

use super::{Bounds, Header, Setup, SinkError};
use crate::base::CoordinateFrame;

/// A vertex as the frame writes it: x, y, z.
///
/// # Errors
/// [`SinkError::Lossy`] for a height that would be read again at another height than within `loss`, or is not finite.
fn placed(frame: &CoordinateFrame, loss: f64, path: &Path, [x, y, height]: [f64; 3]) -> Result<[f64; 3], SinkError> {
    let (x, y) = frame.written_place((x, y));
    let z = frame.written_height(height);
    let lost = (frame.height(z) - height).abs();
    if lost > loss || lost.is_nan() {
        return Err(SinkError::Lossy { path: path.to_path_buf(), height, allowed: loss, found: lost });
    }
    Ok([x, y, z])
}

/// How a writer makes the numbers of vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placer {
    frame: CoordinateFrame,
    loss: f64,
    as_is: bool,
}

impl Placer {
    /// As the setup of a sink says.
    pub(super) fn of(setup: &Setup) -> Placer {
        Placer { frame: setup.header.frame, loss: setup.loss, as_is: setup.as_is }
    }

    /// The numbers of a vertex: x, y, z.
    ///
    /// # Errors
    /// See [`placed`].
    #[inline]
    pub(super) fn place(&self, path: &Path, vertex: [f64; 3]) -> Result<[f64; 3], SinkError> {
        if self.as_is { Ok(vertex) } else { placed(&self.frame, self.loss, path, vertex) }
    }

    /// The bounds of the numbers.
    pub(super) fn bounds(&self, Bounds { min, max }: Bounds) -> Bounds {
        if self.as_is {
            return Bounds { min, max };
        }
        let placed = |[x, y, height]: [f64; 3]| {
            let (x, y) = self.frame.written_place((x, y));
            [x, y, self.frame.written_height(height)]
        };
        Bounds { min: placed(min), max: placed(max) }
    }
}

/// A text in one line: a line break would end the comment it stands in.
pub(super) fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

/// The lines of a run: window, tolerance, options, notes.
pub(super) fn run_lines(header: &Header) -> Vec<String> {
    let window = header.window.map(|window| format!("window {window}"));
    let tolerance = header.tolerance.map(|tolerance| format!("max_error {tolerance}"));
    let options = header.options.iter().map(|option| format!("{} {}", option.name.words(), option.value));
    window.into_iter().chain(tolerance).chain(options).chain(header.notes.iter().cloned()).collect()
}

/// The lines of a frame that is not plain: `xy_scale S T`, which x and y are to be divided by, `offset X Y`, to be added to them
/// then, and `z_scale F`: z is the height times F.
pub(super) fn frame_lines(frame: &CoordinateFrame) -> Vec<String> {
    let mut lines = Vec::new();
    if frame.xy_scale != CoordinateFrame::PLAIN.xy_scale {
        lines.push(format!("xy_scale {} {}", frame.xy_scale.0, frame.xy_scale.1));
    }
    if frame.origin != CoordinateFrame::PLAIN.origin {
        lines.push(format!("offset {} {}", frame.origin.0, frame.origin.1));
    }
    if frame.z_scale != CoordinateFrame::PLAIN.z_scale {
        lines.push(format!("z_scale {}", frame.z_scale));
    }
    lines
}

/// All that a header says, a line for each fact, as `lines::header` takes them again.
pub(super) fn facts(header: &Header) -> Vec<String> {
    let Header { made_by, source, crs, heights, frame, .. } = header;
    let mut lines = Vec::new();
    lines.extend(made_by.iter().map(|program| format!("made by {program}")));
    lines.extend(source.iter().map(|name| format!("source {name}")));
    let key = if frame.is_local() { "map crs " } else { "crs:" };
    lines.extend(crs.definition.iter().map(|crs| format!("{key}{crs}")));
    lines.extend(crs.name.iter().map(|name| format!("crs name {name}")));
    lines.extend(heights.crs.iter().map(|name| format!("vertical crs {name}")));
    lines.extend(heights.unit.iter().map(|unit| format!("height unit {unit}")));
    lines.extend(run_lines(header));
    lines.extend(frame_lines(frame));
    if frame.single {
        lines.push("precision float".to_string());
    }
    lines.iter().map(|line| one_line(line)).collect()
}
