// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stick and slip with a pressure that follows: normal and tangential contact solved as one.
//!
//! Unknowns at `n` points are the tractions on the lower body along both tangents, the pressures
//! `u = (q_x, q_y, p)` [Pa], and the amplitudes `a` of the rigid motions that supports leave free. The
//! relative displacement `u_lower - u_upper` along the tangents and the gap are
//!
//! ```text
//! v = C u + sum_k a_k m_k + v_0,
//! ```
//!
//! with all nine blocks of the compliance `C` of both bodies together. When the upper body is pushed from
//! one state to the next, `v_0` holds the push and what went before, so that tangentially `v` is minus
//! the slip `s` of the upper body over the lower one. The conditions are [Kalker1990, ch. 4]
//!
//! ```text
//! contact:  p >= 0,  v_n >= 0,  p v_n = 0
//! friction: |q| <= mu p,  and  q = mu p s / |s|  where the point slips
//! balance:  sum_i A_i (q_i m_ki,t + p_i m_ki,n) + W_k = 0  for each motion k.
//! ```
//!
//! With fixed stiffnesses `k_t` and `k_n` they read `p = max(0, p - k_n v_n)`, and `q` is the vector
//! `z = q - k_t v_t` shortened to `mu p`: equations without inequalities, whose semismooth Newton steps are
//! dense linear systems over the points in contact.
//!
//! The slip of a push is taken from its beginning to its end, as in an implicit Euler step, while the
//! direction of the slip turns on the way. The error of that is of first order in the length of the pushes.
//! A push is therefore reached in parts, twice as many of them until the tractions no longer change
//! ([`CoupledContact::follow`]).

mod continuation;
mod factor;
mod held;
mod inverse;
mod matrix;
mod mirrored;
mod newton;
mod pulled;
mod tangent;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat};
use mtb_operator::{Compliance, Monitor};

use crate::error::{Error, check, check_positive};
use crate::sliding::{RigidMotion, check_own};
pub use held::{Held, HeldState};
pub use inverse::{Inverse, KeptInverse};
use matrix::threads;
pub use matrix::{CoupledMatrix, OnDemand};
pub use pulled::StickPulling;
pub use tangent::{StickFound, StickGiven, StickSlip};

/// Parts in which a push is reached at most.
pub const PARTS: usize = 64;

/// Parts in which a push is reached at most to keep the error of its path small.
pub const PATH_PARTS: usize = 256;

/// What each push of a path may add to its [`CoupledState::path_error`].
pub const PATH_TOLERANCE: f64 = 1e-3;

/// Factor between the changes by two doublings of the parts while they are too long to tell of their order.
const LEAST_DECAY: f64 = 0.9;

/// Size of a motion, relative to all of them, that counts as none.
const NO_MOTION: f64 = 1e-9;

/// Two bodies in contact with friction, as [`CoupledContact::new`] takes them.
pub struct Coupled<'a> {
    /// Both bodies together: displacement of the lower one relative to the upper one by a traction on the
    /// lower one; see [`Relative`](mtb_operator::Relative).
    pub compliance: &'a dyn Compliance,
    /// Tangential displacement by a unit traction [m/Pa] of a layer between the bodies; 0: none.
    pub layer: f64,
    /// Area that belongs to each point (n) [m2].
    pub area: &'a [f64],
    /// Friction coefficient at each point (n).
    pub friction: &'a [f64],
    /// Gap before contact and before any push (n) [m].
    pub gap: &'a [f64],
    /// Rigid motions that supports leave free.
    pub motions: &'a [RigidMotion],
}

/// What is given to two bodies for one load, as [`CoupledContact::of`] takes it.
pub struct CoupledLoad<'a> {
    /// Area that belongs to each point (n) [m2].
    pub area: &'a [f64],
    /// Friction coefficient at each point (n).
    pub friction: &'a [f64],
    /// Gap before contact and before any push (n) [m].
    pub gap: &'a [f64],
    /// Rigid motions that supports leave free.
    pub motions: &'a [RigidMotion],
    /// Diagonal compliance along the normal (n) [m/Pa] besides that of the bodies; `None`: none.
    pub diagonal: Option<&'a [f64]>,
}

/// Stick and slip of two bodies whose pressure follows; see the [module](self).
pub struct CoupledContact {
    matrix: Arc<CoupledMatrix>,
    /// (n) [m/Pa] along the normal; empty for none.
    diagonal: Vec<f64>,
    /// (3n, m): only those kept.
    motions: Mat<f64>,
    /// Work on those kept (m) [J].
    work: Vec<f64>,
    /// Sum of area times size of each motion kept.
    reach: Vec<f64>,
    /// Amplitude of each motion kept that moves its points on average as far as 1 Pa does: in this unit no column of
    /// a linear system hides the others.
    units: Vec<f64>,
    /// Share of each motion kept in each given one (given, m).
    shares: Mat<f64>,
    area: Vec<f64>,
    friction: Vec<f64>,
    gap: Vec<f64>,
    tolerance: f64,
}

/// What a point does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointState {
    /// Out of contact.
    Open,
    /// In contact, without slip.
    Stick,
    /// In contact, with slip.
    Slip,
}

/// A state of the contact.
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledState {
    /// Tractions along both tangents on the lower body, then pressures (3n) [Pa].
    pub traction: Vec<f64>,
    /// Amplitudes of the motions; of motions that move both bodies alike a combination.
    pub motion: Vec<f64>,
    /// Push of the upper body along both tangents and the normal (3n) [m] that led here.
    pub push: Vec<f64>,
    /// Displacement by `traction` and `motion` (3n) [m], from which a further push counts.
    pub displacement: Vec<f64>,
    /// What each point does (n).
    pub points: Vec<PointState>,
    /// Newton steps of all parts of the push.
    pub iterations: usize,
    /// Estimated error by the finite pushes of the path up to here, as if the errors of all of them added up: of
    /// the tangential tractions as a share of the friction that all points can bear, or of the pressures as a
    /// share of the pressure of all points, whichever is larger. Infinite where there is no estimate.
    pub path_error: f64,
    /// Residual over the norm of the pressure.
    pub residual: f64,
    /// The displacement (3n) [m] by `traction` and `motion`, where `displacement` is another one and this is known.
    own: Option<Vec<f64>>,
}

impl CoupledState {
    /// A state of tractions (3n) [Pa] on `n` points, from whose `displacement` (3n) [m] further slip counts.
    pub(crate) fn before(traction: &[f64], displacement: Vec<f64>, n: usize) -> Self {
        Self {
            traction: traction.to_vec(),
            motion: Vec::new(),
            push: vec![0.0; 3 * n],
            displacement,
            points: vec![PointState::Open; n],
            iterations: 0,
            path_error: 0.0,
            residual: 0.0,
            own: None,
        }
    }

    /// Pressure (n) [Pa].
    pub fn pressure(&self) -> &[f64] {
        &self.traction[2 * self.points.len()..]
    }
}

impl CoupledContact {
    /// Forms all blocks of the compliance.
    ///
    /// Of motions that move both bodies alike, such as two bodies that guides press together, fewer are
    /// kept. A state is solved when its residual is at most `tolerance` of the norm of its pressure.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, areas that are not positive, negative friction, more
    /// points than the memory holds, [`Error::Interrupted`].
    pub fn new(contact: &Coupled<'_>, tolerance: f64, monitor: Monitor<'_>) -> Result<Self, Error> {
        let load = CoupledLoad {
            area: contact.area,
            friction: contact.friction,
            gap: contact.gap,
            motions: contact.motions,
            diagonal: None,
        };
        load.check(contact.compliance.points())?;
        let matrix = CoupledMatrix::new(contact.compliance, contact.layer, monitor)?;
        Self::of(Arc::new(matrix), &load, tolerance)
    }

    /// The same with blocks that are formed already.
    ///
    /// # Errors
    /// As [`CoupledContact::new`]; a diagonal compliance so far below zero that a point snaps shut.
    pub fn of(
        matrix: Arc<CoupledMatrix>,
        contact: &CoupledLoad<'_>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        Self::with_shares(matrix, contact, tolerance, independent)
    }

    /// The same, with [`independent`] as it is `kept` from step to step.
    ///
    /// # Errors
    /// As [`CoupledContact::of`].
    pub(crate) fn again(
        matrix: Arc<CoupledMatrix>,
        contact: &CoupledLoad<'_>,
        tolerance: f64,
        kept: &mut KeptInverse,
    ) -> Result<Self, Error> {
        Self::with_shares(matrix, contact, tolerance, |given| kept.shares(given))
    }

    fn with_shares(
        matrix: Arc<CoupledMatrix>,
        contact: &CoupledLoad<'_>,
        tolerance: f64,
        shares_of: impl FnOnce(&Mat<f64>) -> Result<Mat<f64>, Error>,
    ) -> Result<Self, Error> {
        let n = matrix.points();
        contact.check(n)?;
        check_positive("tolerance", tolerance)?;
        let diagonal = contact.diagonal.unwrap_or(&[]);
        for (i, own) in diagonal.iter().enumerate() {
            let place = 2 * n + i;
            check_own(i, matrix.compliance[(place, place)], *own)?;
        }
        let given = Mat::from_fn(3 * n, contact.motions.len(), |i, k| {
            let motion = &contact.motions[k];
            match i / n {
                0 => motion.tangential_x[i],
                1 => motion.tangential_y[i - n],
                _ => motion.opening[i - 2 * n],
            }
        });
        let shares = shares_of(&given)?;
        let mut motions = Mat::zeros(given.nrows(), shares.ncols());
        let shared = threads(given.nrows() * given.ncols());
        matmul(
            motions.as_mut(),
            Accum::Replace,
            &given,
            &shares,
            1.0,
            shared,
        );
        let work: Vec<f64> = (0..shares.ncols())
            .map(|k| {
                let given = contact.motions.iter().enumerate();
                given.map(|(g, m)| shares[(g, k)] * m.work).sum()
            })
            .collect();
        let reach: Vec<f64> = (0..motions.ncols())
            .map(|k| {
                let size = (0..3 * n).map(|i| motions[(i, k)].abs() * contact.area[i % n]);
                size.sum::<f64>().max(f64::MIN_POSITIVE)
            })
            .collect();
        let whole: f64 = contact.area.iter().sum();
        let units = reach
            .iter()
            .map(|reach| whole / (matrix.stiffness[0] * reach))
            .collect();
        Ok(Self {
            matrix,
            diagonal: diagonal.to_vec(),
            motions,
            work,
            reach,
            units,
            shares,
            area: contact.area.to_vec(),
            friction: contact.friction.to_vec(),
            gap: contact.gap.to_vec(),
            tolerance,
        })
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.area.len()
    }

    /// The bodies pressed together without friction, from where tangential displacements count: its
    /// pressure (n) [Pa] and the amplitudes of the motions given.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn at_rest(&self, pressure: &[f64], motion: &[f64]) -> Result<CoupledState, Error> {
        let n = self.points();
        check("pressure", pressure, n)?;
        check("motion", motion, self.shares.nrows())?;
        let mut traction = vec![0.0; 2 * n];
        traction.extend_from_slice(pressure);
        let kept = self.kept(motion);
        let displacement = self.displacement(&traction, &kept);
        let points = pressure
            .iter()
            .map(|p| {
                if *p > 0.0 {
                    PointState::Stick
                } else {
                    PointState::Open
                }
            })
            .collect();
        Ok(CoupledState {
            traction,
            motion: kept,
            push: vec![0.0; 3 * n],
            displacement,
            points,
            iterations: 0,
            path_error: 0.0,
            residual: 0.0,
            own: None,
        })
    }

    /// A state with the tractions (3n) [Pa] of a step before and the displacement (3n) [m] of the bodies by them, and the
    /// amplitudes of the motions given; zeros where there were others. From which displacement slip counts is not
    /// known yet.
    pub(crate) fn state_before(
        &self,
        traction: &[f64],
        elastic: &[f64],
        motion: &[f64],
    ) -> CoupledState {
        let n = self.points();
        let motion = if motion.len() == self.shares.nrows() {
            self.kept(motion)
        } else {
            vec![0.0; self.shares.ncols()]
        };
        let mut own = elastic.to_vec();
        self.add_own(1.0, traction, &motion, &mut own);
        CoupledState {
            traction: traction.to_vec(),
            motion,
            own: Some(own),
            push: vec![0.0; 3 * n],
            displacement: vec![0.0; 3 * n],
            points: vec![PointState::Open; n],
            iterations: 0,
            path_error: 0.0,
            residual: 0.0,
        }
    }

    /// Amplitudes of the motions kept, by those of the motions given.
    fn kept(&self, motion: &[f64]) -> Vec<f64> {
        (0..self.shares.ncols())
            .map(|k| {
                let given = motion.iter().enumerate();
                given.map(|(g, a)| a * self.shares[(g, k)]).sum()
            })
            .collect()
    }

    /// The states after the upper body was pushed from `state` to each of `pushes` (3n) [m] in turn, as
    /// [`CoupledContact::advance`] takes them. They end where no state was found.
    ///
    /// Each push is reached in parts, twice as many of them until the error that it adds is estimated to be at
    /// most `tolerance`, in the measure of [`CoupledState::path_error`]; see [`path_error`]. Where [`PATH_PARTS`]
    /// parts do not suffice, it is larger than that.
    ///
    /// # Errors
    /// As [`CoupledContact::advance`].
    pub fn follow(
        &self,
        state: &CoupledState,
        pushes: &[Vec<f64>],
        tolerance: f64,
        monitor: Monitor<'_>,
    ) -> Result<Vec<CoupledState>, Error> {
        let mut path: Vec<CoupledState> = Vec::new();
        for push in pushes {
            let from = path.last().unwrap_or(state);
            let advance = |parts| self.advance(from, push, parts, monitor);
            let Some((mut found, error)) = refined(tolerance, advance, |a, b| self.change(a, b))?
            else {
                break;
            };
            found.path_error = from.path_error + error;
            path.push(found);
        }
        Ok(path)
    }

    /// The state after the upper body was pushed from `state` to `push` (3n) [m], along the tangents and the
    /// normal of each point, in `parts` equal parts or, where these do not reach it, in 2, 4, ... times as many;
    /// `None` if no state was found, not even in [`PARTS`] parts.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, [`Error::Interrupted`].
    pub fn advance(
        &self,
        state: &CoupledState,
        push: &[f64],
        parts: usize,
        monitor: Monitor<'_>,
    ) -> Result<Option<CoupledState>, Error> {
        let n = self.points();
        check("push", push, 3 * n)?;
        for (name, values) in [
            ("traction", &state.traction),
            ("displacement", &state.displacement),
            ("push of the state", &state.push),
        ] {
            check(name, values, 3 * n)?;
        }
        check("motion", &state.motion, self.work.len())?;
        let mut parts = parts.max(1);
        loop {
            let found = self.in_parts(state, push, parts, monitor)?;
            parts *= 2;
            if found.is_some() || parts > PARTS {
                return Ok(found);
            }
        }
    }

    /// As [`CoupledContact::advance`] in one part, by what is `kept` from step to step: an [`Inverse`] makes the steps
    /// quick whose points in contact it knows. Where the state is too far for Newton's method, it is reached over
    /// the states between.
    ///
    /// # Errors
    /// As [`CoupledContact::advance`].
    pub fn step(
        &self,
        state: &CoupledState,
        push: &[f64],
        kept: &mut KeptInverse,
        monitor: Monitor<'_>,
    ) -> Result<Option<CoupledState>, Error> {
        match self.at_once(state, push, kept, monitor)? {
            Some(found) => Ok(Some(found)),
            None => self.reach(state, push, kept, monitor),
        }
    }

    /// The same where Newton's method finds the state from this one; `None` elsewhere.
    pub(crate) fn at_once(
        &self,
        state: &CoupledState,
        push: &[f64],
        kept: &mut KeptInverse,
        monitor: Monitor<'_>,
    ) -> Result<Option<CoupledState>, Error> {
        let inverse = kept.for_contact(self, state.pressure(), monitor)?;
        let Some((found, served)) =
            newton::solve(self, state, push, inverse, newton::HIGHER, monitor)?
        else {
            return Ok(None);
        };
        if !served {
            kept.miss(&found.points);
        }
        Ok(Some(found))
    }

    /// The state at `push`, reached in so many equal parts; `None` if no state was found on the way.
    fn in_parts(
        &self,
        state: &CoupledState,
        push: &[f64],
        parts: usize,
        monitor: Monitor<'_>,
    ) -> Result<Option<CoupledState>, Error> {
        let mut reached = state.clone();
        let mut iterations = 0;
        for part in 1..=parts {
            let share = part as f64 / parts as f64;
            let ways = state.push.iter().zip(push);
            let aim: Vec<f64> = ways.map(|(a, b)| a + share * (b - a)).collect();
            // a body that jams is far uphill
            match newton::solve(self, &reached, &aim, None, f64::INFINITY, monitor)? {
                Some((next, _)) => reached = next,
                None => return Ok(None),
            }
            iterations += reached.iterations;
        }
        Ok(Some(CoupledState {
            iterations,
            ..reached
        }))
    }

    /// By how much two states differ: the tangential tractions as a share of the friction that all points can
    /// bear, and the pressures as a share of the pressure of all points; the larger of the two.
    fn change(&self, one: &CoupledState, other: &CoupledState) -> f64 {
        let n = self.points();
        let [mut tangential, mut normal, mut bound, mut pressed] = [0.0; 4];
        for (i, area) in self.area.iter().enumerate() {
            let [x, y, p] = [0, 1, 2].map(|c| one.traction[c * n + i] - other.traction[c * n + i]);
            tangential += area * x.hypot(y);
            normal += area * p.abs();
            pressed += area * other.traction[2 * n + i];
            bound += area * self.friction[i] * other.traction[2 * n + i];
        }
        let share = |of: f64, whole: f64| if of > 0.0 { of / whole } else { 0.0 };
        // without friction tractions are rounding
        let dragged = if bound > 0.0 { tangential } else { 0.0 };
        share(dragged, bound).max(share(normal, pressed))
    }

    /// Gap (n) [m] in a state.
    pub fn gap(&self, state: &CoupledState) -> Vec<f64> {
        let at = 2 * self.points();
        let moved = state.displacement[at..].iter().zip(&state.push[at..]);
        let gaps = self.gap.iter().zip(moved);
        gaps.map(|(gap, (v, push))| gap + v + push).collect()
    }

    /// Amplitudes of the motions given in a state; of motions that move both bodies alike the least ones.
    pub fn amplitudes(&self, state: &CoupledState) -> Vec<f64> {
        let kept = faer::ColRef::from_slice(&state.motion);
        (&self.shares * kept).iter().copied().collect()
    }

    /// Displacement (3n) [m] by tractions and motions.
    fn displacement(&self, traction: &[f64], motion: &[f64]) -> Vec<f64> {
        let mut moved = self.matrix.displacement(traction);
        self.add_own(1.0, traction, motion, &mut moved);
        moved
    }

    /// Displacement (3n) [m] of the bodies alone in a state.
    pub(crate) fn elastic(&self, state: &CoupledState) -> Vec<f64> {
        let mut moved = state.displacement.clone();
        self.add_own(-1.0, &state.traction, &state.motion, &mut moved);
        moved
    }

    /// Adds so much of the displacement (3n) [m] by motions and the diagonal.
    fn add_own(&self, share: f64, traction: &[f64], motion: &[f64], moved: &mut [f64]) {
        for (k, amount) in motion.iter().enumerate() {
            for (v, m) in moved.iter_mut().zip(self.motions.col_as_slice(k)) {
                *v += share * amount * m;
            }
        }
        let at = 2 * self.points();
        let pressed = moved[at..].iter_mut().zip(&traction[at..]);
        for ((v, p), own) in pressed.zip(&self.diagonal) {
            *v += share * own * p;
        }
    }
}

impl CoupledLoad<'_> {
    fn check(&self, n: usize) -> Result<(), Error> {
        check("area", self.area, n)?;
        check("friction", self.friction, n)?;
        check("gap", self.gap, n)?;
        if let Some(diagonal) = self.diagonal {
            check("diagonal", diagonal, n)?;
        }
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
        for motion in self.motions {
            check("opening", &motion.opening, n)?;
            check("tangential_x", &motion.tangential_x, n)?;
            check("tangential_y", &motion.tangential_y, n)?;
            check("work", &[motion.work], 1)?;
        }
        Ok(())
    }
}

/// The state at the end of a push that is reached in parts, twice as many of them until the estimated error is at most
/// `tolerance`, and this error; `None` if none was found. `advance` takes the push in so many parts.
fn refined<S>(
    tolerance: f64,
    advance: impl Fn(usize) -> Result<Option<S>, Error>,
    change: impl Fn(&S, &S) -> f64,
) -> Result<Option<(S, f64)>, Error> {
    let Some(mut found) = advance(1)? else {
        return Ok(None);
    };
    let (mut parts, mut before, mut error) = (1, None, f64::INFINITY);
    while error > tolerance && parts < PATH_PARTS {
        parts *= 2;
        let Some(finer) = advance(parts)? else {
            break;
        };
        let changed = change(&found, &finer);
        error = path_error(changed, before);
        before = Some(changed);
        found = finer;
    }
    Ok(Some((found, error)))
}

/// What a doubling of the parts of a push leaves of their error, after it changed the state by `change` and the
/// doubling before it by `before`.
///
/// It is the sum of all further changes if these go on to shrink by the same factor. That factor is one half
/// once the parts are short, because the method is of first order.
pub fn path_error(change: f64, before: Option<f64>) -> f64 {
    if change == 0.0 {
        return 0.0;
    }
    let left = match before {
        Some(before) if change < LEAST_DECAY * before => change / before,
        _ => LEAST_DECAY,
    };
    change * (left / (1.0 - left)).max(1.0)
}

/// Memory [bytes] that the matrix of a coupled contact takes, with one block of it and the system of a step, or its
/// inverse, which is kept in single precision too; where there is one mirror, both of them by its two parities.
pub fn memory(points: usize) -> f64 {
    8.0 * 30.25 * (points as f64).powi(2)
}

/// Combinations (given, kept) of the columns of `motions` that are independent: all of them, or their
/// principal directions.
fn independent(motions: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let given = motions.ncols();
    let all = Mat::identity(given, given);
    if given < 2 {
        return Ok(all);
    }
    let principal = |matrix: Mat<f64>| {
        matrix.thin_svd().map_err(|_| Error::Overflow {
            name: "size of a motion",
            value: motions.norm_max(),
        })
    };
    let sizes: Vec<f64> = (0..given).map(|k| motions.col(k).norm_l2()).collect();
    let unit = Mat::from_fn(motions.nrows(), given, |i, k| {
        motions[(i, k)] / sizes[k].max(f64::MIN_POSITIVE)
    });
    let smallest = principal(unit)?.S().column_vector()[given - 1];
    if smallest > NO_MOTION {
        return Ok(all);
    }
    let found = principal(motions.clone())?;
    let values = found.S().column_vector();
    let kept = (0..given).take_while(|&k| values[k] > NO_MOTION * values[0]);
    Ok(found.V().get(.., ..kept.count()).to_owned())
}
