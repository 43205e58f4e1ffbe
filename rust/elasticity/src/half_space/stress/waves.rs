// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress by waves of pressure on the surface.

use mtb_operator::Complex;

use super::rectangle::Stress;

/// Stress by a unit wave of pressure with the wave numbers `kx, ky` [1/m], not both zero, at a depth [m], in the body's
/// own frame; `xz` and `yz` are to be taken times `i`.
///
/// [Johnson1985, ch. 13]: the potentials of a wave fall with `exp(-k z)`.
fn wave(nu: f64, [kx, ky]: [f64; 2], depth: f64) -> Stress {
    let k = kx.hypot(ky);
    let (along, across) = (kx / k, ky / k);
    let fall = (-k * depth).exp();
    let inner = 1.0 - 2.0 * nu - k * depth;
    [
        -fall * (2.0 * nu + inner * along * along),
        -fall * (2.0 * nu + inner * across * across),
        -fall * (1.0 + k * depth),
        fall * ky * depth,
        fall * kx * depth,
        -fall * inner * along * across,
    ]
}

/// Component `k` of the stress by a wave: wave indices `index` of `shape` points of a grid with `period`s [m].
///
/// The mean pressure goes through the whole body, whose sides cannot move apart. Waves of which the grid cannot tell
/// the direction have no shear of it.
pub(super) fn periodic(
    nu: f64,
    k: usize,
    index: [usize; 2],
    shape: [usize; 2],
    period: [f64; 2],
    depth: f64,
) -> Complex<f64> {
    let signed = [0, 1].map(|a| {
        let (i, n) = (index[a] as f64, shape[a] as f64);
        if 2.0 * i > n { i - n } else { i }
    });
    if index == [0, 0] {
        let side = -nu / (1.0 - nu);
        return Complex::new([side, side, -1.0, 0.0, 0.0, 0.0][k], 0.0);
    }
    let is_last = [0, 1].map(|a| 2 * index[a] == shape[a]);
    let is_blind = match k {
        3 => is_last[1],
        4 => is_last[0],
        5 => is_last[0] || is_last[1],
        _ => false,
    };
    if is_blind {
        return Complex::default();
    }
    let numbers = [0, 1].map(|a| 2.0 * std::f64::consts::PI * signed[a] / period[a]);
    let value = wave(nu, numbers, depth)[k];
    if k == 3 || k == 4 {
        Complex::new(0.0, value)
    } else {
        Complex::new(value, 0.0)
    }
}
