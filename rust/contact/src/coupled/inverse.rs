// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tractions that keep points where they are: what makes many steps with the same points quick.
//!
//! At base points, which include all that are in contact, `C t + M a = v - o` and `W' t = -w` with the displacement `v`
//! and the offset `o`. The inverse gives `t` and `a` by `v`, which is zero where a point sticks. Unknown are then only
//! the slips and the gaps of those base points that do not stick, a much smaller system than that of all tractions.

use std::collections::VecDeque;

use faer::{ColRef, Mat, Par};
use mtb_operator::dense::{Lu, Real};
use mtb_operator::krylov::{Krylov, add_scaled};
use mtb_operator::{Monitor, reset_workers};

use super::factor::Factor;
use super::matrix::{reset_after, threads};
use super::mirrored::{self, Blocks, Mirror, UNEQUAL};
use super::newton::{Iterate, Unknowns, even_rows, norm};
use super::{CoupledContact, CoupledMatrix, PointState, independent};
use crate::columns::add_columns;
use crate::error::Error;

/// Steps without an inverse after which one is made: it costs about as much as these.
const MISSES: usize = 3;

/// Unknowns below which a system is solved at once.
const DIRECT: usize = 100;

/// Unknowns for each Krylov step that new factors cost.
const STEPS_WORTH: f64 = 110.0;

/// Share of the stiffness times the way from where displacements were asked for precisely, below which a residual has to
/// be known precisely: a hundred times the rounding of single precision.
const ROUGH: f64 = 1e-5;

/// Krylov steps by old factors, beyond those that new ones would take, over the cost of these.
const PATIENCE: f64 = 2.0;

/// Least part of a decade by which a solve tells how many Krylov steps one takes.
const LEAST_DECADES: f64 = 0.3;

/// Steps from which the displacements of the next one are foretold.
const REMEMBERED: usize = 5;

/// Krylov steps with new factors.
const STEPS_AFRESH: usize = 30;

/// Base points, over those in contact, from which on a new base leaves out those that are not.
const WIDEST: f64 = 1.3;

/// The inverse for some base points and free motions.
#[derive(Debug)]
pub struct Inverse {
    pub(super) base: Vec<usize>,
    outside: Vec<usize>,
    /// (3n, m)
    motions: Mat<f64>,
    /// Tractions of the base points and amplitudes, then displacements of the points outside, by displacements of the base
    /// points and work (3n + m, 3k + m).
    pub(super) response: Mat<f64>,
    products: Products,
}

/// What products with the response pass by.
#[derive(Debug)]
enum Products {
    /// The same in single precision, for what need not be better: half as much passes the processor.
    Whole { rough: Mat<f32> },
    /// Where it is its own image in mirrors, what belongs to base points.
    Mirrored {
        precise: Blocks<f64>,
        rough: Blocks<f32>,
    },
}

/// What the entries of a response belong to.
pub(super) struct Places<'a> {
    pub(super) base: &'a [usize],
    pub(super) outside: &'a [usize],
    /// Number of free motions.
    pub(super) motions: usize,
}

/// An inverse from step to step, made when it is worth its cost.
#[derive(Debug, Default)]
pub struct KeptInverse {
    inverse: Option<Inverse>,
    recent: Recent,
    misses: usize,
    /// Points (n) in contact in steps without an inverse since the last one was made.
    seen: Vec<bool>,
    /// Motions that were given, and their independent combinations.
    shares: Option<(Mat<f64>, Mat<f64>)>,
    /// Mirrors in which the points are images of each other, and whether those are left in which the compliance is its
    /// own image.
    mirrors: Vec<Mirror>,
    are_tried: bool,
    /// The compliance in blocks, where it is its own image in these mirrors.
    compliance: Option<Blocks<f64>>,
}

/// What is taken over from one system to the next, of this step or a later one.
#[derive(Debug, Default)]
pub(super) struct Recent {
    factor: Option<Factor>,
    /// Displacements (3n) [m] since the state before in the last steps that were served, the last one first.
    displacements: VecDeque<Vec<f64>>,
}

/// An inverse in use.
pub(super) struct Quick<'a> {
    inverse: &'a Inverse,
    compliance: Option<&'a Blocks<f64>>,
    recent: &'a mut Recent,
}

/// What an inverse says under an offset.
pub(super) struct About<'a> {
    inverse: &'a Inverse,
    compliance: Option<&'a Blocks<f64>>,
    recent: &'a mut Recent,
    offset: &'a [f64],
    /// Displacements of the base points (3k) [m] that were asked for last; at first, those foretold.
    moved: Vec<f64>,
    /// What they answer to (3n + m).
    answer: Vec<f64>,
    /// Displacements that were asked for precisely last, and what they answer to.
    sure: (Vec<f64>, Vec<f64>),
}

/// The linear system of a step, whose unknowns are displacements [m] and whose rows are tractions [Pa]: along and across
/// the slip of each point that slips, and along all axes of each open one.
pub(super) struct System<'a> {
    pub(super) inverse: &'a Inverse,
    points: Vec<Moving>,
    pub(super) size: usize,
    /// Mean stiffness along the tangents [Pa/m].
    pub(super) stiff: f64,
}

/// A base point that does not stick.
pub(super) struct Moving {
    /// Which of the base points.
    pub(super) base: usize,
    pub(super) state: PointState,
    pub(super) slip: [f64; 2],
    friction: f64,
    /// Across the slip, the shares of traction and of displacement [Pa/m] in its row.
    pub(super) across: [f64; 2],
    /// By how much a turn of its slip turns it less than its traction, over the compliance.
    pub(super) turn: f64,
    pub(super) area: f64,
}

impl Moving {
    /// How many unknowns it has.
    pub(super) fn count(&self) -> usize {
        if self.state == PointState::Open { 3 } else { 2 }
    }
}

impl KeptInverse {
    /// For contacts of one compliance at `points` (3n) [m]: where bodies and points are their own image in mirrors across x
    /// or y, products take a half or a quarter of the operations.
    pub fn at(points: &[f64]) -> Self {
        Self {
            mirrors: Mirror::of(points),
            ..Self::default()
        }
    }

    /// Independent combinations of the motions `given`.
    pub(super) fn shares(&mut self, given: &Mat<f64>) -> Result<Mat<f64>, Error> {
        if let Some((known, shares)) = &self.shares
            && are_same(known, given)
        {
            return Ok(shares.clone());
        }
        let shares = independent(given)?;
        self.shares = Some((given.clone(), shares.clone()));
        Ok(shares)
    }

    /// The inverse for a contact, from a state with a `pressure` (n); `None` if there is none yet, or the contact has a
    /// diagonal compliance, which may differ from step to step.
    pub(super) fn for_contact(
        &mut self,
        contact: &CoupledContact,
        pressure: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Option<Quick<'_>>, Error> {
        if !contact.diagonal.is_empty() {
            return Ok(None);
        }
        if (self.inverse.as_ref())
            .is_some_and(|inverse| !are_same(&inverse.motions, &contact.motions))
        {
            (self.inverse, self.misses) = (None, 0);
            self.recent = Recent::default();
        }
        self.try_mirrors(&contact.matrix);
        // by parities it costs less than a step without it
        let is_due = if self.mirrors.is_empty() {
            self.misses >= MISSES
        } else {
            self.misses > 0 || self.inverse.is_none()
        };
        if is_due {
            self.seen.resize(pressure.len(), false);
            for (seen, p) in self.seen.iter_mut().zip(pressure) {
                *seen |= *p > 0.0;
            }
            let closed = self.seen.iter().filter(|seen| **seen).count();
            if let Some(old) = self.inverse.take()
                && (old.base.len() as f64) < WIDEST * closed as f64
            {
                for &i in &old.base {
                    self.seen[i] = true;
                }
            }
            let mirrors = Mirror::completing(&self.mirrors, &mut self.seen);
            let base: Vec<usize> = (0..self.seen.len()).filter(|&i| self.seen[i]).collect();
            if !base.is_empty() {
                self.inverse = Inverse::new(contact, base, &mirrors, monitor)?;
            }
            if self.inverse.is_none() {
                self.mirrors.clear();
            }
            self.misses = 0;
            self.seen.clear();
            self.recent = Recent::default();
        }
        Ok(self.inverse.as_ref().map(|inverse| Quick {
            inverse,
            compliance: self.compliance.as_ref(),
            recent: &mut self.recent,
        }))
    }

    /// Tries once in which mirrors a compliance is its own image.
    fn try_mirrors(&mut self, matrix: &CoupledMatrix) {
        if !self.are_tried {
            (self.mirrors).retain(|mirror| mirror.is_of(UNEQUAL, |t| matrix.displacement(t)));
            if !self.mirrors.is_empty() {
                self.compliance = Blocks::of(&matrix.compliance, &self.mirrors);
            }
            self.are_tried = true;
        }
    }

    /// Displacement (3n) [m] by tractions along both tangents and pressures (3n) [Pa], of the compliance of its contacts.
    pub fn displacement(&mut self, matrix: &CoupledMatrix, traction: &[f64]) -> Vec<f64> {
        self.try_mirrors(matrix);
        displacement(matrix, self.compliance.as_ref(), traction)
    }

    /// Counts a step that was not served.
    pub(super) fn miss(&mut self, points: &[PointState]) {
        self.misses += 1;
        self.seen.resize(points.len(), false);
        for (seen, point) in self.seen.iter_mut().zip(points) {
            *seen |= *point != PointState::Open;
        }
    }
}

/// Displacement (3n) [m] by tractions (3n), of the compliance in `blocks` where there are some.
fn displacement(
    matrix: &CoupledMatrix,
    blocks: Option<&Blocks<f64>>,
    traction: &[f64],
) -> Vec<f64> {
    let Some(blocks) = blocks else {
        return matrix.displacement(traction);
    };
    let mut displacement = vec![0.0; traction.len()];
    blocks.add(traction, &mut displacement);
    displacement
}

impl Recent {
    /// Displacements of the base points (3k) in the last step; zeros before.
    fn last(&self, inverse: &Inverse, n: usize) -> Vec<f64> {
        let last = self.displacements.front();
        inverse.places(n, last.map_or(&[], |last| last))
    }

    /// Those of the next step: of the polynomials through the last steps, the one that foretold the last of them best.
    fn foretold(&self, inverse: &Inverse, n: usize) -> Vec<f64> {
        let displacements = self.displacements.iter();
        let mut differences: Vec<Vec<f64>> =
            displacements.map(|all| inverse.places(n, all)).collect();
        let mut foretold = vec![0.0; 3 * inverse.base.len()];
        let (mut sum, mut least) = (foretold.clone(), f64::INFINITY);
        // the difference of each order in the last step is what polynomials below that order missed there
        while let Some(missed) = differences.first() {
            if norm(missed) < least {
                least = norm(missed);
                foretold.clone_from(&sum);
            }
            add_scaled(&mut sum, 1.0, missed);
            differences = (differences.windows(2))
                .map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| a - b).collect())
                .collect();
        }
        foretold
    }
}

/// Displacement at a place (of 3n) by a traction at one of the places `inner`, or by an amplitude in its unit.
fn influence(contact: &CoupledContact, place: usize, inner: &[usize], column: usize) -> f64 {
    if let Some(&traction) = inner.get(column) {
        contact.matrix.compliance[(place, traction)]
    } else {
        let motion = column - inner.len();
        contact.units[motion] * contact.motions[(place, motion)]
    }
}

/// The inverse of a matrix whose rows differ in size; `None` where one is empty.
fn inverse_of(
    mut matrix: Mat<f64>,
    par: Par,
    monitor: Monitor<'_>,
) -> Result<Option<Mat<f64>>, Error> {
    let Some(scales) = even_rows(&mut matrix) else {
        return Ok(None);
    };
    let mut unit = Mat::zeros(scales.len(), scales.len());
    for (i, scale) in scales.iter().enumerate() {
        unit[(i, i)] = scale.recip();
    }
    let factors = Lu::new(matrix, par, monitor)?;
    Ok(Some(factors.solve(unit.as_ref(), par, monitor)?))
}

/// Matrices of different shapes cannot be compared.
fn are_same(one: &Mat<f64>, other: &Mat<f64>) -> bool {
    one.ncols() == other.ncols() && one.nrows() == other.nrows() && one == other
}

impl Inverse {
    /// For the points `base`; `None` if there is none.
    fn new(
        contact: &CoupledContact,
        base: Vec<usize>,
        mirrors: &[Mirror],
        monitor: Monitor<'_>,
    ) -> Result<Option<Self>, Error> {
        let (n, m, k) = (contact.points(), contact.work.len(), base.len());
        let mut is_base = vec![false; n];
        for &i in &base {
            is_base[i] = true;
        }
        let outside: Vec<usize> = (0..n).filter(|&i| !is_base[i]).collect();
        let places = |points: &[usize]| -> Vec<usize> {
            (0..3)
                .flat_map(|c| points.iter().map(move |i| c * n + i))
                .collect()
        };
        let (inner, outer) = (places(&base), places(&outside));
        let size = 3 * k + m;
        let found = if mirrors.is_empty() {
            Self::by_factors(contact, &inner, monitor)?
        } else {
            Self::by_parities(contact, &base, &inner, mirrors, monitor)?
        };
        let Some(found) = found else {
            return Ok(None);
        };
        let beyond = Mat::from_fn(outer.len(), size, |row, column| {
            influence(contact, outer[row], &inner, column)
        }) * &found;
        reset_workers();
        if !(found.is_all_finite() && beyond.is_all_finite()) {
            return Ok(None);
        }
        let response = Mat::from_fn(size + outer.len(), size, |row, column| {
            if row < 3 * k {
                found[(row, column)]
            } else if row < size {
                contact.units[row - 3 * k] * found[(row, column)]
            } else {
                beyond[(row - size, column)]
            }
        });
        let places = Places {
            base: &base,
            outside: &outside,
            motions: m,
        };
        let blocks =
            (!mirrors.is_empty()).then(|| Blocks::new(&response, &places, mirrors, UNEQUAL));
        let products = blocks.flatten().map_or_else(
            || Products::Whole {
                rough: Mat::from_fn(response.nrows(), response.ncols(), |row, column| {
                    response[(row, column)] as f32
                }),
            },
            |precise| Products::Mirrored {
                rough: precise.rough(),
                precise,
            },
        );
        Ok(Some(Self {
            base,
            outside,
            motions: contact.motions.clone(),
            response,
            products,
        }))
    }

    /// Tractions of base points at the places `inner` and amplitudes, in their units, by displacements and work; `None`
    /// where the matrix has an empty row.
    fn by_factors(
        contact: &CoupledContact,
        inner: &[usize],
        monitor: Monitor<'_>,
    ) -> Result<Option<Mat<f64>>, Error> {
        let (n, k) = (contact.points(), inner.len());
        let size = k + contact.work.len();
        let matrix = Mat::from_fn(size, size, |row, column| {
            if row < k {
                influence(contact, inner[row], inner, column)
            } else if column < k {
                contact.motions[(inner[column], row - k)] * contact.area[inner[column] % n]
            } else {
                0.0
            }
        });
        inverse_of(matrix, faer::get_global_parallelism(), monitor)
    }

    /// The same by the inverse of the compliance, which is its own image in `mirrors`, and what balances.
    fn by_parities(
        contact: &CoupledContact,
        base: &[usize],
        inner: &[usize],
        mirrors: &[Mirror],
        monitor: Monitor<'_>,
    ) -> Result<Option<Mat<f64>>, Error> {
        let (n, k, m) = (contact.points(), inner.len(), contact.work.len());
        let stiffness = mirrored::inverse(&contact.matrix.compliance, base, mirrors, monitor)?;
        let shape = |i: usize, a: usize| contact.motions[(inner[i], a)];
        let shapes = Mat::from_fn(k, m, |i, a| contact.units[a] * shape(i, a));
        let balances = Mat::from_fn(m, k, |a, i| shape(i, a) * contact.area[inner[i] % n]);
        let by_amplitude = &stiffness * &shapes;
        let balanced = &balances * &by_amplitude;
        let Some(inverse) = inverse_of(balanced, Par::Seq, monitor)? else {
            return Ok(None);
        };
        // amplitudes by displacements, tractions by work
        let amplitude = &inverse * (&balances * &stiffness);
        let traction = &by_amplitude * &inverse;
        let mut found = Mat::zeros(k + m, k + m);
        let free = stiffness - &by_amplitude * &amplitude;
        found.submatrix_mut(0, 0, k, k).copy_from(&free);
        found.submatrix_mut(0, k, k, m).copy_from(&traction);
        found.submatrix_mut(k, 0, m, k).copy_from(&amplitude);
        found.submatrix_mut(k, k, m, m).copy_from(-inverse);
        Ok(Some(found))
    }

    /// The base points' part (3k) of displacements (3n); zeros where there are none.
    fn places(&self, n: usize, all: &[f64]) -> Vec<f64> {
        if all.is_empty() {
            return vec![0.0; 3 * self.base.len()];
        }
        let places = (0..3).flat_map(|c| self.base.iter().map(move |i| c * n + i));
        places.map(|place| all[place]).collect()
    }

    /// Adds the answer to displacements of the base points, and work if there is more, to `sum`.
    fn add_response(&self, given: &[f64], sum: &mut [f64]) {
        let mut first = 0;
        if let Products::Mirrored { precise, .. } = &self.products {
            first = 3 * self.base.len();
            precise.add(&given[..first], sum);
        }
        let given = given.iter().enumerate().skip(first);
        let columns: Vec<_> = given
            .filter(|(_, v)| **v != 0.0)
            .map(|(j, v)| (self.response.col_as_slice(j), *v))
            .collect();
        add_columns(&columns, sum);
    }

    /// The same, as far as single precision goes.
    fn add_roughly(&self, given: &[f64], sum: &mut [f64]) {
        let mut rough = vec![0.0_f32; sum.len()];
        match &self.products {
            Products::Mirrored { rough: blocks, .. } => {
                let (moved, work) = given.split_at(3 * self.base.len());
                blocks.add(moved, &mut rough);
                let columns: Vec<_> = work
                    .iter()
                    .enumerate()
                    .map(|(j, v)| (self.response.col_as_slice(moved.len() + j), *v))
                    .collect();
                add_columns(&columns, sum);
            }
            Products::Whole { rough: matrix } => {
                let given = given.iter().enumerate().filter(|(_, v)| **v != 0.0);
                let columns: Vec<_> = given
                    .map(|(j, v)| (matrix.col_as_slice(j), *v as f32))
                    .collect();
                add_columns(&columns, &mut rough);
            }
        }
        for (sum, rough) in sum.iter_mut().zip(rough) {
            *sum += f64::from(rough);
        }
    }
}

impl<'a> Quick<'a> {
    /// The same once more.
    pub(super) fn again(&mut self) -> Quick<'_> {
        Quick {
            inverse: self.inverse,
            compliance: self.compliance,
            recent: self.recent,
        }
    }

    /// What it says under an offset (3n) [m], told from a start, so that its rounding is that of the way from there.
    pub(super) fn about(
        self,
        contact: &CoupledContact,
        offset: &'a [f64],
        start: &Unknowns,
    ) -> About<'a> {
        let Self {
            inverse,
            compliance,
            recent,
        } = self;
        let n = contact.points();
        let Inverse { base, outside, .. } = inverse;
        let places =
            |points: &'a [usize]| (0..3).flat_map(move |c| points.iter().map(move |i| c * n + i));
        let moved = recent.foretold(inverse, n);
        let known = places(outside).all(|place| start.traction[place] == 0.0);
        let (mut answer, work): (Vec<f64>, Vec<f64>) = if known {
            let beyond = places(outside).map(|place| start.displacement[place] - offset[place]);
            let traction = places(base).map(|place| start.traction[place]);
            (
                traction
                    .chain(start.motion.iter().copied())
                    .chain(beyond)
                    .collect(),
                unbalanced(contact, &start.traction).collect(),
            )
        } else {
            (
                vec![0.0; inverse.response.nrows()],
                contact.work.iter().map(|work| -work).collect(),
            )
        };
        let from = if known { &start.displacement } else { offset };
        let there: Vec<f64> = places(base).map(|place| from[place]).collect();
        let still = vec![0.0; there.len()];
        let given: Vec<f64> = still.into_iter().chain(work).collect();
        inverse.add_response(&given, &mut answer);
        let mut about = About {
            inverse,
            compliance,
            recent,
            offset,
            moved: there.clone(),
            answer: answer.clone(),
            sure: (there, answer),
        };
        let roughly = !few(&moved);
        about.ask(moved, roughly);
        about
    }
}

/// Whether so few points move that to ask for their displacement (3k) costs little.
fn few(moved: &[f64]) -> bool {
    2 * moved.iter().filter(|v| **v != 0.0).count() < moved.len()
}

/// Work that tractions (3n) miss to balance each motion [J].
fn unbalanced<'a>(
    contact: &'a CoupledContact,
    traction: &'a [f64],
) -> impl Iterator<Item = f64> + 'a {
    contact.work.iter().enumerate().map(move |(k, work)| {
        let shape = contact.motions.col_as_slice(k).iter().zip(traction);
        let by_contact = shape.zip(contact.area.iter().cycle());
        -by_contact.map(|((m, t), area)| m * area * t).sum::<f64>() - work
    })
}

impl About<'_> {
    /// The start of Newton's method at the least residual: as given, displaced as foretold, where all points stick, or
    /// displaced as in the last step; and whether it is the answer of a linear step,
    /// which that of points that all stick is. None is tried that costs much after one that leaves at most `enough`.
    pub(super) fn start(
        &mut self,
        contact: &CoupledContact,
        given: Iterate,
        enough: f64,
    ) -> (Iterate, bool) {
        let mut best = (given, false);
        let n = contact.points();
        let inverse = self.inverse;
        let foretold = self.moved.clone();
        let zeros = vec![0.0; foretold.len()];
        // where few points move, to ask for another displacement costs little
        let few = few(&foretold);
        let mut tries = vec![foretold];
        if !few {
            tries.push(self.recent.last(inverse, n));
        }
        if !tries.contains(&zeros) {
            tries.push(zeros);
        }
        for moved in tries {
            let new = Iterate::new(contact, self.unknowns(n, moved, !few));
            if new.residual < best.0.residual {
                // where points slip, the linear step is still to be taken, however small the residual is
                let sticks = |point: &usize| new.points[*point] == PointState::Stick;
                let is_answer = inverse.base.iter().all(sticks);
                best = (new, is_answer);
            }
            if !few && best.0.residual <= enough {
                break;
            }
        }
        best
    }

    /// Tractions and amplitudes with the displacement that the compliance says they make.
    pub(super) fn exact(
        &self,
        contact: &CoupledContact,
        traction: Vec<f64>,
        motion: Vec<f64>,
    ) -> Unknowns {
        let displacement = displacement(&contact.matrix, self.compliance, &traction);
        Unknowns::displaced(contact, self.offset, traction, motion, displacement)
    }

    /// Remembers how far the points went in a step.
    pub(super) fn remember(&mut self, displacement: &[f64]) {
        let known = &mut self.recent.displacements;
        known.truncate(REMEMBERED - 1);
        known.push_front(displacement.to_vec());
    }

    /// Takes the rounding of the inverse off, as iterative refinement does: displacements (3n) [m] that it promised,
    /// and what the compliance says.
    pub(super) fn correct(&mut self, contact: &CoupledContact, promised: &[f64], exact: &Unknowns) {
        let n = contact.points();
        let base = &self.inverse.base;
        let places = (0..3).flat_map(|c| base.iter().map(move |i| c * n + i));
        let missed = places.map(|place| promised[place] - exact.displacement[place]);
        let given: Vec<f64> = missed.chain(unbalanced(contact, &exact.traction)).collect();
        let mut more = vec![0.0; self.answer.len()];
        self.inverse.add_roughly(&given, &mut more);
        for answer in [&mut self.answer, &mut self.sure.1] {
            answer
                .iter_mut()
                .zip(&more)
                .for_each(|(v, more)| *v += more);
        }
    }

    /// Asks for displacements of the base points: only those that change pass by. What is asked for `roughly` has the
    /// rounding of single precision on the way from where was asked precisely.
    fn ask(&mut self, moved: Vec<f64>, roughly: bool) {
        if roughly && moved == self.moved {
            return;
        }
        let from = if roughly { &self.moved } else { &self.sure.0 };
        let way: Vec<f64> = moved.iter().zip(from).map(|(to, from)| to - from).collect();
        if roughly {
            self.inverse.add_roughly(&way, &mut self.answer);
        } else {
            self.inverse.add_response(&way, &mut self.sure.1);
            self.sure.0.clone_from(&moved);
            self.answer.clone_from(&self.sure.1);
        }
        self.moved = moved;
    }

    /// Tractions and amplitudes for displacements of the base points.
    fn unknowns(&mut self, n: usize, moved: Vec<f64>, roughly: bool) -> Unknowns {
        self.ask(moved, roughly);
        let Inverse { base, outside, .. } = self.inverse;
        let k = base.len();
        let (all, moved) = (&self.answer, &self.moved);
        let size = all.len() - 3 * outside.len();
        let mut traction = vec![0.0; 3 * n];
        let mut displacement = vec![0.0; 3 * n];
        for c in 0..3 {
            for (b, &point) in base.iter().enumerate() {
                traction[c * n + point] = all[c * k + b];
                displacement[c * n + point] = moved[c * k + b];
            }
            for (row, &point) in outside.iter().enumerate() {
                let place = c * n + point;
                displacement[place] = all[size + c * outside.len() + row] + self.offset[place];
            }
        }
        Unknowns {
            traction,
            motion: all[3 * k..size].to_vec(),
            displacement,
        }
    }

    /// As [`Iterate::linear_step`]; `None` if a point outside the base is in contact, all of the base are open, or the
    /// matrix is singular.
    pub(super) fn linear_step(
        &mut self,
        contact: &CoupledContact,
        iterate: &Iterate,
        tolerance: f64,
        monitor: Monitor<'_>,
    ) -> Result<Option<Unknowns>, Error> {
        let n = contact.points();
        let Inverse { base, outside, .. } = self.inverse;
        if outside
            .iter()
            .any(|&i| iterate.points[i] != PointState::Open)
        {
            return Ok(None);
        }
        let system = System::new(contact, self.inverse, iterate);
        let r = system.size;
        if r == 3 * base.len() {
            return Ok(None);
        }
        // what is no unknown goes back to zero
        let mut moved = vec![0.0; 3 * base.len()];
        for point in &system.points {
            for axis in 0..point.count() {
                let from = iterate.at.displacement[axis * n + base[point.base]];
                moved[axis * base.len() + point.base] = from;
            }
        }
        let mut x = system.local(&moved);
        let is_direct = r < DIRECT;
        let far: Vec<f64> = (moved.iter().zip(&self.sure.0))
            .map(|(to, from)| to - from)
            .collect();
        let is_near = iterate.residual < ROUGH * contact.matrix.stiffness[0] * norm(&far);
        self.ask(moved, !(is_direct || is_near));
        let mut residual = self.rest(&system, &x);
        let mut is_solved = r == 0;
        if r >= DIRECT {
            // new factors once they would have saved as much as they cost, this solve at the pace of the last one included
            let worth = r as f64 / STEPS_WORTH;
            let wanted = (norm(&residual) / tolerance).log10().max(0.0);
            let serves = |f: &Factor| f.lost + (f.pace - f.steps).max(0.0) * wanted < worth;
            let kept = self.recent.factor.take().filter(serves);
            for kept in kept.into_iter().map(Some).chain([None]) {
                let (mut factor, most) = if let Some(factor) = kept {
                    let most = factor.steps * wanted + PATIENCE * worth;
                    (factor, (most as usize).max(1))
                } else {
                    let Some(factor) = system.factor(monitor)? else {
                        break;
                    };
                    (factor, STEPS_AFRESH)
                };
                let before = norm(&residual);
                // unknowns and answer of each Krylov step, from which those of the solution are summed up
                let mut ways: Vec<[Vec<f64>; 2]> = Vec::new();
                let product = |rows: &[f64], out: &mut [f64]| {
                    let mut way = vec![0.0; r];
                    system.near(&factor, rows, &mut way);
                    let mut answer = vec![0.0; self.answer.len()];
                    self.inverse.add_roughly(&system.placed(&way), &mut answer);
                    system.rows(&answer, &way, out);
                    ways.push([way, answer]);
                };
                let (report, weights) =
                    Krylov::default().weights(product, &residual, tolerance, most);
                if !weights.iter().all(|v| v.is_finite()) {
                    break;
                }
                for (weight, [way, answer]) in weights.iter().zip(&ways) {
                    add_scaled(&mut x, *weight, way);
                    add_scaled(&mut self.answer, *weight, answer);
                }
                self.moved = system.placed(&x);
                residual = self.rest(&system, &x);
                let (steps, decades) = (report.steps as f64, (before / report.residual).log10());
                if factor.steps.is_finite() {
                    factor.lost += (steps - factor.steps * decades).max(0.0);
                } else {
                    factor.steps = steps / decades.max(1.0);
                }
                factor.pace = steps / decades.max(LEAST_DECADES);
                self.recent.factor = Some(factor);
                is_solved = report.residual <= tolerance;
                if is_solved {
                    break;
                }
            }
        }
        if !is_solved {
            let all: Vec<usize> = (0..r).collect();
            let par = threads(4 * r * r);
            let lu = Lu::new(system.matrix(&all, |v| v), par, monitor)?;
            let more = lu.solve(ColRef::from_slice(&residual).as_mat(), par, monitor)?;
            reset_after(par);
            if !more.is_all_finite() {
                return Ok(None);
            }
            for (x, more) in x.iter_mut().zip(more.col_as_slice(0)) {
                *x += more;
            }
        }
        Ok(Some(self.unknowns(n, system.placed(&x), !is_direct)))
    }

    /// What is left of the rows of a system, for unknowns that were asked for.
    fn rest(&self, system: &System<'_>, x: &[f64]) -> Vec<f64> {
        let mut rest = vec![0.0; system.size];
        system.rows(&self.answer, x, &mut rest);
        for v in &mut rest {
            *v = -*v;
        }
        rest
    }
}

impl<'a> System<'a> {
    fn new(contact: &CoupledContact, inverse: &'a Inverse, iterate: &Iterate) -> Self {
        let soft = contact.matrix.stiffness[0].recip();
        let mut points = Vec::new();
        for (base, &point) in inverse.base.iter().enumerate() {
            let state = iterate.points[point];
            if state != PointState::Stick {
                // so that rows are tractions, however far the point slips
                let turn = iterate.curvature[point];
                points.push(Moving {
                    base,
                    state,
                    slip: iterate.slip[point],
                    friction: contact.friction[point],
                    across: [turn / (turn + soft), (turn + soft).recip()],
                    turn: turn / soft,
                    area: contact.area[point],
                });
            }
        }
        Self {
            inverse,
            stiff: soft.recip(),
            size: points.iter().map(Moving::count).sum(),
            points,
        }
    }

    /// Each point with its first unknown.
    pub(super) fn numbered(&self) -> impl Iterator<Item = (usize, &Moving)> {
        self.points.iter().scan(0, |next, point| {
            let first = *next;
            *next += point.count();
            Some((first, point))
        })
    }

    /// The unknowns of displacements of the base points.
    fn local(&self, moved: &[f64]) -> Vec<f64> {
        let k = self.inverse.base.len();
        let mut x = Vec::with_capacity(self.size);
        for point in &self.points {
            let [vx, vy, vn] = [0, 1, 2].map(|axis| moved[axis * k + point.base]);
            if point.state == PointState::Slip {
                let [c, s] = point.slip;
                x.extend([c * vx + s * vy, c * vy - s * vx]);
            } else {
                x.extend([vx, vy, vn]);
            }
        }
        x
    }

    /// Displacements of the base points (3k) by the unknowns.
    fn placed(&self, x: &[f64]) -> Vec<f64> {
        let k = self.inverse.base.len();
        let mut moved = vec![0.0; 3 * k];
        for (at, point) in self.numbered() {
            let b = point.base;
            if point.state == PointState::Slip {
                let [c, s] = point.slip;
                moved[b] = c * x[at] - s * x[at + 1];
                moved[k + b] = s * x[at] + c * x[at + 1];
            } else {
                for axis in 0..3 {
                    moved[axis * k + b] = x[at + axis];
                }
            }
        }
        moved
    }

    /// What the rows are for tractions of the base points and unknowns.
    fn rows(&self, traction: &[f64], x: &[f64], out: &mut [f64]) {
        self.rows_of_tractions(traction, out);
        for (at, point) in self.numbered() {
            if point.state == PointState::Slip {
                // the slip keeps its direction
                out[at + 1] += point.across[1] * x[at + 1];
            }
        }
    }

    fn rows_of_tractions(&self, traction: &[f64], out: &mut [f64]) {
        let k = self.inverse.base.len();
        for (at, point) in self.numbered() {
            let [x, y, p] = [0, 1, 2].map(|axis| traction[axis * k + point.base]);
            if point.state == PointState::Slip {
                // the traction follows the pressure along the slip, and turns with it
                let [c, s] = point.slip;
                out[at] = c * x + s * y - point.friction * p;
                out[at + 1] = point.across[0] * (c * y - s * x);
            } else {
                out[at..at + 3].copy_from_slice(&[x, y, p]);
            }
        }
    }

    /// The rows and columns of some of the unknowns, which ascend, as numbers of another kind.
    fn matrix<T: Real>(&self, part: &[usize], of: impl Fn(f64) -> T) -> Mat<T> {
        let k = self.inverse.base.len();
        let response = |place: usize| self.inverse.response.col_as_slice(place);
        let mut matrix = Mat::zeros(part.len(), part.len());
        let (mut moved, mut rows) = (vec![0.0; 3 * k], vec![0.0; self.size]);
        let mut columns = part.iter().enumerate().peekable();
        for (at, point) in self.numbered() {
            while let Some((column, &unknown)) =
                columns.next_if(|(_, unknown)| **unknown < at + point.count())
            {
                if point.state == PointState::Slip {
                    let [c, s] = point.slip;
                    let [x, y] = if unknown == at { [c, s] } else { [-s, c] };
                    let both = response(point.base).iter().zip(response(k + point.base));
                    for (v, (a, b)) in moved.iter_mut().zip(both) {
                        *v = x * a + y * b;
                    }
                    self.rows_of_tractions(&moved, &mut rows);
                    if unknown > at {
                        rows[unknown] += point.across[1];
                    }
                } else {
                    let place = (unknown - at) * k + point.base;
                    self.rows_of_tractions(response(place), &mut rows);
                }
                for (entry, &row) in matrix.col_as_slice_mut(column).iter_mut().zip(part) {
                    *entry = of(rows[row]);
                }
            }
        }
        matrix
    }
}
