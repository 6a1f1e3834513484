//! What makes the mesh of one tile from its samples: rims, engines, polishing and measures. Nothing here knows of files,
//! of runs or of options.

pub mod boundary;
pub mod breaklines;
mod links;
pub mod measure;
pub mod polish;
mod quantum;
pub mod seam;
pub mod triangulate;
