//! A tile as the bytes of a file: quantized-mesh 1.0, with the extension of normals.

use super::Body;
use super::body::{Vector, cross, dot, length, minus};
use super::quantize::SPAN;
use super::surface::{Surface, SurfaceVertex};

/// The number of the extension for normals.
const NORMALS: u8 = 1;

/// A point from which on a tile is never hidden by the ellipsoid, in half axes: where it covers so much of it that no nearer
/// point can be found.
const FAR: f64 = 1e6;

/// How many vertices readers number: those of a tile, and two for each of its border, which viewers hang skirts on.
pub(super) const MOST_VERTICES: usize = 65_536;

/// A tile that is written: each vertex when a triangle first uses it, triangles in an order that compresses well.
pub(super) struct Ordered {
    /// Places of the vertices in the surface.
    order: Vec<u32>,
    /// Of vertices in the order of the file.
    triangles: Vec<[u32; 3]>,
}

impl Ordered {
    pub(super) fn of(surface: &Surface) -> Ordered {
        let flat = surface.triangles.as_flattened();
        let mut triangles = match flat.is_empty() {
            true => Vec::new(),
            false => meshopt::optimize_vertex_cache(flat, surface.vertices.len()),
        };
        let mut places = vec![u32::MAX; surface.vertices.len()];
        let mut order = Vec::with_capacity(places.len());
        for vertex in &mut triangles {
            let place = &mut places[*vertex as usize];
            if *place == u32::MAX {
                *place = order.len() as u32;
                order.push(*vertex);
            }
            *vertex = *place;
        }
        // Those of the border may be in no triangle, at a pole or beside a hole.
        order.extend((0..places.len() as u32).filter(|&i| places[i as usize] == u32::MAX));
        let (triangles, _) = triangles.as_chunks();
        Ordered { order, triangles: triangles.to_vec() }
    }
}

/// How many vertices readers need for a tile.
pub(super) fn numbered(surface: &Surface) -> usize {
    // A corner is on two sides, and so in two of the lists.
    surface.vertices.len() + 2 * (surface.vertices.iter().filter(|v| v.is_on_border()).count() + 4)
}

/// A number of a vertex.
type Of = fn(&SurfaceVertex) -> i64;

/// The bytes of a tile. `normals` are in the order of the surface's vertices.
pub(super) fn encode(body: &Body, surface: &Surface, normals: &[[u8; 2]]) -> Vec<u8> {
    let Ordered { order, triangles } = Ordered::of(surface);
    let vertices: Vec<_> = order.iter().map(|&i| surface.vertices[i as usize]).collect();
    let mut bytes = Vec::with_capacity(120 + 8 * vertices.len() + 6 * triangles.len());
    header(body, surface, &mut bytes);
    put_u32(&mut bytes, vertices.len());
    let values: [Of; 3] = [|v| v.u, |v| v.v, |v| v.quantum];
    for value in values {
        let mut before = 0;
        for vertex in &vertices {
            let delta = value(vertex) - before;
            before = value(vertex);
            put_u16(&mut bytes, ((delta << 1) ^ (delta >> 63)) as usize);
        }
    }
    put_u32(&mut bytes, triangles.len());
    let mut next = 0;
    for &index in triangles.as_flattened() {
        put_u16(&mut bytes, (next - index) as usize);
        next += u32::from(index == next);
    }
    // West, south, east, north.
    let sides: [(Of, i64, Of); 4] =
        [(|v| v.u, 0, |v| v.v), (|v| v.v, 0, |v| v.u), (|v| v.u, SPAN, |v| v.v), (|v| v.v, SPAN, |v| v.u)];
    for (across, at, along) in sides {
        let mut side: Vec<usize> = (0..vertices.len()).filter(|&i| across(&vertices[i]) == at).collect();
        side.sort_by_key(|&i| along(&vertices[i]));
        put_u32(&mut bytes, side.len());
        side.into_iter().for_each(|i| put_u16(&mut bytes, i));
    }
    bytes.push(NORMALS);
    put_u32(&mut bytes, 2 * vertices.len());
    order.iter().for_each(|&i| bytes.extend(normals[i as usize]));
    bytes
}

fn put_u32(bytes: &mut Vec<u8>, value: usize) {
    bytes.extend((value as u32).to_le_bytes());
}

fn put_u16(bytes: &mut Vec<u8>, value: usize) {
    bytes.extend((value as u16).to_le_bytes());
}

fn header(body: &Body, surface: &Surface, bytes: &mut Vec<u8>) {
    let mut put = |values: &[f64]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    let bound = |choose: fn(f64, f64) -> f64| {
        let at = surface.vertices.iter().map(|v| v.at);
        at.reduce(|a, b| std::array::from_fn(|i| choose(a[i], b[i]))).expect("a tile has corners")
    };
    let (low, high) = (bound(f64::min), bound(f64::max));
    let middle: Vector = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
    let radius = surface.vertices.iter().map(|v| length(minus(v.at, middle))).fold(0.0, f64::max);
    let centre: Vector = std::array::from_fn(|i| middle[i] + surface.centre[i]);
    put(&centre);
    bytes.extend((surface.lattice.minimum() as f32).to_le_bytes());
    bytes.extend((surface.lattice.maximum() as f32).to_le_bytes());
    let mut put = |values: &[f64]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    put(&centre);
    // Rounding of the centre and of readers.
    put(&[radius * (1.0 + 1e-12) + 1e-6]);
    put(&occlusion_point(body, surface, centre));
}

/// The point that the ellipsoid hides only if it hides all of the tile, in half axes (Cesium's horizon culling, Ring 2013):
/// on the ray to the centre, so far out that a tangent from it passes above every vertex.
fn occlusion_point(body: &Body, surface: &Surface, centre: Vector) -> Vector {
    let axes = [body.semi_major, body.semi_major, body.semi_minor];
    let scaled = |point: Vector| -> Vector { std::array::from_fn(|i| point[i] / axes[i]) };
    let ray = scaled(centre);
    let size = length(ray);
    let ray = ray.map(|x| x / size);
    let farthest = surface.vertices.iter().fold(0.0f64, |farthest, vertex| {
        let point = scaled(std::array::from_fn(|i| vertex.at[i] + surface.centre[i]));
        let reach = length(point);
        let direction = point.map(|x| x / reach);
        // Points below the ellipsoid count as on it.
        let reach = reach.max(1.0);
        let (cos, sin) = (dot(direction, ray), length(cross(direction, ray)));
        let (cos_tangent, sin_tangent) = (1.0 / reach, (reach * reach - 1.0).sqrt() / reach);
        let share = cos * cos_tangent - sin * sin_tangent;
        farthest.max(if share > 1.0 / FAR { 1.0 / share } else { FAR })
    });
    ray.map(|x| x * farthest)
}
