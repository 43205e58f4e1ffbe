// SPDX-License-Identifier: MIT OR Apache-2.0
//! A half-space under rows that carry waves `exp(i k x)`: integrals over pairs of rows.

use mtb_operator::Component;

use crate::Material;

/// Gauss' rule of eight points on [-1, 1], positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Points and weights of Gauss' rule between two numbers.
pub(super) fn gauss(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    GAUSS
        .into_iter()
        .flat_map(move |(at, weight)| [-at, at].map(|at| (middle + half * at, half * weight)))
}

/// A function of y as a sum of `c (y - place)_+^power`, with power 0 or 1: (place, c, power). It is zero beyond its
/// last place.
pub(super) type Shape = Vec<(f64, f64, i32)>;

/// Values of a uniform strip.
pub(super) fn strip(from: f64, to: f64) -> Shape {
    vec![(from, 1.0, 0), (to, -1.0, 0)]
}

/// The hat of a line between its neighbours, if there are any.
pub(super) fn hat(before: Option<f64>, own: f64, after: Option<f64>) -> Shape {
    let mut shape = Shape::new();
    match before {
        Some(before) => {
            let slope = 1.0 / (own - before);
            shape.extend([(before, slope, 1), (own, -slope, 1)]);
        }
        None => shape.push((own, 1.0, 0)),
    }
    match after {
        Some(after) => {
            let slope = 1.0 / (after - own);
            shape.extend([(own, -slope, 1), (after, slope, 1)]);
        }
        None => shape.push((own, -1.0, 0)),
    }
    shape
}

/// Quadrature of `int int phi_i(y) phi_j(y') g(y - y') dy dy'` as (distance, weight).
pub(super) fn distances(observed: &Shape, loaded: &Shape) -> Vec<(f64, f64)> {
    let mut knots: Vec<f64> = observed
        .iter()
        .flat_map(|(a, _, _)| loaded.iter().map(move |(b, _, _)| a - b))
        .collect();
    knots.sort_by(f64::total_cmp);
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    let near = 1e-9 * (last - first);
    for knot in &mut knots {
        if knot.abs() < near {
            *knot = 0.0;
        }
    }
    if first < -near && last > near {
        knots.push(0.0);
        knots.sort_by(f64::total_cmp);
    }
    let overlap = |distance: f64| -> f64 {
        let mut sum = 0.0;
        for (a, c, p) in observed {
            for (b, d, q) in loaded {
                let beyond = distance - (a - b);
                if beyond > 0.0 {
                    let power = p + q + 1;
                    let factorial: f64 = (1..=power).map(f64::from).product();
                    let sign = if *q == 0 { -1.0 } else { 1.0 };
                    sum += sign * c * d * beyond.powi(power) / factorial;
                }
            }
        }
        sum
    };
    let mut out = Vec::new();
    for pair in knots.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        if to - from <= near {
            continue;
        }
        if from == 0.0 || to == 0.0 {
            // dense towards the logarithm: the distance is the fourth power of what is integrated over
            let end = if from == 0.0 { to } else { from };
            for (t, weight) in gauss(0.0, 1.0) {
                let distance = end * t.powi(4);
                let step = end.abs() * 4.0 * t.powi(3) * weight;
                out.push((distance, step * overlap(distance)));
            }
        } else {
            out.extend(gauss(from, to).map(|(d, w)| (d, w * overlap(d))));
        }
    }
    out
}

/// Displacements of a half-space at a distance `y` [m] from a line load at a wave number [1/m], in its own frame (x, y,
/// into): nn, xx, yy, xn, yn and xy. Those along x are amplitudes of `i`, as are such loads.
///
/// Fourier transforms of the solutions of Boussinesq and Cerruti along x [Johnson1985, ch. 3].
fn line(material: &Material, wave_number: f64, y: f64) -> [f64; 6] {
    let (g, nu) = (material.shear_modulus, material.poisson_ratio);
    let z = wave_number * y.abs();
    let (k0, k1) = bessel(z);
    let turned = if z == 0.0 { 1.0 } else { z * k1 };
    let round = std::f64::consts::PI * g;
    let mixed = (1.0 - 2.0 * nu) * (-z).exp() / (4.0 * g);
    [
        (1.0 - nu) * k0 / round,
        (k0 - nu * turned) / round,
        ((1.0 - nu) * k0 + nu * turned) / round,
        mixed,
        -mixed * y.signum(),
        -nu * wave_number * y * k0 / round,
    ]
}

/// One pair of rows at one wave number: `int int` of all nine components, [observed][loaded].
pub(super) fn pair(
    material: &Material,
    wave_number: f64,
    distances: &[(f64, f64)],
) -> [[f64; 3]; 3] {
    let mut sum = [0.0; 6];
    for (distance, weight) in distances {
        for (sum, value) in sum.iter_mut().zip(line(material, wave_number, *distance)) {
            *sum += weight * value;
        }
    }
    let [nn, xx, yy, xn, yn, xy] = sum;
    // the matrix of all rows is symmetric, and the opposite distance turns what is odd along y round
    [[xx, xy, xn], [-xy, yy, yn], [xn, -yn, nn]]
}

/// Place of a component in the frame.
pub(super) fn index(component: Component) -> usize {
    match component {
        Component::X => 0,
        Component::Y => 1,
        Component::Normal => 2,
    }
}

/// Modified Bessel functions `K_0` and `K_1`, for positive arguments.
pub(super) fn bessel(z: f64) -> (f64, f64) {
    if z > 700.0 {
        return (0.0, 0.0);
    }
    if z <= 1.0 {
        // power series [AbramowitzStegun1972, 9.6.10 to 9.6.13]
        const EULER: f64 = 0.577_215_664_901_532_9;
        let square = 0.25 * z * z;
        let log = (0.5 * z).ln() + EULER;
        let (mut i0, mut i1, mut k0, mut k1) = (1.0, 1.0, 0.0, -0.5);
        let (mut term, mut harmonic) = (1.0, 0.0);
        let mut of_i1 = 1.0;
        for m in 1..20 {
            let m = f64::from(m);
            term *= square / (m * m);
            harmonic += 1.0 / m;
            i0 += term;
            k0 += term * harmonic;
            of_i1 *= square / (m * (m + 1.0));
            i1 += of_i1;
            k1 -= of_i1 * (harmonic + 0.5 / (m + 1.0));
        }
        return (k0 - log * i0, 1.0 / z + 0.5 * z * (log * i1 + k1));
    }
    // the trapezoidal rule of int exp(-z cosh t) cosh(n t) dt converges faster than any power
    let step = 0.125;
    let (mut k0, mut k1) = (0.5 * (-z).exp(), 0.5 * (-z).exp());
    for n in 1..80 {
        let cosh = (step * f64::from(n)).cosh();
        let value = (-z * cosh).exp();
        k0 += value;
        k1 += value * cosh;
        if value * cosh < 1e-17 * k0 {
            break;
        }
    }
    (step * k0, step * k1)
}
