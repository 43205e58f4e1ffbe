// SPDX-License-Identifier: MIT OR Apache-2.0
//! One of the two bodies on its way.

use mtb_operator::Compliance;

use super::surface::{add, along, dot, normals, tangents, turn};
use crate::sliding::displacement;

#[derive(Clone)]
pub(super) struct Side<'a> {
    body: Option<&'a dyn Compliance>,
    /// Deformed and moved points.
    pub(super) position: Vec<[f64; 3]>,
    /// Elastic part of their displacement.
    pub(super) displacement: Vec<[f64; 3]>,
    /// Outward unit normals.
    pub(super) normal: Vec<[f64; 3]>,
    pub(super) pressure: Vec<f64>,
    /// Friction on this body, common frame.
    pub(super) friction: Vec<[f64; 3]>,
    /// Where friction pulls this body.
    pull: [f64; 3],
    /// 1 for the lower body, whose normals point up, -1 for the upper one.
    sign: f64,
}

impl<'a> Side<'a> {
    pub(super) fn new(
        body: Option<&'a dyn Compliance>,
        points: &[f64],
        grids: &[(usize, usize)],
        n: usize,
        sign: f64,
        pull: [f64; 3],
    ) -> Self {
        let position: Vec<[f64; 3]> = (0..n)
            .map(|i| [points[i], points[n + i], points[2 * n + i]])
            .collect();
        Self {
            body,
            normal: normals(&position, grids, sign),
            position,
            displacement: vec![[0.0; 3]; n],
            pressure: vec![0.0; n],
            friction: vec![[0.0; 3]; n],
            pull,
            sign,
        }
    }

    /// Vertical force of the contact on this body, down for the lower one [N].
    pub(super) fn vertical_force(&self, area: &[f64]) -> f64 {
        let sum: f64 = (0..area.len())
            .map(|i| area[i] * (self.pressure[i] * self.normal[i][2] - self.friction[i][2]))
            .sum();
        self.sign * sum
    }

    /// Adds pressure, the friction that comes with it, and the displacements of both.
    pub(super) fn load(&mut self, pressure: &[f64], coefficient: &[f64]) {
        let friction: Vec<[f64; 3]> = (0..pressure.len())
            .map(|i| {
                let direction = along(self.pull, self.normal[i]);
                direction.map(|d| coefficient[i] * pressure[i] * d)
            })
            .collect();
        self.deform(pressure, &friction);
    }

    /// Takes away a share of pressure and friction at each point.
    pub(super) fn release(&mut self, share: &[f64]) {
        let pressure: Vec<f64> = share
            .iter()
            .zip(&self.pressure)
            .map(|(s, p)| -s * p)
            .collect();
        let friction: Vec<[f64; 3]> = share
            .iter()
            .zip(&self.friction)
            .map(|(s, q)| q.map(|q| -s * q))
            .collect();
        self.deform(&pressure, &friction);
    }

    fn deform(&mut self, pressure: &[f64], friction: &[[f64; 3]]) {
        let n = pressure.len();
        let frame: Vec<[[f64; 3]; 2]> = self.normal.iter().map(|n| tangents(*n)).collect();
        if let Some(body) = self.body {
            let along =
                |k: usize| -> Vec<f64> { (0..n).map(|i| dot(friction[i], frame[i][k])).collect() };
            let [x, y, into] = displacement(body, [&along(0), &along(1), pressure]);
            for i in 0..n {
                let tangential = add(frame[i][0].map(|t| x[i] * t), y[i], frame[i][1]);
                let moved = add(tangential, -into[i], self.normal[i]);
                self.displacement[i] = add(self.displacement[i], 1.0, moved);
                self.position[i] = add(self.position[i], 1.0, moved);
            }
        }
        for i in 0..n {
            self.pressure[i] += pressure[i];
            self.friction[i] = add(self.friction[i], 1.0, friction[i]);
        }
    }

    /// Turns the normals with the surface, which was at `before`.
    pub(super) fn turn(&mut self, before: &[[f64; 3]], grids: &[(usize, usize)]) {
        turn(&mut self.normal, before, &self.position, grids);
    }
}
