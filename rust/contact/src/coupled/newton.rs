// SPDX-License-Identifier: MIT OR Apache-2.0
//! The semismooth Newton method, and its linear systems.

use faer::Mat;
use mtb_operator::dense::Lu;
use mtb_operator::{Monitor, report, reset_workers};

use super::inverse::Quick;
use super::{CoupledContact, CoupledState, PointState};
use crate::error::Error;

/// Newton steps for a push or a part of it.
const STEPS: usize = 40;
/// Corrections of an inverse by the compliance in one part.
const CORRECTIONS: usize = 3;
/// Share of a residual that a linear system may leave, at least and at most [EisenstatWalker1996].
const FORCING: f64 = 1e-5;
const LOOSE: f64 = 0.3;
/// Share of the tolerance that a linear system need not fall below.
const LEAST: f64 = 0.01;
/// Share of the pressure that a start may leave for no other to be tried.
const NEAR: f64 = 0.03;
/// Shortest step of the line search.
const SHORTEST: f64 = 1.0 / 64.0;
/// How much a step of the shortest may raise the residual ...
pub(super) const HIGHER: f64 = 1.5;
/// ... and the least share of a Newton step for that.
const LEAST_SHARE: f64 = 1e-8;
/// Relative difference of residuals that makes them the same: steps that come back go on in a circle.
const SAME: f64 = 1e-9;
/// Share of the pressure below which a residual that no longer falls may be the rounding of an inverse.
const ROUNDED: f64 = 1e-6;

/// Tractions (3n) and amplitudes, with the displacement (3n) that they make together with the offset.
pub(super) struct Unknowns {
    pub(super) traction: Vec<f64>,
    pub(super) motion: Vec<f64>,
    pub(super) displacement: Vec<f64>,
}

/// Unknowns, what each point does, and the residual.
pub(super) struct Iterate {
    pub(super) at: Unknowns,
    pub(super) points: Vec<PointState>,
    /// Unit vector of the slip at each point (n).
    pub(super) slip: Vec<[f64; 2]>,
    /// By how much a turn of the slip turns it less than the traction (n) [m/Pa].
    pub(super) curvature: Vec<f64>,
    pub(super) residual: f64,
}

/// The state at `push`, and whether the `inverse` served all the way; `None` if it was not found. Where no Newton step lowers
/// the residual, the shortest may raise it up to so many times as `higher` says.
pub(super) fn solve(
    contact: &CoupledContact,
    state: &CoupledState,
    push: &[f64],
    inverse: Option<Quick<'_>>,
    higher: f64,
    monitor: Monitor<'_>,
) -> Result<Option<(CoupledState, bool)>, Error> {
    let n = contact.points();
    // relative displacement since the last state, less the push: minus the slip; along the normal, the gap
    let offset: Vec<f64> = (0..3 * n)
        .map(|i| {
            if i < 2 * n {
                state.push[i] - push[i] - state.displacement[i]
            } else {
                contact.gap[i - 2 * n] + push[i]
            }
        })
        .collect();
    let (traction, motion) = (state.traction.clone(), state.motion.clone());
    let start = match &state.own {
        Some(own) => Unknowns {
            displacement: own.iter().zip(&offset).map(|(v, o)| v + o).collect(),
            traction,
            motion,
        },
        None => Unknowns::new(contact, &offset, traction, motion),
    };
    // of the pressure that the loads and the last state make; not of one that Newton steps pass on their way
    let loads = contact.work.iter().zip(&contact.reach);
    let loaded = loads.fold(0.0, |sum, (work, reach)| sum + (work / reach).powi(2));
    let least = norm(state.pressure())
        .max((n as f64 * loaded).sqrt())
        .max(f64::MIN_POSITIVE);
    let mut known = inverse.map(|inverse| inverse.about(contact, &offset, &start));
    let mut served = known.is_some();
    let mut corrections = CORRECTIONS;
    let mut iterate = Iterate::new(contact, start);
    // a push whose traction stays below the tolerance of the pressure still takes its linear step
    let mut fewest = usize::from(push != state.push);
    if let Some(known) = &mut known {
        let (start, is_answer) = known.start(contact, iterate, NEAR * least);
        iterate = start;
        if is_answer {
            fewest = 0;
        }
    }
    // of a residual that Newton's steps foretell badly the next linear system may leave more
    let mut forcing = (iterate.residual / least).sqrt().clamp(FORCING, LOOSE);
    let mut uphill: Vec<f64> = Vec::new();
    for count in 0..=STEPS {
        let size = norm(iterate.pressure()).max(least);
        let enough = contact.tolerance * size;
        if count >= fewest && iterate.residual <= enough {
            let Some(quick) = &mut known else {
                let state = iterate.into_state(push, &offset, count, size);
                return Ok(Some((state, served)));
            };
            // the products of an inverse are good to its rounding, and not to that of the compliance
            let Unknowns {
                traction,
                motion,
                displacement,
            } = iterate.at;
            let exact = quick.exact(contact, traction, motion);
            iterate = Iterate::new(contact, exact);
            if iterate.residual <= enough {
                quick.remember(&displacement);
                let state = iterate.into_state(push, &offset, count, size);
                return Ok(Some((state, served)));
            }
            if corrections > 0 {
                quick.correct(contact, &displacement, &iterate.at);
                corrections -= 1;
            } else {
                known = None;
            }
        }
        report(monitor, count, iterate.residual / size)?;
        // what balances loads is pressed: where the residual shows no point in contact, or too few, those that press stay
        if !contact.work.is_empty() && iterate.is_open() {
            iterate.close(contact);
        }
        let next = loop {
            let mut next = None;
            if let Some(known) = &mut known {
                let enough = (forcing * iterate.residual).max(LEAST * enough);
                next = known.linear_step(contact, &iterate, enough, monitor)?;
            }
            served &= next.is_some();
            if next.is_none() {
                next = iterate.linear_step(contact, &offset, monitor)?;
            }
            if next.is_some() || !iterate.close(contact) {
                break next;
            }
        };
        let Some(next) = next else {
            return Ok(None);
        };
        let (mut share, before) = (1.0, iterate.residual);
        let (next, is_less) = loop {
            let new = Iterate::new(contact, iterate.at.towards(&next, share));
            if new.residual < (1.0 - 0.1 * share) * before {
                break (new, true);
            }
            // uphill, but not over several hills at once
            if share <= SHORTEST && new.residual < higher * before || share <= LEAST_SHARE {
                break (new, false);
            }
            share *= 0.5;
        };
        iterate = next;
        if !is_less {
            let is_seen = |seen: &f64| (seen - iterate.residual).abs() < SAME * iterate.residual;
            if higher.is_finite() && uphill.iter().any(is_seen) {
                return Ok(None);
            }
            uphill.push(iterate.residual);
            if iterate.residual < ROUNDED * size
                && let Some(quick) = known.take()
            {
                let Unknowns {
                    traction, motion, ..
                } = iterate.at;
                iterate = Iterate::new(contact, quick.exact(contact, traction, motion));
                served = false;
            }
        }
        forcing = (iterate.residual / before).powi(2).clamp(FORCING, LOOSE);
    }
    Ok(None)
}

impl Unknowns {
    pub(super) fn new(
        contact: &CoupledContact,
        offset: &[f64],
        traction: Vec<f64>,
        motion: Vec<f64>,
    ) -> Self {
        let displacement = contact.matrix.displacement(&traction);
        Self::displaced(contact, offset, traction, motion, displacement)
    }

    /// With the displacement (3n) of the bodies alone.
    pub(super) fn displaced(
        contact: &CoupledContact,
        offset: &[f64],
        traction: Vec<f64>,
        motion: Vec<f64>,
        mut displacement: Vec<f64>,
    ) -> Self {
        contact.add_own(1.0, &traction, &motion, &mut displacement);
        for (v, o) in displacement.iter_mut().zip(offset) {
            *v += o;
        }
        Self {
            traction,
            motion,
            displacement,
        }
    }

    /// So much of the way to others, to which all of them change in proportion.
    fn towards(&self, to: &Self, share: f64) -> Self {
        let between = |from: &[f64], to: &[f64]| -> Vec<f64> {
            if share == 1.0 {
                return to.to_vec();
            }
            let pairs = from.iter().zip(to);
            pairs.map(|(a, b)| a + share * (b - a)).collect()
        };
        Self {
            traction: between(&self.traction, &to.traction),
            motion: between(&self.motion, &to.motion),
            displacement: between(&self.displacement, &to.displacement),
        }
    }
}

impl Iterate {
    pub(super) fn new(contact: &CoupledContact, at: Unknowns) -> Self {
        let n = contact.points();
        let Unknowns {
            traction,
            motion: _,
            displacement,
        } = &at;
        let normal = contact.matrix.stiffness[1];
        let mut points = vec![PointState::Open; n];
        let mut slip = vec![[0.0; 2]; n];
        let mut curvature = vec![0.0; n];
        let mut squares = 0.0;
        for i in 0..n {
            let (q, p) = ([traction[i], traction[n + i]], traction[2 * n + i]);
            let wanted = p - normal * displacement[2 * n + i];
            let mut aim = [0.0; 2];
            if wanted > 0.0 {
                (points[i], slip[i], curvature[i], aim) = rubbing(contact, &at, i);
            }
            let rest = p - wanted.max(0.0);
            squares += (q[0] - aim[0]).powi(2) + (q[1] - aim[1]).powi(2) + rest * rest;
        }
        let mut unbalanced = 0.0;
        for (k, reach) in contact.reach.iter().enumerate() {
            let shape = contact.motions.col(k).iter().zip(traction);
            let on_areas = shape.zip(contact.area.iter().cycle());
            let by_contact: f64 = on_areas.map(|((m, t), area)| m * area * t).sum();
            unbalanced += ((by_contact + contact.work[k]) / reach).powi(2);
        }
        Self {
            at,
            points,
            slip,
            curvature,
            residual: (squares + n as f64 * unbalanced).sqrt(),
        }
    }

    fn is_open(&self) -> bool {
        self.points.iter().all(|point| *point == PointState::Open)
    }

    /// Brings open points that press into contact; whether there are any.
    fn close(&mut self, contact: &CoupledContact) -> bool {
        let mut any = false;
        for i in 0..self.points.len() {
            if self.points[i] == PointState::Open && self.pressure()[i] > 0.0 {
                (self.points[i], self.slip[i], self.curvature[i], _) =
                    rubbing(contact, &self.at, i);
                any = true;
            }
        }
        any
    }

    fn pressure(&self) -> &[f64] {
        &self.at.traction[2 * self.points.len()..]
    }

    fn into_state(
        mut self,
        push: &[f64],
        offset: &[f64],
        iterations: usize,
        size: f64,
    ) -> CoupledState {
        let n = self.points.len();
        for (v, o) in self.at.displacement.iter_mut().zip(offset) {
            *v -= o;
        }
        // what the last damped step left at open points is below the tolerance
        for (i, t) in self.at.traction.iter_mut().enumerate() {
            if self.points[i % n] == PointState::Open {
                *t = 0.0;
            }
        }
        CoupledState {
            traction: self.at.traction,
            motion: self.at.motion,
            push: push.to_vec(),
            displacement: self.at.displacement,
            points: self.points,
            iterations,
            path_error: f64::INFINITY,
            residual: self.residual / size,
            own: None,
        }
    }

    /// Tractions and amplitudes that meet the conditions linearised; `None` for a singular matrix.
    fn linear_step(
        &self,
        contact: &CoupledContact,
        offset: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Option<Unknowns>, Error> {
        let (n, m) = (contact.points(), contact.work.len());
        let closed: Vec<usize> = (0..n)
            .filter(|&i| self.points[i] != PointState::Open)
            .collect();
        let k = closed.len();
        let free: Vec<usize> = (0..3)
            .flat_map(|c| closed.iter().map(move |i| c * n + i))
            .collect();
        let mut matrix = Mat::zeros(3 * k + m, 3 * k + m);
        let mut right = Mat::zeros(3 * k + m, 1);
        for (column, mut out) in matrix.col_iter_mut().enumerate() {
            let (shape, unit) = if column < 3 * k {
                (contact.matrix.compliance.col(free[column]), 1.0)
            } else {
                let motion = column - 3 * k;
                (contact.motions.col(motion), contact.units[motion])
            };
            for (i, &point) in closed.iter().enumerate() {
                let [x, y, gap] = [0, 1, 2].map(|c| unit * shape[c * n + point]);
                if self.points[point] == PointState::Slip {
                    // the slip keeps its direction
                    let [c, s] = self.slip[point];
                    out[k + i] = c * y - s * x;
                } else {
                    out[i] = x;
                    out[k + i] = y;
                }
                out[2 * k + i] = gap;
            }
            if column < 3 * k {
                let area = contact.area[free[column] % n];
                for row in 0..m {
                    out[3 * k + row] = contact.motions[(free[column], row)] * area;
                }
            }
        }
        for (i, &point) in closed.iter().enumerate() {
            let [x, y] = [offset[point], offset[n + point]];
            if self.points[point] == PointState::Slip {
                // the traction follows the pressure along the slip, and turns with it
                let [c, s] = self.slip[point];
                matrix[(i, i)] = c;
                matrix[(i, k + i)] = s;
                matrix[(i, 2 * k + i)] = -contact.friction[point];
                matrix[(k + i, i)] -= self.curvature[point] * s;
                matrix[(k + i, k + i)] += self.curvature[point] * c;
                right[(k + i, 0)] = s * x - c * y;
            } else {
                right[(i, 0)] = -x;
                right[(k + i, 0)] = -y;
            }
            if let Some(own) = contact.diagonal.get(point) {
                matrix[(2 * k + i, 2 * k + i)] += own;
            }
            right[(2 * k + i, 0)] = -offset[2 * n + point];
        }
        for row in 0..m {
            right[(3 * k + row, 0)] = -contact.work[row];
        }
        // only the way from here is solved for, so that its rounding is that of the way
        let here = Mat::from_fn(3 * k + m, 1, |row, _| match row.checked_sub(3 * k) {
            None => self.at.traction[free[row]],
            Some(motion) => self.at.motion[motion] / contact.units[motion],
        });
        right -= &matrix * &here;
        let Some(scales) = even_rows(&mut matrix) else {
            return Ok(None);
        };
        for (row, scale) in scales.iter().enumerate() {
            right[(row, 0)] /= scale;
        }
        let par = faer::get_global_parallelism();
        let way = Lu::new(matrix, par, monitor)?.solve(right.as_ref(), par, monitor)?;
        reset_workers();
        if !way.is_all_finite() {
            return Ok(None);
        }
        let found = here + way;
        let mut traction = vec![0.0; 3 * n];
        for (row, &place) in free.iter().enumerate() {
            traction[place] = found[(row, 0)];
        }
        let motion = (0..m)
            .map(|row| contact.units[row] * found[(3 * k + row, 0)])
            .collect();
        Ok(Some(Unknowns::new(contact, offset, traction, motion)))
    }
}

/// What a point in contact does, the unit vector of its slip, by how much a turn of it turns it less than the traction, and
/// the traction that its friction allows.
fn rubbing(
    contact: &CoupledContact,
    at: &Unknowns,
    i: usize,
) -> (PointState, [f64; 2], f64, [f64; 2]) {
    let n = contact.points();
    let tangential = contact.matrix.stiffness[0];
    let z = [i, n + i].map(|k| at.traction[k] - tangential * at.displacement[k]);
    let length = z[0].hypot(z[1]);
    let bound = contact.friction[i] * at.traction[2 * n + i].max(0.0);
    if length <= bound {
        return (PointState::Stick, [0.0; 2], 0.0, z);
    }
    let slip = z.map(|z| z / length);
    let curvature = (length / bound.max(1e-9 * length) - 1.0) / tangential;
    (PointState::Slip, slip, curvature, slip.map(|s| bound * s))
}

/// Brings the rows of a matrix to like sizes, displacements over the compliance, forces over the area: by what each was
/// divided. `None` if a row is empty.
pub(super) fn even_rows(matrix: &mut Mat<f64>) -> Option<Vec<f64>> {
    let rows = 0..matrix.nrows();
    let scales: Vec<f64> = rows.map(|row| matrix.row(row).norm_max()).collect();
    if scales.contains(&0.0) {
        return None;
    }
    for column in matrix.col_iter_mut() {
        for (a, scale) in column.iter_mut().zip(&scales) {
            *a /= scale;
        }
    }
    Some(scales)
}

pub(super) fn norm(values: &[f64]) -> f64 {
    faer::ColRef::from_slice(values).norm_l2()
}
