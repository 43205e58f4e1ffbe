// SPDX-License-Identifier: MIT OR Apache-2.0
/// Overwrites its second argument with the image of the first one, of the same length.
pub type Map = Box<dyn Fn(&[f64], &mut [f64]) + Send + Sync>;

/// A square linear map on vectors of `f64`.
pub trait LinearOperator: Send + Sync {
    /// Length of the vectors the map takes and returns.
    fn dim(&self) -> usize;

    /// Overwrites `y` with the image of `x`; both have length [`LinearOperator::dim`].
    fn apply(&self, x: &[f64], y: &mut [f64]);
}
