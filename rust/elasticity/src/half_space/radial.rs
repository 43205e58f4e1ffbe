// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hankel transforms of what lies below a surface, tabulated by octaves of the distance.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::quadrature::{chebyshev, gauss_legendre};

/// The radial functions, lengths in thicknesses of the layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Radial {
    /// Transform by `J_1` of the normal spectrum: the flux of a point load through a circle, over its radius.
    Normal,
    /// The same of the spectrum across the wave vector.
    Across,
    /// The same of the difference of those along and across.
    Difference,
    /// Transform by `J_0` of the mixed spectrum, up to a constant.
    Mixed,
}

/// Octaves of the distance, from `2^-FIRST` thicknesses on: to 1e24 of them. Less is as nothing.
const OCTAVES: usize = 128;
const FIRST: i32 = 48;

/// Chebyshev points in an octave. The functions are analytic but at no distance and at imaginary ones: the error is
/// about 5.8^-20, or 5e-16.
const POINTS: usize = 20;

/// Distance up to which the spectra are integrated as they are, to the wave number where they end.
const NEAR: f64 = 8.0;
const LAST_WAVE: usize = 25;

/// Beyond it the integral goes over half periods of the Bessel function, of which the first `SUMMED` count whole and
/// the next ones with the shares of repeated means.
const SUMMED: usize = 24;
const AVERAGED: usize = 32;

/// Grading towards no wave number, where the spectra of unlike bodies have features of any size.
const GRADES: usize = 24;

/// Gauss points on each piece.
const GAUSS: usize = 16;

type Spectra<'a> = dyn Fn(f64) -> [f64; 4] + 'a;

/// Tables of the radial functions of one body.
pub(super) struct Radials {
    octaves: Vec<OnceLock<[[f64; POINTS]; 4]>>,
    near: OnceLock<Vec<(f64, [f64; 4])>>,
}

impl Default for Radials {
    fn default() -> Self {
        Self {
            octaves: (0..OCTAVES).map(|_| OnceLock::new()).collect(),
            near: OnceLock::new(),
        }
    }
}

impl Radials {
    /// A function at a distance. `far_mixed`: what the mixed spectrum holds besides, times `exp(-q) / q`.
    pub(super) fn at(&self, radial: Radial, r: f64, spectra: &Spectra<'_>, far_mixed: f64) -> f64 {
        let (octave, place) = octave_of(r);
        let table = self.octaves[octave].get_or_init(|| self.octave(octave, spectra, far_mixed));
        let square = place * place;
        // four at a time: a chain of five steps instead of twenty
        let (fours, _) = table[radial as usize].as_chunks::<4>();
        fours.iter().rev().fold(0.0, |sum, c| {
            sum * (square * square) + (c[0] + c[1] * place) + square * (c[2] + c[3] * place)
        })
    }

    /// Polynomials in an octave, by their powers: they are smooth enough to leave all digits.
    fn octave(&self, octave: usize, spectra: &Spectra<'_>, far_mixed: f64) -> [[f64; POINTS]; 4] {
        let start = 2f64.powi(octave as i32 - FIRST);
        let places = chebyshev(POINTS);
        let values: Vec<[f64; 4]> = places
            .iter()
            .map(|place| {
                let r = start * (1.5 + 0.5 * place);
                let mut values = if r > NEAR {
                    far(r, spectra)
                } else {
                    near(r, self.near.get_or_init(|| sampled(spectra)))
                };
                // the integral of exp(-q) (J_0(q r) - 1) / q
                values[3] -= far_mixed * (0.5 * (1.0 + r.hypot(1.0))).ln();
                values
            })
            .collect();
        std::array::from_fn(|function| {
            let (mut before, mut now) = ([0.0; POINTS], [0.0; POINTS]);
            now[0] = 1.0;
            let mut powers = [0.0; POINTS];
            for order in 0..POINTS {
                let sum: f64 = (0..POINTS)
                    .map(|k| {
                        let angle = PI * (k as f64 + 0.5) / POINTS as f64;
                        values[k][function] * (order as f64 * angle).cos()
                    })
                    .sum();
                let share = sum * if order == 0 { 1.0 } else { 2.0 } / POINTS as f64;
                for (power, own) in powers.iter_mut().zip(now) {
                    *power += share * own;
                }
                // the next Chebyshev polynomial
                let twice = if order == 0 { 1.0 } else { 2.0 };
                let next = std::array::from_fn(|k| {
                    let lower = if k == 0 { 0.0 } else { now[k - 1] };
                    twice * lower - before[k]
                });
                (before, now) = (now, next);
            }
            powers
        })
    }
}

/// Octave of a distance, and its place there in [-1, 1].
fn octave_of(r: f64) -> (usize, f64) {
    let least = 2f64.powi(-FIRST);
    let most = 2f64.powi(OCTAVES as i32 - FIRST) * (1.0 - f64::EPSILON);
    let r = r.clamp(least, most);
    let exponent = ((r.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    let octave = (exponent + FIRST) as usize;
    (octave, 2.0 * (r * 2f64.powi(-exponent)) - 3.0)
}

/// Ends of pieces from 0 to `end` that grow by four.
fn graded(end: f64) -> Vec<[f64; 2]> {
    let at = |grade: usize| end * 4f64.powi(grade as i32 - GRADES as i32);
    let mut pieces = vec![[0.0, at(0)]];
    pieces.extend((0..GRADES).map(|grade| [at(grade), at(grade + 1)]));
    pieces
}

/// Wave numbers with the spectra there times the weights of a quadrature.
fn sampled(spectra: &Spectra<'_>) -> Vec<(f64, [f64; 4])> {
    let mut pieces = graded(1.0);
    pieces.extend((1..LAST_WAVE).map(|wave| [wave as f64, wave as f64 + 1.0]));
    let rule = gauss_legendre(GAUSS);
    let mut samples = Vec::new();
    for [from, to] in pieces {
        let half = 0.5 * (to - from);
        for (node, weight) in &rule {
            let q = from + half * (1.0 + node);
            samples.push((q, spectra(q).map(|value| half * weight * value)));
        }
    }
    samples
}

fn near(r: f64, samples: &[(f64, [f64; 4])]) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for (q, values) in samples {
        add(&mut sums, q * r, values, 1.0);
    }
    sums
}

/// Adds `share` of the products of spectra with their Bessel functions.
fn add(sums: &mut [f64; 4], x: f64, values: &[f64; 4], share: f64) {
    let (zeroth, first) = (share * libm::j0(x), share * libm::j1(x));
    for (sum, value) in sums[..3].iter_mut().zip(values) {
        *sum += first * value;
    }
    sums[3] += zeroth * values[3];
}

fn far(r: f64, spectra: &Spectra<'_>) -> [f64; 4] {
    let rule = gauss_legendre(GAUSS);
    let mut sums = [0.0; 4];
    let mut piece = |from: f64, to: f64, share: f64| {
        let half = 0.5 * (to - from);
        for (node, weight) in &rule {
            let x = from + half * (1.0 + node);
            add(&mut sums, x, &spectra(x / r), share * half * weight / r);
        }
    };
    let first = 1.25 * PI;
    for [from, to] in graded(first) {
        piece(from, to, 1.0);
    }
    // the share of a half period: that of all partial sums that hold it
    let (mut share, mut binomial) = (1.0, 0.5f64.powi(AVERAGED as i32));
    for k in 0..SUMMED + AVERAGED {
        if k >= SUMMED {
            let j = (k - SUMMED) as f64;
            share -= binomial;
            binomial *= (AVERAGED as f64 - j) / (j + 1.0);
        }
        piece(first + PI * k as f64, first + PI * (k as f64 + 1.0), share);
    }
    sums
}
