// SPDX-License-Identifier: MIT OR Apache-2.0
//! A solved patch, linearised about its state. All is as of a left wheel; results come out of the mirror.

use std::borrow::Cow;
use std::sync::Arc;

use mtb_contact::friction::Friction;
use mtb_contact::normal::{Load, NormalChange, NormalContact, NormalState, Surface, forward};
use mtb_contact::tangential::{
    Drive, Earlier, Motion, PatchOperators, Surroundings, TangentialChange, TangentialProblem,
    TangentialResponse, TangentialState, TangentialTangent,
};
use mtb_geometry::{PlaneChange, PlaneGap};
use mtb_operator::{Grid, Monitor};
use nalgebra::{Matrix3, Vector3};

use crate::derivative::{PatchChange, WheelMargin, WheelTangent};
use crate::error::Error;
use crate::friction::WheelFriction;
use crate::moduli::ByModulus;
use crate::rolling::{Cut, Flow, Kinematics, Measure};
use crate::rows::{Incline, RowFrame, RowSlip, frame_changes, frames};
use crate::track::{Place, RailDeviation, WheelDeviation, index};
use crate::transient::Brought;
use crate::way::{Part, slip_place};
use crate::wheelset::Side;

/// A patch and its solved problems.
pub(crate) struct PatchLinear {
    pub(crate) side: Side,
    pub(crate) plane: PlaneGap,
    /// Pressure (n) [Pa] and deformed gap (n) [m].
    pub(crate) pressure: Vec<f64>,
    pub(crate) gap: Vec<f64>,
    pub(crate) kinematics: Kinematics,
    /// The loaded part; `None` where there is no pressure.
    pub(crate) rolling: Option<RollingLinear>,
}

/// The tangential problem of the loaded part of a patch.
pub(crate) struct RollingLinear {
    pub(crate) cut: Cut,
    pub(crate) operators: Arc<PatchOperators>,
    /// The heat of sliding that its cells add up to [W].
    pub(crate) friction_power: f64,
    pub(crate) motion: Motion,
    /// Centre of the first cell [m].
    pub(crate) origin: [f64; 2],
    /// Sign of the direction along x that is seen as rolling forwards.
    pub(crate) sense: f64,
    /// Slip of the problem over a creepage [-], [m], and slip velocity over a slip of the problem [m/s], [1/s].
    pub(crate) of_creepage: f64,
    pub(crate) speed: f64,
    /// The coefficient of friction of a particle that has not slipped [-].
    pub(crate) at_rest: f64,
    /// Of the way, in order; there is at least one.
    pub(crate) parts: Vec<Part>,
    /// Where the patch follows the rail: what its rows slip besides (2n), in the unit of the problem, that of each row
    /// of the patch, and how the rows are inclined.
    pub(crate) rigid_slip: Option<Vec<f64>>,
    pub(crate) row_slips: Vec<RowSlip>,
    pub(crate) incline: Option<Incline>,
}

/// Change of where wheels and rails are and how they move, in the track.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelMotion {
    pub(crate) place: Place,
    /// Of the velocity of the reference point and of the rotation.
    pub(crate) rigid: [f64; 6],
}

impl WheelMotion {
    /// What of it the wheel of a side notices.
    pub(crate) fn of_side(&self, side: Side) -> Self {
        let mut own = *self;
        let other = 1 - index(side);
        own.place.alignment.rails[other] = RailDeviation::default();
        own.place.alignment.wheels[other] = WheelDeviation::default();
        own
    }
}

/// A change of what a patch is given.
#[derive(Default)]
pub(crate) struct Given<'a> {
    pub(crate) motion: WheelMotion,
    /// The parameter of friction that changes by one.
    pub(crate) friction: Option<usize>,
    pub(crate) layer: f64,
    /// The modulus that changes by one; `None` where the bodies stay as they are.
    pub(crate) modulus: Option<&'a ByModulus>,
    /// Of a transient step [s].
    pub(crate) duration: f64,
    /// Of the patches of the step before, as of left wheels.
    pub(crate) before: Option<&'a [PatchChange]>,
}

impl Given<'_> {
    pub(crate) fn is_nothing(&self) -> bool {
        let WheelMotion { place, rigid } = self.motion;
        place == Place::default()
            && rigid == [0.0; 6]
            && self.friction.is_none()
            && self.layer == 0.0
            && self.modulus.is_none()
            && self.duration == 0.0
            && self.before.is_none()
    }
}

/// What follows for a patch.
pub(crate) struct Found {
    pub(crate) change: PatchChange,
    /// Of the moment about the reference point [N m].
    pub(crate) moment: [f64; 3],
}

/// Tractions as they change, on the loaded part.
struct TractionChange {
    traction: Vec<f64>,
    slip: Vec<f64>,
    coefficient: Vec<f64>,
    /// Of the slip velocity over a slip of the problem.
    speed: f64,
    /// Of the friction power [W].
    power: f64,
}

impl PatchLinear {
    /// What follows from a change, in the track.
    pub(crate) fn changed(
        &self,
        linear: &WheelTangent,
        given: &Given<'_>,
        monitor: Monitor<'_>,
    ) -> Result<Found, Error> {
        let wheelset = &linear.ready.wheelset;
        let plane = &self.plane;
        let n = self.pressure.len();
        let is_right = self.side == Side::Right;
        let [dx, dy] = wheelset.spacing;
        let grid = Grid::new(plane.nx, plane.ny, dx, dy)?;
        let area = grid.cell_area();
        let mirror = Vector3::new(1.0, if is_right { -1.0 } else { 1.0 }, 1.0);

        // plane, gap and pressure
        let (ready, place) = (&linear.ready, &linear.place);
        let by_place = &given.motion.place;
        let mut by_turn = Matrix3::zeros();
        let moved = if by_place.moves(self.side) {
            // as its rail sees it
            let rail = ready.rail(self.side, place);
            let seen = rail.seen_from(plane);
            let pose = ready.axle(self.side, place);
            let by = ready.axle_change(self.side, place, by_place);
            let mut moved = ready
                .over(self.side)
                .change(&seen, pose, wheelset.spacing, by)?;
            let by_rail = by_place.rail(self.side);
            let by_position = rail.point_change(
                &by_rail,
                seen.position.into(),
                Vector3::from(moved.position),
            );
            moved.position = by_position.into();
            by_turn = rail.frame_change(plane, &by_rail, (moved.roller_angle, moved.angle));
            moved.angle += by_rail.place[2];
            Some(moved)
        } else {
            None
        };
        let mut change = PatchChange {
            pressure: vec![0.0; n],
            traction: vec![0.0; 2 * n],
            slip_velocity: vec![0.0; 2 * n],
            coefficient: vec![0.0; n],
            ..PatchChange::default()
        };
        let mut by_position = Vector3::zeros();
        if let Some(moved) = &moved {
            by_position = Vector3::from(moved.position);
            change.contact_angle = moved.angle;
            change.rail_position = moved.rail_position;
            change.wheel_position = moved.wheel_position;
            let deepest = (0..n).min_by(|a, b| plane.gap[*a].total_cmp(&plane.gap[*b]));
            change.approach = deepest.map_or(0.0, |k| -moved.gap[k]);
            let by = (by_position, moved.roller_angle);
            change.origin = ready.in_history_change(self.side, place, plane, by_place, by);
        }
        // the approach goes into the gap that is given, so that it drops out of what is left
        let pressed = NormalChange {
            gap: moved
                .as_ref()
                .map_or_else(|| vec![0.0; n], |moved| moved.gap.clone()),
            compliance: given.modulus.map_or(0.0, |by| by.compliance),
            ..NormalChange::nothing(n)
        };
        if moved.is_some() || given.modulus.is_some() {
            change.pressure = self.pressed(linear, grid, pressed, monitor)?;
        }

        // creepages
        let by_flow =
            self.kinematics
                .flow
                .change(ready, self.side, place, (by_place, &given.motion.rigid));
        let motion = self
            .kinematics
            .change(&by_flow, (by_position, by_turn, change.approach));
        let rows = frames(plane).map(|frames| {
            let (rail, by_rail) = (ready.rail(self.side, place), by_place.rail(self.side));
            let along = (by_position.x, moved.as_ref());
            let by = frame_changes((plane, &frames), (&rail, &by_rail), along);
            (frames, by)
        });
        let by_rows = rows.as_ref().map(|(frames, by_frames)| {
            self.kinematics
                .row_slips_change((plane, dy), (frames, by_frames), (&by_flow, &motion))
        });
        change.creepage = motion.creepage;
        change.rolling_speed = motion.speed;

        if let Some(rolling) = &self.rolling {
            let by_frame = self.frame_change(linear, given, &change);
            let asked = (given, moved.as_ref());
            let found = rolling.changed(
                self,
                linear,
                &change,
                asked,
                (&motion, by_frame, by_rows.as_deref()),
                monitor,
            )?;
            change.friction_power = found.power;
            let (sense, speed) = (rolling.sense, rolling.speed);
            let (end, cells) = (rolling.end(), rolling.operators.grid().points());
            for (here, there) in rolling.cut.points(rolling.operators.grid().nx) {
                change.coefficient[there] = found.coefficient[here];
                for c in 0..2 {
                    let (from, to) = (c * cells + here, c * n + there);
                    change.traction[to] = sense * found.traction[from];
                    if end.slips(here) {
                        change.slip_velocity[to] =
                            sense * (found.speed * end.slip[from] + speed * found.slip[from]);
                    }
                }
            }
        }

        let [x, y, z, ..] = by_place.pose;
        let by_centre = Vector3::new(x, y, z).component_mul(&mirror);
        let (by_force, by_moment) = match &rows {
            Some(rows) => self.load_of_rows_change(&change, rows, by_centre, area),
            None => self.load_change(&change, by_turn, (motion.on_wheel, by_centre), grid),
        };
        change.position = by_position.component_mul(&mirror).into();
        change.force = by_force.component_mul(&mirror).into();
        // a wheel at rest has no rolling speed
        let is_at_rest = self.kinematics.rolling == 0.0;
        change.rolling_speed *= if is_at_rest {
            0.0
        } else {
            self.kinematics.sense
        };
        let moment = if is_right {
            change = change.mirrored(plane.nx);
            -by_moment.component_mul(&mirror)
        } else {
            by_moment
        };
        Ok(Found {
            change,
            moment: moment.into(),
        })
    }

    /// Change of force and moment about the reference point, of a patch on a plane.
    fn load_change(
        &self,
        change: &PatchChange,
        by_turn: Matrix3<f64>,
        (by_on_wheel, by_centre): (Vector3<f64>, Vector3<f64>),
        grid: Grid,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (plane, n) = (&self.plane, self.pressure.len());
        let Grid { dx, dy, .. } = grid;
        let area = grid.cell_area();
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let (mut by_force, mut by_moment) = (Vector3::zeros(), Vector3::zeros());
        let traction = self.traction(n);
        for k in 0..n {
            let [x, y] = [
                dx * (plane.first[0] + (k % plane.nx) as i64) as f64,
                dy * (plane.first[1] + (k / plane.nx) as i64) as f64,
            ];
            let place = Vector3::new(x, y, 0.0);
            let load = Vector3::new(traction[k], traction[n + k], -self.pressure[k]);
            let by_load = Vector3::new(
                change.traction[k],
                change.traction[n + k],
                -change.pressure[k],
            );
            force += load;
            moment += place.cross(&load);
            by_force += by_load;
            by_moment += place.cross(&by_load);
        }
        let turn = self.kinematics.turn * area;
        let by_turn = by_turn * area;
        let by_force = by_turn * force + turn * by_force;
        let by_moment = by_turn * moment + turn * by_moment;
        let force = turn * force;
        let arm = self.kinematics.arm;
        let by_arm = by_on_wheel - by_centre;
        let by_moment = by_moment + by_arm.cross(&force) + arm.cross(&by_force);
        (by_force, by_moment)
    }

    /// The same of a patch that follows the rail.
    fn load_of_rows_change(
        &self,
        change: &PatchChange,
        (rows, by_rows): &(Vec<RowFrame>, Vec<RowFrame>),
        by_centre: Vector3<f64>,
        area: f64,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (plane, n) = (&self.plane, self.pressure.len());
        let dx = self
            .rolling
            .as_ref()
            .map_or(0.0, |rolling| rolling.operators.grid().dx);
        let centre = self.kinematics.on_wheel - self.kinematics.arm;
        let traction = self.traction(n);
        let (mut by_force, mut by_moment) = (Vector3::zeros(), Vector3::zeros());
        for (j, (row, by_row)) in rows.iter().zip(by_rows).enumerate() {
            // the force, and its moment by x, in the frame of the row
            let (mut own, mut by_own) = ([Vector3::zeros(); 2], [Vector3::zeros(); 2]);
            for i in 0..plane.nx {
                let k = j * plane.nx + i;
                let arm = Vector3::x() * (dx * (plane.first[0] + i as i64) as f64);
                let load = Vector3::new(traction[k], traction[n + k], -self.pressure[k]);
                let by_load = Vector3::new(
                    change.traction[k],
                    change.traction[n + k],
                    -change.pressure[k],
                );
                own = [own[0] + load, own[1] + arm.cross(&load)];
                by_own = [by_own[0] + by_load, by_own[1] + arm.cross(&by_load)];
            }
            let [force, _] = own.map(|own| row.turn * own * area);
            let [by, turning] =
                [0, 1].map(|c| (by_row.turn * own[c] + row.turn * by_own[c]) * area);
            let arm = row.on_wheel() - centre;
            let by_arm = row.on_wheel_change(by_row) - by_centre;
            by_force += by;
            by_moment += turning + by_arm.cross(&force) + arm.cross(&by);
        }
        (by_force, by_moment)
    }

    /// What the patch has taken over from the step before.
    pub(crate) fn brought(&self) -> Option<&Brought> {
        let first = self.rolling.as_ref()?.parts.first()?;
        first.transient.as_ref()?.before.as_ref()
    }

    /// Change of the way of the frame since the step before, along x over the reference point and across the rail [m].
    fn frame_change(
        &self,
        linear: &WheelTangent,
        given: &Given<'_>,
        change: &PatchChange,
    ) -> [f64; 2] {
        let Some(brought) = self.brought() else {
            return [0.0; 2];
        };
        let to = (linear.ready).in_history(self.side, &linear.place, &self.plane);
        (brought.gathered).moved_change(given.before, to, change.frame())
    }

    /// Change of the pressure by that of gap and compliance.
    fn pressed(
        &self,
        linear: &WheelTangent,
        grid: Grid,
        change: NormalChange,
        monitor: Monitor<'_>,
    ) -> Result<Vec<f64>, Error> {
        let joined = linear.ready.joined()?;
        let closing = |offset, cell| linear.ready.closing.at(&joined, offset, cell);
        let approach = self.plane.approach();
        let slope = linear.ready.slope(self.side, &self.plane);
        let undeformed: Vec<f64> = self.plane.gap.iter().map(|g| g + approach).collect();
        let contact = NormalContact {
            gap: &undeformed,
            grid,
            surface: match &slope {
                Some(slope) => Surface::Inclined(&closing, slope),
                None => Surface::FreeSpace(&closing),
            },
            load: Load::Approach(approach),
            moments: [None, None],
            hardness: None,
            rough: None,
            start: None,
        };
        let state = NormalState {
            pressure: &self.pressure,
            gap: &self.gap,
            approach,
            tilts: [0.0; 2],
        };
        let mut found = forward(&contact, &state, &[change], monitor)?;
        Ok(found.values.remove(0).pressure)
    }

    /// Traction (2n) on the whole patch, as of a left wheel.
    fn traction(&self, n: usize) -> Vec<f64> {
        let mut traction = vec![0.0; 2 * n];
        if let Some(rolling) = &self.rolling {
            let (end, cells) = (rolling.end(), rolling.operators.grid().points());
            for (here, there) in rolling.cut.points(rolling.operators.grid().nx) {
                for c in 0..2 {
                    traction[c * n + there] = rolling.sense * end.traction[c * cells + here];
                }
            }
        }
        traction
    }

    /// Narrows a margin to that of the patch.
    pub(crate) fn narrow(&self, margin: &mut WheelMargin) {
        let peak = self.pressure.iter().copied().fold(0.0, f64::max);
        for (p, gap) in self.pressure.iter().zip(&self.gap) {
            if *p > 0.0 {
                margin.parting = margin.parting.min(p / peak);
            } else {
                margin.touching = margin.touching.min(gap / self.kinematics.approach);
            }
        }
        for part in self.rolling.iter().flat_map(|rolling| &rolling.parts) {
            part.narrow(margin);
        }
    }
}

impl Part {
    /// Narrows a margin to that of the tractions.
    fn narrow(&self, margin: &mut WheelMargin) {
        let cells = self.pressure.len();
        let size = |field: &[f64], k: usize| field[k].hypot(field[cells + k]);
        let bound = |k: usize| self.coefficient[k] * self.pressure[k];
        let loaded: Vec<usize> = (0..cells).filter(|&k| self.pressure[k] > 0.0).collect();
        let largest = |of: &dyn Fn(usize) -> f64| loaded.iter().map(|k| of(*k)).fold(0.0, f64::max);
        let (most, fastest) = (largest(&bound), largest(&|k| size(&self.slip, k)));
        for k in loaded {
            if self.slips(k) {
                margin.sticking = margin.sticking.min(size(&self.slip, k) / fastest);
            } else {
                let left = (bound(k) - size(&self.traction, k)) / most;
                margin.slipping = margin.slipping.min(left.max(0.0));
            }
        }
    }
}

impl RollingLinear {
    /// The part at the end of the step.
    pub(crate) fn end(&self) -> &Part {
        &self.parts[self.parts.len() - 1]
    }

    /// What a part has rolled on from.
    pub(crate) fn earlier(&self, number: usize) -> Option<Cow<'_, Earlier>> {
        if let Some(last) = number.checked_sub(1) {
            return Some(Cow::Owned(self.parts[last].as_earlier(self.at_rest)));
        }
        let brought = self.parts[number].transient.as_ref()?.before.as_ref()?;
        Some(Cow::Borrowed(&brought.earlier))
    }

    /// The problem of a part that has rolled on from an earlier state, and its solution.
    pub(crate) fn solved<'a>(
        &'a self,
        part: &'a Part,
        earlier: Option<&'a Earlier>,
        linear: &WheelTangent,
    ) -> (TangentialProblem<'a>, TangentialState<'a>) {
        let [along, across, spin] = part.creepage.map(|c| c * self.of_creepage);
        let drive = [along, across];
        let problem = TangentialProblem {
            around: None,
            pressure: &part.pressure,
            origin: self.origin,
            drive: drive.map(Drive::Slip),
            rigid_slip: self.rigid_slip.as_deref(),
            spin,
            speed: self.speed,
            friction: &part.friction,
            earlier,
            plasticity: None,
            start: None,
            tolerance: linear.ready.accuracy.tangential,
        };
        let state = TangentialState {
            traction: &part.traction,
            slip: &part.slip,
            coefficient: &part.coefficient,
            drive,
        };
        (problem, state)
    }

    /// What follows for the tractions.
    fn changed(
        &self,
        patch: &PatchLinear,
        linear: &WheelTangent,
        change: &PatchChange,
        (given, moved): (&Given<'_>, Option<&PlaneChange>),
        (motion, by_frame, by_rows): (&KinematicsChange, [f64; 2], Option<&[RowSlip]>),
        monitor: Monitor<'_>,
    ) -> Result<TractionChange, Error> {
        let Kinematics {
            creepage, speed, ..
        } = patch.kinematics;
        let grid = self.operators.grid();
        let mut pressure = vec![0.0; grid.points()];
        for (here, there) in self.cut.points(grid.nx) {
            pressure[here] = change.pressure[there];
        }
        let before = (given.before.zip(patch.brought())).map(|(by, brought)| {
            let base = brought.gathered.of_base(by);
            let earlier = brought.gathered.change(by, grid.points(), self.at_rest);
            (base.creepage, earlier)
        });
        // pressures change evenly from part to part
        let pressed = |share: f64| -> Vec<f64> {
            let mut by: Vec<f64> = pressure.iter().map(|p| share * p).collect();
            let earlier = before.iter().flat_map(|(_, earlier)| &earlier.pressure);
            for (by, earlier) in by.iter_mut().zip(earlier) {
                *by += (1.0 - share) * earlier;
            }
            by
        };
        let by_last = before.as_ref().map_or([0.0; 3], |(creepage, _)| *creepage);
        // the parts of a step are equally long
        let count = self.parts.len() as f64;
        let (by_way, by_duration) = (by_frame.map(|by| by / count), given.duration / count);
        let mut last: Option<TangentialResponse> = None;
        let mut power = 0.0;
        for (number, part) in self.parts.iter().enumerate() {
            let earlier = self.earlier(number);
            let (problem, state) = self.solved(part, earlier.as_deref(), linear);
            let by_heat = part.transient.is_some() || self.operators.is_second_order();
            let around = by_heat.then(|| Surroundings {
                shape: [grid.nx + 2, grid.ny + 2],
                first: [1, 1],
            });
            let mut tangent = TangentialTangent::new(&self.operators, &problem, state, around)?;
            let mut by = tangent.no_change();
            by.pressure = pressed(part.share);
            by.layer = given.layer;
            let slip = given.modulus.map(|modulus| &modulus.slips[number]);
            if let Some(slip) = slip {
                by.rigid_slip.clone_from(&slip.whole);
                by.stiffness = slip.stiffness;
            }
            if let (Some(last), Some(before)) = (last, number.checked_sub(1)) {
                by.earlier.traction = last.traction;
                by.earlier.pressure = pressed(self.parts[before].share);
                by.earlier.coefficient = last.coefficient;
            } else if let Some((_, earlier)) = &before {
                by.earlier.clone_from(earlier);
            }
            if let Some(slip) = slip {
                by.rigid_slip_behind.clone_from(&slip.behind);
            }
            if let Some(transient) = &part.transient {
                let rigid = part.rigid(&patch.kinematics, motion, by_last);
                transient.change(
                    self,
                    &tangent,
                    &linear.ready,
                    rigid,
                    (by_way, motion.by_rolling, by_duration),
                    &mut by,
                )?;
            } else {
                by.drive = [0, 1].map(|c| self.sense * change.creepage[c]);
                by.spin = change.creepage[2];
                if let Some(of_speed) = by.law.last_mut() {
                    *of_speed = change.rolling_speed / speed;
                }
            }
            let by_rows = by_rows.map(|by_rows| {
                let by_part = (by_way, by_duration);
                self.by_rows(
                    &patch.kinematics,
                    (part, by_part),
                    (motion, by_rows),
                    &mut by,
                )
            });
            self.by_friction(patch, linear, (number, moved), (given, motion), &mut by);
            let found = tangent.forward(&by, monitor)?;
            if let Some(transient) = &part.transient {
                let heat: f64 = found.dissipation.iter().sum();
                let faster = transient.friction_power * by_duration / transient.duration;
                power += (grid.cell_area() * self.speed * heat - faster) / count;
            } else if by_heat {
                let heat: f64 = found.dissipation.iter().sum();
                let faster = change.rolling_speed / speed * self.friction_power;
                power = grid.cell_area() * self.speed * heat + faster;
            } else {
                let mut changed = self.operators.slip_by_pressure(&by.pressure);
                if let Some(slip) = slip {
                    for (changed, own) in changed.iter_mut().zip(&slip.by_pressure) {
                        *changed += own;
                    }
                }
                let drive = (state.drive, creepage[2]);
                power = self.steady_power(
                    (drive, speed),
                    (&by, change.rolling_speed, by_rows.as_deref()),
                    (&found, &changed),
                );
            }
            last = Some(found);
        }
        // a rolling patch has parts
        let found = last.unwrap_or_else(|| unreachable!("a way without parts"));
        let faster = self
            .end()
            .transient
            .as_ref()
            .map_or(change.rolling_speed, |transient| {
                -self.speed * by_duration / transient.duration
            });
        Ok(TractionChange {
            traction: found.traction,
            slip: found.slip,
            coefficient: found.coefficient,
            speed: faster,
            power,
        })
    }

    /// What rows of a patch that follows the rail slip as the problem sees them, times a factor, row by row of its cells.
    pub(crate) fn rows_seen(&self, slips: &[RowSlip], factor: f64) -> Vec<RowSlip> {
        if self.incline.is_none() {
            return Vec::new();
        }
        let rows = self.operators.grid().ny;
        self.cut.rows_seen(slips, rows, self.sense * factor)
    }

    /// Change of what rows that follow the rail slip in a part, with that of their velocities; told row by row.
    fn by_rows(
        &self,
        kinematics: &Kinematics,
        (part, (by_way, by_duration)): (&Part, ([f64; 2], f64)),
        (motion, by_rows): (&KinematicsChange, &[RowSlip]),
        by: &mut TangentialChange,
    ) -> Vec<RowSlip> {
        let grid = self.operators.grid();
        let speed = kinematics.speed;
        // slips of the problem over velocities, and their change; by how much the cells behind of spin are moved
        let (share, by_share, behind) = match &part.transient {
            None => (1.0 / speed, -motion.speed / speed.powi(2), 0.0),
            Some(transient) => {
                let ahead =
                    transient.duration * motion.by_rolling + transient.rolling * by_duration;
                (
                    transient.duration / transient.length,
                    by_duration / transient.length,
                    -by_way[0] - ahead,
                )
            }
        };
        let slips = self.rows_seen(&self.row_slips, 1.0);
        let changes: Vec<RowSlip> = (self.rows_seen(by_rows, share).iter().zip(&slips))
            .map(|(by, slip)| [0, 1, 2].map(|c| by[c] + by_share * slip[c]))
            .collect();
        let n = grid.points();
        let first = slip_place(self.origin, &self.operators);
        let last = first + (grid.nx - 1) as f64 * grid.dx;
        let [back, _] = self.operators.behind();
        for (row, ([along, across, spin], slip)) in changes.iter().zip(&slips).enumerate() {
            for i in 0..grid.nx {
                let k = row * grid.nx + i;
                let x = first + i as f64 * grid.dx;
                by.rigid_slip[k] += along;
                by.rigid_slip[n + k] += across + spin * x;
                // beyond the first and the last cell what is given there counts
                let x = x + back;
                let is_moved = !self.operators.is_second_order();
                let moved = if is_moved && (first..=last).contains(&x) {
                    behind
                } else {
                    0.0
                };
                by.rigid_slip_behind[k] += along;
                by.rigid_slip_behind[n + k] +=
                    across + spin * x.clamp(first, last) + share * slip[2] * moved;
            }
        }
        changes
    }

    /// Change of the power in steady rolling, of what the tractions work on the rigid slip and on that of the pressure.
    fn steady_power(
        &self,
        ((drive, spin), speed): (([f64; 2], f64), f64),
        (by, by_speed, by_rows): (&TangentialChange, f64, Option<&[RowSlip]>),
        (found, changed_by_pressure): (&TangentialResponse, &[f64]),
    ) -> f64 {
        let (grid, end) = (self.operators.grid(), self.end());
        let by_pressure = self.operators.slip_by_pressure(&end.pressure);
        let rows = by_rows.map(|by_rows| (self.rows_seen(&self.row_slips, 1.0 / speed), by_rows));
        let (mut power, mut by_power) = (0.0, 0.0);
        for (here, _) in self.cut.points(grid.nx) {
            let x = self.origin[0] + (here % grid.nx) as f64 * grid.dx;
            let y = self.origin[1] + (here / grid.nx) as f64 * grid.dy;
            let rigid = |drive: [f64; 2], spin: f64| [drive[0] - spin * y, drive[1] + spin * x];
            let mut slip = rigid(drive, spin);
            let mut by_slip = rigid(by.drive, by.spin);
            if let Some((rows, by_rows)) = &rows {
                let row = here / grid.nx;
                for (slip, [along, across, spin]) in
                    [(&mut slip, rows[row]), (&mut by_slip, by_rows[row])]
                {
                    slip[0] += along;
                    slip[1] += across + spin * x;
                }
            }
            for c in 0..2 {
                let at = c * grid.points() + here;
                let slip = slip[c] + by_pressure[at];
                power += end.traction[at] * slip;
                by_power += found.traction[at] * slip
                    + end.traction[at] * (by_slip[c] + changed_by_pressure[at]);
            }
        }
        grid.cell_area() * (speed * by_power + by_speed * power)
    }

    /// Changes of the coefficients, and of the parameters of a law.
    fn by_friction(
        &self,
        patch: &PatchLinear,
        linear: &WheelTangent,
        (number, moved): (usize, Option<&PlaneChange>),
        (given, motion): (&Given<'_>, &KinematicsChange),
        by: &mut TangentialChange,
    ) {
        let part = &self.parts[number];
        let coefficient = &mut by.coefficient;
        let map = match linear.ready.wheelset.friction_of(patch.side) {
            WheelFriction::Everywhere(Friction::Coulomb(_)) => {
                if given.friction.is_some() {
                    coefficient.fill(1.0);
                }
                return;
            }
            WheelFriction::Everywhere(Friction::StaticKinetic { .. }) => {
                // the coefficient at rest only decides which points slip
                for (here, value) in coefficient.iter_mut().enumerate() {
                    if part.slips(here) && given.friction == Some(1) {
                        *value = 1.0;
                    }
                }
                return;
            }
            WheelFriction::Everywhere(Friction::SpeedDependent { .. }) => {
                if let Some(k) = given.friction {
                    by.law[k] = 1.0;
                    self.by_rest(k, number, &mut by.earlier.coefficient);
                }
                return;
            }
            WheelFriction::Everywhere(Friction::TemperatureDependent(_)) => {
                if let Some(k) = given.friction {
                    by.law[k] = 1.0;
                }
                return;
            }
            WheelFriction::OnRail(map) => map,
        };
        let by_behind = part.transient.as_ref().map_or(0.0, |transient| {
            let left = (self.parts.len() - 1 - number) as f64;
            let duration = given.duration / self.parts.len() as f64;
            left * (transient.duration * motion.by_rolling + transient.rolling * duration)
        });
        let plane = &patch.plane;
        for (here, there) in self.cut.points(self.operators.grid().nx) {
            let (column, row) = (there % plane.nx, there / plane.nx);
            let dx = self.operators.grid().dx;
            let x = plane.position[0] + dx * (plane.first[0] + column as i64) as f64 - part.behind;
            let y = plane.rail_positions[row];
            if let Some(k) = given.friction {
                coefficient[here] = map.share(x, y, k);
            }
            let [by_x, by_y] = map.slopes(x, y);
            coefficient[here] -= by_x * by_behind;
            if let Some(moved) = moved {
                coefficient[here] += by_x * moved.position[0] + by_y * moved.rail_positions[row];
            }
        }
    }
}

impl RollingLinear {
    /// Particles that were in no patch before come with the coefficient at rest.
    fn by_rest(&self, parameter: usize, number: usize, coefficient: &mut [f64]) {
        let part = &self.parts[number];
        let Friction::SpeedDependent { law, .. } = &part.friction else {
            return;
        };
        let by_rest = law.parameters(0.0).get(parameter).copied().unwrap_or(0.0);
        if let Some(last) = number.checked_sub(1) {
            for (value, pressure) in coefficient.iter_mut().zip(&self.parts[last].pressure) {
                if *pressure <= 0.0 {
                    *value = by_rest;
                }
            }
            return;
        }
        let before = (part.transient.as_ref()).and_then(|transient| transient.before.as_ref());
        for (value, share) in coefficient
            .iter_mut()
            .zip(before.iter().flat_map(|b| &b.resting))
        {
            *value = by_rest * share;
        }
    }
}

impl Kinematics {
    /// Change of creepages and speed with the motion and the place of the plane: its origin, frame and approach.
    fn change(
        &self,
        by_flow: &Flow,
        (by_position, by_turn, by_approach): (Vector3<f64>, Matrix3<f64>, f64),
    ) -> KinematicsChange {
        let normal = self.turn.column(2).into_owned();
        let by_normal = by_turn.column(2).into_owned();
        let on_wheel = by_position - by_normal * self.approach - normal * by_approach;
        let (on_wheels, on_rails) = ([self.on_wheel, on_wheel], [self.on_rail, by_position]);
        let (by_rigid, by_spin_vector) = self.flow.change_at(by_flow, on_wheels, on_rails);
        let slip = self.turn.transpose() * self.rigid;
        let by_slip = by_turn.transpose() * self.rigid + self.turn.transpose() * by_rigid;
        let by_spin = by_normal.dot(&self.spin_vector) + normal.dot(&by_spin_vector);
        let along = [&self.turn, &by_turn].map(|turn| turn.column(0).into_owned());
        let by_travel = (self.flow).travel_change(by_flow, on_wheels, on_rails, along);
        let by_rolling = by_travel - 0.5 * by_slip.x;
        let speed = match self.measure {
            Measure::Rolling => self.sense * by_rolling,
            Measure::Sliding => (slip.x * by_slip.x + slip.y * by_slip.y) / self.speed,
            Measure::Given => 0.0,
        };
        let spin = normal.dot(&self.spin_vector);
        let creepage = [(slip.x, by_slip.x), (slip.y, by_slip.y), (spin, by_spin)];
        KinematicsChange {
            creepage: creepage.map(|(value, by)| (by - value / self.speed * speed) / self.speed),
            speed,
            on_wheel,
            by_slip: [by_slip.x, by_slip.y],
            by_spin,
            by_rolling,
        }
    }
}

/// Change of a [`Kinematics`].
pub(crate) struct KinematicsChange {
    creepage: [f64; 3],
    /// Of the speed, whose sign is the sense of rolling.
    pub(crate) speed: f64,
    on_wheel: Vector3<f64>,
    /// Of the velocity in the plane [m/s], of the spin [rad/s] and of the rolling speed.
    pub(crate) by_slip: [f64; 2],
    pub(crate) by_spin: f64,
    pub(crate) by_rolling: f64,
}
