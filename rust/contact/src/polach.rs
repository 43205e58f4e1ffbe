// SPDX-License-Identifier: MIT OR Apache-2.0
//! Polach's closed-form creep forces. [Polach1999], [Polach2005]

use std::f64::consts::PI;

use crate::Error;
use crate::error::{check, check_number, check_positive};
use crate::kalker::CreepCoefficients;

/// An elliptic contact and its reduction factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolachContact {
    /// Semi-axis along the rolling direction [m].
    pub a: f64,
    /// Semi-axis across it [m].
    pub b: f64,
    /// Shear modulus of both bodies [Pa].
    pub shear_modulus: f64,
    /// Normal force [N].
    pub normal_force: f64,
    /// Kalker's coefficients of the ellipse.
    pub coefficients: CreepCoefficients,
    /// Reduction of the stiffness where the surfaces stick, 1 for clean ones.
    pub reduction_adhesion: f64,
    /// Reduction of the stiffness where they slip, at most `reduction_adhesion`.
    pub reduction_slip: f64,
}

/// Forces (x, y) [N] on the lower body for the creepage `(xi, eta, phi)`, `phi` in [1/m], at the
/// coefficient of friction `friction`.
///
/// The traction is `2 mu Q / pi (k_A e / (1 + (k_A e)^2) + atan(k_S e))`, with `e` the gradient of the
/// traction in the part that sticks; the lateral force by spin is a fit to FASTSIM. There is no moment.
///
/// # Errors
/// [`Error::NotFinite`] or [`Error::Number`] for bad input.
pub fn creep_force(
    contact: &PolachContact,
    creepage: [f64; 3],
    friction: f64,
) -> Result<[f64; 2], Error> {
    let PolachContact { a, b, .. } = *contact;
    check("creepage", &creepage, 3)?;
    check_positive("a", a)?;
    check_positive("b", b)?;
    check_positive("shear modulus", contact.shear_modulus)?;
    check_positive("normal force", contact.normal_force)?;
    check_number(
        "friction coefficient",
        friction,
        friction >= 0.0,
        "it must not be negative",
    )?;
    check_positive("reduction in adhesion", contact.reduction_adhesion)?;
    check_positive("reduction in slip", contact.reduction_slip)?;
    let [xi, eta, phi] = creepage;
    let limit = friction * contact.normal_force;
    let with_spin = eta + phi * a;
    let lateral = if with_spin.abs() > eta.abs() {
        with_spin
    } else {
        eta
    };
    let size = xi.hypot(lateral);
    if size == 0.0 || limit == 0.0 {
        return Ok([0.0; 2]);
    }
    let c = &contact.coefficients;
    let pure = xi.hypot(eta);
    let stiffness = if pure > 0.0 {
        (c.c11 * xi / pure).hypot(c.c22 * eta / pure)
    } else {
        c.c22
    };
    let gradient = 0.25 * PI * contact.shear_modulus * a * b * stiffness * size / limit;
    let adhesion = contact.reduction_adhesion * gradient;
    let total = 2.0 * limit / PI
        * (adhesion / (1.0 + adhesion * adhesion) + (contact.reduction_slip * gradient).atan());
    // the part of spin
    let elongation = 1.0 + 6.3 * (1.0 - (-a / b).exp());
    let gradient_spin = 8.0 / 3.0 * contact.shear_modulus * b * (a * b).sqrt() * c.c23 / limit
        * lateral.abs()
        / elongation
        * contact.reduction_adhesion;
    let delta = (gradient_spin * gradient_spin - 1.0) / (gradient_spin * gradient_spin + 1.0);
    let moment = gradient_spin * (delta.powi(3) / 3.0 - 0.5 * delta * delta + 1.0 / 6.0)
        - (1.0 - delta * delta).powi(3).sqrt() / 3.0;
    let by_spin = -9.0 / 16.0 * a * limit * moment * elongation * phi / size;
    let mut force = [total * xi / size, total * eta / size + by_spin];
    // friction carries no more than its bound
    let magnitude = force[0].hypot(force[1]);
    if magnitude > limit {
        force = force.map(|f| f * limit / magnitude);
    }
    Ok(force)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kalker::creep_coefficients;

    fn contact() -> PolachContact {
        PolachContact {
            a: 6e-3,
            b: 4e-3,
            shear_modulus: 80e9,
            normal_force: 80e3,
            coefficients: creep_coefficients(1.5, 0.3).unwrap(),
            reduction_adhesion: 1.0,
            reduction_slip: 1.0,
        }
    }

    #[test]
    fn small_creepages_give_the_linear_theory() {
        let k = contact();
        let c = k.coefficients;
        let scale = k.shear_modulus * k.a * k.b;
        let e = 1e-8;
        let fx = creep_force(&k, [e, 0.0, 0.0], 0.3).unwrap()[0];
        let fy = creep_force(&k, [0.0, e, 0.0], 0.3).unwrap()[1];
        let fs = creep_force(&k, [0.0, 0.0, e / k.a], 0.3).unwrap()[1];
        assert!((fx / (scale * c.c11 * e) - 1.0).abs() < 1e-4);
        assert!((fy / (scale * c.c22 * e) - 1.0).abs() < 1e-4);
        let spin = scale * (k.a * k.b).sqrt() * c.c23 * e / k.a;
        assert!((fs / spin - 1.0).abs() < 1e-3, "{}", fs / spin);
    }

    #[test]
    fn no_friction_gives_no_force() {
        assert_eq!(
            creep_force(&contact(), [1e-3, 1e-3, 0.1], 0.0).unwrap(),
            [0.0; 2]
        );
    }

    #[test]
    fn large_creepages_saturate() {
        let f = creep_force(&contact(), [0.3, 0.4, 0.0], 0.3).unwrap();
        assert!((f[0].hypot(f[1]) / (0.3 * 80e3) - 1.0).abs() < 1e-3);
        assert!((f[1] / f[0] - 4.0 / 3.0).abs() < 1e-12);
    }
}
