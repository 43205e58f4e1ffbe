// SPDX-License-Identifier: MIT OR Apache-2.0
//! A state of stick and slip with its pressure, linearised.
//!
//! With the points in contact, in stick and in slip held, small changes of tractions, pressures and motions follow small
//! changes of what is given by linear equations. Let `w` be the displacement `v` along the tangents that would let no point
//! slip, so that the slip is `s = w - v`. Then `dv = dw` where a point sticks; where it slips, `q = mu p s / |s|` gives
//!
//! ```text
//! dq - mu dp e - mu p / |s| (1 - e e') (dw - dv) = p e dmu,   e = s / |s|.
//! ```
//!
//! Gaps stay closed and loads balanced. One matrix serves both ways: its transpose gives the gradient of a number.

use std::sync::{Arc, OnceLock};

use faer::Mat;
use faer::linalg::solvers::{PartialPivLu, Solve};

use super::{CoupledContact, PointState, StickPulling};
use crate::error::{Error, check};

/// Of what is given to a step of stick and slip: small changes, or the gradient by it.
#[derive(Clone, Debug, PartialEq)]
pub struct StickGiven {
    /// Gap before contact (n) [m].
    pub gap: Vec<f64>,
    /// Work of the loads on each motion (m) [J].
    pub work: Vec<f64>,
    /// Displacement `u_lower - u_upper` along both tangents that would let no point slip (2n) [m]: the shift and what the
    /// last step left, less `placed`.
    pub wanted: Vec<f64>,
    /// That by pose and loads (2n) [m], where the rigid displacement is asked for.
    pub placed: Vec<f64>,
    /// Friction coefficient (n).
    pub friction: Vec<f64>,
    /// Pull of a magnet that follows the gap, with all gaps held (n) [Pa]; empty for none.
    pub pull: Vec<f64>,
}

/// Of what is found: small changes, or weights of a sum.
#[derive(Clone, Debug, PartialEq)]
pub struct StickFound {
    /// Tractions along both tangents on the lower body, then pressures (3n) [Pa].
    pub traction: Vec<f64>,
    /// Deformed gap (n) [m]; points in contact have none.
    pub gap: Vec<f64>,
    /// Amplitudes of the motions.
    pub motion: Vec<f64>,
    /// Slip (2n) [m]; points that stick have none.
    pub slip: Vec<f64>,
    /// Displacement `u_lower - u_upper` along both tangents by rigid motions, pose and loads (2n) [m].
    pub rigid: Vec<f64>,
    /// Pull of a magnet that follows the gap (n) [Pa]; empty for none.
    pub pull: Vec<f64>,
}

impl StickGiven {
    /// Nothing, of `points` and `motions`.
    pub fn nothing(points: usize, motions: usize) -> Self {
        Self {
            gap: vec![0.0; points],
            work: vec![0.0; motions],
            wanted: vec![0.0; 2 * points],
            placed: vec![0.0; 2 * points],
            friction: vec![0.0; points],
            pull: Vec::new(),
        }
    }

    fn check(&self, points: usize, motions: usize) -> Result<(), Error> {
        check("gap", &self.gap, points)?;
        check("work", &self.work, motions)?;
        check("wanted", &self.wanted, 2 * points)?;
        check("placed", &self.placed, 2 * points)?;
        check("friction", &self.friction, points)?;
        check(
            "pull",
            &self.pull,
            if self.pull.is_empty() { 0 } else { points },
        )
    }
}

/// What a point in contact does, with what its equations need.
#[derive(Clone, Copy, Debug)]
enum Grip {
    Stick,
    /// Direction of the slip, and `mu p / |s|` [Pa/m].
    Slip([f64; 2], f64),
}

/// The equations of a state of stick and slip, linearised about it.
pub struct StickSlip {
    contact: CoupledContact,
    pressure: Vec<f64>,
    /// Points in contact, and what each of them does.
    closed: Vec<usize>,
    grips: Vec<Grip>,
    /// Whether each point slips, or is open: its slip may change.
    moves: Vec<bool>,
    factors: OnceLock<Option<Arc<PartialPivLu<f64>>>>,
    pub(super) pulling: Option<StickPulling>,
}

impl StickSlip {
    /// About the state with these pressures (n) [Pa], slips (2n) [m] and points.
    pub(crate) fn new(
        contact: CoupledContact,
        pressure: &[f64],
        slip: &[f64],
        points: &[PointState],
    ) -> Self {
        let n = contact.points();
        let closed: Vec<usize> = (0..n).filter(|&i| pressure[i] > 0.0).collect();
        let grip = |&i: &usize| {
            let [x, y] = [slip[i], slip[n + i]];
            let size = x.hypot(y);
            let bound = contact.friction[i] * pressure[i];
            match points[i] {
                PointState::Stick => Grip::Stick,
                _ if size > 0.0 => Grip::Slip([x / size, y / size], bound / size),
                _ => Grip::Slip([0.0; 2], 0.0),
            }
        };
        Self {
            grips: closed.iter().map(grip).collect(),
            moves: points.iter().map(|p| *p != PointState::Stick).collect(),
            closed,
            pressure: pressure.to_vec(),
            contact,
            factors: OnceLock::new(),
            pulling: None,
        }
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.contact.points()
    }

    /// Pressures (n) [Pa] of the state.
    pub(crate) fn pressure(&self) -> &[f64] {
        &self.pressure
    }

    /// Number of the motions given.
    pub fn motions(&self) -> usize {
        self.contact.shares.nrows()
    }

    /// What a unit of pressure moves along the tangents [m/Pa]: by it equations are made alike.
    fn unit(&self) -> f64 {
        1.0 / self.contact.matrix.stiffness[0]
    }

    /// What makes the equations of slip as large as those of stick.
    fn scale(&self, rate: f64) -> f64 {
        1.0 / (1.0 + rate * self.unit())
    }

    /// The matrix in units of pressure: rows of both tangents, of the normal, and of the motions kept; columns likewise.
    fn matrix(&self) -> Mat<f64> {
        let (n, k, m) = (self.points(), self.closed.len(), self.contact.work.len());
        let (unit, compliance) = (self.unit(), &self.contact.matrix.compliance);
        let motions = &self.contact.motions;
        let place = |a: usize| (a / k.max(1)) * n + self.closed[a % k.max(1)];
        // displacement of a row by an unknown, over the unit
        let moved = |row: usize, column: usize| -> f64 {
            if column < 3 * k {
                compliance[(row, place(column))] / unit
            } else {
                motions[(row, column - 3 * k)] * self.contact.units[column - 3 * k] / unit
            }
        };
        let mut matrix = Mat::zeros(3 * k + m, 3 * k + m);
        for column in 0..3 * k + m {
            for (a, (&i, grip)) in self.closed.iter().zip(&self.grips).enumerate() {
                let along = [i, n + i].map(|row| moved(row, column));
                match *grip {
                    Grip::Stick => {
                        matrix[(a, column)] = along[0];
                        matrix[(k + a, column)] = along[1];
                    }
                    Grip::Slip(e, rate) => {
                        let scale = self.scale(rate);
                        let radial = e[0] * along[0] + e[1] * along[1];
                        for c in 0..2 {
                            let mut value = rate * unit * (along[c] - radial * e[c]);
                            if column == c * k + a {
                                value += 1.0;
                            }
                            if column == 2 * k + a {
                                value -= self.contact.friction[i] * e[c];
                            }
                            matrix[(c * k + a, column)] = scale * value;
                        }
                    }
                }
                let own = if column == 2 * k + a {
                    self.contact.diagonal.get(i).copied().unwrap_or(0.0) / unit
                } else {
                    0.0
                };
                matrix[(2 * k + a, column)] = moved(2 * n + i, column) + own;
            }
            if column < 3 * k {
                let row = place(column);
                for motion in 0..m {
                    matrix[(3 * k + motion, column)] = self.contact.area[row % n]
                        * motions[(row, motion)]
                        / self.contact.reach[motion];
                }
            }
        }
        matrix
    }

    fn factors(&self) -> Result<&PartialPivLu<f64>, Error> {
        let made = self.factors.get_or_init(|| {
            // two bodies that part leave nothing to balance a load
            let enough = 3 * self.closed.len() >= self.contact.work.len();
            enough.then(|| Arc::new(self.matrix().partial_piv_lu()))
        });
        made.as_deref().ok_or(Error::Singular)
    }

    fn solved(&self, rhs: &Mat<f64>, transposed: bool) -> Result<Mat<f64>, Error> {
        if rhs.nrows() == 0 {
            return Ok(rhs.clone());
        }
        let factors = self.factors()?;
        let found = if transposed {
            factors.solve_transpose(rhs)
        } else {
            factors.solve(rhs)
        };
        let is_finite =
            (0..found.ncols()).all(|j| found.col_as_slice(j).iter().all(|v| v.is_finite()));
        if is_finite {
            Ok(found)
        } else {
            Err(Error::Singular)
        }
    }

    /// What follows small changes of what is given, with the pull of a magnet held: one answer for each.
    pub(super) fn forward_held(&self, changes: &[StickGiven]) -> Result<Vec<StickFound>, Error> {
        let (n, k, m) = (self.points(), self.closed.len(), self.contact.work.len());
        let unit = self.unit();
        let mut rhs = Mat::zeros(3 * k + m, changes.len());
        for (j, change) in changes.iter().enumerate() {
            change.check(n, self.motions())?;
            for (a, (&i, grip)) in self.closed.iter().zip(&self.grips).enumerate() {
                let w = [change.wanted[i], change.wanted[n + i]];
                match *grip {
                    Grip::Stick => {
                        rhs[(a, j)] = w[0] / unit;
                        rhs[(k + a, j)] = w[1] / unit;
                    }
                    Grip::Slip(e, rate) => {
                        let scale = self.scale(rate);
                        let radial = e[0] * w[0] + e[1] * w[1];
                        let more = self.pressure[i] * change.friction[i];
                        for c in 0..2 {
                            rhs[(c * k + a, j)] =
                                scale * (rate * (w[c] - radial * e[c]) + more * e[c]);
                        }
                    }
                }
                rhs[(2 * k + a, j)] = -change.gap[i] / unit;
            }
            for motion in 0..m {
                let work: f64 = (0..self.motions())
                    .map(|g| self.contact.shares[(g, motion)] * change.work[g])
                    .sum();
                rhs[(3 * k + motion, j)] = -work / self.contact.reach[motion];
            }
        }
        let found = self.solved(&rhs, false)?;
        let answers = changes.iter().enumerate().map(|(j, change)| {
            let mut traction = vec![0.0; 3 * n];
            for (a, &i) in self.closed.iter().enumerate() {
                for c in 0..3 {
                    traction[c * n + i] = found[(c * k + a, j)];
                }
            }
            let kept: Vec<f64> = (0..m)
                .map(|motion| found[(3 * k + motion, j)] * self.contact.units[motion])
                .collect();
            let moved = self.contact.displacement(&traction, &kept);
            let mut rigid = change.placed.clone();
            for (motion, amount) in kept.iter().enumerate() {
                let along = &self.contact.motions.col_as_slice(motion)[..2 * n];
                for (rigid, along) in rigid.iter_mut().zip(along) {
                    *rigid += amount * along;
                }
            }
            let mut gap: Vec<f64> = (change.gap.iter().zip(&moved[2 * n..]))
                .map(|(g, v)| g + v)
                .collect();
            for &i in &self.closed {
                gap[i] = 0.0;
            }
            let slip = (0..2 * n).map(|row| {
                if self.moves[row % n] {
                    change.wanted[row] - moved[row]
                } else {
                    0.0
                }
            });
            let kept = faer::ColRef::from_slice(&kept);
            StickFound {
                slip: slip.collect(),
                motion: (&self.contact.shares * kept).iter().copied().collect(),
                traction,
                gap,
                rigid,
                pull: Vec::new(),
            }
        });
        Ok(answers.collect())
    }

    /// The gradients of sums of what is found with the weights `of`, with the pull of a magnet held: one for each.
    pub(super) fn adjoint_held(&self, of: &[StickFound]) -> Result<Vec<StickGiven>, Error> {
        let (n, k, m) = (self.points(), self.closed.len(), self.contact.work.len());
        let unit = self.unit();
        let mut rhs = Mat::zeros(3 * k + m, of.len());
        let mut gradients = Vec::with_capacity(of.len());
        for (j, weights) in of.iter().enumerate() {
            check("traction", &weights.traction, 3 * n)?;
            check("gap", &weights.gap, n)?;
            check("motion", &weights.motion, self.motions())?;
            check("slip", &weights.slip, 2 * n)?;
            check("rigid", &weights.rigid, 2 * n)?;
            let mut given = StickGiven::nothing(n, self.motions());
            given.placed.clone_from(&weights.rigid);
            for row in 0..2 * n {
                if self.moves[row % n] {
                    given.wanted[row] = weights.slip[row];
                }
            }
            given.gap.clone_from(&weights.gap);
            for &i in &self.closed {
                given.gap[i] = 0.0;
            }
            // as weights of displacements by tractions and motions
            let mut sides: Vec<f64> = given.wanted.iter().map(|w| -w).collect();
            sides.extend_from_slice(&given.gap);
            let back = self.transposed(&sides);
            for (a, &i) in self.closed.iter().enumerate() {
                for c in 0..3 {
                    rhs[(c * k + a, j)] = weights.traction[c * n + i] + back[c * n + i];
                }
            }
            for (row, weight) in weights.rigid.iter().enumerate() {
                sides[row] += weight;
            }
            for motion in 0..m {
                let own = self.contact.motions.col_as_slice(motion).iter();
                let mut sum: f64 = own.zip(&sides).map(|(a, b)| a * b).sum();
                for g in 0..self.motions() {
                    sum += self.contact.shares[(g, motion)] * weights.motion[g];
                }
                rhs[(3 * k + motion, j)] = sum * self.contact.units[motion];
            }
            gradients.push(given);
        }
        let found = self.solved(&rhs, true)?;
        for (j, given) in gradients.iter_mut().enumerate() {
            for (a, (&i, grip)) in self.closed.iter().zip(&self.grips).enumerate() {
                let by = [found[(a, j)], found[(k + a, j)]];
                match *grip {
                    Grip::Stick => {
                        given.wanted[i] += by[0] / unit;
                        given.wanted[n + i] += by[1] / unit;
                    }
                    Grip::Slip(e, rate) => {
                        let scale = self.scale(rate);
                        let radial = e[0] * by[0] + e[1] * by[1];
                        for c in 0..2 {
                            given.wanted[c * n + i] += scale * rate * (by[c] - radial * e[c]);
                        }
                        given.friction[i] = scale * self.pressure[i] * radial;
                    }
                }
                given.gap[i] = -found[(2 * k + a, j)] / unit;
            }
            for motion in 0..m {
                let by = -found[(3 * k + motion, j)] / self.contact.reach[motion];
                for g in 0..self.motions() {
                    given.work[g] += self.contact.shares[(g, motion)] * by;
                }
            }
        }
        Ok(gradients)
    }

    /// Displacement of the bodies (3n) [m] by tractions and pressures (3n) [Pa].
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite.
    pub fn left_by(&self, traction: &[f64]) -> Result<Vec<f64>, Error> {
        check("traction", traction, 3 * self.points())?;
        Ok(self.contact.matrix.displacement(traction))
    }

    /// The transposed map: weights (3n) of tractions and pressures that do what weights (2n) of displacements along the
    /// tangents do.
    ///
    /// # Errors
    /// As [`StickSlip::left_by`].
    pub fn leaving(&self, weights: &[f64]) -> Result<Vec<f64>, Error> {
        let n = self.points();
        check("weights", weights, 2 * n)?;
        let mut all = weights.to_vec();
        all.resize(3 * n, 0.0);
        Ok(self.transposed(&all))
    }

    /// `C' weights` (3n).
    fn transposed(&self, weights: &[f64]) -> Vec<f64> {
        if weights.iter().all(|w| *w == 0.0) {
            return vec![0.0; weights.len()];
        }
        let product =
            self.contact.matrix.compliance.transpose() * faer::ColRef::from_slice(weights);
        product.iter().copied().collect()
    }
}
