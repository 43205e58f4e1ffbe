// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::LinearOperator;

/// Radii of the discs.
#[derive(Clone, Copy)]
pub enum Radius<'a> {
    /// One fixed radius per point; a point of radius zero takes no part.
    Fixed(&'a [f64]),
    /// Radii that depend on the magnitudes of the image.
    Dependent(&'a dyn DependentRadius),
}

/// Radii that follow the magnitude `|F_i|` of the image at the points, their own and others'.
pub trait DependentRadius: Send + Sync {
    /// Overwrites `radius` (n) with the radii at the given magnitudes (n). A point of radius zero
    /// takes no part and must have radius zero at every magnitude.
    fn radius(&self, magnitude: &[f64], radius: &mut [f64]);

    /// Overwrites `derivative` (n) with the derivative of the radii at `magnitude` (n) along
    /// `change` (n).
    fn derivative(&self, magnitude: &[f64], change: &[f64], derivative: &mut [f64]);

    /// Overwrites `derivative` (n) with the derivative by the magnitudes of the sum of the radii with `weight` (n):
    /// the transpose of [`DependentRadius::derivative`].
    fn derivative_transposed(&self, magnitude: &[f64], weight: &[f64], derivative: &mut [f64]);
}

/// A rough inverse of an operator under a curvature.
pub trait Preconditioner: Send + Sync {
    /// Length of the vectors.
    fn dim(&self) -> usize;

    /// Overwrites `x` (2n) with roughly what solves `A x + diagonal curvature x = y`.
    ///
    /// Where `curvature` (n) outweighs the operator, what `x` becomes is of little account, and none is taken of
    /// points that take no part, whose curvature is infinite and whose `y` is zero.
    fn invert(&self, curvature: &[f64], y: &[f64], x: &mut [f64]);
}

/// A rough inverse of the operator alone, which leaves the curvature to the solver.
impl<T: LinearOperator> Preconditioner for T {
    fn dim(&self) -> usize {
        LinearOperator::dim(self)
    }

    fn invert(&self, _: &[f64], y: &[f64], x: &mut [f64]) {
        LinearOperator::apply(self, y, x);
    }
}

/// One scalar condition on the unknown field, with its own scalar unknown.
///
/// `weight . q + softness c = value` holds by the choice of the multiplier `c`, which enters the
/// image as `F = A q + b - c direction`.
#[derive(Clone, Debug)]
pub struct Resultant {
    /// Column of the multiplier in the image, (2n).
    pub direction: Vec<f64>,
    /// Row of the condition, (2n).
    pub weight: Vec<f64>,
    /// What `weight . q` must be.
    pub value: f64,
    /// How far the condition yields to its multiplier: 0 for not at all. A drive through a spring.
    pub softness: f64,
}

/// A variational inequality on discs.
///
/// Find `q` with `|q_i| <= g_i` and `F = A q + b` such that `F_i = 0` inside a disc and
/// `F_i = -s q_i / g_i`, `s >= 0`, on its rim. Vectors hold the first components of all `n`
/// points, then the second ones.
pub struct DiscProblem<'a> {
    /// `A`, of dimension 2n.
    pub operator: &'a dyn LinearOperator,
    /// `A` to some six digits, by which the linear systems of Newton's method are solved: residuals of the problem are
    /// those of `operator`. It may be the same.
    pub rough: &'a dyn LinearOperator,
    /// A rough inverse of `A`, of dimension 2n.
    pub preconditioner: &'a dyn Preconditioner,
    /// `b`, (2n).
    pub offset: &'a [f64],
    /// `g`.
    pub radius: Radius<'a>,
    /// Conditions on `q` with their multipliers; may be empty.
    pub resultants: &'a [Resultant],
    /// A typical diagonal entry of `A`; positive. It scales the residual, not the solution.
    pub diagonal: f64,
}

/// Where a solve starts.
#[derive(Clone, Debug)]
pub enum DiscStart {
    /// At the solution of the linear problem in which no disc is reached, put back into the discs: the
    /// start to take where resultants are prescribed and nothing else is known.
    Inside,
    /// At a given field.
    At {
        /// Field (2n); put back into the discs.
        field: Vec<f64>,
        /// One multiplier per resultant.
        multipliers: Vec<f64>,
    },
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct DiscOptions {
    /// Residual `||q - P(q - F / diagonal)|| / ||q||` aimed at; where `q` is smaller still, over the
    /// field that the offset drives in one step.
    pub tolerance: f64,
    /// Newton steps at most.
    pub max_iterations: usize,
}

/// What a point does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscState {
    /// Radius zero: takes no part.
    Excluded,
    /// Inside its disc.
    Inside,
    /// On the rim.
    Rim,
}

/// The solution, or the last iterate if `converged` is false.
#[derive(Clone, Debug)]
pub struct DiscSolution {
    /// `q`, (2n).
    pub field: Vec<f64>,
    /// `F = A q + b - sum of multipliers times directions`, (2n).
    pub image: Vec<f64>,
    /// One multiplier per resultant.
    pub multipliers: Vec<f64>,
    /// Radii at the solution, (n).
    pub radius: Vec<f64>,
    /// State by point, (n).
    pub state: Vec<DiscState>,
    /// Whether the residual met the tolerance.
    pub converged: bool,
    /// Newton steps.
    pub iterations: usize,
    /// Products with `A`, rough ones among them.
    pub products: usize,
    /// Applications of the preconditioner.
    pub preconditionings: usize,
    /// Residual by Newton step, the last one being that of the solution.
    pub history: Vec<f64>,
}

impl DiscSolution {
    /// Residual of the solution.
    pub fn residual(&self) -> f64 {
        self.history.last().copied().unwrap_or(f64::INFINITY)
    }
}
