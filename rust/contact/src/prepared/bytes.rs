// SPDX-License-Identifier: MIT OR Apache-2.0
//! A prepared contact as bytes: a [`crate::record`] marked `MTBC`.

use std::sync::Arc;

use mtb_operator::{Component, Monitor};

use super::{Bodies, MagnetOverSpeed, NamedMotion, Prepared, Pulled, Table};
use crate::coupled::{CoupledMatrix, OnDemand};
use crate::error::Error;
use crate::interface::{Interface, RoughLaw};
use crate::magnet::{Circuit, Face, Iron, Limb, Poles};
use crate::problem::{Geometry, Means, Window};
use crate::record::{Damaged, Reader, Writer};
use crate::sliding::RigidMotion;
use crate::stepping::Influence;

const MARK: [u8; 4] = *b"MTBC";
const VERSION: u32 = 8;
/// The version before, which did not keep the velocity of the scene.
const WITHOUT_VELOCITY: u32 = 7;
/// The version before that one, which knew of no magnet whose pull follows the gap.
const WITHOUT_MAGNETS: u32 = 6;
/// One more before, which knew of no compliance along the tangents.
const WITHOUT_TANGENTS: u32 = 5;
/// One more before, which knew of no layer that yields.
const WITHOUT_SHEAR: u32 = 4;
/// One more before, which knew of no hardness and no rough layer.
const WITHOUT_INTERFACE: u32 = 3;
/// One more before, which did not hold where the bodies go on beyond their points.
const WITHOUT_WINDOWS: u32 = 2;

const KNOWN: [u32; 7] = [
    VERSION,
    WITHOUT_VELOCITY,
    WITHOUT_MAGNETS,
    WITHOUT_TANGENTS,
    WITHOUT_SHEAR,
    WITHOUT_INTERFACE,
    WITHOUT_WINDOWS,
];

impl Prepared {
    /// The contact as bytes, for a file, with all that sliding needs. How a pull moves the bodies is among it where the
    /// scene has a magnet whose pull follows the gap: a number more for each pair of points.
    ///
    /// # Errors
    /// More points than the memory holds; [`Error::Interrupted`].
    pub fn to_bytes(&self, monitor: Monitor<'_>) -> Result<Vec<u8>, Error> {
        self.written(None, monitor)
    }

    /// The same with the compliance along the tangents, for steps with a [shift](super::Step::shift) too: nine numbers
    /// more for each pair of points.
    ///
    /// # Errors
    /// [`Error::NoTangents`] of a contact whose file had none; more points than the memory holds;
    /// [`Error::Interrupted`].
    pub fn to_bytes_for_shifts(&self, monitor: Monitor<'_>) -> Result<Vec<u8>, Error> {
        let bodies = self.bodies.as_ref().ok_or(Error::NoTangents)?;
        let matrix = bodies.pair.get(monitor)?;
        self.written(Some((bodies, &matrix)), monitor)
    }

    fn written(
        &self,
        bodies: Option<(&Bodies, &CoupledMatrix)>,
        monitor: Monitor<'_>,
    ) -> Result<Vec<u8>, Error> {
        let magnet = match &self.magnet {
            None => None,
            Some(magnet) => Some((magnet, self.faces(monitor)?)),
        };
        let mut out = Writer::default();
        let g = &self.geometry;
        out.array(&g.area);
        for field in [&g.points, &g.normal, &g.tangent_x, &g.tangent_y] {
            out.array(field);
        }
        for field in &g.mean_frame {
            out.array(field);
        }
        out.option(g.means.as_ref(), |out, means| {
            out.counts(&means.start);
            out.counts(&means.column);
            out.array(&means.share);
        });
        out.array(self.influence.normal());
        for block in self.influence.along() {
            out.option(block, Writer::array);
        }
        out.count(self.motions.len());
        for free in &self.motions {
            out.text(&free.name);
            out.option(free.component, Writer::count);
            out.array(&free.motion.tangential_x);
            out.array(&free.motion.tangential_y);
            out.array(&free.motion.opening);
        }
        for table in [&self.friction, &self.loads] {
            put_table(&mut out, table);
        }
        put_parts(&mut out, self.magnetic.as_ref());
        out.array(&self.sliding_direction);
        out.array(&self.reference_point);
        out.option(self.standstill_speed, |out, speed| out.array(&[speed]));
        out.count(g.windows.len());
        for window in &g.windows {
            out.counts(&[window.start, window.nx, window.ny]);
        }
        out.option(self.interface.limit.as_ref(), |out, limit| out.array(limit));
        out.option(self.interface.shear.as_ref(), |out, shear| out.array(shear));
        out.option(self.interface.rough.as_ref(), |out, law| {
            let (floor, level, opening, last) = law.parts();
            out.array(&[floor, last]);
            out.array(level);
            out.array(opening);
        });
        out.option(bodies, |out, (bodies, matrix)| {
            out.array(&matrix.columns());
            put_table(out, &bodies.loads);
            put_parts(out, bodies.magnetic.as_ref());
        });
        out.option(magnet, |out, (magnet, faces)| {
            put_circuit(out, &magnet.circuit);
            put_table(out, &magnet.factor);
            for work in faces.works() {
                out.array(work);
            }
            let along = faces.along().filter(|_| bodies.is_some());
            for face in [faces.normal(), along] {
                out.option(face, |out, face| out.array(&face.columns()));
            }
        });
        out.option(self.velocity, |out, velocity| out.array(&[velocity]));
        Ok(out.finish(MARK, VERSION))
    }

    /// The contact that [`Prepared::to_bytes`] wrote.
    ///
    /// One of version 7 states no velocity of its own. One of version 6 has no magnet whose pull follows the gap either,
    /// one of version 5 takes no steps with a shift, one of version 4 has no layer that yields, one of an earlier version
    /// no hardness and no rough layer. One of version 2 does not know whether its bodies go on beyond their points, and
    /// takes it that they end there.
    ///
    /// # Errors
    /// Bytes that are none, of another version, cut short, changed, or that do not fit together.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let (version, mut body) = Reader::open_any(bytes, MARK, &KNOWN)?;
        let area = body.array()?;
        let mut geometry = Geometry {
            points: body.array()?,
            normal: body.array()?,
            tangent_x: body.array()?,
            tangent_y: body.array()?,
            mean_frame: [body.array()?, body.array()?, body.array()?],
            means: body.option(|body| -> Result<Means, Error> {
                Ok(Means {
                    start: body.counts()?,
                    column: body.counts()?,
                    share: body.array()?,
                })
            })?,
            windows: Vec::new(),
            area,
        };
        let normal = body.array()?;
        let along = [body.option(Reader::array)?, body.option(Reader::array)?];
        let influence = Influence::from_columns(geometry.points(), normal, along)?;
        let count = body.count()?;
        let motions: Result<Vec<NamedMotion>, Error> =
            (0..count).map(|_| motion(&mut body)).collect();
        let friction = table(&mut body)?;
        let loads = table(&mut body)?;
        let magnetic = parts(&mut body)?;
        let sliding_direction = body.numbers()?;
        let reference_point = body.numbers()?;
        let standstill_speed = body.option(Reader::array)?.and_then(|v| v.first().copied());
        if version != WITHOUT_WINDOWS {
            let count = body.count()?;
            let windows: Result<Vec<Window>, Damaged> =
                (0..count).map(|_| window(&mut body)).collect();
            geometry.windows = windows?;
        }
        let mut interface = Interface::default();
        if version >= WITHOUT_SHEAR {
            interface.limit = body.option(Reader::array)?;
            if version >= WITHOUT_TANGENTS {
                interface.shear = body.option(Reader::array)?;
            }
            interface.rough = body.option(law)?;
        }
        let motions = motions?;
        let mut bodies = None;
        if version > WITHOUT_TANGENTS {
            bodies = body.option(|body| tangents(body, geometry.points()))?;
        }
        let (mut magnet, mut pulled) = (None, None);
        if version > WITHOUT_MAGNETS {
            let sizes = (geometry.points(), motions.len());
            let own = body.option(|body| attracted(body, sizes))?;
            if let Some((following, pull, along)) = own {
                (magnet, pulled) = (Some(following), Some(pull));
                if let Some(bodies) = &mut bodies {
                    bodies.pulled = along;
                }
            }
        }
        let mut velocity = None;
        if version > WITHOUT_VELOCITY {
            velocity = body.option(Reader::array)?.and_then(|v| v.first().copied());
        }
        body.close()?;
        let prepared = Self {
            influence: Arc::new(influence),
            bodies,
            geometry,
            motions,
            friction,
            loads,
            magnetic,
            magnet,
            pulled,
            sliding_direction,
            reference_point,
            standstill_speed,
            velocity,
            interface,
        };
        prepared.check()?;
        Ok(prepared)
    }
}

fn put_table(out: &mut Writer, table: &Table) {
    out.array(table.speed());
    table.rows().iter().for_each(|row| out.array(row));
}

fn put_parts(out: &mut Writer, parts: Option<&[Vec<f64>; 2]>) {
    out.option(parts, |out, parts| {
        for part in parts {
            out.array(part);
        }
    });
}

fn parts(body: &mut Reader<'_>) -> Result<Option<[Vec<f64>; 2]>, Damaged> {
    body.option(|body| Ok([body.array()?, body.array()?]))
}

fn tangents(body: &mut Reader<'_>, points: usize) -> Result<Bodies, Error> {
    let matrix = CoupledMatrix::from_columns(points, &body.array()?)?;
    Ok(Bodies {
        pair: OnDemand::formed(matrix),
        loads: table(body)?,
        magnetic: parts(body)?,
        pulled: None,
    })
}

fn put_circuit(out: &mut Writer, circuit: &Circuit) {
    let poles = circuit.poles();
    for curve in circuit.iron().points() {
        out.array(curve);
    }
    out.counts(&poles.points);
    out.array(&[
        circuit.ampere_turns(),
        poles.iron_share,
        poles.length,
        poles.non_magnetic_gap,
        circuit.leakage(),
    ]);
    for limb in circuit.limbs() {
        out.option(limb, |out, limb| out.array(&[limb.length, limb.area]));
    }
    out.array(&poles.area);
}

fn circuit(body: &mut Reader<'_>) -> Result<Circuit, Error> {
    let iron = Iron::new(&body.array()?, &body.array()?)?;
    let points = body.counts()?;
    let [ampere_turns, iron_share, length, non_magnetic_gap, leakage] = body.numbers()?;
    let mut limbs = [None; 2];
    for limb in &mut limbs {
        *limb = body.option(|body| -> Result<Limb, Damaged> {
            let [length, area] = body.numbers()?;
            Ok(Limb { length, area })
        })?;
    }
    let poles = Poles {
        area: body.array()?,
        points,
        iron_share,
        length,
        non_magnetic_gap,
    };
    Circuit::new(iron, ampere_turns, poles, limbs, leakage)
}

/// A magnet, what its pull does, and what it moves along the tangents.
type AttractedParts = (MagnetOverSpeed, Pulled, Option<OnDemand<Face>>);

fn attracted(
    body: &mut Reader<'_>,
    (points, motions): (usize, usize),
) -> Result<AttractedParts, Error> {
    let magnet = MagnetOverSpeed {
        circuit: circuit(body)?,
        factor: table(body)?,
    };
    let works: Result<Vec<Vec<f64>>, Damaged> = (0..motions).map(|_| body.array()).collect();
    let works = works?;
    let mut face = |observed: &[Component]| {
        body.option(|body| -> Result<OnDemand<Face>, Error> {
            let columns = body.array()?;
            Ok(OnDemand::formed(Face::from_columns(
                points, observed, &columns,
            )?))
        })
    };
    let (face, along) = (face(&Face::NORMAL)?, face(&Face::ALONG)?);
    Ok((magnet, Pulled { face, works }, along))
}

fn table(body: &mut Reader<'_>) -> Result<Table, Error> {
    let speed = body.array()?;
    let rows: Result<Vec<Vec<f64>>, Damaged> = speed.iter().map(|_| body.array()).collect();
    Table::new(speed, rows?)
}

fn law(body: &mut Reader<'_>) -> Result<RoughLaw, Error> {
    let [floor, last] = body.numbers()?;
    RoughLaw::of_parts(floor, body.array()?, body.array()?, last)
}

fn window(body: &mut Reader<'_>) -> Result<Window, Damaged> {
    match body.counts()?[..] {
        [start, nx, ny] => Ok(Window { start, nx, ny }),
        _ => Err(Damaged("a grid is not three counts")),
    }
}

fn motion(body: &mut Reader<'_>) -> Result<NamedMotion, Error> {
    let name = body.text()?;
    let component = body.option(Reader::word)?.map(|c| c as usize);
    if component.is_some_and(|c| c > 5) {
        return Err(Error::Stored("a motion has no such component"));
    }
    Ok(NamedMotion {
        name,
        component,
        motion: RigidMotion {
            tangential_x: body.array()?,
            tangential_y: body.array()?,
            opening: body.array()?,
            work: 0.0,
        },
    })
}
