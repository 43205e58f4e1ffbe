// SPDX-License-Identifier: MIT OR Apache-2.0
//! What it costs to condense the pole of a brake: counts and a breakdown of time.
//!
//! `cargo bench -p mtb-elasticity --bench condense`

#[path = "../tests/box_mesh/mod.rs"]
#[allow(dead_code, reason = "shared with the tests")]
mod box_mesh;

use box_mesh::{box_mesh, even, grid_on_bottom, nodes_where};
use mtb_elasticity::Material;
use mtb_elasticity::tetra::{Hold, Limits, Order, Support, TetraBody};
use mtb_operator::unmonitored;

/// Heights of layers that start with `first` and grow to fill `height`.
fn graded(first: f64, height: f64, layers: i32) -> Vec<f64> {
    let sum = |q: f64| (0..layers).map(|k| first * q.powi(k)).sum::<f64>();
    let (mut low, mut high) = (1.0, 10.0);
    for _ in 0..60 {
        let q = 0.5 * (low + high);
        if sum(q) < height {
            low = q;
        } else {
            high = q;
        }
    }
    let mut z = vec![0.0];
    for k in 0..layers {
        z.push(z[k as usize] + first * low.powi(k));
    }
    z
}

fn condense(name: &str, x: &[f64], y: &[f64], z: &[f64], order: Order) {
    let mesh = box_mesh(x, y, z, order);
    let height = z[z.len() - 1];
    let top = Support {
        name: "top".into(),
        nodes: nodes_where(&mesh, |p| p[2] > height - 1e-9),
        hold: [Hold::Prescribed, Hold::Prescribed, Hold::Free],
    };
    let sampling = grid_on_bottom(&mesh, x, y);
    let tets = mesh.n_tets();
    let steel = Material::new(80e9, 0.3).expect("steel");
    let body = TetraBody::new(mesh, steel, vec![top]).expect("a good body");
    let clock = std::time::Instant::now();
    let condensed = body
        .condense(&sampling, Limits::default(), &unmonitored)
        .expect("it condenses");
    let c = condensed.cost;
    println!(
        "{name}: {tets} tets, {} unknowns, {} points, {:.1} M entries, peak {:.2} GB, total {:.2} s\n  \
         ordering {:.2} s, assembly {:.2} s, symbolic {:.2} s\n  \
         numeric {:.1} GF {:.2} s, forward {:.1} GF {:.2} s, products {:.1} GF {:.2} s",
        c.unknowns,
        sampling.n_points(),
        c.factor_entries as f64 * 1e-6,
        c.peak_bytes as f64 * 1e-9,
        clock.elapsed().as_secs_f64(),
        c.ordering_s,
        c.assembly_s,
        c.symbolic_s,
        c.factor_flops * 1e-9,
        c.numeric_s,
        c.forward_flops * 1e-9,
        c.forward_s,
        c.product_flops * 1e-9,
        c.product_s,
    );
}

fn main() {
    let pole = |x0, x1, n| even(x0, x1, n);
    condense(
        "one pole 100 x 30 x 70 mm, Tet10",
        &pole(0.0, 0.1, 33),
        &pole(0.0, 0.03, 10),
        &graded(3e-3, 0.07, 6),
        Order::Quadratic,
    );
    condense(
        "two poles 100 x 70 x 70 mm, Tet10",
        &pole(0.0, 0.1, 33),
        &pole(0.0, 0.07, 23),
        &graded(3e-3, 0.07, 5),
        Order::Quadratic,
    );
    // the blocks of the ordering study: free ordering at most 45 and 60 GFlop
    condense(
        "block 46 x 29 x 14, Tet4",
        &pole(0.0, 0.096, 46),
        &pole(0.0, 0.06, 29),
        &pole(0.0, 0.028, 14),
        Order::Linear,
    );
    condense(
        "block 22 x 14 x 7, Tet10",
        &pole(0.0, 0.096, 22),
        &pole(0.0, 0.06, 14),
        &pole(0.0, 0.028, 7),
        Order::Quadratic,
    );
}
