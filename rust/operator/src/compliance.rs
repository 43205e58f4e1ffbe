// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::{LinearOperator, Map};

/// One of the three components of a traction or a displacement at a contact point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Component {
    /// First tangential direction (x on a grid).
    X,
    /// Second tangential direction (y on a grid).
    Y,
    /// Normal direction, into the body.
    Normal,
}

/// What a body contributes to a contact: traction in, displacement out, at its contact points.
///
/// Both in the body's own frame `(tangential 1, tangential 2, into)` in Pa and m.
pub trait Compliance: Send + Sync {
    /// Number of contact points.
    fn points(&self) -> usize;

    /// Adds `scale` times the displacement component `observed` caused by the traction field
    /// `traction` [Pa] in direction `loaded` to `displacement` [m]; both of length
    /// [`Compliance::points`].
    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    );

    /// Whether [`Compliance::add_displacement`] costs far less than a product with its matrix, so that contacts of
    /// many points are better solved without one.
    fn prefers_products(&self) -> bool {
        false
    }

    /// About the inverse of the compliance along the normal, where each point gives way by `_softer` [m/Pa] to its own
    /// pressure besides: what a Krylov method applies before its products. `None` where nothing cheap is known.
    fn near_inverse(&self, _softer: f64) -> Option<Map> {
        None
    }

    /// Memory [bytes] that [`Compliance::add_influence`] takes for one pair of components, besides the matrix
    /// that it adds to: what is needed meanwhile, and what is kept afterwards.
    fn influence_memory(&self) -> f64 {
        0.0
    }

    /// Areas (n) by which it is reciprocal, `area_i C_ab[i, j] = area_j C_ba[j, i]`: a load on one point moves another
    /// as far as a load there moves the first; `None` where they are not known. (Betti)
    fn reciprocity(&self) -> Option<Vec<f64>> {
        None
    }

    /// Adds `scale` times the transposed influence coefficients times `weights` (n) to `sums` (n): what weights of
    /// displacements `observed` amount to as weights of the tractions `loaded`.
    ///
    /// The default takes a product where areas of [reciprocity](Compliance::reciprocity) are known, and otherwise
    /// forms the matrix.
    fn add_transposed(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        weights: &[f64],
        sums: &mut [f64],
    ) {
        let n = self.points();
        if let Some(areas) = self.reciprocity() {
            let load: Vec<f64> = weights.iter().zip(&areas).map(|(w, a)| w / a).collect();
            let mut moved = vec![0.0; n];
            self.add_displacement(loaded, observed, scale, &load, &mut moved);
            for ((sum, moved), area) in sums.iter_mut().zip(moved).zip(areas) {
                *sum += area * moved;
            }
            return;
        }
        let mut matrix = vec![0.0; n * n];
        self.add_influence(observed, loaded, scale, &mut matrix);
        for (row, weight) in matrix.chunks_exact(n.max(1)).zip(weights) {
            for (sum, a) in sums.iter_mut().zip(row) {
                *sum += weight * a;
            }
        }
    }

    /// Adds `scale` times the influence coefficients [m/Pa] to `matrix`, row-major,
    /// row = observed point, column = loaded point.
    ///
    /// The default applies the map to unit vectors; dense bodies and half-spaces do better.
    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let n = self.points();
        let mut unit = vec![0.0; n];
        let mut column = vec![0.0; n];
        for j in 0..n {
            unit[j] = 1.0;
            column.fill(0.0);
            self.add_displacement(observed, loaded, scale, &unit, &mut column);
            unit[j] = 0.0;
            for i in 0..n {
                matrix[i * n + j] += column[i];
            }
        }
    }
}

/// Bytes of a square matrix.
pub(crate) fn square(points: usize) -> f64 {
    8.0 * (points as f64).powi(2)
}

/// Several compliances acting on the same contact points: their displacements add.
pub struct Sum<'a>(pub Vec<&'a dyn Compliance>);

impl Compliance for Sum<'_> {
    fn points(&self) -> usize {
        self.0.first().map_or(0, |c| c.points())
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        for c in &self.0 {
            c.add_displacement(observed, loaded, scale, traction, displacement);
        }
    }

    fn add_transposed(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        weights: &[f64],
        sums: &mut [f64],
    ) {
        for c in &self.0 {
            c.add_transposed(observed, loaded, scale, weights, sums);
        }
    }

    fn prefers_products(&self) -> bool {
        self.0.iter().any(|c| c.prefers_products())
    }

    fn influence_memory(&self) -> f64 {
        self.0.iter().map(|c| c.influence_memory()).sum()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        for c in &self.0 {
            c.add_influence(observed, loaded, scale, matrix);
        }
    }
}

/// The upper body seen from the lower one.
///
/// Pressure pushes both bodies into themselves, but the traction on the upper body is minus the
/// one on the lower. For a traction given *on the lower body* the sum of the lower compliance and
/// the mirrored upper one yields the relative displacement: `u_lower - u_upper` tangentially, and
/// the sum of both indentations normally. So tangential-tangential and normal-normal
/// influences of the two bodies add, mixed ones subtract; no other line of the house owns this sign.
pub struct Mirrored<'a>(pub &'a dyn Compliance);

fn mirror(observed: Component, loaded: Component) -> f64 {
    if (observed == Component::Normal) == (loaded == Component::Normal) {
        1.0
    } else {
        -1.0
    }
}

impl Compliance for Mirrored<'_> {
    fn points(&self) -> usize {
        self.0.points()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let scale = scale * mirror(observed, loaded);
        self.0
            .add_displacement(observed, loaded, scale, traction, displacement);
    }

    fn add_transposed(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        weights: &[f64],
        sums: &mut [f64],
    ) {
        let scale = scale * mirror(observed, loaded);
        self.0
            .add_transposed(observed, loaded, scale, weights, sums);
    }

    fn prefers_products(&self) -> bool {
        self.0.prefers_products()
    }

    fn influence_memory(&self) -> f64 {
        self.0.influence_memory()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let scale = scale * mirror(observed, loaded);
        self.0.add_influence(observed, loaded, scale, matrix);
    }
}

/// One block of a compliance as a linear operator, for the iterative solvers.
pub struct Block<'a> {
    /// The compliance the block is taken from.
    pub compliance: &'a dyn Compliance,
    /// Component of the displacement.
    pub observed: Component,
    /// Component of the traction.
    pub loaded: Component,
}

impl LinearOperator for Block<'_> {
    fn dim(&self) -> usize {
        self.compliance.points()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.compliance
            .add_displacement(self.observed, self.loaded, 1.0, x, y);
    }
}
