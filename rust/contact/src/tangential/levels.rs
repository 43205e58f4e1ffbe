// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::Grid;

/// Fewest cells along a direction that are worth halving.
const FEWEST: usize = 10;

/// From one grid to the next coarser one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coarsening {
    pub(super) fine: Grid,
    pub(super) coarse: Grid,
    /// Cells merged along x and y: 1 or 2.
    factor: [usize; 2],
}

impl Coarsening {
    /// Halves both directions, if that leaves enough cells.
    pub(super) fn of(fine: Grid) -> Option<Self> {
        let short = fine.nx.min(fine.ny);
        let factor = if short >= FEWEST {
            [2, 2]
        } else if short == 1 && fine.points() >= 4 * FEWEST {
            [
                if fine.nx > 1 { 2 } else { 1 },
                if fine.ny > 1 { 2 } else { 1 },
            ]
        } else {
            return None;
        };
        Some(Self {
            fine,
            factor,
            coarse: Grid {
                nx: fine.nx.div_ceil(factor[0]),
                ny: fine.ny.div_ceil(factor[1]),
                dx: fine.dx * factor[0] as f64,
                dy: fine.dy * factor[1] as f64,
            },
        })
    }

    /// Coarse value as the mean of the fine cells it covers, cells outside counting as zero.
    pub(super) fn average(&self, fine: &[f64]) -> Vec<f64> {
        let weight = 1.0 / (self.factor[0] * self.factor[1]) as f64;
        let mut coarse = vec![0.0; self.coarse.points()];
        for j in 0..self.fine.ny {
            for i in 0..self.fine.nx {
                coarse[self.parent(i, j)] += weight * fine[j * self.fine.nx + i];
            }
        }
        coarse
    }

    /// Mean over the fine cells weighted by `weight`; zero where that is zero.
    pub(super) fn weighted(&self, fine: &[f64], weight: &[f64]) -> Vec<f64> {
        let product: Vec<f64> = fine.iter().zip(weight).map(|(a, b)| a * b).collect();
        let sum = self.average(weight);
        self.average(&product)
            .iter()
            .zip(&sum)
            .map(|(a, b)| if *b > 0.0 { a / b } else { 0.0 })
            .collect()
    }

    fn parent(&self, i: usize, j: usize) -> usize {
        (j / self.factor[1]) * self.coarse.nx + i / self.factor[0]
    }

    /// Fine field from a coarse one by bilinear interpolation of its ratio to `coarse_scale`, over
    /// the coarse cells where that is positive, times `fine_scale`.
    pub(super) fn prolong(
        &self,
        coarse: &[f64],
        coarse_scale: &[f64],
        fine_scale: &[f64],
    ) -> Vec<f64> {
        let mut fine = vec![0.0; self.fine.points()];
        let neighbours = |i: usize, k: usize, n: usize| -> [(usize, f64); 2] {
            if self.factor[k] == 1 {
                return [(i, 1.0), (i, 0.0)];
            }
            let own = i / 2;
            let other = if i.is_multiple_of(2) {
                own.checked_sub(1)
            } else {
                (own + 1 < n).then_some(own + 1)
            };
            [(own, 0.75), (other.unwrap_or(own), 0.25)]
        };
        for j in 0..self.fine.ny {
            for i in 0..self.fine.nx {
                let k = j * self.fine.nx + i;
                if fine_scale[k] <= 0.0 {
                    continue;
                }
                let (mut sum, mut total) = (0.0, 0.0);
                for (jc, wy) in neighbours(j, 1, self.coarse.ny) {
                    for (ic, wx) in neighbours(i, 0, self.coarse.nx) {
                        let c = jc * self.coarse.nx + ic;
                        if coarse_scale[c] > 0.0 {
                            sum += wx * wy * coarse[c] / coarse_scale[c];
                            total += wx * wy;
                        }
                    }
                }
                if total > 0.0 {
                    fine[k] = sum / total * fine_scale[k];
                }
            }
        }
        fine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_and_prolongs_a_constant_ratio() {
        let fine = Grid {
            nx: 11,
            ny: 12,
            dx: 1.0,
            dy: 2.0,
        };
        let c = Coarsening::of(fine).unwrap();
        assert_eq!((c.coarse.nx, c.coarse.ny), (6, 6));
        let scale: Vec<f64> = (0..132)
            .map(|k| (f64::from(k % 7) - 1.0).max(0.0))
            .collect();
        let coarse_scale = c.average(&scale);
        assert!((coarse_scale.iter().sum::<f64>() * 4.0 - scale.iter().sum::<f64>()).abs() < 1e-12);
        let coarse: Vec<f64> = coarse_scale.iter().map(|s| 0.3 * s).collect();
        for (f, s) in c.prolong(&coarse, &coarse_scale, &scale).iter().zip(&scale) {
            assert!((f - 0.3 * s).abs() < 1e-12);
        }
    }
}
