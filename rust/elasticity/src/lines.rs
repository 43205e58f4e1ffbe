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

    /// `M P (P^T M P)^-1` with the integrals `M` of products of the hats of all nodes, and `P` of
    /// [`Lines::hats`]. It does not depend on the length.
    pub(crate) fn shares(&self) -> DMatrix<f64> {
        let n = self.nodes();
        let mass = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 if i == 0 || i == n - 1 => 1.0 / 3.0,
            0 => 2.0 / 3.0,
            1 => 1.0 / 6.0,
            _ => 0.0,
        });
        let sums = self.matrix();
        let mixed = mass * &sums;
        // hats are independent: their products are positive definite
        sums.tr_mul(&mixed).cholesky().map_or_else(
            || mixed.clone(),
            |factor| factor.solve(&mixed.transpose()).transpose(),
        )
    }
}
