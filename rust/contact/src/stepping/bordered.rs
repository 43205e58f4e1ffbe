// SPDX-License-Identifier: MIT OR Apache-2.0
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use mtb_operator::dense::{LuInParts, Watch};
use mtb_operator::krylov::dot;
use mtb_operator::{Error, Monitor};

use super::factor::{Lu, Small};
use super::influence::{Influence, Terms, runs};
use crate::columns::{add_columns, largest};
use crate::sliding::{RigidMotion, SlidingContact};

/// Differences of terms, over the largest, that are nothing beside what rounding leaves of a solution.
const ROUNDING: f64 = 1e-14;

/// The contact's equations on an active set, solved with factors made for a set and a friction of the past.
///
/// With `F` the points factorised, `E` those that came since and `L` those that left, the equations on
/// `F - L + E` with the rigid motions are those on `F` bordered by the rows and columns of the
/// motions, of `E`, and of unit vectors on `L`. Columns once solved are kept until the next factors.
pub(super) struct Bordered {
    lu: Lu,
    factorised: Vec<usize>,
    place: Vec<usize>,
    terms: Terms,
    entered: Vec<Option<Entered>>,
    left: Vec<Option<Vec<f64>>>,
    motions: Vec<Column>,
    now: Now,
    work: Work,
    pub(super) kept: Kept,
}

/// The last answers to transposed equations, which do not depend on the load: states on the same points, under the
/// friction of the factors, have them again.
#[derive(Default)]
pub(super) struct Kept {
    solved: Option<Solved>,
    along: [Option<(Mat<f64>, Mat<f64>)>; 2],
}

struct Solved {
    points: Vec<usize>,
    motions: Vec<RigidMotion>,
    asked: Mat<f64>,
    found: Mat<f64>,
}

impl Kept {
    /// The solution for the right-hand sides `asked`.
    pub(super) fn solution(
        &self,
        asked: &Mat<f64>,
        points: &[usize],
        motions: &[RigidMotion],
    ) -> Option<Mat<f64>> {
        let kept = self.solved.as_ref()?;
        let is_known = kept.points == points
            && is_same(&kept.asked, asked)
            && move_alike(&kept.motions, motions);
        is_known.then(|| kept.found.clone())
    }

    pub(super) fn keep(
        &mut self,
        asked: &Mat<f64>,
        points: &[usize],
        motions: &[RigidMotion],
        found: &Mat<f64>,
    ) {
        self.solved = Some(Solved {
            points: points.to_vec(),
            motions: motions.to_vec(),
            asked: asked.clone(),
            found: found.clone(),
        });
    }

    /// What weights of gaps are as weights of tractions along a tangent, by `product` if it is not known.
    pub(super) fn along(
        &mut self,
        axis: usize,
        gap: &Mat<f64>,
        product: impl FnOnce() -> Option<Mat<f64>>,
    ) -> Option<Mat<f64>> {
        if let Some((weights, known)) = &self.along[axis]
            && is_same(weights, gap)
        {
            return Some(known.clone());
        }
        let found = product()?;
        self.along[axis] = Some((gap.clone(), found.clone()));
        Some(found)
    }
}

/// Whether motions are the same, whatever the work of the loads on them.
fn move_alike(some: &[RigidMotion], others: &[RigidMotion]) -> bool {
    some.len() == others.len()
        && some.iter().zip(others).all(|(a, b)| {
            a.opening == b.opening
                && a.tangential_x == b.tangential_x
                && a.tangential_y == b.tangential_y
        })
}

/// Whether matrices have the same numbers: faer compares those of one shape alone.
fn is_same(one: &Mat<f64>, other: &Mat<f64>) -> bool {
    one.shape() == other.shape() && one == other
}

struct Column {
    column: Vec<f64>,
    solved: Vec<f64>,
}

struct Entered {
    row: Vec<f64>,
    solved: Vec<f64>,
}

/// The set being solved on.
struct Now {
    entered: Vec<(usize, usize)>,
    left: Vec<usize>,
    balance: Vec<Vec<f64>>,
    schur: Option<Small>,
}

#[derive(Default)]
struct Work {
    y: Vec<f64>,
    t: Vec<f64>,
    lu: Vec<f64>,
}

const ABSENT: usize = usize::MAX;

/// Operations of Gauss' factors of so many rows.
pub(super) fn factorisation(rows: usize) -> f64 {
    (rows as f64).powi(3) / 1.5
}

/// Active sets of a step, the second one a few points from the first; and solves on each of them.
const SETS: f64 = 2.0;
const SOLVES: f64 = 4.0;

/// Operations of a step's solves, and of factors of the border for each of its sets, with factors of so many rows.
pub(super) fn solving(rows: usize, borders: usize) -> f64 {
    let (k, b) = (rows as f64, borders as f64);
    SETS * (factorisation(borders) + SOLVES * 2.0 * (k * (k + b) + b * b))
}

/// Points in which a set may differ from one of so many points that is factorised.
pub(super) fn reach(points: usize) -> usize {
    4 + points / 8
}

impl Bordered {
    pub(super) fn new(
        influence: &Influence,
        terms: &Terms,
        set: &[usize],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let lu = Lu::of(block(influence, terms, set), monitor)?;
        Ok(Self::of(
            lu,
            influence.points(),
            terms.clone(),
            set.to_vec(),
        ))
    }

    fn of(lu: Lu, n: usize, terms: Terms, factorised: Vec<usize>) -> Self {
        let mut place = vec![ABSENT; n];
        for (i, &point) in factorised.iter().enumerate() {
            place[point] = i;
        }
        Self {
            lu,
            factorised,
            place,
            terms,
            entered: std::iter::repeat_with(|| None).take(n).collect(),
            left: vec![None; n],
            motions: Vec::new(),
            now: Now {
                entered: Vec::new(),
                left: Vec::new(),
                balance: Vec::new(),
                schur: None,
            },
            work: Work::default(),
            kept: Kept::default(),
        }
    }

    /// Whether the set is the one factorised.
    pub(super) fn holds(&self, active: &[bool]) -> bool {
        self.place
            .iter()
            .zip(active)
            .all(|(place, active)| (*place != ABSENT) == *active)
    }

    /// Whether the set `active` is so far away that factors of its own are cheaper than its borders.
    ///
    /// Of factors of all points, borders are the points that left: up to half of all, these are fewer than the
    /// points that are there. Factors of fewer points serve the neighbourhood of their own set.
    pub(super) fn is_far_from(&self, active: &[bool]) -> bool {
        let k = self.factorised.len();
        let most = if k == active.len() { k / 2 } else { reach(k) };
        self.changes(active).count() > most
    }

    /// Operations of a step on the set `active`, about: solves for columns that are not known, factors of the border,
    /// and solves with both.
    pub(super) fn taking(&self, active: &[bool]) -> f64 {
        let (mut borders, mut unknown) = (0, 0);
        for (point, is_left) in self.changes(active) {
            let is_known = if is_left {
                self.left[point].is_some()
            } else {
                self.entered[point].is_some()
            };
            borders += 1;
            unknown += usize::from(!is_known);
        }
        let k = self.factorised.len();
        2.0 * (k as f64).powi(2) * unknown as f64 + solving(k, borders)
    }

    /// Points in which the set `active` differs from the one factorised, and whether they have left it.
    fn changes(&self, active: &[bool]) -> impl Iterator<Item = (usize, bool)> {
        let pairs = self.place.iter().zip(active).enumerate();
        pairs.filter_map(|(point, (place, active))| {
            let is_there = *place != ABSENT;
            (is_there != *active).then_some((point, is_there))
        })
    }

    /// Points factorised.
    pub(super) fn rows(&self) -> usize {
        self.factorised.len()
    }

    /// Friction and diagonal of the factors.
    pub(super) fn terms(&self) -> &Terms {
        &self.terms
    }

    /// Whether the factors are those of `terms` themselves.
    pub(super) fn is_exact(&self, terms: &Terms) -> bool {
        self.terms == *terms
    }

    /// Whether `terms` are those of the factors but for rounding: the direction of sliding has other last digits at
    /// each speed.
    pub(super) fn serves(&self, terms: &Terms) -> bool {
        let near = |one: &[f64], other: &[f64]| {
            let most = ROUNDING * largest(one);
            one.len() == other.len() && one.iter().zip(other).all(|(a, b)| (a - b).abs() <= most)
        };
        near(&self.terms.drag, &terms.drag) && near(&self.terms.diagonal, &terms.diagonal)
    }

    /// Sign of the determinant of the bordered equations.
    pub(super) fn sign(&self) -> f64 {
        self.lu.sign() * self.now.schur.as_ref().map_or(1.0, Small::sign)
    }

    /// Turns to the set `points`; returns the columns it had to solve for.
    pub(super) fn turn_to(
        &mut self,
        influence: &Influence,
        contact: &SlidingContact<'_>,
        points: &[usize],
        monitor: Monitor<'_>,
    ) -> Result<usize, Error> {
        let mut watch = Watch::new(monitor);
        let each = 4.0 * (self.factorised.len() as f64).powi(2);
        let mut solves = self.keep_motions(contact);
        let mut absent = vec![true; self.factorised.len()];
        self.now.entered.clear();
        for (at, &point) in points.iter().enumerate() {
            match self.place[point] {
                ABSENT => self.now.entered.push((at, point)),
                place => absent[place] = false,
            }
        }
        self.now.left.clear();
        self.now
            .left
            .extend((0..absent.len()).filter(|&i| absent[i]));
        solves += self.solve_columns(influence);
        watch.spend(each * solves as f64)?;
        self.now.balance = contact
            .motions
            .iter()
            .map(|motion| {
                self.factorised
                    .iter()
                    .map(|&i| -contact.work_of_pressure(motion, i))
                    .collect()
            })
            .collect();
        self.now.schur = Some(Small::of(self.schur(influence, contact), monitor)?);
        Ok(solves)
    }

    /// Solves at once for the border columns that are not known yet; returns how many these are.
    fn solve_columns(&mut self, influence: &Influence) -> usize {
        let k = self.factorised.len();
        let come: Vec<usize> = (self.now.entered.iter().map(|&(_, point)| point))
            .filter(|&point| self.entered[point].is_none())
            .collect();
        let gone: Vec<usize> = (self.now.left.iter().copied())
            .filter(|&place| self.left[self.factorised[place]].is_none())
            .collect();
        let count = come.len() + gone.len();
        if count == 0 {
            return 0;
        }
        let mut columns = Mat::zeros(k, count);
        let runs = runs(&self.factorised);
        for (j, &point) in come.iter().enumerate() {
            let to = columns.col_as_slice_mut(j);
            influence.put_column(point, &self.terms, &runs, to);
        }
        for (j, &place) in gone.iter().enumerate() {
            columns[(place, come.len() + j)] = -1.0;
        }
        let solved = self.lu.solve_many(&columns);
        for (j, &point) in come.iter().enumerate() {
            let row = (self.factorised.iter()).map(|&i| influence.entry(point, i, &self.terms));
            self.entered[point] = Some(Entered {
                row: row.collect(),
                solved: solved.col_as_slice(j).to_vec(),
            });
        }
        for (j, &place) in gone.iter().enumerate() {
            self.left[self.factorised[place]] = Some(solved.col_as_slice(come.len() + j).to_vec());
        }
        count
    }

    /// Overwrites `x` (pressures of the set, then motions) with the solution for the right-hand side `x`.
    pub(super) fn solve(&mut self, x: &mut [f64], points: &[usize]) {
        let k = points.len();
        let Work { y, t, lu } = &mut self.work;
        y.clear();
        y.resize(self.factorised.len(), 0.0);
        for (x, &point) in x.iter().zip(points) {
            if self.place[point] != ABSENT {
                y[self.place[point]] = *x;
            }
        }
        self.lu.solve(y, lu);
        t.clear();
        t.extend(
            x[k..]
                .iter()
                .zip(&self.now.balance)
                .map(|(x, row)| x - dot(row, y)),
        );
        for &(at, point) in &self.now.entered {
            let row = self.entered[point].as_ref().map_or(0.0, |e| dot(&e.row, y));
            t.push(x[at] - row);
        }
        t.extend(self.now.left.iter().map(|&place| -y[place]));
        if let Some(schur) = &self.now.schur {
            schur.solve(t, lu);
        }
        let m = self.motions.len();
        let columns = columns(
            &self.motions,
            &self.entered,
            &self.left,
            &self.now,
            &self.factorised,
        );
        let weighted: Vec<_> = columns.zip(&self.work.t).map(|(c, t)| (c, -t)).collect();
        add_columns(&weighted, &mut self.work.y);
        for (x, &point) in x.iter_mut().zip(points) {
            if self.place[point] != ABSENT {
                *x = self.work.y[self.place[point]];
            }
        }
        x[k..].copy_from_slice(&self.work.t[..m]);
        for (&(at, _), t) in self.now.entered.iter().zip(&self.work.t[m..]) {
            x[at] = *t;
        }
    }

    /// The solutions for many right-hand sides at once (columns: gaps of the set, then balances): pressures of the
    /// set, then motions. With `transposed` equations the other way round: for weights of pressures and motions,
    /// those of gaps and balances.
    pub(super) fn solve_many(
        &self,
        rhs: &Mat<f64>,
        points: &[usize],
        transposed: bool,
    ) -> Mat<f64> {
        let (size, cases, k) = (self.factorised.len(), rhs.ncols(), points.len());
        let (m, e) = (self.motions.len(), self.now.entered.len());
        let border = m + e + self.now.left.len();
        let inside = |point: usize| Some(self.place[point]).filter(|place| *place != ABSENT);
        let mut y = Mat::zeros(size, cases);
        let mut t = Mat::zeros(border, cases);
        for j in 0..cases {
            let (gaps, balances) = rhs.col_as_slice(j).split_at(k);
            let y = y.col_as_slice_mut(j);
            for (&point, gap) in points.iter().zip(gaps) {
                if let Some(place) = inside(point) {
                    y[place] = *gap;
                }
            }
            let t = t.col_as_slice_mut(j);
            t[..m].copy_from_slice(balances);
            for (t, &(at, _)) in t[m..].iter_mut().zip(&self.now.entered) {
                *t = gaps[at];
            }
        }
        if border == 0 {
            y = self.solve_inside(&y, transposed);
        } else {
            let columns = self.border_columns();
            if transposed {
                // the columns are solved already: what is left is the rows
                subtract(&mut t, columns.transpose(), &y);
                t = self.solve_border(t, true);
                subtract(&mut y, self.border_rows().as_ref(), &t);
                y = self.solve_inside(&y, true);
            } else {
                y = self.solve_inside(&y, false);
                subtract(&mut t, self.border_rows().transpose(), &y);
                t = self.solve_border(t, false);
                subtract(&mut y, columns.as_ref(), &t);
            }
        }
        let mut x = Mat::zeros(k + m, cases);
        for j in 0..cases {
            let (y, t) = (y.col_as_slice(j), t.col_as_slice(j));
            let (pressures, motions) = x.col_as_slice_mut(j).split_at_mut(k);
            for (&point, pressure) in points.iter().zip(pressures.iter_mut()) {
                if let Some(place) = inside(point) {
                    *pressure = y[place];
                }
            }
            motions.copy_from_slice(&t[..m]);
            for (&(at, _), t) in self.now.entered.iter().zip(&t[m..]) {
                pressures[at] = *t;
            }
        }
        x
    }

    fn solve_inside(&self, rhs: &Mat<f64>, transposed: bool) -> Mat<f64> {
        if transposed {
            self.lu.solve_many_transposed(rhs)
        } else {
            self.lu.solve_many(rhs)
        }
    }

    fn solve_border(&self, rhs: Mat<f64>, transposed: bool) -> Mat<f64> {
        match &self.now.schur {
            Some(schur) => schur.solve_many(rhs, transposed),
            None => rhs,
        }
    }

    /// The solved columns of the border.
    fn border_columns(&self) -> Mat<f64> {
        let (motions, entered, left) = (&self.motions, &self.entered, &self.left);
        let solved = columns(motions, entered, left, &self.now, &self.factorised);
        stacked(solved, self.factorised.len())
    }

    /// The rows of the border, a column each.
    fn border_rows(&self) -> Mat<f64> {
        let balance = self.now.balance.iter().map(Vec::as_slice);
        let entered = self.now.entered.iter();
        let entered = entered.filter_map(|&(_, point)| self.entered[point].as_ref());
        let given = balance.chain(entered.map(|e| e.row.as_slice()));
        let count = self.motions.len() + self.now.entered.len();
        let mut rows = Mat::zeros(self.factorised.len(), count + self.now.left.len());
        for (i, row) in given.enumerate() {
            rows.col_as_slice_mut(i).copy_from_slice(row);
        }
        for (i, &place) in self.now.left.iter().enumerate() {
            rows[(place, count + i)] = 1.0;
        }
        rows
    }

    /// Keeps the solved columns of the motions; returns those that had to be solved anew.
    fn keep_motions(&mut self, contact: &SlidingContact<'_>) -> usize {
        let mut solves = 0;
        self.motions.truncate(contact.motions.len());
        for (k, motion) in contact.motions.iter().enumerate() {
            let opening = || self.factorised.iter().map(|&i| motion.opening[i]);
            if self
                .motions
                .get(k)
                .is_some_and(|kept| kept.column.iter().copied().eq(opening()))
            {
                continue;
            }
            let column: Vec<f64> = opening().collect();
            let mut solved = column.clone();
            self.lu.solve(&mut solved, &mut self.work.lu);
            solves += 1;
            self.motions.truncate(k);
            self.motions.push(Column { column, solved });
        }
        solves
    }

    /// `D - R A^-1 C` of the bordered matrix `[A C; R D]`.
    fn schur(&self, influence: &Influence, contact: &SlidingContact<'_>) -> Mat<f64> {
        let now = &self.now;
        let (m, e) = (self.motions.len(), now.entered.len());
        let size = m + e + now.left.len();
        let mut schur = Mat::zeros(size, size);
        let columns = columns(
            &self.motions,
            &self.entered,
            &self.left,
            now,
            &self.factorised,
        );
        for (j, solved) in columns.enumerate() {
            for (i, row) in now.balance.iter().enumerate() {
                schur[(i, j)] = -dot(row, solved);
            }
            for (i, &(_, point)) in now.entered.iter().enumerate() {
                schur[(m + i, j)] = -self.entered[point]
                    .as_ref()
                    .map_or(0.0, |e| dot(&e.row, solved));
            }
            for (i, &place) in now.left.iter().enumerate() {
                schur[(m + e + i, j)] = -solved[place];
            }
        }
        for (i, &(_, point)) in now.entered.iter().enumerate() {
            for (j, motion) in contact.motions.iter().enumerate() {
                schur[(j, m + i)] -= contact.work_of_pressure(motion, point);
                schur[(m + i, j)] += motion.opening[point];
            }
            for (j, &(_, other)) in now.entered.iter().enumerate() {
                schur[(m + i, m + j)] += influence.entry(point, other, &self.terms);
            }
        }
        schur
    }
}

/// Factors that are being made a part at a time, between steps.
pub(super) struct Making {
    terms: Terms,
    set: Vec<usize>,
    /// `None` before the matrix is there.
    lu: Option<LuInParts>,
}

/// Parts that the making of factors is divided into, about; and the least columns of one of them.
pub(super) const PARTS: usize = 8;
const NARROWEST: usize = 32;

impl Making {
    pub(super) fn new(terms: Terms, set: Vec<usize>) -> Self {
        Self {
            terms,
            set,
            lu: None,
        }
    }

    /// Makes the next part; the factors, once all are made.
    pub(super) fn advance(
        mut self,
        influence: &Influence,
        monitor: Monitor<'_>,
    ) -> Result<Result<Bordered, Self>, Error> {
        let Some(mut lu) = self.lu.take() else {
            let width = self.set.len().div_ceil(PARTS).max(NARROWEST);
            let matrix = block(influence, &self.terms, &self.set);
            self.lu = Some(LuInParts::new(matrix, width));
            return Ok(Err(self));
        };
        if !lu.advance(Par::Seq, &mut Watch::new(monitor))? {
            self.lu = Some(lu);
            return Ok(Err(self));
        }
        let lu = Lu(lu.finish());
        let n = influence.points();
        Ok(Ok(Bordered::of(lu, n, self.terms, self.set)))
    }
}

/// `from - matrix x`, on one thread.
fn subtract(from: &mut Mat<f64>, matrix: MatRef<'_, f64>, x: &Mat<f64>) {
    matmul(from.as_mut(), Accum::Add, matrix, x, -1.0, Par::Seq);
}

/// The equations of `set` without motions.
fn block(influence: &Influence, terms: &Terms, set: &[usize]) -> Mat<f64> {
    let mut matrix = Mat::zeros(set.len(), set.len());
    let runs = runs(set);
    for (j, &point) in set.iter().enumerate() {
        influence.put_column(point, terms, &runs, matrix.col_as_slice_mut(j));
    }
    matrix
}

/// Vectors of a length as the columns of a matrix.
pub(super) fn stacked<'a>(vectors: impl Iterator<Item = &'a [f64]>, length: usize) -> Mat<f64> {
    let vectors: Vec<&[f64]> = vectors.collect();
    let mut matrix = Mat::zeros(length, vectors.len());
    for (j, vector) in vectors.into_iter().enumerate() {
        matrix.col_as_slice_mut(j).copy_from_slice(vector);
    }
    matrix
}

/// The solved border columns of the set of `now`: motions, points that entered, points that left.
fn columns<'a>(
    motions: &'a [Column],
    entered: &'a [Option<Entered>],
    left: &'a [Option<Vec<f64>>],
    now: &'a Now,
    factorised: &'a [usize],
) -> impl Iterator<Item = &'a [f64]> {
    let motions = motions.iter().map(|c| c.solved.as_slice());
    let entered = now
        .entered
        .iter()
        .filter_map(|&(_, point)| entered[point].as_ref().map(|e| e.solved.as_slice()));
    let left = now
        .left
        .iter()
        .filter_map(|&place| left[factorised[place]].as_deref());
    motions.chain(entered).chain(left)
}
