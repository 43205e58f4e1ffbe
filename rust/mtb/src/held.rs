// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the top of a block or of a pole is held.

use mtb_elasticity::tetra::{Hold, Support};
use mtb_geometry::solid::{Filling, SolidMesh};

use crate::Error;

/// A ready way to hold the top of a block or of a pole [Steininger2025].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Held {
    /// The top keeps its place along x and y and moves along z: only the contact holds it there.
    #[default]
    DrivenTop,
    /// The top keeps its place.
    ClampedTop,
    /// Five points on top share one free displacement along z, four at the back hold it along x: single nodes
    /// that give way more the finer the elements are.
    Points,
    /// The same, the points on top fixed along z.
    FixedPoints,
}

/// Share of the size of a body by which a point of a support may miss the nearest node.
const REACH: f64 = 0.1;

impl Held {
    /// How a body that is held so is filled with elements.
    pub fn filling(self) -> Filling {
        Filling {
            halved: matches!(self, Self::Points | Self::FixedPoints),
            clamped: self == Self::ClampedTop,
            ..Filling::default()
        }
    }

    /// The supports of a body of `size` (along, across) [m] and `height` [m] that stands about `middle` and is
    /// turned by the matrix `turn`.
    pub(crate) fn supports(
        self,
        mesh: &SolidMesh,
        middle: [f64; 3],
        size: [f64; 2],
        height: f64,
        turn: [[f64; 3]; 3],
    ) -> Result<Vec<Support>, Error> {
        let held = Hold::Prescribed;
        let top = |hold| Support {
            name: "top".to_owned(),
            nodes: mesh.set("top").unwrap_or_default().to_vec(),
            hold,
        };
        let vertical = match self {
            Self::DrivenTop => return Ok(vec![top([held, held, Hold::Free])]),
            Self::ClampedTop => return Ok(vec![top([held; 3])]),
            Self::Points => Hold::Guided,
            Self::FixedPoints => held,
        };
        let at = |place: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|c| middle[c] + (0..3).map(|k| turn[c][k] * place[k]).sum::<f64>())
        };
        let nearest = |places: Vec<[f64; 3]>| {
            let found = places.into_iter().map(|place| nearest(mesh, at(place)));
            found.collect::<Result<Vec<_>, _>>()
        };
        let along = (-2..=2).map(|k| [0.2 * f64::from(k) * size[0], 0.0, height]);
        let across = [-0.375, -0.125, 0.125, 0.375];
        let across = across.map(|k| [-0.5 * size[0], k * size[1], 0.5 * height]);
        Ok(vec![
            Support {
                name: "top points".to_owned(),
                nodes: nearest(along.collect())?,
                hold: [Hold::Free, held, vertical],
            },
            Support {
                name: "back points".to_owned(),
                nodes: nearest(across.to_vec())?,
                hold: [held, Hold::Free, Hold::Free],
            },
        ])
    }
}

/// The node nearest to a place.
fn nearest(mesh: &SolidMesh, place: [f64; 3]) -> Result<usize, Error> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut best = (0, f64::INFINITY);
    for (number, node) in mesh.nodes.iter().enumerate() {
        let mut square = 0.0;
        for c in 0..3 {
            square += (node[c] - place[c]).powi(2);
            low[c] = low[c].min(node[c]);
            high[c] = high[c].max(node[c]);
        }
        if square < best.1 {
            best = (number, square);
        }
    }
    let size = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
    let distance = best.1.sqrt();
    if distance > REACH * size {
        return Err(Error::FarSupport { place, distance });
    }
    Ok(best.0)
}
