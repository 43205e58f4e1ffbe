// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of a solved contact by everything that was given, with the cells in contact held.
//!
//! With the cells `I` that carry pressure, `A_II p_I - N_I c + b_I = 0` and `N^T p = f`. A change of what is given
//! changes `b`, `f` or `A`, and one more linear solve gives the change of the pressure and of the motions. The
//! matrix is symmetric up to the sign of `c`, so that the same solve gives all derivatives of one number. That of
//! bodies that creep is not, and its transpose takes the place of it.
//! A rough layer adds the slope of its law to the diagonal of these cells.
//! Cells at the hardness carry what they carry, and their gaps follow, as those of open cells do.
//! Where a cell only just touches, parts, begins or ceases to flow, the derivative holds to one side only.

use std::cell::{Cell, OnceCell};
use std::ops::ControlFlow;

use mtb_complementarity::bounded::{Held, HeldSolution, Mode};
use mtb_operator::krylov::dot;
use mtb_operator::{Buffers, Monitor, Progress, report};

use super::inverse::Inverse;
use super::level::{Level, Region, half_sides};
use super::nested::{unpack_motion, with_layer};
use super::product::Product;
use super::{Load, NormalContact, NormalState};
use crate::Error;
use crate::error::{check, check_number};
use crate::inclination::Turn;

/// A change of what is given; or the derivatives of a number by it.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalChange {
    /// Of the gap (ny * nx) [m].
    pub gap: Vec<f64>,
    /// Of the force [N] or of the approach [m], whichever is given.
    pub load: f64,
    /// Of the moments that are given [N m].
    pub moments: [f64; 2],
    /// Of the compliance of the surface, over it [-]; a rough layer stays as it is.
    pub compliance: f64,
    /// Of a flexibility by which each cell gives way to its own pressure (ny * nx) [m/Pa]: a layer.
    pub flexibility: Vec<f64>,
    /// Of the hardness [Pa]; of no account where none is given.
    pub hardness: f64,
}

impl NormalChange {
    /// Nothing, on so many cells.
    pub fn nothing(points: usize) -> Self {
        Self {
            gap: vec![0.0; points],
            load: 0.0,
            moments: [0.0; 2],
            compliance: 0.0,
            flexibility: vec![0.0; points],
            hardness: 0.0,
        }
    }
}

/// A change of what is found; or the weights of a number in it.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalResponse {
    /// Of the pressure (ny * nx) [Pa].
    pub pressure: Vec<f64>,
    /// Of the deformed gap (ny * nx) [m]; where a body flows, minus the depth of it.
    pub gap: Vec<f64>,
    /// Of the approach [m].
    pub approach: f64,
    /// Of the tilts [-].
    pub tilts: [f64; 2],
}

/// Derivatives, and what they cost.
#[derive(Clone, Debug)]
pub struct Derived<T> {
    /// One for each change or number asked for.
    pub values: Vec<T>,
    /// Products with the influence matrix.
    pub products: usize,
    /// Applications of the preconditioner.
    pub preconditionings: usize,
}

/// What changes of the solution follow from changes of what is given: one solve each.
///
/// # Errors
/// As [`solve_normal`](super::solve_normal), and [`Error::Singular`] where the cells in contact do not determine
/// the pressure and the motions.
pub fn forward(
    contact: &NormalContact<'_>,
    solution: &NormalState<'_>,
    changes: &[NormalChange],
    monitor: Monitor<'_>,
) -> Result<Derived<NormalResponse>, Error> {
    let points = contact.grid.points();
    for change in changes {
        check("change of the gap", &change.gap, points)?;
        check("change of the flexibility", &change.flexibility, points)?;
        let numbers = [change.load, change.compliance, change.hardness];
        check("change of load, compliance and hardness", &numbers, 3)?;
        check("change of the moments", &change.moments, 2)?;
    }
    watched(monitor, &|monitor| {
        let place = Place::new(contact, solution, monitor)?;
        place.held(false, monitor, &mut |held| {
            let change = |change: &NormalChange| place.response(held, change, monitor);
            changes.iter().map(change).collect()
        })
    })
}

/// The derivatives by all that is given of numbers that are weighted sums of what was found: one solve each.
///
/// Weights of the gap count where it is open, and where a body flows.
///
/// # Errors
/// As [`forward`].
pub fn adjoint(
    contact: &NormalContact<'_>,
    solution: &NormalState<'_>,
    weights: &[NormalResponse],
    monitor: Monitor<'_>,
) -> Result<Derived<NormalChange>, Error> {
    let points = contact.grid.points();
    for weight in weights {
        check("weights of the pressure", &weight.pressure, points)?;
        check("weights of the gap", &weight.gap, points)?;
        check_number(
            "weight of the approach",
            weight.approach,
            true,
            "a finite number is needed",
        )?;
        check("weights of the tilts", &weight.tilts, 2)?;
    }
    watched(monitor, &|monitor| {
        let place = Place::new(contact, solution, monitor)?;
        place.held(true, monitor, &mut |held| {
            let gradient = |weight: &NormalResponse| place.gradient(held, weight, monitor);
            weights.iter().map(gradient).collect()
        })
    })
}

/// Runs `work` with a monitor that, once it has asked to stop, goes on to do so: products break off without a word.
fn watched<T>(
    monitor: Monitor<'_>,
    work: &dyn Fn(Monitor<'_>) -> Result<T, Error>,
) -> Result<T, Error> {
    let is_stopped = Cell::new(false);
    let result = work(&|progress: Progress| {
        if is_stopped.get() || monitor(progress).is_break() {
            is_stopped.set(true);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    });
    if is_stopped.get() {
        return Err(Error::Interrupted);
    }
    result
}

/// A solved contact as its derivatives see it.
struct Place<'a> {
    contact: &'a NormalContact<'a>,
    /// The motions on the whole grid.
    modes: Vec<Mode>,
    whole: Region,
    /// The rectangle of the solve, its cells in contact and its motions there.
    region: Region,
    set: Vec<bool>,
    held_modes: Vec<Mode>,
    /// Where the gap follows: cells without a pressure, and those at the hardness.
    is_free: Vec<bool>,
    /// One on cells at the hardness, and zero elsewhere.
    flowing: Vec<f64>,
    /// Displacement by the pressure `flowing`.
    by_flowing: OnceCell<Vec<f64>>,
    pressure: &'a [f64],
    /// Normal displacement by the pressure [m], without that of a rough layer.
    displacement: Vec<f64>,
    /// Slope of the law of a rough layer at the cells of the rectangle [m/Pa], and its mean where there is pressure;
    /// empty without one.
    slope: Vec<f64>,
    mean_slope: f64,
    /// How the rows of the rectangle and of the whole grid are inclined.
    turns: [Option<Turn>; 2],
    buffers: Buffers,
    product: Product<'a>,
    /// On the whole grid, where that is not the rectangle.
    whole_product: Option<Product<'a>>,
    whole_products: Cell<usize>,
}

impl<'a> Place<'a> {
    fn new(
        contact: &'a NormalContact<'a>,
        solution: &NormalState<'a>,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let (grid, points) = (contact.grid, contact.grid.points());
        check("pressure", solution.pressure, points)?;
        check("gap of the solution", solution.gap, points)?;
        let level = Level::finest(contact);
        let whole = Region::whole(&grid);
        let region = match contact.surface {
            super::Surface::FreeSpace(_)
            | super::Surface::Rolling(_)
            | super::Surface::Inclined(..) => Region::around(solution.pressure, &grid, false),
            super::Surface::Periodic(_) | super::Surface::Body(_) => whole,
        };
        let flows = |p: f64| contact.hardness.is_some_and(|hardness| p >= hardness);
        let part = region.cut(solution.pressure, grid.nx);
        let modes = level.modes(&whole, contact);
        // the gap is what is left of it once the bodies have moved and given way
        let motion = motion_of(contact, solution);
        let mut displacement = solution.gap.to_vec();
        let offset = level.offset(&whole, contact.load);
        for (i, u) in displacement.iter_mut().enumerate() {
            let moved: f64 = modes.iter().zip(&motion).map(|(m, c)| c * m.shape[i]).sum();
            *u += moved - offset[i];
        }
        let (mut slope, mut mean_slope) = (Vec::new(), 0.0);
        if let Some(law) = contact.rough {
            for (u, p) in displacement.iter_mut().zip(solution.pressure) {
                *u -= law.opening(*p);
            }
            slope = part.iter().map(|p| law.slope(*p)).collect();
            mean_slope = dot(&slope, &part) / part.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        }
        let buffers = Buffers::default();
        let made = |region: &Region| {
            let shape = [region.nx, region.ny];
            Product::influence(contact.surface, &grid, shape, &buffers, monitor)
        };
        let (product, whole_product) = (made(&region), (region != whole).then(|| made(&whole)));
        Ok(Self {
            contact,
            held_modes: level.modes(&region, contact),
            turns: [&region, &whole].map(|region| level.turn(region, contact.surface)),
            slope,
            mean_slope,
            modes,
            whole,
            region,
            set: part.iter().map(|p| *p > 0.0 && !flows(*p)).collect(),
            is_free: (solution.pressure.iter())
                .map(|p| *p <= 0.0 || flows(*p))
                .collect(),
            flowing: (solution.pressure.iter())
                .map(|p| f64::from(u8::from(flows(*p))))
                .collect(),
            by_flowing: OnceCell::new(),
            pressure: solution.pressure,
            displacement,
            buffers,
            product,
            whole_product,
            whole_products: Cell::new(0),
        })
    }

    /// Runs `work` with the linear problem of the cells in contact, or with the transposed one, `back`.
    fn held<T>(
        &self,
        back: bool,
        monitor: Monitor<'_>,
        work: &mut dyn FnMut(&mut Held<'_>) -> Result<Vec<T>, Error>,
    ) -> Result<Derived<T>, Error> {
        let (softened, wave);
        let layer = self.mean_slope;
        let surface = match self.contact.surface {
            super::Surface::FreeSpace(influence) if layer > 0.0 => {
                softened = with_layer(influence, layer);
                super::Surface::FreeSpace(&softened)
            }
            super::Surface::Inclined(influence, inclination) if layer > 0.0 => {
                softened = with_layer(influence, layer);
                super::Surface::Inclined(&softened, inclination)
            }
            super::Surface::Rolling(influence) if layer > 0.0 => {
                softened = with_layer(influence, layer);
                super::Surface::Rolling(&softened)
            }
            super::Surface::Periodic(by) => {
                wave = move |k: f64| layer + by(k);
                super::Surface::Periodic(&wave)
            }
            other => other,
        };
        let inverse = Inverse::new(
            surface,
            &self.contact.grid,
            [self.region.nx, self.region.ny],
            self.set.iter().all(|c| *c),
            &self.buffers,
            monitor,
        );
        report(monitor, 0, f64::NAN)?;
        let apply = |x: &[f64], y: &mut [f64]| {
            self.multiply(&self.product, self.turns[0].as_ref(), back, x, y, monitor);
            for ((y, x), slope) in y.iter_mut().zip(x).zip(&self.slope) {
                *y += slope * x;
            }
        };
        // softer cells than the mean are scaled, as in the solve
        let scale: Vec<f64> = (self.slope.iter())
            .map(|slope| (layer / slope).sqrt().min(1.0))
            .collect();
        let precondition = |set: &[bool], x: &[f64], y: &mut [f64]| {
            if scale.is_empty() {
                return inverse.apply(set, x, y, monitor);
            }
            let scaled: Vec<f64> = x.iter().zip(&scale).map(|(x, e)| x * e).collect();
            inverse.apply(set, &scaled, y, monitor);
            y.iter_mut().zip(&scale).for_each(|(y, e)| *y *= e);
        };
        let mut held = Held::new(&apply, &precondition, &self.held_modes, &self.set);
        let values = work(&mut held)?;
        Ok(Derived {
            values,
            products: held.products + self.whole_products.get(),
            preconditionings: held.preconditionings,
        })
    }

    fn response(
        &self,
        held: &mut Held<'_>,
        change: &NormalChange,
        monitor: Monitor<'_>,
    ) -> Result<NormalResponse, Error> {
        let width = self.contact.grid.nx;
        let mut opened = change.gap.clone();
        for ((gap, own), p) in (opened.iter_mut().zip(&change.flexibility)).zip(self.pressure) {
            *gap += own * p;
        }
        let approach = match self.contact.load {
            Load::Force(_) => 0.0,
            Load::Approach(_) => change.load,
        };
        for (gap, u) in opened.iter_mut().zip(&self.displacement) {
            *gap += change.compliance * u - approach;
        }
        let mut targets = self.targets(change);
        if change.hardness != 0.0 && self.flows() {
            for (gap, u) in opened.iter_mut().zip(self.by_flowing(monitor)) {
                *gap += change.hardness * u;
            }
            for (target, mode) in targets.iter_mut().zip(&self.modes) {
                *target -= change.hardness * dot(&mode.shape, &self.flowing);
            }
        }
        let mut right = self.region.cut(&opened, width);
        for v in &mut right {
            *v = -*v;
        }
        let found = self.solved(held, &right, &targets, monitor)?;
        let mut pressure = self.region.paste(&found.pressure, &self.contact.grid);
        let mut gap = self.image(&pressure, &found.image, monitor);
        for (i, gap) in gap.iter_mut().enumerate() {
            let moved: f64 = (self.modes.iter().zip(&found.motion))
                .map(|(mode, c)| c * mode.shape[i])
                .sum();
            *gap = if self.is_free[i] {
                *gap + opened[i] - moved
            } else {
                0.0
            };
        }
        for (p, flowing) in pressure.iter_mut().zip(&self.flowing) {
            *p += change.hardness * flowing;
        }
        let (found_approach, tilts) =
            unpack_motion(self.contact, &found.motion, half_sides(&self.contact.grid));
        Ok(NormalResponse {
            pressure,
            gap,
            approach: match self.contact.load {
                Load::Force(_) => found_approach,
                Load::Approach(_) => approach,
            },
            tilts,
        })
    }

    fn gradient(
        &self,
        held: &mut Held<'_>,
        weight: &NormalResponse,
        monitor: Monitor<'_>,
    ) -> Result<NormalChange, Error> {
        let width = self.contact.grid.nx;
        // where the gap is closed it stays so
        let of_gap: Vec<f64> = (weight.gap.iter().zip(&self.is_free))
            .map(|(w, is_free)| if *is_free { *w } else { 0.0 })
            .collect();
        let mut right = self.region.cut(&weight.pressure, width);
        if of_gap.iter().any(|w| *w != 0.0) {
            let by_gap = self.whole_image(&of_gap, true, monitor);
            let by_gap = self.region.cut(&by_gap, width);
            right.iter_mut().zip(by_gap).for_each(|(r, w)| *r += w);
        }
        // weights of the motions: their own, less what they close of the gap
        let half = half_sides(&self.contact.grid);
        let is_forced = matches!(self.contact.load, Load::Force(_));
        let mut motion: Vec<f64> = is_forced.then_some(weight.approach).into_iter().collect();
        for axis in 0..2 {
            if self.contact.moments[axis].is_some() {
                motion.push(weight.tilts[axis] / half[axis]);
            }
        }
        for (w, mode) in motion.iter_mut().zip(&self.modes) {
            *w = dot(&mode.shape, &of_gap) - *w;
        }
        let found = self.solved(held, &right, &motion, monitor)?;
        let pressure = self.region.paste(&found.pressure, &self.contact.grid);
        let gap: Vec<f64> = of_gap.iter().zip(&pressure).map(|(w, p)| w - p).collect();
        let by_approach = -gap.iter().sum::<f64>();
        let area = self.contact.grid.cell_area();
        let mut by_targets = found.motion.iter().map(|c| -c / area);
        let load = if is_forced {
            by_targets.next().unwrap_or(0.0)
        } else {
            weight.approach + by_approach
        };
        let mut moments = [0.0; 2];
        for axis in 0..2 {
            if self.contact.moments[axis].is_some() {
                moments[axis] = by_targets.next().unwrap_or(0.0) / half[axis];
            }
        }
        let mut hardness = 0.0;
        if self.flows() {
            hardness = dot(&weight.pressure, &self.flowing) + dot(&gap, self.by_flowing(monitor));
            for (mode, c) in self.modes.iter().zip(&found.motion) {
                hardness += c * dot(&mode.shape, &self.flowing);
            }
        }
        Ok(NormalChange {
            compliance: dot(&gap, &self.displacement),
            flexibility: gap.iter().zip(self.pressure).map(|(w, p)| w * p).collect(),
            gap,
            load,
            moments,
            hardness,
        })
    }

    fn flows(&self) -> bool {
        self.flowing.iter().any(|f| *f != 0.0)
    }

    fn by_flowing(&self, monitor: Monitor<'_>) -> &[f64] {
        (self.by_flowing).get_or_init(|| self.whole_image(&self.flowing, false, monitor))
    }

    /// Changes of the balances.
    fn targets(&self, change: &NormalChange) -> Vec<f64> {
        let area = self.contact.grid.cell_area();
        let half = half_sides(&self.contact.grid);
        let mut targets = Vec::new();
        if let Load::Force(_) = self.contact.load {
            targets.push(change.load / area);
        }
        for axis in 0..2 {
            if self.contact.moments[axis].is_some() {
                targets.push(change.moments[axis] / (area * half[axis]));
            }
        }
        targets
    }

    /// Whether a cell moves another one as that one moves it.
    fn is_symmetric(&self) -> bool {
        !matches!(self.contact.surface, super::Surface::Rolling(_))
    }

    /// The product with the influence matrix, or with its transpose, `back`: that of a convolution is the same one seen
    /// from the other end.
    fn multiply(
        &self,
        product: &Product<'_>,
        turn: Option<&Turn>,
        back: bool,
        x: &[f64],
        y: &mut [f64],
        monitor: Monitor<'_>,
    ) {
        if !back || self.is_symmetric() {
            return product.apply_turned(turn, x, y, monitor);
        }
        let reversed: Vec<f64> = x.iter().rev().copied().collect();
        product.apply(&reversed, y, monitor);
        y.reverse();
    }

    fn solved(
        &self,
        held: &mut Held<'_>,
        right: &[f64],
        target: &[f64],
        monitor: Monitor<'_>,
    ) -> Result<HeldSolution, Error> {
        let found = if self.is_symmetric() {
            held.solve(right, target, monitor)?
        } else {
            held.solve_unsymmetric(right, target, monitor)?
        };
        if found.converged {
            Ok(found)
        } else {
            Err(Error::Singular)
        }
    }

    /// Displacement on the whole grid by a pressure of which that on the rectangle is known.
    fn image(&self, pressure: &[f64], known: &[f64], monitor: Monitor<'_>) -> Vec<f64> {
        if self.region == self.whole {
            return known.to_vec();
        }
        self.whole_image(pressure, false, monitor)
    }

    /// Displacement on the whole grid by a field, or its transpose, `back`.
    fn whole_image(&self, field: &[f64], back: bool, monitor: Monitor<'_>) -> Vec<f64> {
        let mut image = vec![0.0; field.len()];
        let product = self.whole_product.as_ref().unwrap_or(&self.product);
        let turn = self.turns[1].as_ref();
        self.multiply(product, turn, back, field, &mut image, monitor);
        self.whole_products.set(self.whole_products.get() + 1);
        image
    }
}

/// Amplitudes of the free motions of a solution.
fn motion_of(contact: &NormalContact<'_>, solution: &NormalState<'_>) -> Vec<f64> {
    let half = half_sides(&contact.grid);
    let mut motion = Vec::new();
    if let Load::Force(_) = contact.load {
        motion.push(solution.approach);
    }
    for axis in 0..2 {
        if contact.moments[axis].is_some() {
            motion.push(solution.tilts[axis] * half[axis]);
        }
    }
    motion
}
