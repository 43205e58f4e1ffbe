// SPDX-License-Identifier: MIT OR Apache-2.0
//! Simplified theory: an elastic foundation under the rolling contact, solved strip by strip.
//!
//! The displacement of the lower body relative to the upper one is `L q`, point by point. Steady rolling
//! along +x: `s = w + L dq / dx'`, `x'` running from the leading edge backwards; on each strip the
//! traction builds up from zero and is cut back to the bound. [Kalker1982], [VollebregtWilders2010]
//! Rolling across the rows of cells, each cell is the end of a strip of its own.

use crate::Error;
use crate::error::{check, check_number, check_positive};
use crate::friction::{Friction, SlipLaw};
use crate::strips::{Place, Strips};

pub use crate::flexibilities::{Flexibilities, SlopeReduction, gradient};

/// How a strip is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Backward differences between cell centres, the rigid slip a sixth of a cell ahead.
    First,
    /// Rigid slip between cell centres, slip along the mean traction.
    Second,
}

/// A patch of cells for [`solve`].
#[derive(Clone, Debug)]
pub struct FoundationProblem<'a> {
    /// Cells along x and y.
    pub shape: [usize; 2],
    /// Cell sizes [m].
    pub cell: [f64; 2],
    /// Centre of the first cell [m].
    pub origin: [f64; 2],
    /// Traction bound per unit coefficient of friction [Pa], (n): the pressure or its parabolic twin.
    pub bound: &'a [f64],
    /// The foundation.
    pub flexibility: Flexibilities,
    /// One flexibility of both directions, by which the slip is measured and has the direction of the traction;
    /// None for those of the foundation.
    pub isotropic: Option<f64>,
    /// Rolling direction from +x towards +y [rad].
    pub angle: f64,
    /// Rolling speed [m/s].
    pub speed: f64,
    /// The friction law; without memory.
    pub friction: &'a Friction,
    /// Order of the integration.
    pub order: Order,
}

/// Traction and totals of the simplified theory.
#[derive(Clone, Debug)]
pub struct FoundationSolution {
    /// Traction on the lower body [Pa], (2n).
    pub traction: Vec<f64>,
    /// Relative slip [-], (2n).
    pub slip: Vec<f64>,
    /// Cells that slip, (n).
    pub is_slipping: Vec<bool>,
    /// Force (x, y) on the lower body [N].
    pub force: [f64; 2],
    /// Moment about z on the lower body [N m].
    pub spin_moment: f64,
}

/// Solves the simplified theory for one creepage `(xi, eta, phi)`, `phi` in [1/m].
///
/// # Errors
/// [`Error::Shape`], [`Error::NotFinite`], [`Error::Number`] for bad input.
pub fn solve(
    problem: &FoundationProblem<'_>,
    creepage: [f64; 3],
) -> Result<FoundationSolution, Error> {
    let [nx, ny] = problem.shape;
    let n = nx * ny;
    check("bound", problem.bound, n)?;
    check("creepage", &creepage, 3)?;
    check("origin", &problem.origin, 2)?;
    check("angle", &[problem.angle], 1)?;
    check_positive("dx", problem.cell[0])?;
    check_positive("dy", problem.cell[1])?;
    check_positive("speed", problem.speed)?;
    let f = &problem.flexibility;
    check_positive("longitudinal flexibility", f.longitudinal)?;
    check_positive("lateral flexibility", f.lateral)?;
    check_positive("spin flexibility", f.spin)?;
    check_positive("flexibility", problem.isotropic.unwrap_or(1.0))?;
    let law = Law::of(problem.friction, n)?;
    let strips = problem.strips();
    let step = Step::of(problem, &strips, creepage);
    let mut solution = FoundationSolution {
        traction: vec![0.0; 2 * n],
        slip: vec![0.0; 2 * n],
        is_slipping: vec![false; n],
        force: [0.0; 2],
        spin_moment: 0.0,
    };
    let mut keep = |k: usize, slip: [f64; 2], strip: &Strip| {
        let (q, slip) = (strips.back(strip.traction), strips.back(slip));
        solution.traction[k] = q[0];
        solution.traction[n + k] = q[1];
        solution.slip[k] = slip[0];
        solution.slip[n + k] = slip[1];
        solution.is_slipping[k] = strip.is_slipping;
    };
    if strips.direction == [1.0, 0.0] {
        // all strips side by side: they do not wait for one another, the cells of one strip do
        let mut rows = vec![Strip::default(); ny];
        for i in (0..nx).rev() {
            let x = problem.origin[0] + i as f64 * problem.cell[0];
            for (j, strip) in rows.iter_mut().enumerate() {
                let cell = j * nx + i;
                let bound = problem.bound[cell];
                if bound <= 0.0 {
                    *strip = Strip::default();
                    continue;
                }
                let y = problem.origin[1] + j as f64 * problem.cell[1];
                let at = [x, y];
                let slip = strip.advance(&step.cell(&Place { cell, at, bound }, strip, &law));
                keep(cell, slip, strip);
            }
        }
    } else {
        let mut places = Vec::new();
        for cell in (0..n).filter(|k| problem.bound[*k] > 0.0) {
            strips.down_to([cell % nx, cell / nx], &mut places);
            let mut strip = Strip::default();
            let mut slip = [0.0; 2];
            for place in &places {
                slip = strip.advance(&step.cell(place, &strip, &law));
            }
            keep(cell, slip, &strip);
        }
    }
    (solution.force, solution.spin_moment) = totals(problem, &solution.traction);
    Ok(solution)
}

impl<'a> FoundationProblem<'a> {
    /// Its strips along the rolling direction.
    pub(crate) fn strips(&self) -> Strips<'a> {
        Strips {
            shape: self.shape,
            cell: self.cell,
            origin: self.origin,
            bound: self.bound,
            direction: Strips::direction_of(self.angle),
        }
    }
}

/// Force (x, y) [N] and moment about z [N m] of a traction (2n).
pub(crate) fn totals(problem: &FoundationProblem<'_>, traction: &[f64]) -> ([f64; 2], f64) {
    let [nx, ny] = problem.shape;
    let [dx, dy] = problem.cell;
    let (along_x, along_y) = traction.split_at(nx * ny);
    let (mut force, mut moment) = ([0.0; 2], 0.0);
    for (k, (qx, qy)) in along_x.iter().zip(along_y).enumerate() {
        let x = problem.origin[0] + (k % nx) as f64 * dx;
        let y = problem.origin[1] + (k / nx) as f64 * dy;
        force[0] += qx * dx * dy;
        force[1] += qy * dx * dy;
        moment += (x * qy - y * qx) * dx * dy;
    }
    (force, moment)
}

/// What all steps along the strips have in common, in the axes of the rolling direction.
struct Step {
    /// Flexibilities by which the slip is measured.
    flexibility: [f64; 2],
    /// Rigid slip by the creepages that these flexibilities make the tractions of the foundation of.
    creepage: [f64; 2],
    /// The spin likewise, for both directions.
    spin: [f64; 2],
    length: f64,
    speed: f64,
    order: Order,
}

impl Step {
    fn of(problem: &FoundationProblem<'_>, strips: &Strips<'_>, creepage: [f64; 3]) -> Self {
        let f = &problem.flexibility;
        let flexibility = match problem.isotropic {
            Some(one) => [one; 2],
            None => [f.longitudinal, f.lateral],
        };
        let [xi, eta] = strips.turned([creepage[0], creepage[1]]);
        Self {
            flexibility,
            creepage: [
                xi * flexibility[0] / f.longitudinal,
                eta * flexibility[1] / f.lateral,
            ],
            // the spin acts with its own flexibility on those of the two directions
            spin: flexibility.map(|l| creepage[2] * l / f.spin),
            length: strips.step().0,
            speed: problem.speed,
            order: problem.order,
        }
    }

    fn cell<'a>(&self, place: &Place, strip: &Strip, law: &Law<'a>) -> Cell<'a> {
        // from the leading edge to the first cell centre it is half a cell
        let (ahead, share) = match self.order {
            Order::First => (1.0 / 6.0, 1.0),
            Order::Second if strip.is_inside => (0.5, 1.0),
            Order::Second => (0.25, 0.5),
        };
        let [x, y] = place.at;
        Cell {
            rigid: [
                self.creepage[0] - self.spin[0] * y,
                self.creepage[1] + self.spin[1] * (x + ahead * self.length),
            ],
            length: share * self.length,
            bound: place.bound,
            flexibility: self.flexibility,
            speed: self.speed,
            law: law.at(place.cell),
            order: self.order,
        }
    }
}

/// The friction law of one cell.
enum Law<'a> {
    Fixed(&'a [f64]),
    StaticKinetic(f64, f64),
    Slip(&'a SlipLaw),
}

#[derive(Clone, Copy)]
enum CellLaw<'a> {
    StaticKinetic(f64, f64),
    Slip(&'a SlipLaw),
}

impl<'a> Law<'a> {
    fn of(friction: &'a Friction, n: usize) -> Result<Self, Error> {
        match friction {
            Friction::Coulomb(coefficient) => {
                check("friction coefficient", coefficient, n)?;
                Ok(Self::Fixed(coefficient))
            }
            Friction::StaticKinetic { at_rest, kinetic } => {
                Ok(Self::StaticKinetic(*at_rest, *kinetic))
            }
            Friction::SpeedDependent { law, memory } => {
                let distance = memory.map_or(0.0, |m| m.distance);
                check_number(
                    "memory distance",
                    distance,
                    memory.is_none(),
                    "the simplified theory takes friction laws without a memory only",
                )?;
                Ok(Self::Slip(law))
            }
            Friction::TemperatureDependent(_) => Err(Error::NoTemperature),
        }
    }

    fn at(&self, k: usize) -> CellLaw<'a> {
        match self {
            Self::Fixed(mu) => CellLaw::StaticKinetic(mu[k], mu[k]),
            Self::StaticKinetic(at_rest, kinetic) => CellLaw::StaticKinetic(*at_rest, *kinetic),
            Self::Slip(law) => CellLaw::Slip(law),
        }
    }
}

/// One step along a strip, against the rolling direction.
struct Cell<'a> {
    rigid: [f64; 2],
    length: f64,
    bound: f64,
    flexibility: [f64; 2],
    speed: f64,
    law: CellLaw<'a>,
    order: Order,
}

/// State at the last cell of a strip.
#[derive(Clone, Default)]
struct Strip {
    traction: [f64; 2],
    is_inside: bool,
    is_slipping: bool,
}

impl Strip {
    /// Advances by one cell; returns the slip.
    ///
    /// With `c = w length + L q_old` the traction is `q = c / L` where that stays below the bound, else
    /// the one of the bound's size along the slip `(c - L q) / length`.
    fn advance(&mut self, cell: &Cell<'_>) -> [f64; 2] {
        let old = self.traction;
        let [lx, ly] = cell.flexibility;
        let pull = [
            cell.rigid[0] * cell.length + lx * old[0],
            cell.rigid[1] * cell.length + ly * old[1],
        ];
        let was_slipping = self.is_slipping;
        self.is_inside = true;
        let stick = [pull[0] / lx, pull[1] / ly];
        let (at_rest, law) = match cell.law {
            CellLaw::StaticKinetic(at_rest, kinetic) => (at_rest, Err(kinetic)),
            CellLaw::Slip(law) => (law.evaluate(0.0).0, Ok(law)),
        };
        self.is_slipping = length(stick) > at_rest * cell.bound;
        if !self.is_slipping {
            self.traction = stick;
            return [0.0; 2];
        }
        let size = match law {
            Err(kinetic) => kinetic * cell.bound,
            Ok(law) => falling_bound(law, cell, pull),
        };
        let second = (cell.order == Order::Second && was_slipping)
            .then(|| along_mean(cell, old, pull, size))
            .flatten();
        self.traction = second.unwrap_or_else(|| {
            let drag = drag(cell.flexibility, pull, size);
            [pull[0] / (lx + drag), pull[1] / (ly + drag)]
        });
        [
            (pull[0] - lx * self.traction[0]) / cell.length,
            (pull[1] - ly * self.traction[1]) / cell.length,
        ]
    }
}

/// Plain root of the squares: tractions are far from overflow, and this is the innermost line.
fn length(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

/// Square of the size `g` of the traction `c / (L + d)`, and `-1/2` its derivative over `d`.
fn dragged([lx, ly]: [f64; 2], pull: [f64; 2], d: f64) -> (f64, f64) {
    let (ax, ay) = (lx + d, ly + d);
    let each = 1.0 / (ax * ay);
    let (qx, qy) = (pull[0] * ay * each, pull[1] * ax * each);
    let (xx, yy) = (qx * qx, qy * qy);
    (xx + yy, (xx * ay + yy * ax) * each)
}

/// The `d >= 0` for which `c / (L + d)` has the size `g`, by Newton's method on `1 / size`.
fn drag(flexibility: [f64; 2], pull: [f64; 2], size: f64) -> f64 {
    let [lx, ly] = flexibility;
    if size <= 0.0 {
        return f64::INFINITY;
    }
    // exact where both flexibilities are equal
    let mut d = length(pull) * (1.0 / size - 1.0 / length([pull[0] / lx, pull[1] / ly]));
    for _ in 0..30 {
        let (square, steep) = dragged(flexibility, pull, d);
        let change = (square.sqrt() - size) * square / (size * steep);
        d += change;
        // quadratic: the error left is about the square
        if change.abs() <= 1e-4 * (d + lx) {
            break;
        }
    }
    d.max(0.0)
}

/// Traction gained without a bound over one cell, in units of the bound, up to which the direction of slip
/// is taken along the mean traction; beyond, that rule oscillates.
const LONGEST_GAIN: f64 = 0.5;

/// Traction of size `size` after a cell that slips all along: slip along the mean of the tractions at
/// both ends, second order. `None` where the step is too long for that.
fn along_mean(cell: &Cell<'_>, old: [f64; 2], pull: [f64; 2], size: f64) -> Option<[f64; 2]> {
    let [lx, ly] = cell.flexibility;
    let gain = [pull[0] / lx - old[0], pull[1] / ly - old[1]];
    if length(gain) > LONGEST_GAIN * size {
        return None;
    }
    let mut q = old;
    for _ in 0..4 {
        let mean = [old[0] + q[0], old[1] + q[1]];
        let scale = 1.0 / length(mean);
        let n = [mean[0] * scale / lx, mean[1] * scale / ly];
        let p = [pull[0] / lx, pull[1] / ly];
        // |p - a n| = size, the smaller a
        let (nn, pn) = (n[0] * n[0] + n[1] * n[1], n[0] * p[0] + n[1] * p[1]);
        let rest = p[0] * p[0] + p[1] * p[1] - size * size;
        let root = pn * pn - nn * rest;
        if root < 0.0 || !root.is_finite() {
            return None;
        }
        let a = (pn - root.sqrt()) / nn;
        if a < 0.0 {
            return None;
        }
        let new = [p[0] - a * n[0], p[1] - a * n[1]];
        let change = [new[0] - q[0], new[1] - q[1]];
        q = new;
        if length(change) <= 1e-4 * size {
            break;
        }
    }
    Some(q)
}

/// Traction bound of a cell that slips under a slip-dependent law: the root of `g = mu(s(g)) p`, the
/// largest one (the least slip) if there are several.
fn falling_bound(law: &SlipLaw, cell: &Cell<'_>, pull: [f64; 2]) -> f64 {
    // as a function of the drag, which gives traction and slip at once
    let excess = |d: f64| {
        let g = dragged(cell.flexibility, pull, d).0.sqrt();
        let slip = d * g / cell.length;
        (law.evaluate(slip * cell.speed).0 * cell.bound - g, g)
    };
    let rest = law.evaluate(0.0).0 * cell.bound;
    // less traction, step by step, up to the first change of sign
    let (mut low, mut high) = (0.0, 0.0);
    let (mut below, mut g) = excess(0.0);
    let mut above = below;
    let first = if rest > 0.0 { rest } else { g };
    let mut next = first;
    for k in 1..100 {
        high = low + length(pull) * (1.0 / next - 1.0 / g).max(0.0);
        (above, g) = excess(high);
        if above >= 0.0 {
            break;
        }
        (low, below) = (high, above);
        // evenly over most of the range, then by halves towards no traction at all
        next -= if k < 12 { first / 16.0 } else { 0.5 * next };
    }
    if above < 0.0 {
        return 0.0;
    }
    // false position, the weight of an end that stays halved
    for _ in 0..100 {
        let middle = (low * above - high * below) / (above - below);
        let value;
        (value, g) = excess(middle);
        if value.abs() <= 1e-10 * g {
            break;
        }
        if value > 0.0 {
            (high, above) = (middle, value);
            below *= 0.5;
        } else {
            (low, below) = (middle, value);
            above *= 0.5;
        }
    }
    g
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kalker::creep_coefficients;

    const A: f64 = 4e-3;
    const B: f64 = 6e-3;

    /// Forces over `mu F_n` on n cells over each axis.
    fn run(
        n: usize,
        order: Order,
        creepage: [f64; 3],
        friction: &Friction,
        parabolic: bool,
    ) -> [f64; 2] {
        let cell = [2.0 * A / n as f64, 2.0 * B / n as f64];
        let origin = [-A + 0.5 * cell[0], -B + 0.5 * cell[1]];
        let bound: Vec<f64> = (0..n * n)
            .map(|k| {
                let x = (origin[0] + (k % n) as f64 * cell[0]) / A;
                let y = (origin[1] + (k / n) as f64 * cell[1]) / B;
                let inside = (1.0 - x * x - y * y).max(0.0);
                1e9 * if parabolic { inside } else { inside.sqrt() }
            })
            .collect();
        let total: f64 = bound.iter().sum::<f64>() * cell[0] * cell[1];
        let c = creep_coefficients(A / B, 0.3).unwrap();
        let problem = FoundationProblem {
            shape: [n, n],
            cell,
            origin,
            bound: &bound,
            flexibility: Flexibilities::of_ellipse(A, B, 80e9, &c),
            isotropic: None,
            angle: 0.0,
            speed: 10.0,
            friction,
            order,
        };
        let solution = solve(&problem, creepage).unwrap();
        solution.force.map(|f| f / total)
    }

    #[test]
    fn sliding_follows_the_rigid_slip() {
        let n = 20;
        let friction = Friction::Coulomb(vec![0.3; n * n]);
        for order in [Order::First, Order::Second] {
            let f = run(n, order, [0.03, 0.04, 0.0], &friction, true);
            assert!(
                (f[0] - 0.18).abs() < 3e-3 && (f[1] - 0.24).abs() < 3e-3,
                "{f:?}"
            );
        }
    }

    #[test]
    fn second_order_is_better_than_first() {
        let error = |n: usize, order: Order| {
            let at = |n: usize, order| {
                let friction = Friction::Coulomb(vec![0.3; n * n]);
                run(n, order, [4e-4, 3e-4, 0.15], &friction, true)
            };
            let (f, e) = (at(n, order), at(640, Order::Second));
            (f[0] - e[0]).hypot(f[1] - e[1])
        };
        let first = [20, 40, 80].map(|n| error(n, Order::First));
        let second = [20, 40, 80].map(|n| error(n, Order::Second));
        for k in 0..3 {
            assert!(second[k] < 0.35 * first[k], "{first:?} {second:?}");
        }
        // over two halvings: rate above 1.3 against about 1
        assert!((second[0] / second[2]).log2() / 2.0 > 1.3, "{second:?}");
        assert!((first[0] / first[2]).log2() / 2.0 > 0.8, "{first:?}");
    }

    #[test]
    fn a_slipping_cell_meets_its_law() {
        let table = SlipLaw::Table {
            slip_speed: vec![0.0, 1.0, 2.0],
            coefficient: vec![0.0, 0.3, 0.2],
        };
        let falling = SlipLaw::Exponential {
            at_rest: 0.33,
            kinetic: 0.14,
            half_slip: 0.3,
        };
        for law in [&table, &falling] {
            for (x, y) in [(0.05, 0.0), (0.1, -0.2), (-2.0, 0.5), (0.05, 0.1)] {
                let cell = Cell {
                    rigid: [x, y],
                    length: 1e-4,
                    bound: 1e9,
                    flexibility: [1e-14, 2.3e-14],
                    speed: 10.0,
                    law: CellLaw::Slip(law),
                    order: Order::First,
                };
                let mut strip = Strip::default();
                let slip = strip.advance(&cell);
                let bound = law.evaluate(length(slip) * 10.0).0 * 1e9;
                let q = strip.traction;
                assert!(strip.is_slipping);
                let error = length(q) / bound - 1.0;
                assert!(error.abs() < 1e-6, "{law:?} {x} {y} {error}");
                let across = q[0] * slip[1] - q[1] * slip[0];
                assert!(across.abs() < 1e-9 * length(q) * length(slip));
            }
        }
    }

    #[test]
    fn falling_friction_carries_less_than_friction_at_rest() {
        let n = 30;
        let falling = Friction::SpeedDependent {
            law: SlipLaw::Exponential {
                at_rest: 0.33,
                kinetic: 0.14,
                half_slip: 1.25,
            },
            memory: None,
        };
        let f = run(n, Order::First, [0.5, 0.0, 0.0], &falling, false)[0];
        let expected = 0.14 + 0.19 * 0.5_f64.powf(5.0 / 1.25);
        assert!((f - expected).abs() < 2e-3, "{f} {expected}");
    }
}
