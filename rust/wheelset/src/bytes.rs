// SPDX-License-Identifier: MIT OR Apache-2.0
//! A prepared wheelset as bytes: an [`mtb_contact::record`] marked `MTBW`.

use std::sync::Arc;

use mtb_contact::friction::{Friction, Memory, SlipLaw};
use mtb_contact::record::{Damaged, Reader, Writer};
use mtb_contact::temperature::TemperatureLaw;
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_geometry::{Profile, Slices, WheelOnRail};
use mtb_heat::Conductor;

use crate::error::Error;
use crate::friction::{RailFriction, WheelFriction};
use crate::track::RailSprings;
use crate::wheelset::{Sides, Wheelset};

const MARK: [u8; 4] = *b"MTBW";
const VERSION: u32 = 9;

impl Wheelset {
    /// The wheelset as bytes, for a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer::default();
        write_pair(&mut out, &self.pair);
        out.option(self.right.as_ref(), write_pair);
        out.count(match self.sides {
            Sides::Left => 0,
            Sides::Right => 1,
            Sides::Both => 2,
        });
        out.array(&[self.force, self.approach, self.layer]);
        out.array(&self.spacing);
        for body in [self.bodies.lower, self.bodies.upper] {
            out.option(body, |out, m| {
                out.array(&[m.shear_modulus, m.poisson_ratio]);
            });
        }
        write_friction(&mut out, &self.friction);
        out.option(self.right_friction.as_ref(), write_friction);
        out.array(&self.reference_point);
        out.option(self.standstill_speed, |out, speed| out.array(&[speed]));
        out.option(self.springs, |out, springs| {
            out.array(&springs.stiffness);
            out.array(&springs.force);
        });
        out.count(usize::from(self.conformal));
        out.count(usize::from(self.second_order));
        out.finish(MARK, VERSION)
    }

    /// The wheelset that [`Wheelset::to_bytes`] wrote.
    ///
    /// # Errors
    /// Bytes that are none, of another version, cut short, changed, or that hold what no wheelset can be.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let mut body = Reader::open(bytes, MARK, VERSION)?;
        let pair = read_pair(&mut body)?;
        let right = body.option(read_pair)?;
        let sides = match body.word()? {
            0 => Sides::Left,
            1 => Sides::Right,
            2 => Sides::Both,
            _ => return Err(Error::Stored("it has no such wheels")),
        };
        let [force, approach, layer] = body.numbers()?;
        let spacing = body.numbers()?;
        let mut material = || {
            body.option(|body| -> Result<Material, Error> {
                let [shear_modulus, poisson_ratio] = body.numbers()?;
                Ok(Material::new(shear_modulus, poisson_ratio)?)
            })
        };
        let bodies = Pair {
            lower: material()?,
            upper: material()?,
        };
        let wheelset = Self {
            pair,
            right,
            sides,
            force,
            approach,
            spacing,
            bodies,
            friction: read_friction(&mut body)?,
            right_friction: body.option(read_friction)?,
            layer,
            reference_point: body.numbers()?,
            standstill_speed: body
                .option(Reader::numbers::<1>)?
                .map(|[standstill_speed]| standstill_speed),
            springs: body.option(|body| -> Result<_, Error> {
                Ok(RailSprings {
                    stiffness: body.numbers()?,
                    force: body.numbers()?,
                })
            })?,
            conformal: read_flag(&mut body, "its patches lie on no such ground")?,
            second_order: read_flag(&mut body, "its slip is of no such order")?,
        };
        body.close()?;
        wheelset.check()?;
        Ok(wheelset)
    }
}

/// Yes or no; `other` says what is wrong with anything else.
fn read_flag(body: &mut Reader<'_>, other: &'static str) -> Result<bool, Error> {
    match body.word()? {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Error::Stored(other)),
    }
}

fn write_pair(out: &mut Writer, pair: &WheelOnRail) {
    out.array(&pair.wheel.to_numbers());
    out.array(&pair.rail.to_numbers());
    out.array(&[
        pair.wheel_radius,
        pair.gauge,
        pair.gauge_depth,
        pair.rail_inclination,
        pair.flange_back,
        pair.tape_circle,
        pair.lateral,
    ]);
    out.option(pair.roller_radius, |out, radius| out.array(&[radius]));
    for slices in [&pair.wheel_slices, &pair.rail_slices] {
        out.option(slices.as_deref(), |out, slices| {
            out.array(&slices.to_numbers());
        });
    }
}

fn read_pair(body: &mut Reader<'_>) -> Result<WheelOnRail, Error> {
    let wheel = Profile::from_numbers(&body.array()?)?;
    let rail = Profile::from_numbers(&body.array()?)?;
    let [
        wheel_radius,
        gauge,
        gauge_depth,
        rail_inclination,
        flange_back,
        tape_circle,
        lateral,
    ] = body.numbers()?;
    let roller_radius = body.option(Reader::numbers::<1>)?.map(|[radius]| radius);
    let mut slices = || {
        body.option(|body| -> Result<_, Error> {
            Ok(Arc::new(Slices::from_numbers(&body.array()?)?))
        })
    };
    let (wheel_slices, rail_slices) = (slices()?, slices()?);
    Ok(WheelOnRail {
        wheel,
        rail,
        wheel_radius,
        roller_radius,
        gauge,
        gauge_depth,
        rail_inclination,
        flange_back,
        tape_circle,
        lateral,
        wheel_slices,
        rail_slices,
    })
}

fn write_friction(out: &mut Writer, friction: &WheelFriction) {
    let law = match friction {
        WheelFriction::Everywhere(law) => law,
        WheelFriction::OnRail(map) => {
            out.count(4);
            for part in map.parts() {
                out.array(part);
            }
            return;
        }
    };
    let with_memory = |out: &mut Writer, memory: &Option<Memory>| {
        out.option(*memory, |out, m| out.array(&[m.distance, m.min_slip]));
    };
    match law {
        Friction::Coulomb(coefficient) => {
            out.count(0);
            out.array(coefficient);
        }
        Friction::StaticKinetic { at_rest, kinetic } => {
            out.count(1);
            out.array(&[*at_rest, *kinetic]);
        }
        Friction::SpeedDependent {
            law:
                SlipLaw::Exponential {
                    at_rest,
                    kinetic,
                    half_slip,
                },
            memory,
        } => {
            out.count(2);
            out.array(&[*at_rest, *kinetic, *half_slip]);
            with_memory(out, memory);
        }
        Friction::SpeedDependent {
            law:
                SlipLaw::Table {
                    slip_speed,
                    coefficient,
                },
            memory,
        } => {
            out.count(3);
            out.array(slip_speed);
            out.array(coefficient);
            with_memory(out, memory);
        }
        Friction::TemperatureDependent(law) => {
            out.count(5);
            for part in law.table() {
                out.array(part);
            }
            for (body, bulk) in law.bodies.iter().zip(law.bulk) {
                out.array(&[
                    body.conductivity(),
                    body.density(),
                    body.specific_heat(),
                    bulk,
                ]);
            }
            with_memory(out, &law.memory);
        }
    }
}

fn read_friction(body: &mut Reader<'_>) -> Result<WheelFriction, Error> {
    let memory = |body: &mut Reader<'_>| {
        body.option(|body| {
            let [distance, min_slip] = body.numbers()?;
            Ok::<_, Damaged>(Memory { distance, min_slip })
        })
    };
    let law = match body.word()? {
        0 => Friction::Coulomb(body.array()?),
        1 => {
            let [at_rest, kinetic] = body.numbers()?;
            Friction::StaticKinetic { at_rest, kinetic }
        }
        2 => {
            let [at_rest, kinetic, half_slip] = body.numbers()?;
            Friction::SpeedDependent {
                law: SlipLaw::Exponential {
                    at_rest,
                    kinetic,
                    half_slip,
                },
                memory: memory(body)?,
            }
        }
        3 => Friction::SpeedDependent {
            law: SlipLaw::Table {
                slip_speed: body.array()?,
                coefficient: body.array()?,
            },
            memory: memory(body)?,
        },
        4 => {
            let map = RailFriction::new(body.array()?, body.array()?, body.array()?)?;
            return Ok(WheelFriction::OnRail(map));
        }
        5 => {
            let (temperature, coefficient) = (body.array()?, body.array()?);
            let sides: [[f64; 4]; 2] = [body.numbers()?, body.numbers()?];
            let conductor = |[conductivity, density, specific_heat, _]: [f64; 4]| {
                Conductor::new(conductivity, density, specific_heat)
            };
            let damaged = |_| Error::Stored("its friction law conducts no heat");
            let bodies = [
                conductor(sides[0]).map_err(damaged)?,
                conductor(sides[1]).map_err(damaged)?,
            ];
            let bulk = sides.map(|[.., bulk]| bulk);
            let memory = memory(body)?;
            let law = TemperatureLaw::new(temperature, coefficient, bodies, bulk, memory);
            Friction::TemperatureDependent(law?)
        }
        _ => return Err(Error::Stored("it has no such friction law")),
    };
    Ok(law.into())
}
