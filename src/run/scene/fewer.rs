//! Fewer triangles, by meshoptimizer's simplifier.

use meshopt::SimplifyOptions;

/// The relief in the extent as the simplifier sees it: heights count, however flat the ground is.
const RELIEF: f64 = 0.2;

/// Leaves about so many triangles, at most, and no vertex without one. Vertices stay where they are, some go.
pub(super) fn reduce(vertices: &mut Vec<[f64; 3]>, triangles: &mut Vec<[u32; 3]>, most: usize) {
    if triangles.len() > most {
        let places = places(vertices);
        let corners = triangles.as_flattened();
        let mut reduced = meshopt::simplify_decoder(corners, &places, 3 * most, 1.0, SimplifyOptions::None, None);
        if 10 * reduced.len() > 33 * most {
            // It keeps the topology, of which there is too much here.
            reduced = meshopt::simplify_sloppy_decoder(corners, &places, 3 * most, 1.0, None);
        }
        *triangles = reduced.as_chunks::<3>().0.to_vec();
    }
    let mut numbers = vec![u32::MAX; vertices.len()];
    let mut kept = Vec::new();
    for vertex in triangles.as_flattened_mut() {
        let number = &mut numbers[*vertex as usize];
        if *number == u32::MAX {
            *number = kept.len() as u32;
            kept.push(vertices[*vertex as usize]);
        }
        *vertex = *number;
    }
    *vertices = kept;
}

/// Vertices in single precision, within a box of the same proportions for every mesh.
fn places(vertices: &[[f64; 3]]) -> Vec<[f32; 3]> {
    let bounds = |axis: usize| {
        vertices.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v[axis]), high.max(v[axis])))
    };
    let [(left, right), (bottom, top), (low, high)] = [bounds(0), bounds(1), bounds(2)];
    let scale = |length: f64, to: f64| if length > 0.0 { to / length } else { 1.0 };
    let (across, up) = (scale((right - left).max(top - bottom), 1.0), scale(high - low, RELIEF));
    let place = |&[x, y, z]: &[f64; 3]| [(x - left) * across, (y - bottom) * across, (z - low) * up].map(|v| v as f32);
    vertices.iter().map(place).collect()
}
