// SPDX-License-Identifier: MIT OR Apache-2.0
//! The thesis' incremental scheme [Steininger2025, 2.2]: the upper body is lowered in steps, and after each
//! step pressure, friction, back-deformation and normals follow one another.
//!
//! Kept because users will want to compare: [`crate::sliding`] solves the same contact in one
//! complementarity problem, without steps, tolerances or a loading history that a steadily sliding
//! contact does not have.

mod side;
mod surface;

use mtb_complementarity::linear::{Options, Problem, Status, solve};
use mtb_operator::{Compliance, Component, Monitor, check_factors, report};

use crate::error::{Error, check, check_positive};
use side::Side;
use surface::{add, dot};

/// Two bodies with corresponding points, one pressed into the other along -z.
pub struct IncrementalContact<'a> {
    /// The lower body; `None` if rigid.
    pub lower: Option<&'a dyn Compliance>,
    /// The upper body; `None` if rigid.
    pub upper: Option<&'a dyn Compliance>,
    /// Points of the lower surface, x, then y, then z (3n) [m].
    pub lower_points: &'a [f64],
    /// The corresponding points of the upper surface before contact (3n) [m].
    pub upper_points: &'a [f64],
    /// Grids (points along x, points along y) that make up the points, one after another.
    pub grids: &'a [(usize, usize)],
    /// Area of each point (n) [m2].
    pub area: &'a [f64],
    /// Friction coefficient at each point (n).
    pub friction: &'a [f64],
    /// Motion of the upper body over the lower one, any length, zero if nothing slides.
    pub direction: [f64; 3],
    /// Force that presses the upper body down [N].
    pub force: f64,
}

/// The parameters of the scheme, thesis Table 2.1.
#[derive(Clone, Copy, Debug)]
pub struct IncrementalOptions {
    /// `i_estimated steps`: load increments in which the estimated approach is cut.
    pub estimated_steps: usize,
    /// `epsilon_force tolerance` [N].
    pub force_tolerance: f64,
    /// `epsilon_distance tolerance` [m]: surfaces closer than this may come into contact, points
    /// farther apart have lost theirs; `None` takes twice the first increment.
    pub distance_tolerance: Option<f64>,
    /// Times one increment is resolved at most (thesis: about three suffice, up to 20).
    pub max_resolutions: usize,
    /// Times lost contacts are released within one increment at most.
    pub max_releases: usize,
    /// Load increments at most, those to meet the force included.
    pub max_increments: usize,
}

/// How the scheme ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IncrementalStatus {
    /// The force is met and the last increment is resolved.
    Converged,
    /// The increments ran out before the force was met.
    IncrementLimit,
    /// The force is met, but in the last increment the surfaces still intersect, or points under
    /// pressure are apart.
    Unresolved,
    /// A complementarity problem on the way has no solution.
    NoSolution,
}

/// Where the scheme ended.
#[derive(Clone, Debug)]
pub struct IncrementalSolution {
    /// How it ended; only [`IncrementalStatus::Converged`] is a solution, of the scheme's own conditions.
    pub status: IncrementalStatus,
    /// Pressure on the lower body (n) [Pa].
    pub pressure: Vec<f64>,
    /// Friction on the lower body, x, then y, then z (3n) [Pa].
    pub traction: Vec<f64>,
    /// Distance of corresponding points along the normal of the lower body (n) [m].
    pub gap: Vec<f64>,
    /// Elastic displacement of the lower body, x, then y, then z (3n) [m].
    pub lower_displacement: Vec<f64>,
    /// Elastic displacement of the upper body (3n) [m].
    pub upper_displacement: Vec<f64>,
    /// Normals of the deformed lower surface, towards the upper body (3n).
    pub normal: Vec<f64>,
    /// How far the upper body was lowered [m].
    pub approach: f64,
    /// Vertical force on the lower body [N].
    pub force: f64,
    /// Largest violation of the contact conditions, relative to the largest pressure and the approach.
    pub residual: f64,
    /// Pressures of the two bodies, which the scheme solves apart: largest difference over the largest pressure.
    pub imbalance: f64,
    /// Load increments, those taken back included.
    pub increments: usize,
    /// Resolutions of all increments.
    pub resolutions: usize,
    /// Complementarity problems solved, two a resolution.
    pub problems: usize,
    /// Active sets of all of them.
    pub active_sets: usize,
    /// Releases of lost contacts.
    pub releases: usize,
    /// Approach [m] and force [N] after each increment.
    pub history: Vec<(f64, f64)>,
}

/// What an increment leaves of a penetration, relative to the increment, when it counts as resolved.
const RESOLVED: f64 = 1e-4;

/// Runs the incremental scheme.
///
/// Each increment lowers the upper body, then repeats: the distance of corresponding points along each
/// body's normals; one complementarity problem per body, in the pressure it gains, with the stiffness of
/// both; friction from the pressure; the displacements of all of it. Points that lost contact are
/// released as far as they spring back to the other surface; then the normals turn with the surfaces. Once the
/// force is exceeded the last increment is taken back and replaced by shorter ones.
///
/// # Errors
/// Wrong lengths, numbers that are not finite or not positive where they must be, more points than the memory
/// holds, an interruption.
pub fn incremental(
    contact: &IncrementalContact<'_>,
    options: &IncrementalOptions,
    monitor: Monitor<'_>,
) -> Result<IncrementalSolution, Error> {
    let n = contact.check(options)?;
    check_factors(n, memory(contact, n))?;
    let mut run = Run::new(contact, options, n);
    let mut step = run.first_step();
    run.reach = options.distance_tolerance.unwrap_or(2.0 * step);
    let mut state = State::new(contact, n);
    let mut status = IncrementalStatus::IncrementLimit;
    let mut overshot = false;
    let mut history: Vec<(f64, f64)> = vec![(0.0, 0.0)];
    for _ in 0..options.max_increments {
        let mut next = state.clone();
        next.lower_by(step);
        let Some(resolved) = run.increment(&mut next, step, monitor)? else {
            status = IncrementalStatus::NoSolution;
            break;
        };
        let force = next.lower.vertical_force(contact.area);
        history.push((next.approach, force));
        let before = state.lower.vertical_force(contact.area);
        let missing = contact.force - before;
        if force > contact.force + options.force_tolerance {
            // take it back; the force grows faster than linearly, so the secant stays short of it
            overshot = true;
            step *= (missing / (force - before)).clamp(0.05, 0.95);
            continue;
        }
        state = next;
        state.resolved = resolved;
        if (contact.force - force).abs() <= options.force_tolerance {
            status = if resolved {
                IncrementalStatus::Converged
            } else {
                IncrementalStatus::Unresolved
            };
            break;
        }
        if overshot && force > before {
            step *= (contact.force - force) / (force - before);
        }
    }
    Ok(run.finish(&state, status, history))
}

/// Memory [bytes]: the matrix, the active block of a complementarity problem, and what its factors take.
fn memory(contact: &IncrementalContact<'_>, n: usize) -> f64 {
    let bodies = [contact.lower, contact.upper].into_iter().flatten();
    24.0 * (n as f64).powi(2) + bodies.map(Compliance::influence_memory).sum::<f64>()
}

/// Counts and the matrices that stay the same.
struct Run<'a> {
    contact: &'a IncrementalContact<'a>,
    options: &'a IncrementalOptions,
    /// Normal influence of both bodies, n x n.
    normal: Vec<f64>,
    is_symmetric: bool,
    /// Distance below which a point may carry pressure.
    reach: f64,
    n: usize,
    increments: usize,
    resolutions: usize,
    problems: usize,
    active_sets: usize,
    releases: usize,
}

#[derive(Clone)]
struct State<'a> {
    lower: Side<'a>,
    upper: Side<'a>,
    approach: f64,
    resolved: bool,
}

impl<'a> State<'a> {
    fn new(contact: &IncrementalContact<'a>, n: usize) -> Self {
        let grids = contact.grids;
        let d = contact.direction;
        let opposite = d.map(|d| -d);
        Self {
            lower: Side::new(contact.lower, contact.lower_points, grids, n, 1.0, d),
            upper: Side::new(
                contact.upper,
                contact.upper_points,
                grids,
                n,
                -1.0,
                opposite,
            ),
            approach: 0.0,
            resolved: true,
        }
    }

    fn lower_by(&mut self, step: f64) {
        self.approach += step;
        for point in &mut self.upper.position {
            point[2] -= step;
        }
    }

    /// Distance to the other surface along each body's own normals, negative where they intersect.
    fn distances(&self) -> [Vec<f64>; 2] {
        let (lower, upper) = (&self.lower, &self.upper);
        let n = lower.position.len();
        let apart: Vec<[f64; 3]> = (0..n)
            .map(|i| add(upper.position[i], -1.0, lower.position[i]))
            .collect();
        [
            (0..n).map(|i| dot(apart[i], lower.normal[i])).collect(),
            (0..n).map(|i| -dot(apart[i], upper.normal[i])).collect(),
        ]
    }
}

impl<'a> Run<'a> {
    fn new(contact: &'a IncrementalContact<'a>, options: &'a IncrementalOptions, n: usize) -> Self {
        let mut normal = vec![0.0; n * n];
        for body in [contact.lower, contact.upper].into_iter().flatten() {
            body.add_influence(Component::Normal, Component::Normal, 1.0, &mut normal);
        }
        let largest = normal.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
        let is_symmetric = (0..n).all(|i| {
            (0..i).all(|j| (normal[i * n + j] - normal[j * n + i]).abs() <= 1e-13 * largest)
        });
        Self {
            contact,
            options,
            normal,
            is_symmetric,
            reach: 0.0,
            n,
            increments: 0,
            resolutions: 0,
            problems: 0,
            active_sets: 0,
            releases: 0,
        }
    }

    /// The estimated approach over the estimated number of steps.
    ///
    /// The estimate treats the pair as an elastic foundation: at every point where the undeformed
    /// bodies overlap, the pressure is the overlap over the displacement by unit pressure on all of them.
    fn first_step(&self) -> f64 {
        let (lower, upper) = (self.contact.lower_points, self.contact.upper_points);
        let gap: Vec<f64> = (0..self.n)
            .map(|i| upper[2 * self.n + i] - lower[2 * self.n + i])
            .collect();
        let closest = gap.iter().copied().fold(f64::INFINITY, f64::min);
        let mut order: Vec<usize> = (0..self.n).collect();
        order.sort_by(|&i, &j| gap[i].total_cmp(&gap[j]));
        // points join one by one, in blocks of about a hundredth of them
        let mut compliance = vec![0.0; self.n];
        let (mut from, mut approach) = (0, closest);
        while from < self.n {
            let to = (from + self.n / 100 + 1).min(self.n);
            for i in 0..self.n {
                let row = &self.normal[i * self.n..(i + 1) * self.n];
                compliance[i] += order[from..to].iter().map(|&j| row[j]).sum::<f64>();
            }
            let stiffness: f64 = order[..to]
                .iter()
                .map(|&i| self.contact.area[i] / compliance[i])
                .sum();
            let closed: f64 = order[..to]
                .iter()
                .map(|&i| self.contact.area[i] / compliance[i] * gap[i])
                .sum();
            approach = (self.contact.force + closed) / stiffness;
            if to == self.n || approach <= gap[order[to]] {
                break;
            }
            from = to;
        }
        approach.max(closest) / self.options.estimated_steps as f64
    }

    /// Resolves one increment; whether that succeeded, `None` where a complementarity problem has no solution.
    fn increment(
        &mut self,
        state: &mut State<'_>,
        step: f64,
        monitor: Monitor<'_>,
    ) -> Result<Option<bool>, Error> {
        self.increments += 1;
        let before = [&state.lower, &state.upper].map(|s| s.position.clone());
        let limit = RESOLVED * step.abs();
        let Some(mut resolved) = self.resolve(state, limit, monitor)? else {
            return Ok(None);
        };
        for _ in 0..self.options.max_releases {
            if !self.release(state) {
                break;
            }
            self.releases += 1;
            match self.resolve(state, limit, monitor)? {
                Some(r) => resolved = r,
                None => return Ok(None),
            }
        }
        resolved &= !self.is_apart(state);
        state.upper.turn(&before[1], self.contact.grids);
        state.lower.turn(&before[0], self.contact.grids);
        Ok(Some(resolved))
    }

    fn resolve(
        &mut self,
        state: &mut State<'_>,
        limit: f64,
        monitor: Monitor<'_>,
    ) -> Result<Option<bool>, Error> {
        for resolution in 0..=self.options.max_resolutions {
            let distances = state.distances();
            let deepest = -distances[0].iter().copied().fold(f64::INFINITY, f64::min);
            if deepest <= limit {
                return Ok(Some(true));
            }
            if resolution == self.options.max_resolutions {
                break;
            }
            self.resolutions += 1;
            report(monitor, self.resolutions, deepest / state.approach.abs())?;
            let gained = [
                self.pressure(&distances[0], &state.lower.pressure, monitor)?,
                self.pressure(&distances[1], &state.upper.pressure, monitor)?,
            ];
            let [Some(lower), Some(upper)] = gained else {
                return Ok(None);
            };
            state.lower.load(&lower, self.contact.friction);
            state.upper.load(&upper, self.contact.friction);
        }
        Ok(Some(false))
    }

    /// Pressure that one body must gain to close a distance, with the normal stiffness of both.
    fn pressure(
        &mut self,
        distance: &[f64],
        carried: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<Option<Vec<f64>>, Error> {
        let near: Vec<usize> = (0..self.n)
            .filter(|&i| distance[i] < self.reach || carried[i] > 0.0)
            .collect();
        let k = near.len();
        let mut matrix = Vec::with_capacity(k * k);
        for &i in &near {
            matrix.extend(near.iter().map(|&j| self.normal[i * self.n + j]));
        }
        let offset: Vec<f64> = near.iter().map(|&i| distance[i]).collect();
        let problem = Problem {
            matrix: &matrix,
            offset: &offset,
            border: None,
            symmetric: self.is_symmetric,
            limit: None,
        };
        let start = Some(offset.iter().map(|d| *d < 0.0).collect());
        let solution = solve(&problem, &Options { start, kept: None }, monitor)?;
        self.problems += 1;
        self.active_sets += solution.iterations;
        if solution.status != Status::Solved {
            return Ok(None);
        }
        let mut gained = vec![0.0; self.n];
        for (&i, p) in near.iter().zip(&solution.pressure) {
            gained[i] = *p;
        }
        Ok(Some(gained))
    }

    fn lost(&self, state: &State<'_>) -> (Vec<usize>, Vec<f64>) {
        let [distance, _] = state.distances();
        let lost = (0..self.n)
            .filter(|&i| distance[i] > self.reach && state.lower.pressure[i] > 0.0)
            .collect();
        (lost, distance)
    }

    fn is_apart(&self, state: &State<'_>) -> bool {
        !self.lost(state).0.is_empty()
    }

    /// Releases points that carry pressure but lost contact, by the share of the pressure that brings
    /// them back to the other surface, all of it where that does not suffice.
    fn release(&self, state: &mut State<'_>) -> bool {
        let (lost, distance) = self.lost(state);
        if lost.is_empty() {
            return false;
        }
        let mut share = vec![0.0; self.n];
        for &i in &lost {
            let spring: f64 = lost
                .iter()
                .map(|&j| self.normal[i * self.n + j] * state.lower.pressure[j])
                .sum();
            share[i] = (distance[i] / spring).clamp(0.0, 1.0);
        }
        state.lower.release(&share);
        state.upper.release(&share);
        true
    }

    fn finish(
        &self,
        state: &State<'_>,
        status: IncrementalStatus,
        history: Vec<(f64, f64)>,
    ) -> IncrementalSolution {
        let [gap, _] = state.distances();
        let pressure = state.lower.pressure.clone();
        let largest = pressure.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let residual = gap.iter().zip(&pressure).fold(0.0, |r: f64, (g, p)| {
            r.max((g / state.approach.abs()).min(p / largest).abs())
        });
        let imbalance = pressure
            .iter()
            .zip(&state.upper.pressure)
            .fold(0.0, |d: f64, (a, b)| d.max((a - b).abs()))
            / largest;
        let planes = |field: &[[f64; 3]]| -> Vec<f64> {
            (0..3)
                .flat_map(|c| field.iter().map(move |v| v[c]))
                .collect()
        };
        IncrementalSolution {
            status,
            traction: planes(&state.lower.friction),
            pressure,
            gap,
            lower_displacement: planes(&state.lower.displacement),
            upper_displacement: planes(&state.upper.displacement),
            normal: planes(&state.lower.normal),
            approach: state.approach,
            force: state.lower.vertical_force(self.contact.area),
            residual,
            imbalance,
            increments: self.increments,
            resolutions: self.resolutions,
            problems: self.problems,
            active_sets: self.active_sets,
            releases: self.releases,
            history,
        }
    }
}

impl IncrementalContact<'_> {
    fn check(&self, options: &IncrementalOptions) -> Result<usize, Error> {
        let n = self.grids.iter().map(|(nx, ny)| nx * ny).sum();
        check("lower_points", self.lower_points, 3 * n)?;
        check("upper_points", self.upper_points, 3 * n)?;
        check("area", self.area, n)?;
        check("friction", self.friction, n)?;
        check("direction", &self.direction, 3)?;
        for body in [self.lower, self.upper].into_iter().flatten() {
            if body.points() != n {
                return Err(Error::Shape {
                    name: "points of a body",
                    expected: n,
                    found: body.points(),
                });
            }
        }
        for (name, values) in [
            ("grid points", n),
            ("estimated_steps", options.estimated_steps),
        ] {
            check_positive(name, values as f64)?;
        }
        let bodies = [self.lower, self.upper].into_iter().flatten().count();
        check_positive("number of elastic bodies", bodies as f64)?;
        if let Some(index) = self.area.iter().position(|v| *v <= 0.0) {
            let value = self.area[index];
            return Err(Error::NotPositive {
                name: "area",
                index,
                value,
            });
        }
        if let Some(index) = self.friction.iter().position(|v| *v < 0.0) {
            let value = self.friction[index];
            return Err(Error::Negative {
                name: "friction",
                index,
                value,
            });
        }
        check_positive("force", self.force)?;
        check_positive("force_tolerance", options.force_tolerance)?;
        if let Some(distance) = options.distance_tolerance {
            check_positive("distance_tolerance", distance)?;
        }
        Ok(n)
    }
}

#[cfg(test)]
mod tests;
