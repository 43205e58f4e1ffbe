// SPDX-License-Identifier: MIT OR Apache-2.0
//! Memory that transforms use again: fresh pages cost as much as a transform.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex};

use rustfft::num_complex::Complex;

/// Memory for products, to be shared by transforms that are used one after the other; see
/// [`Transform::sharing`](super::Transform::sharing). Grows with what is asked for and is freed with its last owner.
#[derive(Clone, Default)]
pub struct Buffers {
    reals: Arc<Pool<Vec<f64>>>,
    pub(super) double: Pools<f64>,
    pub(super) single: Pools<f32>,
}

/// Memory of transforms of one precision.
#[derive(Clone)]
pub struct Pools<T> {
    fields: Arc<Pool<Vec<Complex<T>>>>,
    scratch: Arc<Pool<Scratch<T>>>,
}

impl<T> Default for Pools<T> {
    fn default() -> Self {
        Self {
            fields: Arc::default(),
            scratch: Arc::default(),
        }
    }
}

impl Buffers {
    /// A vector of any content and length, to be given back by dropping it.
    pub fn reals(&self) -> impl DerefMut<Target = Vec<f64>> + '_ {
        self.reals.lend()
    }
}

impl<T> Pools<T> {
    /// Room for the spectra of a product, of any content.
    pub(super) fn field(&self) -> Lent<'_, Vec<Complex<T>>> {
        self.fields.lend()
    }

    /// Room for the rows and columns that a thread is at work on, of any content.
    pub(super) fn scratch(&self) -> Lent<'_, Scratch<T>> {
        self.scratch.lend()
    }
}

pub(super) struct Scratch<T> {
    pub(super) row: Vec<T>,
    pub(super) spectrum: Vec<Complex<T>>,
    pub(super) columns: Vec<Complex<T>>,
    pub(super) product: Vec<Complex<T>>,
    pub(super) work: Vec<Complex<T>>,
}

impl<T> Default for Scratch<T> {
    fn default() -> Self {
        Self {
            row: Vec::new(),
            spectrum: Vec::new(),
            columns: Vec::new(),
            product: Vec::new(),
            work: Vec::new(),
        }
    }
}

/// The first `len` entries, of any content.
pub(super) fn room<T: Clone + Default>(buffer: &mut Vec<T>, len: usize) -> &mut [T] {
    if buffer.len() < len {
        // what a larger vector would copy is of no use
        *buffer = vec![T::default(); len];
    }
    &mut buffer[..len]
}

struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Pool<T> {
    fn lend(&self) -> Lent<'_, T> {
        let pooled = self.0.lock().ok().and_then(|mut pool| pool.pop());
        Lent {
            pool: self,
            value: pooled.unwrap_or_default(),
        }
    }
}

/// Goes back to its pool when it is dropped.
pub(super) struct Lent<'a, T: Default> {
    pool: &'a Pool<T>,
    value: T,
}

impl<T: Default> Deref for Lent<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T: Default> DerefMut for Lent<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}

impl<T: Default> Drop for Lent<'_, T> {
    fn drop(&mut self) {
        if let Ok(mut pool) = self.pool.0.lock() {
            pool.push(std::mem::take(&mut self.value));
        }
    }
}
