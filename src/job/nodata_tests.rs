//! Rasters with missing samples: what is written is held against the ground by brute force.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use proptest::prelude::*;

use super::tests::{Told, engines, qualities, told};
use super::*;
use crate::base::Heights;
use crate::base::PointSet;
use crate::base::Window;
use crate::base::channels::{Channel, ChannelError, Number, Range, Ranges};
use crate::base::control::Control;
use crate::base::exact;
use crate::base::lattice::{Point, orient};
use crate::field::{Choice, Field, FieldError, FieldOptions, HoleOptions};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::hitting_set::HittingSet;
use crate::raster::{CutlineSource, Raster, read_cutline};
use crate::testing::{self, cases};

pub(super) type Place = (i32, i32);

/// Heights, NaN where there is none.
pub(super) struct Scene {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) heights: Vec<f64>,
    /// Weights of errors and the values of a channel: neither where the height is missing, or no weights or channel at all.
    pub(super) weights: Vec<f64>,
    pub(super) channel: Vec<f64>,
    /// The largest hole that is bridged, in samples, and all samples that are.
    pub(super) most: usize,
    pub(super) bridged: BTreeSet<Place>,
}

impl Scene {
    pub(super) fn new(width: usize, height: usize, heights: Vec<f64>) -> Scene {
        let bridged = BTreeSet::new();
        Scene { width, height, heights, weights: Vec::new(), channel: Vec::new(), most: 0, bridged }
    }

    pub(super) fn at(&self, (column, row): Place) -> Option<f64> {
        let inside = column >= 0 && row >= 0 && column < self.width as i32 && row < self.height as i32;
        inside.then(|| self.heights[row as usize * self.width + column as usize]).filter(|z| !z.is_nan())
    }

    /// Gives every height a weight, 0 among them.
    pub(super) fn weigh(&mut self) {
        let weight = |(i, z): (usize, &f64)| if z.is_nan() { f64::NAN } else { [0.0, 0.5, 1.0, 3.0][i * 7 % 4] };
        self.weights = self.heights.iter().enumerate().map(weight).collect();
    }

    /// The samples of these indices, by rows, as far as they are corners of the ground.
    pub(super) fn points_of(&self, indices: Vec<usize>) -> PointSet {
        let ground: BTreeSet<Place> = self.cells().into_iter().flatten().collect();
        let places = indices.into_iter().map(|i| (i % self.width, i / self.width));
        PointSet::new(places.filter(|&(c, r)| ground.contains(&(c as i32, r as i32))))
    }

    pub(super) fn is_ground(&self, place: Place) -> bool {
        self.at(place).is_some() || self.bridged.contains(&place)
    }

    /// Bridges holes of up to `most` samples.
    pub(super) fn bridging(self, most: usize) -> Scene {
        let (mut seen, mut bridged) = (BTreeSet::new(), BTreeSet::new());
        for start in self.places().filter(|&p| self.at(p).is_none()) {
            let (mut hole, mut open) = (BTreeSet::new(), vec![start]);
            while let Some((column, row)) = open.pop().filter(|&p| seen.insert(p)) {
                hole.insert((column, row));
                let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (column + dx, row + dy)));
                let within = |p: &Place| p.0 >= 0 && p.1 >= 0 && p.0 < self.width as i32 && p.1 < self.height as i32;
                open.extend(around.filter(|p| within(p) && self.at(*p).is_none() && !seen.contains(p)));
                open.sort_unstable();
                open.dedup();
            }
            let (right, bottom) = (self.width as i32 - 1, self.height as i32 - 1);
            let at_edge = |&(column, row): &Place| column == 0 || row == 0 || column == right || row == bottom;
            if hole.len() <= most && !hole.iter().any(at_edge) {
                bridged.extend(hole);
            }
        }
        Scene { most, bridged, ..self }
    }

    pub(super) fn places(&self) -> impl Iterator<Item = Place> {
        let (width, height) = (self.width as i32, self.height as i32);
        (0..height).flat_map(move |row| (0..width).map(move |column| (column, row)))
    }

    /// Corners of the ground of every cell, around.
    pub(super) fn cells(&self) -> Vec<Vec<Place>> {
        let corners = |(c, r): Place| [(c, r), (c + 1, r), (c + 1, r + 1), (c, r + 1)];
        let valid = |p: Place| corners(p).into_iter().filter(|&q| self.is_ground(q)).collect::<Vec<_>>();
        self.places().map(valid).filter(|cell| cell.len() >= 3).collect()
    }

    /// The edges of the ground, with the ground to their left.
    fn boundary(&self) -> BTreeSet<(Place, Place)> {
        let cells = self.cells();
        let edges = cells.iter().flat_map(|c| (0..c.len()).map(|i| (c[i], c[(i + 1) % c.len()])));
        let all: BTreeSet<(Place, Place)> = edges.collect();
        all.iter().copied().filter(|&(p, q)| !all.contains(&(q, p))).collect()
    }

    pub(super) fn field(&self) -> Field {
        let of = |values: &[f64]| {
            Field::from_heights(self.width, self.height, Heights::F64(values.to_vec())).expect("a field")
        };
        let most = self.most as u64;
        let options = HoleOptions { most, memory_bytes: u64::MAX, temp_dir: std::env::temp_dir() };
        let field = of(&self.heights).with_holes_bridged(&options, &Control::default()).expect("bridged");
        if !self.weights.is_empty() {
            return field.with_importance(of(&self.weights)).expect("weights");
        }
        if self.channel.is_empty() {
            return field;
        }
        let range = Range { min: 0.0, max: 10.0 };
        let error = ChannelError::new(0.5, &Ranges { heights: range, channels: vec![range], unit: 10.0 });
        let channel = Channel { name: "red".to_string(), number: Number::F64 };
        field.with_channels(vec![(of(&self.channel), channel)], error)
    }

    pub(super) fn limit(&self, (column, row): Place, tolerance: f64) -> f64 {
        let weight = self.weights.get(row as usize * self.width + column as usize);
        weight.map_or(tolerance, |&weight| exact::limit(weight, tolerance))
    }

    pub(super) fn mesh(&self, params: &Params, threads: usize) -> Result<Mesh, Error> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let field = self.field();
        pool.install(|| triangulate(&field, &testing::in_memory(params), &Control::default()))
    }

    /// Everything the mesh must be.
    fn check(&self, params: &Params) {
        let cells = self.cells();
        let made = self.mesh(params, 1);
        if cells.is_empty() {
            assert!(matches!(made, Err(Error::NoGround { .. })), "{made:?}");
            return;
        }
        let made = made.expect("a mesh");
        let told = told(&made);
        assert!(told == super::tests::told(&self.mesh(params, 2).expect("a mesh")), "another mesh by two threads");
        let ground: BTreeSet<Place> = cells.iter().flatten().copied().collect();
        self.check_counts(&made, ground.len() as u64);
        self.check_mesh(&told, &cells, &ground, params);
    }

    fn check_counts(&self, mesh: &Mesh, ground: u64) {
        let mut errors = crate::kernel::measure::ErrorStats::default();
        mesh.chunks().for_each(|c| errors.add(&c.expect("a chunk").errors));
        let missing = self.places().filter(|&p| !self.is_ground(p)).count() as u64;
        let bridged = self.bridged.len() as u64;
        assert_eq!((errors.samples, errors.nodata, errors.bridged), (ground - bridged, missing, bridged));
        assert_eq!(errors.all_samples(), (self.width * self.height) as u64);
    }

    pub(super) fn check_mesh(&self, told: &Told, cells: &[Vec<Place>], ground: &BTreeSet<Place>, params: &Params) {
        let at = |v: u64| {
            let [x, y, _] = told.vertices[v as usize];
            let steps = |d: f64| (d * 4.0) as i32;
            Point { x: steps(x - 0.5), y: steps(-y - 0.5) }
        };
        let mut covered = BTreeSet::new();
        let mut edges: BTreeSet<(u64, u64)> = BTreeSet::new();
        let mut area = 0;
        // Rows run down, so the map's sense of turning is not the lattice's.
        for [a, c, b] in told.triangles.iter().copied() {
            let [pa, pb, pc] = [a, b, c].map(at);
            let o = orient(pa, pb, pc);
            assert!(o > 0, "orientation {o}");
            area += o;
            for edge in [(a, b), (b, c), (c, a)] {
                assert!(edges.insert(edge), "edge {edge:?} twice");
            }
            for (column, row) in self.places() {
                let p = Point::of_sample(column, row);
                let w = [orient(pb, pc, p), orient(pc, pa, p), orient(pa, pb, p)];
                if w.iter().any(|&w| w < 0) {
                    continue;
                }
                covered.insert((column, row));
                if self.bridged.contains(&(column, row)) {
                    continue;
                }
                let Some(height) = self.at((column, row)) else { panic!("sample {column}, {row} is covered") };
                let z = [a, b, c].map(|v| told.vertices[v as usize][2]);
                let terms = [(w[0], z[0]), (w[1], z[1]), (w[2], z[2]), (-o, height)];
                let limit = self.limit((column, row), params.tolerance.kept());
                assert!(exact::within(&terms, o, limit), "sample {column}, {row}");
            }
        }
        assert_eq!(area, cells.iter().map(|c| if c.len() == 4 { 32 } else { 16 }).sum::<i64>(), "area");
        assert!(covered == *ground, "{covered:?} instead of {ground:?}");
        // Edges without another side are the boundary, all of it, quarter by quarter.
        let quarters = |p: Point, q: Point| {
            let (dx, dy) = (q.x - p.x, q.y - p.y);
            let steps = dx.abs().max(dy.abs());
            assert!(dx % steps == 0 && dy % steps == 0, "edge {p:?} {q:?} runs across cells");
            let on = move |i: i32| Point { x: p.x + dx / steps * i, y: p.y + dy / steps * i };
            (0..steps).map(move |i| (on(i), on(i + 1)))
        };
        let sides = self.boundary().into_iter().map(|(p, q)| [p, q].map(|(c, r)| Point::of_sample(c, r)));
        let mut boundary: BTreeSet<(Point, Point)> = sides.flat_map(|[p, q]| quarters(p, q)).collect();
        for &(a, b) in edges.iter().filter(|&&(a, b)| !edges.contains(&(b, a))) {
            for quarter in quarters(at(a), at(b)) {
                assert!(boundary.remove(&quarter), "edge {a} {b} is inside at {quarter:?}");
            }
        }
        assert!(boundary.is_empty(), "no edge along {boundary:?}");
        let used: BTreeSet<u64> = told.triangles.iter().flatten().copied().collect();
        assert_eq!(used.len(), told.vertices.len(), "vertices in use");
        let places: BTreeMap<Point, u64> = used.iter().map(|&v| (at(v), v)).collect();
        assert_eq!(places.len(), used.len(), "two vertices at one place");
        for (column, row) in params.points.iter().flat_map(|points| points.iter()) {
            assert!(places.contains_key(&Point::of_sample(column as i32, row as i32)), "point {column}, {row}");
        }
        if params.heights == VertexHeights::Sampled {
            for (p, &v) in &places {
                let (sample, height) = ((p.x / 4, p.y / 4), told.vertices[v as usize][2]);
                match self.at(sample) {
                    Some(of_sample) => assert_eq!(of_sample, height),
                    None => assert!(self.bridged.contains(&sample) && height.is_finite()),
                }
            }
        }
    }
}

/// Heights of four kinds, with holes of five.
pub(super) fn scene(width: usize, height: usize, seed: u64, kind: u8, holes: u8) -> Scene {
    let noise = |i: usize, salt: u64| {
        let v = (i as u64 + 1 + salt * 7919).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (v ^ v >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40
    };
    let terrain = super::tests::terrain(seed % 8, width, height);
    let heights = (0..width * height).map(|i| {
        let (c, r) = ((i % width) as f64, (i / width) as f64);
        let missing = match holes {
            0 => noise(i, 1) % 16 == 0,
            1 => noise(i, 1) % 3 == 0,
            2 => noise(i, 1) % 4 != 0,
            // A coast.
            3 => c * 1.3 + (r * 0.9 + (seed % 7) as f64).sin() * 3.0 < 5.0,
            // Blocks.
            _ => noise((c / 3.0) as usize + 97 * (r / 2.0) as usize, 2) % 3 == 0,
        };
        match (missing, kind) {
            (true, _) => f64::NAN,
            (_, 0) => (noise(i, 3) % 9) as f64,
            (_, 1) => terrain[i],
            (_, 2) => c * 0.5 - r + (noise(i, 3) % 2) as f64 * 0.1,
            _ => 7.0,
        }
    });
    Scene::new(width, height, heights.collect())
}

proptest! {
    #![proptest_config(cases(100, 400))]

    #[test]
    fn the_mesh_is_the_ground_and_nothing_else(
        (width, height) in (2usize..=12, 2usize..=12), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=5], strong in any::<bool>(),
        max_error in prop_oneof![Just(0.0), Just(1.0), Just(2.5), 0.0f64..6.0, Just(1e6)],
        engine in prop::sample::select(engines()),
        (quality, heights) in prop::sample::select(qualities()),
    ) {
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let params = Params { feasibility, tile, engine, quality, heights, ..Params::new(max_error) };
        scene(width, height, seed, kind, holes).check(&params);
    }
}

proptest! {
    #![proptest_config(cases(100, 400))]

    #[test]
    fn bridged_holes_are_ground_that_nothing_binds(
        (width, height) in (4usize..=14, 4usize..=14), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=6], strong in any::<bool>(),
        max_error in prop_oneof![Just(0.0), Just(1.0), 0.0f64..6.0], most in prop_oneof![Just(1usize), 2usize..30],
        weighted in prop::bool::weighted(0.3), engine in prop::sample::select(engines()),
        (quality, heights) in prop::sample::select(qualities()),
    ) {
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let mut scene = scene(width, height, seed, kind, holes).bridging(most);
        if weighted {
            scene.weigh();
        }
        // Points may lie in bridged holes; only insertion takes them.
        let insertion = engine.capabilities().points;
        let ground = scene.places().filter(|&p| insertion && (0..4).any(|i| {
            let corner = (p.0 - i % 2, p.1 - i / 2);
            [(0, 0), (1, 0), (0, 1), (1, 1)].iter().filter(|d| scene.is_ground((corner.0 + d.0, corner.1 + d.1))).count() >= 3
        }) && scene.is_ground(p));
        let points = ground.filter(|p| (p.0 * 7 + p.1 * 5) % 9 == 0).map(|(c, r)| (c as usize, r as usize));
        let points = Some(Arc::new(PointSet::new(points.collect::<Vec<_>>())));
        let params = Params { feasibility, tile, engine, quality, heights, points, ..Params::new(max_error) };
        scene.check(&params);
    }
}

proptest! {
    #![proptest_config(cases(40, 100))]

    #[test]
    fn with_weights_and_points(
        (width, height) in (3usize..=12, 3usize..=12), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=5], max_error in prop_oneof![Just(1.0), 0.0f64..6.0],
        weighted in any::<bool>(), points in prop::collection::vec(0usize..144, 0..12),
        (quality, heights) in prop::sample::select(qualities()),
    ) {
        let mut scene = scene(width, height, seed, kind, holes);
        if weighted {
            scene.weigh();
        }
        let points = scene.points_of(points);
        let params = Params { tile, quality, heights, points: Some(Arc::new(points)), ..Params::new(max_error) };
        scene.check(&params);
    }

    #[test]
    fn with_a_channel(
        (width, height) in (3usize..=12, 3usize..=12), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=5], max_error in prop_oneof![Just(1.0), 0.0f64..6.0],
    ) {
        let mut scene = scene(width, height, seed, kind, holes);
        let red = |(i, z): (usize, &f64)| if z.is_nan() { f64::NAN } else { (i * 31 % 10) as f64 };
        scene.channel = scene.heights.iter().enumerate().map(red).collect();
        scene.check(&Params { tile, quality: Quality::None, ..Params::new(max_error) });
    }
}

#[test]
fn what_cannot_be_without_heights_says_so() {
    let scene = scene(12, 12, 5, 0, 1);
    let missing = scene.places().find(|&p| scene.at(p).is_none()).expect("a hole");
    let points = PointSet::new([(missing.0 as usize, missing.1 as usize)]);
    let pointed = Params { points: Some(Arc::new(points)), ..Params::new(1.0) };
    let off = scene.mesh(&pointed, 1);
    assert!(
        matches!(off, Err(Error::PointOffGround { column, row }) if (column as i32, row as i32) == missing),
        "{off:?}"
    );
    // A weight is missing where there is a height.
    let there = scene.heights.iter().position(|z| !z.is_nan()).expect("a height");
    let weights = (0..144).map(|i| if i == there { f64::NAN } else { 1.0 }).collect();
    let unweighted = Scene { weights, ..scene }.mesh(&Params::new(1.0), 1);
    assert!(matches!(unweighted, Err(Error::Field(FieldError::NotAWeight { .. }))), "{unweighted:?}");
}

#[test]
fn larger_grounds_with_many_holes() {
    for holes in 0..5 {
        for engine in [EngineChoice::default(), GreedyCuts::IMPROVED.into(), HittingSet::default().into()] {
            for (quality, heights) in
                [(Quality::None, VertexHeights::Sampled), (Quality::Balanced, VertexHeights::Fitted)]
            {
                let params = Params { engine, quality, heights, tile: 24, ..Params::new(3.0) };
                scene(70, 60, 5, 1, holes).check(&params);
            }
        }
    }
}

/// Every pattern of 3 × 3 samples, cut into tiles of one cell and in one piece.
#[test]
fn every_small_ground() {
    for pattern in 0u32..512 {
        let height = |i: usize| if pattern >> i & 1 == 1 { (i * i % 5) as f64 } else { f64::NAN };
        let heights = (0..9).map(height).collect();
        let scene = Scene::new(3, 3, heights);
        let usual = EngineChoice::default();
        for (tile, engine) in [(0, usual), (1, usual), (1, GreedyCuts::PLAIN.into()), (0, HittingSet::default().into())]
        {
            let params = Params { tile, engine, quality: Quality::None, ..Params::new(1.0) };
            scene.check(&params);
        }
    }
}

/// A polygon with a hole over a raster: as if there were no heights outside, whatever the tiles, the threads and the way
/// to the samples.
#[test]
fn outside_of_a_cutline_is_as_without_heights() {
    const SIZE: (usize, usize) = (70, 50);
    let folder = testing::folder();
    let (path, layer) = (folder.path().join("dem.tif"), folder.path().join("cut.geojson"));
    let mut heights: Vec<f64> = (0..SIZE.0 * SIZE.1).map(|i| (i * i % 1009) as f64 / 100.0).collect();
    let driver = gdal::DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let dataset = driver.create_with_band_type::<f64, _>(&path, SIZE.0, SIZE.1, 1).expect("a raster");
    let mut buffer = gdal::raster::Buffer::new(SIZE, heights.clone());
    dataset.rasterband(1).expect("a band").write((0, 0), SIZE, &mut buffer).expect("written");
    dataset.close().expect("closed");
    // Without a geotransform x is column + ½ and y is −(row + ½).
    let rings = "[[[3,-2],[66,-12],[50,-47],[8,-40],[3,-2]],[[20,-20],[33,-18],[28,-31],[20,-20]]]";
    let geometry = format!(r#"{{"type": "Polygon", "coordinates": {rings}}}"#);
    std::fs::write(&layer, format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {geometry}}}"#))
        .expect("written");
    let source = CutlineSource { path: layer, layer: None };
    let open = || Raster::open(&path, 1).expect("a raster");
    let cutline = read_cutline(&open(), &source, &Control::default().cancel).expect("polygons").0;
    let mut inside = Vec::new();
    cutline.mask(Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 }, &mut inside);
    assert!((1000..2500).contains(&inside.iter().filter(|i| **i).count()));
    heights.iter_mut().zip(&inside).filter(|(_, inside)| !**inside).for_each(|(z, _)| *z = f64::NAN);
    let scene = Scene::new(SIZE.0, SIZE.1, heights);
    for tile in [9, 16, 33, 0] {
        let params = Params { tile, ..Params::new(1.5) };
        scene.check(&params);
        let expected = told(&scene.mesh(&params, 1).expect("a mesh"));
        for (threads, choice) in [(1, Choice::Auto), (3, Choice::Windows), (4, Choice::Decode)] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let options = FieldOptions { choice, ..FieldOptions::default() };
            let raster = open().with_cutline(cutline.clone());
            let (control, params) = (Control::default(), &params);
            let mesh = pool.install(move || {
                let field = Field::open(&raster.to_band().expect("a band"), &options, &control)?;
                triangulate(&field, params, &control)
            });
            assert!(told(&mesh.expect("a mesh")) == expected, "tiles of {tile}, {threads} threads, {choice:?}");
        }
    }
}
