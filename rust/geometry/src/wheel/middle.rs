// SPDX-License-Identifier: MIT OR Apache-2.0
//! The weighted middle of an overlap, which a contact plane lies in.

use super::over::MOST_INCLINED;

/// Weights of the stations of an overlap: the square of the overlap, over the width of the wheel's footprint.
///
/// The footprint is as wide as the root of the overlap, so that a station weighs overlap^(5/2). CONTACT's reference
/// points lie there: those of two wide overlaps within 5 um (`tests/validation/test_whole_wheels.py`). Weights vanish
/// where the overlap ends, so that they change smoothly where a station comes to it or leaves it.
///
/// Only slopes near that of the deepest places count. This one is a mean by a high power of the overlap, and a stretch
/// between stations counts by its share: in a contact that hugs the root of a flange the deepest place moves from tread
/// to flange at once, and the plane must turn with the pose without a jump.
pub(super) struct Middle {
    /// The station that overlaps most.
    pub(super) lowest: usize,
    /// Stations whose slope is near that of the deepest places (n).
    pub(super) is_near: Vec<bool>,
    /// Slope angle of the deepest places.
    deepest: f64,
    /// Share of the stretch before a station that is near (n), the first without one.
    near: Vec<f64>,
    weight: Vec<f64>,
    total: f64,
}

/// Power of the overlap that a station weighs.
const POWER: f64 = 2.5;
/// The same for the slope of the deepest places.
const OF_DEEPEST: f64 = 10.0;

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
        let deep = |k: usize| width(across, k).0 * (overlap[k].max(0.0) / largest).powf(OF_DEEPEST);
        let [sum, all] = (0..slope.len()).fold([0.0; 2], |[sum, all], k| {
            [sum + deep(k) * slope[k], all + deep(k)]
        });
        let deepest = if all > 0.0 { sum / all } else { slope[lowest] };
        let is_near: Vec<bool> = slope
            .iter()
            .map(|s| (s - deepest).abs() <= MOST_INCLINED)
            .collect();
        let mut near = vec![0.0; slope.len()];
        for k in 1..slope.len() {
            near[k] = within([slope[k - 1] - deepest, slope[k] - deepest]).0;
        }
        let mut weight = vec![0.0; overlap.len()];
        for k in 1..overlap.len() {
            let half = 0.5 * near[k] * (across[k] - across[k - 1]).abs();
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
            deepest,
            near,
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
            area[0] += (1.0 - self.near[k]) * size;
            area[1] += self.near[k] * size;
        }
        let [far, near] = area;
        if far > 0.0 { far / (far + near) } else { 0.0 }
    }

    /// Change of a weighted mean, as overlap, places across, slopes and the value itself change; `squares` and their
    /// change where the middle was made by them.
    pub(super) fn mean_change<'a>(
        &'a self,
        [overlap, across, slope]: [&[f64]; 3],
        [by_overlap, by_across, by_slope]: [&[f64]; 3],
        squares: Option<[&[f64]; 2]>,
    ) -> impl Fn(&dyn Fn(usize) -> f64, &dyn Fn(usize) -> f64) -> f64 + 'a {
        let n = overlap.len();
        let mut changed = vec![0.0; n];
        let largest = overlap[self.lowest];
        // of the slope of the deepest places
        let (mut by_deepest, mut all) = (0.0, 0.0);
        for k in (0..n).filter(|k| overlap[*k] > 0.0) {
            let less = (overlap[k] / largest).powf(OF_DEEPEST - 1.0);
            let (width, signs) = width(across, k);
            let by_width: f64 = signs.map(|(end, sign)| sign * by_across[end]).sum();
            let deep = width * less * overlap[k] / largest;
            let by_deep = width * OF_DEEPEST * less / largest * by_overlap[k]
                + by_width * less * overlap[k] / largest;
            by_deepest += deep * by_slope[k] + by_deep * (slope[k] - self.deepest);
            all += deep;
        }
        if all > 0.0 {
            by_deepest /= all;
        }
        for k in 1..n {
            let ends = [k - 1, k];
            let (_, rates) = within(ends.map(|end| slope[end] - self.deepest));
            let by_near: f64 = (ends.iter().zip(rates))
                .map(|(end, rate)| rate * (by_slope[*end] - by_deepest))
                .sum();
            let width = across[k] - across[k - 1];
            let by_width = width.signum() * (by_across[k] - by_across[k - 1]);
            for end in [k - 1, k] {
                let (share, by_share) = squares.map_or_else(
                    || {
                        // over the largest overlap, which all weights are, so that it may be taken to stay
                        let rate = POWER * (overlap[end] / largest).max(0.0).powf(POWER - 1.0);
                        (
                            share(overlap[end], largest),
                            rate / largest * by_overlap[end],
                        )
                    },
                    |[squares, by_squares]| (squares[end], by_squares[end]),
                );
                let by_area = by_width * share + width.abs() * by_share;
                changed[end] += 0.5 * (self.near[k] * by_area + by_near * width.abs() * share);
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

/// Half of the distance between the neighbours of a station, and its rates by the places of stations.
fn width(across: &[f64], k: usize) -> (f64, impl Iterator<Item = (usize, f64)>) {
    let ends = [k.saturating_sub(1), k, (k + 1).min(across.len() - 1)];
    let steps = [0, 1].map(|i| across[ends[i + 1]] - across[ends[i]]);
    let signs = steps.map(|step| {
        if step == 0.0 {
            0.0
        } else {
            0.5 * step.signum()
        }
    });
    let rates = [0, 1]
        .into_iter()
        .flat_map(move |i| [(ends[i + 1], signs[i]), (ends[i], -signs[i])]);
    (0.5 * (steps[0].abs() + steps[1].abs()), rates)
}

/// Share of a stretch whose slope is within the accepted inclination, by the slopes at its ends against the middle, and
/// its rates by both.
fn within([a, b]: [f64; 2]) -> (f64, [f64; 2]) {
    let inside = |s: f64| s.abs() <= MOST_INCLINED;
    if inside(a) && inside(b) {
        return (1.0, [0.0; 2]);
    }
    let (low, high) = (a.min(b), a.max(b));
    if low > MOST_INCLINED || high < -MOST_INCLINED {
        return (0.0, [0.0; 2]);
    }
    let width = high - low;
    let (bottom, top) = (low.max(-MOST_INCLINED), high.min(MOST_INCLINED));
    let part = (top - bottom) / width;
    // an end that counts moves its border with it, and both move the width
    let by_high = (f64::from(high <= MOST_INCLINED) - part) / width;
    let by_low = (part - f64::from(low >= -MOST_INCLINED)) / width;
    (
        part,
        if b > a {
            [by_low, by_high]
        } else {
            [by_high, by_low]
        },
    )
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
    fn the_middle_moves_without_a_jump_from_one_slope_to_another() {
        // a root that turns by 50 degrees, touched at both of its ends
        let n = 801;
        let across: Vec<f64> = (0..n).map(|k| 1e-5 * f64::from(k)).collect();
        let slope: Vec<f64> = (0..n)
            .map(|k| 0.35 + 0.9 * f64::from(k) / f64::from(n - 1))
            .collect();
        let overlap = |tilt: f64| -> Vec<f64> {
            (0..n)
                .map(|k| {
                    let s = f64::from(k) / f64::from(n - 1);
                    5e-5 * (1.0
                        - 0.2 * (std::f64::consts::TAU * s).sin().powi(2)
                        - (2.0 * s - 1.0).powi(4))
                        + tilt * (s - 0.5)
                })
                .collect()
        };
        let angle =
            |tilt: f64| Middle::new(&overlap(tilt), &across, &slope, None).mean(&|k| slope[k]);
        let tilts: Vec<f64> = (-100..=100).map(|k| 5e-7 * f64::from(k)).collect();
        let angles: Vec<f64> = tilts.iter().map(|tilt| angle(*tilt)).collect();
        let far = angles[200] - angles[0];
        assert!(far > 0.15, "{far}");
        for pair in angles.windows(2) {
            assert!((pair[1] - pair[0]).abs() < 0.1 * far, "{pair:?}");
        }
        // and its change is that of differences
        let by_overlap: Vec<f64> = slope.iter().map(|s| (s - 0.8) / 0.9).collect();
        let still = vec![0.0; slope.len()];
        for tilt in [-2e-5, -3e-6, 0.0, 7e-6] {
            let middle = Middle::new(&overlap(tilt), &across, &slope, None);
            let found = middle.mean_change(
                [&overlap(tilt), &across, &slope],
                [&by_overlap, &still, &still],
                None,
            )(&|k| slope[k], &|_| 0.0);
            let difference = (angle(tilt + 1e-11) - angle(tilt - 1e-11)) / 2e-11;
            assert!(
                (found / difference - 1.0).abs() < 1e-4,
                "{found} {difference}"
            );
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
        let found = middle.mean_change(
            [&overlap, &across, &slope],
            [&by_overlap, &still, &still],
            None,
        )(&|k| across[k], &|_| 0.0);
        let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!(
            (found - difference).abs() < 1e-6 * difference.abs(),
            "{found} {difference}"
        );
    }
}
