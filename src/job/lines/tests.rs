//! Lines beside memory against the same in memory.

use proptest::prelude::*;

use super::*;
use crate::base::control::{CancelToken, Control};
use crate::field::Field;
use crate::job::{Mesh, Params, Quality, triangulate};
use crate::testing::cases;

fn line(size: (usize, usize)) -> impl Strategy<Value = Vec<(f64, f64)>> {
    let number = |samples: usize| {
        let last = samples as f64 - 1.0;
        prop_oneof![
            2 => -2.0..last + 2.0,
            // Near the lines between strips and between lists.
            1 => (60.0..68.0f64).prop_map(move |v| v.min(last)),
            1 => (0.0..last).prop_map(|v| (v * 4.0).round() / 4.0),
            1 => (0.0..last).prop_map(f64::round),
        ]
    };
    prop::collection::vec((number(size.0), number(size.1)), 0..12)
}

pub(crate) fn scratch() -> Scratch {
    Scratch::new(None, CancelToken::default())
}

proptest! {
    #![proptest_config(cases(60, 2000))]

    /// Whatever part of them is looked at, with heights of their own and without.
    #[test]
    fn lines_beside_memory_are_the_same(
        lines in prop::collection::vec(line((300, 150)), 1..9), with_heights in any::<bool>(),
        window in (0usize..250, 0usize..120, 2usize..50, 2usize..30), kept in 0usize..40,
    ) {
        let size = (300, 150);
        let heights = lines.iter().map(|line| line.iter().map(|(x, y)| (x * 2.0 + y * 3.0).sin() * 9.0).collect());
        let roads = Polylines::new(lines.clone()).with_heights(heights.collect());
        let roads = if with_heights { roads } else { roads.without_heights() };
        let walls = Polylines::new(lines.into_iter().rev().take(2).map(|line| line.into_iter().skip(1).collect()).collect());
        let sets = [
            LineSet { kind: LineKind::Breaklines, lines: roads, shift: 0.5 },
            LineSet { kind: LineKind::Footprints, lines: walls, shift: 2.0 },
        ];
        let memory = Lines::new(&sets, size, scratch(), Lines::IN_MEMORY).expect("near lines");
        let shelved = Lines::new(&sets, size, scratch(), kept).expect("near lines");
        let all = memory.near(Window { column: 0, row: 0, width: 2, height: 2 }).expect("memory");
        prop_assert_eq!(memory.named(), shelved.named());
        prop_assert_eq!(memory.height_range(), shelved.height_range());
        prop_assert!(memory.counts().eq(shelved.counts()));
        for tolerance in [0.0, 0.3, 2.0, 30.0] {
            prop_assert_eq!(memory.check_heights(tolerance), shelved.check_heights(tolerance));
        }
        let (column, row, width, height) = window;
        let (rows, columns) = (row as i64 * 4..=(row + height) as i64 * 4, column as i64 * 4..=(column + width) as i64 * 4);
        let window = Window { column, row, width, height };
        let is_in = |segment: &&[crate::kernel::breaklines::Place; 2]| segment.iter().all(|p| rows.contains(&p.y) && columns.contains(&p.x));
        let (near, in_rows) = (shelved.near(window).expect("a file"), shelved.in_rows(&(*rows.start()..*rows.end())).expect("a file"));
        for some in [near, in_rows] {
            let found: Vec<_> = some.segments().iter().filter(is_in).collect();
            let expected: Vec<_> = all.segments().iter().filter(is_in).collect();
            prop_assert_eq!(&found, &expected);
            for segment in found {
                prop_assert_eq!(some.sets_of(*segment), all.sets_of(*segment));
                prop_assert_eq!(segment.map(|p| some.height_at(p)), segment.map(|p| all.height_at(p)));
            }
        }
    }
}

/// A mesh as it is written, with its edges along lines.
fn written(mesh: &Mesh) -> Vec<u8> {
    let folder = crate::testing::folder();
    let path = folder.path().join("tin.ply");
    let staged = crate::base::staged::StagedFile::create(&path, true, &[] as &[&std::path::Path]).expect("staged");
    let sink = crate::formats::PlySink::new(staged, crate::formats::Header::default());
    mesh.write(Box::new(sink), &Control::default()).expect("written");
    std::fs::read(path).expect("a file")
}

proptest! {
    #![proptest_config(cases(6, 300))]

    /// Over several strips and several bands of tiles, and rings that cross them, with any number of threads.
    #[test]
    fn meshes_along_lines_beside_memory_are_the_same(
        lines in prop::collection::vec(line((170, 150)), 1..6), ring in (20.0..120.0f64, 20.0..100.0f64, 3.0..50.0f64),
        tile in 8usize..24, is_polished in any::<bool>(), gaps in any::<bool>(), with_heights in any::<bool>(),
        threads in 1usize..4,
    ) {
        let size = (170, 150);
        let mut lines = lines;
        let corner = |i: usize| {
            let angle = (i % 30) as f64 * std::f64::consts::TAU / 30.0;
            (ring.0 + ring.2 * angle.cos(), ring.1 + ring.2 * angle.sin())
        };
        lines.push((0..=30).map(corner).collect());
        let heights = lines.iter().map(|line| line.iter().map(|(x, y)| 40.0 + x / 8.0 - y / 16.0).collect()).collect();
        let lines = Polylines::new(lines).with_heights(heights);
        let lines = if with_heights { lines } else { lines.without_heights() };
        let set = [LineSet { kind: LineKind::Breaklines, lines, shift: 0.5 }];
        let mut samples = crate::job::tests::terrain(3, size.0, size.1);
        samples.iter_mut().enumerate().filter(|(i, _)| gaps && i / 7 % 31 == 0).for_each(|(_, z)| *z = f64::NAN);
        let made = |in_memory: usize, threads: usize| {
            let lines = Lines::new(&set, size, scratch(), in_memory).expect("near lines");
            let quality = if is_polished { Quality::Fast } else { Quality::None };
            let params = Params { tile, quality, breaklines: Some(Arc::new(lines)), ..Params::new(4.0) };
            let field = Field::from_heights(size.0, size.1, crate::base::Heights::F64(samples.clone())).expect("a field");
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| triangulate(&field, &params, &Control::default()).map(|mesh| written(&mesh)))
        };
        match (made(Lines::IN_MEMORY, 1), made(0, threads)) {
            (Ok(memory), Ok(beside)) => prop_assert!(memory == beside),
            (Err(memory), Err(beside)) => prop_assert_eq!(memory.to_string(), beside.to_string()),
            (memory, beside) => panic!("{:?} and {:?}", memory.is_ok(), beside.is_ok()),
        }
    }
}
