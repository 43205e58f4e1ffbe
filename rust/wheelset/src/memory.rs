// SPDX-License-Identifier: MIT OR Apache-2.0
//! What patches carry from one step of transient rolling to the next.
//!
//! The frame of a patch goes with it, and its tractions stay in their cells there. The next step takes what they did to
//! the surface where its own cells are from that at the cells around, so that steps of parts of a cell end where steps
//! of whole ones do, see [`mtb_contact::tangential::PatchOperators::rolling_by`]. Several earlier patches must lie on
//! one grid: those less loaded are interpolated on it, which keeps their forces.

use std::ops::Range;

use mtb_contact::tangential::Earlier;
use nalgebra::Vector2;

use crate::balance::Pressed;
use crate::derivative::PatchChange;
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
    /// Creepages of the patch in that frame, as of [`PatchHistory::creepage`].
    pub(crate) creepage: Option<[f64; 3]>,
    /// What it was gathered from.
    pub(crate) gathered: Gathered<[i64; 2]>,
}

/// Where the frame of a patch was: its origin, as of [`PatchHistory::position`] [m], and the slope of its plane [rad].
pub(crate) type Frame = ([f64; 3], f64);

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
    /// Its number among all of them.
    number: usize,
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
    let own = past.iter().enumerate();
    for (number, known) in own.filter(|(_, known)| known.side == side) {
        let history = (known.history.as_ref()).ok_or(Error::NoHistory { side })?;
        let lines = Lines {
            first: known.first,
            nx: known.nx,
            ny: known.ny,
        };
        olds.extend(
            Extent::of(lines, &history.pressure, spacing).map(|extent| Old {
                number,
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
            olds.iter().map(|old| across(old.frame(), at)).collect()
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
    let rest = ready.wheelset.friction_of(side).at_rest();
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
            let mut all = Gathered {
                base: olds[base].number,
                from: olds[base].frame(),
                frames: Vec::new(),
                cells: Vec::new(),
            };
            for (o, _) in &parts {
                all.take(&olds[*o], spacing, |k| heirs[*o][k] == Some(i));
            }
            let creepage = olds[base].history.creepage;
            let mut moved = moved[i][base].into();
            if parts.len() > 1 {
                // none of their frames is that of all
                moved = all.in_nearest_columns(moved, spacing[0]);
            }
            Some(all.on_one_grid(moved, creepage, rest))
        })
        .collect())
}

/// Place of the origin of a frame in that of an earlier one, along x and across the rail [m].
///
/// Across it is the chord between them as the mean of both planes sees it, for the arc.
fn across(from: Frame, (position, angle): Frame) -> Vector2<f64> {
    let [x, y, z] = [0, 1, 2].map(|c| position[c] - from.0[c]);
    let (sin, cos) = (0.5 * (angle + from.1)).sin_cos();
    Vector2::new(x, cos * y + sin * z)
}

/// Change of [`across`] with that of both frames.
pub(crate) fn across_change(
    (from, by_from): (Frame, Frame),
    ((position, angle), by): (Frame, Frame),
) -> [f64; 2] {
    let [_, y, z] = [0, 1, 2].map(|c| position[c] - from.0[c]);
    let [by_x, by_y, by_z] = [0, 1, 2].map(|c| by.0[c] - by_from.0[c]);
    let (sin, cos) = (0.5 * (angle + from.1)).sin_cos();
    let by_turn = 0.5 * (by.1 + by_from.1) * (cos * z - sin * y);
    [by_x, cos * by_y + sin * by_z + by_turn]
}

/// Loaded cells of earlier patches in one frame. `At`: how their places are told.
#[derive(Clone)]
pub(crate) struct Gathered<At> {
    /// Number of the earlier patch whose frame it is, and that frame.
    base: usize,
    from: Frame,
    /// Numbers and frames of all of them.
    frames: Vec<(usize, Frame)>,
    cells: Vec<Cell<At>>,
}

/// What a cell takes over from one of an earlier patch.
#[derive(Clone)]
struct Cell<At> {
    at: At,
    /// The patch, as a place in [`Gathered::frames`], and its cell.
    patch: usize,
    there: usize,
    traction: [f64; 2],
    pressure: f64,
    coefficient: f64,
    /// Share that goes here, and its change by a metre that the patch moves along x and across.
    weight: f64,
    slopes: [f64; 2],
}

impl Old<'_> {
    fn frame(&self) -> Frame {
        (self.history.position, self.history.angle)
    }
}

impl Gathered<[i64; 2]> {
    /// Adds the loaded cells that are `wanted` of a patch.
    fn take(&mut self, old: &Old<'_>, spacing: [f64; 2], wanted: impl Fn(usize) -> bool) {
        let patch = self.frames.len();
        self.frames.push((old.number, old.frame()));
        let n = old.history.pressure.len();
        let away = across(self.from, old.frame());
        let offset = [0, 1].map(|c| away[c] / spacing[c]);
        let base = offset.map(f64::floor);
        let share = [0, 1].map(|c| offset[c] - base[c]);
        let is_base = old.number == self.base;
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]];
        // where a patch has not moved all is in the first; one that moves may come from there
        let corners = &corners[..if is_base { 1 } else { 4 }];
        for k in (0..n).filter(|k| wanted(*k) && old.history.pressure[*k] > 0.0) {
            let place = [k % old.lines.nx, k / old.lines.nx];
            let pressure = old.history.pressure[k];
            for corner in corners {
                let [along, across] = [0, 1].map(|c| match corner[c] {
                    0 => (1.0 - share[c], -1.0 / spacing[c]),
                    _ => (share[c], 1.0 / spacing[c]),
                });
                self.cells.push(Cell {
                    at: [0, 1]
                        .map(|c| old.lines.first[c] + place[c] as i64 + base[c] as i64 + corner[c]),
                    patch,
                    there: k,
                    traction: [old.ratio[k], old.ratio[n + k]].map(|r| r * pressure),
                    pressure,
                    coefficient: old.history.coefficient[k],
                    weight: along.0 * across.0,
                    slopes: [along.1 * across.0, along.0 * across.1],
                });
            }
        }
    }

    /// Tells columns from the one `dx` [m] apart that the frame has moved to, and returns what is left of its way: a frame
    /// that lies whole columns ahead is the same.
    fn in_nearest_columns(&mut self, [x, y]: [f64; 2], dx: f64) -> [f64; 2] {
        let columns = (x / dx).round();
        for cell in &mut self.cells {
            cell.at[0] -= columns as i64;
        }
        [x - columns * dx, y]
    }

    /// The fields on the smallest grid that holds them; particles beside them have the coefficient of `rest`.
    fn on_one_grid(self, moved: [f64; 2], creepage: Option<[f64; 3]>, rest: f64) -> Before {
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
            earlier.traction[k] += cell.weight * cell.traction[0];
            earlier.traction[n + k] += cell.weight * cell.traction[1];
            earlier.pressure[k] += cell.weight * cell.pressure;
            earlier.coefficient[k] += cell.weight * cell.coefficient;
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
            creepage,
            gathered: self,
        }
    }

    /// The same with other places.
    pub(crate) fn told_by(&self, place: impl Fn([i64; 2]) -> usize) -> Gathered<usize> {
        let cells = self.cells.iter().map(|cell| Cell {
            at: place(cell.at),
            patch: cell.patch,
            there: cell.there,
            traction: cell.traction,
            pressure: cell.pressure,
            coefficient: cell.coefficient,
            weight: cell.weight,
            slopes: cell.slopes,
        });
        Gathered {
            base: self.base,
            from: self.from,
            frames: self.frames.clone(),
            cells: cells.collect(),
        }
    }
}

impl Gathered<usize> {
    /// What the patch whose frame it is has changed.
    pub(crate) fn of_base<'a>(&self, by: &'a [PatchChange]) -> &'a PatchChange {
        &by[self.base]
    }

    /// Change of the way from that frame to another one, with that of both.
    pub(crate) fn moved_change(
        &self,
        by: Option<&[PatchChange]>,
        to: Frame,
        by_to: Frame,
    ) -> [f64; 2] {
        let by_from = by.map_or(([0.0; 3], 0.0), |by| self.of_base(by).frame());
        across_change((self.from, by_from), (to, by_to))
    }

    /// Changes of the fields on `n` cells with those of the earlier patches, as of left wheels.
    pub(crate) fn change(&self, by: &[PatchChange], n: usize, rest: f64) -> Earlier {
        let base = self.of_base(by).frame();
        let away: Vec<[f64; 2]> = (self.frames.iter())
            .map(|(number, frame)| across_change((self.from, base), (*frame, by[*number].frame())))
            .collect();
        let mut change = Earlier {
            traction: vec![0.0; 2 * n],
            pressure: vec![0.0; n],
            coefficient: vec![0.0; n],
        };
        let (mut whole, mut weight, mut by_weight) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for cell in &self.cells {
            let (k, there) = (cell.at, cell.there);
            let by = &by[self.frames[cell.patch].0];
            let [along, across] = [0, 1].map(|c| cell.slopes[c] * away[cell.patch][c]);
            let moved = along + across;
            let count = by.pressure.len();
            for c in 0..2 {
                change.traction[c * n + k] +=
                    cell.weight * by.traction[c * count + there] + moved * cell.traction[c];
            }
            change.pressure[k] += cell.weight * by.pressure[there] + moved * cell.pressure;
            change.coefficient[k] += cell.weight * by.coefficient[there] + moved * cell.coefficient;
            whole[k] += cell.weight * cell.coefficient;
            weight[k] += cell.weight;
            by_weight[k] += moved;
        }
        for (k, value) in change.coefficient.iter_mut().enumerate() {
            // as they are found
            if weight[k] > 1.0 {
                *value = (*value - whole[k] / weight[k] * by_weight[k]) / weight[k];
            } else {
                *value -= rest * by_weight[k];
            }
        }
        change
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACING: [f64; 2] = [1e-3, 1.5e-3];
    const REST: f64 = 0.31;

    /// Two patches that merge, changed by `share` of a change; and that change.
    fn olds(share: f64, is_apart: bool) -> (Vec<PatchRatio>, Vec<PatchChange>) {
        let (nx, ny) = (3, 2);
        let n = nx * ny;
        let value = |k: usize, patch: usize| f64::from(((7 * k + 3 * patch) % 11) as u32) - 4.0;
        let mut olds = Vec::new();
        let mut changes = Vec::new();
        for patch in 0..2 {
            let of = |scale: f64, seed: usize| -> Vec<f64> {
                (0..n).map(|k| scale * value(k + seed, patch)).collect()
            };
            let mut by = PatchChange {
                pressure: of(1e8, 1),
                traction: [of(3e7, 2), of(2e7, 5)].concat(),
                coefficient: of(0.02, 3),
                origin: [2e-4, 5e-4, 3e-4],
                contact_angle: 0.02,
                ..PatchChange::default()
            };
            if patch == 0 {
                by.origin = [-1e-4, 2e-4, 1e-4];
                by.contact_angle = -0.01;
            }
            let pressure = |k: usize| 9e8 + 1e8 * value(k, patch) + share * by.pressure[k];
            let ratio = (0..2 * n)
                .map(|k| (1e8 * value(k, patch) + share * by.traction[k]) / pressure(k % n))
                .collect();
            let away = if patch == 0 || !is_apart { 0.0 } else { 1.0 };
            olds.push(PatchRatio {
                side: Side::Left,
                first: [-1, 2 * patch as i64],
                nx,
                ny,
                ratio,
                history: Some(PatchHistory {
                    position: [0, 1, 2]
                        .map(|c| away * [3.7e-4, -2.2e-4, 1e-4][c] + share * by.origin[c]),
                    angle: 0.05 + 0.1 * away + share * by.contact_angle,
                    pressure: (0..n).map(pressure).collect(),
                    coefficient: (0..n)
                        .map(|k| 0.3 + 0.01 * value(k, patch) + share * by.coefficient[k])
                        .collect(),
                    creepage: None,
                }),
            });
            changes.push(by);
        }
        (olds, changes)
    }

    fn gathered(share: f64, is_apart: bool) -> Before {
        let (olds, _) = olds(share, is_apart);
        let olds: Vec<Old<'_>> = (olds.iter().zip(0..))
            .filter_map(|(known, number)| {
                let history = known.history.as_ref()?;
                let lines = Lines {
                    first: known.first,
                    nx: known.nx,
                    ny: known.ny,
                };
                Some(Old {
                    number,
                    lines,
                    ratio: &known.ratio,
                    history,
                    extent: Extent::of(lines, &history.pressure, SPACING)?,
                })
            })
            .collect();
        let mut all = Gathered {
            base: 0,
            from: olds[0].frame(),
            frames: Vec::new(),
            cells: Vec::new(),
        };
        for old in &olds {
            all.take(old, SPACING, |_| true);
        }
        all.on_one_grid([0.0; 2], None, REST)
    }

    #[test]
    fn changes_of_merged_patches_are_differences() {
        let small = 1e-4;
        let [behind, at, ahead] = [-small, 0.0, small].map(|share| gathered(share, true));
        let (_, by) = olds(0.0, true);
        let n = at.earlier.pressure.len();
        let lines = at.lines;
        let told = at.gathered.told_by(|place| {
            let [i, j] = [0, 1].map(|c| (place[c] - lines.first[c]) as usize);
            j * lines.nx + i
        });
        let found = told.change(&by, n, REST);
        // cells of both patches, of one, and of an interpolated edge
        let mut weight = vec![0.0; n];
        for cell in &told.cells {
            weight[cell.at] += cell.weight;
        }
        for (low, high) in [(1.01, 2.0), (0.999, 1.001), (0.01, 0.99)] {
            assert!(weight.iter().any(|w| *w > low && *w < high));
        }
        for (found, field) in [
            (
                &found.traction,
                [&ahead.earlier.traction, &behind.earlier.traction],
            ),
            (
                &found.pressure,
                [&ahead.earlier.pressure, &behind.earlier.pressure],
            ),
            (
                &found.coefficient,
                [&ahead.earlier.coefficient, &behind.earlier.coefficient],
            ),
        ] {
            let truth = |k: usize| (field[0][k] - field[1][k]) / (2.0 * small);
            let size = (0..field[0].len())
                .map(|k| truth(k).abs())
                .fold(0.0, f64::max);
            for (k, found) in found.iter().enumerate() {
                assert!(
                    (found - truth(k)).abs() < 1e-6 * size,
                    "{k}: {found} is not {}",
                    truth(k)
                );
            }
        }
    }

    #[test]
    fn a_patch_that_has_not_moved_may_come_from_where_it_is() {
        // on whole cells the change is that of one that moves on along and across
        let (_, by) = olds(0.0, false);
        let [at, ahead] = [0.0, 1e-6].map(|share| gathered(share, false));
        let told = |before: &Before| {
            let lines = at.lines;
            before.gathered.told_by(move |place| {
                let [i, j] = [0, 1].map(|c| (place[c] - lines.first[c]) as usize);
                j * lines.nx + i
            })
        };
        assert_eq!([at.lines.nx, at.lines.ny], [ahead.lines.nx, ahead.lines.ny]);
        let found = told(&at).change(&by, at.earlier.pressure.len(), REST);
        let pairs = ahead.earlier.pressure.iter().zip(&at.earlier.pressure);
        for ((after, now), found) in pairs.zip(&found.pressure) {
            assert!((found - (after - now) / 1e-6).abs() < 1e6, "{found}");
        }
    }
}
