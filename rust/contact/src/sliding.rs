// SPDX-License-Identifier: MIT OR Apache-2.0
//! Gross sliding: every point in contact slips, so friction is known once the pressure is.

use std::sync::Arc;

use mtb_complementarity::linear::{
    Border, ByProducts, KeptFactor, Options, Problem, Solution, Status, definiteness_limit, solve,
    solve_by_products,
};
use mtb_operator::{Compliance, Component, Map, Monitor, Relative, check_factors, report};

use crate::columns::largest;
use crate::error::{Error, check};
use crate::interface::{Interface, Linearisation, ROUNDS, SETTLED, Yielding};

/// Two bodies whose contact slides everywhere.
///
/// With Coulomb friction `q = mu p d` on the lower body the gap is linear in the pressure alone,
/// `g = g0 + (C_nn + mu C_nt d) p + sum c_k o_k`, and the contact conditions are one, generally
/// non-symmetric, linear complementarity problem [Klarbring1990].
#[derive(Clone, Copy)]
pub struct SlidingContact<'a> {
    /// Gap of the unloaded pair (n) [m], > 0 open; prescribed motions and attraction included.
    pub gap: &'a [f64],
    /// Area that belongs to each point (n) [m2].
    pub area: &'a [f64],
    /// Friction coefficient at each point (n).
    pub friction: &'a [f64],
    /// Sliding direction of the upper body in the tangent plane: X components, then Y components (2n).
    pub direction: &'a [f64],
    /// Rigid motions that supports leave free.
    pub motions: &'a [RigidMotion],
    /// How far a pressure opens its own point besides what it does to the bodies (n) [m/Pa]: a layer, a step of wear.
    /// It may differ from solve to solve. Below zero a point closes under its own pressure, as a pull does that
    /// follows the gap; less than the compliance of the bodies there, or the point snaps shut.
    pub diagonal: Option<&'a [f64]>,
    /// Hardness, shear limit of a layer, and rough layer; `None` where there are none.
    pub interface: Option<&'a Interface>,
}

/// A rigid motion of one of the bodies that only the contact holds.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidMotion {
    /// Relative tangential displacement `u_lower - u_upper` along X by a unit of the motion (n).
    pub tangential_x: Vec<f64>,
    /// The same along Y (n).
    pub tangential_y: Vec<f64>,
    /// Opening of the gap by a unit of the motion (n).
    pub opening: Vec<f64>,
    /// Work of all loads but the contact's on a unit of the motion [J]; the contact must cancel it.
    pub work: f64,
}

/// The sliding state, or where the search for one ended.
#[derive(Clone, Debug)]
pub struct SlidingSolution {
    /// How the search ended; only [`Status::Solved`] is a solution.
    pub status: Status,
    /// Pressure (n) [Pa].
    pub pressure: Vec<f64>,
    /// Deformed gap (n) [m]; where the pressure is the hardness, minus the depth to which a body has flowed.
    pub gap: Vec<f64>,
    /// Amplitude of each rigid motion.
    pub motion: Vec<f64>,
    /// Active sets or pivots.
    pub iterations: usize,
    /// Relative complementarity residual.
    pub residual: f64,
    /// Whether Lemke's method decided.
    pub by_lemke: bool,
    /// Whether the solution lies on a branch where more load gives less contact.
    pub unstable: bool,
}

/// The influence matrix of a sliding pair, kept for many loads.
///
/// Only `C_nn` and, where friction couples, `C_nt d` are formed; neither of them in [`SlidingMatrix::by_products`].
pub struct SlidingMatrix {
    form: Form,
    points: usize,
    /// Of the last solve without products.
    factor: Arc<KeptFactor>,
}

enum Form {
    Dense {
        normal: Vec<f64>,
        coupling: Option<Vec<f64>>,
    },
    Products {
        pair: Arc<Relative>,
        direction: Vec<f64>,
        is_coupled: bool,
        /// About that of `C_nn` for each root of an area.
        diagonal: f64,
    },
}

/// Difference between what points give way by themselves, in parts of the compliance of a point, up to which a mean
/// stands for all of them: the bodies' own compliance for the shortest waves is some hundredths of it.
const EVEN: f64 = 0.1;

/// The mean of what points give way to their own pressures besides what these do to the bodies [m/Pa]; `None` where it
/// differs too much from point to point, beside the compliance `own` of a point, for a mean to tell.
pub(crate) fn even_softness(softer: impl ExactSizeIterator<Item = f64>, own: f64) -> Option<f64> {
    let count = softer.len() as f64;
    let (mut least, mut most, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for value in softer {
        least = value.min(least);
        most = value.max(most);
        sum += value;
    }
    (most - least <= EVEN * own).then_some(sum / count)
}

/// Points from which on no matrix is made of a pair that [prefers](Compliance::prefers_products) products.
pub const PRODUCTS_FROM: usize = 3000;

/// Adds to `gap` what a pressure opens together with its friction in `direction` (2n), `friction` times the pressure.
fn add_opening(
    pair: &Relative,
    direction: &[f64],
    friction: Option<&[f64]>,
    pressure: &[f64],
    gap: &mut [f64],
) {
    pair.add_displacement(Component::Normal, Component::Normal, 1.0, pressure, gap);
    if let Some(friction) = friction {
        let amount = pressure.iter().zip(friction).map(|(p, mu)| p * mu);
        add_opening_by_friction(pair, direction, &amount.collect::<Vec<f64>>(), gap);
    }
}

/// Adds to `gap` what a friction (n) [Pa] in `direction` (2n) opens.
fn add_opening_by_friction(pair: &Relative, direction: &[f64], friction: &[f64], gap: &mut [f64]) {
    let (x, y) = direction.split_at(friction.len());
    for (component, along) in [(Component::X, x), (Component::Y, y)] {
        if along.iter().any(|d| *d != 0.0) {
            let traction: Vec<f64> = friction.iter().zip(along).map(|(q, d)| q * d).collect();
            pair.add_displacement(Component::Normal, component, 1.0, &traction, gap);
        }
    }
}

/// Solves again and again until a `round` says that it is the last one, from the points in contact of the one before.
fn in_rounds(
    mut start: Option<Vec<bool>>,
    mut round: impl FnMut(Option<Vec<bool>>) -> Result<(SlidingSolution, bool), Error>,
) -> Result<SlidingSolution, Error> {
    let mut iterations = 0;
    for count in 1.. {
        let (mut found, is_last) = round(start)?;
        iterations += found.iterations;
        found.iterations = iterations;
        if is_last {
            return Ok(found);
        }
        if count == ROUNDS {
            found.status = Status::IterationLimit;
            return Ok(found);
        }
        start = (found.status == Status::Solved)
            .then(|| found.pressure.iter().map(|p| *p > 0.0).collect());
    }
    unreachable!("the rounds end")
}

impl SlidingMatrix {
    /// Forms `C_nn`, and `C_nt d` for sliding in `direction` (2n) if `frictional`.
    ///
    /// # Errors
    /// A direction of the wrong length or that is not finite; more points than the memory holds; an interruption.
    pub fn new(
        compliance: &dyn Compliance,
        direction: &[f64],
        frictional: bool,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let n = compliance.points();
        check("direction", direction, 2 * n)?;
        let blocks = 1 + direction
            .chunks(n.max(1))
            .filter(|part| frictional && part.iter().any(|d| *d != 0.0))
            .count();
        let of_bodies = blocks as f64 * compliance.influence_memory();
        check_factors(n, memory(n, frictional) + of_bodies)?;
        let mut normal = vec![0.0; n * n];
        compliance.add_influence(Component::Normal, Component::Normal, 1.0, &mut normal);
        report(monitor, 0, f64::NAN)?;
        let mut coupling = None;
        if frictional {
            let mut sum = vec![0.0; n * n];
            for (component, along) in [
                (Component::X, &direction[..n]),
                (Component::Y, &direction[n..]),
            ] {
                if along.iter().all(|d| *d == 0.0) {
                    continue;
                }
                let mut block = vec![0.0; n * n];
                compliance.add_influence(Component::Normal, component, 1.0, &mut block);
                report(monitor, 0, f64::NAN)?;
                for (sum, block) in sum.chunks_exact_mut(n).zip(block.chunks_exact(n)) {
                    for ((s, b), d) in sum.iter_mut().zip(block).zip(along) {
                        *s += b * d;
                    }
                }
            }
            // like materials cancel; what is left of the sum is rounding
            if largest(&sum) > 1e-14 * largest(&normal) {
                coupling = Some(sum);
            }
        }
        Ok(Self {
            form: Form::Dense { normal, coupling },
            points: n,
            factor: Arc::default(),
        })
    }

    /// The same pair, solved by products alone: for many points, and a pair whose products are fast.
    ///
    /// # Errors
    /// A direction of the wrong length or that is not finite.
    pub fn by_products(
        pair: Arc<Relative>,
        direction: &[f64],
        frictional: bool,
    ) -> Result<Self, Error> {
        let n = pair.points();
        check("direction", direction, 2 * n)?;
        // any pressure that has no symmetry tells whether friction opens the gap
        let pressure: Vec<f64> = (0..n).map(|i| 1.0 + ((i * i) % 7) as f64).collect();
        let (mut alone, mut rubbing) = (vec![0.0; n], vec![0.0; n]);
        add_opening(&pair, direction, None, &pressure, &mut alone);
        if frictional {
            let one = vec![1.0; n];
            add_opening(&pair, direction, Some(&one), &pressure, &mut rubbing);
            rubbing.iter_mut().zip(&alone).for_each(|(r, a)| *r -= a);
        }
        let mut unit = vec![0.0; n];
        unit[n / 2] = 1.0;
        let mut own = vec![0.0; n];
        add_opening(&pair, direction, None, &unit, &mut own);
        Ok(Self {
            form: Form::Products {
                is_coupled: largest(&rubbing) > 1e-13 * largest(&alone),
                direction: direction.to_vec(),
                diagonal: own[n / 2],
                pair,
            },
            points: n,
            factor: Arc::default(),
        })
    }

    /// Whether friction changes the gap at all.
    pub fn is_coupled(&self) -> bool {
        match &self.form {
            Form::Dense { coupling, .. } => coupling.is_some(),
            Form::Products { is_coupled, .. } => *is_coupled,
        }
    }

    /// The factor on `friction` up to which the sliding state exists and is unique for every load.
    ///
    /// `1 / margin` of the wedging limit: below 1 the bodies may wedge. Infinite where friction does
    /// not open or close the gap. See [`definiteness_limit`]. Not a number where it is not known: without the
    /// matrix, and where friction opens or closes the gap. A `diagonal` (n) [m/Pa] as in [`SlidingContact`] counts.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, [`Error::SnapsShut`], an interruption.
    pub fn wedging_factor(
        &self,
        area: &[f64],
        friction: &[f64],
        motions: &[RigidMotion],
        diagonal: Option<&[f64]>,
        monitor: Monitor<'_>,
    ) -> Result<f64, Error> {
        let n = self.points;
        check("area", area, n)?;
        check("friction", friction, n)?;
        let (normal, coupling) = match &self.form {
            Form::Dense {
                normal,
                coupling: Some(coupling),
            } => (normal, coupling),
            Form::Products {
                is_coupled: true, ..
            } => return Ok(f64::NAN),
            _ => return Ok(f64::INFINITY),
        };
        let scaled: Vec<f64> = coupling
            .iter()
            .zip(friction.iter().cycle())
            .map(|(c, mu)| c * mu)
            .collect();
        let mut held = Vec::with_capacity(n * motions.len());
        for motion in motions {
            check("opening", &motion.opening, n)?;
            held.extend(motion.opening.iter().zip(area).map(|(o, a)| o * a));
        }
        let mut softened = Vec::new();
        if let Some(diagonal) = diagonal {
            check("diagonal", diagonal, n)?;
            softened.clone_from(normal);
            add_diagonal(&mut softened, diagonal)?;
        }
        let normal = if diagonal.is_some() {
            &softened
        } else {
            normal
        };
        Ok(definiteness_limit(
            normal,
            &scaled,
            area,
            Some(&held),
            monitor,
        )?)
    }

    /// The factor on a `feedback` (n, n) [m/Pa] of pressures on gaps up to which the sliding state exists and is unique
    /// for every load on the points of `active` (n), and only these touch: where the symmetric part of the matrix of
    /// all that pressures open stops being positive definite. Zero where it is not without the feedback, not a number
    /// without the matrix.
    ///
    /// # Errors
    /// As [`SlidingMatrix::wedging_factor`].
    pub(crate) fn feedback_factor(
        &self,
        contact: &SlidingContact<'_>,
        feedback: &[f64],
        active: &[bool],
        monitor: Monitor<'_>,
    ) -> Result<f64, Error> {
        let n = self.points;
        contact.check(n)?;
        check("feedback", feedback, n * n)?;
        let Form::Dense { normal, coupling } = &self.form else {
            return Ok(f64::NAN);
        };
        let points: Vec<usize> = (0..n).filter(|i| active[*i]).collect();
        let m = points.len();
        let mut matrix = Vec::with_capacity(m * m);
        let mut fed = Vec::with_capacity(m * m);
        for &i in &points {
            for &j in &points {
                let slid = coupling
                    .as_ref()
                    .map_or(0.0, |c| contact.friction[j] * c[i * n + j]);
                matrix.push(normal[i * n + j] + slid);
                fed.push(feedback[i * n + j]);
            }
        }
        let of = |field: &[f64]| -> Vec<f64> { points.iter().map(|&i| field[i]).collect() };
        if let Some(diagonal) = contact.diagonal {
            add_diagonal(&mut matrix, &of(diagonal))?;
        }
        let area = of(contact.area);
        let mut held = Vec::with_capacity(m * contact.motions.len());
        for motion in contact.motions {
            held.extend(points.iter().map(|&i| motion.opening[i] * contact.area[i]));
        }
        Ok(definiteness_limit(
            &matrix,
            &fed,
            &area,
            Some(&held),
            monitor,
        )?)
    }

    /// Solves for one load.
    ///
    /// `start` are the points believed in contact, for example those of the last step.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, negative areas or friction, [`Error::SnapsShut`], an
    /// interruption. A state that does not exist is a [`Status`].
    pub fn solve(
        &self,
        contact: &SlidingContact<'_>,
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<SlidingSolution, Error> {
        self.solve_fed_back(contact, None, start, monitor)
    }

    /// The same where the friction of a unit of pressure opens the gaps besides by a `feedback` (n, n) [m/Pa],
    /// row-major: where friction stops to follow the pressure, so does what it feeds back.
    ///
    /// # Errors
    /// As [`SlidingMatrix::solve`].
    pub(crate) fn solve_fed_back(
        &self,
        contact: &SlidingContact<'_>,
        feedback: Option<&[f64]>,
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<SlidingSolution, Error> {
        let n = self.points;
        contact.check(n)?;
        if let Some(feedback) = feedback {
            check("feedback", feedback, n * n)?;
        }
        let Some(shear) = contact.interface.and_then(|i| i.shear.as_ref()) else {
            return self.solve_layered(contact, feedback, start, monitor);
        };
        let mut yielding = Yielding::new(shear, contact.friction, None);
        let mut failed = None;
        in_rounds(start, |start| {
            let (friction, given) = (yielding.coefficients(), yielding.given());
            let motions = yielding.motions(contact);
            let mut gap = contact.gap.to_vec();
            self.add_friction(contact.direction, &given, &mut gap);
            let fed = feedback.map(|feedback| {
                let mut held = feedback.to_vec();
                for (gap, row) in gap.iter_mut().zip(held.chunks_exact_mut(n)) {
                    for (j, fed) in row.iter_mut().enumerate().filter(|(j, _)| given[*j] > 0.0) {
                        *gap += *fed * given[j] / contact.friction[j];
                        *fed = 0.0;
                    }
                }
                held
            });
            let held = SlidingContact {
                gap: &gap,
                friction: &friction,
                motions: &motions,
                ..*contact
            };
            let found = self.solve_layered(&held, fed.as_deref(), start, monitor)?;
            if found.status == Status::Solved {
                let has_settled = yielding.turn(&found.pressure);
                return Ok((found, has_settled));
            }
            let goes_on = yielding.retreat();
            let first = failed.get_or_insert(found).clone();
            Ok((first, !goes_on))
        })
    }

    /// Adds what a friction (n) [Pa] in `direction` (2n) opens to `gap`.
    fn add_friction(&self, direction: &[f64], friction: &[f64], gap: &mut [f64]) {
        if friction.iter().all(|q| *q == 0.0) {
            return;
        }
        match &self.form {
            Form::Dense { coupling: None, .. }
            | Form::Products {
                is_coupled: false, ..
            } => {}
            Form::Dense {
                coupling: Some(coupling),
                ..
            } => {
                for (gap, row) in gap.iter_mut().zip(coupling.chunks_exact(self.points)) {
                    *gap += row.iter().zip(friction).map(|(c, q)| c * q).sum::<f64>();
                }
            }
            Form::Products { pair, .. } => add_opening_by_friction(pair, direction, friction, gap),
        }
    }

    /// The same with a shear limit left out.
    fn solve_layered(
        &self,
        contact: &SlidingContact<'_>,
        feedback: Option<&[f64]>,
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<SlidingSolution, Error> {
        let n = self.points;
        let Some(law) = contact.interface.and_then(|i| i.rough.as_ref()) else {
            return self.solve_linear(contact, feedback, start, monitor);
        };
        let own = |i: usize| match &self.form {
            Form::Dense { normal, .. } => normal[i * (n + 1)],
            Form::Products { diagonal, .. } => *diagonal,
        };
        let mut rough = Linearisation::new(law, contact.gap, own, Some(contact.mean_pressure()));
        in_rounds(start, |start| {
            let (gap, diagonal) = rough.linear(contact.gap, contact.diagonal);
            let linear = SlidingContact {
                gap: &gap,
                diagonal: Some(&diagonal),
                ..*contact
            };
            let mut found = self.solve_linear(&linear, feedback, start, monitor)?;
            if found.status != Status::Solved {
                return Ok((found, true));
            }
            let has_settled = rough.turn(&found.pressure, &mut found.gap) <= SETTLED;
            if has_settled {
                rough.check_end(&found.pressure)?;
            }
            Ok((found, has_settled))
        })
    }

    /// The same with a law of a rough layer left out.
    fn solve_linear(
        &self,
        contact: &SlidingContact<'_>,
        feedback: Option<&[f64]>,
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<SlidingSolution, Error> {
        let n = self.points;
        let (normal, coupling) = match &self.form {
            Form::Dense { normal, coupling } => (normal, coupling),
            Form::Products {
                pair,
                direction,
                is_coupled,
                diagonal,
            } => {
                let friction = is_coupled.then_some(contact.friction);
                let multiply = |pressure: &[f64], gap: &mut [f64]| {
                    gap.fill(0.0);
                    add_opening(pair, direction, friction, pressure, gap);
                    for ((gap, p), d) in gap
                        .iter_mut()
                        .zip(pressure)
                        .zip(contact.diagonal.unwrap_or(&[]))
                    {
                        *gap += d * p;
                    }
                    if let Some(feedback) = feedback {
                        for (gap, row) in gap.iter_mut().zip(feedback.chunks_exact(n)) {
                            *gap += row.iter().zip(pressure).map(|(f, p)| f * p).sum::<f64>();
                        }
                    }
                };
                let softer = contact.diagonal.unwrap_or(&[0.0]).iter().copied();
                let near_inverse =
                    even_softness(softer, *diagonal).and_then(|softer| pair.near_inverse(softer));
                return contact.solve_by_products(
                    &multiply,
                    *diagonal,
                    near_inverse.as_ref(),
                    start.as_deref(),
                    monitor,
                );
            }
        };
        let mut matrix = normal.clone();
        let mut symmetric = true;
        if let Some(coupling) = coupling {
            symmetric = contact.friction.iter().all(|mu| *mu == 0.0);
            for (row, coupling) in matrix.chunks_exact_mut(n).zip(coupling.chunks_exact(n)) {
                for ((a, c), mu) in row.iter_mut().zip(coupling).zip(contact.friction) {
                    *a += mu * c;
                }
            }
        }
        if let Some(diagonal) = contact.diagonal {
            add_diagonal(&mut matrix, diagonal)?;
        }
        if let Some(feedback) = feedback {
            symmetric = false;
            matrix.iter_mut().zip(feedback).for_each(|(a, f)| *a += f);
        }
        contact.solve_with(matrix, symmetric, start, Some(&self.factor), monitor)
    }
}

/// Adds `diagonal` (n) to that of an n x n matrix, which must stay positive.
fn add_diagonal(matrix: &mut [f64], diagonal: &[f64]) -> Result<(), Error> {
    let own = matrix.iter_mut().step_by(diagonal.len() + 1);
    for (index, (own, diagonal)) in own.zip(diagonal).enumerate() {
        check_own(index, *own, *diagonal)?;
        *own += diagonal;
    }
    Ok(())
}

/// Whether a point that gives way by `compliance` [m/Pa] to its own pressure stays open without any, though a
/// `diagonal` [m/Pa] below zero closes it.
pub(crate) fn check_own(index: usize, compliance: f64, diagonal: f64) -> Result<(), Error> {
    if diagonal < 0.0 && compliance + diagonal <= 0.0 {
        return Err(Error::SnapsShut {
            index,
            diagonal,
            compliance,
        });
    }
    Ok(())
}

impl SlidingSolution {
    fn from(solution: Solution, weight: &[f64]) -> Self {
        Self {
            status: solution.status,
            gap: solution
                .slack
                .iter()
                .zip(weight)
                .map(|(g, w)| g / w)
                .collect(),
            pressure: solution.pressure,
            motion: solution.motion,
            iterations: solution.iterations,
            residual: solution.residual,
            by_lemke: solution.by_lemke,
            unstable: solution.determinant_sign < 0.0,
        }
    }
}

/// Gaps and balances of a [`SlidingContact`] as a complementarity problem has them.
struct Conditions {
    offset: Vec<f64>,
    closing: Vec<f64>,
    balance: Vec<f64>,
    target: Vec<f64>,
}

impl Conditions {
    fn border(&self) -> Option<Border<'_>> {
        (!self.target.is_empty()).then_some(Border {
            motion: &self.closing,
            balance: &self.balance,
            target: &self.target,
        })
    }
}

impl SlidingContact<'_> {
    /// Solves with the n x n row-major influence `matrix` of the pair, friction included.
    pub(crate) fn solve_with(
        &self,
        mut matrix: Vec<f64>,
        symmetric: bool,
        start: Option<Vec<bool>>,
        kept: Option<&Arc<KeptFactor>>,
        monitor: Monitor<'_>,
    ) -> Result<SlidingSolution, Error> {
        let n = self.gap.len();
        // equal areas keep the symmetry of the matrix itself; otherwise each row carries its weight
        let uniform = self.area.iter().all(|a| *a == self.area[0]);
        let weight: Vec<f64> = if uniform {
            vec![1.0; n]
        } else {
            self.area.to_vec()
        };
        if !uniform {
            for (row, w) in matrix.chunks_exact_mut(n).zip(&weight) {
                for a in row {
                    *a *= w;
                }
            }
        }
        let conditions = self.weighted(&weight);
        let problem = Problem {
            matrix: &matrix,
            offset: &conditions.offset,
            border: conditions.border(),
            symmetric,
            limit: self.limit(),
        };
        let options = Options {
            start,
            kept: kept.cloned(),
        };
        let solution = solve(&problem, &options, monitor)?;
        Ok(SlidingSolution::from(solution, &weight))
    }

    /// Solves by products with the influence matrix of the pair, friction included; `diagonal` is that of a point,
    /// `near_inverse` about the inverse without friction.
    fn solve_by_products(
        &self,
        multiply: &(dyn Fn(&[f64], &mut [f64]) + Sync),
        diagonal: f64,
        near_inverse: Option<&Map>,
        start: Option<&[bool]>,
        monitor: Monitor<'_>,
    ) -> Result<SlidingSolution, Error> {
        let n = self.gap.len();
        let weight = vec![1.0; n];
        let conditions = self.weighted(&weight);
        // a load on a small cell moves it less
        let mean = self.area.iter().sum::<f64>() / n as f64;
        let of_area = |area: &f64| diagonal * (area / mean).sqrt();
        let mut diagonal: Vec<f64> = self.area.iter().map(of_area).collect();
        if let Some(own) = self.diagonal {
            for (index, (all, own)) in diagonal.iter_mut().zip(own).enumerate() {
                check_own(index, *all, *own)?;
                *all += own;
            }
        }
        let problem = ByProducts {
            multiply,
            diagonal: &diagonal,
            near_inverse,
            offset: &conditions.offset,
            border: conditions.border(),
            limit: self.limit(),
        };
        let solution = solve_by_products(&problem, start, monitor)?;
        Ok(SlidingSolution::from(solution, &weight))
    }

    /// The conditions with each row times its weight.
    fn weighted(&self, weight: &[f64]) -> Conditions {
        let n = self.gap.len();
        let m = self.motions.len();
        let mut found = Conditions {
            offset: self.gap.iter().zip(weight).map(|(g, w)| g * w).collect(),
            closing: Vec::with_capacity(n * m),
            balance: Vec::with_capacity(n * m),
            target: Vec::with_capacity(m),
        };
        for motion in self.motions {
            let closing = motion.opening.iter().zip(weight).map(|(o, w)| -o * w);
            found.closing.extend(closing);
            let work = (0..n).map(|i| -self.work_of_pressure(motion, i));
            found.balance.extend(work);
            found.target.push(motion.work);
        }
        found
    }

    /// Largest pressures (n) [Pa].
    pub(crate) fn limit(&self) -> Option<&[f64]> {
        self.interface.and_then(|i| i.limit.as_deref())
    }

    /// Pressure [Pa] that carries the load of some motion, the same at all points; zeros where none is loaded.
    pub(crate) fn mean_pressure(&self) -> Vec<f64> {
        let means = self.motions.iter().filter_map(|motion| {
            let parts = motion.opening.iter().zip(self.area);
            let lever: f64 = parts.map(|(o, a)| (o * a).abs()).sum();
            (lever > 0.0).then_some(motion.work.abs() / lever)
        });
        vec![means.fold(0.0, f64::max); self.gap.len()]
    }

    /// Work of a unit pressure at `point`, with its friction, on a unit of `motion`.
    pub(crate) fn work_of_pressure(&self, motion: &RigidMotion, point: usize) -> f64 {
        let n = self.gap.len();
        let tangential = self.direction[point] * motion.tangential_x[point]
            + self.direction[n + point] * motion.tangential_y[point];
        self.area[point] * (motion.opening[point] + self.friction[point] * tangential)
    }

    pub(crate) fn check(&self, n: usize) -> Result<(), Error> {
        check("gap", self.gap, n)?;
        check("area", self.area, n)?;
        check("friction", self.friction, n)?;
        check("direction", self.direction, 2 * n)?;
        if let Some(index) = self.area.iter().position(|v| *v <= 0.0) {
            return Err(Error::NotPositive {
                name: "area",
                index,
                value: self.area[index],
            });
        }
        if let Some(index) = self.friction.iter().position(|v| *v < 0.0) {
            return Err(Error::Negative {
                name: "friction",
                index,
                value: self.friction[index],
            });
        }
        if let Some(diagonal) = self.diagonal {
            check("diagonal", diagonal, n)?;
        }
        if let Some(interface) = self.interface {
            interface.check(n)?;
        }
        for motion in self.motions {
            check("opening", &motion.opening, n)?;
            check("tangential_x", &motion.tangential_x, n)?;
            check("tangential_y", &motion.tangential_y, n)?;
            check("work", &[motion.work], 1)?;
        }
        Ok(())
    }
}

/// Memory [bytes] that the matrices of a sliding contact take, solves included: its blocks, their sum for a load,
/// and the active block or Lemke's table.
pub fn memory(points: usize, frictional: bool) -> f64 {
    let matrices = if frictional { 5.0 } else { 3.0 };
    8.0 * matrices * (points as f64).powi(2)
}

const AXES: [Component; 3] = [Component::X, Component::Y, Component::Normal];

/// Weights of tractions that amount to weights of displacements: the transpose of [`displacement`].
pub fn transposed(body: &dyn Compliance, weights: [&[f64]; 3]) -> [Vec<f64>; 3] {
    let n = body.points();
    let mut sums = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
    for (observed, weights) in AXES.into_iter().zip(weights) {
        if weights.iter().all(|w| *w == 0.0) {
            continue;
        }
        for (loaded, sums) in AXES.into_iter().zip(&mut sums) {
            body.add_transposed(observed, loaded, 1.0, weights, sums);
        }
    }
    sums
}

/// Displacement of a body's contact points under a traction field, both in its own frame
/// `(X, Y, into)`; components without traction cost nothing.
pub fn displacement(body: &dyn Compliance, traction: [&[f64]; 3]) -> [Vec<f64>; 3] {
    let n = body.points();
    let mut field = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
    for (loaded, traction) in AXES.into_iter().zip(traction) {
        if traction.iter().all(|t| *t == 0.0) {
            continue;
        }
        for (observed, field) in AXES.into_iter().zip(&mut field) {
            body.add_displacement(observed, loaded, 1.0, traction, field);
        }
    }
    field
}
