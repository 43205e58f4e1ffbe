// SPDX-License-Identifier: MIT OR Apache-2.0
//! About the inverse of the half-space under the hats of one patch.

use std::f64::consts::PI;

use mtb_operator::{Grid, Map, Transform, unmonitored};

use crate::Material;

/// Nodes of room beyond a patch: what holds a node in its place falls with the cube of the distance.
const ROOM: usize = 8;

/// Waves of a hat that are seen as longer ones count up to so many times the sampling.
const ALIASES: i32 = 2;

/// Share of the compliance of a wave that is left at least where points close under their own pressure.
const LEFT: f64 = 0.5;

/// The pressures that move the nodes of a `grid` by given amounts, about: each wave by itself, as if the patch were
/// repeated with some room between, and none of its hats were cut. Each node gives way by `softer` [m/Pa] to its own
/// pressure besides.
pub(super) fn near_inverse(material: &Material, grid: Grid, softer: f64) -> Map {
    let shape = [grid.nx, grid.ny];
    let transform = Transform::wrapped_with_room(shape, shape.map(|n| n + ROOM));
    let sides = [0, 1].map(|k| transform.padded()[k] as f64 * [grid.dx, grid.dy][k]);
    let longest = 2.0 * PI / sides[0].max(sides[1]);
    let kernel = transform.even_kernel_from_spectrum(|kx, ky| {
        let waves = [kx, ky];
        let wave = [0, 1].map(|k| 2.0 * PI * waves[k] as f64 / sides[k]);
        // a mean over the patch is as soft as its longest wave
        let wave = if waves == [0, 0] {
            [longest, 0.0]
        } else {
            wave
        };
        let own = compliance(material, wave, [grid.dx, grid.dy]);
        1.0 / (own + softer).max(LEFT * own)
    });
    Box::new(move |x: &[f64], y: &mut [f64]| transform.apply_watched(&kernel, x, y, &unmonitored))
}

/// Displacement of nodes by a wave [rad/m] of pressures of 1 Pa on hats with `steps` [m] between them.
fn compliance(material: &Material, wave: [f64; 2], steps: [f64; 2]) -> f64 {
    let mut sum = 0.0;
    for a in -ALIASES..=ALIASES {
        for b in -ALIASES..=ALIASES {
            let alias = [a, b].map(f64::from);
            let seen = [0, 1].map(|k| wave[k] + 2.0 * PI * alias[k] / steps[k]);
            let share = hat(seen[0] * steps[0]) * hat(seen[1] * steps[1]);
            sum += share * share / seen[0].hypot(seen[1]);
        }
    }
    (1.0 - material.poisson_ratio) / material.shear_modulus * sum
}

/// Fourier transform of a hat between nodes of distance 1.
fn hat(wave: f64) -> f64 {
    let half = 0.5 * wave;
    if half == 0.0 {
        1.0
    } else {
        (half.sin() / half).powi(2)
    }
}
