// SPDX-License-Identifier: MIT OR Apache-2.0
use mtb_operator::Component::{self, Normal, X, Y};

use super::*;

const SOFT: Material = Material {
    shear_modulus: 1e9,
    poisson_ratio: 0.4,
};
const STEEL: Material = Material {
    shear_modulus: 80e9,
    poisson_ratio: 0.28,
};
const COMPONENTS: [Component; 3] = [X, Y, Normal];

fn layered(layer: Material, thickness: f64, base: Option<Material>, bond: Bond) -> Layered {
    Layered::new(layer, thickness, base, bond).expect("valid")
}

/// Offsets in cells, on the grid and between.
const PLACES: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [-2.0, 3.0],
    [0.3, -1.2],
    [0.0, 40.0],
    [-500.0, 311.0],
];

/// Largest difference of all components of a body from those of a half-space, over the value at the load.
fn apart(body: &Layered, material: &Material, cell: [f64; 2]) -> f64 {
    let size = influence(material, Normal, Normal, [0.0; 2], cell);
    let mut most: f64 = 0.0;
    for [i, j] in PLACES {
        let offset = [i * cell[0], j * cell[1]];
        for a in COMPONENTS {
            for b in COMPONENTS {
                let own = influence(material, a, b, offset, cell);
                most = most.max((body.influence(a, b, offset, cell) - own).abs() / size);
            }
        }
    }
    most
}

#[test]
fn a_layer_on_its_own_material_is_the_half_space() {
    for material in [SOFT, STEEL] {
        for thickness in [1e-7, 3e-5, 1e-3, 0.4] {
            let body = layered(material, thickness, Some(material), Bond::Bonded);
            let apart = apart(&body, &material, [1e-3, 0.7e-3]);
            assert!(apart < 1e-12, "{thickness}: {apart}");
        }
    }
}

#[test]
fn a_thick_layer_is_its_half_space_in_first_order() {
    let of = |thickness: f64, base| {
        apart(
            &layered(SOFT, thickness, base, Bond::Bonded),
            &SOFT,
            [1e-3, 2e-3],
        )
    };
    for base in [Some(STEEL), None] {
        let (near, far) = (of(1e3, base), of(1e7, base));
        assert!(far < 1e-8, "{far}");
        assert!((near / far / 1e4 - 1.0).abs() < 1e-2, "{near} {far}");
    }
}

#[test]
fn a_thin_layer_is_the_half_space_of_its_base_in_first_order() {
    let of = |thickness: f64, layer, base| {
        let body = layered(layer, thickness, Some(base), Bond::Bonded);
        apart(&body, &base, [1e-3, 2e-3])
    };
    for (layer, base) in [(SOFT, STEEL), (STEEL, SOFT)] {
        let (one, two) = (of(1e-10, layer, base), of(1e-14, layer, base));
        assert!(two < 1e-8, "{two}");
        assert!((one / two / 1e4 - 1.0).abs() < 1e-2, "{one} {two}");
    }
}

#[test]
fn shear_across_the_waves_is_a_row_of_images() {
    // the image of a load at the depth 2 m h has the strength R^m, R = (G1 - G2) / (G1 + G2)
    let (h, g) = (0.7, SOFT.shear_modulus);
    let half = [
        Material {
            poisson_ratio: 0.0,
            ..SOFT
        },
        Material {
            shear_modulus: 3e9,
            poisson_ratio: 0.1,
        },
    ];
    for base in [Some(half[1]), None] {
        let share = base.map_or(-1.0, |b| (g - b.shear_modulus) / (g + b.shear_modulus));
        let body = layered(half[0], h, base, Bond::Bonded);
        for r in [1e-4_f64, 0.03, 0.9, 3.0, 7.9, 8.1, 60.0] {
            // the flux of 1 / sqrt(r^2 + d^2) through a circle, over its radius
            let flux = |depth: f64| r / (r.hypot(depth) + depth);
            let mut sum = 0.0;
            let (mut strength, mut last, mut before) = (2.0, 0.0, 0.0);
            for m in 1..=40_000 {
                strength *= share;
                before = last;
                last = strength * flux(2.0 * f64::from(m));
                sum += last;
                if base.is_some() && last.abs() < 1e-18 {
                    break;
                }
            }
            if base.is_none() {
                // the mean of the means of the last partial sums
                sum -= 0.75 * last + 0.25 * before;
            }
            let value = body.radial(Radial::Across, r);
            assert!((value - sum).abs() < 1e-12, "{r}: {value} {sum}");
        }
    }
}

#[test]
fn waves_on_a_rigid_base_are_the_closed_forms() {
    let h = 2e-3;
    for nu in [-0.3, 0.0, 0.3, 0.49, 0.5] {
        let layer = Material {
            poisson_ratio: nu,
            ..SOFT
        };
        let at = |q: f64, bond| {
            let normal = layered(layer, h, None, bond).waves(q / h).normal;
            normal * layer.shear_modulus * q / h / (1.0 - nu)
        };
        for q in [0.3, 1.0, 4.0, 11.0] {
            let kappa = 3.0 - 4.0 * nu;
            let sum = 0.5 * (kappa * kappa + 1.0) + 2.0 * q * q;
            let bonded =
                (kappa * f64::sinh(2.0 * q) - 2.0 * q) / (kappa * f64::cosh(2.0 * q) + sum);
            assert!(
                (at(q, Bond::Bonded) / bonded - 1.0).abs() < 1e-12,
                "{nu} {q}"
            );
            let free = (f64::cosh(2.0 * q) - 1.0) / (f64::sinh(2.0 * q) + 2.0 * q);
            assert!((at(q, Bond::Frictionless) / free - 1.0).abs() < 1e-12);
        }
        for bond in [Bond::Bonded, Bond::Frictionless] {
            let body = layered(layer, h, None, bond);
            let (limit, long) = (body.waves(0.0).normal, body.waves(1e-5 / h).normal);
            let size = h / layer.shear_modulus;
            assert!((limit - long).abs() < 1e-9 * size, "{nu} {bond:?}");
        }
    }
    // a layer that keeps its volume is squeezed out by long waves: h^3 k^2 / (3 G)
    let rubber = Material {
        poisson_ratio: 0.5,
        ..SOFT
    };
    for q in [1e-2, 1e-4, 1e-6] {
        let normal = layered(rubber, h, None, Bond::Bonded).waves(q / h).normal;
        let squeezed = h * q * q / (3.0 * rubber.shear_modulus);
        assert!((normal / squeezed - 1.0).abs() < 3.0 * q * q + 1e-9, "{q}");
    }
}

/// All cells of a plane under one pressure, or one shear, are one uniform layer.
#[test]
fn all_cells_together_are_the_uniform_layer() {
    let (h, cells) = (1e-3, 60);
    let nu = SOFT.poisson_ratio;
    for (cell, within) in [([1e-3, 1.3e-3], 1e-9), ([4e-3, 5e-3], 1e-9)] {
        let body = layered(SOFT, h, None, Bond::Bonded);
        let sum = |component| -> f64 {
            let mut sum = 0.0;
            for i in -cells..=cells {
                for j in -cells..=cells {
                    let offset = [f64::from(i) * cell[0], f64::from(j) * cell[1]];
                    sum += body.influence(component, component, offset, cell);
                }
            }
            sum
        };
        let unit = h / SOFT.shear_modulus;
        let pressed = unit * (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu));
        assert!(
            (sum(Normal) / pressed - 1.0).abs() < within,
            "{}",
            sum(Normal) / pressed
        );
        assert!((sum(X) / unit - 1.0).abs() < within, "{}", sum(X) / unit);
        assert!((sum(Y) / unit - 1.0).abs() < within, "{}", sum(Y) / unit);
    }
}

/// The rectangle is the sum of its parts, and mirrored and turned as it must be.
#[test]
fn rectangles_add_and_turn() {
    let body = layered(SOFT, 0.5e-3, Some(STEEL), Bond::Bonded);
    let cell = [2e-3, 0.5e-3];
    for [i, j] in PLACES {
        let offset = [i * 1e-3 + 1e-4, j * 1e-3 - 2e-4];
        for a in COMPONENTS {
            for b in COMPONENTS {
                let whole = body.remainder(a, b, offset, cell);
                let size = influence(&SOFT, Normal, Normal, [0.0; 2], cell);
                let mut parts = 0.0;
                for k in [-0.75, -0.25, 0.25, 0.75] {
                    let shifted = [offset[0] - k * 1e-3, offset[1]];
                    parts += body.remainder(a, b, shifted, [0.5e-3, cell[1]]);
                }
                assert!(
                    (whole - parts).abs() < 1e-12 * size,
                    "{a:?} {b:?} {offset:?}"
                );
                let swap = |c| match c {
                    X => Y,
                    Y => X,
                    Normal => Normal,
                };
                let turned =
                    body.remainder(swap(a), swap(b), [offset[1], offset[0]], [cell[1], cell[0]]);
                assert!((whole - turned).abs() < 1e-13 * size);
                let back = body.remainder(b, a, [-offset[0], -offset[1]], cell);
                assert!((whole - back).abs() < 1e-12 * size);
            }
        }
    }
}

#[test]
fn bad_layers_are_named() {
    for thickness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let body = Layered::new(SOFT, thickness, None, Bond::Bonded);
        assert!(matches!(body, Err(Error::Thickness(_))));
    }
    let loose = Material {
        poisson_ratio: 0.7,
        ..SOFT
    };
    let body = Layered::new(SOFT, 1.0, Some(loose), Bond::Bonded);
    assert!(matches!(body, Err(Error::Material { .. })));
}
