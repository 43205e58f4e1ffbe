// SPDX-License-Identifier: MIT OR Apache-2.0
//! What patches carry from one step of transient rolling to the next.
//!
//! The frame of a patch goes with it, and its tractions stay in their cells there. The next step evaluates what they did
//! where its own cells are, with the exact influence of cells, so that a patch that moves by parts of a cell needs no
//! interpolation. Several earlier patches must lie on one grid: those less loaded are interpolated on it, which keeps
//! their forces.

use std::ops::Range;

use mtb_contact::tangential::Earlier;
use nalgebra::{Matrix2, Vector2};

use crate::balance::Pressed;
use crate::error::Error;
use crate::prepared::Ready;
use crate::state::{Lines, PatchHistory, PatchRatio, WheelState};
use crate::track::Place;
use crate::wheelset::Side;

/// What a step rolls on from.
#[derive(Clone, Copy)]
pub(crate) struct Past<'a> {
    /// Time since then [s].
    pub(crate) duration: f64,
    pub(crate) patches: &'a [PatchRatio],
}

impl<'a> Past<'a> {
    pub(crate) fn new(duration: f64, state: &'a WheelState) -> Self {
        Self {
            duration,
            patches: &state.patches,
        }
    }
}

/// What a patch takes over from earlier ones, in the frame that it was in then.
pub(crate) struct Before {
    /// How that frame has moved since then, along x over the reference point and across over the rail [m].
    pub(crate) moved: [f64; 2],
    pub(crate) lines: Lines,
    pub(crate) earlier: Earlier,
    /// Share of the coefficients that is of particles at rest [-].
    pub(crate) resting: Vec<f64>,
    /// That frame: its origin, as of [`PatchHistory::position`] [m], and the slope of its plane [rad].
    pub(crate) from: ([f64; 3], f64),
    /// Creepages of the patch in that frame, as of [`PatchHistory::creepage`].
    pub(crate) creepage: Option<[f64; 3]>,
}

/// The smallest rectangle around loaded cells [m].
#[derive(Clone, Copy)]
struct Extent {
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Extent {
    /// `None` without pressure.
    fn of(lines: Lines, pressure: &[f64], spacing: [f64; 2]) -> Option<Self> {
        let half = 0.5 * Vector2::from(spacing);
        let loaded = (0..pressure.len()).filter(|k| pressure[*k] > 0.0);
        let places = loaded.map(|k| place(lines, k, spacing));
        places.fold(None, |known, at| {
            let (low, high) = (at - half, at + half);
            Some(known.map_or(Self { low, high }, |all: Self| Self {
                low: all.low.inf(&low),
                high: all.high.sup(&high),
            }))
        })
    }

    /// Distance from a place [m], negative inside.
    fn distance(&self, at: Vector2<f64>) -> f64 {
        (self.low - at).sup(&(at - self.high)).max()
    }

    /// Whether it overlaps another across the rail that has been moved by `by` [m].
    fn overlaps(&self, other: &Self, by: f64) -> bool {
        self.low.y < other.high.y + by && other.low.y + by < self.high.y
    }
}

/// Place of a cell in its frame [m].
fn place(lines: Lines, k: usize, spacing: [f64; 2]) -> Vector2<f64> {
    let at = [k % lines.nx, k / lines.nx];
    Vector2::from([0, 1].map(|c| spacing[c] * (lines.first[c] + at[c] as i64) as f64))
}

/// A patch of the step before.
struct Old<'a> {
    lines: Lines,
    ratio: &'a [f64],
    history: &'a PatchHistory,
    extent: Extent,
}

/// What each patch of a wheel in a place takes over. Nothing where a patch is new.
pub(crate) fn carried(
    ready: &Ready,
    side: Side,
    place_now: &Place,
    past: &[PatchRatio],
    now: &[Pressed],
) -> Result<Vec<Option<Before>>, Error> {
    let spacing = ready.wheelset.spacing;
    let mut olds = Vec::new();
    for known in past.iter().filter(|known| known.side == side) {
        let history = (known.history.as_ref()).ok_or(Error::NoHistory { side })?;
        let lines = Lines {
            first: known.first,
            nx: known.nx,
            ny: known.ny,
        };
        olds.extend(
            Extent::of(lines, &history.pressure, spacing).map(|extent| Old {
                lines,
                ratio: &known.ratio,
                history,
                extent,
            }),
        );
    }
    let extents: Vec<Option<Extent>> = now
        .iter()
        .map(|pressed| Extent::of(Lines::of(&pressed.plane), &pressed.pressure, spacing))
        .collect();
    // how the frame of each patch has moved from that of each earlier one
    let moved: Vec<Vec<Vector2<f64>>> = now
        .iter()
        .map(|pressed| {
            let plane = &pressed.plane;
            let at = ready.in_history(side, place_now, plane);
            let from = |old: &Old<'_>| {
                let history = old.history;
                across((history.position, history.angle), (at, plane.angle))
            };
            olds.iter().map(from).collect()
        })
        .collect();
    // the patch that takes over each cell of each earlier one
    let heirs: Vec<Vec<Option<usize>>> = olds
        .iter()
        .enumerate()
        .map(|(o, old)| {
            let overlapping: Vec<(usize, Extent)> = extents
                .iter()
                .enumerate()
                .filter_map(|(i, extent)| Some((i, (*extent)?)))
                .filter(|(i, extent)| extent.overlaps(&old.extent, -moved[*i][o].y))
                .collect();
            let nearest = |k: usize| {
                let at = place(old.lines, k, spacing);
                let distance = |(i, extent): &(usize, Extent)| extent.distance(at - moved[*i][o]);
                let all = overlapping.iter();
                all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
                    .map(|(i, _)| *i)
            };
            (0..old.history.pressure.len()).map(nearest).collect()
        })
        .collect();
    let rest = ready.wheelset.friction.at_rest();
    Ok((0..now.len())
        .map(|i| {
            let inherited = |o: usize| -> f64 {
                let pressure = olds[o].history.pressure.iter().zip(&heirs[o]);
                pressure
                    .filter(|(_, heir)| **heir == Some(i))
                    .map(|(p, _)| p)
                    .sum()
            };
            let parts: Vec<(usize, f64)> = (0..olds.len())
                .map(|o| (o, inherited(o)))
                .filter(|(_, p)| *p > 0.0)
                .collect();
            let (base, _) = *parts.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
            let from = olds[base].history;
            let mut all = Gathered::default();
            for (o, _) in parts {
                let old = &olds[o];
                // of its origin in the frame of the base
                let history = old.history;
                let away = across(
                    (from.position, from.angle),
                    (history.position, history.angle),
                );
                all.take(old, away, spacing, |k| heirs[o][k] == Some(i));
            }
            Some(all.on_one_grid(moved[i][base].into(), from, rest))
        })
        .collect())
}

/// Place of the origin of a frame in that of an earlier one, along x and across the rail [m].
///
/// Across it is the chord between them as the mean of both planes sees it, for the arc.
fn across(from: ([f64; 3], f64), (position, angle): ([f64; 3], f64)) -> Vector2<f64> {
    let [x, y, z] = [0, 1, 2].map(|c| position[c] - from.0[c]);
    let (sin, cos) = (0.5 * (angle + from.1)).sin_cos();
    Vector2::new(x, cos * y + sin * z)
}

/// Change of [`across`] with that of the origin and of the slope.
pub(crate) fn across_change(
    from: ([f64; 3], f64),
    (position, angle): ([f64; 3], f64),
    (by_position, by_angle): ([f64; 3], f64),
) -> [f64; 2] {
    let [_, y, z] = [0, 1, 2].map(|c| position[c] - from.0[c]);
    let [by_x, by_y, by_z] = by_position;
    let (sin, cos) = (0.5 * (angle + from.1)).sin_cos();
    let by_turn = 0.5 * by_angle * (cos * z - sin * y);
    [by_x, cos * by_y + sin * by_z + by_turn]
}

/// Loaded cells of earlier patches on the lines of one frame.
#[derive(Default)]
struct Gathered {
    /// Column and row, traction times weight, pressure times weight, coefficient, weight.
    cells: Vec<Cell>,
}

struct Cell {
    at: [i64; 2],
    traction: [f64; 2],
    pressure: f64,
    coefficient: f64,
    weight: f64,
}

impl Gathered {
    /// Adds the loaded cells that are `wanted` of a patch whose origin is `away` [m].
    fn take(
        &mut self,
        old: &Old<'_>,
        away: Vector2<f64>,
        spacing: [f64; 2],
        wanted: impl Fn(usize) -> bool,
    ) {
        let n = old.history.pressure.len();
        let offset = [0, 1].map(|c| away[c] / spacing[c]);
        let base = offset.map(f64::floor);
        let share = [0, 1].map(|c| offset[c] - base[c]);
        let weights = Matrix2::from_fn(|i, j| {
            let along = if i == 0 { 1.0 - share[0] } else { share[0] };
            let across = if j == 0 { 1.0 - share[1] } else { share[1] };
            along * across
        });
        for k in (0..n).filter(|k| wanted(*k) && old.history.pressure[*k] > 0.0) {
            let place = [k % old.lines.nx, k / old.lines.nx];
            let pressure = old.history.pressure[k];
            for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let weight = weights[(i, j)];
                if weight <= 0.0 {
                    continue;
                }
                let next = [i as i64, j as i64];
                self.cells.push(Cell {
                    at: [0, 1]
                        .map(|c| old.lines.first[c] + place[c] as i64 + base[c] as i64 + next[c]),
                    traction: [old.ratio[k], old.ratio[n + k]].map(|r| weight * r * pressure),
                    pressure: weight * pressure,
                    coefficient: weight * old.history.coefficient[k],
                    weight,
                });
            }
        }
    }

    /// The fields on the smallest grid that holds them; particles beside them have the coefficient of `rest`.
    fn on_one_grid(&self, moved: [f64; 2], from: &PatchHistory, rest: f64) -> Before {
        let span = |c: usize| -> Range<i64> {
            let lines = || self.cells.iter().map(|cell| cell.at[c]);
            let (low, high) = (lines().min(), lines().max());
            low.unwrap_or(0)..high.map_or(0, |high| high + 1)
        };
        let (x, y) = (span(0), span(1));
        let lines = Lines {
            first: [x.start, y.start],
            nx: (x.end - x.start) as usize,
            ny: (y.end - y.start) as usize,
        };
        let n = lines.nx * lines.ny;
        let mut earlier = Earlier {
            traction: vec![0.0; 2 * n],
            pressure: vec![0.0; n],
            coefficient: vec![0.0; n],
        };
        let mut weight = vec![0.0; n];
        for cell in &self.cells {
            let [i, j] = [0, 1].map(|c| (cell.at[c] - lines.first[c]) as usize);
            let k = j * lines.nx + i;
            earlier.traction[k] += cell.traction[0];
            earlier.traction[n + k] += cell.traction[1];
            earlier.pressure[k] += cell.pressure;
            earlier.coefficient[k] += cell.coefficient;
            weight[k] += cell.weight;
        }
        // an interpolated edge is part particle of the patch, part one at rest
        let resting: Vec<f64> = weight.iter().map(|w| (1.0 - w).max(0.0)).collect();
        for ((value, weight), resting) in earlier.coefficient.iter_mut().zip(weight).zip(&resting) {
            *value = *value / weight.max(1.0) + resting * rest;
        }
        Before {
            moved,
            lines,
            earlier,
            resting,
            from: (from.position, from.angle),
            creepage: from.creepage,
        }
    }
}
