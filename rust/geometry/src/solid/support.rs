// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where bodies are held.

use crate::Error;

/// Share of the size of a body by which a point of a support may miss the nearest node.
const REACH: f64 = 0.1;

/// Points at which a block or a pole of `size` (along, across) [m] and `height` [m], with the middle of its foot at
/// the origin, is held: five along the middle of its top, four across its back at half its height
/// [Steininger2025, Fig. 4.4].
pub fn held_points(size: [f64; 2], height: f64) -> ([[f64; 3]; 5], [[f64; 3]; 4]) {
    let top = [-0.4, -0.2, 0.0, 0.2, 0.4].map(|k| [k * size[0], 0.0, height]);
    let back = [-0.375, -0.125, 0.125, 0.375];
    (
        top,
        back.map(|k| [-0.5 * size[0], k * size[1], 0.5 * height]),
    )
}

/// Numbers of the nodes that are nearest to places [m].
///
/// # Errors
/// [`Error::FarNode`] for a place beside the body.
pub fn nearest_nodes(nodes: &[[f64; 3]], places: &[[f64; 3]]) -> Result<Vec<usize>, Error> {
    let extent = |c: usize| {
        let (low, high) = nodes
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), node| {
                (low.min(node[c]), high.max(node[c]))
            });
        high - low
    };
    let size = (0..3).map(extent).fold(0.0, f64::max);
    let nearest = |place: &[f64; 3]| {
        let square = |node: &[f64; 3]| (0..3).map(|c| (node[c] - place[c]).powi(2)).sum::<f64>();
        let squares = nodes.iter().map(square).enumerate();
        let (best, square) = squares
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, f64::INFINITY));
        let distance = square.sqrt();
        if distance > REACH * size {
            return Err(Error::FarNode {
                place: *place,
                distance,
            });
        }
        Ok(best)
    };
    places.iter().map(nearest).collect()
}
