// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pose, rotation and displacement of the rails at which wheels carry prescribed forces.
//!
//! All unknowns are found together by Newton's method. Where that does not lead there, the equilibrium is looked for
//! along the curve of poses in which everything but the lateral force is as asked: on the tread the curve goes across
//! the track, on a flange upwards, so that its own length is what it is followed by, and not a component of the pose.
//! Where y is given and rails on springs or a rotation are not found, a curve leads there from the middle of the track.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::balance::{
    Balance, DIFFERENCE, Effort, LONGEST, Loaded, NEAR, SMALL_JUMP, Wheels, overlaps, stretched,
};
use crate::error::Error;
use crate::prepared::{AxleLoad, Ready, StepInput, Velocity, rotation};
use crate::root::{Search, differences, find_root};
use crate::state::{Found, WheelState};
use crate::track::{Place, index};
use crate::wheelset::{Side, Wheelset};
use mtb_operator::Monitor;

// lengths are those on wheels of 0.46 m, see `Wheelset::sized`

/// Length [m] that stands for a creepage of one, so that all unknowns are lengths of like size.
const OF_CREEPAGE: f64 = 0.1;
/// Largest creepage that is looked for.
const MOST_CREEPAGE: f64 = 0.2;
/// Steps along a curve [m]: the first, the shortest, the longest; and how many of them.
const FIRST_STEP: f64 = 1e-4;
const SHORTEST: f64 = 1e-6;
const MOST_STEPS: usize = 120;
/// Longest step [m] where the curve is straight, how far it may bend away from it over its length, and the overlap
/// there that ends a try, over the one here: a flange ahead is met by short steps.
const LONGEST_STRAIGHT: f64 = 2e-3;
const MOST_BEND: f64 = 0.1;
const MOST_OVERLAP: f64 = 2.0;
/// Longest way along a curve [m]: over the tread to a flange and up to its top.
const LONGEST_WAY: f64 = 3e-2;
/// Steps [m] over a place where the contact plane turns and the forces jump.
const OVER_JUMP: [f64; 6] = [3e-6, 1e-5, 3e-5, 1e-4, 2e-4, 4e-4];
/// Steps [m] across the track over a jump to another contact.
const ACROSS_JUMP: [f64; 3] = [5e-5, 2e-4, 5e-4];
/// How far from a jump [m] its end is found: derivatives by differences are not to cross it.
const BESIDE_JUMP: [f64; 3] = [0.0, 2e-8, 2e-7];
/// Halvings of a step in which the lateral force passes the one asked for.
const HALVINGS: usize = 24;
/// Where between two places on the curve a third is looked for, in this order: the curve may be broken at some.
const SHARES: [f64; 9] = [0.5, 0.25, 0.75, 0.125, 0.875, 0.375, 0.625, 0.05, 0.95];
/// Farthest way [m] from the last step to an equilibrium that is taken without following the curve.
const NEARBY: f64 = 1.5e-3;
/// How far a rail may have been moved aside since the last step [m].
const ASIDE: [f64; 8] = [5e-5, -5e-5, 1e-4, -1e-4, 2e-4, -2e-4, 4e-4, -4e-4];
/// Trials for each unknown, and one more, of a search where another way is left.
const FEW: usize = 4;
/// Residual of the tractions over that of other steps.
const OF_TRACTIONS: f64 = 1e-2;
/// What is left of the error of the forces along a curve.
const ALONG: f64 = 2e-4;

/// What a step finds beside height and roll.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Open {
    lateral: bool,
    rotation: bool,
    springs: bool,
}

impl Open {
    pub(crate) fn of(wheelset: &Wheelset, input: &StepInput) -> Self {
        let springs = wheelset.springs.as_ref();
        Self {
            lateral: input.lateral_force.is_some(),
            rotation: input.axle_load.is_some(),
            springs: springs.is_some_and(|springs| springs.stiffness != [f64::INFINITY; 2]),
        }
    }

    pub(crate) fn is_any(self) -> bool {
        self.lateral || self.rotation || self.springs
    }
}

/// An equilibrium.
pub(crate) struct Settled {
    pub(crate) place: Place,
    pub(crate) velocity: Velocity,
    pub(crate) loaded: Vec<Loaded>,
    pub(crate) depth: Vec<f64>,
    pub(crate) found: Found,
    /// Largest departure of a force from the one asked for, over the vertical one.
    pub(crate) error: f64,
}

/// What is found from balance, each of one equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unknown {
    Height,
    Roll,
    Lateral,
    Rotation,
    /// y (0) or z (1) of a rail on its springs.
    Rail(Side, usize),
}

impl Unknown {
    /// The component of the pose that it is, if it is one.
    pub(crate) fn component(self) -> Option<usize> {
        match self {
            Self::Lateral => Some(1),
            Self::Height => Some(2),
            Self::Roll => Some(3),
            Self::Rotation | Self::Rail(..) => None,
        }
    }

    /// All that a step leaves open.
    pub(crate) fn all_of(wheelset: &Wheelset, input: &StepInput) -> Vec<Self> {
        let open = Open::of(wheelset, input);
        let mut unknowns = Vec::new();
        if input.pose[2].is_nan() {
            unknowns.push(Self::Height);
        }
        if input.pose[3].is_nan() {
            unknowns.push(Self::Roll);
        }
        if open.lateral {
            unknowns.push(Self::Lateral);
        }
        if open.rotation {
            unknowns.push(Self::Rotation);
        }
        if let Some(springs) = &wheelset.springs {
            for side in wheelset.sides.each() {
                for c in (0..2).filter(|c| springs.stiffness[*c].is_finite()) {
                    unknowns.push(Self::Rail(*side, c));
                }
            }
        }
        unknowns
    }
}

/// Which tractions a trial takes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Tractions {
    /// Those of the trial before, over the pressure.
    Known,
    Solved,
}

/// Which unknowns and equations a search has, after how many trials it is given up, and where it stays.
struct Part {
    unknowns: Vec<usize>,
    equations: Vec<usize>,
    trials: usize,
    /// Direction, in the unknowns of the part, and the place beside which a search stays.
    beside: Option<(DVector<f64>, DVector<f64>)>,
}

/// A root and the derivatives there.
type Root = (DVector<f64>, DMatrix<f64>);

/// A place on a curve and the lateral force there that is missing, over the vertical one.
#[derive(Clone)]
struct Reached {
    x: DVector<f64>,
    missing: f64,
}

struct Equilibrium<'a, 'w> {
    ready: &'a Ready,
    input: &'a StepInput,
    unknowns: Vec<Unknown>,
    wheels: &'w mut Wheels<'a>,
    /// The y [m] that is given, where a curve across the track leads there; else y is found for a lateral force.
    across: Option<f64>,
    /// The last trial with tractions of its own: unknowns and residuals.
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// The trial with tractions of its own where forces depart least, and by how much.
    nearest: Option<(f64, DVector<f64>)>,
    /// Forces of the last trial, in the order of [`Equilibrium::wanted`].
    reached: Vec<f64>,
    /// What ended the last trial that could not be made.
    end: Option<String>,
    /// Trials of a search where another way is left.
    few: usize,
}

/// Finds all that a step leaves open.
pub(crate) fn in_equilibrium(
    ready: &Ready,
    input: &StepInput,
    open: Open,
    state: &WheelState,
    effort: &mut Effort,
    monitor: Monitor<'_>,
) -> Result<Settled, Error> {
    let unknowns = Unknown::all_of(&ready.wheelset, input);
    // forces across and along are made of tractions
    let tangential = OF_TRACTIONS * ready.accuracy.tangential;
    // a step that found no more than height and roll tells nothing of the rest
    let plain = (unknowns
        .iter()
        .filter(|u| matches!(u, Unknown::Height | Unknown::Roll)))
    .count();
    let is_resumed = (state.found.as_ref()).is_some_and(|f| f.slope.len() > plain * plain)
        && !state.depth.is_empty();
    let mut wheels = Wheels::new(
        ready,
        input.velocity,
        state,
        input.duration,
        effort,
        monitor,
    );
    wheels.tangential = tangential;
    let mut search = Equilibrium {
        ready,
        input,
        unknowns,
        wheels: &mut wheels,
        across: None,
        last: None,
        nearest: None,
        reached: Vec::new(),
        end: None,
        few: 0,
    };
    search.few = FEW * (search.unknowns.len() + 1);
    let known = state.found.clone().unwrap_or_default();
    if is_resumed {
        if let Some(settled) = search.near_last(&known, &state.depth)? {
            return Ok(settled);
        }
        search.wheels.forget();
    }
    if !open.lateral {
        if is_resumed && let Some(settled) = search.near_aside(&known, &state.depth)? {
            return Ok(settled);
        }
        return search.afresh();
    }
    search.along_curve(&known, &state.depth)
}

impl Equilibrium<'_, '_> {
    fn position(&self, unknown: Unknown) -> Option<usize> {
        self.unknowns.iter().position(|own| *own == unknown)
    }

    fn has_rails(&self) -> bool {
        (self.unknowns.iter()).any(|unknown| matches!(unknown, Unknown::Rail(..)))
    }

    fn sized(&self, length: f64) -> f64 {
        self.ready.wheelset.sized(length)
    }

    /// Pose, rails and velocity.
    fn posed(&self, x: &DVector<f64>) -> (Place, Velocity) {
        let mut place = Place {
            pose: self.input.pose,
            alignment: self.input.alignment,
        };
        let mut creepage = None;
        for (unknown, value) in self.unknowns.iter().zip(x) {
            match unknown {
                Unknown::Height => place.pose[2] = *value,
                Unknown::Roll => place.pose[3] = value / self.ready.tape(),
                Unknown::Lateral => place.pose[1] = *value,
                Unknown::Rotation => creepage = Some(value / self.sized(OF_CREEPAGE)),
                Unknown::Rail(side, c) => place.alignment.rails[index(*side)].place[*c] += value,
            }
        }
        let Some(creepage) = creepage else {
            return (place, self.input.velocity);
        };
        let (_, mut rigid) = self.ready.motion(&place, self.input.velocity);
        let axle = rotation(&place.pose).column(1).into_owned();
        let spin = Vector3::new(rigid[3], rigid[4], rigid[5]);
        // the tape circle is so much faster than the middle of the axle, which turns about the reference point; over a
        // roller the middle stays
        let faster = 1.0 + creepage;
        let above = match self.ready.wheelset.pair.roller_radius {
            Some(_) => 0.0,
            None => (rotation(&place.pose) * self.ready.arm()).z,
        };
        let rolling = faster * rigid[0] / (self.ready.rolling_radius - faster * above);
        let spin = spin + axle * (rolling - axle.dot(&spin));
        rigid[3..].copy_from_slice(spin.as_slice());
        (place, Velocity::Rigid(rigid))
    }

    /// Names of the forces asked for, and their sizes.
    fn wanted(&self) -> Vec<(&'static str, f64)> {
        let wheelset = &self.ready.wheelset;
        let sides = wheelset.sides.each().len() as f64;
        let mut wanted = Vec::new();
        for unknown in &self.unknowns {
            if *unknown == Unknown::Lateral && self.across.is_some() {
                continue;
            }
            wanted.push(match unknown {
                Unknown::Height if self.position(Unknown::Roll).is_some() => {
                    ("a vertical force [N] of the left wheel", wheelset.force)
                }
                Unknown::Height => ("a vertical force [N]", sides * wheelset.force),
                Unknown::Roll => ("a vertical force [N] of the right wheel", wheelset.force),
                Unknown::Lateral => (
                    "a lateral force [N]",
                    self.input.lateral_force.unwrap_or_default(),
                ),
                Unknown::Rotation => match self.input.axle_load {
                    Some(AxleLoad::Moment(moment)) => ("a moment about the axle [N m]", moment),
                    Some(AxleLoad::LongitudinalForce(force)) => {
                        ("a force along the rails [N]", force)
                    }
                    None => ("nothing", 0.0),
                },
                Unknown::Rail(..) => continue,
            });
        }
        wanted
    }

    /// Residuals, one for each unknown: of the forces over the vertical one, of rails over the approach.
    fn residual(&mut self, x: &DVector<f64>, tractions: Tractions) -> Result<DVector<f64>, Error> {
        if let (Tractions::Solved, Some((at, residual))) = (tractions, &self.last)
            && at == x
        {
            return Ok(residual.clone());
        }
        let (place, velocity) = self.posed(x);
        self.wheels.velocity = velocity;
        self.last = None;
        let tried = match tractions {
            Tractions::Known => self.wheels.with_known_ratios(&place),
            Tractions::Solved => self.wheels.with_friction(&place),
        };
        if let Err(why @ (Error::Geometry(_) | Error::CutOff { .. })) = &tried {
            self.end = Some(why.to_string());
        }
        let forces = tried?;
        let wheelset = &self.ready.wheelset;
        let sides = wheelset.sides.each();
        let whole = wheelset.force * sides.len() as f64;
        let total: Vector3<f64> = forces.iter().sum();
        let is_each = self.position(Unknown::Roll).is_some();
        let mut reached = Vec::new();
        let mut out = DVector::zeros(x.len());
        for (k, unknown) in self.unknowns.iter().enumerate() {
            out[k] = match *unknown {
                Unknown::Height | Unknown::Roll => {
                    let (carried, asked) = match (unknown, is_each) {
                        (Unknown::Height, false) => (-total.z, whole),
                        (Unknown::Height, true) => (-forces[0].z, wheelset.force),
                        _ => (-forces[1].z, wheelset.force),
                    };
                    reached.push(carried);
                    let root = stretched(carried / asked, 2.0 / 3.0);
                    if root == 0.0 {
                        // a lifted wheel counts by how far it is up
                        let overlap = self.overlap_of(&place)?;
                        let own = usize::from(*unknown == Unknown::Roll);
                        (overlap[own] / wheelset.approach).min(0.0) - 1.0
                    } else {
                        root - 1.0
                    }
                }
                Unknown::Lateral => {
                    if let Some(y) = self.across {
                        (x[k] - y) / wheelset.approach
                    } else {
                        reached.push(total.y);
                        (total.y - self.input.lateral_force.unwrap_or_default()) / whole
                    }
                }
                Unknown::Rotation => {
                    let (value, asked) = match self.input.axle_load {
                        Some(AxleLoad::Moment(moment)) => {
                            (self.axle_moment(&place, tractions), moment)
                        }
                        Some(AxleLoad::LongitudinalForce(force)) => (total.x, force),
                        None => (0.0, 0.0),
                    };
                    reached.push(value);
                    let size = match self.input.axle_load {
                        Some(AxleLoad::Moment(_)) => whole * self.ready.rolling_radius,
                        _ => whole,
                    };
                    (value - asked) / size
                }
                Unknown::Rail(side, c) => {
                    let own = sides.iter().position(|s| *s == side).unwrap_or_default();
                    let force = [forces[own].y, forces[own].z];
                    let moved = (wheelset.springs.as_ref())
                        .map_or([0.0; 2], |springs| springs.displacement(side, force));
                    (x[k] - moved[c]) / wheelset.approach
                }
            };
        }
        self.reached = reached;
        if tractions == Tractions::Solved {
            self.last = Some((x.clone(), out.clone()));
            let departure = self.departure(&out).abs();
            if self
                .nearest
                .as_ref()
                .is_none_or(|(least, _)| departure < *least)
            {
                self.nearest = Some((departure, x.clone()));
            }
        }
        Ok(out)
    }

    /// The largest departure of a force of a residual, over the vertical one, with its sign.
    fn departure(&self, residual: &DVector<f64>) -> f64 {
        let wheelset = &self.ready.wheelset;
        let whole = wheelset.force * wheelset.sides.each().len() as f64;
        let stiffness = wheelset
            .springs
            .as_ref()
            .map_or([0.0; 2], |springs| springs.stiffness);
        let each = self
            .unknowns
            .iter()
            .zip(residual)
            .map(|(unknown, r)| match *unknown {
                Unknown::Height | Unknown::Roll => stretched(1.0 + r, 1.5) - 1.0,
                Unknown::Lateral | Unknown::Rotation => *r,
                Unknown::Rail(_, c) => r * wheelset.approach * stiffness[c] / whole,
            });
        each.fold(
            0.0,
            |most: f64, e| if e.abs() > most.abs() { e } else { most },
        )
    }

    /// Moment of the forces on the rails about the axle [N m]; only tractions make one that counts.
    fn axle_moment(&self, place: &Place, tractions: Tractions) -> f64 {
        if tractions == Tractions::Known {
            return 0.0;
        }
        let turn = rotation(&place.pose);
        let middle = self.ready.middle(place);
        let patches = self.wheels.loaded.iter().flat_map(|wheel| &wheel.patches);
        let moment: Vector3<f64> = patches
            .map(|rolled| Vector3::from(rolled.patch.load(middle.into())[1]))
            .sum();
        turn.column(1).dot(&moment)
    }

    /// Overlap [m] of the undeformed bodies: of each wheel, or the largest twice.
    fn overlap_of(&self, place: &Place) -> Result<[f64; 2], Error> {
        let each = overlaps(self.ready, place)?;
        Ok(if self.position(Unknown::Roll).is_some() {
            [each[0], each[1]]
        } else {
            [each.iter().copied().fold(f64::NEG_INFINITY, f64::max); 2]
        })
    }

    fn search(&self, tolerance: f64) -> Search {
        Search {
            tolerance,
            longest: self.sized(LONGEST),
            small: DIFFERENCE * self.ready.wheelset.approach,
            trials: usize::MAX,
        }
    }

    /// All unknowns and equations.
    fn whole(&self) -> Part {
        let all: Vec<usize> = (0..self.unknowns.len()).collect();
        Part {
            unknowns: all.clone(),
            equations: all,
            trials: usize::MAX,
            beside: None,
        }
    }

    fn without(&self, left_out: &[Unknown]) -> Part {
        let kept: Vec<usize> = (0..self.unknowns.len())
            .filter(|k| !left_out.contains(&self.unknowns[*k]))
            .collect();
        Part {
            unknowns: kept.clone(),
            equations: kept,
            trials: usize::MAX,
            beside: None,
        }
    }

    /// Newton's method for a part of the problem; `None` where it does not lead to a root. The last trial is there.
    fn newton(
        &mut self,
        part: &Part,
        start: &DVector<f64>,
        jacobian: Option<DMatrix<f64>>,
        tractions: Tractions,
        tolerance: f64,
    ) -> Result<Option<Root>, Error> {
        if part.unknowns.is_empty() {
            return Ok(Some((start.clone(), DMatrix::zeros(0, 0))));
        }
        let search = Search {
            trials: part.trials,
            ..self.search(tolerance)
        };
        let whole = |own: &DVector<f64>| {
            let mut x = start.clone();
            for (k, value) in part.unknowns.iter().zip(own) {
                x[*k] = *value;
            }
            x
        };
        let own =
            DVector::from_iterator(part.unknowns.len(), part.unknowns.iter().map(|k| start[*k]));
        let approach = self.ready.wheelset.approach;
        let mut residual = |own: &DVector<f64>| -> Result<DVector<f64>, Error> {
            let x = whole(own);
            if let Some(k) = self.position(Unknown::Rotation)
                && x[k].abs() > MOST_CREEPAGE * self.sized(OF_CREEPAGE)
            {
                return Err(Error::Tangential {
                    side: Side::Left,
                    residual: f64::INFINITY,
                });
            }
            let all = self.residual(&x, tractions)?;
            let mut out: Vec<f64> = part.equations.iter().map(|k| all[*k]).collect();
            if let Some((direction, at)) = &part.beside {
                out.push(direction.dot(&(own - at)) / approach);
            }
            Ok(DVector::from_vec(out))
        };
        let attempt = || -> Result<Option<Root>, Error> {
            let mut jacobian = if let Some(known) = jacobian {
                known
            } else {
                let value = residual(&own)?;
                differences(&mut residual, &own, &value, search.small)?
            };
            let found = find_root(&mut residual, own.clone(), &mut jacobian, search)?;
            Ok(found.map(|found| (whole(&found), jacobian)))
        };
        match attempt() {
            Err(error) if is_no_end(&error) => Ok(None),
            done => done,
        }
    }

    /// From the equilibrium of the last step on, if the new one is near.
    fn near_last(&mut self, known: &Found, depth: &[f64]) -> Result<Option<Settled>, Error> {
        let Some(start) = self.start(known, depth)? else {
            return Ok(None);
        };
        let n = self.unknowns.len();
        let mut settled = None;
        if known.slope.len() == n * n {
            let slope = DMatrix::from_column_slice(n, n, &known.slope);
            settled = self.settle(&start, Some(slope), self.few)?;
        }
        if settled.is_none() {
            settled = self.settle(&start, None, 2 * self.few)?;
        }
        let lateral = self.position(Unknown::Lateral);
        let is_near = |x: &DVector<f64>| {
            lateral.is_none_or(|k| {
                let way = (x[k] - known.lateral).hypot(x[0] - start[0]);
                way < self.sized(NEARBY)
            })
        };
        match settled {
            Some(root) if is_near(&root.0) => self.settled(&root).map(Some),
            _ => Ok(None),
        }
    }

    /// From the equilibrium of the last step on with a rail moved aside: one on springs gives way to a flange that comes
    /// nearer, and from where it was the flange would climb.
    fn near_aside(&mut self, known: &Found, depth: &[f64]) -> Result<Option<Settled>, Error> {
        if !self.has_rails() {
            return Ok(None);
        }
        let mut nearest: Option<(f64, DVector<f64>)> = None;
        let sides = self.ready.wheelset.sides.each();
        for (side, by) in sides.iter().flat_map(|side| ASIDE.map(|by| (*side, by))) {
            let mut at = known.clone();
            at.rails[index(side)][0] += self.sized(by);
            let Some(start) = self.start(&at, depth)? else {
                continue;
            };
            let value = match self.residual(&start, Tractions::Known) {
                Err(error) if is_no_end(&error) => continue,
                done => done?,
            };
            let departure = self.departure(&value).abs();
            if nearest.as_ref().is_none_or(|(least, _)| departure < *least) {
                nearest = Some((departure, start));
            }
        }
        let Some((_, start)) = nearest else {
            return Ok(None);
        };
        if let Some(root) = self.settle(&start, None, 2 * self.few)? {
            return self.settled(&root).map(Some);
        }
        self.wheels.forget();
        Ok(None)
    }

    /// Newton's method for all unknowns: first with the tractions of the trial before, then with their own.
    fn settle(
        &mut self,
        start: &DVector<f64>,
        jacobian: Option<DMatrix<f64>>,
        trials: usize,
    ) -> Result<Option<Root>, Error> {
        let accuracy = self.ready.accuracy.force / 1.5;
        let part = Part {
            trials,
            ..self.whole()
        };
        if jacobian.is_some() {
            return self.newton(&part, start, jacobian, Tractions::Solved, accuracy);
        }
        let rough = Part {
            trials,
            ..self.without(&[Unknown::Rotation])
        };
        let near = self.newton(&rough, start, None, Tractions::Known, NEAR)?;
        let (start, jacobian) = match near {
            Some((x, slope)) if rough.unknowns.len() == part.unknowns.len() => (x, Some(slope)),
            Some((x, _)) => (x, None),
            None => (start.clone(), None),
        };
        self.newton(&part, &start, jacobian, Tractions::Solved, accuracy)
    }

    /// Where the undeformed bodies overlap as they did.
    fn start(&self, known: &Found, depth: &[f64]) -> Result<Option<DVector<f64>>, Error> {
        let mut x = DVector::zeros(self.unknowns.len());
        for (k, unknown) in self.unknowns.iter().enumerate() {
            x[k] = match *unknown {
                Unknown::Lateral => known.lateral,
                Unknown::Rotation => self.sized(OF_CREEPAGE) * known.creepage,
                Unknown::Rail(side, c) => known.rails[index(side)][c],
                Unknown::Height | Unknown::Roll => 0.0,
            };
        }
        let n = self.unknowns.iter();
        let n = n
            .filter(|u| matches!(u, Unknown::Height | Unknown::Roll))
            .count();
        if n == 0 {
            return Ok(Some(x));
        }
        let approach = self.ready.wheelset.approach;
        let depth = if depth.len() == n {
            DVector::from_row_slice(depth)
        } else {
            DVector::from_element(n, approach)
        };
        let (given, _) = self.posed(&x);
        let balance = Balance {
            ready: self.ready,
            given,
            is_each: n == 2,
        };
        match balance.laid(&depth) {
            Ok((laid, _)) => {
                x.rows_mut(0, n).copy_from(&laid);
                Ok(Some(x))
            }
            Err(Error::Geometry(_)) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Without a lateral force: from the undeformed bodies on.
    fn afresh(&mut self) -> Result<Settled, Error> {
        let guess = self.guess();
        let Some(start) = self.start(&guess, &[])? else {
            return Err(self.failed(String::new()));
        };
        let has_rails = self.has_rails();
        if has_rails {
            // from undeformed bodies a flange may be too far, and rails that give way lead there along the curve
            if let Some(root) = self.settle(&start, None, 2 * self.few)? {
                return self.settled(&root);
            }
            if let Some(root) = self.settle_from_the_middle()? {
                return self.settled(&root);
            }
        }
        if let Some(root) = self.settle(&start, None, usize::MAX)? {
            return self.settled(&root);
        }
        if let Some(near) = self.let_go(&start)?
            && let Some(root) = self.settle(&near, None, usize::MAX)?
        {
            return self.settled(&root);
        }
        if !has_rails && let Some(root) = self.settle_from_the_middle()? {
            return self.settled(&root);
        }
        // rails on springs snap where the force on a narrow contact changes with its cells
        if let Some((departure, nearest)) = self.nearest.take() {
            let value = self.residual(&nearest, Tractions::Solved)?;
            if has_rails
                && departure < SMALL_JUMP
                && let Some(slope) = self.slope(&nearest, &value)?
            {
                return self.settled(&(nearest, slope));
            }
        }
        Err(self.failed(self.unreached()))
    }

    /// Newton's method from where the curve from the middle of the track ends.
    fn settle_from_the_middle(&mut self) -> Result<Option<Root>, Error> {
        // the rotation is found last where all at once leads nowhere
        let has_rotation = self.position(Unknown::Rotation).is_some();
        for is_rotation_given in [true, false] {
            if is_rotation_given && !has_rotation {
                continue;
            }
            if let Some(near) = self.near_from_the_middle(is_rotation_given)?
                && let Some(root) = self.settle(&near, None, usize::MAX)?
            {
                return Ok(Some(root));
            }
        }
        Ok(None)
    }

    /// The derivatives at a place, the last trial; `None` where one beside it cannot be made.
    fn slope(
        &mut self,
        x: &DVector<f64>,
        value: &DVector<f64>,
    ) -> Result<Option<DMatrix<f64>>, Error> {
        let small = DIFFERENCE * self.ready.wheelset.approach;
        let mut residual = |at: &DVector<f64>| self.residual(at, Tractions::Solved);
        let slope = match differences(&mut residual, x, value, small) {
            Err(error) if is_no_end(&error) => return Ok(None),
            done => done?,
        };
        self.residual(x, Tractions::Solved)?;
        Ok(Some(slope))
    }

    /// What the curve across the track from its middle on has at the y given, at the rotation given or at that found.
    ///
    /// A rail on a soft spring gives way to a flange by much more than the contact does: from undeformed bodies that is
    /// too far for Newton's method, and along the curve the flange comes by and by.
    fn near_from_the_middle(
        &mut self,
        is_rotation_given: bool,
    ) -> Result<Option<DVector<f64>>, Error> {
        let mut unknowns = self.unknowns.clone();
        if is_rotation_given {
            unknowns.retain(|unknown| *unknown != Unknown::Rotation);
        }
        unknowns.push(Unknown::Lateral);
        let mut way = Equilibrium {
            ready: self.ready,
            input: self.input,
            unknowns,
            wheels: &mut *self.wheels,
            across: Some(self.input.pose[1]),
            last: None,
            nearest: None,
            reached: Vec::new(),
            end: None,
            few: usize::MAX,
        };
        way.wheels.forget();
        let guess = way.guess();
        let Ok((found, _)) = way.at_end_of_curve(&guess, &[])? else {
            return Ok(None);
        };
        let near = (self.unknowns.iter()).map(|own| way.position(*own).map_or(0.0, |k| found[k]));
        Ok(Some(DVector::from_iterator(self.unknowns.len(), near)))
    }

    /// Rails displaced by what the wheels are to carry.
    fn guess(&self) -> Found {
        let mut guess = Found::default();
        if let (Some(springs), true) = (&self.ready.wheelset.springs, self.input.pose[2].is_nan()) {
            for side in self.ready.wheelset.sides.each() {
                guess.rails[index(*side)] =
                    springs.displacement(*side, [0.0, -self.ready.wheelset.force]);
            }
        }
        guess
    }

    /// Follows the curve of poses with all but the lateral force as asked, from the last one or from the middle of the
    /// track, until the lateral force is as asked as well.
    fn along_curve(&mut self, known: &Found, depth: &[f64]) -> Result<Settled, Error> {
        let middle = self.guess();
        // where nothing is remembered, rails stand as they carry the wheels
        let rails = if depth.is_empty() {
            middle.rails
        } else {
            known.rails
        };
        let last = Found {
            rails,
            ..known.clone()
        };
        let mut ways = vec![(&last, depth, self.few)];
        if known.lateral != 0.0 {
            ways.push((&middle, &[], self.few));
        }
        // no other way is left
        ways.push((&last, depth, usize::MAX));
        let mut failure = None;
        for (guess, depth, few) in ways {
            self.few = few;
            match self.at_end_of_curve(guess, depth)? {
                Ok(root) => return self.settled(&root),
                Err(why) => failure = failure.or(why.map(|why| self.failed(why))),
            }
            self.wheels.forget();
        }
        Err(failure.unwrap_or_else(|| {
            let why = "; no position with the vertical force was found to begin at";
            self.failed(why.into())
        }))
    }

    /// The root at the end of the curve that begins at a guess; else why it was not reached, `None` where no place to
    /// begin at was found.
    fn at_end_of_curve(
        &mut self,
        guess: &Found,
        depth: &[f64],
    ) -> Result<Result<Root, Option<String>>, Error> {
        let lateral = self.position(Unknown::Lateral).unwrap_or_default();
        let mut beginning = None;
        // the contact plane may turn just where the search begins
        for aside in [0.0, 5e-5, -5e-5, 3e-4, -3e-4] {
            let at = Found {
                lateral: guess.lateral + aside,
                ..guess.clone()
            };
            let Some(start) = self.start(&at, depth)? else {
                continue;
            };
            beginning = self.at_its_place_across(&start)?;
            if beginning.is_some() {
                break;
            }
        }
        let Some(beginning) = beginning else {
            return Ok(Err(None));
        };
        let missing = self.missing(&beginning)?;
        if let Some(root) = self.settle_near(&beginning)? {
            return Ok(Ok(root));
        }
        let begin = Reached {
            x: beginning,
            missing,
        };
        let towards = -missing.signum();
        let mut first = None;
        for sense in [towards, -towards] {
            match self.followed(&begin, sense, lateral)? {
                Ok(root) => return Ok(Ok(root)),
                Err(reason) => {
                    first.get_or_insert((reason, self.reached.clone()));
                }
            }
        }
        let (why, reached) = first.unwrap_or_default();
        self.reached = reached;
        Ok(Err(Some(why)))
    }

    /// The place on the curve that is as far across the track as a guess.
    fn at_its_place_across(&mut self, guess: &DVector<f64>) -> Result<Option<DVector<f64>>, Error> {
        let rough = self.without(&[Unknown::Lateral, Unknown::Rotation]);
        let near = self.newton(&rough, guess, None, Tractions::Known, NEAR)?;
        let start = near.map_or_else(|| guess.clone(), |(x, _)| x);
        let part = self.without(&[Unknown::Lateral]);
        let found = self.newton(&part, &start, None, Tractions::Solved, ALONG)?;
        Ok(found.map(|(x, _)| x))
    }

    /// An equilibrium next to a place on the curve, if the derivatives there point to one that is near.
    fn settle_near(&mut self, x: &DVector<f64>) -> Result<Option<Root>, Error> {
        let value = match self.residual(x, Tractions::Solved) {
            Err(error) if is_no_end(&error) => return Ok(None),
            done => done?,
        };
        let Some(slope) = self.slope(x, &value)? else {
            return Ok(None);
        };
        let ahead = slope.clone().lu().solve(&value);
        if ahead.is_none_or(|change| change.amax() >= self.sized(LONGEST)) {
            return Ok(None);
        }
        let accuracy = self.ready.accuracy.force / 1.5;
        let part = Part {
            trials: self.few,
            ..self.whole()
        };
        let found = self.newton(&part, x, Some(slope), Tractions::Solved, accuracy)?;
        Ok(found.filter(|(found, _)| (found - x).amax() < self.sized(LONGEST)))
    }

    /// The lateral force that is too much, over the vertical one.
    fn missing(&mut self, x: &DVector<f64>) -> Result<f64, Error> {
        let lateral = self.position(Unknown::Lateral).unwrap_or_default();
        Ok(self.residual(x, Tractions::Solved)?[lateral])
    }

    /// Along the curve in one sense of y, until the lateral force passes the one asked for; else why it does not.
    fn followed(
        &mut self,
        begin: &Reached,
        sense: f64,
        lateral: usize,
    ) -> Result<Result<Root, String>, Error> {
        let n = self.unknowns.len();
        let mut direction = DVector::zeros(n);
        direction[lateral] = sense;
        let mut here = begin.clone();
        let [mut step, shortest, bent, straight, mut left] =
            [FIRST_STEP, SHORTEST, LONGEST, LONGEST_STRAIGHT, LONGEST_WAY]
                .map(|length| self.sized(length));
        let over_jump = OVER_JUMP.map(|length| self.sized(length));
        let mut slope = None;
        let mut most = here.missing;
        let mut longest = bent;
        let whole = self.ready.wheelset.force * self.ready.wheelset.sides.each().len() as f64;
        let asked = self.input.lateral_force.unwrap_or_default();
        self.end = None;
        for _ in 0..MOST_STEPS {
            if left < 0.0 {
                break;
            }
            let mut there = None;
            let mut length = step;
            if length > bent && !self.is_clear(&here, &direction, length)? {
                length = bent;
            }
            while length >= shortest {
                let found = self.corrected(&here, &direction, length, slope.clone())?;
                let is_straight = found.as_ref().is_some_and(|(found, _)| {
                    (&found.x - &here.x - &direction * length).norm() < MOST_BEND * length
                });
                if length > bent && !is_straight {
                    length = bent;
                    continue;
                }
                if found.is_some() {
                    longest = if is_straight { straight } else { bent };
                    there = found;
                    break;
                }
                slope = None;
                length *= 0.25;
            }
            if there.is_none() {
                for over in over_jump {
                    if let Some(found) = self.corrected(&here, &direction, over, None)? {
                        (there, length) = (Some(found), over);
                        break;
                    }
                }
            }
            let mut is_across = false;
            if there.is_none()
                && let Some((next, way)) = self.across_jump(&here, &direction)?
            {
                (there, length, is_across) = (Some((next, None)), way, true);
            }
            let Some((next, known)) = there else {
                return self.stopped(&here, most * whole + asked).map(Err);
            };
            slope = known;
            if next.missing * here.missing <= 0.0 {
                return self.between(here, next);
            }
            if next.missing.abs() < most.abs() {
                most = next.missing;
            }
            let way = &next.x - &here.x;
            left -= way.norm();
            direction = if is_across {
                // not that of the jump, in which rails give way
                DVector::from_fn(n, |k, _| if k == lateral { way[k].signum() } else { 0.0 })
            } else {
                &way / way.norm()
            };
            here = next;
            step = (1.7 * length).min(longest);
        }
        self.stopped(&here, most * whole + asked).map(Err)
    }

    /// The place on the curve beyond a jump to another contact, and how far it is across the track: rails on springs
    /// give way there by as much as the forces jump.
    fn across_jump(
        &mut self,
        from: &Reached,
        direction: &DVector<f64>,
    ) -> Result<Option<(Reached, f64)>, Error> {
        let lateral = self.position(Unknown::Lateral).unwrap_or_default();
        let known = self.found_at(&from.x);
        for over in ACROSS_JUMP.map(|length| self.sized(length)) {
            let at = Found {
                lateral: known.lateral + direction[lateral].signum() * over,
                ..known.clone()
            };
            let Some(start) = self.start(&at, &[])? else {
                continue;
            };
            let found = match self.at_its_place_across(&start)? {
                None => self.let_go(&start)?,
                found => found,
            };
            if let Some(x) = found {
                let missing = self.missing(&x)?;
                return Ok(Some((Reached { x, missing }, over)));
            }
        }
        Ok(None)
    }

    /// The place as far across the track where the springs of the rails hold what the wheels press on them, from one
    /// where one of the rails is too far from it for Newton's method: that rail is let go, and moves by steps until its
    /// spring holds; the rotation is found last. `None` where the rest is not found on its way.
    fn let_go(&mut self, start: &DVector<f64>) -> Result<Option<DVector<f64>>, Error> {
        let rails: Vec<usize> = (0..self.unknowns.len())
            .filter(|k| matches!(self.unknowns[*k], Unknown::Rail(_, 0)))
            .collect();
        if rails.is_empty() {
            return Ok(None);
        }
        let held: Vec<Unknown> = rails.iter().map(|k| self.unknowns[*k]).collect();
        let given = [Unknown::Lateral, Unknown::Rotation];
        let part = self.without(&[&held[..], &given].concat());
        let Some((first, _)) = self.newton(&part, start, None, Tractions::Solved, NEAR)? else {
            return Ok(None);
        };
        let value = self.residual(&first, Tractions::Solved)?;
        let Some(rail) = rails
            .into_iter()
            .max_by(|a, b| value[*a].abs().total_cmp(&value[*b].abs()))
        else {
            return Ok(None);
        };
        let part = self.without(&[&given[..], &[self.unknowns[rail]]].concat());
        let all = self.without(&given);
        let [mut step, longest] = [FIRST_STEP, LONGEST].map(|length| self.sized(length));
        let Some((mut here, mut slope)) =
            self.newton(&part, &first, None, Tractions::Solved, NEAR)?
        else {
            return Ok(None);
        };
        let mut missing = self.residual(&here, Tractions::Solved)?[rail];
        let mut left = self.sized(LONGEST_WAY);
        let mut is_past = false;
        for _ in 0..MOST_STEPS {
            if left < 0.0 || step < self.sized(SHORTEST) {
                break;
            }
            let mut there = here.clone();
            there[rail] -= step.copysign(missing);
            let Some((there, known)) =
                self.newton(&part, &there, Some(slope.clone()), Tractions::Solved, NEAR)?
            else {
                step *= 0.25;
                continue;
            };
            let next = self.residual(&there, Tractions::Solved)?[rail];
            if next * missing <= 0.0 {
                // the spring holds between here and there
                is_past = true;
                let share = missing / (missing - next);
                let guess = &here + (&there - &here) * share;
                if let Some((x, _)) = self.newton(&all, &guess, None, Tractions::Solved, ALONG)? {
                    let all = self.without(&[Unknown::Lateral]);
                    let found = self.newton(&all, &x, None, Tractions::Solved, ALONG)?;
                    return Ok(found.map(|(x, _)| x));
                }
                step *= 0.25;
                continue;
            }
            left -= step;
            (here, slope, missing) = (there, known, next);
            if !is_past {
                step = (1.7 * step).min(longest);
            }
        }
        Ok(None)
    }

    /// Whether no wheel overlaps its rail much more a step further than here.
    fn is_clear(
        &self,
        from: &Reached,
        direction: &DVector<f64>,
        length: f64,
    ) -> Result<bool, Error> {
        let [here, ahead] = [0.0, length].map(|length| {
            let (place, _) = self.posed(&(&from.x + direction * length));
            match self.overlap_of(&place) {
                Err(Error::Geometry(_)) => Ok(f64::INFINITY),
                done => done.map(|each| each[0].max(each[1])),
            }
        });
        Ok(ahead? < MOST_OVERLAP * here?.max(self.ready.wheelset.approach))
    }

    /// The place on the curve a step further, and the derivatives there.
    #[allow(clippy::type_complexity, reason = "a place and what is known there")]
    fn corrected(
        &mut self,
        from: &Reached,
        direction: &DVector<f64>,
        length: f64,
        slope: Option<DMatrix<f64>>,
    ) -> Result<Option<(Reached, Option<DMatrix<f64>>)>, Error> {
        let ahead = &from.x + direction * length;
        let lateral = self.position(Unknown::Lateral).unwrap_or_default();
        let all = self.whole();
        let part = Part {
            equations: all
                .equations
                .into_iter()
                .filter(|k| *k != lateral)
                .collect(),
            unknowns: all.unknowns,
            trials: self.few,
            beside: Some((direction.clone(), ahead.clone())),
        };
        let slope = slope.map(|mut slope| {
            let last = slope.nrows() - 1;
            let own = direction.transpose() / self.ready.wheelset.approach;
            slope.row_mut(last).copy_from(&own);
            slope
        });
        let Some((x, slope)) = self.newton(&part, &ahead, slope, Tractions::Solved, ALONG)? else {
            return Ok(None);
        };
        // another branch of the curve is none
        if (&x - &ahead).norm() > 2.0 * length.max(self.sized(1e-5)) {
            return Ok(None);
        }
        let missing = self.missing(&x)?;
        Ok(Some((Reached { x, missing }, Some(slope))))
    }

    /// The equilibrium between two places on the curve; else that the force jumps there.
    fn between(
        &mut self,
        mut low: Reached,
        mut high: Reached,
    ) -> Result<Result<Root, String>, Error> {
        for _ in 0..HALVINGS {
            let share = (low.missing / (low.missing - high.missing)).clamp(0.02, 0.98);
            let guess = &low.x + (&high.x - &low.x) * share;
            if let Some(root) = self.settle_near(&guess)? {
                return Ok(Ok(root));
            }
            let way = &high.x - &low.x;
            let length = way.norm();
            let direction = way / length;
            let mut middle = None;
            for share in SHARES {
                if let Some((found, _)) = self.corrected(&low, &direction, share * length, None)? {
                    middle = Some(found);
                    break;
                }
            }
            let Some(middle) = middle else {
                break;
            };
            if middle.missing * low.missing <= 0.0 {
                high = middle;
            } else {
                low = middle;
            }
            if (&high.x - &low.x).norm() < 1e-9 {
                break;
            }
        }
        let [nearer, farther] = if low.missing.abs() < high.missing.abs() {
            [&low, &high]
        } else {
            [&high, &low]
        };
        for (end, other) in [(nearer, farther), (farther, nearer)] {
            if let Some(root) = self.at_small_jump(end, other)? {
                return Ok(Ok(root));
            }
        }
        // the message tells the forces there
        self.residual(&nearer.x, Tractions::Solved)?;
        let whole = self.ready.wheelset.force * self.ready.wheelset.sides.each().len() as f64;
        let asked = self.input.lateral_force.unwrap_or_default();
        let [a, b] = [low.missing, high.missing].map(|missing| asked + whole * missing);
        let lateral = self.position(Unknown::Lateral).unwrap_or_default();
        Ok(Err(format!(
            "; at y = {:.4} mm the lateral force jumps from {a:.0} N to {b:.0} N, because the contact plane turns there, \
             where the contact moves between tread and flange: ask for a force outside the jump, or give y",
            1e3 * low.x[lateral],
        )))
    }

    /// The end of a jump whose lateral force is all but the one asked for, everything else as asked.
    fn at_small_jump(&mut self, end: &Reached, other: &Reached) -> Result<Option<Root>, Error> {
        // the place is only as exact as the curve
        if end.missing.abs() > SMALL_JUMP - ALONG {
            return Ok(None);
        }
        let part = self.without(&[Unknown::Lateral]);
        let accuracy = self.ready.accuracy.force / 1.5;
        let lateral = self.position(Unknown::Lateral).unwrap_or_default();
        let side = (end.x[lateral] - other.x[lateral]).signum();
        for aside in BESIDE_JUMP.map(|length| side * self.sized(length)) {
            let mut start = end.x.clone();
            start[lateral] += aside;
            let found = self.newton(&part, &start, None, Tractions::Solved, accuracy)?;
            let Some((x, _)) = found else {
                continue;
            };
            let value = self.residual(&x, Tractions::Solved)?;
            if value[lateral].abs() > SMALL_JUMP {
                continue;
            }
            if let Some(slope) = self.slope(&x, &value)? {
                return Ok(Some((x, slope)));
            }
        }
        Ok(None)
    }

    /// Why a curve was left; the message tells the forces at the last place on it.
    fn stopped(&mut self, last: &Reached, most: f64) -> Result<String, Error> {
        match self.residual(&last.x, Tractions::Solved) {
            Err(error) if !is_no_end(&error) => return Err(error),
            _ => {}
        }
        let end = (self.end.as_ref()).map(|end| format!("; further on, {end}"));
        Ok(format!(
            "; on the way there the lateral force gets no nearer than {most:.0} N: the contact angle and friction carry \
             no more before the flange climbs{}",
            end.unwrap_or_default()
        ))
    }

    /// Why nothing was found at a given y.
    fn unreached(&self) -> String {
        let mut why = String::new();
        if self.position(Unknown::Rotation).is_some() {
            why +=
                "; tractions carry no more than the coefficient of friction times the normal force";
        }
        if self.has_rails() {
            why += if why.is_empty() { "; " } else { ", or " };
            why +=
                "the search ends too far away: step there from nearer to the middle of the track";
        }
        why
    }

    fn failed(&self, why: String) -> Error {
        Error::Equilibrium {
            wanted: self.wanted(),
            reached: self.reached.clone(),
            why,
        }
    }

    /// What a place tells of what is found.
    fn found_at(&self, x: &DVector<f64>) -> Found {
        let mut found = Found {
            lateral: self.posed(x).0.pose[1],
            ..Found::default()
        };
        for (unknown, value) in self.unknowns.iter().zip(x) {
            match *unknown {
                Unknown::Rotation => found.creepage = value / self.sized(OF_CREEPAGE),
                Unknown::Rail(side, c) => found.rails[index(side)][c] = *value,
                Unknown::Height | Unknown::Roll | Unknown::Lateral => {}
            }
        }
        found
    }

    /// What was found, solved there.
    fn settled(&mut self, (x, slope): &Root) -> Result<Settled, Error> {
        let residual = self.residual(x, Tractions::Solved)?;
        let (place, velocity) = self.posed(x);
        let error = self.departure(&residual);
        let found = Found {
            slope: slope.as_slice().to_vec(),
            ..self.found_at(x)
        };
        let depth = if self.position(Unknown::Height).is_some() {
            let n = if self.position(Unknown::Roll).is_some() {
                2
            } else {
                1
            };
            self.overlap_of(&place)?[..n].to_vec()
        } else {
            Vec::new()
        };
        Ok(Settled {
            place,
            velocity,
            loaded: std::mem::take(&mut self.wheels.loaded),
            depth,
            found,
            error,
        })
    }
}

/// Whether a trial could not be made where it was tried, which another place may mend.
fn is_no_end(error: &Error) -> bool {
    matches!(
        error,
        Error::Geometry(_) | Error::Normal { .. } | Error::Tangential { .. } | Error::CutOff { .. }
    )
}
