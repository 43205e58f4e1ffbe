// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two bodies that stand on each other, and what is asked of them.

use std::sync::Arc;

use mtb_contact::problem::{Body, FreeMotion, Friction, Geometry, Load, Loading, Outcome, Problem};
use mtb_contact::sliding::RigidMotion;
use mtb_operator::{Grid, Monitor, Relative};

use crate::Error;

/// Two bodies that stand on each other: the problem, and the gap between them.
pub struct Contact {
    /// The bodies, the points in which they meet, and the motions that are free.
    pub problem: Problem,
    /// Undeformed gap at each point (n) [m], > 0 open.
    pub gap: Vec<f64>,
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

impl Contact {
    /// Any two bodies on the cells of a grid in a plane, centred at the origin.
    ///
    /// `gap` tells the undeformed gap [m] at (x, y) [m]; `motions` are free, such as [`descent`].
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
        let place = |k: usize| {
            [
                (k % grid.nx) as f64 - 0.5 * (grid.nx - 1) as f64,
                (k / grid.nx) as f64 - 0.5 * (grid.ny - 1) as f64,
            ]
        };
        let places: Vec<[f64; 2]> = (0..n)
            .map(|k| [place(k)[0] * grid.dx, place(k)[1] * grid.dy])
            .collect();
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
        })
    }

    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.gap.len()
    }

    /// Presses the bodies together without friction.
    ///
    /// # Errors
    /// Those of [`Problem::load`] and [`Problem::press`]; [`Error::Unsolved`] where nothing holds the bodies.
    pub fn press(&self, load: Load<'_>, monitor: Monitor<'_>) -> Result<State, Error> {
        let outcome = self.problem.press(&self.loaded(load)?, monitor)?;
        self.state(outcome)
    }

    /// Lets the upper body slide along the velocity `along` (x, y), with friction at every point in contact.
    ///
    /// # Errors
    /// As [`Contact::press`]; [`Error::Unsolved`] as well where the body wedges.
    pub fn slide(
        &self,
        load: Load<'_>,
        along: [f64; 2],
        friction: Friction<'_>,
        monitor: Monitor<'_>,
    ) -> Result<State, Error> {
        let loading = self.loaded(load)?;
        let direction = self.problem.geometry().sliding_direction(along)?;
        let outcome = self
            .problem
            .slide(&loading, &direction, friction, None, monitor)?;
        self.state(outcome)
    }

    fn loaded(&self, load: Load<'_>) -> Result<Loading, Error> {
        let mut loading = self.problem.unloaded(self.gap.clone());
        self.problem.load(&mut loading, load)?;
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
