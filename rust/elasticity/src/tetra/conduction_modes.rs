// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conducting bodies in few modes, in which implicit steps of any duration are diagonal.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use mtb_operator::{Monitor, ready_products, reset_workers};
use rayon::prelude::*;

use super::columns::{columns_of, par, symmetric_eigen};
use super::conduction::{ConductingBody, check_duration, dot, refuse};
use super::conduction_basis::Basis;
use super::factorised::poll;
use super::sampling::Sampling;
use crate::Error;

/// A conducting body in modes of its own.
///
/// Its temperatures are `V a`, with amplitudes `a` (r) of modes `V` that hold the answers of the body to fluxes through
/// its contact points after steps of any duration, from a uniform temperature on: a rational Krylov space
/// [DruskinKnizhnermanZaslavsky2009], [Guettel2013]. Modes hold unit heat, `V^T C V = 1`, and decay at their `rates`,
/// so that an implicit step over a duration is `a <- (a + duration (f + V^T B q)) / (1 + duration rate)`. A uniform
/// temperature is among them, so that balances of heat close as those of the whole body do.
#[derive(Clone)]
pub struct ConductionModes {
    space: Arc<Space>,
    /// Decay [1/s] of the modes.
    rates: Vec<f64>,
    /// Of another conductivity: its modes in those of the space.
    turned: Option<Arc<Mat<f64>>>,
    /// Temperatures of the contact points by the modes (n, r).
    trace: Arc<Mat<f64>>,
}

struct Space {
    body: Arc<ConductingBody>,
    weights: Vec<f64>,
    /// Temperatures of the nodes (ranks, r) that span it, one after the other, and the modes as sums of them.
    columns: Vec<f64>,
    vectors: Mat<f64>,
    rates: Vec<f64>,
    /// Heat flow through films, where there are any.
    films: Option<Mat<f64>>,
    inflow: Vec<f64>,
    uniform: Vec<f64>,
    loss: Vec<f64>,
    trace: Arc<Mat<f64>>,
}

impl ConductingBody {
    /// The body in modes that hold its answers to fluxes through the contact points of `sampling`, after any number of
    /// implicit steps of any duration from a uniform temperature on.
    ///
    /// The answers at durations in a geometric row, from that in which the finest elements under the contact become
    /// uniform to that in which the whole body does, are put together by random fluxes, as many as give something new.
    /// Between two durations they are compared with those of the whole body, and added where more than 1e-5 of one is
    /// left out; in what the contact points see this is far less, because the error of a symmetric projection is of
    /// second order there.
    ///
    /// # Errors
    /// [`Error::NotOnBoundary`], [`Error::NoArea`]; [`Error::Operator`] and [`Error::OutOfMemory`] for more than the
    /// memory holds; [`Error::Interrupted`].
    pub fn modes(
        self: &Arc<Self>,
        sampling: &Sampling,
        monitor: Monitor<'_>,
    ) -> Result<ConductionModes, Error> {
        ready_products()?;
        let (trace, weights) = self.traced(sampling)?;
        let basis = Basis::spanning(self, &trace, monitor)?;
        ConductionModes::new(self, basis, weights, monitor)
    }
}

impl ConductionModes {
    fn new(
        body: &Arc<ConductingBody>,
        basis: Basis<'_>,
        weights: Vec<f64>,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        let rows = basis.rows();
        let between = basis.reduced(body.conduction());
        poll(monitor, 5)?;
        let (vectors, rates) = symmetric_eigen(&between)?;
        poll(monitor, 5)?;
        let spanning = columns_of(&basis.columns, rows);
        let of = |values: &[f64]| {
            times_vector(
                vectors.transpose(),
                &times_vector(spanning.transpose(), values),
            )
        };
        let ones = vec![1.0; rows];
        let through = body.films().times(&ones);
        let uniform = of(&body.capacity().times(&ones));
        let (inflow, loss) = (of(body.inflow_by_rank()), of(&through));
        let films = through.iter().any(|f| *f != 0.0).then(|| {
            let between = basis.reduced(body.films());
            vectors.transpose() * &between * &vectors
        });
        let trace = Mat::from_fn(weights.len(), rates.len(), |i, k| {
            let seen = basis.trace[i]
                .iter()
                .map(|(node, b)| b * spanning[(*node, k)]);
            seen.sum::<f64>() / weights[i]
        });
        let trace = Arc::new(&trace * &vectors);
        let space = Space {
            body: body.clone(),
            weights,
            rates: rates.iter().map(|rate| rate.max(0.0)).collect(),
            films,
            inflow,
            uniform,
            loss,
            trace,
            columns: basis.columns,
            vectors,
        };
        Ok(Self {
            rates: space.rates.clone(),
            trace: space.trace.clone(),
            turned: None,
            space: Arc::new(space),
        })
    }

    /// The body with another `conductivity` [W/(m K)], in the same space: amplitudes keep their meaning.
    ///
    /// Without films it is as exact as the first one. What films do to heat from the contact is in the space for the
    /// first conductivity alone: half of it, beside a strong film, moves answers by 1e-5, and openings by 1e-3.
    ///
    /// # Errors
    /// [`Error::NotPositive`]; [`Error::OutOfMemory`].
    pub fn with_conductivity(&self, conductivity: f64) -> Result<Self, Error> {
        if !(conductivity > 0.0 && conductivity.is_finite()) {
            return Err(Error::NotPositive {
                name: "conductivity",
                value: conductivity,
            });
        }
        let space = &self.space;
        let factor = conductivity / space.body.conductor().conductivity();
        let own: Vec<f64> = space.rates.iter().map(|rate| factor * rate).collect();
        let Some(films) = &space.films else {
            return Ok(Self {
                space: space.clone(),
                rates: own,
                turned: None,
                trace: space.trace.clone(),
            });
        };
        let between = Mat::from_fn(own.len(), own.len(), |i, j| {
            let diagonal = if i == j { own[i] } else { 0.0 };
            diagonal + (1.0 - factor) * films[(i, j)]
        });
        let (vectors, rates) = symmetric_eigen(&between)?;
        Ok(Self {
            space: space.clone(),
            rates: rates.iter().map(|rate| rate.max(0.0)).collect(),
            trace: Arc::new(space.trace.as_ref() * &vectors),
            turned: Some(Arc::new(vectors)),
        })
    }

    /// Number of the modes.
    pub fn count(&self) -> usize {
        self.rates.len()
    }

    /// Areas (n) [m2] of the contact points.
    pub fn weights(&self) -> &[f64] {
        &self.space.weights
    }

    /// Amplitudes (r) of a uniform `temperature` [K].
    pub fn uniform(&self, temperature: f64) -> Vec<f64> {
        let uniform = self.space.uniform.iter();
        uniform.map(|u| temperature * u).collect()
    }

    /// Temperatures (nodes) [K], in the order of the mesh.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn temperature(&self, amplitudes: &[f64]) -> Result<Vec<f64>, Error> {
        refuse("amplitudes", amplitudes, self.count())?;
        let space = &self.space;
        let sums = times_vector(space.vectors.as_ref(), amplitudes);
        let rows = space.body.mesh().nodes().len();
        let ranked = times_vector(columns_of(&space.columns, rows), &sums);
        Ok(self.space.body.by_node(&ranked))
    }

    /// Temperatures of the contact points (n) [K].
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn observe(&self, amplitudes: &[f64]) -> Result<Vec<f64>, Error> {
        refuse("amplitudes", amplitudes, self.count())?;
        Ok(times_vector(self.space.trace.as_ref().as_ref(), amplitudes))
    }

    /// What sums over the temperatures of the nodes, `rows` (m, nodes) row-major, are of the amplitudes: (m, r),
    /// row-major.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn seen(&self, rows: &[f64]) -> Result<Vec<f64>, Error> {
        let nodes = self.space.body.mesh().nodes().len();
        let m = rows.len() / nodes;
        refuse("rows", rows, m * nodes)?;
        ready_products()?;
        let mut ranked = vec![0.0; rows.len()];
        ranked
            .par_chunks_mut(nodes)
            .zip(rows.par_chunks(nodes))
            .for_each(|(ranked, row)| ranked.copy_from_slice(&self.space.body.by_rank(row)));
        let mut seen = Mat::zeros(m, self.count());
        matmul(
            seen.as_mut(),
            Accum::Replace,
            MatRef::from_row_major_slice(&ranked, m, nodes),
            columns_of(&self.space.columns, nodes),
            1.0,
            par(),
        );
        let mut found = vec![0.0; m * self.count()];
        matmul(
            MatMut::from_row_major_slice_mut(&mut found, m, self.count()),
            Accum::Replace,
            seen.as_ref(),
            self.space.vectors.as_ref(),
            1.0,
            par(),
        );
        reset_workers();
        Ok(found)
    }

    /// Heat [J] that the body holds, above that at zero.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn heat(&self, amplitudes: &[f64]) -> Result<f64, Error> {
        refuse("amplitudes", amplitudes, self.count())?;
        Ok(dot(&self.space.uniform, amplitudes))
    }

    /// Heat flow [W] that leaves through films.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn loss(&self, amplitudes: &[f64]) -> Result<f64, Error> {
        refuse("amplitudes", amplitudes, self.count())?;
        let inflow: f64 = self.space.body.inflow_by_rank().iter().sum();
        Ok(dot(&self.space.loss, amplitudes) - inflow)
    }

    /// Amplitudes (r) at the end of an implicit step over `duration` [s] that begins at `amplitudes`, with `flux` (n)
    /// [W/m2] through the contact points.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::Duration`].
    pub fn advance(
        &self,
        duration: f64,
        amplitudes: &[f64],
        flux: &[f64],
    ) -> Result<Vec<f64>, Error> {
        check_duration(duration)?;
        let space = &self.space;
        refuse("amplitudes", amplitudes, self.count())?;
        refuse("flux", flux, space.weights.len())?;
        let heated: Vec<f64> = flux
            .iter()
            .zip(&space.weights)
            .map(|(q, w)| q * w)
            .collect();
        let entered = times_vector(space.trace.transpose(), &heated);
        let mut next: Vec<f64> = amplitudes
            .iter()
            .zip(entered.iter().zip(&space.inflow))
            .map(|(a, (entered, inflow))| a + duration * (entered + inflow))
            .collect();
        if let Some(turned) = &self.turned {
            next = times_vector(turned.transpose(), &next);
        }
        for (a, rate) in next.iter_mut().zip(&self.rates) {
            *a /= 1.0 + duration * rate;
        }
        Ok(match &self.turned {
            Some(turned) => times_vector(turned.as_ref().as_ref(), &next),
            None => next,
        })
    }

    /// Temperatures (n, n) [K m2/W] of the contact points at the end of a step by a unit flux into each, row-major.
    ///
    /// # Errors
    /// [`Error::Duration`], [`Error::Operator`].
    pub fn response(&self, duration: f64) -> Result<Vec<f64>, Error> {
        self.answers(duration, self.trace.as_ref().as_ref())
    }

    /// What [`Self::seen`] found (m, r), of the temperatures at the end of a step by a unit flux into each contact
    /// point: (m, n), row-major.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::Duration`], [`Error::Operator`].
    pub fn response_of(&self, duration: f64, seen: &[f64]) -> Result<Vec<f64>, Error> {
        let m = seen.len() / self.count();
        refuse("seen", seen, m * self.count())?;
        let seen = MatRef::from_row_major_slice(seen, m, self.count());
        match &self.turned {
            Some(turned) => self.answers(duration, (seen * turned.as_ref()).as_ref()),
            None => self.answers(duration, seen),
        }
    }

    fn answers(&self, duration: f64, seen: MatRef<'_, f64>) -> Result<Vec<f64>, Error> {
        check_duration(duration)?;
        ready_products()?;
        let (m, n) = (seen.nrows(), self.weights().len());
        let gains: Vec<f64> = self
            .rates
            .iter()
            .map(|rate| duration / (1.0 + duration * rate))
            .collect();
        let entered = Mat::from_fn(self.count(), n, |k, j| {
            gains[k] * self.trace[(j, k)] * self.space.weights[j]
        });
        let mut found = vec![0.0; m * n];
        matmul(
            MatMut::from_row_major_slice_mut(&mut found, m, n),
            Accum::Replace,
            seen,
            entered.as_ref(),
            1.0,
            par(),
        );
        reset_workers();
        Ok(found)
    }
}

fn times_vector(matrix: MatRef<'_, f64>, x: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; matrix.nrows()];
    let rows = found.len();
    matmul(
        MatMut::from_column_major_slice_mut(&mut found, rows, 1),
        Accum::Replace,
        matrix,
        MatRef::from_column_major_slice(x, x.len(), 1),
        1.0,
        Par::Seq,
    );
    found
}
