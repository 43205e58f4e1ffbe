// SPDX-License-Identifier: MIT OR Apache-2.0
use faer::Mat;
use mtb_operator::dense::Watch;
use mtb_operator::{Error, Monitor};

use super::factor::{Lu, Small};
use super::influence::Influence;
use crate::sliding::SlidingContact;

/// The contact's equations on an active set, solved with factors made for a set and a friction of the past.
///
/// With `F` the points factorised, `E` those that came since and `L` those that left, the equations on
/// `F - L + E` with the rigid motions are those on `F` bordered by the rows and columns of the
/// motions, of `E`, and of unit vectors on `L`. Columns once solved are kept until the next factors.
pub(super) struct Bordered {
    lu: Lu,
    factorised: Vec<usize>,
    place: Vec<usize>,
    drag: Vec<f64>,
    entered: Vec<Option<Entered>>,
    left: Vec<Option<Vec<f64>>>,
    motions: Vec<Column>,
    now: Now,
    work: Work,
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

impl Bordered {
    pub(super) fn new(
        influence: &Influence,
        drag: &[f64],
        set: &[usize],
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let n = influence.points();
        let mut matrix = Mat::zeros(set.len(), set.len());
        for (j, &point) in set.iter().enumerate() {
            let column = matrix.col_as_slice_mut(j);
            for (a, value) in column.iter_mut().zip(influence.column(point, drag, set)) {
                *a = value;
            }
        }
        let mut place = vec![ABSENT; n];
        for (i, &point) in set.iter().enumerate() {
            place[point] = i;
        }
        Ok(Self {
            lu: Lu::of(matrix, monitor)?,
            factorised: set.to_vec(),
            place,
            drag: drag.to_vec(),
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
        })
    }

    /// Whether the set is the one factorised.
    pub(super) fn holds(&self, active: &[bool]) -> bool {
        self.place
            .iter()
            .zip(active)
            .all(|(place, active)| (*place != ABSENT) == *active)
    }

    /// Whether the way to the set `active` is so long that new factors are cheaper.
    pub(super) fn is_far_from(&self, active: &[bool]) -> bool {
        let (mut changes, mut unknown) = (0, 0);
        for (point, active) in active.iter().enumerate() {
            let there = self.place[point] != ABSENT;
            if there != *active {
                changes += 1;
                let known = if there {
                    self.left[point].is_some()
                } else {
                    self.entered[point].is_some()
                };
                unknown += usize::from(!known);
            }
        }
        let k = self.factorised.len();
        changes > 4 + k / 8 || unknown > 4 + k / 16
    }

    /// Whether the factors are those of `drag` itself.
    pub(super) fn is_exact(&self, drag: &[f64]) -> bool {
        self.drag == drag
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
        for &(_, point) in &self.now.entered {
            if self.entered[point].is_none() {
                let mut solved: Vec<f64> = influence
                    .column(point, &self.drag, &self.factorised)
                    .collect();
                self.lu.solve(&mut solved, &mut self.work.lu);
                let row = self
                    .factorised
                    .iter()
                    .map(|&j| influence.entry(point, j, &self.drag));
                self.entered[point] = Some(Entered {
                    row: row.collect(),
                    solved,
                });
                solves += 1;
                watch.spend(each)?;
            }
        }
        for &place in &self.now.left {
            let kept = &mut self.left[self.factorised[place]];
            if kept.is_none() {
                let mut solved = vec![0.0; self.factorised.len()];
                solved[place] = -1.0;
                self.lu.solve(&mut solved, &mut self.work.lu);
                *kept = Some(solved);
                solves += 1;
                watch.spend(each)?;
            }
        }
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
        for (solved, t) in columns.zip(&self.work.t) {
            for (y, s) in self.work.y.iter_mut().zip(solved) {
                *y -= t * s;
            }
        }
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
                schur[(m + i, m + j)] += influence.entry(point, other, &self.drag);
            }
        }
        schur
    }
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // four sums, so that the products need not wait for each other
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4
        .remainder()
        .iter()
        .zip(b4.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    rest + sums.iter().sum::<f64>()
}
