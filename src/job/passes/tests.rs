//! Passes over ranges of tiles, in any order and any place, come to the bytes of one run.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use proptest::prelude::*;

use super::{Job, Pass, PassResult, run_pass};
use crate::base::control::Control;
use crate::job::nodata_tests::scene;
use crate::job::spool::{Chunk, Chunks, Spool, SpoolError};
use crate::job::{Goal, Params, Quality, Store, triangulate_into};
use crate::testing::cases;

fn folder(dir: &Path, pass: &Pass) -> PathBuf {
    dir.join(format!("pass {}", pass.folder()))
}

fn spool(dir: &Path, pass: &Pass) -> Spool {
    Spool::kept(&folder(dir, pass), pass.grid().columns(), pass.grid().len(), 3, false).expect("a spool")
}

/// The files of a pass, by row and column.
fn files(dir: &Path, pass: &Pass) -> BTreeMap<String, Vec<u8>> {
    let entries = |dir: &Path| dir.read_dir().into_iter().flatten().map(|e| e.expect("an entry").path());
    let rows = entries(&folder(dir, pass));
    let all = rows.flat_map(|row| entries(&row).collect::<Vec<_>>());
    let relative = |path: &Path| path.strip_prefix(dir).expect("inside").display().to_string();
    all.map(|path| (relative(&path), fs::read(&path).expect("a chunk"))).collect()
}

/// Chunks that lie in several places, by the ranges of their tiles.
struct Parts {
    tiles: usize,
    parts: Vec<(Range<usize>, Spool)>,
}

impl Chunks for Parts {
    fn tiles(&self) -> usize {
        self.tiles
    }

    fn read(&self, tile: usize, chunk: &mut Chunk, buffer: &mut Vec<u8>) -> Result<(), SpoolError> {
        let (_, spool) = self.parts.iter().find(|(range, _)| range.contains(&tile)).expect("the tile's part");
        spool.read(tile, chunk, buffer)
    }
}

/// Cuts tiles into ranges, some of them empty, and shuffles these.
fn ranges(len: usize, cuts: &[usize], order: u64) -> Vec<Range<usize>> {
    let mut ends: Vec<usize> = cuts.iter().map(|cut| cut % (len + 1)).chain([0, len]).collect();
    ends.sort_unstable();
    let mut ranges: Vec<Range<usize>> = ends.windows(2).map(|ends| ends[0]..ends[1]).collect();
    let mut state = order;
    for last in (1..ranges.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ranges.swap(last, (state >> 33) as usize % (last + 1));
    }
    ranges
}

struct InFolder<'a>(&'a Path);

impl Store for InFolder<'_> {
    fn spool(&self, _: Option<f64>, pass: &Pass) -> Result<Spool, SpoolError> {
        Ok(spool(self.0, pass))
    }
}

proptest! {
    #![proptest_config(cases(16, 400))]

    /// Each range by a job of its own, which knows of the others no more than another process would.
    #[test]
    fn ranges_come_to_the_bytes_of_one_run(
        (width, height) in (2usize..60, 2usize..60), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..4,
        tile in prop_oneof![Just(0usize), 4usize..24], cuts in prop::collection::vec(any::<usize>(), 0..5),
        order in any::<u64>(), trim in prop_oneof![Just(0u32), 1u32..4], what in 0u8..4, one_spool in any::<bool>(),
    ) {
        let scene = scene(width, height, seed, kind, holes);
        let params = Params { tile, ..Params::new(1.0) };
        let params = match what {
            0 => Params { quality: Quality::None, trim, ..params },
            1 => {
                let goal = Goal { max_rms: Some(0.4), ..Goal::default() };
                Params { quality: Quality::None, goal, ..params }
            }
            _ => Params { trim, ..params },
        };
        let (field, control) = (scene.field(), Control::default());
        let folder = tempfile::tempdir().expect("a folder");
        let (one, merged) = (folder.path().join("one"), folder.path().join("merged"));
        [&one, &merged].iter().for_each(|dir| fs::create_dir(dir).expect("made"));
        let Ok(whole) = triangulate_into(&InFolder(&one), &field, &params, &control) else {
            // No ground.
            return Ok(());
        };

        let mut attempt = Some(Job::new(&field, &params, &control).expect("a job"));
        while let Some(of_all) = attempt {
        let mut before: Option<Parts> = None;
        let mut last = PassResult::default();
        for pass in of_all.passes() {
            let mut sum = PassResult::default();
            let mut parts = Vec::new();
            for (i, range) in ranges(pass.grid().len(), &cuts, order).into_iter().enumerate() {
                let job = of_all.clone().surveyed().expect("a job");
                let dir = if one_spool { merged.clone() } else { folder.path().join(format!("part {i}")) };
                fs::create_dir_all(&dir).expect("made");
                let out = spool(&dir, &pass);
                let inputs = before.as_ref().map(|parts| parts as &dyn Chunks);
                sum = sum.plus(run_pass(&job, &pass, range.clone(), inputs, &out).expect("made"));
                for (path, bytes) in files(&dir, &pass) {
                    let path = merged.join(path);
                    fs::create_dir_all(path.parent().expect("a row")).expect("made");
                    fs::write(path, bytes).expect("copied");
                }
                parts.push((range, out));
            }
            sum.check_bare();
            prop_assert_eq!(sum.found, 0);
            prop_assert_eq!(files(&one, &pass), files(&merged, &pass));
            before = Some(Parts { tiles: pass.grid().len(), parts });
            last = sum;
        }
        attempt = of_all.again(&last);
        }

        let put_together = triangulate_into(&InFolder(&merged), &field, &params, &control).expect("found");
        prop_assert_eq!(put_together.tiles_found(), whole.grid().len() as u64);
        let chunks = |mesh: &crate::job::Mesh| mesh.chunks().map(|c| c.expect("a chunk")).collect::<Vec<_>>();
        prop_assert_eq!(chunks(&put_together), chunks(&whole));
    }

    /// Together the tiles of a pass need every tile of the one before, and each those that it overlaps.
    #[test]
    fn a_tile_needs_what_it_overlaps((width, height) in (2usize..90, 2usize..90), tile in 2usize..30) {
        let params = Params { tile, ..Params::new(1.0) };
        let passes = super::passes(width, height, &params).expect("passes");
        prop_assert_eq!(passes[0].needed(0).count(), 0);
        for two in passes.windows(2) {
            let (before, pass) = (&two[0], &two[1]);
            let (grid, needed_grid) = (pass.grid(), before.grid());
            prop_assert_eq!(pass.needs(), Some(before.name()));
            for tile in 0..grid.len() {
                let overlaps = |&other: &usize| {
                    let (a, b) = (grid.place(tile).window, needed_grid.place(other).window);
                    // More than a line in common.
                    let common = |at: usize, of: usize, other_at: usize, other_of: usize| {
                        (at + of).min(other_at + other_of) > at.max(other_at) + 1
                    };
                    common(a.column, a.width, b.column, b.width) && common(a.row, a.height, b.row, b.height)
                };
                let expected: Vec<usize> = (0..needed_grid.len()).filter(overlaps).collect();
                prop_assert_eq!(pass.needed(tile).collect::<Vec<_>>(), expected);
            }
        }
    }
}
