//! Triangles and lines in well-known binary.

const LINE_Z: u32 = 1002;
const POLYGON_Z: u32 = 1003;
const TIN_Z: u32 = 1016;
const TRIANGLE_Z: u32 = 1017;

/// A triangle as a polygon, or as the only ring of a triangle: four points.
fn push_ring(wkb: &mut Vec<u8>, kind: u32, [a, b, c]: &[[f64; 3]; 3]) {
    wkb.push(1);
    for number in [kind, 1, 4] {
        wkb.extend_from_slice(&number.to_le_bytes());
    }
    for value in [a, b, c, a].into_iter().flatten() {
        wkb.extend_from_slice(&value.to_le_bytes());
    }
}

/// A polygon, little-endian.
pub(super) fn polygon(wkb: &mut Vec<u8>, triangle: &[[f64; 3]; 3]) {
    wkb.clear();
    push_ring(wkb, POLYGON_Z, triangle);
}

/// A TIN, little-endian.
pub(super) fn tin(wkb: &mut Vec<u8>, triangles: &[[[f64; 3]; 3]]) {
    wkb.clear();
    wkb.push(1);
    wkb.extend_from_slice(&TIN_Z.to_le_bytes());
    wkb.extend_from_slice(&(triangles.len() as u32).to_le_bytes());
    triangles.iter().for_each(|triangle| push_ring(wkb, TRIANGLE_Z, triangle));
}

/// A line, little-endian.
pub(super) fn line(wkb: &mut Vec<u8>, points: &[[f64; 3]]) {
    wkb.clear();
    wkb.push(1);
    for number in [LINE_Z, points.len() as u32] {
        wkb.extend_from_slice(&number.to_le_bytes());
    }
    points.iter().flatten().for_each(|value| wkb.extend_from_slice(&value.to_le_bytes()));
}
