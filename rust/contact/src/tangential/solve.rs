// SPDX-License-Identifier: MIT OR Apache-2.0
use std::cell::Cell;

use mtb_complementarity::discs::{
    DependentRadius, DiscOptions, DiscProblem, DiscSolution, DiscStart, DiscState, Preconditioner,
    Radius, Resultant, solve_discs,
};
use mtb_operator::{LinearOperator, Monitor};

use super::bound::{SlipBound, past};
use super::checks::check_problem;
use super::faces::{Faces, LedRadius, OnCells, OnCellsInverse};
use super::given::offset;
use super::heated::with_temperature;
use super::operators::PatchOperators;
use super::plastic::Yielding;
use super::problem::{Drive, TangentialProblem, TangentialSolution};
use crate::Error;
use crate::friction::{Friction, Memory, SlipFriction, SlipLaw};

/// Residual to which the coarser grids are solved: they only provide a start.
const COARSE_TOLERANCE: f64 = 3e-3;
/// Residual of problems with fixed coefficients on the way to friction that depends on the slip.
const APPROACH_TOLERANCE: f64 = 1e-3;
const COARSE_ITERATIONS: usize = 40;
const FINE_ITERATIONS: usize = 200;
/// Attempts at friction that depends on the slip, and fixed problems before each.
const ROUNDS: usize = 4;
const STEPS_A_ROUND: usize = 5;

/// Shares of the hardening of a layer by which it is approached.
const HARDENING: [f64; 5] = [0.0, 0.5, 0.8, 0.95, 1.0];

/// Solves a shift, a step of transient rolling, or steady rolling.
///
/// Semismooth Newton on discs, started from coarser grids, all products by the Fourier transform. In
/// rolling the rigid slip is taken at `x + d / 6`, as CONTACT does, so that fields with spin agree
/// cell by cell; the difference to `x` vanishes with the step. It is taken at `x + d / 2` where slip is of second
/// order, [`PatchOperators::of_second_order`].
///
/// # Errors
/// [`Error::Shape`], [`Error::NotFinite`], [`Error::Negative`], [`Error::Number`] for bad input,
/// [`Error::NoContact`], [`Error::ForceTooLarge`]; the monitor's interruption. Not converging is no
/// error: see [`TangentialSolution::converged`].
pub fn solve(
    operators: &PatchOperators,
    problem: &TangentialProblem<'_>,
    monitor: Monitor<'_>,
) -> Result<TangentialSolution, Error> {
    check_problem(operators, problem)?;
    if let Friction::TemperatureDependent(law) = problem.friction {
        return with_temperature(operators, problem, law, monitor);
    }
    let offset = offset(operators, problem);
    let mut cascade = Cascade::new(operators, problem, offset);
    if let Friction::StaticKinetic { at_rest, kinetic } = problem.friction {
        cascade.solve_static_kinetic(*at_rest, *kinetic, monitor)
    } else {
        let solution = cascade.solve(monitor)?;
        Ok(cascade.finish(solution))
    }
}

/// Shares of what is given by which it is approached: the first, and the smallest.
const FIRST_PART: f64 = 0.25;
const SMALLEST_PART: f64 = 1e-3;

/// One problem on all grids, finest first.
pub(super) struct Cascade<'a> {
    operators: &'a PatchOperators,
    problem: &'a TangentialProblem<'a>,
    pressure: Vec<Vec<f64>>,
    /// Fixed coefficients of friction by level; empty if they depend on the slip.
    coefficient: Vec<Vec<f64>>,
    pub(super) offset: Vec<Vec<f64>>,
    /// Where slip of the finest grid is of second order; its offset is then that of the cells.
    pub(super) faces: Option<Faces>,
    coarse_iterations: usize,
    products: Cell<f64>,
    preconditionings: Cell<f64>,
}

impl<'a> Cascade<'a> {
    pub(super) fn new(
        operators: &'a PatchOperators,
        problem: &'a TangentialProblem<'a>,
        offset: Vec<f64>,
    ) -> Self {
        let n = problem.pressure.len();
        let fixed = match problem.friction {
            Friction::Coulomb(coefficient) => Some(coefficient.clone()),
            Friction::StaticKinetic { at_rest, .. } => Some(vec![*at_rest; n]),
            Friction::SpeedDependent { .. } | Friction::TemperatureDependent(_) => None,
        };
        let mut cascade = Self {
            operators,
            problem,
            pressure: vec![problem.pressure.to_vec()],
            coefficient: fixed.into_iter().collect(),
            offset: vec![offset],
            faces: operators.faces(problem.pressure),
            coarse_iterations: 0,
            products: Cell::new(0.0),
            preconditionings: Cell::new(0.0),
        };
        for (level, coarsening) in operators.coarsenings.iter().enumerate() {
            let pressure = cascade.pressure[level].clone();
            if let Some(coefficient) = cascade.coefficient.get(level) {
                let coarse = coarsening.weighted(coefficient, &pressure);
                cascade.coefficient.push(coarse);
            }
            let ones = vec![1.0; pressure.len()];
            let fine = &cascade.offset[level];
            let (first, second) = fine.split_at(ones.len());
            let mut coarse = coarsening.weighted(first, &ones);
            coarse.extend(coarsening.weighted(second, &ones));
            cascade.offset.push(coarse);
            cascade.pressure.push(coarsening.average(&pressure));
        }
        if let Some(faces) = &cascade.faces {
            faces.to_cells(&mut cascade.offset[0]);
        }
        cascade
    }

    /// Starts from the traction given, else on the coarsest grid without traction, and carries the solution
    /// down to the finest.
    fn solve(&mut self, monitor: Monitor<'_>) -> Result<DiscSolution, Error> {
        let is_forced = |d: &Drive| matches!(d, Drive::Force(_));
        let last = self.operators.levels.len() - 1;
        if let Some(traction) = self.problem.start
            && !self.problem.drive.iter().any(is_forced)
        {
            let near = DiscStart::At {
                field: traction.to_vec(),
                multipliers: Vec::new(),
            };
            let solution = self.solve_level(0, &near, monitor)?;
            if solution.converged {
                return Ok(solution);
            }
        }
        let is_start_inside = self.problem.drive.iter().any(is_forced);
        let mut start = if is_start_inside {
            DiscStart::Inside
        } else {
            DiscStart::At {
                field: vec![0.0; 2 * self.pressure[last].len()],
                multipliers: Vec::new(),
            }
        };
        for level in (1..=last).rev() {
            let coarse = self.solve_level(level, &start, monitor)?;
            self.coarse_iterations += coarse.iterations;
            let coarsening = &self.operators.coarsenings[level - 1];
            let (from, to) = (&self.pressure[level], &self.pressure[level - 1]);
            let n = from.len();
            let mut field = coarsening.prolong(&coarse.field[..n], from, to);
            field.extend(coarsening.prolong(&coarse.field[n..], from, to));
            start = DiscStart::At {
                field,
                multipliers: coarse.multipliers,
            };
        }
        let mut solution = self.solve_level(0, &start, monitor)?;
        let is_tried = is_start_inside && last == 0;
        if !solution.converged && !is_tried {
            // coarse grids do not know bodies that give way as a whole; from sticking on, these are as safe as others
            let mut inside = self.solve_level(0, &DiscStart::Inside, monitor)?;
            if !inside.converged && !is_start_inside && !self.coefficient.is_empty() {
                inside = self.by_parts(inside, monitor)?;
            }
            if inside.converged {
                solution = inside;
            }
        }
        if solution.converged {
            return Ok(solution);
        }
        match self.yielding(0) {
            Some(law) if !law.is_fixed() => self.approach_hardening(law, solution, monitor),
            _ if self.coefficient.is_empty() => self.approach_law(solution, monitor),
            _ => Ok(solution),
        }
    }

    /// Approaches what is given from nothing by parts, each from the one before; `failed` where these get too small.
    fn by_parts(
        &mut self,
        failed: DiscSolution,
        monitor: Monitor<'_>,
    ) -> Result<DiscSolution, Error> {
        let whole = self.offset[0].clone();
        let (mut done, mut part) = (0.0, FIRST_PART);
        let mut field = vec![0.0; whole.len()];
        let mut history = failed.history.clone();
        let mut found = None;
        while part >= SMALLEST_PART && done < 1.0 {
            let next = f64::min(done + part, 1.0);
            self.offset[0] = whole.iter().map(|o| next * o).collect();
            let start = DiscStart::At {
                field: field.clone(),
                multipliers: Vec::new(),
            };
            let solution = self.solve_level(0, &start, monitor);
            self.offset[0].clone_from(&whole);
            let solution = solution?;
            history.extend(&solution.history);
            if solution.converged {
                field.clone_from(&solution.field);
                (done, part) = (next, 2.0 * part);
                found = Some(solution);
            } else {
                part *= 0.25;
            }
        }
        match found {
            Some(solution) if done >= 1.0 => Ok(DiscSolution {
                iterations: history.len(),
                history,
                ..solution
            }),
            _ => Ok(failed),
        }
    }

    /// Approaches the hardening or softening of a layer from a layer without either, which is as safe as friction with
    /// fixed coefficients.
    fn approach_hardening(
        &self,
        mut law: Yielding,
        failed: DiscSolution,
        monitor: Monitor<'_>,
    ) -> Result<DiscSolution, Error> {
        let options = DiscOptions {
            tolerance: self.problem.tolerance,
            max_iterations: FINE_ITERATIONS,
        };
        let whole = law.hardening();
        let mut history = failed.history;
        let mut start = DiscStart::At {
            field: failed.field,
            multipliers: failed.multipliers,
        };
        let mut rounds = HARDENING.into_iter().peekable();
        loop {
            let share = rounds.next().unwrap_or(1.0);
            law.set_hardening(share * whole);
            let rest = law.at_rest();
            let radius = if law.is_fixed() {
                Radius::Fixed(&rest)
            } else {
                Radius::Dependent(&law)
            };
            let mut solution = self.solve_discs_at(0, &start, radius, options, monitor)?;
            history.extend(&solution.history);
            if !solution.converged || rounds.peek().is_none() {
                solution.converged &= rounds.peek().is_none();
                solution.iterations = history.len();
                solution.history = history;
                return Ok(solution);
            }
            start = DiscStart::At {
                field: solution.field,
                multipliers: solution.multipliers,
            };
        }
    }

    /// Approaches friction that depends on the slip through problems with fixed coefficients: each of them is
    /// safe, the coefficients move half of the way to their law, and Newton's method takes over from
    /// there. Where the law falls too steeply no state may exist that this could find.
    fn approach_law(
        &self,
        failed: DiscSolution,
        monitor: Monitor<'_>,
    ) -> Result<DiscSolution, Error> {
        let Friction::SpeedDependent { law, memory } = self.problem.friction else {
            return Ok(failed);
        };
        let n = self.problem.pressure.len();
        let mut history = failed.history.clone();
        let mut last = failed;
        let mut radius = vec![0.0; n];
        let still = vec![0.0; n];
        self.speed_dependent(0, law, *memory)
            .radius(&still, &mut radius);
        'rounds: for _ in 0..ROUNDS {
            for _ in 0..STEPS_A_ROUND {
                let start = DiscStart::At {
                    field: last.field,
                    multipliers: last.multipliers,
                };
                let options = DiscOptions {
                    tolerance: APPROACH_TOLERANCE.max(self.problem.tolerance),
                    max_iterations: FINE_ITERATIONS,
                };
                last = self.solve_discs_at(0, &start, Radius::Fixed(&radius), options, monitor)?;
                if last.iterations == 0 && !last.converged {
                    // the coefficients have fallen below what the force needs
                    break 'rounds;
                }
                let mut magnitude: Vec<f64> = (0..n)
                    .map(|i| match last.state[i] {
                        DiscState::Inside => 0.0,
                        // without friction, a point slips as well
                        _ => last.image[i].hypot(last.image[n + i]),
                    })
                    .collect();
                if let Some(faces) = &self.faces {
                    faces.lead(&mut magnitude);
                }
                let mut wanted = vec![0.0; n];
                self.speed_dependent(0, law, *memory)
                    .radius(&magnitude, &mut wanted);
                for (g, w) in radius.iter_mut().zip(wanted) {
                    *g += 0.5 * (w - *g);
                }
            }
            let start = DiscStart::At {
                field: last.field.clone(),
                multipliers: last.multipliers.clone(),
            };
            let mut attempt = self.solve_level(0, &start, monitor)?;
            history.extend(&attempt.history);
            if attempt.converged {
                attempt.iterations = history.len();
                attempt.history = history;
                return Ok(attempt);
            }
            last.state = attempt.state;
            last.image = attempt.image;
            last.radius = attempt.radius;
        }
        last.converged = false;
        last.iterations = history.len();
        last.history = history;
        Ok(last)
    }

    fn solve_level(
        &self,
        level: usize,
        start: &DiscStart,
        monitor: Monitor<'_>,
    ) -> Result<DiscSolution, Error> {
        let options = DiscOptions {
            tolerance: if level == 0 {
                self.problem.tolerance
            } else {
                COARSE_TOLERANCE.max(self.problem.tolerance)
            },
            max_iterations: match (level, self.coefficient.is_empty()) {
                (0, false) => FINE_ITERATIONS,
                _ => COARSE_ITERATIONS,
            },
        };
        if let Friction::SpeedDependent { law, memory } = self.problem.friction {
            let law = self.speed_dependent(level, law, *memory);
            return self.solve_discs_at(level, start, Radius::Dependent(&law), options, monitor);
        }
        match self.yielding(level) {
            Some(law) if !law.is_fixed() => {
                self.solve_discs_at(level, start, Radius::Dependent(&law), options, monitor)
            }
            law => {
                let fixed = law.map_or_else(|| self.bound_of_friction(level), |law| law.at_rest());
                self.solve_discs_at(level, start, Radius::Fixed(&fixed), options, monitor)
            }
        }
    }

    /// Traction bounds [Pa] of fixed coefficients of friction.
    fn bound_of_friction(&self, level: usize) -> Vec<f64> {
        self.coefficient[level]
            .iter()
            .zip(&self.pressure[level])
            .map(|(mu, p)| mu * p.max(0.0))
            .collect()
    }

    /// Traction bounds of a layer that yields, if there is one.
    fn yielding(&self, level: usize) -> Option<Yielding> {
        let plasticity = self.problem.plasticity.as_ref()?;
        let friction = self.bound_of_friction(level);
        Some(Yielding::new(
            self.operators,
            self.problem,
            plasticity,
            level,
            friction,
        ))
    }

    fn solve_discs_at(
        &self,
        level: usize,
        start: &DiscStart,
        radius: Radius<'_>,
        options: DiscOptions,
        monitor: Monitor<'_>,
    ) -> Result<DiscSolution, Error> {
        let here = &self.operators.levels[level];
        let resultants = self.resultants(level);
        let (single, single_inverse) = (here.slip.single(), here.inverse.single());
        // by a force that is given, lines took four times the products in single precision, or found no end
        let is_double = here.grid.ny == 1 || !resultants.is_empty();
        let (rough, preconditioner): (&dyn LinearOperator, &dyn Preconditioner) = if is_double {
            (&here.slip, &here.inverse)
        } else {
            (&single, &single_inverse)
        };
        // coarser grids only provide a start
        let faces = self.faces.as_ref().filter(|_| level == 0);
        let on_cells = |operator| faces.map(|faces| OnCells { faces, operator });
        let (whole, rough_on_cells) = (on_cells(&here.slip), on_cells(rough));
        let inverse = preconditioner;
        let inverse_on_cells = faces.map(|faces| OnCellsInverse { faces, inverse });
        let law = match (faces, radius) {
            (Some(faces), Radius::Dependent(law)) => Some(LedRadius { faces, law }),
            _ => None,
        };
        let radius = (law.as_ref()).map_or(radius, |law| Radius::Dependent(law));
        let problem = DiscProblem {
            operator: (whole.as_ref()).map_or(&here.slip, |whole| whole),
            rough: (rough_on_cells.as_ref()).map_or(rough, |rough| rough),
            preconditioner: (inverse_on_cells.as_ref()).map_or(preconditioner, |inverse| inverse),
            offset: &self.offset[level],
            radius,
            resultants: &resultants,
            diagonal: here.diagonal,
        };
        let solution = solve_discs(&problem, start, options, monitor)?;
        let size = here.grid.points() as f64 / self.operators.grid().points() as f64;
        let add = |count: &Cell<f64>, more: usize| count.set(count.get() + size * more as f64);
        add(&self.products, solution.products);
        add(&self.preconditionings, solution.preconditionings);
        Ok(solution)
    }

    pub(super) fn resultants(&self, level: usize) -> Vec<Resultant> {
        let grid = self.operators.levels[level].grid;
        let n = grid.points();
        let length = self.operators.motion.length();
        let mut resultants = Vec::new();
        for (c, drive) in self.problem.drive.iter().enumerate() {
            if let Drive::Force(value) = *drive {
                let mut direction = vec![0.0; 2 * n];
                direction[c * n..(c + 1) * n].fill(length);
                if let Some(faces) = self.faces.as_ref().filter(|_| level == 0) {
                    faces.to_cells(&mut direction);
                }
                let mut weight = vec![0.0; 2 * n];
                weight[c * n..(c + 1) * n].fill(grid.cell_area());
                resultants.push(Resultant {
                    direction,
                    weight,
                    value,
                    softness: 0.0,
                });
            }
        }
        resultants
    }

    pub(super) fn speed_dependent<'b>(
        &'b self,
        level: usize,
        law: &'b SlipLaw,
        memory: Option<Memory>,
    ) -> SlipBound<'b> {
        let pressure = &self.pressure[level];
        let past = memory.map(|memory| {
            let past = past(
                self.operators,
                self.problem,
                level,
                pressure,
                law,
                self.speed(),
            );
            (memory, past)
        });
        SlipBound {
            friction: SlipFriction::new(law, past),
            pressure,
            speed: self.speed(),
        }
    }

    /// Slip speed [m/s] per unit of the image.
    pub(super) fn speed(&self) -> f64 {
        self.problem.speed / self.operators.motion.length()
    }

    /// Points that slip get the kinetic coefficient, and keep it should they come to rest in the
    /// solution: a state that meets the law is reached after few solves, since points only enter.
    fn solve_static_kinetic(
        &mut self,
        at_rest: f64,
        kinetic: f64,
        monitor: Monitor<'_>,
    ) -> Result<TangentialSolution, Error> {
        let mut solution = self.solve(monitor)?;
        loop {
            let mut entered = false;
            let mut states = solution.state.clone();
            if let Some(faces) = &self.faces {
                faces.follow(&mut states);
            }
            for (mu, state) in self.coefficient[0].iter_mut().zip(&states) {
                if *state == DiscState::Rim && (*mu - at_rest).abs() <= 0.0 && at_rest > kinetic {
                    *mu = kinetic;
                    entered = true;
                }
            }
            if !entered || !solution.converged {
                return Ok(self.finish(solution));
            }
            let start = DiscStart::At {
                field: solution.field,
                multipliers: solution.multipliers,
            };
            let iterations = solution.iterations;
            solution = self.solve_level(0, &start, monitor)?;
            solution.iterations += iterations;
        }
    }

    fn finish(&self, solution: DiscSolution) -> TangentialSolution {
        let grid = self.operators.grid();
        let n = grid.points();
        let per_length = 1.0 / self.operators.motion.length();
        let mut multipliers = solution.multipliers.iter();
        let drive = self.problem.drive.map(|d| match d {
            Drive::Slip(value) => value,
            Drive::Force(_) => multipliers.next().copied().unwrap_or(0.0),
        });
        let area = grid.cell_area();
        let mut force = [0.0; 2];
        let mut spin_moment = 0.0;
        for k in 0..n {
            let x = self.problem.origin[0] + (k % grid.nx) as f64 * grid.dx;
            let y = self.problem.origin[1] + (k / grid.nx) as f64 * grid.dy;
            let q = [solution.field[k], solution.field[n + k]];
            force[0] += q[0] * area;
            force[1] += q[1] * area;
            spin_moment += (x * q[1] - y * q[0]) * area;
        }
        let mut state: Vec<DiscState> = (0..n)
            .map(|i| match solution.state[i] {
                // contact without friction: nothing holds the point
                DiscState::Excluded if self.problem.pressure[i] > 0.0 => {
                    if solution.image[i].hypot(solution.image[n + i]) > 0.0 {
                        DiscState::Rim
                    } else {
                        DiscState::Inside
                    }
                }
                state => state,
            })
            .collect();
        if let Some(faces) = &self.faces {
            faces.follow(&mut state);
        }
        let rest = match self.problem.friction {
            Friction::SpeedDependent { law, .. } => law.evaluate(0.0).0,
            _ => 0.0,
        };
        let coefficient = match (self.problem.friction, self.coefficient.first()) {
            // a cell that came to rest again is held by friction at rest: its traction is below the kinetic bound
            (Friction::StaticKinetic { at_rest, .. }, Some(fixed)) => fixed
                .iter()
                .zip(&state)
                .map(|(mu, state)| match state {
                    DiscState::Rim => *mu,
                    _ => *at_rest,
                })
                .collect(),
            (_, Some(fixed)) => fixed.clone(),
            (_, None) => solution
                .radius
                .iter()
                .zip(self.problem.pressure)
                .map(|(g, p)| if *p > 0.0 { g / p } else { rest })
                .collect(),
        };
        let plastic = self.yielding(0).map(|law| {
            let mut magnitude: Vec<f64> = (0..n)
                .map(|i| match solution.state[i] {
                    DiscState::Rim => solution.image[i].hypot(solution.image[n + i]),
                    _ => 0.0,
                })
                .collect();
            if let Some(faces) = &self.faces {
                faces.lead(&mut magnitude);
            }
            law.plastic_slip(&magnitude)
        });
        let mut image = solution.image;
        if let Some(faces) = &self.faces {
            faces.lead(&mut image);
        }
        TangentialSolution {
            rounds: None,
            plastic,
            slip: image.iter().map(|f| -f * per_length).collect(),
            traction: solution.field,
            state,
            coefficient,
            drive,
            force,
            spin_moment,
            converged: solution.converged,
            iterations: solution.iterations,
            coarse_iterations: self.coarse_iterations,
            products: self.products.get(),
            preconditionings: self.preconditionings.get(),
            history: solution.history,
        }
    }
}
