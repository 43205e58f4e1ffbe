// SPDX-License-Identifier: MIT OR Apache-2.0
use nalgebra::{Matrix3, SMatrix, Vector3};

use super::mesh::EDGES;
use crate::Material;

pub(super) const LINEAR: usize = 4;
pub(super) const QUADRATIC: usize = 10;

/// Lamé's constants lambda and mu [Pa].
pub(super) fn lame(material: Material) -> (f64, f64) {
    let (mu, nu) = (material.shear_modulus, material.poisson_ratio);
    (2.0 * mu * nu / (1.0 - 2.0 * nu), mu)
}

/// Barycentric coordinates and weights (of a volume of one sixth, so summing to one) of the rule of
/// degree 2, exact for the stiffness of straight quadratic tetrahedra.
const RULE_2: [([f64; 4], f64); 4] = {
    const A: f64 = 0.585_410_196_624_968_5;
    const B: f64 = 0.138_196_601_125_010_5;
    [
        ([A, B, B, B], 0.25),
        ([B, A, B, B], 0.25),
        ([B, B, A, B], 0.25),
        ([B, B, B, A], 0.25),
    ]
};

/// Rule of degree 5 with 15 points, all weights positive, for curved quadratic tetrahedra [Keast1986].
fn rule_5() -> [([f64; 4], f64); 15] {
    let mut rule = [([0.25; 4], 0.181_702_068_582_535_05); 15];
    let corner = [
        (1.0 / 3.0, 0.036_160_714_285_714_29),
        (1.0 / 11.0, 0.069_871_494_516_173_79),
    ];
    for (k, (b, weight)) in corner.into_iter().enumerate() {
        for i in 0..4 {
            let mut l = [b; 4];
            l[i] = 1.0 - 3.0 * b;
            rule[1 + 4 * k + i] = (l, weight);
        }
    }
    let b = 0.066_550_153_573_664_3;
    for (k, [i, j]) in EDGES.into_iter().enumerate() {
        let mut l = [0.5 - b; 4];
        l[i] = b;
        l[j] = b;
        rule[9 + k] = (l, 0.065_694_849_368_318_72);
    }
    rule
}

/// Derivatives of the shape functions by the barycentric coordinates 1, 2, 3 (0 depends on them).
fn natural_gradients<const N: usize>(l: [f64; 4]) -> SMatrix<f64, N, 3> {
    // gradients of the barycentric coordinates in natural space
    const G: [[f64; 3]; 4] = [
        [-1.0, -1.0, -1.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    SMatrix::from_fn(|a, c| {
        if N == LINEAR {
            G[a][c]
        } else if a < 4 {
            (4.0 * l[a] - 1.0) * G[a][c]
        } else {
            let [i, j] = EDGES[a - 4];
            4.0 * (l[i] * G[j][c] + l[j] * G[i][c])
        }
    })
}

/// Shape functions at barycentric coordinates `l`.
fn shape<const N: usize>(l: [f64; 4]) -> [f64; N] {
    std::array::from_fn(|a| {
        if N == LINEAR {
            l[a]
        } else if a < 4 {
            l[a] * (2.0 * l[a] - 1.0)
        } else {
            let [i, j] = EDGES[a - 4];
            4.0 * l[i] * l[j]
        }
    })
}

fn jacobian<const N: usize>(
    natural: &SMatrix<f64, N, 3>,
    cell: &[usize],
    nodes: &[[f64; 3]],
) -> Matrix3<f64> {
    let mut jacobian = Matrix3::zeros();
    for (a, &node) in cell.iter().enumerate() {
        let x = nodes[node];
        for i in 0..3 {
            for c in 0..3 {
                jacobian[(i, c)] += x[i] * natural[(a, c)];
            }
        }
    }
    jacobian
}

/// Gradients of the shape functions in space [1/m] and the Jacobian [m3] at `l`.
pub(super) fn gradients<const N: usize>(
    l: [f64; 4],
    cell: &[usize],
    nodes: &[[f64; 3]],
) -> (SMatrix<f64, N, 3>, f64) {
    let natural = natural_gradients::<N>(l);
    let jacobian = jacobian(&natural, cell, nodes);
    let inverse = jacobian.try_inverse().unwrap_or_else(Matrix3::zeros);
    (natural * inverse, jacobian.determinant())
}

/// Smallest Jacobian over the corners and the quadrature points, and the mean one [m3].
pub(super) fn jacobian_range(cell: &[usize], nodes: &[[f64; 3]]) -> (f64, f64) {
    if cell.len() == LINEAR {
        let j = jacobian(&natural_gradients::<LINEAR>([0.25; 4]), cell, nodes).determinant();
        return (j, j);
    }
    let at = |l: [f64; 4]| jacobian(&natural_gradients::<QUADRATIC>(l), cell, nodes).determinant();
    let mut least = f64::INFINITY;
    for i in 0..4 {
        let mut l = [0.0; 4];
        l[i] = 1.0;
        least = least.min(at(l));
    }
    let mut mean = 0.0;
    for (l, weight) in rule_5() {
        let j = at(l);
        least = least.min(j);
        mean += weight * j;
    }
    (least, mean)
}

fn is_straight(cell: &[usize], nodes: &[[f64; 3]]) -> bool {
    EDGES.iter().zip(&cell[4..]).all(|([i, j], &m)| {
        let (a, b, x) = (
            Vector3::from(nodes[cell[*i]]),
            Vector3::from(nodes[cell[*j]]),
            Vector3::from(nodes[m]),
        );
        ((a + b) * 0.5 - x).norm() <= 1e-10 * (a - b).norm()
    })
}

/// Calls `visit(shape functions, gradients [1/m], weight [m3])` at the quadrature points of a cell.
fn integrate<const N: usize>(
    cell: &[usize],
    nodes: &[[f64; 3]],
    mut visit: impl FnMut(&SMatrix<f64, N, 3>, f64),
) {
    let mut at = |l: [f64; 4], weight: f64| {
        let (g, j) = gradients::<N>(l, cell, nodes);
        visit(&g, weight * j / 6.0);
    };
    if N == LINEAR {
        at([0.25; 4], 1.0);
    } else if is_straight(cell, nodes) {
        for (l, weight) in RULE_2 {
            at(l, weight);
        }
    } else {
        for (l, weight) in rule_5() {
            at(l, weight);
        }
    }
}

/// Stiffness matrix [N/m] of one cell, row-major `(3 n, 3 n)`, degrees of freedom node by node.
pub(super) fn stiffness(cell: &[usize], nodes: &[[f64; 3]], material: Material) -> Vec<f64> {
    if cell.len() == LINEAR {
        stiffness_of::<LINEAR>(cell, nodes, material)
    } else {
        stiffness_of::<QUADRATIC>(cell, nodes, material)
    }
}

fn stiffness_of<const N: usize>(
    cell: &[usize],
    nodes: &[[f64; 3]],
    material: Material,
) -> Vec<f64> {
    let (lambda, mu) = lame(material);
    let mut k = vec![0.0; 9 * N * N];
    integrate::<N>(cell, nodes, |g, weight| {
        for a in 0..N {
            for b in 0..=a {
                let dot = mu * (0..3).map(|c| g[(a, c)] * g[(b, c)]).sum::<f64>();
                for i in 0..3 {
                    for j in 0..3 {
                        let mut value = lambda * g[(a, i)] * g[(b, j)] + mu * g[(a, j)] * g[(b, i)];
                        if i == j {
                            value += dot;
                        }
                        k[(3 * a + i) * 3 * N + 3 * b + j] += weight * value;
                    }
                }
            }
        }
    });
    for row in 0..3 * N {
        for column in row + 1..3 * N {
            // node pairs with b > a were not computed
            if column / 3 > row / 3 {
                k[row * 3 * N + column] = k[column * 3 * N + row];
            }
        }
    }
    k
}

/// Calls `visit(shape functions, gradients [1/m], weight [m3])` at the points of a rule that is exact for products
/// of two shape functions of straight cells.
fn integrate_products<const N: usize>(
    cell: &[usize],
    nodes: &[[f64; 3]],
    mut visit: impl FnMut(&[f64; N], &SMatrix<f64, N, 3>, f64),
) {
    for (l, weight) in rule_5() {
        let (g, j) = gradients::<N>(l, cell, nodes);
        visit(&shape::<N>(l), &g, weight * j / 6.0);
    }
}

/// Integrals of products of shape functions [m3] over one cell, row-major `(n, n)`.
pub(super) fn products(cell: &[usize], nodes: &[[f64; 3]]) -> Vec<f64> {
    if cell.len() == LINEAR {
        conduction_of::<LINEAR>(cell, nodes).0
    } else {
        conduction_of::<QUADRATIC>(cell, nodes).0
    }
}

/// Integrals of products of shape functions [m3] and of their gradients [m] over one cell, row-major `(n, n)`.
pub(super) fn conduction(cell: &[usize], nodes: &[[f64; 3]]) -> (Vec<f64>, Vec<f64>) {
    if cell.len() == LINEAR {
        conduction_of::<LINEAR>(cell, nodes)
    } else {
        conduction_of::<QUADRATIC>(cell, nodes)
    }
}

fn conduction_of<const N: usize>(cell: &[usize], nodes: &[[f64; 3]]) -> (Vec<f64>, Vec<f64>) {
    let (mut capacity, mut conductivity) = (vec![0.0; N * N], vec![0.0; N * N]);
    integrate_products::<N>(cell, nodes, |n, g, weight| {
        for a in 0..N {
            for b in 0..N {
                capacity[a * N + b] += weight * n[a] * n[b];
                let dot: f64 = (0..3).map(|c| g[(a, c)] * g[(b, c)]).sum();
                conductivity[a * N + b] += weight * dot;
            }
        }
    });
    (capacity, conductivity)
}

/// Integrals of shape functions (rows) times derivatives of shape functions (columns, three for each node) [m2] over
/// one cell, row-major `(n, 3 n)`.
pub(super) fn divergence(cell: &[usize], nodes: &[[f64; 3]]) -> Vec<f64> {
    if cell.len() == LINEAR {
        divergence_of::<LINEAR>(cell, nodes)
    } else {
        divergence_of::<QUADRATIC>(cell, nodes)
    }
}

fn divergence_of<const N: usize>(cell: &[usize], nodes: &[[f64; 3]]) -> Vec<f64> {
    let mut found = vec![0.0; 3 * N * N];
    integrate_products::<N>(cell, nodes, |n, g, weight| {
        for a in 0..N {
            for b in 0..N {
                for c in 0..3 {
                    found[a * 3 * N + 3 * b + c] += weight * n[a] * g[(b, c)];
                }
            }
        }
    });
    found
}

/// Stress (xx, yy, zz, yz, xz, xy) [Pa] at barycentric coordinates `l`, from nodal displacements [m].
pub(super) fn stress(
    l: [f64; 4],
    cell: &[usize],
    nodes: &[[f64; 3]],
    material: Material,
    displacement: impl Fn(usize) -> [f64; 3],
) -> [f64; 6] {
    let mut gradient = Matrix3::zeros();
    let mut add = |a: usize, g: [f64; 3]| {
        let u = displacement(cell[a]);
        for i in 0..3 {
            for j in 0..3 {
                gradient[(i, j)] += u[i] * g[j];
            }
        }
    };
    if cell.len() == LINEAR {
        let (g, _) = gradients::<LINEAR>(l, cell, nodes);
        (0..LINEAR).for_each(|a| add(a, [g[(a, 0)], g[(a, 1)], g[(a, 2)]]));
    } else {
        let (g, _) = gradients::<QUADRATIC>(l, cell, nodes);
        (0..QUADRATIC).for_each(|a| add(a, [g[(a, 0)], g[(a, 1)], g[(a, 2)]]));
    }
    let (lambda, mu) = lame(material);
    let s =
        Matrix3::identity() * (lambda * gradient.trace()) + (gradient + gradient.transpose()) * mu;
    [
        s[(0, 0)],
        s[(1, 1)],
        s[(2, 2)],
        s[(1, 2)],
        s[(0, 2)],
        s[(0, 1)],
    ]
}
