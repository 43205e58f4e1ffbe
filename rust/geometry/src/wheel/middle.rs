// SPDX-License-Identifier: MIT OR Apache-2.0
//! The weighted middle of an overlap, which a contact plane lies in.

use super::over::MOST_INCLINED;

/// Weights of the stations of an overlap: the square of the overlap, over the width of the wheel's footprint.
///
/// The footprint is as wide as the root of the overlap, so that a station weighs overlap^(5/2). CONTACT's reference
/// points lie there: those of two wide overlaps within 5 um (`tests/validation/test_whole_wheels.py`). Weights vanish
/// where the overlap ends, so that they change smoothly where a station comes to it or leaves it.
pub(super) struct Middle {
    /// The station that overlaps most.
    pub(super) lowest: usize,
    /// Stations whose slope is near that of the lowest one (n).
    pub(super) is_near: Vec<bool>,
    weight: Vec<f64>,
    total: f64,
}

/// Power of the overlap that a station weighs.
const POWER: f64 = 2.5;

impl Middle {
    /// Of stations that overlap by `overlap` [m] at `across` [m], over a rail of slope angle `slope`; `squares`: their
    /// overlap squared over the width of the footprint, where it is not that of a circle on a straight rail.
    pub(super) fn new(
        overlap: &[f64],
        across: &[f64],
        slope: &[f64],
        squares: Option<&[f64]>,
    ) -> Self {
        let largest = overlap.iter().copied().fold(0.0, f64::max);
        let lowest = overlap.iter().position(|o| *o == largest).unwrap_or(0);
        let is_near: Vec<bool> = slope
            .iter()
            .map(|s| (s - slope[lowest]).abs() <= MOST_INCLINED)
            .collect();
        let mut weight = vec![0.0; overlap.len()];
        for k in stretches(&is_near) {
            let half = 0.5 * (across[k] - across[k - 1]).abs();
            for end in [k - 1, k] {
                weight[end] += half
                    * squares.map_or_else(|| share(overlap[end], largest), |squares| squares[end]);
            }
        }
        // a single place keeps its own plane
        if weight.iter().sum::<f64>() == 0.0 {
            weight[lowest] = 1.0;
        }
        let total = weight.iter().sum();
        Self {
            lowest,
            is_near,
            weight,
            total,
        }
    }

    /// Weighted mean of a value at the stations.
    pub(super) fn mean(&self, value: &dyn Fn(usize) -> f64) -> f64 {
        let sum: f64 = (0..self.weight.len())
            .map(|k| self.weight[k] * value(k))
            .sum();
        sum / self.total
    }

    /// Share of the area of half the overlap, which a Hertzian contact covers, that is not near the plane [-].
    pub(super) fn neglected(&self, overlap: &[f64], across: &[f64], slope: &[f64]) -> f64 {
        let half = 0.5 * overlap[self.lowest];
        let mut area = [0.0; 2];
        for k in 1..overlap.len() {
            let root = mean_root([overlap[k - 1] - half, overlap[k] - half]);
            let width = 0.5 * root * (across[k] - across[k - 1]).abs();
            let size = width / slope[k - 1].cos() + width / slope[k].cos();
            area[usize::from(self.is_near[k - 1] && self.is_near[k])] += size;
        }
        let [far, near] = area;
        if far > 0.0 { far / (far + near) } else { 0.0 }
    }

    /// Change of a weighted mean, as overlap, places across and the value itself change.
    pub(super) fn mean_change<'a>(
        &'a self,
        [overlap, across]: [&[f64]; 2],
        [by_overlap, by_across]: [&[f64]; 2],
    ) -> impl Fn(&dyn Fn(usize) -> f64, &dyn Fn(usize) -> f64) -> f64 + 'a {
        let n = overlap.len();
        let mut changed = vec![0.0; n];
        let largest = overlap[self.lowest];
        for k in stretches(&self.is_near) {
            let width = across[k] - across[k - 1];
            let by_width = width.signum() * (by_across[k] - by_across[k - 1]);
            for end in [k - 1, k] {
                // over the largest overlap, which all weights are, so that it may be taken to stay
                let by_share = POWER * (overlap[end] / largest).max(0.0).powf(POWER - 1.0)
                    / largest
                    * by_overlap[end];
                changed[end] +=
                    0.5 * (by_width * share(overlap[end], largest) + width.abs() * by_share);
            }
        }
        let by_total: f64 = changed.iter().sum();
        move |value, by_value| {
            let mean = self.mean(value);
            let sum: f64 = (0..n)
                .map(|k| changed[k] * value(k) + self.weight[k] * by_value(k))
                .sum();
            (sum - mean * by_total) / self.total
        }
    }
}

/// The stretches between stations that both count, by their second one.
fn stretches(counts: &[bool]) -> impl Iterator<Item = usize> {
    (1..counts.len()).filter(|&k| counts[k - 1] && counts[k])
}

/// Weight of a station, over that of one that overlaps most.
pub(super) fn share(overlap: f64, largest: f64) -> f64 {
    if overlap > 0.0 {
        (overlap / largest).powf(POWER)
    } else {
        0.0
    }
}

/// Mean of the root of the positive part of a linear function by its values at the ends.
fn mean_root([a, b]: [f64; 2]) -> f64 {
    if a <= 0.0 && b <= 0.0 {
        return 0.0;
    }
    if a > 0.0 && b > 0.0 {
        let (p, q) = (a.sqrt(), b.sqrt());
        return 2.0 / 3.0 * (p * p + p * q + q * q) / (p + q);
    }
    let (high, low) = if b > a { (b, a) } else { (a, b) };
    2.0 / 3.0 * high * high.sqrt() / (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_root_is_that_of_a_sum() {
        for ends in [
            [2.0, 5.0],
            [5.0, 2.0],
            [-1.0, 3.0],
            [3.0, -0.5],
            [1.0, 1.0],
            [-1.0, -2.0],
        ] {
            let mean = mean_root(ends);
            let n = 20_000;
            let sum: f64 = (0..n)
                .map(|k| {
                    let t = (f64::from(k) + 0.5) / f64::from(n);
                    (ends[0] + t * (ends[1] - ends[0])).max(0.0).sqrt()
                })
                .sum();
            assert!((mean - sum / f64::from(n)).abs() < 1e-6, "{ends:?}");
        }
    }

    #[test]
    fn the_middle_of_two_parabolas_is_their_mean_by_squares_over_footprints() {
        // of an overlap d (1 - s^2) on |s| < 1, overlap^(5/2) has the integral d^(5/2) 5 pi / 16
        let (depth, width) = ([1.0, 0.7], [1.0, 2.0]);
        let n = 4001;
        let across: Vec<f64> = (0..n)
            .map(|k| f64::from(k) * 8.0 / f64::from(n - 1))
            .collect();
        let overlap: Vec<f64> = across
            .iter()
            .map(|y| {
                let of =
                    |c: usize, middle: f64| depth[c] * (1.0 - ((y - middle) / width[c]).powi(2));
                of(0, 1.0).max(of(1, 5.0))
            })
            .collect();
        let slope = vec![0.0; overlap.len()];
        let middle = Middle::new(&overlap, &across, &slope, None);
        let weight = [0, 1].map(|c| depth[c].powf(2.5) * width[c]);
        let exact = (weight[0] + 5.0 * weight[1]) / (weight[0] + weight[1]);
        assert!((middle.mean(&|k| across[k]) - exact).abs() < 1e-5);
        // and follows when one of them deepens
        let deeper = |by: f64| -> Vec<f64> {
            let last = overlap.iter().zip(&across);
            last.map(|(o, y)| if *y > 2.5 { o + by } else { *o })
                .collect()
        };
        let at = |by: f64| Middle::new(&deeper(by), &across, &slope, None).mean(&|k| across[k]);
        let by_overlap: Vec<f64> = across.iter().map(|y| f64::from(*y > 2.5)).collect();
        let still = vec![0.0; overlap.len()];
        let found =
            middle.mean_change([&overlap, &across], [&by_overlap, &still])(&|k| across[k], &|_| {
                0.0
            });
        let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!(
            (found - difference).abs() < 1e-6 * difference.abs(),
            "{found} {difference}"
        );
    }
}
