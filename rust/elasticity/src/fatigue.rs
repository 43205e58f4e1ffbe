// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fatigue of what passes through a contact: Dang Van's criterion.

use mtb_operator::{Monitor, report};
use nalgebra::{DMatrix, DVector, Matrix3, SVector};
use rayon::prelude::*;

use crate::Error;

/// Coordinates of a deviator, in which the distance is the root of `s : s`.
type Deviator = SVector<f64, 5>;

/// Paths between two looks at a monitor.
const BATCH: usize = 256;
/// Relative square of a distance by which a point may lie outside of a ball.
const ROUNDING: f64 = 1e-12;

/// Dang Van's equivalent shear stress [Pa] of each of the `paths` that a stress takes in time (components xx, yy, zz, yz, xz,
/// xy, `states` of them a path): the largest sum over the path of the shear stress about the middle of the path, and of
/// `coefficient` times the hydrostatic stress [DangVanGriveauMessage1989].
///
/// A material that shakes down takes a residual stress on the scale of its grains by which its deviators lie about zero:
/// the middle of the smallest ball that holds them. What is left is that of Tresca. A constant stress so counts by its
/// hydrostatic part alone.
///
/// # Errors
/// [`Error::Interrupted`].
///
/// # Panics
/// Where the numbers are not whole paths.
pub fn dang_van(
    paths: &[f64],
    states: usize,
    coefficient: f64,
    monitor: Monitor<'_>,
) -> Result<Vec<f64>, Error> {
    let length = 6 * states;
    assert!(
        length > 0 && paths.len().is_multiple_of(length),
        "whole paths"
    );
    let mut found = vec![0.0; paths.len() / length];
    for (count, (found, paths)) in found
        .chunks_mut(BATCH)
        .zip(paths.chunks(BATCH * length))
        .enumerate()
    {
        found
            .par_iter_mut()
            .zip(paths.par_chunks(length))
            .for_each(|(found, path)| *found = equivalent(path.as_chunks::<6>().0, coefficient));
        report(monitor, count, f64::NAN)?;
    }
    Ok(found)
}

fn equivalent(path: &[[f64; 6]], coefficient: f64) -> f64 {
    let mut deviators: Vec<Deviator> = path.iter().map(deviator).collect();
    let middle = smallest_ball(&mut deviators);
    let sums = path.iter().map(|stress| {
        let hydrostatic = (stress[0] + stress[1] + stress[2]) / 3.0;
        largest_shear(&(deviator(stress) - middle)) + coefficient * hydrostatic
    });
    sums.fold(f64::NEG_INFINITY, f64::max)
}

fn deviator(&[xx, yy, zz, yz, xz, xy]: &[f64; 6]) -> Deviator {
    let root = std::f64::consts::SQRT_2;
    let along = (2.0 * zz - xx - yy) / 6.0_f64.sqrt();
    Deviator::from([(xx - yy) / root, along, root * yz, root * xz, root * xy])
}

fn largest_shear(s: &Deviator) -> f64 {
    let root = std::f64::consts::SQRT_2;
    let (half, third) = (s[0] / root, s[1] / 6.0_f64.sqrt());
    let (yz, xz, xy) = (s[2] / root, s[3] / root, s[4] / root);
    let (xx, yy, zz) = (half - third, -half - third, 2.0 * third);
    let principal = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues();
    0.5 * (principal.max() - principal.min())
}

/// Middle of the smallest ball that holds all points, which change their order.
fn smallest_ball(points: &mut [Deviator]) -> Deviator {
    ball(points, &mut Vec::new()).0
}

/// Middle and squared radius of the smallest ball that holds `points` and has `border` on its surface: the algorithm
/// of Welzl that moves points on the surface to the front [Gaertner1999].
fn ball(points: &mut [Deviator], border: &mut Vec<Deviator>) -> (Deviator, f64) {
    let (mut middle, mut square) = through(border);
    if border.len() > middle.len() {
        return (middle, square);
    }
    for k in 0..points.len() {
        let point = points[k];
        let away = (point - middle).norm_squared();
        if away <= square + ROUNDING * (away + point.norm_squared()) {
            continue;
        }
        border.push(point);
        (middle, square) = ball(&mut points[..k], border);
        border.pop();
        points[..=k].rotate_right(1);
    }
    (middle, square)
}

/// Middle and squared radius of the smallest ball with these points on its surface; a radius below zero without any.
fn through(border: &[Deviator]) -> (Deviator, f64) {
    let Some((first, others)) = border.split_first() else {
        return (Deviator::zeros(), -1.0);
    };
    let m = others.len();
    let ways: Vec<Deviator> = others.iter().map(|other| other - first).collect();
    let products = DMatrix::from_fn(m, m, |a, b| 2.0 * ways[a].dot(&ways[b]));
    let squares = DVector::from_fn(m, |a, _| ways[a].norm_squared());
    // points that lie on one plane with the others leave it singular: the least solution then
    let shares = products
        .clone()
        .cholesky()
        .map(|factor| factor.solve(&squares))
        .or_else(|| products.svd(true, true).solve(&squares, 1e-12).ok())
        .unwrap_or_else(|| DVector::zeros(m));
    let out: Deviator = ways
        .iter()
        .zip(shares.iter())
        .map(|(way, share)| way * *share)
        .sum();
    (first + out, out.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random numbers in (-1, 1).
    fn random(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Every point is inside, and the middle lies in the hull of those on the surface: no other ball is smaller.
    #[test]
    fn balls_are_the_smallest() {
        let mut seed = 7;
        for count in [1, 2, 3, 6, 20, 200] {
            for flat in [0, 1, 3] {
                let mut points: Vec<Deviator> = (0..count)
                    .map(|_| {
                        Deviator::from_fn(|i, _| if i < flat { 0.3 } else { random(&mut seed) })
                    })
                    .collect();
                let (middle, square) = ball(&mut points, &mut Vec::new());
                let on: Vec<_> = points
                    .iter()
                    .filter(|p| ((*p - middle).norm_squared() - square).abs() < 1e-9)
                    .collect();
                assert!(
                    points
                        .iter()
                        .all(|p| (p - middle).norm_squared() < square + 1e-9)
                );
                // no direction leads away from all of them
                for _ in 0..2000 {
                    let way = Deviator::from_fn(|_, _| random(&mut seed));
                    let nearest = on
                        .iter()
                        .map(|p| way.dot(&(*p - middle)))
                        .fold(f64::MAX, f64::min);
                    assert!(nearest < 1e-7, "{count} points, {flat} flat: {nearest}");
                }
            }
        }
    }

    /// Shear to and fro: its amplitude; tension and compression: half of it, and a third of its part of the mean.
    #[test]
    fn plain_paths() {
        let watch = &mtb_operator::unmonitored;
        let shear = [
            [0.0, 0.0, 0.0, 0.0, 3.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, -1.0, 0.0],
        ]
        .concat();
        assert!((dang_van(&shear, 2, 0.3, watch).unwrap()[0] - 2.0).abs() < 1e-12);
        let tension = [
            [3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [-3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ]
        .concat();
        assert!((dang_van(&tension, 2, 0.3, watch).unwrap()[0] - (1.5 + 0.3)).abs() < 1e-12);
        // a constant stress counts by its mean
        let lifted: Vec<f64> = shear
            .as_chunks::<6>()
            .0
            .iter()
            .flat_map(|s| {
                let [xx, yy, zz, yz, xz, xy] = *s;
                [xx + 6.0, yy - 2.0, zz + 2.0, yz + 9.0, xz, xy]
            })
            .collect();
        assert!((dang_van(&lifted, 2, 0.3, watch).unwrap()[0] - (2.0 + 0.3 * 2.0)).abs() < 1e-12);
    }
}
