// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two bodies that stand on each other, and what is asked of them.

use std::sync::Arc;

use mtb_contact::problem::{
    Body, FreeMotion, Friction, Geometry, Load, Loading, Outcome, Problem, Window,
};
use mtb_contact::sliding::RigidMotion;
use mtb_operator::{Grid, Monitor, Relative};
use mtb_words::Short;

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

/// Loads in words.
fn told(loads: &[Load<'_>]) -> String {
    let told = loads.iter().map(|load| match load {
        Load::Force(force) => format!("a force of {} N", Short(*force)),
        Load::Moments([x, y]) => format!("a moment of ({}, {}) N m", Short(*x), Short(*y)),
        Load::Approach(approach) => format!("an approach of {} m", Short(*approach)),
        Load::Pull(pressure, _) | Load::Resultant(pressure, _) => {
            let largest = pressure.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            format!("a pull of {} Pa at most", Short(largest))
        }
        Load::Displacement(..) => "a displacement".to_owned(),
    });
    match told.collect::<Vec<_>>() {
        none if none.is_empty() => "no load".to_owned(),
        some => some.join(" with "),
    }
}

impl Contact {
    /// Any two bodies on the cells of a grid in a plane, centred at the origin; one of them ends at its edge.
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
        Self::on_cells(pair, grid, gap, motions, Vec::new())
    }

    /// [`Contact::on_plane`] with grids beyond which the bodies go on.
    pub(crate) fn on_cells(
        pair: Relative,
        grid: Grid,
        gap: impl Fn(f64, f64) -> f64,
        motions: Vec<FreeMotion>,
        windows: Vec<Window>,
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
            windows,
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
    /// Those of [`Problem::load`] and [`Problem::press`], an approach to which a body gives way among them;
    /// [`Error::Apart`] where the bodies do not touch;
    /// [`Edge`](mtb_contact::Error::Edge) where half-spaces touch at the edge of their grid; [`Error::Unsolved`] where nothing holds the bodies.
    pub fn press(&self, loads: &[Load<'_>], monitor: Monitor<'_>) -> Result<State, Error> {
        let outcome = self.problem.press(&self.loading(loads)?, monitor)?;
        self.state(outcome, loads)
    }

    /// Lets the upper body slide along the velocity `along` (x, y), with friction at every point in contact.
    ///
    /// # Errors
    /// As [`Contact::press`]; [`Error::Still`] for a velocity that is zero or not finite; [`Error::Unsolved`] as well
    /// where the body wedges.
    pub fn slide(
        &self,
        loads: &[Load<'_>],
        along: [f64; 2],
        friction: Friction<'_>,
        monitor: Monitor<'_>,
    ) -> Result<State, Error> {
        if along == [0.0; 2] || !along.iter().all(|v| v.is_finite()) {
            return Err(Error::Still { along });
        }
        // only the direction counts, and squares overflow
        let size = along[0].abs().max(along[1].abs());
        let along = along.map(|v| v / size);
        let loading = self.loading(loads)?;
        let direction = self.problem.geometry().sliding_direction(along)?;
        let outcome = self
            .problem
            .slide(&loading, &direction, friction, None, monitor)?;
        self.state(outcome, loads)
    }

    /// What loads do together: the gap they leave, and their work on the free motions. The other questions of the
    /// problem take it, such as [`Problem::stick_or_slip`], and so does [`Prepared::new`](mtb_contact::prepared).
    ///
    /// # Errors
    /// Those of [`Problem::load`].
    pub fn loading(&self, loads: &[Load<'_>]) -> Result<Loading, Error> {
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
        let given = loads.iter().find_map(|load| match load {
            Load::Approach(approach) => Some(*approach),
            _ => None,
        });
        if let Some(approach) = given
            && self.problem.unpressed(&loading)?.is_some()
        {
            return Err(mtb_contact::Error::GivesWay { approach }.into());
        }
        Ok(loading)
    }

    fn state(&self, outcome: Outcome, loads: &[Load<'_>]) -> Result<State, Error> {
        if let Some(reason) = outcome.unsolved() {
            return Err(Error::Unsolved(reason));
        }
        if !outcome.in_contact().contains(&true) {
            return Err(Error::Apart {
                loads: told(loads),
                gap: (outcome.solution.gap.iter().copied()).fold(f64::INFINITY, f64::min),
            });
        }
        (self.problem.geometry()).check_edge(&outcome.solution.pressure)?;
        let mut traction = outcome.mean_tractions(self.problem.geometry());
        let pressure = traction.split_off(2 * self.points());
        Ok(State {
            outcome,
            pressure,
            traction,
        })
    }
}
