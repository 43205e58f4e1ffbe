// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the top of a block or of a pole is held.

use mtb_elasticity::tetra::{Hold, Support};
use mtb_geometry::solid::{Filling, SolidMesh, held_points, nearest_nodes};

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
        let placed = |place: &[f64; 3]| -> [f64; 3] {
            std::array::from_fn(|c| middle[c] + (0..3).map(|k| turn[c][k] * place[k]).sum::<f64>())
        };
        let nearest = |places: &[[f64; 3]]| {
            nearest_nodes(&mesh.nodes, &places.iter().map(placed).collect::<Vec<_>>())
        };
        let (on_top, at_back) = held_points(size, height);
        Ok(vec![
            Support {
                name: "top points".to_owned(),
                nodes: nearest(&on_top)?,
                hold: [Hold::Free, held, vertical],
            },
            Support {
                name: "back points".to_owned(),
                nodes: nearest(&at_back)?,
                hold: [held, Hold::Free, Hold::Free],
            },
        ])
    }
}
