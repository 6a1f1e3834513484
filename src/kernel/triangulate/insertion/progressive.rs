//! Insertion in an order that whole rasters can agree on: most of the rim is not there from the start but comes vertex by
//! vertex, each when the errors inside have come down to its own.
//!
//! The order is that of [`crate::kernel::triangulate::progressive`].

use super::refine::Refinement;
use super::surface::Site;
use super::topology::NONE;
use crate::base::control::Cancelled;
use crate::base::mesh::Domain;
use crate::kernel::triangulate::progressive::{Event, Key, Order, Share};

/// The domain with only those vertices on its loops that are there from the start.
pub(super) fn beginning(domain: &Domain, rim: &[(Key, u32)]) -> Domain {
    let mut comes = vec![false; domain.vertices.len()];
    rim.iter().for_each(|&(_, v)| comes[v as usize] = true);
    let first = |l: &Vec<u32>| l.iter().copied().filter(|&v| !comes[v as usize]).collect();
    Domain {
        vertices: domain.vertices.clone(),
        loops: domain.loops.iter().map(first).collect(),
        points: domain.points.clone(),
        edges: domain.edges.clone(),
    }
}

/// The loops of a domain with the vertices that have come so far.
struct Outline {
    /// The vertex before, along the loop, of those that are still to come; of others [`NONE`].
    before: Vec<u32>,
}

impl Outline {
    fn new(domain: &Domain, rim: &[(Key, u32)]) -> Outline {
        let mut before = vec![NONE; domain.vertices.len()];
        rim.iter().for_each(|&(_, v)| before[v as usize] = v);
        for l in &domain.loops {
            for (&u, &v) in l.iter().cycle().skip(l.len() - 1).zip(l) {
                if before[v as usize] == v {
                    before[v as usize] = u;
                }
            }
        }
        Outline { before }
    }

    /// The last vertex on the way to `vertex` that is there. From now on `vertex` is there, too.
    fn before(&mut self, vertex: u32) -> u32 {
        let steps = std::iter::successors(Some(self.before[vertex as usize]), |&v| {
            Some(self.before[v as usize]).filter(|&u| u != NONE)
        });
        let last = steps.last().unwrap_or(vertex);
        self.before[vertex as usize] = NONE;
        last
    }
}

impl Refinement<'_> {
    /// Inserts vertices of the rim and candidates in the order of their keys, up to the cut; `told` hears of each, and of
    /// what is there from the start first.
    pub(super) fn run_in_order(
        &mut self,
        domain: &Domain,
        order: Order<'_>,
        told: &mut dyn FnMut(Event),
    ) -> Result<(), Cancelled> {
        let all = 0..self.surface.topology.len();
        let triangles = u64::from(all.end);
        let squares = order.squares.map_or(0.0, |share| all.map(|t| self.squares_of(t, share)).sum());
        told(Event { key: Key::FIRST, triangles, squares });
        let mut rim = order.rim.iter().copied().peekable();
        let mut outline = Outline::new(domain, order.rim);
        self.surface.topology.track_locked(domain.vertices.len());
        let (mut envelope, mut inside, mut insertions, mut near) = (f64::INFINITY, 0, 0u64, 0);
        while insertions < order.most {
            if insertions.is_multiple_of(256) {
                self.cancel.check()?;
            }
            let before = self.surface.topology.len();
            let best = self.candidates.best();
            let expected = best.map(|(_, c)| envelope.min(c.score));
            let on_rim = rim.next_if(|(k, _)| *k <= order.cut && expected.is_none_or(|e| k.error() >= e));
            let key = match (on_rim, best, expected) {
                (Some((key, vertex)), ..) => {
                    near = self.insert_on_rim(near, outline.before(vertex), vertex);
                    key
                }
                (None, Some((t, candidate)), Some(error)) => {
                    let key = Key::of_interior(error, order.tile, inside);
                    if key > order.cut {
                        break;
                    }
                    near = self.insert(t, candidate.sample).expect("samples on the rim are left out");
                    inside += 1;
                    key
                }
                _ => break,
            };
            envelope = envelope.min(key.error());
            insertions += 1;
            let squares = order.squares.map_or(0.0, |share| self.squares_changed(near, share));
            told(Event { key, triangles: u64::from(self.surface.topology.len() - before), squares });
        }
        Ok(())
    }

    /// Puts a vertex of the domain onto the locked edge it is on, behind the vertex `before`. A triangle at it.
    fn insert_on_rim(&mut self, near: u32, before: u32, vertex: u32) -> u32 {
        let at = self.surface.at(vertex);
        let from = self.surface.topology.locked_from(before);
        // Walks to the rim seldom arrive where it has many bends. Where loops touch, this may be the wrong one.
        let site = match from.filter(|&e| self.surface.passes(e, at)) {
            Some(e) => Site::Edge(e),
            None => self.surface.locate(near, at),
        };
        let connected = self.surface.connect(vertex, site);
        let t = connected.unwrap_or_else(|| panic!("a vertex of the rim at {at:?} is on its edge, found {site:?}"));
        self.update(t);
        t
    }

    /// The change of the sum of squares by what was done around the vertex at corner 2 of `t`.
    pub(super) fn squares_changed(&mut self, t: u32, share: Share<'_>) -> f64 {
        let mut star = std::mem::take(self.star);
        self.surface.topology.star(t, &mut star);
        let mut change = 0.0;
        for &t in &star {
            change += self.squares_of(t, share);
        }
        *self.star = star;
        change
    }

    /// How much a triangle's sum of squares has grown since it was last asked for.
    pub(super) fn squares_of(&mut self, t: u32, share: Share<'_>) -> f64 {
        let now = super::squares::of_triangle(self.scanner.tile, self.surface.corners(t), share, self.locked(t));
        now - self.squares.replace(t, now)
    }
}
