// SPDX-License-Identifier: MIT OR Apache-2.0
//! Magnets whose pull follows the gap, on a prepared contact.

use std::sync::Arc;

use mtb_operator::{Monitor, Relative};

use super::{Following, Prepared, Table};
use crate::coupled::{OnDemand, StickPulling};
use crate::error::{Error, check};
use crate::magnet::{Circuit, Face, Pulling};
use crate::problem::{Attracted, Body, Loading, Problem};

/// Share of its parts below which the sum of the works of a pull is rounding.
const ROUNDING: f64 = 1e-13;

/// A magnet whose pull follows the gap, with a factor over the sliding speed.
#[derive(Clone, Debug, PartialEq)]
pub struct MagnetOverSpeed {
    /// Coil, poles and iron.
    pub circuit: Circuit,
    /// One number over the speed: the factor on its pressure.
    pub factor: Table,
}

impl MagnetOverSpeed {
    /// Checks that it fits so many points.
    pub(super) fn check(&self, points: usize) -> Result<(), Error> {
        check("area", &self.circuit.poles().area, points)?;
        self.factor.check(FACTOR, 1)
    }

    /// With a circuit of its own kind, at a velocity.
    pub(super) fn at<'a>(
        &self,
        circuit: &'a Circuit,
        [x, y]: [f64; 2],
    ) -> Result<Following<'a>, Error> {
        let speed = x.hypot(y);
        Ok(Following {
            circuit,
            factor: self.factor.at(FACTOR, speed)?[0],
            by_speed: self.factor.slope(speed)[0],
        })
    }
}

/// What messages call its factor.
const FACTOR: &str = "speed_factor";

/// What a pull at the points of a contact does.
#[derive(Clone, Debug, PartialEq)]
pub struct Pulled {
    /// How it closes gaps; `None` where it moves no surface.
    pub face: Option<OnDemand<Face>>,
    /// Work [J/Pa] on each motion (m) of a unit of pull at each point (n).
    pub works: Vec<Vec<f64>>,
}

impl Pulled {
    /// On bodies of a problem, with what the pull moves along the tangents.
    pub(super) fn of(
        problem: &Problem,
        bodies: &[Attracted],
    ) -> Result<(Self, Option<OnDemand<Face>>), Error> {
        let at_face = |body: Body| bodies.iter().any(|own| own.body == body && own.at_face);
        let moved = |body| at_face(body).then(|| problem.body(body).cloned()).flatten();
        let (lower, upper) = (moved(Body::Lower), moved(Body::Upper));
        let (mut face, mut along) = (None, None);
        if lower.is_some() || upper.is_some() {
            let pair = Relative::new(lower, upper)?;
            let own = pair.clone();
            face = Some(OnDemand::new(move |monitor| {
                Face::new(&own, &Face::NORMAL, monitor)
            }));
            along = Some(OnDemand::new(move |monitor| {
                Face::new(&pair, &Face::ALONG, monitor)
            }));
        }
        let works = problem.works_of_pull(bodies);
        Ok((Self { face, works }, along))
    }

    /// Checks the lengths for so many points and motions.
    pub(super) fn check(&self, points: usize, motions: usize) -> Result<(), Error> {
        if self.works.len() != motions {
            return Err(Error::Shape {
                name: "works of a pull",
                expected: motions,
                found: self.works.len(),
            });
        }
        (self.works.iter()).try_for_each(|work| check("work of a pull", work, points))
    }
}

/// What a pull moves, formed.
#[derive(Debug)]
pub(super) struct Faces<'a> {
    pulled: &'a Pulled,
    normal: Option<Arc<Face>>,
    /// `None` too where points cannot stick.
    along: Option<Arc<Face>>,
}

impl Prepared {
    /// What a pull moves.
    ///
    /// # Errors
    /// [`Error::NoPull`] of a file without it; as [`Face::new`].
    pub(super) fn faces(&self, monitor: Monitor<'_>) -> Result<Faces<'_>, Error> {
        let formed = |face: &Option<OnDemand<Face>>| -> Result<Option<Arc<Face>>, Error> {
            face.as_ref().map(|face| face.get(monitor)).transpose()
        };
        let pulled = self.pulled.as_ref().ok_or(Error::NoPull)?;
        Ok(Faces {
            pulled,
            normal: formed(&pulled.face)?,
            along: match &self.bodies {
                None => None,
                Some(bodies) => formed(&bodies.pulled)?,
            },
        })
    }
}

impl Faces<'_> {
    /// Work on each motion of a unit of pull at each point.
    pub(super) fn works(&self) -> &[Vec<f64>] {
        &self.pulled.works
    }

    /// What closes gaps.
    pub(super) fn normal(&self) -> Option<&Arc<Face>> {
        self.normal.as_ref()
    }

    /// What moves along the tangents.
    pub(super) fn along(&self) -> Option<&Arc<Face>> {
        self.along.as_ref()
    }

    /// A loading with a pull (n) [Pa] besides.
    pub(super) fn pulled(&self, loading: &Loading, pull: &[f64]) -> Loading {
        let mut loading = loading.clone();
        if let Some(face) = &self.normal {
            face.add(-1.0, pull, &mut loading.gap);
        }
        if let Some(face) = &self.along {
            face.add(-1.0, pull, &mut loading.along);
        }
        for (work, own) in loading.work.iter_mut().zip(self.works()) {
            let (mut sum, mut size) = (0.0, 0.0_f64);
            for part in own.iter().zip(pull).map(|(w, p)| w * p) {
                sum += part;
                size += part.abs();
            }
            // a pull that is balanced in itself turns nothing
            if sum.abs() > ROUNDING * size {
                *work += sum;
            }
        }
        loading
    }
}

impl Faces<'_> {
    /// A magnet that is linearised, where points stick or slip.
    pub(super) fn sticking(&self, pulling: Pulling) -> StickPulling {
        StickPulling::new(pulling, self.along.clone())
    }
}

impl Following<'_> {
    /// The magnet linearised about gaps (n) [m], with the motions that are `free`.
    pub(super) fn pulling(
        &self,
        faces: &Faces<'_>,
        gap: &[f64],
        free: &[usize],
    ) -> Result<Pulling, Error> {
        let slopes = self.circuit.slopes(gap, self.factor)?;
        let works = free.iter().map(|&k| faces.works()[k].clone());
        Ok(Pulling::of(slopes, faces.normal.clone(), works.collect()))
    }
}
