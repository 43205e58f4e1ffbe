// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of shifts and of rolling against differences of solves, and against each other.

use mtb_complementarity::discs::DiscState;
use mtb_contact::friction::{Friction, Memory, SlipLaw};
use mtb_contact::tangential::{
    Bodies, Drive, Earlier, Motion, PatchOperators, PlasticSlip, Plasticity, PlasticityChange,
    Surroundings, TangentialChange, TangentialProblem, TangentialResponse, TangentialSolution,
    TangentialTangent, dissipation, solve,
};
use mtb_contact::temperature::TemperatureLaw;
use mtb_elasticity::Material;
use mtb_elasticity::half_space::Pair;
use mtb_heat::{Conductor, Warming};
use mtb_operator::{Grid, unmonitored};
use proptest::prelude::*;

/// A random contact and what happens to it.
#[allow(clippy::struct_excessive_bools, reason = "what is chosen at random")]
#[derive(Clone, Debug)]
struct Case {
    grid: Grid,
    pressure: Vec<f64>,
    motion: Motion,
    drive: [Drive; 2],
    spin: f64,
    speed: f64,
    friction: Friction,
    layer: f64,
    earlier: Option<Earlier>,
    is_unlike: bool,
    /// Yield stress, hardening and earlier plastic slip of a layer.
    plasticity: Option<(f64, f64, Vec<f64>)>,
    /// Whether rows are inclined.
    is_inclined: bool,
    /// Whether loads act on, less and less, along the way that cells come from.
    creeps: bool,
    /// Whether slip is of second order in the cells.
    is_second_order: bool,
}

/// Pressures are of order one, and so is the shear modulus, over a thousand.
const MODULUS: f64 = 1e3;

struct Random(u64);

impl Random {
    /// From -0.5 to 0.5.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }

    fn field(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| size * self.next()).collect()
    }
}

fn operators(case: &Case) -> PatchOperators {
    let material = |g: f64, nu: f64| Some(Material::new(g, nu).expect("a material"));
    let pair = Pair {
        lower: material(MODULUS, 0.3),
        upper: if case.is_unlike {
            None
        } else {
            material(MODULUS, 0.3)
        },
    };
    let behind =
        |offset: [f64; 2], k: i32| [0, 1].map(|c| offset[c] + [0.06, -0.03][c] * f64::from(k));
    let last = if case.creeps { 6 } else { 1 };
    let tangential = |cell: [f64; 2], offset: [f64; 2]| {
        (0..last).fold([0.0; 3], |sum, k| {
            let own = pair.tangential(cell, behind(offset, k));
            [0, 1, 2].map(|c| sum[c] + 0.5_f64.powi(k) * own[c])
        })
    };
    let pushed = |cell: [f64; 2], offset: [f64; 2]| {
        (0..last).fold([0.0; 2], |sum, k| {
            let own = pair.by_pressure(cell, behind(offset, k));
            [0, 1].map(|c| sum[c] + 0.5_f64.powi(k) * own[c])
        })
    };
    let inclination = |y: f64| 0.5 * y - 0.3;
    let bodies = Bodies {
        tangential: &tangential,
        by_pressure: if case.is_unlike { Some(&pushed) } else { None },
        layer: case.layer,
        is_mirrored: !case.creeps,
        inclination: if case.is_inclined {
            Some(&inclination)
        } else {
            None
        },
        across: None,
    };
    let of = |motion| PatchOperators::new(&bodies, case.grid, motion).expect("operators");
    match case.motion {
        motion if !case.is_second_order => of(motion),
        Motion::Transient { step } => {
            let rolling = of(Motion::Shift).rolling_by(&bodies, step);
            rolling.expect("a step").of_second_order()
        }
        motion => of(motion).of_second_order(),
    }
}

impl Case {
    fn problem(&self) -> TangentialProblem<'_> {
        TangentialProblem {
            around: None,
            pressure: &self.pressure,
            origin: [-0.5 * (self.grid.nx - 1) as f64 * self.grid.dx + 0.03, -0.6],
            drive: self.drive,
            rigid_slip: None,
            spin: self.spin,
            speed: self.speed,
            friction: &self.friction,
            plasticity: self
                .plasticity
                .as_ref()
                .map(|(yield_stress, hardening, earlier)| Plasticity {
                    yield_stress: *yield_stress,
                    hardening: *hardening,
                    earlier,
                }),
            earlier: self.earlier.as_ref(),
            start: None,
            tolerance: 1e-13,
        }
    }

    /// The patch with a cell more on all sides.
    fn around(&self) -> Surroundings {
        Surroundings {
            shape: [self.grid.nx + 2, self.grid.ny + 2],
            first: [1, 1],
        }
    }

    fn solved(&self, operators: &PatchOperators) -> Option<TangentialSolution> {
        solve(operators, &self.problem(), &unmonitored)
            .ok()
            .filter(|s| s.history.last() <= Some(&1e-11))
    }

    fn changed(&self, change: &TangentialChange, share: f64) -> Self {
        let mut other = self.clone();
        let add = |to: &mut [f64], by: &[f64]| {
            for (to, by) in to.iter_mut().zip(by) {
                *to += share * by;
            }
        };
        for (p, d) in other.pressure.iter_mut().zip(&change.pressure) {
            if *p > 0.0 {
                *p += share * d;
            }
        }
        for (drive, d) in other.drive.iter_mut().zip(change.drive) {
            *drive = match *drive {
                Drive::Slip(v) => Drive::Slip(v + share * d),
                Drive::Force(v) => Drive::Force(v + share * d),
            };
        }
        other.spin += share * change.spin;
        other.layer += share * change.layer;
        if let Some((yield_stress, hardening, earlier)) = &mut other.plasticity {
            *yield_stress += share * change.plasticity.yield_stress;
            *hardening += share * change.plasticity.hardening;
            add(earlier, &change.plasticity.earlier);
        }
        if let Some(earlier) = &mut other.earlier {
            add(&mut earlier.traction, &change.earlier.traction);
            add(&mut earlier.pressure, &change.earlier.pressure);
            add(&mut earlier.coefficient, &change.earlier.coefficient);
        }
        match &mut other.friction {
            Friction::Coulomb(mu) => add(mu, &change.coefficient),
            Friction::StaticKinetic { .. } => {}
            Friction::TemperatureDependent(law) => {
                let mut by = change.law.iter().map(|d| share * d);
                let [mut temperature, mut coefficient] = law.table().map(<[f64]>::to_vec);
                for own in coefficient.iter_mut().chain(&mut temperature) {
                    *own += by.next().unwrap_or(0.0);
                }
                let mut next = || by.next().unwrap_or(0.0);
                let bulk = law.bulk.map(|bulk| bulk + next());
                let bodies = law
                    .bodies
                    .map(|body| of_effusivity(body.effusivity() + next()));
                let memory = law.memory.map(|memory| Memory {
                    distance: memory.distance + next(),
                    min_slip: memory.min_slip + next(),
                });
                other.speed *= 1.0 + next();
                *law = TemperatureLaw::new(temperature, coefficient, bodies, bulk, memory)
                    .expect("a law");
            }
            Friction::SpeedDependent { law, memory } => {
                let mut parameters: Vec<&mut f64> = match law {
                    SlipLaw::Exponential {
                        at_rest,
                        kinetic,
                        half_slip,
                    } => vec![at_rest, kinetic, half_slip],
                    SlipLaw::Table {
                        slip_speed,
                        coefficient,
                    } => coefficient.iter_mut().chain(slip_speed).collect(),
                };
                if let Some(Memory { distance, min_slip }) = memory {
                    parameters.extend([distance, min_slip]);
                }
                for (parameter, d) in parameters.into_iter().zip(&change.law) {
                    *parameter += share * d;
                }
                other.speed *= 1.0 + share * change.law.last().copied().unwrap_or(0.0);
            }
        }
        other
    }
}

fn of_effusivity(effusivity: f64) -> Conductor {
    Conductor::new(effusivity, effusivity, 1.0).expect("a conductor")
}

/// The last laws, in steady rolling: friction that follows the temperature, and Coulomb's on bodies that creep.
const HEATED: usize = 8;
const CREEPING: usize = 9;

fn case(kind: usize, law: usize, seed: u64) -> Case {
    let kind = if law >= HEATED {
        kind / 3 * 3 + 2
    } else {
        kind
    };
    let mut random = Random(seed | 1);
    let (nx, ny) = (
        11 + (8.0 * (random.next() + 0.5)) as usize,
        9 + (8.0 * (random.next() + 0.5)) as usize,
    );
    let n = nx * ny;
    let grid = Grid {
        nx,
        ny,
        dx: 0.1,
        dy: 0.12,
    };
    let pressure: Vec<f64> = (0..n)
        .map(|k| {
            let x = 2.0 * ((k % nx) as f64 + 0.5) / nx as f64 - 1.0;
            let y = 2.0 * ((k / nx) as f64 + 0.5) / ny as f64 - 1.0;
            (1.0 - x * x - 0.9 * y * y).max(0.0).sqrt() * (1.0 + 0.2 * random.next())
        })
        .collect();
    let is_inclined = (5..HEATED).contains(&law) && (seed >> 12).is_multiple_of(2);
    let step = match (seed >> 8) % 3 {
        1 if is_inclined => [-0.06, 0.0],
        2 if is_inclined => [2.0 * grid.dx, 0.0],
        0 => [grid.dx, 0.0],
        1 => [-0.06, 0.09],
        _ => [0.0, 0.7 * grid.dy],
    };
    let is_second_order = (seed >> 24).is_multiple_of(2);
    let whole = match (seed >> 8) % 3 {
        2 if !is_inclined => [0.0, grid.dy],
        k => [if k == 0 { grid.dx } else { -grid.dx }, 0.0],
    };
    let motion = match kind % 3 {
        2 if is_second_order => Motion::Steady { step: whole },
        0 => Motion::Shift,
        1 => Motion::Transient { step },
        _ => Motion::Steady { step },
    };
    let is_steady = matches!(motion, Motion::Steady { .. });
    let total: f64 = pressure.iter().sum::<f64>() * grid.cell_area();
    let size = if kind.is_multiple_of(3) { 6e-4 } else { 1e-3 };
    let drive = [0, 1].map(|c| {
        if kind / 3 == c + 1 {
            Drive::Force(0.2 * total * (0.3 + random.next().abs()))
        } else {
            Drive::Slip(size * random.next())
        }
    });
    let falling = SlipLaw::Exponential {
        at_rest: 0.34,
        kinetic: 0.3,
        half_slip: 1.0,
    };
    let memory = Some(Memory {
        distance: 0.2,
        min_slip: 0.02,
    });
    let friction = match law {
        HEATED => Friction::TemperatureDependent(
            TemperatureLaw::new(
                vec![0.0, 0.4, 1.5],
                vec![0.35, 0.3, 0.2],
                [0.01, 0.02].map(of_effusivity),
                [0.1, 0.05],
                (seed >> 20).is_multiple_of(2).then_some(Memory {
                    distance: 0.05,
                    min_slip: 0.02,
                }),
            )
            .expect("a law"),
        ),
        0 | 5.. => Friction::Coulomb((0..n).map(|_| 0.3 * (1.0 + 0.2 * random.next())).collect()),
        1 => Friction::StaticKinetic {
            at_rest: 0.31,
            kinetic: 0.3,
        },
        2 => Friction::SpeedDependent {
            law: falling,
            memory: None,
        },
        3 => Friction::SpeedDependent {
            law: falling,
            memory,
        },
        4 => Friction::SpeedDependent {
            law: SlipLaw::Table {
                slip_speed: vec![0.0, 0.3, 1.0, 4.0],
                coefficient: vec![0.33, 0.32, 0.31, 0.3],
            },
            memory,
        },
    };
    let is_unlike = random.next() > 0.0 && !is_inclined;
    let layer = if random.next() > 0.0 { 2e-4 } else { 0.0 };
    let earlier = (!is_steady && random.next() > -0.2).then(|| Earlier {
        traction: (0..2 * n)
            .map(|k| 0.2 * pressure[k % n] * random.next())
            .collect(),
        pressure: pressure.iter().map(|p| 0.9 * p).collect(),
        coefficient: (0..n).map(|_| 0.32 + 0.01 * random.next()).collect(),
    });
    let spin = size * random.next();
    let plasticity = (6..HEATED).contains(&law).then(|| {
        let hardening = [0.0, 40.0, 400.0][(seed >> 16) as usize % 3];
        let slip = (0..n).map(|_| 2e-4 * (random.next() + 0.5)).collect();
        (
            0.2,
            hardening,
            if earlier.is_some() { slip } else { Vec::new() },
        )
    });
    Case {
        grid,
        pressure,
        motion,
        drive,
        spin,
        speed: 1e3,
        friction,
        layer,
        earlier,
        is_unlike,
        plasticity,
        is_inclined,
        creeps: law == CREEPING,
        is_second_order,
    }
}

fn change(case: &Case, tangent: &TangentialTangent<'_>, seed: u64) -> TangentialChange {
    let mut random = Random(seed.wrapping_mul(77) | 1);
    let n = case.grid.points();
    let mut change = tangent.no_change();
    change.pressure = random.field(n, 0.1);
    change.drive = case.drive.map(|d| match d {
        Drive::Slip(_) => 1e-4 * random.next(),
        Drive::Force(f) => 0.1 * f * random.next(),
    });
    change.spin = 1e-4 * random.next();
    change.coefficient = match case.friction {
        Friction::Coulomb(_) => random.field(n, 0.03),
        _ => change.coefficient,
    };
    if let Friction::SpeedDependent { law, memory } = &case.friction {
        change.law = match law {
            SlipLaw::Exponential { .. } => vec![
                0.03 * random.next(),
                0.03 * random.next(),
                0.3 * random.next(),
            ],
            // the first slip speed is 0, and stays
            SlipLaw::Table { .. } => {
                let moved = random.field(7, 0.03);
                [&moved[..4], &[0.0], &moved[4..]].concat()
            }
        };
        if memory.is_some() {
            change
                .law
                .extend([0.05 * random.next(), 0.005 * random.next()]);
        }
        change.law.push(0.1 * random.next());
    }
    if let Friction::TemperatureDependent(law) = &case.friction {
        change.law = random.field(3, 0.03);
        change.law.extend(random.field(5, 0.03));
        change.law.extend(random.field(2, 2e-3));
        if law.memory.is_some() {
            change
                .law
                .extend([0.01 * random.next(), 0.005 * random.next()]);
        }
        change.law.push(0.1 * random.next());
    }
    if let Some((_, hardening, earlier)) = &case.plasticity {
        change.plasticity = PlasticityChange {
            yield_stress: 0.02 * random.next(),
            hardening: if *hardening > 0.0 {
                0.1 * hardening * random.next()
            } else {
                0.0
            },
            earlier: random.field(
                case.grid.points(),
                if earlier.is_empty() { 0.0 } else { 1e-5 },
            ),
        };
    }
    change.layer = if case.layer > 0.0 {
        1e-4 * random.next()
    } else {
        0.0
    };
    if case.earlier.is_some() {
        change.earlier = Earlier {
            traction: random.field(2 * n, 0.02),
            pressure: random.field(n, 0.05),
            coefficient: random.field(n, 0.01),
        };
    }
    change
}

/// Between which points of a table the temperatures are.
fn points_of_table(case: &Case, law: &TemperatureLaw, heat: &[f64]) -> Vec<usize> {
    let Motion::Steady {
        step: [along, across],
    } = case.motion
    else {
        return Vec::new();
    };
    let (around, grid) = (case.around(), case.grid);
    let warming = Warming::new(
        around.shape,
        [grid.dx, grid.dy],
        across.atan2(along),
        case.speed,
        law.bodies,
    );
    let power: Vec<f64> = heat.iter().map(|heat| case.speed * heat).collect();
    let all: Vec<usize> = (0..heat.len()).collect();
    let rise = warming.expect("a grid").rise(&power, &all);
    let [temperature, _] = law.table();
    let above = |rise: &f64| {
        temperature
            .iter()
            .filter(|t| **t < law.cold() + rise)
            .count()
    };
    rise.iter().map(above).collect()
}

/// Which branch of the law each point is on, and of its memory; how it yields.
fn branches(case: &Case, made: &PatchOperators, solution: &TangentialSolution) -> Vec<usize> {
    let (n, slip) = (case.grid.points(), &solution.slip);
    if let Some(plastic) = &solution.plastic {
        let how = |(share, yields): (&f64, &bool)| usize::from(*share > 0.0) + usize::from(*yields);
        return plastic.share.iter().zip(&plastic.yields).map(how).collect();
    }
    let mut kinks = Vec::new();
    let mut places = Vec::new();
    match &case.friction {
        Friction::SpeedDependent { law, memory } => {
            kinks.extend(memory.iter().map(|m| m.min_slip));
            if let SlipLaw::Table { slip_speed, .. } = law {
                kinks.extend(slip_speed);
            }
        }
        Friction::TemperatureDependent(law) => {
            kinks.extend(law.memory.iter().map(|m| m.min_slip));
            let heat = dissipation(made, &case.problem(), solution, case.around());
            places = points_of_table(case, law, &heat);
        }
        _ => return Vec::new(),
    }
    let speed = |i: usize| case.speed * slip[i].hypot(slip[n + i]);
    places.extend((0..n).map(|i| kinks.iter().filter(|kink| **kink < speed(i)).count()));
    places
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn size(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// All that is found, in units in which it is of like size, of the cells in contact.
fn listed(case: &Case, parts: &[&[f64]; 7], states: &[DiscState]) -> Vec<f64> {
    let n = case.grid.points();
    let [traction, slip, coefficient, drive, heat, share, accumulated] = *parts;
    let mut all = traction.to_vec();
    all.extend((0..2 * n).map(|k| match states[k % n] {
        DiscState::Rim => 100.0 * slip[k],
        _ => 0.0,
    }));
    let loaded = (0..n).filter(|k| case.pressure[*k] > 0.0);
    all.extend(loaded.map(|k| coefficient[k]));
    all.extend(drive.iter().map(|d| 1e3 * d));
    all.extend(heat.iter().map(|h| 300.0 * h));
    all.extend(share);
    all.extend(accumulated.iter().map(|u| 1e3 * u));
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn derivatives_are_limits_of_differences_and_adjoints_their_transposes(
        kind in 0..9_usize, law in 0..=CREEPING, seed in any::<u64>(),
    ) {
        let case = case(kind, law, seed);
        let made = operators(&case);
        let Some(solution) = case.solved(&made) else {
            return Ok(()); // friction that falls may leave no solution that is found so exactly
        };
        let problem = case.problem();
        let mut tangent = TangentialTangent::new(&made, &problem, solution.state(), Some(case.around())).expect("a solution");
        // of its own operators it has its own slip and heat
        let (slip, heat) = tangent.with_operators(&made);
        let own: Vec<f64> = (slip.iter().zip(&solution.slip).enumerate())
            .filter(|(k, _)| solution.state[k % case.grid.points()] == DiscState::Rim)
            .map(|(_, (a, b))| a - b)
            .collect();
        // of second order it is that at the faces
        prop_assert!(case.is_second_order || size(&own) <= 1e-9 * size(&solution.slip), "{} {}", size(&own), size(&solution.slip));
        prop_assert_eq!(heat, dissipation(&made, &problem, &solution, case.around()));
        let change = change(&case, &tangent, seed);
        let derivative = tangent.forward(&change, &unmonitored).expect("a derivative");
        let n = case.grid.points();
        let mut random = Random(seed.wrapping_mul(31) | 1);
        let plain = change;
        let mut change = plain.clone();
        change.rigid_slip = random.field(2 * n, 1e-4);
        change.rigid_slip_behind = random.field(2 * n, 1e-4);
        let found = tangent.forward(&change, &unmonitored).expect("a derivative");
        let weights = TangentialResponse {
            traction: random.field(2 * n, 1.0),
            slip: random.field(2 * n, 100.0),
            coefficient: random.field(n, 1.0),
            drive: [1e3 * random.next(), 1e3 * random.next()],
            dissipation: random.field((case.grid.nx + 2) * (case.grid.ny + 2), 1e3),
            plastic_share: random.field(found.plastic_share.len(), 1.0),
            accumulated: random.field(found.accumulated.len(), 1e3),
        };
        let gradient = tangent.adjoint(&weights, &unmonitored).expect("a gradient");
        let parts = [
            [dot(&weights.traction, &found.traction), -dot(&gradient.pressure, &change.pressure)],
            [dot(&weights.slip, &found.slip), -dot(&gradient.drive, &change.drive)],
            [dot(&weights.coefficient, &found.coefficient), -gradient.spin * change.spin],
            [dot(&weights.drive, &found.drive), -dot(&gradient.coefficient, &change.coefficient)],
            [dot(&weights.dissipation, &found.dissipation), -dot(&gradient.rigid_slip, &change.rigid_slip)],
            [-dot(&gradient.rigid_slip_behind, &change.rigid_slip_behind), 0.0],
            [-dot(&gradient.law, &change.law), -gradient.layer * change.layer],
            [dot(&weights.plastic_share, &found.plastic_share), dot(&weights.accumulated, &found.accumulated)],
            [
                -gradient.plasticity.yield_stress * change.plasticity.yield_stress
                    - gradient.plasticity.hardening * change.plasticity.hardening,
                -dot(&gradient.plasticity.earlier, &change.plasticity.earlier),
            ],
            [
                -dot(&gradient.earlier.traction, &change.earlier.traction),
                -dot(&gradient.earlier.pressure, &change.earlier.pressure)
                    - dot(&gradient.earlier.coefficient, &change.earlier.coefficient),
            ],
        ].concat();
        let whole: f64 = parts.iter().map(|p| p.abs()).sum();
        prop_assert!(parts.iter().sum::<f64>().abs() < 1e-10 * whole, "{:?} {:?}", parts, case.motion);

        let listed = |case: &Case, s: &TangentialSolution, heat: &[f64]| {
            let none = Vec::new();
            let (share, slip) = s.plastic.as_ref().map_or((&none, &none), |p| (&p.share, &p.accumulated));
            listed(case, &[&s.traction, &s.slip, &s.coefficient, &s.drive, heat, share, slip], &solution.state)
        };
        let at = |share: f64| -> Option<Vec<f64>> {
            let other = case.changed(&plain, share);
            let again = (plain.layer != 0.0).then(|| operators(&other));
            let made = again.as_ref().unwrap_or(&made);
            let s = other.solved(made)?;
            let is_same = branches(&other, made, &s) == branches(&case, made, &solution);
            (s.state == solution.state && is_same)
                .then(|| listed(&case, &s, &dissipation(made, &other.problem(), &s, case.around())))
        };
        let slope = |h: f64| -> Option<Vec<f64>> {
            let (a, b) = (at(h)?, at(-h)?);
            Some(a.iter().zip(b).map(|(a, b)| (a - b) / (2.0 * h)).collect())
        };
        let pair = slope(2e-4).and_then(|coarse| Some((coarse, slope(1e-4)?)));
        let Some((coarse, fine)) = pair else { return Ok(()) };
        let expected: Vec<f64> = coarse.iter().zip(&fine).map(|(c, f)| (4.0 * f - c) / 3.0).collect();
        let found = TangentialSolution {
            traction: derivative.traction,
            slip: derivative.slip,
            coefficient: derivative.coefficient,
            drive: derivative.drive,
            plastic: solution.plastic.clone().map(|plastic| PlasticSlip {
                share: derivative.plastic_share,
                accumulated: derivative.accumulated,
                ..plastic
            }),
            ..solution.clone()
        };
        let found = listed(&case, &found, &derivative.dissipation);
        let wrong: Vec<f64> = expected.iter().zip(&found).map(|(a, b)| a - b).collect();
        let error = size(&wrong) / size(&expected);
        prop_assert!(error < 1e-6, "{error}");
    }
}
