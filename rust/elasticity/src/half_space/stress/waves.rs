// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress by waves of traction on the surface.

use mtb_operator::Complex;

use super::rectangle::Stress;

/// Stress by unit waves `exp(i k x)` of traction at a depth, `l` along the wave vector, `t` across it and `z` into the
/// body.
pub(in super::super) struct HalfSpaceWaves {
    /// zz, ll, tt and, to be taken times `i`, lz, by a pressure.
    pub(in super::super) pressure: [f64; 4],
    /// zz, ll and tt, to be taken times `i`, and lz, by a traction along the wave vector.
    pub(in super::super) along: [f64; 4],
    /// tz and, to be taken times `i`, lt, by a traction across it.
    pub(in super::super) across: [f64; 2],
}

impl HalfSpaceWaves {
    /// Those of a half-space, over the wave number times the depth: potentials of a wave fall with `exp(-k z)`.
    /// [Johnson1985, ch. 13]
    pub(in super::super) fn new(nu: f64, depth: f64) -> Self {
        let fall = (-depth).exp();
        let two = 2.0 * nu;
        Self {
            pressure: [-1.0 - depth, depth - 1.0, -two, depth].map(|v| fall * v),
            along: [depth, 2.0 - depth, two, depth - 1.0].map(|v| fall * v),
            across: [-fall, fall],
        }
    }

    /// Stress by a pressure with the wave numbers `kx, ky` [1/m], not both zero, in the body's own frame; `xz` and `yz`
    /// are to be taken times `i`.
    fn by_pressure(&self, [kx, ky]: [f64; 2]) -> Stress {
        let k = kx.hypot(ky);
        let (along, across) = (kx / k, ky / k);
        let [zz, ll, tt, lz] = self.pressure;
        [
            tt + (ll - tt) * along * along,
            tt + (ll - tt) * across * across,
            zz,
            across * lz,
            along * lz,
            (ll - tt) * along * across,
        ]
    }
}

/// Component `k` of the stress by a wave of pressure: wave indices `index` of `shape` points of a grid with `period`s
/// [m]. `waves` are those of a wave number [1/m], `poisson_ratio` that of the material there.
///
/// The mean pressure goes through the whole body, whose sides cannot move apart. Waves of which the grid cannot tell
/// the direction have no shear of it.
pub(super) fn periodic(
    waves: &impl Fn(f64) -> HalfSpaceWaves,
    poisson_ratio: f64,
    k: usize,
    index: [usize; 2],
    shape: [usize; 2],
    period: [f64; 2],
) -> Complex<f64> {
    let signed = [0, 1].map(|a| {
        let (i, n) = (index[a] as f64, shape[a] as f64);
        if 2.0 * i > n { i - n } else { i }
    });
    if index == [0, 0] {
        let side = -poisson_ratio / (1.0 - poisson_ratio);
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
    let value = waves(numbers[0].hypot(numbers[1])).by_pressure(numbers)[k];
    if k == 3 || k == 4 {
        Complex::new(0.0, value)
    } else {
        Complex::new(value, 0.0)
    }
}
