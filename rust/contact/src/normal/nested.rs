// SPDX-License-Identifier: MIT OR Apache-2.0
//! Many cells: conjugate gradients with convolutions, from coarse grids to the finest.

use std::cell::Cell;
use std::ops::ControlFlow;

use mtb_complementarity::bounded::{self, Judgement, Solution, Status};
use mtb_operator::{Buffers, Grid, Monitor, Progress, check_memory, report};

use super::inverse::{Inverse, costs};
use super::level::{Level, Region, half_sides};
use super::product::{Influence, Product};
use super::{CELLS_AT_MOST, Load, Method, NormalContact, NormalSolution, Surface, memory};
use crate::Error;
use crate::interface::{Linearisation, ROUNDS, SETTLED};

/// Relative error of the pressure that a coarse grid may have from its residual: enough to start from and
/// to tell the discretisation error by; without and with cells in contact along all sides, whose
/// pressure peaks leave a larger discretisation error anyway.
const COARSE_ERROR: [f64; 2] = [1e-3, 1e-2];

/// Share of the estimated discretisation error that the residual may cause.
const TOLERANCE_SHARE: f64 = 0.05;

const MAX_ITERATIONS: usize = 1000;

/// Residual of an elastic contact that tells whether pressures reach a cap.
const ELASTIC: f64 = 1e-2;

/// Part of what a law is missed by to which a linearised contact is solved.
const PART: f64 = 0.01;

/// Part of the mean pressure about which a law is linearised at first where the pressure is less.
const LEAST: f64 = 0.1;

/// Linearised contacts in a row whose search may end before their tolerance: the next one may be an easier one.
const FAILURES: usize = 2;

/// Work in points transformed, and the memory for it.
#[derive(Default)]
struct Work {
    products: f64,
    preconditionings: f64,
    buffers: Buffers,
}

pub(super) fn solve(
    contact: &NormalContact<'_>,
    tolerance: Option<f64>,
    monitor: Monitor<'_>,
) -> Result<NormalSolution, Error> {
    check_memory(
        contact.grid.points(),
        memory([contact.grid.nx, contact.grid.ny], Method::Fourier),
        memory([CELLS_AT_MOST.isqrt(); 2], Method::Fourier),
    )?;
    // a product breaks off without a word: whoever looks next hears of it as well
    let is_stopped = Cell::new(false);
    let monitor: Monitor<'_> = &|progress: Progress| {
        if is_stopped.get() || monitor(progress).is_break() {
            is_stopped.set(true);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    };
    let levels = match given(contact) {
        Some(_) => vec![Level::finest(contact)],
        None => Level::pyramid(contact),
    };
    let mut work = Work::default();
    // the last level solved: its number and pressure, and its difference from the one before
    let mut known: Option<(usize, Vec<f64>)> = None;
    let mut previous = None;
    // the same of what is not held at the hardness, where pressures agree on any grid: what the residual is measured by
    let mut free = None;
    let cap = contact.hardness.unwrap_or(f64::INFINITY);
    for k in (1..levels.len()).rev() {
        let is_full = is_full(known.as_ref());
        if is_full && k > 1 {
            continue;
        }
        let level = &levels[k];
        let start = start(contact, &levels, k, known.as_ref());
        let tolerance = residual_for(COARSE_ERROR[usize::from(is_full)], &level.grid);
        let (region, solution) =
            on_level(contact, level, &start, tolerance, false, &mut work, monitor)?;
        if solution.status == Status::Unreachable {
            // too few cells for the balance: the next grid begins anew
            known = None;
            continue;
        }
        let found = region.paste(&solution.pressure, &level.grid);
        previous = difference(&levels, k, &found, known.as_ref(), f64::INFINITY);
        free = difference(&levels, k, &found, known.as_ref(), cap);
        known = Some((k, found));
    }
    let level = &levels[0];
    let tolerance = tolerance.unwrap_or_else(|| {
        // the error halves, at least, from one grid to the next
        let error = free.map_or(COARSE_ERROR[0], |d| 0.5 * d);
        residual_for(TOLERANCE_SHARE * error, &level.grid).clamp(1e-11, 1e-5)
    });
    let start = start(contact, &levels, 0, known.as_ref());
    let (region, solution) = on_level(contact, level, &start, tolerance, true, &mut work, monitor)?;
    let (found, solution) = outside(
        contact, level, region, solution, tolerance, &mut work, monitor,
    )?;
    let difference = difference(&levels, 0, &found.pressure, known.as_ref(), f64::INFINITY);
    let (product, inverse) = costs(contact.surface, [level.grid.nx, level.grid.ny]);
    let (approach, tilts) = unpack_motion(contact, &solution.motion, half_sides(&contact.grid));
    let is_met = found.residual <= tolerance;
    Ok(NormalSolution {
        status: match solution.status {
            Status::Solved if !is_met => Status::Stagnated,
            status => status,
        },
        method: Method::Fourier,
        pressure: found.pressure,
        gap: found.gap,
        approach,
        tilts,
        iterations: solution.iterations,
        products: work.products / product,
        preconditionings: work.preconditionings / inverse,
        residual: found.residual,
        tolerance,
        history: solution.history,
        discretisation_error: error_of(difference, previous),
    })
}

/// The fields of the whole finest grid.
struct Found {
    pressure: Vec<f64>,
    gap: Vec<f64>,
    residual: f64,
}

/// The gap outside of the rectangle; where it closes there, a rectangle around that as well is solved once more.
fn outside(
    contact: &NormalContact<'_>,
    level: &Level,
    region: Region,
    solution: Solution,
    tolerance: f64,
    work: &mut Work,
    monitor: Monitor<'_>,
) -> Result<(Found, Solution), Error> {
    let whole = Region::whole(&level.grid);
    let plain = |solution: &Solution| Found {
        pressure: solution.pressure.clone(),
        gap: solution.slack.clone(),
        residual: solution.residual,
    };
    if region == whole {
        return Ok((plain(&solution), solution));
    }
    let pressure = region.paste(&solution.pressure, &level.grid);
    let shape = [whole.nx, whole.ny];
    let product = Product::influence(contact.surface, &level.grid, shape, &work.buffers, monitor);
    let mut displacement = vec![0.0; whole.points()];
    let turn = level.turn(&whole, contact.surface);
    product.apply_turned(turn.as_ref(), &pressure, &mut displacement, monitor);
    report(monitor, 0, f64::NAN)?;
    work.products += product.size();
    let offset = level.offset(&whole, contact.load);
    let modes = level.modes(&whole, contact);
    let mut judged = Judgement::default();
    let mut gap = offset;
    for i in 0..gap.len() {
        gap[i] += displacement[i];
        for (mode, c) in modes.iter().zip(&solution.motion) {
            gap[i] -= c * mode.shape[i];
        }
        if let Some(law) = contact.rough {
            let opened = law.opening(pressure[i]);
            gap[i] += opened;
            displacement[i] += opened;
        }
        // what flows may go deeper
        let flows = contact.hardness.is_some_and(|h| pressure[i] >= h);
        let slack = if flows { gap[i].max(0.0) } else { gap[i] };
        judged.take(pressure[i], slack, displacement[i]);
    }
    let residual = judged.residual();
    if residual <= tolerance || solution.status != Status::Solved {
        return Ok((
            Found {
                pressure,
                gap,
                residual,
            },
            solution,
        ));
    }
    let touching: Vec<f64> = pressure
        .iter()
        .zip(&gap)
        .map(|(p, gap)| if *gap < 0.0 { 1.0 } else { *p })
        .collect();
    // it grows, so that this ends
    let wider = region.joined(&Region::around(&touching, &level.grid, true));
    let next = if wider == region { whole } else { wider };
    let start = next.cut(&pressure, level.grid.nx);
    let again = on_region(contact, level, next, start, 0.9 * tolerance, work, monitor)?;
    outside(contact, level, next, again, tolerance, work, monitor)
}

/// Residual at which the pressure has the relative error `error` on `grid`: short waves of pressure give
/// way least, so the error is the residual times about a tenth of the cells per side, at most.
fn residual_for(error: f64, grid: &Grid) -> f64 {
    10.0 * error / grid.nx.max(grid.ny) as f64
}

/// Whether all cells of the last level were in contact: no border of the contact is to be found, and the
/// pressure peaks at the sides of the grid do not pass from one level to the next.
fn is_full(known: Option<&(usize, Vec<f64>)>) -> bool {
    known.is_some_and(|(_, pressure)| pressure.iter().all(|p| *p > 0.0))
}

/// The pressure that is given to start from, if it is any.
fn given<'a>(contact: &NormalContact<'a>) -> Option<&'a [f64]> {
    let start = contact.start?;
    start.iter().any(|p| *p > 0.0).then_some(start)
}

/// Pressure to start from: the one given, that of the coarser grid, or a uniform one.
fn start(
    contact: &NormalContact<'_>,
    levels: &[Level],
    k: usize,
    known: Option<&(usize, Vec<f64>)>,
) -> Vec<f64> {
    if let Some(start) = given(contact) {
        return start.to_vec();
    }
    match known {
        Some((coarser, pressure)) if !is_full(known) => {
            let cap = contact.hardness.unwrap_or(f64::INFINITY);
            levels[k].start_from(&levels[*coarser], pressure, cap)
        }
        _ if matches!(contact.load, Load::Force(_)) => vec![1.0; levels[k].grid.points()],
        _ => {
            // balance is restored by factors: where a moment is to be carried, something must be there
            let (grid, half) = (&levels[k].grid, half_sides(&contact.grid));
            let carried = (0..2)
                .filter_map(|axis| Some(contact.moments[axis]?.abs() / half[axis]))
                .fold(0.0, f64::max);
            vec![carried / (grid.cell_area() * grid.points() as f64); grid.points()]
        }
    }
}

/// Difference of the pressure of a level from that of the next coarser one, of what is below a `cap`, if that is known.
fn difference(
    levels: &[Level],
    k: usize,
    pressure: &[f64],
    known: Option<&(usize, Vec<f64>)>,
    cap: f64,
) -> Option<f64> {
    let (coarser, other) = known?;
    if *coarser != k + 1 {
        return None;
    }
    levels[k].difference(pressure, &levels[*coarser], other, cap)
}

/// Solves on the rectangle around the start, and on larger ones where that proves too small. On the finest grid the gap
/// outside of the rectangle is asked for afterwards.
fn on_level(
    contact: &NormalContact<'_>,
    level: &Level,
    start: &[f64],
    tolerance: f64,
    is_finest: bool,
    work: &mut Work,
    monitor: Monitor<'_>,
) -> Result<(Region, Solution), Error> {
    let grid = &level.grid;
    let mut region = match contact.surface {
        super::Surface::FreeSpace(_)
        | super::Surface::Rolling(_)
        | super::Surface::Inclined(..) => Region::around(start, grid, is_finest),
        super::Surface::Periodic(_) | super::Surface::Body(_) => Region::whole(grid),
    };
    let mut part = region.cut(start, grid.nx);
    loop {
        // the gap is evaluated once more from the pressure alone: leave room for rounding
        let solution = on_region(contact, level, region, part, 0.9 * tolerance, work, monitor)?;
        if !region.is_too_small(&solution.pressure, grid) {
            return Ok((region, solution));
        }
        let found = region.paste(&solution.pressure, grid);
        region = region.joined(&Region::around(&found, grid, is_finest));
        part = region.cut(&found, grid.nx);
    }
}

fn on_region(
    contact: &NormalContact<'_>,
    level: &Level,
    region: Region,
    start: Vec<f64>,
    tolerance: f64,
    work: &mut Work,
    monitor: Monitor<'_>,
) -> Result<Solution, Error> {
    let (grid, shape): (&Grid, _) = (&level.grid, [region.nx, region.ny]);
    let product = Product::influence(contact.surface, grid, shape, &work.buffers, monitor);
    let turn = level.turn(&region, contact.surface);
    let is_full = start.iter().all(|p| *p > 0.0);
    report(monitor, 0, f64::NAN)?;
    let offset = level.offset(&region, contact.load);
    let modes = level.modes(&region, contact);
    let buffers = work.buffers.clone();
    // with a diagonal (n) [m/Pa] besides, about `layer` over `scale` (n) squared
    let mut solved = |diagonal: &[f64],
                      layer: f64,
                      scale: &[f64],
                      offset: &[f64],
                      start: Vec<f64>,
                      tolerance: f64| {
        let options = bounded::Options {
            tolerance,
            max_iterations: MAX_ITERATIONS,
        };
        let rectangle;
        let wave;
        let surface = match contact.surface {
            Surface::FreeSpace(influence) => {
                rectangle = with_layer(influence, layer);
                Surface::FreeSpace(&rectangle)
            }
            Surface::Rolling(influence) => {
                rectangle = with_layer(influence, layer);
                Surface::Rolling(&rectangle)
            }
            Surface::Inclined(influence, inclination) => {
                rectangle = with_layer(influence, layer);
                Surface::Inclined(&rectangle, inclination)
            }
            Surface::Periodic(by) => {
                wave = move |k: f64| layer + by(k);
                Surface::Periodic(&wave)
            }
            Surface::Body(body) => Surface::Body(body),
        };
        let inverse = Inverse::new(surface, grid, shape, is_full, &buffers, monitor);
        report(monitor, 0, f64::NAN)?;
        let apply = |x: &[f64], y: &mut [f64]| {
            product.apply_turned(turn.as_ref(), x, y, monitor);
            for ((y, x), d) in y.iter_mut().zip(x).zip(diagonal) {
                *y += d * x;
            }
        };
        let invert = |set: &[bool], x: &[f64], y: &mut [f64]| {
            if scale.is_empty() {
                return inverse.apply(set, x, y, monitor);
            }
            let scaled: Vec<f64> = x.iter().zip(scale).map(|(x, e)| x * e).collect();
            inverse.apply(set, &scaled, y, monitor);
            for (y, e) in y.iter_mut().zip(scale) {
                *y *= e;
            }
        };
        let problem = bounded::Problem {
            offset,
            modes: &modes,
        };
        let solution = match contact.hardness {
            None if matches!(surface, Surface::Rolling(_)) => {
                bounded::solve_unsymmetric(&apply, &invert, &problem, start, options, monitor)?
            }
            None => bounded::solve(&apply, &invert, &problem, start, options, monitor)?,
            Some(cap) => {
                let elastic = |start: Vec<f64>, options: bounded::Options| {
                    bounded::solve(&apply, &invert, &problem, start, options, monitor)
                };
                let bounded = |start: Vec<f64>| {
                    bounded::solve_capped(&apply, &invert, &problem, cap, start, options, monitor)
                };
                elastic_or_flowing(elastic, bounded, cap, start, options)?
            }
        };
        report(monitor, solution.iterations, solution.residual)?;
        work.products += solution.products as f64 * product.size();
        work.preconditionings += solution.preconditionings as f64 * inverse.size();
        Ok::<_, Error>(solution)
    };
    let Some(law) = contact.rough else {
        return solved(&[], 0.0, &[], &offset, start, tolerance);
    };
    let mut unit = vec![0.0; offset.len()];
    unit[0] = 1.0;
    let mut own = vec![0.0; offset.len()];
    product.apply(&unit, &mut own, monitor);
    let guess = match contact.load {
        Load::Force(force) => {
            // a start without a coarser grid is of any size
            let sum: f64 = start.iter().sum::<f64>() * grid.cell_area();
            let by = if sum > 0.0 { force / sum } else { 0.0 };
            start.iter().map(|p| p * by).collect()
        }
        Load::Approach(_) => start.clone(),
    };
    // at a small pressure the law is so soft that a search from another grid's border would not end
    let sum: f64 = guess.iter().sum();
    let square: f64 = guess.iter().map(|p| p * p).sum();
    let least = if sum > 0.0 { LEAST * square / sum } else { 0.0 };
    let guess = guess.iter().map(|p| p.max(least)).collect();
    let mut rough = Linearisation::new(law, &offset, |_| own[0], Some(guess));
    let mut pressure = start;
    let (mut iterations, mut history) = (0, Vec::new());
    let (mut missed, mut failures) = (1.0_f64, 0);
    for round in 1.. {
        let (linear, diagonal) = rough.linear(&offset, None);
        // what carries counts; softer points are scaled in the rough inverse
        let total: f64 = pressure.iter().sum();
        let weighted: f64 = diagonal.iter().zip(&pressure).map(|(d, p)| d * p).sum();
        let layer = if total > 0.0 {
            weighted / total
        } else {
            diagonal.iter().copied().fold(f64::INFINITY, f64::min)
        };
        let scale: Vec<f64> = diagonal
            .iter()
            .map(|d| (layer / d).sqrt().min(1.0))
            .collect();
        let within = tolerance.max(PART * missed);
        let mut found = solved(&diagonal, layer, &scale, &linear, pressure, within)?;
        iterations += found.iterations;
        history.extend(&found.history);
        missed = rough.turn(&found.pressure, &mut found.slack);
        let is_solved = found.status == Status::Solved;
        let has_settled = is_solved && within <= tolerance && missed <= tolerance.max(SETTLED);
        failures = if is_solved { 0 } else { failures + 1 };
        if has_settled || failures > FAILURES || round == ROUNDS {
            if has_settled {
                rough.check_end(&found.pressure)?;
            } else if is_solved {
                found.status = Status::IterationLimit;
            }
            (found.iterations, found.history) = (iterations, history);
            return Ok(found);
        }
        pressure = found.pressure;
    }
    unreachable!("the rounds end")
}

/// Solves under a `cap`: without it as long as no pressure reaches it, since a search that may leave points there loses
/// its way among those that are far open.
fn elastic_or_flowing(
    elastic: impl Fn(Vec<f64>, bounded::Options) -> Result<Solution, mtb_complementarity::Error>,
    bounded: impl Fn(Vec<f64>) -> Result<Solution, mtb_complementarity::Error>,
    cap: f64,
    start: Vec<f64>,
    options: bounded::Options,
) -> Result<Solution, Error> {
    let flows = |pressure: &[f64]| pressure.iter().any(|p| *p >= cap);
    let (mut start, mut products, mut preconditionings) = (start, 0, 0);
    for tolerance in [options.tolerance.max(ELASTIC), options.tolerance] {
        if flows(&start) {
            break;
        }
        let found = elastic(
            start.clone(),
            bounded::Options {
                tolerance,
                ..options
            },
        )?;
        products += found.products;
        preconditionings += found.preconditionings;
        if found.status != Status::Solved {
            break;
        }
        if tolerance == options.tolerance && !flows(&found.pressure) {
            return Ok(Solution {
                products,
                preconditionings,
                ..found
            });
        }
        start = found.pressure;
    }
    let found = bounded(start)?;
    Ok(Solution {
        products: products + found.products,
        preconditionings: preconditionings + found.preconditionings,
        ..found
    })
}

/// Influence with a `layer` [m/Pa] between the bodies.
pub(super) fn with_layer(
    influence: Influence<'_>,
    layer: f64,
) -> impl Fn([f64; 2], [f64; 2]) -> f64 + Sync + '_ {
    move |offset: [f64; 2], cell: [f64; 2]| {
        let own = if offset == [0.0; 2] { layer } else { 0.0 };
        own + influence(offset, cell)
    }
}

/// Approach [m] and tilts from the amplitudes of the free motions.
pub(super) fn unpack_motion(
    contact: &NormalContact<'_>,
    motion: &[f64],
    half: [f64; 2],
) -> (f64, [f64; 2]) {
    let mut amplitudes = motion.iter().copied();
    let approach = match contact.load {
        Load::Approach(approach) => approach,
        Load::Force(_) => amplitudes.next().unwrap_or(0.0),
    };
    let mut tilts = [0.0; 2];
    for axis in 0..2 {
        if contact.moments[axis].is_some() {
            tilts[axis] = amplitudes.next().unwrap_or(0.0) / half[axis];
        }
    }
    (approach, tilts)
}

/// Most by which halving the cells is believed to have lessened the error: order 3/2, as away from the border
/// of smooth contacts.
const FASTEST: f64 = 2.828_427_124_746_19;

/// Error of the finer of two grids from their difference, at the rate seen one grid earlier.
///
/// A difference `d` at order `r` leaves `d / (2^r - 1)`. The contact ends at whole cells, so that `d` jumps
/// about its trend: orders above one are not believed, those below one half (edges) are not seen, and the
/// difference before guards against two grids that agree by chance. The order is one where nothing is known.
pub(super) fn error_of(difference: Option<f64>, previous: Option<f64>) -> Option<f64> {
    let difference = difference?;
    let Some(previous) = previous else {
        return Some(difference);
    };
    let factor = if difference > 0.0 {
        (previous / difference).clamp(2f64.sqrt(), 2.0)
    } else {
        2.0
    };
    Some((difference / (factor - 1.0)).max(previous / FASTEST))
}
