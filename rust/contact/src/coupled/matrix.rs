// SPDX-License-Identifier: MIT OR Apache-2.0
//! All nine blocks of the compliance of two bodies.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use faer::linalg::matmul::matmul;
use faer::{Accum, ColMut, ColRef, Mat, MatRef, Par};
use mtb_operator::{
    Compliance, Component, Monitor, Relative, check_factors, report, reset_workers,
};

use super::memory;
use crate::error::{Error, check, check_positive};

/// The compliance of two bodies at their contact points: along both tangents, then along the normal.
#[derive(Debug)]
pub struct CoupledMatrix {
    /// (3n, 3n)
    pub(crate) compliance: Mat<f64>,
    /// Mean diagonal of the compliance along the tangents and along the normal, inverted.
    pub(super) stiffness: [f64; 2],
}

impl CoupledMatrix {
    /// Forms all blocks of `compliance`, with a `layer` [m/Pa] that softens the tangents.
    ///
    /// # Errors
    /// A negative layer, more points than the memory holds, [`Error::Interrupted`].
    pub fn new(
        compliance: &dyn Compliance,
        layer: f64,
        monitor: Monitor<'_>,
    ) -> Result<Self, Error> {
        const AXES: [Component; 3] = [Component::X, Component::Y, Component::Normal];
        let n = compliance.points();
        check("layer", &[layer], 1)?;
        if layer < 0.0 {
            return Err(Error::Negative {
                name: "layer",
                index: 0,
                value: layer,
            });
        }
        check_factors(n, memory(n) + compliance.influence_memory())?;
        let mut matrix = Mat::zeros(3 * n, 3 * n);
        let mut block = vec![0.0; n * n];
        for (i, observed) in AXES.into_iter().enumerate() {
            for (j, loaded) in AXES.into_iter().enumerate() {
                block.fill(0.0);
                compliance.add_influence(observed, loaded, 1.0, &mut block);
                let mut part = matrix.as_mut().submatrix_mut(i * n, j * n, n, n);
                for (row, values) in block.chunks_exact(n.max(1)).enumerate() {
                    for (column, value) in values.iter().enumerate() {
                        part[(row, column)] = *value;
                    }
                }
                report(monitor, 3 * i + j, f64::NAN)?;
            }
        }
        for i in 0..2 * n {
            matrix[(i, i)] += layer;
        }
        Ok(Self::of(matrix))
    }

    /// Of all blocks (3n, 3n) together, formed elsewhere.
    pub(crate) fn of(compliance: Mat<f64>) -> Self {
        let n = compliance.nrows() / 3;
        let mean = |range: std::ops::Range<usize>| {
            range.len() as f64 / range.map(|i| compliance[(i, i)]).sum::<f64>()
        };
        Self {
            stiffness: [mean(0..2 * n), mean(2 * n..3 * n)],
            compliance,
        }
    }

    /// The compliance (3n, 3n) column by column [m/Pa], as [`CoupledMatrix::columns`] gave it.
    ///
    /// # Errors
    /// A wrong length, numbers that are not finite, a diagonal that is not positive.
    pub fn from_columns(points: usize, columns: &[f64]) -> Result<Self, Error> {
        const NAME: &str = "compliance along the tangents";
        let rows = 3 * points;
        check(NAME, columns, rows * rows)?;
        let diagonal: Vec<f64> = columns.iter().step_by(rows + 1).copied().collect();
        for index in 0..rows {
            check_positive(NAME, diagonal[index])?;
        }
        Ok(Self::of(
            MatRef::from_column_major_slice(columns, rows, rows).to_owned(),
        ))
    }

    /// The compliance (3n, 3n) column by column [m/Pa].
    pub fn columns(&self) -> Vec<f64> {
        let columns = self.compliance.ncols();
        (0..columns)
            .flat_map(|j| self.compliance.col_as_slice(j).iter().copied())
            .collect()
    }

    /// The same with the product of `rows` (3n, k) and `columns` (k, 3n) [m/Pa] added.
    pub(crate) fn softer(&self, rows: MatRef<'_, f64>, columns: MatRef<'_, f64>) -> Self {
        let mut compliance = self.compliance.clone();
        let threads = threads(compliance.nrows() * compliance.ncols());
        matmul(compliance.as_mut(), Accum::Add, rows, columns, 1.0, threads);
        reset_workers();
        Self::of(compliance)
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.compliance.nrows() / 3
    }

    /// Displacement (3n) [m] by tractions along both tangents and pressures (3n) [Pa].
    pub fn displacement(&self, traction: &[f64]) -> Vec<f64> {
        product(self.compliance.as_ref(), traction)
    }
}

/// Entries of a matrix from which on threads share a product.
const SHARED: usize = 500_000;

/// The threads for a matrix of so many entries.
pub(super) fn threads(entries: usize) -> Par {
    if entries < SHARED {
        Par::Seq
    } else {
        faer::get_global_parallelism()
    }
}

/// [`reset_workers`] after what these threads shared: to wake them costs as much as a small system.
pub(super) fn reset_after(threads: Par) {
    if threads.degree() > 1 {
        reset_workers();
    }
}

/// The product of a matrix with a vector.
pub(super) fn product(matrix: MatRef<'_, f64>, vector: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; matrix.nrows()];
    matmul(
        ColMut::from_slice_mut(&mut out),
        Accum::Replace,
        matrix,
        ColRef::from_slice(vector),
        1.0,
        threads(matrix.nrows() * matrix.ncols()),
    );
    out
}

/// What is formed when it is first needed, and then shared; of a file, formed already.
pub struct OnDemand<T>(Arc<Source<T>>);

/// How it is formed.
type Make<T> = Box<dyn Fn(Monitor<'_>) -> Result<T, Error> + Send + Sync>;

enum Source<T> {
    Unformed {
        make: Make<T>,
        made: Mutex<Option<Arc<T>>>,
    },
    Formed(Arc<T>),
}

impl<T> OnDemand<T> {
    /// What `make` forms.
    pub fn new(make: impl Fn(Monitor<'_>) -> Result<T, Error> + Send + Sync + 'static) -> Self {
        let made = Mutex::new(None);
        let make = Box::new(make);
        Self(Arc::new(Source::Unformed { make, made }))
    }

    /// What is formed already.
    pub fn formed(whole: T) -> Self {
        Self(Arc::new(Source::Formed(Arc::new(whole))))
    }

    /// It, formed.
    ///
    /// # Errors
    /// Those of forming it: more points than the memory holds, [`Error::Interrupted`].
    pub fn get(&self, monitor: Monitor<'_>) -> Result<Arc<T>, Error> {
        let (make, made) = match &*self.0 {
            Source::Formed(whole) => return Ok(whole.clone()),
            Source::Unformed { make, made } => (make, made),
        };
        let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(made) = &*made {
            return Ok(made.clone());
        }
        let new = Arc::new(make(monitor)?);
        *made = Some(new.clone());
        Ok(new)
    }
}

impl OnDemand<CoupledMatrix> {
    /// The compliance of two bodies, with a `layer` [m/Pa] that softens the tangents.
    pub fn of_pair(pair: Relative, layer: f64) -> Self {
        Self::new(move |monitor| CoupledMatrix::new(&pair, layer, monitor))
    }
}

impl<T> Clone for OnDemand<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

/// The same bodies, not bodies alike.
impl<T> PartialEq for OnDemand<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T> fmt::Debug for OnDemand<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnDemand").finish_non_exhaustive()
    }
}
