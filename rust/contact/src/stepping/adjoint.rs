// SPDX-License-Identifier: MIT OR Apache-2.0
//! The linearised equations the other way round: gradients of sums of what is found.

use faer::Mat;
use mtb_operator::Monitor;
use mtb_operator::krylov::dot;

use super::bordered::stacked;
use super::tangent::{Found, Given, Tangent};
use crate::error::{Error, check};
use crate::magnet::Pulling;

/// Weights of sums of what is found, those of one sum after those of the other.
#[derive(Clone, Copy, Debug)]
pub struct Weights<'a> {
    /// How many sums there are.
    pub count: usize,
    /// Of tractions along both tangents, then of pressures (3n a sum).
    pub unknowns: &'a [f64],
    /// Of deformed gaps (n a sum); empty where no sum has any.
    pub gap: &'a [f64],
    /// Of the amplitudes of motions (m a sum); empty where no sum has any.
    pub motion: &'a [f64],
    /// Of the pull of a magnet that follows the gap (n a sum); empty where no sum has any.
    pub pull: &'a [f64],
}

/// Gradients of sums by what loads a contact, those of one sum after those of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct ByLoads {
    /// By the gap (n a sum).
    pub gap: Vec<f64>,
    /// By the work on each motion (m a sum).
    pub work: Vec<f64>,
    /// By the pull of a magnet that follows the gap, with all gaps held (n a sum); empty without one.
    pub pull: Vec<f64>,
}

/// Column `j` of `length` numbers.
fn column(values: &[f64], j: usize, length: usize) -> &[f64] {
    &values[j * length..(j + 1) * length]
}

impl Weights<'_> {
    fn check(&self, n: usize, m: usize) -> Result<(), Error> {
        let size = |given: &[f64], each| {
            if given.is_empty() {
                0
            } else {
                self.count * each
            }
        };
        check("unknowns", self.unknowns, self.count * 3 * n)?;
        check("gap", self.gap, size(self.gap, n))?;
        check("motion", self.motion, size(self.motion, m))?;
        check("pull", self.pull, size(self.pull, n))
    }
}

impl Tangent<'_> {
    /// The gradients, by all that is given, of sums of what is found with the weights `of`: one for each.
    ///
    /// # Errors
    /// As [`Tangent::forward`].
    pub fn adjoint(&mut self, of: &[Found], monitor: Monitor<'_>) -> Result<Vec<Given>, Error> {
        let (n, m) = (self.count(), self.state.motions.len());
        let mut unknowns = Vec::with_capacity(of.len() * 3 * n);
        for weights in of {
            check("pressure", &weights.pressure, n)?;
            check("traction", &weights.traction, 2 * n)?;
            check("gap", &weights.gap, n)?;
            check("motion", &weights.motion, m)?;
            unknowns.extend_from_slice(&weights.traction);
            unknowns.extend_from_slice(&weights.pressure);
        }
        let gap: Vec<f64> = of.iter().flat_map(|w| w.gap.iter().copied()).collect();
        let motion: Vec<f64> = of.iter().flat_map(|w| w.motion.iter().copied()).collect();
        let mut pull = Vec::new();
        if of.iter().any(|w| !w.pull.is_empty()) {
            for (j, weights) in of.iter().enumerate() {
                pull.extend_from_slice(&weights.pull);
                pull.resize((j + 1) * n, 0.0);
            }
        }
        let of = Weights {
            count: of.len(),
            unknowns: &unknowns,
            gap: &gap,
            motion: &motion,
            pull: &pull,
        };
        let found = self.by_loads(&of, monitor)?;
        let [x, y] = [self.by_drag(&of, &found, 0)?, self.by_drag(&of, &found, 1)?];
        let hardness = self.by_hardness(&of, &found)?;
        let gradients = (0..of.count).map(|j| Given {
            gap: column(&found.gap, j, n).to_vec(),
            work: column(&found.work, j, m).to_vec(),
            drag: [column(&x, j, n), column(&y, j, n)].concat(),
            pull: if found.pull.is_empty() {
                Vec::new()
            } else {
                column(&found.pull, j, n).to_vec()
            },
            hardness: if hardness.is_empty() {
                Vec::new()
            } else {
                column(&hardness, j, n).to_vec()
            },
        });
        Ok(gradients.collect())
    }

    /// The gradients by gap and work alone: [`Tangent::by_drag`] makes those by friction once they are asked for.
    ///
    /// # Errors
    /// As [`Tangent::forward`].
    pub fn by_loads(&mut self, of: &Weights<'_>, monitor: Monitor<'_>) -> Result<ByLoads, Error> {
        let mut found = self.by_loads_held(of, monitor)?;
        let Some(pulling) = self.pulling else {
            return Ok(found);
        };
        let (n, m) = (self.count(), self.state.motions.len());
        for j in 0..of.count {
            let mut own = pulling.weights(column(&found.gap, j, n), column(&found.work, j, m));
            if !of.pull.is_empty() {
                let given = column(of.pull, j, n);
                own.iter_mut().zip(given).for_each(|(o, w)| *o += w);
            }
            let pull = Pulling::returned(
                &own,
                |pull| {
                    let back = self.of_gap(&pulling.slopes().transposed(pull)?, monitor)?;
                    Ok(pulling.weights(&back.gap, &back.work))
                },
                monitor,
            )?;
            let more = self.of_gap(&pulling.slopes().transposed(&pull)?, monitor)?;
            let gap = &mut found.gap[j * n..(j + 1) * n];
            gap.iter_mut().zip(&more.gap).for_each(|(g, d)| *g += d);
            let work = &mut found.work[j * m..(j + 1) * m];
            work.iter_mut().zip(&more.work).for_each(|(w, d)| *w += d);
            found.pull.extend(pull);
        }
        Ok(found)
    }

    /// The gradients of a sum of gaps with these weights (n), the pull of a magnet held.
    fn of_gap(&mut self, gap: &[f64], monitor: Monitor<'_>) -> Result<ByLoads, Error> {
        let of = Weights {
            count: 1,
            unknowns: &vec![0.0; 3 * self.count()],
            gap,
            motion: &[],
            pull: &[],
        };
        self.by_loads_held(&of, monitor)
    }

    /// The same with the pull of a magnet held.
    fn by_loads_held(&mut self, of: &Weights<'_>, monitor: Monitor<'_>) -> Result<ByLoads, Error> {
        let (n, m, k) = (self.count(), self.state.motions.len(), self.points.len());
        of.check(n, m)?;
        let mut gap = vec![0.0; of.count * n];
        let mut rhs = Mat::zeros(k + m, of.count);
        let (along, across) = self.terms.drag.split_at(n);
        for j in 0..of.count {
            let (pressures, motions) = rhs.col_as_slice_mut(j).split_at_mut(k);
            let (traction, pressure) = column(of.unknowns, j, 3 * n).split_at(2 * n);
            let (on_x, on_y) = traction.split_at(n);
            for (to, &i) in pressures.iter_mut().zip(&self.points) {
                *to = pressure[i] + on_x[i] * along[i] + on_y[i] * across[i];
            }
            if !of.motion.is_empty() {
                motions.copy_from_slice(column(of.motion, j, m));
            }
        }
        if !of.gap.is_empty() {
            self.add_open(of, &mut gap, &mut rhs);
        }
        let found = self.solved(&rhs, true, monitor)?;
        let mut work = Vec::with_capacity(of.count * m);
        for j in 0..of.count {
            let (pressures, motions) = found.col_as_slice(j).split_at(k);
            let gap = &mut gap[j * n..(j + 1) * n];
            for (&point, v) in self.points.iter().zip(pressures) {
                gap[point] = -v;
            }
            work.extend_from_slice(motions);
        }
        Ok(ByLoads {
            gap,
            work,
            pull: Vec::new(),
        })
    }

    /// Puts the weights of open gaps to `gap`, and adds what they are as weights of pressures and motions.
    fn add_open(&self, of: &Weights<'_>, gap: &mut [f64], rhs: &mut Mat<f64>) {
        let (n, k) = (self.count(), self.points.len());
        gap.copy_from_slice(of.gap);
        for gap in gap.chunks_exact_mut(n.max(1)) {
            for &point in &self.points {
                gap[point] = 0.0;
            }
        }
        if gap.iter().all(|weight| *weight == 0.0) {
            return;
        }
        let sides = stacked((0..of.count).map(|j| column(gap, j, n)), n);
        let pulled = self.pulled_back(&sides);
        for j in 0..of.count {
            let (pressures, motions) = rhs.col_as_slice_mut(j).split_at_mut(k);
            let (pulled, side) = (pulled.col_as_slice(j), sides.col_as_slice(j));
            for (to, &point) in pressures.iter_mut().zip(&self.points) {
                *to += pulled[point];
            }
            for (to, motion) in motions.iter_mut().zip(&self.state.motions) {
                *to += dot(&motion.opening, side);
            }
        }
    }

    /// The gradients (n a sum) by the hardness, of the sums whose gradients by loads are `found`; empty without one.
    ///
    /// # Errors
    /// Wrong lengths.
    pub fn by_hardness(&self, of: &Weights<'_>, found: &ByLoads) -> Result<Vec<f64>, Error> {
        let (n, m) = (self.count(), self.state.motions.len());
        of.check(n, m)?;
        check("gap", &found.gap, of.count * n)?;
        check("work", &found.work, of.count * m)?;
        if self.state.limit.is_none() {
            return Ok(Vec::new());
        }
        let flows = self.state.sides().held;
        let sides = stacked((0..of.count).map(|j| column(&found.gap, j, n)), n);
        let pulled = self.pulled_back(&sides);
        let mut all = vec![0.0; of.count * n];
        for (j, hardness) in all.chunks_exact_mut(n.max(1)).enumerate() {
            let weights = column(of.unknowns, j, 3 * n);
            let work = column(&found.work, j, m);
            for i in (0..n).filter(|&i| flows[i]) {
                let drag = [i, n + i].map(|at| self.terms.drag[at]);
                let own = self.terms.diagonal.get(i).copied().unwrap_or(0.0);
                let moved = self.state.motions.iter().zip(work).map(|(motion, work)| {
                    let [x, y] = [motion.tangential_x[i], motion.tangential_y[i]];
                    work * (motion.opening[i] + drag[0] * x + drag[1] * y)
                });
                hardness[i] = weights[2 * n + i]
                    + drag[0] * weights[i]
                    + drag[1] * weights[n + i]
                    + pulled[(i, j)]
                    + own * sides[(i, j)]
                    + self.state.area[i] * moved.sum::<f64>();
            }
        }
        Ok(all)
    }

    /// The gradients (n a sum) by friction along the tangent `axis`, of the sums whose gradients by loads are `found`.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn by_drag(
        &mut self,
        of: &Weights<'_>,
        found: &ByLoads,
        axis: usize,
    ) -> Result<Vec<f64>, Error> {
        let mut own = self.by_size_too(of, found, axis)?;
        if self.state.yields.iter().any(|yields| *yields) {
            let n = self.count();
            let other = self.by_size_too(of, found, 1 - axis)?;
            for (own, other) in own.chunks_exact_mut(n).zip(other.chunks_exact(n)) {
                let mut drag = if axis == 0 {
                    [&*own, other].concat()
                } else {
                    [other, &*own].concat()
                };
                self.state.turned(&mut drag);
                own.copy_from_slice(&drag[axis * n..(axis + 1) * n]);
            }
        }
        Ok(own)
    }

    /// The same where friction may change its size at all points.
    fn by_size_too(
        &mut self,
        of: &Weights<'_>,
        found: &ByLoads,
        axis: usize,
    ) -> Result<Vec<f64>, Error> {
        let (n, m) = (self.count(), self.state.motions.len());
        of.check(n, m)?;
        check("gap", &found.gap, of.count * n)?;
        check("work", &found.work, of.count * m)?;
        let sides = stacked((0..of.count).map(|j| column(&found.gap, j, n)), n);
        let product = self.form.kept_along(axis, &sides);
        let mut all = vec![0.0; of.count * n];
        for (j, drag) in all.chunks_exact_mut(n.max(1)).enumerate() {
            for (motion, work) in (self.state.motions.iter()).zip(column(&found.work, j, m)) {
                let moved = [&motion.tangential_x, &motion.tangential_y][axis];
                for (drag, moved) in drag.iter_mut().zip(moved) {
                    *drag += work * moved;
                }
            }
            let weights = &column(of.unknowns, j, 3 * n)[axis * n..(axis + 1) * n];
            for ((drag, weight), area) in drag.iter_mut().zip(weights).zip(&self.state.area) {
                *drag = weight + area * *drag;
            }
            if let Some(product) = &product {
                for (drag, product) in drag.iter_mut().zip(product.col_as_slice(j)) {
                    *drag += product;
                }
            }
            for (drag, pressure) in drag.iter_mut().zip(&self.state.pressure) {
                *drag *= pressure.max(0.0);
            }
        }
        Ok(all)
    }

    /// Weights of pressures (n) that weights of gaps (n) amount to, a column each.
    fn pulled_back(&self, gap: &Mat<f64>) -> Mat<f64> {
        let n = self.count();
        let mut sum = self.form.transposed_normal(gap);
        for axis in [0, 1] {
            let drag = &self.terms.drag[axis * n..(axis + 1) * n];
            if drag.iter().all(|d| *d == 0.0) {
                continue;
            }
            let Some(product) = self.form.transposed_along(axis, gap) else {
                continue;
            };
            for j in 0..gap.ncols() {
                let sum = sum.col_as_slice_mut(j).iter_mut();
                for ((sum, drag), product) in sum.zip(drag).zip(product.col_as_slice(j)) {
                    *sum += drag * product;
                }
            }
        }
        sum
    }
}
