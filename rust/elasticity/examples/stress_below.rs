// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where is the shear stress largest below a Hertzian contact? 0.310 of the peak pressure, 0.48 radii deep.

use mtb_elasticity::half_space::StressBelow;
use mtb_elasticity::{Error, Material};
use mtb_operator::{Grid, unmonitored};

fn main() -> Result<(), Error> {
    let (radius, peak, n) = (1e-3, 1e9, 81);
    let material = Material::new(80e9, 0.3)?;
    let side = 2.2 * radius / n as f64;
    let grid = Grid::new(n, n, side, side).map_err(Error::Operator)?;
    let place = |k: usize| (k as f64 - 0.5 * (n - 1) as f64) * side;
    let pressure: Vec<f64> = (0..n * n)
        .map(|k| {
            let (x, y) = (place(k % n) / radius, place(k / n) / radius);
            peak * (1.0 - x * x - y * y).max(0.0).sqrt()
        })
        .collect();
    let none = vec![0.0; n * n];
    let below = StressBelow::new(material, grid, [&none, &none, &pressure])?;
    let depths: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k) * radius).collect();
    let stress = below.at(&depths, &unmonitored)?;
    let middle = n * n / 2;
    println!("depth / radius  largest shear stress / peak pressure");
    for (depth, at) in depths.iter().zip(stress.chunks(6 * n * n)) {
        // on the axis x, y and z are the principal axes
        let [side, _, down] = [0, 1, 2].map(|c| at[c * n * n + middle]);
        println!(
            "{:14.2}  {:37.4}",
            depth / radius,
            0.5 * (side - down).abs() / peak
        );
    }
    Ok(())
}
