//! The variants of greedy insertion.

use serde::Serialize;

/// Which of the paper's variants of greedy insertion is run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct InsertionOptions {
    /// How edges are chosen.
    pub swap: Swap,
    /// How many candidates a pass inserts.
    pub selection: Selection,
    /// Which candidate is wanted most.
    pub measure: Measure,
}

/// By what the edges around a new vertex are swapped.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Swap {
    /// By the circle test alone: Delaunay but for locked edges (Garland & Heckbert 1995, algorithm III).
    #[default]
    Delaunay,
    /// By how well the surface fits the samples, unless the shapes differ too much (algorithm IV).
    DataDependent(DataDependent),
}

/// What decides between the two diagonals of a quadrilateral (section 4.5).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DataDependent {
    /// The error that a diagonal is to make small.
    pub fit: Fit,
    /// What a good shape is.
    pub shape: Shape,
    /// The paper's *qthresh*: where the worse of two shapes is at most so large a share of the better, shape decides;
    /// else fit does. 0 is pure data dependence, 1 pure shape.
    pub quality_threshold: f64,
}

impl Default for DataDependent {
    fn default() -> Self {
        DataDependent { fit: Fit::MaxSum, shape: Shape::AreaOverDiameter, quality_threshold: 0.5 }
    }
}

/// The paper's ERROR_ACCUM over a triangle and ERROR_COMBINE over two (section 4.5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// Sums of squares, added.
    L2,
    /// The largest error of both triangles.
    LInfinity,
    /// The largest error of each triangle, added: what the paper found best (section 5.3).
    MaxSum,
}

/// The paper's SHAPE_QUALITY of two triangles that share a diagonal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// The product of their areas over the product of their diameters (section 5.3).
    AreaOverDiameter,
    /// Their smallest angle, as its sine: at a threshold of 1 the result is Delaunay (section 4.5.1).
    SmallestAngle,
}

/// How many candidates a pass inserts before errors are looked at again (section 5.4).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Selection {
    /// The best one.
    #[default]
    Sequential,
    /// All whose error is at least this share of the largest.
    Fractional(f64),
    /// All that are farther than the tolerance.
    Constant,
}

/// What makes a sample important, among those that are farther than the tolerance (section 3).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Its error (3.1).
    #[default]
    LocalError,
    /// The curvature of the field, smoothed with a Gaussian of this standard deviation in cells (3.2). It is that of the
    /// heights, whatever channels there are.
    Curvature(f64),
    /// How much its insertion lowers the sum of errors over its triangle (3.3).
    GlobalError,
    /// Its error times its curvature (3.4), smoothed likewise.
    Product(f64),
}

impl InsertionOptions {
    /// The same with what insertion in order needs ([`crate::kernel::triangulate::Progressive`]): one at a time, the
    /// farthest first.
    pub fn in_order(self) -> InsertionOptions {
        InsertionOptions { selection: Selection::Sequential, measure: Measure::LocalError, ..self }
    }

    /// All of it as text, equal exactly if the results are.
    pub fn named(&self) -> String {
        // Doubles print as the shortest decimals that are read back as the same.
        format!("{:?}, {:?}, {:?}", self.swap, self.selection, self.measure)
    }
}
