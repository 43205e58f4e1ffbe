// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hankel transforms of what lies below a surface, tabulated by octaves of the distance.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::quadrature::{chebyshev, gauss_legendre};

/// Functions of a wave number whose Hankel transforms are wanted. Lengths are in thicknesses of the layer.
pub(super) trait Spectra<const N: usize> {
    /// Orders 0, 1 or 2 of the Bessel functions.
    const ORDERS: [usize; N];

    /// Whole wave number from which on all of them vanish.
    const LAST_WAVE: usize;

    /// Their values at a wave number.
    fn at(&self, wave_number: f64) -> [f64; N];

    /// Transforms at a distance of what they hold besides.
    fn known(&self, _distance: f64) -> [f64; N] {
        [0.0; N]
    }
}

/// Octaves of the distance, from `2^-FIRST` thicknesses on: to 1e24 of them. Less is as nothing.
const OCTAVES: usize = 128;
const FIRST: i32 = 48;

/// Chebyshev points in an octave. The functions are analytic but at no distance and at imaginary ones: the error is
/// about 5.8^-20, or 5e-16.
const POINTS: usize = 20;

/// Distance up to which the spectra are integrated as they are, to the wave number where they end.
const NEAR: f64 = 8.0;

/// Beyond it the integral goes over half periods of the Bessel function, of which the first `SUMMED` count whole and
/// the next ones with the shares of repeated means.
const SUMMED: usize = 24;
const AVERAGED: usize = 32;

/// Grading towards no wave number, where the spectra of unlike bodies have features of any size.
const GRADES: usize = 24;

/// Gauss points on each piece.
const GAUSS: usize = 16;

/// Tables of the Hankel transforms of spectra, which are given anew at each call and must be the same.
pub(super) struct Radials<const N: usize> {
    octaves: Vec<OnceLock<Box<[[f64; POINTS]; N]>>>,
    near: OnceLock<Vec<(f64, [f64; N])>>,
}

impl<const N: usize> Default for Radials<N> {
    fn default() -> Self {
        Self {
            octaves: (0..OCTAVES).map(|_| OnceLock::new()).collect(),
            near: OnceLock::new(),
        }
    }
}

impl<const N: usize> Radials<N> {
    /// One function at a distance.
    pub(super) fn at(&self, function: usize, r: f64, spectra: &impl Spectra<N>) -> f64 {
        let (table, place) = self.table(r, spectra);
        value(&table[function], place)
    }

    /// All functions at a distance.
    pub(super) fn all(&self, r: f64, spectra: &impl Spectra<N>) -> [f64; N] {
        let (table, place) = self.table(r, spectra);
        table.each_ref().map(|powers| value(powers, place))
    }

    fn table(&self, r: f64, spectra: &impl Spectra<N>) -> (&[[f64; POINTS]; N], f64) {
        let (octave, place) = octave_of(r);
        let table = self.octaves[octave].get_or_init(|| Box::new(self.octave(octave, spectra)));
        (table, place)
    }

    /// Polynomials in an octave, by their powers: they are smooth enough to leave all digits.
    fn octave<S: Spectra<N>>(&self, octave: usize, spectra: &S) -> [[f64; POINTS]; N] {
        let start = 2f64.powi(octave as i32 - FIRST);
        let places = chebyshev(POINTS);
        let values: Vec<[f64; N]> = places
            .iter()
            .map(|place| {
                let r = start * (1.5 + 0.5 * place);
                let mut values = if r > NEAR {
                    far(r, spectra)
                } else {
                    near::<N, S>(r, self.near.get_or_init(|| sampled(spectra)))
                };
                for (value, known) in values.iter_mut().zip(spectra.known(r)) {
                    *value += known;
                }
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

/// A polynomial at a place.
fn value(powers: &[f64; POINTS], place: f64) -> f64 {
    let square = place * place;
    // four at a time: a chain of five steps instead of twenty
    let (fours, _) = powers.as_chunks::<4>();
    fours.iter().rev().fold(0.0, |sum, c| {
        sum * (square * square) + (c[0] + c[1] * place) + square * (c[2] + c[3] * place)
    })
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
fn sampled<const N: usize, S: Spectra<N>>(spectra: &S) -> Vec<(f64, [f64; N])> {
    let mut pieces = graded(1.0);
    pieces.extend((1..S::LAST_WAVE).map(|wave| [wave as f64, wave as f64 + 1.0]));
    let rule = gauss_legendre(GAUSS);
    let mut samples = Vec::new();
    for [from, to] in pieces {
        let half = 0.5 * (to - from);
        for (node, weight) in &rule {
            let q = from + half * (1.0 + node);
            samples.push((q, spectra.at(q).map(|value| half * weight * value)));
        }
    }
    samples
}

fn near<const N: usize, S: Spectra<N>>(r: f64, samples: &[(f64, [f64; N])]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (q, values) in samples {
        add::<N, S>(&mut sums, q * r, values, 1.0);
    }
    sums
}

/// Adds `share` of the products of spectra with their Bessel functions.
fn add<const N: usize, S: Spectra<N>>(sums: &mut [f64; N], x: f64, values: &[f64; N], share: f64) {
    let (zeroth, first) = (share * libm::j0(x), share * libm::j1(x));
    let bessel = [zeroth, first, 2.0 * first / x - zeroth];
    for ((sum, value), order) in sums.iter_mut().zip(values).zip(S::ORDERS) {
        *sum += bessel[order] * value;
    }
}

fn far<const N: usize, S: Spectra<N>>(r: f64, spectra: &S) -> [f64; N] {
    let rule = gauss_legendre(GAUSS);
    let mut sums = [0.0; N];
    let mut piece = |from: f64, to: f64, share: f64| {
        let half = 0.5 * (to - from);
        for (node, weight) in &rule {
            let x = from + half * (1.0 + node);
            add::<N, S>(&mut sums, x, &spectra.at(x / r), share * half * weight / r);
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
