// SPDX-License-Identifier: MIT OR Apache-2.0
use super::*;
use mtb_operator::Grid;

const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.3,
};

fn patch(nx: usize, ny: usize, y0: f64) -> Patch {
    Patch {
        x0: 1e-3,
        y0,
        grid: Grid::new(nx, ny, 12e-3 / (nx - 1) as f64, 6e-3 / (ny - 1) as f64).expect("valid"),
    }
}

fn lines(kept: [&[usize]; 2], patch: &Patch) -> [Lines; 2] {
    let one = |kept: &[usize], nodes| Lines::new(kept.to_vec(), nodes).expect("rising");
    [one(kept[0], patch.grid.nx), one(kept[1], patch.grid.ny)]
}

/// A half-space on all nodes of a patch with a tilt and a shift of all of them more.
struct Bending {
    near: HatHalfSpace,
    shapes: [Vec<f64>; 2],
}

const STIFFNESS: f64 = 1e9;

impl Bending {
    fn new(patch: Patch) -> Self {
        let Grid { nx, ny, dx, .. } = patch.grid;
        // means over hats that are cut at the edges
        let x = |i: usize| match i {
            0 => dx / 3.0,
            i if i == nx - 1 => (nx as f64 - 4.0 / 3.0) * dx,
            i => i as f64 * dx,
        };
        Self {
            near: HatHalfSpace::new(STEEL, vec![patch], Neighbours::Interact).expect("valid"),
            shapes: [
                (0..nx * ny).map(|k| 1e2 * x(k % nx)).collect(),
                vec![1.0; nx * ny],
            ],
        }
    }
}

impl Compliance for Bending {
    fn points(&self) -> usize {
        self.near.points()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        self.near
            .add_displacement(observed, loaded, scale, traction, displacement);
        if (observed, loaded) != (Component::Normal, Component::X) && observed != loaded {
            return;
        }
        for shape in &self.shapes {
            let parts = self.near.weights().into_iter().zip(shape).zip(traction);
            let work: f64 = parts.map(|((w, s), t)| w * s * t).sum();
            for (u, s) in displacement.iter_mut().zip(shape) {
                *u += scale * work * s / STIFFNESS;
            }
        }
    }
}

/// A body under the hats between some lines, by its displacements on all of them.
struct OnLines<B> {
    body: B,
    weights: Vec<f64>,
    hats: Vec<Vec<(usize, f64)>>,
}

impl<B> OnLines<B> {
    fn new(body: B, weights: Vec<f64>, [x, y]: &[Lines; 2]) -> Self {
        let (x_hats, y_hats) = (x.hats(), y.hats());
        let mut hats = Vec::new();
        for row in &y_hats {
            for column in &x_hats {
                let parts = row
                    .iter()
                    .flat_map(|(j, b)| column.iter().map(move |(i, a)| (j * x.nodes() + i, a * b)));
                hats.push(parts.collect());
            }
        }
        Self {
            body,
            weights,
            hats,
        }
    }

    /// Integrals over the hats.
    fn sums(&self, values: &[f64]) -> Vec<f64> {
        let one = |hat: &Vec<(usize, f64)>| {
            hat.iter()
                .map(|(i, a)| a * self.weights[*i] * values[*i])
                .sum()
        };
        self.hats.iter().map(one).collect()
    }

    fn own_weights(&self) -> Vec<f64> {
        self.sums(&vec![1.0; self.weights.len()])
    }
}

impl<B: Compliance> Compliance for OnLines<B> {
    fn points(&self) -> usize {
        self.hats.len()
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let mut fine = vec![0.0; self.weights.len()];
        for (hat, t) in self.hats.iter().zip(traction) {
            for (i, a) in hat {
                fine[*i] += a * t;
            }
        }
        let mut moved = vec![0.0; fine.len()];
        self.body
            .add_displacement(observed, loaded, scale, &fine, &mut moved);
        let parts = self.sums(&moved).into_iter().zip(self.own_weights());
        for (u, (sum, w)) in displacement.iter_mut().zip(parts) {
            *u += sum / w;
        }
    }
}

/// What is linear between the lines is carried exactly, so the sum is the body on all nodes.
#[test]
fn a_body_that_differs_by_linear_fields_is_exact() {
    let patch = patch(15, 9, 2e-3);
    let kept = lines([&[0, 1, 3, 6, 8, 11, 13, 14], &[0, 2, 3, 8]], &patch);
    let direct = Bending::new(patch);
    let coarse = OnLines::new(Bending::new(patch), direct.near.weights(), &kept);
    let weights = coarse.own_weights();
    let body: Arc<dyn Compliance> = Arc::new(coarse);
    let refined =
        Refined::new(&body, &weights, &[], STEEL, &[kept], vec![patch], false).expect("positive");
    let n = direct.points();
    for (a, b) in refined.weights().iter().zip(direct.near.weights()) {
        assert!((a - b).abs() < 1e-12 * b);
    }
    let traction: Vec<f64> = (0..n).map(|i| ((i * 7) % 11) as f64 - 3.0).collect();
    for pair in [
        (Component::Normal, Component::Normal),
        (Component::Y, Component::Y),
        (Component::Y, Component::X),
    ] {
        let (mut found, mut expected) = (vec![0.0; n], vec![0.0; n]);
        refined.add_displacement(pair.0, pair.1, 1.0, &traction, &mut found);
        direct.add_displacement(pair.0, pair.1, 1.0, &traction, &mut expected);
        let scale = expected.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        let mut matrix = vec![0.0; n * n];
        refined.add_influence(pair.0, pair.1, 1.0, &mut matrix);
        for i in 0..n {
            assert!((found[i] - expected[i]).abs() < 1e-10 * scale);
            let row = &matrix[i * n..(i + 1) * n];
            let sum: f64 = row.iter().zip(&traction).map(|(a, t)| a * t).sum();
            assert!((found[i] - sum).abs() < 1e-10 * scale);
        }
    }
}

/// With a body that is as stiff as is allowed, and lines as the ready scenes take them, the energy of the sum is
/// positive.
#[test]
fn the_sum_is_positive_definite_for_the_stiffest_body() {
    let patch = patch(41, 25, 0.0);
    let kept = lines(
        [
            &[
                0, 1, 2, 3, 4, 6, 9, 13, 18, 22, 27, 31, 34, 36, 37, 38, 39, 40,
            ],
            &[0, 1, 2, 3, 4, 6, 9, 12, 15, 18, 20, 21, 22, 23, 24],
        ],
        &patch,
    );
    let stiff = Material {
        shear_modulus: STEEL.shear_modulus / (1.02 * LOST),
        ..STEEL
    };
    let on =
        |material| HatHalfSpace::new(material, vec![patch], Neighbours::Interact).expect("valid");
    let coarse = OnLines::new(on(stiff), on(STEEL).weights(), &kept);
    let weights = coarse.own_weights();
    let body: Arc<dyn Compliance> = Arc::new(coarse);
    let refined = Refined::new(&body, &weights, &[], STEEL, &[kept], vec![patch], false)
        .expect("stiff enough");
    let n = refined.points();
    for component in [Component::Normal, Component::X] {
        let mut matrix = vec![0.0; n * n];
        refined.add_influence(component, component, 1.0, &mut matrix);
        let w = refined.weights();
        let energy = Mat::from_fn(n, n, |i, j| {
            0.5 * (w[i] * matrix[i * n + j] + w[j] * matrix[j * n + i])
        });
        assert!(energy.llt(Side::Lower).is_ok(), "{component:?}");
    }
}

/// The half of a symmetric body is the whole under loads that are their own mirror images, to rounding, also where
/// both are softened.
#[test]
fn the_half_is_the_whole_under_symmetric_loads() {
    let own = patch(15, 9, 4e-3);
    let [x, y] = lines([&[0, 1, 3, 6, 8, 11, 13, 14], &[0, 2, 3, 8]], &own);
    let half_lines = [[x.clone(), y.clone()]];
    let whole_lines = [[x.clone(), y.clone()], [x, y.reversed()]];
    let patches = [own, mirrored(&own)];
    let image = images([[15, 9]].into_iter());
    let coarse_image = images([[8, 4]].into_iter());
    // stiffer than the half-space beside it, and deep under both patches another one
    let other = Material {
        shear_modulus: 2.0 * STEEL.shear_modulus,
        poisson_ratio: 0.2,
    };
    let on_all = HatHalfSpace::new(other, patches.to_vec(), Neighbours::Interact).expect("valid");
    let weights = on_all.weights();
    let mut hats = OnLines::new(on_all, weights.clone(), &whole_lines[0]);
    let twin = OnLines::new((), weights.clone(), &whole_lines[1]);
    hats.hats.extend(
        twin.hats
            .into_iter()
            .map(|hat| hat.into_iter().map(|(i, a)| (i + 15 * 9, a)).collect()),
    );
    let coarse_weights = hats.own_weights();
    let body: Arc<dyn Compliance> = Arc::new(hats);
    let half: Arc<dyn Compliance> =
        Arc::new(SymmetricHalf::new(Arc::clone(&body), &coarse_image).expect("pairs"));
    let whole = Refined::new(
        &body,
        &coarse_weights,
        &[],
        STEEL,
        &whole_lines,
        patches.to_vec(),
        false,
    )
    .expect("stiff enough");
    let n = 15 * 9;
    let half = Refined::new(
        &half,
        &coarse_weights[..32],
        &[],
        STEEL,
        &half_lines,
        vec![own],
        true,
    )
    .expect("stiff enough");
    for (observed, loaded) in PAIRS {
        let one: Vec<f64> = (0..n).map(|i| ((i * 7) % 11) as f64 - 3.0).collect();
        let sign = SymmetricHalf::sign(loaded);
        let mut both = one.clone();
        both.extend((n..2 * n).map(|i| sign * one[image[i]]));
        let (mut found, mut expected) = (vec![0.0; n], vec![0.0; 2 * n]);
        half.add_displacement(observed, loaded, 1.0, &one, &mut found);
        whole.add_displacement(observed, loaded, 1.0, &both, &mut expected);
        let scale = expected.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        for (a, b) in found.iter().zip(&expected) {
            assert!(
                (a - b).abs() < 1e-9 * scale,
                "{observed:?} {loaded:?}: {a} {b}"
            );
        }
    }
}

#[test]
fn what_is_carried_keeps_its_resultants() {
    let patches = [patch(12, 8, 0.0), patch(12, 8, 9e-3)];
    let kept = [
        lines([&[0, 1, 4, 11], &[0, 3, 7]], &patches[0]),
        lines([&[0, 5, 11], &[0, 2, 5, 7]], &patches[1]),
    ];
    let carrier = Carrier::new(&kept);
    let w = HatHalfSpace::new(STEEL, patches.to_vec(), Neighbours::Interact)
        .expect("valid")
        .weights();
    let wide = carrier.sum(&w, &kept);
    let traction: Vec<f64> = (0..w.len()).map(|i| ((i * 5) % 9) as f64 - 2.0).collect();
    let next = carrier.restrict(&traction);
    let total = |w: &[f64], t: &[f64]| -> f64 { w.iter().zip(t).map(|(w, t)| w * t).sum() };
    assert!((total(&w, &traction) - total(&wide, &next)).abs() < 1e-12 * total(&w, &traction));
    // the two maps are transposed to each other
    let field: Vec<f64> = (0..wide.len()).map(|i| ((i * 3) % 7) as f64).collect();
    let (a, b) = (
        total(&carrier.carry(&field), &traction),
        total(&field, &next),
    );
    assert!((a - b).abs() < 1e-12 * a.abs());
}

#[test]
fn other_lines_and_bodies_that_are_too_stiff_are_refused() {
    for kept in [&[0][..], &[0, 2, 1, 4], &[1, 4], &[0, 3]] {
        assert!(matches!(Lines::new(kept.to_vec(), 5), Err(Error::Lines(5))));
    }
    let patch = patch(15, 9, 2e-3);
    let kept = lines([&[0, 4, 9, 14], &[0, 4, 8]], &patch);
    let stiff = Material {
        shear_modulus: 8.0 * STEEL.shear_modulus,
        ..STEEL
    };
    let body = HatHalfSpace::new(stiff, vec![patch], Neighbours::Interact).expect("valid");
    let body = OnLines::new(body, Bending::new(patch).near.weights(), &kept);
    let weights = body.own_weights();
    let body: Arc<dyn Compliance> = Arc::new(body);
    let new = |weights: &[f64], patch| {
        let kept = [kept.clone()];
        Refined::new(&body, weights, &[], STEEL, &kept, vec![patch], false)
    };
    assert!(matches!(new(&weights, patch), Err(Error::Stiff)));
    let half: Vec<f64> = weights.iter().map(|w| 0.5 * w).collect();
    assert!(matches!(new(&half, patch), Err(Error::NoArea(0))));
    let other = super::tests::patch(14, 9, 2e-3);
    assert!(matches!(new(&weights, other), Err(Error::Shape { .. })));
}

/// Between the lines a smooth field is known to fourth order in their distance, where it is straight at its ends.
#[test]
fn smooth_fields_are_carried_to_fourth_order() {
    let nodes = 97;
    // integrals of sin(3 pi x / 96) over the hats of all nodes
    let wave = 3.0 * std::f64::consts::PI / 96.0;
    let inner = 2.0 * (1.0 - wave.cos()) / wave.powi(2);
    let end = (wave - wave.sin()) / wave.powi(2);
    let field: Vec<f64> = (0..nodes)
        .map(|k| match k {
            0 | 96 => end,
            k => inner * (wave * k as f64).sin(),
        })
        .collect();
    let errors: Vec<f64> = [12, 6, 3]
        .into_iter()
        .map(|step| {
            let lines = Lines::new((0..nodes).step_by(step).collect(), nodes).expect("rising");
            let fine = nalgebra::DVector::from_column_slice(&field);
            let mut sums = nalgebra::DVector::zeros(lines.len());
            for k in 0..nodes {
                for (hat, value) in lines.at(k) {
                    sums[hat] += value * fine[k];
                }
            }
            let carried = lines.shares() * sums;
            (0..nodes)
                .map(|k| (carried[k] - field[k]).abs())
                .fold(0.0, f64::max)
        })
        .collect();
    assert!(errors[0] < 5e-3, "{errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < pair[0] / 12.0, "{errors:?}");
    }
}

/// A body that stands still in the mean, as one that is free does under loads that its inertia balances, is as stiff as
/// can be against a uniform traction; that is no matter where its loads balance.
#[test]
fn free_motions_do_not_make_a_body_stiff() {
    struct Still<B>(B, Vec<f64>);
    impl<B: Compliance> Compliance for Still<B> {
        fn points(&self) -> usize {
            self.0.points()
        }

        fn add_displacement(
            &self,
            observed: Component,
            loaded: Component,
            scale: f64,
            traction: &[f64],
            displacement: &mut [f64],
        ) {
            let total: f64 = self.1.iter().sum();
            let mean = |u: &[f64]| u.iter().zip(&self.1).map(|(u, w)| u * w).sum::<f64>() / total;
            let balanced: Vec<f64> = traction.iter().map(|t| t - mean(traction)).collect();
            let mut moved = vec![0.0; balanced.len()];
            self.0
                .add_displacement(observed, loaded, 1.0, &balanced, &mut moved);
            let middle = mean(&moved);
            for (u, v) in displacement.iter_mut().zip(moved) {
                *u += scale * (v - middle);
            }
        }
    }
    let patch = patch(15, 9, 2e-3);
    let kept = lines([&[0, 1, 3, 6, 8, 11, 13, 14], &[0, 2, 3, 8]], &patch);
    let on = || HatHalfSpace::new(STEEL, vec![patch], Neighbours::Interact).expect("valid");
    let coarse = OnLines::new(on(), on().weights(), &kept);
    let weights = coarse.own_weights();
    let n = weights.len();
    let body: Arc<dyn Compliance> = Arc::new(Still(coarse, weights.clone()));
    let shifts: Vec<[Vec<f64>; 3]> = (0..3)
        .map(|way| std::array::from_fn(|c| vec![f64::from(c == way); n]))
        .collect();
    let new = |motions: &[[Vec<f64>; 3]]| {
        let kept = [kept.clone()];
        Refined::new(&body, &weights, motions, STEEL, &kept, vec![patch], false)
    };
    assert!(matches!(new(&[]), Err(Error::Stiff)));
    let refined = new(&shifts).expect("free");
    // and it is the half-space under loads that balance, but for its mean
    let fine = refined.weights().to_vec();
    let total: f64 = fine.iter().sum();
    let mean = |u: &[f64]| u.iter().zip(&fine).map(|(u, w)| u * w).sum::<f64>() / total;
    let mut traction: Vec<f64> = (0..fine.len()).map(|i| ((i * 7) % 11) as f64).collect();
    let level = mean(&traction);
    for t in &mut traction {
        *t -= level;
    }
    let (mut found, mut expected) = (vec![0.0; fine.len()], vec![0.0; fine.len()]);
    let normal = Component::Normal;
    refined.add_displacement(normal, normal, 1.0, &traction, &mut found);
    on().add_displacement(normal, normal, 1.0, &traction, &mut expected);
    let (a, b) = (mean(&found), mean(&expected));
    let size = expected.iter().fold(0.0_f64, |m, u| m.max((u - b).abs()));
    for (u, v) in found.iter().zip(&expected) {
        assert!((u - a - (v - b)).abs() < 1e-2 * size, "{u} {v}");
    }
}
