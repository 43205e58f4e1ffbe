// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of a solved tangential problem by everything that was given, with its points in stick, in slip and out
//! of contact held as they are.
//!
//! On a regular grid the transpose of a convolution is the same one seen from the other end, so that the transposed
//! problem has the operators of the problem itself, on fields that are turned around.

use std::borrow::Cow;

use mtb_complementarity::discs::{
    DependentRadius, DiscChange, DiscProblem, DiscResponse, DiscTangent, Preconditioner, Radius,
    transposed,
};
use mtb_operator::krylov::dot;
use mtb_operator::{Kernel, LinearOperator, Monitor};

use super::bound::SlipBound;
use super::change::{PlasticityChange, TangentialChange, TangentialResponse, TangentialState};
use super::dissipation::{Surroundings, heat_of, slip_at_faces};
use super::faces::{
    AtFaces, Faces, LedRadius, OnCells, OnCellsBack, OnCellsInverse, OnCellsInverseBack,
};
use super::given::{carried, image_at_faces, offset, rigid_slip};
use super::heated::Heated;
use super::operators::{Motion, PatchOperators};
use super::plastic::{YieldFound, YieldGiven, Yielding};
use super::problem::{Drive, Earlier, TangentialProblem};
use super::slip::SlipOperator;
use super::solve::Cascade;
use crate::Error;
use crate::error::{check, check_number};
use crate::friction::Friction;
use crate::inclination::Turn;

/// The derivatives of one solution.
pub struct TangentialTangent<'a> {
    pub(super) operators: &'a PatchOperators,
    pub(super) problem: &'a TangentialProblem<'a>,
    pub(super) state: TangentialState<'a>,
    pub(super) around: Option<Surroundings>,
    /// Slip (2n) over the steps that end at the cells.
    pub(super) slip_at_faces: Cow<'a, [f64]>,
    /// Products with the slip operator, or its transpose, so far.
    pub products: usize,
    /// Applications of the preconditioner so far.
    pub preconditionings: usize,
}

impl<'a> TangentialTangent<'a> {
    /// At a solution of a problem; with the dissipation `around`, which is told in any case where friction follows the
    /// temperature.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], and [`Error::NoTemperature`].
    pub fn new(
        operators: &'a PatchOperators,
        problem: &'a TangentialProblem<'a>,
        state: TangentialState<'a>,
        around: Option<Surroundings>,
    ) -> Result<Self, Error> {
        let around = match problem.friction {
            // what the coefficients follow
            Friction::TemperatureDependent(law) => {
                Some(Heated::new(operators, problem, law, around)?.around)
            }
            _ => around,
        };
        let n = operators.grid().points();
        check("pressure", problem.pressure, n)?;
        check("traction", state.traction, 2 * n)?;
        check("slip", state.slip, 2 * n)?;
        check("coefficient", state.coefficient, n)?;
        if let Some(earlier) = problem.earlier {
            check("earlier traction", &earlier.traction, 2 * n)?;
            check("earlier pressure", &earlier.pressure, n)?;
            check("earlier coefficient", &earlier.coefficient, n)?;
        }
        Ok(Self {
            slip_at_faces: slip_at_faces(operators, problem, &state),
            operators,
            problem,
            state,
            around,
            products: 0,
            preconditionings: 0,
        })
    }

    /// No change.
    pub fn no_change(&self) -> TangentialChange {
        let n = self.operators.grid().points();
        TangentialChange {
            pressure: vec![0.0; n],
            drive: [0.0; 2],
            spin: 0.0,
            rigid_slip: vec![0.0; 2 * n],
            rigid_slip_behind: vec![0.0; 2 * n],
            coefficient: vec![0.0; n],
            law: vec![0.0; self.law_parameters()],
            heat: Vec::new(),
            layer: 0.0,
            stiffness: 0.0,
            length: 0.0,
            earlier: Earlier {
                traction: vec![0.0; 2 * n],
                pressure: vec![0.0; n],
                coefficient: vec![0.0; n],
            },
            brought: vec![0.0; if self.remembers() { n } else { 0 }],
            plasticity: PlasticityChange {
                earlier: vec![0.0; if self.yields() { n } else { 0 }],
                ..PlasticityChange::default()
            },
        }
    }

    /// Whether a layer yields.
    fn yields(&self) -> bool {
        self.problem.plasticity.is_some()
    }

    /// Number of the parameters of a law that follows slip or temperature, with those of its memory and the speed.
    pub fn law_parameters(&self) -> usize {
        self.rest_by_law().len()
    }

    /// Derivatives of the coefficient at rest, as it is out of contact, by the parameters of a law, as
    /// [`TangentialChange::law`] has them.
    pub fn rest_by_law(&self) -> Vec<f64> {
        let (mut slopes, memory) = match self.problem.friction {
            Friction::SpeedDependent { law, memory } => (law.parameters(0.0), *memory),
            Friction::TemperatureDependent(law) => (law.parameters(0.0), law.memory),
            _ => return Vec::new(),
        };
        slopes.resize(slopes.len() + 1 + memory.map_or(0, |_| 2), 0.0);
        slopes
    }

    /// What changes of the solution follow from a change of what is given: one linear solve.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, [`Error::Singular`], and the monitor's interruption.
    pub fn forward(
        &mut self,
        change: &TangentialChange,
        monitor: Monitor<'_>,
    ) -> Result<TangentialResponse, Error> {
        let n = self.operators.grid().points();
        check("change of the pressure", &change.pressure, n)?;
        check("change of the drive", &change.drive, 2)?;
        let numbers = [change.spin, change.layer, change.stiffness, change.length];
        check("change of spin, layer, stiffness and length", &numbers, 4)?;
        check("change of the rigid slip", &change.rigid_slip, 2 * n)?;
        check(
            "change of the rigid slip behind",
            &change.rigid_slip_behind,
            2 * n,
        )?;
        check("change of the coefficient", &change.coefficient, n)?;
        check("change of the law", &change.law, self.law_parameters())?;
        check(
            "change of the earlier traction",
            &change.earlier.traction,
            2 * n,
        )?;
        check(
            "change of the earlier pressure",
            &change.earlier.pressure,
            n,
        )?;
        check(
            "change of the earlier coefficient",
            &change.earlier.coefficient,
            n,
        )?;
        let particles = if change.brought.is_empty() { 0 } else { n };
        check(
            "change of the coefficient that is brought along",
            &change.brought,
            particles,
        )?;
        let plasticity = &change.plasticity;
        let numbers = [plasticity.yield_stress, plasticity.hardening];
        check("change of the yield of a layer", &numbers, 2)?;
        let particles = match plasticity.earlier.len() {
            0 => 0,
            _ => n,
        };
        check(
            "change of the earlier plastic slip",
            &plasticity.earlier,
            particles,
        )?;
        if !change.heat.is_empty() {
            let cells = (self.around).map_or(0, |around| around.shape[0] * around.shape[1]);
            check("change of the dissipation", &change.heat, cells)?;
        }
        match self.following()? {
            Some(following) => self.forward_following(&following, change, monitor),
            None => self.forward_held(change, monitor),
        }
    }

    /// [`TangentialTangent::forward`] of friction that does not follow the temperature, or with its coefficients given.
    pub(super) fn forward_held(
        &mut self,
        change: &TangentialChange,
        monitor: Monitor<'_>,
    ) -> Result<TangentialResponse, Error> {
        let n = self.operators.grid().points();
        let plasticity = &change.plasticity;
        let (problem, state, length) = (self.problem, self.state, self.length());
        let in_contact = |field: &[f64]| self.in_contact(field);
        let pressure = in_contact(&change.pressure);
        let mut offset = self.offset_by(change, &pressure);
        if change.layer != 0.0 {
            add(&mut offset, change.layer, &self.layer_image());
        }
        let (mut response, counts) = self.linear(&mut |place| {
            let on_rim = place.on_rim();
            let mut radius: Vec<f64> = (state.coefficient.iter().zip(&pressure))
                .map(|(mu, p)| mu * p)
                .collect();
            if let Some(law) = place.law {
                let speed = place.speeds();
                let mut own = self.by_earlier(&change.earlier.coefficient);
                if self.remembers() {
                    add(&mut own, 1.0, &change.brought);
                }
                for (column, value) in self.by_law(law, &speed).iter().zip(&change.law) {
                    add(&mut own, *value, column);
                }
                law.friction.pass_on(&speed, &mut own);
                if place.faces.is_some() {
                    let magnitude = place.led(place.discs.magnitude().to_vec());
                    let change = place.led_change(vec![0.0; n], &magnitude, &pressure);
                    let mut by_ties = vec![0.0; n];
                    law.derivative(&magnitude, &change, &mut by_ties);
                    add(&mut radius, 1.0, &by_ties);
                }
                for ((g, own), p) in radius.iter_mut().zip(own).zip(problem.pressure) {
                    *g += own * p.max(0.0);
                }
            } else {
                let coefficient = in_contact(&change.coefficient);
                for ((g, mu), p) in radius.iter_mut().zip(coefficient).zip(problem.pressure) {
                    *g += mu * p.max(0.0);
                }
            }
            let mut of_layer = YieldGiven {
                yield_stress: plasticity.yield_stress,
                hardening: plasticity.hardening,
                past: self.particles_before(&plasticity.earlier),
                magnitude: place.led_change(vec![0.0; n], &on_rim, &pressure),
                ..YieldGiven::none(n)
            };
            if let Some(layer) = place.layer {
                of_layer.friction = std::mem::take(&mut radius);
                radius = layer.follow(&on_rim, &of_layer).radius;
            }
            let forces = (problem.drive.iter().zip(change.drive))
                .filter_map(|(drive, d)| matches!(drive, Drive::Force(_)).then_some(d));
            let mut on_cells = offset.clone();
            if let Some(faces) = place.faces {
                faces.to_cells(&mut on_cells);
                let image = self.image_at_faces();
                faces.add_by_pressure(&self.at_faces(&image), &pressure, &mut on_cells);
                let by = faces.by_constants(state.traction);
                let changes = [change.length, change.stiffness, change.layer];
                for (by, change) in by.iter().zip(changes) {
                    add(&mut on_cells, change, by);
                }
            }
            let given = DiscChange {
                offset: on_cells,
                radius,
                values: forces.collect(),
            };
            let found = place.discs.forward(&given, monitor)?;
            let found = found.ok_or(Error::Singular)?;
            let mut multipliers = found.multipliers.iter();
            let mut drive = change.drive;
            for (drive, given) in drive.iter_mut().zip(problem.drive) {
                if let Drive::Force(_) = given {
                    *drive = multipliers.next().copied().unwrap_or(0.0);
                }
            }
            let coefficient = if place.law.is_some() {
                (0..n)
                    .map(|i| match problem.pressure[i] {
                        p if p > 0.0 => (found.radius[i] - state.coefficient[i] * pressure[i]) / p,
                        _ => 0.0,
                    })
                    .collect()
            } else {
                in_contact(&change.coefficient)
            };
            let yielded = place.layer.map(|layer| {
                of_layer.magnitude = place.led_change(
                    place.discs.magnitude_change(&found.image),
                    &on_rim,
                    &pressure,
                );
                layer.follow(&on_rim, &of_layer)
            });
            let slip = found.image.iter().map(|f| -f / length).collect();
            let (plastic_share, accumulated) = yielded
                .map(|found| (found.share, found.accumulated))
                .unwrap_or_default();
            Ok(TangentialResponse {
                plastic_share,
                accumulated,
                traction: found.field,
                slip: place.led_change(slip, state.slip, &pressure),
                coefficient,
                drive,
                dissipation: Vec::new(),
            })
        })?;
        self.count(counts);
        if let Some(around) = self.around {
            let at_faces = self.operators.has_faces().then(|| {
                for c in 0..2 {
                    if let Drive::Force(_) = problem.drive[c] {
                        let by_drive = length * response.drive[c];
                        (offset[c * n..(c + 1) * n].iter_mut()).for_each(|f| *f -= by_drive);
                    }
                }
                let mut image = vec![0.0; 2 * n];
                (self.operators.levels[0].slip).apply(&response.traction, &mut image);
                add(&mut image, 1.0, &offset);
                image.iter().map(|f| -f / length).collect::<Vec<f64>>()
            });
            let slip = at_faces.as_ref().unwrap_or(&response.slip);
            response.dissipation = self.dissipated(around, change, &response, slip);
            add(&mut response.dissipation, 1.0, &change.heat);
        }
        Ok(response)
    }

    /// The derivatives by all that is given of a number that weighs what was found: one transposed solve.
    ///
    /// # Errors
    /// As [`TangentialTangent::forward`].
    pub fn adjoint(
        &mut self,
        weights: &TangentialResponse,
        monitor: Monitor<'_>,
    ) -> Result<TangentialChange, Error> {
        let n = self.operators.grid().points();
        check("weights of the traction", &weights.traction, 2 * n)?;
        check("weights of the slip", &weights.slip, 2 * n)?;
        check("weights of the coefficient", &weights.coefficient, n)?;
        let points = if self.yields() { n } else { 0 };
        check("weights of the share", &weights.plastic_share, points)?;
        check("weights of the plastic slip", &weights.accumulated, points)?;
        for weight in weights.drive {
            check_number(
                "weight of the drive",
                weight,
                true,
                "a finite number is needed",
            )?;
        }
        if let Some(around) = self.around {
            let cells = around.shape[0] * around.shape[1];
            check("weights of the dissipation", &weights.dissipation, cells)?;
        }
        match self.following()? {
            Some(following) => self.adjoint_following(&following, weights, monitor),
            None => self.adjoint_held(weights, monitor),
        }
    }

    /// [`TangentialTangent::adjoint`] of friction that does not follow the temperature, or with its coefficients given.
    pub(super) fn adjoint_held(
        &mut self,
        weights: &TangentialResponse,
        monitor: Monitor<'_>,
    ) -> Result<TangentialChange, Error> {
        let n = self.operators.grid().points();
        let (problem, state, length) = (self.problem, self.state, self.length());
        let mut weights = weights.clone();
        let mut change = self.no_change();
        let mut of_slip = vec![0.0; 2 * n];
        if let Some(around) = self.around {
            change.heat.clone_from(&weights.dissipation);
            of_slip = self.weigh_dissipation(around, &mut weights, &mut change);
        }
        if !self.operators.has_faces() {
            add(&mut weights.slip, 1.0, &of_slip);
        }
        // weights of the slip at faces are weights of tractions and of what is given
        let at_faces: Vec<f64> = of_slip.iter().map(|w| -w / length).collect();
        let of_coefficient = self.in_contact(&weights.coefficient);
        let ((), counts) = self.linear(&mut |place| {
            let forced = (problem.drive.iter().zip(weights.drive))
                .filter_map(|(drive, w)| matches!(drive, Drive::Force(_)).then_some(w));
            let mut of_radius = vec![0.0; n];
            if place.law.is_some() {
                for i in 0..n {
                    if problem.pressure[i] > 0.0 {
                        of_radius[i] = of_coefficient[i] / problem.pressure[i];
                        change.pressure[i] -= state.coefficient[i] * of_radius[i];
                    }
                }
            } else {
                add(&mut change.coefficient, 1.0, &of_coefficient);
            }
            let on_rim = place.on_rim();
            let mut of_cells = weights.slip.clone();
            place.led_back(&mut of_cells, state.slip, &mut change.pressure);
            let mut image: Vec<f64> = of_cells.iter().map(|w| -w / length).collect();
            let mut of_layer = None;
            if let Some(layer) = place.layer {
                let asked = YieldFound {
                    radius: vec![0.0; n],
                    accumulated: weights.accumulated.clone(),
                    share: weights.plastic_share.clone(),
                };
                let given = layer.weigh(&on_rim, &asked);
                let mut of_magnitude = given.magnitude.clone();
                place.led_back(&mut of_magnitude, &on_rim, &mut change.pressure);
                place.discs.weigh_magnitude(&of_magnitude, &mut image);
                of_layer = Some(given);
            }
            let mut of_field = weights.traction.clone();
            let mut forced: Vec<f64> = forced.collect();
            if place.faces.is_some() {
                let mut of_traction = vec![0.0; 2 * n];
                let slip = &self.operators.levels[0].slip;
                slip.apply_transposed(&at_faces, &mut of_traction, &mut vec![0.0; n]);
                add(&mut of_field, 1.0, &of_traction);
                let components = (0..2).filter(|c| matches!(problem.drive[*c], Drive::Force(_)));
                for (forced, c) in forced.iter_mut().zip(components) {
                    *forced -= length * at_faces[c * n..(c + 1) * n].iter().sum::<f64>();
                }
            }
            let asked = DiscResponse {
                field: of_field,
                image,
                multipliers: forced,
                radius: of_radius,
            };
            let found = place.discs.adjoint(&asked, monitor)?;
            let found = found.ok_or(Error::Singular)?;
            let mut by_radius = self.in_contact(&found.radius);
            if let (Some(layer), Some(mut given)) = (place.layer, of_layer) {
                let asked = YieldFound {
                    radius: by_radius,
                    accumulated: vec![0.0; n],
                    share: vec![0.0; n],
                };
                let mut through = layer.weigh(&on_rim, &asked);
                place.led_back(&mut through.magnitude, &on_rim, &mut change.pressure);
                add(&mut given.friction, 1.0, &through.friction);
                add(&mut given.past, 1.0, &through.past);
                change.plasticity = PlasticityChange {
                    yield_stress: given.yield_stress + through.yield_stress,
                    hardening: given.hardening + through.hardening,
                    earlier: self.to_particles_before(&given.past),
                };
                by_radius = self.in_contact(&given.friction);
            }
            add_product(&mut change.pressure, state.coefficient, &by_radius);
            if let Some(law) = place.law {
                let speed = place.speeds();
                let mut back = vec![0.0; n];
                add_product(&mut back, problem.pressure, &by_radius);
                law.friction.pass_back(&speed, &mut back);
                if place.faces.is_some() {
                    let magnitude = place.led(place.discs.magnitude().to_vec());
                    let mut of_magnitude = vec![0.0; n];
                    law.derivative_transposed(&magnitude, &by_radius, &mut of_magnitude);
                    place.led_back(&mut of_magnitude, &magnitude, &mut change.pressure);
                }
                let columns = self.by_law(law, &speed);
                change.law = columns.iter().map(|column| dot(column, &back)).collect();
                change.earlier.coefficient = self.to_earlier(&back);
                if self.remembers() {
                    change.brought = back;
                }
            } else {
                add_product(&mut change.coefficient, problem.pressure, &by_radius);
            }
            let mut of_offset = found.offset;
            if let Some(faces) = place.faces {
                let image = self.image_at_faces();
                faces.add_to_pressure(&self.at_faces(&image), &of_offset, &mut change.pressure);
                let [by_length, by_stiffness, by_layer] = faces.by_constants(state.traction);
                change.length = dot(&by_length, &of_offset);
                change.stiffness = dot(&by_stiffness, &of_offset);
                change.layer += dot(&by_layer, &of_offset);
                faces.to_faces(&mut of_offset);
                add(&mut of_offset, 1.0, &at_faces);
            }
            self.by_offset(&of_offset, &mut change);
            let mut values = found.values.iter();
            for c in 0..2 {
                match problem.drive[c] {
                    Drive::Force(_) => change.drive[c] = values.next().copied().unwrap_or(0.0),
                    Drive::Slip(_) => change.drive[c] += weights.drive[c],
                }
            }
            Ok(())
        })?;
        self.count(counts);
        change.pressure = self.in_contact(&change.pressure);
        Ok(change)
    }

    /// Image (2n) at the faces of the cells.
    fn image_at_faces(&self) -> Vec<f64> {
        let length = self.length();
        self.slip_at_faces.iter().map(|s| -length * s).collect()
    }

    /// Where ties and extensions are derived, with the image there.
    fn at_faces<'b>(&'b self, image: &'b [f64]) -> AtFaces<'b> {
        AtFaces {
            traction: self.state.traction,
            image,
        }
    }

    fn count(&mut self, [products, preconditionings]: [usize; 2]) {
        self.products += products;
        self.preconditionings += preconditionings;
    }

    /// The rigid slip (2n) that does the same to the slip as the bodies of `other` operators, on the same grid and for
    /// the same motion, would do under the tractions and pressures of this solution.
    ///
    /// Where the compliance of the bodies is a sum of parts with factors, the derivative by a factor is that
    /// by [`TangentialChange::rigid_slip`] along what this gives for its part.
    pub fn slip_by_bodies(&self, other: &PatchOperators) -> Vec<f64> {
        let still = TangentialProblem {
            drive: [Drive::Slip(0.0); 2],
            spin: 0.0,
            rigid_slip: None,
            ..self.problem.clone()
        };
        let image = image_at_faces(other, &still, self.state.traction);
        let length = self.length();
        image.iter().map(|f| -f / length).collect()
    }

    /// The stiffness of ties by the bodies of `other` operators on the same grid, over that of these, for
    /// [`TangentialChange::stiffness`]: a sum over bodies like [`TangentialTangent::slip_by_bodies`].
    pub fn stiffness_of(&self, other: &PatchOperators) -> f64 {
        other.stiffness / self.operators.stiffness
    }

    /// The slip (2n), and the heat on the grid around, that `other` operators, for a motion of the same kind on the
    /// same grid, would make of the tractions, and of what else is given and found.
    ///
    /// The derivative by something that the operators depend on is that by [`TangentialChange::rigid_slip`] along the
    /// derivative of this slip, and of the heat directly that of this heat, in which the slip of the cells themselves
    /// is held.
    pub fn with_operators(&self, other: &PatchOperators) -> (Vec<f64>, Vec<f64>) {
        let given = TangentialProblem {
            drive: self.state.drive.map(Drive::Slip),
            ..self.problem.clone()
        };
        let mut slip = image_at_faces(other, &given, self.state.traction);
        let length = other.motion.length();
        for s in &mut slip {
            *s /= -length;
        }
        let heat = (self.around).map(|around| {
            heat_of(
                other,
                self.problem,
                &self.state,
                &self.slip_at_faces,
                around,
            )
        });
        (slip, heat.unwrap_or_default())
    }

    /// The coefficients of friction (n) that the particles of an earlier state bring along where `other` operators, on
    /// the same grid, carry them; empty where they bring none.
    ///
    /// The derivative by something that the operators depend on is that by [`TangentialChange::brought`] along the
    /// derivative of these.
    pub fn brought_by(&self, other: &PatchOperators) -> Vec<f64> {
        let (Friction::SpeedDependent { law, .. }, Some(earlier)) =
            (self.problem.friction, self.problem.earlier)
        else {
            return Vec::new();
        };
        if !self.remembers() {
            return Vec::new();
        }
        let rest = law.evaluate(0.0).0;
        carried(
            &other.grid(),
            other.motion.step(),
            &earlier.coefficient,
            rest,
        )
    }

    /// Images [m] of a unit of slip.
    pub(super) fn length(&self) -> f64 {
        self.operators.motion.length()
    }

    pub(super) fn in_contact(&self, field: &[f64]) -> Vec<f64> {
        let pairs = field.iter().zip(self.problem.pressure);
        pairs
            .map(|(v, p)| if *p > 0.0 { *v } else { 0.0 })
            .collect()
    }

    /// What changes the offset, but for the layer.
    fn offset_by(&self, change: &TangentialChange, pressure: &[f64]) -> Vec<f64> {
        let drive = [0, 1].map(|c| match self.problem.drive[c] {
            Drive::Slip(_) => change.drive[c],
            Drive::Force(_) => 0.0,
        });
        let moved = TangentialProblem {
            pressure,
            drive: drive.map(Drive::Slip),
            spin: change.spin,
            earlier: self.problem.earlier.map(|_| &change.earlier),
            rigid_slip: None,
            ..self.problem.clone()
        };
        // the offset is linear in all of these
        let mut changed = offset(self.operators, &moved);
        add(&mut changed, -self.length(), &change.rigid_slip);
        changed
    }

    /// The transpose of [`TangentialTangent::offset_by`], and the derivative by the layer.
    fn by_offset(&self, of_offset: &[f64], change: &mut TangentialChange) {
        let operators = self.operators;
        let n = operators.grid().points();
        for (slip, w) in change.rigid_slip.iter_mut().zip(of_offset) {
            *slip -= self.length() * w;
        }
        for c in 0..2 {
            if let Drive::Slip(_) = self.problem.drive[c] {
                change.drive[c] = change.rigid_slip[c * n..(c + 1) * n].iter().sum();
            }
        }
        let turning = TangentialProblem {
            spin: 1.0,
            rigid_slip: None,
            ..self.problem.clone()
        };
        change.spin -= dot(
            &rigid_slip(operators, &turning, [0.0; 2], [0.0; 2]),
            of_offset,
        );
        change.layer += dot(&self.layer_image(), of_offset);
        let turned = turned(of_offset);
        let back = |kernels: &Option<[Kernel; 2]>, scale: f64, to: &mut [f64]| {
            if let Some([along, across]) = kernels {
                let mut sum = vec![0.0; n];
                let transform = operators.transform();
                transform.apply_add(along, scale, &turned[..n], &mut sum);
                transform.apply_add(across, scale, &turned[n..], &mut sum);
                for (to, v) in to.iter_mut().zip(sum.iter().rev()) {
                    *to += v;
                }
            }
        };
        back(&operators.pressure_now, -1.0, &mut change.pressure);
        if operators.is_coupled() {
            let (mut traction, mut pressure) = (vec![0.0; 2 * n], vec![0.0; n]);
            let slip = &operators.levels[0].slip;
            slip.apply_transposed(of_offset, &mut traction, &mut pressure);
            add(&mut change.pressure, 1.0, &pressure);
        }
        if self.problem.earlier.is_none() {
            return;
        }
        back(
            &operators.pressure_earlier,
            1.0,
            &mut change.earlier.pressure,
        );
        if let Some(kernels) = &operators.earlier {
            let mut sum = vec![0.0; 2 * n];
            let transform = operators.transform();
            match operators.turn.as_ref().map(Turn::reversed) {
                Some(turn) => {
                    let mut pressure = vec![0.0; n];
                    kernels.apply_turned_transposed(
                        transform,
                        &turn,
                        &turned,
                        &mut sum,
                        &mut pressure,
                    );
                    pressure.reverse();
                    add(&mut change.earlier.pressure, -1.0, &pressure);
                }
                None => kernels.apply(transform, &turned, &mut sum),
            }
            add(&mut change.earlier.traction, -1.0, &self::turned(&sum));
            if let Some(across) = &operators.across_ahead {
                let earlier = &mut change.earlier;
                let (along, aside) = earlier.traction.split_at_mut(n);
                let loads = [Some(along), Some(aside), Some(&mut earlier.pressure[..])];
                across.add_transposed(-1.0, of_offset, loads);
            }
            for c in 0..2 {
                let part = c * n..(c + 1) * n;
                let layer = operators.layer_behind(&of_offset[part.clone()]);
                add(&mut change.earlier.traction[part], -operators.layer, &layer);
            }
        }
    }

    /// Image of the tractions by a unit of the layer.
    fn layer_image(&self) -> Vec<f64> {
        let n = self.operators.grid().points();
        let (before, scale) = match (self.operators.motion, self.problem.earlier) {
            (Motion::Steady { .. }, _) => (
                Some(self.state.traction),
                self.operators.motion.step_length(),
            ),
            (_, Some(earlier)) => (Some(earlier.traction.as_slice()), 1.0),
            _ => (None, 1.0),
        };
        let mut image = self.state.traction.to_vec();
        if let Some(before) = before {
            for c in 0..2 {
                let part = c * n..(c + 1) * n;
                let ahead = self.operators.layer_ahead(&before[part.clone()]);
                add(&mut image[part], -1.0, &ahead);
            }
        }
        image.iter().map(|q| q / scale).collect()
    }

    /// The transpose of carrying a field along by a step.
    pub(super) fn carried_back(&self, field: &[f64]) -> Vec<f64> {
        let step = self.operators.motion.step().map(|d| -d);
        carried(&self.operators.grid(), step, field, 0.0)
    }

    /// What changed coefficients of the earlier state add to those that the particles bring along.
    fn by_earlier(&self, coefficient: &[f64]) -> Vec<f64> {
        let grid = self.operators.grid();
        if !self.remembers() || self.problem.earlier.is_none() {
            return vec![0.0; grid.points()];
        }
        carried(&grid, self.operators.motion.step(), coefficient, 0.0)
    }

    /// The transpose of [`TangentialTangent::by_earlier`].
    fn to_earlier(&self, weights: &[f64]) -> Vec<f64> {
        if !self.remembers() || self.problem.earlier.is_none() {
            return vec![0.0; weights.len()];
        }
        self.carried_back(weights)
    }

    /// What changed plastic slips of the earlier state are at the particles that come.
    fn particles_before(&self, accumulated: &[f64]) -> Vec<f64> {
        let grid = self.operators.grid();
        if accumulated.is_empty() || self.problem.earlier.is_none() {
            return vec![0.0; grid.points()];
        }
        carried(&grid, self.operators.motion.step(), accumulated, 0.0)
    }

    /// The transpose of [`TangentialTangent::particles_before`].
    fn to_particles_before(&self, weights: &[f64]) -> Vec<f64> {
        if self.problem.earlier.is_none() {
            return vec![0.0; weights.len()];
        }
        self.carried_back(weights)
    }

    /// Whether the coefficients depend on those of an earlier state.
    fn remembers(&self) -> bool {
        let is_steady = matches!(self.operators.motion, Motion::Steady { .. });
        let Friction::SpeedDependent { memory, .. } = self.problem.friction else {
            return false;
        };
        memory.is_some() && !is_steady
    }

    /// What the equations of the coefficients gain by the parameters of the law.
    fn by_law(&self, law: &SlipBound<'_>, speed: &[f64]) -> Vec<Vec<f64>> {
        let mut columns = law.friction.by_parameters(speed);
        let Friction::SpeedDependent { law, .. } = self.problem.friction else {
            return columns;
        };
        if self.remembers() {
            // particles that come from outside, or have no past, come from rest
            let grid = self.operators.grid();
            let outside = if self.problem.earlier.is_some() {
                let none = vec![0.0; grid.points()];
                carried(&grid, self.operators.motion.step(), &none, 1.0)
            } else {
                vec![1.0; grid.points()]
            };
            for (column, rest) in columns.iter_mut().zip(law.parameters(0.0)) {
                add(column, rest, &outside);
            }
        }
        columns
    }

    /// Runs `work` with the linear problem; its result, and the products and preconditionings that it took.
    fn linear<T>(
        &self,
        work: &mut dyn FnMut(&mut Place<'_, '_>) -> Result<T, Error>,
    ) -> Result<(T, [usize; 2]), Error> {
        let (operators, problem, state) = (self.operators, self.problem, self.state);
        let cascade = Cascade::new(operators, problem, offset(operators, problem));
        let here = &operators.levels[0];
        let resultants = cascade.resultants(0);
        let exchanged = transposed(&resultants);
        let law = match problem.friction {
            Friction::SpeedDependent { law, memory } => {
                Some(cascade.speed_dependent(0, law, *memory))
            }
            _ => None,
        };
        let bound: Vec<f64> = (state.coefficient.iter().zip(problem.pressure))
            .map(|(mu, p)| mu * p.max(0.0))
            .collect();
        let layer = (problem.plasticity.as_ref())
            .map(|p| Yielding::new(operators, problem, p, 0, bound.clone()));
        let radius = match (&law, &layer) {
            (Some(law), _) => Radius::Dependent(law),
            (None, Some(layer)) => Radius::Dependent(layer),
            (None, None) => Radius::Fixed(&bound),
        };
        let faces = cascade.faces.as_ref();
        let led = match (faces, radius) {
            (Some(faces), Radius::Dependent(law)) => Some(LedRadius { faces, law }),
            _ => None,
        };
        let radius = (led.as_ref()).map_or(radius, |law| Radius::Dependent(law));
        let (slip, inverse) = (&here.slip, &here.inverse);
        let (slip_back, inverse_back) = (Turned(slip), TurnedInverse(inverse));
        let seen = faces.map(|faces| {
            let (operator, back) = (slip as &dyn LinearOperator, &slip_back as _);
            let of_slip = OnCells { faces, operator };
            let operator = back;
            let transposed = OnCellsBack { faces, operator };
            let (inverse, back) = (inverse as &dyn Preconditioner, &inverse_back as _);
            let of_inverse = OnCellsInverse { faces, inverse };
            let inverse = back;
            (
                (of_slip, transposed),
                (of_inverse, OnCellsInverseBack { faces, inverse }),
            )
        });
        let (forth, back): (Inverted<'_>, Inverted<'_>) = match &seen {
            Some((slip, inverse)) => ((&slip.0, &inverse.0), (&slip.1, &inverse.1)),
            None => ((slip, inverse), (&slip_back, &inverse_back)),
        };
        let given = DiscProblem {
            operator: forth.0,
            rough: forth.0,
            preconditioner: forth.1,
            offset: &cascade.offset[0],
            radius,
            resultants: &resultants,
            diagonal: here.diagonal,
        };
        let back = DiscProblem {
            operator: back.0,
            rough: back.0,
            preconditioner: back.1,
            resultants: &exchanged,
            ..given
        };
        let multipliers: Vec<f64> = (problem.drive.iter().zip(state.drive))
            .filter_map(|(given, found)| matches!(given, Drive::Force(_)).then_some(found))
            .collect();
        let mut place = Place {
            discs: DiscTangent::new(&given, &back, state.traction, &multipliers)?,
            law: law.as_ref(),
            layer: layer.as_ref(),
            faces,
            speed: cascade.speed(),
        };
        let result = work(&mut place)?;
        let counts = [place.discs.products, place.discs.preconditionings];
        Ok((result, counts))
    }
}

/// An operator and a rough inverse of it.
type Inverted<'a> = (&'a dyn LinearOperator, &'a dyn Preconditioner);

/// The linear problem of a solution.
struct Place<'a, 'b> {
    discs: DiscTangent<'b>,
    law: Option<&'a SlipBound<'b>>,
    layer: Option<&'a Yielding>,
    /// Where slip is of second order.
    faces: Option<&'a Faces>,
    speed: f64,
}

impl Place<'_, '_> {
    /// Magnitudes of the slip of points on their bound, in the unit of the image (n).
    fn on_rim(&self) -> Vec<f64> {
        self.led(self.discs.magnitude_on_rim())
    }

    /// Values of the cells (n), where tied cells slip like those behind them.
    fn led(&self, mut values: Vec<f64>) -> Vec<f64> {
        if let Some(faces) = self.faces {
            faces.lead(&mut values);
        }
        values
    }

    /// The change of what was `led` (n, or 2n), with that of the values and of the pressure.
    fn led_change(&self, mut change: Vec<f64>, led: &[f64], pressure: &[f64]) -> Vec<f64> {
        if let Some(faces) = self.faces {
            faces.lead_by_pressure(led, pressure, &mut change);
            faces.lead(&mut change);
        }
        change
    }

    /// The transpose of [`Place::led_change`], in place.
    fn led_back(&self, weights: &mut [f64], led: &[f64], pressure: &mut [f64]) {
        if let Some(faces) = self.faces {
            faces.lead_back(weights);
            faces.lead_to_pressure(led, weights, pressure);
        }
    }

    /// Slip speeds [m/s], (n).
    fn speeds(&self) -> Vec<f64> {
        let magnitude = self.led(self.discs.magnitude().to_vec());
        magnitude.iter().map(|m| m * self.speed).collect()
    }
}

/// A slip operator, transposed.
struct Turned<'a>(&'a SlipOperator);

impl LinearOperator for Turned<'_> {
    fn dim(&self) -> usize {
        LinearOperator::dim(self.0)
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.0.apply_transposed(x, y, &mut vec![0.0; x.len() / 2]);
    }
}

/// A rough inverse of an operator of convolutions, for the operator transposed: on what is seen from the other end, that
/// is the same problem.
struct TurnedInverse<'a>(&'a dyn Preconditioner);

impl Preconditioner for TurnedInverse<'_> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn invert(&self, curvature: &[f64], y: &[f64], x: &mut [f64]) {
        let curvature: Vec<f64> = curvature.iter().rev().copied().collect();
        let mut image = vec![0.0; x.len()];
        self.0.invert(&curvature, &turned(y), &mut image);
        x.copy_from_slice(&turned(&image));
    }
}

/// A field of two components seen from the other end of the grid.
pub(super) fn turned(field: &[f64]) -> Vec<f64> {
    let (first, second) = field.split_at(field.len() / 2);
    first
        .iter()
        .rev()
        .chain(second.iter().rev())
        .copied()
        .collect()
}

pub(super) fn add(to: &mut [f64], scale: f64, field: &[f64]) {
    for (to, v) in to.iter_mut().zip(field) {
        *to += scale * v;
    }
}

fn add_product(to: &mut [f64], a: &[f64], b: &[f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to += a * b;
    }
}
