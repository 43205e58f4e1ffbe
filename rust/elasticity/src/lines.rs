// SPDX-License-Identifier: MIT OR Apache-2.0
//! Some of the lines of a regular grid, and the hats between them.

use nalgebra::DMatrix;

use crate::Error;

/// Some of the nodes of a row, among them the first and the last one.
///
/// The hats between them, linear from each to its neighbours, are sums of the hats of all nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lines {
    kept: Vec<usize>,
}

impl Lines {
    /// The nodes `kept` of `nodes` ones.
    ///
    /// # Errors
    /// [`Error::Lines`] unless they rise from 0 to the last one, and there are two.
    pub fn new(kept: Vec<usize>, nodes: usize) -> Result<Self, Error> {
        let rises = kept.windows(2).all(|pair| pair[0] < pair[1]);
        if kept.len() < 2 || !rises || kept[0] != 0 || kept[kept.len() - 1] + 1 != nodes {
            return Err(Error::Lines(nodes));
        }
        Ok(Self { kept })
    }

    /// The same seen in a mirror: the last node is the first one.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let end = self.nodes() - 1;
        Self {
            kept: self.kept.iter().rev().map(|k| end - k).collect(),
        }
    }

    /// Those that are kept.
    pub fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// Number of those that are kept.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Never: there are two at least.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Number of all nodes.
    pub fn nodes(&self) -> usize {
        self.kept[self.kept.len() - 1] + 1
    }

    /// The hats that are not zero at a node, with their values: one or two.
    pub fn at(&self, node: usize) -> impl Iterator<Item = (usize, f64)> {
        let next = self.kept.partition_point(|k| *k <= node);
        let first = next.min(self.len() - 1) - 1;
        let [from, to] = [self.kept[first], self.kept[first + 1]];
        let over = (node - from) as f64 / (to - from) as f64;
        [(first, 1.0 - over), (first + 1, over)]
            .into_iter()
            .filter(|(_, value)| *value > 0.0)
    }

    /// The hats of all nodes whose sum each hat is: nodes and factors.
    pub(crate) fn hats(&self) -> Vec<Vec<(usize, f64)>> {
        let mut hats = vec![Vec::new(); self.len()];
        for node in 0..self.nodes() {
            for (hat, value) in self.at(node) {
                hats[hat].push((node, value));
            }
        }
        hats
    }

    /// The same as a matrix, rows for all nodes.
    fn matrix(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.nodes(), self.len());
        for node in 0..self.nodes() {
            for (hat, value) in self.at(node) {
                matrix[(node, hat)] = value;
            }
        }
        matrix
    }

    /// `F (P^T F)^-1`: of the natural cubic spline over the lines that has given integrals over the hats between
    /// them, its integrals over the hats of all nodes. `F` are these of the spline by its values, and `P` of
    /// [`Lines::hats`] sums them. It does not depend on the length.
    pub(crate) fn shares(&self) -> DMatrix<f64> {
        let mut by_values = DMatrix::<f64>::zeros(self.nodes(), self.len());
        let mut by_curvatures = by_values.clone();
        for cell in 0..self.nodes() - 1 {
            let line = self.kept.partition_point(|k| *k <= cell) - 1;
            let [from, to] = [self.kept[line] as f64, self.kept[line + 1] as f64];
            for (place, weight) in GAUSS {
                let after = (cell as f64 + place - from) / (to - from);
                let before = 1.0 - after;
                for (hat, value) in [(cell, 1.0 - place), (cell + 1, place)] {
                    for (knot, share) in [(line, before), (line + 1, after)] {
                        let bent = (to - from).powi(2) / 6.0 * (share.powi(3) - share);
                        by_values[(hat, knot)] += weight * value * share;
                        by_curvatures[(hat, knot)] += weight * value * bent;
                    }
                }
            }
        }
        let over = by_values + by_curvatures * self.curvatures();
        let sums = self.matrix().tr_mul(&over);
        // a hat and a knot for each line: integrals over the hats tell the values at the knots
        sums.transpose()
            .lu()
            .solve(&over.transpose())
            .map_or(over, |shares| shares.transpose())
    }

    /// Second derivatives of the natural cubic spline at the lines by its values there [Reinsch1967].
    fn curvatures(&self) -> DMatrix<f64> {
        let n = self.len();
        let (mut system, mut bends) = (DMatrix::identity(n, n), DMatrix::zeros(n, n));
        for k in 1..n - 1 {
            let [before, after] = [k - 1, k].map(|j| (self.kept[j + 1] - self.kept[j]) as f64);
            system[(k, k - 1)] = before / 6.0;
            system[(k, k)] = (before + after) / 3.0;
            system[(k, k + 1)] = after / 6.0;
            bends[(k, k - 1)] = 1.0 / before;
            bends[(k, k)] = -1.0 / before - 1.0 / after;
            bends[(k, k + 1)] = 1.0 / after;
        }
        // diagonally dominant
        system.lu().solve(&bends).unwrap_or(bends)
    }
}

/// Places in a cell of length 1 and weights: exact up to degree 5.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];
