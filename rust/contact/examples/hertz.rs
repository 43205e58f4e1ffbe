// SPDX-License-Identifier: MIT OR Apache-2.0
//! A steel ball of 20 mm on a steel plate under 1 kN, against Hertz.

use mtb_contact::normal::{Load, Method, NormalContact, Options, Surface, solve_normal};
use mtb_elasticity::{Material, half_space::influence};
use mtb_operator::{Component, Grid, unmonitored};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let steel = Material::new(80e9, 0.3)?;
    let (radius, force, spacing, n) = (20e-3, 1e3, 10e-6, 100);
    let joined = Material::joined(&[steel, steel])?;
    let closing = move |offset: [f64; 2], cell: [f64; 2]| {
        influence(&joined, Component::Normal, Component::Normal, offset, cell)
    };
    let place = |i: usize| (i as f64 - 0.5 * (n - 1) as f64) * spacing;
    let gap: Vec<f64> = (0..n * n)
        .map(|k| (place(k % n).powi(2) + place(k / n).powi(2)) / (2.0 * radius))
        .collect();
    let contact = NormalContact {
        gap: &gap,
        grid: Grid::new(n, n, spacing, spacing)?,
        surface: Surface::FreeSpace(&closing),
        load: Load::Force(force),
        moments: [None, None],
        hardness: None,
        rough: None,
        start: None,
    };
    let options = Options {
        tolerance: Some(1e-8),
        method: Method::Auto,
    };
    let solved = solve_normal(&contact, options, &unmonitored)?;

    let modulus = steel.young_modulus() / (1.0 - 0.3_f64.powi(2)) / 2.0;
    let a = (0.75 * force * radius / modulus).cbrt();
    let hertz = [1.5 * force / (std::f64::consts::PI * a * a), a * a / radius];
    let peak = solved.pressure.iter().copied().fold(0.0, f64::max);
    println!(
        "status {:?}, {:.1} products",
        solved.status, solved.products
    );
    println!(
        "peak pressure {:.1} MPa, Hertz {:.1}",
        peak / 1e6,
        hertz[0] / 1e6
    );
    println!(
        "approach {:.3} um, Hertz {:.3}",
        solved.approach * 1e6,
        hertz[1] * 1e6
    );
    assert!(
        (peak / hertz[0] - 1.0).abs() < 3e-3 && (solved.approach / hertz[1] - 1.0).abs() < 1e-3
    );
    Ok(())
}
