// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stress under all cells of a grid, by convolutions.

use mtb_operator::{Grid, Kernel, MEMORY_LIMIT, Monitor, Spectra, Transform, check_memory, report};
use rayon::prelude::*;

use super::super::Medium;
use super::inside::{Inside, check};
use super::rectangle::{CLOSED_TO, Responses, corner, difference, far, is_near};
use super::waves::periodic;
use crate::Error;

/// Components of a stress.
const COMPONENTS: usize = 6;

/// Rows of cells that share the antiderivatives at their corners.
const GROUP: usize = 8;

/// What components are odd in, along x and along y, under a traction along x; under one along y likewise with x and y
/// exchanged, and under a pressure.
const ODD: [[[bool; 2]; COMPONENTS]; 3] = {
    const EVEN: [bool; 2] = [false, false];
    const X: [bool; 2] = [true, false];
    const Y: [bool; 2] = [false, true];
    const BOTH: [bool; 2] = [true, true];
    [
        [X, X, X, BOTH, EVEN, Y],
        [Y, Y, Y, EVEN, BOTH, X],
        [EVEN, EVEN, EVEN, Y, X, BOTH],
    ]
};

/// The inside of a half-space under uniform tractions on the cells of a grid: stress below their centres.
///
/// The transforms of the tractions are taken once. Each depth then takes one convolution for each component. In the
/// body's own frame (tangential 1, tangential 2, into), tension positive.
pub struct StressBelow {
    medium: Medium,
    grid: Grid,
    is_periodic: bool,
    transform: Transform,
    /// Which of the loads act: along x, along y, pressure.
    loads: Vec<usize>,
    spectra: Spectra,
}

impl StressBelow {
    /// Under tractions on the body along x and along y, and a pressure, each (n) [Pa].
    ///
    /// # Errors
    /// [`Error::Material`], [`Error::Shape`], [`Error::NotFinite`], and [`Error::CarriedAway`] for tractions along a
    /// layer that slides on its base.
    pub fn new(
        medium: impl Into<Medium>,
        grid: Grid,
        traction: [&[f64]; 3],
    ) -> Result<Self, Error> {
        let shape = [grid.nx, grid.ny];
        let transform = Transform::new(shape, shape);
        Self::with(medium.into(), grid, traction, transform, false)
    }

    /// Under a pressure (n) [Pa] that repeats itself with the grid, along x and along y, between whose values waves go
    /// on. The mean pressure acts on the whole body, whose sides cannot move apart.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn periodic(
        medium: impl Into<Medium>,
        grid: Grid,
        pressure: &[f64],
    ) -> Result<Self, Error> {
        let none = vec![0.0; pressure.len()];
        let transform = Transform::periodic([grid.nx, grid.ny]);
        let traction = [none.as_slice(), &none, pressure];
        Self::with(medium.into(), grid, traction, transform, true)
    }

    fn with(
        medium: Medium,
        grid: Grid,
        traction: [&[f64]; 3],
        transform: Transform,
        is_periodic: bool,
    ) -> Result<Self, Error> {
        for values in traction {
            if values.len() != grid.points() {
                return Err(Error::Shape {
                    name: "traction",
                    found: values.len(),
                    expected: grid.points(),
                });
            }
            if let Some(index) = values.iter().position(|v| !v.is_finite()) {
                return Err(Error::NotFinite {
                    name: "traction",
                    index,
                });
            }
        }
        let loads: Vec<usize> = (0..3)
            .filter(|load| traction[*load].iter().any(|v| *v != 0.0))
            .collect();
        check(&medium, loads.iter().any(|load| *load < 2), &[])?;
        let inputs: Vec<&[f64]> = loads.iter().map(|load| traction[*load]).collect();
        let spectra = transform.spectra(&inputs);
        Ok(Self {
            medium,
            grid,
            is_periodic,
            transform,
            loads,
            spectra,
        })
    }

    /// Convolutions of [`Self::at`] for each depth.
    pub fn convolutions(&self) -> usize {
        if self.loads.is_empty() { 0 } else { COMPONENTS }
    }

    /// Stress [Pa] at `depths` [m] below the centres of the cells: for each depth the components xx, yy, zz, yz, xz, xy,
    /// each (n).
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::AboveSurface`] for a negative depth, [`Error::InRigidBase`], [`Error::Operator`] for more than the memory
    /// holds, [`Error::Interrupted`].
    pub fn at(&self, depths: &[f64], monitor: Monitor<'_>) -> Result<Vec<f64>, Error> {
        for (index, depth) in depths.iter().copied().enumerate() {
            if !depth.is_finite() {
                return Err(Error::NotFinite {
                    name: "depth",
                    index,
                });
            }
            if depth < 0.0 {
                return Err(Error::AboveSurface { index, depth });
            }
        }
        check(&self.medium, false, depths)?;
        let n = self.grid.points();
        let threads = rayon::current_num_threads().clamp(1, depths.len().max(1));
        // results, and for each depth at work its influences and their spectra
        let working = 8 * COMPONENTS * (2 + 2 * self.loads.len()) * threads;
        let bytes = (n * (8 * COMPONENTS * depths.len() + working)) as f64;
        check_memory(n, bytes, 2.0 * MEMORY_LIMIT).map_err(Error::Operator)?;
        let mut stress = vec![0.0; depths.len() * COMPONENTS * n];
        if self.loads.is_empty() {
            return Ok(stress);
        }
        let rounds = stress
            .chunks_mut(threads * COMPONENTS * n)
            .zip(depths.chunks(threads));
        for (number, (parts, depths)) in rounds.enumerate() {
            report(monitor, number, f64::NAN).map_err(|_| Error::Interrupted)?;
            parts
                .par_chunks_mut(COMPONENTS * n)
                .zip(depths)
                .for_each(|(part, depth)| self.at_depth(*depth, part));
        }
        Ok(stress)
    }

    fn at_depth(&self, depth: f64, stress: &mut [f64]) {
        let kernels = if self.is_periodic {
            self.periodic_kernels(depth)
        } else {
            self.kernels(depth)
        };
        let rows: Vec<Vec<Option<&Kernel>>> = (0..COMPONENTS)
            .map(|k| {
                let of_load = |load: usize| Some(&kernels[load * COMPONENTS + k]);
                (0..self.loads.len()).map(of_load).collect()
            })
            .collect();
        let rows: Vec<&[Option<&Kernel>]> = rows.iter().map(Vec::as_slice).collect();
        let mut outputs: Vec<&mut [f64]> = stress.chunks_mut(self.grid.points()).collect();
        self.transform.products(&rows, &self.spectra, &mut outputs);
    }

    /// By load and component.
    fn kernels(&self, depth: f64) -> Vec<Kernel> {
        let (nx, n) = (self.grid.nx, self.grid.points());
        let table = self.influences(depth);
        let kinds = self.loads.iter().flat_map(|load| ODD[*load]);
        kinds
            .zip(table.chunks(n))
            .map(|(odd, values)| {
                self.transform
                    .mirrored_kernel(odd, |i, j| values[j * nx + i])
            })
            .collect()
    }

    fn periodic_kernels(&self, depth: f64) -> Vec<Kernel> {
        let shape = [self.grid.nx, self.grid.ny];
        let period = [
            self.grid.nx as f64 * self.grid.dx,
            self.grid.ny as f64 * self.grid.dy,
        ];
        let inside = Inside::new(&self.medium, depth);
        let waves = |wave_number: f64| inside.waves(wave_number);
        (0..COMPONENTS)
            .map(|k| {
                self.transform.kernel_from_spectrum(|kx, ky| {
                    periodic(&waves, inside.poisson_ratio, k, [kx, ky], shape, period)
                })
            })
            .collect()
    }

    /// Stress at offsets `i, j >= 0` of cells, by load, component and offset.
    fn influences(&self, depth: f64) -> Vec<f64> {
        let Grid { nx, ny, dx, dy } = self.grid;
        let unit = dx.max(dy);
        let sides = [dx, dy];
        let (dx, dy, z) = (dx / unit, dy / unit, depth / unit);
        let inside = Inside::new(&self.medium, depth);
        let nu = inside.poisson_ratio;
        let width = self.loads.len() * COMPONENTS;
        let mut by_cell = vec![0.0; nx * ny * width];
        by_cell
            .par_chunks_mut(GROUP * nx * width)
            .enumerate()
            .for_each(|(group, values)| {
                let first = group * GROUP;
                let edge = |k: usize, d: f64| (k as f64 - 0.5) * d;
                let row = |j: usize| -> Vec<Responses> {
                    let y = edge(j, dy);
                    let reach = (CLOSED_TO + 1.0).powi(2) - y * y - z * z;
                    (0..=nx)
                        .map(|i| edge(i, dx))
                        .take_while(|x| x * x <= reach)
                        .map(|x| corner(nu, x, y, z))
                        .collect()
                };
                let mut below = row(first);
                for (j, values) in (first..).zip(values.chunks_mut(nx * width)) {
                    let above = row(j + 1);
                    for (i, values) in values.chunks_mut(width).enumerate() {
                        let offset = [i as f64 * dx, j as f64 * dy, z];
                        let corners = (below.get(i + 1), above.get(i + 1));
                        let mut found = match corners {
                            (Some(b), Some(d)) if is_near(offset) => {
                                difference([[&below[i], b], [&above[i], d]])
                            }
                            _ => far(nu, offset, [dx, dy]),
                        };
                        let place = [i as f64 * sides[0], j as f64 * sides[1]];
                        inside.add_remainder(&mut found, place, sides);
                        let loads = self.loads.iter().flat_map(|load| found[*load]);
                        for (value, found) in values.iter_mut().zip(loads) {
                            *value = found;
                        }
                    }
                    below = above;
                }
            });
        let mut table = vec![0.0; by_cell.len()];
        for (k, values) in table.chunks_mut(nx * ny).enumerate() {
            for (value, cell) in values.iter_mut().zip(by_cell.chunks(width)) {
                *value = cell[k];
            }
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use mtb_operator::unmonitored;

    use super::super::{LoadedCell, stress_at};
    use super::*;
    use crate::Material;

    const STEEL: Material = Material {
        shear_modulus: 82e9,
        poisson_ratio: 0.28,
    };

    fn loads(n: usize) -> [Vec<f64>; 3] {
        [0.7, 1.3, 2.1].map(|step| (0..n).map(|k| (step * k as f64).sin() + 0.2).collect())
    }

    #[test]
    fn convolutions_equal_sums_over_cells() {
        for (nx, ny, dx, dy) in [
            (9, 6, 1e-3, 1.5e-3),
            (1, 5, 2e-3, 1e-3),
            (150, 3, 1e-3, 1e-3),
        ] {
            let grid = Grid::new(nx, ny, dx, dy).expect("a grid");
            let traction = loads(grid.points());
            let place = |k: usize| [(k % nx) as f64 * dx, (k / nx) as f64 * dy];
            let cells: Vec<LoadedCell> = (0..grid.points())
                .map(|k| LoadedCell {
                    centre: place(k),
                    sides: [dx, dy],
                    traction: [0, 1, 2].map(|c| traction[c][k]),
                })
                .collect();
            let below = StressBelow::new(STEEL, grid, [0, 1, 2].map(|c| traction[c].as_slice()))
                .expect("tractions");
            let depths = [0.0, 0.4e-3, 0.2];
            let found = below.at(&depths, &unmonitored).expect("a stress");
            assert_eq!(below.convolutions(), 6);
            for (depth, found) in depths.iter().zip(found.chunks(6 * grid.points())) {
                let points: Vec<[f64; 3]> = (0..grid.points())
                    .map(|k| [place(k)[0], place(k)[1], *depth])
                    .collect();
                let summed = stress_at(STEEL, &cells, &points, &unmonitored).expect("a sum");
                let scale = summed
                    .iter()
                    .flatten()
                    .fold(0.0, |m: f64, v| m.max(v.abs()));
                for (k, stress) in summed.iter().enumerate() {
                    for (c, value) in stress.iter().enumerate() {
                        let error = (found[c * grid.points() + k] - value).abs() / scale;
                        assert!(error < 1e-12, "{depth} {k} {c}: {error:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn periodic_stress_is_that_of_many_periods() {
        let (nx, ny) = (8, 6);
        let d = 1e-3;
        let grid = Grid::new(nx, ny, d, d).expect("a grid");
        // waves the grid resolves, without a mean
        let wave = |x: f64, y: f64| {
            let turn = 2.0 * std::f64::consts::PI;
            (turn * x / (nx as f64 * d)).cos() + (turn * y / (ny as f64 * d)).sin()
        };
        let pressure: Vec<f64> = (0..nx * ny)
            .map(|k| wave((k % nx) as f64 * d, (k / nx) as f64 * d))
            .collect();
        let below = StressBelow::periodic(STEEL, grid, &pressure).expect("a pressure");
        let depth = 0.7e-3;
        let found = below.at(&[depth], &unmonitored).expect("a stress");
        // the same wave on fine cells, far beyond one period
        let (fine, reach) = (0.25e-3, 60);
        let mut cells = Vec::new();
        for j in -(reach * 4 * ny as i32)..reach * 4 * ny as i32 {
            for i in -(reach * 4 * nx as i32)..reach * 4 * nx as i32 {
                let centre = [(f64::from(i) + 0.5) * fine, (f64::from(j) + 0.5) * fine];
                if centre[0].hypot(centre[1]) < 0.1 {
                    cells.push(LoadedCell {
                        centre,
                        sides: [fine, fine],
                        traction: [0.0, 0.0, wave(centre[0], centre[1])],
                    });
                }
            }
        }
        let k = 2 * nx + 3;
        let points = [[3.0 * d, 2.0 * d, depth]];
        let summed = stress_at(STEEL, &cells, &points, &unmonitored).expect("a sum")[0];
        for (c, value) in summed.iter().enumerate() {
            let own = found[c * nx * ny + k];
            // what is cut off, and the steps of the cells
            assert!((own - value).abs() < 2e-2, "{c}: {own} {value}");
        }
    }

    #[test]
    fn no_load_is_no_stress() {
        let grid = Grid::new(3, 2, 1e-3, 1e-3).expect("a grid");
        let none = [0.0; 6];
        let below = StressBelow::new(STEEL, grid, [&none, &none, &none]).expect("tractions");
        let found = below.at(&[0.0, 1e-3], &unmonitored).expect("a stress");
        assert_eq!((found.len(), below.convolutions()), (72, 0));
        assert!(found.iter().all(|v| *v == 0.0));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let grid = Grid::new(2, 2, 1e-3, 1e-3).expect("a grid");
        let one = [1.0; 4];
        let bad = [1.0, f64::NAN, 1.0, 1.0];
        let new = |traction| StressBelow::new(STEEL, grid, traction).map(|_| ());
        assert!(matches!(
            new([&one, &one, &one[1..]]),
            Err(Error::Shape { .. })
        ));
        assert!(matches!(
            new([&one, &one, &bad]),
            Err(Error::NotFinite { .. })
        ));
        let below = StressBelow::new(STEEL, grid, [&one, &one, &one]).expect("tractions");
        let at = |depth: f64| below.at(&[depth], &unmonitored).map(|_| ());
        assert!(matches!(at(-1e-9), Err(Error::AboveSurface { .. })));
        assert!(matches!(at(f64::NAN), Err(Error::NotFinite { .. })));
        let cells = [LoadedCell {
            centre: [0.0, 0.0],
            sides: [1.0, 1.0],
            traction: [0.0, 0.0, 1.0],
        }];
        let sum = |point| stress_at(STEEL, &cells, &[point], &unmonitored).map(|_| ());
        assert!(matches!(sum([0.5, 0.2, 0.0]), Err(Error::OnBorder(0))));
        assert!(matches!(
            sum([0.5, 0.2, -0.1]),
            Err(Error::AboveSurface { .. })
        ));
        assert!(sum([0.5, 0.2, 0.1]).is_ok());
        assert!(sum([0.5, 2.0, 0.0]).is_ok());
    }
}
