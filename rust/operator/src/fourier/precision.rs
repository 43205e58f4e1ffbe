// SPDX-License-Identifier: MIT OR Apache-2.0
//! Precision of the numbers inside a transform.

use rustfft::FftNum;

use super::buffers::{Buffers, Pools};
use crate::wide::wide;

/// Numbers that a transform calculates with: `f64`, or `f32`. Fields are `f64` either way.
pub trait Precision: sealed::Numbers {}

impl Precision for f64 {}
impl Precision for f32 {}

pub(super) mod sealed {
    use super::{Buffers, FftNum, Pools};

    pub trait Numbers: FftNum + Default {
        /// Factor by which numbers of at most this `size` are multiplied, so that none is out of range.
        fn factor(size: f64) -> f64;

        /// [`Numbers::factor`] of fields.
        fn factor_of(fields: &[&[f64]]) -> f64;

        /// `v` times a factor that [`Numbers::factor`] gave.
        fn of(v: f64, factor: f64) -> Self;

        fn wide(self) -> f64;

        fn pools(buffers: &Buffers) -> &Pools<Self>;
    }
}

impl sealed::Numbers for f64 {
    fn factor(_: f64) -> f64 {
        1.0
    }

    fn factor_of(_: &[&[f64]]) -> f64 {
        1.0
    }

    #[inline]
    fn of(v: f64, _: f64) -> Self {
        v
    }

    #[inline]
    fn wide(self) -> f64 {
        self
    }

    fn pools(buffers: &Buffers) -> &Pools<Self> {
        &buffers.double
    }
}

impl sealed::Numbers for f32 {
    fn factor(size: f64) -> f64 {
        1.0 / size.max(f64::MIN_POSITIVE)
    }

    fn factor_of(fields: &[&[f64]]) -> f64 {
        Self::factor(fields.iter().map(|x| largest(x)).fold(0.0, f64::max))
    }

    #[inline]
    fn of(v: f64, factor: f64) -> Self {
        (v * factor) as Self
    }

    #[inline]
    fn wide(self) -> f64 {
        self.into()
    }

    fn pools(buffers: &Buffers) -> &Pools<Self> {
        &buffers.single
    }
}

/// Largest magnitude of a field; numbers that are none count as nothing.
fn largest(field: &[f64]) -> f64 {
    wide(
        #[inline(always)]
        || {
            let mut most = [0.0_f64; 8];
            let (eights, rest) = field.as_chunks::<8>();
            for eight in eights {
                for (most, v) in most.iter_mut().zip(eight) {
                    *most = if v.abs() > *most { v.abs() } else { *most };
                }
            }
            rest.iter()
                .fold(most.into_iter().fold(0.0, f64::max), |most, v| {
                    most.max(v.abs())
                })
        },
    )
}
