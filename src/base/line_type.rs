//! Types of lines that become edges of a mesh, and edges with the type of their line.

/// Whether the surface is said to break along a line. A mesh has edges along lines of both types, under the same promise: triangles are
/// plane. Programs that draw smooth surfaces through it, or contours, need to be told.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LineType {
    /// The slope breaks: a road's edge, a wall.
    #[default]
    Hard,
    /// It need not: a border, a contour.
    Soft,
}

impl LineType {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            LineType::Hard => "hard",
            LineType::Soft => "soft",
        }
    }

    /// What is called so, here or in ArcGIS.
    pub fn from_name(name: &str) -> Option<LineType> {
        match name {
            "hard" | "Hard_Line" => Some(LineType::Hard),
            "soft" | "Soft_Line" => Some(LineType::Soft),
            _ => None,
        }
    }
}

/// An edge of a mesh that follows a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineEdge<E> {
    /// From the vertex where it begins to the other.
    pub ends: [E; 2],
    /// Hard if one of its lines is.
    pub line_type: LineType,
}

impl<E> LineEdge<E> {
    /// The same edge, its ends named otherwise.
    pub fn map<F>(self, of: impl FnMut(E) -> F) -> LineEdge<F> {
        LineEdge { ends: self.ends.map(of), line_type: self.line_type }
    }
}
