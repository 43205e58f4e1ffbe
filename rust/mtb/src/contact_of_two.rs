// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two bodies that stand on each other, and what is asked of them.

use std::sync::Arc;

use mtb_contact::problem::{Body, FreeMotion, Friction, Geometry, Load, Loading, Outcome, Problem};
use mtb_contact::sliding::RigidMotion;
use mtb_operator::{Grid, Monitor, Relative};

use crate::Error;
use crate::standing::Spread;

/// Two bodies that stand on each other: the problem, and the gap between them.
pub struct Contact {
    /// The bodies, the points in which they meet, and the motions that are free.
    pub problem: Problem,
    /// Undeformed gap at each point (n) [m], > 0 open.
    pub gap: Vec<f64>,
    /// What a force and moments do on each elastic body above.
    pub(crate) spread: Vec<Spread>,
}

/// A state of contact.
#[derive(Clone, Debug)]
pub struct State {
    /// The solution in full; its force and moment act on the lower body.
    pub outcome: Outcome,
    /// Mean pressure over each point (n) [Pa].
    pub pressure: Vec<f64>,
    /// Mean tractions on the lower body over each point (2n) [Pa]: along the first tangents, then the second.
    pub traction: Vec<f64>,
}

impl State {
    /// The largest pressure [Pa].
    pub fn peak_pressure(&self) -> f64 {
        self.pressure.iter().copied().fold(0.0, f64::max)
    }
}

/// The motion of an upper body on a plane that comes down by itself: a load by a force needs it, as one by an
/// approach needs it not to be there.
pub fn descent(points: usize) -> FreeMotion {
    FreeMotion {
        body: Body::Upper,
        motion: RigidMotion {
            tangential_x: vec![0.0; points],
            tangential_y: vec![0.0; points],
            opening: vec![1.0; points],
            work: 0.0,
        },
        is_pulled: true,
    }
}

/// The motions of an upper body on a plane that tilts by itself about the axes x and y through the origin: loads
/// by moments need them. They take the moment of all loads together, that of a pull included.
pub fn tilts(grid: Grid) -> [FreeMotion; 2] {
    let places = places(grid);
    let tilt = |opening: fn(&[f64; 2]) -> f64| FreeMotion {
        body: Body::Upper,
        motion: RigidMotion {
            tangential_x: vec![0.0; places.len()],
            tangential_y: vec![0.0; places.len()],
            opening: places.iter().map(opening).collect(),
            work: 0.0,
        },
        is_pulled: false,
    };
    [tilt(|[_, y]| *y), tilt(|[x, _]| -x)]
}

/// Middles (x, y) [m] of the cells of a grid about the origin.
fn places(grid: Grid) -> Vec<[f64; 2]> {
    let (x, y) = (0.5 * (grid.nx - 1) as f64, 0.5 * (grid.ny - 1) as f64);
    let place = |k: usize| {
        [
            ((k % grid.nx) as f64 - x) * grid.dx,
            ((k / grid.nx) as f64 - y) * grid.dy,
        ]
    };
    (0..grid.points()).map(place).collect()
}

impl Contact {
    /// Any two bodies on the cells of a grid in a plane, centred at the origin.
    ///
    /// `gap` tells the undeformed gap [m] at (x, y) [m]; `motions` are free, such as [`descent`] and [`tilts`].
    ///
    /// # Errors
    /// Compliances of another number of points, numbers that are not finite.
    pub fn on_plane(
        pair: Relative,
        grid: Grid,
        gap: impl Fn(f64, f64) -> f64,
        motions: Vec<FreeMotion>,
    ) -> Result<Self, Error> {
        let n = grid.points();
        let places = places(grid);
        let mut points: Vec<f64> = places.iter().map(|p| p[0]).collect();
        points.extend(places.iter().map(|p| p[1]));
        points.resize(3 * n, 0.0);
        let axis = |c: usize| -> Vec<f64> {
            (0..3 * n)
                .map(|k| f64::from(u8::from(k / n == c)))
                .collect()
        };
        let [tangent_x, tangent_y, normal] = [0, 1, 2].map(axis);
        let geometry = Geometry {
            points,
            area: vec![grid.cell_area(); n],
            mean_frame: [tangent_x.clone(), tangent_y.clone(), normal.clone()],
            normal,
            tangent_x,
            tangent_y,
            means: None,
        };
        Ok(Self {
            problem: Problem::new(pair, Arc::new(geometry), motions)?,
            gap: places.iter().map(|p| gap(p[0], p[1])).collect(),
            spread: Vec::new(),
        })
    }

    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.gap.len()
    }

    /// Presses the bodies together without friction, under all of the loads at once.
    ///
    /// A force and moments on elastic bodies of finite elements are spread over them, as weight is: the force acts
    /// through the middle of the contact points, and of several bodies each takes its share.
    ///
    /// # Errors
    /// Those of [`Problem::load`] and [`Problem::press`]; [`Error::Unpressed`] for an approach to which a body gives
    /// way; [`Error::Unsolved`] where nothing holds the bodies.
    pub fn press(&self, loads: &[Load<'_>], monitor: Monitor<'_>) -> Result<State, Error> {
        let outcome = self.problem.press(&self.loaded(loads)?, monitor)?;
        self.state(outcome)
    }

    /// Lets the upper body slide along the velocity `along` (x, y), with friction at every point in contact.
    ///
    /// # Errors
    /// As [`Contact::press`]; [`Error::Unsolved`] as well where the body wedges.
    pub fn slide(
        &self,
        loads: &[Load<'_>],
        along: [f64; 2],
        friction: Friction<'_>,
        monitor: Monitor<'_>,
    ) -> Result<State, Error> {
        let loading = self.loaded(loads)?;
        let direction = self.problem.geometry().sliding_direction(along)?;
        let outcome = self
            .problem
            .slide(&loading, &direction, friction, None, monitor)?;
        self.state(outcome)
    }

    fn loaded(&self, loads: &[Load<'_>]) -> Result<Loading, Error> {
        let mut loading = self.problem.unloaded(self.gap.clone());
        for load in loads {
            let (force, moments) = match *load {
                Load::Force(force) if !self.spread.is_empty() => (force, [0.0; 2]),
                Load::Moments(moments) if !self.spread.is_empty() => (0.0, moments),
                load => {
                    self.problem.load(&mut loading, load)?;
                    continue;
                }
            };
            let share = 1.0 / self.spread.len() as f64;
            for body in &self.spread {
                body.load(&mut loading, share * force, moments.map(|m| share * m));
            }
        }
        let is_approach = |load: &Load<'_>| matches!(load, Load::Approach(_));
        if loads.iter().any(is_approach) && self.problem.unpressed(&loading)?.is_some() {
            return Err(Error::Unpressed);
        }
        Ok(loading)
    }

    fn state(&self, outcome: Outcome) -> Result<State, Error> {
        if let Some(reason) = outcome.unsolved() {
            return Err(Error::Unsolved(reason));
        }
        let mut traction = outcome.mean_tractions(self.problem.geometry());
        let pressure = traction.split_off(2 * self.points());
        Ok(State {
            outcome,
            pressure,
            traction,
        })
    }
}
