// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of a solution, with the points inside and on the rim of their discs held as they are.
//!
//! The matrix is that of the last Newton step, which has the exact derivative of the projection equation. Its
//! transpose needs that of the operator, and gives the derivatives of one number by everything at once.

use mtb_operator::krylov::gmres;
use mtb_operator::{Monitor, report};

use super::linear::LinearStep;
use super::newton::{Iterate, dot, law, norm};
use super::problem::{DiscProblem, DiscState, Resultant};
use crate::error::{Error, check};

/// Residual, over that of no step, at which a linear system counts as solved, and the one that is needed.
const ENOUGH: f64 = 1e-11;
const NEEDED: f64 = 1e-10;

/// Basis vectors between two restarts, and most restarts.
const BASIS: usize = 60;
const RESTARTS: usize = 20;

/// A change of what is given; or the derivatives of a number by it.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscChange {
    /// Of the offset, (2n).
    pub offset: Vec<f64>,
    /// Of the radii, at a given image, (n).
    pub radius: Vec<f64>,
    /// Of the resultants.
    pub values: Vec<f64>,
}

/// A change of what is found; or the weights of a number in it.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscResponse {
    /// Of the field, (2n).
    pub field: Vec<f64>,
    /// Of the image, (2n).
    pub image: Vec<f64>,
    /// Of the multipliers.
    pub multipliers: Vec<f64>,
    /// Of the radii, (n).
    pub radius: Vec<f64>,
}

/// A solution as its derivatives see it.
pub struct DiscTangent<'a> {
    problem: &'a DiscProblem<'a>,
    /// With the transposed operator, and resultants whose direction and weight are exchanged.
    transposed: &'a DiscProblem<'a>,
    iterate: Iterate,
    /// Direction in which a point is held, both components: on the rim, and in discs of radius zero against their
    /// image.
    normal: Vec<f64>,
    /// Products with the operator, or its transpose, so far.
    pub products: usize,
    /// Applications of a preconditioner so far.
    pub preconditionings: usize,
}

/// Resultants as they stand in the transposed problem.
pub fn transposed(resultants: &[Resultant]) -> Vec<Resultant> {
    let exchanged = |r: &Resultant| Resultant {
        direction: r.weight.clone(),
        weight: r.direction.clone(),
        ..*r
    };
    resultants.iter().map(exchanged).collect()
}

impl<'a> DiscTangent<'a> {
    /// At the solution `field` (2n) and `multipliers` of a problem whose resultants do not yield; `transposed` is the
    /// same problem with the transposed operator, a preconditioner of it, and [`transposed`] resultants.
    ///
    /// # Errors
    /// Wrong lengths, and numbers that are not finite.
    pub fn new(
        problem: &'a DiscProblem<'a>,
        transposed: &'a DiscProblem<'a>,
        field: &[f64],
        multipliers: &[f64],
    ) -> Result<Self, Error> {
        check("field", field, problem.offset.len())?;
        check("multipliers", multipliers, problem.resultants.len())?;
        let mut products = 0;
        let iterate = Iterate::new(problem, field.to_vec(), multipliers.to_vec(), &mut products);
        let n = iterate.radius.len();
        let mut normal = iterate.normal.clone();
        for i in 0..n {
            if iterate.state[i] == DiscState::Excluded && iterate.magnitude[i] > 0.0 {
                normal[i] = -iterate.image[i] / iterate.magnitude[i];
                normal[n + i] = -iterate.image[n + i] / iterate.magnitude[i];
            }
        }
        Ok(Self {
            problem,
            transposed,
            iterate,
            normal,
            products,
            preconditionings: 0,
        })
    }

    /// The magnitudes of the image, (n).
    pub fn magnitude(&self) -> &[f64] {
        &self.iterate.magnitude
    }

    /// The magnitudes of the image where points are on the rim, and 0 elsewhere, (n).
    pub fn magnitude_on_rim(&self) -> Vec<f64> {
        let pairs = self.iterate.magnitude.iter().zip(&self.iterate.state);
        pairs
            .map(|(m, state)| match state {
                DiscState::Rim => *m,
                _ => 0.0,
            })
            .collect()
    }

    /// The change (n) of the magnitudes by one of the image (2n), on the rim.
    pub fn magnitude_change(&self, image: &[f64]) -> Vec<f64> {
        let (n, normal) = (self.iterate.radius.len(), &self.iterate.normal);
        let change = |i: usize| match self.iterate.state[i] {
            DiscState::Rim => -(normal[i] * image[i] + normal[n + i] * image[n + i]),
            _ => 0.0,
        };
        (0..n).map(change).collect()
    }

    /// The transpose of [`DiscTangent::magnitude_change`].
    pub fn weigh_magnitude(&self, weights: &[f64], image: &mut [f64]) {
        let n = self.iterate.radius.len();
        for i in 0..n {
            if self.iterate.state[i] == DiscState::Rim {
                for c in [0, n] {
                    image[c + i] -= self.iterate.normal[c + i] * weights[i];
                }
            }
        }
    }

    /// What changes of the solution follow from a change of what is given; `None` where the matrix is singular.
    ///
    /// # Errors
    /// [`Error::Interrupted`] by the monitor.
    pub fn forward(
        &mut self,
        change: &DiscChange,
        monitor: Monitor<'_>,
    ) -> Result<Option<DiscResponse>, Error> {
        let n = self.iterate.radius.len();
        let step = LinearStep::new(self.problem, &self.iterate);
        let mut base = vec![0.0; 2 * n];
        for c in [0, n] {
            for i in 0..n {
                base[c + i] = change.radius[i] * self.normal[c + i];
            }
        }
        let mut image = vec![0.0; 2 * n];
        self.problem.operator.apply(&base, &mut image);
        add(&mut image, 1.0, &change.offset);
        let m = self.problem.resultants.len();
        let mut right = vec![0.0; 2 * n + m];
        let radius = step.magnitude_change(&image, None);
        step.assemble_rows(&image, &base, None, radius.as_deref(), &mut right);
        for (k, resultant) in self.problem.resultants.iter().enumerate() {
            right[2 * n + k] =
                step.row_scale() * (dot(&resultant.weight, &base) - change.values[k]);
        }
        if radius.is_none() {
            // where nearly all of it is along the normals, rounding leaves some of that, which no field makes
            let (along, across) = right[..2 * n].split_at_mut(n);
            let normals = self.iterate.normal[..n]
                .iter()
                .zip(&self.iterate.normal[n..]);
            for ((x, y), (nx, ny)) in along.iter_mut().zip(across).zip(normals) {
                let own = *x * nx + *y * ny;
                *x -= own * nx;
                *y -= own * ny;
            }
        }
        for v in &mut right {
            *v = -*v;
        }
        let mut counts = [1, 0];
        let found = solved(
            |x, y| {
                let operator = self.problem.operator;
                step.apply(operator, x, y, &mut vec![0.0; 2 * n], &mut vec![0.0; 2 * n]);
            },
            |y, x| step.precondition(y, x, &mut vec![0.0; 2 * n]),
            &self.row_units(m),
            right,
            &mut counts,
            monitor,
        )?;
        let Some(found) = found else {
            return Ok(None);
        };
        let mut field = base;
        add(&mut field, 1.0, &found[..2 * n]);
        self.problem.operator.apply(&field, &mut image);
        add(&mut image, 1.0, &change.offset);
        for (c, resultant) in found[2 * n..].iter().zip(self.problem.resultants) {
            add(&mut image, -c, &resultant.direction);
        }
        let mut radius = change.radius.clone();
        if let Some(more) = step.magnitude_change(&image, None) {
            add(&mut radius, 1.0, &more);
        }
        self.mask(&mut image);
        self.products += counts[0] + 1;
        self.preconditionings += counts[1];
        Ok(Some(DiscResponse {
            field,
            image,
            multipliers: found[2 * n..].to_vec(),
            radius,
        }))
    }

    /// The derivatives by all that is given of a number that weighs what was found; `None` where the matrix is
    /// singular.
    ///
    /// # Errors
    /// [`Error::Interrupted`] by the monitor.
    pub fn adjoint(
        &mut self,
        weights: &DiscResponse,
        monitor: Monitor<'_>,
    ) -> Result<Option<DiscChange>, Error> {
        let n = self.iterate.radius.len();
        let m = self.problem.resultants.len();
        let step = LinearStep::new(self.transposed, &self.iterate);
        let is_dependent = law(self.problem).is_some();
        let mut of_image = weights.image.clone();
        self.mask(&mut of_image);
        if let Some(law) = law(self.problem) {
            // a radius follows the magnitudes of the image
            let mut of_magnitude = vec![0.0; n];
            law.derivative_transposed(&self.iterate.magnitude, &weights.radius, &mut of_magnitude);
            for c in [0, n] {
                for i in 0..n {
                    of_image[c + i] -= self.iterate.normal[c + i] * of_magnitude[i];
                }
            }
        }
        let mut of_field = weights.field.clone();
        let mut image = vec![0.0; 2 * n];
        let mut counts = [1, 0];
        if of_image.iter().any(|w| *w != 0.0) {
            self.transposed.operator.apply(&of_image, &mut image);
            counts[0] += 1;
            add(&mut of_field, 1.0, &image);
        }
        let mut right = of_field.clone();
        step.reduce(&mut right, is_dependent);
        for (k, resultant) in self.transposed.resultants.iter().enumerate() {
            let of_multiplier = weights.multipliers[k] - dot(&resultant.weight, &of_image);
            right.push(-step.row_scale() * of_multiplier);
        }
        let apply = |y: &[f64], x: &mut [f64]| {
            let pressed = self.pressed(&step, &y[..2 * n]);
            self.transposed.operator.apply(&pressed, &mut x[..2 * n]);
            for (c, resultant) in y[2 * n..].iter().zip(self.transposed.resultants) {
                add(&mut x[..2 * n], -c, &resultant.direction);
            }
            let mut held = vec![0.0; 2 * n];
            self.stiffen(&y[..2 * n], &mut held);
            add(&mut x[..2 * n], 1.0, &held);
            step.reduce(&mut x[..2 * n], is_dependent);
            for (k, resultant) in self.transposed.resultants.iter().enumerate() {
                x[2 * n + k] = step.row_scale() * dot(&resultant.weight, &pressed);
            }
        };
        let precondition =
            |y: &[f64], x: &mut [f64]| step.precondition(y, x, &mut vec![0.0; 2 * n]);
        let units = self.row_units(m);
        let found = solved(apply, precondition, &units, right, &mut counts, monitor)?;
        let Some(found) = found else {
            return Ok(None);
        };
        let pressed = self.pressed(&step, &found[..2 * n]);
        self.transposed.operator.apply(&pressed, &mut image);
        add(&mut of_field, -1.0, &image);
        for (c, resultant) in found[2 * n..].iter().zip(self.transposed.resultants) {
            add(&mut of_field, *c, &resultant.direction);
        }
        let along =
            (0..n).map(|i| of_field[i] * self.normal[i] + of_field[n + i] * self.normal[n + i]);
        let radius = along.zip(&weights.radius).map(|(a, w)| a + w).collect();
        let mut offset = of_image;
        add(&mut offset, -1.0, &pressed);
        self.products += counts[0];
        self.preconditionings += counts[1];
        Ok(Some(DiscChange {
            offset,
            radius,
            values: (0..m).map(|k| -found[2 * n + k]).collect(),
        }))
    }

    /// What the rows of the linear systems, and of `m` resultants, are large by: the curvature of a point with next to
    /// no radius, in units of the diagonal, whose rounding is otherwise more than all that is left of other rows.
    fn row_units(&self, m: usize) -> Vec<f64> {
        let own = |c: &f64| 1.0 + c / self.problem.diagonal;
        let units: Vec<f64> = self.iterate.curvature.iter().map(own).collect();
        [&units[..], &units[..], &vec![1.0; m][..]].concat()
    }

    /// Takes out what cannot change: the image inside of the discs.
    fn mask(&self, image: &mut [f64]) {
        let n = self.iterate.radius.len();
        for i in 0..n {
            if self.iterate.state[i] == DiscState::Inside {
                image[i] = 0.0;
                image[n + i] = 0.0;
            }
        }
    }

    /// What the rows of the image give to a field of them, transposed: itself inside, its tangential part on the rim
    /// and there, where radii follow the image, what all rows along normals leave.
    fn pressed(&self, step: &LinearStep<'_>, rows: &[f64]) -> Vec<f64> {
        let n = self.iterate.radius.len();
        let mut pressed = rows.to_vec();
        step.reduce(&mut pressed, false);
        if let Some(law) = law(self.problem) {
            let normal = &self.iterate.normal;
            let along: Vec<f64> = (0..n)
                .map(|i| {
                    self.problem.diagonal * (normal[i] * rows[i] + normal[n + i] * rows[n + i])
                })
                .collect();
            let mut back = vec![0.0; n];
            law.derivative_transposed(&self.iterate.magnitude, &along, &mut back);
            for c in [0, n] {
                for i in 0..n {
                    pressed[c + i] += normal[c + i] * back[i];
                }
            }
        }
        pressed
    }

    /// The part of the matrix that acts point by point: the curvature along the rim, and along normals that move the
    /// diagonal.
    fn stiffen(&self, rows: &[f64], held: &mut [f64]) {
        let n = self.iterate.radius.len();
        let is_dependent = law(self.problem).is_some();
        for i in 0..n {
            if self.iterate.state[i] != DiscState::Rim {
                continue;
            }
            let (nx, ny) = (self.iterate.normal[i], self.iterate.normal[n + i]);
            let along = nx * rows[i] + ny * rows[n + i];
            let across = nx * rows[n + i] - ny * rows[i];
            let across = self.iterate.curvature[i] * across;
            let along = if is_dependent {
                self.problem.diagonal * along
            } else {
                0.0
            };
            held[i] = along * nx - across * ny;
            held[n + i] = along * ny + across * nx;
        }
    }
}

/// Solves a linear system, whose rows count in their `units`, for a right side; `None` where its residual does not fall
/// far enough.
fn solved(
    apply: impl Fn(&[f64], &mut [f64]),
    precondition: impl Fn(&[f64], &mut [f64]),
    units: &[f64],
    mut right: Vec<f64>,
    counts: &mut [usize; 2],
    monitor: Monitor<'_>,
) -> Result<Option<Vec<f64>>, Error> {
    let counted = |rows: &mut [f64]| rows.iter_mut().zip(units).for_each(|(r, u)| *r /= u);
    let apply = |x: &[f64], y: &mut [f64]| {
        apply(x, y);
        counted(y);
    };
    let precondition = |y: &[f64], x: &mut [f64]| {
        let rows: Vec<f64> = y.iter().zip(units).map(|(y, u)| y * u).collect();
        precondition(&rows, x);
    };
    counted(&mut right);
    let start = norm(&right);
    let mut x = vec![0.0; right.len()];
    if start == 0.0 {
        return Ok(Some(x));
    }
    let mut residual = right.clone();
    let mut reached = 1.0;
    for round in 0..RESTARTS {
        report(monitor, round, reached)?;
        let krylov = gmres(
            &apply,
            &precondition,
            &mut x,
            &mut residual,
            ENOUGH * start,
            BASIS,
        );
        counts[0] += krylov.steps + 1;
        counts[1] += krylov.steps + 1;
        let before = reached;
        let mut image = vec![0.0; x.len()];
        apply(&x, &mut image);
        residual.copy_from_slice(&right);
        add(&mut residual, -1.0, &image);
        reached = norm(&residual) / start;
        // what rounding leaves falls no further
        if krylov.residual <= ENOUGH * start || reached > 0.5 * before {
            break;
        }
    }
    Ok((reached <= NEEDED).then_some(x))
}

fn add(to: &mut [f64], scale: f64, field: &[f64]) {
    for (to, v) in to.iter_mut().zip(field) {
        *to += scale * v;
    }
}
