// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arranged bodies give the same numbers point by point and as matrices, and mirrors do what mirrors do.

use std::sync::Arc;

use mtb_operator::{
    Compliance, Component, Error, Map, Mirrored, Reflected, Relative, Separate, Sum, SymmetricHalf,
    SymmetricWhole,
};

/// A compliance with arbitrary blocks, different for each pair of components.
struct Arbitrary(usize);

fn entry(observed: Component, loaded: Component, i: usize, j: usize) -> f64 {
    let number = |c| match c {
        Component::X => 1.0,
        Component::Y => 2.0,
        Component::Normal => 3.0,
    };
    (number(observed) * 1.7 + number(loaded) * 0.3 + i as f64 * 0.9 + j as f64 * j as f64).sin()
}

impl Compliance for Arbitrary {
    fn points(&self) -> usize {
        self.0
    }

    fn add_displacement(&self, o: Component, l: Component, scale: f64, t: &[f64], u: &mut [f64]) {
        for i in 0..self.0 {
            for j in 0..self.0 {
                u[i] += scale * entry(o, l, i, j) * t[j];
            }
        }
    }
}

const AXES: [Component; 3] = [Component::X, Component::Y, Component::Normal];

/// `add_influence` must be the matrix of `add_displacement`, and `add_transposed` multiply with its columns.
fn consistent(body: &dyn Compliance) {
    let n = body.points();
    for o in AXES {
        for l in AXES {
            let mut matrix = vec![0.0; n * n];
            body.add_influence(o, l, 0.7, &mut matrix);
            for j in 0..n {
                let mut unit = vec![0.0; n];
                unit[j] = 1.0;
                let mut u = vec![0.0; n];
                body.add_displacement(o, l, 0.7, &unit, &mut u);
                for i in 0..n {
                    assert!((u[i] - matrix[i * n + j]).abs() < 1e-14);
                }
            }
            let weights: Vec<f64> = (0..n).map(|i| (1.3 * i as f64 + 0.4).sin()).collect();
            let mut sums = vec![0.5; n];
            body.add_transposed(o, l, 0.7, &weights, &mut sums);
            for (j, sum) in sums.iter().enumerate() {
                let expected: f64 = (0..n).map(|i| weights[i] * matrix[i * n + j]).sum();
                assert!((sum - 0.5 - expected).abs() < 1e-13);
            }
        }
    }
}

#[test]
fn matrices_and_maps_agree() {
    let (a, b): (Arc<dyn Compliance>, Arc<dyn Compliance>) =
        (Arc::new(Arbitrary(3)), Arc::new(Arbitrary(4)));
    consistent(&Separate(vec![a.clone(), b.clone()]));
    consistent(&Reflected::new(a.clone(), vec![2, 0, 1]).unwrap());
    consistent(&SymmetricHalf::new(b.clone(), &[1, 0, 3, 2]).unwrap());
    consistent(&SymmetricHalf::new(a.clone(), &[2, 1, 0]).unwrap());
    consistent(&SymmetricHalf::turned(b.clone(), &[1, 0, 3, 2]).unwrap());
    consistent(&SymmetricHalf::turned(a.clone(), &[2, 1, 0]).unwrap());
    consistent(&SymmetricWhole::new(a.clone(), &[1, 0, 3, 2, 4]).unwrap());
    consistent(&Mirrored(&*a));
    let mirrored = Mirrored(&*a);
    consistent(&Sum(vec![&*a, &mirrored]));
    for (lower, upper) in [
        (Some(a.clone()), Some(a.clone())),
        (Some(a.clone()), None),
        (None, Some(a)),
    ] {
        let bare = Relative::new(lower, upper).unwrap();
        consistent(&bare);
        let layered = bare.clone().with_layer(vec![0.3, 0.0, 2.0]).unwrap();
        consistent(&layered);
        let mut u = vec![0.0; 3];
        layered.add_displacement(AXES[2], AXES[2], 2.0, &[1.0, -0.5, 0.25], &mut u);
        bare.add_displacement(AXES[2], AXES[2], -2.0, &[1.0, -0.5, 0.25], &mut u);
        for (found, own) in u.iter().zip([0.6, 0.0, 1.0]) {
            assert!((found - own).abs() < 1e-14);
        }
        for wrong in [vec![1.0; 2], vec![1.0, -1.0, 0.0], vec![f64::NAN; 3]] {
            assert!(matches!(
                bare.clone().with_layer(wrong),
                Err(Error::Layer { .. })
            ));
        }
    }
}

#[test]
fn two_bodies_are_the_lower_and_the_mirrored_upper_one() {
    let (a, b): (Arc<dyn Compliance>, Arc<dyn Compliance>) =
        (Arc::new(Arbitrary(3)), Arc::new(Arbitrary(4)));
    let moved = |body: &dyn Compliance, o, l| {
        let mut u = vec![0.0; 3];
        body.add_displacement(o, l, 2.0, &[1.0, -0.5, 0.25], &mut u);
        u
    };
    for (lower, upper, signs) in [
        (Some(a.clone()), Some(a.clone()), [2.0, 0.0]),
        (Some(a.clone()), None, [1.0, 1.0]),
        (None, Some(a.clone()), [1.0, -1.0]),
    ] {
        let both = Relative::new(lower, upper).unwrap();
        assert_eq!(both.points(), 3);
        for o in AXES {
            for l in AXES {
                let mixed = (o == Component::Normal) != (l == Component::Normal);
                let sign = signs[usize::from(mixed)];
                for (found, one) in moved(&both, o, l).iter().zip(moved(&*a, o, l)) {
                    assert!((found - sign * one).abs() < 1e-14);
                }
            }
        }
    }
    let refused = |lower, upper| Relative::new(lower, upper).err();
    assert_eq!(
        refused(Some(a), Some(b)),
        Some(Error::Points { lower: 3, upper: 4 })
    );
    assert_eq!(refused(None, None), Some(Error::Rigid));
}

#[test]
fn the_upper_body_is_mirrored_in_its_mixed_blocks_only() {
    let a = Arbitrary(2);
    let mirrored = Mirrored(&a);
    let twice = Sum(vec![&a, &mirrored]);
    for o in AXES {
        for l in AXES {
            let mixed = (o == Component::Normal) != (l == Component::Normal);
            let mut u = vec![0.0; 2];
            twice.add_displacement(o, l, 1.0, &[1.0, 0.0], &mut u);
            let expected = if mixed { 0.0 } else { 2.0 * entry(o, l, 0, 0) };
            assert!((u[0] - expected).abs() < 1e-14);
        }
    }
}

#[test]
fn a_body_and_its_twin_fold_onto_the_body() {
    let a: Arc<dyn Compliance> = Arc::new(Arbitrary(3));
    let twin = Reflected::new(a.clone(), vec![0, 1, 2]).unwrap();
    let both: Arc<dyn Compliance> = Arc::new(Separate(vec![a.clone(), Arc::new(twin)]));
    let half = SymmetricHalf::new(both, &[3, 4, 5, 0, 1, 2]).unwrap();
    assert_eq!(half.kept(), [0, 1, 2]);
    for o in AXES {
        for l in AXES {
            let (mut u, mut v) = (vec![0.0; 3], vec![0.0; 3]);
            half.add_displacement(o, l, 1.0, &[1.0, -2.0, 0.5], &mut u);
            a.add_displacement(o, l, 1.0, &[1.0, -2.0, 0.5], &mut v);
            assert!(u.iter().zip(&v).all(|(u, v)| (u - v).abs() < 1e-14));
        }
    }
}

#[test]
fn what_is_no_pairing_is_refused() {
    let a: Arc<dyn Compliance> = Arc::new(Arbitrary(3));
    for image in [vec![1, 2, 0], vec![0, 1], vec![0, 1, 7]] {
        assert!(SymmetricHalf::new(a.clone(), &image).is_none());
    }
    for original in [vec![0, 0, 1], vec![0, 1], vec![0, 1, 7]] {
        assert!(Reflected::new(a.clone(), original).is_none());
    }
}

#[test]
fn half_of_a_whole_is_the_half() {
    let half: Arc<dyn Compliance> = Arc::new(Arbitrary(2));
    let image = [2, 3, 0, 1];
    let whole: Arc<dyn Compliance> = Arc::new(SymmetricWhole::new(half.clone(), &image).unwrap());
    let again = SymmetricHalf::new(whole, &image).unwrap();
    for o in AXES {
        for l in AXES {
            let (mut u, mut v) = (vec![0.0; 2], vec![0.0; 2]);
            again.add_displacement(o, l, 1.0, &[0.3, -1.0], &mut u);
            half.add_displacement(o, l, 1.0, &[0.3, -1.0], &mut v);
            assert!(u.iter().zip(&v).all(|(u, v)| (u - v).abs() < 1e-14));
        }
    }
}

/// Points that give way to their own pressures alone, whose inverse is known.
struct Springs(Vec<f64>);

impl Compliance for Springs {
    fn points(&self) -> usize {
        self.0.len()
    }

    fn add_displacement(&self, o: Component, l: Component, scale: f64, t: &[f64], u: &mut [f64]) {
        if o == l {
            for ((u, c), t) in u.iter_mut().zip(&self.0).zip(t) {
                *u += scale * c * t;
            }
        }
    }

    fn near_inverse(&self, softer: f64) -> Option<Map> {
        let all: Vec<f64> = self.0.iter().map(|c| c + softer).collect();
        Some(Box::new(move |x: &[f64], y: &mut [f64]| {
            for ((y, x), c) in y.iter_mut().zip(x).zip(&all) {
                *y = x / c;
            }
        }))
    }
}

/// The inverse of what is arranged is that of its parts arranged alike, up to a factor.
#[test]
fn near_inverses_are_arranged_as_their_bodies_are() {
    let springs = |own: &[f64]| Arc::new(Springs(own.to_vec())) as Arc<dyn Compliance>;
    let (left, right) = (springs(&[1.0, 2.0, 4.0]), springs(&[3.0, 5.0]));
    let both = || Arc::new(Separate(vec![left.clone(), right.clone()]));
    let twin = Reflected::new(left.clone(), vec![2, 0, 1]).expect("a permutation");
    let whole = springs(&[1.0, 2.0, 2.0, 1.0, 7.0]);
    let half = SymmetricHalf::new(whole, &[3, 2, 1, 0, 4]).expect("an involution");
    let pair = Relative::new(Some(both()), Some(both())).expect("as many points");
    let layered = pair.clone().with_layer(vec![0.5; 5]).expect("flexible");
    let alone = Relative::new(None, Some(both())).expect("one body");
    let bodies: [&dyn Compliance; 6] = [&*both(), &twin, &half, &pair, &layered, &alone];
    for (k, body) in bodies.into_iter().enumerate() {
        for softer in [0.0, 0.3] {
            let n = body.points();
            let pressure: Vec<f64> = (0..n).map(|i| 1.0 + (1.7 * i as f64).sin()).collect();
            let mut moved: Vec<f64> = pressure.iter().map(|p| softer * p).collect();
            body.add_displacement(
                Component::Normal,
                Component::Normal,
                1.0,
                &pressure,
                &mut moved,
            );
            let mut found = vec![0.0; n];
            body.near_inverse(softer).expect("known")(&moved, &mut found);
            let factor = found[0] / pressure[0];
            for (f, p) in found.iter().zip(&pressure) {
                assert!(
                    (f - factor * p).abs() < 1e-14 * factor,
                    "{k}: {found:?} {pressure:?}"
                );
            }
        }
    }
    let unknown = Separate(vec![left, Arc::new(Arbitrary(2))]);
    assert!(unknown.near_inverse(0.0).is_none());
}
