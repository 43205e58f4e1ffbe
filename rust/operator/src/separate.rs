// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use crate::compliance::square;
use crate::{Compliance, Component, Map};

/// Bodies that touch the same opponent but not each other; their points follow one another.
pub struct Separate(pub Vec<Arc<dyn Compliance>>);

impl Compliance for Separate {
    fn points(&self) -> usize {
        self.0.iter().map(|c| c.points()).sum()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let mut start = 0;
        for body in &self.0 {
            let part = start..start + body.points();
            body.add_displacement(
                observed,
                loaded,
                scale,
                &traction[part.clone()],
                &mut displacement[part.clone()],
            );
            start = part.end;
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
        let mut start = 0;
        for body in &self.0 {
            let part = start..start + body.points();
            let (weights, sums) = (&weights[part.clone()], &mut sums[part.clone()]);
            body.add_transposed(observed, loaded, scale, weights, sums);
            start = part.end;
        }
    }

    fn prefers_products(&self) -> bool {
        self.0.iter().any(|c| c.prefers_products())
    }

    fn near_inverse(&self, softer: f64) -> Option<Map> {
        let maps = self
            .0
            .iter()
            .map(|c| Some((c.points(), c.near_inverse(softer)?)))
            .collect::<Option<Vec<_>>>()?;
        Some(Box::new(move |x: &[f64], y: &mut [f64]| {
            let mut start = 0;
            for (points, map) in &maps {
                let part = start..start + points;
                map(&x[part.clone()], &mut y[part.clone()]);
                start = part.end;
            }
        }))
    }

    fn influence_memory(&self) -> f64 {
        let each = self
            .0
            .iter()
            .map(|c| square(c.points()) + c.influence_memory());
        each.sum()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let n = self.points();
        let mut start = 0;
        for body in &self.0 {
            let k = body.points();
            let mut block = vec![0.0; k * k];
            body.add_influence(observed, loaded, scale, &mut block);
            for (i, row) in block.chunks_exact(k.max(1)).enumerate() {
                let at = (start + i) * n + start;
                for (m, b) in matrix[at..at + k].iter_mut().zip(row) {
                    *m += b;
                }
            }
            start += k;
        }
    }
}

/// A body seen in the mirror y = 0: its twin on the other side.
pub struct Reflected {
    inner: Arc<dyn Compliance>,
    /// The point of the original that each point of the twin is the image of.
    original: Vec<usize>,
}

impl Reflected {
    /// The twin whose point `i` is the image of point `original[i]`.
    ///
    /// Returns `None` where `original` is not a permutation of the points of `inner`.
    pub fn new(inner: Arc<dyn Compliance>, original: Vec<usize>) -> Option<Self> {
        let n = inner.points();
        let mut seen = vec![false; n];
        for &i in &original {
            *seen.get_mut(i)? = true;
        }
        (original.len() == n && seen.into_iter().all(|s| s)).then_some(Self { inner, original })
    }

    fn sign(observed: Component, loaded: Component) -> f64 {
        if (observed == Component::Y) == (loaded == Component::Y) {
            1.0
        } else {
            -1.0
        }
    }
}

impl Compliance for Reflected {
    fn points(&self) -> usize {
        self.original.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let n = self.points();
        let mut load = vec![0.0; n];
        for (&i, t) in self.original.iter().zip(traction) {
            load[i] = *t;
        }
        let mut moved = vec![0.0; n];
        let scale = scale * Self::sign(observed, loaded);
        self.inner
            .add_displacement(observed, loaded, scale, &load, &mut moved);
        for (u, &i) in displacement.iter_mut().zip(&self.original) {
            *u += moved[i];
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
        let n = self.points();
        let (mut own, mut found) = (vec![0.0; n], vec![0.0; n]);
        for (&i, w) in self.original.iter().zip(weights) {
            own[i] = *w;
        }
        let scale = scale * Self::sign(observed, loaded);
        self.inner
            .add_transposed(observed, loaded, scale, &own, &mut found);
        for (sum, &i) in sums.iter_mut().zip(&self.original) {
            *sum += found[i];
        }
    }

    fn prefers_products(&self) -> bool {
        self.inner.prefers_products()
    }

    fn near_inverse(&self, softer: f64) -> Option<Map> {
        let (map, original) = (self.inner.near_inverse(softer)?, self.original.clone());
        Some(Box::new(move |x: &[f64], y: &mut [f64]| {
            let (mut own, mut found) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            for (&i, x) in original.iter().zip(x) {
                own[i] = *x;
            }
            map(&own, &mut found);
            for (y, &i) in y.iter_mut().zip(&original) {
                *y = found[i];
            }
        }))
    }

    fn influence_memory(&self) -> f64 {
        square(self.points()) + self.inner.influence_memory()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let n = self.points();
        let mut block = vec![0.0; n * n];
        let scale = scale * Self::sign(observed, loaded);
        self.inner
            .add_influence(observed, loaded, scale, &mut block);
        for (row, &i) in matrix.chunks_exact_mut(n.max(1)).zip(&self.original) {
            for (a, &j) in row.iter_mut().zip(&self.original) {
                *a += block[i * n + j];
            }
        }
    }
}
