// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fields of the nodes at any points of a body.

use rayon::prelude::*;

use super::mesh::{EDGES, TetraMesh};
use crate::Error;

/// By how much a barycentric coordinate may be negative at a point that still counts as inside: what a curved surface
/// stands out from its facets.
const BEYOND: f64 = 0.1;

/// Tetrahedra by cells of a regular grid over the body.
struct Bins {
    low: [f64; 3],
    size: [f64; 3],
    counts: [usize; 3],
    start: Vec<usize>,
    tets: Vec<usize>,
}

impl Bins {
    fn new(boxes: &[[[f64; 3]; 2]]) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for [from, to] in boxes {
            for k in 0..3 {
                low[k] = low[k].min(from[k]);
                high[k] = high[k].max(to[k]);
            }
        }
        // as many bins as tetrahedra, about as wide along each axis
        let extent: [f64; 3] = std::array::from_fn(|k| (high[k] - low[k]).max(f64::MIN_POSITIVE));
        let side = (extent.iter().product::<f64>() / boxes.len() as f64).cbrt();
        let counts = extent.map(|e| ((e / side) as usize).clamp(1, 200));
        let size = std::array::from_fn(|k| extent[k] / counts[k] as f64);
        let mut bins = Self {
            low,
            size,
            counts,
            start: vec![0; counts.iter().product::<usize>() + 1],
            tets: Vec::new(),
        };
        for [from, to] in boxes {
            for bin in bins.over(*from, *to) {
                bins.start[bin + 1] += 1;
            }
        }
        for k in 1..bins.start.len() {
            bins.start[k] += bins.start[k - 1];
        }
        let mut next = bins.start.clone();
        let mut tets = vec![0; bins.start[bins.start.len() - 1]];
        for (tet, [from, to]) in boxes.iter().enumerate() {
            for bin in bins.over(*from, *to) {
                tets[next[bin]] = tet;
                next[bin] += 1;
            }
        }
        bins.tets = tets;
        bins
    }

    fn place(&self, x: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|k| {
            (((x[k] - self.low[k]) / self.size[k]).max(0.0) as usize).min(self.counts[k] - 1)
        })
    }

    /// Bins that a box meets.
    fn over(&self, from: [f64; 3], to: [f64; 3]) -> Vec<usize> {
        let (a, b) = (self.place(from), self.place(to));
        let [nx, ny, _] = self.counts;
        (a[2]..=b[2])
            .flat_map(|k| (a[1]..=b[1]).map(move |j| (j, k)))
            .flat_map(|(j, k)| (a[0]..=b[0]).map(move |i| i + nx * (j + ny * k)))
            .collect()
    }

    /// Tetrahedra that may hold a point.
    fn near(&self, x: [f64; 3]) -> &[usize] {
        let [i, j, k] = self.place(x);
        let bin = i + self.counts[0] * (j + self.counts[1] * k);
        &self.tets[self.start[bin]..self.start[bin + 1]]
    }
}

impl TetraMesh {
    /// Fields of the nodes, component by component (`components` times N), at points (n), component by component:
    /// by the shape functions of the tetrahedra around them.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], and [`Error::NotInside`] for a point that is in no tetrahedron. What a
    /// tenth of an element reaches beyond the surface counts as on it.
    pub fn at_points(&self, values: &[f64], points: &[[f64; 3]]) -> Result<Vec<f64>, Error> {
        let nodes = self.nodes();
        if values.is_empty() || !values.len().is_multiple_of(nodes.len()) {
            return Err(Error::Shape {
                name: "values",
                found: values.len(),
                expected: nodes.len(),
            });
        }
        if let Some(index) = points.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            return Err(Error::NotFinite {
                name: "point",
                index,
            });
        }
        let boxes: Vec<[[f64; 3]; 2]> = (0..self.n_tets())
            .map(|tet| {
                let corners = [0, 1, 2, 3].map(|a| nodes[self.cell(tet)[a]]);
                let bound = |pick: fn(f64, f64) -> f64| {
                    std::array::from_fn(|k| {
                        corners.iter().map(|x| x[k]).reduce(pick).unwrap_or(0.0)
                    })
                };
                let (low, high): ([f64; 3], [f64; 3]) = (bound(f64::min), bound(f64::max));
                let room: f64 = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
                [
                    low.map(|v| v - BEYOND * room),
                    high.map(|v| v + BEYOND * room),
                ]
            })
            .collect();
        let bins = Bins::new(&boxes);
        let components = values.len() / nodes.len();
        let found: Vec<Option<Vec<f64>>> = points
            .par_iter()
            .map(|x| {
                let best = bins
                    .near(*x)
                    .iter()
                    .map(|tet| (*tet, self.barycentric(*tet, *x)))
                    .map(|(tet, l)| (tet, l, l.into_iter().fold(f64::INFINITY, f64::min)))
                    .max_by(|a, b| a.2.total_cmp(&b.2))
                    .filter(|(.., least)| *least >= -BEYOND)?;
                let weights = shapes(best.1, self.cell(best.0).len());
                let at = |k: usize| -> f64 {
                    let own = self.cell(best.0).iter().zip(&weights);
                    own.map(|(node, w)| w * values[k * nodes.len() + node])
                        .sum()
                };
                Some((0..components).map(at).collect())
            })
            .collect();
        let mut sampled = vec![0.0; components * points.len()];
        for (index, values) in found.into_iter().enumerate() {
            for (k, value) in values
                .ok_or(Error::NotInside(index))?
                .into_iter()
                .enumerate()
            {
                sampled[k * points.len() + index] = value;
            }
        }
        Ok(sampled)
    }

    fn barycentric(&self, tet: usize, x: [f64; 3]) -> [f64; 4] {
        let cell = self.cell(tet);
        let origin = self.nodes()[cell[0]];
        let from = |a: [f64; 3]| [0, 1, 2].map(|k| a[k] - origin[k]);
        let edges = [1, 2, 3].map(|a| from(self.nodes()[cell[a]]));
        let p = from(x);
        let triple = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        };
        let [a, b, c] = edges;
        let whole = triple(a, b, c);
        let (u, v, w) = (
            triple(p, b, c) / whole,
            triple(a, p, c) / whole,
            triple(a, b, p) / whole,
        );
        [1.0 - u - v - w, u, v, w]
    }
}

/// Shape functions of a tetrahedron of 4 or 10 nodes.
fn shapes(l: [f64; 4], nodes: usize) -> Vec<f64> {
    if nodes == 4 {
        return l.to_vec();
    }
    let corners = l.iter().map(|l| l * (2.0 * l - 1.0));
    let middles = EDGES.iter().map(|[a, b]| 4.0 * l[*a] * l[*b]);
    corners.chain(middles).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Order;
    use super::*;

    /// A cube of side 2 about the origin, in six tetrahedra, with quadratic nodes if asked.
    fn cube(order: Order) -> TetraMesh {
        let mut nodes: Vec<[f64; 3]> = (0..8)
            .map(|k| [0, 1, 2].map(|a| if k >> a & 1 == 1 { 1.0 } else { -1.0 }))
            .collect();
        let mut cells = Vec::new();
        for (a, b) in [(1, 2), (2, 4), (4, 1), (2, 1), (4, 2), (1, 4)] {
            let mut corners = vec![0, a, a + b, 7];
            let is_right = matches!((a, b), (1, 2) | (2, 4) | (4, 1));
            if !is_right {
                corners.swap(1, 2);
            }
            if order == Order::Quadratic {
                for [i, j] in EDGES {
                    let (p, q) = (nodes[corners[i]], nodes[corners[j]]);
                    let middle = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
                    let known = nodes.iter().position(|x| *x == middle);
                    corners.push(known.unwrap_or(nodes.len()));
                    if known.is_none() {
                        nodes.push(middle);
                    }
                }
            }
            cells.extend(corners);
        }
        TetraMesh::new(nodes, cells, order).expect("a cube")
    }

    #[test]
    fn polynomials_of_the_elements_are_met() {
        for order in [Order::Linear, Order::Quadratic] {
            let mesh = cube(order);
            let square = if order == Order::Linear { 0.0 } else { 1.0 };
            let field = |x: &[f64; 3]| 2.0 + x[0] - 3.0 * x[2] + square * x[1] * (x[0] - x[1]);
            let mut values: Vec<f64> = mesh.nodes().iter().map(field).collect();
            values.extend(mesh.nodes().iter().map(|x| x[1]));
            let points = [
                [0.1, 0.2, -0.9],
                [1.0, -1.0, 0.3],
                [-0.4, 0.8, 0.8],
                [0.0, 0.0, 0.0],
            ];
            let found = mesh.at_points(&values, &points).expect("inside");
            for (k, x) in points.iter().enumerate() {
                assert!((found[k] - field(x)).abs() < 1e-13, "{order:?} {x:?}");
                assert!((found[points.len() + k] - x[1]).abs() < 1e-13);
            }
            let outside = mesh.at_points(&values, &[points[0], [1.5, 0.0, 0.0]]);
            assert_eq!(outside, Err(Error::NotInside(1)));
            assert!(mesh.at_points(&values[1..], &points).is_err());
            assert!(mesh.at_points(&values, &[[f64::NAN, 0.0, 0.0]]).is_err());
        }
    }
}
