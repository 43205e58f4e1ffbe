// SPDX-License-Identifier: MIT OR Apache-2.0
use std::hash::{DefaultHasher, Hash, Hasher};

use mtb_geometry::PlaneGap;

use crate::error::check_entries;
use crate::{Error, Side};

/// Farthest grid line of a state, in spacings.
const FARTHEST: f64 = 1e15;
/// Largest traction over pressure of a state.
const LARGEST: f64 = 1e12;

/// What a step leaves for the next one. A transient step rolls on from it; for any other it decides how long that
/// takes, not what comes out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WheelState {
    /// Overlap [m] of the undeformed bodies that carries the force, one entry for each unknown of the height.
    pub depth: Vec<f64>,
    /// What else was found, and where the next search begins; `None` before a step.
    pub found: Option<Found>,
    /// Traction over pressure of each patch.
    pub patches: Vec<PatchRatio>,
}

/// What a step has found beside height and roll, and the derivatives with which the next search begins.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// y of the pose [m], given or found for a lateral force.
    pub lateral: f64,
    /// Creepage of the rolling wheelset that was found from the load of the axle [-]: the speed of the tape circle over
    /// that of the middle of the axle along x, less one.
    pub creepage: f64,
    /// Displacement (y, z) of the left and of the right rail on its springs [m].
    pub rails: [[f64; 2]; 2],
    /// Derivatives of the forces there that the next search begins with, a square of as many numbers as were found.
    pub slope: Vec<f64>,
}

/// Numbers of what was found, without the derivatives; and the most of those.
const OF_FOUND: usize = 6;
const MOST_SLOPES: usize = 64;

/// Traction over pressure of a patch, on its grid, as of a left wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchRatio {
    /// The wheel.
    pub side: Side,
    /// First grid line along x and across, in spacings from the origin of the plane.
    pub first: [i64; 2],
    /// Points along x.
    pub nx: usize,
    /// Points across.
    pub ny: usize,
    /// The ratio (2 * ny * nx) [-], along x first.
    pub ratio: Vec<f64>,
    /// What a transient step needs beside it; `None` in states that were made without.
    pub history: Option<PatchHistory>,
}

/// Where a patch was and what pressed it, as of a left wheel: with the ratio, the tractions that a transient step rolls
/// on from.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchHistory {
    /// Origin of its frame [m]: x from the middle of the axle in its pose, y and z in the track; on a
    /// roller as seen from its angle about the axis, with the way around the roller from its top as x. Of patches that
    /// follow the rail y and z are 0: their lines across count from the origin of the arc length on the rail.
    pub position: [f64; 3],
    /// Slope of its plane [rad]; 0 of patches that follow the rail.
    pub angle: f64,
    /// Pressure (ny * nx) [Pa].
    pub pressure: Vec<f64>,
    /// Coefficient of friction of the particles [-] (ny * nx).
    pub coefficient: Vec<f64>,
    /// Creepages along x and across [-], and spin [1/m]; `None` of a wheel that did not roll, and in states of earlier
    /// versions: the parts of the next step then have the creepages of its end.
    pub creepage: Option<[f64; 3]>,
}

impl WheelState {
    /// The state as numbers: count and entries of the depth, count and entries of [`Found::to_numbers`], then for each
    /// patch side (1 left, -1 right), first grid lines, points along x and across, the ratio, and 0 or, before what a
    /// transient step needs, 1 or 2: position and angle of the plane, pressure, coefficient of friction, and after 2
    /// the creepages.
    pub fn to_numbers(&self) -> Vec<f64> {
        let mut numbers = vec![self.depth.len() as f64];
        numbers.extend(&self.depth);
        let found = self
            .found
            .as_ref()
            .map(Found::to_numbers)
            .unwrap_or_default();
        numbers.push(found.len() as f64);
        numbers.extend(found);
        for patch in &self.patches {
            patch.put_into(&mut numbers);
        }
        numbers
    }

    /// The state that [`WheelState::to_numbers`] made the numbers of.
    ///
    /// # Errors
    /// Numbers that are none.
    pub fn from_numbers(numbers: &[f64]) -> Result<Self, Error> {
        let cut = Error::State {
            part: "its numbers",
            reason: "some are missing, or a count is none",
        };
        let mut rest = numbers;
        let mut take = |count: f64| {
            let count = (count.fract() == 0.0 && (0.0..1e9).contains(&count))
                .then_some(count as usize)
                .ok_or_else(|| cut.clone())?;
            let (head, tail) = rest.split_at_checked(count).ok_or_else(|| cut.clone())?;
            rest = tail;
            Ok::<_, Error>((head, tail.is_empty()))
        };
        let (count, _) = take(1.0)?;
        let (depth, _) = take(count[0])?;
        let (count, _) = take(1.0)?;
        let (known, mut is_done) = take(count[0])?;
        let found = if known.is_empty() {
            None
        } else {
            Some(Found::from_numbers(known)?)
        };
        let mut state = Self {
            depth: depth.to_vec(),
            found,
            patches: Vec::new(),
        };
        while !is_done {
            let (head, _) = take(5.0)?;
            let side = match head[0] {
                1.0 => Side::Left,
                -1.0 => Side::Right,
                _ => return Err(cut),
            };
            let is_whole = |v: &f64| v.fract() == 0.0 && v.abs() <= FARTHEST;
            if !head.iter().all(is_whole) || head[3] < 0.0 || head[4] < 0.0 {
                return Err(cut);
            }
            let (ratio, _) = take(2.0 * head[3] * head[4])?;
            let has_history;
            (has_history, is_done) = take(1.0)?;
            let history = match has_history {
                [0.0] => None,
                [1.0 | 2.0] => {
                    let (place, _) = take(4.0)?;
                    let (pressure, _) = take(head[3] * head[4])?;
                    let (coefficient, creepage);
                    (coefficient, is_done) = take(head[3] * head[4])?;
                    (creepage, is_done) = match has_history {
                        [2.0] => {
                            let (creepage, is_last) = take(3.0)?;
                            (Some([creepage[0], creepage[1], creepage[2]]), is_last)
                        }
                        _ => (None, is_done),
                    };
                    Some(PatchHistory {
                        position: [place[0], place[1], place[2]],
                        angle: place[3],
                        pressure: pressure.to_vec(),
                        coefficient: coefficient.to_vec(),
                        creepage,
                    })
                }
                _ => return Err(cut),
            };
            state.patches.push(PatchRatio {
                side,
                first: [head[1] as i64, head[2] as i64],
                nx: head[3] as usize,
                ny: head[4] as usize,
                ratio: ratio.to_vec(),
                history,
            });
        }
        state.check()?;
        Ok(state)
    }

    /// Whether its patches lie on planes, or follow the rail: these lie at no height.
    pub(crate) fn check_ground(&self, conformal: bool) -> Result<(), Error> {
        let other = self.patches.iter().find(|patch| {
            (patch.history.as_ref()).is_some_and(|history| {
                let [_, y, z] = history.position;
                (y == 0.0 && z == 0.0 && history.angle == 0.0) != conformal
            })
        });
        other.map_or(Ok(()), |patch| {
            Err(Error::OtherGround {
                side: patch.side,
                conformal,
            })
        })
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let wrong = |part, reason| Err(Error::State { part, reason });
        if self.depth.len() > 2 || self.depth.iter().any(|d| !(*d > 0.0 && d.is_finite())) {
            return wrong("depth", "at most two overlaps > 0 [m] are needed");
        }
        if let Some(found) = &self.found {
            check_entries("state.found", &found.to_numbers())?;
            if found.slope.len() > MOST_SLOPES {
                return wrong("found", "at most 64 derivatives are needed");
            }
        }
        for patch in &self.patches {
            let cells = patch
                .nx
                .checked_mul(patch.ny)
                .and_then(|n| n.checked_mul(2));
            if cells != Some(patch.ratio.len()) {
                return wrong("ratio", "it does not have the size of its grid");
            }
            if patch.ratio.iter().any(|r| r.is_nan() || r.abs() > LARGEST) {
                return wrong("ratio", "finite numbers of at most 1e+12 are needed");
            }
            if patch.first.iter().any(|f| (*f as f64).abs() > FARTHEST) {
                return wrong("first", "grid lines up to 1e+15 are needed");
            }
            let Some(history) = &patch.history else {
                continue;
            };
            check_entries("state.history position", &history.position)?;
            check_entries("state.history angle", &[history.angle])?;
            let creepage = history.creepage.as_ref().map_or(&[][..], |c| &c[..]);
            check_entries("state.history creepage", creepage)?;
            for (part, field) in [
                ("history pressure", &history.pressure),
                ("history coefficient", &history.coefficient),
            ] {
                check_entries("state.history", field)?;
                if 2 * field.len() != patch.ratio.len() {
                    return wrong(part, "it does not have the size of its grid");
                }
                if field.iter().any(|value| *value < 0.0) {
                    return wrong(part, "numbers of at least 0 are needed");
                }
            }
        }
        Ok(())
    }
}

impl Found {
    /// Lateral position, creepage, displacements of the rails, derivatives.
    pub fn to_numbers(&self) -> Vec<f64> {
        let mut numbers = vec![self.lateral, self.creepage];
        numbers.extend(self.rails.as_flattened());
        numbers.extend(&self.slope);
        numbers
    }

    /// What [`Found::to_numbers`] made the numbers of.
    ///
    /// # Errors
    /// Fewer numbers than 6.
    pub fn from_numbers(numbers: &[f64]) -> Result<Self, Error> {
        let Some((&[lateral, creepage, a, b, c, d], slope)) =
            numbers.split_first_chunk::<OF_FOUND>()
        else {
            return Err(Error::State {
                part: "found",
                reason: "at least 6 numbers are needed",
            });
        };
        Ok(Self {
            lateral,
            creepage,
            rails: [[a, b], [c, d]],
            slope: slope.to_vec(),
        })
    }
}

/// Tells patches from others: their numbers, bit by bit.
pub(crate) fn mark(patches: &[PatchRatio]) -> u64 {
    let mut numbers = Vec::new();
    for patch in patches {
        patch.put_into(&mut numbers);
    }
    let mut hasher = DefaultHasher::new();
    for number in numbers {
        number.to_bits().hash(&mut hasher);
    }
    hasher.finish()
}

impl PatchRatio {
    /// Adds its numbers, in the order of [`WheelState::to_numbers`].
    fn put_into(&self, numbers: &mut Vec<f64>) {
        let side = if self.side == Side::Left { 1.0 } else { -1.0 };
        let [x, y] = self.first.map(|first| first as f64);
        numbers.extend([side, x, y, self.nx as f64, self.ny as f64]);
        numbers.extend(&self.ratio);
        let Some(history) = &self.history else {
            numbers.push(0.0);
            return;
        };
        numbers.push(if history.creepage.is_some() { 2.0 } else { 1.0 });
        numbers.extend(history.position);
        numbers.push(history.angle);
        numbers.extend(&history.pressure);
        numbers.extend(&history.coefficient);
        numbers.extend(history.creepage.iter().flatten());
    }

    /// The ratio on another grid; zero beyond this one's.
    pub(crate) fn on(&self, lines: Lines) -> Vec<f64> {
        let own = Lines {
            first: self.first,
            nx: self.nx,
            ny: self.ny,
        };
        let halves = self.ratio.chunks_exact((self.nx * self.ny).max(1));
        let mut out: Vec<f64> = halves.flat_map(|half| own.moved(half, lines)).collect();
        out.resize(2 * lines.nx * lines.ny, 0.0);
        out
    }
}

/// The lines of a grid in spacings from the origin of its plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lines {
    pub(crate) first: [i64; 2],
    pub(crate) nx: usize,
    pub(crate) ny: usize,
}

impl Lines {
    pub(crate) fn of(plane: &PlaneGap) -> Self {
        Self {
            first: plane.first,
            nx: plane.nx,
            ny: plane.ny,
        }
    }

    /// A field on these lines, on others; zero beyond these.
    pub(crate) fn moved(self, field: &[f64], to: Self) -> Vec<f64> {
        let mut out = vec![0.0; to.nx * to.ny];
        let offset = [to.first[0] - self.first[0], to.first[1] - self.first[1]];
        // column and row there of the ones here
        let there = |k: usize, offset: i64, count: usize| {
            usize::try_from(k as i64 + offset)
                .ok()
                .filter(|k| *k < count)
        };
        for j in 0..to.ny {
            let Some(row) = there(j, offset[1], self.ny) else {
                continue;
            };
            for i in 0..to.nx {
                if let Some(column) = there(i, offset[0], self.nx) {
                    out[j * to.nx + i] = field[row * self.nx + column];
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn state() -> WheelState {
        let patch = |side, first| PatchRatio {
            side,
            first,
            nx: 3,
            ny: 2,
            ratio: (0..12).map(|k| 0.1 * f64::from(k)).collect(),
            history: (side == Side::Left).then(|| PatchHistory {
                position: [1e-3, 0.75, -2e-4],
                angle: 0.03,
                pressure: vec![1e8; 6],
                coefficient: vec![0.3; 6],
                creepage: (first[1] > 0).then_some([1e-3, -2e-3, 0.05]),
            }),
        };
        WheelState {
            depth: vec![1e-4, 2e-4],
            found: Some(Found {
                lateral: 1e-3,
                creepage: -2e-3,
                rails: [[1e-4, -2e-4], [3e-4, 0.0]],
                slope: vec![1.0, -2.0, 3.0, 4.0],
            }),
            patches: vec![
                patch(Side::Left, [-1, -4]),
                patch(Side::Left, [-1, 4]),
                patch(Side::Right, [0, -7]),
            ],
        }
    }

    #[test]
    fn numbers_come_back() {
        for state in [state(), WheelState::default()] {
            let numbers = state.to_numbers();
            assert_eq!(WheelState::from_numbers(&numbers).unwrap(), state);
        }
        let numbers = state().to_numbers();
        assert!(WheelState::from_numbers(&numbers[..numbers.len() - 1]).is_err());
        assert!(WheelState::from_numbers(&[]).is_err());
        assert!(WheelState::from_numbers(&[1.0, f64::NAN]).is_err());
    }

    #[test]
    fn a_ratio_moves_with_its_grid() {
        let patch = &state().patches[1];
        let on = |first, nx, ny| patch.on(Lines { first, nx, ny });
        assert_eq!(on([-1, 4], 3, 2), patch.ratio);
        let moved = on([0, 5], 2, 2);
        assert_eq!(&moved[..2], &patch.ratio[4..6]);
        assert_eq!(&moved[2..4], &[0.0, 0.0]);
        assert_eq!(&moved[4..6], &patch.ratio[10..]);
        assert_eq!(on([100, 0], 4, 4), [0.0; 32]);
    }

    proptest! {
        #[test]
        fn any_numbers_are_a_state_or_an_error(numbers in prop::collection::vec(
            prop_oneof![any::<f64>(), (-2..4).prop_map(f64::from)], 0..30)
        ) {
            if let Ok(state) = WheelState::from_numbers(&numbers) {
                prop_assert_eq!(state.to_numbers(), numbers);
            }
        }
    }
}
