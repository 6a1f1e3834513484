//! Mending: samples are inserted where edges stray farther than they may ([`Task::max_stray`]), whatever made the mesh.
//!
//! A mesh of all samples with Delaunay edges keeps every limit of at least one tolerance: none of its edges crosses a side of a
//! cell. So of a side that is crossed a sample is inserted, then whatever that leaves beyond the tolerance, until no edge
//! strays. Where an edge that stays is in the way, an edge may be left: no longer, about, than that one.

use std::collections::HashSet;

use super::refine::{FreeRim, Refinement, Split};
use super::surface::Site;
use super::topology::{next, prev};
use super::{InsertionOptions, Scratch, Task};
use crate::base::RasterRim;
use crate::base::control::Cancelled;
use crate::base::mesh::{Domain, TileMesh};
use crate::base::tiling::TilePlace;
use crate::kernel::triangulate::EngineScratch;
use crate::kernel::triangulate::feasible::{Side, Tester};

/// Edges between two looks at the cancellation token.
const EDGES_BETWEEN_CHECKS: u32 = 4096;
/// How far from an edge that strays beside one that stays others are made Delaunay, in triangles.
const RINGS_BESIDE_RIM: usize = 3;

/// Inserts samples into the mesh of a tile over `domain`, until no edge inside strays farther than it may. Every triangle is to be
/// within the tolerance before, and is after. Vertices stay, new ones follow; the edges of loops stay that run along the
/// sides of the tile, and others are split where that is needed: `domain` then has the vertices of the mesh's rim, and the mesh
/// begins with them. Returns how many edges stray all the same, next to the sides.
///
/// `task.domain` does not matter. Where nothing strays the mesh is left as it is, for the price of a look at its edges.
///
/// # Errors
/// [`Cancelled`], with a mesh of no use.
pub fn mend_tile(
    task: &Task<'_>,
    domain: &mut Domain,
    scratch: &mut EngineScratch,
    mesh: &mut TileMesh,
) -> Result<u64, Cancelled> {
    let sides = RasterRim::of(&TilePlace::alone(task.tile.width(), task.tile.height()));
    let (left, splits) = mend(&Task { domain: &*domain, ..*task }, FreeRim::Beside(sides), scratch, mesh)?;
    if !splits.is_empty() {
        take_up(&splits, domain, mesh);
    }
    Ok(left)
}

/// Does what [`mend_tile`] does to a part of a mesh. Edges of one triangle stay, but for those along `rim`, which may be split. Of the
/// task's domain its edges count, which stay.
///
/// # Errors
/// [`Cancelled`], with a mesh of no use.
pub fn mend_part(
    task: &Task<'_>,
    rim: RasterRim,
    scratch: &mut EngineScratch,
    mesh: &mut TileMesh,
) -> Result<u64, Cancelled> {
    mend(task, FreeRim::Along(rim), scratch, mesh).map(|(left, _)| left)
}

fn mend(
    task: &Task<'_>,
    free_rim: FreeRim,
    scratch: &mut EngineScratch,
    mesh: &mut TileMesh,
) -> Result<(u64, Vec<Split>), Cancelled> {
    task.cancel.check()?;
    let tester = Tester::new(task.tile, task.tolerance, task.feasibility).with_max_stray(task.max_stray);
    if !tester.limits_strays() || !mesh.triangles.iter().any(|&t| strays(&tester, mesh, t)) {
        return Ok((0, Vec::new()));
    }
    let scratch = scratch.of::<Scratch>();
    let mut refinement = scratch.refine_mesh(InsertionOptions::default(), task, mesh);
    refinement.free_rim = free_rim;
    let left = refinement.mend(&tester)?;
    let splits = std::mem::take(&mut refinement.splits);
    refinement.finish(mesh);
    scratch.hand_over();
    Ok((left, splits))
}

/// Whether an edge of a triangle strays. An edge between two triangles is looked at in one of them.
fn strays(tester: &Tester<'_>, mesh: &TileMesh, [a, b, c]: [u32; 3]) -> bool {
    let vertex = |i: u32| mesh.vertices[i as usize];
    [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| p < q && tester.strays(vertex(p), vertex(q)))
}

/// Makes vertices of split edges the domain's: the last of its loops' vertices.
fn take_up(splits: &[Split], domain: &mut Domain, mesh: &mut TileMesh) {
    let (known, count) = (domain.vertices.len() as u32, mesh.vertices.len() as u32);
    let is_new: HashSet<u32> = splits.iter().map(|split| split.vertex).collect();
    let others = (known..count).filter(|v| !is_new.contains(v));
    let order: Vec<u32> = (0..known).chain(splits.iter().map(|split| split.vertex)).chain(others).collect();
    let mut numbers = vec![0; order.len()];
    (0u32..).zip(&order).for_each(|(new, &old)| numbers[old as usize] = new);
    mesh.vertices = order.iter().map(|&v| mesh.vertices[v as usize]).collect();
    mesh.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
    domain.vertices.extend_from_slice(&mesh.vertices[known as usize..known as usize + splits.len()]);
    for split in splits {
        let [from, to] = split.edge.map(|v| numbers[v as usize]);
        let is_edge = |l: &Vec<u32>, i: usize| l[i] == from && l[(i + 1) % l.len()] == to;
        let place =
            domain.loops.iter().enumerate().find_map(|(n, l)| (0..l.len()).find(|&i| is_edge(l, i)).map(|i| (n, i)));
        let (n, i) = place.unwrap_or_else(|| panic!("a loop along the edge {from} {to}, which was split"));
        domain.loops[n].insert(i + 1, numbers[split.vertex as usize]);
    }
}

/// What has come of an edge that strays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// A sample was inserted, or edges were turned.
    Done,
    /// An edge that stays is in the way.
    Blocked,
}

impl Refinement<'_> {
    /// Mends all edges, or all but some that it returns the number of.
    fn mend(&mut self, tester: &Tester<'_>) -> Result<u64, Cancelled> {
        let (mut turned, mut strays) = (HashSet::new(), Vec::new());
        loop {
            let (mut mended, mut left) = (false, 0);
            let mut e = 0;
            while e < 3 * self.surface.topology.len() {
                if e.is_multiple_of(EDGES_BETWEEN_CHECKS) {
                    self.cancel.check()?;
                }
                self.list_strays(tester, e, &mut strays);
                if !strays.is_empty() {
                    match self.mend_edge(tester, e, &strays, &mut turned) {
                        Way::Done => mended = true,
                        Way::Blocked => left += 1,
                    }
                }
                e += 1;
            }
            if !mended {
                return Ok(left);
            }
            self.run()?;
        }
    }

    /// Where an edge between two triangles strays, at that of its half-edges which is met first.
    fn list_strays(&self, tester: &Tester<'_>, e: u32, into: &mut Vec<Side>) {
        let topology = &self.surface.topology;
        into.clear();
        if !topology.is_locked(e) && topology.twin(e) > e {
            let [p, q] = [topology.origin(e), topology.origin(next(e))].map(|v| self.surface.vertices[v as usize]);
            tester.list_strays(p, q, into);
        }
    }

    /// Inserts a sample of a side that an edge strays at. Where all are vertices turns the edge, or, as a last resort, those
    /// around it that are not Delaunay.
    fn mend_edge(&mut self, tester: &Tester<'_>, e: u32, strays: &[Side], turned: &mut HashSet<[u32; 2]>) -> Way {
        let width = self.scanner.tile.width;
        let mut is_blocked = false;
        for &(column, row) in strays.as_flattened() {
            let sample = (row * width + column) as u64;
            let site = self.surface.locate(e / 3, self.place(sample));
            if !self.stays(site) && self.insert_at(site, sample).is_some() {
                return Way::Done;
            }
            is_blocked |= !matches!(site, Site::Vertex(_));
        }
        let rings = if is_blocked { RINGS_BESIDE_RIM } else { usize::MAX };
        if self.turn(tester, e, turned) || self.legalize_near(e, rings) { Way::Done } else { Way::Blocked }
    }

    /// Turns an edge, if its triangles are then within the tolerance and the new edge does not stray. None is turned twice.
    fn turn(&mut self, tester: &Tester<'_>, e: u32, turned: &mut HashSet<[u32; 2]>) -> bool {
        if !self.surface.is_convex(e) {
            return false;
        }
        let topology = &self.surface.topology;
        let numbers = [e, next(e), prev(e), prev(topology.twin(e))].map(|e| topology.origin(e));
        let [x, y, p, q] = numbers.map(|v| self.surface.vertices[v as usize]);
        let fits = |corners| self.scanner.candidate(corners, [false; 3]).is_none();
        if !tester.may_join(p, q) || !fits([x, q, p]) || !fits([q, y, p]) {
            return false;
        }
        if !turned.insert([numbers[0].min(numbers[1]), numbers[0].max(numbers[1])]) {
            return false;
        }
        let both = self.surface.topology.flip(e);
        both.into_iter().for_each(|t| self.rescan(t));
        true
    }

    /// Turns the nearest edges that are not Delaunay, up to so many triangles away, and those that are not because of it.
    fn legalize_near(&mut self, e: u32, rings: usize) -> bool {
        let mut reached = vec![e / 3];
        let mut seen = vec![false; self.surface.topology.len() as usize];
        seen[e as usize / 3] = true;
        let (mut ahead, mut ring) = (0, 0);
        while ahead < reached.len() && ring <= rings {
            let behind = reached.len();
            let suspects = reached[ahead..].iter().flat_map(|&t| 3 * t..3 * t + 3).collect();
            let changed = self.surface.legalize_from(suspects);
            if !changed.is_empty() {
                changed.into_iter().for_each(|t| self.rescan(t));
                return true;
            }
            for i in ahead..behind {
                for side in 3 * reached[i]..3 * reached[i] + 3 {
                    let is_locked = self.surface.topology.is_locked(side);
                    let beyond = self.surface.topology.twin(side) / 3;
                    if !is_locked && !std::mem::replace(&mut seen[beyond as usize], true) {
                        reached.push(beyond);
                    }
                }
            }
            (ahead, ring) = (behind, ring + 1);
        }
        false
    }
}
