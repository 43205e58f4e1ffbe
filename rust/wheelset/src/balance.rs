// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pressures of a wheel at a height, and the height at which they carry the force.

use mtb_complementarity::bounded::Status;
use mtb_contact::normal::{Load, Method, NormalContact, Options, Surface, solve_normal};
use mtb_elasticity::half_space::influence;
use mtb_geometry::PlaneGap;
use mtb_operator::{Component, Grid, Monitor};
use nalgebra::DVector;

use crate::error::Error;
use crate::prepared::Ready;
use crate::root::{Halved, Search, differences, find_root, halved};
use crate::wheelset::Side;

/// Relative residual of the normal problem that is accepted.
const ACCEPTED: f64 = 1e-6;
/// The same where the force jumps over the one asked, as the plane of a contact turns: less than the cells make.
const SMALL_JUMP: f64 = 1e-3;
/// Error of the undeformed overlap that the search for height and roll begins with, and the change of height
/// for differences, both over the approach; and the longest step of that search [m].
const LAID: f64 = 1e-2;
const DIFFERENCE: f64 = 1e-4;
const LONGEST: f64 = 5e-4;

/// Patches and pressures of one wheel at one height.
#[derive(Debug)]
pub(crate) struct Trial {
    /// Vertical force of the pressures [N].
    force: f64,
    pub(crate) patches: Vec<Pressed>,
}

/// A patch and its pressure.
#[derive(Debug)]
pub(crate) struct Pressed {
    pub(crate) plane: PlaneGap,
    /// Pressure (n) [Pa].
    pub(crate) pressure: Vec<f64>,
    /// Gap that is left (n) [m].
    pub(crate) gap: Vec<f64>,
}

/// Patches of a wheel and their pressures; `solves` counts the normal problems.
pub(crate) fn trial(
    ready: &Ready,
    side: Side,
    place: &[f64; 6],
    solves: &mut usize,
    monitor: Monitor<'_>,
) -> Result<Trial, Error> {
    let wheelset = &ready.wheelset;
    let joined = ready.joined()?;
    let closing = |offset: [f64; 2], cell: [f64; 2]| {
        influence(&joined, Component::Normal, Component::Normal, offset, cell)
    };
    let [dx, dy] = wheelset.spacing;
    let [centre, axle] = ready.axle(side, place);
    let mut solved = |planes: Vec<PlaneGap>| -> Result<Trial, Error> {
        let mut trial = Trial {
            force: 0.0,
            patches: Vec::new(),
        };
        for plane in planes {
            let approach = plane.approach();
            if approach <= 0.0 {
                continue;
            }
            let gap: Vec<f64> = plane.gap.iter().map(|g| g + approach).collect();
            let contact = NormalContact {
                gap: &gap,
                grid: Grid::new(plane.nx, plane.ny, dx, dy)?,
                surface: Surface::FreeSpace(&closing),
                load: Load::Approach(approach),
                moments: [None, None],
                hardness: None,
                rough: None,
            };
            let options = Options {
                tolerance: Some(ready.accuracy.normal),
                method: Method::Auto,
            };
            let solution = solve_normal(&contact, options, monitor)?;
            *solves += 1;
            let status = match solution.status {
                Status::Solved | Status::Stagnated if solution.residual <= ACCEPTED => None,
                Status::Solved | Status::Stagnated => Some("stagnated"),
                Status::IterationLimit => Some("iteration limit"),
                Status::Unreachable => Some("unreachable"),
            };
            if let Some(status) = status {
                return Err(Error::Normal {
                    side,
                    status,
                    residual: solution.residual,
                });
            }
            let pressure: Vec<f64> = solution.pressure.iter().map(|p| p.max(0.0)).collect();
            trial.force += pressure.iter().sum::<f64>() * dx * dy * plane.angle.cos();
            let gap = solution.gap;
            trial.patches.push(Pressed {
                plane,
                pressure,
                gap,
            });
        }
        Ok(trial)
    };
    let apart = solved(ready.over.patches(centre, axle, wheelset.spacing)?)?;
    if apart.cut_off().is_none() {
        return Ok(apart);
    }
    // two places have grown together, and the border between them cuts the contact
    let over = &ready.over;
    let together = solved(over.patches_grown_together(centre, axle, wheelset.spacing)?)?;
    match together.cut_off() {
        None => Ok(together),
        Some(plane) => Err(Error::CutOff {
            side,
            size: [1e3 * plane.nx as f64 * dx, 1e3 * plane.ny as f64 * dy],
            angle: plane.angle.to_degrees(),
        }),
    }
}

impl Trial {
    /// The first plane on whose grid the contact reaches the edge.
    fn cut_off(&self) -> Option<&PlaneGap> {
        let is_cut = |Pressed {
                          plane, pressure, ..
                      }: &&Pressed| {
            let (nx, n) = (plane.nx, pressure.len());
            let ends = (0..nx).chain(n - nx..n);
            let sides = (0..n).step_by(nx).flat_map(|k| [k, k + nx - 1]);
            ends.chain(sides).any(|k| pressure[k] > 0.0)
        };
        self.patches.iter().find(is_cut).map(|cut| &cut.plane)
    }
}

/// Lowers (and rolls) the wheelset until its wheels carry the force; `place` gets what was found. Also the
/// overlap that does it, for the next step.
///
/// Unknowns are the height [m] and, if free, roll times the distance of the tape circle [m]. Force goes nearly
/// with overlap^(3/2), so force^(2/3) is nearly linear; its first derivatives are those of the undeformed
/// overlap, which cost no solve and know that a roll moves a flange sideways.
pub(crate) fn in_balance(
    ready: &Ready,
    place: &mut [f64; 6],
    known: &[f64],
    solves: &mut usize,
    monitor: Monitor<'_>,
) -> Result<(Vec<Trial>, Vec<f64>), Error> {
    let n = if place[3].is_nan() { 2 } else { 1 };
    if known.len() == n {
        match balance_from(ready, place, known, solves, monitor) {
            // where a flange ran, or other wheels, may be no start for this pose
            Err(
                Error::Geometry(_)
                | Error::Balance { .. }
                | Error::Normal { .. }
                | Error::CutOff { .. },
            ) => {}
            done => return done,
        }
    }
    balance_from(
        ready,
        place,
        &vec![ready.wheelset.approach; n],
        solves,
        monitor,
    )
}

/// The same, from the overlap `depth` on.
fn balance_from(
    ready: &Ready,
    place: &mut [f64; 6],
    depth: &[f64],
    solves: &mut usize,
    monitor: Monitor<'_>,
) -> Result<(Vec<Trial>, Vec<f64>), Error> {
    let wheelset = &ready.wheelset;
    let sides = wheelset.sides.each();
    let is_each = place[3].is_nan();
    let n = depth.len();
    let wanted = wheelset.force * if is_each { 1.0 } else { sides.len() as f64 };
    let depth = DVector::from_row_slice(depth);
    let given = *place;
    let posed = |x: &DVector<f64>| {
        let mut place = given;
        place[2] = x[0];
        if is_each {
            place[3] = x[1] / ready.over.tape();
        }
        place
    };
    let overlap = |x: &DVector<f64>| -> Result<DVector<f64>, Error> {
        let place = posed(x);
        let found: Result<Vec<f64>, Error> = sides
            .iter()
            .map(|side| {
                let [centre, axle] = ready.axle(*side, &place);
                Ok(ready.over.overlap(centre, axle)?)
            })
            .collect();
        let found = DVector::from_vec(found?);
        Ok(if is_each {
            found
        } else {
            DVector::from_element(1, found.max())
        })
    };
    let search = Search {
        tolerance: LAID * wheelset.approach,
        longest: LONGEST,
        small: DIFFERENCE * wheelset.approach,
    };

    let mut level = DVector::zeros(n);
    level[0] = (overlap(&level)? - &depth).max();
    let laid = lay(overlap, &level, &depth, search);
    let start = match laid {
        Ok(Some(laid)) => laid,
        // a flange that climbs: from the wheel that touches first
        Ok(None) | Err(Error::Geometry(_)) => level,
        Err(error) => return Err(error),
    };
    let mut of_overlap = |x: &DVector<f64>| overlap(x);
    let mut slope = differences(&mut of_overlap, &start, &overlap(&start)?, search.small)?;
    for (k, mut row) in slope.row_iter_mut().enumerate() {
        row /= depth[k];
    }
    let mut trials: Vec<Trial> = Vec::new();
    let mut end = None;
    // force^(2/3) over that wanted, less 1; a lifted wheel counts by how far it is up
    let mut carried = |x: &DVector<f64>| -> Result<DVector<f64>, Error> {
        let place = posed(x);
        let tried: Result<Vec<Trial>, Error> = sides
            .iter()
            .map(|side| trial(ready, *side, &place, solves, monitor))
            .collect();
        if let Err(Error::Geometry(why)) = &tried {
            end = Some(why.to_string());
        }
        trials = tried?;
        let forces = trials.iter().map(|trial| trial.force);
        let forces = if is_each {
            DVector::from_iterator(n, forces)
        } else {
            DVector::from_element(1, forces.sum())
        };
        let mut root = forces.map(|force| (force / wanted).powf(2.0 / 3.0));
        if root.iter().any(|r| *r == 0.0) {
            let overlap = overlap(x)?;
            for (r, overlap) in root.iter_mut().zip(&overlap) {
                if *r == 0.0 {
                    *r = (overlap / wheelset.approach).min(0.0);
                }
            }
        }
        Ok(root.add_scalar(-1.0))
    };
    let search = Search {
        tolerance: ready.accuracy.force / 1.5,
        ..search
    };
    let mut found = find_root(&mut carried, start.clone(), slope, search)?;
    let mut jump = None;
    if found.is_none() && n == 1 {
        match halved(&mut carried, &start, search)? {
            Halved::Root(root) => found = Some(root),
            Halved::Jump(ends) => {
                let near = ends.iter().find(|(_, r)| r.abs() < SMALL_JUMP / 1.5);
                found = near.map(|(height, _)| DVector::from_element(1, *height));
                if let Some(found) = &found {
                    carried(found)?;
                }
                jump = Some(ends.map(|(_, r)| wanted * (r + 1.0).max(0.0).powf(1.5)));
            }
            Halved::Nothing => {}
        }
    }
    let Some(found) = found else {
        return Err(Error::Balance {
            is_each,
            wanted,
            reached: trials.iter().map(|trial| trial.force).collect(),
            end,
            jump,
        });
    };
    *place = posed(&found);
    let depth = overlap(&found)?;
    Ok((trials, depth.iter().copied().collect()))
}

/// Where the undeformed bodies overlap by `depth`.
fn lay(
    overlap: impl Fn(&DVector<f64>) -> Result<DVector<f64>, Error>,
    level: &DVector<f64>,
    depth: &DVector<f64>,
    search: Search,
) -> Result<Option<DVector<f64>>, Error> {
    let mut missing = |x: &DVector<f64>| Ok(overlap(x)? - depth);
    let value = missing(level)?;
    let slope = differences(&mut missing, level, &value, search.small)?;
    find_root(&mut missing, level.clone(), slope, search)
}
