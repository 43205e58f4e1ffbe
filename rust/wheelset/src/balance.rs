// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pressures and tractions of a wheel at a height, and the height at which they carry the force.

use std::cell::{Cell, RefCell};
use std::ops::Range;

use mtb_complementarity::bounded::Status;
use mtb_contact::normal::{Load, Method, NormalContact, Options, Surface, solve_normal};
use mtb_geometry::PlaneGap;
use mtb_operator::{Grid, Monitor, side_by_side, unmonitored};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::error::Error;
use crate::memory::{Past, carried};
use crate::prepared::{Accuracy, Ready, Velocity};
use crate::rolling::{Rolled, rolling};
use crate::root::{Halved, Search, find_root, halved, nested};
use crate::rows::frames;
use crate::state::{Lines, PatchRatio, WheelState};
use crate::track::{Place, sign};
use crate::way::Course;
use crate::wheelset::{Side, Sides};

/// Relative residual of the normal problem that is accepted.
const ACCEPTED: f64 = 1e-6;
/// The same where the force jumps over the one asked, as the plane of a contact turns: less than the cells make.
pub(crate) const SMALL_JUMP: f64 = 1e-3;
/// Error of the undeformed overlap that the search for height and roll begins with, and the change of height
/// for differences, both over the approach; and the longest step of that search [m], on wheels of 0.46 m.
const LAID: f64 = 1e-2;
/// Error of the force that the search with the tractions themselves begins with.
pub(crate) const NEAR: f64 = 1e-3;
/// How many times the residuals of pressures and of tractions may be those of the end in the trials up to there and in
/// the first one with the tractions themselves: small beside what these trials miss the force by.
const ROUGH: [f64; 2] = [1e3, 1e3];
pub(crate) const DIFFERENCE: f64 = 1e-4;
pub(crate) const LONGEST: f64 = 5e-4;

/// What a wheel makes of what is given for it.
type OfWheel<'a, I, T> = dyn Fn(Side, I, &mut Effort, Monitor<'_>) -> Result<T, Error> + Sync + 'a;

/// Does `work` for each wheel with its `given`, for both at once where there are two.
pub(crate) fn each_wheel<I: Send, T: Send>(
    sides: Sides,
    given: impl IntoIterator<Item = I>,
    work: &OfWheel<'_, I, T>,
    effort: &mut Effort,
    monitor: Monitor<'_>,
) -> Result<Vec<T>, Error> {
    let mut wheels = sides.each().iter().copied().zip(given);
    let (Some((side, own)), other) = (wheels.next(), wheels.next()) else {
        return Ok(Vec::new());
    };
    let Some((across, its)) = other else {
        return Ok(vec![work(side, own, effort, monitor)?]);
    };
    let mut beside = Effort::default();
    let found = side_by_side(
        monitor,
        |monitor| work(side, own, effort, monitor),
        |monitor| work(across, its, &mut beside, monitor),
    );
    effort.normal_solves += beside.normal_solves;
    effort.iterations += beside.iterations;
    let (own, its) = found?;
    Ok(vec![own, its])
}

/// As [`each_wheel`], of what costs no solve.
fn each_outline<T: Send>(
    sides: Sides,
    work: impl Fn(Side) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    each_wheel(
        sides,
        [(); 2],
        &|side, (), _, _| work(side),
        &mut Effort::default(),
        &unmonitored,
    )
}

/// Overlap [m] of the undeformed bodies of each wheel.
pub(crate) fn overlaps(ready: &Ready, place: &Place) -> Result<Vec<f64>, Error> {
    each_outline(ready.wheelset.sides, |side| {
        Ok(ready.over(side).overlap(ready.axle(side, place))?)
    })
}

/// Patches and pressures of one wheel at one height.
#[derive(Debug)]
pub(crate) struct Trial {
    /// Force of the pressures on the rail [N], as of a left wheel.
    force: Vector3<f64>,
    patches: Vec<Pressed>,
}

/// One wheel at one height: its patches with pressures and tractions.
pub(crate) struct Loaded {
    /// Force on the rail, in the track [N].
    pub(crate) force: Vector3<f64>,
    pub(crate) patches: Vec<Rolled>,
}

/// The wheelset at an instant.
#[derive(Clone, Copy)]
pub(crate) struct Instant<'a> {
    pub(crate) place: &'a Place,
    pub(crate) velocity: Velocity,
    /// Relative residual of the tractions.
    pub(crate) tangential: f64,
    /// What it rolls on from; `None` in steady rolling.
    pub(crate) past: Option<Past<'a>>,
}

/// Where a pressure is known, and the pressure [Pa].
type Known = (Lines, Vec<f64>);

/// What a step has cost so far.
#[derive(Clone, Copy, Default)]
pub(crate) struct Effort {
    pub(crate) normal_solves: usize,
    /// Newton steps of the tangential problems.
    pub(crate) iterations: usize,
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

/// Patches of a wheel and their pressures, to a relative residual of `tolerance`; `known`: pressures at a height near by
/// to start from, patch by patch.
fn trial(
    ready: &Ready,
    side: Side,
    place: &Place,
    (known, tolerance): (&[Known], f64),
    effort: &mut Effort,
    monitor: Monitor<'_>,
) -> Result<Trial, Error> {
    let wheelset = &ready.wheelset;
    let joined = ready.joined()?;
    let closing = |offset, cell| ready.closing.at(&joined, offset, cell);
    let [dx, dy] = wheelset.spacing;
    let pose = ready.axle(side, place);
    let rail = ready.rail(side, place);
    let mut solved = |planes: Vec<PlaneGap>| -> Result<Trial, Error> {
        let mut trial = Trial {
            force: Vector3::zeros(),
            patches: Vec::new(),
        };
        for plane in planes {
            // found as the rail sees it
            let plane = rail.put(plane);
            let approach = plane.approach();
            if approach <= 0.0 {
                continue;
            }
            let gap: Vec<f64> = plane.gap.iter().map(|g| g + approach).collect();
            let start = known.get(trial.patches.len());
            let start = start.map(|(lines, p)| lines.moved(p, Lines::of(&plane)));
            let slope = ready.slope(side, &plane);
            let contact = NormalContact {
                gap: &gap,
                grid: Grid::new(plane.nx, plane.ny, dx, dy)?,
                surface: match &slope {
                    Some(slope) => Surface::Inclined(&closing, slope),
                    None => Surface::FreeSpace(&closing),
                },
                load: Load::Approach(approach),
                moments: [None, None],
                hardness: None,
                rough: None,
                start: start.as_deref(),
            };
            let options = Options {
                tolerance: Some(tolerance),
                method: Method::Auto,
            };
            let solution = solve_normal(&contact, options, monitor)?;
            effort.normal_solves += 1;
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
            let sum = |pressure: &[f64]| pressure.iter().sum::<f64>() * dx * dy;
            if let Some(rows) = frames(&plane) {
                for (row, pressure) in rows.iter().zip(pressure.chunks(plane.nx)) {
                    trial.force -= row.turn.column(2) * sum(pressure);
                }
            } else {
                trial.force -= rail.frame(&plane).column(2) * sum(&pressure);
            }
            let gap = solution.gap;
            trial.patches.push(Pressed {
                plane,
                pressure,
                gap,
            });
        }
        Ok(trial)
    };
    let cut_off = |plane: &PlaneGap| Error::CutOff {
        side,
        size: [1e3 * plane.nx as f64 * dx, 1e3 * plane.ny as f64 * dy],
        angle: plane.angle.to_degrees(),
    };
    let over = ready.over(side);
    if wheelset.conformal {
        let found = solved(over.patches_along_rail(pose, wheelset.spacing)?)?;
        return match found.cut_off().map(cut_off) {
            Some(error) => Err(error),
            None => Ok(found),
        };
    }
    let apart = solved(over.patches(pose, wheelset.spacing)?)?;
    if apart.cut_off().is_none() {
        return Ok(apart);
    }
    // two places have grown together, and the border between them cuts the contact
    let together = solved(over.patches_grown_together(pose, wheelset.spacing)?)?;
    match together.cut_off() {
        None => Ok(together),
        Some(plane) => Err(cut_off(plane)),
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

/// A wheel in a pose, given its height.
pub(crate) fn loaded(
    ready: &Ready,
    side: Side,
    instant: Instant<'_>,
    known: &[PatchRatio],
    effort: &mut Effort,
    monitor: Monitor<'_>,
) -> Result<Loaded, Error> {
    let anew: (&[Known], f64) = (&[], ready.accuracy.normal);
    let trial = trial(ready, side, instant.place, anew, effort, monitor)?;
    rolled(ready, side, instant, known, trial, effort, monitor)
}

/// The tractions of pressed patches; `known`: traction over pressure to try first.
fn rolled(
    ready: &Ready,
    side: Side,
    instant: Instant<'_>,
    known: &[PatchRatio],
    trial: Trial,
    effort: &mut Effort,
    monitor: Monitor<'_>,
) -> Result<Loaded, Error> {
    let (centre, rigid) = ready.motion(instant.place, instant.velocity);
    let mut known = known.iter().filter(|known| known.side == side);
    let mut loaded = Loaded {
        force: Vector3::zeros(),
        patches: Vec::new(),
    };
    let courses: Vec<Course> = match instant.past {
        Some(past) => {
            let before = carried(ready, side, instant.place, past.patches, &trial.patches)?;
            let rolls_on = |before: Option<_>| Course::Transient {
                duration: past.duration,
                before: before.map(Box::new),
            };
            before.into_iter().map(rolls_on).collect()
        }
        None => trial.patches.iter().map(|_| Course::Steady).collect(),
    };
    for (pressed, course) in trial.patches.into_iter().zip(courses) {
        let plane = &pressed.plane;
        let start = known.next().map(|known| known.on(Lines::of(plane)));
        let rolled = rolling(
            ready,
            side,
            pressed,
            instant,
            (centre, &rigid),
            course,
            start.as_deref(),
            monitor,
        )?;
        effort.iterations += rolled.iterations;
        loaded.force += Vector3::from(rolled.patch.load(centre.into())[0]);
        loaded.patches.push(rolled);
    }
    Ok(loaded)
}

/// The wheels of a search, with what the pose before has left.
pub(crate) struct Wheels<'a> {
    ready: &'a Ready,
    pub(crate) velocity: Velocity,
    /// Relative residual of the pressures, and that of the tractions.
    normal: f64,
    pub(crate) tangential: f64,
    past: Option<Past<'a>>,
    ratios: Vec<PatchRatio>,
    /// Pressures of the last trial, wheel by wheel.
    known: Vec<Vec<Known>>,
    /// A pose and the pressures in it.
    pressed: Option<(Place, Vec<Trial>)>,
    pub(crate) loaded: Vec<Loaded>,
    effort: &'a mut Effort,
    monitor: Monitor<'a>,
}

/// Pressures of the last step, wheel by wheel.
fn known_from(ready: &Ready, state: &WheelState) -> Vec<Vec<Known>> {
    let of_patch = |patch: &PatchRatio| {
        let lines = Lines {
            first: patch.first,
            nx: patch.nx,
            ny: patch.ny,
        };
        Some((lines, patch.history.as_ref()?.pressure.clone()))
    };
    let of_wheel = |side: &Side| {
        let patches = state.patches.iter().filter(|patch| patch.side == *side);
        patches.map_while(of_patch).collect()
    };
    ready.wheelset.sides.each().iter().map(of_wheel).collect()
}

impl<'a> Wheels<'a> {
    /// Of a step that begins with what the last one has left, and rolls on from it in so many seconds [s].
    pub(crate) fn new(
        ready: &'a Ready,
        velocity: Velocity,
        state: &'a WheelState,
        duration: Option<f64>,
        effort: &'a mut Effort,
        monitor: Monitor<'a>,
    ) -> Self {
        Self {
            ready,
            velocity,
            normal: ready.accuracy.normal,
            tangential: ready.accuracy.tangential,
            past: duration.map(|duration| Past::new(duration, state)),
            ratios: state.patches.clone(),
            known: known_from(ready, state),
            pressed: None,
            loaded: Vec::new(),
            effort,
            monitor,
        }
    }

    /// Solves to so many times the residuals of the end.
    fn loosen(&mut self, [normal, tangential]: [f64; 2]) {
        let Accuracy {
            normal: of_pressure,
            tangential: of_traction,
            ..
        } = self.ready.accuracy;
        (self.normal, self.tangential) = (normal * of_pressure, tangential * of_traction);
    }

    /// Forgets what the pose before has left.
    pub(crate) fn forget(&mut self) {
        self.ratios.clear();
        self.known.clear();
        self.pressed = None;
    }

    fn pressed(&mut self, place: &Place) -> Result<Vec<Trial>, Error> {
        let (ready, tolerance) = (self.ready, self.normal);
        let sides = ready.wheelset.sides;
        self.known.resize(sides.each().len(), Vec::new());
        let trials = each_wheel(
            sides,
            &self.known,
            &|side, known: &Vec<Known>, effort, monitor| {
                trial(ready, side, place, (known, tolerance), effort, monitor)
            },
            self.effort,
            self.monitor,
        )?;
        let of_wheel = |trial: &Trial| {
            let pressed = trial.patches.iter();
            pressed
                .map(|p| (Lines::of(&p.plane), p.pressure.clone()))
                .collect()
        };
        self.known = trials.iter().map(of_wheel).collect();
        Ok(trials)
    }

    /// Forces on the rails with the traction over pressure held, which costs no tangential problem.
    pub(crate) fn with_known_ratios(&mut self, place: &Place) -> Result<Vec<Vector3<f64>>, Error> {
        let trials = self.pressed(place)?;
        let area: f64 = self.ready.wheelset.spacing.iter().product();
        let each = self.ready.wheelset.sides.each().iter();
        let forces = each.zip(&trials).map(|(side, trial)| {
            let mut known = self.ratios.iter().filter(|known| known.side == *side);
            let mut force = trial.force;
            let rail = self.ready.rail(*side, place);
            for pressed in &trial.patches {
                let Some(known) = known.next() else {
                    break;
                };
                let plane = &pressed.plane;
                let ratio = known.on(Lines::of(plane));
                let n = pressed.pressure.len();
                let sums = |cells: Range<usize>| {
                    let [along, across] = [0, n].map(|from| {
                        let own = ratio[from + cells.start..from + cells.end].iter();
                        let pressure = &pressed.pressure[cells.clone()];
                        own.zip(pressure).map(|(r, p)| r * p).sum::<f64>() * area
                    });
                    Vector3::new(along, across, 0.0)
                };
                if let Some(rows) = frames(plane) {
                    for (k, row) in rows.iter().enumerate() {
                        force += row.turn * sums(k * plane.nx..(k + 1) * plane.nx);
                    }
                } else {
                    force += rail.frame(plane) * sums(0..n);
                }
            }
            force.y *= sign(*side);
            force
        });
        let forces = forces.collect();
        self.pressed = Some((*place, trials));
        Ok(forces)
    }

    /// Forces on the rails of pressures and tractions.
    pub(crate) fn with_friction(&mut self, place: &Place) -> Result<Vec<Vector3<f64>>, Error> {
        let trials = match self.pressed.take() {
            Some((at, trials)) if at == *place => trials,
            _ => self.pressed(place)?,
        };
        let instant = Instant {
            place,
            velocity: self.velocity,
            tangential: self.tangential,
            past: self.past,
        };
        let (ready, known) = (self.ready, &self.ratios);
        self.loaded = each_wheel(
            ready.wheelset.sides,
            trials,
            &|side, trial, effort, monitor| {
                rolled(ready, side, instant, known, trial, effort, monitor)
            },
            self.effort,
            self.monitor,
        )?;
        let patches = self.loaded.iter().flat_map(|wheel| &wheel.patches);
        self.ratios = patches.map(|rolled| rolled.ratio.clone()).collect();
        Ok(self.loaded.iter().map(|wheel| wheel.force).collect())
    }
}

/// A wheelset whose wheels carry the force, with the overlap and the derivatives that the next step begins with.
pub(crate) struct Balanced {
    pub(crate) loaded: Vec<Loaded>,
    pub(crate) depth: Vec<f64>,
    pub(crate) slope: Vec<f64>,
}

/// Lowers (and rolls) the wheelset until its wheels carry the force; `place` gets what was found.
///
/// Unknowns are the height [m] and, if free, roll times the distance of the tape circle [m]. Force goes nearly
/// with overlap^(3/2), so force^(2/3) is nearly linear; its first derivatives are those of the undeformed
/// overlap, which cost no solve and know that a roll moves a flange sideways. The search begins with the traction
/// over pressure of the step before, or none, and goes on with the tractions themselves.
pub(crate) fn in_balance(
    ready: &Ready,
    place: &mut Place,
    velocity: Velocity,
    state: &WheelState,
    duration: Option<f64>,
    effort: &mut Effort,
    monitor: Monitor<'_>,
) -> Result<Balanced, Error> {
    let n = if place.pose[3].is_nan() { 2 } else { 1 };
    let balance = Balance {
        ready,
        given: *place,
        is_each: n == 2,
    };
    let mut wheels = Wheels::new(ready, velocity, state, duration, effort, monitor);
    let mut root = None;
    if state.depth.len() == n {
        let depth = DVector::from_row_slice(&state.depth);
        let known = (state.found.iter().map(|found| &found.slope)).find(|s| s.len() == n * n);
        let known = known.map(|slope| DMatrix::from_column_slice(n, n, slope));
        match balance.from(&depth, known, false, &mut wheels) {
            // where a flange ran, or other wheels, may be no start for this pose
            Err(
                Error::Geometry(_)
                | Error::Balance { .. }
                | Error::Normal { .. }
                | Error::Tangential { .. }
                | Error::CutOff { .. },
            ) => {}
            done => root = Some(done?),
        }
    }
    let root = if let Some(root) = root {
        root
    } else {
        wheels.forget();
        let depth = DVector::from_element(n, ready.wheelset.approach);
        balance.from(&depth, None, true, &mut wheels)?
    };
    let (root, slope) = root;
    *place = balance.posed(&root);
    let depth = balance.overlap(&root)?;
    Ok(Balanced {
        loaded: wheels.loaded,
        depth: depth.iter().copied().collect(),
        slope: slope.as_slice().to_vec(),
    })
}

/// The force [N] of each wheel on its rail in a pose.
type Carried<'a> = dyn FnMut(&Place) -> Result<Vec<Vector3<f64>>, Error> + 'a;

/// The search for a height (and roll).
pub(crate) struct Balance<'a> {
    pub(crate) ready: &'a Ready,
    /// The pose as it was asked for.
    pub(crate) given: Place,
    /// Whether each wheel is to carry the force by itself.
    pub(crate) is_each: bool,
}

impl Balance<'_> {
    fn posed(&self, x: &DVector<f64>) -> Place {
        let mut place = self.given;
        place.pose[2] = x[0];
        if self.is_each {
            place.pose[3] = x[1] / self.ready.tape();
        }
        place
    }

    /// Overlap [m] of the undeformed bodies: of each wheel, or the largest.
    pub(crate) fn overlap(&self, x: &DVector<f64>) -> Result<DVector<f64>, Error> {
        let found = DVector::from_vec(overlaps(self.ready, &self.posed(x))?);
        Ok(if self.is_each {
            found
        } else {
            DVector::from_element(1, found.max())
        })
    }

    /// How far a search goes, and what it accepts.
    fn search(&self, tolerance: f64) -> Search {
        Search {
            tolerance,
            longest: self.ready.wheelset.sized(LONGEST),
            small: DIFFERENCE * self.ready.wheelset.approach,
            trials: usize::MAX,
        }
    }

    /// Where the undeformed bodies overlap by `depth`, with the first derivatives of the residual of
    /// [`Balance::find`] there.
    pub(crate) fn laid(&self, depth: &DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), Error> {
        let mut level = DVector::zeros(depth.len());
        level[0] = (self.overlap(&level)? - depth).max();
        if !self.is_each {
            // the overlap falls with the height, one for one
            return Ok((level, DMatrix::from_element(1, 1, -1.0 / depth[0])));
        }
        let search = self.search(LAID * self.ready.wheelset.approach);
        let mut missing = |x: &DVector<f64>| Ok(self.overlap(x)? - depth);
        let mut slope = self.overlap_slope(&level)?;
        let laid = match find_root(&mut missing, level.clone(), &mut slope, search) {
            Ok(Some(laid)) => laid,
            // a flange that climbs: from the wheel that touches first
            Ok(None) | Err(Error::Geometry(_)) => level,
            Err(error) => return Err(error),
        };
        let slope = self.slope(&laid)?;
        Ok((laid, slope))
    }

    /// Where the wheels carry the force, from an overlap [m] on, with the derivatives there; `known` ones are those of
    /// the step before, friction included. The last try takes a small jump of the force for a height and a roll.
    fn from(
        &self,
        depth: &DVector<f64>,
        known: Option<DMatrix<f64>>,
        is_last: bool,
        wheels: &mut Wheels<'_>,
    ) -> Result<(DVector<f64>, DMatrix<f64>), Error> {
        let (start, slope) = self.laid(depth)?;
        let slope = known.unwrap_or(slope);
        wheels.loosen(ROUGH);
        let near = self.find(
            &start,
            slope.clone(),
            &mut |place| wheels.with_known_ratios(place),
            NEAR,
            false,
        );
        let (near, slope) = match near {
            Ok(near) => near,
            // what this friction does not carry, another may
            Err(Error::Balance { .. }) => (start, slope),
            Err(error) => return Err(error),
        };
        let accuracy = self.ready.accuracy.force;
        let trials = Cell::new(0);
        let mut carry = |place: &Place| {
            if trials.get() > 0 {
                wheels.loosen([1.0; 2]);
            }
            trials.set(trials.get() + 1);
            wheels.with_friction(place)
        };
        let (found, slope) = self.find(&near, slope, &mut carry, accuracy, is_last)?;
        if trials.get() > 1 {
            return Ok((found, slope));
        }
        // met at once, by rough pressures
        self.find(&found, slope, &mut carry, accuracy, is_last)
    }

    /// First derivatives of the residual of [`Balance::find`].
    fn slope(&self, start: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        let approach = self.ready.wheelset.approach;
        let depth = self.overlap(start)?;
        let mut slope = self.overlap_slope(start)?;
        for (k, mut row) in slope.row_iter_mut().enumerate() {
            // where nothing overlaps yet, as if it were what may carry the force
            row /= if depth[k] > 0.0 { depth[k] } else { approach };
        }
        Ok(slope)
    }

    /// First derivatives of the overlap of each wheel.
    fn overlap_slope(&self, x: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        let place = self.posed(x);
        let mut by = [Place::default(), Place::default()];
        by[0].pose[2] = 1.0;
        by[1].pose[3] = 1.0 / self.ready.tape();
        let ready = self.ready;
        let changes = each_outline(ready.wheelset.sides, |side| {
            let moved = by.each_ref().map(|by| ready.axle_change(side, &place, by));
            Ok(ready
                .over(side)
                .overlap_change(ready.axle(side, &place), &moved)?)
        })?;
        Ok(DMatrix::from_row_iterator(
            x.len(),
            x.len(),
            changes.concat(),
        ))
    }

    /// Where the wheels carry the force, to a relative `accuracy`, with the derivatives there; the last call of
    /// `carry` is there.
    fn find(
        &self,
        start: &DVector<f64>,
        mut slope: DMatrix<f64>,
        carry: &mut Carried<'_>,
        accuracy: f64,
        is_last: bool,
    ) -> Result<(DVector<f64>, DMatrix<f64>), Error> {
        let wheelset = &self.ready.wheelset;
        let sides = wheelset.sides.each().len() as f64;
        let wanted = wheelset.force * if self.is_each { 1.0 } else { sides };
        let search = self.search(accuracy / 1.5);
        let mut reached: Vec<f64> = Vec::new();
        let mut end = None;
        let best = RefCell::new((f64::INFINITY, start.clone()));
        // force^(2/3) over that wanted, less 1; a lifted wheel counts by how far it is up
        let mut carried = |x: &DVector<f64>| -> Result<DVector<f64>, Error> {
            let tried = carry(&self.posed(x));
            if let Err(why @ (Error::Geometry(_) | Error::CutOff { .. })) = &tried {
                end = Some(why.to_string());
            }
            reached = tried?.iter().map(|force| -force.z).collect();
            let forces = if self.is_each {
                DVector::from_row_slice(&reached)
            } else {
                DVector::from_element(1, reached.iter().sum())
            };
            let mut root = forces.map(|force| stretched(force / wanted, 2.0 / 3.0));
            if root.iter().any(|r| *r == 0.0) {
                let overlap = self.overlap(x)?;
                for (r, overlap) in root.iter_mut().zip(&overlap) {
                    if *r == 0.0 {
                        *r = (overlap / wheelset.approach).min(0.0);
                    }
                }
            }
            let missing = root.add_scalar(-1.0);
            let mut best = best.borrow_mut();
            if missing.amax() < best.0 {
                *best = (missing.amax(), x.clone());
            }
            Ok(missing)
        };
        let mut found = find_root(&mut carried, start.clone(), &mut slope, search)?;
        let mut jump = None;
        if found.is_none() && self.is_each && is_last {
            let from = best.borrow().1.clone();
            found = nested(&mut carried, &from, search)?;
            let (missing, nearest) = best.borrow().clone();
            // what is within a small jump is taken for one
            if found.is_none() && missing < SMALL_JUMP / 1.5 {
                carried(&nearest)?;
                found = Some(nearest);
            }
        }
        if found.is_none() && !self.is_each {
            match halved(&mut carried, start, search)? {
                Halved::Root(root) => found = Some(root),
                Halved::Jump(ends) => {
                    let near = ends.iter().find(|(_, r)| r.abs() < SMALL_JUMP / 1.5);
                    found = near.map(|(height, _)| DVector::from_element(1, *height));
                    if let Some(found) = &found {
                        carried(found)?;
                    }
                    jump = Some(ends.map(|(_, r)| wanted * stretched(r + 1.0, 1.5)));
                }
                Halved::Nothing => {}
            }
        }
        match found {
            Some(found) => Ok((found, slope)),
            None => Err(Error::Balance {
                is_each: self.is_each,
                wanted,
                reached,
                end,
                jump,
            }),
        }
    }
}

/// A power of the size of a number, with its sign.
pub(crate) fn stretched(value: f64, power: f64) -> f64 {
    value.abs().powf(power).copysign(value)
}
