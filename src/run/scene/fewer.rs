//! Fewer triangles, by meshoptimizer's simplifier.

use bytemuck::cast_slice;
use meshopt::{SimplifyOptions, VertexDataAdapter};

/// The relief in the extent as the simplifier sees it: heights count, however flat the ground is.
const RELIEF: f64 = 0.2;

/// Leaves about so many triangles, at most, and no vertex without one. Vertices stay where they are, some go.
pub(super) fn reduce(vertices: &mut Vec<[f64; 3]>, triangles: &mut Vec<[u32; 3]>, most: usize) {
    if triangles.len() > most {
        let places = places(vertices);
        let places = VertexDataAdapter::new(cast_slice(&places), size_of::<[f32; 3]>(), 0).expect("whole places");
        let corners = triangles.as_flattened();
        let mut reduced = meshopt::simplify(corners, &places, 3 * most, 1.0, SimplifyOptions::None, None);
        if 10 * reduced.len() > 33 * most {
            // It keeps the topology, of which there is too much here.
            reduced = meshopt::simplify_sloppy(corners, &places, 3 * most, 1.0, None);
        }
        triangles.clear();
        triangles.extend_from_slice(reduced.as_chunks().0);
    }
    keep_used(vertices, triangles);
}

/// Drops the vertices of no triangle.
fn keep_used(vertices: &mut Vec<[f64; 3]>, triangles: &mut [[u32; 3]]) {
    const UNUSED: u32 = u32::MAX;
    let mut numbers = vec![UNUSED; vertices.len()];
    triangles.as_flattened().iter().for_each(|vertex| numbers[*vertex as usize] = 0);
    let mut count = 0;
    for (vertex, number) in numbers.iter_mut().enumerate().filter(|(_, number)| **number != UNUSED) {
        *number = count;
        vertices[count as usize] = vertices[vertex];
        count += 1;
    }
    vertices.truncate(count as usize);
    triangles.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = numbers[*vertex as usize]);
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
