// SPDX-License-Identifier: MIT OR Apache-2.0
//! The thesis' staggered scheme: half-space contact, then finite elements, then contact again.
//!
//! Kept because it is the known remedy, and because where it fails is worth knowing. It counts the local compliance of
//! the elastic body twice, once as a half-space and once as finite elements; [`crate::sliding`] with the
//! body's own compliance does not, and needs no factor.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use faer::{Mat, c64};
use mtb_complementarity::linear::{Border, Options, Problem, Solution, Status, solve};
use mtb_operator::dense::Lu;
use mtb_operator::{Monitor, report};

use crate::anderson::Anderson;
use crate::columns::largest;
use crate::error::{Error, check};

/// The two maps between which the scheme goes to and fro, at n contact points.
#[derive(Clone, Copy, Debug)]
pub struct Staggered<'a> {
    /// Gap opened by a unit pressure, both bodies as half-spaces, friction included; n x n, row-major.
    pub half_spaces: &'a [f64],
    /// Gap opened by a unit pressure through the finite-element body, friction included; n x n.
    pub structure: &'a [f64],
    /// Gap of the unloaded pair (n) [m], attraction included.
    pub gap: &'a [f64],
    /// Weight of each point (n) [m2].
    pub area: &'a [f64],
    /// Free motions, their balance and its target, as in [`Border`]; lengths m n, m n, m.
    pub motion: &'a [f64],
    /// See [`Border::balance`].
    pub balance: &'a [f64],
    /// See [`Border::target`].
    pub target: &'a [f64],
}

/// The parameters of the scheme, thesis Table 2.1.
#[derive(Clone, Copy, Debug)]
pub struct StaggeredOptions {
    /// `f_FE`: the share 1/f of the finite-element displacement applied in each iteration; `None` takes
    /// [`best_factor`].
    pub factor: Option<f64>,
    /// Iterations at most (thesis: 20).
    pub max_iterations: usize,
    /// Largest change of a displacement, relative to the largest displacement, at which the scheme has converged.
    pub tolerance: f64,
    /// Earlier iterates that Anderson's acceleration combines; 0 for none [Walker2011].
    pub anderson_depth: usize,
}

/// How the scheme ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StaggeredStatus {
    /// The displacement changes by less than the tolerance.
    Converged,
    /// The iterations ran out.
    IterationLimit,
    /// The displacement grows without bound.
    Diverged,
    /// A contact problem on the way has no solution.
    NoSolution,
}

/// Where the scheme ended.
#[derive(Clone, Debug)]
pub struct StaggeredSolution {
    /// How it ended; only [`StaggeredStatus::Converged`] is a solution (of the scheme's own equations).
    pub status: StaggeredStatus,
    /// The last contact state.
    pub contact: Solution,
    /// Displacement of the structure in the gap (n) [m].
    pub displacement: Vec<f64>,
    /// The factor used.
    pub factor: f64,
    /// Relative change of the displacement, by iteration.
    pub history: Vec<f64>,
    /// Active sets of all contact problems.
    pub active_sets: usize,
}

/// Runs the staggered scheme `d <- d + (u(p(d)) - d) / f`.
///
/// # Errors
/// Wrong lengths, numbers that are not finite, a factor that is not positive, an interruption.
pub fn staggered(
    problem: &Staggered<'_>,
    options: &StaggeredOptions,
    monitor: Monitor<'_>,
) -> Result<StaggeredSolution, Error> {
    let n = problem.gap.len();
    check("half_spaces", problem.half_spaces, n * n)?;
    check("structure", problem.structure, n * n)?;
    check("area", problem.area, n)?;
    let mut displacement = vec![0.0; n];
    let mut start = None;
    let mut history = Vec::new();
    let mut active_sets = 0;
    let mut memory = Anderson::new(options.anderson_depth);
    let mut factor = options.factor;
    let mut first = None;
    loop {
        let contact = problem.contact(&displacement, start, monitor)?;
        active_sets += contact.iterations;
        if contact.status != Status::Solved {
            let factor = factor.unwrap_or(f64::NAN);
            let status = StaggeredStatus::NoSolution;
            return Ok(StaggeredSolution {
                status,
                contact,
                displacement,
                factor,
                history,
                active_sets,
            });
        }
        let factor = match factor {
            Some(f) if f.is_finite() && f > 0.0 => f,
            Some(value) => {
                return Err(Error::NotPositive {
                    name: "factor",
                    index: 0,
                    value,
                });
            }
            None => *factor.insert(best_factor(problem, &contact.pressure, monitor)?.0),
        };
        let response = times(problem.structure, &contact.pressure);
        let largest = response
            .iter()
            .chain(&displacement)
            .fold(0.0_f64, |m, u| m.max(u.abs()));
        let change = response
            .iter()
            .zip(&displacement)
            .fold(0.0_f64, |m, (u, d)| m.max((u - d).abs()));
        let relative = if largest > 0.0 { change / largest } else { 0.0 };
        history.push(relative);
        let initial = *first.get_or_insert(largest);
        let status = if relative <= options.tolerance {
            Some(StaggeredStatus::Converged)
        } else if !largest.is_finite() || largest > 1e6 * initial {
            Some(StaggeredStatus::Diverged)
        } else if history.len() >= options.max_iterations {
            Some(StaggeredStatus::IterationLimit)
        } else {
            None
        };
        if let Some(status) = status {
            return Ok(StaggeredSolution {
                status,
                contact,
                displacement,
                factor,
                history,
                active_sets,
            });
        }
        report(monitor, history.len(), relative)?;
        start = Some(contact.pressure.iter().map(|&p| p > 0.0).collect());
        let step: Vec<f64> = response
            .iter()
            .zip(&displacement)
            .map(|(u, d)| (u - d) / factor)
            .collect();
        displacement = memory.next(displacement, step);
    }
}

impl Staggered<'_> {
    fn contact(
        &self,
        displacement: &[f64],
        start: Option<Vec<bool>>,
        monitor: Monitor<'_>,
    ) -> Result<Solution, Error> {
        let offset: Vec<f64> = self
            .gap
            .iter()
            .zip(displacement)
            .map(|(g, d)| g + d)
            .collect();
        let border = (!self.target.is_empty()).then_some(Border {
            motion: self.motion,
            balance: self.balance,
            target: self.target,
        });
        let problem = Problem {
            matrix: self.half_spaces,
            offset: &offset,
            border,
            symmetric: false,
            limit: None,
        };
        Ok(solve(&problem, &Options { start, kept: None }, monitor)?)
    }
}

/// The factor with the fastest convergence, and the one below which the scheme diverges.
///
/// On the set in contact the iteration matrix is `I - (I + S^-1 T) / f`. With eigenvalues `l` of `S^-1 T` (the
/// motions and their balance eliminated) it converges if and only if
/// `f > max |1 + l|^2 / (2 Re(1 + l))`; for real `l` the best is the middle of the smallest and the largest `1 + l`.
///
/// # Errors
/// Wrong lengths, an interruption.
pub fn best_factor(
    problem: &Staggered<'_>,
    pressure: &[f64],
    monitor: Monitor<'_>,
) -> Result<(f64, f64), Error> {
    let n = problem.gap.len();
    if pressure.len() != n {
        return Err(Error::Shape {
            name: "pressure",
            expected: n,
            found: pressure.len(),
        });
    }
    let set: Vec<usize> = (0..n).filter(|&i| pressure[i] > 0.0).collect();
    let (k, m) = (set.len(), problem.target.len());
    if k <= m {
        return Ok((1.0, 0.5));
    }
    let bordered = Mat::from_fn(k + m, k + m, |i, j| match (i < k, j < k) {
        (true, true) => problem.half_spaces[set[i] * n + set[j]],
        (true, false) => -scaled(problem.motion, j - k, n, set[i]) * scale_of(problem, n),
        (false, true) => scaled(problem.balance, i - k, n, set[j]) * scale_of(problem, n),
        (false, false) => 0.0,
    });
    let rhs = Mat::from_fn(k + m, k, |i, j| {
        if i < k {
            problem.structure[set[i] * n + set[j]]
        } else {
            0.0
        }
    });
    let solved = Lu::new(bordered, faer::get_global_parallelism(), monitor)?.solve(
        rhs.as_ref(),
        faer::get_global_parallelism(),
        monitor,
    )?;
    let Some(values) = eigenvalues(solved.subrows(0, k).to_owned(), monitor)? else {
        return Ok((f64::NAN, f64::NAN));
    };
    let (mut least, mut largest, mut limit) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    for value in values {
        let real = 1.0 + value.re;
        let square = real * real + value.im * value.im;
        least = least.min(real);
        largest = largest.max(real);
        limit = limit.max(if real > 0.0 {
            square / (2.0 * real)
        } else {
            f64::INFINITY
        });
    }
    let best = (0.5 * (least + largest)).max(1.05 * limit);
    Ok((best, limit))
}

/// Time between two looks at a wish to stop.
const LOOK: Duration = Duration::from_millis(50);

/// Eigenvalues of a matrix; `None` where none were found.
///
/// They are computed in one piece, of seconds for a thousand points, so on a thread of their own: after an
/// interruption it is left to come to its end.
fn eigenvalues(matrix: Mat<f64>, monitor: Monitor<'_>) -> Result<Option<Vec<c64>>, Error> {
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || {
        // nobody may wait any more
        let _ = send.send(matrix.eigenvalues().ok());
    });
    let found = loop {
        match receive.recv_timeout(LOOK) {
            Ok(found) => break found,
            Err(RecvTimeoutError::Timeout) => report(monitor, 0, f64::NAN)?,
            Err(RecvTimeoutError::Disconnected) => break None,
        }
    };
    // dense kernels leave the workers slow
    mtb_operator::reset_workers();
    Ok(found)
}

/// Entry of a border column scaled to a largest entry of one.
fn scaled(columns: &[f64], column: usize, n: usize, row: usize) -> f64 {
    let part = &columns[column * n..(column + 1) * n];
    let most = largest(part);
    if most > 0.0 { part[row] / most } else { 0.0 }
}

fn scale_of(problem: &Staggered<'_>, n: usize) -> f64 {
    (0..n).fold(0.0_f64, |m, i| m.max(problem.half_spaces[i * n + i].abs()))
}

fn times(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    matrix
        .chunks_exact(x.len().max(1))
        .map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
        .collect()
}
