// SPDX-License-Identifier: MIT OR Apache-2.0
/// A square linear map on vectors of `f64`.
pub trait LinearOperator: Send + Sync {
    /// Length of the vectors the map takes and returns.
    fn dim(&self) -> usize;

    /// Overwrites `y` with the image of `x`; both have length [`LinearOperator::dim`].
    fn apply(&self, x: &[f64], y: &mut [f64]);
}
