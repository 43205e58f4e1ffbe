// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::krylov::Krylov;
use mtb_operator::{Monitor, report};

use super::linear::{LinearStep, Outcome};
use super::problem::{
    DependentRadius, DiscOptions, DiscProblem, DiscSolution, DiscStart, DiscState, Radius,
    Resultant,
};
use crate::error::{Error, check};

pub(super) use mtb_operator::krylov::dot;

/// Largest share of the Newton residual to which the linear system is solved ...
const FORCING: f64 = 0.1;
/// ... and the power of the last reduction of the residual which it is below that: where the set of slipping points
/// holds, the linear system is soon all that is left [EisenstatWalker1996].
const FORCING_POWER: f64 = 1.5;
/// Share of the tolerance below which no linear system is solved.
const ENOUGH: f64 = 0.3;
/// Shortest step of the line search.
const SHORTEST_STEP: f64 = 1.0 / 16.0;

/// Size over the bounds below which a field counts as none, well before its squares underflow.
const LEAST_SIZE: f64 = 1e-60;

/// Solves a variational inequality on discs by a damped semismooth Newton method.
///
/// Points inside their disc keep both components free; on the rim the component along the normal
/// is held at the radius and the tangential one is free with the curvature term
/// `(|z| / g - 1) diagonal`, `z = q - F / diagonal`: the exact generalised derivative of the
/// projection equation `q = P(q - F / diagonal)`. Radii that depend on the magnitude of the image
/// enter with their exact derivative as well. The linear systems are solved by preconditioned
/// GMRES to a tenth of the residual.
///
/// For a positive definite operator and fixed radii the solution exists and is unique.
/// [QiSun1993] for the method, [Kalker1990, ch. 4] for the problem.
///
/// # Errors
/// [`Error::Shape`] and [`Error::NotFinite`] for bad input, [`Error::Interrupted`] if the monitor
/// says so. Not converging is no error: see [`DiscSolution::converged`].
pub fn solve_discs(
    problem: &DiscProblem<'_>,
    start: &DiscStart,
    options: DiscOptions,
    monitor: Monitor<'_>,
) -> Result<DiscSolution, Error> {
    check_problem(problem, start)?;
    if problem.resultants.is_empty() {
        return newton(problem, start, options, monitor);
    }
    if is_out_of_reach(problem) {
        let none = DiscOptions {
            max_iterations: 0,
            ..options
        };
        return newton(problem, start, none, monitor);
    }
    let first = DiscOptions {
        max_iterations: options.max_iterations.min(FIRST_ATTEMPT),
        ..options
    };
    let attempt = newton(problem, start, first, monitor)?;
    if attempt.converged || options.max_iterations <= FIRST_ATTEMPT {
        return Ok(attempt);
    }
    approach_resultants(problem, attempt, options, monitor)
}

/// Whether no field within fixed discs has the resultants: what `value . weight` can reach stays below
/// `value . value`.
fn is_out_of_reach(problem: &DiscProblem<'_>) -> bool {
    let Radius::Fixed(radius) = problem.radius else {
        return false;
    };
    let mut weight = vec![0.0; problem.offset.len()];
    let mut wanted = 0.0;
    for resultant in problem.resultants {
        if resultant.softness > 0.0 {
            return false;
        }
        wanted += resultant.value.powi(2);
        for (w, own) in weight.iter_mut().zip(&resultant.weight) {
            *w += resultant.value * own;
        }
    }
    wanted > reach(&weight, radius)
}

/// Newton steps without a lower residual after which more of them are not worth while.
const STALLED: usize = 40;
/// Rounds of softened resultants without a lower residual, likewise.
const STALLED_ROUNDS: usize = 6;
/// Share of the lowest residual so far below which a residual is a lower one.
const LOWER: f64 = 0.99;

/// Newton steps of the first attempt at a problem with resultants.
const FIRST_ATTEMPT: usize = 25;
/// Newton steps of the later attempts, from better starts.
const LATER_ATTEMPT: usize = 12;
/// Rounds of softened resultants.
const ROUNDS: usize = 40;
/// Residual of a softened problem.
const ROUGH: f64 = 1e-3;

/// Reaches prescribed resultants through softened ones (proximal points): each softened problem has no
/// multipliers of its own, so it is as safe as a problem without resultants, and the multipliers found
/// are the place from which the next one yields.
fn approach_resultants(
    problem: &DiscProblem<'_>,
    mut failed: DiscSolution,
    options: DiscOptions,
    monitor: Monitor<'_>,
) -> Result<DiscSolution, Error> {
    let mut counts = [failed.iterations, failed.products, failed.preconditionings];
    let zero = vec![0.0; problem.offset.len()];
    let none = vec![0.0; problem.resultants.len()];
    let mut free = Iterate::first(problem, &zero, &none, &mut counts[1]);
    free.release();
    let elastic = LinearStep::new(problem, &free);
    let mut softness: Vec<f64> = elastic.stiffness().iter().map(|s| 0.3 * s.abs()).collect();
    let mut outcome = elastic.solve(0.0, &mut Krylov::default());
    counts[1] += outcome.products;
    counts[2] += outcome.preconditionings;
    let mut history = std::mem::take(&mut failed.history);
    let (mut best, mut best_round) = (f64::INFINITY, 0);
    for round in 0..ROUNDS {
        let resultants: Vec<Resultant> = problem
            .resultants
            .iter()
            .zip(&outcome.multipliers)
            .zip(&softness)
            .map(|((resultant, c), softness)| Resultant {
                softness: *softness,
                value: resultant.value + softness * c,
                ..resultant.clone()
            })
            .collect();
        let softened = DiscProblem {
            resultants: &resultants,
            ..*problem
        };
        let rough = DiscOptions {
            tolerance: ROUGH.max(options.tolerance),
            max_iterations: options.max_iterations,
        };
        let start = DiscStart::At {
            field: outcome.field,
            multipliers: outcome.multipliers,
        };
        let near = newton(&softened, &start, rough, monitor)?;
        let later = DiscOptions {
            max_iterations: LATER_ATTEMPT,
            ..options
        };
        let start = DiscStart::At {
            field: near.field.clone(),
            multipliers: near.multipliers.clone(),
        };
        let mut attempt = newton(problem, &start, later, monitor)?;
        for solution in [&near, &attempt] {
            counts[0] += solution.iterations;
            counts[1] += solution.products;
            counts[2] += solution.preconditionings;
        }
        history.extend(&attempt.history);
        let lowest = attempt.history.iter().copied().fold(best, f64::min);
        if lowest < LOWER * best {
            (best, best_round) = (lowest, round);
        }
        if attempt.converged || round + 1 == ROUNDS || round >= best_round + STALLED_ROUNDS {
            [
                attempt.iterations,
                attempt.products,
                attempt.preconditionings,
            ] = counts;
            attempt.history = history;
            return Ok(attempt);
        }
        outcome.field = near.field;
        outcome.multipliers = near.multipliers;
        for s in &mut softness {
            *s *= 0.6;
        }
    }
    Ok(failed)
}

fn newton(
    problem: &DiscProblem<'_>,
    start: &DiscStart,
    options: DiscOptions,
    monitor: Monitor<'_>,
) -> Result<DiscSolution, Error> {
    let mut products = 0;
    let mut preconditionings = 0;
    let mut krylov = Krylov::default();
    let mut iterate = match start {
        DiscStart::At { field, multipliers } => {
            Iterate::first(problem, field, multipliers, &mut products)
        }
        DiscStart::Inside => {
            let zero = vec![0.0; problem.offset.len()];
            let none = vec![0.0; problem.resultants.len()];
            let mut free = Iterate::first(problem, &zero, &none, &mut products);
            free.release();
            let outcome = LinearStep::new(problem, &free).solve(0.0, &mut krylov);
            products += outcome.products;
            preconditionings += outcome.preconditionings;
            Iterate::first(problem, &outcome.field, &outcome.multipliers, &mut products)
        }
    };
    let mut history = vec![iterate.relative()];
    let (mut best, mut best_step) = (iterate.relative(), 0);
    while iterate.relative() > options.tolerance
        && history.len() <= options.max_iterations
        && history.len() <= best_step + STALLED
    {
        report(monitor, history.len() - 1, iterate.relative())?;
        let reduction = match history[..] {
            [.., before, now] => now / before,
            _ => 1.0,
        };
        let share = FORCING
            .min(reduction.powf(FORCING_POWER))
            .max(ENOUGH * options.tolerance / iterate.relative());
        let target = share * iterate.merit() * iterate.bound_norm * problem.diagonal;
        let step = LinearStep::new(problem, &iterate);
        let outcome = step.solve(target, &mut krylov);
        products += outcome.products;
        preconditionings += outcome.preconditionings;
        iterate = search(problem, &iterate, &outcome, &mut products);
        if iterate.relative() < LOWER * best {
            (best, best_step) = (iterate.relative(), history.len());
        }
        // a step that lost its numbers ends this attempt, and is no part of the way of the next one
        if !iterate.merit().is_finite() {
            break;
        }
        history.push(iterate.relative());
    }
    Ok(DiscSolution {
        converged: iterate.relative() <= options.tolerance,
        iterations: history.len() - 1,
        field: iterate.field,
        image: iterate.image,
        multipliers: iterate.multipliers,
        radius: iterate.radius,
        state: iterate.state,
        products,
        preconditionings,
        history,
    })
}

/// Tries the full Newton step, then shorter ones until the residual falls; the shortest is taken
/// whatever it gives.
fn search(
    problem: &DiscProblem<'_>,
    old: &Iterate,
    newton: &Outcome,
    products: &mut usize,
) -> Iterate {
    let mut share = 1.0;
    loop {
        let mix = |from: &[f64], to: &[f64]| -> Vec<f64> {
            from.iter()
                .zip(to)
                .map(|(a, b)| a + share * (b - a))
                .collect()
        };
        let mut field = mix(&old.field, &newton.field);
        let radius = mix(&old.radius, &newton.radius);
        project(&mut field, &radius);
        let multipliers = mix(&old.multipliers, &newton.multipliers);
        let new = Iterate::new(problem, field, multipliers, products);
        if new.merit() < (1.0 - 0.1 * share) * old.merit() || share <= SHORTEST_STEP {
            return new;
        }
        share *= 0.5;
    }
}

/// Puts every point of `field` back into its disc.
pub(super) fn project(field: &mut [f64], radius: &[f64]) {
    let (first, second) = field.split_at_mut(radius.len());
    for ((x, y), g) in first.iter_mut().zip(second).zip(radius) {
        let length = length(*x, *y);
        if length > *g {
            let shrink = g.max(0.0) / length;
            *x *= shrink;
            *y *= shrink;
        }
    }
}

/// A feasible field with everything Newton's method wants to know about it.
pub(super) struct Iterate {
    pub(super) field: Vec<f64>,
    pub(super) multipliers: Vec<f64>,
    pub(super) image: Vec<f64>,
    /// `|F_i|`.
    pub(super) magnitude: Vec<f64>,
    pub(super) radius: Vec<f64>,
    pub(super) state: Vec<DiscState>,
    /// Unit vector of `z` on the rim, both components; zero elsewhere.
    pub(super) normal: Vec<f64>,
    /// `(|z| / g - 1) diagonal` on the rim, zero elsewhere.
    pub(super) curvature: Vec<f64>,
    pub(super) bound_norm: f64,
    /// Size of the field that the offset drives, or of the one found: what the residual is measured by.
    size: f64,
    residual: f64,
    defect: f64,
}

impl Iterate {
    fn first(
        problem: &DiscProblem<'_>,
        field: &[f64],
        multipliers: &[f64],
        products: &mut usize,
    ) -> Self {
        let n = problem.offset.len() / 2;
        let mut field = field.to_vec();
        let radius = match problem.radius {
            Radius::Fixed(radius) => radius.to_vec(),
            Radius::Dependent(law) => {
                let mut radius = vec![0.0; n];
                let zero = vec![0.0; n];
                law.radius(&zero, &mut radius);
                project(&mut field, &radius);
                let image = image(problem, &field, multipliers, products);
                law.radius(&magnitudes(&image), &mut radius);
                radius
            }
        };
        project(&mut field, &radius);
        Self::new(problem, field, multipliers.to_vec(), products)
    }

    pub(super) fn new(
        problem: &DiscProblem<'_>,
        field: Vec<f64>,
        mut multipliers: Vec<f64>,
        products: &mut usize,
    ) -> Self {
        let n = field.len() / 2;
        for (c, resultant) in multipliers.iter_mut().zip(problem.resultants) {
            if resultant.softness > 0.0 {
                *c = (resultant.value - dot(&resultant.weight, &field)) / resultant.softness;
            }
        }
        let image = image(problem, &field, &multipliers, products);
        let magnitude = magnitudes(&image);
        let mut radius = vec![0.0; n];
        match problem.radius {
            Radius::Fixed(fixed) => radius.copy_from_slice(fixed),
            Radius::Dependent(law) => law.radius(&magnitude, &mut radius),
        }
        let mut state = vec![DiscState::Excluded; n];
        let mut normal = vec![0.0; 2 * n];
        let mut curvature = vec![0.0; n];
        let mut square = 0.0;
        let mut driven = 0.0;
        for i in 0..n {
            let g = radius[i];
            if g <= 0.0 {
                continue;
            }
            let offset = length(problem.offset[i], problem.offset[n + i]);
            driven += (offset / problem.diagonal).min(g).powi(2);
            let z = [
                field[i] - image[i] / problem.diagonal,
                field[n + i] - image[n + i] / problem.diagonal,
            ];
            let length = length(z[0], z[1]);
            let mut wanted = z;
            if length <= g {
                state[i] = DiscState::Inside;
            } else {
                state[i] = DiscState::Rim;
                normal[i] = z[0] / length;
                normal[n + i] = z[1] / length;
                curvature[i] = (length / g - 1.0) * problem.diagonal;
                wanted = [g * normal[i], g * normal[n + i]];
            }
            square += (field[i] - wanted[0]).powi(2) + (field[n + i] - wanted[1]).powi(2);
        }
        let bound_norm = norm(&radius).max(f64::MIN_POSITIVE);
        let mut defect: f64 = 0.0;
        for (c, resultant) in multipliers.iter().zip(problem.resultants) {
            let found = dot(&resultant.weight, &field) + resultant.softness * c;
            defect += ((found - resultant.value) / reach(&resultant.weight, &radius)).powi(2);
        }
        Self {
            size: driven.sqrt().max(norm(&field)).min(bound_norm),
            residual: square.sqrt() / bound_norm,
            defect: defect.sqrt(),
            field,
            multipliers,
            image,
            magnitude,
            radius,
            state,
            normal,
            curvature,
            bound_norm,
        }
    }

    /// Takes every point as inside its disc.
    fn release(&mut self) {
        for state in &mut self.state {
            if *state == DiscState::Rim {
                *state = DiscState::Inside;
            }
        }
        self.normal.fill(0.0);
        self.curvature.fill(0.0);
    }

    /// Residual of the projection equation and of the resultants together, over the bounds.
    fn merit(&self) -> f64 {
        self.residual.hypot(self.defect)
    }

    /// The same over the size of the field: far below its bounds a field is as exact as near them.
    fn relative(&self) -> f64 {
        let merit = self.merit();
        if merit == 0.0 {
            return 0.0;
        }
        merit / (self.size / self.bound_norm).max(LEAST_SIZE)
    }
}

/// Largest value of `weight . q` over the discs.
fn reach(weight: &[f64], radius: &[f64]) -> f64 {
    let n = radius.len();
    let sum: f64 = (0..n)
        .map(|i| radius[i] * weight[i].hypot(weight[n + i]))
        .sum();
    sum.max(f64::MIN_POSITIVE)
}

fn image(
    problem: &DiscProblem<'_>,
    field: &[f64],
    multipliers: &[f64],
    products: &mut usize,
) -> Vec<f64> {
    let mut image = vec![0.0; field.len()];
    problem.operator.apply(field, &mut image);
    *products += 1;
    for (f, b) in image.iter_mut().zip(problem.offset) {
        *f += b;
    }
    for (c, resultant) in multipliers.iter().zip(problem.resultants) {
        for (f, e) in image.iter_mut().zip(&resultant.direction) {
            *f -= c * e;
        }
    }
    image
}

fn magnitudes(image: &[f64]) -> Vec<f64> {
    let (first, second) = image.split_at(image.len() / 2);
    first
        .iter()
        .zip(second)
        .map(|(x, y)| length(*x, *y))
        .collect()
}

/// Length of a vector whose squares are numbers.
pub(super) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// The law of dependent radii, if there is one.
pub(super) fn law<'a>(problem: &DiscProblem<'a>) -> Option<&'a dyn DependentRadius> {
    match problem.radius {
        Radius::Fixed(_) => None,
        Radius::Dependent(law) => Some(law),
    }
}

fn check_problem(problem: &DiscProblem<'_>, start: &DiscStart) -> Result<(), Error> {
    let dim = 2 * (problem.operator.dim() / 2);
    check("offset", problem.offset, dim)?;
    if let DiscStart::At { field, multipliers } = start {
        check("start", field, dim)?;
        check("multipliers", multipliers, problem.resultants.len())?;
    }
    check("diagonal", &[problem.diagonal], 1)?;
    if let Radius::Fixed(radius) = problem.radius {
        check("radius", radius, dim / 2)?;
    }
    for resultant in problem.resultants {
        check("direction", &resultant.direction, dim)?;
        check("weight", &resultant.weight, dim)?;
        check("value", &[resultant.value], 1)?;
        check("softness", &[resultant.softness], 1)?;
    }
    if problem.preconditioner.dim() != dim {
        return Err(Error::Shape {
            name: "preconditioner",
            expected: dim,
            found: problem.preconditioner.dim(),
        });
    }
    Ok(())
}
