// SPDX-License-Identifier: MIT OR Apache-2.0
//! The weighted middle of an overlap, which a contact plane lies in.

use super::over::MOST_INCLINED;

/// Weights of the stations of an overlap: how wide the footprint of the wheel is there.
///
/// Half the overlap is what a Hertzian contact covers, and the footprint is as wide as the root of what is more. The
/// overlap is linear between two stations and its root is integrated exactly, so that the weights change smoothly
/// where a station comes to it or leaves it.
pub(super) struct Middle {
    /// The station that overlaps most.
    pub(super) lowest: usize,
    /// Stations whose slope is near that of the lowest one (n).
    pub(super) is_near: Vec<bool>,
    weight: Vec<f64>,
    total: f64,
}

impl Middle {
    /// Of stations that overlap by `overlap` [m] at `across` [m], over a rail of slope angle `slope`.
    pub(super) fn new(overlap: &[f64], across: &[f64], slope: &[f64]) -> Self {
        let largest = overlap.iter().copied().fold(0.0, f64::max);
        let lowest = overlap.iter().position(|o| *o == largest).unwrap_or(0);
        let is_near: Vec<bool> = slope
            .iter()
            .map(|s| (s - slope[lowest]).abs() <= MOST_INCLINED)
            .collect();
        let mut weight = footprint(overlap, across, largest, |k| is_near[k]);
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

    /// Share of the area that is not near the plane [-].
    pub(super) fn neglected(&self, overlap: &[f64], across: &[f64], slope: &[f64]) -> f64 {
        let area =
            |weight: &[f64]| -> f64 { weight.iter().zip(slope).map(|(w, s)| w / s.cos()).sum() };
        let all = area(&footprint(overlap, across, overlap[self.lowest], |_| true));
        let near = area(&self.weight);
        if all > near { (all - near) / all } else { 0.0 }
    }

    /// Change of a weighted mean, as overlap, places across and the value itself change.
    pub(super) fn mean_change<'a>(
        &'a self,
        [overlap, across]: [&[f64]; 2],
        [by_overlap, by_across]: [&[f64]; 2],
    ) -> impl Fn(&dyn Fn(usize) -> f64, &dyn Fn(usize) -> f64) -> f64 + 'a {
        let n = overlap.len();
        let mut changed = vec![0.0; n];
        let half = 0.5 * overlap[self.lowest];
        let by_half = 0.5 * by_overlap[self.lowest];
        for k in (1..n).filter(|&k| self.is_near[k - 1] && self.is_near[k]) {
            let width = across[k] - across[k - 1];
            let (root, by) = mean_root([overlap[k - 1] - half, overlap[k] - half]);
            let by_width = width.signum() * (by_across[k] - by_across[k - 1]);
            let by_root = by[0] * (by_overlap[k - 1] - by_half) + by[1] * (by_overlap[k] - by_half);
            let change = 0.5 * (by_width * root + width.abs() * by_root);
            changed[k - 1] += change;
            changed[k] += change;
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

/// Half of what each of the two stretches beside a station weighs, of those whose ends count.
fn footprint(
    overlap: &[f64],
    across: &[f64],
    largest: f64,
    counts: impl Fn(usize) -> bool,
) -> Vec<f64> {
    let mut weight = vec![0.0; overlap.len()];
    for k in (1..overlap.len()).filter(|&k| counts(k - 1) && counts(k)) {
        let ends = [overlap[k - 1] - 0.5 * largest, overlap[k] - 0.5 * largest];
        let half = 0.5 * mean_root(ends).0 * (across[k] - across[k - 1]).abs();
        weight[k - 1] += half;
        weight[k] += half;
    }
    weight
}

/// Mean of the root of the positive part of a linear function by its values at the ends, and its derivatives by these.
fn mean_root(ends: [f64; 2]) -> (f64, [f64; 2]) {
    let [a, b] = ends;
    if a <= 0.0 && b <= 0.0 {
        return (0.0, [0.0; 2]);
    }
    if a > 0.0 && b > 0.0 {
        let (p, q) = (a.sqrt(), b.sqrt());
        let sum = p + q;
        let mean = 2.0 / 3.0 * (p * p + p * q + q * q) / sum;
        return (
            mean,
            [(p, q), (q, p)].map(|(p, q)| (p + 2.0 * q) / (3.0 * sum * sum)),
        );
    }
    let (high, low) = if b > a { (b, a) } else { (a, b) };
    let mean = 2.0 / 3.0 * high * high.sqrt() / (high - low);
    let by_low = mean / (high - low);
    let by_high = (high.sqrt() - mean) / (high - low);
    (
        mean,
        if b > a {
            [by_low, by_high]
        } else {
            [by_high, by_low]
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_root_is_that_of_a_sum_and_has_its_differences() {
        for ends in [
            [2.0, 5.0],
            [5.0, 2.0],
            [-1.0, 3.0],
            [3.0, -0.5],
            [1.0, 1.0],
            [-1.0, -2.0],
        ] {
            let (mean, by) = mean_root(ends);
            let n = 20_000;
            let sum: f64 = (0..n)
                .map(|k| {
                    let t = (f64::from(k) + 0.5) / f64::from(n);
                    (ends[0] + t * (ends[1] - ends[0])).max(0.0).sqrt()
                })
                .sum();
            assert!((mean - sum / f64::from(n)).abs() < 1e-6, "{ends:?}");
            for c in 0..2 {
                let at = |step: f64| {
                    let mut moved = ends;
                    moved[c] += step;
                    mean_root(moved).0
                };
                let difference = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((by[c] - difference).abs() < 1e-8, "{ends:?} {c}");
            }
        }
    }
}
