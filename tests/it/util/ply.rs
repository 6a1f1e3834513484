//! Reading the meshes of tests.

use std::io::Write;

/// A binary little-endian PLY as the project writes it: doubles, triangles of unsigned integers.
pub(crate) fn ply(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut out = Vec::new();
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    )
    .unwrap();
    vertices.iter().flatten().for_each(|v| out.extend(v.to_le_bytes()));
    for triangle in triangles {
        out.push(3);
        triangle.iter().for_each(|v| out.extend(v.to_le_bytes()));
    }
    out
}

/// Two triangles over a flat raster of `width` × `height` samples without georeferencing, at height `z`.
pub(crate) fn flat(width: usize, height: usize, z: f64) -> Vec<u8> {
    let (left, right, top, bottom) = (0.5, width as f64 - 0.5, -0.5, 0.5 - height as f64);
    let corners = [[left, top, z], [left, bottom, z], [right, bottom, z], [right, top, z]];
    ply(&corners, &[[0, 1, 2], [0, 2, 3]])
}

/// Every line of the file but its comments.
pub(crate) fn without_comments(tin: &str) -> Vec<u8> {
    let bytes = std::fs::read(tin).unwrap();
    bytes.split_inclusive(|b| *b == b'\n').filter(|line| !line.starts_with(b"comment ")).flatten().copied().collect()
}
