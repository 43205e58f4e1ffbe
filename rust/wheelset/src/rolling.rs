// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steady and transient rolling of a patch.

use mtb_complementarity::discs::DiscState;
use mtb_contact::tangential::Earlier;
use mtb_geometry::PlaneGap;
use mtb_operator::{Grid, Monitor};
use nalgebra::{Matrix3, Vector3};

use crate::balance::{Instant, Pressed};
use crate::error::Error;
use crate::linear::{PatchLinear, RollingLinear};
use crate::memory::Before;
use crate::patch::{PatchRow, PointStatus, WheelPatch};
use crate::prepared::{Ready, led, rotation, turning};
use crate::rows::{RowSlip, frames, middle};
use crate::state::{Lines, PatchHistory, PatchRatio};
use crate::track::{Place, sign};
use crate::transient::Brought;
use crate::way::{self, Course, Pace};
use crate::wheelset::{Side, Wheelset};

/// Below this share of the speed of the wheel's rim rolling has no direction.
const NO_ROLLING: f64 = 1e-9;
/// A patch with its traction.
pub(crate) struct Rolled {
    pub(crate) patch: WheelPatch,
    /// Traction over pressure for the next step, as of a left wheel.
    pub(crate) ratio: PatchRatio,
    pub(crate) iterations: usize,
    pub(crate) linear: PatchLinear,
}

/// How a wheel moves over its contact plane, as of a left wheel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kinematics {
    /// The frame in the plane.
    pub(crate) turn: Matrix3<f64>,
    pub(crate) approach: f64,
    /// From the reference point to the place on the undeformed wheel whose velocity counts [m].
    pub(crate) arm: Vector3<f64>,
    /// That place and the one on the undeformed rail [m], and the motion around them.
    pub(crate) on_wheel: Vector3<f64>,
    pub(crate) on_rail: Vector3<f64>,
    pub(crate) flow: Flow,
    /// Velocity there [m/s] and rotation [rad/s] of the wheel, less those of the rail.
    pub(crate) rigid: Vector3<f64>,
    pub(crate) spin_vector: Vector3<f64>,
    pub(crate) creepage: [f64; 3],
    /// Rolling speed [m/s], with its sign.
    pub(crate) rolling: f64,
    /// What creepages are over: its size [m/s], > 0, the sign of rolling, and what it is.
    pub(crate) speed: f64,
    pub(crate) sense: f64,
    pub(crate) measure: Measure,
}

/// What creepages are over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Measure {
    /// The rolling speed.
    Rolling,
    /// The slip speed of a wheel that does not roll.
    Sliding,
    /// A speed that was given.
    Given,
}

impl Kinematics {
    /// Of a wheel with reference point `centre`, which moves by `motion`. In transient rolling a wheel at rest creeps
    /// relative to its slip speed.
    fn new(
        ready: &Ready,
        side: Side,
        plane: &PlaneGap,
        place: &Place,
        (centre, motion): (Vector3<f64>, &[f64; 6]),
        is_transient: bool,
    ) -> Result<Self, Error> {
        let wheelset = &ready.wheelset;
        let mirror = mirror(side);
        let turn = ready.rail(side, place).frame(plane);
        let flow = Flow::of(ready, side, place, (centre, motion));
        let approach = plane.approach();
        // the plane lies on the rail, the undeformed surface of the wheel, whose velocity counts, below it; of a roller
        // that of its own undeformed surface
        let on_rail = Vector3::from(plane.position);
        let on_wheel = on_rail - turn.column(2) * approach;
        let arm = on_wheel - centre.component_mul(&mirror);
        let (rigid, spin_vector) = flow.at(on_wheel, on_rail);
        let travel = flow.travel([on_wheel, on_rail], turn.column(0).into());
        let slip = turn.transpose() * rigid;
        let spin = turn.column(2).dot(&spin_vector);
        let rolling = travel - 0.5 * slip.x;
        let standstill = wheelset.standstill_speed.unwrap_or(0.0);
        let mut speed = rolling.abs().max(standstill);
        let mut measure = if rolling.abs() > standstill {
            Measure::Rolling
        } else {
            Measure::Given
        };
        if speed <= NO_ROLLING * rigid.amax().max(motion[0].abs()) || speed == 0.0 {
            if !is_transient {
                return Err(Error::AtRest {
                    side,
                    velocity: *motion,
                });
            }
            let sliding = slip.x.hypot(slip.y);
            (speed, measure) = if sliding > 0.0 {
                (sliding, Measure::Sliding)
            } else {
                (1.0, Measure::Given)
            };
        }
        Ok(Self {
            turn,
            approach,
            arm,
            on_wheel,
            on_rail,
            flow,
            rigid,
            spin_vector,
            creepage: [slip.x / speed, slip.y / speed, spin / speed],
            rolling,
            speed,
            sense: if rolling < 0.0 { -1.0 } else { 1.0 },
            measure,
        })
    }

    /// Whether its creepages are of rolling: over the rolling speed, or the least one that stands for it.
    fn rolls(&self, wheelset: &Wheelset) -> bool {
        self.measure == Measure::Rolling || wheelset.standstill_speed.is_some()
    }
}

/// The motion of a wheel over its rail, or the change of it, as of a left wheel: a shift, and rotations about points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    /// Velocity [m/s].
    shift: Vector3<f64>,
    /// Rotations [rad/s] and the points that they are about [m]: of the wheelset, of the frame of a curved track, of
    /// the wheel on the wheelset, and of the rail, backwards.
    turns: [[Vector3<f64>; 2]; 4],
    /// The same of a roller in place of the rail, backwards; it does not carry the wheelset along.
    roller: Option<[Vector3<f64>; 2]>,
    /// Velocity of the middle of the axle along the track [m/s], or of the surface of a roller, and curvature [1/m].
    pub(crate) ahead: f64,
    pub(crate) curvature: f64,
}

impl Flow {
    fn of(
        ready: &Ready,
        side: Side,
        place: &Place,
        (centre, motion): (Vector3<f64>, &[f64; 6]),
    ) -> Self {
        let mirror = mirror(side);
        let (turn, axes) = (rotation(&place.pose), rotation(&led(&place.pose)));
        let [shift, own] = halves(motion);
        let [bent, bending] = halves(&place.wheel(side).rate);
        let [vy, vz, roll] = place.rail(side).rate;
        // the frame of a curved track turns as it goes, and carries the wheelset with it
        let curvature = sign(side) * place.alignment.curvature;
        let centre = centre.component_mul(&mirror);
        let rail = ready.rail(side, place);
        let roller = ready.wheelset.pair.roller_radius.map(|radius| {
            let spin = rail.turn.column(1) * (motion[0] / radius);
            [spin, rail.point(Vector3::z() * -radius)]
        });
        // patches go along with the axle, whose turns move a reference point beside it; over a roller it stays
        let axle = motion[0] + own.cross(&(turn * ready.arm())).x;
        let (ahead, stays) = roller.map_or((axle, 0.0), |_| (motion[0], axle));
        let stays = Vector3::x() * stays;
        Self {
            shift: (shift + axes * bent).component_mul(&mirror) - Vector3::new(0.0, vy, vz) - stays,
            roller,
            turns: [
                [spun(own, side), centre],
                [Vector3::z() * (ahead * curvature), Vector3::x() * centre.x],
                [
                    spun(axes * bending, side),
                    ready.hub(side, place).component_mul(&mirror),
                ],
                [Vector3::x() * -roll, rail.origin()],
            ],
            ahead,
            curvature,
        }
    }

    /// Its change with that of place, velocity and rotation.
    pub(crate) fn change(
        &self,
        ready: &Ready,
        side: Side,
        place: &Place,
        (by, by_motion): (&Place, &[f64; 6]),
    ) -> Self {
        let mirror = mirror(side);
        let (turn, by_turn) = (rotation(&place.pose), turning(&place.pose, &by.pose));
        let (axes, by_axes) = (led(&place.pose), led(&by.pose));
        let (axes, by_axes) = (rotation(&axes), turning(&axes, &by_axes));
        let [shift, own] = halves(by_motion);
        let [bent, bending] = halves(&place.wheel(side).rate);
        let [by_bent, by_bending] = halves(&by.wheel(side).rate);
        let by_rail = by.rail(side);
        let [vy, vz, roll] = by_rail.rate;
        let curvature = sign(side) * by.alignment.curvature;
        let [x, y, z, ..] = by.pose;
        let centre = Vector3::new(x, y, z).component_mul(&mirror);
        let bent = by_axes * bent + axes * by_bent;
        let (spin, arm) = (spun(self.turns[0][0], side), ready.arm());
        let by_axle = by_motion[0] + (own.cross(&(turn * arm)) + spin.cross(&(by_turn * arm))).x;
        let (by_ahead, by_stays) = match self.roller {
            Some(_) => (by_motion[0], by_axle),
            None => (by_axle, 0.0),
        };
        let carried = by_ahead * self.curvature + self.ahead * curvature;
        let roller = ready.wheelset.pair.roller_radius.map(|radius| {
            let rail = ready.rail(side, place);
            let by_spin = rail.turn.column(1) * by_motion[0]
                + rail.turn_change(by_rail.place[2]).column(1) * self.ahead;
            let middle = Vector3::z() * -radius;
            let by_middle = rail.point_change(&by_rail, middle, Vector3::zeros());
            [by_spin / radius, by_middle]
        });
        let stays = Vector3::x() * by_stays;
        Self {
            shift: (shift + bent).component_mul(&mirror) - Vector3::new(0.0, vy, vz) - stays,
            roller,
            turns: [
                [spun(own, side), centre],
                [Vector3::z() * carried, Vector3::x() * centre.x],
                [
                    spun(by_axes * bending + axes * by_bending, side),
                    ready.hub_change(side, place, by).component_mul(&mirror),
                ],
                [
                    Vector3::x() * -roll,
                    Vector3::new(0.0, by_rail.place[0], by_rail.place[1]),
                ],
            ],
            ahead: by_ahead,
            curvature,
        }
    }

    /// Velocity of a place on the wheel over one on the rail, and rotation.
    pub(crate) fn at(
        &self,
        on_wheel: Vector3<f64>,
        on_rail: Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (mut velocity, mut rotation) = (self.shift, Vector3::zeros());
        let turns = self.turns.iter().map(|turn| (turn, on_wheel));
        let roller = self.roller.iter().map(|turn| (turn, on_rail));
        for ([spin, about], place) in turns.chain(roller) {
            velocity += spin.cross(&(place - about));
            rotation += spin;
        }
        (velocity, rotation)
    }

    /// Speed at which a patch at a place runs over the rail, along a direction.
    fn travel(&self, [on_wheel, on_rail]: [Vector3<f64>; 2], along: Vector3<f64>) -> f64 {
        match self.roller {
            Some([spin, about]) => along.dot(&spin.cross(&(on_rail - about))),
            None => self.ahead * (1.0 - self.curvature * on_wheel.y),
        }
    }

    /// Change of [`Flow::travel`].
    pub(crate) fn travel_change(
        &self,
        by: &Self,
        [on_wheel, by_on_wheel]: [Vector3<f64>; 2],
        [on_rail, by_on_rail]: [Vector3<f64>; 2],
        [along, by_along]: [Vector3<f64>; 2],
    ) -> f64 {
        match (self.roller, by.roller) {
            (Some([spin, about]), Some([by_spin, by_about])) => {
                let arm = on_rail - about;
                by_along.dot(&spin.cross(&arm))
                    + along.dot(&(by_spin.cross(&arm) + spin.cross(&(by_on_rail - by_about))))
            }
            _ => {
                by.ahead * (1.0 - self.curvature * on_wheel.y)
                    - self.ahead * (by.curvature * on_wheel.y + self.curvature * by_on_wheel.y)
            }
        }
    }

    /// Change of [`Flow::at`] with that of the flow and of the places.
    pub(crate) fn change_at(
        &self,
        by: &Self,
        [on_wheel, by_on_wheel]: [Vector3<f64>; 2],
        [on_rail, by_on_rail]: [Vector3<f64>; 2],
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (mut velocity, mut rotation) = (by.shift, Vector3::zeros());
        let turns = self.turns.iter().zip(&by.turns);
        let roller = self.roller.iter().zip(&by.roller);
        let turns = turns.map(|turn| (turn, on_wheel, by_on_wheel));
        let roller = roller.map(|turn| (turn, on_rail, by_on_rail));
        for (([spin, about], [by_spin, by_about]), place, by_place) in turns.chain(roller) {
            velocity += by_spin.cross(&(place - about)) + spin.cross(&(by_place - by_about));
            rotation += by_spin;
        }
        (velocity, rotation)
    }
}

/// The first three of six numbers, and the last ones.
fn halves(numbers: &[f64; 6]) -> [Vector3<f64>; 2] {
    let [x, y, z, a, b, c] = *numbers;
    [Vector3::new(x, y, z), Vector3::new(a, b, c)]
}

/// A rotation in the track, as of a left wheel.
fn spun(rotation: Vector3<f64>, side: Side) -> Vector3<f64> {
    let mirror = mirror(side);
    rotation.component_mul(&mirror) * mirror.y
}

/// What puts a vector of the track into the mirror, or out of it.
fn mirror(side: Side) -> Vector3<f64> {
    let across = if side == Side::Right { -1.0 } else { 1.0 };
    Vector3::new(1.0, across, 1.0)
}

/// The loaded part of a patch as steady rolling along +x sees it: rolling backwards is rolling forwards seen
/// from the other side. In transient rolling it holds what was loaded before, which may lie outside of the patch.
pub(crate) struct Cut {
    /// Columns and rows of the whole patch, and of the part.
    whole: [usize; 2],
    size: [usize; 2],
    start: [isize; 2],
    is_backwards: bool,
}

impl Cut {
    /// `None` where no point is loaded. `before`: lines of what was loaded before.
    fn of(
        pressure: &[f64],
        lines: Lines,
        before: Option<Lines>,
        is_backwards: bool,
    ) -> Option<Self> {
        let nx = lines.nx;
        let (mut low, mut high) = ([isize::MAX; 2], [isize::MIN; 2]);
        for (k, _) in pressure.iter().enumerate().filter(|(_, p)| **p > 0.0) {
            for (c, at) in [k % nx, k / nx].into_iter().enumerate() {
                low[c] = low[c].min(at as isize);
                high[c] = high[c].max(at as isize);
            }
        }
        if low[0] > high[0] {
            return None;
        }
        if let Some(before) = before {
            for (c, count) in [before.nx, before.ny].into_iter().enumerate() {
                let first = (before.first[c] - lines.first[c]) as isize;
                low[c] = low[c].min(first);
                high[c] = high[c].max(first + count as isize - 1);
            }
        }
        Some(Self {
            whole: [nx, lines.ny],
            size: [0, 1].map(|c| (high[c] - low[c] + 1) as usize),
            start: low,
            is_backwards,
        })
    }

    /// Earlier fields on a grid of `cells` points with rows of `nx`; particles beside them have the coefficient of
    /// `rest`.
    fn earlier(
        &self,
        before: &Before,
        lines: Lines,
        (nx, cells): (usize, usize),
        rest: f64,
    ) -> Brought {
        let mut all = Earlier {
            traction: vec![0.0; 2 * cells],
            pressure: vec![0.0; cells],
            coefficient: vec![rest; cells],
        };
        let mut resting = vec![1.0; cells];
        let count = before.earlier.pressure.len();
        let here = |at: [i64; 2]| {
            let [column, row] =
                [0, 1].map(|c| ((at[c] - lines.first[c]) as isize - self.start[c]) as usize);
            row * nx + column
        };
        for k in 0..count {
            let at = [k % before.lines.nx, k / before.lines.nx];
            let here = here([0, 1].map(|c| before.lines.first[c] + at[c] as i64));
            all.pressure[here] = before.earlier.pressure[k];
            all.coefficient[here] = before.earlier.coefficient[k];
            resting[here] = before.resting[k];
            for c in 0..2 {
                all.traction[c * cells + here] = before.earlier.traction[c * count + k];
            }
        }
        Brought {
            earlier: all,
            resting,
            gathered: before.gathered.told_by(here),
        }
    }

    /// Pairs of points: of the part on a grid with rows of `nx`, and of the whole.
    pub(crate) fn points(&self, nx: usize) -> impl Iterator<Item = (usize, usize)> {
        let [columns, rows] = self.size;
        (0..columns * rows).filter_map(move |k| {
            let (i, j) = (k % columns, k / columns);
            let at = [i as isize, j as isize];
            let is_inside = [0, 1].iter().all(|c| {
                let line = self.line(at, *c);
                line >= 0 && line < self.whole[*c] as isize
            });
            is_inside.then(|| (j * nx + i, self.point(at)))
        })
    }

    /// Column (0) or row (1) of the whole at a column and row of the part.
    fn line(&self, at: [isize; 2], c: usize) -> isize {
        let low = if self.is_backwards {
            self.size[c] as isize - 1 - at[c]
        } else {
            at[c]
        };
        self.start[c] + low
    }

    /// Row of the whole at a row of the part, if it has it.
    fn row(&self, row: usize) -> Option<usize> {
        let line = self.line([0, row as isize], 1);
        (0..self.whole[1] as isize)
            .contains(&line)
            .then_some(line as usize)
    }

    /// What rows of the whole slip along, across and by their spin, times a factor with the sign of the direction that is
    /// seen as forwards: for `ny` rows of the part.
    pub(crate) fn rows_seen(&self, slips: &[RowSlip], ny: usize, factor: f64) -> Vec<RowSlip> {
        let seen = |row: usize| {
            let own = self.row(row).map_or([0.0; 3], |row| slips[row]);
            [factor * own[0], factor * own[1], factor.abs() * own[2]]
        };
        (0..ny).map(seen).collect()
    }

    /// Point of the whole at a column and row of the part, or next to it on the border of the whole.
    fn point(&self, at: [isize; 2]) -> usize {
        let [column, row] =
            [0, 1].map(|c| self.line(at, c).clamp(0, self.whole[c] as isize - 1) as usize);
        row * self.whole[0] + column
    }

    /// The row that is the first of the part as seen, in spacings.
    fn first_line(&self, first: i64) -> i64 {
        first + self.line([0, 0], 1) as i64
    }

    /// First column and row of the part as seen, in spacings from the origin.
    fn origin(&self, first: [i64; 2]) -> [i64; 2] {
        [0, 1].map(|c| {
            let low = first[c] + self.start[c] as i64;
            if self.is_backwards {
                -(low + self.size[c] as i64 - 1)
            } else {
                low
            }
        })
    }
}

/// The patch of a wheel rolling at an instant: `centre` is the reference point, `motion` the velocity there and the
/// rotation, `course` what comes before; `start`: traction over pressure to try first.
#[allow(clippy::too_many_arguments, reason = "one patch at one instant")]
pub(crate) fn rolling(
    ready: &Ready,
    side: Side,
    pressed: Pressed,
    instant: Instant<'_>,
    (centre, motion): (Vector3<f64>, &[f64; 6]),
    course: Course,
    start: Option<&[f64]>,
    monitor: Monitor<'_>,
) -> Result<Rolled, Error> {
    let wheelset = &ready.wheelset;
    let [dx, dy] = wheelset.spacing;
    let Pressed {
        plane,
        pressure,
        gap,
    } = pressed;
    let kinematics = Kinematics::new(
        ready,
        side,
        &plane,
        instant.place,
        (centre, motion),
        matches!(course, Course::Transient { .. }),
    )?;
    let Kinematics {
        mut creepage, turn, ..
    } = kinematics;
    let lines = Lines::of(&plane);
    let in_contact = |column: &usize| {
        let rows = pressure[*column..].iter().step_by(plane.nx);
        rows.into_iter().any(|p| *p > 0.0)
    };
    let columns = (0..plane.nx).filter(in_contact).count();
    let course = course.or_steady(kinematics.rolling, columns, dx);
    let course = course.or_from_rest(kinematics.rolling, lines, &pressure, [dx, dy]);
    let is_transient = matches!(course, Course::Transient { .. });
    // transient rolling knows all directions
    let sense = if is_transient { 1.0 } else { kinematics.sense };

    let n = pressure.len();
    let row_slips = kinematics.row_slips(&plane, dy);
    let mut traction = vec![0.0; 2 * n];
    let mut slip_velocity = vec![0.0; 2 * n];
    let mut status = vec![PointStatus::Open; n];
    let mut ratio = vec![0.0; 2 * n];
    let mut iterations = 0;
    let mut friction_power = 0.0;
    let mut heat = vec![0.0; n];
    let law = wheelset.friction_of(side);
    let rest = law.at_rest();
    let mut coefficient = vec![rest; n];
    let mut linear = None;
    let (pace, before) = Pace::of(course, &kinematics, [dx, dy]);
    let carried = before.as_ref().map(|before| before.lines);
    if let Some(cut) = Cut::of(&pressure, lines, carried, sense < 0.0) {
        let incline = ready.incline(side, cut.first_line(plane.first[1]), sense < 0.0);
        let operators = ready.operators.at_least(
            cut.size,
            wheelset.spacing,
            &wheelset.bodies,
            wheelset.layer,
            pace.motion,
            incline.as_ref(),
        )?;
        let grid = operators.grid();
        let cells = grid.points();
        let mut part = vec![0.0; cells];
        let mut first_try = start.is_some().then(|| vec![0.0; 2 * cells]);
        for (here, there) in cut.points(grid.nx) {
            part[here] = pressure[there];
            if let (Some(to), Some(from)) = (&mut first_try, start) {
                to[here] = sense * from[there] * pressure[there];
                to[cells + here] = sense * from[n + there] * pressure[there];
            }
        }
        let friction = |behind: f64| {
            let place = |here: usize| {
                let at = [here % grid.nx, here / grid.nx].map(|k| k as isize);
                let there = cut.point(at);
                let (column, row) = (there % plane.nx, there / plane.nx);
                let x = plane.position[0] + dx * (plane.first[0] + column as i64) as f64;
                [x - behind, plane.rail_positions[row]]
            };
            law.at(cells, place).into_owned()
        };
        let brought = (before.as_ref()).map(|b| cut.earlier(b, lines, (grid.nx, cells), rest));
        let mut from = plane.first;
        if let Some(rows) = &plane.rows {
            // spin counts about the row nearest to the origin, which stays as the contact moves
            from[1] -= middle(rows, dy);
        }
        let first = cut.origin(from);
        let seen = [sense * creepage[0], sense * creepage[1], creepage[2]];
        let loaded = way::Loaded {
            side,
            operators: &operators,
            pressure: &part,
            friction: &friction,
            rest,
            place: [first[0] as f64 * dx, first[1] as f64 * dy],
            creepage: seen,
            rows: (row_slips.as_ref())
                .map(|slips| cut.rows_seen(slips, grid.ny, sense / kinematics.speed)),
            last_creepage: before.as_ref().and_then(|before| before.creepage),
            rolling: kinematics.rolling,
            tolerance: instant.tangential,
        };
        let way = loaded.along(&pace, brought, first_try.as_deref(), monitor)?;
        iterations = way.iterations;
        let [columns, _] = way.around.shape;
        for (k, value) in (way.heat.iter().enumerate()).filter(|(_, value)| **value != 0.0) {
            let at = [k % columns, k / columns].map(|c| c as isize - 1);
            heat[cut.point(at)] += value;
        }
        let rolled = RollingLinear {
            friction_power: way.heat.iter().sum::<f64>() * dx * dy,
            motion: pace.motion,
            origin: way.origin,
            sense,
            of_creepage: pace.of_creepage,
            speed: pace.speed,
            at_rest: rest,
            parts: way.parts,
            rigid_slip: way.rigid_slip,
            row_slips: row_slips.clone().unwrap_or_default(),
            incline,
            cut,
            operators,
        };
        let end = rolled.end();
        let by_pressure = rolled.operators.slip_by_pressure(&end.pressure);
        let [along, across, spin] = seen.map(|c| c * pace.of_creepage);
        let rows = rolled.rows_seen(&rolled.row_slips, pace.of_creepage / kinematics.speed);
        for (here, there) in rolled.cut.points(grid.nx) {
            let [x, y] = [
                (first[0] + (here % grid.nx) as i64) as f64 * dx,
                (first[1] + (here / grid.nx) as i64) as f64 * dy,
            ];
            let mut rigid = [along - spin * y, across + spin * x];
            if let Some([along, across, spin]) = rows.get(here / grid.nx) {
                rigid = [rigid[0] + along, rigid[1] + across + spin * x];
            }
            for c in 0..2 {
                let at = c * cells + here;
                friction_power += end.traction[at] * (rigid[c] + by_pressure[at]);
            }
            status[there] = match end.state[here] {
                DiscState::Excluded => PointStatus::Open,
                DiscState::Inside => PointStatus::Stick,
                DiscState::Rim => PointStatus::Slip,
            };
            coefficient[there] = end.coefficient[here];
            for c in 0..2 {
                let (from, to) = (c * cells + here, c * n + there);
                traction[to] = sense * end.traction[from];
                if status[there] == PointStatus::Slip {
                    slip_velocity[to] = sense * pace.speed * end.slip[from];
                }
                if pressure[there] > 0.0 {
                    ratio[to] = traction[to] / pressure[there];
                }
            }
        }
        linear = Some(rolled);
    }
    friction_power *= pace.speed * dx * dy;
    if is_transient || wheelset.second_order {
        // the elastic energy changes: what works on the rigid slip is not all heat; where slip is of second order, what
        // cells turn into heat adds up to all
        friction_power = heat.iter().sum::<f64>() * dx * dy;
    }
    let (position, angle) = ready.in_history(side, instant.place, &plane);
    let kept = PatchRatio {
        side,
        first: plane.first,
        nx: plane.nx,
        ny: plane.ny,
        ratio,
        history: Some(PatchHistory {
            position,
            angle,
            pressure: pressure.clone(),
            coefficient,
            creepage: kinematics.rolls(wheelset).then_some(creepage),
        }),
    };
    let linear = PatchLinear {
        side,
        pressure: pressure.clone(),
        gap,
        kinematics,
        rolling: linear,
        plane,
    };
    let plane = &linear.plane;
    let mirror = mirror(side);
    let mut first = plane.first;
    let mut first_across = plane.first_across(dy);
    let mut rows: Vec<PatchRow> = (frames(plane).into_iter().flatten())
        .zip(plane.rows.iter().flat_map(|rows| &rows.between))
        .zip(row_slips.into_iter().flatten())
        .zip(0..)
        .map(|(((row, angle), slip), line)| {
            let y = plane.rows.as_ref().map_or(0.0, |rows| {
                dy * (plane.first[1] + line - middle(rows, dy)) as f64
            });
            let [xi, eta, phi] = creepage;
            let own = slip.map(|slip| slip / kinematics.speed);
            PatchRow {
                position: row.place.into(),
                inclination: *angle,
                depth: row.depth,
                creepage: [xi - phi * y + own[0], eta + own[1], phi + own[2]],
            }
        })
        .collect();
    let mut pressure = pressure;
    let mut rotation = turn;
    if side == Side::Right {
        // out of the mirror; y stays to the left
        let flip = Matrix3::from_diagonal(&mirror);
        rotation = flip * turn * flip;
        creepage = [creepage[0], -creepage[1], -creepage[2]];
        first[1] = -(first[1] + plane.ny as i64 - 1);
        first_across = -(first_across + dy * (plane.ny - 1) as f64);
        rows.reverse();
        for row in &mut rows {
            row.position[1] = -row.position[1];
            row.inclination = -row.inclination;
            let [xi, eta, phi] = row.creepage;
            row.creepage = [xi, -eta, -phi];
        }
        reverse_rows(&mut status, plane.nx);
        out_of_mirror(
            plane.nx,
            &mut [&mut pressure, &mut heat],
            &mut [&mut traction, &mut slip_velocity],
        );
    }
    let patch = WheelPatch {
        side,
        position: Vector3::from(plane.position).component_mul(&mirror).into(),
        rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| rotation[(i, j)])),
        contact_angle: plane.angle,
        rail_position: plane.rail_position,
        wheel_position: plane.wheel_position,
        first,
        first_across,
        rows,
        grid: Grid::new(plane.nx, plane.ny, dx, dy)?,
        normal_force: pressure.iter().sum::<f64>() * dx * dy,
        pressure,
        traction,
        slip_velocity,
        dissipation: heat,
        status,
        approach: kinematics.approach,
        creepage,
        rolling_speed: if kinematics.rolling == 0.0 && wheelset.standstill_speed.is_none() {
            0.0
        } else {
            kinematics.sense * kinematics.speed
        },
        friction_power,
        neglected: plane.neglected,
    };
    Ok(Rolled {
        patch,
        ratio: kept,
        iterations,
        linear,
    })
}

/// Turns fields (n) and fields of two components (2n) of a left wheel into those of the right one.
pub(crate) fn out_of_mirror(
    nx: usize,
    fields: &mut [&mut Vec<f64>],
    vectors: &mut [&mut Vec<f64>],
) {
    for field in fields {
        reverse_rows(field, nx);
    }
    for field in vectors {
        let half = field.len() / 2;
        let (along, across) = field.split_at_mut(half);
        reverse_rows(along, nx);
        reverse_rows(across, nx);
        for value in across {
            *value = -*value;
        }
    }
}

fn reverse_rows<T>(field: &mut [T], nx: usize) {
    let ny = field.len() / nx;
    for row in 0..ny / 2 {
        for column in 0..nx {
            field.swap(row * nx + column, (ny - 1 - row) * nx + column);
        }
    }
}
