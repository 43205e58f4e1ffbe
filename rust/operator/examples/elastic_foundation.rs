// SPDX-License-Identifier: MIT OR Apache-2.0
//! A compliance of one's own: an elastic foundation, added to a known one, as a matrix and as a map.

use mtb_operator::{Compliance, Component, Sum};

/// Independent springs: each point gives way to its own traction only (a Winkler foundation).
struct Foundation {
    points: usize,
    /// Indentation by a unit pressure [m/Pa].
    normal: f64,
    /// Shear displacement by a unit traction [m/Pa].
    tangential: f64,
}

impl Compliance for Foundation {
    fn points(&self) -> usize {
        self.points
    }

    fn add_displacement(
        &self,
        observed: Component,
        loaded: Component,
        scale: f64,
        traction: &[f64],
        displacement: &mut [f64],
    ) {
        let spring = match (observed, loaded) {
            (Component::Normal, Component::Normal) => self.normal,
            (a, b) if a == b => self.tangential,
            _ => 0.0,
        };
        for (u, q) in displacement.iter_mut().zip(traction) {
            *u += scale * spring * q;
        }
    }
}

fn main() {
    let rubber = Foundation {
        points: 4,
        normal: 2e-9,
        tangential: 5e-9,
    };
    let cork = Foundation {
        normal: 1e-9,
        ..rubber
    };
    // both layers under the same pressure: their indentations add
    let both = Sum(vec![&rubber, &cork]);
    let pressure = [1e6, 2e6, 2e6, 1e6];
    let mut indentation = [0.0; 4];
    both.add_displacement(
        Component::Normal,
        Component::Normal,
        1.0,
        &pressure,
        &mut indentation,
    );
    println!("indentation {indentation:?} m");

    // the same as a matrix, made by the trait
    let mut matrix = [0.0; 16];
    both.add_influence(Component::Normal, Component::Normal, 1.0, &mut matrix);
    println!("influence of a point on itself {:e} m/Pa", matrix[0]);
    assert!((indentation[1] - matrix[5] * pressure[1]).abs() < 1e-15);
}
