//! What has been measured at tolerances, and where a quantity may be expected to come to a number.

use super::figures::{Figures, Quantity};

/// Figures of meshes by their tolerances, ascending.
#[derive(Debug, Default)]
pub(super) struct Curve {
    points: Vec<(f64, Figures)>,
}

/// How far beyond all that has been measured one guess goes, as a factor.
const STEP: f64 = 4.0;

/// Counts at tolerances closer than this, as a share, say more of chance than of the tolerance.
const NOISE: f64 = 0.01;

/// How far a line leads beyond two measurements, as a share of what is sought.
const CLOSE: f64 = 0.2;

/// Measurements whose tolerances differ by a larger factor are far apart.
const FAR: f64 = 2.0;

/// How steep a line may be: measurements on either side of a jump say little of what lies beyond. Any numbers will do, also those
/// that are none.
pub(super) fn within_reason(step: f64, in_proportion: f64) -> f64 {
    let (least, most) = (LEAST * in_proportion, MOST * in_proportion);
    step.max(least.min(most)).min(least.max(most))
}

/// How long steps are in general, beside those in proportion.
const LEAST: f64 = 0.6;
const MOST: f64 = 1.7;

impl Curve {
    pub(super) fn add(&mut self, tolerance: f64, figures: Figures) {
        let at = self.points.partition_point(|(t, _)| *t < tolerance);
        self.points.insert(at, (tolerance, figures));
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The largest error of all.
    pub(super) fn largest(&self) -> f64 {
        self.points.iter().map(|(_, figures)| figures.largest).fold(0.0, f64::max)
    }

    /// The least tolerance at which something has been measured.
    pub(super) fn least(&self) -> Option<f64> {
        self.points.first().map(|(tolerance, _)| *tolerance)
    }

    pub(super) fn at(&self, tolerance: f64) -> Option<&Figures> {
        self.points.iter().find(|(t, _)| *t == tolerance).map(|(_, figures)| figures)
    }

    /// Whether something has been measured at a tolerance that is off by no more than a share.
    pub(super) fn has_near(&self, tolerance: f64, share: f64) -> bool {
        self.points.iter().any(|(t, _)| (t - tolerance).abs() <= share * tolerance)
    }

    /// The two neighbours between which a quantity comes to a target: with their tolerances and the quantity there.
    pub(super) fn around(&self, quantity: Quantity, target: f64) -> Option<[(f64, f64); 2]> {
        let values = self.points.iter().map(|(t, figures)| (*t, quantity.of(figures)));
        let values: Vec<(f64, f64)> = values.collect();
        // Counts are not monotone: the last crossing is on the side of fewer triangles.
        let pair = values.windows(2).rev().find(|pair| pair[0].1 < target && target <= pair[1].1)?;
        Some([pair[0], pair[1]])
    }

    /// The tolerance whose quantity is the nearest to a target, and that quantity. Of several, the farthest on the way there.
    pub(super) fn nearest(&self, quantity: Quantity, target: f64) -> Option<(f64, f64)> {
        let off = |(_, figures): &(f64, Figures)| (quantity.of(figures) / target - 1.0).abs();
        let (first, last) = (self.points.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?, self.points.iter().rev());
        let last = last.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let nearest = if quantity.of(&first.1) < target { last } else { first };
        Some((nearest.0, quantity.of(&nearest.1)))
    }

    /// Whether enough has been measured so near to a target that it says where that is.
    pub(super) fn leads_to(&self, quantity: Quantity, target: f64) -> bool {
        if self.around(quantity, target).is_some() {
            return true;
        }
        let Some((near, value)) = self.nearest(quantity, target) else { return false };
        let is_far = |(far, _): (f64, &Figures)| (far - near).abs() > NOISE * near;
        (target / value - 1.0).abs() < CLOSE && self.neighbour(near).is_some_and(is_far)
    }

    /// Where a quantity may come to a target: by the line between two measurements, or in proportion where there is one.
    /// `None` without any.
    pub(super) fn guess(&self, quantity: Quantity, target: f64) -> Option<f64> {
        if let Some([low, high]) = self.around(quantity, target) {
            return Some(self.between(quantity, target, [low, high]));
        }
        let (near, value) = self.nearest(quantity, target)?;
        let far = self.neighbour(near);
        let by_line = far.and_then(|(far, figures)| {
            let slope = (quantity.of(figures) - value) / (far - near);
            (slope > 0.0).then(|| near + (target - value) / slope)
        });
        let step = if value > 0.0 { near * (target / value - 1.0) } else { near * STEP };
        let guess = near + by_line.map_or(step, |line| within_reason(line - near, step));
        Some(guess.clamp(near / STEP, near * STEP))
    }

    /// Where between two measurements: on the line through them, and on those through each and the next beyond it. A curve that
    /// bends one way lies between the first and the others.
    fn between(&self, quantity: Quantity, target: f64, [low, high]: [(f64, f64); 2]) -> f64 {
        let on_line = |a: (f64, f64), b: (f64, f64)| a.0 + (b.0 - a.0) * ((target - a.1) / (b.1 - a.1));
        let chord = on_line(low, high);
        if high.0 > FAR * low.0 {
            // Far apart nothing is known of the bend.
            let in_proportion = if low.0 > 0.0 { low.0 * (target / low.1) } else { chord / (STEP * STEP) };
            let is_between = low.0 < in_proportion && in_proportion < high.0;
            return if is_between { (chord * in_proportion).sqrt() } else { chord };
        }
        let value = |point: &(f64, Figures)| (point.0, quantity.of(&point.1));
        let before = self.points.iter().rev().map(value).find(|point| point.0 < low.0 && point.1 < low.1);
        let after = self.points.iter().map(value).find(|point| point.0 > high.0 && point.1 > high.1);
        let lines = [before.map(|before| on_line(before, low)), after.map(|after| on_line(high, after))];
        let lines = lines.into_iter().flatten().map(|line| line.clamp(low.0, high.0));
        let (sum, count) = lines.fold((0.0, 0.0), |(sum, count), line| (sum + line, count + 1.0));
        if count > 0.0 { (chord + sum / count) / 2.0 } else { chord }
    }

    /// What may come of a tolerance, likewise: inverse counts and errors lie on lines.
    pub(super) fn estimate(&self, tolerance: f64) -> Option<Figures> {
        let off = |point: &&(f64, Figures)| (point.0 - tolerance).abs();
        let near = *self.points.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let far = self.neighbour(near.0);
        let value = |of: &dyn Fn(&Figures) -> f64| {
            let value = of(&near.1);
            let in_proportion = if near.0 > 0.0 { value * (tolerance / near.0) } else { value };
            let by_line =
                far.map(|(far, figures)| value + (of(figures) - value) / (far - near.0) * (tolerance - near.0));
            by_line.filter(|line| *line > 0.0).unwrap_or(in_proportion)
        };
        let count = |of: fn(&Figures) -> u64| (1.0 / value(&|figures| 1.0 / of(figures).max(1) as f64)).round() as u64;
        let (vertices, triangles) = (count(|figures| figures.vertices), count(|figures| figures.triangles));
        Some(Figures { vertices, triangles, rms: value(&|figures| figures.rms), largest: near.1.largest })
    }

    /// The measurement next to one at a tolerance.
    fn neighbour(&self, tolerance: f64) -> Option<(f64, &Figures)> {
        let others = self.points.iter().filter(|(t, _)| *t != tolerance);
        let nearest = others.min_by(|a, b| (a.0 - tolerance).abs().total_cmp(&(b.0 - tolerance).abs()))?;
        Some((nearest.0, &nearest.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Goal;

    fn curve(points: &[(f64, u64)]) -> Curve {
        let mut curve = Curve::default();
        for &(tolerance, triangles) in points {
            curve.add(tolerance, Figures { triangles, ..Figures::default() });
        }
        curve
    }

    fn budget(most: u64) -> Quantity {
        Quantity::budget(&Goal { max_triangles: Some(most), ..Goal::default() }).unwrap()
    }

    /// A steep curve: the line alone would creep up to the target from one side.
    #[test]
    fn a_bend_is_taken_into_account() {
        let steep = curve(&[(1.773, 7165), (1.892, 5702), (2.216, 2657)]);
        let guess = steep.guess(budget(4925), 1.0).unwrap();
        assert!((1.95..1.975).contains(&guess), "{guess}");
        let wide = curve(&[(2.091, 40418), (8.364, 2)]);
        assert!(wide.guess(budget(14000), 1.0).unwrap() > 3.0);
    }

    #[test]
    fn half_the_triangles_are_expected_at_twice_the_tolerance() {
        assert_eq!(curve(&[(2.0, 1000)]).guess(budget(500), 1.0), Some(4.0));
        assert_eq!(curve(&[(2.0, 1000)]).guess(budget(10), 1.0), Some(8.0));
        assert_eq!(curve(&[(4.0, 500), (2.0, 1000)]).guess(budget(750), 1.0), Some(2.0 + 2.0 / 3.0));
        assert_eq!(curve(&[(2.0, 1000), (4.0, 500)]).estimate(8.0).map(|figures| figures.triangles), Some(250));
        assert_eq!(curve(&[]).guess(budget(5), 1.0), None);
    }

    /// Heights that are whole numbers: below a half, tolerances are all the same.
    #[test]
    fn a_plateau_is_left() {
        let flat = curve(&[(0.1, 1000), (0.4, 1000)]);
        assert_eq!(flat.guess(budget(500), 1.0), Some(0.8));
        assert_eq!(flat.guess(budget(2000), 1.0), Some(0.05));
    }

    #[test]
    fn what_rises_with_the_tolerance_leads_nowhere() {
        // More triangles at the larger tolerance: a line would lead the wrong way.
        let odd = curve(&[(2.0, 1000), (2.1, 1001)]);
        assert!(odd.guess(budget(500), 1.0).unwrap() > 3.0);
    }
}
