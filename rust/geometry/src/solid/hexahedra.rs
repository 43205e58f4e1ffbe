// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{EDGES, SolidMesh};
use crate::Error;

/// A curvilinear, right-handed grid of hexahedra, each to be cut into six tetrahedra.
#[derive(Clone, Debug)]
pub struct Hexahedra {
    /// Numbers of corners along the three directions, at least 2 each.
    pub shape: [usize; 3],
    /// The corners [m], the last direction fastest.
    pub corners: Vec<[f64; 3]>,
    /// Which hexahedra exist, the last direction fastest; all if this is `None`.
    pub keep: Option<Vec<bool>>,
    /// Columns and rows whose hexahedra are cut as seen in a mirror along the first and along the second
    /// direction. With one half flipped the mesh of a symmetric grid is symmetric.
    pub flipped: [Vec<bool>; 2],
    /// Whether edges get nodes in their middles.
    pub quadratic: bool,
    /// Where nodes, mid-side ones included, have true places; elsewhere they lie on straight edges.
    pub curved: Option<Curved>,
}

/// True places of nodes on a layer of a grid.
#[derive(Clone, Debug)]
pub struct Curved {
    /// The layer along the third direction.
    pub layer: usize,
    /// First row along the second direction of the doubled grid.
    pub first: usize,
    /// Rows of the doubled grid.
    pub rows: usize,
    /// Places [m] of all columns of the doubled grid, rows fastest.
    pub places: Vec<[f64; 3]>,
}

/// Node numbers at the places of the doubled grid.
#[derive(Clone, Debug)]
pub struct Places {
    /// Numbers of places along the three directions.
    pub shape: [usize; 3],
    /// Number of the node at each place, the last direction fastest; `None` where there is none.
    pub number: Vec<Option<usize>>,
}

/// The six tetrahedra of a hexahedron as walks from its first corner to its last: first direction, second
/// one, and whether the walk is right-handed.
const WALKS: [(usize, usize, bool); 6] = [
    (0, 1, true),
    (1, 2, true),
    (2, 0, true),
    (1, 0, false),
    (2, 1, false),
    (0, 2, false),
];

impl Hexahedra {
    /// Cuts the hexahedra: the mesh, without sets, and where its nodes are.
    ///
    /// # Errors
    /// [`Error::Length`] where an array does not fit the shape.
    pub fn tetrahedra(&self) -> Result<(SolidMesh, Places), Error> {
        self.check()?;
        let fine_shape = self.shape.map(|n| 2 * n - 1);
        let flat = |at: [usize; 3]| (at[0] * fine_shape[1] + at[1]) * fine_shape[2] + at[2];
        let fine = self.doubled(fine_shape);
        let [nx, ny, nz] = self.shape.map(|n| n - 1);
        let nodes_per_cell = if self.quadratic { 10 } else { 4 };
        let mut cells = Vec::new();
        for hex in 0..nx * ny * nz {
            if self.keep.as_ref().is_some_and(|keep| !keep[hex]) {
                continue;
            }
            let place = [hex / (ny * nz), hex / nz % ny, hex % nz];
            let flip = [self.flipped[0][place[0]], self.flipped[1][place[1]], false];
            // a mirror turns tetrahedra inside out
            let is_mirrored = flip[0] != flip[1];
            for (p, q, is_even) in WALKS {
                let mut walk = [[0_usize; 3]; 4];
                for (k, step) in walk.iter_mut().enumerate().skip(1) {
                    step[p] = 2;
                    if k > 1 {
                        step[q] = 2;
                    }
                    if k > 2 {
                        *step = [2; 3];
                    }
                }
                if !is_even {
                    walk.swap(1, 2);
                }
                if is_mirrored {
                    walk.swap(0, 1);
                }
                let mut put = |step: [usize; 3]| {
                    cells.push(flat(std::array::from_fn(|axis| {
                        let along = if flip[axis] {
                            2 - step[axis]
                        } else {
                            step[axis]
                        };
                        2 * place[axis] + along
                    })));
                };
                for step in walk {
                    put(step);
                }
                if self.quadratic {
                    for [a, b] in EDGES {
                        put(std::array::from_fn(|c| walk[a][c].midpoint(walk[b][c])));
                    }
                }
            }
        }
        let mut is_used = vec![false; fine.len()];
        for place in &cells {
            is_used[*place] = true;
        }
        let mut number = vec![None; fine.len()];
        let mut nodes = Vec::new();
        for (place, _) in is_used.iter().enumerate().filter(|(_, used)| **used) {
            number[place] = Some(nodes.len());
            nodes.push(fine[place]);
        }
        let cells = cells.iter().filter_map(|place| number[*place]).collect();
        let mesh = SolidMesh {
            nodes,
            cells,
            nodes_per_cell,
            sets: Vec::new(),
        };
        let shape = fine_shape;
        Ok((mesh, Places { shape, number }))
    }

    /// Places of the doubled grid: corners, middles between them, true places where they are given.
    fn doubled(&self, shape: [usize; 3]) -> Vec<[f64; 3]> {
        let mut fine = Vec::with_capacity(shape.iter().product());
        for i in 0..shape[0] {
            for j in 0..shape[1] {
                for k in 0..shape[2] {
                    let at = [i, j, k];
                    // every middle belongs to one edge of the six tetrahedra: from the first corner
                    // towards the last
                    let end = |is_last: bool| {
                        let [i, j, k] = std::array::from_fn(|axis| {
                            let (below, is_odd) = (at[axis] / 2, at[axis] % 2 == 1);
                            let flip = axis < 2 && is_odd && self.flipped[axis][below];
                            below + usize::from(is_odd && flip != is_last)
                        });
                        self.corners[(i * self.shape[1] + j) * self.shape[2] + k]
                    };
                    let (first, last) = (end(false), end(true));
                    fine.push(std::array::from_fn(|c| 0.5 * (first[c] + last[c])));
                }
            }
        }
        if let Some(curved) = &self.curved {
            for (n, place) in curved.places.iter().enumerate() {
                let (i, j) = (n / curved.rows, curved.first + n % curved.rows);
                fine[(i * shape[1] + j) * shape[2] + 2 * curved.layer] = *place;
            }
        }
        fine
    }

    fn check(&self) -> Result<(), Error> {
        let length = |name, found: usize, expected: usize| {
            let accepted = format!("a grid of {:?} corners needs {expected}", self.shape);
            (found == expected).then_some(()).ok_or(Error::Length {
                name,
                found,
                accepted,
            })
        };
        let [nx, ny, nz] = self.shape;
        if nx.min(ny).min(nz) < 2 {
            return Err(Error::Length {
                name: "corners",
                found: self.corners.len(),
                accepted: "a grid has at least 2 along each direction".to_owned(),
            });
        }
        length("corners", self.corners.len(), nx * ny * nz)?;
        length("flipped columns", self.flipped[0].len(), nx - 1)?;
        length("flipped rows", self.flipped[1].len(), ny - 1)?;
        if let Some(keep) = &self.keep {
            length("keep", keep.len(), (nx - 1) * (ny - 1) * (nz - 1))?;
        }
        if let Some(curved) = &self.curved {
            let within = curved.layer < nz && curved.first + curved.rows < 2 * ny;
            let expected = if within {
                (2 * nx - 1) * curved.rows
            } else {
                0
            };
            length("true places", curved.places.len(), expected)?;
        }
        Ok(())
    }
}

impl Places {
    /// Node numbers, rising, at the places that a test of (column, row, layer) picks.
    pub(super) fn set(&self, is_in: impl Fn([usize; 3]) -> bool) -> Vec<usize> {
        let [_, ny, nz] = self.shape;
        let at = |k: usize| [k / (ny * nz), k / nz % ny, k % nz];
        // nodes are numbered as the places are
        let numbers = self.number.iter().enumerate();
        numbers
            .filter(|(k, _)| is_in(at(*k)))
            .filter_map(|(_, number)| *number)
            .collect()
    }

    /// The sides of a box: contact, top, rear, front, right, left.
    pub(super) fn sides(&self) -> [(String, Vec<usize>); 6] {
        let last = self.shape.map(|n| n - 1);
        [
            ("contact", 2, 0),
            ("top", 2, last[2]),
            ("rear", 0, 0),
            ("front", 0, last[0]),
            ("right", 1, 0),
            ("left", 1, last[1]),
        ]
        .map(|(name, axis, at)| (name.to_owned(), self.set(|place| place[axis] == at)))
    }
}
