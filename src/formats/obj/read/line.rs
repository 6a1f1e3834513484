//! Lines of OBJ files: what each is.

/// What the first comment of a file of terrabite's begins with.
const HEADER: &str = "# mesh of ";

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Vertex,
    Face,
    /// Blank, or a comment.
    Nothing,
    /// Something of a mesh that is not read.
    Unused,
    /// Something else.
    Unknown,
}

/// Statements that change nothing about vertices and triangles.
const UNUSED: &[&str] = &[
    "vt",
    "vn",
    "vp",
    "p",
    "l",
    "o",
    "g",
    "s",
    "mg",
    "usemtl",
    "usemap",
    "mtllib",
    "maplib",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
];

/// What a line is, by its first word.
pub(super) fn kind(line: &[u8]) -> Kind {
    let line = line.trim_ascii_start();
    let word = &line[..line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len())];
    match word {
        b"v" => Kind::Vertex,
        // The latter is an old name of the former.
        b"f" | b"fo" => Kind::Face,
        [] | [b'#', ..] => Kind::Nothing,
        _ if UNUSED.iter().any(|unused| unused.as_bytes() == word) => Kind::Unused,
        _ => Kind::Unknown,
    }
}

/// Whether a file that begins so is terrabite's.
pub(super) fn is_header(line: &[u8]) -> bool {
    line.starts_with(HEADER.as_bytes())
}

/// What such a first line tells: the counts of vertices and of triangles.
pub(super) fn counts(line: &str) -> Option<(u64, u64)> {
    let (vertices, triangles) = line.strip_prefix(HEADER)?.strip_suffix(" triangles")?.split_once(" vertices and ")?;
    Some((vertices.parse().ok()?, triangles.parse().ok()?))
}
