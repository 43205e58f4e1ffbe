// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::Arc;

use crate::compliance::square;
use crate::{Compliance, Component, Map};

/// A compliance under loads that are mirror images of themselves about the plane y = 0.
///
/// Only one point of each pair of mirror images is kept, so a problem with a symmetric solution is solved as
/// its half. Under the mirror, components X and Normal keep their sign and Y changes it.
pub struct SymmetricHalf {
    inner: Arc<dyn Compliance>,
    /// The points kept, as indices of the whole.
    kept: Vec<usize>,
    /// For each point of the whole: which kept point carries its load, and whether as its image; none on the plane
    /// under loads that the mirror turns around.
    source: Vec<Option<(usize, bool)>>,
    /// 1, or -1 for loads that the mirror turns around.
    parity: f64,
}

impl SymmetricHalf {
    /// The half of `inner`, whose point `i` has the mirror image `image[i]` (itself on the plane).
    ///
    /// Returns `None` where `image` is not an involution on the points of `inner`.
    pub fn new(inner: Arc<dyn Compliance>, image: &[usize]) -> Option<Self> {
        let (kept, source) = pairing(image)?;
        (inner.points() == image.len()).then_some(Self {
            inner,
            kept,
            source: source.into_iter().map(Some).collect(),
            parity: 1.0,
        })
    }

    /// The same under loads that the mirror turns around: the images carry the opposite, and points on the plane
    /// nothing, which are not kept.
    pub fn turned(inner: Arc<dyn Compliance>, image: &[usize]) -> Option<Self> {
        let whole = Self::new(inner, image)?;
        let mut place = vec![None; whole.kept.len()];
        let mut kept = Vec::new();
        for (place, &i) in place.iter_mut().zip(&whole.kept) {
            if image[i] != i {
                *place = Some(kept.len());
                kept.push(i);
            }
        }
        let turn = |source: &Option<(usize, bool)>| {
            source.and_then(|(k, image)| place[k].map(|k| (k, image)))
        };
        Some(Self {
            source: whole.source.iter().map(turn).collect(),
            inner: whole.inner,
            kept,
            parity: -1.0,
        })
    }

    /// The points kept, as indices of the whole.
    pub fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// The factor between a component at a point and at its image.
    pub fn sign(component: Component) -> f64 {
        if component == Component::Y { -1.0 } else { 1.0 }
    }
}

/// The load of a point of the whole, from those of the kept points; `sign` is that of an image.
fn carried(load: &[f64], source: Option<(usize, bool)>, sign: f64) -> f64 {
    match source {
        None => 0.0,
        Some((k, false)) => load[k],
        Some((k, true)) => sign * load[k],
    }
}

impl Compliance for SymmetricHalf {
    fn points(&self) -> usize {
        self.kept.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let sign = self.parity * Self::sign(loaded);
        let sources = self.source.iter();
        let whole: Vec<f64> = sources.map(|s| carried(traction, *s, sign)).collect();
        let mut moved = vec![0.0; whole.len()];
        self.inner
            .add_displacement(observed, loaded, scale, &whole, &mut moved);
        for (u, &i) in displacement.iter_mut().zip(&self.kept) {
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
        let n = self.source.len();
        let (mut whole, mut found) = (vec![0.0; n], vec![0.0; n]);
        for (w, &i) in weights.iter().zip(&self.kept) {
            whole[i] = *w;
        }
        self.inner
            .add_transposed(observed, loaded, scale, &whole, &mut found);
        let sign = self.parity * Self::sign(loaded);
        for (found, source) in found.iter().zip(&self.source) {
            if let Some((k, image)) = *source {
                sums[k] += if image { sign * found } else { *found };
            }
        }
    }

    fn prefers_products(&self) -> bool {
        self.inner.prefers_products()
    }

    fn near_inverse(&self, softer: f64) -> Option<Map> {
        let map = self.inner.near_inverse(softer)?;
        let (kept, source, parity) = (self.kept.clone(), self.source.clone(), self.parity);
        Some(Box::new(move |x: &[f64], y: &mut [f64]| {
            let whole: Vec<f64> = source.iter().map(|s| carried(x, *s, parity)).collect();
            let mut found = vec![0.0; whole.len()];
            map(&whole, &mut found);
            for (y, &i) in y.iter_mut().zip(&kept) {
                *y = found[i];
            }
        }))
    }

    fn influence_memory(&self) -> f64 {
        square(self.source.len()) + self.inner.influence_memory()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let (n, k) = (self.source.len(), self.kept.len());
        let sign = self.parity * Self::sign(loaded);
        let mut whole = vec![0.0; n * n];
        self.inner
            .add_influence(observed, loaded, scale, &mut whole);
        for (row, &i) in matrix.chunks_exact_mut(k.max(1)).zip(&self.kept) {
            for (a, source) in whole[i * n..(i + 1) * n].iter().zip(&self.source) {
                if let Some((k, image)) = *source {
                    row[k] += if image { sign * a } else { *a };
                }
            }
        }
    }
}

/// The whole of a body that is known by its half, for loads that are their own mirror images.
///
/// The inverse of [`SymmetricHalf`]: only the kept points of a load are looked at, so a load that is not symmetric is
/// answered as if it were.
pub struct SymmetricWhole {
    half: Arc<dyn Compliance>,
    kept: Vec<usize>,
    source: Vec<(usize, bool)>,
}

impl SymmetricWhole {
    /// The whole, whose point `i` has the mirror image `image[i]`, from the `half` on its kept points.
    ///
    /// Returns `None` where `image` is not an involution or does not leave as many points as `half` has.
    pub fn new(half: Arc<dyn Compliance>, image: &[usize]) -> Option<Self> {
        let (kept, source) = pairing(image)?;
        (kept.len() == half.points()).then_some(Self { half, kept, source })
    }
}

impl Compliance for SymmetricWhole {
    fn points(&self) -> usize {
        self.source.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let load: Vec<f64> = self.kept.iter().map(|&i| traction[i]).collect();
        let mut moved = vec![0.0; load.len()];
        self.half
            .add_displacement(observed, loaded, scale, &load, &mut moved);
        let sign = SymmetricHalf::sign(observed);
        for (u, &(k, image)) in displacement.iter_mut().zip(&self.source) {
            *u += if image { sign * moved[k] } else { moved[k] };
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
        let (mut own, mut found) = (vec![0.0; self.kept.len()], vec![0.0; self.kept.len()]);
        let sign = if observed == Component::Y { -1.0 } else { 1.0 };
        for (w, &(k, image)) in weights.iter().zip(&self.source) {
            own[k] += if image { sign * w } else { *w };
        }
        self.half
            .add_transposed(observed, loaded, scale, &own, &mut found);
        for (found, &i) in found.iter().zip(&self.kept) {
            sums[i] += found;
        }
    }

    fn prefers_products(&self) -> bool {
        self.half.prefers_products()
    }

    fn influence_memory(&self) -> f64 {
        square(self.kept.len()) + self.half.influence_memory()
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        let (n, k) = (self.source.len(), self.kept.len());
        let mut half = vec![0.0; k * k];
        self.half.add_influence(observed, loaded, scale, &mut half);
        let sign = SymmetricHalf::sign(observed);
        for (row, &(i, image)) in matrix.chunks_exact_mut(n.max(1)).zip(&self.source) {
            for (&j, a) in self.kept.iter().zip(&half[i * k..(i + 1) * k]) {
                row[j] += if image { sign * a } else { *a };
            }
        }
    }
}

/// The kept points, and for each point which kept one it is (`false`) or is the image of (`true`).
type Pairing = (Vec<usize>, Vec<(usize, bool)>);

/// The pairing of an involution; `None` if `image` is none.
fn pairing(image: &[usize]) -> Option<Pairing> {
    let n = image.len();
    let paired = |i: usize| image.get(image[i]) == Some(&i);
    if image.iter().any(|&j| j >= n) || !(0..n).all(paired) {
        return None;
    }
    let kept: Vec<usize> = (0..n).filter(|&i| i <= image[i]).collect();
    let mut source = vec![(0, false); n];
    for (k, &i) in kept.iter().enumerate() {
        source[image[i]] = (k, true);
        source[i] = (k, false);
    }
    Some((kept, source))
}
