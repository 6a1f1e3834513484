//! All passes over all tiles: from a field to a mesh.

use super::passes::{Job, Pass, PassResult, run_pass};
use std::path::Path;

use super::search::{self, Makers, Store};
use super::spool::{Chunks, Spool, SpoolError};
use super::{Error, Mesh, Params};
use crate::base::control::Control;
use crate::base::features::FeatureSet;
use crate::field::Field;

/// Triangulates a field on the threads of the current rayon pool.
///
/// Memory: one workspace per busy thread (a tile's samples, its front and its mesh), whatever the size of the field.
/// Temporary disk: about 20 bytes per triangle, and 2 KiB per tile for the histogram of its errors. Under a goal that a
/// tolerance is looked for ([`Params::is_searched`]) whole runs are made, about two, and the disk holds two meshes.
///
/// # Errors
/// [`Error`]; nothing is left behind.
pub fn triangulate(field: &Field, params: &Params, control: &Control<'_>) -> Result<Mesh, Error> {
    triangulate_into(&Temporary(&params.temp_dir), field, params, control)
}

/// Keeps chunks in temporary files.
struct Temporary<'a>(&'a Path);

impl Store for Temporary<'_> {
    fn spool(&self, _: Option<f64>, pass: &Pass) -> Result<Spool, SpoolError> {
        Spool::new(self.0, pass.grid().len())
    }
}

/// Makes the spool for a pass.
pub type MakeSpool<'a> = dyn Fn(&Pass) -> Result<Spool, SpoolError> + 'a;

/// Does what [`triangulate`] does, into spools of the caller's. A tile whose chunk a spool has already is not made again.
///
/// # Errors
/// [`Error`]; what becomes of the finished tiles is the spools' matter.
///
/// # Panics
/// If a spool is for another number of tiles.
pub fn triangulate_into(
    store: &dyn Store,
    field: &Field,
    params: &Params,
    control: &Control<'_>,
) -> Result<Mesh, Error> {
    if params.is_searched(FeatureSet::of_field(field)) {
        return search::triangulate(Makers::Here, store, field, params, control);
    }
    run_to_the_end(&|pass| store.spool(None, pass), field, params, control)
}

/// One run: all passes, and all of them again with short links, if edges stray.
pub(super) fn run_to_the_end(
    make_spool: &MakeSpool<'_>,
    field: &Field,
    params: &Params,
    control: &Control<'_>,
) -> Result<Mesh, Error> {
    let job = Job::new(field, params, control)?;
    let (mesh, result) = run(make_spool, &job)?;
    match job.again(&result) {
        None => Ok(mesh),
        Some(again) => {
            drop(mesh);
            run(make_spool, &again).map(|(mesh, _)| mesh)
        }
    }
}

/// All passes of a job, and what came of them.
fn run(make_spool: &MakeSpool<'_>, job: &Job<'_>) -> Result<(Mesh, PassResult), Error> {
    let passes = job.passes();
    let [first, others @ ..] = passes.as_slice() else { unreachable!("there is a first pass") };
    // Before the survey, which may take long.
    let mut spool = make_spool(first)?;
    let job = job.clone().surveyed()?;
    let mut result = whole(&job, first, None, &spool)?;
    let found = result.found;
    must_have_ground(&job, &spool, first)?;
    let mut last = first;
    let (mut held, mut most) = (spool.bytes(), spool.bytes());
    for pass in others {
        let next = make_spool(pass)?;
        result = result.plus(whole(&job, pass, Some(&spool), &next)?);
        // A spool that is not kept is gone once the next pass is done.
        held = if spool.is_kept() { held } else { spool.bytes() } + next.bytes();
        most = most.max(held);
        (spool, last) = (next, pass);
    }
    let spool_bytes = most + job.end.map_or(0, |end| end.survey_bytes);
    let mesh = Mesh { times: result.times, spool_bytes, found, ..Mesh::of(&job, spool, last) };
    Ok((mesh, result))
}

/// All tiles of a pass.
fn whole(job: &Job<'_>, pass: &Pass, inputs: Option<&Spool>, out: &Spool) -> Result<PassResult, Error> {
    let inputs = inputs.map(|spool| spool as &dyn Chunks);
    let result = run_pass(job, pass, 0..pass.grid().len(), inputs, out)?;
    result.check_bare();
    Ok(result)
}

/// Refuses a job no tile of which has a triangle, by the chunks of a pass.
pub(super) fn must_have_ground(job: &Job<'_>, spool: &Spool, pass: &Pass) -> Result<(), Error> {
    let (columns, rows) = (pass.grid().columns(), pass.grid().rows());
    for row in 0..rows {
        if spool.counts(row * columns..(row + 1) * columns)?.iter().any(|c| c.triangles > 0) {
            return Ok(());
        }
    }
    Err(Error::NoGround { path: job.field.name().to_path_buf() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Heights;
    use crate::job::Quality;
    use crate::job::tests::certify_weighted;

    /// Sides are level, and so one link each, as nobody polishes here; what is beside them is wild. Links of a quarter do.
    #[test]
    fn where_long_links_are_in_the_way_of_the_limit_the_run_is_made_again() {
        let (width, height, tile) = (97, 97, 24);
        let wild = |i: usize| {
            let (column, row) = (i % width, i / width);
            let is_level = column % tile == 0 || row % tile == 0;
            if is_level { 0.0 } else { (i * 7919 % 97) as f64 }
        };
        let heights: Vec<f64> = (0..width * height).map(wild).collect();
        let field = Field::from_heights(width, height, Heights::F64(heights.clone())).expect("a field");
        let params = Params { tile, quality: Quality::None, max_stray: Some(1.0), ..Params::new(1.0) };
        let control = Control::default();
        let job = Job::new(&field, &params, &control).expect("a job");
        let (_, result) = run(&|pass| Spool::new(&params.temp_dir, pass.grid().len()), &job).expect("a mesh");
        assert!(job.again(&result).is_some(), "edges are left that stray");
        certify_weighted(width, height, &heights, None, &params);
    }
}
