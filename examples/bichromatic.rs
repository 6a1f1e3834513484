//! The planar bichromatic partition of Agarwal & Desikan 1997 (section 1) on points made from a seed: few disjoint triangles that
//! hold every blue point and no red one.
//!
//! `bichromatic SVG [SEED [BLUE [RED]]]` makes so many points (30 and 60), prints how the search went, and draws it.

use std::fmt::Write;

use terrabite::base::lattice::Point;
use terrabite::kernel::triangulate::hitting_set::bichromatic::{Partition, partition};
use terrabite::kernel::triangulate::hitting_set::reweighting::most_successful;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Points lie in a square of this side; blue ones are in discs.
const SIDE: i32 = 1000;
const DISCS: [(i32, i32, i32); 4] = [(250, 300, 180), (700, 250, 200), (400, 750, 160), (820, 720, 120)];

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, usual: u64| arguments.get(i).map_or(Ok(usual), |word| word.parse::<u64>());
    let path = arguments.first().ok_or("expected: bichromatic SVG [SEED [BLUE [RED]]]")?;
    let (seed, blue, red) = (number(1, 1)?, number(2, 30)? as usize, number(3, 60)? as usize);

    let mut random = seed;
    let mut place = || {
        let mut coordinate = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((random >> 33) % SIDE as u64) as i32
        };
        Point { x: coordinate(), y: coordinate() }
    };
    let is_in_disc = |p: &Point| DISCS.iter().any(|(x, y, r)| (p.x - x).pow(2) + (p.y - y).pow(2) < r * r);
    let (mut blues, mut reds) = (Vec::new(), Vec::new());
    while blues.len() < blue || reds.len() < red {
        let p = place();
        if is_in_disc(&p) && blues.len() < blue {
            blues.push(p);
        } else if !is_in_disc(&p) && reds.len() < red {
            reds.push(p);
        }
    }
    let found = partition(&blues, &reds, seed).ok_or("a blue point where a red one is")?;
    let search = &found.search;
    println!(
        "{} blue and {} red points: {} triangles cover, {} disjoint; c = {}, {} of {} iterations successful, at most {}",
        blues.len(),
        reds.len(),
        found.cover.len(),
        found.triangles.len(),
        search.believed,
        search.successful,
        search.iterations,
        most_successful(search.believed, search.elements),
    );
    std::fs::write(path, drawing(&found, &blues, &reds)?)?;
    Ok(())
}

fn drawing(found: &Partition, blues: &[Point], reds: &[Point]) -> Result<String, std::fmt::Error> {
    let mut svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIDE} {SIDE}\">\n");
    for corners in &found.triangles {
        let corners: Vec<String> = corners.iter().map(|p| format!("{},{}", p.x, p.y)).collect();
        writeln!(svg, "<polygon points=\"{}\" fill=\"#cde\" stroke=\"#357\" stroke-width=\"3\"/>", corners.join(" "))?;
    }
    for (points, colour) in [(blues, "#14c"), (reds, "#c22")] {
        for p in points {
            writeln!(svg, "<circle cx=\"{}\" cy=\"{}\" r=\"8\" fill=\"{colour}\"/>", p.x, p.y)?;
        }
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}
