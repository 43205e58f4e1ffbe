// SPDX-License-Identifier: MIT OR Apache-2.0
//! Solids filled with tetrahedra: blocks, pole shoes and rails that follow a contact grid.
//!
//! Each is a grid of hexahedra, cut into six tetrahedra each, symmetric where the body is: turning the
//! sliding direction round turns the solution round. Elements grow away from the contact.

mod block;
mod hexahedra;
mod layers;
mod middles;
mod outline;
mod pole;
mod rail;
mod section;
mod support;
#[cfg(test)]
mod tests;

pub use block::block;
pub use hexahedra::{Curved, Hexahedra, Places};
pub use outline::Outline;
pub use rail::{RailSection, rail_lines};
pub use section::{SectionMesh, rectangle_section};
pub use support::{held_points, nearest_nodes};

use crate::Error;

/// Unknown displacements that no factorisation within the limits of the solvers holds (8 GB).
const MOST_UNKNOWNS: f64 = 4e6;

/// Ends of the edges that carry the mid-side nodes 4 to 9 of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Tetrahedra with named sets of nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolidMesh {
    /// Nodes [m].
    pub nodes: Vec<[f64; 3]>,
    /// Node numbers of one tetrahedron after the other: corners, then the middles of the edges 01, 12, 02,
    /// 03, 13, 23 if there are any.
    pub cells: Vec<usize>,
    /// 4 or 10.
    pub nodes_per_cell: usize,
    /// Contact faces and sides, by name.
    pub sets: Vec<(String, Vec<usize>)>,
}

/// How a solid is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filling {
    /// Whether supports need nodes at half height.
    pub halved: bool,
    /// Whether all of the top is held: at its edge stress is singular, so there is one thin layer more.
    pub clamped: bool,
    /// The layers are those of a contact grid finer by this factor.
    pub thinner: f64,
    /// Whether edges have nodes in their middles.
    pub quadratic: bool,
}

impl Default for Filling {
    fn default() -> Self {
        Self {
            halved: false,
            clamped: false,
            thinner: 1.0,
            quadratic: true,
        }
    }
}

impl SolidMesh {
    /// The set of nodes of a name.
    pub fn set(&self, name: &str) -> Option<&[usize]> {
        let mut sets = self.sets.iter();
        sets.find(|(own, _)| own == name)
            .map(|(_, nodes)| nodes.as_slice())
    }

    /// The mesh seen in the mirror y = 0, its tetrahedra turned right side out again.
    #[must_use]
    pub fn mirrored(mut self) -> Self {
        for node in &mut self.nodes {
            node[1] = -node[1];
        }
        for cell in self.cells.chunks_exact_mut(self.nodes_per_cell) {
            cell.swap(0, 1);
            if let [_, _, _, _, _, b, c, d, e, _] = cell {
                std::mem::swap(b, c);
                std::mem::swap(d, e);
            }
        }
        self
    }

    /// The mesh rotated by a matrix and then shifted [m].
    #[must_use]
    pub fn moved(mut self, rotation: [[f64; 3]; 3], shift: [f64; 3]) -> Self {
        for node in &mut self.nodes {
            let from = *node;
            *node = std::array::from_fn(|i| {
                let row = rotation[i];
                row[0] * from[0] + row[1] * from[1] + row[2] * from[2] + shift[i]
            });
        }
        self
    }
}

/// Refuses a mesh of about so many tetrahedra before it is made, where factorising it would be refused.
///
/// # Errors
/// [`Error::TooManyTetrahedra`].
pub fn check_unknowns(tetrahedra: f64, quadratic: bool) -> Result<(), Error> {
    // four unknowns a tetrahedron of 10 nodes, half an unknown one of 4
    let unknowns = tetrahedra * if quadratic { 4.0 } else { 0.5 };
    if unknowns > MOST_UNKNOWNS {
        return Err(Error::TooManyTetrahedra {
            tetrahedra,
            unknowns,
            most: MOST_UNKNOWNS,
        });
    }
    Ok(())
}

/// Checks that stations rise.
fn rising(name: &'static str, stations: &[f64]) -> Result<(), Error> {
    let finite = stations.iter().all(|s| s.is_finite());
    if stations.len() < 2 || !finite || stations.windows(2).any(|w| w[1] <= w[0]) {
        return Err(Error::NotRising { name });
    }
    Ok(())
}

/// Stations with one in the middle if they are symmetric, and which of their cells lie beyond it.
///
/// A cell across the middle cannot be cut into six tetrahedra that are their own mirror image.
fn symmetric(stations: &[f64]) -> (Vec<f64>, Vec<bool>) {
    let (first, last) = (stations[0], stations[stations.len() - 1]);
    let middle = 0.5 * (first + last);
    let mut places = stations.to_vec();
    let pairs = stations.iter().zip(stations.iter().rev());
    let off = pairs
        .map(|(a, b)| (a + b - 2.0 * middle).abs())
        .fold(0.0, f64::max);
    if off <= 1e-9 * (last - first) {
        if places.len().is_multiple_of(2) {
            places.insert(places.len() / 2, middle);
        }
        // what is symmetric but for rounding becomes so
        let from: Vec<f64> = places.iter().map(|s| s - middle).collect();
        let both = from.iter().zip(from.iter().rev());
        places = both.map(|(a, b)| middle + 0.5 * (a - b)).collect();
    }
    let beyond = places
        .windows(2)
        .map(|w| 0.5 * (w[1] + w[0]) > middle)
        .collect();
    (places, beyond)
}

/// Steps between stations.
fn steps(stations: &[f64]) -> impl Iterator<Item = f64> {
    stations.windows(2).map(|w| w[1] - w[0])
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

fn extent(stations: &[f64]) -> f64 {
    stations[stations.len() - 1] - stations[0]
}

/// `count` evenly spaced numbers, ends included; one alone is the start.
fn spaced(start: f64, end: f64, count: usize) -> Vec<f64> {
    if count < 2 {
        return vec![start; count];
    }
    let step = (end - start) / (count - 1) as f64;
    let mut places: Vec<f64> = (0..count).map(|i| i as f64 * step + start).collect();
    places[count - 1] = end;
    places
}

/// Stations with their middles between them.
fn doubled(stations: &[f64]) -> Vec<f64> {
    let mut fine = Vec::with_capacity(2 * stations.len());
    for pair in stations.windows(2) {
        fine.extend([pair[0], 0.5 * (pair[1] + pair[0])]);
    }
    fine.extend(stations.last());
    fine
}
