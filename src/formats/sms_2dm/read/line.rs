//! Lines of 2DM files: what each is.

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `ND`.
    Node,
    /// `E3T`.
    Triangle,
    /// An element with another number of nodes.
    OtherElement,
    /// Of a comment.
    Comment,
    /// Blank.
    Nothing,
    /// `MESH2D`, with which a file begins.
    First,
    /// Something that is not read: strings of nodes, lines, materials, boundary conditions.
    Unused,
}

/// What a line is, by its first word.
pub(super) fn kind(line: &[u8]) -> Kind {
    match word(line) {
        [] => Kind::Nothing,
        [b'#', ..] => Kind::Comment,
        b"ND" => Kind::Node,
        b"E3T" => Kind::Triangle,
        // Lines of two and of three nodes have no face.
        b"E2L" | b"E3L" => Kind::Unused,
        [b'E', digit, ..] if digit.is_ascii_digit() => Kind::OtherElement,
        b"MESH2D" => Kind::First,
        _ => Kind::Unused,
    }
}

/// The first word of a line.
pub(super) fn word(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii_start();
    &line[..line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len())]
}

/// What the second line of a file of terrabite's tells: the counts of nodes and of elements.
pub(super) fn counts(line: &str) -> Option<(u64, u64)> {
    let (nodes, elements) = line.strip_prefix("# mesh of ")?.strip_suffix(" elements")?.split_once(" nodes and ")?;
    Some((nodes.parse().ok()?, elements.parse().ok()?))
}
