// SPDX-License-Identifier: MIT OR Apache-2.0
use std::sync::{Arc, OnceLock};

use mtb_operator::{Compliance, Component, Grid, Kernel, Transform};

use super::{Layered, Viscoelastic, influence};
use crate::{Error, Material};

/// A rectangle of contact cells on the surface of a half-space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// x of the centre of the first cell [m].
    pub x0: f64,
    /// y of the centre of the first cell [m].
    pub y0: f64,
    /// The cells.
    pub grid: Grid,
}

/// Whether a load on one patch of a body moves its other patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neighbours {
    /// One solid under all patches, as a rail under two pole shoes.
    Interact,
    /// Each patch belongs to a solid of its own, as the pole shoes.
    Separate,
}

/// What a half-space is made of.
#[derive(Clone)]
pub enum Medium {
    /// One material.
    Uniform(Material),
    /// A layer on a base.
    Layered(Arc<Layered>),
    /// A material that creeps, under a contact that rolls.
    Viscoelastic(Viscoelastic),
}

impl From<Material> for Medium {
    fn from(material: Material) -> Self {
        Self::Uniform(material)
    }
}

impl Medium {
    /// Material at the surface.
    pub fn material(&self) -> Material {
        match self {
            Self::Uniform(material) => *material,
            Self::Layered(layered) => layered.layer(),
            Self::Viscoelastic(body) => body.material(),
        }
    }

    /// Displacement [m/Pa] at a point by a unit traction on a rectangle, as [`influence`](super::influence).
    pub fn influence(
        &self,
        observed: Component,
        loaded: Component,
        offset: [f64; 2],
        cell: [f64; 2],
    ) -> f64 {
        influence(&self.material(), observed, loaded, offset, cell)
            + self.remainder(observed, loaded, offset, cell)
    }

    /// What is added to the influence of the half-space of the material at the surface.
    pub(super) fn remainder(
        &self,
        observed: Component,
        loaded: Component,
        offset: [f64; 2],
        cell: [f64; 2],
    ) -> f64 {
        match self {
            Self::Uniform(_) => 0.0,
            Self::Layered(body) => body.remainder(observed, loaded, offset, cell),
            Self::Viscoelastic(body) => body.remainder(observed, loaded, offset, cell),
        }
    }

    /// Whether a traction along `loaded` moves the surface along `observed` at all.
    fn is_coupled(&self, observed: Component, loaded: Component) -> bool {
        match self {
            Self::Uniform(material) => is_coupled(material, observed, loaded),
            Self::Layered(_) => true,
            Self::Viscoelastic(body) => is_coupled(&body.material(), observed, loaded),
        }
    }

    /// Whether a load does the same at opposite offsets, but for the sign, and what it does goes both ways.
    pub(super) fn is_mirrored(&self) -> bool {
        !matches!(self, Self::Viscoelastic(_))
    }
}

/// A half-space, uniform, layered or creeping, under piecewise constant tractions on rectangular cells.
///
/// Displacements are taken at the cell centres. Products go by the Fourier transform, one kernel per
/// pair of components and of patches, made when first needed; [`Compliance::add_influence`] gives
/// the same coefficients as a dense matrix. Points of several patches follow one another. Safe to
/// share between threads.
pub struct HalfSpace {
    medium: Medium,
    patches: Vec<Patch>,
    starts: Vec<usize>,
    /// From source patch `s` to target patch `t` at `t * patches + s`; `None` where they do not interact.
    transforms: Vec<Option<Arc<Transform>>>,
    kernels: [[OnceLock<Vec<Option<Kernel>>>; 3]; 3],
}

impl HalfSpace {
    /// A half-space with one grid of cells.
    ///
    /// # Errors
    /// [`Error::Material`], [`Error::Operator`].
    pub fn new(medium: impl Into<Medium>, grid: Grid) -> Result<Self, Error> {
        let patch = Patch {
            x0: 0.0,
            y0: 0.0,
            grid,
        };
        Self::with_patches(medium, vec![patch], Neighbours::Interact)
    }

    /// A half-space with several patches of cells, at any distance from one another, in one plane.
    ///
    /// Where cells of two patches differ in size, what one patch does to the other is taken as if both had
    /// cells of their mean size about the same middles, so that it stays a convolution; the loads are those
    /// of the true cells. What cells at the edges do is then taken up to a quarter of the difference of the
    /// patches' widths beside its place.
    ///
    /// # Errors
    /// [`Error::Material`], [`Error::Operator`], [`Error::NoPatch`], and [`Error::PatchSpacing`] where
    /// the spacings differ by more than a third.
    pub fn with_patches(
        medium: impl Into<Medium>,
        patches: Vec<Patch>,
        neighbours: Neighbours,
    ) -> Result<Self, Error> {
        let medium = medium.into();
        let material = medium.material();
        Material::new(material.shear_modulus, material.poisson_ratio)?;
        let starts = starts(&patches)?;
        let mut planned: Vec<Arc<Transform>> = Vec::new();
        let mut transforms = Vec::new();
        for t in 0..patches.len() {
            for s in 0..patches.len() {
                if s != t && neighbours == Neighbours::Separate {
                    transforms.push(None);
                    continue;
                }
                let shape = |p: usize| [patches[p].grid.nx, patches[p].grid.ny];
                let (source, target) = (shape(s), shape(t));
                let known = planned
                    .iter()
                    .find(|p| p.source() == source && p.target() == target)
                    .cloned();
                let transform = known.unwrap_or_else(|| {
                    let transform = Arc::new(Transform::new(source, target));
                    planned.push(Arc::clone(&transform));
                    transform
                });
                transforms.push(Some(transform));
            }
        }
        Ok(Self {
            medium,
            patches,
            starts,
            transforms,
            kernels: Default::default(),
        })
    }

    /// What it is made of.
    pub fn medium(&self) -> &Medium {
        &self.medium
    }

    /// The patches, in the order of the points.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    fn kernel(
        &self,
        observed: Component,
        loaded: Component,
        target: usize,
        source: usize,
    ) -> Option<Kernel> {
        let n = self.patches.len();
        let transform = self.transforms[target * n + source].as_ref()?;
        let place = Placement::new(&self.patches[target], &self.patches[source]);
        let at = |i: f64, j: f64| {
            let offset = place.offset(i, j);
            place.load * self.medium.influence(observed, loaded, offset, place.cell)
        };
        let kernel = if observed == loaded && target == source && self.medium.is_mirrored() {
            transform.even_kernel(|i, j| at(i as f64, j as f64))
        } else {
            transform.kernel(|i, j| at(i as f64, j as f64))
        };
        Some(kernel)
    }

    fn kernels(&self, observed: Component, loaded: Component) -> &[Option<Kernel>] {
        let n = self.patches.len();
        self.kernels[index(observed)][index(loaded)].get_or_init(|| {
            (0..n * n)
                .map(|k| self.kernel(observed, loaded, k / n, k % n))
                .collect()
        })
    }
}

/// Where the cells of one patch lie from those of another.
pub(super) struct Placement {
    /// From the first cell of the source to the first one of the target [m].
    pub(super) shift: [f64; 2],
    /// Mean size of their cells [m].
    pub(super) cell: [f64; 2],
    /// Area of a cell of the source over that of a mean cell.
    pub(super) load: f64,
}

impl Placement {
    pub(super) fn new(target: &Patch, source: &Patch) -> Self {
        let (t, s) = (&target.grid, &source.grid);
        let cell = [0.5 * (t.dx + s.dx), 0.5 * (t.dy + s.dy)];
        // the middles stay where they are
        let first = |p: &Patch| {
            let half = |n: usize| 0.5 * (n as f64 - 1.0);
            [
                p.x0 + half(p.grid.nx) * (p.grid.dx - cell[0]),
                p.y0 + half(p.grid.ny) * (p.grid.dy - cell[1]),
            ]
        };
        let (t0, s0) = (first(target), first(source));
        Self {
            shift: [t0[0] - s0[0], t0[1] - s0[1]],
            cell,
            load: s.dx * s.dy / (cell[0] * cell[1]),
        }
    }

    /// From a cell of the source to one of the target that is `i`, `j` cells further on in its grid [m].
    fn offset(&self, i: f64, j: f64) -> [f64; 2] {
        [
            self.shift[0] + i * self.cell[0],
            self.shift[1] + j * self.cell[1],
        ]
    }
}

/// Relative difference of the cells of two patches up to which they may lie on one body.
const UNLIKE: f64 = 1.0 / 3.0;

/// First point of each patch and the number of all points, of patches with about the same spacing.
pub(super) fn starts(patches: &[Patch]) -> Result<Vec<usize>, Error> {
    let Some(first) = patches.first().map(|p| p.grid) else {
        return Err(Error::NoPatch);
    };
    let mut starts = vec![0];
    for (patch, Patch { grid, .. }) in patches.iter().enumerate() {
        let Grid { nx, ny, dx, dy } = *grid;
        Grid::new(nx, ny, dx, dy)?;
        let differs = |a: f64, b: f64| (a - b).abs() > UNLIKE * b;
        if differs(dx, first.dx) || differs(dy, first.dy) {
            let (first_dx, first_dy) = (first.dx, first.dy);
            return Err(Error::PatchSpacing {
                patch,
                dx,
                dy,
                first_dx,
                first_dy,
            });
        }
        starts.push(starts[patch] + grid.points());
    }
    Ok(starts)
}

/// Whether a traction along `loaded` moves the surface along `observed` at all.
pub(super) fn is_coupled(material: &Material, observed: Component, loaded: Component) -> bool {
    let is_mixed = (observed == Component::Normal) != (loaded == Component::Normal);
    let nu = material.poisson_ratio;
    if is_mixed {
        nu < 0.5
    } else {
        observed == loaded || nu.abs() > 0.0
    }
}

/// Displacement [m/Pa] of the surface by a normal traction wave of unit amplitude:
/// `(1 - nu) / (G k)`, with the wave number `k` [1/m]; zero for the mean, which a half-space cannot carry.
///
/// [Johnson1985, ch. 13.2]
pub fn wave_compliance(material: &Material, wave_number: f64) -> f64 {
    if wave_number == 0.0 {
        0.0
    } else {
        (1.0 - material.poisson_ratio) / (material.shear_modulus * wave_number)
    }
}

pub(super) fn index(component: Component) -> usize {
    match component {
        Component::X => 0,
        Component::Y => 1,
        Component::Normal => 2,
    }
}

impl Compliance for HalfSpace {
    fn points(&self) -> usize {
        self.starts[self.patches.len()]
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        if !self.medium.is_coupled(observed, loaded) {
            return;
        }
        let n = self.patches.len();
        let kernels = self.kernels(observed, loaded);
        for target in 0..n {
            let u = &mut displacement[self.starts[target]..self.starts[target + 1]];
            for source in 0..n {
                let p = &traction[self.starts[source]..self.starts[source + 1]];
                let k = target * n + source;
                if let (Some(transform), Some(kernel)) = (&self.transforms[k], &kernels[k]) {
                    transform.apply_add(kernel, scale, p, u);
                }
            }
        }
    }

    fn reciprocity(&self) -> Option<Vec<f64>> {
        if !self.medium.is_mirrored() {
            return None;
        }
        let grids = self.patches.iter().map(|patch| patch.grid);
        let areas = grids.flat_map(|g| std::iter::repeat_n(g.cell_area(), g.points()));
        Some(areas.collect())
    }

    fn add_influence(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        matrix: &mut [f64],
    ) {
        if !self.medium.is_coupled(observed, loaded) {
            return;
        }
        let (n, points) = (self.patches.len(), self.points());
        for target in 0..n {
            for source in 0..n {
                if self.transforms[target * n + source].is_none() {
                    continue;
                }
                let place = Placement::new(&self.patches[target], &self.patches[source]);
                let (t, s) = (&self.patches[target].grid, &self.patches[source].grid);
                // every offset once
                let width = t.nx + s.nx - 1;
                let table: Vec<f64> = (0..width * (t.ny + s.ny - 1))
                    .map(|k| {
                        let i = (k % width) as f64 - (s.nx - 1) as f64;
                        let j = (k / width) as f64 - (s.ny - 1) as f64;
                        let offset = place.offset(i, j);
                        let value = self.medium.influence(observed, loaded, offset, place.cell);
                        scale * place.load * value
                    })
                    .collect();
                for row in 0..t.points() {
                    let from = (self.starts[target] + row) * points + self.starts[source];
                    for (column, value) in matrix[from..from + s.points()].iter_mut().enumerate() {
                        let i = row % t.nx + s.nx - 1 - column % s.nx;
                        let j = row / t.nx + s.ny - 1 - column / s.nx;
                        *value += table[j * width + i];
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Component::{Normal, X, Y};

    const STEEL: Material = Material {
        shear_modulus: 80e9,
        poisson_ratio: 0.28,
    };

    fn field(n: usize) -> Vec<f64> {
        (0..n).map(|k| ((7 * k + 3) % 11) as f64 - 4.0).collect()
    }

    fn assert_fft_equals_dense(body: &HalfSpace) {
        let n = body.points();
        let p = field(n);
        for observed in [X, Y, Normal] {
            for loaded in [X, Y, Normal] {
                let mut matrix = vec![0.0; n * n];
                body.add_influence(observed, loaded, 1.0, &mut matrix);
                let dense: Vec<f64> = (0..n)
                    .map(|i| (0..n).map(|j| matrix[i * n + j] * p[j]).sum())
                    .collect();
                let mut fast = vec![0.0; n];
                body.add_displacement(observed, loaded, 1.0, &p, &mut fast);
                let scale = dense.iter().fold(1e-300, |m: f64, v| m.max(v.abs()));
                for (a, b) in fast.iter().zip(&dense) {
                    assert!(
                        (a - b).abs() < 2e-14 * scale,
                        "{observed:?} {loaded:?}: {a} {b}"
                    );
                }
                let mut sums = vec![0.0; n];
                body.add_transposed(observed, loaded, 1.0, &p, &mut sums);
                for (j, sum) in sums.iter().enumerate() {
                    let expected: f64 = (0..n).map(|i| matrix[i * n + j] * p[i]).sum();
                    assert!(
                        (sum - expected).abs() < 4e-14 * scale,
                        "{observed:?} {loaded:?} transposed: {sum} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn fft_equals_dense_on_a_grid() -> Result<(), Error> {
        assert_fft_equals_dense(&HalfSpace::new(STEEL, Grid::new(9, 6, 1e-3, 2.5e-3)?)?);
        assert_fft_equals_dense(&HalfSpace::new(STEEL, Grid::new(1, 1, 1e-3, 1e-3)?)?);
        Ok(())
    }

    #[test]
    fn fft_equals_dense_on_patches() -> Result<(), Error> {
        let patches = vec![
            Patch {
                x0: 0.0,
                y0: 0.0,
                grid: Grid::new(5, 4, 1e-3, 2e-3)?,
            },
            Patch {
                x0: 1.3e-3,
                y0: 17.7e-3,
                grid: Grid::new(3, 6, 1e-3, 2e-3)?,
            },
        ];
        for neighbours in [Neighbours::Interact, Neighbours::Separate] {
            let body = HalfSpace::with_patches(STEEL, patches.clone(), neighbours)?;
            assert_fft_equals_dense(&body);
            let mut matrix = vec![0.0; 38 * 38];
            body.add_influence(Normal, Normal, 1.0, &mut matrix);
            let is_coupled = matrix[37] != 0.0;
            assert_eq!(is_coupled, neighbours == Neighbours::Interact);
        }
        Ok(())
    }

    #[test]
    fn a_patch_of_patches_is_the_whole_grid() -> Result<(), Error> {
        let whole = HalfSpace::new(STEEL, Grid::new(4, 6, 1e-3, 1e-3)?)?;
        let halves = HalfSpace::with_patches(
            STEEL,
            vec![
                Patch {
                    x0: 0.0,
                    y0: 0.0,
                    grid: Grid::new(4, 3, 1e-3, 1e-3)?,
                },
                Patch {
                    x0: 0.0,
                    y0: 3e-3,
                    grid: Grid::new(4, 3, 1e-3, 1e-3)?,
                },
            ],
            Neighbours::Interact,
        )?;
        let p = field(24);
        let (mut a, mut b) = (vec![0.0; 24], vec![0.0; 24]);
        whole.add_displacement(Normal, X, 1.0, &p, &mut a);
        halves.add_displacement(Normal, X, 1.0, &p, &mut b);
        let scale = a.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-13 * scale);
        }
        Ok(())
    }

    /// The influence is self-adjoint in the product weighted with the areas, and the load of a coarser patch
    /// arrives whole.
    #[test]
    fn patches_of_unlike_cells_answer_one_another() -> Result<(), Error> {
        let patches = vec![
            Patch {
                x0: 0.0,
                y0: 0.0,
                grid: Grid::new(4, 5, 1e-3, 2e-3)?,
            },
            Patch {
                x0: 0.0,
                y0: 0.1,
                grid: Grid::new(4, 5, 1e-3, 2.4e-3)?,
            },
        ];
        let body = HalfSpace::with_patches(STEEL, patches.clone(), Neighbours::Interact)?;
        assert_fft_equals_dense(&body);
        let mut matrix = vec![0.0; 40 * 40];
        body.add_influence(Normal, Normal, 1.0, &mut matrix);
        for i in 0..40 {
            for j in 0..40 {
                let area = |k: usize| patches[k / 20].grid.cell_area();
                let (a, b) = (matrix[i * 40 + j] * area(i), matrix[j * 40 + i] * area(j));
                assert!((a - b).abs() < 1e-12 * a.abs(), "{i} {j}: {a} {b}");
            }
        }
        // in the mean over the one patch, a uniform pressure on the other is about a point load in its middle
        let seen = (0..400)
            .map(|k| matrix[k / 20 * 40 + 20 + k % 20])
            .sum::<f64>()
            / 20.0;
        let distance = 0.1 + 2.0 * 2.4e-3 - 2.0 * 2e-3;
        let load = 20.0 * patches[1].grid.cell_area();
        let point = (1.0 - STEEL.poisson_ratio) * load
            / (2.0 * std::f64::consts::PI * STEEL.shear_modulus * distance);
        assert!((seen - point).abs() < 2e-3 * point, "{seen} {point}");
        Ok(())
    }

    #[test]
    fn bad_input_is_named() {
        let grid = Grid {
            nx: 2,
            ny: 2,
            dx: 1e-3,
            dy: 1e-3,
        };
        let bad = Material {
            shear_modulus: 80e9,
            poisson_ratio: 0.6,
        };
        assert!(matches!(
            HalfSpace::new(bad, grid),
            Err(Error::Material { .. })
        ));
        assert!(matches!(
            HalfSpace::new(STEEL, Grid { nx: 0, ..grid }),
            Err(Error::Operator(_))
        ));
        let none = HalfSpace::with_patches(STEEL, vec![], Neighbours::Interact);
        assert!(matches!(none, Err(Error::NoPatch)));
        let patches = vec![
            Patch {
                x0: 0.0,
                y0: 0.0,
                grid,
            },
            Patch {
                x0: 1.0,
                y0: 0.0,
                grid: Grid { dx: 2e-3, ..grid },
            },
        ];
        let mixed = HalfSpace::with_patches(STEEL, patches, Neighbours::Interact);
        assert!(matches!(mixed, Err(Error::PatchSpacing { patch: 1, .. })));
    }
}
