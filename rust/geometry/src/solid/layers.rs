// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_words::Rough;

use super::spaced;
use crate::Error;
use crate::error::out_of_range;

/// Of a body [`ACROSS`] elements wide, a rail [`ACROSS_RAIL`]: growth of a layer over the one before it, away
/// from the contact ...
const GROWTH: f64 = 1.7;
/// ... and the thickest layer in widths. Finer elements have thinner layers everywhere.
const THICKEST: f64 = 0.3;
/// Elements over the width of a body.
pub(super) const ACROSS: f64 = 10.0;
/// Elements over the width of the head of a rail.
pub(super) const ACROSS_RAIL: f64 = 20.0;

/// More layers than this are taken for a mistake.
const MOST_LAYERS: f64 = 1e6;

/// Places from 0 to `length` [m] of layers of elements, away from the contact of a body `width` [m] wide.
///
/// The first one is about `first` [m] thick. They grow with the distance, as what is local to the contact
/// fades, up to a share of the width: bending does not fade. Growth beyond 1 and thickest layer shrink with
/// the root of `first`: so each refinement refines all of the body, and an estimate made of two solutions
/// sees the errors of all of its layers.
pub(super) fn layers(
    first: f64,
    length: f64,
    width: f64,
    across: f64,
    least: usize,
) -> Result<Vec<f64>, Error> {
    let coarse = coarseness(first, width, across);
    let growth = 1.0 + (GROWTH - 1.0) * coarse;
    let thickest = first.max(THICKEST * width * coarse);
    // thickness first + (growth - 1) z: up to the thickest, `graded` layers
    let graded = (thickest / first).ln() / growth.ln();
    let end = (thickest - first) / (growth - 1.0);
    let count = if length <= end {
        ((growth - 1.0) * length / first).ln_1p() / growth.ln()
    } else {
        graded + (length - end) / thickest
    };
    if count.is_nan() || count > MOST_LAYERS {
        let accepted = format!(
            "it must be thick enough for {} layers at most",
            Rough(MOST_LAYERS)
        );
        return Err(out_of_range(
            "thickness of the first layer",
            first,
            accepted,
        ));
    }
    let places: Vec<f64> = spaced(0.0, count, least.max(count.round_ties_even() as usize) + 1)
        .into_iter()
        .map(|at| {
            let near = first * (growth.powf(at.min(graded)) - 1.0) / (growth - 1.0);
            near + thickest * (at - graded).max(0.0)
        })
        .collect();
    let scale = length / places[places.len() - 1];
    Ok(places.into_iter().map(|p| p * scale).collect())
}

/// How much thicker than those of a body `across` elements wide its layers far from the contact are.
pub(super) fn coarseness(first: f64, width: f64, across: f64) -> f64 {
    (across * first / width).sqrt()
}

/// Layers of a body from its contact to its top.
pub(super) fn heights(
    first: f64,
    height: f64,
    width: f64,
    halved: bool,
    clamped: bool,
) -> Result<Vec<f64>, Error> {
    if !halved {
        let mut places = layers(first, height, width, ACROSS, 2)?;
        if clamped {
            let n = places.len();
            places.insert(n - 1, (places[n - 2] + 2.0 * places[n - 1]) / 3.0);
        }
        return Ok(places);
    }
    let mut places = layers(first, 0.5 * height, width, ACROSS, 2)?;
    let n = places.len();
    let high = layers(
        places[n - 1] - places[n - 2],
        0.5 * height,
        width,
        ACROSS,
        2,
    )?;
    places.extend(high[1..].iter().map(|z| 0.5 * height + z));
    Ok(places)
}
