// SPDX-License-Identifier: MIT OR Apache-2.0
//! Loops over long fields by the widest instructions of the processor.

use pulp::Arch;

/// Does `work` by the widest instructions that this processor has; elsewhere the compiler takes the oldest processor
/// of its kind for granted.
///
/// For plain loops over slices. What `work` calls must be inlined into it (`#[inline(always)]`, on the closure too), as
/// it keeps its own instructions otherwise. Results are the same on all processors, bit for bit: nothing is fused, and
/// nothing put in another order.
#[inline]
pub fn wide<R>(work: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(work)
}
