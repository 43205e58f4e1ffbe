// SPDX-License-Identifier: MIT OR Apache-2.0
use faer::Spec;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, Par, Side};

use super::{Foot, Section};
use crate::{Error, Material};

/// Barycentric points and weights of the rule of degree 4 on triangles [Hughes2000].
const NEAR_CORNER: (f64, f64) = (0.091_576_213_509_770_74, 0.109_951_743_655_321_87);
/// The other three points.
const NEAR_SIDE: (f64, f64) = (0.445_948_490_915_965, 0.223_381_589_678_011_47);
/// Gauss' rule of four points on [-1, 1].
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// Load on unknowns: number and value.
pub(super) type Sparse = Vec<(usize, f64)>;

/// A point of an edge of six-node triangles: values of its three nodes, tangent (unit), length of a unit of weight.
pub(super) struct EdgePoint {
    pub(super) value: [f64; 3],
    pub(super) tangent: [f64; 2],
    pub(super) length: f64,
    /// Along the edge, from 0 to 1.
    pub(super) share: f64,
}

/// Stiffness of a section as a polynomial of the wave number, on its unknowns.
pub struct Prism {
    material: Material,
    nodes: Vec<[f64; 2]>,
    /// First unknown of each node; none where it is held.
    unknown: Vec<Option<usize>>,
    start: Vec<usize>,
    row: Vec<usize>,
    /// Lower triangle of `K0`, `K1`, `K2`, columns one after the other.
    values: [Vec<f64>; 3],
    symbolic: SymbolicCholesky<usize>,
    slowest: f64,
}

impl Prism {
    /// The prism of an infinitely long section.
    ///
    /// # Errors
    /// [`Error::Material`], [`Error::Incompressible`], [`Error::Index`], [`Error::Section`] for triangles turned inside
    /// out, a base without edges and springs that are not stiff.
    pub fn new(material: Material, section: &Section, foot: Foot) -> Result<Self, Error> {
        let material = Material::new(material.shear_modulus, material.poisson_ratio)?;
        let nu = material.poisson_ratio;
        if nu >= 0.5 {
            return Err(Error::Incompressible(nu));
        }
        let count = section.nodes.len();
        let used = section
            .triangles
            .iter()
            .flatten()
            .chain(section.base.iter().flatten());
        for (index, &value) in used.enumerate() {
            if value >= count {
                return Err(Error::Index {
                    name: "node of the section",
                    index,
                    what: "node",
                    value,
                    count,
                });
            }
        }
        if section.base.is_empty() {
            return Err(Error::Section("its base has no edge, and nothing holds it"));
        }
        let mut is_held = vec![true; count];
        for node in section.triangles.iter().flatten() {
            is_held[*node] = false;
        }
        if let Foot::Pads { vertical, lateral } = foot {
            if ![vertical, lateral]
                .iter()
                .all(|s| s.is_finite() && *s > 0.0)
            {
                return Err(Error::Section(
                    "its foundation needs positive, finite stiffnesses",
                ));
            }
        } else {
            for node in section.base.iter().flatten() {
                is_held[*node] = true;
            }
        }
        let mut next = 0;
        let unknown: Vec<Option<usize>> = is_held
            .iter()
            .map(|held| {
                let first = (!held).then_some(next);
                next += if *held { 0 } else { 3 };
                first
            })
            .collect();
        let (start, row) = pattern(section, &unknown, next);
        let mut prism = Self {
            material,
            nodes: section.nodes.clone(),
            unknown,
            values: [0, 1, 2].map(|_| vec![0.0; row.len()]),
            symbolic: analysed(next, &start, &row)?,
            start,
            row,
            slowest: 0.0,
        };
        let mut moments = Moments::default();
        for triangle in &section.triangles {
            prism.add_element(triangle, &mut moments)?;
        }
        if let Foot::Pads { vertical, lateral } = foot {
            prism.add_pads(&section.base, vertical, lateral);
        }
        prism.slowest = prism.slowest_wave(foot, &moments);
        Ok(prism)
    }

    /// Its material.
    pub fn material(&self) -> Material {
        self.material
    }

    /// Unknown displacements of the section.
    pub fn unknowns(&self) -> usize {
        self.start.len() - 1
    }

    /// Wave number [1/m] below which the compliance varies only as the logarithm of a half-space does.
    pub(super) fn slowest(&self) -> f64 {
        self.slowest
    }

    /// `F^T K(k)^-1 F` [m/Pa times the squared units of the loads] of loads per length at a wave number [1/m], columns
    /// as rows. Along x a load is the amplitude `b` of `q_x = i b`, and a displacement that of `u_x = i a`.
    ///
    /// # Errors
    /// [`Error::Section`] where the prism is not held, or where memory is short.
    pub(super) fn compliance(&self, wave_number: f64, loads: &[Sparse]) -> Result<Mat<f64>, Error> {
        let k = wave_number;
        let [k0, k1, k2] = &self.values;
        let values: Vec<f64> = (0..k0.len())
            .map(|i| k0[i] + k * (k1[i] + k * k2[i]))
            .collect();
        let n = self.unknowns();
        let structure = SymbolicSparseColMatRef::new_checked(n, n, &self.start, None, &self.row);
        let matrix = SparseColMatRef::new(structure, &values);
        let memory = |_| Error::Section("there is too little memory for its factor");
        let request = self
            .symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
            .or(self
                .symbolic
                .solve_in_place_scratch::<f64>(loads.len(), Par::Seq));
        let mut buffer = MemBuffer::try_new(request).map_err(memory)?;
        let stack = MemStack::new(&mut buffer);
        let mut factor = vec![0.0; self.symbolic.len_val()];
        let factor = self
            .symbolic
            .factorize_numeric_llt(
                &mut factor,
                matrix,
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                stack,
                Spec::default(),
            )
            .map_err(|_| Error::Section("nothing holds it, or its triangles are degenerate"))?;
        let mut moved = Mat::zeros(n, loads.len());
        for (column, load) in loads.iter().enumerate() {
            for (unknown, value) in load {
                moved[(*unknown, column)] += value;
            }
        }
        factor.solve_in_place_with_conj(Conj::No, moved.as_mut(), Par::Seq, stack);
        let mut seen = Mat::zeros(loads.len(), loads.len());
        for (i, load) in loads.iter().enumerate() {
            for j in 0..loads.len() {
                seen[(i, j)] = load.iter().map(|(u, value)| value * moved[(*u, j)]).sum();
            }
        }
        Ok(seen)
    }

    /// Unknown of a displacement along x, y or z of a node.
    pub(super) fn unknown(&self, node: usize, component: usize) -> Option<usize> {
        self.unknown[node].map(|first| first + component)
    }

    /// Where a node is.
    pub(super) fn place(&self, node: usize) -> Result<[f64; 2], Error> {
        let count = self.nodes.len();
        let name = "node of the surface of a prism";
        let missing = Error::Index {
            name,
            index: 0,
            what: "node",
            value: node,
            count,
        };
        self.nodes.get(node).copied().ok_or(missing)
    }

    /// Quadrature points of an edge.
    pub(super) fn edge_points(&self, edge: &[usize; 3]) -> Result<[EdgePoint; 4], Error> {
        let mut at = [[0.0; 2]; 3];
        for (at, node) in at.iter_mut().zip(edge) {
            *at = self.place(*node)?;
        }
        Ok(GAUSS.map(|(s, weight)| {
            let value = [0.5 * s * (s - 1.0), 0.5 * s * (s + 1.0), 1.0 - s * s];
            let slope = [s - 0.5, s + 0.5, -2.0 * s];
            let along: [f64; 2] =
                std::array::from_fn(|c| slope.iter().zip(&at).map(|(d, p)| d * p[c]).sum());
            let size = along[0].hypot(along[1]);
            EdgePoint {
                value,
                tangent: along.map(|a| a / size),
                length: size * weight,
                share: 0.5 * (1.0 + s),
            }
        }))
    }

    fn add(&mut self, power: usize, unknowns: [Option<usize>; 2], value: f64) {
        let [Some(row), Some(column)] = unknowns else {
            return;
        };
        if row < column {
            return;
        }
        let range = self.start[column]..self.start[column + 1];
        if let Ok(at) = self.row[range.clone()].binary_search(&row) {
            self.values[power][range.start + at] += value;
        }
    }

    fn add_element(&mut self, triangle: &[usize; 6], moments: &mut Moments) -> Result<(), Error> {
        let places = triangle.map(|n| self.nodes[n]);
        let g = self.material.shear_modulus;
        let nu = self.material.poisson_ratio;
        let lame = 2.0 * g * nu / (1.0 - 2.0 * nu);
        // strains xx, yy, zz, yz, xy, xz; `B = B0 + k B1`
        let mut stiffness = [[[0.0; 18]; 18]; 3];
        for (point, weight) in rule() {
            let (value, by) = shape(point);
            let jacobian: [[f64; 2]; 2] = std::array::from_fn(|r| {
                std::array::from_fn(|c| by.iter().zip(&places).map(|(d, p)| d[r] * p[c]).sum())
            });
            let det = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
            if det.is_nan() || det <= 0.0 {
                return Err(Error::Section("a triangle is turned inside out"));
            }
            let area = 0.5 * weight * det;
            let mut strains = [[[0.0; 6]; 18]; 2];
            let mut place = [0.0; 2];
            for n in 0..6 {
                let [r, s] = by[n];
                let dy = (jacobian[1][1] * r - jacobian[0][1] * s) / det;
                let dz = (jacobian[0][0] * s - jacobian[1][0] * r) / det;
                let v = value[n];
                strains[0][3 * n] = [0.0, 0.0, 0.0, 0.0, dy, dz];
                strains[1][3 * n] = [-v, 0.0, 0.0, 0.0, 0.0, 0.0];
                strains[0][3 * n + 1] = [0.0, dy, 0.0, dz, 0.0, 0.0];
                strains[1][3 * n + 1] = [0.0, 0.0, 0.0, 0.0, v, 0.0];
                strains[0][3 * n + 2] = [0.0, 0.0, dz, dy, 0.0, 0.0];
                strains[1][3 * n + 2] = [0.0, 0.0, 0.0, 0.0, 0.0, v];
                place = [place[0] + v * places[n][0], place[1] + v * places[n][1]];
            }
            moments.add(area, place);
            let stressed = |e: &[f64; 6]| {
                let mean = lame * (e[0] + e[1] + e[2]);
                let shear = [e[3], e[4], e[5]].map(|s| g * s);
                [
                    mean + 2.0 * g * e[0],
                    mean + 2.0 * g * e[1],
                    mean + 2.0 * g * e[2],
                    shear[0],
                    shear[1],
                    shear[2],
                ]
            };
            let stress = strains.map(|by| by.map(|e| stressed(&e)));
            for a in 0..2 {
                for b in 0..2 {
                    for i in 0..18 {
                        for j in 0..18 {
                            let work: f64 = strains[a][i]
                                .iter()
                                .zip(&stress[b][j])
                                .map(|(e, s)| e * s)
                                .sum();
                            stiffness[a + b][i][j] += area * work;
                        }
                    }
                }
            }
        }
        for (power, matrix) in stiffness.iter().enumerate() {
            for (i, row) in matrix.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    let pair = [i, j].map(|k| self.unknown(triangle[k / 3], k % 3));
                    self.add(power, pair, *value);
                }
            }
        }
        Ok(())
    }

    fn add_pads(&mut self, base: &[[usize; 3]], vertical: f64, lateral: f64) {
        let points: Vec<([usize; 3], [EdgePoint; 4])> = base
            .iter()
            .filter_map(|edge| Some((*edge, self.edge_points(edge).ok()?)))
            .collect();
        let width: f64 = points.iter().flat_map(|(_, p)| p).map(|p| p.length).sum();
        for (edge, points) in &points {
            for point in points {
                for (a, va) in edge.iter().zip(point.value) {
                    for (b, vb) in edge.iter().zip(point.value) {
                        for (component, stiffness) in
                            [lateral, lateral, vertical].iter().enumerate()
                        {
                            let pair = [*a, *b].map(|n| self.unknown(n, component));
                            self.add(0, pair, stiffness / width * point.length * va * vb);
                        }
                    }
                }
            }
        }
    }

    /// A quarter of the wave number of bending on the foundation, and none that is long against the section.
    fn slowest_wave(&self, foot: Foot, moments: &Moments) -> f64 {
        let size = |c: usize| {
            let all = self.nodes.iter().map(|n| n[c]);
            all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
        };
        let local = 0.25 / size(0).max(size(1));
        let Foot::Pads { vertical, lateral } = foot else {
            return local;
        };
        let young = 2.0 * self.material.shear_modulus * (1.0 + self.material.poisson_ratio);
        let [lying, standing] = moments.central();
        let wave = |stiffness: f64, inertia: f64| (stiffness / (young * inertia)).powf(0.25);
        let along = (lateral / (young * moments.area)).sqrt();
        0.25 * wave(vertical, standing)
            .min(wave(lateral, lying))
            .min(along)
            .min(4.0 * local)
    }
}

/// Moments of a section.
#[derive(Default)]
struct Moments {
    area: f64,
    first: [f64; 2],
    second: [f64; 2],
}

impl Moments {
    fn add(&mut self, area: f64, place: [f64; 2]) {
        self.area += area;
        for (c, at) in place.iter().enumerate() {
            self.first[c] += area * at;
            self.second[c] += area * at * at;
        }
    }

    /// Of y^2 and of z^2 about the centre [m4].
    fn central(&self) -> [f64; 2] {
        [0, 1].map(|c| self.second[c] - self.first[c].powi(2) / self.area)
    }
}

/// Points (first and second barycentric coordinate) and weights of the rule on triangles.
fn rule() -> impl Iterator<Item = ([f64; 2], f64)> {
    [NEAR_CORNER, NEAR_SIDE]
        .into_iter()
        .flat_map(|(a, weight)| {
            let b = 1.0 - 2.0 * a;
            [[a, a], [a, b], [b, a]].map(|point| (point, weight))
        })
}

/// Values and slopes of the six shape functions.
fn shape([r, s]: [f64; 2]) -> ([f64; 6], [[f64; 2]; 6]) {
    let t = 1.0 - r - s;
    (
        [
            t * (2.0 * t - 1.0),
            r * (2.0 * r - 1.0),
            s * (2.0 * s - 1.0),
            4.0 * t * r,
            4.0 * r * s,
            4.0 * s * t,
        ],
        [
            [1.0 - 4.0 * t, 1.0 - 4.0 * t],
            [4.0 * r - 1.0, 0.0],
            [0.0, 4.0 * s - 1.0],
            [4.0 * (t - r), -4.0 * r],
            [4.0 * s, 4.0 * r],
            [-4.0 * s, 4.0 * (t - s)],
        ],
    )
}

/// Columns of the lower triangle.
fn pattern(section: &Section, unknown: &[Option<usize>], count: usize) -> (Vec<usize>, Vec<usize>) {
    let mut beside: Vec<Vec<usize>> = vec![Vec::new(); count / 3];
    for triangle in &section.triangles {
        let own = triangle.iter().filter_map(|n| unknown[*n]);
        for a in own.clone() {
            beside[a / 3].extend(own.clone().filter(|b| *b >= a));
        }
    }
    let (mut start, mut row) = (vec![0], Vec::new());
    for (node, beside) in beside.iter_mut().enumerate() {
        beside.sort_unstable();
        beside.dedup();
        for component in 0..3 {
            let own = 3 * node + component;
            let below = beside.iter().flat_map(|b| [*b, b + 1, b + 2]);
            row.extend(below.filter(|r| *r >= own));
            start.push(row.len());
        }
    }
    (start, row)
}

fn analysed(n: usize, start: &[usize], row: &[usize]) -> Result<SymbolicCholesky<usize>, Error> {
    factorize_symbolic_cholesky(
        SymbolicSparseColMatRef::new_checked(n, n, start, None, row),
        Side::Lower,
        SymmetricOrdering::Amd,
        CholeskySymbolicParams::default(),
    )
    .map_err(|_| Error::Section("there is too little memory for its factor"))
}
