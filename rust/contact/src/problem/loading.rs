// SPDX-License-Identifier: MIT OR Apache-2.0
//! What presses the bodies: the gap it leaves, and the work it does on the motions that are free.

use mtb_operator::{Compliance, Component, Mirrored};

use super::{Geometry, Problem};
use crate::error::{Error, check, check_number};
use crate::sliding::{RigidMotion, displacement};

/// Share of its parts below which the sum of the works of a pull is rounding.
const ROUNDING: f64 = 1e-13;
/// What a load by one number must be.
const FINITE: &str = "a finite number is needed";

/// One of the two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// The lower one, whose normals point to the other.
    Lower,
    /// The upper one.
    Upper,
}

/// What presses the bodies together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load<'a> {
    /// A force [N] down on the upper body; of several bodies that come down by themselves each takes its share.
    Force(f64),
    /// Moments [N m] about x and y on the upper body; of several bodies that tilt by themselves each takes its
    /// share.
    Moments([f64; 2]),
    /// The upper body comes down by so much [m], as a whole.
    Approach(f64),
    /// A pressure (n) [Pa] that pulls at the surface of one body towards the other, as magnets do: it moves the
    /// surface as a pressure of the opposite sign would, and works on the free motions of the body.
    Pull(&'a [f64], Body),
    /// The same pull where only its resultant counts: it works on the free motions and moves no surface.
    Resultant(&'a [f64], Body),
    /// A displacement (3n) [m] of the points of one body that is known beforehand, in the common frame.
    Displacement(&'a [f64], Body),
}

/// A body that is pulled towards the other one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attracted {
    /// The body.
    pub body: Body,
    /// Whether the pull moves its surface ([`Load::Pull`]); otherwise [`Load::Resultant`].
    pub at_face: bool,
}

impl Attracted {
    /// The load by a pressure (n) [Pa].
    pub fn by(self, pressure: &[f64]) -> Load<'_> {
        if self.at_face {
            Load::Pull(pressure, self.body)
        } else {
            Load::Resultant(pressure, self.body)
        }
    }
}

/// What is given to a problem for one solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Loading {
    /// Gap before contact (n) [m], all displacements included that are known beforehand.
    pub gap: Vec<f64>,
    /// Work of all loads but the contact's on a unit of each motion (m) [J].
    pub work: Vec<f64>,
    /// Displacement `u_lower - u_upper` along both tangents (2n) [m] by all that is known beforehand. Where all slides it
    /// is no matter; where points stick, they slip by its change.
    pub along: Vec<f64>,
    /// Diagonal compliance (n) [m/Pa], as [`SlidingContact::diagonal`](crate::sliding::SlidingContact::diagonal).
    pub diagonal: Option<Vec<f64>>,
}

impl Loading {
    /// The same after wear: `worn` (n) [m] more in the gap, and a `diagonal` (n) [m/Pa] besides its own.
    #[must_use]
    pub fn worn(&self, worn: &[f64], diagonal: &[f64]) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        let own = self.diagonal.as_deref();
        Self {
            gap: sum(&self.gap, worn),
            work: self.work.clone(),
            along: self.along.clone(),
            diagonal: Some(own.map_or_else(|| diagonal.to_vec(), |own| sum(own, diagonal))),
        }
    }
}

/// A rigid motion that supports leave free, of one of the bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeMotion {
    /// The body that it moves.
    pub body: Body,
    /// What it does to the contact; its `work` is part of the loading.
    pub motion: RigidMotion,
    /// Whether a pull on the body works on it. It does not where the work of all loads is given as a whole, as
    /// the moment on a tilt.
    pub is_pulled: bool,
}

impl FreeMotion {
    /// The motion of a body a unit of which moves its contact points by `displacement` (3n) [m], in the common
    /// frame; pulls work on it.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite.
    pub fn of(geometry: &Geometry, body: Body, displacement: &[f64]) -> Result<Self, Error> {
        check("motion", displacement, 3 * geometry.points())?;
        let upwards = body.sign();
        let along = |axes: &[f64], sign: f64| geometry.along(axes, displacement, sign);
        Ok(Self {
            body,
            motion: RigidMotion {
                tangential_x: along(&geometry.tangent_x, -upwards),
                tangential_y: along(&geometry.tangent_y, -upwards),
                opening: along(&geometry.normal, upwards),
                work: 0.0,
            },
            is_pulled: true,
        })
    }
}

impl Body {
    /// 1 for the upper one, from which the gap opens along the normal; -1 for the lower one.
    fn sign(self) -> f64 {
        match self {
            Body::Lower => -1.0,
            Body::Upper => 1.0,
        }
    }
}

impl Geometry {
    /// The same vector at all points (3n), for example a displacement [m] of a body.
    pub fn uniform(&self, vector: [f64; 3]) -> Vec<f64> {
        let n = self.points();
        (0..3 * n).map(|k| vector[k / n]).collect()
    }

    /// `sign` times the component of vectors (3n) along one of the axes (3n) of each point.
    pub(crate) fn along(&self, axes: &[f64], vectors: &[f64], sign: f64) -> Vec<f64> {
        (0..self.points())
            .map(|i| {
                let (axis, vector) = (Self::vector(axes, i), Self::vector(vectors, i));
                sign * (axis[0] * vector[0] + axis[1] * vector[1] + axis[2] * vector[2])
            })
            .collect()
    }

    /// Adds `u_lower - u_upper` along both tangents (2n) [m] by the displacement (3n) [m] of a body.
    fn move_along(&self, displacement: &[f64], body: Body, along: &mut [f64]) {
        let axes = [&self.tangent_x, &self.tangent_y];
        for (axes, along) in axes.into_iter().zip(along.chunks_mut(self.points().max(1))) {
            let moved = self.along(axes, displacement, -body.sign());
            along.iter_mut().zip(moved).for_each(|(a, m)| *a += m);
        }
    }
}

impl Problem {
    /// A loading by nothing: the undeformed gap (n) [m] alone.
    pub fn unloaded(&self, gap: Vec<f64>) -> Loading {
        Loading {
            gap,
            work: vec![0.0; self.motions.len()],
            along: vec![0.0; 2 * self.points()],
            diagonal: None,
        }
    }

    /// Adds a load to what is given.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite; [`Error::Held`] for a force where no motion lets the upper
    /// body down; [`Error::GivesWay`] for an approach that free motions take up, whatever else presses.
    pub fn load(&self, loading: &mut Loading, load: Load<'_>) -> Result<(), Error> {
        self.check(loading)?;
        let g = &*self.geometry;
        let n = g.points();
        match load {
            Load::Force(force) => {
                check_number("force", force, true, FINITE)?;
                let lifts: Vec<f64> = self.motions.iter().map(|free| self.lift(free)).collect();
                let count = lifts.iter().filter(|lift| **lift != 0.0).count();
                if count == 0 {
                    return Err(Error::Held);
                }
                for (work, lift) in loading.work.iter_mut().zip(lifts) {
                    *work -= force / count as f64 * lift;
                }
            }
            Load::Moments(moments) => {
                check("moments", &moments, 2)?;
                let turns: Vec<[f64; 2]> =
                    self.motions.iter().map(|free| self.turn(free)).collect();
                for axis in 0..2 {
                    let count = turns.iter().filter(|turn| turn[axis] != 0.0).count();
                    if count == 0 && moments[axis] != 0.0 {
                        return Err(Error::NotTilting {
                            axis: ["x", "y"][axis],
                        });
                    }
                    for (work, turn) in loading.work.iter_mut().zip(&turns) {
                        *work += moments[axis] / count.max(1) as f64 * turn[axis];
                    }
                }
            }
            Load::Approach(approach) => {
                check_number("approach", approach, true, FINITE)?;
                if self.gives_way() {
                    return Err(Error::GivesWay { approach });
                }
                for (gap, slope) in loading.gap.iter_mut().zip(&g.mean_frame[2][2 * n..]) {
                    *gap -= approach * slope;
                }
                g.move_along(
                    &g.uniform([0.0, 0.0, -approach]),
                    Body::Upper,
                    &mut loading.along,
                );
            }
            Load::Pull(pressure, body) => {
                self.load(loading, Load::Resultant(pressure, body))?;
                if let Some(pulled) = self.body(body) {
                    let normal = Component::Normal;
                    pulled.add_displacement(normal, normal, -1.0, pressure, &mut loading.gap);
                    let [x, y] = [Component::X, Component::Y];
                    for (axis, along) in [x, y].into_iter().zip(loading.along.chunks_mut(n)) {
                        match body {
                            Body::Lower => {
                                pulled.add_displacement(axis, normal, -1.0, pressure, along);
                            }
                            Body::Upper => Mirrored(&**pulled)
                                .add_displacement(axis, normal, -1.0, pressure, along),
                        }
                    }
                }
            }
            Load::Resultant(pressure, body) => {
                check("pull", pressure, n)?;
                for (free, work) in self.motions.iter().zip(&mut loading.work) {
                    if free.body == body && free.is_pulled {
                        let opened = free.motion.opening.iter().zip(pressure).zip(&g.area);
                        let (mut sum, mut size) = (0.0, 0.0_f64);
                        for part in opened.map(|((o, p), a)| o * p * a) {
                            sum += part;
                            size += part.abs();
                        }
                        // a pull that is balanced in itself turns nothing
                        if sum.abs() > ROUNDING * size {
                            *work -= sum;
                        }
                    }
                }
            }
            Load::Displacement(displacement, body) => {
                check("displacement", displacement, 3 * n)?;
                let opened = g.along(&g.normal, displacement, body.sign());
                for (gap, opened) in loading.gap.iter_mut().zip(opened) {
                    *gap += opened;
                }
                g.move_along(displacement, body, &mut loading.along);
            }
        }
        Ok(())
    }

    /// The first free motion that lets a body go along z while no load works on it: an approach pushes this body
    /// aside instead of pressing it.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn unpressed(&self, loading: &Loading) -> Result<Option<usize>, Error> {
        self.check(loading)?;
        let mut loaded = self.motions.iter().zip(&loading.work);
        Ok(loaded.position(|(free, work)| *work == 0.0 && self.rise(free) != 0.0))
    }

    /// Displacement (3n) [m] of the contact points of a body, in the common frame, by the tractions (3n) [Pa] of
    /// the contact: along both tangents on the lower body, and pressure; less a `pull` (n) [Pa] at its surface.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite.
    pub fn displacement(
        &self,
        body: Body,
        traction: &[f64],
        pull: Option<&[f64]>,
    ) -> Result<Vec<f64>, Error> {
        let g = &*self.geometry;
        let n = g.points();
        check("traction", traction, 3 * n)?;
        let Some(compliance) = self.body(body) else {
            return Ok(vec![0.0; 3 * n]);
        };
        // the upper body feels the opposite friction
        let mut own: Vec<f64> = traction[..2 * n].iter().map(|q| -body.sign() * q).collect();
        own.extend(&traction[2 * n..]);
        if let Some(pull) = pull {
            check("pull", pull, n)?;
            for (pressure, pull) in own[2 * n..].iter_mut().zip(pull) {
                *pressure -= pull;
            }
        }
        let moved = displacement(&**compliance, [&own[..n], &own[n..2 * n], &own[2 * n..]]);
        let mut common = vec![0.0; 3 * n];
        for i in 0..n {
            let [x, y, z] =
                [&g.tangent_x, &g.tangent_y, &g.normal].map(|field| Geometry::vector(field, i));
            for c in 0..3 {
                common[c * n + i] =
                    x[c] * moved[0][i] + y[c] * moved[1][i] + body.sign() * z[c] * moved[2][i];
            }
        }
        Ok(common)
    }

    /// Whether free motions along z take up an approach at every point.
    fn gives_way(&self) -> bool {
        let rises = |free: &&FreeMotion| self.rise(free) != 0.0;
        let rising: Vec<&FreeMotion> = self.motions.iter().filter(rises).collect();
        (0..self.points()).all(|i| {
            rising.iter().any(|FreeMotion { motion, .. }| {
                [&motion.tangential_x, &motion.tangential_y, &motion.opening]
                    .iter()
                    .any(|moved| moved[i] != 0.0)
            })
        })
    }

    /// The compliance of a body; `None` of a rigid one.
    pub(crate) fn body(&self, body: Body) -> Option<&std::sync::Arc<dyn Compliance>> {
        match body {
            Body::Lower => self.pair.lower(),
            Body::Upper => self.pair.upper(),
        }
    }

    /// Rise of the upper body, or of one of several, along z by a unit of a motion; zero for all motions but
    /// translations along z.
    fn lift(&self, free: &FreeMotion) -> f64 {
        match free.body {
            Body::Upper => self.rise(free),
            Body::Lower => 0.0,
        }
    }

    /// How far the bodies move apart along z by a unit of a motion; zero for all motions but translations along z.
    fn rise(&self, free: &FreeMotion) -> f64 {
        let (g, motion) = (&*self.geometry, &free.motion);
        let n = g.points();
        let mut lift = 0.0;
        for i in 0..n {
            let [x, y, z] = [0, 1, 2].map(|axis| g.mean_frame[axis][2 * n + i]);
            let moved = [
                motion.tangential_x[i],
                motion.tangential_y[i],
                motion.opening[i],
            ];
            if moved == [0.0; 3] {
                continue;
            }
            if lift == 0.0 {
                lift = moved[2] * z - moved[0] * x - moved[1] * y;
            }
            let rest = [
                moved[0] + lift * x,
                moved[1] + lift * y,
                moved[2] - lift * z,
            ];
            if rest.iter().any(|r| r.abs() > 1e-9 * lift.abs()) {
                return 0.0;
            }
        }
        lift
    }

    /// Rotation of the upper body, or of one of several, about x and y by a unit of a motion.
    ///
    /// Its points rise by a + `turn_x` y - `turn_y` x, wherever they lie along z.
    fn turn(&self, free: &FreeMotion) -> [f64; 2] {
        let (g, motion) = (&*self.geometry, &free.motion);
        let n = g.points();
        let mut moved = Vec::new();
        for i in 0..n {
            let [x, y, z] = [0, 1, 2].map(|axis| g.mean_frame[axis][2 * n + i]);
            let [along, across, opening] = [
                motion.tangential_x[i],
                motion.tangential_y[i],
                motion.opening[i],
            ];
            if [along, across, opening] != [0.0; 3] {
                let rise = opening * z - along * x - across * y;
                moved.push([g.points[i], g.points[n + i], rise]);
            }
        }
        if free.body == Body::Lower || moved.is_empty() {
            return [0.0; 2];
        }
        let mean = [0, 1, 2].map(|c| moved.iter().map(|p| p[c]).sum::<f64>() / moved.len() as f64);
        let sum = |a: usize, b: usize| -> f64 {
            let parts = moved.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b]));
            parts.sum()
        };
        let (xx, xy, yy, xz, yz) = (sum(0, 0), sum(0, 1), sum(1, 1), sum(0, 2), sum(1, 2));
        let determinant = xx * yy - xy * xy;
        if determinant <= 1e-12 * (xx + yy).powi(2) {
            return [0.0; 2];
        }
        let turn = [
            (yz * xx - xz * xy) / determinant,
            -(xz * yy - yz * xy) / determinant,
        ];
        // what a translation turns is rounding
        let size = ((xx + yy) / moved.len() as f64).sqrt();
        let least = 1e-9 * moved.iter().map(|p| p[2].abs()).fold(0.0, f64::max);
        turn.map(|t| if t.abs() * size > least { t } else { 0.0 })
    }

    pub(super) fn check(&self, loading: &Loading) -> Result<(), Error> {
        check("gap", &loading.gap, self.points())?;
        check("work", &loading.work, self.motions.len())?;
        check(
            "displacement along the tangents",
            &loading.along,
            2 * self.points(),
        )?;
        match &loading.diagonal {
            Some(diagonal) => check("diagonal", diagonal, self.points()),
            None => Ok(()),
        }
    }

    pub(super) fn loaded(&self, work: &[f64]) -> Vec<RigidMotion> {
        let works = self.motions.iter().zip(work);
        works
            .map(|(free, work)| RigidMotion {
                work: *work,
                ..free.motion.clone()
            })
            .collect()
    }
}
