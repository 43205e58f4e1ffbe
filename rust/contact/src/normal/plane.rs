// SPDX-License-Identifier: MIT OR Apache-2.0
//! A plane gap over a period, in closed form.

use mtb_complementarity::bounded::Status;

use super::{Load, Method, NormalContact, NormalSolution, Surface};

/// Residual that is asked for where none is given: that of the closed form is zero.
const TOLERANCE: f64 = 1e-8;

/// The pressure that all cells carry alike, where the gap is plane and repeats itself; `None` elsewhere, and with a
/// rough layer, which gives way by itself.
///
/// It moves all cells alike, so that both methods would be left with displacements that are nothing but rounding, and
/// would judge them by themselves.
pub(super) fn solve(
    contact: &NormalContact<'_>,
    method: Method,
    tolerance: Option<f64>,
) -> Option<NormalSolution> {
    let (Surface::Periodic(wave), Load::Force(force)) = (contact.surface, contact.load) else {
        return None;
    };
    let height = contact.gap[0];
    let is_plane = contact.gap.iter().all(|g| *g == height);
    if !is_plane || contact.moments != [None, None] || contact.rough.is_some() {
        return None;
    }
    let n = contact.grid.points();
    let pressure = force / contact.grid.cell_area() / n as f64;
    Some(NormalSolution {
        status: Status::Solved,
        method,
        pressure: vec![pressure; n],
        gap: vec![0.0; n],
        approach: height + wave(0.0) * pressure,
        tilts: [0.0; 2],
        iterations: 0,
        products: 0.0,
        preconditionings: 0.0,
        residual: 0.0,
        tolerance: tolerance.unwrap_or(TOLERANCE),
        history: vec![0.0],
        discretisation_error: Some(0.0),
    })
}
