// SPDX-License-Identifier: MIT OR Apache-2.0
//! Derivatives of frictionless contacts against differences of solves, and against each other.

use mtb_contact::normal::{
    Load, Method, NormalChange, NormalContact, NormalResponse, NormalSolution, Options, Surface,
    adjoint, forward, solve_normal,
};
use mtb_elasticity::Material;
use mtb_elasticity::half_space::{influence, wave_compliance};
use mtb_operator::{Component, Grid, unmonitored};
use proptest::prelude::*;

/// A rough bowl, its load, and which way its cells are continued.
#[derive(Clone, Debug)]
struct Case {
    grid: Grid,
    gap: Vec<f64>,
    load: Load,
    moments: [Option<f64>; 2],
    is_periodic: bool,
    /// Whether loads act on, less and less, along the way that cells come from.
    creeps: bool,
    modulus: f64,
    /// Of a layer, at each cell of which the surface gives way [m/Pa].
    layer: f64,
    hardness: Option<f64>,
}

const MODULUS: f64 = 2e3;

impl Case {
    fn with<T>(&self, work: impl Fn(&NormalContact<'_>) -> T) -> T {
        let material = Material::new(self.modulus, 0.3).expect("a material");
        let rectangle = |offset: [f64; 2], cell: [f64; 2]| {
            let own = if offset == [0.0; 2] { self.layer } else { 0.0 };
            let elastic = |place: [f64; 2]| {
                let normal = Component::Normal;
                influence(&material, normal, normal, place, cell)
            };
            let behind = |k: i32| [0, 1].map(|c| offset[c] + [0.06, -0.03][c] * f64::from(k));
            let crept: f64 = (1..8).map(|k| 0.5_f64.powi(k) * elastic(behind(k))).sum();
            own + elastic(offset) + if self.creeps { crept } else { 0.0 }
        };
        let wave = |k: f64| self.layer + wave_compliance(&material, k);
        work(&NormalContact {
            gap: &self.gap,
            grid: self.grid,
            surface: if self.is_periodic {
                Surface::Periodic(&wave)
            } else if self.creeps {
                Surface::Rolling(&rectangle)
            } else {
                Surface::FreeSpace(&rectangle)
            },
            load: self.load,
            moments: self.moments,
            hardness: self.hardness,
            rough: None,
            start: None,
        })
    }

    fn solved(&self, method: Method) -> NormalSolution {
        // the dense method takes no hardness
        let is_plastic = self.hardness.is_some();
        let method = if is_plastic { Method::Fourier } else { method };
        let tolerance = Some(if method == Method::Dense { 1e-8 } else { 1e-13 });
        let options = Options { tolerance, method };
        self.with(|contact| solve_normal(contact, options, &unmonitored).expect("a solution"))
    }

    fn changed(&self, change: &NormalChange, share: f64) -> Self {
        let mut other = self.clone();
        for (g, d) in other.gap.iter_mut().zip(&change.gap) {
            *g += share * d;
        }
        other.load = match self.load {
            Load::Force(f) => Load::Force(f + share * change.load),
            Load::Approach(a) => Load::Approach(a + share * change.load),
        };
        for (m, d) in other.moments.iter_mut().zip(change.moments) {
            *m = m.map(|m| m + share * d);
        }
        // the layer is part of the surface whose compliance changes, and changes by itself
        let compliance = 1.0 + share * change.compliance;
        other.modulus = self.modulus / compliance;
        other.layer = compliance * self.layer + share * change.flexibility[0];
        other.hardness = self.hardness.map(|h| h + share * change.hardness);
        other
    }
}

fn case() -> impl Strategy<Value = (Case, NormalChange, NormalResponse)> {
    let shape = (10..24_usize, 10..24_usize, 0..7_usize, any::<u64>());
    let effects = (any::<bool>(), any::<bool>());
    (shape, effects).prop_map(|((nx, ny, kind, seed), (is_layered, is_plastic))| {
        let mut state = seed | 1;
        let mut next = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let grid = Grid {
            nx,
            ny,
            dx: 0.09,
            dy: 0.11,
        };
        let (tilt, wave) = (next(), next());
        let gap: Vec<f64> = (0..nx * ny)
            .map(|k| {
                let x = ((k % nx) as f64 + 0.5) / nx as f64 - 0.5;
                let y = ((k / nx) as f64 + 0.5) / ny as f64 - 0.5;
                let bowl = x * x + 1.3 * y * y + 0.05 * tilt * x;
                0.3 * bowl + 0.02 * (9.0 * x + wave).sin() * (7.0 * y).cos() + 0.002 * next()
            })
            .collect();
        let least = gap.iter().copied().fold(f64::INFINITY, f64::min);
        let force = 300.0 + 200.0 * next();
        let (load, moments) = match kind {
            1 | 6 => (Load::Approach(least + 0.05 + 0.02 * next()), [None, None]),
            2 => (Load::Force(force), [Some(0.05 * force * next()), None]),
            3 | 5 => (
                Load::Force(force),
                [Some(0.05 * force * next()), Some(0.05 * force * next())],
            ),
            _ => (Load::Force(force), [None, None]),
        };
        let case = Case {
            grid,
            gap,
            load,
            moments,
            is_periodic: kind == 4,
            creeps: kind >= 5,
            modulus: MODULUS,
            layer: if is_layered {
                1e-5 + 1e-5 * next()
            } else {
                0.0
            },
            hardness: None,
        };
        let hardness = (is_plastic && !case.creeps).then(|| {
            let elastic = case.solved(Method::Fourier);
            (0.8 + 0.2 * next()) * elastic.pressure.iter().fold(0.0_f64, |m, p| m.max(*p))
        });
        let flexibility = 2e-6 * next();
        let case = Case { hardness, ..case };
        let change = NormalChange {
            gap: (0..nx * ny).map(|_| 1e-3 * next()).collect(),
            load: if matches!(load, Load::Approach(_)) {
                1e-3 * next()
            } else {
                20.0 * next()
            },
            moments: [0, 1].map(|k| moments[k].map_or(0.0, |_| next())),
            compliance: 0.1 * next(),
            flexibility: vec![flexibility; nx * ny],
            hardness: 20.0 * next(),
        };
        let weights = NormalResponse {
            pressure: (0..nx * ny).map(|_| next()).collect(),
            gap: (0..nx * ny).map(|_| 1e4 * next()).collect(),
            approach: 1e5 * next(),
            tilts: [1e5 * next(), 1e5 * next()],
        };
        (case, change, weights)
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn work(
    weights: &NormalResponse,
    pressure: &[f64],
    gap: &[f64],
    approach: f64,
    tilts: [f64; 2],
) -> f64 {
    dot(&weights.pressure, pressure)
        + dot(&weights.gap, gap)
        + weights.approach * approach
        + dot(&weights.tilts, &tilts)
}

/// All that is found, one after the other, in units in which it is of like size.
fn listed(pressure: &[f64], gap: &[f64], approach: f64, tilts: [f64; 2]) -> Vec<f64> {
    let lengths = gap.iter().chain([&approach]).chain(&tilts);
    pressure
        .iter()
        .copied()
        .chain(lengths.map(|g| MODULUS * g))
        .collect()
}

/// Central differences with Richardson's extrapolation; `None` where the contact set changes on the way.
fn differences(case: &Case, solution: &NormalSolution, change: &NormalChange) -> Option<Vec<f64>> {
    let set = |s: &NormalSolution, hardness: Option<f64>| -> Vec<(bool, bool)> {
        let flows = |p: f64| hardness.is_some_and(|h| p >= h);
        s.pressure.iter().map(|p| (*p > 0.0, flows(*p))).collect()
    };
    let at = |share: f64| {
        let other = case.changed(change, share);
        let s = other.solved(Method::Dense);
        let is_same = set(&s, other.hardness) == set(solution, case.hardness);
        is_same.then(|| listed(&s.pressure, &s.gap, s.approach, s.tilts))
    };
    let slope = |h: f64| -> Option<Vec<f64>> {
        let (a, b) = (at(h)?, at(-h)?);
        Some(a.iter().zip(b).map(|(a, b)| (a - b) / (2.0 * h)).collect())
    };
    let (coarse, fine) = (slope(4e-3)?, slope(2e-3)?);
    Some(
        coarse
            .iter()
            .zip(fine)
            .map(|(c, f)| (4.0 * f - c) / 3.0)
            .collect(),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn derivatives_are_limits_of_differences_and_adjoints_their_transposes(
        (case, change, weights) in case(),
        is_dense in any::<bool>(),
    ) {
        let solution = case.solved(if is_dense { Method::Dense } else { Method::Fourier });
        let found = case
            .with(|contact| forward(contact, &solution.state(), std::slice::from_ref(&change), &unmonitored))
            .expect("a derivative");
        let gradient = case
            .with(|contact| adjoint(contact, &solution.state(), std::slice::from_ref(&weights), &unmonitored))
            .expect("a gradient");
        let (response, gradient) = (&found.values[0], &gradient.values[0]);
        let (pressure, gap) = (&response.pressure, &response.gap);
        let forward = work(&weights, pressure, gap, response.approach, response.tilts);
        let adjoint = dot(&gradient.gap, &change.gap)
            + gradient.load * change.load
            + dot(&gradient.moments, &change.moments)
            + gradient.compliance * change.compliance
            + dot(&gradient.flexibility, &change.flexibility)
            + gradient.hardness * change.hardness;
        let size = dot(&weights.pressure, &weights.pressure).sqrt() * dot(pressure, pressure).sqrt()
            + (weights.approach * response.approach).abs()
            + dot(&weights.gap, &weights.gap).sqrt() * dot(gap, gap).sqrt();
        prop_assert!((forward - adjoint).abs() < 1e-11 * size, "{forward} {adjoint} {size}");
        if let Some(expected) = differences(&case, &solution, &change) {
            let found = listed(pressure, gap, response.approach, response.tilts);
            let size = dot(&expected, &expected).sqrt();
            let wrong: Vec<f64> = expected.iter().zip(&found).map(|(a, b)| a - b).collect();
            prop_assert!(dot(&wrong, &wrong).sqrt() < 1e-7 * size, "{}", dot(&wrong, &wrong).sqrt() / size);
        }
    }
}

#[test]
fn a_contact_that_does_not_touch_changes_its_gap_only() {
    let grid = Grid {
        nx: 8,
        ny: 9,
        dx: 0.1,
        dy: 0.1,
    };
    let case = Case {
        grid,
        gap: vec![1.0; 72],
        load: Load::Approach(0.4),
        moments: [None, None],
        is_periodic: false,
        creeps: false,
        modulus: MODULUS,
        layer: 0.0,
        hardness: None,
    };
    let change = NormalChange {
        gap: vec![0.5; 72],
        load: 0.2,
        moments: [0.0; 2],
        compliance: 1.0,
        flexibility: vec![1.0; 72],
        hardness: 1.0,
    };
    let solution = case.solved(Method::Fourier);
    let found = case.with(|contact| {
        forward(
            contact,
            &solution.state(),
            std::slice::from_ref(&change),
            &unmonitored,
        )
    });
    let response = &found.expect("a derivative").values[0];
    assert!(response.pressure.iter().all(|p| *p == 0.0));
    assert!(response.gap.iter().all(|g| (g - 0.3).abs() < 1e-15));
}
